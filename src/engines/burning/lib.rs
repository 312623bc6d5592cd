//! Technology of die-sinking EDM: with which steps an electrode burns, how long that takes, how much the electrode
//! wears, and when each channel of a wheel is finished.
//!
//! [`TechnologyFile::estimate`](technology::TechnologyFile::estimate) answers minutes and wear of one electrode;
//! [`schedule::schedule`] puts them together to the hours of a wheel, [`duration::sum_of`] to those of a mold.
//!
//! - [`technology`] is the table of a machine, generator or supplier: steps with current, pulse, gap, rate and wear.
//! - [`rules`] has the default formulas, from which the built-in table ([`defaults::standard`]) was made.
//! - [`estimate`] is minutes and wear of an electrode in one call.
//! - [`choice`] has the task of an electrode; the steps of a table that suit it are taken and share its volume.
//! - [`duration`] gives minutes, with what they rest on and what is missing.
//! - [`wear`] gives the wear of electrodes, how many are needed, and which channels each of them burns.
//! - [`schedule`] puts the burns of all channels of a wheel in order.
//! - [`project`] has the choice of a technology in a project, [`figures`] what tables and reports show of a burn.
//!
//! A figure that a table does not have stays missing: results name it instead of taking it as zero. Lengths are in mm,
//! areas in mm², volumes in mm³, times in minutes, pulses in µs, currents in A.

pub mod choice;
pub mod defaults;
pub mod duration;
mod error;
pub mod estimate;
pub mod figures;
pub mod project;
pub mod rules;
pub mod schedule;
pub mod technology;
pub mod wear;

pub use error::BurningError;

/// The most rows of a schedule or of a list of burns.
pub const MOST_ROWS: usize = 100_000;
