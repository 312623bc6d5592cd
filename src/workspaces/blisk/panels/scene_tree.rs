//! What is in the scene: an eye, a colour, an opacity and "only this" for every body.

use egui::{Color32, RichText, Role, Sense, Ui, WidgetInfo, vec2};

use crate::shell::core::Core;
use crate::widgets::theme::palette;
use crate::workspaces::blisk::document::stage::Stage;
use crate::workspaces::blisk::scene::Layer;
use render::colour::Colour;

/// Draws it.
pub fn show(ui: &mut Ui, core: &mut Core) {
    ui.horizontal(|ui| {
        ui.label(RichText::new("Scene").small().color(palette(ui).faint));
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if ui.small_button("Reset").on_hover_text("Reset colour and opacity of every layer").clicked() {
                core.layers = Default::default();
            }
        });
    });
    for layer in Layer::ALL {
        if exists(core, layer) {
            row(ui, core, layer);
        }
    }
}

/// Whether there is anything in the layer yet.
fn exists(core: &Core, layer: Layer) -> bool {
    match layer {
        Layer::Blisk | Layer::Grid => core.pipeline.part().is_some(),
        Layer::Unshrouded | Layer::LowWall | Layer::HighWall => core.pipeline.channel().is_some(),
        Layer::Centreline => core.pipeline.channel().is_some_and(|found| found.centreline.is_some()),
        Layer::Machine => !core.machine_bodies().is_empty(),
        Layer::Electrode => core.pipeline.electrodes().is_some(),
        Layer::Ghosts | Layer::Sweep | Layer::Paths => !core.track().is_empty(),
        Layer::Contact => {
            (core.contact().is_some() || core.trouble().is_some())
                && core.pipeline.state(Stage::Plan) != crate::workspaces::blisk::pipeline::StageState::Missing
        }
    }
}

fn row(ui: &mut Ui, core: &mut Core, layer: Layer) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        let look = core.layers.get_mut(layer);
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
        let selected = core.selected == Some(layer);
        let mut text = RichText::new(layer.name());
        if !visible {
            text = text.color(palette(ui).faint);
        }
        let name = ui.selectable_label(selected, text);
        if name.clicked() {
            core.selected = (!selected).then_some(layer);
        }
        name.context_menu(|ui| menu(ui, core, layer));
        if layer.is_body() {
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                let look = core.layers.get_mut(layer);
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

fn menu(ui: &mut Ui, core: &mut Core, layer: Layer) {
    if layer.is_body() && ui.button("Show only this").clicked() {
        core.layers.isolate(layer);
    }
    if ui.button("Reset colour and opacity").clicked() {
        *core.layers.get_mut(layer) = *crate::workspaces::blisk::scene::Layers::default().get(layer);
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
