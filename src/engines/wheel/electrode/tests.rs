use std::sync::LazyLock;

use proptest::prelude::*;

use glam::{DMat3, DVec2};

use super::*;
use crate::channel::{Channel, ChannelWall};
use crate::find_channel::find_channel;
use crate::fixtures::exact_channel;
use crate::options::{Auto, BliskOptions, ZAt};
use crate::parametric::random::{random_wheel, shares};
use crate::parametric::wheel::ParametricWheel;
use crate::parametric::{MeshResolution, ParametricBlisk};
use geometry::exact::ExactMesh;
use geometry::frame::Cylindrical;
use task::{Cancel, Task};

struct Part {
    channel: Channel,
    blisk: ExactMesh,
}

fn part(blisk: &ParametricBlisk, resolution: &MeshResolution) -> Part {
    let mesh = blisk.mesh(resolution).unwrap();
    Part { channel: exact_channel(blisk), blisk: ExactMesh::new(&mesh).unwrap() }
}

/// A turbine blisk whose end walls are so finely faceted that they are round to less than a micrometre.
static FINE: LazyLock<Part> = LazyLock::new(|| {
    let blisk = ParametricBlisk { blades: 40, hub_radius_mm: 90.0, shroud_radius_mm: 104.0, ..straight(30.0, -40.0) };
    part(&blisk, &MeshResolution { edge: 10, chord: 60, span: 8, pitch: 26, ring: 4 })
});

fn straight(beta_in_deg: f64, beta_out_deg: f64) -> ParametricBlisk {
    ParametricBlisk { beta_in_deg, beta_out_deg, ..ParametricBlisk::default() }
}

fn unreduced() -> ElectrodeParams {
    ElectrodeParams { circumferential_reduction_deg: [0.0; 2], radial_reduction_mm: 0.0, ..ElectrodeParams::default() }
}

/// The unreduced electrodes of that blisk, entering from -X and from +X.
pub(super) static UNREDUCED: LazyLock<[Electrode; 2]> = LazyLock::new(|| {
    [EntrySide::MinusX, EntrySide::PlusX].map(|side| make(&FINE, &unreduced(), side).unwrap().remove(0))
});

fn make(part: &Part, params: &ElectrodeParams, side: EntrySide) -> Result<Vec<Electrode>, ElectrodeError> {
    make_electrodes(&part.channel, &part.blisk, params, side, &Task::default())
}

/// All that is asked of electrodes of one and the same channel, which is made once.
#[test]
fn electrodes_of_one_channel_seen_from_all_sides() {
    patches_hold_every_triangle_of_the_electrode_once_and_look_outwards();
    an_unreduced_electrode_lies_on_the_gap_everywhere();
    reductions_keep_the_hub_side_on_the_gap_and_turn_each_wall_by_its_own_angle();
    threads_change_nothing();
    a_greater_reduction_gives_a_subset();
    parts_share_the_overlap_and_cover_the_whole();
    single_parts_have_divisions_overlaps_and_reductions_of_their_own();
    faces_look_where_their_names_say();
    what_leaves_no_metal_is_refused_with_the_place_and_the_room_there_is();
    an_own_mesh_is_checked_before_it_is_taken();
    parameters_read_as_a_job_writes_them();
    columns_are_equally_thick_unless_their_split_is_given();
}

fn patches_hold_every_triangle_of_the_electrode_once_and_look_outwards() {
    let mut electrodes = vec![UNREDUCED[0].clone()];
    electrodes
        .extend(make(&FINE, &ElectrodeParams { columns: 2, ..ElectrodeParams::default() }, EntrySide::PlusX).unwrap());
    for electrode in electrodes {
        let sorted = |mut quad: Vec<u32>| {
            quad.sort_unstable();
            quad.dedup();
            quad
        };
        // Quads are pairs of triangles one after the other.
        let pairs = electrode.mesh.triangles.chunks(2).map(|pair| sorted(pair.concat()));
        let quads = electrode.patches.iter().flat_map(|patch| patch.grid.quads().map(|quad| sorted(quad.to_vec())));
        let [mut of_mesh, mut of_patches]: [Vec<_>; 2] = [pairs.collect(), quads.collect()];
        of_mesh.sort();
        of_patches.sort();
        assert_eq!(of_mesh, of_patches);
        let at = |v: u32| electrode.mesh.vertices[v as usize];
        let sixfold = |[a, b, c, d]: [u32; 4]| {
            let [a, b, c, d] = [a, b, c, d].map(at);
            a.dot(b.cross(c)) + a.dot(c.cross(d))
        };
        let volume = electrode.patches.iter().flat_map(|patch| patch.grid.quads()).map(sixfold).sum::<f64>() / 6.0;
        assert!((volume / electrode.volume_mm3 - 1.0).abs() < 1e-3, "{volume} {}", electrode.volume_mm3);
    }
}

