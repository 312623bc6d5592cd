//! The project file (`.sparkpath`): the parameters as JSON, with the meshes' paths relative to the file and the
//! SHA-256 of what they held.
//!
//! ```json
//! {"format": "sparkpath-project", "version": 1, "job": {...}, "meshes": [{"path": "part.stl", "sha256": "..."}]}
//! ```

use std::io::Read;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::job_file::PlanJob;
use super::kept_plan::{KeptPlan, KeptRun};
use files::atomic::atomic_write;
use files::paths::{absolute, relative, without_detours};

/// What a project file holds. Paths are as seen from the working folder, not from the file.
#[derive(Debug, Clone, PartialEq)]
pub struct ProjectFile {
    /// The parameters.
    pub job: PlanJob,
    /// The meshes they name, as far as these have been read.
    pub meshes: Vec<MeshReference>,
    /// The plan that was made of them, if there was one.
    pub plan: Option<KeptPlan>,
    /// Plans that are kept to compare with.
    pub runs: Vec<KeptRun>,
}

/// A mesh file and what it held.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeshReference {
    /// The file.
    pub path: PathBuf,
    /// SHA-256 of its content in hexadecimal, as the importer gives it.
    pub sha256: String,
}

/// A mesh that is not what the project was made with.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MovedMesh {
    /// Where it was.
    pub path: PathBuf,
    /// Whether there still is a file, with other content.
    pub changed: bool,
}

/// Why a project file cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum ProjectFileError {
    /// It cannot be read.
    #[error("{path}: cannot be read ({source}); check the path")]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// It is no project file, or not one of this version.
    #[error("{path}: {problem}")]
    Invalid {
        /// The file.
        path: PathBuf,
        /// What is wrong and what to do.
        problem: String,
    },
    /// It cannot be written.
    #[error("{path}: cannot be written ({source}); save it elsewhere")]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// It would be larger than what is read again.
    #[error(
        "{path}: not written, as the project would have {size} bytes and at most {most} are read again; remove kept runs \
         or plan with a greater step"
    )]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// What it would have (bytes).
        size: u64,
        /// What it may have (bytes).
        most: u64,
    },
}

