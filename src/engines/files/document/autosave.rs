//! Copies of unsaved work in a folder of the program, which survive a crash.
//!
//! A running program holds a lock on `<process>.lock`, and keeps `<process>.<kind>.sparkpath` for each workspace with
//! unsaved work. A copy without a held lock was left by a program that did not end properly.

use std::collections::BTreeMap;
use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use super::project::{CopyNote, LARGEST_PROJECT, Project, note_of};
use super::{AnyDocument, Document, Params};
use crate::FileError;
use crate::atomic::remove_left;
use crate::toml_file::write_text;

const ENDING: &str = "sparkpath";

/// The copies of one running program.
#[derive(Debug)]
pub struct Autosave {
    folder: PathBuf,
    process: String,
    every: f64,
    last: f64,
    /// Kinds that have a copy, with the revision of its content.
    written: BTreeMap<&'static str, u64>,
    _lock: File,
}

impl Autosave {
    /// Starts keeping copies in `folder`, which is made if missing. Copies are [due](Self::is_due) `every` so many
    /// seconds.
    ///
    /// # Errors
    /// If the folder cannot be written.
    pub fn start(folder: &Path, every: f64) -> std::io::Result<Self> {
        std::fs::create_dir_all(folder)?;
        remove_left(folder);
        remove_locks(folder);
        // Numbers of processes come again, and one process may keep several sets.
        for n in 0..u32::MAX {
            let process = format!("{}-{n}", std::process::id());
            let path = folder.join(format!("{process}.lock"));
            let lock = File::options().create(true).truncate(false).write(true).open(&path)?;
            // Another program may have removed it as one that was left.
            if lock.try_lock().is_ok() && path.exists() && copies_of(folder, &process).is_empty() {
                let folder = folder.to_owned();
                return Ok(Self { folder, process, every, last: 0.0, written: BTreeMap::new(), _lock: lock });
            }
        }
        Err(std::io::Error::other("no free name for a copy"))
    }

    /// Whether the copies are to be [updated](Self::update) `now` (s). If so, the time counts anew.
    pub fn is_due(&mut self, now: f64) -> bool {
        let is_due = self.due_in(now) <= 0.0;
        if is_due {
            self.last = now;
        }
        is_due
    }

    /// Time until the copies are due (s), seen from `now` (s).
    pub fn due_in(&self, now: f64) -> f64 {
        self.every - (now - self.last)
    }

    /// Writes a copy if `document` has unsaved work that the copy lacks, and removes the copy if it has none.
    ///
    /// # Errors
    /// [`FileError`]; the former copy stays.
    pub fn update(&mut self, document: &dyn AnyDocument) -> Result<(), FileError> {
        let kind = document.kind();
        self.discard_saved(document);
        if !document.is_unsaved() {
            return Ok(());
        }
        let revision = document.content_revision();
        if self.written.get(kind) == Some(&revision) {
            return Ok(());
        }
        let copy = self.copy(kind);
        write_text(&copy, &document.copy(&copy)?, LARGEST_PROJECT)?;
        self.written.insert(kind, revision);
        Ok(())
    }

    /// Removes the copy of a `document` without unsaved work.
    pub fn discard_saved(&mut self, document: &dyn AnyDocument) {
        if self.written.contains_key(document.kind()) && !document.is_unsaved() {
            self.discard(document.kind());
        }
    }

    /// Removes the copy of this kind, because the work is saved or was given up on purpose.
    pub fn discard(&mut self, kind: &'static str) {
        if self.written.remove(kind).is_some() {
            // A copy that cannot be removed is offered at the next start, which loses nothing.
            let _ = std::fs::remove_file(self.copy(kind));
        }
    }

    fn copy(&self, kind: &str) -> PathBuf {
        self.folder.join(format!("{}.{kind}.{ENDING}", self.process))
    }
}

impl Drop for Autosave {
    fn drop(&mut self) {
        // A copy that is still there stays with its lock file, to be found and recovered.
        if copies_of(&self.folder, &self.process).is_empty() {
            let _ = std::fs::remove_file(self.folder.join(format!("{}.lock", self.process)));
        }
    }
}