/// Vertices, edge midpoints and face centres of the faces that `wanted` picks.
fn places(electrode: &Electrode, wanted: impl Fn(ElectrodeFace) -> bool) -> Vec<DVec3> {
    let corners = electrode.mesh.iter_corners().zip(&electrode.faces).filter(|(_, face)| wanted(**face));
    corners
        .flat_map(|([a, b, c], _)| [a, b, c, (a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0, (a + b + c) / 3.0])
        .collect()
}

/// Least and greatest x of the faces that burn (mm).
fn burned(electrode: &Electrode) -> [f64; 2] {
    let xs = places(electrode, |f| f.burns()).into_iter().map(|p| p.x);
    xs.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(x), b.max(x)])
}

fn an_unreduced_electrode_lies_on_the_gap_everywhere() {
    let gap = 0.1;
    let electrode = &UNREDUCED[0];
    assert!(electrode.mesh.is_watertight());
    let nearest = |p: &DVec3| FINE.blisk.signed_distance(*p);
    for p in places(electrode, |_| true) {
        assert!(nearest(&p) >= gap - 1e-4, "{p}: {}", nearest(&p));
    }
    // Between the edges the walls and end walls are at the gap, but for the chords of their facets.
    let [from, to] = FINE.channel.span_x();
    for wanted in [ElectrodeFace::LowWall, ElectrodeFace::HighWall, ElectrodeFace::HubSide, ElectrodeFace::ShroudSide] {
        let places = places(electrode, |face| face == wanted);
        let inner: Vec<_> = places.iter().filter(|p| p.x > from && p.x < to).map(nearest).collect();
        let close = inner.iter().filter(|d| **d <= gap + 2e-3).count();
        assert!(close as f64 >= 0.9 * inner.len() as f64, "{wanted:?}: {close} of {}", inner.len());
        let worst = inner.iter().fold(0.0, |a: f64, b| a.max(*b));
        assert!(worst < gap + 6e-3, "{wanted:?}: {worst}");
    }
}

fn reductions_keep_the_hub_side_on_the_gap_and_turn_each_wall_by_its_own_angle() {
    let reduced = ElectrodeParams { circumferential_reduction_deg: [0.8, 0.5], ..ElectrodeParams::default() };
    let full = &UNREDUCED[1];
    let small = &make(&FINE, &reduced, EntrySide::PlusX).unwrap()[0];
    let between = FINE.blisk.distance_to(&ExactMesh::new(&small.mesh).unwrap(), &glam::DAffine3::IDENTITY);
    assert!((0.1 - 5e-4..=0.1 + 1e-3).contains(&between), "the whole surfaces are {between} mm apart");
    let hub: Vec<_> = places(small, |f| f == ElectrodeFace::HubSide);
    let on_gap = hub.iter().filter(|p| FINE.blisk.signed_distance(**p) <= 0.1 + 1e-3).count();
    assert!(on_gap as f64 >= 0.99 * hub.len() as f64, "{on_gap} of {}", hub.len());
    let full = ExactMesh::new(&full.mesh).unwrap();
    for (wall, back) in [(ElectrodeFace::LowWall, -0.8f64), (ElectrodeFace::HighWall, 0.5)] {
        // Past the tips of the edges the unreduced electrode gives way more to keep the gap.
        for p in places(small, |f| f == wall).into_iter().filter(|p| p.x > 0.0 && p.x < 20.0) {
            let at = Cylindrical::from_point(p);
            let turned_back = Cylindrical { theta: at.theta + back.to_radians(), ..at }.point();
            let off = full.signed_distance(turned_back).abs();
            assert!(off < 8e-3, "{p} is {off} mm off the unreduced wall");
        }
    }
}

fn threads_change_nothing() {
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| make(&FINE, &unreduced(), EntrySide::PlusX).unwrap())
    };
    assert_eq!(on(1), on(5));
}

