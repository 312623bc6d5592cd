//! What a job found, as `report.json` for programs and `report.html` for people.
//!
//! The structs here are filled by the job and hold nothing that needs explaining twice: lengths in mm, angles in
//! degrees, names as they stand in the JSON. Keys keep their order, so equal results give equal files.

pub mod build;
pub mod comparison;
pub mod design;
#[cfg(test)]
pub mod fixtures;
pub mod measured;
mod page;
pub mod residual_stock;
pub mod simulation;
pub mod verify;

use serde::Serialize;

use crate::workspaces::blisk::document::choice::MeshFrame;
use crate::workspaces::blisk::job::burning::WheelBurning;
use crate::workspaces::blisk::job::figures::Histogram;
use crate::workspaces::blisk::job::measured::MeasuredWalls;
use crate::workspaces::blisk::report::residual_stock::{CopyingReport, ResidualStockReport};
use crate::workspaces::blisk::report::simulation::SimulationReport;
use crate::workspaces::blisk::report::verify::SettingReport;
use feed::certificate::{Certificate, Contact};
use feed::objective::WallSpread;
use feed::path::PathRow;
use feed::pose::{Axis, Pose};
use feed::preset::Preset;
use feed::smoothness::AxisSmoothness;
use feed::wall_clearances::WallClearances;
use files::ParameterList;
use files::report::Picture;
use geometry::frame::Frame;
use nc::block_feed::Slowed;
use wheel::channel::Channel;
use wheel::section_deviation::SectionsDeviation;

/// Version of the keys of `report.json`.
pub const SCHEMA: u32 = 1;

/// A report could not be written.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum ReportError {
    #[error("the report cannot be put into JSON: {0}")]
    Json(#[from] serde_json::Error),
    #[error(transparent)]
    Page(#[from] files::report::PageError),
}

/// A whole job.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// [`SCHEMA`].
    pub schema: u32,
    /// Version of the program.
    pub program_version: String,
    /// How the job ended.
    pub verdict: Verdict,
    /// Files that went in.
    pub inputs: Vec<InputFile>,
    /// What was found in the blisk.
    pub blisk: BliskSummary,
    /// The parameters of the job, defaults included, but for those of strategies that were not followed.
    pub parameters: ParameterList,
    /// The papers' symbols, and the parameters of the strategy.
    pub symbols: Vec<Symbol>,
    /// Electrodes with their paths.
    pub electrodes: Vec<ElectrodeReport>,
    /// Stock that the electrodes leave in the channel; none if not every path is verified.
    #[serde(rename = "leftover")]
    pub residual_stock: Option<ResidualStockReport>,
    /// Reason why the stock left cannot be told, if it cannot.
    #[serde(rename = "no_leftover")]
    pub no_residual_stock: Option<String>,
    /// Minutes and wear of the electrodes, and the schedule of the wheel; none if not every path is verified.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub burning: Option<WheelBurning>,
    /// The measured sections that the blisk was made from, against its walls; none where it was not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub measured: Option<MeasuredReport>,
    /// What was written.
    pub written: Written,
    /// Time per stage.
    pub times: Vec<StageTime>,
    /// Pictures for the page.
    #[serde(skip)]
    pub pictures: Vec<Picture>,
    /// Reason why there are no pictures, when they were wanted and could not be drawn.
    #[serde(skip)]
    pub no_pictures: Option<String>,
}

/// How a job ended.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Verdict {
    /// The program's exit code: 0 done and verified, 3 the answer is no, 130 the work was stopped.
    pub exit_code: i32,
    /// The answer in a sentence.
    pub sentence: String,
}

/// A file that went into the job.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct InputFile {
    /// Role of the file: blisk, electrode, path.
    pub role: String,
    /// Path that the file was read from.
    pub path: String,
    /// SHA-256 of its bytes, hex.
    pub sha256: String,
    /// Triangles read.
    pub triangles: usize,
    /// Unit its numbers were taken to be in.
    pub unit: String,
    /// Reason for taking that unit.
    pub unit_reason: String,
    /// What was mended while reading, in plain sentences.
    pub repairs: Vec<String>,
    /// How near the triangles are to the exact faces of a STEP file.
    pub accuracy: Option<String>,
}

