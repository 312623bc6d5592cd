//! Where what fails a check is, where the cutter stands then, and what could be done that was not done yet.

use glam::DVec3;

use super::result::{CheckKind, FlankCheck, FlankResult};
use super::settings::PathChoice;
use flank::deviation::{Deviation, Feet};
use flank::envelope::EnvelopeCheck;
use flank::params::Objective;

/// How far below the flutes the surface may go (mm): the bottom's own rounding.
pub(super) const BELOW_MM: f64 = 1e-3;

/// Completes the checks that fail: with the place, the cutter's place along the path, and advice.
pub(super) fn complete(result: &FlankResult, checks: &mut [FlankCheck]) {
    for check in checks.iter_mut().filter(|check| !check.holds) {
        if let Some(advice) = advice(result, check) {
            check.text += &format!("; {advice}");
        }
        check.place = check.place.or_else(|| worst(result, check.kind));
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

/// The worst place for the check, of the plan's grid or of that of the checks (mm): that which gave the figure. None
/// where no place is worse than others.
fn worst(result: &FlankResult, kind: CheckKind) -> Option<DVec3> {
    let found = grids(result).map(|grid| {
        let badness = |k: usize| badness(result, &grid, k, kind).unwrap_or(0.0);
        let k = (0..grid.moving.deviation.values.len()).max_by(|a, b| badness(*a).total_cmp(&badness(*b)))?;
        (badness(k) > 0.0).then(|| (badness(k), grid.place(result, k)))
    });
    // Of two that are as bad the first: the plan's.
    let [planned, checked] = found;
    let worse = match (planned, checked) {
        (Some(a), Some(b)) => Some(if b.0 > a.0 { b } else { a }),
        (a, b) => a.or(b),
    };
    worse.map(|(_, place)| place)
}

/// Results of the path over one of the grids.
struct Looked<'a> {
    standing: &'a Deviation,
    moving: &'a EnvelopeCheck,
    feet: &'a Feet,
    is_planned: bool,
}

fn grids(result: &FlankResult) -> [Looked<'_>; 2] {
    let (path, checked) = (result.path(), &result.checked);
    [
        Looked { standing: &path.deviation, moving: &path.envelope, feet: &path.feet, is_planned: true },
        Looked { standing: &checked.deviation, moving: &checked.envelope, feet: &checked.feet, is_planned: false },
    ]
}

impl Looked<'_> {
    /// Place `k` of the grid (mm).
    fn place(&self, result: &FlankResult, k: usize) -> DVec3 {
        let [u, v] = if self.is_planned {
            let [along, up] = self.standing.grid;
            let share = |i: usize, n: usize| (i as f64 / (n.max(2) - 1) as f64).min(1.0);
            [share(k / up.max(1), along), share(k % up.max(1), up)]
        } else {
            result.checked.place(k)
        };
        result.surface.point(u, v)
    }
}

/// How bad place `k` of a grid is for the check, each thing against its own tolerance; above 0 where it is bad at all.
fn badness(result: &FlankResult, grid: &Looked, k: usize, kind: CheckKind) -> Option<f64> {
    let both = [grid.standing.values.get(k)?, grid.moving.deviation.values.get(k)?];
    let beyond = |[over, under]: [f64; 2]| both.iter().map(|e| (-**e - over).max(**e - under)).fold(f64::MIN, f64::max);
    match kind {
        CheckKind::Deviation => {
            // What the surface is off the face and what straight moves leave is added to every place alike.
            let added_mm = result.chordal_deviation_mm + result.fit.as_ref().map_or(0.0, |fit| fit.error.greatest_mm);
            Some(added_mm + beyond([result.overcut_tolerance_mm, result.undercut_tolerance_mm]))
        }
        CheckKind::Envelope => Some((both[0] - both[1]).abs()),
        CheckKind::Bounds => {
            let Objective::Bounded { overcut_mm, undercut_mm } = result.plan.params.objective else { return None };
            Some(beyond([overcut_mm, undercut_mm].map(|bound| bound.unwrap_or(f64::INFINITY))))
        }
        CheckKind::Coverage => {
            let path = result.path();
            let foot = grid.feet.at.get(k)?;
            let touching = result.plan.cutter.above(path.below_mm).ok()?;
            let height = path.below_mm + touching.contact_height(foot.y * path.axis.at(foot.x).length());
            // Once around there are no ends.
            let past_ends = if path.axis.is_closed() { 0.0 } else { (-foot.x).max(foot.x - 1.0) };
            let past_ends = past_ends * path.axis.at(0.5).length();
            Some((-height).max(height - result.plan.cutter.length_mm).max(past_ends))
        }
        _ => None,
    }
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

/// Where the straight moves leave the path by much, they could follow it more closely.
fn finer_moves(result: &FlankResult) -> Option<&'static str> {
    /// Deviation that counts as large (mm).
    const MUCH_MM: f64 = 0.01;
    (result.chordal_deviation_mm > MUCH_MM).then_some("reduce the linearisation tolerance")
}

