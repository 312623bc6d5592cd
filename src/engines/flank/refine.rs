//! Refinement beyond P4: damped Gauss-Newton steps with the exact derivative, for sums of absolute values by
//! re-weighting, with bounds by growing penalties.
//!
//! Guaranteed: the answer is no worse in its objective than the start, covers the surface, along it and in height, if
//! the start does, and none of its control points has moved back behind the one before. Not guaranteed: that no other
//! path is better. Steps stop where the moving cutter no longer does what the standing one does, see [`envelope`].

use nalgebra::{Cholesky, DMatrix, DVector};
use rayon::prelude::*;

use super::FlankError;
use super::advance::Advance;
use super::compensation::{Measured, Model, Row};
use super::cutter::FlankCutter;
use super::deviation::{DesignGrid, Deviation};
use super::edges::Edges;
use super::envelope;
use super::heights::Heights;
use super::params::Objective;
use super::path::FlankPath;
use task::Task;

/// Merit function of a step: the sum over places of a function that approximates the objective.
#[derive(Debug, Clone, Copy)]
struct Merit {
    /// Whether squares are summed, not absolute values.
    is_square: bool,
    /// Below this (mm) absolute values are rounded off.
    soft: f64,
    /// Least and greatest deviation (mm).
    bounds: [f64; 2],
    /// How much the square of what is beyond the bounds counts.
    penalty: f64,
}

impl Merit {
    /// Value, derivative, and weight of the square that lies above it and touches it there.
    fn at(&self, e: f64) -> [f64; 3] {
        let beyond = (e - self.bounds[1]).max(0.0) + (e - self.bounds[0]).min(0.0);
        let round = (e * e + self.soft * self.soft).sqrt();
        let [value, slope, weight] =
            if self.is_square { [0.5 * e * e, e, 1.0] } else { [round, e / round, 1.0 / round] };
        let extra = if beyond == 0.0 { 0.0 } else { self.penalty };
        [value + 0.5 * extra * beyond * beyond, slope + extra * beyond, weight + extra]
    }

    fn of(&self, deviation: &Deviation) -> f64 {
        deviation.counted().iter().map(|e| self.at(*e)[0]).sum()
    }
}

/// Excess of a path over the bounds of an objective (mm).
pub fn beyond_bounds(objective: Objective, deviation: &Deviation) -> f64 {
    let [least, most] = bounds_of(objective);
    (deviation.most_undercut - most).max(least - deviation.most_overcut).max(0.0)
}

/// Excess of a path over the bounds of an objective (mm), static or of the swept envelope, whichever is worse.
pub fn path_beyond_bounds(objective: Objective, path: &FlankPath) -> f64 {
    beyond_bounds(objective, &path.deviation).max(beyond_bounds(objective, &path.envelope.deviation))
}

fn bounds_of(objective: Objective) -> [f64; 2] {
    match objective {
        Objective::Bounded { overcut_mm, undercut_mm } => {
            [overcut_mm.map_or(f64::NEG_INFINITY, |x| -x), undercut_mm.unwrap_or(f64::INFINITY)]
        }
        _ => [f64::NEG_INFINITY, f64::INFINITY],
    }
}

/// Whether `a` is a better answer than `b`: nearer to the bounds first, then by what is summed.
pub(super) fn is_better(objective: Objective, a: &Deviation, b: &Deviation) -> bool {
    /// Excess over a bound that still counts as within (mm).
    const NOTHING: f64 = 1e-7;
    let beyond = [a, b].map(|d| beyond_bounds(objective, d).max(NOTHING));
    let of = |d: &Deviation| if objective == Objective::Rms { d.rms } else { d.sum };
    if beyond[0] != beyond[1] { beyond[0] < beyond[1] } else { of(a) < of(b) }
}

/// Whether a path is within its bounds and touches so well that there is nothing to gain.
pub(super) fn is_settled(objective: Objective, deviation: &Deviation) -> bool {
    deviation.is_settled() && beyond_bounds(objective, deviation) == 0.0
}

