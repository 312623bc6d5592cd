//! Sums over all points of one iteration of a fit.

use glam::{DAffine3, DVec3};
use nalgebra::{Matrix6, Vector6};
use rayon::prelude::*;
use task::Task;

use crate::{MeasuredError, Nominal};

/// Points to a block: a few milliseconds of work. Blocks are summed in order, so that no sum depends on the threads.
const BLOCK: usize = 1024;

/// Distance (mm) below which the direction to the nearest point is rounding and the normal of the triangle is taken.
const ON_SURFACE: f64 = 1e-6;

/// A point of the scan beside the nominal surface.
#[derive(Debug, Clone, Copy)]
pub(super) struct Near {
    /// The point after the motion (mm).
    pub point: DVec3,
    /// Unit vector from the nearest point of the surface, or a normal there.
    pub normal: DVec3,
    /// Distance (mm), not negative.
    pub distance: f64,
    /// The nearest triangle.
    pub triangle: u32,
}

/// The points after `motion`, each beside the nominal surface.
pub(super) fn nearest_of_all(
    nominal: &Nominal,
    points: &[DVec3],
    motion: &DAffine3,
    task: &Task,
) -> Result<Vec<Near>, MeasuredError> {
    let near = |p: &DVec3| {
        let point = motion.transform_point3(*p);
        let nearest = nominal.nearest_by_normals(point);
        let distance = nearest.signed_distance.abs();
        let normal = match (point - nearest.point) / distance {
            normal if distance > ON_SURFACE => normal,
            _ => nominal.normal(nearest.triangle),
        };
        Near { point, normal, distance, triangle: nearest.triangle }
    };
    let blocks = points.par_chunks(BLOCK).map(|block| {
        task.check()?;
        Ok(block.iter().map(near).collect::<Vec<_>>())
    });
    Ok(blocks.collect::<Result<Vec<_>, MeasuredError>>()?.concat())
}

/// The sums of one choice of weights. Rows and columns of a twist: angular velocity, velocity of the centre.
#[derive(Debug, Clone)]
pub(super) struct Sums {
    /// Normal matrix: square of the displacement along the normals, per twist.
    pub normal: Matrix6<f64>,
    /// Right side of the normal equations.
    pub right: Vector6<f64>,
    /// Square of the whole displacement, per twist.
    pub energy: Matrix6<f64>,
    /// Sum of weights.
    pub weight: f64,
    /// Weighted sum of the squares of the distances (mm^2).
    pub squares: f64,
    /// Weighted mean of the square of the angle between triangles and the smooth surface they stand for (rad^2).
    pub facets: f64,
}

/// What is summed: normal matrix, right side, then weight, weighted square of the distance, of the facet angle, first
/// moments, second moments.
#[derive(Clone)]
struct Block {
    normal: Matrix6<f64>,
    right: Vector6<f64>,
    rest: [f64; 12],
}

impl Block {
    fn empty() -> Self {
        Self { normal: Matrix6::zeros(), right: Vector6::zeros(), rest: [0.0; 12] }
    }

    fn plus(mut self, other: &Self) -> Self {
        self.normal += other.normal;
        self.right += other.right;
        self.rest.iter_mut().zip(&other.rest).for_each(|(sum, x)| *sum += x);
        self
    }
}

