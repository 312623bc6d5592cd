//! What a plan is made from, and what comes out: of each electrode, of all together, or why there is none.

use std::sync::{Arc, OnceLock};
use std::time::Instant;

use super::measured::MeasuredWalls;
use super::node_distances::NodeDistances;
use crate::workspaces::blisk::document::job_file::PlanJob;
use crate::workspaces::blisk::document::kept_plan::KeptPlanError;
use crate::workspaces::blisk::document::machine_file::MachineFileError;
use crate::workspaces::blisk::report::StageTime;
use feed::copying::Copying;
use feed::plan::FeedPlan;
use feed::plan_params::PlanError;
use feed::preset::Preset;
use feed::residual_stock::ResidualStock;
use feed::simulation::Simulation;
use feed::verify::VerifyError;
use feed::verify::setting::SettingRoom;
use geometry::exact::ExactMeshError;
use geometry::mesh::Mesh;
use task::{Cancelled, Task};
use wheel::centreline::Centreline;
use wheel::channel::Channel;
use wheel::electrode::{Electrode, ElectrodeError, EntrySide};
use wheel::error::BliskError;
use wheel::sections::MeasuredSection;
use wheel::surface_finder::SurfaceFinder;

/// What a plan is made from.
#[derive(Debug, Clone)]
pub struct PlanInputs {
    /// The blisk as loaded (mm).
    pub blisk: Arc<Mesh>,
    /// Solids beside the blisk that are in the way (mm, in its coordinates); none if there are no such.
    pub obstacles: Option<Arc<Mesh>>,
    /// The user's own electrodes in their final poses, in the blisk's coordinates (mm), in the order of `job`.
    pub own_electrodes: Vec<Arc<Mesh>>,
    /// The measured sections that the blisk was made from, in its coordinates; none where it was not.
    pub sections: Arc<[MeasuredSection]>,
    /// The wheel as it comes (mm, in the coordinates of the finished one); none of a full ring, or of one with an allowance.
    pub blank: Option<Arc<Mesh>>,
    /// All parameters.
    pub job: PlanJob,
}

impl PlanInputs {
    /// A blisk alone (mm): without obstacles, own electrodes and measured sections.
    pub fn of(blisk: impl Into<Arc<Mesh>>, job: PlanJob) -> Self {
        let (blisk, sections) = (blisk.into(), Arc::default());
        Self { blisk, obstacles: None, own_electrodes: Vec::new(), sections, blank: None, job }
    }

    /// Inputs of electrode number `number` as if its stage were the only one, and its number in that.
    pub(super) fn of_electrode(&self, number: usize) -> (Self, usize) {
        let (job, number) = self.job.of_electrode(number);
        (Self { job, ..self.clone() }, number)
    }

    /// Number of electrodes that are planned.
    pub fn electrodes(&self) -> usize {
        if self.own_electrodes.is_empty() { self.job.electrode.count() } else { self.own_electrodes.len() }
    }
}

/// What was found out about one electrode on one side.
#[derive(Debug, Clone)]
pub struct ElectrodeOutcome {
    /// The electrode as it is exported, in W.
    pub electrode: Electrode,
    /// Plan of the electrode.
    pub plan: FeedPlan,
    /// Place of the electrode on its holder, which the path makes up for; none where it is planned as nominal.
    pub preset: Option<Preset>,
    /// The electrode as it is worn, in the pose that makes up for it; none of a new one.
    pub worn: Option<Electrode>,
    /// Distance that the electrode would keep in that pose if nothing of it were worn (mm); none of a new one.
    pub unworn_mm: Option<f64>,
    /// Distances at the nodes of the plan; none where they were not measured.
    pub distances: Vec<NodeDistances>,
    /// Sides that were tried before, and why they were left.
    pub tried: Vec<(EntrySide, String)>,
}

impl ElectrodeOutcome {
    /// An electrode with its plan on the first side that is tried; its distances are not measured.
    pub(super) fn of(electrode: Electrode, plan: FeedPlan) -> Self {
        Self { electrode, plan, preset: None, worn: None, unworn_mm: None, distances: Vec::new(), tried: Vec::new() }
    }

    /// How the electrode stands and is worn, in a sentence; none where it is planned as nominal.
    pub fn preset_sentence(&self) -> Option<String> {
        let sentence = self.preset?.sentence();
        let unworn = self.unworn_mm.map(|mm| {
            format!(
                ". The certificate takes every face that burns to have worn by exactly this, along the direction of burning; a \
                 face that has not worn at all keeps {mm:.4} mm at least"
            )
        });
        Some(sentence + &unworn.unwrap_or_default())
    }

    /// The electrode that burns: as it is worn, or new.
    pub fn burning(&self) -> &Electrode {
        self.worn.as_ref().unwrap_or(&self.electrode)
    }

    /// Whether the search for a change that makes it feasible was stopped.
    pub(super) fn is_stopped(&self) -> bool {
        self.plan.jam.as_ref().and_then(|jam| jam.opening.as_ref()).is_some_and(|opening| opening.is_stopped)
    }

