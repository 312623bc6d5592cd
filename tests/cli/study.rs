//! Studies from the command line: many points, in this process or through Snakemake.

use std::fs;
use std::path::{Path, PathBuf};

use import::write_stl;

use super::uncut::pocket;
use super::{COMES_OUT, job, planned, sparkpath, text};

/// Writes a mold, two libraries of cutters, and a study of it with these parameters.
fn study(folder: &Path, parameters: &str) -> PathBuf {
    write_stl(&folder.join("mold.stl"), &pocket()).unwrap();
    for (name, diameter) in [("wide.toml", 2.0), ("narrow.toml", 1.0)] {
        fs::write(folder.join(name), format!("[[cutter]]\ndiameter_mm = {diameter}\n")).unwrap();
    }
    fs::write(
        folder.join("mold.sparkpath"),
        "kind = \"mold\"\nmesh = \"mold.stl\"\nunits = \"mm\"\nopening = \"+z\"\n",
    )
    .unwrap();
    let file = folder.join("study.toml");
    let text = format!(
        "kind = \"study\"\nproject = \"mold.sparkpath\"\ncommand = \"uncut\"\n{parameters}\n\
         [collect]\nless = [\"volume_mm3\"]\n"
    );
    fs::write(&file, text).unwrap();
    file
}

/// Three points, of which the second leaves the least.
const THREE: &str = "[sampling]\nmethod = \"list\"\n[[parameter]]\nkey = \"library\"\nvalues = [\"wide.toml\", \"narrow.toml\", \"wide.toml\"]\n\
                     [[parameter]]\nkey = \"tolerance_mm\"\nvalues = [0.02, 0.02, 0.05]\n";

fn run(arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = sparkpath(&[&["study"], arguments].concat());
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}

fn of(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn answer_file(out: &Path, point: usize) -> PathBuf {
    out.join(format!("points/{point:06}/answer.json"))
}

fn answer(out: &Path, point: usize) -> serde_json::Value {
    serde_json::from_str(&fs::read_to_string(answer_file(out, point)).unwrap()).unwrap()
}

/// Changes an answer as another program, another file or another hand would.
fn change(out: &Path, point: usize, edit: impl Fn(&mut serde_json::Value)) {
    let mut changed = answer(out, point);
    edit(&mut changed);
    fs::write(answer_file(out, point), changed.to_string()).unwrap();
}

#[test]
fn a_study_goes_on_where_it_stopped_and_ends_with_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let file = study(folder.path(), THREE);
    let [out, other] = ["out", "other"].map(|name| folder.path().join(name));
    let (code, said, problem) = run(&[of(&file), "--out", of(&out), "--threads", "2"]);
    assert_eq!(code, Some(0), "{problem}");
    assert!(said.contains("3 points: 3 feasible, 0 not feasible, 0 bad. Best by less volume_mm3: point 2."), "{said}");
    let csv = fs::read_to_string(out.join("study.csv")).unwrap();
    let rows: Vec<&str> = csv.lines().collect();
    let head = "point,library,tolerance_mm,exit_code,regions,volume_mm3,off_mm3,surface_mm2,height_mm,thickness_mm,\
                hidden_mm2,warnings,is_best,sentence";
    assert_eq!((rows[0], rows.len()), (head, 4));
    assert!(
        rows[1].starts_with("1,../wide.toml,0.02,0,4,3.43") && rows[2].starts_with("2,../narrow.toml,0.02,0,4,0.85"),
        "{csv}"
    );
    assert!(rows[2].contains(",true,The cutters leave 4 regions") && rows[3].contains(",false,"), "{csv}");
    let page = fs::read_to_string(out.join("study.html")).unwrap();
    assert!(page.matches("<svg ").count() == 3 && page.contains("Parallel coordinates"), "{page}");
    assert!(!page.contains("<script") && !page.contains("http"), "it needs nothing from outside");

    // What is gone is computed again, and nothing else.
    let kept = fs::read(answer_file(&out, 3)).unwrap();
    for gone in [answer_file(&out, 1), answer_file(&out, 2), out.join("study.csv"), out.join("study.html")] {
        fs::remove_file(gone).unwrap();
    }
    let (_, said, _) = run(&[of(&out), "--status"]);
    assert_eq!(said, "3 points: 1 feasible, 0 not feasible, 0 bad, 2 open.\n");
    assert_eq!(run(&[of(&file), "--out", of(&out), "--threads", "1"]).0, Some(0));
    assert_eq!(fs::read(answer_file(&out, 3)).unwrap(), kept);
    assert_eq!(fs::read_to_string(out.join("study.csv")).unwrap(), csv);
    assert_eq!(fs::read_to_string(out.join("study.html")).unwrap(), page);

    // Point by point, as another program asks for them.
    assert_eq!(run(&[of(&file), "--out", of(&other), "--set-up"]).0, Some(0));
    for point in ["000003", "1", "2"] {
        assert_eq!(run(&[of(&other), "--point", point]).0, Some(0));
    }
    assert_eq!(run(&[of(&other), "--collect"]).0, Some(0));
    assert_eq!(fs::read_to_string(other.join("study.csv")).unwrap(), csv);

    // The project of a point is one that the command takes.
    let point = out.join("points/000002/point.sparkpath");
    let output = sparkpath(&["uncut", of(&point), "--json"]);
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let volume = found["uncut"]["agreement"]["layers"]["volume_mm3"].as_f64();
    assert_eq!(volume, answer(&out, 2)["results"]["volume_mm3"].as_f64());
}

