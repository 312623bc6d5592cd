use std::f64::consts::{PI, TAU};
use std::sync::LazyLock;

use glam::{DQuat, DVec2, DVec3, EulerRot};
use proptest::prelude::*;

use super::*;
use crate::channel::{BladeSide, Flow};
use crate::error::Misleading;
use crate::fixtures::{TestBlisk, flange, together, turned_part};
use crate::options::{Auto, AxisChoice, AxisLine, AxisName};
use crate::parametric::wheel::{MeridianCurve, ParametricWheel};
use geometry::exact::ExactMesh;

pub(super) fn find(mesh: &Mesh, options: &BliskOptions) -> Result<Channel, BliskError> {
    find_channel(mesh, options, &Task::default())
}

pub(super) fn found(mesh: &Mesh) -> Channel {
    find(mesh, &BliskOptions::default()).unwrap()
}

pub(super) fn refused(mesh: &Mesh) -> String {
    find(mesh, &BliskOptions::default()).unwrap_err().to_string()
}

/// Pieces about the axis, along the passage and across it: enough for chords of 0.05 mm.
pub(super) const PIECES: [usize; 3] = [112, 36, 4];

/// The wheel in as few facets as do where nothing finer is asked: it is found in a third of the time.
pub(super) fn coarse(wheel: ParametricWheel) -> ParametricWheel {
    ParametricWheel { pieces: PIECES, ..wheel }
}

fn conical() -> TestBlisk {
    TestBlisk { blades: 17, hub: [50.0, 0.15], shroud: [62.0, 0.25], ..Default::default() }
}

/// Greatest distance, around the axis, of a channel's walls from the formulas of its part (mm).
fn greatest_miss(part: &TestBlisk, channel: &Channel) -> f64 {
    let middle = {
        let x = 0.5 * part.chord;
        let [lo, hi] = part.wall(x, 0.5 * (part.hub_at(x) + part.shroud_at(x)));
        0.5 * (lo + hi)
    };
    let miss = |u: usize, v: usize| {
        let (lo, hi) = (channel.low.cylindrical(u, v), channel.high.cylindrical(u, v));
        let exact = part.wall(lo.x, lo.r).map(|theta| theta - middle);
        (lo.theta - exact[0]).abs().max((hi.theta - exact[1]).abs()) * lo.r
    };
    // Next to the edges the nose is vertical: there the angle says nothing about the distance.
    let inner = 4..channel.low.nu - 4;
    inner.flat_map(|u| (0..channel.low.nv).map(move |v| (u, v))).map(|(u, v)| miss(u, v)).fold(0.0, f64::max)
}

#[test]
fn walls_lie_on_the_surface_they_were_made_from() {
    let fine = [96, 8, 8, 2];
    for part in [TestBlisk { grid: fine, ..Default::default() }, TestBlisk { grid: fine, ..conical() }] {
        let channel = found(&part.mesh());
        assert_eq!(channel.blades, part.blades);
        assert!(channel.shrouded);
        // The chord error of 14 mm in 96 steps, the coarsest being 0.23 mm, on a camber of 15 mm radius.
        let miss = greatest_miss(&part, &channel);
        assert!(miss < 0.01, "{miss}");
        let [x0, x1] = channel.span_x();
        assert!(x0.abs() < 1e-6 && (x1 - part.chord).abs() < 1e-6, "{x0} {x1}");
        assert!((channel.faces_x[0] + 3.0).abs() < 1e-9 && (channel.faces_x[1] - part.chord - 3.0).abs() < 1e-9);
    }
}

#[test]
fn end_walls_are_the_greatest_hub_and_the_least_shroud() {
    let part = conical();
    let channel = found(&part.mesh());
    // A chord across the channel in 8 pieces dips by r (1 - cos(pitch / 16)), a skewed one a little more.
    let dip = 1.3 * 65.0 * (1.0 - (part.pitch() / 16.0).cos());
    for s in &channel.meridian {
        let (hub, shroud) = (part.hub_at(s.along), part.shroud_at(s.along));
        assert!(s.hub.y <= hub + 1e-9 && s.hub.y > hub - dip, "{s:?}");
        assert!(s.shroud.y <= shroud + 1e-9 && s.shroud.y > shroud - dip, "{s:?}");
    }
    let ends = [channel.meridian[0].along, channel.meridian[channel.meridian.len() - 1].along];
    assert!((ends[0] + 3.0).abs() < 1e-6 && (ends[1] - 17.0).abs() < 1e-6, "as far as the rings reach: {ends:?}");
    assert!(channel.meridian.is_sorted_by(|a, b| a.along < b.along));
}

