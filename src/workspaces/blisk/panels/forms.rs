//! The form of a step, made from the table of parameters: label, value, unit, default, and what is wrong in place.

use crate::widgets::panel_parts::{file_name, parsed_or, short};
use crate::workspaces::blisk::desk::BliskDesk;
use crate::workspaces::context::Context;
use std::cell::RefCell;

use egui::{DragValue, Response, RichText, Slider, SliderClamping, Ui, vec2};
use serde_json::Value;

use crate::widgets::theme::{palette, tick};
use crate::workspaces::blisk::document::field_table::FIELDS;
use crate::workspaces::blisk::document::stage::Stage;
use files::{Field, Group, Instead, Kind, Params as _, Range, Word, get};

/// Width of a number (points).
const VALUE_WIDTH: f32 = 74.0;
/// Width of a slider, or of what else stands before a number.
const MIDDLE_WIDTH: f32 = 90.0;
/// Least width of a form that has room for sliders.
const ROOM_FOR_SLIDERS: f32 = 300.0;
/// Height of a row.
const HEIGHT: f32 = 22.0;

/// Where the columns of a form are: names, sliders, numbers, units. Numbers stand below each other, whatever stands
/// before them.
#[derive(Clone, Copy)]
struct Columns {
    label: f32,
    /// Nothing where there is no room for sliders.
    middle: f32,
}

impl Columns {
    /// Those for `fields` in the room that `ui` has.
    fn of(ui: &Ui, stage: Stage) -> Self {
        let width = ui.available_width();
        let is_long = FIELDS.groups(stage.name()).flat_map(|group| group.fields).any(|field| field.unit.len() > 3);
        let unit = if is_long { 54.0 } else { 28.0 };
        let middle = if width < ROOM_FOR_SLIDERS { 0.0 } else { MIDDLE_WIDTH };
        let gaps = ui.spacing().item_spacing.x * if middle > 0.0 { 3.0 } else { 2.0 };
        Self { label: (width - middle - VALUE_WIDTH - unit - gaps).max(60.0), middle }
    }

    /// Width of what takes the columns of sliders and numbers together.
    fn wide(self, ui: &Ui) -> f32 {
        if self.middle > 0.0 { self.middle + ui.spacing().item_spacing.x + VALUE_WIDTH } else { VALUE_WIDTH }
    }
}

/// What a change of a field is to be.
enum Change {
    /// A value of its own.
    To(Value),
    /// One of many that come while the button is down or keys step a slider.
    Along(Value),
    /// A file is to be chosen.
    Choose,
    /// None: what was typed is no number.
    NoNumber(String),
}

/// What a form asks for that it cannot do itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Request {
    /// An electrode mesh of one's own.
    ElectrodeMesh,
    /// An NC post of one's own.
    Post,
    /// A machine file of one's own.
    Machine,
}

/// Draws the fields of `stage`. Changes go into the document at once.
pub fn show(ui: &mut Ui, desk: &mut BliskDesk, cx: &mut Context, stage: Stage) -> Option<Request> {
    let job = FIELDS.values(desk.document.params());
    let defaults = FIELDS.values(&FIELDS.defaults(desk.document.params()));
    let mut request = None;
    for group in FIELDS.groups(stage.name()) {
        let changed = |f: &Field| get(&job, f.key) != get(&defaults, f.key);
        let mut body = |ui: &mut Ui| {
            let columns = Columns::of(ui, stage);
            for field in group.fields {
                match row(ui, field, &job, &defaults, columns) {
                    Some(Change::To(value)) => change(desk, group, field, &job, value, false),
                    Some(Change::Along(value)) => change(desk, group, field, &job, value, true),
                    Some(Change::Choose) => request = Some(request_of(field)),
                    Some(Change::NoNumber(text)) => cx.say_in_passing(no_number(field, get(&job, field.key), &text)),
                    None => {}
                }
            }
        };
        if group.is_folded {
            // Only at first: a group that unfolded while one of its sliders is dragged would take it from the hand.
            let open = group.fields.iter().any(changed);
            egui::CollapsingHeader::new(group.name).id_salt((stage, group.name)).default_open(open).show(ui, body);
        } else {
            ui.add_space(4.0);
            ui.label(RichText::new(group.name).small().color(palette(ui).faint));
            body(ui);
        }
    }
    if ui.input(|i| i.pointer.any_released()) {
        desk.end_gesture();
    }
    request
}

