//! `sparkpath reproduce`: the results of the papers beside ours.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};

use super::{Answer, Session};
use crate::reproduce::{PAGE_FILE, Paper, reproduce as compute, write};
use files::ExportFolder;

/// What is to be reproduced.
#[derive(Debug, Args)]
pub(super) struct ReproduceArguments {
    /// Folder for reproduction.html, reproduction.json and other files, made if it is not there.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Paper; once for each [default: all].
    #[arg(long, value_name = "NAME", value_parser = paper())]
    paper: Vec<Paper>,
}

fn paper() -> impl TypedValueParser<Value = Paper> {
    let names = PossibleValuesParser::new(Paper::ALL.iter().map(|paper| paper.name()));
    names.try_map(|name| Paper::ALL.into_iter().find(|p| p.name() == name).ok_or("there is no such paper"))
}

/// Computes the results of the papers and writes the page.
pub(super) fn reproduce(arguments: &ReproduceArguments, session: &Session) -> anyhow::Result<Answer> {
    ExportFolder::check(&arguments.out)?;
    let mut papers = if arguments.paper.is_empty() { Paper::ALL.to_vec() } else { arguments.paper.clone() };
    papers.sort_unstable();
    papers.dedup();
    let results = compute(&papers, &session.task)?;
    let written = write(&arguments.out, &results)?;
    super::terminal::finish();
    if session.json {
        say!("{}", serde_json::json!({ "files": written }));
        return Ok(Answer::Yes);
    }
    say!("paper  table or figure  ours is             subject");
    for (of, outcome) in results.iter().flat_map(|of| of.outcomes.iter().map(move |outcome| (of, outcome))) {
        say!("{:<6} {:<16} {:<19} {}", of.paper.name(), outcome.name, outcome.verdict.words(), outcome.title);
    }
    say!("files  {} and {} others in {}", PAGE_FILE, written.len().saturating_sub(1), arguments.out.display());
    Ok(Answer::Yes)
}
