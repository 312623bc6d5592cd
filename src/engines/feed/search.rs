//! The frame that every strategy works in: nodes along the main direction, one after the other from the final
//! pose outwards, halving the step where no free pose is found.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::angle_test::AngleTest;
use super::axis_curve::Joining;
use super::centreline::{CentrelineParams, CentrelineStep, Guide};
use super::clearance::{ClearanceModel, Shortfall};
use super::genetic::{GeneticParams, GeneticStep};
use super::global::GlobalParams;
use super::interpolation::AxisCurves;
use super::jam::{Jam, JamCause, JamContact};
use super::machine::{AxisSet, TravelLimits};
use super::objective::{Objective, ObjectiveValue, StepMotion};
use super::plan::Observe;
use super::pose::{Axis, Pose};
use super::probes::{Demand, Turns};
pub use super::strategy::Strategy;
use task::{Cancel, Cancelled, Progress};
use wheel::channel::Surface;
use wheel::electrode::EntrySide;

/// What a pose must meet to count as free during the search. The verifier has the last word either way.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Constraint {
    /// Signed distance to the finished surface of at least spark gap and margin at every sample.
    #[default]
    Distance,
    /// P0's comparison of the angles alpha and theta at the nearest wall point.
    Angle,
}

/// Everything that a strategy needs to know of one electrode in its channel.
#[derive(Clone, Copy)]
pub struct SearchProblem<'a> {
    /// The electrode's samples over the distance field.
    pub model: &'a ClearanceModel<'a>,
    /// The angle test, if that is the constraint.
    pub angle: Option<&'a AngleTest<'a>>,
    /// What is optimised.
    pub objective: &'a Objective<'a>,
    /// Axes of the machine.
    pub axes: AxisSet,
    /// How far they go.
    pub travel: TravelLimits,
    /// Full ranges of motion in one step, (7), in the order of [`Axis`]; 0 for axes that do not move.
    pub ranges: [f64; 6],
    /// Clearance wanted.
    pub demand: Demand,
    /// How far the walls are drawn in from those of the model's electrode, before any h that is searched for.
    pub turns: Turns,
    /// The side that the electrode is withdrawn to.
    pub side: EntrySide,
    /// How the nodes will be joined.
    pub joining: Joining,
    /// Distance between nodes (mm).
    pub step: f64,
    /// Stretches of withdrawn distance that are searched in finer steps, half for each stretch that holds it (mm).
    pub fine: &'a [[f64; 2]],
    /// How far out of the blisk the electrode is withdrawn (mm).
    pub exit_clearance: f64,
    /// The line that nodes follow in steps of arc length; without one they follow X.
    pub guide: Option<&'a Guide>,
    /// Is shown the nodes found so far after each of them.
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
    /// Its position on the X axis (mm).
    pub x: f64,
    /// Length of this step over the nominal one.
    pub duration: f64,
    /// The step before.
    pub before: StepMotion,
    /// Greatest h that a node has taken so far (rad).
    pub h_so_far: f64,
    /// How often the search has gone back: gives other random numbers.
    pub attempt: u64,
}

impl NodeTask {
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
    /// Its objective.
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
    /// Least clearance of the samples (mm), as the search sees it.
    pub clearance: f64,
    /// Objective values.
    pub objective: ObjectiveValue,
}

/// How the objective fell over the generations at one node.
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
    /// That of a node, withdrawn by `s` (mm), that was not searched over generations.
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

/// The answer of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchOutcome {
    /// Nodes from the final pose outwards.
    pub nodes: Vec<Node>,
    /// How each node's search converged.
    pub convergence: Vec<Convergence>,
    /// Where it jammed, if the electrode did not come out.
    pub jam: Option<Jam>,
}

