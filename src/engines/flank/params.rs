//! Parameters of a flank path.

use serde::{Deserialize, Serialize};

use super::FlankError;
use super::compensation::Model;

/// Initial placing of the cutter.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum OffsetMethod {
    /// Touching both guides at the same u.
    TwoPoint,
    /// Touching both guides and the middle of the surface.
    #[default]
    ThreePoint,
}

/// Objective that a path minimises.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "least")]
pub enum Objective {
    /// The sum of the deviations' absolute values.
    #[default]
    Sum,
    /// The root of the mean of their squares.
    Rms,
    /// The sum, while no overcut and no undercut is greater than its bound.
    Bounded {
        /// Greatest overcut (mm); none for any.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        overcut_mm: Option<f64>,
        /// Greatest undercut (mm); none for any.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        undercut_mm: Option<f64>,
    },
}

/// Grid over which the deviations of each rank are summed to choose one.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SumOver {
    /// The grid of the design surface.
    #[default]
    Surface,
    /// An even grid over t and a of the axis surface, P4 (12). Its sum becomes less too where a path leaves the part.
    Axis,
}

/// Parameters of a flank path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FlankParams {
    /// Initial placing of the cutter.
    pub offset: OffsetMethod,
    /// Number of cutter locations, P4's m.
    pub locations: usize,
    /// Number of control points of each curve of the axis surface; around a closed surface the least.
    pub control_points: usize,
    /// Places along u and v of the design surface where deviations are taken.
    pub grid: [usize; 2],
    /// Whether locations go on past the ends of the guides until the whole surface is covered.
    pub is_covering: bool,
    /// Distance by which paths extend past the last place needed, in u.
    pub overrun_u: f64,
    /// How far the cutter's bottom reaches below the lower guide, along the axis (mm). Paths need some: locations move
    /// along the axis too, by less than 0.05 mm upwards and about as much downwards.
    pub below_mm: f64,
    /// Greatest sliding of the upper contact from the lower one, in u.
    pub slide_u: f64,
    /// Row of the matrix of the compensation, P4 (10) and (11).
    pub row: Model,
    /// Sum by which a rank is chosen, P4 (12).
    pub sum: SumOver,
    /// Objective that the refined path minimises.
    pub objective: Objective,
    /// Most rounds of refinement; 0 for none.
    pub rounds: usize,
    /// Overcut of neighbouring walls that is no gouge (mm).
    pub gouge_tolerance_mm: f64,
}

impl Default for FlankParams {
    fn default() -> Self {
        Self {
            offset: OffsetMethod::ThreePoint,
            locations: 50,
            control_points: 10,
            grid: [100, 50],
            is_covering: true,
            overrun_u: 0.005,
            below_mm: 0.1,
            slide_u: 0.25,
            row: Model::default(),
            sum: SumOver::default(),
            objective: Objective::Sum,
            rounds: 60,
            gouge_tolerance_mm: 0.01,
        }
    }
}

impl FlankParams {
    /// Most places of the grid.
    pub const MOST_PLACES: usize = 1_000_000;
    /// Most control points.
    pub const MOST_CONTROL_POINTS: usize = 100;
    /// Places of the grid that there must be for each control point.
    pub const PLACES_EACH: usize = 6;

    /// Whether a path can be planned so.
    ///
    /// # Errors
    /// [`FlankError::Parameter`] with the name of what is wrong.
    pub fn validate(&self) -> Result<(), FlankError> {
        let [nu, nv] = self.grid;
        let places = nu.saturating_mul(nv);
        let bounds = match self.objective {
            Objective::Bounded { overcut_mm, undercut_mm } => [overcut_mm, undercut_mm],
            _ => [None; 2],
        };
        let is_bound = |b: Option<f64>| b.is_none_or(|x| x.is_finite() && x >= 0.0);
        let one = |name, value: f64, fits: bool, wanted| {
            fits.then_some(()).ok_or(FlankError::Parameter { name, value, wanted })
        };
        let count = self.control_points;
        one("control_points", count as f64, (4..=Self::MOST_CONTROL_POINTS).contains(&count), "from 4 to 100")?;
        let enough = (count..=10_000).contains(&self.locations);
        one("locations", self.locations as f64, enough, "at least the number of control points, and at most 10000")?;
        one("grid", nu.min(nv) as f64, nu >= 2 && nv >= 2, "at least 2 places both ways")?;
        one("grid", places as f64, places <= Self::MOST_PLACES, "at most 1 million places in all")?;
        one("grid", places as f64, places >= Self::PLACES_EACH * count, "at least 6 places for each control point")?;
        one("overrun_u", self.overrun_u, (0.0..=0.1).contains(&self.overrun_u), "from 0 to 0.1")?;
        one("slide_u", self.slide_u, (1e-3..=0.5).contains(&self.slide_u), "from 0.001 to 0.5")?;
        one("rounds", self.rounds as f64, self.rounds <= 10_000, "at most 10000")?;
        let below = self.below_mm;
        one("below_mm", below, (0.0..=100.0).contains(&below), "from 0 to 100 mm")?;
        let tolerance = self.gouge_tolerance_mm;
        one("gouge_tolerance_mm", tolerance, (0.0..=1.0).contains(&tolerance), "from 0 to 1 mm")?;
        one("objective overcut_mm", bounds[0].unwrap_or(0.0), is_bound(bounds[0]), "a length in mm, 0 or more")?;
        one("objective undercut_mm", bounds[1].unwrap_or(0.0), is_bound(bounds[1]), "a length in mm, 0 or more")
    }
}
