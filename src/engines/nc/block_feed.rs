//! Distance and duration of the electrode's motion within a block, and the F word for them.

use glam::DVec3;

use super::post::FeedMode;
use feed::chain::Chain;
use feed::machine::MachineParams;
use feed::path::PathRow;
use feed::pose::{Axis, Pose};
use geometry::mesh::Bounds;

/// Pieces a block is measured in; with blocks of a few degrees the chords miss less than one part in 10^5.
const PIECES: usize = 8;

/// Shortest time a block is given where F is a time (min): a block that moves nothing still needs one.
pub const LEAST_BLOCK_MINUTES: f64 = 0.01 / 60.0;

/// Data that F words are computed from.
#[derive(Debug, Clone, Copy)]
pub struct Pace<'a> {
    /// Meaning of F.
    pub mode: FeedMode,
    /// Decimals of the F word.
    pub decimals: usize,
    /// The machine whose speeds are not to be exceeded.
    pub machine: &'a MachineParams,
    /// O in W (mm).
    pub reference_point: DVec3,
    /// Box around the electrode in its final pose, in W (mm).
    pub electrode: &'a Bounds,
    /// What makes axis values of the machine from poses.
    pub chain: &'a Chain,
}

/// The F word of a block.
#[derive(Debug, Clone, PartialEq)]
pub struct BlockFeed {
    /// The number, in decimals.
    pub text: String,
    /// Share of the programmed speed (1: all of it) and the axis that would be too fast with more.
    pub share: f64,
    /// Axis that limits the speed.
    pub axis: Axis,
}

impl Pace<'_> {
    /// The F word of the block from one pose to the other at `mm_per_min`, lowered so far that no axis exceeds its
    /// greatest speed. None when that is slower than the decimals of F can say.
    pub fn block(&self, from: &Pose, to: &Pose, mm_per_min: f64) -> Option<BlockFeed> {
        let axes = [from, to].map(|pose| self.chain.machine_pose(pose));
        let (least_minutes, axis) = self.machine.least_minutes(&axes[0], &axes[1]);
        let travel = || fastest_point_travel(from, to, self.reference_point, self.electrode);
        // As the control takes it: in feed per minute F is over the programmed length.
        let length = if self.mode == FeedMode::PerMinute { programmed_length(&axes[0], &axes[1]) } else { travel() };
        let asked = length / mm_per_min;
        let minutes = asked.max(least_minutes);
        let f = match self.mode {
            FeedMode::PerMinute if asked >= least_minutes => slow_down(mm_per_min, self.decimals),
            FeedMode::PerMinute => slow_down(length / minutes, self.decimals),
            FeedMode::InverseTime => slow_down(1.0 / minutes.max(LEAST_BLOCK_MINUTES), self.decimals),
            FeedMode::Seconds => Some(whole_seconds(minutes.max(LEAST_BLOCK_MINUTES), self.decimals)),
        };
        let share = if least_minutes > asked { asked / least_minutes } else { 1.0 };
        f.map(|f| BlockFeed { text: format!("{f:.*}", self.decimals), share, axis })
    }

    /// The F words of linear motion along `rows`, one for each but the first.
    ///
    /// # Errors
    /// The number of the first block whose F word would be 0.
    pub fn blocks(&self, rows: &[PathRow], mm_per_min: f64) -> Result<Vec<BlockFeed>, usize> {
        let pairs = rows.windows(2).enumerate();
        pairs.map(|(i, pair)| self.block(&pair[0].pose, &pair[1].pose, mm_per_min).ok_or(i)).collect()
    }

    /// F of the approach (feed per minute), whose start is not known: no faster than any axis may go.
    pub fn approach(&self, mm_per_min: f64) -> Option<String> {
        let MachineParams { speed_mm_min, speed_deg_min, .. } = self.machine;
        let f = slow_down(mm_per_min.min(*speed_mm_min).min(*speed_deg_min), self.decimals)?;
        Some(format!("{f:.*}", self.decimals))
    }
}

/// Share of a step by which a number may be beyond it and still count as this step.
const ROUNDING: f64 = 1e-6;

/// `f` rounded down to `decimals`, so that no limit is exceeded; None if nothing is left of it.
pub(super) fn slow_down(f: f64, decimals: usize) -> Option<f64> {
    let steps = 10f64.powi(decimals as i32);
    let down = (f * steps + ROUNDING).floor() / steps;
    (down > 0.0).then_some(down)
}

/// The seconds of a time in minutes, rounded up to `decimals`.
pub(super) fn whole_seconds(minutes: f64, decimals: usize) -> f64 {
    let steps = 10f64.powi(decimals as i32);
    (minutes * 60.0 * steps - ROUNDING).ceil() / steps
}

