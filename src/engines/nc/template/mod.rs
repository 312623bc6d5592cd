//! Text of any form for people and machines, through templates that users edit: burn sheets and job sheets.
//!
//! Templates are in the language of Jinja; they see the keys of the JSON file of the same data. A name that the data do not have,
//! and a value that is none where it is written, is an error and no gap in the text, because machines read such sheets too. Beside
//! the filters of the language there are
//! - `fixed(decimals, point=".", plus=false)`: a number with so many decimals, `-` where there is none;
//! - `left(width)` and `right(width)`: text filled up with blanks;
//! - `mapped(values, default)`: what a map holds for the value, as in `kind|mapped({"sink": 1, "feed": 2})`; without a default
//!   a value that the map does not hold is an error;
//! - `required(name)`: the value; an error if there is none.
//!
//! All values that are missing are told together.

use std::marker::PhantomData;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError, mpsc};
use std::time::Duration;

use files::{FileError, read_text};
use minijinja::syntax::SyntaxConfig;
use minijinja::value::{Kwargs, Rest, Serde, Value, ValueOrKwargs};
use minijinja::{AutoEscape, Environment, Error, ErrorKind, State, UndefinedBehavior, filters};
use serde::Serialize;

use super::burn_table::BurnTable;
use super::job_file::JobFile;

/// Data that templates make text of.
pub trait Templated: Serialize + Sized + 'static {
    /// Name of the JSON file with the same keys.
    const FILE: &'static str;
    /// Name of the text, in words.
    const SHEET: &'static str;
    /// The template that the program brings along.
    const STANDARD: &'static str;

    /// Data with all that a template may meet: one where everything is there, and one that lacks what may be missing.
    fn examples() -> Vec<Self>;
}

/// A template of a burn sheet.
pub type BurnSheet = Template<BurnTable>;
/// A template of a job sheet.
pub type JobSheet = Template<JobFile>;

/// Name of the built-in template.
pub const STANDARD: &str = "standard";
/// The largest template that is read (bytes).
const LARGEST_FILE: u64 = 1 << 20;
/// Steps that a template may take: enough for thousands of electrodes, and little enough to come to an end.
const MOST_STEPS: u64 = 50_000_000;
/// Time within which a text has to be made; usual ones take milliseconds.
const LONGEST: Duration = Duration::from_secs(10);
/// The widest column, and the most decimals.
const WIDEST: usize = 1000;
const MOST_DECIMALS: usize = 12;
/// The most missing values that are named.
const MOST_NAMED: usize = 20;

/// Reason why a template makes no text.
#[derive(Debug, thiserror::Error)]
pub enum TemplateError {
    /// File cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// File holds nothing.
    #[error("{template}: it is empty; choose another file")]
    Empty {
        /// The file.
        template: String,
    },
    /// Something in it is wrong.
    #[error("{template}: {}{problem}; {remedy}", line.map_or(String::new(), |n| format!("line {n}: ")))]
    Wrong {
        /// The template.
        template: String,
        /// Where, counted from 1.
        line: Option<usize>,
        /// Problem.
        problem: String,
        /// Remedy.
        remedy: String,
    },
    /// The data lack values that it requires.
    #[error("{template}: required values are missing: {}; enter them, or change the template", named(missing))]
    Missing {
        /// The template.
        template: String,
        /// Names of the values, each once, in the order of the text.
        missing: Vec<String>,
    },
}

/// The first of many names, and how many more there are.
fn named(missing: &[String]) -> String {
    let more = missing.len().saturating_sub(MOST_NAMED);
    let shown = missing[..missing.len() - more].join(", ");
    if more == 0 { shown } else { format!("{shown} and {more} more") }
}

/// A template that makes text of a `T`.
#[derive(Debug)]
pub struct Template<T> {
    /// Name of the template in errors.
    name: String,
    text: String,
    of: PhantomData<fn(&T)>,
}

impl<T> Clone for Template<T> {
    fn clone(&self) -> Self {
        Self { name: self.name.clone(), text: self.text.clone(), of: PhantomData }
    }
}

impl<T: Templated> Template<T> {
    /// The built-in template.
    pub fn standard() -> Self {
        Self::new(format!("the built-in {}", T::SHEET), T::STANDARD.to_owned())
    }

    /// The template that is called `name`: [`STANDARD`], or that in a file.
    ///
    /// # Errors
    /// As of [`read`](Self::read).
    pub fn named(name: &str) -> Result<Self, TemplateError> {
        if name == STANDARD { Ok(Self::standard()) } else { Self::read(Path::new(name)) }
    }

    fn new(name: String, text: String) -> Self {
        Self { name, text, of: PhantomData }
    }

