//! The whole motion on a machine and its bodies, for showing.

use std::sync::Arc;

use glam::{DAffine3, DVec3};

use feed::chain::Chain;
use feed::machine_model::{Body, Carrier, MachineModel, Station};
use feed::path::FeedPath;
use feed::pose::Pose;
use feed::simulation::{Leg, Phase, Place, Simulation};
use render::mesh::RenderMesh;

/// A body of a machine for the screen, as its file has it.
#[derive(Debug, Clone)]
pub struct BodyShape {
    /// Name of the body.
    pub name: String,
    /// Part of the machine that carries the body.
    pub carrier: Carrier,
    /// Shape of the body in the coordinates of its carrier.
    pub shape: Arc<RenderMesh>,
}

/// The bodies of `model` for the screen.
pub fn body_shapes(model: &MachineModel) -> Vec<BodyShape> {
    let shape = |body: &Body| BodyShape {
        name: body.name.clone(),
        carrier: body.carrier,
        shape: Arc::new(RenderMesh::new(&body.mesh)),
    };
    model.bodies.iter().map(shape).collect()
}

/// A body of a machine that stands about an electrode and its blisk.
#[derive(Debug, Clone)]
pub struct MachineBody {
    /// Shape of the body in the coordinates of its carrier.
    pub shape: Arc<RenderMesh>,
    /// Part of the machine that carries the body.
    pub carrier: Carrier,
    /// From the coordinates of its carrier to W in the final pose.
    pub stand: DAffine3,
    /// Chain that moves the body.
    pub chain: Chain,
    /// Whether something comes too close to it.
    pub is_in_the_way: bool,
}

impl MachineBody {
    /// `body` of the machine that stands as `station` says; `simulation` tells what comes too close to it.
    pub fn standing(body: &BodyShape, station: &Station, simulation: Option<&Simulation>) -> Self {
        Self {
            shape: body.shape.clone(),
            carrier: body.carrier,
            stand: station.placement(body.carrier),
            chain: station.chain(),
            is_in_the_way: simulation.is_some_and(|s| s.is_in_the_way(&body.name)),
        }
    }

    /// Where the body is at `pose` of the electrode, as seen from the blisk.
    pub fn placement(&self, pose: &Pose) -> DAffine3 {
        self.chain.seen_from_blisk(self.carrier, pose) * self.stand
    }
}

/// Where the pair that keeps its clearance least meets, if it does not keep what is asked for: the two points in W at
/// that instant, as seen from the blisk.
pub fn meeting(simulation: &Simulation) -> Option<(Place, [DVec3; 2])> {
    let pair = simulation.tightest().filter(|pair| !pair.holds())?;
    let place = pair.contact.unwrap_or(pair.least);
    let carrier = |name: &str| match simulation.bodies().iter().find(|body| body.name == name) {
        Some(body) => body.carrier,
        None if name == "electrode" => Carrier::Electrode,
        None => Carrier::Table,
    };
    let at = |name: &str, p: DVec3| simulation.chain().seen_from_blisk(carrier(name), &place.pose).transform_point3(p);
    Some((place, [at(&pair.moving, place.on_moving), at(&pair.fixed, place.on_fixed)]))
}

/// A moment of a whole motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// Axis values, with the turn to the channel in A.
    pub pose: Pose,
    /// Phase of the motion.
    pub phase: Phase,
    /// Channel that the electrode is in or on the way to.
    pub channel: usize,
    /// Withdrawn distance on the feed (mm), where the electrode stands on it: in the feed, and on its way back.
    pub s: Option<f64>,
}

impl Moment {
    /// What is done where, for a reader.
    pub fn name(&self) -> String {
        let on_the_way = if self.phase == Phase::Index { "to channel" } else { "channel" };
        format!("{}, {on_the_way} {}", self.phase.name(), self.channel)
    }
}

