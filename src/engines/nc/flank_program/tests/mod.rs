//! Programs of flank paths are read back by a reader of their own and compared with the path.

use glam::{DMat3, DVec3};

use super::*;
use crate::cutter_locations::{ClJob, text_of};
use flank::machine::kinematics::ToolPose;
use flank::machine::linearise::linearise;
use flank::machine::milling_machine::MillingMachine;
use flank::machine::singular::Passage;
use task::Cancel;

mod tip;

const REACH: f64 = 20.0;

fn machines() -> Vec<MillingMachine> {
    #[derive(serde::Deserialize)]
    struct Library {
        machine: Vec<MillingMachine>,
    }
    toml::from_str::<Library>(include_str!("../../../../../assets/milling_machines.toml")).unwrap().machine
}

fn bent(u: f64) -> (DVec3, DVec3) {
    let tip = DVec3::new(60.0 * u - 30.0, 12.0 * (2.0 * u).sin(), 3.0 * u * u);
    (tip, DVec3::new(0.2 + 0.3 * u, 0.25 * (3.0 * u).cos(), 1.0))
}

/// In from above and out again.
fn path<'a>() -> ToolPath<'a> {
    let lead = |u: f64, by: f64| {
        let (tip, axis) = bent(u);
        ToolPose { tip: tip + axis.normalize() * by, axis }
    };
    let points: Vec<f64> = (0..=8).map(|i| f64::from(i) / 8.0).collect();
    ToolPath::with_leads(bent, &points, &[lead(0.0, 60.0)], &[lead(1.0, 40.0), lead(1.0, 80.0)]).unwrap()
}

struct Made {
    nc: FlankNc,
    line: MachinePath,
    params: LinearisationParams,
}

fn made(k: &Kinematics, post: &Post, tip_control: TipControl) -> Made {
    let interpolation = tip_control.interpolation();
    let params = LinearisationParams { reach_mm: REACH, interpolation, ..LinearisationParams::default() };
    let path = path();
    let line = linearise(k, &path, &params, &Cancel::default()).unwrap();
    let (notes, warnings) = (["Surface (A); tolerance 0.01 mm".to_owned()], ["the holder is near".to_owned()]);
    let job = FlankNcJob {
        program: "flank_1",
        cutter: "cone, bottom 2 mm, 5 degrees",
        machine: k,
        path: &path,
        line: &line,
        params: &params,
        contact: None,
        notes: &notes,
        warnings: &warnings,
    };
    let settings = FlankNcSettings { tip_control, ..FlankNcSettings::default() };
    Made { nc: FlankNc::of(&job, post, &settings).unwrap(), line, params }
}

/// A block as a control reads it: letters with their numbers.
type Block = Vec<(char, f64)>;

/// Comments go, words are split at their letters.
fn blocks(text: &str) -> Vec<Block> {
    let mut found = Vec::new();
    for line in text.lines().filter(|l| *l != "%") {
        let mut bare = String::new();
        let mut depth = 0;
        for c in line.chars() {
            match c {
                '(' => depth += 1,
                ')' => depth -= 1,
                _ if depth == 0 => bare.push(c),
                _ => {}
            }
        }
        assert_eq!(depth, 0, "{line}");
        let word = |w: &str| (w.chars().next().unwrap(), w[1..].parse::<f64>().unwrap());
        let block: Block = bare.split_whitespace().map(word).collect();
        if !block.is_empty() {
            found.push(block);
        }
    }
    found
}

fn value(block: &Block, letter: char) -> Option<f64> {
    block.iter().find(|(c, _)| *c == letter).map(|(_, v)| *v)
}

