//! The report on a planned flank.

use crate::workspaces::flank::document::fields::FIELDS;
use crate::workspaces::flank::document::{
    DemonstrationSurface, FlankDocument, FlankSource, GuideSource, MeshFlank, PathChoice,
};
use crate::workspaces::flank::report::{
    AxisEntry, AxisSlowedEntry, CheckEntry, ClearanceEntry, Figures, FitEntry, FlankReport, LocationsEntry,
    MachineEntry, PaperEntry, PathEntry, RanksEntry, SCHEMA, ShortEntry, SlowedEntry, SurfaceEntry,
};
use files::{Override, ParameterList};
use flank::fit_ruled::RuledFit;
use flank::gouge::{Clearance, ToolPart};
use flank::machine::joint_feed::Slowed;
use flank::offset::Touch;
use flank::ruled_surface::{RuledSurface, Side};
use geometry::nurbs::NurbsCurve;
use nc::flank_job::{FlankResult, Milled, path_of};

/// Number of samples for lengths.
const LOOKS: usize = 512;
/// Greatest difference of a radius from the paper's 1 mm for a comparison (mm).
const NEAR_MM: f64 = 0.02;
/// The most points of the curve of an axis.
const MOST_POINTS: usize = 4000;

/// The report on `result`, which was made from `document`, without plans beside it.
pub fn report(result: &FlankResult, document: &FlankDocument) -> FlankReport {
    let plan = &result.plan;
    let nearest = plan.locations.iter().filter(|l| l.touch == Touch::NearestToThree).count();
    let u0_range = plan.initial.axis.u0_range;
    FlankReport {
        schema: SCHEMA,
        program_version: env!("CARGO_PKG_VERSION"),
        name: result.name.clone(),
        sentence: sentence(result),
        holds: result.holds(),
        blocked: result.why_blocked(),
        surface: surface(&result.surface, result.fit.as_ref(), document),
        cutter: plan.cutter.clone(),
        grid: plan.initial.deviation.counted_grid(),
        locations: LocationsEntry {
            count: plan.locations.len(),
            touching: plan.locations.len() - nearest,
            nearest,
            u0_range,
            control_points: plan.initial.axis.lower().len(),
            control_points_asked: plan.params.control_points,
            fit_mm: plan.fit_mm,
        },
        moving_most_mm: result.moving_most(),
        paths: PathChoice::ALL.into_iter().map(|choice| path(result, choice)).collect(),
        paper: paper(document),
        ranks: RanksEntry {
            singular_values: plan.ranks.singular_values.clone(),
            sums_mm: plan.ranks.sums.clone(),
            best: plan.ranks.best,
        },
        checks: checks(result, &document.overrides),
        clearances: clearances(result),
        compared: Vec::new(),
        machine: result.milled.as_ref().map(|milled| machine(milled, document)),
        warnings: result.all_warnings(),
        parameters: parameters(document),
    }
}

/// Every parameter. Of a mesh in the document only the size is listed.
fn parameters(document: &FlankDocument) -> ParameterList {
    let mut document = document.clone();
    if let FlankSource::Mesh(MeshFlank { kept: Some(kept), .. }) = &mut document.source {
        kept.obj = format!("{} bytes", kept.obj.len()).into();
    }
    FIELDS.list(&document)
}

/// The answer in a sentence.
pub fn sentence(result: &FlankResult) -> String {
    let [nu, nv] = result.path().deviation.counted_grid();
    let mut text = if result.plan.has_deviation() {
        leaves(result)
    } else {
        format!("The deviation is zero within rounding at all {nu} x {nv} samples.")
    };
    let named = |is_overridden: bool| {
        let failed = result.checks.iter().filter(|c| !c.holds && c.is_overridden == is_overridden);
        failed.map(|c| c.kind.name()).collect::<Vec<_>>().join(", ")
    };
    let (blocking, overridden) = (named(false), named(true));
    if !blocking.is_empty() {
        text += &format!(" Blocked by failed checks: {blocking}.");
    }
    if !overridden.is_empty() {
        text += &format!(" Released despite failed checks: {overridden}.");
    }
    if result.holds() {
        text += " Every check holds.";
    }
    text
}

