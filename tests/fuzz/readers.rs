//! Readers of files. An error tells something in one line; what is read can be used.

use std::path::Path;

use import::{ImportLimits, ImportOptions, Units, import_bytes};
use nc::template::{JobSheet, Template, Templated};
use sparkpath::workspaces::blisk::document::{job_file::PlanJob, machine_file};
use sparkpath::workspaces::flank::document::FlankDocument;
use sparkpath::workspaces::mold::document::MoldParams;
use task::Task;

use super::mesh_files::{every_format, part};
use super::target::Target;

/// Reads changed versions of `seeds`.
fn files(
    inputs: u64,
    seeds: impl IntoIterator<Item: Into<Vec<u8>>>,
    read: impl Fn(&[u8]) -> bool + Send + Sync + 'static,
) -> Target {
    Target { inputs, seeds: seeds.into_iter().map(Into::into).collect(), check: Box::new(read) }
}

/// Reads changed versions of texts.
fn texts(
    inputs: u64,
    seeds: impl IntoIterator<Item: Into<Vec<u8>>>,
    read: impl Fn(&str) -> bool + Send + Sync + 'static,
) -> Target {
    files(inputs, seeds, move |bytes| read(&String::from_utf8_lossy(bytes)))
}

/// Reads changed versions of texts as files with an ending.
fn paths(
    inputs: u64,
    ending: &str,
    seeds: impl IntoIterator<Item: Into<Vec<u8>>>,
    read: impl Fn(&Path) -> bool + Send + Sync + 'static,
) -> Target {
    let folder = tempfile::tempdir().unwrap();
    let name = format!("input.{ending}");
    files(inputs, seeds, move |bytes| {
        let file = folder.path().join(&name);
        std::fs::write(&file, bytes).unwrap();
        read(&file)
    })
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

fn mesh(name: &str, bytes: &[u8]) -> bool {
    let reading = Units::Mm.into();
    let options = ImportOptions {
        reading,
        limits: ImportLimits { max_triangles: 100_000, ..Default::default() },
        ..Default::default()
    };
    let Some(imported) = told(import_bytes(name, bytes, &options, &Task::default())) else { return false };
    let corners = imported.mesh.triangles.iter().flatten();
    assert!(corners.into_iter().all(|corner| (*corner as usize) < imported.mesh.vertices.len()));
    assert!(imported.mesh.vertices.iter().all(|p| p.is_finite()));
    true
}

pub fn meshes() -> Target {
    let more = [&include_bytes!("../data/cube.stl")[..], include_bytes!("../data/molds/a_square.stl")];
    let seeds = every_format(&part()).into_iter().map(|(_, bytes)| bytes).chain(more.map(<[u8]>::to_vec));
    files(2000, seeds, |bytes| mesh("part.mesh", bytes))
}

pub fn step_files() -> Target {
    let mesh_of_box = part();
    let of_box = step::write::StepPart {
        name: "box",
        mesh: &mesh_of_box,
        roles: &[],
        role_of: &[],
        patches: &[],
        properties: &[],
    };
    let settings = step::write::StepSettings::default();
    let seed = step::write::write_step(&of_box, &settings, &Task::default()).unwrap().bytes;
    files(300, [seed], |bytes| mesh("part.step", bytes))
}

pub fn points_of_scans() -> Target {
    let seeds = [
        "x,y,z\n1,2,3\n4,5,6\n",
        "1.5 2.5 3.5\n1 2 3\n",
        "X;Y;Z\n1,5;2,5;3,5\n",
        "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nend_header\n1 2 3\n4 5 6\n",
    ];
    let limits = measured::points::PointLimits::default();
    texts(2000, seeds, move |text| {
        told(measured::points::points_from_bytes("scan", text.as_bytes(), &limits, &Task::default())).is_some()
    })
}

pub fn guides_of_ruled_surfaces() -> Target {
    let seeds = ["x,y,z\n0,0,0\n1,0,0.1\n2,0,0\n3,1,0\n4,2,1\n", "# guide\n0 0 0\n1 1 1\n2 2 4\n3 3 9\n"];
    texts(2000, seeds, move |text| told(flank::guide::GuideCurve::from_csv(text)).is_some())
}

pub fn measured_sections() -> Target {
    let mut text = "section,side,x,y,z\n".to_owned();
    for (section, z) in [(1, 100.0), (2, 110.0), (3, 120.0)] {
        for (side, y) in [("low", 0.0), ("high", 9.0)] {
            (0..6).for_each(|i| text += &format!("{section},{side},{},{},{z}\n", 4 * i, y + 0.1 * f64::from(i * i)));
        }
    }
    let seeds = [text.as_str(), "section,side,x,r,theta_deg\n1,low,0,100,0\n"];
    texts(1000, seeds, move |text| told(wheel::sections::read_sections(text)).is_some())
}

pub fn path_tables() -> Target {
    let path = nc::fixtures::path();
    let clearance = vec![0.2; path.rows.len()];
    let text = nc::path_csv::write_path_csv(&path, &clearance).unwrap();
    texts(1000, [text], |text| {
        let Some(read) = told(nc::path_csv::read_path_csv(text)) else { return false };
        assert!(read.rows.iter().all(|row| row.s.is_finite()), "a path is made of numbers");
        true
    })
}

/// Projects that are read are saved as what is read again.
fn project<P: files::Params + PartialEq + std::fmt::Debug>(text: &str) -> bool {
    let folder = Path::new("/folder");
    let Some(document) = told(files::Document::<P>::parse(text, folder)) else { return false };
    let saved = document.text(&folder.join("project")).unwrap_or_else(|error| panic!("cannot be saved: {error}"));
    let again = files::Document::<P>::parse(&saved, folder).unwrap_or_else(|error| panic!("{error}\n{saved}"));
    assert_eq!(again.params(), document.params(), "{saved}");
    true
}

pub fn projects_of_blisks() -> Target {
    let staged = "kind = \"blisk\"\n[blisk]\nmesh = \"a.stl\"\n[electrode]\nparts = 2\n[[electrode.part]]\nuntil = 0.4\n\
                  [[electrode.stage]]\nname = \"rough\"\nspark_gap_mm = 0.3\nparts = 1\n[[electrode.stage]]\nname = \"finish\"\n";
    texts(400, [include_str!("../../assets/demonstration.sparkpath"), staged], project::<PlanJob>)
}

pub fn projects_of_molds() -> Target {
    texts(400, [include_str!("../../assets/mold.sparkpath"), "kind = \"mold\"\n[mold]\n"], project::<MoldParams>)
}

pub fn projects_of_flanks() -> Target {
    let every_key = toml::to_string(&FlankDocument::default()).unwrap();
    texts(400, [format!("kind = \"flank\"\n{every_key}")], project::<FlankDocument>)
}

pub fn jobs() -> Target {
    let seeds: Vec<String> =
        nc::job_file::JobFile::examples().iter().map(|job| serde_json::to_string_pretty(job).unwrap()).collect();
    paths(500, "json", seeds, move |file| {
        let Some(job) = told(nc::job_file::JobFile::read(file)) else { return false };
        told(JobSheet::standard().of(&job)).is_some()
    })
}

fn machine(file: &Path) -> bool {
    let file = file.display().to_string();
    let has_axes = told(machine_file::machine_table(&file)).is_some();
    told(machine_file::read_machine(&file, &Task::default())).is_some() && has_axes
}

pub fn machines() -> Target {
    let seeds = [include_str!("../../assets/machines/xyzac.toml"), include_str!("../../assets/machines/xyzabc.toml")];
    paths(300, "toml", seeds, machine)
}

pub fn machines_of_robots() -> Target {
    paths(500, "urdf", [include_str!("../data/machine.urdf")], machine)
}

pub fn milling_machines() -> Target {
    paths(500, "toml", [include_str!("../../assets/milling_machines.toml")], |file| {
        told(sparkpath::workspaces::flank::document::milling_machine_file::read_milling_machines(file)).is_some()
    })
}

pub fn posts() -> Target {
    let seeds = [
        include_str!("../../assets/posts/iso.toml"),
        include_str!("../../assets/posts/beckhoff-edm.toml"),
        include_str!("../../assets/posts/milling-tcp.toml"),
    ];
    texts(500, seeds, move |text| told(nc::post::Post::from_toml(text, "post.toml")).is_some())
}

fn template<T: Templated>(file: &Path) -> bool {
    told(Template::<T>::read(file)).is_some()
}

pub fn templates_of_burn_tables() -> Target {
    paths(100, "jinja", [include_str!("../../assets/burn_table.jinja")], template::<nc::burn_table::BurnTable>)
}

pub fn templates_of_job_sheets() -> Target {
    paths(100, "jinja", [include_str!("../../assets/job_sheet.jinja")], template::<nc::job_file::JobFile>)
}

pub fn libraries_of_cutters() -> Target {
    texts(500, [include_str!("../../assets/cutters/standard.toml")], |text| {
        told(sparkpath::workspaces::mold::document::cutter_file::CUTTERS.parse(text, Path::new("cutters.toml")))
            .is_some()
    })
}

pub fn lists_of_flank_cutters() -> Target {
    texts(500, [include_str!("../../assets/cutters/flank.toml")], |text| {
        told(sparkpath::workspaces::flank::document::cutter_list::CUTTERS.parse(text, Path::new("cutters.toml")))
            .is_some()
    })
}

pub fn words_for_cutters() -> Target {
    texts(2000, ["flat:1/6/5,ball:0.5,bull:3/0.5"], |text| {
        text.split(',').filter(|word| told(word.parse::<mold::cutter::Cutter>()).is_some()).count() > 0
    })
}

pub fn lists_of_holders() -> Target {
    paths(500, "toml", [include_str!("../../assets/holders.toml")], |file| {
        told(sparkpath::workspaces::mold::document::holder_files::read_holders(file)).is_some()
    })
}

pub fn technology_tables() -> Target {
    texts(300, [include_str!("../../assets/technology.toml")], |text| {
        told(burning::technology::TECHNOLOGY_FILE.parse(text, Path::new("technology.toml"))).is_some()
    })
}

pub fn tables_of_presets() -> Target {
    let seeds = [
        "electrode,x_mm,y_mm,z_mm,c_deg,uncertainty_mm,date,wear_mm\n1,0.1,-0.2,0.05,0.5,0.003,2026-01-01,0.02\n2,0,0,0,0,0,,\n",
    ];
    paths(1000, "csv", seeds, move |file| told(sparkpath::workspaces::blisk::job::preset::read_presets(file)).is_some())
}