#[test]
fn a_bad_point_is_recorded_and_not_tried_again() {
    let folder = tempfile::tempdir().unwrap();
    let molds = "[[parameter]]\nkey = \"mesh\"\nfolder = \"molds\"\n";
    let file = study(folder.path(), molds);
    let (molds, out) = (folder.path().join("molds"), folder.path().join("out"));
    let (code, _, said) = run(&[of(&file), "--out", of(&out)]);
    assert!(code == Some(2) && said.contains("parameter[0].folder is molds: cannot be read"), "{said}");
    fs::create_dir(&molds).unwrap();
    fs::write(molds.join("broken.stl"), "no mesh").unwrap();
    fs::copy(folder.path().join("mold.stl"), molds.join("pocket.stl")).unwrap();
    let (code, said, _) = run(&[of(&file), "--out", of(&out)]);
    assert_eq!(code, Some(3), "{said}");
    assert!(said.contains("2 points: 1 feasible, 0 not feasible, 1 bad."), "{said}");
    let bad = answer(&out, 1);
    assert_eq!((&bad["exit_code"], &bad["settings"]["mesh"]), (&2.into(), &"../molds/broken.stl".into()));
    assert!(bad["sentence"].as_str().unwrap().contains("broken.stl"), "{bad}");
    let before = fs::read(answer_file(&out, 1)).unwrap();
    fs::remove_file(answer_file(&out, 2)).unwrap();
    let (code, said, _) = run(&[of(&out)]);
    assert!(code == Some(3) && !said.contains("point      1 "), "{said}");
    assert_eq!(fs::read(answer_file(&out, 1)).unwrap(), before);
    assert!(fs::read_to_string(out.join("study.csv")).unwrap().contains("1,../molds/broken.stl,2,,,,"), "no results");
    // Asked for by its number it is told as any command tells it.
    let (code, _, said) = run(&[of(&out), "--point", "1"]);
    assert!(code == Some(2) && said.contains("error: point 1: ") && said.contains("broken.stl"), "{said}");
}

