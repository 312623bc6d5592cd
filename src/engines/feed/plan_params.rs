//! Parameters of a plan, and why a plan cannot be made.

use serde::{Deserialize, Serialize};

use super::angle_test::{AngleParams, AngleParamsError};
use super::axis_curve::CurveError;
use super::centreline::CentrelineParams;
use super::genetic::GeneticParamsError;
use super::global::{GlobalParams, GlobalParamsError};
use super::interpolation::{InterpolationError, InterpolationParams, InterpolationParamsError};
use super::machine::MachineError;
use super::objective::{Weights, WeightsError};
use super::search::{Constraint, Strategy};
use super::verify::VerifyError;
use geometry::distance_field::FieldError;
use geometry::exact::ExactMeshError;
use task::Cancelled;
use wheel::centreline::CentrelineError;
use wheel::electrode::ElectrodeError;

/// Parameters of a plan beyond those of its strategy.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PlanParams {
    /// How the path is searched for.
    pub strategy: Strategy,
    /// What a pose must meet during the search.
    pub constraint: Constraint,
    /// Distance between nodes along the main direction (mm).
    pub step_mm: f64,
    /// How far out of the blisk the electrode is withdrawn (mm).
    pub exit_clearance_mm: f64,
    /// Clearance wanted beyond the spark gap as soon as the electrode has left its final pose (mm).
    pub margin_mm: f64,
    /// Size of a cell of the distance field (mm).
    pub field_cell_mm: f64,
    /// Weights of the objective.
    pub weights: Weights,
    /// Safety factors of the angle constraint.
    pub angle: AngleParams,
    /// The centreline strategy.
    pub centreline: CentrelineParams,
    /// How nodes are joined.
    pub interpolation: InterpolationParams,
    /// The global strategy.
    pub global: GlobalParams,
}

impl Default for PlanParams {
    fn default() -> Self {
        Self {
            strategy: Strategy::default(),
            constraint: Constraint::Distance,
            step_mm: 0.5,
            exit_clearance_mm: 5.0,
            margin_mm: 0.0,
            field_cell_mm: 0.25,
            weights: Weights::default(),
            angle: AngleParams::default(),
            centreline: CentrelineParams::default(),
            interpolation: InterpolationParams::default(),
            global: GlobalParams::default(),
        }
    }
}

/// Why a plan cannot be made at all. That no path was found is not an error but an answer.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[allow(missing_docs)]
pub enum PlanError {
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    #[error("[plan] {key} = {value}: must be {range}")]
    Parameter { key: &'static str, value: f64, range: &'static str },
    #[error(transparent)]
    Weights(#[from] WeightsError),
    #[error(transparent)]
    Angle(#[from] AngleParamsError),
    #[error(transparent)]
    Interpolation(#[from] InterpolationParamsError),
    #[error(transparent)]
    Global(#[from] GlobalParamsError),
    #[error(transparent)]
    Rows(#[from] InterpolationError),
    #[error(transparent)]
    Genetic(#[from] GeneticParamsError),
    #[error(transparent)]
    Machine(#[from] MachineError),
    #[error(transparent)]
    Field(FieldError),
    #[error(transparent)]
    Mesh(#[from] ExactMeshError),
    #[error(transparent)]
    Electrode(ElectrodeError),
    #[error(transparent)]
    Curve(#[from] CurveError),
    #[error(transparent)]
    Centreline(CentrelineError),
    #[error(transparent)]
    Verify(VerifyError),
}

impl From<FieldError> for PlanError {
    fn from(error: FieldError) -> Self {
        match error {
            FieldError::Cancelled(cancelled) => cancelled.into(),
            other => Self::Field(other),
        }
    }
}

impl From<CentrelineError> for PlanError {
    fn from(error: CentrelineError) -> Self {
        match error {
            CentrelineError::Cancelled(cancelled) => cancelled.into(),
            other => Self::Centreline(other),
        }
    }
}

impl From<VerifyError> for PlanError {
    fn from(error: VerifyError) -> Self {
        match error {
            VerifyError::Cancelled(cancelled) => cancelled.into(),
            other => Self::Verify(other),
        }
    }
}

impl From<ElectrodeError> for PlanError {
    fn from(error: ElectrodeError) -> Self {
        match error {
            ElectrodeError::Cancelled(cancelled) => cancelled.into(),
            other => Self::Electrode(other),
        }
    }
}

impl PlanParams {
    /// Whether every parameter is within its range.
    pub fn validate(&self) -> Result<(), PlanError> {
        let within = |key, value: f64, least: f64, greatest: f64, range| {
            let ok = (least..=greatest).contains(&value);
            if ok { Ok(()) } else { Err(PlanError::Parameter { key, value, range }) }
        };
        within("step_mm", self.step_mm, 0.01, 10.0, "0.01 to 10 mm")?;
        within("exit_clearance_mm", self.exit_clearance_mm, 0.1, 200.0, "0.1 to 200 mm")?;
        within("margin_mm", self.margin_mm, 0.0, 5.0, "0 to 5 mm")?;
        within("field_cell_mm", self.field_cell_mm, 0.05, 2.0, "0.05 to 2 mm")?;
        let safety = self.centreline.safety_increase_mm;
        within("centreline.safety_increase_mm", safety, 0.0, 5.0, "0 to 5 mm")?;
        self.weights.validate()?;
        self.angle.validate()?;
        self.global.validate()?;
        Ok(self.interpolation.validate()?)
    }
}
