//! `sparkpath compare`.

use super::{COMES_OUT, job, job_for, sparkpath, text};
use crate::common::curved_blisk;

#[test]
fn a_comparison_prints_a_table_and_writes_three_files() {
    let folder = tempfile::tempdir().unwrap();
    let file = job(folder.path(), COMES_OUT);
    let out = folder.path().join("out");
    let output =
        sparkpath(&["compare", &file, "--out", out.to_str().unwrap(), "--strategies", "max-min-distance,genetic"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let mut names: Vec<String> =
        std::fs::read_dir(&out).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    assert_eq!(names, ["comparison.csv", "comparison.html", "comparison.json", "export_manifest.toml"]);
    let json: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(out.join("comparison.json")).unwrap()).unwrap();
    let strategies: Vec<&str> =
        json["runs"].as_array().unwrap().iter().map(|r| r["strategy"].as_str().unwrap()).collect();
    assert_eq!(strategies, ["max-min-distance", "genetic"]);
    let certified = json["runs"][1]["electrodes"][0]["certified_clearance_mm"].as_f64().unwrap();
    assert!(certified >= 0.098, "{certified}");
    let table = text(&output.stdout);
    assert!(table.contains(&format!("{certified:.4}")) && table.contains("max-min-distance"), "{table}");
}

#[test]
fn without_any_certified_run_the_answer_is_3() {
    let folder = tempfile::tempdir().unwrap();
    let file = job_for(&curved_blisk(), folder.path(), "");
    let out = folder.path().join("out");
    let output = sparkpath(&["compare", &file, "--out", out.to_str().unwrap(), "--strategies", "free-travel"]);
    assert_eq!(output.status.code(), Some(3), "{}", text(&output.stderr));
    let html = std::fs::read_to_string(out.join("comparison.html")).unwrap();
    assert!(html.contains("No strategy has a certified path."));
}

#[test]
fn an_unknown_strategy_is_refused_with_those_there_are() {
    let output = sparkpath(&["compare", "job.sparkpath", "--out", "out", "--strategies", "genetic,gentic"]);
    assert_eq!(output.status.code(), Some(2));
    let said = text(&output.stderr);
    assert!(said.contains("gentic") && said.contains("max-min-distance") && said.lines().count() == 1, "{said}");
}
