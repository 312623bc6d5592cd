//! NURBS curves in space.

use glam::{DVec3, DVec4};

use super::NurbsError;
use super::knots::KnotVector;

/// A NURBS curve.
#[derive(Debug, Clone, PartialEq)]
pub struct NurbsCurve {
    knots: KnotVector,
    /// Control points times their weights, and the weights.
    points: Vec<DVec4>,
}

/// The point of a curve that is nearest to another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NearestOnCurve {
    /// Its parameter.
    pub u: f64,
    /// Where it is.
    pub point: DVec3,
    /// How far away.
    pub distance: f64,
}

impl NurbsCurve {
    /// Places looked at on each piece before feet are approached from those nearer than their neighbours.
    const LOOKS: usize = 6;

    /// The curve with these control points and weights.
    ///
    /// # Errors
    /// If numbers do not match, a weight is not positive or a coordinate is no number.
    pub fn new(knots: KnotVector, points: &[DVec3], weights: &[f64]) -> Result<Self, NurbsError> {
        if points.len() != knots.count() || weights.len() != points.len() {
            return Err(NurbsError::Counts);
        }
        let usable = |i: &usize| points[*i].is_finite() && weights[*i].is_finite() && weights[*i] > 0.0;
        if let Some(i) = (0..points.len()).find(|i| !usable(i)) {
            return Err(NurbsError::Value(i));
        }
        Ok(Self { knots, points: points.iter().zip(weights).map(|(p, w)| (*p * *w).extend(*w)).collect() })
    }

    /// Its knots.
    pub fn knots(&self) -> &KnotVector {
        &self.knots
    }

    /// First and last parameter.
    pub fn domain(&self) -> [f64; 2] {
        self.knots.domain()
    }

    /// The point at `u`.
    pub fn point(&self, u: f64) -> DVec3 {
        self.at(u)[0]
    }

    /// Point, first and second derivative at `u`; beyond the ends the end pieces continue.
    pub fn at(&self, u: f64) -> [DVec3; 3] {
        let basis = self.knots.basis(u);
        let points = &self.points[basis.first..=basis.first + self.knots.degree()];
        let sum = |order: usize| points.iter().zip(basis.orders[order]).map(|(p, n)| *p * n).sum::<DVec4>();
        let [a, b, c] = [sum(0), sum(1), sum(2)];
        // The quotient rule on (w C)/w.
        let point = a.truncate() / a.w;
        let first = (b.truncate() - point * b.w) / a.w;
        let second = (c.truncate() - first * (2.0 * b.w) - point * c.w) / a.w;
        [point, first, second]
    }

    /// The unit vector along the curve at `u`; zero where the curve stands still.
    pub fn tangent(&self, u: f64) -> DVec3 {
        self.at(u)[1].normalize_or_zero()
    }

    /// Length from `u0` to `u1` (positive), to about 1e-9 of it for smooth curves: Gauss-Legendre with five points on
    /// halves of each piece.
    pub fn length(&self, u0: f64, u1: f64) -> f64 {
        let mut joints = self.knots.joints();
        joints.retain(|u| (u0..u1).contains(u) && *u > u0);
        joints.insert(0, u0);
        joints.push(u1);
        joints.windows(2).map(|w| self.length_within(w[0], w[1])).sum()
    }

    fn length_within(&self, u0: f64, u1: f64) -> f64 {
        const HALVES: usize = 4;
        let (inner, outer) =
            ((5.0 - 2.0 * (10.0f64 / 7.0).sqrt()).sqrt() / 3.0, (5.0 + 2.0 * (10.0f64 / 7.0).sqrt()).sqrt() / 3.0);
        let root = 13.0 * 70f64.sqrt();
        let (heavy, light) = ((322.0 + root) / 900.0, (322.0 - root) / 900.0);
        let rule = [(0.0, 128.0 / 225.0), (inner, heavy), (-inner, heavy), (outer, light), (-outer, light)];
        let half = 0.5 * (u1 - u0) / HALVES as f64;
        let middles = (0..HALVES).map(|i| u0 + half * (2 * i + 1) as f64);
        middles.flat_map(|m| rule.map(|(x, w)| w * half * self.at(m + half * x)[1].length())).sum()
    }

    /// The point of the curve nearest to `p`, exact to rounding unless the curve winds so much within a piece that two
    /// feet lie between neighbouring places looked at. The ends count as points of the curve.
    pub fn nearest(&self, p: DVec3) -> NearestOnCurve {
        let joints = self.knots.joints();
        let looks: Vec<f64> = joints
            .windows(2)
            .flat_map(|w| (0..Self::LOOKS).map(|k| w[0] + (w[1] - w[0]) * k as f64 / Self::LOOKS as f64))
            .chain(joints.last().copied())
            .collect();
        let distances: Vec<f64> = looks.iter().map(|u| self.point(*u).distance_squared(p)).collect();
        let last = looks.len() - 1;
        let around = |i: usize| [i.saturating_sub(1), (i + 1).min(last)];
        let is_least = |i: &usize| around(*i).iter().all(|j| distances[*j] >= distances[*i]);
        let feet = (0..=last).filter(is_least).map(|i| self.nearest_between(p, looks[i], around(i).map(|j| looks[j])));
        let none = NearestOnCurve { u: looks[0], point: self.point(looks[0]), distance: f64::INFINITY };
        feet.fold(none, |best, foot| if foot.distance < best.distance { foot } else { best })
    }

    /// The foot of `p` on the stretch `within` of the curve, approached from `start`; an end of the stretch if there is
    /// none.
    pub fn nearest_between(&self, p: DVec3, start: f64, within: [f64; 2]) -> NearestOnCurve {
        let u = self.foot(p, start, within);
        let point = self.point(u);
        NearestOnCurve { u, point, distance: point.distance(p) }
    }

    /// Newton's method for the foot of the perpendicular from `p`, halving `bracket` where it would leave it.
    fn foot(&self, p: DVec3, start: f64, [mut low, mut high]: [f64; 2]) -> f64 {
        const ROUNDS: usize = 60;
        let mut u = start;
        for _ in 0..ROUNDS {
            let [point, first, second] = self.at(u);
            let slope = (point - p).dot(first);
            let bend = first.length_squared() + (point - p).dot(second);
            if slope > 0.0 {
                high = u;
            } else {
                low = u;
            }
            let newton = u - slope / bend;
            let next = if bend > 0.0 && (low..=high).contains(&newton) { newton } else { 0.5 * (low + high) };
            if (next - u).abs() <= 1e-15 * (1.0 + u.abs()) {
                return next;
            }
            u = next;
        }
        u
    }
}
