mod tilting;

use super::*;
use crate::approved::NotApproved;
use crate::fixtures;
use crate::fixtures::{OWN_CHANNEL, PITCH_DEG, Scene};
use crate::path_csv::write_path_csv;
use feed::certificate::Certificate;
use feed::machine::BeyondTravel;
use feed::machine::{AxisSet, TravelLimits};
use feed::machine_model::{Body, Carrier, MachineModel};
use feed::quantise::quantise_rad;
use feed::simulation::{Simulation, Visit};
use feed::verify::VerifyOptions;
use files::Validate as _;
use geometry::mesh::Mesh;
use glam::{DMat3, DVec3};
use wheel::electrode::EntrySide;

fn machine() -> &'static MachineParams {
    static MACHINE: std::sync::OnceLock<MachineParams> = std::sync::OnceLock::new();
    MACHINE.get_or_init(MachineParams::default)
}

fn job() -> NcJob<'static> {
    NcJob { program: "path_1", electrode_file: "electrode_1.stl", machine: machine(), notes: &[] }
}

fn scene() -> Scene {
    Scene::new(EntrySide::MinusX)
}

fn program(post: &Post) -> String {
    NcProgram::new(&fixtures::approved(), post, &NcSettings::default(), &job()).unwrap().text().to_owned()
}

/// Words of every block that moves, as an interpreter reads them, comments and block numbers dropped.
fn moving_blocks(post: &Post, text: &str) -> Vec<Vec<(String, String)>> {
    let code = |line: &str| match line.find(post.comment.open.trim()) {
        Some(at) => line[..at].to_owned(),
        None => line.to_owned(),
    };
    let word = |w: &str| {
        let split = w.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(w.len());
        (w[..split].to_owned(), w[split..].to_owned())
    };
    let blocks = text.lines().map(|l| code(l).split_whitespace().map(word).collect::<Vec<_>>());
    blocks.filter(|b| b.iter().any(|(a, v)| a == "G" && v == "01")).collect()
}

fn value<'a>(block: &'a [(String, String)], address: &str) -> Option<&'a str> {
    block.iter().find(|(a, _)| a == address).map(|(_, v)| v.as_str())
}

#[test]
fn every_coordinate_is_the_number_of_the_path_file_there_and_back() {
    let path = fixtures::path();
    let csv = write_path_csv(&path, fixtures::certificate(&path).row_clearance()).unwrap();
    let rows: Vec<Vec<&str>> = csv.lines().skip(2).map(|l| l.split(',').collect()).collect();
    let expected: Vec<_> = rows.iter().chain(rows.iter().rev().skip(1)).collect();
    for (name, _) in crate::post::BUILT_IN {
        let post = Post::load(name, None).unwrap();
        let blocks = moving_blocks(&post, &program(&post));
        assert_eq!(blocks.len(), expected.len(), "{name}");
        for (block, row) in blocks.iter().zip(&expected) {
            for (address, column) in [("X", 2), ("Y", 3), ("Z", 4), ("A", 5), ("C", 7)] {
                assert_eq!(value(block, address), Some(row[column]), "{name}");
            }
            assert_eq!(value(block, "B"), None, "the machine has no B axis");
        }
    }
}

#[test]
fn a_post_sets_the_longest_jump_that_the_certificate_covers_before_the_feed() {
    let mut post = Post::load("iso", None).unwrap();
    let way = fixtures::path().rows[0].s;
    assert!(way > 0.0 && program(&post).contains(&format!("Jumps: up to {way:.5} mm back")), "{}", program(&post));
    post.jump = vec!["#100={jump_mm}".to_owned()];
    post.validate().unwrap();
    let text = program(&post);
    let [jump, feed] = ["#100=", "Verified motion begins"].map(|words| text.find(words).unwrap());
    assert!(jump < feed && text.contains(&format!("#100={way:.5}")), "{text}");
    post.burn = vec!["{jump_mm}".to_owned()];
    assert!(post.validate().unwrap_err().to_string().contains("in jump {jump_mm}"));
}

