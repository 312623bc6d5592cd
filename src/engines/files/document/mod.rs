//! The document of a workspace: parameters with undo and redo, a project file, results kept in the file, and the state
//! of unsaved work.

pub mod autosave;
pub mod history;
pub mod project;
pub mod saving;

use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::document::history::History;
use crate::paths::{absolute, check_name};
use crate::{FileError, Invalid, Validate};
use project::{CopyNote, Project};
use saving::Saving;

/// Parameters that a document can hold. Their TOML form has no key called `kind`, `version`, `files`, `results`, `kept`
/// or `autosave`, which are the project file's own.
pub trait Params: Clone + PartialEq + Serialize + DeserializeOwned + Validate + Default {
    /// Kind of the project in files, as in `mold`.
    const KIND: &'static str;

    /// Name of the part, as in `b_slots.stl`; empty if there is none.
    fn part(&self) -> String;

    /// Name of a document without a file; by default the name of the part.
    fn name(&self) -> String {
        self.part()
    }

    /// Replaces the path of every file in the parameters. Project files have paths relative to their own folder.
    fn change_paths(&mut self, change: &mut dyn FnMut(&Path) -> PathBuf);

    /// Whether nothing can be shown without the file at `path`, which is one of those that are named.
    fn needs(&self, _path: &Path) -> bool {
        true
    }

    /// Fills in the keys that are not given from a file in the parameters, as the travels of a machine. Called once
    /// paths are absolute, with the keys of a project file or the keys just changed.
    ///
    /// # Errors
    /// If the file cannot be read.
    fn complete(&mut self, _is_given: &dyn Fn(&str) -> bool) -> Result<(), Invalid> {
        Ok(())
    }
}

/// The document of any workspace, for callers that do not know its parameters.
pub trait AnyDocument {
    /// Kind of the project in files.
    fn kind(&self) -> &'static str;

    /// Name to show: that of the project file, or else of the part.
    fn name(&self) -> String;

    /// The project file, if there is one.
    fn file(&self) -> Option<&Path>;

    /// The files in the parameters, each once.
    fn files(&self) -> Vec<PathBuf>;

    /// Whether there are unsaved changes.
    fn is_unsaved(&self) -> bool;

    /// A number that is unique among all states of all documents, and changes with the user's work.
    fn revision(&self) -> u64;

    /// A number like [`revision`](Self::revision) that changes with everything that a file holds, results included.
    fn content_revision(&self) -> u64;

    /// Name of the step that undo takes back, or that redo does `again`.
    fn undo_label(&self, again: bool) -> Option<&str>;

    /// Undoes the last step, or does `again` the step undone last. Returns whether there was one.
    fn undo(&mut self, again: bool) -> bool;

    /// The present work as it is to be written to `file`, in any thread. [`Self::end_saving`] follows once it is
    /// written.
    ///
    /// # Errors
    /// [`FileError`] if the work could not be read again.
    fn begin_saving(&mut self, file: &Path) -> Result<Saving, FileError>;

    /// Notes that `saving` was written: its file becomes the document's own, and the work as it was then is saved.
    /// Nothing changes if `saving` is not the one begun last.
    fn end_saving(&mut self, saving: &Saving);

    /// Saves as `file`, whatever that holds. The file becomes the document's own.
    ///
    /// # Errors
    /// [`FileError`]; a former file then stays.
    fn save_as(&mut self, file: &Path) -> Result<(), FileError> {
        let saving = self.begin_saving(file)?;
        saving.write(true)?;
        self.end_saving(&saving);
        Ok(())
    }

    /// Text of a copy of the work, to be kept at `copy`, also while the parameters are not possible.
    ///
    /// # Errors
    /// [`FileError`].
    fn copy(&self, copy: &Path) -> Result<String, FileError>;
}

/// A file in the parameters with the digest of what was read from it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PartFile {
    /// The file.
    pub path: PathBuf,
    /// SHA-256 of its content in hexadecimal, as the importer gives it.
    pub sha256: String,
}

