//! Recognition of random wheels against the formulas that they were made from.

use std::cell::Cell;
use std::f64::consts::{PI, TAU};

use super::tests::{PIECES, coarse};
use super::*;
use crate::channel::Flow;
use crate::fixtures::together;
use crate::parametric::random::{random_wheel, shares};
use crate::parametric::wheel::{Flaws, MeridianCurve, ParametricWheel};
use geometry::frame::Cylindrical;
use glam::{DAffine3, DQuat, DVec2, DVec3, EulerRot};

/// A wheel, where it stands, and what it is.
#[derive(Debug, Clone)]
pub(super) struct Case {
    pub(super) wheel: ParametricWheel,
    pub(super) placement: DAffine3,
    flow: Flow,
}

/// Wheel number `number` of a fixed sequence, at any place in any size.
fn case(number: usize) -> Case {
    let mut share = shares(number as u64);
    let (wheel, flow) = random_wheel(number, &mut share);
    let mut within = |least: f64, most: f64| least + (most - least) * share();
    let turn = DQuat::from_euler(EulerRot::ZYX, within(-PI, PI), within(-1.5, 1.5), within(-PI, PI));
    let shift = DVec3::new(within(-200.0, 200.0), within(-200.0, 200.0), within(-200.0, 200.0));
    let size = 10f64.powf(within(-1.0, 1.5));
    Case { wheel, placement: DAffine3::from_scale_rotation_translation(DVec3::splat(size), turn, size * shift), flow }
}

/// The shares of passage and height of a place (x, r).
fn shares_of(wheel: &ParametricWheel, place: DVec2) -> [f64; 2] {
    let (mut along, mut height) = (0.5, 0.5);
    for _ in 0..200 {
        let h = 1e-6;
        let at = wheel.place(along, height);
        let [du, dv] = [wheel.place(along + h, height) - at, wheel.place(along, height + h) - at].map(|d| d / h);
        let off = place - at;
        let det = du.perp_dot(dv);
        let step = DVec2::new(off.perp_dot(dv), du.perp_dot(off)) / det;
        let step = step.clamp_length_max(0.2);
        along = (along + step.x).clamp(-0.1, 1.1);
        height = (height + step.y).clamp(-0.1, 1.1);
    }
    [along, height]
}

