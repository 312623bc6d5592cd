//! From a blisk mesh to verified feed paths of its electrodes.

use std::sync::{Arc, OnceLock};
use std::time::Instant;

use super::finish::{Finishing, Stock, finish};
use super::prepared_blisk::PreparedBlisk;
use super::simulate;
use crate::workspaces::blisk::document::job_file::PlanJob;
use crate::workspaces::blisk::document::kept_plan::{KeptElectrode, KeptPlan, KeptPlanError};
use crate::workspaces::blisk::document::machine_file::MachineFileError;
use crate::workspaces::blisk::report::StageTime;
use feed::copying::Copying;
use feed::leftover::Leftover;
use feed::plan::{FeedPlan, PlanSettings};
use feed::plan_params::PlanError;
use feed::plan_params::Strategy;
use feed::planner::{DrawnIn, plan_drawn_in, plan_feed};
use feed::problem::Observe;
use feed::problem::{Convergence, Node};
use feed::replay::{Surroundings, replay_feed};
use feed::simulation::Simulation;
use feed::verify::VerifyError;
use files::Validate as _;
use geometry::exact::{ExactMesh, ExactMeshError};
use geometry::frame::Frame;
use geometry::mesh::Mesh;
use task::{Cancelled, Task};
use wheel::channel::Channel;
use wheel::electrode::{
    Electrode, ElectrodeError, ElectrodeParams, EnterSide, EntrySide, Sizing, from_user_mesh, make_electrodes,
};
use wheel::error::BliskError;
use wheel::find_channel::find_channel;
use wheel::surface_finder::SurfaceFinder;

/// What a plan is made from.
#[derive(Debug, Clone)]
pub struct PlanInputs {
    /// The blisk as loaded (mm).
    pub blisk: Arc<Mesh>,
    /// The user's own electrode in its final pose, in the blisk's coordinates (mm), if there is one.
    pub own_electrode: Option<Arc<Mesh>>,
    /// All parameters.
    pub job: PlanJob,
}

/// What was found out about one electrode on one side.
#[derive(Debug, Clone)]
pub struct ElectrodeOutcome {
    /// The electrode as it is exported, in W.
    pub electrode: Electrode,
    /// Plan of the electrode.
    pub plan: FeedPlan,
    /// Sides that were tried before, and why they were left.
    pub tried: Vec<(EntrySide, String)>,
}

/// The answer of a plan.
#[derive(Debug, Clone)]
pub struct PlanOutcome {
    /// The channel.
    pub channel: Arc<Channel>,
    /// The electrodes in the order of their parts.
    pub electrodes: Vec<ElectrodeOutcome>,
    /// Times of the stages in order.
    pub times: Vec<StageTime>,
    /// How they finish the channel. It is worked out after the feeds, which it does not change: see [`finish`].
    finishing: OnceLock<Finishing>,
    /// What stock they leave; worked out last.
    stock: OnceLock<Stock>,
}

impl PlanOutcome {
    /// Whether every electrode has a verified path, nothing is known to collide on the machine, and nothing that comes
    /// after the feeds was stopped.
    pub fn may_be_approved(&self) -> bool {
        self.is_verified() && self.stopped().is_none() && self.finishing().is_none_or(|f| f.collision().is_none())
    }

    /// Stage after the feeds that was stopped, if one was.
    pub fn stopped(&self) -> Option<&'static str> {
        let of_stock = || self.stock()?.is_stopped.then_some("map of the residual stock");
        self.finishing()?.stopped.or_else(of_stock)
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

    /// The whole motion of the electrode with this index on the machine, if it was simulated.
    pub fn simulation(&self, index: usize) -> Option<&Arc<Simulation>> {
        self.finishing()?.simulations.get(index)
    }

    /// What stock is left, if that is known.
    pub fn leftover(&self) -> Option<&Arc<Leftover>> {
        self.stock()?.left.as_ref().ok()
    }
}

/// Why a plan cannot be made. That there is no path is not an error but an answer.
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

/// Plans every electrode of the job, and works out how they finish the channel.
///
/// # Errors
/// [`PlanJobError`]; that there is no path is not one of them.
pub fn run(inputs: &PlanInputs, task: &Task) -> Result<PlanOutcome, PlanJobError> {
    run_finished(&prepare(inputs, task)?, inputs, task)
}

