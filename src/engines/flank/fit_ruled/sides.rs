//! The four sides of a face: two along the guides, two that are the end rulings.

use std::f64::consts::TAU;

use glam::DVec3;
use nalgebra::{Matrix3, SymmetricEigen, Vector3};

use super::knots::Knots;
use super::patch::Patch;
use super::strip::Strip;

/// Corners of a border that are tried, the sharpest.
const MOST_CORNERS: usize = 10;
/// Ways to take the sides that are tried by a fit.
const MOST_TRIED: usize = 6;
/// Points that a side is laid out by.
const LAID: usize = 64;

/// The sides of a strip. Both guides run the same way, so that along them crossed with from lower to upper is outwards.
#[derive(Debug, Clone)]
pub(super) struct Sides {
    /// The points of the lower and of the upper guide with their normals.
    pub guides: [Vec<(DVec3, DVec3)>; 2],
    /// Whether the strip ends where it starts, at a seam.
    pub is_ring: bool,
    /// How unlike a strip it is at first sight.
    pub cost: f64,
}

/// The ways to take the sides of a face, the likeliest first.
pub(super) fn choices(patch: &Patch, up: DVec3) -> Vec<Sides> {
    if let [first, second, ..] = &patch.loops[..]
        && is_ring(patch, [first, second])
    {
        return ring(patch, [first, second], up);
    }
    let Some(around) = patch.loops.first() else { return Vec::new() };
    let border = Border::of(patch, around);
    let mut found = Vec::new();
    let corners = border.corners();
    for a in 0..corners.len() {
        for b in a + 1..corners.len() {
            for c in b + 1..corners.len() {
                for d in c + 1..corners.len() {
                    border.ways([a, b, c, d].map(|i| corners[i].0), &corners, &mut found);
                }
            }
        }
    }
    if let Some(four) = border.box_corners(patch) {
        border.ways(four, &corners, &mut found);
    }
    found.sort_by(|x, y| x.1.total_cmp(&y.1));
    found.dedup_by_key(|x| x.0);
    found.truncate(MOST_TRIED);
    found.into_iter().map(|(four, cost)| border.sides(four, cost, up)).collect()
}

/// Whether the face runs around between two borders: normals along both turn all around, as those around a hole do not.
fn is_ring(patch: &Patch, loops: [&Vec<u32>; 2]) -> bool {
    let mean = |around: &Vec<u32>| {
        let (mut sum, mut length) = (DVec3::ZERO, 0.0);
        for i in 0..around.len() {
            let [p, q] = [around[i], around[(i + 1) % around.len()]].map(|v| v as usize);
            let part = patch.points[p].distance(patch.points[q]);
            sum += 0.5 * part * (patch.normals[p] + patch.normals[q]);
            length += part;
        }
        sum.length() / length.max(1e-300)
    };
    let [long, short] = loops.map(|l| patch.length(l));
    patch.loops.get(2).is_none_or(|third| patch.length(third) < 0.3 * short)
        && loops.iter().all(|l| mean(l) < 0.8)
        && short > 0.05 * long
}