/// Remedies for a surface that the path does not cover. Another path is named only if it covers the surface; flutes
/// that are too short belong to the check of the cutter.
fn to_cover(result: &FlankResult) -> Vec<&'static str> {
    let (plan, path) = (&result.plan, result.path());
    let is_short = !(path.coverage.is_whole && result.checked.coverage.is_whole);
    let ends = (is_short && !plan.params.is_covering).then_some("extend the path past the guides' ends (is_covering)");
    let other = match result.path {
        PathChoice::Refined => plan.chosen.coverage.is_whole.then_some("mill the chosen path (--path chosen)"),
        _ => plan.refined.coverage.is_whole.then_some("mill the refined path (--path refined)"),
    };
    let points = is_short.then_some("take more control points (Points, --points)");
    let lowest = path.coverage.height_range_mm[0].min(result.checked.coverage.height_range_mm[0]);
    let below = (lowest < -BELOW_MM).then_some("increase Extend below (--below)");
    ends.into_iter().chain(other.filter(|_| is_short)).chain(points).chain(below).collect()
}

/// Remedy for a wall that is touched no higher than the cutter's bottom reaches below the lower guide: as under the
/// tips of an electrode, where its base goes on.
fn higher(result: &FlankResult, check: &FlankCheck) -> Option<&'static str> {
    /// Height of the flutes that counts as their bottom (mm).
    const BOTTOM_MM: f64 = 0.01;
    let (path, place) = (result.path(), check.place?);
    let is_low = |t: f64| {
        let pose = path.pose(t);
        (place - pose.tip).dot(pose.axis) <= path.below_mm + BOTTOM_MM
    };
    let is_at_bottom = check.t.map_or_else(|| is_low(0.0) || is_low(1.0), is_low);
    (path.below_mm > 0.0 && is_at_bottom)
        .then_some("reduce Extend below (--below 0) where the part goes on below the lower guide")
}

/// Remedy for a check that fails, as far as it was not applied.
fn advice(result: &FlankResult, check: &FlankCheck) -> Option<String> {
    let is_bounded = matches!(result.plan.params.objective, Objective::Bounded { .. });
    let refined = (result.path != PathChoice::Refined).then_some("mill the refined path");
    let ways: Vec<&str> = match check.kind {
        CheckKind::Deviation => {
            let bounded = (!is_bounded).then_some("bound it (--objective bounded)");
            let points = is_bounded.then_some("take more control points");
            let finer = finer_moves(result);
            let others = ["take a thinner cutter", "allow more"];
            finer.into_iter().chain(refined).chain(bounded).chain(points).chain(others).collect()
        }
        CheckKind::Bounds => {
            let others = ["widen the bounds", "take more control points", "take a thinner cutter"];
            refined.into_iter().chain(others).collect()
        }
        CheckKind::Gouge | CheckKind::Leads => finer_moves(result).into_iter().chain(higher(result, check)).collect(),
        CheckKind::Holder => finer_moves(result).into_iter().collect(),
        CheckKind::Coverage => to_cover(result),
        _ => return None,
    };
    Some(match &ways[..] {
        [] => return None,
        [one] => (*one).to_owned(),
        [first @ .., last] => format!("{}, or {last}", first.join(", ")),
    })
}
