//! The ruled surface while it is being fitted: two cubic B-splines with common knots.

use glam::DVec3;

use super::knots::{Basis, Knots};
use geometry::nurbs::{KnotVector, NurbsCurve, NurbsError};

/// How far beyond its ends a surface is followed for a foot, in its parameters.
const BEYOND: [f64; 2] = [0.25, 0.4];

/// The control points of both guides.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Strip {
    /// Knots of both guides.
    pub knots: Knots,
    /// Control points of the lower guide.
    pub lower: Vec<DVec3>,
    /// Control points of the upper guide, as many.
    pub upper: Vec<DVec3>,
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
    /// Position.
    pub point: DVec3,
    /// Along u and along v.
    pub first: [DVec3; 2],
    /// Twice by u, and by u and v.
    pub second: [DVec3; 2],
}

/// Rulings at even parameters, by which feet are first looked for.
pub(super) struct Rulings(Vec<(f64, DVec3, DVec3)>);

/// The sum of control points by one order of their basis functions.
fn sum(basis: &Basis, order: usize, points: &[DVec3]) -> DVec3 {
    basis.numbers.iter().zip(basis.orders[order]).map(|(i, share)| points[*i] * share).sum()
}

impl Strip {
    /// Control points of each guide.
    pub(super) fn count(&self) -> usize {
        self.lower.len()
    }

    /// The guides as curves, moved by `origin`.
    pub(super) fn guides(&self, origin: DVec3) -> Result<[NurbsCurve; 2], NurbsError> {
        let knots = [&[0.0; 3][..], &self.knots.breaks, &[1.0; 3]].concat();
        let knots = KnotVector::new(3, knots)?;
        let curve = |side: usize| {
            let moved: Vec<DVec3> = self.clamped(side).into_iter().map(|p| p + origin).collect();
            NurbsCurve::new(knots.clone(), &moved, &vec![1.0; moved.len()])
        };
        Ok([curve(0)?, curve(1)?])
    }

    /// Control points of a guide for clamped knots. Those of a closed one count the same but for two at each end, which
    /// follow from its start and its slope there.
    fn clamped(&self, side: usize) -> Vec<DVec3> {
        let points = if side == 0 { &self.lower } else { &self.upper };
        if !self.knots.is_closed {
            return points.clone();
        }
        let (breaks, last) = (&self.knots.breaks, self.knots.pieces());
        let [start, slope, _] = self.guide(side, 0.0);
        let inner = (2..=last).map(|i| points[i % points.len()]);
        let ends = [slope * (breaks[1] / 3.0), slope * ((1.0 - breaks[last - 1]) / 3.0)];
        [start, start + ends[0]].into_iter().chain(inner).chain([start - ends[1], start]).collect()
    }

    /// The points of both guides at `u`.
    pub(super) fn ends(&self, u: f64) -> [DVec3; 2] {
        let basis = self.knots.basis(u);
        [sum(&basis, 0, &self.lower), sum(&basis, 0, &self.upper)]
    }

    /// Point and derivatives of a guide at `u`: the lower one where `side` is 0.
    pub(super) fn guide(&self, side: usize, u: f64) -> [DVec3; 3] {
        let basis = self.knots.basis(u);
        let points = if side == 0 { &self.lower } else { &self.upper };
        [0, 1, 2].map(|order| sum(&basis, order, points))
    }

    /// The surface at `foot`.
    pub(super) fn at(&self, foot: Foot) -> Place {
        let basis = self.knots.basis(foot.u);
        let [low, high] = [&self.lower, &self.upper].map(|g| [0, 1, 2].map(|order| sum(&basis, order, g)));
        let mix = |i: usize| low[i] * (1.0 - foot.v) + high[i] * foot.v;
        Place { point: mix(0), first: [mix(1), high[0] - low[0]], second: [mix(2), high[1] - low[1]] }
    }

