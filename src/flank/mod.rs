//! Floor 3: five-axis flank milling of ruled surfaces. Pure: no files, no window.

pub mod joint_feed;
pub mod joint_path;
pub mod linearise;
pub mod milling_machine;
pub mod singular;
pub mod tool_path;

#[cfg(test)]
#[path = "machine_tests.rs"]
mod machine_tests;