#[test]
fn a_certified_copying_motion_stands_between_the_burn_and_the_retraction() {
    let post = Post::load("iso", None).unwrap();
    let without = program(&post);
    let motion = scene().copying();
    let approved = fixtures::approved().with_copying(&motion).unwrap();
    let program = NcProgram::new(&approved, &post, &NcSettings::default(), &job()).unwrap();
    let with = program.text();
    let at = |text: &str| with.find(text).unwrap_or_else(|| panic!("{text} is missing in {with}"));
    assert!(at("Put the burn here") < at("Section COPYING begins") && at("COPYING ends") < at("Retraction along"));
    assert!(!without.contains("COPYING"));
    let rows = fixtures::path().rows.len();
    let blocks = moving_blocks(&post, with);
    assert_eq!(blocks.len(), moving_blocks(&post, &without).len() + 4);
    let copied: Vec<_> = blocks[rows..rows + 4].iter().map(|b| [value(b, "A"), value(b, "Z")]).collect();
    let expected =
        [["-1.200000", "0.00000"], ["0.000000", "0.00000"], ["0.000000", "0.50000"], ["0.000000", "0.00000"]];
    assert_eq!(copied, expected.map(|b| b.map(Some)));
}

#[test]
fn no_copying_motion_is_taken_that_is_not_proven_for_this_electrode() {
    let (scene, path) = (scene(), scene().copying_path(1.2));
    let refused = |path: &FeedPath, certificate: Certificate| {
        fixtures::approved().with_copying(&fixtures::copying_of(path.clone(), certificate)).unwrap_err()
    };
    // Towards the wall instead of away from it.
    let wrong_way = scene.copying_path(-1.2);
    assert!(matches!(refused(&wrong_way, scene.certificate(&wrong_way)), NotApproved::TooClose { .. }));
    let mut other = scene.clone();
    other.electrode.vertices[0].x -= 1e-9;
    assert_eq!(refused(&path, other.certificate(&path)), NotApproved::OtherElectrode);
    assert_eq!(refused(&path, scene.with_wall_nearer_by(-1.0).certificate(&path)), NotApproved::OtherBlisk);
    assert_eq!(refused(&path, scene.certificate(&scene.copying_path(1.1))), NotApproved::OtherPath);
    let small = FeedPath { spark_gap: 0.05, ..path.clone() };
    assert_eq!(refused(&small, scene.certificate(&small)), NotApproved::OtherGap { required: 0.05, spark_gap: 0.1 });
    let judged = |travel| scene.verified(&path, &VerifyOptions::default(), travel).unwrap();
    assert_eq!(refused(&path, judged(None)), NotApproved::TravelNotJudged);
    let short = judged(Some(TravelLimits::UNLIMITED.with(Axis::Z, [0.0, 0.4])));
    assert!(matches!(refused(&path, short), NotApproved::BeyondTravel(beyond) if beyond.axis == Axis::Z));
    let mut open = path.clone();
    open.rows.pop();
    assert_eq!(
        refused(&open, scene.certificate(&path)),
        NotApproved::OtherPath,
        "another motion than the certificate's"
    );
    assert_eq!(refused(&open, scene.certificate(&open)), NotApproved::WrongEnds);
    let mut unrounded = path.clone();
    unrounded.rows[1].pose.a += 1e-10;
    assert_eq!(refused(&unrounded, scene.certificate(&unrounded)), NotApproved::NotQuantised { row: 1 });
}

#[test]
fn a_reversed_axis_and_more_decimals_keep_the_value() {
    let mut post = Post::load("iso", None).unwrap();
    post.axes[3].reversed = true;
    post.decimals.deg = 9;
    let blocks = moving_blocks(&post, &program(&post));
    for (block, row) in blocks.iter().zip(&fixtures::path().rows) {
        let a: f64 = value(block, "A").unwrap().parse().unwrap();
        assert_eq!((-a).to_radians() + 0.0, row.pose.a);
    }
    assert_eq!(value(&blocks[120], "A"), Some("0.000000000"));
}

