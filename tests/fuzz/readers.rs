//! Readers of files. An error tells something in one line; what is read can be used.

use std::path::Path;
use std::sync::OnceLock;

use import::{ImportLimits, ImportOptions, Units, import_bytes};
use nc::template::{BurnSheet, JobSheet, Template, Templated};
use sparkpath::workspaces::blisk::document::job_file::PlanJob;
use sparkpath::workspaces::flank::document::FlankDocument;
use sparkpath::workspaces::mold::document::MoldParams;
use task::Task;

use super::campaign;
use super::mesh_files::{every_format, part};
use super::mutate::mutated;

/// An input in readable form.
fn shown(bytes: &[u8]) -> String {
    let most = if super::number("FUZZ_INPUT").is_some() { usize::MAX } else { 4000 };
    String::from_utf8_lossy(bytes).chars().take(most).flat_map(char::escape_debug).collect()
}

/// Reads `own` changed versions of `seeds`.
fn fuzz(own: u64, seeds: Vec<Vec<u8>>, read: impl Fn(&[u8])) {
    // What is not changed is read as well.
    seeds.iter().for_each(|seed| read(seed));
    campaign(own, |random| mutated(&seeds, random), |bytes| read(bytes), |bytes| shown(bytes));
}

/// Reads changed versions of texts.
fn fuzz_text(own: u64, seeds: &[&str], read: impl Fn(&str)) {
    let seeds = seeds.iter().map(|seed| seed.as_bytes().to_vec()).collect();
    fuzz(own, seeds, |bytes| read(&String::from_utf8_lossy(bytes)));
}

/// Reads changed versions of texts as files with an ending.
fn fuzz_file(own: u64, ending: &str, seeds: &[&str], read: impl Fn(&Path)) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join(format!("input.{ending}"));
    let seeds = seeds.iter().map(|seed| seed.as_bytes().to_vec()).collect();
    fuzz(own, seeds, |bytes| {
        std::fs::write(&file, bytes).unwrap();
        read(&file);
    });
}

/// An error that a person can use: one line, and not empty.
fn told<T, E: std::fmt::Display>(answer: Result<T, E>) -> Option<T> {
    match answer {
        Ok(read) => Some(read),
        Err(error) => {
            let said = error.to_string();
            assert!(!said.trim().is_empty() && said.len() < 20_000, "{said:?}");
            None
        }
    }
}

fn mesh(name: &str, bytes: &[u8]) {
    let reading = Units::Mm.into();
    let options = ImportOptions {
        reading,
        limits: ImportLimits { max_triangles: 100_000, ..Default::default() },
        ..Default::default()
    };
    let Some(imported) = told(import_bytes(name, bytes, &options, &Task::default())) else { return };
    let corners = imported.mesh.triangles.iter().flatten();
    assert!(corners.into_iter().all(|corner| (*corner as usize) < imported.mesh.vertices.len()));
    assert!(imported.mesh.vertices.iter().all(|p| p.is_finite()));
}

#[test]
fn meshes_in_every_format() {
    let seeds = every_format(&part()).into_iter().map(|(_, bytes)| bytes).collect();
    fuzz(2000, seeds, |bytes| mesh("part.mesh", bytes));
}

/// A box as STEP.
fn step_of_box() -> &'static [u8] {
    static STEP: OnceLock<Vec<u8>> = OnceLock::new();
    STEP.get_or_init(|| {
        let mesh = part();
        let of_box =
            step::write::StepPart { name: "box", mesh: &mesh, roles: &[], role_of: &[], patches: &[], properties: &[] };
        step::write::write_step(&of_box, &step::write::StepSettings::default(), &Task::default()).unwrap().bytes
    })
}

#[test]
fn step_files() {
    fuzz(300, vec![step_of_box().to_vec()], |bytes| mesh("part.step", bytes));
}

#[test]
fn points_of_scans() {
    let seeds = [
        "x,y,z\n1,2,3\n4,5,6\n",
        "1.5 2.5 3.5\n1 2 3\n",
        "X;Y;Z\n1,5;2,5;3,5\n",
        "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nend_header\n1 2 3\n4 5 6\n",
    ];
    let limits = measured::points::PointLimits::default();
    fuzz_text(2000, &seeds, |text| {
        told(measured::points::points_from_bytes("scan", text.as_bytes(), &limits, &Task::default()));
    });
}

#[test]
fn guides_of_ruled_surfaces() {
    let seeds = ["x,y,z\n0,0,0\n1,0,0.1\n2,0,0\n3,1,0\n4,2,1\n", "# guide\n0 0 0\n1 1 1\n2 2 4\n3 3 9\n"];
    fuzz_text(2000, &seeds, |text| {
        told(flank::guide::GuideCurve::from_csv(text));
    });
}

#[test]
fn measured_sections() {
    let mut text = "section,side,x,y,z\n".to_owned();
    for (section, z) in [(1, 100.0), (2, 110.0), (3, 120.0)] {
        for (side, y) in [("low", 0.0), ("high", 9.0)] {
            (0..6).for_each(|i| text += &format!("{section},{side},{},{},{z}\n", 4 * i, y + 0.1 * f64::from(i * i)));
        }
    }
    let seeds = [text.as_str(), "section,side,x,r,theta_deg\n1,low,0,100,0\n"];
    fuzz_text(1000, &seeds, |text| {
        told(wheel::sections::read_sections(text));
    });
}

#[test]
fn path_tables() {
    let path = nc::fixtures::path();
    let clearance = vec![0.2; path.rows.len()];
    let text = nc::path_csv::write_path_csv(&path, &clearance).unwrap();
    fuzz_text(1000, &[&text], |text| {
        let Some(read) = told(nc::path_csv::read_path_csv(text)) else { return };
        assert!(read.rows.iter().all(|row| row.s.is_finite()), "a path is made of numbers");
    });
}

