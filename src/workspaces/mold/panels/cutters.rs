//! The table of cutters.

use egui::{ComboBox, DragValue, Response, RichText, TextEdit, Ui, vec2};
use files::Validate;

use crate::widgets::theme::palette;
use mold::cutter::{Cutter, CutterKind, CutterLibrary};

/// Height of a row (points).
const HEIGHT: f32 = 22.0;
/// Widths of kind, diameter, corner, reach and holder (points), the name has what is left; and where room is scarce.
const WIDTHS: [f32; 5] = [58.0, 50.0, 46.0, 50.0, 50.0];
const NARROW: [f32; 5] = [54.0, 42.0, 36.0, 36.0, 42.0];
/// Least width of a name, and of the number before it.
const NAME: f32 = 36.0;
const NUMBER: f32 = 22.0;

/// Draws `library`, whose row `selected` is marked, as a table to be edited. `of` is what its cutters are called in the
/// names of the fields.
pub fn table(ui: &mut Ui, library: &mut CutterLibrary, selected: &mut usize, of: &str) {
    let gaps = 6.0 * 4.0;
    let left_by = |widths: [f32; 5]| ui.available_width() - widths.iter().sum::<f32>() - NUMBER - gaps - 8.0;
    let widths = if left_by(WIDTHS) < NAME + 32.0 { NARROW } else { WIDTHS };
    let name_width = left_by(widths).max(NAME);
    ui.scope(|ui| {
        ui.spacing_mut().item_spacing = vec2(4.0, 2.0);
        let faint = palette(ui).faint;
        egui::Grid::new(of).num_columns(7).min_col_width(0.0).show(ui, |ui| {
            let holder = if widths == NARROW { "holder" } else { "Ø holder" };
            for head in ["", "name", "kind", "Ø mm", "corner", "reach", holder] {
                ui.label(RichText::new(head).small().color(faint));
            }
            ui.end_row();
            for (i, cutter) in library.cutter.iter_mut().enumerate() {
                if row(ui, cutter, [of, &(i + 1).to_string()], (*selected == i, name_width, widths)) {
                    *selected = i;
                }
                ui.end_row();
            }
        });
    });
    if let Err(problem) = library.validate() {
        let text = crate::widgets::panel_parts::sentence(&problem.to_string());
        ui.add(egui::Label::new(RichText::new(text).small().color(palette(ui).bad)).wrap());
    }
}

/// A row of the table. Tells whether it was touched.
fn row(
    ui: &mut Ui,
    cutter: &mut Cutter,
    [of, number]: [&str; 2],
    (is_selected, name_width, widths): (bool, f32, [f32; 5]),
) -> bool {
    let mut touched = ui.add_sized(vec2(NUMBER, HEIGHT), egui::Button::selectable(is_selected, number)).clicked();
    let mut follow = |ui: &Ui, response: &Response, what: &str| {
        let name = format!("{what} of {of} {number}");
        ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(name));
        touched |= response.clicked() || response.has_focus() || response.dragged();
    };
    let shape = Cutter { name: String::new(), ..cutter.clone() }.label();
    let name = TextEdit::singleline(&mut cutter.name).hint_text(shape).desired_width(name_width).clip_text(true);
    let named = ui.add_sized(vec2(name_width, HEIGHT), name);
    follow(ui, &named, "Name");
    let kind = kind(ui, cutter, &format!("{of} {number}"), widths[0]);
    follow(ui, &kind, "Kind");
    let before = cutter.clone();
    let diameter = number_field(ui, &mut cutter.diameter_mm, widths[1]);
    follow(ui, &diameter, "Diameter");
    if cutter.diameter_mm != before.diameter_mm {
        // A ball stays a ball, and a bull-nose one.
        match before.kind() {
            CutterKind::Flat => {}
            CutterKind::Ball => cutter.corner_mm = cutter.radius(),
            CutterKind::BullNose => cutter.corner_mm = cutter.corner_mm.min(0.9 * cutter.radius()),
        }
    }
    let is_bull = cutter.kind() == CutterKind::BullNose;
    let corner = ui.add_enabled_ui(is_bull, |ui| number_field(ui, &mut cutter.corner_mm, widths[2])).inner;
    follow(ui, &corner, "Corner");
    let reach = optional(ui, &mut cutter.reach_mm, widths[3])
        .on_hover_text("Greatest depth below the material that the holder passes over (mm)");
    follow(ui, &reach, "Reach");
    let holder =
        ui.add_enabled_ui(cutter.reach_mm.is_some(), |ui| optional(ui, &mut cutter.holder_diameter_mm, widths[4]));
    let holder = holder.inner.on_disabled_hover_text("The holder counts only where the reach is limited");
    follow(ui, &holder, "Holder");
    touched
}

/// The name of a kind in a table.
fn short(kind: CutterKind) -> &'static str {
    match kind {
        CutterKind::Flat => "flat",
        CutterKind::Ball => "ball",
        CutterKind::BullNose => "bull",
    }
}

fn kind(ui: &mut Ui, cutter: &mut Cutter, salt: &str, width: f32) -> Response {
    let now = cutter.kind();
    let combo = ComboBox::from_id_salt(("kind", salt)).selected_text(short(now)).width(width);
    let shown = combo.show_ui(ui, |ui| {
        for kind in [CutterKind::Flat, CutterKind::Ball, CutterKind::BullNose] {
            if ui.selectable_label(kind == now, short(kind)).clicked() && kind != now {
                cutter.corner_mm = match kind {
                    CutterKind::Flat => 0.0,
                    CutterKind::Ball => cutter.radius(),
                    CutterKind::BullNose => 0.25 * cutter.radius(),
                };
            }
        }
    });
    shown.response
}

fn number_field(ui: &mut Ui, number: &mut f64, width: f32) -> Response {
    let field = DragValue::new(number).speed(0.02).range(0.0..=1e4).max_decimals(3).update_while_editing(false);
    ui.add_sized(vec2(width, HEIGHT), field)
}

/// A length that need not be there: nothing is a dash.
fn optional(ui: &mut Ui, number: &mut Option<f64>, width: f32) -> Response {
    let mut value = number.unwrap_or(0.0);
    let field = DragValue::new(&mut value)
        .speed(0.1)
        .range(0.0..=1e4)
        .max_decimals(3)
        .custom_formatter(|v, _| if v > 0.0 { format!("{}", (v * 1e3).round() / 1e3) } else { "\u{2013}".to_owned() })
        .custom_parser(|text| {
            let text = text.trim().replace(',', ".");
            if matches!(&*text, "" | "-" | "\u{2013}") { Some(0.0) } else { text.parse().ok() }
        })
        .update_while_editing(false);
    let response = ui.add_sized(vec2(width, HEIGHT), field);
    *number = (value > 0.0).then_some(value);
    response
}

/// What the buttons below a table do to `library`.
pub fn buttons(ui: &mut Ui, library: &mut CutterLibrary, selected: &mut usize) {
    let count = library.cutter.len();
    if ui.button("Add").on_hover_text("A flat-end cutter").clicked() {
        library.cutter.push(Cutter::flat(1.0));
        *selected = count;
    }
    let chosen = library.cutter.get(*selected).cloned();
    if ui.add_enabled(chosen.is_some(), egui::Button::new("Duplicate")).clicked()
        && let Some(cutter) = chosen.clone()
    {
        library.cutter.insert(*selected + 1, cutter);
        *selected += 1;
    }
    if ui.add_enabled(chosen.is_some(), egui::Button::new("Remove")).clicked() {
        library.cutter.remove(*selected);
        *selected = selected.saturating_sub(usize::from(*selected + 1 == count));
    }
}
