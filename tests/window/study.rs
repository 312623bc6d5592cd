//! Studies in the window: set up, run, looked at, and a point taken.

use egui::Role;
use files::AnyDocument as _;
use mold::cutter::Cutter;
use sparkpath::shell::run::Opening;
use sparkpath::workspaces::commands::FrameCommand;
use wheel::electrode::EnterSide;

use crate::common::easy_blisk;
use crate::desk::Home;

#[test]
fn a_study_of_the_open_project_is_run_and_a_point_is_taken() {
    let home = Home::new();
    let out = home.path("study");
    let mut desk = home.start_in(Opening::In("mold", Some(home.mold())), [1280, 900], 1.0);
    desk.take_cutters(&[Cutter::flat(3.0)]);
    desk.until_loaded();
    std::fs::write(home.path("wide.toml"), "[[cutter]]\ndiameter_mm = 5.0\n").unwrap();
    std::fs::write(home.path("narrow.toml"), "[[cutter]]\ndiameter_mm = 2.0\n").unwrap();
    desk.window.state_mut().context_mut().push(FrameCommand::Study);
    desk.settle();
    desk.assert_shows("Of the parameters of stepped");
    // A study without a parameter is not run.
    desk.press("Run study…");
    desk.type_path(&out);
    desk.settle();
    desk.assert_shows("Choose a parameter to vary");
    assert!(!out.exists());
    desk.press_role(Role::ComboBox, "Parameter 1");
    desk.press("Library of cutters   library");
    desk.type_in("Values of parameter 1", "wide.toml, narrow.toml");
    desk.type_in("Less is better", "volume_mm3");
    desk.press("Run study…");
    desk.type_path(&out);
    desk.until("the study is done", |desk| desk.app().study().table().is_some());
    desk.assert_shows("2 points: 2 feasible, 0 not feasible, 0 bad. Best by less volume_mm3: point 2.");
    assert!(out.join("study.csv").is_file() && out.join("Snakefile").is_file());
    desk.until("the mold is at rest", |desk| !desk.mold().work.is_busy());
    desk.pictures("study");
    let before = desk.mold().params().library.clone();
    desk.press_role(Role::Row, "Point 2");
    assert_eq!(desk.mold().params().library.cutter[0].diameter_mm, 2.0);
    desk.press_role(Role::Row, "Point 1");
    assert_eq!(desk.mold().params().library.cutter[0].diameter_mm, 5.0);
    for _ in 0..2 {
        desk.window.state_mut().context_mut().push(FrameCommand::Undo);
        desk.settle();
    }
    assert_eq!(desk.mold().params().library, before);
}

#[test]
fn a_point_of_a_blisk_is_taken_as_one_step() {
    let home = Home::new();
    let project = home.project(&easy_blisk(), |job| {
        job.electrode.circumferential_reduction_deg = [2.8; 2];
        job.electrode.enter = EnterSide::MinusX;
    });
    let mut desk = home.start(Opening::File(project));
    desk.until_idle();
    desk.window.state_mut().context_mut().push(FrameCommand::Study);
    desk.settle();
    desk.press_role(Role::ComboBox, "Parameter 1");
    desk.press("Seed   genetic.seed");
    desk.type_in("Values of parameter 1", "7");
    desk.press("Run study…");
    desk.type_path(&home.path("study"));
    desk.until("the study is done", |desk| desk.app().study().table().is_some());
    desk.assert_shows("1 point: 1 feasible");
    let before = desk.blisk().document.params().clone();
    desk.press_role(Role::Row, "Point 1");
    let taken = desk.blisk().document.params().clone();
    assert_eq!((taken.genetic.seed, &taken.electrode), (7, &before.electrode));
    assert_eq!(desk.blisk().document.undo_label(false), Some("Point 1 of a study"));
    desk.window.state_mut().context_mut().push(FrameCommand::Undo);
    desk.settle();
    assert_eq!(*desk.blisk().document.params(), before);
}
