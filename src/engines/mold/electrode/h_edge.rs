//! H-edges: edges that a tip would have and no cutter makes.
//!
//! Where a mold's edge is convex the tip's is concave. A cutter makes a concave edge only if its flat end does, along a
//! horizontal straight edge between two planes (which wire erosion makes too); others split the region (P3, section 4.3).

use std::collections::HashMap;

use glam::{DVec2, DVec3};

use geometry::mesh::{Mesh, unit_normal};

/// Turn of a concave edge from which on it is one; below, it is a facet of a rounding.
const LEAST_TURN_DEG: f64 = 20.0;
/// Height per length below which an edge is horizontal.
const LEVEL: f64 = 1e-3;
/// Length below which an edge is none (mm).
const SHORTEST: f64 = 0.02;
/// Distance in plan within which edges are one chain (mm).
const TOGETHER: f64 = 1e-3;

/// Concave edges of a tip that stand above one another, or one that is slanted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HEdge {
    /// Ends (mm).
    pub ends: [DVec3; 2],
    /// The unit normals of the faces on both sides, outwards.
    pub normals: [DVec3; 2],
}

impl HEdge {
    /// Length (mm).
    pub fn length(&self) -> f64 {
        self.ends[0].distance(self.ends[1])
    }

    /// Where it is in plan (mm).
    pub fn place(&self) -> DVec2 {
        self.ends[0].midpoint(self.ends[1]).truncate()
    }

    /// Whether it stands upright.
    pub fn is_upright(&self) -> bool {
        (self.ends[1] - self.ends[0]).truncate().length() < TOGETHER
    }
}

/// The H-edges of a tip, the longest first, upright ones above one another together.
pub fn h_edges(tip: &Mesh) -> Vec<HEdge> {
    let mut faces: HashMap<(u32, u32), u32> = HashMap::new();
    for (i, &[a, b, c]) in tip.triangles.iter().enumerate() {
        [(a, b), (b, c), (c, a)].into_iter().for_each(|edge| {
            faces.insert(edge, i as u32);
        });
    }
    let normal = |face: u32| unit_normal(tip.corners(face as usize));
    let mut found: Vec<HEdge> = Vec::new();
    for (i, &[a, b, c]) in tip.triangles.iter().enumerate() {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let Some(other) = faces.get(&(to, from)).filter(|_| from < to) else { continue };
            let ends = [from, to].map(|v| tip.vertices[v as usize]);
            let edge = HEdge { ends, normals: [normal(i as u32), normal(*other)] };
            if is_one(&edge) {
                found.push(edge);
            }
        }
    }
    joined(found)
}

fn is_one(edge: &HEdge) -> bool {
    let [n, m] = edge.normals;
    let along = edge.ends[1] - edge.ends[0];
    let is_concave = n.cross(m).dot(along) < 0.0;
    let is_level = along.z.abs() <= LEVEL * along.length();
    is_concave && !is_level && edge.length() > SHORTEST && n.dot(m) < LEAST_TURN_DEG.to_radians().cos()
}

fn joined(found: Vec<HEdge>) -> Vec<HEdge> {
    let mut chains: Vec<HEdge> = Vec::new();
    for edge in found {
        let same = |c: &&mut HEdge| c.is_upright() && edge.is_upright() && c.place().distance(edge.place()) < TOGETHER;
        match chains.iter_mut().find(same) {
            Some(chain) => {
                let mut all = [chain.ends[0], chain.ends[1], edge.ends[0], edge.ends[1]];
                all.sort_by(|a, b| a.z.total_cmp(&b.z));
                chain.ends = [all[0], all[3]];
            }
            None => chains.push(edge),
        }
    }
    chains.sort_by(|a, b| b.length().total_cmp(&a.length()));
    chains
}
