//! Recognition of random wheels against the formulas that they were made from.

use std::f64::consts::{PI, TAU};

use glam::{DAffine3, DQuat, DVec2, DVec3, EulerRot};
use proptest::prelude::*;
use proptest::strategy::ValueTree as _;
use proptest::test_runner::TestRunner;

use super::*;
use crate::channel::Flow;
use crate::parametric::wheel::{Flaws, MeridianCurve, ParametricWheel, Splitters};
use geometry::frame::Cylindrical;

/// A wheel, where it stands, and what it is.
#[derive(Debug, Clone)]
pub(super) struct Case {
    pub(super) wheel: ParametricWheel,
    pub(super) placement: DAffine3,
    flow: Flow,
}

/// Shares of something, from 0 to 1.
fn share() -> impl Strategy<Value = f64> {
    0.0..1.0
}

/// The curves of hub and shroud of an axial (0), mixed (1) or radial (2) wheel whose size is about 100 mm.
fn curves(flow: usize) -> impl Strategy<Value = (Flow, MeridianCurve, MeridianCurve)> {
    (Just(flow), [share(), share(), share(), share(), share()]).prop_map(|(flow, [a, b, c, d, e])| {
        let at = DVec2::new;
        // Straight from end to end, but bowed by up to a tenth of the length.
        let bowed = |from: DVec2, to: DVec2, bow: [f64; 2]| {
            let MeridianCurve([p, mut q, mut s, t]) = MeridianCurve::line(from, to);
            q += 0.2 * (bow[0] - 0.5) * (to - from).perp();
            s += 0.2 * (bow[1] - 0.5) * (to - from).perp();
            MeridianCurve([p, q, s, t])
        };
        match flow {
            0 => {
                let (length, r, height) = (15.0 + 25.0 * a, 30.0 + 30.0 * b, 9.0 + 10.0 * c);
                let hub = bowed(at(0.0, r), at(length, r * (0.95 + 0.2 * d)), [e, a]);
                let end = hub.0[3] + at(0.0, height * (0.7 + 0.6 * b));
                (Flow::Axial, hub, bowed(at(0.0, r + height), end, [c, d]))
            }
            1 => {
                let (eye, height, rim) = (12.0 + 10.0 * a, 12.0 + 8.0 * b, 60.0 + 20.0 * c);
                let (length, width) = (30.0 + 20.0 * d, 7.0 + 5.0 * e);
                let hub = MeridianCurve::quarter(at(0.0, eye), DVec2::X, at(length, rim));
                let shroud = MeridianCurve::quarter(at(0.0, eye + height), DVec2::X, at(length - width, rim));
                (Flow::Mixed, hub, shroud)
            }
            _ => {
                let (from, to) = (35.0 + 15.0 * a, 65.0 + 20.0 * b);
                let widths = [8.0 + 6.0 * c, 8.0 + 6.0 * d];
                let hub = bowed(at(0.0, from), at(4.0 * e - 2.0, to), [0.5, 0.5 + 0.3 * (a - 0.5)]);
                let shroud = bowed(at(widths[0], from), at(hub.0[3].x + widths[1], to), [0.5, 0.5]);
                (Flow::Radial, hub, shroud)
            }
        }
    })
}

