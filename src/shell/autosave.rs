//! Unsaved work, kept in a folder of the program's own while there is any, so that it survives a kill.
//!
//! Each running program writes `<process>.sparkpath`, `.sparkmold` and `.sparkflank` beside `<process>.lock`, on which it holds
//! a lock as long as it lives. A copy whose lock can be taken was left by a program that did not end properly.

use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::workspaces::blisk::document::Document;
use crate::workspaces::blisk::document::project_file::ProjectFile;
use crate::workspaces::flank::document::FlankDocument;
use crate::workspaces::flank::document::flank_file::{is_flank_file, read_flank, write_flank};
use crate::workspaces::mold::document::MoldParams;
use crate::workspaces::mold::document::mold_file::{is_mold_file, read_mold, write_mold};
use files::Validate;
use files::atomic::atomic_write;

/// How the names of copies end, in the order of [`CopyKind`].
const COPIES: [&str; 3] = ["sparkpath", "sparkmold", "sparkflank"];

/// What a copy is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CopyKind {
    /// A blisk's document.
    Blisk,
    /// A mold.
    Mold,
    /// A flank.
    Flank,
}

impl CopyKind {
    fn of(copy: &Path) -> Self {
        if is_mold_file(copy) {
            Self::Mold
        } else if is_flank_file(copy) {
            Self::Flank
        } else {
            Self::Blisk
        }
    }
}

/// Keeps the copies of one running program.
#[derive(Debug)]
pub struct Autosave {
    blisk: Kept<ProjectFile>,
    mold: Kept<MoldParams>,
    flank: Kept<FlankDocument>,
    lock_path: PathBuf,
    _lock: File,
}

/// One copy, and what it holds.
#[derive(Debug)]
struct Kept<T> {
    copy: PathBuf,
    written: Option<T>,
}

impl<T: PartialEq> Kept<T> {
    /// Makes the copy hold `work`, which was to be saved as `file`; `write` writes it.
    fn update(
        &mut self,
        work: T,
        file: Option<&Path>,
        write: impl Fn(&T, &Path) -> Result<(), String>,
    ) -> Result<(), String> {
        if self.written.as_ref() == Some(&work) {
            return Ok(());
        }
        let note = Note { file: file.map(Path::to_owned) };
        // A copy is worth having without its note, which only says where it belongs.
        let _ = serde_json::to_vec(&note).map(|bytes| atomic_write(&note_of(&self.copy), |out| out.write_all(&bytes)));
        write(&work, &self.copy)?;
        self.written = Some(work);
        Ok(())
    }

    fn discard(&mut self) {
        if self.written.take().is_some() {
            let _ = std::fs::remove_file(&self.copy);
            let _ = std::fs::remove_file(note_of(&self.copy));
        }
    }
}

/// What an earlier program left behind.
#[derive(Debug, Clone)]
pub enum Recovered {
    /// A blisk's document.
    Blisk(Box<Document>),
    /// A mold, and the file that it was to be saved in if it had one.
    Mold(Box<MoldParams>, Option<PathBuf>),
    /// A flank, likewise.
    Flank(Box<FlankDocument>, Option<PathBuf>),
}

/// A copy that an earlier program left behind.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Recovery {
    copy: PathBuf,
    note: PathBuf,
    lock: PathBuf,
    /// The project file it was to be saved in, if it had one.
    pub file: Option<PathBuf>,
    /// What to call its part, if it has one that can be told.
    pub part: Option<String>,
}

/// What stands beside a copy.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Note {
    file: Option<PathBuf>,
}

