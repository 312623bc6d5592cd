//! The checks of a plan's electrodes.

use std::collections::{BTreeMap, BTreeSet};

use glam::{DMat3, DVec2, DVec3};
use rayon::prelude::*;

use super::base::on_plate;
use super::burn_direction::{BurnProposal, proposed};
use super::burning::Burning;
use super::check::{machinable, watertight};
use super::clearance::{Clearance, Obstacle};
use super::cut::Cut;
use super::cuts::Undivided;
use super::design::{Burn, Electrode, PartId, PartNode, RegionPlan};
use super::division::CELL;
use super::earlier::is_nothing;
use super::finding::{CheckKind, Finding};
use super::overhang::Overhangs;
use super::params::{ElectrodeParams, Stage};
use super::part_numbers::{Numbered, Parts};
use super::residual_stock::{Burns, Looked, left_by};
use super::residual_stock::{LeftOfRegion, Milled, OPPOSED, Sample, residual_stock};
use super::samples::{concave_edges, samples};
use super::setting::{ElectrodeError, KeptClear, RegionToBurn, to_burn_frame};
use super::tip::joined;
use crate::cutter::CutterLibrary;
use crate::height_field::HeightFieldError;
use crate::outline::Outline;
use crate::plane;
use geometry::mesh::{Bounds, Edge, Mesh};
use geometry::solid::{SolidError, difference, prism};
use task::Cancel;

/// How alike directions are that are one (cosine).
const SAME: f64 = 1.0 - 1e-12;
/// How much nearer in plan a tip has to be for a place to be its own alone (mm).
const NEARER: f64 = 1e-6;

/// The mold for one burn direction, as it is checked.
struct Setting {
    direction: DVec3,
    /// Rotation from the upright mold to the burn frame.
    turned: DMat3,
    /// The mold's surface in it.
    surface: Mesh,
    /// The mold in it.
    mold: Obstacle,
    /// The edges in which the spark leaves something.
    edges: Vec<Edge>,
}

impl Setting {
    fn new(mold: &Mesh, direction: DVec3, cancel: &Cancel) -> Result<Self, ElectrodeError> {
        cancel.check()?;
        let turned = to_burn_frame(direction);
        let surface = mold.mapped(|p| turned * p);
        let (edges, mold) = (concave_edges(&surface), Obstacle::new(&surface)?.stopped_by(cancel));
        Ok(Self { direction, turned, surface, mold, edges })
    }
}

/// All that a stage's gap and orbit leave room for around a region; none where that has no solid.
fn fullest(
    mold: &Mesh,
    (stage, margin): (&Stage, f64),
    corners: &[[DVec3; 3]],
    cancel: &Cancel,
) -> Result<Option<Burning>, ElectrodeError> {
    if stage.most_across() <= 0.0 || corners.is_empty() {
        return Ok(None);
    }
    let around = Bounds::of(corners.iter().flatten().copied());
    let beside = margin + 2.0 * stage.most_across();
    let [low, high] = [around.min.truncate() - beside, around.max.truncate() + beside];
    let clear = match KeptClear::over(mold, stage, [low, high], around.min.z, cancel) {
        Ok(clear) => clear,
        Err(SolidError::Cancelled(cancelled)) => return Err(cancelled.into()),
        Err(_) => return Ok(None),
    };
    let sides = [low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)];
    let top = around.max.z + 4.0 * stage.most_across() + 1.0;
    let room = prism(&[&sides], around.min.z, top).and_then(|all| difference(&all, &clear.mesh));
    room.ok().map(|room| Ok(Burning::new(&room, stage)?)).transpose()
}

