use glam::DVec2;

use super::wheel::{MeridianCurve, ParametricWheel};
use crate::channel::Flow;
use crate::find_channel::find_channel;
use crate::options::BliskOptions;
use task::Task;

/// Angle of a blade's camber line off the axis at mid-height (deg), from the walls on its two sides.
fn angle_deg(wheel: &ParametricWheel, along: f64) -> f64 {
    let h = 1e-4;
    let camber = |t: f64| {
        let [[_, below], [above, _]] = [0, 1].map(|k| wheel.walls(k, t, 0.5).unwrap());
        0.5 * (below + above)
    };
    let [from, to] = [along - h, along + h].map(|t| (wheel.place(t, 0.5), camber(t)));
    let around = wheel.place(along, 0.5).y * (to.1 - from.1);
    around.atan2(to.0.distance(from.0)).to_degrees()
}

#[test]
fn the_demonstration_is_recognised_and_turns_as_it_says() {
    let wheel = ParametricWheel::demonstration();
    let mesh = wheel.mesh();
    assert!(mesh.is_watertight());
    assert!((50_000..=100_000).contains(&mesh.triangles.len()), "{}", mesh.triangles.len());
    let [inlet, outlet] = [wheel.span[0] + 1e-3, wheel.span[1] - 1e-3].map(|t| angle_deg(&wheel, t));
    assert!((inlet - 30.0).abs() < 1.0 && (outlet + 40.0).abs() < 1.0, "{inlet} {outlet}");

    let channel = find_channel(&mesh, &BliskOptions::default(), &Task::default()).unwrap();
    assert_eq!((channel.flow, channel.blades, channel.shrouded, channel.kinds), (Flow::Axial, 44, true, 1));
    let [from, to] = channel.span_x();
    let edges = wheel.span.map(|t| wheel.place(t, 0.5).x);
    assert!((from - edges[0]).abs() < 0.1 && (to - edges[1]).abs() < 0.1, "{from} {to}, {edges:?}");
}

#[test]
fn equal_rates_wind_evenly_and_unequal_ones_by_their_mean_over_the_whole_passage() {
    let line = |r| MeridianCurve::line(DVec2::new(0.0, r), DVec2::new(20.0, r));
    let base =
        ParametricWheel { hub: line(50.0), shroud: line(60.0), span: [0.0, 1.0], ..ParametricWheel::nozzle_ring() };
    let winds = |wrap, t: f64| {
        let wheel = ParametricWheel { wrap, ..base.clone() };
        wheel.walls(0, t, 0.5).unwrap()[0] - wheel.walls(0, 0.0, 0.5).unwrap()[0]
    };
    for t in [0.25, 0.5, 1.0] {
        assert!((winds([0.4; 2], t) - 0.4 * t).abs() < 1e-12);
    }
    assert!((winds([0.6, -0.2], 1.0) - 0.2).abs() < 1e-12);
    assert!((winds([0.6, -0.2], 0.75) - 0.225).abs() < 1e-12, "farthest where the rate is none");
}

#[test]
fn a_blade_is_as_thick_at_its_edges_as_its_share_says() {
    let wheel = ParametricWheel { edge_thickness: 0.4, ..ParametricWheel::nozzle_ring() };
    let thickness = |t: f64| {
        let [[_, below], [above, _]] = [0, 1].map(|k| wheel.walls(k, t, 0.5).unwrap());
        (above - below) * wheel.place(t, 0.5).y
    };
    assert!((thickness(0.5) - wheel.thickness_mm).abs() < 1e-9);
    for t in wheel.span {
        assert!((thickness(t) - 0.4 * wheel.thickness_mm).abs() < 1e-9);
    }
}
