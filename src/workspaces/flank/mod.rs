//! Ruled flanks milled with the side of a cutter.

pub mod commands;
pub mod comparison;
pub mod document;
pub mod electrode_part;
pub mod export;
pub mod inputs;
pub mod panels;
pub mod paths;
pub mod report;
pub mod scene;
pub mod work;
pub mod workspace;

pub use workspace::FlankWorkspace;
