//! Deviation of the cutter from the design surface: P4 (7), with foot points on the surface extended past its edges.
//!
//! The deviation of a place of the surface is taken where a place of the axis stands over it, that is, on the normal
//! there: `(P - R) . n - rho(h)`, with the sphere inscribed in the cutter around P. Clamping feet to the surface's
//! edges would falsify it, since the axis's lower end stands over v < 0.

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use serde::Serialize;

use super::FlankError;
use super::axis_surface::{AxisAt, AxisSurface};
use super::cutter::FlankCutter;
use super::ruled_surface::{RuledSurface, SurfacePlace};

/// A deviation (mm) that is rounding, of guides too, and no stock: nothing is gained by making it less.
pub const ROUNDING_MM: f64 = 1e-6;

/// A greatest deviation (mm) that nothing is gained by making less: guides written with three decimals are off by as
/// much, and it is a hundredth of what walls are usually allowed.
pub const SETTLED_MM: f64 = 1e-3;

/// Deviations over a grid, positive where stock is left.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Deviation {
    /// Places along u and along v.
    pub grid: [usize; 2],
    /// Whether the last places along u are the first ones again, once around: they count once in every figure.
    pub is_closed: bool,
    /// Deviations (mm); that of the place (i, j) has index `i * grid[1] + j`.
    pub values: Vec<f64>,
    /// Sum of the absolute values (mm).
    pub sum: f64,
    /// Mean (mm).
    pub mean: f64,
    /// Root of the mean of the squares (mm).
    pub rms: f64,
    /// The least deviation (mm): the greatest overcut, if it is negative.
    pub most_overcut: f64,
    /// The greatest deviation (mm): the greatest undercut, if it is positive.
    pub most_undercut: f64,
    /// Sum of what is overcut (mm), as a positive number.
    pub sum_overcut: f64,
    /// Sum of what is undercut (mm).
    pub sum_undercut: f64,
}

impl Deviation {
    /// The figures of some deviations, each place of which counts.
    pub fn of(grid: [usize; 2], values: Vec<f64>) -> Self {
        Self::with(grid, values, false)
    }

    /// The figures of deviations once around a closed surface, whose last places along u are its first ones again.
    pub fn around(grid: [usize; 2], values: Vec<f64>) -> Self {
        Self::with(grid, values, true)
    }

    fn with(grid: [usize; 2], values: Vec<f64>, is_closed: bool) -> Self {
        let counted = &values[..values.len() - repeated(grid, is_closed).min(values.len())];
        let count = counted.len().max(1) as f64;
        let sum_of = |f: &dyn Fn(f64) -> f64| counted.iter().map(|x| f(*x)).sum::<f64>();
        let sum_overcut = sum_of(&|x| (-x).max(0.0));
        let sum_undercut = sum_of(&|x| x.max(0.0));
        let sum = sum_overcut + sum_undercut;
        let rms = (sum_of(&|x| x * x) / count).sqrt();
        let most_overcut = values.iter().copied().fold(f64::INFINITY, f64::min);
        let most_undercut = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mean = sum / count;
        Self { grid, is_closed, values, sum, mean, rms, most_overcut, most_undercut, sum_overcut, sum_undercut }
    }

    /// The deviations (mm) that count: around a closed surface those of the seam once.
    pub fn counted(&self) -> &[f64] {
        &self.values[..self.values.len() - repeated(self.grid, self.is_closed).min(self.values.len())]
    }

    /// Places along u and along v that count.
    pub fn counted_grid(&self) -> [usize; 2] {
        [self.grid[0] - usize::from(self.is_closed && self.grid[0] > 1), self.grid[1]]
    }

    /// Whether the cutter touches everywhere to within [`SETTLED_MM`]: there is nothing to gain, and what seems less
    /// still has come about by sliding along the surface.
    pub fn is_settled(&self) -> bool {
        self.most_undercut.max(-self.most_overcut) <= SETTLED_MM
    }

    /// The deviation at the place (i, j) of the grid (mm).
    pub fn at(&self, i: usize, j: usize) -> Option<f64> {
        (j < self.grid[1]).then(|| self.values.get(i * self.grid[1] + j).copied()).flatten()
    }
}

/// Number of the last places of a grid that are the first ones again.
fn repeated([along, across]: [usize; 2], is_closed: bool) -> usize {
    if is_closed && along > 1 { across } else { 0 }
}

/// Places of a design surface, evenly spaced in v and as a rule in u, with the edges among them: what deviations are
/// measured at.
#[derive(Debug, Clone)]
pub struct DesignGrid {
    size: [usize; 2],
    /// Whether the last rulings are the first ones again.
    is_closed: bool,
    places: Vec<GridPlace>,
}

