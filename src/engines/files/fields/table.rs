//! The table of all parameters of a struct.

use std::fmt::Write;

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use super::text::inline_toml;
use super::{Field, Instead, Kind, When, get, put, steps};
use crate::Invalid;
use crate::toml_file::one_line;

/// Parameters under one heading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Group {
    /// Step or tab of the workspace; may be empty.
    pub section: &'static str,
    /// Heading.
    pub name: &'static str,
    /// Whether forms show the group folded at first, because few users need it.
    pub is_folded: bool,
    /// The parameters.
    pub fields: &'static [Field],
}

/// The fields of all parameters of a `P`, in the order of its forms.
#[derive(Debug)]
pub struct FieldTable<P> {
    pub(super) groups: &'static [Group],
    defaults: fn(&P) -> P,
}

/// A field with the place of its parameter, which may lie in a row.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// The field.
    pub field: &'static Field,
    /// The whole key, as in `stages[1].gap_mm`.
    pub key: String,
    /// Name for a reader, as in `Stages 2, Gap`.
    pub label: String,
}

impl<P: Default> FieldTable<P> {
    /// The table with these groups.
    pub const fn new(groups: &'static [Group]) -> Self {
        Self { groups, defaults: default_of::<P> }
    }
}

fn default_of<P: Default>(_: &P) -> P {
    P::default()
}

impl<P: Serialize + DeserializeOwned> FieldTable<P> {
    /// Sets defaults that depend on other parameters, such as the part.
    #[must_use]
    pub const fn with_defaults(self, defaults: fn(&P) -> P) -> Self {
        Self { defaults, ..self }
    }

