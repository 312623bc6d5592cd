//! What is exported is what was chosen, in the frame that was chosen.

use sparkpath::workspaces::blisk::BliskWorkspace;
use std::collections::BTreeSet;
use std::path::Path;

use egui::Role;
use files::AnyDocument as _;
use geometry::frame::Frame;
use import::{ImportOptions, import_file, write_stl};
use nc::post::BUILT_IN;
use sparkpath::shell::run::Opening;
use sparkpath::workspaces::blisk::document::choice::{DrawnPictures, MeshFrame};
use sparkpath::workspaces::blisk::document::stage::Stage;
use task::{State, Task};

use crate::common::{easy_blisk, mesh};
use crate::desk::{Desk, Home, quick};
use crate::made_once::made_once;

/// A window with a released plan that was not finished, for a channel that stands askew to the axes of the mesh.
pub fn released(home: &Home) -> Desk {
    released_after(home, &|desk| {
        let core = desk.blisk_mut();
        core.work.cancel();
        let mut job = core.document.params().clone();
        job.export.files.pictures = false;
        job.export.pictures =
            DrawnPictures { whole: false, final_pose: false, sweep: false, closest: false, residual_stock: false };
        core.edit("Without pictures", job, false);
    })
}

/// The same with all that follows the plan.
fn released_whole(home: &Home) -> Desk {
    released_after(home, &|_| ())
}

/// A window with a released plan for a channel that stands askew to the axes of the mesh: once `planned` is done to it.
fn released_after(home: &Home, planned: &dyn Fn(&mut Desk)) -> Desk {
    let kept = made_once("askew", plan_askew);
    for name in ["part.stl", PROJECT] {
        std::fs::copy(kept.join(name), home.path(name)).unwrap();
    }
    let mut desk = home.start(Opening::File(home.path(PROJECT)));
    desk.until("the plan is there again", |d| d.state(Stage::Plan) == State::Ready);
    planned(&mut desk);
    desk.until_idle();
    desk.open_step(Stage::Export);
    desk.press("Release for export");
    desk
}

const PROJECT: &str = "askew.sparkpath";

/// Plans and writes part and project into `folder`.
fn plan_askew(folder: &Path) {
    let (home, part) = (Home::new(), folder.join("part.stl"));
    write_stl(&part, &mesh(&easy_blisk())).unwrap();
    let mut desk = home.start(Opening::File(part));
    desk.until_idle();
    let core = desk.blisk_mut();
    let mut job = quick(core.document.params().clone());
    job.blisk.options.channel = 5;
    job.electrode.circumferential_reduction_deg = [3.0, 3.0];
    job.electrode.radial_reduction_mm = 1.0;
    core.edit("Job", job, false);
    desk.until_idle();
    desk.key(egui::Key::F5);
    desk.until("the plan is done", |d| d.state(Stage::Plan) == State::Ready);
    desk.blisk_mut().document.save_as(&folder.join(PROJECT)).unwrap();
}

/// Exports into `folder` and answers the names of what is there beside the manifest.
pub fn export(desk: &mut Desk, folder: &Path) -> BTreeSet<String> {
    desk.window.state_mut().act(|blisk: &mut BliskWorkspace, cx| blisk.export(folder, cx));
    desk.until_idle();
    assert_eq!(desk.state(Stage::Export), State::Ready, "{:#?}", desk.log());
    let files = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().to_string_lossy().into_owned());
    let (manifest, names): (BTreeSet<String>, BTreeSet<String>) = files.partition(|name| name == files::MANIFEST);
    assert_eq!(manifest.len(), 1);
    names
}

fn names(names: &[&str]) -> BTreeSet<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}

fn report(folder: &Path) -> serde_json::Value {
    serde_json::from_str(&std::fs::read_to_string(folder.join("report.json")).unwrap()).unwrap()
}

fn triangles(file: &Path) -> Vec<[glam::DVec3; 3]> {
    let imported = import_file(file, &ImportOptions::default(), &Task::default()).unwrap();
    let mesh = imported.mesh;
    mesh.triangles.iter().map(|t| t.map(|i| mesh.vertices[i as usize])).collect()
}

