//! The problem that every strategy works on, and what its answer is made of. A problem knows no strategy.

use serde::{Deserialize, Serialize};

use super::angle_test::AngleTest;
use super::axis_curve::Joining;
use super::centreline::Guide;
use super::clearance::{ClearanceModel, Shortfall};
use super::climb::mobility;
use super::jam::Jam;
use super::machine::{AxisSet, TravelLimits};
use super::objective::{Objective, ObjectiveValue, StepMotion};
use super::pose::{Axis, Pose};
use super::probes::{Demand, Turns};
use wheel::electrode::EntrySide;

/// Called with the nodes found so far, from the final pose outwards, and the convergence of each of them.
pub type Observe<'a> = dyn Fn(&[Node], &[Convergence]) + Sync + 'a;

/// The search problem of one electrode in its channel.
#[derive(Clone, Copy)]
pub struct SearchProblem<'a> {
    /// Clearance of the electrode's samples in the distance field.
    pub model: &'a ClearanceModel<'a>,
    /// The angle test, if it is the constraint.
    pub angle: Option<&'a AngleTest<'a>>,
    /// The objective.
    pub objective: &'a Objective<'a>,
    /// Axes of the machine.
    pub axes: AxisSet,
    /// Travel of the axes.
    pub travel: TravelLimits,
    /// Full ranges of motion in one step, (7), in the order of [`Axis`]; 0 for axes that do not move.
    pub ranges: [f64; 6],
    /// Clearance demanded.
    pub demand: Demand,
    /// Angles by which the walls are drawn in from those of the model's electrode, before any h that is searched for
    /// (rad).
    pub turns: Turns,
    /// The side that the electrode is withdrawn to.
    pub side: EntrySide,
    /// Curve that will join the nodes.
    pub joining: Joining,
    /// Distance between nodes (mm).
    pub step: f64,
    /// Intervals of withdrawn distance searched in finer steps (mm); each interval that holds a node halves its step.
    pub fine: &'a [[f64; 2]],
    /// Distance outside the blisk to which the electrode is withdrawn (mm).
    pub exit_clearance: f64,
    /// Centreline that nodes follow in steps of arc length; without one they follow the axis of withdrawal.
    pub guide: Option<&'a Guide>,
    /// Called with the nodes found so far after each of them.
    pub observe: &'a Observe<'a>,
}

/// The search for one node.
#[derive(Debug, Clone)]
pub struct NodeTask {
    /// Pose of the node before.
    pub from: Pose,
    /// Withdrawn distance of the node before (mm).
    pub from_s: f64,
    /// Withdrawn distance of this node (mm).
    pub s: f64,
    /// The axis along which the electrode is withdrawn, and the position of this node on it (mm).
    pub advance: (Axis, f64),
    /// Length of this step over the nominal one.
    pub duration: f64,
    /// The step before.
    pub before: StepMotion,
    /// Greatest h that a node has taken so far (rad).
    pub h_so_far: f64,
    /// Number of times that the search has gone back; seeds other random numbers.
    pub attempt: u64,
}

impl NodeTask {
    /// `pose` at this node's position on the axis of withdrawal.
    pub fn placed(&self, pose: &Pose) -> Pose {
        let (axis, position) = self.advance;
        pose.with(axis, position)
    }

    /// The motion from the node before to `pose`.
    pub fn motion_to(&self, pose: &Pose) -> StepMotion {
        StepMotion::between(&self.from, pose, self.duration)
    }
}

/// A free pose for a node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// The pose.
    pub pose: Pose,
    /// Additional circumferential reduction h (rad).
    pub h: f64,
    /// Objective values of the pose.
    pub objective: ObjectiveValue,
}

/// A node of the path, counted from the final pose, which is node 0.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Node {
    /// Withdrawn distance (mm).
    pub s: f64,
    /// Axis values.
    pub pose: Pose,
    /// Additional circumferential reduction h taken here (rad).
    pub h: f64,
    /// Least clearance of the samples in the search's distance field (mm).
    pub clearance: f64,
    /// Objective values.
    pub objective: ObjectiveValue,
}