/// A ring with its seam at a ruling: where the longest side of its lower border starts, which is at a corner of a wall
/// all around or where a rounding goes over into a plane.
fn ring(patch: &Patch, [first, second]: [&Vec<u32>; 2], up: DVec3) -> Vec<Sides> {
    let height = |around: &Vec<u32>| {
        let sum: f64 = around.iter().map(|&v| patch.points[v as usize].dot(up)).sum();
        sum / around.len() as f64
    };
    let (low, high) = if height(first) <= height(second) { (first, second) } else { (second, first) };
    let border = Border::of(patch, low);
    let longest = |i: usize, k: usize| if border.side(k) > border.side(i) * (1.0 + 1e-6) { k } else { i };
    let start = (0..border.points.len()).fold(0, longest);
    let opposite = Border::of(patch, high);
    let (p, n) = (border.points[start], border.normals[start]);
    let nearest = opposite.points.iter().map(|q| q.distance(p)).fold(f64::INFINITY, f64::min);
    // A ruling lies in the tangent planes at both of its ends.
    let off = |i: &usize| {
        let along = (opposite.points[*i] - p).normalize_or_zero();
        along.dot(n).abs() + along.dot(opposite.normals[*i]).abs() + 0.02 * (opposite.points[*i] - p).length() / nearest
    };
    let within = (0..opposite.points.len()).filter(|&i| opposite.points[i].distance(p) <= 1.5 * nearest);
    let Some(end) = within.min_by(|a, b| off(a).total_cmp(&off(b))) else { return Vec::new() };
    let lower: Vec<usize> = (0..=border.points.len()).map(|i| (start + i) % border.points.len()).collect();
    let count = opposite.points.len();
    let upper: Vec<usize> = (0..=count).map(|i| (end + count - i % count) % count).collect();
    let guides = [border.laid(&lower), opposite.laid(&upper)];
    vec![Sides { guides, is_ring: true, cost: 0.0 }]
}

/// A closed border, laid out.
struct Border {
    points: Vec<DVec3>,
    normals: Vec<DVec3>,
    /// Length from the first point to each (mm), and all around.
    lengths: Vec<f64>,
}

impl Border {
    fn of(patch: &Patch, around: &[u32]) -> Self {
        let points: Vec<DVec3> = around.iter().map(|&v| patch.points[v as usize]).collect();
        let normals = around.iter().map(|&v| patch.normals[v as usize]).collect();
        let mut lengths = vec![0.0];
        for i in 0..points.len() {
            lengths.push(lengths[i] + points[i].distance(points[(i + 1) % points.len()]));
        }
        Self { points, normals, lengths }
    }

    /// Length from point `i` to the next (mm).
    fn side(&self, i: usize) -> f64 {
        self.lengths[i + 1] - self.lengths[i]
    }

    fn total(&self) -> f64 {
        self.lengths[self.points.len()]
    }

    /// The point `length` along the border, which may go around.
    fn at(&self, length: f64) -> DVec3 {
        let n = self.points.len();
        let length = length.rem_euclid(self.total());
        let i = self.lengths.partition_point(|l| *l <= length).clamp(1, n) - 1;
        let part = (length - self.lengths[i]) / (self.lengths[i + 1] - self.lengths[i]).max(1e-300);
        self.points[i].lerp(self.points[(i + 1) % n], part.clamp(0.0, 1.0))
    }

    /// Points where the border turns into the face by 25 degrees or more, at once and over a stretch, with the angle,
    /// in order: the sharpest within their stretch.
    fn corners(&self) -> Vec<(usize, f64)> {
        let n = self.points.len();
        let reach = 0.012 * self.total();
        let turn = |i: usize, reach: f64| {
            let l = self.lengths[i];
            let (before, after) = (self.points[i] - self.at(l - reach), self.at(l + reach) - self.points[i]);
            before.cross(after).dot(self.normals[i]).atan2(before.dot(after))
        };
        let angle = |i: usize| {
            let sides = [(i + n - 1) % n, i].map(|k| self.side(k));
            let small = (0.5 * sides[0].min(sides[1])).max(0.002 * self.total());
            // A notch of a ragged border turns back within a stretch, a corner does not.
            turn(i, reach).max(turn(i, small)).min(turn(i, 3.0 * reach))
        };
        let angles: Vec<f64> = (0..n).map(angle).collect();
        let apart = |i: usize, j: usize| {
            let d = (self.lengths[i] - self.lengths[j]).abs();
            d.min(self.total() - d)
        };
        let mut order: Vec<usize> = (0..n).filter(|&i| angles[i] >= 25f64.to_radians()).collect();
        order.sort_by(|&a, &b| angles[b].total_cmp(&angles[a]).then(a.cmp(&b)));
        let mut found: Vec<usize> = Vec::new();
        for i in order {
            if found.len() < MOST_CORNERS && found.iter().all(|&j| apart(i, j) > 0.6 * reach) {
                found.push(i);
            }
        }
        found.sort_unstable();
        found.into_iter().map(|i| (i, angles[i])).collect()
    }

