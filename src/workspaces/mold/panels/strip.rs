//! The strips over the view: through the layers, and for picking the work datum.

use crate::workspaces::commands::{CommandSet, FrameCommand};
use crate::workspaces::mold::panels::desk::MoldDesk;
use egui::{Rect, RichText, Slider, Ui};

use super::list::{dim, stale};
use crate::widgets::panel_parts::row;
use crate::widgets::theme::palette;

/// Draws the strip, if layers are looked at.
pub fn show(ui: &mut Ui, rect: Rect, desk: &mut MoldDesk) {
    let Some(found) = desk.found().cloned() else { return };
    let (layers, Some(number)) = (&found.uncut.layers, desk.layer) else { return };
    let Some(layer) = layers.get(number) else { return };
    row(ui, rect, (0, 620.0), |ui| {
        ui.spacing_mut().slider_width = (ui.available_width() - 374.0).clamp(60.0, 260.0);
        let label = ui.label(RichText::new("Layer").color(palette(ui).faint));
        let mut at = number;
        let last = layers.len() - 1;
        if ui.add_enabled(at > 0, egui::Button::new("\u{23f4}")).on_hover_text("The next one below").clicked() {
            at -= 1;
        }
        ui.add(Slider::new(&mut at, 0..=last).show_value(false)).labelled_by(label.id);
        if ui.add_enabled(at < last, egui::Button::new("\u{23f5}")).on_hover_text("The next one above").clicked() {
            at += 1;
        }
        desk.layer = Some(at);
        stale(ui, desk);
        dim(ui, desk);
        ui.label(RichText::new(format!("z {:.3} mm", layer.z)).monospace());
        if ui.available_width() > 150.0 {
            let text = format!("{:.2} mm, {:.3} mm² uncut", layer.segment_length, layer.area);
            let said = ui.label(RichText::new(text).small().color(palette(ui).faint));
            said.on_hover_text("Length of the outline that no cutter touches in this layer, and the uncut area");
        }
    });
}

/// What is to be clicked on for the work datum.
pub fn picking(ui: &mut Ui, rect: Rect, desk: &mut MoldDesk) {
    let Some(pick) = desk.pick else { return };
    row(ui, rect, (0, 560.0), |ui| {
        ui.label(format!("Work datum: {}", pick.instruction()));
        if ui.button("Cancel picking").on_hover_text(FrameCommand::Cancel.hint(ui.ctx())).clicked() {
            desk.pick = None;
        }
    });
}
