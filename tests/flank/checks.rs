//! What checks find, where it is, and how far decisions on it go.

use super::*;
use nc::flank_job::LoadedSurface;

/// Guides of 10 mm height over an arc of `radius` (mm) from 0 to `to_deg`.
fn upright_arc(radius: f64, to_deg: f64) -> LoadedSurface {
    let arc = |z: f64| {
        let angles = (0..=60).map(|i| (f64::from(i) * to_deg / 60.0).to_radians());
        let points = angles.map(|a| DVec3::new(radius * a.cos(), radius * a.sin(), z)).collect();
        GuideCurve::Points { points, degree: 3 }
    };
    LoadedSurface::Guides { lower: arc(0.0), upper: arc(10.0) }
}

/// A cutter of radius 3 in a hollow of radius 4 that goes around by 190 degrees, without a machine.
fn in_a_hollow() -> FlankInput {
    let mut input = loaded(&quick());
    input.surface = upright_arc(4.0, 190.0);
    input.side = Side::Negative;
    input.cutter = FlankCutter::cylinder(3.0, 20.0);
    input.machine = None;
    input
}

#[test]
fn decisions_on_leads_are_held_against_what_is_cut_of_surface_and_wall() {
    let mut input = in_a_hollow();
    let free = run(&input);
    let own = check(&free, CheckKind::Leads).figures.clone();
    // 3 mm aside in a hollow that leaves 2 mm.
    assert!(own.len() == 1 && (own["own_excess_mm"] - 1.0).abs() < 0.02, "{own:?}");
    let decided = |result: &FlankResult, text: &str| {
        let mut result = result.clone();
        result.decide(&[text.parse().unwrap()]);
        check(&result, CheckKind::Leads).is_overridden
    };
    assert!(!decided(&free, "leads:0.05") && decided(&free, "leads:1.05") && decided(&free, "leads"));
    for (away, is_wall_worse) in [(1.0, true), (2.5, false)] {
        input.walls = Some(needle(&free, (1.0, 6.0, away)).1);
        let result = run(&input);
        let leads = check(&result, CheckKind::Leads);
        assert_eq!(leads.figures["own_excess_mm"], own["own_excess_mm"]);
        assert!((leads.figures["depth_mm"] - (3.0 - away)).abs() < 0.02, "{:?}", leads.figures);
        let [of_own, of_wall] =
            ["cut the surface itself", "deep into a wall"].map(|words| leads.text.find(words).unwrap());
        assert_eq!(of_wall < of_own, is_wall_worse, "the worse comes first: {}", leads.text);
        assert!(
            leads.text.contains("shorten the lead-in") && leads.text.contains("move the walls away"),
            "{}",
            leads.text
        );
        // What was decided of the surface alone lets no wall be cut.
        assert_eq!(decided(&result, "leads:1.05"), !is_wall_worse);
        let mut again = result.clone();
        again.decide(&[free.let_pass(check(&free, CheckKind::Leads))]);
        let why = again.why_blocked().unwrap();
        assert!(why.contains("depth mm is") && why.contains("decide again"), "{why}");
    }
}

#[test]
fn what_has_no_figure_is_not_within_one() {
    let mut input = loaded(&quick());
    input.machine.as_mut().unwrap().linear.x_mm = [-400.0, 0.0];
    let mut result = run(&input);
    result.decide(&["machine:5".parse().unwrap()]);
    let why = result.why_blocked().unwrap();
    assert!(why.starts_with("machine:") && why.contains("name the check alone"), "{why}");
    result.decide(&["machine".parse().unwrap()]);
    assert_eq!(result.why_blocked(), None);
}

/// How deep straight moves of a cylinder's axis from one record to the next cut into an upright arc of `radius` about the Z
/// axis from inside or outside, by the records of the cut alone.
fn cut_by_records(text: &str, (radius, cutter, is_outside): (f64, f64, bool)) -> f64 {
    let mut is_cut = false;
    let mut places = Vec::new();
    for line in text.lines() {
        is_cut = if line.starts_with("$$ cut") { true } else { is_cut && !line.starts_with("$$ retract") };
        if let Some(record) = line.strip_prefix("GOTO/").filter(|_| is_cut) {
            let n: Vec<f64> = record.split(',').map(|n| n.parse().unwrap()).collect();
            places.push(glam::DVec2::new(n[0], n[1]));
        }
    }
    assert!(places.len() > 3);
    let along = places.windows(2).flat_map(|w| (0..=50).map(move |i| w[0].lerp(w[1], f64::from(i) / 50.0)));
    let depth = |p: glam::DVec2| if is_outside { radius - (p.length() - cutter) } else { p.length() + cutter - radius };
    along.map(depth).fold(0.0, f64::max)
}

