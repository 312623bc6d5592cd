//! The results of P4: surfaces A and B of its table 1, which come with the program, milled with its cone and its
//! cylinder.

mod deviations;
mod swarm;
mod sweep;
mod table_2;

use std::time::Instant;

use super::{Outcome, Paper, ReproduceError, Table, Verdict};
use crate::widgets::camera::PICTURE_SIZE;
use crate::workspaces::flank::document::DemonstrationSurface;
use crate::workspaces::flank::scene::{FlankScene, FlankSurface, contact_line};
use crate::workspaces::mold::scene::pictures::{MoldPicture, draw};
use files::report::number;
use files::report::plot::{Plot, Series};
use flank::FlankError;
use flank::compensation::{Measured, Model, best_rank};
use flank::cutter::FlankCutter;
use flank::deviation::DesignGrid;
use flank::offset::{Touch, two_point};
use flank::params::{FlankParams, OffsetMethod, SumOver};
use flank::path::FlankPath;
use flank::plan::{FlankPlan, plan_flank};
use flank::ruled_surface::{RuledSurface, Side};
use glam::DVec3;
use render::camera::Camera;
use render::colour::Theme;
use render::offscreen::RenderError;
use task::Task;

/// Control points (mm) of the lower and the upper boundary of surfaces A and B, table 1. One coordinate is printed as
/// `13.857 3`; the same curve of surface B has 13.857.
const TABLE_1: [[[[f64; 3]; 4]; 2]; 2] = [
    [
        [[70.0, 2.0, -10.0], [81.545, 6.0, -10.0], [92.157, 0.0, -10.0], [109.3, 4.0, -10.0]],
        [[73.445, 13.857, 0.0], [81.443, 4.621, 0.0], [92.634, 2.779, 0.0], [105.48, -9.257, 0.0]],
    ],
    [
        [[79.125, 2.0, -10.0], [84.898, 6.0, -10.0], [90.204, 0.0, -10.0], [98.775, 4.0, -10.0]],
        [[73.445, 13.857, 0.0], [81.443, 4.621, 0.0], [92.634, 2.779, 0.0], [105.48, -9.257, 0.0]],
    ],
];
/// Both surfaces.
const SURFACES: [DemonstrationSurface; 2] = [DemonstrationSurface::A, DemonstrationSurface::B];
/// The cone of figures 6 and 7: bottom radius (mm) and angle (deg).
const CONE: [f64; 2] = [1.0, 5.0];
/// The cylinder of table 2 and figure 5: radius (mm) and angle (deg).
const CYLINDER: [f64; 2] = [2.0, 0.0];
/// Length of our flutes (mm); the paper gives none.
const FLUTES_MM: f64 = 30.0;
/// Size of a plot (CSS pixels).
const PLOT: [f64; 2] = [560.0, 240.0];

/// The tables and figures of the paper.
pub(super) fn results(task: &Task) -> Result<Vec<Outcome>, ReproduceError> {
    let cones = planned("Figure 6", CONE, task)?;
    let cylinders = planned("Table 2", CYLINDER, task)?;
    let mut outcomes =
        vec![table_1()?, table_2::table_2(&cylinders, task)?, figure_1(&cones[0], task)?, figure_2(&cones)];
    outcomes.extend([figure_3(&cones, task)?, figure_4(&cones, task)?, deviations::figure_5(&cylinders)]);
    outcomes.extend(deviations::figures_6_and_7(&cones, task)?);
    outcomes.extend([deviations::equation_12(task)?, sweep::sweep(task)?]);
    Ok(outcomes)
}

/// A surface with a plan.
struct Case {
    which: DemonstrationSurface,
    surface: RuledSurface,
    plan: FlankPlan,
    /// Duration of the plan (s), and of one that ends with the chosen path.
    seconds: [f64; 2],
}

/// How far above the lower guide the flutes end on a path, where they do not reach it (mm).
fn above_guide(path: &FlankPath) -> f64 {
    (-path.coverage.height_range_mm[0]).max(0.0)
}

/// The parameters of the paper: 50 locations, 10 control points, the bottom of the cutter at the lower guide.
fn params() -> FlankParams {
    FlankParams { below_mm: 0.0, ..FlankParams::default() }
}