    /// Every field.
    pub fn fields(&self) -> impl Iterator<Item = &'static Field> {
        self.groups.iter().flat_map(|group| group.fields)
    }

    /// The parameters as JSON, for [`get`] and [`put`]. A form makes them once a frame.
    pub fn values(&self, params: &P) -> Value {
        // Parameters are numbers, words, lists and tables, all of which JSON has.
        serde_json::to_value(params).unwrap_or_default()
    }

    /// The defaults that `params` are compared with.
    pub fn defaults(&self, params: &P) -> P {
        (self.defaults)(params)
    }

    /// The groups of a section, or all of them for an empty one.
    pub fn groups(&self, section: &str) -> impl Iterator<Item = &'static Group> {
        self.groups.iter().filter(move |group| section.is_empty() || group.section == section)
    }

    /// The parameter called `key`.
    ///
    /// # Errors
    /// If there is no such parameter; the error suggests the nearest key.
    pub fn find(&self, key: &str) -> Result<Place, Invalid> {
        find(self.fields(), key, "", "").ok_or_else(|| {
            let wanted = steps(key).last().unwrap_or_default();
            // The unit at its end is often left out.
            let is_named = |other: &str| {
                let rest = other.strip_prefix(wanted);
                !wanted.is_empty() && rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('_'))
            };
            let distance = |other: &str| {
                let off = strsim::damerau_levenshtein(other, key);
                let is_near = 3 * off <= key.chars().count();
                match is_named(steps(other).last().unwrap_or_default()) {
                    true => Some((0, off)),
                    false => is_near.then_some((1, off)),
                }
            };
            // Longer texts than any key would only take time.
            let keys = keys_of(self.fields(), "").into_iter().filter(|_| key.len() < 200);
            let near = keys.filter_map(|other| Some((distance(&other)?, other))).min_by_key(|(off, _)| *off);
            let near = near.map_or_else(String::new, |(_, near)| format!("; did you mean {near}?"));
            Invalid::of(key, format!("there is no such parameter{near}"))
        })
    }

    /// The parameters with the value `text` for `key`, as the command line gives it: one value, with quotation marks as in
    /// files or without, or a list in brackets for all entries of a key such as `reduction_deg`. Conditions between
    /// parameters are left to validation, because several may be set one after the other.
    ///
    /// # Errors
    /// If there is no such parameter, or it cannot have this value.
    pub fn set(&self, params: &P, key: &str, text: &str) -> Result<P, Invalid> {
        let entries = self.fields().filter(|field| {
            field.key.strip_prefix(key).is_some_and(|rest| rest.starts_with('[') && rest.ends_with(']'))
        });
        let entries: Vec<&str> = entries.map(|field| field.key).collect();
        if !entries.is_empty() {
            let values = text.trim().strip_prefix('[').and_then(|text| text.strip_suffix(']')).unwrap_or(text);
            let values: Vec<&str> = values.split(',').map(str::trim).collect();
            if values.len() != entries.len() {
                return Err(Invalid::new(key, text, format!("must be a list of {} values", entries.len())));
            }
            let first = self.set(params, entries[0], values[0])?;
            return entries
                .into_iter()
                .zip(values)
                .skip(1)
                .try_fold(first, |set, (key, text)| self.set(&set, key, text));
        }
        let place = self.find(key)?;
        let quoted = text.strip_prefix('"').and_then(|text| text.strip_suffix('"'));
        let value = place.field.parse(&place.key, quoted.filter(|text| !text.contains('"')).unwrap_or(text))?;
        let params = self.put(&self.values(params), &place.key, value)?;
        place.field.check(&place.key, get(&self.values(&params), &place.key))?;
        Ok(params)
    }

    /// The value of `key` as a text that [`set`](Self::set) takes.
    ///
    /// # Errors
    /// If there is no such parameter.
    pub fn get(&self, params: &P, key: &str) -> Result<String, Invalid> {
        let place = self.find(key)?;
        Ok(place.field.show(get(&self.values(params), &place.key)))
    }

    /// The parameters in `values` with another value for `key`, as forms give it. A value out of range is accepted, so
    /// that the form can mark it; a value that the struct cannot hold is refused.
    ///
    /// # Errors
    /// If the key does not exist, or cannot hold the value.
    pub fn put(&self, values: &Value, key: &str, value: Value) -> Result<P, Invalid> {
        let none = || {
            let whole = key.rsplit_once('.').and_then(|(table, _)| self.find(table).ok());
            let way_out = match whole.as_ref().map(|place| (&place.field.kind, &place.key)) {
                Some((Kind::ChoiceOr(_, form), key)) => format!("give all of {key}, as in \"{key}={form}\""),
                _ => "add the row or choose the variant first".to_owned(),
            };
            Invalid::of(key, format!("there is no such parameter in these; {way_out}"))
        };
        let (mut values, given) = (values.clone(), value.clone());
        if !put(&mut values, key, value) {
            return Err(none());
        }
        let wrong = |e: serde_json::Error| Invalid::new(key, text_of(&given), one_line(&e.to_string()));
        let params = match (P::deserialize(&values), key.rsplit_once('.')) {
            (Ok(params), _) => params,
            // An empty word where there may be none.
            (Err(_), _) if given == "" && put(&mut values, key, Value::Null) => {
                P::deserialize(&values).map_err(wrong)?
            }
            // What a table cannot do without takes the table away.
            (Err(_), Some((table, _))) if given.is_null() && put(&mut values, table, Value::Null) => {
                P::deserialize(&values).map_err(wrong)?
            }
            (Err(e), _) => return Err(wrong(e)),
        };
        // Serde drops what another variant would have in silence.
        let is_lost = !given.is_null() && given != "" && get(&self.values(&params), key).is_null();
        if is_lost { Err(none()) } else { Ok(params) }
    }

    /// The parameters with the default value for `key`.
    ///
    /// # Errors
    /// If there is no such parameter, or it has no default, as in a row.
    pub fn reset(&self, params: &P, key: &str) -> Result<P, Invalid> {
        let defaults = self.values(&self.defaults(params));
        let place = self.find(key)?;
        self.put(&self.values(params), &place.key, get(&defaults, &place.key).clone())
    }

    /// Checks that every parameter that counts is in its range.
    ///
    /// # Errors
    /// The first that is not.
    pub fn check(&self, params: &P) -> Result<(), Invalid> {
        // Of all that parameters hold only paths may be no text.
        let values = serde_json::to_value(params).map_err(|_| {
            let remedy = "has bytes that are no UTF-8 text, and projects and reports could not name it; rename the file or its folder";
            Invalid::of("the name of a file", remedy)
        })?;
        let mut counting = self.fields().filter(|field| field.is_shown(&values));
        counting.try_for_each(|field| field.check(field.key, get(&values, field.key)))
    }

    /// The error in the words of the window: with labels and units, without keys.
    pub fn in_window(&self, problem: &Invalid) -> String {
        let Invalid { key, value, remedy } = problem;
        let remedy = self.labelled(remedy);
        let (label, unit) = match self.find(key) {
            Ok(place) => (place.label, place.field.unit),
            Err(_) => (words_of(key), ""),
        };
        let is_number = value.parse::<f64>().is_ok() && !unit.is_empty();
        let unit = if is_number { format!(" {unit}") } else { String::new() };
        match (label.is_empty(), value.is_empty()) {
            (true, _) => remedy,
            (_, true) => format!("{label}: {remedy}"),
            _ => format!("{label} is {value}{unit}: {remedy}"),
        }
    }

    /// `message`, of an engine, in the words of the window: labels in quotation marks in place of keys of several words,
    /// and of the last parts of keys that have an underscore.
    pub fn labelled(&self, message: &(impl ToString + ?Sized)) -> String {
        let text = message.to_string();
        // Several fields of one key are the entries of a list, as in `reduction_deg[0]`.
        let list = |field: &Field| field.key.split('[').next().unwrap_or(field.key).to_owned();
        let label = |word: &str| {
            // A key of one word, such as `opening`, is a word of plain sentences, too.
            if !word.contains(['_', '.', '[']) {
                return None;
            }
            if let Some(place) = find(self.fields(), word, "", "").filter(|place| !place.label.is_empty()) {
                return Some(format!("\"{}\"", place.label));
            }
            let is_meant = |key: &str| key == word || (word.contains('_') && key.rsplit('.').next() == Some(word));
            let meant = self.fields().map(list).find(|key| is_meant(key))?;
            let labels = self.fields().filter(|field| list(field) == meant && !field.label.is_empty());
            let labels: Vec<_> = labels.map(|field| format!("\"{}\"", field.label)).collect();
            (!labels.is_empty()).then(|| labels.join(" or "))
        };
        let is_of_word = |c: char| c.is_ascii_alphanumeric() || "_.[]".contains(c);
        let mut shown = String::new();
        let mut rest = text.as_str();
        while let Some(start) = rest.find(is_of_word) {
            let (before, from) = rest.split_at(start);
            let (run, after) = from.split_at(from.find(|c| !is_of_word(c)).unwrap_or(from.len()));
            let word = run.trim_matches(['.', '[', ']']);
            let [opening, closing] = match word {
                "" => [run, ""],
                _ => [&run[..run.find(word).unwrap_or(0)], &run[run.find(word).unwrap_or(0) + word.len()..]],
            };
            shown.push_str(before);
            shown.push_str(opening);
            shown.push_str(&label(word).unwrap_or_else(|| word.to_owned()));
            shown.push_str(closing);
            rest = after;
        }
        shown + rest
    }

    /// Name of the step from `before` to `now`, for undo.
    pub fn change(&self, before: &P, now: &P) -> String {
        let (before, now) = (self.values(before), self.values(now));
        let differs = |field: &&Field| match field.kind {
            Kind::Variant { tag, .. } => get(get(&before, field.key), tag) != get(get(&now, field.key), tag),
            _ => get(&before, field.key) != get(&now, field.key),
        };
        let mut changed = self.fields().filter(differs);
        let Some(field) = changed.next() else {
            let tables = before.as_object().zip(now.as_object());
            let other = tables.and_then(|(b, n)| n.iter().find(|(key, value)| b.get(*key) != Some(value)));
            return other.map_or_else(String::new, |(key, _)| capital(&words_of(key)));
        };
        // Another variant has other parameters.
        let is_within = |other: &Field| other.key.strip_prefix(field.key).is_some_and(|rest| rest.starts_with('.'));
        if changed.any(|other| !is_within(other)) {
            return "Several parameters".to_owned();
        }
        change_of(field, get(&before, field.key), get(&now, field.key))
    }

    /// The table in Markdown, for the manual.
    pub fn markdown(&self, params: &P) -> String {
        let defaults = self.values(&self.defaults(params));
        let mut out = String::new();
        for group in self.groups {
            let section = if group.section.is_empty() { String::new() } else { format!("{}: ", group.section) };
            let _ = write!(out, "### {section}{}\n\n", group.name);
            out.push_str("| parameter | key | unit | allowed | default | meaning |\n|---|---|---|---|---|---|\n");
            for field in group.fields {
                markdown_row(&mut out, field, "", Some(get(&defaults, field.key)));
            }
            out.push('\n');
        }
        out
    }

    /// Faults of the table, for a test: every key must exist, its default be allowed, every word and every new row be
    /// understood, and values beyond a range be refused by `validate` too.
    pub fn audit(&self, params: &P, validate: impl Fn(&P) -> bool) -> Vec<String> {
        let values = self.values(params);
        let mut faults = Vec::new();
        for field in self.fields() {
            let key = field.key;
            if field.label.is_empty() || field.help.is_empty() {
                faults.push(format!("{key}: without label or help"));
            }
            if let Err(problem) = field.check(key, get(&values, key))
                && field.is_shown(&values)
            {
                faults.push(problem.to_string());
            }
            let counting = self.where_it_counts(field, &values);
            for value in possible(field) {
                if let Err(problem) = self.put(&counting, key, value) {
                    faults.push(problem.to_string());
                }
            }
            if let When::Is(other, _) | When::IsNot(other, _) = field.when
                && self.find(other).is_err()
                && get(&values, other).is_null()
            {
                faults.push(format!("{key}: its condition is on {other}, which is not there"));
            }
        }
        let taken = self.beyond(params).into_iter().filter(|(_, params)| validate(params));
        faults.extend(taken.map(|(key, params)| format!("{key} = {} is taken", get(&self.values(&params), &key))));
        faults
    }

    /// The parameters with each number in turn just beyond its range, with its key: for tests of error messages.
    pub fn beyond(&self, params: &P) -> Vec<(String, P)> {
        let values = self.values(params);
        let mut all = Vec::new();
        for field in self.fields() {
            let counting = self.where_it_counts(field, &values);
            if !field.is_shown(&counting) {
                continue;
            }
            let mut places = vec![(field, field.key.to_owned())];
            if let (Kind::Rows { fields, .. }, Some(rows)) = (field.kind, get(&counting, field.key).as_array()) {
                for (i, row) in rows.iter().enumerate() {
                    let shown = fields.iter().filter(|inner| inner.is_shown(row));
                    places.extend(shown.map(|inner| (inner, format!("{}[{i}].{}", field.key, inner.key))));
                }
            }
            for (field, key) in places {
                let wrong = beyond(field).into_iter().filter_map(|value| self.put(&counting, &key, value).ok());
                all.extend(wrong.map(|params| (key.clone(), params)));
            }
        }
        all
    }

    /// `values` changed so that the condition of `field` holds.
    fn where_it_counts(&self, field: &Field, values: &Value) -> Value {
        let mut values = values.clone();
        if let When::IsNot(key, words) = field.when
            && let Some(Kind::Choice(all)) = self.fields().find(|f| f.key == key).map(|f| f.kind)
            && let Some(other) = all.iter().find(|word| !words.contains(&word.word))
        {
            put(&mut values, key, other.word.into());
        }
        if let When::IsNot(key, _) = field.when
            && let Some(Kind::ChoiceOr(_, other)) = self.fields().find(|f| f.key == key).map(|f| f.kind)
        {
            put(&mut values, key, inline_toml(other));
        }
        if let When::Is(key, [word, ..]) = field.when {
            let variant = self.fields().find_map(|f| match f.kind {
                Kind::Variant { tag, variants } if key == format!("{}.{tag}", f.key) => {
                    Some((f.key, variants.iter().find(|v| v.word.word == *word)?.new))
                }
                _ => None,
            });
            match variant {
                Some((key, new)) => put(&mut values, key, inline_toml(new)),
                None => put(&mut values, key, if *word == "true" { true.into() } else { (*word).into() }),
            };
        }
        values
    }
}

