//! A document on its way to its file.

use std::fs::File;
use std::path::{Path, PathBuf};

use super::project::LARGEST_PROJECT;
use super::{sha256, sha256_of};
use crate::FileError;
use crate::atomic::remove_left;
use crate::paths::folder_of;
use crate::toml_file::write_text;

/// The work of a document as it was when saving [began](super::AnyDocument::begin_saving).
#[derive(Debug, Clone)]
pub struct Saving {
    pub(super) file: PathBuf,
    pub(super) text: String,
    /// SHA-256 of the file as the document knows it; none of a file that is not the document's own.
    pub(super) known: Option<String>,
    pub(super) number: u64,
}

impl Saving {
    /// The file that is written.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// Writes the file. A file of the document's own that another program has changed since is replaced only
    /// `in_any_case`.
    ///
    /// # Errors
    /// [`FileError`]; a former file then stays.
    pub fn write(&self, in_any_case: bool) -> Result<(), FileError> {
        // Two programs that save at the same moment do so one after the other.
        let _lock = if cfg!(unix) { File::open(&self.file).ok().filter(|file| file.lock().is_ok()) } else { None };
        if let Some(known) = self.known.as_ref().filter(|_| !in_any_case) {
            // A file that is gone is written anew.
            let is_changed = match sha256_of(&self.file) {
                Ok(now) => now != *known && now != self.sha256(),
                Err(error) if error.kind() == std::io::ErrorKind::NotFound => false,
                Err(source) => return Err(FileError::unreadable(&self.file, source)),
            };
            if is_changed {
                return Err(FileError::Changed { file: self.file.clone() });
            }
        }
        write_text(&self.file, &self.text, LARGEST_PROJECT)?;
        remove_left(&folder_of(&self.file));
        Ok(())
    }

    /// SHA-256 of what is written.
    pub(super) fn sha256(&self) -> String {
        sha256(self.text.as_bytes())
    }
}
