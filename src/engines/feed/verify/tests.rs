//! Guarantees of the certificate, against plain sampling and against cases whose answer is known.

use glam::{DAffine3, DMat3, DVec3};
use proptest::prelude::*;

use super::*;
use crate::machine::BeyondTravel;
use crate::path::PathRow;
use crate::pose::Axis;
use geometry::exact::ExactMesh;
use geometry::frame::{Cylindrical, Frame};
use wheel::electrode::EntrySide;

pub(super) fn any_point(size: f64) -> impl Strategy<Value = DVec3> {
    let c = move || -size..size;
    (c(), c(), c()).prop_map(DVec3::from)
}

pub(super) fn any_direction() -> impl Strategy<Value = DVec3> {
    any_point(1.0).prop_map(|p| p.normalize_or(DVec3::X))
}

pub(super) fn any_pose(slide: f64, turn: f64) -> impl Strategy<Value = Pose> {
    (any_point(slide), any_point(turn)).prop_map(|(d, r)| Pose::from_array([d.x, d.y, d.z, r.x, r.y, r.z]))
}

/// Up to three tetrahedra, each of four vertices of its own and outward.
fn any_tetrahedra(size: f64) -> impl Strategy<Value = Mesh> {
    let tetrahedron = move || [any_point(size), any_point(size), any_point(size), any_point(size)];
    let outward =
        |[a, b, c, d]: [DVec3; 4]| if (b - a).cross(c - a).dot(d - a) < 0.0 { [a, c, b, d] } else { [a, b, c, d] };
    prop::collection::vec(tetrahedron().prop_map(outward), 1..4).prop_map(|list| Mesh {
        vertices: list.iter().flatten().copied().collect(),
        triangles: (0..list.len() as u32)
            .flat_map(|i| [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]].map(|t| t.map(|v| v + 4 * i)))
            .collect(),
    })
}

/// Whether `p` is inside one of the tetrahedra: on the inner side of each of its faces.
fn held(tetrahedra: &Mesh, p: DVec3) -> bool {
    let faces: Vec<_> = tetrahedra.iter_corners().collect();
    faces.chunks(4).any(|faces| faces.iter().all(|[a, b, c]| (b - a).cross(c - a).dot(p - a) < 0.0))
}

fn path(reference_point: DVec3, spark_gap: f64, poses: &[Pose]) -> FeedPath {
    let row = |(i, &pose): (usize, &Pose)| PathRow { node: poses.len() - 1 - i, s: (poses.len() - 1 - i) as f64, pose };
    FeedPath { frame: Frame::IDENTITY, reference_point, spark_gap, rows: poses.iter().enumerate().map(row).collect() }
}

fn certify_with(blisk: &Mesh, electrode: &Mesh, path: &FeedPath, options: &VerifyOptions) -> Certificate {
    let surface = |p: DVec3| if p.x < 0.0 { Surface::LowWall } else { Surface::HighWall };
    verify(blisk, electrode, path, &surface, options, &Task::default()).unwrap()
}

fn certify(blisk: &Mesh, electrode: &Mesh, path: &FeedPath) -> Certificate {
    certify_with(blisk, electrode, path, &VerifyOptions::default())
}

/// A grid of `nu` by `nv` cells as triangles.
fn grid(nu: usize, nv: usize, point: impl Fn(f64, f64) -> DVec3) -> Mesh {
    let at = |u: usize, v: usize| (u * (nv + 1) + v) as u32;
    let vertices = (0..=nu)
        .flat_map(|u| (0..=nv).map(move |v| (u as f64 / nu as f64, v as f64 / nv as f64)))
        .map(|(u, v)| point(u, v))
        .collect();
    let cells = (0..nu).flat_map(|u| (0..nv).map(move |v| (u, v)));
    let triangles = cells
        .flat_map(|(u, v)| [[at(u, v), at(u + 1, v), at(u + 1, v + 1)], [at(u, v), at(u + 1, v + 1), at(u, v + 1)]])
        .collect();
    Mesh { vertices, triangles }
}

