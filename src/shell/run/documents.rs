//! The document's comings and goings: opening, saving, recovering, and what is asked before work is lost.

use std::path::{Path, PathBuf};
use std::time::Instant;

use super::SparkpathApp;
use crate::shell::autosave::{Recovered, Recovery};
use crate::shell::dialogs::{Answer, Dialog, Intent, Work};
use crate::shell::files::{FlankPurpose, Opened, Purpose};
use crate::shell::workspace::Workspace;
use crate::workspaces::blisk::document::stage::Stage;
use crate::workspaces::blisk::document::{Document, OpenError};
use crate::workspaces::flank::document::flank_file::is_flank_file;
use crate::workspaces::mold::document::mold_file::is_mold_file;
use crate::workspaces::news::EventKind;

/// How a path was named.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Named {
    /// In a dialog of the system, which asks before a file is overwritten.
    Chosen,
    /// Typed.
    Typed,
}

impl SparkpathApp {
    /// Opens a project or a mesh, in whose place there was no unsaved work.
    pub fn open(&mut self, path: &Path) {
        if is_mold_file(path) {
            self.core.workspace = Workspace::Mold;
            return self.open_mold(path);
        }
        if is_flank_file(path) {
            self.core.workspace = Workspace::Flank;
            return self.open_flank(path);
        }
        if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("sparkpath")) {
            match Document::open(path) {
                Ok(document) => self.replace(document),
                Err(OpenError::Moved(project, moved)) => {
                    self.dialog = Dialog::Moved(project, moved, path.to_owned());
                    return;
                }
                Err(OpenError::File(error)) => {
                    self.core.preferences.recent.remove(path);
                    self.dialog = Dialog::Error("This project cannot be opened".to_owned(), error.to_string());
                    return;
                }
            }
        } else {
            self.replace(Document::for_mesh(path));
        }
        self.core.preferences.recent.add(path);
    }

    pub(super) fn replace(&mut self, document: Document) {
        if let Some(autosave) = &mut self.autosave {
            autosave.discard();
        }
        self.core.document = document;
        self.core.workspace = Workspace::Blisk;
        self.given_up = None;
        self.core.pipeline.reset();
        self.core.tuning.forget_sizes();
        self.core.step = Stage::Part;
        self.core.cursor.s = 0.0;
        self.core.section = None;
        self.core.ghosts.clear();
        self.core.kept.forget();
        self.core.layers = Default::default();
        self.viewport.clear_probe();
        // What was said last is of another part.
        self.core.say(EventKind::Done, format!("{} opened", self.core.document.name()));
    }

    /// Does `intent`, after asking about unsaved work.
    pub(super) fn intend(&mut self, intent: Intent, ctx: &egui::Context) {
        // What was to be done before is not wanted any more.
        (self.after_save, self.given_up) = (None, None);
        self.intend_past(&Work::ALL, intent, ctx);
    }

    /// Does `intent`, after asking about what is unsaved of `work`.
    fn intend_past(&mut self, work: &[Work], intent: Intent, ctx: &egui::Context) {
        match work.iter().find(|work| intent.endangers(**work) && work.is_unsaved(&self.core)) {
            Some(work) => self.dialog = Dialog::Unsaved(*work, intent),
            None => self.carry_out(intent, ctx),
        }
    }

    /// Goes on with what was to be done once `work` is out of the way.
    fn go_on(&mut self, work: Work, intent: Intent, ctx: &egui::Context) {
        let next = Work::ALL.iter().position(|one| *one == work).map_or(&[][..], |i| &Work::ALL[i + 1..]);
        self.intend_past(next, intent, ctx);
    }

    /// Goes on with what was to be done once `work` was saved.
    pub(super) fn saved(&mut self, work: Work, ctx: &egui::Context) {
        if let Some((_, intent)) = self.after_save.take_if(|(of, _)| *of == work) {
            self.go_on(work, intent, ctx);
        }
    }

    /// `work` was not saved: what was to be done after that is off.
    pub(super) fn not_saved(&mut self, work: Work) {
        self.after_save.take_if(|(of, _)| *of == work);
    }

    pub(super) fn carry_out(&mut self, intent: Intent, ctx: &egui::Context) {
        match intent {
            Intent::Quit => {
                self.quitting = true;
                if let Some(autosave) = &mut self.autosave {
                    autosave.discard();
                    autosave.discard_mold();
                    autosave.discard_flank();
                }
                ctx.send_viewport_cmd(egui::ViewportCommand::Close);
            }
            Intent::Open(path) => self.open(&path),
            Intent::OpenMold(path) => {
                self.core.workspace = Workspace::Mold;
                self.open_mold(&path);
            }
            Intent::OpenFlank(path) => {
                self.core.workspace = Workspace::Flank;
                self.open_flank(&path);
            }
            Intent::TakeSurface(source) => self.take_surface(&source),
            Intent::MillFlanks(electrode) => self.take_electrode(&electrode),
            Intent::AskOpen => self.ask(Purpose::Open, "", ctx),
            Intent::Demonstration => self.replace(Document::default()),
        }
    }

    /// The folder that a file dialog starts in.
    pub(super) fn folder(&self) -> Option<PathBuf> {
        let path = match self.core.workspace {
            Workspace::Blisk => self.core.document.file().or(self.core.document.job().blisk.mesh.as_deref()),
            Workspace::Mold => self.core.mold.params.mesh.as_deref(),
            Workspace::Flank => self.core.flank.file(),
        };
        path.and_then(Path::parent).map(Path::to_owned)
    }

    pub(super) fn save(&mut self, ctx: &egui::Context) {
        match self.core.document.file().map(Path::to_owned) {
            Some(file) => self.save_as(&file, ctx),
            None => self.ask_where_to_save(ctx),
        }
    }

    pub(super) fn ask_where_to_save(&mut self, ctx: &egui::Context) {
        let name = format!("{}.sparkpath", self.core.document.name());
        self.ask(Purpose::SaveProject, &name, ctx);
    }

    /// Asks for a path, unless one is being asked for.
    pub(super) fn ask(&mut self, purpose: Purpose, name: &str, ctx: &egui::Context) {
        self.files.is_typing_preferred = self.core.preferences.types_paths;
        let why = match self.files.ask(purpose.clone(), name, self.folder().as_deref(), ctx) {
            Opened::Asked => return,
            Opened::Busy => "Another file dialog is open: close it first",
            Opened::Failed => "No thread could be started for the file dialog: close other programs and try again",
        };
        self.cancelled(&purpose);
        self.core.say(EventKind::Failed, why);
    }

    /// No path was given for `purpose`: what would have followed is off.
    pub(super) fn cancelled(&mut self, purpose: &Purpose) {
        match purpose {
            Purpose::SaveProject => self.not_saved(Work::Blisk),
            Purpose::SaveMold => self.not_saved(Work::Mold),
            Purpose::SaveFlank => self.not_saved(Work::Flank),
            Purpose::Open => self.given_up = None,
            Purpose::Flank(FlankPurpose::Upper) => self.forget_first_guide(),
            _ => {}
        }
    }

    pub(super) fn save_as(&mut self, file: &Path, ctx: &egui::Context) {
        match self.core.document.save_as(file) {
            Ok(()) => {
                if let Some(autosave) = &mut self.autosave {
                    autosave.discard();
                }
                self.core.preferences.recent.add(file);
                self.core.say(EventKind::Done, format!("saved as {}", file.display()));
                self.saved(Work::Blisk, ctx);
            }
            Err(error) => {
                self.not_saved(Work::Blisk);
                self.dialog = Dialog::Error("The project was not saved".to_owned(), error.to_string());
            }
        }
    }

    /// Goes on with a path that was named for `purpose`, unless that would overwrite a file which nobody was asked
    /// about.
    pub(super) fn named(&mut self, purpose: Purpose, path: PathBuf, how: Named, ctx: &egui::Context) {
        if purpose.ending().is_some() && path.is_dir() {
            self.cancelled(&purpose);
            let text = format!("{} is a folder. Add the name of a file to it.", path.display());
            self.dialog = Dialog::Error(purpose.title().to_owned(), text);
            return;
        }
        if let Some(what) = purpose.missing(&path) {
            match how {
                Named::Chosen => self.cancelled(&purpose),
                // The path can be mended.
                Named::Typed => self.behind = Dialog::Path(purpose.clone(), path.display().to_string()),
            }
            let text = format!("There is no {what} {}. Check its name and its folder.", path.display());
            self.dialog = Dialog::Error(purpose.title().to_owned(), text);
            return;
        }
        let whole = purpose.with_ending(path.clone());
        let is_asked_about = how == Named::Chosen && whole == path;
        if purpose.ending().is_some() && !is_asked_about && whole.exists() {
            self.dialog = Dialog::Overwrite(purpose, whole);
        } else {
            self.chosen(purpose, whole, ctx);
        }
    }

    fn chosen(&mut self, purpose: Purpose, path: PathBuf, ctx: &egui::Context) {
        match purpose {
            Purpose::Open if is_mold_file(&path) => self.intend(Intent::OpenMold(path), ctx),
            Purpose::Open if is_flank_file(&path) => self.intend(Intent::OpenFlank(path), ctx),
            Purpose::Flank(what) => self.take_flank_path(what, path, ctx),
            Purpose::SaveFlank => self.write_flank(&path, ctx),
            Purpose::Open => {
                // The window went on while the dialog was open.
                if self.given_up.take().as_ref() == Some(self.core.document.job()) {
                    self.open(&path);
                } else {
                    self.intend(Intent::Open(path), ctx);
                }
            }
            Purpose::SaveProject => self.save_as(&path, ctx),
            Purpose::SaveJob => self.write_job(&path),
            Purpose::ExportFolder => self.export(&path),
            Purpose::Picture => self.write_picture(&path),
            Purpose::ElectrodeMesh => {
                let mut job = self.core.document.job().clone();
                job.electrode.mesh = Some(path);
                self.core.edit("Own electrode", job, false);
            }
            Purpose::Mold => self.choose_mold(path, ctx),
            Purpose::Cutters | Purpose::OtherCutters => self.load_cutters(&path, purpose == Purpose::OtherCutters),
            Purpose::SaveCutters => self.save_cutters(&path),
            Purpose::BurnSheet => self.take_burn_sheet(&path),
            Purpose::ElectrodeFolder => self.export_electrodes(&path),
            Purpose::SaveMold => self.write_mold(&path, ctx),
            Purpose::Post => self.take_post(&path),
            Purpose::Machine => self.take_machine(&path),
            Purpose::MovedMesh(old) => {
                if let Dialog::Moved(project, moved, _) = &mut self.dialog {
                    project.replace_mesh(&old, &path);
                    moved.retain(|m| m.path != old);
                    if moved.is_empty() {
                        self.open_anyway();
                    }
                }
            }
        }
    }

    pub(super) fn open_anyway(&mut self) {
        if let Dialog::Moved(project, _, path) = std::mem::take(&mut self.dialog) {
            self.replace(Document::opened(*project, &path));
            self.core.preferences.recent.add(&path);
        }
    }

    pub(super) fn answer(&mut self, answer: Answer, ctx: &egui::Context) {
        let dialog = std::mem::take(&mut self.dialog);
        match (answer, dialog) {
            (Answer::SaveThen(intent), Dialog::Unsaved(work, _)) => {
                self.after_save = Some((work, intent));
                match work {
                    Work::Blisk => self.save(ctx),
                    Work::Mold => self.save_mold(true, ctx),
                    Work::Flank => self.save_flank(true, ctx),
                }
            }
            (Answer::Discard(intent), Dialog::Unsaved(work, _)) => {
                if work == Work::Blisk {
                    self.given_up = Some(self.core.document.job().clone());
                }
                self.go_on(work, intent, ctx);
            }
            (Answer::Recover(i), Dialog::Recover(copies)) => self.recover(i, copies),
            (Answer::ForgetCopies, Dialog::Recover(copies)) => copies.iter().for_each(Recovery::discard),
            (Answer::Locate(old), dialog) => {
                self.dialog = dialog;
                let title = format!("Where is {}?", old.display());
                self.ask(Purpose::MovedMesh(old), &title, ctx);
            }
            (Answer::OpenAnyway, dialog) => {
                self.dialog = dialog;
                self.open_anyway();
            }
            (Answer::Path(purpose, path), _) => {
                self.dialog = std::mem::take(&mut self.behind);
                self.named(purpose, path, Named::Typed, ctx);
            }
            (Answer::Overwrite, Dialog::Overwrite(purpose, path)) => self.chosen(purpose, path, ctx),
            (Answer::Close, Dialog::Overwrite(purpose, _)) => self.cancelled(&purpose),
            (Answer::Close, Dialog::Path(purpose, _)) => {
                self.cancelled(&purpose);
                self.dialog = std::mem::take(&mut self.behind);
            }
            (Answer::Close, Dialog::Error(..)) => self.dialog = std::mem::take(&mut self.behind),
            (Answer::OwnPost, dialog) => {
                self.dialog = dialog;
                self.ask(Purpose::Post, "", ctx);
            }
            (Answer::ExportTo, _) => self.ask(Purpose::ExportFolder, "", ctx),
            (Answer::ExportFlankTo, _) => self.ask(Purpose::Flank(FlankPurpose::Folder), "", ctx),
            _ => {}
        }
    }

    /// Takes up the work of copy number `i`; those of the other kind can still be taken up beside it.
    fn recover(&mut self, i: usize, mut copies: Vec<Recovery>) {
        let copy = copies.remove(i);
        match copy.work() {
            Ok(Recovered::Blisk(document)) => self.replace(*document),
            Ok(Recovered::Mold(params, file)) => {
                self.core.mold.recover(*params, file.as_deref());
                self.core.workspace = Workspace::Mold;
            }
            Ok(Recovered::Flank(document, file)) => {
                self.core.flank.recover(*document, file.as_deref());
                self.core.workspace = Workspace::Flank;
            }
            Err(why) => {
                self.dialog = Dialog::Error("The copy cannot be read".to_owned(), why);
                return;
            }
        }
        if self.autosave_now() {
            copy.discard();
        }
        self.core.say(EventKind::Done, "unsaved work was recovered");
        copies.retain(|other| other.kind() != copy.kind());
        if !copies.is_empty() {
            self.dialog = Dialog::Recover(copies);
        }
    }

    /// Brings the copies of unsaved work up to date. Tells whether there are as many as are needed.
    pub(super) fn autosave_now(&mut self) -> bool {
        self.autosaved = Instant::now();
        let Some(autosave) = &mut self.autosave else { return false };
        let (mold, flank) = (&self.core.mold, &self.core.flank);
        let molds = mold.is_unsaved().then_some(&mold.params);
        let flanks = flank.is_unsaved().then_some(&flank.params);
        let updated = autosave
            .update(&self.core.document)
            .and_then(|()| autosave.update_mold(molds, mold.record.file.as_deref()))
            .and_then(|()| autosave.update_flank(flanks, flank.record.file.as_deref()));
        if let Err(e) = &updated {
            self.core.say(EventKind::Failed, format!("the unsaved work could not be copied: {e}"));
            self.autosave = None;
        }
        updated.is_ok()
    }
}
