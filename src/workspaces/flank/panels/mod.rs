//! The workspace of flanks: a ruled surface, the cutter that mills it with its side, the path in three steps, and what
//! was checked of it. Like the rest of the window it computes nothing.

pub mod desk;
pub mod export;
mod form;
pub mod guides;
mod plots;
mod results;
mod source;
mod timeline;
pub mod view;

use crate::workspaces::context::Context;
use egui::{Panel, Ui};

use crate::workspaces::flank::commands::FlankCommand;
use crate::workspaces::flank::paths::FlankPath;
use desk::FlankDesk;
use view::FlankView;

/// Height of the panel of timeline and plots (points).
const PLOTS: f32 = 236.0;
/// Height of the panel where there is room for the timeline only (points).
const TIMELINE: f32 = 74.0;

/// Draws the workspace. Returns the purpose of the path to ask for, if any.
pub fn show(ui: &mut Ui, desk: &mut FlankDesk, cx: &mut Context, view: &mut FlankView) -> Option<FlankPath> {
    let room = ui.available_size();
    // In a small window the view comes first: panels get narrower, and the results have none of their own.
    let (wide, tall) = (room.x > 900.0, room.y > 480.0);
    let asked = if desk.shows_panel {
        let (least, width) = if wide { (300.0, 0.26 * room.x) } else { (290.0, 0.5 * room.x) };
        let width = width.clamp(least, 380.0);
        let panel = Panel::left("flank").default_size(width).size_range(least..=(0.45 * room.x).clamp(width, 480.0));
        // In a part of its own, so that no text of a moment makes the panel wider.
        let own = |ui: &mut Ui| {
            let rect = ui.available_rect_before_wrap();
            let asked = form::show(&mut ui.new_child(egui::UiBuilder::new().max_rect(rect)), desk, cx, !wide);
            ui.allocate_rect(rect, egui::Sense::hover());
            asked
        };
        panel.show(ui, own).inner
    } else {
        None
    };
    if wide && desk.shows_list {
        let width = (0.32 * room.x - 100.0).clamp(262.0, 340.0);
        let panel = Panel::right("flank results").default_size(width);
        let panel = panel.size_range(240.0..=(0.4 * room.x).clamp(width, 460.0));
        panel.show(ui, |ui| results::show(ui, desk));
    }
    // A low window has room for the plots or for the view.
    let low = PLOTS.min(0.6 * room.y).max(TIMELINE);
    let (name, height, heights) = match (tall, desk.shows_plots) {
        (true, _) => ("flank plots", PLOTS, 150.0..=460.0),
        (false, true) => ("flank low plots", low, low..=low),
        (false, false) => ("flank timeline", TIMELINE, TIMELINE..=TIMELINE),
    };
    Panel::bottom(name).default_size(height).size_range(heights).resizable(tall).show(ui, |ui| {
        timeline::show(ui, desk, cx, !tall);
        if tall || desk.shows_plots {
            plots::show(ui, desk);
        }
        // The panel keeps its height whatever it shows.
        ui.take_available_space();
    });
    egui::CentralPanel::no_frame().show(ui, |ui| {
        let rect = ui.available_rect_before_wrap();
        view.show(ui, desk, cx);
        let results = wide.then_some((FlankCommand::FoldList, desk.shows_list));
        cx.folds(ui, rect, (FlankCommand::FoldPanel, desk.shows_panel), results);
    });
    asked
}
