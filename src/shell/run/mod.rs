//! The window as a whole: its state, its panels, and what is done every frame.

mod commands;
mod documents;
mod flanks;
mod molds;
mod writing;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use documents::{GivenUp, Named};
use egui::{Panel, Ui};

use super::commands::Command;
use super::core::Core;
use super::dialogs::{self, Dialog, Intent, Work};
use super::files::{Chosen, FileDialogs, Purpose};
use super::palette::CommandPalette;
use super::preferences::Preferences;
use super::workspace::Workspace;
use super::{menu, status};
use crate::shell::autosave::{Autosave, Recovery};
use crate::widgets::pictures::Pictures;
use crate::widgets::theme;
use crate::workspaces::blisk::document::Document;
use crate::workspaces::blisk::panels::forms::Request;
use crate::workspaces::blisk::panels::plots;
use crate::workspaces::blisk::panels::plots::{Curves, Tab};
use crate::workspaces::blisk::panels::viewport::Viewport;
use crate::workspaces::blisk::panels::{inspector, stepper, timeline};
use crate::workspaces::flank::panels as flank_panels;
use crate::workspaces::flank::panels::{FlankView, is_points_file};
use crate::workspaces::mold::panels as mold_panels;
use crate::workspaces::mold::panels::MoldView;
use crate::workspaces::news::EventKind;
use files::user_folder::user_folder;
use render::camera::Camera;
use render::scene::Scene;

/// Where the program keeps what is its own.
#[derive(Debug, Clone)]
pub struct Folders {
    /// Preferences, and the user's own lists.
    pub config: PathBuf,
    /// Copies of unsaved work.
    pub autosave: PathBuf,
}

impl Folders {
    /// Those of the user, if the system has any.
    pub fn of_user() -> Option<Self> {
        let dirs = directories::ProjectDirs::from("", "", "sparkpath")?;
        Some(Self { config: user_folder()?, autosave: dirs.data_local_dir().join("autosave") })
    }
}

/// What the window opens on.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum Opening {
    /// The built-in demonstration blisk.
    #[default]
    Demonstration,
    /// A project file or a mesh.
    File(PathBuf),
    /// The workspace of molds, on this mesh if there is one.
    Mold(Option<PathBuf>),
}

/// What is said when a dialog of the system is closed: some close without ever having been seen.
const NOTHING_CHOSEN: &str =
    "No file was chosen. If no dialog appeared: Edit, Preferences, File dialogs, Type paths in this window";

/// How long unsaved work may be without a copy.
const AUTOSAVE: Duration = Duration::from_secs(2);

/// The window.
pub struct SparkpathApp {
    core: Core,
    viewport: Viewport,
    mold_view: MoldView,
    flank_view: FlankView,
    curves: Curves,
    tab: Tab,
    palette: CommandPalette,
    dialog: Dialog,
    /// What was asked when a path had to be typed for it.
    behind: Dialog,
    files: FileDialogs,
    pictures: Pictures,
    log_open: bool,
    folders: Option<Folders>,
    autosave: Option<Autosave>,
    autosaved: Instant,
    saved_preferences: Preferences,
    /// What the user wants done once this is saved.
    after_save: Option<(Work, Intent)>,
    /// What the user would not save before choosing what to open.
    given_up: GivenUp,
    /// How often something was opened.
    openings: u64,
    adapter: String,
    quitting: bool,
    title: String,
    /// Longest time that a frame took to lay out, without drawing (s); for tests and benchmarks.
    slowest_frame: f64,
}

