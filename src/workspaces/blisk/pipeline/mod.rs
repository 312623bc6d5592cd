//! The steps of a document on the worker thread: what is done, what runs, what is stale, what failed.
//!
//! [`Pipeline::follow`] is called whenever the document may have changed. It starts part, channel and electrode by
//! itself, since they take well under a second; the plan is started by the user. A result is kept with the
//! fingerprint of what it was made from and is current only as long as that is the document's.

mod answers;
mod follow;
mod partial;
mod prepared;
mod sentences;
mod slot;
mod tuning;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

pub use crate::workspaces::news::EventKind;
pub use partial::PartialPlan;
pub use slot::StageState;
pub use tuning::TuningInputs;

use partial::Shapes;
use prepared::Prepared;
use sentences::plan_sentence;
use slot::Slot;

use crate::workspaces::blisk::document::field_table::FIELDS;
use crate::workspaces::blisk::document::job_file::PlanJob;
use crate::workspaces::blisk::document::kept_plan::KeptPlan;
use crate::workspaces::blisk::document::stage::{Fingerprint, Stage};
use crate::workspaces::blisk::job::finish::Finishing;
use crate::workspaces::blisk::job::plan::{PlanInputs, PlanJobError, PlanOutcome};
use crate::workspaces::blisk::job::released::{NotReleased, Released};
use crate::workspaces::blisk::job::simulate;
use crate::workspaces::blisk::job::stages::{Electrodes, FoundChannel, Part};
use crate::workspaces::blisk::report::InputFile;
use crate::workspaces::blisk::scene::leftover::LeftoverShape;
use crate::workspaces::worker::{Reporter, Worker};
use feed::problem::{Convergence, Node};
use files::Validate as _;
use render::mesh::RenderMesh;
use task::Task;
use wheel::channel::Channel;
use wheel::electrode::Electrode;

/// What a step has found.
enum Found {
    Part(Box<Part>),
    Channel(Box<FoundChannel>),
    Electrode(Electrodes),
    Plan(Box<Planned>),
    Finish(Finished),
    Export(Exported),
}

/// A plan with its electrodes for the screen.
struct Planned {
    inputs: PlanInputs,
    /// What the meshes held that it was made from: [`Part::content`].
    content: String,
    outcome: Arc<PlanOutcome>,
    shapes: Vec<Arc<RenderMesh>>,
}

/// How the electrodes of a plan finish the channel; the figures are in the plan itself.
struct Finished {
    /// What stock is left, or why that cannot be told; and what collides on the machine.
    said: Result<String, String>,
    /// The stock that is left, for the screen.
    leftover: Option<LeftoverShape>,
}

impl Finished {
    fn new(finishing: &Finishing, channel: &Channel) -> Self {
        let left = &finishing.leftover;
        let collision = finishing.collision().map(|simulation| simulation.sentence());
        let said = left.as_ref().map(|left| left.sentence(channel)).map_err(Clone::clone);
        Self {
            said: collision.map_or(said, Err),
            leftover: left.as_ref().ok().map(|left| LeftoverShape::new(&left.map)),
        }
    }
}

impl Planned {
    fn new(inputs: PlanInputs, content: String, outcome: PlanOutcome) -> Self {
        let shapes = outcome.electrodes.iter().map(|e| Arc::new(RenderMesh::new(&e.electrode.mesh))).collect();
        Self { inputs, content, outcome: Arc::new(outcome), shapes }
    }
}

/// What was written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Exported {
    /// Where.
    pub folder: PathBuf,
    /// The names of the files.
    pub written: Vec<String>,
}

/// Writes a released plan of these inputs, which were read from these files, into a folder; answers the names of the files.
pub type ExportWork =
    Box<dyn FnOnce(&Path, &Released, &PlanInputs, Vec<InputFile>, &Task) -> Result<Vec<String>, String> + Send>;

/// A line for the log.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// Which step.
    pub stage: Stage,
    /// What became of it.
    pub kind: EventKind,
    /// In one sentence.
    pub text: String,
    /// How long it was worked on.
    pub took: Option<Duration>,
}

