//! The three workspaces, each in a folder of its own.

pub mod blisk;
pub mod flank;
pub mod mold;
pub mod news;
pub mod worker;
