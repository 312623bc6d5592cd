//! Kinematics, choice of positions, linearisation and feed of milling machines.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;
use proptest::prelude::*;

use super::joint_path::MillingError;
use super::kinematics::{Joints, Kinematics, ToolPose};
use super::linearise::{Interpolation, LinearisationParams, MachinePath, linearise, on_the_way};
use super::milling_machine::{CarriedBy, MachineError, MillingMachine};
use super::tool_path::{Section, StraightMoves, ToolPath, ToolPathError};
use task::Cancel;

mod feed;
mod pole;

/// The machines with heads that tilt both ways.
fn machines_with_free_heads() -> Vec<MillingMachine> {
    let mut machines = machines();
    for rotary in machines.iter_mut().flat_map(|m| &mut m.rotary).filter(|r| r.carried_by == CarriedBy::Head) {
        rotary.limits_deg = Some([-200.0, 200.0]);
    }
    machines
}

pub(crate) fn machines() -> Vec<MillingMachine> {
    #[derive(serde::Deserialize)]
    struct Library {
        machine: Vec<MillingMachine>,
    }
    toml::from_str::<Library>(include_str!("../../../../../assets/milling_machines.toml")).unwrap().machine
}

fn trunnion() -> MillingMachine {
    machines().remove(0)
}

fn unit(v: [f64; 3]) -> DVec3 {
    DVec3::from_array(v).try_normalize().unwrap_or(DVec3::Z)
}

/// A machine with skew axes, points and mount, of any kind.
fn skew(kind: usize, v: [f64; 12]) -> MillingMachine {
    let mut machine = machines().remove(kind);
    let shaken = |d: DVec3, by: &[f64]| d + 0.3 * DVec3::new(by[0], by[1], by[2]);
    for (axis, by) in machine.rotary.iter_mut().zip(v.chunks(3)) {
        axis.direction = shaken(axis.direction, by);
        axis.point_mm += 100.0 * DVec3::new(by[1], by[2], by[0]);
    }
    machine.spindle = shaken(machine.spindle, &v[6..9]);
    machine.workpiece.x_axis = unit([v[9], 0.3, v[10]]);
    machine.workpiece.z_axis = shaken(machine.workpiece.z_axis, &v[8..11]);
    machine.workpiece.zero_mm = DVec3::new(30.0 * v[11], 5.0, -12.0);
    machine
}

