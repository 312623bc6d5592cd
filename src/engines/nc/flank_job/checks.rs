//! Checks of a flank path before it is exported, and notes for its reader.

use super::clearances::{gouge, leads, own_surface};
use super::input::{FlankInput, LoadedSurface};
use super::places;
use super::places::BELOW_MM;
use super::result::{CheckKind, FlankCheck, FlankResult};
use super::settings::PathChoice;
use flank::FlankError;
use flank::deviation::Deviation;
use flank::guide::pairing_warning;
use flank::guide_joining::Joining;
use flank::inside_wall::open_edges_about;
use flank::params::Objective;
use flank::refine::beyond_bounds;

/// Tolerance of kept bounds (mm).
const KEPT_MM: f64 = 1e-4;

/// The checks of the path that is milled.
pub(super) fn of(result: &FlankResult) -> Vec<FlankCheck> {
    let mut checks = Vec::new();
    checks.extend(ruled(result));
    checks.extend(guides(&result.joinings));
    checks.push(cutter(result));
    checks.push(coverage(result));
    checks.push(deviation(result));
    checks.extend(bounds(result));
    checks.push(envelope(result));
    checks.push(own_surface(result));
    checks.extend(gouge(result));
    checks.push(leads(result));
    checks.extend(machine(result));
    places::complete(result, &mut checks);
    checks
}

fn ruled(result: &FlankResult) -> Option<FlankCheck> {
    let fit = result.fit.as_ref()?;
    // What is not covered says so itself, after the form.
    let text = match fit.words.first() {
        Some(form) if fit.covers => form.clone(),
        Some(form) => format!("{form}; the surface does not cover all of the face"),
        None => String::new(),
    };
    let at = if fit.is_ruled && !fit.covers { fit.uncovered_at } else { fit.worst };
    let off = if fit.is_ruled { 0.0 } else { fit.error.greatest_mm };
    let uncovered = if fit.covers { 0.0 } else { fit.uncovered_mm.max(fit.lost_mm) };
    let check = FlankCheck::new(CheckKind::Ruled, fit.is_ruled && fit.covers, text).at(at);
    Some(check.with(&[("off_mm", off), ("uncovered_mm", uncovered)]))
}

/// Whether rows of points are joined as they were meant.
fn guides(joinings: &[Joining]) -> Option<FlankCheck> {
    let worst = joinings.iter().copied().reduce(|a, b| {
        let is_worse = (b.is_doubtful, b.departure_mm) > (a.is_doubtful, a.departure_mm);
        if is_worse { b } else { a }
    })?;
    let told: Vec<String> =
        joinings.iter().filter(|j| j.is_doubtful == worst.is_doubtful).map(Joining::words).collect();
    let text = if worst.is_doubtful {
        told.join("; ")
    } else {
        let told = told.join("; ");
        format!("smooth curves through the guides' points leave the straight lines between them by up to {told}")
    };
    let check = FlankCheck::new(CheckKind::Guides, !worst.is_doubtful, text).at(worst.at);
    Some(check.with(&[("off_mm", worst.departure_mm)]))
}

fn cutter(result: &FlankResult) -> FlankCheck {
    let (plan, surface) = (&result.plan, &result.surface);
    match plan.cutter.fits(surface, plan.params.below_mm) {
        Ok(()) => {
            let text =
                format!("flutes of {:.3} mm reach the upper guide, and no hollow is too narrow", plan.cutter.length_mm);
            FlankCheck::new(CheckKind::Cutter, true, text)
        }
        Err(error) => {
            let (place, figure) = match error {
                FlankError::CutterTooShort { u, length_mm, needed_mm } => {
                    (Some(surface.point(u, 1.0)), Some(("too_short_mm", needed_mm - length_mm)))
                }
                FlankError::CutterTooThick { u, v, radius_mm, hollow_mm } => {
                    (Some(surface.point(u, v)), Some(("too_thick_mm", radius_mm - hollow_mm)))
                }
                _ => (None, None),
            };
            let mut text = error.to_string();
            if matches!(error, FlankError::CutterTooThick { .. }) && !result.joinings.is_empty() {
                text += "; if the guides are measured points, their noise may be all of that hollow, as the curve goes \
                         through every one of them: smooth them, or take points that stand further apart";
            }
            FlankCheck { place, ..FlankCheck::new(CheckKind::Cutter, false, text) }.with(figure.as_slice())
        }
    }
}

