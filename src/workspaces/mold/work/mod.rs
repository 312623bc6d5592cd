//! The background work on a mold: reading its mesh, uncut regions, previews, the comparison with other cutters,
//! electrodes, and their files.

mod design;
mod electrode_export;
mod steps;
mod uncut_export;

use files::Validate;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::workspaces::mold::document::MoldParams;
use crate::workspaces::mold::document::fields::FIELDS;
use crate::workspaces::mold::export::ElectrodeForms;
use crate::workspaces::mold::job::compare::Comparison;
use crate::workspaces::mold::job::divisions::{WayResult, compare_divisions};
use crate::workspaces::mold::job::electrodes::timed;
use crate::workspaces::mold::job::uncut::UncutParams;
use crate::workspaces::mold::report::uncut::ComparisonReport;
use crate::workspaces::news::{EventKind, WorkEvent};
use crate::workspaces::opening::await_drives;
pub use design::Designed;
use electrode_export::{Exported, export};
use files::ResultCache;
use import::{Reading, Units};
use mold::cutter::CutterLibrary;
use mold::electrode::design::ElectrodeSet;
use mold::electrode::params::ElectrodeParams;
use nc::electrode_files::ElectrodeFormat;
use nc::template::BurnSheet;
pub use steps::{FoundUncut, Glance, LoadedMold, Survey, load as read_part};
use task::{Doing, Lane, Memo, Priority, Scheduler, State};

/// Key of a mesh: the file, none for the demonstration mold, its unit, and the number of reloads.
type MeshKey = (Option<PathBuf>, Reading, u64);
/// Key of uncut regions: the digest of the mesh, and the parameters.
type Question = (String, UncutParams);
/// Key of electrodes: the key of the uncut regions, and the parameters of electrodes.
type DesignQuestion = (Question, ElectrodeParams);

/// What was computed anew of what had been kept: the question, and both answers.
type Proof = (DesignQuestion, Arc<FoundUncut>, Arc<Designed>);

/// Names of kept results.
const UNCUT: &str = "uncut";
const ELECTRODES: &str = "electrodes";

/// The background work on a mold.
pub struct MoldWork {
    /// Only one mesh is remembered: a file is read again when the user comes back to it.
    mold: Memo<MeshKey, LoadedMold>,
    /// By the digest of the mold.
    surveyed: Memo<String, Survey>,
    /// Answers with their shapes are large: a few are remembered, so that undo is instant.
    found: Memo<Question, FoundUncut>,
    other: Memo<(Question, CutterLibrary), (FoundUncut, Comparison)>,
    glances: Memo<Question, Glance>,
    designed: Memo<DesignQuestion, Designed>,
    /// Ways of dividing, compared with the electrodes of the key.
    divisions: Memo<DesignQuestion, Vec<WayResult>>,
    /// Whether electrodes are made once the uncut regions are known.
    is_waiting: bool,
    /// Exports, each with what was proven for it.
    exported: Memo<u64, (Exported, Option<Proof>)>,
    /// Exports of uncut regions: what was written, in a sentence.
    uncut_exported: Memo<u64, String>,
    exports: u64,
    reloads: u64,
    /// Whether the technology table has changed since minutes were computed.
    is_table_changed: bool,
    priority: Priority,
    /// Cache of results, if there is one.
    pub results: Option<ResultCache>,
    /// Key looked up last in the cache.
    looked_up: (Option<Question>, Option<DesignQuestion>),
}

