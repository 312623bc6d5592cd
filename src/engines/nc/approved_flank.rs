//! The only door to programs and cutter locations of a flank: a result whose every check holds, or was overridden by
//! name.

use crate::flank_job::FlankResult;
use flank::machine::tool_path::{ToolPath, ToolPathError};
use flank::plan::WITHIN_ROUNDING;

/// A flank that may be milled. It can only be made by [`ApprovedFlank::new`], and the result that it holds is one that
/// nobody can change: path, side, machine, positions, tolerance and warnings are those that were checked.
///
/// ```compile_fail,E0451
/// use nc::approved_flank::ApprovedFlank;
/// use nc::flank_job::FlankResult;
/// fn approve(result: &FlankResult) -> ApprovedFlank<'_> {
///     ApprovedFlank { result, path: result.tool_path().unwrap() }
/// }
/// ```
///
/// ```compile_fail,E0308
/// use nc::flank_job::FlankResult;
/// fn unapproved(result: &FlankResult) {
///     let _ = nc::flank_program::FlankNc::new(result, "flank");
/// }
/// ```
///
/// ```compile_fail,E0308
/// use nc::flank_job::FlankResult;
/// fn unapproved(result: &FlankResult) {
///     let _ = nc::cutter_locations::cl_text(result);
/// }
/// ```
pub struct ApprovedFlank<'a> {
    result: &'a FlankResult,
    path: ToolPath<'a>,
}

/// Reason why a flank may not be milled.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NotApprovedFlank {
    /// Checks fail that were not overridden: their names and findings.
    #[error("{0}")]
    Checks(String),
    /// Checks were taken on a coarse grid.
    #[error("the flank was checked on a coarse grid for a preview only; plan it")]
    Preview,
    /// The path cannot be described by poses of a tool.
    #[error(transparent)]
    Path(#[from] ToolPathError),
}

impl<'a> ApprovedFlank<'a> {
    /// Approves a flank on the strength of its checks.
    ///
    /// # Errors
    /// [`NotApprovedFlank`] if a check fails that is not overridden by name for what it finds, if the checks are those
    /// of a quick look, or if the path has no tool.
    pub fn new(result: &'a FlankResult) -> Result<Self, NotApprovedFlank> {
        if let Some(failed) = result.why_blocked() {
            return Err(NotApprovedFlank::Checks(failed));
        }
        if result.is_preview {
            return Err(NotApprovedFlank::Preview);
        }
        Ok(Self { result, path: result.tool_path()? })
    }

    /// The flank that was checked.
    pub fn result(&self) -> &'a FlankResult {
        self.result
    }

    /// The path with its leads.
    pub fn path(&self) -> &ToolPath<'a> {
        &self.path
    }

    /// Notes on the path for the reader of a program.
    pub fn notes(&self) -> Vec<String> {
        let result = self.result;
        let standing = &result.path().deviation;
        let ([nu, nv], [overcut, undercut]) = (standing.counted_grid(), result.moving_most());
        let ratio = match result.plan.share(standing.sum) {
            Some(share) => format!(", {share:.3} of the initial path's"),
            None => format!(", {WITHIN_ROUNDING}"),
        };
        vec![
            format!("Flank {}, {} path", result.name, result.path.name()),
            format!("{} milling with the spindle clockwise (M03)", capital(result.milling.cut.name())),
            format!("Sum of absolute deviations {:.4} mm over {nu} x {nv} places of the surface{ratio}", standing.sum),
            format!("Moving cutter: overcut up to {overcut:.4} mm, undercut up to {undercut:.4} mm"),
        ]
    }

    /// Warnings: checks that fail and were overridden, with their findings, come first.
    pub fn warnings(&self) -> Vec<String> {
        let overridden = self.result.checks.iter().filter(|c| !c.holds);
        let overridden = overridden.map(|c| format!("check {} fails, overridden: {}", c.kind.name(), c.text));
        overridden.chain(self.result.warnings.iter().cloned()).collect()
    }
}

fn capital(word: &str) -> String {
    let mut letters = word.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}
