//! Least squares of the distances of a face from the ruled surface, over the control points of both guides.

use glam::DVec3;

use super::band::Band;
use super::knots::{Basis, Knots};
use super::patch::Patch;
use super::sides::Sides;
use super::strip::{Foot, Strip};
use task::Cancel;

/// Points of each guide's border that a fit looks at, for one of the face.
const SIDE_POINTS: f64 = 0.1;
/// Weight of points inside of triangles, which lie off by the chord error, beside that of corners; and their greater
/// weight where that error is negligible, as on large flats, which have no other points.
const INNER_WEIGHT: f64 = 0.01;
const KNOWN_WEIGHT: f64 = 0.3;
/// Weight of the borders beside the face.
const SIDE_WEIGHT: f64 = 0.1;
/// Weight of the four corners beside the face, along the guides.
const CORNER_WEIGHT: f64 = 0.01;
/// Weight of uneven speed along the guides beside the remaining distances, so that rulings are not turned far for
/// little: where a face is nearly flat nothing else decides which ruling is the right one.
const SPEED_WEIGHT: f64 = 0.05;
/// Weight of bends of the guides: negligible, for control points that no sample is near to.
const BEND_WEIGHT: f64 = 1e-9;

/// Samples that a surface is fitted to.
#[derive(Clone)]
pub(super) struct Samples {
    /// Points of the face and their weights.
    face: Vec<(DVec3, f64)>,
    /// Points of the lower and of the upper border with the normals of the face and weights.
    sides: [Vec<(DVec3, DVec3, f64)>; 2],
    /// Where the lower and the upper guide start and end, unless their ends are free.
    pub ends: Option<[[DVec3; 2]; 2]>,
    /// Diagonal of the box around the face (mm).
    size: f64,
    /// Tells fits to stop.
    pub cancel: Cancel,
}

/// Feet of all samples.
#[derive(Clone)]
struct Feet {
    face: Vec<Foot>,
    sides: [Vec<f64>; 2],
    /// The weighted sum of the squares of distances (mm^2).
    distances: f64,
    /// The sum of the squares of changes of speed (mm^2).
    speed: f64,
}

impl Samples {
    /// At most `count` corners of the face, and a third as many places inside of its triangles: the surface must not
    /// swing between corners.
    pub(super) fn of(patch: &Patch, laid: &Sides, (count, tolerance): (usize, f64), cancel: &Cancel) -> Self {
        let mut face = patch.corner_samples(count);
        let total: f64 = face.iter().map(|f| f.1).sum();
        face.iter_mut().for_each(|f| f.1 /= total.max(1e-300));
        let inner = patch.inner_samples(count / 3);
        let known = (1.0 - patch.chord / tolerance).max(0.0).powi(2);
        let weight = (INNER_WEIGHT + KNOWN_WEIGHT * known) / inner.len().max(1) as f64;
        face.extend(inner.into_iter().map(|p| (p, weight)));
        let sides = [0, 1].map(|s| {
            let guide = &laid.guides[s];
            let step = guide.len().div_ceil((SIDE_POINTS * count as f64) as usize + 8).max(1);
            let mut kept: Vec<(DVec3, DVec3, f64)> = guide.iter().step_by(step).map(|&(p, n)| (p, n, 0.0)).collect();
            if let (Some(last), false) = (guide.last(), (guide.len() - 1).is_multiple_of(step)) {
                kept.push((last.0, last.1, 0.0));
            }
            if known > 0.0 {
                kept = densely(&kept);
            }
            let total: f64 = kept.windows(2).map(|w| w[0].0.distance(w[1].0)).sum();
            for i in 1..kept.len() {
                let share = 0.5 * SIDE_WEIGHT * kept[i - 1].0.distance(kept[i].0) / total.max(1e-300);
                kept[i - 1].2 += share;
                kept[i].2 += share;
            }
            kept
        });
        let ends = match [&laid.guides[0][..], &laid.guides[1][..]] {
            [[a, .., b], [c, .., d]] => Some([[a.0, b.0], [c.0, d.0]]),
            _ => None,
        };
        Self { face, sides, ends, size: patch.size, cancel: cancel.clone() }
    }

