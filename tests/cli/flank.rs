//! Flanks from the command line.

use std::path::Path;

use files::Document;
use files::Override;
use flank::params::Objective;
use flank::ruled_surface::Side;
use geometry::mesh::Mesh;
use glam::DVec3;
use import::{Units, write_stl};
use mold::cutter::{Cutter, CutterLibrary};
use sparkpath::workspaces::flank::document::{CutDirection, FlankDocument, FlankSource, WallsFile};
use sparkpath::workspaces::mold::document::MoldParams;

use super::uncut::pocket;
use super::{sparkpath, sparkpath_with, text};

/// Coarse and unrefined is quick.
const QUICK: [&str; 6] = ["--grid", "30x12", "--path", "chosen", "--objective", "rms"];

fn run(arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = sparkpath(&[&["flank"], arguments, &QUICK[..]].concat());
    let said = text(&output.stderr);
    let last = said.lines().last().unwrap_or_default().to_owned();
    (output.status.code(), text(&output.stdout), last)
}

fn file(folder: &Path, name: &str, content: &str) -> String {
    let file = folder.join(name);
    std::fs::write(&file, content).unwrap();
    file.to_str().unwrap().to_owned()
}

fn opened(file: impl AsRef<Path>) -> FlankDocument {
    Document::<FlankDocument>::open(file.as_ref()).unwrap().params().clone()
}

#[test]
fn a_demonstration_is_planned_written_and_the_same_again_from_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let [out, again, save] = ["out", "again", "a.sparkpath"].map(|name| folder.path().join(name));
    let [out_name, again_name, save_name] = [&out, &again, &save].map(|p| p.to_str().unwrap());
    let (code, said, _) = run(&["--demo", "a", "--out", out_name, "--save", save_name]);
    assert_eq!(code, Some(0), "{said}");
    for words in [
        "The chosen path has a total absolute deviation",
        "30 x 12 samples",
        "Every check holds",
        "check machine: holds",
        "planned",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
    let json: serde_json::Value = serde_json::from_slice(&std::fs::read(out.join("flank.json")).unwrap()).unwrap();
    assert_eq!((&json["holds"], &json["grid"]), (&true.into(), &serde_json::json!([30, 12])));
    assert!(json["paths"][1]["ratio"].as_f64().unwrap() < 0.75);
    // From the saved file, on one thread and as JSON.
    let output = sparkpath(&["flank", "--threads", "1", "--json", save_name, "--out", again_name]);
    assert_eq!(output.status.code(), Some(0));
    for name in ["flank.json", "flank.cl", "flank.ngc", "path.csv", "report.html"] {
        assert!(std::fs::read(out.join(name)).unwrap() == std::fs::read(again.join(name)).unwrap(), "{name}");
    }
    assert_eq!(output.stdout, [std::fs::read(again.join("flank.json")).unwrap(), b"\n".to_vec()].concat());
}

#[test]
fn a_sweep_is_told_beside_the_plan_in_words_table_and_report() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let (code, said, _) = run(&["--demo", "a", "--sweep", "taper:2:8:3", "--out", out.to_str().unwrap()]);
    assert_eq!(code, Some(0), "{said}");
    assert_eq!(said.lines().filter(|line| line.starts_with("with ")).count(), 3, "{said}");
    let json: serde_json::Value = serde_json::from_slice(&std::fs::read(out.join("flank.json")).unwrap()).unwrap();
    let rows = json["compared"].as_array().unwrap();
    let of = |key: &str| rows.iter().map(|row| row["cutter"][key].as_f64().unwrap()).collect::<Vec<_>>();
    assert_eq!((of("taper_deg"), of("radius_mm")), (vec![2.0, 5.0, 8.0], vec![1.0; 3]));
    // The second has the plan's own taper.
    let mean = |row: usize| rows[row]["figures"]["Ok"]["mean_mm"].as_f64().unwrap();
    assert_eq!(mean(1), json["paths"][1]["standing"]["mean_absolute_mm"].as_f64().unwrap());
    assert!(mean(0) != mean(1) && mean(1) != mean(2));
    let table = std::fs::read_to_string(out.join("compared.csv")).unwrap();
    assert_eq!(table.lines().count(), 4);
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("Side by side") && page.contains("taper (deg)") && !page.contains("radius (mm)"));
    let (code, _, last) = run(&["--demo", "a", "--sweep", "width:1:2:3"]);
    assert!(code == Some(2) && !last.is_empty(), "{last}");
}

