//! Jobs of the workspace: pure functions of their inputs.

pub mod compare;
pub mod divisions;
pub mod electrodes;
pub mod preview;
pub mod uncut;
