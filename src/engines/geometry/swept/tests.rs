use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DAffine3, DMat3, DVec2, DVec3};

use super::{SweptError, SweptSurface};
use crate::exact::ExactMesh;
use crate::mesh::Mesh;
use task::{Cancel, Task};

/// A ball of radius 2 mm about the origin; its faces lie up to `sagitta` within it.
fn ball() -> (Mesh, f64) {
    let (n, m) = (48, 24);
    let point = |i: usize, j: usize| {
        let (around, down) = (2.0 * PI * i as f64 / n as f64, PI * j as f64 / m as f64);
        2.0 * DVec3::new(down.sin() * around.cos(), down.sin() * around.sin(), down.cos())
    };
    let mut vertices = vec![point(0, 0), point(0, m)];
    vertices.extend((1..m).flat_map(|j| (0..n).map(move |i| (i, j))).map(|(i, j)| point(i, j)));
    let at = |i: usize, j: usize| match j {
        0 => 0,
        j if j == m => 1,
        j => (2 + (j - 1) * n + i % n) as u32,
    };
    let quads = (0..m).flat_map(|j| (0..n).map(move |i| (i, j)));
    let halves = quads.flat_map(|(i, j)| {
        let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
        [[a, b, c], [a, c, d]]
    });
    let triangles = halves.filter(|[a, b, c]| a != b && b != c && c != a).collect();
    // Half an edge seen from the middle, along both.
    (Mesh { vertices, triangles }, 2.0 * (1.0 - (PI / n as f64).cos() * (FRAC_PI_2 / m as f64).cos()))
}

fn sweep(body: &Mesh, placements: &[DAffine3], cells: usize) -> SweptSurface {
    let swept = SweptSurface::new(body, placements, cells, &Task::default()).unwrap();
    assert!(swept.mesh.is_watertight());
    swept
}

/// Placements from the origin along `way`, close enough.
fn slide(way: DVec3) -> Vec<DAffine3> {
    let n = (way.length() / SweptSurface::STEP).ceil() as usize;
    (0..=n).map(|i| DAffine3::from_translation(way * (i as f64 / n as f64))).collect()
}

/// Turns about Z up to `angle`, close enough for points within `radius`.
fn turn(angle: f64, radius: f64) -> Vec<DAffine3> {
    let n = (angle * radius / SweptSurface::STEP).ceil() as usize;
    (0..=n).map(|i| DAffine3::from_mat3(DMat3::from_rotation_z(angle * i as f64 / n as f64))).collect()
}

fn assert_on(swept: &SweptSurface, distance: impl Fn(DVec3) -> f64, more: f64) {
    for p in &swept.mesh.vertices {
        let d = distance(*p);
        assert!(d.abs() <= SweptSurface::ACCURACY + more, "{p}: {d} mm off");
    }
}

/// How far a chord over two cells cuts into a ball of radius 2 mm.
fn chord(swept: &SweptSurface) -> f64 {
    (2.0 * swept.cell).powi(2) / (8.0 * 2.0) + SweptSurface::ACCURACY
}

/// Every corner of the body lies within the surface in every placement, or as far outside as a chord cuts off.
fn assert_holds(swept: &SweptSurface, body: &Mesh, placements: &[DAffine3], chord: f64) {
    let surface = ExactMesh::new(&swept.mesh).unwrap();
    for placement in placements.iter().step_by(7).chain(placements.last()) {
        for p in &body.vertices {
            let d = surface.signed_distance(placement.transform_point3(*p));
            assert!(d <= chord, "{d} mm outside");
        }
    }
}

#[test]
fn a_ball_along_a_line_sweeps_a_capsule() {
    let (ball, sagitta) = ball();
    let way = DVec3::new(5.0, 2.0, -1.0);
    let placements = slide(way);
    let swept = sweep(&ball, &placements, 40_000);
    let capsule = |p: DVec3| (p - way * (p.dot(way) / way.length_squared()).clamp(0.0, 1.0)).length() - 2.0;
    assert_on(&swept, capsule, sagitta);
    let exact = PI * 4.0 * way.length() + 4.0 / 3.0 * PI * 8.0;
    assert!((swept.mesh.volume() / exact - 1.0).abs() < 0.01, "{} of {exact}", swept.mesh.volume());
    assert_holds(&swept, &ball, &placements, chord(&swept));
}

