//! The table of a study: CSV and a page with plots.

use serde::Serialize;
use serde_json::Value;

use super::answer::{Answer, BAD, YES};
use super::definition::{Collect, StudyCommand};
use super::evaluate::named_results;
use super::folder::{Counts, SECONDS, StudyError, StudyFolder};
use super::pareto::front;
use super::plots;
use files::report::{Template, page, quoted};
use files::{Entry, write_bytes};

/// The table in the folder of a study.
pub const CSV: &str = "study.csv";
/// The page in the folder of a study.
pub const PAGE: &str = "study.html";
/// Most rows of the page; the CSV file has all.
const ROWS: usize = 2000;

/// Points side by side.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Keys of the parameters that were varied.
    pub keys: Vec<String>,
    /// Results.
    pub columns: Vec<Column>,
    /// Points that have an answer, in order.
    pub rows: Vec<Row>,
    /// Numbers of points.
    pub counts: Counts,
    /// Version of the program that answered; empty if no point has an answer.
    pub version: String,
}

/// A result.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Name, or place in the report.
    pub name: String,
    /// Unit; may be empty.
    pub unit: &'static str,
    /// Meaning; empty for a place in the report.
    pub meaning: &'static str,
    /// Goal, if it is one.
    pub goal: Option<Goal>,
}

/// Sense in which a result is better.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Goal {
    /// Less is better.
    Less,
    /// More is better.
    More,
}

/// A point with its results.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Number of the point, counted from 1.
    pub point: usize,
    /// Values of the parameters.
    pub settings: Vec<String>,
    /// Exit code.
    pub exit_code: u8,
    /// Results; null where there is none.
    pub cells: Vec<Value>,
    /// Whether no other feasible point is as good in every goal and better in one.
    pub is_best: bool,
    /// The answer in a sentence.
    pub sentence: String,
}

impl Row {
    /// The answer in a word.
    pub fn word(&self) -> &'static str {
        match self.exit_code {
            YES => "feasible",
            BAD => "bad",
            _ => "not feasible",
        }
    }

    /// Whether the point has a project: a bad one has none.
    pub fn has_project(&self) -> bool {
        self.exit_code != BAD
    }

    /// A result as a number; flags count as 0 and 1.
    pub fn number(&self, column: usize) -> Option<f64> {
        match &self.cells[column] {
            Value::Bool(flag) => Some(f64::from(u8::from(*flag))),
            cell => cell.as_f64(),
        }
    }
}

impl Table {
    /// The table of `study` with these answers, one for each point or none.
    ///
    /// # Errors
    /// [`StudyError`] if the answers cannot be put side by side, or one lacks a result.
    pub fn of(study: &StudyFolder, answers: &[Option<Answer>]) -> Result<Self, StudyError> {
        study.check(answers)?;
        let columns = columns(study.study().command, &study.study().collect);
        let mut rows = Vec::new();
        for answer in answers.iter().flatten() {
            let missing = study.missing(answer).filter(|_| answer.exit_code != BAD);
            if let Some(column) = missing {
                let (folder, point, column) = (study.folder().to_owned(), answer.point, column.clone());
                return Err(StudyError::NoColumn { folder, point, column });
            }
            let cell = |column: &Column| match column.name.as_str() {
                SECONDS => answer.seconds.into(),
                name => answer.results.get(name).cloned().unwrap_or_default(),
            };
            rows.push(Row {
                point: answer.point,
                settings: study.points()[answer.point - 1].clone(),
                exit_code: answer.exit_code,
                cells: columns.iter().map(cell).collect(),
                is_best: false,
                sentence: answer.sentence.clone(),
            });
        }
        let version = answers.iter().flatten().next().map_or_else(String::new, |a| a.program_version.clone());
        let mut table = Self { keys: study.keys().to_vec(), columns, rows, counts: study.counts(answers), version };
        table.mark_best();
        Ok(table)
    }