impl MoldWork {
    /// The work without any result.
    pub fn new(scheduler: &Scheduler) -> Self {
        Self {
            mold: Memo::new(scheduler, Lane::Quick, "Mold").remembering(1),
            surveyed: Memo::new(scheduler, Lane::Quick, "Opening direction").remembering(1),
            found: Memo::new(scheduler, Lane::Long, "Uncut").remembering(3),
            other: Memo::new(scheduler, Lane::Long, "Compare").remembering(1),
            glances: Memo::new(scheduler, Lane::Quick, "Quick look").letting_finish().remembering(2),
            designed: Memo::new(scheduler, Lane::Long, "Electrodes").remembering(4),
            divisions: Memo::new(scheduler, Lane::Long, "Compare divisions").remembering(1),
            is_waiting: false,
            exported: Memo::new(scheduler, Lane::Long, "Export of electrodes").awaiting_the_end().remembering(1),
            uncut_exported: Memo::new(scheduler, Lane::Long, "Export of rest material")
                .awaiting_the_end()
                .remembering(1),
            exports: 0,
            reloads: 0,
            is_table_changed: false,
            priority: Priority::Normal,
            results: None,
            looked_up: (None, None),
        }
    }

    /// Takes in finished work, and reads the mesh of `params`. Returns the reports.
    pub fn follow(&mut self, params: &MoldParams, priority: Priority) -> Vec<WorkEvent> {
        self.priority = priority;
        let mut events = Vec::new();
        while let Some(ended) = self.mold.take() {
            events.push(WorkEvent::of("Mold", ended, |mold| (EventKind::Done, mold.sentence())));
        }
        while let Some(ended) = self.surveyed.take() {
            if ended.result.is_err() {
                events.push(WorkEvent::of("Opening direction", ended, |_| (EventKind::Done, String::new())));
            }
        }
        while let Some(ended) = self.found.take() {
            events.push(WorkEvent::of("Uncut", ended, |found| (EventKind::Done, found.sentence())));
        }
        while let Some(ended) = self.other.take() {
            events.push(WorkEvent::of("Compare", ended, |(_, comparison)| (EventKind::Done, comparison.sentence())));
        }
        while let Some(ended) = self.designed.take() {
            let sentence = |made: &Designed| (EventKind::Done, made.sentence(&params.electrodes.overrides));
            events.push(WorkEvent::of("Electrodes", ended, sentence));
        }
        while let Some(ended) = self.divisions.take() {
            let sentence =
                |ways: &Vec<WayResult>| (EventKind::Done, format!("{} ways of dividing compared", ways.len()));
            events.push(WorkEvent::of("Compare", ended, sentence));
        }
        while let Some(ended) = self.exported.take() {
            if let Ok((_, Some(proof))) = ended.result.as_deref() {
                self.take_proof(proof);
            }
            events.push(WorkEvent::of("Electrodes", ended, |(exported, _)| (EventKind::Done, exported.sentence())));
        }
        while let Some(ended) = self.uncut_exported.take() {
            events.push(WorkEvent::of("Uncut", ended, |text| (EventKind::Done, text.clone())));
        }
        self.load(params);
        self.survey_of(params);
        self.follow_table();
        self.turn_to(params);
        self.take_up(params);
        events.extend(self.follow_wish(params));
        events
    }

    /// Replaces what was kept from an earlier session by what was proven, where that is still remembered.
    fn take_proof(&mut self, (asked, found, made): &Proof) {
        if self.found.get(&asked.0).is_some() {
            self.found.put(&asked.0, found.clone());
        }
        if self.designed.get(asked).is_some() {
            self.designed.put(asked, made.clone());
        }
    }

    /// Cancels work for other parameters. A mesh being read may be the same as before.
    fn turn_to(&mut self, params: &MoldParams) {
        match self.question(params) {
            Some(question) => {
                self.found.turn_to(&question);
                self.glances.turn_to(&question);
                if self.other.under_way().is_some_and(|(of, _)| *of != question) {
                    self.other.stop();
                }
                let designed = design_question(question, &params.electrodes);
                self.designed.turn_to(&designed);
                self.divisions.turn_to(&designed);
            }
            None if self.mold_state(params) == State::Running => {}
            None => {
                self.found.stop();
                self.other.stop();
            }
        }
        self.found.prioritise(self.priority);
        self.other.prioritise(self.priority);
        self.designed.prioritise(self.priority);
    }