#[test]
fn a_ball_about_an_axis_sweeps_a_part_of_a_torus() {
    let (ball, sagitta) = ball();
    let ball = ball.mapped(|p| p + 6.0 * DVec3::X);
    let placements = turn(FRAC_PI_2, 8.0);
    let swept = sweep(&ball, &placements, 40_000);
    let bent = |p: DVec3| {
        let around = p.y.atan2(p.x).clamp(0.0, FRAC_PI_2);
        p.distance(6.0 * DVec3::new(around.cos(), around.sin(), 0.0)) - 2.0
    };
    assert_on(&swept, bent, sagitta);
    assert_holds(&swept, &ball, &placements, chord(&swept));
}

#[test]
fn a_box_along_one_of_its_edges_sweeps_a_longer_box_with_its_edges() {
    let body = Mesh::cuboid(DVec3::new(3.0, 2.0, 1.5));
    let placements = slide(4.0 * DVec3::X);
    let swept = sweep(&body, &placements, 30_000);
    let longer = ExactMesh::new(&Mesh::cuboid(DVec3::new(7.0, 2.0, 1.5))).unwrap();
    assert_on(&swept, |p| longer.signed_distance(p), 0.0);
    assert!((swept.mesh.volume() - 21.0).abs() < 0.05, "{}", swept.mesh.volume());
    assert_holds(&swept, &body, &placements, 0.05);
}

#[test]
fn a_box_aslant_sweeps_the_hull_of_both_ends() {
    let body = Mesh::cuboid(DVec3::splat(2.0));
    let way = DVec3::new(3.0, 3.0, 0.0);
    let placements = slide(way);
    let swept = sweep(&body, &placements, 30_000);
    // Six sides along Z over the hexagon between the two squares.
    let hexagon = [[0.0, 0.0], [2.0, 0.0], [5.0, 3.0], [5.0, 5.0], [3.0, 5.0], [0.0, 2.0]].map(DVec2::from_array);
    let inside = |p: DVec2| {
        (0..6)
            .map(|i| (hexagon[(i + 1) % 6] - hexagon[i]).normalize().perp_dot(p - hexagon[i]))
            .fold(f64::MAX, f64::min)
    };
    for p in &swept.mesh.vertices {
        let depth = inside(p.truncate()).min(p.z).min(2.0 - p.z);
        assert!(depth.abs() <= SweptSurface::ACCURACY, "{p}: {depth}");
    }
    assert!((swept.mesh.volume() - 2.0 * (4.0 + 12.0)).abs() < 0.1, "{}", swept.mesh.volume());
    assert_holds(&swept, &body, &placements, 0.05);
}

#[test]
fn a_body_that_stands_still_is_its_own_sweep() {
    let body = Mesh::cuboid(DVec3::new(2.0, 1.0, 1.0));
    let still = sweep(&body, &[DAffine3::IDENTITY], 5_000);
    assert!((still.mesh.volume() - 2.0).abs() < 0.01);
    assert_on(&still, |p| ExactMesh::new(&body).unwrap().signed_distance(p), 0.0);
}

#[test]
fn the_surface_is_the_same_on_any_number_of_threads() {
    let (ball, _) = ball();
    let placements = slide(DVec3::new(1.0, 2.0, 1.0));
    let mesh = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| sweep(&ball, &placements, 8_000).mesh)
    };
    assert!(mesh(1) == mesh(3));
}

#[test]
fn what_has_no_surface_is_refused() {
    let body = Mesh::cuboid(DVec3::ONE);
    let swept = |body: &Mesh, at: &[DAffine3], cancel: &Cancel| {
        SweptSurface::new(body, at, 1000, &Task::silent(cancel)).map(|s| s.mesh)
    };
    let here = [DAffine3::IDENTITY];
    assert_eq!(swept(&body, &[], &Cancel::default()), Err(SweptError::NoWay));
    let nowhere = [DAffine3::IDENTITY, DAffine3::from_translation(DVec3::NAN)];
    assert_eq!(swept(&body, &nowhere, &Cancel::default()), Err(SweptError::NoWay));
    assert!(matches!(swept(&Mesh::default(), &here, &Cancel::default()), Err(SweptError::Body(_))));
    let cancelled = Cancel::default();
    cancelled.cancel();
    assert!(matches!(swept(&body, &here, &cancelled), Err(SweptError::Cancelled(_))));
}
