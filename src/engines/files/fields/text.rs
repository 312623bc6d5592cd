//! Values as text, as users type and read them.

use serde_json::Value;

use super::{Field, Instead, Kind, get, plain};
use crate::Invalid;

impl Field {
    /// `value` as a text that [`parse`](Self::parse) reads.
    pub fn show(&self, value: &Value) -> String {
        match (self.kind, value) {
            (
                Kind::Number { instead: Instead::Nothing(_), .. }
                | Kind::Numbers { is_optional: true, .. }
                | Kind::File,
                Value::Null,
            ) => "none".to_owned(),
            (Kind::Variant { tag, .. }, Value::Object(_)) => plain(get(value, tag)),
            (Kind::Direction, value) => direction_words(value).to_lowercase().replace('\u{2212}', "-"),
            (Kind::Numbers { .. }, Value::Array(all)) => joined(all),
            (Kind::Points { .. }, Value::Array(all)) => {
                let point = |p: &Value| p.as_array().map_or_else(String::new, |p| joined(p));
                all.iter().map(point).collect::<Vec<_>>().join("; ")
            }
            (Kind::Rows { .. } | Kind::ChoiceOr(..), Value::Array(_) | Value::Object(_)) => {
                match toml::Value::try_from(without_nulls(value.clone())) {
                    Ok(rows) => rows.to_string(),
                    Err(_) => value.to_string(),
                }
            }
            _ => number(value),
        }
    }

    /// `value` for a reader: words by their labels.
    pub fn show_label(&self, value: &Value) -> String {
        if self.kind == Kind::Direction {
            return direction_words(value);
        }
        let text = self.show(value);
        let found = match self.kind {
            Kind::Choice(words) | Kind::ChoiceOrFile(words) | Kind::ChoiceOr(words, _) => {
                words.iter().find(|w| w.word == text).map(|w| w.label)
            }
            Kind::Variant { variants, .. } => variants.iter().find(|v| v.word.word == text).map(|v| v.word.label),
            Kind::Flag => Some(if value.as_bool() == Some(true) { "yes" } else { "no" }),
            _ => None,
        };
        found.map_or(text, str::to_owned)
    }

    /// The value of `text`; errors name it `key`.
    ///
    /// # Errors
    /// The allowed values, if `text` is not allowed.
    pub fn parse(&self, key: &str, text: &str) -> Result<Value, Invalid> {
        let text = text.trim();
        let wrong = || {
            let allowed = self.allowed().unwrap_or_else(|| "must be a text".to_owned());
            Invalid::new(key, if text.is_empty() { "empty" } else { text }, allowed)
        };
        let value = match self.kind {
            Kind::Number { instead: Instead::Word(word, _), .. } if text == word => word.into(),
            Kind::Number { instead: Instead::Nothing(_), .. }
            | Kind::Numbers { is_optional: true, .. }
            | Kind::File
                if matches!(text, "" | "none") =>
            {
                Value::Null
            }
            Kind::Number { is_whole, .. } => read_number(text, is_whole).ok_or_else(wrong)?,
            Kind::Numbers { is_whole, .. } => read_numbers(text, is_whole).ok_or_else(wrong)?,
            Kind::Points { .. } => read_points(text).ok_or_else(wrong)?,
            Kind::Direction => read_direction(text).ok_or_else(wrong)?,
            Kind::Flag => match text {
                "true" | "yes" | "on" => true.into(),
                "false" | "no" | "off" => false.into(),
                _ => return Err(wrong()),
            },
            Kind::Text | Kind::File | Kind::Choice(_) | Kind::ChoiceOrFile(_) => text.into(),
            Kind::ChoiceOr(..) if text.is_empty() => return Err(wrong()),
            // What is no value of TOML is a word.
            Kind::ChoiceOr(..) => {
                read_toml(text).filter(|v| v.is_object() || v.is_array()).unwrap_or_else(|| text.into())
            }
            Kind::Variant { variants, .. } => {
                let found = variants.iter().find(|v| v.word.word == text).ok_or_else(wrong)?;
                read_toml(found.new).ok_or_else(wrong)?
            }
            Kind::Rows { .. } => read_toml(text).ok_or_else(wrong)?,
        };
        // Rows may leave out what has a default.
        if !matches!(self.kind, Kind::Rows { .. }) {
            self.check(key, &value)?;
        }
        Ok(value)
    }
}

fn joined(numbers: &[Value]) -> String {
    numbers.iter().map(number).collect::<Vec<_>>().join(", ")
}

/// A number without a useless `.0`; other values unchanged.
fn number(value: &Value) -> String {
    let text = plain(value);
    match value {
        Value::Number(_) => text.strip_suffix(".0").map_or(text.clone(), str::to_owned),
        _ => text,
    }
}

/// A typed number, with a decimal point or comma, and a hyphen or a real minus sign.
pub(crate) fn read_number(text: &str, is_whole: bool) -> Option<Value> {
    let plain: String = text.chars().filter(|c| !c.is_whitespace()).collect();
    let plain = plain.replace(',', ".").replace('\u{2212}', "-");
    if let Ok(whole) = plain.parse::<u64>() {
        return Some(if is_whole { whole.into() } else { (whole as f64).into() });
    }
    if let Ok(whole) = plain.parse::<i64>() {
        return Some(if is_whole { whole.into() } else { (whole as f64).into() });
    }
    let number = plain.parse::<f64>().ok().filter(|n| n.is_finite())?;
    match is_whole {
        true if number.fract() == 0.0 && number.abs() < 9e15 => Some((number as i64).into()),
        true => None,
        false => Some(number.into()),
    }
}

