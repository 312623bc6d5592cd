//! Electrodes from the command line.

use geometry::mesh::Mesh;
use glam::DVec3;
use import::write_stl;

use super::uncut::pocket;
use super::{sparkpath, text};

fn said(output: &std::process::Output) -> (Option<i32>, String) {
    (output.status.code(), text(&output.stdout) + &text(&output.stderr))
}

#[test]
fn a_pocket_gets_one_electrode_that_burns_its_four_corners() {
    let folder = tempfile::tempdir().unwrap();
    let (file, out) = (folder.path().join("mold.stl"), folder.path().join("out"));
    write_stl(&file, &pocket()).unwrap();
    let [mold, out_text] = [&file, &out].map(|p| p.to_str().unwrap().to_owned());
    let base = ["electrodes", &mold, "--units", "mm", "--cutters", "flat:1", "--no-pictures"];
    let (code, words) = said(&sparkpath(&[&base[..], &["--out", &out_text, "--formats", "stl,obj,glb"]].concat()));
    assert_eq!(code, Some(0), "{words}");
    assert!(words.contains("1 electrode with 4 burns") && words.contains("E01: 4 burns"), "{words}");
    assert!(words.contains("holder 15, ") && !words.contains("nothing was written"), "{words}");
    let table = std::fs::read_to_string(out.join("burn_table.csv")).unwrap();
    assert_eq!(table.lines().count(), 5, "a head and four burns: {table}");
    for name in ["burn_table.json", "burn_sheet.txt", "report.html", "electrodes.json"] {
        assert!(out.join(name).metadata().unwrap().len() > 200, "{name}");
    }
    for end in ["stl", "obj", "glb"] {
        assert!(out.join(format!("E01_finish_g0.05_copper_x1.{end}")).exists(), "{end}");
    }
    // The middle of the base stands off the corner, turned with it: the four burns lie symmetrically.
    let rows = table.lines().skip(1).map(|l| l.split(',').map(str::to_owned).collect::<Vec<_>>());
    let sum =
        rows.fold([0.0, 0.0], |[x, y], row| [x + row[2].parse::<f64>().unwrap(), y + row[3].parse::<f64>().unwrap()]);
    assert!(sum.iter().all(|v| v.abs() < 1e-3), "{sum:?}");
}

