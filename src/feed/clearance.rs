//! The distance constraint of the search: clearance of the electrode's samples, looked up in a distance field.

use glam::{DAffine3, DMat3, DVec3};

use super::pose::{Axis, Pose};
use super::samples::{Cluster, Sample, cluster};
use crate::blisk::electrode::{ElectrodeFace, EntrySide};
use crate::geometry::distance_field::DistanceField;

/// How much clearance the search demands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Demand {
    /// The spark gap (mm).
    pub spark_gap: f64,
    /// Clearance wanted beyond it (mm).
    pub margin: f64,
    /// Allowance for the error of the field (mm).
    pub guard: f64,
}

/// The electrode's samples over the distance field of the finished blisk.
#[derive(Clone)]
pub struct ClearanceModel<'a> {
    field: &'a DistanceField,
    /// X extent of the blisk at the channel's radii (mm): beyond it, outside the field, there is nothing to meet.
    faces_x: [f64; 2],
    reference_point: DVec3,
    side: EntrySide,
    samples: Vec<Sample>,
    /// Clearance of each sample in the final pose (mm).
    at_final: Vec<f64>,
    clusters: Vec<Cluster>,
    /// Greatest `extra` in each cluster (mm).
    cluster_extra: Vec<f64>,
}

/// Which way a sample follows the additional circumferential reduction h of P0.
fn group(face: ElectrodeFace) -> usize {
    match face {
        ElectrodeFace::LowWall => 1,
        ElectrodeFace::HighWall => 2,
        _ => 0,
    }
}

/// A pose made ready for testing samples, with the walls turned away from their blades by h.
struct Placed([DAffine3; 3]);

impl Placed {
    fn new(pose: &Pose, h: f64, reference_point: DVec3) -> Self {
        let place = pose.placement(reference_point);
        let turned = |angle| place * DAffine3::from_mat3(DMat3::from_rotation_x(angle));
        Self([place, turned(h), turned(-h)])
    }

    fn point(&self, sample: &Sample) -> DVec3 {
        self.0[group(sample.face)].transform_point3(sample.point)
    }
}

/// A sample that lacks clearance.
#[derive(Debug, Clone, Copy)]
pub struct Shortfall {
    /// Number of the sample.
    pub sample: usize,
    /// Clearance it lacks (mm).
    pub lack: f64,
    /// Where the sample is at this pose, in W (mm).
    pub at: DVec3,
    /// Direction in which its clearance grows fastest.
    pub away: DVec3,
}

impl<'a> ClearanceModel<'a> {
    /// How much more than in the final pose a sample must have for every mm withdrawn, until it has what is
    /// demanded. In the final pose itself only the spark gap is open.
    const OPENING: f64 = 0.05;
    /// Samples in a cluster, a balance between tests saved and balls that are too wide to decide.
    const CLUSTER: usize = 12;

    /// A model of the electrode with these samples and reference point O (in W), withdrawn to `side`.
    pub fn new(
        field: &'a DistanceField,
        faces_x: [f64; 2],
        reference_point: DVec3,
        side: EntrySide,
        mut samples: Vec<Sample>,
    ) -> Self {
        let clusters = cluster(&mut samples, Self::CLUSTER, |face| group(face) as u8);
        let mut model = Self {
            field,
            faces_x,
            reference_point,
            side,
            at_final: Vec::new(),
            cluster_extra: vec![0.0; clusters.len()],
            samples,
            clusters,
        };
        model.at_final = model.samples.iter().map(|s| model.clearance_at(s.point)).collect();
        model
    }

    /// The samples, in the order of their numbers.
    pub fn samples(&self) -> &[Sample] {
        &self.samples
    }

    /// Electrode reference point O in W (mm).
    pub fn reference_point(&self) -> DVec3 {
        self.reference_point
    }

    /// The side that the electrode is withdrawn to.
    pub fn side(&self) -> EntrySide {
        self.side
    }

    /// The face of the sample nearest to the point `p` of the electrode.
    pub fn face_at(&self, p: DVec3) -> ElectrodeFace {
        let nearest =
            self.samples.iter().min_by(|a, b| a.point.distance_squared(p).total_cmp(&b.point.distance_squared(p)));
        nearest.map_or(ElectrodeFace::Holder, |s| s.face)
    }

