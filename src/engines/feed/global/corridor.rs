//! Layers of poses, one for each node, and the widest way through them.

use rayon::prelude::*;

use super::ground::{Ground, Place};
use crate::clearance::Shortfall;
use crate::climb::mobility;
use crate::even::even;
use crate::pose::{Axis, Pose};
use crate::search::SearchProblem;
use task::{Cancel, Cancelled, Progress};

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
#[derive(Debug, Clone, Copy, PartialEq)]
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

impl Waypoint {
    /// The final pose, where there is `room` (mm).
    pub(super) fn first(room: f64) -> Self {
        Self { s: 0.0, pose: Pose::FINAL, width: room, length: 0.0, from: 0 }
    }

    /// The one at `place` that is reached from here, which is number `from` of its layer.
    pub(super) fn then(&self, place: &Place, from: usize, ground: &Ground) -> Self {
        let length = self.length + ground.motion_between(&self.pose, &place.pose);
        Self { s: place.s, pose: place.pose, width: self.width.min(place.room), length, from }
    }
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
    ground: &'a Ground<'a>,
    problem: &'a SearchProblem<'a>,
    effort: Effort,
    layers: Vec<Vec<Waypoint>>,
}

/// A pose that was tried for a node.
#[derive(Debug, Clone, Copy)]
struct Tried {
    place: Place,
    waypoint: Waypoint,
    reachable: bool,
}

impl<'a> Corridor<'a> {
    /// Least distance between nodes, as a share of the step, and the first one from the final pose, where space opens.
    const LEAST_STEP: f64 = 0.125;
    const FIRST_STEP: f64 = 0.5;
    /// How far poses are strewn about those expected (mm), by turns.
    const SPREADS: [f64; 3] = [0.4, 1.2, 3.0];
    /// Motion by which poses of one node differ at first; half as much until there are enough (mm).
    const APART: f64 = 1.6;
    const LEAST_APART: f64 = 0.05;

    pub(super) fn new(ground: &'a Ground<'a>, effort: Effort) -> Self {
        Self { ground, problem: ground.problem, effort, layers: vec![vec![Waypoint::first(ground.room)]] }
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
        let one = |&(parent, number): &(usize, usize)| {
            cancel.check()?;
            let place = self.ground.roomiest_near(self.seed(parent, number, each, s), s);
            let before = &parents[parent];
            let waypoint = before.then(&place, parent, self.ground);
            let joins = || self.ground.joins((before.s, &before.pose), (s, &place.pose));
            let reachable = self.ground.is_free(&place) && joins();
            Ok(Tried { place, waypoint, reachable })
        };
        seeds.par_iter().map(one).collect()
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

    /// The widest of the reachable poses, as different from each other as their number allows.
    fn chosen(&self, tried: &[Tried]) -> Vec<Waypoint> {
        let mut reachable: Vec<&Waypoint> = tried.iter().filter(|t| t.reachable).map(|t| &t.waypoint).collect();
        reachable.sort_by(|a, b| b.width.total_cmp(&a.width).then(a.length.total_cmp(&b.length)));
        let mut chosen: Vec<Waypoint> = Vec::new();
        let mut apart = Self::APART;
        while chosen.len() < self.poses(&reachable) && apart >= Self::LEAST_APART {
            for candidate in &reachable {
                let differs = |c: &Waypoint| self.ground.motion_between(&c.pose, &candidate.pose) >= apart;
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
        let nearest = tried.iter().min_by(|a, b| a.place.lack.total_cmp(&b.place.lack));
        let (pose, lack, worst) =
            nearest.map_or((Pose::FINAL, 0.0, None), |t| (t.place.pose, t.place.lack, t.place.worst));
        DeadEnd { way, s, pose, lack, worst }
    }
}
