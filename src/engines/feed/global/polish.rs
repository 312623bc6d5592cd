//! Polishing a whole path: the least bent one of those that keep their share of the room about them.
//!
//! A sequence of convex problems. About the present path, what each node must keep clear of is taken as half-spaces, to
//! first order; within a distance in which that is trusted, the path of least bending is found that keeps to all of
//! them at once (alternating directions: bending pulls at the whole path, each node is projected on its half-spaces,
//! and what they disagree on is carried into the next round). Where the fields then say otherwise, a node is moved back
//! to freedom and trusted less.

use rayon::prelude::*;

use super::GlobalParams;
use super::free_space::COARSE;
use super::halfspaces::{HalfSpaces, Step};
use crate::clearance::ClearanceModel;
use crate::climb::mobility;
use crate::pose::{Axis, Pose};
use crate::probes::Demand;
use crate::problem::{Node, SearchProblem};
use geometry::smoothing::Smoother;
use task::{Cancel, Cancelled};

/// How far the first step of polishing trusts what was found about a node, and the most it does (mm).
const TRUST: [f64; 2] = [0.6, 2.0];
/// Convex problems, and rounds for each.
const PROBLEMS: usize = 12;
const ROUNDS: usize = 40;
/// Length over which one round of alternating directions spreads (mm).
const SPREAD: f64 = 3.0;
/// Steps of ascent that tell how much room there is about a node.
const LOOK_AROUND: usize = 6;

/// A node being polished.
#[derive(Debug, Clone, Copy)]
struct Polished {
    pose: Pose,
    demand: Demand,
    trust: f64,
}

impl SearchProblem<'_> {
    /// The least bent path near `nodes` on which each of them keeps its share of the room about it.
    pub(crate) fn polished(
        &self,
        nodes: Vec<Node>,
        params: &GlobalParams,
        cancel: &Cancel,
    ) -> Result<Vec<Node>, Cancelled> {
        let s: Vec<f64> = nodes.iter().map(|n| n.s).collect();
        let Some(smoother) = Smoother::new(&s, SPREAD) else { return Ok(nodes) };
        let mut path = self.with_demands(&nodes, params, cancel)?;
        let mut smooth: Vec<Pose> = Vec::new();
        let coarse = self.model.thinned(COARSE, cancel)?;
        for _ in 0..PROBLEMS {
            let spaces = self.spaces_about(&coarse, &nodes, &path, cancel)?;
            let (steps, bent) = least_bent(&smoother, &path, &spaces, self.free_axes());
            smooth = bent;
            path = self.taken(&nodes, &path, &steps, cancel)?;
        }
        Ok(self.led_out(self.settled(nodes, &smooth, &path)))
    }

    /// `nodes` with the last one so far out as is asked for: what turns on the way may have come nearer.
    fn led_out(&self, mut nodes: Vec<Node>) -> Vec<Node> {
        if let Some(last) = nodes.last_mut() {
            let missing = self.exit_clearance - self.distance_outside(&last.pose);
            if missing > 0.0 {
                last.s += missing;
                last.pose = self.withdrawn(&last.pose, last.s);
            }
        }
        nodes
    }

    /// Demand of each node, a share of the clearance margin about it on top of the demand, and the pose near it that
    /// meets it.
    fn with_demands(&self, nodes: &[Node], params: &GlobalParams, cancel: &Cancel) -> Result<Vec<Polished>, Cancelled> {
        let narrow = self.narrow();
        let wide = Demand { room: params.room_mm, ..narrow };
        let one = |node: &Node| {
            cancel.check()?;
            if node.s == 0.0 {
                return Ok(Polished { pose: node.pose, demand: narrow, trust: 0.0 });
            }
            let at = (node.s, self.turns);
            let ascent = self.model.ascend(node.pose, at, &wide, self.free_axes(), LOOK_AROUND, cancel)?;
            let room = (params.room_mm - ascent.lack).max(0.0);
            let demand = Demand { room: params.room_kept * room, ..narrow };
            Ok(Polished { pose: ascent.pose, demand, trust: TRUST[0] })
        };
        nodes.par_iter().map(one).collect()
    }

    /// Constraints of each node, as half-spaces of steps from its pose.
    fn spaces_about(
        &self,
        coarse: &ClearanceModel,
        nodes: &[Node],
        path: &[Polished],
        cancel: &Cancel,
    ) -> Result<Vec<HalfSpaces>, Cancelled> {
        let one = |(node, at): (&Node, &Polished)| {
            cancel.check()?;
            if at.trust == 0.0 {
                return Ok(HalfSpaces::default());
            }
            // A step of this length brings a point nearer by up to about half as much again.
            let further = 1.5 * at.trust;
            let demand = Demand { room: at.demand.room + further, ..at.demand };
            let walls = coarse.walls_about(&at.pose, (node.s, self.turns), &demand, self.free_axes());
            let keeps = walls.into_iter().map(|(slopes, lack)| (slopes, lack - further)).collect();
            let limits = self.free_axes().iter().map(|&axis| {
                let ends = self.travel.of(axis).map(|end| (end - at.pose.get(axis)) / mobility(axis));
                (axis as usize, [ends[0].max(-at.trust), ends[1].min(at.trust)])
            });
            Ok(HalfSpaces::new(keeps, limits.collect()))
        };
        nodes.par_iter().zip(path).map(one).collect()
    }

    /// The path after `steps`, each node moved to where it is free, or left where it was.
    fn taken(
        &self,
        nodes: &[Node],
        path: &[Polished],
        steps: &[Step],
        cancel: &Cancel,
    ) -> Result<Vec<Polished>, Cancelled> {
        let one = |k: usize| {
            cancel.check()?;
            let before = path[k];
            if before.trust == 0.0 {
                return Ok(before);
            }
            let wanted = stepped(&before.pose, &steps[k]);
            let (pose, lacking) = self.model.climb(wanted, nodes[k].s, self.turns, &before.demand, self.free_axes());
            let strayed = self.model.motion_between(&wanted, &pose);
            if strayed == 0.0 && lacking.is_none() {
                return Ok(Polished { pose, trust: (1.5 * before.trust).min(TRUST[1]), ..before });
            }
            let near = lacking.is_none() && strayed < 0.5 * before.trust;
            let trust = 0.5 * before.trust;
            Ok(if near { Polished { pose, trust, ..before } } else { Polished { trust, ..before } })
        };
        (0..nodes.len()).into_par_iter().map(one).collect()
    }

    /// The smooth poses where they are free. Elsewhere the pose that was kept free or the first one, whichever is free and
    /// nearer to the smooth one.
    fn settled(&self, nodes: Vec<Node>, smooth: &[Pose], path: &[Polished]) -> Vec<Node> {
        let narrow = self.narrow();
        let settled = |k: usize| {
            let node = nodes[k];
            if k == 0 {
                return node;
            }
            let is_free = |pose: &Pose| self.keeps(pose, node.s, 0.0, &narrow, &mut 0);
            let off = |pose: &Pose| self.model.motion_between(&smooth[k], pose);
            let pose = nearest_free(smooth[k], [path[k].pose, node.pose], is_free, off).unwrap_or(node.pose);
            Node { pose, clearance: self.model.least_clearance(&pose, self.turns), ..node }
        };
        self.valued((0..nodes.len()).into_par_iter().map(settled).collect())
    }
}