#[test]
fn hand_computed_positions_of_the_three_kinds() {
    let [table, head, mixed] = &machines()[..] else { panic!() };
    let near = |a: DVec3, b: [f64; 3]| assert!(a.distance(DVec3::from(b)) < 1e-12, "{a} {b:?}");
    // The cradle turned by 90 degrees: A counts as the tool moves, so the tool comes to lie along -Y of the workpiece.
    let k = table.kinematics().unwrap();
    let at = k.forward(&Joints { linear: DVec3::ZERO, rotary: [FRAC_PI_2, 0.0] });
    near(at.axis, [0.0, -1.0, 0.0]);
    // The tip is 30 mm above A, which lies 30 mm below the workpiece's zero: in the turned workpiece it is at y = -30
    // from A and level with it.
    near(at.tip, [0.0, -30.0, -30.0]);
    near(k.forward(&Joints { linear: DVec3::new(1.0, 2.0, 3.0), rotary: [0.0; 2] }).tip, [1.0, 2.0, 3.0]);
    near(k.slides(&Joints { linear: DVec3::ZERO, rotary: [0.0; 2] }), [0.0, 0.0, 150.0]);
    // The spindle tilted by 90 degrees: the tip, 330 mm below the pivot, comes to -X of it and level with it.
    let k = head.kinematics().unwrap();
    let at = k.forward(&Joints { linear: DVec3::ZERO, rotary: [0.0, FRAC_PI_2] });
    near(at.axis, [1.0, 0.0, 0.0]);
    near(at.tip, [-330.0, 0.0, 330.0]);
    let at = k.forward(&Joints { linear: DVec3::ZERO, rotary: [FRAC_PI_2, FRAC_PI_2] });
    near(at.axis, [0.0, 1.0, 0.0]);
    near(at.tip, [0.0, -330.0, 330.0]);
    // The spindle at 90 degrees and the table at 90: the tool moves about Z as C counts.
    let k = mixed.kinematics().unwrap();
    let at = k.forward(&Joints { linear: DVec3::ZERO, rotary: [FRAC_PI_2, FRAC_PI_2] });
    near(at.axis, [0.0, 1.0, 0.0]);
    near(at.tip, [0.0, -290.0, 290.0]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]
    #[test]
    fn both_solutions_of_every_direction_give_it_back(
        kind in 0..3usize, d in prop::array::uniform3(-1.0..1.0f64), tip in prop::array::uniform3(-200.0..200.0f64),
    ) {
        let k = machines()[kind].kinematics().unwrap();
        let (axis, tip) = (unit(d), DVec3::from(tip));
        for rotary in k.inverse(axis).unwrap() {
            let back = k.forward(&k.with_tip(tip, rotary));
            prop_assert!(back.axis.distance(axis) < 1e-12 && k.direction(&rotary).distance(axis) < 1e-12);
            prop_assert!(back.tip.distance(tip) < 1e-11);
        }
    }

    #[test]
    fn skew_machines_too_and_what_they_can_do_is_found(
        kind in 0..3usize, v in prop::array::uniform12(-1.0..1.0f64), rotary in prop::array::uniform2(-PI..PI),
        linear in prop::array::uniform3(-200.0..200.0f64),
    ) {
        let k = skew(kind, v).kinematics().unwrap();
        let pose = k.forward(&Joints { linear: DVec3::from(linear), rotary });
        let solutions = k.inverse(pose.axis).unwrap();
        for rotary in solutions {
            let back = k.forward(&k.with_tip(pose.tip, rotary));
            prop_assert!(back.axis.distance(pose.axis) < 1e-12, "{}", back.axis.distance(pose.axis));
            prop_assert!(back.tip.distance(pose.tip) < 1e-10);
        }
        // One of the two is where it came from.
        let apart = |a: f64, b: f64| (a - b).sin().hypot(1.0 - (a - b).cos());
        let nearest = solutions.iter().map(|s| apart(s[0], rotary[0]).max(apart(s[1], rotary[1])));
        prop_assert!(k.off_pole(pose.axis) < 1e-3 || nearest.fold(f64::MAX, f64::min) < 1e-6);
    }

    #[test]
    fn near_the_pole_no_digit_is_lost(kind in 0..3usize, exponent in -14.0..-1.0f64, turn in -PI..PI) {
        let k = machines()[kind].kinematics().unwrap();
        let off = 10f64.powf(exponent);
        let axis = DVec3::new(off.sin() * turn.cos(), off.sin() * turn.sin(), off.cos()).normalize();
        for rotary in k.inverse(axis).unwrap() {
            prop_assert!(k.direction(&rotary).distance(axis) < 1e-12);
            prop_assert!((rotary[k.tilt_axis()].abs() - off).abs() < 1e-14 + 1e-12 * off);
        }
    }

    #[test]
    fn no_motion_bends_more_than_its_bound(
        kind in 0..3usize, v in prop::array::uniform12(-1.0..1.0f64), r in prop::array::uniform4(-1.0..1.0f64),
        linear in prop::array::uniform6(-100.0..100.0f64), height in 0.0..50.0f64,
    ) {
        let k = skew(kind, v).kinematics().unwrap();
        let [x, y, z, dx, dy, dz] = linear;
        let from = Joints { linear: DVec3::new(x, y, z), rotary: [r[0], r[1]] };
        let to = Joints { linear: DVec3::new(x + dx, y + dy, z + dz), rotary: [r[0] + r[2], r[1] + r[3]] };
        let at = |t: f64| k.forward(&from.lerp(&to, t)).at_height(height);
        let bend = |t: f64| ((at(t - 1e-3) - at(t) * 2.0 + at(t + 1e-3)) * 1e6).length();
        let most = (1..20).map(|i| bend(f64::from(i) / 20.0)).fold(0.0, f64::max);
        prop_assert!(most <= k.bend(&from, &to, height) + 1e-3, "{most} {}", k.bend(&from, &to, height));
    }
}

