//! Where an electrode's tip stands in plan.

use glam::DVec2;

use crate::outline::Outline;
use crate::plane;
use crate::plane::Shape;

/// Corners of the polygon that stands for a disc.
const CORNERS: usize = 24;

/// The convex hull of points, counter-clockwise; none if they lie on a line.
pub fn hull(points: &[DVec2]) -> Option<Outline> {
    let mut points = points.to_vec();
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    let mut ring: Vec<DVec2> = Vec::new();
    let chain = |ring: &mut Vec<DVec2>, from: usize, p: DVec2| {
        while ring.len() >= from + 2
            && (ring[ring.len() - 1] - ring[ring.len() - 2]).perp_dot(p - ring[ring.len() - 1]) <= 0.0
        {
            ring.pop();
        }
        ring.push(p);
    };
    points.iter().for_each(|p| chain(&mut ring, 0, *p));
    let lower = ring.len().saturating_sub(1);
    points.iter().rev().skip(1).for_each(|p| chain(&mut ring, lower, *p));
    ring.pop();
    Outline::new(ring).filter(|o| o.area() > 0.0)
}

/// The polygon around a disc of this radius.
fn disc(radius: f64) -> [DVec2; CORNERS] {
    let step = std::f64::consts::TAU / CORNERS as f64;
    let around = radius / (0.5 * step).cos();
    std::array::from_fn(|i| DVec2::from_angle(i as f64 * step) * around)
}

/// Everything within `by` of convex pieces, each given by its corners; at most 1 % further.
pub fn grown_pieces(pieces: impl Iterator<Item = Vec<DVec2>>, by: f64) -> Vec<Shape> {
    let disc = disc(by);
    let grown =
        |corners: Vec<DVec2>| hull(&corners.iter().flat_map(|p| disc.iter().map(move |d| *p + *d)).collect::<Vec<_>>());
    plane::union(&pieces.filter_map(grown).collect::<Vec<_>>(), &[])
}

fn band(outlines: &[Outline], width: f64) -> Vec<Outline> {
    let sides = outlines.iter().flat_map(Outline::sides).map(|side| side.to_vec());
    grown_pieces(sides, width).into_iter().flatten().collect()
}

/// Everything within `by` of a set.
pub fn grown(outlines: &[Outline], by: f64) -> Vec<Outline> {
    plane::outlines(plane::union(outlines, &band(outlines, by)))
}

/// Everything of a set that is further than `by` from its boundary.
pub fn shrunk(outlines: &[Outline], by: f64) -> Vec<Outline> {
    plane::difference(outlines, &band(outlines, by)).into_iter().flatten().collect()
}

/// Whether a set is nowhere as thick as `least` (mm), but where its arms meet.
pub fn is_thin(outlines: &[Outline], least: f64) -> bool {
    /// Share of the least size from which on a tip is as thick as it.
    const NEARLY: f64 = 0.98;
    /// Share of a tip's area that is as thick as the least size if the tip is.
    const THIN: f64 = 0.5;
    let half = 0.5 * NEARLY * least;
    half > 0.0 && plane::area(&grown(&shrunk(outlines, half), half)) < THIN * plane::area(outlines)
}

/// The half of the plane on the side of `through` to which `outward` does not point, as far as `reach`.
pub fn half_plane(through: DVec2, outward: DVec2, reach: f64) -> Vec<Outline> {
    let along = outward.perp() * reach;
    let back = -outward * 2.0 * reach;
    let corners = vec![through - along, through + along, through + along + back, through - along + back];
    Outline::new(corners).into_iter().collect()
}
