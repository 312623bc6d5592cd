//! The workspace of blisks.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use egui::{Panel, Ui};

use crate::workspaces::blisk::commands::BliskCommand;
use crate::workspaces::blisk::desk::BliskDesk;
use crate::workspaces::blisk::desk::picks::Picked;
use crate::workspaces::blisk::document::job_file::PlanJob;
use crate::workspaces::blisk::document::job_file::field_table::FIELDS;
use crate::workspaces::blisk::document::machine_file::read_machine;
use crate::workspaces::blisk::document::stage::Stage;
use crate::workspaces::blisk::document::{Document, demonstration, kept_plan};
use crate::workspaces::blisk::export;
use crate::workspaces::blisk::job::stages::{self, Part};
use crate::workspaces::blisk::panels::dialogs::Answer;
use crate::workspaces::blisk::panels::forms::{self, Request as FormRequest};
use crate::workspaces::blisk::panels::plots::{self, Curves, Tab};
use crate::workspaces::blisk::panels::view::BliskView;
use crate::workspaces::blisk::panels::{dialogs, inspector, stepper, timeline};
use crate::workspaces::blisk::paths::BliskPath;
use crate::workspaces::blisk::work::ElectrodeTable;
use crate::workspaces::blisk::work::release::ExportWork;
use crate::workspaces::commands::{Command, CommandInfo, CommandSet, Commanded, FrameCommand, Groups};
use crate::workspaces::context::{Context, LogLine, PathSet, Request, first, is_project, status_sentence};
use crate::workspaces::hands::Hands;
use crate::workspaces::message::Message;
use crate::workspaces::moved_files;
use crate::workspaces::news::EventKind;
use crate::workspaces::opening::{Incoming, NotOpened, Opening, Source};
use crate::workspaces::technology::{TableChange, TechnologyWindow, read_table, take_first_unless_known};
use crate::workspaces::workspace::{About, Menu, Standing, Workspace, held_in_fields};
use files::{AnyDocument, Params as _, Recovery};
use nc::post::Post;
use nc::template::JobSheet;
use render::view::StandardView;
use task::{Scheduler, State, Task};

static ABOUT: About =
    About { id: "blisk", name: "Blisk", switch: CommandInfo::new("Workspace: blisk feed"), menu: "Plan" };

/// Replacement of the document, done once unsaved work is dealt with.
enum Pending {
    Open(PathBuf),
    AskOpen,
    Demonstration,
    /// A document that was read with its part.
    Take(Arc<Incoming<PlanJob, Arc<Part>>>),
}

/// The workspace of blisks.
pub struct BliskWorkspace {
    /// The document and the results made from it.
    pub desk: BliskDesk,
    view: BliskView,
    curves: Curves,
    tab: Tab,
    opening: Opening<Pending, PlanJob, Arc<Part>>,
    /// The parameter that the mesh of an electrode of one's own is asked for.
    own_mesh_key: String,
    /// Window of the technology table.
    technology: TechnologyWindow,
}

impl BliskWorkspace {
    /// The workspace with the demonstration blisk.
    pub fn new(scheduler: &Scheduler) -> Self {
        Self {
            desk: BliskDesk::new(demonstration(), scheduler),
            view: BliskView::default(),
            curves: Curves::default(),
            tab: Tab::Positions,
            opening: Opening::new(scheduler),
            own_mesh_key: String::new(),
            technology: TechnologyWindow::default(),
        }
    }

    /// Reads a document with its part, which then replaces the present one.
    fn begin(&mut self, source: Source<PlanJob>) {
        self.opening.begin(source, |document, task| {
            kept_plan::check(document).map_err(|why| {
                let file = document.file().map_or_else(String::new, |file| format!("{}: ", file.display()));
                NotOpened::Document(format!("{file}{why}"))
            })?;
            Ok(Arc::new(stages::load(document.params(), task)?))
        });
    }

    /// Replaces the present document by the one that was read.
    fn take(&mut self, opened: &Incoming<PlanJob, Arc<Part>>, cx: &mut Context) {
        self.replace(opened.document.clone(), opened.loaded.clone(), cx);
        opened.copy.iter().for_each(|copy| cx.request(Request::Recovered(copy.clone())));
    }

