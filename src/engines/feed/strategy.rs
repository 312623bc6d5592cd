//! The interface of a strategy: a way to search the path of an electrode, with its parameters.

use glam::DVec3;

use super::pose::Axis;
use super::problem::{Candidate, Convergence, Node, NodeTask, SearchOutcome, SearchProblem};
use task::{Cancel, Cancelled, Task};
use wheel::channel::Surface;

/// A symbol of the papers, or a parameter, as reports list it.
#[derive(Debug, Clone, PartialEq)]
pub struct StrategySymbol {
    /// The symbol.
    pub symbol: String,
    /// Meaning of the symbol.
    pub meaning: &'static str,
    /// Value of the symbol, in `unit`.
    pub value: f64,
    /// The unit; `1` for none.
    pub unit: &'static str,
}

impl StrategySymbol {
    pub(super) fn new(symbol: impl Into<String>, meaning: &'static str, value: f64, unit: &'static str) -> Self {
        Self { symbol: symbol.into(), meaning, value, unit }
    }
}

/// Free candidates for a node, best first, and the convergence of their search.
pub type Candidates = Result<(Vec<Candidate>, Convergence), Cancelled>;

/// A search for a path, implemented by the parameters of the strategy.
///
/// A strategy either searches node by node, from the final pose outwards, and implements
/// [`candidates`](Self::candidates); or it searches the whole path at once, and implements
/// [`whole_path`](Self::whole_path).
pub trait SearchStrategy: Sync {
    /// Free candidates for the node of `at`, best first, with the convergence of their search.
    ///
    /// # Errors
    /// [`Cancelled`].
    fn candidates(&self, _problem: &SearchProblem, at: &NodeTask, _cancel: &Cancel) -> Candidates {
        Ok((Vec::new(), Convergence::none(at.s)))
    }

    /// Whether the strategy searches the whole path at once.
    fn is_whole(&self) -> bool {
        false
    }

    /// The whole path, starting near the path `known` if that has nodes. Called only if the strategy [is
    /// whole](Self::is_whole).
    ///
    /// # Errors
    /// [`Cancelled`].
    fn whole_path(
        &self,
        _problem: &SearchProblem,
        known: &[Node],
        _surface_of: &dyn Fn(DVec3) -> Surface,
        _task: &Task,
    ) -> Result<SearchOutcome, Cancelled> {
        Ok(SearchOutcome { nodes: known.to_vec(), convergence: Vec::new(), jam: None })
    }

    /// The path of `nodes` after the verifier has asked for more clearance, moved as a whole if the strategy can do
    /// that.
    ///
    /// # Errors
    /// [`Cancelled`].
    fn polished(&self, _problem: &SearchProblem, nodes: Vec<Node>, _cancel: &Cancel) -> Result<Vec<Node>, Cancelled> {
        Ok(nodes)
    }

    /// Whether nodes follow the centreline of the channel in steps of arc length, and not the X axis.
    fn follows_centreline(&self) -> bool {
        false
    }

    /// Key of the table of the strategy's own parameters; none of a strategy without parameters.
    fn parameters(&self) -> Option<&'static str> {
        None
    }

    /// Parameters for reports.
    fn symbols(&self) -> Vec<StrategySymbol> {
        Vec::new()
    }

    /// Symbols for reports of an axis that moves by up to `half` either way in one step (mm or rad).
    fn axis_symbols(&self, _axis: Axis, _half: f64) -> Vec<StrategySymbol> {
        Vec::new()
    }
}
