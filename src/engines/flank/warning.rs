//! Warnings on a plan, in words.

use super::FlankError;
use super::offset::Touch;
use super::path::FlankPath;
use super::plan::{FlankPlan, RING_FIT_MM};
use super::refine::path_beyond_bounds;
use super::ruled_surface::RuledSurface;

/// Warning on a plan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlanWarning {
    /// Path that the warning is about: see [`FlankPlan::paths`]. None if it is about the whole plan.
    pub path: Option<&'static str>,
    /// Text of the warning.
    pub text: String,
}

/// All warnings of a plan.
pub(super) fn of_plan(surface: &RuledSurface, plan: &FlankPlan) -> Vec<PlanWarning> {
    let mut warnings = of_whole(surface, plan);
    for (name, path) in plan.paths() {
        let of_path = of_coverage(name, path).into_iter().chain(of_envelope(path));
        warnings.extend(of_path.map(|text| PlanWarning { path: Some(name), text }));
    }
    let refined = of_bounds(plan).into_iter().chain(of_refined(plan));
    warnings.extend(refined.map(|text| PlanWarning { path: Some("refined"), text }));
    warnings
}

/// Warnings on the plan as a whole.
fn of_whole(surface: &RuledSurface, plan: &FlankPlan) -> Vec<PlanWarning> {
    let mut warnings = Vec::new();
    if let Err(error) = plan.cutter.fits(surface, plan.params.below_mm) {
        let instead = match error {
            FlankError::CutterTooShort { .. } => "the path was planned as if its flutes were long enough",
            _ => "the path was planned all the same: see its overcut",
        };
        warnings.push(format!("{error}; {instead}"));
    }
    warnings.extend(of_locations(plan));
    warnings.extend(of_ring(plan));
    let [along, across] = plan.ranks.grid;
    if plan.ranks.grid != plan.params.grid {
        warnings.push(format!(
            "the grid is fine: ranks were tried on one of {along} x {across} places, and the sums over ranks are of \
             that one"
        ));
    }
    let before = &plan.initial.deviation;
    if before.is_settled() {
        warnings.push(format!(
            "the deviation of the initial path is at most {:.4} mm, within the rounding of guides with three \
             decimals: the initial path is also the chosen one",
            before.most_undercut.max(-before.most_overcut)
        ));
    } else if plan.ranks.best == 0 {
        let kept = "no rank reduces the total absolute deviation: the initial path is also the chosen one";
        warnings.push(kept.into());
    }
    warnings.into_iter().map(|text| PlanWarning { path: None, text }).collect()
}

/// Figures in which the refined path is worse than the first one.
fn of_refined(plan: &FlankPlan) -> Vec<String> {
    let mut warnings = Vec::new();
    let (before, after) = (&plan.initial.deviation, &plan.refined.deviation);
    if is_worse(before.most_undercut, after.most_undercut) {
        let (a, b) = (before.most_undercut, after.most_undercut);
        warnings.push(format!(
            "the refined path's sum is less, but its greatest undercut is {b:.4} mm where the initial one's is {a:.4} \
             mm; bound the undercut if that matters"
        ));
    }
    if is_worse(-before.most_overcut, -after.most_overcut) {
        let (a, b) = (-before.most_overcut, -after.most_overcut);
        warnings.push(format!(
            "the refined path's sum is less, but its greatest overcut is {b:.4} mm where the initial one's is {a:.4} \
             mm; bound the overcut if that matters"
        ));
    }
    warnings
}

/// Whether a deviation (mm) has grown so much that it is worth saying.
fn is_worse(before: f64, after: f64) -> bool {
    const SHARE: f64 = 1.1;
    const LEAST_MM: f64 = 1e-3;
    let before = before.max(0.0);
    after > SHARE * before && after - before > LEAST_MM
}

fn of_locations(plan: &FlankPlan) -> Option<String> {
    let missed = || plan.locations.iter().filter(|l| l.touch == Touch::NearestToThree);
    let first = missed().next()?;
    let worst = missed().filter_map(|l| l.middle_mm).fold(0.0, |worst: f64, m| worst.max(m.abs()));
    Some(format!(
        "{} of {} locations, the first at u0 = {:.4}, cannot touch the surface midway however far the upper contact \
         slides within {} of u: each was put where it comes nearest to it, at worst {worst:.1e} mm off",
        missed().count(),
        plan.locations.len(),
        first.u0,
        plan.params.slide_u
    ))
}

/// Around a closed surface the first path may still be far from its locations.
fn of_ring(plan: &FlankPlan) -> Option<String> {
    let axis = &plan.initial.axis;
    (axis.is_closed() && plan.fit_mm > RING_FIT_MM).then(|| {
        format!(
            "around the ring the first path is up to {:.4} mm off its locations with {} control points of each curve, \
             as many as a grid of {} places around is given; take a finer grid along u, or more control points",
            plan.fit_mm,
            axis.lower().len(),
            plan.params.grid[0]
        )
    })
}

fn of_bounds(plan: &FlankPlan) -> Option<String> {
    /// Tolerance of kept bounds (mm).
    const KEPT: f64 = 1e-4;
    let both = [&plan.refined.deviation, &plan.refined.envelope.deviation];
    let overcut = both.iter().fold(0.0, |most: f64, d| most.max(-d.most_overcut));
    let undercut = both.iter().fold(0.0, |most: f64, d| most.max(d.most_undercut));
    let beyond = path_beyond_bounds(plan.params.objective, &plan.refined);
    (beyond > KEPT).then(|| {
        format!(
            "the bounds asked for are not kept: the refined path goes {beyond:.4} mm beyond them, with overcut up to \
             {overcut:.4} mm and undercut up to {undercut:.4} mm, standing or moving; widen them, or take a thinner \
             cutter or more control points"
        )
    })
}

fn of_coverage(name: &str, path: &FlankPath) -> Vec<String> {
    let mut warnings = Vec::new();
    let [first, last] = path.coverage.t_range;
    if !path.coverage.is_whole {
        warnings.push(format!(
            "the {name} path does not cover the surface: it runs from t = 0 to 1 and {first:.4} to {last:.4} are \
             needed; deviations past its ends are those of the path gone on"
        ));
    }
    let [lowest, _] = path.coverage.height_range_mm;
    if lowest < -5e-3 {
        warnings.push(format!(
            "on the {name} path the flutes end {:.4} mm above the lowest line of the surface that they should cut; \
             raise Extend below (--below) by that much",
            -lowest
        ));
    }
    warnings
}

fn of_envelope(path: &FlankPath) -> Option<String> {
    let (still, moving) = (&path.deviation, &path.envelope.deviation);
    // Of next to nothing, a share is nothing too.
    let differs = (moving.sum - still.sum).abs() > 0.05 * still.sum && still.mean > 1e-6;
    (differs || path.envelope.without > 0).then(|| {
        format!(
            "total absolute deviation: swept envelope {:.4} mm, static {:.4} mm, at most {:.4} mm apart at one \
             sample; {} samples have no grazing point",
            moving.sum, still.sum, path.envelope.greatest_difference, path.envelope.without
        )
    })
}
