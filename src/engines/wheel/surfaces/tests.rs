use std::f64::consts::PI;

use glam::DAffine3;

use super::SurfaceClass::*;
use super::*;
use crate::find_channel::find_channel;
use crate::fixtures::TestBlisk;
use crate::options::{AxisChoice, AxisLine, BliskOptions};
use crate::parametric::wheel::{MeridianCurve, ParametricWheel, Splitters};

/// Pieces of a fillet of a parametric wheel.
const ROUNDS: usize = 8;
const PIECES: [usize; 3] = [160, 48, 6];

fn classes(mesh: &Mesh) -> (SurfaceClasses, Channel) {
    let channel = find_channel(mesh, &BliskOptions::default(), &Task::default()).unwrap();
    (classify(mesh, &channel, &[], &Task::default()).unwrap(), channel)
}

/// The class of every triangle of a wheel, from the order in which its shells are made; none where it is open to
/// taste: flat ends of blades, and the hub away from the blades of a wheel without shroud.
fn truth(part: &ParametricWheel) -> Vec<Option<SurfaceClass>> {
    let [around, along, across] = part.pieces;
    let mut all = Vec::new();
    let mut quad = |class| all.extend([class; 2]);
    let walls: &[SurfaceClass] = if part.shrouded { &[Hub, Shroud] } else { &[Hub] };
    for wall in walls {
        for i in (0..around).flat_map(|_| 0..2 * (along + 1)) {
            let share = (i as f64 + 0.5) / along as f64;
            let span = part.span_of_all();
            let is_beside = part.shrouded || (span[0]..span[1]).contains(&share);
            quad(if i >= along { Some(Elsewhere) } else { is_beside.then_some(*wall) });
        }
    }
    let rounds = if part.fillet_mm > 0.0 { ROUNDS } else { 0 };
    let mut rows = vec![[Elsewhere; 2]];
    rows.extend(vec![[HubFillet; 2]; rounds]);
    for k in 0..part.blades {
        let splitter = part.splitter(k);
        let sides = if splitter.is_some() { [SplitterLow, SplitterHigh] } else { [MainLow, MainHigh] };
        let mut rows = rows.clone();
        rows.extend(vec![sides; across]);
        if part.shrouded {
            rows.extend(vec![[ShroudFillet; 2]; rounds]);
            rows.push([Elsewhere; 2]);
        }
        let span = splitter.map_or(part.span, |s| s.span);
        for i in 0..along {
            let share = span[0] + (span[1] - span[0]) * (i as f64 + 0.5) / along as f64;
            // Without a shroud the flow path is known beside the splitters alone.
            let is_known = part.shrouded || share >= part.span_of_all()[0];
            rows.iter().flatten().for_each(|class| quad(is_known.then_some(*class)));
        }
        (0..2 * rows.len()).for_each(|_| quad(None));
        let top = if part.shrouded { Elsewhere } else { Tip };
        for i in 0..along {
            let share = span[0] + (span[1] - span[0]) * (i as f64 + 0.5) / along as f64;
            let is_known = part.shrouded || share >= part.span_of_all()[0];
            [Elsewhere, top].into_iter().for_each(|class| quad(is_known.then_some(class)));
        }
    }
    all
}

/// Share of the area whose class is the true one.
fn share_right(mesh: &Mesh, found: &SurfaceClasses, truth: &[Option<SurfaceClass>]) -> f64 {
    assert_eq!((found.classes.len(), truth.len()), (mesh.triangles.len(), mesh.triangles.len()));
    let (mut right, mut all) = (0.0, 0.0);
    for ((class, truth), corners) in found.classes.iter().zip(truth).zip(mesh.iter_corners()) {
        let area = normal_times_two_areas(corners).length();
        if let Some(truth) = truth {
            all += area;
            right += if class == truth { area } else { 0.0 };
        }
    }
    right / all
}

fn area(found: &SurfaceClasses, class: SurfaceClass) -> f64 {
    found.areas.iter().find(|a| a.class == class).map_or(0.0, |a| a.area_mm2)
}

