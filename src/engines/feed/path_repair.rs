//! Repair of a path that is nearly free: the curve through the nodes bends a little at each node that is added after
//! them, and so may lose clearance between nodes where it was tested before.

use rayon::prelude::*;

use super::interpolation::AxisCurves;
use super::pose::Pose;
use super::problem::{Node, SearchProblem};
use task::{Cancel, Cancelled};

impl SearchProblem<'_> {
    /// Greatest number of times that the curve is drawn anew through more nodes.
    const PASSES: usize = 8;
    /// Least share of an interval on either side of an inserted node.
    const LEAST_SHARE: f64 = 0.25;
    /// Length of the shortest interval that is divided, as a share of the step.
    const LEAST_INTERVAL: f64 = 1.0 / 64.0;

    /// Moves nodes that lack clearance, and inserts nodes where the curve between them lacks it, both by climbing the
    /// distance fields from the curve, until the curve is free as far as the probes tell. None where that cannot be
    /// reached: another search is needed then. With the angle constraint there is no field to climb and no repair.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn repaired(&self, nodes: &[Node], cancel: &Cancel) -> Result<Option<Vec<Node>>, Cancelled> {
        if self.angle.is_some() || nodes.len() < 2 {
            return Ok(None);
        }
        let Some(mut nodes) = self.with_free_nodes(nodes, cancel)? else { return Ok(None) };
        for _ in 0..Self::PASSES {
            let Ok(curves) = AxisCurves::through(&nodes, self.joining) else { return Ok(None) };
            let Some(dips) = self.dips(&nodes, &curves, cancel)? else { return Ok(None) };
            if dips.is_empty() {
                return Ok(Some(self.valued(nodes)));
            }
            nodes.extend(dips);
            nodes.sort_by(|a, b| a.s.total_cmp(&b.s));
        }
        Ok(None)
    }

    /// The nodes, each of them free; none where one cannot be made so.
    fn with_free_nodes(&self, nodes: &[Node], cancel: &Cancel) -> Result<Option<Vec<Node>>, Cancelled> {
        let freed = |node: &Node| {
            cancel.check()?;
            // The final pose is given.
            let free = node.s == 0.0 || self.keeps(&node.pose, node.s, node.h, &self.between(), &mut 0);
            Ok(if free { Some(*node) } else { self.node_near(&node.pose, node.s, node.h) })
        };
        nodes.par_iter().map(freed).collect()
    }

    /// A node for every interval that the curve is not free in; none where no free pose is near it.
    fn dips(&self, nodes: &[Node], curves: &AxisCurves, cancel: &Cancel) -> Result<Option<Vec<Node>>, Cancelled> {
        let taken = nodes.iter().scan(0.0f64, |h, node| {
            *h = h.max(node.h);
            Some(*h)
        });
        let taken: Vec<f64> = taken.skip(1).collect();
        let in_interval = |(w, &h): (&[Node], &f64)| {
            cancel.check()?;
            let Some(s) = self.dip(&w[0], &w[1], h, curves) else { return Ok(None) };
            let too_short = w[1].s - w[0].s < Self::LEAST_INTERVAL * self.step;
            let node = if too_short { None } else { self.node_near(&curves.pose(s), s, h) };
            Ok(Some(node))
        };
        let found: Result<Vec<Option<Option<Node>>>, Cancelled> =
            nodes.par_windows(2).zip(&taken).map(in_interval).collect();
        Ok(found?.into_iter().flatten().collect())
    }

    /// Middle of the stretch where the curve from `from` to `to` is not free (withdrawn distance, mm), kept away from
    /// both ends.
    fn dip(&self, from: &Node, to: &Node, h: f64, curves: &AxisCurves) -> Option<f64> {
        let mut hint = 0;
        let blocked: Vec<f64> = self
            .joints(from, to)
            .filter(|&t| {
                let s = from.s + (to.s - from.s) * t;
                !self.keeps(&curves.pose(s), s, h, &self.between(), &mut hint)
            })
            .collect();
        let t = blocked.get(blocked.len() / 2)?.clamp(Self::LEAST_SHARE, 1.0 - Self::LEAST_SHARE);
        Some(from.s + (to.s - from.s) * t)
    }

    /// Free node near `pose`, withdrawn by `s`, with the whole allowance for the errors of the fields or, where that
    /// does not fit, a part of it.
    fn node_near(&self, pose: &Pose, s: f64, h: f64) -> Option<Node> {
        let start = self.withdrawn(pose, s);
        [self.demand, self.narrow()].iter().find_map(|demand| {
            let (pose, lacking) = self.model.climb(start, s, self.turned(h), demand, self.free_axes());
            let free = lacking.is_none() && self.keeps(&pose, s, h, &self.between(), &mut 0);
            free.then(|| {
                let clearance = self.model.least_clearance(&pose, self.turned(h));
                Node { s, pose, h, clearance, objective: Default::default() }
            })
        })
    }
}
