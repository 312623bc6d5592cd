//! Moving a pose by following the distance fields: to the nearest free one, or to where there is most room.

use glam::{DMat3, DVec3};

use super::clearance::{ClearanceModel, Lacking, NearbyPoses, Shortfall};
use super::pose::{Axis, Pose};
use super::probes::{Demand, Instant, Turns};
use task::{Cancel, Cancelled};

/// End of an ascent.
#[derive(Debug, Clone, Copy)]
pub struct Ascent {
    /// The pose.
    pub pose: Pose,
    /// Clearance that the worst probe lacks there (mm), 0 if none does.
    pub lack: f64,
    /// The worst probe, if one lacks clearance.
    pub worst: Option<Shortfall>,
}

/// How fast the clearance of a probe grows along each axis, in steps of its [`mobility`].
pub(super) type Slopes = [f64; 6];

impl ClearanceModel<'_> {
    /// Moves `start` along `axes` towards freedom by following the distance fields: in each round every probe that
    /// lacks clearance shifts the pose by the smallest motion that would mend it. Returns the best pose met
    /// and the probe that still lacks most there, none if the pose is free.
    pub fn climb(
        &self,
        start: Pose,
        s: f64,
        turns: Turns,
        demand: &Demand,
        axes: &[Axis],
    ) -> (Pose, Option<Shortfall>) {
        const ROUNDS: usize = 16;
        /// Rounds without getting nearer to freedom after which it is given up.
        const PATIENCE: usize = 3;
        const WORST: usize = 24;
        let mut nearby = self.nearby();
        let mut pose = start;
        let mut best: Option<(Pose, Shortfall)> = None;
        let mut since_best = 0;
        for _ in 0..ROUNDS {
            let lacking = self.worst_lacking(&mut nearby, &pose, (s, turns), demand, false, WORST);
            let Some(&worst) = lacking.first() else { return (pose, None) };
            if best.is_none_or(|(_, known)| worst.lack < known.lack) {
                best = Some((pose, worst));
                since_best = 0;
            } else if since_best == PATIENCE {
                break;
            } else {
                since_best += 1;
            }
            pose = self.shifted(&pose, &lacking, axes);
        }
        best.map_or((start, None), |(pose, worst)| (pose, Some(worst)))
    }

    /// The probes that lack most clearance, worst first, at most `most` of them.
    fn worst_lacking(
        &self,
        nearby: &mut NearbyPoses,
        pose: &Pose,
        (s, turns): (f64, Turns),
        demand: &Demand,
        one_each: bool,
        most: usize,
    ) -> Vec<Shortfall> {
        let placed = self.placed(pose, turns);
        let mut lacking = self.lacking(nearby, &placed, &Instant { s, turns }, demand, one_each);
        let worse = |a: &Lacking, b: &Lacking| b.lack.total_cmp(&a.lack).then(a.probe.cmp(&b.probe));
        if lacking.len() > most {
            lacking.select_nth_unstable_by(most, worse);
            lacking.truncate(most);
        }
        lacking.sort_unstable_by(worse);
        lacking.into_iter().map(|l| self.shortfall(l, &placed)).collect()
    }

    /// One round of climbing: projects the pose onto the half-space in which each of the worst probes has room,
    /// one after the other (Kaczmarz), to first order.
    fn shifted(&self, pose: &Pose, lacking: &[Shortfall], axes: &[Axis]) -> Pose {
        /// Beyond the demand, so that rounding does not undo the shift (mm).
        const BEYOND: f64 = 2e-4;
        let start = pose.to_array();
        let mut q = start;
        for short in lacking {
            let slopes = self.slopes(pose, short.at, short.away);
            let slope = |a: Axis| slopes[a as usize];
            let weight = |a: Axis| mobility(a).powi(2);
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

    /// Moves `start` along `axes` to where the worst probe lacks least, by at most `steps` steps of steepest ascent of
    /// the least clearance within a region in which the fields are trusted. What lies between two walls comes to stand
    /// in the middle between them.
    pub fn ascend(
        &self,
        start: Pose,
        at: (f64, Turns),
        demand: &Demand,
        axes: &[Axis],
        steps: usize,
        cancel: &Cancel,
    ) -> Result<Ascent, Cancelled> {
        self.ascend_from(start, at, demand, axes, |_| steps, cancel)
    }

    /// [`ascend`](Self::ascend) by as many steps as `steps` returns for what the worst probe lacks at `start` (mm).
    pub(super) fn ascend_from(
        &self,
        start: Pose,
        at: (f64, Turns),
        demand: &Demand,
        axes: &[Axis],
        steps: impl FnOnce(f64) -> usize,
        cancel: &Cancel,
    ) -> Result<Ascent, Cancelled> {
        const WORST: usize = 48;
        /// Length of the first and of the last step (mm).
        const TRUST: [f64; 2] = [0.4, 0.004];
        /// Share of the expected gain with which a step is a good one.
        const GOOD: f64 = 0.5;
        let mut nearby = self.nearby();
        let mut look = |pose: &Pose| self.worst_lacking(&mut nearby, pose, at, demand, true, WORST);
        let lack_of = |lacking: &[Shortfall]| lacking.first().map_or(0.0, |w| w.lack);
        let (mut pose, mut lacking, mut trust) = (start, look(&start), TRUST[0]);
        for _ in 0..steps(lack_of(&lacking)) {
            // At a pose where none was before, the distance fields are made first.
            cancel.check()?;
            let lack = lack_of(&lacking);
            if lack == 0.0 || trust < TRUST[1] {
                break;
            }
            let (next, expected) = self.steepest(&pose, &lacking, axes, trust);
            let there = look(&next);
            let gain = lack - lack_of(&there);
            if gain > 0.0 {
                (pose, lacking) = (next, there);
            }
            trust *= if gain >= GOOD * expected { 1.5 } else { 0.4 };
        }
        Ok(Ascent { pose, lack: lack_of(&lacking), worst: lacking.first().copied() })
    }

    /// The step that gains most for the worst of `lacking`, to first order, less half its square over `trust` (mm), and
    /// what it is expected to gain (mm). Solved in the dual: weights of the probes, at first all on the worst, are
    /// moved from the least to the most pressing one.
    fn steepest(&self, pose: &Pose, lacking: &[Shortfall], axes: &[Axis], trust: f64) -> (Pose, f64) {
        const ROUNDS: usize = 60;
        let slopes: Vec<Slopes> = lacking.iter().map(|short| self.scaled_slopes(pose, short, axes)).collect();
        let mut weights = vec![0.0; lacking.len()];
        weights[0] = 1.0;
        let mut step = slopes[0].map(|g| trust * g);
        let left = |i: usize, step: &Slopes| lacking[i].lack - dot(&slopes[i], step);
        for _ in 0..ROUNDS {
            let (mut most, mut least) = ((0, f64::NEG_INFINITY), (0, f64::INFINITY));
            for (i, weight) in weights.iter().enumerate() {
                let left = left(i, &step);
                if left > most.1 {
                    most = (i, left);
                }
                if *weight > 0.0 && left < least.1 {
                    least = (i, left);
                }
            }
            let ((to, worst), (from, easiest)) = (most, least);
            let apart: Slopes = std::array::from_fn(|k| slopes[to][k] - slopes[from][k]);
            let bend = trust * dot(&apart, &apart);
            if worst - easiest < 1e-5 || bend < 1e-12 {
                break;
            }
            let moved = ((worst - easiest) / bend).min(weights[from]);
            weights[to] += moved;
            weights[from] -= moved;
            step.iter_mut().zip(apart).for_each(|(s, a)| *s += trust * moved * a);
        }
        let worst_left = (0..lacking.len()).map(|i| left(i, &step)).fold(f64::NEG_INFINITY, f64::max);
        let mut q = pose.to_array();
        for &axis in axes {
            q[axis as usize] += mobility(axis) * step[axis as usize];
        }
        (Pose::from_array(q), lacking[0].lack - worst_left)
    }

    /// Constraints near a pose: for the worst probe of each cluster that lacks clearance, the slopes of its clearance
    /// along the axes, in steps of each axis's [`mobility`], and the clearance it lacks (mm).
    pub(super) fn walls_about(
        &self,
        pose: &Pose,
        at: (f64, Turns),
        demand: &Demand,
        axes: &[Axis],
    ) -> Vec<(Slopes, f64)> {
        const WORST: usize = 64;
        let near = self.worst_lacking(&mut self.nearby(), pose, at, demand, true, WORST);
        near.iter().map(|short| (self.scaled_slopes(pose, short, axes), short.lack)).collect()
    }

    fn scaled_slopes(&self, pose: &Pose, short: &Shortfall, axes: &[Axis]) -> Slopes {
        let slopes = self.slopes(pose, short.at, short.away);
        let mut scaled = [0.0; 6];
        for &axis in axes {
            scaled[axis as usize] = mobility(axis) * slopes[axis as usize];
        }
        scaled
    }

    /// How fast the point of the electrode now at `p` (in W) moves along `direction` with each axis at `pose`.
    fn slopes(&self, pose: &Pose, p: DVec3, direction: DVec3) -> Slopes {
        let table = DMat3::from_rotation_x(pose.a);
        let slid = self.reference_point() + DVec3::new(pose.x, pose.y, pose.z);
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

/// Size of a step along an axis that moves the electrode's points by about 1 mm (mm or rad).
pub(super) fn mobility(axis: Axis) -> f64 {
    match axis {
        Axis::X | Axis::Y | Axis::Z => 1.0,
        Axis::A => 1.0 / 100.0,
        Axis::B | Axis::C => 1.0 / 10.0,
    }
}

fn dot(a: &Slopes, b: &Slopes) -> f64 {
    a.iter().zip(b).map(|(p, q)| p * q).sum()
}
