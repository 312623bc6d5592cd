//! Documents that are read in the background, before they take the place of what is open.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use files::patience::await_files;
use files::{AnyDocument as _, Document, MovedFile, Params, Recovery, files_in};
use task::{Doing, Lane, Memo, Priority, Refusal, Scheduler, Task};

use super::commands::{Command, CommandSet, FrameCommand};
use super::context::{Context, Request};
use super::moved_files::MovedFiles;
use super::news::EventKind;

/// Origin of a document.
pub enum Source<P> {
    /// A project file. The user is asked about its files that are gone or have changed.
    Project(PathBuf),
    /// A copy of unsaved work.
    Copy(Recovery),
    /// A document that is there already.
    There(Box<Document<P>>),
}

/// A document that was read, with the content of its files.
pub struct Incoming<P, L> {
    /// The document.
    pub document: Document<P>,
    /// Content of its files. None while the user is asked about them, and if a copy of unsaved work names files that
    /// cannot be read: the work is not lost for that.
    pub loaded: Option<L>,
    /// Copy that the document was read from, if it was.
    pub copy: Option<Recovery>,
    /// Files of a project that are gone or have changed.
    moved: Vec<MovedFile>,
}

/// Reason why a document was not opened, in one line.
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

/// Waits until the drives of `files` answer.
///
/// # Errors
/// If the task is cancelled before.
pub fn await_drives(files: &[PathBuf], task: &Task) -> Result<(), String> {
    let waiting = |file: &Path| {
        let text = format!("the drive of {} does not answer yet", file.display());
        task.progress.report("waiting for a drive", 0.0, &text);
    };
    if await_files(files, || task.cancel.is_cancelled(), waiting) {
        return Ok(());
    }
    task.check().map_err(|e| e.to_string())
}

/// A document that was read, or the file that is none and why.
type Read<P, L> = Result<Arc<Incoming<P, L>>, (Option<PathBuf>, String)>;

/// The replacement of a workspace's document: a `W` that waits until unsaved work is dealt with, and a document of
/// parameters `P` that is being read with the content `L` of its files. A document that cannot be read replaces nothing.
pub struct Opening<W, P, L> {
    /// Replacement of the document, done once unsaved work is dealt with.
    pub pending: Option<W>,
    /// Project that waits until the user has been asked about its files.
    pub moved: MovedFiles<P>,
    memo: Memo<u64, Read<P, L>>,
    /// Number of documents opened so far.
    number: u64,
}

impl<W, P: Params + Send + Sync + 'static, L: Send + Sync + 'static> Opening<W, P, L> {
    /// An idle reader: no document is being read.
    pub fn new(scheduler: &Scheduler) -> Self {
        let memo = Memo::new(scheduler, Lane::Quick, "Open").remembering(1);
        Self { pending: None, moved: MovedFiles::default(), memo, number: 0 }
    }

    /// Reads a document from `source`, and by `load` the content of its files. Drops the document being read.
    pub fn begin(
        &mut self,
        source: Source<P>,
        load: impl FnOnce(&Document<P>, &Task) -> Result<L, NotOpened> + Send + 'static,
    ) {
        self.number += 1;
        self.moved.forget();
        self.memo.restart(&self.number, Priority::Shown, move |work| {
            let source_file = match &source {
                Source::Project(file) => Some(file.clone()),
                Source::Copy(_) | Source::There(_) => None,
            };
            await_drives(&source_file.into_iter().collect::<Vec<_>>(), &work.task)?;
            let asks_about_files = matches!(source, Source::Project(_));
            let (file, copy, document) = match source {
                Source::Project(file) => (Some(file.clone()), None, Document::open(&file)),
                Source::Copy(copy) => (None, Some(copy.clone()), copy.open()),
                Source::There(document) => (document.file().map(Path::to_owned), None, Ok(*document)),
            };
            let document = match document {
                Ok(document) => document,
                Err(why) => return Ok(Err((file, why.to_string()))),
            };
            await_drives(&files_in(document.params()), &work.task)?;
            work.task.check().map_err(|e| e.to_string())?;
            let moved = if asks_about_files { document.moved_files() } else { Vec::new() };
            if !moved.is_empty() {
                return Ok(Ok(Arc::new(Incoming { document, loaded: None, copy, moved })));
            }
            let loaded = match load(&document, &work.task) {
                Ok(loaded) => Some(loaded),
                Err(NotOpened::Document(why)) => return Ok(Err((file, why))),
                Err(NotOpened::Part(_)) if copy.is_some() && !work.task.cancel.is_cancelled() => None,
                Err(NotOpened::Part(why)) => return Err(why),
            };
            Ok(Ok(Arc::new(Incoming { document, loaded, copy, moved })))
        });
    }

    /// Replaces the document by `pending` after the question about unsaved work.
    pub fn intend(&mut self, pending: W, cx: &mut Context) {
        self.stop();
        self.pending = Some(pending);
        cx.request(Request::Replace);
    }

    /// Replaces the document by `pending` within a replacement that was asked about already.
    pub fn go_on(&mut self, pending: W, cx: &mut Context) {
        self.pending = Some(pending);
        cx.request(Request::GoOn);
    }

    /// The document that has been read. Shows the reason if it could not be read, and asks the user about files that are
    /// gone or have changed.
    pub fn take(&mut self, cx: &mut Context) -> Option<Arc<Incoming<P, L>>> {
        // Work that was superseded may have ended meanwhile.
        let ended = std::iter::from_fn(|| self.memo.take()).find(|ended| ended.key == self.number)?;
        // What was read is held by who takes it.
        self.memo.clear();
        let (title, why) = match ended.result.as_deref() {
            Ok(Ok(opened)) if opened.moved.is_empty() => return Some(opened.clone()),
            Ok(Ok(opened)) => {
                self.moved.ask(opened.document.clone(), opened.moved.clone(), cx);
                return None;
            }
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
