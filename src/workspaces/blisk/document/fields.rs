//! What a form needs to know of every parameter: its name, unit, symbol in the paper, range, and what it does.
//!
//! A field names its parameter by a JSON pointer into a [`PlanJob`], so that forms, job files and project files speak
//! of the same structs. The ranges are those of `validate()`; a test holds the two together.

use serde_json::Value;

use super::job_file::PlanJob;
use super::stage::Stage;

/// One parameter of a job.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Field {
    /// The step it belongs to.
    pub stage: Stage,
    /// Heading under which it stands.
    pub group: &'static str,
    /// JSON pointer into a job; its parts are section and key of a job file.
    pub pointer: &'static str,
    /// Name for a reader.
    pub label: &'static str,
    /// What it is in the papers, may be empty.
    pub symbol: &'static str,
    /// Unit, may be empty.
    pub unit: &'static str,
    /// What values it takes.
    pub kind: Kind,
    /// What it does.
    pub help: &'static str,
}

/// What values a parameter takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// A number, with the decimals it is shown with.
    Number(Range, usize),
    /// A number that is best set by a slider; the second range is the slider's.
    Slider(Range, Range, usize),
    /// A whole number.
    Integer(Range),
    /// A number or `"auto"`; the third is what giving it starts with.
    AutoNumber(Range, usize, f64),
    /// A whole number or `"auto"`; the second is what giving it starts with.
    AutoInteger(Range, u64),
    /// One of some words, each with how it is shown.
    Choice(&'static [(&'static str, &'static str)]),
    /// One of some words, each with how it is shown, or the path of a file.
    ChoiceOrFile(&'static [(&'static str, &'static str)]),
    /// Yes or no.
    Flag,
    /// A file, or none.
    File,
}

/// Least and greatest value; the latter may be infinite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range(pub f64, pub f64);

impl Range {
    /// Whether `value` lies within.
    pub fn contains(self, value: f64) -> bool {
        (self.0..=self.1).contains(&value)
    }
}

impl Field {
    /// Where the parameter stands in a job file, e.g. `[electrode] spark_gap_mm`.
    pub fn key(&self) -> String {
        let mut parts: Vec<&str> = self.pointer.split('/').skip(1).collect();
        let index = parts.pop_if(|p| p.bytes().all(|b| b.is_ascii_digit()));
        let key = parts.pop().unwrap_or_default();
        let index = index.map(|i| format!("[{i}]")).unwrap_or_default();
        format!("[{}] {key}{index}", parts.join("."))
    }

    /// Its value in `job`, which is a job as JSON.
    pub fn get<'a>(&self, job: &'a Value) -> &'a Value {
        job.pointer(self.pointer).unwrap_or(&Value::Null)
    }

    /// The numbers that it may be, if it is one.
    pub fn range(&self) -> Option<Range> {
        match self.kind {
            Kind::Number(range, _) | Kind::Slider(range, ..) | Kind::Integer(range) => Some(range),
            Kind::AutoNumber(range, ..) | Kind::AutoInteger(range, _) => Some(range),
            Kind::Choice(_) | Kind::ChoiceOrFile(_) | Kind::Flag | Kind::File => None,
        }
    }

    /// Why `value` cannot be taken, if it cannot.
    pub fn problem(&self, value: &Value) -> Option<String> {
        let (range, number) = match self.kind {
            Kind::Number(range, _) | Kind::Slider(range, ..) | Kind::Integer(range) => (range, value.as_f64()),
            Kind::AutoNumber(range, ..) | Kind::AutoInteger(range, _) if value.is_number() => (range, value.as_f64()),
            _ => return None,
        };
        let unit = if self.unit.is_empty() { String::new() } else { format!(" {}", self.unit) };
        let ok = number.is_some_and(|n| range.contains(n));
        let allowed = match range {
            Range(least, f64::INFINITY) => format!("must be at least {least}{unit}"),
            Range(least, greatest) => format!("must be from {least} to {greatest}{unit}"),
        };
        (!ok).then_some(allowed)
    }

    /// The fields of a step, in the order of its form.
    pub fn of(stage: Stage) -> impl Iterator<Item = &'static Self> {
        super::field_table::FIELDS.iter().filter(move |f| f.stage == stage)
    }
}

/// The job as JSON, for fields to read.
pub fn job_as_json(job: &PlanJob) -> Value {
    // A job is made of numbers, texts and lists alone, all of which JSON has.
    serde_json::to_value(job).unwrap_or_default()
}

