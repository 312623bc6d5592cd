//! What goes wrong is said where it went wrong, in words.

use std::sync::Arc;

use egui::{Key, Role};
use files::AnyDocument;
use sparkpath::shell::run::Opening;
use sparkpath::workspaces::blisk::document::stage::Stage;
use sparkpath::workspaces::flank::document::FlankSource;
use task::State;

use crate::common::{curved_blisk, easy_blisk};
use crate::desk::{Desk, Home};

#[test]
fn a_wrong_number_is_told_beside_its_field() {
    let home = Home::new();
    let mut desk = home.start(Opening::Demonstration);
    desk.until_done(Stage::Plan);
    desk.open_step(Stage::Electrode);
    desk.enter("Spark gap", "abc");
    desk.assert_shows("Spark gap: \"abc\" is not a number; enter a number from 0.005 to 2 mm; it stays 0.1 mm");
    assert_eq!(desk.blisk().document.params().electrode.spark_gap_mm, 0.1);
    desk.enter("Spark gap", "9");
    desk.until_idle();
    desk.assert_shows("Spark gap is 9 mm: must be from 0.005 to 2 mm");
    assert!(desk.step_says(Stage::Electrode, "failed") && desk.step_says(Stage::Channel, "done"));
    let State::Failed(why) = desk.state(Stage::Electrode) else { panic!() };
    assert!(why.contains("Spark gap"), "{why}");
    desk.key(Key::F5);
    desk.until_idle();
    assert_eq!(desk.state(Stage::Plan), State::Stale, "nothing is planned from a wrong number");
    desk.enter("Spark gap", "0.1");
    desk.until_done(Stage::Electrode);
    assert!(!desk.shows("must be from") && desk.step_says(Stage::Electrode, "done"));
}

#[test]
fn a_mesh_that_is_no_blisk_fails_at_its_channel() {
    let home = Home::new();
    let mut desk = home.start(Opening::File("tests/data/cube.stl".into()));
    desk.until_idle();
    assert!(desk.step_says(Stage::Part, "done") && desk.step_says(Stage::Channel, "failed"));
    assert_eq!(desk.state(Stage::Electrode), State::Missing);
    desk.open_step(Stage::Channel);
    let State::Failed(why) = desk.state(Stage::Channel) else { panic!() };
    assert!(why.contains("blade") || why.contains("axis"), "{why}");
    desk.assert_shows(&why[1..]);
}

#[test]
fn a_file_that_is_no_mesh_fails_at_the_part() {
    let home = Home::new();
    let file = home.path("noise.stl");
    std::fs::write(&file, b"this is not a mesh").unwrap();
    let mut desk = home.start(Opening::File(file));
    desk.until_idle();
    assert!(desk.step_says(Stage::Part, "failed"));
    let State::Failed(why) = desk.state(Stage::Part) else { panic!() };
    assert!(why.contains("noise.stl"), "{why}");
    desk.assert_shows(&why);
}

#[test]
fn a_project_whose_mesh_has_changed_asks() {
    let home = Home::new();
    let part = home.part(&easy_blisk());
    let mut desk = home.start(Opening::File(part.clone()));
    desk.until_idle();
    let project = home.path("job.sparkpath");
    desk.blisk_mut().document.save_as(&project).unwrap();
    home.part(&curved_blisk());
    desk.window.state_mut().open(&project);
    desk.settle();
    desk.assert_shows("has changed since the project was saved");
    desk.press("Use as it is now");
    desk.until_idle();
    assert_eq!(desk.blisk().document.file(), Some(project.as_path()));
    std::fs::remove_file(&part).unwrap();
    desk.window.state_mut().open(&project);
    desk.settle();
    desk.assert_shows("no longer exists");
    desk.assert_shows("Find it…");
    assert!(!desk.shows("Use as it is now"), "there is nothing to use");
    desk.press("Cancel");
    assert!(!desk.shows("no longer exists"));
    assert!(desk.step_says(Stage::Channel, "done"), "what was open stays");
}

#[test]
fn a_broken_project_is_said_to_be_broken_and_what_was_open_stays() {
    let home = Home::new();
    let file = home.path("broken.sparkpath");
    std::fs::write(&file, "{\"format\": 7").unwrap();
    let mut desk = home.start(Opening::File(file));
    desk.settle();
    desk.assert_shows("This project cannot be opened");
    desk.assert_shows("broken.sparkpath");
    desk.press("Close");
    desk.until_done(Stage::Electrode);
    assert!(desk.step_says(Stage::Electrode, "done") && !desk.shows("This project cannot be opened"));
}

/// What cannot be read takes the place of nothing: neither its name nor its parameters, nor those of the workspace.
#[test]
fn a_failed_open_changes_nothing() {
    const FAILED: &str = "cannot be opened";
    let home = Home::new();
    let [broken, kept] = [home.path("broken.stl"), home.path("kept.sparkpath")];
    std::fs::write(&broken, b"this is not a mesh").unwrap();
    // A file that is well in itself, but names a mesh that cannot be read.
    std::fs::write(&kept, "mesh = \"broken.stl\"").unwrap();
    let mut desk = home.start(Opening::In("mold", Some(home.mold())));
    desk.until_loaded();
    let fails = |desk: &mut Desk, file: &std::path::Path| {
        let title = desk.app().title().to_owned();
        desk.drop_file(file);
        desk.assert_shows(FAILED);
        desk.assert_shows("broken.stl");
        desk.press("Close");
        assert!(!desk.shows(FAILED) && desk.app().title() == title, "{title} {}", desk.app().title());
    };
    let (params, mold) = (desk.mold().document.params().clone(), desk.mold().work.mold().unwrap().clone());
    for file in [&broken, &kept] {
        fails(&mut desk, file);
        let now = desk.mold();
        assert!(
            *now.document.params() == params
                && Arc::ptr_eq(now.work.mold().unwrap(), &mold)
                && !now.document.is_unsaved()
        );
        assert!(now.document.name() == "stepped" && now.document.file().is_none());
    }

    desk.press_role(Role::Tab, "Flank workspace");
    fails(&mut desk, &broken);
    assert!(matches!(desk.flank().document.params().source, FlankSource::Demonstration { .. }));
    // A mold that fails is not gone to either.
    fails(&mut desk, &kept);
    desk.press_role(Role::Tab, "Blisk workspace");
    desk.until_done(Stage::Part);
    let core = desk.blisk();
    let (job, part) = (core.document.params().clone(), core.work.part().unwrap().clone());
    fails(&mut desk, &broken);
    let core = desk.blisk();
    assert!(*core.document.params() == job && Arc::ptr_eq(core.work.part().unwrap(), &part));
    assert!(desk.step_says(Stage::Part, "done"));
}
