//! Electrodes for what the cutters leave.
//!
//! A region of what is left is burned by the tip of an electrode: the part of a prism over the region that keeps the
//! spark gap from the mold. Where a mold's convex edges would leave the tip edges that no cutter makes (H-edges), the
//! region is divided. Everything here stands in the burn frame: the electrode comes down along -Z.

pub mod base;
pub mod burn_direction;
pub mod burn_time;
pub mod burning;
pub mod check;
pub mod clearance;
pub mod combine;
pub mod cut;
pub mod cuts;
pub mod design;
pub mod division;
pub mod family;
pub mod finding;
pub mod footprint;
pub mod given;
pub mod h_edge;
pub mod names;
pub mod params;
pub mod plan;
pub mod plan_checks;
pub mod residual_stock;
pub mod setting;
pub mod tip;

mod arrangement;
mod cut_lines;
mod earlier;
mod edits;
mod net_shape;
mod overhang;
mod part_numbers;
mod samples;
mod sharing;

#[cfg(test)]
mod arrangement_tests;
#[cfg(test)]
mod division_tests;
#[cfg(test)]
mod orbit_tests;
#[cfg(test)]
mod plan_tests;
#[cfg(test)]
mod residual_stock_tests;
#[cfg(test)]
mod stages_tests;
#[cfg(test)]
mod tests;