/// All kinds of wheels in turn: directions of flow, with and without a shroud, without splitters, with splitters in the
/// middle between the blades and off it.
fn cases(number: usize) -> impl Strategy<Value = Case> {
    let (flow, shrouded, splitting) = (number % 3, number % 6 < 3, (number + number / 3) % 3);
    let shape = (curves(flow), 5..30usize, [share(), share(), share(), share(), share(), share()]);
    let extras = (any::<bool>(), 0..8usize, prop::sample::select(vec![0, 0, 6]));
    let place = ([-PI..PI, -1.5..1.5, -PI..PI], [-200.0..200.0, -200.0..200.0, -200.0..200.0], -1.0..1.5f64);
    (shape, extras, place).prop_map(move |((curves, blades, s), (positive, teeth, holes), place)| {
        let (flow, hub, shroud) = curves;
        let least = (0..=40).map(|i| hub.at(f64::from(i) / 40.0).y.min(shroud.at(f64::from(i) / 40.0).y));
        let least = least.fold(f64::INFINITY, f64::min);
        // Passages at least 4 mm wide, with splitters between blades twice as far apart.
        let splitting = if flow == Flow::Axial { 0 } else { splitting };
        let most = ((TAU * least / 7.0) as usize).max(5);
        let blades = blades.min(most);
        let blades = if splitting > 0 { (2 * (blades / 2)).max(6) } else { blades };
        let pitch = TAU / blades as f64;
        let thickness_mm = (pitch * least) * (0.08 + 0.2 * s[0]);
        let middle = [hub.at(0.5), shroud.at(0.5)];
        let length = (0..20).map(|i| f64::from(i) / 20.0).map(|t| hub.at(t).distance(hub.at(t + 0.05))).sum::<f64>();
        // Blades lean by up to 50 degrees off the meridional plane.
        let steep = (50.0 * s[1]).to_radians().tan();
        let wrap = steep * length / (0.5 * (middle[0].y + middle[1].y)) * if positive { 1.0 } else { -1.0 };
        let height = hub.at(1.0).distance(shroud.at(1.0)).min(hub.at(0.0).distance(shroud.at(0.0)));
        let passage = pitch * least - thickness_mm;
        let fillet_mm = if s[2] < 0.4 { 0.0 } else { (s[2] * 0.15 * height).min(0.15 * passage) };
        let off_middle = if splitting == 2 { 0.08 * pitch } else { 0.0 };
        let splitters = (splitting > 0).then(|| Splitters { span: [0.35 + 0.2 * s[3], 0.92], off_middle });
        let wheel = ParametricWheel {
            blades,
            hub,
            shroud,
            shrouded,
            span: [0.1, 0.92],
            splitters,
            wrap,
            lean: 0.1 * (s[4] - 0.5),
            thickness_mm,
            nose: if s[5] < 0.3 { 0.0 } else { 0.06 * s[5] },
            fillet_mm,
            wall_mm: 4.0,
            teeth,
            holes,
            pieces: [180, 64, 8],
            ..ParametricWheel::nozzle_ring()
        };
        let (angles, shift, size) = place;
        let turn = DQuat::from_euler(EulerRot::ZYX, angles[0], angles[1], angles[2]);
        let placement = DAffine3::from_scale_rotation_translation(DVec3::splat(10f64.powf(size)), turn, shift.into());
        Case { wheel, placement, flow }
    })
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
    let kinds = wheel.splitters.map_or(1, |s| if s.off_middle == 0.0 { 1 } else { 2 });
    expect(channel.blades == wheel.blades, format!("{} blades for {}", channel.blades, wheel.blades));
    // Of an open wheel with splitters only what they bound on one side is known, which may all run along the radius.
    let may_be_radial = *flow == Flow::Mixed && !wheel.shrouded && wheel.splitters.is_some();
    expect(
        channel.flow == *flow || (may_be_radial && channel.flow == Flow::Radial),
        format!("{:?} for {flow:?}", channel.flow),
    );
    expect(channel.shrouded == wheel.shrouded, format!("shrouded {}", channel.shrouded));
    let unlike = if wheel.splitters.is_some() && kinds == 1 { wheel.blades / 2 } else { 0 };
    expect(channel.kinds == kinds, format!("{} kinds for {kinds}", channel.kinds));
    expect(channel.unlike.len() == unlike, format!("{} unlike for {unlike}", channel.unlike.len()));
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
    let span = wheel.splitters.map_or(wheel.span, |splitters| splitters.span);
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

/// So many wheels are tried.
const WHEELS: usize = 6;

/// The first wheels of a fixed sequence, those of which `what` finds fault with what it says.
pub(super) fn faulty(what: impl Fn(&Case) -> Vec<String>) -> String {
    let mut runner = TestRunner::deterministic();
    let all = (0..WHEELS).map(|number| (number, cases(number).new_tree(&mut runner).unwrap().current()));
    let faulty = all.filter_map(|(number, case)| {
        let said = what(&case);
        (!said.is_empty()).then(|| format!("wheel {number}: {said:#?} {case:?}\n"))
    });
    faulty.collect()
}

fn find(case: &Case) -> Result<Channel, BliskError> {
    find_channel(&case.wheel.mesh_at(case.placement), &BliskOptions::default(), &Task::default())
}

#[test]
fn random_wheels_are_recognised() {
    let faulty = faulty(|case| match find(case) {
        Ok(channel) => wrong(case, &channel),
        Err(error) => vec![format!("refused: {error}")],
    });
    assert!(faulty.is_empty(), "{faulty}");
}

/// A wheel that is spoilt is refused, or the channels beside what is wrong with it are told.
#[test]
fn spoilt_random_wheels_are_refused_or_told() {
    let faulty = faulty(|case| {
        let wheel = &case.wheel;
        // Well beyond what is doubted.
        let mm = case.placement.matrix3.x_axis.length() * wheel.place(0.5, 0.5).y;
        let turn = (0.03 * wheel.pitch()).max(0.2 / mm);
        let flaws = [
            (Flaws { turned_blade: Some((2, turn)), ..Flaws::default() }, 2),
            // Where a splitter is missing there is one passage in place of two.
            (Flaws { missing_blade: Some(3), ..Flaws::default() }, 1),
            (Flaws { missing_shroud: 0.5, ..Flaws::default() }, wheel.blades / 3),
        ];
        let flaws = flaws.into_iter().filter(|(flaws, _)| wheel.shrouded || flaws.missing_shroud == 0.0);
        // Splitters in the middle make every other passage the mirror image of its neighbour.
        let mirrored = find(case).map_or(0, |channel| channel.unlike.len());
        let unsaid = flaws.filter_map(|(flaws, least)| {
            let spoilt = Case { wheel: ParametricWheel { flaws, ..wheel.clone() }, ..case.clone() };
            // Only the channels of its kind are compared with one.
            let told = find(&spoilt).map_or(wheel.blades, |channel| channel.kinds * channel.unlike.len());
            (told < least || told == mirrored).then(|| format!("{told} channels differ of {flaws:?}"))
        });
        unsaid.collect()
    });
    assert!(faulty.is_empty(), "{faulty}");
}
