//! The whole motion: what is done in a channel, and the way from one to the next.

use std::f64::consts::TAU;

use serde::Serialize;

use super::{OutOfTravel, Scenario, Visit};
use crate::feed::machine::MachineParams;
use crate::feed::path::FeedPath;
use crate::feed::pose::{Axis, Pose};
use crate::feed::quantise::quantise_rad;

/// What the machine is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Phase {
    /// From the clear position to the first row of the feed.
    Approach,
    /// The feed to the final pose.
    Feed,
    /// The copying motion along the walls.
    Copying,
    /// The feed and the approach backwards.
    Retract,
    /// Turning the blisk to the next channel.
    Index,
}

impl Phase {
    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Approach => "approach",
            Self::Feed => "feed",
            Self::Copying => "copying motion",
            Self::Retract => "retraction",
            Self::Index => "indexing",
        }
    }
}

/// A part of the motion, linear in every axis between its poses.
#[derive(Debug, Clone, PartialEq)]
pub struct Leg {
    /// What is done.
    pub phase: Phase,
    /// In which channel, or on the way to which.
    pub channel: usize,
    /// The poses in order, with the turn to the channel in A.
    pub poses: Vec<Pose>,
}

impl Leg {
    /// The pose at `row`; `3.25` is a quarter of the way from pose 3 to pose 4.
    pub fn pose_at(&self, row: f64) -> Pose {
        let last = self.poses.len().saturating_sub(1);
        let i = (row.max(0.0) as usize).min(last);
        let (from, to) = (self.poses[i], self.poses[(i + 1).min(last)]);
        from.lerp(&to, row - i as f64)
    }
}

/// The poses of `rows` with the turn to a channel.
fn turned(poses: impl Iterator<Item = Pose>, turn: f64) -> Vec<Pose> {
    // Without a turn they keep every bit.
    poses.map(|p| if turn == 0.0 { p } else { Pose { a: p.a + turn, ..p } }).collect()
}

fn rows(path: &FeedPath) -> impl DoubleEndedIterator<Item = Pose> {
    path.rows.iter().map(|row| row.pose)
}

/// Approach, feed and copying in a channel. The retraction goes back the same way and keeps the same clearances.
pub(super) fn channel_legs(approach: &[Pose], feed: &FeedPath, copying: Option<&FeedPath>, visit: &Visit) -> Vec<Leg> {
    let leg = |phase, poses| Leg { phase, channel: visit.channel, poses };
    let mut legs = vec![
        leg(Phase::Approach, turned(approach.iter().copied(), visit.turn)),
        leg(Phase::Feed, turned(rows(feed), visit.turn)),
    ];
    legs.extend(copying.map(|path| leg(Phase::Copying, turned(rows(path), visit.turn))));
    legs
}

/// The ways between the channels, at the clear position.
pub(super) fn index_legs(approach: &[Pose], visits: &[Visit]) -> Vec<Leg> {
    let Some(clear) = approach.first() else { return Vec::new() };
    let at = |visit: &Visit| if visit.turn == 0.0 { *clear } else { Pose { a: clear.a + visit.turn, ..*clear } };
    let leg =
        |pair: &[Visit]| Leg { phase: Phase::Index, channel: pair[1].channel, poses: vec![at(&pair[0]), at(&pair[1])] };
    visits.windows(2).map(leg).collect()
}

/// The longest way between two channels, from the first turned to 0: on a blisk whose channels are alike the others are
/// parts of it.
pub(super) fn widest_index_leg(approach: &[Pose], visits: &[Visit]) -> Option<Leg> {
    let widest = visits.windows(2).max_by(|p, q| (p[1].turn - p[0].turn).total_cmp(&(q[1].turn - q[0].turn)))?;
    let from = Visit { turn: 0.0, ..widest[0] };
    let to = Visit { turn: widest[1].turn - widest[0].turn, ..widest[1] };
    index_legs(approach, &[from, to]).pop()
}

/// The whole motion in order.
pub(super) fn whole(approach: &[Pose], feed: &FeedPath, copying: Option<&FeedPath>, visits: &[Visit]) -> Vec<Leg> {
    let mut index = index_legs(approach, visits).into_iter();
    let mut legs = Vec::new();
    for visit in visits {
        legs.extend(channel_legs(approach, feed, copying, visit));
        // The last pose of the approach is the first of the feed.
        let back = rows(feed).rev().chain(approach.iter().rev().skip(1).copied());
        legs.push(Leg { phase: Phase::Retract, channel: visit.channel, poses: turned(back, visit.turn) });
        legs.extend(index.next());
    }
    legs
}

/// The turns of A to the `channels`, in rising order, and the channels that A does not reach. A channel may be reached
/// from either side.
pub(super) fn visits(scenario: &Scenario, channels: &[usize]) -> (Vec<Visit>, Vec<usize>) {
    let [least, most] = scenario.machine.travel(Axis::A);
    let poses = rows(scenario.feed.0).chain(scenario.copying.into_iter().flat_map(|(path, _)| rows(path)));
    let [from, to] = poses.fold([0.0f64, 0.0f64], |[from, to], p| [from.min(p.a), to.max(p.a)]);
    let (mut visits, mut out_of_reach) = (Vec::new(), Vec::new());
    let total = scenario.channels.max(1);
    for &channel in channels {
        let ahead = (channel % total + total - scenario.own_channel % total) % total;
        let turn = TAU * ahead as f64 / total as f64;
        let within = |turn: &f64| turn + from >= least - 1e-9 && turn + to <= most + 1e-9;
        // The shorter way round first.
        let ways = if 2 * ahead > total { [turn - TAU, turn] } else { [turn, turn - TAU] };
        match ways.map(quantise_rad).into_iter().find(within) {
            Some(turn) => visits.push(Visit { channel, turn }),
            None => out_of_reach.push(channel),
        }
    }
    visits.sort_by(|p, q| p.turn.total_cmp(&q.turn));
    (visits, out_of_reach)
}

/// The first pose beyond the travel of an axis.
pub(super) fn out_of_travel(legs: &[Leg], machine: &MachineParams) -> Option<OutOfTravel> {
    let limits = machine.limits();
    legs.iter().find_map(|leg| {
        leg.poses.iter().find_map(|pose| {
            let (axis, limit) = limits.beyond(pose)?;
            let (phase, channel) = (leg.phase, leg.channel);
            Some(OutOfTravel { axis, phase, channel, value: pose.get(axis), limit })
        })
    })
}

/// All that A goes through in `legs`, for bodies that nothing else moves: it is continuous, so that they take every
/// place between the least and the greatest.
pub(super) fn turned_leg(legs: &[Leg]) -> Option<Leg> {
    const STEP: f64 = 0.1;
    let last = legs.last()?;
    let turns = || legs.iter().flat_map(|leg| &leg.poses).map(|pose| pose.a);
    let (least, most) = (turns().fold(f64::INFINITY, f64::min), turns().fold(f64::NEG_INFINITY, f64::max));
    let steps = ((most - least) / STEP).ceil().max(1.0) as usize;
    let at = |i: usize| Pose { a: least + (most - least) * i as f64 / steps as f64, ..Pose::FINAL };
    (least <= most).then(|| Leg { phase: Phase::Index, channel: last.channel, poses: (0..=steps).map(at).collect() })
}

/// Least time of the motion (min) with every axis within its speed.
pub(super) fn minutes(legs: &[Leg], machine: &MachineParams) -> f64 {
    legs.iter().flat_map(|leg| leg.poses.windows(2)).map(|pair| machine.least_minutes(&pair[0], &pair[1]).0).sum()
}
