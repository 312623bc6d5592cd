//! Figures 3 and 4 of P0: the constraint at the walls, and the distances of the electrode from them.

use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use super::pictures::{Studio, View, picture};
use super::{BY_GENETIC, Case, SHEET, SHEET_ASPECT, Subject, Table, around, failed};
use crate::reproduce::{Outcome, ReproduceError, Verdict};
use crate::widgets::theme::COPPER;
use crate::workspaces::blisk::job::figures::Histogram;
use feed::angle_test::{AngleParams, AngleTest};
use feed::objective::{WallSamples, WallSpread, Weights};
use feed::pose::Pose;
use feed::problem::Node;
use files::report::number;
use files::report::plot::{Plot, Series};
use geometry::inside::guarded_distance;
use geometry::mesh::normal_times_two_areas;
use render::camera::{Camera, Projection};
use render::colour::Theme;
use render::colour_map::{ColourMap, Legend};
use render::mesh::RenderMesh;
use render::scene::{Object, ObjectId, Scene, SurfaceValues};
use render::view::looking;
use task::Task;
use wheel::channel::Channel;
use wheel::electrode::{Electrode, ElectrodeFace};
use wheel::surface_finder::SurfaceFinder;

/// A place beside a wall of the channel, with its exact distance from the blisk (mm), negative inside.
struct Place {
    wall: usize,
    at: DVec3,
    distance: f64,
}

/// Wrong answers of the two tests: of the 90 degree test first, then of the comparison of alpha with theta.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Judged {
    /// Places on which the tests have an answer: free ones, and ones inside a blade.
    places: [usize; 2],
    /// Free places that are called interfering.
    alarms: [usize; 2],
    /// Places inside a blade that are called free.
    missed: [usize; 2],
}

impl Judged {
    fn of(test: &AngleTest, place: &Place) -> Self {
        let mut judged = Self::default();
        let Some(angles) = test.angles(place.at, &mut [0; 2])[place.wall] else { return judged };
        let is_inside = place.distance < 0.0;
        judged.places[usize::from(is_inside)] = 1;
        for (i, limit) in [FRAC_PI_2, angles.theta].into_iter().enumerate() {
            let interferes = angles.alpha >= limit;
            judged.alarms[i] = usize::from(interferes && !is_inside);
            judged.missed[i] = usize::from(!interferes && is_inside);
        }
        judged
    }

    fn and(self, other: Self) -> Self {
        let sum = |a: [usize; 2], b: [usize; 2]| [a[0] + b[0], a[1] + b[1]];
        Self {
            places: sum(self.places, other.places),
            alarms: sum(self.alarms, other.alarms),
            missed: sum(self.missed, other.missed),
        }
    }

    fn wrong(&self) -> [usize; 2] {
        [0, 1].map(|i| self.alarms[i] + self.missed[i])
    }
}