    /// The same model with further samples, or more demanding ones where it had them already.
    pub fn with_samples(&self, more: &[Sample]) -> Self {
        let mut samples = self.samples.clone();
        for new in more {
            match samples.iter_mut().find(|s| s.point.distance(new.point) < 1e-3 && s.face == new.face) {
                Some(known) => known.extra += new.extra,
                None => samples.push(*new),
            }
        }
        let mut model = Self::new(self.field, self.faces_x, self.reference_point, self.side, samples);
        for (extra, c) in model.cluster_extra.iter_mut().zip(&model.clusters) {
            *extra = model.samples[c.start..c.end].iter().map(|s| s.extra).fold(0.0, f64::max);
        }
        model
    }

    /// Clearance at a point (mm), negative inside the blisk. Outside the field it is a lower bound: the distance
    /// from the blisk's faces, or -1 beside the field, where nothing is known.
    #[inline]
    pub fn clearance_at(&self, p: DVec3) -> f64 {
        self.field.value(p).unwrap_or_else(|| self.clearance_outside(p))
    }

    fn clearance_outside(&self, p: DVec3) -> f64 {
        let beyond = (self.faces_x[0] - p.x).max(p.x - self.faces_x[1]);
        if beyond > 0.0 { beyond } else { -1.0 }
    }

    /// Clearance demanded of sample `i` when withdrawn by `s`.
    #[inline]
    fn demanded(&self, i: usize, s: f64, demand: &Demand) -> f64 {
        let wanted = demand.spark_gap + demand.margin + demand.guard + self.samples[i].extra;
        wanted.min(self.at_final[i] + Self::OPENING * s)
    }

    /// Whether every sample has the clearance demanded of it at `pose`, withdrawn by `s`, with the walls drawn
    /// in by a further `h` (rad). Tests cluster `hint` first and leaves there the one that failed.
    pub fn is_free(&self, pose: &Pose, s: f64, h: f64, demand: &Demand, hint: &mut usize) -> bool {
        let placed = Placed::new(pose, h, self.reference_point);
        if *hint < self.clusters.len() && !self.cluster_is_free(*hint, &placed, s, demand) {
            return false;
        }
        for i in 0..self.clusters.len() {
            if !self.cluster_is_free(i, &placed, s, demand) {
                *hint = i;
                return false;
            }
        }
        true
    }

    #[inline]
    fn cluster_is_free(&self, i: usize, placed: &Placed, s: f64, demand: &Demand) -> bool {
        let c = &self.clusters[i];
        let center = placed.0[group(self.samples[c.start].face)].transform_point3(c.center);
        let enough = demand.spark_gap + demand.margin + demand.guard + self.cluster_extra[i] + c.radius;
        // Away from the surface the field may tell that much more than the truth.
        let doubt = DistanceField::ACCURACY + 0.05 * (enough - DistanceField::NEAR).max(0.0);
        self.clearance_at(center) >= enough + doubt
            || (c.start..c.end)
                .all(|k| self.clearance_at(placed.point(&self.samples[k])) >= self.demanded(k, s, demand))
    }

    /// The samples that lack clearance, in order.
    pub fn shortfalls(&self, pose: &Pose, s: f64, h: f64, demand: &Demand) -> Vec<Shortfall> {
        let placed = Placed::new(pose, h, self.reference_point);
        let mut found = Vec::new();
        for (i, c) in self.clusters.iter().enumerate() {
            if self.cluster_is_free(i, &placed, s, demand) {
                continue;
            }
            for k in c.start..c.end {
                let at = placed.point(&self.samples[k]);
                let (clearance, away) = self.clearance_and_direction(at);
                let lack = self.demanded(k, s, demand) - clearance;
                if lack > 0.0 {
                    found.push(Shortfall { sample: k, lack, at, away });
                }
            }
        }
        found
    }

    fn clearance_and_direction(&self, p: DVec3) -> (f64, DVec3) {
        self.field.value_and_gradient(p).unwrap_or_else(|| {
            let middle = 0.5 * (self.faces_x[0] + self.faces_x[1]);
            (self.clearance_outside(p), DVec3::X * (p.x - middle).signum())
        })
    }

