//! The window: its state, and the work of each frame.

mod copies;
mod drives;
mod lost;
mod questions;
mod watch;

use std::any::Any;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};
use std::time::Instant;

use egui::{Panel, Ui};

use crate::shell::dialogs::{self, Dialog, Intent};
use crate::shell::files::{Asking, Chosen, FileDialogs, PICTURE, Purpose};
use crate::shell::palette::CommandPalette;
use crate::shell::pictures::Pictures;
use crate::shell::study::StudyWindow;
use crate::shell::{menu, status};
use crate::widgets::theme;
use crate::workspaces::commands::{Command, CommandSet, FrameCommand, Scope, pressed};
use crate::workspaces::context::{Context, LogLine, Request};
use crate::workspaces::hands::Hands;
use crate::workspaces::news::EventKind;
use crate::workspaces::preferences::{Preferences, ThemeChoice};
use crate::workspaces::registry::workspaces;
use crate::workspaces::workspace::Workspace;
use copies::EVERY;
use drives::Waiting;
use files::paths::user_folder;
use files::{Autosave, Recovery, ResultCache};
use lost::Lost;
use render::camera::Camera;
use render::scene::Scene;
use task::Scheduler;
use watch::Watch;

/// Folders of the program.
#[derive(Debug, Clone)]
pub struct Folders {
    /// Preferences and the user's own lists.
    pub config: PathBuf,
    /// Copies of unsaved work.
    pub autosave: PathBuf,
    /// Cache of results.
    pub results: PathBuf,
}

impl Folders {
    /// Folders of the user, if the system has any.
    pub fn of_user() -> Option<Self> {
        let dirs = directories::ProjectDirs::from("", "", "sparkpath")?;
        let [autosave, results] = [dirs.data_local_dir().join("autosave"), dirs.cache_dir().join("results")];
        Some(Self { config: user_folder()?, autosave, results })
    }
}

/// Content that the window opens with.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum Opening {
    /// The built-in demonstration blisk.
    #[default]
    Demonstration,
    /// A project file or a mesh.
    File(PathBuf),
    /// The workspace with this name, on this file if there is one.
    In(&'static str, Option<PathBuf>),
}

/// Message after a file dialog of the system closes without a choice. Some close without ever having been visible.
const NOTHING_CHOSEN: &str =
    "No file was chosen. If no dialog appeared: Edit, Preferences, File dialogs, Type paths in this window";

/// Greatest size of the cache of results (bytes).
const MOST_RESULTS: u64 = 512 << 20;

/// Origin of a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Named {
    /// From a dialog of the system, which asks before a file is overwritten.
    Chosen,
    /// Typed by the user.
    Typed,
}

/// The window.
pub struct SparkpathApp {
    workspaces: Vec<Box<dyn Workspace>>,
    /// Number of the workspace that is shown.
    shown: usize,
    cx: Context,
    /// Runs the work of the workspaces.
    scheduler: Scheduler,
    palette: CommandPalette,
    dialog: Dialog,
    /// Dialogs behind the present one, shown again after it, the last first.
    behind: Vec<Dialog>,
    files: FileDialogs,
    pictures: Pictures,
    study: StudyWindow,
    log_open: bool,
    folders: Option<Folders>,
    autosave: Option<Autosave>,
    /// Errors of the last attempt to write copies.
    not_copied: Vec<String>,
    saved_preferences: Preferences,
    /// Work on files whose drive does not answer yet.
    waiting: Waiting,
    watch: Watch,
    /// Reason why the graphics device was lost, if it was.
    lost: Lost,
    /// Why the program ends by itself, once it does.
    ending: Arc<OnceLock<String>>,
    ctx: egui::Context,
    /// Intent that follows once the document of this workspace is saved.
    after_save: Option<(usize, Intent)>,
    /// For each workspace the revision that the user gave up for the present replacement: the user is not asked about
    /// it again while it is unchanged.
    given_up: Vec<Option<u64>>,
    adapter: String,
    quitting: bool,
    title: String,
    /// Longest time that a frame took to lay out, without drawing (s); for tests and benchmarks.
    slowest_frame: f64,
}

