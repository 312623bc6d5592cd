//! The feed path as it is exported: rows with linear motion of every axis between them.

use glam::DVec3;
use serde::Serialize;

use super::pose::Pose;
use crate::geometry::frame::Frame;

/// One row of a feed path.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PathRow {
    /// The search node at or before this row counted from the final pose, which is node 0.
    pub node: usize,
    /// Distance withdrawn along the main direction, 0 at the final pose (mm).
    pub s: f64,
    /// Axis values.
    pub pose: Pose,
}

/// A feed path in feed order: the first row is outside the blisk, the last is the final pose (all zeros).
/// The motion between rows is linear in every axis, which is what the exported program does.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FeedPath {
    /// Workpiece frame W in the coordinates of the loaded mesh (mm).
    pub frame: Frame,
    /// Electrode reference point O in W (mm).
    pub reference_point: DVec3,
    /// Spark gap the path must keep (mm).
    pub spark_gap: f64,
    /// Rows in feed order.
    pub rows: Vec<PathRow>,
}

/// Decimals of lengths in files (mm).
pub const LENGTH_DECIMALS: usize = 5;
/// Decimals of angles in files (deg).
pub const ANGLE_DECIMALS: usize = 6;

/// The row as files give it: lengths rounded to [`LENGTH_DECIMALS`], angles in degrees to [`ANGLE_DECIMALS`].
/// Rounding again changes nothing, and reading what was written gives the same bits.
pub fn quantised(row: &PathRow) -> PathRow {
    let length = |v: f64| rounded(v, LENGTH_DECIMALS);
    let angle = |v: f64| rounded(v.to_degrees(), ANGLE_DECIMALS).to_radians();
    let Pose { x, y, z, a, b, c } = row.pose;
    let pose = Pose { x: length(x), y: length(y), z: length(z), a: angle(a), b: angle(b), c: angle(c) };
    PathRow { node: row.node, s: length(row.s), pose }
}

fn rounded(value: f64, decimals: usize) -> f64 {
    let scale = 10f64.powi(decimals as i32);
    // Adding 0 turns -0 into 0.
    (value * scale).round() / scale + 0.0
}