/// Figure 3: the comparison of alpha with theta against that with 90 degrees, on walls of ever fewer points.
pub(super) fn constraint(subject: &Subject, primitive: &[Electrode], task: &Task) -> Result<Outcome, ReproduceError> {
    const NAME: &str = "Figure 3";
    /// Places nearer to the surface than this are left out (mm).
    const TOO_NEAR: f64 = 0.03;
    /// How far poses are moved across the channel, either way, so that the electrode reaches into a blade (mm).
    const ASIDE: f64 = 0.6;
    /// Points of a wall along the passage and from hub to shroud, beside those of the job.
    const COARSE: [[usize; 2]; 2] = [[21, 9], [11, 5]];
    let Case { found, .. } = subject.genetic();
    let path = found.plan.nodes.iter().map(|node| node.pose).collect();
    let stands = primitive.iter().map(|electrode| (electrode, vec![Pose::FINAL]));
    let mut places = Vec::new();
    for (electrode, poses) in std::iter::once((&found.electrode, path)).chain(stands) {
        let samples = WallSamples::of(electrode, &subject.channel.channel, &task.cancel)?;
        let aside = |pose: Pose| [-ASIDE, 0.0, ASIDE].map(|y| Pose { y: pose.y + y, ..pose });
        for pose in poses.into_iter().flat_map(aside) {
            task.check()?;
            for (wall, all) in samples.placed(&pose, 0.0).into_iter().enumerate() {
                let place = |at: DVec3| Place { wall, at, distance: guarded_distance(&subject.channel.exact, at) };
                places.par_extend(all.into_par_iter().map(place).filter(|place| place.distance.abs() > TOO_NEAR));
            }
        }
    }
    let coarse = COARSE.map(|points| subject.channel_of(points, NAME, task));
    let mut grids = vec![subject.channel.channel.clone()];
    for channel in coarse {
        grids.push(Arc::new(channel?));
    }
    let judge = |channel: &Arc<Channel>| {
        let test = AngleTest::new(channel, 0.0, &AngleParams::default());
        let all = places.par_iter().map(|place| Judged::of(&test, place));
        (format!("{} x {}", channel.low.nu, channel.low.nv), all.reduce(Judged::default, Judged::and))
    };
    let judged: Vec<(String, Judged)> = grids.iter().map(judge).collect();
    let row = |(grid, of): &(String, Judged)| {
        let [free, inside] = of.places;
        let figures = [free, of.alarms[0], of.alarms[1], inside, of.missed[0], of.missed[1]];
        std::iter::once(grid.clone()).chain(figures.map(|n| n.to_string())).collect::<Vec<_>>()
    };
    let wrong: Vec<[usize; 2]> = judged.iter().map(|(_, of)| of.wrong()).collect();
    let [tangent, angles] = [0, 1].map(|i| wrong.iter().map(|of| of[i]).sum::<usize>());
    let shown = |i: usize| wrong.iter().map(|of| of[i].to_string()).collect::<Vec<_>>().join(", ");
    let answers = judged.iter().map(|(_, of)| of.places.iter().sum::<usize>());
    let (answered, unanswered): (Vec<_>, Vec<_>) =
        answers.map(|n| (n.to_string(), (places.len() - n).to_string())).unzip();
    let why = format!(
        "The paper says that the 90 degree test refuses free places beside a twisted wall, which the comparison of alpha with \
         theta lets pass. So it is here, but that comparison also lets more places within a blade pass, of which the paper \
         says nothing. On walls of ever fewer points the former misjudges {}, the latter {} of {} places in both ways together. Neither test has an \
         answer at the other {} of {} places, which lie beyond the ends of the walls. The paper does not say how many points \
         its walls have. Neither test proves a path; the certificate does.",
        shown(0),
        shown(1),
        answered.join(", "),
        unanswered.join(", "),
        places.len()
    );
    let caption = format!(
        "Samples on the walls of the net-shape electrode in its final pose and of the reduced one at every node of its path, \
         and {ASIDE} mm to either side; true distances are exact, those below {TOO_NEAR} mm are left out"
    );
    let head = [
        "points of a wall",
        "#free",
        "#refused, 90°",
        "#refused, alpha and theta",
        "#inside a blade",
        "#missed, 90°",
        "#missed, alpha and theta",
    ];
    Ok(Outcome {
        tables: vec![Table::new(&caption, &head, judged.iter().map(row).collect())],
        ..subject.outcome(
            NAME,
            "Constraint: alpha and theta at the nearest wall point",
            if angles < tangent { Verdict::Same } else { Verdict::Worse },
            why,
            "plan.constraint = angle, plan.angle.delta1_mm, plan.angle.delta2_deg, blisk.wall_points_chord, \
             blisk.wall_points_span; in the window the step Plan, Constraint",
        )
    })
}

/// An electrode in a pose, with the distances of its walls.
struct Position<'a> {
    name: String,
    electrode: &'a Electrode,
    pose: Pose,
    distances: [Vec<f64>; 2],
}

impl Position<'_> {
    fn spread(&self) -> WallSpread {
        WallSpread::of(&self.distances)
    }
}

