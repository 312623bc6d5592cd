//! One result of the work behind a workspace: what it was made from, and what is running.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::blisk::pipeline::{EventKind, StageState};
use super::worker::{Ended, Message, TaskId};

/// What is being worked on.
#[derive(Debug, Clone, PartialEq)]
pub struct Doing {
    /// What it is for.
    pub what: &'static str,
    /// What is being done, in the words of the computation.
    pub stage: String,
    /// How much of that is done, 0 to 1.
    pub fraction: f64,
    /// When it began.
    pub since: Instant,
}

/// Something for the log.
#[derive(Debug, Clone, PartialEq)]
pub struct WorkEvent {
    /// What became of it.
    pub kind: EventKind,
    /// In one sentence.
    pub text: String,
    /// How long it was worked on.
    pub took: Option<Duration>,
}

/// A result with all that tells whether it is that of the present question.
pub(super) struct Kept<K, T> {
    pub value: Option<(K, Arc<T>)>,
    pub failure: Option<(K, String)>,
    pub running: Option<(TaskId, K)>,
    /// What the user has cancelled.
    given_up: Option<TaskId>,
}

impl<K, T> Default for Kept<K, T> {
    fn default() -> Self {
        Self { value: None, failure: None, running: None, given_up: None }
    }
}

impl<K: PartialEq + Clone, T> Kept<K, T> {
    pub fn state(&self, now: &K) -> StageState {
        if self.running.as_ref().is_some_and(|(_, of)| of == now) {
            return StageState::Running;
        }
        // What is known stays known, whatever became of asking it once more.
        if self.is_of(now) {
            return StageState::Done;
        }
        if let Some((_, text)) = self.failure.as_ref().filter(|(of, _)| of == now) {
            return StageState::Failed(text.clone());
        }
        if self.value.is_some() { StageState::Stale } else { StageState::Missing }
    }

    /// Whether the result is that of `now`.
    pub fn is_of(&self, now: &K) -> bool {
        self.value.as_ref().is_some_and(|(of, _)| of == now)
    }

    /// Notes that the user cancels what is waited for.
    pub fn give_up(&mut self) {
        self.given_up = self.running.as_ref().map(|(task, _)| *task);
    }

    /// Whether `task` is what is waited for.
    pub fn awaits(&self, task: TaskId) -> bool {
        self.running.as_ref().is_some_and(|(running, _)| *running == task)
    }

    /// Notes how what was waited for has ended, and says what became of it.
    pub fn end(&mut self, ended: Ended<T>, sentence: impl Fn(&T) -> String) -> Option<(EventKind, String)> {
        let (task, of) = self.running.take()?;
        let is_given_up = self.given_up.take() == Some(task);
        let text = match ended {
            Ended::Done(value) => {
                let said = sentence(&value);
                self.value = Some((of, Arc::new(value)));
                self.failure = None;
                return Some((EventKind::Done, said));
            }
            // The program cancels what nobody asks any more: it may be asked again.
            Ended::Cancelled if !is_given_up => return None,
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

/// Keeps in `doing` what `message` says of the task for `what`. Answers how it has ended, and how long it took.
pub(super) fn note<T>(
    doing: &mut Option<Doing>,
    what: &'static str,
    message: Message<(), T>,
) -> Option<(Ended<T>, Option<Duration>)> {
    match message {
        Message::Started(_) => {
            *doing = Some(Doing { what, stage: String::new(), fraction: 0.0, since: Instant::now() });
            None
        }
        Message::Progress { stage, fraction, .. } => {
            if let Some(doing) = doing {
                (doing.stage, doing.fraction) = (stage, fraction);
            }
            None
        }
        Message::Partial(..) => None,
        Message::Finished(_, ended) => Some((ended, doing.take_if(|d| d.what == what).map(|d| d.since.elapsed()))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ended(kept: &mut Kept<u32, u32>, of: u32, ended: Ended<u32>) -> Option<(EventKind, String)> {
        kept.running.get_or_insert((1, of));
        kept.end(ended, |value| value.to_string())
    }

    #[test]
    fn only_what_the_user_cancels_is_not_asked_again() {
        let mut kept = Kept::default();
        assert_eq!(ended(&mut kept, 7, Ended::Cancelled), None);
        assert_eq!(kept.state(&7), StageState::Missing);
        kept.running = Some((1, 7));
        kept.give_up();
        let (kind, _) = ended(&mut kept, 7, Ended::Cancelled).unwrap();
        assert_eq!((kind, kept.state(&7)), (EventKind::Cancelled, StageState::Failed("cancelled".to_owned())));
        // It was another task that the user has cancelled.
        kept.running = Some((1, 8));
        kept.give_up();
        kept.running = Some((2, 9));
        assert_eq!((ended(&mut kept, 9, Ended::Cancelled), kept.state(&9)), (None, StageState::Missing));
    }

    #[test]
    fn what_is_known_stays_known() {
        let mut kept = Kept::default();
        ended(&mut kept, 7, Ended::Done(1)).unwrap();
        ended(&mut kept, 7, Ended::Failed("no room".to_owned())).unwrap();
        assert_eq!((kept.state(&7), kept.state(&8)), (StageState::Done, StageState::Stale));
    }
}
