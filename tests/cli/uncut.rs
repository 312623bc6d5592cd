//! Molds from the command line.

use std::f64::consts::PI;
use std::path::Path;

use geometry::mesh::Mesh;
use glam::DVec3;
use import::write_stl;
use mold::fixtures::{self, rectangle};

use super::{sparkpath, text};

/// A block of 20 x 20 x 10 mm with its top at 0 and a pocket of 8 x 6 x 4 mm.
pub(super) fn pocket() -> Mesh {
    let hole = rectangle(8.0, 6.0);
    fixtures::pocket(&rectangle(20.0, 20.0), &hole, &hole, [10.0, 4.0]).mapped(|p| p - 10.0 * DVec3::Z)
}

fn answer(file: &Path, arguments: &[&str]) -> (Option<i32>, serde_json::Value) {
    let file = file.to_str().unwrap();
    let output = sparkpath(&[&["uncut", file, "--json", "--units", "mm"], arguments].concat());
    let json = serde_json::from_slice(&output.stdout).unwrap_or_default();
    (output.status.code(), json)
}

#[test]
fn the_corners_of_a_pocket_are_left_whichever_way_it_opens() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("mold.stl");
    let mesh = pocket();
    assert!(mesh.is_watertight() && mesh.volume() > 0.0);
    let exact = 4.0 * (1.0 - PI / 4.0) * 4.0;
    for (opening, turned) in [("+z", mesh.clone()), ("-x", mesh.mapped(|p| DVec3::new(-p.z, p.y, p.x)))] {
        write_stl(&file, &turned).unwrap();
        let out = folder.path().join("out");
        let flat = ["--cutters", "flat:1", "--opening", opening, "--out", out.to_str().unwrap()];
        let (code, json) = answer(&file, &flat);
        assert_eq!(code, Some(0), "{json}");
        let left = &json["uncut"];
        assert_eq!(left["regions"].as_array().unwrap().len(), 4);
        let [layers, field] = ["layers", "field"].map(|way| left["agreement"][way]["volume_mm3"].as_f64().unwrap());
        assert!((layers / exact - 1.0).abs() < 1e-3 && (field / exact - 1.0).abs() < 0.03, "{layers} {field} {exact}");
        assert!(std::fs::read(out.join("uncut.ply")).unwrap().starts_with(b"ply\n"));
        let said = std::fs::read_to_string(out.join("uncut.txt")).unwrap();
        assert!(said.starts_with("The cutters leave 4 regions of 3.43"), "{said}");
    }
}

