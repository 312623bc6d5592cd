//! Plans that the user keeps beside the present one.

use std::sync::Arc;

use crate::workspaces::blisk::document::Document;
use crate::workspaces::blisk::document::kept_plan::{self, KeptPlan};
use crate::workspaces::blisk::job::compare::{kept_run, run_of};
use crate::workspaces::blisk::job::outcome::PlanOutcome;
use crate::workspaces::blisk::job::plan::kept;
use crate::workspaces::blisk::job::stages::{FoundChannel, Part};
use crate::workspaces::blisk::report::Smoothness;
use crate::workspaces::blisk::report::comparison::{AxisCourse, Run};
use feed::plan_params::Strategy;
use feed::pose::Axis;
use feed::smoothness::axis_smoothness;
use task::{Ended, Lane, Memo, Priority, Refusal, Same, Scheduler, State};

/// Key of a kept run: its number, the digest of its inputs, and the step of its differences (mm).
type Key = (usize, String, f64);

/// The kept runs: content of the document, computed to be shown.
pub struct KeptRuns {
    /// Runs of the document, read once for each change of its kept content.
    runs: Vec<kept_plan::KeptRun>,
    /// Revision of the kept content that the runs were read from.
    read: Option<u64>,
    /// Runs are computed one after the other. A run that failed for another channel may succeed for this one.
    made: Memo<Key, KeptRun>,
    channel: Option<Same<FoundChannel>>,
}

/// A kept run.
pub struct KeptRun {
    /// Number of the run, counted from 1.
    pub number: usize,
    /// Number of the run's colour among those of the theme.
    pub colour: usize,
    /// Figures and curves of the run.
    pub run: Run,
    /// Digests of its paths.
    paths: Vec<String>,
}

impl KeptRun {
    /// The run `of` with `plan`. Differences are taken over steps of `step` (mm), the same for all runs.
    fn new(of: &kept_plan::KeptRun, plan: &PlanOutcome, step: f64) -> Self {
        let mut run = run_of(of.job.plan.strategy, plan);
        for (kept, electrode) in run.electrodes.iter_mut().zip(&plan.electrodes) {
            let Some(planned) = &electrode.plan.path else { continue };
            let figures = Axis::ALL.map(|axis| axis_smoothness(&planned.curves, axis, step));
            kept.smoothness = Smoothness::of(&figures);
        }
        // A file may name any colour.
        let colour = of.colour % kept_plan::KeptRun::MOST;
        Self { number: of.number, colour, run, paths: paths(plan).map(str::to_owned).collect() }
    }

    /// Name of the run: its number and strategy.
    pub fn name(&self) -> String {
        name(self.number, self.run.strategy)
    }

    /// Course of `axis` for electrode number `electrode`, from 0.
    pub fn course(&self, electrode: usize, axis: Axis) -> Option<&AxisCourse> {
        self.run.electrodes.get(electrode)?.course(axis.letter())
    }
}

fn name(number: usize, strategy: Strategy) -> String {
    format!("{number} {}", strategy.name())
}

impl KeptRuns {
    /// An empty set of kept runs.
    pub fn new(scheduler: &Scheduler) -> Self {
        let made = Memo::new(scheduler, Lane::Quick, "Kept runs").remembering(kept_plan::KeptRun::MOST);
        Self { runs: Vec::new(), read: None, made, channel: None }
    }

    /// Kept runs that can be shown, in the order of keeping.
    pub fn all(&self) -> Vec<&KeptRun> {
        self.keyed().filter_map(|(key, _)| Some(&**self.made.get(&key)?)).collect()
    }

    /// Kept runs that cannot be shown: number, name, reason.
    pub fn absent(&self) -> Vec<(usize, String, String)> {
        let reason = |key: &Key| match self.made.state(key) {
            State::Failed(why) => format!("not compared: {why}"),
            _ if self.channel.is_some() => "is being recomputed".to_owned(),
            _ => "waits for part and channel".to_owned(),
        };
        let absent = self.keyed().filter(|(key, _)| self.made.get(key).is_none());
        absent.map(|(key, of)| (of.number, name(of.number, of.job.plan.strategy), reason(&key))).collect()
    }

    /// Whether another run can be kept, and the certified `plan` is not kept already.
    pub fn can_keep(&self, plan: &PlanOutcome) -> bool {
        plan.is_verified()
            && self.runs.len() < kept_plan::KeptRun::MOST
            && !self.all().iter().any(|run| run.paths.iter().map(String::as_str).eq(paths(plan)))
    }