const CENTER: DVec3 = DVec3::new(0.0, 0.0, 40.0);

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn bounds_enclose_what_dense_sampling_finds(
        blisk in any_tetrahedra(3.0), electrode in any_tetrahedra(3.0), offset in any_direction(),
        poses in prop::collection::vec(any_pose(2.0, 0.3), 2..4),
    ) {
        let blisk = blisk.mapped(|p| p + CENTER);
        let electrode = electrode.mapped(|p| p + CENTER + offset * 7.0);
        let path = path(CENTER, 0.1, &poses);
        let options = VerifyOptions { resolution_mm: 0.001, ..VerifyOptions::default() };
        let certificate = certify_with(&blisk, &electrode, &path, &options);

        let (b, e) = (ExactMesh::new(&blisk).unwrap(), ExactMesh::new(&electrode).unwrap());
        let reach = electrode.vertices.iter().map(|p| p.distance(CENTER)).fold(0.0, f64::max);
        let (mut sampled, mut step) = (f64::INFINITY, 0.0f64);
        let n = 300;
        for pair in poses.windows(2) {
            let moved: Vec<f64> = (0..6).map(|i| pair[1].to_array()[i] - pair[0].to_array()[i]).collect();
            let travel = (0..3).map(|i| moved[i].abs()).sum::<f64>()
                + (CENTER.z + 2.0 + reach) * moved[3].abs() + reach * (moved[4].abs() + moved[5].abs());
            step = step.max(travel / n as f64);
            for i in 0..=n {
                let placement = pair[0].lerp(&pair[1], i as f64 / n as f64).placement(CENTER);
                sampled = sampled.min(b.distance_to(&e, &placement));
                let back = placement.inverse();
                let inside = electrode.vertices.iter().any(|&p| held(&blisk, placement.transform_point3(p)))
                    || blisk.vertices.iter().any(|&p| held(&electrode, back.transform_point3(p)));
                sampled = if inside { 0.0 } else { sampled };
            }
        }
        // The other library's distances are good to about 1e-6.
        prop_assert!(certificate.certified() <= sampled + 1e-6, "{} {sampled}", certificate.certified());
        prop_assert!(certificate.least().distance - certificate.certified() <= options.resolution_mm + 1e-6);
        prop_assert!(certificate.least().distance >= sampled - step - 1e-6, "{} {sampled}", certificate.least().distance);
        prop_assert!(certificate.least().distance <= sampled + options.resolution_mm + 1e-6);

        let least = certificate.least();
        let moved = least.pose.placement(CENTER).transform_point3(least.on_electrode);
        prop_assert!((moved.distance(least.on_blisk) - least.distance).abs() < 1e-9);
    }

    #[test]
    fn distances_at_a_pose_are_those_of_another_library(
        blisk in any_tetrahedra(3.0), electrode in any_tetrahedra(3.0), pose in any_pose(6.0, 1.0),
    ) {
        let found = mesh_distance(&blisk, &electrode, CENTER, &pose).unwrap();
        let expected = ExactMesh::new(&blisk).unwrap()
            .distance_to(&ExactMesh::new(&electrode).unwrap(), &pose.placement(CENTER));
        prop_assert!((found.distance - expected).abs() < 1e-6, "{} {expected}", found.distance);
    }

    #[test]
    fn a_reversed_path_keeps_its_clearance(
        blisk in any_tetrahedra(3.0), electrode in any_tetrahedra(3.0), poses in prop::collection::vec(any_pose(2.0, 0.3), 3),
    ) {
        let electrode = electrode.mapped(|p| p + DVec3::X * 7.0);
        let reversed: Vec<_> = poses.iter().rev().copied().collect();
        let there = certify(&blisk, &electrode, &path(CENTER, 0.1, &poses));
        let back = certify(&blisk, &electrode, &path(CENTER, 0.1, &reversed));
        let resolution = VerifyOptions::default().resolution_mm + 1e-6;
        prop_assert!((there.least().distance - back.least().distance).abs() <= resolution);
        prop_assert!(there.row_clearance().iter().zip(back.row_clearance().iter().rev()).all(|(p, q)| (p - q).abs() < 1e-9));
    }

    #[test]
    fn turning_blisk_and_table_together_changes_nothing(
        blisk in any_tetrahedra(3.0), electrode in any_tetrahedra(3.0), angle in -3.0..3.0, poses in prop::collection::vec(any_pose(2.0, 0.3), 2),
    ) {
        let electrode = electrode.mapped(|p| p + DVec3::Y * 7.0);
        let turned_blisk = blisk.mapped(|p| DMat3::from_rotation_x(angle) * p);
        let turned: Vec<_> = poses.iter().map(|p| Pose { a: p.a + angle, ..*p }).collect();
        let plain = certify(&blisk, &electrode, &path(CENTER, 0.1, &poses));
        let moved = certify(&turned_blisk, &electrode, &path(CENTER, 0.1, &turned));
        let resolution = VerifyOptions::default().resolution_mm + 1e-6;
        prop_assert!((plain.least().distance - moved.least().distance).abs() <= resolution);
        prop_assert!((plain.row_clearance()[0] - moved.row_clearance()[0]).abs() < 1e-9);
    }
}

