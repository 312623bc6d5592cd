//! The burn table as text of any form, through a template that users edit.
//!
//! Templates are in the language of Jinja; they see the keys of `burn_table.json`. What they name and the table does
//! not have is an error and no gap in the text, because burn sheets are read by machines too. Beside the filters of the
//! language there are
//! - `fixed(decimals)`: a number with so many decimals, `-` where there is none;
//! - `left(width)` and `right(width)`: text filled up with blanks.

use std::path::Path;

use minijinja::syntax::SyntaxConfig;
use minijinja::value::{Serde, Value};
use minijinja::{AutoEscape, Environment, Error, ErrorKind, UndefinedBehavior};

use super::burn_table::BurnTable;

/// The template that the program brings along: a burn sheet for people.
pub const BURN_SHEET: &str = include_str!("../../../assets/burn_table.jinja");
/// The largest template that is read (bytes).
const LARGEST_FILE: u64 = 1 << 20;
/// Steps that a template may take: enough for thousands of electrodes, and little enough to come to an end.
const MOST_STEPS: u64 = 50_000_000;
/// The widest column, and the most decimals.
const WIDEST: usize = 1000;
const MOST_DECIMALS: usize = 12;

/// Reason why a template makes no text.
#[derive(Debug, thiserror::Error)]
pub enum TemplateError {
    /// File cannot be read.
    #[error("{template}: cannot be read ({source}); check the path, and that it is text in UTF-8")]
    Unreadable {
        /// The file.
        template: String,
        /// Reason that the system gives.
        source: std::io::Error,
    },
    /// File is no template.
    #[error("{template}: it has {bytes} bytes; a template has at most {LARGEST_FILE}")]
    TooLarge {
        /// The file.
        template: String,
        /// Size.
        bytes: u64,
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
        remedy: &'static str,
    },
}

/// A template that makes a burn sheet.
#[derive(Debug, Clone)]
pub struct BurnSheet {
    /// Name of the template in errors.
    name: String,
    text: String,
}

impl BurnSheet {
    /// The built-in template.
    pub fn standard() -> Self {
        Self { name: "the built-in burn sheet".to_owned(), text: BURN_SHEET.to_owned() }
    }

    /// Name of the template: the built-in name, or its file.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The template in `file`, tried on examples of all that a table may hold: electrodes take their time, and what is
    /// wrong with their sheet should be known before.
    ///
    /// # Errors
    /// [`TemplateError`] with the line.
    pub fn read(file: &Path) -> Result<Self, TemplateError> {
        let template = file.display().to_string();
        let unreadable = |source| TemplateError::Unreadable { template: template.clone(), source };
        let bytes = std::fs::metadata(file).map_err(unreadable)?.len();
        if bytes > LARGEST_FILE {
            return Err(TemplateError::TooLarge { template, bytes });
        }
        let text = std::fs::read_to_string(file).map_err(unreadable)?;
        if text.trim().is_empty() {
            return Err(unreadable(std::io::Error::new(std::io::ErrorKind::InvalidData, "it is empty")));
        }
        let sheet = Self { name: template, text };
        BurnTable::examples().iter().try_for_each(|example| sheet.of(example).map(drop))?;
        Ok(sheet)
    }

    /// The text that it makes of `table`.
    ///
    /// # Errors
    /// [`TemplateError::Wrong`] with the line.
    pub fn of(&self, table: &BurnTable) -> Result<String, TemplateError> {
        render_within(MOST_STEPS, table, &self.text, &self.name)
    }
}

fn render_within(steps: u64, table: &BurnTable, template: &str, name: &str) -> Result<String, TemplateError> {
    let wrong = |error: Error| explained(&error, template, name);
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
    environment.add_filter("left", |text: String, width: usize| format!("{text:<width$}", width = width.min(WIDEST)));
    environment.add_filter("right", |text: String, width: usize| format!("{text:>width$}", width = width.min(WIDEST)));
    environment.render_named_str(name, template, Value::from(Serde(table))).map_err(wrong)
}

/// A number with so many decimals.
fn fixed(value: &Value, decimals: Option<usize>) -> Result<String, Error> {
    if value.is_undefined() {
        return Err(ErrorKind::UndefinedError.into());
    }
    if value.is_none() {
        return Ok("-".to_owned());
    }
    let number = f64::try_from(value.clone()).map_err(|_| {
        Error::new(ErrorKind::InvalidOperation, format!("fixed is for numbers, not for {}", value.kind()))
    })?;
    if !number.is_finite() {
        return Ok("-".to_owned());
    }
    let text = format!("{number:.*}", decimals.unwrap_or(3).min(MOST_DECIMALS));
    let is_zero = text.bytes().all(|b| b"-0.".contains(&b));
    Ok(if is_zero { text.trim_start_matches('-').to_owned() } else { text })
}

