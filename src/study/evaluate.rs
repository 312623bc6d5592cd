//! The answer of a command for one point: the jobs that the command itself runs, without its files.

use std::path::{Path, PathBuf};

use serde::Serialize;
use serde_json::{Map, Value, json};

use super::base::Base;
use super::definition::StudyCommand;
use crate::workspaces::blisk::document::job_file::PlanJob;
use crate::workspaces::blisk::job::burning::WheelBurning;
use crate::workspaces::blisk::job::finish::finish_as_far_as_possible;
use crate::workspaces::blisk::job::outcome::{PlanInputs, PlanOutcome};
use crate::workspaces::blisk::job::plan::{prepare, run_prepared};
use crate::workspaces::blisk::job::planned::inputs_of;
use crate::workspaces::blisk::job::preset::{check_presets, read_presets, with_presets};
use crate::workspaces::blisk::job::sizing::{SizingRange, auto_sized, size as size_job};
use crate::workspaces::blisk::job::stages::{Part, load};
use crate::workspaces::blisk::report::{Report, build};
use crate::workspaces::mold::document::demonstration::DEMONSTRATION;
use crate::workspaces::mold::document::{MoldParams, part_of};
use crate::workspaces::mold::job::electrodes::electrodes as find_electrodes;
use crate::workspaces::mold::job::uncut::{Uncut, uncut as find_uncut};
use crate::workspaces::mold::report::ElectrodesReport;
use crate::workspaces::mold::report::uncut::UncutReport;
use burning::schedule::Schedule;
use files::get;
use import::{ImportOptions, ImportReport, Imported, import_file};
use task::Task;
use wheel::electrode::Sizing;

/// Outcome of a point.
pub struct Evaluated {
    /// Whether the answer is yes: exit code 0, and not 3.
    pub holds: bool,
    /// The answer in a sentence.
    pub sentence: String,
    /// The named results, in their order.
    pub named: Vec<(&'static str, Value)>,
    /// Report of the command, in which columns can name places.
    pub report: Value,
    /// The parameters that were used.
    pub base: Base,
}

/// Reason why there is no answer, in a line: the settings or the files of the point are wrong, or it was told to stop.
pub type Reason = String;

/// A named result: its name in tables, its unit, and what it is.
pub type NamedResult = (&'static str, &'static str, &'static str);

/// The named results of a command.
pub fn named_results(command: StudyCommand) -> &'static [NamedResult] {
    match command {
        StudyCommand::Plan => &[
            ("electrodes", "", "number of electrodes"),
            ("verified", "", "whether every path is verified"),
            ("certified_mm", "mm", "certified clearance of the electrode that has the least"),
            ("volume_mm3", "mm³", "volume of all electrodes"),
            ("thickness_mm", "mm", "least thickness of any electrode"),
            ("burn_area_mm2", "mm²", "area that erodes, of all electrodes"),
            ("residual_mm", "mm", "thickest residual stock on a wall"),
            ("left_mm3", "mm³", "volume of the channel that no electrode erodes"),
            ("channel_min", "min", "burning of a channel"),
            ("wheel_h", "h", "the whole wheel, with set-up, indexing and changes"),
            ("needed", "", "electrodes that the wheel needs"),
            ("throat_mm", "mm", "least distance of the walls"),
            ("turning_deg", "deg", "turning of the channel"),
            ("enter", "", "sides of entry"),
        ],
        StudyCommand::Size => &[
            ("sets", "", "number of certified sets, each side of entry counted"),
            ("thickness_mm", "mm", "least thickness of the thickest set"),
            ("low_reduction_deg", "deg", "its reduction of the low wall"),
            ("high_reduction_deg", "deg", "its reduction of the high wall"),
            ("volume_mm3", "mm³", "its volume"),
            ("certified_mm", "mm", "its certified clearance"),
            ("enter", "", "its side of entry"),
        ],
        StudyCommand::Uncut => &[
            ("regions", "", "number of uncut regions"),
            ("volume_mm3", "mm³", "their volume"),
            ("off_mm3", "mm³", "estimated error of the volume"),
            ("surface_mm2", "mm²", "area of the mold's surface that bounds them"),
            ("height_mm", "mm", "greatest height of a region"),
            ("thickness_mm", "mm", "greatest thickness of a region"),
            ("hidden_mm2", "mm²", "area that no cutter from this side sees"),
            ("warnings", "", "number of warnings"),
        ],
        StudyCommand::Electrodes => &[
            ("regions", "", "number of uncut regions"),
            ("electrodes", "", "number of electrodes"),
            ("burns", "", "number of burns"),
            ("minutes", "min", "all burns, with set-up and changes"),
            ("blocked", "", "electrodes that a failed check blocks"),
            ("not_burned", "", "regions that are not burned, or not wholly"),
            ("burned_mm3", "mm³", "volume that all burns take"),
            ("burn_area_mm2", "mm²", "area that burns, of all electrodes"),
            ("left_mm", "mm", "greatest thickness that all burns leave"),
            ("left_mm3", "mm³", "volume that they leave"),
        ],
    }
}

/// Whether `column` may be a place in a report, and not a named result.
pub fn is_place(column: &str) -> bool {
    column.contains(['.', '['])
}

/// Runs `command` with the parameters `base`. `decide` sets what was varied anew in parameters that were freed of the decisions
/// for another part.
///
/// # Errors
/// The reason in a line, also when told to stop.
pub fn evaluate(
    command: StudyCommand,
    base: Base,
    decide: &dyn Fn(Base) -> Result<Base, Reason>,
    task: &Task,
) -> Result<Evaluated, Reason> {
    match (command, base) {
        (StudyCommand::Plan, Base::Blisk(job)) => plan(*job, task),
        (StudyCommand::Size, Base::Blisk(job)) => size(*job, task),
        (StudyCommand::Uncut, Base::Mold(params)) => uncut(*params, decide, task),
        (StudyCommand::Electrodes, Base::Mold(params)) => electrodes(*params, decide, task),
        (command, _) => Err(format!("the project is not for {}", command.name())),
    }
}

fn text(error: impl std::fmt::Display) -> Reason {
    error.to_string()
}

fn value(of: &impl Serialize) -> Result<Value, Reason> {
    serde_json::to_value(of).map_err(text)
}

/// The sum of what is known; none if something is not.
fn sum(values: impl Iterator<Item = Option<f64>>) -> Option<f64> {
    values.sum()
}

/// The least of what is known; none if something is not, or nothing is there.
fn least(mut values: impl Iterator<Item = Option<f64>>) -> Option<f64> {
    let first = values.next()??;
    values.try_fold(first, |least, value| Some(least.min(value?)))
}

fn greatest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, f64::max)
}