/// A hub of radius 40 and a pad around part of it, 0.1 mm further out; both are coarse facets, so that the true
/// gap depends on where the facets meet.
fn hub_and_pad() -> (Mesh, Mesh) {
    let on = |x: f64, r: f64, theta: f64| Cylindrical { x, r, theta }.point();
    let hub = grid(10, 180, |u, v| on(-20.0 + 40.0 * u, 40.0, (1.0 - 2.0 * v) * std::f64::consts::PI));
    let pad = grid(5, 16, |u, v| on(-4.0 + 8.0 * u, 40.1, -0.2 + 0.4 * v));
    (hub, pad)
}

#[test]
fn sliding_along_a_plane_keeps_exactly_the_gap() {
    let block = Mesh::cuboid(DVec3::new(50.0, 50.0, 5.0));
    let tool = Mesh::cuboid(DVec3::new(5.0, 5.0, 5.0)).mapped(|p| p + DVec3::new(10.0, 10.0, 5.1));
    for (c, error) in [(0.0, 1e-8), (2.0, VerifyOptions::default().resolution_mm)] {
        let poses = [Pose::from_array([20.0, 7.0, 0.0, 0.0, 0.0, c]), Pose::FINAL];
        let certificate = certify(&block, &tool, &path(DVec3::new(12.0, 13.0, 4.0), 0.1, &poses));
        assert!(
            certificate.certified() <= 0.1 && certificate.certified() >= 0.1 - error,
            "{}",
            certificate.certified()
        );
        assert!((certificate.least().distance - 0.1).abs() < 1e-12);
        assert!(!certificate.holds(), "it starts above the block, not outside");
    }
}

#[test]
fn sliding_around_a_hub_keeps_the_gap_of_its_facets() {
    let (hub, pad) = hub_and_pad();
    let poses: Vec<_> = (0..8).map(|i| Pose { x: 2.0 * i as f64, a: 0.07 * i as f64, ..Pose::FINAL }).rev().collect();
    let certificate = certify(&hub, &pad, &path(DVec3::new(0.0, 0.0, 40.0), 0.1, &poses));
    // The middle of a facet of the pad dips below the circle by 40.1 (1 - cos(0.0125)), and it passes over an
    // edge of the hub, whose vertices are on the circle.
    let expected = 40.1 * f64::cos(0.0125) - 40.0;
    assert!(certificate.certified() <= expected && certificate.certified() >= expected - 0.0005);
    assert!(certificate.least().distance >= expected - 1e-9);
    assert_eq!(certificate.row_clearance().len(), 8);
}

