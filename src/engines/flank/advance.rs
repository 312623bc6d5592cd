//! Cost that keeps a path from turning back during refinement: sliding its control points along it changes deviations
//! so little that, left free, the end ones change places, and the path goes forward, then back.

use glam::DVec3;
use nalgebra::{DMatrix, DVector};

use super::axis_surface::AxisSurface;

/// The legs between neighbouring control points of both curves, and how far each should still go on.
#[derive(Debug, Clone)]
pub(super) struct Advance {
    legs: Vec<Leg>,
    /// Cost of the square of a share of a leg.
    by_share: f64,
}

/// Bound on one leg.
#[derive(Debug, Clone, Copy)]
struct Leg {
    /// Whether it is one of C_t.
    is_upper: bool,
    /// Numbers of the control points that it goes from and to.
    ends: [usize; 2],
    /// Where the path goes there.
    direction: DVec3,
    /// How far the start's leg goes that way (mm).
    length: f64,
}

impl Advance {
    /// The legs of `start` that go on, and costs that match deviations of the size `scale` (mm).
    pub fn of(start: &AxisSurface, scale: f64) -> Self {
        /// A share of a leg that costs as much as a deviation of the usual size.
        const SHARE: f64 = 2e-3;
        let legs = [start.lower(), start.upper()].into_iter().enumerate();
        let legs = legs.flat_map(|(curve, points)| legs_of(points, curve == 1, start.is_closed())).collect();
        Self { legs, by_share: scale / (SHARE * SHARE) }
    }

    /// Whether every leg still goes on. The speed of a curve is the sum of three neighbouring legs with weights that
    /// are not negative: where the path bends little within them, it goes on as they do.
    pub fn is_kept(&self, axis: &AxisSurface) -> bool {
        self.legs.iter().all(|leg| leg.share(axis) > 0.0)
    }

    /// Legs that are shorter than they should be, and by which share of what they were.
    fn short<'a>(&'a self, axis: &'a AxisSurface) -> impl Iterator<Item = (&'a Leg, f64)> + 'a {
        /// Share of the start's leg that is kept.
        const KEPT: f64 = 0.4;
        self.legs.iter().map(move |leg| (leg, KEPT - leg.share(axis))).filter(|(_, short)| *short > 0.0)
    }

    /// Cost of legs that are too short.
    pub fn cost(&self, axis: &AxisSurface) -> f64 {
        self.short(axis).map(|(_, short)| 0.5 * self.by_share * short * short).sum()
    }

    /// Adds the squares of what legs are short by, as they change with the control points.
    pub fn add_to(&self, axis: &AxisSurface, matrix: &mut DMatrix<f64>, slope: &mut DVector<f64>) {
        let n = axis.lower().len();
        for (leg, short) in self.short(axis) {
            let by = leg.direction / leg.length;
            let first = if leg.is_upper { n } else { 0 };
            let unknown = |k: usize| (3 * (first + leg.ends[k / 3]) + k % 3, if k < 3 { by[k] } else { -by[k % 3] });
            for (column, value) in (0..6).map(unknown) {
                slope[column] += self.by_share * short * value;
                (0..6).map(unknown).for_each(|(row, other)| matrix[(row, column)] += self.by_share * value * other);
            }
        }
    }
}

impl Leg {
    /// How far the same leg of a path goes on, as a share of what it did.
    fn share(&self, axis: &AxisSurface) -> f64 {
        let points = if self.is_upper { axis.upper() } else { axis.lower() };
        (points[self.ends[1]] - points[self.ends[0]]).dot(self.direction) / self.length
    }
}

/// The legs of a curve that go on the way that the curve goes from before them to behind them. Such as hardly do, where
/// the curve stands still or turns, are left free.
fn legs_of(points: &[DVec3], is_upper: bool, is_closed: bool) -> Vec<Leg> {
    /// Share of the mean leg below which one hardly goes on.
    const HARDLY: f64 = 0.05;
    let n = points.len();
    let count = if is_closed { n } else { n - 1 };
    let at = |i: usize| points[i % n];
    let mean = (0..count).map(|i| at(i).distance(at(i + 1))).sum::<f64>() / count as f64;
    let leg = |i: usize| {
        let [before, behind] = if is_closed { [i + n - 1, i + 2] } else { [i.saturating_sub(1), (i + 2).min(n - 1)] };
        let direction = (at(behind) - at(before)).normalize_or_zero();
        Leg { is_upper, ends: [i, (i + 1) % n], direction, length: (at(i + 1) - at(i)).dot(direction) }
    };
    (0..count).map(leg).filter(|leg| leg.length > HARDLY * mean).collect()
}
