//! What the window does for the workspace of molds.

use std::path::{Path, PathBuf};
use std::time::Duration;

use super::SparkpathApp;
use crate::shell::commands::Command;
use crate::shell::core::LogLine;
use crate::shell::dialogs::{Dialog, Intent, Work};
use crate::shell::files::Purpose;
use crate::shell::record::Hands;
use crate::shell::workspace::Workspace;
use crate::workspaces::blisk::panels::viewport::Viewport;
use crate::workspaces::flank::document::flank_file::is_flank_file;
use crate::workspaces::mold::document::cutter_file::CUTTERS;
use crate::workspaces::mold::document::mold_file::{ENDING, is_mold_file, write_mold};
use crate::workspaces::mold::scene::{MoldLook, RegionColours};
use crate::workspaces::news::EventKind;
use crate::workspaces::news::WorkEvent;
use nc::burn_template::BurnSheet;

impl SparkpathApp {
    /// The view of the workspace that is shown.
    pub(super) fn seen(&self) -> &Viewport {
        match self.core.workspace {
            Workspace::Blisk => &self.viewport,
            Workspace::Mold => &self.mold_view.viewport,
            Workspace::Flank => &self.flank_view.viewport,
        }
    }

    pub(super) fn seen_mut(&mut self) -> &mut Viewport {
        match self.core.workspace {
            Workspace::Blisk => &mut self.viewport,
            Workspace::Mold => &mut self.mold_view.viewport,
            Workspace::Flank => &mut self.flank_view.viewport,
        }
    }

