//! Everything that is computed for a blisk: its part, channel and electrodes, which follow the document by themselves;
//! the plan, which the user starts, and what comes after it. Quick looks and sizes stand in `looks`, release and export
//! in `release`.

mod looks;
mod measured;
pub mod release;
#[cfg(test)]
mod tests;

use std::sync::Arc;
use std::time::Duration;

use glam::DVec3;

use crate::workspaces::blisk::document::Document;
use crate::workspaces::blisk::document::job_file::PlanJob;
use crate::workspaces::blisk::document::job_file::field_table::FIELDS;
use crate::workspaces::blisk::document::kept_plan::KeptPlan;
use crate::workspaces::blisk::document::stage::{Fingerprint, Stage};
use crate::workspaces::blisk::job::outcome::{PlanInputs, PlanOutcome};
use crate::workspaces::blisk::job::plan::kept;
use crate::workspaces::blisk::job::planned::{Exported, Finished, PartialPlan, Planned, inputs_of};
use crate::workspaces::blisk::job::prepared_blisk::PreparedBlisk;
use crate::workspaces::blisk::job::released::Released;
use crate::workspaces::blisk::job::simulate;
use crate::workspaces::blisk::job::stages::{self, Electrodes, FoundChannel, Part};
use crate::workspaces::blisk::report::InputFile;
use crate::workspaces::blisk::scene::residual_stock::MapShape;
use crate::workspaces::news::{EventKind, WorkEvent};
use crate::workspaces::opening::await_drives;
use files::{PartFile, Validate as _, files_in};
pub use looks::ElectrodeTable;
use looks::Looks;
use measured::MeasuredKey;
use task::{Doing, Lane, Memo, Priority, Same, Scheduler, State};

/// How long work may take before more is said of it than its result: what takes less would only flicker.
const MOMENT: Duration = Duration::from_millis(500);

/// What has happened, and at which step.
pub type StageEvent = (Stage, WorkEvent);

/// The present parameters, what the files held, and the fingerprints that follow.
struct Now {
    job: Arc<PlanJob>,
    /// Why no plan can be made of these parameters, in the words of the window.
    problem: Option<String>,
    /// What the files held, and how often they were read.
    content: String,
    part: Fingerprint,
    channel: Fingerprint,
    electrode: Fingerprint,
    plan: Fingerprint,
    export: Fingerprint,
    technology_edits: u64,
}

impl Now {
    fn new(job: &PlanJob, content: String, part: Fingerprint, technology_edits: u64) -> Self {
        let of = |stage| Fingerprint::of(stage, job, &content);
        Self {
            part,
            channel: of(Stage::Channel),
            electrode: of(Stage::Electrode),
            plan: of(Stage::Plan),
            export: Fingerprint::of(Stage::Export, job, &format!("{content}/{technology_edits}")),
            technology_edits,
            problem: job.validate().err().map(|problem| FIELDS.in_window(&problem)),
            job: Arc::new(job.clone()),
            content,
        }
    }
}

/// Work that begins as soon as the blisk is ready for planning.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Wish {
    Plan,
    Table(ElectrodeTable),
}

/// Everything that is computed for a blisk.
pub struct BliskWork {
    /// Meshes and plans are large: of each a few are remembered, so that undo is instant.
    part: Memo<Fingerprint, Part>,
    /// What is known of a channel that was refused is its place, in the coordinates of the mesh.
    channel: Memo<Fingerprint, FoundChannel, DVec3>,
    electrodes: Memo<Fingerprint, Electrodes>,
    /// The blisk made ready for planning with a size of cells (mm). Two would take twice the memory.
    prepared: Memo<(Same<FoundChannel>, f64), PreparedBlisk>,
    planned: Memo<Fingerprint, Planned, Arc<PartialPlan>>,
    /// Plans for the electrodes as they are measured: by the plan, the table, and how often files were read.
    measured: Memo<MeasuredKey, Planned>,
    finished: Memo<Same<Planned>, Finished>,
    /// Exports, each under the number of exports before it.
    exported: Memo<(Fingerprint, u64), Exported>,
    exports: (Option<Fingerprint>, u64),
    looks: Looks,
    wishes: Vec<Wish>,
    released: Option<Released>,
    /// The plan that the document was told of.
    noted: Option<Same<Planned>>,
    /// The plan that the document came with, once it was read.
    kept: Option<Option<Arc<KeptPlan>>>,
    /// The inputs of the kept plan that was found to be of other parameters.
    passed_over: Option<String>,
    now: Option<Now>,
    reloads: u64,
    technology_edits: u64,
    priority: Priority,
    events: Vec<StageEvent>,
}