/// Values that a field must accept.
fn possible(field: &Field) -> Vec<Value> {
    match field.kind {
        Kind::Choice(words) | Kind::ChoiceOrFile(words) | Kind::ChoiceOr(words, _) => {
            words.iter().map(|w| w.word.into()).collect()
        }
        Kind::Variant { variants, .. } => variants.iter().map(|v| inline_toml(v.new)).collect(),
        Kind::Rows { new, .. } => vec![Value::from(vec![inline_toml(new)])],
        Kind::Number { instead: Instead::Word(word, start), is_whole, .. } => {
            vec![word.into(), if is_whole { Value::from(start as i64) } else { start.into() }]
        }
        Kind::Number { instead: Instead::Nothing(start), is_whole, .. } => {
            vec![Value::Null, if is_whole { Value::from(start as i64) } else { start.into() }]
        }
        _ => Vec::new(),
    }
}

/// Numbers just beyond the range of a field, or lists with one.
fn beyond(field: &Field) -> Vec<Value> {
    let Some(range) = field.range() else { return Vec::new() };
    let ends = [(range.0, -1.0), (range.1, 1.0)].into_iter().filter(|(end, _)| end.is_finite());
    let value = |(end, side): (f64, f64)| match field.is_whole() {
        true => Value::from((end + side) as i64),
        false => Value::from(end + side * 1e-3 * end.abs().max(0.01)),
    };
    match field.kind {
        Kind::Numbers { count, .. } => ends.map(|end| vec![value(end); count.unwrap_or(1)].into()).collect(),
        Kind::Points { .. } => ends.map(|end| vec![vec![value(end); 3]; 2].into()).collect(),
        _ => ends.map(value).collect(),
    }
}

