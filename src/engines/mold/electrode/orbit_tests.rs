//! Orbits in hollows whose facets are shorter than the orbit.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DAffine3, DMat3, DVec2, DVec3};

use super::burning::Burning;
use super::clearance::Obstacle;
use super::design::{Electrode, ElectrodeSet};
use super::finding::CheckKind;
use super::params::{ElectrodeParams, Orbit, Stage};
use super::setting::GOUGE;
use super::tests::{GAP, mold, params, planned, region};
use crate::fixtures::{dish, polygon, rectangle};
use geometry::exact::ExactMesh;
use geometry::fixtures::{clipped, polygon_area};
use geometry::mesh::{Bounds, Mesh};
use geometry::solid::{difference, prism, union};

const RADIUS: f64 = 0.3;
const DEPTH: f64 = 3.0;

/// A rectangle with rounded corners of so many facets.
fn rounded(x: f64, y: f64, radius: f64, facets: usize) -> Vec<DVec2> {
    let quarter = |k: usize| {
        let middle = DVec2::from_angle(FRAC_PI_2 * (k as f64 + 0.5)).signum() * (DVec2::new(x, y) / 2.0 - radius);
        let at = move |i: usize| DVec2::from_angle(FRAC_PI_2 * (k as f64 + i as f64 / facets as f64)) * radius;
        (0..=facets).map(move |i| middle + at(i))
    };
    (0..4).flat_map(quarter).collect()
}

/// Area of what a convex hollow leaves a tip in plan: what lies the gap off each side at every one of these shifts.
fn room(hollow: &[DVec2], shifts: &[DVec2]) -> f64 {
    let mut kept = hollow.to_vec();
    for shift in shifts {
        for i in 0..hollow.len() {
            let (a, b) = (hollow[i], hollow[(i + 1) % hollow.len()]);
            let inward = (b - a).perp().normalize();
            kept = clipped(&kept, |p| inward.dot(p + *shift - a) - GAP);
        }
    }
    polygon_area(&kept)
}

fn planned_with(orbit: Orbit, hollow: &[DVec2], tolerance_mm: f64) -> (Mesh, ElectrodeSet) {
    let mold = mold([20.0, 20.0, 10.0], &[(hollow, DEPTH)]);
    let set = planned_in(&mold, orbit, tolerance_mm);
    (mold, set)
}

fn planned_in(mold: &Mesh, orbit: Orbit, tolerance_mm: f64) -> ElectrodeSet {
    let middle = mold.bounds().center().truncate();
    let all = region(mold, middle - 4.5, middle + 4.5);
    let stage = Stage { orbit, ..Stage::finish(GAP) };
    planned(mold, &[all], &ElectrodeParams { stages: vec![stage], tolerance_mm, ..params(GAP) })
}

/// The corners of a square orbit.
fn corners() -> [DVec2; 4] {
    [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)].map(|(x, y)| DVec2::new(x, y) * RADIUS)
}

/// Places all along its sides.
fn around() -> impl Iterator<Item = DVec2> {
    let sides = (0..4).map(|k| (corners()[k], corners()[(k + 1) % 4]));
    sides.flat_map(|(a, b)| (0..8).map(move |i| a.lerp(b, f64::from(i) / 8.0)))
}

#[test]
fn a_square_orbit_keeps_the_gap_in_round_hollows_with_the_coordinates_of_files() {
    // Upright and slanting walls of a body that is not about the origin, in single precision.
    for floor in [3.0, 2.6] {
        let levels = [(polygon(64, 3.0), 10.0), (polygon(64, floor), 10.0 - DEPTH)];
        let mold = dish(&polygon(64, 12.0), &levels, 10.0 - DEPTH);
        let mold = mold.mapped(|p| (p + DVec3::new(-10.1, 3.3, -10.0)).as_vec3().as_dvec3());
        assert!(mold.is_watertight());
        let set = planned_in(&mold, Orbit::Square { radius_mm: RADIUS }, 0.02);
        assert!(set.holds(), "{:?} {:?}", set.checks, set.regions[0].reason);
        let nearest = least_distance(&mold, &burning(&set.electrodes[0]), around());
        assert!((GAP - 1e-6..GAP + 1e-3).contains(&nearest), "{nearest}");
    }
}

