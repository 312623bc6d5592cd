//! The adaptive genetic strategy of P0: one node after the other, each pose the best of an evolved population
//! of free individuals.

pub mod coding;
mod evolution;

use files::Invalid;
use serde::{Deserialize, Serialize};

use super::pose::Axis;
use super::problem::{NodeTask, SearchProblem};
use super::strategy::{Candidates, SearchStrategy, StrategySymbol};
use coding::Coding;
pub use evolution::GeneticStep;
use task::Cancel;

/// Whether the circumferential reduction h is searched too.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ReductionMode {
    /// h is what the electrode was made with.
    #[default]
    Given,
    /// h is a variable of every node, on top of the electrode's reductions; the electrode is then made with the
    /// greatest h that any node took.
    Variable,
}

/// Parameters of the genetic strategy.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GeneticParams {
    /// Individuals.
    pub population: usize,
    /// Generations for each node, at most.
    pub generations: usize,
    /// Generations without a better objective after which the search of a node ends; 0 for none.
    pub stall_generations: usize,
    /// k1 = k3: probability of crossover of worse than average parents, falling to 0 for the best
    /// (Srinivas and Patnaik 1994).
    pub crossover: f64,
    /// k2 = k4: probability that a gene of a worse than average individual mutates, falling to 0 for the best
    /// (Srinivas and Patnaik 1994).
    pub mutation: f64,
    /// Best individuals that pass unchanged into the next generation.
    pub elite: usize,
    /// Precision of Y and Z in (8) (mm).
    pub precision_mm: f64,
    /// Precision of A, B, C and h in (8) (deg).
    pub precision_deg: f64,
    /// Whether h is given or variable.
    pub h: ReductionMode,
    /// Greatest h when it is variable (deg).
    pub h_max_deg: f64,
    /// Seed: the same seed gives the same path.
    pub seed: u64,
}

impl Default for GeneticParams {
    fn default() -> Self {
        Self {
            population: 60,
            generations: 40,
            stall_generations: 0,
            crossover: 0.9,
            mutation: 0.3,
            elite: 2,
            precision_mm: 0.001,
            precision_deg: 0.001,
            h: ReductionMode::Given,
            h_max_deg: 1.0,
            seed: 1,
        }
    }
}

impl SearchStrategy for GeneticParams {
    fn candidates(&self, problem: &SearchProblem, at: &NodeTask, cancel: &Cancel) -> Candidates {
        GeneticStep::new(self, problem, at).run(cancel)
    }

    fn parameters(&self) -> Option<&'static str> {
        Some("genetic")
    }

    fn symbols(&self) -> Vec<StrategySymbol> {
        vec![
            StrategySymbol::new("p_c", "k1 = k3: probability of crossover", self.crossover, "1"),
            StrategySymbol::new("p_m", "k2 = k4: probability of mutation of a gene", self.mutation, "1"),
        ]
    }

    fn axis_symbols(&self, axis: Axis, half: f64) -> Vec<StrategySymbol> {
        let precision = if axis.is_rotary() { self.precision_deg.to_radians() } else { self.precision_mm };
        let bits = Coding::new(-half, half, precision).bits;
        vec![StrategySymbol::new(format!("N_{}", axis.letter()), "bits of the code (8)", f64::from(bits), "bit")]
    }
}

impl GeneticParams {
    /// Whether every parameter is within its range.
    pub fn validate(&self) -> Result<(), Invalid> {
        [
            ("population", self.population as f64, [4.0, 1e4], ""),
            ("generations", self.generations as f64, [1.0, 1e4], ""),
            ("stall_generations", self.stall_generations as f64, [0.0, 1e4], ""),
            ("crossover", self.crossover, [0.0, 1.0], ""),
            ("mutation", self.mutation, [0.0, 1.0], ""),
            ("elite", self.elite as f64, [1.0, (self.population / 2) as f64], ""),
            ("precision_mm", self.precision_mm, [1e-5, 0.1], "mm"),
            ("precision_deg", self.precision_deg, [1e-5, 0.1], "deg"),
            ("h_max_deg", self.h_max_deg, [0.01, 20.0], "deg"),
        ]
        .into_iter()
        .try_for_each(|(key, value, range, unit)| Invalid::unless_within(key, value, range, unit))
        .map_err(|problem| problem.within("genetic"))
    }
}