    /// Opens a file in the workspace where it belongs: while molds are shown a mesh is one, and a table of cutters is
    /// theirs.
    pub(super) fn open_here(&mut self, path: PathBuf, ctx: &egui::Context) {
        self.forget_intents();
        let is = |ending| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(ending));
        if is_mold_file(&path) {
            self.intend(Intent::OpenMold(path), ctx);
        } else if is_flank_file(&path) {
            self.intend(Intent::OpenFlank(path), ctx);
        } else if self.core.workspace == Workspace::Blisk || is("sparkpath") {
            self.intend(Intent::Open(path), ctx);
        } else if self.core.workspace == Workspace::Flank {
            self.take_for_flank(&path, ctx);
        } else if is("toml") {
            self.load_cutters(&path, false);
        } else {
            self.intend(Intent::OpenMold(path), ctx);
        }
    }

    /// Saves the mold, in its file if it has one and that will do.
    pub(super) fn save_mold(&mut self, in_its_file: bool, ctx: &egui::Context) {
        match self.core.mold.record.file.clone().filter(|_| in_its_file) {
            Some(file) => self.write_mold(&file, ctx),
            None => {
                let name = format!("{}{ENDING}", self.core.mold.params.name());
                self.ask(Purpose::SaveMold, &name, ctx);
            }
        }
    }

    pub(super) fn write_mold(&mut self, file: &Path, ctx: &egui::Context) {
        match write_mold(file, &self.core.mold.params) {
            Ok(()) => {
                self.core.mold.saved_as(file);
                self.core.preferences.recent.add(file);
                self.core.say(EventKind::Done, format!("saved as {}", file.display()));
                self.saved(Work::Mold, ctx);
            }
            Err(e) => {
                self.not_saved(Work::Mold);
                self.dialog = Dialog::Error("The mold was not saved".to_owned(), e.to_string());
            }
        }
    }

    pub(super) fn load_cutters(&mut self, path: &Path, are_others: bool) {
        match CUTTERS.read(path) {
            Ok(library) if are_others => self.core.mold.other = library,
            Ok(library) => {
                let mut params = self.core.mold.params.clone();
                params.library = library;
                self.core.mold.edit(params);
            }
            Err(error) => self.dialog = Dialog::Error("This is no library of cutters".to_owned(), error.to_string()),
        }
    }

    /// A template that is wrong changes nothing.
    pub(super) fn take_burn_sheet(&mut self, path: &Path) {
        match BurnSheet::read(path) {
            Ok(sheet) => self.core.mold.electrodes.sheet = sheet,
            Err(error) => {
                self.dialog = Dialog::Error("This is no template of a burn sheet".to_owned(), error.to_string())
            }
        }
    }

    pub(super) fn save_cutters(&mut self, path: &Path) {
        match CUTTERS.write(path, &self.core.mold.params.library) {
            Ok(()) => self.core.say(EventKind::Done, format!("cutters saved as {}", path.display())),
            Err(e) => self.dialog = Dialog::Error("The cutters were not saved".to_owned(), e.to_string()),
        }
    }

    /// Keeps the answer up with the parameters, and the log with both.
    pub(super) fn follow_mold(&mut self, ctx: &egui::Context) {
        let is_seen = self.core.workspace == Workspace::Mold;
        let news = self.core.mold.follow(Hands::of(ctx), is_seen);
        self.note_events(Workspace::Mold, news, ctx);
    }

    /// Keeps the log up with what has happened in a workspace, and comes back after `wait`.
    pub(super) fn note_events(
        &mut self,
        workspace: Workspace,
        (events, wait): (Vec<WorkEvent>, Option<Duration>),
        ctx: &egui::Context,
    ) {
        for event in events {
            let line = self.core.line(event.kind, event.text);
            self.core.note(workspace, LogLine { took: event.took, ..line });
        }
        if let Some(wait) = wait {
            ctx.request_repaint_after(wait);
        }
    }

    /// Writes the files of the electrodes into `folder`; says why not if it cannot.
    pub fn export_electrodes(&mut self, folder: &Path) {
        let mold = &mut self.core.mold;
        let formats = mold.electrodes.formats();
        if let Err(why) = mold.work.export_electrodes(&mold.params, folder, (&formats, &mold.electrodes.sheet)) {
            self.dialog = Dialog::Error("Nothing was exported".to_owned(), why);
        }
    }

    /// Along the way of the electrode that is selected.
    pub(super) fn step_along_burn(&mut self, command: Command) {
        let burns = &mut self.core.mold.electrodes;
        match command {
            Command::Play => burns.play(),
            Command::NextNode | Command::PreviousNode => burns.step(command == Command::NextNode),
            Command::FirstNode => (burns.time, burns.is_playing) = (Some(0.0), false),
            _ => (burns.time, burns.is_playing) = (None, false),
        }
    }

    pub(super) fn run_on_mold(&mut self, command: Command) {
        let mold = &mut self.core.mold;
        let done = match command {
            Command::FindUncut => {
                mold.electrodes.is_shown = false;
                mold.find()
            }
            Command::DesignElectrodes => mold.design(),
            Command::CompareCutters => mold.work.compare(&mold.params, &mold.other),
            _ => {
                let bounds = mold.work.mold().map(|mold| mold.shape.bounds());
                let burns = &mut mold.electrodes;
                match command {
                    Command::Electrodes => burns.is_shown = !burns.is_shown,
                    Command::FlyToRegion if burns.seen().is_some() => {
                        bounds.into_iter().for_each(|bounds| burns.fly_to_selected(bounds));
                    }
                    Command::Isolate if burns.seen().is_some() => burns.is_alone = !burns.is_alone,
                    Command::FaintMold if burns.seen().is_some() => {
                        burns.look = MoldLook::ALL[(burns.look as usize + 1) % MoldLook::ALL.len()];
                    }
                    Command::FlyToRegion => mold.fly_to = mold.selected,
                    Command::Isolate => mold.isolated = !mold.isolated,
                    Command::Layers => mold.toggle_layers(),
                    Command::FoldPanel => mold.fold_panel(),
                    Command::FoldList if mold.is_small => mold.shows_list_instead = !mold.shows_list_instead,
                    Command::FoldList => mold.shows_list = !mold.shows_list,
                    Command::FaintMold => mold.is_faint = !mold.is_faint,
                    _ => {
                        mold.colours = match mold.colours {
                            RegionColours::ByRegion => RegionColours::ByDepth,
                            RegionColours::ByDepth => RegionColours::ByRegion,
                        }
                    }
                }
                Ok(())
            }
        };
        if let Err(why) = done {
            self.core.say(EventKind::Failed, why);
        }
    }
}
