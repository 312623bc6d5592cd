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
    /// Diagonal of the control points' box.
    extent: f64,
}

/// The point of a curve that is nearest to another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NearestOnCurve {
    /// Parameter.
    pub u: f64,
    /// Position.
    pub point: DVec3,
    /// Distance.
    pub distance: f64,
}

impl NurbsCurve {
    /// Places sampled on each piece before feet are approached from those nearer than their neighbours.
    const LOOKS: usize = 6;
    /// Most places looked at so, of a curve that has no more pieces.
    const MOST_LOOKS: usize = 6000;
    /// Share of the curve's extent by which a point may be nearer than the one that [`Self::nearest`] answers.
    pub const NEAR: f64 = 1e-4;

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
        Ok(Self::of(knots, points.iter().zip(weights).map(|(p, w)| (*p * *w).extend(*w)).collect()))
    }

    /// Reversed curve: its point at u is this curve's point at first plus last parameter less u.
    pub fn reversed(&self) -> Self {
        let points = self.points.iter().rev().copied().collect();
        Self { knots: self.knots.reversed(), points, extent: self.extent }
    }

    /// The curve with its control points carried by an affine `map`.
    #[must_use]
    pub fn mapped(&self, map: impl Fn(DVec3) -> DVec3) -> Self {
        let points = self.points.iter().map(|q| (map(q.truncate() / q.w) * q.w).extend(q.w)).collect();
        Self::of(self.knots.clone(), points)
    }

    /// The stretch of the curve from one parameter within its ends to a greater one, with the same parameters.
    ///
    /// # Errors
    /// If the parameters do not rise.
    pub fn between(&self, from: f64, to: f64) -> Result<Self, NurbsError> {
        let degree = self.knots.degree();
        let inner = self.knots.knots().iter().copied().filter(|u| *u > from && *u < to).collect();
        let knots = KnotVector::clamped(degree, from, inner, to)?;
        let points = (0..knots.count()).map(|i| {
            // Polar form (blossom) of the piece that control point i counts on, at the knots behind it.
            let t = &knots.knots()[i..=i + degree + 1];
            let piece = t.windows(2).find(|w| w[1] > w[0]).map_or(from, |w| 0.5 * (w[0] + w[1]));
            self.polar(piece, &t[1..=degree])
        });
        let points = points.collect();
        Ok(Self::of(knots, points))
    }

    /// The curve of homogeneous control points, as many as `knots` count.
    pub(super) fn of(knots: KnotVector, points: Vec<DVec4>) -> Self {
        let corners = |pick: fn(DVec3, DVec3) -> DVec3| points.iter().map(|q| q.truncate() / q.w).reduce(pick);
        let extent = corners(DVec3::max).zip(corners(DVec3::min)).map_or(0.0, |(high, low)| high.distance(low));
        Self { knots, points, extent }
    }

    /// The polar form of the piece around `u` at `arguments`, as many as the degree.
    fn polar(&self, u: f64, arguments: &[f64]) -> DVec4 {
        let (degree, knots) = (self.knots.degree(), self.knots.knots());
        let first = self.knots.basis(u).first;
        let mut points = self.points[first..=first + degree].to_vec();
        for (r, t) in (1..).zip(arguments) {
            for j in (r..=degree).rev() {
                let (low, high) = (knots[first + j], knots[first + j + degree + 1 - r]);
                points[j] = points[j - 1].lerp(points[j], (t - low) / (high - low));
            }
        }
        points[degree]
    }

    /// Knots.
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

    /// The point of the curve nearest to `p`: a foot exact to rounding, or an end. Another foot is nearer by at most
    /// [`Self::NEAR`] of the curve's greatest extent: stretches are looked at until the greatest speed along them
    /// forbids more.
    pub fn nearest(&self, p: DVec3) -> NearestOnCurve {
        let joints = self.knots.joints();
        // Stretches are halved where that may be needed: fewer looks of short pieces miss nothing.
        let parts = (Self::MOST_LOOKS / joints.len()).clamp(1, Self::LOOKS);
        let mut looks: Vec<f64> = joints.windows(2).flat_map(|w| places(w, parts)).collect();
        looks.dedup();
        let distances: Vec<f64> = looks.iter().map(|u| self.point(*u).distance(p)).collect();
        let last = looks.len() - 1;
        let around = |i: usize| [i.saturating_sub(1), (i + 1).min(last)];
        let is_least = |i: &usize| around(*i).iter().all(|j| distances[*j] >= distances[*i]);
        let feet = (0..=last).filter(is_least).map(|i| self.nearest_between(p, looks[i], around(i).map(|j| looks[j])));
        let none = NearestOnCurve { u: looks[0], point: self.point(looks[0]), distance: f64::INFINITY };
        let found = feet.fold(none, |best, foot| if foot.distance < best.distance { foot } else { best });
        let near = Self::NEAR * self.extent();
        (1..=last).fold(found, |best, i| {
            let speed = self.greatest_speed(0.5 * (looks[i - 1] + looks[i]));
            self.nearer_on(p, speed, near, [looks[i - 1], looks[i]], [distances[i - 1], distances[i]], best)
        })
    }

    /// `best`, or a point of the stretch that is more than `near` nearer to `p`. `ends` are the distances at the ends
    /// of the stretch: between them no point is nearer than half their sum less half the greatest length between.
    fn nearer_on(
        &self,
        p: DVec3,
        speed: f64,
        near: f64,
        within: [f64; 2],
        ends: [f64; 2],
        best: NearestOnCurve,
    ) -> NearestOnCurve {
        let possible = 0.5 * (ends[0] + ends[1] - speed * (within[1] - within[0]));
        let middle = 0.5 * (within[0] + within[1]);
        // What is no number is not nearer.
        let is_nearer = possible < best.distance - near;
        if !is_nearer || middle <= within[0] || middle >= within[1] {
            return best;
        }
        let there = self.point(middle).distance(p);
        let foot = if there < best.distance - near { self.nearest_between(p, middle, within) } else { best };
        let best = if foot.distance < best.distance { foot } else { best };
        let best = self.nearer_on(p, speed, near, [within[0], middle], [ends[0], there], best);
        self.nearer_on(p, speed, near, [middle, within[1]], [there, ends[1]], best)
    }

    /// Diagonal of the control points' box; the curve lies within it.
    pub fn extent(&self) -> f64 {
        self.extent
    }

    /// No less than the speed anywhere on the piece around `u`. With the origin among the piece's control points, none
    /// of them farther than `r`, the quotient rule gives |C'| <= (|A'| + |w'| r)/w, and A' and w' lie among the control
    /// points of the derivative.
    fn greatest_speed(&self, u: f64) -> f64 {
        let (first, steps) = self.knots.slope_steps(u);
        let points = &self.points[first..=first + self.knots.degree()];
        let origin = points.iter().map(|q| q.truncate() / q.w).sum::<DVec3>() / points.len() as f64;
        let moved = |q: &DVec4| (q.truncate() - origin * q.w).extend(q.w);
        let most = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
        let radius = most(&mut points.iter().map(|q| (q.truncate() / q.w).distance(origin)));
        let slopes: Vec<DVec4> =
            points.windows(2).zip(steps).map(|(w, step)| (moved(&w[1]) - moved(&w[0])) * step).collect();
        let heaviest = most(&mut slopes.iter().map(|s| s.truncate().length()));
        let weights = most(&mut slopes.iter().map(|s| s.w.abs()));
        (heaviest + weights * radius) / points.iter().map(|q| q.w).fold(f64::INFINITY, f64::min)
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

/// `parts + 1` places evenly over the stretch between the two `ends`.
fn places(ends: &[f64], parts: usize) -> impl Iterator<Item = f64> {
    let (from, by) = (ends[0], (ends[1] - ends[0]) / parts as f64);
    let to = ends[1];
    (0..parts).map(move |k| from + by * k as f64).chain(std::iter::once(to))
}
