//! Wheels that lack something or have too much, several in one mesh, and parts that are none.

use std::f64::consts::TAU;

use super::sentences::{SCREW, STRAIGHT};
use super::*;
use crate::fixtures::together;
use crate::options::AxisLine;
use crate::parametric::wheel::{Flaws, MeridianCurve, ParametricWheel, Splitters};
use geometry::solid::prism;
use glam::{DMat3, DVec3, Vec3Swizzles as _};

/// Teeth of the gears.
const TEETH: usize = 20;

fn find(mesh: &Mesh, options: &BliskOptions) -> Result<Channel, Refused> {
    // Few points of walls are enough to tell what is wrong.
    let options = BliskOptions { wall_points_chord: 41, wall_points_span: 9, ..options.clone() };
    find_or_refuse(mesh, &options, &Task::default())
}

/// An axial wheel of few facets.
fn axial() -> ParametricWheel {
    let line = |r: f64| MeridianCurve::line(DVec2::new(0.0, r), DVec2::new(30.0, r));
    ParametricWheel {
        blades: 12,
        hub: line(40.0),
        shroud: line(52.0),
        wrap: [0.4; 2],
        pieces: [96, 24, 4],
        ..ParametricWheel::nozzle_ring()
    }
}

#[test]
fn one_of_two_wheels_in_a_mesh_is_chosen_by_its_axis() {
    let wheel = axial();
    let point = [0.0, 90.0, 90.0];
    let beside = together(wheel.mesh(), &wheel.mesh().mapped(|p| p + DVec3::from(point)));
    let refused = find(&beside, &BliskOptions::default()).unwrap_err();
    assert!(matches!(refused.error, BliskError::Bodies { count: 2, wheels: 2, blades: 12, .. }), "{refused}");
    let axis = AxisChoice::Line(AxisLine { direction: [1.0, 0.0, 0.0], point });
    let second = find(&beside, &BliskOptions { axis, ..Default::default() }).unwrap();
    assert!(second.assumed.iter().any(|said| said.contains("2 bodies apart")), "{:?}", second.assumed);
}

/// What stands straight may be blades, or teeth and spokes.
#[test]
fn straight_blades_and_teeth_are_told() {
    let tooth = [[18.0, -0.36], [23.0, -0.14], [23.0, 0.14], [18.0, 0.36]];
    let corners = (0..TEETH).flat_map(|k| tooth.map(|[r, at]| (r, TAU * (k as f64 + at) / TEETH as f64)));
    let outline: Vec<DVec2> = corners.map(|(r, theta)| r * DVec2::from_angle(theta)).collect();
    let gear = prism(&[&outline], 0.0, 15.0).unwrap().mapped(|p| DVec3::new(p.z, p.x, p.y));
    let vanes = ParametricWheel { wrap: [0.0; 2], ..axial() };
    for mesh in [gear, vanes.mesh()] {
        let channel = find(&mesh, &BliskOptions::default()).unwrap();
        assert!(channel.assumed.iter().any(|said| said == STRAIGHT), "{:?}", channel.assumed);
    }
}

/// Plates of one lead are a screw; those that turn further behind than in front are blades.
#[test]
fn blades_that_are_wound_by_one_lead_are_told() {
    for (wrap, is_screw) in [([0.4; 2], true), ([0.1, 0.7], false)] {
        let channel = find(&ParametricWheel { wrap, ..axial() }.mesh(), &BliskOptions::default()).unwrap();
        assert_eq!(channel.assumed.iter().any(|said| said == SCREW), is_screw, "{:?}", channel.assumed);
    }
    let demonstration = find(&ParametricWheel::demonstration().mesh(), &BliskOptions::default()).unwrap();
    assert!(!demonstration.assumed.iter().any(|said| said == SCREW), "{:?}", demonstration.assumed);
}

