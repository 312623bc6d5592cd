//! Takes in what the worker answers.

use std::sync::Arc;
use std::time::Instant;

use super::sentences::{
    channel_sentence, electrode_sentence, export_sentence, finish_sentence, part_sentence, plan_sentence,
};
use super::slot::Slot;
use super::{Event, EventKind, Exported, Finished, Found, PartialPlan, Pipeline, Planned, Running};
use crate::workspaces::blisk::document::kept_plan::KeptPlan;
use crate::workspaces::blisk::document::stage::{Fingerprint, Stage};
use crate::workspaces::blisk::job::stages::{Electrodes, FoundChannel, Part};
use crate::workspaces::worker::{Ended, Message, TaskId};

impl Pipeline {
    pub(super) fn take(&mut self, message: Message<PartialPlan, Found>) -> Option<Event> {
        match message {
            Message::Started(task) => {
                let stage = self.stage_of(task)?;
                let now = Instant::now();
                self.running = Some(Running {
                    stage,
                    doing: stage.name().to_lowercase(),
                    fraction: 0.0,
                    message: String::new(),
                    since: now,
                    doing_since: now,
                });
                None
            }
            Message::Progress { task, stage: doing, fraction, message } => {
                self.stage_of(task)?;
                let running = self.running.as_mut()?;
                if running.doing != doing {
                    running.doing_since = Instant::now();
                }
                (running.doing, running.fraction, running.message) = (doing, fraction, message);
                None
            }
            Message::Partial(task, partial) => {
                self.stage_of(task)?;
                self.partials += 1;
                self.partial = PartialPlan { number: self.partials, ..partial };
                None
            }
            Message::Finished(task, ended) => {
                let stage = self.stage_of(task)?;
                let took = self.running.take_if(|r| r.stage == stage).map(|r| r.since.elapsed());
                let (kind, text) = self.finish(stage, task, ended)?;
                Some(Event { stage, kind, text, took })
            }
        }
    }

    fn stage_of(&self, task: TaskId) -> Option<Stage> {
        let is = |running: Option<(TaskId, Fingerprint)>| running.is_some_and(|(id, _)| id == task);
        if is(self.part.running) {
            Some(Stage::Part)
        } else if is(self.channel.running) {
            Some(Stage::Channel)
        } else if is(self.electrode.running) {
            Some(Stage::Electrode)
        } else if is(self.plan.running) {
            Some(Stage::Plan)
        } else if is(self.finish.running) {
            Some(Stage::Verify)
        } else {
            is(self.export.running).then_some(Stage::Export)
        }
    }

    fn finish(&mut self, stage: Stage, task: TaskId, ended: Ended<Found>) -> Option<(EventKind, String)> {
        match stage {
            Stage::Part => self.part.end(task, ended, Found::part, part_sentence),
            Stage::Channel => self.channel.end(task, ended, Found::channel, channel_sentence),
            Stage::Electrode => self.electrode.end(task, ended, Found::electrode, electrode_sentence),
            Stage::Plan => {
                let before = self.plan().map(Arc::as_ptr);
                let said = self.plan.end(task, ended, Found::plan, plan_sentence);
                // An earlier plan was noted when it was made, and may be of what the files held then.
                if self.plan().map(Arc::as_ptr) != before {
                    self.finish = Slot::default();
                    self.keep_plan();
                }
                said
            }
            Stage::Verify => {
                // What was released had no copying motion.
                self.released = None;
                self.finish.end(task, ended, Found::finish, finish_sentence)
            }
            Stage::Export => self.export.end(task, ended, Found::export, export_sentence),
        }
    }

    fn keep_plan(&mut self) {
        let Some((_, planned)) = &self.plan.value else { return };
        let Some(electrodes) = crate::workspaces::blisk::job::plan::kept(&planned.outcome) else { return };
        let inputs = KeptPlan::inputs_of(&planned.inputs.job, &planned.content);
        self.replayed = Some(inputs.clone());
        self.newly_planned = Some(KeptPlan { inputs, electrodes });
    }
}

impl Found {
    fn part(self) -> Option<Part> {
        if let Self::Part(part) = self { Some(*part) } else { None }
    }

    fn channel(self) -> Option<FoundChannel> {
        if let Self::Channel(channel) = self { Some(*channel) } else { None }
    }

    fn electrode(self) -> Option<Electrodes> {
        if let Self::Electrode(electrodes) = self { Some(electrodes) } else { None }
    }

    fn plan(self) -> Option<Planned> {
        if let Self::Plan(plan) = self { Some(*plan) } else { None }
    }

    fn finish(self) -> Option<Finished> {
        if let Self::Finish(finished) = self { Some(finished) } else { None }
    }

    fn export(self) -> Option<Exported> {
        if let Self::Export(exported) = self { Some(exported) } else { None }
    }
}
