//! Wheels made from parameters: for the demonstration, for the results of the papers, and as parts for tests.

mod blisk;
#[cfg(any(test, feature = "fixtures"))]
pub mod random;
pub(crate) mod welder;
pub mod wheel;

pub use blisk::{ChannelSide, MeshResolution, ParametricBlisk, ParametricError};

#[cfg(test)]
mod tests;
