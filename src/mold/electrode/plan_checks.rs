//! The checks of a plan's electrodes.

use glam::{DMat3, DVec2, DVec3};
use rayon::prelude::*;

use super::base::on_plate;
use super::check::{
    Burning, Finding, LeftOfRegion, Milled, Obstacle, Sample, allowed, left_by, leftover, machinable, watertight,
};
use super::design::{Electrode, RegionPlan};
use super::params::{ElectrodeParams, Stage};
use super::plan::{ElectrodeError, RegionToBurn, to_burn_frame};
use crate::geometry::mesh::{Mesh, unit_normal};
use crate::mold::cutter::CutterLibrary;
use crate::progress::Cancel;

/// The z component of the unit normal from which on a face is a floor.
const FLOOR: f64 = 0.5;
/// Samples of a region's surface at most.
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
    let last = electrodes.iter().map(|e| e.stage).max().unwrap_or(0);
    let upright = Obstacle::new(mold)?;
    let left = (0..regions.len())
        .into_par_iter()
        .map(|r| left_of((&upright, milled), r, electrodes, &regions[r], stages, cancel));
    let left: Vec<LeftOfRegion> = left.collect::<Result<_, ElectrodeError>>()?;
    plans.iter_mut().zip(&left).for_each(|(plan, left)| plan.left = *left);
    let most = stages.get(last).map_or(params.tolerance_mm, |stage| allowed(stage, params.tolerance_mm));
    let check = |electrode: &Electrode| -> Result<Vec<Finding>, ElectrodeError> {
        cancel.check()?;
        let closed = watertight(&electrode.mesh);
        let is_closed = closed.holds;
        let mut findings = vec![closed];
        let turned = to_burn_frame(electrode.direction);
        let setting = mold.mapped(|p| turned * p);
        let obstacle = if turned == DMat3::IDENTITY { None } else { Some(Obstacle::new(&setting)?) };
        let obstacle = obstacle.as_ref().unwrap_or(&upright);
        let mut worst: [Option<Finding>; 2] = [None, None];
        for burn in &electrode.burns {
            let mesh = electrode.burning(&electrode.mesh, burn, &turned);
            let found = obstacle.clearance(&mesh, &stages[electrode.stage], params.lift_mm)?;
            for (worst, found) in worst.iter_mut().zip(found) {
                if worst.as_ref().is_none_or(|w| w.holds && !found.holds) {
                    let place = found.place.map(|p| turned.transpose() * p);
                    *worst = Some(Finding { place, ..found });
                }
            }
        }
        findings.extend(worst.into_iter().flatten());
        let own = electrode.burns.iter().flat_map(|b| &b.parts).map(|p| left[p.region]);
        if let Some(left) = own.max_by(|a, b| a.thickness.total_cmp(&b.thickness)) {
            findings.push(leftover(&left, most));
        }
        if is_closed {
            let milled = on_plate(&electrode.tips)?;
            findings.push(placed_first(machinable(&milled, cutters, params.tolerance_mm, cancel)?, electrode));
        }
        Ok(findings)
    };
    electrodes.par_iter().map(check).collect()
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
    electrodes: &[Electrode],
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
    let stride = region.corners.len() / SAMPLES + 1;
    let sample = |(corners, depth): (&[DVec3; 3], &f64)| {
        let upright = unit_normal(*corners).z;
        let [a, b, c] = corners.map(|p| turned * p);
        let twice = (b - a).cross(c - a);
        let (normal, area) = (twice.normalize_or_zero(), 0.5 * twice.length() * stride as f64);
        // What lies on a floor is as thick as it is high, across the surface.
        let thickest = if upright > FLOOR { (depth * upright).min(region.thickness) } else { region.thickness };
        Sample { point: (a + b + c) / 3.0, normal, area, thickest }
    };
    let samples: Vec<Sample> = region.corners.iter().zip(&region.depths).step_by(stride).map(sample).collect();
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
    findings.extend(Obstacle::new(mold)?.clearance(electrode, stage, params.lift_mm)?);
    if is_closed {
        findings.push(machinable(electrode, cutters, params.tolerance_mm, cancel)?);
    }
    Ok(findings)
}
