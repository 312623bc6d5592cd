//! The objective of P0: smooth motion of every axis (4), and an electrode that keeps to the middle (5).

use files::Invalid;
use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::pose::{Axis, Pose};
use super::samples::Sample;
use geometry::mesh::Bounds;
use task::{Cancel, Cancelled};
use wheel::channel::{BladeSpan, Channel};
use wheel::electrode::ElectrodeFace;
use wheel::surface_finder::SurfaceFinder;

/// Weights of the objective; within each group only the ratios count, and each is used scaled to sum 1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Weights {
    /// a1: smoothness of Z, or of X where the electrode is withdrawn along Z.
    pub a1: f64,
    /// b1: smoothness of Y.
    pub b1: f64,
    /// c1: smoothness of C.
    pub c1: f64,
    /// Smoothness of A, where the machine has it; P0 keeps A still.
    pub d1: f64,
    /// Smoothness of B, where the machine has it.
    pub e1: f64,
    /// a2: equal least distances to both walls.
    pub a2: f64,
    /// b2: even distances along the low (P0: left) wall.
    pub b2: f64,
    /// c2: even distances along the high (P0: right) wall.
    pub c2: f64,
    /// a3: the smoothness objective as a whole.
    pub a3: f64,
    /// b3: the centring objective as a whole.
    pub b3: f64,
}

impl Default for Weights {
    fn default() -> Self {
        let third = 1.0 / 3.0;
        Self { a1: 0.2, b1: 0.2, c1: 0.2, d1: 0.2, e1: 0.2, a2: third, b2: third, c2: third, a3: 0.5, b3: 0.5 }
    }
}

impl Weights {
    /// Whether every group has a usable sum.
    pub fn validate(&self) -> Result<(), Invalid> {
        let groups: [(&'static str, &[f64]); 3] = [
            ("a1, b1, c1, d1, e1", &[self.a1, self.b1, self.c1, self.d1, self.e1]),
            ("a2, b2, c2", &[self.a2, self.b2, self.c2]),
            ("a3, b3", &[self.a3, self.b3]),
        ];
        for (names, group) in groups {
            if !group.iter().all(|w| w.is_finite() && *w >= 0.0) || group.iter().sum::<f64>() <= 0.0 {
                return Err(Invalid::of(
                    names,
                    "weights must be finite, not negative, and not all zero in their group",
                ));
            }
        }
        Ok(())
    }

    /// The weights as they are used: each group summing to 1, the first over the axes that move.
    pub fn normalised(&self, axes: &[Axis]) -> Self {
        let used = |axis: Axis, w: f64| if axes.contains(&axis) { w } else { 0.0 };
        let first = [
            if axes.contains(&Axis::Z) { self.a1 } else { used(Axis::X, self.a1) },
            used(Axis::Y, self.b1),
            used(Axis::C, self.c1),
            used(Axis::A, self.d1),
            used(Axis::B, self.e1),
        ];
        let [a1, b1, c1, d1, e1] = scaled_to_one(first);
        let [a2, b2, c2] = scaled_to_one([self.a2, self.b2, self.c2]);
        let [a3, b3] = scaled_to_one([self.a3, self.b3]);
        Self { a1, b1, c1, d1, e1, a2, b2, c2, a3, b3 }
    }

    /// Smoothness weight of an axis.
    fn smoothness(&self, axis: Axis) -> f64 {
        match axis {
            // Of X and Z one is the axis of withdrawal, which has no range, and the other leads across the passage.
            Axis::X | Axis::Z => self.a1,
            Axis::Y => self.b1,
            Axis::A => self.d1,
            Axis::B => self.e1,
            Axis::C => self.c1,
        }
    }
}

fn scaled_to_one<const N: usize>(weights: [f64; N]) -> [f64; N] {
    let sum: f64 = weights.iter().sum();
    if sum > 0.0 { weights.map(|w| w / sum) } else { weights }
}

/// Obj1 and Obj2 of a pose and their weighted sum.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObjectiveValue {
    /// Obj1 (4): unsmoothness.
    pub smoothness: f64,
    /// Obj2 (5): eccentricity.
    pub centring: f64,
    /// a3 Obj1 + b3 Obj2 (6).
    pub total: f64,
}

