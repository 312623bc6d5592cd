//! The workspace of blisks as the window knows it.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use egui::{Panel, ProgressBar, RichText, Ui};

use crate::widgets::panel_parts::doing;
use crate::widgets::theme::palette;
use crate::widgets::viewport::Viewport;
use crate::workspaces::blisk::commands::BliskCommand;
use crate::workspaces::blisk::desk::{BliskDesk, BliskDialog};
use crate::workspaces::blisk::document::job_file::PlanJob;
use crate::workspaces::blisk::document::machine_file::read_machine;
use crate::workspaces::blisk::document::stage::Stage;
use crate::workspaces::blisk::document::{Document, demonstration, kept_plan};
use crate::workspaces::blisk::export;
use crate::workspaces::blisk::job::stages::{self, Part};
use crate::workspaces::blisk::panels::forms::{self, Request as FormRequest};
use crate::workspaces::blisk::panels::plots::{self, Curves, Tab};
use crate::workspaces::blisk::panels::view::BliskView;
use crate::workspaces::blisk::panels::{export_dialog, inspector, moved_dialog, stepper, timeline};
use crate::workspaces::blisk::pipeline::{ExportWork, StageState};
use crate::workspaces::commands::{Command, CommandInfo, CommandSet, Commanded, FrameCommand, Groups};
use crate::workspaces::context::{Context, LogLine, MESHES, PathInfo, PathKind, PathSet, Request, first, is_project};
use crate::workspaces::hands::Hands;
use crate::workspaces::message::Message;
use crate::workspaces::news::EventKind;
use crate::workspaces::opening::Opening;
use crate::workspaces::workspace::{About, Menu, Standing, Workspace};
use files::{AnyDocument, Params as _, Recovery};
use nc::post::Post;
use render::scene::SectionPlane;
use render::view::StandardView;
use task::{Scheduler, Task};

static ABOUT: About =
    About { id: "blisk", name: "Blisk", switch: CommandInfo::new("Workspace: blisk feed"), menu: "Plan" };

/// What the workspace asks paths for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum BliskPath {
    /// Project or mesh to open.
    Open,
    /// Folder for the exported files.
    ExportFolder,
    /// An electrode mesh of one's own.
    ElectrodeMesh,
    /// An NC post of one's own.
    Post,
    /// A machine file of one's own.
    Machine,
    /// A file of a project that is elsewhere now.
    MovedFile,
}

impl PathSet for BliskPath {
    fn table() -> &'static [(Self, PathInfo)] {
        use BliskPath as P;
        const TOML: &[&str] = &["toml"];
        const OPEN: &[&str] = &["stl", "STL", "obj", "OBJ", "gltf", "glb", "GLTF", "GLB", "sparkpath"];
        const fn info(title: &'static str, kind: PathKind) -> PathInfo {
            PathInfo { title, kind, opens: false }
        }
        static TABLE: [(P, PathInfo); 6] = [
            (
                P::Open,
                PathInfo {
                    title: "Open a project or a mesh",
                    kind: PathKind::Read("Projects and meshes", OPEN, false),
                    opens: true,
                },
            ),
            (P::ExportFolder, info("Folder for the exported files", PathKind::Folder)),
            (P::ElectrodeMesh, info("Your own electrode", PathKind::Read("Meshes", MESHES, false))),
            (P::Post, info("Your own NC post", PathKind::Read("Post", TOML, false))),
            (P::Machine, info("Your own machine", PathKind::Read("Machine", TOML, false))),
            (P::MovedFile, info("Find the file", PathKind::Read("Files", &[], false))),
        ];
        &TABLE
    }
}

/// What takes the place of the document once nothing stands in the way.
enum Pending {
    Open(PathBuf),
    AskOpen,
    Demonstration,
    /// A document that was read with its part.
    Take(Arc<(Document, Arc<Part>)>),
}

/// The workspace of blisks.
pub struct BliskWorkspace {
    /// The document and what has been made of it.
    pub desk: BliskDesk,
    view: BliskView,
    curves: Curves,
    tab: Tab,
    pending: Option<Pending>,
    opening: Opening<(Document, Arc<Part>)>,
    /// The file that is looked for.
    locating: Option<PathBuf>,
}

