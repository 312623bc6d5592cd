//! Paths once around closed surfaces.

use super::*;
use crate::axis_surface::CubicBasis;
use crate::own_surface::own_surface;
use crate::path::FlankPath;
use crate::plan::RING_FIT_MM;

/// An exact circle around the z axis, which starts `turn_deg` from the x axis.
fn circle(radius: f64, z: f64, turn_deg: f64) -> GuideCurve {
    let corner = |i: u32| {
        let angle = (turn_deg + 45.0 * f64::from(i)).to_radians();
        let far = if i.is_multiple_of(2) { radius } else { radius * std::f64::consts::SQRT_2 };
        DVec3::new(far * angle.cos(), far * angle.sin(), z)
    };
    let weight = |i: u32| if i.is_multiple_of(2) { 1.0 } else { std::f64::consts::FRAC_1_SQRT_2 };
    GuideCurve::BSpline {
        degree: 2,
        knots: vec![0.0, 0.0, 0.0, 0.25, 0.25, 0.5, 0.5, 0.75, 0.75, 1.0, 1.0, 1.0],
        points: (0..=8).map(corner).collect(),
        weights: (0..=8).map(weight).collect(),
    }
}

/// The surface between two circles 10 mm apart, the upper one turned, seen from outside.
fn between([low, high]: [f64; 2], turn_deg: f64) -> RuledSurface {
    let surface = RuledSurface::from_guides(&circle(low, 0.0, 0.0), &circle(high, 10.0, turn_deg), Side::Positive);
    let surface = surface.unwrap();
    let place = surface.at(0.3, 0.5);
    assert!(surface.is_closed() && place.normal.dot(place.point) > 0.0);
    surface
}

fn params() -> FlankParams {
    FlankParams { locations: 80, control_points: 40, grid: [81, 12], below_mm: 0.0, rounds: 0, ..Default::default() }
}

/// A path that goes around once ends where and as it starts, and cuts the seam's places alike from both sides.
fn assert_closed(path: &FlankPath) {
    let [start, end] = [0.0, 1.0].map(|t| path.pose(t));
    close(start.tip, end.tip, 1e-12);
    close(start.axis, end.axis, 1e-12);
    let [before, after] = [1.0 - 1e-9, 1e-9].map(|t| path.axis.at(t));
    let speed = after.tip_speed.length();
    close(before.tip_speed, after.tip_speed, 1e-6 * speed);
    assert!(path.poses.first().unwrap().tip.distance(path.poses.last().unwrap().tip) < 1e-12);
    let [along, across] = path.deviation.grid;
    for j in 0..across {
        for deviation in [&path.deviation, &path.envelope.deviation] {
            let [first, last] = [0, along - 1].map(|i| deviation.at(i, j).unwrap());
            assert!((first - last).abs() < 1e-9, "{first} {last}");
        }
    }
    assert!(path.coverage.is_whole && path.envelope.without == 0, "{:?}", path.coverage);
}

#[test]
fn a_frustum_is_touched_all_along_its_rulings_by_cylinder_and_cone() {
    let surface = between([8.0, 5.0], 0.0);
    // Half the angle of the frustum's tip.
    let (sin, cos) = 0.3f64.atan().sin_cos();
    for (radius, taper_deg) in [(3.0, 0.0), (2.0, 6.0)] {
        let cutter = FlankCutter::cone(radius, taper_deg, 20.0);
        let plan = planned(&surface, &cutter, &params()).unwrap();
        let (lean, rise) = cutter.half_angle().sin_cos();
        for path in [&plan.initial, &plan.chosen] {
            assert_closed(path);
            // The normal is the same all along a ruling, which the flute then touches all along.
            for deviation in [&path.deviation, &path.envelope.deviation] {
                let most = deviation.most_undercut.max(-deviation.most_overcut);
                assert!(most < 5e-4, "{taper_deg}: {most}");
            }
        }
        // What is left is that of the splines through the locations: the locations themselves have none.
        assert!(plan.locations.iter().all(|l| l.middle_mm.is_some_and(|m| m.abs() < 1e-9)));
        let finer = FlankParams { locations: 160, control_points: 80, ..params() };
        let finer = planned(&surface, &cutter, &finer).unwrap().initial.deviation.rms;
        assert!(finer < 0.35 * plan.initial.deviation.rms, "{finer} {}", plan.initial.deviation.rms);
        for (i, location) in plan.locations.iter().enumerate() {
            // In the half-plane of the ruling: along the normal by the radius, and the axis leans off the ruling.
            let normal = [cos, sin];
            let ruling = [-sin, cos];
            let axis = [0, 1].map(|k| ruling[k] * rise + normal[k] * lean);
            let tip = [0, 1].map(|k| [8.0, 0.0][k] + normal[k] * radius / rise - axis[k] * radius * lean / rise);
            let found = [location.tip.truncate().length(), location.tip.z];
            assert!((0..2).all(|k| (found[k] - tip[k]).abs() < 1e-9), "{i}: {found:?} {tip:?}");
        }
        assert_eq!((plan.locations.len(), plan.locations[0].u0, plan.locations[80].u0), (81, 0.0, 1.0));
        close(plan.locations[0].tip, plan.locations[80].tip, 1e-12);
        let task = Task::default();
        let grid = DesignGrid::new(&surface, [40, 5]);
        let own = own_surface(&plan.chosen, &cutter, (&grid, 0.01), &task).unwrap();
        assert!(own.holds(), "{}", own.text());
    }
}

