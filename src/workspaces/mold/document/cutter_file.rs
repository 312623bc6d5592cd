//! Files of cutter libraries.

use std::path::{Path, PathBuf};

use files::atomic::atomic_write;
use mold::cutter::{CutterError, CutterLibrary};

/// The largest file that is read (bytes).
const LARGEST_FILE: u64 = 1 << 20;
/// The most cutters of a library.
const MOST_CUTTERS: usize = 256;

/// Why a library of cutters cannot be had.
#[derive(Debug, thiserror::Error)]
pub enum CutterFileError {
    /// It cannot be read.
    #[error("{file}: cannot be read ({source}); check the path")]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// It is not what a library has to be.
    #[error("{file}: {problem}")]
    Invalid {
        /// The file.
        file: PathBuf,
        /// What is wrong and what to do, in one line.
        problem: String,
    },
    /// A cutter is not possible.
    #[error("{file}: {source}")]
    Cutter {
        /// The file.
        file: PathBuf,
        /// Which, and why.
        source: CutterError,
    },
}

/// The library that the program brings along.
///
/// # Errors
/// [`CutterFileError`], if the program was built with a file that is none.
pub fn standard_cutters() -> Result<CutterLibrary, CutterFileError> {
    parsed(Path::new("standard.toml"), include_str!("../../../../assets/cutters/standard.toml"))
}

/// The library in a TOML file: a list `[[cutter]]` with the keys of [`Cutter`](mold::cutter::Cutter).
///
/// # Errors
/// [`CutterFileError`].
pub fn read_cutters(file: &Path) -> Result<CutterLibrary, CutterFileError> {
    let unreadable = |source| CutterFileError::Unreadable { file: file.to_owned(), source };
    let size = std::fs::metadata(file).map_err(unreadable)?.len();
    if size > LARGEST_FILE {
        let problem = format!("it has {size} bytes; a library of cutters has at most {LARGEST_FILE}");
        return Err(CutterFileError::Invalid { file: file.to_owned(), problem });
    }
    parsed(file, &std::fs::read_to_string(file).map_err(unreadable)?)
}

/// Writes `library` as a TOML file that [`read_cutters`] reads.
///
/// # Errors
/// [`CutterFileError`], also of a library that could not be read again.
pub fn write_cutters(file: &Path, library: &CutterLibrary) -> Result<(), CutterFileError> {
    let invalid = |problem: String| CutterFileError::Invalid { file: file.to_owned(), problem };
    library.validate().map_err(|source| CutterFileError::Cutter { file: file.to_owned(), source })?;
    let text = toml::to_string_pretty(library).map_err(|e| invalid(e.to_string()))?;
    let unwritable = |e: std::io::Error| invalid(format!("cannot be written ({e}); choose another place"));
    atomic_write(file, |out| out.write_all(text.as_bytes())).map_err(unwritable)
}

fn parsed(file: &Path, text: &str) -> Result<CutterLibrary, CutterFileError> {
    let invalid = |problem: String| CutterFileError::Invalid { file: file.to_owned(), problem };
    let library: CutterLibrary = toml::from_str(text).map_err(|e| {
        let line = e.span().map_or(1, |span| text.bytes().take(span.start).filter(|b| *b == b'\n').count() + 1);
        invalid(format!("line {line}: {}", e.message().replace('\n', " ")))
    })?;
    if library.cutter.len() > MOST_CUTTERS {
        return Err(invalid(format!("it has {} cutters; at most {MOST_CUTTERS} are possible", library.cutter.len())));
    }
    library.validate().map_err(|source| CutterFileError::Cutter { file: file.to_owned(), source })?;
    Ok(library)
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
        write_cutters(&file, &library).unwrap();
        assert_eq!(read_cutters(&file).unwrap(), library);
        assert!(write_cutters(&file, &CutterLibrary::default()).unwrap_err().to_string().contains("no cutter"));
        assert_eq!(read_cutters(&file).unwrap(), library, "what cannot be written takes nothing away");
    }

    #[test]
    fn what_is_no_library_is_answered_with_the_place_and_the_reason() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("mine.toml");
        for (text, words) in [
            ("[[cutter]]\ndiameter_mm = 0.0\n", "diameter_mm is 0 mm"),
            ("[[cutter]]\ndiameter_mm = -3.0\n", "diameter_mm is -3 mm"),
            ("[[cutter]]\ndiameter_mm = 3.0\nradius = 1\n", "line 3"),
            ("[[cutter]\n", "line 1"),
            ("", "no cutter"),
        ] {
            std::fs::write(&file, text).unwrap();
            let said = read_cutters(&file).unwrap_err().to_string();
            assert!(said.contains("mine.toml") && said.contains(words), "{text:?}: {said}");
        }
        assert!(matches!(read_cutters(&folder.path().join("none.toml")), Err(CutterFileError::Unreadable { .. })));
    }
}