fn find(fields: impl IntoIterator<Item = &'static Field>, key: &str, prefix: &str, label: &str) -> Option<Place> {
    for field in fields {
        let Some(rest) = key.strip_prefix(field.key) else { continue };
        let (whole, label) = (format!("{prefix}{}", field.key), format!("{label}{}", field.label));
        if rest.is_empty() {
            return Some(Place { field, key: whole, label });
        }
        if let Kind::Rows { fields, .. } = field.kind
            && let Some((row, inner)) = rest.strip_prefix('[').and_then(|rest| rest.split_once("]."))
            && let Ok(row) = row.parse::<u32>()
        {
            let found = find(fields, inner, &format!("{whole}[{row}]."), &format!("{label} {}, ", u64::from(row) + 1));
            if found.is_some() {
                return found;
            }
        }
    }
    None
}

/// The keys of `fields` and of the first row of each list among them, each after `prefix`.
fn keys_of(fields: impl IntoIterator<Item = &'static Field>, prefix: &str) -> Vec<String> {
    let with_rows = |field: &'static Field| {
        let key = format!("{prefix}{}", field.key);
        let rows = if let Kind::Rows { fields, .. } = field.kind {
            keys_of(fields, &format!("{key}[0]."))
        } else {
            Vec::new()
        };
        std::iter::once(key).chain(rows)
    };
    fields.into_iter().flat_map(with_rows).collect()
}

