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
//! A blisk looks the same from every channel, if its mesh does: that is proven first, triangle by triangle, and what
//! the two are apart is taken off the clearances. Where it is not so, every channel is tested by itself. Tables and
//! beds need not look the same, and are tested in every channel.

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

pub use approach::Approach;
pub use findings::{PairReport, Place, Simulation};
pub use run::simulate;
pub use tour::{Leg, OutOfTravel, Phase, Visit};

use super::certificate::Certificate;
use super::machine::MachineParams;
use super::machine_model::MachineModel;
use super::path::FeedPath;
use super::preset::Preset;
use geometry::mesh::Mesh;
use wheel::electrode::Electrode;

/// Scenario of a simulation.
pub struct Scenario<'a> {
    /// The finished blisk in W.
    pub blisk: &'a Mesh,
    /// Number of channels.
    pub channels: usize,
    /// The channel that the feed was planned in.
    pub own_channel: usize,
    /// The electrode.
    pub electrode: &'a Electrode,
    /// How the electrode stands on its holder, of one whose feed makes up for that.
    pub preset: Option<&'a Preset>,
    /// Feed of the electrode with its certificate.
    pub feed: (&'a FeedPath, &'a Certificate),
    /// Copying motion of the electrode with its certificate, if there is one.
    pub copying: Option<(&'a FeedPath, &'a Certificate)>,
    /// Travels and speeds.
    pub machine: &'a MachineParams,
    /// The bodies.
    pub model: &'a MachineModel,
}

/// Options of a simulation.
#[derive(Debug, Clone, PartialEq)]
pub struct SimulationOptions {
    /// Numbers of the channels that are burnt.
    pub channels: Vec<usize>,
    /// Distance outside the blisk that the electrode is withdrawn to before it moves across (mm).
    pub clear_mm: f64,
    /// How close proven bounds come to the smallest clearance met (mm).
    pub resolution_mm: f64,
    /// How close they come for bodies that are farther apart than is asked for, as a share of the distance beyond that,
    /// where that is more.
    pub resolution_share: f64,
}

impl SimulationOptions {
    /// Default options for these channels.
    pub fn of(channels: Vec<usize>) -> Self {
        Self { channels, clear_mm: 10.0, resolution_mm: 0.005, resolution_share: 0.01 }
    }
}
