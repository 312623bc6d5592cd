//! One step of the work: its result, the fingerprint of what that was made from, and what is running.

use std::sync::Arc;

use super::{EventKind, Found};
use crate::workspaces::blisk::document::stage::Fingerprint;
use crate::workspaces::worker::{Ended, TaskId};

/// How a step stands.
#[derive(Debug, Clone, PartialEq)]
pub enum StageState {
    /// Nothing has been done.
    Missing,
    /// It is being worked on.
    Running,
    /// Its result is that of the present parameters.
    Done,
    /// Its result is that of other parameters.
    Stale,
    /// It could not be done with the present parameters: one line why.
    Failed(String),
}

/// One step's result and state.
pub(super) struct Slot<T> {
    pub(super) value: Option<(Fingerprint, Arc<T>)>,
    pub(super) failure: Option<(Fingerprint, String)>,
    pub(super) running: Option<(TaskId, Fingerprint)>,
}

impl<T> Default for Slot<T> {
    fn default() -> Self {
        Self { value: None, failure: None, running: None }
    }
}

impl<T> Slot<T> {
    pub(super) fn current(&self, now: Fingerprint) -> Option<&Arc<T>> {
        self.value.as_ref().filter(|(made_from, _)| *made_from == now).map(|(_, value)| value)
    }

    pub(super) fn state(&self, now: Fingerprint) -> StageState {
        if self.running.is_some_and(|(_, made_from)| made_from == now) {
            return StageState::Running;
        }
        if let Some((_, text)) = self.failure.as_ref().filter(|(made_from, _)| *made_from == now) {
            return StageState::Failed(text.clone());
        }
        match &self.value {
            None => StageState::Missing,
            Some((made_from, _)) if *made_from == now => StageState::Done,
            Some(_) => StageState::Stale,
        }
    }

    /// Whether nothing is known of, and nobody works on, what belongs to `now`.
    pub(super) fn wants_work(&self, now: Fingerprint) -> bool {
        matches!(self.state(now), StageState::Missing | StageState::Stale)
    }

    /// Notes the end of `task` if it is the one this step waits for, and says what became of it.
    pub(super) fn end(
        &mut self,
        task: TaskId,
        ended: Ended<Found>,
        mine: fn(Found) -> Option<T>,
        sentence: fn(&T) -> (EventKind, String),
    ) -> Option<(EventKind, String)> {
        let (_, made_from) = self.running.take_if(|(running, _)| *running == task)?;
        let text = match ended {
            Ended::Done(found) => match mine(found) {
                Some(value) => {
                    let said = sentence(&value);
                    self.value = Some((made_from, Arc::new(value)));
                    self.failure = None;
                    return Some(said);
                }
                None => "internal error: a step answered with another step's result".to_owned(),
            },
            Ended::Cancelled => return Some((EventKind::Cancelled, "cancelled".to_owned())),
            Ended::Failed(text) | Ended::Panicked(text) => text,
        };
        self.failure = Some((made_from, text.clone()));
        Some((EventKind::Failed, text))
    }

    /// Takes being cancelled for an answer, where the step would otherwise begin again by itself.
    pub(super) fn rest(&mut self, made_from: Option<Fingerprint>) {
        if let Some(made_from) = made_from {
            self.failure = Some((made_from, "cancelled; load the part again to go on".to_owned()));
        }
    }
}
