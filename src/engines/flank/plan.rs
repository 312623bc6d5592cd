//! A whole plan: first locations, axis surface, compensation over every rank, refinement, checks.

use rayon::prelude::*;

use super::FlankError;
use super::axis_surface::AxisSurface;
use super::compensation::{Measured, Model, RankCurve, best_rank};
use super::cutter::FlankCutter;
use super::deviation::{DesignGrid, ROUNDING_MM};
use super::heights::Heights;
use super::offset::{CutterLocation, three_point, two_point};
use super::params::{FlankParams, OffsetMethod, SumOver};
use super::path::FlankPath;
use super::refine::{is_better, is_settled, refine};
use super::ruled_surface::RuledSurface;
use super::warning::{self, PlanWarning};
use task::{Cancel, Task};

/// Remark where the cutter touches all of the surface from the start.
pub const WITHIN_ROUNDING: &str = "touches within rounding";

/// A path and those that it came from.
#[derive(Debug, Clone, PartialEq)]
pub struct FlankPlan {
    /// The cutter, whole.
    pub cutter: FlankCutter,
    /// Parameters of the plan.
    pub params: FlankParams,
    /// The locations by offset.
    pub locations: Vec<CutterLocation>,
    /// How far the curves of the first path are from them at most (mm); around a closed surface also from those midway.
    pub fit_mm: f64,
    /// The path through them.
    pub initial: FlankPath,
    /// Sums over ranks.
    pub ranks: RankCurve,
    /// The path of the best rank.
    pub chosen: FlankPath,
    /// The path made best in the objective; the chosen one again if no rounds were asked for.
    pub refined: FlankPath,
    /// Warnings on the plan.
    pub warnings: Vec<PlanWarning>,
}