fn cutter([radius_mm, taper_deg]: [f64; 2]) -> FlankCutter {
    FlankCutter::cone(radius_mm, taper_deg, FLUTES_MM)
}

/// The problem of a result.
fn failed(name: &'static str, problem: impl ToString) -> ReproduceError {
    ReproduceError::Result { paper: Paper::P4, name, problem: problem.to_string() }
}

/// The error of a result.
fn flank_error(name: &'static str) -> impl Fn(FlankError) -> ReproduceError {
    move |error| match error {
        FlankError::Cancelled(cancelled) => cancelled.into(),
        error => failed(name, error),
    }
}

fn surface(which: DemonstrationSurface, name: &'static str) -> Result<RuledSurface, ReproduceError> {
    let guides = which.guides().map_err(|problem| failed(name, problem))?;
    RuledSurface::from_guides(&guides.lower, &guides.upper, Side::Positive).map_err(flank_error(name))
}

/// Both surfaces, milled with a cutter.
fn planned(name: &'static str, of_cutter: [f64; 2], task: &Task) -> Result<Vec<Case>, ReproduceError> {
    let one = |which: DemonstrationSurface| {
        let surface = surface(which, name)?;
        let timed = |rounds: usize| -> Result<(FlankPlan, f64), ReproduceError> {
            let (params, start) = (FlankParams { rounds, ..params() }, Instant::now());
            let plan = plan_flank(&surface, &cutter(of_cutter), &params, task).map_err(flank_error(name))?;
            Ok((plan, start.elapsed().as_secs_f64()))
        };
        let ((_, short), (plan, whole)) = (timed(0)?, timed(params().rounds)?);
        Ok(Case { which, surface, plan, seconds: [whole, short] })
    };
    SURFACES.into_iter().map(one).collect()
}

/// How to plan a case by hand.
fn by_hand(of_cutter: [f64; 2], more: &str, place: &str) -> String {
    let [radius, taper] = of_cutter;
    format!(
        "sparkpath flank --demo a --radius {radius} --taper-deg {taper} --below 0{more} (and --demo b). Window: \
         workspace Flank, Surface {{A, B}}, Cutter {{Radius {radius}, Taper {taper}}}, Path {{Extend below 0}}, F8; \
         {place}."
    )
}

fn part(of_cutter: [f64; 2]) -> String {
    let [radius, taper] = of_cutter;
    let cutter =
        if taper == 0.0 { format!("cylinder R{radius} mm") } else { format!("cone r0 {radius} mm, {taper}°") };
    format!("surfaces A and B of the paper, its {cutter}, 50 locations, 10 control points; 100 x 50 samples (u, v)")
}

fn strings<const N: usize>(cells: [&str; N]) -> Vec<String> {
    cells.map(str::to_owned).to_vec()
}

fn line(points: Vec<[f64; 2]>, class: &'static str) -> Series {
    Series { points, class, dots: false }
}

/// Control points of the surfaces.
fn table_1() -> Result<Outcome, ReproduceError> {
    let mut rows = Vec::new();
    let mut greatest = 0.0f64;
    for (which, printed) in SURFACES.into_iter().zip(TABLE_1) {
        let surface = surface(which, "Table 1")?;
        for (name, guide, printed) in [("lower", surface.lower(), printed[0]), ("upper", surface.upper(), printed[1])] {
            let printed = printed.map(DVec3::from_array);
            let off = (0..=10).map(|i| f64::from(i) / 10.0).map(|u| guide.point(u).distance(bezier(printed, u)));
            let off = off.fold(0.0, f64::max);
            greatest = greatest.max(off);
            let text = printed.map(|p| format!("({}, {}, {})", number(p.x, 3), number(p.y, 3), number(p.z, 3)));
            rows.push(vec![which.name().to_owned(), name.to_owned(), text.join(" "), number(off, 9)]);
        }
    }
    Ok(Outcome {
        name: "Table 1".to_owned(),
        title: "control points of the surfaces' boundaries".to_owned(),
        part: "surfaces A and B, which come with the program".to_owned(),
        verdict: if greatest < 1e-9 { Verdict::Same } else { Verdict::Worse },
        why: "our guides are the paper's Bezier curves; its surface A has a stray digit in one coordinate (13.857 3), \
              which is read as in surface B"
            .to_owned(),
        by_hand: "sparkpath flank --demo a, sparkpath flank --demo b. Window: workspace Flank, Surface {From \
                  demonstration, Surface A or B}."
            .to_owned(),
        tables: vec![Table {
            caption: "Control points of the paper (mm), and how far our guide is from their curve at most (mm)"
                .to_owned(),
            head: strings(["surface", "guide", "control points", "#off"]),
            rows,
        }],
        plots: Vec::new(),
        pictures: Vec::new(),
        files: Vec::new(),
    })
}