    /// The points of the border farthest to the four corners of a box along the ruling and across it. The normals of a
    /// strip turn least along its rulings, so that these are across all normals as near as can be.
    fn box_corners(&self, patch: &Patch) -> Option<[usize; 4]> {
        let mut sums = Matrix3::<f64>::zeros();
        let mut mean = DVec3::ZERO;
        for (n, share) in patch.normals.iter().zip(&patch.shares) {
            let v = Vector3::new(n.x, n.y, n.z);
            sums += v * v.transpose() * *share;
            mean += *n * *share;
        }
        let eigen = SymmetricEigen::try_new(sums, 1e-15, 200)?;
        let least = eigen.eigenvalues.imin();
        let column = eigen.eigenvectors.column(least);
        let along = DVec3::new(column[0], column[1], column[2]);
        let across = along.cross(mean).normalize_or_zero();
        let span = |d: DVec3| {
            let of = |pick: fn(f64, f64) -> f64, start: f64| self.points.iter().map(|p| p.dot(d)).fold(start, pick);
            (of(f64::max, f64::NEG_INFINITY) - of(f64::min, f64::INFINITY)).max(1e-9 * patch.size)
        };
        let (x, y) = (across / span(across), along / span(along));
        let farthest = |d: DVec3| {
            let value = |i: &usize| self.points[*i].dot(d);
            (0..self.points.len()).reduce(|a, b| if value(&b) > value(&a) { b } else { a })
        };
        let mut four = [farthest(-x - y)?, farthest(x - y)?, farthest(x + y)?, farthest(y - x)?];
        four.sort_unstable();
        four.windows(2).all(|w| w[0] < w[1]).then_some(four)
    }

    /// Both ways to take four corners; the first side of each is a guide.
    fn ways(&self, [a, b, c, d]: [usize; 4], corners: &[(usize, f64)], found: &mut Vec<([usize; 4], f64)>) {
        for four in [[a, b, c, d], [b, c, d, a]] {
            let [i, j, k, l] = four;
            let missed: f64 = corners.iter().filter(|c| !four.contains(&c.0)).map(|c| c.1 / TAU).sum();
            let ends = [self.bend(j, k), self.bend(l, i)];
            let guides = [self.length(i, j), self.length(k, l)];
            let rulings = [self.length(j, k), self.length(l, i)];
            let unlike = |[x, y]: [f64; 2]| 1.0 - x.min(y) / x.max(y).max(1e-300);
            let cost = ends[0] + ends[1] + missed + 0.05 * (unlike(guides) + unlike(rulings));
            if guides.iter().chain(&rulings).all(|l| *l > 1e-6 * self.total()) {
                found.push((four, cost));
            }
        }
    }

    fn length(&self, from: usize, to: usize) -> f64 {
        (self.lengths[to] - self.lengths[from]).rem_euclid(self.total())
    }

    /// How far the border between two points leaves their chord, as a share of it.
    fn bend(&self, from: usize, to: usize) -> f64 {
        let (a, b) = (self.points[from], self.points[to]);
        let along = (b - a).normalize_or_zero();
        let off = |i: usize| across(self.points[i] - a, along).length();
        self.stretch(from, to).map(off).fold(0.0, f64::max) / a.distance(b).max(1e-300)
    }

    fn stretch(&self, from: usize, to: usize) -> impl Iterator<Item = usize> + '_ {
        let n = self.points.len();
        (0..=(to + n - from) % n).map(move |i| (from + i) % n)
    }

    fn laid(&self, order: &[usize]) -> Vec<(DVec3, DVec3)> {
        order.iter().map(|&i| (self.points[i], self.normals[i])).collect()
    }

    /// The sides from four corners in order around the face, the first side a guide.
    fn sides(&self, [a, b, c, d]: [usize; 4], cost: f64, up: DVec3) -> Sides {
        let side = |from: usize, to: usize| self.laid(&self.stretch(from, to).collect::<Vec<usize>>());
        let back = |mut side: Vec<(DVec3, DVec3)>| {
            side.reverse();
            side
        };
        let (first, second) = (side(a, b), side(c, d));
        let height = |side: &[(DVec3, DVec3)]| side.iter().map(|p| p.0.dot(up)).sum::<f64>() / side.len() as f64;
        let guides = if height(&first) <= height(&second) { [first, back(second)] } else { [second, back(first)] };
        Sides { guides, is_ring: false, cost }
    }
}