#[test]
fn what_straight_moves_cut_between_the_records_is_checked() {
    let mut input = in_a_hollow();
    (input.surface, input.params.locations, input.params.below_mm) = (upright_arc(50.0, 90.0), 10, 0.0);
    for side in [Side::Positive, Side::Negative] {
        input.side = side;
        input.milling.linearisation_mm = 0.002;
        let close = run(&input);
        assert!(
            check(&close, CheckKind::Deviation).holds && close.chordal_deviation_mm <= 0.002,
            "{}",
            close.chordal_deviation_mm
        );
        // Ten locations on 90 degrees are 10 degrees apart: the axis goes 53 (1 - cos 5 deg) mm inwards between them.
        input.milling.linearisation_mm = 0.3;
        let coarse = run(&input);
        let pose = coarse.path().pose(0.5);
        let distance = pose.tip.truncate().length();
        let sagitta = distance * (1.0 - 5f64.to_radians().cos());
        assert!(
            (coarse.chordal_deviation_mm / sagitta - 1.0).abs() < 0.03,
            "{} {sagitta}",
            coarse.chordal_deviation_mm
        );
        let deviation = check(&coarse, CheckKind::Deviation);
        assert!(!deviation.holds && deviation.text.contains("mm chordal deviation"), "{}", deviation.text);
        assert!(deviation.text.contains("linearisation tolerance"), "{}", deviation.text);
        let is_outside = distance > 50.0;
        let records = cl_text(&ApprovedFlank::new(&let_pass(&coarse)).unwrap()).unwrap();
        let cut = cut_by_records(&records, (50.0, 3.0, is_outside));
        assert!(cut <= deviation.figures["overcut_mm"] + 1e-6, "{cut} {:?}", deviation.figures);
        assert!(!is_outside || cut > 0.2, "{cut}");
    }
}

#[test]
fn walls_are_nearer_by_what_straight_moves_leave_the_path() {
    let mut input = in_a_hollow();
    (input.surface, input.params.locations) = (upright_arc(50.0, 90.0), 10);
    input.milling.linearisation_mm = 0.3;
    let free = run(&input);
    let away = 0.5 * free.chordal_deviation_mm;
    input.walls = Some(needle(&free, (0.5, 6.0, away)).1);
    let result = run(&input);
    let gouge = check(&result, CheckKind::Gouge);
    let distance = result.gouge.unwrap().cutter.unwrap().distance_mm;
    assert!((distance - away).abs() < 0.02 && !gouge.holds, "{distance} {}", gouge.text);
    assert!((gouge.figures["depth_mm"] - (free.chordal_deviation_mm - distance)).abs() < 1e-9, "{:?}", gouge.figures);
}

#[test]
fn a_failing_deviation_is_placed_where_it_is_worst_against_its_own_tolerance() {
    let input = loaded(&quick());
    let first = run(&input);
    let values = || {
        let (path, checked) = (first.path(), &first.checked);
        let planned = [&path.deviation, &path.envelope.deviation];
        planned.into_iter().chain([&checked.deviation, &checked.envelope.deviation])
    };
    let most = |sign: f64| {
        let of = |d: &flank::deviation::Deviation| {
            let [along, across] = d.grid;
            let k = (0..d.values.len()).max_by(|a, b| (sign * d.values[*a]).total_cmp(&(sign * d.values[*b]))).unwrap();
            let [u, v] = [(k / across, along), (k % across, across)].map(|(i, n)| i as f64 / (n - 1) as f64);
            (sign * d.values[k], first.surface.point(u, v))
        };
        values().map(of).max_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
    };
    let ((over, over_at), (under, under_at)) = (most(-1.0), most(1.0));
    assert!(over > 1e-3 && under > 1e-3 && over_at.distance(under_at) > 0.5, "{over} {under}");
    for (tolerances, place) in [([0.5 * over, 1.0], over_at), ([1.0, 0.5 * under], under_at)] {
        let mut input = input.clone();
        [input.overcut_tolerance_mm, input.undercut_tolerance_mm] = tolerances;
        let result = run(&input);
        let deviation = check(&result, CheckKind::Deviation);
        assert!(!deviation.holds && deviation.place.unwrap().distance(place) < 1e-9, "{deviation:?} {place}");
    }
}

