//! Writes the results of a plan into a folder.

use std::path::{Path, PathBuf};

use super::plan::{ElectrodeOutcome, PlanOutcome};
use crate::export::approved::{Approved, NotApproved};
use crate::export::files::{WriteError, write_atomically};
use crate::export::nc::{NcError, NcJob, NcProgram};
use crate::export::path_csv::{PathCsvError, write_path_csv};
use crate::export::post::{Post, PostError};
use crate::export::report::{Report, ReportError};
use crate::mesh_io::stl_bytes;
use crate::project::PlanJob;

/// Why results cannot be written.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum PlanFilesError {
    #[error(transparent)]
    Write(#[from] WriteError),
    #[error("{path}: the folder cannot be made or cleared ({source}); give another with --out")]
    Folder { path: PathBuf, source: std::io::Error },
    #[error("the electrode cannot be written as STL: {0}")]
    Electrode(std::io::Error),
    #[error(transparent)]
    Report(#[from] ReportError),
    #[error(transparent)]
    Csv(#[from] PathCsvError),
    #[error(transparent)]
    Post(#[from] PostError),
    #[error(transparent)]
    Nc(#[from] NcError),
    #[error("the path of electrode {electrode} was certified but cannot be approved: {source}")]
    NotApproved { electrode: usize, source: NotApproved },
}

/// Makes everything first and then writes it, so that an error or an interruption leaves no mixture behind. Files
/// of an earlier plan in the folder are removed: an old program must not stand beside a new report. Returns
/// the names of the files.
///
/// A path that is not verified is written for study as `path_K.unverified.csv`, and never as NC.
pub fn write(
    folder: &Path,
    outcome: &PlanOutcome,
    job: &PlanJob,
    post: &Post,
    mut report: Report,
) -> Result<Vec<String>, PlanFilesError> {
    let mut files: Vec<(String, Vec<u8>)> = Vec::new();
    for (i, electrode) in outcome.electrodes.iter().enumerate() {
        let own = electrode_files(i + 1, electrode, outcome, job, post)?;
        report.electrodes[i].files = own.iter().map(|(name, _)| name.clone()).collect();
        files.extend(own);
    }
    files.push(("report.json".to_owned(), report.json()?.into_bytes()));
    files.push(("report.html".to_owned(), report.html().into_bytes()));
    let unusable = |source| PlanFilesError::Folder { path: folder.to_owned(), source };
    std::fs::create_dir_all(folder).map_err(unusable)?;
    remove_results(folder).map_err(unusable)?;
    for (name, bytes) in &files {
        write_atomically(&folder.join(name), bytes)?;
    }
    Ok(files.into_iter().map(|(name, _)| name).collect())
}

fn electrode_files(
    k: usize,
    outcome: &ElectrodeOutcome,
    whole: &PlanOutcome,
    job: &PlanJob,
    post: &Post,
) -> Result<Vec<(String, Vec<u8>)>, PlanFilesError> {
    let electrode_file = format!("electrode_{k}.stl");
    let in_mesh_frame = outcome.electrode.mesh.in_parent_of(&whole.channel.frame);
    let mut files = vec![(electrode_file.clone(), stl_bytes(&in_mesh_frame).map_err(PlanFilesError::Electrode)?)];
    let Some(planned) = &outcome.plan.path else { return Ok(files) };
    let csv = write_path_csv(&planned.path, &planned.certificate.row_clearance)?.into_bytes();
    if !planned.certificate.holds() {
        files.push((format!("path_{k}.unverified.csv"), csv));
        return Ok(files);
    }
    files.push((format!("path_{k}.csv"), csv));
    let approved = Approved::new(planned.path.clone(), planned.certificate.clone())
        .map_err(|source| PlanFilesError::NotApproved { electrode: k, source })?;
    let nc_job = NcJob {
        program: &format!("path_{k}"),
        electrode_file: &electrode_file,
        electrode: outcome.electrode.mesh.bounds(),
        axes: job.machine.axes.axes(),
    };
    let program = NcProgram::new(&approved, post, &job.export.nc, &nc_job)?;
    files.push((format!("path_{k}.{}", program.extension()), program.text().as_bytes().to_vec()));
    Ok(files)
}

/// Removes what an earlier plan may have written.
fn remove_results(folder: &Path) -> std::io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name();
        let name = name.to_string_lossy();
        let ours = name == "report.json"
            || name == "report.html"
            || numbered(&name, "electrode_").is_some_and(|rest| rest == ".stl")
            || numbered(&name, "path_").is_some_and(|rest| rest.starts_with('.'));
        if ours && entry.file_type()?.is_file() {
            std::fs::remove_file(entry.path())?;
        }
    }
    Ok(())
}

/// What follows `prefix` and a number in `name`.
fn numbered<'a>(name: &'a str, prefix: &str) -> Option<&'a str> {
    let rest = name.strip_prefix(prefix)?;
    let end = rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len());
    (end > 0).then(|| &rest[end..])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_results_of_a_plan_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        let names = ["electrode_1.stl", "path_12.csv", "path_1.unverified.csv", "path_2.nc", "report.json"];
        let others = ["electrode_x.stl", "path_.csv", "electrode_1.stl.bak", "part.stl", "report.txt"];
        for name in names.iter().chain(&others) {
            std::fs::write(folder.path().join(name), "x").unwrap();
        }
        remove_results(folder.path()).unwrap();
        assert!(names.iter().all(|n| !folder.path().join(n).exists()));
        assert!(others.iter().all(|n| folder.path().join(n).exists()));
    }
}
