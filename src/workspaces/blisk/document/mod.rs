//! The document: the parameters of a job with undo and redo, its file, and whether there is unsaved work.

pub mod choice;
pub mod field_table;
pub mod fields;
pub mod job_file;
pub mod kept_plan;
pub mod machine_file;
pub mod project_file;
pub mod stage;

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};

use crate::workspaces::blisk::document::job_file::PlanJob;
use crate::workspaces::blisk::document::kept_plan::{KeptPlan, KeptRun};
use crate::workspaces::blisk::document::project_file::{MeshReference, MovedMesh, ProjectFile, ProjectFileError};
use files::old_history::History;
use files::{AnyDocument, FileError};

/// The parameters of a job as a user edits them.
#[derive(Debug, Clone, PartialEq)]
pub struct Document {
    job: PlanJob,
    history: History<PlanJob>,
    file: Option<PathBuf>,
    /// What its file holds, or what a new document starts with; none if no file holds anything of it.
    saved: Option<PlanJob>,
    /// Meshes as they were when they were last read, for the project file.
    meshes: Vec<MeshReference>,
    /// The plan that was made last.
    plan: Option<KeptPlan>,
    /// Plans kept to compare with, and those of them that its file holds.
    runs: Vec<KeptRun>,
    saved_runs: Vec<KeptRun>,
}

/// Why a project file cannot be opened as it stands.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// It cannot be read.
    #[error(transparent)]
    File(#[from] ProjectFileError),
    /// Meshes it names are gone or have other content: the user has to say what to do.
    #[error("{} of the meshes of this project are not where they were or have changed", .1.len())]
    Moved(Box<ProjectFile>, Vec<MovedMesh>),
}

impl Default for Document {
    fn default() -> Self {
        let ProjectFile { job, meshes, plan, .. } = ProjectFile::demonstration();
        Self { meshes, plan, ..Self::new(job) }
    }
}

impl Document {
    /// A new document, not yet saved and without unsaved work.
    pub fn new(job: PlanJob) -> Self {
        Self {
            saved: Some(job.clone()),
            job,
            history: History::default(),
            file: None,
            meshes: Vec::new(),
            plan: None,
            runs: Vec::new(),
            saved_runs: Vec::new(),
        }
    }

    /// A new document for the blisk in the mesh file `mesh`, all else by default.
    pub fn for_mesh(mesh: &Path) -> Self {
        let mut job = PlanJob::demonstration();
        job.electrode = Default::default();
        job.blisk.mesh = Some(mesh.to_owned());
        Self::new(job)
    }

    /// Opens a project file whose meshes are where they were.
    ///
    /// # Errors
    /// [`OpenError::Moved`] carries what was read, for [`opened`](Self::opened) once the user has answered.
    pub fn open(path: &Path) -> Result<Self, OpenError> {
        let project = ProjectFile::read(path)?;
        let moved = project.moved_meshes();
        if !moved.is_empty() {
            return Err(OpenError::Moved(Box::new(project), moved));
        }
        let ProjectFile { job, meshes, plan, runs } = project;
        Ok(Self { file: Some(path.to_owned()), meshes, plan, saved_runs: runs.clone(), runs, ..Self::new(job) })
    }

    /// The document of a project file whose user has said what shall stand for its meshes: where that is not what
    /// the file says, there is unsaved work.
    pub fn opened(project: ProjectFile, path: &Path) -> Self {
        let ProjectFile { job, meshes, plan, runs } = project;
        let saved = ProjectFile::read(path).ok().map(|held| held.job);
        Self { file: Some(path.to_owned()), meshes, plan, saved, saved_runs: runs.clone(), runs, ..Self::new(job) }
    }

    /// A document from an autosaved copy: unsaved work, to be saved as `file`.
    pub fn recovered(project: ProjectFile, file: Option<PathBuf>) -> Self {
        let ProjectFile { job, meshes, plan, runs } = project;
        Self { file, meshes, plan, runs, saved: None, ..Self::new(job) }
    }

    /// The parameters.
    pub fn job(&self) -> &PlanJob {
        &self.job
    }

    /// The project file, if there is one.
    pub fn file(&self) -> Option<&Path> {
        self.file.as_deref()
    }