/// What was found in the blisk.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs)]
pub struct BliskSummary {
    pub blades: usize,
    pub channel: usize,
    pub shrouded: bool,
    /// W in the coordinates of the loaded mesh (mm).
    pub frame: Frame,
    /// Least and greatest hub radius over the blades' span.
    pub hub_radius_mm: [f64; 2],
    /// Least and greatest shroud or tip radius over the blades' span.
    pub shroud_radius_mm: [f64; 2],
    /// X extent of the blades.
    pub span_x_mm: [f64; 2],
    /// Least distance between the walls.
    pub throat_mm: f64,
    /// How much the channel's middle line turns.
    pub turning_deg: f64,
    pub low_wall: String,
    pub high_wall: String,
    /// What was assumed, in plain sentences.
    pub assumed: Vec<String>,
}

impl BliskSummary {
    /// The summary of `channel`.
    pub fn of(channel: &Channel) -> Self {
        use wheel::channel::Surface::{HighWall, LowWall};
        let ([lo, hi], [from, to]) = (channel.span_x(), channel.span_along());
        let inside = channel.meridian.iter().map(|m| m.along).filter(|along| (from..=to).contains(along));
        let stations = [from, to].into_iter().chain(inside).map(|along| channel.station_at(along));
        let radii: Vec<_> = stations.map(|station| (station.hub.y, station.shroud.y)).collect();
        let range = |values: &mut dyn Iterator<Item = f64>| {
            values.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], v| [a.min(v), b.max(v)])
        };
        Self {
            blades: channel.blades,
            channel: channel.index,
            shrouded: channel.shrouded,
            frame: channel.frame,
            hub_radius_mm: range(&mut radii.iter().map(|r| r.0)),
            shroud_radius_mm: range(&mut radii.iter().map(|r| r.1)),
            span_x_mm: [lo, hi],
            throat_mm: channel.throat.width_mm,
            turning_deg: channel.turning.to_degrees(),
            low_wall: channel.surface_name(LowWall).to_owned(),
            high_wall: channel.surface_name(HighWall).to_owned(),
            assumed: channel.assumed.clone(),
        }
    }
}

/// Measured sections against the walls of the channel.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MeasuredReport {
    /// The verdicts in sentences.
    pub sentence: String,
    /// Whether both verdicts are good.
    pub holds: bool,
    /// The sections against the walls that are planned for.
    pub planned: SectionsDeviation,
    /// Each inner section against walls through the others.
    pub others: SectionsDeviation,
    /// Every point as a table, if it was written.
    pub file: Option<String>,
}

impl From<&MeasuredWalls> for MeasuredReport {
    fn from(walls: &MeasuredWalls) -> Self {
        Self {
            sentence: walls.sentence(),
            holds: walls.holds(),
            planned: walls.planned.clone(),
            others: walls.others.clone(),
            file: None,
        }
    }
}

/// A symbol of the papers with the value it had.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs)]
pub struct Symbol {
    pub symbol: String,
    pub meaning: String,
    pub value: String,
    pub unit: String,
}

/// Axis values in file units.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
#[allow(missing_docs)]
pub struct PoseReport {
    pub x_mm: f64,
    pub y_mm: f64,
    pub z_mm: f64,
    pub a_deg: f64,
    pub b_deg: f64,
    pub c_deg: f64,
}

impl From<&Pose> for PoseReport {
    fn from(p: &Pose) -> Self {
        let [a_deg, b_deg, c_deg] = [p.a, p.b, p.c].map(f64::to_degrees);
        Self { x_mm: p.x, y_mm: p.y, z_mm: p.z, a_deg, b_deg, c_deg }
    }
}

/// Where the least clearance is. Points in W (mm), the electrode's in its final pose.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs)]
pub struct ClearancePlace {
    pub row: f64,
    pub s_mm: f64,
    pub pose: PoseReport,
    pub on_electrode: [f64; 3],
    pub on_blisk: [f64; 3],
    /// The surface's name for a reader.
    pub surface: String,
}

impl ClearancePlace {
    /// The place of `contact`; `surface` is [`Channel::surface_name`] of its surface.
    pub fn of(contact: &Contact, surface: &str) -> Self {
        Self {
            row: contact.row,
            s_mm: contact.s,
            pose: PoseReport::from(&contact.pose),
            on_electrode: contact.on_electrode.to_array(),
            on_blisk: contact.on_blisk.to_array(),
            surface: surface.to_owned(),
        }
    }
}

/// Values of P0's objective at a node.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct ObjectiveReport {
    /// Obj1 of (4).
    pub smoothness: f64,
    /// Obj2 of (5).
    pub centring: f64,
    /// a3 Obj1 + b3 Obj2.
    pub total: f64,
}

/// A search node.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs)]
pub struct NodeReport {
    pub node: usize,
    pub s_mm: f64,
    #[serde(flatten)]
    pub pose: PoseReport,
    pub clearance_mm: f64,
    pub objective: Option<ObjectiveReport>,
    /// P0's D_L, D_R, S_L and S_R.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub walls_mm: Option<WallsReport>,
    /// P1's four distances.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distances_mm: Option<DistancesReport>,
}

