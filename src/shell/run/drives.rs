//! Files that are opened and saved, on drives that may not answer: the window never waits for one longer than a moment.

use std::path::{Path, PathBuf};
use std::time::Duration;

use super::SparkpathApp;
use crate::shell::files::Purpose;
use crate::workspaces::context::is_project;
use crate::workspaces::news::EventKind;
use files::patience::Awaited;
use files::{FileError, Saving, kind_of, paths};

/// A project whose kind is being read, and what becomes of it then.
#[derive(Debug, Clone)]
pub enum Arriving {
    /// Opened; the user has been asked about unsaved work.
    Open,
    /// Opened, after the question about unsaved work.
    Take,
    /// Opened for the question with this purpose, of this workspace and with this number.
    Path(Purpose, usize, usize),
    /// Taken as this point of a study.
    Point(usize),
}

/// A project that is being written.
struct Written {
    workspace: usize,
    saving: Saving,
    result: Awaited<Result<(), FileError>>,
}

/// A project whose drive has not told its kind yet.
struct Read {
    file: PathBuf,
    then: Arriving,
    kind: Awaited<Result<String, FileError>>,
}

/// Work on files whose drive does not answer yet.
#[derive(Default)]
pub struct Waiting {
    read: Option<Read>,
    written: Vec<Written>,
}

impl SparkpathApp {
    /// Opens a document or a mesh. The caller has asked about unsaved work.
    pub fn open(&mut self, path: &Path) {
        if is_project(path) { self.arrive(path, Arriving::Open) } else { self.open_in(self.shown, path) }
    }

    fn open_in(&mut self, owner: usize, path: &Path) {
        self.give_up(owner);
        // What is to be seen is worked on from the beginning.
        self.shown = owner;
        self.with(owner, |workspace, cx| workspace.open(path, cx));
    }

    /// Opens files in the workspace that they belong to.
    pub(super) fn open_here(&mut self, mut files: Vec<PathBuf>) {
        let Some(first) = files.first().cloned() else { return };
        self.given_up.clear();
        if is_project(&first) {
            return self.arrive(&first, Arriving::Take);
        }
        if files.len() > 2 {
            files.truncate(1);
        }
        self.with(self.shown, |workspace, cx| workspace.take_files(&files, cx));
    }

    /// Has the kind of the project in `file` read, by which its workspace is known.
    pub(super) fn arrive(&mut self, file: &Path, then: Arriving) {
        let (of, ctx) = (file.to_owned(), self.ctx.clone());
        let read = move || paths::check_name(&of).and_then(|()| kind_of(&of));
        let kind = match Awaited::start(read, move || ctx.request_repaint()) {
            Ok(kind) => kind,
            Err(source) => return self.arrived(Err(FileError::unreadable(file, source)), file, then),
        };
        match kind.take_soon() {
            Some(kind) => self.arrived(kind, file, then),
            None => self.waiting.read = Some(Read { file: file.to_owned(), then, kind }),
        }
    }

    /// Goes on with a project once its kind is known; shows the reason if it has none.
    fn arrived(&mut self, kind: Result<String, FileError>, file: &Path, then: Arriving) {
        let owner = kind.map(|kind| (self.workspaces.iter().position(|one| one.about().id == kind), kind));
        let owner = match owner {
            Ok((Some(owner), _)) => owner,
            Ok((None, kind)) => {
                let known: Vec<&str> = self.workspaces.iter().map(|one| one.about().id).collect();
                let why = format!("{}: kind is \"{kind}\": must be one of {}", file.display(), known.join(", "));
                self.cx.not_opened(file);
                self.error("This project cannot be opened", why);
                return self.not_arrived(then);
            }
            Err(error) => {
                self.cx.not_a_project(file, &error);
                return self.not_arrived(then);
            }
        };
        match then {
            Arriving::Open => self.open_in(owner, file),
            Arriving::Path(_, i, number) if i == owner => {
                self.with(i, |workspace, cx| workspace.take_path(number, file.to_owned(), cx));
            }
            Arriving::Take | Arriving::Path(..) => {
                self.with(owner, |workspace, cx| workspace.take_files(&[file.to_owned()], cx));
            }
            Arriving::Point(point) => self.take_parameters(owner, point, file),
        }
    }

    fn not_arrived(&mut self, then: Arriving) {
        if let Arriving::Path(purpose, ..) = then {
            self.cancelled(purpose);
        }
    }

    /// Writes `saving` of workspace number `i`; a file that another program has changed only `in_any_case`.
    pub(super) fn write(&mut self, i: usize, saving: Saving, in_any_case: bool, ctx: &egui::Context) {
        if self.waiting.written.iter().any(|one| one.workspace == i) {
            return self.say(EventKind::Refused, "the project is still being saved: cancel that first");
        }
        let (written, at_end) = (saving.clone(), ctx.clone());
        let result = Awaited::start(move || written.write(in_any_case), move || at_end.request_repaint());
        match result.map_err(|source| FileError::unwritable(saving.file(), source)) {
            Ok(result) => match result.take_soon() {
                Some(written) => self.end_saving(i, saving, written, ctx),
                None => self.waiting.written.push(Written { workspace: i, saving, result }),
            },
            Err(why) => self.end_saving(i, saving, Err(why), ctx),
        }
    }

    /// Takes what drives have answered.
    pub(super) fn follow_drives(&mut self, ctx: &egui::Context) {
        if let Some(kind) = self.waiting.read.as_ref().and_then(|read| read.kind.take())
            && let Some(Read { file, then, .. }) = self.waiting.read.take()
        {
            // Work done meanwhile is asked about.
            let then = if matches!(then, Arriving::Open) { Arriving::Take } else { then };
            self.given_up.clear();
            self.arrived(kind, &file, then);
        }
        let ended = self.waiting.written.iter().enumerate().find_map(|(n, one)| Some((n, one.result.take()?)));
        if let Some((n, written)) = ended {
            let Written { workspace, saving, .. } = self.waiting.written.remove(n);
            self.end_saving(workspace, saving, written, ctx);
        }
        if self.is_waiting() {
            ctx.request_repaint_after(Duration::from_millis(500));
        }
    }

    /// Whether a drive is waited for.
    pub(super) fn is_waiting(&self) -> bool {
        self.waiting.read.is_some() || !self.waiting.written.is_empty()
    }

    /// Sentence on the drive that is waited for.
    pub(super) fn waiting_for(&self) -> Option<String> {
        let read = self.waiting.read.iter().map(|read| ("opening", read.file.as_path()));
        let written = self.waiting.written.iter().map(|one| ("saving", one.saving.file()));
        let (what, file) = read.chain(written).next()?;
        let name = file.file_name().unwrap_or(file.as_os_str()).to_string_lossy();
        Some(format!("{what} {name}: its drive does not answer yet"))
    }

    /// Waits no longer, at the user's wish. What was to be opened is not, and what was to be saved stays unsaved.
    pub(super) fn stop_waiting(&mut self) {
        if let Some(Read { file, then, .. }) = self.waiting.read.take() {
            self.not_arrived(then);
            self.say(EventKind::Cancelled, format!("{} was not opened: its drive does not answer", file.display()));
        }
        for Written { workspace, saving, .. } in std::mem::take(&mut self.waiting.written) {
            self.after_save.take_if(|(of, _)| *of == workspace);
            let file = saving.file().display();
            self.say(EventKind::Cancelled, format!("{file} may not be saved: its drive does not answer"));
        }
    }
}