    /// Replaces the present document.
    pub fn replace(&mut self, document: Document, part: Option<Arc<Part>>, cx: &mut Context) {
        let desk = &mut self.desk;
        desk.work.reset(document.params(), part);
        desk.document = document;
        desk.step = Stage::Part;
        desk.cursor.s = 0.0;
        desk.section = None;
        desk.ghosts.clear();
        desk.kept.forget();
        desk.picking = Default::default();
        desk.layers = Default::default();
        // Another part is looked at as the first one was.
        self.view = BliskView::default();
        cx.request(Request::Show);
        let document = &self.desk.document;
        if let Some(path) = document.file().or(document.params().blisk.file()) {
            cx.opened(path);
        }
        // What was said last is of another part.
        cx.say(EventKind::Done, format!("opened {}", self.desk.document.name()));
    }

    fn plan(&mut self, cx: &mut Context) {
        // Its form marks the value and says what it may be.
        if let Some(stage) = Stage::ALL.into_iter().find(|stage| forms::has_problem(&self.desk, *stage)) {
            self.desk.step = stage;
            let text = format!("Step {} has a value out of range; it is marked there.", stage.name());
            return cx.error("The plan cannot be started", text);
        }
        match self.desk.work.start_plan() {
            Ok(()) => {
                self.desk.step = self.desk.step.max(Stage::Plan);
                cx.say(EventKind::Done, "planning");
                self.tab = if self.tab == Tab::Table { Tab::Table } else { Tab::Positions };
            }
            Err(why) => cx.error("The plan cannot be started", why),
        }
    }

    /// Plans and verifies the previewed path once the user has stopped editing.
    fn plan_at_rest(&mut self, cx: &mut Context, hands: Hands) {
        if hands == Hands::Holding || !self.desk.can_plan() {
            return;
        }
        match self.desk.work.is_at_rest(cx.now) {
            Ok(()) => match self.desk.work.start_plan() {
                Ok(()) => cx.say(EventKind::Done, "planning the previewed path"),
                Err(why) => cx.say(EventKind::Failed, why),
            },
            Err(Some(wait)) => cx.wake_after(wait),
            Err(None) => {}
        }
    }

    fn release(&mut self, cx: &mut Context) {
        match self.desk.work.release() {
            Ok(()) => cx.say(EventKind::Done, "the plan is released for export"),
            Err(why) => cx.error("Not released", why),
        }
    }

    fn run_own(&mut self, command: BliskCommand, cx: &mut Context, now: f64) {
        let (desk, view) = (&mut self.desk, &mut self.view);
        match command {
            BliskCommand::NewDemonstration => self.opening.intend(Pending::Demonstration, cx),
            BliskCommand::Plan => self.plan(cx),
            BliskCommand::Release => self.release(cx),
            BliskCommand::Withdraw => desk.work.withdraw(),
            BliskCommand::Ghost => desk.toggle_ghost(),
            BliskCommand::Keep => desk.keep(cx),
            BliskCommand::Section => desk.toggle_section(),
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
            BliskCommand::Colours => {
                desk.colours = !desk.colours;
                desk.surfaces &= !desk.colours;
            }
            BliskCommand::Surfaces => desk.toggle_surfaces(),
            BliskCommand::Pick(of) => {
                desk.toggle_picking(of);
                view.clear_probe();
            }
            BliskCommand::Unpick => desk.remove_last_picked(),
            BliskCommand::ShowRefusal => view.fly_to_refusal(desk, now),
            BliskCommand::ResidualStock => {
                desk.toggle_residual_stock();
                if desk.residual_stock {
                    view.look_into_channel(desk, now);
                }
            }
            BliskCommand::Deviations => {
                desk.toggle_deviations();
                if desk.deviations {
                    view.look_into_channel(desk, now);
                }
            }
            BliskCommand::MillFlanks => {
                if let Some(part) = desk.electrode_to_mill() {
                    cx.request(Request::Send(Message::MillFlanks(part.into())));
                }
            }
            BliskCommand::Technology => self.technology.toggle(),
            BliskCommand::Step(stage) => desk.step = stage,
        }
    }

    /// Sets the post of this file, or shows why the file is no post.
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

