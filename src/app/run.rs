//! The window as a whole: lays out the panels, carries out commands, opens and saves.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use egui::{Panel, Ui};

use super::commands::Command;
use super::core::Core;
use super::dialogs::{self, Answer, Dialog, Intent};
use super::files::{Chosen, FileDialogs, Purpose};
use super::palette::CommandPalette;
use super::plots::{self, Curves, Tab};
use super::preferences::{Preferences, ThemeChoice};
use super::viewport::Viewport;
use super::{forms::Request, inspector, menu, status, stepper, theme, timeline};
use crate::export::post::Post;
use crate::jobs::pipeline::{EventKind, ExportWork};
use crate::jobs::{plan_files, plan_pictures, plan_report};
use crate::project::{Autosave, Document, OpenError, Recovery, Stage};
use crate::render::scene::{Scene, SectionPlane};

/// Where the program keeps what is its own.
#[derive(Debug, Clone)]
pub struct Folders {
    /// Preferences.
    pub config: PathBuf,
    /// Copies of unsaved work.
    pub autosave: PathBuf,
}

impl Folders {
    /// Those of the user, if the system has any.
    pub fn of_user() -> Option<Self> {
        let dirs = directories::ProjectDirs::from("", "", "sparkpath")?;
        Some(Self { config: dirs.config_dir().to_owned(), autosave: dirs.data_local_dir().join("autosave") })
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
}

/// How long unsaved work may be without a copy.
const AUTOSAVE: Duration = Duration::from_secs(2);

/// The window.
pub struct SparkpathApp {
    core: Core,
    viewport: Viewport,
    curves: Curves,
    tab: Tab,
    palette: CommandPalette,
    dialog: Dialog,
    /// What was asked when a path had to be typed for it.
    behind: Dialog,
    files: FileDialogs,
    log_open: bool,
    folders: Option<Folders>,
    autosave: Option<Autosave>,
    autosaved: Instant,
    saved_preferences: Preferences,
    after_save: Option<Intent>,
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
        super::viewport_gpu::install(state);
        let info = state.adapter.get_info();
        let preferences = folders.as_ref().map(|f| Preferences::read(&f.config)).unwrap_or_default();
        theme::install(&cc.egui_ctx);
        let ctx = cc.egui_ctx.clone();
        let core = Core::new(Document::default(), preferences.clone(), move || ctx.request_repaint())
            .map_err(|e| format!("no thread could be started to work on: {e}"))?;
        let copies = folders.as_ref().map(|f| Recovery::find(&f.autosave)).unwrap_or_default();
        let autosave = folders.as_ref().and_then(|f| Autosave::start(&f.autosave).ok());
        let mut app = Self {
            core,
            viewport: Viewport::default(),
            curves: Curves::default(),
            tab: Tab::Positions,
            palette: CommandPalette::default(),
            dialog: if copies.is_empty() { Dialog::None } else { Dialog::Recover(copies) },
            behind: Dialog::None,
            files: FileDialogs::default(),
            log_open: false,
            folders,
            autosave,
            autosaved: Instant::now(),
            saved_preferences: preferences,
            after_save: None,
            adapter: format!("Drawn by {} ({:?}, {:?})", info.name, info.device_type, info.backend),
            quitting: false,
            title: String::new(),
            slowest_frame: 0.0,
        };
        if info.device_type == wgpu::DeviceType::Cpu {
            let text = format!("{} draws in software: moving views are drawn lighter and sharpen at rest", info.name);
            app.core.say(EventKind::Done, text);
        }
        if let Opening::File(path) = opening {
            app.open(path);
        }
        app.apply_preferences(&cc.egui_ctx);
        Ok(app)
    }

    /// What every panel sees.
    pub fn core(&self) -> &Core {
        &self.core
    }

    /// The same, to be changed: for tests and pictures.
    pub fn core_mut(&mut self) -> &mut Core {
        &mut self.core
    }

    /// What the 3-D view shows.
    pub fn scene(&self) -> &Scene {
        self.viewport.picture().0
    }