/// What is being worked on.
#[derive(Debug, Clone, PartialEq)]
pub struct Running {
    /// Which step.
    pub stage: Stage,
    /// What is being done, in the words of the computation.
    pub doing: String,
    /// How much of that is done, 0 to 1.
    pub fraction: f64,
    /// Detail, may be empty.
    pub message: String,
    /// When the step began.
    pub since: Instant,
    /// When what is being done now began.
    doing_since: Instant,
}

impl Running {
    /// Time that what is being done will still take if it goes on as it did; none while that cannot be told.
    pub fn time_left(&self) -> Option<Duration> {
        let spent = self.doing_since.elapsed();
        let known = self.fraction > 0.03 && self.fraction < 1.0 && spent > Duration::from_millis(500);
        known.then(|| spent.mul_f64((1.0 - self.fraction) / self.fraction))
    }
}

/// The fingerprints of the present document.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Now {
    part: Fingerprint,
    channel: Fingerprint,
    electrode: Fingerprint,
    plan: Fingerprint,
    export: Fingerprint,
}

/// The steps of one document. See the module's page.
pub struct Pipeline {
    worker: Worker<PartialPlan, Found>,
    part: Slot<Part>,
    channel: Slot<FoundChannel>,
    electrode: Slot<Electrodes>,
    plan: Slot<Planned>,
    finish: Slot<Finished>,
    export: Slot<Exported>,
    prepared: Prepared,
    released: Option<Released>,
    /// The kept plan that was taken up already.
    replayed: Option<String>,
    /// The inputs of the kept plan that was found to be of other parameters.
    passed_over: Option<String>,
    /// A plan to be noted in the document.
    newly_planned: Option<KeptPlan>,
    partial: PartialPlan,
    /// Partial plans so far.
    partials: u64,
    running: Option<Running>,
    now: Option<(PlanJob, Now)>,
    reloads: u64,
    /// The part of a document that was opened, which has been read already.
    given: Option<Arc<Part>>,
}

impl Pipeline {
    /// Starts the worker; `wake` is called from it whenever something has happened.
    ///
    /// # Errors
    /// If the system gives no thread.
    pub fn start(wake: impl Fn() + Send + Sync + 'static) -> std::io::Result<Self> {
        Ok(Self {
            worker: Worker::start(wake)?,
            part: Slot::default(),
            channel: Slot::default(),
            electrode: Slot::default(),
            plan: Slot::default(),
            finish: Slot::default(),
            export: Slot::default(),
            prepared: Prepared::default(),
            released: None,
            replayed: None,
            passed_over: None,
            newly_planned: None,
            partial: PartialPlan::default(),
            partials: 0,
            running: None,
            now: None,
            reloads: 0,
            given: None,
        })
    }

    /// Starts the plan for the parameters of the last [`follow`](Self::follow).
    ///
    /// # Errors
    /// One line for the user if it cannot be started.
    pub fn start_plan(&mut self) -> Result<(), String> {
        let Some((job, now)) = self.now.clone() else { return Err("nothing is loaded".to_owned()) };
        let (Some(part), Some(channel)) = (self.part.current(now.part), self.channel.current(now.channel)) else {
            return Err("the channel is not known yet".to_owned());
        };
        let (part, channel) = (part.clone(), channel.clone());
        job.validate().map_err(|problem| FIELDS.in_window(&problem))?;
        self.partial = PartialPlan::default();
        self.released = None;
        let prepared = self.prepared.clone();
        let work = move |reporter: &Reporter<PartialPlan, Found>, task: &Task| {
            let inputs = PlanInputs { blisk: part.mesh.clone(), own_electrode: part.own_electrode.clone(), job };
            let text = |e: PlanJobError| e.to_string();
            simulate::check_machine(&inputs.job, task).map_err(text)?;
            simulate::check_channels(&inputs.job, &channel.channel).map_err(text)?;
            let ready = prepared.get(&channel, inputs.job.plan.field_cell_mm, task).map_err(text)?;
            let shapes = Shapes::default();
            let observe = |electrode: &Arc<Electrode>, nodes: &[Node], convergence: &[Convergence]| {
                let electrode = Some((electrode.clone(), shapes.of(electrode)));
                let (nodes, convergence) = (nodes.to_vec(), convergence.to_vec());
                reporter.partial(PartialPlan { number: 0, electrode, nodes, convergence });
            };
            let outcome =
                crate::workspaces::blisk::job::plan::run_prepared(&ready, &inputs, &observe, task).map_err(text)?;
            Ok(Found::Plan(Box::new(Planned::new(inputs, part.content(), outcome))))
        };
        let id = self.worker.submit(Stage::Plan as u32, work);
        self.plan.running = Some((id, now.plan));
        self.plan.failure = None;
        Ok(())
    }

