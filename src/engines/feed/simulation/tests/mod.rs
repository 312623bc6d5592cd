//! A bar that is fed over a drum, with bodies in its way whose clearances can be worked out by hand.

mod claims;
mod tilting;

use super::bodies::Bodies;
use super::run::Run;
use super::*;
use crate::machine::TravelLimits;
use crate::machine_model::{Body, Carrier};
use crate::path::PathRow;
use crate::pose::Pose;
use crate::verify::{Verifier, VerifyOptions};
use geometry::exact::ExactMesh;
use geometry::frame::Frame;
use geometry::mesh::Bounds;
use glam::DVec3;
use std::f64::consts::FRAC_PI_2;
use task::{Cancel, Task};
use wheel::channel::Surface;
use wheel::electrode::{ElectrodeFace, EntrySide};

const O: DVec3 = DVec3::new(0.0, 0.0, 100.0);

fn block(centre: [f64; 3], size: [f64; 3]) -> Mesh {
    let size = DVec3::from_array(size);
    Mesh::cuboid(size).mapped(|p| p - 0.5 * size + DVec3::from_array(centre))
}

fn body(name: &str, carrier: Carrier, centre: [f64; 3], size: [f64; 3]) -> Body {
    Body { name: name.to_owned(), carrier, mesh: block(centre, size) }
}

/// A drum of 90 mm radius between x = -5 and 5, of 48 sides, alike every 7.5 degrees.
fn drum() -> Mesh {
    let rim = |k: u32, x: f64| {
        let (sine, cosine) = (std::f64::consts::TAU * f64::from(k) / 48.0).sin_cos();
        DVec3::new(x, -90.0 * sine, 90.0 * cosine)
    };
    let mut vertices: Vec<DVec3> = (0..48).map(|k| rim(k, -5.0)).chain((0..48).map(|k| rim(k, 5.0))).collect();
    vertices.extend([DVec3::new(-5.0, 0.0, 0.0), DVec3::new(5.0, 0.0, 0.0)]);
    let side = |k: u32| {
        let (next, far, far_next) = ((k + 1) % 48, k + 48, (k + 1) % 48 + 48);
        [[k, far_next, next], [k, far, far_next], [96, k, next], [97, far_next, far]]
    };
    let mesh = Mesh { vertices, triangles: (0..48).flat_map(side).collect() };
    if mesh.volume() > 0.0 {
        mesh
    } else {
        Mesh { triangles: mesh.triangles.iter().map(|[a, b, c]| [*a, *c, *b]).collect(), ..mesh }
    }
}

struct Parts {
    blisk: Mesh,
    electrode: Electrode,
    feed: FeedPath,
    certificate: Certificate,
    machine: MachineParams,
    model: MachineModel,
}

/// A bar from x = -10 to 10, 2 mm wide, at z = 99 to 101, fed from x = 30 with C at `turned`.
fn parts(bodies: Vec<Body>, turned: f64) -> Parts {
    let mesh = block([0.0, 0.0, 100.0], [20.0, 2.0, 2.0]);
    let electrode = Electrode {
        faces: vec![ElectrodeFace::Shank; mesh.triangles.len()],
        mesh,
        enters_from: EntrySide::PlusX,
        reference_point: O,
        stage: None,
        part: 0,
        parts: 1,
        column: None,
        least_thickness_mm: 2.0,
        volume_mm3: 80.0,
        burn_area_mm2: 1.0,
        undersize_mm: 0.1,
        clearance_mm: 9.0,
        assumed: Vec::new(),
        patches: Vec::new(),
    };
    let row = |s: f64, c: f64| PathRow { node: 0, s, pose: Pose { x: s, c, ..Pose::FINAL } };
    let rows = vec![row(30.0, turned), row(0.0, 0.0)];
    let feed = FeedPath { frame: Frame::IDENTITY, reference_point: O, spark_gap: 0.1, rows };
    let blisk = drum();
    let certificate = certified(&blisk, &electrode.mesh, &feed);
    let machine = MachineParams::default();
    Parts { blisk, electrode, feed, certificate, machine, model: MachineModel { bodies } }
}

fn certified(blisk: &Mesh, electrode: &Mesh, feed: &FeedPath) -> Certificate {
    let verifier = Verifier::new(blisk, electrode, O, &Cancel::default()).unwrap().within(TravelLimits::UNLIMITED);
    let (options, surface) = (VerifyOptions::default(), |_: DVec3| Surface::Elsewhere);
    verifier.verify(feed, &surface, &options, &Task::default()).unwrap()
}

