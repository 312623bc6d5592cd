//! The search that strategies share: nodes along the main direction, one after the other from the final pose outwards,
//! halving the step where no free pose is found.

use glam::DVec3;

use super::clearance::Shortfall;
use super::interpolation::AxisCurves;
use super::jam::{Jam, JamCause, JamContact};
use super::pose::Pose;
use super::problem::{Candidate, Convergence, Node, NodeTask, SearchOutcome, SearchProblem};
use super::strategy::SearchStrategy;
use task::{Cancel, Cancelled, Task};
use wheel::channel::Surface;

impl SearchProblem<'_> {
    /// Times that a step is halved before the search gives up.
    const HALVINGS: i32 = 4;
    /// Number of times that the search goes back from a jam with hardly any clearance missing.
    const ATTEMPTS: u64 = 6;
    /// Clearance that may be missing at such a place (mm).
    const NEARLY: f64 = 0.05;
    /// Nodes taken back the first time; twice as many the second time, and so on.
    const BACK: usize = 2;
    /// Most halvings of the first step where the verifier asked for finer steps.
    const FINEST: usize = 3;
    /// Nodes before the next one that the curve is drawn through: a spline hardly depends on nodes further away.
    const CURVE_NODES: usize = 6;
    /// Number of intervals tested, the last ones.
    const CURVE_INTERVALS: usize = 2;

    /// Whether the motion from `nodes` to the next one is free along the curve that will join them: the spline through
    /// the last few nodes and this one, over the intervals that it changes much.
    fn motion_is_free(&self, nodes: &[Node], task: &NodeTask, to: &Candidate) -> bool {
        let known = &nodes[nodes.len().saturating_sub(Self::CURVE_NODES)..];
        let next = Node { s: task.s, pose: to.pose, ..nodes[nodes.len() - 1] };
        let joined = [known, &[next]].concat();
        // Knots rise by construction; were they not to, nothing could be said of the motion.
        let Ok(curves) = AxisCurves::through(&joined, self.joining) else { return false };
        let h = to.h.max(task.h_so_far);
        let between = self.between();
        let mut hint = 0;
        joined.windows(2).rev().take(Self::CURVE_INTERVALS).all(|w| {
            self.joints(&w[0], &w[1]).all(|t| {
                let s = w[0].s + (w[1].s - w[0].s) * t;
                self.keeps(&curves.pose(s), s, h, &between, &mut hint)
            })
        })
    }

    /// Searches on from `kept` nodes (at least the final pose) until the electrode is out of the blisk or jams.
    pub fn search(
        &self,
        strategy: &dyn SearchStrategy,
        kept: &[Node],
        surface_of: &dyn Fn(DVec3) -> Surface,
        task: &Task,
    ) -> Result<SearchOutcome, Cancelled> {
        if strategy.is_whole() {
            return strategy.whole_path(self, kept, surface_of, task);
        }
        let mut nodes = kept.to_vec();
        if nodes.is_empty() {
            nodes.push(self.final_node());
        }
        let mut convergence: Vec<Convergence> = Vec::new();
        let least = nodes.len();
        let way = self.exit_clearance - self.distance_outside(&Pose::FINAL);
        // An electrode that is not out after twice the way plus its length never will be.
        let limit = 2.0 * way + 50.0;
        let mut furthest: Option<SearchOutcome> = None;
        let mut attempt = 0;
        loop {
            let last = nodes[nodes.len() - 1];
            if self.distance_outside(&last.pose) >= self.exit_clearance && nodes.len() > 1 {
                return Ok(SearchOutcome { nodes, convergence, jam: None });
            }
            task.report("search", last.s / way.max(1e-9), &format!("node {}", nodes.len() - 1));
            (self.observe)(&nodes, &convergence);
            match self.next_node(strategy, &nodes, attempt, &task.cancel)? {
                Some((node, trace)) if node.s <= limit => {
                    nodes.push(node);
                    convergence.push(trace);
                    continue;
                }
                _ => {}
            }
            let jam = self.jam(&nodes, surface_of);
            let here = SearchOutcome { nodes: nodes.clone(), convergence: convergence.clone(), jam: Some(jam.clone()) };
            let further = furthest.as_ref().and_then(|f| f.nodes.last()).is_none_or(|f| f.s < last.s);
            if further {
                furthest = Some(here.clone());
            }
            attempt += 1;
            if attempt > Self::ATTEMPTS || !jam.is_near(Self::NEARLY) {
                return Ok(furthest.unwrap_or(here));
            }
            // Back a little, further each time, and on with other random numbers.
            let back = (Self::BACK * attempt as usize).min(nodes.len() - least);
            nodes.truncate(nodes.len() - back);
            convergence.truncate(convergence.len() - back);
        }
    }

    fn next_node(
        &self,
        strategy: &dyn SearchStrategy,
        nodes: &[Node],
        attempt: u64,
        cancel: &Cancel,
    ) -> Result<Option<(Node, Convergence)>, Cancelled> {
        if let Some(coasting) = self.coast(nodes) {
            return Ok(Some(coasting));
        }
        // Where the way is too narrow for the allowance, it is given up before the search is.
        let narrow = SearchProblem { demand: self.narrow(), ..*self };
        let first = self.first_halving(nodes);
        for (problem, first) in [(self, first), (&narrow, first.max(1))] {
            for halving in first..=Self::HALVINGS {
                let task = NodeTask { attempt, ..problem.task(nodes, 0.5f64.powi(halving)) };
                let (candidates, trace) = strategy.candidates(problem, &task, cancel)?;
                if let Some(chosen) = candidates.iter().find(|c| problem.motion_is_free(nodes, &task, c)) {
                    return Ok(Some((problem.node(&task, chosen), trace)));
                }
            }
        }
        Ok(None)
    }

    /// Number of halvings to begin with, so that the step is at most twice the last one, and as many as the verifier
    /// asked for here.
    fn first_halving(&self, nodes: &[Node]) -> i32 {
        let [.., before, last] = nodes else { return 0 };
        let fine = self.fine.iter().filter(|[from, to]| (*from..*to).contains(&last.s)).count();
        // A line that bends makes equal steps along it a little unequal along the axis of withdrawal.
        let whole = self.guide.map_or(self.step, |guide| 0.9 * (guide.next_s(last.s, self.step) - last.s));
        let narrow = (whole / (2.0 * (last.s - before.s))).log2().ceil().max(0.0) as i32;
        narrow.max(fine.min(Self::FINEST) as i32).min(Self::HALVINGS)
    }

    /// Node of an electrode whose walls have left the blades: its axes run down to rest, each step a share of the one
    /// before, where that is free with clearance to spare.
    fn coast(&self, nodes: &[Node]) -> Option<(Node, Convergence)> {
        const SHARE: f64 = 0.75;
        const ROOM: f64 = 3.0;
        let task = self.task(nodes, 1.0);
        if nodes.len() < 3 || self.objective.is_between_blades(&task.from) {
            return None;
        }
        let rates = task.before.increments;
        let ratio = SHARE.powf(task.before.duration) * task.duration / task.before.duration;
        let mut q = task.from.to_array();
        for (value, rate) in q.iter_mut().zip(rates) {
            *value += rate * ratio;
        }
        let pose = task.placed(&Pose::from_array(q));
        let objective = self.objective.value(&pose, task.h_so_far, &task.motion_to(&pose), &task.before);
        let candidate = Candidate { pose, h: task.h_so_far, objective };
        let node = self.node(&task, &candidate);
        let roomy = node.clearance >= ROOM * (self.demand.spark_gap + self.demand.margin);
        let free = roomy
            && self.is_free(&pose, task.s, task.h_so_far, &mut 0)
            && self.motion_is_free(nodes, &task, &candidate);
        free.then(|| (node, Convergence::none(task.s)))
    }

    /// Cause of the jam: the end of travel along the withdrawal, or the point with the greatest lack of clearance at the pose nearest to
    /// being free, reached by climbing from the expected pose. The worst point counts even if the climb succeeds, since
    /// only the motion to that pose may be blocked.
    fn jam(&self, nodes: &[Node], surface_of: &dyn Fn(DVec3) -> Surface) -> Jam {
        let task = self.task(nodes, 1.0);
        let ratio = task.duration / task.before.duration;
        let mut expected = task.from.to_array();
        for (value, rate) in expected.iter_mut().zip(task.before.increments) {
            *value += rate * ratio;
        }
        let starts = [Pose::from_array(expected), task.from].map(|pose| task.placed(&pose));
        let jam = |pose, cause| Jam { node: nodes.len(), s: task.s, pose, cause, opening: None };
        // The other axes are free to stay where they are; the axis of withdrawal has to go on.
        if let Some((axis, limit)) = self.travel.beyond(&task.placed(&Pose::FINAL)) {
            return jam(starts[1], JamCause::Travel { axis, value: task.advance.1, limit });
        }
        let climbed = starts.into_iter().filter_map(|start| {
            let (pose, short) = self.climb(start, task.s, task.h_so_far);
            short.map(|short| (pose, short))
        });
        let nearest = climbed.min_by(|a, b| a.1.lack.total_cmp(&b.1.lack)).or_else(|| {
            Some((starts[1], self.model.tightest(&starts[1], self.turned(task.h_so_far), self.demand.wanted())?))
        });
        let Some((pose, Shortfall { on_electrode, on_blisk, lack, .. })) = nearest else {
            return jam(starts[1], JamCause::Unknown);
        };
        let surface = surface_of(on_blisk);
        jam(pose, JamCause::Contact(JamContact { on_electrode, on_blisk, surface, lack }))
    }
}
