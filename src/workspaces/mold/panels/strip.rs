//! The strip over the view that goes through the layers.

use crate::workspaces::mold::panels::desk::MoldDesk;
use egui::{Rect, RichText, Slider, Ui, UiBuilder, vec2};

use super::list::{dim, stale};
use crate::widgets::theme::palette;

/// Draws the strip, if layers are looked at.
pub fn show(ui: &mut Ui, rect: Rect, desk: &mut MoldDesk) {
    let Some(found) = desk.found().cloned() else { return };
    let (layers, Some(number)) = (&found.uncut.layers, desk.layer) else { return };
    let Some(layer) = layers.get(number) else { return };
    let width = (rect.width() - 16.0).min(620.0);
    let area = Rect::from_min_size(rect.left_bottom() + vec2(8.0, -40.0), vec2(width, 32.0));
    let layout = egui::Layout::left_to_right(egui::Align::Center);
    let mut child = ui.new_child(UiBuilder::new().max_rect(area.shrink2(vec2(8.0, 0.0))).layout(layout));
    child.painter().rect_filled(area, 5.0, child.visuals().window_fill.gamma_multiply(0.92));
    child.spacing_mut().slider_width = (width - 390.0).clamp(60.0, 260.0);
    let label = child.label(RichText::new("Layer").color(palette(&child).faint));
    let mut at = number;
    let last = layers.len() - 1;
    if child.add_enabled(at > 0, egui::Button::new("\u{23f4}")).on_hover_text("The next one below").clicked() {
        at -= 1;
    }
    child.add(Slider::new(&mut at, 0..=last).show_value(false)).labelled_by(label.id);
    if child.add_enabled(at < last, egui::Button::new("\u{23f5}")).on_hover_text("The next one above").clicked() {
        at += 1;
    }
    desk.layer = Some(at);
    stale(&mut child, desk);
    dim(&mut child, desk);
    child.label(RichText::new(format!("z {:.3} mm", layer.z)).monospace());
    if child.available_width() > 150.0 {
        let text = format!("{:.2} mm, {:.3} mm² uncut", layer.segment_length, layer.area);
        let said = child.label(RichText::new(text).small().color(palette(&child).faint));
        said.on_hover_text("Length of the outline that no cutter touches in this layer, and the uncut area");
    }
}
