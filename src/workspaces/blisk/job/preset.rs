//! Plans for electrodes as they were measured on their holders, and as they are worn.

use std::collections::BTreeMap;
use std::path::Path;

use super::outcome::{PlanInputs, PlanJobError, PlanOutcome};
use feed::machine_model::Station;
use feed::path::{FeedPath, PathRow};
use feed::preset::{MOST_OFF, Preset};
use feed::verify::Verifier;
use geometry::mesh::Mesh;
use geometry::solid::SolidError;
use glam::DVec3;
use task::Task;
use wheel::electrode::Electrode;
use wheel::surface_finder::SurfaceFinder;

/// Columns of a table of presets; the date is for people, and the last one may be left out.
pub const COLUMNS: [&str; 8] = ["electrode", "x_mm", "y_mm", "z_mm", "c_deg", "uncertainty_mm", "date", "wear_mm"];
/// Length of the path's end along which its direction is measured (mm).
const END_MM: f64 = 1.0;
/// The largest table that is read (bytes).
const LARGEST_FILE: u64 = 1 << 20;

/// An electrode as it is put to use.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredElectrode {
    /// Place on its holder.
    pub preset: Preset,
    /// Length that the front has lost in the burns before (mm), by the wear of the technology.
    pub wear_mm: f64,
}

/// Electrodes as they are put to use, by the number of the electrode from 1.
pub type Presets = BTreeMap<usize, MeasuredElectrode>;

