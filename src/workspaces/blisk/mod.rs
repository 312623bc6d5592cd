//! Feed paths of electrodes into the channels of a blisk.

pub mod commands;
pub mod desk;
pub mod document;
pub mod export;
pub mod job;
pub mod panels;
pub mod paths;
pub mod report;
pub mod scene;
pub mod work;
pub mod workspace;

pub use desk::BliskDesk;
pub use workspace::BliskWorkspace;