/// The findings for each electrode; what is left of each region goes into its plan.
pub(super) fn checked(
    (mold, milled): (&Mesh, &Milled),
    electrodes: &[Electrode],
    (plans, regions, parts): (&mut [RegionPlan], &[RegionToBurn], &Parts),
    (cutters, params, stages): (&CutterLibrary, &ElectrodeParams, &[Stage]),
    cancel: &Cancel,
) -> Result<Vec<Vec<Finding>>, ElectrodeError> {
    // What stages before the last burn does not have its finish.
    let last: Vec<&Electrode> = electrodes.iter().filter(|e| e.stage + 1 == stages.len()).collect();
    let mut settings: Vec<Setting> = Vec::new();
    for direction in plans.iter().map(|plan| plan.direction).chain(electrodes.iter().map(|e| e.direction)) {
        if !settings.iter().any(|s| is_same(s, direction)) {
            settings.push(Setting::new(mold, direction, cancel)?);
        }
    }
    let of_direction = |direction: DVec3| settings.iter().find(|s| is_same(s, direction));
    let overhangs = Overhangs::of(mold);
    let left_of = |r: usize| match of_direction(plans[r].direction) {
        Some(setting) => {
            left_of((setting, &overhangs, milled), (r, &plans[r], &regions[r]), &last, (stages, params), cancel)
        }
        None => Ok(Left::default()),
    };
    let left: Vec<Left> = (0..regions.len()).into_par_iter().map(left_of).collect::<Result<_, _>>()?;
    for ((plan, left), region) in plans.iter_mut().zip(&left).zip(regions) {
        (plan.left, plan.proposal) = (left.all, left.proposal);
        // Of what needs no tip it is told that it stays.
        let needs_none = plan.is_set_aside || (plan.tree.is_none() && is_nothing(region, params));
        let nobodys = || (!needs_none).then(|| nobodys(left, (params.tolerance_mm, milled.accuracy()))).flatten();
        if plan.reason.is_none() {
            (plan.reason, plan.reason_place) = nobodys().unzip();
        }
    }
    let check = |electrode: &Electrode| -> Result<Vec<Finding>, ElectrodeError> {
        cancel.check()?;
        let closed = watertight(&electrode.mesh);
        let is_closed = closed.holds;
        let mut findings = vec![closed];
        if let Some(setting) = of_direction(electrode.direction) {
            findings.extend(clearances(electrode, setting, &stages[electrode.stage], params)?);
        }
        findings.extend(residual_stock_of(electrode, &left, stages, (params.tolerance_mm, milled.accuracy())));
        if is_closed {
            findings.push(milling(electrode, undivided(electrode, parts), (cutters, params), cancel)?);
        }
        Ok(findings)
    };
    electrodes.par_iter().map(check).collect()
}

fn is_same(setting: &Setting, direction: DVec3) -> bool {
    setting.direction.dot(direction) > SAME
}

/// How near the worst of its burns comes to the mold, there and on its way.
fn clearances(
    electrode: &Electrode,
    setting: &Setting,
    stage: &Stage,
    params: &ElectrodeParams,
) -> Result<Vec<Finding>, ElectrodeError> {
    let turned = &setting.turned;
    let clearance = |burn: &Burn| {
        let mesh = electrode.burning(&electrode.mesh, burn, turned);
        setting.mold.clearance(&mesh, stage, burn.retract(params.lift_mm))
    };
    let all: Vec<Clearance> = electrode.burns.iter().map(clearance).collect::<Result<_, _>>()?;
    let Some(worst) = all.into_iter().reduce(Clearance::worse) else { return Ok(Vec::new()) };
    let [gouge, approach] = worst.findings(stage);
    let approach = within_limit(approach, electrode, params);
    let upright = |f: Finding| Finding { place: f.place.map(|p| turned.transpose() * p), ..f };
    Ok(vec![upright(gouge), upright(approach)])
}

/// The finding on the way in and out, which also fails where a burn needs a greater retract distance than the limit.
fn within_limit(approach: Finding, electrode: &Electrode, params: &ElectrodeParams) -> Finding {
    let needed = electrode.burns.iter().map(|burn| burn.retract(params.lift_mm)).fold(0.0, f64::max);
    let Some(limit) = params.lift_limit_mm.filter(|limit| needed > *limit) else { return approach };
    let text = format!(
        "{}; the retract distance that brings it clear of the mold is {needed:.3} mm, the retract limit {limit:.3} mm: \
         burn the region from another direction, or raise the retract limit",
        approach.text
    );
    Finding { holds: false, text, ..approach }.with(&[("retract_mm", needed - limit)])
}

/// Residual stock of the parts that an electrode is for, each once.
fn residual_stock_of(electrode: &Electrode, left: &[Left], stages: &[Stage], tolerance: (f64, f64)) -> Option<Finding> {
    let own: BTreeSet<PartId> = electrode.burns.iter().flat_map(|b| &b.parts).copied().collect();
    let looked = own.iter().map(|p| left[p.region].looked).reduce(Looked::and)?;
    if electrode.stage + 1 < stages.len() {
        return Some(for_later());
    }
    let of_part = |p: &PartId| left[p.region].of_parts.get(&p.part).copied();
    let all = own.iter().filter_map(of_part).fold(LeftOfRegion::default(), LeftOfRegion::and);
    Some(residual_stock(&all, tolerance, &stages[electrode.stage], looked))
}

/// What became of the cuts that were tried on the heads of an electrode of which cutters leave something.
fn undivided(electrode: &Electrode, parts: &Parts) -> Option<Undivided> {
    let heads = electrode.burns.first().into_iter().flat_map(|burn| &burn.parts);
    let is_it = |id: &PartId, part: &&Numbered| (part.stage, part.number) == (electrode.stage, id.part);
    let of = |id: &PartId| parts[id.region].iter().find(|part| is_it(id, part)).and_then(|part| part.undivided);
    heads.filter_map(of).reduce(Undivided::and)
}