    /// Measures the distances at the nodes; a plan that is cancelled only then stays as it is, without them.
    pub(super) fn measure(&mut self, around: (&Channel, &SurfaceFinder, Option<&Centreline>), task: &Task) {
        let found = NodeDistances::at(&self.plan.nodes, self.burning(), around, &task.cancel);
        self.distances = found.unwrap_or_default();
    }
}

/// The answer of a plan.
#[derive(Debug, Clone)]
pub struct PlanOutcome {
    /// The channel.
    pub channel: Arc<Channel>,
    /// The electrodes in the order of their parts.
    pub electrodes: Vec<ElectrodeOutcome>,
    /// Centreline of the channel, where there is one and it was looked for.
    pub centreline: Option<Arc<Centreline>>,
    /// The measured sections that the blisk was made from against the walls of the channel, if it was made from any.
    pub measured: Option<Arc<MeasuredWalls>>,
    /// Times of the stages in order.
    pub times: Vec<StageTime>,
    /// How they finish the channel. It is worked out after the feeds, which it does not change: see
    /// [`finish`](super::finish::finish).
    finishing: OnceLock<Finishing>,
    /// What stock they leave; worked out last.
    stock: OnceLock<Stock>,
    /// Whether the drawing of the plan's pictures was stopped.
    is_undrawn: bool,
}

impl PlanOutcome {
    /// What came out of the feeds; nothing is known yet of what comes after them.
    pub(super) fn new(channel: Arc<Channel>, electrodes: Vec<ElectrodeOutcome>, times: Vec<StageTime>) -> Self {
        Self {
            channel,
            electrodes,
            centreline: None,
            measured: None,
            times,
            finishing: OnceLock::new(),
            stock: OnceLock::new(),
            is_undrawn: false,
        }
    }

    /// The plan with nothing known of what comes after the feeds.
    pub(super) fn unfinished(self) -> Self {
        Self { finishing: OnceLock::new(), stock: OnceLock::new(), ..self }
    }

    /// The plan with the drawing of its pictures stopped.
    pub fn undrawn(self) -> Self {
        Self { is_undrawn: true, ..self }
    }

    /// The plan with what the measured sections of `inputs` are off its channel's walls. One that is cancelled only then
    /// stays as it is.
    pub(super) fn with_sections(mut self, inputs: &PlanInputs, task: &Task) -> Self {
        let limit = inputs.job.blisk.sections.limit_mm();
        let found = MeasuredWalls::of(&inputs.sections, &self.channel, limit, &task.cancel);
        self.measured = found.unwrap_or_default().map(Arc::new);
        self
    }

    /// Whether every electrode has a verified path, nothing is known to collide on the machine, and nothing that comes
    /// after the feeds was stopped.
    pub fn may_be_approved(&self) -> bool {
        self.is_verified() && self.stopped().is_none() && self.finishing().is_none_or(|f| f.collision().is_none())
    }

    /// Stage that was stopped, if one was: of what comes after the feeds, the search for what would make one feasible, or
    /// the drawing of the pictures.
    pub fn stopped(&self) -> Option<&'static str> {
        if self.electrodes.iter().any(ElectrodeOutcome::is_stopped) {
            return Some("search for a change that makes it feasible");
        }
        let of_stock = || self.stock()?.is_stopped.then_some("map of the residual stock");
        let of_pictures = || self.is_undrawn.then_some("drawing of the pictures");
        self.finishing().and_then(|finishing| finishing.stopped).or_else(of_stock).or_else(of_pictures)
    }

    /// Whether every electrode has a verified path.
    pub fn is_verified(&self) -> bool {
        !self.electrodes.is_empty() && self.electrodes.iter().all(|e| e.plan.is_verified())
    }

    /// How the electrodes finish the channel, once that is known.
    pub fn finishing(&self) -> Option<&Finishing> {
        self.finishing.get()
    }

    pub(super) fn finished_by(&self, finishing: Finishing) -> &Finishing {
        self.finishing.get_or_init(|| finishing)
    }

    /// What stock the electrodes leave, once that is known or known to be unknown.
    pub fn stock(&self) -> Option<&Stock> {
        self.stock.get()
    }

    pub(super) fn leaving(&self, stock: Stock) -> &Stock {
        self.stock.get_or_init(|| stock)
    }

    /// The copying motion of the electrode with this index, if that is known.
    pub fn copying(&self, index: usize) -> Option<&Copying> {
        self.finishing()?.copying.get(index)
    }

    /// The setting errors that the feed of the electrode with this index bears, if the job asks about any.
    pub fn setting(&self, index: usize) -> Option<&SettingRoom> {
        self.finishing()?.setting.get(index)?.as_ref()
    }

    /// Whether the clearance is proven with the setting errors that the job asks about, for every feed that was looked at; true
    /// where none was.
    pub fn bears_setting(&self) -> bool {
        self.finishing().is_none_or(|f| f.setting.iter().flatten().all(SettingRoom::holds))
    }

    /// Sentences on the setting errors that each electrode bears, as far as known.
    pub fn setting_sentences(&self) -> impl Iterator<Item = String> {
        let rooms = self.finishing().into_iter().flat_map(|f| f.setting.iter().enumerate());
        let label = |i: usize| self.electrodes.get(i).map_or_else(String::new, |e| e.electrode.label(i));
        rooms.filter_map(move |(i, room)| Some(format!("Electrode {}: {}.", label(i), room.as_ref()?.sentence())))
    }

    /// The whole motion of the electrode with this index on the machine, if it was simulated.
    pub fn simulation(&self, index: usize) -> Option<&Arc<Simulation>> {
        self.finishing()?.simulations.get(index)
    }

    /// What stock is left, if that is known.
    pub fn residual_stock(&self) -> Option<&Arc<ResidualStock>> {
        self.stock()?.left.as_ref().ok()
    }
}

