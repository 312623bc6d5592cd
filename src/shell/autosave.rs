//! Unsaved work, kept in a folder of the program's own while there is any, so that it survives a kill.
//!
//! Each running program writes `<process>.<ending>` for each workspace, such as `.sparkpath`, beside `<process>.lock`, on
//! which it holds a lock as long as it lives. A copy whose lock can be taken was left by a program that did not end
//! properly.

use std::any::Any;
use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::workspaces::workspace::Workspace;
use files::atomic::atomic_write;

/// Keeps the copies of one running program.
pub struct Autosave {
    /// One for each workspace.
    copies: Vec<Copy>,
    lock_path: PathBuf,
    _lock: File,
}

/// The copy of one document, and what it holds.
struct Copy {
    path: PathBuf,
    written: Option<Box<dyn Any>>,
}

impl Copy {
    fn discard(&mut self) {
        if self.written.take().is_some() {
            let _ = std::fs::remove_file(&self.path);
            let _ = std::fs::remove_file(note_of(&self.path));
        }
    }
}

/// A copy that an earlier program left behind.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Recovery {
    /// The copy.
    pub copy: PathBuf,
    note: PathBuf,
    lock: PathBuf,
    /// The number of the workspace whose document it is.
    pub workspace: usize,
    /// The file it was to be saved in, if it had one.
    pub file: Option<PathBuf>,
    /// What to call its part, if it has one that can be told.
    pub part: Option<String>,
}

/// What stands beside a copy.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Note {
    file: Option<PathBuf>,
    #[serde(default)]
    part: Option<String>,
}

fn note_of(copy: &Path) -> PathBuf {
    let ending = copy.extension().unwrap_or_default().to_string_lossy().into_owned();
    copy.with_extension(format!("{ending}-note"))
}

impl Autosave {
    /// Starts keeping copies in `folder`, which is made if it is not there, of documents with these `endings`, one for each
    /// workspace.
    ///
    /// # Errors
    /// If nothing can be written there.
    pub fn start(folder: &Path, endings: &[&str]) -> std::io::Result<Self> {
        std::fs::create_dir_all(folder)?;
        // Numbers of processes come again, and one process may keep several documents.
        for n in 0..u32::MAX {
            let name = format!("{}-{n}", std::process::id());
            let lock_path = folder.join(format!("{name}.lock"));
            let lock = File::options().create(true).truncate(false).write(true).open(&lock_path)?;
            let paths: Vec<PathBuf> = endings.iter().map(|ending| folder.join(format!("{name}{ending}"))).collect();
            if lock.try_lock().is_ok() && !paths.iter().any(|path| path.exists()) {
                let copies = paths.into_iter().map(|path| Copy { path, written: None }).collect();
                return Ok(Self { copies, lock_path, _lock: lock });
            }
        }
        Err(std::io::Error::other("no free name for a copy"))
    }

    /// Writes a copy of each document that has unsaved work which its copy lacks; removes the copies of those without. A
    /// document that cannot be written now leaves its copy as it was.
    ///
    /// # Errors
    /// One line if one cannot be written; the copy before then still is there.
    pub fn update(&mut self, workspaces: &[Box<dyn Workspace>]) -> Result<(), String> {
        self.discard_saved(workspaces);
        for (copy, workspace) in self.copies.iter_mut().zip(workspaces) {
            if !workspace.is_unsaved() || workspace.is_at(copy.written.as_deref()) {
                continue;
            }
            let note = Note { file: workspace.file().map(Path::to_owned), part: workspace.part() };
            // A copy is worth having without its note, which only says where it belongs.
            let _ =
                serde_json::to_vec(&note).map(|bytes| atomic_write(&note_of(&copy.path), |out| out.write_all(&bytes)));
            workspace.write(&copy.path)?;
            copy.written = Some(workspace.snapshot());
        }
        Ok(())
    }

    /// Removes the copies of documents without unsaved work.
    pub fn discard_saved(&mut self, workspaces: &[Box<dyn Workspace>]) {
        for (copy, workspace) in self.copies.iter_mut().zip(workspaces) {
            if copy.written.is_some() && !workspace.is_unsaved() {
                copy.discard();
            }
        }
    }

    /// Removes all copies: the work was given up on purpose.
    pub fn discard(&mut self) {
        self.copies.iter_mut().for_each(Copy::discard);
    }
}