/// The same files of electrodes to the last byte, and positions that differ by the datum.
#[test]
fn a_work_datum_changes_positions_and_no_electrode() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("mold.stl");
    write_stl(&file, &pocket()).unwrap();
    let mold = file.to_str().unwrap();
    let made = |name: &str, more: &[&str]| {
        let out = folder.path().join(name);
        let base = ["electrodes", mold, "--units", "mm", "--cutters", "flat:1", "--no-pictures", "--out"];
        let (code, words) = said(&sparkpath(&[&base[..], &[out.to_str().unwrap()], more].concat()));
        assert_eq!(code, Some(0), "{words}");
        let read = |name: &str| std::fs::read(out.join(name)).unwrap();
        let table: serde_json::Value = serde_json::from_slice(&read("burn_table.json")).unwrap();
        (read("E01_finish_g0.05_copper_x1.stl"), table, String::from_utf8(read("burn_sheet.txt")).unwrap(), words)
    };
    let (plain, from_mesh, ..) = made("plain", &[]);
    let datum = ["--datum", "10,-4,0.5", "--datum-angle", "90"];
    let ball = ["--set", "setup.datum=[{ x_mm = 30.0, y_mm = 7.0, z_mm = 6.0, radius_mm = 4.0 }]"];
    let (same, from_datum, sheet, words) = made("datum", &[&datum[..], &ball].concat());
    assert!(plain == same, "the electrode is the same to the last byte");
    assert!(sheet.contains("Datum: given, at X 10.0000 Y -4.0000 Z 0.5000 of the mold's file."), "{sheet}");
    assert!(words.contains("work datum: given, at (10, -4, 0.5) of the file, turned by 90 deg"), "{words}");
    // The ball is (20, 11, 5.5) away from the datum. Its sheet is the one that the command makes of the job.
    assert!(!folder.path().join("plain/setup_sheet.txt").exists(), "without a datum");
    let set_up = std::fs::read_to_string(folder.path().join("datum/setup_sheet.txt")).unwrap();
    let line = set_up.lines().find_map(|line| line.trim_start().strip_prefix("in the axes of the job")).unwrap();
    assert_eq!(line.split_whitespace().collect::<Vec<_>>(), ["11.0000", "-20.0000", "5.5000"], "{set_up}");
    let job = folder.path().join("datum/job.json");
    let made_of_job = sparkpath(&["setup-sheet", job.to_str().unwrap(), "--ball", "30,7,6,4"]);
    assert_eq!(text(&made_of_job.stdout).trim_end(), set_up.trim_end());
    let burns = |table: &serde_json::Value| table["electrodes"][0]["burns"].as_array().unwrap().clone();
    let figure = |burn: &serde_json::Value, key: &str| burn[key].as_f64().unwrap();
    assert_eq!(burns(&from_mesh).len(), 4);
    for (a, b) in burns(&from_mesh).iter().zip(&burns(&from_datum)) {
        // X of the datum is Y of the file, and Y against its X.
        let [x, y, z] = ["x_mm", "y_mm", "z_mm"].map(|key| figure(a, key));
        let found = ["x_mm", "y_mm", "z_mm"].map(|key| figure(b, key));
        let expected = [y + 4.0, 10.0 - x, z - 0.5];
        assert!(found.iter().zip(expected).all(|(f, e)| (f - e).abs() < 2e-4), "{found:?} {expected:?}");
        let turned = (figure(a, "c_deg") - figure(b, "c_deg")).rem_euclid(360.0);
        assert!((turned - 90.0).abs() < 1e-3, "{turned}");
        assert_eq!(a["depth_mm"], b["depth_mm"]);
    }
}

#[test]
fn ways_of_dividing_are_compared() {
    let folder = tempfile::tempdir().unwrap();
    let (file, out) = (folder.path().join("mold.stl"), folder.path().join("out"));
    write_stl(&file, &pocket()).unwrap();
    let [mold, out_text] = [&file, &out].map(|p| p.to_str().unwrap().to_owned());
    let base = ["electrodes", &mold, "--units", "mm", "--cutters", "flat:1", "--no-pictures", "--out", &out_text];
    let (code, words) = said(&sparkpath(&[&base[..], &["--compare-divisions"]].concat()));
    assert_eq!(code, Some(0), "{words}");
    let rows: Vec<Vec<&str>> = words
        .lines()
        .skip_while(|line| !line.starts_with("divided at"))
        .skip(1)
        .map(|line| line.split("  ").map(str::trim).filter(|cell| !cell.is_empty()).collect())
        .collect();
    let names: Vec<&str> = rows.iter().take(4).map(|row| row[0]).collect();
    assert_eq!(names, ["undivided", "whole faces", "every inner edge", "H-edges (own)"], "{words}");
    assert_eq!((rows[1][1], rows[3][1]), ("1", "4"), "faces of four corners are those of one region: {words}");
    let json: serde_json::Value = serde_json::from_slice(&std::fs::read(out.join("electrodes.json")).unwrap()).unwrap();
    assert_eq!(json["divisions"][3]["is_own"], true);
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    for text in ["Ways of dividing", "every inner edge of whole faces", "Refinement: reuse and shared bases"] {
        assert!(page.contains(text), "{text}");
    }
}