fn leaves(result: &FlankResult) -> String {
    let path = result.path();
    let [nu, nv] = path.deviation.counted_grid();
    let [overcut, undercut] = result.moving_most();
    format!(
        "The {} path has a total absolute deviation of {:.3} mm over {nu} x {nv} samples, ratio {:.3} to the \
         initial {:.3} mm; swept envelope: overcut up to {:.1} \u{b5}m, undercut up to {:.1} \u{b5}m.",
        result.path.name(),
        path.deviation.sum,
        result.plan.ratio(path),
        result.plan.initial.deviation.sum,
        1e3 * overcut,
        1e3 * undercut,
    )
}

fn path(result: &FlankResult, choice: PathChoice) -> PathEntry {
    let path = path_of(&result.plan, choice);
    let points = |points: &[glam::DVec3]| points.iter().map(|p| p.to_array()).collect();
    PathEntry {
        name: choice.name(),
        is_milled: choice == result.path,
        ratio: result.plan.share(path.deviation.sum),
        moving_ratio: result.plan.moving_share(path),
        standing: Figures::of(&path.deviation),
        moving: Figures::of(&path.envelope.deviation),
        greatest_difference_mm: path.envelope.greatest_difference,
        without: path.envelope.without,
        covers: path.coverage.is_whole,
        t_range: path.coverage.t_range,
        height_range_mm: path.coverage.height_range_mm,
        below_mm: result.plan.params.below_mm,
        is_closed: path.axis.is_closed(),
        control_lower: points(path.axis.lower()),
        control_upper: points(path.axis.upper()),
    }
}

fn paper(document: &FlankDocument) -> PaperEntry {
    let cutter = &document.cutter;
    // Where it touches the lower guide, which its bottom may reach below.
    let radius = cutter.radius_at(document.plan.below_mm);
    let is_its_cone = (radius - 1.0).abs() <= NEAR_MM && cutter.taper_deg == 5.0;
    let comparable = match &document.source {
        FlankSource::Demonstration { surface } if is_its_cone => Some(surface.paper_ratio()),
        _ => None,
    };
    let [ratio_a, ratio_b] = [DemonstrationSurface::A, DemonstrationSurface::B].map(DemonstrationSurface::paper_ratio);
    PaperEntry { ratio_a, ratio_b, comparable }
}

fn surface(surface: &RuledSurface, fit: Option<&RuledFit>, document: &FlankDocument) -> SurfaceEntry {
    let share = |i: usize| i as f64 / LOOKS as f64;
    let length =
        |curve: &NurbsCurve| (0..LOOKS).map(|i| curve.point(share(i)).distance(curve.point(share(i + 1)))).sum::<f64>();
    let rulings = (0..=LOOKS).map(|i| surface.point(share(i), 0.0).distance(surface.point(share(i), 1.0)));
    let ruling_mm = rulings.fold([f64::INFINITY, 0.0], |[low, high]: [f64; 2], r| [low.min(r), high.max(r)]);
    SurfaceEntry {
        source: source(&document.source),
        side: if surface.side() == Side::Negative { -1 } else { 1 },
        is_reversed: surface.is_reversed(),
        ruling_mm,
        guide_mm: [length(surface.lower()), length(surface.upper())],
        fit: fit.map(|fit| FitEntry {
            is_ruled: fit.is_ruled,
            tolerance_mm: fit.tolerance_mm,
            error: fit.error,
            error_corners: fit.error_corners,
            worst: fit.worst.to_array(),
            chord_mm: fit.chord_mm,
            words: fit.words.clone(),
        }),
    }
}

fn source(source: &FlankSource) -> String {
    let guide = |guide: &GuideSource| match guide {
        GuideSource::File(file) => file.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned()),
        GuideSource::Curve(_) => "a curve given by its points".to_owned(),
    };
    match source {
        FlankSource::Demonstration { surface } => format!("{} of the paper (P4)", surface.name()),
        FlankSource::Guides { lower, upper } => format!("guides: {} and {}", guide(lower), guide(upper)),
        FlankSource::Mesh(mesh) => format!("{}, flank {}", mesh.part(), mesh.candidate),
    }
}

