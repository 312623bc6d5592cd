//! Approach from a position clear of all bodies to the first row of the feed.

use glam::DVec3;

use super::Scenario;
use crate::chain::Chain;
use crate::machine::MachineParams;
use crate::pose::{Axis, Pose};
use crate::quantise::{quantise, quantise_mm};

/// Step to which files round lengths (mm).
const STEP: f64 = 1e-5;

/// Straight moves from a clear position to the first row of the feed.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Approach {
    /// The poses; the last is the first row.
    pub poses: Vec<Pose>,
}

/// Candidate approaches, best first: across above the blisk, then in beside it to the first row; without the motion
/// across; and none at all. The rotary axes are turned before.
pub(super) fn candidates(scenario: &Scenario, chain: &Chain, clear: f64) -> Vec<Approach> {
    let Some(first) = scenario.feed.0.rows.first().map(|row| row.pose) else { return vec![Approach::default()] };
    let machine = scenario.machine;
    let side = scenario.electrode.enters_from;
    let axis = Axis::of_withdrawal(side);
    let position = first.get(axis);
    let out = first.with(axis, within(machine, axis, position + side.sign() * clear, position));
    let up = within(machine, Axis::Z, first.z + rise(scenario, &first, clear), first.z);
    let up = if axis == Axis::Z { out } else { Pose { z: up, ..out } };
    let out = within_slides(machine, chain, &first, out);
    let up = within_slides(machine, chain, &out, Pose { x: out.x, y: out.y, ..up });
    [vec![up, out, first], vec![out, first], vec![first]].map(shortened).to_vec()
}

/// `value` (mm), rounded as files are, as far as the travel of `axis` goes, seen from `from`, which may itself be
/// beyond it.
fn within(machine: &MachineParams, axis: Axis, value: f64, from: f64) -> f64 {
    let [least, most] = machine.travel(axis);
    let [least, most] = [least.min(from), most.max(from)];
    let rounded = quantise_mm(value.clamp(least, most));
    if (least..=most).contains(&rounded) {
        return rounded;
    }
    // The step of files nearest to the end of travel is beyond it; the one before is not.
    quantise_mm(rounded + STEP.copysign(from - rounded))
}

/// `to`, or the place on the straight way there from `from` where the slides of a machine whose C turns the table end.
/// The slides are linear on the way, where nothing else moves.
fn within_slides(machine: &MachineParams, chain: &Chain, from: &Pose, to: Pose) -> Pose {
    let limits = machine.limits();
    let is_within = |t: f64| limits.beyond(&chain.machine_pose(&from.lerp(&to, t))).is_none();
    if chain.on_table_c().is_none() || is_within(1.0) {
        return to;
    }
    let (mut within, mut beyond) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (within + beyond);
        if is_within(middle) {
            within = middle;
        } else {
            beyond = middle;
        }
    }
    // Files round to their step.
    let way = DVec3::new(to.x - from.x, to.y - from.y, to.z - from.z).length();
    from.lerp(&to, (within - 2.0 * STEP / way).max(0.0))
}

/// How far the electrode has to rise from `pose` to be above the blisk by `clear` (mm).
fn rise(scenario: &Scenario, pose: &Pose, clear: f64) -> f64 {
    let electrode = scenario.electrode;
    let place = Pose { a: 0.0, ..*pose }.placement(electrode.reference_point);
    let heights = electrode.mesh.vertices.iter().map(|&p| place.transform_point3(p).z);
    let lowest = heights.fold(f64::INFINITY, f64::min);
    let top = scenario.blisk.vertices.iter().map(|p| p.y.hypot(p.z)).fold(0.0, f64::max);
    let rise = top + clear - lowest;
    if rise.is_finite() { rise.max(0.0) } else { 0.0 }
}

/// Approach with its poses rounded as in files, without repetitions.
fn shortened(poses: Vec<Pose>) -> Approach {
    let last = poses.len().saturating_sub(1);
    let mut rounded: Vec<Pose> =
        poses.iter().enumerate().map(|(i, pose)| if i == last { *pose } else { quantise(pose) }).collect();
    rounded.dedup();
    Approach { poses: rounded }
}
