//! The closest points of two meshes, by branch and bound over their hierarchies.

use glam::{DMat3, DVec3};

use super::bvh::Bvh;
use super::triangle_distance::{ClosestPoints, triangle_distance};

/// Bound on what rounding changes of a distance (mm): hundreds of times the error of coordinates of metres.
pub const ROUNDING: f64 = 1e-9;

/// A node of the first hierarchy and one of the second.
pub type NodePair = [u32; 2];

/// The closest points of two meshes and the triangles they are on.
#[derive(Debug, Clone, Copy)]
pub struct NearestPair {
    /// The points, in the coordinates of the second mesh, and their distance (mm).
    pub points: ClosestPoints,
    /// Numbers of the triangles.
    pub triangles: [u32; 2],
}

/// The closest points of `moved`, moved by `u -> rotation * u + shift`, and of `fixed`; neither is empty. `guess` is a
/// pair of triangles thought to be close: the better it is, the faster the answer.
pub fn nearest_pair(moved: &Bvh, fixed: &Bvh, placement: (&DMat3, DVec3), guess: Option<[u32; 2]>) -> NearestPair {
    let search = Search { moved, fixed, placement };
    let triangles = guess.unwrap_or([moved.node(0).triangle, fixed.node(0).triangle]);
    search.nearer(search.at(triangles), f64::NEG_INFINITY)
}

/// Two triangles nearer to each other than `limit` (mm), if there are such. `guess` is as for [`nearest_pair`].
pub fn nearer_than(
    moved: &Bvh,
    fixed: &Bvh,
    placement: (&DMat3, DVec3),
    limit: f64,
    guess: Option<[u32; 2]>,
) -> Option<[u32; 2]> {
    let search = Search { moved, fixed, placement };
    if let Some(guess) = guess.filter(|&guess| search.at(guess).points.distance < limit) {
        return Some(guess);
    }
    // Bounds may be rounded up by less.
    let just_beyond = ClosestPoints { distance: limit + ROUNDING, ..ClosestPoints::NONE };
    let found = search.nearer(NearestPair { points: just_beyond, triangles: [0; 2] }, limit);
    (found.points.distance < limit).then_some(found.triangles)
}

struct Search<'a> {
    moved: &'a Bvh,
    fixed: &'a Bvh,
    placement: (&'a DMat3, DVec3),
}

impl Search<'_> {
    fn at(&self, triangles: [u32; 2]) -> NearestPair {
        let (rotation, shift) = self.placement;
        let [m, f] = triangles;
        let moved = self.moved.corners(m).map(|u| *rotation * u + shift);
        NearestPair { points: triangle_distance(&moved, self.fixed.corners(f)), triangles }
    }

    /// The closest points, or `best` if there are none closer; once they are closer than `enough` (mm) no closer ones
    /// are looked for.
    fn nearer(&self, mut best: NearestPair, enough: f64) -> NearestPair {
        let Self { moved, fixed, placement: (rotation, shift) } = *self;
        let mut stack = vec![(0.0, [0, 0])];
        while let Some((bound, pair)) = stack.pop() {
            if best.points.distance < enough {
                break;
            }
            if bound >= best.points.distance {
                continue;
            }
            let Some(halves) = halves(moved, fixed, pair) else {
                let found = self.at([moved.node(pair[0]).triangle, fixed.node(pair[1]).triangle]);
                if found.points.distance < best.points.distance {
                    best = found;
                }
                continue;
            };
            let bounded = halves.map(|pair| {
                let (m, f) = (moved.node(pair[0]), fixed.node(pair[1]));
                let centers = (*rotation * m.bounds.center + shift).distance(f.bounds.center);
                let spheres = centers - m.radius - f.radius;
                if spheres >= best.points.distance {
                    return (spheres, pair);
                }
                (m.bounds.placed(rotation, shift).separation(&f.bounds).length(), pair)
            });
            // The closer half is looked at first.
            let [first, second] = bounded;
            stack.extend(if first.0 <= second.0 { [second, first] } else { [first, second] });
        }
        best
    }
}

/// The pair with its larger node halved; None for two leaves.
pub fn halves(moved: &Bvh, fixed: &Bvh, [m, f]: NodePair) -> Option<[NodePair; 2]> {
    let of_moved = || moved.children(m).map(|halves| halves.map(|half| [half, f]));
    let of_fixed = || fixed.children(f).map(|halves| halves.map(|half| [m, half]));
    if moved.node(m).radius >= fixed.node(f).radius {
        of_moved().or_else(of_fixed)
    } else {
        of_fixed().or_else(of_moved)
    }
}