impl Drop for Autosave {
    fn drop(&mut self) {
        // A copy that is still there stays with its lock file, to be found and recovered.
        if !self.copies.iter().any(|copy| copy.path.exists()) {
            let _ = std::fs::remove_file(&self.lock_path);
        }
    }
}

impl Recovery {
    /// The copies in `folder` of documents with these `endings` that no living program keeps, in the order of their names.
    pub fn find(folder: &Path, endings: &[&str]) -> Vec<Self> {
        let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
        let mut paths: Vec<PathBuf> = entries.flatten().map(|e| e.path()).collect();
        paths.sort();
        let ending_of = |path: &Path| format!(".{}", path.extension().unwrap_or_default().to_string_lossy());
        let numbered = paths.into_iter().filter_map(|path| {
            let ending = ending_of(&path);
            let workspace = endings.iter().position(|one| *one == ending)?;
            Self::of(path, workspace)
        });
        numbered.collect()
    }

    fn of(copy: PathBuf, workspace: usize) -> Option<Self> {
        let (note, lock) = (note_of(&copy), copy.with_extension("lock"));
        if let Ok(file) = File::options().write(true).open(&lock)
            && matches!(file.try_lock(), Err(TryLockError::WouldBlock))
        {
            return None;
        }
        let known: Note =
            std::fs::read(&note).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok()).unwrap_or_default();
        Some(Self { copy, note, lock, workspace, file: known.file, part: known.part })
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
    use crate::workspaces::blisk::BliskWorkspace;
    use crate::workspaces::blisk::document::Document;
    use crate::workspaces::context::Context;
    use crate::workspaces::flank::FlankWorkspace;
    use crate::workspaces::flank::document::FlankDocument;
    use crate::workspaces::mold::MoldWorkspace;
    use crate::workspaces::mold::document::MoldParams;
    use crate::workspaces::preferences::Preferences;
    use crate::workspaces::registry::workspaces;
    use task::Scheduler;

    const ENDINGS: [&str; 3] = [".sparkpath", ".sparkmold", ".sparkflank"];

    /// The program's workspaces.
    fn list() -> Vec<Box<dyn Workspace>> {
        workspaces(&Scheduler::manual(|| ()))
    }

    fn at<W: Workspace>(list: &mut [Box<dyn Workspace>]) -> &mut W {
        list.iter_mut().find_map(|one| (&mut **one as &mut dyn Any).downcast_mut()).unwrap()
    }

    /// The program's workspaces, with unsaved work in that of blisks.
    fn unsaved(seed: u64) -> Vec<Box<dyn Workspace>> {
        let mut list = list();
        let desk = &mut at::<BliskWorkspace>(&mut list).desk;
        let mut job = desk.document.job().clone();
        job.genetic.seed = seed;
        desk.edit("seed", job, false);
        list
    }

    fn recovered(copy: &Recovery) -> Vec<Box<dyn Workspace>> {
        let mut list = list();
        let cx = &mut Context::new(Preferences::default());
        list[copy.workspace].recover(&copy.copy, copy.file.clone(), cx).unwrap();
        list
    }

    fn document_of(copy: &Recovery) -> Document {
        at::<BliskWorkspace>(&mut recovered(copy)).desk.document.clone()
    }