/// The time of every block after the approach, as the control takes it (minutes).
fn minutes(post: &Post, text: &str) -> Vec<f64> {
    let f = |b: &Vec<(String, String)>| value(b, "F").unwrap().parse::<f64>().unwrap();
    let blocks = moving_blocks(post, text);
    let time = |f: f64| if post.feed.mode == FeedMode::Seconds { f / 60.0 } else { 1.0 / f };
    blocks[1..].iter().map(f).map(time).collect()
}

#[test]
fn block_times_move_the_fastest_electrode_point_at_the_feed() {
    let path = fixtures::path();
    let bounds = fixtures::electrode_bounds();
    let corners = (0..8)
        .map(|i| bounds.min + bounds.size() * glam::DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64));
    let corners: Vec<_> = corners.collect();
    for mode in [FeedMode::InverseTime, FeedMode::Seconds] {
        let mut post = Post::load("beckhoff-edm", None).unwrap();
        (post.feed.mode, post.feed.decimals) = (mode, 9);
        let times = minutes(&post, &program(&post));
        assert_eq!(times.len(), 240);
        for (i, time) in times.iter().enumerate() {
            let (from, to, feed) = if i < 120 { (i, i + 1, 5.0) } else { (240 - i, 239 - i, 50.0) };
            let at = |row: usize, p| path.rows[row].pose.placement(path.reference_point).transform_point3(p);
            let chord = corners.iter().map(|&p| at(from, p).distance(at(to, p))).fold(0.0, f64::max);
            assert!((chord / time / feed - 1.0).abs() < 1e-4, "block {i}: {} mm/min", chord / time);
        }
    }
}

/// F of every block after the approach, as the control has it in force, and the minutes it makes of it by RS-274/NGC.
fn timed(post: &Post, text: &str) -> Vec<(f64, f64)> {
    let rows = fixtures::path().rows;
    let order: Vec<usize> = (0..121).chain((0..120).rev()).collect();
    let mut f = f64::NAN;
    let blocks = moving_blocks(post, text);
    let timed = blocks[1..].iter().zip(order.windows(2)).map(|(block, pair)| {
        f = value(block, "F").map_or(f, |f| f.parse().unwrap());
        let minutes = match post.feed.mode {
            FeedMode::PerMinute => programmed_length(&rows[pair[0]].pose, &rows[pair[1]].pose) / f,
            FeedMode::InverseTime => 1.0 / f,
            FeedMode::Seconds => f / 60.0,
        };
        (f, minutes)
    });
    timed.collect()
}

#[test]
fn no_axis_exceeds_its_speed_and_no_block_is_slowed_in_vain() {
    let rows = fixtures::path().rows;
    let order: Vec<usize> = (0..121).chain((0..120).rev()).collect();
    let limits = MachineParams { speed_mm_min: 30.0, speed_deg_min: 9.0, ..Default::default() };
    for mode in [FeedMode::PerMinute, FeedMode::InverseTime, FeedMode::Seconds] {
        let mut post = Post::load("iso", None).unwrap();
        (post.feed.mode, post.feed.decimals) = (mode, 6);
        let write = |machine| {
            let settings = NcSettings::default();
            NcProgram::new(&fixtures::approved(), &post, &settings, &NcJob { machine, ..job() }).unwrap()
        };
        let (limited, free) = (write(&limits), write(machine()));
        let (blocks, unlimited) = (timed(&post, limited.text()), timed(&post, free.text()));
        let mut slower = 0;
        for (i, pair) in order.windows(2).enumerate() {
            let speed = |axis: Axis| {
                let way = (rows[pair[1]].pose.get(axis) - rows[pair[0]].pose.get(axis)).abs();
                let (way, limit) = if axis.is_rotary() { (way.to_degrees(), 9.0) } else { (way, 30.0) };
                way / blocks[i].1 / limit
            };
            let fastest = Axis::ALL.map(speed).into_iter().fold(0.0, f64::max);
            assert!(fastest <= 1.0 + 1e-9, "{mode:?} block {i}: {fastest} of what an axis may");
            if blocks[i].0 != unlimited[i].0 {
                slower += 1;
                assert!(fastest > 1.0 - 1e-5, "{mode:?} block {i} need not be so slow: {fastest}");
            }
        }
        let slowed = limited.slowed().unwrap();
        assert_eq!((slowed.blocks, slowed.of, free.slowed()), (slower, 240, None), "{mode:?}");
        assert!(slower > 10 && slower < 240 && limited.text().contains("LOWERED FEED"), "{mode:?} {slower}");
        assert!(!free.text().contains("LOWERED FEED"));
    }
}

