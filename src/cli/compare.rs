//! `sparkpath compare`: the paths of several strategies side by side.

use std::path::Path;

use clap::builder::{PossibleValuesParser, TypedValueParser};

use super::project::ProjectArguments;
use super::{Answer, Session};
use crate::workspaces::blisk::job::compare as job;
use crate::workspaces::blisk::report::comparison::{Comparison, Run};
use feed::plan_params::Strategy;
use files::ExportFolder;

/// Reads the name of a strategy.
pub(super) fn strategy() -> impl TypedValueParser<Value = Strategy> {
    let names = PossibleValuesParser::new(Strategy::ALL.iter().map(|strategy| strategy.name()));
    names.try_map(|name| Strategy::named(&name).ok_or("there is no such strategy"))
}

/// Plans `project` by each of `strategies`, or by all if none is named, and writes the comparison
/// into `out`.
pub(super) fn compare(
    project: &ProjectArguments,
    out: &Path,
    strategies: &[Strategy],
    session: &Session,
) -> anyhow::Result<Answer> {
    let (inputs, files) = super::plan::load(project, session)?;
    ExportFolder::check(out)?;
    let mut wanted: Vec<Strategy> = Vec::new();
    for &strategy in if strategies.is_empty() { Strategy::ALL } else { strategies } {
        if !wanted.contains(&strategy) {
            wanted.push(strategy);
        }
    }
    let (prepared, inputs) = super::plan::ready(inputs, session)?;
    super::terminal::finish();
    if !session.json {
        say!("strategy          electrode  from  certified mm  nodes    rows  search s  certificate s  sum objective");
    }
    let show = |run: &Run| {
        if !session.json {
            super::terminal::finish();
            lines(run).iter().for_each(|line| say!("{line}"));
        }
    };
    let runs = job::compare(&prepared, &inputs, &wanted, &show, &session.task)?;
    let comparison = job::comparison(runs, &inputs.job, files);
    let written = job::write(out, &comparison, &session.task.cancel)?;
    super::terminal::finish();
    if session.json {
        say!("{}", comparison.json()?.trim_end());
    } else {
        print_smoothness(&comparison);
        say!("files  {} in {}", written.join(", "), out.display());
    }
    Ok(if comparison.has_certified() { Answer::Yes } else { Answer::No })
}

fn lines(run: &Run) -> Vec<String> {
    let name = run.strategy.name();
    if let Some(why) = &run.failure {
        return vec![format!("{name:<16}  cannot be followed: {why}")];
    }
    let line = |e: &crate::workspaces::blisk::report::comparison::RunElectrode| {
        let clearance = e.certified_clearance_mm.map_or("-".to_owned(), |c| format!("{c:.4}"));
        let figures = format!(
            "{name:<16}  {:>9}  {:>4}  {clearance:>12}  {:>5}  {:>6}  {:>8.2}  {:>13.2}  {:>13.4}",
            e.index, e.enters_from, e.nodes, e.rows, e.search_seconds, e.certificate_seconds, e.objective_sums.total
        );
        if e.certified { figures } else { format!("{figures}  {}", e.verdict) }
    };
    run.electrodes.iter().map(line).collect()
}

fn print_smoothness(comparison: &Comparison) {
    say!("");
    say!("strategy          electrode  axis      total variation  RMS 2nd diff.   greatest  turns back");
    for run in &comparison.runs {
        for e in &run.electrodes {
            for a in e.smoothness.iter().filter(|a| a.axis != e.withdrawn.letter()) {
                say!(
                    "{:<16}  {:>9}  {} {:<6}  {:>15.4}  {:>13.6}  {:>9.6}  {:>10}",
                    run.strategy.name(),
                    e.index,
                    a.axis,
                    a.unit,
                    a.total_variation,
                    a.rms_second_difference,
                    a.max_second_difference,
                    a.sign_changes_first_difference
                );
            }
        }
    }
}
