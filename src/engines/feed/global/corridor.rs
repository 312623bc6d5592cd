//! Layers of poses, one for each node, the path with the greatest clearance margin through them, and warm starts from
//! known paths.

use rayon::prelude::*;

use super::free_space::{Configuration, FreeSpace};
use crate::clearance::Shortfall;
use crate::pose::Pose;
use crate::problem::SearchProblem;
use task::{Cancel, Cancelled, Task};

/// Numbers of poses and distance of nodes of a search.
#[derive(Debug, Clone, Copy)]
pub struct Effort {
    /// Poses kept for each node.
    pub poses: usize,
    /// Poses tried for each node.
    pub seeds: usize,
    /// Distance between nodes (mm).
    pub step: f64,
}

/// A pose on a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Waypoint {
    /// Withdrawn distance (mm).
    pub s: f64,
    /// The pose.
    pub pose: Pose,
    /// Clearance margin: least clearance beyond the demand on the widest path from the final pose to here (mm).
    pub margin: f64,
    /// Motion of the electrode's points on that path (mm).
    length: f64,
    /// The waypoint before, in the layer before.
    from: usize,
}

impl Waypoint {
    /// Waypoint at the final pose, with the clearance margin `room` (mm).
    pub(super) fn first(room: f64) -> Self {
        Self { s: 0.0, pose: Pose::FINAL, margin: room, length: 0.0, from: 0 }
    }

    /// Waypoint at `configuration`, reached from here; `from` is the number of this waypoint in its layer.
    pub(super) fn then(&self, configuration: &Configuration, from: usize, space: &FreeSpace) -> Self {
        let length = self.length + space.motion_between(&self.pose, &configuration.pose);
        Self { s: configuration.s, pose: configuration.pose, margin: self.margin.min(configuration.room), length, from }
    }
}

/// Waypoints from the final pose outwards.
pub type ExtractionPath = Vec<Waypoint>;

/// Dead end: the node that no path reaches.
#[derive(Debug, Clone)]
pub struct DeadEnd {
    /// The widest of the paths that come so far.
    pub path: ExtractionPath,
    /// Withdrawn distance that none reaches (mm).
    pub s: f64,
    /// The pose there that comes nearest to being free.
    pub pose: Pose,
    /// Clearance that it lacks (mm); 0 if only the motion to it is blocked.
    pub lack: f64,
    /// Worst lack of clearance at that pose, if any.
    pub worst: Option<Shortfall>,
}

/// Layered search: the waypoints kept for each node so far.
pub(super) struct Corridor<'a> {
    space: &'a FreeSpace<'a>,
    problem: &'a SearchProblem<'a>,
    effort: Effort,
    layers: Vec<Vec<Waypoint>>,
}

/// A pose that was tried for a node.
#[derive(Debug, Clone, Copy)]
struct Tried {
    configuration: Configuration,
    waypoint: Waypoint,
    reachable: bool,
}

impl<'a> Corridor<'a> {
    /// Least distance between nodes, as a share of the step, and the first one from the final pose, where space opens.
    const LEAST_STEP: f64 = 0.125;
    const FIRST_STEP: f64 = 0.5;
    /// Spread of poses about those expected (mm), by turns.
    const SPREADS: [f64; 3] = [0.4, 1.2, 3.0];
    /// Motion by which poses of one node differ at first; half as much until there are enough (mm).
    const APART: f64 = 1.6;
    const LEAST_APART: f64 = 0.05;

    pub(super) fn new(space: &'a FreeSpace<'a>, effort: Effort) -> Self {
        Self { space, problem: space.problem, effort, layers: vec![vec![Waypoint::first(space.room)]] }
    }

