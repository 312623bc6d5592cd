//! Layers of poses, one for each node, and the widest way through them.

use rayon::prelude::*;

use crate::feed::clearance::{ClearanceModel, Shortfall};
use crate::feed::climb::{Ascent, mobility};
use crate::feed::even::even;
use crate::feed::pose::{Axis, Pose};
use crate::feed::probes::Demand;
use crate::feed::search::SearchProblem;
use crate::progress::{Cancel, Cancelled, Progress};

/// How many poses are tried.
#[derive(Debug, Clone, Copy)]
pub struct Effort {
    /// Poses kept for each node.
    pub poses: usize,
    /// Poses tried for each node.
    pub seeds: usize,
    /// Distance between nodes (mm).
    pub step: f64,
}

/// A pose on a way.
#[derive(Debug, Clone, Copy)]
pub struct Waypoint {
    /// Withdrawn distance (mm).
    pub s: f64,
    /// The pose.
    pub pose: Pose,
    /// Least room beyond what is asked for on the widest way from the final pose to here (mm).
    pub width: f64,
    /// Motion of the electrode's points on that way (mm).
    length: f64,
    /// The waypoint before, in the layer before.
    from: usize,
}

/// Waypoints from the final pose outwards.
pub type Way = Vec<Waypoint>;

/// Where all ways end.
#[derive(Debug, Clone)]
pub struct DeadEnd {
    /// The widest of the ways that come so far.
    pub way: Way,
    /// Withdrawn distance that none reaches (mm).
    pub s: f64,
    /// The pose there that comes nearest to being free.
    pub pose: Pose,
    /// Clearance that it lacks (mm); 0 if only the motion to it is blocked.
    pub lack: f64,
    /// What it meets, if anything.
    pub worst: Option<Shortfall>,
}

/// The layers so far.
pub(super) struct Corridor<'a> {
    problem: &'a SearchProblem<'a>,
    /// Some of the problem's probes, which lead the search.
    coarse: &'a ClearanceModel<'a>,
    room: f64,
    effort: Effort,
    layers: Vec<Vec<Waypoint>>,
}

/// A pose that was tried for a node.
#[derive(Debug, Clone, Copy)]
struct Tried {
    waypoint: Waypoint,
    /// Clearance that it lacks (mm).
    lack: f64,
    worst: Option<Shortfall>,
    reachable: bool,
}

impl<'a> Corridor<'a> {
    /// Least distance between nodes, as a share of the step, and the first one from the final pose, where space opens.
    const LEAST_STEP: f64 = 0.125;
    const FIRST_STEP: f64 = 0.5;
    /// Distance withdrawn at which all the room that counts may have opened (mm).
    const OPEN: f64 = 4.0;
    /// Steps of ascent for each pose.
    const ASCENT: usize = 12;
    /// Steps that all probes take part in, where some of them did not tell enough.
    const TOUCH: usize = 4;
    /// Clearance that may be missing by the leading probes for the others to be asked (mm).
    const HOPELESS: f64 = 0.05;
    /// How far poses are strewn about those expected (mm), by turns.
    const SPREADS: [f64; 3] = [0.4, 1.2, 3.0];
    /// Motion between the places where a way is tested (mm).
    const STRIDE: f64 = 0.25;
    /// Motion by which poses of one node differ at first; half as much until there are enough (mm).
    const APART: f64 = 1.6;
    const LEAST_APART: f64 = 0.05;

    pub(super) fn new(
        problem: &'a SearchProblem<'a>,
        coarse: &'a ClearanceModel<'a>,
        room: f64,
        effort: Effort,
    ) -> Self {
        let start = Waypoint { s: 0.0, pose: Pose::FINAL, width: room, length: 0.0, from: 0 };
        Self { problem, coarse, room, effort, layers: vec![vec![start]] }
    }

    /// Adds layers until the electrode is out, and answers the widest way; or the dead end.
    pub(super) fn explore(mut self, progress: &Progress, cancel: &Cancel) -> Result<Result<Way, DeadEnd>, Cancelled> {
        let exit = self.problem.exit_clearance;
        let way = exit - self.problem.way_out(&Pose::FINAL);
        let limit = 2.0 * way + 50.0;
        let mut step = Self::FIRST_STEP * self.effort.step;
        loop {
            let last = self.layers.len() - 1;
            let s = self.layers[last][0].s;
            if last > 0 && self.layers[last].iter().any(|w| self.problem.way_out(&w.pose) >= exit) {
                return Ok(Ok(self.widest(|w| self.problem.way_out(&w.pose) >= exit)));
            }
            progress.report(
                "search",
                s / way.max(1e-9),
                &format!("{} mm, {} poses", s.round(), self.layers[last].len()),
            );
            let tried = self.tried(s + step, cancel)?;
            let layer = self.chosen(&tried);
            if !layer.is_empty() && s + step <= limit {
                self.layers.push(layer);
                step = (2.0 * step).min(self.effort.step);
                continue;
            }
            step *= 0.5;
            if step < Self::LEAST_STEP * self.effort.step || s > limit {
                return Ok(Err(self.dead_end(s + 2.0 * step, &tried)));
            }
        }
    }

