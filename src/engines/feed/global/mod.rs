//! The global strategy: a search over many poses for each node, which no greedy step can lead into a dead end.
//!
//! A diverse set of poses is kept for every node. Each pose is moved to where its clearance margin is greatest and
//! joined to the poses of the node before by free motions. The extraction path is the widest path through them: the one
//! with the greatest clearance margin at its narrowest point. The whole path is then polished for smoothness and
//! clearance. Where no pose of a node can be reached, that node is the bottleneck of the channel at this resolution.
//!
//! A fixed lattice of poses would miss the path: near the final pose, free space is only as wide as the spark gap.

mod corridor;
mod free_space;
mod halfspaces;
mod polish;

use files::Invalid;
use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::jam::{Jam, JamCause, JamContact};
use super::pose::Pose;
use super::problem::{Convergence, Node, SearchOutcome, SearchProblem};
use super::strategy::{SearchStrategy, StrategySymbol};
pub(super) use corridor::ExtractionPath;
use corridor::{Corridor, DeadEnd, Effort, Waypoint};
use free_space::FreeSpace;
use task::{Cancel, Cancelled, Task};
use wheel::channel::Surface;

/// Parameters of the global strategy (`[plan.global]` of a project).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GlobalParams {
    /// Poses kept for each node.
    pub poses: usize,
    /// Clearance margin beyond the demand, up to which a wider path counts as better (mm).
    pub room_mm: f64,
    /// Share of the clearance margin about the path that polishing keeps: 0 gives the smoothest path, 1 the widest.
    pub room_kept: f64,
}

impl Default for GlobalParams {
    fn default() -> Self {
        Self { poses: 24, room_mm: 0.2, room_kept: 0.5 }
    }
}

/// Preview of an extraction path: the result of a coarse search.
#[derive(Debug, Clone, PartialEq)]
pub struct PreviewPath {
    /// Nodes from the final pose outwards, as far as the search came.
    pub nodes: Vec<Node>,
    /// Clearance margin at the narrowest point of the path (mm), if the path leads out.
    pub margin: Option<f64>,
    /// Place where the search jammed, if no path leads out.
    pub jam: Option<Jam>,
    /// Reference point O that the poses are about, that of the prepared electrode, in W (mm).
    pub reference_point: DVec3,
}

impl GlobalParams {
    /// Whether every parameter is within its range.
    pub fn validate(&self) -> Result<(), Invalid> {
        Invalid::unless_within("poses", self.poses as f64, [2.0, 1000.0], "")?;
        Invalid::unless_within("room_mm", self.room_mm, [0.0, 5.0], "mm")?;
        Invalid::unless_within("room_kept", self.room_kept, [0.0, 1.0], "")
    }
}

impl SearchStrategy for GlobalParams {
    fn is_whole(&self) -> bool {
        true
    }

    fn whole_path(
        &self,
        problem: &SearchProblem,
        known: &[Node],
        surface_of: &dyn Fn(DVec3) -> Surface,
        task: &Task,
    ) -> Result<SearchOutcome, Cancelled> {
        problem.widest_path(self, known, surface_of, task)
    }

    fn polished(&self, problem: &SearchProblem, nodes: Vec<Node>, cancel: &Cancel) -> Result<Vec<Node>, Cancelled> {
        problem.polished(nodes, self, cancel)
    }

    fn parameters(&self) -> Option<&'static str> {
        Some("plan.global")
    }

    fn symbols(&self) -> Vec<StrategySymbol> {
        let room = "clearance margin up to which a wider path counts as better";
        vec![
            StrategySymbol::new("poses", "poses kept for each node", self.poses as f64, "1"),
            StrategySymbol::new("room", room, self.room_mm, "mm"),
            StrategySymbol::new(
                "margin kept",
                "share of the clearance margin that polishing keeps",
                self.room_kept,
                "1",
            ),
        ]
    }
}

