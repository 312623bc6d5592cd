//! The work on a mold behind the window: the mesh, what its cutters leave, a quick look while a cutter is changed, and
//! what other cutters would leave.

mod design;
mod electrode_export;
mod glance;
mod steps;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::workspaces::blisk::pipeline::{EventKind, StageState};
use crate::workspaces::glances::Glances;
use crate::workspaces::kept::{Doing, Kept, WorkEvent, note};
use crate::workspaces::mold::document::MoldParams;
use crate::workspaces::mold::job::compare::Comparison;
use crate::workspaces::mold::job::uncut::UncutParams;
use crate::workspaces::worker::{Ended, Message, Reporter, TaskId, Worker};
pub use design::Designed;
use design::Designer;
pub use glance::Glance;
use import::Units;
use mold::cutter::CutterLibrary;
use nc::burn_template::BurnSheet;
use nc::electrode_files::ElectrodeFormat;
pub use steps::{FoundUncut, LoadedMold};
use task::{Cancel, Progress};

/// What a mesh is read from: the file, its unit, how often it was asked for.
type MeshKey = (PathBuf, Units, u64);
/// What is asked of a mold: what tells the mesh from any other, and the question.
type Question = (String, UncutParams);

/// What a task has made.
enum Made {
    Found(Box<FoundUncut>),
    Other(Box<(FoundUncut, Comparison)>),
}

/// What the places in the queue are for; a later one is of no use once an earlier one is asked anew.
const FIND: u32 = 0;
const COMPARE: u32 = 1;

/// See the module's page.
pub struct MoldWork {
    /// Loads meshes, beside what is being looked for: it may be found to be the same mesh.
    loader: Worker<(), LoadedMold>,
    loading: Option<Doing>,
    worker: Worker<(), Made>,
    glancer: Glances<Question, Glance>,
    mold: Kept<MeshKey, LoadedMold>,
    found: Kept<Question, FoundUncut>,
    other: Kept<(Question, CutterLibrary), (FoundUncut, Comparison)>,
    doing: Option<Doing>,
    designer: Designer,
    reloads: u64,
}

impl MoldWork {
    /// Starts the workers; `wake` is called from them whenever something has happened.
    ///
    /// # Errors
    /// If the system gives no thread.
    pub fn start(wake: impl Fn() + Send + Sync + Clone + 'static) -> std::io::Result<Self> {
        Ok(Self {
            loader: Worker::start(wake.clone())?,
            loading: None,
            worker: Worker::start(wake.clone())?,
            glancer: Glances::start(wake.clone())?,
            designer: Designer::start(wake)?,
            mold: Kept::default(),
            found: Kept::default(),
            other: Kept::default(),
            doing: None,
            reloads: 0,
        })
    }

    /// Takes in what the workers have said, and loads the mesh that `params` name. Answers what has happened.
    pub fn follow(&mut self, params: &MoldParams) -> Vec<WorkEvent> {
        let loaded: Vec<_> = self.loader.messages().into_iter().filter_map(|m| self.take_loaded(m)).collect();
        let made: Vec<_> = self.worker.messages().into_iter().filter_map(|m| self.take(m)).collect();
        self.glancer.follow();
        self.load(params);
        // What other parameters leave is of no use to anybody. A mesh that is being loaded may be the same as before.
        let question = self.question(params);
        let is_loading = self.mold_state(params) == StageState::Running;
        let is_other = |of: &Question| question.as_ref().map_or(!is_loading, |question| question != of);
        if self.found.running.as_ref().is_some_and(|(_, of)| is_other(of)) {
            self.worker.cancel_from(FIND);
        }
        if self.other.running.as_ref().is_some_and(|(_, (of, _))| is_other(of)) {
            self.worker.cancel_from(COMPARE);
        }
        let designed = self.designer.follow(question.as_ref(), &params.electrodes);
        let refused = self.follow_wish(params);
        loaded.into_iter().chain(made).chain(designed).chain(refused).collect()
    }

