//! A frustum, and the least distance from it to a triangle.
//!
//! The signed distance to a convex solid is convex, inside as well as outside (S. Boyd, L. Vandenberghe, Convex
//! Optimization, 2004, section 8.1 and exercise 8.5), and changes by no more than the way. So it has one least value on
//! a triangle, and a tangent plane at any place shows a half of the triangle that cannot hold it. The triangle is cut
//! at its centroid again and again (A. Yu. Levin, On an algorithm for the minimization of convex functions, Soviet
//! Mathematics Doklady 6, 1965): each cut takes away 1 - 1/e of the area at least, whatever the triangle's shape and
//! size. A long sliver and a large face that the flutes touch along a line take as few cuts as any other.
//!
//! Guaranteed: the distance is that of the place named, and no place is nearer by more than [`EXACT`], but for
//! rounding.

use glam::{DVec2, DVec3};

use super::path::FlankPose;

/// No place of a triangle is nearer than the one found by more than this (mm).
pub const EXACT: f64 = 1e-5;

/// Most cuts of one triangle. They leave e^-90 of the area, less than rounding does: the distance is then exact to
/// e^-45 of its range on the triangle.
const MOST_CUTS: usize = 200;

/// A piece of a cone around an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frustum {
    /// Heights of its ends above the tip (mm).
    pub heights: [f64; 2],
    /// Radii of its ends (mm).
    pub radii: [f64; 2],
}

impl Frustum {
    /// Signed distance (mm) from it at `pose` to `p`, negative inside, and its gradient.
    pub fn distance(&self, pose: &FlankPose, p: DVec3) -> (f64, DVec3) {
        let d = p - pose.tip;
        let h = d.dot(pose.axis);
        let across = d - h * pose.axis;
        let r = across.length();
        let out = if r > 0.0 { across / r } else { pose.axis.any_orthonormal_vector() };
        let [low, high] = self.heights;
        let [below, above] = self.radii;
        // The slant side as a line in the half-plane of r and h.
        let (rise, run) = (high - low, above - below);
        let length = rise.hypot(run);
        let (normal_r, normal_h) = (rise / length, -run / length);
        let side = (r - below) * normal_r + (h - low) * normal_h;
        let faces = [(low - h, [0.0, -1.0]), (h - high, [0.0, 1.0]), (side, [normal_r, normal_h])];
        // So near outside that what rounding leaves of a way to it tells no direction, its faces tell one.
        let near_a_face = faces.iter().all(|f| f.0 <= 1e-7);
        if near_a_face {
            let (distance, [by_r, by_h]) =
                faces.into_iter().fold((f64::NEG_INFINITY, [0.0; 2]), |a, b| if b.0 > a.0 { b } else { a });
            return (distance, by_r * out + by_h * pose.axis);
        }
        // Outside: the nearest point of the three sides.
        let along = (((r - below) * run + (h - low) * rise) / (length * length)).clamp(0.0, 1.0);
        let feet = [[r.min(below), low], [r.min(above), high], [below + along * run, low + along * rise]];
        let way = |[fr, fh]: [f64; 2]| [r - fr, h - fh];
        let size = |f: &[f64; 2]| way(*f)[0].hypot(way(*f)[1]);
        let near = feet.into_iter().min_by(|a, b| size(a).total_cmp(&size(b))).unwrap_or(feet[2]);
        let (distance, [by_r, by_h]) = (size(&near), way(near));
        (distance, (by_r * out + by_h * pose.axis) / distance.max(f64::MIN_POSITIVE))
    }
}

/// The least distance (mm) from `frustum` at `pose` to a triangle and a place that has it, if it is less than `most`.
/// Inside, distances are negative by the depth.
pub fn nearest_on(corners: [DVec3; 3], frustum: &Frustum, pose: &FlankPose, most: f64) -> Option<(f64, DVec3)> {
    least_over(corners, most, |p| frustum.distance(pose, p))
}

/// The least value below `most` of a convex function that is given with a slope, over a triangle, and where.
fn least_over(
    [a, b, c]: [DVec3; 3],
    most: f64,
    mut value_and_slope: impl FnMut(DVec3) -> (f64, DVec3),
) -> Option<(f64, DVec3)> {
    // Shares of two sides from `a`: in them no triangle is a sliver.
    let (ab, ac) = (b - a, c - a);
    let mut best = None;
    let mut least = most;
    let mut left = vec![DVec2::ZERO, DVec2::X, DVec2::Y];
    let mut cut = Vec::with_capacity(8);
    for _ in 0..MOST_CUTS {
        let middle = centroid(&left);
        let p = a + middle.x * ab + middle.y * ac;
        let (value, slope) = value_and_slope(p);
        if value < least {
            (least, best) = (value, Some((value, p)));
        }
        let slope = DVec2::new(slope.dot(ab), slope.dot(ac));
        // Convex: nowhere below its tangent plane. What that holds above the least by now is of no more use.
        let above = |q: DVec2| value + slope.dot(q - middle) - (least - EXACT);
        below_zero(&left, above, &mut cut);
        std::mem::swap(&mut left, &mut cut);
        if left.is_empty() {
            break;
        }
    }
    best
}

/// The part of a convex polygon where a linear function is negative; empty if there is none.
fn below_zero(polygon: &[DVec2], linear: impl Fn(DVec2) -> f64, part: &mut Vec<DVec2>) {
    part.clear();
    let Some(last) = polygon.last() else { return };
    let (mut before, mut at_before) = (*last, linear(*last));
    for &corner in polygon {
        let at_corner = linear(corner);
        if (at_before < 0.0) != (at_corner < 0.0) {
            part.push(before.lerp(corner, at_before / (at_before - at_corner)));
        }
        if at_corner < 0.0 {
            part.push(corner);
        }
        (before, at_before) = (corner, at_corner);
    }
}

/// The centroid of a convex polygon; of one without area the mean of its corners.
fn centroid(polygon: &[DVec2]) -> DVec2 {
    let first = polygon[0];
    let (mut area, mut moment) = (0.0, DVec2::ZERO);
    for side in polygon[1..].windows(2) {
        let (s, t) = (side[0] - first, side[1] - first);
        let twice = s.perp_dot(t);
        area += twice;
        moment += twice * (s + t);
    }
    let middle = first + moment / (3.0 * area);
    let (low, high) = polygon.iter().fold((first, first), |(low, high), p| (low.min(*p), high.max(*p)));
    // Rounding must not carry it out of a polygon that is thinner than that.
    let is_within = middle.cmpge(low).all() && middle.cmple(high).all();
    if is_within { middle } else { polygon.iter().sum::<DVec2>() / polygon.len() as f64 }
}

#[cfg(test)]
mod tests;