/// Figure 4: the distances of the electrode from the walls in a good and in a bad position.
pub(super) fn distribution(
    subject: &Subject,
    primitive: &[Electrode],
    studio: &mut Studio,
    task: &Task,
) -> Result<Outcome, ReproduceError> {
    const NAME: &str = "Figure 4";
    /// Points of a wall along the passage and from hub to shroud: so many that the chords of its grid follow the fillets.
    const FINE: [usize; 2] = [121, 121];
    let fine = Arc::new(subject.channel_of(FINE, NAME, task)?);
    let finder = SurfaceFinder::new(fine).map_err(|e| failed(task, NAME, &e))?;
    let to_walls = |p: DVec3| finder.wall_distances(p);
    let gauge = |electrode: &Electrode| WallSamples::of(electrode, &subject.channel.channel, &task.cancel);
    let mut along = Vec::new();
    for case in &subject.cases {
        let samples = gauge(&case.found.electrode)?;
        let nodes: Vec<_> = case.plan().nodes.par_iter().map(|n| samples.spread(&n.pose, 0.0, &to_walls)).collect();
        task.check()?;
        along.push(nodes);
    }
    // The most uneven position that free travel comes to while half of the walls are between the blades.
    let (reduced, weights) = (&subject.genetic().found.electrode, Weights::default());
    let (on_walls, nodes) = (gauge(reduced)?, &subject.free_travel().plan().nodes);
    let between = |pose: &Pose| on_walls.placed(pose, 0.0).map(|places| places.len());
    let all = between(&Pose::FINAL);
    let is_within = |node: &Node| between(&node.pose).iter().zip(all).all(|(now, all)| 2 * now >= all);
    let worst = along[2].iter().zip(nodes).filter(|(_, node)| is_within(node));
    let unevenness = |of: &WallSpread| of.deviation.iter().sum::<f64>();
    let worst = worst.max_by(|a, b| unevenness(a.0).total_cmp(&unevenness(b.0)));
    let worst = worst.map_or(Pose::FINAL, |(_, node)| node.pose);
    let s = worst.x.abs();
    let net_shape = primitive.first().unwrap_or(reduced);
    let mut positions = Vec::new();
    for (name, electrode, pose) in [
        ("(a) net-shape electrode, final pose".to_owned(), net_shape, Pose::FINAL),
        ("reduced electrode, final pose".to_owned(), reduced, Pose::FINAL),
        (format!("(b) most uneven node of free travel, {s:.1} mm out"), reduced, worst),
    ] {
        let distances = gauge(electrode)?.distances(&pose, 0.0, &to_walls);
        positions.push(Position { name, electrode, pose, distances });
    }
    let row = |p: &Position| {
        let WallSpread { least, deviation: [low, high] } = p.spread();
        let least = least.map(|d| d.unwrap_or(f64::NAN));
        let figures = [least[0], least[1], (least[0] - least[1]).abs(), low, high, p.spread().centring(&weights)];
        std::iter::once(p.name.clone()).chain(figures.map(|v| number(v, 3))).collect::<Vec<_>>()
    };
    let [good, _, bad] = [0, 1, 2].map(|i| positions[i].spread());
    let verdict = if agrees(&good, &bad) { Verdict::Same } else { Verdict::Worse };
    let why = format!(
        "The paper says: in the final pose D_L and D_R are about equal and S_L and S_R about 0, in a bad position S_L and S_R \
         are large. Ours: S_L {:.3} and S_R {:.3} mm against {:.3} and {:.3} mm. The paper prints no values.",
        good.deviation[0], good.deviation[1], bad.deviation[0], bad.deviation[1]
    );
    let mut plots: Vec<String> = positions.iter().map(|p| histogram(p).svg()).collect();
    type Quantity = fn(&WallSpread) -> Option<f64>;
    let quantities: [(&str, Quantity); 3] = [
        ("|D_L - D_R|, mm", |w| Some((w.least[0]? - w.least[1]?).abs())),
        ("S_L, mm", |w| w.least[0].map(|_| w.deviation[0])),
        ("S_R, mm", |w| w.least[1].map(|_| w.deviation[1])),
    ];
    plots.extend(quantities.iter().map(|(title, of)| {
        let series = subject.cases.iter().zip(&along).map(|(case, nodes)| {
            let points = case.plan().nodes.iter().zip(nodes).filter_map(|(n, w)| of(w).map(|v| [n.s, v]));
            Series { points: points.collect(), class: case.class, dots: false }
        });
        let (title, x_label) = ((*title).to_owned(), "s, mm retracted; colours as in figure 7".to_owned());
        Plot { title, x_label, size: [360.0, 220.0], series: series.collect(), ..Plot::default() }.svg()
    }));
    let shown = [&positions[0], &positions[2]];
    let coloured: Vec<Coloured> = shown.iter().map(|p| Coloured::of(p, subject, &to_walls)).collect();
    task.check()?;
    let most = coloured.iter().flat_map(|c| c.values.iter()).filter(|v| v.is_finite()).fold(0.0, |a: f32, b| a.max(*b));
    let sides = [ElectrodeFace::LowWall, ElectrodeFace::HighWall];
    let views: Vec<View> = coloured.iter().flat_map(|c| sides.map(|side| c.view(side, most))).collect();
    let png = studio.sheet(&views, SHEET, task).map_err(|e| failed(task, NAME, &e))?;
    let bar = Legend {
        title: String::new(),
        unit: "mm".to_owned(),
        map: ColourMap::Sequential,
        min: 0.0,
        max: f64::from(most),
        threshold: None,
    };
    let mut legend: Vec<_> = bar.ticks(5).into_iter().map(|v| (bar.colour(v), format!("{v:.2} mm"))).collect();
    legend.push((COPPER, "not a wall, or beyond the blades".to_owned()));
    let caption = format!(
        "Distance of the low wall (left) and the high wall (right) from the wall of the channel beside it, as a grid of \
         points tells it, about 0.01 mm off the mesh; above {}, below {}.",
        shown[0].name, shown[1].name
    );
    let head = ["position", "#D_L mm", "#D_R mm", "#|D_L − D_R| mm", "#S_L mm", "#S_R mm", "#Obj2 (5), equal weights"];
    Ok(Outcome {
        tables: vec![Table::new("Distances of the electrode's walls", &head, positions.iter().map(row).collect())],
        plots,
        pictures: picture("Distances of the walls as colours", caption, &legend, png).into_iter().collect(),
        files: vec![("p0_nodes.csv".to_owned(), nodes_csv(&subject.cases, &along).into_bytes())],
        ..subject.outcome(
            NAME,
            "Distribution of wall distances over the electrode",
            verdict,
            why + &studio.note(),
            &format!(
                "{BY_GENETIC}; columns D_L, D_R, S_L, S_R of the node table in report.html, walls_mm in report.json, nodes_1.csv; the histogram of every node in wall_distances_1.csv, and in the window as the plot Histogram. Figures of this page: p0_nodes.csv"
            ),
        )
    })
}