/// The objective over one electrode and channel.
pub struct Objective<'a> {
    weights: Weights,
    /// Full ranges of the axes' motion (7), in the order of [`Axis`].
    ranges: [f64; 6],
    reference_point: DVec3,
    low: Vec<DVec3>,
    high: Vec<DVec3>,
    walls: &'a WallDistances,
    blades: BladeSpan,
}

/// A motion of the axes within one search step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepMotion {
    /// Axis increments of the step (mm, rad).
    pub increments: [f64; 6],
    /// The step's length over the nominal one: P0's time between two steps.
    pub duration: f64,
}

impl StepMotion {
    /// The motion from one pose to another in `duration` nominal steps.
    pub fn between(from: &Pose, to: &Pose, duration: f64) -> Self {
        let (p, q) = (from.to_array(), to.to_array());
        Self { increments: std::array::from_fn(|i| q[i] - p[i]), duration }
    }
}

impl<'a> Objective<'a> {
    /// Most samples of each wall that are used, spread evenly.
    const WALL_SAMPLES: usize = 120;

    /// Prepares the objective for an electrode with `samples` and reference point O (in W) in `channel`;
    /// `ranges` are the full ranges of motion of the axes by (7).
    pub fn new(
        weights: Weights,
        ranges: [f64; 6],
        samples: &[Sample],
        reference_point: DVec3,
        channel: &Channel,
        walls: &'a WallDistances,
    ) -> Self {
        let on = |face: ElectrodeFace| {
            let all: Vec<DVec3> = samples.iter().filter(|s| s.face == face).map(|s| s.point).collect();
            let stride = all.len().div_ceil(Self::WALL_SAMPLES).max(1);
            all.into_iter().step_by(stride).collect()
        };
        Self {
            weights,
            ranges,
            reference_point,
            low: on(ElectrodeFace::LowWall),
            high: on(ElectrodeFace::HighWall),
            walls,
            blades: channel.blade_span(),
        }
    }

    /// The objective at `pose`, reached by `motion` after the step `before`, with walls drawn in by `h` (rad).
    pub fn value(&self, pose: &Pose, h: f64, motion: &StepMotion, before: &StepMotion) -> ObjectiveValue {
        let smoothness = self.smoothness(motion, before);
        let centring = self.centring(pose, h);
        ObjectiveValue { smoothness, centring, total: self.weights.a3 * smoothness + self.weights.b3 * centring }
    }

    /// Whether any wall sample is still between the blades at `pose`.
    pub fn is_between_blades(&self, pose: &Pose) -> bool {
        let place = pose.placement(self.reference_point);
        let between = |p: &DVec3| self.blades.contains(place.transform_point3(*p));
        self.low.iter().chain(&self.high).any(between)
    }

    /// (4): for each axis the change of its rate between two steps over the time between them, as a share of
    /// the axis's range. With unequal steps, rates are increments per nominal step.
    fn smoothness(&self, motion: &StepMotion, before: &StepMotion) -> f64 {
        Axis::ALL
            .into_iter()
            .filter(|&axis| self.ranges[axis as usize] > 0.0)
            .map(|axis| {
                let i = axis as usize;
                let change = motion.increments[i] / motion.duration - before.increments[i] / before.duration;
                self.weights.smoothness(axis) * (change / (motion.duration * self.ranges[i])).abs()
            })
            .sum()
    }

