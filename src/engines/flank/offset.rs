//! Cutter locations that touch the surface at two or three points, P4 (2) to (7).
//!
//! P4 (5) prints the tangent of the half-angle where its own (6) follows from the sine; the sine is right, since Q1 and
//! Q2 are centres of spheres inscribed in the cone.

use glam::{DVec2, DVec3};
use serde::Serialize;

use super::FlankError;
use super::cutter::FlankCutter;
use super::ruled_surface::{RuledSurface, SurfacePlace};

/// Contact that a location was made for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Touch {
    /// Both guides, as was asked for.
    TwoPoints,
    /// Both guides and the surface midway.
    ThreePoints,
    /// No slide along the upper guide makes it touch midway: it is the one that comes nearest to it.
    NearestToThree,
}

/// A place of the cutter.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CutterLocation {
    /// Parameter of the contact on the lower guide.
    pub u0: f64,
    /// Parameter of the contact on the upper guide.
    pub u1: f64,
    /// Contact on the lower guide (mm), on the rim of the bottom circle.
    pub lower_contact: DVec3,
    /// Contact on the upper guide (mm).
    pub upper_contact: DVec3,
    /// The place of the axis over the lower contact (mm), P4's Q1.
    pub q1: DVec3,
    /// The place of the axis over the upper contact (mm), P4's Q2.
    pub q2: DVec3,
    /// Distance from Q2 to the upper contact (mm), P4's x.
    pub upper_radius: f64,
    /// Centre of the bottom circle (mm), P4's O.
    pub tip: DVec3,
    /// Unit vector of the axis, from the lower guide to the upper, P4's I.
    pub axis: DVec3,
    /// Deviation midway between the guides (mm), where it can be measured.
    pub middle_mm: Option<f64>,
    /// Contact of the location.
    pub touch: Touch,
}

/// The location that touches the lower guide at `u0` and the upper at `u1`.
///
/// # Errors
/// [`FlankError::NoLocation`] if no cutter does.
pub fn two_point(surface: &RuledSurface, cutter: &FlankCutter, u0: f64, u1: f64) -> Result<CutterLocation, FlankError> {
    let none = |reason| FlankError::NoLocation { u0, u1, reason };
    let (sin, cos) = cutter.half_angle().sin_cos();
    let (low, high) = (surface.at(u0, 0.0), surface.at(u1, 1.0));
    if low.normal == DVec3::ZERO || high.normal == DVec3::ZERO {
        return Err(none("the surface has no normal there"));
    }
    let lower_radius = cutter.radius_mm / cos;
    let q1 = low.point + lower_radius * low.normal;
    let w = high.point - q1;
    let c1 = w.dot(high.normal) * sin * sin;
    let c2 = lower_radius * lower_radius - w.length_squared() * sin * sin;
    let inner = (lower_radius + c1).powi(2) - c2 * cos * cos;
    if inner.is_nan() || inner < 0.0 {
        return Err(none("the contacts are too near to each other for the cutter's taper"));
    }
    let upper_radius = (lower_radius + c1 + inner.sqrt()) / (cos * cos);
    let q2 = high.point + upper_radius * high.normal;
    let axis = (q2 - q1).normalize_or_zero();
    if axis == DVec3::ZERO {
        return Err(none("both ends of its axis fall together"));
    }
    let tip = q1 - axis * (cutter.radius_mm * sin / cos);
    let contacts = [low, high].map(|place: SurfacePlace| place.point);
    let mut location = CutterLocation {
        u0,
        u1,
        lower_contact: contacts[0],
        upper_contact: contacts[1],
        q1,
        q2,
        upper_radius,
        tip,
        axis,
        middle_mm: None,
        touch: Touch::TwoPoints,
    };
    location.middle_mm = middle(surface, cutter, &location).map(|(deviation, _)| deviation);
    Ok(location)
}

/// Deviation (mm) at the place of the axis whose foot has v = 1/2, and its height above the tip (mm).
pub fn middle(surface: &RuledSurface, cutter: &FlankCutter, location: &CutterLocation) -> Option<(f64, f64)> {
    const ROUNDS: usize = 30;
    let length = (location.q2 - location.tip).length();
    let mut height = 0.5 * length;
    let mut start = DVec2::new(0.5 * (location.u0 + location.u1), 0.5);
    for _ in 0..ROUNDS {
        let p = location.tip + height * location.axis;
        let foot = surface.foot(p, start)?;
        let off = (p - foot.point).dot(foot.normal);
        if (foot.v - 0.5).abs() < 1e-13 {
            return Some((off - cutter.sphere_at(height), height));
        }
        start = DVec2::new(foot.u, foot.v);
        height += (0.5 - foot.v) * foot_slope(surface, location.axis, p, &foot)?;
    }
    let p = location.tip + height * location.axis;
    let foot = surface.foot(p, start)?;
    let is_there = (foot.v - 0.5).abs() < 1e-9;
    is_there.then(|| ((p - foot.point).dot(foot.normal) - cutter.sphere_at(height), height))
}