/// Whether it can be milled.
fn milling(
    electrode: &Electrode,
    undivided: Option<Undivided>,
    (cutters, params): (&CutterLibrary, &ElectrodeParams),
    cancel: &Cancel,
) -> Result<Finding, ElectrodeError> {
    // Tips that cannot be set on a plate are tried with their whole base.
    let plate = on_plate(&joined(electrode.tips.clone(), electrode.others.clone()));
    let milled = plate.as_ref().unwrap_or(&electrode.mesh);
    let milling = match machinable(milled, cutters, params.tolerance_mm, undivided, cancel) {
        Err(HeightFieldError::Cancelled(cancelled)) => return Err(cancelled.into()),
        Err(error) => {
            Finding::failed(CheckKind::Machinable, format!("it could not be tried: {error}"), ("not_tried", 1.0))
        }
        Ok(finding) => placed_first(finding, electrode),
    };
    Ok(if electrode.is_thin { thin(params) } else { milling })
}

/// Finding for an earlier stage, whose residual stock the later stages burn.
fn for_later() -> Finding {
    let text = "what it leaves is for the stages after it".to_owned();
    Finding::new(CheckKind::ResidualStock, true, text, None)
}

fn thin(params: &ElectrodeParams) -> Finding {
    let least = params.least_size_mm;
    let text = format!("a head is thinner than the least size of {least} mm: reduce spark gap, orbit or least size");
    Finding::failed(CheckKind::Machinable, text, ("too_thin", 1.0))
}

/// A finding on an electrode by itself, with its place where the first burn puts it.
fn placed_first(finding: Finding, electrode: &Electrode) -> Finding {
    let Some(burn) = electrode.burns.first() else { return finding };
    let back = to_burn_frame(electrode.direction).transpose();
    let at = |p: DVec3| burn.position + back * DVec2::from_angle(burn.turn).rotate(p.truncate()).extend(p.z);
    Finding { place: finding.place.map(at), ..finding }
}

/// Residual stock of a region after all burns.
#[derive(Default)]
struct Left {
    /// All of it.
    all: LeftOfRegion,
    /// Of each part what is left where it stands, by number.
    of_parts: BTreeMap<usize, LeftOfRegion>,
    /// Residual stock where no part stands.
    of_none: LeftOfRegion,
    /// Residual stock in slots and corners that no electrode of this spark enters.
    in_slots: LeftOfRegion,
    /// Residual stock that the mold hangs over.
    shaded: LeftOfRegion,
    /// Another burn direction, where that is more than is allowed.
    proposal: Option<BurnProposal>,
    looked: Looked,
}

fn left_of(
    (setting, overhangs, milled): (&Setting, &Overhangs, &Milled),
    (number, plan, region): (usize, &RegionPlan, &RegionToBurn),
    electrodes: &[&Electrode],
    (stages, params): (&[Stage], &ElectrodeParams),
    cancel: &Cancel,
) -> Result<Left, ElectrodeError> {
    cancel.check()?;
    let Some(last) = stages.last() else { return Ok(Left::default()) };
    let mut burns: Vec<Burning> = Vec::new();
    for electrode in electrodes {
        for burn in electrode.burns.iter().filter(|b| b.parts.iter().any(|p| p.region == number)) {
            let mesh = electrode.burning(&electrode.tips, burn, &setting.turned);
            burns.push(Burning::new(&mesh, &stages[electrode.stage])?);
        }
    }
    let parts = plan.tree.as_ref().map_or_else(Vec::new, in_plan);
    let cuts = plan.tree.as_ref().map_or_else(Vec::new, cuts);
    let corners: Vec<[DVec3; 3]> = region.corners.iter().map(|c| c.map(|p| setting.turned * p)).collect();
    let radii = [last.gap_mm, last.gap_mm + last.orbit.radius_mm()];
    let (samples, looked) = samples(&corners, region, (&setting.edges, &cuts), radii);
    let samples = overhangs.without_hidden(samples, (&setting.mold, &setting.turned), milled.within);
    let back = setting.turned.transpose();
    let leaves = |p: DVec3, within: f64| (milled.leaves)(back * p, within);
    let milled = Milled { leaves: &leaves, within: milled.within };
    let fullest = fullest(&setting.surface, (last, params.margin_mm), &corners, cancel)?;
    let burns = Burns { all: &burns, fullest: fullest.as_ref() };
    let found = left_by(&burns, &samples, (&setting.mold, &milled), cancel)?;
    let reach = last.most_across() + CELL;
    let mut left = Left { looked, ..Left::default() };
    let are_shaded: Vec<bool> = found.iter().map(|found| found.is_shaded).collect();
    for (sample, found) in samples.iter().zip(found) {
        let is_own = found.left.thickness > 0.0;
        let (is_shaded, is_in_slot, is_unreached) = (found.is_shaded, found.is_in_slot, found.is_unreached);
        let found = found.left.moved(|p| back * p);
        left.all = left.all.and(found);
        if is_shaded {
            left.shaded = left.shaded.and(found);
            continue;
        }
        if is_in_slot {
            left.in_slots = left.in_slots.and(found);
            continue;
        }
        let own = if is_own { own_parts(sample, &parts, reach) } else { Vec::new() };
        if own.is_empty() {
            left.of_none = left.of_none.and(found);
        } else if is_unreached {
            left.in_slots = left.in_slots.and(found);
            continue;
        }
        for part in own {
            let of_part = left.of_parts.entry(part).or_default();
            *of_part = of_part.and(found);
        }
    }
    if left.shaded.excess > params.tolerance_mm + milled.accuracy() {
        let samples: Vec<(Sample, bool)> = samples.into_iter().zip(are_shaded).collect();
        left.proposal = proposed(&setting.mold, &setting.turned, (&samples, radii[1]), cancel)?;
    }
    Ok(left)
}

