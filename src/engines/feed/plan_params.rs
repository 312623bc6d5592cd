//! Parameters of a plan, and reasons why a plan cannot be made.

use files::Invalid;
use serde::{Deserialize, Serialize};

use super::angle_test::AngleParams;
use super::axis_curve::CurveError;
use super::centreline::CentrelineParams;
use super::genetic::GeneticParams;
use super::global::GlobalParams;
use super::interpolation::{InterpolationError, InterpolationParams};
use super::objective::Weights;
use super::strategy::SearchStrategy;
use super::verify::VerifyError;
use geometry::distance_field::FieldError;
use geometry::exact::ExactMeshError;
use task::Cancelled;
use wheel::centreline::CentrelineError;
use wheel::electrode::{ElectrodeError, ElectrodeFace};

/// Lists the strategies: a variant of [`Strategy`], its name in project files and for a reader, and the parameters that
/// implement it, which are those of the plan or the genetic ones.
macro_rules! strategies {
    ($($(#[$doc:meta])* $strategy:ident: $name:literal, $label:literal, |$plan:pat_param, $genetic:pat_param| $params:expr;)+) => {
        /// Strategy by which a path is searched for.
        #[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
        pub enum Strategy { $($(#[$doc])* #[serde(rename = $name)] $strategy),+ }

        impl Strategy {
            /// Every strategy, in the order of the interface.
            pub const ALL: &'static [Self] = &[$(Self::$strategy),+];

            /// Name of the strategy in project files.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$strategy => $name),+ }
            }

            /// Name of the strategy for a reader.
            pub const fn label(self) -> &'static str {
                match self { $(Self::$strategy => $label),+ }
            }

            /// The strategy with its parameters.
            pub fn search<'a>(self, plan: &'a PlanParams, genetic: &'a GeneticParams) -> &'a dyn SearchStrategy {
                match self { $(Self::$strategy => { let ($plan, $genetic) = (plan, genetic); $params })+ }
            }
        }
    };
}

strategies! {
    /// The adaptive genetic algorithm of P0.
    Genetic: "genetic", "genetic", |_, genetic| genetic;
    /// Searches the widest path over many poses for each node, then polishes it as a whole.
    #[default]
    Global: "global", "global", |plan, _| &plan.global;
    /// Moves along the main direction as far as possible (Kang et al. 2018); for comparison.
    FreeTravel: "free-travel", "free travel", |_, _| &super::baselines::FreeTravel;
    /// Maximises the least distance at every node (Ayesta et al. 2016); for comparison.
    MaxMinDistance: "max-min-distance", "max. min. distance", |_, _| &super::baselines::MaxMinDistance;
    /// Follows the centreline of the channel, P1.
    Centreline: "centreline", "centreline", |plan, _| &plan.centreline;
}

impl Strategy {
    /// Strategy with this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|strategy| strategy.name() == name)
    }
}

/// Constraint that a pose must meet to count as free during the search. The verifier decides in the end.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Constraint {
    /// Signed distance to the finished surface of at least spark gap and margin at every sample.
    #[default]
    Distance,
    /// P0's comparison of the angles alpha and theta at the nearest wall point.
    Angle,
}

/// Least distances wanted of the sides of an electrode, P1's thresholds of its four distances (mm). In the final pose only the
/// spark gap is open: a threshold is asked for as far as 0.05 mm more for each mm withdrawn. Where spark gap and margin ask
/// for more, these hold. Edges of the blisk are tested with spark gap and margin alone.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Thresholds {
    /// Side that burns the low wall.
    pub low_wall_mm: f64,
    /// Side that burns the high wall.
    pub high_wall_mm: f64,
    /// Side that burns the hub.
    pub hub_mm: f64,
    /// Side that burns the shroud.
    pub shroud_mm: f64,
}

impl Thresholds {
    /// The threshold of a face of the electrode (mm); zero where it has none.
    pub fn of(&self, face: ElectrodeFace) -> f64 {
        match face {
            ElectrodeFace::LowWall => self.low_wall_mm,
            ElectrodeFace::HighWall => self.high_wall_mm,
            ElectrodeFace::HubSide => self.hub_mm,
            ElectrodeFace::ShroudSide => self.shroud_mm,
            _ => 0.0,
        }
    }
}

