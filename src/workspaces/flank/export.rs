//! The files of a flank: cutter locations, the NC program, the path as a table, and the report. This module writes
//! files.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use crate::workspaces::flank::comparison::{self, Row};
use crate::workspaces::flank::document::FlankDocument;
use crate::workspaces::flank::document::fields::FIELDS;
use crate::workspaces::flank::report::FlankReport;
use crate::workspaces::flank::report::build::report;
use crate::workspaces::flank::report::maps::deviation_maps;
use files::ExportFolder;
use flank::path::FlankPath;
use nc::approved_flank::ApprovedFlank;
use nc::cutter_locations::cl_text;
use nc::flank_job::FlankResult;
use nc::flank_program::FlankNc;
use nc::program::is_program_for;
use task::Task;

/// The file of cutter locations.
pub const CL_FILE: &str = "flank.cl";
/// The file of the path as a table.
pub const CSV_FILE: &str = "path.csv";
/// The table of plans side by side.
pub const COMPARED_FILE: &str = "compared.csv";
/// Name of the NC program, without its ending.
pub const PROGRAM: &str = "flank";

/// The report for programs.
pub const JSON_FILE: &str = "flank.json";
/// The report for people.
pub const REPORT_FILE: &str = "report.html";
/// Name of the export in the manifest of a folder.
const EXPORT: &str = "flank";

/// Files to write.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ExportChoice {
    /// Cutter locations.
    pub cl: bool,
    /// The program of the machine.
    pub nc: bool,
    /// The path with its deviations as a table.
    pub csv: bool,
    /// The report, for people and for programs.
    pub report: bool,
}

impl ExportChoice {
    /// All files.
    pub const ALL: Self = Self { cl: true, nc: true, csv: true, report: true };

    /// Whether any file is chosen.
    pub fn any(self) -> bool {
        self.cl || self.nc || self.csv || self.report
    }
}

/// Result of an export.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WrittenFlank {
    /// The folder.
    pub folder: PathBuf,
    /// Names of the files.
    pub files: Vec<String>,
    /// Reason why there is no file to mill by; none if there is one.
    pub blocked: Option<String>,
    /// Names of the failed checks: those that block the export, or else those overridden.
    pub failing: Vec<&'static str>,
    /// What happened to files of earlier exports, in words.
    pub former: Vec<String>,
}

impl WrittenFlank {
    /// The files that were written, and those that were not with the reason.
    pub fn sentence(&self) -> String {
        let mut text = format!("{} written to {}", self.files.join(", "), self.folder.display());
        if let Some(why) = &self.blocked {
            let failing = if self.failing.is_empty() { why.clone() } else { self.failing.join(", ") };
            text += &format!("; no program was written: failed checks {failing}");
        } else if !self.failing.is_empty() {
            text += &format!("; released despite failed checks: {}", self.failing.join(", "));
        }
        for note in &self.former {
            text += &format!("; {note}");
        }
        text
    }
}