/// What is wrong with a recognised channel, of the wheel in its own size.
pub(super) fn wrong(case: &Case, channel: &Channel) -> Vec<String> {
    let Case { wheel, placement, flow } = case;
    let scale = placement.matrix3.x_axis.length();
    let mut wrong = Vec::new();
    let mut expect = |holds: bool, what: String| {
        if !holds {
            wrong.push(what);
        }
    };
    let kinds = wheel.kinds();
    expect(channel.blades == wheel.blades, format!("{} blades for {}", channel.blades, wheel.blades));
    expect(channel.flow == *flow, format!("{:?} for {flow:?}", channel.flow));
    expect(channel.shrouded == wheel.shrouded, format!("shrouded {}", channel.shrouded));
    expect(channel.kinds == kinds, format!("{} kinds for {kinds}", channel.kinds));
    expect(channel.unlike.is_empty(), format!("unlike: {:?}", channel.unlike));
    let back = placement.inverse();
    let axis = back.transform_vector3(channel.frame.direction_to_parent(DVec3::X)).normalize();
    expect(axis.x.abs() > 1.0 - 1e-6, format!("axis {axis}"));
    // Chords about the axis and along the curves, of which blades and walls are made.
    let [around, along, _] = wheel.pieces.map(|n| n as f64);
    let rim = wheel.hub.at(1.0).y.max(wheel.shroud.at(1.0).y).max(wheel.shroud.at(0.0).y);
    let chord = rim * (1.0 - (PI / around).cos()) + 0.02 + 20.0 / along.powi(2);
    let in_wheel = |p: DVec3| Cylindrical::from_point(back.transform_point3(channel.frame.to_parent(p)));
    // Which wall of a radial passage is the hub depends on the sense of the axis.
    let middle = in_wheel({
        let at = channel.middle().hub;
        DVec3::new(at.x, 0.0, at.y)
    });
    let [_, height] = shares_of(wheel, DVec2::new(middle.x, middle.r));
    let (hub, shroud) = if height < 0.5 { (&wheel.hub, &wheel.shroud) } else { (&wheel.shroud, &wheel.hub) };
    let mut worst_end = (0.0, String::new());
    let (mut worst_wall, mut compared) = ((0.0, String::new()), 0);
    let curve_off = |curve: &MeridianCurve, place: DVec2| {
        let ts = (0..=400).map(|i| f64::from(i) / 400.0);
        ts.map(|t| curve.at(t)).collect::<Vec<_>>().windows(2).fold(f64::INFINITY, |least: f64, pair| {
            let way = pair[1] - pair[0];
            let t = ((place - pair[0]).dot(way) / way.length_squared()).clamp(0.0, 1.0);
            least.min(place.distance(pair[0] + t * way))
        })
    };
    let span = wheel.span_of_all();
    for s in &channel.meridian {
        for (name, curve, place) in [("hub", hub, s.hub), ("shroud", shroud, s.shroud)] {
            let at = in_wheel(DVec3::new(place.x, 0.0, place.y));
            let at = DVec2::new(at.x, at.r);
            let [t, _] = shares_of(wheel, at);
            // Beyond the blades the tips of an open wheel say nothing.
            if name == "shroud" && !wheel.shrouded && !(span[0] + 0.01..span[1] - 0.01).contains(&t) {
                continue;
            }
            if !(1e-3..0.999).contains(&t) {
                continue;
            }
            let off = curve_off(curve, at);
            if off > worst_end.0 {
                worst_end = (off, format!("{name} off by {off:.3} at {at} (share {t:.2})"));
            }
        }
    }
    expect(worst_end.0 < chord + 0.03, worst_end.1);
    let (low, high) = (&channel.low, &channel.high);
    for (u, v) in (3..low.nu - 3).flat_map(|u| (1..low.nv - 1).map(move |v| (u, v))) {
        for (side, wall) in [low, high].into_iter().enumerate() {
            let at = in_wheel(wall.point(u, v));
            let [t, height] = shares_of(wheel, DVec2::new(at.x, at.r));
            // On a round edge the angle says nothing about the distance.
            if !(span[0] + wheel.nose..span[1] - wheel.nose).contains(&t) {
                continue;
            }
            // Seen along the other sense of the axis the low wall is the high one.
            let own = if axis.x > 0.0 { side } else { 1 - side };
            let off = (0..wheel.blades).filter_map(|k| wheel.walls(k, t, height));
            let off = off.map(|walls| (at.theta - walls[own] + PI).rem_euclid(TAU) - PI);
            let off = off.fold(f64::INFINITY, |least, off| least.min(off.abs())) * at.r;
            compared += usize::from(off.is_finite());
            if off > worst_wall.0 && off.is_finite() {
                worst_wall = (off, format!("wall {side} off by {off:.3} at share {t:.3}, height {height:.3}"));
            }
        }
    }
    expect(compared * 2 > low.nu * low.nv, format!("only {compared} places of walls can be compared"));
    expect(worst_wall.0 < 3.0 * chord + 0.05, worst_wall.1);
    let width = channel.throat.width_mm / scale;
    expect(width > 0.5 && width < TAU * rim / wheel.blades as f64, format!("throat {width}"));
    wrong
}

/// Number of wheels that are tried, if the environment's `WHEEL_COUNT` says it.
fn wheel_count() -> Option<usize> {
    std::env::var("WHEEL_COUNT").ok()?.parse().ok()
}

/// Number of wheels that are tried: 6, or as many as are asked for.
fn wheels() -> usize {
    wheel_count().unwrap_or(6)
}

/// The first wheels of the sequence, those of which `what` finds fault with what it says.
pub(super) fn faulty(what: impl Fn(&Case) -> Vec<String>) -> String {
    let faulty = (0..wheels()).map(|number| (number, case(number))).filter_map(|(number, case)| {
        let said = what(&case);
        (!said.is_empty()).then(|| format!("wheel {number}: {said:#?} {case:?}\n"))
    });
    faulty.collect()
}

fn find(case: &Case) -> Result<Channel, BliskError> {
    // Rounded as in an STL file.
    let mesh = case.wheel.mesh_at(case.placement).mapped(|p| p.as_vec3().as_dvec3());
    find_channel(&mesh, &BliskOptions::default(), &Task::default())
}

#[test]
fn random_wheels_are_recognised() {
    let faulty = faulty(|case| match find(case) {
        Ok(channel) => wrong(case, &channel),
        Err(error) => vec![format!("refused: {error}")],
    });
    assert!(faulty.is_empty(), "{faulty}");
}

/// Ahead of blades and splitters rays to the hub go between the fillets round their edges: those of a splitter stand in the
/// middle between the main blades (wheels 13, 246, 272), and those of leaning blades lie elsewhere about the axis than the
/// blades at half the height (825).
#[test]
fn the_hub_ahead_of_blades_is_met_between_their_fillets() {
    for number in [13, 246, 272, 825] {
        let case = case(number);
        assert!(case.wheel.kinds() == 2 && case.wheel.fillets_round_edges);
        let wrong = wrong(&case, &find(&case).unwrap());
        assert!(wrong.is_empty(), "{number}: {wrong:?}");
    }
}

