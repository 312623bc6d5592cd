//! The objective of P0: smooth motion of every axis (4), and an electrode that keeps to the middle (5).

use files::Invalid;
use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::pose::{Axis, Pose};
use super::samples::{Sample, SampleSpacing, sample_electrode};
use geometry::mesh::Bounds;
use task::{Cancel, Cancelled};
use wheel::channel::{BladeSpan, Channel};
use wheel::electrode::{Electrode, ElectrodeFace};
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
    samples: WallSamples,
    walls: &'a WallDistances,
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

/// Distances of the walls of an electrode from those of the channel in one pose, as (5) takes them: of the low (P0: left)
/// wall first, of those samples that are between the blades.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct WallSpread {
    /// D_L and D_R: least distances (mm); none where no sample is between the blades.
    pub least: [Option<f64>; 2],
    /// S_L and S_R: standard deviations of the distances (mm).
    pub deviation: [f64; 2],
}

/// Samples of the two walls of an electrode, each tested against the wall of the channel beside it.
#[derive(Debug, Clone)]
pub struct WallSamples {
    reference_point: DVec3,
    walls: [Vec<DVec3>; 2],
    blades: BladeSpan,
}

impl WallSamples {
    /// Most samples of each wall that are used, spread evenly.
    const MOST: usize = 120;

    /// The samples of an electrode with reference point O (in W) that are on its walls.
    fn new(samples: &[Sample], reference_point: DVec3, channel: &Channel) -> Self {
        let on = |face: ElectrodeFace| {
            let all: Vec<DVec3> = samples.iter().filter(|s| s.face == face).map(|s| s.point).collect();
            let stride = all.len().div_ceil(Self::MOST).max(1);
            all.into_iter().step_by(stride).collect()
        };
        let walls = [ElectrodeFace::LowWall, ElectrodeFace::HighWall].map(on);
        Self { reference_point, walls, blades: channel.blade_span() }
    }

    /// The samples that the objective uses of `electrode`.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn of(electrode: &Electrode, channel: &Channel, cancel: &Cancel) -> Result<Self, Cancelled> {
        let samples = sample_electrode(&electrode.mesh, &electrode.faces, SampleSpacing::default(), cancel)?;
        Ok(Self::new(&samples, electrode.reference_point, channel))
    }

    /// The samples of each wall that are between the blades at `pose`, with the walls drawn in by `h` (rad), in W.
    pub fn placed(&self, pose: &Pose, h: f64) -> [Vec<DVec3>; 2] {
        let place = pose.placement(self.reference_point);
        [(0, h), (1, -h)].map(|(wall, angle)| {
            let turn = glam::DMat3::from_rotation_x(angle);
            let placed = self.walls[wall].iter().map(|p| place.transform_point3(turn * *p));
            placed.filter(|p| self.blades.contains(*p)).collect()
        })
    }

    /// Distances (mm) of the [`placed`](Self::placed) samples from the wall beside them; `to_walls` answers the distances
    /// of a place from the low and the high wall of the channel.
    pub fn distances(&self, pose: &Pose, h: f64, to_walls: &dyn Fn(DVec3) -> [f64; 2]) -> [Vec<f64>; 2] {
        let [low, high] = self.placed(pose, h);
        [(0, low), (1, high)].map(|(wall, places)| places.into_iter().map(|p| to_walls(p)[wall]).collect())
    }

    /// D_L, D_R, S_L and S_R of (5); the arguments are those of [`distances`](Self::distances).
    pub fn spread(&self, pose: &Pose, h: f64, to_walls: &dyn Fn(DVec3) -> [f64; 2]) -> WallSpread {
        WallSpread::of(&self.distances(pose, h, to_walls))
    }
}

impl WallSpread {
    /// The figures of the distances from both walls (mm).
    pub fn of(distances: &[Vec<f64>; 2]) -> Self {
        let least = |all: &Vec<f64>| all.iter().copied().min_by(f64::total_cmp);
        let deviation = |all: &Vec<f64>| {
            let n = all.len().max(1) as f64;
            let [sum, squares] = all.iter().fold([0.0; 2], |[sum, squares], d| [sum + d, squares + d * d]);
            (squares / n - (sum / n).powi(2)).max(0.0).sqrt()
        };
        Self { least: distances.each_ref().map(least), deviation: distances.each_ref().map(deviation) }
    }