fn coverage(result: &FlankResult) -> FlankCheck {
    let [planned, checked] = [&result.path().coverage, &result.checked.coverage];
    let widest = |a: [f64; 2], b: [f64; 2]| [a[0].min(b[0]), a[1].max(b[1])];
    let [first, last] = widest(planned.t_range, checked.t_range);
    let [lowest, highest] = widest(planned.height_range_mm, checked.height_range_mm);
    let is_whole = planned.is_whole && checked.is_whole;
    let flutes = result.plan.cutter.length_mm;
    let mut missing = Vec::new();
    if !is_whole {
        missing.push(format!("the path runs from t = 0 to 1 and {first:.4} to {last:.4} are needed"));
    }
    if lowest < -BELOW_MM {
        missing.push(format!("the flutes end {:.4} mm above the lowest line that they should cut", -lowest));
    }
    if highest > flutes {
        missing.push(format!("the surface reaches {:.3} mm above the flutes' top", highest - flutes));
    }
    let text = if missing.is_empty() {
        format!(
            "the whole surface is covered: t from {first:.4} to {last:.4} of 0 to 1, heights from {lowest:.3} to \
             {highest:.3} mm of 0 to {flutes:.3} mm"
        )
    } else {
        missing.join("; ")
    };
    let short = if is_whole { 0.0 } else { (-first).max(last - 1.0) };
    let figures = [("missing_t", short), ("above_lowest_mm", -lowest), ("above_flutes_mm", highest - flutes)];
    FlankCheck::new(CheckKind::Coverage, missing.is_empty(), text).with(&figures)
}

/// Deviations of the path that is milled: standing and moving, over the grid that it was planned on and over the one
/// for checks.
fn deviations(result: &FlankResult) -> [&Deviation; 4] {
    let (path, checked) = (result.path(), &result.checked);
    [&path.deviation, &path.envelope.deviation, &checked.deviation, &checked.envelope.deviation]
}

/// Greatest overcut and undercut of the path that is milled (mm).
fn greatest(result: &FlankResult) -> [f64; 2] {
    let all = deviations(result);
    let overcut = all.iter().fold(0.0, |most: f64, d| most.max(-d.most_overcut));
    [overcut, all.iter().fold(0.0, |most: f64, d| most.max(d.most_undercut))]
}

/// The worse of the standing and the moving cutter, to which the fit of a face adds its own error, and the straight
/// moves that are written how far they leave the path.
fn deviation(result: &FlankResult) -> FlankCheck {
    let off_mm = result.fit.as_ref().map_or(0.0, |fit| fit.error.greatest_mm);
    let chordal_deviation_mm = result.chordal_deviation_mm;
    let [overcut, undercut] = greatest(result).map(|most| most + off_mm + chordal_deviation_mm);
    let allowed = [result.overcut_tolerance_mm, result.undercut_tolerance_mm];
    let holds = overcut <= allowed[0] && undercut <= allowed[1];
    let mut text = format!(
        "overcut up to {overcut:.4} mm, undercut up to {undercut:.4} mm, static or swept envelope, on {}; allowed: \
         {} and {} mm",
        result.checked.words, allowed[0], allowed[1]
    );
    if result.fit.is_some() {
        text += &format!("; both include {off_mm:.4} mm error of the fit");
    }
    text += &format!("; both include {chordal_deviation_mm:.4} mm chordal deviation");
    let figures = [("overcut_mm", overcut), ("undercut_mm", undercut)];
    FlankCheck::new(CheckKind::Deviation, holds, text).with(&figures)
}

fn bounds(result: &FlankResult) -> Option<FlankCheck> {
    let objective = result.plan.params.objective;
    let Objective::Bounded { .. } = objective else { return None };
    let beyond = deviations(result).into_iter().map(|d| beyond_bounds(objective, d)).fold(0.0, f64::max);
    let [overcut, undercut] = greatest(result);
    let text = format!(
        "overcut up to {overcut:.4} mm, undercut up to {undercut:.4} mm, static or swept envelope: {}",
        if beyond > KEPT_MM { format!("{beyond:.4} mm beyond the bounds") } else { "within the bounds".to_owned() }
    );
    Some(FlankCheck::new(CheckKind::Bounds, beyond <= KEPT_MM, text).with(&[("beyond_mm", beyond)]))
}