    /// Name of the template: the built-in name, or its file.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The template in `file`, tried on examples of all that the data may hold: electrodes take their time, and what is
    /// wrong with their sheet should be known before.
    ///
    /// # Errors
    /// [`TemplateError`] with the line.
    pub fn read(file: &Path) -> Result<Self, TemplateError> {
        let text = read_text(file, "template", LARGEST_FILE)?;
        let template = file.display().to_string();
        if text.trim().is_empty() {
            return Err(TemplateError::Empty { template });
        }
        let sheet = Self::new(template, text);
        for example in T::examples() {
            match sheet.of(&example) {
                // Values that an example lacks, the data may have.
                Ok(_) | Err(TemplateError::Missing { .. }) => {}
                Err(error) => return Err(error),
            }
        }
        Ok(sheet)
    }

    /// The text that it makes of `data`.
    ///
    /// # Errors
    /// [`TemplateError::Wrong`] with the line, [`TemplateError::Missing`] with the names.
    pub fn of(&self, data: &T) -> Result<String, TemplateError> {
        self.within(LONGEST, MOST_STEPS, data)
    }

    /// The text, made beside this thread: steps do not tell how long a text gets that doubles itself in each of them. What goes on
    /// after its time is left to end with the program.
    fn within(&self, longest: Duration, steps: u64, data: &T) -> Result<String, TemplateError> {
        let (sheet, data) = (self.clone(), Value::from(Serde(data)));
        let (tell, told) = mpsc::channel();
        // Nobody may be waiting any more.
        std::thread::spawn(move || drop(tell.send(sheet.render(steps, &data))));
        told.recv_timeout(longest).unwrap_or_else(|_| {
            Err(TemplateError::Wrong {
                template: self.name.clone(),
                line: None,
                problem: format!("it takes longer than {} s", longest.as_secs()),
                remedy: "does it make ever longer texts in a loop?".to_owned(),
            })
        })
    }

    fn render(&self, steps: u64, data: &Value) -> Result<String, TemplateError> {
        let wrong = |error: Error| explained(&error, &self.text, &self.name, T::FILE);
        let missing = Missing::default();
        let mut environment = Environment::new();
        let mut syntax = SyntaxConfig::builder();
        // Lines that hold only a statement leave nothing in the text.
        syntax.trim_blocks(true).lstrip_blocks(true).keep_trailing_newline(true);
        environment.set_syntax(syntax.build().map_err(wrong)?);
        environment.set_auto_escape_callback(|_| AutoEscape::None);
        environment.set_undefined_behavior(UndefinedBehavior::Strict);
        environment.set_fuel(Some(steps));
        // What was undefined is named in errors only so.
        environment.set_debug(true);
        environment.add_filter("fixed", fixed);
        environment.add_filter("left", |text: String, width: usize| {
            within(width, WIDEST).map(|width| format!("{text:<width$}"))
        });
        environment.add_filter("right", |text: String, width: usize| {
            within(width, WIDEST).map(|width| format!("{text:>width$}"))
        });
        // Filters of Jinja that make as much as a number says, which steps do not tell; where it stands in what they are given.
        for (name, of_jinja, place) in [
            ("batch", Value::from_function(filters::batch), 1),
            ("format", Value::from_function(filters::format), 0),
            ("indent", Value::from_function(filters::indent), 1),
            ("slice", Value::from_function(filters::slice), 1),
        ] {
            environment.add_filter(name, move |state: &mut State, given: Rest<ValueOrKwargs>| {
                let given = given.into_values();
                let says_how_much = |i, value: &Value| i == place || place > 0 && value.is_kwargs();
                given.iter().enumerate().filter(|(i, v)| says_how_much(*i, v)).try_for_each(|(_, v)| narrow(v))?;
                of_jinja.call(state, &given)
            });
        }
        // Where there is no value the word none would be taken for one.
        environment.set_formatter(|out, state, value| match value.is_none() {
            true => Err(Error::new(ErrorKind::InvalidOperation, "there is no value to be written")),
            false => minijinja::escape_formatter(out, state, value),
        });
        let not_there = missing.clone();
        environment.add_filter("required", move |value: &Value, name: &str| not_there.required(value, name));
        let not_mapped = missing.clone();
        environment.add_filter("mapped", move |value: &Value, values: &Value, default: Option<Value>| {
            not_mapped.mapped(value, values, default)
        });
        let text = environment.render_named_str(&self.name, &self.text, data).map_err(wrong)?;
        let missing = missing.names();
        if missing.is_empty() { Ok(text) } else { Err(TemplateError::Missing { template: self.name.clone(), missing }) }
    }
}

/// Names of the values that are missing.
#[derive(Debug, Clone, Default)]
struct Missing(Arc<Mutex<Vec<String>>>);

impl Missing {
    /// `value`, called `name`; it is missing if it is none or empty text.
    fn required(&self, value: &Value, name: &str) -> Result<Value, Error> {
        if value.is_undefined() {
            return Err(ErrorKind::UndefinedError.into());
        }
        if value.is_none() || value.as_str().is_some_and(|text| text.trim().is_empty()) {
            self.add(name.to_owned());
            return Ok(Value::from(""));
        }
        Ok(value.clone())
    }

