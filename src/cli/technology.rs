//! `sparkpath technology`: a technology table, read and checked.

use std::path::Path;

use super::{Answer, Session};
use crate::workspaces::technology::read_table;
use burning::figures::gaps_of;
use burning::project::ProjectTechnology;
use burning::technology::{Step, Technology};

/// Prints the technologies of the table in `file`, or of the built-in one, with the figures that are missing.
pub(super) fn technology(file: Option<&Path>, session: &Session) -> anyhow::Result<Answer> {
    let mut project = ProjectTechnology::default();
    if let Some(file) = file {
        project.table = file.to_string_lossy().into_owned();
    }
    let table = read_table(&project)?;
    super::terminal::finish();
    if session.json {
        say!("{}", serde_json::to_string_pretty(&table)?);
        return Ok(Answer::Yes);
    }
    for technology in &table.technology {
        print(technology);
        let burns = table.calibrations_of(&technology.id).count();
        say!("  finished burns: {burns}");
    }
    Ok(Answer::Yes)
}

fn print(technology: &Technology) {
    say!("{}: {}", technology.id, technology.label());
    say!("  basis: {}", technology.basis);
    say!("  source: {}", technology.source.split_whitespace().collect::<Vec<_>>().join(" "));
    say!("  {}", HEAD.map(|head| format!("{head:>9}")).concat());
    for step in &technology.step {
        say!("  {}", cells(step).map(|cell| format!("{cell:>9}")).concat());
    }
    for missing in gaps_of(technology) {
        say!("  {missing}");
    }
}

/// Columns of the table of steps.
const HEAD: [&str; 8] = ["step", "VDI", "A", "on us", "gap mm", "mm3/min", "wear %", "stock mm"];

/// The figures of a step; what is missing is a dash.
fn cells(step: &Step) -> [String; 8] {
    let cell = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |value| value.to_string());
    [
        step.name.clone(),
        step.finish_vdi().map_or_else(|| "-".to_owned(), |vdi| format!("{vdi:.1}")),
        cell(step.ip_a),
        cell(step.on_us),
        cell(step.gap_side_mm),
        cell(step.rate_mm3_min),
        cell(step.wear_percent),
        cell(step.stock_next_mm),
    ]
}