    /// (5), over those samples that are between the blades; 0 when none is. Distances in mm.
    fn centring(&self, pose: &Pose, h: f64) -> f64 {
        let place = pose.placement(self.reference_point);
        let spread = |points: &[DVec3], wall: usize, angle: f64| {
            let turn = glam::DMat3::from_rotation_x(angle);
            let (mut n, mut sum, mut squares, mut least) = (0.0, 0.0, 0.0, f64::INFINITY);
            for &p in points {
                let q = place.transform_point3(turn * p);
                if !self.blades.contains(q) {
                    continue;
                }
                let d = self.walls.at(q)[wall];
                n += 1.0;
                sum += d;
                squares += d * d;
                least = least.min(d);
            }
            let deviation = if n > 0.0 { (squares / n - (sum / n).powi(2)).max(0.0).sqrt() } else { 0.0 };
            (least, deviation)
        };
        let (low, high) = (spread(&self.low, 0, h), spread(&self.high, 1, -h));
        let difference = if low.0.is_finite() && high.0.is_finite() { low.0 - high.0 } else { 0.0 };
        self.weights.a2 * difference * difference + self.weights.b2 * low.1 + self.weights.c2 * high.1
    }
}

/// Distances to the two walls on a regular grid, interpolated; good to about 0.02 mm, which centring does not feel.
pub struct WallDistances {
    min: DVec3,
    cell: f64,
    nodes: [usize; 3],
    values: Vec<[f32; 2]>,
}

impl WallDistances {
    const CELL: f64 = 0.6;

    /// The distances over `region`.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn new(finder: &SurfaceFinder, region: Bounds, cancel: &Cancel) -> Result<Self, Cancelled> {
        use rayon::prelude::*;
        let nodes = (region.size() / Self::CELL).ceil().to_array().map(|n| (n as usize).clamp(1, 400) + 1);
        let cell = (0..3).map(|i| region.size()[i] / (nodes[i] - 1) as f64).fold(Self::CELL, f64::max);
        let values = (0..nodes[0] * nodes[1] * nodes[2])
            .into_par_iter()
            .map(|i| {
                cancel.check()?;
                let at = [i % nodes[0], i / nodes[0] % nodes[1], i / nodes[0] / nodes[1]].map(|k| k as f64);
                Ok(finder.wall_distances(region.min + DVec3::from_array(at) * cell).map(|d| d as f32))
            })
            .collect::<Result<_, Cancelled>>()?;
        Ok(Self { min: region.min, cell, nodes, values })
    }

    /// Distances to the low and the high wall; beyond the grid, those at its border.
    fn at(&self, p: DVec3) -> [f64; 2] {
        let limit = DVec3::from_array(self.nodes.map(|n| (n - 1) as f64 - 1e-6));
        let q = ((p - self.min) / self.cell).clamp(DVec3::ZERO, limit);
        let (base, t) = (q.floor(), q.fract());
        let mut sum = [0.0; 2];
        for corner in 0..8usize {
            let far = [corner & 1, corner >> 1 & 1, corner >> 2 & 1];
            let i = [0, 1, 2].map(|k| base[k] as usize + far[k]);
            let weight: f64 = (0..3).map(|k| if far[k] == 1 { t[k] } else { 1.0 - t[k] }).product();
            let v = self.values[(i[2] * self.nodes[1] + i[1]) * self.nodes[0] + i[0]];
            sum = [sum[0] + weight * f64::from(v[0]), sum[1] + weight * f64::from(v[1])];
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_of_weights_sum_to_one_over_the_axes_in_use() {
        let w = Weights { a1: 2.0, b1: 1.0, c1: 1.0, d1: 5.0, ..Default::default() };
        let w = w.normalised(&[Axis::X, Axis::Y, Axis::Z, Axis::C]);
        assert_eq!((w.a1, w.b1, w.c1, w.d1, w.e1), (0.5, 0.25, 0.25, 0.0, 0.0));
        assert!((w.a2 + w.b2 + w.c2 - 1.0).abs() < 1e-15 && (w.a3 + w.b3 - 1.0).abs() < 1e-15);
    }

    #[test]
    fn useless_weights_are_refused() {
        assert!(Weights::default().validate().is_ok());
        assert!(Weights { a3: 0.0, b3: 0.0, ..Default::default() }.validate().is_err());
        assert!(Weights { a2: -0.1, ..Default::default() }.validate().is_err());
        assert!(Weights { c1: f64::NAN, ..Default::default() }.validate().is_err());
    }
}
