//! Curves of edges: lines, circles and B-splines along chains of sides.

use std::collections::BTreeSet;

use geometry::circle::Circle;
use glam::DVec3;
use rayon::prelude::*;
use task::{Cancelled, Task};

use super::spline::{Curve, Knots, ON_SIDE};
use super::surface::{Axes, Surface, meet};

/// Points that an edge on a cylinder or cone is judged by, at least.
const LEAST_POINTS: usize = 17;
/// Share of the tolerance within which a curve stays on planes, cylinders and cones beside it.
const ON_SURFACE: f64 = 0.02;
/// Share of the tolerance within which a curve passes the points of its chain.
const ON_POINTS: f64 = 0.25;
/// Share of the tolerance within which a curve stays with the sides between these points.
const ON_SIDES: f64 = 0.6;
/// Times that spans of a curve are halved at most.
const HALVINGS: usize = 9;
/// Times that the spans of a strip are halved at most.
const MOST_HALVINGS: usize = 16;
/// Share of the tolerance within which the curves of a strip follow its lines.
const ON_LINE: f64 = 0.4;
/// Places between two points at which a spline is judged, the first point counted.
const PLACES: usize = 3;

/// The form of an edge.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Form {
    /// The straight line between the ends.
    Line,
    /// Counter-clockwise about z from the first end to the second.
    Circle {
        /// Centre and axis.
        axes: Axes,
        /// Radius (mm).
        radius: f64,
    },
    /// The spline of the edge.
    Spline,
}

/// The way of an edge along the skin.
pub(super) struct Course<'a> {
    /// The planes, cylinders and cones beside it.
    pub(super) surfaces: Vec<&'a Surface>,
    /// Whether there is a free form beside it.
    pub(super) is_at_free: bool,
    /// Points of the chain, the ends included (mm).
    pub(super) line: Vec<DVec3>,
    /// The tolerance of the file (mm).
    pub(super) tolerance: f64,
}

/// The curve of an edge.
#[derive(Debug, Clone)]
pub(super) struct EdgeCurve {
    /// Form.
    pub(super) form: Form,
    /// The same curve as a spline; beside free forms it is the one that is written.
    pub(super) spline: Curve,
    /// Parameters on the spline of the points of the chain.
    pub(super) parameters: Vec<f64>,
    /// Greatest distance from the planes, cylinders and cones beside it (mm).
    pub(super) gap: f64,
    /// The point of the chain at which the curve has to be divided, where it cannot follow the chain as a whole.
    pub(super) split: Option<usize>,
}

/// Points along an edge with their parameters.
struct Points {
    at: Vec<DVec3>,
    parameters: Vec<f64>,
    /// Numbers of the points that are those of the chain.
    of_chain: Vec<usize>,
}

