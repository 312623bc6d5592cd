//! The files of a flank: cutter locations, the NC program, the path as a table, and the report. This module writes
//! files.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::flank::{FlankResult, Milled};
use super::flank_maps::deviation_maps;
use super::flank_report::report;
use super::plan_files::prepare;
use crate::export::files::write_atomically;
use crate::export::flank_cl::{ClJob, cl_text};
use crate::export::flank_nc::{FlankNc, FlankNcJob, milling_post};
use crate::flank::cutter::FlankCutter;
use crate::flank::path::FlankPath;
use crate::progress::{Cancel, Progress};
use crate::project::flank_params::FlankDocument;

/// The file of cutter locations.
pub const CL_FILE: &str = "flank.cl";
/// The file of the path as a table.
pub const CSV_FILE: &str = "path.csv";
/// What the NC program is called, without its ending.
pub const PROGRAM: &str = "flank";

/// What was written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WrittenFlank {
    /// The folder.
    pub folder: PathBuf,
    /// Names of the files.
    pub files: Vec<String>,
    /// Why there is nothing to mill among them; none if there is.
    pub blocked: Option<String>,
    /// Files of an earlier path that are still there, though this one has none.
    pub older: Vec<PathBuf>,
}

impl WrittenFlank {
    /// What was written, and what was not and why.
    pub fn sentence(&self) -> String {
        let mut text = format!("{} written to {}", self.files.join(", "), self.folder.display());
        if let Some(why) = &self.blocked {
            text += &format!("; nothing to mill was written ({why})");
        }
        for file in &self.older {
            text += &format!("; an older file is still there: {}", file.display());
        }
        text
    }
}

/// Makes sure that files can be written into `folder`, before anything is computed.
///
/// # Errors
/// One line naming the folder.
pub fn check_folder(folder: &Path) -> Result<(), String> {
    prepare(folder).map_err(|e| e.to_string())
}

/// Writes the report, and what can be milled unless a check fails, into `folder`, which is made if it is not there.
///
/// # Errors
/// One line naming the file or what is wrong; cancelled.
pub fn export(
    folder: &Path,
    result: &FlankResult,
    document: &FlankDocument,
    progress: &Progress,
    cancel: &Cancel,
) -> Result<WrittenFlank, String> {
    progress.report("files", 0.0, "");
    let blocked = result.why_blocked();
    // All texts are made before any is written.
    let mut texts = Vec::new();
    if blocked.is_none() {
        texts.push((CSV_FILE.to_owned(), path_csv(result.path())));
        texts.push((CL_FILE.to_owned(), cl(result)?));
        if let Some(milled) = result.milled() {
            let nc = nc(result, milled)?;
            texts.push((format!("{PROGRAM}.{}", nc.extension), nc.text));
        }
    }
    let report = report(result, document);
    let maps = deviation_maps(&result.plan, cancel).map_err(|e| e.to_string())?;
    check_folder(folder)?;
    std::fs::create_dir_all(folder)
        .map_err(|e| format!("{}: the folder cannot be made ({e}); choose another", folder.display()))?;
    for (name, text) in &texts {
        cancel.check().map_err(|e| e.to_string())?;
        write_atomically(&folder.join(name), text.as_bytes()).map_err(|e| e.to_string())?;
    }
    report.write(folder, &maps).map_err(|e| e.to_string())?;
    let mut files: Vec<String> = texts.into_iter().map(|(name, _)| name).collect();
    let extension = milling_post(&result.milling.post).map_or_else(|_| "nc".to_owned(), |post| post.extension);
    let could_be = [CSV_FILE.to_owned(), CL_FILE.to_owned(), format!("{PROGRAM}.{extension}")];
    let older = could_be.into_iter().filter(|name| !files.contains(name)).map(|name| folder.join(name));
    let older = older.filter(|file| file.exists()).collect();
    files.extend(["flank.json", "report.html"].map(str::to_owned));
    progress.report("files", 1.0, "");
    Ok(WrittenFlank { folder: folder.to_owned(), files, blocked, older })
}

