//! Where a user's own lists are kept.

use std::path::PathBuf;

/// The folder of the user's settings and lists, if the system has one: `mold.sparkpath`, `holders.toml` and the folder
/// `holders` are looked for in it.
pub fn user_folder() -> Option<PathBuf> {
    Some(directories::ProjectDirs::from("", "", "sparkpath")?.config_dir().to_owned())
}