/// Whether a field of `stage` says that its value cannot be taken.
pub fn has_problem(desk: &BliskDesk, stage: Stage) -> bool {
    let job = FIELDS.values(desk.document.params());
    let fields = FIELDS.groups(stage.name()).flat_map(|group| group.fields);
    fields.into_iter().any(|field| problem(field, get(&job, field.key)).is_some())
}

/// Why `value` cannot be taken, if it cannot.
fn problem(field: &Field, value: &Value) -> Option<String> {
    field.check(field.key, value).err().map(|problem| problem.remedy)
}

fn request_of(field: &Field) -> Request {
    match field.key {
        "machine.name" => Request::Machine,
        "export.post" => Request::Post,
        _ => Request::ElectrodeMesh,
    }
}

fn change(desk: &mut BliskDesk, group: &Group, field: &Field, job: &Value, value: Value, dragging: bool) {
    // A value that the struct itself cannot hold never leaves its field.
    let changed = FIELDS.put(job, field.key, value);
    let completed = changed.and_then(|mut job| job.complete(&|key| key == field.key).map(|()| job));
    if let Ok(job) = completed {
        desk.edit(&format!("{} {}", group.name, field.label), job, dragging);
    }
}

fn row(ui: &mut Ui, field: &Field, job: &Value, defaults: &Value, columns: Columns) -> Option<Change> {
    let value = get(job, field.key);
    let mut change = None;
    ui.horizontal(|ui| {
        let changed = value != get(defaults, field.key);
        let name = RichText::new(field.label).color(if changed {
            ui.visuals().strong_text_color()
        } else {
            ui.visuals().text_color()
        });
        let label = cell(ui, columns.label, |ui| {
            ui.add(egui::Label::new(name).truncate().selectable(false).sense(egui::Sense::click()))
        });
        let hint = |ui: &mut Ui| tooltip(ui, field, get(defaults, field.key));
        let label_id = label.id;
        label.clone().on_hover_ui(hint);
        label.context_menu(|ui| {
            if ui.button("Reset to default").clicked() {
                change = Some(Change::To(get(defaults, field.key).clone()));
            }
        });
        if let Some(wanted) = widget(ui, field, value, label_id, columns) {
            change = Some(wanted);
        }
        if !field.unit.is_empty() && shows_number(field.kind, value) {
            ui.label(RichText::new(field.unit).color(palette(ui).faint));
        }
    });
    if let Some(problem) = problem(field, value) {
        ui.with_layout(egui::Layout::top_down(egui::Align::Max), |ui| {
            let text = RichText::new(format!("{} {problem}", field.label)).small().color(palette(ui).bad);
            ui.add(egui::Label::new(text).wrap());
        });
    }
    change
}

/// Whether a number stands in the row, which is to have its unit.
fn shows_number(kind: Kind, value: &Value) -> bool {
    matches!(kind, Kind::Number { .. }) && value.is_number()
}

/// Says that `text`, which was typed into `field`, is no number, and what is asked for.
fn no_number(field: &Field, value: &Value, text: &str) -> String {
    let unit = if field.unit.is_empty() { String::new() } else { format!(" {}", field.unit) };
    let asked = match field.range() {
        Some(Range(least, greatest)) if greatest.is_finite() => format!("a number from {least} to {greatest}{unit}"),
        Some(Range(least, _)) => format!("a number of at least {least}{unit}"),
        None => "a number".to_owned(),
    };
    let stays = shown(value).map(|now| format!("; it stays {now}{unit}")).unwrap_or_default();
    let typed: String = text.trim().chars().take(24).collect();
    format!("{}: \"{typed}\" is not a number; enter {asked}{stays}", field.label)
}

