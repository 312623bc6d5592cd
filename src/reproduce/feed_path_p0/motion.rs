//! Figures 6 and 7 of P0: how the electrode leaves the channel, and how smoothly.

use std::sync::Arc;

use glam::DVec3;

use super::pictures::{Studio, View, picture};
use super::{BY_GENETIC, Case, SHEET, SHEET_ASPECT, Subject, around, failed, key};
use crate::reproduce::{Outcome, ReproduceError, Table, Verdict};
use crate::widgets::camera::{bodies, electrode_in_channel};
use crate::workspaces::blisk::job::figures::centroid_way;
use crate::workspaces::blisk::report::Smoothness;
use crate::workspaces::blisk::report::comparison::{AxisCourse, courses};
use crate::workspaces::blisk::scene::track::{Station, Track};
use crate::workspaces::blisk::scene::{Layer, Layers, SceneInputs, build, from_w, layer_id};
use feed::pose::Axis;
use feed::smoothness::AxisSmoothness;
use files::report::number;
use files::report::plot::{Plot, Series};
use render::colour::Theme;
use render::mesh::RenderMesh;
use render::scene::{LineSet, Scene};
use task::Task;

/// The axes whose smoothness the paper compares.
const COMPARED: [Axis; 3] = [Axis::Y, Axis::Z, Axis::C];

/// What the electrode's motion is drawn from.
struct Stage<'a> {
    subject: &'a Subject,
    case: &'a Case,
    track: Track,
    shape: Arc<RenderMesh>,
    layers: Layers,
}

impl<'a> Stage<'a> {
    fn new(subject: &'a Subject, case: &'a Case) -> Self {
        let mut layers = Layers::default();
        layers.into_channel();
        for layer in [Layer::Grid, Layer::Contact, Layer::Paths] {
            layers.get_mut(layer).visible = false;
        }
        let shape = Arc::new(RenderMesh::for_pictures(&case.found.electrode.mesh));
        Self { subject, case, track: Track::of_plan(case.plan()), shape, layers }
    }

    /// The electrode retracted by `s` (mm), in the blisk without its shroud.
    fn scene(&self, s: f64) -> Scene {
        build(&SceneInputs {
            blisk: None,
            channel: Some((&self.subject.channel.channel, &self.subject.channel.shapes)),
            electrode: Some((&self.case.found.electrode, &self.shape)),
            track: Some(&self.track),
            machine: &[],
            pose: None,
            s,
            ghosts: &[],
            swept: None,
            contact: None,
            trouble: None,
            values: None,
            residual_stock: None,
            layers: &self.layers,
            selected: None,
            section: None,
            theme: Theme::LIGHT,
            triad: true,
        })
    }

    /// Views of the electrode retracted by each of `way`, all from one place.
    fn views(&self, way: &[f64]) -> Vec<View> {
        let scenes: Vec<Scene> = way.iter().map(|s| self.scene(*s)).collect();
        let electrodes = scenes.iter().flat_map(|scene| &scene.objects);
        let objects = electrodes.filter(|o| o.id == layer_id(Layer::Electrode)).cloned().collect();
        let around = bodies(&Scene { objects, ..Scene::default() });
        let (channel, side) = (&self.subject.channel.channel, self.case.found.electrode.enters_from);
        let camera = electrode_in_channel(channel, side, &around, SHEET_ASPECT);
        scenes.into_iter().map(|scene| (scene, camera)).collect()
    }
}

/// `count` distances from the final pose to `length` (mm).
fn spread(length: f64, count: usize) -> Vec<f64> {
    (0..count).map(|i| length * i as f64 / (count - 1).max(1) as f64).collect()
}