/// To within a millionth of a millimetre, near or far.
fn options(channels: &[usize]) -> SimulationOptions {
    SimulationOptions { resolution_mm: 1e-6, resolution_share: 0.0, ..SimulationOptions::of(channels.to_vec()) }
}

impl Parts {
    fn simulate(&self, channels: &[usize]) -> Simulation {
        self.simulate_clear(channels, 10.0)
    }

    /// Simulates with the electrode taken out by `clear_mm`.
    fn simulate_clear(&self, channels: &[usize], clear_mm: f64) -> Simulation {
        let machine = self.machine.seen_from_w(self.electrode.enters_from);
        let (scenario, options) = (self.scenario(&machine), SimulationOptions { clear_mm, ..options(channels) });
        let simulation = simulate(&scenario, &options, &Task::default()).unwrap();
        self.check_places(&simulation);
        simulation
    }

    fn scenario<'a>(&'a self, machine: &'a MachineParams) -> Scenario<'a> {
        Scenario {
            blisk: &self.blisk,
            channels: 4,
            own_channel: 0,
            electrode: &self.electrode,
            preset: None,
            feed: (&self.feed, &self.certificate),
            copying: None,
            machine,
            model: &self.model,
        }
    }

    /// Every place that is named is one of the whole motion.
    fn check_places(&self, simulation: &Simulation) {
        let legs = simulation.legs(&self.feed, None);
        for pair in simulation.pairs() {
            for place in std::iter::once(&pair.least).chain(&pair.contact) {
                let leg = legs.iter().find(|leg| leg.phase == place.phase && leg.channel == place.channel).unwrap();
                let pose = leg.pose_at(place.row).to_array();
                let off = pose.iter().zip(place.pose.to_array()).map(|(p, q)| (p - q).abs()).fold(0.0, f64::max);
                assert!(off < 1e-9, "{} and {}: {place:?} {pose:?}", pair.moving, pair.fixed);
                self.check_points(simulation.chain(), pair, place);
            }
        }
    }

    /// The points of a tool and of what A turns are as far apart as is said.
    fn check_points(&self, chain: &crate::chain::Chain, pair: &PairReport, place: &Place) {
        let carrier = |name: &str| self.model.bodies.iter().find(|b| b.name == name).map(|b| b.carrier);
        let (moving, fixed) = (carrier(&pair.moving), carrier(&pair.fixed));
        let is_tool = pair.moving == "electrode" || moving.is_some_and(Carrier::slides);
        let is_turned = pair.fixed == "blisk" || fixed == Some(Carrier::Table);
        if !is_tool || !is_turned {
            return;
        }
        let moved = chain.seen_from_blisk(moving.unwrap_or(Carrier::Electrode), &place.pose);
        let apart = moved.transform_point3(place.on_moving).distance(place.on_fixed);
        assert!((apart - place.distance).abs() < 2e-6, "{} and {}: {apart} {place:?}", pair.moving, pair.fixed);
    }

    /// With a certificate of these very parts.
    fn certified(mut self) -> Self {
        self.certificate = certified(&self.blisk, &self.electrode.mesh, &self.feed);
        self
    }

    /// Scene with a feed through other poses; one that has none keeps the certificate of the former.
    fn with_poses(mut self, poses: Vec<Pose>) -> Self {
        let row = |pose: Pose| PathRow { node: 0, s: pose.x.abs(), pose };
        self.feed.rows = poses.into_iter().map(row).collect();
        if self.feed.rows.is_empty() { self } else { self.certified() }
    }
}

fn pair<'a>(simulation: &'a Simulation, moving: &str, fixed: &str) -> &'a PairReport {
    simulation.pairs().iter().find(|p| p.moving == moving && p.fixed == fixed && p.during.is_none()).unwrap()
}

/// A chuck behind the bar, from x = 10 to 12 and 20 mm wide.
fn chuck() -> Body {
    body("chuck", Carrier::Electrode, [1.0, 0.0, 0.0], [2.0, 20.0, 2.0])
}