/// Moves: values of the letters, F, and whether F is one over the time.
fn moves(text: &str, letters: &str) -> Vec<(Vec<f64>, f64, bool)> {
    let (mut found, mut feed, mut inverse) = (Vec::new(), 0.0, false);
    for block in blocks(text) {
        for (c, v) in &block {
            match (c, *v) {
                ('G', v) if v == 93.0 || v == 94.0 => inverse = v == 93.0,
                ('F', v) => feed = v,
                _ => {}
            }
        }
        if value(&block, 'G') == Some(1.0) {
            assert!(!inverse || value(&block, 'F').is_some(), "every block of G93 needs its F");
            found.push((letters.chars().map(|c| value(&block, c).unwrap()).collect(), feed, inverse));
        }
    }
    found
}

/// The tool on the workpiece, worked out from what the machines are and not by their kinematics.
fn tool(kind: usize, v: &[f64]) -> (DVec3, DVec3) {
    let (xyz, [first, second]) = (DVec3::new(v[0], v[1], v[2]), [v[3].to_radians(), v[4].to_radians()]);
    match kind {
        // The cradle goes about -X through z = -30 of the workpiece, the table in it about -Z: undone in this order.
        0 => {
            let (a, c) = (DMat3::from_rotation_x(first), DMat3::from_rotation_z(second));
            let pivot = DVec3::new(0.0, 0.0, -30.0);
            (c * (a * (xyz - pivot) + pivot), c * a * DVec3::Z)
        }
        // The pivot is 330 mm above the tip.
        1 => {
            let turned = DMat3::from_rotation_z(first) * DMat3::from_rotation_y(second);
            let pivot = xyz + 330.0 * DVec3::Z;
            (pivot + turned * DVec3::new(0.0, 0.0, -330.0), turned * DVec3::Z)
        }
        // The pivot is 290 mm above the tip; the table turns about Z of the workpiece.
        _ => {
            let (b, c) = (DMat3::from_rotation_y(first), DMat3::from_rotation_z(second));
            let pivot = xyz + 290.0 * DVec3::Z;
            (c * (pivot + b * DVec3::new(0.0, 0.0, -290.0)), c * b * DVec3::Z)
        }
    }
}

/// Distance of `p` from the curve through `points`, and the piece that is nearest; searched on from `start`.
fn off_curve(points: &[DVec3], p: DVec3) -> f64 {
    let piece = |w: &[DVec3]| {
        let along = w[1] - w[0];
        let t =
            if along == DVec3::ZERO { 0.0 } else { ((p - w[0]).dot(along) / along.length_squared()).clamp(0.0, 1.0) };
        p.distance(w[0] + along * t)
    };
    points.windows(2).map(piece).fold(f64::INFINITY, f64::min)
}

/// A job without contact, notes and warnings.
fn bare_job<'a>(
    machine: &'a Kinematics,
    path: &'a ToolPath<'a>,
    line: &'a MachinePath,
    params: &'a LinearisationParams,
) -> FlankNcJob<'a> {
    let (program, cutter) = ("p", "");
    FlankNcJob { program, cutter, machine, path, line, params, contact: None, notes: &[], warnings: &[] }
}

#[test]
fn a_program_read_back_follows_the_path_on_every_machine() {
    let path = path();
    let samples: Vec<ToolPose> = (0..=path.last() * 150).map(|i| path.at(i as f64 / 150.0).unwrap()).collect();
    let curve = |h: f64| samples.iter().map(|pose| pose.at_height(h)).collect::<Vec<DVec3>>();
    let (tips, tops) = (curve(0.0), curve(REACH));
    for (kind, (machine, letters)) in machines().iter().zip(["XYZAC", "XYZCB", "XYZBC"]).enumerate() {
        let k = machine.kinematics().unwrap();
        let made = made(&k, &milling_post("milling").unwrap(), TipControl::Off);
        let moves = moves(&made.nc.text, letters);
        assert_eq!(moves.len(), made.line.points.len());
        let mut minutes = 0.0;
        for w in moves.windows(2) {
            assert!(w[1].2);
            minutes += 1.0 / w[1].1;
            for i in 0..=4 {
                let t = f64::from(i) / 4.0;
                let at: Vec<f64> = w[0].0.iter().zip(&w[1].0).map(|(a, b)| a + (b - a) * t).collect();
                let (tip, axis) = tool(kind, &at);
                // The curves are chords themselves, 0.05 micrometre from the path at most.
                let most = made.params.linearisation_mm + 5e-5;
                assert!(off_curve(&tips, tip) <= most && off_curve(&tops, tip + axis * REACH) <= most);
            }
        }
        // Both ends are where they should be, and F rounded down only makes it slower.
        assert!(tool(kind, &moves[0].0).0.distance(samples[0].tip) < 1e-4);
        assert!(tool(kind, &moves[moves.len() - 1].0).0.distance(samples[samples.len() - 1].tip) < 1e-4);
        assert!(minutes >= made.nc.minutes && minutes < made.nc.minutes * 1.01, "{minutes} {}", made.nc.minutes);
    }
}