/// Whether the distances in a good and in a bad position are as the paper says: about equal and even in the former,
/// uneven in the latter.
fn agrees(good: &WallSpread, bad: &WallSpread) -> bool {
    /// What counts as nothing: some times the error of wall grids (mm).
    const NOTHING: f64 = 0.05;
    let [low, high] = good.least;
    let is_even = low.zip(high).is_some_and(|(low, high)| (low - high).abs() < NOTHING);
    let grown = |wall: usize| bad.deviation[wall] > 3.0 * good.deviation[wall];
    is_even && good.deviation.iter().all(|s| *s < NOTHING) && grown(0) && grown(1)
}

/// Shares of the samples of both walls over the distance.
fn histogram(position: &Position) -> Plot {
    let found = Histogram::of(&position.distances);
    let series = [(0, "c0"), (1, "c1")].map(|(wall, class)| Series { points: found.outline(wall), class, dots: false });
    Plot {
        title: format!("{}, % of samples", position.name),
        x_label: "distance, mm; blue low wall, brown high wall".to_owned(),
        size: [360.0, 220.0],
        series: series.to_vec(),
        ..Plot::default()
    }
}

/// An electrode with the distances of its walls at its vertices.
struct Coloured<'a> {
    electrode: &'a Electrode,
    shape: Arc<RenderMesh>,
    /// Distances (mm); not a number where there is none.
    values: Arc<Vec<f32>>,
}