#[test]
fn a_feed_too_slow_for_its_decimals_and_a_path_beyond_travel_are_refused() {
    let mut post = Post::load("iso", None).unwrap();
    (post.feed.mode, post.feed.decimals) = (FeedMode::PerMinute, 0);
    let write = |machine| {
        NcProgram::new(&fixtures::approved(), &post, &NcSettings::default(), &NcJob { machine, ..job() }).unwrap_err()
    };
    let slow = MachineParams { speed_mm_min: 0.4, ..Default::default() };
    assert_eq!(write(&slow), NcError::FeedTooSlow { block: 0, decimals: 0 });
    let short = MachineParams { travel_x_mm: [-59.9, 0.0], ..Default::default() };
    let beyond = BeyondTravel { axis: Axis::X, row: 0, value: -60.0, limit: -59.9 };
    assert_eq!(write(&short), NcError::BeyondTravel(beyond));
}

#[test]
fn the_header_carries_the_certificate() {
    let (post, a) = (Post::load("iso", None).unwrap(), fixtures::approved());
    let c = a.certificate();
    let text = program(&post);
    let digests = [c.path_digest(), c.blisk_digest(), c.electrode_digest()].map(|d| &d[..16]);
    let least = c.least();
    assert!(c.certified() <= least.distance && (least.distance - 0.1032).abs() < 1e-4 && (least.s - 3.0).abs() < 0.5);
    let certified = format!("over the whole motion: {} mm or more", floor_mm_text(c.certified()));
    let least = format!("found: {} mm, {} mm before", floor_mm_text(least.distance), mm_text(least.s, MM_DECIMALS));
    let figures = [certified.as_str(), &least, "121 rows", "electrode_1.stl", "0.10000 mm"];
    for part in figures.into_iter().chain(digests) {
        assert!(text.contains(part), "{part}\n{text}");
    }
    assert!(text.find("G61").unwrap() < text.find("G01").unwrap(), "corners must not be rounded");
    assert!(text.lines().all(|l| l.len() <= post.max_line_length && l.is_ascii()));
}

#[test]
fn the_fastest_point_under_feed_per_minute_is_stated() {
    let path = fixtures::path();
    let bounds = fixtures::electrode_bounds();
    let ratio = |w: &[PathRow]| {
        fastest_point_travel(&w[0].pose, &w[1].pose, path.reference_point, &bounds)
            / programmed_length(&w[0].pose, &w[1].pose)
    };
    let fastest = path.rows.windows(2).map(ratio).fold(0.0, f64::max);
    let text = program(&Post::load("iso", None).unwrap());
    assert!(fastest > 1.0 && text.contains(&format!("{:.1} mm/min at this feed", 5.0 * fastest)), "{text}");
}

#[test]
fn a_file_name_cannot_smuggle_in_a_block() {
    for (name, _) in crate::post::BUILT_IN {
        let post = Post::load(name, None).unwrap();
        let evil =
            NcJob { electrode_file: "e)\nG01 Z-99\r\n;(%\u{2028}G01 Z-98 \u{202e}ü", program: "p)\nM30", ..job() };
        let text = NcProgram::new(&fixtures::approved(), &post, &NcSettings::default(), &evil).unwrap();
        assert_eq!(moving_blocks(&post, text.text()), moving_blocks(&post, &program(&post)));
        let lines = |t: &str| t.lines().filter(|l| !l.starts_with(post.comment.open.trim())).count();
        assert_eq!(lines(text.text()), lines(&program(&post)));
        assert!(text.text().is_ascii());
    }
}