/// The job with another value for one field.
///
/// # Errors
/// One line if the field takes no such value.
pub fn with_value(job: &Value, field: &Field, value: Value) -> Result<PlanJob, String> {
    let mut job = job.clone();
    match job.pointer_mut(field.pointer) {
        Some(place) => *place = value,
        None => return Err(format!("{} is not a parameter", field.key())),
    }
    if field.pointer == "/machine/name" {
        take_machine(&mut job);
    }
    PlanJob::from_json(job, std::path::Path::new(""))
}

/// Drops what the machine that is named says itself: axes, travels and speeds. Without one they stay as they are.
fn take_machine(job: &mut Value) {
    if let Some(machine) = job["machine"].as_object_mut()
        && machine.get("name").and_then(Value::as_str).is_some_and(|name| !name.is_empty())
    {
        machine.retain(|key, _| key == "name");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn base() -> PlanJob {
        let mut job = PlanJob::demonstration();
        job.blisk.mesh = Some("part.stl".into());
        job
    }

    #[test]
    fn every_field_names_a_parameter_and_its_default_is_in_range() {
        let job = job_as_json(&base());
        for field in super::super::field_table::FIELDS {
            assert!(job.pointer(field.pointer).is_some(), "{}", field.pointer);
            assert_eq!(field.problem(field.get(&job)), None, "{}", field.pointer);
            assert!(!field.label.is_empty() && !field.help.is_empty(), "{}", field.pointer);
        }
    }

    #[test]
    fn ranges_are_those_that_a_job_is_checked_against() {
        let job = job_as_json(&base());
        for field in super::super::field_table::FIELDS {
            let range = match field.kind {
                Kind::Number(r, _) | Kind::Slider(r, ..) | Kind::Integer(r) | Kind::AutoNumber(r, ..) => r,
                Kind::AutoInteger(r, _) => r,
                _ => continue,
            };
            let whole = matches!(field.kind, Kind::Integer(_) | Kind::AutoInteger(..));
            let outside = |bound: f64, side: f64| bound + side * if whole { 1.0 } else { 1e-3 * bound.abs().max(0.01) };
            let beyond = [(range.0, -1.0), (range.1, 1.0)];
            for (bound, side) in beyond.into_iter().filter(|(bound, _)| bound.is_finite()) {
                let value = outside(bound, side);
                let number = if whole && value >= 0.0 { Value::from(value as u64) } else { Value::from(value) };
                let refused = with_value(&job, field, number.clone()).and_then(|j| j.validate()).is_err();
                assert!(refused, "{} = {number} is taken", field.pointer);
                assert!(field.problem(&number).is_some(), "{} = {number}", field.pointer);
            }
        }
    }

    #[test]
    fn every_choice_is_a_word_that_is_understood() {
        let job = job_as_json(&base());
        for field in super::super::field_table::FIELDS {
            if let Kind::Choice(words) | Kind::ChoiceOrFile(words) = field.kind {
                for (word, _) in words {
                    assert!(with_value(&job, field, (*word).into()).is_ok(), "{} = {word}", field.pointer);
                }
            }
        }
    }

    #[test]
    fn a_value_is_set_and_read_again() {
        let job = job_as_json(&base());
        let field = Field::of(Stage::Electrode).find(|f| f.pointer.ends_with("deg/1")).unwrap();
        let changed = with_value(&job, field, 1.25.into()).unwrap();
        assert_eq!(changed.electrode.circumferential_reduction_deg, [2.0, 1.25]);
        assert_eq!(field.key(), "[electrode] circumferential_reduction_deg[1]");
    }

    #[test]
    fn a_machine_that_is_chosen_brings_its_axes_along() {
        let job = job_as_json(&base());
        let field = Field::of(Stage::Plan).find(|f| f.pointer == "/machine/name").unwrap();
        let six = with_value(&job, field, "xyzabc".into()).unwrap();
        assert_eq!((six.machine.axes, six.machine.has_bodies()), (feed::machine::AxisSet::XYZABC, true));
        let none = with_value(&job_as_json(&six), field, "".into()).unwrap();
        assert_eq!((none.machine.axes, none.machine.has_bodies()), (six.machine.axes, false));
        assert!(with_value(&job, field, "nowhere/mine.toml".into()).unwrap_err().contains("cannot be read"));
    }
}
