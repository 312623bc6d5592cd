//! The verdict on a feed path: proven bounds of its least clearance.

use glam::DVec3;
use serde::Serialize;

use crate::machine::BeyondTravel;
use crate::pose::Pose;
use wheel::channel::Surface;
use wheel::electrode::EntrySide;

/// Closest approach of two surfaces during a motion.
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

/// Verdict on the travel of the axes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum TravelVerdict {
    /// Not judged, as no machine was given.
    NotJudged,
    /// Every row is within the travel of every axis, and so is every instant between.
    Within,
    /// The first row that is.
    Beyond(BeyondTravel),
}

/// Findings of the verifier about the whole continuous motion of a path.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Findings {
    pub(super) path_digest: String,
    pub(super) blisk_digest: String,
    pub(super) electrode_digest: String,
    pub(super) required: f64,
    pub(super) tolerance: f64,
    pub(super) certified: f64,
    pub(super) least: Contact,
    pub(super) violations: Vec<Contact>,
    pub(super) row_clearance: Vec<f64>,
    pub(super) row_surface: Vec<Surface>,
    pub(super) enters_from: Option<EntrySide>,
    pub(super) ends_right: bool,
    pub(super) travel: TravelVerdict,
    pub(super) pair_intervals: u64,
}

/// Proof of the clearance over the whole continuous motion of a path. Only the verifier can make one, since the
/// constructor is visible in its module alone, and none can be changed.
///
/// ```compile_fail,E0451
/// fn made_up() -> feed::certificate::Certificate {
///     feed::certificate::Certificate { findings: todo!() }
/// }
/// ```
///
/// ```compile_fail,E0624
/// fn made_up() -> feed::certificate::Certificate {
///     feed::certificate::Certificate::of(todo!())
/// }
/// ```
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

    /// [`FeedPath::digest`](crate::path::FeedPath::digest) of the path that was verified.
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

    /// Tolerance below the spark gap (mm).
    pub fn tolerance(&self) -> f64 {
        self.findings.tolerance
    }

    /// Clearance demanded, in words: the spark gap less the tolerance.
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

    /// Surface that each row's clearance is measured to.
    pub fn row_surface(&self) -> &[Surface] {
        &self.findings.row_surface
    }

    /// Whether the first row has the electrode wholly outside the blisk and the last is the final pose.
    pub fn ends_right(&self) -> bool {
        self.findings.ends_right
    }

    /// The side of the blisk, in W, that the electrode enters from: the one that all of it is beyond at the first row.
    /// None where the motion does not begin outside.
    pub fn enters_from(&self) -> Option<EntrySide> {
        self.findings.enters_from
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

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// Values that no verification returns, but a fault in one might.
    #[test]
    fn what_is_no_number_or_proves_nothing_keeps_no_clearance() {
        let least = Contact {
            distance: 0.1,
            row: 0.0,
            s: 0.0,
            pose: Pose::FINAL,
            on_electrode: DVec3::ZERO,
            on_blisk: DVec3::ZERO,
            surface: Surface::Elsewhere,
        };
        let keeps = |certified: f64, required: f64, tolerance: f64| {
            let findings = Findings {
                path_digest: String::new(),
                blisk_digest: String::new(),
                electrode_digest: String::new(),
                required,
                tolerance,
                certified,
                least,
                violations: Vec::new(),
                row_clearance: vec![0.1],
                row_surface: vec![Surface::Elsewhere],
                enters_from: None,
                ends_right: true,
                travel: TravelVerdict::Within,
                pair_intervals: 0,
            };
            let certificate = Certificate::of(findings);
            assert_eq!(certificate.keeps_clearance(), certificate.holds());
            certificate.keeps_clearance()
        };
        assert!(keeps(0.0981, 0.1, 0.002) && keeps(0.1, 0.1, 0.0));
        for [certified, required, tolerance] in [
            [0.0979, 0.1, 0.002],
            [f64::NAN, 0.1, 0.002],
            [0.1, f64::NAN, 0.002],
            [0.1, 0.1, f64::NAN],
            [0.0, 0.1, 1.0],
            [0.0, 0.0, 0.0],
        ] {
            assert!(!keeps(certified, required, tolerance), "{certified} {required} {tolerance}");
        }
    }
}
