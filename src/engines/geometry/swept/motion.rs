//! Least distances to a body over its motion.
//!
//! From one placement to another no point of the body goes further than the way between them, so that no distance to
//! the body changes by more: with distances `d` and `e` at both ends of a run of placements that is `w` long, none
//! within the run is below `(d + e - w) / 2`. Runs are halved only where that bound leaves something to be found.

use glam::{DAffine3, DVec3};

use crate::distance_field::DistanceField;
use crate::mesh::{Bounds, Mesh};

/// Steps of the search for the least distance between two placements: what is left of a step is 1 %.
const GOLDEN_STEPS: usize = 10;
/// Difference of distances that is not worth looking for (mm).
const SAME: f64 = 1e-3;

/// A body in motion.
pub(super) struct Motion {
    field: DistanceField,
    body: Bounds,
    /// From the world to the body, for every placement.
    to_body: Vec<DAffine3>,
    /// Upper bound of the motion of any point of the body from the first placement (mm).
    way: Vec<f64>,
}

/// The placements that matter near some place: runs of neighbours, by their first and last.
#[derive(Default)]
pub(super) struct Near {
    runs: Vec<[usize; 2]>,
    /// Whether the body covers the whole place in one of its placements.
    pub covered: bool,
}

impl Near {
    /// Whether no placement matters.
    pub(super) fn is_empty(&self) -> bool {
        self.runs.is_empty()
    }

    /// The first placement that matters.
    pub(super) fn first(&self) -> usize {
        self.runs.first().map_or(0, |run| run[0])
    }
}

/// The nearest place of the swept surface.
pub(super) struct Touch {
    /// Signed distance (mm), negative inside.
    pub distance: f64,
    /// Unit vector away from the body; zero where that is unknown.
    pub normal: DVec3,
}

/// A placement and the distance to the body in it.
#[derive(Clone, Copy)]
struct Known {
    index: usize,
    distance: f64,
}

impl Motion {
    pub(super) fn new(body: &Mesh, field: DistanceField, placements: &[DAffine3]) -> Self {
        let bounds = body.bounds();
        let corners = bounds.corners();
        let mut way = vec![0.0];
        way.extend(placements.windows(2).scan(0.0, |sum, pair| {
            // The way is a convex function of the point: greatest at a corner of the box.
            let moved = corners.map(|c| pair[0].transform_point3(c).distance(pair[1].transform_point3(c)));
            *sum += moved.into_iter().fold(0.0, f64::max);
            Some(*sum)
        }));
        Self { field, body: bounds, to_body: placements.iter().map(DAffine3::inverse).collect(), way }
    }

    /// The placements in which the body may come within `radius` of `center`.
    pub(super) fn near(&self, center: DVec3, radius: f64) -> Near {
        let mut near = Near::default();
        let [first, last] = self.ends([0, self.to_body.len() - 1], center);
        self.collect(center, radius, first, last, &mut near);
        near
    }

    fn collect(&self, center: DVec3, radius: f64, a: Known, b: Known, near: &mut Near) {
        near.covered |= a.distance.min(b.distance) < -(radius + doubt(radius));
        if near.covered || self.bound(a, b) > radius {
            return;
        }
        if b.index - a.index <= 1 || self.way[b.index] - self.way[a.index] <= 0.5 * radius {
            match near.runs.last_mut() {
                Some([_, end]) if *end == a.index => *end = b.index,
                _ => near.runs.push([a.index, b.index]),
            }
            return;
        }
        let middle = self.known((a.index + b.index) / 2, center);
        self.collect(center, radius, a, middle, near);
        self.collect(center, radius, middle, b, near);
    }

    /// Whether the body covers `p` in one of these placements; `last` is the one that did the last time.
    pub(super) fn covers(&self, near: &Near, p: DVec3, last: &mut usize) -> bool {
        self.known(*last, p).distance < 0.0
            || near.runs.iter().any(|&run| {
                let [a, b] = self.ends(run, p);
                self.run_covers(p, a, b, last)
            })
    }

