//! Compensation of deviations by the singular value decomposition, over every rank, P4 (10) to (13).
//!
//! A change of the control points changes a deviation by `dD . n` (P4 (11) has the sign turned); for a cone the height
//! of the place above the bottom changes too. The system is solved for every rank and each answer's true deviation is
//! taken: large ranks leave the neighbourhood in which the system holds.

use glam::{DMat2, DVec2, DVec3};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::FlankError;
use super::advance::Advance;
use super::axis_surface::AxisSurface;
use super::cutter::FlankCutter;
use super::deviation::{DesignGrid, Deviation, Feet, GridPlace, ROUNDING_MM, on_axis_grid};
use super::envelope::envelope_over;
use super::heights::Heights;
use super::params::SumOver;
use super::ruled_surface::RuledSurface;
use task::Cancel;

/// True sums of deviations over the number of singular values kept.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct RankCurve {
    /// The singular values, falling.
    pub singular_values: Vec<f64>,
    /// For each rank k from 1: the sum of absolute deviations (mm) of the path it leads to; none where that path is so
    /// far off that it cannot be measured. That of the best rank is the chosen path's, put back along its axis or not.
    pub sums: Vec<Option<f64>>,
    /// The same sum of the path that they start from (mm).
    pub start_sum: f64,
    /// The rank with the least sum, among those of paths that do not turn back and, if there are any, that cover the
    /// surface, along it and in height. 0 if no rank is better than the path before, or if that is good enough.
    pub best: usize,
    /// Places along u and v of the grid that the sums are of.
    pub grid: [usize; 2],
}

/// Model of the effect of a change of the control points.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Model {
    /// Shift of each place of the axis along the normal; P4's model.
    Shift,
    /// Shift, and change of the height of the place, and so of the radius of a cone there.
    #[default]
    Height,
    /// And another place of the axis then stands over the same place of the surface: the exact derivative.
    Moving,
}

/// Dependence of the deviation at a sample on the control points.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row {
    /// Numbers of four control points.
    pub numbers: [usize; 4],
    /// Basis functions.
    pub values: [f64; 4],
    /// By a change of C_b and of C_t.
    pub by: [DVec3; 2],
}

impl Row {
    /// The row of one place, whose axis stands at `foot`.
    pub fn of(axis: &AxisSurface, cutter: &FlankCutter, place: &GridPlace, foot: DVec2, model: Model) -> Self {
        let (t, a) = (foot.x, foot.y);
        let at = axis.at(t);
        let direction = at.axis();
        let sin = if model == Model::Shift { 0.0 } else { cutter.half_angle().sin() };
        let mut shift = place.at.normal;
        if model == Model::Moving {
            let (by_t, by_a) = (at.tip_speed.lerp(at.top_speed, a), at.top - at.tip);
            let longer = direction.dot(at.top_speed - at.tip_speed);
            let of_foot = DVec2::new(by_t.dot(shift) - a * sin * longer, by_a.dot(shift) - sin * at.length());
            let [e, f] = place.tangents;
            // Columns are how the foot's two conditions change with t and a; transposed for the product from the left.
            let moves = DMat2::from_cols_array(&[by_t.dot(e), by_t.dot(f), by_a.dot(e), by_a.dot(f)]);
            let share = moves.transpose().inverse() * of_foot;
            if share.is_finite() {
                shift -= share.x * e + share.y * f;
            }
        }
        let taller = a * sin * direction;
        let basis = axis.basis().at(t);
        Self { numbers: basis.numbers, values: basis.values, by: [(1.0 - a) * shift + taller, a * shift - taller] }
    }

    /// Entries that are not zero: number of the unknown, rising, and value. Unknowns are x, y, z of all of C_b, then of
    /// C_t.
    pub fn entries(&self, control_points: usize) -> [(usize, f64); 24] {
        let mut entries = [(0, 0.0); 24];
        for (k, entry) in entries.iter_mut().enumerate() {
            let (curve, point, axis) = (k / 12, k / 3 % 4, k % 3);
            let unknown = 3 * (curve * control_points + self.numbers[point]) + axis;
            *entry = (unknown, self.values[point] * self.by[curve][axis]);
        }
        // Across the seam of a closed path the last control points come before the first.
        if self.numbers[3] < self.numbers[0] {
            entries.sort_unstable_by_key(|e| e.0);
        }
        entries
    }
}

