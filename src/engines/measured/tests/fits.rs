//! Fits: known errors are found, what the surface does not determine is named.

use geometry::frame::Frame;
use geometry::mesh::Mesh;
use glam::{DAffine3, DQuat, DVec3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use task::{Cancel, Task};

use super::meshes::{NOISE, drum, ellipsoid, error_about, nominal, normal, points_on, scan, without_a_third, wrong_by};
use crate::deviation::deviations;
use crate::fit::{BestFit, FitSettings, Freedom, Freedoms, Undetermined, best_fit};
use crate::{MeasuredError, Nominal};

/// What a fit may be wrong by at the surface (mm).
const ALLOWED: f64 = 0.002;

fn fit(nominal: &Nominal, points: &[DVec3]) -> BestFit {
    best_fit(nominal, points, &FitSettings::default(), &Task::default()).unwrap()
}

/// Fits a scan with noise and a rigid error of the points, of which 30 % are missing, and checks the fit. What it is
/// wrong by is what displaces the surface along its normals, or what changes the `measure` of the smooth surface that
/// the facets stand for, such as the radius: facets that turn on a sphere displace nothing of it.
fn checked(name: &str, mesh: Mesh, points: &[(DVec3, DVec3)], measure: Option<fn(DVec3) -> f64>) -> BestFit {
    let nominal = nominal(mesh);
    let seen = without_a_third(points, DVec3::new(0.3, 0.8, 0.2));
    let error = error_about(nominal.mesh().bounds().center());
    let fit = fit(&nominal, &scan(&seen, &error, NOISE, 7));
    let motion = fit.motion * error;
    let wrong = match measure {
        None => wrong_by(points, &motion),
        Some(measure) => {
            let off = |p: DVec3| (measure(motion.transform_point3(p)) - measure(p)).abs();
            points.iter().map(|(p, _)| off(*p)).fold(0.0, f64::max)
        }
    };
    assert!(wrong < ALLOWED, "{name}: {wrong}");
    assert!(fit.has_converged && (fit.rms_mm / NOISE - 1.0).abs() < 0.1, "{name}: {}", fit.rms_mm);
    assert!((fit.scale_mm / NOISE - 1.0).abs() < 0.1);
    fit
}

fn translations(fit: &BestFit) -> Vec<DVec3> {
    let of = |open: &Undetermined| match open {
        Undetermined::Translation { direction, .. } => Some(*direction),
        Undetermined::Rotation { .. } => None,
    };
    fit.undetermined.iter().filter_map(of).collect()
}

/// Points and directions of the axes of the rotations that are open.
fn rotations(fit: &BestFit) -> Vec<(DVec3, DVec3)> {
    let of = |open: &Undetermined| match open {
        Undetermined::Translation { .. } => None,
        Undetermined::Rotation { point, direction, pitch, .. } => {
            assert_eq!(*pitch, 0.0);
            Some((*point, *direction))
        }
    };
    fit.undetermined.iter().filter_map(of).collect()
}

#[test]
fn a_box_determines_all() {
    let mesh = Mesh::cuboid(DVec3::new(80.0, 50.0, 30.0));
    let points = points_on(&mesh, 20_000, 1);
    assert!(checked("box", mesh, &points, None).undetermined.is_empty());
}

#[test]
fn an_ellipsoid_determines_all() {
    let mesh = ellipsoid(DVec3::new(40.0, 28.0, 18.0));
    let points = points_on(&mesh, 20_000, 2);
    assert!(checked("ellipsoid", mesh, &points, None).undetermined.is_empty());
}

#[test]
fn a_plane_leaves_two_translations_and_a_rotation_open() {
    let mesh = Mesh::cuboid(DVec3::new(100.0, 80.0, 10.0));
    let is_inner = |p: DVec3| p.z == 10.0 && p.x > 3.0 && p.x < 97.0 && p.y > 3.0 && p.y < 77.0;
    let points: Vec<_> = points_on(&mesh, 30_000, 3).into_iter().filter(|(p, _)| is_inner(*p)).collect();
    let fit = checked("plane", mesh, &points, None);
    let open = translations(&fit);
    assert!(open.len() == 2 && open[0].abs_diff_eq(DVec3::X, 1e-3) && open[1].abs_diff_eq(DVec3::Y, 1e-3), "{open:?}");
    let turns = rotations(&fit);
    assert!(turns.len() == 1 && turns[0].1.abs_diff_eq(DVec3::Z, 1e-3), "{turns:?}");
    let words: Vec<String> = fit.undetermined.iter().map(ToString::to_string).collect();
    assert!(words[0] == "translation along X" && words[2].starts_with("rotation about the axis along Z through"));
    let values = fit.values.iter().map(|v| (v.freedom, v.value.abs()));
    assert!(values.clone().all(|(freedom, value)| freedom != Freedom::C || value < 1e-4), "{values:?}");
}

#[test]
fn a_cylinder_leaves_a_translation_and_a_rotation_open() {
    let mesh = drum(20.0, 60.0, 120);
    let is_side = |p: DVec3, n: DVec3| n.z.abs() < 0.5 && p.z > 2.0 && p.z < 58.0;
    let points: Vec<_> = points_on(&mesh, 30_000, 4).into_iter().filter(|(p, n)| is_side(*p, *n)).collect();
    let fit = checked("cylinder", mesh, &points, Some(|p| p.truncate().length()));
    let (open, turns) = (translations(&fit), rotations(&fit));
    assert!(open.len() == 1 && open[0].abs_diff_eq(DVec3::Z, 1e-3), "{open:?}");
    assert!(turns.len() == 1 && turns[0].1.abs_diff_eq(DVec3::Z, 1e-3), "{turns:?}");
    assert!(turns[0].0.truncate().length() < 0.1, "{turns:?}");
}

#[test]
fn a_sphere_leaves_three_rotations_open() {
    const CENTRE: DVec3 = DVec3::new(10.0, 5.0, -3.0);
    let mesh = ellipsoid(DVec3::splat(25.0)).mapped(|p| p + CENTRE);
    let points = points_on(&mesh, 20_000, 5);
    let fit = checked("sphere", mesh, &points, Some(|p| p.distance(CENTRE)));
    let turns = rotations(&fit);
    assert!(fit.undetermined.len() == 3 && turns.len() == 3, "{:?}", fit.undetermined);
    for ((point, direction), axis) in turns.iter().zip([DVec3::X, DVec3::Y, DVec3::Z]) {
        assert!(direction.abs_diff_eq(axis, 1e-6));
        let off = (CENTRE - *point).reject_from(axis).length();
        assert!(off < 0.2, "{point} {direction}: {off}");
    }
}

#[test]
fn a_scan_without_noise_is_fitted_exactly_and_few_points_far_off_are_not_lost() {
    // A plate, of which one point in 60 lies on its sides, off by half a millimetre.
    let mesh = Mesh::cuboid(DVec3::new(100.0, 80.0, 2.0));
    let points = points_on(&mesh, 12_000, 6);
    let nominal = nominal(mesh);
    let error = DAffine3::from_translation(DVec3::new(0.5, -0.4, 0.0));
    let scanned = scan(&points, &error, 0.0, 0);
    let fit = fit(&nominal, &scanned);
    let wrong = wrong_by(&points, &(fit.motion * error));
    assert!(wrong < 1e-6 && fit.undetermined.is_empty(), "{wrong} {:?}", fit.undetermined);
}

#[test]
fn stray_points_hardly_move_the_fit() {
    let mesh = Mesh::cuboid(DVec3::new(80.0, 50.0, 30.0));
    let nominal = nominal(mesh);
    let points = points_on(nominal.mesh(), 20_000, 8);
    let error = error_about(DVec3::new(40.0, 25.0, 15.0));
    let clean = scan(&points, &error, NOISE, 9);
    let before = fit(&nominal, &clean);
    // On one side only, which is worse than all around: up to 2 mm outside, 1 mm in the mean.
    let mut random = ChaCha8Rng::seed_from_u64(10);
    let mut stray = clean.clone();
    for i in (0..stray.len()).step_by(50) {
        stray[i] += error.transform_vector3(points[i].1) * (1.0 + 0.3 * normal(&mut random));
    }
    let after = fit(&nominal, &stray);
    let moved = wrong_by(&points, &(after.motion * before.motion.inverse()));
    let wrong = wrong_by(&points, &(after.motion * error));
    assert!(moved < ALLOWED && wrong < ALLOWED && after.undetermined.is_empty());
}

#[test]
fn a_clamp_beyond_reach_determines_nothing() {
    let mesh = Mesh::cuboid(DVec3::new(100.0, 80.0, 10.0));
    let nominal = nominal(mesh);
    let is_inner = |p: DVec3| p.z == 10.0 && p.x > 3.0 && p.x < 97.0 && p.y > 3.0 && p.y < 77.0;
    let points: Vec<_> = points_on(nominal.mesh(), 30_000, 3).into_iter().filter(|(p, _)| is_inner(*p)).collect();
    let mut scanned = scan(&points, &DAffine3::from_translation(DVec3::Z * 0.3), NOISE, 11);
    // A clamp beside the plate: 2 % of the points, nearest to the side of the plate.
    let mut random = ChaCha8Rng::seed_from_u64(12);
    let clamp = scanned.len() / 50;
    scanned.extend(
        (0..clamp).map(|_| DVec3::new(101.5 + random.random::<f64>(), 30.0 + 20.0 * random.random::<f64>(), 4.0)),
    );
    let settings = FitSettings { reach_mm: 1.0, ..FitSettings::default() };
    let fit = best_fit(&nominal, &scanned, &settings, &Task::default()).unwrap();
    assert_eq!(fit.beyond_reach, clamp);
    assert_eq!((translations(&fit).len(), rotations(&fit).len()), (2, 1), "{:?}", fit.undetermined);
    assert!(fit.motion.translation.truncate().length() < 1e-3, "{:?}", fit.motion);
}

#[test]
fn only_the_freedoms_of_a_machine_move() {
    let mesh = Mesh::cuboid(DVec3::new(80.0, 50.0, 30.0));
    let nominal = nominal(mesh);
    let points = points_on(nominal.mesh(), 10_000, 13);
    let frame = Frame::from_x_and_z_hint(DVec3::new(40.0, 25.0, 0.0), DVec3::new(1.0, 0.5, 0.0), DVec3::Z);
    // What the machine has to correct: its values brought back.
    let turn = DAffine3::from_axis_angle(frame.z, 0.4f64.to_radians());
    let about = DAffine3::from_translation(frame.origin) * turn * DAffine3::from_translation(-frame.origin);
    let shift = frame.direction_to_parent(DVec3::new(0.3, -0.2, 0.1));
    let correction = DAffine3::from_translation(shift) * about;
    let scanned = scan(&points, &correction.inverse(), NOISE, 14);
    let settings =
        |free: &[Freedom]| FitSettings { freedoms: Freedoms::of(frame, free).unwrap(), ..FitSettings::default() };
    let all = [Freedom::X, Freedom::Y, Freedom::Z, Freedom::C];
    let fit = best_fit(&nominal, &scanned, &settings(&all), &Task::default()).unwrap();
    let expected = [0.3, -0.2, 0.1, 0.4f64.to_radians()];
    for (value, expected) in fit.values.iter().zip(expected) {
        let off = (value.value - expected).abs();
        assert!(off < 5.0 * value.standard_deviation && value.standard_deviation < 2e-4, "{value:?} {expected}");
    }
    assert!((fit.motion.matrix3 * DVec3::Z).abs_diff_eq(DVec3::Z, 1e-12) && fit.undetermined.is_empty());
    let one = best_fit(&nominal, &scanned, &settings(&[Freedom::Y]), &Task::default()).unwrap();
    assert!(one.values.len() == 1 && one.motion.translation.normalize().dot(frame.y).abs() > 1.0 - 1e-12);
}

#[test]
fn standard_deviations_are_those_of_many_scans() {
    let mesh = Mesh::cuboid(DVec3::new(40.0, 30.0, 20.0)).mapped(|p| p - DVec3::new(20.0, 15.0, 10.0));
    let nominal = nominal(mesh);
    let points = points_on(nominal.mesh(), 600, 15);
    let fits: Vec<BestFit> =
        (0..60).map(|seed| fit(&nominal, &scan(&points, &DAffine3::IDENTITY, NOISE, 100 + seed))).collect();
    for k in 0..6 {
        let seen = (fits.iter().map(|f| f.values[k].value.powi(2)).sum::<f64>() / fits.len() as f64).sqrt();
        let told = fits.iter().map(|f| f.values[k].standard_deviation).sum::<f64>() / fits.len() as f64;
        assert!((seen / told - 1.0).abs() < 0.35, "{k}: {seen} {told}");
    }
}

#[test]
fn neither_threads_nor_the_order_of_points_matter() {
    let mesh = ellipsoid(DVec3::new(40.0, 28.0, 18.0));
    let nominal = nominal(mesh);
    let points = points_on(nominal.mesh(), 5_000, 16);
    let error = DAffine3::from_rotation_translation(DQuat::from_rotation_y(0.005), DVec3::new(0.2, 0.1, -0.3));
    let scanned = scan(&points, &error, NOISE, 17);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let fit = fit(&nominal, &scanned);
            let map = deviations(&nominal, &scanned, &fit.motion, &Task::default()).unwrap();
            (fit, map)
        })
    };
    let (one, two) = (on(1), on(2));
    assert_eq!(one, two);
    let backwards: Vec<DVec3> = scanned.iter().rev().copied().collect();
    let other = fit(&nominal, &backwards);
    assert!(wrong_by(&points, &(other.motion * one.0.motion.inverse())) < 1e-8);
}