impl Course<'_> {
    /// The simplest curve that stays within its shares of the tolerance.
    pub(super) fn curve(&self) -> EdgeCurve {
        let (first, last) = (self.line[0], self.line[self.line.len() - 1]);
        let points = self.points();
        let base = points.at.iter().map(|&p| self.gap(p)).fold(0.0, f64::max);
        let gap = (ON_SURFACE * self.tolerance).clamp(1e-6, 1e-3).max(1.5 * base);
        if self.is_straight(gap) {
            let spline = Curve::line(first, last);
            let gap = (0..=8).map(|k| self.gap(first.lerp(last, f64::from(k) / 8.0))).fold(0.0, f64::max);
            return EdgeCurve { form: Form::Line, spline, parameters: chord_parameters(&self.line), gap, split: None };
        }
        let circle = if self.is_at_free { None } else { self.circle(&points.at, gap) };
        let mut found = self.spline(&points, gap);
        if let Some(circle) = circle {
            (found.form, found.split) = (circle, None);
            found.gap = found.gap.min(gap);
        }
        found
    }

    /// Points of the chain, and where it lies on a cylinder or cone, places between them too, which are moved to where
    /// the surfaces meet.
    fn points(&self) -> Points {
        let is_round = self.surfaces.iter().any(|s| s.axis().is_some());
        let sides = (self.line.len() - 1).max(1);
        let pieces = if is_round { LEAST_POINTS.div_ceil(sides).max(2) } else { 1 };
        let (mut at, mut of_chain) = (vec![self.line[0]], vec![0]);
        for pair in self.line.windows(2) {
            for k in 1..pieces {
                let p = pair[0].lerp(pair[1], k as f64 / pieces as f64);
                let q = meet(&self.surfaces, p);
                let far = (0.3 * pair[0].distance(pair[1])).max(4.0 * self.tolerance);
                at.push(if q.is_finite() && q.distance(p) <= far { q } else { p });
            }
            of_chain.push(at.len());
            at.push(pair[1]);
        }
        Points { parameters: chord_parameters(&at), at, of_chain }
    }

    fn is_straight(&self, gap: f64) -> bool {
        let (a, b) = (self.line[0], self.line[self.line.len() - 1]);
        let Some(along) = (b - a).try_normalize() else { return false };
        let is_between_planes =
            !self.is_at_free && self.surfaces.len() == 2 && self.surfaces.iter().all(|s| s.axis().is_none());
        let off = gap.max(ON_POINTS * self.tolerance);
        let is_rising = self.line.windows(2).all(|w| (w[1] - w[0]).dot(along) > 0.0);
        (is_rising || is_between_planes)
            && self.line.iter().all(|&p| (p - a).reject_from_normalized(along).length() <= off)
            && (0..=8).all(|k| self.gap(a.lerp(b, f64::from(k) / 8.0)) <= gap)
    }

    fn gap(&self, p: DVec3) -> f64 {
        self.surfaces.iter().map(|s| s.gap(p)).fold(0.0, f64::max)
    }

    /// The circle through the points, exactly about the axis of a cylinder or cone if it is one of its.
    fn circle(&self, points: &[DVec3], gap: f64) -> Option<Form> {
        if points.len() < 4 {
            return None;
        }
        let mut circle = Circle::through(points)?;
        // The points turn to and fro about a centre far away.
        let extent = points.iter().map(|p| p.distance(points[0])).fold(0.0, f64::max);
        if circle.radius > 50.0 * extent {
            return None;
        }
        for surface in &self.surfaces {
            let Some((axis, radius)) = surface.axis().zip(surface.radius_at(circle.centre)) else { continue };
            let on_axis = axis.origin + axis.z * (circle.centre - axis.origin).dot(axis.z);
            let is_its = on_axis.distance(circle.centre) < 10.0 * gap && axis.z.cross(circle.normal).length() < 1e-3;
            if is_its {
                circle = Circle { centre: on_axis, normal: axis.z * axis.z.dot(circle.normal).signum(), radius };
                break;
            }
        }
        let swept: DVec3 = points.windows(2).map(|w| (w[0] - circle.centre).cross(w[1] - circle.centre)).sum();
        let normal = if swept.dot(circle.normal) < 0.0 { -circle.normal } else { circle.normal };
        let x = (points[0] - circle.centre).reject_from_normalized(normal).try_normalize()?;
        let axes = Axes { origin: circle.centre, x, z: normal };
        let on_circle = |p: DVec3| axes.point(axes.local(p).truncate().extend(0.0).normalize_or_zero() * circle.radius);
        let is_on = |&p: &DVec3| on_circle(p).distance(p) <= gap && self.gap(on_circle(p)) <= gap;
        let angles: Vec<f64> = points[1..].iter().map(|&p| angle(&axes, p)).collect();
        let is_rising = angles.first().is_some_and(|a| *a > 0.0) && angles.windows(2).all(|w| w[0] < w[1]);
        let is_circle = is_rising && points.iter().all(is_on);
        is_circle.then_some(Form::Circle { axes, radius: circle.radius })
    }

    /// A spline with as few spans as are needed.
    fn spline(&self, points: &Points, gap: f64) -> EdgeCurve {
        let least = 0.5 * points.parameters.windows(2).map(|w| w[1] - w[0]).fold(1.0, f64::min);
        let line = Curve::line(self.line[0], self.line[self.line.len() - 1]);
        let mut knots = Knots::unit();
        let mut best = (f64::INFINITY, line, f64::INFINITY, 0);
        for _ in 0..=HALVINGS {
            let Some(curve) = Curve::fitted(knots.clone(), &points.parameters, &points.at) else { break };
            let breaks = knots.breaks();
            let mut is_failing = vec![false; breaks.len() - 1];
            let (mut worst, mut off) = ((0.0f64, 0), 0.0f64);
            for (k, (u, excess, away)) in self.excesses(&curve, points, gap).into_iter().enumerate() {
                off = off.max(away);
                if excess > worst.0 {
                    worst = (excess, k);
                }
                let span = breaks.partition_point(|b| *b <= u).clamp(1, breaks.len() - 1) - 1;
                is_failing[span] |= excess > 1.0;
            }
            if worst.0 < best.0 {
                best = (worst.0, curve, off, worst.1 / PLACES);
            }
            let next = knots.halved(|span| is_failing[span] && breaks[span + 1] - breaks[span] > least);
            if worst.0 <= 1.0 || next == knots || next.count() > 2 * points.at.len() + 8 {
                break;
            }
            knots = next;
        }
        let (excess, spline, gap, at) = best;
        let parameters = points.of_chain.iter().map(|&k| points.parameters[k]).collect();
        let split = (excess > 1.5 && self.line.len() > 2).then(|| {
            let nearest = points.of_chain.partition_point(|&k| k <= at);
            nearest.clamp(1, self.line.len() - 2)
        });
        EdgeCurve { form: Form::Spline, spline, parameters, gap, split }
    }

    /// Places along a curve: parameter, by how much what is allowed is exceeded there, and distance from the surfaces.
    fn excesses(&self, curve: &Curve, points: &Points, gap: f64) -> Vec<(f64, f64, f64)> {
        let mut found = Vec::with_capacity(PLACES * points.at.len());
        for (k, pair) in points.parameters.windows(2).enumerate() {
            let [a, b] = [points.at[k], points.at[k + 1]];
            for j in 0..PLACES {
                let u = pair[0] + (pair[1] - pair[0]) * j as f64 / PLACES as f64;
                let p = curve.at(u);
                let away = self.gap(p);
                let stray = if j == 0 {
                    p.distance(a) / (ON_POINTS * self.tolerance)
                } else {
                    from_side(p, a, b) / (ON_SIDES * self.tolerance)
                };
                found.push((u, stray.max(away / gap), away));
            }
        }
        found
    }
}

