//! The folder of a study: set up once, run in any number of pieces.

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use super::answer::{Answer, BAD, NO, YES};
use super::base::{Base, LIBRARY, Setting};
use super::definition::{Collect, Parameter, STUDIES, Study, text_of};
use super::evaluate::{evaluate, is_place, named_results};
use super::sampling::{Axis, Values, points};
use crate::panic_text;
use crate::workspaces::mold::paths::meshes_in;
use files::{FileError, Invalid, PartFile, atomic_write, paths, sha256, sha256_of, write_bytes};
use task::{Cancel, Task};

/// The study in its folder.
pub const STUDY: &str = "study.toml";
/// The project in the folder of a study.
const PROJECT: &str = "project.sparkpath";
/// The workflow in the folder of a study.
const SNAKEFILE: &str = "Snakefile";

/// Reason why a study cannot be set up, run or collected.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// A file cannot be read or written, or says what is not possible.
    #[error(transparent)]
    File(#[from] FileError),
    /// The folder belongs to another study.
    #[error("{}: another study is in this folder, {what}; choose another folder, or remove this one", folder.display())]
    Another {
        /// The folder.
        folder: PathBuf,
        /// Difference from the study that was asked for.
        what: &'static str,
    },
    /// The answers cannot be put side by side.
    #[error("{}: {problem}; remove the folders of the points that are to be computed anew", folder.display())]
    Mixed {
        /// The folder of the points.
        folder: PathBuf,
        /// Difference of the answers, with points.
        problem: String,
    },
    /// There is no point of this number.
    #[error("{}: there is no point {point}; the study has {count}", folder.display())]
    NoPoint {
        /// The folder.
        folder: PathBuf,
        /// Number asked for.
        point: usize,
        /// Number of points.
        count: usize,
    },
    /// A point needs to be run again for a result that was not asked for before.
    #[error("{}: point {point} has no result {column}; run the study again, which computes it", folder.display())]
    NoColumn {
        /// The folder.
        folder: PathBuf,
        /// Number of the point.
        point: usize,
        /// The result.
        column: String,
    },
    /// The page cannot be made.
    #[error(transparent)]
    Page(#[from] files::report::PageError),
    /// The program failed.
    #[error("internal error: {0}; please report it with the files that led to it")]
    Internal(String),
    /// The work was stopped.
    #[error("cancelled")]
    Cancelled,
}

/// A study in its folder.
#[derive(Debug)]
pub struct StudyFolder {
    folder: PathBuf,
    study: Study,
    base: Base,
    keys: Vec<String>,
    points: Vec<Vec<String>>,
    sha256: String,
}

/// Numbers of points.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
pub struct Counts {
    /// All.
    pub points: usize,
    /// Points whose answer is yes.
    pub feasible: usize,
    /// Points whose answer is no.
    pub not_feasible: usize,
    /// Points that cannot be.
    pub bad: usize,
    /// Points that have no answer yet.
    pub open: usize,
}

impl Counts {
    /// The numbers in a sentence.
    pub fn sentence(&self) -> String {
        let Self { points, feasible, not_feasible, bad, open } = self;
        let open = if *open > 0 { format!(", {open} open") } else { String::new() };
        let points = files::report::counted(*points, "point");
        format!("{points}: {feasible} feasible, {not_feasible} not feasible, {bad} bad{open}.")
    }
}

/// Points that were run.
#[derive(Debug, Default)]
pub struct Ran {
    /// Points without an answer because the program failed, with the reason. They are tried again by the next run.
    pub failed: Vec<(usize, String)>,
    /// Whether the work was stopped before all points were run.
    pub is_stopped: bool,
}

impl StudyFolder {
    /// Sets up `folder` for the study in `file`, or goes on with it if it is there already. `seed` takes the place of the
    /// project's seed; a new mold is as the standard in `user_folder` says.
    ///
    /// # Errors
    /// [`StudyError`]; if another study is in the folder, nothing is changed.
    pub fn create(
        file: &Path,
        folder: &Path,
        seed: Option<u64>,
        user_folder: Option<&Path>,
    ) -> Result<Self, StudyError> {
        let text = STUDIES.read_text(file)?;
        let study = STUDIES.parse(&text, file)?;
        let placed = |problem| FileError::placed(file, &text, problem);
        let own = paths::folder_of(file);
        let base = Base::read(&own.join(&study.project), study.command, user_folder)?.with_seed(seed);
        Self::set_up(study, &base, &own, folder, &placed)
    }

    /// Sets up `folder` for a study of `base`, or goes on with it if it is there already. Paths in the study are as seen from
    /// the folder `own`; `placed` makes a problem of the study an error of its file.
    ///
    /// # Errors
    /// [`StudyError`]; if another study is in the folder, nothing is changed.
    pub fn set_up(
        study: Study,
        base: &Base,
        own: &Path,
        folder: &Path,
        placed: &dyn Fn(Invalid) -> FileError,
    ) -> Result<Self, StudyError> {
        check_columns(&study).map_err(placed)?;
        let (folder, to) = (folder.to_owned(), paths::absolute(folder));
        let study = resolved(study, base, own, &to).map_err(placed)?;
        let all = axes(&study, base).and_then(|axes| points(&axes, &study.sampling)).map_err(placed)?;
        let project = base.text(&to.join(PROJECT))?;
        let there = folder.join(STUDY);
        if there.exists() {
            let former = STUDIES.read(&there)?;
            let another = |what| StudyError::Another { folder: folder.clone(), what };
            if (Study { collect: study.collect.clone(), ..former }) != study {
                return Err(another("with other parameters, values or samples"));
            }
            if files::read_text(&folder.join(PROJECT), "project", files::LARGEST_PROJECT)? != project {
                return Err(another("of another project, or of this one before it was changed"));
            }
        }
        std::fs::create_dir_all(&folder).map_err(|source| FileError::unwritable(&folder, source))?;
        let snakefile = include_str!("Snakefile").replace("@COUNT@", &all.len().to_string());
        for (name, text) in [(PROJECT, project), (SNAKEFILE, snakefile)] {
            write_unless_same(&folder.join(name), &text)?;
        }
        // What opens the folder comes last.
        write_unless_same(&there, &STUDIES.text(&there, &study)?)?;
        Self::open(&folder)
    }

    /// Opens the folder of a study.
    ///
    /// # Errors
    /// [`StudyError`].
    pub fn open(folder: &Path) -> Result<Self, StudyError> {
        let file = folder.join(STUDY);
        let text = STUDIES.read_text(&file)?;
        let study = STUDIES.parse(&text, &file)?;
        let placed = |problem| FileError::placed(&file, &text, problem);
        check_columns(&study).map_err(placed)?;
        let here = paths::absolute(folder);
        let base = Base::read(&here.join(&study.project), study.command, None)?;
        let axes = axes(&study, &base).map_err(placed)?;
        let points = points(&axes, &study.sampling).map_err(placed)?;
        let keys = axes.into_iter().map(|axis| axis.key).collect();
        let without_columns = Study { collect: Collect::default(), ..study.clone() };
        let content = STUDIES.text(&file, &without_columns)? + &base.text(&here.join(PROJECT))?;
        Ok(Self { folder: folder.to_owned(), study, base, keys, points, sha256: sha256(content.as_bytes()) })
    }

    /// The study.
    pub fn study(&self) -> &Study {
        &self.study
    }

    /// The project that is varied.
    pub fn base(&self) -> &Base {
        &self.base
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Keys of the parameters that are varied.
    pub fn keys(&self) -> &[String] {
        &self.keys
    }

    /// The points: for each the values of the parameters in their order.
    pub fn points(&self) -> &[Vec<String>] {
        &self.points
    }

    /// Folder of a point, which is counted from 1.
    pub fn folder_of(&self, point: usize) -> PathBuf {
        self.folder.join("points").join(format!("{point:06}"))
    }

    fn settings(&self, point: usize) -> Vec<Setting<'_>> {
        self.keys.iter().zip(&self.points[point - 1]).map(|(key, value)| (key.as_str(), value.as_str())).collect()
    }

    /// A point in words.
    pub fn words(&self, point: usize) -> String {
        let words: Vec<String> = self.settings(point).iter().map(|(key, value)| format!("{key}={value}")).collect();
        words.join(" ")
    }

    /// The answers of all points; none where there is none.
    ///
    /// # Errors
    /// [`StudyError`] of a file that is no answer.
    pub fn answers(&self) -> Result<Vec<Option<Answer>>, StudyError> {
        let of = |point| Ok(Answer::read(&self.folder_of(point).join("answer.json"), point)?);
        (1..=self.points.len()).map(of).collect()
    }

    /// Numbers of points by their answers.
    pub fn counts(&self, answers: &[Option<Answer>]) -> Counts {
        let count = |code| answers.iter().flatten().filter(|answer| answer.exit_code == code).count();
        let open = answers.iter().filter(|answer| answer.is_none()).count();
        Counts { points: answers.len(), feasible: count(YES), not_feasible: count(NO), bad: count(BAD), open }
    }

    /// Checks that `answers` can be put side by side: by this version of the program, of this study, from the same files.
    ///
    /// # Errors
    /// [`StudyError::Mixed`].
    pub fn check(&self, answers: &[Option<Answer>]) -> Result<(), StudyError> {
        let mixed = |problem| Err(StudyError::Mixed { folder: self.folder.join("points"), problem });
        // First of all, as another version may write the same study in other words.
        let mut versions: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
        for answer in answers.iter().flatten() {
            versions.entry(&answer.program_version).or_default().push(answer.point);
        }
        let own = env!("CARGO_PKG_VERSION");
        if versions.keys().any(|version| *version != own) {
            let of = |(version, points): (&&str, &Vec<usize>)| format!("{version} (point{})", ranges(points));
            let all: Vec<String> = versions.iter().map(of).collect();
            return mixed(format!("this program is version {own}, and the answers are of {}", all.join(", ")));
        }
        let mut inputs: BTreeMap<&Path, (&str, usize)> = BTreeMap::new();
        for answer in answers.iter().flatten() {
            let point = answer.point;
            if answer.study_sha256 != self.sha256 {
                return mixed(format!("the answer of point {point} is of another study or of a changed project"));
            }
            for file in &answer.inputs {
                let (sha256, other) = *inputs.entry(&file.path).or_insert((&file.sha256, point));
                if sha256 != file.sha256 {
                    let file = file.path.display();
                    return mixed(format!("{file} was another file for point {point} than for point {other}"));
                }
            }
        }
        Ok(())
    }

    /// Checks that answers from the files as they are now can stand beside `answers`.
    fn check_going_on(&self, answers: &[Option<Answer>]) -> Result<(), StudyError> {
        self.check(answers)?;
        let mut now: BTreeMap<&Path, Option<String>> = BTreeMap::new();
        for answer in answers.iter().flatten() {
            for file in &answer.inputs {
                let hash = || sha256_of(&self.folder.join(&file.path)).ok();
                if now.entry(&file.path).or_insert_with(hash).as_ref() != Some(&file.sha256) {
                    let (file, point) = (file.path.display(), answer.point);
                    let problem = format!("{file} is another file now than it was for point {point}");
                    return Err(StudyError::Mixed { folder: self.folder.join("points"), problem });
                }
            }
        }
        Ok(())
    }

    /// Runs a point and writes its answer.
    ///
    /// # Errors
    /// [`StudyError`]; nothing was written then, and the point can be tried again.
    pub fn run_point(&self, point: usize, task: &Task) -> Result<Answer, StudyError> {
        if !(1..=self.points.len()).contains(&point) {
            let (folder, count) = (self.folder.clone(), self.points.len());
            return Err(StudyError::NoPoint { folder, point, count });
        }
        let started = Instant::now();
        let (here, settings) = (paths::absolute(&self.folder), self.settings(point));
        let words = settings.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
        let mut answer = Answer::of(point, &self.sha256, words);
        let decide = |base: Base| base.with(&settings, &here).map_err(|problem| problem.to_string());
        let found = decide(self.base.clone()).and_then(|base| {
            answer.inputs = Self::inputs_of(&base, &settings, &here);
            evaluate(self.study.command, base, &decide, task)
        });
        // What a computation answers once it has been told to stop is that it stopped.
        task.check().map_err(|_| StudyError::Cancelled)?;
        let own = self.folder_of(point);
        std::fs::create_dir_all(&own).map_err(|source| FileError::unwritable(&own, source))?;
        match found {
            Err(why) => answer.sentence = why.split_whitespace().collect::<Vec<_>>().join(" "),
            Ok(found) => {
                answer.exit_code = if found.holds { YES } else { NO };
                answer.sentence.clone_from(&found.sentence);
                answer.results = found.results(self.columns());
                let project = own.join("point.sparkpath");
                let text = found.base.text(&paths::absolute(&project))?;
                write_bytes(&project, text.as_bytes())?;
            }
        }
        answer.seconds = started.elapsed().as_secs_f64();
        answer.write(&own.join("answer.json"))?;
        Ok(answer)
    }

    /// The files of a point that are there, as they are now.
    fn inputs_of(base: &Base, settings: &[Setting], here: &Path) -> Vec<PartFile> {
        let cutters = settings.iter().filter(|(key, _)| *key == LIBRARY);
        let cutters = cutters.map(|(_, file)| paths::without_detours(&here.join(file)));
        let part_file =
            |file: PathBuf| Some(PartFile { sha256: sha256_of(&file).ok()?, path: paths::relative(&file, here) });
        base.files().into_iter().chain(cutters).filter_map(part_file).collect()
    }

    /// Every column that is asked for, the goals included.
    fn columns(&self) -> impl Iterator<Item = &String> {
        let Collect { columns, less, more } = &self.study.collect;
        columns.iter().chain(less).chain(more)
    }

    /// Whether a point is to be run: it has no answer, or lacks a result that is asked for.
    fn is_open(&self, answer: Option<&Answer>) -> bool {
        answer.is_none_or(|answer| answer.exit_code != BAD && self.missing(answer).is_some())
    }

    /// A result that is asked for and that a point does not have, as it was not asked for when it was run.
    pub(super) fn missing(&self, answer: &Answer) -> Option<&String> {
        self.columns().find(|column| is_place(column) && !answer.results.contains_key(*column))
    }

    /// Runs every point that has no answer, as many at once as there are `threads`, and shows `found` each answer. What was
    /// answered before the work was stopped stays.
    ///
    /// # Errors
    /// [`StudyError`], also if an answer cannot be written.
    pub fn run(&self, threads: usize, task: &Task, found: &(dyn Fn(&Answer) + Sync)) -> Result<Ran, StudyError> {
        let answers = self.answers()?;
        self.check_going_on(&answers)?;
        let open: Vec<usize> = (1..=answers.len()).filter(|&i| self.is_open(answers[i - 1].as_ref())).collect();
        let all = answers.len();
        drop(answers);
        // Threads that no point has use of help with the points.
        let workers = threads.clamp(1, open.len().max(1));
        let each = (threads / workers).max(1);
        let (next, done) = (AtomicUsize::new(0), AtomicUsize::new(all - open.len()));
        let failed: Mutex<Vec<(usize, String)>> = Mutex::default();
        let broken: Mutex<Option<StudyError>> = Mutex::default();
        let stop = Cancel::default();
        let work = || {
            let pool = match rayon::ThreadPoolBuilder::new().num_threads(each).build() {
                Ok(pool) => pool,
                Err(error) => {
                    stop.cancel();
                    broken
                        .lock()
                        .unwrap_or_else(PoisonError::into_inner)
                        .replace(StudyError::Internal(error.to_string()));
                    return;
                }
            };
            while let Some(&point) = open.get(next.fetch_add(1, Ordering::Relaxed)) {
                if task.cancel.is_cancelled() || stop.is_cancelled() {
                    return;
                }
                let run = || pool.install(|| self.run_point(point, &Task::silent(&task.cancel)));
                match catch_unwind(AssertUnwindSafe(run)) {
                    Ok(Ok(answer)) => {
                        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
                        task.report("study", done as f64 / all as f64, &format!("{done} of {all} points"));
                        found(&answer);
                    }
                    Ok(Err(StudyError::Cancelled)) => return,
                    Ok(Err(error)) => {
                        stop.cancel();
                        broken.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
                        return;
                    }
                    Err(panic) => {
                        let why = panic_text(&*panic);
                        failed.lock().unwrap_or_else(PoisonError::into_inner).push((point, why));
                    }
                }
            }
        };
        task.report("study", (all - open.len()) as f64 / all as f64, "");
        std::thread::scope(|scope| {
            for _ in 0..workers {
                scope.spawn(work);
            }
        });
        if let Some(error) = broken.into_inner().unwrap_or_else(PoisonError::into_inner) {
            return Err(error);
        }
        let mut failed = failed.into_inner().unwrap_or_else(PoisonError::into_inner);
        failed.sort();
        Ok(Ran { failed, is_stopped: task.cancel.is_cancelled() })
    }
}

/// Writes a file unless it holds the same: what Snakemake looks at is the time of the last change.
fn write_unless_same(file: &Path, text: &str) -> Result<(), FileError> {
    if std::fs::read(file).is_ok_and(|bytes| bytes == text.as_bytes()) {
        return Ok(());
    }
    atomic_write(file, |to| to.write_all(text.as_bytes())).map_err(|source| FileError::unwritable(file, source))
}

/// Numbers in rising order as ranges, as in `s 1-3, 5`, or ` 5` for a single one.
fn ranges(numbers: &[usize]) -> String {
    let mut ranges: Vec<[usize; 2]> = Vec::new();
    for &number in numbers {
        match ranges.last_mut() {
            Some([_, last]) if *last + 1 == number => *last = number,
            _ => ranges.push([number; 2]),
        }
    }
    let text = |[first, last]: &[usize; 2]| if first == last { first.to_string() } else { format!("{first}-{last}") };
    let texts: Vec<String> = ranges.iter().map(text).collect();
    format!("{} {}", if numbers.len() == 1 { "" } else { "s" }, texts.join(", "))
}

/// Checks that the columns are results of the command.
fn check_columns(study: &Study) -> Result<(), Invalid> {
    let known = named_results(study.command);
    let Collect { columns, less, more } = &study.collect;
    for (list, names) in [("columns", columns), ("less", less), ("more", more)] {
        for (i, name) in names.iter().enumerate() {
            let is_known = is_place(name) || name == SECONDS || known.iter().any(|(known, ..)| known == name);
            if !is_known {
                let names: Vec<&str> = known.iter().map(|(name, ..)| *name).chain([SECONDS]).collect();
                let remedy = format!(
                    "is no result of {}: take one of {}, or a place in its report as in a.b[0].c",
                    study.command.name(),
                    names.join(", ")
                );
                return Err(Invalid::new(format!("collect.{list}[{i}]"), name, remedy));
            }
        }
    }
    Ok(())
}

/// Name of the column with the time of a point (s).
pub const SECONDS: &str = "seconds";

/// The study as it is written into its folder, `to_folder`: the project beside it, meshes of folders as lists of values, and
/// files as seen from there. `from_folder` is the folder of the study as it was read.
fn resolved(study: Study, base: &Base, from_folder: &Path, to_folder: &Path) -> Result<Study, Invalid> {
    let mut study = Study { project: PROJECT.into(), ..study };
    // A value may need that an earlier parameter is set.
    let mut before = base.clone();
    for (i, parameter) in study.parameter.iter_mut().enumerate() {
        let at = |name: &str| format!("parameter[{i}].{name}");
        if let Some(folder) = parameter.folder.take() {
            let meshes = meshes_in(&from_folder.join(&folder))
                .map_err(|why| Invalid::new(at("folder"), folder.display(), why))?;
            parameter.values = meshes.iter().map(|mesh| toml::Value::String(mesh.display().to_string())).collect();
        }
        let mut first = None;
        for (j, value) in parameter.values.iter_mut().enumerate() {
            let text = text_of(value);
            let (set, file) = before.set((&parameter.key, &text), from_folder).map_err(|problem| {
                let is_unknown = problem.value.is_empty() && problem.key == parameter.key;
                let place = if is_unknown && j == 0 { at("key") } else { format!("{}[{j}]", at("values")) };
                Invalid::of(place, problem.to_string())
            })?;
            if let Some(file) = file {
                *value = toml::Value::String(paths::relative(&file, to_folder).display().to_string());
            }
            first.get_or_insert(set);
        }
        if let (Some(from), Some(to)) = (parameter.from, parameter.to) {
            let is_whole = before.is_whole(&parameter.key).map_err(|e| Invalid::of(at("key"), e.to_string()))?;
            for (name, end) in [("from", from), ("to", to)] {
                if is_whole && end.fract() != 0.0 {
                    return Err(Invalid::new(at(name), end, format!("{} takes whole numbers", parameter.key)));
                }
                let set = before.set((&parameter.key, &end.to_string()), from_folder);
                let (set, _) = set.map_err(|problem| Invalid::of(at(name), problem.to_string()))?;
                first.get_or_insert(set);
            }
        }
        before = first.unwrap_or(before);
    }
    Ok(study)
}

/// The parameters of `study` with their values.
fn axes(study: &Study, base: &Base) -> Result<Vec<Axis>, Invalid> {
    let of = |(i, parameter): (usize, &Parameter)| {
        let values = match (parameter.from, parameter.to) {
            (Some(from), Some(to)) => {
                let is_whole = base.is_whole(&parameter.key);
                let is_whole = is_whole.map_err(|e| Invalid::of(format!("parameter[{i}].key"), e.to_string()))?;
                Values::Range { from, to, steps: parameter.steps, is_whole }
            }
            _ => Values::List(parameter.values.iter().map(text_of).collect()),
        };
        Ok(Axis { key: parameter.key.clone(), values })
    };
    study.parameter.iter().enumerate().map(of).collect()
}
