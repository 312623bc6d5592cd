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
    let is_read = |file: &Path| {
        let out = arguments.out.as_ref().and_then(|out| out.canonicalize().ok());
        out.is_some() && out == file.canonicalize().ok()
    };
    for file in [Some(&arguments.job), arguments.template.as_ref()].into_iter().flatten() {
        anyhow::ensure!(!is_read(file), "--out {}: the sheet would replace what it is made from", file.display());
    }
    let sheet = arguments.template.as_deref().map_or_else(|| Ok(JobSheet::standard()), JobSheet::read)?;
    let text = sheet.of(&JobFile::read(&arguments.job)?)?;
    match &arguments.out {
        Some(out) => files::write_bytes(out, text.as_bytes())?,
        // The sheet ends its own lines.
        None => say!("{}", text.strip_suffix('\n').unwrap_or(&text)),
    }
    Ok(Answer::Yes)
}