/// A place of the grid and two unit vectors square to its normal.
#[derive(Debug, Clone, Copy)]
pub(super) struct GridPlace {
    pub at: SurfacePlace,
    pub tangents: [DVec3; 2],
}

/// Feet: the places of the axis that stand over the places of a grid.
#[derive(Debug, Clone, PartialEq)]
pub struct Feet {
    /// For each place (t, a) of the axis surface.
    pub at: Vec<DVec2>,
}

impl Feet {
    /// Least and greatest t: the surface is covered if they are within 0 and 1.
    pub fn t_range(&self) -> [f64; 2] {
        range(self.at.iter().map(|q| q.x))
    }
}

fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
}

impl DesignGrid {
    /// The grid of `size` places along u and v, 2 at least both ways.
    pub fn new(surface: &RuledSurface, size: [usize; 2]) -> Self {
        let along: Vec<f64> = (0..size[0]).map(|i| i as f64 / (size[0].max(2) - 1) as f64).collect();
        Self::along(surface, &along, size[1])
    }

    /// The grid of rulings at these u, with `across` places on each, 2 at least.
    pub fn along(surface: &RuledSurface, u: &[f64], across: usize) -> Self {
        let place = |k: usize| {
            let at = surface.at(u[k / across], (k % across) as f64 / (across.max(2) - 1) as f64);
            let along = at.along_v.normalize_or_zero();
            GridPlace { at, tangents: [along, at.normal.cross(along)] }
        };
        let is_once_around = u.first().zip(u.last()).is_some_and(|(first, last)| last - first == 1.0);
        let places = (0..u.len() * across).into_par_iter().map(place).collect();
        Self { size: [u.len(), across], is_closed: surface.is_closed() && is_once_around, places }
    }

    /// Places along u and along v.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// Size of the grid that counts: around a closed surface the last rulings are the first ones again.
    pub fn counted_size(&self) -> [usize; 2] {
        [self.counted_places().len() / self.size[1].max(1), self.size[1]]
    }

    /// Places, row by row: v runs faster.
    pub fn places(&self) -> impl ExactSizeIterator<Item = &SurfacePlace> {
        self.places.iter().map(|place| &place.at)
    }

    pub(super) fn grid_places(&self) -> &[GridPlace] {
        &self.places
    }

    /// Places that count: around a closed surface the rulings of the seam once.
    pub(super) fn counted_places(&self) -> &[GridPlace] {
        &self.places[..self.places.len() - repeated(self.size, self.is_closed)]
    }

    /// The figures of deviations (mm) at its places.
    pub(super) fn figures(&self, values: Vec<f64>) -> Deviation {
        Deviation::with(self.size, values, self.is_closed)
    }

    /// The deviation of a path and where its axis stands over the grid. `near` says where it stood before, if known.
    ///
    /// # Errors
    /// [`FlankError::Unmeasured`] if no place of the axis stands over some place.
    pub fn deviation(
        &self,
        axis: &AxisSurface,
        cutter: &FlankCutter,
        near: Option<&Feet>,
    ) -> Result<(Deviation, Feet), FlankError> {
        let found = self.measured(axis, cutter, near);
        if let Some(first) = found.iter().position(Option::is_none) {
            let count = found.iter().filter(|f| f.is_none()).count();
            let SurfacePlace { u, v, .. } = self.places[first].at;
            return Err(FlankError::Unmeasured { count, u, v });
        }
        let (values, at) = found.into_iter().flatten().unzip();
        Ok((self.figures(values), Feet { at }))
    }

    /// Deviation (mm) and place (t, a) of the axis for every place that it stands over.
    pub(super) fn measured(
        &self,
        axis: &AxisSurface,
        cutter: &FlankCutter,
        near: Option<&Feet>,
    ) -> Vec<Option<(f64, DVec2)>> {
        const BLOCK: usize = 256;
        let blocks: Vec<Vec<Option<(f64, DVec2)>>> = self
            .places
            .par_chunks(BLOCK)
            .enumerate()
            .map(|(block, places)| {
                let one = |(k, place): (usize, &GridPlace)| {
                    let start = near.map(|feet| feet.at[block * BLOCK + k]);
                    over(axis, cutter, place, start).map(|(q, at)| (deviation_at(cutter, place, &at, q.y), q))
                };
                places.iter().enumerate().map(one).collect()
            })
            .collect();
        blocks.concat()
    }
}

