//! What goes wrong is said where it went wrong, in words.

use std::sync::Arc;

use egui::{Key, Role};
use files::{AnyDocument, Document};
use sparkpath::shell::run::Opening;
use sparkpath::workspaces::blisk::BliskWorkspace;
use sparkpath::workspaces::blisk::document::stage::Stage;
use sparkpath::workspaces::blisk::paths::BliskPath;
use sparkpath::workspaces::context::Context;
use sparkpath::workspaces::flank::document::{FlankDocument, FlankSource, WallsFile};
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
    assert!(!desk.shows("is not a number"), "a number was entered meanwhile");
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
fn what_is_asked_meanwhile_comes_first_and_no_question_is_lost() {
    let home = Home::new();
    let mut desk = home.start(Opening::Demonstration);
    desk.until_done(Stage::Part);
    let act = |desk: &mut Desk, act: fn(&mut Context)| {
        desk.window.state_mut().act(|_: &mut BliskWorkspace, cx| act(cx));
        desk.settle();
    };
    act(&mut desk, |cx| cx.ask(BliskPath::Post, ""));
    act(&mut desk, |cx| cx.ask(BliskPath::Machine, ""));
    act(&mut desk, |cx| {
        cx.error("One thing is wrong", "The one");
        cx.error("Another is wrong", "The other");
    });
    for (title, button) in
        [("Another is wrong", "Close"), ("One thing is wrong", "Close"), ("Your own machine", "Cancel")]
    {
        desk.assert_shows(title);
        desk.press(button);
    }
    desk.assert_shows("Your own NC post");
    desk.type_path(&home.path("none.toml"));
    desk.assert_shows("This is no post");
    desk.press("Close");
    assert!(!desk.shows("Type or paste the path") && !desk.shows("wrong"));
    // Asked twice it is asked once.
    act(&mut desk, |cx| cx.ask(BliskPath::Post, ""));
    act(&mut desk, |cx| cx.ask(BliskPath::Post, ""));
    desk.press("Cancel");
    assert!(!desk.shows("Type or paste the path"));
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

#[test]
fn a_mold_whose_mesh_is_elsewhere_or_has_changed_asks() {
    let home = Home::new();
    let mesh = home.mold();
    let [project, elsewhere] = ["stepped.sparkpath", "elsewhere.stl"].map(|name| home.path(name));
    let mut desk = home.start(Opening::In("mold", Some(mesh.clone())));
    desk.until_loaded();
    desk.mold_mut().document.save_as(&project).unwrap();
    std::fs::rename(&mesh, &elsewhere).unwrap();
    desk.drop_file(&project);
    desk.assert_shows("no longer exists");
    assert!(!desk.shows("Open without"), "there would be nothing to show");
    desk.press("Find it…");
    desk.type_path(&elsewhere);
    desk.until("the mold is found", |desk| desk.mold().params().mesh.as_ref() == Some(&elsewhere));
    desk.until_loaded();
    let document = &desk.mold().document;
    assert!(document.file() == Some(project.as_path()) && document.is_unsaved(), "the file names the former mesh");

    desk.mold_mut().document.save_as(&project).unwrap();
    std::fs::copy("tests/data/cube.stl", &elsewhere).unwrap();
    desk.drop_file(&project);
    desk.assert_shows("has changed since the project was saved");
    desk.press("Cancel");
    assert!(!desk.shows("has changed since") && !desk.app().is_opening());
    desk.drop_file(&project);
    desk.press("Use as it is now");
    desk.until("the other mesh is there", |desk| desk.mold().work.mold().is_some_and(|m| m.mesh.triangles.len() == 12));
}

#[test]
fn a_flank_whose_files_are_gone_or_have_changed_asks() {
    let home = Home::new();
    let [lower, upper, walls, project] =
        ["lower.csv", "upper.csv", "walls.stl", "flank.sparkpath"].map(|name| home.path(name));
    let write = |file: &std::path::Path, z: f64| {
        std::fs::write(file, format!("0,0,{z}\n10,2,{z}\n20,2,{z}\n30,0,{z}\n")).unwrap();
    };
    write(&lower, 0.0);
    write(&upper, 10.0);
    std::fs::copy("tests/data/cube.stl", &walls).unwrap();
    let walled = Some(WallsFile { file: walls.clone(), units: Default::default() });
    let source = FlankSource::guides([lower, upper.clone()]);
    Document::new(FlankDocument { source, walls: walled, ..Default::default() }).export(&project).unwrap();
    let mut desk = home.start(Opening::File(project.clone()));
    desk.until("all is read", |desk| {
        let (work, params) = (&desk.flank().work, desk.flank().document.params());
        work.loaded(params).is_some() && work.walls(params).is_some()
    });
    desk.flank_mut().document.save_as(&project).unwrap();

    write(&upper, 11.0);
    desk.drop_file(&project);
    desk.assert_shows("upper.csv has changed since the project was saved");
    assert!(!desk.shows("lower.csv has changed") && !desk.shows("walls.stl has changed"));
    desk.press("Cancel");
    std::fs::remove_file(&walls).unwrap();
    write(&upper, 10.0);
    desk.drop_file(&project);
    desk.assert_shows("walls.stl no longer exists");
    desk.press("Open without");
    desk.until("it is open without its walls", |desk| {
        let (work, params) = (&desk.flank().work, desk.flank().document.params());
        matches!(work.walls_state(params), State::Failed(_)) && work.loaded(params).is_some()
    });
    assert_eq!(desk.flank().document.file(), Some(project.as_path()));
    std::fs::remove_file(&upper).unwrap();
    desk.drop_file(&project);
    desk.assert_shows("upper.csv no longer exists");
    assert!(!desk.shows("Open without"), "without its guide there is no surface");
}
