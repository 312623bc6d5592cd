//! Effect of the tool on the design surface from elsewhere on the path.

use super::*;
use crate::frustum_distance::Frustum;
use crate::gouge::ToolPart;
use crate::own_leads::own_gouge_of_moves;
use crate::own_surface::{EXACT, OwnSurfaceCheck, moving, own_surface};
use crate::path::FlankPath;

/// The wall over a line in the plane, 10 mm high.
fn upright(points: &[[f64; 2]], degree: usize, side: Side) -> RuledSurface {
    let guide =
        |z: f64| GuideCurve::Points { points: points.iter().map(|p| DVec3::new(p[0], p[1], z)).collect(), degree };
    RuledSurface::from_guides(&guide(0.0), &guide(10.0), side).unwrap()
}

/// A round pocket of radius 8 with a mouth of 8 between lips of radius 2 that bulge out.
fn omega() -> RuledSurface {
    let mut points = Vec::new();
    let mut arc = |[x, y]: [f64; 2], r: f64, [from, to]: [f64; 2], n: u32| {
        points.extend((0..n).map(|i| from + (to - from) * f64::from(i) / f64::from(n)).map(|a| {
            let a = a.to_radians();
            [x + r * a.cos(), y + r * a.sin()]
        }));
    };
    // Lips touch the pocket where both centres are in line: at 3 : 4 : 5.
    let lean = 0.8f64.asin().to_degrees();
    arc([-6.0, 8.0], 2.0, [90.0, -lean], 16);
    arc([0.0, 0.0], 8.0, [180.0 - lean, 360.0 + lean], 60);
    arc([6.0, 8.0], 2.0, [180.0 + lean, 90.0], 16);
    let flat = (0..8).map(f64::from);
    let left = flat.clone().map(|i| [-14.0 + i, 10.0]);
    let right = flat.map(|i| [6.0 + i, 10.0]);
    let all: Vec<[f64; 2]> = left.chain(points).chain(right).collect();
    upright(&all, 3, Side::Negative)
}

fn checked(path: &FlankPath, cutter: &FlankCutter, surface: &RuledSurface, size: [usize; 2]) -> OwnSurfaceCheck {
    let grid = DesignGrid::new(surface, size);
    own_surface(path, cutter, (&grid, 0.01), &Task::default()).unwrap()
}

/// The envelope beside a sweep by brute force along the normals, which knows nothing of envelopes.
#[derive(Debug)]
struct Swept {
    /// Greatest difference between both (mm).
    greatest_difference_mm: f64,
    /// Sum of absolute deviations by the envelope and by the sweep (mm), over places that both know.
    sums_mm: [f64; 2],
    /// Places that the cutter stands nowhere over, or whose normals the flutes never reach.
    without: usize,
}

fn swept(path: &FlankPath, cutter: &FlankCutter, surface: &RuledSurface, size: [usize; 2]) -> Swept {
    const SAMPLES: usize = 100;
    let touching = cutter.above(path.below_mm).unwrap();
    let grid = DesignGrid::new(surface, size);
    // Flutes are gone on past both ends, as those of the envelope are.
    let heights = [-path.below_mm - touching.radius_mm, touching.length_mm + touching.radius_at(touching.length_mm)];
    let mut found = Swept { greatest_difference_mm: 0.0, sums_mm: [0.0; 2], without: 0 };
    for (place, moving) in grid.places().zip(moving(&grid, path, &touching)) {
        let swept = swept_above(&path.axis, &touching, (place.point, place.normal), heights, SAMPLES);
        let Some((swept, moving)) = swept.zip(moving) else {
            found.without += 1;
            continue;
        };
        found.sums_mm = [found.sums_mm[0] + moving.abs(), found.sums_mm[1] + swept.abs()];
        found.greatest_difference_mm = found.greatest_difference_mm.max((swept - moving).abs());
    }
    found
}

/// The depth that is found is that of dense sampling along the path.
fn assert_sampled(found: &OwnSurfaceCheck, path: &FlankPath, cutter: &FlankCutter) {
    let worst = found.worst.unwrap();
    let flutes = Frustum { heights: [0.0, cutter.length_mm], radii: [cutter.radius_mm, cutter.radius_mm] };
    let at = |i: u32| flutes.distance(&path.pose(f64::from(i) / 4000.0), worst.point).0;
    let depth = -(0..=4000).map(at).fold(f64::INFINITY, f64::min);
    assert!((depth - worst.depth_mm).abs() < 2.0 * EXACT && worst.part == ToolPart::Cutter, "{depth} {worst:?}");
}

