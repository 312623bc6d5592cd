//! The ruled surface while it is being fitted: two uniform cubic B-splines with common knots.

use glam::DVec3;

use crate::geometry::nurbs::{KnotVector, NurbsCurve, NurbsError};

/// How far beyond its ends a surface is followed for a foot, in its parameters.
const BEYOND: [f64; 2] = [0.25, 0.4];

/// The control points of both guides.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Strip {
    /// Of the lower guide.
    pub lower: Vec<DVec3>,
    /// Of the upper one, as many.
    pub upper: Vec<DVec3>,
}

/// The four basis functions at a parameter, with their first and second derivatives.
#[derive(Debug, Clone, Copy)]
pub(super) struct Basis {
    /// Number of the first of them.
    pub first: usize,
    /// Values, first and second derivatives.
    pub orders: [[f64; 4]; 3],
}

/// A place of the surface.
#[derive(Debug, Clone, Copy)]
pub(super) struct Foot {
    /// Along the guides.
    pub u: f64,
    /// From the lower guide to the upper one.
    pub v: f64,
}

/// A surface point with its derivatives.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    /// Where it is.
    pub point: DVec3,
    /// Along u and along v.
    pub first: [DVec3; 2],
    /// Twice by u, and by u and v.
    pub second: [DVec3; 2],
}

/// Rulings at even parameters, by which feet are first looked for.
pub(super) struct Rulings(Vec<(f64, DVec3, DVec3)>);

impl Basis {
    /// At `u` of clamped uniform cubics of `count` control points over 0 to 1; the end pieces go on beyond.
    pub(super) fn at(count: usize, u: f64) -> Self {
        let pieces = count - 3;
        let span = ((u * pieces as f64).floor().max(0.0) as usize).min(pieces - 1);
        let knot = |i: usize| ((span + i).saturating_sub(2).min(pieces)) as f64 / pieces as f64;
        // The knots around the span: three before it, itself, three behind.
        let k: [f64; 6] = std::array::from_fn(knot);
        let mut rows = [[0.0; 4]; 4];
        rows[0][0] = 1.0;
        for d in 1..=3 {
            let mut carried = 0.0;
            for r in 0..d {
                let (left, right) = (k[3 + r - d], k[3 + r]);
                let share = rows[d - 1][r] / (right - left);
                rows[d][r] = carried + (right - u) * share;
                carried = (u - left) * share;
            }
            rows[d][d] = carried;
        }
        let slope = |lower: &[f64; 4], d: usize| -> [f64; 4] {
            std::array::from_fn(|r| {
                let rise = if r > 0 && r <= d { lower[r - 1] / (k[r + 2] - k[r + 2 - d]) } else { 0.0 };
                let fall = if r < d { lower[r] / (k[r + 3] - k[r + 3 - d]) } else { 0.0 };
                d as f64 * (rise - fall)
            })
        };
        let first = slope(&rows[2], 3);
        let second = slope(&slope(&rows[1], 2), 3);
        Self { first: span, orders: [rows[3], first, second] }
    }

    fn sum(&self, order: usize, points: &[DVec3]) -> DVec3 {
        let [a, b, c, d] = self.orders[order];
        match &points[self.first..] {
            [p, q, r, s, ..] => *p * a + *q * b + *r * c + *s * d,
            _ => DVec3::NAN,
        }
    }
}

impl Strip {
    /// Control points of each guide.
    pub(super) fn count(&self) -> usize {
        self.lower.len()
    }

    /// The guides as curves, moved by `origin`.
    pub(super) fn guides(&self, origin: DVec3) -> Result<[NurbsCurve; 2], NurbsError> {
        let pieces = self.count() - 3;
        let mut knots = vec![0.0; 3];
        knots.extend((0..=pieces).map(|i| i as f64 / pieces as f64));
        knots.extend([1.0; 3]);
        let knots = KnotVector::new(3, knots)?;
        let curve = |points: &[DVec3]| {
            let moved: Vec<DVec3> = points.iter().map(|p| *p + origin).collect();
            NurbsCurve::new(knots.clone(), &moved, &vec![1.0; moved.len()])
        };
        Ok([curve(&self.lower)?, curve(&self.upper)?])
    }

