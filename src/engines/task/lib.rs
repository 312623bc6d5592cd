//! Long computations: progress, cancelling, and values that are computed in the background and remembered.
//!
//! A job is a pure function of its inputs and a [`Task`], which may be shared between threads. A [`Memo`] runs such
//! jobs on the threads of a [`Scheduler`] and keeps what they answer.

mod doing;
mod memo;
mod scheduler;
mod stage_times;
#[cfg(test)]
mod tests;

use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

pub use doing::Doing;
pub use memo::{Ended, Memo, Refusal, Same, State, Work};
pub use scheduler::{Lane, Priority, Scheduler};
pub use stage_times::{StageClock, StageTime};

/// The result of a computation that was cancelled.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

/// A flag that cancels computations. Every computation of our own looks at the flag at least every 50 ms of work on a
/// part of ordinary size; [`Scheduler`] tells what becomes of one that does not.
#[derive(Debug, Clone, Default)]
pub struct Cancel(Arc<AtomicU8>);

/// The states of a flag after 0: it is up, and a computation has seen it.
const UP: u8 = 1;
const SEEN: u8 = 2;

impl Cancel {
    /// Tells every computation that holds this flag to stop.
    pub fn cancel(&self) {
        let _ = self.0.compare_exchange(0, UP, Ordering::Relaxed, Ordering::Relaxed);
    }

    /// Whether [`cancel`](Self::cancel) has been called.
    pub fn is_cancelled(&self) -> bool {
        match self.0.load(Ordering::Relaxed) {
            0 => false,
            UP => {
                self.0.store(SEEN, Ordering::Relaxed);
                true
            }
            _ => true,
        }
    }

    /// Whether a computation has looked at the flag since it is up, and will stop therefore.
    pub fn is_seen(&self) -> bool {
        self.0.load(Ordering::Relaxed) == SEEN
    }

    /// `Err(Cancelled)` once the flag is up, for use with `?`.
    pub fn check(&self) -> Result<(), Cancelled> {
        if self.is_cancelled() { Err(Cancelled) } else { Ok(()) }
    }
}

/// One report of progress.
#[derive(Debug, Clone, PartialEq)]
pub struct Update<'a> {
    /// Name of the stage, e.g. `"distance field"`.
    pub stage: &'a str,
    /// Share of the stage that is done, 0 to 1.
    pub fraction: f64,
    /// Detail for the reader, may be empty.
    pub message: &'a str,
}

type Sink = dyn Fn(&Update) + Send + Sync;

/// Receiver of the progress of a computation.
#[derive(Clone)]
pub struct Progress(Arc<Sink>);

impl Progress {
    /// Sends every report to `sink`, which may be called from any thread.
    pub fn new(sink: impl Fn(&Update) + Send + Sync + 'static) -> Self {
        Self(Arc::new(sink))
    }

    /// A progress sink for a part of the work, whose stages are all called `stage`.
    pub fn as_stage(&self, stage: &'static str) -> Self {
        let sink = self.0.clone();
        Self::new(move |update| sink(&Update { stage, ..update.clone() }))
    }

    /// A progress sink for a part of the work, whose stages are all called `stage` and whose messages are all `message`.
    fn as_stage_about(&self, stage: &'static str, message: &str) -> Self {
        let (sink, message) = (self.0.clone(), message.to_owned());
        Self::new(move |update| sink(&Update { stage, fraction: update.fraction, message: &message }))
    }

    /// Reports that `fraction` of `stage` is done.
    pub fn report(&self, stage: &str, fraction: f64, message: &str) {
        (self.0)(&Update { stage, fraction: fraction.clamp(0.0, 1.0), message });
    }
}

impl Default for Progress {
    /// Drops every report.
    fn default() -> Self {
        Self::new(|_| {})
    }
}

/// What every job is given: a receiver of progress and a flag that cancels the job. The default reports to nobody and
/// is never cancelled.
#[derive(Clone, Default)]
pub struct Task {
    /// Receiver of the job's progress.
    pub progress: Progress,
    /// Flag that cancels the job.
    pub cancel: Cancel,
}

impl Task {
    /// A task that reports to nobody and stops when `cancel` is raised.
    pub fn silent(cancel: &Cancel) -> Self {
        Self { progress: Progress::default(), cancel: cancel.clone() }
    }

    /// A task for a part of the job, whose stages are all called `stage`.
    pub fn as_stage(&self, stage: &'static str) -> Self {
        Self { progress: self.progress.as_stage(stage), cancel: self.cancel.clone() }
    }

    /// A task for a part of the job that tells `message`, what is known by then, for as long as the part lasts.
    pub fn as_stage_about(&self, stage: &'static str, message: &str) -> Self {
        Self { progress: self.progress.as_stage_about(stage, message), cancel: self.cancel.clone() }
    }

    /// Reports that `fraction` of `stage` is done.
    pub fn report(&self, stage: &str, fraction: f64, message: &str) {
        self.progress.report(stage, fraction, message);
    }

    /// `Err(Cancelled)` once the job is cancelled, for use with `?`.
    pub fn check(&self) -> Result<(), Cancelled> {
        self.cancel.check()
    }
}
