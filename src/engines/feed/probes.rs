//! Points carried by one body and tested against the other: the electrode's samples against the blisk, and the
//! blisk's edges against the electrode.

use glam::DVec3;
use rayon::prelude::*;

use super::clearance_cache::{ClearanceCache, MotionBound};
use super::plan_params::Thresholds;
use super::samples::{Cluster, Sample, cluster};
use geometry::distance_field::DistanceField;
use geometry::mesh::Bounds;
use task::{Cancel, Cancelled};
use wheel::electrode::ElectrodeFace;

/// Clearance that the search demands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Demand {
    /// The spark gap (mm).
    pub spark_gap: f64,
    /// Clearance wanted beyond it (mm).
    pub margin: f64,
    /// Allowance for the error of the fields (mm).
    pub guard: f64,
    /// Clearance margin wanted beyond all that, also near the final pose (mm).
    pub room: f64,
}

impl Demand {
    /// Clearance wanted wherever the final pose does not stand in the way (mm).
    pub fn wanted(&self) -> f64 {
        self.needed() + self.room
    }

    /// Clearance demanded without the clearance margin (mm).
    fn needed(&self) -> f64 {
        self.spark_gap + self.margin + self.guard
    }
}

/// Clearances wanted of points on single sides of the electrode beyond those of all points, as far as the feed has opened
/// up.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SideDemand {
    /// Clearances wanted of the sides.
    pub thresholds: Thresholds,
    /// Clearance asked of all points (mm).
    pub common_mm: f64,
}

impl SideDemand {
    /// What is wanted of a point on `face` beyond that of all points (mm).
    #[inline]
    fn of(&self, face: ElectrodeFace) -> f64 {
        (self.thresholds.of(face) - self.common_mm).max(0.0)
    }
}

/// Angles by which the low and the high wall are drawn in further than those of the electrode at hand, P0's h (rad).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Turns(pub [f64; 2]);

impl Turns {
    /// The electrode as it is.
    pub const NONE: Self = Self([0.0; 2]);

    /// Both walls drawn in by the same angle (rad).
    pub fn both(h: f64) -> Self {
        Self([h; 2])
    }

    /// Whether no wall is drawn in.
    pub fn is_none(self) -> bool {
        self == Self::NONE
    }
}

/// Withdrawn distance and wall turns, common to all points at one moment of the search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instant {
    /// Withdrawn distance (mm).
    pub s: f64,
    /// Angles by which the walls are drawn in (rad).
    pub turns: Turns,
}

impl Instant {
    /// Whether a point is still part of the electrode.
    #[inline]
    fn holds(&self, sample: &Sample) -> bool {
        let Turns([low, high]) = self.turns;
        sample.stays_to[0] >= low && sample.stays_to[1] >= high
    }
}

/// Direction in which a point follows the additional circumferential reduction h of P0: 0 not at all, 1 with the low
/// wall, 2 with the high wall.
pub fn group(face: ElectrodeFace) -> usize {
    match face {
        ElectrodeFace::LowWall => 1,
        ElectrodeFace::HighWall => 2,
        _ => 0,
    }
}

/// Error bound of a distance field at `distance` (mm): the most that its value may exceed the distance.
fn doubt(distance: f64) -> f64 {
    DistanceField::ACCURACY + 0.05 * (distance - DistanceField::NEAR).max(0.0)
}

/// Points with what is demanded of each, in clusters.
#[derive(Debug, Clone)]
pub struct Probes {
    samples: Vec<Sample>,
    sides: SideDemand,
    /// Clearance of each in the final pose (mm).
    at_final: Vec<f64>,
    clusters: Vec<Cluster>,
    /// Greatest demand of a point in each cluster beyond that of all points (mm).
    cluster_extra: Vec<f64>,
    /// Neighbouring clusters, as balls around all their points; `start` and `end` count clusters.
    blocks: Vec<Cluster>,
    /// The greatest of the values of [`cluster_extra`](Self::cluster_extra) (mm).
    greatest_extra: f64,
    /// Greatest `extra` of a point (mm).
    greatest_learned: f64,
}

impl Probes {
    /// Growth of the demand per mm withdrawn, from the clearance in the final pose to the demand. In the final pose
    /// only the spark gap is open.
    const OPENING: f64 = 0.05;
    /// Withdrawn distance from which on the extra demand of a point counts in full (mm).
    const LEARNED: f64 = 0.25;
    /// Points in a cluster: a balance between tests saved and balls too wide to decide.
    const CLUSTER: usize = 12;

