//! Keeps up with the document: what changed, what has to be made anew, what is taken up again.

use super::{Event, EventKind, Finished, Found, Now, PartialPlan, Pipeline, Planned};
use crate::workspaces::blisk::document::Document;
use crate::workspaces::blisk::document::job_file::PlanJob;
use crate::workspaces::blisk::document::kept_plan::KeptPlan;
use crate::workspaces::blisk::document::stage::{Fingerprint, Stage};
use crate::workspaces::blisk::job::finish::finish;
use crate::workspaces::blisk::job::plan::PlanInputs;
use crate::workspaces::blisk::job::stages;
use crate::workspaces::blisk::job::stages::Part;
use crate::workspaces::worker::Reporter;
use task::Task;

impl Pipeline {
    /// Takes in what the worker has said, and starts what `document` needs. Answers what has happened.
    pub fn follow(&mut self, document: &mut Document) -> Vec<Event> {
        let messages = self.worker.messages();
        let mut events: Vec<Event> = messages.into_iter().filter_map(|m| self.take(m)).collect();
        if let Some(part) = self.part.value.as_ref().map(|(_, part)| part.clone())
            && let [blisk, ..] = &part.files[..]
            && !blisk.sha256.is_empty()
        {
            for file in &part.files {
                document.note_file(file.path.as_ref(), &file.sha256);
            }
        }
        let now = self.refresh(document.params());
        if self.released.is_some() && self.released().is_none() {
            self.withdraw();
            let text = "release withdrawn: an input changed".to_owned();
            events.push(Event { stage: Stage::Export, kind: EventKind::Cancelled, text, took: None });
        }
        // A plan for other parameters is of no use to anybody.
        if self.plan.running.is_some_and(|(_, made_from)| made_from != now.plan) {
            self.worker.cancel_from(Stage::Plan as u32);
            // A kept plan is taken up again once its parameters are there again.
            self.replayed = None;
        }
        if self.finish.running.is_some_and(|(_, made_from)| made_from != now.plan) {
            self.worker.cancel_from(Stage::Verify as u32);
        }
        self.start_early_stages(document.params(), now);
        events.extend(self.replay_kept_plan(document, now));
        self.start_finish(now);
        if let Some(plan) = self.newly_planned.take() {
            plan.note(document);
        }
        events
    }

    /// What the files held, and how often they were read.
    pub(super) fn content(&self) -> String {
        let content = self.part.value.as_ref().map(|(_, p)| p.content()).unwrap_or_default();
        format!("{content}/{}", self.reloads)
    }

    fn refresh(&mut self, job: &PlanJob) -> Now {
        let of = |stage, content: &str| Fingerprint::of(stage, job, content);
        let later = self.content();
        let now = Now {
            part: of(Stage::Part, &self.reloads.to_string()),
            channel: of(Stage::Channel, &later),
            electrode: of(Stage::Electrode, &later),
            plan: of(Stage::Plan, &later),
            export: of(Stage::Export, &later),
        };
        self.now = Some((job.clone(), now));
        now
    }

    fn start_early_stages(&mut self, job: &PlanJob, now: Now) {
        let job = job.clone();
        if self.part.wants_work(now.part) {
            let given = self.given.take();
            let work = move |_: &Reporter<_, _>, task: &Task| {
                let part = given.map_or_else(|| stages::load(&job, task), |part| Ok(Part::clone(&part)));
                part.map(|part| Found::Part(Box::new(part)))
            };
            let id = self.worker.submit(Stage::Part as u32, work);
            self.part.running = Some((id, now.part));
            return;
        }
        let Some(part) = self.part.current(now.part).cloned() else { return };
        if self.channel.wants_work(now.channel) {
            let work = move |_: &Reporter<_, _>, task: &Task| {
                stages::channel(&part, &job, task).map(|found| Found::Channel(Box::new(found)))
            };
            let id = self.worker.submit(Stage::Channel as u32, work);
            self.channel.running = Some((id, now.channel));
            return;
        }
        let Some(channel) = self.channel.current(now.channel).cloned() else { return };
        if self.electrode.wants_work(now.electrode) {
            let work = move |_: &Reporter<_, _>, task: &Task| {
                stages::electrodes(&part, &channel, &job, task).map(Found::Electrode)
            };
            let id = self.worker.submit(Stage::Electrode as u32, work);
            self.electrode.running = Some((id, now.electrode));
        }
    }

    /// Works out the copying motions of a certified plan, and what stock is left, unless that was done or stopped.
    fn start_finish(&mut self, now: Now) {
        let (Some(found), Some(planned)) = (self.channel.current(now.channel), self.plan.current(now.plan)) else {
            return;
        };
        if self.plan.running.is_some() || !planned.outcome.is_verified() || !self.finish.wants_work(now.plan) {
            return;
        }
        let (found, planned) = (found.clone(), planned.clone());
        let work = move |_: &Reporter<PartialPlan, Found>, task: &Task| {
            let finishing = finish(&planned.outcome, &planned.inputs, &found.blisk, task).map_err(|e| e.to_string())?;
            Ok(Found::Finish(Finished::new(finishing, &planned.outcome.channel)))
        };
        let id = self.worker.submit(Stage::Verify as u32, work);
        self.finish.running = Some((id, now.plan));
    }

    /// Takes up the plan that the document came with, if it is for its present parameters; says so once if it is not.
    fn replay_kept_plan(&mut self, document: &Document, now: Now) -> Option<Event> {
        if self.plan.value.is_some() || self.plan.running.is_some() {
            return None;
        }
        let kept = KeptPlan::of(document)?;
        let (part, found) = (self.part.current(now.part)?, self.channel.current(now.channel)?);
        // A file may say anything: as many electrodes as there are parts, or none of it counts.
        let parts = self.electrode.current(now.electrode).map(|made| made.electrodes.len());
        if parts.is_none() || self.replayed.as_deref() == Some(&kept.inputs) {
            return None;
        }
        if parts != Some(kept.electrodes.len())
            || kept.inputs != KeptPlan::inputs_of(document.params(), &part.content())
        {
            let is_news = self.passed_over.replace(kept.inputs.clone()).as_ref() != Some(&kept.inputs);
            let text = "the plan in this project is out of date; plan again".to_owned();
            return is_news.then_some(Event { stage: Stage::Plan, kind: EventKind::Cancelled, text, took: None });
        }
        self.replayed = Some(kept.inputs.clone());
        let (part, found, kept, job) = (part.clone(), found.clone(), kept.clone(), document.params().clone());
        let work = move |_: &Reporter<PartialPlan, Found>, task: &Task| {
            let inputs = PlanInputs { blisk: part.mesh.clone(), own_electrode: part.own_electrode.clone(), job };
            let outcome = crate::workspaces::blisk::job::plan::replay(
                &inputs,
                &found.channel,
                &found.blisk,
                &found.exact,
                &kept,
                task,
            );
            outcome.map(|o| Found::Plan(Box::new(Planned::new(inputs, part.content(), o)))).map_err(|e| e.to_string())
        };
        let id = self.worker.submit(Stage::Plan as u32, work);
        self.plan.running = Some((id, now.plan));
        None
    }
}
