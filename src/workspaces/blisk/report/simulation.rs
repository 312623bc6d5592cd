//! What the simulation of a whole motion found, as figures of a report and as text.

use std::fmt::Write;

use serde::Serialize;

use crate::workspaces::blisk::report::PoseReport;
use feed::simulation::{PairReport, Place, Simulation};

/// The whole motion of one electrode on its machine.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SimulationReport {
    /// What was found, in a sentence.
    pub sentence: String,
    /// Whether nothing comes too close or beyond the travel of an axis.
    pub holds: bool,
    /// The channels in the order in which they are burnt, with what is added to A there.
    pub channels: Vec<ChannelReport>,
    /// Channels that A does not reach.
    pub out_of_reach: Vec<usize>,
    /// Poses from the clear position to the first row of the feed.
    pub approach: Vec<PoseReport>,
    /// Least time at the axes' greatest speeds, without burning (min).
    pub least_minutes: f64,
    /// How far the blisk is from itself, turned by channels, at most (mm); none if the meshes of its channels differ,
    /// so that each was tested by itself.
    pub period_error_mm: Option<f64>,
    /// Every pair of bodies that may meet.
    pub pairs: Vec<PairFigures>,
}

/// A channel of the motion.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs)]
pub struct ChannelReport {
    pub channel: usize,
    pub a_deg: f64,
}

/// Two bodies and their clearance.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs)]
pub struct PairFigures {
    pub moving: String,
    pub fixed: String,
    /// Part of the motion, if not all of it.
    pub during: Option<&'static str>,
    pub holds: bool,
    pub required_mm: f64,
    /// Proven lower bound.
    pub certified_mm: f64,
    /// The smallest clearance met, and where.
    pub least_mm: f64,
    pub least_at: PlaceReport,
    /// The first instant at which they touch, if they do; on the way from channel to channel that of the widest way
    /// where channels are alike.
    pub contact: Option<PlaceReport>,
}

/// An instant of the motion.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs)]
pub struct PlaceReport {
    pub phase: &'static str,
    pub channel: usize,
    /// `3.25` is a quarter of the way from pose 3 of the phase to pose 4.
    pub row: f64,
    pub pose: PoseReport,
    /// Point on the moving body where it is in the final pose, in W (mm).
    pub on_moving: [f64; 3],
    /// Point on the other body in the final pose, in W (mm).
    pub on_fixed: [f64; 3],
}

impl PlaceReport {
    fn of(place: &Place) -> Self {
        Self {
            phase: place.phase.name(),
            channel: place.channel,
            row: place.row,
            pose: PoseReport::from(&place.pose),
            on_moving: place.on_moving.to_array(),
            on_fixed: place.on_fixed.to_array(),
        }
    }
}

impl PairFigures {
    fn of(pair: &PairReport) -> Self {
        Self {
            moving: pair.moving.clone(),
            fixed: pair.fixed.clone(),
            during: pair.during,
            holds: pair.holds(),
            required_mm: pair.required,
            certified_mm: pair.certified,
            least_mm: pair.least.distance,
            least_at: PlaceReport::of(&pair.least),
            contact: pair.contact.as_ref().map(PlaceReport::of),
        }
    }

    /// The two and when, e.g. `chuck and blisk`.
    fn name(&self) -> String {
        let during = self.during.map(|d| format!(" ({d})")).unwrap_or_default();
        format!("{} and {}{during}", self.moving, self.fixed)
    }

    fn place(&self) -> String {
        let at = self.contact.as_ref().unwrap_or(&self.least_at);
        let touch = if self.contact.is_some() { "touch at " } else { "" };
        format!("{touch}{} of channel {}, row {:.2}", at.phase, at.channel, at.row)
    }
}

impl SimulationReport {
    /// The figures of `simulation`.
    pub fn of(simulation: &Simulation) -> Self {
        let channel = |v: &feed::simulation::Visit| ChannelReport { channel: v.channel, a_deg: v.turn.to_degrees() };
        Self {
            sentence: simulation.sentence(),
            holds: simulation.holds(),
            channels: simulation.visits().iter().map(channel).collect(),
            out_of_reach: simulation.out_of_reach().to_vec(),
            approach: simulation.approach().iter().map(PoseReport::from).collect(),
            least_minutes: simulation.minutes(),
            period_error_mm: simulation.period_error(),
            pairs: simulation.pairs().iter().map(PairFigures::of).collect(),
        }
    }

    /// The report as text for the terminal.
    pub fn text(&self) -> String {
        let mut out = String::new();
        for p in &self.pairs {
            let verdict = if p.holds { "" } else { "   TOO CLOSE" };
            let _ = writeln!(
                out,
                "{:<44} certified {:>9.4} mm of {:>7.4} mm   {}{verdict}",
                p.name(),
                p.certified_mm,
                p.required_mm,
                p.place()
            );
        }
        let _ = writeln!(out, "least time without burning {:.1} min", self.least_minutes);
        out + &self.sentence
    }
}