#[test]
fn a_stop_on_the_bed_is_met_by_the_chuck_at_the_instant_worked_out_by_hand() {
    // From x = 16 to 20 in W, counted from the drum's far face at x = -5, beside the bar but not beside the chuck.
    let parts = parts(vec![chuck(), body("stop", Carrier::Bed, [23.0, 4.0, 100.0], [4.0, 2.0, 2.0])], 0.0);
    let simulation = parts.simulate(&[0]);
    assert!(!simulation.holds() && simulation.travel().is_none());
    // The chuck's front is at x + 10: it meets the stop at x = 10, two thirds of the way in from 30.
    let contact = pair(&simulation, "chuck", "stop").contact.unwrap();
    assert_eq!((contact.phase, contact.channel), (Phase::Feed, 0));
    assert!((contact.row - 2.0 / 3.0).abs() < 1e-6, "{contact:?}");
    // The bar passes the stop at 2 mm.
    let bar = pair(&simulation, "electrode", "stop");
    assert!(bar.holds() && (bar.least.distance - 2.0).abs() < 1e-6 && bar.certified > 2.0 - 2e-6, "{bar:?}");
    let sentence = simulation.sentence();
    assert!(sentence.contains("COLLISION: chuck meets stop in the feed of channel 0, at row 0.667"), "{sentence}");
}

#[test]
fn a_body_nearer_than_asked_for_is_told_without_a_contact() {
    let stop = body("stop", Carrier::Bed, [23.0, 11.5, 100.0], [4.0, 2.0, 2.0]);
    let mut parts = parts(vec![chuck(), stop], 0.0);
    // The chuck's side is at y = 10, the stop's at 10.5.
    let simulation = parts.simulate(&[0]);
    let close = pair(&simulation, "chuck", "stop");
    assert!(close.contact.is_none() && !close.holds() && (close.certified - 0.5).abs() < 1e-6, "{close:?}");
    assert!(simulation.sentence().contains("TOO CLOSE"));
    parts.machine.body_clearance_mm = 0.49;
    assert!(parts.simulate(&[0]).holds());
}

#[test]
fn a_lug_on_the_table_is_in_the_way_in_its_own_channel_only() {
    // The same stop a quarter turn about X further: at theta = 90 degrees z becomes -y.
    let lug = body("lug", Carrier::Table, [23.0, -100.0, 4.0], [4.0, 2.0, 2.0]);
    let parts = parts(vec![chuck(), lug], 0.0);
    let all = parts.simulate(&[0, 1, 2, 3]);
    assert_eq!(all.visits().len(), 4);
    assert!(all.period_error().unwrap() < 1e-12, "{:?}", all.period_error());
    let contact = pair(&all, "chuck", "lug").contact.unwrap();
    assert_eq!((contact.phase, contact.channel), (Phase::Feed, 1));
    assert!((contact.row - 2.0 / 3.0).abs() < 1e-6);
    let others = parts.simulate(&[0, 2, 3]);
    assert!(others.holds(), "{}", others.sentence());
    // Turned by A the other way, the last channel is a quarter turn back.
    let turns: Vec<f64> = others.visits().iter().map(|v| v.turn / FRAC_PI_2).collect();
    assert!(turns.iter().zip([-1.0, 0.0, 2.0]).all(|(t, expected)| (t - expected).abs() < 1e-9), "{turns:?}");
}

/// A lug below the axis, that A takes past a post on the bed on the way to channel 1 and not to channel 3.
#[test]
fn what_a_turns_is_tested_against_the_bed() {
    let at = 100.0 * std::f64::consts::FRAC_1_SQRT_2;
    let lug = body("lug", Carrier::Table, [-20.0, 0.0, -100.0], [4.0, 4.0, 4.0]);
    let post = body("post", Carrier::Bed, [-20.0, -at, -at], [4.0, 4.0, 4.0]);
    let turning = parts(vec![lug, post], 0.0);
    let contact = pair(&turning.simulate(&[0, 1]), "lug", "post").contact.unwrap();
    assert!(contact.phase == Phase::Index && (0.6..0.785).contains(&contact.pose.a), "{contact:?}");
    for channels in [&[0][..], &[0, 3]] {
        let simulation = turning.simulate(channels);
        assert!(simulation.holds() && pair(&simulation, "lug", "post").certified > 1.0, "{}", simulation.sentence());
    }
    // The drum reaches to a radius of 90 mm.
    let peg = body("peg", Carrier::Bed, [5.0, 80.0, 0.0], [4.0, 4.0, 4.0]);
    let simulation = parts(vec![peg], 0.0).simulate(&[0]);
    assert!(!simulation.holds() && pair(&simulation, "blisk", "peg").contact.is_some(), "{}", simulation.sentence());
    // What touches at rest turns there as in a bearing.
    let hub = body("hub", Carrier::Table, [-20.0, 0.0, 0.0], [10.0, 4.0, 4.0]);
    let bearing = body("bearing", Carrier::Bed, [-20.0, 0.0, 0.0], [10.0, 8.0, 8.0]);
    assert!(parts(vec![hub, bearing], 0.0).simulate(&[0, 1]).holds());
}