/// Distances of the electrode's walls from those of the channel at a node, as P0's (5) takes them (mm): of samples
/// between the blades.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct WallsReport {
    /// D_L: least distance of the low (P0: left) wall; none outside the blades.
    pub least_low: Option<f64>,
    /// D_R: least distance of the high (P0: right) wall; none outside the blades.
    pub least_high: Option<f64>,
    /// S_L: standard deviation of the distances of the low wall.
    pub deviation_low: f64,
    /// S_R: standard deviation of the distances of the high wall.
    pub deviation_high: f64,
}

impl From<WallSpread> for WallsReport {
    fn from(spread: WallSpread) -> Self {
        let ([least_low, least_high], [deviation_low, deviation_high]) = (spread.least, spread.deviation);
        Self { least_low, least_high, deviation_low, deviation_high }
    }
}

/// P1's four distances at a node (mm); what is missing is out of reach.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct DistancesReport {
    /// Distance to the wall on the side of smaller theta.
    pub low_wall: f64,
    /// Distance to the wall on the side of greater theta.
    pub high_wall: f64,
    /// Distance to the hub.
    pub hub: Option<f64>,
    /// Distance to the shroud.
    pub shroud: Option<f64>,
}

impl From<WallClearances> for DistancesReport {
    fn from(WallClearances { walls: [low_wall, high_wall], hub, shroud }: WallClearances) -> Self {
        Self { low_wall, high_wall, hub, shroud }
    }
}

/// How even the motion of an axis is, over equal steps of withdrawn distance; mm or degrees.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Smoothness {
    /// The axis letter.
    pub axis: char,
    /// `mm` or `deg`.
    pub unit: &'static str,
    /// Sum of the steps' sizes.
    pub total_variation: f64,
    /// Root mean square of the second differences.
    pub rms_second_difference: f64,
    /// Greatest second difference in size.
    pub max_second_difference: f64,
    /// How often the axis turns back.
    pub sign_changes_first_difference: usize,
}

impl Smoothness {
    /// The figures of every axis that moves, given in the order of [`Axis`].
    pub fn of(axes: &[AxisSmoothness; 6]) -> Vec<Self> {
        let moving = Axis::ALL.into_iter().zip(axes).filter(|(_, s)| s.total_variation > 0.0);
        moving
            .map(|(axis, s)| Self {
                axis: axis.letter(),
                unit: if axis.is_rotary() { "deg" } else { "mm" },
                total_variation: s.total_variation,
                rms_second_difference: s.rms_second_difference,
                max_second_difference: s.max_second_difference,
                sign_changes_first_difference: s.sign_changes,
            })
            .collect()
    }
}

/// How the genetic search of a node went on, per generation.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs)]
pub struct Convergence {
    pub node: usize,
    pub best: Vec<f64>,
    pub mean: Vec<f64>,
}

/// Reason why there is no verified path.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Failure {
    /// The node that has no free pose, or the one at or before the worst place of a path.
    pub node: usize,
    /// How far the electrode is withdrawn there (mm).
    pub s_mm: f64,
    /// The surface that is in the way, if one is.
    pub wall: Option<String>,
    /// Where, in W (mm).
    pub place: Option<[f64; 3]>,
    /// What happened and what would help, in plain words.
    pub sentence: String,
}

