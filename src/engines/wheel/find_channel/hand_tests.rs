//! What is given by hand: points on hub, shroud and blades.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use super::super::by_hand::nearest;
use super::tests::{coarse, find, found};
use super::*;
use crate::channel::{Station, Surface};
use crate::fixtures::TestBlisk;
use crate::options::{Auto, AxisChoice, AxisLine, EndWalls};
use crate::parametric::wheel::{Flaws, MeridianCurve, ParametricWheel};
use geometry::frame::{Cylindrical, wrap_angle};

/// Points on a curve of a wheel at so many shares of the passage, each at another angle, in no order.
fn on_curve(curve: &MeridianCurve, shares: &[f64]) -> Vec<[f64; 3]> {
    let point = |(i, share): (usize, &f64)| {
        let at = curve.at(*share);
        Cylindrical { x: at.x, r: at.y, theta: 2.4 * i as f64 }.point().into()
    };
    shares.iter().enumerate().map(point).collect()
}

/// The point on the low wall of the passage above blade `k`.
fn on_blade(part: &ParametricWheel, k: usize, along: f64, height: f64) -> [f64; 3] {
    let place = part.place(along, height);
    let [theta, _] = part.walls(k, along, height).unwrap();
    Cylindrical { x: place.x, r: place.y, theta }.point().into()
}

fn ring() -> ParametricWheel {
    coarse(ParametricWheel::nozzle_ring())
}

fn impeller() -> ParametricWheel {
    coarse(ParametricWheel::impeller())
}

fn axial() -> ParametricWheel {
    let line = |r: f64| MeridianCurve::line(DVec2::new(0.0, r), DVec2::new(24.0, r + 2.0));
    ParametricWheel { blades: 24, hub: line(50.0), shroud: line(62.0), ..ring() }
}

/// Greatest distance of a channel's hub and shroud from the curves of its part, beside the blades (mm).
fn off_curves(part: &ParametricWheel, channel: &Channel) -> f64 {
    let polygon = |curve: &MeridianCurve| -> Vec<DVec2> { (0..=800).map(|i| curve.at(f64::from(i) / 800.0)).collect() };
    let (hub, shroud) = (polygon(&part.hub), polygon(&part.shroud));
    let [first, last] = channel.span_along();
    let inner = channel.meridian.iter().filter(|s| (first + 1.0..last - 1.0).contains(&s.along));
    inner.map(|s| nearest(&hub, s.hub).1.max(nearest(&shroud, s.shroud).1)).fold(0.0, f64::max)
}

const SHARES: [f64; 5] = [0.5, 0.05, 0.97, 0.25, 0.75];
/// What chords about the axis and along the curves may make of hub and shroud (mm).
const MOST_OFF: f64 = 0.05;

#[test]
fn points_on_hub_and_shroud_alone_give_the_passage() {
    let open = ParametricWheel { shrouded: false, ..impeller() };
    for part in [ring(), open, axial()] {
        let mesh = part.mesh();
        let base = found(&mesh);
        let points = |curve| on_curve(curve, &SHARES);
        let (hub_points_mm, shroud_points_mm) = (points(&part.hub), points(&part.shroud));
        let both = BliskOptions { hub_points_mm, shroud_points_mm, ..BliskOptions::default() };
        let channel = find(&mesh, &both).unwrap();
        assert_eq!((channel.flow, channel.shrouded, channel.blades), (base.flow, base.shrouded, base.blades));
        assert!((channel.throat.width_mm - base.throat.width_mm).abs() < 0.02, "{:?}", channel.throat);
        // Chords along the curves and about the axis.
        let off = off_curves(&part, &channel);
        assert!(off < MOST_OFF, "{:?}: {off}", channel.flow);
        assert!(channel.assumed.iter().any(|a| a.contains("5 on the hub, 5 on the shroud")), "{:?}", channel.assumed);
        // One of the two is enough, too.
        let one = if part.shrouded {
            BliskOptions { shroud_points_mm: Vec::new(), ..both }
        } else {
            BliskOptions { hub_points_mm: Vec::new(), ..both }
        };
        let channel = find(&mesh, &one).unwrap();
        assert_eq!((channel.flow, channel.shrouded), (base.flow, base.shrouded));
        assert!(off_curves(&part, &channel) < MOST_OFF);
    }
}