/// Parameters of a plan beyond those of its strategy.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PlanParams {
    /// Strategy of the search.
    pub strategy: Strategy,
    /// Constraint that a pose must meet during the search.
    pub constraint: Constraint,
    /// Distance between nodes along the main direction (mm).
    pub step_mm: f64,
    /// Distance by which the electrode is retracted out of the blisk (mm).
    pub exit_clearance_mm: f64,
    /// Clearance wanted beyond the spark gap as soon as the electrode has left its final pose (mm).
    pub margin_mm: f64,
    /// Clearances wanted of single sides of the electrode.
    pub thresholds: Thresholds,
    /// Size of a cell of the distance field (mm).
    pub field_cell_mm: f64,
    /// Weights of the objective.
    pub weights: Weights,
    /// Safety factors of the angle constraint.
    pub angle: AngleParams,
    /// The centreline strategy.
    pub centreline: CentrelineParams,
    /// Interpolation between nodes.
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
            thresholds: Thresholds::default(),
            field_cell_mm: 0.25,
            weights: Weights::default(),
            angle: AngleParams::default(),
            centreline: CentrelineParams::default(),
            interpolation: InterpolationParams::default(),
            global: GlobalParams::default(),
        }
    }
}

/// Reason why a plan cannot be made. A search without a path is a result, not an error.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PlanError {
    /// The plan was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// A parameter cannot be used.
    #[error(transparent)]
    Params(#[from] Invalid),
    /// The rows cannot keep to the curve.
    #[error(transparent)]
    Rows(#[from] InterpolationError),
    /// A distance field cannot be built.
    #[error(transparent)]
    Field(FieldError),
    /// A mesh cannot be searched.
    #[error(transparent)]
    Mesh(#[from] ExactMeshError),
    /// The electrode cannot be made.
    #[error(transparent)]
    Electrode(ElectrodeError),
    /// The nodes cannot be joined.
    #[error(transparent)]
    Curve(#[from] CurveError),
    /// The channel has no centreline.
    #[error(transparent)]
    Centreline(CentrelineError),
    /// The path cannot be verified.
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
    /// Checks that every parameter is within its range.
    pub fn validate(&self) -> Result<(), Invalid> {
        for (key, value, range) in [
            ("plan.step_mm", self.step_mm, [0.01, 10.0]),
            ("plan.exit_clearance_mm", self.exit_clearance_mm, [0.1, 200.0]),
            ("plan.margin_mm", self.margin_mm, [0.0, 5.0]),
            ("plan.thresholds.low_wall_mm", self.thresholds.low_wall_mm, [0.0, 5.0]),
            ("plan.thresholds.high_wall_mm", self.thresholds.high_wall_mm, [0.0, 5.0]),
            ("plan.thresholds.hub_mm", self.thresholds.hub_mm, [0.0, 5.0]),
            ("plan.thresholds.shroud_mm", self.thresholds.shroud_mm, [0.0, 5.0]),
            ("plan.field_cell_mm", self.field_cell_mm, [0.05, 2.0]),
            ("plan.centreline.safety_increase_mm", self.centreline.safety_increase_mm, [0.0, 5.0]),
        ] {
            Invalid::unless_within(key, value, range, "mm")?;
        }
        if self.constraint == Constraint::Angle && self.thresholds != Thresholds::default() {
            let why = "the constraint \"angle\" knows no distances: use \"distance\", or leave the thresholds at 0";
            return Err(Invalid::of("plan.thresholds", why));
        }
        self.weights.validate().map_err(|problem| problem.within("plan.weights"))?;
        self.angle.validate().map_err(|problem| problem.within("plan.angle"))?;
        self.global.validate().map_err(|problem| problem.within("plan.global"))?;
        self.interpolation.validate().map_err(|problem| problem.within("plan.interpolation"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_job_files() {
        for &strategy in Strategy::ALL {
            assert_eq!(serde_json::to_value(strategy).unwrap(), strategy.name());
            assert_eq!(Strategy::named(strategy.name()), Some(strategy));
        }
        assert_eq!(Strategy::named("Genetic"), None);
    }
}
