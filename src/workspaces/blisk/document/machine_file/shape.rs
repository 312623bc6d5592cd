//! Boxes and cylinders as closed meshes.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use geometry::mesh::Mesh;

/// Sides of the prism that stands for a cylinder.
const SIDES: u32 = 96;

/// The box of this size about `centre` (mm).
pub(super) fn cuboid(size: DVec3, centre: DVec3) -> Mesh {
    let least = centre - 0.5 * size;
    let mut mesh = Mesh::cuboid(size);
    mesh.vertices.iter_mut().for_each(|p| *p = least + *p);
    mesh
}

/// A prism about the cylinder with this radius and length (mm) about `centre`, its axis along coordinate `axis`. It
/// is circumscribed, so that no point of the cylinder is outside it; it is larger by 0.054 percent of the radius at
/// most.
pub(super) fn cylinder(radius: f64, length: f64, axis: usize, centre: DVec3) -> Mesh {
    let outer = radius / (PI / f64::from(SIDES)).cos();
    let rim = |k: u32, along: f64| {
        let (sine, cosine) = (TAU * f64::from(k) / f64::from(SIDES)).sin_cos();
        let mut p = DVec3::ZERO;
        (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (along, outer * cosine, outer * sine);
        centre + p
    };
    let ends = [-0.5 * length, 0.5 * length];
    let mut vertices: Vec<DVec3> =
        ends.iter().flat_map(|&along| (0..SIDES).map(move |k| (k, along))).map(|(k, a)| rim(k, a)).collect();
    for along in ends {
        let mut p = DVec3::ZERO;
        p[axis] = along;
        vertices.push(centre + p);
    }
    let (low, high) = (2 * SIDES, 2 * SIDES + 1);
    let side = |k: u32| {
        let next = (k + 1) % SIDES;
        let (far, far_next) = (k + SIDES, next + SIDES);
        [[k, next, far_next], [k, far_next, far], [low, next, k], [high, far, far_next]]
    };
    Mesh { vertices, triangles: (0..SIDES).flat_map(side).collect() }
}
