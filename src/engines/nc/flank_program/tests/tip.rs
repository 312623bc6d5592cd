//! Programs for controls that follow the tool's tip.

use super::*;

/// The built-in post with the words of a control that follows the tool's tip.
fn following_post() -> Post {
    let words = "[tip_control]\nangles = \"G43.4\"\nvector = \"G43.5\"\noff = \"G49\"\n\n[comment]";
    Post::from_toml(&BUILT_IN_POST.1.replacen("[comment]", words, 1), "following").unwrap()
}

#[test]
fn a_tools_direction_is_counted_along_the_same_axes_as_its_tip() {
    let k = machines()[2].kinematics().unwrap();
    let plain = moves(&made(&k, &following_post(), TipControl::Vector).nc.text, "XYZIJK");
    for reversed in [vec![Axis::X], vec![Axis::Y, Axis::Z], vec![Axis::X, Axis::Y, Axis::Z], vec![Axis::C]] {
        let mut post = following_post();
        post.axes.iter_mut().for_each(|a| a.reversed = reversed.contains(&a.axis));
        let text = made(&k, &post, TipControl::Vector).nc.text;
        let signs = [Axis::X, Axis::Y, Axis::Z].map(|a| if reversed.contains(&a) { -1.0 } else { 1.0 });
        for (p, r) in plain.iter().zip(moves(&text, "XYZIJK")) {
            for i in 0..6 {
                assert_eq!(r.0[i], signs[i % 3] * p.0[i], "{reversed:?}");
            }
        }
        assert!(!text.contains("I-0.000000000 "));
    }
}

#[test]
fn built_in_posts_for_milling_read_back_and_the_example_follows_the_tip() {
    for (name, _) in BUILT_IN_POSTS {
        let post = milling_post(name).unwrap();
        assert_eq!(Post::from_toml(&toml::to_string(&post).unwrap(), name).unwrap(), post);
        assert_eq!((post.axes.len(), post.feed.mode), (6, FeedMode::InverseTime), "{name}");
    }
    let example = milling_post("milling-tcp").unwrap();
    assert!(example.title.contains("Example"), "{}", example.title);
    assert_eq!(example.tip_control, following_post().tip_control);
    for tip_control in [TipControl::Angles, TipControl::Vector] {
        assert!(tip_words(&example, tip_control).unwrap().is_some());
    }
    let unknown = milling_post("mine").unwrap_err().to_string();
    assert!(unknown.contains("milling, milling-tcp, iso, beckhoff-edm"), "{unknown}");
}

#[test]
fn a_post_without_words_for_the_tip_is_refused_one() {
    let k = machines()[2].kinematics().unwrap();
    let path = path();
    let mut only_angles = following_post();
    only_angles.tip_control.as_mut().unwrap().vector = None;
    for (post, tip_control, wanted) in [
        (milling_post("milling").unwrap(), TipControl::Angles, "angles"),
        (milling_post("milling").unwrap(), TipControl::Vector, "vector"),
        (only_angles, TipControl::Vector, "vector"),
    ] {
        let params = LinearisationParams { interpolation: tip_control.interpolation(), ..Default::default() };
        let line = linearise(&k, &path, &params, &Cancel::default()).unwrap();
        let job = bare_job(&k, &path, &line, &params);
        let settings = FlankNcSettings { tip_control, ..FlankNcSettings::default() };
        let error = FlankNc::of(&job, &post, &settings).unwrap_err();
        assert_eq!(error, NcError::NoTipControl { wanted });
        assert!(error.to_string().contains("[tip_control]"), "{error}");
    }
}

#[test]
fn a_control_that_follows_the_tip_gets_tip_and_turn() {
    let k = machines()[2].kinematics().unwrap();
    let post = following_post();
    let angles = made(&k, &post, TipControl::Angles);
    assert!(angles.nc.text.contains("\nG43.4 H1\n") && angles.nc.text.contains("\nG49\n"));
    let vector = made(&k, &post, TipControl::Vector);
    assert!(vector.nc.text.contains("\nG43.5 H1\n"));
    let (angles_moves, vector_moves) = (moves(&angles.nc.text, "XYZBC"), moves(&vector.nc.text, "XYZIJK"));
    assert_eq!(angles_moves.len(), vector_moves.len());
    let path = path();
    for ((a, v), point) in angles_moves.iter().zip(&vector_moves).zip(&angles.line.points) {
        let wanted = path.at(point.s).unwrap();
        assert!(DVec3::new(a.0[0], a.0[1], a.0[2]).distance(wanted.tip) < 1e-5);
        assert_eq!(a.0[..3], v.0[..3]);
        let axis = DVec3::new(v.0[3], v.0[4], v.0[5]);
        assert!(axis.distance(wanted.axis) < 1e-7);
        assert!(tool(2, &[0.0, 0.0, 0.0, a.0[3], a.0[4]]).1.distance(axis) < 1e-7);
    }
    // Positions that were measured for another kind of motion are refused.
    let job_params = LinearisationParams::default();
    let line = linearise(&k, &path, &job_params, &Cancel::default()).unwrap();
    let job = bare_job(&k, &path, &line, &job_params);
    let settings = FlankNcSettings { tip_control: TipControl::Angles, ..FlankNcSettings::default() };
    assert!(FlankNc::of(&job, &post, &settings).unwrap_err().to_string().contains("tip_control"));
}

#[test]
fn a_control_that_follows_the_tip_gets_it_in_the_machines_directions_however_the_workpiece_is_clamped() {
    let mut machine = machines().remove(1);
    // Turned about X by 30 degrees: the workpiece's Z leans towards the machine's Y.
    let (y, z) = (DVec3::new(0.0, 0.75f64.sqrt(), -0.5), DVec3::new(0.0, 0.5, 0.75f64.sqrt()));
    (machine.workpiece.x_axis, machine.workpiece.z_axis) = (DVec3::X, z);
    let k = machine.kinematics().unwrap();
    let turned = |v: DVec3| DVec3::X * v.x + y * v.y + z * v.z;
    let angles = made(&k, &following_post(), TipControl::Angles);
    let vector = made(&k, &following_post(), TipControl::Vector);
    let path = path();
    let moves = [moves(&angles.nc.text, "XYZCB"), moves(&vector.nc.text, "XYZIJK")];
    for ((a, v), point) in moves[0].iter().zip(&moves[1]).zip(&angles.line.points) {
        let wanted = path.at(point.s).unwrap();
        assert!(DVec3::new(a.0[0], a.0[1], a.0[2]).distance(turned(wanted.tip)) < 1e-5);
        let axis = DVec3::new(v.0[3], v.0[4], v.0[5]);
        assert!(axis.distance(turned(wanted.axis)) < 1e-7 && a.0[..3] == v.0[..3]);
        assert!(tool(1, &[0.0, 0.0, 0.0, a.0[3], a.0[4]]).1.distance(axis) < 1e-7);
    }
}
