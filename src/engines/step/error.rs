//! Errors of STEP files.

use task::Cancelled;

/// Reason why a STEP file gives no solids.
#[derive(Debug, thiserror::Error)]
pub enum StepError {
    /// The text breaks the rules of ISO 10303-21.
    #[error("it is no STEP file that can be read: {problem}; export it again from the CAD program")]
    Syntax {
        /// Message of the reader, with the place.
        problem: String,
    },
    /// The file would take more than is allowed.
    #[error("{found} {what} exceed the limit of {limit}; leave out what is not needed, or allow a coarser tolerance")]
    TooLarge {
        /// Quantity that exceeds the limit.
        what: &'static str,
        /// How much the file asks for.
        found: u64,
        /// How much is allowed.
        limit: u64,
    },
    /// There is nothing with faces in it.
    #[error("it holds no solid and no closed surface ({found}); export the part as a solid")]
    NoSolid {
        /// Number of faces and edges.
        found: String,
    },
    /// Cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
