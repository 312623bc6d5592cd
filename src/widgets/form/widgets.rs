//! The widgets of forms: one for each kind of parameter.

use std::cell::{Cell, RefCell};
use std::ops::RangeInclusive;

use egui::{DragValue, Response, RichText, Slider, SliderClamping, TextEdit, Ui, vec2};
use serde_json::Value;

use super::{Change, GAP, HEIGHT, VALUE, Widths, cell, mark};
use crate::widgets::panel_parts::{file_name, parsed_or, short};
use crate::widgets::theme::{palette, tick};
use files::{AXIS_NAMES, Instead, Kind, Place, Range, Word, direction_words, get, inline_toml};

/// Greatest length of labels that are shown side by side.
const SHORT: usize = 4;
/// What stands for an empty text.
pub(super) const NOTHING: &str = "\u{2013}";
/// Width of a unit after numbers (points).
const UNIT: f32 = 32.0;
/// Widths of a digit, and of the edges about a number (points).
const DIGIT: f32 = 7.8;
const EDGES: f32 = 12.0;
/// Greatest length of a text.
const LETTERS: usize = 4000;

/// Draws the widgets of a row.
pub(super) fn widget(
    ui: &mut Ui,
    place: &Place,
    value: &Value,
    widths: Widths,
    also: &[[String; 2]],
) -> Option<Change> {
    match place.field.kind {
        Kind::Number { slider, instead, .. } => number_row(ui, place, value, widths, (slider, instead)),
        Kind::Flag => {
            let mut on = value.as_bool().unwrap_or_default();
            let ticked = named(ui, place, |ui| tick(ui, &mut on, ()));
            ticked.changed().then(|| Change::To(on.into()))
        }
        Kind::Choice(words) if is_short(words) => chips(ui, words, value),
        Kind::Choice(words) | Kind::ChoiceOrFile(words) | Kind::ChoiceOr(words, _) => {
            choice(ui, place, words, also, value, widths.wide)
        }
        Kind::Variant { .. } => variant(ui, place, value, widths.wide),
        Kind::File => file(ui, place, value, widths.wide),
        Kind::Numbers { count: Some(_), is_optional: false, .. } => numbers(ui, place, value, widths.wide),
        Kind::Direction => direction(ui, place, value, widths.wide),
        Kind::Numbers { .. } | Kind::Points { .. } | Kind::Text => text(ui, place, value, widths.wide, NOTHING),
        Kind::Rows { .. } => None,
    }
}

/// Whether the numbers of a value stand on a line of their own, as they would not fit beside their label: the components
/// of a point, and of a direction that is along no axis.
pub(super) fn is_long(ui: &Ui, place: &Place, value: &Value) -> bool {
    match place.field.kind {
        Kind::Numbers { count: Some(count), is_optional: false, .. } => count > 2,
        Kind::Direction => is_other_direction(ui, place, value),
        _ => false,
    }
}

/// Draws what stands beside the label where the numbers are on the line below.
pub(super) fn head(ui: &mut Ui, place: &Place, value: &Value, widths: Widths) -> Option<Change> {
    if place.field.kind == Kind::Direction { axes(ui, place, value, widths.wide) } else { None }
}

/// Draws the numbers that have a line of their own, over the width of the form, with their unit.
pub(super) fn components(ui: &mut Ui, place: &Place, value: &Value) -> Option<Change> {
    let unit = place.field.unit;
    let change = numbers(ui, place, value, ui.available_width() - if unit.is_empty() { 0.0 } else { UNIT });
    if !unit.is_empty() {
        ui.label(RichText::new(unit).color(palette(ui).faint));
    }
    change
}

