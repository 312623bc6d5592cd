//! The table of cutters. Its lengths are parameters; the kind is what diameter and corner make together.

use egui::Ui;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::widgets::form::{ExtraColumn, Form};
use files::Validate;
use mold::cutter::{Cutter, CutterKind};

/// Width of the kinds (points).
const KIND: f32 = 54.0;
const KINDS: [(CutterKind, &str); 3] =
    [(CutterKind::Flat, "flat"), (CutterKind::Ball, "ball"), (CutterKind::BullNose, "bull")];

/// Draws the cutters under `key` of a form.
pub fn table<P>(ui: &mut Ui, form: &mut Form<P>, key: &str)
where
    P: Clone + PartialEq + Serialize + DeserializeOwned + Validate,
{
    let before = form.value(key).clone();
    form.rows(ui, key, Some(ExtraColumn { head: "kind", after: 1, width: KIND, draw: &mut kind, called: label }));
    let rows = |value: &Value| value.as_array().cloned().unwrap_or_default();
    let (before, now) = (rows(&before), rows(form.value(key)));
    for (i, (before, now)) in before.iter().zip(&now).enumerate().filter(|_| before.len() == now.len()) {
        if let Some(corner) = same_kind(before, now) {
            form.put(&format!("{key}[{i}].corner_mm"), corner.into());
        }
    }
}

/// The corner with which a cutter of another diameter stays a ball, or a bull-nose (mm).
fn same_kind(before: &Value, now: &Value) -> Option<f64> {
    let (before, now) = (Cutter::deserialize(before).ok()?, Cutter::deserialize(now).ok()?);
    if before.diameter_mm == now.diameter_mm || before.corner_mm != now.corner_mm {
        return None;
    }
    match before.kind() {
        CutterKind::Flat => None,
        CutterKind::Ball => Some(now.radius()),
        CutterKind::BullNose => Some(now.corner_mm.min(0.9 * now.radius())),
    }
}

/// What the cutter in `row` is called, as far as there is room: its other lengths stand beside it.
fn label(row: &Value) -> Option<String> {
    let label = Cutter::deserialize(row).ok()?.label();
    label.split(" (").next().map(str::to_owned)
}

/// The kind of the cutter in `row`, which is called `name`. Returns the row with another one.
fn kind(ui: &mut Ui, name: &str, row: &Value) -> Option<Value> {
    let cutter = Cutter::deserialize(row).ok()?;
    let now = cutter.kind();
    let text = KINDS.iter().find(|(kind, _)| *kind == now).map_or("", |(_, text)| text);
    let mut corner = None;
    let combo = egui::ComboBox::from_id_salt((name, "kind")).selected_text(text).width(KIND);
    let shown = combo.show_ui(ui, |ui| {
        for (kind, text) in KINDS {
            if ui.selectable_label(kind == now, text).clicked() && kind != now {
                corner = Some(match kind {
                    CutterKind::Flat => 0.0,
                    CutterKind::Ball => cutter.radius(),
                    CutterKind::BullNose => 0.25 * cutter.radius(),
                });
            }
        }
    });
    ui.ctx().accesskit_node_builder(shown.response.id, |node| node.set_label(format!("{name}, Kind")));
    shown.response.on_hover_text(cutter.label());
    let corner_mm = corner?;
    serde_json::to_value(Cutter { corner_mm, ..cutter }).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::widgets::theme::palette;
    use crate::workspaces::mold::document::MoldParams;
    use crate::workspaces::mold::document::fields::FIELDS;
    use egui_kittest::Harness;
    use egui_kittest::kittest::Queryable as _;

    #[test]
    fn a_corner_greater_than_the_radius_is_marked_in_its_cell() {
        let mut params = MoldParams::default();
        params.library.cutter = vec![Cutter::flat(3.0), Cutter::bull_nose(2.0, 2.5)];
        let problem = params.validate().unwrap_err();
        let bad = std::cell::Cell::default();
        let window = Harness::new_ui(|ui| {
            bad.set(palette(ui).bad);
            let mut form = Form::new(&FIELDS, &params, Some(&problem));
            table(ui, &mut form, "library.cutter");
        });
        let marked: Vec<egui::Rect> = window
            .output()
            .shapes
            .iter()
            .filter_map(|shape| match &shape.shape {
                egui::Shape::Rect(rect) if rect.stroke.color == bad.get() => Some(rect.rect),
                _ => None,
            })
            .collect();
        let corner = window.get_by_label("Cutters 2, Corner").rect();
        assert!(marked.len() == 1 && corner.expand(2.0).contains_rect(marked[0]), "{marked:?} {corner:?}");
    }

    #[test]
    fn a_cutter_of_another_diameter_is_of_the_same_kind() {
        let value = |cutter: &Cutter| serde_json::to_value(cutter).unwrap();
        let corner = |before: Cutter, diameter_mm: f64| {
            same_kind(&value(&before), &value(&Cutter { diameter_mm, ..before.clone() }))
        };
        assert_eq!(corner(Cutter::ball(2.0), 6.0), Some(3.0));
        assert_eq!(corner(Cutter::bull_nose(2.0, 0.5), 6.0), Some(0.5));
        assert_eq!(corner(Cutter::bull_nose(2.0, 1.5), 2.0), Some(0.9));
        assert_eq!(corner(Cutter::flat(2.0), 6.0), None);
        assert_eq!(corner(Cutter::ball(2.0), 4.0), None);
    }
}
