//! What the window does for the workspace of flanks.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::SparkpathApp;
use crate::app::commands::Command;
use crate::app::dialogs::{Dialog, Intent, Work};
use crate::app::files::{FlankPurpose, Purpose};
use crate::app::flank::Fly;
use crate::app::record::Hands;
use crate::app::workspace::Workspace;
use crate::jobs::flank_electrode::FlankElectrode;
use crate::jobs::pipeline::EventKind;
use crate::project::flank_file::{ENDING, is_flank_file, read_flank, write_flank};
use crate::project::flank_params::{FlankDocument, FlankSource, GuideSource, MeshFlank, PathChoice, WallsFile};

impl SparkpathApp {
    /// Takes the flank that was saved at `path`, in whose place there was no unsaved work.
    pub fn open_flank(&mut self, path: &Path) {
        match read_flank(path) {
            Ok(document) => {
                self.core.flank.replace(document, Some(path));
                self.core.preferences.recent.add(path);
                self.core.say(EventKind::Done, format!("{} opened", self.core.flank.name()));
            }
            Err(e) => {
                self.core.preferences.recent.remove(path);
                self.dialog = Dialog::Error("This flank cannot be opened".to_owned(), e.to_string());
            }
        }
    }

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
        let (events, wait) = self.core.flank.follow(Hands::of(ctx), is_seen);
        self.note_events(events, wait, ctx);
    }

    /// Takes a file that was dropped: points for the guide curve that comes next, or else a part with the flank.
    pub(super) fn take_for_flank(&mut self, path: &Path) {
        let is = |ending: &str| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(ending));
        if !is("csv") && !is("txt") {
            return self.take_mesh(path);
        }
        // Of two dropped after each other the first is the lower one.
        let source = match &self.core.flank.params.source {
            FlankSource::Guides { lower: GuideSource::File(lower), upper: GuideSource::File(upper) }
                if lower == upper && lower != path =>
            {
                FlankSource::Guides { lower: GuideSource::File(lower.clone()), upper: file(path) }
            }
            _ => FlankSource::Guides { lower: file(path), upper: file(path) },
        };
        self.edit_flank(|params| params.source = source);
    }

    fn take_mesh(&mut self, path: &Path) {
        let path = path.to_owned();
        self.edit_flank(|params| {
            params.source = match &params.source {
                FlankSource::Mesh(mesh) => {
                    FlankSource::Mesh(MeshFlank { file: path, candidate: 1, kept: None, ..mesh.clone() })
                }
                _ => FlankSource::Mesh(MeshFlank::of(&path)),
            };
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
            FlankPurpose::Open if is_flank_file(&path) => self.intend(Intent::OpenFlank(path), ctx),
            FlankPurpose::Open => self.take_for_flank(&path),
            FlankPurpose::Mesh => self.take_mesh(&path),
            FlankPurpose::Lower => {
                // The other curve is asked for as well where there is none yet.
                let is_first = !matches!(self.core.flank.params.source, FlankSource::Guides { .. });
                self.edit_flank(|params| {
                    let upper = match &params.source {
                        FlankSource::Guides { upper, .. } => upper.clone(),
                        _ => file(&path),
                    };
                    params.source = FlankSource::Guides { lower: file(&path), upper };
                });
                if is_first {
                    self.ask(Purpose::Flank(FlankPurpose::Upper), "", ctx);
                }
            }
            FlankPurpose::Upper => self.edit_flank(|params| {
                let lower = match &params.source {
                    FlankSource::Guides { lower, .. } => lower.clone(),
                    _ => file(&path),
                };
                params.source = FlankSource::Guides { lower, upper: file(&path) };
            }),
            FlankPurpose::Walls => {
                self.edit_flank(|params| params.walls = Some(WallsFile { file: path, units: Default::default() }));
            }
            FlankPurpose::Machine => {
                self.edit_flank(|params| params.milling.machine = path.to_string_lossy().into_owned());
            }
            FlankPurpose::Folder => self.export_flank(&path),
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
            Command::Open => self.ask(Purpose::Flank(FlankPurpose::Open), "", ctx),
            Command::Reload => flank.work.reload(),
            Command::Save | Command::SaveAs => self.save_flank(command == Command::Save, ctx),
            Command::Undo | Command::Redo => flank.undo(command == Command::Redo),
            Command::Cancel => flank.work.cancel(),
            Command::Export => self.dialog = Dialog::ExportFlank,
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
            Command::ShowCutter => flank.shows_cutter = !flank.shows_cutter,
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

fn file(path: &Path) -> GuideSource {
    GuideSource::File(path.to_owned())
}
