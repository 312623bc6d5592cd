//! The workspace of molds: what milling cutters leave uncut, found, listed, looked at, compared. Like the rest of the
//! window it computes nothing.

mod compare;
mod cutters;
mod desk;
mod electrode;
mod list;
mod panel;
mod strip;
mod view;

pub use desk::MoldDesk;
pub use electrode::ElectrodeDesk;
pub use list::Column;
pub use view::MoldView;

use egui::{Panel, Role, Ui, WidgetInfo};

use crate::shell::commands::Command;
use crate::shell::core::Core;
use crate::shell::files::Purpose;
use crate::widgets::folds;

/// Draws the workspace. Answers what a path is wanted for.
pub fn show(ui: &mut Ui, core: &mut Core, view: &mut MoldView) -> Option<Purpose> {
    let room = ui.available_width();
    // In a small window the view comes first: panels get narrower, and the list has one only in the place of the other.
    let wide = room > 900.0;
    core.mold.is_small = !wide;
    let is_listed = if wide { core.mold.shows_list } else { core.mold.shows_list_instead };
    let is_formed = core.mold.shows_panel && (wide || !is_listed);
    let asked = if is_formed {
        let (least, width) = if wide { (320.0, 0.32 * room) } else { (300.0, 0.5 * room) };
        let width = width.clamp(least, 412.0);
        let panel = Panel::left("mold").default_size(width).size_range(least..=(0.45 * room).clamp(width, 520.0));
        panel.show(ui, |ui| panel::show(ui, core, !wide)).inner
    } else {
        None
    };
    if is_listed {
        let width = if wide { (0.35 * room - 100.0).clamp(228.0, 348.0) } else { (0.5 * room).clamp(228.0, 412.0) };
        let list = Panel::right(if wide { "regions" } else { "regions instead" })
            .default_size(width)
            .size_range(228.0..=(0.4 * room).clamp(width, 480.0));
        list.show(ui, |ui| lists(ui, core));
    }
    egui::CentralPanel::no_frame().show(ui, |ui| {
        let rect = ui.available_rect_before_wrap();
        view.show(ui, core);
        folds::show(ui, rect, core, is_formed, Some(is_listed));
    });
    asked
}

/// The list of regions or that of electrodes.
fn lists(ui: &mut Ui, core: &mut Core) {
    if core.mold.electrodes.designed().is_some() {
        ui.add_space(2.0);
        ui.horizontal(|ui| {
            for (name, is_shown) in [("Regions", false), ("Electrodes", true)] {
                let is_on = core.mold.electrodes.is_shown == is_shown;
                let response = ui.selectable_label(is_on, name).on_hover_text(Command::Electrodes.hint(ui.ctx()));
                response.widget_info(|| WidgetInfo::selected(Role::Tab, true, is_on, format!("List of {name}")));
                if response.clicked() && !is_on {
                    core.push(Command::Electrodes);
                }
            }
        });
    }
    if core.mold.electrodes.seen().is_some() { electrode::list(ui, core) } else { list::show(ui, core) }
}
