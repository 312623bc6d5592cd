//! Questions to the user (unsaved work, paths, copies) and what follows from the answers.

use std::fs::File;
use std::path::{Path, PathBuf};

use super::drives::Arriving;
use super::{Named, SparkpathApp};
use crate::shell::dialogs::{Answer, Dialog, Intent};
use crate::shell::files::{Asking, Opened, PROJECT, Purpose};
use crate::shell::study::{LOOK_AT, RUN_IN, StudyAnswer};
use crate::workspaces::context::{PathKind, is_project};
use crate::workspaces::news::EventKind;
use files::patience::{Found, look_at, soon};
use files::{FileError, Recovery, Saving};

/// Whether the drive of a file that is read at once answers; what is opened may take its time.
fn answers(purpose: Purpose, path: &Path) -> Result<(), FileError> {
    if purpose.info.opens || !matches!(purpose.info.kind, PathKind::Read(..)) {
        return Ok(());
    }
    // What is wrong with the file is said by who reads it.
    soon(path, |path| {
        drop(File::open(path));
        Ok(())
    })
}

impl SparkpathApp {
    /// Carries out `intent` after the question about unsaved work.
    pub(super) fn intend(&mut self, intent: Intent, ctx: &egui::Context) {
        // What was to be done before is not wanted any more, nor what was answered for it.
        self.after_save = None;
        self.given_up.clear();
        self.intend_from(0, intent, ctx);
    }

    /// Carries out `intent` after the questions about unsaved work, from workspace number `first` on.
    pub(super) fn intend_from(&mut self, first: usize, intent: Intent, ctx: &egui::Context) {
        let mut asked = first..self.workspaces.len();
        match asked.find(|i| self.is_endangered(*i, intent)) {
            Some(i) => self.put_up(Dialog::Unsaved(i, intent)),
            None => self.carry_out(intent, ctx),
        }
    }

    /// Whether `intent` would lose work of workspace number `i` that the user has not given up as it is now.
    fn is_endangered(&self, i: usize, intent: Intent) -> bool {
        let document = self.workspaces[i].document();
        let given_up = self.given_up.get(i).copied().flatten();
        intent.endangers(i) && document.is_unsaved() && given_up != Some(document.revision())
    }

    /// Carries out the intent that waits for the document of workspace number `i` to be saved.
    fn saved(&mut self, i: usize, ctx: &egui::Context) {
        if let Some((_, intent)) = self.after_save.take_if(|(of, _)| *of == i) {
            // From the first: another workspace may have been worked in while the dialog was open.
            self.intend_from(0, intent, ctx);
        }
    }

    fn carry_out(&mut self, intent: Intent, ctx: &egui::Context) {
        match intent {
            Intent::Quit => {
                self.quitting = true;
                let kinds = self.workspaces.iter().map(|one| one.about().id);
                self.autosave.iter_mut().for_each(|autosave| kinds.clone().for_each(|kind| autosave.discard(kind)));
                ctx.send_viewport_cmd(egui::ViewportCommand::Close);
            }
            Intent::Replace(i) => self.with(i, |workspace, cx| workspace.proceed(cx)),
        }
    }

    /// Saves the document of workspace number `i`, in its own file if it has one and `in_its_file` is set.
    pub(super) fn save(&mut self, i: usize, in_its_file: bool, ctx: &egui::Context) {
        let document = self.workspaces[i].document();
        match document.file().map(Path::to_owned).filter(|_| in_its_file) {
            Some(file) => self.save_as(i, &file, ctx),
            None => {
                let name = format!("{}.sparkpath", document.name());
                self.ask(Purpose { of: Asking::Document(i), info: &PROJECT }, &name, ctx);
            }
        }
    }

    fn save_as(&mut self, i: usize, file: &Path, ctx: &egui::Context) {
        match self.workspaces[i].document_mut().begin_saving(file) {
            Ok(saving) => self.write(i, saving, false, ctx),
            Err(why) => self.not_saved(i, &why),
        }
    }