    /// Probes at `samples`, of which those on some sides of the electrode are wanted to keep more; `clearance` returns the
    /// clearance of each in the final pose.
    pub fn new(
        mut samples: Vec<Sample>,
        sides: SideDemand,
        clearance: impl Fn(DVec3) -> f64 + Sync,
        cancel: &Cancel,
    ) -> Result<Self, Cancelled> {
        let clusters = cluster(&mut samples, Self::CLUSTER, |face| group(face) as u8);
        let at_final = samples
            .par_iter()
            .map(|s| cancel.check().map(|()| clearance(s.point)))
            .collect::<Result<_, Cancelled>>()?;
        let extra =
            |c: &Cluster| samples[c.start..c.end].iter().map(|s| s.extra + sides.of(s.face)).fold(0.0, f64::max);
        let cluster_extra: Vec<f64> = clusters.iter().map(extra).collect();
        let greatest_extra = cluster_extra.iter().copied().fold(0.0, f64::max);
        let greatest_learned = samples.iter().map(|s| s.extra).fold(0.0, f64::max);
        let blocks = blocks(&samples, &clusters);
        Ok(Self { samples, sides, at_final, clusters, cluster_extra, blocks, greatest_extra, greatest_learned })
    }

    /// The points, in the order of their numbers.
    pub fn samples(&self) -> &[Sample] {
        &self.samples
    }

    /// The points that are part of the electrode with walls drawn in by `turns`, with their numbers.
    pub fn held(&self, turns: Turns) -> impl Iterator<Item = (usize, &Sample)> {
        let at = Instant { s: 0.0, turns };
        self.samples.iter().enumerate().filter(move |(_, sample)| at.holds(sample))
    }

    /// First cluster that lacks clearance at an instant. `clearance` returns the clearance of a point of a group, or
    /// any value of at least its last argument where the clearance is greater.
    pub fn first_blocked(
        &self,
        at: &Instant,
        demand: &Demand,
        clearance: &impl Fn(DVec3, usize, f64) -> f64,
    ) -> Option<usize> {
        let crowded = self.blocks.iter().filter(|block| {
            let group = self.group_of(&self.clusters[block.start]);
            self.spare(block, group, self.greatest_extra, demand, clearance) < demand.room
        });
        crowded.flat_map(|block| block.start..block.end).find(|&i| !self.cluster_is_free(i, at, demand, clearance))
    }

    /// Lower bound of the spare clearance of a ball of points of one group, without any margin (mm), or any value of at
    /// least the margin demanded.
    #[inline]
    fn spare(
        &self,
        ball: &Cluster,
        group: usize,
        extra: f64,
        demand: &Demand,
        clearance: &impl Fn(DVec3, usize, f64) -> f64,
    ) -> f64 {
        let needed = demand.needed() + extra + ball.radius;
        let enough = needed + demand.room;
        let clearance = clearance(ball.center, group, enough + doubt(enough));
        if clearance.is_finite() { clearance - doubt(clearance) - needed } else { clearance }
    }

    /// A clearance cache for these points.
    pub fn clearance_cache(&self) -> ClearanceCache {
        ClearanceCache::new([self.blocks.len(), self.clusters.len(), self.samples.len()])
    }

    /// Bound on the growth of a point's demand over a further withdrawal by `further` (mm).
    pub fn rise(&self, further: f64) -> f64 {
        let further = further.max(0.0);
        Self::OPENING * further + self.greatest_learned * (further / Self::LEARNED).min(1.0)
    }