impl BliskWorkspace {
    /// The workspace on the demonstration blisk. `wake` is called when there is something to be shown.
    ///
    /// # Errors
    /// If the system gives no thread to work on.
    pub fn new(scheduler: &Scheduler, wake: impl Fn() + Send + Sync + Clone + 'static) -> std::io::Result<Self> {
        Ok(Self {
            desk: BliskDesk::new(demonstration(), scheduler, wake)?,
            view: BliskView::default(),
            curves: Curves::default(),
            tab: Tab::Positions,
            pending: None,
            opening: Opening::new(scheduler),
            locating: None,
        })
    }

    /// Goes on with `pending`, after asking about unsaved work.
    fn intend(&mut self, pending: Pending, cx: &mut Context) {
        self.opening.stop();
        self.pending = Some(pending);
        cx.request(Request::Replace);
    }

    /// Goes on with `pending` on the way to what was asked for before.
    fn go_on(&mut self, pending: Pending, cx: &mut Context) {
        self.pending = Some(pending);
        cx.request(Request::GoOn);
    }

    /// Reads the part of `document`, which then takes the place of the present one.
    fn begin(&mut self, document: Document) {
        self.opening.begin(move |task| {
            let part = stages::load(document.params(), task)?;
            Ok((document.clone(), Arc::new(part)))
        });
    }

    /// The document at `path`, without its part; says why there is none.
    fn document_at(&mut self, path: &Path, cx: &mut Context) -> Option<Document> {
        if !is_project(path) {
            return Some(Document::new(PlanJob::for_mesh(path)));
        }
        let opened = Document::open(path).map_err(|e| e.to_string());
        let readable = |document: Document| match kept_plan::check(&document) {
            Ok(()) => Ok(document),
            Err(why) => Err(format!("{}: {why}", path.display())),
        };
        match opened.and_then(readable) {
            Ok(document) => {
                let moved = document.moved_files();
                if moved.is_empty() {
                    return Some(document);
                }
                self.desk.dialog = Some(BliskDialog::Moved(Box::new(document), moved));
                cx.request(Request::Dialog);
            }
            Err(why) => {
                cx.not_opened(path);
                cx.error("This project cannot be opened", why);
            }
        }
        None
    }

    /// Takes `document` in the place of the present one.
    pub fn replace(&mut self, document: Document, part: Option<Arc<Part>>, cx: &mut Context) {
        let desk = &mut self.desk;
        desk.document = document;
        desk.pipeline.reset(part);
        desk.tuning.forget_sizes();
        desk.step = Stage::Part;
        desk.cursor.s = 0.0;
        desk.section = None;
        desk.ghosts.clear();
        desk.kept.forget();
        desk.layers = Default::default();
        // Another part is looked at as the first one was.
        self.view = BliskView::default();
        cx.request(Request::Show);
        let document = &self.desk.document;
        if let Some(path) = document.file().or(document.params().blisk.mesh.as_deref()) {
            cx.opened(path);
        }
        // What was said last is of another part.
        cx.say(EventKind::Done, format!("{} opened", self.desk.document.name()));
    }

    fn plan(&mut self, cx: &mut Context) {
        // Its form marks the value and says what it may be.
        if let Some(stage) = Stage::ALL.into_iter().find(|stage| forms::has_problem(&self.desk, *stage)) {
            self.desk.step = stage;
            let text = format!("Step {} has a value out of range; it is marked there.", stage.name());
            return cx.error("The plan cannot be started", text);
        }
        match self.desk.pipeline.start_plan() {
            Ok(()) => {
                self.desk.step = self.desk.step.max(Stage::Plan);
                cx.say(EventKind::Done, "planning");
                self.tab = if self.tab == Tab::Table { Tab::Table } else { Tab::Positions };
            }
            Err(why) => cx.error("The plan cannot be started", why),
        }
    }

    /// Plans and verifies what was looked at quickly, once nothing moves any more.
    fn plan_at_rest(&mut self, cx: &mut Context, hands: Hands) {
        if hands == Hands::Holding || !self.desk.can_plan() {
            return;
        }
        match self.desk.tuning.is_at_rest() {
            Ok(()) => match self.desk.pipeline.start_plan() {
                Ok(()) => cx.say(EventKind::Done, "planning the previewed path"),
                Err(why) => cx.say(EventKind::Failed, why),
            },
            Err(Some(wait)) => cx.wake_after(wait),
            Err(None) => {}
        }
    }