#[test]
fn segments_page_and_other_cutters_are_written_and_no_time_is_in_files_for_programs() {
    let folder = tempfile::tempdir().unwrap();
    let (file, other) = (folder.path().join("mold.stl"), folder.path().join("other.toml"));
    write_stl(&file, &pocket()).unwrap();
    std::fs::write(&other, "[[cutter]]\ndiameter_mm = 1.0\n").unwrap();
    let run = |out: &str, more: &[&str]| {
        let out = folder.path().join(out);
        let to = ["--cutters", "flat:1", "--no-pictures", "--out", out.to_str().unwrap()];
        let (code, json) = answer(&file, &[&to, more].concat());
        assert_eq!(code, Some(0), "{json}");
        let read = |name: &str| std::fs::read_to_string(out.join(name)).unwrap();
        (json, ["uncut.json", "uncut.txt", "uncut_segments.csv", "uncut.html"].map(read))
    };
    let (plain, [figures, words, segments, page]) = run("plain", &[]);
    let runs: Vec<&str> = segments.lines().filter(|line| !line.starts_with('#')).collect();
    assert_eq!(runs[0], "layer,height_mm,region,length_mm,points_mm,interference");
    assert!(runs[1..].iter().all(|run| run.ends_with(",local")), "corners of one pocket: {segments}");
    let lowest = runs[1].split(',').next().unwrap();
    let of_layer = runs.iter().filter(|run| run.split(',').next() == Some(lowest)).count();
    assert_eq!(of_layer, 4, "a run in each corner: {segments}");
    for text in ["Uncut detection", "height map, layers, surface", "mold.stl", "flat D2 (R1)"] {
        assert!(page.contains(text), "{text}");
    }
    assert!(plain.get("comparison").is_none() && !page.contains("Other cutters"));
    let ways = [["--compare", "flat:0.5"], ["--compare-library", other.to_str().unwrap()]];
    let [given, listed] = ways.map(|more| run(more[0], &more));
    assert!(given == listed || given.1[..3] == listed.1[..3], "the same however it is given");
    let comparison = &given.0["comparison"];
    assert_eq!((comparison["regions"][1].as_u64(), comparison["taken"].as_array().unwrap().len()), (Some(4), 4));
    let left = comparison["volumes_mm3"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect::<Vec<_>>();
    assert!((left[0] / left[1] - 4.0).abs() < 1e-3, "a corner is as the square of the radius: {left:?}");
    assert!(given.1[1].contains("less is left") && given.1[3].contains("Other cutters"), "{}", given.1[1]);
    let again = run("plain", &[]).1;
    assert_eq!([&again[0], &again[1], &again[2]], [&figures, &words, &segments]);
    let wrong = sparkpath(&["uncut", file.to_str().unwrap(), "--compare", "flat:0"]);
    assert!(wrong.status.code() == Some(2) && text(&wrong.stderr).contains("radius is 0: must"));
}

#[test]
fn a_folder_of_molds_is_one_table_and_one_that_fails_keeps_no_other_back() {
    let folder = tempfile::tempdir().unwrap();
    let (molds, out) = (folder.path().join("molds"), folder.path().join("out"));
    std::fs::create_dir(&molds).unwrap();
    assert_eq!(answer(&molds, &[]).0, Some(2), "no mesh in it");
    write_stl(&molds.join("b.stl"), &pocket()).unwrap();
    write_stl(&molds.join("a.STL"), &pocket()).unwrap();
    std::fs::write(molds.join("notes.txt"), "no mesh").unwrap();
    let flat = ["--cutters", "flat:1", "--out", out.to_str().unwrap()];
    let (code, json) = answer(&molds, &flat);
    assert_eq!(code, Some(0), "{json}");
    std::fs::write(molds.join("c.obj"), "no mesh").unwrap();
    let (code, json) = answer(&molds, &flat);
    assert_eq!(code, Some(3), "{json}");
    let rows = json["rows"].as_array().unwrap();
    let names: Vec<&str> = rows.iter().map(|row| row["file"].as_str().unwrap()).collect();
    assert_eq!(names, ["a.STL", "b.stl", "c.obj"]);
    let exact = 4.0 * (1.0 - PI / 4.0) * 4.0;
    for row in &rows[..2] {
        let figures = &row["figures"];
        assert_eq!((figures["triangles"].as_u64(), figures["regions"].as_u64()), (Some(28), Some(4)), "{row}");
        assert!((figures["volume_mm3"].as_f64().unwrap() / exact - 1.0).abs() < 1e-3, "{row}");
        assert_eq!(figures["hidden_area_mm2"].as_f64(), Some(0.0));
    }
    assert!(rows[2]["figures"].is_null() && rows[2]["reason"].as_str().unwrap().contains("c.obj"), "{}", rows[2]);
    let csv = std::fs::read_to_string(out.join("corpus.csv")).unwrap();
    assert!(csv.lines().count() == 4 && csv.contains("a.STL,28,4,3.43"), "{csv}");
    assert!(std::fs::read_to_string(out.join("corpus.html")).unwrap().contains("c.obj"));
    for wrong in [["--cutters", "flat:0"], ["--compare", "flat:0.5"], ["--mesh", "b.stl"]] {
        assert_eq!(answer(&molds, &wrong).0, Some(2), "{wrong:?}");
    }
}

#[test]
fn a_ball_leaves_the_edges_of_a_floor_and_both_together_the_corners() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("mold.stl");
    write_stl(&file, &pocket()).unwrap();
    let regions = |cutters: &str| answer(&file, &["--cutters", cutters]).1["uncut"]["regions"].clone();
    let ball = regions("ball:1");
    assert_eq!(ball.as_array().unwrap().len(), 1);
    // Fillets along the straight edges of the floor, the columns in the corners above them, and what an eighth of the
    // ball leaves of a cube in each corner between.
    let fillet = 1.0 - PI / 4.0;
    let exact = fillet * (2.0 * (6.0 + 4.0) + 4.0 * 3.0) + 4.0 * (1.0 - PI / 6.0);
    let volume = ball[0]["volume_mm3"].as_f64().unwrap();
    assert!((volume / exact - 1.0).abs() < 0.02, "{volume} {exact}");
    assert_eq!(regions("flat:1,ball:1").as_array().unwrap().len(), 4);
}

