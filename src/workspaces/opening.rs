//! Documents that are read in the background, before they take the place of what is open.

use std::sync::Arc;

use task::{Doing, Lane, Memo, Priority, Refusal, Scheduler, Task};

use super::commands::{Command, CommandSet, FrameCommand};
use super::context::{Context, Request};
use super::news::EventKind;

/// What takes the place of the document, a `P` that waits for the user's leave and a `T` that is being read with its part.
/// A part that cannot be read takes the place of nothing.
pub struct Opening<P, T> {
    /// What takes the place of the document once nothing stands in the way.
    pub pending: Option<P>,
    memo: Memo<u64, T>,
    /// How often something was opened.
    number: u64,
}

impl<P, T: Send + Sync + 'static> Opening<P, T> {
    /// An idle reader: no document is being read.
    pub fn new(scheduler: &Scheduler) -> Self {
        Self { pending: None, memo: Memo::new(scheduler, Lane::Quick, "Open").remembering(1), number: 0 }
    }

    /// Reads a document; what was being read is given up.
    pub fn begin(&mut self, read: impl FnOnce(&Task) -> Result<T, String> + Send + 'static) {
        self.number += 1;
        self.memo.restart(&self.number, Priority::Shown, move |work| read(&work.task));
    }

    /// Goes on with `pending`, after asking about unsaved work.
    pub fn intend(&mut self, pending: P, cx: &mut Context) {
        self.stop();
        self.pending = Some(pending);
        cx.request(Request::Replace);
    }

    /// Goes on with `pending` on the way to what was asked for before.
    pub fn go_on(&mut self, pending: P, cx: &mut Context) {
        self.pending = Some(pending);
        cx.request(Request::GoOn);
    }

    /// What has been read; says why something was not.
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

    /// What is being read, and how far it is.
    pub fn doing(&self) -> Option<&Doing> {
        self.memo.doing()
    }

    /// Whether something is being read.
    pub fn is_busy(&self) -> bool {
        self.memo.is_busy()
    }

    /// Whether `command` cancels what is being read.
    pub fn is_ended_by(&self, command: Command) -> bool {
        FrameCommand::of(command) == Some(FrameCommand::Cancel) && self.is_busy()
    }

    /// Cancels it, as the user asked.
    pub fn cancel(&mut self) {
        self.memo.cancel();
    }

    /// Gives it up: something else is wanted now.
    pub fn stop(&mut self) {
        self.memo.stop();
    }
}