/// The linear system that a change of the control points should solve: `J x = -deviation`, reduced to as many rows as
/// unknowns by orthogonal transformations.
#[derive(Debug, Clone)]
pub struct Compensation {
    singular_values: Vec<f64>,
    /// Columns: right singular vectors divided by the singular values, times the transformed right side.
    parts: DMatrix<f64>,
}

impl Compensation {
    /// The system at a path.
    ///
    /// # Errors
    /// [`FlankError::Singular`] if it cannot be decomposed; cancelled.
    pub fn new(
        grid: &DesignGrid,
        axis: &AxisSurface,
        cutter: &FlankCutter,
        (deviation, feet): (&Deviation, &Feet),
        (model, cancel): (Model, &Cancel),
    ) -> Result<Self, FlankError> {
        let triangle = triangle(grid, axis, cutter, (deviation, feet), (model, cancel))?;
        cancel.check()?;
        let unknowns = triangle.ncols() - 1;
        let square = triangle.view((0, 0), (unknowns, unknowns)).into_owned();
        let right = triangle.view((0, unknowns), (unknowns, 1)).into_owned();
        const ROUNDS: usize = 10_000;
        let failed = FlankError::Singular("the compensation");
        let svd = square.try_svd(true, true, f64::EPSILON, ROUNDS).ok_or(failed.clone())?;
        let (Some(u), Some(v_t)) = (&svd.u, &svd.v_t) else { return Err(failed) };
        let singular_values: Vec<f64> = svd.singular_values.iter().copied().collect();
        let turned = u.transpose() * right;
        let least = f64::MIN_POSITIVE;
        let factor = |i: usize| if singular_values[i] > least { turned[i] / singular_values[i] } else { 0.0 };
        let parts = DMatrix::from_fn(unknowns, unknowns, |r, c| v_t[(c, r)] * factor(c));
        Ok(Self { singular_values, parts })
    }

    /// The singular values, falling.
    pub fn singular_values(&self) -> &[f64] {
        &self.singular_values
    }

    /// The change of the control points that keeps the first `rank` singular values.
    pub fn change(&self, rank: usize) -> DVector<f64> {
        self.parts.columns(0, rank.min(self.parts.ncols())).column_sum()
    }
}

/// The triangle that [J | -deviation] is turned into: blocks by themselves, a few at a time, each time together with
/// what is left of those before. The order is fixed, and no more than a few blocks are held.
fn triangle(
    grid: &DesignGrid,
    axis: &AxisSurface,
    cutter: &FlankCutter,
    (deviation, feet): (&Deviation, &Feet),
    (model, cancel): (Model, &Cancel),
) -> Result<DMatrix<f64>, FlankError> {
    const LEAST: usize = 512;
    const AT_ONCE: usize = 8;
    let n = axis.lower().len();
    let width = 6 * n + 1;
    // A block much higher than wide is turned into a triangle much smaller than itself.
    let size = LEAST.max(4 * width);
    let of_block = |(block, places): (usize, &[GridPlace])| -> Result<DMatrix<f64>, FlankError> {
        cancel.check()?;
        let mut rows = DMatrix::zeros(places.len(), width);
        for (r, place) in places.iter().enumerate() {
            let k = block * size + r;
            let row = Row::of(axis, cutter, place, feet.at[k], model);
            row.entries(n).iter().for_each(|(c, value)| rows[(r, *c)] = *value);
            rows[(r, width - 1)] = -deviation.values[k];
        }
        Ok(rows.qr().r())
    };
    let places = grid.counted_places();
    let mut left = DMatrix::zeros(0, width);
    for start in (0..places.len()).step_by(AT_ONCE * size) {
        let end = places.len().min(start + AT_ONCE * size);
        let first = start / size;
        let blocks = places[start..end].par_chunks(size).enumerate();
        let blocks: Result<Vec<DMatrix<f64>>, FlankError> =
            blocks.map(|(block, places)| of_block((first + block, places))).collect();
        let blocks = blocks?;
        cancel.check()?;
        let height: usize = left.nrows() + blocks.iter().map(DMatrix::nrows).sum::<usize>();
        let mut all = DMatrix::zeros(height.max(width), width);
        let mut top = 0;
        for block in std::iter::once(&left).chain(&blocks) {
            all.rows_mut(top, block.nrows()).copy_from(block);
            top += block.nrows();
        }
        left = all.qr().r();
    }
    Ok(left)
}

