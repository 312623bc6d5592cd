//! Flanks from their files to the files of the path, through the library.

use std::sync::{Arc, OnceLock};

use files::MANIFEST;
use files::Override;
use flank::cutter::{FlankCutter, HolderPart};
use flank::guide::GuideCurve;
use flank::machine::milling_machine::MillingMachine;
use flank::params::{FlankParams, Objective, OffsetMethod};
use flank::ruled_surface::{RuledSurface, Side};
use geometry::mesh::Mesh;
use glam::DVec3;
use import::{Units, write_stl};
use nc::approved_flank::{ApprovedFlank, NotApprovedFlank};
use nc::cutter_locations::cl_text;
use nc::flank_job::{CheckKind, FlankInput, FlankResult, flank};
use nc::flank_program::FlankNc;
use serde_json::Value;
use sparkpath::workspaces::flank::document::{
    CutDirection, DemonstrationSurface, FlankDocument, FlankSource, MeshFlank, PathChoice, WallsFile,
};
use sparkpath::workspaces::flank::export::{CL_FILE, CSV_FILE, ExportChoice, WrittenFlank, export};
use sparkpath::workspaces::flank::inputs::{load, load_surface};
use sparkpath::workspaces::flank::report::build::report;
use task::{Cancel, Task};
use tempfile::TempDir;

#[path = "flank/checks.rs"]
mod checks;

fn demonstration(surface: DemonstrationSurface) -> FlankDocument {
    FlankDocument { source: FlankSource::Demonstration { surface }, ..FlankDocument::default() }
}

/// Coarse and without refinement: for what does not hang on the figures.
fn quick() -> FlankDocument {
    let plan = FlankParams { grid: [30, 12], rounds: 0, ..FlankParams::default() };
    FlankDocument { plan, path: PathChoice::Chosen, ..FlankDocument::default() }
}

fn loaded(document: &FlankDocument) -> FlankInput {
    load(document, None, &Task::default()).unwrap()
}

fn run(input: &FlankInput) -> FlankResult {
    flank(input, &Task::default()).unwrap()
}

/// Both of the paper's surfaces with the paper's cone and every default.
fn planned() -> &'static [(FlankDocument, FlankResult); 2] {
    static PLANNED: OnceLock<[(FlankDocument, FlankResult); 2]> = OnceLock::new();
    PLANNED.get_or_init(|| {
        [DemonstrationSurface::A, DemonstrationSurface::B].map(|surface| {
            let mut document = demonstration(surface);
            // The reference's cutter of radius 1 mm ends where it touches the lower guide.
            let cutter = &mut document.cutter;
            cutter.radius_mm -= document.plan.below_mm * cutter.half_angle().tan();
            let result = run(&loaded(&document));
            (document, result)
        })
    })
}

fn exported(document: &FlankDocument, result: &FlankResult) -> (TempDir, WrittenFlank) {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let written = export(&out, (result, document), &[], ExportChoice::ALL, &Task::default());
    let written = written.unwrap();
    (folder, written)
}

fn read(folder: &TempDir, file: &str) -> String {
    std::fs::read_to_string(folder.path().join("out").join(file)).unwrap()
}

fn check(result: &FlankResult, kind: CheckKind) -> &nc::flank_job::FlankCheck {
    result.checks.iter().find(|c| c.kind == kind).unwrap()
}

#[test]
fn the_papers_surfaces_reach_the_figures_of_the_reference_and_the_report_says_them() {
    let reference: Value = serde_json::from_str(include_str!("data/flank/reference.json")).unwrap();
    for ((document, result), (name, paper)) in planned().iter().zip([("A", 0.541), ("B", 0.526)]) {
        let covered = &reference["cases"][format!("cone_r1_a5_{name}")]["covered"];
        let figure = |way: &[&str]| way.iter().fold(covered, |v, key| &v[key]).as_f64().unwrap();
        let (start, best) = (figure(&["init", "sum"]), figure(&["tsvd", "best"]));
        let plan = &result.plan;
        assert!((plan.initial.deviation.sum / start - 1.0).abs() < 1e-3, "{name}: {}", plan.initial.deviation.sum);
        assert!(plan.chosen.deviation.sum < best * 1.001, "{name}: {} for {best}", plan.chosen.deviation.sum);
        assert!(plan.refined.deviation.sum < plan.chosen.deviation.sum && plan.ratio(&plan.refined) < paper, "{name}");
        assert!(result.holds(), "{name}: {:?}", result.why_blocked());

        let (folder, written) = exported(document, result);
        assert_eq!(written.files, [CSV_FILE, CL_FILE, "flank.json", "report.html", "flank.ngc"]);
        let json: Value = serde_json::from_str(&read(&folder, "flank.json")).unwrap();
        let said = |i: usize, key: &str| json["paths"][i]["standing"][key].as_f64().unwrap();
        for (i, (_, path)) in plan.paths().iter().enumerate() {
            assert_eq!(said(i, "sum_mm"), path.deviation.sum);
            assert_eq!(said(i, "rms_mm"), path.deviation.rms);
            assert_eq!(said(i, "most_overcut_mm"), -path.deviation.most_overcut);
        }
        assert_eq!(json["paper"]["comparable"].as_f64(), Some(paper));
        assert_eq!(json["grid"], serde_json::json!([100, 50]));
        let html = read(&folder, "report.html");
        let ratio = format!("{:.3}", plan.ratio(&plan.refined));
        assert!(html.contains(&format!("the refined path {ratio}")) && html.contains(&format!("leaves {paper} of")));
        assert!(html.matches("<img").count() == 4 && html.contains("100 \u{d7} 50"));
        // What encodes pictures may hold any letters.
        assert!(html.split('"').filter(|part| !part.starts_with("data:")).all(|part| !part.contains("NaN")));
    }
}