impl SparkpathApp {
    /// The window's state. `folders` is where preferences and copies are kept, if anywhere.
    ///
    /// # Errors
    /// If there is no GPU state to draw with or no thread to work on.
    pub fn new(cc: &eframe::CreationContext, opening: &Opening, folders: Option<Folders>) -> Result<Self, String> {
        let state = cc.wgpu_render_state.as_ref().ok_or("the window has no wgpu device to draw with")?;
        crate::widgets::viewport_gpu::install(state);
        let info = state.adapter.get_info();
        let preferences = folders.as_ref().map(|f| Preferences::read(&f.config)).unwrap_or_default();
        theme::install(&cc.egui_ctx);
        let ctx = cc.egui_ctx.clone();
        let wake = move || ctx.request_repaint();
        let no_thread = |e| format!("no thread could be started to work on: {e}");
        let pictures = Pictures::start(wake.clone()).map_err(no_thread)?;
        let core = Core::new(Document::default(), preferences.clone(), wake).map_err(no_thread)?;
        let copies = folders.as_ref().map(|f| Recovery::find(&f.autosave)).unwrap_or_default();
        let autosave = folders.as_ref().and_then(|f| Autosave::start(&f.autosave).ok());
        let mut app = Self {
            core,
            viewport: Viewport::default(),
            mold_view: MoldView::default(),
            flank_view: FlankView::default(),
            curves: Curves::default(),
            tab: Tab::Positions,
            palette: CommandPalette::default(),
            dialog: if copies.is_empty() { Dialog::None } else { Dialog::Recover(copies) },
            behind: Dialog::None,
            files: FileDialogs::default(),
            pictures,
            log_open: false,
            folders,
            autosave,
            autosaved: Instant::now(),
            saved_preferences: preferences,
            after_save: None,
            given_up: GivenUp::default(),
            openings: 0,
            adapter: format!("Drawn by {} ({:?}, {:?})", info.name, info.device_type, info.backend),
            quitting: false,
            title: String::new(),
            slowest_frame: 0.0,
        };
        if info.device_type == wgpu::DeviceType::Cpu {
            let text = format!("{} draws in software: moving views are drawn lighter and sharpen at rest", info.name);
            app.core.say(EventKind::Done, text);
        }
        if let Some(folder) = app.folders.as_ref().map(|f| f.config.clone()) {
            let wrong = app.core.mold.take_user_files(&folder);
            wrong.into_iter().for_each(|text| app.core.say(EventKind::Failed, text));
        }
        match opening {
            Opening::Demonstration => {}
            Opening::File(path) => app.open(path),
            Opening::Mold(path) => {
                app.core.workspace = Workspace::Mold;
                if let Some(opened) = path.as_ref().and_then(|path| app.document_at(path, Workspace::Mold)) {
                    app.take(opened);
                }
            }
        }
        app.apply_preferences(&cc.egui_ctx);
        Ok(app)
    }

    /// The title of the window.
    pub fn title(&self) -> &str {
        &self.title
    }

    /// What every panel sees.
    pub fn core(&self) -> &Core {
        &self.core
    }

    /// The same, to be changed: for tests and pictures.
    pub fn core_mut(&mut self) -> &mut Core {
        &mut self.core
    }

    /// Has paths typed even where the system has file dialogs: for tests.
    pub fn type_paths(&mut self) {
        self.files.typed = true;
    }

    /// What the 3-D view shows.
    pub fn scene(&self) -> &Scene {
        self.seen().picture().0
    }

    /// From where it is seen.
    pub fn camera(&self) -> &Camera {
        self.seen().picture().1
    }

    /// Longest time that a frame has taken to lay out since the last call, drawing apart (s).
    pub fn take_slowest_frame(&mut self) -> f64 {
        std::mem::take(&mut self.slowest_frame)
    }

    fn apply_preferences(&mut self, ctx: &egui::Context) {
        ctx.set_theme(self.core.preferences.egui_theme());
        if (ctx.zoom_factor() - self.core.preferences.scale).abs() > 1e-3 {
            ctx.set_zoom_factor(self.core.preferences.scale);
        }
        if self.core.preferences != self.saved_preferences {
            self.saved_preferences = self.core.preferences.clone();
            if let Some(folders) = &self.folders
                && let Err(e) = self.core.preferences.write(&folders.config)
            {
                self.core.say(EventKind::Failed, format!("preferences could not be saved: {e}"));
            }
        }
    }

