//! The program as its users and other tools meet it: exit codes, files, one line for every mistake.

mod common;
#[path = "cli/compare.rs"]
mod compare;
#[path = "cli/electrodes.rs"]
mod electrodes;
#[path = "cli/flank.rs"]
mod flank;
#[path = "common/made_once.rs"]
mod made_once;
#[path = "cli/measured.rs"]
mod measured;
#[path = "cli/pictures.rs"]
mod pictures;
#[path = "cli/sections.rs"]
mod sections;
#[path = "cli/simulate.rs"]
mod simulate;
#[path = "cli/study.rs"]
mod study;
#[path = "cli/uncut.rs"]
mod uncut;

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::OnceLock;

use common::{curved_blisk, easy_blisk, mesh};
use import::write_stl;
use made_once::made_once;
use task::Task;
use wheel::parametric::ParametricBlisk;

fn sparkpath(arguments: &[&str]) -> Output {
    sparkpath_with(concat!(env!("CARGO_TARGET_TMPDIR"), "/no-settings"), arguments)
}

/// Runs the program for a user whose settings are in this folder.
fn sparkpath_with(settings: &str, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_sparkpath"));
    command.args(arguments).env("XDG_CONFIG_HOME", settings).stdin(Stdio::null()).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Runs the program where nothing can draw: on an interface to the graphics that Linux does not have.
#[cfg(target_os = "linux")]
fn blind(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_sparkpath"));
    command.args(arguments).env("WGPU_BACKEND", "dx12").stdin(Stdio::null()).output().unwrap()
}

/// Writes the easy blisk.
fn part(folder: &Path) -> String {
    let file = folder.join("part.stl");
    write_stl(&file, &mesh(&easy_blisk())).unwrap();
    file.to_str().unwrap().to_owned()
}

/// Writes the easy blisk and a project with a coarse search for it, with `electrode` among its keys.
fn job(folder: &Path, electrode: &str) -> String {
    job_for(&easy_blisk(), folder, electrode)
}

fn job_for(blisk: &ParametricBlisk, folder: &Path, electrode: &str) -> String {
    write_stl(&folder.join("part.stl"), &mesh(blisk)).unwrap();
    let file = folder.join("job.sparkpath");
    let text = format!(
        "kind = \"blisk\"\n[blisk]\nmesh = \"part.stl\"\nunits = \"mm\"\n[electrode]\nenter = \"-x\"\n{electrode}\n\
         [plan]\nstep_mm = 1.6\nfield_cell_mm = 0.5\n[genetic]\npopulation = 16\ngenerations = 6\n"
    );
    std::fs::write(&file, text).unwrap();
    file.to_str().unwrap().to_owned()
}

const COMES_OUT: &str = "circumferential_reduction_deg = [2.8, 2.8]";

/// Of what a plan writes all but pictures.
const NO_PICTURES: &str = "[export.files]\npictures = false\n[export.pictures]\nwhole = false\nfinal_pose = false\n\
                           sweep = false\nclosest = false\nleftover = false\n";

/// Errors of setting up, which the path of that job bears.
const SETTING: &str =
    "[setting]\nx_mm = 0.002\ny_mm = 0.002\nz_mm = 0.002\na_deg = 0.001\nb_deg = 0.001\nc_deg = 0.001\n";

/// Adds lines to a project.
fn add(file: &str, lines: &str) {
    std::fs::write(file, std::fs::read_to_string(file).unwrap() + lines).unwrap();
}

/// A finished plan, which is made once and shared by those that read it.
fn planned() -> &'static Path {
    static PLAN: OnceLock<PathBuf> = OnceLock::new();
    PLAN.get_or_init(|| {
        made_once("plan", |folder| {
            let file = job(folder, COMES_OUT);
            add(&file, SETTING);
            let output = sparkpath(&["plan", &file, "--out", folder.join("out").to_str().unwrap()]);
            assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
            assert!(text(&output.stdout).contains("setting errors hold"), "{}", text(&output.stdout));
        })
    })
}

fn path(name: &str) -> String {
    planned().join(name).to_str().unwrap().to_owned()
}

