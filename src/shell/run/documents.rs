//! The document's comings and goings: opening, saving, recovering, and what is asked before work is lost.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use super::SparkpathApp;
use crate::shell::autosave::{Recovered, Recovery};
use crate::shell::dialogs::{Answer, Dialog, Intent, Work};
use crate::shell::files::{FlankPurpose, Opened, Purpose};
use crate::shell::opening::Incoming;
use crate::shell::workspace::Workspace;
use crate::workspaces::blisk::document::job_file::PlanJob;
use crate::workspaces::blisk::document::stage::Stage;
use crate::workspaces::blisk::document::{Document, OpenError};
use crate::workspaces::blisk::job::stages::Part;
use crate::workspaces::blisk::panels::viewport::Viewport;
use crate::workspaces::flank::document::flank_file::{is_flank_file, read_flank};
use crate::workspaces::flank::document::{FlankDocument, FlankSource, MeshFlank};
use crate::workspaces::mold::document::MoldParams;
use crate::workspaces::mold::document::mold_file::{is_mold_file, read_mold};
use crate::workspaces::news::EventKind;
use task::{Priority, Refusal, Same};

/// Parameters that the user would not save before opening something else. They are not asked about again as long as nothing
/// of them is changed.
#[derive(Default)]
pub(super) struct GivenUp {
    blisk: Option<PlanJob>,
    mold: Option<MoldParams>,
    flank: Option<FlankDocument>,
}

/// How a path was named.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Named {
    /// In a dialog of the system, which asks before a file is overwritten.
    Chosen,
    /// Typed.
    Typed,
}

impl SparkpathApp {
    /// Opens a document or a mesh where nothing is open that could be lost, at the start of the program.
    pub fn open(&mut self, path: &Path) {
        if let Some(opened) = self.document_at(path, Workspace::Blisk) {
            self.take(opened);
        }
    }

