//! Forms made from a table of parameters: label, value, unit, default, and errors beside the field.

mod rows;
mod widgets;

use egui::{Response, RichText, Ui, vec2};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use super::panel_parts::sentence;
use super::theme::palette;
use files::{Field, FieldTable, Group, Instead, Invalid, Kind, Place, Range, Validate, get};

pub use rows::ExtraColumn;

/// Width of a number (points).
const VALUE: f32 = 74.0;
/// Width of a slider, or of another widget before a number.
const MIDDLE: f32 = 90.0;
/// Least width of a form that has room for sliders.
const ROOM_FOR_SLIDERS: f32 = 272.0;
/// Least width of a label.
const LABEL: f32 = 84.0;
/// Height of a row.
const HEIGHT: f32 = 22.0;
/// Room between numbers beside each other.
const GAP: f32 = 4.0;

/// A change of a field.
enum Change {
    /// A single change.
    To(Value),
    /// A change within a gesture: a button is down, or keys step a slider.
    Along(Value),
    /// The user wants to choose a file.
    Choose,
    /// No change: the typed text is not a number.
    NoNumber(String),
    /// No change: the typed value is not allowed.
    Wrong(Invalid),
}

/// Parameters changed by a form.
#[derive(Debug, Clone, PartialEq)]
pub struct Edit<P> {
    /// All parameters after the change.
    pub params: P,
    /// Key of the changed parameter; empty if no field was used.
    pub key: String,
    /// Name of the change for undo.
    pub label: String,
    /// Whether the change belongs to a gesture.
    pub in_gesture: bool,
}

/// Result of a form in a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer<P> {
    /// The change, if there was one.
    pub edit: Option<Edit<P>>,
    /// The key of the parameter for which a file is to be chosen.
    pub wanted: Option<String>,
    /// Message about the typed text.
    pub said: Option<String>,
}

/// A form for parameters `P` while it is drawn: groups, rows and tables in any order, then [`answer`](Self::answer).
pub struct Form<P: 'static> {
    table: &'static FieldTable<P>,
    before: P,
    params: P,
    values: Value,
    defaults: Value,
    problem: Option<Invalid>,
    changed: String,
    in_gesture: bool,
    wanted: Option<String>,
    said: Option<String>,
}

impl<P: Clone + PartialEq + Serialize + DeserializeOwned + Validate> Form<P> {
    /// A form of `table` for `params`, with which this is wrong.
    pub fn new(table: &'static FieldTable<P>, params: &P, problem: Option<&Invalid>) -> Self {
        Self {
            table,
            before: params.clone(),
            params: params.clone(),
            values: table.values(params),
            defaults: table.values(&table.defaults(params)),
            problem: problem.cloned(),
            changed: String::new(),
            in_gesture: false,
            wanted: None,
            said: None,
        }
    }

    /// The parameters as they are now.
    pub fn params(&self) -> &P {
        &self.params
    }

    /// The value of the parameter under `key`; null if there is none.
    pub fn value(&self, key: &str) -> &Value {
        get(&self.values, key)
    }

    /// Changes the parameters without a field.
    pub fn change(&mut self, edit: impl FnOnce(&mut P)) {
        edit(&mut self.params);
        self.values = self.table.values(&self.params);
    }

    /// The change, and what the user asks for.
    pub fn answer(self) -> Answer<P> {
        let Self { table, before, params, changed: key, in_gesture, wanted, said, .. } = self;
        let label = if params == before { None } else { Some(table.change(&before, &params)) };
        Answer { edit: label.map(|label| Edit { params, key, label, in_gesture }), wanted, said }
    }

    /// Draws the groups of `section`. Groups for few users are folded unless a value in them differs from its default.
    pub fn section(&mut self, ui: &mut Ui, section: &str) {
        for group in self.table.groups(section) {
            self.draw(ui, group);
        }
    }

    /// Draws the group called `name`, with its heading.
    pub fn group(&mut self, ui: &mut Ui, name: &str) {
        if let Some(group) = self.table.groups("").find(|group| group.name == name) {
            self.draw(ui, group);
        }
    }

    fn draw(&mut self, ui: &mut Ui, group: &'static Group) {
        let name = group.name;
        if !group.fields.iter().any(|field| field.is_shown(&self.values)) {
            return;
        }
        if group.is_folded {
            let changed = |field: &Field| get(&self.values, field.key) != get(&self.defaults, field.key);
            // Only at first: a group that unfolded while one of its sliders is dragged would take it from the hand.
            let open = group.fields.iter().any(changed);
            let header = egui::CollapsingHeader::new(name).id_salt((group.section, name)).default_open(open);
            header.show_unindented(ui, |ui| self.fields(ui, group));
        } else {
            heading(ui, name);
            self.fields(ui, group);
        }
    }

