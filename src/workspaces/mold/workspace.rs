//! The workspace of molds.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use egui::Ui;

use crate::workspaces::commands::{Command, CommandInfo, CommandSet, Commanded, FrameCommand, Groups};
use crate::workspaces::context::{Context, PathSet, Request, first, is_project};
use crate::workspaces::hands::Hands;
use crate::workspaces::message::{ElectrodePart, Message};
use crate::workspaces::mold::commands::MoldCommand;
use crate::workspaces::mold::document::MoldParams;
use crate::workspaces::mold::document::cutter_file::CUTTERS;
use crate::workspaces::mold::panels;
use crate::workspaces::mold::panels::desk::MoldDesk;
use crate::workspaces::mold::panels::view::MoldView;
use crate::workspaces::mold::paths::MoldPath;
use crate::workspaces::mold::scene::{MoldLook, RegionColours};
use crate::workspaces::mold::work::{LoadedMold, read_part};
use crate::workspaces::moved_files;
use crate::workspaces::news::EventKind;
use crate::workspaces::opening::{Incoming, Opening, Source};
use crate::workspaces::technology::{TableChange, TechnologyWindow, read_table, take_first_unless_known};
use crate::workspaces::workspace::{About, Menu, Workspace, held_in_fields};
use files::patience::soon;
use files::{AnyDocument, Document, Recovery, paths};
use nc::template::BurnSheet;
use task::{Scheduler, State};

static ABOUT: About = About { id: "mold", name: "Mold", switch: CommandInfo::new("Workspace: mold"), menu: "Mold" };

/// The workspace of molds.
pub struct MoldWorkspace {
    /// The mold, its parameters and results.
    pub desk: MoldDesk,
    view: MoldView,
    opening: Opening<Pending, MoldParams, Option<Arc<LoadedMold>>>,
    /// Window of the technology table.
    technology: TechnologyWindow,
}

/// Replacement of the mold, done once unsaved work is dealt with.
enum Pending {
    Open(PathBuf),
    Ask,
    /// A mold that was read.
    Take(Arc<Incoming<MoldParams, Option<Arc<LoadedMold>>>>),
}

impl MoldWorkspace {
    /// An empty workspace.
    pub fn new(scheduler: &Scheduler) -> Self {
        Self {
            desk: MoldDesk::new(scheduler),
            view: MoldView::default(),
            opening: Opening::new(scheduler),
            technology: TechnologyWindow::default(),
        }
    }

    /// Whether `pending` loses no work: cutters that were chosen before there was a mold stay.
    fn is_harmless(&self, pending: &Pending) -> bool {
        self.desk.params().mesh.is_none()
            && match pending {
                Pending::Open(path) => !is_project(path),
                Pending::Ask => true,
                Pending::Take(opened) => opened.document.file().is_none(),
            }
    }

    /// Replaces the mold by `pending` after the question about unsaved work.
    fn intend(&mut self, pending: Pending, cx: &mut Context) {
        self.opening.stop();
        self.request(pending, Request::Replace, cx);
    }

    /// Replaces the mold by `pending` within a replacement that was asked about already.
    fn go_on(&mut self, pending: Pending, cx: &mut Context) {
        self.request(pending, Request::GoOn, cx);
    }

    fn request(&mut self, pending: Pending, request: Request, cx: &mut Context) {
        let is_harmless = self.is_harmless(&pending);
        self.opening.pending = Some(pending);
        if is_harmless { self.proceed(cx) } else { cx.request(request) }
    }

    /// Reads a mold with its mesh, which then replaces the present mold.
    fn begin(&mut self, source: Source<MoldParams>) {
        self.opening.begin(source, |document, task| {
            let params = document.params();
            let part = params.mesh.as_ref().map(|mesh| read_part(mesh, &params.reading(), task));
            Ok(part.transpose()?.map(Arc::new))
        });
    }