impl SearchProblem<'_> {
    /// Shares of the poses asked for that are tried, one after the other, until a path is found.
    const WIDENINGS: [f64; 3] = [0.35, 1.0, 3.0];
    /// Poses tried for each that is kept.
    const SEEDS: usize = 2;
    /// Distance between the nodes of the search over that between those of the path.
    const STRIDE_RATIO: f64 = 2.0;

    /// Widest extraction path, polished: warm-started from `known`, a path that was nearly free, where that succeeds;
    /// otherwise searched for.
    pub(super) fn widest_path(
        &self,
        params: &GlobalParams,
        known: &[Node],
        surface_of: &dyn Fn(DVec3) -> Surface,
        task: &Task,
    ) -> Result<SearchOutcome, Cancelled> {
        let near = if known.len() > 1 {
            let poses: Vec<(f64, Pose)> = known.iter().map(|n| (n.s, n.pose)).collect();
            FreeSpace::new(self, params.room_mm, &task.cancel)?.warm_started(&poses, &task.cancel)?
        } else {
            None
        };
        let found = match near {
            Some(path) => Ok(path),
            None => self.extraction_path(params, &Self::WIDENINGS, task)?,
        };
        match found {
            Ok(path) => {
                let nodes = self.polished(self.nodes_along(&path), params, &task.cancel)?;
                (self.observe)(&nodes, &[]);
                Ok(SearchOutcome { convergence: unsearched(&nodes), nodes, jam: None })
            }
            Err(end) => {
                let nodes = self.nodes_along(&end.path);
                let jam = self.dead_end(&end, nodes.len(), surface_of);
                Ok(SearchOutcome { convergence: unsearched(&nodes), nodes, jam: Some(jam) })
            }
        }
    }

    /// Preview of the extraction path with few poses at a coarse step, in a fraction of a second; or how far it leads.
    pub(super) fn preview_path(
        &self,
        params: &GlobalParams,
        surface_of: &dyn Fn(DVec3) -> Surface,
        task: &Task,
    ) -> Result<PreviewPath, Cancelled> {
        const EFFORT: Effort = Effort { poses: 6, seeds: 12, step: 1.5 };
        let space = FreeSpace::quick(self, params.room_mm, &task.cancel)?;
        let found = Corridor::new(&space, EFFORT).explore(task)?;
        let reference_point = self.model.reference_point();
        let nodes = |path: &ExtractionPath| path.par_iter().map(|w| self.plain_node(w)).collect::<Vec<_>>();
        Ok(match found {
            Ok(path) => {
                PreviewPath { margin: path.last().map(|w| w.margin), nodes: nodes(&path), jam: None, reference_point }
            }
            Err(end) => {
                let nodes = nodes(&end.path);
                let jam = self.dead_end(&end, nodes.len(), surface_of);
                PreviewPath { margin: None, nodes, jam: Some(jam), reference_point }
            }
        })
    }

    /// A node without its objective.
    fn plain_node(&self, waypoint: &Waypoint) -> Node {
        let clearance = self.model.least_clearance(&waypoint.pose, self.turns);
        Node { s: waypoint.s, pose: waypoint.pose, h: 0.0, clearance, objective: Default::default() }
    }

    /// Wide extraction path found with few poses, if there is one.
    pub(super) fn path_with_few_poses(
        &self,
        params: &GlobalParams,
        task: &Task,
    ) -> Result<Option<ExtractionPath>, Cancelled> {
        Ok(self.extraction_path(params, &Self::WIDENINGS[..1], task)?.ok())
    }

    /// Warm-started path: the path near `path`, which is one of a similar electrode; none if there is none near.
    pub(super) fn warm_started_path(
        &self,
        params: &GlobalParams,
        path: &ExtractionPath,
        cancel: &Cancel,
    ) -> Result<Option<ExtractionPath>, Cancelled> {
        let poses: Vec<(f64, Pose)> = path.iter().map(|w| (w.s, w.pose)).collect();
        FreeSpace::new(self, params.room_mm, cancel)?.warm_started(&poses, cancel)
    }

    /// Wide extraction path, or the dead end of all paths.
    fn extraction_path(
        &self,
        params: &GlobalParams,
        widenings: &[f64],
        task: &Task,
    ) -> Result<Result<ExtractionPath, DeadEnd>, Cancelled> {
        let mut furthest: Option<DeadEnd> = None;
        for (i, share) in widenings.iter().enumerate() {
            // Only the first one is quick: what it does not find is narrow.
            let space = if i == 0 { FreeSpace::quick } else { FreeSpace::new }(self, params.room_mm, &task.cancel)?;
            let poses = (share * params.poses as f64).round().max(2.0) as usize;
            let effort = Effort { poses, seeds: Self::SEEDS * poses, step: Self::STRIDE_RATIO * self.step };
            match Corridor::new(&space, effort).explore(task)? {
                Ok(path) => return Ok(Ok(path)),
                Err(end) if furthest.as_ref().is_none_or(|f| f.s < end.s) => furthest = Some(end),
                Err(_) => {}
            }
        }
        furthest.map(Err).ok_or(Cancelled)
    }

    /// Nodes along the path, one step apart.
    fn nodes_along(&self, path: &ExtractionPath) -> Vec<Node> {
        let mut nodes = vec![self.final_node()];
        for w in path.windows(2) {
            let pieces = ((w[1].s - w[0].s) / self.step - 1e-9).ceil().max(1.0) as usize;
            for i in 1..=pieces {
                let t = i as f64 / pieces as f64;
                let (s, pose) = (w[0].s + (w[1].s - w[0].s) * t, w[0].pose.lerp(&w[1].pose, t));
                let clearance = self.model.least_clearance(&pose, self.turns);
                nodes.push(Node { s, pose, h: 0.0, clearance, objective: Default::default() });
            }
        }
        self.valued(nodes)
    }

    fn dead_end(&self, end: &DeadEnd, node: usize, surface_of: &dyn Fn(DVec3) -> Surface) -> Jam {
        let jam = |cause| Jam { node, s: end.s, pose: end.pose, cause, opening: None };
        if let Some((axis, limit)) = self.travel.beyond(&end.pose) {
            return jam(JamCause::Travel { axis, value: end.pose.get(axis), limit });
        }
        let wanted = self.demand.wanted();
        let place = end.worst.or_else(|| self.model.tightest(&end.pose, self.turns, wanted));
        let cause = place.map_or(JamCause::Unknown, |short| {
            let (on_electrode, on_blisk) = (short.on_electrode, short.on_blisk);
            JamCause::Contact(JamContact { on_electrode, on_blisk, surface: surface_of(on_blisk), lack: end.lack })
        });
        jam(cause)
    }
}

/// Empty convergence of nodes that were not searched one by one.
fn unsearched(nodes: &[Node]) -> Vec<Convergence> {
    nodes[1..].iter().map(|n| Convergence::none(n.s)).collect()
}