    fn inputs(&mut self, ctx: &egui::Context) {
        let dropped: Vec<PathBuf> = ctx.input(|i| i.raw.dropped_files.iter().map(|f| f.path().to_owned()).collect());
        match <[PathBuf; 2]>::try_from(dropped) {
            Ok(both) if self.core.workspace == Workspace::Flank && both.iter().all(|path| is_points_file(path)) => {
                self.take_guides(both, ctx);
            }
            Ok([path, _]) => self.open_here(path, ctx),
            Err(dropped) => dropped.into_iter().take(1).for_each(|path| self.open_here(path, ctx)),
        }
        match self.files.chosen() {
            Some(Chosen::Path(purpose, path)) => self.named(purpose, path, Named::Chosen, ctx),
            Some(Chosen::Cancelled(purpose)) => {
                self.core.say_in_passing(NOTHING_CHOSEN);
                self.cancelled(&purpose);
            }
            Some(Chosen::ToType(purpose, name)) => {
                let name = if purpose.ending().is_some() { &*name } else { "" };
                let start = self.folder().unwrap_or_default().join(name).display().to_string();
                self.behind = std::mem::replace(&mut self.dialog, Dialog::Path(purpose, start));
            }
            None => {}
        }
        let is_unsaved = Work::ALL.iter().any(|work| work.is_unsaved(&self.core));
        if ctx.input(|i| i.viewport().close_requested()) && !self.quitting && is_unsaved {
            ctx.send_viewport_cmd(egui::ViewportCommand::CancelClose);
            self.intend(Intent::Quit, ctx);
        }
        if matches!(self.dialog, Dialog::None) {
            // The field that is typed in gives up the focus with Escape before anyone hears of it.
            Command::pressed(ctx, self.palette.is_open()).into_iter().for_each(|c| self.core.push(c));
        }
    }

    fn panels(&mut self, ui: &mut Ui) {
        let opened = Panel::top("menu").show(ui, |ui| menu::show(ui, &mut self.core)).inner;
        if let Some(path) = opened {
            self.open_here(path, &ui.ctx().clone());
        }
        Panel::bottom("status").exact_size(26.0).show(ui, |ui| status::show(ui, &mut self.core));
        match self.core.workspace {
            Workspace::Blisk => {}
            Workspace::Mold => {
                if let Some(purpose) = mold_panels::show(ui, &mut self.core, &mut self.mold_view) {
                    let ctx = ui.ctx().clone();
                    match purpose {
                        Purpose::Mold => self.intend(Intent::Ask(purpose), &ctx),
                        _ => self.ask(purpose, "cutters.toml", &ctx),
                    }
                }
                return;
            }
            Workspace::Flank => {
                if let Some(purpose) = flank_panels::show(ui, &mut self.core, &mut self.flank_view) {
                    let ctx = ui.ctx().clone();
                    match purpose {
                        Purpose::Flank(what) if self.is_another_flank(what) => {
                            self.intend(Intent::Ask(purpose), &ctx);
                        }
                        _ => self.ask(purpose, "", &ctx),
                    }
                }
                return;
            }
        }
        // In a small window, or one drawn large, the view comes first: what can be spared gives way to it.
        let room = ui.available_size();
        let (wide, tall) = (room.x > 900.0, room.y > 480.0);
        let left = if wide { 356.0 } else { (0.46 * room.x).clamp(240.0, 356.0) };
        let request = Panel::left("step")
            .default_size(left)
            .size_range(left..=left.max(460.0).min(0.5 * room.x).max(left))
            .show(ui, |ui| stepper::show(ui, &mut self.core))
            .inner;
        if let Some(request) = request {
            let purpose = match request {
                Request::ElectrodeMesh => Purpose::ElectrodeMesh,
                Request::Post => Purpose::Post,
                Request::Machine => Purpose::Machine,
            };
            let ctx = ui.ctx().clone();
            self.ask(purpose, "", &ctx);
        }
        if wide {
            Panel::right("inspector")
                .default_size(250.0)
                .size_range(220.0..=380.0)
                .show(ui, |ui| inspector::show(ui, &mut self.core, &mut self.viewport));
        }
        let name = if tall { "timeline" } else { "timeline alone" };
        let heights = if tall { 150.0..=520.0 } else { 70.0..=70.0 };
        Panel::bottom(name).default_size(250.0).size_range(heights).resizable(tall).show(ui, |ui| {
            let is_beside = tall && plots::table_beside(ui, &mut self.core);
            let margin = egui::Margin { right: if is_beside { 8 } else { 0 }, top: 2, ..Default::default() };
            egui::Frame::new().inner_margin(margin).show(ui, |ui| {
                timeline::show(ui, &mut self.core);
                if tall {
                    ui.add_space(2.0);
                    plots::show(ui, &mut self.core, &mut self.tab, &mut self.curves, is_beside);
                } else {
                    self.core.span = None;
                }
                // The panel keeps its height whatever it shows.
                ui.take_available_space();
            });
        });
        egui::CentralPanel::no_frame().show(ui, |ui| self.viewport.show(ui, &mut self.core));
    }