#[test]
fn a_dip_between_two_free_rows_is_caught() {
    // Half a turn about the tool axis: free at both ends, the long bar sweeps through the post on the way.
    let post = Mesh::cuboid(DVec3::new(1.0, 1.0, 10.0)).mapped(|p| p + DVec3::new(8.0, -0.5, 0.0));
    let bar = Mesh::cuboid(DVec3::new(1.0, 20.0, 2.0)).mapped(|p| p + DVec3::new(-0.5, -10.0, 5.0));
    let poses = [Pose { c: std::f64::consts::PI, ..Pose::FINAL }, Pose::FINAL];
    let certificate = certify(&post, &bar, &path(DVec3::ZERO, 0.1, &poses));
    assert!(certificate.row_clearance().iter().all(|&d| (d - 7.5).abs() < 1e-9));
    assert_eq!((certificate.certified(), certificate.least().distance <= 0.0005), (0.0, true));
    let row = certificate.least().row;
    assert!(row > 0.0 && row < 1.0 && !certificate.violations().is_empty());
    // Passing at a height of 0.05 mm above the post instead of through it.
    let over = bar.mapped(|p| p + DVec3::Z * 5.05);
    let certificate = certify(&post, &over, &path(DVec3::ZERO, 0.1, &poses));
    assert!(
        (certificate.certified() - 0.05).abs() < VerifyOptions::default().resolution_mm,
        "{}",
        certificate.certified()
    );
    assert!(certificate.violations().iter().all(|v| v.distance < 0.098));
    assert_eq!(&certificate.violations()[0], certificate.least());
}

#[test]
fn crossing_surfaces_and_an_electrode_inside_metal_have_no_clearance() {
    let block = Mesh::cuboid(DVec3::splat(10.0));
    let tool = Mesh::cuboid(DVec3::ONE);
    let away = Pose { x: 30.0, ..Pose::FINAL };
    for (place, starts_inside) in [(DVec3::splat(9.5), false), (DVec3::splat(4.0), true)] {
        let placed = tool.mapped(|p| p + place);
        let into = certify(&block, &placed, &path(DVec3::ZERO, 0.1, &[away, Pose::FINAL]));
        assert_eq!((into.certified(), into.least().distance, into.ends_right()), (0.0, 0.0, true));
        assert!(!into.holds());
        let without_gap = FeedPath { spark_gap: 0.0, ..path(DVec3::ZERO, 0.1, &[away, Pose::FINAL]) };
        let strict = VerifyOptions { tolerance_mm: 0.0, ..VerifyOptions::default() };
        assert!(
            !certify_with(&block, &placed, &without_gap, &strict).holds(),
            "a crossing is not good where no gap is asked for"
        );
        let still = certify(&block, &placed, &path(DVec3::ZERO, 0.1, &[Pose::FINAL, Pose::FINAL]));
        assert_eq!((still.certified(), still.least().distance, still.least().row), (0.0, 0.0, 0.0));
        assert_eq!(still.row_clearance(), [0.0, 0.0]);
        assert!(mesh_distance(&block, &placed, DVec3::ZERO, &Pose::FINAL).unwrap().distance > 0.0 || !starts_inside);
    }
    // And the other way round: a small part of the blisk inside a big electrode.
    let around = block.mapped(|p| p - 4.0);
    let swallowed = certify(&tool, &around, &path(DVec3::ZERO, 0.1, &[Pose::FINAL]));
    assert_eq!(swallowed.certified(), 0.0);
}

#[test]
fn no_certificate_is_made_with_a_tolerance_of_half_the_gap_or_more() {
    let block = Mesh::cuboid(DVec3::splat(10.0));
    let tool = Mesh::cuboid(DVec3::ONE).mapped(|p| p + DVec3::Z * 10.06);
    let path = |gap: f64| path(DVec3::ZERO, gap, &[Pose { x: 30.0, ..Pose::FINAL }, Pose::FINAL]);
    let certified = |gap: f64, tolerance_mm: f64| {
        let options = VerifyOptions { tolerance_mm, ..VerifyOptions::default() };
        verify(&block, &tool, &path(gap), &|_| Surface::Hub, &options, &Task::default())
    };
    // 0.06 mm are kept, of which nobody shall say that they are 0.1 or 1 mm.
    assert!(!certified(0.1, 0.0).unwrap().holds() && certified(0.1, 0.0499).unwrap().holds());
    for (gap, tolerance_mm) in [(0.1, 0.05), (0.1, 0.06), (1.0, 0.95), (0.1, -1e-9), (0.1, f64::NAN), (0.0, 1e-9)] {
        let error = certified(gap, tolerance_mm).unwrap_err();
        let VerifyError::Tolerance { tolerance_mm: t, spark_gap_mm } = &error else { panic!("{error}") };
        assert!(t.to_bits() == tolerance_mm.to_bits() && *spark_gap_mm == gap, "{error}");
    }
    assert!(certified(0.0, 0.0).unwrap().holds(), "a gap of nothing has no tolerance");
}

