//! The tree of the scene: for every body visibility, colour, opacity and "only this".

use crate::workspaces::blisk::desk::BliskDesk;
use egui::{Color32, RichText, Role, Sense, Ui, WidgetInfo, vec2};

use crate::widgets::theme::palette;
use crate::workspaces::blisk::document::stage::Stage;
use crate::workspaces::blisk::scene::Layer;
use render::colour::Colour;

/// Draws the tree.
pub fn show(ui: &mut Ui, desk: &mut BliskDesk) {
    ui.horizontal(|ui| {
        ui.label(RichText::new("Scene").small().color(palette(ui).faint));
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if ui.small_button("Reset").on_hover_text("Reset colour and opacity of every layer").clicked() {
                desk.layers = Default::default();
            }
        });
    });
    for layer in Layer::ALL {
        if exists(desk, layer) {
            row(ui, desk, layer);
        }
    }
    super::channel_kinds::show(ui, desk);
}

/// Whether there is anything in the layer yet.
fn exists(desk: &BliskDesk, layer: Layer) -> bool {
    match layer {
        Layer::Blisk | Layer::Grid => desk.work.part().is_some(),
        Layer::Unshrouded | Layer::LowWall | Layer::HighWall => desk.work.channel().is_some(),
        Layer::Centreline => desk.work.channel().is_some_and(|found| found.centreline.is_some()),
        Layer::Passage => desk.step == Stage::Channel && desk.work.channel().is_some(),
        Layer::Machine => !desk.machine_bodies().is_empty(),
        Layer::Electrode => desk.work.electrodes().is_some(),
        Layer::Ghosts | Layer::Sweep | Layer::Paths => !desk.track().is_empty(),
        Layer::Contact => {
            (desk.contact().is_some() || desk.trouble().is_some())
                && desk.work.state(Stage::Plan) != task::State::Missing
        }
    }
}

fn row(ui: &mut Ui, desk: &mut BliskDesk, layer: Layer) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        let look = desk.layers.get_mut(layer);
        if eye(ui, look.visible, layer.name()).clicked() {
            look.visible = !look.visible;
        }
        if layer.is_body() {
            let mut rgb = [look.colour.r, look.colour.g, look.colour.b];
            let swatch = ui.color_edit_button_srgb(&mut rgb).on_hover_text("Colour");
            swatch.widget_info(|| WidgetInfo::labeled(Role::ColorWell, true, format!("Colour of {}", layer.name())));
            look.colour = Colour::rgb(rgb[0], rgb[1], rgb[2]);
        }
        let visible = look.visible;
        let selected = desk.selected == Some(layer);
        let mut text = RichText::new(layer.name());
        if !visible {
            text = text.color(palette(ui).faint);
        }
        let name = ui.selectable_label(selected, text);
        if name.clicked() {
            desk.selected = (!selected).then_some(layer);
        }
        name.context_menu(|ui| menu(ui, desk, layer));
        if layer.is_body() {
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                let look = desk.layers.get_mut(layer);
                let opacity = egui::DragValue::from_get_set(|v| {
                    if let Some(v) = v {
                        look.opacity = (v / 100.0).clamp(0.02, 1.0) as f32;
                    }
                    f64::from(look.opacity * 100.0)
                });
                let response = ui.add(opacity.range(2.0..=100.0).speed(1.0).max_decimals(0).suffix(" %"));
                response.on_hover_text(format!("Opacity of {}", layer.name()));
            });
        }
    });
}

fn menu(ui: &mut Ui, desk: &mut BliskDesk, layer: Layer) {
    if layer.is_body() && ui.button("Show only this").clicked() {
        desk.layers.isolate(layer);
    }
    if ui.button("Reset colour and opacity").clicked() {
        *desk.layers.get_mut(layer) = *crate::workspaces::blisk::scene::Layers::default().get(layer);
    }
}

/// An eye, crossed out where the layer is hidden.
fn eye(ui: &mut Ui, open: bool, name: &str) -> egui::Response {
    let (rect, response) = ui.allocate_exact_size(vec2(20.0, 18.0), Sense::click());
    response.widget_info(|| WidgetInfo::selected(Role::CheckBox, true, open, format!("Show {name}")));
    let colour = if open { ui.visuals().text_color() } else { palette(ui).faint.gamma_multiply(0.6) };
    let stroke = egui::Stroke::new(1.3, colour);
    let c = rect.center();
    let lid = |up: f32| -> Vec<egui::Pos2> {
        (0..=8)
            .map(|i| {
                let t = i as f32 / 4.0 - 1.0;
                c + vec2(7.0 * t, -up * 4.5 * (1.0 - t * t))
            })
            .collect()
    };
    ui.painter().line(lid(1.0), stroke);
    ui.painter().line(lid(-1.0), stroke);
    if open {
        ui.painter().circle_filled(c, 2.2, colour);
    } else {
        ui.painter().line_segment([c + vec2(-6.0, 5.0), c + vec2(6.0, -5.0)], stroke);
    }
    if response.hovered() {
        ui.painter().rect_stroke(
            rect,
            3.0,
            egui::Stroke::new(1.0, Color32::from_gray(128).gamma_multiply(0.4)),
            egui::StrokeKind::Inside,
        );
    }
    response.on_hover_text(if open { "Hide" } else { "Show" })
}