    /// The points of both guides at `u`.
    pub(super) fn ends(&self, u: f64) -> [DVec3; 2] {
        let basis = Basis::at(self.count(), u);
        [basis.sum(0, &self.lower), basis.sum(0, &self.upper)]
    }

    /// Point and derivatives of a guide at `u`: the lower one where `side` is 0.
    pub(super) fn guide(&self, side: usize, u: f64) -> [DVec3; 3] {
        let basis = Basis::at(self.count(), u);
        let points = if side == 0 { &self.lower } else { &self.upper };
        [0, 1, 2].map(|order| basis.sum(order, points))
    }

    /// The surface at `foot`.
    pub(super) fn at(&self, foot: Foot) -> Place {
        let basis = Basis::at(self.count(), foot.u);
        let [low, high] = [&self.lower, &self.upper].map(|g| [0, 1, 2].map(|order| basis.sum(order, g)));
        let mix = |i: usize| low[i] * (1.0 - foot.v) + high[i] * foot.v;
        Place { point: mix(0), first: [mix(1), high[0] - low[0]], second: [mix(2), high[1] - low[1]] }
    }

    /// Rulings to look for feet by.
    pub(super) fn rulings(&self) -> Rulings {
        let n = 6 * (self.count() - 3).max(6);
        let at = |i: usize| i as f64 / n as f64;
        Rulings((0..=n).map(|i| (at(i), self.ends(at(i)))).map(|(u, [a, b])| (u, a, b)).collect())
    }

    /// The place nearest to `p` between the ends, near enough to measure distances of more than a thousandth of a piece.
    pub(super) fn foot_within(&self, rulings: &Rulings, p: DVec3) -> Foot {
        let on = |u: f64| {
            let [a, b] = self.ends(u);
            let v = ((p - a).dot(b - a) / (b - a).length_squared().max(1e-300)).clamp(0.0, 1.0);
            (a.lerp(b, v).distance_squared(p), Foot { u, v })
        };
        let nearer = |a: (f64, Foot), b: (f64, Foot)| if b.0 < a.0 { b } else { a };
        let seen = rulings.0.iter().map(|r| on(r.0)).fold((f64::INFINITY, Foot { u: 0.5, v: 0.5 }), nearer);
        let step = 1.0 / (rulings.0.len().max(2) - 1) as f64;
        let (mut low, mut high) = ((seen.1.u - step).max(0.0), (seen.1.u + step).min(1.0));
        for _ in 0..30 {
            let [a, b] = [low + (high - low) / 3.0, high - (high - low) / 3.0];
            (low, high) = if on(a).0 < on(b).0 { (low, b) } else { (a, high) };
        }
        nearer(seen, on(0.5 * (low + high))).1
    }

    /// The foot of `p`, looked for everywhere.
    pub(super) fn foot(&self, rulings: &Rulings, p: DVec3) -> Foot {
        let mut best = (f64::INFINITY, Foot { u: 0.5, v: 0.5 });
        for &(u, a, b) in &rulings.0 {
            let along = b - a;
            let v = ((p - a).dot(along) / along.length_squared().max(1e-300)).clamp(-0.05, 1.05);
            let squared = (a + along * v).distance_squared(p);
            if squared < best.0 {
                best = (squared, Foot { u, v });
            }
        }
        self.foot_near(best.1, p)
    }

    /// The foot of `p` approached from `foot` by Newton's method, each step no worse than the one before.
    pub(super) fn foot_near(&self, foot: Foot, p: DVec3) -> Foot {
        const ROUNDS: usize = 12;
        let mut foot = foot;
        let mut place = self.at(foot);
        for _ in 0..ROUNDS {
            let d = place.point - p;
            let [ru, rv] = place.first;
            let [g, h] = [d.dot(ru), d.dot(rv)];
            let (a, c) = (ru.length_squared() + d.dot(place.second[0]), rv.length_squared());
            let b = ru.dot(rv) + d.dot(place.second[1]);
            let (a, b) = if a * c - b * b > 1e-6 * a.abs() * c { (a, b) } else { (ru.length_squared(), 0.0) };
            let det = a * c - b * b;
            if det.is_nan() || det <= 0.0 {
                break;
            }
            let (du, dv) = ((b * h - c * g) / det, (b * g - a * h) / det);
            let scale = (0.1 / du.abs().max(1e-300)).min(1.0);
            let mut share = scale;
            let before = d.length_squared();
            let (mut next, mut there) = (foot, place);
            while share > 0.01 * scale {
                next = Foot {
                    u: (foot.u + du * share).clamp(-BEYOND[0], 1.0 + BEYOND[0]),
                    v: (foot.v + dv * share).clamp(-BEYOND[1], 1.0 + BEYOND[1]),
                };
                there = self.at(next);
                if there.point.distance_squared(p) <= before {
                    break;
                }
                share *= 0.3;
            }
            if there.point.distance_squared(p) > before {
                break;
            }
            let moved = (next.u - foot.u).abs() + (next.v - foot.v).abs();
            (foot, place) = (next, there);
            // Newton's steps shrink as squares: the next one would be nothing.
            if moved < 1e-8 {
                break;
            }
        }
        foot
    }

