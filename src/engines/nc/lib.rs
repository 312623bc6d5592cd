//! Output for machines: approval of paths, NC programs through posts, burn tables, electrode files.

pub mod approved;
pub mod approved_flank;
pub mod block_feed;
pub mod burn_csv;
pub mod burn_example;
pub mod burn_table;
pub mod cutter_locations;
pub mod electrode_files;
#[cfg(any(test, feature = "fixtures"))]
pub mod electrode_fixtures;
#[cfg(any(test, feature = "fixtures"))]
pub mod fixtures;
pub mod flank_job;
pub mod flank_program;
pub mod job_file;
pub mod lines;
pub mod measuring_points;
pub mod path_csv;
pub mod post;
pub mod program;
pub mod setup_sheet;
pub mod step_files;
pub mod template;