    /// The samples where they are at `pose`, with the walls drawn in by `h` (rad).
    pub fn placed_samples(&self, pose: &Pose, h: f64) -> impl Iterator<Item = DVec3> {
        let placed = Placed::new(pose, h, self.reference_point);
        self.samples.iter().map(move |sample| placed.point(sample))
    }

    /// The least clearance of any sample at `pose` (mm) and the number of the sample.
    pub fn least_clearance(&self, pose: &Pose) -> (f64, usize) {
        let place = pose.placement(self.reference_point);
        let mut least = (f64::INFINITY, 0);
        for (k, sample) in self.samples.iter().enumerate() {
            let d = self.clearance_at(place.transform_point3(sample.point));
            if d < least.0 {
                least = (d, k);
            }
        }
        least
    }

    /// The direction in which clearance grows at `p`.
    pub fn direction_at(&self, p: DVec3) -> DVec3 {
        self.clearance_and_direction(p).1
    }

    /// Moves `pose` along `axes` towards freedom by following the distance field: in each round every sample that
    /// lacks clearance shifts the pose by the smallest motion that would mend it. Answers the best pose met
    /// and the sample that still lacks most there, none if the pose is free.
    pub fn climb(&self, start: Pose, s: f64, h: f64, demand: &Demand, axes: &[Axis]) -> (Pose, Option<Shortfall>) {
        const ROUNDS: usize = 16;
        let mut pose = start;
        let mut best: Option<(Pose, Shortfall)> = None;
        for _ in 0..ROUNDS {
            let mut lacking = self.shortfalls(&pose, s, h, demand);
            lacking.sort_by(|a, b| b.lack.total_cmp(&a.lack).then(a.sample.cmp(&b.sample)));
            let Some(&worst) = lacking.first() else { return (pose, None) };
            if best.is_none_or(|(_, known)| worst.lack < known.lack) {
                best = Some((pose, worst));
            }
            pose = self.shifted(&pose, &lacking, axes);
        }
        best.map_or((start, None), |(pose, worst)| (pose, Some(worst)))
    }

    /// One round of climbing: projects the pose onto the half-space in which each of the worst samples has room,
    /// one after the other (Kaczmarz), to first order.
    fn shifted(&self, pose: &Pose, lacking: &[Shortfall], axes: &[Axis]) -> Pose {
        const WORST: usize = 24;
        /// Beyond the demand, so that rounding does not undo the shift (mm).
        const BEYOND: f64 = 2e-4;
        let start = pose.to_array();
        let mut q = start;
        for short in lacking.iter().take(WORST) {
            let slopes = self.slopes(pose, short.at, short.away);
            let slope = |a: Axis| slopes[a as usize];
            let weight = |a: Axis| Self::mobility(a).powi(2);
            let gained: f64 = axes.iter().map(|&a| slope(a) * (q[a as usize] - start[a as usize])).sum();
            let lack = short.lack + BEYOND - gained;
            let norm: f64 = axes.iter().map(|&a| weight(a) * slope(a).powi(2)).sum();
            if lack > 0.0 && norm > 1e-9 {
                for &a in axes {
                    q[a as usize] += weight(a) * slope(a) * lack / norm;
                }
            }
        }
        Pose::from_array(q)
    }

    /// Size of a step along an axis that moves the electrode's points by about 1 mm.
    fn mobility(axis: Axis) -> f64 {
        match axis {
            Axis::X | Axis::Y | Axis::Z => 1.0,
            Axis::A => 1.0 / 100.0,
            Axis::B | Axis::C => 1.0 / 10.0,
        }
    }

    /// How fast the point now at `p` (in W) moves along `direction` with each axis at `pose`.
    fn slopes(&self, pose: &Pose, p: DVec3, direction: DVec3) -> [f64; 6] {
        let table = DMat3::from_rotation_x(pose.a);
        let slid = self.reference_point + DVec3::new(pose.x, pose.y, pose.z);
        let arm = table.transpose() * p - slid;
        let local = table.transpose() * direction;
        let tilt_axis = DMat3::from_rotation_z(pose.c) * DVec3::Y;
        [
            local.x,
            local.y,
            local.z,
            direction.dot(DVec3::X.cross(p)),
            local.dot(tilt_axis.cross(arm)),
            local.dot(DVec3::Z.cross(arm)),
        ]
    }
}
