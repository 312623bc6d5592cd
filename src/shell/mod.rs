//! The frame of the window: menus, the switch between workspaces, palette, dialogs, log, preferences, copies of unsaved
//! work. It knows workspaces only through [`Workspace`](crate::workspaces::workspace::Workspace) and computes nothing.

pub mod dialogs;
pub mod files;
pub mod menu;
pub mod palette;
pub mod pictures;
pub mod run;
pub mod startup;
pub mod status;
pub mod study;
pub mod system_dialogs;

pub use crate::workspaces::preferences::{Preferences, ThemeChoice};
pub use run::{Folders, Opening, SparkpathApp};
pub use startup::{Window, preflight, run_window};