/// Draws the widget of a cell of a table, an empty text with this `hint`.
pub(super) fn narrow(ui: &mut Ui, place: &Place, value: &Value, width: f32, hint: &str) -> Option<Change> {
    match place.field.kind {
        Kind::Text => text(ui, place, value, width, hint),
        Kind::Number { instead: Instead::Never, decimals, .. } => {
            drag(ui, place, value.as_f64().unwrap_or_default(), width, (0, decimals))
        }
        Kind::Number { .. } => number_or_dash(ui, place, value, width),
        _ => widget(ui, place, value, Widths { label: 0.0, middle: 0.0, wide: width }, &[]),
    }
}

/// Names a widget after its parameter, and adds the help text as a tooltip.
fn named(ui: &mut Ui, place: &Place, add: impl FnOnce(&mut Ui) -> Response) -> Response {
    let response = add(ui);
    ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(place.label.clone()));
    response.on_hover_text(place.field.help)
}

fn number_row(
    ui: &mut Ui,
    place: &Place,
    value: &Value,
    widths: Widths,
    (slider, instead): (Option<Range>, Instead),
) -> Option<Change> {
    let start = |start: f64| if place.field.is_whole() { Value::from(start as i64) } else { start.into() };
    let (nothing, word, start) = match instead {
        Instead::Never => (Value::Null, "", Value::Null),
        Instead::Word(word, begin) => (word.into(), word, start(begin)),
        Instead::Nothing(begin) => (Value::Null, "none", start(begin)),
    };
    if instead != Instead::Never {
        let mut is_without = !value.is_number();
        // Without a place of its own the box gives way to the number; the label's menu resets it.
        let mut toggle = |ui: &mut Ui| {
            let ticked = tick(ui, &mut is_without, word);
            let name = format!("{}: {word}", place.label);
            ui.ctx().accesskit_node_builder(ticked.id, |node| node.set_label(name));
            ticked.changed()
        };
        let toggled = match widths.middle {
            middle if middle > 0.0 => cell(ui, middle, toggle),
            _ => !value.is_number() && toggle(ui),
        };
        if toggled {
            return Some(Change::To(if is_without { nothing } else { start }));
        }
        if is_without {
            return None;
        }
    }
    let mut to = value.clone();
    let mut slid = None;
    if let Some(Range(least, greatest)) = slider.filter(|_| widths.middle > 0.0 && instead == Instead::Never) {
        let mut at = value.as_f64().unwrap_or_default();
        let Kind::Number { decimals, .. } = place.field.kind else { return None };
        let slider = Slider::new(&mut at, least..=greatest).clamping(SliderClamping::Never).show_value(false);
        ui.spacing_mut().slider_width = widths.middle;
        let response = named(ui, place, |ui| ui.add(slider.step_by(10f64.powi(-(decimals.min(3) as i32)))));
        slid = along(&response, at.into());
        to = at.into();
    }
    number(ui, place, &to, VALUE).or(slid)
}

/// A number that is dragged or typed.
fn number(ui: &mut Ui, place: &Place, value: &Value, width: f32) -> Option<Change> {
    let Kind::Number { decimals, .. } = place.field.kind else { return None };
    drag(ui, place, value.as_f64().unwrap_or_default(), width, (decimals, decimals))
}

fn drag(ui: &mut Ui, place: &Place, mut at: f64, width: f32, (least, most): (usize, usize)) -> Option<Change> {
    let is_whole = place.field.is_whole();
    let (before, shown, wrong) = (at, RefCell::default(), RefCell::default());
    let field = DragValue::new(&mut at)
        .speed(place.field.drag_step())
        .max_decimals(if is_whole { 0 } else { most.max(6) })
        .min_decimals(least.min(3))
        .custom_formatter(|number, decimals| kept(fitting(number, decimals, width), &shown))
        .custom_parser(|text| if text == *shown.borrow() { Some(before) } else { parsed_or(text, &wrong) })
        .update_while_editing(false);
    let response = named(ui, place, |ui| ui.add_sized(vec2(width, HEIGHT), field));
    let value = if is_whole { whole(at) } else { at.into() };
    wrong.into_inner().map(Change::NoNumber).or(along(&response, value))
}

