//! Surfaces that the cutter touches everywhere from the start: nothing is to be made better.

use super::*;
use crate::machine::linearise::{LinearisationParams, linearise};
use crate::machine::tests::machines;
use crate::machine::tool_path::ToolPath;
use crate::path::FlankPath;

/// An upright rectangle, its guides of `count` points each, turned about Z and shifted, with coordinates rounded to
/// multiples of `digit` (mm) if that is not 0.
fn rectangle([length, height]: [f64; 2], turn_deg: f64, (count, digit): (u32, f64)) -> RuledSurface {
    let turn = glam::DMat3::from_rotation_z(turn_deg.to_radians());
    let guide = |z: f64| {
        let share = |i: u32| f64::from(i) / f64::from(count - 1);
        let points = (0..count).map(|i| turn * DVec3::new(length * share(i), 4.0, z) + DVec3::new(7.0, -3.0, 0.0));
        let rounded = points.map(|p| if digit > 0.0 { (p / digit).round() * digit } else { p });
        GuideCurve::Points { points: rounded.collect(), degree: 3 }
    };
    RuledSurface::from_guides(&guide(0.0), &guide(height), Side::Positive).unwrap()
}

/// Greatest differences of axis and of the tip's height among the poses of a path.
fn wander(path: &FlankPath) -> [f64; 2] {
    let first = path.poses[0];
    let of = |f: &dyn Fn(&crate::path::FlankPose) -> f64| path.poses.iter().map(f).fold(0.0, f64::max);
    [of(&|p| (p.axis - first.axis).length()), of(&|p| (p.tip.z - first.tip.z).abs())]
}

#[test]
fn a_plane_keeps_axis_and_height() {
    let cutters =
        [FlankCutter::cylinder(3.0, 40.0), FlankCutter::cylinder(5.0, 40.0), FlankCutter::cone(2.0, 5.0, 40.0)];
    for (size, turn_deg, count) in [([30.0, 12.0], 0.0, 2), ([30.0, 12.0], 37.0, 2), ([10.0, 12.0], 123.0, 5)] {
        let surface = rectangle(size, turn_deg, (count, 0.0));
        for cutter in &cutters {
            let plan = planned(&surface, cutter, &FlankParams::default()).unwrap();
            for (name, path) in plan.paths() {
                let [axis, height] = wander(path);
                let what =
                    format!("{name} over {size:?} by {turn_deg} deg, R {}: {axis:e} {height:e}", cutter.radius_mm);
                assert!(axis < 1e-9 && height < 1e-9, "{what}");
                assert!(path.coverage.is_whole && path.coverage.height_range_mm[0] > 0.0, "{what} {:?}", path.coverage);
            }
            // The flute lies along the plane: the axis leans by the taper, and the bottom is below as asked.
            let (lean, pose) = (plan.refined.poses[7].axis.dot(DVec3::Z), plan.refined.poses[7]);
            assert!((lean - cutter.half_angle().cos()).abs() < 1e-9, "{lean}");
            assert!(pose.tip.z < 0.0 && pose.tip.z > -0.5, "{pose:?}");
        }
    }
}

#[test]
fn guides_written_with_four_decimals_do_not_make_the_path_wander() {
    const DIGIT: f64 = 1e-4;
    for (turn_deg, count) in [(37.0, 5), (118.0, 5), (37.0, 30)] {
        let surface = rectangle([30.0, 12.0], turn_deg, (count, DIGIT));
        let plan = planned(&surface, &FlankCutter::cylinder(3.0, 40.0), &FlankParams::default()).unwrap();
        for (name, path) in plan.paths() {
            let [axis, height] = wander(path);
            assert!(
                axis < DIGIT && height < 3.0 * DIGIT,
                "{name} by {turn_deg} deg, {count} points: {axis:e} {height:e}"
            );
        }
    }
}

/// An upright wall of 40 by 15 mm, turned by 20 degrees, whose guides have five points each that are off by up to `off`
/// (mm).
fn upright(off: f64) -> RuledSurface {
    let turn = glam::DMat3::from_rotation_z(20f64.to_radians());
    let guide = |z: f64| {
        let noise = |i: u32, k: f64| off * (917.3 * f64::from(i) + 31.7 * z + 5.1 * k).sin();
        let at = |i: u32| DVec3::new(10.0 * f64::from(i) + noise(i, 0.0), 4.0 + noise(i, 1.0), z + noise(i, 2.0));
        GuideCurve::Points { points: (0..5).map(|i| turn * at(i)).collect(), degree: 3 }
    };
    RuledSurface::from_guides(&guide(0.0), &guide(15.0), Side::Positive).unwrap()
}

#[test]
fn the_machine_turns_no_axis_along_a_wall_that_is_upright_but_for_rounding() {
    let cutter = FlankCutter::cylinder(3.0, 30.0);
    for off in [0.0, 1e-9, 1e-6] {
        let plan = planned(&upright(off), &cutter, &FlankParams::default()).unwrap();
        for (name, path) in plan.paths() {
            let places: Vec<f64> = path.poses.iter().map(|pose| pose.t).collect();
            let at = |t: f64| {
                let pose = path.pose(t);
                (pose.tip, pose.axis)
            };
            let tool_path = ToolPath::new(at, &places).unwrap();
            let params = LinearisationParams { reach_mm: cutter.length_mm, ..LinearisationParams::default() };
            for machine in machines() {
                let k = machine.kinematics().unwrap();
                let line = linearise(&k, &tool_path, &params, &Cancel::default()).unwrap();
                let by = |i: usize| {
                    let values = || line.points.iter().map(|p| p.joints.rotary[i]);
                    values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
                };
                let turned = [by(0), by(1)];
                assert!(turned.iter().all(|t| *t < 1e-6), "{name} {off:e} {}: {turned:?}", machine.name);
                assert_eq!(line.points.len(), places.len(), "{name} {off:e} {}", machine.name);
            }
        }
    }
}