/// Text in a range of a template; where that is a filter, with its input.
fn expression(template: &str, range: std::ops::Range<usize>) -> Option<&str> {
    let before = template.get(..range.start)?;
    let opened = ["{{", "{%"].into_iter().filter_map(|sign| before.rfind(sign)).max().map_or(0, |at| at + 2);
    let start = if before.trim_end().ends_with('|') { opened } else { range.start };
    template.get(start..range.end).map(str::trim).filter(|text| !text.is_empty())
}

fn explained(error: &Error, template: &str, name: &str) -> TemplateError {
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
        ErrorKind::UndefinedError => {
            "the names are those of the keys of burn_table.json, and of what may be none nothing can be had: ask \
             before with if"
        }
        ErrorKind::UnknownFilter => {
            "filters are fixed, left, right, and those of Jinja: join, upper, default and others"
        }
        ErrorKind::OutOfFuel => "the template takes too many steps: are its loops right?",
        ErrorKind::SyntaxError => "statements stand in {% %}, values in {{ }}, remarks in {# #}",
        _ => "compare with the standard template",
    };
    TemplateError::Wrong { template: name.to_owned(), line, problem: problem.replace(char::is_control, " "), remedy }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::electrode_fixtures::set;
    use mold::datum::Datum;
    use mold::electrode::params::Shape;
    use mold::opening::Opening;

    fn table() -> BurnTable {
        BurnTable::of(&set(), "shell", Opening::PlusZ, &Datum::default())
    }

    fn render(table: &BurnTable, template: &str, name: &str) -> Result<String, TemplateError> {
        BurnSheet { name: name.to_owned(), text: template.to_owned() }.of(table)
    }

    #[test]
    fn the_standard_sheet_says_positions_and_what_is_blocked() {
        let text = render(&table(), BURN_SHEET, "standard").unwrap();
        let line = |words: &[&str]| text.lines().any(|l| words.iter().all(|w| l.contains(w)));
        assert!(line(&["SHEET", "shell"]) && line(&["opening", "+z"]), "{text}");
        assert!(line(&["3 electrodes", "4 burns", "25 min"]), "{text}");
        assert!(line(&["12.3457", "-4.5000", "20.0000", "90.0000"]), "{text}");
        assert!(line(&["Files hold the electrodes as they are milled"]) && line(&["NOTE: no holder"]), "{text}");
        assert!(line(&["E03", "BLOCKED"]), "{text}");
        assert!(line(&["E02", "OVERRIDDEN"]), "{text}");
        assert!(line(&["gouge", "failed", "too deep a burn"]), "{text}");
        assert!(!text.contains("none") && !text.contains("{"), "{text}");
        assert!(text.lines().all(|l| l == l.trim_end()), "{text}");
        let mut one = set();
        (one.params.shape, one.electrodes) = (Shape::Net, one.electrodes.drain(2..).collect());
        one.checks.drain(..2);
        let text =
            render(&BurnTable::of(&one, "shell", Opening::PlusZ, &Datum::default()), BURN_SHEET, "standard").unwrap();
        let line = |words: &[&str]| text.lines().any(|l| words.iter().all(|w| l.contains(w)));
        assert!(line(&["1 electrode, 1 burn,"]) && line(&["FILES HOLD THE SHAPE OF THE CAVITY"]), "{text}");
        assert!(line(&["TO BE MILLED SMALLER by wall 0.0500 floor 0.0500"]), "{text}");
    }

    #[test]
    fn a_users_template_makes_a_format_of_its_own() {
        let template = "{% for e in electrodes if e.state != 'blocked' %}\n{% for b in e.burns %}\n\
            ({{ e.name|left(5) }})X{{ b.x_mm|fixed(3) }} C{{ b.c_deg|fixed(1)|right(6) }} \
            H{{ e.holder.name if e.holder }}\n\
            {% endfor %}\n{% endfor %}\nM30\n";
        let expected = "(E01  )X12.346 C  90.0 Hholder 25\n(E01  )X-1.000 C-135.0 Hholder 25\n\
                        (E02-finish)X0.000 C   0.0 H\nM30\n";
        assert_eq!(render(&table(), template, "mine").unwrap(), expected);
    }

    #[test]
    fn text_is_not_escaped_and_nothing_is_dropped_at_the_end() {
        let mut table = table();
        table.mold = "<a> & \"b\"".to_owned();
        assert_eq!(render(&table, "{{ mold }}\n\n", "x.html").unwrap(), "<a> & \"b\"\n\n");
        assert_eq!(
            render(&table, "{{ -0.0001|fixed(2) }} {{ none|fixed }} {{ 3|fixed(1) }}", "x").unwrap(),
            "0.00 - 3.0"
        );
    }

    #[test]
    fn a_wrong_template_is_answered_with_the_line_and_the_remedy() {
        for (template, line, words) in [
            ("a\n{% for e in electrodes %}\n{{ e.naem }}\n{% endfor %}", 3, "naem"),
            ("a\n{{ mold|fixt }}", 2, "fixt"),
            ("\n\n{{ mold|fixed(2) }}", 3, "fixed is for numbers"),
            ("{{ missing|fixed(2) }}", 1, "undefined value: `missing|fixed(2)`"),
            (
                "a{{ mold }}\n{% for e in electrodes %}{{ e.name }}{{ e.naem }}{% endfor %}",
                2,
                "undefined value: `e.naem`",
            ),
            ("a\nb\n{% if mold %}\n", 3, "syntax"),
            ("a\n{{ mold", 2, "syntax"),
            ("{% for e in electrode %}{% endfor %}", 1, "undefined value: `electrode`"),
            ("{% include 'other' %}", 1, "include"),
            ("\n{% for a in range(9999) %}{% for b in range(9999) %}{% endfor %}{% endfor %}", 2, "too many steps"),
        ] {
            let error = render_within(10_000, &table(), template, "mine.jinja").unwrap_err();
            let said = error.to_string();
            let TemplateError::Wrong { line: Some(found), .. } = error else { panic!("{template:?}: {said}") };
            // The end of a text counts as the line of its last character or as the next.
            assert!(found == line || found == template.lines().count(), "{template:?}: {said}");
            assert!(said.starts_with(&format!("mine.jinja: line {found}: ")) && said.contains(words), "{said}");
            assert_eq!(said.lines().count(), 1);
        }
    }

    /// The keys of values and of what is in them.
    fn keys(value: &serde_json::Value, at: &str, found: &mut std::collections::BTreeSet<String>) {
        match value {
            serde_json::Value::Object(map) => map.iter().for_each(|(key, value)| {
                found.insert(format!("{at}.{key}"));
                keys(value, &format!("{at}.{key}"), found);
            }),
            serde_json::Value::Array(list) => list.iter().for_each(|value| keys(value, at, found)),
            _ => {}
        }
    }

    #[test]
    fn a_template_is_tried_on_all_that_a_table_may_hold_before_there_is_one() {
        let of = |table: &BurnTable| {
            let mut found = Default::default();
            keys(&serde_json::to_value(table).unwrap(), "", &mut found);
            found
        };
        let [full, several] = BurnTable::examples();
        assert!(of(&full).is_superset(&of(&table())), "an example knows every key");
        for state in ["ok", "overridden", "blocked"] {
            assert!(several.electrodes.iter().any(|e| e.state.name() == state));
        }
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("mine.jinja");
        let read = |text: &str| {
            std::fs::write(&file, text).unwrap();
            BurnSheet::read(&file).map(drop).map_err(|e| e.to_string())
        };
        assert_eq!(read(BURN_SHEET), Ok(()));
        assert_eq!(read("{% for e in electrodes %}{{ e.holder.name if e.holder else '-' }}{% endfor %}"), Ok(()));
        for (text, words) in [
            ("\n{% for e in electrodes %}{{ e.holder.name }}{% endfor %}", "line 2: undefined value: `e.holder.name`"),
            (
                "{% for e in electrodes if e.state == 'blocked' %}\n{{ e.stat }}{% endfor %}",
                "line 2: undefined value: `e.stat`",
            ),
            ("{% for e in electrodes %}", "syntax"),
        ] {
            let said = read(text).unwrap_err();
            assert!(said.contains("mine.jinja") && said.contains(words), "{said}");
        }
    }

    #[test]
    fn a_template_is_read_from_its_file() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("mine.jinja");
        std::fs::write(&file, "{{ burns }} burns\n").unwrap();
        assert_eq!(BurnSheet::read(&file).unwrap().of(&table()).unwrap(), "4 burns\n");
        std::fs::write(&file, [0xff, 0xfe]).unwrap();
        for wrong in [file, folder.path().join("none")] {
            assert!(matches!(BurnSheet::read(&wrong), Err(TemplateError::Unreadable { .. })));
        }
    }
}