    fn fields(&mut self, ui: &mut Ui, group: &'static Group) {
        for field in group.fields {
            match field.kind {
                Kind::Rows { .. } => {
                    if field.label != group.name {
                        heading(ui, field.label);
                    }
                    self.rows(ui, field.key, None);
                }
                _ => self.row(ui, field.key),
            }
        }
    }

    /// Draws the parameter under `key` in a row of its own, if it counts.
    pub fn row(&mut self, ui: &mut Ui, key: &str) {
        self.row_with(ui, key, &[]);
    }

    /// Draws the parameter as [`Self::row`] does, with further words to choose and their labels.
    pub fn row_with(&mut self, ui: &mut Ui, key: &str, also: &[[String; 2]]) {
        let Ok(place) = self.table.find(key) else { return };
        if !place.field.is_shown(&self.values) {
            return;
        }
        let (field, value) = (place.field, get(&self.values, key).clone());
        let default = get(&self.defaults, key).clone();
        let problem = self.problem_of(&place, &value);
        let mut change = None;
        let is_long = widgets::is_long(ui, &place, &value);
        ui.horizontal(|ui| {
            let widths = Widths::of(ui, field);
            let label = cell(ui, widths.label, |ui| label(ui, field, value != default));
            label.clone().on_hover_ui(|ui| tooltip(ui, field, Some(&default)));
            label.context_menu(|ui| {
                if ui.button("Reset to default").clicked() {
                    change = Some(Change::To(default.clone()));
                }
            });
            if problem.is_some() {
                mark(ui);
            }
            let made = match is_long {
                true => widgets::head(ui, &place, &value, widths),
                false => widgets::widget(ui, &place, &value, widths, also),
            };
            change = made.or(change.take());
            // Some files must be there.
            let can_go = || value.is_string() && value != "" && self.table.put(&self.values, key, Value::Null).is_ok();
            if field.kind == Kind::File && can_go() && ui.button("None").on_hover_text(field.help).clicked() {
                change = Some(Change::To(Value::Null));
            }
            if !is_long && !field.unit.is_empty() && (value.is_number() || value.is_array()) {
                ui.label(RichText::new(field.unit).color(palette(ui).faint));
            }
        });
        if is_long {
            ui.horizontal(|ui| {
                if problem.is_some() {
                    mark(ui);
                }
                change = widgets::components(ui, &place, &value).or(change.take());
            });
        }
        if let Some(problem) = problem {
            complain(ui, &problem);
        }
        self.take(&place, &value, change);
    }

    /// The error of a field's value, in the words of the window.
    fn problem_of(&self, place: &Place, value: &Value) -> Option<String> {
        let own = place.field.check(&place.key, value).err();
        let has_rows = matches!(place.field.kind, Kind::Rows { .. });
        let is_here = |key: &str| key == place.key || has_rows && key.starts_with(&place.key);
        let of_all = self.problem.clone().filter(|problem| is_here(&problem.key));
        own.or(of_all).map(|problem| sentence(&self.table.in_window(&problem)))
    }

    /// Replaces the value of `key`, if the parameters can hold the new one.
    pub fn put(&mut self, key: &str, value: Value) {
        // A value that the parameters themselves cannot hold never leaves its field.
        if let Ok(params) = self.table.put(&self.values, key, value) {
            self.values = self.table.values(&params);
            (self.params, self.changed) = (params, key.to_owned());
        }
    }

    fn take(&mut self, place: &Place, value: &Value, change: Option<Change>) {
        match change {
            None => {}
            Some(Change::To(value)) => self.put(&place.key, value),
            Some(Change::Along(value)) => {
                self.in_gesture = true;
                self.put(&place.key, value);
            }
            Some(Change::Choose) => self.wanted = Some(place.key.clone()),
            Some(Change::NoNumber(text)) => self.said = Some(no_number(place, value, &text)),
            Some(Change::Wrong(problem)) => self.said = Some(self.table.in_window(&problem)),
        }
    }
}

/// Heading of a group of fields.
pub fn heading(ui: &mut Ui, name: &str) {
    if !name.is_empty() {
        ui.add_space(4.0);
        ui.label(RichText::new(name).small().color(palette(ui).faint));
    }
}