/// A hole in a blade three pitches away leaves the passage as it is, and that beside it is refused for it.
#[test]
fn missing_triangles_spoil_only_the_passage_beside_them() {
    let ring = ParametricWheel { thickness_mm: 6.0, pieces: [100, 32, 8], ..ParametricWheel::nozzle_ring() };
    let find = |mesh: &Mesh, options: &BliskOptions| find_or_refuse(mesh, options, &Task::default());
    let whole = find(&ring.mesh(), &BliskOptions::default()).unwrap();
    let middle = whole.frame.to_parent(whole.low.point(whole.low.nu / 2, whole.low.nv / 2));
    let hole = DMat3::from_rotation_x(3.0 * ring.pitch()) * middle;
    let mut open = ring.mesh();
    let vertices = open.vertices.clone();
    let off = |t: &[u32; 3]| t.iter().map(|v| vertices[*v as usize]).sum::<DVec3>().distance(3.0 * hole);
    open.triangles.sort_by(|a, b| off(a).total_cmp(&off(b)));
    open.triangles.drain(..24);
    let channel = find(&open, &BliskOptions::default()).unwrap();
    assert!(
        (channel.throat.width_mm - whole.throat.width_mm).abs() < 1e-6,
        "{} {}",
        channel.throat.width_mm,
        whole.throat.width_mm
    );
    assert_eq!(channel.unlike.iter().map(|unlike| unlike.number).collect::<Vec<_>>(), [3], "{:?}", channel.unlike);
    let refused = find(&open, &BliskOptions { channel: 3, ..Default::default() }).unwrap_err();
    assert!(matches!(refused.error, BliskError::Spoilt { closed: false, other: Some(_), .. }), "{refused}");
    let place = |p: DVec3| DVec2::new(p.x, p.yz().length());
    assert!(place(refused.at.unwrap()).distance(place(hole)) < 4.0, "{refused}");
}

/// Without one splitter of the second kind, the others of that kind are not counted.
#[test]
fn blades_that_are_not_counted_are_told() {
    let splitters = vec![Splitters::over([0.35, 0.9]), Splitters::over([0.6, 0.9])];
    let wheel = ParametricWheel { splitters, thickness_mm: 1.5, ..axial() };
    let tells = |flaws: Flaws| match find(&ParametricWheel { flaws, ..wheel.clone() }.mesh(), &BliskOptions::default())
    {
        Ok(channel) => (channel.blades, channel.assumed.iter().any(|said| said.contains("crosses 11 gaps"))),
        Err(refused) => panic!("{refused}"),
    };
    assert_eq!(tells(Flaws::default()), (12, false));
    assert_eq!(tells(Flaws { missing_blades: vec![5], ..Flaws::default() }), (8, true));
}

/// Something stands in the mouth of the chosen passage alone.
#[test]
fn the_odd_passage_is_told_from_those_that_are_alike() {
    let ring = ParametricWheel { pieces: [100, 32, 8], ..ParametricWheel::nozzle_ring() };
    let whole = find(&ring.mesh(), &BliskOptions::default()).unwrap();
    let [low, high] = [&whole.low, &whole.high].map(|wall| wall.point(wall.nu - 1, wall.nv / 2));
    // Beyond both edges, within the rings.
    let mouth = 0.5 * (low + high);
    let mouth = whole.frame.to_parent(mouth.with_x(0.0).normalize() * 102.5 + DVec3::X * mouth.x);
    let lump = Mesh::cuboid(DVec3::splat(2.0)).mapped(|p| p - DVec3::splat(1.0) + mouth);
    let channel = find(&together(ring.mesh(), &lump), &BliskOptions::default()).unwrap();
    assert!(channel.assumed.iter().any(|said| said.starts_with("Channel 0 is the odd one")), "{:?}", channel.assumed);
    let other = find(&together(ring.mesh(), &lump), &BliskOptions { channel: 10, ..Default::default() }).unwrap();
    assert!(other.unlike.iter().any(|unlike| unlike.number == 0), "{:?}", other.unlike);
}

/// What is not found about the likeliest axis is not taken for something about another.
#[test]
fn spoilt_wheels_are_refused_about_their_own_axis() {
    let oval = axial().mesh().mapped(|p| DVec3::new(p.x, 1.04 * p.y, p.z));
    let gaps = ParametricWheel { flaws: Flaws { missing_blades: (0..5).collect(), ..Default::default() }, ..axial() };
    for mesh in [oval, gaps.mesh()] {
        let refused = find(&mesh, &BliskOptions::default()).unwrap_err();
        let axis = refused.error.axis().unwrap_or_else(|| panic!("{refused}"));
        assert!(axis.direction.cross(DVec3::X).length() < 0.01 && axis.distance(DVec3::ZERO) < 2.0, "{refused}");
    }
}