/// Figure 6: the electrode leaves the channel.
pub(super) fn exit(subject: &Subject, studio: &mut Studio, task: &Task) -> Result<Outcome, ReproduceError> {
    const NAME: &str = "Figure 6";
    const FILE: &str = "p0_exit.png";
    const PICTURES: usize = 32;
    /// Size of the animation (pixels), with the aspect of the stills.
    const SIZE: [u32; 2] = [480, 315];
    let case = subject.genetic();
    let stage = Stage::new(subject, case);
    let stills = spread(stage.track.length(), 4);
    let sheet = studio.sheet(&stage.views(&stills), SHEET, task).map_err(|e| failed(task, NAME, &e))?;
    let views = stage.views(&spread(stage.track.length(), PICTURES));
    let animation = studio.animation(&views, SIZE, task).map_err(|e| failed(task, NAME, &e))?;
    let row = |(letter, station): (char, Station)| {
        let [x, y, z, _, _, c] = station.pose.to_array();
        let figures = [station.s, x, y, z, c.to_degrees(), station.clearance].map(|v| number(v, 3));
        std::iter::once(format!("({letter})")).chain(figures).collect::<Vec<_>>()
    };
    let stations = stills.iter().filter_map(|s| stage.track.at(*s));
    let rows = ('a'..='d').zip(stations).map(row).collect();
    let verdict = if case.plan().is_verified() { Verdict::Same } else { Verdict::Worse };
    let why = format!(
        "The paper's electrode leaves without interference in a simulation with ADAMS. Ours {}; the certified clearance holds \
         at every instant of the motion, not only at those of a simulation.",
        case.plan().verdict(&subject.channel.channel)
    );
    let head = ["picture", "#retracted mm", "#X mm", "#Y mm", "#Z mm", "#C °", "#clearance mm"];
    let caption = "From the upper left to the lower right: final pose, a third and two thirds of the way, outside.";
    let moving =
        format!("The same as an animation, {PICTURES} pictures; {FILE} beside this page is an animated PNG file.");
    Ok(Outcome {
        tables: vec![Table::new("Poses of the stills", &head, rows)],
        pictures: [
            picture("Exit of the electrode", caption.to_owned(), &[], sheet),
            picture("Exit of the electrode, animated", moving, &[], animation.clone()),
        ]
        .into_iter()
        .flatten()
        .collect(),
        files: animation.map(|animation| (FILE.to_owned(), animation)).into_iter().collect(),
        ..subject.outcome(
            NAME,
            "Exit of the electrode from the channel",
            verdict,
            why + &studio.note(),
            &format!("{BY_GENETIC}; the time line below the picture plays the motion"),
        )
    })
}

/// Length of the polyline through `points` (mm), and the sum of the angles at its corners (rad).
fn bends(points: impl Iterator<Item = DVec3>) -> [f64; 2] {
    let points: Vec<DVec3> = points.collect();
    let ways: Vec<DVec3> = points.windows(2).map(|w| w[1] - w[0]).filter(|way| way.length() > 0.0).collect();
    [ways.iter().map(|way| way.length()).sum(), ways.windows(2).map(|w| w[0].angle_between(w[1])).sum()]
}

/// Figure 7: the curves of the axes and of the electrode's centroid.
pub(super) fn smoothness(subject: &Subject, studio: &mut Studio, task: &Task) -> Result<Outcome, ReproduceError> {
    const NAME: &str = "Figure 7";
    let curves: Vec<Vec<AxisCourse>> = subject.cases.iter().map(|case| courses(case.plan())).collect();
    let ways: Vec<Vec<[f64; 4]>> = subject.cases.iter().map(|case| centroid_way(&case.found)).collect();
    let axis_plot = |axis: Axis| {
        let of = |(case, courses): (&Case, &Vec<AxisCourse>)| {
            let course = courses.iter().find(|c| c.axis == axis.letter())?;
            Some(Series { points: course.curve.clone(), class: case.class, dots: false })
        };
        let unit = if axis.is_rotary() { "°" } else { "mm" };
        let series = subject.cases.iter().zip(&curves).filter_map(of).collect();
        plot(format!("{}, {unit}", axis.letter()), "s, mm retracted", series)
    };
    let letters = ['X', 'Y', 'Z'];
    let centroid_plot = |[across, up]: [usize; 2]| {
        let of = |(case, way): (&Case, &Vec<[f64; 4]>)| Series {
            points: way.iter().map(|p| [p[across + 1], p[up + 1]]).collect(),
            class: case.class,
            dots: false,
        };
        let series = subject.cases.iter().zip(&ways).map(of).collect();
        plot(format!("Centroid: {}, mm", letters[up]), &format!("{}, mm", letters[across]), series)
    };
    let mut plots: Vec<String> = COMPARED.into_iter().map(|axis| axis_plot(axis).svg()).collect();
    plots.extend([[0, 1], [0, 2], [1, 2]].map(|plane| centroid_plot(plane).svg()));
    task.check()?;
    let verdict = verdict(subject.genetic(), subject.free_travel());
    let legend = key(&subject.cases);
    let caption = "In space, with the electrode in its final pose. The curves of the plots have the same colours.";
    let png = studio.sheet(&[centroid_view(subject, &ways)], [1120, 735], task).map_err(|e| failed(task, NAME, &e))?;
    let blisk = import::stl_bytes(&subject.part.mesh).map_err(|e| failed(task, NAME, &e))?;
    let files = vec![
        ("p0_blisk.stl".to_owned(), blisk),
        ("p0_axes.csv".to_owned(), axes_csv(&subject.cases, &curves).into_bytes()),
        ("p0_centroid.csv".to_owned(), centroid_csv(&subject.cases, &ways).into_bytes()),
    ];
    Ok(Outcome {
        tables: vec![axes_table(&subject.cases), whole_table(&subject.cases, &ways)],
        plots,
        pictures: picture("Way of the electrode's centroid", caption.to_owned(), &legend, png).into_iter().collect(),
        files,
        ..subject.outcome(
            NAME,
            "Smoothness of the axes and way of the centroid",
            verdict,
            why(subject.genetic(), subject.free_travel()) + &studio.note(),
            "sparkpath compare p0_blisk.stl --set electrode.circumferential_reduction_deg=[2,2] --set electrode.enter=+x --set \
             machine.axes=XYZC --set plan.weights.a3=0.9 --set plan.weights.b3=0.1 --strategies \
             genetic,free-travel,max-min-distance,global --out DIR writes the curves; sparkpath plan writes centroid_1.csv; in the window keep runs and set them side \
             by side in the plots, of which Centroid shows the way of the centroid. Figures of this page: p0_axes.csv, p0_centroid.csv",
        )
    })
}