#[test]
fn the_files_hold_the_path_that_was_checked() {
    let (document, result) = &planned()[0];
    let (folder, _) = exported(document, result);
    let csv = read(&folder, CSV_FILE);
    let rows: Vec<Vec<f64>> =
        csv.lines().skip(1).map(|line| line.split(',').map(|c| c.parse().unwrap_or(f64::NAN)).collect()).collect();
    assert_eq!(rows.len(), 50);
    let places: f64 = rows.iter().map(|row| row[7]).sum();
    assert_eq!(places, 5000.0, "every place of the grid belongs to one location");
    let sum: f64 = rows.iter().filter(|row| row[7] > 0.0).map(|row| row[7] * row[8]).sum();
    assert!((sum / result.path().deviation.sum - 1.0).abs() < 1e-3);
    let goto = |line: &str| -> Vec<f64> { line[5..].split(',').map(|c| c.parse().unwrap()).collect() };
    let cl = read(&folder, CL_FILE);
    let locations: Vec<Vec<f64>> = cl.lines().filter(|l| l.starts_with("GOTO/")).map(goto).collect();
    for row in &rows {
        let is_there = |l: &Vec<f64>| (0..6).all(|k| (l[k] - row[k + 1]).abs() < 2e-6);
        assert!(locations.iter().any(is_there), "{row:?}");
    }
    // Outside at both ends: beside the surface and lifted along the axis.
    let [first, last] = [&locations[0], &locations[locations.len() - 1]];
    for (outside, on) in [(first, &rows[0]), (last, &rows[49])] {
        let away: f64 = (0..3).map(|k| (outside[k] - on[k + 1]).powi(2)).sum();
        assert!((away.sqrt() - 3.0f64.hypot(30.0)).abs() < 1e-3, "{away}");
    }
    let nc = read(&folder, "flank.ngc");
    let milled = result.milled().unwrap();
    assert_eq!(nc.lines().filter(|l| l.contains("G01")).count(), milled.line.points.len());
}

/// A result whose failing checks are all overridden, each by its name for what it found.
fn let_pass(result: &FlankResult) -> FlankResult {
    let mut passed = result.clone();
    let decisions: Vec<Override> = result.checks.iter().filter(|c| !c.holds).map(|c| result.let_pass(c)).collect();
    passed.decide(&decisions);
    passed
}

#[test]
fn a_flank_is_approved_by_checks_that_hold_or_were_overridden_and_never_by_a_quick_look() {
    let mut document = quick();
    document.cutter.length_mm = 8.0;
    let short = run(&loaded(&document));
    let refused = ApprovedFlank::new(&short).err().unwrap();
    assert_eq!(refused, NotApprovedFlank::Checks(short.why_blocked().unwrap()));
    let passed = let_pass(&short);
    let approved = ApprovedFlank::new(&passed).unwrap();
    let cutter = check(&short, CheckKind::Cutter);
    assert_eq!(approved.warnings()[0], format!("check cutter fails, overridden: {}", cutter.text));
    // Another override than that for the check, or one for less than it finds, approves nothing.
    for (wrong, less) in [("gouge", None), ("cutter", Some(1e-3))] {
        let mut result = short.clone();
        result.decide(&[Override { most: less, ..Override::whatever(wrong) }]);
        assert!(ApprovedFlank::new(&result).is_err(), "{wrong}");
    }
    let quick = FlankInput { is_preview: true, ..loaded(&quick()) };
    let mut looked = run(&quick);
    looked.decide(&CheckKind::ALL.map(|kind| Override::whatever(kind.name())));
    assert_eq!(ApprovedFlank::new(&looked).err(), Some(NotApprovedFlank::Preview));
}

#[test]
fn what_is_said_of_the_moving_cutter_is_the_worse_of_the_plans_grid_and_of_the_checks() {
    let document = quick();
    let result = run(&loaded(&document));
    let [planned, checked] = [&result.path().envelope.deviation, &result.checked.envelope.deviation];
    assert!(checked.values.len() > 10 * planned.values.len());
    let worst = [-planned.most_overcut.min(checked.most_overcut), planned.most_undercut.max(checked.most_undercut)];
    assert_eq!(result.moving_most(), worst);
    let [overcut, undercut] = worst;
    let remarks = cl_text(&ApprovedFlank::new(&result).unwrap()).unwrap();
    let remarks: Vec<&str> = remarks.lines().filter_map(|line| line.strip_prefix("$$ ")).collect();
    let said = format!("Moving cutter: overcut up to {overcut:.4} mm, undercut up to {undercut:.4} mm");
    assert!(remarks.join(" ").contains(&said), "{remarks:?}");
    let report = report(&result, &document);
    assert_eq!(report.moving_most_mm, worst);
    assert!(report.sentence.contains(&format!("overcut up to {:.1} \u{b5}m", 1e3 * overcut)), "{}", report.sentence);
}