/// By how much the height along the axis grows with v of the foot.
fn foot_slope(surface: &RuledSurface, axis: DVec3, p: DVec3, foot: &SurfacePlace) -> Option<f64> {
    const STEP: f64 = 1e-6;
    let step = STEP * foot.along_v.length();
    let next = surface.foot(p + step * axis, DVec2::new(foot.u, foot.v))?;
    let slope = (next.v - foot.v) / step;
    (slope.abs() > 1e-9).then(|| 1.0 / slope)
}

/// The location that touches the lower guide at `u0`, the upper guide where it also touches the middle of the surface,
/// with the upper contact within `slide` of `u0`. Where none does, the one nearest to it, marked so.
///
/// # Errors
/// [`FlankError::NoLocation`] if not even two points can be touched.
pub fn three_point(
    surface: &RuledSurface,
    cutter: &FlankCutter,
    u0: f64,
    slide: f64,
) -> Result<CutterLocation, FlankError> {
    /// Distance that counts as touching (mm), where no slide is needed and where the deviation has no change of sign.
    /// On a surface that is flat but for the digits of its guides a slide would follow these.
    const TOUCHING: f64 = 1e-7;
    let plain = two_point(surface, cutter, u0, u0)?;
    if plain.middle_mm.is_some_and(|m| m.abs() < TOUCHING) {
        return Ok(CutterLocation { touch: Touch::ThreePoints, ..plain });
    }
    let at = |u1: f64| two_point(surface, cutter, u0, u1).ok().and_then(|l| l.middle_mm.map(|m| (u1, m, l)));
    let (_, off, location) = slide_to_touch(&at, u0, slide, TOUCHING).unwrap_or((u0, f64::INFINITY, plain));
    let touch = if off.abs() < TOUCHING { Touch::ThreePoints } else { Touch::NearestToThree };
    Ok(CutterLocation { touch, ..location })
}

/// The slide within `slide` of `u0` that is nearest to it among those that touch midway to within `touching` (mm); if
/// there is none, the one with the least deviation. A deviation can change its sign in a jump, without a touch: then it
/// is looked for further on.
pub(super) fn slide_to_touch(at: &dyn Fn(f64) -> Option<Slide>, u0: f64, slide: f64, touching: f64) -> Option<Slide> {
    const LOOKS: [i32; 2] = [10, 100];
    let mut nearest: Option<Slide> = at(u0);
    let keep = |nearest: &mut Option<Slide>, found: Slide| {
        if nearest.is_none_or(|n| found.1.abs() < n.1.abs()) {
            *nearest = Some(found);
        }
    };
    for looks in LOOKS {
        // From the middle outwards, so that the change of sign nearest to u0 is taken.
        let mut last = [at(u0); 2];
        for i in 1..=looks {
            for (last, sign) in last.iter_mut().zip([1.0, -1.0]) {
                let Some(next) = at(u0 + sign * slide * f64::from(i) / f64::from(looks)) else { continue };
                if let Some(last) = last.filter(|last| last.1 * next.1 <= 0.0) {
                    let found = root(at, last, next);
                    if found.1.abs() < touching {
                        return Some(found);
                    }
                    keep(&mut nearest, found);
                }
                *last = Some(next);
                keep(&mut nearest, next);
            }
        }
    }
    nearest
}

/// u1, the deviation midway (mm) and the location.
pub(super) type Slide = (f64, f64, CutterLocation);

/// The slide with the least deviation midway, between two whose deviations differ in sign: the Illinois variant of the
/// method of false position, which never leaves the bracket.
fn root(at: &dyn Fn(f64) -> Option<Slide>, first: Slide, second: Slide) -> Slide {
    const ROUNDS: usize = 60;
    let ((mut a, mut fa), (mut b, mut fb)) = ((first.0, first.1), (second.0, second.1));
    let mut best = if fa.abs() < fb.abs() { first } else { second };
    for _ in 0..ROUNDS {
        if best.1.abs() < 1e-14 || (b - a).abs() < 1e-15 {
            break;
        }
        let guess = b - fb * (b - a) / (fb - fa);
        let Some(next) = at(guess) else { break };
        if next.1.abs() < best.1.abs() {
            best = next;
        }
        if next.1 * fb < 0.0 {
            (a, fa) = (b, fb);
        } else {
            fa *= 0.5;
        }
        (b, fb) = (next.0, next.1);
    }
    best
}
