//! Tables of rows in forms.

use egui::{RichText, Ui, vec2};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use super::{Form, GAP, cell, complain, mark, tooltip, widgets};
use crate::widgets::theme::palette;
use files::{Field, Kind, Place, Validate, get, inline_toml};

/// Width of the number of a row (points).
const NUMBER: f32 = 22.0;
/// Room that a heading leaves before the next one (points).
const APART: f32 = 6.0;

/// A column without a parameter of its own, such as a value derived from several parameters.
pub struct ExtraColumn<'a> {
    /// Heading of the column.
    pub head: &'a str,
    /// The number of columns before it.
    pub after: usize,
    /// Width (points).
    pub width: f32,
    /// Draws the cell of a row. Returns the changed row, if any.
    pub draw: &'a mut dyn FnMut(&mut Ui, &str, &Value) -> Option<Value>,
    /// What a row is called whose name is empty.
    pub called: fn(&Value) -> Option<String>,
}

impl<P: Clone + PartialEq + Serialize + DeserializeOwned + Validate> Form<P> {
    /// Draws the rows under `key` as a table: a line for each, or as many lines as the columns need. The number of a
    /// row opens its menu.
    pub fn rows(&mut self, ui: &mut Ui, key: &str, mut extra: Option<ExtraColumn>) {
        let Ok(place) = self.table.find(key) else { return };
        let Kind::Rows { fields, is_first, .. } = place.field.kind else { return };
        if !place.field.is_shown(&self.values) {
            return;
        }
        let rows = get(&self.values, key).as_array().cloned().unwrap_or_default();
        let columns = Columns::of(ui, fields, extra.as_ref().map(|extra| (extra.after, extra.width)));
        ui.scope(|ui| {
            ui.spacing_mut().item_spacing = vec2(GAP, 2.0);
            if !rows.is_empty() {
                columns.heads(ui, extra.as_ref().map_or("", |extra| extra.head));
            }
            for (i, row) in rows.iter().enumerate() {
                let called = extra.as_ref().and_then(|extra| (extra.called)(row));
                let hint = called.as_deref().unwrap_or(widgets::NOTHING);
                for line in 0..columns.lines {
                    ui.horizontal(|ui| {
                        if line == 0 {
                            self.row_menu(ui, &place, i, &rows);
                        } else {
                            cell(ui, NUMBER, |_| ());
                        }
                        for column in columns.all.iter().filter(|column| column.line == line) {
                            let Some(field) = column.field else {
                                let name = format!("{} {}", place.label, i + 1);
                                let draw = extra.as_mut().map(|extra| &mut extra.draw);
                                let other = cell(ui, column.width, |ui| draw.and_then(|draw| draw(ui, &name, row)));
                                self.take_row(&place, i, other);
                                continue;
                            };
                            let inner = Place {
                                field,
                                key: format!("{key}[{i}].{}", field.key),
                                label: format!("{} {}, {}", place.label, i + 1, field.label),
                            };
                            let value = get(row, field.key);
                            let is_there = field.is_shown(row);
                            let change = cell(ui, column.width, |ui| {
                                if is_there && self.problem_of(&inner, value).is_some() {
                                    mark(ui);
                                }
                                is_there.then(|| widgets::narrow(ui, &inner, value, column.width, hint)).flatten()
                            });
                            if line > 0 && is_there {
                                ui.label(RichText::new(column.in_line()).small().color(palette(ui).faint));
                            }
                            self.take(&inner, value, change);
                        }
                    });
                }
            }
            let problem = self.problem_of(&place, get(&self.values, key));
            if let Some(problem) = problem {
                complain(ui, &problem);
            }
            ui.add_space(ui.spacing().item_spacing.y);
            let name = format!("Add to {}", place.label);
            let add = ui.small_button("Add").on_hover_text(place.field.help);
            ui.ctx().accesskit_node_builder(add.id, |node| node.set_label(name));
            if add.clicked() {
                self.set_rows(&place, |rows| rows.insert(if is_first { 0 } else { rows.len() }, new_row(&place, rows)));
            }
        });
    }

    /// The number of row `i`, which has a menu.
    fn row_menu(&mut self, ui: &mut Ui, place: &Place, i: usize, rows: &[Value]) {
        let mut edit: Option<fn(&mut Vec<Value>, usize)> = None;
        let menu = cell(ui, NUMBER, |ui| {
            ui.menu_button(RichText::new((i + 1).to_string()).color(palette(ui).faint), |ui| {
                let mut entry = |is_on: bool, text: &str, does: fn(&mut Vec<Value>, usize)| {
                    if ui.add_enabled(is_on, egui::Button::new(text)).clicked() {
                        edit = Some(does);
                        ui.close();
                    }
                };
                entry(true, "Duplicate", |rows, i| rows.insert(i + 1, rows[i].clone()));
                entry(true, "Remove", |rows, i| drop(rows.remove(i)));
                entry(i > 0, "Move up", |rows, i| rows.swap(i, i - 1));
                entry(i + 1 < rows.len(), "Move down", |rows, i| rows.swap(i, i + 1));
            })
            .response
        });
        let name = format!("{} {}", place.label, i + 1);
        ui.ctx().accesskit_node_builder(menu.id, |node| node.set_label(name));
        menu.on_hover_text("Duplicate, remove or move this row");
        if let Some(edit) = edit {
            self.set_rows(place, |rows| edit(rows, i));
        }
    }

    fn set_rows(&mut self, place: &Place, edit: impl FnOnce(&mut Vec<Value>)) {
        let mut rows = get(&self.values, &place.key).as_array().cloned().unwrap_or_default();
        edit(&mut rows);
        self.put(&place.key, rows.into());
    }

