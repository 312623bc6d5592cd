//! Rigid coordinate frames and the cylindrical coordinates of the workpiece frame W.

use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

/// A right-handed orthonormal frame given in the coordinates of a parent frame (for W: the loaded mesh, in mm).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// Origin in parent coordinates.
    pub origin: DVec3,
    /// Unit vector of the frame's X axis in parent coordinates.
    pub x: DVec3,
    /// Unit vector of the frame's Y axis in parent coordinates.
    pub y: DVec3,
    /// Unit vector of the frame's Z axis in parent coordinates.
    pub z: DVec3,
}

impl Frame {
    /// The frame that coincides with its parent.
    pub const IDENTITY: Self = Self { origin: DVec3::ZERO, x: DVec3::X, y: DVec3::Y, z: DVec3::Z };

    /// The frame at `origin` with X along `x` and Z as near `z_hint` as orthogonality allows.
    /// If the two are parallel any perpendicular Z is taken.
    pub fn from_x_and_z_hint(origin: DVec3, x: DVec3, z_hint: DVec3) -> Self {
        let x = x.normalize_or(DVec3::X);
        let z = (z_hint - x * x.dot(z_hint)).try_normalize().unwrap_or_else(|| x.any_orthonormal_vector());
        Self { origin, x, y: z.cross(x), z }
    }

    /// Parent coordinates of a point given in this frame.
    pub fn to_parent(&self, p: DVec3) -> DVec3 {
        self.origin + self.direction_to_parent(p)
    }

    /// Coordinates in this frame of a point given in the parent.
    pub fn from_parent(&self, p: DVec3) -> DVec3 {
        self.direction_from_parent(p - self.origin)
    }

    /// Parent components of a direction given in this frame.
    pub fn direction_to_parent(&self, d: DVec3) -> DVec3 {
        self.x * d.x + self.y * d.y + self.z * d.z
    }

    /// Components in this frame of a direction given in the parent.
    pub fn direction_from_parent(&self, d: DVec3) -> DVec3 {
        DVec3::new(self.x.dot(d), self.y.dot(d), self.z.dot(d))
    }

    /// This frame turned by `angle` (rad, right-handed) about its own X axis.
    pub fn turned_about_x(&self, angle: f64) -> Self {
        let turn = DMat3::from_rotation_x(angle);
        Self { y: self.direction_to_parent(turn * DVec3::Y), z: self.direction_to_parent(turn * DVec3::Z), ..*self }
    }
}

/// Cylindrical coordinates about X: `theta` is 0 on +Z and grows with a right-handed turn about X, so that
/// turning a point by `a` about X adds `a` to its `theta`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cylindrical {
    /// Position along X (mm).
    pub x: f64,
    /// Distance from the X axis (mm).
    pub r: f64,
    /// Angle about X (rad), in (-pi, pi] when made from a point.
    pub theta: f64,
}

impl Cylindrical {
    /// The cylindrical coordinates of a point.
    pub fn from_point(p: DVec3) -> Self {
        Self { x: p.x, r: p.y.hypot(p.z), theta: (-p.y).atan2(p.z) }
    }

    /// The point with these coordinates.
    pub fn point(&self) -> DVec3 {
        let (s, c) = self.theta.sin_cos();
        DVec3::new(self.x, -self.r * s, self.r * c)
    }
}

/// The angle equal to `angle` up to whole turns that lies in (-pi, pi].
pub fn wrap_angle(angle: f64) -> f64 {
    let turned = angle.rem_euclid(std::f64::consts::TAU);
    if turned > std::f64::consts::PI { turned - std::f64::consts::TAU } else { turned }
}

/// The angle equal to `angle` up to whole turns that is nearest to `near` (rad).
pub fn angle_near(angle: f64, near: f64) -> f64 {
    angle + std::f64::consts::TAU * ((near - angle) / std::f64::consts::TAU).round()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_and_its_inverse_cancel() {
        let frame = Frame::from_x_and_z_hint(DVec3::new(1.0, -2.0, 3.0), DVec3::new(0.3, 0.9, -0.2), DVec3::Z);
        let p = DVec3::new(4.0, 5.0, -6.0);
        assert!((frame.from_parent(frame.to_parent(p)) - p).length() < 1e-12);
        assert!((frame.x.cross(frame.y) - frame.z).length() < 1e-12, "right-handed");
    }

    #[test]
    fn turning_about_x_adds_to_theta() {
        let p = Cylindrical { x: 3.0, r: 7.0, theta: 0.4 }.point();
        let turned = Cylindrical::from_point(DMat3::from_rotation_x(0.3) * p);
        assert!((turned.theta - 0.7).abs() < 1e-12 && (turned.r - 7.0).abs() < 1e-12);
    }

    #[test]
    fn the_nearest_equal_angle_is_within_half_a_turn() {
        for (angle, near, expected) in
            [(3.0, -3.0, 3.0 - std::f64::consts::TAU), (0.5, 0.4, 0.5), (-0.1, 13.0, 4.0 * std::f64::consts::PI - 0.1)]
        {
            assert!((angle_near(angle, near) - expected).abs() < 1e-12, "{angle} near {near}");
        }
    }
}
