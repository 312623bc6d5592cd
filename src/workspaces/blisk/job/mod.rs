//! Jobs of the workspace: pure functions of their inputs.

pub mod burning;
pub mod compare;
pub mod design;
pub mod figures;
pub mod finish;
pub mod job_of_plan;
pub mod measured;
pub mod node_distances;
pub mod outcome;
pub mod plan;
pub mod plan_pictures;
pub mod planned;
pub mod prepared_blisk;
pub mod preset;
pub mod preview;
pub mod released;
mod remedy;
pub mod scan;
pub mod simulate;
pub mod sizing;
pub mod stages;
