//! Floor 4: results as files: path CSV, NC programs through posts, electrodes with their burn tables, and reports.
//!
//! An NC program can only be made from an [`approved::Approved`] path, and that only from a certificate that
//! holds for exactly this path. What is verified is exactly what is written, because a path is rounded to the
//! decimals of the files ([`crate::feed::quantise`]) before it is verified.

pub mod approved;
pub mod approved_flank;
mod burn_csv;
mod burn_example;
pub mod burn_table;
pub mod burn_template;
pub mod choice;
pub mod comparison;
mod comparison_html;
pub mod electrode_files;
pub mod electrode_folder;
pub mod electrode_report;
mod electrode_report_html;
pub mod export_folder;
pub mod files;
pub mod flank_cl;
pub mod flank_nc;
pub mod flank_report;
mod flank_report_html;
pub mod leftover_report;
pub mod nc;
pub mod nc_feed;
mod nc_lines;
mod nc_tour;
pub mod path_csv;
pub mod post;
pub mod report;
mod report_curves;
mod report_html;
mod report_tables;
pub mod simulation_report;
pub mod svg_plot;
pub mod uncut_ply;
pub mod verify_report;

pub(crate) use crate::feed::quantise;

#[cfg(test)]
pub(crate) mod electrode_fixtures;
#[cfg(test)]
pub(crate) mod fixtures;