#[test]
fn a_tool_inside_a_wall_that_lacks_a_triangle_gouges_it() {
    let mut input = loaded(&quick());
    let around = geometry::mesh::Mesh {
        vertices: (0..8)
            .map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)) * 800.0 - 400.0)
            .collect(),
        triangles: vec![
            [0, 2, 3],
            [0, 3, 1],
            [4, 5, 7],
            [4, 7, 6],
            [0, 1, 5],
            [0, 5, 4],
            [2, 6, 7],
            [2, 7, 3],
            [0, 4, 6],
            [0, 6, 2],
            [1, 3, 7],
            [1, 7, 5],
        ],
    };
    let open = Mesh { triangles: around.triangles[1..].to_vec(), ..around.clone() };
    for (wall, is_open) in [(around, false), (open, true)] {
        input.walls = Some(Arc::new(wall));
        let result = run(&input);
        assert!(!check(&result, CheckKind::Gouge).holds && !check(&result, CheckKind::Leads).holds);
        assert_eq!(result.warnings.iter().any(|w| w.contains("open at 3 edges")), is_open, "{:?}", result.warnings);
    }
}

#[test]
fn guides_with_a_corner_of_few_points_fail_and_dense_curves_do_not() {
    let mut input = loaded(&quick());
    (input.machine, input.side) = (None, Side::Positive);
    let row = |z: f64| GuideCurve::Points {
        points: [[0.0, 0.0], [20.0, 0.0], [20.0, 20.0]].map(|[x, y]| DVec3::new(x, y, z)).to_vec(),
        degree: 3,
    };
    input.surface = LoadedSurface::Guides { lower: row(0.0), upper: row(10.0) };
    let result = run(&input);
    let guides = check(&result, CheckKind::Guides);
    // The parabola through the three has its foot beside the middle of either side.
    assert!(!guides.holds && result.why_blocked().is_some_and(|why| why.contains("guides: the points")), "{guides:?}");
    assert!(guides.figures.get("off_mm").is_some_and(|off| *off > 1.0) && guides.place.is_some(), "{guides:?}");
    input.surface = upright_arc(20.0, 120.0);
    let result = run(&input);
    let guides = check(&result, CheckKind::Guides);
    // The sagitta of two degrees.
    let sagitta = 20.0 * (1.0 - 1f64.to_radians().cos());
    assert!(guides.holds && guides.text.contains(&format!("up to {sagitta:.3} mm")), "{}", guides.text);
    // Curves that are not given by points have no such check.
    assert!(planned().iter().all(|(_, result)| result.checks.iter().all(|c| c.kind != CheckKind::Guides)));
}

#[test]
fn a_path_that_ends_too_early_is_told_what_would_cover_the_surface() {
    let mut document = quick();
    document.plan.is_covering = false;
    let result = run(&loaded(&document));
    let coverage = check(&result, CheckKind::Coverage);
    assert!(!coverage.holds && coverage.text.contains("are needed"), "{}", coverage.text);
    assert!(coverage.text.contains("is_covering") && coverage.text.contains("--points"), "{}", coverage.text);
    // A path that covers no more is no remedy.
    let covers = result.plan.refined.coverage.is_whole;
    assert_eq!(coverage.text.contains("--path refined"), covers, "{}", coverage.text);
}

/// The curve of a path that `flank.json` tells: a uniform cubic B-spline that is periodic, at share `x` of piece `i`.
pub(super) fn periodic(points: &Value, (i, x): (usize, f64)) -> DVec3 {
    let points = points.as_array().unwrap();
    let point = |k: usize| {
        let at = |axis: usize| points[k % points.len()][axis].as_f64().unwrap();
        DVec3::new(at(0), at(1), at(2))
    };
    let weights =
        [(1.0 - x).powi(3), 3.0 * x.powi(3) - 6.0 * x * x + 4.0, 3.0 * (x + x * x - x.powi(3)) + 1.0, x.powi(3)];
    weights.iter().enumerate().map(|(k, weight)| point(i + k) * *weight / 6.0).sum()
}