    fn mark_best(&mut self) {
        let goals: Vec<(usize, Goal)> =
            self.columns.iter().enumerate().filter_map(|(i, column)| Some((i, column.goal?))).collect();
        let cost = |row: &Row, (column, goal): &(usize, Goal)| {
            let value = row.number(*column)?;
            Some(if *goal == Goal::More { -value } else { value })
        };
        let costs = |row: &Row| -> Option<Vec<f64>> {
            goals.iter().map(|goal| cost(row, goal)).collect::<Option<_>>().filter(|_| row.exit_code == YES)
        };
        let all: Vec<Option<Vec<f64>>> = self.rows.iter().map(costs).collect();
        for (row, is_best) in self.rows.iter_mut().zip(front(&all)) {
            row.is_best = is_best;
        }
    }

    /// Whether there are goals.
    pub fn has_goals(&self) -> bool {
        self.columns.iter().any(|column| column.goal.is_some())
    }

    /// The table as CSV: a row for each point that has an answer. A cell without a result is empty.
    pub fn csv(&self) -> String {
        let mut head: Vec<String> = vec!["point".to_owned()];
        head.extend(self.keys.iter().cloned());
        head.push("exit_code".to_owned());
        head.extend(self.columns.iter().map(|column| column.name.clone()));
        head.extend(self.has_goals().then(|| "is_best".to_owned()));
        head.push("sentence".to_owned());
        let mut csv = line(&head);
        for row in &self.rows {
            let mut cells = vec![row.point.to_string()];
            cells.extend(row.settings.iter().cloned());
            cells.push(row.exit_code.to_string());
            cells.extend(row.cells.iter().map(cell_text));
            cells.extend(self.has_goals().then(|| row.is_best.to_string()));
            cells.push(row.sentence.clone());
            csv += &line(&cells);
        }
        csv
    }

    /// The table with its plots as one self-contained page.
    ///
    /// # Errors
    /// [`StudyError::Page`], which a test of the template keeps from happening.
    pub fn html(&self, study: &StudyFolder) -> Result<String, StudyError> {
        const TEMPLATE: Template = Template { name: "study.html.jinja", text: include_str!("study.html.jinja") };
        #[derive(Serialize)]
        struct Page<'a> {
            part: String,
            command: &'static str,
            holds: bool,
            sentence: String,
            version: &'a str,
            plots: Vec<plots::TitledPlot>,
            head: Vec<String>,
            rows: Vec<Vec<String>>,
            left_out: usize,
            columns: Vec<[&'a str; 3]>,
            parameters: Vec<Entry>,
        }
        let is_number = |i: usize| self.rows.iter().all(|row| row.cells[i].is_number() || row.cells[i].is_null());
        let mut head = vec!["#point".to_owned()];
        head.extend(self.keys.iter().cloned());
        head.extend(self.columns.iter().enumerate().map(|(i, column)| {
            let unit = if column.unit.is_empty() { String::new() } else { format!(" {}", column.unit) };
            let name = column.name.strip_suffix(unit_ending(column.unit)).unwrap_or(&column.name).replace('_', " ");
            format!("{}{name}{unit}", if is_number(i) { "#" } else { "" })
        }));
        head.push("answer".to_owned());
        let cells = |row: &Row| {
            let mut cells = vec![row.point.to_string()];
            cells.extend(row.settings.iter().cloned());
            cells.extend(row.cells.iter().map(shown));
            cells.push(match (row.is_best, row.exit_code) {
                (true, _) => "best".to_owned(),
                (false, BAD) => format!("bad: {}", row.sentence),
                _ => row.word().to_owned(),
            });
            cells
        };
        let page_of = Page {
            part: study.base().part(),
            command: study.study().command.name(),
            holds: self.counts.feasible > 0,
            sentence: self.sentence(),
            version: &self.version,
            plots: plots::all(self),
            head,
            rows: self.rows.iter().take(ROWS).map(cells).collect(),
            left_out: self.rows.len().saturating_sub(ROWS),
            columns: self
                .columns
                .iter()
                .filter(|column| !column.meaning.is_empty())
                .map(|column| [column.name.as_str(), column.unit, column.meaning])
                .collect(),
            parameters: study.base().entries(),
        };
        Ok(page(&TEMPLATE, &page_of)?)
    }

