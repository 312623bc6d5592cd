//! The distance constraint of the search, looked up in two distance fields: that of the finished blisk for samples
//! of the electrode, and that of the electrode for the edges of the blisk, which would otherwise slip in between
//! the samples of a face.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};

use super::clearance_cache::ClearanceCache;
use super::outside::Outside;
use super::pose::Pose;
use super::probes::{Demand, Instant, Probes, SideDemand, Turns, group};
use super::samples::{Sample, thinned};
use geometry::distance_field::DistanceField;
use geometry::mesh::Bounds;
use task::{Cancel, Cancelled};
use wheel::electrode::{ElectrodeFace, EntrySide};

/// The two bodies' probes over each other's distance fields.
#[derive(Clone)]
pub struct ClearanceModel<'a> {
    bodies: Bodies<'a>,
    electrode: Probes,
    blisk: Probes,
    /// Greatest distance of an electrode sample from the blisk's axis, and from the reference point (mm).
    levers: [f64; 2],
    /// The box around the electrode's samples and its distance field, in its final pose (mm).
    around: Bounds,
}

/// The distance fields and measures that a clearance model is made of.
#[derive(Clone)]
pub struct Bodies<'a> {
    /// Distance field of the finished blisk, in W.
    pub blisk: &'a DistanceField,
    /// Distance field of the electrode in its final pose, in W.
    pub electrode: &'a DistanceField,
    /// X extent of the blisk at the channel's radii (mm): beyond it, outside the field, there is nothing to meet.
    pub faces_x: [f64; 2],
    /// Radii within and beyond which there is nothing to meet, where the electrode is withdrawn along the radius (mm): those
    /// of the bore and of the rim.
    pub free_radii: Option<[f64; 2]>,
    /// Extent of the blisk beyond which the electrode is outside.
    pub outside: Arc<Outside>,
    /// Electrode reference point O in W (mm).
    pub reference_point: DVec3,
    /// The side that the electrode is withdrawn to.
    pub side: EntrySide,
    /// Electrode that the samples lie on.
    pub samples: SamplesOf,
    /// Clearances wanted of single sides of the electrode beyond those of all points.
    pub sides: SideDemand,
}

/// Electrode that samples lie on, where walls are drawn in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SamplesOf {
    /// The electrode whose distance field is used: samples on its walls are turned with them.
    Prepared,
    /// The electrode made with its walls drawn in.
    DrawnIn,
}

/// A pose made ready for testing, with the walls turned away from their blades.
#[derive(Clone)]
pub(super) struct Placed {
    /// The electrode as it is and with each of its walls turned.
    parts: [DAffine3; 3],
    /// Transforms of the electrode's points into W, by their [`group`].
    to_blisk: [DAffine3; 3],
    /// Transforms of the blisk's points into the frame of the electrode and, where they are turned, of each of its
    /// walls.
    to_electrode: [DAffine3; 3],
    turns: Turns,
}

impl Placed {
    fn new(pose: &Pose, turns: Turns, reference_point: DVec3, samples: SamplesOf) -> Self {
        let place = pose.placement(reference_point);
        let turned = |angle| place * DAffine3::from_mat3(DMat3::from_rotation_x(angle));
        let Turns([low, high]) = turns;
        let parts = [place, turned(low), turned(-high)];
        let to_blisk = if samples == SamplesOf::Prepared { parts } else { [place; 3] };
        Self { parts, to_blisk, to_electrode: parts.map(|t| t.inverse()), turns }
    }

    /// Greatest distance between the points of a body within `bounds` here and at `other` (mm): reached at a corner.
    fn motion_from(&self, other: &Self, bounds: Bounds) -> f64 {
        let ends = [bounds.min, bounds.max];
        let parts = if self.turns.is_none() { &self.parts[..1] } else { &self.parts };
        let moved = |(to, from): (&DAffine3, &DAffine3), i: usize| {
            let corner = DVec3::new(ends[i & 1].x, ends[i >> 1 & 1].y, ends[i >> 2].z);
            to.transform_point3(corner).distance_squared(from.transform_point3(corner))
        };
        let pairs = parts.iter().zip(&other.parts);
        let squares = pairs.flat_map(|pair| (0..8).map(move |i| moved(pair, i)));
        squares.fold(0.0, f64::max).sqrt()
    }
}

