//! The workspace of molds: what milling cutters leave uncut, found, listed, looked at, compared. Like the rest of the
//! window it computes nothing.

mod compare;
mod cutters;
mod desk;
mod list;
mod panel;
mod strip;
mod view;

pub use desk::MoldDesk;
pub use list::Column;
pub use view::MoldView;

use egui::{Panel, Ui};

use super::core::Core;
use super::files::Purpose;

/// Draws the workspace. Answers what a path is wanted for.
pub fn show(ui: &mut Ui, core: &mut Core, view: &mut MoldView) -> Option<Purpose> {
    let room = ui.available_size();
    // In a small window the view comes first.
    let wide = room.x > 900.0;
    let left = if wide { 412.0 } else { (0.5 * room.x).clamp(260.0, 412.0) };
    let asked = Panel::left("mold")
        .default_size(left)
        .size_range(left.min(356.0)..=left.max(520.0).min(0.55 * room.x).max(left))
        .show(ui, |ui| panel::show(ui, core, !wide))
        .inner;
    if wide {
        let list = Panel::right("regions").default_size(348.0).size_range(300.0..=480.0);
        list.show(ui, |ui| list::show(ui, core));
    }
    egui::CentralPanel::no_frame().show(ui, |ui| view.show(ui, core));
    asked
}
