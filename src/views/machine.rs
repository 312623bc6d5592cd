//! The whole motion on a machine and its bodies, for showing.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};

use crate::feed::machine_model::Carrier;
use crate::feed::path::FeedPath;
use crate::feed::pose::Pose;
use crate::feed::simulation::{Leg, Phase, Place, Simulation};
use crate::render::mesh::RenderMesh;

/// A body of a machine for the screen.
#[derive(Debug, Clone)]
pub struct MachineBody {
    /// Where it is in the final pose, in W.
    pub shape: Arc<RenderMesh>,
    /// What it goes with.
    pub carrier: Carrier,
    /// Whether something comes too close to it.
    pub is_in_the_way: bool,
}

impl MachineBody {
    /// Where the body is at `pose` of an electrode with this reference point, as seen from the blisk.
    pub fn placement(&self, pose: &Pose, reference_point: DVec3) -> DAffine3 {
        match self.carrier {
            Carrier::Electrode => pose.placement(reference_point),
            Carrier::Head => Pose { b: 0.0, c: 0.0, ..*pose }.placement(reference_point),
            Carrier::Table => DAffine3::IDENTITY,
            Carrier::Bed => DAffine3::from_mat3(DMat3::from_rotation_x(pose.a)),
        }
    }
}

/// The bodies of the machine that `simulation` was made with.
pub fn machine_bodies(simulation: &Simulation) -> Vec<MachineBody> {
    let body = |body: &crate::feed::machine_model::Body| MachineBody {
        shape: Arc::new(RenderMesh::new(&body.mesh)),
        carrier: body.carrier,
        is_in_the_way: simulation.is_in_the_way(&body.name),
    };
    simulation.bodies().iter().map(body).collect()
}

/// A whole motion along its way: millimetres of slide or degrees of turn, whichever are more.
#[derive(Debug, Clone, Default)]
pub struct WholeMotion {
    legs: Vec<Leg>,
    /// The way to every pose of every leg.
    ways: Vec<Vec<f64>>,
}

impl WholeMotion {
    /// The motion that was simulated.
    pub fn new(simulation: &Simulation, feed: &FeedPath, copying: Option<&FeedPath>) -> Self {
        let legs = simulation.legs(feed, copying);
        let mut so_far = 0.0;
        let ways = legs.iter().map(|leg| {
            let mut ways = vec![so_far];
            for pair in leg.poses.windows(2) {
                so_far += way_between(&pair[0], &pair[1]);
                ways.push(so_far);
            }
            ways
        });
        let ways = ways.collect();
        Self { legs, ways }
    }

    /// All of the way.
    pub fn length(&self) -> f64 {
        self.ways.last().and_then(|ways| ways.last()).copied().unwrap_or(0.0)
    }

    /// What is done in which channel from where to where, in order.
    pub fn phases(&self) -> impl Iterator<Item = (Phase, usize, [f64; 2])> {
        let span = |ways: &Vec<f64>| [ways.first(), ways.last()].map(|w| w.copied().unwrap_or(0.0));
        self.legs.iter().zip(&self.ways).map(move |(leg, ways)| (leg.phase, leg.channel, span(ways)))
    }

    /// The pose at `way`, and what is done there in which channel.
    pub fn at(&self, way: f64) -> Option<(Pose, Phase, usize)> {
        let i = self.ways.partition_point(|ways| ways.last().is_some_and(|end| *end < way));
        let i = i.min(self.legs.len().checked_sub(1)?);
        let (leg, ways) = (&self.legs[i], &self.ways[i]);
        let k = ways.partition_point(|w| *w <= way).clamp(1, ways.len().max(2) - 1);
        let (Some(from), Some(to)) = (ways.get(k - 1), ways.get(k)) else {
            return leg.poses.first().map(|pose| (*pose, leg.phase, leg.channel));
        };
        let t = if to > from { ((way - from) / (to - from)).clamp(0.0, 1.0) } else { 1.0 };
        Some((leg.pose_at((k - 1) as f64 + t), leg.phase, leg.channel))
    }

