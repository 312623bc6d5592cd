//! Floor 3: how an electrode gets into its channel and out again: poses, constraints, objective, strategies,
//! interpolation and the verification certificate.

pub mod angle_test;
pub mod axis_curve;
mod baselines;
pub mod centreline;
pub mod clearance;
pub mod climb;
pub mod copying;
mod even;
pub mod four_distances;
pub mod genetic;
pub mod global;
pub mod interpolation;
pub mod jam;
pub mod leftover;
pub mod machine;
pub mod machine_model;
mod mend;
pub mod objective;
pub mod outside;
pub mod path;
pub mod plan;
pub mod plan_params;
mod planner;
pub mod pose;
pub mod prepared;
pub mod probes;
pub mod quantise;
pub mod replay;
pub mod samples;
pub mod search;
pub mod simulation;
pub mod sizing;
pub mod smoothness;
pub mod strategy;
pub mod verify;
mod watch;

pub use verify::certificate;
