//! H-edges: edges that a tip would have and no cutter makes.
//!
//! Where a mold's edge is convex the tip's is concave. A cutter makes a concave edge only if its flat end does, along a
//! horizontal straight edge between two planes (which wire erosion makes too); others split the region (P3, section
//! 4.3).

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

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
/// Distance within which ends of edges are one point, and upright edges one edge in plan (mm).
const TOGETHER: f64 = 1e-3;
/// Greatest turn from one edge of a chain to the next.
const MOST_TURN_DEG: f64 = 45.0;

/// Concave edges of a tip that stand above one another, or one that is slanted; normals are outwards.
pub type HEdge = Edge;

/// H-edges that run on from one another: points of a polyline in the burn frame (mm), each side of which is an edge. A
/// closed one ends where it begins.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EdgeChain(pub Vec<DVec3>);

impl EdgeChain {
    /// Number of its edges.
    pub fn edges(&self) -> usize {
        self.0.len().saturating_sub(1)
    }

    /// Length (mm).
    pub fn length(&self) -> f64 {
        self.0.windows(2).map(|side| side[0].distance(side[1])).sum()
    }
}

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

/// The edges as chains, the longest first. Edges with a common end are of one chain where they go on in about the same
/// direction; where several do, the straightest way is taken.
pub fn chains(edges: &[HEdge]) -> Vec<EdgeChain> {
    // Ends are numbered: those of edge e are 2 e and 2 e + 1.
    let point = |end: usize| edges[end / 2].ends[end % 2];
    let out = |end: usize| edges[end / 2].along() * [-1.0, 1.0][end % 2];
    let ends = 0..2 * edges.len();
    let mut by_x: Vec<usize> = ends.clone().collect();
    by_x.sort_by(|a, b| point(*a).x.total_cmp(&point(*b).x).then(a.cmp(b)));
    let mut meetings: Vec<(f64, [usize; 2])> = Vec::new();
    for (i, &a) in by_x.iter().enumerate() {
        for &b in by_x[i + 1..].iter().take_while(|b| point(**b).x - point(a).x <= TOGETHER) {
            let straight = -out(a).dot(out(b));
            let is_met = a / 2 != b / 2 && point(a).distance(point(b)) <= TOGETHER;
            if is_met && straight >= MOST_TURN_DEG.to_radians().cos() {
                meetings.push((straight, [a.min(b), a.max(b)]));
            }
        }
    }
    meetings.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut next: Vec<Option<usize>> = vec![None; ends.len()];
    for (_, [a, b]) in meetings {
        if next[a].is_none() && next[b].is_none() {
            (next[a], next[b]) = (Some(b), Some(a));
        }
    }
    let mut is_taken = vec![false; edges.len()];
    let mut chains = Vec::new();
    // From the ends of open chains first, so that closed ones are what remains.
    for start in ends.clone().filter(|end| next[*end].is_none()).chain(ends) {
        let (mut points, mut end) = (Vec::new(), Some(start));
        while let Some(from) = end.filter(|end| !is_taken[end / 2]) {
            is_taken[from / 2] = true;
            if points.is_empty() {
                points.push(point(from));
            }
            points.push(point(from ^ 1));
            end = next[from ^ 1];
        }
        chains.extend((!points.is_empty()).then_some(EdgeChain(points)));
    }
    chains.sort_by(|a: &EdgeChain, b| b.length().total_cmp(&a.length()));
    chains
}

#[cfg(test)]
mod tests {
    use super::*;

    fn edge(from: DVec3, to: DVec3) -> HEdge {
        HEdge { ends: [from, to], normals: [DVec3::X, DVec3::Y] }
    }

    #[test]
    fn edges_that_run_on_are_one_chain_and_corners_and_branches_end_it() {
        // A quarter of a circle of 6 edges in any order and direction, with an upright edge at its end.
        let at = |i: usize| 2.0 * DVec2::from_angle(std::f64::consts::FRAC_PI_2 * i as f64 / 6.0).extend(0.0);
        let mut edges: Vec<HEdge> = [3, 0, 5, 2, 4, 1].map(|i| edge(at(i), at(i + 1))).to_vec();
        edges[2].ends.reverse();
        edges.push(edge(at(6), at(6) + DVec3::Z));
        let found = chains(&edges);
        assert_eq!(found.iter().map(EdgeChain::edges).collect::<Vec<_>>(), [6, 1]);
        let side = 4.0 * (std::f64::consts::PI / 24.0).sin();
        assert!((found[0].length() - 6.0 * side).abs() < 1e-12 && (found[1].length() - 1.0).abs() < 1e-12);
        let ends = [found[0].0[0], found[0].0[6]];
        assert!(ends == [at(0), at(6)] || ends == [at(6), at(0)], "{ends:?}");
        // Of three edges at a point the two that go straight on are one chain.
        let slanted = edge(DVec3::ZERO, DVec3::new(1.0, 0.5, 0.0));
        let found = chains(&[edge(-DVec3::X, DVec3::ZERO), slanted, edge(DVec3::X, DVec3::ZERO)]);
        assert_eq!(found.iter().map(EdgeChain::edges).collect::<Vec<_>>(), [2, 1]);
        assert_eq!((found[0].length(), chains(&[]).len()), (2.0, 0));
    }

    #[test]
    fn a_closed_chain_ends_where_it_begins() {
        let at = |i: usize| DVec2::from_angle(std::f64::consts::TAU * i as f64 / 12.0).extend(0.0);
        let edges: Vec<HEdge> = (0..12).map(|i| edge(at(i), at((i + 1) % 12))).collect();
        let [chain] = &chains(&edges)[..] else { panic!("one chain") };
        assert_eq!((chain.edges(), chain.0[0]), (12, chain.0[12]));
    }
}