fn checks(result: &FlankResult, overrides: &[Override]) -> Vec<CheckEntry> {
    let entry = |check: &nc::flank_job::FlankCheck| CheckEntry {
        name: check.kind.name(),
        holds: check.holds,
        is_overridden: check.is_overridden,
        text: check.text.clone(),
        place: check.place.map(|p| p.to_array()),
        t: check.t,
        figures: check.figures.clone(),
        lapsed: check.lapsed.clone(),
        given_for: overrides
            .iter()
            .filter(|o| !check.holds && o.check == check.kind.name())
            .find_map(|o| o.given_for()),
    };
    result.checks.iter().map(entry).collect()
}

fn clearances(result: &FlankResult) -> Vec<ClearanceEntry> {
    let Some(gouge) = &result.gouge else { return Vec::new() };
    let entry = |Clearance { part, distance_mm, point, t }: Clearance| ClearanceEntry {
        part: match part {
            ToolPart::Cutter => "flutes".to_owned(),
            ToolPart::Holder(i) => format!("holder, part {}", i + 1),
        },
        distance_mm,
        place: point.to_array(),
        t,
    };
    [gouge.cutter, gouge.holder].into_iter().flatten().map(entry).collect()
}

fn machine(milled: &Result<Milled, String>, document: &FlankDocument) -> MachineEntry {
    let mut entry = MachineEntry {
        name: document.milling.machine.clone(),
        trouble: None,
        positions: 0,
        linearisation_mm: document.milling.linearisation_mm,
        deviation_mm: 0.0,
        minutes: 0.0,
        slowed: None,
        singular: Vec::new(),
        axes: Vec::new(),
    };
    match milled {
        Err(trouble) => entry.trouble = Some(trouble.clone()),
        Ok(milled) => {
            let machine = milled.machine.machine();
            entry.name = format!("{}: {}", machine.name, machine.title);
            entry.positions = milled.line.points.len();
            entry.deviation_mm = milled.line.deviation_mm;
            (entry.minutes, entry.slowed) = (milled.minutes, milled.slowed.map(slowed));
            entry.singular = milled.line.singular.iter().map(ToString::to_string).collect();
            entry.axes = axes(milled);
        }
    }
    entry
}

fn slowed(slowed: Slowed) -> SlowedEntry {
    let Slowed { moves, share, by_axis, short } = slowed;
    SlowedEntry {
        moves,
        least_share: share,
        for_axes: by_axis.map(|(moves, least_share, axis)| AxisSlowedEntry { moves, least_share, axis }),
        short: short.map(|(moves, least_share)| ShortEntry { moves, least_share }),
    }
}

/// The five axes over time: the spindle nose in machine coordinates, and the rotary axes.
fn axes(milled: &Milled) -> Vec<AxisEntry> {
    let (k, points) = (&milled.machine, &milled.line.points);
    let mut seconds = vec![0.0];
    for minutes in &milled.move_minutes {
        seconds.push(seconds[seconds.len() - 1] + 60.0 * minutes);
    }
    let apart = points.len().div_ceil(MOST_POINTS).max(1);
    let last = points.len().saturating_sub(1);
    let shown: Vec<usize> = (0..points.len()).filter(|i| i % apart == 0 || *i == last).collect();
    let curve = |value: &dyn Fn(usize) -> f64| -> Vec<[f64; 2]> {
        shown.iter().filter_map(|i| seconds.get(*i).map(|s| [*s, value(*i)])).collect()
    };
    let linear = &k.machine().linear;
    let limits = [linear.x_mm, linear.y_mm, linear.z_mm];
    let straight = ['X', 'Y', 'Z'].into_iter().enumerate().map(|(axis, letter)| AxisEntry {
        letter,
        unit: "mm",
        limits: limits[axis],
        values: curve(&|i| k.slides(&points[i].joints)[axis]),
    });
    let rotary = (0..2).map(|axis| AxisEntry {
        letter: k.letter(axis),
        unit: "\u{b0}",
        limits: k.machine().rotary[axis].limits().map(f64::to_degrees),
        values: curve(&|i| points[i].joints.rotary[axis].to_degrees()),
    });
    straight.chain(rotary).collect()
}