#[test]
fn a_path_that_is_off_more_than_is_allowed_is_no_program() {
    // A cylinder that touches both guides only cuts far into the surface between them.
    let mut document = quick();
    document.plan.offset = OffsetMethod::TwoPoint;
    document.path = PathChoice::Initial;
    document.cutter = FlankCutter::cylinder(2.0, 30.0);
    let result = run(&loaded(&document));
    let off = check(&result, CheckKind::Deviation);
    let most = -result.checked.envelope.deviation.most_overcut;
    let planned = -result.path().envelope.deviation.most_overcut;
    assert!(planned <= most && (planned / most - 1.0).abs() < 0.02, "on 30 x 12 places {planned}, checked {most}");
    assert!(most > document.overcut_tolerance_mm && !off.holds && result.why_blocked().is_some(), "{}", off.text);
    // Straight moves leave it by what they may, no more.
    assert!(
        result.chordal_deviation_mm > 0.0 && result.chordal_deviation_mm <= document.milling.linearisation_mm,
        "{}",
        result.chordal_deviation_mm
    );
    assert!(
        off.place.is_some() && off.text.contains(&format!("{:.4}", most + result.chordal_deviation_mm)),
        "{}",
        off.text
    );
    // Only what was not done yet is advised, and the cutter can be shown where it is.
    assert!(off.text.contains("mill the refined path, bound it"), "{}", off.text);
    let (place, pose) = (off.place.unwrap(), result.path().pose(off.t.unwrap()));
    let from_axis = (place - pose.tip).cross(pose.axis).length();
    assert!((from_axis - (2.0 - most)).abs() < 0.05, "the place is at the flutes of the cutter there: {from_axis}");
    document.plan.objective = Objective::Bounded { overcut_mm: Some(0.01), undercut_mm: None };
    let bounded = run(&loaded(&document));
    let beyond = check(&bounded, CheckKind::Bounds);
    assert!(!beyond.holds && beyond.place.is_some() && beyond.t.is_some(), "{}", beyond.text);
    assert!(beyond.text.contains("mill the refined path, widen the bounds"), "{}", beyond.text);
    assert!(!check(&bounded, CheckKind::Deviation).text.contains("bound it"));
    document.path = PathChoice::Refined;
    let refined = run(&loaded(&document));
    let again = refined.checks.iter().filter(|c| !c.holds).find(|c| c.text.contains("mill the refined path"));
    assert!(again.is_none(), "{again:?}");
    (document.path, document.plan.objective) = (PathChoice::Initial, Objective::Sum);
    document.overcut_tolerance_mm = most + result.chordal_deviation_mm + 1e-3;
    document.undercut_tolerance_mm = 1.0;
    assert!(check(&run(&loaded(&document)), CheckKind::Deviation).holds);
    // A grid on which nothing is seen of it does not help.
    document.overcut_tolerance_mm = FlankDocument::default().overcut_tolerance_mm;
    document.plan.grid = [100, 2];
    let coarse = run(&loaded(&document));
    let off = check(&coarse, CheckKind::Deviation);
    assert!(coarse.path().deviation.most_overcut > -0.01 && !off.holds, "{}", off.text);
    assert!(off.text.contains("on 100 x 50 samples, at most"), "{}", off.text);
}

#[test]
fn leads_that_cut_the_surface_itself_fail_without_any_wall() {
    let mut input = loaded(&quick());
    let arc = |z: f64| {
        let angles = (0..=60).map(|i| (f64::from(i) * 190.0 / 60.0).to_radians());
        GuideCurve::Points { points: angles.map(|a| DVec3::new(4.0 * a.cos(), 4.0 * a.sin(), z)).collect(), degree: 3 }
    };
    input.surface = nc::flank_job::LoadedSurface::Guides { lower: arc(0.0), upper: arc(10.0) };
    input.side = Side::Negative;
    input.cutter = FlankCutter::cylinder(3.0, 20.0);
    input.machine = None;
    let result = run(&input);
    let leads = check(&result, CheckKind::Leads);
    let deep = |own: &Option<flank::own_surface::OwnGouge>| own.is_some_and(|o| (o.depth_mm - 1.0).abs() < 0.02);
    assert!(result.lead_own.iter().all(deep), "3 mm aside in a hollow of 4 mm: {:?}", result.lead_own);
    assert!(!leads.holds && leads.text.contains("cut the surface itself") && leads.place.is_some(), "{}", leads.text);
    input.milling.aside_mm = 1.5;
    let short = run(&input);
    assert!(check(&short, CheckKind::Leads).holds && check(&short, CheckKind::Surface).holds);
}

