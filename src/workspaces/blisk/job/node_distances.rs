//! Distances between an electrode and the surfaces of its channel at the nodes of its path.

use rayon::prelude::*;

use feed::objective::{WallSamples, WallSpread};
use feed::pose::Pose;
use feed::problem::Node;
use feed::wall_clearances::{ClearanceGauge, WallClearances};
use task::{Cancel, Cancelled};
use wheel::channel::Channel;
use wheel::electrode::Electrode;
use wheel::surface_finder::SurfaceFinder;

/// Distances at a node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NodeDistances {
    /// D_L, D_R, S_L and S_R of P0's (5) (mm), of samples between the blades; positive outside the blisk.
    pub spread: WallSpread,
    /// The four distances of P1 (mm), positive outside the blisk.
    pub clearances: WallClearances,
}

impl NodeDistances {
    /// The distances of `electrode` at each of `nodes`; `finder` is that of `channel`.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn at(
        nodes: &[Node],
        electrode: &Electrode,
        (channel, finder): (&Channel, &SurfaceFinder),
        cancel: &Cancel,
    ) -> Result<Vec<Self>, Cancelled> {
        let samples = WallSamples::of(electrode, channel, cancel)?;
        let poses: Vec<Pose> = nodes.iter().map(|node| node.pose).collect();
        let clearances = ClearanceGauge::new(electrode, channel, finder, cancel)?.at_all(&poses, cancel)?;
        let spread = |pose: &Pose| samples.spread(pose, 0.0, &|p| finder.wall_distances(p));
        let spreads = poses.par_iter().map(|pose| cancel.check().map(|()| spread(pose)));
        let spreads: Vec<WallSpread> = spreads.collect::<Result<_, _>>()?;
        let both = spreads.into_iter().zip(clearances);
        Ok(both.map(|(spread, clearances)| Self { spread, clearances }).collect())
    }
}