/// The smooth pose where it is free, else the nearer free one of `others`: what was kept free may have been led far away.
fn nearest_free(
    smooth: Pose,
    mut others: [Pose; 2],
    is_free: impl Fn(&Pose) -> bool,
    off: impl Fn(&Pose) -> f64,
) -> Option<Pose> {
    others.sort_by(|a, b| off(a).total_cmp(&off(b)));
    [smooth].into_iter().chain(others).find(is_free)
}

fn stepped(pose: &Pose, step: &Step) -> Pose {
    let mut q = pose.to_array();
    for (axis, (value, step)) in Axis::ALL.into_iter().zip(q.iter_mut().zip(step)) {
        *value += mobility(axis) * step;
    }
    Pose::from_array(q)
}

/// The steps to the least bent path that keeps to `spaces`, and that path without the last projection.
fn least_bent(smoother: &Smoother, path: &[Polished], spaces: &[HalfSpaces], axes: &[Axis]) -> (Vec<Step>, Vec<Pose>) {
    let n = path.len();
    let (mut kept, mut carried): (Vec<Step>, Vec<Step>) = (vec![[0.0; 6]; n], vec![[0.0; 6]; n]);
    let mut bent = kept.clone();
    for _ in 0..ROUNDS {
        for &axis in axes {
            let i = axis as usize;
            let here = |k: usize| path[k].pose.get(axis) / mobility(axis);
            let targets: Vec<f64> = (0..n).map(|k| here(k) + kept[k][i] - carried[k][i]).collect();
            for (k, value) in smoother.smooth(&targets).into_iter().enumerate() {
                bent[k][i] = value - here(k);
            }
        }
        let project = |k: usize| {
            let target: Step = std::array::from_fn(|i| bent[k][i] + carried[k][i]);
            spaces[k].nearest(&target)
        };
        kept = (0..n).into_par_iter().with_min_len(8).map(project).collect();
        for k in 1..n {
            for i in 0..6 {
                carried[k][i] += bent[k][i] - kept[k][i];
            }
        }
    }
    let smooth = (0..n).map(|k| stepped(&path[k].pose, &bent[k])).collect();
    (kept, smooth)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_settles_at_the_nearest_of_the_free_poses() {
        let [smooth, near, far] = [1.0, 1.5, 4.0].map(|x| Pose { x, ..Pose::FINAL });
        let settled = |blocked: &[Pose]| {
            nearest_free(smooth, [far, near], |pose| !blocked.contains(pose), |pose| (pose.x - smooth.x).abs())
        };
        assert_eq!(settled(&[]), Some(smooth));
        assert_eq!(settled(&[smooth]), Some(near));
        assert_eq!(settled(&[smooth, near]), Some(far));
        assert_eq!(settled(&[smooth, near, far]), None);
    }
}
