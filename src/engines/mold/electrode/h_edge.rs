//! H-edges: edges that a tip would have and no cutter makes.
//!
//! Where a mold's edge is convex the tip's is concave. A cutter makes a concave edge only if its flat end does, along a
//! horizontal straight edge between two planes (which wire erosion makes too); others split the region (P3, section
//! 4.3).

use glam::DVec2;

use super::params::DividedAt;
use crate::cutter::{Cutter, CutterKind, CutterLibrary};
use geometry::mesh::{Edge, Mesh};

/// Turn of a concave edge from which on it is one; below, it is a facet of a rounding.
const LEAST_TURN_DEG: f64 = 20.0;
/// Turn of the shallowest inner edges that are looked at.
const SHALLOWEST_DEG: f64 = 2.0;
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

/// How the inner edges of tips are milled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Milling {
    /// Least radius of all cutters (mm).
    pub least: f64,
    /// Least radius of those with a ball end (mm); infinite without any.
    pub least_ball: f64,
    /// What may stay in an edge (mm).
    pub tolerance: f64,
}

impl Milling {
    /// With the cutters of a library.
    pub fn by(cutters: &CutterLibrary, tolerance: f64) -> Self {
        let least = |is: fn(CutterKind) -> bool| {
            let all = cutters.needed().into_iter().filter(|c| is(c.kind()));
            all.map(Cutter::radius).fold(f64::INFINITY, f64::min)
        };
        Self { least: least(|_| true), least_ball: least(|kind| kind == CutterKind::Ball), tolerance }
    }

    /// Thickness of what the best of them leaves in a long inner edge that no flat end follows (mm).
    fn left_in(&self, edge: &Edge) -> f64 {
        let half = 0.5 * edge.normals[0].angle_between(edge.normals[1]);
        let radius = if is_upright(edge) { self.least } else { self.least_ball };
        radius * (1.0 / half.cos().max(1e-9) - 1.0)
    }
}

/// The inner edges of a tip, down to shallow ones.
pub fn inner_edges(tip: &Mesh) -> Vec<HEdge> {
    tip.concave_edges(SHALLOWEST_DEG.to_radians())
}

/// The H-edges among the inner edges of a tip, the longest first, upright ones above one another together; with
/// [`DividedAt::EveryEdge`] also those that cutters mill.
pub fn h_edges(inner: &[HEdge], at: DividedAt, milling: &Milling) -> Vec<HEdge> {
    // A flat end mills a level edge on a floor.
    let is_on_floor = |edge: &Edge| {
        let is_level = (edge.ends[1] - edge.ends[0]).z.abs() <= LEVEL * edge.length();
        is_level && edge.normals.iter().any(|n| n.truncate().length() <= LEVEL)
    };
    let is_sharp = |edge: &&HEdge| edge.normals[0].dot(edge.normals[1]) < LEAST_TURN_DEG.to_radians().cos();
    let is_milled = |edge: &HEdge| is_on_floor(edge) || milling.left_in(edge) <= milling.tolerance;
    let is_asked = |edge: &&HEdge| (at == DividedAt::EveryEdge || !is_milled(edge)) && edge.length() > SHORTEST;
    joined(inner.iter().filter(is_sharp).filter(is_asked).copied().collect())
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