    /// Calls `found` with every point that lacks clearance and the clearance it lacks (mm), in order, until `found`
    /// returns false; of each cluster only with the point that lacks most, if `one_each`. Points whose motion bound in
    /// `cache` still holds are skipped.
    pub fn lacking(
        &self,
        at: &Instant,
        demand: &Demand,
        clearance: &impl Fn(DVec3, usize, f64) -> f64,
        cache: &mut ClearanceCache,
        one_each: bool,
        mut found: impl FnMut(usize, f64) -> bool,
    ) {
        let (moved, room) = (cache.moved(), demand.room);
        for (block, rest) in self.blocks.iter().zip(&mut cache.blocks) {
            let group = self.group_of(&self.clusters[block.start]);
            let spare = |ball, extra| self.spare(ball, group, extra, demand, clearance);
            if !rest.opens(moved, room, || spare(block, self.greatest_extra)) {
                continue;
            }
            for i in block.start..block.end {
                let cluster = &self.clusters[i];
                if !cache.clusters[i].opens(moved, room, || spare(cluster, self.cluster_extra[i])) {
                    continue;
                }
                let mut worst: Option<(usize, f64)> = None;
                for k in cluster.start..cluster.end {
                    if cache.points[k].lasts(moved, room) {
                        continue;
                    }
                    let (lack, rest) = self.lack(k, at, demand, clearance, moved);
                    cache.points[k] = rest;
                    if lack > 0.0 && !one_each {
                        if !found(k, lack) {
                            return;
                        }
                    } else if lack > worst.map_or(0.0, |(_, most)| most) {
                        worst = Some((k, lack));
                    }
                }
                if worst.is_some_and(|(k, lack)| !found(k, lack)) {
                    return;
                }
            }
        }
    }

    /// Clearance that point `k` lacks (mm), and its motion bound if it lacks nothing.
    #[inline]
    fn lack(
        &self,
        k: usize,
        at: &Instant,
        demand: &Demand,
        clearance: &impl Fn(DVec3, usize, f64) -> f64,
        moved: f64,
    ) -> (f64, MotionBound) {
        let sample = &self.samples[k];
        if !at.holds(sample) {
            return (0.0, MotionBound::FOR_EVER);
        }
        let demanded = self.demanded(k, at.s, demand);
        let clearance = clearance(sample.point, group(sample.face), demanded);
        (demanded - clearance, MotionBound::of(clearance - doubt(clearance) - demanded + demand.room, moved))
    }

    fn group_of(&self, cluster: &Cluster) -> usize {
        group(self.samples[cluster.start].face)
    }

    /// Number of clusters.
    pub fn clusters(&self) -> usize {
        self.clusters.len()
    }

    /// The points of this set with `more` added; a point that exists already takes the greater demand.
    pub fn joined(&self, more: &[Sample]) -> Vec<Sample> {
        let mut samples = self.samples.clone();
        for new in more {
            match samples.iter_mut().find(|s| s.point.distance(new.point) < 1e-3 && s.face == new.face) {
                Some(known) => known.extra += new.extra,
                None => samples.push(*new),
            }
        }
        samples
    }

    /// Whether every point of cluster `i` has the clearance demanded of it; `clearance` is that of
    /// [`first_blocked`](Self::first_blocked).
    #[inline]
    pub fn cluster_is_free(
        &self,
        i: usize,
        at: &Instant,
        demand: &Demand,
        clearance: &impl Fn(DVec3, usize, f64) -> f64,
    ) -> bool {
        let c = &self.clusters[i];
        let group = self.group_of(c);
        self.spare(c, group, self.cluster_extra[i], demand, clearance) >= demand.room
            || (c.start..c.end).all(|k| {
                let demanded = self.demanded(k, at.s, demand);
                !at.holds(&self.samples[k]) || clearance(self.samples[k].point, group, demanded) >= demanded
            })
    }

    /// Clearance demanded of point `k` when withdrawn by `s`.
    #[inline]
    fn demanded(&self, k: usize, s: f64, demand: &Demand) -> f64 {
        let Sample { extra, face, .. } = self.samples[k];
        let opened = self.at_final[k] + Self::OPENING * s + extra * (s / Self::LEARNED).min(1.0);
        (demand.needed() + extra + self.sides.of(face)).min(opened) + demand.room
    }
}

/// Balls around up to eight neighbouring clusters of one group each.
fn blocks(samples: &[Sample], clusters: &[Cluster]) -> Vec<Cluster> {
    const CLUSTERS: usize = 8;
    let group_of = |c: &Cluster| group(samples[c.start].face);
    let mut blocks = Vec::new();
    let mut start = 0;
    while start < clusters.len() {
        let same = |c: &&Cluster| group_of(c) == group_of(&clusters[start]);
        let end = start + clusters[start..].iter().take(CLUSTERS).take_while(same).count();
        let points = &samples[clusters[start].start..clusters[end - 1].end];
        let center = Bounds::of(points.iter().map(|s| s.point)).center();
        let radius = points.iter().map(|s| s.point.distance(center)).fold(0.0, f64::max);
        blocks.push(Cluster { center, radius, start, end });
        start = end;
    }
    blocks
}
