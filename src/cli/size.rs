//! `sparkpath size`: the least reductions with which electrodes come out.

use super::project::ProjectArguments;
use super::{Answer, Session};
use crate::workspaces::blisk::job::plan::prepare;
use crate::workspaces::blisk::job::sizing::{SizeRow, SizingRange, size as size_job};

/// Sizes the electrodes of `project` for up to `parts` parts and prints the table.
pub(super) fn size(project: &ProjectArguments, parts: usize, session: &Session) -> anyhow::Result<Answer> {
    let (inputs, _) = super::plan::load(project, session)?;
    let prepared = prepare(&inputs, &session.task)?;
    let range = SizingRange { from: 1, to: parts };
    let show = |row: &SizeRow| {
        if !session.json {
            super::terminal::finish();
            say!("{}", line(row));
        }
    };
    if !session.json {
        super::terminal::finish();
        let stage = if inputs.job.electrode.stage.is_empty() { "" } else { "  stage" };
        say!("parts  enter  low deg  high deg  thickness mm  volume mm3  certified mm{stage}");
    }
    let rows = size_job(&prepared, &inputs, range, &show, &session.task)?;
    super::terminal::finish();
    if session.json {
        say!("{}", serde_json::to_string_pretty(&rows)?);
    } else if rows.is_empty() {
        say!("Not feasible: no electrode has an extraction path at the reductions tried.");
    }
    Ok(if rows.is_empty() { Answer::No } else { Answer::Yes })
}

fn line(row: &SizeRow) -> String {
    let [low, high] = row.reduction_cells();
    let stage = row.stage.as_ref().map(|stage| format!("  {stage}")).unwrap_or_default();
    let enter = row.enter.name();
    let SizeRow { parts, least_thickness_mm, volume_mm3, certified_mm, .. } = row;
    format!(
        "{parts:>5}  {enter:>5}  {low:>7}  {high:>8}  {least_thickness_mm:>12.3}  {volume_mm3:>10.1}  \
         {certified_mm:>12.4}{stage}"
    )
}