/// A point of a cubic Bezier curve, by de Casteljau.
fn bezier(mut points: [DVec3; 4], u: f64) -> DVec3 {
    for degree in (1..4).rev() {
        (0..degree).for_each(|i| points[i] = points[i].lerp(points[i + 1], u));
    }
    points[0]
}

/// An outcome for a drawing without figures, in whose place ours are shown.
fn drawing(name: &str, title: &str, why: &str, by_hand: String) -> Outcome {
    Outcome {
        name: name.to_owned(),
        title: title.to_owned(),
        part: part(CONE),
        verdict: Verdict::NotComparable,
        why: why.to_owned(),
        by_hand,
        tables: Vec::new(),
        plots: Vec::new(),
        pictures: Vec::new(),
        files: Vec::new(),
    }
}

/// Deviation along the axis at one location.
fn figure_1(case: &Case, task: &Task) -> Result<Outcome, ReproduceError> {
    let params = FlankParams { offset: OffsetMethod::TwoPoint, rounds: 0, ..params() };
    let two = plan_flank(&case.surface, &cutter(CONE), &params, task).map_err(flank_error("Figure 1"))?;
    let curve = |plan: &FlankPlan| contact_line(&plan.initial, 0.5).into_iter().map(|[_, v, d]| [v, 1e3 * d]).collect();
    let plot = Plot {
        title: "Surface A, halfway: deviation (µm) up the ruling; blue three-point, brown two-point".to_owned(),
        x_label: "v".to_owned(),
        size: PLOT,
        series: vec![line(curve(&two), "c1"), line(curve(&case.plan), "c0")],
        levels: vec![(0.0, "touches".to_owned())],
        ..Plot::default()
    };
    let why = "it defines the deviation of one location and has no figures; ours shows that deviation: zero at both \
               guides with two points, and in the middle too with three";
    let place = "tab Deviation, plot on the right; Path {Offset two-point} for the other curve";
    let plots = vec![plot.svg()];
    Ok(Outcome { plots, ..drawing("Figure 1", "deviation between cutter and surface", why, by_hand(CONE, "", place)) })
}

/// Search for the third point.
fn figure_2(cases: &[Case]) -> Outcome {
    let row = |case: &Case| {
        let (locations, micro) = (&case.plan.locations, |mm: f64| number(1e3 * mm, 4));
        let greatest =
            |of: &mut dyn Iterator<Item = Option<f64>>| of.flatten().fold(0.0, |most: f64, m| most.max(m.abs()));
        let two = |u0: f64| two_point(&case.surface, &case.plan.cutter, u0, u0).ok().and_then(|l| l.middle_mm);
        let slides = locations.iter().map(|l| l.u1 - l.u0);
        let [low, high] = slides.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], s| [a.min(s), b.max(s)]);
        vec![
            case.which.name().to_owned(),
            locations.len().to_string(),
            locations.iter().filter(|l| l.touch == Touch::ThreePoints).count().to_string(),
            micro(greatest(&mut locations.iter().map(|l| two(l.u0)))),
            micro(greatest(&mut locations.iter().map(|l| l.middle_mm))),
            format!("{} to {}", number(low, 4), number(high, 4)),
        ]
    };
    let why = "it is a flow chart without figures. Ours follows it, with two changes: the change of sign is looked \
               for outwards from u0 instead of in a range that must be given, and the root is found by false position \
               (Illinois) instead of bisection";
    let title = "search for the third contact";
    Outcome {
        tables: vec![Table {
            caption: "Deviation in the middle before and after the slide along the upper guide".to_owned(),
            head: strings([
                "surface",
                "#locations",
                "#touch at three points",
                "#two-point, µm",
                "#three-point, µm",
                "#slide u1 - u0",
            ]),
            rows: cases.iter().map(row).collect(),
        }],
        ..drawing(
            "Figure 2",
            title,
            why,
            by_hand(CONE, " --out DIR", "Export…; report.html in DIR says how many locations touch as asked"),
        )
    }
}

