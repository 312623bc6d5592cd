//! The results of P1.

use super::{Outcome, ReproduceError};
use task::Task;

/// The tables and figures of the paper.
pub(super) fn results(_task: &Task) -> Result<Vec<Outcome>, ReproduceError> {
    Ok(Vec::new())
}
