use std::sync::Arc;

use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rayon::prelude::*;

use super::DistanceField;
use crate::exact::ExactMesh;
use crate::fixtures::folded_box;
use crate::mesh::{Bounds, Mesh};
use task::Task;

/// A block with a notch: convex edges, and a concave corner that distances have a crease in.
fn notched_block() -> Mesh {
    // The L-shaped outline extruded along z.
    let outline = [[0.0, 0.0], [4.0, 0.0], [4.0, 1.5], [1.5, 1.5], [1.5, 4.0], [0.0, 4.0]];
    let vertices = [0.0, 4.0].iter().flat_map(|&z| outline.iter().map(move |p| DVec3::new(p[0], p[1], z))).collect();
    let caps = [[0, 1, 2], [0, 2, 3], [0, 3, 5], [3, 4, 5]];
    let mut triangles: Vec<[u32; 3]> = caps.iter().flat_map(|&[a, b, c]| [[a, c, b], [a + 6, b + 6, c + 6]]).collect();
    for i in 0..6 {
        let j = (i + 1) % 6;
        triangles.extend([[i, j, j + 6], [i, j + 6, i + 6]]);
    }
    Mesh { vertices, triangles }
}

fn field(mesh: &Mesh, region: Bounds) -> (DistanceField, Arc<ExactMesh>) {
    let exact = Arc::new(ExactMesh::new(mesh).unwrap());
    let field = DistanceField::build(mesh, exact.clone(), region, 0.2, &Task::default()).unwrap();
    (field, exact)
}

#[test]
fn near_the_surface_the_error_keeps_the_stated_accuracy() {
    let mesh = notched_block();
    assert!(mesh.is_watertight());
    // Turned, so that no face lies along the cells.
    let turn = glam::DMat3::from_rotation_z(0.3) * glam::DMat3::from_rotation_x(0.5);
    let mesh = mesh.mapped(|p| turn * p);
    let (field, exact) = field(&mesh, mesh.bounds().grown(1.0));
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(7);
    let (min, size) = (field.bounds().min, field.bounds().size());
    let (mut near, mut worst) = (0, 0.0f64);
    for _ in 0..100_000 {
        let p = min + size * DVec3::new(random.random(), random.random(), random.random());
        let (expected, got) = (exact.signed_distance(p), field.value(p).unwrap());
        if expected.abs() <= DistanceField::NEAR {
            near += 1;
            worst = worst.max((got - expected).abs());
        } else {
            let allowed = DistanceField::ACCURACY + 0.08 * (expected.abs() - DistanceField::NEAR);
            assert!((got - expected).abs() <= allowed, "{p}: {got} instead of {expected}");
        }
    }
    assert!(near > 10_000);
    assert!(worst <= DistanceField::ACCURACY, "worst error {worst} mm");
}

/// Winding number of a closed surface around `p` as the sum of the triangles' solid angles.
fn solid_angles(mesh: &Mesh, p: DVec3) -> f64 {
    let half_angle = |corners: [DVec3; 3]| {
        let [a, b, c] = corners.map(|q| (q - p).normalize());
        a.dot(b.cross(c)).atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
    };
    mesh.iter_corners().map(half_angle).sum::<f64>() / std::f64::consts::TAU
}

#[test]
fn folds_turn_no_sign_further_away_than_they_are_thick() {
    // The way back above or below the way there: turned inside out, or overlapping.
    for thickness in [0.04, -0.04] {
        let turn = glam::DMat3::from_rotation_z(0.3) * glam::DMat3::from_rotation_x(0.5);
        let mesh = folded_box(thickness).mapped(|p| turn * p);
        assert!(mesh.is_watertight());
        let (field, exact) = field(&mesh, mesh.bounds().grown(0.8));
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        let (min, size) = (field.bounds().min, field.bounds().size());
        let mut misled = 0;
        for _ in 0..100_000 {
            let p = min + size * DVec3::new(random.random(), random.random(), random.random());
            let by_normals = exact.signed_distance(p);
            let distance = by_normals.abs();
            let (got, gradient) = field.value_and_gradient(p).unwrap();
            let allowed = DistanceField::ACCURACY + 0.08 * (distance - DistanceField::NEAR).max(0.0);
            assert!((got.abs() - distance).abs() <= allowed, "{p}: {got}, the distance is {distance}");
            if distance > thickness.abs() {
                let inside = solid_angles(&mesh, p).abs() > 0.5;
                assert_eq!(got < 0.0, inside, "{p}: {got}");
                assert_eq!(field.value(p).unwrap() < 0.0, inside, "{p}");
                let ahead = field.value(p + gradient.normalize_or_zero() * 1e-3).unwrap_or(got);
                let jump = (ahead - got).abs() - 1e-3;
                assert!(distance > DistanceField::NEAR || jump < 2.0 * DistanceField::ACCURACY, "{p}: {jump}");
                misled += usize::from((by_normals < 0.0) != inside);
            }
        }
        assert!(misled > 100, "the normals mislead at {misled} places only");
    }
}

#[test]
fn the_gradient_points_away_from_the_surface_with_slope_one() {
    let mesh = Mesh::cuboid(DVec3::splat(3.0));
    let (field, _) = field(&mesh, mesh.bounds().grown(1.0));
    for p in [DVec3::new(1.3, 1.6, 3.3), DVec3::new(1.3, 1.6, 2.8), DVec3::new(3.2, 3.3, 3.1)] {
        let (d, gradient) = field.value_and_gradient(p).unwrap();
        let step = 1e-3;
        let ahead = field.value(p + gradient.normalize() * step).unwrap();
        assert!((gradient.length() - 1.0).abs() < 0.05, "{p}: {gradient}");
        assert!((ahead - d - step).abs() < 0.1 * step, "{p}");
    }
}

#[test]
fn outside_its_bounds_the_field_says_nothing() {
    let mesh = Mesh::cuboid(DVec3::ONE);
    let (field, _) = field(&mesh, mesh.bounds().grown(0.5));
    let beyond = field.bounds().max + 0.01;
    for p in [beyond, DVec3::splat(-0.51), DVec3::NAN, DVec3::INFINITY] {
        assert_eq!(field.value(p), None, "{p}");
    }
}

#[test]
fn the_field_is_the_same_whoever_asks_first() {
    let mesh = notched_block();
    let region = mesh.bounds().grown(0.5);
    let places: Vec<DVec3> = (0..40_000)
        .map(|i| {
            region.min
                + region.size() * DVec3::new(f64::from(i % 34), f64::from(i / 34 % 34), f64::from(i / 1156)) / 35.0
        })
        .collect();
    let in_turn: Vec<u64> = {
        let (field, _) = field(&mesh, region);
        places.iter().map(|&p| field.value(p).unwrap().to_bits()).collect()
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(4).build().unwrap();
    let (other, _) = field(&mesh, region);
    let backwards: Vec<u64> =
        pool.install(|| places.par_iter().rev().map(|&p| other.value(p).unwrap().to_bits()).collect());
    assert!(in_turn.into_iter().eq(backwards.into_iter().rev()));
}

#[test]
fn a_field_too_large_for_memory_is_refused() {
    let mesh = Mesh::cuboid(DVec3::splat(1e3));
    let exact = ExactMesh::new(&mesh).unwrap().into();
    let answer = DistanceField::build(&mesh, exact, mesh.bounds(), 0.2, &Task::default());
    assert!(matches!(answer, Err(super::FieldError::TooLarge { .. })));
}