    /// Source of the mold at `path`, a project or a mesh.
    fn source(&self, path: &Path) -> Source<MoldParams> {
        if is_project(path) { Source::Project(path.to_owned()) } else { Source::There(Box::new(self.desk.begun(path))) }
    }

    /// Replaces the present mold by `document`, with its mesh if that was read.
    fn take(&mut self, document: Document<MoldParams>, part: Option<Arc<LoadedMold>>, cx: &mut Context) {
        self.desk.replace(document);
        if let Some(part) = part {
            self.desk.work.put(self.desk.document.params(), part);
        }
        cx.request(Request::Show);
        let document = &self.desk.document;
        document.file().or(document.params().mesh.as_deref()).iter().for_each(|path| cx.opened(path));
        cx.say(EventKind::Done, format!("opened {}", document.name()));
    }

    fn load_cutters(&mut self, path: &Path, are_others: bool, cx: &mut Context) {
        match CUTTERS.read(path) {
            Ok(library) if are_others => self.desk.other = library,
            Ok(library) => {
                let mut params = self.desk.params().clone();
                params.library = library;
                self.desk.edit(params);
            }
            Err(error) => cx.error("This is no library of cutters", error.to_string()),
        }
    }

    /// Sets the template of the burn sheet. A wrong template changes nothing.
    fn take_burn_sheet(&mut self, path: &Path, cx: &mut Context) {
        match BurnSheet::read(path) {
            Ok(sheet) => self.desk.electrodes.sheet = sheet,
            Err(error) => cx.error("This is no template of a burn sheet", error.to_string()),
        }
    }

    /// Sets the technology table of the file `path`, or shows why the file is none. A table without the present technology
    /// sets its first one.
    fn take_technology(&mut self, path: &Path, cx: &mut Context) {
        let mut params = self.desk.params().clone();
        let technology = &mut params.electrodes.technology;
        technology.table = path.to_string_lossy().into_owned();
        match read_table(technology) {
            Ok(table) => {
                take_first_unless_known(technology, &table);
                self.desk.edit(params);
            }
            Err(error) => cx.error("This is no technology table", error.to_string()),
        }
    }

    /// Draws the window of the technology table, and takes its changes in.
    fn show_technology(&mut self, ui: &Ui, cx: &mut Context) {
        let paths = [MoldPath::Technology, MoldPath::TechnologyCopy];
        let change = self.technology.show(ui, &self.desk.params().electrodes.technology, cx, paths);
        if let Some(TableChange::Use(id)) = &change {
            let mut params = self.desk.params().clone();
            params.electrodes.technology.id.clone_from(id);
            self.desk.edit(params);
        }
        if change.is_some() {
            self.desk.work.recompute_burning();
        }
    }

    fn save_cutters(&mut self, path: &Path, cx: &mut Context) {
        let library = self.desk.params().library.clone();
        match soon(path, move |path| CUTTERS.write(path, &library)) {
            Ok(()) => cx.say(EventKind::Done, format!("cutters saved as {}", path.display())),
            Err(e) => cx.error("The cutters were not saved", e.to_string()),
        }
    }

    /// Writes the files of the electrodes into `folder`, or shows why that is not possible.
    pub fn export(&mut self, folder: &Path, cx: &mut Context) {
        let desk = &mut self.desk;
        let formats = desk.electrodes.formats();
        if let Err(why) =
            desk.work.export_electrodes(desk.document.params(), folder, (&formats, &desk.electrodes.sheet))
        {
            cx.error("Nothing was exported", why);
        }
    }

    /// Writes the files of the rest material into `folder`, or shows why that is not possible.
    pub fn export_uncut(&mut self, folder: &Path, cx: &mut Context) {
        let desk = &mut self.desk;
        if let Err(why) = desk.work.export_uncut(desk.document.params(), &desk.other, folder) {
            cx.error("Nothing was exported", why);
        }
    }