/// The lines across a passage of which nothing else is known than points on one of its walls.
#[test]
fn points_on_one_wall_give_the_lines_across_a_passage() {
    let open = ParametricWheel { shrouded: false, ..impeller() };
    for (part, end) in [(impeller(), 0), (impeller(), 1), (open, 0)] {
        let slices = Slices::new(part.mesh());
        let points = on_curve([&part.hub, &part.shroud][end], &SHARES);
        let mut options = BliskOptions::default();
        *[&mut options.hub_points_mm, &mut options.shroud_points_mm][end] = points;
        let by_hand = ByHand::new(&options, &Frame::IDENTITY);
        let cancel = Cancel::default();
        let tracer =
            Tracer { slices: &slices, pitch: part.pitch(), options: &options, by_hand: &by_hand, cancel: &cancel };
        let at = part.place(0.4, 0.4);
        let gap = slices.gaps(at.x, at.y)[2];
        let lines = tracer.lines_by_hand(Place { along: 0.0, x: at.x, r: at.y, gap }, None, 1.0).unwrap().unwrap();
        assert_eq!(lines.shrouded, part.shrouded);
        let center = DVec2::new(-30.0, 70.0);
        assert!(lines.lines.len() > 40, "{}", lines.lines.len());
        for [hub, shroud] in &lines.lines {
            let off = [hub.distance(center) - 50.0, shroud.distance(center) - 34.0];
            // A cubic curve through five points of a quarter circle, and steps of the search for the tips.
            let most = if part.shrouded { [0.1; 2] } else { [0.1, 0.6] };
            assert!(off[0].abs() < most[0] && off[1].abs() < most[1], "{off:?}");
        }
    }
}

#[test]
fn the_hub_is_the_wall_that_its_points_lie_on() {
    let part = ring();
    let options = BliskOptions { hub_points_mm: on_curve(&part.shroud, &SHARES), ..BliskOptions::default() };
    let channel = find(&part.mesh(), &options).unwrap();
    for s in &channel.meridian {
        assert!((s.hub.x - 12.0).abs() < 1e-6 && s.shroud.x.abs() < 1e-6, "{s:?}");
    }
    assert!(channel.agreement.iter().all(|a| a.share == 1.0), "{:?}", channel.agreement);
}

#[test]
fn the_first_point_on_a_blade_picks_the_passage() {
    let part = impeller();
    let mesh = part.mesh();
    // Near the inlet, where the passage is a long way round from its middle.
    for k in [0, 7] {
        for (height, other) in [(0.5, 0.6), (0.2, 0.9)] {
            let points = vec![on_blade(&part, k, 0.15, height), on_blade(&part, (k + 2) % 9, other, height)];
            let options = BliskOptions { blade_points_mm: points, ..BliskOptions::default() };
            let channel = find(&mesh, &options).unwrap();
            let (u, v) = (40, 12);
            let [low, high] = [&channel.low, &channel.high]
                .map(|wall| Cylindrical::from_point(channel.frame.to_parent(wall.point(u, v))));
            let along = (low.x + 30.0).atan2(70.0 - low.r) / (0.5 * PI);
            let [theta, next] = part.walls(k, along, 0.5).unwrap();
            assert!(wrap_angle(low.theta - theta).abs() < 0.02, "{k}: {} {theta}", low.theta);
            assert!(wrap_angle(high.theta - next).abs() < 0.02, "{k}: {} {next}", high.theta);
        }
    }
}