/// A path with its deviation and where its axis stands.
#[derive(Debug, Clone)]
pub struct Measured {
    /// The surface that its axis sweeps.
    pub axis: AxisSurface,
    /// Deviation over the design surface.
    pub deviation: Deviation,
    /// Foot points of the axis over the samples of the grid.
    pub feet: Feet,
    /// Least and greatest t at which the moving cutter grazes the surface's ends.
    grazing: [f64; 2],
    /// How far in t it grazes them before it stands over the surface's beginning, or after it stands over its end, at
    /// most.
    pub(super) lag: f64,
    /// Least and greatest height (mm) above the tip of the places of the axis over the lower guide.
    pub heights_mm: [f64; 2],
}

impl Measured {
    /// Measures a path; `near` says where the axis of a similar one stood.
    ///
    /// # Errors
    /// [`FlankError::Unmeasured`].
    pub fn new(
        grid: &DesignGrid,
        axis: AxisSurface,
        cutter: &FlankCutter,
        near: Option<&Feet>,
    ) -> Result<Self, FlankError> {
        let (deviation, feet) = grid.deviation(&axis, cutter, near)?;
        let [along, across] = grid.size();
        // A closed path has no ends.
        let ends = (0..across).chain((along - 1) * across..along * across).filter(|_| !axis.is_closed());
        let (mut grazing, mut lag) = ([f64::INFINITY, f64::NEG_INFINITY], 0.0f64);
        for k in ends {
            let outwards = if k < across { -1.0 } else { 1.0 };
            // Where it does not graze there is nothing more to be covered.
            let Some(found) = envelope_over(&axis, cutter, &grid.grid_places()[k], feet.at[k]) else { continue };
            grazing = [grazing[0].min(found.t), grazing[1].max(found.t)];
            lag = lag.max(outwards * (found.t - feet.at[k].x));
        }
        let heights = feet.at.iter().step_by(across).map(|q| q.y * axis.at(q.x).length());
        let widest = |[low, high]: [f64; 2], h: f64| [low.min(h), high.max(h)];
        let heights_mm = heights.fold([f64::INFINITY, f64::NEG_INFINITY], widest);
        Ok(Self { axis, deviation, feet, grazing, lag, heights_mm })
    }

    /// Least and greatest t that the path must have to cover the surface, standing and moving; 0 and 1 of a closed
    /// path, which has every t.
    pub fn t_range(&self) -> [f64; 2] {
        if self.axis.is_closed() {
            return [0.0, 1.0];
        }
        let [first, last] = self.feet.t_range();
        [first.min(self.grazing[0]), last.max(self.grazing[1])]
    }

    /// Whether the path begins before and ends behind the surface, by where the cutter stands over it.
    pub fn stands_over_all(&self) -> bool {
        let [first, last] = self.feet.t_range();
        self.axis.is_closed() || (first >= 0.0 && last <= 1.0)
    }

    /// Whether it covers all that `other` covers, standing and moving.
    pub(super) fn covers_as(&self, other: &Self) -> bool {
        self.covers() || (!other.covers() && (self.stands_over_all() || !other.stands_over_all()))
    }

    /// Whether it also grazes all of the surface while it moves.
    pub fn covers(&self) -> bool {
        let [first, last] = self.t_range();
        first >= 0.0 && last <= 1.0
    }
}

