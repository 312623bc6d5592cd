//! Meshes for the screen, made once where the work is done and not where it is shown.

use std::collections::HashMap;
use std::f64::consts::PI;
use std::sync::Arc;

use glam::DVec3;

use crate::blisk::channel::{Channel, ChannelWall};
use crate::geometry::frame::Cylindrical;
use crate::geometry::mesh::Mesh;
use crate::render::mesh::RenderMesh;

/// What is shown of a channel.
#[derive(Debug, Clone)]
pub struct ChannelShapes {
    /// The wall on the side of smaller theta, in W.
    pub low: Arc<RenderMesh>,
    /// The wall on the side of greater theta, in W.
    pub high: Arc<RenderMesh>,
    /// The part of the blisk about the channel with its shroud taken off, in W.
    pub sector: Arc<RenderMesh>,
}

/// The shapes of `channel` in `blisk`, which is in W.
pub fn channel_shapes(blisk: &Mesh, channel: &Channel) -> ChannelShapes {
    ChannelShapes {
        low: Arc::new(RenderMesh::new(&wall_mesh(&channel.low, true))),
        high: Arc::new(RenderMesh::new(&wall_mesh(&channel.high, false))),
        sector: Arc::new(RenderMesh::new(&sector(blisk, channel))),
    }
}

/// The grid of a wall as triangles, seen from within the channel.
fn wall_mesh(wall: &ChannelWall, is_low: bool) -> Mesh {
    let index = |u: usize, v: usize| (u * wall.nv + v) as u32;
    let cells = (1..wall.nu).flat_map(|u| (1..wall.nv).map(move |v| (u, v)));
    let quads = cells.map(|(u, v)| [index(u - 1, v - 1), index(u, v - 1), index(u, v), index(u - 1, v)]);
    let triangles = quads.flat_map(|[a, b, c, d]| if is_low { [[a, c, b], [a, d, c]] } else { [[a, b, c], [a, c, d]] });
    Mesh { triangles: triangles.collect(), vertices: wall.points.clone() }
}

/// The blisk within a pitch of the channel's middle and below its shroud, so that one sees into it. Cut along the planes
/// through the axis, so that its sides are straight.
fn sector(blisk: &Mesh, channel: &Channel) -> Mesh {
    let half = (1.6 * PI / channel.blades as f64).min(0.45 * PI);
    let sides = [half, -half].map(|theta| DVec3::new(0.0, -theta.cos(), -theta.sin()) * theta.signum());
    let above = |corners: &[DVec3; 3]| corners.iter().sum::<DVec3>().z > 0.0;
    let below_shroud = |corners: &[DVec3; 3]| {
        let middle = Cylindrical::from_point(corners.iter().sum::<DVec3>() / 3.0);
        !channel.shrouded || middle.r < channel.radii_at(middle.x).1 - 0.05
    };
    let mut mesh = Mesh::default();
    for corners in blisk.iter_corners().filter(|c| above(c) && below_shroud(c)) {
        let kept = sides.iter().fold(corners.to_vec(), |polygon, side| clipped(&polygon, *side));
        let first = mesh.vertices.len() as u32;
        mesh.triangles.extend((2..kept.len() as u32).map(|i| [first, first + i - 1, first + i]));
        mesh.vertices.extend(kept);
    }
    joined(&mesh)
}

/// The part of a convex polygon on the side of the plane through the origin that `normal` points away from.
fn clipped(polygon: &[DVec3], normal: DVec3) -> Vec<DVec3> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (i, &b) in polygon.iter().enumerate() {
        let a = polygon[(i + polygon.len() - 1) % polygon.len()];
        let (ha, hb) = (normal.dot(a), normal.dot(b));
        if (ha > 0.0) != (hb > 0.0) {
            kept.push(a + (b - a) * (ha / (ha - hb)));
        }
        if hb <= 0.0 {
            kept.push(b);
        }
    }
    kept
}

/// The mesh with equal vertices made one, so that its shading is smooth again.
fn joined(mesh: &Mesh) -> Mesh {
    let mut known: HashMap<[i64; 3], u32> = HashMap::new();
    let mut vertices = Vec::new();
    // A nanometre: what is nearer was one point before the cut.
    let key = |p: DVec3| (p * 1e6).round().to_array().map(|v| v as i64);
    let place: Vec<u32> = mesh
        .vertices
        .iter()
        .map(|p| {
            *known.entry(key(*p)).or_insert_with(|| {
                vertices.push(*p);
                vertices.len() as u32 - 1
            })
        })
        .collect();
    let triangles = mesh.triangles.iter().map(|t| t.map(|v| place[v as usize]));
    Mesh { triangles: triangles.filter(|[a, b, c]| a != b && b != c && c != a).collect(), vertices }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clipped_square_loses_the_half_on_the_side_of_the_normal() {
        let square = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]].map(|[x, y]| DVec3::new(x, y, 5.0));
        let half = clipped(&square, DVec3::X);
        assert_eq!(half.len(), 4);
        assert!(half.iter().all(|p| p.x <= 0.0 && p.z == 5.0));
        let area: f64 = (2..half.len()).map(|i| (half[i - 1] - half[0]).cross(half[i] - half[0]).z / 2.0).sum();
        assert!((area - 2.0).abs() < 1e-12);
        assert!(clipped(&square, DVec3::Z).is_empty() && clipped(&square, DVec3::NEG_Z).len() == 4);
    }
}