#[test]
fn what_fails_a_check_is_not_written_unless_it_is_overridden_by_name() {
    let mut document = quick();
    document.cutter.length_mm = 8.0;
    let result = run(&loaded(&document));
    let short = check(&result, CheckKind::Cutter);
    assert!(!result.holds() && !short.holds && short.text.contains("flutes are 8.000 mm"), "{}", short.text);
    let uncovered = check(&result, CheckKind::Coverage);
    let v = result.surface.nearest(uncovered.place.unwrap()).v;
    assert!(v > 0.99 && uncovered.t.is_some(), "the flutes end below the upper guide: {v}");
    // What was done instead is said.
    assert!(result.warnings.iter().any(|w| w.contains("planned as if its flutes were long enough")));
    let (folder, written) = exported(&document, &result);
    assert_eq!(written.files, ["flank.json", "report.html"]);
    let told = written.sentence();
    assert!(
        told.contains("no program was written: failed checks cutter, coverage") && written.former.is_empty(),
        "{told}"
    );
    assert!(read(&folder, "report.html").contains("Check cutter fails."));
    let only_nc = ExportChoice { cl: false, nc: true, csv: false, report: false };
    let other = folder.path().join("other");
    let written = export(&other, (&result, &document), &[], only_nc, &Task::default()).unwrap();
    assert_eq!(written.files, ["flank.json", "report.html"], "the report says why there is no program");

    document.overrides = ["cutter", "coverage", "ruled"].map(Override::whatever).to_vec();
    let result = run(&loaded(&document));
    assert!(!result.holds() && result.why_blocked().is_none(), "{:?}", result.why_blocked());
    assert!(result.all_warnings().iter().any(|w| w.contains("override of \"ruled\"")));
    let (folder, written) = exported(&document, &result);
    assert!(written.files.contains(&CL_FILE.to_owned()) && written.blocked.is_none());
    assert!(read(&folder, CL_FILE).contains("WARNING: check cutter fails, overridden"));

    // An older path is not passed off as that of a plan that is blocked.
    document.overrides.clear();
    let blocked = run(&loaded(&document));
    let out = folder.path().join("out");
    let before = read(&folder, "flank.ngc");
    std::fs::write(out.join("flank.tap"), before.replace("G93", "G94")).unwrap();
    std::fs::write(out.join("flank.nc"), "(of another program)").unwrap();
    let write = |result: &FlankResult, document: &FlankDocument| {
        export(&out, (result, document), &[], ExportChoice::ALL, &Task::default()).unwrap()
    };
    let written = write(&blocked, &document);
    let told = [CSV_FILE, CL_FILE, "flank.ngc"].map(|name| format!("{name} of an earlier export was removed"));
    let renamed = "flank.tap of an earlier export is now called flank.tap.old";
    assert_eq!(written.former, [&told[..], &[renamed.to_owned()]].concat());
    assert!(written.sentence().contains(renamed));
    assert!(
        out.join("flank.tap.old").exists() && [CSV_FILE, CL_FILE, "flank.ngc"].iter().all(|f| !out.join(f).exists())
    );
    assert!(out.join("flank.nc").exists(), "what is not ours keeps its name");
    assert!(write(&blocked, &document).former.is_empty(), "what was set aside once stays so");

    // Not even where the manifest was deleted, or the program was changed by hand.
    let edited = before.clone() + "\n";
    for has_manifest in [false, true] {
        document.overrides = ["cutter", "coverage", "ruled"].map(Override::whatever).to_vec();
        write(&run(&loaded(&document)), &document);
        document.overrides.clear();
        std::fs::write(out.join("flank.ngc"), &edited).unwrap();
        if !has_manifest {
            std::fs::remove_file(out.join(MANIFEST)).unwrap();
        }
        let written = write(&blocked, &document);
        let renamed = written.former.iter().find(|note| note.starts_with("flank.ngc ")).unwrap();
        let now = renamed.rsplit(' ').next().unwrap();
        assert!(read(&folder, now) == edited && !out.join("flank.ngc").exists(), "{renamed}");
    }
    std::fs::write(out.join(MANIFEST), "[[").unwrap();
    let (choice, cancel) = (ExportChoice::ALL, Cancel::default());
    let refused = export(&out, (&blocked, &document), &[], choice, &Task::silent(&cancel)).unwrap_err();
    assert!(refused.contains("the manifest of the former export is damaged"), "{refused}");
}