/// A slim pin on a plate before an edge of the electrode, where the orbit brings the two nearest.
#[test]
fn what_an_edge_of_the_electrode_meets_between_the_corners_of_its_orbit_is_found() {
    const PIN: f64 = 0.05;
    let plate = prism(&[&rectangle(20.0, 20.0)], -2.0, 0.0).unwrap();
    // Its edge is at the origin, and looks along X.
    let edge = polygon(4, 2.0).iter().map(|p| *p - DVec2::X * 2.0).collect::<Vec<_>>();
    let electrode = prism(&[&edge], 1.0, 4.0).unwrap();
    for (orbit, at) in [
        (Orbit::Square { radius_mm: 0.5 }, DVec2::new(0.5, 0.13)),
        (Orbit::Circular { radius_mm: 0.5 }, DVec2::from_angle(0.0137) * 0.5),
        (Orbit::Circular { radius_mm: 0.5 }, DVec2::from_angle(-0.3) * 0.5),
    ] {
        let away = if matches!(orbit, Orbit::Square { .. }) { DVec2::X } else { at.normalize() };
        for (off, keeps) in [(GAP - 2.0 * GOUGE, false), (GAP + GOUGE, true)] {
            let pin: Vec<DVec2> = polygon(720, PIN).iter().map(|p| *p + at + away * (off + PIN)).collect();
            let mold = union(&plate, &prism(&[&pin], -1.0, 3.0).unwrap()).unwrap();
            let stage = Stage { orbit, ..Stage::finish(GAP) };
            let clearance = Obstacle::new(&mold).unwrap().clearance(&electrode, &stage, 10.0).unwrap();
            assert_eq!(clearance.findings(&stage)[0].holds, keeps, "{orbit:?} {off}: {clearance:?}");
        }
    }
}

/// The electrode where it burns.
fn burning(electrode: &Electrode) -> Mesh {
    electrode.burning(&electrode.mesh, &electrode.burns[0], &DMat3::IDENTITY)
}

/// Least distance of an electrode from a mold at these shifts.
fn least_distance(mold: &Mesh, electrode: &Mesh, shifts: impl Iterator<Item = DVec2>) -> f64 {
    let (mold, electrode) = (ExactMesh::new(mold).unwrap(), ExactMesh::new(electrode).unwrap());
    let at = |shift: DVec2| mold.distance_to(&electrode, &DAffine3::from_translation(shift.extend(0.0)));
    shifts.map(at).fold(f64::INFINITY, f64::min)
}

/// Volume of the part of an electrode in the mold.
fn volume_within(electrode: &Mesh) -> f64 {
    difference(electrode, &prism(&[&rectangle(50.0, 50.0)], 0.0, 90.0).unwrap()).unwrap().volume()
}

#[test]
fn a_square_orbit_keeps_the_gap_in_round_hollows_and_takes_all_the_room_there_is() {
    // In the obtuse corners that look along X and Y a square leaves its half side times the tangent of half their turn.
    for (hollow, tolerance) in [(polygon(64, 3.0), 0.02), (polygon(12, 3.0), 0.09), (rounded(8.0, 6.0, 0.4, 8), 0.02)] {
        let (mold, set) = planned_with(Orbit::Square { radius_mm: RADIUS }, &hollow, tolerance);
        let [electrode] = &set.electrodes[..] else { panic!("{:?}", set.regions[0].reason) };
        assert!(set.holds(), "{:?}", set.checks);
        let electrode = burning(electrode);
        let nearest = least_distance(&mold, &electrode, around());
        assert!((GAP - 1e-6..GAP + 1e-3).contains(&nearest), "{nearest}");
        let expected = room(&hollow, &corners()) * (DEPTH - GAP);
        assert!((volume_within(&electrode) / expected - 1.0).abs() < 1e-6, "{} {expected}", volume_within(&electrode));
    }
}

#[test]
fn a_circular_orbit_keeps_the_gap_in_round_hollows_and_takes_all_the_room_there_is() {
    let around = || (0..96).map(|k| DVec2::from_angle(f64::from(k) / 96.0 * TAU) * RADIUS);
    for hollow in [polygon(64, 3.0), polygon(12, 3.0), rounded(8.0, 6.0, 0.4, 8), rounded(8.0, 6.0, 0.2, 8)] {
        let (mold, set) = planned_with(Orbit::Circular { radius_mm: RADIUS }, &hollow, 0.02);
        let [electrode] = &set.electrodes[..] else { panic!("{:?}", set.regions[0].reason) };
        assert!(set.holds(), "{:?}", set.checks);
        let electrode = burning(electrode);
        let nearest = least_distance(&mold, &electrode, around());
        assert!((GAP - 1e-6..GAP + 1e-3).contains(&nearest), "{nearest}");
        // A side is nearest at the place of the circle along its normal.
        let n = hollow.len();
        let normals: Vec<DVec2> =
            (0..n).map(|i| -(hollow[(i + 1) % n] - hollow[i]).perp().normalize() * RADIUS).collect();
        let expected = room(&hollow, &normals) * (DEPTH - GAP);
        assert!((volume_within(&electrode) / expected - 1.0).abs() < 1e-6, "{} {expected}", volume_within(&electrode));
    }
}