    /// Cancels the plan, or whatever else runs.
    pub fn cancel(&mut self) {
        self.part.rest(self.part.running.map(|(_, of)| of));
        self.channel.rest(self.channel.running.map(|(_, of)| of));
        self.electrode.rest(self.electrode.running.map(|(_, of)| of));
        self.finish.failure = self.finish.running.map(|(_, of)| (of, "stopped".to_owned()));
        self.worker.cancel_from(0);
        if let Some(running) = &mut self.running {
            running.message = "stopping".to_owned();
        }
    }

    /// Forgets everything: another document is there, with this part if it has been read already.
    pub fn reset(&mut self, part: Option<Arc<Part>>) {
        self.given = part;
        self.worker.cancel_from(0);
        (self.part, self.channel, self.electrode) = Default::default();
        (self.plan, self.finish, self.export) = Default::default();
        (self.released, self.replayed, self.newly_planned) = Default::default();
        (self.running, self.now, self.passed_over) = (None, None, None);
        self.partial = PartialPlan::default();
    }

    /// Reads the files again.
    pub fn reload(&mut self) {
        self.reloads += 1;
    }

    /// How often they were read again.
    pub fn reloads(&self) -> u64 {
        self.reloads
    }

    /// How `stage` stands for the document of the last [`follow`](Self::follow).
    pub fn state(&self, stage: Stage) -> StageState {
        let Some((_, now)) = &self.now else { return StageState::Missing };
        match stage {
            Stage::Part => self.part.state(now.part),
            Stage::Channel => self.channel.state(now.channel),
            Stage::Electrode => self.electrode.state(now.electrode),
            Stage::Plan => match (self.plan.state(now.plan), &self.plan.value) {
                (StageState::Done, Some((_, plan)))
                    if plan.outcome.electrodes.iter().any(|e| e.plan.path.is_none()) =>
                {
                    StageState::Failed(plan_sentence(plan).1)
                }
                (state, _) => state,
            },
            Stage::Verify => match (self.plan.state(now.plan), &self.plan.value) {
                (StageState::Done, Some((_, plan)))
                    if plan.outcome.electrodes.iter().any(|e| e.plan.path.is_none()) =>
                {
                    StageState::Missing
                }
                (StageState::Done, Some((_, plan))) if !plan.outcome.may_be_approved() => {
                    StageState::Failed(plan_sentence(plan).1)
                }
                // Nothing is verified on a machine before its whole motion is known.
                (StageState::Done, _) if self.now.as_ref().is_some_and(|(job, _)| simulate::is_needed(job)) => {
                    match self.finishing() {
                        StageState::Missing => StageState::Running,
                        state => state,
                    }
                }
                (StageState::Failed(_) | StageState::Running, _) => StageState::Missing,
                (state, _) => state,
            },
            Stage::Export => self.export.state(now.export),
        }
    }

    /// The part, current or not.
    pub fn part(&self) -> Option<&Arc<Part>> {
        self.part.value.as_ref().map(|(_, v)| v)
    }

    /// The channel, current or not.
    pub fn channel(&self) -> Option<&Arc<FoundChannel>> {
        self.channel.value.as_ref().map(|(_, v)| v)
    }

    /// The electrodes, current or not.
    pub fn electrodes(&self) -> Option<&Arc<Electrodes>> {
        self.electrode.value.as_ref().map(|(_, v)| v)
    }

    /// The plan, current or not: see [`state`](Self::state).
    pub fn plan(&self) -> Option<&Arc<PlanOutcome>> {
        self.plan.value.as_ref().map(|(_, v)| &v.outcome)
    }

    /// The electrodes of the plan for the screen.
    pub fn plan_shapes(&self) -> Option<&[Arc<RenderMesh>]> {
        self.plan.value.as_ref().map(|(_, v)| &v.shapes[..])
    }

