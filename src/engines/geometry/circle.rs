//! Circles through points in space, by least squares.

use glam::{DMat3, DVec3};
use nalgebra::{Matrix3, SymmetricEigen};

/// Points that spread this little across their longest direction (a share of it) lie on a line.
const ON_A_LINE: f64 = 1e-4;

/// A circle in space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Circle {
    /// Centre (mm).
    pub centre: DVec3,
    /// Unit normal of the plane.
    pub normal: DVec3,
    /// Radius (mm).
    pub radius: f64,
}

impl Circle {
    /// The circle through points in the plane that is nearest to them; none for fewer than three points, and where they
    /// lie on a line.
    pub fn through(points: &[DVec3]) -> Option<Self> {
        if points.len() < 3 {
            return None;
        }
        let middle = points.iter().sum::<DVec3>() / points.len() as f64;
        let mut spread = DMat3::ZERO;
        for p in points {
            let from = *p - middle;
            spread += DMat3::from_cols(from * from.x, from * from.y, from * from.z);
        }
        let eigen = SymmetricEigen::try_new(Matrix3::from_column_slice(&spread.to_cols_array()), f64::EPSILON, 100)?;
        let mut by_value = [0, 1, 2];
        by_value.sort_by(|&i, &j| eigen.eigenvalues[j].total_cmp(&eigen.eigenvalues[i]));
        let [most, across, least] = by_value;
        // The eigenvalues are squares of lengths.
        let share = (eigen.eigenvalues[across] / eigen.eigenvalues[most]).max(0.0).sqrt();
        if share.is_nan() || share < ON_A_LINE {
            return None;
        }
        Self::about(points, DVec3::from_array(std::array::from_fn(|row| eigen.eigenvectors[(row, least)])))
    }

    /// The circle through points that are seen along `axis`; none where they lie on a line.
    pub fn about(points: &[DVec3], axis: DVec3) -> Option<Self> {
        let normal = axis.try_normalize()?;
        let (x, y) = normal.any_orthonormal_pair();
        let middle = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
        let (mut matrix, mut right) = (DMat3::ZERO, DVec3::ZERO);
        let scale = points.iter().map(|p| p.distance(middle)).fold(0.0, f64::max);
        if scale == 0.0 {
            return None;
        }
        for p in points {
            let from = (p - middle) / scale;
            let row = DVec3::new(from.dot(x), from.dot(y), 1.0);
            let square = row.truncate().length_squared();
            matrix += DMat3::from_cols(row * row.x, row * row.y, row);
            right += row * square;
        }
        let found = matrix.inverse() * right;
        let at = found.truncate() * 0.5;
        let radius = (found.z + at.length_squared()).sqrt() * scale;
        let centre = middle + (x * at.x + y * at.y) * scale;
        (radius.is_finite() && centre.is_finite()).then_some(Self { centre, normal, radius })
    }

    /// Distance of a point from the circle (mm).
    pub fn distance(&self, p: DVec3) -> f64 {
        let from = p - self.centre;
        let height = from.dot(self.normal);
        height.hypot((from - self.normal * height).length() - self.radius)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn on_circle(circle: &Circle, angles: &[f64]) -> Vec<DVec3> {
        let (x, y) = circle.normal.any_orthonormal_pair();
        angles.iter().map(|a| circle.centre + circle.radius * (x * a.cos() + y * a.sin())).collect()
    }

    #[test]
    fn points_of_a_circle_give_it_back() {
        let normal = DVec3::new(1.0, -2.0, 0.5).normalize();
        let circle = Circle { centre: DVec3::new(40.0, -7.0, 120.0), normal, radius: 35.0 };
        for angles in [&[0.1, 0.6, 1.4][..], &[0.0, 2.0, 4.0], &[0.3, 1.0, 2.2, 3.7, 5.9]] {
            let found = Circle::through(&on_circle(&circle, angles)).unwrap();
            assert!((found.radius - 35.0).abs() < 1e-8, "{angles:?}: {found:?}");
            assert!(found.centre.distance(circle.centre) < 1e-8);
            assert!(found.normal.cross(normal).length() < 1e-10);
        }
    }

    #[test]
    fn the_distance_counts_both_off_the_plane_and_off_the_radius() {
        let circle = Circle { centre: DVec3::ZERO, normal: DVec3::Z, radius: 10.0 };
        assert!((circle.distance(DVec3::new(13.0, 0.0, 4.0)) - 5.0).abs() < 1e-12);
        assert!(circle.distance(DVec3::new(0.0, -10.0, 0.0)) < 1e-12);
    }

    #[test]
    fn two_points_or_points_on_a_line_give_none() {
        let line: Vec<DVec3> = (0..4).map(|i| DVec3::new(1.0, 2.0, 3.0) * f64::from(i)).collect();
        assert_eq!(Circle::through(&line), None);
        assert_eq!(Circle::through(&line[..2]), None);
        assert_eq!(Circle::through(&[DVec3::ONE; 3]), None);
    }
}