#[test]
fn a_plan_writes_everything_and_answers_0() {
    let out = planned().join("out");
    for name in ["electrode_1.stl", "path_1.csv", "path_1.nc", "report.json", "report.html"] {
        assert!(out.join(name).is_file(), "{name}");
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

/// The job file of a plan names its files by what is in them, and has the figures of the report.
#[test]
fn the_job_file_of_a_plan_has_its_files_and_figures() {
    let json = |name: &str| -> serde_json::Value {
        serde_json::from_str(&std::fs::read_to_string(path(name)).unwrap()).unwrap()
    };
    let (job, report) = (json("out/job.json"), json("out/report.json"));
    let schema: serde_json::Value = serde_json::from_slice(&sparkpath(&["job-schema"]).stdout).unwrap();
    let required = schema["$defs"]["electrode"]["required"].as_array().unwrap();
    let electrode = &job["electrodes"][0];
    assert!(required.iter().all(|key| electrode.get(key.as_str().unwrap()).is_some()), "{electrode}");
    assert_eq!(electrode.as_object().unwrap().len(), required.len());
    let location = &electrode["locations"][0];
    let feed = &location["operations"][0];
    assert_eq!((&feed["kind"], &feed["id"]), (&"feed".into(), &"E1.L1.O1".into()));
    assert_eq!(feed["certified_clearance_mm"], report["electrodes"][0]["certified_clearance_mm"]);
    assert_eq!(feed["path"]["name"], "path_1.csv");
    let path_file = std::fs::read(path("out/path_1.csv")).unwrap();
    assert_eq!(feed["path"]["sha256"], files::sha256(&path_file));
    assert_eq!((&feed["minutes"], &location["position"]["a_deg"]), (&().into(), &0.0.into()), "no step is given");
    // Each point to be measured lies on the electrode, whose file is in the axes of the points.
    let stl = std::fs::read(path("out/electrode_1.stl")).unwrap();
    let corner = |at: usize| -> [f64; 3] {
        [0, 4, 8].map(|k| f64::from(f32::from_le_bytes(stl[at + k..at + k + 4].try_into().unwrap())))
    };
    let points = electrode["inspection_points"].as_array().unwrap();
    assert!(points.len() >= 12, "{points:?}");
    let off = |point: &serde_json::Value| {
        let vector = |key: &str| [0, 1, 2].map(|k| point[key][k].as_f64().unwrap());
        let (p, n) = (vector("point_mm"), vector("normal"));
        let dot = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let facets = (84..stl.len()).step_by(50);
        let off = |at: usize| {
            let normal = [0, 4, 8].map(|k| f64::from(f32::from_le_bytes(stl[at + k..at + k + 4].try_into().unwrap())));
            let corner = corner(at + 12);
            // Of the plane through a facet of the same normal.
            (dot(normal, n) > 0.9999).then(|| dot(n, [0, 1, 2].map(|k| p[k] - corner[k])).abs())
        };
        facets.filter_map(off).fold(f64::INFINITY, f64::min)
    };
    assert!(points.iter().all(|point| off(point) < 1e-3), "{points:?}");
    // The sheet of the export is that of the command, and what a template requires and the job does not have is named.
    let job_file = path("out/job.json");
    let sheet = text(&sparkpath(&["job-sheet", &job_file]).stdout).to_owned();
    assert_eq!(std::fs::read_to_string(path("out/job_sheet.txt")).unwrap(), sheet);
    let own = std::env::temp_dir().join(format!("sparkpath-{}.jinja", std::process::id()));
    std::fs::write(&own, "{% for e in electrodes %}{{ e.material|required('material of ' ~ e.id) }}{% endfor %}")
        .unwrap();
    let refused = sparkpath(&["job-sheet", &job_file, "--template", own.to_str().unwrap()]);
    std::fs::remove_file(&own).unwrap();
    assert_eq!(refused.status.code(), Some(2), "{}", text(&refused.stderr));
    assert!(text(&refused.stderr).contains("required values are missing: material of E1"), "{}", text(&refused.stderr));
    // A table turns against A.
    let balls = ["--ball", "30,7,6,4", "--ball", "0,0,0,5", "--a-axis", "0,-10", "--a-deg", "0,90"];
    let set_up = sparkpath(&[&["setup-sheet", &job_file], &balls[..]].concat());
    let sheet = text(&set_up.stdout);
    let numbers = |what: &str| -> Vec<f64> {
        let line = sheet.lines().find_map(|l| l.trim_start().strip_prefix(what));
        let line = line.unwrap_or_else(|| panic!("{what}: {}", text(&set_up.stderr)));
        line.split_whitespace().map(|word| word.parse().unwrap()).collect()
    };
    let [x, y, z] = numbers("in the axes of the job")[..] else { panic!("no place") };
    let turned = numbers("ball 1 at A 90.0000");
    assert!(turned.iter().zip([x, z + 10.0, -10.0 - y]).all(|(a, b)| (a - b).abs() < 2e-4), "{turned:?}");
    let alone = sparkpath(&["setup-sheet", &job_file, "--ball", "0,0,0,5", "--a-deg", "0,20"]);
    assert_eq!(alone.status.code(), Some(2), "{}", text(&alone.stdout));
    let over = sparkpath(&["setup-sheet", &job_file, "--ball", "0,0,0,5", "--out", &job_file]);
    assert!(text(&over.stderr).contains("would replace"), "{}", text(&over.stderr));
    let refused = sparkpath(&["setup-sheet", &job_file]);
    assert_eq!(refused.status.code(), Some(2), "{}", text(&refused.stdout));
    assert!(text(&refused.stderr).contains("there is no datum"), "{}", text(&refused.stderr));
    // The path ends in the direction of its last two rows.
    let text = String::from_utf8(path_file).unwrap();
    let rows: Vec<Vec<f64>> =
        text.lines().skip(2).map(|l| l.split(',').map(|v| v.parse().unwrap()).collect()).collect();
    let [.., before, last] = &rows[..] else { panic!("{} rows", rows.len()) };
    let way: Vec<f64> = (2..5).map(|k| last[k] - before[k]).collect();
    let length = way.iter().map(|v| v * v).sum::<f64>().sqrt();
    let approach: Vec<f64> = location["approach"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
    let along: f64 = approach.iter().zip(&way).map(|(a, w)| a * w / length).sum();
    assert!((along - 1.0).abs() < 1e-6, "{approach:?} {way:?}");
}

#[test]
fn a_project_says_which_files_are_written() {
    let folder = tempfile::tempdir().unwrap();
    let file = job(folder.path(), COMES_OUT);
    let choices = NO_PICTURES.replace("pictures = false", "nc = false\npictures = false");
    add(&file, &("[export]\nframe = \"w\"\n".to_owned() + &choices));
    let out = folder.path().join("out");
    let output = sparkpath(&["plan", &file, "--out", out.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let mut names: Vec<String> =
        std::fs::read_dir(&out).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    let written = [
        "centroid_1.csv",
        "copying_1.csv",
        "electrode_1.stl",
        "export_manifest.toml",
        "inscribed_circles.csv",
        "job.csv",
        "job.json",
        "job.xml",
        "job_sheet.txt",
        "leftover.ply",
        "measuring_points.csv",
        "nodes_1.csv",
        "path_1.csv",
        "report.html",
        "report.json",
        "wall_distances_1.csv",
    ];
    assert_eq!(names, written);
    let report: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(out.join("report.json")).unwrap()).unwrap();
    assert_eq!(report["written"]["electrode_frame"], "w");
    assert_eq!(report["written"]["not_asked_for"], serde_json::json!(["step", "nc", "pictures"]));
}

/// The same parameters on the command line and in a project.
#[test]
fn a_bare_mesh_with_settings_gives_the_same_bytes_as_a_project() {
    let folder = tempfile::tempdir().unwrap();
    let (part, out) = (part(folder.path()), folder.path().join("out"));
    let mut arguments = vec!["plan", &part, "--out", out.to_str().unwrap()];
    for setting in [
        "blisk.units=mm",
        "electrode.enter=-x",
        "electrode.circumferential_reduction_deg[0]=2.8",
        "electrode.circumferential_reduction_deg[1]=2.8",
        "plan.step_mm=1.6",
        "plan.field_cell_mm=0.5",
        "genetic.population=16",
        "genetic.generations=6",
        "export.files.pictures=false",
        "setting.x_mm=0.002",
        "setting.y_mm=0.002",
        "setting.z_mm=0.002",
        "setting.a_deg=0.001",
        "setting.b_deg=0.001",
        "setting.c_deg=0.001",
    ] {
        arguments.extend(["--set", setting]);
    }
    let output = sparkpath(&arguments);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    for name in ["electrode_1.stl", "path_1.csv", "path_1.nc"] {
        let read = |file: &Path| std::fs::read(file).unwrap();
        assert!(read(&out.join(name)) == read(path(&format!("out/{name}")).as_ref()), "{name}");
    }
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
    // A curved electrode that fills its channel.
    let electrode = "circumferential_reduction_deg = [0.0, 0.0]\nradial_reduction_mm = 0.0";
    let file = job_for(&curved_blisk(), folder.path(), electrode);
    add(&file, NO_PICTURES);
    let greedy = std::fs::read_to_string(&file).unwrap().replace("[plan]", "[plan]\nstrategy = \"free-travel\"");
    std::fs::write(&file, greedy).unwrap();
    let out = folder.path().join("out");
    std::fs::create_dir(&out).unwrap();
    std::fs::write(out.join("path_1.nc"), "an older program").unwrap();
    let output = sparkpath(&["plan", &file, "--out", out.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(3), "{}", text(&output.stderr));
    let report = std::fs::read_to_string(out.join("report.json")).unwrap();
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    let electrode = &report["electrodes"][0];
    assert_eq!((&electrode["verified"], &report["verdict"]["exit_code"]), (&false.into(), &3.into()));
    let failure = &electrode["failure"];
    assert!(failure["sentence"].as_str().unwrap().contains("jams at node"), "{failure}");
    assert!(failure["wall"].is_string() && failure["place"].as_array().is_some_and(|p| p.len() == 3));
    assert!(!out.join("path_1.nc").exists(), "no program stays that does not belong to these results");
}

#[test]
fn an_electrode_of_ones_own_is_planned_like_a_derived_one() {
    let folder = tempfile::tempdir().unwrap();
    let own = path("out/electrode_1.stl");
    let file = job(folder.path(), &format!("mesh = '{own}'"));
    let out = folder.path().join("out");
    #[cfg(target_os = "linux")]
    let sparkpath = blind;
    let output = sparkpath(&["plan", &file, "--out", out.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    #[cfg(target_os = "linux")]
    pictures::without_a_graphics_driver_a_plan_is_written_all_the_same(&out);
    let read = |folder: &Path, name: &str| std::fs::read(folder.join(name)).unwrap();
    assert_eq!(read(&out, "electrode_1.stl").len(), std::fs::read(&own).unwrap().len(), "as many triangles");
    let report: serde_json::Value = serde_json::from_slice(&read(&out, "report.json")).unwrap();
    let theirs: serde_json::Value = serde_json::from_slice(&std::fs::read(path("out/report.json")).unwrap()).unwrap();
    let volume = |r: &serde_json::Value| r["electrodes"][0]["volume_mm3"].as_f64().unwrap();
    assert!((volume(&report) / volume(&theirs) - 1.0).abs() < 1e-6);
    assert_eq!(
        (&report["electrodes"][0]["verified"], &report["inputs"][1]["role"]),
        (&true.into(), &"electrode".into())
    );
    let csv = out.join("path_1.csv");
    let part = folder.path().join("part.stl");
    let files = ["--blisk", part.to_str().unwrap(), "--electrode", &own, "--path", csv.to_str().unwrap()];
    let verified = sparkpath(&[&["verify", "--units", "mm", "--gap", "0.1"], &files[..]].concat());
    assert_eq!(verified.status.code(), Some(0), "{}{}", text(&verified.stdout), text(&verified.stderr));
}

#[test]
fn a_verification_judges_travel_if_limits_are_given_and_leaves_the_plans_report_alone() {
    let out = tempfile::tempdir().unwrap();
    let folder = out.path().to_str().unwrap().to_owned();
    std::fs::write(out.path().join("report.json"), "of a plan").unwrap();
    let (blisk, electrode, csv) = (path("part.stl"), path("out/electrode_1.stl"), path("out/path_1.csv"));
    let verify = |limits: &[&str]| {
        let files = ["--blisk", &blisk, "--electrode", &electrode, "--path", &csv, "--out", &folder];
        let output = sparkpath(&[&["verify", "--units", "mm", "--gap", "0.1"], &files[..], limits].concat());
        let report = std::fs::read(out.path().join("verify.json")).unwrap_or_default();
        (output.status.code(), serde_json::from_slice::<serde_json::Value>(&report).unwrap_or_default())
    };
    let (code, report) = verify(&[]);
    assert_eq!((code, &report["travel"]["judged"]), (Some(0), &false.into()));
    assert!(report["sentence"].as_str().unwrap().contains("not judged"));
    let (code, report) = verify(&["--travel", "X=-250,0", "--travel", "c=-360,360"]);
    assert_eq!((code, &report["travel"]["judged"], &report["travel"]["beyond"]), (Some(0), &true.into(), &().into()));
    let (code, report) = verify(&["--travel", "X=-1,1"]);
    assert_eq!((code, &report["travel"]["beyond"]["axis"]), (Some(3), &"X".into()));
    assert_eq!((&report["verified"], &report["travel"]["beyond"]["row"]), (&false.into(), &0.into()));
    assert_eq!(verify(&["--travel", "X=1,2"]).0, Some(2), "the final pose is not within");
    // Setting errors: what it bears is told, and a hundred times as much is borne by no gap of 0.1 mm.
    let (code, report) = verify(&["--setting", "0.002,0.002,0.002,0.001,0.001,0.001"]);
    let setting = &report["setting"];
    // The plan says the same, in its report and in its program.
    let plan: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(path("out/report.json")).unwrap()).unwrap();
    let of_plan = &plan["electrodes"][0]["setting"];
    let ratio = of_plan["scale"].as_f64().unwrap() / setting["scale"].as_f64().unwrap();
    assert!((ratio - 1.0).abs() < 0.02, "{of_plan} {setting}");
    let program = std::fs::read_to_string(path("out/path_1.nc")).unwrap().split_whitespace().collect::<String>();
    assert!(program.contains("settingerrorshold"), "{program}");
    assert_eq!((code, &setting["holds"]), (Some(0), &true.into()), "{setting}");
    let scale = setting["scale"].as_f64().unwrap();
    assert!((1.0..50.0).contains(&scale), "{setting}");
    assert!((setting["largest"]["y_mm"].as_f64().unwrap() - 0.002 * scale).abs() < 1e-9);
    assert!(setting["beyond"]["distance_mm"].as_f64().unwrap() < 0.07, "{setting}");
    assert!(std::fs::read_to_string(out.path().join("verify.html")).unwrap().contains("largest that hold"));
    let (code, report) = verify(&["--setting", "0.2,0.2,0.2,0.1,0.1,0.1"]);
    assert_eq!((code, &report["verified"], &report["setting"]["holds"]), (Some(3), &true.into(), &false.into()));
    assert_eq!(verify(&["--setting", "0.2,0.2"]).0, Some(2));
    assert_eq!(verify(&["--setting", "1,0,0,0,0,0", "--accuracy", "0.1"]).0, Some(2), "nothing would be left");
    assert_eq!(std::fs::read_to_string(out.path().join("report.json")).unwrap(), "of a plan");
    assert!(out.path().join("verify.html").is_file());
}

#[test]
fn an_electrode_in_w_is_told_from_a_collision() {
    let folder = tempfile::tempdir().unwrap();
    let (blisk, csv, right) = (path("part.stl"), path("out/path_1.csv"), path("out/electrode_1.stl"));
    let path = nc::path_csv::read_path_csv(&std::fs::read_to_string(&csv).unwrap()).unwrap();
    let options = import::ImportOptions { reading: import::Units::Mm.into(), ..Default::default() };
    let electrode = import::import_file(Path::new(&right), &options, &Task::default());
    let in_w = folder.path().join("w.stl");
    write_stl(&in_w, &electrode.unwrap().mesh.in_frame(&path.frame)).unwrap();
    let verify = |electrode: &str, gap: &str| {
        let files = ["verify", "--blisk", &blisk, "--electrode", electrode, "--path", &csv];
        let output = sparkpath(&[&files, &["--units", "mm", "--gap", gap][..]].concat());
        (output.status.code(), text(&output.stdout))
    };
    let (code, said) = verify(in_w.to_str().unwrap(), "0.1");
    assert!(code == Some(3) && said.contains("is in W"), "{said}");
    let (code, said) = verify(&right, "0.3");
    assert!(code == Some(3) && !said.contains("is in W"), "{said}");
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
        (plan("no-such.sparkpath"), "no-such.sparkpath"),
        (plan("no-such.stl"), "no-such.stl"),
        (plan(&at("a.sparkpath", "kind = \"blisk\"\n[blisk]\nmesh = \"absent.stl\"\n")), "absent.stl"),
        (plan(&at("b.sparkpath", "kind = \"blisk\"\n[blisk]\nmesh = \"a.toml\"\n[plan]\nstep = 1\n")), "plan.step: "),
        (plan(&at("c.sparkpath", "kind = \"blisk\"\n[blisk]\nmesh = \"c.sparkpath\"\n")), "c.sparkpath"),
        (plan(&at("d.sparkpath", "kind = \"blisk\"\n[blisk]\nblades = 23\n")), "--set blisk.mesh=FILE"),
        (plan(&at("e.sparkpath", "[blisk]\nmesh = \"a.stl\"\n")), "kind: it is missing; write"),
        (plan(&at("f.sparkpath", "kind = \"mold\"\n")), "must be \"blisk\" here"),
        (plan(&at("g.toml", "[blisk]\nmesh = \"a.stl\"\n")), "kind = \"blisk\""),
        (
            sparkpath(&["plan", "a.stl", "--out", &out, "--set", "electrode.parts=many"]),
            "electrode.parts is many: must be",
        ),
        (sparkpath(&["plan", "a.stl", "--out", &out, "--set", "electrode.prts=2"]), "did you mean electrode.parts?"),
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
    // Until the first line of progress it may not yet listen.
    let (code, _) = simulate::interrupted_at("", &["plan", &file, "--out", out.to_str().unwrap()]);
    assert_eq!(code, Some(130));
    assert!(!out.exists());
}

#[test]
fn progress_and_answer_are_json_when_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let part = part(folder.path());
    let output = sparkpath(&["inspect", &part, "--json", "--threads", "1"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let answer: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(answer["blisk"]["channel"]["shrouded"], true);
    for line in text(&output.stderr).lines() {
        let progress: serde_json::Value = serde_json::from_str(line).unwrap();
        assert!(progress["stage"].is_string() && progress["fraction"].as_f64().is_some_and(|f| f <= 1.0));
    }
}

#[test]
fn mistakes_are_one_json_line_when_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let cube = folder.path().join("cube.stl");
    std::fs::write(&cube, CUBE).unwrap();
    for (arguments, named) in [
        (vec!["--json", "fly"], "fly"),
        (vec!["plan", "no-such.sparkpath", "--out", "x", "--json"], "no-such.sparkpath"),
        (vec!["inspect", cube.to_str().unwrap(), "--json"], "cube.stl"),
    ] {
        let output = sparkpath(&arguments);
        assert_eq!(output.status.code(), Some(2));
        let lines: Vec<serde_json::Value> =
            text(&output.stderr).lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        let errors: Vec<_> = lines.iter().filter(|line| line.get("error").is_some()).collect();
        assert_eq!((errors.len(), &errors[0]["exit_code"]), (1, &2.into()));
        assert!(errors[0]["error"].as_str().unwrap().contains(named), "{errors:?}");
    }
}

#[test]
fn inspect_names_the_keys_that_help() {
    let folder = tempfile::tempdir().unwrap();
    let cube = folder.path().join("cube.stl");
    std::fs::write(&cube, CUBE).unwrap();
    let output = sparkpath(&["inspect", cube.to_str().unwrap()]);
    let (said, error) = (text(&output.stdout), text(&output.stderr));
    // The reason stands in the verdict, once.
    assert!(said.matches("blisk.axis").count() == 1 && !said.contains("[blisk]"), "{said}");
    assert!(error.contains("verdict") && !error.contains("blisk.axis"), "{error}");
}

/// A cube of 20 mm as ASCII STL.
const CUBE: &str = include_str!("data/cube.stl");