    /// Makes electrodes that were asked for before the uncut regions were known.
    fn follow_wish(&mut self, params: &MoldParams) -> Option<WorkEvent> {
        if !self.is_waiting || self.state(params) == State::Running {
            return None;
        }
        self.is_waiting = false;
        // What became of the search has been said.
        let why = if self.state(params) == State::Ready { self.design(params).err()? } else { return None };
        Some(WorkEvent { kind: EventKind::Failed, text: format!("Electrodes: {why}"), took: None })
    }

    /// Reads the mesh of `params`, unless that is done. The demonstration mold is made once it is to be seen.
    fn load(&mut self, params: &MoldParams) {
        let key = self.mesh_key(params);
        match key.0.clone() {
            Some(path) => {
                let reading = key.1.clone();
                self.mold.ask(&key, self.priority, move |work| {
                    await_drives(std::slice::from_ref(&path), &work.task)?;
                    steps::load(&path, &reading, &work.task)
                });
            }
            None if self.priority == Priority::Shown => {
                self.mold.ask(&key, self.priority, |work| steps::load_demonstration(&work.task));
            }
            None => {}
        }
    }

    /// Looks for opening direction and rims of the mold of `params`, unless that is done.
    fn survey_of(&mut self, params: &MoldParams) {
        let Some(mold) = self.part(params).cloned() else { return };
        self.surveyed.ask(&mold.sha256.clone(), self.priority, move |work| {
            steps::survey(&mold, &work.task.cancel).map_err(|e| e.to_string())
        });
    }

    /// Opening direction and rims of the mold of `params`, once found.
    pub fn survey(&self, params: &MoldParams) -> Option<&Arc<Survey>> {
        self.surveyed.get(&self.part(params)?.sha256)
    }

    /// Whether opening direction and rims are being looked for.
    pub fn is_surveying(&self) -> bool {
        self.surveyed.is_busy()
    }

    fn mesh_key(&self, params: &MoldParams) -> MeshKey {
        let reading = if params.mesh.is_some() { params.reading() } else { Units::Mm.into() };
        (params.mesh.clone(), reading, self.reloads)
    }

    /// Takes `mold` as the mesh of `params`.
    pub fn put(&mut self, params: &MoldParams, mold: Arc<LoadedMold>) {
        self.mold.put(&self.mesh_key(params), mold);
    }

    /// Reads the mesh again.
    pub fn reload(&mut self) {
        self.reloads += 1;
    }

    /// State of the mesh of `params`.
    pub fn mold_state(&self, params: &MoldParams) -> State {
        self.mold.state(&self.mesh_key(params))
    }

    /// The mold that was read last.
    pub fn mold(&self) -> Option<&Arc<LoadedMold>> {
        self.mold.last().map(|(_, mold)| mold)
    }

    /// The mold of `params`, if read. While the mesh is read again, the known one.
    fn current_mold(&self, params: &MoldParams) -> Option<&Arc<LoadedMold>> {
        let ((path, reading, _), mold) = self.mold.last()?;
        let asked = self.mesh_key(params);
        let is_same = (&asked.0, &asked.1) == (path, reading);
        (is_same && !matches!(self.mold_state(params), State::Failed(_) | State::Cancelled)).then_some(mold)
    }

    /// The part of `params`, once read.
    pub fn part(&self, params: &MoldParams) -> Option<&Arc<LoadedMold>> {
        self.current_mold(params).filter(|_| self.mold_state(params) == State::Ready)
    }

    fn question(&self, params: &MoldParams) -> Option<Question> {
        // The direction is proposed once the mold is read.
        let mold = self.current_mold(params).filter(|_| params.opening.is_some())?;
        Some((mold.sha256.clone(), params.uncut()))
    }

    /// Key for `params`, and the mold.
    fn asked(&self, params: &MoldParams) -> Result<(Question, Arc<LoadedMold>), String> {
        let mold = self.current_mold(params).ok_or("load a mold first")?;
        let question = self.question(params).ok_or("choose the opening direction, or wait until one is proposed")?;
        Ok((question, mold.clone()))
    }

