//! Sectors of wheels: what is found in one is what is found in the whole wheel.

use std::f64::consts::TAU;

use glam::{DAffine3, DQuat, DVec2, DVec3, EulerRot, Vec3Swizzles as _};

use super::random_wheels::{faulty, wrong};
use super::tests::{coarse, find, found, refused};
use crate::channel::Station;
use crate::error::{BliskError, Misleading};
use crate::fixtures::{TestBlisk, flange, turned_part};
use crate::options::{Auto, AxisChoice, AxisLine, BliskOptions};
use crate::parametric::wheel::{MeridianCurve, ParametricWheel, Splitters};
use geometry::frame::Cylindrical;
use geometry::mesh::Mesh;
use geometry::solid::{intersection, prism, union, wound};
use import::ImportOptions;
use task::Task;

/// The part of a wheel about X between two angles (rad).
fn sector(wheel: &Mesh, from: f64, angle: f64) -> Mesh {
    let at = |theta: f64| -> DVec2 { Cylindrical { x: 0.0, r: 1e3, theta }.point().yz() };
    let outline = [DVec2::ZERO, at(from), at(from + 0.5 * angle), at(from + angle)];
    let wedge = prism(&[&outline], -500.0, 500.0).unwrap().mapped(|p| DVec3::new(p.z, p.x, p.y));
    intersection(wheel, &wedge).unwrap()
}

#[test]
fn a_sector_is_the_wheel_that_it_was_cut_from() {
    let part = TestBlisk::default();
    let (wheel, pitch) = (part.mesh(), part.pitch());
    let whole = found(&wheel);
    let turn = DQuat::from_euler(EulerRot::XYZ, 0.3, -0.8, 1.1);
    // Cut through passages and through blades; whole pitches that divide the wheel and that do not, and none.
    for (from, pitches) in [(0.1, 4.0), (0.45, 3.0), (0.2, 5.0), (0.3, 2.7), (0.7, 7.3), (0.25, 1.0)] {
        let cut = sector(&wheel, from * pitch, pitches * pitch).mapped(|p| turn * p + DVec3::new(5.0, -80.0, 33.0));
        let channel = find(&cut, &BliskOptions::default()).unwrap_or_else(|e| panic!("{pitches} pitches: {e}"));
        assert_eq!((channel.blades, channel.kinds), (part.blades, 1), "{pitches} pitches");
        assert!(channel.unlike.is_empty(), "{pitches} pitches: {:?}", channel.unlike);
        let middle = Cylindrical { x: 0.0, r: 1.0, theta: (from + 0.5 * pitches) * pitch }.point();
        let off = (turn * middle).angle_between(channel.frame.z);
        assert!(off < 0.5 * pitch + 1e-3, "channel 0 is {off} rad off the middle of the sector");
        let again = channel.wheel_in_w(&cut);
        assert!(again.is_watertight());
        assert!((again.volume() / wheel.volume() - 1.0).abs() < 1e-4, "{pitches}: {}", again.volume());
        let (throat, turning) = (channel.throat.width_mm - whole.throat.width_mm, channel.turning - whole.turning);
        assert!(throat.abs() < 0.005 && turning.abs() < 1e-3, "{pitches} pitches: {throat} {turning}");
        assert!(channel.assumed[0].contains("is a sector"), "{:?}", channel.assumed);
    }
}

/// Bolt holes are not blades that do not repeat.
#[test]
fn holes_that_are_not_as_many_as_the_blades_do_not_refuse_a_sector() {
    let wheel = ParametricWheel { blades: 7, holes: 6, ..coarse(ParametricWheel::demonstration()) };
    let mesh = wheel.mesh();
    for from in [0.2, 0.6] {
        let cut = sector(&mesh, from * wheel.pitch(), 3.15 * wheel.pitch());
        let channel = find(&cut, &BliskOptions::default()).unwrap_or_else(|e| panic!("from {from}: {e}"));
        assert_eq!(channel.blades, 7, "from {from}");
    }
}