fn plot(title: String, x_label: &str, series: Vec<Series>) -> Plot {
    Plot { title, x_label: x_label.to_owned(), size: [360.0, 240.0], series, ..Plot::default() }
}

/// Reversals, greatest second difference and root mean square of the second differences of `case` as shares of those of
/// `other`, for each compared axis.
fn against(case: &Case, other: &Case) -> Option<[[f64; 3]; 3]> {
    let [ours, theirs] = [case, other].map(|c| c.plan().path.as_ref().map(|p| p.smoothness));
    let (ours, theirs) = (ours?, theirs?);
    let figures = |s: AxisSmoothness| [s.sign_changes as f64, s.max_second_difference, s.rms_second_difference];
    Some(COMPARED.map(|axis| {
        let [a, b] = [ours, theirs].map(|smoothness| figures(smoothness[axis as usize]));
        [0, 1, 2].map(|i| if a[i] == b[i] { 1.0 } else { a[i] / b[i] })
    }))
}

/// Whether `genetic` is smoother than `other` by every figure of every compared axis, as the paper says.
fn verdict(genetic: &Case, other: &Case) -> Verdict {
    match against(genetic, other) {
        Some(axes) if axes.iter().flatten().all(|share| *share < 1.0) => Verdict::Same,
        _ => Verdict::Worse,
    }
}

fn why(genetic: &Case, other: &Case) -> String {
    let Some(axes) = against(genetic, other) else { return "One of the methods finds no path.".to_owned() };
    let shares = |i: usize| COMPARED.iter().zip(&axes).map(move |(a, s)| format!("{} {:.2}", a.letter(), s[i]));
    let [reversals, rms] = [0, 2].map(|i| shares(i).collect::<Vec<_>>().join(", "));
    format!(
        "The paper says that its feed curves have fewer sharp points than those of [11]; it prints curves and no figures. Of \
         the genetic path as shares of free travel: reversals (an axis turns back) {reversals}; root mean square of the second \
         differences {rms}. By total variation (the way of an axis) and by the way of the centroid free travel may be less, \
         while the genetic centroid's way turns less: see the tables. The weights are not printed: this holds with a3 = 0.9; \
         with 0.5 smoothness has next to no say, and the path may be rougher than free travel. The search of free travel \
         is ours, from its objective; \"global\" is our own search, not in the paper."
    )
}

/// Smoothness of each compared axis in every case.
fn axes_table(cases: &[Case]) -> Table {
    let rows = cases.iter().flat_map(|case| {
        let smoothness = case.plan().path.as_ref().map_or(Vec::new(), |p| Smoothness::of(&p.smoothness));
        let compared = smoothness.into_iter().filter(|s| COMPARED.iter().any(|axis| axis.letter() == s.axis));
        compared.map(move |s| {
            let figures = [(s.total_variation, 2), (s.rms_second_difference, 4), (s.max_second_difference, 4)];
            let axis = format!("{} {}", s.axis, s.unit);
            let figures = figures.map(|(value, decimals)| number(value, decimals));
            let reversals = s.sign_changes_first_difference.to_string();
            [case.name.to_owned(), axis].into_iter().chain(figures).chain([reversals]).collect::<Vec<_>>()
        })
    });
    let head = ["method", "axis", "#total variation", "#RMS 2nd difference", "#greatest 2nd difference", "#reversals"];
    let caption = "Smoothness over equal steps of 0.5 mm; the paper prints no figures";
    Table::new(caption, &head, rows.collect())
}

