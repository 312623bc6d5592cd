//! Files of flanks: the surface, the cutter and how it is milled.

use std::path::{Path, PathBuf};

use super::flank_params::{FlankDocument, FlankSource, GuideSource};
use super::paths::{absolute, relative, without_detours};
use crate::mesh_io::atomic_write;

/// How the name of such a file ends.
pub const ENDING: &str = ".sparkflank";
/// The largest file that is written or read (bytes).
const LARGEST_FILE: u64 = 1 << 20;

/// Why the file of a flank cannot be read or written.
#[derive(Debug, thiserror::Error)]
#[error("{file}: {problem}")]
pub struct FlankFileError {
    /// The file.
    pub file: PathBuf,
    /// What is wrong and what to do, in one line.
    pub problem: String,
}

/// Whether `path` is named as a file of a flank.
pub fn is_flank_file(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case(&ENDING[1..]))
}

/// Writes `document` as a TOML file, with the files that it names as seen from the file's folder.
///
/// # Errors
/// [`FlankFileError`], also of a document that could not be read again.
pub fn write_flank(file: &Path, document: &FlankDocument) -> Result<(), FlankFileError> {
    let wrong = |problem: String| FlankFileError { file: file.to_owned(), problem };
    document.validate().map_err(wrong)?;
    let folder = absolute(file.parent().unwrap_or(Path::new("")));
    let text = toml::to_string_pretty(&with_files(document, |f| relative(f, &folder)));
    let text = text.map_err(|e| wrong(e.to_string()))?;
    let size = text.len() as u64;
    if size > LARGEST_FILE {
        return Err(wrong(format!(
            "not written: it would have {size} bytes and at most {LARGEST_FILE} are read again"
        )));
    }
    atomic_write(file, |out| out.write_all(text.as_bytes()))
        .map_err(|e| wrong(format!("cannot be written ({e}); choose another place")))
}

/// The document in a file that [`write_flank`] has written.
///
/// # Errors
/// [`FlankFileError`].
pub fn read_flank(file: &Path) -> Result<FlankDocument, FlankFileError> {
    let wrong = |problem: String| FlankFileError { file: file.to_owned(), problem };
    let unreadable = |e: std::io::Error| wrong(format!("cannot be read ({e}); check the path"));
    let size = std::fs::metadata(file).map_err(unreadable)?.len();
    if size > LARGEST_FILE {
        return Err(wrong(format!("it has {size} bytes; the file of a flank has at most {LARGEST_FILE}")));
    }
    let text = std::fs::read_to_string(file).map_err(unreadable)?;
    let document: FlankDocument = toml::from_str(&text).map_err(|e| wrong(e.message().replace('\n', " ")))?;
    document.validate().map_err(wrong)?;
    let folder = absolute(file.parent().unwrap_or(Path::new("")));
    Ok(with_files(&document, |f| without_detours(&folder.join(f))))
}

/// The document with every file that it names changed. Machines are names unless they end in `.toml`.
fn with_files(document: &FlankDocument, change: impl Fn(&Path) -> PathBuf) -> FlankDocument {
    let mut changed = document.clone();
    match &mut changed.source {
        FlankSource::Demonstration { .. } => {}
        FlankSource::Guides { lower, upper } => {
            for guide in [lower, upper] {
                if let GuideSource::File(file) = guide {
                    *file = change(file);
                }
            }
        }
        FlankSource::Mesh(mesh) => mesh.file = change(&mesh.file),
    }
    if let Some(walls) = &mut changed.walls {
        walls.file = change(&walls.file);
    }
    if changed.milling.machine.ends_with(".toml") {
        changed.milling.machine = change(Path::new(&changed.milling.machine)).to_string_lossy().into_owned();
    }
    changed
}

#[cfg(test)]
#[path = "flank_file_tests.rs"]
mod tests;