#[test]
fn a_wheel_that_lacks_a_blade_is_found_by_its_blade_count() {
    for part in [ring(), impeller(), axial()] {
        let flaws = Flaws { missing_blades: vec![4], ..Flaws::default() };
        let mesh = ParametricWheel { flaws, ..part.clone() }.mesh();
        assert!(find(&mesh, &BliskOptions::default()).is_err());
        let points = vec![on_blade(&part, 1, 0.5, 0.5)];
        let blades = Auto::Given(part.blades);
        let options = BliskOptions { blades, blade_points_mm: points, ..BliskOptions::default() };
        let channel = find(&mesh, &options).unwrap();
        assert_eq!((channel.blades, channel.kinds), (part.blades, 1));
        // Blade 4 would bound the passages above blades 3 and 4; the picked one is above blade 1.
        let unlike: Vec<usize> = channel.unlike.iter().map(|unlike| unlike.number).collect();
        assert_eq!(unlike, [2, 3], "{:?}", channel.assumed);
        assert!(off_curves(&part, &channel) < MOST_OFF);
    }
}

#[test]
fn under_half_a_shroud_a_passage_is_picked() {
    for (part, end) in [(ring(), 0.0), (axial(), 0.5 * TAU)] {
        let flaws = Flaws { missing_shroud: 0.5, ..Flaws::default() };
        let mesh = ParametricWheel { flaws, ..part.clone() }.mesh();
        // The shroud stands from theta 0 to half a turn.
        let at = |turn: f64| {
            let blade = (0..part.blades).min_by(|a, b| {
                let off = |k: usize| wrap_angle(part.walls(k, 0.5, 0.5).unwrap()[0] - turn).abs();
                off(*a).total_cmp(&off(*b))
            });
            let points = vec![on_blade(&part, blade.unwrap(), 0.5, 0.5)];
            find(&mesh, &BliskOptions { blade_points_mm: points, ..BliskOptions::default() })
        };
        let covered = at(0.25 * TAU).unwrap();
        assert!(covered.shrouded && off_curves(&part, &covered) < MOST_OFF);
        let open = at(0.75 * TAU).unwrap();
        assert!(!open.shrouded && open.unlike.len() >= part.blades / 3, "{:?}", open.unlike);
        // Where the shroud ends the passage is neither.
        if let Ok(channel) = at(end) {
            let width = covered.throat.width_mm;
            assert!((channel.throat.width_mm - width).abs() < 0.1 * width, "{} {width}", channel.throat.width_mm);
        }
    }
}

#[test]
fn about_the_right_axis_given_by_hand_the_wheel_is_right() {
    for part in [ring(), impeller()] {
        let mesh = part.mesh();
        let about = |direction: [f64; 3]| {
            let axis = AxisChoice::Line(AxisLine { direction, point: [0.0; 3] });
            find(&mesh, &BliskOptions { axis, ..BliskOptions::default() })
        };
        let (sin, cos) = 2.0_f64.to_radians().sin_cos();
        let wrong = about([cos, sin, 0.0]).unwrap_err().to_string();
        let named = format!("has {} blades about the axis through (0, 0, 0) mm along (1, 0, 0)", part.blades);
        assert!(wrong.contains(&named), "{wrong}");
        assert!(off_curves(&part, &about([1.0, 0.0, 0.0]).unwrap()) < MOST_OFF);
    }
}

/// A line that is off by so little is taken, but not unsaid.
#[test]
fn an_axis_given_a_little_beside_the_blades_is_told() {
    let mesh = axial().mesh();
    let told = |y: f64, tilt: f64| {
        let axis = AxisChoice::Line(AxisLine { direction: [1.0, tilt, 0.0], point: [0.0, y, 0.0] });
        let channel = find(&mesh, &BliskOptions { axis, ..BliskOptions::default() }).unwrap();
        channel
            .assumed
            .iter()
            .any(|a| a.contains("another axis than the one that is given: through (0, 0, 0) mm along (1, 0, 0)"))
    };
    assert!(told(0.01, 0.0) && told(0.03, 0.0) && told(0.0, 0.0005));
    assert!(!told(0.0, 0.0));
}

