use task::Task;

use super::*;
use crate::channel::BladeSide;
use crate::find_channel::find_channel;
use crate::options::BliskOptions;
use crate::parametric::random::{random_wheel, shares};
use crate::parametric::wheel::ParametricWheel;
use crate::parametric::{MeshResolution, ParametricBlisk};
use crate::surface_finder::SurfaceFinder;

/// Half of a round bore of radius `radius` about `axis`, its middle line at (sine, cosine) 0: `side` -1 is the wall
/// of smaller theta. `axis` gives place and sideways direction at a share of the length.
fn half_bore(axis: impl Fn(f64) -> [DVec3; 2], radius: f64, side: f64, nu: usize, nv: usize) -> NurbsWall {
    let angle = |v: usize| 1.4 * (2.0 * v as f64 / (nv - 1) as f64 - 1.0);
    let mut points = Vec::new();
    for u in 0..nu {
        let [middle, sideways] = axis(u as f64 / (nu - 1) as f64);
        points.extend((0..nv).map(|v| {
            let (sin, cos) = angle(v).sin_cos();
            middle + sideways * (side * radius * cos) + DVec3::Z * (radius * sin)
        }));
    }
    let normals = vec![DVec3::Z; points.len()];
    NurbsWall::of_grid(&crate::channel::ChannelWall { nu, nv, points, normals, side: BladeSide::Flat }).unwrap()
}

#[test]
fn the_centreline_of_a_straight_bore_is_its_axis() {
    // Theta grows towards -Y.
    let axis = |t: f64| [DVec3::new(30.0 * t - 15.0, 0.0, 110.0), DVec3::NEG_Y];
    let [low, high] = [-1.0, 1.0].map(|side| half_bore(axis, 4.0, side, 41, 21));
    let line = Centreline::between(&low, &high, &Cancel::default()).unwrap();
    assert!((line.length() - 30.0).abs() < 1e-3, "{}", line.length());
    for i in 0..=50 {
        let p = line.curve().point(f64::from(i) / 50.0);
        assert!(p.y.abs() < 1e-3 && (p.z - 110.0).abs() < 1e-3, "{p}");
    }
    assert!(line.diameters().unwrap()[1] < 8.0 + 1e-3);
    for circle in line.sections.iter().flatten() {
        let [a, b] = circle.contacts.map(|c| c.distance(circle.center));
        assert!((a - b).abs() < 1e-6, "as far from one wall as from the other");
    }
}

#[test]
fn the_centreline_of_a_bent_bore_is_its_arc() {
    // An arc of radius 40 in the plane z = 110, 40 degrees long.
    let arc = 40f64.to_radians();
    let axis = |t: f64| {
        let (sin, cos) = (arc * (t - 0.5)).sin_cos();
        [DVec3::new(40.0 * sin, 40.0 * cos - 39.0, 110.0), DVec3::new(sin, cos, 0.0) * -1.0]
    };
    let [low, high] = [-1.0, 1.0].map(|side| half_bore(axis, 4.0, side, 61, 21));
    let line = Centreline::between(&low, &high, &Cancel::default()).unwrap();
    for i in 0..=100 {
        let p = line.curve().point(f64::from(i) / 100.0);
        let off = (p.x.hypot(p.y + 39.0) - 40.0).hypot(p.z - 110.0);
        assert!(off < 1e-3, "{off} mm at {p}");
    }
    assert!(line.length() > 0.97 * 40.0 * arc && line.length() < 40.0 * arc + 1e-3, "{}", line.length());
}

