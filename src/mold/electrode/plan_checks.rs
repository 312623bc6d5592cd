//! The checks of a plan's electrodes.

use std::collections::BTreeSet;

use glam::{DMat3, DVec2, DVec3};
use rayon::prelude::*;

use super::base::on_plate;
use super::burning::Burning;
use super::check::{
    CheckKind, Clearance, Finding, LeftOfRegion, Milled, Obstacle, Sample, left_by, leftover, machinable, watertight,
};
use super::design::{Burn, Electrode, RegionPlan};
use super::params::{ElectrodeParams, Stage};
use super::plan::{ElectrodeError, RegionToBurn, to_burn_frame};
use super::tip::joined;
use crate::geometry::mesh::{Mesh, unit_normal};
use crate::mold::cutter::CutterLibrary;
use crate::mold::height_field::HeightFieldError;
use crate::progress::Cancel;

/// The z component of the unit normal from which on a face is a floor.
const FLOOR: f64 = 0.5;
/// Longest side of the part of a surface that a sample stands for, if there are not too many of them (mm).
const FINE: f64 = 0.2;
/// Samples of a region's surface, about, at most.
const SAMPLES: usize = 6000;

/// The findings for each electrode; what is left of each region goes into its plan.
pub(super) fn checked(
    (mold, milled): (&Mesh, &Milled),
    electrodes: &[Electrode],
    plans: &mut [RegionPlan],
    regions: &[RegionToBurn],
    (cutters, params, stages): (&CutterLibrary, &ElectrodeParams, &[Stage]),
    cancel: &Cancel,
) -> Result<Vec<Vec<Finding>>, ElectrodeError> {
    // What stages before the last burn does not have its finish.
    let last: Vec<&Electrode> = electrodes.iter().filter(|e| e.stage + 1 == stages.len()).collect();
    let upright = Obstacle::new(mold)?;
    let left =
        (0..regions.len()).into_par_iter().map(|r| left_of((&upright, milled), r, &last, &regions[r], stages, cancel));
    let left: Vec<LeftOfRegion> = left.collect::<Result<_, ElectrodeError>>()?;
    plans.iter_mut().zip(&left).for_each(|(plan, left)| plan.left = *left);
    let check = |electrode: &Electrode| -> Result<Vec<Finding>, ElectrodeError> {
        cancel.check()?;
        let closed = watertight(&electrode.mesh);
        let is_closed = closed.holds;
        let mut findings = vec![closed];
        let turned = to_burn_frame(electrode.direction);
        let setting = mold.mapped(|p| turned * p);
        let obstacle = if turned == DMat3::IDENTITY { None } else { Some(Obstacle::new(&setting)?) };
        let obstacle = obstacle.as_ref().unwrap_or(&upright);
        let stage = &stages[electrode.stage];
        let clearance = |burn: &Burn| {
            let mesh = electrode.burning(&electrode.mesh, burn, &turned);
            obstacle.clearance(&mesh, stage, params.lift_mm.max(burn.depth))
        };
        let all: Vec<Clearance> = electrode.burns.iter().map(clearance).collect::<Result<_, _>>()?;
        if let Some(worst) = all.into_iter().reduce(Clearance::worse) {
            let [gouge, approach] = worst.findings(stage);
            let short = electrode.burns.iter().find(|burn| params.lift_mm < burn.depth);
            let upright = |f: Finding| Finding { place: f.place.map(|p| turned.transpose() * p), ..f };
            findings.push(upright(gouge));
            findings.push(short.map_or_else(|| upright(approach), |burn| too_short_a_lift(params.lift_mm, burn)));
        }
        // Of all regions that it is for, each once, as the sum of what is told of each.
        let own: BTreeSet<usize> = electrode.burns.iter().flat_map(|b| &b.parts).map(|p| p.region).collect();
        if let Some(left) = own.into_iter().map(|r| left[r]).reduce(LeftOfRegion::and) {
            let is_last = electrode.stage + 1 == stages.len();
            findings.push(if is_last { leftover(&left, params.tolerance_mm, stage) } else { for_later() });
        }
        if is_closed {
            // Tips that cannot be set on a plate are tried with their whole base.
            let plate = on_plate(&joined(electrode.tips.clone(), electrode.others.clone()));
            let milled = plate.as_ref().unwrap_or(&electrode.mesh);
            let milling = match machinable(milled, cutters, params.tolerance_mm, cancel) {
                Err(HeightFieldError::Cancelled(cancelled)) => return Err(cancelled.into()),
                Err(error) => Finding::failed(CheckKind::Machinable, format!("it could not be tried: {error}")),
                Ok(finding) => placed_first(finding, electrode),
            };
            findings.push(if electrode.is_thin { thin(params) } else { milling });
        }
        Ok(findings)
    };
    electrodes.par_iter().map(check).collect()
}

fn too_short_a_lift(lift: f64, burn: &Burn) -> Finding {
    let text =
        format!("lifted by {lift} mm it is still in the mold, {:.2} mm deep: a larger lift_mm is needed", burn.depth);
    Finding { place: Some(burn.position), ..Finding::failed(CheckKind::Approach, text) }
}

