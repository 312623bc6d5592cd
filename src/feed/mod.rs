//! Floor 3: how an electrode gets into its channel and out again: poses, constraints, objective, strategies,
//! interpolation and the verification certificate.

pub mod certificate;
pub mod path;
pub mod pose;
pub mod verify;