#[test]
fn the_side_of_entry_is_that_on_which_the_motion_begins() {
    let block = Mesh::cuboid(DVec3::new(10.0, 40.0, 5.0)).mapped(|p| p - DVec3::new(0.0, 20.0, 0.0));
    let tool = Mesh::cuboid(DVec3::ONE).mapped(|p| p + DVec3::new(4.0, 0.0, 6.0));
    let side = |x: f64, then: f64| {
        let poses = [Pose { x, ..Pose::FINAL }, Pose { x: then, ..Pose::FINAL }, Pose::FINAL];
        certify(&block, &tool, &path(DVec3::ZERO, 0.1, &poses)).enters_from()
    };
    assert_eq!((side(6.1, 0.0), side(-5.1, 0.0)), (Some(EntrySide::PlusX), Some(EntrySide::MinusX)));
    // Beyond the other side later on is not where it comes from, and within is nowhere.
    assert_eq!((side(6.1, -5.1), side(-5.1, 6.1)), (Some(EntrySide::PlusX), Some(EntrySide::MinusX)));
    assert_eq!((side(5.9, 6.1), side(0.0, -5.1)), (None, None));
}

#[test]
fn both_ends_of_the_path_have_to_be_right() {
    let block = Mesh::cuboid(DVec3::new(10.0, 40.0, 5.0)).mapped(|p| p - DVec3::new(0.0, 20.0, 0.0));
    let tool = Mesh::cuboid(DVec3::ONE).mapped(|p| p + DVec3::new(4.0, 0.0, 6.0));
    let ends_right =
        |first: Pose, last: Pose| certify(&block, &tool, &path(DVec3::ZERO, 0.1, &[first, last])).ends_right();
    let out = |x: f64| Pose { x, ..Pose::FINAL };
    assert!(ends_right(out(6.1), Pose::FINAL) && ends_right(out(-5.1), Pose::FINAL));
    assert!(!ends_right(out(5.9), Pose::FINAL) && !ends_right(out(-4.9), Pose::FINAL));
    assert!(!ends_right(out(6.1), out(1e-9)));
    let certificate = certify(&block, &tool, &path(DVec3::ZERO, 0.1, &[out(6.1), Pose::FINAL]));
    assert!(certificate.holds() && certificate.violations().is_empty());
}

#[test]
fn stopping_early_tells_a_violation_and_claims_nothing() {
    let (hub, pad) = hub_and_pad();
    let poses: Vec<_> =
        (0..100).map(|i| Pose { x: 0.2 * i as f64, z: -0.0005 * i as f64, ..Pose::FINAL }).rev().collect();
    let path = path(DVec3::new(0.0, 0.0, 40.0), 0.1, &poses);
    let stop = VerifyOptions { stop_at_violation: true, ..VerifyOptions::default() };
    let (early, full) = (certify_with(&hub, &pad, &path, &stop), certify(&hub, &pad, &path));
    assert_eq!(early.certified(), 0.0);
    assert!(
        !early.violations().is_empty()
            && early.violations().len() <= 16
            && early.pair_intervals() < full.pair_intervals()
    );
    assert!(full.violations().windows(2).all(|pair| pair[0].distance <= pair[1].distance));
    let fine = FeedPath { spark_gap: 0.0, ..path };
    let [stop, full] = [true, false].map(|stop_at_violation| {
        let options = VerifyOptions { tolerance_mm: 0.0, stop_at_violation, ..VerifyOptions::default() };
        certify_with(&hub, &pad, &fine, &options).certified()
    });
    assert_eq!(stop, full);
}