#[test]
fn an_axis_that_is_not_there_is_an_error() {
    let (post, settings) = (Post::load("iso", None).unwrap(), NcSettings::default());
    let machine = MachineParams { axes: AxisSet::XYZC, ..Default::default() };
    let four = NcJob { machine: &machine, ..job() };
    let error = NcProgram::new(&fixtures::approved(), &post, &settings, &four).unwrap_err();
    assert!(matches!(error, NcError::AxisNotOnMachine { axis: 'A', .. }));
    let mut without_c = post.clone();
    without_c.axes.retain(|a| a.axis != Axis::C);
    let error = NcProgram::new(&fixtures::approved(), &without_c, &settings, &job()).unwrap_err();
    assert_eq!(error, NcError::AxisNotInPost { axis: 'C' });
    let short = Post { max_line_length: 50, ..post.clone() };
    assert!(matches!(
        NcProgram::new(&fixtures::approved(), &short, &settings, &job()),
        Err(NcError::LineTooLong { .. })
    ));
    let still = NcSettings { feed_mm_per_min: f64::NAN, ..settings };
    assert!(matches!(NcProgram::new(&fixtures::approved(), &post, &still, &job()), Err(NcError::Setting { .. })));
}

#[test]
fn block_numbers_start_again_rather_than_grow_too_long() {
    let mut post = Post::load("iso", None).unwrap();
    post.block_numbers = Some(crate::post::BlockNumbers { first: 5, step: 5, last: 100 });
    let text = program(&post);
    let numbers = text.lines().filter_map(|l| l.strip_prefix('N')?.split(' ').next()?.parse::<u32>().ok());
    let numbers: Vec<_> = numbers.collect();
    assert_eq!(&numbers[..3], [5, 10, 15]);
    assert!(numbers.len() > 240 && numbers.iter().all(|n| (5..=100).contains(n)));
}

/// Channels that are burnt: that of the path and the next one.
const BURNT: [usize; 2] = [OWN_CHANNEL, OWN_CHANNEL + 1];

/// The approved path with its simulation on a machine with bodies.
fn simulated() -> Approved {
    fixtures::approved().with_simulation(&fixtures::simulation(), &MachineModel::default()).unwrap()
}

#[test]
fn every_simulated_channel_is_burnt_with_a_turned_by_its_pitch() {
    // Without bodies, so that the machine is not turned.
    let simulation = scene().simulation(None, (machine(), &MachineModel::default()), &BURNT);
    let approved = fixtures::approved().with_simulation(&simulation, &MachineModel::default()).unwrap();
    for (name, _) in crate::post::BUILT_IN {
        let post = Post::load(name, None).unwrap();
        let program = NcProgram::new(&approved, &post, &NcSettings::default(), &job()).unwrap();
        let blocks = moving_blocks(&post, program.text());
        // To the clear position, two moves in, the feed there and back, two moves out; and again.
        let rows = fixtures::path().rows.len();
        let in_channel = 1 + 2 + 2 * (rows - 1) + 2;
        assert_eq!(blocks.len(), 2 * in_channel, "{name}");
        let number = |block: &[(String, String)], axis: &str| value(block, axis).unwrap().parse::<f64>().unwrap();
        for (first, second) in blocks[..in_channel].iter().zip(&blocks[in_channel..]) {
            for axis in ["X", "Y", "Z", "C"] {
                assert_eq!(value(first, axis), value(second, axis), "{name}");
            }
            assert!((number(second, "A") - number(first, "A") - PITCH_DEG).abs() < 1e-9, "{name}");
        }
        let clear = simulation.approach()[0];
        for at in [0, in_channel - 1, in_channel] {
            assert!(
                (number(&blocks[at], "X") - clear.x).abs() < 1e-9 && (number(&blocks[at], "Z") - clear.z).abs() < 1e-9
            );
        }
    }
}