/// Deviation over a grid of the axis surface, `size` places along t and a with the ends among them, each at the foot of
/// its own place: the grid of P4 (12). Not for choosing paths: its sum becomes less too where a path leaves the part.
///
/// # Errors
/// [`FlankError::Unmeasured`] if a place has no foot.
pub fn on_axis_grid(
    surface: &RuledSurface,
    axis: &AxisSurface,
    cutter: &FlankCutter,
    size: [usize; 2],
) -> Result<Deviation, FlankError> {
    let share = |i: usize, n: usize| i as f64 / (n.max(2) - 1) as f64;
    let place = |k: usize| DVec2::new(share(k / size[1], size[0]), share(k % size[1], size[1]));
    let one = |k: usize| {
        let q = place(k);
        let at = axis.at(q.x);
        let p = at.tip.lerp(at.top, q.y);
        let foot = surface.foot(p, DVec2::new(axis.u0(q.x), q.y))?;
        Some((p - foot.point).dot(foot.normal) - cutter.sphere_at(q.y * at.length()))
    };
    let found: Vec<Option<f64>> = (0..size[0] * size[1]).into_par_iter().map(one).collect();
    if let Some(first) = found.iter().position(Option::is_none) {
        let (count, q) = (found.iter().filter(|f| f.is_none()).count(), place(first));
        return Err(FlankError::Unmeasured { count, u: q.x, v: q.y });
    }
    Ok(Deviation::of(size, found.into_iter().flatten().collect()))
}

/// Deviation (mm) of the cutter at the share `a` of the axis over a place.
fn deviation_at(cutter: &FlankCutter, place: &GridPlace, axis: &AxisAt, a: f64) -> f64 {
    let off = axis.tip.lerp(axis.top, a) - place.at.point;
    off.dot(place.at.normal) - cutter.sphere_at(a * axis.length())
}

/// The place (t, a) of the axis over a place of the surface. Where the axis runs unevenly and nothing is known of where
/// it stands, it is looked for further and further around; past an end of the path only if none of the path's own
/// places near that end is as good.
fn over(axis: &AxisSurface, cutter: &FlankCutter, place: &GridPlace, start: Option<DVec2>) -> Option<(DVec2, AxisAt)> {
    const AROUND: [f64; 8] = [-0.01, 0.01, -0.02, 0.02, -0.04, 0.04, -0.08, 0.08];
    if let Some(start) = start {
        return over_near(axis, place, start);
    }
    let [from, to] = axis.u0_range;
    let first = DVec2::new((place.at.u - from) / (to - from), place.at.v);
    let from_aside = |off: &f64| over_near(axis, place, first + DVec2::new(*off, 0.0));
    let found = over_near(axis, place, first).or_else(|| AROUND.iter().find_map(from_aside))?;
    let is_within = |(q, _): &(DVec2, AxisAt)| axis.is_closed() || (0.0..=1.0).contains(&q.x);
    if is_within(&found) {
        return Some(found);
    }
    // A path that turns back near its end, gone on past it, comes over the place once more.
    let off = |(q, at): &(DVec2, AxisAt)| deviation_at(cutter, place, at, q.y).abs();
    let own = AROUND.iter().filter_map(from_aside).filter(is_within);
    let best = own.min_by(|a, b| off(a).total_cmp(&off(b)));
    Some(best.filter(|best| off(best) <= off(&found)).unwrap_or(found))
}

/// The place of the axis over a place of the surface, by Newton's method from `q`.
fn over_near(axis: &AxisSurface, place: &GridPlace, mut q: DVec2) -> Option<(DVec2, AxisAt)> {
    const ROUNDS: usize = 30;
    let [first, second] = place.tangents;
    for _ in 0..ROUNDS {
        let at = axis.at(q.x);
        let (by_t, by_a) = (at.tip_speed.lerp(at.top_speed, q.y), at.top - at.tip);
        let off = at.tip.lerp(at.top, q.y) - place.at.point;
        let (f, g) = (off.dot(first), off.dot(second));
        let (a, b, c, d) = (by_t.dot(first), by_a.dot(first), by_t.dot(second), by_a.dot(second));
        let det = a * d - b * c;
        let step = DVec2::new(d * f - b * g, a * g - c * f) / det;
        // A path that lies across the surface sends the first steps far off.
        let step = step * (0.2 / step.abs().max_element()).min(1.0);
        q -= step;
        if !q.is_finite() || q.abs().max_element() > 4.0 {
            return None;
        }
        if step.abs().max_element() < 1e-12 {
            return Some((q, axis.at(q.x)));
        }
    }
    None
}
