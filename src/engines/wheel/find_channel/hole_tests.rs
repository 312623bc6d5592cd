//! Wheels with holes in hub, shroud and blades: they are no channels, and change nothing of these.

use std::f64::consts::TAU;

use glam::{DQuat, DVec2, DVec3};

use super::tests::{coarse, find, found};
use super::*;
use crate::channel::{Flow, Station, Surface};
use crate::fixtures::{TestBlisk, together};
use crate::options::Auto;
use crate::parametric::wheel::ParametricWheel;

/// A wall of revolution of `part` at a height of 0 or 1 with a round hole in it in the middle of every passage, as deep as
/// `depth` of its thickness.
fn drilled(part: &ParametricWheel, height: f64, radius: f64, depth: f64) -> Mesh {
    let (at, beside) = (part.place(0.5, height), part.place(0.5, 1.0 - height));
    let way = (beside - at).normalize();
    let ring: Vec<DVec2> = (0..24).map(|i| radius * DVec2::from_angle(TAU * f64::from(i) / 24.0)).collect();
    let hole = geometry::solid::prism(&[&ring], -depth * part.wall_mm, part.wall_mm).unwrap();
    let wall = part.wall(height);
    (0..part.blades).fold(wall, |wall, k| {
        let [low, high] = part.walls(k, 0.5, height).unwrap();
        let (sin, cos) = (0.5 * (low + high)).sin_cos();
        let turned = |x: f64, r: f64| DVec3::new(x, r * cos, r * sin);
        let (out, along) = (turned(way.x, way.y), turned(-way.y, way.x));
        let middle = turned(at.x, at.y);
        let placed = hole.mapped(|p| middle + p.x * along + p.y * out.cross(along) + p.z * out);
        geometry::solid::difference(&wall, &placed).unwrap()
    })
}

/// The greatest distance of the hub (0) or the shroud (1) that was found from the drawn one (mm).
fn off_curve(channel: &Channel, part: &ParametricWheel, height: f64) -> f64 {
    let curve: Vec<DVec2> = (0..=4000).map(|i| part.place(f64::from(i) / 4000.0, height)).collect();
    let off = |s: &Station| curve.iter().map(|p| p.distance(s.place(height))).fold(f64::INFINITY, f64::min);
    channel.meridian.iter().map(off).fold(0.0, f64::max)
}

#[test]
fn holes_in_hub_and_shroud_are_told_and_change_nothing() {
    let open = ParametricWheel { shrouded: false, ..coarse(ParametricWheel::impeller()) };
    let drilled_parts = [
        (coarse(ParametricWheel::nozzle_ring()), 1.0, Surface::Shroud, 2.0),
        (coarse(ParametricWheel::impeller()), 0.0, Surface::Hub, 2.0),
        (ParametricWheel { wall_mm: 8.0, ..coarse(ParametricWheel::impeller()) }, 0.0, Surface::Hub, 0.8),
        (open, 0.0, Surface::Hub, 2.0),
    ];
    for (part, height, surface, depth) in drilled_parts {
        let whole = found(&part.mesh());
        let other = part.shrouded.then(|| part.wall(1.0 - height));
        let blades = (0..part.blades).map(|k| part.blade(k));
        let mesh =
            other.into_iter().chain(blades).fold(drilled(&part, height, 3.0, depth), |all, one| together(all, &one));
        let channel = found(&mesh);
        assert!((channel.throat.width_mm - whole.throat.width_mm).abs() < 2e-3, "{:?}", channel.throat);
        let open = |a: &&Agreement| a.open > 0.0;
        let holes: Vec<Surface> = channel.agreement.iter().filter(open).map(|a| a.surface).collect();
        assert_eq!(holes, [surface]);
        assert!(channel.assumed.iter().any(|s| s.contains("has holes")), "{:?}", channel.assumed);
        let off = off_curve(&channel, &part, height);
        assert!(off < 0.05, "{off}");
    }
}

/// Balance holes that cut into the blades beside the hub: there a gap is narrower at once on one side only.
#[test]
fn holes_that_cut_into_blades_change_nothing() {
    let part = ParametricWheel { wall_mm: 8.0, ..coarse(ParametricWheel::impeller()) };
    let at = part.place(0.4, 0.0);
    let ring: Vec<DVec2> = (0..24).map(|i| 2.0 * DVec2::from_angle(TAU * f64::from(i) / 24.0)).collect();
    let drill = geometry::solid::prism(&[&ring], -5.0, 60.0).unwrap();
    let [low, _] = part.walls(0, 0.4, 0.0).unwrap();
    let drills = (0..part.blades).map(|k| {
        let (sin, cos) = (low + 0.5 / at.y + part.pitch() * k as f64).sin_cos();
        drill.mapped(|p| DVec3::new(at.x + p.z, at.y * cos + p.x, at.y * sin + p.y))
    });
    let drills = drills.reduce(|all, one| together(all, &one)).unwrap();
    let solid = geometry::solid::wound(&part.mesh()).unwrap();
    let channel = found(&geometry::solid::difference(&solid, &drills).unwrap());
    let whole = found(&part.mesh());
    assert_eq!((channel.blades, channel.kinds, channel.unlike.len()), (part.blades, 1, 0));
    assert!((channel.throat.width_mm - whole.throat.width_mm).abs() < 2e-3, "{:?} {:?}", channel.throat, whole.throat);
    let off = off_curve(&channel, &part, 0.0);
    assert!(off < 0.05, "{off}");
}

