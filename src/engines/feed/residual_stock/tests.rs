use std::sync::{Arc, LazyLock};

use super::*;
use crate::copying::{Copying, CopyingExtent, CopyingMotion, CopyingSettings, copying_motion};
use crate::machine::{AxisSet, MachineParams};
use crate::verify::{Verifier, VerifyOptions};
use geometry::exact::ExactMesh;
use geometry::frame::Cylindrical;
use geometry::mesh::normal_times_two_areas;
use glam::DVec2;
use wheel::electrode::{ElectrodeParams, EntrySide, make_electrodes};
use wheel::find_channel::find_channel;
use wheel::fixtures::{exact_channel, together, turned_part};
use wheel::options::{Auto, BliskOptions};
use wheel::parametric::wheel::{MeridianCurve, ParametricWheel};
use wheel::parametric::{MeshResolution, ParametricBlisk};

const GAP: f64 = 0.1;
/// Facets of blisk and electrode, the field's error and the resolution (mm).
const ERROR: f64 = 0.015;

struct Part {
    mesh: Mesh,
    exact: ExactMesh,
    channel: Arc<Channel>,
    finder: SurfaceFinder,
}

/// A blisk of little turning without fillets, finely meshed.
static PART: LazyLock<Part> = LazyLock::new(|| {
    let blisk = ParametricBlisk {
        blades: 40,
        hub_radius_mm: 90.0,
        shroud_radius_mm: 100.0,
        beta_in_deg: 20.0,
        beta_out_deg: -25.0,
        chord_mm: 14.0,
        width_mm: 18.0,
        ..ParametricBlisk::default()
    };
    let mesh = blisk.mesh(&MeshResolution { edge: 8, chord: 40, span: 6, pitch: 20, ring: 2 }).unwrap();
    let channel = Arc::new(exact_channel(&blisk));
    let finder = SurfaceFinder::new(channel.clone()).unwrap();
    Part { exact: ExactMesh::new(&mesh).unwrap(), mesh, channel, finder }
});

fn site() -> Site<'static> {
    let junctions = Junctions::default();
    let blank = Blank::Full;
    Site {
        blisk: &PART.mesh,
        channel: &PART.channel,
        finder: &PART.finder,
        spark_gap: GAP,
        junctions,
        proven: None,
        blank,
    }
}

fn unreduced() -> ElectrodeParams {
    ElectrodeParams {
        spark_gap_mm: GAP,
        circumferential_reduction_deg: [0.0; 2],
        radial_reduction_mm: 0.0,
        ..Default::default()
    }
}

fn make(params: &ElectrodeParams) -> Vec<Electrode> {
    let task = Task::default();
    make_electrodes(&PART.channel, &PART.exact, params, EntrySide::MinusX, &task).unwrap()
}

fn left_by(burns: &[Burn]) -> ResidualStock {
    residual_stock(&site(), burns, &Task::default()).unwrap()
}

fn standing(electrodes: &[Electrode]) -> ResidualStock {
    let burn = |electrode| Burn { electrode, spark_gap: GAP, feed: Vec::new(), copying: Vec::new() };
    left_by(&electrodes.iter().map(burn).collect::<Vec<_>>())
}

/// Residual stock of electrodes made with `params`, sampled closely where they meet.
fn divided(params: &ElectrodeParams) -> ResidualStock {
    let electrodes = make(params);
    assert!(electrodes.iter().all(|e| e.mesh.is_watertight()) && electrodes.len() == params.count());
    let burns: Vec<_> = electrodes
        .iter()
        .map(|electrode| Burn { electrode, spark_gap: GAP, feed: Vec::new(), copying: Vec::new() })
        .collect();
    let site = Site { junctions: Junctions::of(&PART.channel, params).unwrap(), ..site() };
    residual_stock(&site, &burns, &Task::default()).unwrap()
}

