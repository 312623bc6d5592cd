//! Ruled flanks milled with the side of a cutter.

pub mod document;
pub mod electrode_part;
pub mod export;
pub mod inputs;
pub mod panels;
pub mod report;
pub mod scene;
pub mod work;
