//! How fast the moves of a machine are.

use super::*;
use crate::machine::joint_feed::{Contact, Feeds, least_minutes, paces};

#[test]
fn no_axis_exceeds_its_speed_and_no_contact_the_feed() {
    for mut machine in machines_with_free_heads() {
        machine.rotary.iter_mut().for_each(|r| r.speed_deg_min = 400.0);
        let k = machine.kinematics().unwrap();
        let params = LinearisationParams::default();
        let path = ToolPath::new(passing(0.5), &points(21)).unwrap();
        let line = linearise(&k, &path, &params, &Cancel::default()).unwrap();
        let interpolation = params.interpolation;
        let reach_mm = params.reach_mm;
        let contact = None;
        let feeds =
            Feeds { cut_mm_min: 800.0, lead_mm_min: 2000.0, reach_mm, least_minutes: 0.0, interpolation, contact };
        let paces = paces(&k, &path, &line, &feeds);
        let mut slowed = 0;
        for (pace, w) in paces.iter().zip(line.points.windows(2)) {
            assert!(pace.minutes >= least_minutes(&k, &w[0], &w[1]).0 * (1.0 - 1e-12));
            for i in 0..2 {
                let by = (w[1].joints.rotary[i] - w[0].joints.rotary[i]).to_degrees().abs();
                assert!(by / pace.minutes <= 400.0 * (1.0 + 1e-9));
            }
            let speeds = (w[1].joints.linear - w[0].joints.linear).abs() / pace.minutes;
            assert!(speeds.max_element() <= 40_000.0);
            assert!(pace.way_mm / pace.minutes <= 800.0 * (1.0 + 1e-9));
            slowed += usize::from(pace.share < 1.0);
            // Where nothing is slowed the feed is kept, not only not exceeded.
            assert!(pace.share < 1.0 || (pace.way_mm / pace.minutes - 800.0).abs() < 1e-6);
        }
        assert!(slowed > 0 && slowed < paces.len());
    }
}

#[test]
fn in_a_hollow_it_is_the_contact_that_has_the_feed_and_leads_touch_at_that_of_the_cut() {
    // An upright cutter of radius 3 mm along a quarter of an arc of radius 4 mm, inside and outside of it.
    let arc = |axis_radius: f64| {
        move |u: f64| (axis_radius * DVec3::new((FRAC_PI_2 * u).cos(), (FRAC_PI_2 * u).sin(), 0.0), DVec3::Z)
    };
    let k = trunnion().kinematics().unwrap();
    for (axis_radius, is_right, fastest) in [(1.0, true, 4.0), (7.0, false, 7.0)] {
        let at = |by: f64, z: f64| ToolPose { tip: DVec3::new(axis_radius + by, 0.0, z), axis: DVec3::Z };
        let path = ToolPath::with_leads(arc(axis_radius), &points(9), &[at(1.0, 50.0), at(1.0, 0.0)], &[]).unwrap();
        let params = LinearisationParams::default();
        let line = linearise(&k, &path, &params, &Cancel::default()).unwrap();
        let contact = Some(Contact { radii_mm: [3.0; 2], is_right });
        let interpolation = params.interpolation;
        let feeds =
            Feeds { cut_mm_min: 100.0, lead_mm_min: 900.0, reach_mm: 20.0, least_minutes: 0.0, interpolation, contact };
        let paces = paces(&k, &path, &line, &feeds);
        let cut: f64 = paces.iter().filter(|p| p.section == Section::Cut).map(|p| p.minutes).sum();
        let wanted = FRAC_PI_2 * fastest / 100.0;
        assert!((cut / wanted - 1.0).abs() < 1e-3, "{cut} {wanted}");
        let approach: f64 = paces.iter().filter(|p| p.section == Section::Approach).map(|p| p.minutes).sum();
        assert!((approach - (50.0 / 900.0 + 1.0 / 100.0)).abs() < 1e-9, "{approach}");
    }
}

#[test]
fn a_control_that_takes_no_shorter_moves_is_given_longer_ones_and_it_is_said() {
    let k = machines()[0].kinematics().unwrap();
    let params = LinearisationParams { linearisation_mm: 1e-4, ..LinearisationParams::default() };
    let path = ToolPath::new(passing(0.5), &points(21)).unwrap();
    let line = linearise(&k, &path, &params, &Cancel::default()).unwrap();
    let (reach_mm, interpolation) = (params.reach_mm, params.interpolation);
    let with = |least_minutes: f64| {
        let feeds =
            Feeds { cut_mm_min: 8000.0, lead_mm_min: 8000.0, reach_mm, least_minutes, interpolation, contact: None };
        paces(&k, &path, &line, &feeds)
    };
    let (free, least) = (with(0.0), 0.01 / 60.0);
    assert!(free.iter().all(|p| p.short_share == 1.0) && free.iter().any(|p| p.minutes < least));
    for (free, held) in free.iter().zip(with(least)) {
        assert_eq!(held.minutes, free.minutes.max(least));
        assert!((held.short_share - (free.minutes / held.minutes)).abs() < 1e-12 && held.share == free.share);
    }
}