    /// Sets the template of the job sheet of this file, or shows why the file is none.
    pub fn take_job_sheet(&mut self, path: &Path, cx: &mut Context) {
        match JobSheet::read(path) {
            Ok(_) => {
                let mut job = self.desk.document.params().clone();
                job.export.job_sheet = path.to_string_lossy().into_owned();
                self.desk.edit("Files Job sheet", job, false);
            }
            Err(error) => cx.error("This is no template of a job sheet", error.to_string()),
        }
    }

    /// Sets the file of the parameter under `key`, or shows why it cannot be set.
    fn take_file(&mut self, label: &str, key: &str, path: &Path, cx: &mut Context) {
        match FIELDS.set(self.desk.document.params(), key, &path.to_string_lossy()) {
            Ok(job) => self.desk.edit(label, job, false),
            Err(error) => cx.error("The file cannot be set", error.to_string()),
        }
    }

    /// Sets the technology table of the file `path`, or shows why the file is none. A table without the present technology
    /// sets its first one.
    pub fn take_technology(&mut self, path: &Path, cx: &mut Context) {
        let mut job = self.desk.document.params().clone();
        job.technology.table = path.to_string_lossy().into_owned();
        match read_table(&job.technology) {
            Ok(table) => {
                take_first_unless_known(&mut job.technology, &table);
                self.desk.edit("Technology table", job, false);
            }
            Err(error) => cx.error("This is no technology table", error.to_string()),
        }
    }

    /// Draws the window of the technology table, and takes its changes in.
    fn show_technology(&mut self, ui: &Ui, cx: &mut Context) {
        let paths = [BliskPath::Technology, BliskPath::TechnologyCopy];
        let change = self.technology.show(ui, &self.desk.document.params().technology, cx, paths);
        if let Some(TableChange::Use(id)) = &change {
            let mut job = self.desk.document.params().clone();
            job.technology.id.clone_from(id);
            self.desk.edit("Technology", job, false);
        }
        if change.is_some() {
            self.desk.work.recompute_burning();
        }
    }

    /// Sets the machine of the file `path`, or shows why the file is no machine.
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

    /// Writes the files of the released plan into `folder`, or shows why that is not possible.
    pub fn export(&mut self, folder: &Path, cx: &mut Context) {
        let write: ExportWork = Box::new(|folder, released, inputs, files, task| {
            let exported = export::export(folder, released.plan(), inputs, files, task);
            exported.map(|(report, _)| report.written).map_err(|e| e.to_string())
        });
        if let Err(why) = self.desk.work.start_export(folder, write) {
            cx.error("Nothing was exported", why);
        }
    }
}

impl Commanded for BliskWorkspace {
    fn is_enabled(&self, command: Command) -> bool {
        self.opening.is_ended_by(command) || self.desk.is_enabled(command)
    }

    fn why_not(&self, command: Command) -> Option<&'static str> {
        if FrameCommand::of(command) != Some(FrameCommand::Export) {
            return command.info.needs;
        }
        Some(match self.desk.work.state(Stage::Plan) {
            State::Ready if self.desk.work.can_release() => "release the plan first",
            State::Ready => "the plan cannot be released: see its checks",
            State::Running => "wait for the plan, and release it first",
            State::Stale => "the plan is out of date: plan again and release first",
            _ => "plan and release first",
        })
    }
}

impl Workspace for BliskWorkspace {
    held_in_fields!(BliskCommand);

    fn menu(&self, menu: Menu) -> Groups {
        use BliskCommand as C;
        let of = C::group;
        match menu {
            Menu::New => vec![of(&[C::NewDemonstration])],
            Menu::Save => Vec::new(),
            Menu::Own => {
                let first = [C::Plan.into(), FrameCommand::Cancel.into(), C::Keep.into()];
                let picks = of(&Picked::ALL.map(C::Pick));
                vec![[&first[..], &of(&[C::Release, C::Withdraw])].concat(), picks, of(&[C::Technology, C::MillFlanks])]
            }
            Menu::View => {
                vec![
                    of(&[C::Section, C::IntoChannel, C::WholeBlisk]),
                    of(&[C::Measure, C::Colours, C::ResidualStock, C::Surfaces]),
                ]
            }
        }
    }

