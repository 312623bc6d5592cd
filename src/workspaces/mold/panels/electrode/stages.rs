//! The burns that a place goes through, as a table: two lines for each, its figures and below them its orbit.

use egui::{ComboBox, RichText, TextEdit, Ui, vec2};

use super::fields::{Figure, HEIGHT, figure};
use crate::widgets::theme::palette;
use mold::electrode::params::{ElectrodeParams, Orbit, Stage};

/// Widths of gap, stock, finish, number and what removes a stage (points); the name has what is left.
const WIDTHS: [f32; 5] = [46.0, 54.0, 40.0, 38.0, 20.0];
/// Room between them, and the widths that a name may have.
const GAP: f32 = 4.0;
const NAME: std::ops::RangeInclusive<f32> = 60.0..=130.0;
/// Gap that another rough stage begins with (mm), and its finish (VDI 3400).
const ROUGH: (f64, f64) = (0.25, 32.0);
/// As many stages as a file may hold.
const MOST: usize = 16;
/// Longest length in the table (mm).
const LONGEST: f64 = 5.0;

/// Draws it.
pub fn show(ui: &mut Ui, asked: &mut ElectrodeParams) {
    let mut removed = None;
    let several = asked.stages.len() > 1;
    let taken = WIDTHS.iter().sum::<f32>() + GAP * WIDTHS.len() as f32;
    let name = (ui.available_width() - taken).clamp(*NAME.start(), *NAME.end());
    ui.scope(|ui| {
        ui.spacing_mut().item_spacing = vec2(GAP, 2.0);
        egui::Grid::new("stages").num_columns(6).min_col_width(0.0).show(ui, |ui| {
            for head in ["stage", "gap mm", "stock mm", "VDI", "pieces", ""] {
                ui.label(RichText::new(head).small().color(palette(ui).faint));
            }
            ui.end_row();
            for (i, stage) in asked.stages.iter_mut().enumerate() {
                figures(ui, stage, (i, name));
                let remove = ui.add_enabled(several, egui::Button::new("\u{00d7}").small());
                if remove.on_hover_text("Remove this stage").clicked() {
                    removed = Some(i);
                }
                ui.end_row();
                orbit(ui, &mut stage.orbit, (i, name));
                ui.end_row();
            }
        });
    });
    if let Some(i) = removed {
        asked.stages.remove(i);
    }
    let can_add = asked.stages.len() < MOST;
    let add = ui.add_enabled(can_add, egui::Button::new("Add a roughing stage"));
    if add.on_hover_text("Burned before the others").clicked() {
        let is_free = |name: &String| asked.stages.iter().all(|s| s.name != *name);
        let names = std::iter::once("rough".to_owned()).chain((2..100).map(|i| format!("rough{i}")));
        let name = names.into_iter().find(is_free).unwrap_or_default();
        asked.stages.insert(0, Stage { name, finish_vdi: ROUGH.1, ..Stage::finish(ROUGH.0) });
    }
}

/// The first line of a stage, up to what removes it.
fn figures(ui: &mut Ui, stage: &mut Stage, (i, width): (usize, f32)) {
    let of = |what: &str| format!("{what} of stage {}", i + 1);
    let field = TextEdit::singleline(&mut stage.name).desired_width(width).clip_text(true);
    let response =
        ui.add_sized(vec2(width, HEIGHT), field).on_hover_text("Letters, digits, - and _: part of file names");
    ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(of("Name")));
    let length = Figure { range: 0.0..=LONGEST, speed: 0.005, width: WIDTHS[0], suffix: "", decimals: 4, hint: "" };
    let hint = "Spark gap (mm)";
    figure(ui, &mut stage.gap_mm, &of("Gap"), &Figure { hint, ..length.clone() });
    let hint = "Stock left for the later stages, on every face (mm)";
    figure(ui, &mut stage.stock_mm, &of("Stock"), &Figure { hint, width: WIDTHS[1], ..length.clone() });
    let roughness = format!("Surface finish to be reached (VDI 3400): Ra {:.2} µm", stage.roughness_um());
    let finish = Figure { range: 0.0..=60.0, speed: 0.1, width: WIDTHS[2], suffix: "", decimals: 4, hint: &roughness };
    figure(ui, &mut stage.finish_vdi, &of("Finish"), &finish);
    let mut pieces = f64::from(stage.quantity);
    let hint = "How many of each electrode are made";
    let number = Figure { range: 1.0..=1000.0, speed: 0.05, width: WIDTHS[3], suffix: "", decimals: 0, hint };
    if figure(ui, &mut pieces, &of("Pieces"), &number).changed() {
        stage.quantity = pieces.round().max(1.0) as u32;
    }
}

/// The second one: the orbit and its radius.
fn orbit(ui: &mut Ui, orbit: &mut Orbit, (i, width): (usize, f32)) {
    let name = match orbit {
        Orbit::None => "no orbit",
        Orbit::Circular { .. } => "circle",
        Orbit::Square { .. } => "square",
    };
    let radius_mm = orbit.radius_mm().max(0.05);
    let all = [Orbit::None, Orbit::Circular { radius_mm }, Orbit::Square { radius_mm }];
    let combo = ComboBox::from_id_salt(("orbit", i)).selected_text(name).width(width);
    let shown = combo.show_ui(ui, |ui| {
        for (kind, text) in all.into_iter().zip(["no orbit", "circle", "square"]) {
            if ui.selectable_label(text == name, text).clicked() && text != name {
                *orbit = kind;
            }
        }
    });
    let response =
        shown.response.on_hover_text("Orbital motion across the burn direction; the electrode is smaller by it");
    ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(format!("Orbit of stage {}", i + 1)));
    let mut radius = orbit.radius_mm();
    let hint = "Radius of the circle, or half the side of the square (mm)";
    let length = Figure { range: 0.0..=LONGEST, speed: 0.005, width: WIDTHS[0], suffix: "", decimals: 4, hint };
    let name = format!("Radius of orbit of stage {}", i + 1);
    let field = ui.add_enabled_ui(radius > 0.0, |ui| figure(ui, &mut radius, &name, &length)).inner;
    ui.label(RichText::new("radius mm").small().color(palette(ui).faint));
    if let (true, Orbit::Circular { radius_mm } | Orbit::Square { radius_mm }) = (field.changed(), orbit) {
        *radius_mm = radius.max(0.001);
    }
}
