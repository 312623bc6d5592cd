//! From a blisk mesh to verified feed paths of its electrodes.

use std::sync::Arc;
use std::time::Instant;

use crate::blisk::channel::Channel;
use crate::blisk::electrode::{
    Electrode, ElectrodeError, ElectrodeParams, EnterSide, EntrySide, from_user_mesh, make_electrodes,
};
use crate::blisk::error::BliskError;
use crate::blisk::find_channel::find_channel;
use crate::export::report::StageTime;
use crate::feed::plan::{FeedPlan, PlanSettings, PlanningSpace, plan_feed};
use crate::feed::plan_params::PlanError;
use crate::geometry::exact::{ExactMesh, ExactMeshError};
use crate::geometry::frame::Frame;
use crate::geometry::mesh::Mesh;
use crate::progress::{Cancel, Cancelled, Progress};
use crate::project::PlanJob;

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
    /// Its plan.
    pub plan: FeedPlan,
    /// Sides that were tried before, and why they were left.
    pub tried: Vec<(EntrySide, String)>,
}

/// The answer of a plan.
#[derive(Debug, Clone)]
pub struct PlanOutcome {
    /// The channel.
    pub channel: Channel,
    /// The electrodes in the order of their parts.
    pub electrodes: Vec<ElectrodeOutcome>,
    /// Times of the stages in order.
    pub times: Vec<StageTime>,
}

impl PlanOutcome {
    /// Whether every electrode has a verified path.
    pub fn is_verified(&self) -> bool {
        !self.electrodes.is_empty() && self.electrodes.iter().all(|e| e.plan.is_verified())
    }
}

/// Why a plan cannot be made. That there is no path is not an error but an answer.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum PlanJobError {
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    #[error(transparent)]
    Blisk(BliskError),
    #[error(transparent)]
    Electrode(ElectrodeError),
    #[error(transparent)]
    Plan(PlanError),
    #[error(transparent)]
    Mesh(#[from] ExactMeshError),
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

/// Plans every electrode of the job.
pub fn run(inputs: &PlanInputs, progress: &Progress, cancel: &Cancel) -> Result<PlanOutcome, PlanJobError> {
    let job = &inputs.job;
    let mut clock = Clock::default();
    let channel = clock.time("channel", || find_channel(&inputs.blisk, &job.blisk.options, progress, cancel))?;
    let blisk = inputs.blisk.in_frame(&channel.frame);
    let exact = clock.time("exact mesh", || ExactMesh::new(&blisk))?;
    let cell = job.plan.field_cell_mm;
    job.plan.validate()?;
    let space =
        clock.time("distance field", || PlanningSpace::new(&blisk, &exact, &channel, cell, progress, cancel))?;
    let mut planner = JobPlanner { inputs, space: &space, exact: &exact, progress, cancel, clock };
    let electrodes = planner.electrodes()?;
    let times = planner.clock.0;
    Ok(PlanOutcome { channel, electrodes, times })
}

/// Adds up the times of stages by name.
#[derive(Default)]
struct Clock(Vec<StageTime>);

impl Clock {
    fn time<T>(&mut self, stage: &str, work: impl FnOnce() -> T) -> T {
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
    space: &'a PlanningSpace<'a>,
    exact: &'a ExactMesh,
    progress: &'a Progress,
    cancel: &'a Cancel,
    clock: Clock,
}

impl JobPlanner<'_> {
    fn electrodes(&mut self) -> Result<Vec<ElectrodeOutcome>, PlanJobError> {
        (0..self.parts()).map(|part| self.part(part)).collect()
    }

    fn parts(&self) -> usize {
        if self.inputs.own_electrode.is_some() { 1 } else { self.inputs.job.electrode.parts }
    }

    /// The part that is number `part` along X. Tries the sides one after the other until one is verified; if none is, the
    /// one that came out, or else the one that got furthest, is the answer. A side for which no electrode can be made is
    /// noted and left.
    ///
    /// # Errors
    /// That of the first side if no electrode can be made for any.
    fn part(&mut self, part: usize) -> Result<ElectrodeOutcome, PlanJobError> {
        let mut best: Option<ElectrodeOutcome> = None;
        let mut impossible: Option<ElectrodeError> = None;
        let mut tried = Vec::new();
        for side in sides(self.inputs.job.electrode.enter, part, self.parts()) {
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
            tried.extend(worse.map(|o| (o.electrode.enters_from, o.plan.verdict(self.space.channel))));
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
        let job = &self.inputs.job;
        let started = Instant::now();
        let electrode = self.electrode(part, side, 0.0)?;
        self.clock.add("electrode", started.elapsed().as_secs_f64());
        let settings = PlanSettings {
            plan: &job.plan,
            genetic: &job.genetic,
            machine: &job.machine,
            verify: &job.verify,
            spark_gap: job.electrode.spark_gap_mm,
        };
        let remake = |h: f64| self.electrode(part, side, h);
        let mut plan = plan_feed(self.space, &electrode, &settings, &remake, self.progress, self.cancel)?;
        self.clock.add("electrode field", plan.field_seconds);
        self.clock.add("search", plan.search_seconds);
        self.clock.add("certificate", plan.verify_seconds);
        let electrode = plan.remade.take().map_or(electrode, |remade| *remade);
        Ok(ElectrodeOutcome { electrode, plan, tried: Vec::new() })
    }

    /// The electrode with its walls drawn in by a further `h` (rad), its vertices as a file will hold them.
    fn electrode(&self, part: usize, side: EntrySide, h: f64) -> Result<Electrode, ElectrodeError> {
        let params = &self.inputs.job.electrode;
        let channel = self.space.channel;
        let mut electrode = match &self.inputs.own_electrode {
            Some(own) => {
                let own = own.in_frame(&channel.frame);
                from_user_mesh(own, channel, self.exact, params.spark_gap_mm, side, self.cancel)?
            }
            None => {
                let [low, high] = params.circumferential_reduction_deg;
                let circumferential_reduction_deg = [low + h.to_degrees(), high + h.to_degrees()];
                let params = ElectrodeParams { circumferential_reduction_deg, ..params.clone() };
                let mut all = make_electrodes(channel, self.exact, &params, side, self.progress, self.cancel)?;
                // Electrodes are counted from the side of entry.
                all.swap_remove(if side == EntrySide::MinusX { part } else { params.parts - 1 - part })
            }
        };
        electrode.mesh = as_written(&electrode.mesh, &channel.frame);
        Ok(electrode)
    }
}

/// How good an outcome is: verified, come out, or got so far (mm).
fn rank(outcome: &ElectrodeOutcome) -> (bool, bool, f64) {
    let withdrawn = outcome.plan.nodes.last().map_or(0.0, |n| n.s);
    (outcome.plan.is_verified(), outcome.plan.path.is_some(), withdrawn)
}

/// The sides to try for the part that is number `part` of `parts` along X, the nearer one first.
fn sides(enter: EnterSide, part: usize, parts: usize) -> Vec<EntrySide> {
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
