//! Surfaces and scans of them.

use std::f64::consts::TAU;
use std::sync::Arc;

use geometry::mesh::{Mesh, normal_times_two_areas};
use glam::{DAffine3, DQuat, DVec3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use task::Task;

use crate::Nominal;

/// Noise of the scans (mm).
pub const NOISE: f64 = 0.005;

/// A closed cylinder about Z from z = 0, of `facets` sides.
pub fn drum(radius: f64, height: f64, facets: u32) -> Mesh {
    let ring = |z: f64| {
        (0..facets).map(move |i| {
            let (s, c) = (TAU * f64::from(i) / f64::from(facets)).sin_cos();
            DVec3::new(radius * c, radius * s, z)
        })
    };
    let vertices = ring(0.0).chain(ring(height)).chain([DVec3::ZERO, DVec3::Z * height]).collect();
    let (n, bottom, top) = (facets, 2 * facets, 2 * facets + 1);
    let of_side = |i: u32| {
        let j = (i + 1) % n;
        [[i, j, j + n], [i, j + n, i + n], [bottom, j, i], [top, i + n, j + n]]
    };
    Mesh { vertices, triangles: (0..n).flat_map(of_side).collect() }
}

/// An ellipsoid of these half axes about the origin.
pub fn ellipsoid(half: DVec3) -> Mesh {
    const ROUND: u32 = 96;
    const RINGS: u32 = 47;
    let mut mesh = Mesh::default();
    for i in 1..=RINGS {
        let (s, c) = (0.5 * TAU * f64::from(i) / f64::from(RINGS + 1)).sin_cos();
        mesh.vertices.extend((0..ROUND).map(|k| {
            let (t, u) = (TAU * f64::from(k) / f64::from(ROUND)).sin_cos();
            half * DVec3::new(s * u, s * t, c)
        }));
    }
    mesh.vertices.extend([DVec3::Z * half.z, DVec3::NEG_Z * half.z]);
    let (top, bottom) = (ROUND * RINGS, ROUND * RINGS + 1);
    for k in 0..ROUND {
        let l = (k + 1) % ROUND;
        mesh.triangles.push([top, k, l]);
        for ring in (0..RINGS - 1).map(|i| i * ROUND) {
            let (a, b, c, d) = (ring + k, ring + l, ring + ROUND + k, ring + ROUND + l);
            mesh.triangles.extend([[a, c, d], [a, d, b]]);
        }
        let last = (RINGS - 1) * ROUND;
        mesh.triangles.push([bottom, last + l, last + k]);
    }
    mesh
}

pub fn nominal(mesh: Mesh) -> Nominal {
    assert!(mesh.is_watertight() && mesh.volume() > 0.0);
    Nominal::new(Arc::new(mesh), &Task::default()).unwrap()
}

/// Points of a surface with its normals there, evenly spread by chance.
pub fn points_on(mesh: &Mesh, count: usize, seed: u64) -> Vec<(DVec3, DVec3)> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut sum = 0.0;
    let sums: Vec<f64> = mesh
        .iter_corners()
        .map(|corners| {
            sum += normal_times_two_areas(corners).length();
            sum
        })
        .collect();
    let point = |_| {
        let at = random.random::<f64>() * sum;
        let corners = mesh.corners(sums.partition_point(|s| *s < at).min(sums.len() - 1));
        let (u, v): (f64, f64) = (random.random(), random.random());
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        let [a, b, c] = corners;
        (a + (b - a) * u + (c - a) * v, normal_times_two_areas(corners).normalize())
    };
    (0..count).map(point).collect()
}

/// The points without the 30 % that lie farthest along `direction`.
pub fn without_a_third(points: &[(DVec3, DVec3)], direction: DVec3) -> Vec<(DVec3, DVec3)> {
    let mut heights: Vec<f64> = points.iter().map(|(p, _)| p.dot(direction)).collect();
    heights.sort_by(f64::total_cmp);
    let most = heights[heights.len() * 7 / 10];
    points.iter().filter(|(p, _)| p.dot(direction) <= most).copied().collect()
}

/// A number of the standard normal distribution (G. E. P. Box and M. E. Muller, 1958).
pub fn normal(random: &mut ChaCha8Rng) -> f64 {
    let (u, v): (f64, f64) = (random.random(), random.random());
    (-2.0 * (1.0 - u).ln()).sqrt() * (TAU * v).cos()
}

/// The points with noise of `deviation` (mm) in each coordinate, displaced by `error`.
pub fn scan(points: &[(DVec3, DVec3)], error: &DAffine3, deviation: f64, seed: u64) -> Vec<DVec3> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut noise = || DVec3::new(normal(&mut random), normal(&mut random), normal(&mut random)) * deviation;
    points.iter().map(|(p, _)| error.transform_point3(*p + noise())).collect()
}

/// A displacement by 0.5 mm and a turn by 0.5 degrees about a skew axis through `about`.
pub fn error_about(about: DVec3) -> DAffine3 {
    let turn = DQuat::from_axis_angle(DVec3::new(0.5, -0.7, 0.6).normalize(), 0.5f64.to_radians());
    let shift = DVec3::new(-0.6, 0.5, 0.7).normalize() * 0.5;
    DAffine3::from_translation(about + shift) * DAffine3::from_quat(turn) * DAffine3::from_translation(-about)
}

/// The greatest displacement of the surface along its normals that `motion` makes (mm): what a fit was wrong by.
pub fn wrong_by(points: &[(DVec3, DVec3)], motion: &DAffine3) -> f64 {
    points.iter().map(|(p, n)| n.dot(motion.transform_point3(*p) - *p).abs()).fold(0.0, f64::max)
}
