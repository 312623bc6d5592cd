//! Machines with bodies from the command line.

use std::path::Path;
use std::process::{Command, Stdio};

use super::{COMES_OUT, NO_PICTURES, add, job, sparkpath, text};

/// The easy job on a machine, with these keys of `[machine]`.
fn on_machine(folder: &Path, machine: &str) -> String {
    let file = job(folder, COMES_OUT);
    add(&file, &format!("[machine]\n{machine}{NO_PICTURES}"));
    file
}

#[test]
fn channels_are_simulated_and_nothing_collides() {
    let folder = tempfile::tempdir().unwrap();
    let file = on_machine(folder.path(), "name = \"xyzac\"\n");
    let out = folder.path().join("out");
    let output = sparkpath(&["simulate", &file, "--channels", "0,1,7", "--out", out.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{} {}", text(&output.stdout), text(&output.stderr));
    let json: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(out.join("simulation.json")).unwrap()).unwrap();
    let simulation = &json["electrodes"][0]["simulation"];
    assert_eq!(simulation["channels"].as_array().unwrap().len(), 3);
    let pairs = simulation["pairs"].as_array().unwrap();
    assert!(pairs.iter().any(|p| p["moving"] == "chuck" && p["fixed"] == "faceplate"));
    assert!(pairs.iter().all(|p| p["certified_mm"].as_f64() >= p["required_mm"].as_f64()));
    assert!(std::fs::read_to_string(out.join("simulation.txt")).unwrap().contains("Nothing collides in 3 channels"));
}

#[test]
fn a_plan_that_collides_is_answered_no_and_has_no_program() {
    let folder = tempfile::tempdir().unwrap();
    // A bed that fills the place that the electrode is withdrawn to.
    let wall = "[[bodies]]\nname = \"wall\"\ncarried_by = \"bed\"\nshape = \"box\"\nsize_mm = [10, 400, 400]\n\
                centre_mm = [45, 0, 0]\n";
    std::fs::write(folder.path().join("mine.toml"), wall).unwrap();
    let file = on_machine(folder.path(), "name = \"mine.toml\"\n");
    let out = folder.path().join("out");
    let output = sparkpath(&["plan", &file, "--out", out.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(3), "{}", text(&output.stderr));
    assert!(!out.join("path_1.nc").exists() && out.join("path_1.csv").exists());
    let report: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(out.join("report.json")).unwrap()).unwrap();
    assert_eq!(report["electrodes"][0]["verified"], true, "the feed itself is certified");
    let sentence = report["verdict"]["sentence"].as_str().unwrap();
    assert!(sentence.contains("COLLISION: electrode meets wall"), "{sentence}");
}

#[test]
fn a_machine_that_cannot_be_read_is_bad_input() {
    let folder = tempfile::tempdir().unwrap();
    let body = |lines: &str| format!("[[bodies]]\nname = \"arm\"\ncarried_by = \"head\"\n{lines}");
    std::fs::write(folder.path().join("mine.toml"), "speed = 3").unwrap();
    std::fs::write(folder.path().join("bad.toml"), body("shape = \"box\"\nsize_mm = [1, 0, 3]")).unwrap();
    std::fs::write(folder.path().join("open.toml"), body("shape = \"mesh\"\nfile = \"mine.toml\"")).unwrap();
    for (machine, words) in [
        ("name = \"mill\"\n", "there is no such machine"),
        ("", "machine.name is missing"),
        ("name = \"mine.toml\"\n", "mine.toml: unknown field `speed`"),
        ("name = \"bad.toml\"\n", "bad.toml: body arm: size_mm is 0"),
        ("name = \"open.toml\"\n", "open.toml: body arm: "),
    ] {
        let file = on_machine(folder.path(), machine);
        let output = sparkpath(&["simulate", &file]);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2));
        assert!(said.contains(words) && !said.contains("distance field"), "{said}");
    }
}

/// Runs the program and interrupts it as soon as it says on standard error that it is at `stage`.
#[cfg(unix)]
pub fn interrupted_at(stage: &str, arguments: &[&str]) -> (Option<i32>, String) {
    use std::io::{BufRead as _, BufReader, Read as _};
    let mut command = Command::new(env!("CARGO_BIN_EXE_sparkpath"));
    let command = command.args(arguments).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    let mut stderr = BufReader::new(child.stderr.take().unwrap());
    let mut said = String::new();
    while !said.lines().any(|line| line.starts_with(stage)) {
        assert!(stderr.read_line(&mut said).unwrap() > 0, "{said}");
    }
    // The shell's own: a small system has no other.
    let interrupt = format!("kill -INT {}", child.id());
    assert!(Command::new("sh").args(["-c", &interrupt]).status().unwrap().success());
    stderr.read_to_string(&mut said).unwrap();
    (child.wait().unwrap().code(), said)
}

#[cfg(unix)]
#[test]
fn a_plan_that_is_stopped_while_it_is_simulated_is_written_without_a_program() {
    let folder = tempfile::tempdir().unwrap();
    let file = on_machine(folder.path(), "name = \"xyzac\"\n");
    add(&file, "[export]\nchannels = \"all\"\n");
    let out = folder.path().join("out");
    std::fs::create_dir(&out).unwrap();
    std::fs::write(out.join("path_1.nc"), "an older program").unwrap();
    let (code, said) = interrupted_at("simulation", &["plan", &file, "--out", out.to_str().unwrap()]);
    assert!(code == Some(130) && said.contains("simulation of the whole motion was stopped"), "{said}");
    for name in ["path_1.csv", "copying_1.csv", "electrode_1.stl", "report.html"] {
        assert!(out.join(name).is_file(), "{name}");
    }
    assert!(!out.join("path_1.nc").exists(), "not even an older one");
    let report: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(out.join("report.json")).unwrap()).unwrap();
    assert_eq!((&report["verdict"]["exit_code"], &report["electrodes"][0]["verified"]), (&130.into(), &true.into()));
    let sentence = report["verdict"]["sentence"].as_str().unwrap();
    assert!(sentence.contains("simulation of the whole motion was stopped"), "{sentence}");
    assert!(report["electrodes"][0]["simulation"].is_null());
}

#[cfg(unix)]
#[test]
fn a_simulation_finds_the_sizes_that_its_project_leaves_open() {
    let folder = tempfile::tempdir().unwrap();
    let file = on_machine(folder.path(), "name = \"xyzac\"\n");
    let open = std::fs::read_to_string(&file).unwrap().replace("[electrode]", "[electrode]\nsize = \"auto\"");
    std::fs::write(&file, open).unwrap();
    // What follows is the simulation of any other job, and is not waited for.
    let (code, said) = interrupted_at("sizing", &["simulate", &file]);
    assert_eq!(code, Some(130), "{said}");
}