/// Projects that are read are saved as what is read again.
fn project<P: files::Params + PartialEq + std::fmt::Debug>(text: &str) {
    let folder = Path::new("/folder");
    let Some(document) = told(files::Document::<P>::parse(text, folder)) else { return };
    let saved = document.text(&folder.join("project")).unwrap_or_else(|error| panic!("cannot be saved: {error}"));
    let again = files::Document::<P>::parse(&saved, folder).unwrap_or_else(|error| panic!("{error}\n{saved}"));
    assert_eq!(again.params(), document.params(), "{saved}");
}

#[test]
fn projects_of_blisks() {
    let staged = "kind = \"blisk\"\n[blisk]\nmesh = \"a.stl\"\n[electrode]\nparts = 2\n[[electrode.part]]\nuntil = 0.4\n\
                  [[electrode.stage]]\nname = \"rough\"\nspark_gap_mm = 0.3\nparts = 1\n[[electrode.stage]]\nname = \"finish\"\n";
    fuzz_text(400, &[include_str!("../../assets/demonstration.sparkpath"), staged], project::<PlanJob>);
}

#[test]
fn projects_of_molds() {
    fuzz_text(400, &[include_str!("../../assets/mold.sparkpath"), "kind = \"mold\"\n[mold]\n"], project::<MoldParams>);
}

#[test]
fn projects_of_flanks() {
    fuzz_text(400, &["kind = \"flank\"\n[surface]\nside = \"positive\"\n[cutter]\n"], project::<FlankDocument>);
}

#[test]
fn jobs() {
    let seeds: Vec<String> =
        nc::job_file::JobFile::examples().iter().map(|job| serde_json::to_string_pretty(job).unwrap()).collect();
    let seeds: Vec<&str> = seeds.iter().map(String::as_str).collect();
    fuzz_file(500, "json", &seeds, |file| {
        let Some(job) = told(nc::job_file::JobFile::read(file)) else { return };
        told(JobSheet::standard().of(&job));
    });
}

const URDF: &str = r#"<robot name="m"><link name="base"/><link name="x"><collision><geometry><box size="1 2 3"/></geometry></collision></link>
<joint name="X" type="prismatic"><parent link="base"/><child link="x"/><axis xyz="1 0 0"/><limit lower="-1" upper="1" velocity="1" effort="1"/></joint></robot>"#;

#[test]
fn machines() {
    let seeds = [include_str!("../../assets/machines/xyzac.toml"), include_str!("../../assets/machines/xyzabc.toml")];
    let read = |file: &Path| {
        told(sparkpath::workspaces::blisk::document::machine_file::read_machine(
            &file.display().to_string(),
            &Task::default(),
        ));
    };
    fuzz_file(300, "toml", &seeds, read);
    fuzz_file(500, "urdf", &[URDF], read);
}

#[test]
fn milling_machines() {
    fuzz_file(500, "toml", &[include_str!("../../assets/milling_machines.toml")], |file| {
        told(sparkpath::workspaces::flank::document::milling_machine_file::read_milling_machines(file));
    });
}

#[test]
fn posts() {
    let seeds = [
        include_str!("../../assets/posts/iso.toml"),
        include_str!("../../assets/posts/beckhoff-edm.toml"),
        include_str!("../../assets/posts/milling-tcp.toml"),
    ];
    fuzz_text(500, &seeds, |text| {
        told(nc::post::Post::from_toml(text, "post.toml"));
    });
}

fn template<T: Templated>(file: &Path) {
    told(Template::<T>::read(file));
}

#[test]
fn templates() {
    fuzz_file(100, "jinja", &[include_str!("../../assets/burn_table.jinja")], template::<nc::burn_table::BurnTable>);
    fuzz_file(100, "jinja", &[include_str!("../../assets/job_sheet.jinja")], template::<nc::job_file::JobFile>);
    let _ = BurnSheet::standard();
}

#[test]
fn libraries_of_cutters() {
    let file = Path::new("cutters.toml");
    fuzz_text(500, &[include_str!("../../assets/cutters/standard.toml")], |text| {
        told(sparkpath::workspaces::mold::document::cutter_file::CUTTERS.parse(text, file));
    });
    fuzz_text(500, &[include_str!("../../assets/cutters/flank.toml")], |text| {
        told(sparkpath::workspaces::flank::document::cutter_list::CUTTERS.parse(text, file));
    });
    fuzz_text(2000, &["flat:1/6/5,ball:0.5,bull:3/0.5"], |text| {
        text.split(',').for_each(|word| drop(told(word.parse::<mold::cutter::Cutter>())));
    });
}

#[test]
fn lists_of_holders() {
    fuzz_file(500, "toml", &[include_str!("../../assets/holders.toml")], |file| {
        told(sparkpath::workspaces::mold::document::holder_files::read_holders(file));
    });
}

#[test]
fn technology_tables() {
    fuzz_text(300, &[include_str!("../../assets/technology.toml")], |text| {
        told(burning::technology::TECHNOLOGY_FILE.parse(text, Path::new("technology.toml")));
    });
}

#[test]
fn tables_of_presets() {
    let seeds = [
        "electrode,x_mm,y_mm,z_mm,c_deg,uncertainty_mm,date,wear_mm\n1,0.1,-0.2,0.05,0.5,0.003,2026-01-01,0.02\n2,0,0,0,0,0,,\n",
    ];
    fuzz_file(1000, "csv", &seeds, |file| {
        told(sparkpath::workspaces::blisk::job::preset::read_presets(file));
    });
}
