//! The program as its users and other tools meet it: exit codes, files, one line for every mistake.

use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::sync::OnceLock;

use sparkpath::blisk::parametric::{MeshResolution, ParametricBlisk};
use sparkpath::mesh_io::write_stl;
use tempfile::TempDir;

fn sparkpath(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_sparkpath")).args(arguments).stdin(Stdio::null()).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Writes a small blisk and a job with a small search for it, with `more` lines at its end.
fn job(folder: &Path, electrode: &str) -> String {
    let blisk = ParametricBlisk {
        blades: 24,
        hub_radius_mm: 60.0,
        shroud_radius_mm: 72.0,
        bore_radius_mm: 40.0,
        width_mm: 20.0,
        chord_mm: 14.0,
        beta_in_deg: 20.0,
        beta_out_deg: -25.0,
        twist_deg: 2.0,
        ..Default::default()
    };
    write_stl(&folder.join("part.stl"), &blisk.mesh(&MeshResolution::default()).unwrap()).unwrap();
    let file = folder.join("job.toml");
    let text = format!(
        "[blisk]\nmesh = \"part.stl\"\nunits = \"mm\"\n[electrode]\nenter = \"-x\"\n{electrode}\n\
         [plan]\nstep_mm = 0.8\n[genetic]\npopulation = 16\ngenerations = 6\n"
    );
    std::fs::write(&file, text).unwrap();
    file.to_str().unwrap().to_owned()
}

const COMES_OUT: &str = "circumferential_reduction_deg = [2.0, 2.0]";

/// A finished plan, shared by the tests that read it.
fn planned() -> &'static (TempDir, Output) {
    static PLAN: OnceLock<(TempDir, Output)> = OnceLock::new();
    PLAN.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let file = job(folder.path(), COMES_OUT);
        let out = folder.path().join("out");
        let output = sparkpath(&["plan", &file, "--out", out.to_str().unwrap()]);
        (folder, output)
    })
}

fn path(name: &str) -> String {
    planned().0.path().join(name).to_str().unwrap().to_owned()
}

#[test]
fn a_plan_writes_everything_and_answers_0() {
    let (folder, output) = planned();
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    for name in ["electrode_1.stl", "path_1.csv", "path_1.nc", "report.json", "report.html"] {
        assert!(folder.path().join("out").join(name).is_file(), "{name}");
    }
    let report: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(path("out/report.json")).unwrap()).unwrap();
    let electrode = &report["electrodes"][0];
    assert_eq!((&electrode["extractable"], &electrode["verified"]), (&true.into(), &true.into()));
    assert!(electrode["certified_clearance_mm"].as_f64().unwrap() >= 0.098);
    let csv = std::fs::read_to_string(path("out/path_1.csv")).unwrap();
    assert!(csv.starts_with("# {\"format\":\"sparkpath-path-1\""));
    let header = csv.lines().nth(1).unwrap();
    assert_eq!(header, "node,s_mm,x_mm,y_mm,z_mm,a_deg,b_deg,c_deg,clearance_mm");
    let last: Vec<f64> = csv.lines().last().unwrap().split(',').take(8).map(|v| v.parse().unwrap()).collect();
    assert!(last.iter().all(|v| *v == 0.0));
}

#[test]
fn a_written_plan_passes_verify_and_a_tampered_one_does_not() {
    let (blisk, electrode, csv) = (path("part.stl"), path("out/electrode_1.stl"), path("out/path_1.csv"));
    let verify = |csv: &str, gap: &str| {
        let rest = ["--units", "mm", "--path", csv, "--gap", gap];
        sparkpath(&[&["verify", "--blisk", &blisk, "--electrode", &electrode], &rest[..]].concat())
    };
    let good = verify(&csv, "0.1");
    assert_eq!(good.status.code(), Some(0), "{}{}", text(&good.stdout), text(&good.stderr));
    assert_eq!(verify(&csv, "0.3").status.code(), Some(3), "a wider gap is not kept");
    // The electrode driven 2 mm further out along the radius half way in.
    let original = std::fs::read_to_string(&csv).unwrap();
    let rows = original.lines().count();
    let tampered: Vec<String> = original
        .lines()
        .enumerate()
        .map(|(i, line)| {
            let mut fields: Vec<String> = line.split(',').map(str::to_owned).collect();
            if i == rows * 2 / 3 {
                fields[4] = "2.00000".to_owned();
            }
            fields.join(",")
        })
        .collect();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("tampered.csv");
    std::fs::write(&file, tampered.join("\n")).unwrap();
    let bad = verify(file.to_str().unwrap(), "0.1");
    assert_eq!(bad.status.code(), Some(3), "{}", text(&bad.stderr));
    assert!(text(&bad.stdout).contains("NOT verified"));
}