#[test]
fn the_hub_is_measured_at_the_corners_of_its_facets() {
    // Facets of 5 degrees, whose middles lie 0.05 mm below their corners.
    let part = TestBlisk { grid: [24, 8, 3, 2], ..Default::default() };
    for s in &found(&part.mesh()).meridian {
        assert!((s.hub.y - 50.0).abs() < 1e-3, "{s:?}");
    }
}

#[test]
fn root_fillets_do_not_lift_the_hub() {
    let part = TestBlisk { fillet: 1.5, twist: 0.0, grid: [32, 32, 24, 2], ..Default::default() };
    let channel = found(&part.mesh());
    for s in &channel.meridian {
        assert!((s.hub.y - 50.0).abs() < 0.02 && (s.shroud.y - 62.0).abs() < 0.02, "{s:?}");
    }
}

/// Blades that lean by 35 and 40 deg, and many near to one another by 29 deg: over the middle of the passage at half its
/// height, and in narrow ones beside the hub, stands a blade.
#[test]
fn blades_that_lean_over_hub_and_shroud_are_not_taken_for_them() {
    let wide = TestBlisk { blades: 48, fillet: 0.6, grid: [24, 24, 8, 2], ..Default::default() };
    let narrow = TestBlisk { blades: 90, thickness: 2.7, fillet: 0.3, ..wide.clone() };
    for (lean, part) in [(0.7, wide.clone()), (0.84, wide), (0.5, narrow)] {
        let part = TestBlisk { twist: lean / 56.0, ..part };
        let channel = found(&part.mesh());
        assert_eq!(channel.blades, part.blades);
        for station in &channel.meridian {
            assert!(
                (station.hub.y - 50.0).abs() < 0.05 && (station.shroud.y - 62.0).abs() < 0.1,
                "{lean}: {station:?}"
            );
        }
    }
}

#[test]
fn normals_point_into_the_channel_and_rows_rise() {
    let channel = found(&conical().mesh());
    for (wall, other) in [(&channel.low, &channel.high), (&channel.high, &channel.low)] {
        let wall_middle = (4..wall.nu - 4).flat_map(|u| (0..wall.nv).map(move |v| (u, v)));
        for (u, v) in wall_middle {
            let across = other.point(u, v) - wall.point(u, v);
            assert!(wall.normal(u, v).dot(across) > 0.0, "{u} {v}");
            assert!((wall.normal(u, v).length() - 1.0).abs() < 1e-12);
        }
        for v in 1..wall.nv {
            assert!((0..wall.nu).all(|u| wall.cylindrical(u, v).r > wall.cylindrical(u, v - 1).r));
        }
        for u in 1..wall.nu {
            assert!((0..wall.nv).all(|v| wall.point(u, v).x > wall.point(u - 1, v).x));
        }
    }
}

#[test]
fn wall_points_lie_on_the_mesh_with_its_normals() {
    let mesh = TestBlisk { shroud: [66.0, -0.1], ..conical() }.mesh();
    let exact = ExactMesh::new(&mesh).unwrap();
    let channel = found(&mesh);
    for wall in [&channel.low, &channel.high] {
        for (p, n) in wall.points.iter().zip(&wall.normals) {
            let nearest = exact.nearest(channel.frame.to_parent(*p));
            assert!(nearest.signed_distance.abs() < 1e-9);
            let just_off = exact.signed_distance(channel.frame.to_parent(*p + 1e-4 * *n));
            assert!((just_off - 1e-4).abs() < 2e-5, "{just_off}");
        }
    }
}

#[test]
fn the_middle_of_the_channel_is_on_z() {
    let part = TestBlisk::default();
    let channel = found(&part.mesh());
    let (u, v) = (channel.low.nu / 2, channel.low.nv / 2);
    let (lo, hi) = (channel.low.cylindrical(u, v), channel.high.cylindrical(u, v));
    assert!((lo.x - 0.5 * part.chord).abs() < 1e-6);
    assert!((lo.theta + hi.theta).abs() < 1e-6, "{lo:?} {hi:?}");
    assert!(lo.theta < 0.0 && hi.theta > 0.0);
}

