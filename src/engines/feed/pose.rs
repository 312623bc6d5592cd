//! Poses of the electrode and the machine axes that make them.

use glam::{DAffine3, DMat3, DVec3};
use serde::{Deserialize, Serialize};

use wheel::electrode::EntrySide;

/// Axis values relative to the electrode's final pose: mm and radians. The final pose is all zeros.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Along the blisk axis (mm).
    pub x: f64,
    /// Across (mm).
    pub y: f64,
    /// Along the tool axis (mm).
    pub z: f64,
    /// About the blisk axis (rad).
    pub a: f64,
    /// Tilt of six-axis machines (rad).
    pub b: f64,
    /// About the tool axis (rad).
    pub c: f64,
}

/// The machine's axes, in the order of [`Pose::to_array`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Axis {
    /// Along the blisk axis (mm).
    X,
    /// Across the channel (mm).
    Y,
    /// Radial (mm).
    Z,
    /// Rotation of the blisk about X (rad).
    A,
    /// Tilt of the electrode about its Y (rad).
    B,
    /// Rotation of the electrode about its Z (rad).
    C,
}

impl Axis {
    /// Every axis in order.
    pub const ALL: [Self; 6] = [Self::X, Self::Y, Self::Z, Self::A, Self::B, Self::C];

    /// The axis letter.
    pub fn letter(self) -> char {
        ['X', 'Y', 'Z', 'A', 'B', 'C'][self as usize]
    }

    /// The axis along which an electrode is withdrawn to `side`.
    pub fn of_withdrawal(side: EntrySide) -> Self {
        match side {
            EntrySide::MinusX | EntrySide::PlusX => Self::X,
            EntrySide::Outward | EntrySide::Inward => Self::Z,
        }
    }

    /// Whether the axis turns rather than slides.
    pub fn is_rotary(self) -> bool {
        self as usize >= 3
    }
}

impl Pose {
    /// The final pose.
    pub const FINAL: Self = Self { x: 0.0, y: 0.0, z: 0.0, a: 0.0, b: 0.0, c: 0.0 };

    /// `[x, y, z, a, b, c]` (mm, rad).
    pub fn to_array(&self) -> [f64; 6] {
        [self.x, self.y, self.z, self.a, self.b, self.c]
    }

    /// The pose with axis values `[x, y, z, a, b, c]` (mm, rad).
    pub fn from_array([x, y, z, a, b, c]: [f64; 6]) -> Self {
        Self { x, y, z, a, b, c }
    }

    /// The value of one axis.
    pub fn get(&self, axis: Axis) -> f64 {
        self.to_array()[axis as usize]
    }

    /// The pose with another value of one axis.
    pub fn with(&self, axis: Axis, value: f64) -> Self {
        let mut values = self.to_array();
        values[axis as usize] = value;
        Self::from_array(values)
    }

    /// Linear motion of all axes: `self` at `t = 0`, `other` at `t = 1`.
    pub fn lerp(&self, other: &Self, t: f64) -> Self {
        let (p, q) = (self.to_array(), other.to_array());
        Self::from_array(std::array::from_fn(|i| p[i] + (q[i] - p[i]) * t))
    }

    /// The rigid motion of the electrode from its final pose, given the reference point O in W:
    /// `p' = Rx(a) * (O + (x, y, z) + Rz(c) * Ry(b) * (p - O))`.
    pub fn placement(&self, reference_point: DVec3) -> DAffine3 {
        let (table, tool) = (DMat3::from_rotation_x(self.a), self.tool());
        let slid = reference_point + self.slide();
        DAffine3 { matrix3: table * tool, translation: table * (slid - tool * reference_point) }
    }

    /// The pose that places an electrode about the reference point `to` as this one does about `from`.
    pub fn about(&self, from: DVec3, to: DVec3) -> Self {
        let apart = from - to;
        let slide = self.slide() + apart - self.tool() * apart;
        Self { x: slide.x, y: slide.y, z: slide.z, ..*self }
    }

    fn slide(&self) -> DVec3 {
        DVec3::new(self.x, self.y, self.z)
    }

    fn tool(&self) -> DMat3 {
        DMat3::from_rotation_z(self.c) * DMat3::from_rotation_y(self.b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn placement_is_the_formula_of_the_frames_page() {
        let o = DVec3::new(10.0, 0.0, 117.0);
        let pose = Pose { x: -3.0, y: 1.5, z: 0.25, a: 0.1, b: -0.2, c: 0.3 };
        let p = DVec3::new(12.0, -4.0, 120.0);
        let (sc, cc) = pose.c.sin_cos();
        let (sb, cb) = pose.b.sin_cos();
        let (sa, ca) = pose.a.sin_cos();
        let d = p - o;
        let tilted = DVec3::new(cb * d.x + sb * d.z, d.y, -sb * d.x + cb * d.z);
        let turned = DVec3::new(cc * tilted.x - sc * tilted.y, sc * tilted.x + cc * tilted.y, tilted.z);
        let slid = o + DVec3::new(pose.x, pose.y, pose.z) + turned;
        let expected = DVec3::new(slid.x, ca * slid.y - sa * slid.z, sa * slid.y + ca * slid.z);
        assert!((pose.placement(o).transform_point3(p) - expected).length() < 1e-12);
        let other = DVec3::new(-4.0, 2.5, 90.0);
        let about_other = pose.about(o, other).placement(other).transform_point3(p);
        assert!((about_other - expected).length() < 1e-12, "{about_other}");
        assert!((Pose::FINAL.placement(o).transform_point3(p) - p).length() < 1e-12);
    }
}