/// Slowed blocks of a program.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slowed {
    /// Blocks that are slower.
    pub blocks: usize,
    /// Blocks in all.
    pub of: usize,
    /// Least share of the speed asked for that is left.
    pub least_share: f64,
    /// The axis that demands it.
    pub axis: Axis,
}

impl Slowed {
    /// The summary of `feeds`; None if all have the speed asked for.
    pub fn of<'f>(feeds: impl Iterator<Item = &'f BlockFeed> + Clone) -> Option<Self> {
        let slower = feeds.clone().filter(|f| f.share < 1.0);
        let least = slower.clone().min_by(|a, b| a.share.total_cmp(&b.share))?;
        Some(Self { blocks: slower.count(), of: feeds.count(), least_share: least.share, axis: least.axis })
    }
}

/// An upper bound of the way (mm) that the fastest electrode point travels, relative to the workpiece, while
/// every axis moves linearly from `from` to `to`. `reference_point` is O and `electrode` the electrode's box in
/// its final pose, both in W.
pub fn fastest_point_travel(from: &Pose, to: &Pose, reference_point: DVec3, electrode: &Bounds) -> f64 {
    // A point's place is affine in the point, so its speed is convex in it and greatest at a corner of the box.
    let corners = std::array::from_fn::<_, 8, _>(|i| {
        DVec3::select(glam::BVec3::new(i & 1 == 0, i & 2 == 0, i & 4 == 0), electrode.min, electrode.max)
    });
    let mut placed = corners.map(|p| from.placement(reference_point).transform_point3(p));
    let mut travel = [0.0; 8];
    for i in 1..=PIECES {
        let placement = from.lerp(to, i as f64 / PIECES as f64).placement(reference_point);
        for ((corner, place), way) in corners.iter().zip(&mut placed).zip(&mut travel) {
            let next = placement.transform_point3(*corner);
            *way += next.distance(*place);
            *place = next;
        }
    }
    travel.into_iter().fold(0.0, f64::max)
}

/// Length that a control with feed per minute refers F to in a block: the path length in X, Y and Z (mm) when any of
/// them moves, else that in A, B and C (degrees), as in RS-274/NGC.
pub fn programmed_length(from: &Pose, to: &Pose) -> f64 {
    let change = |axis: Axis| to.get(axis) - from.get(axis);
    let norm = |axes: [Axis; 3]| axes.map(change).iter().map(|d| d * d).sum::<f64>().sqrt();
    let linear = norm([Axis::X, Axis::Y, Axis::Z]);
    if linear > 0.0 { linear } else { norm([Axis::A, Axis::B, Axis::C]).to_degrees() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const BOX: Bounds = Bounds { min: DVec3::new(-5.0, -3.0, 100.0), max: DVec3::new(5.0, 4.0, 120.0) };

    #[test]
    fn a_slide_travels_its_length_and_a_turn_its_arc() {
        let o = DVec3::new(2.0, 1.0, 50.0);
        let slide = Pose { x: 3.0, y: -4.0, z: 12.0, ..Pose::FINAL };
        assert!((fastest_point_travel(&Pose::FINAL, &slide, o, &BOX) - 13.0).abs() < 1e-12);
        let table = Pose { a: 0.05, ..Pose::FINAL };
        let arc = 0.05 * 4f64.hypot(120.0);
        assert!((fastest_point_travel(&Pose::FINAL, &table, o, &BOX) / arc - 1.0).abs() < 1e-5);
        let tool = Pose { c: -0.2, ..Pose::FINAL };
        let arc = 0.2 * 7f64.hypot(4.0);
        assert!((fastest_point_travel(&Pose::FINAL, &tool, o, &BOX) / arc - 1.0).abs() < 1e-4);
    }

    #[test]
    fn a_rotary_block_is_programmed_in_degrees() {
        let turn = Pose { a: 3f64.to_radians(), c: 4f64.to_radians(), ..Pose::FINAL };
        assert!((programmed_length(&Pose::FINAL, &turn) - 5.0).abs() < 1e-12);
        let both = Pose { x: 0.5, ..turn };
        assert_eq!(programmed_length(&Pose::FINAL, &both), 0.5);
    }

    proptest! {
        #[test]
        fn no_point_of_the_box_travels_further(
            pose in prop::array::uniform6(-0.3..0.3f64),
            place in prop::array::uniform3(0.0..1.0f64),
        ) {
            let (o, to) = (DVec3::new(0.0, 0.0, 110.0), Pose::from_array(pose));
            let p = BOX.min + DVec3::from_array(place) * BOX.size();
            let at = |t: f64| Pose::FINAL.lerp(&to, t).placement(o).transform_point3(p);
            let way: f64 = (0..400).map(|i| at(i as f64 / 400.0).distance(at((i + 1) as f64 / 400.0))).sum();
            prop_assert!(way <= fastest_point_travel(&Pose::FINAL, &to, o, &BOX) * (1.0 + 1e-3));
        }
    }
}