/// In a sector of one pitch no two blades stand a pitch apart: the angle between its cuts tells their number.
#[test]
fn a_sector_of_one_pitch_is_recognised() {
    let without_holes = ParametricWheel { holes: 0, ..ParametricWheel::demonstration() };
    for wheel in [without_holes, coarse(ParametricWheel::nozzle_ring())] {
        let mesh = wheel.mesh();
        for from in [0.1, 0.6] {
            let cut = sector(&mesh, from * wheel.pitch(), wheel.pitch());
            let channel = find(&cut, &BliskOptions::default()).unwrap_or_else(|e| panic!("from {from}: {e}"));
            assert_eq!(channel.blades, wheel.blades, "from {from}");
        }
    }
}

/// Least distance between the two blades beside a passage of `wheel`, by brute force over places on them.
fn least_width(wheel: &ParametricWheel) -> f64 {
    const PLACES: [usize; 2] = [160, 24];
    let [from, to] = wheel.span;
    let shares = |i: usize| (0..=PLACES[i]).map(move |k| k as f64 / PLACES[i] as f64);
    let places = shares(0).flat_map(|along| shares(1).map(move |height| (from + (to - from) * along, height)));
    let wall = |side: usize| -> Vec<DVec3> {
        let point = |(along, height)| {
            let DVec2 { x, y: r } = wheel.place(along, height);
            Some(Cylindrical { x, r, theta: wheel.walls(0, along, height)?[side] }.point())
        };
        places.clone().filter_map(point).collect()
    };
    let [low, high] = [wall(0), wall(1)];
    let to_high = |p: &DVec3| high.iter().map(|q| p.distance_squared(*q)).fold(f64::INFINITY, f64::min);
    low.iter().map(to_high).fold(f64::INFINITY, f64::min).sqrt()
}

/// A passage is as wide as its blades stand apart, with fillets and without.
#[test]
fn fillets_do_not_make_the_throat_narrower() {
    let [axial, mixed, radial] =
        [ParametricWheel::demonstration(), ParametricWheel::impeller(), ParametricWheel::nozzle_ring()];
    // Radii as shares of the height.
    for (wheel, share) in [(axial, 0.15), (mixed, 0.15), (radial, 0.05)] {
        let plain = ParametricWheel { fillet_mm: 0.0, ..wheel };
        let height = plain.hub.0[1].distance(plain.shroud.0[1]);
        let width = |wheel: &ParametricWheel| found(&wheel.mesh()).throat.width_mm;
        let expected = width(&plain);
        let least = least_width(&plain);
        assert!((expected / least - 1.0).abs() < 0.005, "{expected} for {least}");
        let filleted = width(&ParametricWheel { fillet_mm: share * height, fillet_pieces: 8, ..plain });
        assert!((filleted / expected - 1.0).abs() < 0.03, "R {share} of the height: {filleted} for {expected}");
    }
}

/// A passage between cones, whose ends are square to it: steeper than the axis's and flatter than the radius's.
#[test]
fn passages_between_cones_of_any_angle_are_found() {
    for degrees in [20.0_f64, 44.0, 46.0, 55.0] {
        let along = DVec2::from_angle(degrees.to_radians());
        let (from, up) = (DVec2::new(0.0, 40.0), along.perp());
        let line = |height: f64, narrower: f64| {
            MeridianCurve::line(from + height * up, from + 30.0 * along + narrower * height * up)
        };
        let wheel = ParametricWheel {
            blades: 16,
            hub: line(0.0, 1.0),
            shroud: line(10.0, 0.8),
            wrap: [0.4; 2],
            ..coarse(ParametricWheel::nozzle_ring())
        };
        let channel = find(&wheel.mesh(), &BliskOptions::default()).unwrap_or_else(|e| panic!("{degrees} deg: {e}"));
        let (width, least) = (channel.throat.width_mm, least_width(&wheel));
        assert!(channel.shrouded && channel.blades == 16, "{degrees} deg");
        assert!((width / least - 1.0).abs() < 0.005, "{degrees} deg: {width} for {least}");
    }
}

