//! STEP files: solids with faces to closed triangle meshes.
//!
//! [`read`](read::read) takes AP203, AP214 and AP242. Each edge is sampled once, and the faces on both sides of it use the
//! same points, so that a solid closes whose faces share their edges.

pub mod error;
pub mod read;

pub use error::StepError;