#[test]
fn wrong_questions_are_answered_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("mold.stl");
    let mut open = pocket();
    // Without the walls of the pocket.
    open.triangles.truncate(20);
    write_stl(&file, &open).unwrap();
    let (code, json) = answer(&file, &["--cutters", "flat:1"]);
    assert_eq!(code, Some(3));
    let said = json["uncut"]["sentence"].as_str().unwrap();
    assert!(
        said.contains("the rest material may be larger") && !json["uncut"]["warnings"].as_array().unwrap().is_empty(),
        "{said}"
    );
    for (arguments, words) in [
        (["--cutters", "flat:0"], "radius is 0: must"),
        (["--cutters", "cone:1"], "is no cutter"),
        (["--opening", "up"], "expected +x"),
        (["--opening", "0,0,0"], "or auto"),
        (["--datum", "1,2"], "expected 3 numbers"),
        (["--datum-angle", "400"], "datum.angle_deg is 400"),
        (["--tolerance", "-1"], "expected a length in mm from 0.0001 to 10"),
        (["--tolerance", "abc"], "expected a length in mm from 0.0001 to 10"),
        (["--layers", "0"], "expected a length in mm from 0.000001"),
        (["--step", "5"], "grid_step_mm is 5: must be from 0.000001 to 0.25 mm"),
        (["--library", "nowhere.toml"], "cannot be read"),
    ] {
        let output = sparkpath(&[&["uncut", file.to_str().unwrap()], &arguments[..]].concat());
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?} {error}");
        let said: Vec<&str> = error.lines().filter(|line| line.contains("rror") || line.contains(words)).collect();
        assert!(said.len() == 1 && said[0].contains(words), "{arguments:?} {error}");
    }
}

#[test]
fn what_looks_away_from_the_cutters_is_not_reached_and_is_no_hole_in_the_floor() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("mold.stl");
    write_stl(&file, &pocket()).unwrap();
    let (code, json) = answer(&file, &["--cutters", "flat:1", "--opening", "-z"]);
    let found = &json["uncut"];
    assert_eq!(code, Some(3), "{found}");
    assert_eq!(found["sentence"], "The cutters reach everything but 2 undercut faces of 48.00 mm2.");
    // The floor looks away, and the walls lie under it.
    let warnings = found["warnings"].as_array().unwrap();
    let hidden = warnings[0].as_str().unwrap();
    assert!(found["is_whole"] == false && warnings.len() == 1, "{found}");
    assert!(hidden.contains("of 160.0 mm^2 of the part's inner faces (100 %)"), "{hidden}");
}

#[test]
fn the_opening_direction_is_proposed_where_none_is_given() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let [file, project] = ["mold.stl", "mold.sparkpath"].map(path);
    write_stl(Path::new(&file), &pocket().mapped(|p| DVec3::new(-p.z, p.y, p.x))).unwrap();
    let asked = ["--units", "mm", "--cutters", "flat:1"];
    let said = |output: &std::process::Output| (text(&output.stdout), text(&output.stderr));
    let (found, note) = said(&sparkpath(&[&["uncut", &file, "--save", &project], &asked[..]].concat()));
    assert!(found.starts_with("The cutters leave 4 regions of 3.43"), "{found}");
    assert!(note.contains("opening direction -x: 0.0 mm2 of faces look away") && note.contains("next best "), "{note}");
    // It is written in the project, and no longer proposed.
    assert!(std::fs::read_to_string(&project).unwrap().contains("opening = \"-x\""));
    let (again, note) = said(&sparkpath(&["uncut", &project]));
    assert!(again == found && !note.contains("opening"), "{note}");
    let (_, note) = said(&sparkpath(&["uncut", &project, "--opening", "auto"]));
    assert!(note.contains("opening direction -x: "), "{note}");
    // The same along a vector that is hardly off it.
    let (along, _) = said(&sparkpath(&[&["uncut", &file, "--opening", "-1,0,1e-9"], &asked[..]].concat()));
    assert!(along.starts_with("The cutters leave 4 regions of 3.43"), "{along}");
}

