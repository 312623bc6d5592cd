//! The handles at the edges of the view that fold the panels beside it.

use egui::{Align2, FontId, Rect, Role, Sense, Ui, WidgetInfo, vec2};

use super::theme::palette;

/// A panel beside the view that folds.
pub struct Folding<'a> {
    /// Whether the panel is on the left.
    pub is_left: bool,
    /// Whether the panel is shown, not folded.
    pub is_there: bool,
    /// The name of its handle.
    pub name: &'a str,
    /// The name with the keys, if there are any.
    pub hint: String,
}

/// Draws the handles over the view in `rect`. Answers the number of the one that was clicked.
pub fn show(ui: &mut Ui, rect: Rect, panels: &[Folding]) -> Option<usize> {
    const SIZE: egui::Vec2 = vec2(12.0, 46.0);
    let inwards = vec2(0.5 * SIZE.x, 0.0);
    let mut clicked = None;
    for (i, panel) in panels.iter().enumerate() {
        let at = if panel.is_left { rect.left_center() + inwards } else { rect.right_center() - inwards };
        if handle(ui, Rect::from_center_size(at, SIZE), panel) {
            clicked = Some(i);
        }
    }
    clicked
}

/// A handle of a folded panel, which points to where the panel goes. Answers whether it was clicked.
fn handle(ui: &mut Ui, rect: Rect, panel: &Folding) -> bool {
    let response = ui.interact(rect, ui.scope_id().with(("fold", panel.name)), Sense::click());
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, panel.name));
    let visuals = ui.visuals();
    let (fill, ink) = if response.hovered() {
        (visuals.widgets.hovered.weak_bg_fill, visuals.strong_text_color())
    } else {
        (visuals.window_fill.gamma_multiply(0.88), palette(ui).faint)
    };
    ui.painter().rect_filled(rect, 3.0, fill);
    let points_right = panel.is_left != panel.is_there;
    let sign = if points_right { "\u{23f5}" } else { "\u{23f4}" };
    ui.painter().text(rect.center(), Align2::CENTER_CENTER, sign, FontId::proportional(10.0), ink);
    response.on_hover_text(&panel.hint).clicked()
}