fn a_greater_reduction_gives_a_subset() {
    let with = |low: f64, high: f64, radial: f64| {
        let params = ElectrodeParams {
            circumferential_reduction_deg: [low, high],
            radial_reduction_mm: radial,
            ..ElectrodeParams::default()
        };
        make(&FINE, &params, EntrySide::MinusX).unwrap().remove(0)
    };
    let large = ExactMesh::new(&with(0.2, 0.3, 0.1).mesh).unwrap();
    let small = with(0.9, 0.6, 0.7);
    for p in places(&small, |f| f != ElectrodeFace::Holder) {
        let outside = large.signed_distance(p);
        assert!(outside < 2e-3, "{p} is {outside} mm outside");
    }
}

#[test]
fn a_straight_channel_has_the_thickness_of_geometry() {
    let blisk = ParametricBlisk { twist_deg: 0.0, ..straight(0.0, 0.0) };
    let part = part(&blisk, &MeshResolution { pitch: 12, ..MeshResolution::default() });
    let gap = 0.1;
    for turn in [0.0f64, 0.6] {
        let params = ElectrodeParams { circumferential_reduction_deg: [turn; 2], ..unreduced() };
        let electrode = &make(&part, &params, EntrySide::MinusX).unwrap()[0];
        let r = blisk.hub_radius_mm + gap;
        // At mid-chord, at the hub: half the pitch less half the blade, the gap and the turn, on both sides.
        let half = 0.5 * blisk.pitch() - (0.5 * blisk.max_thickness_mm + gap) / r - turn.to_radians();
        let expected = 2.0 * r * half.sin();
        let ratio = electrode.least_thickness_mm / expected;
        assert!((ratio - 1.0).abs() < 0.01, "{} for {expected}", electrode.least_thickness_mm);
    }
}

fn parts_share_the_overlap_and_cover_the_whole() {
    let whole = &make(&FINE, &ElectrodeParams::default(), EntrySide::PlusX).unwrap()[0];
    let params = ElectrodeParams { parts: 3, overlap_mm: 1.5, ..ElectrodeParams::default() };
    let parts = make(&FINE, &params, EntrySide::PlusX).unwrap();
    assert_eq!(parts.iter().map(|e| e.part).collect::<Vec<_>>(), [2, 1, 0]);
    let ranges: Vec<_> = parts.iter().map(burned).collect();
    assert_eq!([ranges[2][0], ranges[0][1]], burned(whole), "entering from +X the first part is the one at +X");
    for pair in ranges.windows(2) {
        // Each burns the gap of 0.1 mm beyond its end.
        assert!((pair[1][1] - pair[0][0] - 1.3).abs() < 1e-9, "{ranges:?}");
    }
    let whole = ExactMesh::new(&whole.mesh).unwrap();
    for part in &parts {
        assert!(part.mesh.is_watertight() && part.mesh.volume() > 0.0);
        // A deeper part's shank stays inside what the parts before it have burned.
        for p in places(part, |f| f != ElectrodeFace::Holder) {
            assert!(whole.signed_distance(p) < 8e-3, "part {}: {p}", part.part);
        }
    }
}