    fn feet(&self, strip: &Strip, before: Option<&Feet>) -> Feet {
        let rulings = strip.rulings();
        let place = |(i, (p, _)): (usize, &(DVec3, f64))| {
            before.map_or_else(|| strip.foot(&rulings, *p), |feet| strip.foot_near(feet.face[i], *p))
        };
        let face: Vec<Foot> = self.face.iter().enumerate().map(place).collect();
        let sides = [0, 1].map(|s| {
            let points = self.sides[s].iter().enumerate();
            let start = |i: usize, p: DVec3| before.map_or_else(|| strip.foot(&rulings, p).u, |f| f.sides[s][i]);
            points.map(|(i, side)| strip.foot_on_guide(s, start(i, side.0), side.0)).collect()
        });
        let mut feet = Feet { face, sides, distances: 0.0, speed: 0.0 };
        let (mut distances, mut speed) = (0.0, 0.0);
        self.rows(strip, &feet, |_, residual, weight| distances += weight * residual * residual);
        Self::speed_rows(strip, 1.0, |_, residual, weight| speed += weight * residual * residual);
        (feet.distances, feet.speed) = (distances, speed);
        feet
    }

    /// Calls `each` with every row of the Jacobian (the control points that count, as number, share and direction), its
    /// residual and its weight.
    fn rows(&self, strip: &Strip, feet: &Feet, mut each: impl FnMut(&[(usize, f64, DVec3)], f64, f64)) {
        let n = strip.count();
        let mut row = Vec::with_capacity(8);
        for ((p, weight), foot) in self.face.iter().zip(&feet.face) {
            let place = strip.at(*foot);
            let normal = place.first[0].cross(place.first[1]).normalize_or_zero();
            let basis = strip.knots.basis(foot.u);
            row.clear();
            for (k, share) in basis.orders[0].iter().enumerate() {
                row.push((basis.numbers[k], share * (1.0 - foot.v), normal));
                row.push((n + basis.numbers[k], share * foot.v, normal));
            }
            each(&row, (*p - place.point).dot(normal), *weight);
        }
        for s in 0..2 {
            let mut along = |direction: DVec3, residual: f64, weight: f64, basis: &Basis| {
                row.clear();
                let shares = basis.orders[0].iter().enumerate();
                row.extend(shares.map(|(k, share)| (s * n + basis.numbers[k], *share, direction)));
                each(&row, residual, weight);
            };
            for ((p, normal, weight), &u) in self.sides[s].iter().zip(&feet.sides[s]) {
                let [c, t, _] = strip.guide(s, u);
                let across = t.cross(*normal).normalize_or_zero();
                along(across, (*p - c).dot(across), *weight, &strip.knots.basis(u));
            }
            for (end, p) in self.ends.iter().flat_map(|ends| [0.0, 1.0].into_iter().zip(ends[s])) {
                let [c, t, _] = strip.guide(s, end);
                let t = t.normalize_or_zero();
                along(t, (p - c).dot(t), CORNER_WEIGHT, &strip.knots.basis(end));
            }
        }
    }

    /// The rows that keep the speed along both guides even.
    fn speed_rows(strip: &Strip, weight: f64, mut each: impl FnMut(&[(usize, f64, DVec3)], f64, f64)) {
        let n = strip.count();
        let pieces = strip.knots.pieces() as f64;
        for (s, guide) in [&strip.lower, &strip.upper].into_iter().enumerate() {
            for triple @ [h, i, j] in strip.knots.triples() {
                let along = (guide[j] - guide[h]).normalize_or_zero();
                let [before, here, after] = [-1, 0, 1].map(|by| strip.knots.place(i as isize + by));
                let (a, b) = (1.0 / (here - before), 1.0 / (after - here));
                let change = (guide[j] - guide[i]) * b - (guide[i] - guide[h]) * a;
                let [h, i, j] = triple.map(|i| s * n + i);
                each(&[(h, a, along), (i, -a - b, along), (j, b, along)], -change.dot(along), weight * pieces);
            }
        }
    }

    /// The normal equations, the coordinates of both guides' control points by turns.
    fn equations(&self, strip: &Strip, feet: &Feet, speed: f64) -> (Band, Vec<f64>) {
        let n = strip.count();
        let unknown = |a: usize| first_unknown(a, &strip.knots);
        let mut matrix = Band::new(6 * n, band_width(&strip.knots));
        let mut right = vec![0.0; 6 * n];
        let mut shares: Vec<(usize, f64)> = Vec::with_capacity(24);
        let mut add = |row: &[(usize, f64, DVec3)], residual: f64, weight: f64| {
            shares.clear();
            for &(a, x, d) in row {
                shares.extend((0..3).map(|i| (unknown(a) + i, x * d[i])));
            }
            for &(i, x) in &shares {
                right[i] += weight * x * residual;
                shares.iter().for_each(|&(j, y)| matrix.add(i, j, weight * x * y));
            }
        };
        self.rows(strip, feet, &mut add);
        Self::speed_rows(strip, speed, &mut add);
        for (s, guide) in [&strip.lower, &strip.upper].into_iter().enumerate() {
            for triple @ [h, i, j] in strip.knots.triples() {
                let second = guide[h] - 2.0 * guide[i] + guide[j];
                for axis in DVec3::AXES {
                    let row = [0, 1, 2].map(|k| (s * n + triple[k], [-1.0, 2.0, -1.0][k], axis));
                    add(&row, second.dot(axis), BEND_WEIGHT * n as f64);
                }
            }
        }
        (matrix, right)
    }

