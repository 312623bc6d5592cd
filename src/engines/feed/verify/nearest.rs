//! The closest points of electrode and blisk at one instant, by branch and bound over two hierarchies.

use glam::{DMat3, DVec3};

use super::ROUNDING;
use geometry::bvh::Bvh;
use geometry::triangle_distance::{ClosestPoints, triangle_distance};

/// A node of the electrode's hierarchy and one of the blisk's.
pub(super) type NodePair = [u32; 2];

/// The closest points of two meshes (first: electrode, second: blisk, both in W) and the triangles they are on.
#[derive(Debug, Clone, Copy)]
pub(super) struct Nearest {
    pub points: ClosestPoints,
    pub triangles: [u32; 2],
}

/// The closest points of `blisk` and of `electrode` moved by `u -> rotation * u + shift`. `guess` is a pair of
/// triangles thought to be close: the better it is, the faster the answer.
pub(super) fn nearest(electrode: &Bvh, blisk: &Bvh, placement: (&DMat3, DVec3), guess: Option<[u32; 2]>) -> Nearest {
    let search = Search { electrode, blisk, placement };
    let triangles = guess.unwrap_or([electrode.node(0).triangle, blisk.node(0).triangle]);
    search.nearer(search.at(triangles), f64::NEG_INFINITY)
}

/// Two triangles nearer to each other than `limit` (mm), if there are such. `guess` is as for [`nearest`].
pub(super) fn nearer_than(
    electrode: &Bvh,
    blisk: &Bvh,
    placement: (&DMat3, DVec3),
    limit: f64,
    guess: Option<[u32; 2]>,
) -> Option<[u32; 2]> {
    let search = Search { electrode, blisk, placement };
    if let Some(guess) = guess.filter(|&guess| search.at(guess).points.distance < limit) {
        return Some(guess);
    }
    // Bounds may be rounded up by less.
    let just_beyond = ClosestPoints { distance: limit + ROUNDING, ..ClosestPoints::NONE };
    let found = search.nearer(Nearest { points: just_beyond, triangles: [0; 2] }, limit);
    (found.points.distance < limit).then_some(found.triangles)
}

struct Search<'a> {
    electrode: &'a Bvh,
    blisk: &'a Bvh,
    placement: (&'a DMat3, DVec3),
}

impl Search<'_> {
    fn at(&self, triangles: [u32; 2]) -> Nearest {
        let (rotation, shift) = self.placement;
        let [e, b] = triangles;
        let moved = self.electrode.corners(e).map(|u| *rotation * u + shift);
        Nearest { points: triangle_distance(&moved, self.blisk.corners(b)), triangles }
    }

    /// The closest points, or `best` if there are none closer; once they are closer than `enough` (mm) no closer ones
    /// are looked for.
    fn nearer(&self, mut best: Nearest, enough: f64) -> Nearest {
        let Self { electrode, blisk, placement: (rotation, shift) } = *self;
        let mut stack = vec![(0.0, [0, 0])];
        while let Some((bound, pair)) = stack.pop() {
            if best.points.distance < enough {
                break;
            }
            if bound >= best.points.distance {
                continue;
            }
            let Some(halves) = halves(electrode, blisk, pair) else {
                let found = self.at([electrode.node(pair[0]).triangle, blisk.node(pair[1]).triangle]);
                if found.points.distance < best.points.distance {
                    best = found;
                }
                continue;
            };
            let bounded = halves.map(|pair| {
                let (e, b) = (electrode.node(pair[0]), blisk.node(pair[1]));
                let centers = (*rotation * e.bounds.center + shift).distance(b.bounds.center);
                let spheres = centers - e.radius - b.radius;
                if spheres >= best.points.distance {
                    return (spheres, pair);
                }
                (e.bounds.placed(rotation, shift).separation(&b.bounds).length(), pair)
            });
            // The closer half is looked at first.
            let [first, second] = bounded;
            stack.extend(if first.0 <= second.0 { [second, first] } else { [first, second] });
        }
        best
    }
}

/// The pair with its larger node halved; None for two leaves.
pub(super) fn halves(electrode: &Bvh, blisk: &Bvh, [e, b]: NodePair) -> Option<[NodePair; 2]> {
    let of_electrode = || electrode.children(e).map(|halves| halves.map(|half| [half, b]));
    let of_blisk = || blisk.children(b).map(|halves| halves.map(|half| [e, half]));
    if electrode.node(e).radius >= blisk.node(b).radius {
        of_electrode().or_else(of_blisk)
    } else {
        of_blisk().or_else(of_electrode)
    }
}
