//! Description of a parameter for forms, command line, files and reports.
//!
//! A [`Field`] names its parameter by a key path such as `electrode.holder_mm[0]` into the JSON form of a parameter
//! struct, as serde writes it. An `Option` that is `None` is null there.

pub mod listing;
pub mod table;
pub mod text;

use serde_json::Value;

use crate::Invalid;
use crate::error::allowed;

/// A parameter. Constructors set its kind, further methods its properties:
///
/// ```
/// # use files::Field;
/// const STEP: Field = Field::number("plan.step_mm", "Step", "mm", 0.01, 10.0)
///     .symbol("k")
///     .decimals(2)
///     .help("Distance between nodes along X.");
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Field {
    /// Key of the field: its place in the parameters.
    pub key: &'static str,
    /// Name for a reader.
    pub label: &'static str,
    /// Symbol of the field in the papers; may be empty.
    pub symbol: &'static str,
    /// Unit; may be empty.
    pub unit: &'static str,
    /// Kind of its values.
    pub kind: Kind,
    /// Condition under which the parameter counts.
    pub when: When,
    /// Help text: the effect of the field.
    pub help: &'static str,
}

/// Kind of values of a parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// A number.
    Number {
        /// Allowed values.
        range: Range,
        /// Whether only whole numbers are allowed.
        is_whole: bool,
        /// Decimals shown.
        decimals: usize,
        /// Change per point of dragging; 0 to derive it from the decimals.
        step: f64,
        /// The range of its slider, if it has one.
        slider: Option<Range>,
        /// Value that may stand in place of a number.
        instead: Instead,
    },
    /// A list of numbers.
    Numbers {
        /// Allowed range of each number.
        range: Range,
        /// Whether only whole numbers are allowed.
        is_whole: bool,
        /// Length of the list; any length if none.
        count: Option<usize>,
        /// Whether there may be no list.
        is_optional: bool,
    },
    /// A list of points of three coordinates each.
    Points {
        /// Allowed range of each coordinate.
        range: Range,
    },
    /// A direction: along an axis, or three components.
    Direction,
    /// Yes or no.
    Flag,
    /// A text; no value is an empty one.
    Text,
    /// The path of a file, or none.
    File,
    /// A choice among words; no value is the empty word.
    Choice(&'static [Word]),
    /// A choice among words, or the path of a file.
    ChoiceOrFile(&'static [Word]),
    /// A choice among words, or a value of another form, which the struct itself checks.
    ChoiceOr(&'static [Word], &'static str),
    /// A choice among tables, told apart by the word under `tag`.
    Variant {
        /// Key of the word in the table.
        tag: &'static str,
        /// The tables.
        variants: &'static [Variant],
    },
    /// A list of tables of one kind.
    Rows {
        /// The columns; their keys are relative to a row.
        fields: &'static [Field],
        /// A new row, as an inline table of TOML.
        new: &'static str,
        /// Whether a new row is put first.
        is_first: bool,
    },
}

/// Alternative to a number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Instead {
    /// Always a number.
    Never,
    /// The word, as `"auto"`; a number starts with this value.
    Word(&'static str, f64),
    /// No value; a number starts with this value.
    Nothing(f64),
}

/// A word to choose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Word {
    /// Word in files and on the command line.
    pub word: &'static str,
    /// Label in windows and reports.
    pub label: &'static str,
    /// Help text: the meaning of the word; may be empty.
    pub help: &'static str,
}

/// A word to choose.
pub const fn word(word: &'static str, label: &'static str, help: &'static str) -> Word {
    Word { word, label, help }
}

/// A table to choose among several.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Variant {
    /// Word under the tag.
    pub word: Word,
    /// Content of a new variant, as an inline table of TOML with its word.
    pub new: &'static str,
}

/// Least and greatest value, each of which may be infinite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range(pub f64, pub f64);

impl Range {
    /// Whether `value` lies within.
    pub fn contains(self, value: f64) -> bool {
        value.is_finite() && (self.0..=self.1).contains(&value)
    }
}