    /// Steps along the burn of the selected electrode.
    fn step_along_burn(&mut self, command: FrameCommand) {
        let burns = &mut self.desk.electrodes;
        match command {
            FrameCommand::Play => burns.play(),
            FrameCommand::NextNode | FrameCommand::PreviousNode => burns.step(command == FrameCommand::NextNode),
            FrameCommand::FirstNode => (burns.time, burns.is_playing) = (Some(0.0), false),
            _ => (burns.time, burns.is_playing) = (None, false),
        }
    }

    fn mill_flanks(&self, cx: &mut Context) {
        let Some((electrode, _)) = self.desk.electrodes.chosen() else { return };
        if !self.desk.electrodes.designed().is_some_and(|made| made.is_proven) {
            // What was read from a file is shown, but proves nothing.
            let why = "These electrodes were kept from an earlier session. Find the rest material and create the \
                       electrodes again first.";
            return cx.error("No flank to mill", why.to_owned());
        }
        let part = ElectrodePart::of_mold(electrode, &self.desk.document.name());
        cx.request(Request::Send(Message::MillFlanks(part.into())));
    }

    fn run_own(&mut self, command: MoldCommand, cx: &mut Context) {
        let desk = &mut self.desk;
        let bounds = desk.work.mold().map(|mold| mold.shape.bounds());
        let burns = &mut desk.electrodes;
        let mut done = Ok(());
        match command {
            MoldCommand::FindUncut => {
                burns.is_shown = false;
                done = desk.find();
            }
            MoldCommand::DesignElectrodes => done = desk.design(),
            MoldCommand::CompareCutters => done = desk.work.compare(desk.document.params(), &desk.other),
            MoldCommand::CompareDivisions => done = desk.work.compare_divisions(desk.document.params()),
            MoldCommand::ExportUncut => cx.ask(MoldPath::UncutFolder, ""),
            MoldCommand::Electrodes => burns.is_shown = !burns.is_shown,
            MoldCommand::FlyToRegion if burns.seen().is_some() => {
                bounds.into_iter().for_each(|bounds| burns.fly_to_selected(bounds));
            }
            MoldCommand::Isolate if burns.seen().is_some() => burns.is_alone = !burns.is_alone,
            MoldCommand::FaintMold if burns.seen().is_some() => {
                burns.look = MoldLook::ALL[(burns.look as usize + 1) % MoldLook::ALL.len()];
            }
            MoldCommand::FlyToRegion => desk.fly_to = desk.selected,
            MoldCommand::Isolate => desk.isolated = !desk.isolated,
            MoldCommand::FaintMold => desk.is_faint = !desk.is_faint,
            MoldCommand::Layers => desk.toggle_layers(),
            MoldCommand::Section => burns.toggle_cut(),
            MoldCommand::MillFlanks => self.mill_flanks(cx),
            MoldCommand::Technology => self.technology.toggle(),
            MoldCommand::FoldPanel => desk.fold_panel(),
            MoldCommand::FoldList if desk.is_small => desk.shows_list_instead = !desk.shows_list_instead,
            MoldCommand::FoldList => desk.shows_list = !desk.shows_list,
            MoldCommand::DepthColours => {
                desk.colours = match desk.colours {
                    RegionColours::ByRegion => RegionColours::ByDepth,
                    RegionColours::ByDepth => RegionColours::ByRegion,
                }
            }
        }
        if let Err(why) = done {
            cx.say(EventKind::Failed, why);
        }
    }
}