/// The values of all axes (mm, rad) in every block that moves, with what the post and a turned machine count the other
/// way round set right.
fn replayed(post: &Post, text: &str, is_turned: bool) -> Vec<Pose> {
    let mut at = Pose::FINAL.to_array();
    let blocks = moving_blocks(post, text);
    let poses = blocks.iter().map(|block| {
        for (i, (axis, letter)) in Axis::ALL.into_iter().zip(["X", "Y", "Z", "A", "B", "C"]).enumerate() {
            let Some(number) = value(block, letter) else { continue };
            let number: f64 = number.parse().unwrap();
            let number = if axis.is_rotary() { number.to_radians() } else { number };
            let is_opposite = is_turned && "XYAB".contains(letter);
            let is_reversed = post.axes.iter().any(|a| a.axis == axis && a.reversed);
            at[i] = if is_opposite != is_reversed { -number } else { number };
        }
        Pose { x: at[0], y: at[1], z: at[2], a: at[3], b: at[4], c: at[5] }
    });
    poses.collect()
}

/// Poses of a tour, written down without the legs of a simulation: in every channel the approach, the feed, the copying
/// motion and all the way back, A turned by the channel's angle.
fn poses_of_tour(approach: &[Pose], feed: &FeedPath, copying: &FeedPath, visits: &[Visit]) -> Vec<Pose> {
    let rows = |path: &FeedPath| path.rows.iter().map(|row| row.pose).collect::<Vec<_>>();
    let there = [&approach[..approach.len() - 1], &rows(feed)].concat();
    let back: Vec<Pose> = there.iter().rev().skip(1).copied().collect();
    let in_channel = [&there[..], &rows(copying)[1..], &back].concat();
    let turned = |visit: &Visit| {
        let turn = visit.turn;
        in_channel.iter().map(move |p| Pose { a: p.a + turn, ..*p }).collect::<Vec<_>>()
    };
    visits.iter().flat_map(turned).collect()
}

#[test]
fn a_program_replayed_is_the_motion_that_was_simulated() {
    let turn = |deg: f64| quantise_rad(deg.to_radians());
    // The plan's channel is neither the first nor the only one, and A goes both ways from it.
    let visits = [-1i32, 0, 1].map(|by| Visit {
        channel: OWN_CHANNEL.wrapping_add_signed(by as isize),
        turn: turn(f64::from(by) * PITCH_DEG),
    });
    let machine = fixtures::machine_with_bodies();
    let (bodies, channels) = (MachineModel::default(), visits.map(|v| v.channel));
    for (side, is_reversed) in [(EntrySide::PlusX, false), (EntrySide::MinusX, false), (EntrySide::MinusX, true)] {
        let scene = Scene::new(side);
        let copying = scene.copying();
        let simulation = scene.simulation(Some(&copying), (&machine, &bodies), &channels);
        assert!(simulation.holds(), "{}", simulation.sentence());
        // The order in which A goes through them is the machine's own.
        let mut expected_visits = visits;
        expected_visits.sort_by_key(|v| simulation.visits().iter().position(|w| w.channel == v.channel));
        assert_eq!(simulation.visits(), expected_visits);
        let approved = scene.approved().with_copying(&copying).unwrap();
        let approved = approved.with_simulation(&simulation, &bodies).unwrap();
        let expected = poses_of_tour(simulation.approach(), &scene.path, &copying.path, &expected_visits);
        for (name, _) in crate::post::BUILT_IN {
            let mut post = Post::load(name, None).unwrap();
            post.axes.iter_mut().filter(|a| a.axis == Axis::A).for_each(|a| a.reversed = is_reversed);
            let job = NcJob { machine: &machine, ..job() };
            let program = NcProgram::new(&approved, &post, &NcSettings::default(), &job).unwrap();
            let poses = replayed(&post, program.text(), side == EntrySide::MinusX);
            assert_eq!(poses.len(), expected.len(), "{name}");
            for (i, (pose, expected)) in poses.iter().zip(&expected).enumerate() {
                let off = pose.to_array().into_iter().zip(expected.to_array()).map(|(p, q)| (p - q).abs());
                assert!(off.fold(0.0, f64::max) < 1e-9, "{name} block {i}: {pose:?} {expected:?}");
            }
        }
    }
}

