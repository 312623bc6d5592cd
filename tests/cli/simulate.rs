//! Machines with bodies from the command line.

use super::{COMES_OUT, job, sparkpath, text};

/// The easy job on a machine, with these keys of `[machine]`.
fn on_machine(folder: &std::path::Path, machine: &str) -> String {
    let file = job(folder, COMES_OUT);
    let text = std::fs::read_to_string(&file).unwrap() + "[machine]\n" + machine;
    std::fs::write(&file, text).unwrap();
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
    let file = on_machine(folder.path(), "file = \"mine.toml\"\n");
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
    for (machine, words) in [("name = \"mill\"\n", "there is no such machine"), ("", "has no name")] {
        let file = on_machine(folder.path(), machine);
        let output = sparkpath(&["simulate", &file]);
        assert_eq!(output.status.code(), Some(2));
        assert!(text(&output.stderr).contains(words), "{}", text(&output.stderr));
    }
}
