//! What cutters leave uncut in a mold, and electrodes for it.

pub mod document;
pub mod export;
pub mod job;
pub mod panels;
pub mod report;
pub mod scene;
pub mod work;