/// Refines `start` in at most `rounds` steps. `soft` says from which share of the mean deviation on absolute values are
/// rounded off at first: 0.5 far from the answer, less near to it. `heights` are those
/// that the first path has. Bounds are made narrower by what the moving cutter
/// goes beyond them, and refinement goes on.
///
/// # Errors
/// Cancelled.
pub fn refine(
    grid: &DesignGrid,
    start: &Measured,
    (cutter, heights): (&FlankCutter, &Heights),
    (objective, rounds, soft): (Objective, usize, f64),
    task: &Task,
) -> Result<Measured, FlankError> {
    const TRIES: usize = 3;
    /// Excess over a bound that still counts as within (mm).
    const KEPT: f64 = 1e-6;
    let mut answer = refine_standing((grid, cutter, heights), start, (objective, rounds, soft), task)?;
    let Objective::Bounded { mut overcut_mm, mut undercut_mm } = objective else { return Ok(answer) };
    let [least, most] = bounds_of(objective);
    let moving_of =
        |path: &Measured| envelope::check(grid, &path.axis, cutter, (&path.deviation, &path.feet)).deviation;
    let mut moving = moving_of(&answer);
    for _ in 0..TRIES {
        let beyond = beyond_bounds(objective, &moving).max(beyond_bounds(objective, &answer.deviation));
        if beyond < KEPT || rounds == 0 {
            break;
        }
        // What is beyond a bound while the cutter stands is for refinement itself.
        let (still, beyond_of) = (&answer.deviation, |off: f64, more: f64| if off > 0.0 { more.max(0.0) } else { 0.0 });
        let over = beyond_of(least - moving.most_overcut, still.most_overcut - moving.most_overcut);
        let under = beyond_of(moving.most_undercut - most, moving.most_undercut - still.most_undercut);
        overcut_mm = overcut_mm.map(|x| x - over);
        undercut_mm = undercut_mm.map(|x| x - under);
        let narrower = Objective::Bounded { overcut_mm, undercut_mm };
        let next = refine_standing((grid, cutter, heights), &answer, (narrower, rounds, 0.2), task)?;
        let next_moving = moving_of(&next);
        if beyond_bounds(objective, &next_moving).max(beyond_bounds(objective, &next.deviation)) >= beyond {
            break;
        }
        (answer, moving) = (next, next_moving);
    }
    Ok(answer)
}

/// Refines `start` with bounds on what the standing cutter does.
fn refine_standing(
    (grid, cutter, heights): (&DesignGrid, &FlankCutter, &Heights),
    start: &Measured,
    (objective, rounds, soft): (Objective, usize, f64),
    task: &Task,
) -> Result<Measured, FlankError> {
    const STAGE: usize = 8;
    /// Share by which the moving cutter's sum may differ from the standing one's.
    const TRUSTED: f64 = 0.02;
    let scale = start.deviation.mean.max(1e-9);
    let bounds = bounds_of(objective);
    let mut merit = Merit { is_square: objective == Objective::Rms, soft: soft * scale, bounds, penalty: 10.0 / scale };
    let (edges, advance) = (Edges::of(start, heights, scale), Advance::of(&start.axis, scale));
    let (mut best, mut now, mut damping) = (start.clone(), start.clone(), 1e-3);
    // Bounds come before that: the moving cutter is held to them by itself.
    let is_bounded = matches!(objective, Objective::Bounded { .. });
    let trusted_share = if is_bounded { 2.5 * TRUSTED } else { TRUSTED };
    let allowed = moving_difference(grid, start, cutter).max(trusted_share);
    let (mut trusted, mut checked, mut in_stage) = (start.clone(), 0, 0);
    for round in 0..rounds {
        task.check()?;
        task.report("refining the path", round as f64 / rounds as f64, "");
        let (next, gained) = step(grid, &now, (cutter, heights), (&merit, &edges, &advance), &mut damping);
        in_stage += 1;
        if let Some(next) = next {
            if is_better(objective, &next.deviation, &best.deviation) {
                best = next.clone();
            }
            now = next;
        }
        if gained > 2e-4 && in_stage < STAGE {
            continue;
        }
        if round >= checked + STAGE {
            if moving_difference(grid, &best, cutter) > allowed {
                return Ok(trusted);
            }
            (trusted, checked) = (best.clone(), round);
        }
        let is_sharp = merit.is_square || merit.soft < 2e-3 * scale;
        let beyond = beyond_bounds(objective, &now.deviation);
        if is_sharp && gained < 1e-6 && beyond < 1e-7 {
            break;
        }
        in_stage = 0;
        merit.soft = (0.4 * merit.soft).max(1e-3 * scale);
        merit.penalty = (4.0 * merit.penalty).min(1e5 / scale);
        // What a penalty still lets through is asked for beforehand.
        if is_sharp && beyond > 0.0 {
            let least = (bounds[0] - now.deviation.most_overcut).max(0.0);
            let most = (now.deviation.most_undercut - bounds[1]).max(0.0);
            merit.bounds = [merit.bounds[0] + least, merit.bounds[1] - most];
        }
    }
    Ok(if moving_difference(grid, &best, cutter) > allowed { trusted } else { best })
}