/// How the electrodes of a plan finish the channel once they are in.
#[derive(Debug, Clone)]
pub struct Finishing {
    /// The copying motion of each electrode; empty if not every electrode has a certified path.
    pub copying: Vec<Copying>,
    /// The setting errors that the feed of each electrode bears; empty if the job asks about none.
    pub setting: Vec<Option<SettingRoom>>,
    /// The whole motion of each electrode on the machine; empty if the machine has no bodies and no other channels are
    /// burnt.
    pub simulations: Vec<Arc<Simulation>>,
    /// Stage that was stopped, if one was: nothing can be approved then.
    pub stopped: Option<&'static str>,
    /// Times of the stages in order.
    pub times: Vec<StageTime>,
}

/// What stock the electrodes of a plan leave of the channel, all together. A plan can be approved before that is known.
#[derive(Debug, Clone)]
pub struct Stock {
    /// The stock, or why it cannot be told.
    pub left: Result<Arc<ResidualStock>, String>,
    /// Whether its computation was stopped.
    pub is_stopped: bool,
    /// Time of its computation.
    pub times: Vec<StageTime>,
}

impl Finishing {
    /// The first motion on the machine in which something comes too close, or an axis cannot go where it would have to.
    pub fn collision(&self) -> Option<&Simulation> {
        self.simulations.iter().map(|s| &**s).find(|s| !s.holds())
    }
}

/// Reason why a plan cannot be made. That there is no path is not an error but an answer.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum PlanJobError {
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    #[error("{0}")]
    Job(String),
    #[error(transparent)]
    Invalid(#[from] files::Invalid),
    #[error(transparent)]
    Kept(#[from] KeptPlanError),
    #[error(transparent)]
    Blisk(BliskError),
    #[error(transparent)]
    Electrode(ElectrodeError),
    #[error(transparent)]
    Plan(PlanError),
    #[error(transparent)]
    Mesh(#[from] ExactMeshError),
    #[error(transparent)]
    Verify(VerifyError),
    #[error(transparent)]
    Machine(MachineFileError),
}

impl From<VerifyError> for PlanJobError {
    fn from(error: VerifyError) -> Self {
        match error {
            VerifyError::Cancelled(cancelled) => cancelled.into(),
            other => Self::Verify(other),
        }
    }
}

impl From<MachineFileError> for PlanJobError {
    fn from(error: MachineFileError) -> Self {
        match error {
            MachineFileError::Cancelled(cancelled) => cancelled.into(),
            other => Self::Machine(other),
        }
    }
}

impl From<BliskError> for PlanJobError {
    fn from(error: BliskError) -> Self {
        match error {
            BliskError::Cancelled(cancelled) => cancelled.into(),
            other => Self::Blisk(other),
        }
    }
}

impl From<ElectrodeError> for PlanJobError {
    fn from(error: ElectrodeError) -> Self {
        match error {
            ElectrodeError::Cancelled(cancelled) => cancelled.into(),
            other => Self::Electrode(other),
        }
    }
}

impl From<PlanError> for PlanJobError {
    fn from(error: PlanError) -> Self {
        match error {
            PlanError::Cancelled(cancelled) => cancelled.into(),
            other => Self::Plan(other),
        }
    }
}

/// Adds up the times of stages by name.
#[derive(Clone, Default)]
pub(super) struct Clock(pub(super) Vec<StageTime>);

impl Clock {
    pub(super) fn time<T>(&mut self, stage: &str, work: impl FnOnce() -> T) -> T {
        let started = Instant::now();
        let result = work();
        self.add(stage, started.elapsed().as_secs_f64());
        result
    }

    pub(super) fn add(&mut self, stage: &str, seconds: f64) {
        match self.0.iter_mut().find(|t| t.stage == stage) {
            Some(known) => known.seconds += seconds,
            None => self.0.push(StageTime { stage: stage.to_owned(), seconds }),
        }
    }
}
