//! The centreline as the path of an electrode: its core point, and where that point is to be when the electrode is
//! withdrawn.

use glam::{DMat3, DVec3, Vec3Swizzles as _};

use crate::pose::{Axis, Pose};
use geometry::exact::ExactMesh;
use wheel::centreline::Centreline;
use wheel::channel::{Channel, Flow};
use wheel::electrode::{Electrode, ElectrodeError, EntrySide};

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
    side: EntrySide,
    /// 1 where the line leads to the side of entry, -1 where it comes from there.
    sign: f64,
}

impl Guide {
    /// Least share of a step that goes along the axis of withdrawal, where the line hardly does: nodes are distinguished
    /// by their places there.
    const LEAST_SHARE: f64 = 0.2;

    /// The path of `electrode` along `line`, the centreline of `channel`.
    ///
    /// # Errors
    /// If the passage does not open to the side of entry, or the electrode's mesh cannot be searched.
    pub fn new(line: Centreline, channel: &Channel, electrode: &Electrode) -> Result<Self, ElectrodeError> {
        let (o, side) = (electrode.reference_point, electrode.enters_from);
        let sign = if side.mouth(channel)? { 1.0 } else { -1.0 };
        let nearest = |p: DVec3| match channel.flow {
            Flow::Axial => line.length_at_x(p.x),
            Flow::Mixed | Flow::Radial => line.length_near(p),
        };
        let [place, normal] = line.at_length(nearest(o));
        let core = section_middle(&ExactMesh::new(&electrode.mesh)?, place, normal);
        let start = nearest(core);
        let beside = core - line.at_length(start)[0];
        Ok(Self { line, reference_point: o, core, start, beside, side, sign })
    }

    /// The core point in the final pose (mm, in W).
    pub fn core(&self) -> DVec3 {
        self.core
    }

    /// The electrode's reference point O (mm, in W).
    pub fn reference_point(&self) -> DVec3 {
        self.reference_point
    }

    /// Arc length of the node withdrawn by `s` along the axis of withdrawal (mm).
    pub fn arc_length(&self, s: f64) -> f64 {
        if s == 0.0 { self.start } else { self.length_where(self.core + s * self.side.direction(), 0.0) }
    }

    /// Arc length at which the core point beside the line is as far as `at` along the axis of withdrawal, where A has
    /// turned by `a` (rad).
    fn length_where(&self, at: DVec3, a: f64) -> f64 {
        let direction = DMat3::from_rotation_x(a) * self.side.direction();
        self.line.length_reaching((direction, direction.dot(at - self.beside)), self.start, self.sign)
    }

    /// Withdrawn distance of the node a `step` of arc length after the one at `s` (mm). Always greater than `s`.
    pub fn next_s(&self, s: f64, step: f64) -> f64 {
        let next = self.line.at_length(self.arc_length(s) + self.sign * step)[0];
        let withdrawn = self.side.direction().dot(next + self.beside - self.core);
        withdrawn.max(s + Self::LEAST_SHARE * step)
    }

    /// Turn of the line from the node at `from` to that at `to`, both retract distances (rad), by the axis that can follow
    /// it: C, or A, about X, where the electrode is withdrawn along Z.
    pub fn turning(&self, from: f64, to: f64) -> (Axis, f64) {
        let [a, b] = [from, to].map(|s| self.line.at_length(self.arc_length(s))[1]);
        match Axis::of_withdrawal(self.side) {
            Axis::X => (Axis::C, a.truncate().angle_to(b.truncate())),
            _ => (Axis::A, a.yz().angle_to(b.yz())),
        }
    }

    /// `pose` with such slides across the withdrawal that the core point lies on the line where it is withdrawn to.
    pub fn on_line(&self, pose: &Pose) -> Pose {
        let axis = Axis::of_withdrawal(self.side);
        let flat = Pose { x: 0.0, y: 0.0, z: 0.0, ..*pose }.with(axis, pose.get(axis));
        let at = flat.placement(self.reference_point).transform_point3(self.core);
        let target = self.line.at_length(self.length_where(at, pose.a))[0] + self.beside;
        // Slides shift before A turns.
        let shift = DMat3::from_rotation_x(-pose.a) * (target - at);
        Pose { x: shift.x, y: shift.y, z: shift.z, ..*pose }.with(axis, pose.get(axis))
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