fn note_of(copy: &Path) -> PathBuf {
    copy.with_extension(match CopyKind::of(copy) {
        CopyKind::Blisk => "note",
        CopyKind::Mold => "mold-note",
        CopyKind::Flank => "flank-note",
    })
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
            let copies = COPIES.map(path);
            if lock.try_lock().is_ok() && !copies.iter().any(|copy| copy.exists()) {
                let [blisk, mold, flank] = copies;
                let (blisk, mold) = (Kept { copy: blisk, written: None }, Kept { copy: mold, written: None });
                let flank = Kept { copy: flank, written: None };
                return Ok(Self { blisk, mold, flank, lock_path, _lock: lock });
            }
        }
        Err(std::io::Error::other("no free name for a copy"))
    }

    /// Writes a copy if `document` has unsaved work that the copy lacks; removes the copy if it has none.
    ///
    /// # Errors
    /// One line if it cannot be written; the copy before then still is there.
    pub fn update(&mut self, document: &Document) -> Result<(), String> {
        if !document.is_unsaved() {
            self.blisk.discard();
            return Ok(());
        }
        self.blisk.update(document.project_file(), document.file(), |project, copy| {
            project.write(copy).map_err(|e| e.to_string())
        })
    }

    /// The same for a mold, which was to be saved as `file`; none if there is no unsaved work. Cutters that are not
    /// possible, as while a number is typed, leave the copy as it was.
    ///
    /// # Errors
    /// One line if it cannot be written; the copy before then still is there.
    pub fn update_mold(&mut self, unsaved: Option<&MoldParams>, file: Option<&Path>) -> Result<(), String> {
        match unsaved {
            None => self.mold.discard(),
            Some(params) if params.validate().is_err() => {}
            Some(params) => self
                .mold
                .update(params.clone(), file, |params, copy| write_mold(copy, params).map_err(|e| e.to_string()))?,
        }
        Ok(())
    }

    /// The same for a flank.
    ///
    /// # Errors
    /// As [`Self::update_mold`].
    pub fn update_flank(&mut self, unsaved: Option<&FlankDocument>, file: Option<&Path>) -> Result<(), String> {
        match unsaved {
            None => self.flank.discard(),
            Some(document) if document.validate().is_err() => {}
            Some(document) => self
                .flank
                .update(document.clone(), file, |one, copy| write_flank(copy, one).map_err(|e| e.to_string()))?,
        }
        Ok(())
    }

    /// Removes the copy of the blisk: the work is saved, or was given up on purpose.
    pub fn discard(&mut self) {
        self.blisk.discard();
    }

    /// Removes the copy of the mold.
    pub fn discard_mold(&mut self) {
        self.mold.discard();
    }

    /// Removes the copy of the flank.
    pub fn discard_flank(&mut self) {
        self.flank.discard();
    }
}

impl Drop for Autosave {
    fn drop(&mut self) {
        // A copy that is still there stays with its lock file, to be found and recovered.
        if ![&self.blisk.copy, &self.mold.copy, &self.flank.copy].into_iter().any(|copy| copy.exists()) {
            let _ = std::fs::remove_file(&self.lock_path);
        }
    }
}

impl Recovery {
    /// The copies in `folder` that no living program keeps, in the order of their names.
    pub fn find(folder: &Path) -> Vec<Self> {
        let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
        let is_copy = |p: &PathBuf| p.extension().is_some_and(|e| COPIES.iter().any(|copy| e == *copy));
        let mut copies: Vec<PathBuf> = entries.flatten().map(|e| e.path()).filter(is_copy).collect();
        copies.sort();
        copies.into_iter().filter_map(Self::of).collect()
    }

