//! The two methods that the papers compare themselves with, as strategies: their objectives are those of the papers,
//! the search is our own.
//!
//! - Free travel (Kang et al. 2018, P0's reference 11): the electrode goes straight on along the main direction as long
//!   as it is free; where it is stopped, the other axes are set so that it can go straight on furthest.
//! - Greatest least distance (Ayesta et al. 2016, P0's reference 10): at every node the electrode stands where the
//!   least distance to the blisk is greatest.
//!
//! Neither looks at smoothness.

use rayon::prelude::*;

use super::pose::Pose;
use super::probes::Demand;
use super::problem::{Candidate, Convergence, NodeTask, SearchProblem};
use super::strategy::{Candidates, SearchStrategy};
use task::{Cancel, Cancelled};

/// Poses that are tried for a node.
const SEEDS: usize = 24;
/// Spread of those poses about the pose before (mm), by turns.
const SPREADS: [f64; 3] = [0.3, 1.0, 3.0];
/// Steps of ascent for each.
const ASCENT: usize = 16;

/// Straight on along the main direction.
pub(super) struct FreeTravel;

impl SearchStrategy for FreeTravel {
    fn candidates(&self, problem: &SearchProblem, at: &NodeTask, cancel: &Cancel) -> Candidates {
        Ok((problem.furthest_travelling(at, cancel)?, Convergence::none(at.s)))
    }
}

/// The greatest least distance at every node.
pub(super) struct MaxMinDistance;

impl SearchStrategy for MaxMinDistance {
    fn candidates(&self, problem: &SearchProblem, at: &NodeTask, cancel: &Cancel) -> Candidates {
        Ok((problem.greatest_clearance(at, cancel)?, Convergence::none(at.s)))
    }
}

impl SearchProblem<'_> {
    /// The pose before if it is free at the node; otherwise free poses, first those that can go straight on furthest.
    fn furthest_travelling(&self, task: &NodeTask, cancel: &Cancel) -> Result<Vec<Candidate>, Cancelled> {
        let straight = task.placed(&task.from);
        if self.is_free(&straight, task.s, task.h_so_far, &mut 0) {
            return Ok(vec![self.valued_candidate(straight, task)]);
        }
        let one = |i: usize| {
            cancel.check()?;
            let (pose, lacking) = self.climb(start_of(self, task, i), task.s, task.h_so_far);
            let free = lacking.is_none() && self.is_free(&pose, task.s, task.h_so_far, &mut 0);
            Ok(free.then(|| (self.free_travel(&pose, task), self.valued_candidate(pose, task))))
        };
        sorted((0..SEEDS).into_par_iter().map(one).collect())
    }

    /// Free poses, those with the greatest least clearance first.
    fn greatest_clearance(&self, task: &NodeTask, cancel: &Cancel) -> Result<Vec<Candidate>, Cancelled> {
        /// Clearance beyond which more does not count (mm).
        const ROOM: f64 = 3.0;
        let wide = Demand { room: ROOM, ..self.demand };
        let one = |i: usize| {
            cancel.check()?;
            let at = (task.s, self.turned(task.h_so_far));
            let pose = self.model.ascend(start_of(self, task, i), at, &wide, self.free_axes(), ASCENT, cancel)?.pose;
            let free = self.is_free(&pose, task.s, task.h_so_far, &mut 0);
            let distance = || self.model.least_clearance(&pose, self.turned(task.h_so_far));
            Ok(free.then(|| (distance(), self.valued_candidate(pose, task))))
        };
        sorted((0..SEEDS).into_par_iter().map(one).collect())
    }

    /// Distance that the electrode can go on from `pose` along the main direction alone (mm), as far as that matters.
    fn free_travel(&self, pose: &Pose, task: &NodeTask) -> f64 {
        const STRIDE: f64 = 0.25;
        const MOST: usize = 200;
        let mut hint = 0;
        let ahead = |i: &usize| {
            let way = *i as f64 * STRIDE;
            let further = self.withdrawn(pose, task.s + way);
            self.is_free(&further, task.s + way, task.h_so_far, &mut hint)
        };
        (1..=MOST).take_while(ahead).count() as f64 * STRIDE
    }

    pub(super) fn valued_candidate(&self, pose: Pose, task: &NodeTask) -> Candidate {
        let objective = self.objective.value(&pose, task.h_so_far, &task.motion_to(&pose), &task.before);
        Candidate { pose, h: task.h_so_far, objective }
    }
}

/// The best first; of those equally good the one that was tried first.
fn sorted(found: Result<Vec<Option<(f64, Candidate)>>, Cancelled>) -> Result<Vec<Candidate>, Cancelled> {
    let mut found: Vec<(f64, Candidate)> = found?.into_iter().flatten().collect();
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    Ok(found.into_iter().map(|(_, candidate)| candidate).collect())
}

/// Start number `i` of a node: the pose before, the motion as before, or scattered about the pose before.
fn start_of(problem: &SearchProblem, task: &NodeTask, i: usize) -> Pose {
    let mut pose = task.from;
    if i == 1 {
        let ratio = task.duration / task.before.duration;
        let mut q = pose.to_array();
        q.iter_mut().zip(task.before.increments).for_each(|(value, rate)| *value += rate * ratio);
        pose = Pose::from_array(q);
    }
    if i > 1 {
        pose = problem.scattered(&pose, SPREADS[i % SPREADS.len()], i as f64 + task.s);
    }
    task.placed(&pose)
}
