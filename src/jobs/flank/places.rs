//! Where what fails a check is, where the cutter stands then, and what could be done that was not done yet.

use glam::DVec3;

use super::checks::{CheckKind, FlankCheck};
use super::{FlankResult, PathChoice};
use crate::flank::params::Objective;

/// Completes the checks that fail: with the place, the cutter's place along the path, and advice.
pub(super) fn complete(result: &FlankResult, checks: &mut [FlankCheck]) {
    for check in checks.iter_mut().filter(|check| !check.holds) {
        if let Some(advice) = advice(result, check.kind) {
            check.text += &format!("; {advice}");
        }
        check.place = check.place.or_else(|| worst(result, check.kind).map(|k| place(result, k)));
        if is_of_surface(check.kind) {
            check.t = check.t.or_else(|| check.place.map(|place| nearest(result, place)));
        }
    }
}

/// Whether what the check finds is on the surface, so that the cutter that stands over it is to blame.
fn is_of_surface(kind: CheckKind) -> bool {
    matches!(
        kind,
        CheckKind::Cutter | CheckKind::Coverage | CheckKind::Deviation | CheckKind::Bounds | CheckKind::Envelope
    )
}

/// The place of the plan's grid that is worst for the check; none where none is worse than others.
fn worst(result: &FlankResult, kind: CheckKind) -> Option<usize> {
    let path = result.path();
    let both = [&path.deviation.values, &path.envelope.deviation.values];
    let worse = |of: &dyn Fn(usize) -> f64| {
        let found = (0..both[0].len().min(both[1].len())).max_by(|a, b| of(*a).total_cmp(&of(*b)))?;
        (of(found) > 0.0).then_some(found)
    };
    match kind {
        CheckKind::Deviation => worse(&|k| both.iter().fold(0.0, |most: f64, values| most.max(values[k].abs()))),
        CheckKind::Envelope => worse(&|k| (both[0][k] - both[1][k]).abs()),
        CheckKind::Bounds => {
            let Objective::Bounded { overcut_mm, undercut_mm } = result.plan.params.objective else { return None };
            let [over, under] = [overcut_mm, undercut_mm].map(|bound| bound.unwrap_or(f64::INFINITY));
            let beyond = |value: f64| (-value - over).max(value - under);
            worse(&|k| both.iter().fold(0.0, |most: f64, values| most.max(beyond(values[k]))))
        }
        CheckKind::Coverage => {
            let touching = result.plan.cutter.above(path.below_mm).ok()?;
            let flutes = result.plan.cutter.length_mm;
            worse(&|k| {
                let Some(foot) = path.feet.at.get(k) else { return 0.0 };
                let height = path.below_mm + touching.contact_height(foot.y * path.axis.at(foot.x).length());
                let past_ends = (-foot.x).max(foot.x - 1.0) * path.axis.at(0.5).length();
                (-height).max(height - flutes).max(past_ends)
            })
        }
        _ => None,
    }
}

/// Place `k` of the plan's grid (mm).
fn place(result: &FlankResult, k: usize) -> DVec3 {
    let [along, up] = result.path().deviation.grid;
    let share = |i: usize, n: usize| (i as f64 / (n.max(2) - 1) as f64).min(1.0);
    result.surface.point(share(k / up.max(1), along), share(k % up.max(1), up))
}

/// Where along the path the axis is nearest to a place.
fn nearest(result: &FlankResult, place: DVec3) -> f64 {
    let off = |tip: DVec3, axis: DVec3| {
        let from_tip = place - tip;
        (from_tip - axis * from_tip.dot(axis).clamp(0.0, result.plan.cutter.length_mm)).length()
    };
    let poses = result.path().poses.iter();
    let found = poses.min_by(|a, b| off(a.tip, a.axis).total_cmp(&off(b.tip, b.axis)));
    found.map_or(0.0, |pose| pose.t)
}

/// What could be done about a check that fails, as far as it was not done.
fn advice(result: &FlankResult, kind: CheckKind) -> Option<String> {
    let is_bounded = matches!(result.plan.params.objective, Objective::Bounded { .. });
    let refined = (result.path != PathChoice::Refined).then_some("mill the refined path");
    let ways: Vec<&str> = match kind {
        CheckKind::Deviation => {
            let bounded = (!is_bounded).then_some("bound it (objective bounded)");
            let points = is_bounded.then_some("take more control points");
            refined.into_iter().chain(bounded).chain(points).chain(["take a thinner cutter", "allow more"]).collect()
        }
        CheckKind::Bounds => {
            let others = ["widen the bounds", "take more control points", "take a thinner cutter"];
            refined.into_iter().chain(others).collect()
        }
        CheckKind::Leads => {
            vec!["take another aside or retract (--aside, --retract)", "move the walls away"]
        }
        _ => return None,
    };
    Some(match &ways[..] {
        [] => return None,
        [one] => (*one).to_owned(),
        [first @ .., last] => format!("{}, or {last}", first.join(", ")),
    })
}