const FORMAT: &str = "sparkpath-project";
/// The second one may hold runs; without any a file is still of the first.
const VERSION: u32 = 2;
/// The largest file that is written or read (bytes): some 170 000 nodes, far more than any plan has.
const LARGEST: u64 = 64 << 20;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Content {
    format: String,
    version: u32,
    job: serde_json::Value,
    #[serde(default)]
    meshes: Vec<MeshReference>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    plan: Option<KeptPlan>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    runs: Vec<RunContent>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct RunContent {
    number: usize,
    colour: usize,
    job: serde_json::Value,
    plan: KeptPlan,
}

/// What every version has, to tell a newer file from a broken one.
#[derive(Deserialize)]
struct Head {
    format: String,
    version: u32,
}

impl ProjectFile {
    /// Reads a project file.
    ///
    /// # Errors
    /// If it cannot be read, is no project file, is of a newer version, or holds a parameter that is not known.
    pub fn read(path: &Path) -> Result<Self, ProjectFileError> {
        Self::read_up_to(path, LARGEST)
    }

    fn read_up_to(path: &Path, most: u64) -> Result<Self, ProjectFileError> {
        let unreadable = |source| ProjectFileError::Unreadable { path: path.to_owned(), source };
        let invalid = |problem| ProjectFileError::Invalid { path: path.to_owned(), problem };
        let mut text = String::new();
        let file = std::fs::File::open(path).map_err(unreadable)?;
        file.take(most + 1).read_to_string(&mut text).map_err(unreadable)?;
        if text.len() as u64 > most {
            let most = most >> 20;
            return Err(invalid(format!("it is larger than any Sparkpath project ({most} MiB); open another file")));
        }
        Self::parse(&text, path.parent().unwrap_or(Path::new(""))).map_err(invalid)
    }

    /// The project of the built-in demonstration, with its plan.
    pub fn demonstration() -> Self {
        let built_in = include_str!("../../../../assets/demonstration.sparkpath");
        // A test opens it; were it damaged, the demonstration would start without its plan.
        let bare = || Self { job: PlanJob::demonstration(), meshes: Vec::new(), plan: None, runs: Vec::new() };
        Self::parse(built_in, Path::new("")).unwrap_or_else(|_| bare())
    }

    fn parse(text: &str, folder: &Path) -> Result<Self, String> {
        let head: Head = serde_json::from_str(text)
            .map_err(|e| format!("this is no Sparkpath project ({e}); open a .sparkpath file"))?;
        if head.format != FORMAT {
            return Err(format!("this is no Sparkpath project but \"{}\"; open a .sparkpath file", head.format));
        }
        if head.version > VERSION {
            return Err(format!(
                "this project was saved by a newer Sparkpath (version {} of the file, {VERSION} is known here); \
                 open it with that one",
                head.version
            ));
        }
        let content: Content = serde_json::from_str(text).map_err(|e| format!("the project is damaged: {e}"))?;
        let job_of = |content| {
            let mut job = PlanJob::from_json(content, folder).map_err(|e| format!("the project is damaged: {e}"))?;
            for mesh in [&mut job.blisk.mesh, &mut job.electrode.mesh] {
                *mesh = mesh.take().map(|p| without_detours(&p));
            }
            Ok::<_, String>(job)
        };
        let job = job_of(content.job)?;
        let run = |run: RunContent| {
            let RunContent { number, colour, job, plan } = run;
            Ok::<_, String>(KeptRun { number, colour, job: job_of(job)?, plan })
        };
        let runs = content.runs.into_iter().map(run).collect::<Result<_, _>>()?;
        let path = |m: &MeshReference| without_detours(&folder.join(&m.path));
        let meshes = content.meshes.into_iter().map(|m| MeshReference { path: path(&m), ..m }).collect();
        Ok(Self { job, meshes, plan: content.plan, runs })
    }

    /// Writes the project file, under a temporary name first.
    ///
    /// # Errors
    /// If it cannot be written, or could not be read again; what was there before then still is.
    pub fn write(&self, path: &Path) -> Result<(), ProjectFileError> {
        self.write_up_to(path, LARGEST)
    }

    fn write_up_to(&self, path: &Path, most: u64) -> Result<(), ProjectFileError> {
        let unwritable = |source| ProjectFileError::Unwritable { path: path.to_owned(), source };
        let text = self.text(path).map_err(|e| unwritable(e.into()))?;
        let size = text.len() as u64;
        if size > most {
            return Err(ProjectFileError::TooLarge { path: path.to_owned(), size, most });
        }
        atomic_write(path, |out| out.write_all(text.as_bytes())).map_err(unwritable)
    }

    pub(super) fn text(&self, path: &Path) -> Result<String, serde_json::Error> {
        let folder = absolute(path.parent().unwrap_or(Path::new("")));
        let meshes = self
            .meshes
            .iter()
            .map(|m| MeshReference { path: relative(&m.path, &folder), sha256: m.sha256.clone() })
            .collect();
        let (job, plan) = (serde_json::to_value(self.job.seen_from(&folder))?, self.plan.clone());
        let run = |run: &KeptRun| {
            let KeptRun { number, colour, job, plan } = run.clone();
            Ok::<_, serde_json::Error>(RunContent {
                number,
                colour,
                job: serde_json::to_value(job.seen_from(&folder))?,
                plan,
            })
        };
        let runs = self.runs.iter().map(run).collect::<Result<Vec<_>, _>>()?;
        let version = if runs.is_empty() { 1 } else { VERSION };
        let content = Content { format: FORMAT.to_owned(), version, job, meshes, plan, runs };
        serde_json::to_string_pretty(&content).map(|text| text + "\n")
    }

    /// The meshes that are gone or hold something else than when the project was saved.
    pub fn moved_meshes(&self) -> Vec<MovedMesh> {
        let mut moved = Vec::new();
        for path in [&self.job.blisk.mesh, &self.job.electrode.mesh].into_iter().flatten() {
            let known = self.meshes.iter().find(|m| &m.path == path);
            match sha256_of(path) {
                Err(_) => moved.push(MovedMesh { path: path.clone(), changed: false }),
                Ok(now) if known.is_some_and(|m| m.sha256 != now) && !has_buffers(path) => {
                    moved.push(MovedMesh { path: path.clone(), changed: true });
                }
                Ok(_) => {}
            }
        }
        moved
    }

    /// Puts `found` in the place of the mesh that was at `path`, whatever it holds.
    pub fn replace_mesh(&mut self, path: &Path, found: &Path) {
        let jobs = std::iter::once(&mut self.job).chain(self.runs.iter_mut().map(|run| &mut run.job));
        for mesh in jobs.flat_map(|job| [&mut job.blisk.mesh, &mut job.electrode.mesh]) {
            if mesh.as_deref() == Some(path) {
                *mesh = Some(found.to_owned());
            }
        }
        self.meshes.retain(|m| m.path != path && m.path != found);
    }
}

/// A glTF's hash covers its buffer files too, which only the importer knows.
fn has_buffers(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("gltf"))
}