#[test]
fn a_direction_out_of_reach_is_said_with_how_far() {
    // A nutating head: its tilting axis stands at 45 degrees to the spindle, so the tool reaches 90 degrees of tilt.
    let mut machine = machines().remove(1);
    machine.rotary[1].direction = DVec3::new(0.0, 1.0, 1.0);
    let k = machine.kinematics().unwrap();
    let tilted = |deg: f64| DVec3::new(deg.to_radians().sin(), 0.0, deg.to_radians().cos());
    for rotary in k.inverse(tilted(89.9)).unwrap() {
        assert!(k.direction(&rotary).distance(tilted(89.9)) < 1e-12);
    }
    let Err(MachineError::Unreachable { by_deg, .. }) = k.inverse(tilted(97.0)) else { panic!() };
    assert!((by_deg - 7.0).abs() < 1e-9);
    let path = ToolPath::new(|u| (DVec3::X * u, tilted(80.0 + 20.0 * u)), &[0.0, 0.3, 1.0]).unwrap();
    let said = linearise(&k, &path, &LinearisationParams::default(), &Cancel::default()).unwrap_err().to_string();
    assert!(said.contains("cut point 3 (u = 1.00000)") && said.contains("10.000 degrees beyond"), "{said}");
}

/// A flank that bends and twists.
fn bent(u: f64) -> (DVec3, DVec3) {
    let tip = DVec3::new(60.0 * u - 30.0, 12.0 * (2.0 * u).sin(), 3.0 * u * u);
    (tip, DVec3::new(0.2 + 0.3 * u, 0.25 * (3.0 * u).cos(), 1.0))
}

fn points(n: usize) -> Vec<f64> {
    (0..n).map(|i| i as f64 / (n - 1) as f64).collect()
}

/// The greatest way off that 200 places of every move have, measured by the definition.
fn densely(k: &Kinematics, path: &ToolPath, line: &MachinePath, params: &LinearisationParams) -> f64 {
    let mut most = 0.0f64;
    for w in line.points.windows(2) {
        for i in 0..=200 {
            let t = f64::from(i) / 200.0;
            let wanted = path.at(w[0].s + (w[1].s - w[0].s) * t).unwrap();
            let moved = on_the_way(k, params.interpolation, &w[0], &w[1], t);
            for h in [0.0, 0.5 * params.reach_mm, params.reach_mm] {
                most = most.max(wanted.at_height(h).distance(moved.at_height(h)));
            }
        }
    }
    most
}

#[test]
fn the_tolerance_holds_everywhere_and_the_points_are_not_wasted() {
    for machine in machines() {
        let k = machine.kinematics().unwrap();
        let path = ToolPath::new(bent, &points(9)).unwrap();
        for interpolation in [Interpolation::Joints, Interpolation::Tip] {
            let count = |tolerance: f64| {
                let params = LinearisationParams { linearisation_mm: tolerance, interpolation, ..Default::default() };
                let line = linearise(&k, &path, &params, &Cancel::default()).unwrap();
                let found = densely(&k, &path, &line, &params);
                assert!(found <= line.deviation_mm && line.deviation_mm <= tolerance, "{found} {}", line.deviation_mm);
                assert!(line.measured_mm <= line.deviation_mm && found > 0.2 * tolerance);
                assert!(line.points.windows(2).all(|w| w[0].s < w[1].s));
                line.points.len() as f64
            };
            // The way off goes with the square of the step: a hundredth of it needs ten times the points.
            let ratio = count(2e-4) / count(2e-2);
            assert!((4.0..20.0).contains(&ratio), "{ratio}");
        }
    }
}