#[test]
fn a_path_beyond_the_travel_of_an_axis_is_not_verified() {
    let block = Mesh::cuboid(DVec3::new(10.0, 40.0, 5.0)).mapped(|p| p - DVec3::new(0.0, 20.0, 0.0));
    let tool = Mesh::cuboid(DVec3::ONE).mapped(|p| p + DVec3::new(4.0, 0.0, 6.0));
    let poses = [Pose { x: 8.0, z: 3.0, ..Pose::FINAL }, Pose { x: 6.0, c: -0.1, ..Pose::FINAL }, Pose::FINAL];
    let path = path(DVec3::ZERO, 0.1, &poses);
    let judged = |travel: Option<TravelLimits>| {
        let verifier = Verifier::new(&block, &tool, DVec3::ZERO, &Cancel::default()).unwrap();
        let verifier = match travel {
            Some(travel) => verifier.within(travel),
            None => verifier,
        };
        let (options, cancel) = (VerifyOptions::default(), Cancel::default());
        let c = verifier.verify(&path, &|_| Surface::Hub, &options, &Task::silent(&cancel)).unwrap();
        (c.travel(), c.holds())
    };
    let unlimited = TravelLimits::UNLIMITED;
    assert_eq!(judged(None), (TravelVerdict::NotJudged, true));
    assert_eq!(judged(Some(unlimited)), (TravelVerdict::Within, true));
    assert_eq!(judged(Some(unlimited.with(Axis::X, [0.0, 8.0]))), (TravelVerdict::Within, true));
    for (limits, axis, row, value, limit) in [
        (unlimited.with(Axis::X, [-1.0, 7.9]), Axis::X, 0, 8.0, 7.9),
        (unlimited.with(Axis::Z, [0.0, 0.0]), Axis::Z, 0, 3.0, 0.0),
        (unlimited.with(Axis::C, [-0.09, 1.0]), Axis::C, 1, -0.1, -0.09),
    ] {
        let beyond = BeyondTravel { axis, row, value, limit };
        assert_eq!(judged(Some(limits)), (TravelVerdict::Beyond(beyond), false));
    }
}

#[test]
fn the_certificate_names_what_was_verified() {
    let (hub, pad) = hub_and_pad();
    let path = path(DVec3::new(0.0, 0.0, 40.0), 0.1, &[Pose { x: 60.0, ..Pose::FINAL }, Pose::FINAL]);
    let c = certify(&hub, &pad, &path);
    assert_eq!([c.path_digest(), c.blisk_digest(), c.electrode_digest()], [path.digest(), hub.digest(), pad.digest()]);
}

#[test]
fn the_certificate_does_not_depend_on_the_number_of_threads() {
    let (hub, pad) = hub_and_pad();
    let poses: Vec<_> = (0..40)
        .map(|i| f64::from(i) / 4.0)
        .map(|s| Pose { x: s, a: 0.02 * s, z: 0.01 * (s * 2.0).sin().abs(), c: 0.003 * s, ..Pose::FINAL })
        .rev()
        .collect();
    let path = path(DVec3::new(0.0, 0.0, 40.0), 0.1, &poses);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let certificate = pool.install(|| certify(&hub, &pad, &path));
        serde_json::to_string(&certificate).unwrap()
    };
    assert_eq!(on(1), on(2));
    assert_eq!(on(1), on(5));
}