#[test]
fn answers_that_cannot_stand_side_by_side_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = study(folder.path(), THREE);
    let out = folder.path().join("out");
    assert_eq!(run(&[of(&file), "--out", of(&out)]).0, Some(0));
    let whole = fs::read_to_string(answer_file(&out, 2)).unwrap();
    let csv = fs::read(out.join("study.csv")).unwrap();
    let refused = |words: &str| {
        for arguments in [&[of(&out), "--collect"][..], &[of(&out)]] {
            let (code, _, said) = run(arguments);
            assert!(code == Some(2) && said.contains(words), "{arguments:?}: {said}");
        }
        fs::write(answer_file(&out, 2), &whole).unwrap();
    };
    change(&out, 2, |answer| answer["program_version"] = "9.9.9".into());
    refused("the answers are of 0.1.0 (points 1, 3), 9.9.9 (point 2); remove the folders of the points");
    change(&out, 2, |answer| answer["study_sha256"] = "0".into());
    refused("point 2 is of another study");
    change(&out, 2, |answer| answer["inputs"][0]["sha256"] = "0".into());
    refused("mold.stl was another file for point 2 than for point 1");
    fs::write(answer_file(&out, 2), "{}").unwrap();
    refused("this is no answer");
    change(&out, 2, |answer| answer["point"] = 0.into());
    refused("this is the answer of point 0; remove it");
    assert_eq!(fs::read(out.join("study.csv")).unwrap(), csv);
    // Before more is computed the files are looked at as they are now.
    fs::write(folder.path().join("wide.toml"), "[[cutter]]\ndiameter_mm = 3.0\n").unwrap();
    fs::remove_file(answer_file(&out, 3)).unwrap();
    let (code, _, said) = run(&[of(&out)]);
    assert!(code == Some(2) && said.contains("wide.toml is another file now than it was for point 1"), "{said}");
}

#[test]
fn mistakes_of_a_study_name_the_key_and_the_remedy_and_write_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let value = |key: &str, value: &str| format!("[[parameter]]\nkey = \"{key}\"\nvalues = [{value}]\n");
    for (parameters, words) in [
        (
            value("tolerance", "1"),
            "line 5: parameter[0].key: tolerance: there is no such parameter; did you mean tolerance_mm?",
        ),
        (value("tolerance_mm", "0.02, -1"), "parameter[0].values[1]: tolerance_mm is -1: must be"),
        (value("library", "\"none.toml\""), "none.toml"),
        (
            "[[parameter]]\nkey = \"tolerance_mm\"\nfrom = 0.01\nto = 0.1\n".to_owned(),
            "parameter[0].steps: it is missing",
        ),
        (
            "[[parameter]]\nkey = \"tolerance_mm\"\nfrom = 0.01\nto = 1e9\nsteps = 2\n".to_owned(),
            "parameter[0].to: tolerance_mm is",
        ),
        (format!("{}[collect]\nmore = [\"volume\"]\n", value("tolerance_mm", "1")), "duplicate key"),
    ] {
        let file = study(folder.path(), &parameters);
        let (code, _, said) = run(&[of(&file), "--out", of(&out)]);
        assert!(code == Some(2) && said.contains(words), "{parameters}: {said}");
    }
    let file = study(folder.path(), THREE);
    let whole = fs::read_to_string(&file).unwrap();
    fs::write(&file, whole.replace("volume_mm3", "volume")).unwrap();
    let (code, _, said) = run(&[of(&file), "--out", of(&out)]);
    assert!(
        code == Some(2) && said.contains("collect.less[0] is volume: is no result of uncut: take one of regions"),
        "{said}"
    );
    fs::write(&file, whole.replace("\"uncut\"", "\"plan\"")).unwrap();
    let (code, _, said) = run(&[of(&file), "--out", of(&out)]);
    assert!(
        code == Some(2) && said.contains("a study of a mold has the command uncut or electrodes, not plan"),
        "{said}"
    );
    assert!(!out.exists());
    assert!(run(&[of(&file)]).2.contains("give the folder for the points with --out DIR"));
    assert!(run(&[of(folder.path())]).0 == Some(2), "no folder of a study");
    // A folder has one study; what it collects may change.
    fs::write(&file, &whole).unwrap();
    assert_eq!(run(&[of(&file), "--out", of(&out), "--set-up"]).0, Some(0));
    assert!(run(&[of(&out), "--point", "4"]).2.contains("there is no point 4; the study has 3"));
    fs::write(&file, whole.replace("0.05]", "0.06]")).unwrap();
    let (code, _, said) = run(&[of(&file), "--out", of(&out)]);
    assert!(code == Some(2) && said.contains("another study is in this folder"), "{said}");
    assert!(!out.join("points").exists());
}