/// What every case comes to as a whole.
fn whole_table(cases: &[Case], ways: &[Vec<[f64; 4]>]) -> Table {
    let row = |(case, way): (&Case, &Vec<[f64; 4]>)| {
        let plan = case.plan();
        let [length, angle] = bends(way.iter().map(|[_, x, y, z]| DVec3::new(*x, *y, *z)));
        let sum = |value: fn(&feed::problem::Node) -> f64| plan.nodes.iter().map(value).sum::<f64>();
        let clearance = plan.path.as_ref().map_or(f64::NAN, |p| p.certificate.certified());
        let [smooth, centred] = [sum(|n| n.objective.smoothness), sum(|n| n.objective.centring)];
        vec![
            case.name.to_owned(),
            if plan.is_verified() { "yes" } else { "no" }.to_owned(),
            number(clearance, 4),
            plan.nodes.len().to_string(),
            number(smooth, 3),
            number(centred, 2),
            number(length, 2),
            number(angle.to_degrees(), 1),
            number(plan.search_seconds, 1),
        ]
    };
    let head = [
        "method",
        "certified",
        "#clearance mm",
        "#nodes",
        "#sum of Obj1",
        "#sum of Obj2",
        "#way of the centroid mm",
        "#turning of the centroid °",
        "#search s",
    ];
    Table::new("Paths", &head, cases.iter().zip(ways).map(row).collect())
}

/// The ways of the centroid beside the electrode in its final pose.
fn centroid_view(subject: &Subject, ways: &[Vec<[f64; 4]>]) -> View {
    let mut stage = Stage::new(subject, subject.genetic());
    stage.layers.get_mut(Layer::Electrode).opacity = 0.3;
    let mut scene = stage.scene(0.0);
    let (channel, side) = (&subject.channel.channel, subject.genetic().found.electrode.enters_from);
    let to_mesh = from_w(&channel.frame);
    let points = |way: &[[f64; 4]]| -> Vec<DVec3> {
        way.iter().map(|[_, x, y, z]| to_mesh.transform_point3(DVec3::new(*x, *y, *z))).collect()
    };
    let camera = electrode_in_channel(channel, side, &around(ways.iter().flat_map(|way| points(way))), SHEET_ASPECT);
    for (case, way) in subject.cases.iter().zip(ways).filter(|(_, way)| way.len() > 1) {
        let line = LineSet::new(vec![points(way)], case.colour);
        scene.lines.push(LineSet { on_top: true, width_px: 3.0, ..line });
    }
    (scene, camera)
}

fn axes_csv(cases: &[Case], curves: &[Vec<AxisCourse>]) -> String {
    let mut out = "strategy,axis,unit,s_mm,value\n".to_owned();
    for (case, courses) in cases.iter().zip(curves) {
        let name = case.name.replace(',', ";");
        for AxisCourse { axis, unit, curve, .. } in courses {
            out.extend(curve.iter().map(|[s, value]| format!("{name},{axis},{unit},{s:.6},{value:.6}\n")));
        }
    }
    out
}

fn centroid_csv(cases: &[Case], ways: &[Vec<[f64; 4]>]) -> String {
    let mut out = "strategy,s_mm,x_mm,y_mm,z_mm\n".to_owned();
    for (case, way) in cases.iter().zip(ways) {
        let name = case.name.replace(',', ";");
        out.extend(way.iter().map(|[s, x, y, z]| format!("{name},{s:.6},{x:.6},{y:.6},{z:.6}\n")));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_corner_turns_by_a_right_angle_and_a_straight_line_by_nothing() {
        let corner = [DVec3::ZERO, DVec3::X, DVec3::X, DVec3::new(1.0, 2.0, 0.0), DVec3::new(1.0, 5.0, 0.0)];
        let [length, angle] = bends(corner.into_iter());
        assert!((length - 6.0).abs() < 1e-12 && (angle - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        assert_eq!(bends(std::iter::empty()), [0.0; 2]);
    }

    #[test]
    fn distances_run_from_the_final_pose_to_the_end() {
        assert_eq!(spread(6.0, 4), [0.0, 2.0, 4.0, 6.0]);
    }
}
