//! The handles at the edges of the view that fold the panels beside it.

use egui::{Align2, FontId, Rect, Role, Sense, Ui, WidgetInfo, vec2};

use super::theme::palette;
use crate::shell::commands::Command;
use crate::shell::core::Core;

/// Draws them over the view in `rect`, with whether the panel on the left is there, and that on the right if it has one
/// of its own.
pub fn show(ui: &mut Ui, rect: Rect, core: &mut Core, shows_panel: bool, shows_list: Option<bool>) {
    const SIZE: egui::Vec2 = vec2(12.0, 46.0);
    let [left, right] = [rect.left_center(), rect.right_center()];
    let inwards = vec2(0.5 * SIZE.x, 0.0);
    handle(ui, Rect::from_center_size(left + inwards, SIZE), core, Command::FoldPanel, !shows_panel);
    if let Some(shows_list) = shows_list {
        handle(ui, Rect::from_center_size(right - inwards, SIZE), core, Command::FoldList, shows_list);
    }
}

/// One of them, which points to the right or to the left.
fn handle(ui: &mut Ui, rect: Rect, core: &mut Core, command: Command, points_right: bool) {
    let response = ui.interact(rect, ui.scope_id().with(("fold", command.name())), Sense::click());
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, command.name()));
    let visuals = ui.visuals();
    let (fill, ink) = if response.hovered() {
        (visuals.widgets.hovered.weak_bg_fill, visuals.strong_text_color())
    } else {
        (visuals.window_fill.gamma_multiply(0.88), palette(ui).faint)
    };
    ui.painter().rect_filled(rect, 3.0, fill);
    let sign = if points_right { "\u{23f5}" } else { "\u{23f4}" };
    ui.painter().text(rect.center(), Align2::CENTER_CENTER, sign, FontId::proportional(10.0), ink);
    if response.on_hover_text(command.hint(ui.ctx())).clicked() {
        core.push(command);
    }
}