#[test]
fn a_round_hollow_narrower_than_gap_and_orbit_has_no_tip() {
    for (orbit, radius) in [
        (Orbit::None, 0.03),
        (Orbit::None, 0.045),
        (Orbit::Circular { radius_mm: RADIUS }, 0.2),
        (Orbit::Circular { radius_mm: RADIUS }, 0.34),
        (Orbit::Square { radius_mm: RADIUS }, 0.25),
        (Orbit::Square { radius_mm: RADIUS }, 0.4),
    ] {
        let (_, set) = planned_with(orbit, &polygon(24, radius), 0.02);
        assert!(set.electrodes.is_empty() && !set.holds(), "{orbit:?} {radius}");
        let reason = set.regions[0].reason.clone().unwrap_or_default();
        assert!(reason.contains("narrower than twice the spark gap"), "{reason}");
    }
}

/// A pocket with rounded corners and a fillet around its floor, in facets shorter than the orbit.
fn filleted(corner: f64, fillet: f64) -> Mesh {
    /// Facets of the fillet, and of each corner.
    const FACETS: usize = 6;
    let level = |i: usize| {
        let around = FRAC_PI_2 * i as f64 / FACETS as f64;
        let inwards = fillet * (1.0 - around.cos());
        let outline = rounded(5.0 - 2.0 * inwards, 4.0 - 2.0 * inwards, corner - inwards, FACETS);
        (outline, 10.0 - DEPTH + fillet * (1.0 - around.sin()))
    };
    let mut levels = vec![(level(0).0, 10.0)];
    levels.extend((0..=FACETS).map(level));
    // The block has as many corners as each level.
    dish(&rounded(20.0, 20.0, 2.0, FACETS), &levels, 10.0 - DEPTH).mapped(|p| p - DVec3::Z * 10.0)
}

#[test]
fn a_circular_orbit_keeps_the_gap_where_a_floor_rises_into_a_fillet() {
    let around = || (0..96).map(|k| DVec2::from_angle(f64::from(k) / 96.0 * TAU) * RADIUS);
    for (corner, fillet) in [(0.5, 0.4), (0.32, 0.3), (1.0, 0.2)] {
        let mold = filleted(corner, fillet);
        assert!(mold.is_watertight() && mold.volume() > 0.0);
        // What its way leaves in the fillets is not looked at here.
        let set = planned_in(&mold, Orbit::Circular { radius_mm: RADIUS }, 0.5);
        assert!(!set.electrodes.is_empty(), "{:?}", set.regions[0].reason);
        let mut all = Vec::new();
        for (made, findings) in set.electrodes.iter().zip(&set.checks) {
            assert!(findings.iter().filter(|f| f.kind != CheckKind::Machinable).all(|f| f.holds), "{findings:?}");
            let nearest = least_distance(&mold, &burning(made), around());
            assert!((GAP - GOUGE..GAP + 1e-3).contains(&nearest), "{corner} {fillet}: {nearest}");
            all.extend(made.burns.iter().flat_map(|b| made.burning(&made.tips, b, &DMat3::IDENTITY).vertices));
        }
        // Floor and walls are flat, and as far off as they should be.
        let bounds = Bounds::of(all);
        assert!((bounds.min.z - (GAP - DEPTH)).abs() < 1e-6, "{bounds:?}");
        let size = DVec2::new(5.0, 4.0) - 2.0 * (GAP + RADIUS);
        assert!((bounds.size().truncate() - size).abs().max_element() < 1e-6, "{bounds:?}");
    }
}

#[test]
fn places_share_a_tip_only_where_it_keeps_the_gap_all_along_its_orbit() {
    // Two slots, the second narrower by so much that their tips are laid onto each other, and nearer than the gap
    // allows.
    for (narrower, electrodes) in [(0.0, 1), (0.003, 2)] {
        let slot = |x: f64, y: f64, width: f64| -> Vec<DVec2> {
            rectangle(6.0, width).iter().map(|p| *p + DVec2::new(x, y)).collect()
        };
        let slots = [slot(-5.0, -4.0, 2.0), slot(5.0, 4.0, 2.0 - narrower)];
        let mold = mold([30.0, 20.0, 10.0], &[(&slots[0], DEPTH), (&slots[1], DEPTH)]);
        let own = [-1.0, 1.0].map(|s| {
            let at = DVec2::new(5.0, 4.0) * s;
            region(&mold, at - DVec2::new(3.1, 1.1), at + DVec2::new(3.1, 1.1))
        });
        for orbit in [Orbit::Circular { radius_mm: 0.1 }, Orbit::Square { radius_mm: 0.1 }] {
            let stage = Stage { orbit, ..Stage::finish(GAP) };
            let asked = ElectrodeParams { stages: vec![stage], together_mm: 0.0, ..params(GAP) };
            let set = planned(&mold, &own, &asked);
            assert!(set.holds(), "{orbit:?} {narrower}: {:?}", set.checks);
            assert_eq!(set.electrodes.len(), electrodes, "{orbit:?} {narrower}");
        }
    }
}

