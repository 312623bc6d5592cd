//! The three workspaces, each in a folder of its own.

pub mod blisk;
pub mod flank;
pub mod glances;
pub mod kept;
pub mod mold;
pub mod worker;