impl Measured {
    /// Sum of the absolute deviations (mm) over the grid of the surface, or over as many places of the axis surface; none
    /// where one of these has no foot.
    ///
    /// # Errors
    /// Cancelled, and whatever else keeps it from being measured.
    pub fn sum(
        &self,
        over: SumOver,
        (surface, grid): (&RuledSurface, &DesignGrid),
        cutter: &FlankCutter,
    ) -> Result<Option<f64>, FlankError> {
        match over {
            SumOver::Surface => Ok(Some(self.deviation.sum)),
            SumOver::Axis => match on_axis_grid(surface, &self.axis, cutter, grid.size()) {
                Ok(deviation) => Ok(Some(deviation.sum)),
                Err(FlankError::Unmeasured { .. }) => Ok(None),
                Err(other) => Err(other),
            },
        }
    }
}

/// Tries every rank in one step from `start` and answers the path of the least sum; `start` itself if none is better by
/// more than rounding, or if there is nothing to gain. A cylinder that leaves its heights is put back along its axis.
/// `grid` is of `surface`.
///
/// # Errors
/// [`FlankError::Singular`], cancelled.
pub fn best_rank(
    (surface, grid): (&RuledSurface, &DesignGrid),
    start: &Measured,
    cutter: &FlankCutter,
    (model, sum_over): (Model, SumOver),
    cancel: &Cancel,
) -> Result<(Measured, RankCurve), FlankError> {
    let sum_of = |path: &Measured| path.sum(sum_over, (surface, grid), cutter);
    let system = Compensation::new(grid, &start.axis, cutter, (&start.deviation, &start.feet), (model, cancel))?;
    let (heights, advance) = (Heights::of(start, cutter), Advance::of(&start.axis, 0.0));
    let must_cover = start.stands_over_all();
    let allowed = |path: Measured| {
        let path = heights.kept(grid, path, start, cutter)?;
        ((path.stands_over_all() || !must_cover) && advance.is_kept(&path.axis)).then_some(path)
    };
    // The sum of each, and that of the path taken for it, if one is allowed.
    let candidate = |rank: usize| -> Result<Option<(f64, Option<f64>)>, FlankError> {
        cancel.check()?;
        let path = path_of(grid, start, cutter, &system, rank);
        let Some(path) = path else { return Ok(None) };
        let Some(sum) = sum_of(&path)? else { return Ok(None) };
        Ok(Some((sum, allowed(path).map(|path| sum_of(&path)).transpose()?.flatten())))
    };
    let ranks = system.singular_values().len();
    let found: Result<Vec<_>, _> = (1..=ranks).into_par_iter().map(candidate).collect();
    let found = found?;
    let rounding = ROUNDING_MM * start.deviation.counted().len() as f64;
    let start_sum = sum_of(start)?.unwrap_or(f64::INFINITY);
    let mut best = (0, start_sum - rounding);
    for (i, candidate) in found.iter().enumerate().filter(|_| !start.deviation.is_settled()) {
        if let Some((_, Some(sum))) = *candidate
            && sum < best.1
        {
            best = (i + 1, sum);
        }
    }
    let chosen = if best.0 > 0 { path_of(grid, start, cutter, &system, best.0).and_then(allowed) } else { None };
    let of_rank = |i: usize| match &chosen {
        Some(_) if i + 1 == best.0 => Some(best.1),
        _ => found[i].map(|(sum, _)| sum),
    };
    let sums = (0..ranks).map(of_rank).collect();
    let singular_values = system.singular_values().to_vec();
    let curve = RankCurve { singular_values, sums, start_sum, best: best.0, grid: grid.size() };
    Ok((chosen.unwrap_or_else(|| start.clone()), curve))
}

fn path_of(
    grid: &DesignGrid,
    start: &Measured,
    cutter: &FlankCutter,
    system: &Compensation,
    rank: usize,
) -> Option<Measured> {
    let axis = start.axis.moved(&system.change(rank)).ok()?;
    Measured::new(grid, axis, cutter, Some(&start.feet)).ok()
}
