//! The document of a workspace: parameters with undo and redo, a project file, results that are kept in it, and whether
//! there is unsaved work.

pub mod autosave;
pub mod history;
pub mod project;

use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::document::history::History;
use crate::{FileError, Invalid, Validate};
use project::{CopyNote, Project};

/// Parameters that a document can hold. Their TOML form has no key called `kind`, `version`, `files`, `results`, `kept` or
/// `autosave`, which are the project file's own.
pub trait Params: Clone + PartialEq + Serialize + DeserializeOwned + Validate + Default {
    /// The word for the workspace in project files, as in `mold`.
    const KIND: &'static str;

    /// What the part is called, as in `b_slots.stl`; empty if there is none.
    fn part(&self) -> String;

    /// What to call a document without a file; the part unless said otherwise.
    fn name(&self) -> String {
        self.part()
    }

    /// Replaces the path of every file that is named: project files have them as seen from their own folder.
    fn change_paths(&mut self, change: &mut dyn FnMut(&Path) -> PathBuf);

    /// Whether nothing can be shown without the file at `path`, which is one of those that are named.
    fn needs(&self, _path: &Path) -> bool {
        true
    }

    /// Takes over what a file that is named says of the keys that are not given, as the travels of a machine. Called once
    /// paths are those of the system, with keys of a project file or those that have just been changed.
    ///
    /// # Errors
    /// If that file cannot be read.
    fn complete(&mut self, _is_given: &dyn Fn(&str) -> bool) -> Result<(), Invalid> {
        Ok(())
    }
}

/// The document of any workspace, for whoever does not know its parameters.
pub trait AnyDocument {
    /// The word for the workspace in project files.
    fn kind(&self) -> &'static str;

    /// The name to show: that of the project file, or else of the part.
    fn name(&self) -> String;

    /// The project file, if there is one.
    fn file(&self) -> Option<&Path>;

    /// Whether there are changes that no file holds.
    fn is_unsaved(&self) -> bool;

    /// A number that no state of any document had before, taken anew with each change of the user's work.
    fn revision(&self) -> u64;

    /// A number like [`revision`](Self::revision) that changes with anything that a file holds, results included.
    fn content_revision(&self) -> u64;

    /// What undo would take back, or do `again`.
    fn undo_label(&self, again: bool) -> Option<&str>;

    /// Takes the last step back, or does the one `again` that was taken back last. Tells whether there was one.
    fn undo(&mut self, again: bool) -> bool;

    /// Saves as `file` and makes it the document's own.
    ///
    /// # Errors
    /// [`FileError`]; what was there before then still is.
    fn save_as(&mut self, file: &Path) -> Result<(), FileError>;

    /// The text of a copy of the work, to lie at `copy`; none while the parameters are not possible.
    ///
    /// # Errors
    /// [`FileError`].
    fn copy(&self, copy: &Path) -> Result<Option<String>, FileError>;
}

/// A file that the parameters name, and what it held when it was read.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PartFile {
    /// The file.
    pub path: PathBuf,
    /// SHA-256 of its content in hexadecimal, as the importer gives it.
    pub sha256: String,
}

/// A file that is not what the project was made with.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MovedFile {
    /// Where it was.
    pub path: PathBuf,
    /// Whether there still is a file, with other content.
    pub is_changed: bool,
}

/// The parameters of a workspace as a user edits them.
#[derive(Debug, Clone)]
pub struct Document<P> {
    params: P,
    history: History<P>,
    file: Option<PathBuf>,
    /// What its file holds, or what a new document starts with; none if no file holds anything of it.
    saved: Option<P>,
    files: Vec<PartFile>,
    results: BTreeMap<String, String>,
    kept: BTreeMap<String, String>,
    saved_kept: BTreeMap<String, String>,
    revision: u64,
    content_revision: u64,
}

impl<P: Params> Default for Document<P> {
    fn default() -> Self {
        Self::new(P::default())
    }
}

impl<P: Params> Document<P> {
    /// A new document, not yet saved and without unsaved work.
    pub fn new(params: P) -> Self {
        Self::of(Project { params, ..Project::default() }, None)
    }

    fn of(project: Project<P>, file: Option<PathBuf>) -> Self {
        let Project { params, files, results, kept } = project;
        let (saved, saved_kept) = (Some(params.clone()), kept.clone());
        let (history, revision, content_revision) = (History::default(), next_revision(), next_revision());
        Self { params, history, file, saved, files, results, kept, saved_kept, revision, content_revision }
    }