    #[test]
    fn a_mold_is_kept_beside_a_blisk_and_what_is_not_possible_leaves_its_copy() {
        let folder = tempfile::tempdir().unwrap();
        let copies = folder.path().join("copies");
        let mut autosave = Autosave::start(&copies, &ENDINGS).unwrap();
        let mut list = unsaved(5);
        let file = folder.path().join("mine.sparkmold");
        let desk = &mut at::<MoldWorkspace>(&mut list).desk;
        let mesh = Some(folder.path().join("part.stl"));
        desk.record.file = Some(file.clone());
        desk.edit(MoldParams { mesh, tolerance_mm: 0.07, ..desk.params.clone() });
        let params = desk.params.clone();
        autosave.update(&list).unwrap();
        let desk = &mut at::<MoldWorkspace>(&mut list).desk;
        let mut broken = params.clone();
        broken.library.cutter[0].diameter_mm = 0.0;
        desk.edit(broken);
        autosave.update(&list).unwrap();
        drop(autosave);
        let found = Recovery::find(&copies, &ENDINGS);
        let [mold, blisk] = &found[..] else { panic!("{found:?}") };
        let desk = recovered(mold);
        let (kept, of) = (desk[mold.workspace].snapshot(), desk[mold.workspace].file());
        assert_eq!((kept.downcast_ref(), of), (Some(&params), Some(&*file)));
        mold.discard();
        let left = Recovery::find(&copies, &ENDINGS);
        assert_eq!(left.as_slice(), std::slice::from_ref(blisk), "the one leaves the other alone");
        blisk.discard();
        let mut autosave = Autosave::start(&copies, &ENDINGS).unwrap();
        let desk = &mut at::<MoldWorkspace>(&mut list).desk;
        desk.edit(params.clone());
        autosave.update(&list).unwrap();
        at::<MoldWorkspace>(&mut list).desk.saved_as(&file);
        at::<BliskWorkspace>(&mut list).desk.document = Document::default();
        autosave.update(&list).unwrap();
        drop(autosave);
        assert_eq!(std::fs::read_dir(&copies).unwrap().count(), 0, "saved work leaves nothing");
    }

    #[test]
    fn a_flank_is_kept_with_the_file_that_it_belongs_to() {
        let folder = tempfile::tempdir().unwrap();
        let copies = folder.path().join("copies");
        let mut autosave = Autosave::start(&copies, &ENDINGS).unwrap();
        let mut list = list();
        let document = FlankDocument { envelope_tolerance_mm: 0.007, ..FlankDocument::default() };
        let file = folder.path().join("mine.sparkflank");
        let desk = &mut at::<FlankWorkspace>(&mut list).desk;
        desk.record.file = Some(file.clone());
        desk.edit(document.clone());
        autosave.update(&list).unwrap();
        let broken = FlankDocument { envelope_tolerance_mm: 0.0, ..document.clone() };
        at::<FlankWorkspace>(&mut list).desk.edit(broken);
        autosave.update(&list).unwrap();
        drop(autosave);
        let found = Recovery::find(&copies, &ENDINGS);
        let [flank] = &found[..] else { panic!("{found:?}") };
        let desk = recovered(flank);
        let (kept, of) = (desk[flank.workspace].snapshot(), desk[flank.workspace].file());
        assert_eq!((kept.downcast_ref(), of), (Some(&document), Some(&*file)));
    }

    #[test]
    fn unsaved_work_is_found_after_its_program_is_gone_but_not_before() {
        let folder = tempfile::tempdir().unwrap();
        let mut list = unsaved(77);
        let mut autosave = Autosave::start(folder.path(), &ENDINGS).unwrap();
        autosave.update(&list).unwrap();
        assert_eq!(Recovery::find(folder.path(), &ENDINGS), [], "its program is alive");
        drop(autosave);
        let found = Recovery::find(folder.path(), &ENDINGS);
        assert_eq!(found.len(), 1);
        let kept = document_of(&found[0]);
        assert_eq!(kept.job(), at::<BliskWorkspace>(&mut list).desk.document.job());
        assert!(kept.is_unsaved());
        found[0].discard();
        assert_eq!(Recovery::find(folder.path(), &ENDINGS), []);
    }

    #[test]
    fn saved_work_leaves_no_copy() {
        let folder = tempfile::tempdir().unwrap();
        let mut list = unsaved(77);
        let mut autosave = Autosave::start(folder.path(), &ENDINGS).unwrap();
        autosave.update(&list).unwrap();
        list[0].save_as(&folder.path().join("elsewhere.json")).unwrap();
        autosave.update(&list).unwrap();
        drop(autosave);
        assert_eq!(Recovery::find(folder.path(), &ENDINGS), []);
    }

    #[test]
    fn two_programs_keep_two_copies() {
        let folder = tempfile::tempdir().unwrap();
        let mut first = Autosave::start(folder.path(), &ENDINGS).unwrap();
        let mut second = Autosave::start(folder.path(), &ENDINGS).unwrap();
        first.update(&unsaved(11)).unwrap();
        second.update(&unsaved(12)).unwrap();
        drop((first, second));
        let found = Recovery::find(folder.path(), &ENDINGS);
        let seeds: Vec<u64> = found.iter().map(|r| document_of(r).job().genetic.seed).collect();
        assert_eq!(seeds, [11, 12]);
    }
}
