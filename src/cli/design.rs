//! `sparkpath design`: the sets of electrodes that take the fewest hours.

use std::path::PathBuf;

use clap::Args;

use super::project::ProjectArguments;
use super::{Answer, Session};
use crate::workspaces::blisk::document::job_file::field_table::FIELDS;
use crate::workspaces::blisk::job::burning::check_ends;
use crate::workspaces::blisk::job::design::{DesignLimits, DesignRow, DesignSpace, design as design_job};
use crate::workspaces::blisk::job::plan::prepare;
use crate::workspaces::blisk::report::design::{DesignReport, SCHEMA};
use files::{Document, ExportFolder};

/// Project of the fastest of the best sets.
const FASTEST: &str = "fastest.sparkpath";

/// A job, what is tried, and what has to be kept.
#[derive(Debug, Args)]
pub(super) struct DesignArguments {
    #[command(flatten)]
    project: ProjectArguments,
    /// Folder for design.json, design.csv, design.html and fastest.sparkpath, made if it is not there.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Up to how many parts along the passage.
    #[arg(long, value_name = "N", allow_negative_numbers = true, default_value_t = 2, value_parser = clap::value_parser!(u8).range(1..=20))]
    parts: u8,
    /// Parts divided left and right as well.
    #[arg(long)]
    columns: bool,
    /// Planes between two parts as shares of the passage, beside the one that makes both equally thick.
    #[arg(long, value_name = "SHARES", allow_negative_numbers = true, value_delimiter = ',', value_parser = share)]
    planes: Vec<f64>,
    /// Radial reductions (mm) [default: that of the project].
    #[arg(long, value_name = "MM", allow_negative_numbers = true, value_delimiter = ',', value_parser = length)]
    radial: Vec<f64>,
    /// Greatest residual stock on the walls (mm) [default: any].
    #[arg(long, value_name = "MM", allow_negative_numbers = true, value_parser = length)]
    residual: Option<f64>,
    /// Least thickness of the electrodes (mm).
    #[arg(long, value_name = "MM", allow_negative_numbers = true, default_value_t = 0.0, value_parser = length)]
    thickness: f64,
}

fn share(text: &str) -> Result<f64, String> {
    let value: f64 = text.trim().parse().map_err(|_| "expected a number from 0.01 to 0.99".to_owned())?;
    if (0.01..=0.99).contains(&value) { Ok(value) } else { Err("must be from 0.01 to 0.99".to_owned()) }
}

/// The values without those that come again.
fn each_once(values: &[f64]) -> Vec<f64> {
    let mut once: Vec<f64> = Vec::new();
    for value in values {
        if !once.contains(value) {
            once.push(*value);
        }
    }
    once
}

fn length(text: &str) -> Result<f64, String> {
    let value: f64 = text.trim().parse().map_err(|_| "expected a length in mm".to_owned())?;
    if (0.0..=100.0).contains(&value) { Ok(value) } else { Err("must be from 0 to 100 mm".to_owned()) }
}

/// Searches the sets of electrodes of the job, prints each as it is certified, and writes the answer.
pub(super) fn design(arguments: &DesignArguments, session: &Session) -> anyhow::Result<Answer> {
    let (inputs, files) = super::plan::load(&arguments.project, session)?;
    ExportFolder::check(&arguments.out)?;
    anyhow::ensure!(
        arguments.planes.is_empty() || arguments.parts >= 2,
        "--planes: planes divide two parts; give --parts 2 or more"
    );
    check_ends(&inputs.job).map_err(anyhow::Error::msg)?;
    let prepared = prepare(&inputs, &session.task)?;
    let space = DesignSpace {
        most_parts: usize::from(arguments.parts),
        columns: arguments.columns,
        radial_reductions_mm: each_once(&arguments.radial),
        planes: each_once(&arguments.planes),
    };
    let limits = DesignLimits { residual_mm: arguments.residual, thickness_mm: arguments.thickness };
    let show = |row: &DesignRow| {
        if !session.json {
            super::terminal::finish();
            say!("{}", line(row));
        }
    };
    if !session.json {
        super::terminal::finish();
        say!("{HEAD}");
    }
    let design = design_job(&prepared, &inputs, &space, &limits, &show, &session.task)?;
    let fastest = design.fastest().cloned();
    let report = DesignReport {
        schema: SCHEMA,
        program_version: env!("CARGO_PKG_VERSION"),
        inputs: files,
        sentence: design.sentence(),
        limits,
        design,
        parameters: FIELDS.list(&inputs.job),
    };
    let (json, csv, html) = (report.json()?, report.csv(), report.html()?);
    let texts = [("design.json", &json), ("design.csv", &csv), ("design.html", &html)];
    session.task.check()?;
    let mut folder = ExportFolder::open(&arguments.out, "design")?;
    for (name, text) in texts {
        folder.write(name, text.as_bytes())?;
    }
    if let Some(row) = fastest {
        let mut job = inputs.job.clone();
        row.apply(&mut job);
        let text = Document::new(job).text(&folder.path(FASTEST))?;
        folder.write(FASTEST, text.as_bytes())?;
    }
    folder.publish()?;
    super::terminal::finish();
    if session.json {
        say!("{}", json.trim_end());
    } else {
        report.design.left_out.iter().for_each(|why| say!("left out: {why}"));
        say!("{}", report.sentence);
    }
    Ok(if report.design.fastest().is_some() { Answer::Yes } else { Answer::No })
}

/// Head of the table.
const HEAD: &str = "parts  columns  plane  enter  low deg  high deg  radial mm  channel min  wheel h  needed  residual mm  \
    thickness mm  note";

fn line(row: &DesignRow) -> String {
    let number = |value: Option<f64>, decimals: usize| value.map_or("-".to_owned(), |v| format!("{v:.decimals$}"));
    let reduction = |wall: usize| row.stage_cell(|stage| stage.size.reduction_cells()[wall].clone());
    let [low, high] = [reduction(0), reduction(1)];
    let note = match (&row.breaks[..], &row.no_minutes) {
        ([], Some(why)) => why.clone(),
        (breaks, _) => breaks.join("; "),
    };
    let text = format!(
        "{:>5}  {:>7}  {:>5}  {:>5}  {low:>7}  {high:>8}  {:>9}  {:>11}  {:>7}  {:>6}  {:>11}  {:>12.3}  {note}",
        row.stage_cell(|stage| stage.size.parts.to_string()),
        row.stage_cell(|stage| stage.columns.to_string()),
        row.stage_cell(|stage| number(stage.plane, 2)),
        row.stage_cell(|stage| stage.size.enter.name().to_owned()),
        row.stage_cell(|stage| stage.radial_reduction_mm.to_string()),
        number(row.channel.map(|channel| channel.mean), 1),
        row.hours_cell(),
        row.needed_cell(),
        row.residual_cell(),
        row.least_thickness_mm
    );
    text.trim_end().to_owned()
}
