//! Clearances against those of a brute-force search.

use super::*;
use crate::cutter::HolderPart;
use crate::frustum_distance::Frustum;
use crate::gouge::{GougeCheck, ToolPart, check, slack};
use crate::path::{FlankPath, FlankPose};
use crate::walls::{OwnTriangles, Walls};
use geometry::mesh::Mesh;

/// A finely divided square of half size `half` around `center`, spanned by two unit vectors.
fn wall(center: DVec3, along: DVec3, up: DVec3, half: f64) -> Mesh {
    const N: u32 = 6;
    let at = |i: u32| half * (2.0 * f64::from(i) / f64::from(N) - 1.0);
    let vertices = (0..=N).flat_map(|i| (0..=N).map(move |j| center + at(i) * along + at(j) * up)).collect();
    let triangles = (0..N)
        .flat_map(|i| (0..N).map(move |j| i * (N + 1) + j))
        .flat_map(|k| [[k, k + 1, k + N + 1], [k + 1, k + N + 2, k + N + 1]])
        .collect();
    Mesh { vertices, triangles }
}

/// Walls of `mesh`: whatever lies within 0.05 mm of the surface belongs to it.
fn walls(mesh: &Mesh, surface: &RuledSurface, path: &FlankPath) -> Walls {
    Walls::new(mesh, OwnTriangles::Near(0.05), (surface, path), 0.05, &Cancel::default()).unwrap()
}

fn checked(path: &FlankPath, cutter: &FlankCutter, walls: &Walls) -> GougeCheck {
    check(path, cutter, walls, &Task::default()).unwrap()
}

#[test]
fn the_distance_to_a_frustum_is_that_of_its_samples() {
    let cone = Frustum { heights: [1.0, 9.0], radii: [2.0, 3.5] };
    let pose = FlankPose { t: 0.0, tip: DVec3::new(1.0, 2.0, 3.0), axis: DVec3::new(1.0, 2.0, 2.0) / 3.0 };
    let aside = pose.axis.any_orthonormal_vector();
    let outline = |k: u32| {
        let s = f64::from(k) / 20_000.0;
        let [low, high] = [(2.0, 1.0), (3.5, 9.0)];
        [(2.0 * s, 1.0), (3.5 * s, 9.0), (low.0 + s * (high.0 - low.0), low.1 + s * (high.1 - low.1))]
    };
    for (r, h) in [(0.0, 0.0), (5.0, 4.0), (1.0, 5.0), (2.0, 8.7), (6.0, 12.0), (3.0, -2.0), (0.3, 1.2), (2.9, 5.0)] {
        let p = pose.tip + h * pose.axis + r * aside;
        let (distance, slope) = cone.distance(&pose, p);
        let sampled = (0..=20_000).flat_map(outline).map(|(a, b)| (a - r).hypot(b - h)).fold(f64::INFINITY, f64::min);
        let is_inside = h > 1.0 && h < 9.0 && r < 2.0 + 1.5 * (h - 1.0) / 8.0;
        let wanted = if is_inside { -sampled } else { sampled };
        assert!((distance - wanted).abs() < 1e-6, "({r}, {h}): {distance} {wanted}");
        let ahead = cone.distance(&pose, p + 1e-6 * slope).0;
        assert!(((ahead - distance) / 1e-6 - 1.0).abs() < 1e-5, "the slope is the way out");
    }
}

#[test]
fn the_least_clearance_of_a_path_is_that_of_dense_sampling() {
    let (surface, plan) = &quick("cyl_R2_A");
    let path = &plan.refined;
    let holder = vec![HolderPart { length_mm: 10.0, lower_radius_mm: 6.0, upper_radius_mm: 8.0 }];
    let cutter = FlankCutter { length_mm: 20.0, holder, ..plan.cutter.clone() };
    // Walls on the cutter's side: one upright that the flutes come near to, one above that the holder runs into.
    let middle = path.pose(0.43);
    let out = surface.normal(0.43, 0.5);
    let near = wall(middle.tip + 6.0 * out + 4.0 * middle.axis, middle.axis, middle.axis.cross(out).normalize(), 7.0);
    let above = wall(middle.tip + 28.0 * middle.axis + 9.0 * out, out, out.any_orthonormal_vector(), 2.0);
    for mesh in [&near, &above] {
        let found = checked(path, &cutter, &walls(mesh, surface, path));
        let flutes = Frustum { heights: [0.0, 20.0], radii: [2.0, 2.0] };
        let nose = Frustum { heights: [20.0, 30.0], radii: [6.0, 8.0] };
        let shares = (0..=8).flat_map(|i| (0..=8 - i).map(move |j| (f64::from(i) / 8.0, f64::from(j) / 8.0)));
        let of = |[a, b, c]: [DVec3; 3]| shares.clone().map(move |(s, t)| a + s * (b - a) + t * (c - a));
        let points: Vec<DVec3> = mesh.iter_corners().flat_map(of).collect();
        for (part, clearance) in [(flutes, found.cutter), (nose, found.holder)] {
            let samples =
                |pose: &FlankPose| points.iter().map(|p| part.distance(pose, *p).0).fold(f64::INFINITY, f64::min);
            let dense = (0..=60).map(|i| samples(&path.pose(f64::from(i) / 60.0))).fold(f64::INFINITY, f64::min);
            let clearance = clearance.unwrap();
            assert!(clearance.distance_mm - slack(clearance.distance_mm) < dense, "{clearance:?} {dense}");
            let there = part.distance(&path.pose(clearance.t), clearance.point).0;
            assert!((there - clearance.distance_mm).abs() < 1e-9, "the place named is where it is");
        }
    }
    let found = checked(path, &cutter, &walls(&above, surface, path));
    let gouge = found.gouge(0.01).unwrap();
    assert!(gouge.part == ToolPart::Holder(0) && gouge.distance_mm < 0.0, "{gouge:?}");
}

#[test]
fn the_design_surface_itself_is_no_neighbour() {
    let (surface, plan) = &quick("cyl_R2_A");
    let at = |k: u32| surface.point(f64::from(k / 9) / 40.0, f64::from(k % 9) / 8.0);
    let own = (0..40u32)
        .flat_map(|i| (0..8u32).map(move |j| i * 9 + j))
        .flat_map(|k| [[k, k + 9, k + 1], [k + 1, k + 9, k + 10]]);
    let mesh = Mesh { vertices: (0..41 * 9).map(at).collect(), triangles: own.collect() };
    let none = walls(&mesh, surface, &plan.refined);
    assert!(none.triangles().is_empty());
    let all = checked(&plan.refined, &plan.cutter, &none);
    assert_eq!((all.cutter, all.holder), (None, None), "nothing but its own surface, and no holder");
}