#[test]
fn a_twisted_ring_is_cut_alike_all_around_and_better_when_refined() {
    let surface = between([9.0, 9.0], 50.0);
    let cutter = FlankCutter::cylinder(3.0, 20.0);
    let plan = planned(&surface, &cutter, &FlankParams { rounds: 20, ..params() }).unwrap();
    let [start, best] = [&plan.initial, &plan.refined].map(|path| {
        assert_closed(path);
        &path.deviation
    });
    assert!(start.mean > 1e-3 && best.sum < 0.9 * start.sum, "{} {}", start.sum, best.sum);
    // A quarter further on all is the same again.
    for i in 0..=60 {
        for j in 0..12 {
            let [here, there] = [i, i + 20].map(|i| start.at(i, j).unwrap());
            assert!((here - there).abs() < 1e-8, "{i} {j}: {here} {there}");
        }
    }
}

/// An oval cone: circles stretched along X, which start at `turn_deg`, a quarter turn or none.
fn oval(turn_deg: f64) -> RuledSurface {
    let stretched = |radius: f64, z: f64| match circle(radius, z, turn_deg) {
        GuideCurve::BSpline { degree, knots, points, weights } => {
            let points = points.into_iter().map(|p| DVec3::new(1.5 * p.x, p.y, p.z)).collect();
            GuideCurve::BSpline { degree, knots, points, weights }
        }
        other => other,
    };
    RuledSurface::from_guides(&stretched(12.0, 0.0), &stretched(9.0, 10.0), Side::Positive).unwrap()
}

#[test]
fn sums_around_a_ring_do_not_depend_on_where_its_seam_is() {
    let cutter = FlankCutter::cone(2.0, 4.0, 20.0);
    let [first, second] = [0.0, 90.0].map(|turn| planned(&oval(turn), &cutter, &params()).unwrap());
    for ((name, a), (_, b)) in first.paths().into_iter().zip(second.paths()) {
        assert_closed(a);
        assert_closed(b);
        for [a, b] in [[&a.deviation, &b.deviation], [&a.envelope.deviation, &b.envelope.deviation]] {
            // The seam has another deviation in each: counted twice it would show.
            let [of_a, of_b] = [a, b].map(|d| (0..12).map(|j| d.at(0, j).unwrap().abs()).sum::<f64>());
            assert!((of_a - of_b).abs() > 1e-4 * a.sum, "{name}: {of_a} {of_b}");
            for (x, y) in [(a.sum, b.sum), (a.mean, b.mean), (a.rms, b.rms), (a.sum_overcut, b.sum_overcut)] {
                assert!((x / y - 1.0).abs() < 1e-6, "{name}: {x} {y}");
            }
            assert_eq!((a.counted_grid(), a.counted().len(), a.values.len()), ([80, 12], 960, 972));
            assert!((a.mean * 960.0 / a.sum - 1.0).abs() < 1e-12);
        }
    }
}

#[test]
fn a_ring_is_given_as_many_control_points_as_it_needs() {
    let cutter = FlankCutter::cylinder(3.0, 20.0);
    let usual = FlankParams { rounds: 0, below_mm: 0.0, ..FlankParams::default() };
    let plan = planned(&between([8.0, 5.0], 0.0), &cutter, &usual).unwrap();
    let count = plan.initial.axis.lower().len();
    assert!(count > 10 && count <= 49 && plan.fit_mm <= RING_FIT_MM, "{count} {}", plan.fit_mm);
    let most = plan.initial.deviation.most_undercut.max(-plan.initial.deviation.most_overcut);
    assert!(most < 2.0 * RING_FIT_MM, "{most}: the flute lies along every ruling of a frustum");
    assert!(plan.warnings.iter().all(|w| !w.text.contains("around the ring")), "{:?}", plan.warnings);
    // No more than one for two places around; then it is said how far the path is off.
    let coarse = FlankParams { grid: [25, 6], ..usual.clone() };
    let plan = planned(&between([8.0, 5.0], 0.0), &cutter, &coarse).unwrap();
    assert!(plan.initial.axis.lower().len() == 12 && plan.fit_mm > RING_FIT_MM);
    assert!(plan.warnings.iter().any(|w| w.text.contains("12 control points") && w.text.contains("25 places around")));
    // Those that were asked for are never made fewer, and open guides have what they were given.
    let many = FlankParams { control_points: 40, locations: 80, grid: [41, 6], ..usual };
    assert_eq!(planned(&between([8.0, 5.0], 0.0), &cutter, &many).unwrap().initial.axis.lower().len(), 40);
    let (_, open) = quick("cyl_R2_A");
    assert_eq!(open.initial.axis.lower().len(), 10);
}

