use super::*;
use crate::approved::NotApproved;
use crate::fixtures;
use crate::path_csv::write_path_csv;
use feed::certificate::{Findings, TravelVerdict};
use feed::copying::CopyingMotion;
use feed::machine::AxisSet;
use feed::machine_model::MachineModel;
use feed::path::FeedPath;
use feed::quantise::quantise_rad;
use feed::simulation::{Findings as Simulated, Simulation, Visit};
use wheel::electrode::EntrySide;

fn machine() -> &'static MachineParams {
    static MACHINE: std::sync::OnceLock<MachineParams> = std::sync::OnceLock::new();
    MACHINE.get_or_init(MachineParams::default)
}

fn job() -> NcJob<'static> {
    NcJob { program: "path_1", electrode_file: "electrode_1.stl", machine: machine(), is_turned: false }
}

fn program(post: &Post) -> String {
    NcProgram::new(&fixtures::approved(), post, &NcSettings::default(), &job()).unwrap().text().to_owned()
}

/// What an interpreter sees: the words of every block that moves, comments and block numbers dropped.
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
fn a_certified_copying_motion_stands_between_the_burn_and_the_retraction() {
    let post = Post::load("iso", None).unwrap();
    let without = program(&post);
    let motion = fixtures::copying(|_| ());
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
    let refused = |motion: &CopyingMotion| fixtures::approved().with_copying(motion).unwrap_err();
    let changed = |change: fn(&mut Findings)| refused(&fixtures::copying(change));
    assert!(matches!(changed(|f| f.certified = 0.05), NotApproved::TooClose { .. }));
    assert_eq!(changed(|f| f.electrode_digest = "0".repeat(64)), NotApproved::OtherElectrode);
    assert_eq!(changed(|f| f.blisk_digest = "0".repeat(64)), NotApproved::OtherBlisk);
    assert_eq!(changed(|f| f.path_digest = "0".repeat(64)), NotApproved::OtherPath);
    assert_eq!(changed(|f| f.travel = TravelVerdict::NotJudged), NotApproved::TravelNotJudged);
    let mut open = fixtures::copying(|_| ());
    open.path.rows.pop();
    assert_eq!(refused(&open), NotApproved::OtherPath, "another motion than the certificate's");
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
    let figures = ["0.10150 mm or more", "0.10320 mm", "121 rows", "electrode_1.stl", "0.10000 mm"];
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

/// The approved path with its made-up simulation, with what was found changed by `change`.
fn simulated(change: impl Fn(&mut Simulated)) -> Result<Approved, NotApproved> {
    let mut findings = fixtures::simulation();
    change(&mut findings);
    fixtures::approved().with_simulation(&Simulation::made_up(findings), &MachineModel::default())
}

#[test]
fn every_simulated_channel_is_burnt_with_a_turned_by_its_pitch() {
    let approved = simulated(|_| ()).unwrap();
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
            assert!((number(second, "A") - number(first, "A") - 6.0).abs() < 1e-9, "{name}");
        }
        let clear = fixtures::simulation().approach[0];
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

/// What a machine is to do, written down without the legs of a simulation: in every channel the approach, the feed, the
/// copying motion and all the way back, A turned by the channel's angle.
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
    let copying = fixtures::copying(|_| ());
    let turn = |deg: f64| quantise_rad(deg.to_radians());
    // The plan's channel is neither the first nor the only one, and A goes both ways from it.
    let visits = [(2, -6.0), (3, 0.0), (4, 6.0)].map(|(channel, deg)| Visit { channel, turn: turn(deg) });
    let machine = MachineParams { name: "xyzac".to_owned(), ..Default::default() };
    let feed = fixtures::path();
    for (name, _) in crate::post::BUILT_IN {
        for (is_turned, is_reversed) in [(false, false), (true, false), (true, true)] {
            let mut findings = fixtures::simulation();
            findings.copying_digest = Some(copying.path.digest());
            findings.visits = visits.to_vec();
            findings.enters_from = if is_turned { EntrySide::MinusX } else { EntrySide::PlusX };
            let simulation = Simulation::made_up(findings);
            let approved = fixtures::approved().with_copying(&copying).unwrap();
            let approved = approved.with_simulation(&simulation, &MachineModel::default()).unwrap();
            let expected = poses_of_tour(simulation.approach(), &feed, &copying.path, &visits);
            let mut post = Post::load(name, None).unwrap();
            post.axes.iter_mut().filter(|a| a.axis == Axis::A).for_each(|a| a.reversed = is_reversed);
            let job = NcJob { is_turned, machine: &machine, ..job() };
            let program = NcProgram::new(&approved, &post, &NcSettings::default(), &job).unwrap();
            let poses = replayed(&post, program.text(), is_turned);
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
    let machine = MachineParams { name: "xyzac".to_owned(), ..Default::default() };
    let (post, job) = (Post::load("iso", None).unwrap(), NcJob { machine: &machine, ..job() });
    let program = |approved: &Approved| NcProgram::new(approved, &post, &NcSettings::default(), &job).map(|_| ());
    assert_eq!(program(&fixtures::approved()), Err(NcError::NotSimulated));
    let approved = simulated(|_| ()).unwrap();
    assert_eq!(program(&approved), Ok(()));
    let made = |change: fn(&mut Simulated)| program(&simulated(change).unwrap());
    assert_eq!(made(|s| s.with_bodies = false), Err(NcError::NotSimulated));
    let of_another = |result| matches!(result, Err(NcError::OtherMachineSimulated { .. }));
    assert!(of_another(made(|s| s.body_clearance_mm = 0.99)));
    assert!(of_another(made(|s| s.body_clearance_mm = f64::NAN)));
    assert!(of_another(made(|s| s.enters_from = EntrySide::MinusX)));
    assert_eq!(made(|s| s.body_clearance_mm = 1.01), Ok(()));
    let refused = |change: fn(&mut Simulated)| simulated(change).unwrap_err();
    let another = NotApproved::OtherSimulated;
    assert_eq!(refused(|s| s.path_digest = "0".repeat(64)), another("path"));
    assert_eq!(refused(|s| s.copying_digest = Some("0".repeat(64))), another("copying motion"));
    assert_eq!(refused(|s| s.blisk_digest = "0".repeat(64)), another("blisk"));
    assert_eq!(refused(|s| s.electrode_digest = "0".repeat(64)), another("electrode"));
    assert_eq!(refused(|s| s.model_digest = "0".repeat(64)), another("machine"));
    assert!(matches!(refused(|s| s.out_of_reach = vec![7]), NotApproved::Collides(text) if text.contains("channel 7")));
    assert!(
        matches!(refused(|s| s.pairs.clear()), NotApproved::Collides(text) if text.contains("Nothing was simulated"))
    );
    assert!(matches!(refused(|s| s.visits.clear()), NotApproved::Collides(_)));
    assert!(matches!(refused(|s| s.pairs[0].certified = 0.0), NotApproved::Collides(_)));
    // A machine whose A does not go as far as the second channel.
    let short = MachineParams { travel_a_deg: [-3.0, 5.0], ..machine.clone() };
    let job = NcJob { machine: &short, ..job };
    let error = NcProgram::new(&approved, &post, &NcSettings::default(), &job).unwrap_err();
    assert!(matches!(error, NcError::BeyondTravel(beyond) if beyond.axis == Axis::A), "{error}");
}

/// A simulation knows the copying motion that it was made with, whichever of the two is given first.
#[test]
fn a_copying_motion_given_after_the_simulation_wants_another() {
    let copying = fixtures::copying(|_| ());
    let feed_only = simulated(|_| ()).unwrap();
    assert!(feed_only.simulation().is_some());
    let with_copying = feed_only.with_copying(&copying).unwrap();
    assert_eq!(with_copying.simulation(), None);
    let machine = MachineParams { name: "xyzac".to_owned(), ..Default::default() };
    let (post, job) = (Post::load("iso", None).unwrap(), NcJob { machine: &machine, ..job() });
    let program = NcProgram::new(&with_copying, &post, &NcSettings::default(), &job);
    assert_eq!(program, Err(NcError::NotSimulated));
    let mut findings = fixtures::simulation();
    let of_feed = Simulation::made_up(findings.clone());
    let error = with_copying.clone().with_simulation(&of_feed, &MachineModel::default()).unwrap_err();
    assert_eq!(error, NotApproved::OtherSimulated("copying motion"));
    findings.copying_digest = Some(copying.path.digest());
    let of_both = Simulation::made_up(findings);
    assert!(with_copying.with_simulation(&of_both, &MachineModel::default()).unwrap().simulation().is_some());
}

/// An electrode from -X on a machine with bodies: the machine is turned by half a turn about Z against W.
#[test]
fn a_turned_machine_has_x_y_a_and_b_the_other_way_round_and_is_told() {
    let text = |is_turned: bool| {
        let (post, settings) = (Post::load("iso", None).unwrap(), NcSettings::default());
        NcProgram::new(&fixtures::approved(), &post, &settings, &NcJob { is_turned, ..job() })
            .unwrap()
            .text()
            .to_owned()
    };
    let words = |text: &str, letter: char| -> Vec<f64> {
        let moves = text.lines().filter(|line| line.contains("G01"));
        moves
            .flat_map(|l| {
                l.split_whitespace().filter_map(|w| w.strip_prefix(letter)?.parse().ok()).collect::<Vec<f64>>()
            })
            .collect()
    };
    let (straight, turned) = (text(false), text(true));
    for (letter, sign) in [('X', -1.0), ('Y', -1.0), ('Z', 1.0), ('A', -1.0), ('C', 1.0)] {
        let expected: Vec<f64> = words(&straight, letter).into_iter().map(|v| sign * v).collect();
        assert!(!expected.is_empty() && expected.iter().any(|v| *v != 0.0), "{letter}");
        assert_eq!(words(&turned, letter), expected, "{letter}");
    }
    let told = "TURNED BY HALF A TURN";
    assert!(turned.contains(told) && !straight.contains(told));
}
