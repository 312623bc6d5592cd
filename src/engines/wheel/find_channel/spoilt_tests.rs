//! Wheels that lack something or have too much, several in one mesh, and parts that are none.

use std::f64::consts::TAU;

use super::*;
use crate::fixtures::together;
use crate::options::AxisLine;
use crate::parametric::wheel::{MeridianCurve, ParametricWheel};
use geometry::solid::prism;
use glam::DVec3;

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
    const TEETH: usize = 20;
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