    /// Opens a project file. Ask for [`moved_files`](Self::moved_files) before anything is read from them.
    ///
    /// # Errors
    /// [`FileError`], also of a file of another workspace or of a newer program.
    pub fn open(file: &Path) -> Result<Self, FileError> {
        Ok(Self::of(Project::read(file)?, Some(file.to_owned())))
    }

    /// The document in the text of a project, as one that is built in; files that it names are seen from `folder`.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn parse(text: &str, folder: &Path) -> Result<Self, FileError> {
        Ok(Self::of(Project::parse(text, &folder.join("project"))?, None))
    }

    /// A document from a copy of unsaved work, to be saved as `file`.
    pub(crate) fn recovered(project: Project<P>, file: Option<PathBuf>) -> Self {
        Self { saved: None, ..Self::of(project, file) }
    }

    /// A copy of the document that belongs to no file.
    #[must_use]
    pub fn detached(&self) -> Self {
        Self { file: None, ..self.clone() }
    }

    /// The parameters.
    pub fn params(&self) -> &P {
        &self.params
    }

    /// Makes `params` the parameters, as one step named `label`. Those `in_gesture` (a drag, a number being typed) with
    /// the same label make one step together, until [`end_gesture`](Self::end_gesture). Tells whether anything changed.
    pub fn edit(&mut self, label: &str, params: P, in_gesture: bool) -> bool {
        if params == self.params {
            return false;
        }
        self.history.record(label, &self.params, in_gesture);
        self.params = params;
        self.touch();
        true
    }

    /// Makes `params` the parameters as part of the last step, so that undo takes both back together.
    pub fn complete_step(&mut self, params: P) {
        self.params = params;
        self.content_revision = next_revision();
    }

    /// Changes the parameters and those of every step alike, which is no step of its own: what the program notes of the
    /// part. What the file is taken to hold changes too if `is_in_file`, so that no unsaved work comes of it.
    pub fn amend(&mut self, is_in_file: bool, mut change: impl FnMut(&mut P)) {
        change(&mut self.params);
        self.history.change_all(&mut change);
        if is_in_file {
            self.saved.iter_mut().for_each(change);
        }
        self.content_revision = next_revision();
    }

    fn touch(&mut self) {
        (self.revision, self.content_revision) = (next_revision(), next_revision());
    }

    /// Ends a gesture: the button was released, the field was left.
    pub fn end_gesture(&mut self) {
        self.history.end_gesture();
    }

    /// A result under this name, in the workspace's own form. What a computation found is checked before it is used:
    /// a file never vouches for a path.
    pub fn result(&self, name: &str) -> Option<&str> {
        self.results.get(name).map(String::as_str)
    }

    /// Notes a result that can be computed again, for the project file; none removes it. That is no unsaved work.
    pub fn note_result(&mut self, name: &str, result: Option<String>) {
        note(&mut self.results, name, result);
        self.content_revision = next_revision();
    }

    /// What the user decided to keep under this name.
    pub fn kept(&self, name: &str) -> Option<&str> {
        self.kept.get(name).map(String::as_str)
    }

    /// Keeps what may be nowhere else, as runs to compare with; none removes it. That is unsaved work.
    pub fn keep(&mut self, name: &str, content: Option<String>) {
        note(&mut self.kept, name, content);
        self.touch();
    }

    /// Notes the content of a file that was read, for the project file.
    pub fn note_file(&mut self, read: &PartFile) {
        if !self.files.contains(read) {
            self.files.retain(|file| file.path != read.path);
            self.files.push(read.clone());
        }
    }

    /// The files that the parameters name and that are gone, or hold something else than when they were noted.
    pub fn moved_files(&self) -> Vec<MovedFile> {
        let mut moved = Vec::new();
        for path in used(&self.params) {
            let known = self.files.iter().find(|file| file.path == path);
            match (path.is_file(), known) {
                (false, _) => moved.push(MovedFile { path, is_changed: false }),
                (true, Some(known)) if !has_buffers(&path) => match sha256_of(&path) {
                    Ok(now) if now == known.sha256 => {}
                    Ok(_) => moved.push(MovedFile { path, is_changed: true }),
                    Err(_) => moved.push(MovedFile { path, is_changed: false }),
                },
                (true, _) => {}
            }
        }
        moved
    }

    /// Puts `found` in the place of the file that was at `path`, whatever it holds. That is unsaved work and no step.
    pub fn replace_file(&mut self, path: &Path, found: &Path) {
        self.params.change_paths(&mut |file| if file == path { found.to_owned() } else { file.to_owned() });
        self.files.retain(|file| file.path != path && file.path != found);
        self.touch();
    }

    /// Writes the parameters alone as a project file, as for the command line on another machine. The document's own file
    /// stays what it is.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn export(&self, file: &Path) -> Result<(), FileError> {
        Project { params: self.params.clone(), ..Project::default() }.write(file)
    }

    /// What a file of this document holds.
    pub(crate) fn project(&self) -> Project<P> {
        let used = used(&self.params);
        Project {
            params: self.params.clone(),
            files: self.files.iter().filter(|file| used.contains(&file.path)).cloned().collect(),
            results: self.results.clone(),
            kept: self.kept.clone(),
        }
    }
}