#[test]
fn turning_and_sides_are_those_of_the_camber_line() {
    for beta in [[0.6, -0.7], [-0.5, 0.4], [0.3, 0.3]] {
        let part = TestBlisk { beta, twist: 0.0, grid: [64, 8, 8, 2], ..Default::default() };
        let channel = found(&part.mesh());
        let turn = beta[1] - beta[0];
        assert!((channel.turning - turn.abs()).abs() < 0.01, "{} {turn}", channel.turning);
        let sides = [channel.low.side, channel.high.side];
        assert_eq!(
            sides,
            match turn {
                t if t < -0.1 => [BladeSide::Suction, BladeSide::Pressure],
                t if t > 0.1 => [BladeSide::Pressure, BladeSide::Suction],
                _ => [BladeSide::Flat, BladeSide::Flat],
            }
        );
    }
}

#[test]
fn the_throat_is_no_wider_than_any_pair_of_wall_points() {
    let channel = found(&conical().mesh());
    let pairs = channel.low.points.iter().flat_map(|p| channel.high.points.iter().map(move |q| (*p - *q).length()));
    let closest = pairs.fold(f64::INFINITY, f64::min);
    let throat = channel.throat;
    assert!(throat.width_mm <= closest && throat.width_mm > 0.95 * closest, "{} {closest}", throat.width_mm);
    assert!(((throat.on_low_wall - throat.on_high_wall).length() - throat.width_mm).abs() < 1e-12);
}

#[test]
fn without_a_shroud_the_tips_bound_the_channel() {
    let part = TestBlisk { shrouded: false, grid: [32, 8, 8, 2], ..Default::default() };
    let channel = found(&part.mesh());
    assert!(!channel.shrouded && channel.blades == part.blades);
    for s in channel.meridian.iter().filter(|s| (1.0..13.0).contains(&s.along)) {
        assert!((s.shroud.y - 62.0).abs() < 0.02, "{s:?}");
    }
    assert!(channel.assumed.iter().any(|a| a.contains("tips")), "{:?}", channel.assumed);
    let points = channel.low.nu * channel.low.nv;
    assert_eq!((channel.low.points.len(), channel.high.normals.len()), (points, points));
}

#[test]
fn channels_are_counted_from_the_reference_direction() {
    let mesh = TestBlisk::default().mesh();
    let pitch = TAU / 24.0;
    let channel = |index| find(&mesh, &BliskOptions { channel: index, ..Default::default() }).unwrap();
    // Angle of the channel's Z from the mesh's Z about its X.
    let angle = |c: &Channel| (-c.frame.z.y).atan2(c.frame.z.z);
    let first = angle(&channel(0));
    assert!(first.abs() <= 0.5 * pitch + 1e-6);
    assert!((angle(&channel(1)) - first - pitch).abs() < 1e-6);
    assert!((angle(&channel(23)) - first + pitch).abs() < 1e-6);
    let error = find(&mesh, &BliskOptions { channel: 24, ..Default::default() }).unwrap_err();
    assert_eq!(error, BliskError::NoSuchChannel { index: 24, blades: 24 });
}

#[test]
fn every_blade_count_is_told() {
    for blades in [5, 6, 7, 12, 13, 31, 47, 60, 90] {
        let radius = 3.0 * blades as f64;
        let part = TestBlisk {
            blades,
            hub: [radius, 0.0],
            shroud: [radius + 9.0, 0.0],
            bore: 0.6 * radius,
            thickness: 2.0,
            grid: [16, 4, 96usize.div_ceil(blades).max(3), 1],
            ..Default::default()
        };
        let channel = found(&part.mesh());
        assert_eq!(channel.blades, blades);
    }
}

#[test]
fn bolt_holes_of_another_count_do_not_win() {
    let part = TestBlisk::default();
    // A flange within the bore, overlapping the hub a little: two shells that make one part.
    let flange = flange(12.0, 31.0, 8, 3.5);
    let channel = found(&together(part.mesh(), &flange));
    assert_eq!(channel.blades, 24);
    assert!((channel.low.cylindrical(0, 0).r - 50.06).abs() < 0.01);
}