fn single_parts_have_divisions_overlaps_and_reductions_of_their_own() {
    let row = PartParams::default();
    let params = ElectrodeParams {
        parts: 3,
        part: vec![
            PartParams { until: Some(0.5), overlap_mm: Some(2.2), radial_reduction_mm: Some(1.5), ..row },
            PartParams { until: Some(0.75), low_reduction_deg: Some(1.4), ..row },
        ],
        ..unreduced()
    };
    let [whole_from, whole_to] = burned(&UNREDUCED[0]);
    let parts = make(&FINE, &params, EntrySide::MinusX).unwrap();
    let ranges: Vec<_> = parts.iter().map(burned).collect();
    // Divisions are given; the burns share 2.2 and 1 mm, gaps included.
    let length = whole_to - whole_from;
    for (k, (division, shared)) in [(0.5 * length, 2.0), (0.75 * length, 0.8)].into_iter().enumerate() {
        let middle = whole_from + division;
        assert!((ranges[k][1] - (middle + 0.5 * shared)).abs() < 1e-9, "{k}: {ranges:?}");
        assert!((ranges[k + 1][0] - (middle - 0.5 * shared)).abs() < 1e-9, "{k}: {ranges:?}");
    }
    let top = |e: &Electrode| {
        let on_shroud = places(e, |f| f == ElectrodeFace::ShroudSide).into_iter();
        on_shroud.map(|p| p.y.hypot(p.z)).fold(0.0, f64::max)
    };
    assert!((top(&parts[2]) - top(&parts[0]) - 1.5).abs() < 5e-3);
    let whole = ExactMesh::new(&UNREDUCED[0].mesh).unwrap();
    for (part, turn) in parts.iter().zip([0.0f64, 1.4, 0.0]) {
        for (wall, turn) in [(ElectrodeFace::LowWall, turn), (ElectrodeFace::HighWall, 0.0)] {
            for p in places(part, |f| f == wall).into_iter().filter(|p| p.x > 0.0 && p.x < 20.0) {
                let at = Cylindrical::from_point(p);
                let back = Cylindrical { theta: at.theta - turn.to_radians(), ..at }.point();
                assert!(whole.signed_distance(back).abs() < 8e-3, "{wall:?} of part {}: {p}", part.part);
            }
        }
    }
}

fn faces_look_where_their_names_say() {
    for side in [EntrySide::MinusX, EntrySide::PlusX] {
        let electrode = &make(&FINE, &ElectrodeParams::default(), side).unwrap()[0];
        let mut area = [[0.0; 3]; 4];
        let names =
            [ElectrodeFace::LowWall, ElectrodeFace::HighWall, ElectrodeFace::HubSide, ElectrodeFace::ShroudSide];
        for (corners, face) in electrode.mesh.iter_corners().zip(&electrode.faces) {
            let normal = geometry::mesh::normal_times_two_areas(corners);
            assert!(normal.length() > 0.0, "no degenerate faces");
            let (along, [radial, around]) = (normal.x, boundary::components(corners[0], DVec2::Y, normal));
            if let Some(i) = names.iter().position(|n| n == face) {
                [0, 1, 2].into_iter().zip([along, radial, around]).for_each(|(k, part)| area[i][k] += part);
            }
            let out = side.sign();
            match face {
                ElectrodeFace::FarEnd => assert!(along * out < 0.0 && radial.abs() < 1e-6),
                ElectrodeFace::EntryEnd => assert!(along * out > -1e-9, "{along}"),
                _ => {}
            }
        }
        assert!(area[0][2] < 0.0 && area[1][2] > 0.0 && area[2][1] < 0.0 && area[3][1] > 0.0, "{area:?}");
        let o = electrode.reference_point;
        assert!(o.y == 0.0 && (o.x - 10.0).abs() < 0.5 && o.z > 90.0 && o.z < 104.0, "{o}");
        let burning: f64 = names.iter().map(|n| places(electrode, |f| f == *n).len() as f64).sum();
        assert!(burning > 0.0 && electrode.burn_area_mm2 > 600.0 && electrode.clearance_mm >= 0.1 - 1e-3);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(5))]
    #[test]
    fn any_electrode_is_closed_and_keeps_the_gap(
        angles in (20.0..40.0f64, -45.0..-20.0f64),
        shape in (-6.0..6.0f64, -4.0..4.0f64, 0.0..0.1f64, -0.1..0.1f64, -0.1..0.1f64),
        reduction in (0.0..1.0f64, 0.0..1.0f64, 0.0..0.8f64),
        choice in (any::<bool>(), any::<bool>(), 1..3usize, 0.03..0.3f64),
    ) {
        let ((beta_in_deg, beta_out_deg), (twist_deg, lean_deg, taper, hub_slope, shroud_slope)) = (angles, shape);
        let (plus, shrouded, parts, spark_gap_mm) = choice;
        let blisk = ParametricBlisk {
            blades: 40, hub_radius_mm: 100.0, shroud_radius_mm: 116.0,
            beta_in_deg, beta_out_deg, twist_deg, lean_deg, taper, hub_slope, shroud_slope, shrouded,
            ..ParametricBlisk::default()
        };
        let part = part(&blisk, &MeshResolution::default());
        let params = ElectrodeParams {
            circumferential_reduction_deg: [reduction.0, reduction.1],
            radial_reduction_mm: reduction.2,
            spark_gap_mm,
            parts,
            ..ElectrodeParams::default()
        };
        let side = if plus { EntrySide::PlusX } else { EntrySide::MinusX };
        let electrodes = make(&part, &params, side).map_err(|e| TestCaseError::fail(e.to_string()))?;
        prop_assert_eq!(electrodes.len(), parts);
        for electrode in &electrodes {
            prop_assert!(electrode.mesh.is_watertight() && electrode.volume_mm3 > 0.0);
            for p in places(electrode, |_| true) {
                let distance = part.blisk.signed_distance(p);
                prop_assert!(distance >= spark_gap_mm - 5e-4, "{distance} at {p}");
            }
        }
    }
}

