//! Surfaces of faces that are no free forms: planes, cylinders and cones, each as a distance with its gradient.

use geometry::segmentation::FaceKind;
use glam::DVec3;

/// Three unit vectors at right angles, right-handed, at a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Axes {
    /// Place (mm).
    pub(super) origin: DVec3,
    /// First direction.
    pub(super) x: DVec3,
    /// Third direction.
    pub(super) z: DVec3,
}

impl Axes {
    /// Axes along `z`, the first direction being any.
    pub(super) fn along(origin: DVec3, z: DVec3) -> Self {
        Self { origin, x: z.any_orthonormal_vector(), z }
    }

    /// Second direction.
    pub(super) fn y(&self) -> DVec3 {
        self.z.cross(self.x)
    }

    /// Coordinates of a point.
    pub(super) fn local(&self, p: DVec3) -> DVec3 {
        let from = p - self.origin;
        DVec3::new(from.dot(self.x), from.dot(self.y()), from.dot(self.z))
    }

    /// The point of these coordinates.
    pub(super) fn point(&self, local: DVec3) -> DVec3 {
        self.origin + self.x * local.x + self.y() * local.y + self.z * local.z
    }
}

/// The surface of a face. What is outside lies above it: distances are positive there, and gradients point outwards.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Surface {
    /// A plane; z is its outward normal.
    Plane(Axes),
    /// A circular cylinder about z.
    Cylinder {
        /// Axis.
        axes: Axes,
        /// Radius (mm).
        radius: f64,
        /// Whether the axis lies outside the material.
        is_hollow: bool,
    },
    /// A circular cone about z, which opens along z.
    Cone {
        /// Axis; its origin is the tip.
        axes: Axes,
        /// Angle between axis and surface (rad).
        half_angle: f64,
        /// Whether the axis lies outside the material.
        is_hollow: bool,
    },
}

impl Surface {
    /// The surface of a plane, cylinder or cone beside `near`; none for a free form.
    pub(super) fn of(kind: &FaceKind, near: DVec3) -> Option<Self> {
        match *kind {
            FaceKind::Plane { normal, offset } => {
                let origin = near - normal * (normal.dot(near) - offset);
                Some(Self::Plane(Axes::along(origin, normal)))
            }
            FaceKind::Cylinder { point, direction, radius, is_hollow } => {
                Some(Self::Cylinder { axes: Axes::along(point, direction), radius, is_hollow })
            }
            FaceKind::Cone { apex, axis, half_angle, is_hollow } => {
                Some(Self::Cone { axes: Axes::along(apex, axis), half_angle, is_hollow })
            }
            FaceKind::Sphere { .. } | FaceKind::Torus { .. } | FaceKind::FreeForm => None,
        }
    }

    /// Signed distance of a point (mm) and its gradient, a unit vector.
    pub(super) fn distance(&self, p: DVec3) -> (f64, DVec3) {
        match self {
            Self::Plane(axes) => ((p - axes.origin).dot(axes.z), axes.z),
            Self::Cylinder { axes, radius, is_hollow } => {
                let (_, away, out) = around(axes, p);
                signed(away - radius, out, *is_hollow)
            }
            Self::Cone { axes, half_angle, is_hollow } => {
                let (height, away, out) = around(axes, p);
                let (sin, cos) = half_angle.sin_cos();
                signed(away * cos - height * sin, out * cos - axes.z * sin, *is_hollow)
            }
        }
    }

    /// Distance of a point from the surface (mm), never negative.
    pub(super) fn gap(&self, p: DVec3) -> f64 {
        self.distance(p).0.abs()
    }

    /// The axis of a cylinder or cone.
    pub(super) fn axis(&self) -> Option<&Axes> {
        match self {
            Self::Cylinder { axes, .. } | Self::Cone { axes, .. } => Some(axes),
            _ => None,
        }
    }

    /// Radius of a cylinder or cone at the place of `p` along the axis (mm).
    pub(super) fn radius_at(&self, p: DVec3) -> Option<f64> {
        match self {
            Self::Cylinder { radius, .. } => Some(*radius),
            Self::Cone { axes, half_angle, .. } => Some((p - axes.origin).dot(axes.z) * half_angle.tan()),
            _ => None,
        }
    }
}

/// Height along the axis, distance from it and the direction away from it.
fn around(axes: &Axes, p: DVec3) -> (f64, f64, DVec3) {
    let from = p - axes.origin;
    let height = from.dot(axes.z);
    let away = from - axes.z * height;
    let distance = away.length();
    (height, distance, if distance > 0.0 { away / distance } else { axes.x })
}

fn signed(distance: f64, normal: DVec3, is_hollow: bool) -> (f64, DVec3) {
    if is_hollow { (-distance, -normal) } else { (distance, normal) }
}

/// The point nearest to `p` that lies on all surfaces, as well as there is one: surfaces that are tangent to each other,
/// but apart, count for their mean.
pub(super) fn meet(surfaces: &[&Surface], mut p: DVec3) -> DVec3 {
    for _ in 0..12 {
        let step = least_step(surfaces.iter().map(|s| s.distance(p)));
        p -= step;
        if step.length() < 1e-12 {
            break;
        }
    }
    p
}

/// The least step that meets all conditions (value, gradient) in the sense of least squares. Directions about which the
/// gradients say next to nothing are left alone.
pub(super) fn least_step(rows: impl Iterator<Item = (f64, DVec3)>) -> DVec3 {
    let mut matrix = nalgebra::Matrix3::<f64>::zeros();
    let mut right = nalgebra::Vector3::<f64>::zeros();
    for (value, gradient) in rows {
        let g = nalgebra::Vector3::new(gradient.x, gradient.y, gradient.z);
        matrix += g * g.transpose();
        right += g * value;
    }
    let Some(eigen) = nalgebra::SymmetricEigen::try_new(matrix, 1e-15, 100) else { return DVec3::ZERO };
    let mut step = nalgebra::Vector3::zeros();
    for k in 0..3 {
        // Gradients at an angle a leave an eigenvalue of 1 - cos a: below 8 degrees they count as parallel, or a place
        // would slide far along the surfaces for the sake of next to nothing.
        if eigen.eigenvalues[k] > 9.7e-3 {
            let v = eigen.eigenvectors.column(k);
            step += v * (v.dot(&right) / eigen.eigenvalues[k]);
        }
    }
    DVec3::new(step.x, step.y, step.z)
}
