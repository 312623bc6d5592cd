//! What the window does for the workspace of flanks.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::SparkpathApp;
use crate::shell::commands::Command;
use crate::shell::dialogs::{Dialog, Intent, Work};
use crate::shell::files::{FlankPurpose, Purpose};
use crate::shell::record::Hands;
use crate::shell::workspace::Workspace;
use crate::workspaces::flank::document::flank_file::{ENDING, is_flank_file, write_flank};
use crate::workspaces::flank::document::milling_machine_file::read_milling_machines;
use crate::workspaces::flank::document::{FlankDocument, FlankSource, GuideSource, MeshFlank, PathChoice, WallsFile};
use crate::workspaces::flank::electrode_part::FlankElectrode;
use crate::workspaces::flank::panels::{Fly, is_points_file, pair_of_guides};
use crate::workspaces::news::EventKind;
use flank::machine::milling_machine::MillingMachine;
use flank::ruled_surface::Side;
use nc::flank_program::milling_post;

impl SparkpathApp {
    /// Mills the flanks of the electrode that is selected, after asking about unsaved work.
    pub(super) fn mill_flanks(&mut self, ctx: &egui::Context) {
        if let Some(electrode) = self.core.electrode_to_mill() {
            self.intend(Intent::MillFlanks(Arc::new(electrode)), ctx);
        }
    }

    /// Takes an electrode in the place of a flank of which nothing is unsaved. The cutter and the machine stay.
    pub(super) fn take_electrode(&mut self, electrode: &FlankElectrode) {
        match electrode.document(&self.core.flank.params) {
            Ok(document) => {
                self.core.flank.replace(document, None);
                self.core.workspace = Workspace::Flank;
                self.core.say(EventKind::Done, format!("flanks of {} of {}", electrode.name, electrode.of));
            }
            Err(e) => self.dialog = Dialog::Error("Its flanks cannot be milled".to_owned(), e.to_string()),
        }
    }

    /// Saves the flank, in its file if it has one and that will do.
    pub(super) fn save_flank(&mut self, in_its_file: bool, ctx: &egui::Context) {
        match self.core.flank.record.file.clone().filter(|_| in_its_file) {
            Some(file) => self.write_flank(&file, ctx),
            None => {
                let name = format!("{}{ENDING}", self.core.flank.params.name());
                self.ask(Purpose::SaveFlank, &name, ctx);
            }
        }
    }

    pub(super) fn write_flank(&mut self, file: &Path, ctx: &egui::Context) {
        match write_flank(file, &self.core.flank.params) {
            Ok(()) => {
                let flank = &mut self.core.flank;
                flank.record.saved_as(file, &flank.params);
                self.core.preferences.recent.add(file);
                self.core.say(EventKind::Done, format!("saved as {}", file.display()));
                self.saved(Work::Flank, ctx);
            }
            Err(e) => {
                self.not_saved(Work::Flank);
                self.dialog = Dialog::Error("The flank was not saved".to_owned(), e.to_string());
            }
        }
    }

    /// Keeps what is shown up with the parameters, and the log with both.
    pub(super) fn follow_flank(&mut self, ctx: &egui::Context) {
        let is_seen = self.core.workspace == Workspace::Flank;
        let news = self.core.flank.follow(Hands::of(ctx), is_seen);
        self.note_events(Workspace::Flank, news, ctx);
    }

    /// Takes a file that was dropped or opened: the points of a guide curve, or else a part with the flank.
    pub(super) fn take_for_flank(&mut self, path: &Path, ctx: &egui::Context) {
        if !is_points_file(path) {
            let mesh = FlankSource::Mesh(MeshFlank::of(path));
            return self.go_on_to(Intent::TakeSurface(Box::new(mesh)), ctx);
        }
        let both = match self.core.flank.first_guide.take() {
            // Of two after each other the first is the lower one.
            Some(lower) if lower != path => Some([lower, path.to_owned()]),
            _ => pair_of_guides(path),
        };
        match both {
            Some(both) => self.go_on_to(Intent::TakeSurface(Box::new(FlankSource::guides(both))), ctx),
            None => self.ask_for_upper(path, ctx),
        }
    }