impl Commanded for MoldDesk {
    fn is_enabled(&self, command: Command) -> bool {
        use FrameCommand as F;
        let burns = &self.electrodes;
        let is_one_seen = burns.seen().is_some() && burns.chosen().is_some();
        if let Some(command) = F::of(command) {
            return match command {
                F::Undo | F::Redo => self.document.undo_label(command == F::Redo).is_some(),
                F::Cancel => self.work.is_busy() || burns.split.is_some() || self.pick.is_some(),
                F::Export => self.is_designed(),
                F::Play | F::NextNode | F::PreviousNode | F::FirstNode | F::LastNode => is_one_seen,
                _ => true,
            };
        }
        let Some(command) = MoldCommand::of(command) else { return false };
        match command {
            MoldCommand::FindUncut | MoldCommand::DesignElectrodes => {
                self.work.mold_state(self.params()) == State::Ready
            }
            MoldCommand::Electrodes => burns.designed().is_some(),
            MoldCommand::FlyToRegion | MoldCommand::Isolate if burns.seen().is_some() => burns.chosen().is_some(),
            MoldCommand::FlyToRegion | MoldCommand::Isolate => self.selected.is_some(),
            MoldCommand::Section => is_one_seen,
            MoldCommand::CompareCutters | MoldCommand::ExportUncut => self.state() == State::Ready,
            MoldCommand::Layers if burns.seen().is_some() => false,
            MoldCommand::Layers => self.found().is_some_and(|found| !found.uncut.layers.is_empty()),
            MoldCommand::CompareDivisions => self.is_designed(),
            MoldCommand::MillFlanks => self.is_designed() && burns.chosen().is_some(),
            _ => true,
        }
    }
}

impl Commanded for MoldWorkspace {
    fn is_enabled(&self, command: Command) -> bool {
        self.opening.is_ended_by(command) || self.desk.is_enabled(command)
    }

    fn why_not(&self, command: Command) -> Option<&'static str> {
        let is_export = FrameCommand::of(command) == Some(FrameCommand::Export);
        if is_export { Some("create the electrodes of these parameters first") } else { command.info.needs }
    }
}

impl Workspace for MoldWorkspace {
    held_in_fields!(MoldCommand);

    fn menu(&self, menu: Menu) -> Groups {
        use MoldCommand as C;
        let of = C::group;
        match menu {
            Menu::New | Menu::Save => Vec::new(),
            Menu::Own => vec![
                [
                    of(&[C::FindUncut, C::DesignElectrodes, C::CompareCutters, C::ExportUncut]),
                    vec![FrameCommand::Cancel.into()],
                ]
                .concat(),
                of(&[C::Electrodes, C::Layers, C::DepthColours, C::FaintMold]),
                of(&[C::FoldPanel, C::FoldList]),
                of(&[C::FlyToRegion, C::Isolate, C::CompareDivisions, C::Technology, C::MillFlanks]),
            ],
            Menu::View => vec![of(&[C::Section])],
        }
    }

    fn run(&mut self, command: Command, cx: &mut Context, _now: f64) {
        use FrameCommand as F;
        if let Some(command) = MoldCommand::of(command) {
            return self.run_own(command, cx);
        }
        match F::of(command) {
            Some(F::Open) => self.intend(Pending::Ask, cx),
            Some(F::Reload) => self.desk.work.reload(),
            Some(F::Cancel) if self.opening.is_busy() => self.opening.cancel(),
            // What is being drawn is given up first.
            Some(F::Cancel) if self.desk.electrodes.split.is_some() => self.desk.electrodes.give_up_split(),
            Some(F::Cancel) if self.desk.pick.is_some() => self.desk.pick = None,
            Some(F::Cancel) => self.desk.cancel(),
            Some(F::Export) => cx.ask(MoldPath::ElectrodeFolder, ""),
            Some(along @ (F::Play | F::NextNode | F::PreviousNode | F::FirstNode | F::LastNode)) => {
                self.step_along_burn(along);
            }
            _ => {}
        }
    }

    fn ui(&mut self, ui: &mut Ui, cx: &mut Context) {
        match panels::show(ui, &mut self.desk, cx, &mut self.view) {
            Some(MoldPath::Open) => self.intend(Pending::Ask, cx),
            Some(path) => cx.ask(path, "cutters.toml"),
            None => {}
        }
        self.show_technology(ui, cx);
    }

    fn triangles(&self) -> Option<usize> {
        self.desk.work.mold().map(|mold| mold.mesh.triangles.len())
    }