#[test]
fn per_minute_feeds_and_seconds_take_the_same_time() {
    let k = machines()[0].kinematics().unwrap();
    let mut post = milling_post("milling").unwrap();
    post.feed.mode = FeedMode::PerMinute;
    post.feed.word = "G94".to_owned();
    let made_per_minute = made(&k, &post, TipControl::Off);
    let mut minutes = 0.0;
    for w in moves(&made_per_minute.nc.text, "XYZAC").windows(2) {
        let by: Vec<f64> = w[0].0.iter().zip(&w[1].0).map(|(a, b)| b - a).collect();
        let length = DVec3::new(by[0], by[1], by[2]).length();
        minutes += length / w[1].1;
    }
    let total = made_per_minute.nc.minutes;
    assert!(minutes >= total * (1.0 - 1e-9) && minutes < total * 1.01, "{minutes} {total}");
    post.feed.mode = FeedMode::Seconds;
    let seconds: f64 = moves(&made(&k, &post, TipControl::Off).nc.text, "XYZAC").iter().skip(1).map(|m| m.1).sum();
    assert!(seconds / 60.0 >= total && seconds / 60.0 < total * 1.01);
}

#[test]
fn short_blocks_take_the_time_that_is_said() {
    let k = machines()[0].kinematics().unwrap();
    let path = path();
    let params = LinearisationParams { linearisation_mm: 1e-4, reach_mm: REACH, ..LinearisationParams::default() };
    let line = linearise(&k, &path, &params, &Cancel::default()).unwrap();
    let job = bare_job(&k, &path, &line, &params);
    let settings = FlankNcSettings { feed_mm_per_min: 20_000.0, lead_mm_per_min: 20_000.0, ..Default::default() };
    let post = milling_post("milling").unwrap();
    let nc = FlankNc::of(&job, &post, &settings).unwrap();
    let times: Vec<f64> = moves(&nc.text, "XYZAC").iter().skip(1).map(|m| 1.0 / m.1).collect();
    let total: f64 = times.iter().sum();
    assert!(total >= nc.minutes && total < nc.minutes * 1.001, "{total} {}", nc.minutes);
    let (count, share) = nc.stretched.unwrap();
    let shortest = times.iter().filter(|t| **t < 0.010_001 / 60.0).count();
    assert!(count == shortest && (0.0..1.0).contains(&share), "{count} {shortest} {share}");
    // They count among the moves that are slower than asked for, with what both reasons leave together.
    let paces = paces(&k, &path, &line, &settings.feeds(&params, &post, None));
    let slowed = Slowed::of(&paces).unwrap();
    let left = |p: &Pace| p.way_mm / (p.minutes * 20_000.0);
    let slow: Vec<f64> = paces.iter().map(left).filter(|share| *share < 1.0 - 1e-9).collect();
    assert_eq!((slowed.moves, slowed.short), (slow.len(), Some((count, share))));
    assert!((slow.iter().copied().fold(1.0, f64::min) - slowed.share).abs() < 1e-9 && slowed.share <= share);
    assert!(nc.text.contains("SHORT MOVES") && !nc.text.contains("as asked for throughout"));
    // F as the speed along X Y Z needs no such time.
    let mut per_minute = post;
    (per_minute.feed.mode, per_minute.feed.word) = (FeedMode::PerMinute, "G94".to_owned());
    let nc = FlankNc::of(&job, &per_minute, &settings).unwrap();
    assert!(nc.stretched.is_none() && nc.minutes < total && !nc.text.contains("SHORT MOVES"));
}