/// A wheel is clamped by its turned surfaces: where its blades were set aslant they do not tell the axis.
#[test]
fn the_axis_is_that_of_the_turned_surfaces_where_blades_are_aslant() {
    for wheel in [ParametricWheel::impeller(), ParametricWheel::nozzle_ring()].map(coarse) {
        let aslant = DAffine3::from_rotation_y(0.002) * DAffine3::from_translation(DVec3::new(0.0, 0.05, -0.08));
        let mut mesh = wheel.mesh();
        // The walls come first, each with two points a step along the passage.
        let [around, along, _] = wheel.pieces;
        mesh.vertices[4 * around * (along + 1)..].iter_mut().for_each(|p| *p = aslant.transform_point3(*p));
        let turn = DQuat::from_euler(EulerRot::ZYX, 0.3, -0.7, 1.1);
        let at = DVec3::new(20.0, -30.0, 10.0);
        for placement in [DAffine3::IDENTITY, DAffine3::from_rotation_translation(turn, at)] {
            let placed = mesh.mapped(|p| placement.transform_point3(p));
            let channel = find_channel(&placed, &BliskOptions::default(), &Task::default()).unwrap();
            let (axis, origin) = (placement.transform_vector3(DVec3::X), placement.translation);
            let off =
                channel.frame.x.cross(axis).length().max((channel.frame.origin - origin).cross(axis).length() / 100.0);
            assert!(off < 2e-4, "{off}");
        }
    }
}

/// A wheel that is spoilt is refused, or the channels beside what is wrong with it are told. Every wheel is spoilt in every
/// way where a number of wheels is asked for, else in one of them after the other.
#[test]
fn spoilt_random_wheels_are_refused_or_told() {
    let turn = Cell::new(0);
    let faulty = faulty(|case| {
        let wheel = &case.wheel;
        // Only the channels of one kind are compared: of three kinds one lies beside neither side of a blade.
        if wheel.kinds() > 2 {
            return Vec::new();
        }
        // Well beyond what may differ.
        let mm = case.placement.matrix3.x_axis.length() * wheel.place(0.5, 0.5).y;
        let angle = (0.03 * wheel.pitch()).max(0.2 / mm);
        // One of the two, wheel by wheel.
        let blade = if wheel.blades.is_multiple_of(2) {
            Flaws { bent_blade: Some((2, angle * wheel.place(0.5, 0.5).y)), ..Flaws::default() }
        } else {
            Flaws { turned_blade: Some((2, angle)), ..Flaws::default() }
        };
        let flaws = [
            (blade, 2),
            // Where a splitter is missing there is one passage in place of two.
            (Flaws { missing_blades: vec![3], ..Flaws::default() }, 1),
            (Flaws { missing_shroud: 0.5, ..Flaws::default() }, wheel.blades / 3),
        ];
        let flaws = flaws.into_iter().filter(|(flaws, _)| wheel.shrouded || flaws.missing_shroud == 0.0);
        let mut flaws: Vec<_> = flaws.collect();
        if wheel_count().is_none() {
            flaws = vec![flaws[turn.replace(turn.get() + 1) % flaws.len()].clone()];
        }
        let unsaid = flaws.into_iter().filter_map(|(flaws, least)| {
            let of_few_facets = ParametricWheel { flaws: flaws.clone(), pieces: PIECES, ..wheel.clone() };
            let spoilt = Case { wheel: of_few_facets, ..case.clone() };
            // Only the channels of its kind are compared with one.
            let told = find(&spoilt).map_or(wheel.blades, |channel| channel.kinds * channel.unlike.len());
            (told < least).then(|| format!("{told} channels differ of {flaws:?}"))
        });
        unsaid.collect()
    });
    assert!(faulty.is_empty(), "{faulty}");
}

/// The wheel with a pin from blade to blade through every passage, as long as its share of the passage's width says.
fn with_pins(wheel: &ParametricWheel, share: f64) -> Mesh {
    let span = wheel.span_of_all();
    let middle = 0.5 * (span[0] + span[1]);
    let place = wheel.place(middle, 0.5);
    let thick = 0.25 * wheel.place(middle, 0.0).distance(wheel.place(middle, 1.0));
    (0..wheel.blades).fold(wheel.mesh(), |mesh, k| {
        let [low, high] = wheel.walls(k, middle, 0.5).unwrap();
        let width = high - low;
        let pin = Mesh::cuboid(DVec3::new(thick, share * width * place.y, thick));
        let at = Cylindrical { x: place.x, r: place.y, theta: 0.5 * (low + high) };
        let turn = DAffine3::from_translation(at.point()) * DAffine3::from_rotation_x(-at.theta);
        together(mesh, &pin.mapped(|p| turn.transform_point3(p)))
    })
}