impl<P: Params> AnyDocument for Document<P> {
    fn kind(&self) -> &'static str {
        P::KIND
    }

    fn name(&self) -> String {
        let stem = self.file.as_deref().and_then(Path::file_stem);
        stem.map_or_else(|| self.params.name(), |stem| stem.to_string_lossy().into_owned())
    }

    fn file(&self) -> Option<&Path> {
        self.file.as_deref()
    }

    fn is_unsaved(&self) -> bool {
        self.saved.as_ref() != Some(&self.params) || self.saved_kept != self.kept
    }

    fn revision(&self) -> u64 {
        self.revision
    }

    fn content_revision(&self) -> u64 {
        self.content_revision
    }

    fn undo_label(&self, again: bool) -> Option<&str> {
        if again { self.history.redo_label() } else { self.history.undo_label() }
    }

    fn undo(&mut self, again: bool) -> bool {
        let step = if again { self.history.redo(&self.params) } else { self.history.undo(&self.params) };
        let Some(params) = step else { return false };
        self.params = params;
        self.touch();
        true
    }

    fn save_as(&mut self, file: &Path) -> Result<(), FileError> {
        self.project().write(file)?;
        (self.file, self.saved) = (Some(file.to_owned()), Some(self.params.clone()));
        self.saved_kept = self.kept.clone();
        Ok(())
    }

    fn copy(&self, copy: &Path) -> Result<Option<String>, FileError> {
        if self.params.validate().is_err() {
            return Ok(None);
        }
        let note = CopyNote { file: self.file.clone(), part: self.params.part() };
        self.project().text(copy, Some(note)).map(Some)
    }
}

/// A number that was not given before.
fn next_revision() -> u64 {
    static NEXT: AtomicU64 = AtomicU64::new(0);
    NEXT.fetch_add(1, Ordering::Relaxed)
}

fn note(all: &mut BTreeMap<String, String>, name: &str, content: Option<String>) {
    match content {
        Some(content) => drop(all.insert(name.to_owned(), content)),
        None => drop(all.remove(name)),
    }
}

/// The files that `params` name, each once.
fn used(params: &impl Params) -> Vec<PathBuf> {
    let mut paths: Vec<PathBuf> = Vec::new();
    params.clone().change_paths(&mut |path| {
        if !paths.iter().any(|known| known == path) {
            paths.push(path.to_owned());
        }
        path.to_owned()
    });
    paths
}

/// A glTF's hash covers its buffer files too, which only the importer knows.
fn has_buffers(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("gltf"))
}

/// SHA-256 of a file's content in hexadecimal.
///
/// # Errors
/// If it cannot be read.
pub fn sha256_of(path: &Path) -> std::io::Result<String> {
    let mut file = std::fs::File::open(path)?;
    let mut hash = Sha256::new();
    let mut block = vec![0; 1 << 20];
    loop {
        let n = file.read(&mut block)?;
        if n == 0 {
            return Ok(hexadecimal(hash));
        }
        hash.update(&block[..n]);
    }
}

/// SHA-256 of `bytes` in hexadecimal.
pub fn sha256(bytes: &[u8]) -> String {
    let mut hash = Sha256::new();
    hash.update(bytes);
    hexadecimal(hash)
}

fn hexadecimal(hash: Sha256) -> String {
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