    fn run_covers(&self, p: DVec3, a: Known, b: Known, last: &mut usize) -> bool {
        for end in [a, b] {
            if end.distance < 0.0 {
                *last = end.index;
                return true;
            }
        }
        if b.index - a.index <= 1 || self.bound(a, b) > 0.0 {
            return false;
        }
        let middle = self.known((a.index + b.index) / 2, p);
        self.run_covers(p, a, middle, last) || self.run_covers(p, middle, b, last)
    }

    /// The nearest place to `p` of the body in these placements and between them.
    pub(super) fn nearest(&self, near: &Near, p: DVec3) -> Touch {
        let mut best = Known { index: 0, distance: f64::INFINITY };
        for &run in &near.runs {
            let [a, b] = self.ends(run, p);
            for end in [a, b] {
                if end.distance < best.distance {
                    best = end;
                }
            }
            self.search(p, a, b, &mut best);
        }
        if !best.distance.is_finite() {
            return Touch { distance: f64::INFINITY, normal: DVec3::ZERO };
        }
        self.between(p, best)
    }

    fn search(&self, p: DVec3, a: Known, b: Known, best: &mut Known) {
        if b.index - a.index <= 1 || self.bound(a, b) > best.distance - SAME {
            return;
        }
        let middle = self.known((a.index + b.index) / 2, p);
        if middle.distance < best.distance {
            *best = middle;
        }
        self.search(p, a, middle, best);
        self.search(p, middle, b, best);
    }

    /// The least distance between the neighbours of the best placement, by the golden section.
    fn between(&self, p: DVec3, best: Known) -> Touch {
        let place = |i: usize| self.to_body[i].transform_point3(p);
        let here = place(best.index);
        let before = place(best.index.saturating_sub(1));
        let after = place((best.index + 1).min(self.to_body.len() - 1));
        let at = |t: f64| if t < 0.0 { here.lerp(before, -t) } else { here.lerp(after, t) };
        let value = |t: f64| self.distance(at(t));
        let ratio = 0.5 * (5f64.sqrt() - 1.0);
        let (mut low, mut high) = (-1.0, 1.0);
        let (mut s, mut t) = (high - ratio * (high - low), low + ratio * (high - low));
        let (mut at_s, mut at_t) = (value(s), value(t));
        for _ in 0..GOLDEN_STEPS {
            if at_s <= at_t {
                (high, t, at_t) = (t, s, at_s);
                s = high - ratio * (high - low);
                at_s = value(s);
            } else {
                (low, s, at_s) = (s, t, at_t);
                t = low + ratio * (high - low);
                at_t = value(t);
            }
        }
        let (found, least) = if at_s <= at_t { (s, at_s) } else { (t, at_t) };
        let q = if least < best.distance { at(found) } else { here };
        let (distance, gradient) = self.field.value_and_gradient(q).unwrap_or((best.distance, DVec3::ZERO));
        let normal = self.to_body[best.index].matrix3.transpose() * gradient;
        Touch { distance, normal: normal.normalize_or_zero() }
    }

    fn ends(&self, run: [usize; 2], p: DVec3) -> [Known; 2] {
        run.map(|index| self.known(index, p))
    }

    fn known(&self, index: usize, p: DVec3) -> Known {
        Known { index, distance: self.distance(self.to_body[index].transform_point3(p)) }
    }

    /// Distance from the body in its own frame; beyond the field no more than that.
    fn distance(&self, q: DVec3) -> f64 {
        let to_box = || q.distance(q.clamp(self.body.min, self.body.max));
        self.field.value(q).unwrap_or_else(to_box)
    }

    /// Lower bound of all distances in a run, from those at its ends.
    fn bound(&self, a: Known, b: Known) -> f64 {
        let sure = |d: f64| d - doubt(d);
        0.5 * (sure(a.distance) + sure(b.distance) - (self.way[b.index] - self.way[a.index]))
    }
}

/// How far a distance read from a field may be off (mm).
fn doubt(distance: f64) -> f64 {
    DistanceField::ACCURACY + 0.08 * (distance.abs() - DistanceField::NEAR).max(0.0)
}
