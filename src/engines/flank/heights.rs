//! How high the cutter stands along its axis: nothing in the deviations holds it there. A cylinder deviates no more
//! wherever it stands along its axis, and a cone little, so that a step which gains next to nothing may carry the
//! flutes' end above the surface, or the bottom far below it.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::axis_surface::AxisSurface;
use super::compensation::Measured;
use super::cutter::FlankCutter;
use super::deviation::DesignGrid;

/// Heights (mm) above the tip that the places of the axis over the lower guide may have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Heights {
    /// The least: lower, and the flutes' end is above the lower guide.
    pub floor: f64,
    /// The greatest: higher, and the bottom is deeper than was asked.
    pub ceiling: f64,
}

impl Heights {
    /// How much deeper than the first path's the bottom may be (mm): a cone that sinks along its axis has any radius,
    /// but something may be below.
    const DEEPER_MM: f64 = 0.05;
    /// Greatest accepted distance of a path beyond the heights (mm): half of the usual depth of the bottom below the
    /// lower guide.
    pub const BEYOND_MM: f64 = 0.05;

    /// Heights of a first path, whose cutter touches the lower guide with its rim.
    pub fn of(first: &Measured, cutter: &FlankCutter) -> Self {
        // The contact on the rim has its sphere this high.
        let rim = cutter.radius_mm * cutter.half_angle().tan();
        Self { floor: rim, ceiling: first.heights_mm[1].max(rim) + Self::DEEPER_MM }
    }

    /// Distance of a path beyond the heights (mm); 0 within.
    pub fn beyond(&self, path: &Measured) -> f64 {
        let [low, high] = path.heights_mm;
        (self.floor - low).max(high - self.ceiling).max(0.0)
    }

    /// Whether a path keeps them to [`Self::BEYOND_MM`], or is at least no further beyond them than `before`.
    pub fn keeps_as(&self, path: &Measured, before: &Measured) -> bool {
        self.beyond(path) <= self.beyond(before).max(Self::BEYOND_MM)
    }

    /// The path, if it keeps them as [`Self::keeps_as`]; that of a cylinder also after it has been put back along its
    /// axis, for what an endless cylinder sweeps stays the same.
    pub fn kept(&self, grid: &DesignGrid, path: Measured, before: &Measured, cutter: &FlankCutter) -> Option<Measured> {
        if self.keeps_as(&path, before) {
            return Some(path);
        }
        let axis = (cutter.taper_deg == 0.0).then(|| self.slid(grid, &path)).flatten()?;
        let back = Measured::new(grid, axis, cutter, None).ok()?;
        self.keeps_as(&back, before).then_some(back)
    }

    /// The axis surface moved along itself so that it stands at the floor over the lower guide, by least squares.
    fn slid(&self, grid: &DesignGrid, path: &Measured) -> Option<AxisSurface> {
        /// Stiffness of control points that no place determines, as a share of the weight of one place.
        const STIFF: f64 = 1e-6;
        let n = path.axis.lower().len();
        let (mut matrix, mut right) = (DMatrix::identity(n, n) * STIFF, DMatrix::zeros(n, 3));
        for foot in path.feet.at.iter().take(grid.counted_places().len()).step_by(grid.size()[1]) {
            let at = path.axis.at(foot.x);
            let off = (foot.y * at.length() - self.floor) * at.axis();
            let basis = path.axis.basis().at(foot.x);
            for (i, value) in basis.numbers.into_iter().zip(basis.values) {
                (0..3).for_each(|k| right[(i, k)] += value * off[k]);
                basis.numbers.into_iter().zip(basis.values).for_each(|(j, other)| matrix[(i, j)] += value * other);
            }
        }
        let moved = Cholesky::new(matrix)?.solve(&right);
        let change = |k: usize| moved[(k / 3 % n, k % 3)];
        path.axis.moved(&DVector::from_fn(6 * n, |k, _| change(k))).ok()
    }
}
