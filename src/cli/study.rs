//! `sparkpath study`: a command on many variants of a project.

use std::path::PathBuf;

use clap::Args;

use super::{Answer, Internal, Session};
use crate::study::answer::Answer as PointAnswer;
use crate::study::folder::{Counts, Ran, StudyError, StudyFolder};
use crate::study::table::{CSV, PAGE};
use files::paths::user_folder;

/// A study and what is done with it.
#[derive(Debug, Args)]
pub(super) struct StudyArguments {
    /// A study (TOML), or the folder of one that was set up before.
    #[arg(value_name = "STUDY|DIR")]
    study: PathBuf,
    /// Folder of the study, made if it is not there. A study that was stopped goes on in it.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Sets up the folder, and runs nothing: for Snakemake, on one machine or many.
    #[arg(long, group = "part")]
    set_up: bool,
    /// Runs this point, counted from 1, and writes its answer.
    #[arg(long, value_name = "N", group = "part")]
    point: Option<usize>,
    /// Makes the table and its page of the answers that there are.
    #[arg(long, group = "part")]
    collect: bool,
    /// Tells how many points have an answer.
    #[arg(long, group = "part")]
    status: bool,
}

/// Sets up the study or opens its folder, and does what is asked: all of it, or a part.
pub(super) fn study(arguments: &StudyArguments, session: &Session) -> anyhow::Result<Answer> {
    let study = opened(arguments, session)?;
    if let Some(point) = arguments.point {
        return run_point(&study, point, session);
    }
    if arguments.set_up {
        tell(&study, study.counts(&study.answers()?), &format!("set up in {}", study.folder().display()), session)?;
        return Ok(Answer::Yes);
    }
    if arguments.status {
        tell(&study, study.counts(&study.answers()?), "", session)?;
        return Ok(Answer::Yes);
    }
    if !arguments.collect {
        let Ran { failed, is_stopped } = run_all(&study, session)?;
        if is_stopped {
            let written = "the points done by then stay, and the same command goes on with the others";
            return Ok(Answer::Stopped { stage: "study", written });
        }
        if let Some((point, why)) = failed.first() {
            let others = if failed.len() > 1 { format!(" and {} more", failed.len() - 1) } else { String::new() };
            return Err(
                Internal(format!("point {point}{others} failed and is tried again by the next run: {why}")).into()
            );
        }
    }
    let table = study.collect().map_err(told)?;
    super::terminal::finish();
    let sentence = table.sentence();
    let files = format!("files  {CSV}, {PAGE} in {}", study.folder().display());
    if !session.json {
        say!("{files}");
    }
    tell(&study, table.counts, sentence.strip_prefix(&table.counts.sentence()).unwrap_or_default(), session)?;
    Ok(if table.counts.bad == 0 { Answer::Yes } else { Answer::No })
}

/// The folder of the study, set up if that is asked for.
fn opened(arguments: &StudyArguments, session: &Session) -> anyhow::Result<StudyFolder> {
    let (study, is_folder) = (&arguments.study, arguments.study.is_dir());
    let name = study.display();
    match &arguments.out {
        Some(_) if is_folder => {
            anyhow::bail!("--out: {name} is the folder of a study, whose results stay in it; leave --out away")
        }
        None if !is_folder => {
            anyhow::ensure!(study.exists(), "{name}: there is no study and no folder of that name");
            anyhow::bail!("{name}: give the folder for the points with --out DIR")
        }
        Some(out) => StudyFolder::create(study, out, session.seed, user_folder().as_deref()).map_err(told),
        None => {
            anyhow::ensure!(
                session.seed.is_none(),
                "--seed: the seed of a study that is set up is that of its project; set up another one"
            );
            StudyFolder::open(study).map_err(told)
        }
    }
}

/// The error with the exit code of its kind.
fn told(error: StudyError) -> anyhow::Error {
    match error {
        StudyError::Internal(why) => Internal(why).into(),
        other => other.into(),
    }
}

fn run_point(study: &StudyFolder, point: usize, session: &Session) -> anyhow::Result<Answer> {
    let answer = study.run_point(point, &session.task).map_err(told)?;
    super::terminal::finish();
    if session.json {
        say!("{}", serde_json::to_string_pretty(&answer)?);
    } else {
        say!("point {point}  {}", study.words(point));
        say!("{}", answer.sentence);
    }
    match answer.exit_code {
        0 => Ok(Answer::Yes),
        3 => Ok(Answer::No),
        _ => anyhow::bail!("point {point}: {}", answer.sentence),
    }
}

fn run_all(study: &StudyFolder, session: &Session) -> anyhow::Result<Ran> {
    let show = |answer: &PointAnswer| {
        if session.json {
            return;
        }
        super::terminal::finish();
        let word = match answer.exit_code {
            0 => "feasible".to_owned(),
            3 => "not feasible".to_owned(),
            _ => format!("bad: {}", answer.sentence),
        };
        say!("point {:>6}  {:>8.1} s  {}  {word}", answer.point, answer.seconds, study.words(answer.point));
    };
    study.run(rayon::current_num_threads(), &session.task, &show).map_err(told)
}

/// Prints how many points have which answer, with `more`.
fn tell(study: &StudyFolder, counts: Counts, more: &str, session: &Session) -> anyhow::Result<()> {
    super::terminal::finish();
    if session.json {
        let folder = study.folder().display().to_string();
        say!("{}", serde_json::to_string_pretty(&serde_json::json!({ "folder": folder, "counts": counts }))?);
    } else {
        say!("{}", format!("{} {}", counts.sentence(), more.trim()).trim_end());
    }
    Ok(())
}