#[test]
fn what_is_collected_can_change_and_a_new_place_is_computed() {
    let folder = tempfile::tempdir().unwrap();
    let file = study(folder.path(), "[[parameter]]\nkey = \"library\"\nvalues = [\"wide.toml\", \"narrow.toml\"]\n");
    let out = folder.path().join("out");
    assert_eq!(run(&[of(&file), "--out", of(&out)]).0, Some(0));
    let before = fs::read(answer_file(&out, 1)).unwrap();
    let whole = fs::read_to_string(&file).unwrap();
    fs::write(&file, whole.replace("less = [", "columns = [\"regions\"]\nless = [")).unwrap();
    assert_eq!(run(&[of(&file), "--out", of(&out)]).0, Some(0));
    let csv = fs::read_to_string(out.join("study.csv")).unwrap();
    assert!(
        csv.starts_with("point,library,exit_code,regions,volume_mm3,is_best,sentence\n1,../wide.toml,0,4,3.43"),
        "{csv}"
    );
    assert_eq!(fs::read(answer_file(&out, 1)).unwrap(), before, "it was known");
    fs::write(&file, whole.replace("less = [", "columns = [\"uncut.regions[0].volume_mm3\"]\nless = [")).unwrap();
    assert_eq!(run(&[of(&file), "--out", of(&out), "--set-up"]).0, Some(0));
    let (code, _, said) = run(&[of(&out), "--collect"]);
    assert!(code == Some(2) && said.contains("point 1 has no result uncut.regions[0].volume_mm3"), "{said}");
    assert_eq!(run(&[of(&out)]).0, Some(0));
    let csv = fs::read_to_string(out.join("study.csv")).unwrap();
    assert!(csv.lines().nth(1).unwrap().starts_with("1,../wide.toml,0,0.85"), "a region of four: {csv}");
}

#[cfg(unix)]
#[test]
fn a_study_that_is_interrupted_keeps_what_is_done_and_nothing_half_written() {
    let folder = tempfile::tempdir().unwrap();
    let file = study(folder.path(), THREE);
    let out = folder.path().join("out");
    let arguments = ["study", of(&file), "--out", of(&out), "--threads", "1"];
    let (code, said) = super::simulate::interrupted_at("study", &arguments);
    assert!(code == Some(130) && said.contains("the same command goes on"), "{said}");
    assert!(!out.join("study.csv").exists());
    let (code, said, _) = run(&[of(&out), "--status"]);
    assert!(code == Some(0) && said.contains("open"), "every answer is whole: {said}");
    assert_eq!(run(&[of(&out)]).0, Some(0));
    let count = fs::read_to_string(out.join("study.csv")).unwrap().lines().count();
    assert_eq!(count, 4);
}

