//! Files that hold what a workspace was asked, as TOML.

use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::paths::absolute;
use crate::atomic::atomic_write;

/// Why such a file cannot be read or written.
#[derive(Debug, thiserror::Error)]
#[error("{file}: {problem}")]
pub struct TomlFileError {
    /// The file.
    pub file: PathBuf,
    /// What is wrong and what to do, in one line.
    pub problem: String,
}

impl TomlFileError {
    /// What is wrong with `file`.
    pub fn of(file: &Path, problem: String) -> Self {
        Self { file: file.to_owned(), problem }
    }
}

/// Whether the name of `path` ends with `ending`, a point and letters of any case.
pub fn has_ending(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|e| ending.strip_prefix('.').is_some_and(|own| e.eq_ignore_ascii_case(own)))
}

/// The folder that files named in `file` are seen from.
pub fn folder_of(file: &Path) -> PathBuf {
    absolute(file.parent().unwrap_or(Path::new("")))
}

/// Writes `content` of at most `largest` bytes, all of it or nothing.
///
/// # Errors
/// [`TomlFileError`], also of a content that would be too large to be read again.
pub fn write(file: &Path, content: &impl Serialize, largest: u64) -> Result<(), TomlFileError> {
    let wrong = |problem: String| TomlFileError::of(file, problem);
    let text = toml::to_string_pretty(content).map_err(|e| wrong(e.to_string()))?;
    let size = text.len() as u64;
    if size > largest {
        return Err(wrong(format!("not written: it would have {size} bytes and at most {largest} are read again")));
    }
    atomic_write(file, |out| out.write_all(text.as_bytes()))
        .map_err(|e| wrong(format!("cannot be written ({e}); choose another place")))
}

/// The content of the file of a `what`, which has at most `largest` bytes.
///
/// # Errors
/// [`TomlFileError`].
pub fn read<T: DeserializeOwned>(file: &Path, what: &str, largest: u64) -> Result<T, TomlFileError> {
    let wrong = |problem: String| TomlFileError::of(file, problem);
    let unreadable = |e: std::io::Error| wrong(format!("cannot be read ({e}); check the path"));
    let size = std::fs::metadata(file).map_err(unreadable)?.len();
    if size > largest {
        return Err(wrong(format!("it has {size} bytes; the file of a {what} has at most {largest}")));
    }
    let text = std::fs::read_to_string(file).map_err(unreadable)?;
    toml::from_str(&text).map_err(|e| wrong(e.message().replace('\n', " ")))
}