/// Half a wheel is bounded by one plane, and one blade of a radial wheel turns about itself as well: a tall one between
/// thin rings more than about the axis, and the rings' facets are planes like the cuts.
#[test]
fn half_a_wheel_and_one_pitch_of_it_are_the_wheel() {
    let ring = coarse(ParametricWheel::nozzle_ring());
    let shroud = MeridianCurve::line(DVec2::new(20.0, 68.0), DVec2::new(20.0, 104.0));
    let tall = ParametricWheel { shroud, wall_mm: 2.0, span: [0.02, 0.98], ..ring.clone() };
    // Blades of one shell with the rings, as solid modellers write them.
    let [ring_mesh, tall_mesh] = [&ring, &tall].map(|ring| wound(&ring.mesh()).unwrap());
    let pitch = ring.pitch();
    let turn = DQuat::from_euler(EulerRot::XYZ, 0.3, -0.8, 1.1);
    let half = 0.5 * TAU;
    let cuts = [(&ring_mesh, 0.3, half), (&ring_mesh, 0.0, half), (&ring_mesh, 0.4, pitch)];
    for (wheel, from, angle) in cuts.into_iter().chain([(&tall_mesh, 0.3, pitch)]) {
        let cut = sector(wheel, from * pitch, angle).mapped(|p| turn * p + DVec3::new(5.0, -80.0, 33.0));
        let channel = find(&cut, &BliskOptions::default()).unwrap_or_else(|e| panic!("{from} {angle}: {e}"));
        assert_eq!((channel.blades, channel.kinds, channel.unlike.len()), (ring.blades, 1, 0));
        let again = channel.wheel_in_w(&cut).volume();
        assert!((again / wheel.volume() - 1.0).abs() < 1e-3, "{again} of {}", wheel.volume());
        assert!(channel.assumed[0].contains("wheel of 20 blades"), "{:?}", channel.assumed);
        // The arcs of the mesh tell the axis of half a wheel as two cuts do.
        let (axis, moved) = (turn * DVec3::X, turn * DVec3::ZERO + DVec3::new(5.0, -80.0, 33.0));
        let off = (channel.frame.origin - moved).reject_from_normalized(axis).length();
        assert!(channel.frame.x.cross(axis).length() < 1e-8 && off < 1e-6, "{} {off}", channel.frame.x);
        // One blade alone tells no pitch.
        let is_by_angle = channel.assumed[0].contains("holds no two blades that are alike");
        assert_eq!(is_by_angle, angle == pitch, "{:?}", channel.assumed);
        // One cut of each kind is enough for what is given by hand.
        if from == 0.0 {
            continue;
        }
        // What is given and right is right of a sector, too, where a blade alone looks like a wheel of a few.
        let axis = AxisChoice::Line(AxisLine { direction: axis.into(), point: moved.into() });
        let right = [
            BliskOptions { axis, ..Default::default() },
            BliskOptions { blades: Auto::Given(ring.blades), ..Default::default() },
        ];
        for options in right {
            assert_eq!(find(&cut, &options).unwrap_or_else(|e| panic!("{from} {angle}: {e}")).blades, ring.blades);
        }
        let wrong = BliskOptions { blades: Auto::Given(ring.blades + 3), ..Default::default() };
        let error = find(&cut, &wrong).unwrap_err();
        assert!(matches!(error, BliskError::Misleading { blades: 20, .. }), "{error}");
    }
}

/// The passage between main blades before their splitters begin can be taken by hand.
#[test]
fn a_passage_may_end_where_splitters_begin() {
    let part = ParametricWheel { splitters: vec![Splitters::over([0.6, 0.95])], ..ParametricWheel::impeller() };
    let options = BliskOptions { blades: Auto::Given(part.blades / 2), ..Default::default() };
    match find(&part.mesh(), &options) {
        Ok(channel) => assert_eq!((channel.blades, channel.unlike.len()), (part.blades / 2, 0)),
        Err(error) => assert!(!matches!(error, BliskError::Obstructed { .. }), "{error}"),
    }
}

#[test]
fn a_sector_without_a_bore_is_a_wheel_without_one() {
    let part = TestBlisk::default();
    let around: Vec<DVec2> = (0..64).map(|i| DVec2::from_angle(TAU * f64::from(i) / 64.0) * 42.0).collect();
    let core = prism(&[&around], 1.0, 9.0).unwrap().mapped(|p| DVec3::new(p.z, p.x, p.y));
    let wheel = union(&part.mesh(), &core).unwrap();
    let whole = found(&wheel);
    let cut = sector(&wheel, 0.1 * part.pitch(), 4.0 * part.pitch());
    let channel = found(&cut);
    assert_eq!(channel.blades, whole.blades);
    assert!((channel.wheel_in_w(&cut).volume() / wheel.volume() - 1.0).abs() < 1e-3);
}

