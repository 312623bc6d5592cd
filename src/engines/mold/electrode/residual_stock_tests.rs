//! Residual stock of known size.

use std::f64::consts::{FRAC_1_SQRT_2, PI, SQRT_2};

use glam::{DMat3, DVec2, DVec3};

use super::clearance::Obstacle;
use super::design::ElectrodeSet;
use super::finding::{CheckKind, Finding};
use super::params::{ElectrodeParams, Orbit, Stage};
use super::plan::plan;
use super::residual_stock::{Burns, Milled, Sample, left_by};
use super::setting::ElectrodeError;
use super::tests::{GAP, cutters, mold, params, planned, region, ring};
use crate::fixtures::rectangle;
use geometry::mesh::{Mesh, unit_normal};
use geometry::solid::{difference, hull, prism};
use task::{Cancel, Task};

/// How far the spark of the gap stays from where two faces meet at right angles, and where three do (mm).
const ROUNDED: [f64; 2] = [GAP * (SQRT_2 - 1.0), GAP * 0.732_051];

/// A pocket with a slot of this width and length that leads out of it along X, both this deep.
fn pocket_with_slot(width: f64, length: f64, depth: f64) -> Mesh {
    let half = width / 2.0;
    let end = 2.0 + length;
    let outline = ring(&[
        (-2.0, -2.0),
        (2.0, -2.0),
        (2.0, -half),
        (end, -half),
        (end, half),
        (2.0, half),
        (2.0, 2.0),
        (-2.0, 2.0),
    ]);
    mold([30.0, 20.0, 10.0], &[(&outline, depth)])
}

fn planned_all(mold: &Mesh, stage: Stage) -> ElectrodeSet {
    let all = region(mold, DVec2::splat(-9.0), DVec2::splat(9.0));
    planned(mold, &[all], &ElectrodeParams { stages: vec![stage], ..params(GAP) })
}

fn residual_stock(findings: &[Finding]) -> &Finding {
    findings.iter().find(|f| f.kind == CheckKind::ResidualStock).unwrap()
}

#[test]
fn a_slot_that_no_electrode_enters_is_no_corner() {
    // Narrower than twice what the spark and the orbit need, so that all of it is near another face.
    let circular = Stage { orbit: Orbit::Circular { radius_mm: 0.2 }, ..Stage::finish(GAP) };
    for (stage, width, length) in [(Stage::finish(0.3), 0.42, 6.0), (circular.clone(), 0.34, 6.0), (circular, 0.3, 1.0)]
    {
        let depth = 3.0;
        let set = planned_all(&pocket_with_slot(width, length, depth), stage);
        assert!(!set.holds(), "{width}: {:?}", set.checks);
        let left = set.regions[0].left;
        assert!((left.excess - width / 2.0).abs() < 0.01, "{width}: {left:?}");
        // All of the slot, and what corners of the pocket keep.
        let slot = width * length * depth;
        assert!((0.9 * slot..1.15 * slot + 0.3).contains(&left.volume), "{width}: {} {slot}", left.volume);
        assert!(set.regions[0].reason.as_ref().is_some_and(|t| t.contains("where no head reaches")), "{width}");
        // The pocket itself is burned, and its electrode is not to blame.
        assert!(
            set.electrodes.iter().zip(&set.checks).all(|(_, found)| residual_stock(found).holds),
            "{:?}",
            set.checks
        );
    }
}

#[test]
fn corners_are_forgiven_what_the_spark_cannot_burn_however_sharp_and_no_more() {
    // Pockets with corners of 60, 90 and 120 degrees: a ball of radius g comes no nearer than g / sin(angle / 2) - g to
    // where two faces meet.
    for (sides, gap) in [(3, 0.1), (4, 0.1), (6, 0.1), (4, 0.3)] {
        let outline: Vec<DVec2> =
            (0..sides).map(|i| DVec2::from_angle(0.2 + 2.0 * PI * f64::from(i) / f64::from(sides)) * 3.0).collect();
        let mold = mold([20.0, 20.0, 10.0], &[(&outline, 3.0)]);
        let set = planned_all(&mold, Stage::finish(gap));
        let left = set.regions[0].left;
        assert!(residual_stock(&set.checks[0]).holds, "{sides} {gap}: {:?}", set.checks);
        let two = gap / (PI * (0.5 - 1.0 / f64::from(sides))).sin().min(FRAC_1_SQRT_2) - gap;
        assert!(left.excess < 2e-3 && left.thickness > 0.99 * two, "{sides} {gap}: {left:?} {two}");
    }
}