/// Writes the chosen files into `folder`, which is made if missing: the report, and the files to mill by unless a check
/// fails; with the plans beside this one. Either all files are written or none. Files of an earlier path that are not written anew do not keep their
/// names, so that they cannot be taken for files of this path.
///
/// # Errors
/// One line naming the file or the fault; cancelled.
pub fn export(
    folder: &Path,
    (result, document): (&FlankResult, &FlankDocument),
    compared: &[Row],
    choice: ExportChoice,
    task: &Task,
) -> Result<WrittenFlank, String> {
    task.report("files", 0.0, "");
    let approved = ApprovedFlank::new(result);
    let blocked = approved.as_ref().err().map(ToString::to_string);
    // All texts are made before any is written.
    let mut texts = Vec::new();
    if choice.csv && !compared.is_empty() {
        texts.push((COMPARED_FILE.to_owned(), comparison::csv(compared)));
    }
    if choice.csv && blocked.is_none() {
        texts.push((CSV_FILE.to_owned(), path_csv(result.path())));
    }
    if let Some(approved) = approved.as_ref().ok().filter(|_| choice.cl) {
        texts.push((CL_FILE.to_owned(), cl_text(approved).map_err(|e| e.to_string())?));
    }
    // Of a path that is blocked the report says why, whatever else was asked for.
    if choice.report || blocked.is_some() {
        let report = FlankReport { compared: compared.to_vec(), ..report(result, document) };
        let maps = deviation_maps(&result.plan, &task.cancel).map_err(|e| e.to_string())?;
        let json = report.json().map_err(|e| format!("the report on a flank as JSON: {e}"))?;
        texts.push((JSON_FILE.to_owned(), json));
        texts.push((REPORT_FILE.to_owned(), report.html(&maps).map_err(|e| e.to_string())?));
    }
    // The program comes last, so that it never lies beside results that it does not belong to.
    if let Some(approved) = approved.ok().filter(|_| choice.nc && result.milled().is_some()) {
        let nc = FlankNc::new(&approved, PROGRAM).map_err(|e| FIELDS.labelled(&e))?;
        texts.push((format!("{PROGRAM}.{}", nc.extension), nc.text));
    }
    let mut out = ExportFolder::open(folder, EXPORT).map_err(|e| e.to_string())?.setting_aside(is_of_a_flank);
    for (name, text) in &texts {
        task.check().map_err(|e| e.to_string())?;
        out.write(name, text.as_bytes()).map_err(|e| e.to_string())?;
    }
    let files: Vec<String> = texts.into_iter().map(|(name, _)| name).collect();
    task.check().map_err(|e| e.to_string())?;
    let former = out.publish().map_err(|e| e.to_string())?.notes();
    task.report("files", 1.0, "");
    let failing = result.checks.iter().filter(|c| !c.holds && (blocked.is_none() || !c.is_overridden));
    let failing = failing.map(|c| c.kind.name()).collect();
    Ok(WrittenFlank { folder: folder.to_owned(), files, blocked, failing, former })
}

/// Whether a file is one to mill a flank by, of any post.
fn is_of_a_flank(file: &Path) -> bool {
    let name = file.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let is_named = name.strip_prefix(PROGRAM).is_some_and(|rest| rest.starts_with('.') && !rest[1..].contains('.'));
    [CSV_FILE, CL_FILE].contains(&name) || is_named && is_program_for(file, &format!("flank path {PROGRAM}"))
}

/// The locations of a path with the deviations at the nearest samples of the grid.
pub fn path_csv(path: &FlankPath) -> String {
    let count = path.poses.len();
    let mut near: Vec<Vec<f64>> = vec![Vec::new(); count];
    for (foot, deviation) in path.feet.at.iter().zip(path.deviation.counted()) {
        let place = (foot.x * (count.max(2) - 1) as f64).round().clamp(0.0, (count.max(1) - 1) as f64) as usize;
        if let Some(near) = near.get_mut(place) {
            near.push(*deviation);
        }
    }
    let mut text = String::from(
        "t,tip_x_mm,tip_y_mm,tip_z_mm,axis_x,axis_y,axis_z,places,mean_absolute_mm,most_overcut_mm,most_undercut_mm\n",
    );
    // Writing to a string cannot fail.
    for (pose, near) in path.poses.iter().zip(&near) {
        let (tip, axis) = (pose.tip, pose.axis);
        let _ = write!(text, "{:.9},{:.6},{:.6},{:.6},", pose.t, tip.x, tip.y, tip.z);
        let _ = write!(text, "{:.9},{:.9},{:.9},{}", axis.x, axis.y, axis.z, near.len());
        if near.is_empty() {
            // Past the ends of the surface.
            text.push_str(",,,\n");
            continue;
        }
        let mean = near.iter().map(|d| d.abs()).sum::<f64>() / near.len() as f64;
        let over = near.iter().fold(0.0f64, |most, d| most.max(-d));
        let under = near.iter().fold(0.0f64, |most, d| most.max(*d));
        let _ = writeln!(text, ",{mean:.6},{over:.6},{under:.6}");
    }
    text
}