fn what_leaves_no_metal_is_refused_with_the_place_and_the_room_there_is() {
    let params = ElectrodeParams { circumferential_reduction_deg: [4.0, 4.0], ..ElectrodeParams::default() };
    match make(&FINE, &params, EntrySide::MinusX) {
        Err(ElectrodeError::NoMetal { r, available, taken, .. }) => {
            assert!((taken - 8f64.to_radians() * r).abs() < 1e-6 && available < taken + 0.2, "{available} {taken}");
        }
        other => panic!("{other:?}"),
    }
    let params = ElectrodeParams { radial_reduction_mm: 14.0, ..ElectrodeParams::default() };
    assert!(matches!(make(&FINE, &params, EntrySide::MinusX), Err(ElectrodeError::NoHeight { .. })));
    let params = ElectrodeParams { parts: 10, overlap_mm: 8.0, ..ElectrodeParams::default() };
    assert!(matches!(make(&FINE, &params, EntrySide::MinusX), Err(ElectrodeError::PartTooShort { .. })));
    let params = ElectrodeParams { spark_gap_mm: f64::NAN, ..ElectrodeParams::default() };
    assert!(make(&FINE, &params, EntrySide::MinusX).unwrap_err().to_string().contains("spark_gap_mm"));
    let task = Task::default();
    task.cancel.cancel();
    let params = ElectrodeParams::default();
    let stopped = make_electrodes(&FINE.channel, &FINE.blisk, &params, EntrySide::MinusX, &task);
    assert_eq!(stopped, Err(ElectrodeError::Cancelled(Cancelled)));
}

fn an_own_mesh_is_checked_before_it_is_taken() {
    let own = |mesh: Mesh| from_user_mesh(mesh, &FINE.channel, &FINE.blisk, 0.1, EntrySide::MinusX, &Cancel::default());
    let made = make(&FINE, &ElectrodeParams::default(), EntrySide::MinusX).unwrap().remove(0);
    let taken = own(made.mesh.clone()).unwrap();
    assert!((taken.clearance_mm - made.clearance_mm).abs() < 1e-3, "{}", taken.clearance_mm);
    assert!((taken.least_thickness_mm / made.least_thickness_mm - 1.0).abs() < 0.02);
    let open = Mesh { triangles: made.mesh.triangles[1..].to_vec(), ..made.mesh.clone() };
    assert_eq!(own(open), Err(ElectrodeError::NotWatertight));
    let mut turned = made.mesh.clone();
    turned.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    assert!(matches!(own(turned), Err(ElectrodeError::InsideOut(_))));
    assert_eq!(own(made.mesh.mapped(|p| p + DVec3::Z)), Err(ElectrodeError::Interferes));
    // Wholly inside the disk's metal, where the surfaces do not touch.
    let inside = Mesh::cuboid(DVec3::splat(2.0)).mapped(|p| p + DVec3::new(9.0, 0.0, 75.0));
    assert_eq!(own(inside), Err(ElectrodeError::Interferes));
}

#[test]
fn thickness_of_a_box_is_its_width() {
    let mesh = Mesh::cuboid(DVec3::new(20.0, 3.0, 10.0));
    let face = |corners: [DVec3; 3]| match geometry::mesh::unit_normal(corners).y {
        y if y > 0.5 => ElectrodeFace::LowWall,
        y if y < -0.5 => ElectrodeFace::HighWall,
        _ => ElectrodeFace::HubSide,
    };
    let faces: Vec<_> = mesh.iter_corners().map(face).collect();
    let thickness = measure::least_thickness(&mesh, &faces, &Cancel::default()).unwrap();
    assert!((thickness - 3.0).abs() < 1e-9, "{thickness}");
    assert_eq!(measure::burn_area(&mesh, &faces), mesh.area());
}