/// Condition under which a parameter counts and is shown. Keys are those of the table of the field: all parameters, or
/// a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum When {
    /// Always.
    Always,
    /// If the value under the key is one of these words; no value is the empty word.
    Is(&'static str, &'static [&'static str]),
    /// If the value under the key is none of these words.
    IsNot(&'static str, &'static [&'static str]),
}

impl Field {
    const fn of(key: &'static str, label: &'static str, kind: Kind) -> Self {
        Self { key, label, symbol: "", unit: "", kind, when: When::Always, help: "" }
    }

    /// A number from `least` to `greatest`.
    pub const fn number(key: &'static str, label: &'static str, unit: &'static str, least: f64, greatest: f64) -> Self {
        let range = Range(least, greatest);
        let (slider, instead) = (None, Instead::Never);
        let kind = Kind::Number { range, is_whole: false, decimals: 3, step: 0.0, slider, instead };
        Self { unit, ..Self::of(key, label, kind) }
    }

    /// A whole number from `least` to `greatest`.
    pub const fn integer(key: &'static str, label: &'static str, least: f64, greatest: f64) -> Self {
        let range = Range(least, greatest);
        let (slider, instead) = (None, Instead::Never);
        Self::of(key, label, Kind::Number { range, is_whole: true, decimals: 0, step: 0.2, slider, instead })
    }

    /// Numbers from `least` to `greatest`, as many as there are.
    pub const fn numbers(
        key: &'static str,
        label: &'static str,
        unit: &'static str,
        least: f64,
        greatest: f64,
    ) -> Self {
        let kind = Kind::Numbers { range: Range(least, greatest), is_whole: false, count: None, is_optional: false };
        Self { unit, ..Self::of(key, label, kind) }
    }

    /// Points with coordinates from `least` to `greatest`, as many as there are.
    pub const fn points(key: &'static str, label: &'static str, unit: &'static str, least: f64, greatest: f64) -> Self {
        Self { unit, ..Self::of(key, label, Kind::Points { range: Range(least, greatest) }) }
    }

    /// A direction.
    pub const fn direction(key: &'static str, label: &'static str) -> Self {
        Self::of(key, label, Kind::Direction)
    }

    /// Yes or no.
    pub const fn flag(key: &'static str, label: &'static str) -> Self {
        Self::of(key, label, Kind::Flag)
    }

    /// A text.
    pub const fn text(key: &'static str, label: &'static str) -> Self {
        Self::of(key, label, Kind::Text)
    }

    /// A file, or none.
    pub const fn file(key: &'static str, label: &'static str) -> Self {
        Self::of(key, label, Kind::File)
    }

    /// A choice among `words`.
    pub const fn choice(key: &'static str, label: &'static str, words: &'static [Word]) -> Self {
        Self::of(key, label, Kind::Choice(words))
    }

    /// A choice among `words`, or a file.
    pub const fn choice_or_file(key: &'static str, label: &'static str, words: &'static [Word]) -> Self {
        Self::of(key, label, Kind::ChoiceOrFile(words))
    }

    /// A choice among `words`, or a value of the form that `other` describes, as `numbers like 0,1,2`.
    pub const fn choice_or(
        key: &'static str,
        label: &'static str,
        words: &'static [Word],
        other: &'static str,
    ) -> Self {
        Self::of(key, label, Kind::ChoiceOr(words, other))
    }

    /// A choice among `variants`, told apart by the word under `tag`.
    pub const fn variant(
        key: &'static str,
        label: &'static str,
        tag: &'static str,
        variants: &'static [Variant],
    ) -> Self {
        Self::of(key, label, Kind::Variant { tag, variants })
    }

    /// Rows of `fields`. A new row has the content of the inline table `new`.
    pub const fn rows(key: &'static str, label: &'static str, fields: &'static [Self], new: &'static str) -> Self {
        Self::of(key, label, Kind::Rows { fields, new, is_first: false })
    }

    /// Sets the symbol in the papers.
    #[must_use]
    pub const fn symbol(self, symbol: &'static str) -> Self {
        Self { symbol, ..self }
    }

    /// Sets the help text: a sentence on the effect of the parameter.
    #[must_use]
    pub const fn help(self, help: &'static str) -> Self {
        Self { help, ..self }
    }

    /// Sets the condition under which the parameter counts.
    #[must_use]
    pub const fn when(self, when: When) -> Self {
        Self { when, ..self }
    }

    /// Sets the number of decimals shown.
    #[must_use]
    pub const fn decimals(mut self, places: usize) -> Self {
        if let Kind::Number { decimals, .. } = &mut self.kind {
            *decimals = places;
        }
        self
    }

    /// Sets the change per point of dragging, in the unit of the number.
    #[must_use]
    pub const fn step(mut self, by: f64) -> Self {
        if let Kind::Number { step, .. } = &mut self.kind {
            *step = by;
        }
        self
    }

    /// Adds a slider from `least` to `greatest`.
    #[must_use]
    pub const fn slider(mut self, least: f64, greatest: f64) -> Self {
        if let Kind::Number { slider, .. } = &mut self.kind {
            *slider = Some(Range(least, greatest));
        }
        self
    }

    /// Allows `word` in place of a number; a number starts with `start`.
    #[must_use]
    pub const fn or_word(mut self, word: &'static str, start: f64) -> Self {
        if let Kind::Number { instead, .. } = &mut self.kind {
            *instead = Instead::Word(word, start);
        }
        self
    }

    /// Allows no value; a number starts with `start`.
    #[must_use]
    pub const fn or_nothing(mut self, start: f64) -> Self {
        if let Kind::Number { instead, .. } = &mut self.kind {
            *instead = Instead::Nothing(start);
        }
        self
    }

    /// Sets the length of the list.
    #[must_use]
    pub const fn count(mut self, number: usize) -> Self {
        if let Kind::Numbers { count, .. } = &mut self.kind {
            *count = Some(number);
        }
        self
    }

    /// Allows no list of numbers.
    #[must_use]
    pub const fn optional(mut self) -> Self {
        if let Kind::Numbers { is_optional, .. } = &mut self.kind {
            *is_optional = true;
        }
        self
    }

    /// Puts new rows first.
    #[must_use]
    pub const fn first(mut self) -> Self {
        if let Kind::Rows { is_first, .. } = &mut self.kind {
            *is_first = true;
        }
        self
    }

    /// Allows whole numbers only.
    #[must_use]
    pub const fn whole(mut self) -> Self {
        if let Kind::Numbers { is_whole, .. } = &mut self.kind {
            *is_whole = true;
        }
        self
    }

    /// Whether the parameter is a whole number or a list of them.
    pub fn is_whole(&self) -> bool {
        matches!(self.kind, Kind::Number { is_whole: true, .. } | Kind::Numbers { is_whole: true, .. })
    }

    /// Change of a number per point of dragging.
    pub fn drag_step(&self) -> f64 {
        match self.kind {
            Kind::Number { step, .. } if step > 0.0 => step,
            Kind::Number { decimals, .. } => 5.0 * 10f64.powi(-(decimals as i32)),
            _ => 1.0,
        }
    }

    /// Allowed range of a number or a list of numbers.
    pub fn range(&self) -> Option<Range> {
        match self.kind {
            Kind::Number { range, .. } | Kind::Numbers { range, .. } | Kind::Points { range } => Some(range),
            _ => None,
        }
    }

    /// Allowed values in words; none if anything is allowed.
    pub fn allowed(&self) -> Option<String> {
        let whole = |is_whole: bool, text: String| if is_whole { format!("{text}, a whole number") } else { text };
        let words = |words: &[Word]| words.iter().map(|w| w.word).collect::<Vec<_>>().join(", ");
        match self.kind {
            Kind::Number { range, is_whole, instead, .. } => {
                let number = whole(is_whole, allowed([range.0, range.1], self.unit));
                Some(match instead {
                    Instead::Never => number,
                    Instead::Word(word, _) => format!("{number}, or {word}"),
                    Instead::Nothing(_) => format!("{number}, or none"),
                })
            }
            Kind::Numbers { range, is_whole, count, .. } => {
                let each = whole(is_whole, allowed([range.0, range.1], self.unit));
                let count = count.map_or_else(|| "numbers".to_owned(), |n| format!("{n} numbers"));
                Some(format!("{count} with commas between, each of which {each}"))
            }
            Kind::Points { range } => Some(format!(
                "must be points of three coordinates like 1, 2, 3; 4, 5, 6, each of which {}",
                allowed([range.0, range.1], self.unit)
            )),
            Kind::Choice(all) => Some(format!("must be one of {}", words(all))),
            Kind::ChoiceOrFile(all) => Some(format!("must be one of {}, or the path of a file", words(all))),
            Kind::ChoiceOr(all, other) => Some(format!("must be one of {}, or {other}", words(all))),
            Kind::Variant { variants, .. } => {
                let words: Vec<&str> = variants.iter().map(|v| v.word.word).collect();
                Some(format!("must be one of {}", words.join(", ")))
            }
            Kind::Direction => Some("must be +x, -x, +y, -y, +z, -z, or three numbers with commas between".to_owned()),
            Kind::Flag => Some("must be true or false".to_owned()),
            Kind::Rows { .. } => Some("must be a list of tables".to_owned()),
            Kind::Text | Kind::File => None,
        }
    }

    /// Whether the parameter counts with `values`, those of its table or row.
    pub fn is_shown(&self, values: &Value) -> bool {
        let has = |key: &str, words: &[&str]| words.contains(&plain(get(values, key)).as_str());
        match self.when {
            When::Always => true,
            When::Is(key, words) => has(key, words),
            When::IsNot(key, words) => !has(key, words),
        }
    }

    /// Checks that `value` is allowed; errors name it `key`.
    ///
    /// # Errors
    /// What is allowed.
    pub fn check(&self, key: &str, value: &Value) -> Result<(), Invalid> {
        let is_number = |value: &Value, range: Range, is_whole: bool| {
            value.as_f64().is_some_and(|n| range.contains(n) && (!is_whole || n.fract() == 0.0))
        };
        let text = value.as_str();
        let holds = match self.kind {
            Kind::Number { range, is_whole, instead, .. } => match instead {
                Instead::Word(word, _) if text == Some(word) => true,
                Instead::Nothing(_) if value.is_null() => true,
                _ => is_number(value, range, is_whole),
            },
            Kind::Numbers { is_optional: true, .. } if value.is_null() => true,
            Kind::Numbers { range, is_whole, count, .. } => value.as_array().is_some_and(|all| {
                count.is_none_or(|count| all.len() == count) && all.iter().all(|v| is_number(v, range, is_whole))
            }),
            Kind::Points { range } => value.as_array().is_some_and(|all| {
                let is_point = |p: &Value| text::parts(p).is_some_and(|parts| parts.iter().all(|c| range.contains(*c)));
                all.iter().all(is_point)
            }),
            Kind::Choice(words) => words.iter().any(|w| Some(w.word) == text.or(value.is_null().then_some(""))),
            Kind::Variant { tag, variants } => variants.iter().any(|v| Some(v.word.word) == get(value, tag).as_str()),
            Kind::Direction => text::parts(value).is_some_and(|parts| parts.iter().any(|part| *part != 0.0)),
            Kind::Flag => value.is_boolean(),
            Kind::Text => value.is_string() || value.is_null(),
            Kind::ChoiceOrFile(_) => value.is_string(),
            Kind::ChoiceOr(..) => !value.is_null(),
            Kind::File => value.is_string() || value.is_null(),
            // An empty list may be left out.
            Kind::Rows { .. } if value.is_null() => true,
            Kind::Rows { fields, .. } => {
                let Some(rows) = value.as_array() else { return Err(self.refused(key, value)) };
                for (i, row) in rows.iter().enumerate() {
                    for field in fields.iter().filter(|field| field.is_shown(row)) {
                        field.check(&format!("{key}[{i}].{}", field.key), get(row, field.key))?;
                    }
                }
                true
            }
        };
        if holds { Ok(()) } else { Err(self.refused(key, value)) }
    }

    fn refused(&self, key: &str, value: &Value) -> Invalid {
        // What is no number has no form in JSON.
        let is_nan = value.is_null() && matches!(self.kind, Kind::Number { .. });
        let shown = if is_nan { "NaN".to_owned() } else { self.show(value) };
        Invalid::new(key, shown, self.allowed().unwrap_or_else(|| "must be a text".to_owned()))
    }
}

/// The names and numbers in a key path: `a.b[0].c` has four.
pub(crate) fn steps(key: &str) -> impl Iterator<Item = &str> {
    key.split(['.', '[', ']']).filter(|step| !step.is_empty())
}

/// The value under `key`; null if there is none.
pub fn get<'a>(values: &'a Value, key: &str) -> &'a Value {
    let step = |here: &'a Value, step: &str| match here {
        Value::Array(list) => list.get(step.parse::<usize>().ok()?),
        other => other.get(step),
    };
    steps(key).try_fold(values, step).unwrap_or(&Value::Null)
}

/// Puts `value` under `key`, whose table must exist; an optional table begins empty. Returns whether the value is
/// there.
pub fn put(values: &mut Value, key: &str, value: Value) -> bool {
    let all: Vec<&str> = steps(key).collect();
    let Some((last, path)) = all.split_last() else { return false };
    let mut here = values;
    for step in path {
        if here.is_null() {
            *here = Value::Object(serde_json::Map::new());
        }
        let next = match here {
            Value::Array(list) => step.parse::<usize>().ok().and_then(|i| list.get_mut(i)),
            other => other.get_mut(*step),
        };
        let Some(next) = next else { return false };
        here = next;
    }
    if here.is_null() {
        *here = Value::Object(serde_json::Map::new());
    }
    match here {
        Value::Array(list) => match last.parse::<usize>().ok().and_then(|i| list.get_mut(i)) {
            Some(place) => *place = value,
            None => return false,
        },
        Value::Object(table) => drop(table.insert((*last).to_owned(), value)),
        _ => return false,
    }
    true
}

/// A value as plain text.
fn plain(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}
