//! Unsaved work, kept in a folder of the program's own while the document has any, so that it survives a kill.
//!
//! Each running program writes one file, `<process>.sparkpath`, beside `<process>.lock`, on which it holds a lock as
//! long as it lives. A copy whose lock can be taken was left by a program that did not end properly.

use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::document::Document;
use super::project_file::{ProjectFile, ProjectFileError};
use crate::mesh_io::atomic_write;

/// Keeps the copy of one running program.
#[derive(Debug)]
pub struct Autosave {
    copy: PathBuf,
    note: PathBuf,
    lock_path: PathBuf,
    _lock: File,
    written: Option<ProjectFile>,
}

/// A copy that an earlier program left behind.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Recovery {
    copy: PathBuf,
    note: PathBuf,
    lock: PathBuf,
    /// The project file it was to be saved in, if it had one.
    pub file: Option<PathBuf>,
}

/// What stands beside a copy.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Note {
    file: Option<PathBuf>,
}

impl Autosave {
    /// Starts keeping copies in `folder`, which is made if it is not there.
    ///
    /// # Errors
    /// If nothing can be written there.
    pub fn start(folder: &Path) -> std::io::Result<Self> {
        std::fs::create_dir_all(folder)?;
        // Numbers of processes come again, and one process may keep several documents.
        for n in 0..u32::MAX {
            let name = format!("{}-{n}", std::process::id());
            let path = |extension: &str| folder.join(format!("{name}.{extension}"));
            let lock_path = path("lock");
            let lock = File::options().create(true).truncate(false).write(true).open(&lock_path)?;
            if lock.try_lock().is_ok() && !path("sparkpath").exists() {
                let (copy, note) = (path("sparkpath"), path("note"));
                return Ok(Self { copy, note, lock_path, _lock: lock, written: None });
            }
        }
        Err(std::io::Error::other("no free name for a copy"))
    }

    /// Writes a copy if `document` has unsaved work that the copy lacks; removes the copy if it has none.
    ///
    /// # Errors
    /// If it cannot be written; the copy before then still is there.
    pub fn update(&mut self, document: &Document) -> Result<(), ProjectFileError> {
        if !document.is_unsaved() {
            self.discard();
            return Ok(());
        }
        let project = document.project_file();
        if self.written.as_ref() == Some(&project) {
            return Ok(());
        }
        let note = Note { file: document.file().map(Path::to_owned) };
        // A copy is worth having without its note, which only says where it belongs.
        let _ = serde_json::to_vec(&note).map(|bytes| atomic_write(&self.note, |out| out.write_all(&bytes)));
        project.write(&self.copy)?;
        self.written = Some(project);
        Ok(())
    }

    /// Removes the copy: the work is saved, or was given up on purpose.
    pub fn discard(&mut self) {
        if self.written.take().is_some() {
            let _ = std::fs::remove_file(&self.copy);
            let _ = std::fs::remove_file(&self.note);
        }
    }
}

impl Drop for Autosave {
    fn drop(&mut self) {
        // A copy that is still there stays with its lock file, to be found and recovered.
        if !self.copy.exists() {
            let _ = std::fs::remove_file(&self.lock_path);
        }
    }
}

impl Recovery {
    /// The copies in `folder` that no living program keeps, in the order of their names.
    pub fn find(folder: &Path) -> Vec<Self> {
        let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
        let mut copies: Vec<PathBuf> =
            entries.flatten().map(|e| e.path()).filter(|p| p.extension().is_some_and(|e| e == "sparkpath")).collect();
        copies.sort();
        copies.into_iter().filter_map(Self::of).collect()
    }

    fn of(copy: PathBuf) -> Option<Self> {
        let (note, lock) = (copy.with_extension("note"), copy.with_extension("lock"));
        if let Ok(file) = File::options().write(true).open(&lock)
            && matches!(file.try_lock(), Err(TryLockError::WouldBlock))
        {
            return None;
        }
        let known: Note =
            std::fs::read(&note).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok()).unwrap_or_default();
        Some(Self { copy, note, lock, file: known.file })
    }

    /// The document as it was. The copy stays until [`discard`](Self::discard).
    ///
    /// # Errors
    /// If the copy cannot be read.
    pub fn document(&self) -> Result<Document, ProjectFileError> {
        Ok(Document::recovered(ProjectFile::read(&self.copy)?, self.file.clone()))
    }

    /// When the copy was written.
    pub fn written(&self) -> Option<std::time::SystemTime> {
        std::fs::metadata(&self.copy).and_then(|m| m.modified()).ok()
    }

    /// Removes the copy.
    pub fn discard(&self) {
        for path in [&self.copy, &self.note, &self.lock] {
            let _ = std::fs::remove_file(path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::project::PlanJob;

    fn unsaved(seed: u64) -> Document {
        let mut document = Document::default();
        let mut job = PlanJob::demonstration();
        job.genetic.seed = seed;
        document.edit("seed", job, None);
        document
    }

    #[test]
    fn unsaved_work_is_found_after_its_program_is_gone_but_not_before() {
        let folder = tempfile::tempdir().unwrap();
        let document = unsaved(77);
        let mut autosave = Autosave::start(folder.path()).unwrap();
        autosave.update(&document).unwrap();
        assert_eq!(Recovery::find(folder.path()), [], "its program is alive");
        drop(autosave);
        let found = Recovery::find(folder.path());
        assert_eq!(found.len(), 1);
        let recovered = found[0].document().unwrap();
        assert_eq!(recovered.job(), document.job());
        assert!(recovered.is_unsaved());
        found[0].discard();
        assert_eq!(Recovery::find(folder.path()), []);
    }

    #[test]
    fn saved_work_leaves_no_copy() {
        let folder = tempfile::tempdir().unwrap();
        let mut document = unsaved(77);
        let mut autosave = Autosave::start(folder.path()).unwrap();
        autosave.update(&document).unwrap();
        document.save_as(&folder.path().join("elsewhere.json")).unwrap();
        autosave.update(&document).unwrap();
        drop(autosave);
        assert_eq!(Recovery::find(folder.path()), []);
    }

    #[test]
    fn two_programs_keep_two_copies() {
        let folder = tempfile::tempdir().unwrap();
        let mut first = Autosave::start(folder.path()).unwrap();
        let mut second = Autosave::start(folder.path()).unwrap();
        first.update(&unsaved(11)).unwrap();
        second.update(&unsaved(12)).unwrap();
        drop((first, second));
        let seeds: Vec<u64> =
            Recovery::find(folder.path()).iter().map(|r| r.document().unwrap().job().genetic.seed).collect();
        assert_eq!(seeds, [11, 12]);
    }
}
