//! The workspace of molds as the window knows it.

use std::any::Any;
use std::path::{Path, PathBuf};

use egui::Ui;

use crate::widgets::panel_parts::doing;
use crate::widgets::viewport::Viewport;
use crate::workspaces::commands::{Command, CommandInfo, CommandSet, Commanded, FrameCommand, Groups};
use crate::workspaces::context::{Context, PathInfo, PathKind, PathSet, Request, first, has_ending};
use crate::workspaces::message::{ElectrodePart, Message};
use crate::workspaces::mold::commands::MoldCommand;
use crate::workspaces::mold::document::MoldParams;
use crate::workspaces::mold::document::cutter_file::{read_cutters, write_cutters};
use crate::workspaces::mold::document::mold_file::{ENDING, is_mold_file, read_mold, write_mold};
use crate::workspaces::mold::panels::{self, MoldDesk, MoldView};
use crate::workspaces::mold::paths::MoldPath;
use crate::workspaces::mold::scene::{MoldLook, RegionColours};
use crate::workspaces::news::EventKind;
use crate::workspaces::record::Hands;
use crate::workspaces::workspace::{About, Menu, Workspace};
use nc::burn_template::BurnSheet;
use task::{Scheduler, State};

static ABOUT: About = About {
    id: "mold",
    name: "Mold",
    switch: CommandInfo::new("Workspace: mold"),
    menu: "Mold",
    save: PathInfo { title: "Save mold", kind: PathKind::Write("Mold", ENDING), opens: false },
    ending: ENDING,
    article: "The mold ",
    kind: "Mold, ",
    not_saved: "The mold was not saved",
};

/// The workspace of molds.
pub struct MoldWorkspace {
    /// The mold, what is asked about it and what was found.
    pub desk: MoldDesk,
    view: MoldView,
    /// What is opened once nothing stands in the way.
    pending: Option<PathBuf>,
}

impl MoldWorkspace {
    /// An empty workspace.
    pub fn new(scheduler: &Scheduler) -> Self {
        Self { desk: MoldDesk::new(scheduler), view: MoldView::default(), pending: None }
    }

    /// Opens the mold at `path`, after asking about unsaved work.
    fn choose(&mut self, path: &Path, cx: &mut Context) {
        self.pending = Some(path.to_owned());
        if is_mold_file(path) || self.desk.params.mesh.is_some() {
            cx.request(Request::Replace);
        } else {
            // Nothing is lost: the cutters that were chosen stay.
            self.proceed(cx);
        }
    }

    fn load_cutters(&mut self, path: &Path, are_others: bool, cx: &mut Context) {
        match read_cutters(path) {
            Ok(library) if are_others => self.desk.other = library,
            Ok(library) => {
                let mut params = self.desk.params.clone();
                params.library = library;
                self.desk.edit(params);
            }
            Err(error) => cx.error("This is no library of cutters", error.to_string()),
        }
    }

    /// A template that is wrong changes nothing.
    fn take_burn_sheet(&mut self, path: &Path, cx: &mut Context) {
        match BurnSheet::read(path) {
            Ok(sheet) => self.desk.electrodes.sheet = sheet,
            Err(error) => cx.error("This is no template of a burn sheet", error.to_string()),
        }
    }

    fn save_cutters(&mut self, path: &Path, cx: &mut Context) {
        match write_cutters(path, &self.desk.params.library) {
            Ok(()) => cx.say(EventKind::Done, format!("cutters saved as {}", path.display())),
            Err(e) => cx.error("The cutters were not saved", e.to_string()),
        }
    }

    /// Writes the files of the electrodes into `folder`; says why not if it cannot.
    pub fn export(&mut self, folder: &Path, cx: &mut Context) {
        let desk = &mut self.desk;
        let formats = desk.electrodes.formats();
        if let Err(why) = desk.work.export_electrodes(&desk.params, folder, (&formats, &desk.electrodes.sheet)) {
            cx.error("Nothing was exported", why);
        }
    }

    /// Along the way of the electrode that is selected.
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
        let part = ElectrodePart::of_mold(electrode, &self.desk.name());
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
            MoldCommand::CompareCutters => done = desk.work.compare(&desk.params, &desk.other),
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
                F::Undo | F::Redo => self.undo_label(command == F::Redo).is_some(),
                F::Cancel => self.work.is_busy() || burns.split.is_some(),
                F::Export => self.is_designed(),
                F::Play | F::NextNode | F::PreviousNode | F::FirstNode | F::LastNode => is_one_seen,
                _ => true,
            };
        }
        let Some(command) = MoldCommand::of(command) else { return false };
        match command {
            MoldCommand::FindUncut | MoldCommand::DesignElectrodes => {
                self.work.mold_state(&self.params) == State::Ready
            }
            MoldCommand::Electrodes => burns.designed().is_some(),
            MoldCommand::FlyToRegion | MoldCommand::Isolate if burns.seen().is_some() => burns.chosen().is_some(),
            MoldCommand::FlyToRegion | MoldCommand::Isolate => self.selected.is_some(),
            MoldCommand::Section => is_one_seen,
            MoldCommand::CompareCutters => self.state() == State::Ready,
            MoldCommand::Layers if burns.seen().is_some() => false,
            MoldCommand::Layers => self.found().is_some_and(|found| !found.uncut.layers.is_empty()),
            MoldCommand::MillFlanks => self.is_designed() && burns.chosen().is_some(),
            _ => true,
        }
    }
}

impl Commanded for MoldWorkspace {
    fn is_enabled(&self, command: Command) -> bool {
        self.desk.is_enabled(command)
    }
}

