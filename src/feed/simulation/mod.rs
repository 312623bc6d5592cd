//! The whole motion of one electrode on its machine: approach, feed, copying, retraction, and the same again for other
//! channels after the blisk was turned to them by A.
//!
//! Every body that moves is tested against every body that it could meet: electrode, holder and head against blisk,
//! table and bed; electrode and holder, which C and B turn, against the head; blisk and table, which A turns, against
//! the bed. Clearances are certified as that of a feed is: over the continuous motion, with every axis linear
//! between two poses. The electrode in the blisk's channel is the matter of the feed's own certificate, which stands in
//! the list beside the others. What is not tested: bodies that are carried by the same axes or fixed to each other,
//! cables, hoses and doors that no one has described. The blisk is taken as
//! finished: of stock, before and during the burn, nothing is known here.
//!
//! A blisk looks the same from every channel, if its mesh does: that is proven first, triangle by triangle, and what the
//! two are apart is taken off the clearances. Where it is not so, every channel is tested by itself. Tables and beds need
//! not look the same, and are tested in every channel.

mod approach;
mod bodies;
mod copies;
mod periodic;
mod run;
#[cfg(test)]
mod tests;
mod tour;

use glam::DVec3;
use serde::Serialize;

use super::certificate::Certificate;
use super::machine::MachineParams;
use super::machine_model::{Body, MachineModel};
use super::path::FeedPath;
use super::pose::{Axis, Pose};
use crate::blisk::electrode::Electrode;
use crate::geometry::mesh::Mesh;
use crate::progress::{Cancel, Cancelled, Progress};
pub use approach::Approach;
use bodies::Bodies;
use run::Run;
pub use tour::{Leg, Phase};

/// What is simulated.
pub struct Scenario<'a> {
    /// The finished blisk in W.
    pub blisk: &'a Mesh,
    /// Number of channels.
    pub channels: usize,
    /// The channel that the feed was planned in.
    pub own_channel: usize,
    /// The electrode.
    pub electrode: &'a Electrode,
    /// Its feed with the certificate.
    pub feed: (&'a FeedPath, &'a Certificate),
    /// Its copying motion with the certificate, if there is one.
    pub copying: Option<(&'a FeedPath, &'a Certificate)>,
    /// Travels and speeds.
    pub machine: &'a MachineParams,
    /// The bodies.
    pub model: &'a MachineModel,
}

/// How it is simulated.
#[derive(Debug, Clone, PartialEq)]
pub struct SimulationOptions {
    /// Which channels are burnt, by their numbers in the blisk.
    pub channels: Vec<usize>,
    /// How far out of the blisk the electrode is taken before it moves across (mm).
    pub clear_mm: f64,
    /// How close proven bounds come to the smallest clearance met (mm).
    pub resolution_mm: f64,
    /// The same for bodies that are farther apart than they have to be, as a share of what they are so.
    pub resolution_share: f64,
}

impl SimulationOptions {
    /// The usual ones for these channels.
    pub fn of(channels: Vec<usize>) -> Self {
        Self { channels, clear_mm: 10.0, resolution_mm: 0.005, resolution_share: 0.01 }
    }
}

/// Where two bodies are how near, in the words of the whole motion.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Place {
    /// Distance (mm).
    pub distance: f64,
    /// What the machine is doing.
    pub phase: Phase,
    /// In which channel, or on the way to which.
    pub channel: usize,
    /// Position in the phase: `3.25` is a quarter of the way from pose 3 to pose 4.
    pub row: f64,
    /// Axis values.
    pub pose: Pose,
    /// The point on the moving body, where it is in the final pose, in W (mm).
    pub on_moving: DVec3,
    /// The point on the other body, in the final pose, in W (mm).
    pub on_fixed: DVec3,
}

/// The clearance of two bodies over the whole motion.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PairReport {
    /// The body that moves.
    pub moving: String,
    /// The other.
    pub fixed: String,
    /// In which part of the motion, if not in all.
    pub during: Option<&'static str>,
    /// Clearance asked for (mm).
    pub required: f64,
    /// Proven clearance (mm).
    pub certified: f64,
    /// The smallest clearance met.
    pub least: Place,
    /// The first instant at which they touch, if they do.
    pub contact: Option<Place>,
}

impl PairReport {
    /// Whether the clearance is proven to be what is asked for.
    pub fn holds(&self) -> bool {
        self.certified > 0.0 && self.certified >= self.required
    }
}

/// An axis that would have to go beyond its travel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct OutOfTravel {
    /// The axis.
    pub axis: Axis,
    /// Doing what.
    pub phase: Phase,
    /// In which channel.
    pub channel: usize,
    /// Where it would have to go (mm or rad).
    pub value: f64,
    /// Where its travel ends (mm or rad).
    pub limit: f64,
}

/// A channel of the motion.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Visit {
    /// Which.
    pub channel: usize,
    /// What is added to A there (rad).
    pub turn: f64,
}

/// What was found out about the whole motion.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Simulation {
    /// [`FeedPath::digest`] of the feed that was simulated.
    pub path_digest: String,
    /// The same of the copying motion, if there is one.
    pub copying_digest: Option<String>,
    /// Poses from the clear position to the first row of the feed; the retraction goes back through them.
    pub approach: Vec<Pose>,
    /// The channels in the order in which they are burnt.
    pub visits: Vec<Visit>,
    /// Channels that were asked for and that A does not reach.
    pub out_of_reach: Vec<usize>,
    /// Every pair of bodies, the ones that come nearest to what is asked for first.
    pub pairs: Vec<PairReport>,
    /// The first pose beyond the travel of an axis.
    pub travel: Option<OutOfTravel>,
    /// Least time of the whole motion at the axes' greatest speeds, without burning (min).
    pub minutes: f64,
    /// How far apart the blisk's mesh and itself are when it is turned by channels (mm); none if they differ.
    pub period_error: Option<f64>,
    /// [`MachineModel::digest`] of the bodies.
    pub model_digest: String,
    /// The bodies of the machine in W, where they are in the final pose.
    #[serde(skip)]
    pub bodies: Vec<Body>,
}