    /// The way to `place`.
    pub fn way_to(&self, place: &Place) -> Option<f64> {
        let is_it = |leg: &Leg| leg.phase == place.phase && leg.channel == place.channel;
        let ways = &self.ways[self.legs.iter().position(is_it)?];
        let k = (place.row.max(0.0) as usize).min(ways.len().checked_sub(1)?);
        let next = ways.get(k + 1).unwrap_or(&ways[k]);
        Some(ways[k] + (next - ways[k]) * (place.row - k as f64))
    }
}

fn way_between(from: &Pose, to: &Pose) -> f64 {
    let d: [f64; 6] = std::array::from_fn(|i| to.to_array()[i] - from.to_array()[i]);
    let turn = d[3..].iter().map(|angle| angle.to_degrees().abs()).fold(0.0, f64::max);
    DVec3::new(d[0], d[1], d[2]).length().max(turn)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::fixtures;

    #[test]
    fn the_whole_motion_is_stepped_through_without_a_jump() {
        let (feed, turn) = (fixtures::path(), 6f64.to_radians());
        let motion = WholeMotion::new(&Simulation::made_up(fixtures::simulation()), &feed, None);
        let phases: Vec<_> = motion.phases().collect();
        assert_eq!(phases.len(), 7);
        assert!(phases.windows(2).all(|pair| pair[0].2[1] == pair[1].2[0]));
        assert_eq!(phases[0].2, [0.0, 30.0], "20 mm down and 10 mm in");
        let index = phases[3];
        assert!(
            index.0 == Phase::Index && (index.2[1] - index.2[0] - 6.0).abs() < 1e-9,
            "degrees, where it only turns"
        );
        let (pose, phase, channel) = motion.at(2.5).unwrap();
        assert_eq!((phase, channel), (Phase::Approach, 3));
        assert!((pose.z - (feed.rows[0].pose.z + 17.5)).abs() < 1e-9);
        // The end of the second feed is the final pose of the next channel.
        let (pose, phase, channel) = motion.at(phases[5].2[1]).unwrap();
        assert_eq!((phase, channel), (Phase::Feed, 4));
        assert!((pose.a - turn).abs() < 1e-12 && pose.x == 0.0);
        assert_eq!(motion.at(motion.length() + 1.0).unwrap().1, Phase::Retract);
        let steps = 4000;
        let poses: Vec<Pose> =
            (0..=steps).map(|i| motion.at(motion.length() * i as f64 / steps as f64).unwrap().0).collect();
        let most = poses.windows(2).map(|p| way_between(&p[0], &p[1])).fold(0.0, f64::max);
        assert!(most <= motion.length() / steps as f64 + 1e-9, "{most}");
    }

    #[test]
    fn the_bed_turns_back_as_seen_from_the_blisk_and_the_head_does_not_tilt() {
        let pose = Pose { x: 3.0, a: 0.4, b: 0.2, c: -0.3, ..Pose::FINAL };
        let (o, p) = (DVec3::new(1.0, 2.0, 90.0), DVec3::new(5.0, -7.0, 30.0));
        let at = |carrier| {
            let shape = Arc::new(RenderMesh::new(&Default::default()));
            MachineBody { shape, carrier, is_in_the_way: false }.placement(&pose, o).transform_point3(p)
        };
        let turned = DMat3::from_rotation_x(0.4);
        assert!((at(Carrier::Bed) - turned * p).length() < 1e-12);
        assert!((at(Carrier::Head) - turned * (p + DVec3::new(3.0, 0.0, 0.0))).length() < 1e-12);
        assert_eq!(at(Carrier::Table), p);
        assert!((at(Carrier::Electrode) - pose.placement(o).transform_point3(p)).length() < 1e-12);
    }
}