/// The value; a negative zero is no other value than zero.
fn unsigned_zero(value: &Value) -> Value {
    if value.as_f64() == Some(0.0) && value.is_f64() { json!(0.0) } else { value.clone() }
}

fn part_of_job(job: &PlanJob, task: &Task) -> Result<Part, Reason> {
    let part = load(job, task)?;
    let is_open = |report: &ImportReport| !report.watertight;
    if part.report.as_ref().is_some_and(is_open) {
        let name = &part.name;
        return Err(format!(
            "{name}: the surface is not closed, so it has no inside and nothing can be proven about it; close it in the \
             program it came from"
        ));
    }
    Ok(part)
}

fn plan(job: PlanJob, task: &Task) -> Result<Evaluated, Reason> {
    let part = part_of_job(&job, task)?;
    let inputs = inputs_of(&part, &job);
    let presets = job.setup.presets.as_deref().map(|file| read_presets(Path::new(file))).transpose().map_err(text)?;
    if let Some(presets) = &presets {
        check_presets(presets, inputs.electrodes()).map_err(|why| format!("presets: {why}"))?;
    }
    let prepared = prepare(&inputs, task).map_err(text)?;
    let inputs: PlanInputs = match job.electrode.size {
        Sizing::Given => inputs,
        Sizing::Auto => auto_sized(&prepared, &inputs, task).map_err(text)?.0,
    };
    let mut outcome = run_prepared(&prepared, &inputs, &|_, _, _| (), task).map_err(text)?;
    if let Some(presets) = &presets {
        outcome = with_presets(outcome, &inputs, prepared.blisk(), presets, task).map_err(text)?;
    }
    finish_as_far_as_possible(&outcome, &inputs, prepared.blisk(), task).map_err(text)?;
    let mut report = build::report(&outcome, &inputs.job, part.files.clone());
    // Times differ from run to run.
    report.times.clear();
    Ok(Evaluated {
        holds: outcome.may_be_approved() && outcome.bears_setting(),
        sentence: report.verdict.sentence.clone(),
        named: plan_results(&report, &outcome),
        report: value(&report)?,
        base: Base::Blisk(job.into()),
    })
}