#[test]
fn too_few_points_odd_points_and_cancelling_are_told() {
    let nominal = nominal(Mesh::cuboid(DVec3::ONE));
    let run = |points: &[DVec3], task: &Task| best_fit(&nominal, points, &FitSettings::default(), task).unwrap_err();
    let few = run(&[DVec3::ZERO; 6], &Task::default());
    assert!(few.to_string().contains("the scan has 6 points that count, the fit needs at least 7"), "{few}");
    let mut odd = vec![DVec3::ONE; 9];
    odd[4].y = f64::NAN;
    assert!(run(&odd, &Task::default()).to_string().contains("point 5 "));
    let settings = |reach_mm: f64| FitSettings { reach_mm, ..FitSettings::default() };
    let far = vec![DVec3::splat(5.0); 9];
    let reached = |reach_mm| best_fit(&nominal, &far, &settings(reach_mm), &Task::default()).unwrap_err();
    assert!(matches!(reached(1.0), MeasuredError::TooFewPoints { found: 0, .. }));
    assert!(matches!(reached(f64::NAN), MeasuredError::BadSetting { .. }));
    let cancel = Cancel::default();
    cancel.cancel();
    assert!(matches!(run(&[DVec3::ONE; 9], &Task::silent(&cancel)), MeasuredError::Cancelled(_)));
    // One place over and over, and places on a line, determine little, but are no error.
    for points in
        [vec![DVec3::new(0.5, 0.5, 1.0); 9], (0..9).map(|i| DVec3::new(0.1 * f64::from(i), 0.5, 1.1)).collect()]
    {
        let fit = best_fit(&nominal, &points, &FitSettings::default(), &Task::default()).unwrap();
        assert!(fit.undetermined.len() >= 2 && fit.rms_mm < 1e-6, "{fit:?}");
    }
}
