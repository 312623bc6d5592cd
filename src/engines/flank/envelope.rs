//! Swept envelope of the moving cutter, and a brute-force sweep to check it.
//!
//! The cutter is the hull of spheres around the places of its axis. A sphere at a fixed height touches the envelope
//! where its normal is square to its own motion, and the cone where the normal leans by the half-angle: both together
//! give two grazing points, one on the surface's side. A standing cutter's deviation is that of the sphere's point
//! towards the surface instead, so the two differ by the second order of the angle between both normals.

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use serde::Serialize;

use super::axis_surface::{AxisAt, AxisSurface};
use super::cutter::FlankCutter;
use super::deviation::{DesignGrid, Deviation, Feet, GridPlace};

/// Deviation of the moving cutter, and how it compares with that of the standing one.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EnvelopeCheck {
    /// Deviation of the moving cutter over the same grid.
    pub deviation: Deviation,
    /// Greatest difference to the standing cutter's (mm).
    pub greatest_difference: f64,
    /// Places without a grazing point over them; there the standing cutter's deviation stands.
    pub without: usize,
    /// Least and greatest t at which it grazes over a place; beyond 0 or 1 the path had to go on to do so. A closed
    /// path has every t: 0 and 1.
    pub t_range: [f64; 2],
}

/// The point (mm) where the cutter at `t` grazes its envelope with the sphere around `height` (mm) above its tip, on
/// the side that `normal` points away from; none where the cutter moves along its own axis too steeply to graze.
pub fn grazing_point(
    axis: &AxisSurface,
    cutter: &FlankCutter,
    (t, height): (f64, f64),
    normal: DVec3,
) -> Option<(DVec3, DVec3)> {
    let AxisAt { tip, tip_speed, top, top_speed } = axis.at(t);
    let length = top.distance(tip);
    let along = (top - tip) / length;
    let turning = top_speed - tip_speed;
    let speed = tip_speed + height * (turning - along * along.dot(turning)) / length;
    let climb = speed.dot(along);
    let across = speed - climb * along;
    let (sin, cos) = cutter.half_angle().sin_cos();
    let width = across.length();
    let lean = sin / cos * climb / width;
    if lean.is_nan() || lean.abs() >= 1.0 {
        return None;
    }
    let forward = across / width;
    let aside = along.cross(forward);
    let aside = if aside.dot(normal) > 0.0 { -aside } else { aside };
    let outwards = -sin * along + cos * (lean * forward + (1.0 - lean * lean).sqrt() * aside);
    Some((tip + height * along + cutter.sphere_at(height) * outwards, outwards))
}

/// Deviation of the moving cutter's envelope along the normals of the grid.
pub fn check(
    grid: &DesignGrid,
    axis: &AxisSurface,
    cutter: &FlankCutter,
    (standing, feet): (&Deviation, &Feet),
) -> EnvelopeCheck {
    let places = grid.grid_places();
    let one = |k: usize| envelope_over(axis, cutter, &places[k], feet.at[k]);
    let found: Vec<Option<Grazing>> = (0..places.len()).into_par_iter().with_min_len(64).map(one).collect();
    let counted = grid.counted_places().len();
    let without = found.iter().take(counted).filter(|f| f.is_none_or(|f| f.above.is_none())).count();
    let moving = |f: &Option<Grazing>| f.and_then(|f| f.above);
    let values: Vec<f64> = found.iter().zip(&standing.values).map(|(f, still)| moving(f).unwrap_or(*still)).collect();
    let differences = values.iter().zip(&standing.values).map(|(a, b)| (a - b).abs());
    let greatest_difference = differences.fold(0.0, f64::max);
    let ends = [f64::INFINITY, f64::NEG_INFINITY];
    let t_range = found.iter().flatten().fold(ends, |[low, high], f| [low.min(f.t), high.max(f.t)]);
    let t_range = if axis.is_closed() { [0.0, 1.0] } else { t_range };
    EnvelopeCheck { deviation: grid.figures(values), greatest_difference, without, t_range }
}

/// The moving cutter over a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Grazing {
    /// Parameter t of the path where the cutter grazes there; the path may have to go on past its ends for it.
    pub t: f64,
    /// How far above the place (mm) it cuts: of a path that ends before, how far the cutter at its end does. None if
    /// that one does not reach the place's normal.
    pub above: Option<f64>,
}

/// Where the envelope meets the normal of a place, by Newton's method with differences for derivatives.
pub(super) fn envelope_over(
    axis: &AxisSurface,
    cutter: &FlankCutter,
    place: &GridPlace,
    foot: DVec2,
) -> Option<Grazing> {
    const ROUNDS: usize = 12;
    /// Tangential distance (mm) at which the normal is met.
    const MET: f64 = 1e-8;
    let off = |q: DVec2| {
        let (point, _) = grazing_point(axis, cutter, (q.x, q.y), place.at.normal)?;
        let off = point - place.at.point;
        Some((DVec2::new(off.dot(place.tangents[0]), off.dot(place.tangents[1])), off.dot(place.at.normal)))
    };
    let mut q = DVec2::new(foot.x, foot.y * axis.at(foot.x).length());
    for _ in 0..ROUNDS {
        let (here, above) = off(q)?;
        if here.abs().max_element() < MET {
            // Before its start and after its end the path does not cut: the cutter standing there does.
            let end = if axis.is_closed() { q.x } else { q.x.clamp(0.0, 1.0) };
            let line = (place.at.point, place.at.normal);
            let standing = || entry(&axis.at(end), cutter, line, [f64::NEG_INFINITY, f64::INFINITY]);
            return Some(Grazing { t: q.x, above: if end == q.x { Some(above) } else { standing() } });
        }
        let (by_t, by_h) = (1e-6, 1e-5);
        let a = (off(q + DVec2::new(by_t, 0.0))?.0 - here) / by_t;
        let b = (off(q + DVec2::new(0.0, by_h))?.0 - here) / by_h;
        let det = a.perp_dot(b);
        let step = DVec2::new(here.perp_dot(b), a.perp_dot(here)) / det;
        if !step.is_finite() || step.x.abs() > 0.5 {
            return None;
        }
        q -= step;
    }
    None
}

/// Where a line enters the cone around an axis: the lesser root of |d|^2 - h^2 = (r0 + h tan alpha)^2, d the way from
/// the tip and h its part along the axis.
pub(super) fn entry(
    at: &AxisAt,
    cutter: &FlankCutter,
    (point, normal): (DVec3, DVec3),
    [lowest, highest]: [f64; 2],
) -> Option<f64> {
    let along = at.axis();
    let tan = cutter.half_angle().tan();
    let (d, h, by_h) = (point - at.tip, (point - at.tip).dot(along), normal.dot(along));
    let (radius, by_radius) = (cutter.radius_mm + h * tan, by_h * tan);
    let a = 1.0 - by_h * by_h - by_radius * by_radius;
    let b = d.dot(normal) - h * by_h - radius * by_radius;
    let c = d.length_squared() - h * h - radius * radius;
    let inner = b * b - a * c;
    if a <= 0.0 || inner.is_nan() || inner < 0.0 {
        return None;
    }
    let [s, leaves] = [-1.0, 1.0].map(|sign| (-b + sign * inner.sqrt()) / a);
    let height = h + s * by_h;
    (leaves > 0.0 && cutter.radius_at(height) > 0.0 && (lowest..=highest).contains(&height)).then_some(s)
}