    /// Rulings to look for feet by.
    pub(super) fn rulings(&self) -> Rulings {
        let even = 6.0 * self.knots.pieces().max(6) as f64;
        let places = self.knots.breaks.windows(2).flat_map(|w| {
            let parts = (even * (w[1] - w[0])).round().max(2.0);
            (0..parts as usize).map(move |i| w[0] + (w[1] - w[0]) * i as f64 / parts)
        });
        Rulings(places.chain([1.0]).map(|u| (u, self.ends(u))).map(|(u, [a, b])| (u, a, b)).collect())
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
                let u = foot.u + du * share;
                let is_closed = self.knots.is_closed;
                next = Foot {
                    u: if is_closed { u } else { u.clamp(-BEYOND[0], 1.0 + BEYOND[0]) },
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
        let within = |u: f64| if self.knots.is_closed { u } else { u.clamp(0.0, 1.0) };
        let mut u = within(u);
        for _ in 0..12 {
            let [c, t, a] = self.guide(side, u);
            let bend = t.length_squared() + (c - p).dot(a);
            let bend = if bend > 0.1 * t.length_squared() { bend } else { t.length_squared() };
            let next = within(u - ((c - p).dot(t) / bend.max(1e-300)).clamp(-0.1, 0.1));
            let moved = (next - u).abs();
            u = next;
            if moved < 1e-11 {
                break;
            }
        }
        u
    }

    /// Surface with the pieces halved that are more than `enough` off by `errors`, the worst of them where there would
    /// be more than `most` control points; none where nothing can be halved.
    pub(super) fn refined(&self, errors: &[f64], enough: f64, most: usize) -> Option<Self> {
        let mut worst: Vec<usize> = (0..errors.len()).filter(|&i| errors[i] > enough).collect();
        worst.sort_by(|&a, &b| errors[b].total_cmp(&errors[a]));
        worst.truncate(most.saturating_sub(self.count()));
        if worst.is_empty() {
            return None;
        }
        let mut knots = self.knots.clone();
        knots.breaks.extend(worst.iter().map(|&i| 0.5 * (self.knots.breaks[i] + self.knots.breaks[i + 1])));
        knots.breaks.sort_by(f64::total_cmp);
        let places = knots.dense();
        let ends: Vec<[DVec3; 2]> = places.iter().map(|&u| self.ends(u)).collect();
        Self::through(knots, &places, &ends)
    }

    /// Surface, not closed, from `start` to `end` in its parameter, which may lie beyond its ends.
    pub(super) fn between(&self, start: f64, end: f64) -> Option<Self> {
        let (breaks, last) = (&self.knots.breaks, self.knots.pieces());
        let moved = |i: usize| if i == 0 || i == last { breaks[i] } else { (breaks[i] - start) / (end - start) };
        let knots = Knots { breaks: (0..=last).map(moved).collect(), is_closed: false };
        let places = knots.dense();
        let ends: Vec<[DVec3; 2]> = places.iter().map(|&u| self.ends(start + (end - start) * u)).collect();
        Self::through(knots, &places, &ends)
    }

    /// The guides with these knots and the least squares of distances from `ends[i]` at `places[i]`.
    pub(super) fn through(knots: Knots, places: &[f64], ends: &[[DVec3; 2]]) -> Option<Self> {
        let count = knots.count();
        let mut matrix = nalgebra::DMatrix::<f64>::zeros(count, count);
        let mut right = nalgebra::DMatrix::<f64>::zeros(count, 6);
        for (&u, pair) in places.iter().zip(ends) {
            let basis = knots.basis(u);
            for (k, x) in basis.orders[0].iter().enumerate() {
                for (l, y) in basis.orders[0].iter().enumerate() {
                    matrix[(basis.numbers[k], basis.numbers[l])] += x * y;
                }
                for (c, value) in pair.iter().flat_map(|p| p.to_array()).enumerate() {
                    right[(basis.numbers[k], c)] += x * value;
                }
            }
        }
        // Control points that no place tells of follow their neighbours.
        for triple in knots.triples() {
            for (k, x) in triple.into_iter().zip([1.0, -2.0, 1.0]) {
                for (l, y) in triple.into_iter().zip([1.0, -2.0, 1.0]) {
                    matrix[(k, l)] += 1e-12 * places.len() as f64 * x * y;
                }
            }
        }
        let solved = matrix.cholesky()?.solve(&right);
        let point = |i: usize, c: usize| DVec3::new(solved[(i, c)], solved[(i, c + 1)], solved[(i, c + 2)]);
        let [lower, upper] = [0, 3].map(|c| (0..count).map(|i| point(i, c)).collect());
        let strip = Self { knots, lower, upper };
        strip.lower.iter().chain(&strip.upper).all(|p| p.is_finite()).then_some(strip)
    }
}