impl BliskWork {
    /// The work on a blisk without any result yet.
    pub fn new(scheduler: &Scheduler) -> Self {
        Self {
            part: Memo::new(scheduler, Lane::Quick, Stage::Part.name()).remembering(2),
            channel: Memo::new(scheduler, Lane::Quick, Stage::Channel.name()).remembering(3),
            electrodes: Memo::new(scheduler, Lane::Quick, Stage::Electrode.name()).remembering(4),
            prepared: Memo::new(scheduler, Lane::Quick, "Preparation").remembering(1),
            planned: Memo::new(scheduler, Lane::Long, Stage::Plan.name()).remembering(4),
            measured: Memo::new(scheduler, Lane::Quick, Stage::Verify.name()).remembering(2),
            finished: Memo::new(scheduler, Lane::Long, Stage::Verify.name()).remembering(4),
            exported: Memo::new(scheduler, Lane::Long, Stage::Export.name()).awaiting_the_end().remembering(1),
            exports: (None, 0),
            looks: Looks::new(scheduler),
            wishes: Vec::new(),
            released: None,
            noted: None,
            kept: None,
            passed_over: None,
            now: None,
            reloads: 0,
            technology_edits: 0,
            priority: Priority::Normal,
            events: Vec::new(),
        }
    }

    /// Forgets everything: another document is there, whose part has perhaps been read already.
    pub fn reset(&mut self, job: &PlanJob, part: Option<Arc<Part>>) {
        self.part.clear();
        self.channel.clear();
        self.electrodes.clear();
        self.prepared.clear();
        self.planned.clear();
        self.measured.clear();
        self.finished.clear();
        self.exported.clear();
        self.looks.clear();
        (self.wishes, self.events) = Default::default();
        (self.released, self.noted, self.kept, self.passed_over, self.now) = Default::default();
        self.exports.0 = None;
        if let Some(part) = part {
            self.say(Stage::Part, EventKind::Done, &part.sentence());
            self.part.put(&self.part_key(job), part);
        }
    }

    /// Reads the files again.
    pub fn reload(&mut self) {
        self.reloads += 1;
    }

    /// How often they were read again.
    pub fn reloads(&self) -> u64 {
        self.reloads
    }

    /// Computes minutes and wear again: the technology table has changed.
    pub fn recompute_burning(&mut self) {
        self.technology_edits += 1;
    }

    /// How often the technology table has changed.
    pub fn technology_edits(&self) -> u64 {
        self.technology_edits
    }

    fn part_key(&self, job: &PlanJob) -> Fingerprint {
        Fingerprint::of(Stage::Part, job, &format!("{:?}/{}", job.electrode.mesh, self.reloads))
    }

    fn say(&mut self, stage: Stage, kind: EventKind, text: &str) {
        let text = format!("{}: {text}", stage.name());
        self.events.push((stage, WorkEvent { kind, text, took: None }));
    }

    /// The sentence on what has been made of the present parameters in an early `stage`; none while there is nothing.
    pub fn sentence(&self, stage: Stage) -> Option<String> {
        let now = self.now.as_ref()?;
        match stage {
            Stage::Part => self.part.get(&now.part).map(|part| part.sentence()),
            Stage::Channel => self.channel.get(&now.channel).map(|found| found.sentence()),
            Stage::Electrode => self.electrodes.get(&now.electrode).map(|made| made.sentence()),
            _ => None,
        }
    }

