//! From a blisk mesh to verified feed paths of its electrodes.

use std::sync::Arc;
use std::time::Instant;

use super::finish::finish;
use super::outcome::{Clock, ElectrodeOutcome, PlanInputs, PlanJobError, PlanOutcome};
use super::prepared_blisk::{PreparedBlisk, electrode_of};
use super::remedy::RemedySearch;
use super::simulate;
use crate::workspaces::blisk::document::job_file::PlanJob;
use crate::workspaces::blisk::document::kept_plan::{KeptElectrode, KeptPlan};
use feed::jam::Opening;
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
use wheel::centreline::Centreline;
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
    task.check()?;
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
    let mut channel = clock.time("channel", || find_channel(&inputs.blisk, &job.blisk.options, task))?;
    channel.obstacles = inputs.obstacles.clone();
    for number in 0..job.electrode.count() {
        sides(job, &channel, number)?;
    }
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
/// found. The answer is that of [`run`] before it is finished. Told to stop while a change is searched for that makes a jammed
/// electrode feasible, it answers what is known by then: [`PlanOutcome::stopped`].
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
    JobPlanner { inputs, prepared, observe, explain: true, stage: None, task, clock }.outcome()
}

/// Plans as [`run_prepared`] does, without reporting nodes and without finding out which change
/// would open a way where there is none.
///
/// # Errors
/// Every error of [`run_prepared`].
pub fn run_feeds(prepared: &PreparedBlisk, inputs: &PlanInputs, task: &Task) -> Result<PlanOutcome, PlanJobError> {
    let clock = prepared.clock.clone();
    JobPlanner { inputs, prepared, observe: &|_, _, _| (), explain: false, stage: None, task, clock }.outcome()
}

/// Whether electrode number `number` along the passage has a certified path.
///
/// # Errors
/// Every error of [`run_prepared`].
pub(super) fn comes_out(
    prepared: &PreparedBlisk,
    inputs: &PlanInputs,
    number: usize,
    task: &Task,
) -> Result<bool, PlanJobError> {
    let mut planner = JobPlanner {
        inputs,
        prepared,
        observe: &|_, _, _| (),
        explain: false,
        stage: None,
        task,
        clock: Clock::default(),
    };
    Ok(planner.part(number)?.plan.is_verified())
}