#[test]
fn a_cutter_on_one_lip_of_a_pocket_cuts_the_other() {
    let surface = omega();
    let params =
        FlankParams { locations: 200, control_points: 80, grid: [160, 4], rounds: 0, ..FlankParams::default() };
    let cutter = FlankCutter::cylinder(5.0, 20.0);
    assert!(cutter.fits(&surface, 0.0).is_ok(), "nowhere is it hollow with less than 8 mm");
    let plan = planned(&surface, &cutter, &params).unwrap();
    let found = checked(&plan.chosen, &cutter, &surface, [60, 3]);
    // On one lip the axis is 5 mm from the other lip's centre, whose radius is 2 mm.
    let worst = found.worst.unwrap();
    assert!((worst.excess_mm() - 2.0).abs() < 0.25, "{worst:?}");
    assert!(!found.holds() && found.count >= 6 && found.text().contains("the surface itself"), "{}", found.text());
    assert_sampled(&found, &plan.chosen, &cutter);
    // The sweep along normals sees it as well, and the envelope alone does not.
    let alone = -plan.chosen.envelope.deviation.most_overcut;
    let sweep = swept(&plan.chosen, &cutter, &surface, [60, 3]);
    assert!(alone < 0.25 * worst.depth_mm && sweep.greatest_difference_mm > 1.0, "{alone} {worst:?} {sweep:?}");
    let slim = FlankCutter::cylinder(2.5, 20.0);
    let plan = planned(&surface, &slim, &params).unwrap();
    let found = checked(&plan.chosen, &slim, &surface, [60, 3]);
    assert!(found.holds(), "{}", found.text());
}

#[test]
fn a_hollow_corner_is_cut_from_its_other_leg() {
    let turn = 60f64.to_radians();
    let surface = upright(&[[0.0, 0.0], [20.0, 0.0], [20.0 + 20.0 * turn.cos(), 20.0 * turn.sin()]], 1, Side::Negative);
    let params =
        FlankParams { locations: 100, control_points: 40, grid: [100, 4], rounds: 0, ..FlankParams::default() };
    let cutter = FlankCutter::cylinder(3.0, 20.0);
    let plan = planned(&surface, &cutter, &params).unwrap();
    let found = checked(&plan.chosen, &cutter, &surface, [101, 3]);
    assert!(found.worst.unwrap().excess_mm() > 0.5, "{}", found.text());
    assert_sampled(&found, &plan.chosen, &cutter);
}

#[test]
fn paths_of_the_reference_keep_off_their_own_surface_and_the_holder_does_not() {
    use crate::cutter::HolderPart;
    for name in ["cone_r1_a5_A", "cyl_R2_B"] {
        let (surface, plan) = quick(name);
        let found = checked(&plan.chosen, &plan.cutter, &surface, [24, 9]);
        assert!(found.holds(), "{name}: {}", found.text());
        let sweep = swept(&plan.chosen, &plan.cutter, &surface, [15, 7]);
        assert!(sweep.without == 0 && sweep.greatest_difference_mm < 1e-5, "{name}: {sweep:?}");
        let [by_envelope, by_sweep] = sweep.sums_mm;
        assert!((by_envelope / by_sweep - 1.0).abs() < 1e-4, "{name}: {sweep:?}");
        // Flutes that end within the surface, and above them a collar.
        let holder = vec![HolderPart { length_mm: 5.0, lower_radius_mm: 6.0, upper_radius_mm: 6.0 }];
        let collar = FlankCutter { length_mm: 6.0, holder, ..plan.cutter.clone() };
        let found = checked(&plan.chosen, &collar, &surface, [24, 9]);
        assert!(found.worst.is_some_and(|w| w.part == ToolPart::Holder(0) && w.depth_mm > 1.0), "{}", found.text());
    }
}

#[test]
fn a_cutter_that_leaves_a_hollow_sideways_runs_into_its_other_side() {
    // Along 190 deg of an arc of radius 4 the axis of a cutter of radius 3 runs 1 mm from the arc's centre.
    let arc: Vec<[f64; 2]> = (0..=60)
        .map(|i| f64::from(i) * 190.0 / 60.0)
        .map(f64::to_radians)
        .map(|a| [4.0 * a.cos(), 4.0 * a.sin()])
        .collect();
    let surface = upright(&arc, 3, Side::Negative);
    let cutter = FlankCutter::cylinder(3.0, 20.0);
    let params = FlankParams { grid: [60, 4], rounds: 0, ..FlankParams::default() };
    let path = planned(&surface, &cutter, &params).unwrap().chosen;
    assert!(checked(&path, &cutter, &surface, [60, 3]).holds(), "the path itself is sound");
    let grid = DesignGrid::new(&surface, [200, 3]);
    // What is opposite of both ends, 180 of the 190 deg further on.
    for (t, u, opposite) in [(0.0, 0.0, 180.0 / 190.0), (1.0, 1.0, 10.0 / 190.0)] {
        let (pose, off) = (path.pose(t), surface.normal(u, 0.5));
        let leaving = |aside: f64| {
            let places = [pose.tip, pose.tip + aside * off, pose.tip + aside * off + 30.0 * DVec3::Z];
            let cancel = Cancel::default();
            own_gouge_of_moves((&places, pose.axis), &cutter, (&grid, 0.01), &cancel).unwrap()
        };
        // 3 mm sideways is 2 mm past the centre: 1 mm into the other side.
        let worst = leaving(3.0).unwrap();
        assert!((worst.depth_mm - 1.0).abs() < 0.02 && worst.part == ToolPart::Cutter, "{worst:?}");
        assert!(worst.expected_mm < 0.01 && (worst.u - opposite).abs() < 0.01, "{worst:?}");
        assert_eq!(leaving(1.5), None, "the hollow leaves 2 mm");
    }
}
