//! The whole motion: the legs in a channel, and the index motion from one channel to the next.

use std::f64::consts::TAU;

use serde::Serialize;

use super::Scenario;
use crate::chain::Chain;
use crate::machine::MachineParams;
use crate::path::FeedPath;
use crate::pose::{Axis, Pose};
use crate::quantise::quantise_rad;

/// Phase of the whole motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Phase {
    /// Way from the clear position to the first row of the feed.
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
    /// Name of the phase.
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

/// A channel of the motion.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Visit {
    /// Number of the channel.
    pub channel: usize,
    /// Angle added to A there (rad).
    pub turn: f64,
}

/// An axis that would have to go beyond its travel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct OutOfTravel {
    /// The axis.
    pub axis: Axis,
    /// Phase of the motion.
    pub phase: Phase,
    /// Channel of the motion.
    pub channel: usize,
    /// Axis value that the motion needs (mm or rad).
    pub value: f64,
    /// End of the axis's travel (mm or rad).
    pub limit: f64,
}

/// A part of the motion, linear in every axis between its poses.
#[derive(Debug, Clone, PartialEq)]
pub struct Leg {
    /// Phase of the leg.
    pub phase: Phase,
    /// Channel of the motion, or the one that the blisk is turned to.
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

/// Approach and `paths` in a channel. The retraction goes back the same way and keeps the same clearances.
fn channel_legs(approach: &[Pose], paths: &[(Phase, Vec<Pose>)], visit: &Visit) -> Vec<Leg> {
    let leg = |phase, poses| Leg { phase, channel: visit.channel, poses };
    let first = leg(Phase::Approach, turned(approach.iter().copied(), visit.turn));
    let others = paths.iter().map(|(phase, poses)| leg(*phase, turned(poses.iter().copied(), visit.turn)));
    std::iter::once(first).chain(others).collect()
}

/// Legs in every channel, with the index motions between them.
fn through(approach: &[Pose], visits: &[Visit], in_channel: impl Fn(&Visit) -> Vec<Leg>) -> Vec<Leg> {
    let mut index = index_legs(approach, visits).into_iter();
    visits.iter().flat_map(|visit| in_channel(visit).into_iter().chain(index.next())).collect()
}

/// The ways between the channels, at the clear position.
fn index_legs(approach: &[Pose], visits: &[Visit]) -> Vec<Leg> {
    let Some(clear) = approach.first() else { return Vec::new() };
    let at = |visit: &Visit| if visit.turn == 0.0 { *clear } else { Pose { a: clear.a + visit.turn, ..*clear } };
    let leg =
        |pair: &[Visit]| Leg { phase: Phase::Index, channel: pair[1].channel, poses: vec![at(&pair[0]), at(&pair[1])] };
    visits.windows(2).map(leg).collect()
}

/// The feed and, if there is one, the copying motion, with the rows that the machine needs.
pub(super) fn paths(chain: &Chain, feed: &FeedPath, copying: Option<&FeedPath>) -> Vec<(Phase, Vec<Pose>)> {
    let poses = |path: &FeedPath| chain.refined(&path.rows).iter().map(|row| row.pose).collect();
    let paths = std::iter::once((Phase::Feed, feed)).chain(copying.map(|path| (Phase::Copying, path)));
    paths.map(|(phase, path)| (phase, poses(path))).collect()
}

/// The legs that pairs of bodies are tested on.
pub(super) struct Legs {
    /// The whole motion but the retractions, which keep the clearances of the way in.
    pub all: Vec<Leg>,
    /// Legs in the channel of the plan, whether it is burnt or not.
    pub own: Vec<Leg>,
    /// All that A goes through, for bodies that nothing else moves.
    pub turned: Option<Leg>,
}

impl Legs {
    /// Approach and `paths` in `visits`; `own_channel` is that of the plan.
    pub fn new(approach: &[Pose], paths: &[(Phase, Vec<Pose>)], own_channel: usize, visits: &[Visit]) -> Self {
        let all = through(approach, visits, |visit| channel_legs(approach, paths, visit));
        let own = channel_legs(approach, paths, &Visit { channel: own_channel, turn: 0.0 });
        Self { turned: turned_leg(&all), all, own }
    }