    /// The document at `path`, without its part; a mesh is one of `workspace`. Says why there is none.
    pub(super) fn document_at(&mut self, path: &Path, workspace: Workspace) -> Option<Incoming> {
        let file = Some(path.to_owned());
        let read = if is_mold_file(path) {
            let params = read_mold(path).map(|params| Incoming::Mold(Box::new(params), file, None));
            params.map_err(|e| ("This mold cannot be opened", e.to_string()))
        } else if is_flank_file(path) {
            let document = read_flank(path).map(|document| Incoming::Flank(Box::new(document), file, None));
            document.map_err(|e| ("This flank cannot be opened", e.to_string()))
        } else if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("sparkpath")) {
            match Document::open(path) {
                Ok(document) => Ok(Incoming::Blisk(Box::new(document), None)),
                Err(OpenError::Moved(project, moved)) => {
                    self.dialog = Dialog::Moved(project, moved, path.to_owned());
                    return None;
                }
                Err(OpenError::File(error)) => Err(("This project cannot be opened", error.to_string())),
            }
        } else {
            Ok(match workspace {
                Workspace::Blisk => Incoming::Blisk(Box::new(Document::for_mesh(path)), None),
                Workspace::Mold => Incoming::Mold(Box::new(self.core.mold.begun(path)), None, None),
                Workspace::Flank => {
                    let source = FlankSource::Mesh(MeshFlank::of(path));
                    Incoming::Flank(Box::new(self.core.flank.params.of_another(source)), None, None)
                }
            })
        };
        match read {
            Ok(opened) => Some(opened),
            Err((title, text)) => {
                self.core.preferences.recent.remove(path);
                self.dialog = Dialog::Error(title.to_owned(), text);
                None
            }
        }
    }

    /// Reads the part of what is at `path`, which then takes the place of what is open.
    fn begin_at(&mut self, path: &Path, workspace: Workspace) {
        if let Some(opened) = self.document_at(path, workspace) {
            self.begin(opened);
        }
    }

    /// Reads the part of `opened`, which then takes the place of what is open.
    pub(super) fn begin(&mut self, opened: Incoming) {
        self.openings += 1;
        self.core
            .opening
            .restart(&self.openings, Priority::Shown, move |work| opened.read(&work.progress, &work.cancel));
    }

    /// Takes what has been read; a part that cannot be read takes the place of nothing.
    pub(super) fn follow_opening(&mut self, ctx: &egui::Context) {
        while let Some(ended) = self.core.opening.take() {
            // What was read is held by who takes it.
            self.core.opening.clear();
            match ended.result {
                // What the user would not save is not asked about again, unless it was changed in the meantime.
                Ok(opened) => self.go_on_to(Intent::Take(Same(opened)), ctx),
                Err(Refusal::Cancelled) => self.core.say(EventKind::Cancelled, "Open: cancelled"),
                Err(Refusal::Failed(why)) => {
                    self.core.say(EventKind::Failed, format!("Open: {why}"));
                    self.dialog = Dialog::Error("The file cannot be opened".to_owned(), why);
                }
            }
        }
    }

    /// Puts a document in the place of what is open.
    pub(super) fn take(&mut self, opened: Incoming) {
        self.given_up = GivenUp::default();
        let workspace = opened.workspace();
        let recent = match opened {
            Incoming::Blisk(document, part) => {
                let recent = document.file().or(document.job().blisk.mesh.as_deref()).map(Path::to_owned);
                self.replace(*document, part);
                recent
            }
            Incoming::Mold(params, file, part) => {
                match (&file, &params.mesh) {
                    (None, Some(mesh)) => self.core.mold.open(mesh),
                    _ => self.core.mold.replace(*params.clone(), file.as_deref()),
                }
                if let Some(part) = part {
                    self.core.mold.work.put(&params, part);
                }
                file.or(params.mesh)
            }
            Incoming::Flank(document, file, part) => {
                self.core.flank.replace(*document.clone(), file.as_deref());
                if let Some(part) = part {
                    self.core.flank.work.put(&document, part);
                }
                file
            }
        };
        self.core.workspace = workspace;
        if let Some(path) = recent {
            self.core.preferences.recent.add(&path);
        }
        // What was said last is of another part.
        let name = match workspace {
            Workspace::Blisk => self.core.document.name(),
            Workspace::Mold => self.core.mold.name(),
            Workspace::Flank => self.core.flank.name(),
        };
        self.core.say(EventKind::Done, format!("{name} opened"));
    }

    pub(super) fn replace(&mut self, document: Document, part: Option<Arc<Part>>) {
        if let Some(autosave) = &mut self.autosave {
            autosave.discard();
        }
        self.core.document = document;
        self.core.workspace = Workspace::Blisk;
        self.core.pipeline.reset(part);
        self.core.tuning.forget_sizes();
        self.core.step = Stage::Part;
        self.core.cursor.s = 0.0;
        self.core.section = None;
        self.core.ghosts.clear();
        self.core.kept.forget();
        self.core.layers = Default::default();
        // Another part is looked at as the first one was.
        self.viewport = Viewport::default();
    }

    /// Does `intent`, after asking about unsaved work.
    pub(super) fn intend(&mut self, intent: Intent, ctx: &egui::Context) {
        self.forget_intents();
        self.go_on_to(intent, ctx);
    }

    /// What was to be done before is not wanted any more, nor what was answered for it.
    pub(super) fn forget_intents(&mut self) {
        (self.after_save, self.given_up) = (None, GivenUp::default());
        self.core.opening.stop();
    }

    /// Does `intent`, after asking about unsaved work that was not asked about on the way to it.
    pub(super) fn go_on_to(&mut self, intent: Intent, ctx: &egui::Context) {
        self.intend_past(&Work::ALL, intent, ctx);
    }

    /// Whether `intent` would lose `work` that nobody has said may be lost.
    fn is_lost(&self, work: Work, intent: &Intent) -> bool {
        let mold = &self.core.mold.params;
        // The cutters that were chosen before there was a mold stay.
        let goes_on = work == Work::Mold
            && mold.mesh.is_none()
            && match intent {
                Intent::OpenMold(path) => !is_mold_file(path),
                Intent::Take(opened) => opened.0.is_bare_mold(),
                Intent::Ask(_) => true,
                _ => false,
            };
        let is_given_up = match work {
            Work::Blisk => self.given_up.blisk.as_ref() == Some(self.core.document.job()),
            Work::Mold => self.given_up.mold.as_ref() == Some(mold),
            Work::Flank => self.given_up.flank.as_ref() == Some(&self.core.flank.params),
        };
        intent.endangers(work) && work.is_unsaved(&self.core) && !goes_on && !is_given_up
    }

    /// Does `intent`, after asking about what is unsaved of `work`.
    fn intend_past(&mut self, work: &[Work], intent: Intent, ctx: &egui::Context) {
        match work.iter().find(|work| self.is_lost(**work, &intent)) {
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
            Intent::Open(path) => self.begin_at(&path, Workspace::Blisk),
            Intent::OpenMold(path) => self.begin_at(&path, Workspace::Mold),
            Intent::OpenFlank(path) => self.begin_at(&path, Workspace::Flank),
            Intent::TakeSurface(source) => {
                let document = self.core.flank.params.of_another(*source);
                self.begin(Incoming::Flank(Box::new(document), None, None));
            }
            Intent::MillFlanks(electrode) => self.take_electrode(&electrode),
            Intent::Ask(purpose) => self.ask(purpose, "", ctx),
            Intent::Take(opened) => self.take(Incoming::clone(&opened.0)),
            Intent::Demonstration => self.take(Incoming::Blisk(Box::default(), None)),
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
            Purpose::Open | Purpose::Mold => self.given_up = GivenUp::default(),
            Purpose::Flank(what) => {
                self.given_up = GivenUp::default();
                if *what == FlankPurpose::Upper {
                    self.forget_first_guide();
                }
            }
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
            Purpose::Open if is_mold_file(&path) => self.go_on_to(Intent::OpenMold(path), ctx),
            Purpose::Open if is_flank_file(&path) => self.go_on_to(Intent::OpenFlank(path), ctx),
            Purpose::Open => self.go_on_to(Intent::Open(path), ctx),
            Purpose::Mold => self.go_on_to(Intent::OpenMold(path), ctx),
            Purpose::Flank(what) => self.take_flank_path(what, path, ctx),
            Purpose::SaveFlank => self.write_flank(&path, ctx),
            Purpose::SaveProject => self.save_as(&path, ctx),
            Purpose::SaveJob => self.write_job(&path),
            Purpose::ExportFolder => self.export(&path),
            Purpose::Picture => self.write_picture(&path),
            Purpose::ElectrodeMesh => {
                let mut job = self.core.document.job().clone();
                job.electrode.mesh = Some(path);
                self.core.edit("Own electrode", job, false);
            }
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
            self.begin(Incoming::Blisk(Box::new(Document::opened(*project, &path)), None));
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
                match work {
                    Work::Blisk => self.given_up.blisk = Some(self.core.document.job().clone()),
                    Work::Mold => self.given_up.mold = Some(self.core.mold.params.clone()),
                    Work::Flank => self.given_up.flank = Some(self.core.flank.params.clone()),
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
            Ok(Recovered::Blisk(document)) => self.replace(*document, None),
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