    /// The document of workspace number `i` was saved by `saving`, or was not.
    pub(super) fn end_saving(&mut self, i: usize, saving: Saving, written: Result<(), FileError>, ctx: &egui::Context) {
        match written {
            Ok(()) => {
                self.workspaces[i].document_mut().end_saving(&saving);
                self.cx.opened(saving.file());
                self.say(EventKind::Done, format!("saved as {}", saving.file().display()));
                self.saved(i, ctx);
            }
            Err(why) if why.is_changed() => self.put_up(Dialog::Changed(i, saving)),
            Err(why) => self.not_saved(i, &why),
        }
    }

    fn not_saved(&mut self, i: usize, why: &FileError) {
        self.after_save.take_if(|(of, _)| *of == i);
        self.error("The project was not saved", why.to_string());
    }

    /// Draws the window of studies, and does what it asks for.
    pub(super) fn show_study(&mut self, ctx: &egui::Context) {
        match self.study.show(ctx, &*self.workspaces[self.shown]) {
            Some(StudyAnswer::FolderToRun) => self.ask(Purpose { of: Asking::Study(true), info: &RUN_IN }, "", ctx),
            Some(StudyAnswer::FolderToSee) => self.ask(Purpose { of: Asking::Study(false), info: &LOOK_AT }, "", ctx),
            Some(StudyAnswer::Take(point, project)) => self.take_point(point, &project),
            None => {}
        }
    }

    /// Takes the parameters of a point of a study in the workspace of its kind, as a step that can be undone.
    fn take_point(&mut self, point: usize, project: &Path) {
        self.arrive(project, Arriving::Point(point));
    }

    /// Takes the parameters of a point of a study in workspace number `owner`.
    pub(super) fn take_parameters(&mut self, owner: usize, point: usize, project: &Path) {
        self.shown = owner;
        let label = format!("Point {point} of a study");
        match self.with(owner, |workspace, _| workspace.take_parameters(project, &label)) {
            Ok(()) => self
                .say(EventKind::Done, format!("the parameters of point {point} are taken; undo gives the former ones")),
            Err(why) => self.error("The parameters of this point cannot be taken", why),
        }
    }

    /// Asks for a path, unless another dialog is open.
    pub(super) fn ask(&mut self, purpose: Purpose, name: &str, ctx: &egui::Context) {
        self.files.is_typing_preferred = self.cx.preferences.types_paths;
        let why = match self.files.ask(purpose, name, self.folder().as_deref(), ctx) {
            Opened::Asked => return,
            Opened::Busy => "Another file dialog is open: close it first",
            Opened::Failed => "No thread could be started for the file dialog: close other programs and try again",
        };
        self.cancelled(purpose);
        self.say(EventKind::Failed, why);
    }

    /// Drops what was to follow a path for `purpose`, because none was given.
    pub(super) fn cancelled(&mut self, purpose: Purpose) {
        match purpose.of {
            Asking::Picture | Asking::Study(_) => {}
            Asking::Document(i) => drop(self.after_save.take_if(|(of, _)| *of == i)),
            Asking::Workspace(i, number) => {
                self.given_up.clear();
                self.with(i, |workspace, cx| workspace.no_path(number, cx));
            }
        }
    }

    /// Takes a path for `purpose`, unless that would overwrite a file without asking.
    pub(super) fn named(&mut self, purpose: Purpose, path: PathBuf, how: Named, ctx: &egui::Context) {
        let title = purpose.info.title;
        let whole = purpose.with_ending(path.clone());
        let (found, there) = match look_at(&path).and_then(|found| Ok((found, look_at(&whole)?))) {
            Ok(found) => found,
            Err(silent) => {
                self.cancelled(purpose);
                return self.error(title, silent.to_string());
            }
        };
        if purpose.ending().is_some() && found == Found::Folder {
            self.cancelled(purpose);
            return self.error(title, format!("{} is a folder. Add the name of a file to it.", path.display()));
        }
        if purpose.is_missing(found) {
            match how {
                Named::Chosen => self.cancelled(purpose),
                // The path can be mended.
                Named::Typed => self.put_up(Dialog::Path(purpose, path.display().to_string())),
            }
            let text = format!("There is no file {}. Check its name and its folder.", path.display());
            return self.error(title, text);
        }
        let is_asked_about = how == Named::Chosen && whole == path;
        if purpose.ending().is_some() && !is_asked_about && there != Found::Nothing {
            self.put_up(Dialog::Overwrite(purpose, whole));
        } else {
            self.chosen(purpose, whole, ctx);
        }
    }