    /// State of the uncut regions for `params`.
    pub fn state(&self, params: &MoldParams) -> State {
        self.question(params).map_or_else(|| of_no_mold(&self.found), |question| self.found.state(&question))
    }

    /// The uncut regions found or asked for last, for any parameters: see [`state`](Self::state).
    pub fn found(&self) -> Option<&Arc<FoundUncut>> {
        let (question, found) = self.found.last()?;
        // What is left of another mold cannot be shown on this one.
        self.mold().filter(|mold| mold.sha256 == question.0).map(|_| found)
    }

    /// Whether the [`found`](Self::found) regions belong to `params`.
    pub fn is_found_of(&self, params: &MoldParams) -> bool {
        self.found.last().is_some_and(|(of, _)| self.question(params).as_ref() == Some(of))
    }

    /// Searches the uncut regions.
    ///
    /// # Errors
    /// One line if the search cannot start.
    pub fn find(&mut self, params: &MoldParams) -> Result<(), String> {
        let (question, mold) = self.asked(params)?;
        question.1.validate().map_err(|e| FIELDS.labelled(&e))?;
        // Who asks again for what there is wants it computed.
        let results = self.results.clone();
        let kept = results.clone().filter(|_| self.state(params) != State::Ready);
        let key = question.clone();
        self.found.restart(&question, self.priority, move |work| {
            if let Some(found) = kept.as_ref().and_then(|kept| kept.get(UNCUT, &key)) {
                return Ok(steps::shown(&mold, found, false));
            }
            let found = steps::find(&mold, &key.1, &work.task)?;
            results.iter().for_each(|results| results.put(UNCUT, &key, &found.uncut));
            Ok(found)
        });
        Ok(())
    }

    /// Takes a result for `params` from the cache, if nothing was asked for them since.
    fn take_up(&mut self, params: &MoldParams) {
        let (Some(results), Ok((question, mold))) = (self.results.clone(), self.asked(params)) else { return };
        if self.looked_up.0.as_ref() != Some(&question) {
            self.looked_up.0 = Some(question.clone());
            if self.found.wants(&question) && !self.found.is_busy() && results.has(UNCUT, &question) {
                let (key, mold) = (question.clone(), mold.clone());
                let gone = "what was kept of it is damaged: find it again";
                let (kept, priority) = (results.clone(), self.priority);
                self.found.ask(&question, priority, move |_| {
                    kept.get(UNCUT, &key).map(|found| steps::shown(&mold, found, false)).ok_or_else(|| gone.to_owned())
                });
            }
        }
        let Some(found) = self.found.get(&question).cloned() else { return };
        // Names that were given then are given still.
        let named = (question.clone(), kept_electrodes(&params.electrodes));
        if self.looked_up.1.as_ref() != Some(&named) {
            self.looked_up.1 = Some(named.clone());
            let asked = design_question(question, &params.electrodes);
            if self.designed.wants(&asked) && !self.designed.is_busy() && results.has(ELECTRODES, &named) {
                let gone = "what was kept of them is damaged: create them again";
                self.designed.ask(&asked, self.priority, move |_| {
                    let set = results.get(ELECTRODES, &named);
                    // The technology table may have changed since.
                    set.map(|set| design::shown(&mold, &found, timed(set), false)).ok_or_else(|| gone.to_owned())
                });
            }
        }
    }

    /// Searches the uncut regions of `library`, to compare them with those for `params`.
    ///
    /// # Errors
    /// One line if it cannot be asked.
    pub fn compare(&mut self, params: &MoldParams, library: &CutterLibrary) -> Result<(), String> {
        let (question, mold) = self.asked(params)?;
        let found = self.found.get(&question).filter(|_| self.found.state(&question) == State::Ready).cloned();
        let found = found.ok_or("find the rest material of the present cutters first")?;
        let asked = UncutParams { library: library.clone(), ..question.1.clone() };
        asked.validate().map_err(|e| FIELDS.labelled(&e))?;
        self.other.restart(&(question, library.clone()), self.priority, move |work| {
            steps::compare(&mold, &found, &asked, &work.task)
        });
        Ok(())
    }