    /// Takes in what has been made, and makes what `document` needs. Returns what has happened.
    pub fn follow(&mut self, document: &mut Document, priority: Priority) -> Vec<StageEvent> {
        self.priority = priority;
        self.take();
        self.refresh(document.params());
        let read = self.part().into_iter().flat_map(|part| &part.files);
        let read = read.filter(|file| !file.sha256.is_empty());
        let part_file = |file: &InputFile| PartFile { path: file.path.clone().into(), sha256: file.sha256.clone() };
        read.map(part_file).for_each(|file| document.note_file(&file));
        if self.released.is_some() && self.released().is_none() {
            self.withdraw();
            self.say(Stage::Export, EventKind::Cancelled, "release withdrawn: an input changed");
        }
        self.follow_early_stages();
        self.follow_kept_plan(document);
        self.follow_wishes();
        self.follow_measured();
        self.follow_finish();
        self.note_plan(document);
        std::mem::take(&mut self.events)
    }

    fn take(&mut self) {
        self.planned.prioritise(self.priority);
        self.exported.prioritise(self.priority);
        let events = &mut self.events;
        fn done<V>(sentence: impl Fn(&V) -> String) -> impl Fn(&V) -> (EventKind, String) {
            move |value| (EventKind::Done, sentence(value))
        }
        drain(events, Stage::Part, &mut self.part, done(Part::sentence));
        drain(events, Stage::Channel, &mut self.channel, done(FoundChannel::sentence));
        drain(events, Stage::Electrode, &mut self.electrodes, done(Electrodes::sentence));
        drain(events, Stage::Plan, &mut self.planned, Planned::sentence);
        drain(events, Stage::Verify, &mut self.measured, Planned::sentence);
        if drain(events, Stage::Verify, &mut self.finished, Finished::sentence) {
            // What was released without its copying motions is another plan now.
            self.released = self.released.take().filter(Released::is_whole);
        }
        drain(events, Stage::Export, &mut self.exported, done(Exported::sentence));
        while self.prepared.take().is_some() {}
    }

    /// Brings the fingerprints up to date. What is made for others is of no use to anybody.
    fn refresh(&mut self, job: &PlanJob) {
        let part = self.part_key(job);
        self.part.turn_to(&part);
        let content = self.part().map(|part| part.content()).unwrap_or_default();
        let content = format!("{content}/{}", self.reloads);
        let edits = self.technology_edits;
        let is_known =
            |now: &Now| now.part == part && now.content == content && now.technology_edits == edits && *now.job == *job;
        if !self.now.as_ref().is_some_and(is_known) {
            let now = Now::new(job, content, part, edits);
            if self.now.as_ref().is_some_and(|before| before.plan != now.plan) {
                self.wishes.clear();
            }
            self.channel.turn_to(&now.channel);
            self.electrodes.turn_to(&now.electrode);
            self.planned.turn_to(&now.plan);
            self.now = Some(now);
        }
    }

    fn follow_early_stages(&mut self) {
        let (Some(now), priority) = (&self.now, self.priority) else { return };
        let job = now.job.clone();
        self.part.ask(&now.part, priority, move |work| {
            await_drives(&files_in(&*job), &work.task)?;
            stages::load(&job, &work.task)
        });
        let Some(part) = self.part.get(&now.part) else { return };
        let (job, of) = (now.job.clone(), part.clone());
        self.channel.ask(&now.channel, priority, move |work| {
            stages::channel(&of, &job, &|place| work.partial(place), &work.task)
        });
        let Some(found) = self.channel.get(&now.channel) else { return };
        let (job, part, found) = (now.job.clone(), part.clone(), found.clone());
        self.electrodes.ask(&now.electrode, priority, move |work| stages::electrodes(&part, &found, &job, &work.task));
    }

    /// Takes up the plan that the document came with, if it is for its present parameters; says so once if it is not.
    fn follow_kept_plan(&mut self, document: &Document) {
        let Some(now) = &self.now else { return };
        if self.planned.last().is_some() || self.is_planning() || !self.planned.wants(&now.plan) {
            return;
        }
        let (part, found) = (self.part.get(&now.part), self.channel.get(&now.channel));
        let (Some(part), Some(found), Some(made)) = (part, found, self.electrodes.get(&now.electrode)) else { return };
        let kept = self.kept.get_or_insert_with(|| KeptPlan::of(document).map(Arc::new));
        let Some(kept) = kept.clone() else { return };
        // A file may say anything: as many electrodes as there are parts, or none of it counts.
        let is_whole = made.electrodes.len() == kept.electrodes.len();
        if !is_whole || kept.inputs != KeptPlan::inputs_of(&now.job, &part.content()) {
            if self.passed_over.replace(kept.inputs.clone()).as_ref() != Some(&kept.inputs) {
                self.say(Stage::Plan, EventKind::Cancelled, "the plan in this project is out of date; plan again");
            }
            return;
        }
        let (part, found, job) = (part.clone(), found.clone(), now.job.clone());
        self.planned
            .ask(&now.plan, self.priority, move |work| Planned::replay(&kept, (&part, &found, &job), &work.task));
    }