    /// Takes two guides that were dropped together: the lower one is told by its name, or else comes first.
    pub(super) fn take_guides(&mut self, files: [PathBuf; 2], ctx: &egui::Context) {
        let named = pair_of_guides(&files[0]).filter(|pair| pair.iter().all(|file| files.contains(file)));
        let source = FlankSource::guides(named.unwrap_or(files));
        self.go_on_to(Intent::TakeSurface(Box::new(source)), ctx);
    }

    /// Keeps the lower guide until the upper one is named: one alone is no surface.
    fn ask_for_upper(&mut self, lower: &Path, ctx: &egui::Context) {
        self.core.flank.first_guide = Some(lower.to_owned());
        self.core.say_in_passing("This is the lower guide: choose or drop the upper one");
        self.ask(Purpose::Flank(FlankPurpose::Upper), "", ctx);
    }

    /// No upper guide was named: the lower one that waited for it is not taken.
    pub(super) fn forget_first_guide(&mut self) {
        if self.core.flank.first_guide.take().is_some() {
            self.core.say_in_passing("No upper guide was named: the lower one is not taken either");
        }
    }

    /// Takes another mesh, in place of one as what the user goes on with.
    fn take_mesh(&mut self, path: PathBuf, ctx: &egui::Context) {
        let FlankSource::Mesh(mesh) = &self.core.flank.params.source else {
            return self.go_on_to(Intent::TakeSurface(Box::new(FlankSource::Mesh(MeshFlank::of(&path)))), ctx);
        };
        let source = FlankSource::Mesh(MeshFlank { file: path, candidate: 1, kept: None, ..mesh.clone() });
        self.edit_flank(|params| {
            (params.source, params.side) = (source, Side::Automatic);
            params.overrides.clear();
        });
    }

    /// Whether a path that is named for this takes the place of the whole flank.
    pub(super) fn is_another_flank(&self, what: FlankPurpose) -> bool {
        let source = &self.core.flank.params.source;
        match what {
            FlankPurpose::Open => true,
            FlankPurpose::Mesh => !matches!(source, FlankSource::Mesh(_)),
            FlankPurpose::Lower | FlankPurpose::Upper => !matches!(source, FlankSource::Guides { .. }),
            _ => false,
        }
    }

    /// Takes another guide curve: the surface is another one, and what was decided on the former one does not hold for it.
    fn take_guide(&mut self, change: impl FnOnce(&mut GuideSource, &mut GuideSource)) {
        self.edit_flank(|params| {
            if let FlankSource::Guides { lower, upper } = &mut params.source {
                change(lower, upper);
                params.overrides.clear();
            }
        });
    }

    fn edit_flank(&mut self, change: impl FnOnce(&mut FlankDocument)) {
        let mut params = self.core.flank.params.clone();
        change(&mut params);
        self.core.flank.edit(params);
    }

    /// Goes on with a path that was named for something of the flank.
    pub(super) fn take_flank_path(&mut self, what: FlankPurpose, path: PathBuf, ctx: &egui::Context) {
        match what {
            FlankPurpose::Open if is_flank_file(&path) => self.go_on_to(Intent::OpenFlank(path), ctx),
            FlankPurpose::Open => self.take_for_flank(&path, ctx),
            FlankPurpose::Mesh => self.take_mesh(path, ctx),
            FlankPurpose::Lower => match (&self.core.flank.params.source, pair_of_guides(&path)) {
                (FlankSource::Guides { .. }, _) => self.take_guide(|lower, _| *lower = GuideSource::File(path)),
                (_, Some(both)) => self.go_on_to(Intent::TakeSurface(Box::new(FlankSource::guides(both))), ctx),
                // One alone is no surface.
                (_, None) => self.ask_for_upper(&path, ctx),
            },
            FlankPurpose::Upper => match (self.core.flank.first_guide.take(), &self.core.flank.params.source) {
                (Some(lower), _) => {
                    let source = FlankSource::guides([lower, path]);
                    self.go_on_to(Intent::TakeSurface(Box::new(source)), ctx);
                }
                (None, FlankSource::Guides { .. }) => self.take_guide(|_, upper| *upper = GuideSource::File(path)),
                (None, _) => {}
            },
            FlankPurpose::Walls => {
                self.edit_flank(|params| params.walls = Some(WallsFile { file: path, units: Default::default() }));
            }
            FlankPurpose::Machine => self.take_milling_machine(&path),
            FlankPurpose::Post => match milling_post(&path.to_string_lossy()) {
                Ok(_) => self.edit_flank(|params| params.milling.post = path.to_string_lossy().into_owned()),
                Err(e) => self.dialog = Dialog::Error("This is no post".to_owned(), e.to_string()),
            },
            FlankPurpose::Folder => self.export_flank(&path),
        }
    }

