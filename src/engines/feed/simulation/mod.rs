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
mod findings;
mod pace;
mod periodic;
mod run;
#[cfg(test)]
mod tests;
mod tour;

use super::certificate::Certificate;
use super::machine::MachineParams;
use super::machine_model::MachineModel;
use super::path::FeedPath;
pub use approach::Approach;
use bodies::Bodies;
use findings::Findings;
pub use findings::{OutOfTravel, PairReport, Place, Simulation, Visit};
use geometry::mesh::Mesh;
use run::Run;
use task::{Cancel, Cancelled, Progress};
pub use tour::{Leg, Phase};
use wheel::electrode::Electrode;

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
    /// How close they come for bodies that are farther apart than is asked for, as a share of the distance beyond that,
    /// where that is more.
    pub resolution_share: f64,
}

impl SimulationOptions {
    /// The usual ones for these channels.
    pub fn of(channels: Vec<usize>) -> Self {
        Self { channels, clear_mm: 10.0, resolution_mm: 0.005, resolution_share: 0.01 }
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
    let period_error = periodic::error_of(scenario.blisk, visits.iter().map(|v| v.turn), cancel)?;
    let run = Run { scenario, options, bodies: &bodies, visits: &visits, period_error, cancel };
    let copies = run.copies()?;
    progress.report("simulation", 0.0, "approach");
    let approach = run.approach(&copies)?;
    let mut pairs = Vec::new();
    // Without a feed there is nothing to say of any pair.
    if !scenario.feed.0.rows.is_empty() {
        pairs.extend(run.feed_pairs());
        pairs.extend(run.all(&approach, &copies, progress)?);
    }
    pairs.sort_by(|p, q| (p.certified - p.required).total_cmp(&(q.certified - q.required)));
    let legs = tour::whole(&approach.poses, scenario.feed.0, scenario.copying.map(|c| c.0), &visits);
    Ok(Simulation::of(Findings {
        path_digest: scenario.feed.0.digest(),
        copying_digest: scenario.copying.map(|(path, _)| path.digest()),
        blisk_digest: scenario.blisk.digest(),
        electrode_digest: scenario.electrode.mesh.digest(),
        travel: tour::out_of_travel(&legs, scenario.machine),
        minutes: tour::minutes(&legs, scenario.machine),
        approach: approach.poses,
        visits,
        out_of_reach,
        pairs,
        period_error,
        model_digest: scenario.model.digest(),
        with_bodies: scenario.machine.has_bodies(),
        body_clearance_mm: scenario.machine.body_clearance_mm,
        enters_from: scenario.electrode.enters_from,
        bodies: bodies::placed(scenario),
    }))
}