/// What an earlier stage leaves is the business of those after it.
fn for_later() -> Finding {
    let text = "what it leaves is for the stages after it".to_owned();
    Finding { kind: CheckKind::Leftover, holds: true, text, place: None }
}

fn thin(params: &ElectrodeParams) -> Finding {
    let least = params.least_size_mm;
    let text = format!(
        "a tip is thinner than the least size of {least} mm: a smaller gap or orbit, or a smaller least_size_mm"
    );
    Finding::failed(CheckKind::Machinable, text)
}

/// A finding on an electrode by itself, with its place where the first burn puts it.
fn placed_first(finding: Finding, electrode: &Electrode) -> Finding {
    let Some(burn) = electrode.burns.first() else { return finding };
    let back = to_burn_frame(electrode.direction).transpose();
    let at = |p: DVec3| burn.position + back * DVec2::from_angle(burn.turn).rotate(p.truncate()).extend(p.z);
    Finding { place: finding.place.map(at), ..finding }
}

/// What all burns leave of a region.
fn left_of(
    (mold, milled): (&Obstacle, &Milled),
    number: usize,
    electrodes: &[&Electrode],
    region: &RegionToBurn,
    stages: &[Stage],
    cancel: &Cancel,
) -> Result<LeftOfRegion, ElectrodeError> {
    let mut burns: Vec<Burning> = Vec::new();
    let mut turned = DMat3::IDENTITY;
    for electrode in electrodes {
        for burn in electrode.burns.iter().filter(|b| b.parts.iter().any(|p| p.region == number)) {
            turned = to_burn_frame(electrode.direction);
            let mesh = electrode.burning(&electrode.tips, burn, &turned);
            burns.push(Burning::new(&mesh, &stages[electrode.stage])?);
        }
    }
    let samples = samples(region, &turned);
    let back = turned.transpose();
    let in_frame;
    let mold = if turned == DMat3::IDENTITY {
        mold
    } else {
        in_frame = mold.turned(&turned)?;
        &in_frame
    };
    let leaves = |p: DVec3| (milled.leaves)(back * p);
    let milled = Milled { leaves: &leaves, within: milled.within };
    let left = left_by(&burns.iter().collect::<Vec<_>>(), &samples, (mold, &milled), cancel)?;
    Ok(LeftOfRegion { place: back * left.place, ..left })
}

/// Places of a region's surface, evenly by area: large parts are divided, of small ones each stands for its neighbours.
pub(super) fn samples(region: &RegionToBurn, turned: &DMat3) -> Vec<Sample> {
    let area = |[a, b, c]: &[DVec3; 3]| 0.5 * (*b - *a).cross(*c - *a).length();
    let all: f64 = region.corners.iter().map(area).sum();
    let share = (all / SAMPLES as f64).max(1e-9);
    let longest = FINE.max((4.0 * share).sqrt());
    let (mut samples, mut waiting) = (Vec::new(), 0.0);
    for (corners, depth) in region.corners.iter().zip(&region.depths) {
        let upright = unit_normal(*corners).z;
        // What lies on a floor is as thick as it is high, across the surface.
        let thickest = if upright > FLOOR { (depth * upright).min(region.thickness) } else { region.thickness };
        let normal = *turned * unit_normal(*corners);
        let mut parts = vec![*corners];
        while let Some(part) = parts.pop() {
            let [a, b, c] = part;
            let sides = [a.distance(b), b.distance(c), c.distance(a)];
            let most = sides.iter().copied().fold(0.0, f64::max);
            if most > longest {
                let [a, b, c] = match sides.iter().position(|s| *s == most) {
                    Some(1) => [b, c, a],
                    Some(2) => [c, a, b],
                    _ => [a, b, c],
                };
                parts.extend([[a, a.midpoint(b), c], [a.midpoint(b), b, c]]);
                continue;
            }
            waiting += area(&part);
            if waiting >= share {
                samples.push(Sample { point: *turned * ((a + b + c) / 3.0), normal, area: waiting, thickest });
                waiting = 0.0;
            }
        }
    }
    samples
}

/// Checks of electrodes from elsewhere, placed in the upright mold, as those of a plan are checked.
///
/// # Errors
/// [`ElectrodeError`].
pub fn check_own(
    mold: &Mesh,
    electrode: &Mesh,
    stage: &Stage,
    (cutters, params): (&CutterLibrary, &ElectrodeParams),
    cancel: &Cancel,
) -> Result<Vec<Finding>, ElectrodeError> {
    let closed = watertight(electrode);
    let is_closed = closed.holds;
    let mut findings = vec![closed];
    findings.extend(Obstacle::new(mold)?.clearance(electrode, stage, params.lift_mm)?.findings(stage));
    if is_closed {
        findings.push(machinable(electrode, cutters, params.tolerance_mm, cancel)?);
    }
    Ok(findings)
}
