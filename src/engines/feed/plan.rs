//! The plan for one electrode, and the settings that it is made with.

use std::sync::Arc;

use super::certificate::{Certificate, TravelVerdict};
use super::genetic::GeneticParams;
use super::interpolation::AxisCurves;
use super::jam::Jam;
use super::machine::MachineParams;
use super::path::FeedPath;
use super::plan_params::{PlanError, PlanParams};
use super::probes::SideDemand;
use super::problem::{Convergence, Node, Observe};
use super::smoothness::AxisSmoothness;
use super::strategy::SearchStrategy;
use super::verify::VerifyOptions;
use wheel::channel::Channel;
use wheel::electrode::{Electrode, ElectrodeError};

/// The plan for one electrode.
#[derive(Debug, Clone, PartialEq)]
pub struct FeedPlan {
    /// Nodes from the final pose outwards.
    pub nodes: Vec<Node>,
    /// Convergence of the search for each node.
    pub convergence: Vec<Convergence>,
    /// Place where the search jammed, if it did.
    pub jam: Option<Jam>,
    /// The path, if the electrode came out.
    pub path: Option<PlannedPath>,
    /// Additional circumferential reduction that the electrode was made with in the end (rad).
    pub h: f64,
    /// The electrode, if h made it another than the given one.
    pub remade: Option<Arc<Electrode>>,
    /// Full ranges of motion by (7), in the order of [`Axis`](crate::pose::Axis) (mm, rad).
    pub ranges: [f64; 6],
    /// Points tested for clearance in the last search.
    pub probes: usize,
    /// Searches made: the first, and one for each finding of the verifier that path repair could not remove.
    pub rounds: usize,
    /// Path repairs made after a finding of the verifier.
    pub repairs: usize,
    /// Time spent on the electrode's distance field (s).
    pub field_seconds: f64,
    /// Time in the search (s).
    pub search_seconds: f64,
    /// Time in the verification (s).
    pub verify_seconds: f64,
}

/// A path with its certificate and figures.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedPath {
    /// The curve of each axis.
    pub curves: AxisCurves,
    /// The rows.
    pub path: FeedPath,
    /// Certificate of the rows.
    pub certificate: Certificate,
    /// Smoothness of each axis, in the order of [`Axis`](crate::pose::Axis).
    pub smoothness: [AxisSmoothness; 6],
}

impl FeedPlan {
    /// Whether the electrode comes out on a path that the verifier certified.
    pub fn is_verified(&self) -> bool {
        self.path.as_ref().is_some_and(|p| p.certificate.holds())
    }

    /// The answer in one sentence.
    pub fn verdict(&self, channel: &Channel) -> String {
        match (&self.jam, &self.path) {
            (Some(jam), _) => jam.sentence(channel),
            (None, Some(PlannedPath { certificate: c, .. })) if c.holds() => {
                format!("has an extraction path, certified clearance {:.4} mm; {}", c.certified(), c.demand())
            }
            (None, Some(PlannedPath { certificate: c, .. })) if !c.ends_right() => {
                "has an extraction path that does not begin wholly outside the blisk; raise exit_clearance_mm"
                    .to_owned()
            }
            (None, Some(PlannedPath { certificate: c, .. })) if c.keeps_clearance() => match c.travel() {
                TravelVerdict::Beyond(beyond) => format!("has an extraction path, but {beyond}"),
                TravelVerdict::Within | TravelVerdict::NotJudged => "was not verified".to_owned(),
            },
            (None, Some(PlannedPath { certificate: c, .. })) => format!(
                "has an extraction path, but with a clearance of only {:.4} mm to the {}, {:.2} mm before the final \
                 pose; {}",
                c.least().distance,
                channel.surface_name(c.least().surface),
                c.least().s,
                c.demand()
            ),
            (None, None) => "was not planned".to_owned(),
        }
    }
}

/// Parameters of planning one electrode.
#[derive(Clone, Copy)]
pub struct PlanSettings<'a> {
    /// Search and interpolation.
    pub plan: &'a PlanParams,
    /// The genetic strategy.
    pub genetic: &'a GeneticParams,
    /// The machine.
    pub machine: &'a MachineParams,
    /// Verification.
    pub verify: &'a VerifyOptions,
    /// Spark gap (mm).
    pub spark_gap: f64,
    /// Whether the further reduction that would open a path is searched for where there is none, if the strategy can.
    pub explain: bool,
    /// Called with the nodes found so far after each of them.
    pub observe: &'a Observe<'a>,
}

impl PlanSettings<'_> {
    /// The strategy with its parameters.
    pub fn strategy(&self) -> &dyn SearchStrategy {
        self.plan.strategy.search(self.plan, self.genetic)
    }

    /// Clearances that are wanted of single sides of the electrode beyond those of all points.
    pub fn side_demand(&self) -> SideDemand {
        SideDemand { thresholds: self.plan.thresholds, common_mm: self.spark_gap + self.plan.margin_mm }
    }

    /// Whether every parameter is within its range.
    pub(super) fn validate(&self) -> Result<(), PlanError> {
        self.plan.validate()?;
        self.genetic.validate()?;
        Ok(self.machine.validate()?)
    }
}

/// Makes the electrode again with its walls drawn in by a further h (rad).
pub type Remake<'a> = dyn Fn(f64) -> Result<Electrode, ElectrodeError> + 'a;