/// Removes the locks in `folder` of programs that ended without a copy.
fn remove_locks(folder: &Path) {
    for path in std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()) {
        let process =
            path.file_stem().and_then(|stem| stem.to_str()).filter(|_| path.extension().is_some_and(|e| e == "lock"));
        let Some(process) = process else { continue };
        if let Ok(file) = File::options().write(true).open(&path)
            && file.try_lock().is_ok()
            && copies_of(folder, process).is_empty()
        {
            let _ = std::fs::remove_file(&path);
        }
    }
}

/// The copies in `folder` that the program called `process` made; all of them for an empty one. In the order of names.
fn copies_of(folder: &Path, process: &str) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let is_copy = |path: &PathBuf| {
        path.extension().is_some_and(|e| e == ENDING)
            && name_parts(path).is_some_and(|[of, _]| process.is_empty() || of == process)
    };
    let mut copies: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).filter(is_copy).collect();
    copies.sort();
    copies
}

/// Process and kind in the name of a copy.
fn name_parts(copy: &Path) -> Option<[&str; 2]> {
    let (process, kind) = copy.file_stem()?.to_str()?.rsplit_once('.')?;
    Some([process, kind])
}

/// A copy that an earlier program left behind.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Recovery {
    copy: PathBuf,
    /// The kind of the workspace, as in `mold`.
    pub kind: String,
    /// Name of the part; empty if unknown.
    pub part: String,
    /// The project file of the work, if it had one.
    pub file: Option<PathBuf>,
}

impl Recovery {
    /// The copies in `folder` without a running program, in the order of their names.
    pub fn find(folder: &Path) -> Vec<Self> {
        copies_of(folder, "").into_iter().filter_map(Self::of).collect()
    }

    fn of(copy: PathBuf) -> Option<Self> {
        let [process, kind] = name_parts(&copy)?.map(str::to_owned);
        let lock = copy.with_file_name(format!("{process}.lock"));
        if let Ok(file) = File::options().write(true).open(lock)
            && matches!(file.try_lock(), Err(TryLockError::WouldBlock))
        {
            return None;
        }
        // One that is damaged is offered too: opening it says what is wrong.
        let CopyNote { file, part, .. } = note_of(&copy).unwrap_or_default();
        Some(Self { copy, kind, part, file })
    }

    /// Title of the copy in a list: `Mold: b_slots, not saved yet`, or with the name of its project file.
    pub fn title(&self) -> String {
        let mut letters = self.kind.chars();
        let kind: String = letters.next().map(|c| c.to_ascii_uppercase()).into_iter().chain(letters).collect();
        let part = if self.part.is_empty() { String::new() } else { format!(": {}", self.part) };
        match &self.file {
            Some(file) => format!("{kind}{part}, of {}", file.file_name().unwrap_or_default().to_string_lossy()),
            None => format!("{kind}{part}, not saved yet"),
        }
    }

    /// The unsaved work. The copy stays until [`discard`](Self::discard).
    ///
    /// # Errors
    /// [`FileError`] if the copy cannot be read.
    pub fn open<P: Params>(&self) -> Result<Document<P>, FileError> {
        let (project, note) = Project::read_copy(&self.copy)?;
        Ok(Document::recovered(project, note))
    }

    /// The copy itself.
    pub fn copy(&self) -> &Path {
        &self.copy
    }

    /// Time when the copy was written.
    pub fn written(&self) -> Option<SystemTime> {
        std::fs::metadata(&self.copy).and_then(|m| m.modified()).ok()
    }

    /// Removes the copy, and the lock of its program if that left no other.
    pub fn discard(&self) {
        let _ = std::fs::remove_file(&self.copy);
        if let (Some([process, _]), Some(folder)) = (name_parts(&self.copy), self.copy.parent())
            && copies_of(folder, process).is_empty()
        {
            let _ = std::fs::remove_file(folder.join(format!("{process}.lock")));
        }
    }
}
