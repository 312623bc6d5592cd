//! The report on a flank path, as `flank.json` for programs and `report.html` for people.

pub mod build;
pub mod maps;
mod page;

use std::collections::BTreeMap;

use serde::Serialize;

use crate::workspaces::flank::comparison::Row;
use files::ParameterList;
use files::report::{PageError, Picture, png_url};
use flank::cutter::FlankCutter;
use flank::deviation::Deviation;
use geometry::nurbs::FitError;

/// Version of the keys of `flank.json`.
pub const SCHEMA: u32 = 2;

/// Content of the report on a flank path. Lengths in mm, places in the axes of the surface.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FlankReport {
    /// [`SCHEMA`].
    pub schema: u32,
    /// Version of the program.
    pub program_version: &'static str,
    /// Name of the flank.
    pub name: String,
    /// The result in a sentence.
    pub sentence: String,
    /// Whether every check holds.
    pub holds: bool,
    /// Reason why no path was exported; none if there is no obstacle.
    pub blocked: Option<String>,
    /// The surface.
    pub surface: SurfaceEntry,
    /// The cutter.
    pub cutter: FlankCutter,
    /// Places along u and v of the surface at which deviations are taken.
    pub grid: [usize; 2],
    /// The first locations.
    pub locations: LocationsEntry,
    /// Greatest overcut and undercut (mm) of the path that is milled as the cutter moves, on `grid` or on that of the
    /// checks, whichever is worse.
    pub moving_most_mm: [f64; 2],
    /// The initial path, that of the best rank, the refined one.
    pub paths: Vec<PathEntry>,
    /// Ratios of the paper's method, on its own grids.
    pub paper: PaperEntry,
    /// Sums over ranks.
    pub ranks: RanksEntry,
    /// Checks of the path that is milled.
    pub checks: Vec<CheckEntry>,
    /// Clearances of the path that is milled.
    pub clearances: Vec<ClearanceEntry>,
    /// Plans beside this one: with other cutters, or at steps of a quantity.
    pub compared: Vec<Row>,
    /// Positions of the path on the machine; none without a machine.
    pub machine: Option<MachineEntry>,
    /// Warnings.
    pub warnings: Vec<String>,
    /// Every parameter, defaults included.
    pub parameters: ParameterList,
}

/// A surface.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SurfaceEntry {
    /// Source of the surface, in words.
    pub source: String,
    /// Side of the cutter as u runs: +1 where R_u x R_v points to, -1 on the other.
    pub side: i8,
    /// Whether u, along the cutter's travel, runs against the guides as they were given.
    pub is_reversed: bool,
    /// Least and greatest length of its rulings (mm).
    pub ruling_mm: [f64; 2],
    /// Lengths of the lower and the upper guide (mm).
    pub guide_mm: [f64; 2],
    /// Fit of the surface to a face; none for guides.
    pub fit: Option<FitEntry>,
}

/// The fit of a surface to a face.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FitEntry {
    /// Whether the face is ruled within the tolerance.
    pub is_ruled: bool,
    /// The tolerance (mm).
    pub tolerance_mm: f64,
    /// Distances of the face from the surface.
    pub error: FitError,
    /// Distances of the corners of triangles alone.
    pub error_corners: FitError,
    /// Place of the greatest distance (mm).
    pub worst: [f64; 3],
    /// Greatest distance of the triangles from a smooth surface (mm).
    pub chord_mm: f64,
    /// The fit in words.
    pub words: Vec<String>,
}

/// The first locations of the cutter.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LocationsEntry {
    /// Number of locations.
    pub count: usize,
    /// Locations with all required contacts.
    pub touching: usize,
    /// Locations without all required contacts, placed nearest to them.
    pub nearest: usize,
    /// u of the first and of the last contact on the lower guide.
    pub u0_range: [f64; 2],
    /// Control points of each of the two curves through them.
    pub control_points: usize,
    /// Requested control points; around a ring there may be more.
    pub control_points_asked: usize,
    /// Greatest distance of these curves from the locations (mm).
    pub fit_mm: f64,
}

/// A path.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PathEntry {
    /// initial, chosen or refined.
    pub name: &'static str,
    /// Whether this path is milled.
    pub is_milled: bool,
    /// Sum of the path as a share of the initial path's; none if that is nothing but rounding.
    pub ratio: Option<f64>,
    /// Sum of the moving cutter on the path as a share of its sum on the initial path; none as for `ratio`.
    pub moving_ratio: Option<f64>,
    /// Figures of the standing cutter.
    pub standing: Figures,
    /// Figures of the moving cutter: its true envelope.
    pub moving: Figures,
    /// Greatest difference between both at one place (mm).
    pub greatest_difference_mm: f64,
    /// Places that the moving cutter does not touch.
    pub without: usize,
    /// Whether the path covers the surface.
    pub covers: bool,
    /// Least and greatest t that stand over the surface.
    pub t_range: [f64; 2],
    /// Least and greatest height above the cutter's bottom that touches (mm).
    pub height_range_mm: [f64; 2],
    /// How far below the curve of `control_lower` the bottom's centre is, along the axis (mm).
    pub below_mm: f64,
    /// Whether the curves of the axis are closed, around a closed surface.
    pub is_closed: bool,
    /// Control points of the curve of the axis at the lower guide (mm), of a uniform cubic B-spline over t: clamped, or
    /// periodic if it is closed, where the points 0, 1, 2 come again after the last.
    pub control_lower: Vec<[f64; 3]>,
    /// Control points of the curve of the upper end of the axis (mm), as in `control_lower`.
    pub control_upper: Vec<[f64; 3]>,
}

