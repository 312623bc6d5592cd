//! The workspace of flanks.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use egui::Ui;

use crate::workspaces::commands::{Command, CommandInfo, CommandSet, Commanded, FrameCommand, Groups};
use crate::workspaces::context::{Context, LogLine, PathSet, Request, first, is_project};
use crate::workspaces::flank::commands::FlankCommand;
use crate::workspaces::flank::document::milling_machine_file::read_milling_machines;
use crate::workspaces::flank::document::{FlankDocument, FlankSource, GuideSource, MeshFlank, PathChoice, WallsFile};
use crate::workspaces::flank::electrode_part::flank_of;
use crate::workspaces::flank::panels;
use crate::workspaces::flank::panels::desk::{FlankDesk, Fly};
use crate::workspaces::flank::panels::export;
use crate::workspaces::flank::panels::guides::{is_points_file, pair};
use crate::workspaces::flank::panels::view::FlankView;
use crate::workspaces::flank::paths::FlankPath;
use crate::workspaces::flank::work::{FlankWork, LoadedFlank};
use crate::workspaces::hands::Hands;
use crate::workspaces::message::{ElectrodePart, Message};
use crate::workspaces::moved_files;
use crate::workspaces::news::EventKind;
use crate::workspaces::opening::{Incoming, Opening, Source};
use crate::workspaces::workspace::{About, Menu, Standing, Workspace, held_in_fields};
use files::{AnyDocument, Document, Recovery};
use flank::machine::milling_machine::MillingMachine;
use flank::ruled_surface::Side;
use nc::flank_program::milling_post;
use task::Scheduler;

static ABOUT: About =
    About { id: "flank", name: "Flank", switch: CommandInfo::new("Workspace: flank milling"), menu: "Flank" };

/// Replacement of the flank, done once unsaved work is dealt with.
enum Pending {
    Open(PathBuf),
    /// Another surface to mill.
    Surface(FlankSource),
    /// An electrode whose flanks are milled.
    Electrode(Arc<ElectrodePart>),
    /// A path to be asked for.
    Ask(FlankPath),
    /// A flank that was read.
    Take(Arc<Incoming<FlankDocument, Arc<LoadedFlank>>>),
}

/// The workspace of flanks.
pub struct FlankWorkspace {
    /// The flank and the results made from it.
    pub desk: FlankDesk,
    view: FlankView,
    opening: Opening<Pending, FlankDocument, Arc<LoadedFlank>>,
}

impl FlankWorkspace {
    /// The workspace with a built-in surface.
    pub fn new(scheduler: &Scheduler) -> Self {
        Self { desk: FlankDesk::new(scheduler), view: FlankView::default(), opening: Opening::new(scheduler) }
    }

    /// Reads a flank with the files of its surface, which then replaces the present flank.
    fn begin(&mut self, source: Source<FlankDocument>) {
        self.opening.begin(source, |document, task| Ok(Arc::new(FlankWork::read(document.params(), task)?)));
    }

    /// Replaces the present flank by `opened`.
    fn put(&mut self, opened: &Incoming<FlankDocument, Arc<LoadedFlank>>, cx: &mut Context) {
        self.desk.replace(opened.document.clone());
        if let Some(loaded) = &opened.loaded {
            self.desk.work.put(opened.document.params(), loaded.clone());
        }
        self.tell_of_opened(cx);
        opened.copy.iter().for_each(|copy| cx.request(Request::Recovered(copy.clone())));
    }

    fn tell_of_opened(&self, cx: &mut Context) {
        cx.request(Request::Show);
        let document = &self.desk.document;
        document.file().into_iter().for_each(|file| cx.opened(file));
        cx.say(EventKind::Done, format!("opened {}", document.name()));
    }

    /// Whether a path for `what` replaces the whole flank.
    fn is_another(&self, what: FlankPath) -> bool {
        let source = &self.desk.params().source;
        match what {
            FlankPath::Open => true,
            FlankPath::Mesh => !matches!(source, FlankSource::Mesh(_)),
            FlankPath::Lower | FlankPath::Upper => !matches!(source, FlankSource::Guides { .. }),
            _ => false,
        }
    }

    /// Changes a guide curve. Overrides of the former surface are dropped.
    fn take_guide(&mut self, change: impl FnOnce(&mut GuideSource, &mut GuideSource)) {
        self.edit_flank(|params| {
            if let FlankSource::Guides { lower, upper } = &mut params.source {
                change(lower, upper);
                params.overrides.clear();
            }
        });
    }