#[test]
fn an_override_holds_for_what_it_was_given_for_and_for_nothing_worse() {
    let mut document = quick();
    document.cutter.length_mm = 8.0;
    let result = run(&loaded(&document));
    document.overrides = result.checks.iter().filter(|c| !c.holds).map(|c| result.let_pass(c)).collect();
    let short = check(&result, CheckKind::Cutter).figures["too_short_mm"];
    assert!(short > 0.0 && run(&loaded(&document)).why_blocked().is_none());
    // Longer flutes lack less, shorter ones more.
    document.cutter.length_mm = 8.5;
    assert!(run(&loaded(&document)).why_blocked().is_none());
    document.cutter.length_mm = 7.0;
    let worse = run(&loaded(&document));
    let (now, why) = (check(&worse, CheckKind::Cutter), worse.why_blocked().unwrap());
    assert!((now.figures["too_short_mm"] - short - 1.0).abs() < 1e-9 && !now.is_overridden);
    assert!(why.contains(&format!("more than the {short:.4} that this was decided for")), "{why}");
    let entry = serde_json::to_value(report(&worse, &document)).unwrap();
    let entry = entry["checks"].as_array().unwrap().iter().find(|c| c["name"] == "cutter").unwrap().clone();
    assert!(entry["lapsed"].as_str().unwrap().contains("decide again"), "{entry}");
    assert_eq!(entry["given_for"], format!("too short mm {short:.4}"));
    // A name alone is for whatever there is, and is remembered for what there was.
    document.overrides = document.overrides.iter().map(|one| Override::whatever(&one.check)).collect();
    assert!(run(&loaded(&document)).why_blocked().is_none());
    assert_eq!(worse.remembered(&document.overrides)[0], worse.let_pass(now));
}

#[test]
fn a_machine_that_cannot_follow_says_where_and_why() {
    let document = quick();
    let mut input = loaded(&document);
    let machine: &mut MillingMachine = input.machine.as_mut().unwrap();
    machine.linear.x_mm = [-400.0, 0.0];
    let result = run(&input);
    let failed = check(&result, CheckKind::Machine);
    assert!(!failed.holds && failed.text.contains("axis X") && failed.text.contains("outside of its limits"));
    assert_eq!(result.why_blocked().unwrap(), format!("machine: {}", failed.text));
    assert_eq!(report(&result, &document).machine.unwrap().trouble.as_deref(), Some(failed.text.as_str()));

    input.machine = None;
    let result = run(&input);
    assert!(result.holds() && result.milled.is_none());
    let (_, written) = exported(&document, &result);
    assert_eq!(written.files, [CSV_FILE, CL_FILE, "flank.json", "report.html"]);
}

#[test]
fn climb_milling_has_the_surface_to_the_right_of_the_travel_and_conventional_to_the_left() {
    let leads: Vec<DVec3> = [CutDirection::Climb, CutDirection::Conventional]
        .into_iter()
        .map(|cut| {
            let mut document = quick();
            document.milling.cut = cut;
            let result = run(&loaded(&document));
            let path = result.path();
            for pair in path.poses.windows(2) {
                let right = (pair[1].tip - pair[0].tip).cross(pair[0].axis);
                // Towards the cutter.
                let normal = result.surface.nearest(pair[0].tip + pair[0].axis).normal;
                assert!(if cut == CutDirection::Climb { right.dot(normal) < 0.0 } else { right.dot(normal) > 0.0 });
            }
            let words = format!("({} milling", if cut == CutDirection::Climb { "Climb" } else { "Conventional" });
            let (folder, _) = exported(&document, &result);
            assert!(read(&folder, "flank.ngc").contains(&words));
            result.approach[0].tip
        })
        .collect();
    assert!(leads[0].distance(leads[1]) > 20.0, "they begin at opposite ends");
}

#[test]
fn a_tool_longer_than_the_machines_is_said() {
    let mut document = quick();
    let part = HolderPart { length_mm: 100.0, lower_radius_mm: 4.0, upper_radius_mm: 20.0 };
    document.cutter.holder = vec![part];
    let result = run(&loaded(&document));
    let failed = check(&result, CheckKind::Machine);
    assert!(
        !failed.holds && failed.text.contains("130.000 mm long") && failed.text.contains("120.000 mm"),
        "{}",
        failed.text
    );
    document.milling.gauge_length_mm = Some(130.0);
    assert!(check(&run(&loaded(&document)), CheckKind::Machine).holds);
}

/// A needle towards the flutes from behind, square to them `height` above the tip, `away` from them (mm) at `t` of the path.
fn needle(result: &FlankResult, (t, height, away): (f64, f64, f64)) -> (DVec3, Arc<Mesh>) {
    let (pose, cutter) = (result.path().pose(t), &result.plan.cutter);
    let normal = result.surface.normal(t, 0.5);
    let back = (normal - pose.axis * normal.dot(pose.axis)).normalize();
    let outwards = back * cutter.half_angle().cos() - pose.axis * cutter.half_angle().sin();
    let tip = pose.tip + height * pose.axis + cutter.radius_at(height) * back + away * outwards;
    let across = pose.axis.cross(back) * 0.01;
    let vertices = vec![tip, tip + 5.0 * outwards + across, tip + 5.0 * outwards - across];
    (tip, Arc::new(Mesh { vertices, triangles: vec![[0, 1, 2]] }))
}