/// A place of fixed width in a row.
fn cell<R>(ui: &mut Ui, width: f32, add: impl FnOnce(&mut Ui) -> R) -> R {
    let layout = egui::Layout::left_to_right(egui::Align::Center);
    let made = ui.allocate_ui_with_layout(vec2(width, HEIGHT), layout, |ui| {
        ui.set_min_width(width);
        add(ui)
    });
    made.inner
}

/// Leaves the column of sliders empty.
fn no_slider(ui: &mut Ui, columns: Columns) {
    if columns.middle > 0.0 {
        cell(ui, columns.middle, |_| ());
    }
}

fn tooltip(ui: &mut Ui, field: &Field, default: &Value) {
    ui.set_max_width(320.0);
    let symbol = if field.symbol.is_empty() { String::new() } else { format!("   {}", field.symbol) };
    ui.strong(format!("{}{symbol}", field.label));
    ui.label(field.help);
    let unit = if field.unit.is_empty() { String::new() } else { format!(" {}", field.unit) };
    if let Some(Range(least, greatest)) = field.range() {
        let upper = if greatest.is_finite() { format!(" to {greatest}") } else { " or more".to_owned() };
        ui.weak(format!("Range {least}{upper}{unit}"));
    }
    if let Some(text) = shown(default) {
        ui.weak(format!("Default {text}{unit}"));
    }
    ui.weak(field.key);
}

fn shown(value: &Value) -> Option<String> {
    match value {
        Value::Null => None,
        Value::String(text) => Some(text.clone()),
        other => Some(other.to_string()),
    }
}

fn widget(ui: &mut Ui, field: &Field, value: &Value, label: egui::Id, columns: Columns) -> Option<Change> {
    if problem(field, value).is_some() {
        let bad = palette(ui).bad;
        let widgets = &mut ui.visuals_mut().widgets;
        widgets.inactive.bg_stroke = egui::Stroke::new(1.0, bad);
        widgets.hovered.bg_stroke = egui::Stroke::new(1.0, bad);
    }
    match field.kind {
        Kind::Number { is_whole, decimals, instead: Instead::Word(_, start), .. } => {
            let start = if is_whole { Value::from(start as u64) } else { start.into() };
            auto(ui, value, start, label, columns, |ui, given| match is_whole {
                true => whole(ui, given, label),
                false => number(ui, given, decimals, label),
            })
        }
        Kind::Number { slider: Some(Range(least, greatest)), decimals, .. } => {
            let mut to = value.as_f64().unwrap_or_default();
            let slid = (columns.middle > 0.0).then(|| {
                let slider = Slider::new(&mut to, least..=greatest)
                    .clamping(SliderClamping::Never)
                    .show_value(false)
                    .step_by(10f64.powi(-(decimals as i32)));
                ui.spacing_mut().slider_width = columns.middle;
                ui.add(slider).labelled_by(label)
            });
            let slid = slid.and_then(|slid| along(&slid, to.into()));
            number(ui, &to.into(), decimals, label).or(slid)
        }
        Kind::Number { is_whole, decimals, .. } => {
            no_slider(ui, columns);
            if is_whole { whole(ui, value, label) } else { number(ui, value, decimals, label) }
        }
        Kind::Choice(words) | Kind::ChoiceOrFile(words) | Kind::ChoiceOr(words, _) => {
            choice(ui, field, words, value, label, columns.wide(ui))
        }
        Kind::Flag => {
            no_slider(ui, columns);
            let mut on = value.as_bool().unwrap_or_default();
            let box_ = tick(ui, &mut on, ()).labelled_by(label);
            box_.changed().then(|| Change::To(on.into()))
        }
        Kind::File => file(ui, value, columns.wide(ui)),
        Kind::Numbers { .. } | Kind::Text | Kind::Variant { .. } | Kind::Rows { .. } => None,
    }
}

