//! A whole plan: first locations, axis surface, compensation over every rank, refinement, checks.

use super::FlankError;
use super::compensation::RankCurve;
use super::cutter::FlankCutter;
use super::offset::CutterLocation;
use super::params::FlankParams;
use super::path::FlankPath;
use super::ruled_surface::RuledSurface;
use crate::progress::{Cancel, Progress};

/// A path and those that it came from.
#[derive(Debug, Clone, PartialEq)]
pub struct FlankPlan {
    /// The cutter.
    pub cutter: FlankCutter,
    /// What was asked.
    pub params: FlankParams,
    /// The locations by offset.
    pub locations: Vec<CutterLocation>,
    /// The path through them.
    pub initial: FlankPath,
    /// Sums over ranks.
    pub ranks: RankCurve,
    /// The path of the best rank.
    pub chosen: FlankPath,
    /// The path made best in the objective; the chosen one again if no rounds were asked for.
    pub refined: FlankPath,
    /// What the reader must know, in words.
    pub warnings: Vec<String>,
}

impl FlankPlan {
    /// The paths and their names: initial, chosen, refined.
    pub fn paths(&self) -> [(&'static str, &FlankPath); 3] {
        [("initial", &self.initial), ("chosen", &self.chosen), ("refined", &self.refined)]
    }
}

/// Plans a flank path.
///
/// # Errors
/// [`FlankError`] that says what is wrong with surface, cutter or parameters; cancelled.
pub fn plan_flank(
    surface: &RuledSurface,
    cutter: &FlankCutter,
    params: &FlankParams,
    progress: &Progress,
    cancel: &Cancel,
) -> Result<FlankPlan, FlankError> {
    params.validate()?;
    cutter.fits(surface)?;
    progress.report("flank locations", 0.0, "");
    cancel.check()?;
    Err(FlankError::Singular("the plan, not yet written,"))
}