#[test]
fn the_program_says_what_it_is_for() {
    let k = machines()[0].kinematics().unwrap();
    let made = made(&k, &milling_post("milling").unwrap(), TipControl::Off);
    let text = &made.nc.text;
    for words in [
        "trunnion-ac: table-table, A C",
        "cone, bottom 2 mm, 5 degrees",
        "Tool length 120 mm",
        "asked for: 0.002 mm",
        "Surface [A], tolerance",
        "WARNING: the holder is near",
        "Section APPROACH",
        "Section CUT",
        "Section RETRACT",
        "S12000 M03",
    ] {
        assert!(text.contains(words), "{words}");
    }
    assert!(text.lines().all(|l| l.len() <= 120) && text.is_ascii());
    let mut post = milling_post("milling").unwrap();
    post.axes.retain(|a| a.axis != Axis::C);
    let path = path();
    let job = FlankNcJob {
        program: "p",
        cutter: "",
        machine: &k,
        path: &path,
        line: &made.line,
        params: &made.params,
        contact: None,
        notes: &[],
        warnings: &[],
    };
    let error = FlankNc::of(&job, &post, &FlankNcSettings::default()).unwrap_err();
    assert_eq!(error, NcError::AxisNotInPost { axis: 'C' });
    let settings = FlankNcSettings { feed_mm_per_min: f64::NAN, ..FlankNcSettings::default() };
    assert!(FlankNc::of(&job, &milling_post("milling").unwrap(), &settings).is_err());
}

#[test]
fn a_cutter_location_file_read_back_is_the_path() {
    let (path, tolerance) = (path(), 0.001);
    let notes = ["cost: 5 $".to_owned()];
    let job = ClJob {
        part: "flank 1",
        diameter_mm: 2.0,
        taper_deg: 5.0,
        flute_mm: REACH,
        spindle_rpm: 12000.0,
        feed_mm_per_min: 500.0,
        lead_mm_per_min: 2000.0,
        tolerance_mm: tolerance,
        notes: &notes,
        warnings: &[],
    };
    let text = text_of(&path, &job).unwrap();
    let numbers = |l: &str| l.split(',').map(|v| v.parse::<f64>().unwrap()).collect::<Vec<f64>>();
    let read: Vec<Vec<f64>> = text.lines().filter_map(|l| l.strip_prefix("GOTO/")).map(numbers).collect();
    let samples: Vec<DVec3> =
        (0..=path.last() * 400).map(|i| path.at(i as f64 / 400.0).unwrap().at_height(REACH)).collect();
    for w in read.windows(2) {
        let pose = |v: &[f64]| (DVec3::new(v[0], v[1], v[2]), DVec3::new(v[3], v[4], v[5]));
        let ((tip, axis), (to_tip, to_axis)) = (pose(&w[0]), pose(&w[1]));
        assert!((axis.length() - 1.0).abs() < 1e-8);
        let middle = tip.lerp(to_tip, 0.5) + axis.lerp(to_axis, 0.5).normalize() * REACH;
        assert!(off_curve(&samples, middle) < tolerance + 2e-5);
    }
    let feeds: Vec<&str> = text.lines().filter(|l| l.starts_with("FEDRAT")).collect();
    assert_eq!(feeds, ["FEDRAT/2000.000,MMPM", "FEDRAT/500.000,MMPM", "FEDRAT/2000.000,MMPM"]);
    assert!(text.contains("CUTTER/2.00000,0,1.00000,0,0,5.000000,20.00000\n") && text.contains("$$ cost: 5 _\n"));
    assert!(text.starts_with("PARTNO/flank 1\n") && text.ends_with("END\nFINI\n"));
    let gotos: Vec<usize> = text.lines().enumerate().filter(|(_, l)| l.starts_with("GOTO")).map(|(i, _)| i).collect();
    let cut = text.lines().position(|l| l == "$$ cut").unwrap();
    // The move to the start of the cut is still the approach.
    assert_eq!(gotos.iter().filter(|i| **i < cut).count(), 2);
}