    /// Writes the uncut regions for `params` into `folder`, with their comparison with the cutters `other` if that is
    /// there.
    ///
    /// # Errors
    /// One line if there are none for `params`.
    pub fn export_uncut(&mut self, params: &MoldParams, other: &CutterLibrary, folder: &Path) -> Result<(), String> {
        let (question, mold) = self.asked(params)?;
        let found = self.found.get(&question).filter(|_| self.found.state(&question) == State::Ready).cloned();
        let found = found.ok_or("the rest material is out of date: find it again")?;
        let compared = self.other().filter(|_| self.is_other_of(params, other));
        let comparison = compared.map(|made| ComparisonReport::of(&made.1, other, params.opening()));
        let folder = folder.to_owned();
        self.exports += 1;
        self.uncut_exported.restart(&self.exports, Priority::Shown, move |work| {
            // What was read from a file is shown, but proves nothing.
            let proven = if found.is_proven { None } else { Some(steps::find(&mold, &question.1, &work.task)?) };
            let found = proven.as_ref().unwrap_or(&found);
            uncut_export::export(&folder, found, comparison.as_ref(), &mold, &work.task)
        });
        Ok(())
    }

    /// State of the comparison of `params` with `library`.
    pub fn comparison_state(&self, params: &MoldParams, library: &CutterLibrary) -> State {
        let question = self.question(params);
        question.map_or(State::Missing, |question| self.other.state(&(question, library.clone())))
    }

    /// Whether the [`other`](Self::other) result compares `params` with `library`.
    pub fn is_other_of(&self, params: &MoldParams, library: &CutterLibrary) -> bool {
        self.other.last().is_some_and(|((of, with), _)| with == library && self.question(params).as_ref() == Some(of))
    }

    /// Uncut regions of the other library and the comparison with the shown result; none for another result.
    pub fn other(&self) -> Option<&Arc<(FoundUncut, Comparison)>> {
        let ((question, _), other) = self.other.last()?;
        self.found.last().filter(|(of, _)| *of == question).map(|_| other)
    }

    /// Previews the uncut regions, unless they are known or being previewed. While the cutters go on changing, every
    /// preview is finished and the last one is for the last cutters.
    pub fn glance(&mut self, params: &MoldParams) {
        let Ok((question, mold)) = self.asked(params) else { return };
        let asked = question.1.clone();
        self.glances.ask(&question, self.priority, move |work| steps::glance(&mold, &asked, &work.task.cancel));
    }

    /// Forgets the preview.
    pub fn forget_glance(&mut self) {
        self.glances.clear();
    }

    /// Forgets the mesh of another mold, which is read anew even from the same file, and previews and wishes for it.
    pub fn begin_anew(&mut self) {
        self.mold.clear();
        self.surveyed.clear();
        self.forget_glance();
        self.is_waiting = false;
    }

    /// The preview for `params`; while they go on changing (`is_held`) also for earlier ones, but never for another
    /// mold.
    pub fn glanced(&self, params: &MoldParams, is_held: bool) -> Option<&Arc<Glance>> {
        let question = self.question(params)?;
        let before = self.glances.last().filter(|(of, _)| is_held && of.0 == question.0);
        self.glances.get(&question).or(before.map(|(_, glance)| glance))
    }

    /// Work under way.
    pub fn doing(&self) -> Option<&Doing> {
        let all = [self.mold.doing(), self.surveyed.doing(), self.found.doing(), self.other.doing()];
        let made = [self.designed.doing(), self.divisions.doing()];
        let exported = [self.exported.doing(), self.uncut_exported.doing()];
        all.into_iter().chain(made).chain(exported).flatten().next()
    }

