//! Lists of cutters for flanks.

use std::path::Path;

use files::{FileError, Invalid, TomlFile, Validate};
use flank::cutter::FlankCutter;
use serde::{Deserialize, Serialize};

/// A list of cutters: `[[cutter]]` with the keys of [`FlankCutter`].
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CutterList {
    /// The cutters.
    #[serde(default)]
    pub cutter: Vec<FlankCutter>,
}

/// Most cutters of a list.
const MOST: usize = 100;

impl Validate for CutterList {
    fn validate(&self) -> Result<(), Invalid> {
        if self.cutter.is_empty() || self.cutter.len() > MOST {
            return Err(Invalid::of("cutter", format!("there are {}; give 1 to {MOST}", self.cutter.len())));
        }
        let one = |(i, cutter): (usize, &FlankCutter)| {
            cutter.validate().map_err(|e| Invalid::of(format!("cutter[{i}]"), e.to_string()))
        };
        self.cutter.iter().enumerate().try_for_each(one)
    }
}

/// Files of such lists; the user's own is called [`USER_CUTTERS`].
pub const CUTTERS: TomlFile<CutterList> = TomlFile::new("list of cutters for flanks");

/// Name of the user's list in the user's folder.
pub const USER_CUTTERS: &str = "flank_cutters.toml";

/// The user's list in `folder`, or else the one that the program brings along.
///
/// # Errors
/// [`FileError`], if the user's list is none.
pub fn user_cutters(folder: Option<&Path>) -> Result<CutterList, FileError> {
    let own = folder.map(|folder| CUTTERS.read_if_there(&folder.join(USER_CUTTERS))).transpose()?.flatten();
    own.map_or_else(standard_cutters, Ok)
}

/// The list that the program brings along.
///
/// # Errors
/// [`FileError`], if the program was built with a file that is none.
pub fn standard_cutters() -> Result<CutterList, FileError> {
    CUTTERS.parse(include_str!("../../../../assets/cutters/flank.toml"), Path::new("flank.toml"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_users_list_takes_the_place_of_the_standard_one_and_what_is_wrong_with_it_is_said() {
        let folder = tempfile::tempdir().unwrap();
        let standard = user_cutters(Some(folder.path())).unwrap();
        assert_eq!((user_cutters(None).unwrap(), standard.cutter.len()), (standard, 6));
        let file = folder.path().join(USER_CUTTERS);
        std::fs::write(&file, "[[cutter]]\nradius_mm = 1.5\nlength_mm = 20.0\n").unwrap();
        assert_eq!(user_cutters(Some(folder.path())).unwrap().cutter, [FlankCutter::cylinder(1.5, 20.0)]);
        for (text, words) in [("", "cutter"), ("[[cutter]]\nradius_mm = -1.0\nlength_mm = 20.0\n", "cutter[0]")] {
            std::fs::write(&file, text).unwrap();
            let said = user_cutters(Some(folder.path())).unwrap_err().to_string();
            assert!(said.contains(USER_CUTTERS) && said.contains(words), "{said}");
        }
    }
}