#[test]
fn the_shorter_way_within_the_limits_is_taken() {
    // The direction goes round by 300 degrees from +X, which C reaches at 90 or at -90 degrees: within 220 degrees each
    // way only the start at -90 leaves room.
    let mut machine = trunnion();
    machine.rotary[1].limits_deg = Some([-220.0, 220.0]);
    let round = |u: f64| {
        let turn = (300.0 * u).to_radians();
        (DVec3::new(40.0 * turn.cos(), 40.0 * turn.sin(), 0.0), DVec3::new(turn.cos(), turn.sin(), 2.0))
    };
    let path = ToolPath::new(round, &points(31)).unwrap();
    let params = LinearisationParams { linearisation_mm: 0.02, ..Default::default() };
    let line = linearise(&machine.kinematics().unwrap(), &path, &params, &Cancel::default()).unwrap();
    let c: Vec<f64> = line.points.iter().map(|p| p.joints.rotary[1].to_degrees()).collect();
    assert!(c.iter().all(|v| v.abs() <= 220.0));
    assert!(((c[c.len() - 1] - c[0]).abs() - 300.0).abs() < 1e-3);
    assert!(c.windows(2).all(|w| (w[1] - w[0]).abs() < 15.0));
    // And within 140 degrees each way nothing fits: the best start ends at 210.
    machine.rotary[1].limits_deg = Some([-140.0, 140.0]);
    let error = linearise(&machine.kinematics().unwrap(), &path, &params, &Cancel::default()).unwrap_err();
    let MillingError::OutsideLimits { axis: 'C', by, unit: "degrees", .. } = error else { panic!("{error}") };
    assert!((by - 70.0).abs() < 1e-9, "{by}");
}

#[test]
fn limits_of_straight_and_tilting_axes_are_said_with_the_place() {
    let mut machine = trunnion();
    machine.linear.x_mm = [-400.0, 20.0];
    machine.rotary[1].limits_deg = Some([-10.0, 10.0]);
    let path = ToolPath::new(|u| (DVec3::new(50.0 * u, 0.0, 0.0), DVec3::Z), &points(6)).unwrap();
    let error = linearise(&machine.kinematics().unwrap(), &path, &LinearisationParams::default(), &Cancel::default())
        .unwrap_err();
    // 50 mm times the cosine of 10 degrees: the table turns as far as it can to help.
    assert!(matches!(error, MillingError::OutsideLimits { axis: 'X', .. }), "{error}");
    let said = error.to_string();
    assert!(said.contains("cut point 6") && said.contains("49.240 mm, 29.240 mm outside"), "{said}");
    // A table that turns further lets the same cut go along -X or Y.
    machine.rotary[1].limits_deg = None;
    assert!(
        linearise(&machine.kinematics().unwrap(), &path, &LinearisationParams::default(), &Cancel::default()).is_ok()
    );
    let mut machine = trunnion();
    machine.rotary[0].limits_deg = Some([-15.0, 15.0]);
    let path = ToolPath::new(|u| (DVec3::X * u, DVec3::new(u, 0.0, 1.0)), &points(6)).unwrap();
    let error = linearise(&machine.kinematics().unwrap(), &path, &LinearisationParams::default(), &Cancel::default())
        .unwrap_err();
    let MillingError::OutsideLimits { axis: 'A', by, at, .. } = error else { panic!("{error}") };
    assert!((by - 30.0).abs() < 1e-6 && at.point == 6);
}

fn passing(off_deg: f64) -> impl Fn(f64) -> (DVec3, DVec3) + Sync {
    move |u| (DVec3::new(80.0 * u - 40.0, 5.0, 0.0), DVec3::new(0.3 * (2.0 * u - 1.0), off_deg.to_radians().tan(), 1.0))
}