/// An arm that C swings past a bracket of the head.
#[test]
fn what_c_turns_is_tested_against_the_head() {
    let at = 30.0 * std::f64::consts::FRAC_1_SQRT_2;
    let bodies = || {
        let arm = body("arm", Carrier::Electrode, [20.0, 0.0, 30.0], [4.0, 4.0, 4.0]);
        vec![arm, body("bracket", Carrier::Head, [at, at, 30.0], [4.0, 4.0, 4.0])]
    };
    let swung = parts(bodies(), FRAC_PI_2).simulate(&[0]);
    let contact = pair(&swung, "arm", "bracket").contact.unwrap();
    assert!(contact.phase == Phase::Feed && (0.785..1.0).contains(&contact.pose.c), "{contact:?}");
    let straight = parts(bodies(), 0.0).simulate(&[0]);
    assert!(pair(&straight, "arm", "bracket").holds(), "{}", straight.sentence());
}

#[test]
fn a_drum_that_is_not_alike_is_tested_in_every_channel() {
    let mut parts = parts(vec![chuck()], 0.0);
    // A tooth at theta = 90 degrees reaches up to 0.6 mm below the bar.
    let tooth = block([0.0, -90.0, 0.0], [4.0, 16.8, 4.0]);
    let count = parts.blisk.vertices.len() as u32;
    parts.blisk.vertices.extend(&tooth.vertices);
    parts.blisk.triangles.extend(tooth.triangles.iter().map(|t| t.map(|v| v + count)));
    let simulation = parts.certified().simulate(&[0, 1]);
    assert_eq!(simulation.period_error(), None);
    let in_others = simulation.pairs().iter().find(|p| p.during == Some("feed in other channels")).unwrap();
    assert!((in_others.least.distance - 0.6).abs() < 1e-6 && in_others.least.channel == 1, "{in_others:?}");
    assert!(in_others.holds(), "the spark gap is asked for in a channel");
}

/// What another channel keeps by less than the usual resolution is proven more finely.
#[test]
fn a_channel_that_just_keeps_the_gap_is_proven_to() {
    let nearest = |distance: f64| {
        let mut parts = parts(vec![chuck()], 0.0);
        let tooth = block([0.0, -90.0, 0.0], [4.0, 2.0 * (9.0 - distance), 4.0]);
        let count = parts.blisk.vertices.len() as u32;
        parts.blisk.vertices.extend(&tooth.vertices);
        parts.blisk.triangles.extend(tooth.triangles.iter().map(|t| t.map(|v| v + count)));
        let parts = parts.certified();
        let machine = parts.machine.seen_from_w(parts.electrode.enters_from);
        simulate(&parts.scenario(&machine), &SimulationOptions::of(vec![0, 1]), &Task::default()).unwrap()
    };
    let required = 0.098;
    for (beyond, holds) in [(2e-4, true), (-2e-4, false)] {
        let simulation = nearest(required + beyond);
        let in_others = simulation.pairs().iter().find(|p| p.during == Some("feed in other channels")).unwrap();
        assert!((in_others.required - required).abs() < 1e-9 && in_others.holds() == holds, "{in_others:?}");
        assert!(in_others.certified <= required + beyond + 1e-9, "{in_others:?}");
    }
}