    fn take_row(&mut self, place: &Place, i: usize, row: Option<Value>) {
        if let Some(row) = row {
            self.put(&format!("{}[{i}]", place.key), row);
        }
    }
}

/// A column of a table.
struct Column {
    field: Option<&'static Field>,
    /// Name and unit, which may be empty.
    head: [String; 2],
    width: f32,
    line: usize,
}

impl Column {
    /// The heading in a line.
    fn in_line(&self) -> String {
        let [name, unit] = &self.head;
        if unit.is_empty() { name.clone() } else { format!("{name} {unit}") }
    }
}

/// The columns of a table, in as many lines as the available width requires.
struct Columns {
    all: Vec<Column>,
    lines: usize,
    /// Whether units stand below the names in the headings.
    is_stacked: bool,
}

impl Columns {
    /// Columns in as few lines as possible. Units stand below the names where that brings all into a line.
    fn of(ui: &Ui, fields: &'static [Field], extra: Option<(usize, f32)>) -> Self {
        let in_line = Self::laid_out(ui, fields, extra, false);
        if in_line.lines == 1 {
            return in_line;
        }
        let stacked = Self::laid_out(ui, fields, extra, true);
        if stacked.lines == 1 { stacked } else { in_line }
    }

    fn laid_out(ui: &Ui, fields: &'static [Field], extra: Option<(usize, f32)>, is_stacked: bool) -> Self {
        let room = ui.available_width() - NUMBER - 2.0 * GAP;
        let font = egui::TextStyle::Small.resolve(ui.style());
        // A unit is said once and holds for the columns that follow.
        let mut unit = "";
        let mut column = |field: &'static Field| {
            let said = if field.unit == unit { "" } else { field.unit };
            unit = field.unit;
            Self::column(ui, (field, said), &font, is_stacked)
        };
        let mut all: Vec<Column> = fields.iter().map(&mut column).collect();
        if let Some((after, width)) = extra {
            all.insert(after.min(all.len()), Column { field: None, head: Default::default(), width, line: 0 });
        }
        let (mut line, mut used) = (0, 0.0);
        for column in &mut all {
            let head = text_width(ui, &column.in_line(), &font) + GAP;
            let label = |line: usize| if line == 0 { 0.0 } else { head };
            if used > 0.0 && used + column.width + label(line) > room {
                (line, used) = (line + 1, 0.0);
            }
            column.line = line;
            used += column.width + GAP + label(line);
        }
        // Texts take what is left of the first line.
        let left = room - all.iter().filter(|c| c.line == 0).map(|c| c.width + GAP).sum::<f32>();
        if let Some(text) = all.iter_mut().find(|c| c.line == 0 && c.field.is_some_and(|f| f.kind == Kind::Text)) {
            text.width += left.clamp(0.0, 120.0);
        }
        Self { all, lines: line + 1, is_stacked }
    }

    fn column(ui: &Ui, (field, unit): (&'static Field, &str), font: &egui::FontId, is_stacked: bool) -> Column {
        let name = if field.symbol.is_empty() { field.label } else { field.symbol };
        let least = match field.kind {
            Kind::Text => 40.0,
            Kind::Choice(_) | Kind::ChoiceOrFile(_) | Kind::Variant { .. } => 62.0,
            Kind::Numbers { count, .. } => 50.0 * count.unwrap_or(2) as f32,
            Kind::Flag => NUMBER,
            _ => 50.0,
        };
        let mut column = Column { field: Some(field), width: least, head: [name, unit].map(str::to_owned), line: 0 };
        let of_text = |text: &str| text_width(ui, text, font) + APART;
        let [name, unit] = &column.head;
        let wide = if is_stacked { of_text(name).max(of_text(unit)) } else { of_text(&column.in_line()) };
        column.width = column.width.max(wide);
        column
    }

    /// The headings of the first line.
    fn heads(&self, ui: &mut Ui, extra: &str) {
        ui.horizontal(|ui| {
            cell(ui, NUMBER, |_| ());
            for column in self.all.iter().filter(|column| column.line == 0) {
                let head = match (column.field, self.is_stacked) {
                    (None, _) => extra.to_owned(),
                    (_, true) => column.head.join("\n"),
                    (_, false) => column.in_line(),
                };
                let text = RichText::new(head).small().color(palette(ui).faint);
                let label = egui::Label::new(text).selectable(false);
                let label = if self.is_stacked { label } else { label.truncate() };
                let label = cell(ui, column.width, |ui| ui.add(label));
                if let Some(field) = column.field {
                    label.on_hover_ui(|ui| tooltip(ui, field, None));
                }
            }
        });
    }
}

fn text_width(ui: &Ui, text: &str, font: &egui::FontId) -> f32 {
    ui.painter().layout_no_wrap(text.to_owned(), font.clone(), egui::Color32::WHITE).size().x + 1.0
}

/// A new row as the table defines it, with a unique name.
fn new_row(place: &Place, rows: &[Value]) -> Value {
    let Kind::Rows { new, .. } = place.field.kind else { return Value::Null };
    let mut row = inline_toml(new);
    if let Some(name) = row["name"].as_str().filter(|name| !name.is_empty()).map(str::to_owned) {
        let is_free = |name: &String| rows.iter().all(|row| row["name"].as_str() != Some(name));
        let mut names = std::iter::once(name.clone()).chain((2..).map(|n| format!("{name}{n}")));
        row["name"] = names.find(is_free).into();
    }
    row
}
