//! The global strategy: no greedy step can walk into a dead end.
//!
//! A diverse set of poses is kept for every node, each moved to where there is most room about it, and joined to the
//! poses of the node before by motions that are free. The way out is the widest one through them all: the one whose
//! narrowest place has most clearance. The whole path is then polished at once, for smoothness and clearance. Where no
//! pose of a node can be reached, the node is the bottleneck of the channel at this resolution.
//!
//! A fixed lattice of poses would miss the way: near the final pose free space is only the spark gap wide.

mod corridor;
mod follow;
mod ground;
mod halfspaces;
mod polish;

use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::jam::{Jam, JamCause, JamContact};
use super::pose::Pose;
use super::search::{Convergence, Node, SearchOutcome, SearchProblem};
pub(super) use corridor::Way;
use corridor::{Corridor, DeadEnd, Effort, Waypoint};
use ground::Ground;
use task::{Cancel, Cancelled, Progress};
use wheel::channel::Surface;

/// Parameters of the global strategy (`[plan.global]` of a job).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GlobalParams {
    /// Poses kept for each node.
    pub poses: usize,
    /// Clearance beyond what is asked for, up to which a wider way counts as better (mm).
    pub room_mm: f64,
    /// Share of the room about the way that polishing keeps: 0 gives the smoothest path, 1 the roomiest.
    pub room_kept: f64,
}

impl Default for GlobalParams {
    fn default() -> Self {
        Self { poses: 24, room_mm: 0.2, room_kept: 0.5 }
    }
}

/// What a coarse search found.
#[derive(Debug, Clone, PartialEq)]
pub struct CoarseWay {
    /// Nodes from the final pose outwards, as far as it got.
    pub nodes: Vec<Node>,
    /// Room beyond what is asked for at the narrowest place of the way (mm), if it leads out.
    pub width: Option<f64>,
    /// Where it ends, if it does not.
    pub jam: Option<Jam>,
}

/// A parameter of the global strategy that cannot be used.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("[plan.global] {key} = {value}: must be {range}")]
pub struct GlobalParamsError {
    key: &'static str,
    value: f64,
    range: &'static str,
}

impl GlobalParams {
    /// Whether every parameter is within its range.
    pub fn validate(&self) -> Result<(), GlobalParamsError> {
        let within = |key, value: f64, least: f64, greatest: f64, range| {
            if (least..=greatest).contains(&value) { Ok(()) } else { Err(GlobalParamsError { key, value, range }) }
        };
        within("poses", self.poses as f64, 2.0, 1000.0, "2 to 1000")?;
        within("room_mm", self.room_mm, 0.0, 5.0, "0 to 5 mm")?;
        within("room_kept", self.room_kept, 0.0, 1.0, "0 to 1")
    }
}