#[test]
fn a_wall_behind_the_cutter_is_gouged_as_deep_as_it_reaches_into_it() {
    const DEPTH: f64 = 0.3;
    let document = quick();
    let mut input = loaded(&document);
    let free = run(&input);
    let unchecked = |r: &FlankResult| r.warnings.iter().any(|w| w.contains("no neighbouring walls were given"));
    assert!(free.gouge.is_none() && unchecked(&free));
    let (tip, wall) = needle(&free, (0.5, 6.0, -DEPTH));
    input.walls = Some(wall);
    let result = run(&input);
    let gouge = check(&result, CheckKind::Gouge);
    assert!(!gouge.holds && !unchecked(&result), "{}", gouge.text);
    let found = result.gouge.unwrap().cutter.unwrap();
    assert!((found.distance_mm + DEPTH).abs() < 0.02 && found.point.distance(tip) < 0.02, "{found:?}");
    assert!((found.t - 0.5).abs() < 0.02 && gouge.t == Some(found.t) && gouge.place == Some(found.point));

    // One that only the way off the surface meets: 3 mm to the side.
    let (tip, wall) = needle(&free, (1.0, 6.0, 2.5));
    input.walls = Some(wall);
    let result = run(&input);
    assert!(check(&result, CheckKind::Gouge).holds);
    let leads = check(&result, CheckKind::Leads);
    assert!(!leads.holds && leads.text.contains("on the retraction the flutes go"), "{}", leads.text);
    let found = result.lead_gouge[1].unwrap().cutter.unwrap();
    let deep = 3.0 * document.cutter.half_angle().cos() - 2.5;
    assert!((found.distance_mm + deep).abs() < 0.02 && found.point.distance(tip) < 0.02, "{found:?} for {deep}");
}

/// A solid whose front is the surface that `at` gives, fine enough for its chords not to matter.
fn solid(at: impl Fn(f64, f64) -> DVec3, back: DVec3) -> Mesh {
    const ALONG: usize = 80;
    const UP: usize = 12;
    let share = |i: usize, n: usize| i as f64 / n as f64;
    let index = |i: usize, j: usize| (i * (UP + 1) + j) as u32;
    let front: Vec<DVec3> = (0..=ALONG)
        .flat_map(|i| (0..=UP).map(move |j| (i, j)))
        .map(|(i, j)| at(share(i, ALONG), share(j, UP)))
        .collect();
    let behind = front.len() as u32;
    let vertices: Vec<DVec3> = front.iter().copied().chain(front.iter().map(|p| *p + back)).collect();
    let mut triangles = Vec::new();
    for (i, j) in (0..ALONG).flat_map(|i| (0..UP).map(move |j| (i, j))) {
        let [a, b, c, d] = [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)];
        triangles.extend([[a, b, c], [a, c, d]]);
        triangles.extend([[a, c, b], [a, d, c]].map(|t| t.map(|v| v + behind)));
    }
    let mut side = |a: u32, b: u32| triangles.extend([[b, a, a + behind], [b, a + behind, b + behind]]);
    (0..ALONG).for_each(|i| side(index(i, 0), index(i + 1, 0)));
    (0..ALONG).for_each(|i| side(index(i + 1, UP), index(i, UP)));
    (0..UP).for_each(|j| side(index(ALONG, j), index(ALONG, j + 1)));
    (0..UP).for_each(|j| side(index(0, j + 1), index(0, j)));
    Mesh { vertices, triangles }
}

#[test]
fn a_flank_of_a_mesh_is_milled_as_the_surface_that_it_was_made_from() {
    let guides = DemonstrationSurface::B.guides().unwrap();
    let surface = RuledSurface::from_guides(&guides.lower, &guides.upper, Side::Positive).unwrap();
    let mesh = solid(|u, v| surface.point(u, v), -8.0 * surface.normal(0.5, 0.5));
    assert!(mesh.is_watertight() && mesh.volume() > 0.0);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("electrode.stl");
    write_stl(&file, &mesh).unwrap();

    let source = MeshFlank { file, units: Units::Mm, ..MeshFlank::default() };
    let document = FlankDocument { source: FlankSource::Mesh(source), ..quick() };
    let mut input = loaded(&document);
    let nc::flank_job::LoadedSurface::Face { candidates, number, .. } = &mut input.surface else {
        panic!("a face of a mesh")
    };
    // The front and the back are equal in area: the front is the one that looks forwards.
    let front = candidates.iter().position(|c| c.is_ruled() && c.outwards.dot(surface.normal(0.5, 0.5)) > 0.5);
    *number = front.unwrap() + 1;
    let result = run(&input);
    let fit = result.fit.as_ref().unwrap();
    assert!(fit.is_ruled && check(&result, CheckKind::Ruled).holds, "{:?}", fit.words);
    let exact = run(&loaded(&FlankDocument { source: demonstration(DemonstrationSurface::B).source, ..quick() }));
    let (found, wanted) = (result.plan.chosen.deviation.rms, exact.plan.chosen.deviation.rms);
    assert!((found / wanted - 1.0).abs() < 0.2, "{found} for {wanted}");
    // The rest of the solid is a wall that counts.
    assert!(result.gouge.is_some() && result.plan.initial.coverage.is_whole);
    // What the surface is off the face counts as much as what the path is off the surface.
    let off_mm = fit.error.greatest_mm;
    let both = [&result.checked.deviation, &result.checked.envelope.deviation];
    let most = both.iter().fold(0.0, |most: f64, d| most.max(-d.most_overcut));
    input.overcut_tolerance_mm = most + result.chordal_deviation_mm + 0.5 * off_mm;
    let deviation = run(&input);
    let deviation = check(&deviation, CheckKind::Deviation);
    assert!(off_mm > 1e-6 && !deviation.holds, "{off_mm} {}", deviation.text);
    let most = most + off_mm + result.chordal_deviation_mm;
    assert!(deviation.text.contains(&format!("overcut up to {most:.4} mm")), "{}", deviation.text);
    // One that there is not.
    let nc::flank_job::LoadedSurface::Face { number, .. } = &mut input.surface else { return };
    *number = 1000;
    let said = flank(&input, &Task::default()).unwrap_err().to_string();
    assert!(said.contains("no flank 1000"), "{said}");
}

