use std::f64::consts::PI;

use glam::{DMat3, DVec3};
use proptest::prelude::*;

use super::*;
use geometry::frame::Cylindrical;

fn blisks() -> impl Strategy<Value = ParametricBlisk> {
    let shape = (24..50usize, 20.0..45.0f64, -50.0..-20.0f64, -0.15..0.15f64, -0.15..0.15f64);
    let blade = (-8.0..8.0f64, -5.0..5.0f64, 0.0..0.15f64, any::<bool>());
    (shape, blade).prop_map(|((blades, beta_in, beta_out, hub, shroud), (twist, lean, taper, shrouded))| {
        ParametricBlisk {
            blades,
            hub_radius_mm: 90.0,
            shroud_radius_mm: 110.0,
            hub_slope: hub,
            shroud_slope: shroud,
            beta_in_deg: beta_in,
            beta_out_deg: beta_out,
            twist_deg: twist,
            lean_deg: lean,
            taper,
            shrouded,
            ..ParametricBlisk::default()
        }
    })
}

/// Volume by Pappus and by integrating the thickness of the blades, for cylindrical walls without taper.
fn analytic_volume(blisk: &ParametricBlisk) -> f64 {
    let ring = |inner: f64, outer: f64| PI * (outer * outer - inner * inner) * blisk.width_mm;
    let steps = 20_000;
    let profile = blisk.profile(0.5 * (blisk.hub_radius_mm + blisk.shroud_radius_mm));
    let dx = blisk.chord_mm / f64::from(steps);
    let area: f64 =
        (0..steps).map(|i| (f64::from(i) + 0.5) * dx).map(|x| (profile.upper_y(x) - profile.lower_y(x)) * dx).sum();
    let blades = blisk.blades as f64 * area * (blisk.shroud_radius_mm - blisk.hub_radius_mm);
    let shroud = if blisk.shrouded { ring(blisk.shroud_radius_mm, blisk.outer_radius()) } else { 0.0 };
    ring(blisk.bore_radius_mm, blisk.hub_radius_mm) + shroud + blades
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    #[test]
    fn every_blisk_is_closed_and_holds_its_own_walls(blisk in blisks(), along in 0.0..1.0f64, v in 0.02..0.98f64) {
        let mesh = blisk.mesh(&MeshResolution::default()).unwrap();
        prop_assert!(mesh.is_watertight());
        let finer = blisk.mesh(&MeshResolution { pitch: 5, chord: 30, ..MeshResolution::default() }).unwrap();
        prop_assert!((mesh.volume() / finer.volume() - 1.0).abs() < 8e-3, "{} {}", mesh.volume(), finer.volume());
        let (hub, tip) = blisk.radii(10.0);
        let r = hub + v * (tip - hub);
        let x = blisk.x_le(r) + along * (blisk.x_te(r) - blisk.x_le(r));
        let (hub, tip) = blisk.radii(x);
        prop_assume!(r > hub + 0.2 && r < tip - 0.2);
        let exact = geometry::exact::ExactMesh::new(&mesh).unwrap();
        for side in [ChannelSide::Low, ChannelSide::High] {
            let theta = blisk.wall_theta(side, x, r);
            let on_wall = exact.signed_distance(Cylindrical { x, r, theta }.point());
            prop_assert!(on_wall.abs() < 0.05, "{side:?}: {on_wall}");
        }
        let middle = 0.5 * (blisk.wall_theta(ChannelSide::Low, x, r) + blisk.wall_theta(ChannelSide::High, x, r));
        prop_assert!(exact.signed_distance(Cylindrical { x, r, theta: middle }.point()) > 0.0, "the channel is free");
        let in_blade = blisk.wall_theta(ChannelSide::High, x, r) + 1e-3;
        prop_assume!(along > 0.2 && along < 0.8);
        prop_assert!(exact.signed_distance(Cylindrical { x, r, theta: in_blade }.point()) < 0.0, "the blade is not");
    }
}

#[test]
fn volume_is_that_of_rings_and_blades() {
    for shrouded in [true, false] {
        let blisk = ParametricBlisk { shrouded, twist_deg: 0.0, ..ParametricBlisk::default() };
        let mesh = blisk.mesh(&MeshResolution { pitch: 6, ..MeshResolution::default() }).unwrap();
        assert!(mesh.is_watertight());
        let ratio = mesh.volume() / analytic_volume(&blisk);
        assert!((ratio - 1.0).abs() < 5e-4, "shrouded {shrouded}: {ratio}");
    }
}

#[test]
fn turning_by_one_pitch_changes_nothing() {
    let blisk = ParametricBlisk::turbine();
    let mesh = blisk.mesh(&MeshResolution::default()).unwrap();
    let turn = DMat3::from_rotation_x(blisk.pitch());
    let key = |p: DVec3| [p.x, p.y, p.z].map(|c| (c * 1e6).round() as i64);
    let mut before: Vec<_> = mesh.vertices.iter().map(|&p| key(p)).collect();
    before.sort_unstable();
    for &p in mesh.vertices.iter().step_by(37) {
        let [x, y, z] = key(turn * p);
        let near = |d: [i64; 3]| before.binary_search(&[x + d[0], y + d[1], z + d[2]]).is_ok();
        let offsets = (0..27).map(|i| [i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1]);
        assert!(offsets.into_iter().any(near), "{p}");
    }
}

#[test]
fn the_turbine_is_a_blisk_of_a_handy_size() {
    let mesh = ParametricBlisk::turbine().mesh(&MeshResolution::default()).unwrap();
    assert!(mesh.is_watertight() && mesh.volume() > 0.0);
    assert!((40_000..=60_000).contains(&mesh.triangles.len()), "{}", mesh.triangles.len());
}

#[test]
fn the_walls_meet_in_the_edges_of_the_blades() {
    let blisk = ParametricBlisk::turbine();
    let r = 104.0;
    for x in [blisk.x_le(r), blisk.x_te(r)] {
        let low = blisk.wall_theta(ChannelSide::Low, x, r);
        let high = blisk.wall_theta(ChannelSide::High, x, r);
        assert!((high - low - blisk.pitch()).abs() < 1e-9, "the edge of one blade, a pitch apart");
    }
    assert_eq!(blisk.blade_side(ChannelSide::Low), BladeSide::Suction);
    assert_eq!(blisk.blade_side(ChannelSide::High), BladeSide::Pressure);
}

#[test]
fn what_cannot_be_built_is_refused_in_words() {
    let base = ParametricBlisk::default;
    let cases = [
        (ParametricBlisk { blades: 300, ..base() }, "fewer blades"),
        (
            ParametricBlisk { max_thickness_mm: 0.15, wedge_in_deg: 0.0, wedge_out_deg: 0.0, ..base() },
            "max_thickness_mm",
        ),
        (ParametricBlisk { shroud_radius_mm: 100.0, ..base() }, "above the hub"),
        (ParametricBlisk { bore_radius_mm: 120.0, ..base() }, "bore_radius_mm"),
        (ParametricBlisk { width_mm: 19.0, ..base() }, "width_mm"),
        (ParametricBlisk { beta_in_deg: 89.0, ..base() }, "beta_in_deg"),
        (ParametricBlisk { chord_mm: f64::NAN, ..base() }, "chord_mm"),
    ];
    for (blisk, expected) in cases {
        let message = blisk.mesh(&MeshResolution::default()).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    }
    let none = MeshResolution { pitch: 0, ..MeshResolution::default() };
    assert!(base().mesh(&none).unwrap_err().to_string().contains("pitch is 0"));
}
