//! The feed path as it is exported: rows with linear motion of every axis between them.

use glam::DVec3;
use serde::Serialize;
use sha2::{Digest, Sha256};

use super::pose::Pose;
use geometry::frame::Frame;

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

impl FeedPath {
    /// SHA-256 (lower-case hex) over the exact bits of the frame, the reference point, the spark gap and every
    /// row: two paths with the same digest are the same motion. Ties a certificate to the path it was made for.
    pub fn digest(&self) -> String {
        let mut hash = Sha256::new();
        let number = |hash: &mut Sha256, v: f64| hash.update(v.to_bits().to_le_bytes());
        let Frame { origin, x, y, z } = self.frame;
        let header = [origin, x, y, z, self.reference_point].map(|v| v.to_array()).concat();
        header.iter().chain([&self.spark_gap]).for_each(|&v| number(&mut hash, v));
        for row in &self.rows {
            hash.update((row.node as u64).to_le_bytes());
            std::iter::once(row.s).chain(row.pose.to_array()).for_each(|v| number(&mut hash, v));
        }
        hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }
}
