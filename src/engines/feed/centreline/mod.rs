//! The centreline strategy of P1: the electrode's core point is carried along the centreline of the channel in steps of
//! arc length; at each node the posture is adjusted until all distances are safe.
//!
//! P1 resolves a contact by adjusting the posture, by a greater safety gap, or by a shorter step. Here the posture
//! climbs the distance field from some starts that are given by the line and by the motion so far; then the same is
//! tried with a greater gap, which keeps to the middle of the room there is; steps are shortened by the frame that all
//! strategies share. The axis of withdrawal follows the line alone, so that nodes keep their order; P1 leaves open which
//! axis does.

mod guide;
#[cfg(test)]
mod tests;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

pub use guide::Guide;

use super::pose::{Axis, Pose};
use super::probes::Demand;
use super::problem::{Candidate, Convergence, NodeTask, SearchProblem};
use super::strategy::{Candidates, SearchStrategy, StrategySymbol};
use task::{Cancel, Cancelled};

/// Parameters of the centreline strategy.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CentrelineParams {
    /// By how much the gap that postures are adjusted for is increased where the plain one leads to no free motion
    /// (mm).
    pub safety_increase_mm: f64,
}

impl Default for CentrelineParams {
    fn default() -> Self {
        Self { safety_increase_mm: 0.1 }
    }
}

impl SearchStrategy for CentrelineParams {
    fn candidates(&self, problem: &SearchProblem, at: &NodeTask, cancel: &Cancel) -> Candidates {
        match problem.guide {
            Some(guide) => CentrelineStep::new(self, problem, guide, at).run(cancel),
            None => Ok((Vec::new(), Convergence::none(at.s))),
        }
    }

    fn follows_centreline(&self) -> bool {
        true
    }

    fn parameters(&self) -> Option<&'static str> {
        Some("plan.centreline")
    }

    fn symbols(&self) -> Vec<StrategySymbol> {
        let meaning = "of the gap where the plain one leads to no free motion";
        vec![StrategySymbol::new("increase", meaning, self.safety_increase_mm, "mm")]
    }
}

/// The search for one node.
pub struct CentrelineStep<'a> {
    params: &'a CentrelineParams,
    problem: &'a SearchProblem<'a>,
    guide: &'a Guide,
    task: &'a NodeTask,
}

impl<'a> CentrelineStep<'a> {
    /// Increases of the gap, as shares of the greatest.
    const INCREASES: [f64; 4] = [0.0, 0.25, 0.5, 1.0];

    /// Prepares the search for `task` along `guide`.
    pub fn new(
        params: &'a CentrelineParams,
        problem: &'a SearchProblem<'a>,
        guide: &'a Guide,
        task: &'a NodeTask,
    ) -> Self {
        Self { params, problem, guide, task }
    }

    /// Free postures at the node, those of the plain gap first, the best of each gap first. Where the search has gone
    /// back from a jam, those of an increased gap come first, of another one each time.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn run(&self, cancel: &Cancel) -> Candidates {
        let starts = self.starts();
        let count = Self::INCREASES.len();
        let first = self.task.attempt as usize % count;
        let gaps = (0..count).map(|i| Self::INCREASES[(first + i) % count] * self.params.safety_increase_mm);
        let tries: Vec<(usize, f64, Pose)> =
            gaps.enumerate().flat_map(|(i, more)| starts.iter().map(move |start| (i, more, *start))).collect();
        let adjusted = |&(i, more, start): &(usize, f64, Pose)| {
            cancel.check()?;
            Ok(self.adjusted(start, more).map(|candidate| (i, candidate)))
        };
        let found: Result<Vec<Option<(usize, Candidate)>>, Cancelled> = tries.par_iter().map(adjusted).collect();
        let mut found: Vec<(usize, Candidate)> = found?.into_iter().flatten().collect();
        // The sort is stable: of equals the earlier start comes first.
        found.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.objective.total.total_cmp(&b.1.objective.total)));
        let trace = Convergence { s: self.task.s, best: Vec::new(), mean: Vec::new() };
        Ok((found.into_iter().map(|(_, candidate)| candidate).collect(), trace))
    }

    /// Postures to adjust: the core point on the line, turned with the line, turned on as before, or not turned; and
    /// the motion as before, and the last posture, wherever they leave the core point.
    fn starts(&self) -> Vec<Pose> {
        let NodeTask { from, before, duration, .. } = *self.task;
        let ratio = duration / before.duration;
        let mut onward = from.to_array();
        for (axis, value) in onward.iter_mut().enumerate() {
            *value += before.increments[axis] * ratio;
        }
        let onward = self.task.placed(&Pose::from_array(onward));
        let still = self.task.placed(&from);
        let (axis, turn) = self.guide.turning(self.task.from_s, self.task.s);
        let turned = still.with(axis, from.get(axis) + turn);
        let on_line = [turned, onward, still].map(|pose| self.guide.on_line(&pose));
        // Between what the line asks for and what the room has allowed so far.
        let between = on_line[0].lerp(&onward, 0.5);
        let mut starts = on_line.to_vec();
        starts.extend([between, onward, still]);
        starts.iter_mut().for_each(|pose| self.stay_still(pose));
        starts
    }

    /// Axes that the machine does not have stay where they are.
    fn stay_still(&self, pose: &mut Pose) {
        let mut values = pose.to_array();
        let is_still = |axis: &Axis| *axis != self.task.advance.0 && !self.problem.free_axes().contains(axis);
        for axis in Axis::ALL.into_iter().filter(is_still) {
            values[axis as usize] = self.task.from.get(axis);
        }
        *pose = Pose::from_array(values);
    }

    /// The posture near `start` with a gap increased by `more` as far as there is room, if it is free as asked for.
    fn adjusted(&self, start: Pose, more: f64) -> Option<Candidate> {
        let (problem, task) = (self.problem, self.task);
        let demand = Demand { margin: problem.demand.margin + more, ..problem.demand };
        let (pose, _) = problem.model.climb(start, task.s, problem.turned(task.h_so_far), &demand, problem.free_axes());
        if !problem.is_free(&pose, task.s, task.h_so_far, &mut 0) {
            return None;
        }
        let objective = problem.objective.value(&pose, task.h_so_far, &task.motion_to(&pose), &task.before);
        Some(Candidate { pose, h: task.h_so_far, objective })
    }
}
