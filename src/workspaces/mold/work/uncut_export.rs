//! The files of uncut regions: figures, surface, segments, and a page with pictures.

use std::path::Path;

use super::steps::{FoundUncut, LoadedMold};
use crate::workspaces::mold::export::UncutFiles;
use crate::workspaces::mold::report::steps::steps;
use crate::workspaces::mold::report::uncut::{ComparisonReport, UncutPage};
use crate::workspaces::mold::scene::pictures::{MoldPicture, UncutShapes, draw, uncut_pictures};
use files::report::Picture;
use render::offscreen::RenderError;
use task::Task;

/// Writes all files of the regions `found`, with a comparison if there is one, into `folder`, which is made if missing.
/// Returns what was written, in a sentence.
///
/// # Errors
/// One line naming the file.
pub(super) fn export(
    folder: &Path,
    found: &FoundUncut,
    comparison: Option<&ComparisonReport>,
    mold: &LoadedMold,
    task: &Task,
) -> Result<String, String> {
    let shapes = UncutShapes { mold: &mold.shape, regions: &found.shapes, invert: found.invert.as_ref() };
    let pictures = uncut_pictures(&mold.mesh, &found.uncut, &shapes, &task.cancel).map_err(|e| e.to_string())?;
    let (pictures, no_pictures) = drawn(pictures, task)?;
    task.check().map_err(|e| e.to_string())?;
    let runs = found.uncut.classed_runs(&mold.mesh, &task.cancel).map_err(|e| e.to_string())?;
    let notes: Vec<String> = mold.report.notes().collect();
    let times = steps(&found.times);
    let files = UncutFiles {
        uncut: &found.uncut,
        runs: &runs,
        report: &found.report,
        sha256: &mold.file.sha256,
        import: &mold.report,
        page: UncutPage { mold: &mold.name, notes: &notes, comparison, times: &times, pictures: &pictures },
    };
    let published = files.write(folder).map_err(|e| e.to_string())?;
    let mut text = format!("rest material written to {}", folder.display());
    for note in published.notes() {
        text += &format!("; {note}");
    }
    if let Some(why) = no_pictures {
        text += &format!("; no pictures: {why}");
    }
    Ok(text)
}

/// Pictures for a page, or none and the reason why nothing can be drawn here.
///
/// # Errors
/// One line if the task is cancelled.
pub(super) fn drawn(pictures: Vec<MoldPicture>, task: &Task) -> Result<(Vec<Picture>, Option<String>), String> {
    match draw(pictures, task) {
        Ok(pictures) => Ok((pictures, None)),
        Err(RenderError::Cancelled(cancelled)) => Err(cancelled.to_string()),
        Err(error) => Ok((Vec::new(), Some(error.to_string()))),
    }
}