/// Motion-bound clearance caches of both bodies for tests at poses near to each other, all with the same demand but for
/// its room and with the walls equally turned.
pub(super) struct NearbyPoses {
    electrode: ClearanceCache,
    blisk: ClearanceCache,
    /// Last pose tested, with its withdrawn distance (mm).
    last: Option<(Placed, f64)>,
}

impl NearbyPoses {
    fn new(model: &ClearanceModel) -> Self {
        Self { electrode: model.electrode.clearance_cache(), blisk: model.blisk.clearance_cache(), last: None }
    }

    fn advance(&mut self, model: &ClearanceModel, placed: &Placed, s: f64) {
        if let Some((last, last_s)) = &self.last {
            let motion = placed.motion_from(last, model.around);
            // Whatever more is demanded counts as if the electrode had come nearer by as much.
            self.electrode.advance(motion + model.electrode.rise(s - last_s));
            self.blisk.advance(motion + model.blisk.rise(s - last_s));
        }
        self.last = Some((placed.clone(), s));
    }
}

/// The number of a probe and the clearance it lacks (mm).
#[derive(Debug, Clone, Copy)]
pub(super) struct Lacking {
    pub(super) probe: usize,
    pub(super) lack: f64,
}

/// A probe that lacks clearance.
#[derive(Debug, Clone, Copy)]
pub struct Shortfall {
    /// Number of the probe.
    pub probe: usize,
    /// Clearance it lacks (mm).
    pub lack: f64,
    /// Point of the electrode's surface at this pose, in W (mm).
    pub at: DVec3,
    /// The direction in which the electrode would have to move there.
    pub away: DVec3,
    /// The point of the electrode in its final pose, in W (mm).
    pub on_electrode: DVec3,
    /// The point of the blisk, in W (mm).
    pub on_blisk: DVec3,
}

impl Bodies<'_> {
    /// Reach of the electrode's field beyond the clearance wanted (mm): whatever is further away is free.
    pub const AROUND: f64 = 1.0;

    /// Clearance at a point of W from the blisk (mm), negative inside it. Outside the field it is a lower bound:
    /// the distance from the blisk's faces, or -1 beside the field, where nothing is known.
    #[inline]
    pub fn clearance_at(&self, p: DVec3) -> f64 {
        self.clearance_or_enough(p, f64::INFINITY)
    }

    /// Clearance at `p` (mm), or any value of at least `enough` (mm) where the clearance is greater than that.
    #[inline]
    fn clearance_or_enough(&self, p: DVec3, enough: f64) -> f64 {
        self.blisk.value_or_enough(p, enough).unwrap_or_else(|| self.clearance_outside(p))
    }

    fn clearance_outside(&self, p: DVec3) -> f64 {
        let beyond = (self.faces_x[0] - p.x).max(p.x - self.faces_x[1]).max(self.beyond_radii(p));
        if beyond > 0.0 { beyond } else { -1.0 }
    }

    /// How far `p` is beyond the blisk's rim or within its bore, where that leads outside.
    fn beyond_radii(&self, p: DVec3) -> f64 {
        let r = p.y.hypot(p.z);
        self.free_radii.map_or(f64::NEG_INFINITY, |[bore, rim]| (r - rim).max(bore - r))
    }

    fn clearance_and_direction(&self, p: DVec3) -> (f64, DVec3) {
        self.blisk.value_and_gradient(p).unwrap_or_else(|| {
            let middle = 0.5 * (self.faces_x[0] + self.faces_x[1]);
            let beside = (self.faces_x[0] - p.x).max(p.x - self.faces_x[1]);
            let out = if self.beyond_radii(p) > beside {
                let [bore, rim] = self.free_radii.unwrap_or_default();
                let r = p.y.hypot(p.z);
                p.with_x(0.0).normalize_or(DVec3::Z) * if r - rim > bore - r { 1.0 } else { -1.0 }
            } else {
                DVec3::X * (p.x - middle).signum()
            };
            (self.clearance_outside(p), out)
        })
    }

    /// Clearance of a point of the blisk from the electrode in its final pose.
    #[inline]
    fn distance_to_electrode(&self, p: DVec3, enough: f64) -> f64 {
        self.electrode.value_or_enough(p, enough).unwrap_or(f64::INFINITY)
    }

    #[inline]
    fn electrode_clearance(&self, placed: &Placed, p: DVec3, group: usize, enough: f64) -> f64 {
        self.clearance_or_enough(placed.to_blisk[group].transform_point3(p), enough)
    }

    /// Clearance of the point `p` of the blisk. An electrode with its walls drawn in is the intersection of three
    /// bodies, and so no nearer than any of them.
    #[inline]
    fn blisk_clearance(&self, placed: &Placed, p: DVec3, enough: f64) -> f64 {
        let seen = |i: usize| self.distance_to_electrode(placed.to_electrode[i].transform_point3(p), enough);
        let mut clearance = seen(0);
        for i in 1..3 {
            if placed.turns.is_none() || clearance >= enough {
                break;
            }
            clearance = clearance.max(seen(i));
        }
        clearance
    }
}