/// A circle by points, the last where the first is, at angles that are not spaced evenly.
fn circle_of_points(count: u32, radius: f64, z: f64) -> GuideCurve {
    let at = |i: u32| {
        let share = std::f64::consts::TAU * f64::from(i % count) / f64::from(count);
        let angle = share + 0.3 / f64::from(count) * (3.0 * share).sin();
        DVec3::new(radius * angle.cos(), radius * angle.sin(), z)
    };
    GuideCurve::Points { points: (0..=count).map(at).collect(), degree: 3 }
}

#[test]
fn a_ring_of_points_goes_on_across_its_seam() {
    let cutter = FlankCutter::cylinder(3.0, 20.0);
    let mut off = Vec::new();
    for count in [12, 24, 96] {
        let [lower, upper] = [(8.0, 0.0), (5.0, 10.0)].map(|(radius, z)| circle_of_points(count, radius, z));
        let surface = RuledSurface::from_guides(&lower, &upper, Side::Positive).unwrap();
        assert!(surface.is_closed(), "{count}");
        for curve in [surface.lower(), surface.upper()] {
            let [start, end] = [0.0, 1.0].map(|u| curve.at(u));
            close(start[0], end[0], 1e-12);
            close(start[1], end[1], 1e-9 * start[1].length());
            let bend = (start[2] - end[2]).length() / start[2].length();
            assert!(bend < 0.2, "{count}: {bend}");
            // What it is off the circle at the seam is no more than elsewhere.
            let radius = start[0].truncate().length();
            let most = |from: f64| {
                let places = (0..=50).map(|i| from + 0.1 * (f64::from(i) / 50.0 - 0.5)).map(|u| u - u.floor());
                places.map(|u| (curve.point(u).truncate().length() - radius).abs()).fold(0.0, f64::max)
            };
            assert!(most(0.0) < 3.0 * most(0.5), "{count}: {} {}", most(0.0), most(0.5));
        }
        let usual = FlankParams { rounds: 0, below_mm: 0.0, ..FlankParams::default() };
        let plan = planned(&surface, &cutter, &usual).unwrap();
        assert!(plan.locations.iter().all(|l| l.touch == Touch::ThreePoints), "{count}");
        off.push(plan.fit_mm);
    }
    assert!(off[1] <= RING_FIT_MM && off[2] <= RING_FIT_MM, "{off:?}");
}

#[test]
fn points_that_meet_at_a_corner_are_no_ring() {
    let side = |i: i32| f64::from(i) / 5.0;
    let around = (0..5).map(|i| [side(i), 0.0]).chain((0..5).map(|i| [1.0, side(i)]));
    let around = around.chain((0..5).map(|i| [1.0 - side(i), 1.0])).chain((0..=5).map(|i| [0.0, 1.0 - side(i)]));
    let points = around.map(|[x, y]: [f64; 2]| DVec3::new(x, y, 0.0)).collect();
    let square = GuideCurve::Points { points, degree: 3 }.curve().unwrap();
    let turn = square.tangent(0.0).angle_between(square.tangent(1.0));
    assert!((turn - std::f64::consts::FRAC_PI_2).abs() < 0.2, "{turn}");
}

#[test]
fn closed_splines_sum_to_one_and_wrap_around() {
    for count in [4, 5, 10, 23] {
        let basis = CubicBasis::closed(count);
        assert_eq!(basis.count(), count);
        for i in -30..=130 {
            let t = f64::from(i) / 100.0;
            let (here, next) = (basis.at(t), basis.at(t + 1.0));
            assert!((here.values.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            let value = |at: &crate::axis_surface::BasisAt, k: usize| {
                at.numbers.iter().zip(at.values).filter(|n| *n.0 == k).map(|n| n.1).sum::<f64>()
            };
            assert!((0..count).all(|k| (value(&here, k) - value(&next, k)).abs() < 1e-9), "{count} {t}");
        }
    }
}

#[test]
fn guides_that_meet_their_start_at_a_corner_are_not_closed() {
    let square = |half: f64, z: f64| {
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]];
        let points = corners.map(|[x, y]| DVec3::new(half * x, half * y, z)).to_vec();
        GuideCurve::Points { points, degree: 1 }
    };
    let surface = RuledSurface::from_guides(&square(5.0, 0.0), &square(4.0, 10.0), Side::Positive);
    assert!(!surface.unwrap().is_closed());
}