#[test]
fn axis_and_blades_of_a_sector_may_be_given() {
    let part = TestBlisk::default();
    let (wheel, pitch) = (part.mesh(), part.pitch());
    let cut = sector(&wheel, 0.1 * pitch, 3.0 * pitch);
    let given = |direction, blades| BliskOptions {
        axis: AxisChoice::Line(AxisLine { direction, point: [0.0; 3] }),
        blades: Auto::Given(blades),
        ..Default::default()
    };
    assert_eq!(find(&cut, &given([1.0, 0.0, 0.0], part.blades)).unwrap().blades, part.blades);
    // No sector about that line, and no wheel of that many blades.
    assert!(find(&cut, &given([0.0, 1.0, 0.0], part.blades)).is_err());
    let error = find(&cut, &given([1.0, 0.0, 0.0], part.blades + 1)).unwrap_err();
    assert!(matches!(error, BliskError::Misleading { given: Misleading::Blades, .. }), "{error}");
    assert_eq!(error.axis().unwrap().direction, DVec3::X);
}

/// A few blades of a sector look like a wheel of their own, and the facets of its rings repeat at every part of a turn that
/// they divide.
#[test]
fn a_sector_with_too_few_blades_asks_for_their_number() {
    let coarse = [112, 36, 4];
    let cases = [(3, 0.3, coarse), (5, 0.3, coarse), (5, 0.44, coarse), (5, 0.45, [160, 48, 8]), (5, 0.66, coarse)];
    for (blades, from, pieces) in cases {
        let ring = ParametricWheel { blades, pieces, ..ParametricWheel::nozzle_ring() };
        let (wheel, pitch) = (wound(&ring.mesh()).unwrap(), ring.pitch());
        let cut = sector(&wheel, from * pitch, 1.3 * pitch);
        match find(&cut, &BliskOptions::default()) {
            Ok(channel) => assert_eq!(channel.blades, blades, "{from}"),
            Err(error) => assert!(error.to_string().contains("blisk.blades"), "{blades} blades, {from}: {error}"),
        }
        let given = BliskOptions { blades: Auto::Given(blades), ..BliskOptions::default() };
        let channel = find(&cut, &given).unwrap_or_else(|e| panic!("{blades} blades, {from}: {e}"));
        assert_eq!(channel.blades, blades, "{from}");
    }
}

#[test]
fn what_no_wheel_can_be_made_of_is_refused() {
    let part = TestBlisk::default();
    let (wheel, pitch) = (part.mesh(), part.pitch());
    let narrow = refused(&sector(&wheel, 0.1 * pitch, 0.6 * pitch));
    assert!(narrow.contains("is a sector"), "{narrow}");
    let holes = refused(&sector(&flange(20.0, 60.0, 8, 6.0), 0.3, TAU / 8.0));
    assert!(!holes.contains("is a sector"), "a piece of a flange has no blades: {holes}");
    // The blades repeat, but what they stand on does not: the place is named.
    let half = 20.0;
    let square = [[-half, -half], [-half, half], [half, half], [half, -half]].map(DVec2::from);
    let disk: Vec<DVec2> = (0..90).map(|i| DVec2::from_angle(TAU * f64::from(i) / 90.0) * 45.0).collect();
    let disk = prism(&[&disk, &square], 1.0, 9.0).unwrap().mapped(|p| DVec3::new(p.z, p.x, p.y));
    let bore = refused(&sector(&union(&wheel, &disk).unwrap(), 0.0, 2.3 * pitch));
    assert!(bore.contains("not congruent"), "{bore}");
    let r: f64 = bore.split(", r ").nth(1).and_then(|r| r.split(' ').next()).unwrap().parse().unwrap();
    assert!((half - 0.1..1.5 * half).contains(&r), "{bore}");
    let ring = [[0.0, 40.0], [10.0, 40.0], [10.0, 60.0], [0.0, 60.0]];
    let message = refused(&sector(&turned_part(&ring, 90), 0.1, TAU / 9.0));
    assert!(!message.contains("is a sector"), "a piece of a ring has no blades: {message}");
    // One blade of three is bent: whatever is kept of the sector, its ends do not fit or its blades differ.
    let bent = wheel.mapped(|p| {
        let c = Cylindrical::from_point(p);
        let is_first = (c.theta.rem_euclid(TAU) / pitch - 0.5).floor() == 0.0;
        let bent = if is_first { 0.03 * pitch * (TAU * c.x / part.chord).sin() } else { 0.0 };
        Cylindrical { theta: c.theta + bent, ..c }.point()
    });
    match find(&sector(&bent, 0.1 * pitch, 4.0 * pitch), &BliskOptions::default()) {
        Err(_) => {}
        Ok(channel) => assert!(!channel.unlike.is_empty(), "{:?}", channel.assumed),
    }
}