/// Greatest deviation of the vertices near a surface that tells how far a point lies from it, away from hub, shroud
/// and the blades' edges.
fn ridge(found: &ResidualStock, surfaces: [Surface; 2], off: impl Fn(DVec3) -> f64, near: f64) -> f64 {
    let map = &found.map;
    let mine = map.mesh.triangles.iter().zip(&map.surfaces).filter(|(_, s)| surfaces.contains(s));
    mine.flat_map(|(t, _)| t)
        .map(|&v| (map.mesh.vertices[v as usize], f64::from(map.deviation[v as usize])))
        .filter(|(p, _)| off(*p).abs() < near && (2.0..12.0).contains(&p.x))
        .map(|(_, d)| d)
        .fold(f64::NEG_INFINITY, f64::max)
}

/// An electrode that stands a gap and a stock away from the surface and burns in that gap leaves the stock; one that burns
/// after it takes that away, and no more than that is left for it.
#[test]
fn a_stage_leaves_its_stock_for_the_next_one() {
    const STOCK: f64 = 0.15;
    let wide = ElectrodeParams { spark_gap_mm: 2.0 * GAP + STOCK, ..unreduced() };
    let (rough, finish) = (make(&wide), make(&unreduced()));
    // A longer way straight through a curved channel would cut into its walls.
    let burn = |electrode, spark_gap| Burn { electrode, spark_gap, feed: straight(0.01), copying: Vec::new() };
    let left = left_by(&[burn(&rough[0], 2.0 * GAP)]);
    // Away from the corners, from which the edges of the electrode stay farther away.
    let is_inner = |p: &DVec3| (91.0..99.0).contains(&p.y.hypot(p.z)) && (2.0..12.0).contains(&p.x);
    let places = left.map.mesh.vertices.iter().zip(left.map.deviation.iter());
    let inner: Vec<f64> = places.filter(|(p, _)| is_inner(p)).map(|(_, d)| f64::from(*d)).collect();
    assert!(inner.len() > 100 && inner.iter().all(|d| (d - STOCK).abs() < ERROR), "{inner:?}");
    assert_eq!(left.deepest(), None);
    let both = left_by(&[burn(&rough[0], 2.0 * GAP), burn(&finish[0], GAP)]);
    assert_eq!((both.thickest(), both.deepest()), (left_by(&[burn(&finish[0], GAP)]).thickest(), None));
    let volume = |pieces: &[Piece]| pieces.iter().map(|piece| piece.volume_mm3).sum::<f64>();
    let area: f64 = left.surfaces.iter().map(|surface| surface.area_mm2).sum();
    let (layer, removed) = (STOCK * area, volume(&both.removed[1]));
    assert!((0.85..1.15).contains(&(removed / layer)), "{removed} mm3 for a layer of {layer} mm3");
}

#[test]
fn burns_that_only_meet_leave_a_ridge_and_none_where_they_overlap() {
    // Two edges, each a gap before the plane where the burns meet and a gap off the wall: the point of the wall
    // in that plane is sqrt(2) gaps from both.
    let left = (2f64.sqrt() - 1.0) * GAP;
    let walls = [Surface::LowWall, Surface::HighWall];
    let parts = |overlap_mm| ElectrodeParams { parts: 2, overlap_mm, ..unreduced() };
    let plane = Junctions::of(&PART.channel, &parts(0.0)).unwrap().planes[0];
    let on_wall = |p: DVec3| if (90.6..99.4).contains(&p.y.hypot(p.z)) { p.x - plane } else { f64::INFINITY };
    let meeting = ridge(&divided(&parts(0.0)), walls, on_wall, 0.05);
    // Where the channel is at an angle to X one of the edges is the sharper.
    assert!((left - ERROR..1.3 * left + ERROR).contains(&meeting), "{meeting} {left}");
    assert!(meeting > TOLERANCE);
    let overlapping = ridge(&divided(&parts(ElectrodeParams::default().overlap_mm)), walls, on_wall, 0.8);
    assert!(overlapping < ERROR, "{overlapping}");

    let columns = |column_overlap_mm| ElectrodeParams {
        columns: 2,
        column_overlap_mm,
        column_split: Auto::Given(0.5),
        ..unreduced()
    };
    let passage = Passage::new(&PART.channel).unwrap();
    let off = |p: DVec3| passage.beyond_split(p, 0.5);
    let ends = [Surface::Hub, Surface::Shroud];
    let meeting = ridge(&divided(&columns(0.0)), ends, off, 0.05);
    assert!((left - ERROR..1.3 * left + ERROR).contains(&meeting), "{meeting} {left}");
    let overlapping = ridge(&divided(&columns(ElectrodeParams::default().column_overlap_mm)), ends, off, 0.8);
    assert!(overlapping < ERROR, "{overlapping}");
}

