//! Rows of the form: a name, a number with its unit, and what is said when something else is typed.

use std::cell::RefCell;
use std::ops::RangeInclusive;

use egui::{DragValue, Response, RichText, Slider, SliderClamping, Ui, vec2};

use super::super::forms::{parsed_or, short};
use super::super::panel_parts::named;
use super::super::theme::palette;

/// Height of a row, and width of a number (points).
const HEIGHT: f32 = 22.0;
const WIDTH: f32 = 70.0;
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

/// A number as a count.
pub fn whole(number: f64) -> usize {
    // What is too large for any grid is answered by the parameters themselves.
    number.round().clamp(0.0, 1e12) as usize
}

/// A number that is dragged or typed, as wide as all others.
pub fn field(ui: &mut Ui, value: &mut f64, what: Number, wrong: &mut Option<String>) -> Response {
    let typed = RefCell::default();
    let before = *value;
    let drag = DragValue::new(value)
        .speed(what.speed)
        .max_decimals(what.decimals)
        .custom_formatter(short)
        .custom_parser(|text| parsed_or(text, &typed))
        .update_while_editing(false);
    let response = ui.add_sized(vec2(WIDTH, HEIGHT), drag).on_hover_text(what.hint);
    if let Some(text) = typed.into_inner() {
        let text: String = text.trim().chars().take(24).collect();
        let unit = if what.unit.is_empty() { String::new() } else { format!(" {}", what.unit) };
        *wrong = Some(format!("{}: \"{text}\" is no number; it stays {before}{unit}", what.name));
    }
    response
}

/// A unit behind its number.
pub fn unit(ui: &mut Ui, unit: &str) {
    if !unit.is_empty() {
        ui.label(RichText::new(unit).color(palette(ui).faint));
    }
}