impl SearchProblem<'_> {
    /// Times that a step is halved before the search gives up.
    const HALVINGS: i32 = 4;
    /// How often the search goes back from a place where hardly anything is missing.
    const ATTEMPTS: u64 = 6;
    /// What may be missing there (mm).
    const NEARLY: f64 = 0.05;
    /// Nodes that it goes back the first time, twice as many the second, and so on.
    const BACK: usize = 2;
    /// Share of the allowance that nodes must keep where there is no room for all of it.
    const NARROW: f64 = 0.3;
    /// Most times that it is halved from the start where the verifier asked for finer steps.
    const FINEST: usize = 3;
    /// Least and greatest number of parts of an interval between two nodes, at whose joints the motion is tested.
    const PARTS: [f64; 2] = [5.0, 40.0];
    /// How far the electrode's points may move from one such joint to the next (mm).
    const STRIDE: f64 = 0.2;
    /// Nodes before the next one that the curve is drawn through: a spline forgets what is further away.
    const CURVE_NODES: usize = 6;
    /// Intervals that are tested, the last ones.
    const CURVE_INTERVALS: usize = 2;

    /// The machine's axes except X.
    pub fn free_axes(&self) -> &[Axis] {
        &self.axes.axes()[1..]
    }

    /// Direction of withdrawal along X.
    pub fn direction(&self) -> f64 {
        self.side.sign()
    }

    /// Whether the constraint holds at `pose`, withdrawn by `s`, within the machine's travel.
    pub fn is_free(&self, pose: &Pose, s: f64, h: f64, hint: &mut usize) -> bool {
        self.keeps(pose, s, h, &self.demand, hint)
    }

    /// The same with another demand.
    pub(super) fn keeps(&self, pose: &Pose, s: f64, h: f64, demand: &Demand, hint: &mut usize) -> bool {
        if self.travel.beyond(pose).is_some() {
            return false;
        }
        match self.angle {
            None => self.model.is_free(pose, s, self.turned(h), demand, hint),
            Some(test) => test.is_free(self.model, pose, self.turned(h)),
        }
    }

    /// See [`ClearanceModel::climb`].
    pub fn climb(&self, pose: Pose, s: f64, h: f64) -> (Pose, Option<Shortfall>) {
        self.model.climb(pose, s, self.turned(h), &self.demand, self.free_axes())
    }

    /// How far the walls are drawn in with an additional reduction h (rad).
    pub(super) fn turned(&self, h: f64) -> Turns {
        Turns(self.turns.0.map(|turn| turn + h))
    }

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

    /// Where the motion from one node to the next is tested, as shares of it.
    pub(super) fn joints(&self, from: &Node, to: &Node) -> impl Iterator<Item = f64> + use<> {
        let strides = self.model.motion_between(&from.pose, &to.pose) / Self::STRIDE;
        let parts = strides.ceil().clamp(Self::PARTS[0], Self::PARTS[1]);
        (1..parts as usize).map(move |i| i as f64 / parts)
    }

    /// What nodes are asked for where there is no room for all of the allowance.
    pub(super) fn narrow(&self) -> Demand {
        Demand { guard: Self::NARROW * self.demand.guard, ..self.demand }
    }

    /// How far the electrode is out of the blisk at `pose`: negative while some point is not beyond the metal (mm).
    pub fn way_out(&self, pose: &Pose) -> f64 {
        self.model.outside().way_out(pose, self.side)
    }

    /// Free candidates for `task`, best first, and how they were come by.
    fn candidates(
        &self,
        strategy: &StrategyParams,
        task: &NodeTask,
        cancel: &Cancel,
    ) -> Result<(Vec<Candidate>, Convergence), Cancelled> {
        match strategy {
            StrategyParams::Genetic(params) => GeneticStep::new(params, self, task).run(cancel),
            StrategyParams::FreeTravel => Ok((self.furthest_travelling(task, cancel)?, Convergence::none(task.s))),
            StrategyParams::MaxMinDistance => Ok((self.roomiest(task, cancel)?, Convergence::none(task.s))),
            // It does not search node by node.
            StrategyParams::Global(_) => Ok((Vec::new(), Convergence::none(task.s))),
            StrategyParams::Centreline(params) => match self.guide {
                Some(guide) => CentrelineStep::new(params, self, guide, task).run(cancel),
                None => Ok((Vec::new(), Convergence::none(task.s))),
            },
        }
    }

    /// Searches on from `kept` nodes (at least the final pose) until the electrode is out of the blisk or jams.
    pub fn search(
        &self,
        strategy: &StrategyParams,
        kept: &[Node],
        surface_of: &dyn Fn(DVec3) -> Surface,
        progress: &Progress,
        cancel: &Cancel,
    ) -> Result<SearchOutcome, Cancelled> {
        if let StrategyParams::Global(params) = strategy {
            return self.widest_way(params, kept, surface_of, progress, cancel);
        }
        let mut nodes = kept.to_vec();
        if nodes.is_empty() {
            nodes.push(self.final_node());
        }
        let mut convergence: Vec<Convergence> = Vec::new();
        let least = nodes.len();
        let way = self.exit_clearance - self.way_out(&Pose::FINAL);
        // An electrode that is not out after twice the way plus its length never will be.
        let limit = 2.0 * way + 50.0;
        let mut furthest: Option<SearchOutcome> = None;
        let mut attempt = 0;
        loop {
            let last = nodes[nodes.len() - 1];
            if self.way_out(&last.pose) >= self.exit_clearance && nodes.len() > 1 {
                return Ok(SearchOutcome { nodes, convergence, jam: None });
            }
            progress.report("search", last.s / way.max(1e-9), &format!("node {}", nodes.len() - 1));
            (self.observe)(&nodes, &convergence);
            match self.next_node(strategy, &nodes, attempt, cancel)? {
                Some((node, trace)) if node.s <= limit => {
                    nodes.push(node);
                    convergence.push(trace);
                    continue;
                }
                _ => {}
            }
            let jam = self.jam(&nodes, surface_of);
            let here = SearchOutcome { nodes: nodes.clone(), convergence: convergence.clone(), jam: Some(jam) };
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

    pub(super) fn final_node(&self) -> Node {
        let clearance = self.model.least_clearance(&Pose::FINAL, self.turns);
        Node { s: 0.0, pose: Pose::FINAL, h: 0.0, clearance, objective: ObjectiveValue::default() }
    }

    fn task(&self, nodes: &[Node], duration: f64) -> NodeTask {
        let last = &nodes[nodes.len() - 1];
        let before = match nodes {
            [.., a, b] => StepMotion::between(&a.pose, &b.pose, (b.s - a.s) / self.step),
            // Nothing has moved yet but X, whose rate is the nominal one.
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
            x: self.direction() * s,
            duration,
            before,
            h_so_far: nodes.iter().map(|n| n.h).fold(0.0, f64::max),
            attempt: 0,
        }
    }

    fn next_node(
        &self,
        strategy: &StrategyParams,
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
                let (candidates, trace) = problem.candidates(strategy, &task, cancel)?;
                if let Some(chosen) = candidates.iter().find(|c| problem.motion_is_free(nodes, &task, c)) {
                    return Ok(Some((problem.node(&task, chosen), trace)));
                }
            }
        }
        Ok(None)
    }

    /// How often the step is halved at first: so that it is at most twice the last one, and as often as the
    /// verifier asked for here.
    fn first_halving(&self, nodes: &[Node]) -> i32 {
        let [.., before, last] = nodes else { return 0 };
        let fine = self.fine.iter().filter(|[from, to]| (*from..*to).contains(&last.s)).count();
        // A line that bends makes equal steps along it a little unequal along X.
        let whole = self.guide.map_or(self.step, |guide| 0.9 * (guide.next_s(last.s, self.step) - last.s));
        let narrow = (whole / (2.0 * (last.s - before.s))).log2().ceil().max(0.0) as i32;
        narrow.max(fine.min(Self::FINEST) as i32).min(Self::HALVINGS)
    }

    /// Once the electrode's walls have left the blades there is nothing left to keep to the middle of: its axes run
    /// down to rest, each step a share of the one before, as long as that is free with room to spare.
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
        for (value, rate) in q.iter_mut().zip(rates).skip(1) {
            *value += rate * ratio;
        }
        q[0] = task.x;
        let pose = Pose::from_array(q);
        let objective = self.objective.value(&pose, task.h_so_far, &task.motion_to(&pose), &task.before);
        let candidate = Candidate { pose, h: task.h_so_far, objective };
        let node = self.node(&task, &candidate);
        let roomy = node.clearance >= ROOM * (self.demand.spark_gap + self.demand.margin);
        let free = roomy
            && self.is_free(&pose, task.s, task.h_so_far, &mut 0)
            && self.motion_is_free(nodes, &task, &candidate);
        free.then(|| (node, Convergence::none(task.s)))
    }

    fn node(&self, task: &NodeTask, chosen: &Candidate) -> Node {
        let clearance = self.model.least_clearance(&chosen.pose, self.turned(chosen.h));
        Node { s: task.s, pose: chosen.pose, h: chosen.h, clearance, objective: chosen.objective }
    }

    /// What stops the electrode: the end of X's travel, or the place where the pose that comes nearest to being free,
    /// climbing from the expected one, still lacks room. The worst place counts even if the climb succeeds, which it
    /// may when only the motion to it is blocked.
    fn jam(&self, nodes: &[Node], surface_of: &dyn Fn(DVec3) -> Surface) -> Jam {
        let task = self.task(nodes, 1.0);
        let ratio = task.duration / task.before.duration;
        let mut expected = task.from.to_array();
        for (value, rate) in expected.iter_mut().zip(task.before.increments) {
            *value += rate * ratio;
        }
        expected[0] = task.x;
        let starts = [Pose::from_array(expected), Pose { x: task.x, ..task.from }];
        let jam = |pose, cause| Jam { node: nodes.len(), s: task.s, pose, cause, opening: None };
        // The other axes are free to stay where they are; X has to go on.
        if let Some((axis, limit)) = self.travel.beyond(&Pose { x: task.x, ..Pose::FINAL }) {
            return jam(starts[1], JamCause::Travel { axis, value: task.x, limit });
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

/// A strategy with its parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StrategyParams {
    /// See [`Strategy::Genetic`].
    Genetic(GeneticParams),
    /// See [`Strategy::Global`].
    Global(GlobalParams),
    /// See [`Strategy::FreeTravel`].
    FreeTravel,
    /// See [`Strategy::MaxMinDistance`].
    MaxMinDistance,
    /// See [`Strategy::Centreline`].
    Centreline(CentrelineParams),
}