fn plan_results(report: &Report, outcome: &PlanOutcome) -> Vec<(&'static str, Value)> {
    let electrodes = || report.electrodes.iter();
    let stock = outcome.residual_stock();
    let thickest = stock.map(|stock| stock.thickest().map_or(0.0, |(_, layer)| layer.depth_mm));
    let burning: Option<&WheelBurning> = report.burning.as_ref();
    let needed: Option<usize> = burning.and_then(|of| of.electrodes.iter().map(|electrode| electrode.copies).sum());
    let wheel = burning.and_then(|of| of.schedule.as_ref()).map(Schedule::total);
    let mut enter: Vec<&str> = electrodes().map(|e| e.enters_from.as_str()).collect();
    enter.dedup();
    vec![
        ("electrodes", json!(report.electrodes.len())),
        ("verified", json!(outcome.is_verified())),
        ("certified_mm", json!(least(electrodes().map(|e| e.certified_clearance_mm)))),
        ("volume_mm3", json!(sum(electrodes().map(|e| Some(e.volume_mm3))))),
        ("thickness_mm", json!(least(electrodes().map(|e| e.least_thickness_mm)))),
        ("burn_area_mm2", json!(sum(electrodes().map(|e| e.burn_area_mm2)))),
        ("residual_mm", json!(thickest)),
        ("left_mm3", json!(stock.map(|stock| stock.stock.left_mm3))),
        ("channel_min", json!(burning.and_then(|of| of.channel).map(|minutes| minutes.mean))),
        ("wheel_h", json!(wheel.map(|minutes| minutes.mean / 60.0))),
        ("needed", json!(needed)),
        ("throat_mm", json!(report.blisk.throat_mm)),
        ("turning_deg", json!(report.blisk.turning_deg)),
        ("enter", json!(enter.join(" "))),
    ]
}

fn size(job: PlanJob, task: &Task) -> Result<Evaluated, Reason> {
    let part = part_of_job(&job, task)?;
    let inputs = inputs_of(&part, &job);
    let prepared = prepare(&inputs, task).map_err(text)?;
    let parts = job.electrode.parts;
    let range = SizingRange { from: parts, to: parts };
    let rows = size_job(&prepared, &inputs, range, &|_| (), task).map_err(text)?;
    let thickest = rows.iter().max_by(|a, b| a.least_thickness_mm.total_cmp(&b.least_thickness_mm));
    let sentence = match thickest {
        Some(row) => format!("The thickest electrodes have {:.3} mm at least.", row.least_thickness_mm),
        None => "Not feasible: no electrode has an extraction path at the reductions tried.".to_owned(),
    };
    let named = vec![
        ("sets", json!(rows.len())),
        ("thickness_mm", json!(thickest.map(|row| row.least_thickness_mm))),
        ("low_reduction_deg", json!(thickest.map(|row| row.reduction_deg[0]))),
        ("high_reduction_deg", json!(thickest.map(|row| row.reduction_deg[1]))),
        ("volume_mm3", json!(thickest.map(|row| row.volume_mm3))),
        ("certified_mm", json!(thickest.map(|row| row.certified_mm))),
        ("enter", json!(thickest.map(|row| row.enter.name()))),
    ];
    let report = json!({ "rows": value(&rows)? });
    Ok(Evaluated { holds: !rows.is_empty(), sentence, named, report, base: Base::Blisk(job.into()) })
}

/// A mold, and what is left of it.
struct FoundUncut {
    params: MoldParams,
    imported: Imported,
    name: String,
    uncut: Uncut,
}