/// Reason why a file is no table of presets.
#[derive(Debug, thiserror::Error)]
pub enum PresetError {
    /// File cannot be read.
    #[error(transparent)]
    File(#[from] files::FileError),
    /// A line is wrong.
    #[error("{file}: line {line}: {problem}")]
    Line {
        /// The file.
        file: String,
        /// Number of the line, from 1.
        line: usize,
        /// Problem and remedy.
        problem: String,
    },
}

/// The presets in the CSV file `file`, whose first line names [`COLUMNS`].
///
/// # Errors
/// [`PresetError`] with the line.
pub fn read_presets(file: &Path) -> Result<Presets, PresetError> {
    let text = files::read_text(file, "table of presets", LARGEST_FILE)?;
    let name = file.display().to_string();
    presets_of(&text).map_err(|(line, problem)| PresetError::Line { file: name, line, problem })
}

fn presets_of(text: &str) -> Result<Presets, (usize, String)> {
    let mut lines = text.strip_prefix('\u{feff}').unwrap_or(text).lines().enumerate();
    let head = lines.next().map_or("", |(_, line)| line);
    let (all, [without_wear @ .., wear]) = (head.split(',').map(str::trim), &COLUMNS);
    if !all.clone().eq(COLUMNS) && !all.eq(without_wear.iter().copied()) {
        let columns = without_wear.join(",");
        return Err((
            1,
            format!("the columns are to be {columns} or these and {wear}, with commas between and points in numbers"),
        ));
    }
    let mut presets = Presets::new();
    for (i, line) in lines.filter(|(_, line)| !line.trim().is_empty()) {
        let (number, preset) = row(line, head.split(',').count()).map_err(|problem| (i + 1, problem))?;
        if presets.insert(number, preset).is_some() {
            return Err((i + 1, format!("electrode {number} has a preset already; leave one row for each")));
        }
    }
    Ok(presets)
}

fn row(line: &str, columns: usize) -> Result<(usize, MeasuredElectrode), String> {
    let cells: Vec<&str> = line.split(',').map(str::trim).collect();
    let (true, [electrode, x_mm, y_mm, z_mm, c_deg, uncertainty_mm, _date, wear @ ..]) =
        (cells.len() == columns, &cells[..])
    else {
        return Err(format!("it has {} cells, and {columns} are needed", cells.len()));
    };
    let number = electrode.trim_start_matches(['E', 'e']).parse().ok().filter(|number| *number >= 1);
    let number = number.ok_or_else(|| format!("electrode is {electrode:?}: give its number, as 1 or E1"))?;
    let within = |name: &str, text: &str, [least, most]: [f64; 2], unit: &str| {
        let value = text.parse().ok().filter(|value: &f64| (least..=most).contains(value));
        value.ok_or_else(|| format!("{name} is {text:?}: must be a number from {least} to {most} {unit}"))
    };
    let value = |name: &str, text: &str, most: f64, unit: &str| within(name, text, [-most, most], unit);
    let [most_mm, most_deg] = MOST_OFF;
    let preset = Preset {
        x_mm: value("x_mm", x_mm, most_mm, "mm")?,
        y_mm: value("y_mm", y_mm, most_mm, "mm")?,
        z_mm: value("z_mm", z_mm, most_mm, "mm")?,
        c_deg: value("c_deg", c_deg, most_deg, "deg")?,
        uncertainty_mm: within("uncertainty_mm", uncertainty_mm, [0.0, most_mm], "mm")?,
        ..Preset::default()
    };
    // What is not known is not 0.
    let wear_mm = match wear.first() {
        None => 0.0,
        Some(&"") => return Err("wear_mm is empty; give the wear in mm, or 0 for a new electrode".to_owned()),
        Some(text) => within("wear_mm", text, [0.0, most_mm], "mm")?,
    };
    Ok((number, MeasuredElectrode { preset, wear_mm }))
}

/// Checks that there is a preset for each of `count` electrodes and for no other.
///
/// # Errors
/// The first electrode of which it is not so, in words.
pub fn check_presets(presets: &Presets, count: usize) -> Result<(), String> {
    if let Some(number) = presets.keys().find(|number| **number > count) {
        return Err(format!("there is a preset for electrode {number}, and the plan has {count}; remove its row"));
    }
    match (1..=count).find(|number| !presets.contains_key(number)) {
        Some(number) => Err(format!("electrode {number} has no preset; add a row for it")),
        None => Ok(()),
    }
}

/// The plan for electrodes that stand on their holders and are worn as `presets` say: each path is rewritten and verified anew
/// with the worn electrode. `blisk` is that of the plan, in W. What comes after the feed is not known yet.
///
/// # Errors
/// If an electrode has no preset or there is none for it, its preset is not measured as well as the setting errors of the job
/// ask for, B tilts one that stands turned on its holder, or a path cannot be judged.
pub fn with_presets(
    outcome: PlanOutcome,
    inputs: &PlanInputs,
    blisk: &Mesh,
    presets: &Presets,
    task: &Task,
) -> Result<PlanOutcome, PlanJobError> {
    let mut outcome = outcome.unfinished();
    let (job, wrong) = (&inputs.job, |text: String| Err(PlanJobError::Job(text)));
    check_presets(presets, outcome.electrodes.len()).map_err(PlanJobError::Job)?;
    let finder = SurfaceFinder::new(outcome.channel.clone())?;
    for (number, electrode) in (1..).zip(&mut outcome.electrodes) {
        let Some(MeasuredElectrode { preset, wear_mm }) = presets.get(&number) else { continue };
        if job.setting.errors().is_none() && preset.uncertainty_mm > job.setting.accuracy_mm {
            return wrong(format!(
                "the preset of electrode {number} is measured to {} mm, and errors of setting up may take up {} mm of the spark \
                 gap (setting.accuracy_mm); measure it better",
                preset.uncertainty_mm, job.setting.accuracy_mm
            ));
        }
        if let Some(errors) = job.setting.errors() {
            let covered = errors.of_axes().into_iter().take(3).fold(f64::INFINITY, f64::min);
            if preset.uncertainty_mm > covered {
                return wrong(format!(
                    "the preset of electrode {number} is measured to {} mm, and the setting errors of X, Y and Z cover \
                     {covered} mm; measure it better, or ask for larger setting errors",
                    preset.uncertainty_mm
                ));
            }
        }
        let advance = match &electrode.plan.path {
            Some(planned) if *wear_mm > 0.0 => *wear_mm * end_direction(&planned.path, &electrode.electrode),
            _ => DVec3::ZERO,
        };
        let from = electrode.electrode.reference_point;
        let side = electrode.electrode.enters_from;
        let mounting = job.machine.mounting(side);
        let station = Station::new(&electrode.electrode.mesh, from, side, mounting, blisk);
        let table_arm_mm = station.chain().on_table_c().map(|q| (from - q).truncate().into());
        let preset = Preset { advance_mm: advance.into(), table_arm_mm, ..*preset };
        let tilts = electrode.plan.path.as_ref().is_some_and(|p| p.path.rows.iter().any(|row| row.pose.b != 0.0));
        if preset.c_deg != 0.0 && tilts {
            return wrong(format!(
                "electrode {number} stands turned by {} deg about Z on its holder, so that B would tilt it about another line \
                 than the path takes; align it on the holder, or plan on a machine without B",
                preset.c_deg
            ));
        }
        let to = preset.reference_point(from);
        electrode.electrode.reference_point = to;
        if advance != DVec3::ZERO {
            let worn = electrode.electrode.worn(advance, &task.cancel);
            electrode.worn = Some(worn.map_err(|error| match error {
                SolidError::Cancelled(cancelled) => cancelled.into(),
                error => PlanJobError::Job(format!("electrode {number}, worn by {wear_mm} mm: {error}")),
            })?);
        }
        for node in &mut electrode.plan.nodes {
            node.pose = node.pose.about(from, to);
        }
        let burning = electrode.worn.as_ref().unwrap_or(&electrode.electrode);
        if let Some(planned) = &mut electrode.plan.path {
            let path = preset.path(&planned.path);
            let limits = job.machine.seen_from_w(electrode.electrode.enters_from).pose_limits();
            let certified = |mesh: &Mesh| {
                let verifier = Verifier::new(blisk, mesh, to, &task.cancel)?.within(limits);
                Ok::<_, PlanJobError>(verifier.verify(&path, &|p| finder.surface_of(p), &job.verify, task)?)
            };
            let certificate = certified(&burning.mesh)?;
            if electrode.worn.is_some() {
                let unworn = electrode.electrode.mesh.mapped(|p| p + advance);
                electrode.unworn_mm = Some(certified(&unworn)?.certified());
            }
            (planned.path, planned.certificate) = (path, certificate);
        }
        electrode.preset = Some(preset);
    }
    Ok(outcome)
}

/// The direction in which the front of the electrode arrives in the final pose of `path`, a unit vector in W.
fn end_direction(path: &FeedPath, electrode: &Electrode) -> DVec3 {
    let out = electrode.enters_from.direction();
    let front = electrode.mesh.vertices.iter().copied().min_by(|a, b| a.dot(out).total_cmp(&b.dot(out)));
    let by_distance = |a: &&PathRow, b: &&PathRow| a.s.total_cmp(&b.s);
    let last = path.rows.iter().min_by(by_distance);
    let before = path.rows.iter().filter(|row| row.s >= END_MM).min_by(by_distance);
    let before = before.or_else(|| path.rows.iter().max_by(by_distance));
    let place = |row: &PathRow| Some(row.pose.placement(path.reference_point).transform_point3(front?));
    let arrives = last.and_then(place).zip(before.and_then(place)).map(|(last, before)| last - before);
    arrives.and_then(DVec3::try_normalize).unwrap_or(-out)
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "electrode,x_mm,y_mm,z_mm,c_deg,uncertainty_mm,date\n";

    #[test]
    fn presets_are_read_line_by_line() {
        let text = format!("{HEAD}E2,0.1,-0.02,0,0.25,0.002,2026-03-01\n\n1, 0, 0, 0, 0, 0.003,\n");
        let presets = presets_of(&text).unwrap();
        assert_eq!(presets.keys().copied().collect::<Vec<_>>(), [1, 2]);
        let preset = Preset { x_mm: 0.1, y_mm: -0.02, c_deg: 0.25, uncertainty_mm: 0.002, ..Preset::default() };
        assert_eq!(presets[&2], MeasuredElectrode { preset, wear_mm: 0.0 });
        let worn = format!("{}1,0,0,0,0,0.003,,0.08\n2,0,0,0,0,0.003,,0\n", HEAD.replace("date", "date,wear_mm"));
        assert_eq!(presets_of(&worn).unwrap().values().map(|of| of.wear_mm).collect::<Vec<_>>(), [0.08, 0.0]);
    }

    #[test]
    fn a_wrong_line_is_named() {
        for (rows, line, words) in [
            ("1,0,0,0,0,0", 2, "6 cells"),
            ("1,0,0,0,0,0,\n1,0,0,0,0,0,", 3, "electrode 1 has a preset already"),
            ("x,0,0,0,0,0,", 2, "electrode is \"x\""),
            ("1,7,0,0,0,0,", 2, "x_mm is \"7\": must be a number from -5 to 5 mm"),
            ("1,0,nan,0,0,0,", 2, "y_mm is \"nan\""),
            ("1,0,0,0,0,-1,", 2, "from 0 to 5 mm"),
        ] {
            let (at, said) = presets_of(&format!("{HEAD}{rows}")).unwrap_err();
            assert!(at == line && said.contains(words), "{rows}: line {at}: {said}");
        }
        assert_eq!(presets_of("a,b").unwrap_err().0, 1);
        let unknown = presets_of(&format!("{}1,0,0,0,0,0.003,,\n", HEAD.replace("date", "date,wear_mm")));
        assert!(unknown.unwrap_err().1.contains("wear_mm is empty"), "a wear that is not known is not 0");
    }
}