#[test]
fn what_is_no_blisk_is_refused_with_the_reason() {
    let bar = [[0.0, 0.0], [10.0, 0.0], [10.0, 30.0], [0.0, 30.0]];
    let ring = bar.map(|[x, r]| [x, r + 20.0]);
    let ball: Vec<[f64; 2]> =
        (0..=40).map(|i| (i as f64 / 40.0 * 0.5 * TAU).sin_cos()).map(|(s, c)| [-20.0 * c, 20.0 * s]).collect();
    for (what, mesh, word) in [
        ("cube", Mesh::cuboid(DVec3::splat(20.0)), "do not face each other"),
        ("ring", turned_part(&ring, 90), "no circle about the axis"),
        ("ball", turned_part(&ball, 90), "no circle about the axis"),
        ("flange", flange(20.0, 60.0, 8, 6.0), "8 gaps, but they are round holes"),
        ("half", TestBlisk::default().sectors(0..12), "covers only about"),
        ("nothing", Mesh::default(), "no triangles"),
    ] {
        let message = refused(&mesh);
        assert!(message.contains(word), "{what}: {message}");
    }
    // Their number makes no channels of holes.
    let numbered = BliskOptions { blades: Auto::Given(8), ..Default::default() };
    let holes = find(&flange(20.0, 60.0, 8, 6.0), &numbered).unwrap_err().to_string();
    assert!(holes.contains("round holes") && !holes.contains("with blisk.blades"), "{holes}");
    let half = find(&TestBlisk::default().sectors(0..12), &BliskOptions::default()).unwrap_err();
    assert!(matches!(half, BliskError::Partial { covered_deg, .. } if (covered_deg - 180.0).abs() < 30.0), "{half}");
}

#[test]
fn broken_meshes_are_refused_without_a_panic() {
    let mut mesh = TestBlisk::default().mesh();
    mesh.vertices[7].y = f64::NAN;
    assert!(refused(&mesh).contains("vertex 7"));
    let mut mesh = TestBlisk::default().mesh();
    mesh.triangles[3][1] = 1 << 30;
    assert!(refused(&mesh).contains("triangle 3"));
    let mut mesh = TestBlisk::default().mesh();
    mesh.vertices[9].y = 1e200;
    assert!(refused(&mesh).contains("vertex 9"));
    let flat = Mesh { vertices: vec![DVec3::ZERO; 3], triangles: vec![[0, 1, 2]] };
    assert!(find(&flat, &BliskOptions::default()).is_err());
    let mut holed = TestBlisk::default().mesh();
    holed.triangles = holed.triangles.into_iter().step_by(2).collect();
    assert!(refused(&holed).contains("not closed"));
}

#[test]
fn an_inside_out_mesh_is_turned_over() {
    let mesh = TestBlisk::default().mesh();
    let inside_out = mesh.turned_over();
    let (right, turned) = (found(&mesh), found(&inside_out));
    assert_eq!(right.low, turned.low);
    assert!(turned.assumed[0].contains("inside out"));
}

#[test]
fn what_is_given_is_used() {
    let part = TestBlisk::default();
    let mesh = part.mesh();
    let base = found(&mesh);
    let line = AxisLine { direction: [-2.0, 0.0, 0.0], point: [5.0, 0.0, 0.0] };
    for axis in [AxisChoice::Line(line), AxisChoice::Named(AxisName::X)] {
        let channel = find(&mesh, &BliskOptions { axis, blades: Auto::Given(24), ..Default::default() }).unwrap();
        let apart = channel.low.points.iter().zip(&base.low.points).map(|(p, q)| (*p - *q).length());
        assert!(apart.fold(0.0, f64::max) < 1e-6);
    }
    let radii = BliskOptions {
        hub_radius_mm: Auto::Given(52.0),
        shroud_radius_mm: Auto::Given(60.0),
        wall_points_chord: 31,
        wall_points_span: 7,
        ..Default::default()
    };
    let channel = find(&mesh, &radii).unwrap();
    assert!(channel.meridian.iter().all(|s| (s.hub.y, s.shroud.y) == (52.0, 60.0)));
    assert_eq!((channel.low.nu, channel.high.nv), (31, 7));
    assert!(channel.assumed.iter().any(|a| a.contains("52 mm")));
    let none = find(&mesh, &BliskOptions { hub_radius_mm: Auto::Given(61.999), ..Default::default() });
    assert!(none.is_err());
}