    /// The strip moved by Gauss-Newton steps, damped as far as they do not get better, to a small weighted mean square
    /// distance. Feet are looked for anew at every step.
    /// The search ends early where the mean square distance is the square of `enough` (mm).
    pub(super) fn improved(&self, strip: Strip, rounds: usize, enough: f64) -> Strip {
        let mut strip = strip;
        let mut feet = self.feet(&strip, None);
        let mut damping = 1e-4;
        for _ in 0..rounds {
            if feet.distances <= enough * enough || self.cancel.is_cancelled() {
                break;
            }
            let speed = SPEED_WEIGHT * feet.distances.max(enough * enough) / (self.size * self.size);
            let (matrix, right) = self.equations(&strip, &feet, speed);
            let mean = matrix.mean();
            let mut is_better = false;
            let cost = |feet: &Feet| feet.distances + speed * feet.speed;
            let before = cost(&feet);
            for _ in 0..5 {
                let mut damped = matrix.clone();
                for i in 0..right.len() {
                    damped.add(i, i, damping * (matrix.diagonal(i) + 1e-3 * mean) + 1e-12 * mean);
                }
                let next = damped
                    .solve(&right)
                    .and_then(|step| moved(&strip, &step))
                    .map(|next| (self.feet(&next, Some(&feet)), next));
                if let Some((there, next)) = next.filter(|(there, _)| cost(there) < before) {
                    (feet, strip) = (there, next);
                    damping = (0.1 * damping).max(1e-9);
                    is_better = true;
                    break;
                }
                damping *= 10.0;
            }
            if !is_better || cost(&feet) > before * (1.0 - 3e-3) {
                break;
            }
        }
        strip
    }

    /// Least and greatest parameter along the guides at which points of the face have their feet.
    pub(super) fn reach(&self, strip: &Strip) -> [f64; 2] {
        let feet = self.feet(strip, None);
        let along = || feet.face.iter().map(|f| f.u);
        [along().fold(f64::INFINITY, f64::min), along().fold(f64::NEG_INFINITY, f64::max)]
    }
}

/// A border with more points on its long sides, between which a guide could swing.
fn densely(side: &[(DVec3, DVec3, f64)]) -> Vec<(DVec3, DVec3, f64)> {
    const PARTS: f64 = 64.0;
    let total: f64 = side.windows(2).map(|w| w[0].0.distance(w[1].0)).sum();
    let between = |w: &[(DVec3, DVec3, f64)]| {
        let [(p, n, _), (q, m, _)] = [w[0], w[1]];
        let parts = (PARTS * p.distance(q) / total.max(1e-300)).ceil().clamp(1.0, PARTS);
        let at = move |share: f64| (p.lerp(q, share), n.lerp(m, share).normalize_or_zero(), 0.0);
        (0..parts as usize).map(move |i| at(i as f64 / parts))
    };
    side.windows(2).flat_map(between).chain(side.last().copied()).collect()
}

/// The first of three unknowns of control point `i`, those of the upper guide counted on. Those of a ring go around
/// both ways by turns, so that its last ones stand beside its first.
fn first_unknown(i: usize, knots: &Knots) -> usize {
    let n = knots.count();
    let (side, i) = (i / n, i % n);
    let place = match knots.is_closed {
        false => i,
        true if i < n.div_ceil(2) => 2 * i,
        true => 2 * (n - 1 - i) + 1,
    };
    6 * place + 3 * side
}

/// How far the unknowns of four neighbouring control points are apart at most, and one more: three control points, or
/// six where they go both ways by turns.
fn band_width(knots: &Knots) -> usize {
    6 * if knots.is_closed { 7 } else { 4 }
}

/// The strip with its control points moved, if all of them are points.
fn moved(strip: &Strip, step: &[f64]) -> Option<Strip> {
    let n = strip.count();
    let at = |i: usize| DVec3::from_slice(&step[first_unknown(i, &strip.knots)..]);
    let guide = |points: &[DVec3], from: usize| -> Vec<DVec3> {
        points.iter().enumerate().map(|(i, p)| *p + at(from + i)).collect()
    };
    let next = Strip { knots: strip.knots.clone(), lower: guide(&strip.lower, 0), upper: guide(&strip.upper, n) };
    next.lower.iter().chain(&next.upper).all(|p| p.is_finite()).then_some(next)
}