    /// Makes electrodes that were asked for before it was known what is left.
    fn follow_wish(&mut self, params: &MoldParams) -> Option<WorkEvent> {
        if !self.designer.is_waiting || self.state(params) == StageState::Running {
            return None;
        }
        self.designer.is_waiting = false;
        // What became of the search has been said.
        let why = if self.state(params) == StageState::Done { self.design(params).err()? } else { return None };
        Some(WorkEvent { kind: EventKind::Failed, text: format!("Electrodes: {why}"), took: None })
    }

    /// Loads the mesh that `params` name, unless that is done.
    fn load(&mut self, params: &MoldParams) {
        let Some(path) = &params.mesh else { return };
        let key = (path.clone(), params.units, self.reloads);
        if matches!(self.mold.state(&key), StageState::Missing | StageState::Stale) {
            let (path, units) = (path.clone(), params.units);
            let work = move |_: &Reporter<(), LoadedMold>, p: &Progress, c: &Cancel| steps::load(&path, units, p, c);
            let id = self.loader.submit(0, work);
            self.mold.running = Some((id, key));
        }
    }

    fn take_loaded(&mut self, message: Message<(), LoadedMold>) -> Option<WorkEvent> {
        if !self.mold.awaits(message.task()) {
            return None;
        }
        let (ended, took) = note(&mut self.loading, "Mold", message)?;
        let (kind, text) = self.mold.end(ended, LoadedMold::sentence)?;
        Some(WorkEvent { kind, text: format!("Mold: {text}"), took })
    }

    fn take(&mut self, message: Message<(), Made>) -> Option<WorkEvent> {
        let task = message.task();
        let what = self.what(task)?;
        let (ended, took) = note(&mut self.doing, what, message)?;
        let (kind, text) = self.finish(task, ended)?;
        Some(WorkEvent { kind, text: format!("{what}: {text}"), took })
    }