#[test]
fn following_a_path_can_be_stopped() {
    let cancel = Cancel::default();
    cancel.cancel();
    let path = ToolPath::new(passing(0.5), &points(21)).unwrap();
    let answer = linearise(&machines()[0].kinematics().unwrap(), &path, &LinearisationParams::default(), &cancel);
    assert!(matches!(answer, Err(MillingError::Cancelled(_))));
    // In the middle, too: the path itself raises the flag.
    let cancel = Cancel::default();
    let looks = std::sync::atomic::AtomicUsize::new(0);
    let stopping = |u: f64| {
        if looks.fetch_add(1, std::sync::atomic::Ordering::Relaxed) > 3000 {
            cancel.cancel();
        }
        passing(0.5)(u)
    };
    let path = ToolPath::new(stopping, &points(21)).unwrap();
    let params = LinearisationParams { linearisation_mm: 1e-4, ..LinearisationParams::default() };
    let answer = linearise(&machines()[0].kinematics().unwrap(), &path, &params, &cancel);
    assert!(matches!(answer, Err(MillingError::Cancelled(_))));
}

#[test]
fn leads_belong_to_the_path_and_are_named() {
    let lead = |z: f64, x: f64| ToolPose { tip: DVec3::new(x, 0.0, z), axis: DVec3::new(0.2, 0.25, 1.0) * 3.0 };
    let (approach, retract) = ([lead(80.0, -40.0), lead(20.0, -40.0)], [lead(60.0, 40.0)]);
    let path = ToolPath::with_leads(bent, &points(4), &approach, &retract).unwrap();
    assert_eq!(path.last(), 6);
    assert_eq!(
        (path.section(1.5), path.section(2.0), path.section(5.0)),
        (Section::Approach, Section::Cut, Section::Cut)
    );
    assert_eq!(path.section(5.5), Section::Retract);
    for (s, at) in [(0.0, approach[0].tip), (2.0, bent(0.0).0), (5.0, bent(1.0).0), (6.0, retract[0].tip)] {
        assert!(path.at(s).unwrap().tip.distance(at) < 1e-12);
        assert!((path.at(s).unwrap().axis.length() - 1.0).abs() < 1e-12);
    }
    assert!(path.at(5.5).unwrap().tip.distance(bent(1.0).0.lerp(retract[0].tip, 0.5)) < 1e-12);
    assert_eq!(path.place(0.0).to_string(), "approach point 1");
    assert_eq!(path.place(3.5).to_string(), "cut point 2 + 0.500 (u = 0.50000)");
    assert_eq!(path.place(6.0).to_string(), "retract point 1");
    let params = LinearisationParams::default();
    let k = trunnion().kinematics().unwrap();
    let line = linearise(&k, &path, &params, &Cancel::default()).unwrap();
    assert!(densely(&k, &path, &line, &params) <= params.linearisation_mm);
    let StraightMoves { moves, chordal_deviation_mm } = path.straightened(0.001, 20.0).unwrap();
    assert!(moves.len() > 7 && moves.windows(2).all(|w| w[0].0 < w[1].0));
    let off = |(s, pose): &(f64, ToolPose)| path.at(*s).unwrap().tip.distance(pose.tip);
    assert!(moves.iter().all(|m| off(m) == 0.0));
    // What is said to be the furthest is that of dense sampling, and no more than was allowed.
    let dense = moves.windows(2).flat_map(|w| (0..=64).map(move |i| (w[0], w[1], f64::from(i) / 64.0)));
    let by = dense.map(|((from, start), (to, end), share)| {
        let (wanted, axis) =
            (path.at(from + (to - from) * share).unwrap(), start.axis.lerp(end.axis, share).normalize());
        let straight = ToolPose { tip: start.tip.lerp(end.tip, share), axis };
        [0.0, 20.0].map(|h| wanted.at_height(h).distance(straight.at_height(h))).into_iter().fold(0.0, f64::max)
    });
    let furthest = by.fold(0.0, f64::max);
    assert!(
        chordal_deviation_mm <= 0.001
            && chordal_deviation_mm > 2e-4
            && (furthest / chordal_deviation_mm - 1.0).abs() < 0.05,
        "{furthest} {chordal_deviation_mm}"
    );
}

