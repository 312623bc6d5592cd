//! The workspace of molds: what milling cutters leave uncut, found, listed, looked at, compared. Like the rest of the
//! window it computes nothing.

mod compare;
mod cutters;
pub mod datum_pick;
pub mod desk;
mod electrode;
mod list;
mod panel;
mod strip;
pub mod view;

use crate::workspaces::context::Context;
use crate::workspaces::mold::commands::MoldCommand;
use egui::{Panel, Ui};

use crate::workspaces::mold::paths::MoldPath;
use desk::MoldDesk;
use view::MoldView;

/// Draws the workspace. Returns the purpose of the path to ask for, if any.
pub fn show(ui: &mut Ui, desk: &mut MoldDesk, cx: &mut Context, view: &mut MoldView) -> Option<MoldPath> {
    let room = ui.available_width();
    // In a small window the view comes first: panels get narrower, and the list has one only in the place of the other.
    let wide = room > 900.0;
    desk.is_small = !wide;
    let is_listed = if wide { desk.shows_list } else { desk.shows_list_instead };
    let is_formed = desk.shows_panel && (wide || !is_listed);
    let asked = if is_formed {
        let (least, width) = if wide { (320.0, 0.32 * room) } else { (300.0, 0.5 * room) };
        let width = width.clamp(least, 412.0);
        let panel = Panel::left("mold").default_size(width).size_range(least..=(0.45 * room).clamp(width, 520.0));
        panel.show(ui, |ui| panel::show(ui, desk, cx, !wide)).inner
    } else {
        None
    };
    if is_listed {
        let width = if wide { (0.35 * room - 100.0).clamp(228.0, 348.0) } else { (0.5 * room).clamp(228.0, 412.0) };
        let list = Panel::right(if wide { "regions" } else { "regions instead" })
            .default_size(width)
            .size_range(228.0..=(0.4 * room).clamp(width, 480.0));
        list.show(ui, |ui| list::lists(ui, desk, cx));
    }
    egui::CentralPanel::no_frame().show(ui, |ui| {
        let rect = ui.available_rect_before_wrap();
        view.show(ui, desk, cx);
        cx.folds(ui, rect, (MoldCommand::FoldPanel, is_formed), Some((MoldCommand::FoldList, is_listed)));
    });
    asked
}
