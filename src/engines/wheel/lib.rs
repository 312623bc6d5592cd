//! What a blisk is. Finds its axis, period and channels in a bare mesh, makes electrodes for a
//! channel, and makes parametric blisks.

pub mod blade_sections;
mod by_hand;
pub mod cad_faces;
pub mod centreline;
pub mod channel;
pub mod electrode;
pub mod error;
pub mod find_channel;
#[cfg(any(test, feature = "fixtures"))]
pub mod fixtures;
pub mod frame;
mod inscribed;
pub mod inspect;
pub mod nurbs_wall;
pub mod options;
pub mod parametric;
pub mod passage;
pub mod profile;
pub mod section_deviation;
pub mod sections;
pub mod surface_finder;
pub mod surfaces;