#[test]
fn guide_curves_come_from_tables_and_a_cutter_that_is_too_short_blocks_what_would_be_milled() {
    let folder = tempfile::tempdir().unwrap();
    let lower = file(folder.path(), "lower.csv", "x,y,z\n0,0,0\n10,2,0\n20,2,0\n30,0,0\n");
    let upper = file(folder.path(), "upper.csv", "# mm\n0;1;10\n10;3.5;10\n20;3;10\n30;0;10\n");
    let out = folder.path().join("out");
    let guides = ["--lower", &lower, "--upper", &upper, "--out", out.to_str().unwrap(), "--radius", "1.5"];
    let (code, said, last) = run(&guides);
    assert!(code != Some(0) && format!("{said}{last}").contains("the positive side is towards"), "{said} {last}");
    let guides = [&guides[..], &["--side", "negative"]].concat();
    let (code, said, last) = run(&[&guides[..], &["--taper-deg", "0", "--holder", "20:1.5,10:8:12"]].concat());
    assert_eq!(code, Some(0), "{said} {last}");
    assert!(out.join("flank.ngc").exists() && said.contains("nothing was checked for gouges"));
    let (code, said, _) = run(&[&guides[..], &["--length", "6"]].concat());
    assert_eq!(code, Some(3), "{said}");
    assert!(said.contains("check cutter: FAILS: the flutes are 6.000 mm long and must be"), "{said}");
    assert!(said.contains("flank.ngc of an earlier export was removed"), "{said}");
    assert!(!out.join("flank.ngc").exists());
    // A short cutter may be meant so.
    let overrides = ["--length", "6", "--override", "cutter", "--override", "coverage"];
    let (code, said, _) = run(&[&guides[..], &overrides].concat());
    assert_eq!((code, out.join("flank.ngc").exists()), (Some(3), true), "{said}");
}

#[test]
fn the_flanks_of_a_mesh_are_listed_and_one_is_milled() {
    // A wedge: four side walls, two of them leaning.
    let ring = |x: f64, y: f64, z: f64| [[-x, -y], [x, -y], [x, y], [-x, y]].map(|[x, y]| DVec3::new(x, y, z));
    let mut triangles = vec![[0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7]];
    for i in 0..4 {
        let (a, b) = (i, (i + 1) % 4);
        triangles.extend([[a, b, b + 4], [a, b + 4, a + 4]]);
    }
    let mesh = Mesh { vertices: [ring(1.5, 1.5, 0.0), ring(1.5, 1.0, 3.0)].concat(), triangles };
    assert!(mesh.is_watertight() && mesh.volume() > 0.0);
    let folder = tempfile::tempdir().unwrap();
    let part = folder.path().join("wedge.stl");
    write_stl(&part, &mesh).unwrap();
    let part = part.to_str().unwrap();
    let output = sparkpath(&["flank", "--json", "--mesh", part, "--units", "mm", "--list"]);
    assert_eq!(output.status.code(), Some(0));
    let list: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let leaning = 3.0 * 3f64.hypot(0.5);
    let is_leaning = |c: &&serde_json::Value| (c["area_mm2"].as_f64().unwrap() - leaning).abs() < 1e-6;
    let found: Vec<&serde_json::Value> = list.as_array().unwrap().iter().filter(is_leaning).collect();
    assert!(found.len() == 2 && found.iter().all(|c| c["kind"] == "plane" && c["is_ruled"] == true), "{list}");
    let number = found[0]["flank"].to_string();
    let taken = ["--mesh", part, "--units", "mm", "--flank", number.as_str()];
    let (code, said, _) = run(&[&taken[..], &["--taper-deg", "0", "--machine", "fork-cb"]].concat());
    // A plane is touched all along: nothing is off but rounding.
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("check ruled: holds") && said.contains("is zero within rounding"), "{said}");
    let (code, _, last) = run(&["--mesh", part, "--flank", "99"]);
    assert!(code == Some(2) && last.contains("no flank 99"), "{last}");
}

