//! Five-axis milling machines on a flank path: the machine as data, its kinematics, which positions it takes along the
//! path, the straight moves between them and their feed.
//!
//! `ToolPath + Kinematics -> joint_path -> MachinePath -> paces`; `export` writes programs of it.

pub mod joint_feed;
pub mod joint_path;
pub mod kinematics;
pub mod linearise;
pub mod milling_machine;
pub mod singular;
#[cfg(test)]
pub(crate) mod tests;
pub mod tool_path;