impl Simulation {
    /// Whether everything keeps its clearance within the travel of the axes, in every channel that was asked for.
    pub fn holds(&self) -> bool {
        self.pairs.iter().all(PairReport::holds) && self.travel.is_none() && self.out_of_reach.is_empty()
    }

    /// Of the pairs that do not keep what is asked for the worst; if there are none, of those with a body of the machine
    /// the one that comes nearest to it.
    pub fn tightest(&self) -> Option<&PairReport> {
        let failing = self.pairs.iter().filter(|p| !p.holds());
        let bodies = self.pairs.iter().filter(|p| p.during.is_none());
        failing.chain(bodies).next()
    }

    /// The legs of the whole motion in order, for showing.
    pub fn legs(&self, feed: &FeedPath, copying: Option<&FeedPath>) -> Vec<Leg> {
        tour::whole(&self.approach, feed, copying, &self.visits)
    }

    /// Whether the body called `name` is in a pair that does not keep what is asked for.
    pub fn is_in_the_way(&self, name: &str) -> bool {
        self.pairs.iter().any(|p| !p.holds() && (p.moving == name || p.fixed == name))
    }

    /// What was found, in a sentence or two.
    pub fn sentence(&self) -> String {
        let channels = match self.visits.len() {
            1 => "one channel".to_owned(),
            n => format!("{n} channels"),
        };
        let mut text = match self.tightest() {
            None => format!("The machine has no bodies; the electrode stays clear of the blisk in {channels}."),
            Some(pair) if pair.holds() => format!(
                "Nothing collides in {channels}: {} clearances of bodies are proven, the least of the machine's own, of {} and \
                 {}, {} mm of {:.3} mm. The blisk is taken as finished.",
                self.pairs.len(),
                pair.moving,
                pair.fixed,
                floored(pair.certified),
                pair.required
            ),
            Some(pair) => self.pairs.iter().find(|p| p.contact.is_some()).unwrap_or(pair).complaint(),
        };
        if !self.out_of_reach.is_empty() {
            let list: Vec<String> = self.out_of_reach.iter().map(usize::to_string).collect();
            text += &format!(" The travel of A does not reach channel {}.", list.join(", "));
        }
        if let Some(beyond) = &self.travel {
            let of = |value: f64| if beyond.axis.is_rotary() { value.to_degrees() } else { value };
            let (letter, unit) = (beyond.axis.letter(), if beyond.axis.is_rotary() { "deg" } else { "mm" });
            text += &format!(
                " Axis {letter} would go to {:.3} {unit} in the {} of channel {}, beyond its travel to {:.3} {unit}.",
                of(beyond.value),
                beyond.phase.name(),
                beyond.channel,
                of(beyond.limit)
            );
        }
        text
    }
}

/// A proven clearance (mm) to three decimals, never rounded up.
fn floored(mm: f64) -> String {
    format!("{:.3}", (mm * 1e3).floor() / 1e3)
}

impl PairReport {
    fn complaint(&self) -> String {
        let Self { moving, fixed, required, certified, .. } = self;
        match &self.contact {
            Some(at) => format!(
                "COLLISION: {moving} meets {fixed} in the {} of channel {}, at row {:.3}.",
                at.phase.name(),
                at.channel,
                at.row
            ),
            None => format!(
                "TOO CLOSE: {moving} and {fixed} are proven to stay apart by {} mm only, of {required:.3} mm; \
                 the least, {:.3} mm, is in the {} of channel {}, at row {:.3}.",
                floored(*certified),
                self.least.distance,
                self.least.phase.name(),
                self.least.channel,
                self.least.row
            ),
        }
    }
}

/// Simulates the whole motion.
///
/// # Errors
/// [`Cancelled`]. A collision is an answer.
pub fn simulate(
    scenario: &Scenario,
    options: &SimulationOptions,
    progress: &Progress,
    cancel: &Cancel,
) -> Result<Simulation, Cancelled> {
    progress.report("simulation", 0.0, "bodies");
    let bodies = Bodies::new(scenario, cancel)?;
    let (visits, out_of_reach) = tour::visits(scenario, &options.channels);
    let run = Run { scenario, options, bodies: &bodies, cancel };
    let approach = run.approach()?;
    let period_error = periodic::error_of(scenario.blisk, visits.iter().map(|v| v.turn), cancel)?;
    let mut pairs = run.feed_pairs(period_error.unwrap_or(0.0));
    pairs.extend(run.all(&approach, &visits, period_error, progress)?);
    pairs.sort_by(|p, q| (p.certified - p.required).total_cmp(&(q.certified - q.required)));
    let legs = tour::whole(&approach.poses, scenario.feed.0, scenario.copying.map(|c| c.0), &visits);
    Ok(Simulation {
        path_digest: scenario.feed.0.digest(),
        copying_digest: scenario.copying.map(|(path, _)| path.digest()),
        travel: tour::out_of_travel(&legs, scenario.machine),
        minutes: tour::minutes(&legs, scenario.machine),
        approach: approach.poses,
        visits,
        out_of_reach,
        pairs,
        period_error,
        model_digest: scenario.model.digest(),
        bodies: bodies::placed(scenario),
    })
}
