//! Floor 3: how an electrode gets into its channel and out again: poses, constraints, objective, strategies,
//! interpolation and the verification certificate.

pub mod angle_test;
pub mod certificate;
pub mod clearance;
pub mod copying;
pub mod genetic;
pub mod interpolation;
pub mod jam;
pub mod leftover;
pub mod machine;
mod mend;
pub mod objective;
pub mod outside;
pub mod path;
pub mod plan;
pub mod plan_params;
mod planner;
pub mod pose;
pub mod probes;
pub mod quantise;
pub mod replay;
pub mod samples;
pub mod search;
pub mod smoothness;
pub mod verify;