/// Figures of deviations (mm) over the grid.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[allow(missing_docs)]
pub struct Figures {
    pub sum_mm: f64,
    pub mean_absolute_mm: f64,
    pub rms_mm: f64,
    /// Greatest overcut, as a positive number (mm).
    pub most_overcut_mm: f64,
    pub most_undercut_mm: f64,
    pub sum_overcut_mm: f64,
    pub sum_undercut_mm: f64,
}

impl Figures {
    /// Figures of `deviation`.
    pub fn of(deviation: &Deviation) -> Self {
        Self {
            sum_mm: deviation.sum,
            mean_absolute_mm: deviation.mean,
            rms_mm: deviation.rms,
            most_overcut_mm: (-deviation.most_overcut).max(0.0),
            most_undercut_mm: deviation.most_undercut.max(0.0),
            sum_overcut_mm: deviation.sum_overcut,
            sum_undercut_mm: deviation.sum_undercut,
        }
    }
}

/// The ratios of the paper that the method is from.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PaperEntry {
    /// Ratio on surface A.
    pub ratio_a: f64,
    /// Ratio on surface B.
    pub ratio_b: f64,
    /// The ratio to compare with, if the surface and the cone are those of the paper.
    pub comparable: Option<f64>,
}

/// Sums over ranks.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RanksEntry {
    /// Singular values, falling.
    pub singular_values: Vec<f64>,
    /// The sum for each rank from 1 (mm); none where no deviation can be measured.
    pub sums_mm: Vec<Option<f64>>,
    /// The rank with the least sum; 0 if the initial path is better than all.
    pub best: usize,
}

/// A check.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CheckEntry {
    /// Name that an override gives.
    pub name: &'static str,
    /// Whether the check holds.
    pub holds: bool,
    /// Whether the check fails and is overridden.
    pub is_overridden: bool,
    /// Finding of the check, in words.
    pub text: String,
    /// Place of the finding (mm).
    pub place: Option<[f64; 3]>,
    /// Parameter t of the path at the finding.
    pub t: Option<f64>,
    /// Figures of a check that fails, by name.
    pub figures: BTreeMap<String, f64>,
    /// Finding that an override was given for, in words.
    pub given_for: Option<String>,
    /// Reason why that override no longer holds.
    pub lapsed: Option<String>,
}

/// Least distance of a part of the tool from a wall.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ClearanceEntry {
    /// The part.
    pub part: String,
    /// Distance (mm); negative by the depth of a gouge.
    pub distance_mm: f64,
    /// The place of the wall (mm).
    pub place: [f64; 3],
    /// t of the path.
    pub t: f64,
}

/// The path on a machine.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MachineEntry {
    /// Name and kind of the machine.
    pub name: String,
    /// Reason why the machine cannot follow; none if it can.
    pub trouble: Option<String>,
    /// Number of positions.
    pub positions: usize,
    /// Allowed between them (mm).
    pub linearisation_mm: f64,
    /// Bound of what there is (mm).
    pub deviation_mm: f64,
    /// Time (min).
    pub minutes: f64,
    /// Moves slower than the requested feed; none if all have it.
    pub slowed: Option<SlowedEntry>,
    /// Places where the pole is passed.
    pub singular: Vec<String>,
    /// Axes of the machine over time.
    pub axes: Vec<AxisEntry>,
}

/// Moves slower than the requested feed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SlowedEntry {
    /// Number of slowed moves, for whichever reason.
    pub moves: usize,
    /// Least share of the feed that remains.
    pub least_share: f64,
    /// Moves where an axis would be too fast.
    pub for_axes: Option<AxisSlowedEntry>,
    /// Moves that would be shorter than the time that the control gives any block.
    pub short: Option<ShortEntry>,
}

/// Moves where an axis would be too fast.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct AxisSlowedEntry {
    /// Number of moves.
    pub moves: usize,
    /// Least share of the feed that the axes allow.
    pub least_share: f64,
    /// Axis that limits the feed most.
    pub axis: char,
}

/// Moves that take the control's shortest time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ShortEntry {
    /// Number of moves.
    pub moves: usize,
    /// Least share of their speed that remains.
    pub least_share: f64,
}

/// An axis of a machine.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AxisEntry {
    /// Letter of the axis.
    pub letter: char,
    /// mm or deg.
    pub unit: &'static str,
    /// Limits of the axis, in `unit`.
    pub limits: [f64; 2],
    /// Seconds from the first position, and value.
    pub values: Vec<[f64; 2]>,
}

/// The deviation maps of the paths, with one scale.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct DeviationMaps {
    /// The maps; u to the right, v upwards.
    pub maps: Vec<Picture>,
    /// The bar of colours, least on the left; the `bar_url` of templates.
    #[serde(rename = "bar_url", serialize_with = "png_url")]
    pub bar_png: Vec<u8>,
    /// The deviation (mm) at the right end of the bar; the left end is the same, negative.
    pub end_mm: f64,
}

impl FlankReport {
    /// The path that is milled.
    pub fn milled(&self) -> Option<&PathEntry> {
        self.paths.iter().find(|p| p.is_milled)
    }

    /// The report as JSON; a number that is not finite becomes null.
    ///
    /// # Errors
    /// None that is known; the writer's own.
    pub fn json(&self) -> Result<String, serde_json::Error> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }

    /// The report as one self-contained page.
    ///
    /// # Errors
    /// [`PageError`], which a test of the template keeps from happening.
    pub fn html(&self, maps: &DeviationMaps) -> Result<String, PageError> {
        page::page(self, maps)
    }
}