impl Sums {
    /// The sums about `centre`, each point weighted by what `weight` makes of its distance.
    pub fn of(near: &[Near], centre: DVec3, nominal: &Nominal, weight: impl Fn(f64) -> f64 + Sync) -> Self {
        let block = |points: &[Near]| {
            let mut sum = Block::empty();
            for point in points {
                let w = weight(point.distance);
                let x = point.point - centre;
                let (turn, n) = (x.cross(point.normal), point.normal);
                let row = Vector6::new(turn.x, turn.y, turn.z, n.x, n.y, n.z);
                sum.normal += row * (row * w).transpose();
                sum.right -= row * (w * point.distance);
                // The normal of a facet is off by any angle up to the greatest, hence the third of its square.
                let facet = nominal.facet_angle(point.triangle).powi(2) / 3.0;
                let moments = [x.x * x.x, x.y * x.y, x.z * x.z, x.y * x.z, x.z * x.x, x.x * x.y];
                let own = [1.0, point.distance.powi(2), facet, x.x, x.y, x.z].into_iter().chain(moments);
                sum.rest.iter_mut().zip(own).for_each(|(sum, value)| *sum += w * value);
            }
            sum
        };
        let blocks: Vec<Block> = near.par_chunks(BLOCK).map(block).collect();
        let Block { normal, right, rest } = blocks.iter().fold(Block::empty(), Block::plus);
        let [weight, squares, facets, x, y, z, xx, yy, zz, yz, zx, xy] = rest;
        #[rustfmt::skip]
        let energy = Matrix6::new(
            yy + zz,     -xy,     -zx,     0.0,      -z,       y,
                -xy, zz + xx,     -yz,       z,     0.0,      -x,
                -zx,     -yz, xx + yy,      -y,       x,     0.0,
                0.0,       z,      -y,  weight,     0.0,     0.0,
                 -z,     0.0,       x,     0.0,  weight,     0.0,
                  y,      -x,     0.0,     0.0,     0.0,  weight,
        );
        Self { normal, right, energy, weight, squares, facets: facets / weight.max(f64::MIN_POSITIVE) }
    }
}

/// Mean of the points after the motion.
pub(super) fn centre_of(near: &[Near]) -> DVec3 {
    let sums: Vec<DVec3> = near.par_chunks(BLOCK).map(|block| block.iter().map(|n| n.point).sum()).collect();
    sums.iter().sum::<DVec3>() / near.len().max(1) as f64
}

/// Standard deviation of a normal distribution with the median of these distances (mm).
pub(super) fn scale_of(near: &[Near]) -> f64 {
    const MEDIAN_TO_DEVIATION: f64 = 1.4826;
    let mut distances: Vec<f64> = near.iter().map(|n| n.distance).collect();
    if distances.is_empty() {
        return 0.0;
    }
    let middle = distances.len() / 2;
    MEDIAN_TO_DEVIATION * *distances.select_nth_unstable_by(middle, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::mesh::Mesh;
    use nalgebra::Vector3;
    use std::sync::Arc;

    #[test]
    fn energy_and_normal_matrix_are_squares_of_displacements() {
        let nominal = Nominal::new(Arc::new(Mesh::cuboid(DVec3::splat(4.0))), &Task::default()).unwrap();
        let near: Vec<Near> = (0..50)
            .map(|i| {
                let t = f64::from(i);
                let point = DVec3::new((0.37 * t).sin(), (0.91 * t).cos(), (1.3 * t).sin()) * 5.0;
                let normal = DVec3::new((0.7 * t).cos(), (0.2 * t).sin(), 0.3).normalize();
                Near { point, normal, distance: 0.1, triangle: 0 }
            })
            .collect();
        let centre = DVec3::new(0.3, -0.2, 0.1);
        let sums = Sums::of(&near, centre, &nominal, |_| 2.0);
        let twist = Vector6::new(0.2, -0.4, 0.7, 1.0, 0.5, -0.3);
        let displacement = |p: DVec3| {
            let turn = Vector3::new(0.2, -0.4, 0.7);
            DVec3::new(turn.x, turn.y, turn.z).cross(p - centre) + DVec3::new(1.0, 0.5, -0.3)
        };
        let expected = near.iter().map(|n| 2.0 * displacement(n.point).length_squared()).sum::<f64>();
        assert!((twist.dot(&(sums.energy * twist)) - expected).abs() < 1e-9 * expected);
        let expected = near.iter().map(|n| 2.0 * displacement(n.point).dot(n.normal).powi(2)).sum::<f64>();
        assert!((twist.dot(&(sums.normal * twist)) - expected).abs() < 1e-9 * expected);
        let expected = near.iter().map(|n| -0.2 * displacement(n.point).dot(n.normal)).sum::<f64>();
        assert!((twist.dot(&sums.right) - expected).abs() < 1e-9);
        assert!((sums.weight - 100.0).abs() < 1e-12 && (sums.squares - 1.0).abs() < 1e-12);
    }
}