/// Where the wheel is found without it, what is given by hand is what is wrong.
#[test]
fn what_is_given_and_fits_nothing_is_named() {
    let wrong = [
        (Misleading::Blades, BliskOptions { blades: Auto::Given(23), ..Default::default() }),
        (Misleading::Axis, BliskOptions { axis: AxisChoice::Named(AxisName::Y), ..Default::default() }),
    ];
    let part = TestBlisk::default();
    for (what, options) in wrong {
        match find(&part.mesh(), &options).unwrap_err() {
            BliskError::Misleading { given, blades, axis, at } => {
                assert_eq!((given, blades), (what, part.blades));
                assert!(axis.direction.x > 0.999_999 && (50.0..62.0).contains(&at.y), "{axis} {at}");
            }
            other => panic!("{what:?}: {other}"),
        }
    }
}

#[test]
fn the_answer_does_not_depend_on_the_number_of_threads() {
    let mesh = conical().mesh();
    let with = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap().install(|| found(&mesh));
    assert_eq!(with(1), with(3));
}

/// A part and its channel.
static CONICAL: LazyLock<(Mesh, Channel)> = LazyLock::new(|| {
    let mesh = conical().mesh();
    let channel = found(&mesh);
    (mesh, channel)
});

proptest! {
    #![proptest_config(ProptestConfig::with_cases(8))]

    /// Moving the part moves W with it and leaves the channel as it is, up to which of the equal channels is
    /// number 0 and up to where along the axis the origin lies.
    #[test]
    fn the_channel_moves_with_the_part(
        a in -3.0..3.0f64, b in -1.5..1.5f64, c in -3.0..3.0f64, shift in -200.0..200.0f64,
    ) {
        let (mesh, base) = &*CONICAL;
        let turn = DQuat::from_euler(EulerRot::XYZ, a, b, c);
        let move_point = |p: DVec3| turn * p + DVec3::new(shift, -0.5 * shift, 0.3 * shift);
        let moved = found(&mesh.mapped(move_point));
        prop_assert_eq!(moved.blades, base.blades);
        let flipped = moved.frame.x.dot(turn * base.frame.x) < 0.0;
        let major = moved.frame.x.abs().max_element();
        prop_assert!(moved.frame.x.to_array().contains(&major), "X runs along the positive side: {}", moved.frame.x);
        prop_assert!((moved.throat.width_mm - base.throat.width_mm).abs() < 1e-5);
        prop_assert!((moved.turning - base.turning).abs() < 1e-6);
        // W of the moved part, carried back, is a turn by whole pitches about X and a slide along it away.
        let n = base.low.nu - 1;
        let offset = if flipped { moved.low.point(n, 0).x + base.high.point(0, 0).x } else { moved.low.point(0, 0).x - base.low.point(0, 0).x };
        for u in 0..=n {
            for v in 0..base.low.nv {
                // A part turned end for end has its low and high walls swapped and its edges reversed.
                let expected = if flipped {
                    let p = base.high.point(n - u, v);
                    DVec3::new(offset - p.x, -p.y, p.z)
                } else {
                    base.low.point(u, v) + DVec3::X * offset
                };
                let miss = moved.low.point(u, v) - expected;
                prop_assert!(miss.length() < 1e-6, "{} {} {}", u, v, miss);
            }
        }
        // And the frame puts them onto the moved mesh's own axis.
        let on_axis = moved.frame.from_parent(move_point(DVec3::new(4.0, 0.0, 0.0)));
        prop_assert!(on_axis.y.hypot(on_axis.z) < 1e-6, "{}", on_axis);
    }
}

