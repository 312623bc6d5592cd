//! Undo and redo over whole sets of parameters: a job is a few hundred bytes, so a step keeps all of it.

use super::job_file::PlanJob;

/// Most steps that are kept.
const DEPTH: usize = 500;

/// One step: what was done, and the parameters on the other side of it.
#[derive(Debug, Clone, PartialEq)]
struct Step {
    label: String,
    job: PlanJob,
}

/// The steps that can be undone and done again.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct History {
    past: Vec<Step>,
    future: Vec<Step>,
    /// The gesture whose changes make one step: a slider being dragged, a number being typed.
    gesture: Option<u64>,
}

impl History {
    /// Notes that `before` is about to be changed. Changes of the same `gesture` make one step.
    pub(super) fn record(&mut self, label: &str, before: &PlanJob, gesture: Option<u64>) {
        let continued = gesture.is_some() && gesture == self.gesture && !self.past.is_empty();
        self.gesture = gesture;
        self.future.clear();
        if continued {
            return;
        }
        self.past.push(Step { label: label.to_owned(), job: before.clone() });
        if self.past.len() > DEPTH {
            self.past.remove(0);
        }
    }

    /// The parameters before the last step, if there is one.
    pub(super) fn undo(&mut self, now: &PlanJob) -> Option<PlanJob> {
        let step = self.past.pop()?;
        self.gesture = None;
        self.future.push(Step { label: step.label, job: now.clone() });
        Some(step.job)
    }

    /// The parameters after the step that was undone last, if there is one.
    pub(super) fn redo(&mut self, now: &PlanJob) -> Option<PlanJob> {
        let step = self.future.pop()?;
        self.gesture = None;
        self.past.push(Step { label: step.label, job: now.clone() });
        Some(step.job)
    }

    /// What undo would take back.
    pub(super) fn undo_label(&self) -> Option<&str> {
        self.past.last().map(|s| s.label.as_str())
    }

    /// What redo would do again.
    pub(super) fn redo_label(&self) -> Option<&str> {
        self.future.last().map(|s| s.label.as_str())
    }
}