impl Workspace for MoldWorkspace {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn commands(&self) -> Vec<Command> {
        MoldCommand::all()
    }

    fn menu(&self, menu: Menu) -> Groups {
        use MoldCommand as C;
        let of = |all: &[C]| all.iter().map(|command| command.command()).collect::<Vec<_>>();
        match menu {
            Menu::New | Menu::Save => Vec::new(),
            Menu::Own => vec![
                [of(&[C::FindUncut, C::DesignElectrodes, C::CompareCutters]), vec![FrameCommand::Cancel.into()]]
                    .concat(),
                of(&[C::Electrodes, C::Layers, C::DepthColours, C::FaintMold]),
                of(&[C::FoldPanel, C::FoldList]),
                of(&[C::FlyToRegion, C::Isolate, C::MillFlanks]),
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
            Some(F::Open) => cx.ask(MoldPath::Open, ""),
            Some(F::Reload) => self.desk.work.reload(),
            // What is being drawn is given up first.
            Some(F::Cancel) if self.desk.electrodes.split.is_some() => self.desk.electrodes.give_up_split(),
            Some(F::Cancel) => self.desk.cancel(),
            Some(F::Export) => cx.ask(MoldPath::ElectrodeFolder, ""),
            Some(along @ (F::Play | F::NextNode | F::PreviousNode | F::FirstNode | F::LastNode)) => {
                self.step_along_burn(along);
            }
            _ => {}
        }
    }

    fn ui(&mut self, ui: &mut Ui, cx: &mut Context) {
        if let Some(path) = panels::show(ui, &mut self.desk, cx, &mut self.view) {
            cx.ask(path, "cutters.toml");
        }
    }

    fn status(&mut self, ui: &mut Ui, _cx: &mut Context, is_shown: bool) {
        if let Some(now) = self.desk.work.doing().filter(|_| is_shown) {
            doing(ui, now);
        }
    }

    fn triangles(&self) -> Option<usize> {
        self.desk.work.mold().map(|mold| mold.mesh.triangles.len())
    }

    fn follow(&mut self, cx: &mut Context, hands: Hands, _seconds: f64, is_shown: bool) {
        let news = self.desk.follow(hands, is_shown);
        cx.note_events(news, 0);
    }

    fn is_busy(&self) -> bool {
        self.desk.work.is_busy()
    }

    fn viewport(&self) -> &Viewport {
        &self.view.viewport
    }

    fn viewport_mut(&mut self) -> &mut Viewport {
        &mut self.view.viewport
    }

    fn name(&self) -> String {
        self.desk.name()
    }

    fn is_unsaved(&self) -> bool {
        self.desk.is_unsaved()
    }

    fn file(&self) -> Option<&Path> {
        self.desk.record.file.as_deref()
    }

    fn near(&self) -> Option<&Path> {
        self.desk.params.mesh.as_deref()
    }

    fn undo_label(&self, again: bool) -> Option<&str> {
        self.desk.undo_label(again)
    }

    fn undo(&mut self, again: bool) {
        self.desk.undo(again);
    }

    fn open(&mut self, path: &Path, cx: &mut Context) {
        cx.request(Request::Show);
        if is_mold_file(path) {
            match read_mold(path) {
                Ok(params) => self.desk.replace(params, Some(path)),
                Err(e) => {
                    cx.not_opened(path);
                    return cx.error("This mold cannot be opened", e.to_string());
                }
            }
        } else {
            self.desk.open(path);
        }
        cx.opened(path);
    }

    fn take_files(&mut self, files: &[PathBuf], cx: &mut Context) {
        let path = first(files);
        if has_ending(path, ".toml") { self.load_cutters(path, false, cx) } else { self.choose(path, cx) }
    }

    fn proceed(&mut self, cx: &mut Context) {
        if let Some(path) = self.pending.take() {
            self.open(&path, cx);
        }
    }

    fn write(&self, file: &Path) -> Result<(), String> {
        write_mold(file, &self.desk.params).map_err(|e| e.to_string())
    }

    fn save_as(&mut self, file: &Path) -> Result<(), String> {
        self.write(file)?;
        self.desk.saved_as(file);
        Ok(())
    }

    fn recover(&mut self, copy: &Path, file: Option<PathBuf>, cx: &mut Context) -> Result<(), String> {
        let params = read_mold(copy).map_err(|e| e.to_string())?;
        self.desk.recover(params, file.as_deref());
        cx.request(Request::Show);
        Ok(())
    }

    fn snapshot(&self) -> Box<dyn Any> {
        Box::new(self.desk.params.clone())
    }

    fn is_at(&self, snapshot: Option<&dyn Any>) -> bool {
        let params = &self.desk.params;
        snapshot.and_then(|s| s.downcast_ref::<MoldParams>()) == Some(params) || params.validate().is_err()
    }

    fn take_path(&mut self, number: usize, path: PathBuf, cx: &mut Context) {
        match MoldPath::at(number) {
            Some(MoldPath::Open) => self.choose(&path, cx),
            Some(MoldPath::Cutters) => self.load_cutters(&path, false, cx),
            Some(MoldPath::OtherCutters) => self.load_cutters(&path, true, cx),
            Some(MoldPath::SaveCutters) => self.save_cutters(&path, cx),
            Some(MoldPath::BurnSheet) => self.take_burn_sheet(&path, cx),
            Some(MoldPath::ElectrodeFolder) => self.export(&path, cx),
            None => {}
        }
    }

    fn take_user_files(&mut self, folder: &Path, cx: &mut Context) {
        for wrong in self.desk.take_user_files(folder) {
            cx.say(EventKind::Failed, wrong);
        }
    }
}
