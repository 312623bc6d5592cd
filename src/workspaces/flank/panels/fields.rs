//! Rows of the form: a name, a number with its unit, and what is said when something else is typed.

use std::cell::RefCell;
use std::ops::RangeInclusive;

use egui::{ComboBox, DragValue, Response, RichText, Slider, SliderClamping, TextEdit, Ui, vec2};
use glam::DVec3;

use crate::widgets::panel_parts::named;
use crate::widgets::theme::palette;
use crate::workspaces::blisk::panels::forms::{parsed_or, short};

/// Height of a row, and width of a number (points).
const HEIGHT: f32 = 22.0;
const WIDTH: f32 = 70.0;
/// Width of a number of which three are in a row, and of a text.
const NARROW: f32 = 54.0;
const TEXT: f32 = 176.0;
/// Width of a slider; there is none in a form that is narrower than the second figure.
const SLIDER: f32 = 84.0;
const ROOM_FOR_SLIDERS: f32 = 270.0;

/// What a number is.
#[derive(Clone, Copy)]
pub struct Number<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its unit; may be empty.
    pub unit: &'a str,
    /// What it means.
    pub hint: &'a str,
    /// How much it changes when it is dragged by a point.
    pub speed: f64,
    /// The most decimals that it is shown with.
    pub decimals: usize,
}

impl<'a> Number<'a> {
    /// A length in mm.
    pub fn mm(name: &'a str, hint: &'a str) -> Self {
        Self { name, unit: "mm", hint, speed: 0.02, decimals: 4 }
    }

    /// A count.
    pub fn count(name: &'a str, hint: &'a str) -> Self {
        Self { name, unit: "", hint, speed: 0.2, decimals: 0 }
    }
}

/// A row with a number; `wrong` gets a sentence if what was typed is none.
pub fn number(ui: &mut Ui, value: &mut f64, what: Number, wrong: &mut Option<String>) -> Response {
    named(ui, what.name, |ui, label| {
        let response = field(ui, value, what, wrong).labelled_by(label);
        unit(ui, what.unit);
        response
    })
}

/// The same with a slider before it, where there is room for one.
pub fn slider(ui: &mut Ui, value: &mut f64, range: RangeInclusive<f64>, what: Number, wrong: &mut Option<String>) {
    named(ui, what.name, |ui, label| {
        if ui.available_width() + 84.0 > ROOM_FOR_SLIDERS {
            ui.spacing_mut().slider_width = SLIDER;
            let slider = Slider::new(value, range).clamping(SliderClamping::Never).show_value(false);
            let slider = slider.step_by(10f64.powi(-(what.decimals.min(2) as i32)));
            let response = ui.add(slider).on_hover_text(what.hint);
            ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(what.name));
        }
        field(ui, value, what, wrong).labelled_by(label);
        unit(ui, what.unit);
    });
}

/// A whole number in a row of its own.
pub fn count(ui: &mut Ui, value: &mut usize, what: Number, wrong: &mut Option<String>) {
    let mut number_of = *value as f64;
    number(ui, &mut number_of, what, wrong);
    *value = whole(number_of);
}

/// The most letters of a text.
const LETTERS: usize = 60;

/// A row with a text, which is taken once the hands leave it: what is half typed changes nothing.
pub fn text(ui: &mut Ui, value: &mut String, name: &str, hint: &str) {
    named(ui, name, |ui, label| {
        let id = ui.make_persistent_id(name);
        let mut typed = ui.data_mut(|d| d.get_temp::<String>(id)).unwrap_or_else(|| value.clone());
        let edit = TextEdit::singleline(&mut typed).id(id.with("text")).char_limit(LETTERS).hint_text("none");
        let response = ui.add_sized(vec2(TEXT.min(ui.available_width()), HEIGHT), edit).on_hover_text(hint);
        let response = response.labelled_by(label);
        if response.has_focus() {
            ui.data_mut(|d| d.insert_temp(id, typed));
            return;
        }
        ui.data_mut(|d| d.remove::<String>(id));
        if response.lost_focus() {
            *value = typed.trim().to_owned();
        }
    });
}

/// Directions along an axis, and their names.
const AXES: [(DVec3, &str); 6] = [
    (DVec3::Z, "+Z"),
    (DVec3::NEG_Z, "\u{2212}Z"),
    (DVec3::X, "+X"),
    (DVec3::NEG_X, "\u{2212}X"),
    (DVec3::Y, "+Y"),
    (DVec3::NEG_Y, "\u{2212}Y"),
];