/// Course of the objective over the generations at a node.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Convergence {
    /// Withdrawn distance of the node (mm).
    pub s: f64,
    /// Least objective in each generation, the first population included.
    pub best: Vec<f64>,
    /// Mean objective in each generation.
    pub mean: Vec<f64>,
}

impl Convergence {
    /// Empty convergence of a node, withdrawn by `s` (mm), that was not searched over generations.
    pub fn none(s: f64) -> Self {
        Self { s, best: Vec::new(), mean: Vec::new() }
    }

    /// Adds a generation.
    pub fn record(&mut self, objectives: impl ExactSizeIterator<Item = f64>) {
        let n = objectives.len() as f64;
        let (least, sum) = objectives.fold((f64::INFINITY, 0.0), |(least, sum), v| (least.min(v), sum + v));
        self.best.push(least);
        self.mean.push(sum / n);
    }
}

/// Result of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchOutcome {
    /// Nodes from the final pose outwards.
    pub nodes: Vec<Node>,
    /// Convergence of each node's search.
    pub convergence: Vec<Convergence>,
    /// Jam, if the electrode did not come out.
    pub jam: Option<Jam>,
}

impl SearchProblem<'_> {
    /// Share of the allowance that nodes must keep where the whole does not fit.
    const NARROW: f64 = 0.3;
    /// Least and greatest number of parts of an interval between two nodes, at whose joints the motion is tested.
    const PARTS: [f64; 2] = [5.0, 40.0];
    /// How far the electrode's points may move from one such joint to the next (mm).
    const STRIDE: f64 = 0.2;

    /// The machine's axes except the one along which the electrode is withdrawn.
    pub fn free_axes(&self) -> &'static [Axis] {
        self.axes.free_axes(self.side)
    }

    /// The axis along which the electrode is withdrawn, and its position there when it is withdrawn by `s` (mm).
    pub fn advance(&self, s: f64) -> (Axis, f64) {
        (Axis::of_withdrawal(self.side), self.side.sign() * s)
    }

    /// `pose` withdrawn by `s` (mm).
    pub fn withdrawn(&self, pose: &Pose, s: f64) -> Pose {
        let (axis, position) = self.advance(s);
        pose.with(axis, position)
    }

    /// Whether `pose`, withdrawn by `s`, is within the machine's travel and meets the constraint.
    pub fn is_free(&self, pose: &Pose, s: f64, h: f64, hint: &mut usize) -> bool {
        self.keeps(pose, s, h, &self.demand, hint)
    }

    /// Whether the constraint holds with `demand` in place of the problem's own.
    pub(super) fn keeps(&self, pose: &Pose, s: f64, h: f64, demand: &Demand, hint: &mut usize) -> bool {
        if self.travel.beyond(pose).is_some() {
            return false;
        }
        match self.angle {
            None => self.model.is_free(pose, s, self.turned(h), demand, hint),
            Some(test) => test.is_free(self.model, pose, self.turned(h)),
        }
    }

    /// Nearest free pose by [`ClearanceModel::climb`] with the problem's demand, and the worst shortfall left there.
    pub fn climb(&self, pose: Pose, s: f64, h: f64) -> (Pose, Option<Shortfall>) {
        self.model.climb(pose, s, self.turned(h), &self.demand, self.free_axes())
    }

    /// How far the walls are drawn in with an additional reduction h (rad).
    pub(super) fn turned(&self, h: f64) -> Turns {
        Turns(self.turns.0.map(|turn| turn + h))
    }

    /// Demand of nodes where the whole allowance does not fit.
    pub(super) fn narrow(&self) -> Demand {
        Demand { guard: Self::NARROW * self.demand.guard, ..self.demand }
    }

    /// Demand between nodes: the allowance that nodes keep may be used up there.
    pub(super) fn between(&self) -> Demand {
        Demand { guard: 0.0, ..self.demand }
    }

    /// Fractions of the motion from one node to the next at which it is tested.
    pub(super) fn joints(&self, from: &Node, to: &Node) -> impl Iterator<Item = f64> + use<> {
        let strides = self.model.motion_between(&from.pose, &to.pose) / Self::STRIDE;
        let parts = strides.ceil().clamp(Self::PARTS[0], Self::PARTS[1]);
        (1..parts as usize).map(move |i| i as f64 / parts)
    }

    /// Distance of the electrode outside the blisk at `pose` (mm); negative while a point is not beyond the metal.
    pub fn distance_outside(&self, pose: &Pose) -> f64 {
        self.model.outside().distance_outside(pose, self.side)
    }

    pub(super) fn final_node(&self) -> Node {
        let clearance = self.model.least_clearance(&Pose::FINAL, self.turns);
        Node { s: 0.0, pose: Pose::FINAL, h: 0.0, clearance, objective: ObjectiveValue::default() }
    }

    pub(super) fn task(&self, nodes: &[Node], duration: f64) -> NodeTask {
        let last = &nodes[nodes.len() - 1];
        let before = match nodes {
            [.., a, b] => StepMotion::between(&a.pose, &b.pose, (b.s - a.s) / self.step),
            // Nothing has moved yet but the axis of withdrawal, whose rate is the nominal one.
            _ => StepMotion { increments: [0.0; 6], duration: 1.0 },
        };
        let step = self.step * duration;
        let (s, duration) = match self.guide {
            None => (last.s + step, duration),
            Some(guide) => {
                let s = guide.next_s(last.s, step);
                (s, (s - last.s) / self.step)
            }
        };
        NodeTask {
            from: last.pose,
            from_s: last.s,
            s,
            advance: self.advance(s),
            duration,
            before,
            h_so_far: nodes.iter().map(|n| n.h).fold(0.0, f64::max),
            attempt: 0,
        }
    }

    pub(super) fn node(&self, task: &NodeTask, chosen: &Candidate) -> Node {
        let clearance = self.model.least_clearance(&chosen.pose, self.turned(chosen.h));
        Node { s: task.s, pose: chosen.pose, h: chosen.h, clearance, objective: chosen.objective }
    }

    /// The nodes with the objective of the steps between them as they are now.
    pub(super) fn valued(&self, mut nodes: Vec<Node>) -> Vec<Node> {
        let mut before = StepMotion { increments: [0.0; 6], duration: 1.0 };
        for k in 1..nodes.len() {
            let (from, to) = (nodes[k - 1], nodes[k]);
            let motion = StepMotion::between(&from.pose, &to.pose, (to.s - from.s) / self.step);
            nodes[k].objective = self.objective.value(&to.pose, to.h, &motion, &before);
            before = motion;
        }
        nodes
    }

    /// `pose` with every free axis moved by up to `spread` times its [`mobility`] either way: point `n` of the
    /// [`quasi_random`] sequence.
    pub(super) fn scattered(&self, pose: &Pose, spread: f64, n: f64) -> Pose {
        let mut q = pose.to_array();
        for (k, &axis) in self.free_axes().iter().enumerate() {
            q[axis as usize] += spread * mobility(axis) * (2.0 * quasi_random(n, k) - 1.0);
        }
        Pose::from_array(q)
    }
}

/// Coordinate `k`, 0 to 1, of point `n` of a low-discrepancy sequence in five dimensions: the additive recurrence by
/// powers of the generalised golden ratio, the root of `x^6 = x + 1` (Roberts's R sequence).
pub(crate) fn quasi_random(n: f64, k: usize) -> f64 {
    const RATIO: f64 = 1.134_724_138_401_519_4;
    (0.5 + n * RATIO.powi(-(k as i32 + 1))).fract()
}

#[cfg(test)]
mod tests {
    use super::quasi_random;

    #[test]
    fn every_part_of_the_space_gets_its_share() {
        for k in 0..5 {
            let mut parts = [0; 8];
            (0..800).for_each(|n| parts[(quasi_random(f64::from(n), k) * 8.0) as usize] += 1);
            assert!(parts.iter().all(|&n| (85..=115).contains(&n)), "{k}: {parts:?}");
        }
        let ratio: f64 = 1.134_724_138_401_519_4;
        assert!((ratio.powi(6) - ratio - 1.0).abs() < 1e-12);
    }
}