    /// The table in a sentence or two.
    pub fn sentence(&self) -> String {
        let best: Vec<String> = self.rows.iter().filter(|row| row.is_best).map(|row| row.point.to_string()).collect();
        let goals: Vec<String> = self
            .columns
            .iter()
            .filter_map(|column| {
                Some(format!("{} {}", if column.goal? == Goal::Less { "less" } else { "more" }, column.name))
            })
            .collect();
        let best = match (goals.is_empty(), best.len()) {
            (true, _) => String::new(),
            (false, 0) => format!(" No point can be compared by {}.", goals.join(", ")),
            (false, n) => {
                let named = best[..n.min(12)].join(", ");
                let more = if n > 12 { format!(" and {} more", n - 12) } else { String::new() };
                format!(" Best by {}: point {named}{more}.", goals.join(", "))
            }
        };
        format!("{}{best}", self.counts.sentence())
    }
}

/// The columns of a table: those that are asked for, or else all named results of the command; goals come along.
fn columns(command: StudyCommand, collect: &Collect) -> Vec<Column> {
    let known = named_results(command);
    let mut names: Vec<&str> = collect.columns.iter().map(String::as_str).collect();
    if names.is_empty() {
        names.extend(known.iter().map(|(name, ..)| *name));
    }
    for goal in collect.less.iter().chain(&collect.more) {
        if !names.contains(&goal.as_str()) {
            names.push(goal);
        }
    }
    let column = |name: &str| {
        let (unit, meaning) = match known.iter().find(|(known, ..)| *known == name) {
            Some((_, unit, meaning)) => (*unit, *meaning),
            None if name == SECONDS => ("s", "time that the point took"),
            None => ("", ""),
        };
        let is_in = |list: &[String]| list.iter().any(|goal| goal == name);
        let goal = match (is_in(&collect.less), is_in(&collect.more)) {
            (true, _) => Some(Goal::Less),
            (_, true) => Some(Goal::More),
            _ => None,
        };
        Column { name: name.to_owned(), unit, meaning, goal }
    };
    names.into_iter().map(column).collect()
}

/// End of a name that says its unit.
fn unit_ending(unit: &str) -> &'static str {
    match unit {
        "mm" => "_mm",
        "mm²" => "_mm2",
        "mm³" => "_mm3",
        "deg" => "_deg",
        "min" => "_min",
        "h" => "_h",
        _ => "\0",
    }
}

fn line(cells: &[String]) -> String {
    cells.iter().map(|cell| quoted(cell)).collect::<Vec<_>>().join(",") + "\n"
}

/// A result with all its digits.
fn cell_text(cell: &Value) -> String {
    match cell {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

/// A result as pages and the window show it.
pub fn shown(cell: &Value) -> String {
    match cell {
        Value::Null => "–".to_owned(),
        Value::Bool(flag) => if *flag { "yes" } else { "no" }.to_owned(),
        Value::Number(number) if number.is_f64() => number.as_f64().map_or_else(String::new, files::report::small),
        other => cell_text(other),
    }
}

impl StudyFolder {
    /// Puts the answers side by side and writes the table and its page into the folder.
    ///
    /// # Errors
    /// [`StudyError`]; nothing was written then.
    pub fn collect(&self) -> Result<Table, StudyError> {
        let table = Table::of(self, &self.answers()?)?;
        let html = table.html(self)?;
        write_bytes(&self.folder().join(CSV), table.csv().as_bytes())?;
        write_bytes(&self.folder().join(PAGE), html.as_bytes())?;
        Ok(table)
    }
}
