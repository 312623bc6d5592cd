//! Cylinders and cones through points, by least squares.

use glam::{DMat3, DVec3};
use nalgebra::{SMatrix, SVector};

use crate::circle::Circle;

/// Steps of the least-squares fit at most.
const STEPS: usize = 25;

/// A straight line turned about an axis: a cylinder where `slope` is zero, else a cone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Revolved {
    /// A point of the axis.
    pub(super) origin: DVec3,
    /// Unit direction of the axis.
    pub(super) axis: DVec3,
    /// Radius at the origin (mm).
    pub(super) radius: f64,
    /// Growth of the radius along the axis.
    pub(super) slope: f64,
}

impl Revolved {
    /// Height along the axis, distance from it and direction away from it.
    fn place(&self, p: DVec3) -> (f64, f64, DVec3) {
        let from = p - self.origin;
        let height = from.dot(self.axis);
        let away = from - self.axis * height;
        let distance = away.length();
        (height, distance, if distance > 0.0 { away / distance } else { DVec3::ZERO })
    }

    /// Signed distance of a point (mm), positive away from the axis.
    pub(super) fn signed_distance(&self, p: DVec3) -> f64 {
        let (height, distance, _) = self.place(p);
        (distance - self.radius - self.slope * height) / (1.0 + self.slope * self.slope).sqrt()
    }

    /// The unit normal away from the axis at the place of `p`; zero on the axis.
    pub(super) fn normal(&self, p: DVec3) -> DVec3 {
        let (.., away) = self.place(p);
        if away == DVec3::ZERO { DVec3::ZERO } else { (away - self.axis * self.slope).normalize() }
    }

    /// The unit direction of the straight line through the place of `p`.
    pub(super) fn generator(&self, p: DVec3) -> DVec3 {
        let (.., away) = self.place(p);
        (self.axis + away * self.slope).normalize()
    }

    /// The cylinder about `axis` through points, by the circle through them seen along it; none where they lie on a
    /// line.
    pub(super) fn cylinder(points: &[DVec3], axis: DVec3) -> Option<Self> {
        let Circle { centre, normal, radius } = Circle::about(points, axis)?;
        Some(Self { origin: centre, axis: normal, radius, slope: 0.0 })
    }

    /// The cone whose tangent planes (unit normal, offset) these are, which go on around it in order; none where three
    /// of them do not meet in one point.
    pub(super) fn cone(points: &[DVec3], planes: &[(DVec3, f64)]) -> Option<Self> {
        let turns = planes.windows(3).map(|w| (w[1].0 - w[0].0).cross(w[2].0 - w[1].0));
        let axis = turns.sum::<DVec3>().try_normalize()?;
        let (mut matrix, mut right) = (DMat3::ZERO, DVec3::ZERO);
        for &(n, offset) in planes {
            matrix += DMat3::from_cols(n * n.x, n * n.y, n * n.z);
            right += n * offset;
        }
        let apex = matrix.inverse() * right;
        let middle = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
        // Seen from the apex the points lie up the axis.
        let axis = if (middle - apex).dot(axis) < 0.0 { -axis } else { axis };
        let slopes = points.iter().filter_map(|p| {
            let up = (p - apex).dot(axis);
            (up > 0.0).then(|| (p - apex - axis * up).length() / up)
        });
        let (sum, count) = slopes.fold((0.0, 0), |(sum, count), slope| (sum + slope, count + 1));
        let slope = sum / f64::from(count.max(1));
        let height = (middle - apex).dot(axis);
        let found = Self { origin: apex + axis * height, axis, radius: slope * height, slope };
        (found.origin.is_finite() && slope.is_finite() && slope > 0.0).then_some(found)
    }

    /// This surface moved and turned until the squares of the distances of `points` are least, or their mean is less
    /// than the square of `enough`.
    pub(super) fn fitted(self, points: &[DVec3], enough: f64) -> Self {
        let middle = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
        let mut now = self.about(middle);
        let mut cost = now.cost(points);
        let mut damping = 1e-6;
        let enough = enough * enough * points.len() as f64;
        for _ in 0..STEPS {
            if cost < enough {
                break;
            }
            let Some(next) = now.stepped(points, damping) else { break };
            let next_cost = next.cost(points);
            if next_cost < cost {
                let is_done = next_cost > cost * (1.0 - 1e-4);
                (now, cost, damping) = (next, next_cost, damping * 0.1);
                if is_done {
                    break;
                }
            } else {
                damping *= 100.0;
                if damping > 1e3 {
                    break;
                }
            }
        }
        now
    }

    /// Surface with its origin moved along its axis to lie beside `middle`.
    fn about(self, middle: DVec3) -> Self {
        let height = (middle - self.origin).dot(self.axis);
        Self { origin: self.origin + self.axis * height, radius: self.radius + self.slope * height, ..self }
    }

    fn cost(&self, points: &[DVec3]) -> f64 {
        points.iter().map(|&p| self.signed_distance(p).powi(2)).sum()
    }

    /// One step of Levenberg and Marquardt. A cylinder stays one.
    fn stepped(&self, points: &[DVec3], damping: f64) -> Option<Self> {
        let (x, y) = self.axis.any_orthonormal_pair();
        let steepness = 1.0 / (1.0 + self.slope * self.slope).sqrt();
        let reach = points.iter().map(|p| p.distance(self.origin)).fold(1e-9, f64::max);
        let mut matrix = SMatrix::<f64, 6, 6>::zeros();
        let mut right = SVector::<f64, 6>::zeros();
        for &p in points {
            let (height, distance, away) = self.place(p);
            let tilt = height + self.slope * distance;
            let slope = if self.slope == 0.0 { 0.0 } else { -height / reach };
            // Turns and slopes are measured by what they move at the farthest point, so that all are lengths.
            let row =
                [-away.dot(x), -away.dot(y), -tilt * away.dot(x) / reach, -tilt * away.dot(y) / reach, -1.0, slope];
            let row = SVector::<f64, 6>::from(row) * steepness;
            matrix += row * row.transpose();
            right -= row * ((distance - self.radius - self.slope * height) * steepness);
        }
        let largest = matrix.diagonal().max().max(f64::MIN_POSITIVE);
        for i in 0..6 {
            matrix[(i, i)] += damping * matrix[(i, i)] + 1e-14 * largest;
        }
        let step = matrix.cholesky()?.solve(&right);
        let next = Self {
            origin: self.origin + x * step[0] + y * step[1],
            axis: (self.axis + (x * step[2] + y * step[3]) / reach).try_normalize()?,
            radius: self.radius + step[4],
            slope: self.slope + step[5] / reach,
        };
        (next.origin.is_finite() && next.radius.is_finite() && next.slope.is_finite()).then_some(next)
    }
}
