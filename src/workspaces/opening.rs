//! Documents that are read in the background, before they take the place of what is open.

use std::path::PathBuf;
use std::sync::Arc;

use files::{Document, Params, Recovery};
use task::{Doing, Lane, Memo, Priority, Refusal, Scheduler, Task};

use super::commands::{Command, CommandSet, FrameCommand};
use super::context::{Context, Request};
use super::news::EventKind;

/// Where a document comes from.
pub enum Source<P> {
    /// A project file.
    Project(PathBuf),
    /// A copy of unsaved work.
    Copy(Recovery),
    /// A document that is in no file yet.
    New(Document<P>),
}

/// A document that was read, with what its files hold.
pub struct Incoming<P, L> {
    /// The document.
    pub document: Document<P>,
    /// What its files hold; none if a copy of unsaved work names files that cannot be read, which is no reason to lose it.
    pub loaded: Option<L>,
    /// The copy that the document was read from, if it was.
    pub copy: Option<Recovery>,
}

/// Why no document takes the place of the present one: one line.
pub enum NotOpened {
    /// The document itself cannot be read.
    Document(String),
    /// A file that it names cannot be read.
    Part(String),
}

impl From<String> for NotOpened {
    fn from(why: String) -> Self {
        Self::Part(why)
    }
}

/// A document that was read, or the file of which none could be and why.
type Read<P, L> = Result<Arc<Incoming<P, L>>, (Option<PathBuf>, String)>;

/// What takes the place of the document: a `W` that waits for the user's leave, and a document of parameters `P` that is
/// being read with what its files hold, an `L`. What cannot be read takes the place of nothing.
pub struct Opening<W, P, L> {
    /// What takes the place of the document once nothing stands in the way.
    pub pending: Option<W>,
    memo: Memo<u64, Read<P, L>>,
    /// How often something was opened.
    number: u64,
}

impl<W, P: Params + Send + Sync + 'static, L: Send + Sync + 'static> Opening<W, P, L> {
    /// An idle reader: no document is being read.
    pub fn new(scheduler: &Scheduler) -> Self {
        Self { pending: None, memo: Memo::new(scheduler, Lane::Quick, "Open").remembering(1), number: 0 }
    }

    /// Reads a document from `source`, and by `load` what its files hold; what was being read is given up.
    pub fn begin(
        &mut self,
        source: Source<P>,
        load: impl FnOnce(&Document<P>, &Task) -> Result<L, NotOpened> + Send + 'static,
    ) {
        self.number += 1;
        self.memo.restart(&self.number, Priority::Shown, move |work| {
            let (file, copy, document) = match source {
                Source::Project(file) => (Some(file.clone()), None, Document::open(&file)),
                Source::Copy(copy) => (None, Some(copy.clone()), copy.open()),
                Source::New(document) => (None, None, Ok(document)),
            };
            let document = match document {
                Ok(document) => document,
                Err(why) => return Ok(Err((file, why.to_string()))),
            };
            work.task.check().map_err(|e| e.to_string())?;
            let loaded = match load(&document, &work.task) {
                Ok(loaded) => Some(loaded),
                Err(NotOpened::Document(why)) => return Ok(Err((file, why))),
                Err(NotOpened::Part(_)) if copy.is_some() && !work.task.cancel.is_cancelled() => None,
                Err(NotOpened::Part(why)) => return Err(why),
            };
            Ok(Ok(Arc::new(Incoming { document, loaded, copy })))
        });
    }

    /// Goes on with `pending`, after asking about unsaved work.
    pub fn intend(&mut self, pending: W, cx: &mut Context) {
        self.stop();
        self.pending = Some(pending);
        cx.request(Request::Replace);
    }

    /// Goes on with `pending` on the way to what was asked for before.
    pub fn go_on(&mut self, pending: W, cx: &mut Context) {
        self.pending = Some(pending);
        cx.request(Request::GoOn);
    }

    /// What has been read; says why something was not.
    pub fn take(&mut self, cx: &mut Context) -> Option<Arc<Incoming<P, L>>> {
        // What was given up for something else may have come to its end.
        let ended = std::iter::from_fn(|| self.memo.take()).find(|ended| ended.key == self.number)?;
        // What was read is held by who takes it.
        self.memo.clear();
        let (title, why) = match ended.result.as_deref() {
            Ok(Ok(opened)) => return Some(opened.clone()),
            Ok(Err((Some(file), why))) => {
                cx.not_opened(file);
                ("This project cannot be opened", why)
            }
            Ok(Err((None, why))) => ("The copy cannot be read", why),
            Err(Refusal::Failed(why)) => ("The file cannot be opened", why),
            Err(Refusal::Cancelled) => {
                cx.say(EventKind::Cancelled, "Open: cancelled");
                return None;
            }
        };
        cx.say(EventKind::Failed, format!("Open: {why}"));
        cx.error(title, why.clone());
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