/// A number with no more decimals than fit into a field of this width (points): a field that grows would widen its panel.
fn fitting(number: f64, decimals: RangeInclusive<usize>, width: f32) -> String {
    let (least, most) = (*decimals.start(), *decimals.end());
    let fits = |text: &String| DIGIT * text.chars().count() as f32 <= width - EDGES;
    let mut shown = (least..=most).rev().map(|most| short(number, least..=most));
    shown.find(fits).unwrap_or_else(|| short(number, least..=least))
}

/// Keeps the `text` that a field shows in `shown`: a field that is left unchanged keeps its number, whose decimals it may
/// not all show.
fn kept(text: String, shown: &RefCell<String>) -> String {
    shown.borrow_mut().clone_from(&text);
    text
}

fn whole(number: f64) -> Value {
    let rounded = number.round();
    if rounded < 0.0 { Value::from(rounded as i64) } else { Value::from(rounded as u64) }
}

/// An optional number; a dash if missing. Where it may not be zero, zero is missing.
fn number_or_dash(ui: &mut Ui, place: &Place, value: &Value, width: f32) -> Option<Change> {
    let mut at = value.as_f64().unwrap_or_default();
    let (before, shown, wrong) = (at, RefCell::default(), RefCell::default());
    let Range(least, _) = place.field.range().unwrap_or(Range(0.0, f64::INFINITY));
    let is_given = Cell::new(value.is_number());
    let is_there = |number: f64| if least > 0.0 { number > 0.0 } else { is_given.get() || number != 0.0 };
    let field = DragValue::new(&mut at)
        .speed(place.field.drag_step())
        .max_decimals(6)
        .custom_formatter(|number, decimals| {
            kept(if is_there(number) { fitting(number, decimals, width) } else { NOTHING.to_owned() }, &shown)
        })
        .custom_parser(|text| match text.trim() {
            "" | "-" | NOTHING => {
                is_given.set(false);
                Some(0.0)
            }
            text if text == *shown.borrow() => Some(before),
            text => {
                let number = parsed_or(text, &wrong).filter(|number| *number >= least.min(0.0));
                if number.is_none() {
                    *wrong.borrow_mut() = Some(text.to_owned());
                }
                is_given.set(is_given.get() || number.is_some());
                number
            }
        })
        .update_while_editing(false);
    let response = named(ui, place, |ui| ui.add_sized(vec2(width, HEIGHT), field));
    let new = if is_there(at) { at.max(least.min(0.0)).into() } else { Value::Null };
    // Zero and none are the same number to the widget.
    let is_other = is_given.get() != value.is_number() && new != *value;
    let typed = || is_other.then_some(Change::To(new.clone()));
    // A number that is typed and not possible is said to be so.
    let refused = |text: String| match place.field.parse(&place.key, &text) {
        Err(problem) if read_as_number(&text) => Change::Wrong(problem),
        _ => Change::NoNumber(text),
    };
    wrong.into_inner().map(refused).or_else(|| along(&response, new.clone())).or_else(typed)
}

fn read_as_number(text: &str) -> bool {
    parsed_or(text, &RefCell::default()).is_some()
}

fn along(response: &Response, value: Value) -> Option<Change> {
    let is_held = response.dragged() || response.has_focus();
    response.changed().then_some(if is_held { Change::Along(value) } else { Change::To(value) })
}

/// Numbers side by side; three are named after the axes.
fn numbers(ui: &mut Ui, place: &Place, value: &Value, width: f32) -> Option<Change> {
    let mut all = value.as_array().cloned().unwrap_or_default();
    let each = (width - GAP * all.len().saturating_sub(1) as f32) / all.len().max(1) as f32;
    let mut change = None;
    ui.spacing_mut().item_spacing.x = GAP;
    for i in 0..all.len() {
        let letter = if all.len() == 3 { ["X", "Y", "Z"][i].to_owned() } else { (i + 1).to_string() };
        let part = Place { label: format!("{} {letter}", place.label), ..place.clone() };
        let at = all[i].as_f64().unwrap_or_default();
        let mut put = |to: Value| {
            all[i] = to;
            Value::from(all.clone())
        };
        change = match drag(ui, &part, at, each, (0, 4)) {
            Some(Change::To(to)) => Some(Change::To(put(to))),
            Some(Change::Along(to)) => Some(Change::Along(put(to))),
            other => other.or(change),
        };
    }
    change
}