#[test]
fn c_turns_what_the_electrode_carries_and_not_the_head() {
    // 30 mm from the C axis along x, which C turns to y: the post stands there at the start of the feed.
    let post = || body("post", Carrier::Bed, [35.0, 30.0, 100.0], [1.0, 1.0, 1.0]);
    let carried = body("arm", Carrier::Electrode, [20.0, 0.0, 0.0], [2.0, 2.0, 2.0]);
    let simulation = parts(vec![carried, post()], FRAC_PI_2).simulate(&[0]);
    let contact = pair(&simulation, "arm", "post").contact.unwrap();
    // From x = 40 in, the arm's front at x - 1 meets the post's back at 30.5; the clear position is above.
    assert_eq!(contact.phase, Phase::Approach);
    let expected = (simulation.approach().len() - 2) as f64 + (40.0 - 31.5) / 10.0;
    assert!((contact.row - expected).abs() < 1e-6, "{contact:?}");
    let head = body("arm", Carrier::Head, [30.0, 0.0, 0.0], [2.0, 2.0, 2.0]);
    assert!(parts(vec![head, post()], FRAC_PI_2).simulate(&[0]).holds());
}

#[test]
fn channels_beyond_the_travel_of_a_are_named() {
    let mut parts = parts(vec![chuck()], 0.0);
    parts.machine.travel_a_deg = [-100.0, 100.0];
    let simulation = parts.simulate(&[0, 1, 2, 3]);
    assert_eq!(simulation.out_of_reach(), [2]);
    assert_eq!(simulation.visits().iter().map(|v| v.channel).collect::<Vec<_>>(), [3, 0, 1]);
    assert!(!simulation.holds() && simulation.sentence().contains("does not reach channel 2"));
    parts.machine.axes = crate::machine::AxisSet::XYZC;
    assert_eq!(parts.simulate(&[0, 1]).out_of_reach(), [1]);
    assert!(parts.simulate(&[0]).holds());
}

#[test]
fn the_whole_motion_is_one_way_and_takes_its_time() {
    let parts = parts(vec![chuck()], 0.0);
    let simulation = parts.simulate(&[0, 1]);
    let legs = simulation.legs(&parts.feed, None);
    let names: Vec<_> = legs.iter().map(|leg| leg.phase.name()).collect();
    let of_channel = ["approach", "feed", "retraction"];
    assert_eq!(names, [&of_channel[..], &["indexing"], &of_channel].concat());
    assert!(legs.windows(2).all(|pair| pair[0].poses.last() == pair[1].poses.first()), "without a jump");
    // In and out 40 mm and up and down by the rise, twice, at 1000 mm/min; a quarter turn at 1800 deg/min.
    let rise = simulation.approach()[0].z;
    let expected = 4.0 * (40.0 + rise) / 1000.0 + 90.0 / 1800.0;
    assert!((simulation.minutes() - expected).abs() < 1e-9, "{} {expected}", simulation.minutes());
    // Above the drum by the clear distance: the bar's underside is at 99.
    assert!((rise - 1.0).abs() < 1e-5, "{rise}");
}

/// A needle over the middle of a flank of the drum: its edges pass below only where A turns.
#[test]
fn what_is_nearest_between_channels_is_told_of_a_way_of_the_tour() {
    let flank = 90.0 * (std::f64::consts::PI / 48.0).sin();
    let parts = parts(vec![body("needle", Carrier::Head, [-37.0, flank, 5.0], [0.2, 0.2, 20.0])], 0.0);
    let distance_at = |pose: &Pose| {
        let needle = block([-37.0, flank, 105.0], [0.2, 0.2, 20.0]);
        let [drum, needle] = [&parts.blisk, &needle].map(|mesh| ExactMesh::new(mesh).unwrap());
        drum.distance_to(&needle, &pose.placement(O))
    };
    // The widest way is that from channel 3 at -90 degrees to channel 2 at 180, and the channel of the plan is not
    // burnt.
    for channels in [&[2, 3][..], &[0, 1], &[1, 2]] {
        let simulation = parts.simulate_clear(channels, 9.0);
        let turns = [simulation.visits()[0].turn, simulation.visits()[1].turn];
        let least = pair(&simulation, "needle", "blisk").least;
        assert_eq!((least.phase, least.channel), (Phase::Index, simulation.visits()[1].channel));
        assert!(turns[0] < least.pose.a && least.pose.a < turns[1], "{least:?} {turns:?}");
        assert!((distance_at(&least.pose) - least.distance).abs() < 1e-6, "{least:?}");
        assert!(least.distance < distance_at(&simulation.approach()[0]) - 0.1, "nearer than at rest");
    }
}