impl FlankPlan {
    /// The paths and their names: initial, chosen, refined.
    pub fn paths(&self) -> [(&'static str, &FlankPath); 3] {
        [("initial", &self.initial), ("chosen", &self.chosen), ("refined", &self.refined)]
    }

    /// Warnings on one of the paths, in words: those of the plan, and of this path.
    pub fn warnings_of<'a>(&'a self, path: &'a str) -> impl Iterator<Item = &'a str> {
        let of_it = self.warnings.iter().filter(move |warning| warning.path.is_none_or(|of| of == path));
        of_it.map(|warning| warning.text.as_str())
    }

    /// The sum of absolute deviations of a path as a share of the initial one's.
    pub fn ratio(&self, path: &FlankPath) -> f64 {
        path.deviation.sum / self.initial.deviation.sum.max(f64::MIN_POSITIVE)
    }

    /// Whether there is any deviation to speak of: a plane or a cylinder is touched everywhere from the start, and
    /// shares of what rounding leaves mean nothing.
    pub fn has_deviation(&self) -> bool {
        self.initial.deviation.mean > ROUNDING_MM
    }

    /// A sum of absolute deviations (mm) as a share of the initial one, unless that is nothing but rounding.
    pub fn share(&self, sum: f64) -> Option<f64> {
        self.has_deviation().then(|| sum / self.initial.deviation.sum)
    }

    /// Sum of the moving cutter on a path as a share of its sum on the initial one.
    pub fn moving_share(&self, path: &FlankPath) -> Option<f64> {
        let [sum, first] = [path, &self.initial].map(|path| path.envelope.deviation.sum);
        self.has_deviation().then(|| sum / first.max(f64::MIN_POSITIVE))
    }

    /// A [`Self::share`] in words, as in `ratio 0.541`.
    pub fn ratio_words(&self, sum: f64) -> String {
        self.share(sum).map_or_else(|| WITHIN_ROUNDING.to_owned(), |share| format!("ratio {share:.3}"))
    }
}

/// Plans a flank path. A cutter that is too short or too thick is planned with as if it were not, and the plan's
/// warnings say so.
///
/// # Errors
/// [`FlankError`] that says what is wrong with cutter or parameters, or that no path can be measured; cancelled.
pub fn plan_flank(
    surface: &RuledSurface,
    cutter: &FlankCutter,
    params: &FlankParams,
    task: &Task,
) -> Result<FlankPlan, FlankError> {
    params.validate()?;
    cutter.validate()?;
    let whole = cutter;
    let cutter = &whole.above(params.below_mm)?;
    let grid = DesignGrid::new(surface, params.grid);
    task.report("placing the cutter", 0.0, "");
    let Start { locations, fit_mm, path: start } = covering_start(surface, cutter, params, &grid, &task.cancel)?;
    task.report("evaluating every rank", 0.0, "");
    let (chosen, ranks) = ranked(surface, &grid, &start, cutter, ((params.row, params.sum), &task.cancel))?;
    let heights = Heights::of(&start, cutter);
    let refined = refined(surface, &grid, &chosen, (cutter, &heights), params, task)?;
    task.report("computing the swept envelope", 0.0, "");
    let path = |measured: Measured| -> Result<FlankPath, FlankError> {
        task.check()?;
        Ok(FlankPath::of(&grid, cutter, measured, (params.locations, params.below_mm)))
    };
    let (initial, chosen, refined) = (path(start)?, path(chosen)?, path(refined)?);
    let (cutter, params) = (whole.clone(), params.clone());
    let mut plan =
        FlankPlan { cutter, params, locations, fit_mm, initial, ranks, chosen, refined, warnings: Vec::new() };
    plan.warnings = warning::of_plan(surface, &plan);
    task.report("computing the swept envelope", 1.0, "");
    Ok(plan)
}

/// A fine grid's coarse one, on which steps far from the answer are taken.
const COARSE: [usize; 2] = [100, 50];

/// Whether a grid is so fine that a coarse one leads near to the answer.
fn is_fine([along, across]: [usize; 2]) -> bool {
    along * across > 4 * COARSE[0] * COARSE[1]
}

/// The path of the best rank; of a fine grid the ranks are tried on a coarse one.
fn ranked(
    surface: &RuledSurface,
    grid: &DesignGrid,
    start: &Measured,
    cutter: &FlankCutter,
    (by, cancel): ((Model, SumOver), &Cancel),
) -> Result<(Measured, RankCurve), FlankError> {
    if !is_fine(grid.size()) {
        return best_rank((surface, grid), start, cutter, by, cancel);
    }
    let coarse = DesignGrid::new(surface, COARSE);
    let near = Measured::new(&coarse, start.axis.clone(), cutter, None)?;
    let (chosen, mut ranks) = best_rank((surface, &coarse), &near, cutter, by, cancel)?;
    let chosen = Measured::new(grid, chosen.axis, cutter, Some(&start.feet)).ok();
    let sum = |path: &Measured| path.sum(by.1, (surface, grid), cutter);
    let before = sum(start)?.unwrap_or(f64::INFINITY);
    let after = chosen.as_ref().map(sum).transpose()?.flatten();
    // Not by the rounding of either.
    let is_better = after.is_some_and(|after| before - after > ROUNDING_MM * start.deviation.counted().len() as f64);
    let chosen = chosen.filter(|path| is_better && (path.stands_over_all() || !start.stands_over_all()));
    if chosen.is_none() {
        ranks.best = 0;
    }
    Ok((chosen.unwrap_or_else(|| start.clone()), ranks))
}

/// The path refined; on a fine grid first on a coarser one, which costs little and leads near to the answer. One that
/// touches well enough everywhere is kept: steps would only slide it along the surface.
fn refined(
    surface: &RuledSurface,
    grid: &DesignGrid,
    chosen: &Measured,
    (cutter, heights): (&FlankCutter, &Heights),
    params: &FlankParams,
    task: &Task,
) -> Result<Measured, FlankError> {
    if is_settled(params.objective, &chosen.deviation) {
        return Ok(chosen.clone());
    }
    if !is_fine(grid.size()) {
        return refine(grid, chosen, (cutter, heights), (params.objective, params.rounds, 0.5), task);
    }
    let coarse = DesignGrid::new(surface, COARSE);
    let near = Measured::new(&coarse, chosen.axis.clone(), cutter, None)
        .and_then(|start| refine(&coarse, &start, (cutter, heights), (params.objective, params.rounds, 0.5), task))
        .and_then(|near| Measured::new(grid, near.axis, cutter, Some(&chosen.feet)));
    task.check()?;
    let near = near.ok().filter(|near| is_better(params.objective, &near.deviation, &chosen.deviation));
    let near = near.filter(|near| near.covers_as(chosen) && heights.keeps_as(near, chosen));
    let start = near.as_ref().unwrap_or(chosen);
    refine(grid, start, (cutter, heights), (params.objective, params.rounds.div_ceil(4), 0.05), task)
}

/// The location at `u0` by the method asked for.
fn location(
    surface: &RuledSurface,
    cutter: &FlankCutter,
    params: &FlankParams,
    u0: f64,
) -> Result<CutterLocation, FlankError> {
    match params.offset {
        OffsetMethod::TwoPoint => two_point(surface, cutter, u0, u0),
        OffsetMethod::ThreePoint => three_point(surface, cutter, u0, params.slide_u),
    }
}

/// `n` locations evenly over a range of u0.
fn locations(
    surface: &RuledSurface,
    cutter: &FlankCutter,
    params: &FlankParams,
    (n, [from, to]): (usize, [f64; 2]),
    cancel: &Cancel,
) -> Result<Vec<CutterLocation>, FlankError> {
    let one = |i: usize| {
        cancel.check()?;
        let share = i as f64 / (n - 1) as f64;
        location(surface, cutter, params, from + share * (to - from))
    };
    (0..n).into_par_iter().map(one).collect()
}

/// Locations, their path, and how far it is from them at most (mm).
struct Start {
    locations: Vec<CutterLocation>,
    fit_mm: f64,
    path: Measured,
}

/// Locations and their path, from ends that cover the surface if that is asked for and possible.
fn covering_start(
    surface: &RuledSurface,
    cutter: &FlankCutter,
    params: &FlankParams,
    grid: &DesignGrid,
    cancel: &Cancel,
) -> Result<Start, FlankError> {
    if surface.is_closed() {
        return closed_start((surface, cutter), params, grid, cancel);
    }
    const ROUNDS: usize = 6;
    /// How far past the ends of the guides locations may go.
    const FURTHEST: f64 = 0.25;
    let mut range = [0.0, 1.0];
    if params.is_covering {
        let ends = [(0.0, -1.0), (1.0, 1.0)].map(|(end, away)| {
            let needed = end_needed(surface, cutter, params, end, away * FURTHEST).unwrap_or(end);
            needed + away * params.overrun_u
        });
        range = [ends[0].max(-FURTHEST), ends[1].min(1.0 + FURTHEST)];
    }
    let mut found = None;
    for _ in 0..ROUNDS {
        let all = locations(surface, cutter, params, (params.locations, range), cancel)?;
        let axis = AxisSurface::fit(&all, params.control_points, false)?;
        let start = Measured::new(grid, axis, cutter, None)?;
        let [first, last] = start.t_range();
        let covers = start.covers();
        found = Some((all, start));
        if covers || !params.is_covering {
            break;
        }
        // The middle of the surface may lie further out than either guide's end.
        let width = range[1] - range[0];
        let more = |missing: f64| if missing > 0.0 { missing * width + params.overrun_u.max(1e-3) } else { 0.0 };
        let next = [(range[0] - more(-first)).max(-FURTHEST), (range[1] + more(last - 1.0)).min(1.0 + FURTHEST)];
        if next == range {
            break;
        }
        range = next;
    }
    let (locations, path) = found.ok_or(FlankError::Singular("the first path"))?;
    Ok(Start { fit_mm: path.axis.furthest(&locations), locations, path })
}

/// How far a path around a closed surface may be from its locations (mm): a twentieth of the overcut that is usually
/// let pass.
pub const RING_FIT_MM: f64 = 0.005;

/// Locations once around a closed surface, the last where the first is, and their closed path: it needs no more to
/// cover the surface. A ring turns by 360 degrees, for which the control points asked for may be too few: they are made
/// more until the path keeps to its locations and to those midway between them.
fn closed_start(
    (surface, cutter): (&RuledSurface, &FlankCutter),
    params: &FlankParams,
    grid: &DesignGrid,
    cancel: &Cancel,
) -> Result<Start, FlankError> {
    let most = most_around(params);
    let mut count = params.control_points;
    loop {
        // More than twice as many locations as control points leave the fit no room to swing between them.
        let n = if count > params.control_points { params.locations.max(2 * count) } else { params.locations };
        let with_midway = locations(surface, cutter, params, (2 * n + 1, [0.0, 1.0]), cancel)?;
        let all: Vec<CutterLocation> = with_midway.iter().step_by(2).copied().collect();
        let axis = AxisSurface::fit(&all, count, true)?;
        let fit_mm = axis.furthest(&with_midway);
        if fit_mm <= RING_FIT_MM || count >= most {
            return Ok(Start { locations: all, fit_mm, path: Measured::new(grid, axis, cutter, None)? });
        }
        count = (count + count.div_ceil(4)).min(most);
    }
}

/// The most control points that a closed path is given: as many as were asked for, or one for two of the grid's places
/// around. With more of them refinement would follow single places.
fn most_around(params: &FlankParams) -> usize {
    let [along, across] = params.grid;
    let places = (along - 1).saturating_mul(across);
    let most = ((along - 1) / 2).min(places / FlankParams::PLACES_EACH).min(FlankParams::MOST_CONTROL_POINTS);
    most.max(params.control_points)
}

/// u0 of the location whose upper contact is at the `end` of the upper guide, if it lies past the end of the lower one.
fn end_needed(
    surface: &RuledSurface,
    cutter: &FlankCutter,
    params: &FlankParams,
    end: f64,
    furthest: f64,
) -> Option<f64> {
    const ROUNDS: usize = 60;
    let off = |u0: f64| location(surface, cutter, params, u0).ok().map(|l| (l.u1 - end) * furthest.signum());
    // Positive: the upper contact is past the end already.
    if off(end)? >= 0.0 {
        return None;
    }
    let (mut short, mut past) = (end, end + furthest);
    if off(past)? < 0.0 {
        return Some(past);
    }
    for _ in 0..ROUNDS {
        let middle = 0.5 * (short + past);
        if off(middle)? < 0.0 {
            short = middle;
        } else {
            past = middle;
        }
        if (past - short).abs() < 1e-12 {
            break;
        }
    }
    Some(past)
}