#[test]
fn what_is_dropped_for_another_mesh_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let [mesh, project, picture] = ["mold.stl", "mold.sparkpath", "mold.png"].map(path);
    let turned = pocket().mapped(|p| DVec3::new(-p.z, p.y, p.x));
    write_stl(Path::new(&mesh), &turned).unwrap();
    let datum = ["--datum", "1,-2,0.5", "--datum-angle", "-90"];
    let asked = [&["--units", "mm", "--cutters", "flat:1", "--opening", "+x", "--save", &project][..], &datum].concat();
    let first = sparkpath(&[&["uncut", &mesh], &asked[..]].concat());
    assert!(!text(&first.stderr).contains("dropped"), "{}", text(&first.stderr));
    let mut params =
        files::Document::<sparkpath::workspaces::mold::document::MoldParams>::open(project.as_ref()).unwrap();
    params.amend(true, |params| params.electrodes.overrides.push("E01:gouge".parse().unwrap()));
    params.export(project.as_ref()).unwrap();
    write_stl(Path::new(&mesh), &turned.mapped(|p| p * 1.01)).unwrap();
    for command in [&["uncut", &project][..], &["electrodes", &project], &["render", &project, "--png", &picture]] {
        let said = text(&sparkpath(command).stderr);
        assert!(
            said.contains("dropped: opening direction +x (now -x), work datum given, 1 override;"),
            "{command:?}: {said}"
        );
    }
    let kept =
        text(&sparkpath(&["uncut", &project, "--opening", "+x", "--datum", "1,-2,0.5", "--datum-angle", "-90"]).stderr);
    assert!(kept.contains("dropped: 1 override;"), "direction and datum are given anew: {kept}");
}

#[test]
fn a_guessed_unit_is_told_by_every_command_and_in_its_sheets() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let [mesh, out] = ["mold.stl", "out"].map(path);
    write_stl(Path::new(&mesh), &pocket()).unwrap();
    // What is written here names its unit in the head.
    let mut bytes = std::fs::read(&mesh).unwrap();
    bytes[..80].fill(b' ');
    std::fs::write(&mesh, bytes).unwrap();
    let mold = [&mesh, "--cutters", "flat:1", "--out", &out];
    let guess = "The unit is a guess: millimetres because";
    for (command, sheet) in [("uncut", "uncut.txt"), ("electrodes", "burn_sheet.txt")] {
        let output =
            sparkpath(&[&[command], &mold[..], &["--no-pictures"][..usize::from(command == "electrodes")]].concat());
        assert!(text(&output.stderr).contains(guess), "{command}");
        assert!(std::fs::read_to_string(Path::new(&out).join(sheet)).unwrap().contains(guess), "{sheet}");
    }
    for command in [&["plan", &mesh, "--out", &out][..], &["flank", "--mesh", &mesh, "--list"]] {
        let said = text(&sparkpath(command).stderr);
        assert!(said.contains(guess), "{command:?}: {said}");
    }
    let inspected = text(&sparkpath(&["inspect", &mesh]).stdout);
    assert_eq!(inspected.matches("because").count(), 1, "{inspected}");
    assert!(inspected.contains("binary STL") && inspected.contains("unit         millimetres\n"), "{inspected}");
}

/// Projects and reports are text, and could not name such a file.
#[cfg(target_os = "linux")]
#[test]
fn a_name_that_is_no_text_is_refused_with_the_way_out() {
    use std::os::unix::ffi::OsStrExt;
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join(std::ffi::OsStr::from_bytes(b"schl\xfcssel.stl"));
    write_stl(&file, &pocket()).unwrap();
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_sparkpath"))
        .args(["uncut".as_ref(), file.as_os_str(), "--cutters".as_ref(), "flat:1".as_ref()])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    let said = text(&output.stderr);
    assert!(said.contains("UTF-8") && said.contains("rename the file"), "{said}");
}
