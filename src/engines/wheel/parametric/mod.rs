//! Wheels made from parameters: for the demonstration, and as parts for tests.

#[cfg(any(test, feature = "fixtures"))]
mod blisk;
#[cfg(any(test, feature = "fixtures"))]
pub mod random;
pub(crate) mod welder;
pub mod wheel;

#[cfg(any(test, feature = "fixtures"))]
pub use blisk::{ChannelSide, MeshResolution, ParametricBlisk, ParametricError};

#[cfg(test)]
mod tests;
