//! Deviations: signs, statistics, worst places, verdict.

use geometry::mesh::Mesh;
use glam::{DAffine3, DVec3};
use task::Task;

use super::meshes::{NOISE, error_about, nominal, points_on, scan};
use crate::MeasuredError;
use crate::deviation::{DeviationMap, Tolerance, deviations};
use crate::fit::{FitSettings, best_fit};
use crate::points::{PointLimits, points_from_bytes};
use crate::table::{deviations_csv, deviations_ply};

fn map_of(size: DVec3, points: &[DVec3]) -> DeviationMap {
    deviations(&nominal(Mesh::cuboid(size)), points, &DAffine3::IDENTITY, &Task::default()).unwrap()
}

#[test]
fn a_bump_of_known_height_is_found_with_its_place_and_extent() {
    const HEIGHT: f64 = 0.08;
    const RADIUS: f64 = 4.0;
    let mesh = Mesh::cuboid(DVec3::new(80.0, 50.0, 30.0));
    let nominal = nominal(mesh);
    let centre = DVec3::new(55.0, 20.0, 30.0);
    let mut points = points_on(nominal.mesh(), 30_000, 21);
    let share = |p: DVec3| 1.0 - (p - centre).length_squared() / (RADIUS * RADIUS);
    for (p, _) in &mut points {
        if p.z == 30.0 && share(*p) > 0.0 {
            p.z += HEIGHT * share(*p);
        }
    }
    let scanned = scan(&points, &error_about(DVec3::new(40.0, 25.0, 15.0)), 0.2 * NOISE, 22);
    let fit = best_fit(&nominal, &scanned, &FitSettings::default(), &Task::default()).unwrap();
    let map = deviations(&nominal, &scanned, &fit.motion, &Task::default()).unwrap();
    let tolerance = Tolerance::symmetric(0.02).unwrap();
    // Triangles 2 and 3 of the box are its top.
    let worst = map.worst(3, 10.0, &tolerance, |d| d.triangle / 2);
    assert!((worst[0].deviation.distance - HEIGHT).abs() < 0.005, "{:?}", worst[0]);
    assert!(worst[0].surface == 1 && worst[0].deviation.nearest.distance(centre) < 1.0);
    assert!(worst[1].deviation.distance.abs() < 0.01 && worst[1].deviation.point.distance(centre) > 9.0);
    // The paraboloid is higher than the tolerance within a radius of 4 mm times the root of three quarters.
    let above = map.list().iter().filter(|d| tolerance.excess(d.distance) > 0.0);
    let reach = above.map(|d| d.nearest.distance(centre)).fold(0.0, f64::max);
    assert!((reach - RADIUS * 0.75f64.sqrt()).abs() < 0.2, "{reach}");
    let verdict = map.verdict(&tolerance);
    let text = verdict.to_string();
    assert!(!verdict.is_within && text.contains("outside of the tolerance of -0.0200 to +0.0200 mm"), "{text}");
    assert_eq!(verdict.farthest, Some(worst[0].deviation));
    let by = map.statistics_by(&tolerance, |d| d.triangle / 2);
    assert_eq!(by.len(), 6);
    assert!(by.iter().all(|(face, s)| (s.share_within < 1.0) == (*face == 1)), "{by:?}");
    assert!(map.verdict(&tolerance.for_share(0.9).unwrap()).is_within);
}

#[test]
fn deviations_are_positive_outside_of_the_metal() {
    let size = DVec3::new(10.0, 20.0, 30.0);
    let points = [DVec3::new(5.0, 10.0, 30.5), DVec3::new(5.0, 10.0, 29.8), DVec3::new(-0.1, 10.0, 15.0)];
    let map = map_of(size, &points);
    let found: Vec<f64> = map.list().iter().map(|d| d.distance).collect();
    assert!(found.iter().zip([0.5, -0.2, 0.1]).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
    let statistics = map.statistics(&Tolerance::between(-0.3, 0.15).unwrap());
    assert!((statistics.least_mm + 0.2).abs() < 1e-12 && (statistics.greatest_mm - 0.5).abs() < 1e-12);
    assert!((statistics.mean_mm - 0.4 / 3.0).abs() < 1e-12 && (statistics.rms_mm - 0.1f64.sqrt()).abs() < 1e-12);
    assert!(statistics.within == 2 && (statistics.share_within - 2.0 / 3.0).abs() < 1e-12);
}

#[test]
fn what_lies_beyond_reach_is_left_out_and_counted() {
    let map = map_of(DVec3::splat(10.0), &[DVec3::new(5.0, 5.0, 10.01), DVec3::new(5.0, 5.0, 14.0)]);
    let (near, others) = map.within_reach(1.0);
    assert_eq!((near.list().len(), others), (1, 1));
    let tolerance = Tolerance::symmetric(0.02).unwrap();
    let verdict = near.verdict(&tolerance);
    assert!(verdict.is_within && verdict.farthest.is_none());
    assert_eq!(verdict.to_string(), "within the tolerance of -0.0200 to +0.0200 mm: all 1 points lie in it");
    let (none, others) = map.within_reach(1e-3);
    assert!(others == 2 && !none.verdict(&tolerance).is_within, "no points keep no tolerance");
    assert!(none.worst(5, 0.0, &tolerance, |_| ()).is_empty());
}

#[test]
fn tolerances_that_make_no_sense_are_refused() {
    for mm in [0.0, -0.1, f64::NAN, f64::INFINITY] {
        assert!(Tolerance::symmetric(mm).is_err(), "{mm}");
    }
    let tolerance = Tolerance::between(-0.01, 0.05).unwrap();
    for share in [0.0, 1.1, f64::NAN] {
        assert!(tolerance.for_share(share).is_err(), "{share}");
    }
    let nothing = deviations(&nominal(Mesh::cuboid(DVec3::ONE)), &[], &DAffine3::IDENTITY, &Task::default());
    assert!(matches!(nothing, Err(MeasuredError::TooFewPoints { .. })));
}

#[test]
fn files_hold_every_point_with_its_deviation() {
    let points = [DVec3::new(5.0, 10.0, 30.5), DVec3::new(5.0, 10.0, 29.75)];
    let map = map_of(DVec3::new(10.0, 20.0, 30.0), &points);
    let csv = deviations_csv(&map, |d| if d.distance > 0.0 { "hub, \"outer\"" } else { "top" });
    let lines: Vec<&str> = csv.lines().collect();
    assert_eq!(lines[0], "x_mm,y_mm,z_mm,deviation_mm,surface");
    assert_eq!(lines[1], "5.000000,10.000000,30.500000,0.500000,\"hub, \"\"outer\"\"\"");
    assert_eq!(lines[2], "5.000000,10.000000,29.750000,-0.250000,top");
    let scan = points_from_bytes("map.csv", csv.as_bytes(), &PointLimits::default(), &Task::default()).unwrap();
    assert_eq!(scan.points, points);
    let ply = deviations_ply(&map, |d| if d > 0.0 { [255, 0, 0] } else { [0, 0, 255] });
    let scan = points_from_bytes("map.ply", &ply, &PointLimits::default(), &Task::default()).unwrap();
    assert_eq!(scan.points, points);
    let end = ply.len() - 7;
    assert_eq!((&ply[end..end + 3], &ply[end + 3..]), ([0, 0, 255].as_slice(), (-0.25f32).to_le_bytes().as_slice()));
}