#[test]
fn every_mistake_is_one_line_and_is_found_before_anything_is_computed() {
    let folder = tempfile::tempdir().unwrap();
    let lower = file(folder.path(), "lower.csv", "0,0,0\n10,0,0\n");
    let crossing = file(folder.path(), "crossing.csv", "5,-5,0\n5,5,0\n");
    let letters = file(folder.path(), "letters.csv", "0,0,1\n1,2,a\n");
    let part = file(folder.path(), "part.stl", "solid\nendsolid\n");
    let wrong = file(folder.path(), "wrong.sparkpath", "kind = \"flank\"\n[cutter]\nradius = 1\n");
    // 12 mm, or 12 inches.
    let small =
        file(folder.path(), "small.obj", "v 0 0 0\nv 12 0 0\nv 0 9 0\nv 0 0 5\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
    for (arguments, words) in [
        (&["--lower", &lower, "--upper", &crossing][..], "cross or touch"),
        (&["--lower", &lower, "--upper", &letters], "line 2"),
        (&["--lower", &lower, "--upper", "nowhere.csv"], "cannot be read"),
        (&["--lower", &lower], "--upper"),
        (&[], "no surface was given"),
        (&[part.as_str()], "part.stl"),
        (&[part.as_str(), "--demo", "a"], "another surface is given"),
        (&[wrong.as_str()], "unknown field `radius`"),
        (&["--demo", "c"], "--demo"),
        (&["--demo", "a", "--machine", "lathe"], "trunnion-ac, fork-cb, swivel-bc"),
        (&["--demo", "a", "--radius", "-1"], "radius_mm is -1"),
        (&["--demo", "a", "--taper-deg", "80"], "taper_deg is 80"),
        (&["--demo", "a", "--holder", "20"], "expected length:radius"),
        (&["--demo", "a", "--points", "3"], "control_points is 3"),
        (&["--demo", "a", "--tolerance", "0"], "linearisation_mm is 0"),
        (&["--demo", "a", "--feed", "nan"], "feed_mm_per_min is nan"),
        (&["--demo", "a", "--max-overcut", "0"], "are for --objective bounded"),
        (&["--demo", "a", "--flank", "1"], "give one with --mesh"),
        (&["--mesh", &part, "--flank", "3,4"], "expected one number from 1"),
        (&["--lower", &lower, "--upper", &lower, "--units", "inch"], "guide curves are in mm"),
        (&["--demo", "a", "--walls", "nowhere.stl"], "nowhere.stl"),
        (&["--demo", "a", "--out", &lower], "lower.csv"),
        (&["--mesh", &small], "small.obj: it says no unit"),
        (&["--mesh", &small, "--list"], "set the unit: `--units mm`"),
    ] {
        let (code, said, last) = run(arguments);
        assert!(code == Some(2) && said.is_empty() && last.contains(words), "{arguments:?}: {code:?} {last}");
        assert!(last.matches("--help").count() < 2, "{last}");
    }
}

#[test]
fn an_electrode_of_a_mold_or_of_a_folder_is_milled_as_it_stands_on_the_table() {
    let folder = tempfile::tempdir().unwrap();
    let [mesh, file, out] = ["mold.stl", "pocket.sparkpath", "out"].map(|name| folder.path().join(name));
    write_stl(&mesh, &pocket()).unwrap();
    let mut asked = MoldParams { mesh: Some(mesh.clone()), units: Units::Mm, ..MoldParams::default() };
    asked.library = CutterLibrary { cutter: vec![Cutter::flat(1.0)] };
    Document::new(asked).export(&file).unwrap();
    let [mesh, file, out] = [&mesh, &file, &out].map(|p| p.to_str().unwrap());
    let design = ["electrodes", mesh, "--units", "mm", "--cutters", "flat:1", "--no-pictures", "--out", out];
    assert_eq!(sparkpath(&design).status.code(), Some(0));
    let list = |of: &str| {
        let output = sparkpath(&["flank", "--json", "--electrode", "E01", "--of", of, "--list"]);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        let list: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        list.as_array().unwrap().iter().map(|c| c["area_mm2"].as_f64().unwrap()).collect::<Vec<_>>()
    };
    let (designed, exported) = (list(file), list(out));
    assert!(designed.len() == exported.len() && !designed.is_empty());
    assert!(designed.iter().zip(&exported).all(|(a, b)| (a - b).abs() < 1e-3), "{designed:?} {exported:?}");
    // What is saved holds the mesh, and the electrode stands on its base.
    let save = folder.path().join("e01.sparkpath");
    let more = ["--taper-deg", "0", "--radius", "0.5", "--save", save.to_str().unwrap()];
    let (code, said, last) = run(&[&["--electrode", "E01", "--of", file][..], &more].concat());
    assert!(matches!(code, Some(0 | 3)), "{said} {last}");
    let saved = opened(&save);
    let FlankSource::Mesh(source) = &saved.source else { panic!("{said}") };
    assert!(source.part() == "E01 of mold" && source.fit.up == DVec3::NEG_Z);
    assert_eq!(saved.milling.workpiece.as_ref().unwrap().z_axis, DVec3::NEG_Z);
    // What was said of one part is not said of another that takes its place.
    let mut other = FlankDocument { side: Side::Negative, ..saved.clone() };
    other.overrides = vec![Override::whatever("gouge")];
    other.walls = Some(WallsFile { file: mesh.into(), units: Units::Mm });
    Document::new(other).export(&save).unwrap();
    let other = ["--electrode", "E01", "--of", out, "--override", "leads:0.5", "--save", save.to_str().unwrap()];
    let (code, said, last) = run(&[&[save.to_str().unwrap()][..], &other].concat());
    assert!(matches!(code, Some(0 | 3)), "{said} {last}");
    let found = opened(save);
    assert_eq!((found.side, found.walls, found.cutter), (Side::Automatic, None, saved.cutter));
    assert_eq!(found.overrides, ["leads:0.5".parse().unwrap()]);
    for (of, name, words) in [
        (file, "E99", "there is no electrode \"E99\"; there are E01"),
        (out, "E99", "there is no electrode \"E99\"; there are E01"),
        (mesh, "E01", "electrodes are in the project of a mold or a blisk"),
        ("nowhere.sparkpath", "1", "nowhere.sparkpath"),
    ] {
        let (code, said, last) = run(&["--electrode", name, "--of", of]);
        assert!(code == Some(2) && said.is_empty() && last.contains(words), "{of} {name}: {code:?} {last}");
    }
}

#[test]
fn a_users_own_machine_and_what_is_said_beside_a_file_are_taken() {
    let folder = tempfile::tempdir().unwrap();
    let settings = folder.path().join("sparkpath");
    std::fs::create_dir(&settings).unwrap();
    let own = sparkpath::workspaces::flank::document::milling_machine_file::STANDARD_FILE.replacen(
        "trunnion-ac",
        "my-mill",
        1,
    );
    file(&settings, "milling_machines.toml", &own);
    let save = folder.path().join("a.sparkpath");
    let save = save.to_str().unwrap();
    let told = |arguments: &[&str]| {
        let output = sparkpath_with(folder.path().to_str().unwrap(), &[&["flank"], arguments, &QUICK[..4]].concat());
        (output.status.code(), text(&output.stderr))
    };
    let (code, said) = told(&[
        "--demo",
        "a",
        "--machine",
        "my-mill",
        "--max-overcut",
        "0.05",
        "--max-undercut",
        "0.07",
        "--save",
        save,
    ]);
    assert_eq!(code, Some(0), "{said}");
    assert_eq!(run(&["--demo", "a", "--machine", "my-mill"]).0, Some(2), "another user has no such machine");
    let (code, said) = told(&[save, "--max-overcut", "0.04", "--cut", "conventional", "--save", save]);
    assert_eq!(code, Some(0), "{said}");
    let document = opened(save);
    let bounds = Objective::Bounded { overcut_mm: Some(0.04), undercut_mm: Some(0.07) };
    assert_eq!((document.plan.objective, document.milling.cut), (bounds, CutDirection::Conventional));
    // Another machine has the workpiece and the tool where its own file says, and that is said.
    assert_eq!(told(&[save, "--zero", "0,0,45", "--gauge-length", "125", "--save", save]).0, Some(0));
    assert!(opened(save).milling.workpiece.is_some());
    let (code, said, _) = run(&[save, "--machine", "trunnion-ac", "--gauge-length", "130", "--save", save]);
    assert!(code == Some(0) && said.contains("how the workpiece was clamped was of the former one"), "{said}");
    let milling = opened(save).milling;
    assert_eq!((milling.workpiece, milling.gauge_length_mm), (None, Some(130.0)));
    // What the post cannot say is found before anything is computed.
    let post = nc::flank_program::BUILT_IN_POST.1.replacen("[[axes]]\naxis = \"c\"\nword = \"C\"\n", "", 1);
    let post = file(folder.path(), "no_c.toml", &post);
    let (code, _, said) = run(&["--demo", "a", "--post", &post]);
    assert!(code == Some(2) && said.contains("axis C"), "{said}");
}
