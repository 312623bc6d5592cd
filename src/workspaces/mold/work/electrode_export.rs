//! The files of electrodes: their shapes, the burn table, a sheet for people and a report with pictures.

use std::path::{Path, PathBuf};

use super::design::Designed;
use super::steps::LoadedMold;
use super::uncut_export::drawn;
use crate::workspaces::mold::export::{EXPORT, ElectrodeForms, export_electrodes};
use crate::workspaces::mold::job::divisions::WayResult;
use crate::workspaces::mold::report::steps::steps;
use crate::workspaces::mold::report::{ElectrodesPage, ElectrodesReport};
use crate::workspaces::mold::scene::pictures::electrode_pictures;
use files::ExportFolder;
use mold::datum::Datum;
use mold::electrode::design::ElectrodeSet;
use mold::electrode::design::IdleOverride;
use nc::electrode_files::LeftOut;
use task::Task;

/// Result of an export.
#[derive(Debug)]
pub struct Exported {
    folder: PathBuf,
    files: usize,
    left_out: Vec<LeftOut>,
    /// What happened to files of earlier exports, in words.
    former: Vec<String>,
    /// Overrides that no longer hold, in words.
    lapsed: Vec<String>,
    /// Reason why there is no burn sheet.
    no_sheet: Option<String>,
    /// Reason why there are no pictures.
    no_pictures: Option<String>,
}

impl Exported {
    /// The files that were written, and those that were not with the reason.
    pub fn sentence(&self) -> String {
        let plural = if self.files == 1 { "" } else { "s" };
        let mut text = format!("{} file{plural} and the burn table written to {}", self.files, self.folder.display());
        for left in &self.left_out {
            let kind = left.format.map_or_else(String::new, |f| format!(" as {}", f.extension().to_uppercase()));
            text += &format!("; {} left out{kind} ({})", left.electrode, left.why);
        }
        for note in self.former.iter().chain(&self.lapsed) {
            text += &format!("; {note}");
        }
        if let Some(why) = &self.no_sheet {
            text += &format!("; no burn sheet: {why}");
        }
        if let Some(why) = &self.no_pictures {
            text += &format!("; no pictures: {why}");
        }
        text
    }
}

/// Writes all files into `folder`, which is made if missing. Blocked electrodes have no file.
///
/// # Errors
/// One line naming the file.
pub(super) fn export(
    folder: &Path,
    (set, designed, divisions): (&ElectrodeSet, &Designed, Option<&Vec<WayResult>>),
    (mold, datum): (&LoadedMold, &Datum),
    forms: &ElectrodeForms,
    task: &Task,
) -> Result<Exported, String> {
    let opened = ExportFolder::open(folder, EXPORT).map_err(|e| e.to_string())?;
    let pictures = electrode_pictures(set, &designed.shapes, &mold.shape, designed.opening);
    let (pictures, no_pictures) = drawn(pictures, task)?;
    let mut report = ElectrodesReport::of(set, &mold.name, designed.opening, datum, designed.report.is_certain);
    report.table.notes.extend(mold.report.notes().chain(designed.doubts.clone()));
    report.divisions = divisions.cloned();
    task.check().map_err(|e| e.to_string())?;
    let page = ElectrodesPage { times: &steps(&designed.times), pictures: &pictures };
    let (written, published) =
        export_electrodes(opened, (set, &report), forms, &page, task).map_err(|e| e.to_string())?;
    let idle = set.idle_overrides(&set.params.overrides).into_iter();
    let lapsed = idle.filter(|(_, why)| matches!(why, IdleOverride::Lapsed(_)));
    let lapsed = lapsed.map(|(o, why)| format!("override of {o}: {why}")).collect();
    Ok(Exported {
        lapsed,
        folder: folder.to_owned(),
        files: written.files.len(),
        former: published.notes(),
        left_out: written.left_out,
        no_sheet: written.no_sheet,
        no_pictures,
    })
}
