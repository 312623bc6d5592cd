//! Metal within a passage that is none of its walls: a pin, a strut, a lump, a part left in place.

use glam::DVec3;
use rayon::prelude::*;

use super::super::channel::Channel;
use super::super::passage::Passage;
use geometry::frame::{Cylindrical, angle_near};
use geometry::mesh::{Bounds, Mesh};

/// Share of the passage's height that metal must be off walls, hub and shroud not to belong to one of them.
const OFF_SHARE: f64 = 0.06;
/// Least distance that it must be off them (mm).
const LEAST_OFF: f64 = 0.1;
/// Share of the blades' span at either edge that is not looked at: round edges of neighbours reach into it.
const EDGE: f64 = 0.05;
/// Distance of the places on a triangle, as a share of the passage's height.
const STEP: f64 = 0.2;
/// Most pieces that the edge of a triangle is divided into to look at places between its corners.
const MOST_PIECES: f64 = 12.0;

/// The place of `mesh`, in W, that is deepest in the passage of `channel`, and how far it is off the nearest of walls, hub
/// and shroud (mm), if that is too far to belong to one of them.
pub(super) fn obstruction(channel: &Channel, mesh: &Mesh) -> Option<(DVec3, f64)> {
    let passage = Passage::new(channel)?;
    let around = Bounds::of(channel.low.points.iter().chain(&channel.high.points).copied());
    let [from, to] = passage.span;
    let (from, to) = (from + EDGE * (to - from), to - EDGE * (to - from));
    // How far a place is off the nearest surface; none outside the passage, or where it may belong to a surface.
    let depth = |p: DVec3| {
        let [along, height] = passage.along_and_height(p);
        if !(from..=to).contains(&along) {
            return None;
        }
        let [hub, shroud] = channel.line_at(along).ends;
        let Cylindrical { r, theta, .. } = Cylindrical::from_point(p);
        let [low, high] = passage.between(along, height.clamp(hub, shroud));
        let theta = angle_near(theta, 0.5 * (low + high));
        let off = ((theta - low) * r).min((high - theta) * r).min(height - hub).min(shroud - height);
        (off > LEAST_OFF.max(OFF_SHARE * (shroud - hub))).then_some(off)
    };
    let step = STEP * channel.middle().height();
    let of_triangle = |i: usize| {
        let corners = mesh.corners(i);
        if !Bounds::of(corners).intersects(&around) {
            return None;
        }
        let places = places(corners, step).filter(|p| around.distance_to(*p) == 0.0);
        places.filter_map(|p| Some((p, depth(p)?))).max_by(|a, b| a.1.total_cmp(&b.1))
    };
    // Of places as deep the first, on any number of threads.
    let deeper = |a: (DVec3, f64), b: (DVec3, f64)| if b.1 > a.1 { b } else { a };
    (0..mesh.triangles.len()).into_par_iter().filter_map(of_triangle).reduce_with(deeper)
}

/// Places over a triangle, no further apart than `step` (mm) where that takes no more than [`MOST_PIECES`] to an edge.
fn places([a, b, c]: [DVec3; 3], step: f64) -> impl Iterator<Item = DVec3> {
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    let pieces = (longest / step).ceil().clamp(1.0, MOST_PIECES) as u32;
    let share = move |i: u32| f64::from(i) / f64::from(pieces);
    (0..=pieces).flat_map(move |i| (0..=pieces - i).map(move |k| a + share(i) * (b - a) + share(k) * (c - a)))
}