/// A file of a project that is gone or has changed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MovedFile {
    /// Former path.
    pub path: PathBuf,
    /// Whether a file with other content is there.
    pub is_changed: bool,
}

/// The parameters of a workspace as a user edits them.
#[derive(Debug, Clone)]
pub struct Document<P> {
    params: P,
    /// What is wrong with the parameters, once that was asked.
    problem: OnceLock<Option<Invalid>>,
    history: History<P>,
    file: Option<PathBuf>,
    /// SHA-256 of the file as it was read or saved last; none without a file.
    file_sha256: Option<String>,
    /// Saving under way: its number, the parameters and the kept content.
    saving: Option<(u64, P, BTreeMap<String, String>)>,
    /// Parameters in the file, or those of a new document; none if no file holds the work.
    saved: Option<P>,
    files: Vec<PartFile>,
    results: BTreeMap<String, String>,
    kept: BTreeMap<String, String>,
    saved_kept: BTreeMap<String, String>,
    kept_revision: u64,
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
        let [kept_revision, revision, content_revision] = [(); 3].map(|()| next_revision());
        let (history, problem) = (History::default(), OnceLock::new());
        Self {
            params,
            problem,
            history,
            file,
            file_sha256: None,
            saving: None,
            saved,
            files,
            results,
            kept,
            saved_kept,
            kept_revision,
            revision,
            content_revision,
        }
    }

    /// Opens a project file. Check [`moved_files`](Self::moved_files) before files of the parameters are read.
    ///
    /// # Errors
    /// [`FileError`], also of a file of another workspace or of a newer program.
    pub fn open(file: &Path) -> Result<Self, FileError> {
        let text = project::text_of(file)?;
        let read = Self::of(Project::parse(&text, file)?, Some(file.to_owned()));
        Ok(Self { file_sha256: Some(sha256(text.as_bytes())), ..read })
    }

    /// The document in the text of a project, such as a built-in one. Paths are relative to `folder`.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn parse(text: &str, folder: &Path) -> Result<Self, FileError> {
        Ok(Self::of(Project::parse(text, &folder.join("project"))?, None))
    }

    /// A document from a copy of unsaved work, to be saved as the file that `note` names.
    pub(crate) fn recovered(project: Project<P>, note: CopyNote) -> Self {
        Self { saved: None, file_sha256: note.sha256, ..Self::of(project, note.file) }
    }

    /// A copy of the document without a file.
    #[must_use]
    pub fn detached(&self) -> Self {
        Self { file: None, file_sha256: None, saving: None, ..self.clone() }
    }

    /// The parameters.
    pub fn params(&self) -> &P {
        &self.params
    }

    /// The first problem of the parameters, which is looked for once for each change of them.
    pub fn problem(&self) -> Option<&Invalid> {
        self.problem.get_or_init(|| self.params.validate().err()).as_ref()
    }

    /// Sets the parameters as one step named `label`. Edits `in_gesture` (a drag, a number being typed) with the same
    /// label form one step, until [`end_gesture`](Self::end_gesture). Returns whether anything changed.
    pub fn edit(&mut self, label: &str, params: P, in_gesture: bool) -> bool {
        if params == self.params {
            return false;
        }
        self.history.record(label, &self.params, in_gesture);
        self.params = params;
        self.touch();
        true
    }

    /// Sets the parameters as part of the last step, so that undo takes both back together.
    pub fn complete_step(&mut self, params: P) {
        self.params = params;
        self.touch_params();
    }

    /// Changes the parameters in the present state and in every step, without a step of its own: for facts about the
    /// part. With `is_in_file` the saved state changes too, so that the change is not unsaved work.
    pub fn amend(&mut self, is_in_file: bool, mut change: impl FnMut(&mut P)) {
        change(&mut self.params);
        self.history.change_all(&mut change);
        if is_in_file {
            self.saved.iter_mut().for_each(change);
        }
        self.touch_params();
    }

    /// Notes that the parameters have changed.
    fn touch_params(&mut self) {
        (self.problem, self.content_revision) = (OnceLock::new(), next_revision());
    }

    /// Notes that the user's work has changed.
    fn touch(&mut self) {
        self.revision = next_revision();
        self.touch_params();
    }

    /// Ends a gesture, when a button is released or a field is left.
    pub fn end_gesture(&mut self) {
        self.history.end_gesture();
    }

    /// The kept result of this name, in the workspace's own form. A result of a computation is checked before use: a
    /// file never proves a path.
    pub fn result(&self, name: &str) -> Option<&str> {
        self.results.get(name).map(String::as_str)
    }

    /// Notes a result that can be computed again for the project file; none removes it. The note is not unsaved work.
    pub fn note_result(&mut self, name: &str, result: Option<String>) {
        note(&mut self.results, name, result);
        self.content_revision = next_revision();
    }

    /// The content that the user keeps under this name.
    pub fn kept(&self, name: &str) -> Option<&str> {
        self.kept.get(name).map(String::as_str)
    }

    /// A number like [`revision`](AnyDocument::revision) that changes with the kept content.
    pub fn kept_revision(&self) -> u64 {
        self.kept_revision
    }

    /// Keeps content that may be nowhere else, such as runs to compare with; none removes it. The change is unsaved
    /// work.
    pub fn keep(&mut self, name: &str, content: Option<String>) {
        note(&mut self.kept, name, content);
        self.kept_revision = next_revision();
        self.touch();
    }

    /// Notes the digest of a file that was read, for the project file.
    pub fn note_file(&mut self, read: &PartFile) {
        if !self.files.contains(read) {
            self.files.retain(|file| file.path != read.path);
            self.files.push(read.clone());
        }
    }

    /// The files in the parameters that are gone, or whose content differs from the noted digest.
    pub fn moved_files(&self) -> Vec<MovedFile> {
        let mut moved = Vec::new();
        for path in files_in(&self.params) {
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

    /// Replaces the path `path` by `found`, whatever the file holds. The change is unsaved work, but no step.
    pub fn replace_file(&mut self, path: &Path, found: &Path) {
        self.params.change_paths(&mut |file| if file == path { found.to_owned() } else { file.to_owned() });
        self.files.retain(|file| file.path != path && file.path != found);
        self.touch();
    }

    /// Only the parameters as the text of a project file that is to lie at `file`, for the command line on another machine.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn text(&self, file: &Path) -> Result<String, FileError> {
        Project { params: self.params.clone(), ..Project::default() }.text(file, None)
    }

    /// Writes [`text`](Self::text) to `file`. The document keeps its own file.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn export(&self, file: &Path) -> Result<(), FileError> {
        Project { params: self.params.clone(), ..Project::default() }.write(file)
    }

    /// Content of the document's project file.
    pub(crate) fn project(&self) -> Project<P> {
        let used = files_in(&self.params);
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

    fn files(&self) -> Vec<PathBuf> {
        files_in(&self.params)
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

    fn begin_saving(&mut self, file: &Path) -> Result<Saving, FileError> {
        check_name(file)?;
        let text = self.project().text(file, None)?;
        let known = self.file_sha256.clone().filter(|_| self.file.as_deref() == Some(file));
        let number = next_revision();
        self.saving = Some((number, self.params.clone(), self.kept.clone()));
        Ok(Saving { file: file.to_owned(), text, known, number })
    }

    fn end_saving(&mut self, saving: &Saving) {
        if let Some((_, params, kept)) = self.saving.take_if(|(number, ..)| *number == saving.number) {
            (self.file, self.file_sha256) = (Some(saving.file.clone()), Some(saving.sha256()));
            (self.saved, self.saved_kept) = (Some(params), kept);
        }
    }

    fn copy(&self, copy: &Path) -> Result<String, FileError> {
        let (file, sha256) = (self.file.as_deref().map(absolute), self.file_sha256.clone());
        self.project().text(copy, Some(CopyNote { file, sha256, part: self.params.part() }))
    }
}

/// A number that was not used before.
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

/// The files in `params`, each once.
pub fn files_in(params: &impl Params) -> Vec<PathBuf> {
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