    /// Replaces the flank by a flank of `electrode`. Cutter and machine stay.
    fn take_electrode(&mut self, electrode: &ElectrodePart, cx: &mut Context) {
        match flank_of(electrode, self.desk.params()) {
            Ok(params) => {
                self.desk.replace(Document::new(params));
                cx.request(Request::Show);
                cx.say(EventKind::Done, format!("flanks of {} of {}", electrode.name, electrode.of));
            }
            Err(e) => cx.error("Its flanks cannot be milled", e.to_string()),
        }
    }

    /// Takes a file that was dropped or opened: the points of a guide curve, or a part with the flank.
    fn take_file(&mut self, path: &Path, cx: &mut Context) {
        if !is_points_file(path) {
            let mesh = FlankSource::Mesh(MeshFlank::of(path));
            return self.opening.go_on(Pending::Surface(mesh), cx);
        }
        let both = match self.desk.first_guide.take() {
            // Of two after each other the first is the lower one.
            Some(lower) if lower != path => Some([lower, path.to_owned()]),
            _ => pair(path),
        };
        match both {
            Some(both) => self.opening.go_on(Pending::Surface(FlankSource::guides(both)), cx),
            None => self.ask_for_upper(path, cx),
        }
    }

    /// Takes two guides that were dropped together. Their names tell which is the lower one; otherwise the first is.
    fn take_guides(&mut self, files: [PathBuf; 2], cx: &mut Context) {
        let named = pair(&files[0]).filter(|pair| pair.iter().all(|file| files.contains(file)));
        let source = FlankSource::guides(named.unwrap_or(files));
        self.opening.go_on(Pending::Surface(source), cx);
    }

    /// Keeps the lower guide until the upper one is named, because one guide is no surface.
    fn ask_for_upper(&mut self, lower: &Path, cx: &mut Context) {
        self.desk.first_guide = Some(lower.to_owned());
        cx.say_in_passing("This is the lower guide: choose or drop the upper one");
        cx.ask(FlankPath::Upper, "");
    }

    /// Drops the lower guide, because no upper guide was named.
    fn forget_first_guide(&mut self, cx: &mut Context) {
        if self.desk.first_guide.take().is_some() {
            cx.say_in_passing("No upper guide was named: the lower one is not taken either");
        }
    }

    /// Takes another mesh. If the present flank has one, the mesh is replaced and the other parameters stay.
    fn take_mesh(&mut self, path: PathBuf, cx: &mut Context) {
        let FlankSource::Mesh(mesh) = &self.desk.params().source else {
            return self.opening.go_on(Pending::Surface(FlankSource::Mesh(MeshFlank::of(&path))), cx);
        };
        let source = FlankSource::Mesh(MeshFlank { file: path, candidate: 1, kept: None, ..mesh.clone() });
        self.edit_flank(|params| {
            (params.source, params.side) = (source, Side::Automatic);
            params.overrides.clear();
        });
    }

    fn edit_flank(&mut self, change: impl FnOnce(&mut FlankDocument)) {
        let mut params = self.desk.params().clone();
        change(&mut params);
        self.desk.edit(params);
    }

    /// Takes a path that was asked for.
    fn take(&mut self, what: FlankPath, path: PathBuf, cx: &mut Context) {
        match what {
            FlankPath::Open if is_project(&path) => self.opening.go_on(Pending::Open(path), cx),
            FlankPath::Open => self.take_file(&path, cx),
            FlankPath::Mesh => self.take_mesh(path, cx),
            FlankPath::Lower => match (&self.desk.params().source, pair(&path)) {
                (FlankSource::Guides { .. }, _) => self.take_guide(|lower, _| *lower = GuideSource::File(path)),
                (_, Some(both)) => self.opening.go_on(Pending::Surface(FlankSource::guides(both)), cx),
                // One alone is no surface.
                (_, None) => self.ask_for_upper(&path, cx),
            },
            FlankPath::Upper => match (self.desk.first_guide.take(), &self.desk.params().source) {
                (Some(lower), _) => {
                    let source = FlankSource::guides([lower, path]);
                    self.opening.go_on(Pending::Surface(source), cx);
                }
                (None, FlankSource::Guides { .. }) => self.take_guide(|_, upper| *upper = GuideSource::File(path)),
                (None, _) => {}
            },
            FlankPath::Walls => {
                self.edit_flank(|params| params.walls = Some(WallsFile { file: path, units: Default::default() }));
            }
            FlankPath::Machine => self.take_milling_machine(&path, cx),
            FlankPath::Post => match milling_post(&path.to_string_lossy()) {
                Ok(_) => self.edit_flank(|params| params.milling.post = path.to_string_lossy().into_owned()),
                Err(e) => cx.error("This is no post", e.to_string()),
            },
            FlankPath::Folder => self.export(&path, cx),
            FlankPath::MovedFile => {
                let found = self.opening.moved.found(&path, cx);
                found.into_iter().for_each(|found| self.begin(Source::There(Box::new(found))));
            }
        }
    }

