//! STEP files: solids with faces to closed triangle meshes, and closed meshes to solids with faces.
//!
//! [`read`](read::read) takes AP203, AP214 and AP242. Each edge is sampled once, and the faces on both sides of it use the
//! same points, so that a solid closes whose faces share their edges. [`write_step`](write::write_step) writes AP242 with
//! planes, cylinders, cones and fitted B-splines.

pub mod error;
pub mod read;
pub mod write;

pub use error::StepError;