    fn what(&self, task: TaskId) -> Option<&'static str> {
        if self.found.awaits(task) { Some("Uncut") } else { self.other.awaits(task).then_some("Compare") }
    }

    fn finish(&mut self, task: TaskId, ended: Ended<Made>) -> Option<(EventKind, String)> {
        if self.found.awaits(task) {
            let ended = done(ended, |made| if let Made::Found(found) = made { Some(*found) } else { None });
            return self.found.end(ended, FoundUncut::sentence);
        }
        let ended = done(ended, |made| if let Made::Other(other) = made { Some(*other) } else { None });
        self.other.end(ended, |(_, comparison)| comparison.sentence())
    }

    /// Reads the mesh again.
    pub fn reload(&mut self) {
        self.reloads += 1;
    }

    /// How the mesh of `params` stands.
    pub fn mold_state(&self, params: &MoldParams) -> StageState {
        let Some(path) = &params.mesh else { return StageState::Missing };
        self.mold.state(&(path.clone(), params.units, self.reloads))
    }

    /// The mold that was loaded last.
    pub fn mold(&self) -> Option<&Arc<LoadedMold>> {
        self.mold.value.as_ref().map(|(_, mold)| mold)
    }

    /// The mold of `params`, if it is there. While its mesh is read again it is the one that is known.
    fn current_mold(&self, params: &MoldParams) -> Option<&Arc<LoadedMold>> {
        let ((path, units, _), mold) = self.mold.value.as_ref()?;
        let is_same = params.mesh.as_ref() == Some(path) && params.units == *units;
        (is_same && !matches!(self.mold_state(params), StageState::Failed(_))).then_some(mold)
    }

    fn question(&self, params: &MoldParams) -> Option<Question> {
        let question = UncutParams {
            opening: params.opening,
            tolerance_mm: params.tolerance_mm,
            ..UncutParams::of(params.library.clone())
        };
        self.current_mold(params).map(|mold| (mold.sha256.clone(), question))
    }

    /// How the answer for `params` stands.
    pub fn state(&self, params: &MoldParams) -> StageState {
        match self.question(params) {
            Some(question) => self.found.state(&question),
            None if self.found.value.is_some() => StageState::Stale,
            None => StageState::Missing,
        }
    }

    /// What was found last, for whatever parameters: see [`state`](Self::state).
    pub fn found(&self) -> Option<&Arc<FoundUncut>> {
        let (question, found) = self.found.value.as_ref()?;
        // What is left of another mold cannot be shown on this one.
        self.mold().filter(|mold| mold.sha256 == question.0).map(|_| found)
    }

    /// Whether what was [`found`](Self::found) answers `params`, whatever is being worked on.
    pub fn is_found_of(&self, params: &MoldParams) -> bool {
        self.question(params).is_some_and(|question| self.found.is_of(&question))
    }

    /// Looks for what the cutters leave.
    ///
    /// # Errors
    /// One line if it cannot be asked.
    pub fn find(&mut self, params: &MoldParams) -> Result<(), String> {
        let (Some(question), Some(mold)) = (self.question(params), self.current_mold(params).cloned()) else {
            return Err("load a mold first".to_owned());
        };
        question.1.validate().map_err(|e| e.to_string())?;
        let asked = question.1.clone();
        let work = move |_: &Reporter<(), Made>, p: &Progress, c: &Cancel| {
            steps::find(&mold, &asked, p, c).map(|found| Made::Found(Box::new(found)))
        };
        let id = self.worker.submit(FIND, work);
        self.found.failure = None;
        self.found.running = Some((id, question));
        Ok(())
    }

    /// Looks for what `library` would leave, to compare it with what was found for `params`.
    ///
    /// # Errors
    /// One line if it cannot be asked.
    pub fn compare(&mut self, params: &MoldParams, library: &CutterLibrary) -> Result<(), String> {
        let (Some(question), Some(mold)) = (self.question(params), self.current_mold(params).cloned()) else {
            return Err("load a mold first".to_owned());
        };
        let Some(found) = self.found().filter(|_| self.found.state(&question) == StageState::Done).cloned() else {
            return Err("find the rest material of the present cutters first".to_owned());
        };
        let asked = UncutParams { library: library.clone(), ..question.1.clone() };
        asked.validate().map_err(|e| e.to_string())?;
        let work = move |_: &Reporter<(), Made>, p: &Progress, c: &Cancel| {
            steps::compare(&mold, &found, &asked, p, c).map(|other| Made::Other(Box::new(other)))
        };
        let id = self.worker.submit(COMPARE, work);
        self.other.failure = None;
        self.other.running = Some((id, (question, library.clone())));
        Ok(())
    }

    /// How the comparison of `params` with `library` stands.
    pub fn comparison_state(&self, params: &MoldParams, library: &CutterLibrary) -> StageState {
        match self.question(params) {
            Some(question) => self.other.state(&(question, library.clone())),
            None => StageState::Missing,
        }
    }

    /// Whether the [`other`](Self::other) answer is the comparison of `params` with `library`.
    pub fn is_other_of(&self, params: &MoldParams, library: &CutterLibrary) -> bool {
        self.question(params).is_some_and(|question| self.other.is_of(&(question, library.clone())))
    }

    /// What the other library leaves and how that compares with what is shown; none of another answer.
    pub fn other(&self) -> Option<&Arc<(FoundUncut, Comparison)>> {
        let ((question, _), other) = self.other.value.as_ref()?;
        self.found.value.as_ref().filter(|(of, _)| of == question).map(|_| other)
    }

    /// Looks quickly at what the cutters leave, unless that is known or being looked at. While it is asked again and
    /// again with other cutters every look comes to its end, and the last one is of the last.
    pub fn glance(&mut self, params: &MoldParams) {
        if let (Some(question), Some(mold)) = (self.question(params), self.current_mold(params).cloned()) {
            let params = question.1.clone();
            self.glancer.ask(question, move |cancel| glance::look(&mold, &params, cancel));
        }
    }

    /// Forgets what was seen at a glance.
    pub fn forget_glance(&mut self) {
        self.glancer.forget();
    }

    /// What was seen at a glance of `params`; while they go on changing (`is_held`) also of earlier ones, but never of
    /// another mold.
    pub fn glanced(&self, params: &MoldParams, is_held: bool) -> Option<&Arc<Glance>> {
        let question = self.question(params)?;
        self.glancer.seen(|of| *of == question || (is_held && of.0 == question.0))
    }

    /// What is being worked on.
    pub fn doing(&self) -> Option<&Doing> {
        self.loading.as_ref().or(self.doing.as_ref()).or(self.designer.doing())
    }

    /// Whether anything waits or runs.
    pub fn is_busy(&self) -> bool {
        self.loader.is_busy() || self.worker.is_busy() || self.glancer.is_busy() || self.designer.is_busy()
    }

    /// Stops what runs, at the user's wish: none of it begins again by itself.
    pub fn cancel(&mut self) {
        self.mold.give_up();
        self.found.give_up();
        self.other.give_up();
        self.loader.cancel_from(0);
        self.worker.cancel_from(FIND);
        self.designer.cancel();
    }

    /// Makes electrodes for what is left, which is looked for first where it is not known.
    ///
    /// # Errors
    /// One line if it cannot be asked.
    pub fn design(&mut self, params: &MoldParams) -> Result<(), String> {
        params.electrodes.validate().map_err(|e| e.to_string())?;
        let (Some(question), Some(mold)) = (self.question(params), self.current_mold(params).cloned()) else {
            return Err("load a mold first".to_owned());
        };
        let known = self.found().filter(|_| self.found.is_of(&question)).cloned();
        match known {
            Some(found) => self.designer.design(&question, &params.electrodes, mold, found),
            None => {
                if self.state(params) != StageState::Running {
                    self.find(params)?;
                }
                self.designer.is_waiting = true;
            }
        }
        Ok(())
    }

    /// How the electrodes for `params` stand.
    pub fn design_state(&self, params: &MoldParams) -> StageState {
        if self.designer.is_waiting {
            return StageState::Running;
        }
        match self.question(params) {
            Some(question) => self.designer.state(&question, &params.electrodes),
            None if self.designer.has_made() => StageState::Stale,
            None => StageState::Missing,
        }
    }

    /// The electrodes that were made last for the present mold, for whatever parameters.
    pub fn designed(&self) -> Option<&Arc<Designed>> {
        self.designer.made_of(&self.mold()?.sha256)
    }

    /// Whether [`designed`](Self::designed) answers `params`.
    pub fn is_designed_of(&self, params: &MoldParams) -> bool {
        self.question(params).is_some_and(|question| self.designer.is_of(&question, &params.electrodes))
    }

    /// Writes the electrodes into `folder`.
    ///
    /// # Errors
    /// One line if there are none for `params`.
    pub fn export_electrodes(
        &mut self,
        params: &MoldParams,
        folder: &Path,
        (formats, sheet): (&[ElectrodeFormat], &BurnSheet),
    ) -> Result<(), String> {
        let made = self.designed().filter(|_| self.is_designed_of(params)).cloned();
        let (Some(made), Some(mold)) = (made, self.mold().cloned()) else {
            return Err("the electrodes are out of date: create them again".to_owned());
        };
        let name = params.name();
        self.designer.export(folder, (made, mold), (name, &params.electrodes), (formats.to_vec(), sheet.clone()));
        Ok(())
    }
}

/// What has ended, which `mine` takes out of what any task may have made.
fn done<T>(ended: Ended<Made>, mine: impl Fn(Made) -> Option<T>) -> Ended<T> {
    match ended {
        Ended::Done(made) => match mine(made) {
            Some(mine) => Ended::Done(mine),
            None => Ended::Failed("internal error: one task answered with the result of another".to_owned()),
        },
        Ended::Cancelled => Ended::Cancelled,
        Ended::Failed(text) => Ended::Failed(text),
        Ended::Panicked(text) => Ended::Panicked(text),
    }
}