/// A turned electrode: a cone frustum that stands on a wider foot.
fn turned() -> Mesh {
    const AROUND: usize = 120;
    let rows = [[14.0, 0.0], [14.0, 5.0], [8.0, 5.0], [5.0, 15.0]];
    let at = |[r, z]: [f64; 2], i: usize| {
        let angle = std::f64::consts::TAU * i as f64 / AROUND as f64;
        DVec3::new(r * angle.cos(), r * angle.sin(), z)
    };
    let mut vertices: Vec<DVec3> = rows.iter().flat_map(|row| (0..AROUND).map(|i| at(*row, i))).collect();
    vertices.extend([DVec3::ZERO, DVec3::new(0.0, 0.0, 15.0)]);
    let n = AROUND as u32;
    let [bottom, top] = [4 * n, 4 * n + 1];
    let mut triangles = Vec::new();
    for (i, j) in (0..n).map(|i| (i, (i + 1) % n)) {
        (0..3).for_each(|k| triangles.extend([[i, j, j + n], [i, j + n, i + n]].map(|t| t.map(|v| v + k * n))));
        triangles.extend([[bottom, j, i], [top, i + 3 * n, j + 3 * n]]);
    }
    Mesh { vertices, triangles }
}

#[test]
fn a_flank_all_around_is_milled_in_one_go_and_back_to_its_start() {
    let mesh = turned();
    assert!(mesh.is_watertight() && mesh.volume() > 0.0);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("turned.stl");
    write_stl(&file, &mesh).unwrap();
    let source = MeshFlank { file, units: Units::Mm, ..MeshFlank::default() };
    let mut document = FlankDocument { source: FlankSource::Mesh(source), ..quick() };
    document.plan.control_points = 40;
    document.plan.locations = 80;
    document.plan.grid = [60, 8];
    // The foot is below: the bottom of the cutter follows its plane.
    document.plan.below_mm = 0.0;
    document.cutter = FlankCutter::cylinder(3.0, 20.0);
    let mut input = loaded(&document);
    input.machine = None;
    let nc::flank_job::LoadedSurface::Face { candidates, number, .. } = &mut input.surface else {
        panic!("a face of a mesh")
    };
    let frustum = candidates.iter().position(|c| c.kind == flank::fit_ruled::CandidateKind::Cone);
    *number = frustum.unwrap() + 1;
    let result = run(&input);
    let fit = result.fit.as_ref().unwrap();
    assert!(fit.is_closed && check(&result, CheckKind::Ruled).holds, "{:?}", fit.words);
    // The bottom leans with the wall: it touches the foot beside the wall and rises from there.
    assert!(result.holds() && result.gouge.is_some_and(|g| g.cutter.is_some()), "{:?}", result.why_blocked());
    let [start, end] = [0.0, 1.0].map(|t| result.path().pose(t));
    assert!(start.tip.distance(end.tip) < 1e-9 && start.axis.distance(end.axis) < 1e-9);
    // Beside the seam it leaves along the normal: further from the axis of the part than on the path.
    let away = |p: DVec3| p.truncate().length();
    assert!(away(result.approach[1].tip) > away(start.tip) + 1.0 && away(result.retract[0].tip) > away(end.tip) + 1.0);
    // The report tells its curves so that they can be had again.
    let entry = &serde_json::to_value(report(&result, &document)).unwrap()["paths"][PathChoice::Chosen as usize];
    let count = entry["control_lower"].as_array().unwrap().len();
    assert!(entry["is_milled"] == true && entry["is_closed"] == true && count >= 40);
    for (i, x) in [(0, 0.0), (3, 0.4), (count - 2, 0.7), (count - 1, 0.9)] {
        let pose = result.path().pose((i as f64 + x) / count as f64);
        let [low, high] = ["control_lower", "control_upper"].map(|key| checks::periodic(&entry[key], (i, x)));
        assert!(low.distance(pose.tip) < 1e-9 && (high - low).normalize().distance(pose.axis) < 1e-9, "{i} {x}");
    }
    // Reaching below, it cuts the foot: deepest where bottom and flute are as near, x beside the wall, x cos(a) deep.
    input.params.below_mm = 0.3;
    let (sin, cos) = 0.3f64.atan().sin_cos();
    let deepest = 0.3 / (1.0 + sin / cos);
    let gouge = run(&input).gouge.unwrap().cutter.unwrap();
    assert!((gouge.distance_mm + deepest).abs() < 0.03, "{gouge:?} {deepest}");
}