#[test]
fn what_is_no_path_or_no_setting_is_said() {
    let none = |points: &[f64]| ToolPath::new(bent, points).err().unwrap();
    assert_eq!(none(&[0.0]), ToolPathError::Points { found: 1 });
    assert!(matches!(none(&[0.0, 0.5, 0.5]), ToolPathError::NotRising { point: 2, .. }));
    assert!(matches!(none(&[0.0, f64::NAN]), ToolPathError::NotRising { .. }));
    let error = ToolPath::new(|u| (DVec3::ZERO, DVec3::Z * (1.0 - u)), &points(3)).err().unwrap();
    assert!(error.to_string().contains("cut point 3"), "{error}");
    let over = ToolPose { tip: DVec3::ZERO, axis: DVec3::NEG_Z };
    let error = ToolPath::with_leads(|_| (DVec3::ZERO, DVec3::Z), &points(2), &[over], &[]).err().unwrap();
    assert!(error.to_string().contains("approach point 1"), "{error}");
    let k = trunnion().kinematics().unwrap();
    let path = ToolPath::new(bent, &points(4)).unwrap();
    for (params, name) in [
        (LinearisationParams { linearisation_mm: 0.0, ..Default::default() }, "linearisation_mm"),
        (LinearisationParams { reach_mm: f64::NAN, ..Default::default() }, "reach_mm"),
    ] {
        assert!(linearise(&k, &path, &params, &Cancel::default()).unwrap_err().to_string().contains(name));
    }
    // A step in the path itself cannot be followed.
    let step = |u: f64| (DVec3::new(u, if u < 0.4 { 0.0 } else { 1.0 }, 0.0), DVec3::new(0.1, 0.2, 1.0));
    let path = ToolPath::new(step, &points(2)).unwrap();
    let error = linearise(&k, &path, &LinearisationParams::default(), &Cancel::default()).unwrap_err();
    assert!(matches!(error, MillingError::ChordalDeviation { .. }), "{error}");
    let error = path.straightened(0.001, 20.0).unwrap_err();
    assert!(
        matches!(error, ToolPathError::Jumps { .. }) && error.to_string().contains("cut point 1 + 0.400"),
        "{error}"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]
    #[test]
    fn any_smooth_path_is_followed_within_the_tolerance_or_refused_for_a_reason(
        kind in 0..3usize, v in prop::array::uniform12(-1.0..1.0f64), c in prop::array::uniform12(-1.0..1.0f64),
        n in 2..12usize, tolerance in -3.0..-1.5f64,
    ) {
        let mut machine = skew(kind, v);
        machine.rotary.iter_mut().for_each(|r| r.limits_deg = None);
        let k = machine.kinematics().unwrap();
        let wave = |u: f64, i: usize| c[i] + c[i + 3] * (2.0 * u).sin();
        let path = |u: f64| {
            let tip = DVec3::new(50.0 * u + 20.0 * wave(u, 0), 20.0 * wave(u, 1), 10.0 * wave(u, 2));
            (tip, DVec3::new(wave(u, 6), wave(u, 7), 1.5 + 0.3 * wave(u, 8)))
        };
        let path = ToolPath::new(path, &points(n)).unwrap();
        let params = LinearisationParams { linearisation_mm: 10f64.powf(tolerance), ..Default::default() };
        match linearise(&k, &path, &params, &Cancel::default()) {
            Ok(line) => prop_assert!(densely(&k, &path, &line, &params) <= params.linearisation_mm),
            Err(MillingError::Unreachable { .. } | MillingError::OutsideLimits { .. }) => {}
            Err(error) => prop_assert!(false, "{error}"),
        }
    }
}