    /// Keeps `plan`, made with the parameters of `document` from meshes with this content. Returns its name; none of a
    /// plan without a path.
    ///
    /// # Errors
    /// One line if there is no room for the plan.
    pub fn keep(
        &mut self,
        plan: &PlanOutcome,
        document: &mut Document,
        content: &str,
    ) -> Result<Option<String>, String> {
        self.read(document);
        let job = document.params().clone();
        let Some(electrodes) = kept(plan) else { return Ok(None) };
        let plan_kept = KeptPlan { inputs: KeptPlan::inputs_of(&job, content), electrodes };
        let number = self.runs.iter().map(|run| run.number).max().unwrap_or(0) + 1;
        let is_free = |colour: &usize| self.runs.iter().all(|run| run.colour != *colour);
        let colour = (0..kept_plan::KeptRun::MOST).find(is_free).unwrap_or(0);
        let of = kept_plan::KeptRun::new(number, colour, job, plan_kept);
        kept_plan::KeptRun::keep(&[&self.runs[..], std::slice::from_ref(&of)].concat(), document)?;
        self.read(document);
        let step = self.step().unwrap_or(of.job.plan.step_mm);
        let run = Arc::new(KeptRun::new(&of, plan, step));
        self.made.put(&key(&of, step), run.clone());
        Ok(Some(run.name()))
    }

    /// Has `document` keep run number `number` no more.
    pub fn remove(&mut self, number: usize, document: &mut Document) {
        self.runs.retain(|run| run.number != number);
        // Fewer are always few enough.
        kept_plan::KeptRun::keep(&self.runs, document).unwrap_or_default();
        self.read(document);
    }

    /// Keeps up with what `document` keeps.
    fn read(&mut self, document: &Document) {
        if self.read != Some(document.kept_revision()) {
            self.runs = kept_plan::KeptRun::all_of(document);
            self.read = Some(document.kept_revision());
        }
    }

    /// Follows `document`: computes the runs of its file once part and channel are there. Returns the reasons why some
    /// are not shown.
    pub fn follow(&mut self, document: &Document, of: Option<(&Arc<Part>, &Arc<FoundChannel>)>) -> Vec<String> {
        self.read(document);
        let mut problems = Vec::new();
        while let Some(Ended { key, result, .. }) = self.made.take() {
            if let Err(Refusal::Failed(why)) = result {
                problems.push(format!("the kept run {} is not shown: {why}", key.0));
            }
        }
        let Some((part, found)) = of.map(|(part, found)| (part.clone(), Same(found.clone()))) else { return problems };
        let keys: Vec<Key> = self.keyed().map(|(key, _)| key).collect();
        if self.channel.as_ref() != Some(&found) {
            keys.iter().for_each(|key| self.made.resume(key));
            self.channel = Some(found.clone());
        }
        if self.made.under_way().is_some_and(|of| keys.contains(of)) {
            return problems;
        }
        let lacking = keys.into_iter().zip(&self.runs).find(|(key, _)| self.made.wants(key));
        let Some((key, of)) = lacking else { return problems };
        let (of, now, step) = (of.clone(), document.params().clone(), key.2);
        self.made.ask(&key, Priority::Background, move |work| {
            let made = kept_run(&of, &now, &part, &found.0, &work.task);
            made.map(|plan| KeptRun::new(&of, &plan, step)).map_err(|e| e.to_string())
        });
        problems
    }

    /// Whether a run is being computed.
    pub fn is_busy(&self) -> bool {
        self.made.is_busy()
    }

    /// Forgets all runs, because another document is open.
    pub fn forget(&mut self) {
        self.made.clear();
        self.runs.clear();
        (self.read, self.channel) = (None, None);
    }

    /// The step that differences of all runs are taken over, that of the first (mm); none without any.
    pub fn step(&self) -> Option<f64> {
        self.runs.first().map(|run| run.job.plan.step_mm)
    }

    /// The runs with their keys.
    fn keyed(&self) -> impl Iterator<Item = (Key, &kept_plan::KeptRun)> {
        let step = self.step().unwrap_or_default();
        self.runs.iter().map(move |run| (key(run, step), run))
    }
}

fn key(run: &kept_plan::KeptRun, step: f64) -> Key {
    (run.number, run.plan.inputs.clone(), step)
}

/// Digests of the paths of `plan`.
fn paths(plan: &PlanOutcome) -> impl Iterator<Item = &str> {
    plan.electrodes.iter().filter_map(|e| Some(e.plan.path.as_ref()?.certificate.path_digest()))
}
