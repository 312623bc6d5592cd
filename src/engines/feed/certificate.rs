//! The verdict on a feed path: proven bounds of its least clearance.

use glam::DVec3;
use serde::Serialize;

use super::machine::BeyondTravel;
use super::pose::Pose;
use wheel::channel::Surface;

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

/// What was found out about the travel of the axes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum TravelVerdict {
    /// No machine was given.
    NotJudged,
    /// No row is beyond the travel of an axis, and so no instant is.
    Within,
    /// The first row that is.
    Beyond(BeyondTravel),
}

/// What the verifier found out about the whole continuous motion of a path.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs)]
pub struct Findings {
    pub path_digest: String,
    pub blisk_digest: String,
    pub electrode_digest: String,
    pub required: f64,
    pub tolerance: f64,
    pub certified: f64,
    pub least: Contact,
    pub violations: Vec<Contact>,
    pub row_clearance: Vec<f64>,
    pub row_surface: Vec<Surface>,
    pub ends_right: bool,
    pub travel: TravelVerdict,
    pub pair_intervals: u64,
}

/// What the verifier proved about the whole continuous motion of a path. Nobody else can make or change one.
///
/// ```compile_fail,E0616
/// fn flatter(mut certificate: feed::certificate::Certificate) {
///     certificate.findings.certified = 1.0;
/// }
/// ```
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Certificate {
    findings: Findings,
}

impl Certificate {
    /// The certificate of `findings`: for the verifier alone.
    pub(super) fn of(findings: Findings) -> Self {
        Self { findings }
    }

    /// A certificate of made-up findings.
    #[cfg(any(test, feature = "fixtures"))]
    pub fn made_up(findings: Findings) -> Self {
        Self { findings }
    }

    /// What it was made from, to be changed.
    #[cfg(any(test, feature = "fixtures"))]
    pub fn into_findings(self) -> Findings {
        self.findings
    }

    /// [`FeedPath::digest`](super::path::FeedPath::digest) of the path that was verified.
    pub fn path_digest(&self) -> &str {
        &self.findings.path_digest
    }

    /// [`Mesh::digest`](geometry::mesh::Mesh::digest) of the blisk it was verified against, in W.
    pub fn blisk_digest(&self) -> &str {
        &self.findings.blisk_digest
    }

    /// [`Mesh::digest`](geometry::mesh::Mesh::digest) of the electrode that was moved, in its final pose in W.
    pub fn electrode_digest(&self) -> &str {
        &self.findings.electrode_digest
    }

    /// Spark gap (mm).
    pub fn required(&self) -> f64 {
        self.findings.required
    }

    /// How far below the spark gap is still accepted (mm).
    pub fn tolerance(&self) -> f64 {
        self.findings.tolerance
    }

    /// What clearance is asked for, in words: the spark gap less the tolerance.
    pub fn demand(&self) -> String {
        format!("{:.4} mm less the tolerance of {:.4} mm are required", self.required(), self.tolerance())
    }

    /// Proven lower bound of the clearance over the whole motion (mm). 0 if the electrode touches or crosses
    /// the blisk or starts inside it, and if the verification stopped at the first violation.
    pub fn certified(&self) -> f64 {
        self.findings.certified
    }

    /// The smallest clearance met: an upper bound of the least clearance, and where it is.
    pub fn least(&self) -> &Contact {
        &self.findings.least
    }

    /// Places where the clearance falls below the spark gap less the tolerance, at rows and at instants found
    /// between them: the worst first, none close to a worse one, at most 16.
    pub fn violations(&self) -> &[Contact] {
        &self.findings.violations
    }

    /// Exact clearance at every row of the path (mm), 0 in metal. If the verification stopped at a violation,
    /// rows wholly inside metal show the distance between the surfaces.
    pub fn row_clearance(&self) -> &[f64] {
        &self.findings.row_clearance
    }

    /// Which surface each row's clearance is to.
    pub fn row_surface(&self) -> &[Surface] {
        &self.findings.row_surface
    }

    /// Whether the first row has the electrode wholly outside the blisk and the last is the final pose.
    pub fn ends_right(&self) -> bool {
        self.findings.ends_right
    }

    /// Whether the axes stay within their travel, if a machine was given.
    pub fn travel(&self) -> TravelVerdict {
        self.findings.travel
    }

    /// Triangle pairs and time intervals that had to be bounded one by one.
    pub fn pair_intervals(&self) -> u64 {
        self.findings.pair_intervals
    }

    /// Whether the clearance over the whole motion is proven to be the spark gap less the tolerance or more.
    pub fn keeps_clearance(&self) -> bool {
        let f = &self.findings;
        // 0 says that nothing was proven, which no tolerance can make good.
        f.certified > 0.0 && f.certified >= f.required - f.tolerance
    }

    /// Whether the motion is proven to keep the spark gap less the tolerance, from outside to the final pose, and no
    /// axis goes beyond its travel where that is known.
    pub fn holds(&self) -> bool {
        self.ends_right() && self.keeps_clearance() && !matches!(self.travel(), TravelVerdict::Beyond(_))
    }
}