#[test]
fn places_along_the_line_are_found_by_length_and_by_x() {
    let axis = |t: f64| [DVec3::new(30.0 * t, 5.0 * t * t, 100.0), DVec3::NEG_Y];
    let [low, high] = [-1.0, 1.0].map(|side| half_bore(axis, 3.0, side, 41, 15));
    let line = Centreline::between(&low, &high, &Cancel::default()).unwrap();
    let places: Vec<DVec3> = (0..=2000).map(|i| line.at_length(line.length() * f64::from(i) / 2000.0)[0]).collect();
    let chords: f64 = places.windows(2).map(|w| w[0].distance(w[1])).sum();
    assert!((chords - line.length()).abs() < 1e-4, "{chords}");
    let even = line.length() / 2000.0;
    assert!(places.windows(2).all(|w| (w[0].distance(w[1]) - even).abs() < 1e-6));
    for l in [-20.0, -0.1, 0.0, 4.0, 17.5, line.length(), line.length() + 8.0] {
        let [place, direction] = line.at_length(l);
        assert!((line.length_at_x(place.x) - l).abs() < 1e-6, "{l}");
        assert!((direction.length() - 1.0).abs() < 1e-9 && direction.x > 0.0);
    }
    // Beyond the ends it goes straight on from where it ended.
    let [end, beyond] = [line.length(), line.length() + 3.0].map(|l| line.at_length(l)[0]);
    assert!((end.distance(beyond) - 3.0).abs() < 1e-9);
    assert_eq!(line.polyline(7).len(), 7);
}

/// In a radial passage and in one that turns from the axis to the radius the line is as far from one wall as from the
/// other, half way from hub to shroud, and about as long as what lies half way between the blades.
#[test]
fn in_passages_of_any_direction_it_lies_in_the_middle() {
    // Of the third the blades end at the very rims.
    let to_the_rims = ParametricWheel { span: [0.0, 1.0], ..ParametricWheel::nozzle_ring() };
    for wheel in [ParametricWheel::nozzle_ring(), ParametricWheel::impeller(), to_the_rims] {
        let wheel = ParametricWheel { pieces: [112, 36, 4], ..wheel };
        let channel = find_channel(&wheel.mesh(), &BliskOptions::default(), &Task::default()).unwrap();
        assert_ne!(channel.flow, Flow::Axial);
        let line = Centreline::of_channel(&channel, &Cancel::default()).unwrap();
        let finder = SurfaceFinder::new(channel.clone().into()).unwrap();
        for i in 4..=36 {
            let l = line.length() * f64::from(i) / 40.0;
            let [p, direction] = line.at_length(l);
            let [low, high] = finder.wall_distances(p);
            assert!((low - high).abs() < 0.05 * (low + high), "{i}: {low} {high}");
            let [along, height] = channel.along_and_height(DVec2::new(p.x, p.y.hypot(p.z)));
            let share = height / channel.station_at(along).height();
            assert!((share - 0.5).abs() < 0.08, "{i}: {share}");
            assert!((line.length_near(p) - l).abs() < 1e-6 && (direction.length() - 1.0).abs() < 1e-9);
        }
        // A circle between two blades is no wider than their pitch.
        let widest = channel.low.points.iter().map(|p| p.y.hypot(p.z)).fold(0.0, f64::max) * wheel.pitch();
        assert!(line.diameters().unwrap()[1] < widest, "{:?}", line.diameters());
        // Half way between the blades, as the wheel is drawn.
        let middle = |i: u32| {
            let along = wheel.span[0] + (wheel.span[1] - wheel.span[0]) * f64::from(i) / 400.0;
            let [low, high] = wheel.walls(0, along, 0.5)?;
            let DVec2 { x, y: r } = wheel.place(along, 0.5);
            Some(Cylindrical { x, r, theta: 0.5 * (low + high) }.point())
        };
        let drawn: Vec<DVec3> = (0..=400).filter_map(middle).collect();
        let drawn: f64 = drawn.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
        assert!(line.length() > 0.7 * drawn && line.length() < 1.05 * drawn, "{} of {drawn}", line.length());
    }
}

