//! Program parts around the channel: the simulated approach, and the motion from one channel to the next.

use super::{Feeds, TurnedJob, Writer, check_axes, first_position, in_channel};
use crate::approved::Approved;
use crate::block_feed::{BlockFeed, Pace};
use crate::lines::NcError;
use crate::post::Post;
use feed::path::PathRow;
use feed::pose::{Axis, Pose};
use feed::quantise::{deg_text, floor_mm_text};
use feed::simulation::Simulation;

/// The F words outside the feed.
#[derive(Default)]
pub(super) struct TourFeeds {
    approach: Vec<BlockFeed>,
    leave: Vec<BlockFeed>,
    index: Vec<BlockFeed>,
}

impl TourFeeds {
    /// For the simulated motion of `approved` at `mm_per_min`; none if it was not simulated.
    ///
    /// # Errors
    /// The number of a block whose F word would be 0.
    pub(super) fn new(approved: &Approved, pace: &Pace, mm_per_min: f64) -> Result<Self, usize> {
        let Some(simulation) = approved.simulation() else { return Ok(Self::default()) };
        let approach = rows(simulation.approach());
        let leave: Vec<PathRow> = approach.iter().rev().copied().collect();
        let index = simulation.visits().windows(2).enumerate().map(|(i, pair)| {
            let clear = simulation.approach().first().copied().unwrap_or(Pose::FINAL);
            let at = |turn: f64| Pose { a: clear.a + turn, ..clear };
            pace.block(&at(pair[0].turn), &at(pair[1].turn), mm_per_min).ok_or(i)
        });
        Ok(Self {
            approach: pace.blocks(&approach, mm_per_min)?,
            leave: pace.blocks(&leave, mm_per_min)?,
            index: index.collect::<Result<_, _>>()?,
        })
    }

    /// Each of them.
    pub(super) fn all(&self) -> impl Iterator<Item = &BlockFeed> + Clone {
        self.approach.iter().chain(&self.leave).chain(&self.index)
    }
}

fn rows(poses: &[Pose]) -> Vec<PathRow> {
    poses.iter().map(|&pose| PathRow { node: 0, s: 0.0, pose }).collect()
}

/// Makes sure that a machine with bodies was simulated with them, with the clearance that is asked for and on the side
/// that the electrode enters from, and that its axes go wherever the motion does.
pub(super) fn check(approved: &Approved, post: &Post, job: &TurnedJob) -> Result<(), NcError> {
    let machine = &job.machine;
    if !machine.comes_from(approved.enters_from()) {
        let (from, along) = (approved.enters_from().words(), machine.head_along.axis().letter());
        return Err(NcError::HeadComesFromElsewhere { from, along });
    }
    let Some(simulation) = approved.simulation() else {
        return if machine.has_bodies() { Err(NcError::NotSimulated) } else { Ok(()) };
    };
    if machine.has_bodies() && !simulation.with_bodies() {
        return Err(NcError::NotSimulated);
    }
    let other = |simulated: String, asked: String| Err(NcError::OtherMachineSimulated { simulated, asked });
    let [simulated, asked] = [simulation.body_clearance_mm(), machine.body_clearance_mm];
    if simulated.is_nan() || simulated < asked {
        return other(format!("a body clearance of {simulated} mm"), format!("one of {asked} mm"));
    }
    let [was, is] = [simulation.mounting(), machine.mounting(approved.enters_from())];
    if was != is {
        return other(was.to_string(), is.to_string());
    }
    let legs = simulation.legs(approved.path(), approved.copying().map(|copying| &copying.path));
    legs.iter().try_for_each(|leg| check_axes(&job.chain, &rows(&leg.poses), post, machine))
}

/// Comments on the simulation.
pub(super) fn header(w: &mut Writer, approved: &Approved) {
    let Some(simulation) = approved.simulation() else { return };
    if let Some(pair) = simulation.tightest() {
        w.comment(&format!(
            "Simulated with the bodies of the machine, approach and retraction included: none comes nearer than {} mm",
            floor_mm_text(pair.certified)
        ));
    }
    let sense = if w.counts_backwards(Axis::A) { -1.0 } else { 1.0 };
    let channels =
        simulation.visits().iter().map(|v| format!("{} at A {}", v.channel, deg_text(sense * v.turn + 0.0, 6)));
    w.comment(&format!("Channels: {}", channels.collect::<Vec<_>>().join(", ")));
}

/// Every channel: there, in, out and back to the clear position.
pub(super) fn motion(w: &mut Writer, approved: &Approved, simulation: &Simulation, feeds: &Feeds) {
    let approach = rows(simulation.approach());
    let Some(clear) = approach.first() else { return };
    for (i, visit) in simulation.visits().iter().enumerate() {
        w.turn = visit.turn;
        if i == 0 {
            first_position(w, &clear.pose, feeds);
        } else {
            w.comment(&format!("Section INDEX: A turns the blisk to channel {}", visit.channel));
            w.moves(std::iter::once(clear), &feeds.tour.index[i - 1..]);
        }
        w.comment(&format!("Section CHANNEL {} begins: simulated approach from the clear position", visit.channel));
        w.moves(approach.iter().skip(1), &feeds.tour.approach);
        in_channel(w, approved, feeds);
        w.comment("Simulated retraction to the clear position");
        w.moves(approach.iter().rev().skip(1), &feeds.tour.leave);
        w.comment(&format!("Section CHANNEL {} ends", visit.channel));
    }
    w.turn = 0.0;
}