#[test]
fn fillets_have_the_radius_and_the_area_that_they_were_made_with() {
    // Blades along the radius, so that the section across a fillet is the circle that it was made from.
    for fillet_mm in [0.6, 1.0, 1.6] {
        let part = ParametricWheel { wrap: [0.0; 2], fillet_mm, pieces: PIECES, ..ParametricWheel::nozzle_ring() };
        let mesh = part.mesh();
        let (found, _) = classes(&mesh);
        for radius in [found.hub_fillet_mm, found.shroud_fillet_mm] {
            let radius = radius.unwrap();
            assert!((radius / fillet_mm - 1.0).abs() < 0.02, "{radius} for {fillet_mm}");
        }
        let right = share_right(&mesh, &found, &truth(&part));
        assert!(right > 0.99, "{fillet_mm}: {right}");
        // Two sides of 20 blades that are 0.8 of 36 mm long, in 8 chords; and the lower ends of their edges.
        let quarter = 16.0 * fillet_mm * (PI / 32.0).sin();
        let [least, most] = [0.0, 2.0 * 1.04 * fillet_mm * (3.0 + 2.0 * fillet_mm)];
        for class in [HubFillet, ShroudFillet] {
            let each = area(&found, class) / 20.0 - 2.0 * quarter * 28.8;
            assert!((0.98 * least - 0.5..most).contains(&each), "{each} beyond the fillets themselves");
        }
        let ring = PI * (104f64.powi(2) - 68f64.powi(2));
        for class in [Hub, Shroud] {
            assert!((area(&found, class) / ring - 1.0).abs() < 0.003, "{}", area(&found, class));
        }
    }
}

#[test]
fn blades_are_told_by_kind_and_side() {
    let splitters = vec![Splitters { off_middle: 0.03, ..Splitters::over([0.5, 0.95]) }];
    let part =
        ParametricWheel { blades: 14, thickness_mm: 2.0, splitters, pieces: PIECES, ..ParametricWheel::impeller() };
    for shrouded in [true, false] {
        let part = ParametricWheel { shrouded, ..part.clone() };
        let mesh = part.mesh();
        let (found, channel) = classes(&mesh);
        assert_eq!((channel.kinds, found.hub_fillet_mm, found.shroud_fillet_mm), (2, None, None));
        let right = share_right(&mesh, &found, &truth(&part));
        assert!(right > 0.97, "shroud {shrouded}: {right}");
        // Of the two sides of a blade of even thickness neither is larger by much.
        let [low, high] = [MainLow, MainHigh].map(|class| area(&found, class));
        assert!((low / high - 1.0).abs() < 0.1, "{low} {high}");
        assert!(area(&found, SplitterLow) < 0.8 * low, "splitters are shorter");
        assert_eq!(area(&found, Tip) > 0.0, !shrouded);
        let sum: f64 = found.areas.iter().map(|a| a.area_mm2).sum();
        assert!((sum / mesh.area() - 1.0).abs() < 1e-9, "every triangle has one class");
    }
}

#[test]
fn a_welded_blisk_turned_over_and_about_has_the_same_classes() {
    let part = TestBlisk { fillet: 1.0, twist: 0.0, beta: [0.0, 0.0], grid: [32, 32, 12, 2], ..Default::default() };
    let mesh = part.mesh();
    let (found, channel) = classes(&mesh);
    let inside_out = mesh.turned_over();
    assert_eq!(classify(&inside_out, &channel, &[], &Task::default()).unwrap(), found);
    let turn = glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -0.4, 0.2);
    let (turned, _) = classes(&mesh.mapped(|p| turn * p + DVec3::new(3.0, -40.0, 12.0)));
    for (a, b) in found.areas.iter().zip(&turned.areas) {
        assert!(a.class == b.class && (a.area_mm2 - b.area_mm2).abs() < 0.01 * found.areas[0].area_mm2, "{a:?} {b:?}");
    }
    // The rings beside the blades belong to hub and shroud; the bore and the outer skin do not.
    let [hub, shroud] = [Hub, Shroud].map(|class| area(&found, class));
    let whole = |r: f64, length: f64| 2.0 * PI * r * length;
    assert!(hub > 0.5 * whole(50.0, 20.0) && hub < whole(50.0, 20.0), "{hub}");
    assert!(shroud > 0.5 * whole(62.0, 20.0) && shroud < whole(62.0, 20.0), "{shroud}");
    assert!(area(&found, Elsewhere) > whole(30.0, 20.0) + whole(66.0, 20.0));
}

