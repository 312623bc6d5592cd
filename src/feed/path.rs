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
