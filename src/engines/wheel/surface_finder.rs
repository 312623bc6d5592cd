//! Classification of points by the surface of the blisk that they lie on, and distances to the walls of the channel.

use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::channel::{Channel, ChannelWall, Surface};
use geometry::exact::{ExactMesh, ExactMeshError};
use geometry::frame::Cylindrical;
use geometry::mesh::Mesh;

/// Distances to the surfaces of one channel, each taken by itself.
pub struct SurfaceFinder {
    channel: Arc<Channel>,
    low: ExactMesh,
    high: ExactMesh,
    /// The obstacles beside the blisk.
    obstacles: Option<ExactMesh>,
}

impl SurfaceFinder {
    /// Distance from a surface up to which a point lies on it (mm): above the chord error of the wall grids, well below
    /// any spark gap.
    const ON_SURFACE: f64 = 0.2;

    /// Distance within which a point lies on an obstacle (mm): rounding.
    const ON_OBSTACLE: f64 = 1e-6;

    /// Prepares the walls of `channel`.
    pub fn new(channel: Arc<Channel>) -> Result<Self, ExactMeshError> {
        let low = ExactMesh::new(&wall_mesh(&channel.low))?;
        let high = ExactMesh::new(&wall_mesh(&channel.high))?;
        let obstacles = channel.obstacles_in_w().map(|mesh| ExactMesh::new(&mesh)).transpose()?;
        Ok(Self { channel, low, high, obstacles })
    }

    /// The surface that the point `p` of the blisk, or of an obstacle beside it, lies on.
    pub fn surface_of(&self, p: DVec3) -> Surface {
        let is_on = |obstacle: &ExactMesh| obstacle.nearest(p).signed_distance.abs() <= Self::ON_OBSTACLE;
        if self.obstacles.as_ref().is_some_and(is_on) {
            return Surface::Obstacle;
        }
        let Cylindrical { x, r, .. } = Cylindrical::from_point(p);
        let place = DVec2::new(x, r);
        let [along, height] = self.channel.along_and_height(place);
        let (line, [front, back]) = (self.channel.line_at(along), self.channel.ends_along());
        let on_line = (line.place(height) - place).length() < Self::ON_SURFACE;
        let on_ring = on_line && along > front - Self::ON_SURFACE && along < back + Self::ON_SURFACE;
        let end_wall = |end: f64| if on_ring { (height - end).abs() } else { f64::INFINITY };
        let ([hub, shroud], [low, high]) = (line.ends.map(end_wall), self.wall_distances(p));
        let closed = if self.channel.shrouded { shroud } else { f64::INFINITY };
        [(low, Surface::LowWall), (high, Surface::HighWall), (hub, Surface::Hub), (closed, Surface::Shroud)]
            .into_iter()
            .filter(|&(distance, _)| distance <= Self::ON_SURFACE)
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map_or(Surface::Elsewhere, |(_, surface)| surface)
    }

    /// The point of the low wall nearest to `p`, in W.
    pub fn nearest_on_low_wall(&self, p: DVec3) -> DVec3 {
        self.low.nearest(p).point
    }

    /// Distances from `p` to the low and to the high wall (mm, never negative).
    pub fn wall_distances(&self, p: DVec3) -> [f64; 2] {
        [&self.low, &self.high].map(|wall| wall.nearest(p).signed_distance.abs())
    }
}

/// The grid of a wall as triangles.
fn wall_mesh(wall: &ChannelWall) -> Mesh {
    let index = |u: usize, v: usize| (u * wall.nv + v) as u32;
    let quads = (1..wall.nu).flat_map(|u| (1..wall.nv).map(move |v| (u, v)));
    let triangles = quads
        .flat_map(|(u, v)| {
            let [a, b, c, d] = [index(u - 1, v - 1), index(u, v - 1), index(u, v), index(u - 1, v)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    Mesh { vertices: wall.points.clone(), triangles }
}