/// Wheels of all kinds, cut where it happens to be.
#[test]
fn sectors_of_random_wheels_are_recognised() {
    let faulty = faulty(|case| {
        let (wheel, pitch) = (&case.wheel, case.wheel.pitch());
        let most = 0.45 * wheel.blades as f64;
        // With two kinds of blades two of each must be there.
        let kinds = wheel.kinds() as f64;
        let random = |k: f64| (k * (wheel.wrap[0] + wheel.thickness_mm)).sin().abs();
        let pitches = (2.0 * kinds + 3.0 * random(71.0)).min(most);
        if pitches < 2.0 * kinds {
            return Vec::new();
        }
        // Half of them are cut whole pitches apart.
        let pitches = if random(37.0) < 0.5 { pitches.floor() } else { pitches };
        let cut = sector(&wheel.mesh_at(DAffine3::IDENTITY), random(53.0) * pitch, pitches * pitch);
        let placed = cut.mapped(|p| case.placement.transform_point3(p));
        match find(&placed, &BliskOptions::default()) {
            Ok(channel) => wrong(case, &channel),
            Err(error) => vec![format!("{pitches} pitches of {} are refused: {error}", wheel.blades)],
        }
    });
    assert!(faulty.is_empty(), "{faulty}");
}

/// An STL file holds no parts: what the import makes of shells that cross is what is recognised.
#[test]
fn a_wheel_of_shells_that_cross_is_the_same_from_a_file() {
    let splitters = vec![Splitters::over([0.5, 0.95])];
    let impeller =
        ParametricWheel { blades: 18, thickness_mm: 1.5, pieces: [120, 48, 8], ..ParametricWheel::impeller() };
    for wheel in [impeller.clone(), ParametricWheel { splitters, ..impeller }] {
        let mesh = wheel.mesh();
        let inside_out =
            Mesh { triangles: mesh.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect(), ..mesh.clone() };
        for (mesh, turned) in [(&mesh, 0), (&inside_out, wheel.blades + 2)] {
            let file = import::stl_bytes(mesh).unwrap();
            let imported =
                import::import_bytes("wheel.stl", &file, &ImportOptions::default(), &Task::default()).unwrap();
            let report = &imported.report;
            assert_eq!((report.components, report.components_turned, report.cavities), (wheel.blades + 2, turned, 0));
            assert!((imported.mesh.volume() / wheel.mesh().volume() - 1.0).abs() < 1e-5);
            let channel = found(&imported.mesh);
            let kinds = wheel.kinds();
            assert_eq!((channel.blades, channel.kinds, channel.unlike.len()), (wheel.blades, kinds, 0));
        }
    }
}

/// Between large fillets a narrow strip is left of the hub.
#[test]
fn between_large_fillets_the_hub_is_the_strip_that_they_leave() {
    let axial = ParametricWheel { fillet_mm: 4.0, ..ParametricWheel::demonstration() };
    let mixed = ParametricWheel { blades: 14, fillet_mm: 2.5, ..ParametricWheel::impeller() };
    for part in [axial, mixed] {
        let channel = found(&part.mesh());
        let curve: Vec<DVec2> = (0..=4000).map(|i| part.place(f64::from(i) / 4000.0, 0.0)).collect();
        let span = channel.span_along();
        let off = |s: &Station| curve.iter().map(|p| p.distance(s.hub)).fold(f64::INFINITY, f64::min);
        let between = channel.meridian.iter().filter(|s| (span[0]..span[1]).contains(&s.along));
        let off = between.map(off).fold(0.0, f64::max);
        assert!(off < 0.05, "{} blades: {off}", part.blades);
    }
}