#[test]
fn a_flank_that_cannot_be_is_answered_in_words_and_work_that_is_not_wanted_stops() {
    let mut input = loaded(&quick());
    let cancel = Cancel::default();
    cancel.cancel();
    assert!(flank(&input, &Task::silent(&cancel)).unwrap_err().is_cancelled());
    let line = |from: [f64; 3], to: [f64; 3]| GuideCurve::Bezier { points: vec![from.into(), to.into()] };
    input.surface = nc::flank_job::LoadedSurface::Guides {
        lower: line([0.0, 0.0, 0.0], [10.0, 0.0, 0.0]),
        upper: line([5.0, -5.0, 0.0], [5.0, 5.0, 0.0]),
    };
    let said = flank(&input, &Task::default()).unwrap_err().to_string();
    assert!(said.contains("cross or touch"), "{said}");
}

/// A box of this size (mm) as an OBJ file that says no unit.
fn box_without_unit(file: &std::path::Path, [x, y, z]: [f64; 3]) {
    let mut text = String::new();
    for k in 0..8u8 {
        let at = |bit: u8, size: f64| if k & bit == 0 { 0.0 } else { size };
        text += &format!("v {} {} {}\n", at(1, x), at(2, y), at(4, z));
    }
    text += "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    std::fs::write(file, text).unwrap();
}

#[test]
fn a_part_without_a_unit_is_not_milled_in_inches_by_a_guess() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("electrode.obj");
    let read = |size, units| {
        box_without_unit(&file, size);
        let source = FlankSource::Mesh(MeshFlank { file: file.clone(), units, ..MeshFlank::default() });
        load_surface(&source, &Task::default())
    };
    let length = |surface: &nc::flank_job::LoadedSurface| match surface {
        nc::flank_job::LoadedSurface::Face { mesh, .. } => mesh.bounds().size().x,
        other => panic!("{other:?}"),
    };
    // 12 inches would be an ordinary part, 12 mm is an electrode.
    let small = [12.0, 9.0, 1.0];
    let refused = read(small, Units::Auto).unwrap_err().to_string();
    for words in ["electrode.obj", "says no unit", "inches", "--units mm"] {
        assert!(refused.contains(words), "{words}: {refused}");
    }
    for (units, wanted) in [(Units::Mm, 12.0), (Units::Inch, 304.8)] {
        let found = read(small, units).unwrap();
        assert!((length(&found.value) - wanted).abs() < 1e-9 && found.doubts.is_empty(), "{:?}", found.doubts);
    }
    // Millimetres are the custom, but 40 inches are not beyond belief.
    let usual = read([40.0, 9.0, 9.0], Units::Auto).unwrap();
    assert!((length(&usual.value) - 40.0).abs() < 1e-9);
    assert!(
        usual.doubts.len() == 1 && usual.doubts[0].contains("electrode.obj: The unit is a guess"),
        "{:?}",
        usual.doubts
    );
    assert!(read([80.0, 9.0, 9.0], Units::Auto).unwrap().doubts.is_empty());
}

#[test]
fn walls_without_a_unit_are_in_that_of_the_surface_and_every_reader_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("walls.obj");
    box_without_unit(&file, [3.0, 2.0, 1.0]);
    let walls = |units| Some(WallsFile { file: file.clone(), units });
    let length = |input: &FlankInput| input.walls.as_ref().unwrap().bounds().size().x;
    // Guides are in mm.
    let document = FlankDocument { walls: walls(Units::Auto), ..quick() };
    let input = loaded(&document);
    assert!((length(&input) - 3.0).abs() < 1e-9, "{}", length(&input));
    let given = loaded(&FlankDocument { walls: walls(Units::Inch), ..quick() });
    assert!((length(&given) - 76.2).abs() < 1e-9 && given.doubts.is_empty(), "{:?}", given.doubts);
    let result = run(&input);
    let said = "walls.obj: The unit is a guess: millimetres";
    assert!(result.all_warnings().iter().any(|w| w.contains(said)), "{:?}", result.all_warnings());
    let passed = let_pass(&result);
    let approved = ApprovedFlank::new(&passed).unwrap();
    let cl = cl_text(&approved).unwrap();
    assert!(cl.contains("WARNING: walls.obj: The unit is a guess"), "{cl}");
    let nc = FlankNc::new(&approved, "flank").unwrap().text;
    assert!(nc.to_lowercase().contains("walls.obj: the unit is a guess"), "{nc}");
    let report = report(&result, &document);
    assert!(report.json().unwrap().contains(said) && report.warnings.iter().any(|w| w.contains(said)));

    // Of a part in inches they are in inches.
    let part = folder.path().join("part.obj");
    box_without_unit(&part, [4.0, 3.0, 2.0]);
    let source = FlankSource::Mesh(MeshFlank { file: part, units: Units::Inch, ..MeshFlank::default() });
    let input = loaded(&FlankDocument { source, walls: walls(Units::Auto), ..quick() });
    assert!((length(&input) - 76.2).abs() < 1e-9);
}
