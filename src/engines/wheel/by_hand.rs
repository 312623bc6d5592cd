//! Points on hub, shroud and blades that are given by hand, about the axis of a wheel.

use glam::{DVec2, DVec3};

use super::options::BliskOptions;
use geometry::frame::{Cylindrical, Frame};
use geometry::nurbs::NurbsCurve;

/// Points of a curve nearer together than this share of its length are one.
const APART: f64 = 0.005;
/// Pieces of a curve through points.
const PIECES: usize = 64;

/// What is given by hand, in a frame whose X is the axis.
#[derive(Debug, Clone, Default)]
pub(crate) struct ByHand {
    /// Places (x, r) of the points on the hub and on the shroud or the tips, in their order in the options.
    pub ends: [Vec<DVec2>; 2],
    /// The curves through them, from end to end.
    pub curves: [Option<Vec<DVec2>>; 2],
    /// Points on blades.
    pub blades: Vec<Cylindrical>,
}

impl ByHand {
    /// The points of `options` in `frame`.
    pub fn new(options: &BliskOptions, frame: &Frame) -> Self {
        let about = |points: &[[f64; 3]]| -> Vec<Cylindrical> {
            points.iter().map(|p| Cylindrical::from_point(frame.from_parent(DVec3::from(*p)))).collect()
        };
        let places = |points| about(points).into_iter().map(|c| DVec2::new(c.x, c.r)).collect();
        let ends: [Vec<DVec2>; 2] = [places(&options.hub_points_mm), places(&options.shroud_points_mm)];
        Self { curves: ends.each_ref().map(|points| curve(points)), ends, blades: about(&options.blade_points_mm) }
    }

    /// Places (x, r) in the passage or at its border; none if nothing is given. Hub and shroud may be given beyond the
    /// blades: of their curves these are the middles.
    pub fn places(&self) -> Vec<DVec2> {
        if !self.blades.is_empty() {
            return self.blades.iter().map(|c| DVec2::new(c.x, c.r)).collect();
        }
        match &self.curves {
            [Some(hub), Some(shroud)] => vec![0.5 * (hub[PIECES / 2] + shroud[PIECES / 2])],
            [Some(curve), None] | [None, Some(curve)] => vec![curve[PIECES / 2]],
            [None, None] => self.ends.concat(),
        }
    }
}

/// The curve through points on it in any order, as a polygon of [`PIECES`]; none through fewer than two places. The
/// points are ordered along the line through the two that are furthest apart, as those of a curve that turns by less
/// than half a turn are.
fn curve(points: &[DVec2]) -> Option<Vec<DVec2>> {
    let pairs = points.iter().enumerate().flat_map(|(i, a)| points[i + 1..].iter().map(move |b| (*a, *b)));
    let (from, to) = pairs.max_by(|(a, b), (c, d)| a.distance_squared(*b).total_cmp(&c.distance_squared(*d)))?;
    let way = to - from;
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| way.dot(*a).total_cmp(&way.dot(*b)).then(a.x.total_cmp(&b.x)).then(a.y.total_cmp(&b.y)));
    sorted.dedup_by(|b, a| a.distance(*b) <= APART * way.length());
    if sorted.len() < 2 || way.length() < 1e-9 {
        return None;
    }
    let spatial: Vec<DVec3> = sorted.iter().map(|p| p.extend(0.0)).collect();
    let curve = NurbsCurve::through(&spatial, (sorted.len() - 1).min(3)).ok()?;
    let [start, end] = curve.domain();
    let at = |i: usize| curve.point(start + (end - start) * i as f64 / PIECES as f64);
    Some((0..=PIECES).map(|i| at(i).truncate()).collect())
}

/// The point of a polygon that is nearest to `place`, and its distance (mm).
pub(crate) fn nearest(polygon: &[DVec2], place: DVec2) -> (DVec2, f64) {
    let foot = |pair: &[DVec2]| {
        let way = pair[1] - pair[0];
        let t = ((place - pair[0]).dot(way) / way.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        pair[0] + t * way
    };
    let feet = polygon.windows(2).map(foot).map(|foot| (foot, foot.distance(place)));
    feet.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((DVec2::NAN, f64::INFINITY))
}

/// The radius of a curve at `x`; beyond its ends it goes straight on.
pub(crate) fn radius_at(polygon: &[DVec2], x: f64) -> Option<f64> {
    let at = |pair: &[DVec2]| {
        let way = pair[1] - pair[0];
        (way.x != 0.0).then(|| pair[0].y + (x - pair[0].x) / way.x * way.y)
    };
    let holds = |pair: &&[DVec2]| (pair[0].x.min(pair[1].x)..=pair[0].x.max(pair[1].x)).contains(&x);
    let (first, last) = (polygon.get(..2)?, polygon.get(polygon.len() - 2..)?);
    let is_first = (first[0].x - x).abs() < (last[1].x - x).abs();
    at(polygon.windows(2).find(holds).unwrap_or(if is_first { first } else { last }))
}