/// A groove of 43.6 degrees, in which the spark keeps 1.7 times its radius off the root.
#[test]
fn the_root_of_a_sharp_groove_is_a_corner_however_it_lies() {
    let keeps = GAP * (29f64.sqrt() / 2.0 - 1.0);
    for turn in [0.0f64, 0.3] {
        let turned = |p: DVec3| DVec2::from_angle(turn).rotate(p.truncate()).extend(p.z);
        let at = |x: f64| [(-0.8, 0.0), (0.8, 0.0), (0.0, -2.0)].map(|(y, z)| DVec3::new(x, y, z));
        let groove = hull([at(-2.0), at(2.0)].as_flattened()).mapped(turned);
        let mold = difference(&mold([12.0, 12.0, 10.0], &[]), &groove).unwrap();
        let all = region(&mold, DVec2::splat(-2.5), DVec2::splat(2.5));
        let set = planned(&mold, &[all], &params(GAP));
        let left = set.regions[0].left;
        assert!(set.regions[0].reason.is_none(), "{turn}: {:?}", set.regions[0].reason);
        assert!((0.99 * keeps..3.0 * keeps).contains(&left.thickness), "{turn}: {left:?} {keeps}");
    }
}

/// A pocket with a corner of 30 degrees in plan: on its floor no wall stands opposite, but no electrode comes near either.
#[test]
fn no_electrode_is_to_blame_for_the_floor_of_a_corner_that_none_enters() {
    let gap = 0.2;
    let across = 6.0 * (PI / 12.0).tan();
    let outline = ring(&[(0.0, 0.0), (6.0, -across), (6.0, across)]);
    let mold = mold([20.0, 20.0, 10.0], &[(&outline, 3.0)]);
    let set = planned_all(&mold, Stage::finish(gap));
    let blamed: Vec<&Finding> =
        set.checks.iter().map(|found| residual_stock(found)).filter(|found| !found.holds).collect();
    assert!(blamed.is_empty(), "{blamed:?}");
    // A disc of the gap's radius stays so far off the corner.
    let keeps = gap / (PI / 12.0).sin() - gap;
    let left = set.regions[0].left;
    assert!((0.5 * keeps..1.1 * keeps).contains(&left.thickness), "{left:?} {keeps}");
    let reason = set.regions[0].reason.as_ref().unwrap();
    assert!(reason.contains("in a groove or corner that is sharper"), "{reason}");
}

#[test]
fn what_a_sharp_floor_edge_keeps_is_found_in_a_pocket_however_large() {
    let (size, depth) = (90.0, 3.0);
    let mold = mold([120.0, 120.0, 10.0], &[(&rectangle(size, size), depth)]);
    let all = region(&mold, DVec2::splat(-50.0), DVec2::splat(50.0));
    let set = planned(&mold, &[all], &params(GAP));
    let left = set.regions[0].left;
    // Two faces meet at right angles; along the floor's edges and in the upright ones.
    assert!((0.99 * ROUNDED[0]..=ROUNDED[1] + 1e-6).contains(&left.thickness), "{left:?}");
    let volume = (1.0 - PI / 4.0) * GAP * GAP * (4.0 * size + 4.0 * depth);
    assert!((left.volume - volume).abs() < 0.2 * volume, "{} {volume}", left.volume);
    let said = &residual_stock(&set.checks[0]).text;
    assert!(said.contains("sampled every"), "{said}");
}

#[test]
fn stock_that_nothing_burns_is_as_thick_as_what_the_cutters_leave() {
    const THICK: f64 = 0.3;
    let mold = Obstacle::new(&mold([20.0, 20.0, 10.0], &[])).unwrap();
    let point = DVec3::new(10.0, 0.0, -5.0);
    let sample = Sample { point, normal: DVec3::X, area: 2.0, thickest: 1.0 };
    for within in [0.02, 0.05, 0.11] {
        let leaves = |p: DVec3, near: f64| p.x - near <= point.x + THICK;
        let milled = Milled { leaves: &leaves, within };
        let burns = Burns { all: &[], fullest: None };
        let found = left_by(&burns, &[sample], (&mold, &milled), &Cancel::default()).unwrap()[0].left;
        assert!((found.thickness - THICK).abs() < 0.02 * within, "{within}: {found:?}");
        assert!((found.volume - 2.0 * THICK).abs() < 0.04 * within, "{within}: {found:?}");
    }
}