/// Widths of the columns of a row: label, slider, number. Numbers stand below each other.
#[derive(Clone, Copy)]
struct Widths {
    label: f32,
    /// Width of the slider; 0 where there is no room or need for sliders.
    middle: f32,
    /// Width of slider and number together.
    wide: f32,
}

impl Widths {
    fn of(ui: &Ui, field: &Field) -> Self {
        let (width, gap) = (ui.available_width(), ui.spacing().item_spacing.x);
        let unit = if field.unit.len() > 3 { 54.0 } else { 28.0 };
        if let Kind::Choice(words) = field.kind
            && widgets::is_short(words)
        {
            let wide = words.iter().map(|word| 17.0 + 8.0 * word.label.chars().count() as f32).sum::<f32>();
            return Self { label: (width - wide - gap).max(40.0), middle: 0.0, wide };
        }
        let has_room = width >= ROOM_FOR_SLIDERS;
        let (is_wide, has_middle) = match field.kind {
            Kind::Number { slider, instead, .. } => (false, slider.is_some() || instead != Instead::Never),
            Kind::Flag => (false, false),
            _ => (true, false),
        };
        let middle = if has_room && has_middle { MIDDLE } else { 0.0 };
        let most = (width - LABEL - unit - 2.0 * gap).max(VALUE);
        let wide = if is_wide { (MIDDLE + gap + VALUE).min(most) } else { VALUE };
        let label = width - wide - unit - 2.0 * gap - if middle > 0.0 { middle + gap } else { 0.0 };
        Self { label: label.max(40.0), middle, wide }
    }
}

/// A place of fixed width in a row.
fn cell<R>(ui: &mut Ui, width: f32, add: impl FnOnce(&mut Ui) -> R) -> R {
    let layout = egui::Layout::left_to_right(egui::Align::Center);
    let made = ui.allocate_ui_with_layout(vec2(width, HEIGHT), layout, |ui| {
        ui.set_min_width(width);
        ui.set_max_width(width);
        add(ui)
    });
    made.inner
}

fn label(ui: &mut Ui, field: &Field, is_changed: bool) -> Response {
    let visuals = ui.visuals();
    let colour = if is_changed { visuals.strong_text_color() } else { visuals.text_color() };
    let name = RichText::new(field.label).color(colour);
    ui.add(egui::Label::new(name).truncate().selectable(false).sense(egui::Sense::click()))
}

/// Colours the edge of the next widgets as wrong.
fn mark(ui: &mut Ui) {
    let bad = palette(ui).bad;
    let widgets = &mut ui.visuals_mut().widgets;
    widgets.inactive.bg_stroke = egui::Stroke::new(1.0, bad);
    widgets.hovered.bg_stroke = egui::Stroke::new(1.0, bad);
}

/// The error text below a field.
pub fn complain(ui: &mut Ui, problem: &str) {
    ui.with_layout(egui::Layout::top_down(egui::Align::Max), |ui| {
        ui.add(egui::Label::new(RichText::new(problem).small().color(palette(ui).bad)).wrap());
    });
}

fn tooltip(ui: &mut Ui, field: &Field, default: Option<&Value>) {
    ui.set_max_width(320.0);
    let symbol = if field.symbol.is_empty() { String::new() } else { format!("   {}", field.symbol) };
    ui.strong(format!("{}{symbol}", field.label));
    ui.label(field.help);
    if let Some(allowed) = field.range().and(field.allowed()) {
        ui.weak(sentence(&allowed));
    }
    if let Some(default) = default.filter(|value| !value.is_null() && !value.is_object()) {
        let unit =
            if field.unit.is_empty() || !default.is_number() { String::new() } else { format!(" {}", field.unit) };
        ui.weak(format!("Default {}{unit}", field.show_label(default)));
    }
    ui.weak(field.key);
}

/// The message that `text`, which was typed, is not a number, with the allowed values.
fn no_number(place: &Place, value: &Value, text: &str) -> String {
    let Place { field, label, .. } = place;
    let unit = if field.unit.is_empty() { String::new() } else { format!(" {}", field.unit) };
    let asked = match field.range() {
        Some(Range(least, greatest)) if greatest.is_finite() => format!("a number from {least} to {greatest}{unit}"),
        Some(Range(least, _)) if least.is_finite() => format!("a number of at least {least}{unit}"),
        _ => "a number".to_owned(),
    };
    let stays = if value.is_number() { format!("; it stays {}{unit}", field.show(value)) } else { String::new() };
    let typed: String = text.trim().chars().take(24).collect();
    format!("{label}: \"{typed}\" is not a number; enter {asked}{stays}")
}