/// Reads the mold of `before` and finds what the cutters leave, as the commands do.
fn found_uncut(
    before: MoldParams,
    decide: &dyn Fn(Base) -> Result<Base, Reason>,
    task: &Task,
) -> Result<FoundUncut, Reason> {
    let demonstrated = before.demonstrated(task)?;
    let path = before.mesh.clone().or(demonstrated.as_ref().map(|_| PathBuf::from(DEMONSTRATION)));
    let Some(path) = path else { return Err("mesh is missing; give the mold in the project".to_owned()) };
    let options = ImportOptions { reading: before.reading(), ..ImportOptions::default() };
    let imported = demonstrated.map_or_else(|| import_file(&path, &options, task).map_err(text), Ok)?;
    let Base::Mold(params) = decide(Base::Mold(before.of_part(&part_of(&imported)).into()))? else {
        return Err("the project is none of a mold".to_owned());
    };
    let mut params = *params;
    params.open(&imported.mesh, &task.cancel).map_err(text)?;
    let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let uncut = find_uncut(&imported.mesh, &params.uncut(), task).map_err(|e| format!("{name}: {e}"))?;
    Ok(FoundUncut { params, imported, name, uncut })
}

fn uncut(params: MoldParams, decide: &dyn Fn(Base) -> Result<Base, Reason>, task: &Task) -> Result<Evaluated, Reason> {
    let found = found_uncut(params, decide, task)?;
    let report = UncutReport::of(&found.uncut, found.imported.faces.as_ref());
    let regions = || report.regions.iter();
    let named = vec![
        ("regions", json!(report.regions.len())),
        ("volume_mm3", json!(found.uncut.found().volume_mm3)),
        ("off_mm3", json!(report.grid.as_ref().map(|grid| grid.off_mm3))),
        ("surface_mm2", json!(regions().map(|region| region.surface_area_mm2).fold(0.0, |sum, v| sum + v))),
        ("height_mm", json!(greatest(regions().map(|region| region.height_mm)))),
        ("thickness_mm", json!(greatest(regions().map(|region| region.thickness_mm)))),
        ("hidden_mm2", json!(report.invert.area_mm2)),
        ("warnings", json!(report.warnings.len())),
    ];
    Ok(Evaluated {
        holds: report.is_whole,
        sentence: report.sentence.clone(),
        named,
        report: json!({ "uncut": value(&report)? }),
        base: Base::Mold(found.params.into()),
    })
}

fn electrodes(
    params: MoldParams,
    decide: &dyn Fn(Base) -> Result<Base, Reason>,
    task: &Task,
) -> Result<Evaluated, Reason> {
    let FoundUncut { params, imported, name, uncut } = found_uncut(params, decide, task)?;
    let set = find_electrodes(&imported, &uncut, &params.electrodes, task).map_err(|e| format!("{name}: {e}"))?;
    let report = ElectrodesReport::of(&set, &name, params.opening(), &params.datum, uncut.is_certain());
    let (table, regions) = (&report.table, || report.regions.iter());
    let named = vec![
        ("regions", json!(report.regions.len())),
        ("electrodes", json!(table.electrodes.len())),
        ("burns", json!(table.burns)),
        ("minutes", json!(table.minutes)),
        ("blocked", json!(report.blocked.len())),
        ("not_burned", json!(table.not_burned.len())),
        ("burned_mm3", json!(table.electrodes.iter().map(|e| e.volume_mm3).fold(0.0, |sum, v| sum + v))),
        ("burn_area_mm2", json!(table.electrodes.iter().map(|e| e.burn_area_mm2).fold(0.0, |sum, v| sum + v))),
        ("left_mm", json!(greatest(regions().map(|region| region.left_thickness_mm)))),
        ("left_mm3", json!(regions().map(|region| region.left_volume_mm3).fold(0.0, |sum, v| sum + v))),
    ];
    Ok(Evaluated {
        holds: set.holds() && uncut.is_whole(),
        sentence: report.sentence.clone(),
        named,
        report: value(&report)?,
        base: Base::Mold(params.into()),
    })
}

impl Evaluated {
    /// The named results, and the places of the report among `columns`. A place that holds no number, word or flag has no value.
    pub fn results<'a>(&self, columns: impl Iterator<Item = &'a String>) -> Map<String, Value> {
        let named = self.named.iter().map(|(name, value)| ((*name).to_owned(), unsigned_zero(value)));
        let single = |value: &Value| if value.is_array() || value.is_object() { Value::Null } else { value.clone() };
        let places = columns.filter(|column| is_place(column));
        named.chain(places.map(|place| (place.clone(), single(get(&self.report, place))))).collect()
    }
}
