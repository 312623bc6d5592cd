//! What the works behind the workspaces have to say.

use std::time::Duration;

use task::{Ended, Refusal};

/// What became of work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EventKind {
    /// Work is done.
    Done,
    /// Work is done, and the answer is no.
    Refused,
    /// Work was cancelled.
    Cancelled,
    /// Work could not be done.
    Failed,
}

/// Something for the log.
#[derive(Debug, Clone, PartialEq)]
pub struct WorkEvent {
    /// What became of it.
    pub kind: EventKind,
    /// Text of the event, one sentence.
    pub text: String,
    /// How long it was worked on.
    pub took: Option<Duration>,
}

impl WorkEvent {
    /// What became of work for `what`. `sentence` says what came out.
    pub fn of<K, V>(what: &str, ended: Ended<K, V>, sentence: impl FnOnce(&V) -> (EventKind, String)) -> Self {
        let (kind, text) = match &ended.result {
            Ok(value) => sentence(value),
            Err(Refusal::Cancelled) => (EventKind::Cancelled, "cancelled".to_owned()),
            Err(Refusal::Failed(why)) => (EventKind::Failed, why.clone()),
        };
        Self { kind, text: format!("{what}: {text}"), took: (!ended.took.is_zero()).then_some(ended.took) }
    }
}