#[test]
fn the_channel_grows_with_the_part() {
    let mesh = conical().mesh();
    let base = found(&mesh);
    for scale in [25.4, 1.0 / 25.4, 1000.0] {
        let grown = found(&mesh.mapped(|p| p * scale));
        for (small, large) in [(&base.low, &grown.low), (&base.high, &grown.high)] {
            let misses = small.points.iter().zip(&large.points).map(|(p, q)| (*p * scale - *q).length());
            assert!(misses.fold(0.0, f64::max) < 1e-6 * scale);
        }
        assert!((base.throat.width_mm * scale - grown.throat.width_mm).abs() < 1e-6 * scale);
    }
}

/// Greatest difference of the width between the walls, along the circumference, from that of the part (mm).
fn greatest_width_miss(part: &ParametricWheel, channel: &Channel) -> f64 {
    let pitch = TAU / part.blades as f64;
    let miss = |u: usize, v: usize| {
        let (low, high) = (channel.low.cylindrical(u, v), channel.high.cylindrical(u, v));
        let width = (high.theta - low.theta).rem_euclid(TAU) * low.r;
        (width - (pitch * low.r - part.thickness_mm)).abs()
    };
    let inner = 2..channel.low.nu - 2;
    inner.flat_map(|u| (0..channel.low.nv).map(move |v| (u, v))).map(|(u, v)| miss(u, v)).fold(0.0, f64::max)
}

/// A chord of the walls around the axis at `r` dips by this (mm).
fn dip_around(r: f64) -> f64 {
    1.01 * r * (1.0 - (PI / 200.0).cos())
}

#[test]
fn a_passage_along_the_radius_is_found_between_flat_rings() {
    let part = ParametricWheel::nozzle_ring();
    let channel = found(&part.mesh());
    assert_eq!((channel.flow, channel.blades, channel.shrouded), (Flow::Radial, part.blades, true));
    for s in &channel.meridian {
        assert!(s.hub.x.abs() < 1e-6 && (s.shroud.x - 12.0).abs() < 1e-6, "{s:?}");
        assert!((s.hub.y - s.shroud.y).abs() < 1e-6, "lines across a straight passage are square to it: {s:?}");
    }
    let ends = [0, channel.meridian.len() - 1].map(|i| channel.meridian[i].hub.y);
    assert!((ends[0] - 68.0).abs() < dip_around(68.0) && (ends[1] - 104.0).abs() < dip_around(104.0), "{ends:?}");
    // Between circles 0.3 mm apart the blades' chords turn by 1.7 mrad.
    let miss = greatest_width_miss(&part, &channel);
    assert!(miss < 1e-3, "{miss}");
    assert!(channel.agreement.iter().all(|a| a.share == 1.0), "{:?}", channel.agreement);
}

#[test]
fn a_passage_that_turns_from_the_axis_to_the_radius_is_found_between_its_curves() {
    let closed = ParametricWheel::impeller();
    let tips = ParametricWheel { shrouded: false, ..ParametricWheel::impeller() };
    for part in [closed, tips] {
        let channel = found(&part.mesh());
        assert_eq!((channel.flow, channel.blades), (Flow::Mixed, part.blades));
        assert_eq!(channel.shrouded, part.shrouded);
        let center = DVec2::new(-30.0, 70.0);
        // Chords along the arcs in 96 pieces, which are cubic curves, and the beginning of the first blade's row of the
        // lattice at the tips.
        let dip = |radius: f64, r: f64| radius * (1.01 * (1.0 - (PI / 4.0 / 96.0).cos()) + 3e-4) + dip_around(r);
        for s in &channel.meridian {
            assert!((s.hub.distance(center) - 50.0).abs() < dip(50.0, s.hub.y), "{s:?}");
            let is_bladed =
                (channel.low.cylindrical(2, 12).r..channel.low.cylindrical(78, 12).r).contains(&s.place(0.5).y);
            if part.shrouded || is_bladed {
                assert!((s.shroud.distance(center) - 34.0).abs() < dip(34.0, s.shroud.y), "{s:?}");
            }
        }
        let miss = greatest_width_miss(&part, &channel);
        assert!(miss < 0.02, "{miss}");
        let rises = |v: usize| {
            (1..channel.low.nu).all(|u| channel.low.cylindrical(u, v).r > channel.low.cylindrical(u - 1, v).r)
        };
        assert!((0..channel.low.nv).all(rises), "from the eye to the rim");
    }
}