#[test]
fn what_cannot_be_made_is_answered_in_words_and_what_fails_is_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let (file, out) = (folder.path().join("mold.stl"), folder.path().join("out"));
    let [mold, out_text] = [&file, &out].map(|p| p.to_str().unwrap().to_owned());
    let run = |more: &[&str]| {
        let base = ["electrodes", &mold, "--units", "mm", "--cutters", "flat:1", "--no-pictures", "--out", &out_text];
        said(&sparkpath(&[&base[..], more].concat()))
    };
    let open = Mesh { triangles: pocket().triangles[1..].to_vec(), ..pocket() };
    write_stl(&file, &open).unwrap();
    let (code, words) = run(&[]);
    assert!(code != Some(0) && (words.contains("open edges") || words.contains("closed")), "{words}");
    // A slot that a large cutter cannot enter, on the base of the electrode: nothing of the tip can be milled with a ball alone.
    write_stl(&file, &pocket().mapped(|p| p + DVec3::X)).unwrap();
    let (code, words) = run(&["--electrode-cutters", "ball:3"]);
    assert!(code == Some(3) && words.contains("machinable fails") && words.contains("E01 was not written"), "{words}");
    assert!(!out.join("E01_finish_g0.05_copper_x1.stl").exists());
    let (code, words) = run(&["--electrode-cutters", "ball:3", "--override", "E01:gouge"]);
    assert!(
        code == Some(3) && words.contains("E01 was not written") && words.contains("override E01:gouge: the check"),
        "{words}"
    );
    let (code, words) = run(&["--electrode-cutters", "ball:3", "--override", "E01:machinable"]);
    assert!(code == Some(3) && out.join("E01_finish_g0.05_copper_x1.stl").exists(), "{words}");
    let (code, words) = run(&["--gap", "-1"]);
    assert!(code == Some(2) && words.contains("--gap <MM>") && words.contains("from 0 to 5"), "{words}");
    let (code, words) = run(&["--override", "E99:leftover"]);
    assert!(code == Some(2) && words.contains("there is no electrode E99; there is E01"), "{words}");
}

#[test]
fn what_is_wrong_with_files_and_words_is_answered_before_any_work() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    // A mold that is none: what is answered of it would come after the files.
    let [mold, file, template, params] = ["mold.stl", "file", "mine.jinja", "wrong.sparkpath"].map(path);
    [&mold, &file].into_iter().for_each(|f| std::fs::write(f, "none").unwrap());
    std::fs::write(&template, "{{ mold }}\n{% for e in electrodes %}{{ e.naem }}{% endfor %}").unwrap();
    std::fs::write(&params, "kind = \"mold\"\n[electrodes]\noverrides = [\"E01:gouges\"]").unwrap();
    let (deep, out, none) = (format!("{file}/out"), path("out"), path("none.jinja"));
    for (more, words) in [
        (["--template", &template], &["mine.jinja: line 2: ", "e.naem"][..]),
        (["--template", &none], &["none.jinja", "cannot be read"]),
        (["--out", &file], &["file"]),
        (["--out", &deep], &["file/out"]),
        (["--override", "E01:gouges"], &["gouges", "watertight, gouge"]),
        (["--electrode-cutters", "ball:-1"], &["ball:-1", "radius is -1: must"]),
        (["--out", &out], &["mold.stl"]),
    ] {
        let (code, said) = said(&sparkpath(&[&["electrodes", &mold, "--units", "mm"], &more[..]].concat()));
        assert!(code == Some(2) && words.iter().all(|w| said.contains(w)), "{more:?}: {said}");
    }
    let (code, words) = said(&sparkpath(&["electrodes", &params]));
    assert!(
        code == Some(2) && words.contains("wrong.sparkpath: line 3") && words.contains("watertight, gouge"),
        "{words}"
    );
    // The lists in a user's settings are read, those of suppliers too; settings lie there on Linux.
    #[cfg(target_os = "linux")]
    {
        let suppliers = folder.path().join("sparkpath/holders");
        std::fs::create_dir_all(&suppliers).unwrap();
        std::fs::write(suppliers.join("Acme.toml"), "[[holder]]\nname = \"a\"\nsize = 3\n").unwrap();
        let (code, said) = said(&super::sparkpath_with(folder.path().to_str().unwrap(), &["electrodes", &mold]));
        assert!(code == Some(2) && said.contains("Acme.toml: line 3") && said.contains("`size`"), "{said}");
    }
    assert!(!std::path::Path::new(&out).exists(), "a folder that was made for nothing goes again");
}