fn sha256_of(path: &Path) -> std::io::Result<String> {
    let mut file = std::fs::File::open(path)?;
    let mut hash = Sha256::new();
    let mut block = vec![0; 1 << 20];
    loop {
        let n = file.read(&mut block)?;
        if n == 0 {
            return Ok(hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect());
        }
        hash.update(&block[..n]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn project(folder: &Path) -> ProjectFile {
        let mesh = folder.join("part.stl");
        std::fs::write(&mesh, "solid").unwrap();
        let mut job = PlanJob::demonstration();
        job.blisk.mesh = Some(mesh.clone());
        job.electrode.circumferential_reduction_deg = [0.1 + 0.2, 1.0 / 3.0];
        job.blisk.options.blades = wheel::options::Auto::Given(60);
        ProjectFile {
            job,
            plan: None,
            runs: Vec::new(),
            meshes: vec![MeshReference { sha256: sha256_of(&mesh).unwrap(), path: mesh }],
        }
    }

    #[test]
    fn a_project_survives_saving_and_opening_to_the_last_bit() {
        let folder = tempfile::tempdir().unwrap();
        let project = project(folder.path());
        let file = folder.path().join("a.sparkpath");
        project.write(&file).unwrap();
        assert_eq!(ProjectFile::read(&file).unwrap(), project);
        let plan = ProjectFile::demonstration().plan.unwrap();
        let run = KeptRun { number: 3, colour: 1, job: project.job.clone(), plan };
        let with_run = ProjectFile { runs: vec![run], ..project.clone() };
        with_run.write(&file).unwrap();
        assert_eq!(ProjectFile::read(&file).unwrap(), with_run);
        let mut demonstration = project.clone();
        demonstration.job = PlanJob::demonstration();
        demonstration.write(&file).unwrap();
        assert_eq!(ProjectFile::read(&file).unwrap().job, demonstration.job);
    }

    #[test]
    fn what_is_written_can_be_read_and_what_cannot_is_not_written() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("long.sparkpath");
        let project = project(folder.path());
        project.write(&file).unwrap();
        let most = std::fs::metadata(&file).unwrap().len();
        assert!(ProjectFile::read_up_to(&file, most).unwrap() == project);
        let mut longer = project.clone();
        longer.plan = Some(KeptPlan { inputs: String::new(), electrodes: Vec::new() });
        let problem = longer.write_up_to(&file, most).unwrap_err().to_string();
        assert!(problem.contains("not written") && problem.contains(&format!("at most {most}")), "{problem}");
        assert!(ProjectFile::read_up_to(&file, most).unwrap() == project, "what was there still is");
        longer.write(&file).unwrap();
        let problem = ProjectFile::read_up_to(&file, most).unwrap_err().to_string();
        assert!(problem.contains("larger than any"), "{problem}");
    }

    #[test]
    fn a_project_moved_together_with_its_meshes_still_opens() {
        let folder = tempfile::tempdir().unwrap();
        let (old, new) = (folder.path().join("old"), folder.path().join("new"));
        std::fs::create_dir(&old).unwrap();
        project(&old).write(&old.join("a.sparkpath")).unwrap();
        std::fs::rename(&old, &new).unwrap();
        let read = ProjectFile::read(&new.join("a.sparkpath")).unwrap();
        assert_eq!(read.job.blisk.mesh.as_deref(), Some(&*new.join("part.stl")));
        assert_eq!(read.moved_meshes(), []);
    }

    #[test]
    fn lost_and_changed_meshes_are_told_apart() {
        let folder = tempfile::tempdir().unwrap();
        let mut project = project(folder.path());
        let mesh = folder.path().join("part.stl");
        std::fs::write(&mesh, "other").unwrap();
        assert_eq!(project.moved_meshes(), [MovedMesh { path: mesh.clone(), changed: true }]);
        std::fs::remove_file(&mesh).unwrap();
        assert_eq!(project.moved_meshes(), [MovedMesh { path: mesh.clone(), changed: false }]);
        let found = folder.path().join("found.stl");
        std::fs::write(&found, "anything").unwrap();
        project.replace_mesh(&mesh, &found);
        assert_eq!(project.moved_meshes(), []);
    }

    #[test]
    fn what_is_no_project_is_refused_in_one_line() {
        let job = serde_json::to_value(PlanJob::demonstration()).unwrap();
        let newer = serde_json::json!({"format": FORMAT, "version": VERSION + 1, "job": job});
        let foreign = serde_json::json!({"format": "gltf", "version": 1});
        let mut wrong = serde_json::json!({"format": FORMAT, "version": VERSION, "job": job});
        wrong["job"]["plan"]["step_mm"] = "wide".into();
        for (text, named) in [
            ("solid cube".to_owned(), "no Sparkpath project"),
            (newer.to_string(), "newer"),
            (foreign.to_string(), "gltf"),
            (wrong.to_string(), "plan: "),
        ] {
            let problem = ProjectFile::parse(&text, Path::new("")).unwrap_err();
            assert!(problem.contains(named) && !problem.contains('\n'), "{problem}");
        }
    }

    #[test]
    fn the_demonstration_comes_with_a_plan_for_its_own_parameters() {
        let ProjectFile { job, plan, .. } = ProjectFile::demonstration();
        assert_eq!(job, PlanJob::demonstration());
        let plan = plan.expect("open the demonstration, plan, and save it as assets/demonstration.sparkpath");
        assert_eq!(plan.inputs, KeptPlan::inputs_of(&job, ""), "plan it again, and save it");
    }
}
