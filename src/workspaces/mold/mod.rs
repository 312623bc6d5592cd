//! What cutters leave uncut in a mold, and electrodes for it.

pub mod commands;
pub mod document;
pub mod export;
pub mod job;
pub mod panels;
pub mod paths;
pub mod report;
pub mod scene;
pub mod work;
pub mod workspace;

pub use workspace::MoldWorkspace;