    /// The name to show: that of the file, or of the mesh.
    pub fn name(&self) -> String {
        let path = self.file.as_ref().or(self.job.blisk.mesh.as_ref());
        path.and_then(|p| p.file_stem())
            .map_or_else(|| "Demonstration blisk".to_owned(), |n| n.to_string_lossy().into_owned())
    }

    /// Whether there are changes that no file holds.
    pub fn is_unsaved(&self) -> bool {
        self.saved.as_ref() != Some(&self.job) || self.saved_runs != self.runs
    }

    /// Makes `job` the parameters, as one step named `label`; those of one `gesture` (a drag, a number being typed)
    /// make one step together. Nothing happens if nothing changes. Tells whether something did.
    pub fn edit(&mut self, label: &str, job: PlanJob, gesture: Option<u64>) -> bool {
        if job == self.job {
            return false;
        }
        self.history.record(label, &self.job, gesture);
        self.job = job;
        true
    }

    /// Takes the last step back. Tells whether there was one.
    pub fn undo(&mut self) -> bool {
        let before = self.history.undo(&self.job);
        before.map(|job| self.job = job).is_some()
    }

    /// Does the step again that was taken back last. Tells whether there was one.
    pub fn redo(&mut self) -> bool {
        let after = self.history.redo(&self.job);
        after.map(|job| self.job = job).is_some()
    }

    /// What undo would take back.
    pub fn undo_label(&self) -> Option<&str> {
        self.history.undo_label()
    }

    /// What redo would do again.
    pub fn redo_label(&self) -> Option<&str> {
        self.history.redo_label()
    }

    /// Notes the content of a mesh file that was read, for the project file.
    pub fn note_mesh(&mut self, path: &Path, sha256: &str) {
        self.meshes.retain(|m| m.path != path);
        self.meshes.push(MeshReference { path: path.to_owned(), sha256: sha256.to_owned() });
    }

    /// What a file of this document holds.
    pub fn project_file(&self) -> ProjectFile {
        let used = |m: &&MeshReference| {
            [&self.job.blisk.mesh, &self.job.electrode.mesh].iter().any(|p| p.as_ref() == Some(&m.path))
        };
        ProjectFile {
            job: self.job.clone(),
            meshes: self.meshes.iter().filter(used).cloned().collect(),
            plan: self.plan.clone(),
            runs: self.runs.clone(),
        }
    }

    /// The plan that was made last, or came with the file.
    pub fn plan(&self) -> Option<&KeptPlan> {
        self.plan.as_ref()
    }

    /// Notes a plan, for the project file. A plan alone is no unsaved work: the same search finds it again.
    pub fn note_plan(&mut self, plan: KeptPlan) {
        self.plan = Some(plan);
    }

    /// The plans that are kept to compare with, in the order of keeping.
    pub fn runs(&self) -> &[KeptRun] {
        &self.runs
    }

    /// Keeps a plan to compare with. That is unsaved work: its parameters may be nowhere else.
    pub fn keep_run(&mut self, run: KeptRun) {
        self.runs.push(run);
    }

    /// Keeps the run with this number no longer.
    pub fn drop_run(&mut self, number: usize) {
        self.runs.retain(|run| run.number != number);
    }

    /// Saves as `path` and makes it the document's file.
    ///
    /// # Errors
    /// If it cannot be written; what was there before then still is.
    pub fn save_as(&mut self, path: &Path) -> Result<(), ProjectFileError> {
        self.project_file().write(path)?;
        self.file = Some(path.to_owned());
        self.saved = Some(self.job.clone());
        self.saved_runs = self.runs.clone();
        Ok(())
    }
}