#[test]
fn a_project_is_asked_like_its_mesh_with_options_and_options_come_first() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let [mesh, project, out, saved] = ["mold.stl", "pocket.sparkpath", "out", "saved.sparkpath"].map(path);
    write_stl(std::path::Path::new(&mesh), &pocket()).unwrap();
    let text = "kind = \"mold\"\nmesh = \"mold.stl\"\nunits = \"mm\"\n[[library.cutter]]\ndiameter_mm = 2.0\n\
                [[electrodes.stages]]\nname = \"fine\"\ngap_mm = 0.1\n";
    std::fs::write(&project, text).unwrap();
    let table = |arguments: &[&str]| {
        let (code, words) = said(&sparkpath(&[arguments, &["--no-pictures", "--out", &out]].concat()));
        assert_eq!(code, Some(0), "{words}");
        std::fs::read_to_string(std::path::Path::new(&out).join("burn_table.csv")).unwrap()
    };
    let of_project = table(&["electrodes", &project, "--save", &saved]);
    assert!(of_project.contains("fine"), "{of_project}");
    // What was asked is a project of its own, with the part that its decisions are for.
    assert_eq!(table(&["electrodes", &saved]), of_project);
    let params = files::Document::<sparkpath::workspaces::mold::document::MoldParams>::open(saved.as_ref()).unwrap();
    assert!(params.params().part.is_some() && params.params().electrodes.stages[0].gap_mm == 0.1);
    let wide = table(&["electrodes", &project, "--gap", "0.2"]);
    assert!(wide != of_project && wide.contains("0.2"), "{wide}");
    // The same settings for another mesh.
    let [other, standard] = ["other.stl", "standard.sparkpath"].map(path);
    std::fs::rename(&mesh, &other).unwrap();
    std::fs::write(&standard, text.replace("mesh = \"mold.stl\"\n", "")).unwrap();
    assert_eq!(table(&["electrodes", &standard, "--mesh", &other]), of_project.replace("mold.stl", "other.stl"));
    let (code, words) = said(&sparkpath(&["uncut", &standard]));
    assert!(code == Some(2) && words.contains("mesh is missing; give one with --mesh"), "{words}");
    std::fs::write(&standard, "kind = \"flank\"").unwrap();
    for command in ["uncut", "electrodes"] {
        let (code, words) = said(&sparkpath(&[command, &standard]));
        assert!(
            code == Some(2)
                && words.contains("line 1: kind is \"flank\": must be \"mold\" here; one of a flank is for flank"),
            "{words}"
        );
    }
}

#[test]
fn regions_with_nothing_to_burn_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let mold = "tests/data/molds/a_square.stl";
    let base = ["electrodes", mold, "--units", "mm", "--no-pictures", "--out", out.to_str().unwrap()];
    let (code, words) = said(&sparkpath(&[&base[..], &["--cutters", "flat:0.05"]].concat()));
    assert!(code == Some(0) && !words.contains("Every check holds"), "{words}");
    assert!(words.contains("Regions left out, as within the tolerance there is nothing to burn: 1, 2, 3"), "{words}");
    assert!(words.contains("region 1 has no electrode: finish stage: there is nothing to burn"), "{words}");
    let sheet = std::fs::read_to_string(out.join("burn_sheet.txt")).unwrap();
    assert!(sheet.contains("REGION 12 IS NOT BURNED") && sheet.contains("there is nothing to burn"), "{sheet}");
}