/// Every result that is named comes out of a plan, and a channel that is not there is a bad point.
#[test]
fn a_study_of_a_plan_has_its_figures() {
    let folder = tempfile::tempdir().unwrap();
    job(folder.path(), COMES_OUT);
    let file = folder.path().join("study.toml");
    let text = "kind = \"study\"\nproject = \"job.sparkpath\"\ncommand = \"plan\"\n\
                [[parameter]]\nkey = \"blisk.channel\"\nvalues = [0, 99]\n\
                [collect]\ncolumns = [\"certified_mm\", \"electrodes[0].enters_from\", \"seconds\"]\n";
    fs::write(&file, text).unwrap();
    let out = folder.path().join("out");
    let (code, said, problem) = run(&[of(&file), "--out", of(&out)]);
    assert!(code == Some(3) && said.contains("1 feasible, 0 not feasible, 1 bad"), "{said}{problem}");
    let answer = answer(&out, 1);
    let results = answer["results"].as_object().unwrap();
    assert!(results["certified_mm"].as_f64().unwrap() >= 0.098 && results["verified"] == true, "{answer}");
    assert_eq!((&results["electrodes"], &results["enter"]), (&1.into(), &"-x".into()));
    let report = fs::read_to_string(planned().join("out/report.json")).unwrap();
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    let of_command = &report["electrodes"][0];
    for (name, key) in [("certified_mm", "certified_clearance_mm"), ("volume_mm3", "volume_mm3")] {
        assert_eq!(results[name], of_command[key], "the command itself finds the same");
    }
    for known in ["volume_mm3", "thickness_mm", "burn_area_mm2", "residual_mm", "left_mm3", "throat_mm", "turning_deg"]
    {
        assert!(results[known].as_f64().is_some_and(|value| value >= 0.0), "{known}: {answer}");
    }
    // Without a finish there are no minutes.
    assert!(results["channel_min"].is_null() && results["wheel_h"].is_null(), "{answer}");
    let csv = fs::read_to_string(out.join("study.csv")).unwrap();
    assert!(csv.contains(",-x,") && csv.lines().nth(2).unwrap().starts_with("2,99,2,,,"), "{csv}");
}

/// The Snakefile with the real Snakemake, which the variable `SNAKEMAKE` names: killed midway, with a point that fails once,
/// and taken up again.
#[cfg(unix)]
#[test]
#[ignore = "needs Snakemake 9; scripts/test installs it and runs this"]
fn snakemake_is_killed_goes_on_and_ends_with_the_same_bytes() {
    use std::os::unix::fs::PermissionsExt as _;
    use std::process::{Command, Stdio};

    let snakemake = std::env::var_os("SNAKEMAKE").expect("the variable SNAKEMAKE names the program");
    let folder = tempfile::tempdir().unwrap();
    let file = study(folder.path(), THREE);
    let [alone, many] = ["alone", "many"].map(|name| folder.path().join(name));
    assert_eq!(run(&[of(&file), "--out", of(&alone)]).0, Some(0));
    assert_eq!(run(&[of(&file), "--out", of(&many), "--set-up"]).0, Some(0));
    // The second call kills Snakemake, the third fails as a machine might.
    let program = folder.path().join("program");
    let script = format!(
        "#!/bin/sh\necho call >> calls\ncase $(wc -l < calls | tr -d ' ') in\n\
         2) kill -TERM $(cat pid); exit 1 ;;\n3) exit 1 ;;\nesac\nexec {} \"$@\"\n",
        env!("CARGO_BIN_EXE_sparkpath")
    );
    fs::write(&program, script).unwrap();
    fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).unwrap();
    let make = || {
        let mut shell = Command::new("sh");
        shell.args(["-c", "echo $$ > pid; exec \"$SNAKEMAKE\" --cores 1"]).current_dir(&many).stdin(Stdio::null());
        shell.env("SNAKEMAKE", &snakemake).env("SPARKPATH", &program).env("XDG_CACHE_HOME", folder.path());
        let output = shell.output().unwrap();
        (output.status.success(), text(&output.stderr))
    };
    let answered = || (1..=3).filter(|&point| answer_file(&many, point).exists()).count();
    let (is_done, said) = make();
    assert!(!is_done && answered() == 1 && !many.join("study.csv").exists(), "{said}");
    let (is_done, said) = make();
    assert!(is_done, "{said}");
    let calls = fs::read_to_string(many.join("calls")).unwrap().lines().count();
    assert_eq!(calls, 6, "one point, a kill, a failure, two points, the table");
    for name in ["study.csv", "study.html", "study.toml"] {
        assert_eq!(fs::read(many.join(name)).unwrap(), fs::read(alone.join(name)).unwrap(), "{name}");
    }
}
