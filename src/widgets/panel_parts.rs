//! Parts that the panels of several workspaces are made of.

use egui::{CollapsingHeader, Rect, RichText, Ui, UiBuilder, vec2};

/// A part of a panel that folds.
pub fn section(ui: &mut Ui, name: &str, open: bool, body: impl FnOnce(&mut Ui)) {
    let title = RichText::new(name).strong();
    CollapsingHeader::new(title).id_salt(name).default_open(open).show_unindented(ui, |ui| {
        body(ui);
        ui.add_space(6.0);
    });
}

/// A name before what is chosen, as in the forms of the other workspace.
pub fn named<R>(ui: &mut Ui, name: &str, add: impl FnOnce(&mut Ui, egui::Id) -> R) -> R {
    let row = ui.horizontal(|ui| {
        let layout = egui::Layout::left_to_right(egui::Align::Center);
        let label = ui.allocate_ui_with_layout(vec2(84.0, 22.0), layout, |ui| {
            ui.set_min_width(84.0);
            ui.label(name).id
        });
        add(ui, label.inner)
    });
    row.inner
}

/// Row number `i` from below over the view in `rect`.
pub fn row(ui: &mut Ui, rect: Rect, i: usize, add: impl FnOnce(&mut Ui)) {
    let width = (rect.width() - 16.0).min(560.0);
    let area = Rect::from_min_size(rect.left_bottom() + vec2(8.0, -40.0 - 36.0 * i as f32), vec2(width, 32.0));
    let layout = egui::Layout::left_to_right(egui::Align::Center);
    let mut child = ui.new_child(UiBuilder::new().max_rect(area.shrink2(vec2(8.0, 0.0))).layout(layout));
    child.painter().rect_filled(area, 5.0, child.visuals().window_fill.gamma_multiply(0.92));
    add(&mut child);
}
