//! Reports of finished work for the log.

use std::time::Duration;

use task::{Ended, Refusal};

/// Outcome of work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EventKind {
    /// Work is done.
    Done,
    /// Work is done; its result is negative, as a failed check.
    Refused,
    /// Work was cancelled.
    Cancelled,
    /// Work could not be done.
    Failed,
}

/// Report of a finished piece of work.
#[derive(Debug, Clone, PartialEq)]
pub struct WorkEvent {
    /// Outcome of the work.
    pub kind: EventKind,
    /// Text of the event, one sentence.
    pub text: String,
    /// Time that the work took.
    pub took: Option<Duration>,
}

impl WorkEvent {
    /// The report on the work called `what`. `sentence` describes a value.
    pub fn of<K, V>(what: &str, ended: Ended<K, V>, sentence: impl FnOnce(&V) -> (EventKind, String)) -> Self {
        let (kind, text) = match &ended.result {
            Ok(value) => sentence(value),
            Err(Refusal::Cancelled) => (EventKind::Cancelled, "cancelled".to_owned()),
            Err(Refusal::Failed(why)) => (EventKind::Failed, why.clone()),
        };
        Self { kind, text: format!("{what}: {text}"), took: (!ended.took.is_zero()).then_some(ended.took) }
    }
}