/// Whether points lie in order on the straight line from the first to the last, within the share of the tolerance for
/// edges on planes.
pub(super) fn is_straight(line: &[DVec3], tolerance: f64) -> bool {
    let (a, b) = (line[0], line[line.len() - 1]);
    let Some(along) = (b - a).try_normalize() else { return false };
    line.windows(2).all(|w| (w[1] - w[0]).dot(along) > 0.0)
        && line.iter().all(|&p| (p - a).reject_from_normalized(along).length() <= ON_SURFACE * tolerance)
}

/// Knots so dense that a curve along the sides of each of `lines`, whose points are at the same parameters, stays within
/// a share of the tolerance, as far as spans of a part of a side allow.
pub(super) fn fitted_within(
    lines: &[Vec<DVec3>],
    parameters: &[f64],
    tolerance: f64,
    task: &Task,
) -> Result<Knots, Cancelled> {
    let mut knots = Knots::unit();
    for _ in 0..MOST_HALVINGS {
        task.check()?;
        let breaks = knots.breaks();
        let span_of = |u: f64| breaks.partition_point(|b| *b <= u).clamp(1, breaks.len() - 1) - 1;
        let failing = |line: &Vec<DVec3>| {
            let mut failing = BTreeSet::new();
            let Some(curve) = Curve::along(knots.clone(), parameters, line) else { return failing };
            for (ends, side) in parameters.windows(2).zip(line.windows(2)) {
                for j in 0..ON_SIDE {
                    let u = ends[0] + (ends[1] - ends[0]) * (j as f64 + 0.5) / ON_SIDE as f64;
                    if from_side(curve.at(u), side[0], side[1]) > ON_LINE * tolerance {
                        failing.insert(span_of(u));
                    }
                }
            }
            failing
        };
        let failing = lines.par_iter().map(failing).reduce(BTreeSet::new, |mut a, mut b| {
            a.append(&mut b);
            a
        });
        let is_wide = |span: usize| {
            let [from, to] = [breaks[span], breaks[span + 1]];
            let within = parameters.windows(2).filter(|ends| ends[0] < to && ends[1] > from);
            to - from > 4.0 * within.map(|ends| ends[1] - ends[0]).fold(1.0, f64::min) / ON_SIDE as f64
        };
        let next = knots.halved(|span| failing.contains(&span) && is_wide(span));
        if next == knots {
            break;
        }
        knots = next;
    }
    Ok(knots)
}

fn from_side(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let along = b - a;
    let share = ((p - a).dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    p.distance(a + along * share)
}

/// Parameters from 0 to 1 in the proportion of the chords between points.
fn chord_parameters(points: &[DVec3]) -> Vec<f64> {
    let mut sums = vec![0.0];
    for w in points.windows(2) {
        sums.push(sums[sums.len() - 1] + w[0].distance(w[1]));
    }
    let (last, count) = (sums[sums.len() - 1], (points.len() - 1).max(1) as f64);
    let even = |k: usize| k as f64 / count;
    (0..sums.len()).map(|k| if last > 0.0 { (sums[k] / last).min(1.0) } else { even(k) }).collect()
}

/// Angle of a point about z (rad), from 0 to a full turn.
fn angle(axes: &Axes, p: DVec3) -> f64 {
    let local = axes.local(p);
    let angle = local.y.atan2(local.x);
    if angle < -1e-9 { angle + std::f64::consts::TAU } else { angle }
}