impl SearchProblem<'_> {
    /// Shares of the poses asked for that are tried, one after the other, until a way is found.
    const WIDENINGS: [f64; 3] = [0.35, 1.0, 3.0];
    /// Poses tried for each that is kept.
    const SEEDS: usize = 2;
    /// Distance between the nodes of the search over that between those of the path.
    const STRIDE_RATIO: f64 = 2.0;

    /// The widest way out, polished: near `known`, a path that was nearly one, if there is one there; else searched for.
    pub(super) fn widest_way(
        &self,
        params: &GlobalParams,
        known: &[Node],
        surface_of: &dyn Fn(DVec3) -> Surface,
        progress: &Progress,
        cancel: &Cancel,
    ) -> Result<SearchOutcome, Cancelled> {
        let near = if known.len() > 1 {
            let poses: Vec<(f64, Pose)> = known.iter().map(|n| (n.s, n.pose)).collect();
            Ground::new(self, params.room_mm).followed(&poses, cancel)?
        } else {
            None
        };
        let found = match near {
            Some(way) => Ok(way),
            None => self.way_out_of(params, &Self::WIDENINGS, progress, cancel)?,
        };
        match found {
            Ok(way) => {
                let nodes = self.polished(self.nodes_along(&way), params, cancel)?;
                (self.observe)(&nodes, &[]);
                Ok(SearchOutcome { convergence: unsearched(&nodes), nodes, jam: None })
            }
            Err(end) => {
                let nodes = self.nodes_along(&end.way);
                let jam = self.dead_end(&end, nodes.len(), surface_of);
                Ok(SearchOutcome { convergence: unsearched(&nodes), nodes, jam: Some(jam) })
            }
        }
    }

    /// A way out found with few poses and far between, in a fraction of a second; or how far it gets.
    pub(super) fn coarse_way(
        &self,
        params: &GlobalParams,
        surface_of: &dyn Fn(DVec3) -> Surface,
        progress: &Progress,
        cancel: &Cancel,
    ) -> Result<CoarseWay, Cancelled> {
        const EFFORT: Effort = Effort { poses: 6, seeds: 12, step: 1.5 };
        let ground = Ground::quick(self, params.room_mm);
        let found = Corridor::new(&ground, EFFORT).explore(progress, cancel)?;
        let nodes = |way: &Way| way.par_iter().map(|w| self.plain_node(w)).collect::<Vec<_>>();
        Ok(match found {
            Ok(way) => CoarseWay { width: way.last().map(|w| w.width), nodes: nodes(&way), jam: None },
            Err(end) => {
                let nodes = nodes(&end.way);
                let jam = self.dead_end(&end, nodes.len(), surface_of);
                CoarseWay { width: None, nodes, jam: Some(jam) }
            }
        })
    }

    /// A node without its objective.
    fn plain_node(&self, waypoint: &Waypoint) -> Node {
        let clearance = self.model.least_clearance(&waypoint.pose, self.turns);
        Node { s: waypoint.s, pose: waypoint.pose, h: 0.0, clearance, objective: Default::default() }
    }

    /// A wide way out; none if none is found with few poses.
    pub(super) fn way_with_few(
        &self,
        params: &GlobalParams,
        progress: &Progress,
        cancel: &Cancel,
    ) -> Result<Option<Way>, Cancelled> {
        Ok(self.way_out_of(params, &Self::WIDENINGS[..1], progress, cancel)?.ok())
    }

    /// The way near `way`, one of a similar electrode; none if there is none near.
    pub(super) fn followed_way(
        &self,
        params: &GlobalParams,
        way: &Way,
        cancel: &Cancel,
    ) -> Result<Option<Way>, Cancelled> {
        let poses: Vec<(f64, Pose)> = way.iter().map(|w| (w.s, w.pose)).collect();
        Ground::new(self, params.room_mm).followed(&poses, cancel)
    }

    /// A wide way out, or where all ways end.
    fn way_out_of(
        &self,
        params: &GlobalParams,
        widenings: &[f64],
        progress: &Progress,
        cancel: &Cancel,
    ) -> Result<Result<Way, DeadEnd>, Cancelled> {
        let mut furthest: Option<DeadEnd> = None;
        for (i, share) in widenings.iter().enumerate() {
            // Only the first one is quick: what it does not find is narrow.
            let ground = if i == 0 { Ground::quick } else { Ground::new }(self, params.room_mm);
            let poses = (share * params.poses as f64).round().max(2.0) as usize;
            let effort = Effort { poses, seeds: Self::SEEDS * poses, step: Self::STRIDE_RATIO * self.step };
            match Corridor::new(&ground, effort).explore(progress, cancel)? {
                Ok(way) => return Ok(Ok(way)),
                Err(end) if furthest.as_ref().is_none_or(|f| f.s < end.s) => furthest = Some(end),
                Err(_) => {}
            }
        }
        furthest.map(Err).ok_or(Cancelled)
    }

    /// The way as nodes a step apart.
    fn nodes_along(&self, way: &Way) -> Vec<Node> {
        let mut nodes = vec![self.final_node()];
        for w in way.windows(2) {
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

/// No node was searched by itself: nothing converged.
fn unsearched(nodes: &[Node]) -> Vec<Convergence> {
    nodes[1..].iter().map(|n| Convergence::none(n.s)).collect()
}