/// The parts that have a sample to burn: the nearest in plan within `reach` of it, of those that stand over one another
/// all.
fn own_parts(sample: &Sample, parts: &[(usize, Vec<Outline>)], reach: f64) -> Vec<usize> {
    let p = sample.point.truncate();
    let off: Vec<(usize, f64)> = parts.iter().map(|(part, free)| (*part, plane::off(free, p))).collect();
    let least = off.iter().map(|(_, off)| *off).fold(reach, f64::min);
    off.into_iter().filter(|(_, off)| *off <= least + NEARER).map(|(part, _)| part).collect()
}

/// The parts that are not divided further, by number, in plan.
fn in_plan(node: &PartNode) -> Vec<(usize, Vec<Outline>)> {
    let free = || node.outlines.iter().filter_map(|points| Outline::new(points.clone())).collect();
    match node.part {
        Some(part) => vec![(part, free())],
        None => node.parts.iter().flat_map(in_plan).collect(),
    }
}

/// The cuts between parts.
fn cuts(node: &PartNode) -> Vec<Cut> {
    let own = node.cut.iter().copied();
    own.chain(node.parts.iter().flat_map(cuts)).collect()
}

/// Report on residual stock that no head comes near, with its place.
fn nobodys(left: &Left, (tolerance, accuracy): (f64, f64)) -> Option<(String, DVec3)> {
    let text = |LeftOfRegion { excess, excess_place: place, .. }: LeftOfRegion, why: &str, remedy: &str| {
        (excess > tolerance + accuracy)
            .then(|| (format!("residual stock {excess:.4} mm {why}, allowed rest {tolerance:.4} mm: {remedy}"), place))
    };
    let shaded = text(
        left.shaded,
        "where a wall of the mold hangs over it, so that no head that sinks straight reaches it",
        &left.proposal.map_or_else(
            || "no straight burn from another direction sees more of it".to_owned(),
            |proposal| format!("burn the region from another direction: {proposal}"),
        ),
    );
    let remedy = "reduce spark gap or orbit, or add a cutter";
    let nobodys = || text(left.of_none, "where no head reaches", remedy);
    let sharpest = (-OPPOSED).acos().to_degrees();
    let narrow = format!(
        "in a groove or corner that is sharper than {sharpest:.1} deg or narrower than spark gap and orbit on both \
         sides, whose floor no spark of this gap reaches"
    );
    shaded.or_else(nobodys).or_else(|| text(left.in_slots, &narrow, remedy))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::rectangle;

    #[test]
    fn what_is_left_is_charged_to_the_parts_that_stand_there() {
        let at = |x: f64| Outline::new(rectangle(2.0, 1.0).iter().map(|p| *p + DVec2::X * x).collect());
        // Two that reach over one another by 0.2 mm, and one apart.
        let parts: Vec<(usize, Vec<Outline>)> =
            [0.0, 1.8, 6.0].into_iter().enumerate().map(|(i, x)| (i, at(x).into_iter().collect())).collect();
        let own = |x: f64, y: f64| {
            let sample = Sample { point: DVec3::new(x, y, -1.0), normal: DVec3::Z, area: 1.0, thickest: 1.0 };
            own_parts(&sample, &parts, 0.1)
        };
        assert_eq!(own(0.0, 0.0), [0]);
        assert_eq!(own(0.9, 0.0), [0, 1], "where both stand");
        assert_eq!(own(2.0, 0.55), [1], "its wall");
        assert_eq!(own(6.0, -0.55), [2]);
        assert!(own(4.0, 0.0).is_empty() && own(0.0, 0.7).is_empty(), "where none comes");
    }
}
