//! Paths through the pole of a machine, and close by.

use super::*;
use crate::machine::singular::Passage;

#[test]
fn the_pole_is_passed_and_said() {
    for machine in machines_with_free_heads() {
        let k = machine.kinematics().unwrap();
        let params = LinearisationParams::default();
        for (off_deg, n) in [(0.0, 5), (0.0, 6), (1e-4, 6), (0.05, 6), (0.5, 6), (1.5, 40)] {
            let path = ToolPath::new(passing(off_deg), &points(n)).unwrap();
            let line = linearise(&k, &path, &params, &Cancel::default()).unwrap();
            assert!(densely(&k, &path, &line, &params) <= params.linearisation_mm);
            let [passage] = &line.singular[..] else { panic!("{:?}", line.singular) };
            assert!((passage.least_deg - off_deg).abs() < 1e-3 && (passage.at.u.unwrap() - 0.5).abs() < 1e-4);
            match passage.passage {
                // Straight through: the tilt goes on to the other side and the pole's axis stands.
                Passage::Held => assert!(off_deg < 1e-3),
                // Beside it the tool cannot but follow: half a turn less what lies outside of the cone.
                Passage::Swung { by_deg, over_mm } => {
                    let expected = 180.0 - 2.0 * (off_deg / 5.0).asin().to_degrees();
                    assert!(off_deg > 1e-3 && (by_deg - expected).abs() < 12.0, "{by_deg} {expected}");
                    assert!(over_mm < 80.0);
                }
                Passage::TurnedInPlace { .. } => panic!("{passage}"),
            }
            assert!(passage.to_string().contains("singular"));
        }
    }
}

#[test]
fn a_corner_at_the_pole_is_turned_in_place() {
    // The tool leans in X, stands up, and leans in Y.
    let lean = |u: f64| {
        (
            DVec3::new(30.0, 10.0 * u, 0.0),
            if u < 0.5 { DVec3::new(0.5 - u, 0.0, 1.0) } else { DVec3::new(0.0, u - 0.5, 1.0) },
        )
    };
    for machine in machines() {
        let k = machine.kinematics().unwrap();
        let params = LinearisationParams::default();
        let path = ToolPath::new(lean, &points(5)).unwrap();
        let line = linearise(&k, &path, &params, &Cancel::default()).unwrap();
        assert!(densely(&k, &path, &line, &params) <= params.linearisation_mm);
        let Passage::TurnedInPlace { by_deg } = line.singular[0].passage else { panic!("{}", line.singular[0]) };
        assert!((by_deg - 90.0).abs() < 1e-3, "{by_deg}");
    }
}

#[test]
fn a_tilt_that_cannot_go_past_the_pole_turns_half_round_there() {
    let mut machine = machines().remove(2);
    machine.rotary[0].limits_deg = Some([-5.0, 120.0]);
    let k = machine.kinematics().unwrap();
    let params = LinearisationParams::default();
    let path = ToolPath::new(passing(0.0), &points(6)).unwrap();
    let line = linearise(&k, &path, &params, &Cancel::default()).unwrap();
    assert!(densely(&k, &path, &line, &params) <= params.linearisation_mm);
    assert!(line.points.iter().all(|p| p.joints.rotary[0].to_degrees() >= -5.0));
    let Passage::TurnedInPlace { by_deg } = line.singular[0].passage else { panic!("{}", line.singular[0]) };
    assert!((by_deg - 180.0).abs() < 1e-3, "{by_deg}");
    // While it turns the tip stays where it is.
    let turning = line.points.windows(2).filter(|w| w[0].s == w[1].s);
    assert!(turning.clone().count() > 20 && turning.clone().all(|w| w[0].tip == w[1].tip));
}

#[test]
fn a_path_along_the_pole_turns_nothing() {
    for machine in machines() {
        let path = ToolPath::new(|u| (DVec3::new(20.0 * u, 0.0, 1.0), DVec3::Z), &points(5)).unwrap();
        let line =
            linearise(&machine.kinematics().unwrap(), &path, &LinearisationParams::default(), &Cancel::default())
                .unwrap();
        assert_eq!(line.points.len(), 5, "straight cuts need no points between");
        assert!(line.points.iter().all(|p| p.joints.rotary == [0.0; 2]));
        assert_eq!(line.singular[0].passage, Passage::Held);
    }
}

/// How far the rotary axes go over a path, each way counted (rad).
fn turned(line: &MachinePath) -> [f64; 2] {
    let by = |i: usize| line.points.windows(2).map(|w| (w[1].joints.rotary[i] - w[0].joints.rotary[i]).abs()).sum();
    [by(0), by(1)]
}

/// Rounding (rad) that differs from place to place, in so many waves.
fn rounding(off_rad: f64, waves: f64, u: f64) -> DVec3 {
    off_rad * DVec3::new((6.1 * waves * u).sin(), (8.7 * waves * u + 1.0).cos(), 0.0)
}

#[test]
fn a_wall_that_is_upright_but_for_rounding_turns_nothing() {
    for machine in machines() {
        let k = machine.kinematics().unwrap();
        // The last is what a fine tolerance over long flutes would not let pass by itself.
        for (off_rad, waves, linearisation_mm, reach_mm) in
            [(1e-9, 150.0, 2e-3, 30.0), (1e-7, 150.0, 2e-3, 60.0), (5e-7, 3.0, 1e-4, 60.0)]
        {
            let upright = |u: f64| (DVec3::new(60.0 * u - 30.0, 7.0, 0.0), DVec3::Z + rounding(off_rad, waves, u));
            let path = ToolPath::new(upright, &points(40)).unwrap();
            let params = LinearisationParams { linearisation_mm, reach_mm, ..LinearisationParams::default() };
            let line = linearise(&k, &path, &params, &Cancel::default()).unwrap();
            assert!(densely(&k, &path, &line, &params) <= params.linearisation_mm);
            assert_eq!(line.points.len(), 40, "{off_rad}: rounding asks for no points between");
            let turned = turned(&line);
            assert!(turned[k.pole_axis()] == 0.0 && turned[k.tilt_axis()] < 200.0 * off_rad, "{off_rad}: {turned:?}");
            assert_eq!(line.singular[0].passage, Passage::Held);
        }
    }
}

#[test]
fn where_a_wall_becomes_upright_the_poles_axis_stays_where_it_is() {
    // Leaning by 11 degrees at first and at last, to the same side; upright but for rounding midway.
    let aside = DVec3::new(0.6, 0.8, 0.0);
    let lean = |u: f64| 0.5 * ((0.4 - u).max(0.0) + (u - 0.6).max(0.0));
    let wall =
        move |u: f64| (DVec3::new(60.0 * u - 30.0, 7.0, 0.0), DVec3::Z + lean(u) * aside + rounding(1e-9, 150.0, u));
    for machine in machines() {
        let k = machine.kinematics().unwrap();
        let params = LinearisationParams::default();
        let path = ToolPath::new(wall, &points(41)).unwrap();
        let line = linearise(&k, &path, &params, &Cancel::default()).unwrap();
        assert!(densely(&k, &path, &line, &params) <= params.linearisation_mm);
        let [pole, tilt] = [turned(&line)[k.pole_axis()], turned(&line)[k.tilt_axis()]];
        assert!(pole < 1e-4 && (tilt - 2.0 * 0.2f64.atan()).abs() < 1e-4, "{}: {pole} {tilt}", machine.name);
    }
}