fn motion(electrode: &Electrode, params: &ElectrodeParams, axes: AxisSet) -> Copying {
    let (verify, machine) = (VerifyOptions::default(), MachineParams { axes, ..Default::default() });
    let settings = CopyingSettings {
        machine: &machine,
        verify: &verify,
        spark_gap: GAP,
        frame: PART.channel.frame,
        outwards: DVec3::Z,
    };
    let task = Task::default();
    let verifier = Verifier::new(&PART.mesh, &electrode.mesh, electrode.reference_point, &task.cancel).unwrap();
    let verifier = verifier.within(machine.limits());
    let wanted = CopyingExtent::of(electrode, params, 0.0);
    let surface_of = |p: DVec3| PART.finder.surface_of(p);
    copying_motion(electrode, &verifier, wanted, &settings, &surface_of, &task).unwrap()
}

fn made(copying: Copying) -> CopyingMotion {
    match copying {
        Copying::Made(motion) => *motion,
        other => panic!("{other:?}"),
    }
}

/// Vertices on walls, away from hub, shroud and the blades' edges, with their deviation and whether on the low wall.
fn on_walls(found: &ResidualStock) -> Vec<(DVec3, f64, bool)> {
    let map = &found.map;
    let mut seen = vec![None; map.mesh.vertices.len()];
    for (triangle, surface) in map.mesh.triangles.iter().zip(&map.surfaces) {
        triangle.iter().for_each(|&v| seen[v as usize] = Some(*surface));
    }
    let walls = [Surface::LowWall, Surface::HighWall];
    (0..seen.len())
        .filter(|&v| seen[v].is_some_and(|s| walls.contains(&s)))
        .map(|v| (map.mesh.vertices[v], f64::from(map.deviation[v]), seen[v] == Some(Surface::LowWall)))
        .filter(|(p, ..)| (2.0..12.0).contains(&p.x) && (90.6..99.4).contains(&p.y.hypot(p.z)))
        .collect()
}

#[test]
fn an_unreduced_electrode_leaves_no_more_than_the_rounding_of_corners() {
    let found = standing(&make(&unreduced()));
    let walls = on_walls(&found);
    assert!(walls.len() > 500, "{}", walls.len());
    for (p, d, _) in walls {
        assert!(d.abs() < ERROR, "{p}: {d}");
    }
    // A corner of two walls at the angle phi is rounded by gap / sin(phi / 2) - gap; here phi is 60 degrees or more.
    let thickest = found.surfaces.iter().map(|s| s.left.depth_mm).fold(0.0, f64::max);
    assert!(thickest < GAP + ERROR, "{found:#?}", found = found.surfaces);
    assert!(found.surfaces.iter().all(|s| s.overcut.at.is_none()), "{:?}", found.surfaces);
    let area: f64 = found.surfaces.iter().map(|s| s.area_mm2).sum();
    let left: f64 = found.surfaces.iter().map(|s| s.left.area_mm2).sum();
    assert!(left < 0.06 * area, "{left} of {area} mm2: {:#?}", found.surfaces);
    assert!(found.stock.left_mm3 < 0.005 * found.stock.channel_mm3, "{:?}", found.stock);
}

