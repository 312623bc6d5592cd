//! The grid of the checks: it hangs on the surface and not on what its user asked for.

use super::*;
use crate::check_grid::{CheckGrid, CheckedPath};
use crate::path::FlankPath;
use crate::ruled_surface::SurfacePlace;

fn checked(surface: &RuledSurface, path: &FlankPath, cutter: &FlankCutter) -> CheckedPath {
    CheckGrid::new(surface).checked(path, &cutter.above(path.below_mm).unwrap()).unwrap()
}

/// A wall of 300 mm with guides of `count` points each and a bump towards the cutter, 0.6 mm high and about 1.5 mm
/// wide, midway between two places of a grid of 100.
fn wall_with_a_bump(count: u32) -> RuledSurface {
    const LENGTH: f64 = 300.0;
    let middle = LENGTH * 49.5 / 99.0;
    let guide = |z: f64| {
        let at = |i: u32| LENGTH * f64::from(i) / f64::from(count - 1);
        let points = (0..count).map(at).map(|x| DVec3::new(x, -0.6 * (-((x - middle) / 0.45).powi(2)).exp(), z));
        GuideCurve::Points { points: points.collect(), degree: 3 }
    };
    RuledSurface::from_guides(&guide(0.0), &guide(20.0), Side::Positive).unwrap()
}

#[test]
fn a_bump_between_two_places_of_the_plan_is_seen_by_the_check() {
    let surface = wall_with_a_bump(1201);
    let cutter = FlankCutter::cylinder(3.0, 30.0);
    let params = FlankParams { grid: [100, 4], rounds: 0, ..FlankParams::default() };
    let plan = planned(&surface, &cutter, &params).unwrap();
    let path = &plan.initial;
    assert!(path.deviation.most_overcut > -0.01, "the plan does not see it: {}", path.deviation.most_overcut);
    let found = checked(&surface, path, &cutter);
    // A straight path is 3 mm off the wall, so that what the moving cutter takes off the bump is its height, measured
    // along normals that lean beside the top.
    let grid = CheckGrid::new(&surface);
    let cut = grid.places.places().zip(&found.envelope.deviation.values).map(|(place, e)| e * place.normal.y);
    let height = cut.fold(0.0, f64::max);
    assert!((height - 0.6).abs() < 0.03, "{height} {}", found.words);
    assert!(found.deviation.most_overcut < -0.3, "{}", found.deviation.most_overcut);
    let values = &found.envelope.deviation.values;
    let deepest = (0..values.len()).min_by(|a, b| values[*a].total_cmp(&values[*b])).unwrap();
    assert!((surface.point(found.place(deepest)[0], 0.0).x - 150.0).abs() < 0.5, "{:?}", found.place(deepest));
    // Numbers are those of the grid's own places.
    let off = |(k, place): (usize, &SurfacePlace)| {
        let [u, v] = found.place(k);
        (place.u - u).abs().max((place.v - v).abs())
    };
    assert!(grid.places.places().enumerate().map(off).fold(0.0, f64::max) < 1e-12);
    // Nor does the cutter fit into the hollows at its feet.
    assert!(matches!(cutter.fits(&surface, 0.1), Err(FlankError::CutterTooThick { u, .. }) if (u - 0.5).abs() < 0.01));
}

#[test]
fn a_coarse_grid_of_the_plan_does_not_weaken_the_check() {
    let (surface, cutter, _) = case(&reference(), "cyl_R2_A");
    let of = |grid| {
        let params = FlankParams { offset: OffsetMethod::TwoPoint, grid, rounds: 0, ..FlankParams::default() };
        let path = planned(&surface, &cutter, &params).unwrap().initial;
        let own = path.deviation.most_overcut;
        (own, checked(&surface, &path, &cutter).deviation.most_overcut)
    };
    let (fine, coarse) = (of([100, 50]), of([100, 2]));
    assert!(fine.0 < -0.1 && fine.1 == fine.0, "the cutter cuts in between both guides: {fine:?}");
    assert!(coarse.0 > -0.01, "a plan that looks at both guides only sees nothing of it: {coarse:?}");
    assert!((coarse.1 / fine.1 - 1.0).abs() < 1e-3, "{coarse:?} {fine:?}");
}

#[test]
fn every_piece_of_both_guides_has_two_places_and_there_is_an_end_to_them() {
    let wavy = |count: u32, z: f64| {
        let at = |i: u32| f64::from(i) * 200.0 / f64::from(count - 1);
        let points = (0..count).map(at).map(|x| DVec3::new(x, (0.1 * x).sin(), z)).collect();
        GuideCurve::Points { points, degree: 3 }
    };
    let surface = |counts: [u32; 2]| {
        RuledSurface::from_guides(&wavy(counts[0], 0.0), &wavy(counts[1], 10.0), Side::Positive).unwrap()
    };
    let uneven = surface([401, 37]);
    let places = uneven.places_along(100);
    assert!(places.windows(2).all(|w| w[0] < w[1]) && places[0] == 0.0 && places[places.len() - 1] == 1.0);
    for curve in [uneven.lower(), uneven.upper()] {
        for [from, to] in curve.knots().joints().windows(2).map(|w| [w[0], w[1]]) {
            let within = places.iter().filter(|u| (from..to).contains(*u)).count();
            assert!(within >= 2 || to - from < 1e-6, "{within} from {from} to {to}");
        }
    }
    // Few pieces need no more than the even places.
    assert_eq!(surface([5, 5]).places_along(100).len(), 100);
    assert_eq!(surface([9000, 9000]).places_along(100).len(), RuledSurface::MOST_ALONG);
}
