//! Cutter location files of flank paths: APT records that a machine's own post-processor reads.

use std::fmt::Write;

use super::approved_flank::ApprovedFlank;
use flank::machine::kinematics::ToolPose;
use flank::machine::tool_path::{Section, ToolPath, ToolPathError};

/// The longest remark line.
const LONGEST_LINE: usize = 100;

/// The APT text of the path that is milled: `GOTO/x,y,z,i,j,k` with the middle of the cutter's bottom and the unit
/// vector to the spindle, both in the workpiece's frame.
///
/// # Errors
/// [`ToolPathError`] where the path has no tool.
pub fn cl_text(approved: &ApprovedFlank) -> Result<String, ToolPathError> {
    let result = approved.result();
    let (cutter, milling) = (&result.plan.cutter, &result.milling);
    let (notes, warnings) = (approved.notes(), approved.warnings());
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
    text_of(approved.path(), &job)
}

/// Input of a cutter location file.
#[derive(Debug, Clone, Copy)]
pub(super) struct ClJob<'a> {
    /// Name of the part.
    pub(super) part: &'a str,
    /// Diameter of the cutter's bottom (mm).
    pub(super) diameter_mm: f64,
    /// Angle between the cutter's flank and its axis (degrees); 0 for a cylinder.
    pub(super) taper_deg: f64,
    /// Length of the flutes (mm).
    pub(super) flute_mm: f64,
    /// Spindle speed, clockwise (1/min).
    pub(super) spindle_rpm: f64,
    /// Feed of the tip along the cut and on the moves onto it and off it (mm/min).
    pub(super) feed_mm_per_min: f64,
    /// Feed of the other moves of approach and retraction (mm/min).
    pub(super) lead_mm_per_min: f64,
    /// The furthest that straight moves of tip and direction may leave the path (mm), up to the flutes' top.
    pub(super) tolerance_mm: f64,
    /// Remarks.
    pub(super) notes: &'a [String],
    /// Warnings.
    pub(super) warnings: &'a [String],
}

/// The APT text of any path, approved or not: for [`cl_text`] and its tests.
pub(super) fn text_of(path: &ToolPath, job: &ClJob) -> Result<String, ToolPathError> {
    let moves = path.straightened(job.tolerance_mm, job.flute_mm)?.moves;
    let mut lines = vec![format!("PARTNO/{}", plain(job.part))];
    let mut remark = |text: &str| lines.extend(wrapped(text));
    remark(&format!("Sparkpath {}: flank path, mm, workpiece frame", env!("CARGO_PKG_VERSION")));
    remark("The tool point is the middle of the cutter's bottom; i j k point to the spindle.");
    remark(&format!("Straight moves leave the path by {} mm at most at the measured places", job.tolerance_mm));
    job.notes.iter().for_each(|note| remark(note));
    job.warnings.iter().for_each(|warning| remark(&format!("WARNING: {warning}")));
    lines.push("UNITS/MM".to_owned());
    lines.push("MULTAX/ON".to_owned());
    let radius = job.diameter_mm / 2.0;
    // Diameter, corner radius, place of its centre across and along, bottom and side angle, height.
    lines.push(format!("CUTTER/{:.5},0,{radius:.5},0,0,{:.6},{:.5}", job.diameter_mm, job.taper_deg, job.flute_mm));
    lines.push(format!("SPINDL/{:.0},CLW", job.spindle_rpm));
    let (mut section, mut feed_given) = (None, 0.0);
    for (s, pose) in &moves {
        // A record belongs to the part of the move that ends there.
        let own = path.section((s - 1e-9).max(0.0));
        if section != Some(own) {
            section = Some(own);
            let name = match own {
                Section::Approach => "approach",
                Section::Cut => "cut",
                Section::Retract => "retract",
            };
            lines.push(format!("$$ {name}"));
        }
        let is_on_flank = path.is_on_flank((s - 1e-9).max(0.0));
        let feed = if is_on_flank { job.feed_mm_per_min } else { job.lead_mm_per_min };
        if feed != feed_given {
            feed_given = feed;
            lines.push(format!("FEDRAT/{feed:.3},MMPM"));
        }
        lines.push(goto(pose));
    }
    lines.extend(["SPINDL/OFF", "MULTAX/OFF", "END", "FINI"].map(str::to_owned));
    Ok(lines.join("\n") + "\n")
}

fn goto(pose: &ToolPose) -> String {
    let mut text = String::from("GOTO/");
    for (i, v) in pose.tip.to_array().into_iter().chain(pose.axis.to_array()).enumerate() {
        let decimals = if i < 3 { 6 } else { 9 };
        let step = 10f64.powi(decimals);
        let comma = if i == 0 { "" } else { "," };
        // Rounded first, so that no zero has a sign. Writing to a string cannot fail.
        let _ = write!(text, "{comma}{:.*}", decimals as usize, (v * step).round() / step + 0.0);
    }
    text
}

fn plain(text: &str) -> String {
    text.chars().map(|c| if c == ' ' || c.is_ascii_graphic() && c != '$' { c } else { '_' }).collect()
}

fn wrapped(text: &str) -> Vec<String> {
    let mut lines = vec![String::from("$$")];
    for word in plain(text).split_whitespace() {
        let last = lines.len() - 1;
        if lines[last].len() + 1 + word.len() > LONGEST_LINE && lines[last].len() > 2 {
            lines.push(String::from("$$"));
        }
        let last = lines.len() - 1;
        lines[last].push(' ');
        lines[last].push_str(word);
    }
    lines
}