#[test]
fn the_channel_is_measured_right() {
    let found = standing(&make(&unreduced()));
    let c = &PART.channel;
    // Slices between the exact walls.
    let (nu, nv) = (c.low.nu, c.low.nv);
    let mut volume = 0.0;
    for u in 1..nu {
        for v in 1..nv {
            let corner = |u, v| (c.low.cylindrical(u, v), c.high.cylindrical(u, v));
            let corners = [corner(u - 1, v - 1), corner(u, v - 1), corner(u, v), corner(u - 1, v)];
            let pitch = corners.iter().map(|(a, b)| b.theta - a.theta).sum::<f64>() / 4.0;
            let r = corners.iter().map(|(a, _)| a.r).sum::<f64>() / 4.0;
            let (a, b, d) = (corners[0].0, corners[1].0, corners[3].0);
            volume += (b.x - a.x) * (d.r - a.r) * r * pitch;
        }
    }
    assert!((found.stock.channel_mm3 / volume - 1.0).abs() < 0.01, "{} {volume}", found.stock.channel_mm3);
    let hub = found.surfaces.iter().find(|s| s.surface == Surface::Hub).unwrap().area_mm2;
    let shroud = found.surfaces.iter().find(|s| s.surface == Surface::Shroud).unwrap().area_mm2;
    let mean = volume / 10.0;
    assert!((0.5 * (hub + shroud) / mean - 1.0).abs() < 0.05, "{hub} {shroud} {mean}");
}

#[test]
fn without_copying_the_walls_keep_what_the_reduction_takes() {
    let deg = [0.2, 0.3];
    let reduced = ElectrodeParams { circumferential_reduction_deg: deg, ..unreduced() };
    let found = standing(&make(&reduced));
    let mut compared = 0;
    for (p, d, is_low) in on_walls(&found) {
        let nearest = PART.exact.nearest(p);
        let normal = geometry::mesh::unit_normal(PART.mesh.corners(nearest.triangle as usize));
        let around = DVec3::X.cross(DVec3::new(0.0, p.y, p.z).normalize());
        let turn = deg[usize::from(!is_low)].to_radians();
        let expected = p.y.hypot(p.z) * turn * normal.dot(around).abs();
        assert!((d / expected - 1.0).abs() < 0.02 + ERROR / expected, "{p}: {d} {expected}");
        compared += 1;
    }
    assert!(compared > 500);
    let walls = found.surfaces.iter().filter(|s| matches!(s.surface, Surface::LowWall | Surface::HighWall));
    let layers: f64 = walls.map(|s| s.left.volume_mm3).sum();
    // The layers on the two walls are all that is left, but for corners.
    assert!((found.stock.left_mm3 / layers - 1.0).abs() < 0.05, "{} {layers}", found.stock.left_mm3);
}

/// Each wall's layer counts in full, also where a ray comes upon it from what is eroded.
#[test]
fn a_thin_layer_counts_the_same_on_either_wall() {
    let left = |deg: [f64; 2]| {
        let reduced = ElectrodeParams { circumferential_reduction_deg: deg, ..unreduced() };
        standing(&make(&reduced)).stock.left_mm3
    };
    let nothing = left([0.0, 0.0]);
    let [low, high] = [left([0.04, 0.0]) - nothing, left([0.0, 0.04]) - nothing];
    // 0.04 deg at a radius of 95 mm make 0.066 mm on 14 x 10 mm of wall, measured round the axis.
    let expected = 0.04f64.to_radians() * 95.0 * 140.0;
    for layer in [low, high] {
        assert!((layer / expected - 1.0).abs() < 0.12, "{low} {high} {expected}");
    }
}