impl AnyDocument for Document {
    fn kind(&self) -> &'static str {
        "blisk"
    }

    fn name(&self) -> String {
        self.name()
    }

    fn file(&self) -> Option<&Path> {
        self.file()
    }

    fn is_unsaved(&self) -> bool {
        self.is_unsaved()
    }

    fn revision(&self) -> u64 {
        let mut hash = DefaultHasher::new();
        self.project_file().text(Path::new("project")).ok().hash(&mut hash);
        hash.finish()
    }

    fn content_revision(&self) -> u64 {
        AnyDocument::revision(self)
    }

    fn undo_label(&self, again: bool) -> Option<&str> {
        if again { self.redo_label() } else { self.undo_label() }
    }

    fn undo(&mut self, again: bool) -> bool {
        if again { self.redo() } else { self.undo() }
    }

    fn save_as(&mut self, file: &Path) -> Result<(), FileError> {
        let error = |e: ProjectFileError| match e {
            ProjectFileError::Unwritable { path, source } => FileError::Unwritable { file: path, source },
            other => FileError::NotWritten { file: file.to_owned(), problem: other.to_string() },
        };
        self.save_as(file).map_err(error)
    }

    fn copy(&self, copy: &Path) -> Result<Option<String>, FileError> {
        let text = self.project_file().text(copy);
        text.map(Some).map_err(|e| FileError::NotWritten { file: copy.to_owned(), problem: e.to_string() })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn with_radial(job: &PlanJob, mm: f64) -> PlanJob {
        let mut job = job.clone();
        job.electrode.radial_reduction_mm = mm;
        job
    }

    #[test]
    fn one_drag_is_one_step_and_the_next_another() {
        let mut document = Document::default();
        let start = document.job().clone();
        for mm in [0.6, 0.7, 0.8] {
            document.edit("radial", with_radial(&start, mm), Some(1));
        }
        document.edit("radial", with_radial(&start, 0.9), Some(2));
        assert!(document.undo());
        assert_eq!(document.job().electrode.radial_reduction_mm, 0.8);
        assert!(document.undo());
        assert_eq!(document.job(), &start);
        assert!(!document.undo() && !document.is_unsaved());
    }

    #[test]
    fn a_new_edit_ends_what_could_be_done_again() {
        let mut document = Document::default();
        let start = document.job().clone();
        document.edit("a", with_radial(&start, 0.6), None);
        document.undo();
        assert_eq!(document.redo_label(), Some("a"));
        document.edit("b", with_radial(&start, 0.7), None);
        assert!(!document.redo());
        assert_eq!(document.undo_label(), Some("b"));
    }

    #[test]
    fn recovered_work_counts_as_unsaved_whatever_is_done_to_it() {
        let mut document = Document::recovered(Document::default().project_file(), None);
        assert!(document.is_unsaved());
        let mut job = document.job().clone();
        for seed in 0..5 {
            job.genetic.seed = seed;
            document.edit("Seed", job.clone(), None);
            assert!(document.is_unsaved(), "seed {seed}");
        }
        let folder = tempfile::tempdir().unwrap();
        document.save_as(&folder.path().join("a.sparkpath")).unwrap();
        assert!(!document.is_unsaved());
    }

    #[test]
    fn a_mesh_that_was_found_elsewhere_is_unsaved_work() {
        let folder = tempfile::tempdir().unwrap();
        let [old, found, file] = ["old.stl", "found.stl", "a.sparkpath"].map(|name| folder.path().join(name));
        std::fs::write(&found, "solid").unwrap();
        Document::for_mesh(&old).save_as(&file).unwrap();
        let Err(OpenError::Moved(mut project, _)) = Document::open(&file) else { panic!("the mesh is not there") };
        assert!(!Document::opened((*project).clone(), &file).is_unsaved());
        project.replace_mesh(&old, &found);
        let mut document = Document::opened(*project, &file);
        assert!(document.is_unsaved(), "the file names another mesh");
        document.save_as(&file).unwrap();
        assert_eq!(Document::open(&file).unwrap().job().blisk.mesh.as_ref(), Some(&found));
    }

    proptest! {
        /// Undoing every step gives the start again, and doing them all again the end.
        #[test]
        fn undo_and_redo_are_inverse(values in prop::collection::vec((0.0..5.0_f64, prop::option::of(0..3_u64)), 1..20)) {
            let mut document = Document::default();
            let start = document.job().clone();
            for (mm, gesture) in values {
                document.edit("radial", with_radial(&start, mm), gesture);
            }
            let end = document.job().clone();
            while document.undo() {}
            prop_assert_eq!(document.job(), &start);
            while document.redo() {}
            prop_assert_eq!(document.job(), &end);
        }
    }
}
