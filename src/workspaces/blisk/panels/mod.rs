//! The panels of the workspace.

pub mod burning;
pub mod channel_kinds;
pub mod dialogs;
pub mod entry_arrows;
pub mod forms;
pub mod inspector;
pub mod kept_runs;
pub mod meridian;
pub mod node_table;
pub mod overlay;
pub mod picks;
pub mod plots;
pub mod scan;
pub mod scene_tree;
pub mod sets;
pub mod sizes;
pub mod step_facts;
pub mod stepper;
pub mod timeline;
pub mod view;