    /// Begins what waits for the blisk to be ready.
    fn follow_wishes(&mut self) {
        if self.wishes.is_empty() {
            return;
        }
        let ready = match self.ready() {
            Ok(Some(ready)) => Ok(ready),
            Ok(None) => return,
            Err(why) => Err(why),
        };
        for wish in std::mem::take(&mut self.wishes) {
            match (wish, self.inputs(), &self.now, self.part()) {
                (Wish::Table(table), Ok(inputs), ..) => self.search(table, ready.clone(), inputs),
                (Wish::Plan, _, Some(now), Some(part)) => {
                    let (ready, part, job) = (ready.clone(), part.clone(), now.job.clone());
                    self.planned.restart(&now.plan, self.priority, move |work| {
                        let found = |partial| work.partial(Arc::new(partial));
                        Planned::search(&*ready?, (&part, &job), &found, &work.task)
                    });
                }
                _ => {}
            }
        }
    }

    fn wish(&mut self, wish: Wish) {
        self.wishes.retain(|other| *other != wish);
        self.wishes.push(wish);
        self.follow_wishes();
    }

    /// Works out the copying motions of a certified plan, and what stock is left, unless that was done or stopped.
    fn follow_finish(&mut self) {
        let found = self.now.as_ref().and_then(|now| self.channel.get(&now.channel)).cloned();
        let planned = self.current().filter(|planned| planned.outcome.is_verified()).cloned();
        let (Some(found), Some(planned), false) = (found, planned, self.is_planning()) else {
            return self.finished.stop();
        };
        self.finished
            .ask(&Same(planned.clone()), self.priority, move |work| Finished::of(&planned, &found.blisk, &work.task));
    }

    /// Has the document keep the present plan, for nominal electrodes.
    fn note_plan(&mut self, document: &mut Document) {
        let nominal = self.now.as_ref().and_then(|now| self.planned.get(&now.plan));
        let Some(planned) = nominal.cloned().map(Same) else { return };
        if self.noted.as_ref() == Some(&planned) {
            return;
        }
        if let Some(electrodes) = kept(&planned.0.outcome) {
            let inputs = KeptPlan::inputs_of(&planned.0.inputs.job, &planned.0.content);
            KeptPlan { inputs, electrodes }.note(document);
        }
        self.noted = Some(planned);
    }

    /// The inputs of a plan for the present parameters.
    ///
    /// # Errors
    /// One line for the user if nothing can be planned.
    fn inputs(&self) -> Result<PlanInputs, String> {
        let now = self.now.as_ref().ok_or("nothing is loaded")?;
        let (part, found) = (self.part.get(&now.part), self.channel.get(&now.channel));
        let (part, _) = part.zip(found).ok_or("the channel is not known yet")?;
        now.problem.clone().map_or_else(|| Ok(inputs_of(part, &now.job)), Err)
    }

    /// The present blisk made ready for planning, once it is.
    ///
    /// # Errors
    /// One line for the user if it cannot be.
    fn ready(&mut self) -> Result<Option<Arc<PreparedBlisk>>, String> {
        let Some(now) = &self.now else { return Ok(None) };
        let Some(found) = self.channel.get(&now.channel).cloned() else { return Ok(None) };
        let cell = now.job.plan.field_cell_mm;
        let key = (Same(found.clone()), cell);
        if self.prepared.wants(&key) {
            self.prepared.clear();
        }
        let state = self.prepared.ask(&key, self.priority, move |work| {
            let (blisk, exact, channel) = (found.blisk.clone(), found.exact.clone(), found.channel.clone());
            PreparedBlisk::new(blisk, exact, channel, cell, &work.task).map_err(|e| e.to_string())
        });
        state.why_not().map_or_else(|| Ok(self.prepared.get(&key).cloned()), |why| Err(why.to_owned()))
    }

