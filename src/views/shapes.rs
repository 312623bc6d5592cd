//! Meshes for the screen, made once where the work is done and not where it is shown.

use std::sync::Arc;

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

/// The triangles of the blisk within a pitch of the channel's middle and below its shroud, so that one sees into it.
fn sector(blisk: &Mesh, channel: &Channel) -> Mesh {
    let half = 1.6 * std::f64::consts::PI / channel.blades as f64;
    let kept = |[a, b, c]: [glam::DVec3; 3]| {
        let middle = Cylindrical::from_point((a + b + c) / 3.0);
        let (_, shroud) = channel.radii_at(middle.x);
        let below_shroud = !channel.shrouded || middle.r < shroud - 0.05;
        middle.theta.abs() < half && below_shroud
    };
    let triangles: Vec<[u32; 3]> =
        blisk.triangles.iter().zip(blisk.iter_corners()).filter(|(_, c)| kept(*c)).map(|(t, _)| *t).collect();
    compacted(&Mesh { vertices: blisk.vertices.clone(), triangles })
}

/// The mesh without the vertices that no triangle uses.
fn compacted(mesh: &Mesh) -> Mesh {
    let mut place = vec![u32::MAX; mesh.vertices.len()];
    let mut vertices = Vec::new();
    let mut keep = |v: u32| {
        let known = &mut place[v as usize];
        if *known == u32::MAX {
            *known = vertices.len() as u32;
            vertices.push(mesh.vertices[v as usize]);
        }
        *known
    };
    let triangles = mesh.triangles.iter().map(|t| t.map(&mut keep)).collect();
    Mesh { vertices, triangles }
}