/// The wheel with a strut from hub to shroud, a fifth of the passage's width thick, in every passage at a share of the
/// splitters' or blades' span.
fn with_struts(wheel: &ParametricWheel, share: f64) -> Mesh {
    let span = wheel.span_of_all();
    let along = span[0] + share * (span[1] - span[0]);
    let [hub, place, shroud] = [0.0, 0.5, 1.0].map(|height| wheel.place(along, height));
    let up = shroud - hub;
    (0..wheel.blades).fold(wheel.mesh(), |mesh, k| {
        let [low, high] = wheel.walls(k, along, 0.5).unwrap();
        let thick = 0.2 * (high - low) * place.y;
        let strut = Mesh::cuboid(DVec3::new(thick, thick, 1.02 * up.length()));
        let at = Cylindrical { x: place.x, r: place.y, theta: 0.5 * (low + high) };
        // From along the radius to along the height.
        let lean = DAffine3::from_rotation_y(up.x.atan2(up.y));
        let turn = DAffine3::from_translation(at.point()) * DAffine3::from_rotation_x(-at.theta) * lean;
        together(mesh, &strut.mapped(|p| turn.transform_point3(p)))
    })
}

/// Where only some passages hold something, they are refused, and the others are found.
#[test]
fn a_passage_beside_one_with_a_strut_is_found() {
    let wheel = coarse(ParametricWheel::nozzle_ring());
    let place = wheel.place(0.5, 0.5);
    let mesh = (0..wheel.blades).step_by(4).fold(wheel.mesh(), |mesh, k| {
        let [low, high] = wheel.walls(k, 0.5, 0.5).unwrap();
        let strut = Mesh::cuboid(DVec3::new(14.0, 2.0, 2.0));
        // Nearer to one of the walls.
        let at = Cylindrical { x: place.x, r: place.y, theta: 0.3 * low + 0.7 * high };
        let turn = DAffine3::from_translation(at.point()) * DAffine3::from_rotation_x(-at.theta);
        together(mesh, &strut.mapped(|p| turn.transform_point3(p)))
    });
    let of = |channel: usize| find_channel(&mesh, &BliskOptions { channel, ..Default::default() }, &Task::default());
    let (found, refused): (Vec<_>, Vec<_>) = (0..8).map(of).partition(Result::is_ok);
    assert!(
        refused.len() == 2 && refused.iter().all(|r| matches!(r, Err(BliskError::Obstructed { .. }))),
        "{refused:?}"
    );
    assert!(found.iter().flatten().all(|channel| channel.unlike.len() == 5));
}

/// Where every passage has a pin or a strut no two differ, and all four surfaces of a passage are where they were. Some are told
/// as what stands in it, with their place; others keep the blades or their walls from being found.
#[test]
fn what_stands_in_every_passage_is_no_passage_without_it() {
    let (told, is_second) = (Cell::new(0), Cell::new(false));
    let faulty = faulty(|case| {
        let wheel = &coarse(case.wheel.clone());
        let span = wheel.span_of_all();
        let fault = |mesh: Mesh, share: f64, what: String| {
            let mesh = mesh.mapped(|p| case.placement.transform_point3(p));
            let along = span[0] + share * (span[1] - span[0]);
            match find_or_refuse(&mesh, &BliskOptions::default(), &Task::default()) {
                // Where struts are taken for splitters, the passage is the one beside them.
                Ok(channel) => (channel.blades == wheel.blades).then(|| format!("accepted with {what}")),
                Err(Refused { error: BliskError::Obstructed { .. }, at: Some(p) }) => {
                    told.set(told.get() + 1);
                    let p = Cylindrical::from_point(case.placement.inverse().transform_point3(p));
                    let off = DVec2::new(p.x, p.r).distance(wheel.place(along, 0.5));
                    let height = wheel.place(along, 0.0).distance(wheel.place(along, 1.0));
                    (off > height).then(|| format!("{what} told {off} mm off their place"))
                }
                Err(_) => None,
            }
        };
        // One of each in turn, wheel by wheel.
        let (pins, at) = if is_second.replace(!is_second.get()) { (0.4, 0.7) } else { (1.1, 0.3) };
        let pins = fault(with_pins(wheel, pins), 0.5, format!("pins over {pins} of the width"));
        let struts = fault(with_struts(wheel, at), at, format!("struts at {at} of the span"));
        pins.into_iter().chain(struts).collect()
    });
    assert!(faulty.is_empty(), "{faulty}");
    assert!(2 * told.get() > wheels(), "{} are told", told.get());
}