pub(super) fn is_short(words: &[Word]) -> bool {
    words.len() <= 6 && words.iter().all(|word| word.label.chars().count() <= SHORT)
}

/// A choice of short words, all visible.
fn chips(ui: &mut Ui, words: &[Word], value: &Value) -> Option<Change> {
    ui.spacing_mut().item_spacing.x = 2.0;
    let chosen = words.iter().filter(|word| {
        let response = ui.selectable_label(value.as_str() == Some(word.word), word.label);
        let response = if word.help.is_empty() { response } else { response.on_hover_text(word.help) };
        response.clicked() && value.as_str() != Some(word.word)
    });
    chosen.last().map(|word| Change::To(word.word.into()))
}

/// Label of a choice whose value is a table and none of its words.
const GIVEN: &str = "given";

/// A choice in a drop-down list.
fn combo(ui: &mut Ui, place: &Place, now: &str, width: f32, add: impl FnOnce(&mut Ui)) {
    named(ui, place, |ui| {
        let list = egui::ComboBox::from_id_salt(&place.key).selected_text(now).truncate().width(width);
        list.show_ui(ui, add).response
    });
}

fn choice(
    ui: &mut Ui,
    place: &Place,
    words: &[Word],
    also: &[[String; 2]],
    value: &Value,
    width: f32,
) -> Option<Change> {
    let now = value.as_str();
    let own = words.iter().map(|word| [word.word, word.label, word.help]);
    let all: Vec<[&str; 3]> = own.chain(also.iter().map(|[word, label]| [word.as_str(), word, label])).collect();
    let known = now.and_then(|now| all.iter().find(|[word, ..]| *word == now)).map(|[_, label, _]| file_name(label));
    let other = || if value.is_object() { GIVEN.to_owned() } else { place.field.show_label(value) };
    let shown = known.unwrap_or_else(|| now.map_or_else(other, file_name));
    let mut change = None;
    combo(ui, place, &shown, width, |ui| {
        for [word, label, help] in &all {
            let response = ui.selectable_label(Some(*word) == now, file_name(label));
            let response = if help.is_empty() { response } else { response.on_hover_text(*help) };
            if response.clicked() && Some(*word) != now {
                change = Some(Change::To((*word).into()));
            }
        }
        let may_be_file = matches!(place.field.kind, Kind::ChoiceOrFile(_));
        if may_be_file && ui.selectable_label(false, "Own file\u{2026}").clicked() {
            change = Some(Change::Choose);
        }
        // Its parts have fields of their own.
        if let Kind::ChoiceOr(_, other) = place.field.kind
            && let table @ Value::Object(_) = inline_toml(other)
            && ui.selectable_label(value.is_object(), GIVEN).clicked()
            && !value.is_object()
        {
            change = Some(Change::To(table));
        }
    });
    change
}

/// A choice of tables. A new table keeps the values that both have.
fn variant(ui: &mut Ui, place: &Place, value: &Value, width: f32) -> Option<Change> {
    let Kind::Variant { tag, variants } = place.field.kind else { return None };
    let now = get(value, tag).as_str();
    let mut change = None;
    combo(ui, place, &place.field.show_label(value), width, |ui| {
        for variant in variants {
            let response = ui.selectable_label(Some(variant.word.word) == now, variant.word.label);
            let help = variant.word.help;
            let response = if help.is_empty() { response } else { response.on_hover_text(help) };
            if response.clicked() && Some(variant.word.word) != now {
                let mut table = inline_toml(variant.new);
                for (key, kept) in table.as_object_mut().into_iter().flatten().filter(|(key, _)| *key != tag) {
                    *kept = value.get(key).unwrap_or(kept).clone();
                }
                change = Some(Change::To(table));
            }
        }
    });
    change
}