/// Points as they were measured, and curves that go on beyond the rim, say what was found without them.
#[test]
fn points_on_both_walls_say_what_was_found() {
    for part in [ring(), impeller(), axial()] {
        let mesh = part.mesh();
        let whole = found(&mesh);
        let of = |place: fn(&Station) -> DVec2, beyond: f64| {
            let mut places: Vec<DVec2> = whole.meridian.iter().step_by(6).map(place).collect();
            let [.., before, last] = places[..] else { panic!() };
            places.push(last + (1.0 + beyond) * (last - before));
            let point = |(i, at): (usize, &DVec2)| -> [f64; 3] {
                let at = Cylindrical { x: at.x, r: at.y, theta: i as f64 }.point();
                whole.frame.to_parent(at).into()
            };
            places.iter().enumerate().map(point).collect()
        };
        for beyond in [0.0, 1.0] {
            let (hub_points_mm, shroud_points_mm) = (of(|s| s.hub, beyond), of(|s| s.shroud, beyond));
            let channel =
                find(&mesh, &BliskOptions { hub_points_mm, shroud_points_mm, ..BliskOptions::default() }).unwrap();
            let off = channel.throat.width_mm - whole.throat.width_mm;
            assert!(off.abs() < 1e-3 && off_curves(&part, &channel) < MOST_OFF, "{beyond}: {off}");
        }
    }
}

#[test]
fn points_that_do_not_lie_where_they_should_are_refused_by_key_and_number() {
    let part = impeller();
    let mesh = part.mesh();
    let refused = |options: BliskOptions| find(&mesh, &options).unwrap_err().to_string();
    let mut hub_points_mm = on_curve(&part.hub, &SHARES);
    // Two millimetres further out from the axis.
    let r = hub_points_mm[3][1].hypot(hub_points_mm[3][2]);
    (1..3).for_each(|i| hub_points_mm[3][i] *= (r + 2.0) / r);
    let message = refused(BliskOptions { hub_points_mm, ..BliskOptions::default() });
    assert!(message.contains("point 4 of blisk.hub_points_mm") && message.contains("mm off the hub"), "{message}");

    let in_the_air = part.place(0.5, 0.5);
    let point = Cylindrical { x: in_the_air.x, r: in_the_air.y, theta: part.walls(2, 0.5, 0.5).unwrap()[0] + 0.1 };
    let blade_points_mm = vec![on_blade(&part, 1, 0.5, 0.5), point.point().into()];
    let message = refused(BliskOptions { blade_points_mm, ..BliskOptions::default() });
    assert!(message.contains("point 2 of blisk.blade_points_mm"), "{message}");
    let off = 0.1 * in_the_air.y;
    assert!(message.contains(&format!("{off:.1}")), "{off}: {message}");

    let message = refused(BliskOptions { hub_points_mm: vec![[0.0; 3]], ..BliskOptions::default() });
    assert!(message.contains("blisk.hub_points_mm: has only one point, and a second one is needed"), "{message}");
    let both = BliskOptions {
        hub_points_mm: on_curve(&part.hub, &SHARES),
        hub_radius_mm: Auto::Given(50.0),
        ..BliskOptions::default()
    };
    assert!(refused(both).contains("blisk.hub_radius_mm, not both"));
}

/// A point off the hub is named however far off it is, and whatever it leads to.
#[test]
fn points_off_the_hub_of_an_axial_passage_are_named() {
    let part = axial();
    let mesh = part.mesh();
    let height = part.place(0.5, 0.0).distance(part.place(0.5, 1.0));
    for off in [-0.3, 0.2, 0.9] {
        let mut hub_points_mm = on_curve(&part.hub, &SHARES);
        let r = hub_points_mm[1][1].hypot(hub_points_mm[1][2]);
        (1..3).for_each(|i| hub_points_mm[1][i] *= (r + off * height) / r);
        let error = find(&mesh, &BliskOptions { hub_points_mm, ..BliskOptions::default() }).unwrap_err();
        assert!(matches!(error, BliskError::PointOff { number: 2, .. }), "{off}: {error}");
    }
}