    /// Entry of the map `values` for `value`; else `default`, without which it is missing.
    fn mapped(&self, value: &Value, values: &Value, default: Option<Value>) -> Result<Value, Error> {
        if value.is_undefined() {
            return Err(ErrorKind::UndefinedError.into());
        }
        if values.kind() != minijinja::value::ValueKind::Map {
            let problem = format!("mapped takes a map as {{\"sink\": 1}}, not a {}", values.kind());
            return Err(Error::new(ErrorKind::InvalidOperation, problem));
        }
        let held = values.get_item(value)?;
        if !held.is_undefined() {
            return Ok(held);
        }
        Ok(default.unwrap_or_else(|| {
            self.add(format!("a value for {value} in a map"));
            Value::from("")
        }))
    }

    fn add(&self, name: String) {
        let mut names = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if !names.contains(&name) {
            names.push(name);
        }
    }

    fn names(&self) -> Vec<String> {
        std::mem::take(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// `count` if it is at most `most`.
fn within(count: usize, most: usize) -> Result<usize, Error> {
    let problem =
        || Error::new(ErrorKind::InvalidOperation, format!("{count} is too many, at most {most} are written"));
    (count <= most).then_some(count).ok_or_else(problem)
}

/// Whether `given`, a number, a format or arguments with names, asks for at most as much as is written.
fn narrow(given: &Value) -> Result<(), Error> {
    let narrow_number = |count| within(count, WIDEST).map(drop);
    if let Some(format) = given.as_str() {
        let mut numbers = format.split(|c: char| !c.is_ascii_digit()).filter(|digits| !digits.is_empty());
        return numbers.try_for_each(|digits| narrow_number(digits.parse().unwrap_or(usize::MAX)));
    }
    if given.is_kwargs() {
        return given.try_iter()?.try_for_each(|key| narrow(&given.get_item(&key)?));
    }
    given.as_usize().map_or(Ok(()), narrow_number)
}

/// A number with so many decimals.
fn fixed(value: &Value, decimals: Option<usize>, format: Kwargs) -> Result<String, Error> {
    if value.is_undefined() {
        return Err(ErrorKind::UndefinedError.into());
    }
    let (point, plus): (Option<String>, Option<bool>) = (format.get("point")?, format.get("plus")?);
    format.assert_all_used()?;
    if value.is_none() {
        return Ok("-".to_owned());
    }
    let number = f64::try_from(value.clone()).map_err(|_| {
        Error::new(ErrorKind::InvalidOperation, format!("fixed is for numbers, not for {}", value.kind()))
    })?;
    if !number.is_finite() {
        return Ok("-".to_owned());
    }
    let text = format!("{number:.*}", within(decimals.unwrap_or(3), MOST_DECIMALS)?);
    let is_zero = text.bytes().all(|b| b"-0.".contains(&b));
    let text = if is_zero { text.trim_start_matches('-').to_owned() } else { text };
    let text = if plus == Some(true) && !text.starts_with('-') { format!("+{text}") } else { text };
    Ok(text.replace('.', point.as_deref().unwrap_or(".")))
}

/// Text in a range of a template; where that is a filter, with its input.
fn expression(template: &str, range: std::ops::Range<usize>) -> Option<&str> {
    let before = template.get(..range.start)?;
    let opened = ["{{", "{%"].into_iter().filter_map(|sign| before.rfind(sign)).max().map_or(0, |at| at + 2);
    let start = if before.trim_end().ends_with('|') { opened } else { range.start };
    template.get(start..range.end).map(str::trim).filter(|text| !text.is_empty())
}

fn explained(error: &Error, template: &str, name: &str, keys: &str) -> TemplateError {
    let mut problem = error.kind().to_string();
    if let Some(detail) = error.detail() {
        problem += &format!(": {detail}");
    } else if let Some(text) = error.range().and_then(|range| expression(template, range)) {
        problem += &format!(": `{}`", text.chars().take(80).collect::<String>());
    }
    let line = error.line();
    if let Some(text) = line.and_then(|n| template.lines().nth(n - 1)).map(str::trim).filter(|t| !t.is_empty()) {
        problem += &format!(", in `{}`", text.chars().take(80).collect::<String>());
    }
    let remedy = match error.kind() {
        ErrorKind::UndefinedError => &format!(
            "names are the keys of {keys}; a value that may be none has no keys of its own: ask before with if"
        ),
        ErrorKind::UnknownFilter => {
            "filters are fixed, left, right, mapped, required, and those of Jinja: join, upper, default and others"
        }
        ErrorKind::OutOfFuel => "the template takes too many steps: are its loops right?",
        ErrorKind::SyntaxError => "statements stand in {% %}, values in {{ }}, remarks in {# #}",
        _ => "compare with the standard template",
    };
    let remedy = remedy.to_owned();
    TemplateError::Wrong { template: name.to_owned(), line, problem: problem.replace(char::is_control, " "), remedy }
}

#[cfg(test)]
mod tests;