    /// Obj2 of (5) with these `weights`; without a sample beside one of the walls there is no difference.
    pub fn centring(&self, weights: &Weights) -> f64 {
        let difference = if let [Some(low), Some(high)] = self.least { low - high } else { 0.0 };
        let [low, high] = self.deviation;
        weights.a2 * difference * difference + weights.b2 * low + weights.c2 * high
    }
}

impl<'a> Objective<'a> {
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
        Self { weights, ranges, samples: WallSamples::new(samples, reference_point, channel), walls }
    }

    /// The objective at `pose`, reached by `motion` after the step `before`, with walls drawn in by `h` (rad).
    pub fn value(&self, pose: &Pose, h: f64, motion: &StepMotion, before: &StepMotion) -> ObjectiveValue {
        let smoothness = self.smoothness(motion, before);
        let centring = self.centring(pose, h);
        ObjectiveValue { smoothness, centring, total: self.weights.a3 * smoothness + self.weights.b3 * centring }
    }

    /// Whether any wall sample is still between the blades at `pose`.
    pub fn is_between_blades(&self, pose: &Pose) -> bool {
        let place = pose.placement(self.samples.reference_point);
        let between = |p: &DVec3| self.samples.blades.contains(place.transform_point3(*p));
        self.samples.walls.iter().flatten().any(between)
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
        self.samples.spread(pose, h, &|p| self.walls.at(p)).centring(&self.weights)
    }
}

/// Distances to the two walls on a regular grid, interpolated. Within a cell of a wall they are too large, by up to half a
/// cell; further off they are good to 0.1 mm, and away from both walls to a twentieth of the distance.
pub struct WallDistances {
    min: DVec3,
    cell: f64,
    nodes: [usize; 3],
    values: Vec<[f32; 2]>,
}

impl WallDistances {
    /// Sizes of the cells near the walls and away from them (mm).
    const CELL: f64 = 0.6;
    const COARSE: f64 = 2.4;
    /// Distance from both walls that counts as away (mm).
    const AWAY: f64 = 12.0;

