//! Floor 6: the window. It draws the document and what has been made of it, sends edits and commands, and computes
//! nothing. One file a panel; [`core::Core`] is what they all see.

mod commands;
mod core;
mod cursor;
mod dialogs;
mod export_dialog;
mod files;
mod flank;
mod folds;
mod forms;
mod inspector;
mod kept_runs;
mod machine_bodies;
mod machine_motion;
mod menu;
mod mold;
mod node_table;
mod overlay;
mod palette;
mod panel_parts;
mod pictures;
mod plots;
mod preferences;
mod record;
mod run;
mod scene_tree;
mod sizes;
mod startup;
mod status;
mod step_facts;
mod stepper;
mod swept;
mod system_dialogs;
mod theme;
mod timeline;
mod tuning;
mod viewport;
mod viewport_gpu;
mod workspace;

pub use commands::Command;
pub use flank::FlankDesk;
pub use mold::{Column, ElectrodeDesk, MoldDesk};
pub use preferences::{Preferences, ThemeChoice};
pub use run::{Folders, Opening, SparkpathApp};
pub use startup::{Window, preflight, run_window};
pub use workspace::Workspace;