/// A whole motion along its way: millimetres of slide or degrees of turn, whichever are more.
#[derive(Debug, Clone, Default)]
pub struct WholeMotion {
    legs: Vec<Leg>,
    /// The way to every pose of every leg.
    ways: Vec<Vec<f64>>,
    /// Withdrawn distances of the rows of the feed (mm).
    withdrawn: Vec<f64>,
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
        let withdrawn = simulation.chain().refined(&feed.rows).iter().map(|row| row.s).collect();
        Self { legs, ways, withdrawn }
    }

    /// Length of the whole way.
    pub fn length(&self) -> f64 {
        self.ways.last().and_then(|ways| ways.last()).copied().unwrap_or(0.0)
    }

    /// What is done in which channel from where to where, in order.
    pub fn phases(&self) -> impl Iterator<Item = (Phase, usize, [f64; 2])> {
        let span = |ways: &Vec<f64>| [ways.first(), ways.last()].map(|w| w.copied().unwrap_or(0.0));
        self.legs.iter().zip(&self.ways).map(move |(leg, ways)| (leg.phase, leg.channel, span(ways)))
    }

    /// What is done at `way`.
    pub fn at(&self, way: f64) -> Option<Moment> {
        let i = self.ways.partition_point(|ways| ways.last().is_some_and(|end| *end < way));
        let i = i.min(self.legs.len().checked_sub(1)?);
        let (leg, ways) = (&self.legs[i], &self.ways[i]);
        let k = ways.partition_point(|w| *w <= way).clamp(1, ways.len().max(2) - 1);
        let row = match (ways.get(k - 1), ways.get(k)) {
            (Some(from), Some(to)) if to > from => (k - 1) as f64 + ((way - from) / (to - from)).clamp(0.0, 1.0),
            (Some(_), Some(_)) => k as f64,
            _ if leg.poses.is_empty() => return None,
            _ => 0.0,
        };
        Some(Moment {
            pose: leg.pose_at(row),
            phase: leg.phase,
            channel: leg.channel,
            s: self.withdrawn(leg.phase, row),
        })
    }

    /// Withdrawn distance at `row` of a leg (mm), as far as that goes along the feed.
    fn withdrawn(&self, phase: Phase, row: f64) -> Option<f64> {
        let last = self.withdrawn.len().checked_sub(1)?;
        let row = match phase {
            Phase::Feed => row,
            // It goes back from the last row.
            Phase::Retract => last as f64 - row,
            Phase::Approach | Phase::Copying | Phase::Index => return None,
        };
        if !(0.0..=last as f64).contains(&row) {
            return None;
        }
        let from = (row as usize).min(last);
        let (from, to, t) = (self.withdrawn[from], self.withdrawn[(from + 1).min(last)], row - from as f64);
        Some(from + t * (to - from))
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
    use glam::DMat3;
    use nc::fixtures;

    #[test]
    fn the_whole_motion_is_stepped_through_without_a_jump() {
        let (feed, turn) = (fixtures::path(), fixtures::PITCH_DEG.to_radians());
        let simulation = fixtures::simulation();
        let [up, out, first] = simulation.approach() else { panic!("{:?}", simulation.approach()) };
        let motion = WholeMotion::new(&simulation, &feed, None);
        let phases: Vec<_> = motion.phases().collect();
        assert_eq!(phases.len(), 7);
        assert!(phases.windows(2).all(|pair| pair[0].2[1] == pair[1].2[0]));
        let (down, inwards) = (up.z - out.z, (out.x - first.x).abs());
        assert!(down > 10.0 && (inwards - 10.0).abs() < 1e-9, "{down} {inwards}");
        assert!(phases[0].2[0] == 0.0 && (phases[0].2[1] - down - inwards).abs() < 1e-9, "{:?}", phases[0]);
        let index = phases[3];
        assert!(
            index.0 == Phase::Index && (index.2[1] - index.2[0] - fixtures::PITCH_DEG).abs() < 1e-9,
            "degrees, where it only turns"
        );
        let Moment { pose, phase, channel, s } = motion.at(2.5).unwrap();
        assert_eq!((phase, channel, s), (Phase::Approach, 3, None), "not on the feed yet");
        assert!((pose.z - (up.z - 2.5)).abs() < 1e-9);
        // The end of the second feed is the final pose of the next channel.
        let Moment { pose, phase, channel, s } = motion.at(phases[5].2[1]).unwrap();
        assert_eq!((phase, channel, s), (Phase::Feed, 4, Some(0.0)));
        assert!((pose.a - turn).abs() < 1e-12 && pose.x == 0.0);
        assert_eq!(motion.at(motion.length() + 1.0).unwrap().phase, Phase::Retract);
        let steps = 4000;
        let poses: Vec<Pose> =
            (0..=steps).map(|i| motion.at(motion.length() * i as f64 / steps as f64).unwrap().pose).collect();
        let most = poses.windows(2).map(|p| way_between(&p[0], &p[1])).fold(0.0, f64::max);
        assert!(most <= motion.length() / steps as f64 + 1e-9, "{most}");
    }

    #[test]
    fn the_bed_turns_back_as_seen_from_the_blisk_and_the_head_does_not_tilt() {
        let pose = Pose { x: 3.0, a: 0.4, b: 0.2, c: -0.3, ..Pose::FINAL };
        let (o, p) = (DVec3::new(1.0, 2.0, 90.0), DVec3::new(5.0, -7.0, 30.0));
        let at = |carrier| {
            let shape = Arc::new(RenderMesh::new(&Default::default()));
            let chain = Chain::new(o, None);
            MachineBody { shape, carrier, stand: DAffine3::IDENTITY, chain, is_in_the_way: false }
                .placement(&pose)
                .transform_point3(p)
        };
        let turned = DMat3::from_rotation_x(0.4);
        assert!((at(Carrier::Bed) - turned * p).length() < 1e-12);
        assert!((at(Carrier::Head) - turned * (p + DVec3::new(3.0, 0.0, 0.0))).length() < 1e-12);
        assert_eq!(at(Carrier::Table), p);
        assert!((at(Carrier::Electrode) - pose.placement(o).transform_point3(p)).length() < 1e-12);
    }
}