#[test]
fn what_is_written_is_what_was_ticked() {
    let home = Home::new();
    let mut desk = released_whole(&home);
    let folder = home.path("out");
    let everything = names(&[
        "electrode_1.stl",
        "path_1.csv",
        "path_1.nc",
        "job.csv",
        "job.json",
        "job.xml",
        "job_sheet.txt",
        "measuring_points.csv",
        "report.html",
        "report.json",
        "centroid_1.csv",
        "inscribed_circles.csv",
        "nodes_1.csv",
        "wall_distances_1.csv",
        "view_1_whole.png",
        "electrode_1_final.png",
        "electrode_1_sweep.png",
        "electrode_1_closest.png",
        "copying_1.csv",
        "leftover.ply",
        "view_2_leftover.png",
    ]);
    assert_eq!(export(&mut desk, &folder), everything);
    let written = &report(&folder)["written"];
    assert_eq!((&written["electrode_frame"], &written["post"]), (&"mesh".into(), &"iso".into()));
    let listed = written["files"].as_array().unwrap().iter().map(|name| name.as_str().unwrap().to_owned());
    assert_eq!(listed.collect::<BTreeSet<_>>(), everything);
    assert_eq!(written["not_asked_for"], serde_json::json!(["step"]));

    desk.press("Export…");
    for file in ["path_K.nc", "path_K.csv", "leftover.ply, copying_K.csv", "*.png", "Sweep"] {
        desk.press_role(Role::CheckBox, file);
    }
    desk.press_role(Role::Button, "Cancel");
    assert!(desk.blisk().work.released().is_some(), "what is written has nothing to do with what was released");
    let tables = [
        "job.csv",
        "job.json",
        "job.xml",
        "job_sheet.txt",
        "measuring_points.csv",
        "centroid_1.csv",
        "inscribed_circles.csv",
        "nodes_1.csv",
        "wall_distances_1.csv",
    ];
    let left = names(&[&["electrode_1.stl", "report.html", "report.json"], &tables[..]].concat());
    assert_eq!(export(&mut desk, &folder), left, "what an earlier export wrote is not left beside");
    let html = std::fs::read_to_string(folder.join("report.html")).unwrap();
    assert_eq!(html.matches("<img ").count(), 4, "the page holds the pictures that are drawn");
    assert_eq!(
        report(&folder)["written"]["not_asked_for"],
        serde_json::json!(["step", "path", "nc", "leftover", "pictures"])
    );

    desk.press("Export…");
    for file in ["electrode_K.stl", "report.html, .json"] {
        desk.press_role(Role::CheckBox, file);
    }
    desk.assert_shows("No file is chosen: nothing would be written.");
}

#[test]
fn an_electrode_in_w_is_that_of_the_mesh_seen_from_w() {
    let home = Home::new();
    let mut desk = released(&home);
    let [in_mesh, in_w] = [home.path("mesh"), home.path("w")];
    export(&mut desk, &in_mesh);
    let core = desk.blisk_mut();
    let mut job = core.document.params().clone();
    job.export.frame = MeshFrame::W;
    core.edit("Frame", job, false);
    desk.until_idle();
    export(&mut desk, &in_w);
    let frame: Frame = serde_json::from_value(report(&in_w)["blisk"]["frame"].clone()).unwrap();
    assert!((frame.z - glam::DVec3::Z).length() > 0.5, "the frames differ: {frame:?}");
    let (of_mesh, of_w) = (triangles(&in_mesh.join("electrode_1.stl")), triangles(&in_w.join("electrode_1.stl")));
    assert!(of_w.len() == of_mesh.len() && !of_w.is_empty());
    for (there, here) in of_mesh.iter().flatten().zip(of_w.iter().flatten()) {
        // An STL file has numbers of 24 bits: 4e-6 mm at 72 mm, in each of two files.
        assert!((frame.from_parent(*there) - *here).length() < 4e-5, "{there} and {here}");
    }
    assert_eq!(report(&in_w)["written"]["electrode_frame"], "w");
    let program = |folder: &Path| std::fs::read_to_string(folder.join("path_1.nc")).unwrap();
    assert!(program(&in_w).contains("electrode_1.stl in the workpiece frame W"));
    let motion = |folder: &Path| program(folder).lines().filter(|l| l.contains("G01")).collect::<Vec<_>>().join("\n");
    assert_eq!(motion(&in_mesh), motion(&in_w), "the program moves in W in any case");
    // What was written is taken as an electrode of one's own, which is read as soon as it is named.
    let core = desk.blisk_mut();
    let mut job = core.document.params().clone();
    job.electrode.mesh = Some(in_mesh.join("electrode_1.stl"));
    core.edit("Own electrode", job, false);
    desk.until_idle();
    let own = &desk.blisk().work.part().unwrap().own_electrodes;
    assert_eq!((own.len(), own[0].triangles.len(), desk.state(Stage::Electrode)), (1, of_mesh.len(), State::Ready));
}

#[test]
fn a_post_of_ones_own_is_taken_by_its_file() {
    let home = Home::new();
    let mut desk = released(&home);
    let post = home.path("mine.toml");
    std::fs::write(&post, BUILT_IN[0].1.replace("extension = \"nc\"", "extension = \"ngc\"")).unwrap();
    desk.window.state_mut().act(|blisk: &mut BliskWorkspace, cx| blisk.take_post(&post, cx));
    desk.settle();
    assert_eq!(desk.blisk().document.params().export.post, post.to_string_lossy());
    let files = export(&mut desk, &home.path("out"));
    assert!(files.contains("path_1.ngc") && !files.contains("path_1.nc"), "{files:?}");
    std::fs::write(home.path("broken.toml"), "title = 3").unwrap();
    let broken = home.path("broken.toml");
    desk.window.state_mut().act(|blisk: &mut BliskWorkspace, cx| blisk.take_post(&broken, cx));
    desk.settle();
    desk.assert_shows("This is no post");
    assert_eq!(desk.blisk().document.params().export.post, post.to_string_lossy());
}