/// Between blades that hardly overlap, or that wind far around the axis, circles do not lead through: the line stays off
/// the metal and goes on from the inlet to the outlet all the same.
#[test]
fn where_no_circles_lead_through_it_is_half_way_between_the_walls() {
    for number in [27, 33, 39] {
        let (wheel, _) = random_wheel(number, &mut shares(number as u64));
        let mesh = wheel.mesh();
        let channel = find_channel(&mesh, &BliskOptions::default(), &Task::default()).unwrap();
        let line = Centreline::of_channel(&channel, &Cancel::default()).unwrap();
        let exact = channel.exact(&mesh.in_frame(&channel.frame).into()).unwrap();
        assert!(line.sections.is_empty() && line.diameters().is_none(), "wheel {number}");
        let [from, to] = channel.span_along();
        let mut before = f64::NEG_INFINITY;
        for i in 0..=200 {
            let [p, _] = line.at_length(line.length() * f64::from(i) / 200.0);
            let [along, _] = channel.along_and_height(DVec2::new(p.x, p.y.hypot(p.z)));
            assert!(along > before && (from..=to).contains(&along), "wheel {number}: {along} after {before}");
            let off = exact.nearest(p).signed_distance;
            let room = channel.throat.width_mm.min(channel.station_at(along).height());
            assert!(off > 0.2 * room, "wheel {number}: {off} at {along}");
            before = along;
        }
        assert!(before - from > 0.8 * (to - from), "wheel {number}: as far as {before} of {from} to {to}");
    }
}

#[test]
fn the_line_reaches_a_place_along_a_direction_from_either_end() {
    let axis = |t: f64| [DVec3::new(30.0 * t, 5.0 * t * t, 100.0), DVec3::NEG_Y];
    let [low, high] = [-1.0, 1.0].map(|side| half_bore(axis, 3.0, side, 41, 15));
    let line = Centreline::between(&low, &high, &Cancel::default()).unwrap();
    let direction = DVec3::new(0.6, 0.8, 0.0);
    for l in [7.0, 20.0, line.length() + 4.0] {
        let value = line.at_length(l)[0].dot(direction);
        assert!((line.length_reaching((direction, value), 5.0, 1.0) - l).abs() < 1e-6, "{l}");
        assert_eq!(line.length_reaching((direction, value), l + 1.0, 1.0), l + 1.0, "so far already");
    }
    let back = line.at_length(3.0)[0].dot(-direction);
    assert!((line.length_reaching((-direction, back), 12.0, -1.0) - 3.0).abs() < 1e-6);
}

#[test]
fn walls_that_do_not_face_each_other_have_none() {
    let axis = |x: f64| move |t: f64| [DVec3::new(x + 10.0 * t, 0.0, 100.0), DVec3::NEG_Y];
    let low = half_bore(axis(0.0), 3.0, -1.0, 21, 9);
    let high = half_bore(axis(30.0), 3.0, 1.0, 21, 9);
    let error = Centreline::between(&low, &high, &Cancel::default()).unwrap_err();
    assert!(matches!(error, CentrelineError::NoPassage { found: 0, .. }), "{error}");
    let cancel = Cancel::default();
    cancel.cancel();
    assert_eq!(Centreline::between(&low, &low, &cancel), Err(CentrelineError::Cancelled(Cancelled)));
}

#[test]
fn between_blades_farther_apart_than_they_are_long_it_leads_straight_through() {
    // Beyond the blades' ends such circles are wider than the blades are long, and their centres far away.
    for (chord_mm, width_mm) in [(14.0, 20.0), (10.0, 14.0), (7.0, 12.0), (5.0, 9.0)] {
        let blisk = ParametricBlisk {
            blades: 24,
            hub_radius_mm: 42.0,
            shroud_radius_mm: 50.0,
            bore_radius_mm: 28.0,
            width_mm,
            chord_mm,
            max_thickness_mm: 0.2 * chord_mm,
            beta_in_deg: 20.0,
            beta_out_deg: -25.0,
            twist_deg: 2.0,
            ..Default::default()
        };
        let mesh = blisk.mesh(&MeshResolution::default()).unwrap();
        let channel = find_channel(&mesh, &BliskOptions::default(), &Task::default()).unwrap();
        let line = Centreline::of_channel(&channel, &Cancel::default()).unwrap();
        // The blades bend by less than 25 degrees either way.
        let longest = chord_mm / 25f64.to_radians().cos();
        assert!(line.length() > chord_mm - 0.1 && line.length() < longest, "{} of {chord_mm}", line.length());
        assert!(line.fit.greatest_mm < 0.02, "{:?}", line.fit);
    }
}