    /// Longest time that a frame has taken to lay out since the last call, drawing apart (s).
    pub fn take_slowest_frame(&mut self) -> f64 {
        std::mem::take(&mut self.slowest_frame)
    }

    /// Opens a project or a mesh, in whose place there was no unsaved work.
    pub fn open(&mut self, path: &Path) {
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

    fn replace(&mut self, document: Document) {
        if let Some(autosave) = &mut self.autosave {
            autosave.discard();
        }
        self.core.document = document;
        self.core.pipeline.reset();
        self.core.step = Stage::Part;
        self.core.cursor.s = 0.0;
        self.core.section = None;
        self.core.ghosts.clear();
        self.core.layers = Default::default();
        self.viewport.clear_probe();
    }

    /// Does `intent`, after asking about unsaved work.
    fn intend(&mut self, intent: Intent, ctx: &egui::Context) {
        if self.core.document.is_unsaved() {
            self.dialog = Dialog::Unsaved(intent);
        } else {
            self.carry_out(intent, ctx);
        }
    }

    fn carry_out(&mut self, intent: Intent, ctx: &egui::Context) {
        match intent {
            Intent::Quit => {
                self.quitting = true;
                if let Some(autosave) = &mut self.autosave {
                    autosave.discard();
                }
                ctx.send_viewport_cmd(egui::ViewportCommand::Close);
            }
            Intent::Open(path) => self.open(&path),
            Intent::AskOpen => self.files.ask(Purpose::Open, "", self.folder().as_deref(), ctx),
            Intent::Demonstration => self.replace(Document::default()),
        }
    }

    /// The folder that a file dialog starts in.
    fn folder(&self) -> Option<PathBuf> {
        let path = self.core.document.file().or(self.core.document.job().blisk.mesh.as_deref());
        path.and_then(Path::parent).map(Path::to_owned)
    }

    fn save(&mut self, ctx: &egui::Context) {
        match self.core.document.file().map(Path::to_owned) {
            Some(file) => self.save_as(&file, ctx),
            None => self.ask_where_to_save(ctx),
        }
    }

    fn ask_where_to_save(&mut self, ctx: &egui::Context) {
        let name = format!("{}.sparkpath", self.core.document.name());
        self.files.ask(Purpose::SaveProject, &name, self.folder().as_deref(), ctx);
    }

    fn save_as(&mut self, file: &Path, ctx: &egui::Context) {
        let file = if file.extension().is_some() { file.to_owned() } else { file.with_extension("sparkpath") };
        match self.core.document.save_as(&file) {
            Ok(()) => {
                self.core.preferences.recent.add(&file);
                self.core.say(EventKind::Done, format!("saved as {}", file.display()));
                if let Some(intent) = self.after_save.take() {
                    self.carry_out(intent, ctx);
                }
            }
            Err(error) => self.dialog = Dialog::Error("The project was not saved".to_owned(), error.to_string()),
        }
    }

    fn chosen(&mut self, purpose: Purpose, path: PathBuf, ctx: &egui::Context) {
        match purpose {
            Purpose::Open => self.open(&path),
            Purpose::SaveProject => self.save_as(&path, ctx),
            Purpose::SaveJob => self.write_job(&path),
            Purpose::ExportFolder => self.export(&path),
            Purpose::Picture => self.write_picture(&path),
            Purpose::ElectrodeMesh => {
                let mut job = self.core.document.job().clone();
                job.electrode.mesh = Some(path);
                self.core.edit("Own electrode", job, false);
            }
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

    fn open_anyway(&mut self) {
        if let Dialog::Moved(project, _, path) = std::mem::take(&mut self.dialog) {
            self.replace(Document::opened(*project, &path));
            self.core.preferences.recent.add(&path);
        }
    }

    fn write_job(&mut self, path: &Path) {
        let text = self.core.document.job().to_toml();
        let written = text.and_then(|text| {
            crate::mesh_io::atomic_write(path, |out| out.write_all(text.as_bytes())).map_err(|e| e.to_string())
        });
        match written {
            Ok(()) => self.core.say(EventKind::Done, format!("job file written to {}", path.display())),
            Err(e) => self.dialog = Dialog::Error("The job file was not written".to_owned(), e),
        }
    }

    /// Writes the files of the approved plan into `folder`, as the export dialog does; says why not if it cannot.
    pub fn export(&mut self, folder: &Path) {
        let write: ExportWork = Box::new(|folder, plan, inputs, files, progress, cancel| {
            let post = Post::named(&inputs.job.export.post).map_err(|e| e.to_string())?;
            plan_files::prepare(folder).map_err(|e| e.to_string())?;
            let mut report = plan_report::report(plan, &inputs.job, files);
            plan_pictures::add(&mut report, plan, inputs, progress, cancel).map_err(|e| e.to_string())?;
            cancel.check().map_err(|e| e.to_string())?;
            plan_files::write(folder, plan, inputs, &post, &mut report).map_err(|e| e.to_string())
        });
        if let Err(why) = self.core.pipeline.start_export(folder, write) {
            self.dialog = Dialog::Error("Nothing was exported".to_owned(), why);
        }
    }

    fn write_picture(&mut self, path: &Path) {
        let (scene, camera) = self.viewport.picture();
        // A picture has nothing else that tells the axes.
        let scene = Scene { triad: true, ..(**scene).clone() };
        let picture = crate::render::offscreen::Offscreen::new()
            .and_then(|mut o| o.png(&scene, camera, [1920, 1200], &crate::progress::Cancel::default()))
            .map_err(|e| e.to_string());
        let written = picture.and_then(|bytes| {
            crate::mesh_io::atomic_write(path, |out| out.write_all(&bytes)).map_err(|e| e.to_string())
        });
        match written {
            Ok(()) => self.core.say(EventKind::Done, format!("picture written to {}", path.display())),
            Err(e) => self.dialog = Dialog::Error("The picture was not written".to_owned(), e),
        }
    }

    fn answer(&mut self, answer: Answer, ctx: &egui::Context) {
        let dialog = std::mem::take(&mut self.dialog);
        match (answer, dialog) {
            (Answer::SaveThen(intent), _) => {
                self.after_save = Some(intent);
                self.save(ctx);
            }
            (Answer::Discard(intent), _) => self.carry_out(intent, ctx),
            (Answer::Recover(i), Dialog::Recover(mut copies)) => {
                let copy = copies.remove(i);
                match copy.document() {
                    Ok(document) => {
                        self.replace(document);
                        self.autosave_now();
                        copy.discard();
                        self.core.say(EventKind::Done, "unsaved work was recovered");
                    }
                    Err(e) => self.dialog = Dialog::Error("The copy cannot be read".to_owned(), e.to_string()),
                }
            }
            (Answer::ForgetCopies, Dialog::Recover(copies)) => copies.iter().for_each(Recovery::discard),
            (Answer::Locate(old), dialog) => {
                self.dialog = dialog;
                let title = format!("Where is {}?", old.display());
                self.files.ask(Purpose::MovedMesh(old), &title, self.folder().as_deref(), ctx);
            }
            (Answer::OpenAnyway, dialog) => {
                self.dialog = dialog;
                self.open_anyway();
            }
            (Answer::Path(purpose, path), _) => {
                self.dialog = std::mem::take(&mut self.behind);
                self.chosen(purpose, path, ctx);
            }
            (Answer::Close, Dialog::Path(..)) => self.dialog = std::mem::take(&mut self.behind),
            (Answer::ExportTo, _) => self.files.ask(Purpose::ExportFolder, "", self.folder().as_deref(), ctx),
            _ => {}
        }
    }

    fn autosave_now(&mut self) {
        self.autosaved = Instant::now();
        let Some(autosave) = &mut self.autosave else { return };
        if let Err(e) = autosave.update(&self.core.document) {
            self.core.say(EventKind::Failed, format!("no copy of the unsaved work could be kept: {e}"));
            self.autosave = None;
        }
    }

    fn run(&mut self, command: Command, ctx: &egui::Context) {
        if !command.is_enabled(&self.core) {
            return;
        }
        let now = ctx.input(|i| i.time);
        match command {
            Command::NewDemonstration => self.intend(Intent::Demonstration, ctx),
            Command::Open => self.intend(Intent::AskOpen, ctx),
            Command::Quit => self.intend(Intent::Quit, ctx),
            Command::Reload => self.core.pipeline.reload(),
            Command::Save => self.save(ctx),
            Command::SaveAs => self.ask_where_to_save(ctx),
            Command::SaveJob => {
                let name = format!("{}.toml", self.core.document.name());
                self.files.ask(Purpose::SaveJob, &name, self.folder().as_deref(), ctx);
            }
            Command::Undo => drop(self.core.document.undo()),
            Command::Redo => drop(self.core.document.redo()),
            Command::Preferences => self.dialog = Dialog::Preferences,
            Command::Plan => self.plan(),
            Command::Cancel => self.core.pipeline.cancel(),
            Command::Approve => self.approve(),
            Command::Withdraw => self.core.pipeline.withdraw(),
            Command::Export => self.dialog = Dialog::Export,
            Command::Step(stage) => self.core.step = stage,
            Command::Screenshot => {
                let name = format!("{}.png", self.core.document.name());
                self.files.ask(Purpose::Picture, &name, self.folder().as_deref(), ctx);
            }
            Command::Theme => {
                let dark = ctx.theme() == egui::Theme::Dark;
                self.core.preferences.theme = if dark { ThemeChoice::Light } else { ThemeChoice::Dark };
            }
            Command::Palette => self.palette.toggle(),
            Command::Log => self.log_open = !self.log_open,
            Command::About => self.dialog = Dialog::About,
            Command::Ghost => self.core.toggle_ghost(),
            Command::Fit => self.viewport.fit(false),
            Command::View(view) => self.viewport.look(view, now),
            Command::Projection => self.viewport.toggle_projection(),
            Command::IntoChannel => {
                self.core.layers.into_channel();
                self.viewport.look_into_channel(&self.core, now);
            }
            Command::WholeBlisk => {
                self.core.layers.whole_blisk();
                self.viewport.look(crate::render::view::StandardView::Isometric, now);
            }
            Command::Section => self.toggle_section(),
            Command::Measure => {
                self.core.measuring = !self.core.measuring;
                self.viewport.clear_probe();
            }
            Command::Colours => self.core.colours = !self.core.colours,
            Command::Play | Command::NextNode | Command::PreviousNode | Command::FirstNode | Command::LastNode => {
                self.step_along(command);
            }
        }
    }

    fn plan(&mut self) {
        match self.core.pipeline.start_plan() {
            Ok(()) => {
                self.core.step = self.core.step.max(Stage::Plan);
                self.tab = if self.tab == Tab::Table { Tab::Table } else { Tab::Positions };
            }
            Err(why) => self.dialog = Dialog::Error("The plan cannot be started".to_owned(), why),
        }
    }

    fn approve(&mut self) {
        match self.core.pipeline.approve() {
            Ok(()) => self.core.say(EventKind::Done, "the plan is approved"),
            Err(why) => self.dialog = Dialog::Error("Not approved".to_owned(), why),
        }
    }

    fn step_along(&mut self, command: Command) {
        let track = self.core.shared_track();
        let cursor = &mut self.core.cursor;
        if command == Command::Play {
            cursor.playing = !cursor.playing;
            if cursor.playing && cursor.s <= 0.0 {
                cursor.s = track.length();
            }
            return;
        }
        cursor.playing = false;
        cursor.s = match command {
            Command::NextNode => track.next_node(cursor.s),
            Command::PreviousNode => track.previous_node(cursor.s),
            Command::FirstNode => track.length(),
            _ => 0.0,
        };
    }

    fn toggle_section(&mut self) {
        self.core.section = match (self.core.section, self.core.pipeline.part()) {
            (None, Some(part)) => {
                // Across the channel's middle where one is known: that is what one wants to look into.
                let plane = self.core.pipeline.channel().map(|found| {
                    let frame = &found.channel.frame;
                    let [low, high] = found.channel.span_x();
                    let middle = 0.5 * (low + high);
                    let (hub, shroud) = found.channel.radii_at(middle);
                    let point = glam::DVec3::new(middle, 0.0, 0.5 * (hub + shroud));
                    SectionPlane { point: frame.to_parent(point), normal: frame.x }
                });
                plane.or(Some(SectionPlane { point: part.mesh.bounds().center(), normal: glam::DVec3::X }))
            }
            _ => None,
        };
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
        if let Some(path) = dropped.into_iter().next() {
            self.intend(Intent::Open(path), ctx);
        }
        match self.files.chosen() {
            Some(Chosen::Path(purpose, path)) => self.chosen(purpose, path, ctx),
            Some(Chosen::NoDialogs(purpose)) => {
                let start = self.folder().map(|f| f.join("").display().to_string()).unwrap_or_default();
                self.behind = std::mem::replace(&mut self.dialog, Dialog::Path(purpose, start));
            }
            None => {}
        }
        if ctx.input(|i| i.viewport().close_requested()) && !self.quitting && self.core.document.is_unsaved() {
            ctx.send_viewport_cmd(egui::ViewportCommand::CancelClose);
            self.dialog = Dialog::Unsaved(Intent::Quit);
        }
        if matches!(self.dialog, Dialog::None) {
            Command::pressed(ctx).into_iter().for_each(|c| self.core.push(c));
        }
    }

    fn panels(&mut self, ui: &mut Ui) {
        let opened = Panel::top("menu").show(ui, |ui| menu::show(ui, &mut self.core)).inner;
        if let Some(path) = opened {
            self.intend(Intent::Open(path), &ui.ctx().clone());
        }
        Panel::bottom("status").exact_size(26.0).show(ui, |ui| status::show(ui, &mut self.core));
        // In a small window, or one drawn large, the view comes first: what can be spared gives way to it.
        let room = ui.available_size();
        let (wide, tall) = (room.x > 900.0, room.y > 480.0);
        let left = if wide { 356.0 } else { (0.46 * room.x).clamp(240.0, 356.0) };
        let request = Panel::left("step")
            .default_size(left)
            .size_range(left..=left.max(460.0).min(0.5 * room.x).max(left))
            .show(ui, |ui| stepper::show(ui, &mut self.core))
            .inner;
        if request == Some(Request::ElectrodeMesh) {
            let ctx = ui.ctx().clone();
            self.files.ask(Purpose::ElectrodeMesh, "Your own electrode", self.folder().as_deref(), &ctx);
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
            ui.add_space(2.0);
            timeline::show(ui, &mut self.core);
            if tall {
                ui.add_space(2.0);
                plots::show(ui, &mut self.core, &mut self.tab, &mut self.curves);
            }
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

    fn retitle(&mut self, ctx: &egui::Context) {
        let mark = if self.core.document.is_unsaved() { "*" } else { "" };
        let title = format!("{}{mark} - Sparkpath", self.core.document.name());
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
        if self.autosaved.elapsed() > AUTOSAVE {
            self.autosave_now();
        }
        if self.core.document.is_unsaved() {
            ctx.request_repaint_after(AUTOSAVE);
        }
        if self.core.pipeline.is_busy() {
            // Time left and elapsed go on even while nothing is reported.
            ctx.request_repaint_after(Duration::from_millis(250));
        }
        self.slowest_frame = self.slowest_frame.max(started.elapsed().as_secs_f64());
    }

    fn on_exit(&mut self) {
        if self.core.document.is_unsaved() && !self.quitting {
            self.autosave_now();
        }
    }
}