fn file(ui: &mut Ui, place: &Place, value: &Value, width: f32) -> Option<Change> {
    let path = value.as_str().filter(|path| !path.is_empty());
    let name = path.map(file_name);
    // There must be room for a button that takes it away.
    let button = egui::Button::new(name.as_deref().unwrap_or("Choose\u{2026}")).truncate();
    let chosen = cell(ui, (width - 50.0).max(VALUE), |ui| ui.add(button));
    chosen.on_hover_text(path.unwrap_or(place.field.help)).clicked().then_some(Change::Choose)
}

/// A direction: along an axis, or three components.
fn direction(ui: &mut Ui, place: &Place, value: &Value, width: f32) -> Option<Change> {
    let others = 3.0 * 40.0;
    let is_other = is_other_direction(ui, place, value);
    let change = axes(ui, place, value, if is_other { (width - others).max(56.0) } else { width });
    if is_other { numbers(ui, place, value, others).or(change) } else { change }
}

/// Name under which the window remembers that components are asked for of a direction along an axis.
fn other_id(place: &Place) -> egui::Id {
    egui::Id::unique((&place.key, "other direction"))
}

/// Whether a direction is along no axis, or its components are asked for.
fn is_other_direction(ui: &Ui, place: &Place, value: &Value) -> bool {
    let is_asked_for = || ui.data_mut(|d| d.get_temp(other_id(place))).unwrap_or(false);
    !AXIS_NAMES.contains(&&*direction_words(value)) || is_asked_for()
}

/// The axes to choose from, and "other".
fn axes(ui: &mut Ui, place: &Place, value: &Value, width: f32) -> Option<Change> {
    let (words, id) = (direction_words(value), other_id(place));
    let mut is_other = is_other_direction(ui, place, value);
    let mut change = None;
    combo(ui, place, if is_other { "other" } else { &words }, width, |ui| {
        for axis in AXIS_NAMES {
            if ui.selectable_label(!is_other && words == axis, axis).clicked() {
                is_other = false;
                change = place.field.parse(&place.key, axis).ok().map(Change::To);
            }
        }
        is_other |= ui.selectable_label(is_other, "other").clicked();
    });
    ui.data_mut(|d| d.insert_temp(id, is_other));
    change
}

/// A text, or numbers as text, taken when the field is left: a half-typed text changes nothing.
fn text(ui: &mut Ui, place: &Place, value: &Value, width: f32, hint: &str) -> Option<Change> {
    let id = ui.make_persistent_id((&place.key, "typed"));
    let shown = place.field.show(value);
    let typed = ui.data_mut(|d| d.get_temp::<(String, String)>(id)).filter(|(of, _)| *of == shown);
    let mut text = typed.map_or_else(|| shown.clone(), |(_, text)| text);
    let read = |text: &str| place.field.parse(&place.key, text);
    if read(&text).is_err() {
        mark(ui);
    }
    let edit = TextEdit::singleline(&mut text).id(id.with("text")).char_limit(LETTERS).hint_text(hint);
    let response = named(ui, place, |ui| ui.add_sized(vec2(width, HEIGHT), edit.clip_text(true)));
    match read(&text) {
        Ok(new) if !response.has_focus() => {
            ui.data_mut(|d| d.remove::<(String, String)>(id));
            let is_other = new != *value && !(value.is_null() && new == "");
            (is_other && response.lost_focus()).then_some(Change::To(new))
        }
        read => {
            ui.data_mut(|d| d.insert_temp(id, (shown, text)));
            read.err().filter(|_| response.lost_focus()).map(Change::Wrong)
        }
    }
}