#[test]
fn the_approach_is_clear_in_every_channel() {
    // Above where the chuck comes in, too low for the way across above the drum.
    let lug = body("lug", Carrier::Table, [56.0, -104.7, 0.0], [8.0, 4.0, 4.0]);
    let parts = parts(vec![chuck(), lug], 0.0);
    for (channels, poses) in [(&[0][..], 3), (&[0, 1], 2), (&[1], 2), (&[0, 3], 3)] {
        let simulation = parts.simulate(channels);
        assert!(simulation.holds(), "{channels:?}: {}", simulation.sentence());
        assert_eq!(simulation.approach().len(), poses, "{channels:?}");
    }
}

/// A lug that is beside the chuck in one channel, and another that is in its way in the next.
#[test]
fn copies_of_a_table_tell_what_turning_it_tells() {
    let near = body("near", Carrier::Table, [23.0, -100.0, 15.0], [4.0, 2.0, 2.0]);
    let met = body("met", Carrier::Table, [23.0, -4.0, -100.0], [4.0, 2.0, 2.0]);
    let parts = parts(vec![chuck(), near, met], 0.3);
    let (scenario, options, task) = (parts.scenario(&parts.machine), options(&[0, 1, 2, 3]), &Task::default());
    let (visits, _) = tour::visits(&scenario, &options.channels);
    let bodies = &Bodies::new(&scenario, &task.cancel).unwrap();
    let run = Run {
        scenario: &scenario,
        options: &options,
        bodies,
        visits: &visits,
        period_error: Some(0.0),
        fineness: 1.0,
        task,
    };
    let copies = run.copies().unwrap();
    assert_eq!(copies.iter().flatten().count(), 2);
    let approach = run.approach(&copies).unwrap();
    let all = |copies| run.all(&approach, copies).unwrap();
    let (with, without) = (all(&copies), all(&[]));
    assert_eq!(with.len(), without.len());
    for (p, q) in with.iter().zip(&without) {
        assert_eq!((&p.moving, &p.fixed, p.during), (&q.moving, &q.fixed, q.during));
        assert!((p.certified - q.certified).abs() < 3e-6, "{p:?} {q:?}");
        assert!((p.least.distance - q.least.distance).abs() < 3e-6, "{p:?} {q:?}");
        assert_eq!(p.contact, q.contact);
        let is_same = (p.least.channel, p.least.phase) == (q.least.channel, q.least.phase);
        assert!(is_same && (p.least.pose.a - q.least.pose.a).abs() < 1e-3, "{p:?} {q:?}");
    }
    // The points are on the bodies, and as far apart as is said.
    let bodies = bodies::placed(&scenario);
    for p in with.iter().filter(|p| p.contact.is_none()) {
        let Some(lug) = bodies.iter().find(|b| b.name == p.fixed && b.carrier == Carrier::Table) else { continue };
        let Place { distance, pose, on_moving, on_fixed, .. } = p.least;
        let apart = pose.placement(O).transform_point3(on_moving).distance(on_fixed);
        let is_on_lug = lug.mesh.bounds().grown(1e-6).intersects(&Bounds { min: on_fixed, max: on_fixed });
        assert!(is_on_lug && (apart - distance).abs() < 1e-6, "{p:?}");
    }
    let chuck_and = |name: &str| with.iter().find(|p| p.moving == "chuck" && p.fixed == name).unwrap();
    assert_eq!(chuck_and("met").contact.map(|c| (c.phase, c.channel)), Some((Phase::Feed, 2)));
    assert!(chuck_and("near").contact.is_none() && chuck_and("near").least.distance < 5.0);
}