#[test]
fn a_machine_with_bodies_wants_a_simulation_that_holds_of_this_very_motion() {
    let machine = fixtures::machine_with_bodies();
    let (post, job) = (Post::load("iso", None).unwrap(), NcJob { machine: &machine, ..job() });
    let program = |approved: &Approved| NcProgram::new(approved, &post, &NcSettings::default(), &job).map(|_| ());
    assert_eq!(program(&fixtures::approved()), Err(NcError::NotSimulated));
    let approved = simulated();
    assert_eq!(program(&approved), Ok(()));

    let (scene, nothing) = (scene(), MachineModel::default());
    let on = |machine: &MachineParams| scene.simulation(None, (machine, &nothing), &BURNT);
    let given = |simulation: &Simulation| fixtures::approved().with_simulation(simulation, &nothing);
    let clear_by = |mm: f64| on(&MachineParams { body_clearance_mm: mm, ..machine.clone() });
    assert_eq!(program(&given(&on(&MachineParams::default())).unwrap()), Err(NcError::NotSimulated));
    let nearer = program(&given(&clear_by(0.99)).unwrap());
    assert!(matches!(nearer, Err(NcError::OtherMachineSimulated { .. })), "{nearer:?}");
    assert_eq!(program(&given(&clear_by(1.01)).unwrap()), Ok(()));
    assert!(matches!(given(&clear_by(f64::NAN)), Err(NotApproved::Collides(_))));
    let without_name = NcJob { machine: &MachineParams::default(), ..job.clone() };
    let turned = NcProgram::new(&approved, &post, &NcSettings::default(), &without_name);
    assert!(matches!(turned, Err(NcError::OtherMachineSimulated { .. })), "{turned:?}");

    let another = |simulation: &Simulation, what: &'static str| {
        assert_eq!(given(simulation).unwrap_err(), NotApproved::OtherSimulated(what));
    };
    let of = |scene: &Scene| scene.simulation(None, (&machine, &nothing), &BURNT);
    let mut other = scene.clone();
    other.path.rows[60].pose.y += 1e-5;
    another(&of(&other), "path");
    another(&scene.simulation(Some(&scene.copying()), (&machine, &nothing), &BURNT), "copying motion");
    another(&of(&scene.with_wall_nearer_by(-1e-9)), "blisk");
    let mut other = scene.clone();
    other.electrode.vertices[0].z += 1e-9;
    another(&of(&other), "electrode");
    // Above everything, so that nothing is met.
    let far = Mesh::cuboid(DVec3::ONE).mapped(|p| p + DVec3::new(0.0, 0.0, 2000.0));
    let bodies = MachineModel { bodies: vec![Body { name: "lamp".to_owned(), carrier: Carrier::Bed, mesh: far }] };
    another(&scene.simulation(None, (&machine, &bodies), &BURNT), "machine");
    another(&of(&Scene { side: EntrySide::PlusX, ..scene.clone() }), "side of entry");

    let collides = |simulation: &Simulation, bodies: &MachineModel| {
        let error = fixtures::approved().with_simulation(simulation, bodies).unwrap_err();
        let NotApproved::Collides(text) = error else { panic!("{error}") };
        text
    };
    assert!(collides(&scene.simulation(None, (&machine, &nothing), &[]), &nothing).contains("Nothing was simulated"));
    let limited = MachineParams { travel_a_deg: [-25.0, 25.0], ..machine.clone() };
    assert!(collides(&on(&limited), &nothing).contains("channel 4"));
    // A post where the electrode ends up.
    let post_there = Mesh::cuboid(DVec3::splat(400.0)).mapped(|p| p - DVec3::splat(200.0));
    let bodies =
        MachineModel { bodies: vec![Body { name: "post".to_owned(), carrier: Carrier::Bed, mesh: post_there }] };
    assert!(collides(&scene.simulation(None, (&machine, &bodies), &BURNT), &bodies).contains("post"));

    // A machine whose A does not go as far as the second channel.
    let short = MachineParams { travel_a_deg: [-20.0, 20.0], ..machine.clone() };
    let job = NcJob { machine: &short, ..job };
    let error = NcProgram::new(&approved, &post, &NcSettings::default(), &job).unwrap_err();
    assert!(matches!(error, NcError::BeyondTravel(beyond) if beyond.axis == Axis::A), "{error}");
}