    /// Adds layers until the electrode is out; returns the path with the greatest clearance margin, or the dead end.
    pub(super) fn explore(mut self, task: &Task) -> Result<Result<ExtractionPath, DeadEnd>, Cancelled> {
        let exit = self.problem.exit_clearance;
        let distance = exit - self.problem.distance_outside(&Pose::FINAL);
        let limit = 2.0 * distance + 50.0;
        let mut step = Self::FIRST_STEP * self.effort.step;
        loop {
            let last = self.layers.len() - 1;
            let s = self.layers[last][0].s;
            if last > 0 && self.layers[last].iter().any(|w| self.problem.distance_outside(&w.pose) >= exit) {
                return Ok(Ok(self.widest(|w| self.problem.distance_outside(&w.pose) >= exit)));
            }
            task.report(
                "search",
                s / distance.max(1e-9),
                &format!("{} mm, {} poses", s.round(), self.layers[last].len()),
            );
            let tried = self.tried(s + step, &task.cancel)?;
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

    /// Poses tried at `s`, each moved to where its clearance margin is greatest.
    fn tried(&self, s: f64, cancel: &Cancel) -> Result<Vec<Tried>, Cancelled> {
        let parents = &self.layers[self.layers.len() - 1];
        let each = self.effort.seeds.div_ceil(parents.len()).max(2);
        let seeds: Vec<(usize, usize)> = (0..parents.len()).flat_map(|p| (0..each).map(move |i| (p, i))).collect();
        let one = |&(parent, number): &(usize, usize)| {
            cancel.check()?;
            let configuration = self.space.widest_near(self.seed(parent, number, each, s), s, cancel)?;
            let before = &parents[parent];
            let waypoint = before.then(&configuration, parent, self.space);
            let joins = || self.space.joins((before.s, &before.pose), (s, &configuration.pose));
            let reachable = self.space.is_free(&configuration) && joins();
            Ok(Tried { configuration, waypoint, reachable })
        };
        seeds.par_iter().map(one).collect()
    }

    /// Start of the search for a configuration: motion as before, no motion, or scattered about the former.
    fn seed(&self, parent: usize, number: usize, each: usize, s: f64) -> Pose {
        let layer = &self.layers[self.layers.len() - 1];
        let here = &layer[parent];
        let mut q = here.pose.to_array();
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
            return self.problem.withdrawn(&self.problem.scattered(&Pose::from_array(q), spread, n), s);
        }
        self.problem.withdrawn(&Pose::from_array(q), s)
    }

    /// The widest of the reachable poses, as different from each other as their number allows.
    fn chosen(&self, tried: &[Tried]) -> Vec<Waypoint> {
        let mut reachable: Vec<&Waypoint> = tried.iter().filter(|t| t.reachable).map(|t| &t.waypoint).collect();
        reachable.sort_by(|a, b| b.margin.total_cmp(&a.margin).then(a.length.total_cmp(&b.length)));
        let mut chosen: Vec<Waypoint> = Vec::new();
        let mut apart = Self::APART;
        while chosen.len() < self.poses(&reachable) && apart >= Self::LEAST_APART {
            for candidate in &reachable {
                let differs = |c: &Waypoint| self.space.motion_between(&c.pose, &candidate.pose) >= apart;
                if chosen.len() < self.effort.poses && chosen.iter().all(differs) {
                    chosen.push(**candidate);
                }
            }
            apart *= 0.5;
        }
        chosen
    }

    /// Number of poses worth keeping: few outside the blades, once the full clearance margin is reached.
    fn poses(&self, reachable: &[&Waypoint]) -> usize {
        const OUTSIDE: usize = 2;
        let outside = reachable.first().is_some_and(|w| !self.problem.objective.is_between_blades(&w.pose));
        if outside { OUTSIDE.min(self.effort.poses) } else { self.effort.poses.min(reachable.len()) }
    }

    /// The widest path to the last layer's waypoints that `ends` allows; the shortest of those equally wide.
    fn widest(&self, ends: impl Fn(&Waypoint) -> bool) -> ExtractionPath {
        let last = &self.layers[self.layers.len() - 1];
        let better = |a: &&Waypoint, b: &&Waypoint| a.margin.total_cmp(&b.margin).then(b.length.total_cmp(&a.length));
        let Some(mut at) = last.iter().filter(|w| ends(w)).max_by(better) else { return self.layers[0].clone() };
        let mut path = vec![*at];
        for layer in self.layers[..self.layers.len() - 1].iter().rev() {
            at = &layer[at.from];
            path.push(*at);
        }
        path.reverse();
        path
    }

    fn dead_end(&self, s: f64, tried: &[Tried]) -> DeadEnd {
        let path = self.widest(|_| true);
        let nearest = tried.iter().min_by(|a, b| a.configuration.lack.total_cmp(&b.configuration.lack));
        let (pose, lack, worst) = nearest
            .map_or((Pose::FINAL, 0.0, None), |t| (t.configuration.pose, t.configuration.lack, t.configuration.worst));
        DeadEnd { path, s, pose, lack, worst }
    }
}

impl FreeSpace<'_> {
    /// Times that a motion that is not free is halved.
    const HALVINGS: usize = 3;

    /// Warm-started path: the path near `known`, which holds the withdrawn distances (mm) and poses of a path of a
    /// similar electrode from the final pose on. Each pose is moved to where this electrode has the greatest clearance
    /// margin. None if a pose is not free, or no free motion leads from one to the next.
    pub(super) fn warm_started(
        &self,
        known: &[(f64, Pose)],
        cancel: &Cancel,
    ) -> Result<Option<ExtractionPath>, Cancelled> {
        let configuration = |&(s, pose): &(f64, Pose)| {
            cancel.check()?;
            let configuration = if s == 0.0 { self.origin() } else { self.widest_near(pose, s, cancel)? };
            Ok(self.is_free(&configuration).then_some(configuration))
        };
        let configurations: Result<Vec<Option<Configuration>>, Cancelled> =
            known.par_iter().map(configuration).collect();
        let Some(configurations) = configurations?.into_iter().collect::<Option<Vec<Configuration>>>() else {
            return Ok(None);
        };
        let stretch = |pair: &[Configuration]| {
            cancel.check()?;
            self.stretch(&pair[0], &pair[1], Self::HALVINGS, cancel)
        };
        let stretches: Result<Vec<Option<Vec<Configuration>>>, Cancelled> =
            configurations.par_windows(2).map(stretch).collect();
        Ok(stretches?.into_iter().collect::<Option<Vec<_>>>().map(|all| self.path_over(&all.concat())))
    }

    /// Configurations from the one after `from` to `to` with free motions between them.
    fn stretch(
        &self,
        from: &Configuration,
        to: &Configuration,
        halvings: usize,
        cancel: &Cancel,
    ) -> Result<Option<Vec<Configuration>>, Cancelled> {
        if self.joins((from.s, &from.pose), (to.s, &to.pose)) {
            return Ok(Some(vec![*to]));
        }
        let Some(halvings) = halvings.checked_sub(1) else { return Ok(None) };
        let middle = self.widest_near(from.pose.lerp(&to.pose, 0.5), 0.5 * (from.s + to.s), cancel)?;
        if !self.is_free(&middle) {
            return Ok(None);
        }
        let Some(before) = self.stretch(from, &middle, halvings, cancel)? else { return Ok(None) };
        Ok(self.stretch(&middle, to, halvings, cancel)?.map(|after| [before, after].concat()))
    }

    /// The path from the final pose over `configurations`.
    fn path_over(&self, configurations: &[Configuration]) -> ExtractionPath {
        let mut path = vec![Waypoint::first(self.room)];
        for configuration in configurations {
            let before = path[path.len() - 1];
            path.push(before.then(configuration, 0, self));
        }
        path
    }
}