/// Share by which the sum of deviations differs while the cutter moves. A path that swings from side to side can
/// have little deviation wherever it stands and much between.
fn moving_difference(grid: &DesignGrid, path: &Measured, cutter: &FlankCutter) -> f64 {
    let moving = envelope::check(grid, &path.axis, cutter, (&path.deviation, &path.feet));
    (moving.deviation.sum - path.deviation.sum).abs() / path.deviation.sum.max(f64::MIN_POSITIVE)
}

/// One step that makes the merit smaller, and by which share of it; none if no damping is enough.
fn step(
    grid: &DesignGrid,
    now: &Measured,
    (cutter, heights): (&FlankCutter, &Heights),
    (merit, edges, advance): (&Merit, &Edges, &Advance),
    damping: &mut f64,
) -> (Option<Measured>, f64) {
    const TRIES: usize = 8;
    let (mut matrix, mut slope) = normal_equations(grid, now, cutter, merit);
    edges.add_to(grid, now, &mut matrix, &mut slope);
    advance.add_to(&now.axis, &mut matrix, &mut slope);
    let cost = |path: &Measured| merit.of(&path.deviation) + edges.cost(grid, path) + advance.cost(&path.axis);
    let value = cost(now);
    let mean = matrix.diagonal().mean();
    for _ in 0..TRIES {
        let mut damped = matrix.clone();
        // Sliding the control points along the path changes nothing: those directions need damping of their own.
        (0..damped.nrows()).for_each(|i| damped[(i, i)] += *damping * matrix[(i, i)] + 1e-7 * mean);
        let next = Cholesky::new(damped).and_then(|system| {
            let axis = now.axis.moved(&-system.solve(&slope)).ok()?;
            let next = Measured::new(grid, axis, cutter, Some(&now.feet)).ok()?;
            heights.kept(grid, next, now, cutter)
        });
        if let Some(next) = next.filter(|next| next.covers_as(now) && advance.is_kept(&next.axis)) {
            let gain = value - cost(&next);
            if gain > 0.0 {
                *damping = (*damping * 0.2).max(1e-9);
                return (Some(next), gain / value);
            }
        }
        *damping = (*damping * 8.0).min(1e6);
    }
    (None, 0.0)
}

/// Matrix and slope of the squares that lie above the merit.
fn normal_equations(
    grid: &DesignGrid,
    now: &Measured,
    cutter: &FlankCutter,
    merit: &Merit,
) -> (DMatrix<f64>, DVector<f64>) {
    // A fixed number of blocks, so that sums are the same on any number of threads.
    const BLOCKS: usize = 16;
    let places = grid.counted_places();
    let n = now.axis.lower().len();
    let size = places.len().div_ceil(BLOCKS);
    let of_block = |block: usize| {
        let (mut matrix, mut slope) = (DMatrix::zeros(6 * n, 6 * n), DVector::zeros(6 * n));
        for (k, place) in places.iter().enumerate().skip(block * size).take(size) {
            let row = Row::of(&now.axis, cutter, place, now.feet.at[k], Model::Moving);
            let entries = row.entries(n);
            let [_, first, weight] = merit.at(now.deviation.values[k]);
            for (c, (column, value)) in entries.iter().enumerate() {
                slope[*column] += first * value;
                let scaled = weight * value;
                // Entries rise, so this is the lower triangle.
                entries[c..].iter().for_each(|(r, other)| matrix[(*r, *column)] += scaled * other);
            }
        }
        (matrix, slope)
    };
    let blocks: Vec<_> = (0..BLOCKS).into_par_iter().map(of_block).collect();
    let (mut matrix, mut slope) = (DMatrix::zeros(6 * n, 6 * n), DVector::zeros(6 * n));
    for (m, s) in blocks {
        matrix += m;
        slope += s;
    }
    matrix.fill_upper_triangle_with_lower_triangle();
    (matrix, slope)
}
