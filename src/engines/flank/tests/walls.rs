//! Triangles that are walls, and the depth that the flutes may go into them.

use super::*;
use crate::gouge::{Clearance, check};
use crate::walls::{OwnTriangles, Walls};
use geometry::mesh::Mesh;

/// Quadrangles along the wall: their corners are all that the mesh tells of it.
const PARTS: usize = 3;
const LENGTH: f64 = 30.0;
const HEIGHT: f64 = 10.0;
/// How far the wall's upper edge leans out at one end and back at the other (mm).
const LEAN: f64 = 1.1;
/// How far a step stands out, and how high it is (mm).
const OUT: f64 = 0.3;
const HIGH: f64 = 0.1;

/// A part whose cross-section at each x is a polygon of y and z, given by y of the wall's upper edge there, and how the
/// ends are cut into triangles. From the first to the second point of the polygon is the wall; it faces along y.
fn part(section: &dyn Fn(f64) -> Vec<[f64; 2]>, ends: &[[u32; 3]]) -> (Mesh, Vec<u32>) {
    let share = |i: usize| i as f64 / PARTS as f64;
    let at = |i: usize| {
        let row = section(LEAN * (1.0 - 2.0 * share(i)));
        row.into_iter().map(move |[y, z]| DVec3::new(LENGTH * share(i), y, z))
    };
    let vertices: Vec<DVec3> = (0..=PARTS).flat_map(at).collect();
    let n = (vertices.len() / (PARTS + 1)) as u32;
    let mut triangles = Vec::new();
    for k in 0..n {
        for i in 0..PARTS as u32 {
            let [a, b] = [k, (k + 1) % n].map(|k| i * n + k);
            triangles.extend([[a, b, b + n], [a, b + n, a + n]]);
        }
    }
    let last = PARTS as u32 * n;
    triangles.extend(ends.iter().flat_map(|&[a, b, c]| [[a, c, b], [a + last, b + last, c + last]]));
    let mesh = Mesh { vertices, triangles };
    assert!(mesh.is_watertight() && mesh.volume() > 0.0, "{}", mesh.volume());
    (mesh, (0..2 * PARTS as u32).collect())
}

/// Nothing beside the wall.
fn plain() -> (Mesh, Vec<u32>) {
    part(&|y| vec![[0.0, 0.0], [y, HEIGHT], [-8.0, HEIGHT], [-8.0, 0.0]], &[[0, 1, 3], [1, 2, 3]])
}

/// A bead along the wall's upper edge.
fn bead() -> (Mesh, Vec<u32>) {
    let top = HEIGHT + HIGH;
    let section =
        |y: f64| vec![[0.0, 0.0], [y, HEIGHT], [y + OUT, HEIGHT], [y + OUT, top], [y, top], [-8.0, top], [-8.0, 0.0]];
    part(&section, &[[0, 1, 6], [1, 4, 6], [4, 5, 6], [1, 2, 3], [1, 3, 4]])
}

/// A ledge along its lower edge.
fn ledge() -> (Mesh, Vec<u32>) {
    let section = |y: f64| vec![[0.0, 0.0], [y, HEIGHT], [-8.0, HEIGHT], [-8.0, -HIGH], [OUT, -HIGH], [OUT, 0.0]];
    part(&section, &[[0, 1, 3], [1, 2, 3], [0, 3, 4], [0, 4, 5]])
}

/// How far the triangles of the wall are off its surface: a quarter of what the fourth corner of a quadrangle is off
/// the plane of the others. It is all that tolerances, errors and chords of a fit can be told by.
const CHORD: f64 = 2.0 * LEAN / PARTS as f64 / 4.0;
/// Distance within which triangles count as the surface itself: error, chord and tolerance of a fit.
const NEAR: f64 = 2.0 * CHORD + 0.01;

/// The wall's surface and a path along it.
fn milled() -> (RuledSurface, FlankPlan) {
    let guide = |from: DVec3, to: DVec3| GuideCurve::Bezier { points: vec![from, to] };
    let lower = guide(DVec3::ZERO, LENGTH * DVec3::X);
    let upper = guide(DVec3::new(0.0, LEAN, HEIGHT), DVec3::new(LENGTH, -LEAN, HEIGHT));
    let mut surface = RuledSurface::from_guides(&lower, &upper, Side::Positive).unwrap();
    if surface.normal(0.5, 0.5).y < 0.0 {
        surface = RuledSurface::from_guides(&lower, &upper, Side::Negative).unwrap();
    }
    let params = FlankParams { grid: [40, 10], rounds: 0, ..FlankParams::default() };
    let plan = planned(&surface, &FlankCutter::cylinder(2.0, 20.0), &params).unwrap();
    (surface, plan)
}

fn walls(mesh: &Mesh, own: OwnTriangles, (surface, plan): &(RuledSurface, FlankPlan), most_mm: f64) -> Walls {
    Walls::new(mesh, own, (surface, &plan.chosen), most_mm, &Cancel::default()).unwrap()
}

fn clearance(walls: &Walls, plan: &FlankPlan) -> Clearance {
    check(&plan.chosen, &plan.cutter, walls, &Task::default()).unwrap().cutter.unwrap()
}

#[test]
fn a_narrow_step_beside_a_coarse_wall_is_a_wall() {
    let milled = milled();
    assert!(OUT.hypot(HIGH) < NEAR, "all of the step is as near to the surface as the wall's own triangles may be");
    for ((mesh, face), depth) in [(bead(), OUT), (ledge(), milled.1.params.below_mm)] {
        let near = clearance(&walls(&mesh, OwnTriangles::Near(NEAR), &milled, CHORD), &milled.1);
        assert!(near.distance_mm > -0.03, "what is near is taken for the wall itself: {near:?}");
        let exact = clearance(&walls(&mesh, OwnTriangles::Listed(&face), &milled, CHORD), &milled.1);
        assert!((exact.distance_mm + depth).abs() < 0.05, "{depth}: {exact:?}");
    }
}

#[test]
fn what_turns_away_at_the_border_is_touched_as_deep_as_the_border_is_cut() {
    let milled = milled();
    let (mesh, face) = plain();
    let walls = walls(&mesh, OwnTriangles::Listed(&face), &milled, 0.0);
    let found = clearance(&walls, &milled.1);
    assert!(found.distance_mm > -milled.1.params.gouge_tolerance_mm, "{found:?}");
    // A place at the border lies in the flutes by the overcut there; no more than that is allowed, and only there.
    let path = &milled.1.chosen;
    let overcut = -path.deviation.most_overcut.min(path.envelope.deviation.most_overcut);
    assert_eq!(walls.allowed.len(), mesh.triangles.len() - face.len());
    assert!(walls.allowed.iter().all(|a| (0.0..=overcut).contains(a)), "{overcut} {:?}", walls.allowed);
    assert!(walls.allowed.iter().any(|a| *a > 0.0) && walls.allowed.contains(&0.0), "{:?}", walls.allowed);
}

#[test]
fn a_second_copy_of_the_part_has_the_same_walls() {
    let milled = milled();
    let (mesh, face) = bead();
    let mut copy = mesh.clone();
    copy.triangles.reverse();
    let [exact, same] = [
        walls(&mesh, OwnTriangles::Listed(&face), &milled, CHORD),
        walls(&copy, OwnTriangles::On(&mesh, &face, 1e-3), &milled, CHORD),
    ];
    assert_eq!(same.triangles().len(), mesh.triangles.len() - face.len());
    let [exact, same] = [exact, same].map(|walls| clearance(&walls, &milled.1).distance_mm);
    assert!((same - exact).abs() < 0.02, "{same} {exact}");
}