    /// Sets the machine of this file. If the file has several, the first one is set and the others are listed.
    fn take_milling_machine(&mut self, file: &Path, cx: &mut Context) {
        let machines = match read_milling_machines(file) {
            Ok(machines) => machines,
            Err(e) => {
                cx.error("This is no milling machine", e.to_string());
                return;
            }
        };
        let name = file.to_string_lossy().into_owned();
        let is_one = machines.len() == 1;
        let named = |machine: &MillingMachine| if is_one { name.clone() } else { format!("{name}#{}", machine.name) };
        let Some(first) = machines.first().map(named) else { return };
        let listed = &mut self.desk.machines;
        for machine in machines.iter().filter(|_| !is_one) {
            let name = named(machine);
            if listed.iter().all(|[other, _]| *other != name) {
                listed.push([name, machine.title.clone()]);
            }
        }
        let mut forgotten = None;
        self.edit_flank(|params| forgotten = params.milling.take_machine(&first));
        if let Some(forgotten) = forgotten {
            cx.say_in_passing(forgotten);
        }
    }

    /// Writes the files of the plan into `folder`, or shows why that is not possible.
    pub fn export(&mut self, folder: &Path, cx: &mut Context) {
        let desk = &mut self.desk;
        if let Err(why) = desk.work.export(desk.document.params(), &desk.rows(), folder, desk.choice) {
            cx.error("Nothing was exported", why);
        }
    }

    fn run_own(&mut self, command: FlankCommand, cx: &mut Context) {
        let desk = &mut self.desk;
        match command {
            FlankCommand::PlanFlank => {
                if let Err(why) = desk.plan() {
                    cx.say(EventKind::Failed, why);
                }
            }
            FlankCommand::NextPath => desk.path = PathChoice::ALL[(desk.path as usize + 1) % PathChoice::ALL.len()],
            FlankCommand::SideBySide => {
                desk.is_side_by_side = !desk.is_side_by_side;
                desk.fly = Some(if desk.is_side_by_side { Fly::Square } else { Fly::Onto });
            }
            FlankCommand::FaceFlank => desk.fly = Some(Fly::Square),
            FlankCommand::ShowCutter => desk.toggle_cutter(),
            FlankCommand::AxisSurface => desk.shows_axis = !desk.shows_axis,
            FlankCommand::Rulings => desk.shows_rulings = !desk.shows_rulings,
            FlankCommand::MovingCutter => desk.is_moving = !desk.is_moving,
            FlankCommand::FoldPanel => desk.shows_panel = !desk.shows_panel,
            FlankCommand::FoldList => desk.shows_list = !desk.shows_list,
        }
    }
}

impl Commanded for FlankDesk {
    fn is_enabled(&self, command: Command) -> bool {
        use FrameCommand as F;
        if let Some(command) = F::of(command) {
            return match command {
                F::Undo | F::Redo => self.document.undo_label(command == F::Redo).is_some(),
                F::Cancel => self.work.is_busy(),
                F::Export => self.is_planned(),
                F::Play | F::NextNode | F::PreviousNode | F::FirstNode | F::LastNode => self.planned().is_some(),
                _ => true,
            };
        }
        use FlankCommand as C;
        match C::of(command) {
            Some(C::PlanFlank) => self.can_plan(),
            Some(C::NextPath | C::SideBySide | C::AxisSurface | C::MovingCutter) => self.planned().is_some(),
            other => other.is_some(),
        }
    }
}

impl Commanded for FlankWorkspace {
    fn is_enabled(&self, command: Command) -> bool {
        self.opening.is_ended_by(command) || self.desk.is_enabled(command)
    }

    fn why_not(&self, command: Command) -> Option<&'static str> {
        let is_export = FrameCommand::of(command) == Some(FrameCommand::Export);
        if is_export { Some("plan the flank with these parameters first") } else { command.info.needs }
    }
}

impl Workspace for FlankWorkspace {
    held_in_fields!(FlankCommand);

    fn menu(&self, menu: Menu) -> Groups {
        use FlankCommand as C;
        let of = C::group;
        match menu {
            Menu::New | Menu::Save | Menu::View => Vec::new(),
            Menu::Own => vec![
                vec![C::PlanFlank.into(), FrameCommand::Cancel.into()],
                of(&[C::NextPath, C::SideBySide, C::FaceFlank, C::MovingCutter]),
                of(&[C::ShowCutter, C::AxisSurface, C::Rulings]),
                of(&[C::FoldPanel, C::FoldList]),
            ],
        }
    }

