//! One result of the work on a mold: what it was made from, and what is running.

use std::sync::Arc;

use crate::jobs::pipeline::{EventKind, StageState};
use crate::jobs::worker::{Ended, TaskId};

/// A result with all that tells whether it is that of the present question.
pub(super) struct Kept<K, T> {
    pub value: Option<(K, Arc<T>)>,
    pub failure: Option<(K, String)>,
    pub running: Option<(TaskId, K)>,
}

impl<K, T> Default for Kept<K, T> {
    fn default() -> Self {
        Self { value: None, failure: None, running: None }
    }
}

impl<K: PartialEq + Clone, T> Kept<K, T> {
    pub fn state(&self, now: &K) -> StageState {
        if self.running.as_ref().is_some_and(|(_, of)| of == now) {
            return StageState::Running;
        }
        if let Some((_, text)) = self.failure.as_ref().filter(|(of, _)| of == now) {
            return StageState::Failed(text.clone());
        }
        match &self.value {
            None => StageState::Missing,
            Some((of, _)) if of == now => StageState::Done,
            Some(_) => StageState::Stale,
        }
    }

    /// Whether `task` is what is waited for.
    pub fn is_of(&self, task: TaskId) -> bool {
        self.running.as_ref().is_some_and(|(running, _)| *running == task)
    }

    /// Notes how what was waited for has ended, and says what became of it.
    pub fn end(&mut self, ended: Ended<T>, sentence: impl Fn(&T) -> String) -> Option<(EventKind, String)> {
        let (_, of) = self.running.take()?;
        let text = match ended {
            Ended::Done(value) => {
                let said = sentence(&value);
                self.value = Some((of, Arc::new(value)));
                self.failure = None;
                return Some((EventKind::Done, said));
            }
            Ended::Cancelled => {
                // What would begin again by itself takes being cancelled for an answer.
                self.failure = Some((of, "cancelled".to_owned()));
                return Some((EventKind::Cancelled, "cancelled".to_owned()));
            }
            Ended::Failed(text) | Ended::Panicked(text) => text,
        };
        self.failure = Some((of, text.clone()));
        Some((EventKind::Failed, text))
    }
}