    /// Whether work waits or runs.
    pub fn is_busy(&self) -> bool {
        self.is_waiting || self.doing().is_some() || self.glances.is_busy()
    }

    /// Stops all work at the user's wish. None of it begins again by itself.
    pub fn cancel(&mut self) {
        self.is_waiting = false;
        self.mold.cancel();
        self.surveyed.cancel();
        self.found.cancel();
        self.other.cancel();
        self.designed.cancel();
        self.divisions.cancel();
        self.exported.cancel();
        self.uncut_exported.cancel();
    }

    /// Makes electrodes for the uncut regions, after searching them if needed.
    ///
    /// # Errors
    /// One line if the search cannot start.
    pub fn design(&mut self, params: &MoldParams) -> Result<(), String> {
        params.electrodes.validate().map_err(|e| FIELDS.in_window(&e.within("electrodes")))?;
        let (question, mold) = self.asked(params)?;
        self.is_waiting = false;
        let Some(found) = self.found.get(&question).cloned() else {
            if self.state(params) != State::Running {
                self.find(params)?;
            }
            self.is_waiting = true;
            return Ok(());
        };
        let (asked, results) = (params.electrodes.clone(), self.results.clone());
        self.designed.restart(&design_question(question.clone(), &params.electrodes), self.priority, move |work| {
            let made = design::design(&mold, &found, &asked, &work.task)?;
            // The file may have them with the names that they had before, or with those that they were given.
            let named = ElectrodeParams { names: made.set.names.clone(), ..asked.clone() };
            for asked in [&asked, &named] {
                let key = (question.clone(), kept_electrodes(asked));
                results.iter().for_each(|results| results.put(ELECTRODES, &key, &made.set));
            }
            Ok(made)
        });
        Ok(())
    }

    /// Computes minutes and wear again, once no electrodes are being made: the technology table has changed.
    pub fn recompute_burning(&mut self) {
        self.is_table_changed = true;
    }

    fn follow_table(&mut self) {
        if !self.is_table_changed || self.designed.is_busy() || self.divisions.is_busy() {
            return;
        }
        self.is_table_changed = false;
        let last = self.designed.last().map(|(asked, made)| (asked.clone(), made.clone()));
        // Others that are remembered have the minutes of before.
        self.designed.clear();
        self.divisions.clear();
        self.looked_up.1 = None;
        let Some((asked, made)) = last else { return };
        let (Some(mold), Some(found)) = (self.mold(), self.found.get(&asked.0)) else { return };
        self.designed.put(&asked, made.timed_again(mold, found).into());
    }

    /// State of the electrodes for `params`.
    pub fn design_state(&self, params: &MoldParams) -> State {
        if self.is_waiting {
            return State::Running;
        }
        let state = |question| self.designed.state(&design_question(question, &params.electrodes));
        self.question(params).map_or_else(|| of_no_mold(&self.designed), state)
    }

    /// The electrodes made or asked for last for the present mold, for any parameters.
    pub fn designed(&self) -> Option<&Arc<Designed>> {
        let ((question, _), made) = self.designed.last()?;
        self.mold().filter(|mold| mold.sha256 == question.0).map(|_| made)
    }

    /// Whether [`designed`](Self::designed) belongs to `params`.
    pub fn is_designed_of(&self, params: &MoldParams) -> bool {
        let asked = self.question(params).map(|question| design_question(question, &params.electrodes));
        self.designed.last().is_some_and(|(of, _)| asked.as_ref() == Some(of))
    }

    /// Compares other ways of dividing with that of the electrodes for `params`.
    ///
    /// # Errors
    /// One line if there are none for `params`.
    pub fn compare_divisions(&mut self, params: &MoldParams) -> Result<(), String> {
        let (question, mold) = self.asked(params)?;
        let found = self.found.get(&question).cloned();
        let asked = design_question(question, &params.electrodes);
        let made = self.designed.get(&asked).cloned();
        let (found, made) = found.zip(made).ok_or("the electrodes are out of date: create them again")?;
        self.divisions.restart(&asked, self.priority, move |work| {
            let ways = compare_divisions(mold.body(), &found.uncut, &made.set, &work.task);
            ways.map_err(|e| FIELDS.labelled(&e))
        });
        Ok(())
    }