    /// The parameter of the foot of `p` on a guide, approached from `u`.
    pub(super) fn foot_on_guide(&self, side: usize, u: f64, p: DVec3) -> f64 {
        let mut u = u.clamp(0.0, 1.0);
        for _ in 0..12 {
            let [c, t, a] = self.guide(side, u);
            let bend = t.length_squared() + (c - p).dot(a);
            let bend = if bend > 0.1 * t.length_squared() { bend } else { t.length_squared() };
            let next = (u - ((c - p).dot(t) / bend.max(1e-300)).clamp(-0.1, 0.1)).clamp(0.0, 1.0);
            let moved = (next - u).abs();
            u = next;
            if moved < 1e-11 {
                break;
            }
        }
        u
    }

    /// The same surface with twice as many pieces.
    pub(super) fn refined(&self) -> Self {
        let count = 2 * (self.count() - 3) + 3;
        let places: Vec<f64> = (0..4 * count).map(|i| i as f64 / (4 * count - 1) as f64).collect();
        let ends: Vec<[DVec3; 2]> = places.iter().map(|&u| self.ends(u)).collect();
        Self::through(count, &places, &ends).unwrap_or_else(|| self.clone())
    }

    /// The same surface from `start` to `end` in its parameter, which may lie beyond its ends.
    pub(super) fn between(&self, start: f64, end: f64) -> Option<Self> {
        let n = 4 * self.count();
        let places: Vec<f64> = (0..n).map(|i| i as f64 / (n - 1) as f64).collect();
        let ends: Vec<[DVec3; 2]> = places.iter().map(|&u| self.ends(start + (end - start) * u)).collect();
        Self::through(self.count(), &places, &ends)
    }

    /// The guides of `count` control points each with the least squares of distances from `ends[i]` at `places[i]`.
    pub(super) fn through(count: usize, places: &[f64], ends: &[[DVec3; 2]]) -> Option<Self> {
        let mut matrix = nalgebra::DMatrix::<f64>::zeros(count, count);
        let mut right = nalgebra::DMatrix::<f64>::zeros(count, 6);
        for (&u, pair) in places.iter().zip(ends) {
            let basis = Basis::at(count, u);
            for (k, x) in basis.orders[0].iter().enumerate() {
                for (l, y) in basis.orders[0].iter().enumerate() {
                    matrix[(basis.first + k, basis.first + l)] += x * y;
                }
                for (c, value) in pair.iter().flat_map(|p| p.to_array()).enumerate() {
                    right[(basis.first + k, c)] += x * value;
                }
            }
        }
        // Control points that no place tells of follow their neighbours.
        for i in 1..count - 1 {
            for (k, x) in [(i - 1, 1.0), (i, -2.0), (i + 1, 1.0)] {
                for (l, y) in [(i - 1, 1.0), (i, -2.0), (i + 1, 1.0)] {
                    matrix[(k, l)] += 1e-12 * places.len() as f64 * x * y;
                }
            }
        }
        let solved = matrix.cholesky()?.solve(&right);
        let point = |i: usize, c: usize| DVec3::new(solved[(i, c)], solved[(i, c + 1)], solved[(i, c + 2)]);
        let strip =
            Self { lower: (0..count).map(|i| point(i, 0)).collect(), upper: (0..count).map(|i| point(i, 3)).collect() };
        strip.lower.iter().chain(&strip.upper).all(|p| p.is_finite()).then_some(strip)
    }
}