/// Plans every electrode of the job on a blisk that was made ready before, and works out how they finish the channel.
///
/// # Errors
/// As [`run`].
pub fn run_finished(prepared: &PreparedBlisk, inputs: &PlanInputs, task: &Task) -> Result<PlanOutcome, PlanJobError> {
    let outcome = run_prepared(prepared, inputs, &|_, _, _| (), task)?;
    finish(&outcome, inputs, &prepared.space.blisk, task)?;
    Ok(outcome)
}

/// Makes the blisk of a job ready for planning.
///
/// # Errors
/// If the machine or its bodies cannot be read, if there is no channel, or one that is too large or not all that are to be
/// burnt, or when told to stop.
pub fn prepare(inputs: &PlanInputs, task: &Task) -> Result<PreparedBlisk, PlanJobError> {
    let job = &inputs.job;
    job.validate()?;
    let mut clock = Clock::default();
    simulate::check_machine(job, task)?;
    let channel = clock.time("channel", || find_channel(&inputs.blisk, &job.blisk.options, task))?;
    simulate::check_channels(job, &channel)?;
    let blisk = inputs.blisk.in_frame(&channel.frame);
    let exact = clock.time("exact mesh", || ExactMesh::new(&blisk))?;
    let cell = job.plan.field_cell_mm;
    let mut prepared = PreparedBlisk::new(blisk.into(), exact.into(), channel.into(), cell, task)?;
    clock.0.append(&mut prepared.clock.0);
    prepared.clock = clock;
    Ok(prepared)
}

/// Looks at a plan while it is made: at the electrode that a way is searched for, and at what was found; see [`Observe`].
pub type ObservePlan<'a> = dyn Fn(&Arc<Electrode>, &[Node], &[Convergence]) + Sync + 'a;

/// Plans every electrode of the job on a blisk that was made ready before; `observe` is shown the nodes as they are
/// found. The answer is that of [`run`] before it is finished.
///
/// # Errors
/// [`PlanJobError`]; that there is no path is not one of them.
pub fn run_prepared(
    prepared: &PreparedBlisk,
    inputs: &PlanInputs,
    observe: &ObservePlan,
    task: &Task,
) -> Result<PlanOutcome, PlanJobError> {
    let clock = prepared.clock.clone();
    JobPlanner { inputs, prepared, observe, explain: true, task, clock }.outcome()
}

/// Plans as [`run_prepared`] does, without reporting nodes and without finding out which change
/// would open a way where there is none.
///
/// # Errors
/// As [`run_prepared`].
pub fn run_feeds(prepared: &PreparedBlisk, inputs: &PlanInputs, task: &Task) -> Result<PlanOutcome, PlanJobError> {
    let clock = prepared.clock.clone();
    JobPlanner { inputs, prepared, observe: &|_, _, _| (), explain: false, task, clock }.outcome()
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

    fn add(&mut self, stage: &str, seconds: f64) {
        match self.0.iter_mut().find(|t| t.stage == stage) {
            Some(known) => known.seconds += seconds,
            None => self.0.push(StageTime { stage: stage.to_owned(), seconds }),
        }
    }
}

struct JobPlanner<'a> {
    inputs: &'a PlanInputs,
    prepared: &'a PreparedBlisk,
    observe: &'a ObservePlan<'a>,
    explain: bool,
    task: &'a Task,
    clock: Clock,
}