#[test]
fn only_a_passage_along_the_axis_is_bounded_by_one_radius() {
    let options = BliskOptions { hub_radius_mm: Auto::Given(70.0), ..Default::default() };
    let error = find(&ParametricWheel::nozzle_ring().mesh(), &options).unwrap_err();
    assert_eq!(error, BliskError::NotAxial { key: "hub_radius_mm" });
}

/// Points of the low (0) or the high wall (1) of the passage above blade `k` as it is drawn.
pub(super) fn drawn_wall(part: &ParametricWheel, k: usize, side: usize) -> Vec<DVec3> {
    const PIECES: [usize; 2] = [400, 20];
    let share = |i: usize, of: usize| i as f64 / PIECES[of] as f64;
    let places = (0..=PIECES[0]).flat_map(|i| (0..=PIECES[1]).map(move |j| (share(i, 0), share(j, 1))));
    let point = |(along, height): (f64, f64)| {
        let at = part.place(along, height);
        Some(Cylindrical { x: at.x, r: at.y, theta: part.walls(k, along, height)?[side] }.point())
    };
    places.filter_map(point).collect()
}

pub(super) fn least_distance(some: &[DVec3], others: &[DVec3]) -> f64 {
    let pairs = some.iter().flat_map(|p| others.iter().map(move |q| p.distance_squared(*q)));
    pairs.fold(f64::INFINITY, f64::min).sqrt()
}

/// Where a swept edge meets the hub, the fillet that goes round it stands ahead of the blade, and the tips run along the
/// edge and then along the fillet. The passage keeps the height of the tips ahead of them.
#[test]
fn blades_with_swept_edges_and_fillets_round_them_are_recognised() {
    for (blades, tip, sweep) in [(3, 34.0, 3.0), (3, 24.0, 3.0), (7, 34.0, 2.0)] {
        let at = DVec2::new;
        let part = ParametricWheel {
            blades,
            hub: MeridianCurve::line(at(-4.5, 11.7), at(34.5, 14.3)),
            shroud: MeridianCurve::line(at(-4.5 + sweep, tip), at(34.5 - sweep, tip)),
            shrouded: false,
            span: [4.5 / 39.0, 34.5 / 39.0],
            wrap: [1.3; 2],
            edge_thickness: 0.5,
            nose: 0.1,
            fillet_mm: 1.5,
            fillets_round_edges: true,
            pieces: [240, 60, 12],
            ..ParametricWheel::nozzle_ring()
        };
        let channel = found(&part.mesh());
        assert_eq!((channel.blades, channel.flow, channel.shrouded), (blades, Flow::Axial, false));
        let bare = ParametricWheel { fillet_mm: 0.0, ..part.clone() };
        let drawn = least_distance(&drawn_wall(&bare, 0, 0), &drawn_wall(&bare, 0, 1));
        let throat = channel.throat.width_mm;
        assert!((throat / drawn - 1.0).abs() < 0.004, "{blades} blades: {throat} of {drawn}");
        for s in &channel.meridian {
            assert!((s.shroud.y - tip).abs() < 0.01 * tip, "{blades} blades: {s:?}");
        }
    }
}

/// Where a blade has lost its outer part, circles through that part meet one gap less.
#[test]
fn a_broken_blade_is_told_and_a_passage_away_from_it_found() {
    let part = ParametricWheel { shrouded: false, thickness_mm: 4.0, ..ParametricWheel::impeller() };
    let broken_off = [0, 1, 2, 3].map(|i| part.hub.0[i].lerp(part.shroud.0[i], 0.6));
    let stump = ParametricWheel { shroud: MeridianCurve(broken_off), ..part.clone() }.blade(4);
    let blades = (0..part.blades).filter(|k| *k != 4).map(|k| part.blade(k)).chain([stump]);
    let channel = found(&blades.fold(part.wall(0.0), |all, one| together(all, &one)));
    let whole = found(&part.mesh());
    assert_eq!((channel.blades, channel.kinds, channel.unlike.len()), (part.blades, 1, 2));
    assert!((channel.throat.width_mm - whole.throat.width_mm).abs() < 0.01, "{:?}", channel.throat);
    assert!(channel.assumed.iter().any(|s| s.contains("broken or missing")), "{:?}", channel.assumed);
}