/// Control points of a refined path of a cone on a ruled surface of 40 x 10 mm (surface A): the bottom of the cutter
/// and a point 10 mm above it on its axis. Independent reference computation, six decimals.
const LOWER: [[f64; 3]; 10] = [
    [69.383713, 1.043067, -9.232281],
    [71.025644, 1.883528, -9.060402],
    [74.35164, 2.588105, -9.139026],
    [79.248548, 2.691287, -9.394971],
    [84.335708, 2.300363, -9.702332],
    [89.76857, 1.78115, -9.956348],
    [95.740946, 1.452372, -10.169825],
    [102.305495, 1.735695, -10.430242],
    [107.181182, 2.650955, -10.631941],
    [109.714149, 3.426156, -10.771885],
];
/// Points of the upper guide.
const UPPER: [[f64; 3]; 10] = [
    [71.968973, 12.860459, 1.643723],
    [73.213551, 11.33756, 1.30331],
    [75.703754, 8.855094, 0.876731],
    [79.845591, 5.824411, 0.460941],
    [84.267776, 3.128864, 0.110058],
    [89.014904, 0.460416, -0.32444],
    [94.110584, -2.461273, -0.856081],
    [99.513565, -5.990199, -1.426339],
    [103.230192, -9.037466, -1.837979],
    [105.098171, -10.894204, -2.025148],
];

/// A clamped uniform cubic B-spline by de Boor's steps.
fn spline(points: &[[f64; 3]; 10], t: f64) -> DVec3 {
    let knot = |i: usize| ((i as f64 - 3.0) / 7.0).clamp(0.0, 1.0);
    let i = 3 + ((t * 7.0) as usize).min(6);
    let mut d: [DVec3; 4] = std::array::from_fn(|j| DVec3::from_array(points[i - 3 + j]));
    for r in 1..=3 {
        for j in (r..=3).rev() {
            let (low, high) = (knot(i - 3 + j), knot(i + 1 + j - r));
            d[j] = d[j - 1].lerp(d[j], (t - low) / (high - low));
        }
    }
    d[3]
}

#[test]
fn a_real_flank_that_leans_to_both_sides_of_the_pole_is_followed_on_every_machine() {
    let cut = |t: f64| {
        let tip = spline(&LOWER, t);
        (tip, spline(&UPPER, t) - tip)
    };
    let points: Vec<f64> = (0..50).map(|i| f64::from(i) / 49.0).collect();
    for machine in machines() {
        let k = machine.kinematics().unwrap();
        let path = ToolPath::new(cut, &points).unwrap();
        let params = LinearisationParams { linearisation_mm: 0.001, reach_mm: 16.0, ..LinearisationParams::default() };
        let line = linearise(&k, &path, &params, &Cancel::default()).unwrap();
        assert!(line.deviation_mm <= 0.001);
        // The tool passes 1.88 degrees beside the vertical, as computed from the same points elsewhere.
        let [passage] = &line.singular[..] else { panic!("{:?}", line.singular) };
        assert!((passage.least_deg - 1.8819).abs() < 1e-3 && passage.axis == 'C');
        let Passage::Swung { by_deg, .. } = passage.passage else { panic!("{passage}") };
        assert!((100.0..180.0).contains(&by_deg), "{by_deg}");
        let job = bare_job(&k, &path, &line, &params);
        let nc = FlankNc::of(&job, &milling_post("milling").unwrap(), &FlankNcSettings::default()).unwrap();
        // 40 mm at 500 mm/min, more where an axis is too slow.
        assert!((0.08..0.5).contains(&nc.minutes), "{}", nc.minutes);
    }
}