    /// Poses tried at `s`, each moved to where there is most room about it.
    fn tried(&self, s: f64, cancel: &Cancel) -> Result<Vec<Tried>, Cancelled> {
        let parents = &self.layers[self.layers.len() - 1];
        let each = self.effort.seeds.div_ceil(parents.len()).max(2);
        let seeds: Vec<(usize, usize)> = (0..parents.len()).flat_map(|p| (0..each).map(move |i| (p, i))).collect();
        // Near the final pose there cannot be much room: it is taken in proportion to what space may have opened.
        let opened = (s / Self::OPEN).min(1.0);
        let wide = self.room * opened;
        let demand = Demand { room: wide, ..self.problem.narrow() };
        let one = |&(parent, number): &(usize, usize)| {
            cancel.check()?;
            let ascent = self.ascended(self.seed(parent, number, each, s), s, &demand);
            let before = &parents[parent];
            let room = (wide - ascent.lack) / opened;
            let length = before.length + self.coarse.motion_between(&before.pose, &ascent.pose);
            let waypoint = Waypoint { s, pose: ascent.pose, width: before.width.min(room), length, from: parent };
            let lack = (ascent.lack - wide).max(0.0);
            let within = lack == 0.0 && self.problem.travel.beyond(&ascent.pose).is_none();
            let reachable = within && self.joins(before, &waypoint);
            Ok(Tried { waypoint, lack, worst: ascent.worst, reachable })
        };
        seeds.par_iter().map(one).collect()
    }

    /// The place with most room near `start`: found by some of the probes and judged by all.
    fn ascended(&self, start: Pose, s: f64, demand: &Demand) -> Ascent {
        let (at, axes) = ((s, self.problem.turns), self.problem.free_axes());
        let led = self.coarse.ascend(start, at, demand, axes, Self::ASCENT);
        if led.lack > demand.room + Self::HOPELESS {
            return led;
        }
        let judged = self.problem.model.ascend(led.pose, at, demand, axes, 0);
        if judged.lack > demand.room {
            return self.problem.model.ascend(led.pose, at, demand, axes, Self::TOUCH);
        }
        judged
    }

    /// Where the search for a place begins: going on as before, staying, and strewn about the former.
    fn seed(&self, parent: usize, number: usize, each: usize, s: f64) -> Pose {
        let layer = &self.layers[self.layers.len() - 1];
        let here = &layer[parent];
        let mut q = here.pose.to_array();
        let x = self.problem.direction() * s;
        if number != 1 && self.layers.len() > 1 {
            let before = &self.layers[self.layers.len() - 2][here.from];
            let ratio = (s - here.s) / (here.s - before.s);
            let b = before.pose.to_array();
            for (value, b) in q.iter_mut().zip(b) {
                *value += ratio * (*value - b);
            }
        }
        if number > 1 {
            let spread = Self::SPREADS[number % Self::SPREADS.len()];
            let n = (parent * each + number) as f64 + 0.618 * self.layers.len() as f64;
            for (k, &axis) in self.problem.free_axes().iter().enumerate() {
                q[axis as usize] += spread * mobility(axis) * (2.0 * even(n, k) - 1.0);
            }
        }
        q[Axis::X as usize] = x;
        Pose::from_array(q)
    }

    /// Whether the straight motion between two waypoints is free.
    fn joins(&self, from: &Waypoint, to: &Waypoint) -> bool {
        let strides = self.coarse.motion_between(&from.pose, &to.pose) / Self::STRIDE;
        let parts = strides.ceil().clamp(2.0, 24.0) as usize;
        let between = self.problem.between();
        let mut hint = 0;
        (1..parts).all(|i| {
            let t = i as f64 / parts as f64;
            let s = from.s + (to.s - from.s) * t;
            self.coarse.is_free(&from.pose.lerp(&to.pose, t), s, self.problem.turns, &between, &mut hint)
        })
    }

    /// The widest of the reachable poses, as different from each other as their number allows.
    fn chosen(&self, tried: &[Tried]) -> Vec<Waypoint> {
        let mut reachable: Vec<&Waypoint> = tried.iter().filter(|t| t.reachable).map(|t| &t.waypoint).collect();
        reachable.sort_by(|a, b| b.width.total_cmp(&a.width).then(a.length.total_cmp(&b.length)));
        let mut chosen: Vec<Waypoint> = Vec::new();
        let mut apart = Self::APART;
        while chosen.len() < self.poses(&reachable) && apart >= Self::LEAST_APART {
            for candidate in &reachable {
                let differs = |c: &Waypoint| self.coarse.motion_between(&c.pose, &candidate.pose) >= apart;
                if chosen.len() < self.effort.poses && chosen.iter().all(differs) {
                    chosen.push(**candidate);
                }
            }
            apart *= 0.5;
        }
        chosen
    }

    /// How many poses are worth keeping: few, once there is all the room that counts outside the blades.
    fn poses(&self, reachable: &[&Waypoint]) -> usize {
        const OUTSIDE: usize = 2;
        let outside = reachable.first().is_some_and(|w| !self.problem.objective.is_between_blades(&w.pose));
        if outside { OUTSIDE.min(self.effort.poses) } else { self.effort.poses.min(reachable.len()) }
    }

    /// The widest way to the last layer's waypoints that `ends` allows; the shortest of those equally wide.
    fn widest(&self, ends: impl Fn(&Waypoint) -> bool) -> Way {
        let last = &self.layers[self.layers.len() - 1];
        let better = |a: &&Waypoint, b: &&Waypoint| a.width.total_cmp(&b.width).then(b.length.total_cmp(&a.length));
        let Some(mut at) = last.iter().filter(|w| ends(w)).max_by(better) else { return self.layers[0].clone() };
        let mut way = vec![*at];
        for layer in self.layers[..self.layers.len() - 1].iter().rev() {
            at = &layer[at.from];
            way.push(*at);
        }
        way.reverse();
        way
    }

    fn dead_end(&self, s: f64, tried: &[Tried]) -> DeadEnd {
        let way = self.widest(|_| true);
        let nearest = tried.iter().min_by(|a, b| a.lack.total_cmp(&b.lack));
        let (pose, lack, worst) = nearest.map_or((Pose::FINAL, 0.0, None), |t| (t.waypoint.pose, t.lack, t.worst));
        DeadEnd { way, s, pose, lack, worst }
    }
}
