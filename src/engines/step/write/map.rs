//! Maps of pieces to the unit square.
//!
//! Every vertex inside lies in the weighted middle of its neighbours (Tutte), so that no triangle is turned over. The
//! weights are those of a harmonic map where they are positive.

use std::collections::{HashMap, HashSet};

use glam::{DVec2, DVec3};

use super::piece::Piece;
use super::skin::sides_of;

/// Bounds of the weights, the greatest part of them against the mean.
const WEIGHTS: [f64; 2] = [1e-2, 50.0];
/// Steps of the method of conjugate gradients at most, and the share of the residual at which it ends.
const STEPS: usize = 4000;
const RESIDUAL: f64 = 1e-9;

/// A piece laid out in the unit square.
#[derive(Debug, Clone, Default)]
pub(super) struct Map {
    /// Vertices of the piece, and the middles of sides that lead from a side of the square to itself (mm).
    pub(super) points: Vec<DVec3>,
    /// Places of the points in the square.
    pub(super) places: Vec<DVec2>,
    /// Triangles.
    pub(super) triangles: Vec<[u32; 3]>,
}

impl Map {
    /// The map of a disc whose vertices on the border have these places.
    pub(super) fn of(piece: &Piece, on_border: &HashMap<u32, DVec2>) -> Self {
        let mut map = Self { points: piece.points.clone(), places: Vec::new(), triangles: piece.triangles.clone() };
        map.split_flat_sides(on_border);
        let place = |v: u32| on_border.get(&v).copied();
        map.places = (0..map.points.len() as u32).map(|v| place(v).unwrap_or(DVec2::splat(0.5))).collect();
        let is_fixed: Vec<bool> = (0..map.points.len() as u32).map(|v| place(v).is_some()).collect();
        let links = map.links();
        map.solve(&links, &is_fixed);
        map
    }

    /// Splits sides inside whose ends lie on the same side of the square: their triangles would have no area there.
    fn split_flat_sides(&mut self, on_border: &HashMap<u32, DVec2>) {
        let is_flat = |a: u32, b: u32| {
            let (Some(p), Some(q)) = (on_border.get(&a), on_border.get(&b)) else { return false };
            (0..2).any(|k| p[k] == q[k] && (p[k] == 0.0 || p[k] == 1.0))
        };
        let mut owner: HashSet<(u32, u32)> = HashSet::new();
        self.triangles.iter().for_each(|t| owner.extend(sides_of(*t)));
        let mut middle: HashMap<(u32, u32), u32> = HashMap::new();
        for t in &self.triangles {
            for (a, b) in sides_of(*t) {
                if a < b && owner.contains(&(b, a)) && is_flat(a, b) {
                    middle.insert((a, b), self.points.len() as u32);
                    self.points.push(0.5 * (self.points[a as usize] + self.points[b as usize]));
                }
            }
        }
        if middle.is_empty() {
            return;
        }
        let old = std::mem::take(&mut self.triangles);
        for t in old {
            self.triangles.extend(split(t, &middle));
        }
    }

    /// The neighbours of every vertex with the weights of the sides to them.
    fn links(&self) -> Vec<Vec<(u32, f64)>> {
        let mut weights: HashMap<(u32, u32), f64> = HashMap::new();
        let mut order = Vec::new();
        for t in &self.triangles {
            for k in 0..3 {
                let [a, b, c] = [t[k], t[(k + 1) % 3], t[(k + 2) % 3]];
                let [p, q, r] = [a, b, c].map(|v| self.points[v as usize]);
                let (d, e) = (p - r, q - r);
                let cotangent = d.dot(e) / d.cross(e).length().max(1e-9 * d.dot(e).abs().max(f64::MIN_POSITIVE));
                let key = (a.min(b), a.max(b));
                let weight = weights.entry(key).or_insert_with(|| {
                    order.push(key);
                    0.0
                });
                *weight += 0.5 * cotangent;
            }
        }
        let mut links = vec![Vec::new(); self.points.len()];
        for (a, b) in order {
            let weight = weights[&(a, b)].clamp(WEIGHTS[0], WEIGHTS[1]);
            links[a as usize].push((b, weight));
            links[b as usize].push((a, weight));
        }
        links
    }