    /// The stock that the electrodes of the plan leave, for the screen.
    pub fn leftover_shape(&self) -> Option<&LeftoverShape> {
        self.finish.value.as_ref().and_then(|(_, v)| v.leftover.as_ref())
    }

    /// What the plan that runs has found so far.
    pub fn partial_plan(&self) -> Option<&PartialPlan> {
        self.plan.running.map(|_| &self.partial)
    }

    /// What is being worked on.
    pub fn running(&self) -> Option<&Running> {
        self.running.as_ref()
    }

    /// Whether anything waits or runs.
    pub fn is_busy(&self) -> bool {
        self.worker.is_busy()
    }

    /// The plan if it is that of the present parameters and every path of it is certified; none while another one is
    /// being made, which would take its place unseen.
    fn certified(&self) -> Option<&Arc<PlanOutcome>> {
        let (_, now) = self.now.as_ref()?;
        let plan = &self.plan.current(now.plan)?.outcome;
        (self.plan.running.is_none() && plan.may_be_approved()).then_some(plan)
    }

    /// Whether the plan can be released: all that is exported with it is known.
    pub fn can_release(&self) -> bool {
        let is_settled = match self.finishing() {
            StageState::Done => true,
            StageState::Failed(_) => self.now.as_ref().is_some_and(|(job, _)| !simulate::is_needed(job)),
            StageState::Missing | StageState::Running | StageState::Stale => false,
        };
        self.certified().is_some() && is_settled
    }

    /// How the copying motions of the plan, and what stock is left, stand; stale if the plan is.
    pub fn finishing(&self) -> StageState {
        match (&self.now, self.plan()) {
            (Some((_, now)), Some(plan)) if plan.is_verified() => match self.finish.state(now.plan) {
                // It is begun as soon as the plan is that of the present parameters.
                StageState::Stale if self.plan.current(now.plan).is_some() => StageState::Missing,
                state => state,
            },
            _ => StageState::Missing,
        }
    }

    /// Works out the copying motions after all, where that was stopped.
    pub fn resume_finishing(&mut self) {
        self.finish.failure = None;
    }

    /// Releases the plan, as the user wishes. It can be exported from then on, until an input changes or it is planned anew.
    ///
    /// # Errors
    /// One line if there is no certified plan for the present parameters, or another one is being made.
    pub fn release(&mut self) -> Result<(), String> {
        let released = self.certified().ok_or(NotReleased).and_then(Released::by_user).map_err(|e| e.to_string())?;
        if !self.can_release() {
            return Err(
                "the copying motions of this plan, or its motion on the machine, are not computed yet".to_owned()
            );
        }
        self.released = Some(released);
        Ok(())
    }

    /// Takes the release back, and stops an export that has not yet replaced any file.
    pub fn withdraw(&mut self) {
        self.released = None;
        self.worker.cancel_from(Stage::Export as u32);
    }

    /// The present plan, if the user released it.
    pub fn released(&self) -> Option<&Released> {
        self.released.as_ref().filter(|released| self.certified().is_some_and(|plan| released.is_of(plan)))
    }

    /// Writes the released plan into `folder`.
    ///
    /// # Errors
    /// One line if it is not released.
    pub fn start_export(&mut self, folder: &Path, write: ExportWork) -> Result<(), String> {
        let released = self.released().cloned().ok_or("release the plan first")?;
        let planned = self.plan.value.as_ref().map(|(_, planned)| planned.clone());
        let (Some((job, now)), Some(part), Some(planned)) = (self.now.clone(), self.part(), planned) else {
            return Err("there is no plan to export".to_owned());
        };
        let (files, folder) = (part.files.clone(), folder.to_owned());
        let work = move |_: &Reporter<PartialPlan, Found>, task: &Task| {
            // What is only about writing may have changed since the plan was made.
            let inputs = PlanInputs { job, ..planned.inputs.clone() };
            write(&folder, &released, &inputs, files, task).map(|written| Found::Export(Exported { folder, written }))
        };
        let id = self.worker.submit(Stage::Export as u32, work);
        self.export.failure = None;
        self.export.running = Some((id, now.export));
        Ok(())
    }

    /// What was exported last.
    pub fn exported(&self) -> Option<&Arc<Exported>> {
        self.export.value.as_ref().map(|(_, v)| v)
    }
}