/// Bolts through the blades of a ring: on the circle through them there are twice as many gaps as blades, all even.
#[test]
fn holes_through_the_blades_are_no_channels() {
    let closed =
        ParametricWheel { blades: 15, thickness_mm: 8.0, wrap: [0.4; 2], ..coarse(ParametricWheel::nozzle_ring()) };
    let open = ParametricWheel { shrouded: false, ..closed.clone() };
    for (part, radius, axis) in [(&closed, 1.0, DVec3::Z), (&closed, 2.0, DVec3::ONE), (&open, 2.0, DVec3::Y)] {
        let whole = found(&part.mesh());
        let ring: Vec<DVec2> = (0..24).map(|i| radius * DVec2::from_angle(TAU * f64::from(i) / 24.0)).collect();
        let drill = geometry::solid::prism(&[&ring], -30.0, 40.0).unwrap();
        let [before, behind] = [0, 1].map(|k| part.walls(k, 0.5, 0.5).unwrap());
        let blade = 0.5 * (before[1] + behind[0]);
        let drills = (0..part.blades).map(|k| {
            let (sin, cos) = (blade + part.pitch() * k as f64).sin_cos();
            let middle = part.place(0.5, 0.5).y * DVec3::new(0.0, cos, sin);
            drill.mapped(|p| middle + DVec3::new(p.z, p.x, p.y))
        });
        let drills = drills.reduce(|all, one| together(all, &one)).unwrap();
        let solid = geometry::solid::wound(&part.mesh()).unwrap();
        let turn = DQuat::from_rotation_arc(DVec3::X, axis.normalize());
        let mesh =
            geometry::solid::difference(&solid, &drills).unwrap().mapped(|p| turn * p + DVec3::new(3.0, 4.0, -5.0));
        let channel = found(&mesh);
        assert_eq!((channel.blades, channel.kinds, channel.flow, channel.unlike.len()), (15, 1, Flow::Radial, 0));
        assert_eq!(channel.shrouded, part.shrouded);
        assert!((channel.throat.width_mm - whole.throat.width_mm).abs() < 2e-3, "{:?}", channel.throat);
        assert!(channel.frame.x.dot(axis.normalize()).abs() > 1.0 - 1e-9, "{:?}", channel.frame);
    }
}

/// Cooling holes along the radius, through hub, blades and shroud: between their walls there are twice as many gaps.
#[test]
fn hollow_blades_are_counted_once() {
    let part = TestBlisk { blades: 16, thickness: 6.0, ..Default::default() };
    let whole = found(&part.mesh());
    let ring: Vec<DVec2> = (0..24).map(|i| 1.5 * DVec2::from_angle(TAU * f64::from(i) / 24.0)).collect();
    let drill = geometry::solid::prism(&[&ring], 20.0, 80.0).unwrap();
    let [low, high] = part.wall(7.0, 56.0);
    let blade = 0.5 * (high + low + part.pitch());
    let drills = (0..part.blades).map(|k| {
        let (sin, cos) = (blade + part.pitch() * k as f64).sin_cos();
        drill.mapped(|p| DVec3::new(7.0 + p.x, p.z * cos - p.y * sin, p.z * sin + p.y * cos))
    });
    let drills = drills.reduce(|all, one| together(all, &one)).unwrap();
    let solid = geometry::solid::wound(&part.mesh()).unwrap();
    let channel = found(&geometry::solid::difference(&solid, &drills).unwrap());
    assert_eq!((channel.blades, channel.kinds, channel.flow, channel.unlike.len()), (16, 1, Flow::Axial, 0));
    assert!((channel.throat.width_mm - whole.throat.width_mm).abs() < 2e-3, "{:?}", channel.throat);
}

/// Bolt holes in a long flange, as many as the blades and with more wall than these, where the number is given.
#[test]
fn bolt_holes_of_the_number_that_is_given_are_no_channels() {
    let part = TestBlisk::default();
    let circle = |count: usize, radius: f64, at: DVec2| -> Vec<DVec2> {
        (0..count).map(|i| at + radius * DVec2::from_angle(TAU * i as f64 / count as f64)).collect()
    };
    let reversed = |ring: Vec<DVec2>| ring.into_iter().rev().collect::<Vec<_>>();
    let hole = |k: usize| reversed(circle(24, 3.5, 80.0 * DVec2::from_angle(0.05 + part.pitch() * k as f64)));
    let outer = circle(240, 95.0, DVec2::ZERO);
    let inner = reversed(circle(240, 65.0, DVec2::ZERO));
    let rings: Vec<Vec<DVec2>> = [outer, inner].into_iter().chain((0..part.blades).map(hole)).collect();
    let rings: Vec<&[DVec2]> = rings.iter().map(Vec::as_slice).collect();
    let flange = geometry::solid::prism(&rings, 0.0, 60.0).unwrap().mapped(|p| DVec3::new(p.z, p.x, p.y));
    let mesh = together(part.mesh(), &flange);
    let options = BliskOptions { blades: Auto::Given(part.blades), ..Default::default() };
    let (channel, whole) = (find(&mesh, &options).unwrap(), found(&part.mesh()));
    assert_eq!((channel.blades, channel.unlike.len()), (part.blades, 0));
    assert!((channel.throat.width_mm - whole.throat.width_mm).abs() < 2e-3, "{:?}", channel.throat);
}