    fn run(&mut self, command: Command, cx: &mut Context, now: f64) {
        use FrameCommand as F;
        if let Some(command) = BliskCommand::of(command) {
            return self.run_own(command, cx, now);
        }
        match F::of(command) {
            Some(F::Open) => self.opening.intend(Pending::AskOpen, cx),
            Some(F::Reload) => self.desk.work.reload(),
            Some(F::Cancel) if self.opening.is_busy() => self.opening.cancel(),
            Some(F::Cancel) if self.desk.picking().is_some() => self.desk.picking = Default::default(),
            Some(F::Cancel) => self.desk.work.cancel(),
            Some(F::Export) => {
                self.opening.moved.forget();
                cx.request(Request::Dialog);
            }
            Some(along @ (F::Play | F::NextNode | F::PreviousNode | F::FirstNode | F::LastNode)) => {
                self.desk.step_along(along);
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
            Some(FormRequest::Sections) => cx.ask(BliskPath::Sections, ""),
            Some(FormRequest::ElectrodeMesh(key)) => {
                self.own_mesh_key = key;
                cx.ask(BliskPath::ElectrodeMesh, "");
            }
            Some(FormRequest::Post) => cx.ask(BliskPath::Post, ""),
            Some(FormRequest::JobSheet) => cx.ask(BliskPath::JobSheet, ""),
            Some(FormRequest::Machine) => cx.ask(BliskPath::Machine, ""),
            Some(FormRequest::Technology) => cx.ask(BliskPath::Technology, ""),
            Some(FormRequest::Scan) => cx.ask(BliskPath::Scan, ""),
            Some(FormRequest::Blank) => cx.ask(BliskPath::Blank, ""),
            Some(FormRequest::Presets) => cx.ask(BliskPath::Presets, ""),
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
        self.show_technology(ui, cx);
    }

    fn status(&mut self, ui: &mut Ui, cx: &mut Context, is_shown: bool) {
        if let Some(now) = self.doing().filter(|_| is_shown) {
            cx.doing(ui, now);
        }
        // The search for a table goes on beside everything else, whichever step is open.
        let work = &mut self.desk.work;
        for (table, name, found) in [
            (ElectrodeTable::Sizes, "Sizes", work.sizes().0.len()),
            (ElectrodeTable::Sets, "Sets", work.sets().0.len()),
        ] {
            let Some(doing) = work.searching(table) else { continue };
            if ui.small_button("Stop").on_hover_text("Stop the search; what was found stays").clicked() {
                work.stop_search(table);
            }
            status_sentence(ui, 200.0, &format!("{name}, {found} found: {doing}"));
            ui.separator();
        }
    }

    fn triangles(&self) -> Option<usize> {
        self.desk.work.part().map(|part| part.mesh.triangles.len())
    }

    fn follow(&mut self, cx: &mut Context, hands: Hands, seconds: f64, is_shown: bool) {
        if let Some(opened) = self.opening.take(cx) {
            self.opening.go_on(Pending::Take(opened), cx);
        }
        // Nothing is made of a blisk that nobody has looked at.
        if !is_shown && self.desk.work.state(Stage::Part) == State::Missing {
            return;
        }
        self.desk.follow(cx, is_shown);
        self.plan_at_rest(cx, hands);
        if self.desk.advance(std::time::Duration::from_secs_f64(seconds)) {
            cx.wake_after(std::time::Duration::ZERO);
        }
    }

    fn is_busy(&self) -> bool {
        self.opening.is_busy() || self.desk.is_busy()
    }

    fn near(&self) -> Option<&Path> {
        self.desk.document.file().or(self.desk.document.params().blisk.file())
    }

    fn open(&mut self, path: &Path, cx: &mut Context) {
        if is_project(path) {
            self.begin(Source::Project(path.to_owned()));
        } else {
            self.replace(Document::new(PlanJob::for_mesh(path)), None, cx);
        }
    }

    fn take_files(&mut self, files: &[PathBuf], cx: &mut Context) {
        self.opening.intend(Pending::Open(first(files).to_owned()), cx);
    }

    fn proceed(&mut self, cx: &mut Context) {
        match self.opening.pending.take() {
            Some(Pending::Open(path)) if is_project(&path) => self.begin(Source::Project(path)),
            Some(Pending::Open(path)) => self.begin(Source::There(Box::new(Document::new(PlanJob::for_mesh(&path))))),
            Some(Pending::AskOpen) => cx.ask(BliskPath::Open, ""),
            Some(Pending::Demonstration) => self.replace(demonstration(), None, cx),
            Some(Pending::Take(opened)) => self.take(&opened, cx),
            None => {}
        }
    }

    fn recover(&mut self, copy: Recovery, _cx: &mut Context) {
        self.begin(Source::Copy(copy));
    }

    fn take_parameters(&mut self, file: &Path, label: &str) -> Result<(), String> {
        let project = Document::open(file).map_err(|error| error.to_string())?;
        self.desk.edit(label, project.params().clone(), false);
        Ok(())
    }

    fn take_path(&mut self, number: usize, path: PathBuf, cx: &mut Context) {
        match BliskPath::at(number) {
            Some(BliskPath::Open) => self.opening.go_on(Pending::Open(path), cx),
            Some(BliskPath::ExportFolder) => self.export(&path, cx),
            Some(BliskPath::ElectrodeMesh) => {
                let key = std::mem::take(&mut self.own_mesh_key);
                self.take_file("Own electrode", &key, &path, cx);
            }
            Some(BliskPath::Sections) => self.take_file("Sections", "blisk.sections.file", &path, cx),
            Some(BliskPath::Post) => self.take_post(&path, cx),
            Some(BliskPath::JobSheet) => self.take_job_sheet(&path, cx),
            Some(BliskPath::Machine) => self.take_machine(&path, cx),
            Some(BliskPath::Presets) => self.take_file("Presets", "setup.presets", &path, cx),
            Some(BliskPath::Blank) => self.take_file("Blank", "burning.blank", &path, cx),
            Some(BliskPath::Scan) => self.take_file("Scan", "scan.file", &path, cx),
            Some(BliskPath::Technology) => self.take_technology(&path, cx),
            Some(BliskPath::TechnologyCopy) if self.technology.write_copy(&path, cx) => self.take_technology(&path, cx),
            Some(BliskPath::TechnologyCopy) => {}
            Some(BliskPath::MovedFile) => {
                let found = self.opening.moved.found(&path, cx);
                found.into_iter().for_each(|found| self.begin(Source::There(Box::new(found))));
            }
            None => {}
        }
    }

    fn dialog_title(&self) -> &'static str {
        if self.opening.moved.is_asking() { moved_files::TITLE } else { "Export" }
    }

    fn dialog(&mut self, ui: &mut Ui, cx: &mut Context) -> bool {
        if self.opening.moved.is_asking() {
            let opened = self.opening.moved.dialog(ui, cx, BliskPath::MovedFile);
            opened.into_iter().for_each(|document| self.begin(Source::There(Box::new(document))));
            return !self.opening.moved.is_asking();
        }
        match dialogs::export(ui, &mut self.desk) {
            Some(Answer::OwnPost) => cx.ask(BliskPath::Post, ""),
            Some(Answer::Folder) => {
                cx.ask(BliskPath::ExportFolder, "");
                return true;
            }
            Some(Answer::Close) => return true,
            None => {}
        }
        false
    }

    fn receive(&mut self, message: &Message, _cx: &mut Context) -> bool {
        let Message::TechnologyTable(table) = message else { return false };
        if self.technology.is_changed(&self.desk.document.params().technology, table) {
            self.desk.work.recompute_burning();
        }
        false
    }

    fn standing(&self, line: &LogLine) -> Standing {
        let stage = Stage::ALL.into_iter().find(|stage| Some(stage.number()) == line.topic);
        let state = |stage| self.desk.work.state(stage);
        let is_over = match (line.kind, stage) {
            // What a change does not touch has failed as before.
            (EventKind::Failed, Some(stage)) => !matches!(state(stage), State::Failed(_)),
            (EventKind::Refused, Some(stage)) => !matches!(state(stage), State::Failed(_) | State::Ready),
            // A change that is undone brings back what was made before, of which the line does not tell.
            (EventKind::Done, Some(stage)) => {
                self.desk.work.sentence(stage).is_some_and(|now| !line.text.ends_with(&now))
            }
            (EventKind::Cancelled, Some(_)) | (EventKind::Done, None) => false,
            (_, None) => line.is_of_other(self.revision()),
        };
        if is_over { Standing::Over } else { Standing::Current }
    }
}
