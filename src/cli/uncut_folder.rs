//! `sparkpath uncut FOLDER`: what milling cutters leave of every mold in a folder.

use std::path::Path;
use std::time::Instant;

use super::uncut::{AskedMold, MoldArguments};
use super::{Answer, Session};
use crate::panic_text;
use crate::workspaces::mold::job::uncut::uncut as find_uncut;
use crate::workspaces::mold::paths::meshes_in;
use crate::workspaces::mold::report::corpus::{Corpus, CorpusFigures, CorpusRow};
use files::ExportFolder;
use task::Task;

/// Finds what the cutters leave of every mesh in `folder` with what `mold` asks for, prints one table and writes it into
/// `out` if there is one. A mold that fails does not end the work. The answer is no if one failed.
pub(super) fn uncut_folder(
    folder: &Path,
    mold: &MoldArguments,
    out: Option<&Path>,
    session: &Session,
) -> anyhow::Result<Answer> {
    let files = meshes_in(folder).map_err(|why| anyhow::anyhow!("{}: {why}", folder.display()))?;
    out.map_or(Ok(()), ExportFolder::check)?;
    mold.of_file(&files[0])?.check()?;
    let mut corpus = Corpus { folder: folder.display().to_string(), molds: files.len(), rows: Vec::new() };
    let silent = Task::silent(&session.task.cancel);
    for (i, file) in files.iter().enumerate() {
        let start = Instant::now();
        let name = file.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        session.task.report("molds", i as f64 / files.len() as f64, &name);
        let figures = || -> anyhow::Result<CorpusFigures> {
            let AskedMold { params, imported, .. } = mold.of_file(file)?.read(|_| Ok(()), session)?;
            let found = find_uncut(&imported.mesh, &params.uncut(), &silent)?;
            Ok(CorpusFigures::of(&imported.mesh, &found))
        };
        let figures = std::panic::catch_unwind(std::panic::AssertUnwindSafe(figures));
        if session.task.cancel.is_cancelled() {
            break;
        }
        let figures = match figures {
            Ok(figures) => figures.map_err(|error| error.to_string()),
            Err(panic) => Err(format!("internal error: {}", panic_text(&*panic))),
        };
        corpus.rows.push(CorpusRow::of(name, figures, start.elapsed().as_secs_f64()));
    }
    out.map(|out| corpus.write(out)).transpose()?;
    super::terminal::finish();
    if session.json {
        say!("{}", serde_json::to_string_pretty(&corpus)?);
    } else {
        say!("{}", corpus.text().trim_end());
    }
    Ok(match corpus.rows.len() < files.len() {
        true => Answer::Stopped { stage: "folder", written: "the molds done before that are in the table" },
        false if corpus.is_whole() => Answer::Yes,
        false => Answer::No,
    })
}