impl<'a> ClearanceModel<'a> {
    /// A model with `electrode_samples` on the electrode and `blisk_points` on the blisk.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn new(
        bodies: Bodies<'a>,
        electrode_samples: Vec<Sample>,
        blisk_points: Vec<Sample>,
        cancel: &Cancel,
    ) -> Result<Self, Cancelled> {
        let greatest =
            |length: &dyn Fn(DVec3) -> f64| electrode_samples.iter().map(|s| length(s.point)).fold(0.0, f64::max);
        let field = bodies.electrode.bounds();
        let around = Bounds::of(electrode_samples.iter().map(|s| s.point).chain([field.min, field.max]));
        let to_blisk = |p: DVec3| bodies.clearance_at(p);
        let to_electrode = |p: DVec3| bodies.distance_to_electrode(p, f64::INFINITY);
        Ok(Self {
            around,
            levers: [greatest(&|p| p.y.hypot(p.z)), greatest(&|p| p.distance(bodies.reference_point))],
            electrode: Probes::new(electrode_samples, bodies.sides, to_blisk, cancel)?,
            blisk: Probes::new(blisk_points, SideDemand::default(), to_electrode, cancel)?,
            bodies,
        })
    }

    /// The electrode's samples.
    pub fn samples(&self) -> &[Sample] {
        self.electrode.samples()
    }

    /// Points tested on both bodies.
    pub fn probes(&self) -> usize {
        self.electrode.samples().len() + self.blisk.samples().len()
    }

    /// The region in which the electrode is out of the blisk.
    pub fn outside(&self) -> &Outside {
        &self.bodies.outside
    }

    /// Electrode reference point O in W (mm).
    pub fn reference_point(&self) -> DVec3 {
        self.bodies.reference_point
    }

    /// The side that the electrode is withdrawn to.
    pub fn side(&self) -> EntrySide {
        self.bodies.side
    }

    /// Upper estimate of the motion of the electrode's points from one pose to another (mm).
    pub fn motion_between(&self, from: &Pose, to: &Pose) -> f64 {
        let (p, q) = (from.to_array(), to.to_array());
        let [x, y, z, a, b, c] = std::array::from_fn(|i| (q[i] - p[i]).abs());
        DVec3::new(x, y, z).length() + self.levers[0] * a + self.levers[1] * (b + c)
    }

    /// Point of the prepared electrode, and its face, for a point of the electrode with its walls drawn in by `turns`.
    pub fn before_turning(&self, p: DVec3, turns: Turns) -> (DVec3, ElectrodeFace) {
        let placed = self.placed(&Pose::FINAL, turns);
        let distance = |s: &Sample| placed.to_blisk[group(s.face)].transform_point3(s.point).distance_squared(p);
        let held = self.electrode.held(turns).map(|(_, s)| (distance(s), s.face));
        let nearest = held.min_by(|a, b| a.0.total_cmp(&b.0));
        let face = nearest.map_or(ElectrodeFace::Holder, |(_, face)| face);
        (placed.to_blisk[group(face)].inverse().transform_point3(p), face)
    }

    /// Model with probes no nearer to each other than `spacing` (mm), and with all probes that have an extra demand.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn thinned(&self, spacing: f64, cancel: &Cancel) -> Result<Self, Cancelled> {
        let [electrode, blisk] = [&self.electrode, &self.blisk].map(|probes| thinned(probes.samples(), spacing));
        Self::new(self.bodies.clone(), electrode, blisk, cancel)
    }

    /// Model with further probes; a probe that exists already takes the greater demand.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn with_probes(
        &self,
        electrode_samples: &[Sample],
        blisk_points: &[Sample],
        cancel: &Cancel,
    ) -> Result<Self, Cancelled> {
        let [electrode, blisk] = [self.electrode.joined(electrode_samples), self.blisk.joined(blisk_points)];
        Self::new(self.bodies.clone(), electrode, blisk, cancel)
    }

    /// Whether every probe has the clearance demanded of it at `pose`, withdrawn by `s`, with the walls drawn in by
    /// `turns`. Cluster `hint` is tested first; the cluster that failed is left there.
    pub fn is_free(&self, pose: &Pose, s: f64, turns: Turns, demand: &Demand, hint: &mut usize) -> bool {
        let placed = Placed::new(pose, turns, self.bodies.reference_point, self.bodies.samples);
        let at = Instant { s, turns };
        let clusters = self.electrode.clusters() + self.blisk.clusters();
        if *hint < clusters && !self.cluster_is_free(*hint, &placed, &at, demand) {
            return false;
        }
        let of_electrode = |p: DVec3, group, enough: f64| self.bodies.electrode_clearance(&placed, p, group, enough);
        let of_blisk = |p: DVec3, _, enough: f64| self.bodies.blisk_clearance(&placed, p, enough);
        let blocked = self.electrode.first_blocked(&at, demand, &of_electrode).or_else(|| {
            let blocked = self.blisk.first_blocked(&at, demand, &of_blisk)?;
            Some(self.electrode.clusters() + blocked)
        });
        *hint = blocked.unwrap_or(*hint);
        blocked.is_none()
    }

    /// Clusters are counted through: the electrode's first, then the blisk's.
    #[inline]
    fn cluster_is_free(&self, i: usize, placed: &Placed, at: &Instant, demand: &Demand) -> bool {
        match i.checked_sub(self.electrode.clusters()) {
            None => {
                let clearance =
                    |p: DVec3, group, enough: f64| self.bodies.electrode_clearance(placed, p, group, enough);
                self.electrode.cluster_is_free(i, at, demand, &clearance)
            }
            Some(j) => {
                let clearance = |p: DVec3, _, enough: f64| self.bodies.blisk_clearance(placed, p, enough);
                self.blisk.cluster_is_free(j, at, demand, &clearance)
            }
        }
    }

    /// New caches for tests at poses near to each other.
    pub(super) fn nearby(&self) -> NearbyPoses {
        NearbyPoses::new(self)
    }

    /// The probes that lack clearance, in order; of each cluster only the one that lacks most, if `one_each`.
    pub(super) fn lacking(
        &self,
        nearby: &mut NearbyPoses,
        placed: &Placed,
        at: &Instant,
        demand: &Demand,
        one_each: bool,
    ) -> Vec<Lacking> {
        let mut found = Vec::new();
        self.look(nearby, (placed, at, demand), one_each, |lacking| {
            found.push(lacking);
            true
        });
        found
    }

    /// Whether every probe has the clearance demanded of it at `pose`, withdrawn by `s`, with the walls drawn in by
    /// `turns`; `nearby` holds the caches of earlier tests at poses near this one.
    pub(super) fn stays_free(
        &self,
        nearby: &mut NearbyPoses,
        pose: &Pose,
        (s, turns): (f64, Turns),
        demand: &Demand,
    ) -> bool {
        let mut free = true;
        self.look(nearby, (&self.placed(pose, turns), &Instant { s, turns }, demand), false, |_| {
            free = false;
            free
        });
        free
    }

    /// Calls `found` with the probes that lack clearance until it returns false.
    fn look(
        &self,
        nearby: &mut NearbyPoses,
        (placed, at, demand): (&Placed, &Instant, &Demand),
        one_each: bool,
        mut found: impl FnMut(Lacking) -> bool,
    ) {
        nearby.advance(self, placed, at.s);
        let mut going = true;
        let clearance = |p: DVec3, group, enough: f64| self.bodies.electrode_clearance(placed, p, group, enough);
        self.electrode.lacking(at, demand, &clearance, &mut nearby.electrode, one_each, |probe, lack| {
            going = found(Lacking { probe, lack });
            going
        });
        if !going {
            return;
        }
        let first = self.samples().len();
        let clearance = |p: DVec3, _, enough: f64| self.bodies.blisk_clearance(placed, p, enough);
        self.blisk.lacking(at, demand, &clearance, &mut nearby.blisk, one_each, |k, lack| {
            found(Lacking { probe: first + k, lack })
        });
    }

    /// Contact of a probe that lacks clearance.
    pub(super) fn shortfall(&self, lacking: Lacking, placed: &Placed) -> Shortfall {
        match lacking.probe.checked_sub(self.samples().len()) {
            None => self.electrode_shortfall(lacking.probe, lacking.lack, placed),
            Some(k) => self.blisk_shortfall(k, lacking.lack, placed),
        }
    }

    /// A pose made ready for testing.
    pub(super) fn placed(&self, pose: &Pose, turns: Turns) -> Placed {
        Placed::new(pose, turns, self.bodies.reference_point, self.bodies.samples)
    }

    fn electrode_shortfall(&self, k: usize, lack: f64, placed: &Placed) -> Shortfall {
        let sample = &self.electrode.samples()[k];
        let at = placed.to_blisk[group(sample.face)].transform_point3(sample.point);
        let (clearance, away) = self.bodies.clearance_and_direction(at);
        let on_blisk = at - away * clearance;
        Shortfall { probe: k, lack, at, away, on_electrode: sample.point, on_blisk }
    }

    fn blisk_shortfall(&self, k: usize, lack: f64, placed: &Placed) -> Shortfall {
        let on_blisk = self.blisk.samples()[k].point;
        // Of the electrode as it is and with each wall turned, the one that is furthest away bounds what is left.
        let seen = |i: usize| placed.to_electrode[i].transform_point3(on_blisk);
        let all = if placed.turns.is_none() { 0..1 } else { 0..3 };
        let distance = |i: &usize| self.bodies.distance_to_electrode(seen(*i), f64::INFINITY);
        let group = all.max_by(|i, j| distance(i).total_cmp(&distance(j)).then(j.cmp(i))).unwrap_or(0);
        let nearest = self.bodies.electrode.value_and_gradient(seen(group));
        let (clearance, outward) = nearest.unwrap_or((Bodies::AROUND, DVec3::X));
        let on_electrode = seen(group) - outward * clearance;
        let back = placed.to_electrode[group].inverse();
        let at = back.transform_point3(on_electrode);
        let away = -back.transform_vector3(outward);
        let on_electrode = match self.bodies.samples {
            SamplesOf::Prepared => on_electrode,
            SamplesOf::DrawnIn => placed.to_electrode[0].transform_point3(at),
        };
        Shortfall { probe: self.electrode.samples().len() + k, lack, at, away, on_electrode, on_blisk }
    }

    /// The samples where they are at `pose`, with the walls drawn in by `turns`.
    pub fn placed_samples(&self, pose: &Pose, turns: Turns) -> impl Iterator<Item = DVec3> {
        let placed = Placed::new(pose, turns, self.bodies.reference_point, self.bodies.samples);
        self.samples().iter().map(move |s| placed.to_blisk[group(s.face)].transform_point3(s.point))
    }

    /// The least clearance of any probe at `pose` with the walls drawn in by `turns` (mm).
    pub fn least_clearance(&self, pose: &Pose, turns: Turns) -> f64 {
        let placed = self.placed(pose, turns);
        let electrode = |s: &Sample| self.bodies.electrode_clearance(&placed, s.point, group(s.face), f64::INFINITY);
        let electrode = self.electrode.held(turns).map(|(_, s)| electrode(s));
        let blisk = self.blisk.held(turns).map(|(_, s)| self.bodies.blisk_clearance(&placed, s.point, f64::INFINITY));
        electrode.chain(blisk).fold(f64::INFINITY, f64::min)
    }

    /// The probe with the least clearance at `pose`, as if it lacked what is missing of `wanted` mm.
    pub fn tightest(&self, pose: &Pose, turns: Turns, wanted: f64) -> Option<Shortfall> {
        let placed = self.placed(pose, turns);
        let electrode = self.electrode.held(turns).map(|(k, _)| self.electrode_shortfall(k, 0.0, &placed));
        let blisk = self.blisk.held(turns).map(|(k, _)| self.blisk_shortfall(k, 0.0, &placed));
        let clearance = |f: &Shortfall| (f.at - f.on_blisk).dot(f.away);
        let tightest = electrode.chain(blisk).min_by(|a, b| clearance(a).total_cmp(&clearance(b)))?;
        Some(Shortfall { lack: (wanted - clearance(&tightest)).max(0.0), ..tightest })
    }
}