struct JobPlanner<'a> {
    inputs: &'a PlanInputs,
    prepared: &'a PreparedBlisk,
    observe: &'a ObservePlan<'a>,
    explain: bool,
    /// Name of the stage whose electrodes are planned as if it were the only one.
    stage: Option<String>,
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
        let mut electrodes = self.electrodes()?;
        let space = &self.prepared.space;
        let mut centreline = None;
        // Trials of sizes and comparisons do not show them.
        if self.explain {
            self.clock.time("distances", || {
                centreline = Centreline::of_channel(&space.channel, &self.task.cancel).ok().map(Arc::new);
                let around = (&*space.channel, &space.finder, centreline.as_deref());
                electrodes.iter_mut().for_each(|e| e.measure(around, self.task));
            });
        }
        let mut outcome = PlanOutcome::new(space.channel.clone(), electrodes, self.clock.0);
        outcome.centreline = centreline;
        Ok(if self.explain { outcome.with_sections(self.inputs, self.task) } else { outcome })
    }

    fn electrodes(&mut self) -> Result<Vec<ElectrodeOutcome>, PlanJobError> {
        let mut electrodes = Vec::new();
        for number in 0..self.inputs.electrodes() {
            electrodes.push(self.part(number)?);
            // Nothing is known of those after the one whose jam was kept.
            if electrodes.last().is_some_and(ElectrodeOutcome::is_stopped) {
                break;
            }
        }
        Ok(electrodes)
    }

    /// The electrode that is number `part`, columns of one part and stages counted through. Tries the sides one after the
    /// other until one is verified; if none is, the one that came out, or else the one that a change makes feasible, or
    /// else the one that got furthest, is the answer. A side for which no electrode can be made is noted and left.
    ///
    /// # Errors
    /// The reasons of all sides if no electrode can be made for any.
    fn part(&mut self, part: usize) -> Result<ElectrodeOutcome, PlanJobError> {
        if !self.inputs.job.electrode.stage.is_empty() {
            let (inputs, in_stage) = self.inputs.of_electrode(part);
            let clock = std::mem::take(&mut self.clock);
            let stage = self.inputs.job.electrode.stage_of(part).map(|stage| stage.name.clone());
            let mut of_stage = JobPlanner { inputs: &inputs, stage, clock, ..*self };
            let outcome = of_stage.part(in_stage);
            self.clock = of_stage.clock;
            return outcome;
        }
        // The best first.
        let mut outcomes: Vec<ElectrodeOutcome> = Vec::new();
        let mut impossible = Vec::new();
        let mut tried = Vec::new();
        let (job, channel) = (&self.inputs.job, &self.prepared.space.channel);
        let left_out = job
            .electrode
            .of_electrode(part)
            .enter
            .candidates(channel)?
            .into_iter()
            .filter(|side| !job.machine.comes_from(*side));
        let along = job.machine.head_along.axis().letter();
        let left_out =
            left_out.map(|side| (side, format!("is not tried: the head of the machine comes along {along}")));
        tried.extend(left_out);
        for side in sides(job, channel, part)? {
            let outcome = match self.on_side(part, side) {
                Ok(outcome) => outcome,
                Err(PlanJobError::Electrode(error)) => {
                    tried.push((side, format!("cannot be made: {error}")));
                    impossible.push((side, error));
                    continue;
                }
                Err(PlanJobError::Cancelled(cancelled)) => {
                    // Where it jams on the side before is known all the same.
                    let jam = outcomes.first_mut().and_then(|best| best.plan.jam.as_mut()).ok_or(cancelled)?;
                    jam.opening.get_or_insert_default().is_stopped = true;
                    break;
                }
                Err(other) => return Err(other),
            };
            let is_best = outcomes.first().is_none_or(|best| rank(best) < rank(&outcome));
            outcomes.insert(if is_best { 0 } else { outcomes.len() }, outcome);
            if outcomes[0].plan.is_verified() {
                break;
            }
        }
        let no_side = ElectrodeError::of_sides(impossible).map_or_else(|| Cancelled.into(), PlanJobError::from);
        let sides: Vec<EntrySide> =
            tried.iter().map(|(side, _)| *side).chain(outcomes.iter().map(|o| o.electrode.enters_from)).collect();
        self.explain_jams(&mut outcomes, part, &sides)?;
        // A remedy is worth more than a longer way to the jam.
        if outcomes.first().is_some_and(|best| best.plan.path.is_none() && !is_opened(best))
            && let Some(opened) = outcomes.iter().position(is_opened)
        {
            outcomes[..=opened].rotate_right(1);
        }
        let mut outcomes = outcomes.into_iter();
        let best = outcomes.next().ok_or(no_side)?;
        tried.extend(outcomes.map(|o| (o.electrode.enters_from, o.plan.verdict(channel))));
        Ok(ElectrodeOutcome { tried, ..best })
    }

    /// Adds to the jams of electrode number `part`, the best first, the changes by which it comes out: to each jam those
    /// that hold for its side of entry. Nothing is looked for where the best comes out. `tried` are the sides that need
    /// not be proposed. A search that is stopped keeps what it has found.
    fn explain_jams(
        &self,
        outcomes: &mut [ElectrodeOutcome],
        part: usize,
        tried: &[EntrySide],
    ) -> Result<(), PlanJobError> {
        let channel = &self.prepared.space.channel;
        let comes_out = outcomes.first().is_none_or(|best| best.plan.path.is_some());
        if comes_out || outcomes.iter().any(ElectrodeOutcome::is_stopped) {
            return Ok(());
        }
        let mut search = RemedySearch::new(self.prepared, self.inputs, part, tried);
        // More reduction of the walls is the least change: it is looked for on every side before any other.
        for looks in [RemedySearch::walls, RemedySearch::others] {
            for outcome in outcomes.iter_mut() {
                let known = outcome.plan.jam.as_ref().map(|jam| jam.place_and_cause(channel));
                let side = outcome.electrode.enters_from;
                let (Some(opening), Some(known)) = (opening_of(outcome), known) else { continue };
                let task = self.task.as_stage_about(Opening::SEARCH, &known);
                match looks(&mut search, opening, side, &task) {
                    Err(PlanJobError::Cancelled(_)) => {
                        outcomes.iter_mut().filter_map(opening_of).for_each(|opening| opening.is_stopped = true);
                        return Ok(());
                    }
                    ended => ended?,
                }
            }
        }
        Ok(())
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
        Ok(ElectrodeOutcome::of(electrode, plan))
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
        let made = electrode_of(self.inputs, &space.channel, exact, (part, side, h), self.task)?;
        Ok(Electrode { stage: self.stage.clone().or(made.stage), ..made })
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
    let is_open = |(part, electrode): (usize, &KeptElectrode)| {
        sides(job, channel, part).map(|open| open.contains(&electrode.side))
    };
    let are_open: Vec<bool> = kept.electrodes.iter().enumerate().map(is_open).collect::<Result<_, _>>()?;
    if are_open.contains(&false) {
        return Err(PlanJobError::Job(
            "the kept plan enters from a side that the passage does not open to, or that the machine's bodies do not come \
             from; plan again"
                .to_owned(),
        ));
    }
    let mut clock = Clock::default();
    let finder = SurfaceFinder::new(channel.clone())?;
    let around = Surroundings { blisk, finder: &finder, frame: channel.frame };
    let centreline = Centreline::of_channel(channel, &task.cancel).ok().map(Arc::new);
    let mut electrodes = Vec::new();
    for (part, KeptElectrode { side, h, nodes }) in kept.electrodes.iter().enumerate() {
        let make = || electrode_of(inputs, channel, exact, (part, *side, *h), task);
        let electrode = clock.time("electrode", make)?;
        let machine = &job.machine.seen_from_w(*side);
        let (of_stage, _) = job.of_electrode(part);
        let settings = PlanSettings { machine, ..settings_of(&of_stage, &|_, _| ()) };
        let plan = replay_feed(&around, &electrode, nodes, *h, &settings, task)?;
        clock.add("certificate", plan.verify_seconds);
        let mut outcome = ElectrodeOutcome::of(electrode, plan);
        outcome.measure((channel, &finder, centreline.as_deref()), task);
        electrodes.push(outcome);
    }
    let mut outcome = PlanOutcome::new(channel.clone(), electrodes, clock.0);
    outcome.centreline = centreline;
    Ok(outcome.with_sections(inputs, task))
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

/// What would make an electrode feasible that jams.
fn opening_of(outcome: &mut ElectrodeOutcome) -> Option<&mut Opening> {
    outcome.plan.jam.as_mut()?.opening.as_mut()
}

/// Whether a change is known that would make an electrode feasible that jams.
fn is_opened(outcome: &ElectrodeOutcome) -> bool {
    let opening = outcome.plan.jam.as_ref().and_then(|jam| jam.opening.as_ref());
    opening.is_some_and(|opening| !opening.changes.is_empty())
}

/// How good an outcome is: verified, come out, or got so far (mm).
fn rank(outcome: &ElectrodeOutcome) -> (bool, bool, f64) {
    let withdrawn = outcome.plan.nodes.last().map_or(0.0, |n| n.s);
    (outcome.plan.is_verified(), outcome.plan.path.is_some(), withdrawn)
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

/// The sides that electrode number `number` may enter from, the one that its part is nearer to first.
///
/// # Errors
/// If the passage opens to none of them, or the machine's bodies stand for heads that come from elsewhere.
pub(super) fn sides(job: &PlanJob, channel: &Channel, number: usize) -> Result<Vec<EntrySide>, PlanJobError> {
    let (stage, in_stage) = job.electrode.in_stage(number);
    let of_stage = job.electrode.of_stage(stage);
    let (part, _) = of_stage.place_of(in_stage);
    let mut sides = of_stage.of_part(part).enter.candidates(channel)?;
    sides.retain(|side| job.machine.comes_from(*side));
    if sides.is_empty() {
        return Err(head_comes_from_elsewhere(job));
    }
    if part > 0 && 2 * part >= of_stage.parts {
        sides.reverse();
    }
    Ok(sides)
}