    /// State of the comparison of ways of dividing for `params`.
    pub fn divisions_state(&self, params: &MoldParams) -> State {
        let state = |question| self.divisions.state(&design_question(question, &params.electrodes));
        self.question(params).map_or(State::Missing, state)
    }

    /// Ways of dividing compared for `params`.
    pub fn divisions(&self, params: &MoldParams) -> Option<&Arc<Vec<WayResult>>> {
        self.divisions.get(&design_question(self.question(params)?, &params.electrodes))
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
        let (Some(made), Ok((question, mold))) = (made, self.asked(params)) else {
            return Err("the electrodes are out of date: create them again".to_owned());
        };
        let (formats, burn_sheet) = (formats.to_vec(), sheet.clone());
        let (folder, forms) =
            (folder.to_owned(), ElectrodeForms { formats, burn_sheet, set_up: params.setup.set_up() });
        let datum = params.datum.clone();
        // Which of them are let pass, and what they are called, may have changed since they were made.
        let asked = ElectrodeParams { names: Vec::new(), ..params.electrodes.clone() };
        let (electrodes, divisions) = (params.electrodes.clone(), self.divisions(params).cloned());
        self.exports += 1;
        self.exported.restart(&self.exports, Priority::Shown, move |work| {
            // What was read from a file is shown, but proves nothing.
            let mut proof = None;
            if !made.is_proven {
                let found = steps::find(&mold, &question.1, &work.task)?;
                let proven = design::design(&mold, &found, &electrodes, &work.task)?;
                if !is_as_shown(&made.set, &proven.set) {
                    return Err(
                        "the electrodes as they are made now are not those that are shown, which were kept from an \
                                earlier session: create them again and look at them"
                            .to_owned(),
                    );
                }
                proof = Some((design_question(question, &electrodes), Arc::new(found), Arc::new(proven)));
            }
            let made = proof.as_ref().map_or(&made, |(_, _, proven)| proven);
            let set = ElectrodeSet { params: asked.clone(), ..made.set.clone() };
            let all = (&set, &**made, divisions.as_deref());
            let exported = export(&folder, all, (&mold, &datum), &forms, &work.task)?;
            Ok((exported, proof))
        });
        Ok(())
    }
}

/// Whether the electrodes of `now` are those of `shown`, with the same verdicts.
fn is_as_shown(shown: &ElectrodeSet, now: &ElectrodeSet) -> bool {
    let bodies =
        |set: &ElectrodeSet| -> Vec<_> { set.electrodes.iter().map(|e| (e.name.clone(), e.mesh.clone())).collect() };
    bodies(shown) == bodies(now) && shown.checks == now.checks
}

/// The parameters that electrodes depend on: neither overrides nor former names, which they keep, but what the user gave
/// them.
fn design_question(question: Question, electrodes: &ElectrodeParams) -> DesignQuestion {
    let (overrides, material) = (Vec::new(), String::new());
    let names = electrodes.names.iter().filter(|name| !name.given.is_nothing()).cloned().collect();
    (question, ElectrodeParams { overrides, names, material, ..electrodes.clone() })
}

/// The parameters in the key of kept electrodes: with the names, which are given for good.
fn kept_electrodes(electrodes: &ElectrodeParams) -> ElectrodeParams {
    ElectrodeParams { overrides: Vec::new(), material: String::new(), ..electrodes.clone() }
}

/// State of a value while there is no mold.
fn of_no_mold<K: Clone + PartialEq, V: Send + 'static>(memo: &Memo<K, V>) -> State {
    if memo.last().is_some() { State::Stale } else { State::Missing }
}