    fn of(copy: PathBuf) -> Option<Self> {
        let (note, lock) = (note_of(&copy), copy.with_extension("lock"));
        if let Ok(file) = File::options().write(true).open(&lock)
            && matches!(file.try_lock(), Err(TryLockError::WouldBlock))
        {
            return None;
        }
        let known: Note =
            std::fs::read(&note).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok()).unwrap_or_default();
        let mut found = Self { copy, note, lock, file: known.file, part: None };
        found.part = found.work().ok().and_then(|work| match work {
            Recovered::Blisk(document) => Some(document.name()),
            Recovered::Mold(params, _) => params.mesh.is_some().then(|| params.name()),
            Recovered::Flank(document, _) => Some(document.name()),
        });
        Some(found)
    }

    /// What it is of.
    pub fn kind(&self) -> CopyKind {
        CopyKind::of(&self.copy)
    }

    /// The work as it was. The copy stays until [`discard`](Self::discard).
    ///
    /// # Errors
    /// One line if the copy cannot be read.
    pub fn work(&self) -> Result<Recovered, String> {
        let file = self.file.clone();
        match self.kind() {
            CopyKind::Mold => Ok(Recovered::Mold(Box::new(read_mold(&self.copy).map_err(|e| e.to_string())?), file)),
            CopyKind::Flank => Ok(Recovered::Flank(Box::new(read_flank(&self.copy).map_err(|e| e.to_string())?), file)),
            CopyKind::Blisk => {
                let project = ProjectFile::read(&self.copy).map_err(|e| e.to_string())?;
                Ok(Recovered::Blisk(Box::new(Document::recovered(project, file))))
            }
        }
    }

    /// When the copy was written.
    pub fn written(&self) -> Option<std::time::SystemTime> {
        std::fs::metadata(&self.copy).and_then(|m| m.modified()).ok()
    }

    /// Removes the copy.
    pub fn discard(&self) {
        for path in [&self.copy, &self.note] {
            let _ = std::fs::remove_file(path);
        }
        // The other copy of the same program needs its lock no more than this one: nobody holds it.
        let _ = std::fs::remove_file(&self.lock);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workspaces::blisk::document::job_file::PlanJob;

    fn unsaved(seed: u64) -> Document {
        let mut document = Document::default();
        let mut job = PlanJob::demonstration();
        job.genetic.seed = seed;
        document.edit("seed", job, None);
        document
    }

    fn document_of(recovery: &Recovery) -> Document {
        let Recovered::Blisk(document) = recovery.work().unwrap() else { panic!("it is of a mold") };
        *document
    }

    #[test]
    fn a_mold_is_kept_beside_a_blisk_and_what_is_not_possible_leaves_its_copy() {
        let folder = tempfile::tempdir().unwrap();
        let copies = folder.path().join("copies");
        let mut autosave = Autosave::start(&copies).unwrap();
        let mesh = Some(folder.path().join("part.stl"));
        let params = MoldParams { mesh, tolerance_mm: 0.07, ..MoldParams::default() };
        let file = folder.path().join("mine.sparkmold");
        autosave.update_mold(Some(&params), Some(&file)).unwrap();
        autosave.update(&unsaved(5)).unwrap();
        let mut broken = params.clone();
        broken.library.cutter[0].diameter_mm = 0.0;
        autosave.update_mold(Some(&broken), Some(&file)).unwrap();
        drop(autosave);
        let found = Recovery::find(&copies);
        let [mold, blisk] = &found[..] else { panic!("{found:?}") };
        let Recovered::Mold(recovered, of) = mold.work().unwrap() else { panic!("{mold:?}") };
        assert_eq!((recovered, of), (Box::new(params.clone()), Some(file)));
        mold.discard();
        assert_eq!(Recovery::find(&copies).as_slice(), std::slice::from_ref(blisk), "the one leaves the other alone");
        blisk.discard();
        let mut autosave = Autosave::start(&copies).unwrap();
        autosave.update_mold(Some(&params), None).unwrap();
        let part = |copies: &[Recovery]| copies.first().and_then(|copy| copy.part.clone());
        drop(autosave);
        let found = Recovery::find(&copies);
        assert_eq!(part(&found).as_deref(), Some("part"), "what has no file is told by its part");
        found.iter().for_each(Recovery::discard);
        let mut autosave = Autosave::start(&copies).unwrap();
        autosave.update_mold(Some(&params), None).unwrap();
        autosave.update_mold(None, None).unwrap();
        drop(autosave);
        assert_eq!(std::fs::read_dir(&copies).unwrap().count(), 0, "saved work leaves nothing");
    }

    #[test]
    fn a_flank_is_kept_with_the_file_that_it_belongs_to() {
        let folder = tempfile::tempdir().unwrap();
        let copies = folder.path().join("copies");
        let mut autosave = Autosave::start(&copies).unwrap();
        let document = FlankDocument { envelope_tolerance_mm: 0.007, ..FlankDocument::default() };
        let file = folder.path().join("mine.sparkflank");
        autosave.update_flank(Some(&document), Some(&file)).unwrap();
        let broken = FlankDocument { envelope_tolerance_mm: 0.0, ..document.clone() };
        autosave.update_flank(Some(&broken), Some(&file)).unwrap();
        drop(autosave);
        let found = Recovery::find(&copies);
        let [flank] = &found[..] else { panic!("{found:?}") };
        assert_eq!(flank.kind(), CopyKind::Flank);
        let Recovered::Flank(recovered, of) = flank.work().unwrap() else { panic!("{flank:?}") };
        assert_eq!((*recovered, of), (document, Some(file)));
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
        let recovered = document_of(&found[0]);
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
        let seeds: Vec<u64> = Recovery::find(folder.path()).iter().map(|r| document_of(r).job().genetic.seed).collect();
        assert_eq!(seeds, [11, 12]);
    }
}
