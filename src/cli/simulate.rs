//! `sparkpath simulate`: the whole motion of a plan on its machine.

use std::path::Path;

use serde::Serialize;

use super::project::ProjectArguments;
use super::{Answer, Session};
use crate::workspaces::blisk::document::choice::Channels;
use crate::workspaces::blisk::export::SIMULATE;
use crate::workspaces::blisk::job::outcome::PlanOutcome;
use crate::workspaces::blisk::job::plan::run_finished;
use crate::workspaces::blisk::report::simulation::SimulationReport;
use files::ExportFolder;

/// What `simulation.json` holds.
#[derive(Serialize)]
struct Answers {
    /// Whether every electrode has a certified path on which nothing collides.
    holds: bool,
    electrodes: Vec<ElectrodeAnswer>,
}

#[derive(Serialize)]
struct ElectrodeAnswer {
    /// Number of the electrode, counted from 1.
    index: usize,
    /// What became of its path, in a sentence.
    path: String,
    /// Result of the simulation; none without a certified path.
    simulation: Option<SimulationReport>,
}

/// Plans `project` and simulates its whole motion, in `channels` if they are given.
pub(super) fn simulate(
    project: &ProjectArguments,
    channels: Option<&Channels>,
    out: Option<&Path>,
    session: &Session,
) -> anyhow::Result<Answer> {
    let (mut inputs, _) = super::plan::load(project, session)?;
    if let Some(channels) = channels {
        inputs.job.export.channels = channels.clone();
    }
    if !inputs.job.machine.has_bodies() && inputs.job.export.channels == Channels::Own {
        anyhow::bail!(
            "{}: machine.name is missing, and so there are no bodies to simulate; give --set machine.name=xyzac, a \
             machine file, or --channels",
            project.file.display()
        );
    }
    if let Some(folder) = out {
        // An older verdict must not outlive a failure of this one.
        ExportFolder::write_all(folder, SIMULATE, &[])?;
    }
    let (prepared, inputs) = super::plan::ready(inputs, session)?;
    let outcome = run_finished(&prepared, &inputs, &session.task)?;
    let answers = answers(&outcome);
    let (json, text) = (serde_json::to_string_pretty(&answers)?, text(&answers));
    if let Some(folder) = out {
        let lines = text.clone() + "\n";
        let files = [("simulation.json", json.as_bytes()), ("simulation.txt", lines.as_bytes())];
        ExportFolder::write_all(folder, SIMULATE, &files)?;
    }
    super::terminal::finish();
    say!("{}", if session.json { &json } else { &text });
    Ok(if answers.holds { Answer::Yes } else { Answer::No })
}

fn answers(outcome: &PlanOutcome) -> Answers {
    let answer = |(i, e): (usize, &crate::workspaces::blisk::job::outcome::ElectrodeOutcome)| ElectrodeAnswer {
        index: i + 1,
        path: format!("Electrode {} {}.", e.electrode.label(i), e.plan.verdict(&outcome.channel)),
        simulation: outcome.simulation(i).map(|s| SimulationReport::of(s)),
    };
    Answers {
        holds: outcome.may_be_approved() && (0..outcome.electrodes.len()).all(|i| outcome.simulation(i).is_some()),
        electrodes: outcome.electrodes.iter().enumerate().map(answer).collect(),
    }
}

fn text(answers: &Answers) -> String {
    let of = |e: &ElectrodeAnswer| match &e.simulation {
        Some(simulation) => format!("{}\n{}", e.path, simulation.text()),
        None => format!("{}\nThere is nothing to simulate without a certified path.", e.path),
    };
    answers.electrodes.iter().map(of).collect::<Vec<_>>().join("\n")
}