fn change_of(field: &Field, before: &Value, now: &Value) -> String {
    let (Kind::Rows { fields, .. }, Some(before), Some(now)) = (field.kind, before.as_array(), now.as_array()) else {
        return field.label.to_owned();
    };
    match now.len().cmp(&before.len()) {
        std::cmp::Ordering::Greater => return format!("{}: row added", field.label),
        std::cmp::Ordering::Less => return format!("{}: row removed", field.label),
        std::cmp::Ordering::Equal => {}
    }
    let mut differing = now.iter().zip(before).enumerate().filter(|(_, (now, before))| now != before);
    let (Some((i, (now, before))), None) = (differing.next(), differing.next()) else {
        return field.label.to_owned();
    };
    let inner = fields.iter().find(|f| get(now, f.key) != get(before, f.key));
    let inner = inner.map_or_else(String::new, |f| format!(", {}", change_of(f, get(before, f.key), get(now, f.key))));
    format!("{} {}{inner}", field.label, i + 1)
}

fn markdown_row(out: &mut String, field: &Field, prefix: &str, default: Option<&Value>) {
    let cell = |text: &str| text.replace('|', "\\|").replace('\n', " ");
    let key = format!("{prefix}{}", field.key);
    let default = default.map_or_else(String::new, |value| field.show(value));
    let symbol = if field.symbol.is_empty() { String::new() } else { format!(" ({})", field.symbol) };
    let cells = [
        format!("{}{symbol}", field.label),
        format!("`{key}`"),
        field.unit.to_owned(),
        field.allowed().unwrap_or_default(),
        default,
        field.help.to_owned(),
    ];
    let cells: Vec<String> = cells.iter().map(|text| cell(text)).collect();
    let _ = writeln!(out, "| {} |", cells.join(" | "));
    if let Kind::Rows { fields, .. } = field.kind {
        fields.iter().for_each(|inner| markdown_row(out, inner, &format!("{key}[N]."), None));
    }
}

/// The words in the last name of a key, without its unit: for windows, which show no keys, where no field has the key.
fn words_of(key: &str) -> String {
    let name = steps(key).filter(|step| step.parse::<u32>().is_err()).last().unwrap_or_default();
    named_unit(name).0.replace('_', " ")
}

/// A name without the unit at its end, and the unit; empty if the name has none.
pub(super) fn named_unit(name: &str) -> (&str, &'static str) {
    const UNITS: [(&str, &str); 7] = [
        ("_mm_per_min", "mm/min"),
        ("_mm2", "mm\u{b2}"),
        ("_mm3", "mm\u{b3}"),
        ("_mm", "mm"),
        ("_deg", "deg"),
        ("_min", "min"),
        ("_s", "s"),
    ];
    UNITS.iter().find_map(|(end, unit)| Some((name.strip_suffix(end)?, *unit))).unwrap_or((name, ""))
}

pub(super) fn capital(words: &str) -> String {
    let mut letters = words.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

pub(super) fn text_of(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
