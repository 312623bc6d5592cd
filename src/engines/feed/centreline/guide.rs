//! The centreline as the path of an electrode: its core point, and where that point is to be when the electrode is
//! withdrawn.

use glam::{DMat3, DVec3};

use crate::pose::Pose;
use geometry::exact::{ExactMesh, ExactMeshError};
use wheel::centreline::Centreline;
use wheel::electrode::Electrode;

/// Path of an electrode's core point along the centreline of its channel, in W.
#[derive(Debug, Clone, PartialEq)]
pub struct Guide {
    line: Centreline,
    reference_point: DVec3,
    /// P1's v: the middle of the electrode's section square to the centreline, in the final pose (mm).
    core: DVec3,
    /// Arc length of the core point in the final pose (mm).
    start: f64,
    /// Offset of the core point from the centreline in the final pose (mm).
    beside: DVec3,
    /// Direction of withdrawal along X.
    direction: f64,
}

impl Guide {
    /// Least share of a step that goes along X, where the line hardly does: nodes are distinguished by X.
    const LEAST_SHARE: f64 = 0.2;

    /// The path of `electrode` along `line`.
    ///
    /// # Errors
    /// If the electrode's mesh cannot be searched.
    pub fn new(line: Centreline, electrode: &Electrode) -> Result<Self, ExactMeshError> {
        let o = electrode.reference_point;
        let [place, normal] = line.at_length(line.length_at_x(o.x));
        let core = section_middle(&ExactMesh::new(&electrode.mesh)?, place, normal);
        let start = line.length_at_x(core.x);
        let beside = core - line.at_length(start)[0];
        let direction = electrode.enters_from.sign();
        Ok(Self { line, reference_point: o, core, start, beside, direction })
    }

    /// The core point in the final pose (mm, in W).
    pub fn core(&self) -> DVec3 {
        self.core
    }

    /// The electrode's reference point O (mm, in W).
    pub fn reference_point(&self) -> DVec3 {
        self.reference_point
    }

    /// Arc length of the node withdrawn by `s` along X (mm).
    pub fn arc_length(&self, s: f64) -> f64 {
        if s == 0.0 { self.start } else { self.line.length_at_x(self.core.x + self.direction * s) }
    }

    /// Withdrawn distance along X of the node a `step` of arc length after the one at `s` (mm). Always greater than
    /// `s`.
    pub fn next_s(&self, s: f64, step: f64) -> f64 {
        let next = self.line.at_length(self.arc_length(s) + self.direction * step)[0];
        let along_x = self.direction * (next.x - self.core.x);
        along_x.max(s + Self::LEAST_SHARE * step)
    }

    /// Turn of the line about Z from the node at `from` to that at `to`, both retract distances (rad).
    pub fn turning(&self, from: f64, to: f64) -> f64 {
        let [a, b] = [from, to].map(|s| self.line.at_length(self.arc_length(s))[1]);
        a.truncate().angle_to(b.truncate())
    }

    /// `pose` with Y and Z such that the core point lies on the line where its X is.
    pub fn on_line(&self, pose: &Pose) -> Pose {
        let flat = Pose { y: 0.0, z: 0.0, ..*pose };
        let at = flat.placement(self.reference_point).transform_point3(self.core);
        let target = self.line.at_length(self.line.length_at_x(at.x))[0] + self.beside;
        // Y and Z shift before A turns.
        let back = DMat3::from_rotation_x(-pose.a);
        let shift = back * (target - at);
        Pose { y: shift.y, z: shift.z, ..*pose }
    }
}

/// The middle of the electrode's section through `place`, square to `normal`: half way between the walls, and from
/// there half way between hub and shroud. Where a line leaves through no surface the place stays as it is.
fn section_middle(electrode: &ExactMesh, place: DVec3, normal: DVec3) -> DVec3 {
    const REACH: f64 = 1e3;
    let outwards = DVec3::new(0.0, place.y, place.z).normalize_or(DVec3::Z);
    let across = normal.cross(outwards).normalize_or(DVec3::Y);
    let radial = across.cross(normal);
    [across, radial].into_iter().fold(place, |at, direction| {
        let crossing = |direction| electrode.first_crossing(at, direction, REACH);
        match (crossing(direction), crossing(-direction)) {
            (Some(ahead), Some(behind)) => at + direction * (0.5 * (ahead - behind)),
            _ => at,
        }
    })
}
