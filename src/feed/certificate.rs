//! The verdict on a feed path: proven bounds of its least clearance.

use glam::DVec3;
use serde::Serialize;

use super::pose::Pose;
use crate::blisk::channel::Surface;

/// Where two surfaces come closest during a motion.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Contact {
    /// Distance between the two points (mm); 0 when the surfaces touch or cross.
    pub distance: f64,
    /// Position on the path: `3.25` is a quarter of the way from row 3 to row 4 in feed order.
    pub row: f64,
    /// Distance still withdrawn at that instant (mm).
    pub s: f64,
    /// Axis values at that instant.
    pub pose: Pose,
    /// The point on the electrode, in its final pose in W (mm).
    pub on_electrode: DVec3,
    /// The point on the blisk, in W (mm).
    pub on_blisk: DVec3,
    /// The surface of the blisk it lies on.
    pub surface: Surface,
}

/// What the verifier proved about the whole continuous motion of a path.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Certificate {
    /// [`FeedPath::digest`](super::path::FeedPath::digest) of the path that was verified.
    pub path_digest: String,
    /// Spark gap (mm).
    pub required: f64,
    /// How far below the spark gap is still accepted (mm).
    pub tolerance: f64,
    /// Proven lower bound of the clearance over the whole motion (mm). 0 if the electrode touches or crosses
    /// the blisk or starts inside it, and if the verification stopped at the first violation.
    pub certified: f64,
    /// The smallest clearance met: an upper bound of the least clearance, and where it is.
    pub least: Contact,
    /// Places where the clearance falls below the spark gap less the tolerance, at rows and at instants found
    /// between them: the worst first, none close to a worse one, at most 16.
    pub violations: Vec<Contact>,
    /// Exact clearance at every row of the path (mm), 0 in metal. If the verification stopped at a violation,
    /// rows wholly inside metal show the distance between the surfaces.
    pub row_clearance: Vec<f64>,
    /// Which surface each row's clearance is to.
    pub row_surface: Vec<Surface>,
    /// Whether the first row has the electrode wholly outside the blisk and the last is the final pose.
    pub ends_right: bool,
    /// Triangle pairs and time intervals that had to be bounded one by one.
    pub pair_intervals: u64,
}

impl Certificate {
    /// Whether the motion is proven to keep the spark gap less the tolerance, from outside to the final pose.
    pub fn holds(&self) -> bool {
        // 0 says that nothing was proven, which no tolerance can make good.
        self.ends_right && self.certified > 0.0 && self.certified >= self.required - self.tolerance
    }
}
