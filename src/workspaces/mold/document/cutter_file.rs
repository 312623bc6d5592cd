//! Files of cutter libraries.

use std::path::Path;

use files::{FileError, TomlFile};
use mold::cutter::CutterLibrary;

/// A library of cutters: a list `[[cutter]]` with the keys of [`Cutter`](mold::cutter::Cutter).
pub const CUTTERS: TomlFile<CutterLibrary> = TomlFile::new("library of cutters");

/// The library that the program brings along.
///
/// # Errors
/// [`FileError`], if the program was built with a file that is none.
pub fn standard_cutters() -> Result<CutterLibrary, FileError> {
    CUTTERS.parse(include_str!("../../../../assets/cutters/standard.toml"), Path::new("standard.toml"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use mold::cutter::CutterKind;

    #[test]
    fn the_standard_library_has_flat_and_ball_cutters() {
        let library = standard_cutters().unwrap();
        let count = |kind| library.cutter.iter().filter(|c| c.kind() == kind).count();
        assert_eq!((count(CutterKind::Flat), count(CutterKind::Ball), count(CutterKind::BullNose)), (4, 4, 0));
    }

    #[test]
    fn a_library_is_read_as_it_was_written() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("mine.toml");
        let mut library = standard_cutters().unwrap();
        library.cutter[0].name = "roughing \"big\"".to_owned();
        library.cutter[1].reach_mm = Some(12.5);
        library.cutter[1].holder_diameter_mm = Some(20.0);
        CUTTERS.write(&file, &library).unwrap();
        assert_eq!(CUTTERS.read(&file).unwrap(), library);
        assert!(CUTTERS.write(&file, &CutterLibrary::default()).unwrap_err().to_string().contains("no cutter"));
        assert_eq!(CUTTERS.read(&file).unwrap(), library, "what cannot be written takes nothing away");
    }

    #[test]
    fn what_is_no_library_is_answered_with_the_place_and_the_reason() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("mine.toml");
        for (text, words) in [
            ("[[cutter]]\ndiameter_mm = 0.0\n", "line 2: cutter[0].diameter_mm is 0: must be from"),
            ("[[cutter]]\ndiameter_mm = -3.0\n", "cutter[0].diameter_mm is -3"),
            ("[[cutter]]\ndiameter_mm = 3.0\nradius = 1\n", "line 3"),
            ("[[cutter]\n", "line 1"),
            ("", "no cutter"),
        ] {
            std::fs::write(&file, text).unwrap();
            let said = CUTTERS.read(&file).unwrap_err().to_string();
            assert!(said.contains("mine.toml") && said.contains(words), "{text:?}: {said}");
        }
        assert!(CUTTERS.read(&folder.path().join("none.toml")).unwrap_err().is_not_found());
    }
}