fn parameters_read_as_a_job_writes_them() {
    let text = "spark_gap_mm = 0.2\ncircumferential_reduction_deg = [1.0, 0.5]\nenter = \"-x\"\nsize = \"auto\"\n";
    let params: ElectrodeParams = toml::from_str(text).unwrap();
    assert_eq!((params.enter, params.size, params.spark_gap_mm), (EnterSide::MinusX, Sizing::Auto, 0.2));
    assert_eq!(params.radial_reduction_mm, 0.5);
    assert_eq!(params.enter.candidates(&FINE.channel).unwrap(), [EntrySide::MinusX]);
    assert_eq!(EnterSide::Auto.candidates(&FINE.channel).unwrap(), [EntrySide::MinusX, EntrySide::PlusX]);
    assert!(toml::from_str::<ElectrodeParams>("gap = 1.0").is_err(), "unknown keys are mistakes");
    assert!(params.validate().is_ok());
}

/// The first channel of a wheel, and the wheel in W.
fn passage_of(wheel: &ParametricWheel) -> (Channel, Mesh) {
    // Chords of 0.04 mm.
    let mesh = ParametricWheel { pieces: [120, 40, 5], ..wheel.clone() }.mesh();
    let channel = find_channel(&mesh, &BliskOptions::default(), &Task::default()).unwrap();
    let wheel = mesh.in_frame(&channel.frame);
    (channel, wheel)
}

#[test]
fn electrodes_of_passages_in_any_direction_keep_the_gap_and_fill_them() {
    let radial = ParametricWheel::nozzle_ring();
    let mixed = ParametricWheel::impeller();
    for (wheel, sides) in [(radial, vec![EntrySide::Outward]), (mixed, vec![EntrySide::MinusX, EntrySide::Outward])] {
        let (channel, mesh) = passage_of(&wheel);
        let blisk = ExactMesh::new(&mesh).unwrap();
        let mut open = EntrySide::open(&channel);
        open.retain(|side| *side != EntrySide::Inward);
        assert_eq!(open, sides);
        for side in sides {
            let params = ElectrodeParams {
                circumferential_reduction_deg: [0.0, 0.0],
                radial_reduction_mm: 0.0,
                overrun_mm: 0.0,
                parts: 2,
                ..Default::default()
            };
            let electrodes = make_electrodes(&channel, &blisk, &params, side, &Task::default()).unwrap();
            assert_eq!(electrodes.len(), 2);
            for electrode in &electrodes {
                assert!(electrode.mesh.is_watertight() && electrode.volume_mm3 > 0.0);
                assert!(electrode.clearance_mm >= 0.099, "{side:?}: {}", electrode.clearance_mm);
                assert_eq!(electrode.enters_from, side);
                // The holder is beyond the wheel's face or rim, the burning part no further than the gap beyond it.
                let outwards = |p: DVec3| if side == EntrySide::Outward { p.y.hypot(p.z) } else { -p.x };
                let places = |of: &dyn Fn(ElectrodeFace) -> bool| -> Vec<f64> {
                    let all = electrode.mesh.iter_corners().zip(&electrode.faces).filter(|(_, face)| of(**face));
                    all.flat_map(|(corners, _)| [0.0, 0.25, 0.5].map(|t| outwards(corners[0].lerp(corners[1], t))))
                        .collect()
                };
                let metal = mesh.vertices.iter().map(|&p| outwards(p)).fold(f64::NEG_INFINITY, f64::max);
                assert!(places(&|f| f == ElectrodeFace::Holder).iter().all(|&place| place > metal));
                assert!(places(&|f| f.burns()).iter().all(|&place| place < metal + params.spark_gap_mm + 1e-9));
            }
            // Together they burn each wall to the gap: every point of the walls is the gap away from one of them.
            let bodies: Vec<ExactMesh> = electrodes.iter().map(|e| ExactMesh::new(&e.mesh).unwrap()).collect();
            let (mut near, mut count) = (0, 0);
            for wall in [&channel.low, &channel.high] {
                for (u, v) in (2..wall.nu - 2).flat_map(|u| (2..wall.nv - 2).map(move |v| (u, v))) {
                    let distance = bodies
                        .iter()
                        .map(|b| b.nearest(wall.point(u, v)).signed_distance)
                        .fold(f64::INFINITY, f64::min);
                    count += 1;
                    near += usize::from(distance < 0.13);
                }
            }
            assert!(near as f64 > 0.97 * f64::from(count), "{side:?}: {near} of {count}");
        }
    }
}

