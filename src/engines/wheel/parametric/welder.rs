//! Meshes from corner points.

use std::collections::HashMap;

use geometry::mesh::Mesh;
use glam::DVec3;

/// Joins corner points that coincide to 1e-7 mm and drops triangles that collapse.
#[derive(Default)]
pub(crate) struct Welder {
    pub mesh: Mesh,
    ids: HashMap<[i64; 3], u32>,
}

impl Welder {
    fn id(&mut self, p: DVec3) -> u32 {
        let key = (p * 1e7).round().to_array().map(|c| c as i64);
        *self.ids.entry(key).or_insert_with(|| {
            self.mesh.vertices.push(p);
            self.mesh.vertices.len() as u32 - 1
        })
    }

    pub fn triangle(&mut self, corners: [DVec3; 3]) {
        let ids = corners.map(|p| self.id(p));
        if ids[0] != ids[1] && ids[1] != ids[2] && ids[2] != ids[0] {
            self.mesh.triangles.push(ids);
        }
    }

    /// The patch `point(i, j)`, turning clockwise from i to j seen from outside.
    pub fn patch(&mut self, ni: usize, nj: usize, point: impl Fn(usize, usize) -> DVec3) {
        for i in 0..ni {
            for j in 0..nj {
                let [a, b, c, d] = [point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)];
                self.triangle([a, c, b]);
                self.triangle([a, d, c]);
            }
        }
    }

    /// The quadrilateral with these corners.
    pub fn quad(&mut self, [a, b, c, d]: [DVec3; 4]) {
        self.triangle([a, b, c]);
        self.triangle([a, c, d]);
    }
}
