//! Documents that are read in the background, before they take the place of what is open.

use std::sync::Arc;

use task::{Doing, Lane, Memo, Priority, Refusal, Scheduler, Task};

use super::commands::{Command, CommandSet, FrameCommand};
use super::context::{Context, Request};
use super::news::EventKind;

/// The replacement of a workspace's document: a `P` that waits until unsaved work is dealt with, and a `T` that is
/// being read with its part. A part that cannot be read replaces nothing.
pub struct Opening<P, T> {
    /// Replacement of the document, done once unsaved work is dealt with.
    pub pending: Option<P>,
    memo: Memo<u64, T>,
    /// Number of documents opened so far.
    number: u64,
}

impl<P, T: Send + Sync + 'static> Opening<P, T> {
    /// An idle reader: no document is being read.
    pub fn new(scheduler: &Scheduler) -> Self {
        Self { pending: None, memo: Memo::new(scheduler, Lane::Quick, "Open").remembering(1), number: 0 }
    }

    /// Reads a document and drops the one being read.
    pub fn begin(&mut self, read: impl FnOnce(&Task) -> Result<T, String> + Send + 'static) {
        self.number += 1;
        self.memo.restart(&self.number, Priority::Shown, move |work| read(&work.task));
    }

    /// Replaces the document by `pending` after the question about unsaved work.
    pub fn intend(&mut self, pending: P, cx: &mut Context) {
        self.stop();
        self.pending = Some(pending);
        cx.request(Request::Replace);
    }

    /// Replaces the document by `pending` within a replacement that was asked about already.
    pub fn go_on(&mut self, pending: P, cx: &mut Context) {
        self.pending = Some(pending);
        cx.request(Request::GoOn);
    }

    /// The document that has been read; reports the reason if it could not be read.
    pub fn take(&mut self, cx: &mut Context) -> Option<Arc<T>> {
        let ended = self.memo.take()?;
        // What was read is held by who takes it.
        self.memo.clear();
        match ended.result {
            Ok(opened) => return Some(opened),
            Err(Refusal::Cancelled) => cx.say(EventKind::Cancelled, "Open: cancelled"),
            Err(Refusal::Failed(why)) => {
                cx.say(EventKind::Failed, format!("Open: {why}"));
                cx.error("The file cannot be opened", why);
            }
        }
        None
    }

    /// The document being read, with its progress.
    pub fn doing(&self) -> Option<&Doing> {
        self.memo.doing()
    }

    /// Whether a document is being read.
    pub fn is_busy(&self) -> bool {
        self.memo.is_busy()
    }

    /// Whether `command` cancels the reading.
    pub fn is_ended_by(&self, command: Command) -> bool {
        FrameCommand::of(command) == Some(FrameCommand::Cancel) && self.is_busy()
    }

    /// Cancels the reading at the user's wish.
    pub fn cancel(&mut self) {
        self.memo.cancel();
    }

    /// Stops the reading because another document is wanted.
    pub fn stop(&mut self) {
        self.memo.stop();
    }
}