#[test]
fn the_copying_motion_brings_every_wall_to_its_gap() {
    let reduced =
        ElectrodeParams { circumferential_reduction_deg: [0.8, 0.6], radial_reduction_mm: 0.4, ..unreduced() };
    let electrodes = make(&reduced);
    let copying = made(motion(&electrodes[0], &reduced, AxisSet::XYZAC));
    assert!(copying.holds() && copying.is_whole(), "{copying:#?}");
    let poses: Vec<Pose> = copying.path.rows.iter().map(|r| r.pose).collect();
    let burn = |copying: Vec<Pose>| Burn { electrode: &electrodes[0], spark_gap: GAP, feed: Vec::new(), copying };
    let (without, with) = (left_by(&[burn(Vec::new())]), left_by(&[burn(poses.clone())]));
    for (p, d, _) in on_walls(&with) {
        // The step that lifts it over the facets of the hub moves it along the walls.
        assert!(d.abs() < ERROR + 0.01, "{p}: {d}");
    }
    assert!(without.stock.left_mm3 > 10.0 * with.stock.left_mm3, "{:?} {:?}", without.stock, with.stock);
    assert!(with.surfaces.iter().all(|s| s.overcut.at.is_none()), "{:?}", with.surfaces);
    // A feed can only take away.
    let feed = vec![Pose { x: -9.0, ..Pose::FINAL }, Pose::FINAL];
    let fed = left_by(&[Burn { electrode: &electrodes[0], spark_gap: GAP, feed, copying: poses }]);
    assert!(fed.stock.left_mm3 <= with.stock.left_mm3 + 1e-9);
    let less = fed.map.deviation.iter().zip(with.map.deviation.iter());
    let more = less.map(|(fed, unfed)| fed - unfed).fold(0.0, f32::max);
    assert!(f64::from(more) <= cutter::RESOLUTION + 1e-6, "{more}");
}

#[test]
fn a_motion_that_would_cut_too_deep_is_shortened_or_refused() {
    let reduced = ElectrodeParams { circumferential_reduction_deg: [0.5, 0.5], ..unreduced() };
    let electrode = &make(&reduced)[0];
    assert_eq!(motion(electrode, &reduced, AxisSet::XYZC), Copying::NoTable);
    assert_eq!(motion(&make(&unreduced())[0], &unreduced(), AxisSet::XYZAC), Copying::NotNeeded);
    let too_much = ElectrodeParams { circumferential_reduction_deg: [0.5, 0.9], ..unreduced() };
    let copying = made(motion(electrode, &too_much, AxisSet::XYZAC));
    assert!(copying.holds() && !copying.is_whole(), "{copying:#?}");
    assert!(copying.reached.high <= 0.502f64.to_radians(), "{:?}", copying.reached);
}

#[test]
fn columns_that_overlap_leave_no_more_than_one_electrode_and_a_web_where_they_do_not() {
    let columns = |column_overlap_mm| ElectrodeParams {
        columns: 2,
        column_overlap_mm,
        column_split: Auto::Given(0.5),
        ..unreduced()
    };
    let whole = standing(&make(&unreduced()));
    let overlapping = make(&columns(0.5));
    assert!(overlapping.iter().all(|e| e.mesh.is_watertight()) && overlapping.len() == 2);
    let found = standing(&overlapping);
    assert!(found.stock.left_mm3 < whole.stock.left_mm3 + 0.5, "{:?} {:?}", found.stock, whole.stock);
    let thickest = |l: &ResidualStock| l.thickest().map_or(0.0, |(_, layer)| layer.depth_mm);
    assert!(thickest(&found) < thickest(&whole) + ERROR, "{:?} {:?}", found.thickest(), whole.thickest());

    let apart = make(&columns(-1.0));
    let found = standing(&apart);
    // A web along the middle: what the two burns stand apart.
    let web = 1.0;
    // The channel leans by up to 25 degrees, so that the web is thinner than it is wide round the axis.
    let thinnest = web * 25f64.to_radians().cos() - 2.0 * GAP * (1.0 / 25f64.to_radians().cos() - 1.0);
    assert!((0.5 * thinnest - 0.02..0.5 * web + 0.02).contains(&found.stock.depth_mm), "{:?}", found.stock);
    // 14 mm long and 10 mm high.
    assert!((0.8 * web * 140.0..1.1 * web * 140.0).contains(&found.stock.left_mm3), "{:?}", found.stock);
    let hub = found.surfaces.iter().find(|s| s.surface == Surface::Hub).unwrap();
    let shroud = found.surfaces.iter().find(|s| s.surface == Surface::Shroud).unwrap();
    assert!(hub.left.depth_mm > 0.3 && shroud.left.depth_mm > 0.3, "{hub:?} {shroud:?}");
}