    /// The longest way between two channels: on a blisk whose channels are alike it passes whatever the others pass.
    pub fn widest_index(&self) -> Option<&Leg> {
        let width = |leg: &Leg| leg.poses.last().zip(leg.poses.first()).map_or(0.0, |(to, from)| to.a - from.a);
        let index = self.all.iter().filter(|leg| leg.phase == Phase::Index);
        // Of ways as wide as each other the first.
        index.rev().max_by(|p, q| width(p).total_cmp(&width(q)))
    }

    /// The first leg that takes A to `a`, and the row where it does.
    pub fn passing(&self, a: f64) -> Option<(&Leg, f64)> {
        self.all.iter().find_map(|leg| Some((leg, row_at(&leg.poses, a)?)))
    }
}

/// First instant with A at `a`.
fn row_at(poses: &[Pose], a: f64) -> Option<f64> {
    /// Tolerance for rounding at either end (rad).
    const ROUNDING: f64 = 1e-12;
    poses.windows(2).enumerate().find_map(|(i, pair)| {
        let [from, to] = [pair[0].a, pair[1].a];
        let passes = a >= from.min(to) - ROUNDING && a <= from.max(to) + ROUNDING;
        let share = if from == to { 0.0 } else { ((a - from) / (to - from)).clamp(0.0, 1.0) };
        passes.then_some(i as f64 + share)
    })
}

/// The whole motion in order.
pub(super) fn whole(approach: &[Pose], paths: &[(Phase, Vec<Pose>)], visits: &[Visit]) -> Vec<Leg> {
    let feed = paths.first().map_or(&[][..], |(_, poses)| poses);
    through(approach, visits, |visit| {
        let mut legs = channel_legs(approach, paths, visit);
        // The last pose of the approach is the first of the feed.
        let back = feed.iter().rev().copied().chain(approach.iter().rev().skip(1).copied());
        legs.push(Leg { phase: Phase::Retract, channel: visit.channel, poses: turned(back, visit.turn) });
        legs
    })
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
pub(super) fn out_of_travel(chain: &Chain, legs: &[Leg], machine: &MachineParams) -> Option<OutOfTravel> {
    let limits = machine.limits();
    legs.iter().find_map(|leg| {
        leg.poses.iter().find_map(|pose| {
            let pose = chain.machine_pose(pose);
            let (axis, limit) = limits.beyond(&pose)?;
            let (phase, channel) = (leg.phase, leg.channel);
            Some(OutOfTravel { axis, phase, channel, value: pose.get(axis), limit })
        })
    })
}

/// All that A goes through in `legs`, for bodies that nothing else moves: it is continuous, so that they take every
/// place between the least and the greatest.
fn turned_leg(legs: &[Leg]) -> Option<Leg> {
    const STEP: f64 = 0.1;
    let last = legs.last()?;
    let turns = || legs.iter().flat_map(|leg| &leg.poses).map(|pose| pose.a);
    let (least, most) = (turns().fold(f64::INFINITY, f64::min), turns().fold(f64::NEG_INFINITY, f64::max));
    let steps = ((most - least) / STEP).ceil().max(1.0) as usize;
    let at = |i: usize| Pose { a: least + (most - least) * i as f64 / steps as f64, ..Pose::FINAL };
    (least <= most).then(|| Leg { phase: Phase::Index, channel: last.channel, poses: (0..=steps).map(at).collect() })
}

/// Least time of the motion (min) with every axis within its speed.
pub(super) fn minutes(chain: &Chain, legs: &[Leg], machine: &MachineParams) -> f64 {
    let least = |pair: &[Pose]| machine.least_minutes(&chain.machine_pose(&pair[0]), &chain.machine_pose(&pair[1])).0;
    legs.iter().flat_map(|leg| leg.poses.windows(2)).map(least).sum()
}