    /// The distances over `region`.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn new(finder: &SurfaceFinder, region: Bounds, cancel: &Cancel) -> Result<Self, Cancelled> {
        let coarse = Self::sampled(region, Self::COARSE, &|p| finder.wall_distances(p), cancel)?;
        let distances = |p: DVec3| {
            let about = coarse.at(p);
            if about[0].min(about[1]) > Self::AWAY { about } else { finder.wall_distances(p) }
        };
        Self::sampled(region, Self::CELL, &distances, cancel)
    }

    /// `distances` at the nodes of a grid over `region` with cells of about `cell` mm.
    fn sampled(
        region: Bounds,
        cell: f64,
        distances: &(dyn Fn(DVec3) -> [f64; 2] + Sync),
        cancel: &Cancel,
    ) -> Result<Self, Cancelled> {
        use rayon::prelude::*;
        let nodes = (region.size() / cell).ceil().to_array().map(|n| (n as usize).clamp(1, 400) + 1);
        let cell = (0..3).map(|i| region.size()[i] / (nodes[i] - 1) as f64).fold(cell, f64::max);
        let values = (0..nodes[0] * nodes[1] * nodes[2])
            .into_par_iter()
            .map(|i| {
                cancel.check()?;
                let at = [i % nodes[0], i / nodes[0] % nodes[1], i / nodes[0] / nodes[1]].map(|k| k as f64);
                Ok(distances(region.min + DVec3::from_array(at) * cell).map(|d| d as f32))
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
    fn a_distribution_has_its_least_value_and_its_deviation() {
        let spread = WallSpread::of(&[vec![1.0, 3.0], Vec::new()]);
        assert_eq!((spread.least, spread.deviation), ([Some(1.0), None], [1.0, 0.0]));
        let weights = Weights { a2: 0.5, b2: 0.25, c2: 0.25, ..Weights::default() };
        assert_eq!(spread.centring(&weights), 0.25, "no difference of least distances beside one wall alone");
        let both = WallSpread::of(&[vec![1.0, 3.0], vec![4.0, 4.0]]);
        assert_eq!(both.centring(&weights), 0.5 * 9.0 + 0.25);
    }

    /// P0's figure 4: a net-shape electrode in its final pose is equally far from both walls all over, and one moved
    /// across the channel by d is nearer to one wall and farther from the other, by d along their normals.
    #[test]
    fn a_net_shape_electrode_stands_evenly_between_the_walls_in_its_final_pose() {
        use geometry::exact::ExactMesh;
        use task::Task;
        use wheel::electrode::{ElectrodeParams, EntrySide, make_electrodes};
        use wheel::fixtures::exact_channel;
        use wheel::parametric::{MeshResolution, ParametricBlisk};

        let blisk = ParametricBlisk::turbine();
        let channel = exact_channel(&blisk);
        let mesh = blisk.mesh(&MeshResolution::default()).unwrap().in_frame(&channel.frame);
        let params = ElectrodeParams { circumferential_reduction_deg: [0.0; 2], ..Default::default() };
        let (task, exact) = (Task::default(), ExactMesh::new(&mesh).unwrap());
        let made = make_electrodes(&channel, &exact, &params, EntrySide::PlusX, &task).unwrap();
        let finder = SurfaceFinder::new(channel.clone().into()).unwrap();
        let samples = WallSamples::of(&made[0], &channel, &task.cancel).unwrap();
        let spread = |pose: &Pose| samples.spread(pose, 0.0, &|p| finder.wall_distances(p));
        let [good, bad] = [Pose::FINAL, Pose { y: 0.05, ..Pose::FINAL }].map(|pose| spread(&pose));
        for wall in 0..2 {
            assert!((good.least[wall].unwrap() - params.spark_gap_mm).abs() < 0.02, "{good:?}");
            assert!(good.deviation[wall] < 0.02, "{good:?}");
        }
        // Beside one of two curved walls the distances may become evener: not beside both.
        let sum = |spread: &WallSpread| spread.deviation.iter().sum::<f64>();
        assert!(sum(&bad) > 1.2 * sum(&good), "{good:?} {bad:?}");
        let moved = |wall: usize| bad.least[wall].unwrap() - good.least[wall].unwrap();
        assert!(moved(0) * moved(1) < 0.0 && moved(0).abs() < 0.06 && moved(1).abs() < 0.06, "{good:?} {bad:?}");
    }

    #[test]
    fn distances_from_the_grid_are_those_to_the_walls_near_them_and_away() {
        use rand::{RngExt as _, SeedableRng as _};
        use wheel::fixtures::exact_channel;
        use wheel::parametric::ParametricBlisk;

        let channel = exact_channel(&ParametricBlisk::turbine());
        let both = channel.low.points.iter().chain(&channel.high.points);
        let region = Bounds::of(both.copied()).grown(20.0);
        let finder = SurfaceFinder::new(channel.into()).unwrap();
        let walls = WallDistances::new(&finder, region, &Cancel::default()).unwrap();
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        let mut away = 0;
        for _ in 0..20_000 {
            let p = region.min + region.size() * DVec3::new(random.random(), random.random(), random.random());
            let exact = finder.wall_distances(p);
            // In cells that a wall passes through its two sides are mixed.
            if exact[0].min(exact[1]) < 3f64.sqrt() * WallDistances::CELL {
                continue;
            }
            let is_away = exact[0].min(exact[1]) > WallDistances::AWAY;
            away += usize::from(is_away);
            let share = if is_away { 0.05 } else { 0.0 };
            let off = [0, 1].map(|wall| (walls.at(p)[wall] - exact[wall]).abs() / (0.1 + share * exact[wall]));
            assert!(off[0].max(off[1]) < 1.0, "{p}: {:?} for {exact:?}", walls.at(p));
        }
        assert!(away > 1000, "{away}");
    }

    #[test]
    fn useless_weights_are_refused() {
        assert!(Weights::default().validate().is_ok());
        assert!(Weights { a3: 0.0, b3: 0.0, ..Default::default() }.validate().is_err());
        assert!(Weights { a2: -0.1, ..Default::default() }.validate().is_err());
        assert!(Weights { c1: f64::NAN, ..Default::default() }.validate().is_err());
    }
}
