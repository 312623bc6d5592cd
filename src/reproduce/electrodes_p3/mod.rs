//! The results of P3: Li, Zhou, Liu and Ma, A new approach for uncut detection and automatic design of EDM electrodes
//! (2019).

mod cases;
mod demonstration;
mod drawings;
mod parts;
mod plane;

use std::fmt::Display;

use super::{Outcome, Paper, ReproduceError, Table, Verdict};
use crate::workspaces::mold::job::uncut::UncutParams;
use geometry::mesh::Mesh;
use import::stl_bytes;
use mold::cutter::{Cutter, CutterLibrary};
use mold::electrode::params::ElectrodeParams;
use task::Task;

/// The tables and figures of the paper, in its order.
pub(super) fn results(task: &Task) -> Result<Vec<Outcome>, ReproduceError> {
    let mut outcomes = drawings::outcomes();
    outcomes.extend(plane::outcomes());
    outcomes.extend(parts::outcomes(task)?);
    outcomes.extend(demonstration::outcomes(task)?);
    outcomes.sort_by_key(|outcome| {
        let (kind, number) = outcome.name.split_once(' ').unwrap_or_default();
        (kind == "Table", number.parse::<usize>().unwrap_or(usize::MAX))
    });
    outcomes.push(cases::outcome(task)?);
    Ok(outcomes)
}

/// An outcome that compares nothing yet.
fn blank(name: &str, title: &str, part: &str) -> Outcome {
    Outcome {
        name: name.to_owned(),
        title: title.to_owned(),
        part: part.to_owned(),
        verdict: Verdict::NotComparable,
        why: String::new(),
        by_hand: String::new(),
        ..Outcome::default()
    }
}

/// Same where it is so, else worse.
fn same_if(is_so: bool) -> Verdict {
    if is_so { Verdict::Same } else { Verdict::Worse }
}

/// Makes the error of the result `name` of one of the engines, or tells that the task was cancelled.
fn wrong<E: Display>(name: &'static str, task: &Task) -> impl Fn(E) -> ReproduceError {
    move |error| match task.check() {
        Err(cancelled) => cancelled.into(),
        Ok(()) => ReproduceError::Result { paper: Paper::P3, name, problem: error.to_string() },
    }
}

/// A part as a file beside the page; none where it cannot be written.
fn part_file(name: &str, mesh: &Mesh) -> Vec<(String, Vec<u8>)> {
    stl_bytes(mesh).ok().map(|bytes| (format!("p3_{name}.stl"), bytes)).into_iter().collect()
}

fn params_of(cutters: &[Cutter]) -> UncutParams {
    UncutParams::of(CutterLibrary { cutter: cutters.to_vec() })
}

/// Electrodes that are milled with a flat cutter of 0.5 mm radius.
fn electrode_params() -> ElectrodeParams {
    ElectrodeParams { cutters: Some(CutterLibrary { cutter: vec![Cutter::flat(0.5)] }), ..ElectrodeParams::default() }
}