    fn windows(&mut self, ctx: &egui::Context) {
        self.palette.show(ctx, &mut self.core);
        dialogs::log(ctx, &self.core, &mut self.log_open);
        if let Some(answer) = dialogs::show(ctx, &mut self.core, &mut self.dialog, &self.adapter) {
            self.answer(answer, ctx);
        }
    }

    /// Plans and verifies what was looked at quickly, once nothing moves any more.
    fn plan_at_rest(&mut self, ctx: &egui::Context) {
        if ctx.input(|i| i.pointer.any_down()) || !self.core.can_plan() {
            return;
        }
        match self.core.tuning.is_at_rest() {
            Ok(()) => match self.core.pipeline.start_plan() {
                Ok(()) => self.core.say(EventKind::Done, "planning the previewed path"),
                Err(why) => self.core.say(EventKind::Failed, why),
            },
            Err(Some(wait)) => ctx.request_repaint_after(wait),
            Err(None) => {}
        }
    }

    fn retitle(&mut self, ctx: &egui::Context) {
        let (name, work) = match self.core.workspace {
            Workspace::Blisk => (self.core.document.name(), Work::Blisk),
            Workspace::Mold => (self.core.mold.name(), Work::Mold),
            Workspace::Flank => (self.core.flank.name(), Work::Flank),
        };
        let mark = if work.is_unsaved(&self.core) { "*" } else { "" };
        let title = format!("{name}{mark} - Sparkpath");
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
        self.core.follow();
        self.follow_mold(&ctx);
        self.follow_flank(&ctx);
        self.follow_opening(&ctx);
        self.plan_at_rest(&ctx);
        self.follow_pictures();
        let elapsed = Duration::from_secs_f32(ctx.input(|i| i.stable_dt).clamp(0.0, 0.1));
        if self.core.advance(elapsed) {
            ctx.request_repaint();
        }
        self.inputs(&ctx);
        self.panels(ui);
        self.windows(&ctx);
        for command in self.core.take_commands() {
            self.run(command, &ctx);
            ctx.request_repaint();
        }
        self.apply_preferences(&ctx);
        self.retitle(&ctx);
        // What was given up on purpose is not kept again while the window closes.
        if !self.quitting && self.autosaved.elapsed() > AUTOSAVE {
            self.autosave_now();
        }
        if Work::ALL.iter().any(|work| work.is_unsaved(&self.core)) {
            ctx.request_repaint_after(AUTOSAVE);
        }
        if self.core.opening.is_busy()
            || self.core.pipeline.is_busy()
            || self.core.mold.work.is_busy()
            || self.core.flank.work.is_busy()
        {
            // Time left and elapsed go on even while nothing is reported.
            ctx.request_repaint_after(Duration::from_millis(250));
        }
        self.slowest_frame = self.slowest_frame.max(started.elapsed().as_secs_f64());
    }

    fn on_exit(&mut self) {
        // Of saved work this removes the copy.
        if !self.quitting {
            self.autosave_now();
        }
    }
}
