//! Floor 6: the window. It draws the document and what has been made of it, sends edits and commands, and computes
//! nothing. One file a panel; [`core::Core`] is what they all see.

pub mod autosave;
pub mod commands;
pub mod core;
pub mod dialogs;
pub mod files;
pub mod menu;
pub mod opening;
pub mod palette;
pub mod preferences;
pub mod recent;
pub mod record;
pub mod run;
pub mod startup;
pub mod status;
pub mod system_dialogs;
pub mod workspace;

pub use crate::workspaces::flank::panels::FlankDesk;
pub use crate::workspaces::mold::panels::{Column, ElectrodeDesk, MoldDesk};
pub use commands::Command;
pub use preferences::{Preferences, ThemeChoice};
pub use run::{Folders, Opening, SparkpathApp};
pub use startup::{Window, preflight, run_window};
pub use workspace::Workspace;