/// A cutter in a few words.
pub fn cutter_words(cutter: &FlankCutter) -> String {
    let shape = if cutter.taper_deg == 0.0 {
        format!("cylinder R{} mm", cutter.radius_mm)
    } else {
        format!("cone, bottom R{} mm, {} deg from axis to flute", cutter.radius_mm, cutter.taper_deg)
    };
    let name = if cutter.name.is_empty() { String::new() } else { format!("{}: ", cutter.name) };
    format!("{name}{shape}, flutes {} mm", cutter.length_mm)
}

/// What a program's reader should know of the path.
fn notes(result: &FlankResult) -> Vec<String> {
    let path = result.path();
    let (standing, moving) = (&path.deviation, &path.envelope.deviation);
    let [nu, nv] = standing.grid;
    let ratio = if result.has_deviation() {
        format!(", {:.3} of the initial path's", result.plan.ratio(path))
    } else {
        String::new()
    };
    vec![
        format!("Flank {}, {} path", result.name, result.path.name()),
        format!("Sum of absolute deviations {:.4} mm over {nu} x {nv} places of the surface{ratio}", standing.sum),
        format!(
            "Moving cutter: overcut up to {:.4} mm, undercut up to {:.4} mm",
            (-moving.most_overcut).max(0.0),
            moving.most_undercut.max(0.0)
        ),
    ]
}

/// What is to be heeded: checks that fail and were overridden come first.
fn heeded(result: &FlankResult) -> Vec<String> {
    let overridden = result.checks.iter().filter(|c| !c.holds);
    let overridden = overridden.map(|c| format!("check {} fails, overridden: {}", c.kind.name(), c.text));
    overridden.chain(result.warnings.iter().cloned()).collect()
}

/// Cutter locations of the path that is milled, as APT text.
///
/// # Errors
/// One line.
pub fn cl(result: &FlankResult) -> Result<String, String> {
    let (cutter, milling) = (&result.plan.cutter, &result.milling);
    let path = result.tool_path().map_err(|e| e.to_string())?;
    let (notes, warnings) = (notes(result), heeded(result));
    let job = ClJob {
        part: &result.name,
        diameter_mm: 2.0 * cutter.radius_mm,
        taper_deg: cutter.taper_deg,
        flute_mm: cutter.length_mm,
        spindle_rpm: milling.program.spindle_rpm,
        feed_mm_per_min: milling.program.feed_mm_per_min,
        lead_mm_per_min: milling.program.lead_mm_per_min,
        tolerance_mm: milling.linearisation_mm,
        notes: &notes,
        warnings: &warnings,
    };
    cl_text(&path, &job).map_err(|e| e.to_string())
}

/// The NC program of the path that is milled.
///
/// # Errors
/// One line.
pub fn nc(result: &FlankResult, milled: &Milled) -> Result<FlankNc, String> {
    let path = result.tool_path().map_err(|e| e.to_string())?;
    let post = milling_post(&result.milling.post).map_err(|e| e.to_string())?;
    let (notes, warnings) = (notes(result), heeded(result));
    let job = FlankNcJob {
        program: PROGRAM,
        cutter: &cutter_words(&result.plan.cutter),
        machine: &milled.machine,
        path: &path,
        line: &milled.line,
        params: &milled.params,
        notes: &notes,
        warnings: &warnings,
    };
    FlankNc::new(&job, &post, &result.milling.program).map_err(|e| e.to_string())
}

/// The locations of a path with the deviations of the places of the grid that are nearest to each.
pub fn path_csv(path: &FlankPath) -> String {
    let count = path.poses.len();
    let mut near: Vec<Vec<f64>> = vec![Vec::new(); count];
    for (foot, deviation) in path.feet.at.iter().zip(&path.deviation.values) {
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