#[test]
fn what_another_shell_buries_is_no_surface_of_the_channel() {
    let electrode = &make(&unreduced())[0];
    let burn = || [Burn { electrode, spark_gap: GAP, feed: Vec::new(), copying: Vec::new() }];
    let ring = turned_part(&[[2.0, 89.0], [12.0, 89.0], [12.0, 89.6], [2.0, 89.6]], 120);
    let with_ring = together(PART.mesh.clone(), &ring);
    let buried = residual_stock(&Site { blisk: &with_ring, ..site() }, &burn(), &Task::default()).unwrap();
    assert_eq!(buried.surfaces, left_by(&burn()).surfaces);
}

#[test]
fn what_lies_beside_the_blades_is_no_surface_of_the_channel() {
    let channel = &PART.channel;
    let passage = Passage::new(channel).unwrap();
    let [_, to] = passage.span;
    let electrodes = make(&unreduced());
    let found = standing(&electrodes);
    // Pieces of hub and shroud are 0.45 mm long, so that whole ones would reach as far as 0.3 mm beyond the edges.
    let along = |p: &DVec3| passage.along_and_height(*p)[0];
    let furthest = found.map.mesh.vertices.iter().map(along).fold(f64::NEG_INFINITY, f64::max);
    assert!((to - 0.45..=to + GAP).contains(&furthest), "{furthest} {to}");
}

#[test]
fn pieces_that_reach_beyond_the_edges_and_flat_ends_of_blades_lie_beside_the_blades() {
    let passage = Passage::new(&PART.channel).unwrap();
    let [_, to] = passage.span;
    // The channel is straight: along it goes X.
    let at = |x: f64, r: f64, turn: f64| DVec3::new(x, r * turn.cos(), r * turn.sin());
    let along = |x: f64| passage.along_and_height(at(x, 95.0, 0.0))[0];
    let x_of = |s: f64| 5.0 + (s - along(5.0)) / (along(6.0) - along(5.0));
    let is_beside = |corners: [DVec3; 3]| surface::is_beside_blades(&passage, corners, GAP);
    // A piece of the hub that begins within the blades.
    let hub = |end: f64| {
        is_beside([at(x_of(to - 0.2), 90.0, 0.0), at(x_of(end), 90.0, 0.0), at(x_of(to - 0.2), 90.0, 0.005)])
    };
    assert!(!hub(to + 0.5 * GAP) && hub(to + 3.0 * GAP));
    // A face across the passage at its end is one of a blade's; the same far within is a step of the wall.
    let across = |s: f64| {
        let x = x_of(s);
        is_beside([at(x, 95.0, 0.0), at(x, 95.0, 0.005), at(x, 95.4, 0.0)])
    };
    assert!(across(to) && !across(0.5 * (passage.span[0] + to)));
    // A wall along the passage up to its end is part of the channel.
    assert!(!is_beside([at(x_of(to - 0.3), 95.0, 0.0), at(x_of(to), 95.0, 0.0), at(x_of(to), 95.3, 0.0)]));
}

