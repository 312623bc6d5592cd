//! Claims of a simulation, and the instants that they refer to.

use super::*;

/// A corner of the drum is half a micrometre off, far from all that comes near.
#[test]
fn what_channels_differ_by_is_taken_off_and_twice_between_them() {
    const OFF: f64 = 5e-4;
    let even = parts(vec![chuck()], 0.0);
    let mut nearly = parts(vec![chuck()], 0.0);
    let corner = &mut nearly.blisk.vertices[5];
    *corner += OFF * DVec3::new(0.0, corner.y, corner.z).normalize();
    let nearly = nearly.certified();
    for (channels, times) in [(&[0][..], 0.0), (&[1], 1.0), (&[0, 1], 2.0)] {
        let (p, q) = (even.simulate(channels), nearly.simulate(channels));
        let error = f64::min(times, 1.0) * OFF;
        assert!((q.period_error().unwrap() - error).abs() < 1e-9, "{channels:?} {:?}", q.period_error());
        let [p, chuck] = [&p, &q].map(|s| pair(s, "chuck", "blisk"));
        assert!((p.certified - chuck.certified - times * OFF).abs() < 3e-6, "{channels:?}: {p:?} {chuck:?}");
        assert!((p.least.distance - chuck.least.distance).abs() < 1e-6, "{channels:?}: {p:?} {chuck:?}");
        let feed = q.pairs().iter().find(|p| p.during == Some("feed")).unwrap();
        assert!((feed.certified - (nearly.certificate.certified() - error)).abs() < 1e-9, "{channels:?}: {feed:?}");
    }
}

#[test]
fn a_certificate_of_something_else_or_of_too_little_proves_nothing() {
    let good = || parts(vec![chuck()], 0.0);
    let at = |x: f64, z: f64| Pose { x, z, ..Pose::FINAL };
    let mut other_blisk = good();
    other_blisk.blisk.vertices[5].x += 1e-9;
    let mut other_electrode = good();
    other_electrode.electrode.mesh.vertices[0].x += 1e-9;
    let others = [good().with_poses(vec![at(31.0, 0.0), Pose::FINAL]), other_blisk, other_electrode];
    assert!(good().simulate(&[0]).holds());
    for (i, other) in others.into_iter().enumerate() {
        let certificate = other.certified().certificate;
        assert!(certificate.holds());
        let (parts, certificate) = (good(), &certificate);
        let feed = (&parts.feed, certificate);
        let scenario = Scenario { feed, ..parts.scenario(&parts.machine) };
        let simulation = simulate(&scenario, &options(&[0]), &Task::default()).unwrap();
        let feed = simulation.pairs().iter().find(|p| p.during == Some("feed")).unwrap();
        assert!(feed.certified == 0.0 && !simulation.holds(), "{i}: {feed:?}");
    }
    // Down to 0.05 mm above the drum, where 0.098 mm are asked for.
    let close = good().with_poses(vec![at(30.0, 0.0), at(0.0, -8.95), Pose::FINAL]);
    assert!((close.certificate.least().distance - 0.05).abs() < 1e-6, "{:?}", close.certificate.least());
    let simulation = close.simulate(&[0]);
    let feed = simulation.pairs().iter().find(|p| p.during == Some("feed")).unwrap();
    assert!(feed.certified == 0.0 && !simulation.holds(), "{feed:?}");
}

#[test]
fn paths_without_rows_are_no_motion_and_hide_no_other() {
    let nothing = parts(vec![chuck()], 0.0).with_poses(Vec::new()).simulate(&[0, 1]);
    assert!(!nothing.holds() && nothing.pairs().is_empty());
    assert!(nothing.sentence().contains("the feed has no rows"), "{}", nothing.sentence());
    let stop = body("stop", Carrier::Bed, [23.0, 4.0, 100.0], [4.0, 2.0, 2.0]);
    let parts = parts(vec![chuck(), stop], 0.0);
    let empty = FeedPath { rows: Vec::new(), ..parts.feed.clone() };
    let scenario = Scenario { copying: Some((&empty, &parts.certificate)), ..parts.scenario(&parts.machine) };
    let simulation = simulate(&scenario, &options(&[0]), &Task::default()).unwrap();
    assert!(pair(&simulation, "chuck", "stop").contact.is_some());
    let copying = simulation.pairs().iter().find(|p| p.during == Some("copying motion")).unwrap();
    assert_eq!(copying.certified, 0.0);
}

/// Travels that end between two steps of files, past the middle between them.
#[test]
fn a_rounded_approach_stays_within_the_travel() {
    let mut parts = parts(vec![chuck()], 0.0);
    (parts.machine.travel_x_mm, parts.machine.travel_z_mm) = ([-1.0, 35.000_006], [-1.0, 0.123_456]);
    let simulation = parts.simulate(&[0]);
    assert_eq!(simulation.travel(), None);
    let clear = simulation.approach()[0];
    assert_eq!((clear.x, clear.z), (35.0, 0.123_45));
}

/// A lug below the axis that swings past a post and back: A falls first, and rises afterwards.
#[test]
fn what_a_turns_is_met_when_the_tour_first_comes_there() {
    let angle: f64 = 0.2;
    let lug = body("lug", Carrier::Table, [-20.0, 0.0, -100.0], [4.0, 4.0, 4.0]);
    let post = body("post", Carrier::Bed, [-20.0, 100.0 * angle.sin(), -100.0 * angle.cos()], [1.0, 1.0, 1.0]);
    let at = |x: f64, a: f64| Pose { x, a, ..Pose::FINAL };
    let parts = parts(vec![lug, post], 0.0).with_poses(vec![at(30.0, 0.0), at(30.0, -0.3), at(30.0, 0.0), Pose::FINAL]);
    let contact = pair(&parts.simulate(&[0]), "lug", "post").contact.unwrap();
    assert!(contact.phase == Phase::Feed && contact.row < 1.0, "{contact:?}");
    // Half of both widths before the middle of the post, some 2.5 of 100 mm.
    assert!((contact.pose.a + angle - 0.025).abs() < 0.005, "{contact:?}");
}

#[test]
fn a_contact_in_every_channel_is_told_of_the_one_burnt_first() {
    let stop = body("stop", Carrier::Bed, [23.0, 4.0, 100.0], [4.0, 2.0, 2.0]);
    // Its front at x + 1 meets the drum's face at 5.
    let nose = body("nose", Carrier::Electrode, [-8.0, 0.0, -10.0], [2.0, 2.0, 6.0]);
    let parts = parts(vec![chuck(), stop, nose], 0.0);
    let simulation = parts.simulate(&[0, 1, 3]);
    assert_eq!(simulation.visits().iter().map(|v| v.channel).collect::<Vec<_>>(), [3, 0, 1]);
    for (moving, fixed, row) in [("chuck", "stop", 2.0 / 3.0), ("nose", "blisk", 26.0 / 30.0)] {
        let found = pair(&simulation, moving, fixed);
        let contact = found.contact.unwrap();
        assert_eq!((contact.phase, contact.channel, found.least.channel), (Phase::Feed, 3, 0), "{found:?}");
        assert!((contact.row - row).abs() < 1e-6 && (contact.pose.a + FRAC_PI_2).abs() < 1e-8, "{contact:?}");
    }
}