    /// Starts the plan for the parameters of the last [`follow`](Self::follow).
    ///
    /// # Errors
    /// One line for the user if it cannot be started.
    pub fn start_plan(&mut self) -> Result<(), String> {
        self.inputs()?;
        self.released = None;
        self.planned.stop();
        self.finished.stop();
        self.exported.stop();
        self.wish(Wish::Plan);
        Ok(())
    }

    /// Cancels the plan, and whatever else runs but for sizes.
    pub fn cancel(&mut self) {
        if self.wishes.contains(&Wish::Plan) {
            self.wishes.retain(|wish| *wish != Wish::Plan);
            self.say(Stage::Plan, EventKind::Cancelled, "cancelled");
        }
        self.cancel_look();
        if self.wishes.is_empty() {
            self.prepared.stop();
        }
        self.part.cancel();
        self.channel.cancel();
        self.electrodes.cancel();
        self.planned.cancel();
        self.measured.cancel();
        self.finished.cancel();
        self.exported.cancel();
    }

    /// Whether a plan is being made for the present parameters, or waits to be.
    pub fn is_planning(&self) -> bool {
        let is_running = |now: &Now| self.planned.state(&now.plan) == State::Running;
        self.wishes.contains(&Wish::Plan) || self.now.as_ref().is_some_and(is_running)
    }

    /// How `stage` stands for the document of the last [`follow`](Self::follow). What begins by itself and was
    /// cancelled has failed; what only the user begins is then as it was before.
    pub fn state(&self, stage: Stage) -> State {
        let Some(now) = &self.now else { return State::Missing };
        let early = |state| match state {
            State::Cancelled => State::Failed("cancelled; load the part again to go on".to_owned()),
            state => state,
        };
        match stage {
            Stage::Part => early(self.part.state(&now.part)),
            Stage::Channel => early(self.channel.state(&now.channel)),
            Stage::Electrode => early(self.electrodes.state(&now.electrode)),
            Stage::Plan if self.is_planning() => State::Running,
            Stage::Plan => match self.current() {
                Some(planned) if !planned.comes_out() => State::Failed(planned.sentence().1),
                _ => as_before(&self.planned, &now.plan),
            },
            Stage::Verify => match (self.state(Stage::Plan), self.current()) {
                (State::Ready, Some(planned)) if !planned.outcome.may_be_approved() => {
                    State::Failed(planned.sentence().1)
                }
                // Nothing is verified on a machine before its whole motion is known.
                (State::Ready, _) if simulate::is_needed(&now.job) => match self.finishing() {
                    State::Missing => State::Running,
                    state => state,
                },
                (State::Failed(_) | State::Running, _) => State::Missing,
                // A plan that is not rewritten for the measured electrodes yet.
                (State::Ready, None) => self.measured_key().map_or(State::Missing, |key| self.measured.state(&key)),
                (state, _) => state,
            },
            Stage::Export => match self.exports {
                (Some(of), number) if of == now.export => as_before(&self.exported, &(of, number)),
                _ if self.exported.last().is_some() => State::Stale,
                _ => State::Missing,
            },
        }
    }

    /// How the copying motions of the plan, and what stock is left, stand; stale if the plan is.
    pub fn finishing(&self) -> State {
        let is_verified = |planned: &Planned| planned.outcome.is_verified();
        match (self.current(), self.planned()) {
            (Some(planned), _) if is_verified(planned) => match self.finished.state(&Same(planned.clone())) {
                // It is begun as soon as the plan is made.
                State::Stale => State::Missing,
                State::Cancelled => State::Failed("stopped".to_owned()),
                state => state,
            },
            (None, Some(planned)) if is_verified(planned) => State::Stale,
            _ => State::Missing,
        }
    }

    /// Works out the copying motions after all, where that was stopped.
    pub fn resume_finishing(&mut self) {
        if let Some(planned) = self.current().cloned() {
            self.finished.resume(&Same(planned));
        }
    }

    /// The part, current or not.
    pub fn part(&self) -> Option<&Arc<Part>> {
        self.part.last().map(|(_, part)| part)
    }

    /// The channel, current or not.
    pub fn channel(&self) -> Option<&Arc<FoundChannel>> {
        self.channel.last().map(|(_, found)| found)
    }