#[test]
fn the_wall_of_a_step_is_burned_by_the_orbit_though_the_tip_over_the_step_is_nearer() {
    // A step at height -1, its wall at x = 0: the tip keeps gap and radius off the wall, and the gap off the step.
    let radius = 0.1;
    let block = |x: [f64; 2], z: [f64; 2]| {
        prism(&[&[(x[0], -2.0), (x[1], -2.0), (x[1], 2.0), (x[0], 2.0)].map(DVec2::from)], z[0], z[1]).unwrap()
    };
    let tip = union(&block([-5.0, -GAP - radius], [-3.0 + GAP, 1.0]), &block([-6.0, 3.0], [-1.0 + GAP, 2.0])).unwrap();
    for orbit in [Orbit::Circular { radius_mm: radius }, Orbit::Square { radius_mm: radius }] {
        let burning = Burning::new(&tip, &Stage { orbit, ..Stage::finish(GAP) }).unwrap();
        for z in [-1.0, -1.02, -1.05, -1.09, -2.0] {
            let beyond = burning.beyond(DVec3::new(0.0, 0.3, z));
            assert!((-1e-9..=GOUGE).contains(&beyond), "{orbit:?} {z}: {beyond}");
        }
        // Within the wall what is beyond is as far as it is deep.
        let beyond = burning.beyond(DVec3::new(0.03, 0.3, -2.0));
        assert!((beyond - 0.03).abs() <= GOUGE, "{orbit:?}: {beyond}");
    }
}

#[test]
fn orbits_gaps_finishes_and_times_are_those_of_their_definitions() {
    let slanted = DVec3::new(0.6, 0.0, 0.8);
    let circle = Stage { orbit: Orbit::Circular { radius_mm: 0.2 }, ..Stage::finish(0.1) };
    assert!((circle.undersize(DVec3::X) - 0.3).abs() < 1e-12 && (circle.undersize(DVec3::Z) - 0.1).abs() < 1e-12);
    assert!((circle.undersize(slanted) - (0.1 + 0.12)).abs() < 1e-12);
    let square = Stage { orbit: Orbit::Square { radius_mm: 0.2 }, ..Stage::finish(0.1) };
    let diagonal = DVec3::new(1.0, 1.0, 0.0).normalize();
    assert!((square.undersize(diagonal) - (0.1 + 0.2 * 2f64.sqrt())).abs() < 1e-12);
    // The machine does not turn a square with its electrode.
    let turns = [0.0, 0.3, std::f64::consts::FRAC_PI_2, -std::f64::consts::PI];
    assert_eq!(turns.map(|turn| square.orbit.fits_turned(turn)), [true, false, true, true]);
    assert!(turns.iter().all(|turn| circle.orbit.fits_turned(*turn)));
    // VDI 3400: class 0 is 0.1 um, class 20 is 1 um, class 40 is 10 um.
    for (class, roughness) in [(0.0, 0.1), (20.0, 1.0), (40.0, 10.0)] {
        let stage = Stage { finish_vdi: class, ..Stage::finish(0.1) };
        assert!((stage.roughness_um() - roughness).abs() < 1e-12);
    }
}

#[test]
fn an_orbit_makes_the_tip_smaller_in_plan_only_and_every_check_holds() {
    let mold = mold([30.0, 20.0, 10.0], &[(&rectangle(8.0, 2.0), 5.0)]);
    let slot = region(&mold, DVec2::new(-4.1, -1.1), DVec2::new(4.1, 1.1));
    for orbit in [Orbit::Circular { radius_mm: 0.3 }, Orbit::Square { radius_mm: 0.3 }] {
        let stage = Stage { orbit, ..Stage::finish(GAP) };
        let set = planned(&mold, std::slice::from_ref(&slot), &ElectrodeParams { stages: vec![stage], ..params(GAP) });
        assert!(set.holds(), "{orbit:?} {:?}", set.checks);
        let size = set.electrodes[0].tips.bounds().size();
        assert!((size.x - (8.0 - 0.7)).abs() < 1e-6 && (size.y - (2.0 - 0.7)).abs() < 1e-6, "{orbit:?} {size}");
        assert!((set.electrodes[0].burns[0].depth - (5.0 - GAP)).abs() < 1e-6);
    }
}