#[test]
fn points_of_a_cone_stand_for_its_hub() {
    let part = TestBlisk { blades: 17, hub: [50.0, 0.15], shroud: [62.0, 0.25], ..Default::default() };
    let point = |x: f64, theta: f64| Cylindrical { x, r: part.hub_at(x), theta }.point().into();
    let options = BliskOptions { hub_points_mm: vec![point(12.0, 0.4), point(1.0, 2.0)], ..BliskOptions::default() };
    let mesh = part.mesh();
    let (channel, base) = (find(&mesh, &options).unwrap(), found(&mesh));
    let off = channel.low.points.iter().zip(&base.low.points).map(|(p, q): (&DVec3, &DVec3)| p.distance(*q));
    assert!(off.fold(0.0, f64::max) < 1e-6);
}
/// An impeller whose blades are as thick as this (mm) beside a hub that is small at the inlet.
fn narrow(thickness_mm: f64, shrouded: bool) -> ParametricWheel {
    let arc = |radius: f64| {
        MeridianCurve::quarter(DVec2::new(-30.0, 60.0 - radius), DVec2::X, DVec2::new(radius - 30.0, 60.0))
    };
    let (hub, shroud) = (arc(48.0), arc(24.0));
    ParametricWheel {
        blades: 16,
        thickness_mm,
        edge_thickness: 0.6,
        hub,
        shroud,
        shrouded,
        wrap: [1.0; 2],
        ..impeller()
    }
}

/// The flat edges of such blades lie along the circles there, which run into them up to the next blade.
#[test]
fn a_passage_much_narrower_than_its_blades_is_found() {
    for (thickness_mm, shrouded) in [(5.0, false), (6.0, true)] {
        let part = narrow(thickness_mm, shrouded);
        let channel = found(&geometry::solid::wound(&part.mesh()).unwrap());
        assert_eq!((channel.blades, channel.flow, channel.shrouded), (16, Flow::Mixed, shrouded));
        assert!(off_curves(&part, &channel) < MOST_OFF);
    }
}

#[test]
fn above_where_blades_grow_together_a_drawn_curve_bounds_the_passage() {
    const HEIGHT: f64 = 0.4;
    for shrouded in [false, true] {
        let part = narrow(8.0, shrouded);
        let width = |height: f64| part.walls(0, 0.2, height).map(|[low, high]| high - low).unwrap();
        assert!(width(0.0) < 0.0 && width(HEIGHT) > 0.0);
        let mesh = geometry::solid::wound(&part.mesh()).unwrap();
        // On walls of blades, as one picks them.
        let shares = [0.5, 0.12, 0.93, 0.25, 0.75];
        let hub_points_mm = shares.map(|along| on_blade(&part, 3, along, HEIGHT)).to_vec();
        let measured = BliskOptions { hub_points_mm, ..BliskOptions::default() };
        if shrouded {
            let refusal = find(&mesh, &BliskOptions::default()).unwrap_err().to_string();
            assert!(refusal.contains("draw a curve above the hub"), "{refusal}");
            assert!(find(&mesh, &measured).is_err(), "no hub lies there");
        }
        let channel = find(&mesh, &BliskOptions { end_walls: EndWalls::Drawn, ..measured.clone() }).unwrap();
        assert_eq!((channel.blades, channel.flow, channel.shrouded), (16, Flow::Mixed, shrouded));
        let [first, last] = channel.span_along();
        let drawn: Vec<DVec2> = (0..=800).map(|i| part.place(f64::from(i) / 800.0, HEIGHT)).collect();
        for station in channel.meridian.iter().filter(|s| (first + 1.0..last - 1.0).contains(&s.along)) {
            // A cubic curve through five points of a quarter of an ellipse.
            let off = nearest(&drawn, station.hub).1;
            assert!(off < 0.2, "{off} mm off at {}", station.along);
        }
        assert!(channel.assumed.iter().any(|a| a.contains("Drawn curves")), "{:?}", channel.assumed);
        if shrouded {
            continue;
        }
        // Between two drawn curves nothing ends the passage but its own height.
        let BliskOptions { hub_points_mm, .. } = measured;
        let shroud_points_mm = shares.map(|along| on_blade(&part, 3, along, 0.9)).to_vec();
        let both = BliskOptions { hub_points_mm, shroud_points_mm, end_walls: EndWalls::Drawn, ..Default::default() };
        let channel = find(&mesh, &both).unwrap();
        let [first, last] = channel.span_along();
        let height = channel.meridian.iter().map(Station::height).fold(0.0, f64::max);
        let ends = [channel.meridian[0].along, channel.meridian[channel.meridian.len() - 1].along];
        assert!(ends[0] > first - 2.0 * height && ends[1] < last + 2.0 * height, "{ends:?} of {first} to {last}");
    }
    // Into the part none may be drawn.
    let part = axial();
    let lower = MeridianCurve(part.hub.0.map(|p| p - DVec2::new(0.0, 0.2)));
    let hub_points_mm = on_curve(&lower, &[0.12, 0.5, 0.88]);
    let drawn = BliskOptions { hub_points_mm, end_walls: EndWalls::Drawn, ..BliskOptions::default() };
    let error = find(&part.mesh(), &drawn).unwrap_err();
    assert!(matches!(error, BliskError::DrawnOutside { key: "hub_points_mm", .. }), "{error}");
}