    /// Puts every vertex that is not fixed in the middle of its neighbours, by conjugate gradients.
    fn solve(&mut self, links: &[Vec<(u32, f64)>], is_fixed: &[bool]) {
        let free: Vec<usize> = (0..links.len()).filter(|&i| !is_fixed[i]).collect();
        let sums: Vec<f64> = links.iter().map(|l| l.iter().map(|(_, w)| w).sum::<f64>().max(1e-12)).collect();
        let residual = |x: &[DVec2], i: usize| -> DVec2 {
            links[i].iter().map(|&(j, w)| (x[j as usize] - x[i]) * w).sum::<DVec2>()
        };
        let mut left = vec![DVec2::ZERO; links.len()];
        free.iter().for_each(|&i| left[i] = residual(&self.places, i));
        let mut along: Vec<DVec2> = vec![DVec2::ZERO; links.len()];
        free.iter().for_each(|&i| along[i] = left[i] / sums[i]);
        // Both coordinates are solved for at once, each with steps of its own.
        let product = |left: &[DVec2]| free.iter().map(|&i| left[i] * left[i] / sums[i]).sum::<DVec2>();
        let mut now = product(&left);
        let enough = now * (RESIDUAL * RESIDUAL);
        let share = |a: DVec2, b: DVec2| {
            DVec2::new(if b.x > 0.0 { a.x / b.x } else { 0.0 }, if b.y > 0.0 { a.y / b.y } else { 0.0 })
        };
        for _ in 0..STEPS {
            if now.cmple(enough).all() {
                break;
            }
            let mut image = vec![DVec2::ZERO; links.len()];
            free.iter().for_each(|&i| image[i] = -residual(&along, i));
            let bend = free.iter().map(|&i| along[i] * image[i]).sum::<DVec2>();
            let step = share(now, bend);
            for &i in &free {
                self.places[i] += along[i] * step;
                left[i] -= image[i] * step;
            }
            let next = product(&left);
            let carry = share(next, now);
            free.iter().for_each(|&i| along[i] = left[i] / sums[i] + along[i] * carry);
            now = next;
        }
    }

    /// The points of the piece at the places (`us[i]`, `vs[j]`), at `i * vs.len() + j`.
    pub(super) fn sampled(&self, us: &[f64], vs: &[f64]) -> Vec<DVec3> {
        let mut found = vec![(f64::NEG_INFINITY, DVec3::ZERO); us.len() * vs.len()];
        for t in &self.triangles {
            let [p, q, r] = t.map(|v| self.places[v as usize]);
            let area = (q - p).perp_dot(r - p);
            if area <= 0.0 || area.is_nan() {
                continue;
            }
            let (low, high) = (p.min(q).min(r) - 1e-9, p.max(q).max(r) + 1e-9);
            let range =
                |all: &[f64], k: usize| all.partition_point(|x| *x < low[k])..all.partition_point(|x| *x <= high[k]);
            for i in range(us, 0) {
                for j in range(vs, 1) {
                    let x = DVec2::new(us[i], vs[j]);
                    let shares =
                        [(q - x).perp_dot(r - x), (r - x).perp_dot(p - x), (p - x).perp_dot(q - x)].map(|a| a / area);
                    let within = shares.into_iter().fold(f64::INFINITY, f64::min);
                    let entry = &mut found[i * vs.len() + j];
                    if within > entry.0 {
                        let corners = t.map(|v| self.points[v as usize]);
                        *entry = (within, (0..3).map(|k| corners[k] * shares[k]).sum());
                    }
                }
            }
        }
        self.fill(us, vs, found)
    }

    /// Gives places that no triangle holds, by rounding, the nearest vertex.
    fn fill(&self, us: &[f64], vs: &[f64], found: Vec<(f64, DVec3)>) -> Vec<DVec3> {
        let nearest = |n: usize| {
            let x = DVec2::new(us[n / vs.len()], vs[n % vs.len()]);
            let far = |v: &usize| self.places[*v].distance_squared(x);
            (0..self.places.len()).min_by(|a, b| far(a).total_cmp(&far(b))).map_or(DVec3::ZERO, |v| self.points[v])
        };
        found.iter().enumerate().map(|(n, f)| if f.0 > -1e-3 { f.1 } else { nearest(n) }).collect()
    }
}

/// A triangle over its corners and the middles of its sides that have one.
fn split(t: [u32; 3], middle: &HashMap<(u32, u32), u32>) -> Vec<[u32; 3]> {
    let found = sides_of(t).map(|(a, b)| middle.get(&(a.min(b), a.max(b))).copied());
    // Turned so that the first side has a middle, and the last none unless all have.
    let turn =
        (0..3).find(|&k| found[k].is_some() && (found[(k + 2) % 3].is_none() || found.iter().all(Option::is_some)));
    let Some(k) = turn else { return vec![t] };
    let [a, b, c] = [k, (k + 1) % 3, (k + 2) % 3].map(|i| t[i]);
    match [k, (k + 1) % 3, (k + 2) % 3].map(|i| found[i]) {
        [Some(m), None, _] => vec![[a, m, c], [m, b, c]],
        [Some(m), Some(n), None] => vec![[m, b, n], [a, m, n], [a, n, c]],
        [Some(m), Some(n), Some(o)] => vec![[a, m, o], [m, b, n], [o, n, c], [m, n, o]],
        _ => vec![t],
    }
}