#[test]
fn the_facets_of_a_rim_that_blades_end_flush_with_lie_beside_the_blades() {
    let flat = ParametricWheel { span: [0.0, 1.0], ..ParametricWheel::nozzle_ring() };
    // The shroud leans, so that the passage narrows towards the axis and its ends stay square to the hub.
    let leaning = MeridianCurve::line(DVec2::new(12.0, 68.0), DVec2::new(6.0, 104.0));
    let narrowing = ParametricWheel { shroud: leaning, ..flat.clone() };
    for wheel in [flat, narrowing] {
        let channel = find_channel(&wheel.mesh(), &BliskOptions::default(), &Task::default()).unwrap();
        let passage = Passage::new(&channel).unwrap();
        let last = *channel.meridian.last().unwrap();
        for share in [0.02, 0.5, 0.98] {
            let DVec2 { x, y: rim } = last.place(share);
            // Facing outwards, within the spark gap of the end of the blades.
            let facet = [(x - 0.2, 0.002), (x + 0.2, 0.002), (x, -0.002)];
            let corners = facet.map(|(x, theta)| Cylindrical { x, r: rim, theta }.point());
            let along = corners.map(|p| passage.along_and_height(p)[0] - passage.span[1]);
            assert!(along.iter().all(|beyond| beyond.abs() < GAP), "{along:?}");
            assert!(normal_times_two_areas(corners).dot(corners[0]) > 0.0);
            assert!(surface::is_beside_blades(&passage, corners, GAP), "{share}");
        }
        // Hub and walls up to there are surfaces of the channel.
        let near = channel.station_at(last.along - 0.3).hub;
        let of_hub = [(0.0, 0.0), (0.1, 0.0), (0.0, 0.001)].map(|(up, theta)| {
            let DVec2 { x, y: r } = near - up * (last.hub - near).normalize();
            Cylindrical { x, r, theta }.point()
        });
        assert!(!surface::is_beside_blades(&passage, of_hub, GAP));
        let of_wall = [(0.0, 0.0), (0.1, 0.0), (0.0, 0.1)].map(|(down, over)| {
            let DVec2 { x, y: r } = channel.station_at(last.along - 0.3 - down).place(0.5);
            Cylindrical { x: x + over, r, theta: 0.0 }.point()
        });
        assert!(!surface::is_beside_blades(&passage, of_wall, GAP));
    }
}

/// Poses that lead straight along X into the final pose.
fn straight(length: f64) -> Vec<Pose> {
    [1.0, 0.3, 0.0].map(|share| Pose { x: -share * length, ..Pose::FINAL }).to_vec()
}

/// A cuboid of 3 x 3 mm along X in the middle of the channel, which reaches to the middle of the blades.
fn bar() -> Electrode {
    let passage = Passage::new(&PART.channel).unwrap();
    let [from, to] = passage.span;
    let middle = 0.5 * (from + to);
    let [low, high] = passage.between(middle, 95.0);
    let Cylindrical { x, r, theta } = Cylindrical { x: middle, r: 95.0, theta: 0.5 * (low + high) };
    let [y, z] = [r * theta.sin(), r * theta.cos()];
    let at = Cylindrical { x, r, theta }.point();
    assert!((at.y.abs() - y.abs()).abs() < 1e-9 && (at.z - z).abs() < 1e-9);
    let mesh = Mesh::cuboid(DVec3::new(40.0, 3.0, 3.0)).mapped(|p| p + at - DVec3::new(40.0, 1.5, 1.5));
    let faces = vec![wheel::electrode::ElectrodeFace::FarEnd; mesh.triangles.len()];
    Electrode { mesh, faces, patches: Vec::new(), reference_point: at, ..make(&unreduced()).remove(0) }
}

/// A bar of 3 mm by 3 mm takes its section and a gap all round, rounded at the edges, from the blades' front edges to a gap
/// beyond its end.
#[test]
fn a_bar_removes_its_section_along_its_way() {
    let electrode = bar();
    let burn = || Burn { electrode: &electrode, spark_gap: GAP, feed: straight(30.0), copying: Vec::new() };
    let removed = left_by(&[burn(), burn()]).removed;
    let gap = GAP + DistanceField::ACCURACY;
    let section = (3.0 + 2.0 * gap).powi(2) - (4.0 - std::f64::consts::PI) * gap * gap;
    let [from, to] = PART.channel.span_x();
    let length = 0.5 * (to - from) + gap;
    let sum = |pieces: &[Piece]| pieces.iter().map(|piece| piece.volume_mm3).sum::<f64>();
    assert!((sum(&removed[0]) / (section * length) - 1.0).abs() < 0.02, "{} {}", sum(&removed[0]), section * length);
    assert!(removed[0].len() >= 4, "{removed:?}");
    let inner = &removed[0][1..removed[0].len() - 1];
    for piece in inner {
        assert!((piece.frontal_area_mm2 / section - 1.0).abs() < 0.08, "{piece:?} {section}");
    }
    let advance: f64 = removed[0].iter().map(|piece| piece.volume_mm3 / piece.frontal_area_mm2).sum();
    assert!((advance - length).abs() < 0.6, "{advance} {length}");
    assert_eq!(removed[1], [], "the first one has left nothing of it");
}