/// Over the middle of the passage at half its height stands a blade that leans: the shroud is met beside its curve.
#[test]
fn curves_drawn_on_hub_and_shroud_between_leaning_blades_are_measured_there() {
    let narrow = TestBlisk { blades: 90, thickness: 2.7, fillet: 0.3, grid: [24, 24, 8, 2], ..Default::default() };
    let part = TestBlisk { twist: 0.5 / 56.0, ..narrow };
    let points = |r: f64| vec![[1.0, r, 0.0], [7.0, r, 0.0], [13.0, r, 0.0]];
    let (hub_points_mm, shroud_points_mm) = (points(50.0), points(62.0));
    let drawn = BliskOptions { hub_points_mm, shroud_points_mm, end_walls: EndWalls::Drawn, ..Default::default() };
    let channel = find(&part.mesh(), &drawn).unwrap();
    assert!(channel.shrouded);
    let shroud = channel.agreement.iter().find(|a| a.surface == Surface::Shroud).expect("it is measured");
    assert!(shroud.share > 0.95 && shroud.greatest_mm < 0.05, "{shroud:?}");
}

/// A hub that is drawn from end to end, beyond the blades as well, reaches as far as it is drawn.
#[test]
fn a_drawn_hub_alone_bounds_the_passage_beyond_the_blades() {
    const HEIGHT: f64 = 0.1;
    let part = ParametricWheel { span: [0.25, 0.9], ..impeller() };
    let shares: Vec<f64> = (0..=12).map(|i| 0.03 + 0.94 * f64::from(i) / 12.0).collect();
    let hub_points_mm = shares
        .iter()
        .map(|along| {
            let at = part.place(*along, HEIGHT);
            Cylindrical { x: at.x, r: at.y, theta: 0.0 }.point().into()
        })
        .collect();
    let drawn = BliskOptions { hub_points_mm, end_walls: EndWalls::Drawn, ..BliskOptions::default() };
    let channel = find(&part.mesh(), &drawn).unwrap();
    assert_eq!((channel.blades, channel.shrouded), (part.blades, true));
    let hub: Vec<DVec2> = channel.meridian.iter().map(|station| station.hub).collect();
    for share in [shares[0], shares[12]] {
        let off = nearest(&hub, part.place(share, HEIGHT)).1;
        assert!(off < 0.2, "ends {off} mm before where it is drawn to");
    }
}

/// A refusal for points names the one that is off, not all of them.
#[test]
fn a_point_that_is_off_is_named() {
    let part = impeller();
    let mesh = part.mesh();
    let far = |r: f64| Cylindrical { x: part.place(0.5, 1.0).x, r, theta: 0.3 }.point().into();
    let mut shroud_points_mm = on_curve(&part.shroud, &[0.1, 0.9]);
    shroud_points_mm.push(far(300.0));
    let error = find(&mesh, &BliskOptions { shroud_points_mm, ..BliskOptions::default() }).unwrap_err();
    assert!(matches!(error, BliskError::PointOff { key: "shroud_points_mm", number: 3, .. }), "{error}");
    let blade_points_mm = vec![on_blade(&part, 3, 0.5, 0.5), far(300.0)];
    let error = find(&mesh, &BliskOptions { blade_points_mm, ..BliskOptions::default() }).unwrap_err();
    assert!(matches!(error, BliskError::BladePoint { number: 2, .. }), "{error}");
}
