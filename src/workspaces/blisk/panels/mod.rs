//! The panels of the workspace.

pub mod cursor;
pub mod export_dialog;
pub mod forms;
pub mod inspector;
pub mod kept_runs;
pub mod machine_bodies;
pub mod machine_motion;
pub mod moved_dialog;
pub mod node_table;
pub mod overlay;
pub mod plots;
pub mod scene_tree;
pub mod sizes;
pub mod step_facts;
pub mod stepper;
pub mod swept;
pub mod timeline;
pub mod tuning;
pub mod view;
