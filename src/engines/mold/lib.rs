//! Molds: what a milling cutter that comes from above cannot reach.
//!
//! A mold stands with its opening upwards: cutters come down along -Z. What is left uncut is defined by the closing of
//! the mold's height by each cutter; the answer is the least of them over the library.

pub mod ball_agreement;
pub mod cutter;
pub mod datum;
pub mod demonstration;
pub mod electrode;
pub mod exact_fit;
pub mod height_field;
pub mod interference;
pub mod invert;
pub mod layers;
pub mod opening;
pub mod outline;
pub mod piece;
pub mod plane;
pub mod random_mold;
pub mod region;
pub mod rolling;
pub mod section;
pub mod stack;
pub mod surface;
pub mod uncut_layer;
pub mod uncut_region;
pub mod unseen;
pub mod warning;

mod capsule;
mod centre_path;
mod contact;
mod edge_grid;

#[cfg(any(test, feature = "fixtures"))]
pub mod fixtures;