#[test]
fn faces_of_an_own_mesh_are_told_as_they_were_made_in_any_direction_of_the_passage() {
    use ElectrodeFace::{HighWall, HubSide, LowWall, ShroudSide};
    let radial = (ParametricWheel::nozzle_ring(), EntrySide::Outward);
    let mixed = [EntrySide::MinusX, EntrySide::Outward].map(|side| (ParametricWheel::impeller(), side));
    for (wheel, side) in [radial].into_iter().chain(mixed) {
        let (channel, mesh) = passage_of(&wheel);
        let part = Part { channel, blisk: ExactMesh::new(&mesh).unwrap() };
        let made = make(&part, &unreduced(), side).unwrap().remove(0);
        let cancel = Cancel::default();
        let own = from_user_mesh(made.mesh.clone(), &part.channel, &part.blisk, 0.1, side, &cancel).unwrap();
        assert!((own.clearance_mm - made.clearance_mm).abs() < 1e-3, "{side:?}: {}", own.clearance_mm);
        assert!((own.burn_area_mm2 / made.burn_area_mm2 - 1.0).abs() < 0.05, "{side:?}: {}", own.burn_area_mm2);
        for face in [LowWall, HighWall, HubSide, ShroudSide] {
            let areas = made.mesh.iter_corners().zip(made.faces.iter().zip(&own.faces));
            let [all, same] =
                areas.filter(|(_, (was, _))| **was == face).fold([0.0; 2], |[all, same], (corners, (was, is))| {
                    let area = geometry::mesh::normal_times_two_areas(corners).length();
                    [all + area, same + if was == is { area } else { 0.0 }]
                });
            assert!(same > 0.9 * all, "{side:?} {face:?}: {same} of {all}");
        }
        let apart = (own.reference_point - made.reference_point).dot(side.direction());
        // Faces at the mouth may count for the shank.
        assert!(apart.abs() < 2.0, "{side:?}: {apart}");
    }
}

/// From the bore the shank goes straight inwards along the radius through the mouth, and the holder stands in the bore.
#[test]
fn an_electrode_from_the_bore_stands_in_it() {
    let wheel = ParametricWheel { pieces: [120, 40, 5], ..ParametricWheel::nozzle_ring() };
    let mesh = wheel.mesh();
    let options = BliskOptions { z_at: ZAt::Bore, ..BliskOptions::default() };
    let channel = find_channel(&mesh, &options, &Task::default()).unwrap();
    let blisk = ExactMesh::new(&channel.wheel_in_w(&mesh)).unwrap();
    let part = Part { channel, blisk };
    let electrode = &make(&part, &ElectrodeParams::default(), EntrySide::Inward).unwrap()[0];
    assert!(electrode.clearance_mm > 0.099, "{}", electrode.clearance_mm);
    let bore = wheel.place(0.0, 0.5).y;
    let holder = places(electrode, |face| face == ElectrodeFace::Holder);
    assert!(holder.iter().all(|p| p.y.hypot(p.z) < bore + 1e-9 && p.z < bore), "{holder:?}");
    // Of both mouths only that in the bore is below the passage.
    assert_eq!(EntrySide::open(&part.channel), [EntrySide::Outward, EntrySide::Inward]);
    assert_eq!(EnterSide::Auto.candidates(&part.channel), Ok(vec![EntrySide::Outward]));
}

/// Where a flange steps back from the hub, and where the hub goes on within the blades, of shells that reach into one
/// another.
#[test]
fn electrodes_keep_the_gap_beside_steps_and_overlapping_shells() {
    for number in [15, 54] {
        let (wheel, _) = random_wheel(number, &mut shares(number as u64));
        let (channel, mesh) = passage_of(&wheel);
        let part = Part { blisk: ExactMesh::new(&mesh).unwrap(), channel };
        let turn = wheel.pitch().to_degrees();
        let params = ElectrodeParams { circumferential_reduction_deg: [0.2 * turn; 2], ..unreduced() };
        for side in [EntrySide::MinusX, EntrySide::PlusX] {
            let electrode = &make(&part, &params, side).unwrap()[0];
            assert!(electrode.clearance_mm > 0.099, "wheel {number}: {}", electrode.clearance_mm);
        }
    }
}

