//! `sparkpath setup-sheet`: where a job lies from what a machine touches.

use std::path::PathBuf;

use clap::Args;
use glam::{DVec2, DVec3};

use super::job_sheet::written;
use super::{Answer, numbers};
use nc::job_file::JobFile;
use nc::setup_sheet::{Datum, SetUp, TableCheck, setup_sheet};

/// A job and its datums.
#[derive(Debug, Args)]
pub(super) struct SetUpSheetArguments {
    /// The job (JSON), as job.json of an export.
    #[arg(value_name = "JOB")]
    job: PathBuf,
    /// A ball that is touched: its centre in the coordinates of the workpiece's file, and its radius (mm). May be repeated.
    #[arg(long, value_name = "X,Y,Z,R", allow_hyphen_values = true, value_parser = |text: &str| numbers::<4>(text))]
    ball: Vec<[f64; 4]>,
    /// A corner that is touched, in the coordinates of the workpiece's file (mm). May be repeated.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = |text: &str| numbers::<3>(text))]
    corner: Vec<[f64; 3]>,
    /// Step that set-up values are rounded to (mm).
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    round: Option<f64>,
    /// Y and Z of the axis of A, parallel to X, in the axes of the job (mm): the balls are told at both angles of A.
    #[arg(long, value_name = "Y,Z", allow_hyphen_values = true, value_parser = |text: &str| numbers::<2>(text))]
    a_axis: Option<[f64; 2]>,
    /// The two angles of A (degrees) as in the NC programs: of the electrode against the workpiece, so that a table turns the
    /// other way.
    #[arg(long, value_name = "FIRST,SECOND", allow_hyphen_values = true, default_value = "0,30", requires = "a_axis", value_parser = |text: &str| numbers::<2>(text))]
    a_deg: [f64; 2],
    /// File of the sheet [default: standard output].
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Writes or prints the sheet.
pub(super) fn set_up_sheet(arguments: &SetUpSheetArguments) -> anyhow::Result<Answer> {
    let ball = |&[x, y, z, radius]: &[f64; 4]| Datum { place: DVec3::new(x, y, z), radius: Some(radius) };
    let corner = |&place: &[f64; 3]| Datum { place: place.into(), radius: None };
    let setup = SetUp {
        datums: arguments.ball.iter().map(ball).chain(arguments.corner.iter().map(corner)).collect(),
        round: arguments.round,
        check: arguments
            .a_axis
            .map(|axis| TableCheck { a_axis: DVec2::from(axis), angles: arguments.a_deg.map(f64::to_radians) }),
    };
    let sheet = || Ok(setup_sheet(&JobFile::read(&arguments.job)?, &setup)?);
    written(arguments.out.as_deref(), &[&arguments.job], sheet)
}
