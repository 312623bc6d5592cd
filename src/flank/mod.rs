//! Five-axis flank milling of ruled surfaces.

pub mod fit_ruled;