/// The value of inline TOML in a field table; null if it is wrong, which the table's test finds.
pub fn inline_toml(text: &str) -> Value {
    read_toml(text).unwrap_or_default()
}

/// Numbers separated by commas, blanks or `x`. If there are semicolons, these separate and commas are decimal.
fn read_numbers(text: &str, is_whole: bool) -> Option<Value> {
    let inner = text.strip_prefix('[').and_then(|t| t.strip_suffix(']')).unwrap_or(text);
    let has_semicolon = inner.contains(';');
    let is_between = |c: char| match has_semicolon {
        true => c == ';',
        false => c == ',' || c == 'x' || c == '\u{d7}' || c.is_whitespace(),
    };
    let words = inner.split(is_between).map(str::trim).filter(|word| !word.is_empty());
    words.map(|word| read_number(word, is_whole)).collect::<Option<Vec<_>>>().map(Value::from)
}

/// Points with semicolons or new lines between, their coordinates with commas or blanks; or lists of numbers in brackets.
fn read_points(text: &str) -> Option<Value> {
    if text.starts_with('[') {
        return read_toml(text).filter(Value::is_array);
    }
    let points = text.split([';', '\n']).map(str::trim).filter(|point| !point.is_empty());
    let coordinates = |point: &str| read_numbers(point, false);
    points.map(coordinates).collect::<Option<Vec<_>>>().map(Value::from)
}

/// Axes with their names.
const AXES: [(&str, [f64; 3]); 6] = [
    ("+Z", [0.0, 0.0, 1.0]),
    ("\u{2212}Z", [0.0, 0.0, -1.0]),
    ("+X", [1.0, 0.0, 0.0]),
    ("\u{2212}X", [-1.0, 0.0, 0.0]),
    ("+Y", [0.0, 1.0, 0.0]),
    ("\u{2212}Y", [0.0, -1.0, 0.0]),
];

/// Names of the directions along axes, as windows show them.
pub const AXIS_NAMES: [&str; 6] = [AXES[0].0, AXES[1].0, AXES[2].0, AXES[3].0, AXES[4].0, AXES[5].0];

/// The three components of a direction; none if there are not three numbers.
pub(super) fn parts(value: &Value) -> Option<[f64; 3]> {
    let all: Vec<f64> = value.as_array()?.iter().filter_map(Value::as_f64).filter(|part| part.is_finite()).collect();
    all.try_into().ok()
}

/// Name of a direction: that of its axis, or its three components.
pub fn direction_words(value: &Value) -> String {
    const HAIR: f64 = 1e-6;
    let Some(parts) = parts(value) else { return String::new() };
    let length = parts.iter().map(|part| part * part).sum::<f64>().sqrt();
    let is_along =
        |axis: &[f64; 3]| axis.iter().zip(&parts).all(|(a, part)| (a * length - part).abs() <= HAIR * length);
    match AXES.iter().find(|(_, axis)| length > 0.0 && is_along(axis)) {
        Some((name, _)) => (*name).to_owned(),
        None => parts.map(|part| number(&part.into())).join(", "),
    }
}

/// Reads a letter with its sign, or three numbers.
fn read_direction(text: &str) -> Option<Value> {
    let upper = text.to_uppercase().replace('-', "\u{2212}");
    let signed = if upper.len() == 1 { format!("+{upper}") } else { upper };
    match AXES.iter().find(|(name, _)| *name == signed) {
        Some((_, axis)) => serde_json::to_value(axis).ok(),
        None => read_numbers(text, false),
    }
}

/// An inline value of TOML.
pub(super) fn read_toml(text: &str) -> Option<Value> {
    let mut table: toml::Table = toml::from_str(&format!("value = {text}")).ok()?;
    if table.len() != 1 {
        return None;
    }
    serde_json::to_value(table.remove("value")?).ok()
}

/// TOML has no null: what is not there is left out.
fn without_nulls(value: Value) -> Value {
    match value {
        Value::Object(table) => {
            table.into_iter().filter(|(_, v)| !v.is_null()).map(|(key, v)| (key, without_nulls(v))).collect()
        }
        Value::Array(list) => list.into_iter().map(without_nulls).collect(),
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_typed_shown_and_refused() {
        const FIELD: Field = Field::points("picked_mm", "Picked", "mm", -10.0, 10.0);
        let parse = |text: &str| FIELD.parse("picked_mm", text);
        let two = serde_json::json!([[1.0, -2.5, 3.0], [4.0, 5.0, 6.0]]);
        for text in ["1, -2.5, 3; 4, 5, 6", "[[1.0, -2.5, 3.0], [4.0, 5.0, 6.0]]", "1 -2.5 3\n4 5 6;"] {
            assert_eq!(parse(text).unwrap(), two, "{text}");
        }
        assert_eq!(FIELD.show(&two), "1, -2.5, 3; 4, 5, 6");
        assert_eq!(parse("").unwrap(), serde_json::json!([]));
        for wrong in ["1, 2", "1, 2, 3; 4, 5", "1, 2, 11", "1, 2, three", "[1, 2, 3]"] {
            let message = parse(wrong).unwrap_err().to_string();
            assert!(message.contains("points of three coordinates"), "{wrong}: {message}");
        }
    }
}