    /// The place where the channel of the present parameters was refused, in the coordinates of the mesh (mm).
    pub fn refused_at(&self) -> Option<DVec3> {
        let now = &self.now.as_ref()?.channel;
        self.channel.partial(now).copied().filter(|_| matches!(self.channel.state(now), State::Failed(_)))
    }

    /// The electrodes, current or not.
    pub fn electrodes(&self) -> Option<&Arc<Electrodes>> {
        self.electrodes.last().map(|(_, made)| made)
    }

    /// The plan with its electrodes for the screen, current or not.
    pub fn planned(&self) -> Option<&Arc<Planned>> {
        self.current().or(self.planned.last().map(|(_, planned)| planned))
    }

    /// The plan, current or not: see [`state`](Self::state).
    pub fn plan(&self) -> Option<&Arc<PlanOutcome>> {
        self.planned().map(|planned| &planned.outcome)
    }

    /// The plan of the present parameters, for the electrodes as they are measured if they are.
    fn current(&self) -> Option<&Arc<Planned>> {
        match self.measured_key() {
            Some(key) => self.measured.get(&key),
            None => self.planned.get(&self.now.as_ref()?.plan),
        }
    }

    /// The stock that the electrodes of the plan leave, for the screen.
    pub fn residual_stock_shape(&self) -> Option<&MapShape> {
        self.finished.get(&Same(self.planned()?.clone()))?.residual_stock.as_ref()
    }

    /// What the plan that runs has found so far.
    pub fn partial_plan(&self) -> Option<&Arc<PartialPlan>> {
        let now = self.now.as_ref().filter(|now| self.planned.state(&now.plan) == State::Running)?;
        self.planned.partial(&now.plan)
    }

    /// What is being worked on: what the user waits for, first what has begun.
    pub fn doing(&self) -> Option<&Doing> {
        let ready = self.prepared.doing().filter(|_| self.wishes.contains(&Wish::Plan));
        let early = [self.part.doing(), self.channel.doing(), self.electrodes.doing(), ready];
        let late = [self.planned.doing(), self.finished.doing(), self.exported.doing()];
        let all = early.into_iter().chain(late).chain([self.look_doing()]);
        all.flatten().min_by_key(|doing| doing.is_waiting)
    }

    /// Whether channel and electrode, as far as they are known, are of earlier parameters, in this order: the present ones
    /// could not be made, or have been worked on for more than a moment.
    pub fn is_earlier(&self) -> [bool; 2] {
        let is_slow = |doing: Option<&Doing>| doing.is_some_and(|doing| doing.asked.elapsed() > MOMENT);
        let is_off = |stage, doing| match self.state(stage) {
            State::Failed(_) => true,
            State::Running => is_slow(doing),
            _ => false,
        };
        let part = is_off(Stage::Part, self.part.doing());
        let channel = part || is_off(Stage::Channel, self.channel.doing());
        let electrode = channel || is_off(Stage::Electrode, self.electrodes.doing());
        [channel && self.channel().is_some(), electrode && self.electrodes().is_some()]
    }

    /// Whether anything waits or runs, sizes and looks of a moment apart.
    pub fn is_busy(&self) -> bool {
        self.wishes.contains(&Wish::Plan) || self.doing().is_some()
    }
}

/// Takes in what has become of the work for `stage`. Returns whether any has ended.
fn drain<K: Clone + PartialEq, V: Send + 'static, P: Send + 'static>(
    events: &mut Vec<StageEvent>,
    stage: Stage,
    memo: &mut Memo<K, V, P>,
    sentence: impl Fn(&V) -> (EventKind, String),
) -> bool {
    let before = events.len();
    while let Some(ended) = memo.take() {
        events.push((stage, WorkEvent::of(stage.name(), ended, &sentence)));
    }
    events.len() > before
}

/// How a value stands that only the user has made: as before, if that was cancelled.
fn as_before<K: Clone + PartialEq, V: Send + 'static, P: Send + 'static>(memo: &Memo<K, V, P>, key: &K) -> State {
    match memo.state(key) {
        State::Cancelled if memo.last().is_some() => State::Stale,
        State::Cancelled => State::Missing,
        state => state,
    }
}
