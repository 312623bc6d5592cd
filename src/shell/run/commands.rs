//! Commands carried out.

use super::SparkpathApp;
use crate::shell::commands::Command;
use crate::shell::dialogs::{Dialog, Intent};
use crate::shell::files::Purpose;
use crate::shell::preferences::ThemeChoice;
use crate::shell::workspace::Workspace;
use crate::workspaces::blisk::document::stage::Stage;
use crate::workspaces::blisk::panels::forms;
use crate::workspaces::blisk::panels::plots::Tab;
use crate::workspaces::news::EventKind;
use render::scene::SectionPlane;
use render::view::StandardView;

impl SparkpathApp {
    pub(super) fn run(&mut self, command: Command, ctx: &egui::Context) {
        if !command.is_enabled(&self.core) {
            return;
        }
        match command {
            Command::Cancel if self.core.opening.is_busy() => self.core.opening.cancel(),
            Command::NewDemonstration => self.intend(Intent::Demonstration, ctx),
            _ if self.core.workspace == Workspace::Flank && self.run_on_flank(command, ctx) => {}
            Command::Open
            | Command::Quit
            | Command::Reload
            | Command::Save
            | Command::SaveAs
            | Command::SaveJob
            | Command::Undo
            | Command::Redo
            | Command::Export
            | Command::Screenshot => self.run_on_document(command, ctx),
            Command::Preferences
            | Command::Theme
            | Command::Palette
            | Command::Log
            | Command::About
            | Command::Workspace(_) => self.run_on_window(command, ctx),
            Command::Plan
            | Command::Cancel
            | Command::Release
            | Command::Withdraw
            | Command::Step(_)
            | Command::Keep
            | Command::MillFlanks => self.run_on_plan(command, ctx),
            Command::Fit
            | Command::View(_)
            | Command::Projection
            | Command::IntoChannel
            | Command::WholeBlisk
            | Command::Ghost
            | Command::Section
            | Command::Measure
            | Command::Leftover
            | Command::Colours => self.run_on_view(command, ctx),
            // Flanks have their own.
            Command::PlanFlank
            | Command::NextPath
            | Command::SideBySide
            | Command::FaceFlank
            | Command::ShowCutter
            | Command::AxisSurface
            | Command::Rulings
            | Command::MovingCutter => {}
            Command::FindUncut
            | Command::DesignElectrodes
            | Command::Electrodes
            | Command::CompareCutters
            | Command::FlyToRegion
            | Command::Isolate
            | Command::Layers
            | Command::DepthColours
            | Command::FaintMold
            | Command::FoldPanel
            | Command::FoldList => self.run_on_mold(command),
            Command::Play | Command::NextNode | Command::PreviousNode | Command::FirstNode | Command::LastNode => {
                if self.is_of_mold() {
                    return self.step_along_burn(command);
                }
                self.step_along(command);
            }
        }
    }

    fn is_of_mold(&self) -> bool {
        self.core.workspace == Workspace::Mold
    }

    /// Files of the present workspace, and its steps that can be undone.
    fn run_on_document(&mut self, command: Command, ctx: &egui::Context) {
        let is_of_mold = self.is_of_mold();
        match command {
            Command::Open if is_of_mold => self.intend(Intent::Ask(Purpose::Mold), ctx),
            Command::Open => self.intend(Intent::Ask(Purpose::Open), ctx),
            Command::Quit => self.intend(Intent::Quit, ctx),
            Command::Reload if is_of_mold => self.core.mold.work.reload(),
            Command::Reload => self.core.pipeline.reload(),
            Command::Save | Command::SaveAs if is_of_mold => self.save_mold(command == Command::Save, ctx),
            Command::Save => self.save(ctx),
            Command::SaveAs => self.ask_where_to_save(ctx),
            Command::SaveJob => {
                let name = format!("{}.toml", self.core.document.name());
                self.ask(Purpose::SaveJob, &name, ctx);
            }
            Command::Undo | Command::Redo if is_of_mold => self.core.mold.undo(command == Command::Redo),
            Command::Undo => drop(self.core.document.undo()),
            Command::Redo => drop(self.core.document.redo()),
            Command::Export if is_of_mold => self.ask(Purpose::ElectrodeFolder, "", ctx),
            Command::Export => self.dialog = Dialog::Export,
            Command::Screenshot => {
                let name = match self.core.workspace {
                    Workspace::Blisk => self.core.document.name(),
                    Workspace::Mold => self.core.mold.params.name(),
                    Workspace::Flank => self.core.flank.params.name(),
                };
                let name = format!("{name}.png");
                self.ask(Purpose::Picture, &name, ctx);
            }
            _ => {}
        }
    }