impl JobPlanner<'_> {
    fn outcome(mut self) -> Result<PlanOutcome, PlanJobError> {
        self.inputs.job.validate()?;
        if self.inputs.job.electrode.size == Sizing::Auto {
            let todo = "[electrode] size = \"auto\": find the sizes first and take one, or give the reductions";
            return Err(PlanJobError::Job(todo.to_owned()));
        }
        let electrodes = self.electrodes()?;
        let channel = self.prepared.space.channel.clone();
        Ok(PlanOutcome { channel, electrodes, times: self.clock.0, finishing: OnceLock::new(), stock: OnceLock::new() })
    }

    fn electrodes(&mut self) -> Result<Vec<ElectrodeOutcome>, PlanJobError> {
        (0..self.parts()).map(|part| self.part(part)).collect()
    }

    fn parts(&self) -> usize {
        if self.inputs.own_electrode.is_some() { 1 } else { self.inputs.job.electrode.count() }
    }

    /// The electrode that is number `part` along X, columns of one part counted through. Tries the sides one after the
    /// other until one is verified; if none is, the one that came out, or else the one that got furthest, is the
    /// answer. A side for which no electrode can be made is noted and left.
    ///
    /// # Errors
    /// The error of the first side if no electrode can be made for any side.
    fn part(&mut self, part: usize) -> Result<ElectrodeOutcome, PlanJobError> {
        let mut best: Option<ElectrodeOutcome> = None;
        let mut impossible: Option<ElectrodeError> = None;
        let mut tried = Vec::new();
        let params = &self.inputs.job.electrode;
        let columns = if self.inputs.own_electrode.is_some() { 1 } else { params.columns };
        for side in sides(params.enter, part / columns, self.parts() / columns) {
            let outcome = match self.on_side(part, side) {
                Ok(outcome) => outcome,
                Err(PlanJobError::Electrode(error)) => {
                    tried.push((side, format!("cannot be made: {error}")));
                    impossible.get_or_insert(error);
                    continue;
                }
                Err(other) => return Err(other),
            };
            let worse = match best.take() {
                Some(before) if rank(&before) >= rank(&outcome) => {
                    best = Some(before);
                    Some(outcome)
                }
                before => {
                    best = Some(outcome);
                    before
                }
            };
            tried.extend(worse.map(|o| (o.electrode.enters_from, o.plan.verdict(&self.prepared.space.channel))));
            if best.as_ref().is_some_and(|b| b.plan.is_verified()) {
                break;
            }
        }
        match (best, impossible) {
            (Some(best), _) => Ok(ElectrodeOutcome { tried, ..best }),
            (None, Some(error)) => Err(error.into()),
            (None, None) => Err(Cancelled.into()),
        }
    }

    fn on_side(&mut self, part: usize, side: EntrySide) -> Result<ElectrodeOutcome, PlanJobError> {
        let started = Instant::now();
        let electrode = Arc::new(self.electrode(part, side, 0.0)?);
        self.clock.add("electrode", started.elapsed().as_secs_f64());
        let observe = |nodes: &[Node], traces: &[Convergence]| (self.observe)(&electrode, nodes, traces);
        let machine = &self.inputs.job.machine.seen_from_w(side);
        let settings = PlanSettings { explain: self.explain, machine, ..settings_of(&self.inputs.job, &observe) };
        let mut plan = match self.inputs.job.plan.strategy {
            Strategy::Global => self.drawn_in(part, &electrode, &settings)?,
            _ => {
                let remake = |h: f64| self.electrode(part, side, h);
                plan_feed(&self.prepared.space, &electrode, &settings, &remake, self.task)?
            }
        };
        self.clock.add("electrode field", plan.field_seconds);
        self.clock.add("search", plan.search_seconds);
        self.clock.add("certificate", plan.verify_seconds);
        let electrode = plan.remade.take().map_or_else(|| Arc::unwrap_or_clone(electrode), Arc::unwrap_or_clone);
        Ok(ElectrodeOutcome { electrode, plan, tried: Vec::new() })
    }

    /// The plan of `electrode` on the fullest one of its kind, which later plans with other reductions share.
    fn drawn_in(&self, part: usize, electrode: &Electrode, settings: &PlanSettings) -> Result<FeedPlan, PlanJobError> {
        let started = Instant::now();
        let which = (part, electrode.enters_from);
        let (full, turns) = self.prepared.fullest(self.inputs, which, self.task)?;
        let field_seconds = started.elapsed().as_secs_f64();
        let space = &self.prepared.space;
        let drawn_in = DrawnIn { prepared: &full, turns, electrode };
        let plan = plan_drawn_in(space, &drawn_in, settings, self.task)?;
        Ok(FeedPlan { field_seconds, ..plan })
    }

    fn electrode(&self, part: usize, side: EntrySide, h: f64) -> Result<Electrode, ElectrodeError> {
        let PreparedBlisk { space, exact, .. } = self.prepared;
        electrode_of(self.inputs, &space.channel, exact, (part, side, h), self.task)
    }
}