/// Drum and bar are the same after half a turn about Z, and the machine is turned with the side of entry: all is as
/// before then, with x, y, and a the other way round.
#[test]
fn an_electrode_from_the_other_side_finds_the_machine_turned() {
    let bodies = || {
        let stop = body("stop", Carrier::Bed, [23.0, 4.0, 100.0], [4.0, 2.0, 2.0]);
        let lug = body("lug", Carrier::Table, [27.0, -96.0, 12.0], [2.0, 2.0, 2.0]);
        vec![chuck(), stop, lug, body("head", Carrier::Head, [14.0, -3.0, 8.0], [4.0, 4.0, 4.0])]
    };
    let start = Pose { x: 30.0, y: 1.5, a: 0.05, c: 0.3, ..Pose::FINAL };
    let turned = |p: Pose| Pose { x: -p.x, y: -p.y, a: -p.a, b: -p.b, ..p };
    let machine = MachineParams {
        name: "turned".to_owned(),
        travel_x_mm: [-1.0, 40.0],
        travel_y_mm: [-1.0, 2.0],
        travel_a_deg: [-3.0, 120.0],
        ..MachineParams::default()
    };
    let from_plus = Parts { machine: machine.clone(), ..parts(bodies(), 0.0).with_poses(vec![start, Pose::FINAL]) };
    let mut from_minus = Parts { machine, ..parts(bodies(), 0.0).with_poses(vec![turned(start), Pose::FINAL]) };
    from_minus.electrode.enters_from = EntrySide::MinusX;
    let (plus, minus) = (from_plus.simulate(&[0, 1]), from_minus.simulate(&[0, 3]));
    assert!(plus.travel().is_none() && minus.travel().is_none() && minus.out_of_reach().is_empty());
    let seen = from_minus.machine.seen_from_w(EntrySide::MinusX);
    assert_eq!(tour::visits(&from_minus.scenario(&seen), &[0, 1]).1, [1], "A goes the other way round");
    assert_eq!(plus.approach().iter().copied().map(turned).collect::<Vec<_>>(), minus.approach());
    assert_eq!(plus.pairs().len(), minus.pairs().len());
    for p in plus.pairs().iter().filter(|p| p.during.is_none()) {
        let q = pair(&minus, &p.moving, &p.fixed);
        assert!((p.certified - q.certified).abs() < 3e-6, "{p:?} {q:?}");
        assert!((p.least.distance - q.least.distance).abs() < 3e-6, "{p:?} {q:?}");
        assert_eq!(p.contact.map(|c| c.phase), q.contact.map(|c| c.phase));
        // What A turns the other way meets channels in the opposite order; a way between them leads to the other one.
        if !["blisk", "lug"].contains(&p.moving.as_str()) && p.least.phase != Phase::Index {
            let opposite = (4 - p.least.channel) % 4;
            assert_eq!((p.least.phase, opposite), (q.least.phase, q.least.channel), "{p:?} {q:?}");
        }
        if let (Some(p), Some(q)) = (&p.contact, &q.contact) {
            assert!((p.row - q.row).abs() < 1e-6, "{p:?} {q:?}");
        }
    }
    assert!(pair(&minus, "chuck", "stop").contact.is_some());
}

/// A block 50 mm from the C axis, that B swings up against a beam of the bed and one of the head.
#[test]
fn b_tilts_what_the_electrode_carries_and_not_the_head() {
    let instant: f64 = 0.15;
    let height = 51.0 * instant.sin() + instant.cos();
    let beam = |name, carrier, [x, y, z]: [f64; 3]| body(name, carrier, [x, y, z + height + 1.0], [16.0, 6.0, 2.0]);
    let bodies = vec![
        body("arm", Carrier::Electrode, [40.0, 0.0, 0.0], [2.0, 2.0, 2.0]),
        beam("beam", Carrier::Bed, [85.0, 3.5, 100.0]),
        beam("bracket", Carrier::Head, [50.0, -3.5, 0.0]),
    ];
    let at = |x: f64, b: f64| Pose { x, b, ..Pose::FINAL };
    let poses = vec![at(30.0, 0.0), at(30.0, -2.0 * instant), at(30.0, 0.0), Pose::FINAL];
    let mut tilted = parts(bodies, 0.0).with_poses(poses);
    tilted.machine.axes = crate::machine::AxisSet::XYZABC;
    let simulation = tilted.simulate(&[0]);
    assert_eq!(simulation.travel(), None);
    for fixed in ["beam", "bracket"] {
        let contact = pair(&simulation, "arm", fixed).contact.unwrap();
        assert_eq!(contact.phase, Phase::Feed);
        assert!((contact.row - 0.5).abs() < 1e-6 && (contact.pose.b + instant).abs() < 1e-6, "{fixed}: {contact:?}");
    }
    assert!(pair(&simulation, "bracket", "beam").contact.is_none(), "the head does not tilt");
    tilted.machine.axes = crate::machine::AxisSet::XYZAC;
    assert_eq!(tilted.simulate(&[0]).travel().map(|t| t.axis), Some(crate::pose::Axis::B));
}