/// What all electrodes remove is what is not left; a second part removes only what the first one leaves.
#[test]
fn what_is_removed_and_what_is_left_make_the_channel() {
    let electrodes = make(&ElectrodeParams { parts: 2, ..unreduced() });
    let burns: Vec<Burn> = electrodes
        .iter()
        .map(|electrode| Burn { electrode, spark_gap: GAP, feed: straight(40.0), copying: Vec::new() })
        .collect();
    let found = left_by(&burns);
    let all: f64 = found.removed.iter().flatten().map(|piece| piece.volume_mm3).sum();
    let gone = found.stock.channel_mm3 - found.stock.left_mm3;
    assert!((all / gone - 1.0).abs() < 0.01, "{all} {gone}");
    let alone = left_by(&burns[1..]).removed;
    let sum = |pieces: &[Piece]| pieces.iter().map(|piece| piece.volume_mm3).sum::<f64>();
    assert!(sum(&found.removed[1]) < 0.9 * sum(&alone[0]), "{} {}", sum(&found.removed[1]), sum(&alone[0]));
    assert!(found.removed.iter().flatten().all(|piece| piece.frontal_area_mm2 > 0.1));
    assert_eq!(found, left_by(&burns), "the order of threads does not count");
}

/// The stock that electrodes remove of a wheel that comes with an allowance, and that they leave, is the channel within the allowance of
/// the finished blisk, counted with exact distances at places of its own.
#[test]
fn of_a_near_net_wheel_only_its_allowance_is_burned() {
    const ALLOWANCE: f64 = 0.8;
    let electrodes = make(&unreduced());
    // The electrode as it stands and as it comes in from -X.
    let feed: Vec<crate::pose::Pose> =
        (0..=40).rev().map(|k| crate::pose::Pose { x: -f64::from(k) * 0.5, ..crate::pose::Pose::FINAL }).collect();
    let burn = || vec![Burn { electrode: &electrodes[0], spark_gap: GAP, feed: feed.clone(), copying: Vec::new() }];
    let by = |blank| residual_stock(&Site { blank, ..site() }, &burn(), &Task::default()).unwrap();
    let sum = |found: &ResidualStock| found.removed.iter().flatten().map(|piece| piece.volume_mm3).sum::<f64>();
    let (full, near) = (by(Blank::Full), by(Blank::Allowance(ALLOWANCE)));
    // Places all over the channel, from wall to wall.
    let passage = Passage::new(&PART.channel).unwrap();
    let [from, to] = PART.channel.span_x();
    let (mut within, mut all) = (0.0, 0.0);
    for i in 0..60_u32 {
        let x = from + (to - from) * (f64::from(i) + 0.5) / 60.0;
        let (hub, shroud) = PART.channel.radii_at(x);
        for j in 0..30_u32 {
            let r = hub + (shroud - hub) * (f64::from(j) + 0.5) / 30.0;
            let [low, high] = passage.between(x, r);
            for k in 0..30_u32 {
                let theta = low + (high - low) * (f64::from(k) + 0.5) / 30.0;
                let volume = (high - low).max(0.0) * r;
                all += volume;
                if PART.exact.signed_distance(Cylindrical { x, r, theta }.point()) <= ALLOWANCE {
                    within += volume;
                }
            }
        }
    }
    let expected = within / all;
    let found = (sum(&near) + near.stock.left_mm3) / (sum(&full) + full.stock.left_mm3);
    assert!((found - expected).abs() < 0.03, "{found} of the channel, {expected} expected");
    assert!(expected < 0.7, "the allowance leaves a channel free");
    for (full, near) in full.surfaces.iter().zip(&near.surfaces) {
        assert!(near.left.depth_mm <= full.left.depth_mm.min(ALLOWANCE) + 1e-6, "{:?}", near.surface);
    }
    // The same wheel given as a mesh: nothing of the ring is stock but what the finished blisk has.
    let finished = by(Blank::Solid(&PART.mesh));
    assert!(sum(&finished) < 0.02 * sum(&full), "{} of {}", sum(&finished), sum(&full));
}
