//! How an electrode gets into its channel and out again: poses, constraints, objective, strategies,
//! interpolation and the verification certificate.

pub mod angle_test;
pub mod axis_curve;
mod baselines;
pub mod centreline;
pub mod chain;
pub mod clearance;
mod clearance_cache;
pub mod climb;
pub mod copying;
pub mod genetic;
pub mod global;
pub mod interpolation;
pub mod jam;
pub mod machine;
pub mod machine_model;
pub mod objective;
pub mod outside;
pub mod path;
mod path_repair;
pub mod plan;
pub mod plan_params;
pub mod planner;
pub mod pose;
pub mod prepared;
pub mod preset;
pub mod probes;
pub mod problem;
pub mod quantise;
pub mod replay;
pub mod residual_stock;
pub mod samples;
pub mod search;
mod setup;
pub mod simulation;
pub mod sizing;
pub mod smoothness;
pub mod strategy;
pub mod verify;
pub mod wall_clearances;

pub use verify::certificate;