    /// What belongs to the window itself.
    fn run_on_window(&mut self, command: Command, ctx: &egui::Context) {
        match command {
            Command::Preferences => self.dialog = Dialog::Preferences,
            Command::Theme => {
                let dark = ctx.theme() == egui::Theme::Dark;
                self.core.preferences.theme = if dark { ThemeChoice::Light } else { ThemeChoice::Dark };
            }
            Command::Palette => self.palette.toggle(),
            Command::Log => self.log_open = !self.log_open,
            Command::About => self.dialog = Dialog::About,
            Command::Workspace(workspace) => self.core.workspace = workspace,
            _ => {}
        }
    }

    /// Plans, and what is decided on them.
    fn run_on_plan(&mut self, command: Command, ctx: &egui::Context) {
        let is_of_mold = self.is_of_mold();
        match command {
            Command::Plan => self.plan(),
            // What is being drawn is given up first.
            Command::Cancel if is_of_mold && self.core.mold.electrodes.split.is_some() => {
                self.core.mold.electrodes.give_up_split();
            }
            Command::Cancel if is_of_mold => self.core.mold.cancel(),
            Command::Cancel => self.core.pipeline.cancel(),
            Command::Release => self.release(),
            Command::Withdraw => self.core.pipeline.withdraw(),
            Command::Step(stage) => self.core.step = stage,
            Command::Keep => self.core.keep(),
            Command::MillFlanks => self.mill_flanks(ctx),
            _ => {}
        }
    }

    /// Where the view looks from, and what it shows.
    fn run_on_view(&mut self, command: Command, ctx: &egui::Context) {
        let now = ctx.input(|i| i.time);
        match command {
            Command::Fit => self.seen_mut().fit(false),
            Command::View(view) => self.seen_mut().look(view, now),
            Command::Projection => self.seen_mut().toggle_projection(),
            Command::IntoChannel => {
                self.core.layers.into_channel();
                self.viewport.look_into_channel(&self.core, now);
            }
            Command::WholeBlisk => {
                self.core.layers.whole_blisk();
                self.viewport.look(StandardView::Isometric, now);
            }
            Command::Ghost => self.core.toggle_ghost(),
            Command::Section if self.is_of_mold() => self.core.mold.electrodes.toggle_cut(),
            Command::Section => self.toggle_section(),
            Command::Measure => {
                self.core.measuring = !self.core.measuring;
                self.viewport.clear_probe();
            }
            Command::Leftover => {
                self.core.toggle_leftover();
                if self.core.leftover {
                    self.viewport.look_into_channel(&self.core, now);
                }
            }
            Command::Colours => self.core.colours = !self.core.colours,
            _ => {}
        }
    }

    pub(super) fn plan(&mut self) {
        // Its form marks the value and says what it may be.
        if let Some(stage) = Stage::ALL.into_iter().find(|stage| forms::has_problem(&self.core, *stage)) {
            self.core.step = stage;
            let text = format!("Step {} has a value out of range; it is marked there.", stage.name());
            self.dialog = Dialog::Error("The plan cannot be started".to_owned(), text);
            return;
        }
        match self.core.pipeline.start_plan() {
            Ok(()) => {
                self.core.step = self.core.step.max(Stage::Plan);
                self.core.say(EventKind::Done, "planning");
                self.tab = if self.tab == Tab::Table { Tab::Table } else { Tab::Positions };
            }
            Err(why) => self.dialog = Dialog::Error("The plan cannot be started".to_owned(), why),
        }
    }

    pub(super) fn release(&mut self) {
        match self.core.pipeline.release() {
            Ok(()) => self.core.say(EventKind::Done, "the plan is released for export"),
            Err(why) => self.dialog = Dialog::Error("Not released".to_owned(), why),
        }
    }

    pub(super) fn step_along(&mut self, command: Command) {
        let track = self.core.shared_track();
        let cursor = &mut self.core.cursor;
        if command == Command::Play {
            cursor.playing = !cursor.playing;
            if self.core.machine.shown().is_some() {
                if cursor.playing && self.core.machine.advance(0.0) == Some(false) {
                    self.core.machine.go_to(Some(0.0));
                }
                return;
            }
            if cursor.playing && cursor.s <= 0.0 {
                cursor.s = track.length();
            }
            return;
        }
        self.core.machine.go_to(None);
        cursor.playing = false;
        cursor.s = match command {
            Command::NextNode => track.next_node(cursor.s),
            Command::PreviousNode => track.previous_node(cursor.s),
            Command::FirstNode => track.length(),
            _ => 0.0,
        };
    }

    pub(super) fn toggle_section(&mut self) {
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
}
