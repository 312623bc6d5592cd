//! The form of a step, made from the table of parameters: label, value, unit, default, and what is wrong in place.

use crate::widgets::panel_parts::{file_name, parsed_or, short};
use crate::workspaces::blisk::desk::BliskDesk;
use crate::workspaces::context::Context;
use std::cell::RefCell;

use egui::{DragValue, Response, RichText, Slider, SliderClamping, Ui, vec2};
use serde_json::Value;

use crate::widgets::theme::{palette, tick};
use crate::workspaces::blisk::document::fields::{Field, Kind, Range, job_as_json, with_value};
use crate::workspaces::blisk::document::job_file::PlanJob;
use crate::workspaces::blisk::document::stage::Stage;

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
        let unit = if Field::of(stage).any(|f| f.unit.len() > 3) { 54.0 } else { 28.0 };
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
    let job = job_as_json(desk.document.job());
    let defaults = job_as_json(&defaults(desk.document.job()));
    let mut group = "";
    let mut request = None;
    let groups = groups(stage);
    for (name, folded) in groups {
        if name == group {
            continue;
        }
        group = name;
        let fields: Vec<&Field> = Field::of(stage).filter(|f| f.group == name).collect();
        let changed = |f: &&Field| f.get(&job) != f.get(&defaults);
        let mut body = |ui: &mut Ui| {
            let columns = Columns::of(ui, stage);
            for field in &fields {
                match row(ui, field, &job, &defaults, columns) {
                    Some(Change::To(value)) => change(desk, field, &job, value, false),
                    Some(Change::Along(value)) => change(desk, field, &job, value, true),
                    Some(Change::Choose) => request = Some(request_of(field)),
                    Some(Change::NoNumber(text)) => cx.say_in_passing(no_number(field, field.get(&job), &text)),
                    None => {}
                }
            }
        };
        if folded {
            // Only at first: a group that unfolded while one of its sliders is dragged would take it from the hand.
            let open = fields.iter().any(changed);
            egui::CollapsingHeader::new(name).id_salt((stage, name)).default_open(open).show(ui, body);
        } else {
            ui.add_space(4.0);
            ui.label(RichText::new(name).small().color(palette(ui).faint));
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
    let job = job_as_json(desk.document.job());
    Field::of(stage).any(|f| f.problem(f.get(&job)).is_some())
}

fn request_of(field: &Field) -> Request {
    match field.pointer {
        "/machine/name" => Request::Machine,
        _ if field.stage == Stage::Export => Request::Post,
        _ => Request::ElectrodeMesh,
    }
}

/// The defaults that fields are compared with: those of the same part.
fn defaults(job: &PlanJob) -> PlanJob {
    let mut defaults = PlanJob::demonstration();
    if job.blisk.mesh.is_some() {
        defaults.electrode = Default::default();
    }
    defaults.blisk.mesh = job.blisk.mesh.clone();
    defaults
}

/// Headings of a step's form in order, and whether they start folded: what few need to touch.
fn groups(stage: Stage) -> Vec<(&'static str, bool)> {
    const FOLDED: [&str; 10] = [
        "Radii",
        "Wall grid",
        "Body",
        "Own electrode",
        "Weights",
        "Fine points",
        "Centreline search",
        "Genetic search",
        "Files",
        "Pictures",
    ];
    let mut groups: Vec<(&str, bool)> = Vec::new();
    for field in Field::of(stage) {
        if groups.last().is_none_or(|(name, _)| *name != field.group) {
            groups.push((field.group, FOLDED.contains(&field.group)));
        }
    }
    groups
}

fn change(desk: &mut BliskDesk, field: &Field, job: &Value, value: Value, dragging: bool) {
    // A value that the struct itself cannot hold never leaves its field.
    if let Ok(job) = with_value(job, field, value) {
        desk.edit(&format!("{} {}", field.group, field.label), job, dragging);
    }
}

fn row(ui: &mut Ui, field: &Field, job: &Value, defaults: &Value, columns: Columns) -> Option<Change> {
    let value = field.get(job);
    let mut change = None;
    ui.horizontal(|ui| {
        let changed = value != field.get(defaults);
        let name = RichText::new(field.label).color(if changed {
            ui.visuals().strong_text_color()
        } else {
            ui.visuals().text_color()
        });
        let label = cell(ui, columns.label, |ui| {
            ui.add(egui::Label::new(name).truncate().selectable(false).sense(egui::Sense::click()))
        });
        let hint = |ui: &mut Ui| tooltip(ui, field, field.get(defaults));
        let label_id = label.id;
        label.clone().on_hover_ui(hint);
        label.context_menu(|ui| {
            if ui.button("Reset to default").clicked() {
                change = Some(Change::To(field.get(defaults).clone()));
            }
        });
        if let Some(wanted) = widget(ui, field, value, label_id, columns) {
            change = Some(wanted);
        }
        if !field.unit.is_empty() && shows_number(field.kind, value) {
            ui.label(RichText::new(field.unit).color(palette(ui).faint));
        }
    });
    if let Some(problem) = field.problem(value) {
        ui.with_layout(egui::Layout::top_down(egui::Align::Max), |ui| {
            let text = RichText::new(format!("{} {problem}", field.label)).small().color(palette(ui).bad);
            ui.add(egui::Label::new(text).wrap());
        });
    }
    change
}

/// Whether a number stands in the row, which is to have its unit.
fn shows_number(kind: Kind, value: &Value) -> bool {
    match kind {
        Kind::AutoNumber(..) | Kind::AutoInteger(..) => value.is_number(),
        kind => matches!(kind, Kind::Number(..) | Kind::Slider(..) | Kind::Integer(_)),
    }
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
    ui.weak(field.key());
}

fn shown(value: &Value) -> Option<String> {
    match value {
        Value::Null => None,
        Value::String(text) => Some(text.clone()),
        other => Some(other.to_string()),
    }
}

fn widget(ui: &mut Ui, field: &Field, value: &Value, label: egui::Id, columns: Columns) -> Option<Change> {
    if field.problem(value).is_some() {
        let bad = palette(ui).bad;
        let widgets = &mut ui.visuals_mut().widgets;
        widgets.inactive.bg_stroke = egui::Stroke::new(1.0, bad);
        widgets.hovered.bg_stroke = egui::Stroke::new(1.0, bad);
    }
    match field.kind {
        Kind::Number(_, decimals) => {
            no_slider(ui, columns);
            number(ui, value, decimals, label)
        }
        Kind::Slider(_, Range(least, greatest), decimals) => {
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
        Kind::Integer(_) => {
            no_slider(ui, columns);
            whole(ui, value, label)
        }
        Kind::AutoNumber(_, decimals, start) => {
            auto(ui, value, start.into(), label, columns, |ui, given| number(ui, given, decimals, label))
        }
        Kind::AutoInteger(_, start) => {
            auto(ui, value, start.into(), label, columns, |ui, given| whole(ui, given, label))
        }
        Kind::Choice(words) => choice(ui, field, words, value, label, columns.wide(ui)),
        Kind::ChoiceOrFile(words) => choice(ui, field, words, value, label, columns.wide(ui)),
        Kind::Flag => {
            no_slider(ui, columns);
            let mut on = value.as_bool().unwrap_or_default();
            let box_ = tick(ui, &mut on, ()).labelled_by(label);
            box_.changed().then(|| Change::To(on.into()))
        }
        Kind::File => file(ui, value, columns.wide(ui)),
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
    words: &'static [(&'static str, &'static str)],
    value: &Value,
    label: egui::Id,
    width: f32,
) -> Option<Change> {
    let now = value.as_str();
    let mut change = None;
    let text = now.map_or("as in the job file".to_owned(), |now| shown_choice(words, now));
    let combo = egui::ComboBox::from_id_salt(field.pointer).selected_text(text).truncate().width(width);
    let response = combo.show_ui(ui, |ui| {
        for (word, shown) in words {
            if ui.selectable_label(Some(*word) == now, *shown).clicked() {
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
pub fn shown_choice(words: &[(&str, &str)], now: &str) -> String {
    let shown = words.iter().find(|(word, _)| *word == now).map(|(_, shown)| (*shown).to_owned());
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