    fn run(&mut self, command: Command, cx: &mut Context, _now: f64) {
        use FrameCommand as F;
        if let Some(command) = FlankCommand::of(command) {
            return self.run_own(command, cx);
        }
        let desk = &mut self.desk;
        match F::of(command) {
            Some(F::Open) => self.opening.intend(Pending::Ask(FlankPath::Open), cx),
            Some(F::Cancel) if self.opening.is_busy() => self.opening.cancel(),
            Some(F::Reload) => desk.work.reload(),
            Some(F::Cancel) => desk.work.cancel(),
            Some(F::Export) => {
                desk.changed_files = desk.work.changed_files(desk.document.params());
                self.opening.moved.forget();
                cx.request(Request::Dialog);
            }
            Some(F::Play) => desk.play(),
            Some(F::NextNode) => desk.step(true),
            Some(F::PreviousNode) => desk.step(false),
            Some(F::FirstNode) => desk.go_to(0.0),
            Some(F::LastNode) => desk.go_to(1.0),
            _ => {}
        }
    }

    fn ui(&mut self, ui: &mut Ui, cx: &mut Context) {
        if let Some(path) = panels::show(ui, &mut self.desk, cx, &mut self.view) {
            if self.is_another(path) { self.opening.intend(Pending::Ask(path), cx) } else { cx.ask(path, "") }
        }
    }

    fn follow(&mut self, cx: &mut Context, hands: Hands, _seconds: f64, is_shown: bool) {
        if let Some(opened) = self.opening.take(cx) {
            self.opening.go_on(Pending::Take(opened), cx);
        }
        let news = self.desk.follow(hands, is_shown, cx.now);
        cx.note_events(news);
    }

    fn is_busy(&self) -> bool {
        self.opening.is_busy() || self.desk.work.is_busy()
    }

    fn near(&self) -> Option<&Path> {
        self.desk.file()
    }

    fn open(&mut self, path: &Path, _cx: &mut Context) {
        self.begin(Source::Project(path.to_owned()));
    }

    fn take_files(&mut self, files: &[PathBuf], cx: &mut Context) {
        self.opening.stop();
        match files {
            [one, other] if files.iter().all(|file| is_points_file(file)) => {
                self.take_guides([one.clone(), other.clone()], cx);
            }
            _ if is_project(first(files)) => self.opening.go_on(Pending::Open(first(files).to_owned()), cx),
            _ => self.take_file(first(files), cx),
        }
    }

    fn proceed(&mut self, cx: &mut Context) {
        match self.opening.pending.take() {
            Some(Pending::Open(path)) => self.begin(Source::Project(path)),
            Some(Pending::Surface(source)) => {
                self.begin(Source::There(Box::new(Document::new(self.desk.params().of_another(source)))));
            }
            Some(Pending::Ask(what)) => cx.ask(what, ""),
            Some(Pending::Take(opened)) => self.put(&opened, cx),
            Some(Pending::Electrode(part)) => self.take_electrode(&part, cx),
            None => {}
        }
    }

    fn recover(&mut self, copy: Recovery, _cx: &mut Context) {
        self.begin(Source::Copy(copy));
    }

    fn take_path(&mut self, number: usize, path: PathBuf, cx: &mut Context) {
        if let Some(what) = FlankPath::at(number) {
            self.take(what, path, cx);
        }
    }

    fn no_path(&mut self, number: usize, cx: &mut Context) {
        if FlankPath::at(number) == Some(FlankPath::Upper) {
            self.forget_first_guide(cx);
        }
    }

    fn dialog_title(&self) -> &'static str {
        if self.opening.moved.is_asking() { moved_files::TITLE } else { "Export" }
    }

    fn dialog(&mut self, ui: &mut Ui, cx: &mut Context) -> bool {
        if self.opening.moved.is_asking() {
            let opened = self.opening.moved.dialog(ui, cx, FlankPath::MovedFile);
            opened.into_iter().for_each(|document| self.begin(Source::There(Box::new(document))));
            return !self.opening.moved.is_asking();
        }
        match export::show(ui, &mut self.desk, cx) {
            Some(export::Answer::Folder) => {
                cx.ask(FlankPath::Folder, "");
                true
            }
            answer => answer.is_some(),
        }
    }

    fn receive(&mut self, message: &Message, cx: &mut Context) -> bool {
        let Message::MillFlanks(part) = message else { return false };
        self.opening.intend(Pending::Electrode(part.clone()), cx);
        true
    }

    fn revision(&self) -> u64 {
        self.desk.revision()
    }

    fn standing(&self, line: &LogLine) -> Standing {
        match (line.is_of_other(self.revision()), line.kind) {
            (false, _) => Standing::Current,
            (true, EventKind::Done) => Standing::Stale,
            (true, _) => Standing::Over,
        }
    }
}