    /// Takes the machine in this file; of several the first one, and the others are in the list.
    fn take_milling_machine(&mut self, file: &Path) {
        let machines = match read_milling_machines(file) {
            Ok(machines) => machines,
            Err(e) => {
                self.dialog = Dialog::Error("This is no milling machine".to_owned(), e.to_string());
                return;
            }
        };
        let name = file.to_string_lossy().into_owned();
        let is_one = machines.len() == 1;
        let named = |machine: &MillingMachine| if is_one { name.clone() } else { format!("{name}#{}", machine.name) };
        let Some(first) = machines.first().map(named) else { return };
        let listed = &mut self.core.flank.machines;
        for machine in machines.iter().filter(|_| !is_one) {
            let name = named(machine);
            if listed.iter().all(|[other, _]| *other != name) {
                listed.push([name, machine.title.clone()]);
            }
        }
        let mut forgotten = None;
        self.edit_flank(|params| forgotten = params.milling.take_machine(&first));
        if let Some(forgotten) = forgotten {
            self.core.say_in_passing(forgotten);
        }
    }

    /// Writes the files of the plan into `folder`; says why not if it cannot.
    pub fn export_flank(&mut self, folder: &Path) {
        let flank = &mut self.core.flank;
        if let Err(why) = flank.work.export(&flank.params, folder, flank.choice) {
            self.dialog = Dialog::Error("Nothing was exported".to_owned(), why);
        }
    }

    /// Does a command that means something else for flanks than elsewhere. Tells whether it was one.
    pub(super) fn run_on_flank(&mut self, command: Command, ctx: &egui::Context) -> bool {
        let flank = &mut self.core.flank;
        match command {
            Command::Open => self.intend(Intent::Ask(Purpose::Flank(FlankPurpose::Open)), ctx),
            Command::Reload => flank.work.reload(),
            Command::Save | Command::SaveAs => self.save_flank(command == Command::Save, ctx),
            Command::Undo | Command::Redo => flank.undo(command == Command::Redo),
            Command::Cancel => flank.work.cancel(),
            Command::Export => {
                flank.changed_files = flank.work.changed_files(&flank.params);
                self.dialog = Dialog::ExportFlank;
            }
            Command::PlanFlank => {
                if let Err(why) = flank.plan() {
                    self.core.say(EventKind::Failed, why);
                }
            }
            Command::NextPath => flank.path = PathChoice::ALL[(flank.path as usize + 1) % PathChoice::ALL.len()],
            Command::SideBySide => {
                flank.is_side_by_side = !flank.is_side_by_side;
                flank.fly = Some(if flank.is_side_by_side { Fly::Square } else { Fly::Onto });
            }
            Command::FaceFlank => flank.fly = Some(Fly::Square),
            Command::ShowCutter => flank.toggle_cutter(),
            Command::AxisSurface => flank.shows_axis = !flank.shows_axis,
            Command::Rulings => flank.shows_rulings = !flank.shows_rulings,
            Command::MovingCutter => flank.is_moving = !flank.is_moving,
            Command::FoldPanel => flank.shows_panel = !flank.shows_panel,
            Command::FoldList => flank.shows_list = !flank.shows_list,
            Command::Play => flank.play(),
            Command::NextNode | Command::PreviousNode => flank.step(command == Command::NextNode),
            Command::FirstNode | Command::LastNode => flank.go_to(if command == Command::LastNode { 1.0 } else { 0.0 }),
            _ => return false,
        }
        true
    }
}