#[test]
fn bad_input_is_refused_in_plain_words() {
    let (mesh, empty) = (Mesh::cuboid(DVec3::ONE), Mesh::default());
    let surface = |_: DVec3| Surface::Elsewhere;
    let run = |blisk: &Mesh, path: &FeedPath, options: &VerifyOptions| {
        verify(blisk, &mesh, path, &surface, options, &Task::default()).unwrap_err().to_string()
    };
    let good = path(DVec3::ZERO, 0.1, &[Pose::FINAL]);
    let options = VerifyOptions::default();
    assert!(run(&empty, &good, &options).contains("blisk mesh has no triangles"));
    assert!(run(&mesh.mapped(|p| p / 0.0), &good, &options).contains("vertex 0 of the blisk"));
    assert!(run(&mesh, &path(DVec3::ZERO, 0.1, &[]), &options).contains("no rows"));
    let broken = path(DVec3::ZERO, 0.1, &[Pose::FINAL, Pose { b: f64::NAN, ..Pose::FINAL }]);
    assert!(run(&mesh, &broken, &options).contains("row 1"));
    let far = path(DVec3::ZERO, 0.1, &[Pose { x: 1e300, ..Pose::FINAL }]);
    assert!(run(&mesh, &far, &options).contains("row 0"));
    assert!(run(&mesh, &path(DVec3::ZERO, -0.1, &[Pose::FINAL]), &options).contains("spark gap"));
    assert!(run(&mesh, &good, &VerifyOptions { resolution_mm: 0.0, ..options }).contains("resolution_mm is 0"));
    let other = Verifier::new(&mesh, &mesh, DVec3::X, &Cancel::default()).unwrap();
    assert!(other.verify(&good, &surface, &options, &Task::default()).is_err());
}

#[test]
fn meshes_without_size_and_wild_motions_end_with_an_answer() {
    let point = Mesh { vertices: vec![DVec3::ZERO; 3], triangles: vec![[0, 1, 2]; 9] };
    let other = point.mapped(|p| p + DVec3::new(0.0, 30.0, 0.0));
    let poses = [Pose { y: -60.0, x: 3.0, ..Pose::FINAL }, Pose::FINAL];
    let certificate = certify(&point, &other, &path(DVec3::ZERO, 0.1, &poses));
    // The straight line passes the origin at its middle, 1.5 along X, and is inclined by 3 in 60.
    let expected = 1.5 / (1.0 + 0.05f64 * 0.05).sqrt();
    assert!(certificate.certified() <= expected && certificate.certified() > expected - 0.001);
    let wild = [Pose::from_array([1e4, -1e4, 1e4, 900.0, -900.0, 900.0]), Pose::FINAL];
    let certificate = certify(&point, &other.mapped(|p| p - DVec3::Y * 29.0), &path(DVec3::ZERO, 0.1, &wild));
    assert!(certificate.least().distance - certificate.certified() <= 0.0005 + 1e-9);
}

#[test]
fn a_raised_flag_stops_the_work() {
    let (hub, pad) = hub_and_pad();
    let cancel = Cancel::default();
    cancel.cancel();
    let path = path(DVec3::ZERO, 0.1, &[Pose { x: 5.0, ..Pose::FINAL }, Pose::FINAL]);
    let verdict = verify(&hub, &pad, &path, &|_| Surface::Hub, &VerifyOptions::default(), &Task::silent(&cancel));
    assert_eq!(verdict.unwrap_err(), VerifyError::Cancelled(Cancelled));
}

#[test]
fn placements_used_inside_are_those_of_the_pose() {
    let pose = Pose::from_array([1.0, 2.0, 3.0, 0.1, 0.2, 0.3]);
    let tool = Mesh::cuboid(DVec3::ONE).mapped(|p| p + CENTER);
    let verifier = Verifier::new(&Mesh::cuboid(DVec3::ONE), &tool, CENTER, &Cancel::default()).unwrap();
    let moved = |placement: DAffine3| tool.mapped(|p| placement.transform_point3(p));
    let clearance = verifier.distance(&pose);
    let expected = ExactMesh::new(&Mesh::cuboid(DVec3::ONE))
        .unwrap()
        .distance_to(&ExactMesh::new(&moved(pose.placement(CENTER))).unwrap(), &DAffine3::IDENTITY);
    assert!((clearance.distance - expected).abs() < 1e-6);
    let on_electrode = pose.placement(CENTER).transform_point3(clearance.on_electrode);
    assert!((on_electrode.distance(clearance.on_blisk) - clearance.distance).abs() < 1e-12);
}

fn mesh_distance(
    blisk: &Mesh,
    electrode: &Mesh,
    reference_point: DVec3,
    pose: &Pose,
) -> Result<Clearance, VerifyError> {
    Ok(Verifier::new(blisk, electrode, reference_point, &Cancel::default())?.distance(pose))
}