#[test]
fn work_stops_when_told_to() {
    let (mesh, cancel) = (TestBlisk::default().mesh(), task::Cancel::default());
    let (_, channel) = classes(&mesh);
    cancel.cancel();
    assert_eq!(classify(&mesh, &channel, &[], &Task::silent(&cancel)), Err(Cancelled));
}

/// Which blades are main blades is a matter of the wheel, however it is turned and whichever channel is chosen: between two
/// splitters the longer one is none, and ahead of splitters strongly bent blades go on past the next one's place.
#[test]
fn main_blades_are_those_of_the_wheel_whichever_channel_is_chosen() {
    let splitters = |froms: &[f64]| froms.iter().map(|from| Splitters::over([*from, 0.95])).collect();
    let impeller = ParametricWheel { thickness_mm: 1.5, pieces: PIECES, ..ParametricWheel::impeller() };
    let three = ParametricWheel { blades: 15, splitters: splitters(&[0.35, 0.6]), ..impeller.clone() };
    let other_way = ParametricWheel { wrap: [-1.2; 2], ..three.clone() };
    let bent = ParametricWheel { blades: 16, splitters: splitters(&[0.6]), wrap: [2.2, -0.4], ..impeller };
    for part in [three, other_way, bent] {
        let truth = truth(&part);
        for (index, turn) in [0.0, 0.1, 0.35].into_iter().enumerate() {
            let mesh = part.mesh_at(DAffine3::from_rotation_x(turn));
            let mesh = if index == 2 { mesh.turned_over() } else { mesh };
            let options = BliskOptions { channel: index % part.kinds(), ..Default::default() };
            let channel = find_channel(&mesh, &options, &Task::default()).unwrap();
            assert_eq!((channel.kinds, channel.unlike.len()), (part.kinds(), 0), "{turn}");
            let found = classify(&mesh, &channel, &[], &Task::default()).unwrap();
            let right = share_right(&mesh, &found, &truth);
            assert!(right > 0.97, "{} of {}, turned {turn}: {right}", channel.index, part.kinds());
        }
    }
}

/// The axis that is found from coarse blades lies off the true one by little: the faces that hub and tips end in then stand
/// aslant, and belong to no blade.
#[test]
fn faces_that_stand_aslant_belong_to_no_blade() {
    let across = |x: f64| DVec2::new(x, 50.0);
    let part = ParametricWheel {
        blades: 16,
        hub: MeridianCurve::line(across(0.0), across(30.0)),
        shroud: MeridianCurve::line(DVec2::new(0.0, 62.0), DVec2::new(30.0, 62.0)),
        shrouded: false,
        wrap: [0.3; 2],
        pieces: PIECES,
        ..ParametricWheel::nozzle_ring()
    };
    let mesh = part.mesh();
    let sides = |slope: f64| {
        let line = AxisLine { direction: [1.0, slope, 0.0], point: [0.0, 0.003, 0.0] };
        let options = BliskOptions { axis: AxisChoice::Line(line), ..Default::default() };
        let channel = find_channel(&mesh, &options, &Task::default()).unwrap();
        let found = classify(&mesh, &channel, &[], &Task::default()).unwrap();
        [MainLow, MainHigh, Hub].map(|class| area(&found, class))
    };
    let straight = sides(0.0);
    for slope in [1e-4, -1e-4, 3e-4] {
        for (aslant, straight) in sides(slope).into_iter().zip(straight) {
            assert!((aslant / straight - 1.0).abs() < 0.01, "{slope}: {aslant} for {straight}");
        }
    }
}