    fn release(&mut self, cx: &mut Context) {
        match self.desk.pipeline.release() {
            Ok(()) => cx.say(EventKind::Done, "the plan is released for export"),
            Err(why) => cx.error("Not released", why),
        }
    }

    fn step_along(&mut self, command: FrameCommand) {
        let track = self.desk.shared_track();
        let cursor = &mut self.desk.cursor;
        if command == FrameCommand::Play {
            cursor.playing = !cursor.playing;
            if self.desk.machine.shown().is_some() {
                if cursor.playing && self.desk.machine.advance(0.0) == Some(false) {
                    self.desk.machine.go_to(Some(0.0));
                }
                return;
            }
            if cursor.playing && cursor.s <= 0.0 {
                cursor.s = track.length();
            }
            return;
        }
        self.desk.machine.go_to(None);
        cursor.playing = false;
        cursor.s = match command {
            FrameCommand::NextNode => track.next_node(cursor.s),
            FrameCommand::PreviousNode => track.previous_node(cursor.s),
            FrameCommand::FirstNode => track.length(),
            _ => 0.0,
        };
    }

    fn toggle_section(&mut self) {
        self.desk.section = match (self.desk.section, self.desk.pipeline.part()) {
            (None, Some(part)) => {
                // Across the channel's middle where one is known: that is what one wants to look into.
                let plane = self.desk.pipeline.channel().map(|found| {
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

    fn run_own(&mut self, command: BliskCommand, cx: &mut Context, now: f64) {
        let (desk, view) = (&mut self.desk, &mut self.view);
        match command {
            BliskCommand::NewDemonstration => self.intend(Pending::Demonstration, cx),
            BliskCommand::Plan => self.plan(cx),
            BliskCommand::Release => self.release(cx),
            BliskCommand::Withdraw => desk.pipeline.withdraw(),
            BliskCommand::Ghost => desk.toggle_ghost(),
            BliskCommand::Keep => desk.keep(cx),
            BliskCommand::Section => self.toggle_section(),
            BliskCommand::IntoChannel => {
                desk.layers.into_channel();
                view.look_into_channel(desk, now);
            }
            BliskCommand::WholeBlisk => {
                desk.layers.whole_blisk();
                view.viewport.look(StandardView::Isometric, now);
            }
            BliskCommand::Measure => {
                desk.measuring = !desk.measuring;
                view.clear_probe();
            }
            BliskCommand::Colours => desk.colours = !desk.colours,
            BliskCommand::Leftover => {
                desk.toggle_leftover();
                if desk.leftover {
                    view.look_into_channel(desk, now);
                }
            }
            BliskCommand::MillFlanks => {
                if let Some(part) = desk.electrode_to_mill() {
                    cx.request(Request::Send(Message::MillFlanks(part.into())));
                }
            }
            BliskCommand::Step(stage) => desk.step = stage,
        }
    }

    /// Takes the post in this file, if it is one.
    pub fn take_post(&mut self, path: &Path, cx: &mut Context) {
        let name = path.to_string_lossy().into_owned();
        match Post::named(&name) {
            Ok(_) => {
                let mut job = self.desk.document.params().clone();
                job.export.post = name;
                self.desk.edit("NC program Post-processor", job, false);
            }
            Err(error) => cx.error("This is no post", error.to_string()),
        }
    }

    /// Takes the machine in the file `path`; says why not if it is none.
    pub fn take_machine(&mut self, path: &Path, cx: &mut Context) {
        let name = path.to_string_lossy().into_owned();
        let mut job = self.desk.document.params().clone();
        job.machine.name = name;
        let read = read_machine(&job.machine.name, &Task::default()).map_err(|e| e.to_string());
        let taken = read.and_then(|_| job.complete(&|key| key == "machine.name").map_err(|e| e.remedy));
        match taken {
            Ok(()) => self.desk.edit("Machine Bodies", job, false),
            Err(error) => cx.error("This is no machine", error),
        }
    }

    /// Writes the files of the released plan into `folder`, as the export dialog does; says why not if it cannot.
    pub fn export(&mut self, folder: &Path, cx: &mut Context) {
        let write: ExportWork = Box::new(|folder, released, inputs, files, task| {
            let exported = export::export(folder, released.plan(), inputs, files, task);
            exported.map(|(_, written)| written).map_err(|e| e.to_string())
        });
        if let Err(why) = self.desk.pipeline.start_export(folder, write) {
            cx.error("Nothing was exported", why);
        }
    }

    /// Takes the file at `path` in the place of one that the project to be opened has lost.
    fn found_file(&mut self, path: &Path, cx: &mut Context) {
        let Some(BliskDialog::Moved(document, moved)) = &mut self.desk.dialog else { return };
        let Some(old) = self.locating.take() else { return };
        document.replace_file(&old, path);
        moved.retain(|m| m.path != old);
        if moved.is_empty() {
            self.open_anyway(cx);
        }
    }

    fn open_anyway(&mut self, cx: &mut Context) {
        if let Some(BliskDialog::Moved(document, _)) = self.desk.dialog.take() {
            self.begin(*document);
            cx.request(Request::CloseDialog);
        }
    }
}

impl Commanded for BliskDesk {
    fn is_enabled(&self, command: Command) -> bool {
        use FrameCommand as F;
        if let Some(command) = F::of(command) {
            return match command {
                F::Undo => self.document.undo_label(false).is_some(),
                F::Redo => self.document.undo_label(true).is_some(),
                F::Cancel => self.pipeline.is_busy(),
                F::Export => self.pipeline.released().is_some(),
                F::Play | F::NextNode | F::PreviousNode | F::FirstNode | F::LastNode => !self.track().is_empty(),
                _ => true,
            };
        }
        let Some(command) = BliskCommand::of(command) else { return false };
        match command {
            BliskCommand::Plan => self.can_plan(),
            BliskCommand::Release => self.pipeline.can_release() && self.pipeline.released().is_none(),
            BliskCommand::Withdraw => self.pipeline.released().is_some(),
            BliskCommand::Ghost => !self.track().is_empty() && self.feed_cursor().is_some(),
            BliskCommand::Keep => self.can_keep(),
            BliskCommand::Colours => self.pipeline.state(Stage::Electrode) != StageState::Missing,
            BliskCommand::Leftover => self.leftover_shape().is_some(),
            BliskCommand::MillFlanks => {
                self.pipeline.state(Stage::Electrode) == StageState::Done && self.shown_electrode().is_some()
            }
            _ => true,
        }
    }
}

impl Commanded for BliskWorkspace {
    fn is_enabled(&self, command: Command) -> bool {
        let is_opening = FrameCommand::of(command) == Some(FrameCommand::Cancel) && self.opening.is_busy();
        is_opening || self.desk.is_enabled(command)
    }
}

impl Workspace for BliskWorkspace {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn commands(&self) -> Vec<Command> {
        BliskCommand::all()
    }

    fn menu(&self, menu: Menu) -> Groups {
        use BliskCommand as C;
        let of = |all: &[C]| all.iter().map(|command| command.command()).collect::<Vec<_>>();
        match menu {
            Menu::New => vec![of(&[C::NewDemonstration])],
            Menu::Save => Vec::new(),
            Menu::Own => {
                let first = [C::Plan.into(), FrameCommand::Cancel.into(), C::Keep.into()];
                vec![[&first[..], &of(&[C::Release, C::Withdraw])].concat(), of(&[C::MillFlanks])]
            }
            Menu::View => {
                vec![of(&[C::Section, C::IntoChannel, C::WholeBlisk]), of(&[C::Measure, C::Colours, C::Leftover])]
            }
        }
    }

    fn run(&mut self, command: Command, cx: &mut Context, now: f64) {
        use FrameCommand as F;
        if let Some(command) = BliskCommand::of(command) {
            return self.run_own(command, cx, now);
        }
        match F::of(command) {
            Some(F::Open) => self.intend(Pending::AskOpen, cx),
            Some(F::Reload) => self.desk.pipeline.reload(),
            Some(F::Cancel) if self.opening.is_busy() => self.opening.cancel(),
            Some(F::Cancel) => self.desk.pipeline.cancel(),
            Some(F::Export) => {
                self.desk.dialog = Some(BliskDialog::Export);
                cx.request(Request::Dialog);
            }
            Some(along @ (F::Play | F::NextNode | F::PreviousNode | F::FirstNode | F::LastNode)) => {
                self.step_along(along);
            }
            _ => {}
        }
    }

    fn ui(&mut self, ui: &mut Ui, cx: &mut Context) {
        let (desk, view) = (&mut self.desk, &mut self.view);
        // In a small window, or one drawn large, the view comes first: what can be spared gives way to it.
        let room = ui.available_size();
        let (wide, tall) = (room.x > 900.0, room.y > 480.0);
        let left = if wide { 356.0 } else { (0.46 * room.x).clamp(240.0, 356.0) };
        let request = Panel::left("step")
            .default_size(left)
            .size_range(left..=left.max(460.0).min(0.5 * room.x).max(left))
            .show(ui, |ui| stepper::show(ui, desk, cx))
            .inner;
        match request {
            Some(FormRequest::ElectrodeMesh) => cx.ask(BliskPath::ElectrodeMesh, ""),
            Some(FormRequest::Post) => cx.ask(BliskPath::Post, ""),
            Some(FormRequest::Machine) => cx.ask(BliskPath::Machine, ""),
            None => {}
        }
        if wide {
            Panel::right("inspector")
                .default_size(250.0)
                .size_range(220.0..=380.0)
                .show(ui, |ui| inspector::show(ui, desk, cx, view));
        }
        let name = if tall { "timeline" } else { "timeline alone" };
        let heights = if tall { 150.0..=520.0 } else { 70.0..=70.0 };
        Panel::bottom(name).default_size(250.0).size_range(heights).resizable(tall).show(ui, |ui| {
            let is_beside = tall && plots::table_beside(ui, desk);
            let margin = egui::Margin { right: if is_beside { 8 } else { 0 }, top: 2, ..Default::default() };
            egui::Frame::new().inner_margin(margin).show(ui, |ui| {
                timeline::show(ui, desk, cx);
                if tall {
                    ui.add_space(2.0);
                    plots::show(ui, desk, &mut self.tab, &mut self.curves, is_beside);
                } else {
                    desk.span = None;
                }
                // The panel keeps its height whatever it shows.
                ui.take_available_space();
            });
        });
        egui::CentralPanel::no_frame().show(ui, |ui| view.show(ui, desk, cx));
    }

    fn status(&mut self, ui: &mut Ui, cx: &mut Context, is_shown: bool) {
        if let Some(now) = self.opening.doing().filter(|_| is_shown) {
            doing(ui, now);
        } else if let Some(running) = self.desk.pipeline.running().filter(|_| is_shown).cloned() {
            ui.label(RichText::new(format!("{}: {}", running.stage.name(), running.doing)));
            let bar = ProgressBar::new(running.fraction as f32).desired_width(140.0).desired_height(8.0);
            let response = ui.add(bar);
            let percent = format!("{} {:.0} %", running.doing, 100.0 * running.fraction);
            response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::ProgressIndicator, true, &percent));
            ui.label(RichText::new(format!("{:3.0} %", 100.0 * running.fraction)).monospace());
            if !running.message.is_empty() {
                ui.label(RichText::new(&running.message).color(palette(ui).faint));
            }
            let elapsed = running.since.elapsed().as_secs();
            let left = running.time_left().map(|t| format!(", about {} s left", t.as_secs() + 1)).unwrap_or_default();
            ui.label(RichText::new(format!("{elapsed} s{left}")).color(palette(ui).faint));
            let cancel = ui.small_button("Cancel").on_hover_text(FrameCommand::Cancel.hint(ui.ctx()));
            if cancel.clicked() {
                cx.push(FrameCommand::Cancel);
            }
            ui.separator();
        }
        // Sizing goes on beside everything else, whichever step is open.
        let Some(doing) = self.desk.tuning.sizing().map(str::to_owned) else { return };
        let found = self.desk.tuning.sizes().0.len();
        ui.label(format!("Sizes: {doing}")).on_hover_text("The table grows in the step Electrode");
        ui.label(RichText::new(format!("{found} found")).color(palette(ui).faint));
        if ui.small_button("Stop").on_hover_text("Stop sizing; what was found stays").clicked() {
            self.desk.tuning.stop_sizing();
        }
        ui.separator();
    }

    fn triangles(&self) -> Option<usize> {
        self.desk.pipeline.part().map(|part| part.mesh.triangles.len())
    }

    fn follow(&mut self, cx: &mut Context, hands: Hands, seconds: f64, is_shown: bool) {
        if let Some(opened) = self.opening.take(cx) {
            self.go_on(Pending::Take(opened), cx);
        }
        // Nothing is made of a blisk that nobody has looked at.
        if !is_shown && self.desk.pipeline.state(Stage::Part) == StageState::Missing {
            return;
        }
        self.desk.follow(cx);
        self.plan_at_rest(cx, hands);
        if self.desk.advance(std::time::Duration::from_secs_f64(seconds)) {
            cx.wake_after(std::time::Duration::ZERO);
        }
    }

    fn is_busy(&self) -> bool {
        self.opening.is_busy() || self.desk.pipeline.is_busy()
    }

    fn is_opening(&self) -> bool {
        self.opening.is_busy()
    }

    fn viewport(&self) -> &Viewport {
        &self.view.viewport
    }

    fn viewport_mut(&mut self) -> &mut Viewport {
        &mut self.view.viewport
    }

    fn document(&self) -> &dyn AnyDocument {
        &self.desk.document
    }

    fn document_mut(&mut self) -> &mut dyn AnyDocument {
        &mut self.desk.document
    }

    fn near(&self) -> Option<&Path> {
        self.desk.document.file().or(self.desk.document.params().blisk.mesh.as_deref())
    }

    fn open(&mut self, path: &Path, cx: &mut Context) {
        if let Some(document) = self.document_at(path, cx) {
            self.replace(document, None, cx);
        }
    }

    fn take_files(&mut self, files: &[PathBuf], cx: &mut Context) {
        self.intend(Pending::Open(first(files).to_owned()), cx);
    }

    fn proceed(&mut self, cx: &mut Context) {
        match self.pending.take() {
            Some(Pending::Open(path)) => {
                if let Some(document) = self.document_at(&path, cx) {
                    self.begin(document);
                }
            }
            Some(Pending::AskOpen) => cx.ask(BliskPath::Open, ""),
            Some(Pending::Demonstration) => self.replace(demonstration(), None, cx),
            Some(Pending::Take(opened)) => self.replace(opened.0.clone(), Some(opened.1.clone()), cx),
            None => {}
        }
    }

    fn recover(&mut self, copy: &Recovery, cx: &mut Context) -> Result<(), String> {
        let document = copy.open().map_err(|e| e.to_string())?;
        self.replace(document, None, cx);
        Ok(())
    }

    fn take_path(&mut self, number: usize, path: PathBuf, cx: &mut Context) {
        match BliskPath::at(number) {
            Some(BliskPath::Open) => self.go_on(Pending::Open(path), cx),
            Some(BliskPath::ExportFolder) => self.export(&path, cx),
            Some(BliskPath::ElectrodeMesh) => {
                let mut job = self.desk.document.params().clone();
                job.electrode.mesh = Some(path);
                self.desk.edit("Own electrode", job, false);
            }
            Some(BliskPath::Post) => self.take_post(&path, cx),
            Some(BliskPath::Machine) => self.take_machine(&path, cx),
            Some(BliskPath::MovedFile) => self.found_file(&path, cx),
            None => {}
        }
    }

    fn dialog_title(&self) -> &'static str {
        match self.desk.dialog {
            Some(BliskDialog::Moved(..)) => "Files of this project",
            _ => "Export",
        }
    }

    fn dialog(&mut self, ui: &mut Ui, cx: &mut Context) -> bool {
        match &self.desk.dialog {
            Some(BliskDialog::Export) => match export_dialog::show(ui, &mut self.desk) {
                Some(export_dialog::Answer::OwnPost) => cx.ask(BliskPath::Post, ""),
                Some(export_dialog::Answer::Folder) => {
                    cx.ask(BliskPath::ExportFolder, "");
                    return true;
                }
                Some(export_dialog::Answer::Close) => return true,
                None => {}
            },
            Some(BliskDialog::Moved(document, moved)) => match moved_dialog::show(ui, document.params(), moved) {
                Some(moved_dialog::Answer::Locate(old)) => {
                    let title = format!("Where is {}?", old.display());
                    self.locating = Some(old);
                    cx.ask(BliskPath::MovedFile, &title);
                }
                Some(moved_dialog::Answer::OpenAnyway) => self.open_anyway(cx),
                Some(moved_dialog::Answer::Close) => return true,
                None => {}
            },
            None => return true,
        }
        false
    }

    fn standing(&self, line: &LogLine) -> Standing {
        let stage = Stage::ALL.into_iter().find(|stage| Some(stage.number()) == line.topic);
        let is_failed = |stage| matches!(self.desk.pipeline.state(stage), StageState::Failed(_));
        let is_mended = line.kind == EventKind::Failed && stage.is_some_and(|stage| !is_failed(stage));
        if is_mended { Standing::Over } else { Standing::Current }
    }
}