/// Compensation by each row of the matrix.
fn figure_3(cases: &[Case], task: &Task) -> Result<Outcome, ReproduceError> {
    let mut rows = Vec::new();
    for case in cases {
        let grid = DesignGrid::new(&case.surface, params().grid);
        let start = Measured::new(&grid, case.plan.initial.axis.clone(), &case.plan.cutter, None);
        let start = start.map_err(flank_error("Figure 3"))?;
        for (words, model) in [
            ("shift along the normal (the paper's)", Model::Shift),
            ("and height along a cone (the program's)", Model::Height),
            ("and another place of the axis (exact derivative)", Model::Moving),
        ] {
            let best =
                best_rank((&case.surface, &grid), &start, &case.plan.cutter, (model, SumOver::Surface), &task.cancel);
            let (path, ranks) = best.map_err(flank_error("Figure 3"))?;
            let [sum, ratio] = [path.deviation.sum, path.deviation.sum / start.deviation.sum].map(|x| number(x, 3));
            rows.push(vec![case.which.name().to_owned(), words.to_owned(), ranks.best.to_string(), sum, ratio]);
        }
    }
    let why = "it is a sketch without figures. The sign of the paper's equation 11 is turned: a shift by the \
               deviation against the normal removes it, and the change is plus the shift times the normal. For a cone \
               the height of each place changes too, which the paper's row leaves out";
    let place = "Path, Fine points {Matrix row shift, and height, exact}; tab Ranks";
    Ok(Outcome {
        tables: vec![Table {
            caption:
                "One compensation by the best rank, with three models of how the control points change the deviation"
                    .to_owned(),
            head: strings(["surface", "row of the matrix", "#best rank", "#sum mm", "#ratio to initial"]),
            rows,
        }],
        ..drawing("Figure 3", "compensation of the deviation", why, by_hand(CONE, " --set plan.row=shift", place))
    })
}

/// Pictures of the surfaces.
fn figure_4(cases: &[Case], task: &Task) -> Result<Outcome, ReproduceError> {
    let picture = |case: &Case| {
        let surface = FlankSurface::bare(&case.surface);
        let scene = FlankScene {
            surface: Some(&surface),
            shapes: None,
            paths: &[],
            moving: false,
            poses: &[],
            contacts: &[],
            tips: &[],
            shows_axis: false,
            shows_rulings: true,
            part: None,
            walls: None,
            place: None,
            open_side: None,
            theme: Theme::LIGHT,
        }
        .build();
        let aspect = f64::from(PICTURE_SIZE[0]) / f64::from(PICTURE_SIZE[1]);
        let camera = surface.camera(&surface.shape.bounds(), Camera::default(), aspect, false);
        let caption = "Seen from the cutter's side, the upper guide above, with rulings.".to_owned();
        MoldPicture { title: case.which.name().to_owned(), caption, legend: Vec::new(), scene, camera }
    };
    let (pictures, without) = match draw(cases.iter().map(picture).collect(), task) {
        Ok(pictures) => (pictures, String::new()),
        Err(RenderError::Cancelled(cancelled)) => return Err(cancelled.into()),
        Err(error) => (Vec::new(), format!("; no picture can be drawn here: {error}")),
    };
    Ok(Outcome {
        verdict: Verdict::Same,
        part: "surfaces A and B, which come with the program".to_owned(),
        pictures,
        ..drawing(
            "Figure 4",
            "the surfaces",
            &format!("the same control points, see table 1{without}"),
            "sparkpath flank --demo a --save a.sparkpath, then sparkpath render a.sparkpath --png a.png. Window: \
             workspace Flank, Surface {A, B}."
                .to_owned(),
        )
    })
}