impl SparkpathApp {
    /// The window's state. `folders` are the folders of preferences, copies and results, if any.
    ///
    /// # Errors
    /// If there is no GPU state to draw with, or a thread cannot be started.
    pub fn new(cc: &eframe::CreationContext, opening: &Opening, folders: Option<Folders>) -> Result<Self, String> {
        let ctx = cc.egui_ctx.clone();
        let no_thread = |e| format!("no thread could be started to work on: {e}");
        let scheduler = Scheduler::start(move || ctx.request_repaint()).map_err(no_thread)?;
        let list = workspaces(&scheduler);
        Self::with_workspaces(cc, (opening, folders), list, scheduler)
    }

    /// The window's state with these workspaces, at least one.
    ///
    /// # Errors
    /// Every error of [`Self::new`].
    pub fn with_workspaces(
        cc: &eframe::CreationContext,
        (opening, folders): (&Opening, Option<Folders>),
        workspaces: Vec<Box<dyn Workspace>>,
        scheduler: Scheduler,
    ) -> Result<Self, String> {
        let state = cc.wgpu_render_state.as_ref().ok_or("the window has no wgpu device to draw with")?;
        crate::widgets::viewport_gpu::install(state);
        let info = state.adapter.get_info();
        let preferences = folders.as_ref().map(|f| Preferences::read(&f.config)).unwrap_or_default();
        theme::install(&cc.egui_ctx);
        let mut copies = folders.as_ref().map(|f| Recovery::find(&f.autosave)).unwrap_or_default();
        copies.retain(|copy| workspaces.iter().any(|one| one.about().id == copy.kind));
        let autosave = folders.as_ref().and_then(|f| Autosave::start(&f.autosave, EVERY).ok());
        let mut app = Self {
            workspaces,
            shown: 0,
            cx: Context::new(preferences.clone()),
            scheduler,
            palette: CommandPalette::default(),
            dialog: if copies.is_empty() { Dialog::None } else { Dialog::Recover(copies) },
            behind: Vec::new(),
            files: FileDialogs::default(),
            pictures: Pictures::default(),
            study: StudyWindow::default(),
            log_open: false,
            folders,
            autosave,
            not_copied: Vec::new(),
            saved_preferences: preferences,
            waiting: Waiting::default(),
            watch: Watch::default(),
            lost: Lost::watch(state, &cc.egui_ctx),
            ending: Arc::default(),
            ctx: cc.egui_ctx.clone(),
            after_save: None,
            given_up: Vec::new(),
            adapter: format!("Drawn by {} ({:?}, {:?})", info.name, info.device_type, info.backend),
            quitting: false,
            title: String::new(),
            slowest_frame: 0.0,
        };
        if info.device_type == wgpu::DeviceType::Cpu {
            let text = format!("{} draws in software: moving views are drawn lighter and sharpen at rest", info.name);
            app.say(EventKind::Done, text);
        }
        if let Some(Folders { config, results, .. }) = app.folders.clone() {
            app.cx.results = Some(ResultCache::new(&results, MOST_RESULTS));
            // What is wrong with the user's lists is said in the workspace that is seen first.
            app.workspaces.iter_mut().for_each(|workspace| workspace.take_user_files(&config, &mut app.cx));
        }
        match opening {
            Opening::Demonstration => {}
            Opening::File(path) => app.open(path),
            Opening::In(id, path) => {
                app.show(id);
                let shown = app.shown;
                path.iter().for_each(|path| app.with(shown, |workspace, cx| workspace.open(path, cx)));
            }
        }
        app.attend(&cc.egui_ctx);
        app.apply_preferences(&cc.egui_ctx);
        Ok(app)
    }

    /// The title of the window.
    pub fn title(&self) -> &str {
        &self.title
    }

    /// Preferences, log and requests.
    pub fn context(&self) -> &Context {
        &self.cx
    }

    /// Mutable context: for tests and pictures.
    pub fn context_mut(&mut self) -> &mut Context {
        &mut self.cx
    }

