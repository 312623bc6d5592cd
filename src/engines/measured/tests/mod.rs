//! Tests from theory: scans of known surfaces, with known errors.

mod deviations;
mod fits;
pub(crate) mod meshes;
mod reading;
