//! Figures 3 and 4 of P0: the constraint at the walls, and the distances of the electrode from them.

use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use super::pictures::{Studio, View, picture};
use super::{BY_GENETIC, Case, SHEET, SHEET_ASPECT, Subject, around, failed, key, table};
use crate::reproduce::{Outcome, ReproduceError, Verdict};
use crate::widgets::theme::COPPER;
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
use wheel::electrode::{Electrode, ElectrodeFace};

/// Answers of the two tests on places whose distance from the blisk is known.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Judged {
    /// Places.
    places: usize,
    /// Those called interfering by the 90 degree test.
    by_tangent: usize,
    /// Those called interfering by the comparison of alpha with theta.
    by_angles: usize,
}

impl Judged {
    fn and(self, other: Self) -> Self {
        Self {
            places: self.places + other.places,
            by_tangent: self.by_tangent + other.by_tangent,
            by_angles: self.by_angles + other.by_angles,
        }
    }
}

/// Figure 3: the comparison of alpha with theta against that with 90 degrees.
pub(super) fn constraint(subject: &Subject, task: &Task) -> Result<Outcome, ReproduceError> {
    /// Places nearer to the surface than this are left out: the walls are grids of points (mm).
    const TOO_NEAR: f64 = 0.03;
    /// How far poses are moved across the channel, either way, so that the electrode reaches into a blade (mm).
    const ASIDE: f64 = 0.6;
    let channel = &subject.channel;
    let Case { found, .. } = subject.genetic();
    let samples = WallSamples::of(&found.electrode, &channel.channel, &task.cancel)?;
    let test = AngleTest::new(&channel.channel, 0.0, &AngleParams::default());
    let at = |pose: Pose| {
        task.check()?;
        // Free places, then those inside a blade.
        let (mut judged, mut nearest) = ([Judged::default(); 2], [0; 2]);
        for (wall, places) in samples.placed(&pose, 0.0).into_iter().enumerate() {
            for place in places {
                let distance = guarded_distance(&channel.exact, place);
                let Some(angles) = test.angles(place, &mut nearest)[wall].filter(|_| distance.abs() > TOO_NEAR) else {
                    continue;
                };
                let of = &mut judged[usize::from(distance < 0.0)];
                of.places += 1;
                of.by_tangent += usize::from(angles.alpha >= FRAC_PI_2);
                of.by_angles += usize::from(angles.alpha >= angles.theta);
            }
        }
        Ok::<_, ReproduceError>(judged)
    };
    let aside = |node: &Node| [-ASIDE, 0.0, ASIDE].map(|y| Pose { y: node.pose.y + y, ..node.pose });
    let poses: Vec<Pose> = found.plan.nodes.iter().flat_map(aside).collect();
    let judged = poses.into_par_iter().map(at).collect::<Result<Vec<_>, _>>()?;
    let [free, inside] = [0, 1].map(|i| judged.iter().map(|j| j[i]).fold(Judged::default(), Judged::and));
    let row = |name: &str, of: Judged, wrong: [usize; 2]| {
        let shares = wrong.map(|n| format!("{n} ({} %)", number(100.0 * n as f64 / of.places.max(1) as f64, 2)));
        let [tangent, angles] = shares;
        vec![name.to_owned(), of.places.to_string(), tangent, angles]
    };
    let missed = [inside.places - inside.by_tangent, inside.places - inside.by_angles];
    let [tangent, angles] = [free.by_tangent + missed[0], free.by_angles + missed[1]];
    let verdict = if angles < tangent { Verdict::Same } else { Verdict::Worse };
    let why = format!(
        "The paper says that the 90 degree test misjudges places beside a twisted wall and the comparison of alpha with theta \
         does not. Of {} places with a known distance the former misjudges {tangent}, the latter {angles}. Neither proves a \
         path; the certificate does.",
        free.places + inside.places
    );
    let rows = vec![
        row("free, called interfering", free, [free.by_tangent, free.by_angles]),
        row("inside a blade, called free", inside, missed),
    ];
    let caption = format!(
        "Samples on the electrode's walls at every node of the path, and {ASIDE} mm to either side of it; true distances are \
         exact, those below {TOO_NEAR} mm are left out"
    );
    Ok(Outcome {
        tables: vec![table(&caption, &["places", "#number", "#wrong, 90° test", "#wrong, alpha and theta"], rows)],
        ..subject.outcome(
            "Figure 3",
            "Constraint: alpha and theta at the nearest wall point",
            verdict,
            why,
            "--set plan.constraint=angle, plan.angle.delta1_mm, plan.angle.delta2_deg; in the window the step Plan, Constraint",
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
    let to_walls = |p: DVec3| subject.finder.wall_distances(p);
    let gauge = |electrode: &Electrode| WallSamples::of(electrode, &subject.channel.channel, &task.cancel);
    let mut along = Vec::new();
    for case in &subject.cases {
        let samples = gauge(&case.found.electrode)?;
        let nodes: Vec<_> = case.plan().nodes.par_iter().map(|n| samples.spread(&n.pose, 0.0, &to_walls)).collect();
        task.check()?;
        along.push(nodes);
    }
    // The worst position that free travel comes to while both walls are between the blades.
    let (reduced, weights) = (&subject.genetic().found.electrode, Weights::default());
    let worst = along[2].iter().zip(&subject.free_travel().plan().nodes);
    let worst = worst.filter(|(spread, _)| spread.least.iter().all(Option::is_some));
    let worst = worst.max_by(|a, b| a.0.centring(&weights).total_cmp(&b.0.centring(&weights)));
    let worst = worst.map_or(Pose::FINAL, |(_, node)| node.pose);
    let s = worst.x.abs();
    let net_shape = primitive.first().unwrap_or(reduced);
    let mut positions = Vec::new();
    for (name, electrode, pose) in [
        ("(a) net-shape electrode, final pose".to_owned(), net_shape, Pose::FINAL),
        ("reduced electrode, final pose".to_owned(), reduced, Pose::FINAL),
        (format!("(b) reduced electrode, worst node of free travel, {s:.1} mm before"), reduced, worst),
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
    let quantities: [(&str, fn(&WallSpread) -> Option<f64>); 3] = [
        ("|D_L - D_R|, mm", |w| Some((w.least[0]? - w.least[1]?).abs())),
        ("S_L, mm", |w| w.least[0].map(|_| w.deviation[0])),
        ("S_R, mm", |w| w.least[1].map(|_| w.deviation[1])),
    ];
    plots.extend(quantities.iter().map(|(title, of)| {
        let series = subject.cases.iter().zip(&along).map(|(case, nodes)| {
            let points = case.plan().nodes.iter().zip(nodes).filter_map(|(n, w)| of(w).map(|v| [n.s, v]));
            Series { points: points.collect(), class: case.class, dots: false }
        });
        let (title, x_label) = ((*title).to_owned(), "s, mm retracted".to_owned());
        Plot { title, x_label, size: [360.0, 220.0], series: series.collect(), ..Plot::default() }.svg()
    }));
    let shown = [&positions[0], &positions[2]];
    let coloured: Vec<Coloured> = shown.iter().map(|p| Coloured::of(p, subject)).collect();
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
        "Distance of the low wall (left) and the high wall (right) from the wall of the channel beside it; above {}, below {}.",
        shown[0].name, shown[1].name
    );
    let head = ["position", "#D_L mm", "#D_R mm", "#|D_L − D_R| mm", "#S_L mm", "#S_R mm", "#Obj2 (5), equal weights"];
    let colours = key(&subject.cases).into_iter().map(|(_, name)| name).collect::<Vec<_>>().join(", ");
    Ok(Outcome {
        tables: vec![table("Distances of the electrode's walls", &head, positions.iter().map(row).collect())],
        plots,
        pictures: vec![picture("Distances of the walls as colours", caption, &legend, png)],
        files: vec![("p0_nodes.csv".to_owned(), nodes_csv(&subject.cases, &along).into_bytes())],
        ..subject.outcome(
            NAME,
            &format!(
                "Distribution of wall distances; histograms of low and high wall, then along the paths of {colours}"
            ),
            verdict,
            why,
            &format!(
                "{BY_GENETIC}; columns D_L, D_R, S_L, S_R of the node table in report.html, walls_mm in report.json"
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
    let most = position.distances.iter().flatten().copied().fold(1e-3, f64::max);
    let steps = |distances: &Vec<f64>| {
        let width = most / BINS as f64;
        let counts = binned(distances, most);
        let share = |n: usize| 100.0 * n as f64 / distances.len().max(1) as f64;
        let corners = counts.iter().enumerate().flat_map(|(i, &n)| [0, 1].map(|k| [(i + k) as f64 * width, share(n)]));
        corners.collect::<Vec<_>>()
    };
    let [low, high] = position.distances.each_ref().map(steps);
    Plot {
        title: format!("% of samples, {}", position.name),
        x_label: "distance, mm".to_owned(),
        size: [360.0, 220.0],
        series: [(low, "c0"), (high, "c1")].map(|(points, class)| Series { points, class, dots: false }).to_vec(),
        ..Plot::default()
    }
}

/// Bins of a histogram.
const BINS: usize = 24;

/// How many of `values` are in each of the bins from 0 to `most`.
fn binned(values: &[f64], most: f64) -> [usize; BINS] {
    let mut counts = [0; BINS];
    for value in values {
        counts[((value / most * BINS as f64) as usize).min(BINS - 1)] += 1;
    }
    counts
}

/// An electrode with the distances of its walls at its vertices.
struct Coloured<'a> {
    electrode: &'a Electrode,
    shape: Arc<RenderMesh>,
    /// Distances (mm); not a number where there is none.
    values: Arc<Vec<f32>>,
}

impl<'a> Coloured<'a> {
    fn of(position: &Position<'a>, subject: &Subject) -> Self {
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
            let distance = wall.filter(|_| blades.contains(at)).map(|wall| subject.finder.wall_distances(at)[wall]);
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
    let mut out = "strategy,node,s_mm,x_mm,y_mm,z_mm,a_deg,b_deg,c_deg,clearance_mm,objective_1,objective_2,objective,\
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
    fn every_value_is_in_a_bin_the_greatest_in_the_last() {
        let counts = binned(&[0.0, 0.5, 1.0, 1.0], 1.0);
        assert_eq!((counts[0], counts[BINS / 2], counts[BINS - 1]), (1, 1, 2));
        assert_eq!(counts.iter().sum::<usize>(), 4);
    }

    #[test]
    fn the_paper_is_met_by_even_distances_that_become_uneven() {
        let even = WallSpread { least: [Some(0.1), Some(0.11)], deviation: [0.01; 2] };
        let uneven = WallSpread { least: [Some(0.1), Some(1.0)], deviation: [0.5; 2] };
        assert!(agrees(&even, &uneven) && !agrees(&uneven, &uneven) && !agrees(&even, &even));
    }
}
