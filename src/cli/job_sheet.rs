//! `sparkpath job-sheet`: text made of a job file through a template.

use std::path::{Path, PathBuf};

use clap::Args;

use super::Answer;
use nc::job_file::JobFile;
use nc::template::JobSheet;

/// A job and its template.
#[derive(Debug, Args)]
pub(super) struct JobSheetArguments {
    /// The job (JSON), as job.json of an export.
    #[arg(value_name = "JOB")]
    job: PathBuf,
    /// A template (Jinja) [default: the built-in one].
    #[arg(long, value_name = "FILE")]
    template: Option<PathBuf>,
    /// File of the text [default: standard output].
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Writes or prints the text. Where values are missing that the template requires, no file is written.
pub(super) fn job_sheet(arguments: &JobSheetArguments) -> anyhow::Result<Answer> {
    let read: Vec<&Path> =
        [Some(&arguments.job), arguments.template.as_ref()].into_iter().flatten().map(|f| &**f).collect();
    let sheet = || {
        let sheet = arguments.template.as_deref().map_or_else(|| Ok(JobSheet::standard()), JobSheet::read)?;
        Ok(sheet.of(&JobFile::read(&arguments.job)?)?)
    };
    written(arguments.out.as_deref(), &read, sheet)
}

/// Writes a sheet to `out`, which must be none of the files that are `read` for it, or prints it.
pub(super) fn written(
    out: Option<&Path>,
    read: &[&Path],
    sheet: impl FnOnce() -> anyhow::Result<String>,
) -> anyhow::Result<Answer> {
    let place = out.and_then(|out| out.canonicalize().ok());
    for file in read {
        let is_out = place.is_some() && place == file.canonicalize().ok();
        anyhow::ensure!(!is_out, "--out {}: the sheet would replace what it is made from", file.display());
    }
    let text = sheet()?;
    match out {
        Some(out) => files::write_bytes(out, text.as_bytes())?,
        // The sheet ends its own lines.
        None => say!("{}", text.strip_suffix('\n').unwrap_or(&text)),
    }
    Ok(Answer::Yes)
}