#[test]
fn electrodes_between_leaning_blades_that_end_flush_with_the_rim_fill_the_passage_but_for_their_reductions() {
    let wheel = ParametricWheel { span: [0.1, 1.0], lean: 0.35, fillet_mm: 0.8, ..ParametricWheel::impeller() };
    let (channel, mesh) = passage_of(&wheel);
    let blisk = ExactMesh::new(&mesh).unwrap();
    let params = ElectrodeParams {
        circumferential_reduction_deg: [3.0, 3.0],
        radial_reduction_mm: 2.0,
        parts: 2,
        ..Default::default()
    };
    let electrodes = make_electrodes(&channel, &blisk, &params, EntrySide::Outward, &Task::default()).unwrap();
    for electrode in &electrodes {
        assert!(electrode.mesh.is_watertight() && electrode.clearance_mm >= 0.099, "{}", electrode.clearance_mm);
    }
    // At the rim the passage runs along +Z, seen along the axis.
    let middle = |u: usize| {
        let wall = |wall: &ChannelWall| wall.point(u, wall.nv / 2);
        0.5 * (wall(&channel.low) + wall(&channel.high))
    };
    let last = channel.low.nu - 1;
    let way = (middle(last) - middle(last - 3)).with_x(0.0).normalize();
    assert!(way.dot(DVec3::Z) > 0.995, "{way}");
    // Turned back to a wall, they are the gap away from it, up to where the shroud side is drawn in.
    let bodies: Vec<ExactMesh> = electrodes.iter().map(|e| ExactMesh::new(&e.mesh).unwrap()).collect();
    let turn = 3f64.to_radians();
    for (wall, turn) in [(&channel.low, turn), (&channel.high, -turn)] {
        let (mut near, mut count) = (0, 0);
        for (u, v) in (4..wall.nu - 4).flat_map(|u| (2..wall.nv - 6).map(move |v| (u, v))) {
            let place = DMat3::from_rotation_x(turn) * wall.point(u, v);
            let distance = bodies.iter().map(|b| b.nearest(place).signed_distance).fold(f64::INFINITY, f64::min);
            count += 1;
            near += usize::from(distance < 0.15);
        }
        assert!(near as f64 > 0.95 * f64::from(count), "{near} of {count}");
    }
}

/// The narrow places of this channel lie in its front half, so that halves of its length are not equally thick.
#[test]
fn parts_are_more_alike_in_thickness_than_halves_unless_their_division_is_given() {
    let blisk = ParametricBlisk { beta_in_deg: 50.0, beta_out_deg: -36.0, ..ParametricBlisk::default() };
    let part = part(&blisk, &MeshResolution::default());
    let thicknesses = |columns, until| {
        let row = PartParams { until, ..PartParams::default() };
        let params = ElectrodeParams { parts: 2, part: vec![row], columns, overlap_mm: 0.2, ..unreduced() };
        let made = make(&part, &params, EntrySide::PlusX).unwrap();
        made.iter().map(|e| e.least_thickness_mm).collect::<Vec<_>>()
    };
    let unlike = |of: &[f64]| {
        let [least, most] = of.iter().fold([f64::INFINITY, 0.0], |[a, b], t| [f64::min(a, *t), f64::max(b, *t)]);
        most / least - 1.0
    };
    for columns in [1, 2] {
        let (balanced, halves) = (thicknesses(columns, None), thicknesses(columns, Some(0.5)));
        assert_eq!(balanced.len(), 2 * columns);
        assert!(unlike(&balanced) < 0.7 * unlike(&halves), "{halves:?} {balanced:?}");
    }
}

fn columns_are_equally_thick_unless_their_split_is_given() {
    let thicknesses = |column_split| {
        let params = ElectrodeParams { columns: 2, column_split, ..unreduced() };
        let made = make(&FINE, &params, EntrySide::PlusX).unwrap();
        [made[0].least_thickness_mm, made[1].least_thickness_mm]
    };
    let [low, high] = thicknesses(Auto::Auto);
    assert!((low / high - 1.0).abs() < 0.04, "{low} {high}");
    let [low, high] = thicknesses(Auto::Given(0.35));
    assert!(low < 0.8 * high, "{low} {high}");
}
