//! H-edges: edges that a tip would have and no cutter makes.
//!
//! Where a mold's edge is convex the tip's is concave. A cutter makes a concave edge only if its flat end does, along a
//! horizontal straight edge between two planes (which wire erosion makes too); others split the region (P3, section
//! 4.3).

use glam::DVec2;

use super::params::DividedAt;
use geometry::mesh::{Edge, Mesh};

/// Turn of a concave edge from which on it is one; below, it is a facet of a rounding.
const LEAST_TURN_DEG: f64 = 20.0;
/// Height per length below which an edge is horizontal.
const LEVEL: f64 = 1e-3;
/// Length below which an edge is none (mm).
const SHORTEST: f64 = 0.02;
/// Distance in plan within which edges are one chain (mm).
const TOGETHER: f64 = 1e-3;

/// Concave edges of a tip that stand above one another, or one that is slanted; normals are outwards.
pub type HEdge = Edge;

/// Where an edge is in plan (mm).
pub fn place(edge: &HEdge) -> DVec2 {
    edge.ends[0].midpoint(edge.ends[1]).truncate()
}

/// Whether an edge stands upright.
pub fn is_upright(edge: &HEdge) -> bool {
    (edge.ends[1] - edge.ends[0]).truncate().length() < TOGETHER
}

/// The H-edges of a tip, the longest first, upright ones above one another together; with [`DividedAt::EveryEdge`] also
/// the concave edges that a flat end mills.
pub fn h_edges(tip: &Mesh, at: DividedAt) -> Vec<HEdge> {
    let is_level = |edge: &Edge| (edge.ends[1] - edge.ends[0]).z.abs() <= LEVEL * edge.length();
    let mut found = tip.concave_edges(LEAST_TURN_DEG.to_radians());
    found.retain(|edge| (at == DividedAt::EveryEdge || !is_level(edge)) && edge.length() > SHORTEST);
    joined(found)
}

fn joined(found: Vec<HEdge>) -> Vec<HEdge> {
    let mut chains: Vec<HEdge> = Vec::new();
    for edge in found {
        let same = |c: &&mut HEdge| is_upright(c) && is_upright(&edge) && place(c).distance(place(&edge)) < TOGETHER;
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
