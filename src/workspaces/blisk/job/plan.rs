//! From a blisk mesh to verified feed paths of its electrodes.

use std::sync::Arc;
use std::time::Instant;

use super::finish::finish;
use super::outcome::{Clock, ElectrodeOutcome, PlanInputs, PlanJobError, PlanOutcome};
use super::prepared_blisk::{PreparedBlisk, electrode_of};
use super::simulate;
use crate::workspaces::blisk::document::job_file::PlanJob;
use crate::workspaces::blisk::document::kept_plan::{KeptElectrode, KeptPlan};
use feed::machine::HeadAxis;
use feed::plan::{FeedPlan, PlanSettings};
use feed::plan_params::Strategy;
use feed::planner::{DrawnIn, plan_drawn_in, plan_feed};
use feed::problem::Observe;
use feed::problem::{Convergence, Node};
use feed::replay::{Surroundings, replay_feed};
use files::Validate as _;
use geometry::exact::ExactMesh;
use geometry::mesh::Mesh;
use task::{Cancelled, Task};
use wheel::channel::Channel;
use wheel::electrode::{Electrode, ElectrodeError, EntrySide, Sizing};
use wheel::find_channel::find_channel;
use wheel::surface_finder::SurfaceFinder;

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
/// Every error of [`run`].
pub fn run_finished(prepared: &PreparedBlisk, inputs: &PlanInputs, task: &Task) -> Result<PlanOutcome, PlanJobError> {
    let outcome = run_prepared(prepared, inputs, &|_, _, _| (), task)?;
    finish(&outcome, inputs, &prepared.space.blisk, task)?;
    Ok(outcome)
}

/// Makes the blisk of a job ready for planning.
///
/// # Errors
/// If the machine or its bodies cannot be read, if there is no channel, or one that is too large or not all that are to
/// be burnt, or when told to stop.
pub fn prepare(inputs: &PlanInputs, task: &Task) -> Result<PreparedBlisk, PlanJobError> {
    let job = &inputs.job;
    job.validate()?;
    let mut clock = Clock::default();
    simulate::check_machine(job, task)?;
    let channel = clock.time("channel", || find_channel(&inputs.blisk, &job.blisk.options, task))?;
    sides_of(job, &channel)?;
    simulate::check_channels(job, &channel)?;
    let blisk = Arc::new(channel.wheel_in_w(&inputs.blisk));
    let exact = clock.time("exact mesh", || channel.exact(&blisk))?;
    let cell = job.plan.field_cell_mm;
    let mut prepared = PreparedBlisk::new(blisk, exact.into(), channel.into(), cell, task)?;
    clock.0.append(&mut prepared.clock.0);
    prepared.clock = clock;
    Ok(prepared)
}

/// Looks at a plan while it is made: at the electrode that a way is searched for, and at what was found; see
/// [`Observe`].
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
/// Every error of [`run_prepared`].
pub fn run_feeds(prepared: &PreparedBlisk, inputs: &PlanInputs, task: &Task) -> Result<PlanOutcome, PlanJobError> {
    let clock = prepared.clock.clone();
    JobPlanner { inputs, prepared, observe: &|_, _, _| (), explain: false, task, clock }.outcome()
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
            let todo = "electrode.size is \"auto\": find the sizes first and take one, or give the reductions";
            return Err(PlanJobError::Job(todo.to_owned()));
        }
        let electrodes = self.electrodes()?;
        let channel = self.prepared.space.channel.clone();
        Ok(PlanOutcome::new(channel, electrodes, self.clock.0))
    }

    fn electrodes(&mut self) -> Result<Vec<ElectrodeOutcome>, PlanJobError> {
        (0..self.parts()).map(|part| self.part(part)).collect()
    }

    fn parts(&self) -> usize {
        if self.inputs.own_electrode.is_some() { 1 } else { self.inputs.job.electrode.count() }
    }

    /// The electrode that is number `part` along the passage, columns of one part counted through. Tries the sides one after the
    /// other until one is verified; if none is, the one that came out, or else the one that got furthest, is the
    /// answer. A side for which no electrode can be made is noted and left.
    ///
    /// # Errors
    /// The error of the first side if no electrode can be made for any side.
    fn part(&mut self, part: usize) -> Result<ElectrodeOutcome, PlanJobError> {
        let mut best: Option<ElectrodeOutcome> = None;
        let mut impossible: Option<ElectrodeError> = None;
        let mut tried = Vec::new();
        let (job, channel) = (&self.inputs.job, &self.prepared.space.channel);
        let left_out =
            job.electrode.enter.candidates(channel)?.into_iter().filter(|side| !job.machine.comes_from(*side));
        let along = job.machine.head_along.axis().letter();
        let left_out =
            left_out.map(|side| (side, format!("is not tried: the head of the machine comes along {along}")));
        tried.extend(left_out);
        let params = &self.inputs.job.electrode;
        let columns = if self.inputs.own_electrode.is_some() { 1 } else { params.columns };
        for side in sides(&self.inputs.job, &self.prepared.space.channel, part / columns, self.parts() / columns)? {
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
/// Every error of [`run`], and if `kept` is none that the job can have had.
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
    let open = sides_of(job, channel)?;
    if kept.electrodes.iter().any(|electrode| !open.contains(&electrode.side)) {
        return Err(PlanJobError::Job(
            "the kept plan enters from a side that the passage does not open to, or that the machine's bodies do not come \
             from; plan again"
                .to_owned(),
        ));
    }
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
    Ok(PlanOutcome::new(channel.clone(), electrodes, clock.0))
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

/// The sides that an electrode of `channel` may enter from, in the order in which they are tried.
///
/// # Errors
/// If the passage opens to none of them, or the machine's bodies stand for heads that come from elsewhere.
pub(super) fn sides_of(job: &PlanJob, channel: &Channel) -> Result<Vec<EntrySide>, PlanJobError> {
    let mut sides = job.electrode.enter.candidates(channel)?;
    sides.retain(|side| job.machine.comes_from(*side));
    if sides.is_empty() { Err(head_comes_from_elsewhere(job)) } else { Ok(sides) }
}

/// The refusal of electrodes that enter from where the head of the machine does not come from.
pub(super) fn head_comes_from_elsewhere(job: &PlanJob) -> PlanJobError {
    let (left, other, example) = match job.machine.head_along {
        HeadAxis::X => ("the only side of entry that is left is the rim", "Z", "xyzac-ram"),
        HeadAxis::Z => ("the sides of entry that are left are along X", "X", "xyzac"),
    };
    PlanJobError::Job(format!(
        "machine.name: the head of {} comes along {}, and {left}; choose a machine whose head comes along {other}, as that \
         of {example} does, another side of entry, or no bodies, and watch head and table yourself",
        job.machine.name,
        job.machine.head_along.axis().letter()
    ))
}

/// The sides to try for the part that is number `part` of `parts` along the passage, the nearer one first.
///
/// # Errors
/// Every error of [`sides_of`].
pub(super) fn sides(
    job: &PlanJob,
    channel: &Channel,
    part: usize,
    parts: usize,
) -> Result<Vec<EntrySide>, PlanJobError> {
    Ok(nearer_first(sides_of(job, channel)?, part, parts))
}

/// `sides`, those at the first station first, in the order in which they are near to part `part` of `parts`.
pub(super) fn nearer_first(mut sides: Vec<EntrySide>, part: usize, parts: usize) -> Vec<EntrySide> {
    if 2 * part >= parts && part > 0 {
        sides.reverse();
    }
    sides
}
