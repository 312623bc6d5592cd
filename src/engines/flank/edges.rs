//! Cost that keeps a path on the surface's edges during refinement: sliding along the path or along the axis changes
//! deviations so little that, left free, it carries the path's ends or the cutter's bottom off the surface.

use glam::DVec3;
use nalgebra::{DMatrix, DVector};

use super::compensation::{Measured, Row};
use super::deviation::DesignGrid;
use super::heights::Heights;

/// Bounds that a path should keep, and what it costs not to.
#[derive(Debug, Clone, Copy)]
pub(super) struct Edges {
    /// How far within the path's ends (t) the surface's ends should lie; none for a closed path.
    margin: Option<f64>,
    /// Least height (mm) above the tip of a place of the axis over the lower guide.
    floor: f64,
    /// The greatest: a cone that sinks along its axis has any radius, but something may be below.
    ceiling: f64,
    /// Cost of the square of a share of the path.
    by_t: f64,
    /// Cost of the square of a height (1/mm^2).
    by_height: f64,
}

impl Edges {
    /// Bounds of t that `start` keeps, those of the height, and costs that match deviations of the size `scale` (mm).
    pub fn of(start: &Measured, heights: &Heights, scale: f64) -> Self {
        /// A share of the path and a height (mm) that cost as much as a deviation of the usual size.
        const SHARE: f64 = 2e-4;
        const HEIGHT: f64 = 5e-3;
        let [first, last] = start.feet.t_range();
        // The moving cutter grazes the ends a little before or after it stands over them.
        let margin = (0.5 * first.min(1.0 - last)).min(2e-3).max(1.2 * start.lag);
        let margin = (!start.axis.is_closed()).then_some(margin);
        let Heights { floor, ceiling } = *heights;
        Self { margin, floor, ceiling, by_t: scale / (SHARE * SHARE), by_height: scale / (HEIGHT * HEIGHT) }
    }

    /// Places that are beyond a bound: by how much, the cost of its square, and how that changes.
    fn beyond<'a>(&'a self, grid: &'a DesignGrid, path: &'a Measured) -> impl Iterator<Item = (f64, f64, Row)> + 'a {
        let [along, across] = grid.size();
        let ends = (0..across).flat_map(move |j| [(j, 1.0), ((along - 1) * across + j, -1.0)]);
        let at_ends = ends.filter_map(move |(k, sign)| {
            let (t, a) = path.feet.at[k].into();
            let margin = self.margin?;
            let beyond = if sign > 0.0 { margin - t } else { t - (1.0 - margin) };
            (beyond > 0.0).then(|| {
                let at = path.axis.at(t);
                let speed = at.tip_speed.lerp(at.top_speed, a);
                let by = sign * speed / speed.length_squared();
                (beyond, self.by_t, row(path, t, [(1.0 - a) * by, a * by]))
            })
        });
        let rulings = grid.counted_places().len() / across.max(1);
        let at_bottom = (0..rulings).filter_map(move |i| {
            let (t, a) = path.feet.at[i * across].into();
            let at = path.axis.at(t);
            let height = a * at.length();
            let (low, high) = (self.floor - height, height - self.ceiling);
            let upwards = if low > 0.0 { at.axis() } else { -at.axis() };
            let beyond = low.max(high);
            (beyond > 0.0).then(|| (beyond, self.by_height, row(path, t, [upwards, DVec3::ZERO])))
        });
        at_ends.chain(at_bottom)
    }

    /// Cost of exceeding the bounds.
    pub fn cost(&self, grid: &DesignGrid, path: &Measured) -> f64 {
        self.beyond(grid, path).map(|(beyond, cost, _)| 0.5 * cost * beyond * beyond).sum()
    }

    /// Adds the squares of what is beyond, as they change with the control points.
    pub fn add_to(&self, grid: &DesignGrid, path: &Measured, matrix: &mut DMatrix<f64>, slope: &mut DVector<f64>) {
        let n = path.axis.lower().len();
        for (beyond, cost, row) in self.beyond(grid, path) {
            let entries = row.entries(n);
            for (column, value) in entries {
                slope[column] += cost * beyond * value;
                entries.iter().for_each(|(r, other)| matrix[(*r, column)] += cost * value * other);
            }
        }
    }
}

fn row(path: &Measured, t: f64, by: [DVec3; 2]) -> Row {
    let basis = path.axis.basis().at(t);
    Row { numbers: basis.numbers, values: basis.values, by }
}