#[test]
fn checks_of_an_orbit_stop_when_they_are_told_to() {
    let mold = pocket_with_slot(0.8, 3.0, 3.0);
    let all = region(&mold, DVec2::splat(-9.0), DVec2::splat(9.0));
    let stage = Stage { orbit: Orbit::Circular { radius_mm: 0.1 }, ..Stage::finish(GAP) };
    let set = planned_all(&mold, stage.clone());
    let electrode = &set.electrodes[0];
    let standing = electrode.burning(&electrode.mesh, &electrode.burns[0], &DMat3::IDENTITY);
    let cancel = Cancel::default();
    let obstacle = Obstacle::new(&mold).unwrap().stopped_by(&cancel);
    assert!(obstacle.clearance(&standing, &stage, 1.0).is_ok());
    cancel.cancel();
    let found = obstacle.clearance(&standing, &stage, 1.0);
    assert!(matches!(found, Err(ElectrodeError::Cancelled(_))), "{found:?}");
    let everything = |_: DVec3, _: f64| true;
    let milled = Milled { leaves: &everything, within: 0.05 };
    let asked = ElectrodeParams { stages: vec![stage], ..params(GAP) };
    let found = plan(&mold, &[all], (&cutters(), &milled), &asked, &Task::silent(&cancel));
    assert!(matches!(found, Err(ElectrodeError::Cancelled(_))));
}

#[test]
fn the_place_of_a_gouge_is_where_it_comes_nearest_and_stock_is_named() {
    // A long block whose middle comes near a ridge: its corners are far from it.
    let hollow = ring(&[(-9.0, -2.0), (9.0, -2.0), (9.0, 2.0), (0.5, 2.0), (0.0, 1.0), (-0.5, 2.0), (-9.0, 2.0)]);
    let mold = mold([30.0, 20.0, 10.0], &[(&hollow, 3.0)]);
    let obstacle = Obstacle::new(&mold).unwrap();
    let block = |high: f64| {
        let outline = ring(&[(-8.0, -1.0), (8.0, -1.0), (8.0, high), (-8.0, high)]);
        geometry::solid::prism(&[&outline], -2.0, 1.0).unwrap()
    };
    let stage = Stage { stock_mm: 0.1, ..Stage::finish(GAP) };
    for high in [0.9, 1.2] {
        let [gouge, _] = obstacle.clearance(&block(high), &stage, 5.0).unwrap().findings(&stage);
        let place = gouge.place.unwrap();
        assert!(!gouge.holds && place.x.abs() < 0.3 && (0.8..1.4).contains(&place.y), "{gouge:?}");
        assert!(gouge.text.contains("stock 0.1000 mm"), "{gouge:?}");
    }
}

/// Regions are known to cells, so that the surface of one beside an undercut goes on a little under what hangs over it.
/// What is left there is none of the region's. At the overhang's edge the electrode ends a gap before it, and its spark
/// leaves what it does where faces meet at right angles.
#[test]
fn what_lies_under_an_overhang_beside_a_region_is_not_left_of_it() {
    let pocket = mold([20.0, 20.0, 12.0], &[(&rectangle(4.0, 3.0), 6.0)]);
    let beside = [(1.9, -1.5), (4.0, -1.5), (4.0, 1.5), (1.9, 1.5)].map(DVec2::from);
    let mold = difference(&pocket, &prism(&[&beside], -6.0, -4.0).unwrap()).unwrap();
    let looks_up = |c: &[DVec3; 3]| unit_normal(*c).z > -1e-3;
    let corner = |high: f64| {
        let mut region = region(&mold, DVec2::new(0.9, -1.6), DVec2::new(high, -0.5));
        region.corners.retain(looks_up);
        region.depths = region.corners.iter().map(|c| -(c[0].z + c[1].z + c[2].z) / 3.0).collect();
        region
    };
    for high in [2.0001, 2.1] {
        let left = planned(&mold, &[corner(high)], &params(GAP)).regions[0].left;
        let is_rounded = (ROUNDED[0] - 1e-3..ROUNDED[1] + 1e-3).contains(&left.thickness);
        assert!(is_rounded && left.place.x <= 2.0, "{high}: {left:?}");
    }
    assert!(corner(2.1).corners.len() > corner(2.0001).corners.len());
}
