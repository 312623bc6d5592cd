//! The results of P1.
//!
//! The part is a blisk of 60 channels, as many as the paper's: the paper states no other dimension of it. Its blades are
//! made of the paper's section: two circles joined by two polynomials of fifth order.

mod accuracy;
mod blade;
mod feed;
mod midline;

use std::fmt::Display;
use std::sync::Arc;

use glam::DVec3;

use super::{Outcome, Paper, ReproduceError, Table, Verdict};
use crate::workspaces::mold::scene::pictures::{MoldPicture, draw};
use files::report::{Picture, number};
use geometry::mesh::Mesh;
use render::offscreen::RenderError;
use task::Task;
use wheel::nurbs_wall::NurbsWall;
use wheel::parametric::{ChannelSide, MeshResolution, ParametricBlisk};
use wheel::sections::MeasuredSection;

const PAPER: Paper = Paper::P1;

/// Channels of the paper's wheel (text on figure 10).
const CHANNELS: usize = 60;

const PART: &str = "blisk of 60 channels, the only dimension that the paper states of its wheel";

/// Why nothing can be said of cells and curves that the paper shows in pictures.
const NO_CELLS: &str = "The cells of the paper's table were not available to us as text, so only ours stand here.";

/// The tables and figures of the paper.
pub(super) fn results(task: &Task) -> Result<Vec<Outcome>, ReproduceError> {
    let part = Part::new(task)?;
    let planned = feed::Planned::new(&part, task)?;
    let mut all = planned.outcomes(&part, task)?;
    all.extend(blade::outcomes(&part, task)?);
    all.push(midline::figure_6(&part, task)?);
    all.extend(accuracy::outcomes(&part, &planned.frame(), task)?);
    // As they follow each other in the paper.
    const ORDER: [&str; 15] = [
        "Figure 1",
        "Figure 2",
        "Figure 3",
        "Table 1",
        "Table 2",
        "Table 3",
        "Figure 4",
        "Figure 5",
        "Figure 6",
        "Table 4",
        "Figure 7",
        "Figure 8",
        "Table 5",
        "Figure 9",
        "Figure 10",
    ];
    all.sort_by_key(|outcome| ORDER.iter().position(|name| *name == outcome.name));
    Ok(all)
}

/// The part that everything here is computed on.
struct Part {
    blisk: ParametricBlisk,
    mesh: Arc<Mesh>,
    /// The walls of a channel as NURBS through sections of the exact blades.
    walls: [NurbsWall; 2],
}

/// Shares of the height at which the walls have their sections.
const SECTIONS: usize = 9;
/// Points of a section on each wall.
const POINTS: usize = 121;

impl Part {
    fn new(task: &Task) -> Result<Self, ReproduceError> {
        let blisk = ParametricBlisk { blades: CHANNELS, ..ParametricBlisk::default() };
        let fine = MeshResolution { edge: 8, chord: 36, span: 5, pitch: 8, ..MeshResolution::default() };
        let mesh = Arc::new(blisk.mesh(&fine).map_err(failed("Figure 1", task))?);
        let heights: Vec<f64> = (0..SECTIONS).map(|k| k as f64 / (SECTIONS - 1) as f64).collect();
        let walls = NurbsWall::of_measured(&sections(&blisk, &heights, POINTS, &|_| DVec3::ZERO), &task.cancel);
        Ok(Self { walls: walls.map_err(failed("Figure 1", task))?, blisk, mesh })
    }

    /// Radius half way between hub and shroud (mm).
    fn mean_radius(&self) -> f64 {
        0.5 * (self.blisk.hub_radius_mm + self.blisk.shroud_radius_mm)
    }
}

/// A point of a section before anything is added to it.
struct Place {
    /// Section, counted from the hub.
    section: usize,
    /// Wall: 0 low, 1 high.
    wall: usize,
    /// Number of the point on its wall, counted from the leading edge.
    index: usize,
    /// Point (mm) and unit normal into the channel.
    at: DVec3,
    normal: DVec3,
}

/// Sections of the exact blades at shares of the height with `points` on each wall, closer together at the edges, each
/// point moved by `error` (mm).
fn sections(
    blisk: &ParametricBlisk,
    heights: &[f64],
    points: usize,
    error: &dyn Fn(&Place) -> DVec3,
) -> Vec<MeasuredSection> {
    let section = |name: String| MeasuredSection { name, ..MeasuredSection::default() };
    let mut sections: Vec<MeasuredSection> = (1..=heights.len()).map(|k| section(k.to_string())).collect();
    for place in places(blisk, heights, points) {
        let MeasuredSection { low, high, .. } = &mut sections[place.section];
        let wall = if place.wall == 0 { low } else { high };
        wall.push(place.at + error(&place));
    }
    sections
}

/// The points of such sections, wall by wall.
fn places(blisk: &ParametricBlisk, heights: &[f64], points: usize) -> impl Iterator<Item = Place> {
    let along = move |i: usize| 0.5 - 0.5 * (i as f64 / (points - 1) as f64 * std::f64::consts::PI).cos();
    let walls = (0..heights.len()).flat_map(|section| (0..2).map(move |wall| (section, wall)));
    walls.flat_map(move |(section, wall)| {
        let side = [ChannelSide::Low, ChannelSide::High][wall];
        (0..points).map(move |index| {
            let [at, normal] = blisk.wall_at(side, along(index), heights[section]);
            Place { section, wall, index, at, normal }
        })
    })
}

/// An outcome that has no tables and pictures yet.
fn outcome(name: &str, title: &str, verdict: Verdict, why: impl Into<String>, by_hand: &str) -> Outcome {
    Outcome {
        name: name.to_owned(),
        title: title.to_owned(),
        part: PART.to_owned(),
        verdict,
        why: why.into(),
        by_hand: by_hand.to_owned(),
        ..Outcome::default()
    }
}

/// Numbers as cells.
fn cells(values: &[f64], decimals: usize) -> Vec<String> {
    values.iter().map(|value| number(*value, decimals)).collect()
}

/// The error of the result `name`, or that the task was cancelled.
fn failed<E: Display>(name: &'static str, task: &Task) -> impl Fn(E) -> ReproduceError {
    move |problem| match task.check() {
        Err(cancelled) => cancelled.into(),
        Ok(()) => ReproduceError::Result { paper: PAPER, name, problem: problem.to_string() },
    }
}

/// `pictures` drawn; none where nothing can be drawn.
fn drawn(pictures: Vec<MoldPicture>, task: &Task) -> Result<Vec<Picture>, ReproduceError> {
    match draw(pictures, task) {
        Err(RenderError::Cancelled(cancelled)) => Err(cancelled.into()),
        made => Ok(made.unwrap_or_default()),
    }
}
