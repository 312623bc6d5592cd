//! Wheels with splitters: their blades are counted, and every kind of passage is followed along its own blades.

use std::f64::consts::{PI, TAU};

use glam::DVec2;

use super::tests::{coarse, find};
use super::*;
use crate::channel::Flow;
use crate::parametric::wheel::{MeridianCurve, ParametricWheel, Splitters};

#[test]
fn splitters_make_two_kinds_of_channels() {
    // Nine main blades and a splitter behind each, not quite in the middle.
    let part = ParametricWheel {
        blades: 18,
        splitters: vec![Splitters { off_middle: 0.02, ..Splitters::over([0.5, 0.95]) }],
        thickness_mm: 2.0,
        ..coarse(ParametricWheel::impeller())
    };
    let mesh = part.mesh();
    let channels = [0, 1].map(|channel| find(&mesh, &BliskOptions { channel, ..Default::default() }).unwrap());
    for channel in &channels {
        assert_eq!((channel.blades, channel.flow, channel.unlike.len()), (18, Flow::Mixed, 0));
        // Both kinds begin where the splitters do, half way along the arc of 42 mm radius.
        let first = channel.low.cylindrical(0, 12);
        let angle = (first.x + 30.0).atan2(70.0 - first.r);
        assert!((angle - PI / 4.0).abs() < 0.02, "{first:?}");
        assert!(channel.assumed.iter().any(|a| a.contains("repeat after every 2")), "{:?}", channel.assumed);
    }
    let width = |channel: &Channel| {
        let [low, high] = [&channel.low, &channel.high].map(|wall| wall.cylindrical(40, 12).theta);
        (high - low).rem_euclid(TAU)
    };
    let difference = (width(&channels[0]) - width(&channels[1])).abs();
    assert!((difference - 0.04).abs() < 1e-3, "one is wider by as much as the other is narrower: {difference}");
}

/// In an even pitch the gaps between thick main blades and thin splitters are not even; ahead of the splitters those
/// between the main blades alone are.
#[test]
fn thin_splitters_between_thick_blades_are_counted() {
    let part = ParametricWheel {
        blades: 18,
        splitters: vec![Splitters { thickness: 0.1, ..Splitters::over([0.5, 0.95]) }],
        thickness_mm: 10.0,
        ..coarse(ParametricWheel::impeller())
    };
    let mesh = part.mesh();
    for channel in [0, 1] {
        let found = find(&mesh, &BliskOptions { channel, ..Default::default() }).unwrap();
        assert_eq!((found.blades, found.kinds, found.unlike.len()), (18, 2, 0));
    }
}

/// At the tips a splitter may begin further back than another does at the hub: its edge stands beside the passage.
#[test]
fn every_passage_of_an_open_wheel_with_three_kinds_of_blades_is_found() {
    let part = ParametricWheel {
        blades: 15,
        splitters: [0.6, 0.35].map(|from| Splitters::over([from, 0.95])).into(),
        thickness_mm: 1.4,
        shrouded: false,
        ..coarse(ParametricWheel::impeller())
    };
    let mesh = part.mesh();
    for channel in 0..3 {
        let found = find(&mesh, &BliskOptions { channel, ..Default::default() }).unwrap();
        assert_eq!((found.blades, found.kinds, found.unlike.len()), (15, 3, 0), "{channel}");
    }
}

/// Of an axial wheel rays along the radius meet leaned blades rather than the hub. Ahead of a splitter the passage goes on
/// between the main blades, and points on the hub do not choose the stretch there.
#[test]
fn hub_and_tips_go_on_beside_leaned_blades_and_ahead_of_splitters() {
    let at = DVec2::new;
    let plain = ParametricWheel {
        blades: 34,
        hub: MeridianCurve([at(0.0, 45.0), at(14.0, 45.4), at(27.0, 47.0), at(40.0, 52.0)]),
        shroud: MeridianCurve::line(at(0.0, 75.0), at(40.0, 72.0)),
        shrouded: false,
        span: [0.08, 0.92],
        wrap: [0.9, -0.1],
        thickness_mm: 2.4,
        pieces: [200, 48, 8],
        ..ParametricWheel::nozzle_ring()
    };
    let splitters = vec![Splitters { off_middle: 0.02, thickness: 0.7, ..Splitters::over([0.5, 0.92]) }];
    let leaned = ParametricWheel { lean: 0.2, ..plain.clone() };
    let split = ParametricWheel { splitters, ..plain };
    let both = ParametricWheel { lean: 0.2, ..split.clone() };
    let hub_points = [0.1, 0.3, 0.5, 0.7, 0.9].map(|share| both.hub.at(share)).map(|p| [p.x, 0.0, p.y]);
    for (part, channel, hub_points_mm) in [
        (&leaned, 0, vec![]),
        (&split, 0, vec![]),
        (&both, 0, vec![]),
        (&both, 1, vec![]),
        (&both, 0, hub_points.into()),
    ] {
        let found = find(&part.mesh(), &BliskOptions { channel, hub_points_mm, ..Default::default() }).unwrap();
        assert_eq!((found.blades, found.kinds, found.flow), (34, part.kinds(), Flow::Axial));
        let ends = [found.meridian[0].along, found.meridian[found.meridian.len() - 1].along];
        assert!(ends[0] < 0.1 && ends[1] > 39.9, "{ends:?}");
        for share in (0..=100).map(|i| f64::from(i) / 100.0) {
            let [hub, tip] = [&part.hub, &part.shroud].map(|curve| curve.at(share));
            let off = found.radii_at(hub.x).0 - hub.y;
            assert!(off.abs() < 0.06, "channel {channel}: hub {off} off at {}", hub.x);
            let off = found.radii_at(tip.x).1 - tip.y;
            assert!(!(0.1..0.9).contains(&share) || off.abs() < 0.06, "channel {channel}: tips {off} off at {}", tip.x);
        }
    }
}