/// A number that is dragged or typed.
fn number(ui: &mut Ui, value: &Value, decimals: usize, label: egui::Id) -> Option<Change> {
    let speed = 10f64.powi(-(decimals as i32)) * 5.0;
    let mut number = value.as_f64().unwrap_or_default();
    let wrong = RefCell::default();
    let field = DragValue::new(&mut number)
        .speed(speed)
        .max_decimals(decimals.max(6))
        .min_decimals(decimals.min(3))
        .custom_formatter(short)
        .custom_parser(|text| parsed_or(text, &wrong))
        .update_while_editing(false);
    let response = ui.add_sized(vec2(VALUE_WIDTH, HEIGHT), field).labelled_by(label);
    wrong.into_inner().map(Change::NoNumber).or(along(&response, number.into()))
}

fn whole(ui: &mut Ui, value: &Value, label: egui::Id) -> Option<Change> {
    let mut number = value.as_u64().unwrap_or_default();
    let wrong = RefCell::default();
    let field = DragValue::new(&mut number)
        .speed(0.2)
        .custom_parser(|text| parsed_or(text, &wrong))
        .update_while_editing(false);
    let response = ui.add_sized(vec2(VALUE_WIDTH, HEIGHT), field).labelled_by(label);
    wrong.into_inner().map(Change::NoNumber).or(along(&response, number.into()))
}

fn along(response: &Response, value: Value) -> Option<Change> {
    response.changed().then_some(if response.dragged() || response.has_focus() {
        Change::Along(value)
    } else {
        Change::To(value)
    })
}

fn auto(
    ui: &mut Ui,
    value: &Value,
    start: Value,
    label: egui::Id,
    columns: Columns,
    given: impl FnOnce(&mut Ui, &Value) -> Option<Change>,
) -> Option<Change> {
    let mut is_auto = !value.is_number();
    // Without a column of its own the box gives way to the number; the name's menu resets it.
    let mut toggle = |ui: &mut Ui| tick(ui, &mut is_auto, "auto").labelled_by(label).changed();
    let toggled = match columns.middle {
        middle if middle > 0.0 => cell(ui, middle, toggle),
        _ => value.is_string() && toggle(ui),
    };
    if toggled {
        return Some(Change::To(if is_auto { "auto".into() } else { start }));
    }
    if is_auto { None } else { given(ui, value) }
}

fn choice(
    ui: &mut Ui,
    field: &Field,
    words: &'static [Word],
    value: &Value,
    label: egui::Id,
    width: f32,
) -> Option<Change> {
    let now = value.as_str();
    let mut change = None;
    let text = now.map_or_else(|| field.show(value), |now| shown_choice(words, now));
    let combo = egui::ComboBox::from_id_salt(field.key).selected_text(text).truncate().width(width);
    let response = combo.show_ui(ui, |ui| {
        for Word { word, label, .. } in words {
            if ui.selectable_label(Some(*word) == now, *label).clicked() {
                change = Some(Change::To((*word).into()));
            }
        }
        if matches!(field.kind, Kind::ChoiceOrFile(_)) && ui.selectable_label(false, "Own file…").clicked() {
            change = Some(Change::Choose);
        }
    });
    response.response.labelled_by(label);
    change
}

/// How a choice is shown: by its name, or the name of the file that it is.
pub fn shown_choice(words: &[Word], now: &str) -> String {
    let shown = words.iter().find(|w| w.word == now).map(|w| w.label.to_owned());
    shown.unwrap_or_else(|| file_name(now))
}

fn file(ui: &mut Ui, value: &Value, width: f32) -> Option<Change> {
    let mut change = None;
    let name = value.as_str().map(file_name);
    // There must be room for the other button.
    let button = egui::Button::new(name.as_deref().unwrap_or("Choose…")).truncate();
    let chosen = cell(ui, (width - 50.0).max(VALUE_WIDTH), |ui| ui.add(button));
    if chosen.on_hover_text(value.as_str().unwrap_or("None")).clicked() {
        change = Some(Change::Choose);
    }
    if value.is_string() && ui.button("None").on_hover_text("Derive the electrode from the channel").clicked() {
        change = Some(Change::To(Value::Null));
    }
    change
}