/// The name of a direction: an axis, or its three parts.
pub fn direction_words(direction: DVec3) -> String {
    let unit = direction.normalize_or_zero();
    let found = AXES.iter().find(|(axis, _)| axis.distance(unit) < 1e-6);
    // No zero with a sign.
    let [x, y, z] = unit.to_array().map(|part| if part.abs() < 5e-4 { 0.0 } else { part });
    found.map_or_else(|| format!("{x:.3}, {y:.3}, {z:.3}"), |(_, name)| (*name).to_owned())
}

/// A row with a direction: one along an axis, or any other by its three parts, which appear where it is none of these.
pub fn direction(ui: &mut Ui, value: &mut DVec3, name: &str, hint: &str, wrong: &mut Option<String>) {
    let id = ui.make_persistent_id(name).with("other");
    let is_axis = |v: DVec3| AXES.iter().any(|(axis, _)| axis.distance(v.normalize_or_zero()) < 1e-6);
    let mut is_other = !is_axis(*value) || ui.data_mut(|d| d.get_temp(id)).unwrap_or(false);
    named(ui, name, |ui, label| {
        let text = if is_other { "other".to_owned() } else { direction_words(*value) };
        let combo = ComboBox::from_id_salt(name).selected_text(text).width(110.0);
        let shown = combo.show_ui(ui, |ui| {
            for (axis, name) in AXES {
                let is_this = !is_other && axis.distance(value.normalize_or_zero()) < 1e-6;
                if ui.selectable_label(is_this, name).clicked() {
                    (*value, is_other) = (axis, false);
                }
            }
            if ui.selectable_label(is_other, "other").clicked() {
                is_other = true;
            }
        });
        shown.response.on_hover_text(hint).labelled_by(label);
    });
    ui.data_mut(|d| d.insert_temp(id, is_other));
    if is_other {
        let part = Number { unit: "", speed: 0.01, decimals: 4, ..Number::mm(name, hint) };
        point(ui, value, "", part, wrong);
    }
}

/// A row with the three parts of a point or a direction, each called by its letter after `what`'s name.
pub fn point(ui: &mut Ui, value: &mut DVec3, name: &str, what: Number, wrong: &mut Option<String>) {
    named(ui, name, |ui, _| {
        for (i, letter) in ["X", "Y", "Z"].into_iter().enumerate() {
            let name = format!("{} {letter}", what.name);
            let response = narrow(ui, &mut value[i], Number { name: &name, ..what }, wrong);
            ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(name));
        }
        unit(ui, what.unit);
    });
}

/// A number as a count.
pub fn whole(number: f64) -> usize {
    // What is too large for any grid is answered by the parameters themselves.
    number.round().clamp(0.0, 1e12) as usize
}

/// A number that is dragged or typed, as wide as all others.
pub fn field(ui: &mut Ui, value: &mut f64, what: Number, wrong: &mut Option<String>) -> Response {
    sized(ui, value, what, WIDTH, wrong)
}

/// The same, so narrow that three are beside each other.
fn narrow(ui: &mut Ui, value: &mut f64, what: Number, wrong: &mut Option<String>) -> Response {
    sized(ui, value, what, NARROW, wrong)
}

fn sized(ui: &mut Ui, value: &mut f64, what: Number, width: f32, wrong: &mut Option<String>) -> Response {
    let typed = RefCell::default();
    let before = *value;
    let drag = DragValue::new(value)
        .speed(what.speed)
        .max_decimals(what.decimals)
        .custom_formatter(short)
        .custom_parser(|text| parsed_or(text, &typed))
        .update_while_editing(false);
    let response = ui.add_sized(vec2(width, HEIGHT), drag).on_hover_text(what.hint);
    if let Some(text) = typed.into_inner() {
        let text: String = text.trim().chars().take(24).collect();
        let unit = if what.unit.is_empty() { String::new() } else { format!(" {}", what.unit) };
        *wrong = Some(format!("{}: \"{text}\" is not a number; it stays {before}{unit}", what.name));
    }
    response
}

/// A unit behind its number.
pub fn unit(ui: &mut Ui, unit: &str) {
    if !unit.is_empty() {
        ui.label(RichText::new(unit).color(palette(ui).faint));
    }
}