#[test]
fn a_jam_answers_3_with_reasons_and_removes_an_older_program() {
    let folder = tempfile::tempdir().unwrap();
    let file = job(folder.path(), "circumferential_reduction_deg = [0.0, 0.0]\nradial_reduction_mm = 0.0");
    let out = folder.path().join("out");
    std::fs::create_dir(&out).unwrap();
    std::fs::write(out.join("path_1.nc"), "an older program").unwrap();
    let output = sparkpath(&["plan", &file, "--out", out.to_str().unwrap()]);
    let report = std::fs::read_to_string(out.join("report.json")).unwrap();
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    // Whether a full electrode slides out of this blisk is not known beforehand; the answers must agree.
    let verified = report["electrodes"][0]["verified"] == true;
    assert_eq!(output.status.code(), Some(if verified { 0 } else { 3 }));
    let program = std::fs::read_to_string(out.join("path_1.nc")).unwrap_or_default();
    assert_eq!(!program.is_empty(), verified);
    assert!(!program.contains("older"));
}

#[test]
fn every_mistake_is_one_line_with_code_2() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str, content: &str| {
        let file = folder.path().join(name);
        std::fs::write(&file, content).unwrap();
        file.to_str().unwrap().to_owned()
    };
    let out = folder.path().join("out").to_str().unwrap().to_owned();
    let plan = |file: &str| sparkpath(&["plan", file, "--out", &out]);
    for (output, named) in [
        (plan("no-such-job.toml"), "no-such-job.toml"),
        (plan(&at("a.toml", "[blisk]\nmesh = \"absent.stl\"\n")), "absent.stl"),
        (plan(&at("b.toml", "[blisk]\nmesh = \"a.toml\"\n[plan]\nstep = 1\n")), "step"),
        (plan(&at("c.toml", "[blisk]\nmesh = \"c.toml\"\n")), "c.toml"),
        (sparkpath(&["inspect", &at("cube.stl", CUBE)]), "cube.stl"),
        (sparkpath(&["fly"]), "fly"),
        (sparkpath(&["plan"]), "--out"),
    ] {
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{message}");
        let errors: Vec<&str> = message.lines().filter(|l| !l.ends_with(" ...")).collect();
        assert_eq!(errors.len(), 1, "{message}");
        assert!(errors[0].contains(named) && errors[0].starts_with("error: "), "{message}");
    }
    assert!(!Path::new(&out).exists(), "nothing is written");
}

#[cfg(unix)]
#[test]
fn interrupting_answers_130_and_writes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let file = job(folder.path(), COMES_OUT);
    let out = folder.path().join("out");
    let child = Command::new(env!("CARGO_BIN_EXE_sparkpath"))
        .args(["plan", &file, "--out", out.to_str().unwrap()])
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // Until the first line of progress it may not yet listen.
    let mut child = child;
    let mut stderr = std::io::BufReader::new(child.stderr.take().unwrap());
    std::io::BufRead::read_line(&mut stderr, &mut String::new()).unwrap();
    Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(!out.exists());
}

#[test]
fn progress_and_answer_are_json_when_asked_for() {
    let output = sparkpath(&["inspect", &path("part.stl"), "--json", "--threads", "1"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let answer: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(answer["blisk"]["channel"]["shrouded"], true);
    for line in text(&output.stderr).lines() {
        let progress: serde_json::Value = serde_json::from_str(line).unwrap();
        assert!(progress["stage"].is_string() && progress["fraction"].as_f64().is_some_and(|f| f <= 1.0));
    }
}

/// A cube of 20 mm as ASCII STL.
const CUBE: &str = include_str!("data/cube.stl");