    fn chosen(&mut self, purpose: Purpose, path: PathBuf, ctx: &egui::Context) {
        match purpose.of {
            Asking::Picture => self.write_picture(&path),
            Asking::Document(i) => self.save_as(i, &path, ctx),
            Asking::Study(true) => self.study.run(&path, &*self.workspaces[self.shown], ctx),
            Asking::Study(false) => self.study.look_at(&path, ctx),
            Asking::Workspace(i, number) if purpose.info.opens && is_project(&path) => {
                self.arrive(&path, Arriving::Path(purpose, i, number));
            }
            Asking::Workspace(i, number) => match answers(purpose, &path) {
                Ok(()) => self.with(i, |workspace, cx| workspace.take_path(number, path, cx)),
                Err(silent) => {
                    self.cancelled(purpose);
                    self.error(purpose.info.title, silent.to_string());
                }
            },
        }
    }

    pub(super) fn answer(&mut self, answer: Answer, ctx: &egui::Context) {
        let dialog = self.take_down();
        match (answer, dialog) {
            (Answer::SaveThen(intent), Dialog::Unsaved(i, _)) => {
                self.after_save = Some((i, intent));
                self.save(i, true, ctx);
            }
            (Answer::Discard(intent), Dialog::Unsaved(i, _)) => {
                self.give_up(i);
                self.intend_from(i + 1, intent, ctx);
            }
            (Answer::Recover(i), Dialog::Recover(copies)) => self.recover(i, copies),
            (Answer::ForgetCopies, Dialog::Recover(copies)) => copies.iter().for_each(Recovery::discard),
            (Answer::Path(purpose, path), _) => self.named(purpose, path, Named::Typed, ctx),
            (Answer::Overwrite, Dialog::Overwrite(purpose, path)) => self.chosen(purpose, path, ctx),
            (Answer::Overwrite, Dialog::Changed(i, saving)) => self.write(i, saving, true, ctx),
            (Answer::SaveCopy, Dialog::Changed(i, _)) => self.save(i, false, ctx),
            (Answer::ReadAgain, Dialog::Changed(i, saving)) => {
                self.after_save.take_if(|(of, _)| *of == i);
                self.open_here(vec![saving.file().to_owned()]);
            }
            (Answer::Close, Dialog::Changed(i, _)) => drop(self.after_save.take_if(|(of, _)| *of == i)),
            (Answer::Close, Dialog::Overwrite(purpose, _) | Dialog::Path(purpose, _)) => self.cancelled(purpose),
            _ => {}
        }
    }

    /// Has the unsaved work of workspace number `i`, as it is now, not asked about.
    pub(super) fn give_up(&mut self, i: usize) {
        self.given_up.resize_with(self.workspaces.len(), || None);
        self.given_up[i] = Some(self.workspaces[i].document().revision());
    }

    /// Recovers the work of copy number `i`; copies of other workspaces can still be recovered beside it.
    fn recover(&mut self, i: usize, mut copies: Vec<Recovery>) {
        let copy = copies.remove(i);
        let Some(owner) = self.workspaces.iter().position(|one| one.about().id == copy.kind) else { return };
        copies.retain(|other| other.kind != copy.kind);
        if !copies.is_empty() {
            self.put_up(Dialog::Recover(copies));
        }
        self.with(owner, |workspace, cx| workspace.recover(copy, cx));
    }

    /// The work of `copy` was taken up by workspace number `owner`.
    pub(super) fn recovered(&mut self, owner: usize, copy: &Recovery) {
        if self.autosave_now() {
            copy.discard();
        }
        self.shown = owner;
        self.cx.take_turn(self.shown);
        self.say(EventKind::Done, "unsaved work was recovered");
    }
}