impl<'a> Coloured<'a> {
    fn of(position: &Position<'a>, subject: &Subject, to_walls: &(dyn Fn(DVec3) -> [f64; 2] + Sync)) -> Self {
        let (electrode, blades) = (position.electrode, subject.channel.channel.blade_span());
        let place = position.pose.placement(electrode.reference_point);
        let mesh = &electrode.mesh;
        let mut wall_of = vec![None; mesh.vertices.len()];
        for (triangle, face) in mesh.triangles.iter().zip(&electrode.faces) {
            let wall = match face {
                ElectrodeFace::LowWall => 0,
                ElectrodeFace::HighWall => 1,
                _ => continue,
            };
            triangle.iter().for_each(|v| wall_of[*v as usize] = Some(wall));
        }
        let value = |(p, wall): (&DVec3, &Option<usize>)| {
            let at = place.transform_point3(*p);
            let distance = wall.filter(|_| blades.contains(at)).map(|wall| to_walls(at)[wall]);
            distance.map_or(f32::NAN, |d| d as f32)
        };
        let values = mesh.vertices.par_iter().zip(&wall_of).map(value).collect();
        Self { electrode, shape: Arc::new(RenderMesh::for_pictures(mesh)), values: Arc::new(values) }
    }

    /// The electrode seen onto one of its walls; colours run from 0 to `most` (mm).
    fn view(&self, side: ElectrodeFace, most: f32) -> View {
        let Electrode { mesh, faces, .. } = self.electrode;
        let on_side = || mesh.iter_corners().zip(faces).filter(|(_, face)| **face == side).map(|(corners, _)| corners);
        let outwards: DVec3 = on_side().map(normal_times_two_areas).sum();
        let range = [0.0, most];
        let values = SurfaceValues { values: self.values.clone(), map: ColourMap::Sequential, range };
        let object = Object::new(ObjectId(0), self.shape.clone(), COPPER);
        let mut scene = Scene { triad: false, ..Scene::new(Theme::LIGHT) };
        scene.objects.push(Object { edges: false, values: Some(values), ..object });
        let mut camera = Camera {
            orientation: looking(outwards, DVec3::Z),
            projection: Projection::Orthographic,
            ..Camera::default()
        };
        camera.fit(&around(on_side().flatten()), SHEET_ASPECT);
        (scene, camera)
    }
}

/// Every node of every path, with both objectives and what the second is made of.
fn nodes_csv(cases: &[Case], along: &[Vec<WallSpread>]) -> String {
    let mut out =
        "strategy,node,s_mm,x_mm,y_mm,z_mm,a_deg,b_deg,c_deg,field_clearance_mm,objective_1,objective_2,objective,\
        D_L_mm,D_R_mm,S_L_mm,S_R_mm\n"
            .to_owned();
    for (case, spreads) in cases.iter().zip(along) {
        for (i, (node, w)) in case.plan().nodes.iter().zip(spreads).enumerate() {
            let [x, y, z, a, b, c] = node.pose.to_array();
            let [a, b, c] = [a, b, c].map(f64::to_degrees);
            let o = &node.objective;
            let figures = [node.s, x, y, z, a, b, c, node.clearance, o.smoothness, o.centring, o.total];
            let figures = figures.map(|v| format!("{v:.6}")).join(",");
            let least = w.least.map(|d| d.map_or(String::new(), |d| format!("{d:.6}"))).join(",");
            let deviations = w.deviation.map(|s| format!("{s:.6}")).join(",");
            let name = case.name.replace(',', ";");
            out += &format!("{name},{i},{figures},{least},{deviations}\n");
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrong_answers_are_alarms_and_misses() {
        let one = Judged { places: [3, 1], alarms: [2, 1], missed: [0, 1] };
        assert_eq!(one.and(one), Judged { places: [6, 2], alarms: [4, 2], missed: [0, 2] });
        assert_eq!(one.wrong(), [2, 2]);
    }

    #[test]
    fn the_paper_is_met_by_even_distances_that_become_uneven() {
        let even = WallSpread { least: [Some(0.1), Some(0.11)], deviation: [0.01; 2] };
        let uneven = WallSpread { least: [Some(0.1), Some(1.0)], deviation: [0.5; 2] };
        assert!(agrees(&even, &uneven) && !agrees(&uneven, &uneven) && !agrees(&even, &even));
    }
}