/// A simulation knows the copying motion that it was made with, whichever of the two is given first.
#[test]
fn a_copying_motion_given_after_the_simulation_wants_another() {
    let copying = scene().copying();
    let feed_only = simulated();
    assert!(feed_only.simulation().is_some());
    let with_copying = feed_only.with_copying(&copying).unwrap();
    assert_eq!(with_copying.simulation(), None);
    let (machine, nothing) = (fixtures::machine_with_bodies(), MachineModel::default());
    let (post, job) = (Post::load("iso", None).unwrap(), NcJob { machine: &machine, ..job() });
    let program = NcProgram::new(&with_copying, &post, &NcSettings::default(), &job);
    assert_eq!(program, Err(NcError::NotSimulated));
    let error = with_copying.clone().with_simulation(&fixtures::simulation(), &nothing).unwrap_err();
    assert_eq!(error, NotApproved::OtherSimulated("copying motion"));
    let of_both = scene().simulation(Some(&copying), (&machine, &nothing), &BURNT);
    assert!(with_copying.with_simulation(&of_both, &nothing).unwrap().simulation().is_some());
}

/// An electrode from -X on a machine with bodies finds the machine turned by half a turn about Z against W. When part,
/// electrode and path are turned by as much, the machine itself does the very same.
#[test]
fn a_turned_machine_has_x_y_a_and_b_the_other_way_round_and_is_told() {
    let (machine, nothing) = (fixtures::machine_with_bodies(), MachineModel::default());
    let post = Post::load("iso", None).unwrap();
    let text = |side: EntrySide, machine: &MachineParams| {
        let scene = Scene::new(side);
        let simulation = scene.simulation(None, (machine, &nothing), &[OWN_CHANNEL]);
        let approved = scene.approved().with_simulation(&simulation, &nothing).unwrap();
        let job = NcJob { machine, ..job() };
        NcProgram::new(&approved, &post, &NcSettings::default(), &job).unwrap().text().to_owned()
    };
    let words = |text: &str, letter: &str| -> Vec<f64> {
        moving_blocks(&post, text).iter().map(|block| value(block, letter).unwrap().parse().unwrap()).collect()
    };
    let [minus, plus] = [EntrySide::MinusX, EntrySide::PlusX].map(|side| text(side, &machine));
    let in_w = text(EntrySide::MinusX, &MachineParams::default());
    for (letter, sign) in [("X", -1.0), ("Y", -1.0), ("Z", 1.0), ("A", -1.0), ("C", 1.0)] {
        let turned = words(&minus, letter);
        assert!(turned.iter().any(|v| *v != 0.0), "{letter}");
        assert_eq!(turned, words(&plus, letter), "{letter}");
        assert_eq!(turned, words(&in_w, letter).into_iter().map(|v| sign * v).collect::<Vec<_>>(), "{letter}");
    }
    let told = "TURNED BY HALF A TURN";
    assert!(minus.contains(told) && !plus.contains(told) && !in_w.contains(told));
}
