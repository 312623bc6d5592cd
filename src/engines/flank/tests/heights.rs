//! The cutter's height along its axis, which no deviation holds.

use nalgebra::DVector;

use super::*;
use crate::heights::Heights;
use crate::path::FlankPath;

/// A surface between two rows of `count` points at shares from 0 to 1, with coordinates rounded to multiples of `digit`
/// (mm).
fn wall((count, digit): (u32, f64), [lower, upper]: [&dyn Fn(f64) -> DVec3; 2]) -> RuledSurface {
    let guide = |of: &dyn Fn(f64) -> DVec3| {
        let points = (0..count).map(|i| of(f64::from(i) / f64::from(count - 1)));
        GuideCurve::Points { points: points.map(|p| (p / digit).round() * digit).collect(), degree: 3 }
    };
    RuledSurface::from_guides(&guide(lower), &guide(upper), Side::Positive).unwrap()
}

/// A leaning plane of 60 by 20 mm.
fn plane(rounded: (u32, f64)) -> RuledSurface {
    let ((sin_a, cos_a), (sin_b, cos_b)) = (0.37f64.sin_cos(), 0.21f64.sin_cos());
    let (along, up) = (DVec3::new(cos_a, sin_a, 0.0), DVec3::new(-sin_a * sin_b, cos_a * sin_b, cos_b));
    let at = |t: f64, v: f64| DVec3::splat(7.123) + 60.0 * t * along + 20.0 * v * up;
    wall(rounded, [&|t| at(t, 0.0), &|t| at(t, 1.0)])
}

/// A twisted wall in the form of an S, 300 mm long.
fn twisted() -> RuledSurface {
    let at = |t: f64, v: f64| DVec3::new((300.0 + 2.0 * v) * t, 5.0 * (6.0 * t + 0.3 * v).sin(), 20.0 * v);
    wall((60, 1e-6), [&|t| at(t, 0.0), &|t| at(t, 1.0)])
}

/// A quarter of a cone that is narrower above.
fn tapered(rounded: (u32, f64)) -> RuledSurface {
    let at = |t: f64, v: f64| {
        let (sin, cos) = (std::f64::consts::FRAC_PI_2 * t).sin_cos();
        DVec3::new((50.0 - 2.0 * v) * cos, (50.0 - 2.0 * v) * sin, 3.3 + 20.0 * v)
    };
    wall(rounded, [&|t| at(t, 0.0), &|t| at(t, 1.0)])
}

/// Least and greatest height (mm) that the cutter's bottom is deeper than was asked, over the lower guide.
fn deeper(plan: &FlankPlan, path: &FlankPath) -> [f64; 2] {
    let cutter = plan.cutter.above(plan.params.below_mm).unwrap();
    let rim = cutter.radius_mm * cutter.half_angle().tan();
    let heights = path.feet.at.iter().step_by(plan.params.grid[1]).map(|q| q.y * path.axis.at(q.x).length() - rim);
    heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], h| [low.min(h), high.max(h)])
}

/// Asserts that all paths of a plan keep the height that was asked to 0.05 mm above and 0.1 mm below.
fn keeps_height(what: &str, surface: &RuledSurface, cutter: &FlankCutter, params: &FlankParams) -> FlankPlan {
    let plan = planned(surface, cutter, params).unwrap();
    for (name, path) in plan.paths() {
        let [low, high] = deeper(&plan, path);
        assert!(low > -0.05 && high < 0.1, "{what}, {name}: {low} {high}");
        assert!(path.coverage.is_whole && path.coverage.height_range_mm[0] > 0.0, "{what}, {name} {:?}", path.coverage);
    }
    plan
}

#[test]
fn planes_written_with_three_decimals_keep_height_and_axis() {
    let short = FlankCutter::cylinder(3.0, 40.0);
    let long = (FlankCutter::cylinder(3.0, 150.0), FlankParams { below_mm: 60.0, ..FlankParams::default() });
    for count in [12, 30] {
        let surface = plane((count, 1e-3));
        for (cutter, params) in [(&short, &FlankParams::default()), (&long.0, &long.1)] {
            let what = format!("{count} points, {} mm", cutter.length_mm);
            let plan = keeps_height(&what, &surface, cutter, params);
            for (name, path) in plan.paths() {
                let first = path.poses[0].axis;
                let tilt = path.poses.iter().map(|p| p.axis.angle_between(first)).fold(0.0, f64::max).to_degrees();
                assert!(tilt < 0.1, "{what}, {name}: tilts by {tilt} deg");
            }
        }
    }
}

#[test]
fn rougher_planes_and_tapered_walls_keep_height() {
    for taper_deg in [0.0, 5.0] {
        let cutter = FlankCutter::cone(3.0, taper_deg, 40.0);
        let params = FlankParams::default();
        keeps_height("plane with two decimals", &plane((30, 1e-2)), &cutter, &params);
        for digit in [1e-3, 1e-4] {
            keeps_height(&format!("tapered wall, {digit}"), &tapered((30, digit)), &cutter, &params);
        }
    }
}

#[test]
fn a_twisted_wall_keeps_height_and_is_made_better_all_the_same() {
    let surface = twisted();
    for (taper_deg, control_points) in [(0.0, 10), (0.0, 20), (5.0, 10)] {
        let cutter = FlankCutter::cone(3.0, taper_deg, 40.0);
        let params = FlankParams { control_points, ..FlankParams::default() };
        let what = format!("{taper_deg} deg, {control_points} points");
        let plan = keeps_height(&what, &surface, &cutter, &params);
        assert!(plan.ratio(&plan.refined) < 0.1, "{what}: {}", plan.ratio(&plan.refined));
    }
}

#[test]
fn a_cylinder_that_climbed_is_put_back_and_sweeps_the_same() {
    let (surface, cutter, _) = case(&reference(), "cyl_R2_B");
    let params = FlankParams { grid: [60, 20], rounds: 0, ..FlankParams::default() };
    let grid = DesignGrid::new(&surface, params.grid);
    let axis = planned(&surface, &cutter, &params).unwrap().initial.axis;
    let start = Measured::new(&grid, axis.clone(), &cutter, None).unwrap();
    let heights = Heights::of(&start, &cutter);
    // Up by some 3 mm, and more towards the end of the path.
    let n = axis.lower().len();
    let up = |i: usize| (3.0 + 0.2 * (i % n) as f64) * axis.at((i % n) as f64 / (n - 1) as f64).axis();
    let climbed = axis.moved(&DVector::from_fn(6 * n, |k, _| up(k / 3)[k % 3])).unwrap();
    let climbed = Measured::new(&grid, climbed, &cutter, None).unwrap();
    assert!(heights.beyond(&climbed) > 2.0 && !heights.keeps_as(&climbed, &start));
    let sum = climbed.deviation.sum;
    let back = heights.kept(&grid, climbed.clone(), &start, &cutter).unwrap();
    assert!(heights.beyond(&back) <= Heights::BEYOND_MM, "{}", heights.beyond(&back));
    assert!((back.deviation.sum / sum - 1.0).abs() < 0.05, "{} {sum}", back.deviation.sum);
    // A cone's radius is another one at another height: its path is not touched.
    let cone = FlankCutter::cone(2.0, 3.0, 40.0);
    assert!(heights.kept(&grid, climbed, &start, &cone).is_none());
}