    fn follow(&mut self, cx: &mut Context, hands: Hands, _seconds: f64, is_shown: bool) {
        if let Some(opened) = self.opening.take(cx) {
            self.go_on(Pending::Take(opened), cx);
        }
        let news = self.desk.follow(hands, is_shown, cx.now);
        cx.note_events(news);
    }

    fn is_busy(&self) -> bool {
        self.opening.is_busy() || self.desk.work.is_busy()
    }

    fn near(&self) -> Option<&Path> {
        self.desk.params().mesh.as_deref()
    }

    fn open(&mut self, path: &Path, cx: &mut Context) {
        match self.source(path) {
            Source::There(document) => self.take(*document, None, cx),
            project => self.begin(project),
        }
    }

    fn take_files(&mut self, files: &[PathBuf], cx: &mut Context) {
        let path = first(files);
        if paths::has_ending(path, ".toml") {
            self.load_cutters(path, false, cx)
        } else {
            self.intend(Pending::Open(path.to_owned()), cx)
        }
    }

    fn proceed(&mut self, cx: &mut Context) {
        match self.opening.pending.take() {
            Some(Pending::Open(path)) => self.begin(self.source(&path)),
            Some(Pending::Ask) => cx.ask(MoldPath::Open, ""),
            Some(Pending::Take(opened)) => {
                self.take(opened.document.clone(), opened.loaded.clone().flatten(), cx);
                opened.copy.iter().for_each(|copy| cx.request(Request::Recovered(copy.clone())));
            }
            None => {}
        }
    }

    fn recover(&mut self, copy: Recovery, _cx: &mut Context) {
        self.begin(Source::Copy(copy));
    }

    fn dialog_title(&self) -> &'static str {
        moved_files::TITLE
    }

    fn dialog(&mut self, ui: &mut Ui, cx: &mut Context) -> bool {
        let opened = self.opening.moved.dialog(ui, cx, MoldPath::MovedFile);
        opened.into_iter().for_each(|document| self.begin(Source::There(Box::new(document))));
        !self.opening.moved.is_asking()
    }

    fn take_parameters(&mut self, file: &Path, _label: &str) -> Result<(), String> {
        let project = Document::<MoldParams>::open(file).map_err(|error| error.to_string())?;
        self.desk.edit(project.params().clone());
        Ok(())
    }

    fn take_path(&mut self, number: usize, path: PathBuf, cx: &mut Context) {
        match MoldPath::at(number) {
            Some(MoldPath::Open) => self.go_on(Pending::Open(path), cx),
            Some(MoldPath::MovedFile) => {
                let found = self.opening.moved.found(&path, cx);
                found.into_iter().for_each(|found| self.begin(Source::There(Box::new(found))));
            }
            Some(MoldPath::Cutters) => self.load_cutters(&path, false, cx),
            Some(MoldPath::OtherCutters) => self.load_cutters(&path, true, cx),
            Some(MoldPath::SaveCutters) => self.save_cutters(&path, cx),
            Some(MoldPath::BurnSheet) => self.take_burn_sheet(&path, cx),
            Some(MoldPath::Technology) => self.take_technology(&path, cx),
            Some(MoldPath::TechnologyCopy) if self.technology.write_copy(&path, cx) => self.take_technology(&path, cx),
            Some(MoldPath::TechnologyCopy) => {}
            Some(MoldPath::UncutFolder) => self.export_uncut(&path, cx),
            Some(MoldPath::ElectrodeFolder) => self.export(&path, cx),
            None => {}
        }
    }

    fn receive(&mut self, message: &Message, _cx: &mut Context) -> bool {
        let Message::TechnologyTable(table) = message else { return false };
        if self.technology.is_changed(&self.desk.params().electrodes.technology, table) {
            self.desk.work.recompute_burning();
        }
        false
    }

    fn take_user_files(&mut self, folder: &Path, cx: &mut Context) {
        self.desk.work.results.clone_from(&cx.results);
        for wrong in self.desk.take_user_files(folder) {
            cx.say(EventKind::Failed, wrong);
        }
    }
}