/// The electrode number `part` along X for a side, with its walls drawn in by a further `h` (rad), its vertices as a file
/// will hold them.
pub(super) fn electrode_of(
    inputs: &PlanInputs,
    channel: &Channel,
    exact: &ExactMesh,
    (part, side, h): (usize, EntrySide, f64),
    task: &Task,
) -> Result<Electrode, ElectrodeError> {
    let params = &inputs.job.electrode;
    let mut electrode = match &inputs.own_electrode {
        Some(own) => {
            from_user_mesh(own.in_frame(&channel.frame), channel, exact, params.spark_gap_mm, side, &task.cancel)?
        }
        None => {
            let [low, high] = params.circumferential_reduction_deg;
            let circumferential_reduction_deg = [low + h.to_degrees(), high + h.to_degrees()];
            let params = ElectrodeParams { circumferential_reduction_deg, ..params.clone() };
            let mut all = make_electrodes(channel, exact, &params, side, task)?;
            // Electrodes are counted from the side of entry.
            let (along, column) = (part / params.columns, part % params.columns);
            let from_entry = if side == EntrySide::MinusX { along } else { params.parts - 1 - along };
            all.swap_remove(from_entry * params.columns + column)
        }
    };
    electrode.mesh = as_written(&electrode.mesh, &channel.frame);
    Ok(electrode)
}

/// What concerns the feed in a job.
pub(super) fn settings_of<'a>(job: &'a PlanJob, observe: &'a Observe<'a>) -> PlanSettings<'a> {
    PlanSettings {
        plan: &job.plan,
        genetic: &job.genetic,
        machine: &job.machine,
        verify: &job.verify,
        spark_gap: job.electrode.spark_gap_mm,
        explain: true,
        observe,
    }
}

/// The plan whose nodes were kept in a project: joined and verified anew, in a fraction of the time of a search.
///
/// # Errors
/// As [`run`], and if `kept` is none that the job can have had.
pub fn replay(
    inputs: &PlanInputs,
    channel: &Arc<Channel>,
    blisk: &Mesh,
    exact: &ExactMesh,
    kept: &KeptPlan,
    task: &Task,
) -> Result<PlanOutcome, PlanJobError> {
    let job = &inputs.job;
    job.validate()?;
    kept.check(job)?;
    let mut clock = Clock::default();
    let finder = SurfaceFinder::new(channel.clone())?;
    let settings = settings_of(job, &|_, _| ());
    let around = Surroundings { blisk, finder: &finder, frame: channel.frame };
    let mut electrodes = Vec::new();
    for (part, KeptElectrode { side, h, nodes }) in kept.electrodes.iter().enumerate() {
        let make = || electrode_of(inputs, channel, exact, (part, *side, *h), task);
        let electrode = clock.time("electrode", make)?;
        let machine = &job.machine.seen_from_w(*side);
        let settings = PlanSettings { machine, ..settings };
        let plan = replay_feed(&around, &electrode, nodes, *h, &settings, task)?;
        clock.add("certificate", plan.verify_seconds);
        electrodes.push(ElectrodeOutcome { electrode, plan, tried: Vec::new() });
    }
    Ok(PlanOutcome {
        channel: channel.clone(),
        electrodes,
        times: clock.0,
        finishing: OnceLock::new(),
        stock: OnceLock::new(),
    })
}

/// What a project keeps of a plan: none unless every electrode has a certified path.
pub fn kept(outcome: &PlanOutcome) -> Option<Vec<KeptElectrode>> {
    let keep = |e: &ElectrodeOutcome| KeptElectrode {
        side: e.electrode.enters_from,
        h: e.plan.h,
        nodes: e.plan.nodes.clone(),
    };
    outcome.is_verified().then(|| outcome.electrodes.iter().map(keep).collect())
}

/// How good an outcome is: verified, come out, or got so far (mm).
fn rank(outcome: &ElectrodeOutcome) -> (bool, bool, f64) {
    let withdrawn = outcome.plan.nodes.last().map_or(0.0, |n| n.s);
    (outcome.plan.is_verified(), outcome.plan.path.is_some(), withdrawn)
}

/// The sides to try for the part that is number `part` of `parts` along X, the nearer one first.
pub(super) fn sides(enter: EnterSide, part: usize, parts: usize) -> Vec<EntrySide> {
    let mut sides = enter.candidates().to_vec();
    if 2 * part >= parts && part > 0 {
        sides.reverse();
    }
    sides
}

/// The mesh as its file will hold it: single precision in the coordinates of the loaded mesh. What is verified is
/// what is written.
fn as_written(mesh: &Mesh, frame: &Frame) -> Mesh {
    mesh.mapped(|p| frame.from_parent(frame.to_parent(p).as_vec3().as_dvec3()))
}