impl Sides {
    /// The first surface between the guides: with points at equal shares of their lengths on one ruling, or with those
    /// whose ruling lies best in the tangent planes at both of its ends.
    pub(super) fn strip(&self, count: usize, by_tangents: bool) -> Option<Strip> {
        let laid = [0, 1].map(|side| even(&self.guides[side]));
        let pairs: Vec<[usize; 2]> = if by_tangents { matched(&laid) } else { (0..=LAID).map(|i| [i, i]).collect() };
        let steps = pairs.iter().map(|&[i, j]| 0.5 * (i + j) as f64 / LAID as f64);
        let ends: Vec<[DVec3; 2]> = pairs.iter().map(|&[i, j]| [laid[0][i].0, laid[1][j].0]).collect();
        Strip::through(Knots::even(count, self.is_ring), &steps.collect::<Vec<f64>>(), &ends)
    }
}

/// Component of `p` across the unit vector `along`.
fn across(p: DVec3, along: DVec3) -> DVec3 {
    p - along * p.dot(along)
}

/// Points at even lengths, with normals.
fn even(side: &[(DVec3, DVec3)]) -> Vec<(DVec3, DVec3)> {
    let mut lengths = vec![0.0];
    for (i, w) in side.windows(2).enumerate() {
        lengths.push(lengths[i] + w[0].0.distance(w[1].0));
    }
    let total = lengths[lengths.len() - 1];
    let at = |k: usize| {
        let length = total * k as f64 / LAID as f64;
        let i = lengths.partition_point(|l| *l <= length).clamp(1, side.len() - 1) - 1;
        let part = ((length - lengths[i]) / (lengths[i + 1] - lengths[i]).max(1e-300)).clamp(0.0, 1.0);
        (side[i].0.lerp(side[i + 1].0, part), side[i].1.lerp(side[i + 1].1, part).normalize_or_zero())
    };
    (0..=LAID).map(at).collect()
}

/// Pairs of points from the first to the last, by dynamic programming: least sum of the squares by which rulings leave
/// the tangent planes, with a little for stretching.
fn matched(laid: &[Vec<(DVec3, DVec3)>; 2]) -> Vec<[usize; 2]> {
    const MOST: usize = 4;
    let n = LAID + 1;
    let cost = |i: usize, j: usize| {
        let ((p, np), (q, nq)) = (laid[0][i], laid[1][j]);
        let along = (q - p).normalize_or_zero();
        let apart = (i as f64 - j as f64) / LAID as f64;
        along.dot(np).powi(2) + along.dot(nq).powi(2) + 1e-4 * apart * apart
    };
    let mut best = vec![(f64::INFINITY, [0usize; 2]); n * n];
    best[0] = (cost(0, 0), [0, 0]);
    for i in 1..n {
        for j in 1..n {
            let here = cost(i, j);
            for (di, dj) in (1..=MOST).map(|k| (k, 1)).chain((2..=MOST).map(|k| (1, k))) {
                if di > i || dj > j {
                    continue;
                }
                let (before, _) = best[(i - di) * n + j - dj];
                let total = before + here * 0.5 * (di + dj) as f64;
                if total < best[i * n + j].0 {
                    best[i * n + j] = (total, [i - di, j - dj]);
                }
            }
        }
    }
    let mut pairs = vec![[LAID, LAID]];
    while let Some(&[i, j]) = pairs.last()
        && (i, j) != (0, 0)
        && best[i * n + j].0.is_finite()
    {
        pairs.push(best[i * n + j].1);
    }
    pairs.reverse();
    pairs
}
