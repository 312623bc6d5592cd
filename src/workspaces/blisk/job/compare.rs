//! Comparison of strategies: one set of electrodes planned by each of them. [`write()`] writes the files.

use std::path::Path;

use super::outcome::{PlanInputs, PlanJobError, PlanOutcome};
use super::plan::run_feeds;
use super::planned::inputs_of;
use super::prepared_blisk::PreparedBlisk;
use super::stages::{FoundChannel, Part};
use crate::workspaces::blisk::document::job_file::field_table::FIELDS;
use crate::workspaces::blisk::document::job_file::{BliskSection, PlanJob};
use crate::workspaces::blisk::document::kept_plan::{KeptPlan, KeptRun};
use crate::workspaces::blisk::export::PlanFilesError;
use crate::workspaces::blisk::report::InputFile;
use crate::workspaces::blisk::report::comparison::{Comparison, Run, RunElectrode, SCHEMA};
use feed::genetic::ReductionMode;
use feed::plan_params::Strategy;
use files::ExportFolder;
use task::{Cancel, Progress, Task};

/// Plans every electrode of the job by each of `strategies` and shows `finished` each run as it ends. Electrodes are
/// those that the job gives: none is drawn in further by the genetic search. A strategy that cannot be followed on this
/// job says why in its run.
///
/// # Errors
/// When told to stop, and the first strategy's own if none can be followed.
pub fn compare(
    prepared: &PreparedBlisk,
    inputs: &PlanInputs,
    strategies: &[Strategy],
    finished: &(dyn Fn(&Run) + Sync),
    task: &Task,
) -> Result<Vec<Run>, PlanJobError> {
    let mut runs = Vec::new();
    let mut first_error = None;
    for &strategy in strategies {
        let inputs = PlanInputs { job: job_for(&inputs.job, strategy), ..inputs.clone() };
        let run = match run_feeds(prepared, &inputs, &named(task, strategy)) {
            Ok(outcome) => run_of(strategy, &outcome),
            Err(PlanJobError::Cancelled(cancelled)) => return Err(cancelled.into()),
            Err(error) => {
                let failure = Some(error.to_string());
                first_error.get_or_insert(error);
                Run { strategy, failure, electrodes: Vec::new() }
            }
        };
        finished(&run);
        runs.push(run);
    }
    match first_error {
        Some(error) if runs.iter().all(|run| run.failure.is_some()) => Err(error),
        _ => Ok(runs),
    }
}

/// The job planned with `strategy`, its circumferential reductions as given.
pub fn job_for(job: &PlanJob, strategy: Strategy) -> PlanJob {
    let mut job = job.clone();
    job.plan.strategy = strategy;
    // Only one strategy searches the reduction, and would then compare another electrode.
    job.genetic.h = ReductionMode::Given;
    job
}

/// `task` with the strategy's name before every message.
fn named(task: &Task, strategy: Strategy) -> Task {
    let progress = task.progress.clone();
    let named = Progress::new(move |update| {
        let message = format!("{}: {}", strategy.name(), update.message);
        progress.report(update.stage, update.fraction, &message);
    });
    Task { progress: named, cancel: task.cancel.clone() }
}

/// The figures of a plan that `strategy` made.
pub fn run_of(strategy: Strategy, outcome: &PlanOutcome) -> Run {
    let electrodes = outcome.electrodes.iter().enumerate();
    let of = |(i, e): (usize, &super::outcome::ElectrodeOutcome)| {
        RunElectrode::of(i + 1, &e.plan, &e.electrode, &outcome.channel)
    };
    Run { strategy, failure: None, electrodes: electrodes.map(of).collect() }
}

/// The figures of a plan that was kept with the parameters `kept.job`: its nodes are joined and verified anew on the
/// part and the channel of `now`.
///
/// # Errors
/// If it is of other meshes or of another channel, is none that its parameters allow, or when told to stop.
pub fn kept_run(
    kept: &KeptRun,
    now: &PlanJob,
    part: &Part,
    found: &FoundChannel,
    task: &Task,
) -> Result<PlanOutcome, PlanJobError> {
    let blisk = |job: &PlanJob| BliskSection { mesh: None, ..job.blisk.clone() };
    if kept.plan.inputs != KeptPlan::inputs_of(&kept.job, &part.content()) || blisk(&kept.job) != blisk(now) {
        return Err(PlanJobError::Job("it is of another part or channel than the present one".to_owned()));
    }
    let inputs = inputs_of(part, &kept.job);
    super::plan::replay(&inputs, &found.channel, &found.blisk, &found.exact, &kept.plan, task)
}

/// The comparison of `runs` of `job`, whose meshes were read from `files`.
pub fn comparison(runs: Vec<Run>, job: &PlanJob, files: Vec<InputFile>) -> Comparison {
    Comparison {
        schema: SCHEMA,
        program_version: env!("CARGO_PKG_VERSION"),
        inputs: files,
        step_mm: job.plan.step_mm,
        parameters: FIELDS.list(&job_for(job, Strategy::default())).without("plan.strategy"),
        runs,
    }
}

/// Writes `comparison.json`, `comparison.csv` and `comparison.html` into `folder`. Returns their names.
///
/// # Errors
/// [`PlanFilesError`] naming what cannot be written; when told to stop, before anything is.
pub fn write(folder: &Path, comparison: &Comparison, cancel: &Cancel) -> Result<Vec<&'static str>, PlanFilesError> {
    let (json, csv, html) = (comparison.json()?, comparison.csv(), comparison.html()?);
    let files = [("comparison.json", json), ("comparison.csv", csv), ("comparison.html", html)];
    cancel.check()?;
    ExportFolder::write_all(folder, "compare", &files.each_ref().map(|(name, text)| (*name, text.as_bytes())))?;
    Ok(files.map(|(name, _)| name).to_vec())
}