    /// Kind of the workspace that is shown.
    pub fn shown(&self) -> &'static str {
        self.workspaces[self.shown].about().id
    }

    /// Shows the workspace of this kind.
    pub fn show(&mut self, id: &str) {
        self.shown = self.workspaces.iter().position(|one| one.about().id == id).unwrap_or(self.shown);
        self.cx.take_turn(self.shown);
    }

    /// The workspace of this type: for tests and benchmarks.
    pub fn workspace<W: Workspace>(&self) -> Option<&W> {
        self.workspaces.iter().find_map(|one| (&**one as &dyn Any).downcast_ref())
    }

    /// Mutable workspace of this type: for tests and benchmarks.
    pub fn workspace_mut<W: Workspace>(&mut self) -> Option<&mut W> {
        self.workspaces.iter_mut().find_map(|one| (&mut **one as &mut dyn Any).downcast_mut())
    }

    /// Calls `act` on the workspace of this type, if there is one: for tests and benchmarks.
    pub fn act<W: Workspace, R>(&mut self, act: impl FnOnce(&mut W, &mut Context) -> R) -> Option<R> {
        let i = self.workspaces.iter().position(|one| (&**one as &dyn Any).is::<W>())?;
        self.with(i, |workspace, cx| (workspace as &mut dyn Any).downcast_mut().map(|workspace| act(workspace, cx)))
    }

    /// Whether work is under way.
    pub fn is_busy(&self) -> bool {
        self.is_waiting()
            || self.pictures.is_busy()
            || self.study.is_busy()
            || self.workspaces.iter().any(|one| one.is_busy())
    }

    /// Whether a document is being read.
    pub fn is_opening(&self) -> bool {
        self.is_waiting() || self.workspaces.iter().any(|one| one.is_opening())
    }

    /// The last line of the log in the workspace that is shown, unless it tells of a problem that is over; and whether
    /// the line is of other parameters than the present ones.
    pub fn last_said(&self) -> Option<(&LogLine, bool)> {
        status::last_said(&*self.workspaces[self.shown], self.shown, &self.cx)
    }

    /// Has paths typed even if the system has file dialogs: for tests.
    pub fn type_paths(&mut self) {
        self.files.typed = true;
    }

    /// Scene of the 3-D view.
    pub fn scene(&self) -> &Scene {
        self.workspaces[self.shown].viewport().picture().0
    }

    /// Camera of the 3-D view.
    pub fn camera(&self) -> &Camera {
        self.workspaces[self.shown].viewport().picture().1
    }

    /// Longest layout of a frame since the last call, without drawing (s).
    pub fn take_slowest_frame(&mut self) -> f64 {
        std::mem::take(&mut self.slowest_frame)
    }

    /// Calls `act` on workspace number `i`, which is the one that acts meanwhile.
    fn with<R>(&mut self, i: usize, act: impl FnOnce(&mut dyn Workspace, &mut Context) -> R) -> R {
        self.cx.take_turn(i);
        let answer = act(&mut *self.workspaces[i], &mut self.cx);
        self.cx.set_revision(self.workspaces[i].revision());
        self.cx.take_turn(self.shown);
        answer
    }

    /// Adds a line to the log of the workspace that is shown.
    fn say(&mut self, kind: EventKind, text: impl Into<String>) {
        self.with(self.shown, |_, cx| cx.say(kind, text));
    }

    /// Shows an error in front of the present dialog.
    fn error(&mut self, title: impl Into<String>, text: impl Into<String>) {
        self.put_up(Dialog::Error(title.into(), text.into()));
    }

    /// Asks what `dialog` asks, and what was asked before again after that. A question that is asked once more is asked
    /// once.
    fn put_up(&mut self, dialog: Dialog) {
        let before = std::mem::replace(&mut self.dialog, dialog);
        self.behind.push(before);
        let now = &self.dialog;
        self.behind.retain(|one| !matches!(one, Dialog::None) && !one.is_alike(now));
    }

    /// Asks what was asked before the present dialog, which is answered.
    fn take_down(&mut self) -> Dialog {
        std::mem::replace(&mut self.dialog, self.behind.pop().unwrap_or_default())
    }

    /// Carries out the requests of the workspaces.
    fn attend(&mut self, ctx: &egui::Context) {
        loop {
            let requests = self.cx.take_requests();
            if requests.is_empty() {
                return;
            }
            for (i, request) in requests {
                match request {
                    Request::Path(number, info, name) => {
                        self.ask(Purpose { of: Asking::Workspace(i, number), info }, &name, ctx);
                    }
                    Request::Error(title, text) => self.error(title, text),
                    Request::Dialog => self.put_up(Dialog::Workspace(i)),
                    Request::CloseDialog => {
                        // On top of all others, whatever it was behind.
                        self.put_up(Dialog::Workspace(i));
                        self.take_down();
                    }
                    Request::Replace => self.intend(Intent::Replace(i), ctx),
                    Request::GoOn => self.intend_from(0, Intent::Replace(i), ctx),
                    Request::Show => {
                        self.shown = i;
                        self.cx.take_turn(i);
                    }
                    Request::Recovered(copy) => self.recovered(i, &copy),
                    Request::Send(message) => {
                        let mut others = (0..self.workspaces.len()).filter(|other| *other != i);
                        others.any(|i| self.with(i, |workspace, cx| workspace.receive(&message, cx)));
                    }
                }
            }
        }
    }

    /// Whether any document has unsaved work.
    fn is_unsaved(&self) -> bool {
        self.workspaces.iter().any(|one| one.document().is_unsaved())
    }

    /// The folder that a file dialog starts in.
    fn folder(&self) -> Option<PathBuf> {
        self.workspaces[self.shown].near().and_then(Path::parent).map(Path::to_owned)
    }

    fn write_picture(&mut self, path: &Path) {
        let (scene, camera) = self.workspaces[self.shown].viewport().picture();
        // A picture has nothing else that tells the axes.
        let scene = Scene { triad: true, ..(**scene).clone() };
        self.pictures.write(path, scene, *camera, &self.scheduler);
    }

    /// Reports the pictures that were written.
    fn follow_pictures(&mut self) {
        for written in self.pictures.written() {
            match written {
                Ok(path) => self.say(EventKind::Done, format!("picture written to {}", path.display())),
                Err(why) => self.say(EventKind::Failed, format!("the picture was not written: {why}")),
            }
        }
    }

    /// The commands available now, and those that switch the workspace.
    fn commands(&self) -> Vec<Command> {
        let mut all = FrameCommand::all();
        all.extend(self.workspaces[self.shown].commands());
        all.extend(self.workspaces.iter().enumerate().map(|(i, one)| Command::switch(i, &one.about().switch)));
        all
    }

    fn run(&mut self, command: Command, ctx: &egui::Context) {
        use FrameCommand as F;
        let (now, shown) = (self.cx.now, self.shown);
        if F::of(command) == Some(F::Cancel) && self.is_waiting() {
            return self.stop_waiting();
        }
        if command.scope == Scope::Switch {
            self.shown = command.index;
            return self.cx.take_turn(self.shown);
        }
        if !self.workspaces[shown].is_enabled(command) {
            let why = self.workspaces[shown].why_not(command);
            why.into_iter()
                .for_each(|why| self.cx.say_in_passing(format!("{}: {why}", command.info.name.trim_end_matches('…'))));
            return;
        }
        match F::of(command) {
            Some(F::Save) => self.save(shown, true, ctx),
            Some(F::SaveAs) => self.save(shown, false, ctx),
            Some(F::Undo) => drop(self.workspaces[shown].document_mut().undo(false)),
            Some(F::Redo) => drop(self.workspaces[shown].document_mut().undo(true)),
            Some(F::Quit) => self.intend(Intent::Quit, ctx),
            Some(F::Screenshot) => {
                let name = format!("{}.png", self.workspaces[shown].document().name());
                self.ask(Purpose { of: Asking::Picture, info: &PICTURE }, &name, ctx);
            }
            Some(F::Fit) => self.workspaces[shown].viewport_mut().fit(false),
            Some(F::View(view)) => self.workspaces[shown].viewport_mut().look(view, now),
            Some(F::Projection) => self.workspaces[shown].viewport_mut().toggle_projection(),
            Some(F::Preferences) => self.put_up(Dialog::Preferences),
            Some(F::Theme) => {
                let dark = ctx.theme() == egui::Theme::Dark;
                self.cx.preferences.theme = if dark { ThemeChoice::Light } else { ThemeChoice::Dark };
            }
            Some(F::Palette) => self.palette.toggle(),
            Some(F::Log) => self.log_open = !self.log_open,
            Some(F::Study) => self.study.is_open = !self.study.is_open,
            Some(F::About) => self.put_up(Dialog::About),
            _ => self.with(shown, |workspace, cx| workspace.run(command, cx, now)),
        }
    }

    fn apply_preferences(&mut self, ctx: &egui::Context) {
        let preferences = &self.cx.preferences;
        ctx.set_theme(preferences.egui_theme());
        if (ctx.zoom_factor() - preferences.scale).abs() > 1e-3 {
            ctx.set_zoom_factor(preferences.scale);
        }
        if *preferences != self.saved_preferences {
            self.saved_preferences = preferences.clone();
            if let Some(folders) = &self.folders
                && let Err(e) = self.saved_preferences.write(&folders.config)
            {
                self.say(EventKind::Failed, format!("preferences could not be saved: {e}"));
            }
        }
    }

    fn follow(&mut self, ctx: &egui::Context) {
        let hands = Hands::of(ctx);
        self.cx.now = ctx.input(|i| i.time);
        let seconds = f64::from(ctx.input(|i| i.stable_dt).clamp(0.0, 0.1));
        let shown = self.shown;
        for i in 0..self.workspaces.len() {
            self.with(i, |workspace, cx| workspace.follow(cx, hands, seconds, i == shown));
        }
        self.follow_pictures();
    }

    fn inputs(&mut self, ctx: &egui::Context) {
        let dropped: Vec<PathBuf> = ctx.input(|i| i.raw.dropped_files.iter().map(|f| f.path().to_owned()).collect());
        self.open_here(dropped);
        self.follow_drives(ctx);
        match self.files.chosen() {
            Some(Chosen::Path(purpose, path)) => self.named(purpose, path, Named::Chosen, ctx),
            Some(Chosen::Cancelled(purpose)) => {
                self.cx.say_in_passing(NOTHING_CHOSEN);
                self.cancelled(purpose);
            }
            Some(Chosen::ToType(purpose, name)) => {
                let name = if purpose.ending().is_some() { &*name } else { "" };
                let start = self.folder().unwrap_or_default().join(name).display().to_string();
                self.put_up(Dialog::Path(purpose, start));
            }
            None => {}
        }
        let is_unsaved = self.is_unsaved();
        if ctx.input(|i| i.viewport().close_requested()) && !self.quitting && is_unsaved {
            ctx.send_viewport_cmd(egui::ViewportCommand::CancelClose);
            self.intend(Intent::Quit, ctx);
        }
        if matches!(self.dialog, Dialog::None) {
            // The field that is typed in gives up the focus with Escape before anyone hears of it.
            let commands = pressed(ctx, self.commands(), self.palette.is_open());
            commands.into_iter().for_each(|command| self.cx.push(command));
        }
    }

    fn panels(&mut self, ui: &mut Ui) {
        let shown = self.shown;
        let opened = Panel::top("menu").show(ui, |ui| menu::show(ui, (&self.workspaces, shown), &mut self.cx)).inner;
        self.open_here(opened.into_iter().collect());
        let waiting = self.waiting_for();
        Panel::bottom("status")
            .exact_size(26.0)
            .show(ui, |ui| status::show(ui, (&mut self.workspaces, shown), waiting.as_deref(), &mut self.cx));
        self.with(shown, |workspace, cx| workspace.ui(ui, cx));
    }

    fn windows(&mut self, ctx: &egui::Context) {
        let (commands, here) = (self.commands(), &self.workspaces[self.shown]);
        let is_enabled = |command: Command| command.scope == Scope::Switch || here.is_enabled(command);
        self.palette.show(ctx, &mut self.cx, commands, is_enabled);
        dialogs::log(ctx, &self.cx, &mut self.log_open);
        self.show_study(ctx);
        let answer = dialogs::show(ctx, (&mut self.workspaces, &mut self.cx), &mut self.dialog, &self.adapter);
        self.cx.take_turn(self.shown);
        if let Some(answer) = answer {
            self.answer(answer, ctx);
        }
    }

    /// The window of studies: for tests.
    pub fn study(&self) -> &StudyWindow {
        &self.study
    }

    fn retitle(&mut self, ctx: &egui::Context) {
        let here = self.workspaces[self.shown].document();
        let mark = if here.is_unsaved() { "*" } else { "" };
        let title = format!("{}{mark} - Sparkpath", here.name());
        if title != self.title {
            ctx.send_viewport_cmd(egui::ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }
}

impl eframe::App for SparkpathApp {
    fn ui(&mut self, ui: &mut Ui, _frame: &mut eframe::Frame) {
        let started = Instant::now();
        let ctx = ui.ctx().clone();
        if self.end_if_lost(&ctx) {
            return;
        }
        self.follow(&ctx);
        self.inputs(&ctx);
        self.attend(&ctx);
        self.panels(ui);
        self.windows(&ctx);
        self.attend(&ctx);
        for command in self.cx.take_commands() {
            self.run(command, &ctx);
            self.attend(&ctx);
            ctx.request_repaint();
        }
        self.apply_preferences(&ctx);
        self.retitle(&ctx);
        self.keep_up(&ctx);
        self.watch_files();
        self.slowest_frame = self.slowest_frame.max(started.elapsed().as_secs_f64());
    }

    fn on_exit(&mut self) {
        // Of saved work this removes the copy.
        if !self.quitting {
            self.autosave_now();
        }
    }
}