/// An electrode and its path.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct ElectrodeReport {
    /// Number of the electrode, counted from 1.
    pub index: usize,
    /// Part of the channel that the electrode burns where the channel is divided; empty for a single electrode.
    pub share: String,
    /// `-x`, `+x` or `outward`, in W.
    pub enters_from: String,
    /// Whether a path was found.
    pub extractable: bool,
    /// Whether its clearance is proven.
    pub verified: bool,
    /// Spark gap (mm).
    pub required_clearance_mm: f64,
    /// How far below the spark gap is still accepted (mm).
    pub tolerance_mm: f64,
    /// Proven lower bound over the whole motion (mm).
    pub certified_clearance_mm: Option<f64>,
    /// Place of the electrode on its holder in a sentence; none where it is planned as nominal.
    pub preset: Option<String>,
    /// Place of the electrode on its holder as numbers, and the way by which it goes on for its wear.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub preset_values: Option<Preset>,
    /// Distance that the electrode would keep if nothing of it were worn (mm); none of a new one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unworn_mm: Option<f64>,
    /// Longest jump back along the path that the certificate covers (mm); none without a verified path.
    pub longest_jump_mm: Option<f64>,
    /// Smallest clearance met: an upper bound of the least (mm).
    pub least_clearance_mm: Option<f64>,
    /// Place of the smallest clearance met.
    pub least_clearance_at: Option<ClearancePlace>,
    /// The search nodes, node 0 being the final pose.
    pub nodes: Vec<NodeReport>,
    /// Per moving axis.
    pub smoothness: Vec<Smoothness>,
    /// Volume of the electrode (mm^3).
    pub volume_mm3: f64,
    /// Least wall thickness of the electrode (mm).
    pub least_thickness_mm: Option<f64>,
    /// Area that erodes (mm^2).
    pub burn_area_mm2: Option<f64>,
    /// Per node of a genetic search.
    pub ga_convergence: Vec<Convergence>,
    /// The copying motion at the end of the feed, if the path is verified.
    pub copying: Option<CopyingReport>,
    /// Setting errors that the feed bears, where the job asks about any.
    pub setting: Option<SettingReport>,
    /// The whole motion on the machine, if it was simulated.
    pub simulation: Option<SimulationReport>,
    /// Reason why the path is not verified, when it is not.
    pub failure: Option<Failure>,
    /// What the certificate was made for.
    pub sha256: Option<VerifiedDigests>,
    /// How the NC program's feed was lowered for the machine's speeds, if it was.
    pub feed_lowered: Option<FeedLowered>,
    /// The electrode as STEP, or why there is none, in a sentence; none where it was not asked for.
    pub step: Option<String>,
    /// Files written for this electrode.
    pub files: Vec<String>,
    /// Rows and clearances for the plots.
    #[serde(skip)]
    pub motion: Option<Motion>,
    /// Retract distance and place of the centroid in W (mm) for the plots, from the final pose outwards.
    #[serde(skip)]
    pub centroid: Vec<[f64; 4]>,
    /// Retract distance (mm) and wall distances in the final pose and at the most uneven node, for the plots.
    #[serde(skip)]
    pub wall_distances: Vec<(f64, Histogram)>,
}

/// Blocks of the NC program that are slower than asked for, so that no axis exceeds its greatest speed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FeedLowered {
    /// Blocks that are slower.
    pub blocks: usize,
    /// Blocks in all.
    pub of_blocks: usize,
    /// Least share of the speed asked for that is left.
    pub least_share: f64,
    /// The axis that demands it.
    pub axis: char,
}

impl From<&Slowed> for FeedLowered {
    fn from(s: &Slowed) -> Self {
        Self { blocks: s.blocks, of_blocks: s.of, least_share: s.least_share, axis: s.axis.letter() }
    }
}

/// SHA-256 (hex) of what was verified, as [`Certificate`] has them: meshes in W, bit for bit.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs)]
pub struct VerifiedDigests {
    pub path: String,
    pub blisk: String,
    pub electrode: String,
}

impl VerifiedDigests {
    /// Digests of the files that `certificate` is about.
    pub fn of(certificate: &Certificate) -> Self {
        let c = certificate;
        let [path, blisk, electrode] = [c.path_digest(), c.blisk_digest(), c.electrode_digest()].map(str::to_owned);
        Self { path, blisk, electrode }
    }
}

/// The rows of a path with their clearances.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Motion {
    /// Rows of the path, in feed order.
    pub rows: Vec<PathRow>,
    /// Exact clearance at every row (mm).
    pub clearance: Vec<f64>,
}

/// What was written beside the report, as it was chosen.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Written {
    /// Frame of the electrode meshes: `mesh` or `w`.
    pub electrode_frame: MeshFrame,
    /// Name or file of the post.
    pub post: String,
    /// Every file, in the order of writing.
    pub files: Vec<String>,
    /// Reason why there is no job sheet, if its template makes none.
    pub no_job_sheet: Option<String>,
    /// Keys of `[export.files]` that were false.
    pub not_asked_for: Vec<&'static str>,
}

/// Time of a stage.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs)]
pub struct StageTime {
    pub stage: String,
    pub seconds: f64,
}

impl Report {
    /// The report as JSON, keys in the order of the structs; a number that is not finite becomes null.
    ///
    /// # Errors
    /// [`ReportError::Json`], which only a parameter table with keys that are not text could cause.
    pub fn json(&self) -> Result<String, ReportError> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }

    /// The report as one self-contained page.
    ///
    /// # Errors
    /// [`ReportError::Page`], which a test of the template keeps from happening.
    pub fn html(&self) -> Result<String, ReportError> {
        Ok(page::page(self)?)
    }
}

#[cfg(test)]
mod tests;
