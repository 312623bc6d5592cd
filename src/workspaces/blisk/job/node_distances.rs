//! Distances between an electrode and the surfaces of its channel at the nodes of its path.

use glam::DVec3;
use rayon::prelude::*;

use feed::centreline::Guide;
use feed::objective::{WallSamples, WallSpread};
use feed::pose::Pose;
use feed::problem::Node;
use feed::wall_clearances::{ClearanceGauge, WallClearances};
use task::{Cancel, Cancelled};
use wheel::centreline::Centreline;
use wheel::channel::Channel;
use wheel::electrode::Electrode;
use wheel::surface_finder::SurfaceFinder;

/// Distances at a node.
#[derive(Debug, Clone, PartialEq)]
pub struct NodeDistances {
    /// Distances of P0's figure 4 (mm): of the samples of the low and of the high wall that are between the blades.
    pub walls: [Vec<f64>; 2],
    /// D_L, D_R, S_L and S_R of P0's (5) (mm), of samples between the blades; positive outside the blisk.
    pub spread: WallSpread,
    /// The four distances of P1 (mm), positive outside the blisk.
    pub clearances: WallClearances,
    /// P1's core point v (mm, in W), and its arc length along the centreline (mm); none where there is no centreline.
    pub core: Option<(DVec3, f64)>,
}

impl NodeDistances {
    /// The distances of `electrode` at each of `nodes`; `finder` is that of `channel`, and `line` its centreline, if it has
    /// one.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn at(
        nodes: &[Node],
        electrode: &Electrode,
        (channel, finder, line): (&Channel, &SurfaceFinder, Option<&Centreline>),
        cancel: &Cancel,
    ) -> Result<Vec<Self>, Cancelled> {
        let samples = WallSamples::of(electrode, channel, cancel)?;
        let poses: Vec<Pose> = nodes.iter().map(|node| node.pose).collect();
        let clearances = ClearanceGauge::new(electrode, channel, finder, cancel)?.at_all(&poses, cancel)?;
        let distances = |pose: &Pose| samples.distances(pose, 0.0, &|p| finder.wall_distances(p));
        let walls = poses.par_iter().map(|pose| cancel.check().map(|()| distances(pose)));
        let walls: Vec<[Vec<f64>; 2]> = walls.collect::<Result<_, _>>()?;
        // An electrode that cannot be followed has no core point either.
        let guide = line.and_then(|line| Guide::new(line.clone(), channel, electrode).ok());
        let core = |node: &Node| {
            let guide = guide.as_ref()?;
            let place = node.pose.placement(electrode.reference_point);
            Some((place.transform_point3(guide.core()), guide.arc_length(node.s)))
        };
        let all = nodes.iter().zip(walls).zip(clearances);
        let at = |((node, walls), clearances): ((&Node, [Vec<f64>; 2]), WallClearances)| Self {
            spread: WallSpread::of(&walls),
            walls,
            clearances,
            core: core(node),
        };
        Ok(all.map(at).collect())
    }
}
