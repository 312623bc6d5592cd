//! Refinement beyond P4: damped Gauss-Newton steps with the exact derivative, for sums of absolute values by
//! re-weighting, with bounds by growing penalties.
//!
//! Guaranteed: the answer is no worse in its objective than the start, and covers the surface if the start does. Not
//! guaranteed: that no other path is better.

use nalgebra::{Cholesky, DMatrix, DVector};
use rayon::prelude::*;

use super::FlankError;
use super::compensation::{Measured, Model, Row};
use super::cutter::FlankCutter;
use super::deviation::{DesignGrid, Deviation};
use super::params::Objective;
use crate::progress::{Cancel, Progress};

/// What a step makes smaller: the sum over places of a function that nears the objective.
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
        deviation.values.iter().map(|e| self.at(*e)[0]).sum()
    }
}

/// How far beyond the bounds of an objective a path goes (mm).
pub fn beyond_bounds(objective: Objective, deviation: &Deviation) -> f64 {
    let [least, most] = bounds_of(objective);
    (deviation.most_undercut - most).max(least - deviation.most_overcut).max(0.0)
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
fn is_better(objective: Objective, a: &Deviation, b: &Deviation) -> bool {
    /// What is beyond a bound by less counts as within (mm).
    const NOTHING: f64 = 1e-7;
    let beyond = [a, b].map(|d| beyond_bounds(objective, d).max(NOTHING));
    let of = |d: &Deviation| if objective == Objective::Rms { d.rms } else { d.sum };
    if beyond[0] != beyond[1] { beyond[0] < beyond[1] } else { of(a) < of(b) }
}

/// Refines `start` in at most `rounds` steps.
///
/// # Errors
/// Cancelled.
pub fn refine(
    grid: &DesignGrid,
    start: &Measured,
    cutter: &FlankCutter,
    (objective, rounds): (Objective, usize),
    (progress, cancel): (&Progress, &Cancel),
) -> Result<Measured, FlankError> {
    const STAGE: usize = 8;
    let scale = start.deviation.mean.max(1e-9);
    let bounds = bounds_of(objective);
    let mut merit = Merit { is_square: objective == Objective::Rms, soft: 0.5 * scale, bounds, penalty: 10.0 / scale };
    let (mut best, mut now, mut damping) = (start.clone(), start.clone(), 1e-3);
    let mut in_stage = 0;
    for round in 0..rounds {
        cancel.check()?;
        progress.report("refining the path", round as f64 / rounds as f64, "");
        let (next, gained) = step(grid, &now, cutter, &merit, &mut damping);
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
    Ok(best)
}

/// One step that makes the merit smaller, and by which share of it; none if no damping is enough.
fn step(
    grid: &DesignGrid,
    now: &Measured,
    cutter: &FlankCutter,
    merit: &Merit,
    damping: &mut f64,
) -> (Option<Measured>, f64) {
    const TRIES: usize = 8;
    /// How much sliding along the path is held back, as a share of the matrix's mean diagonal.
    const GAUGE: f64 = 0.03;
    let (matrix, slope) = normal_equations(grid, now, cutter, merit);
    let value = merit.of(&now.deviation);
    let mean = matrix.diagonal().mean();
    let matrix = matrix + sliding(now, GAUGE * mean);
    for _ in 0..TRIES {
        let mut damped = matrix.clone();
        // Sliding the control points along the path changes nothing: those directions need damping of their own.
        (0..damped.nrows()).for_each(|i| damped[(i, i)] += *damping * matrix[(i, i)] + 1e-7 * mean);
        let next = Cholesky::new(damped).and_then(|system| {
            let axis = now.axis.moved(&-system.solve(&slope)).ok()?;
            Measured::new(grid, axis, cutter, Some(&now.feet)).ok()
        });
        if let Some(next) = next.filter(|next| next.covers() || !now.covers()) {
            let gain = value - merit.of(&next.deviation);
            if gain > 0.0 {
                *damping = (*damping * 0.2).max(1e-9);
                return (Some(next), gain / value);
            }
        }
        *damping = (*damping * 8.0).min(1e6);
    }
    (None, 0.0)
}

/// Squares of how far the axis's ends slide along their own curves: such steps change next to nothing but, left free,
/// carry the path's ends off the surface.
fn sliding(now: &Measured, weight: f64) -> DMatrix<f64> {
    let n = now.axis.lower().len();
    let mut matrix = DMatrix::zeros(6 * n, 6 * n);
    let looks = 3 * n;
    for i in 0..looks {
        let t = i as f64 / (looks - 1) as f64;
        let (at, basis) = (now.axis.at(t), now.axis.basis().at(t));
        for (curve, speed) in [at.tip_speed, at.top_speed].into_iter().enumerate() {
            let along = speed.normalize_or_zero();
            let entry = |k: usize| {
                let unknown = 3 * (curve * n + basis.first + k / 3) + k % 3;
                (unknown, basis.values[k / 3] * along[k % 3])
            };
            for (row, a) in (0..12).map(entry) {
                (0..12).map(entry).for_each(|(column, b)| matrix[(row, column)] += weight * a * b);
            }
        }
    }
    matrix
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
    let places = grid.grid_places();
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
