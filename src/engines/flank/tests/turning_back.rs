//! Paths must not turn back at their ends, and one that does is measured where it is, not where it would go on.

use super::*;
use crate::path::FlankPath;

/// A bulged wall that leans by 3 mm on 20 mm, through as many points of the lower and the upper guide. Those of the
/// upper one are unevenly spread if the counts differ.
fn bulged([lower, upper]: [u32; 2], side: Side) -> RuledSurface {
    let guide = |count: u32, power: f64, (lean, z): (f64, f64)| {
        let at = |u: f64| DVec3::new(60.0 * u, 8.0 * (std::f64::consts::PI * u).sin() + lean, z);
        let points = (0..count).map(|i| at((f64::from(i) / f64::from(count - 1)).powf(power)));
        GuideCurve::Points { points: points.collect(), degree: 3 }
    };
    let (power, lean) = if lower == upper { (1.0, 3.0) } else { (1.5, 0.0) };
    RuledSurface::from_guides(&guide(lower, 1.0, (0.0, 0.0)), &guide(upper, power, (lean, 20.0)), side).unwrap()
}

/// The least cosine between the ways that both curves of a path go at neighbouring ones of many places.
fn least_turn(path: &FlankPath) -> f64 {
    const PLACES: i32 = 1000;
    let speeds = |i: i32| {
        let at = path.axis.at(f64::from(i) / f64::from(PLACES));
        [at.tip_speed, at.top_speed].map(DVec3::normalize_or_zero)
    };
    let turn = |i: i32| {
        let [before, after] = [speeds(i), speeds(i + 1)];
        before[0].dot(after[0]).min(before[1].dot(after[1]))
    };
    (0..PLACES).map(turn).fold(1.0, f64::min)
}

#[test]
fn refined_paths_over_a_bulged_wall_go_on_to_their_ends() {
    let cutter = FlankCutter::cylinder(2.0, 40.0);
    for (counts, side) in [
        ([200, 200], Side::Positive),
        ([200, 200], Side::Negative),
        ([40, 77], Side::Positive),
        ([40, 77], Side::Negative),
    ] {
        let surface = bulged(counts, side);
        let plan = planned(&surface, &cutter, &FlankParams::default()).unwrap();
        let path = &plan.refined;
        let what = format!("{counts:?} {side:?}");
        for (name, path) in plan.paths() {
            assert!(least_turn(path) > 0.99, "{what} {name}: {}", least_turn(path));
        }
        assert!(path.coverage.is_whole, "{what}: {:?}", path.coverage);
        let is_settled = plan.chosen.deviation.is_settled();
        assert!(is_settled || path.deviation.sum < plan.chosen.deviation.sum, "{what}: refinement still gains");
        // Measured anew on another grid, the same path is as good.
        let finer = DesignGrid::new(&surface, [173, 31]);
        let ((deviation, _), coverage, envelope) = path.over(&finer, &cutter.above(path.below_mm).unwrap()).unwrap();
        assert!(coverage.is_whole, "{what}: {coverage:?}");
        let [before, after] = [&path.deviation, &deviation].map(|d| d.most_undercut.max(-d.most_overcut));
        assert!(after < 1.5 * before, "{what}: {before} {after}");
        assert!((deviation.mean / path.deviation.mean - 1.0).abs() < 0.05, "{what}: {}", deviation.mean);
        assert!((envelope.deviation.mean / deviation.mean - 1.0).abs() < 0.05, "{what}: {}", envelope.deviation.mean);
    }
}

#[test]
fn a_path_that_turns_back_past_the_ends_of_a_plane_covers_it_without_deviation() {
    let guide = |z: f64| GuideCurve::Bezier { points: vec![DVec3::new(0.0, 0.0, z), DVec3::new(60.0, 0.0, z)] };
    let surface = RuledSurface::from_guides(&guide(0.0), &guide(20.0), Side::Positive).unwrap();
    let normal = surface.normal(0.5, 0.5);
    let cutter = FlankCutter::cylinder(2.0, 40.0);
    // Its first and last legs go back, so that it turns outside of the plane: the plane is covered.
    let along = [0.3, -1.5, 8.0, 17.0, 26.0, 34.0, 43.0, 52.0, 61.5, 59.7];
    let row = |z: f64| along.map(|x| DVec3::new(x, 0.0, z) + 2.0 * normal).to_vec();
    let axis = AxisSurface::new(row(0.0), row(20.0), [0.0, 1.0]).unwrap();
    let ends = (0..=1000).map(|i| axis.at(f64::from(i) / 1000.0).tip.x);
    let [low, high] = ends.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], x| [l.min(x), h.max(x)]);
    assert!(low < 0.0 && high > 60.0, "{low} {high}");
    let grid = DesignGrid::new(&surface, [200, 5]);
    let path = Measured::new(&grid, axis, &cutter, None).unwrap();
    let [first, last] = path.feet.t_range();
    assert!(first >= 0.0 && last <= 1.0, "{first} {last}");
    assert!(path.deviation.sum < 1e-9, "{}", path.deviation.sum);
}