fn envelope(result: &FlankResult) -> FlankCheck {
    let both = [&result.path().envelope, &result.checked.envelope];
    let greatest = both.iter().fold(0.0, |most: f64, e| most.max(e.greatest_difference));
    let without = both.iter().fold(0, |most, e| most.max(e.without));
    let tolerance = result.envelope_tolerance_mm;
    let holds = greatest <= tolerance && without == 0;
    let mut text = format!(
        "swept envelope and static deviation differ by {greatest:.5} mm at most on {}; allowed: {tolerance} mm",
        result.checked.words
    );
    if without > 0 {
        // What fails comes first.
        let untouched = format!("at {without} samples the swept envelope does not touch the surface");
        text = if greatest > tolerance { format!("{text}; {untouched}") } else { format!("{untouched}; {text}") };
    }
    let figures = [("difference_mm", greatest), ("untouched_places", without as f64)];
    FlankCheck::new(CheckKind::Envelope, holds, text).with(&figures)
}

fn machine(result: &FlankResult) -> Option<FlankCheck> {
    let check = match result.milled.as_ref()? {
        Ok(milled) => FlankCheck::new(
            CheckKind::Machine,
            true,
            format!(
                "{} positions of {} within its limits; between them tip and flutes' top leave the path by {:.5} mm at \
                 most, allowed: {} mm",
                milled.line.points.len(),
                milled.machine.machine().name,
                milled.line.deviation_mm,
                milled.params.linearisation_mm
            ),
        ),
        Err(why) => FlankCheck::new(CheckKind::Machine, false, why.clone()),
    };
    Some(check)
}

/// The plan's warnings, and what was not checked.
pub(super) fn warnings(result: &FlankResult, input: &FlankInput) -> Vec<String> {
    let mut warnings: Vec<String> = result.plan.warnings_of(result.path.name()).map(str::to_owned).collect();
    warnings.extend(sinks(result));
    warnings.extend(open_walls(result, input));
    if let LoadedSurface::Guides { lower, upper } = &input.surface {
        warnings.extend(pairing_warning(lower, upper));
    }
    let is_own_wall = matches!(input.surface, LoadedSurface::Face { is_own_wall: true, .. });
    if input.walls.is_none() && !is_own_wall {
        warnings
            .push("no neighbouring walls were given: nothing was checked for gouges by flutes or holder".to_owned());
    } else if result.plan.cutter.holder.is_empty() {
        warnings.push("the cutter has no holder: what is above the flutes was not checked".to_owned());
    }
    warnings
}

/// Of walls that are not closed, and about the tool, no one can tell for sure what is inside of them.
fn open_walls(result: &FlankResult, input: &FlankInput) -> Option<String> {
    let wall = input.walls.as_ref()?;
    let edges = open_edges_about(&result.path().pose(0.0), &result.plan.cutter, wall)?;
    Some(format!(
        "the walls are open at {edges} edges, so that inside and outside are estimated there; close the walls"
    ))
}

/// A refined path may sink a cone along its axis to have a fitting radius: what is below the lower guide is then in its
/// way.
fn sinks(result: &FlankResult) -> Option<String> {
    /// Depth that counts as sunk (mm).
    const SUNK_MM: f64 = 0.5;
    let (path, asked) = (result.path(), result.plan.params.below_mm);
    let touching = result.plan.cutter.above(asked).ok()?;
    let on_lower_guide = path.feet.at.iter().step_by(path.deviation.grid[1].max(1));
    let heights = on_lower_guide.map(|q| asked + touching.contact_height(q.y * path.axis.at(q.x).length()));
    let deepest = heights.fold(asked, f64::max);
    let instead = match result.path {
        PathChoice::Refined => ", or mill the chosen path",
        PathChoice::Chosen => ", or mill the initial path",
        PathChoice::Initial => "",
    };
    (deepest > asked + SUNK_MM).then(|| {
        format!(
            "the {} path moves the cutter's bottom up to {deepest:.2} mm below the lower guide, {asked} mm were \
             requested: check that nothing is there{instead}",
            result.path.name()
        )
    })
}
