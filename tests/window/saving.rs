//! No work is lost: what is asked before, and what is kept.

use std::path::Path;

use eframe::App as _;
use egui::{Key, Modifiers};
use files::{AnyDocument, Recovery};
use sparkpath::shell::run::Opening;
use sparkpath::workspaces::blisk::document::job_file::PlanJob;
use sparkpath::workspaces::blisk::document::stage::Stage;
use sparkpath::workspaces::blisk::document::{Document, demonstration};
use sparkpath::workspaces::mold::document::MoldParams;

use crate::desk::{Desk, Home, holds};

const UNSAVED: &str = "has unsaved changes";
const OPEN: &str = "Open a project or a mesh";

fn seed(desk: &Desk) -> u64 {
    desk.blisk().document.params().genetic.seed
}

/// Work that no file holds.
fn work(desk: &mut Desk, seed: u64) {
    let core = desk.blisk_mut();
    let mut job = core.document.params().clone();
    job.genetic.seed = seed;
    core.edit("Seed", job, false);
    desk.settle();
}

fn control(desk: &mut Desk, key: Key) {
    desk.key_with(Modifiers::COMMAND, key);
}

/// A project of the demonstration blisk with this seed.
fn project(file: &Path, seed: u64) {
    let mut job = demonstration().params().clone();
    job.genetic.seed = seed;
    Document::new(job).save_as(file).unwrap();
}

#[test]
fn work_done_while_a_file_is_chosen_is_asked_about_once() {
    let home = Home::new();
    let file = home.path("other.sparkpath");
    project(&file, 40);
    let mut desk = home.start(Opening::Demonstration);
    control(&mut desk, Key::O);
    desk.assert_shows(OPEN);
    work(&mut desk, 41);
    desk.type_path(&file);
    desk.assert_shows(UNSAVED);
    assert_eq!(seed(&desk), 41);
    desk.press("Don't save");
    assert_eq!(seed(&desk), 40);
    // Who has given the work up before choosing is not asked again.
    work(&mut desk, 42);
    control(&mut desk, Key::O);
    desk.press("Don't save");
    desk.type_path(&file);
    assert!(!desk.shows(UNSAVED));
    assert_eq!(seed(&desk), 40);
    // But is, if nothing was chosen after all.
    work(&mut desk, 43);
    control(&mut desk, Key::O);
    desk.press("Don't save");
    desk.press("Cancel");
    control(&mut desk, Key::O);
    desk.assert_shows(UNSAVED);
    assert_eq!(seed(&desk), 43);
}

#[test]
fn what_was_to_follow_a_save_is_off_when_nothing_is_saved() {
    let home = Home::new();
    let mut desk = home.start(Opening::Demonstration);
    work(&mut desk, 51);
    control(&mut desk, Key::O);
    desk.press("Save");
    desk.assert_shows("Save project");
    desk.press("Cancel");
    control(&mut desk, Key::S);
    desk.type_path(&home.path("a.sparkpath"));
    assert!(!desk.blisk().document.is_unsaved());
    assert!(!desk.shows(OPEN), "the user had taken that back");
    drop(desk);
    let mut desk = home.start(Opening::Demonstration);
    work(&mut desk, 52);
    control(&mut desk, Key::O);
    desk.press("Save");
    let absent = home.path("absent/b.sparkpath");
    desk.type_path(&absent);
    desk.assert_shows("The project was not saved");
    desk.assert_shows(&format!("{}: cannot be written (No such file", absent.display()));
    assert!(!desk.shows(".part"), "nobody asked for a temporary file");
    desk.key(Key::Enter);
    assert!(!desk.shows("The project was not saved"), "Return closes what only tells");
    control(&mut desk, Key::S);
    desk.type_path(&home.path("b.sparkpath"));
    assert!(!desk.blisk().document.is_unsaved() && !desk.shows(OPEN));
    // While what follows a save does follow.
    work(&mut desk, 53);
    control(&mut desk, Key::O);
    desk.press("Save");
    desk.assert_shows(OPEN);
}

#[test]
fn a_project_is_saved_under_a_name_that_opens_and_over_nothing_unasked() {
    let home = Home::new();
    let mut desk = home.start(Opening::Demonstration);
    work(&mut desk, 61);
    control(&mut desk, Key::S);
    desk.type_path(&home.path("blisk v1.5"));
    let file = home.path("blisk v1.5.sparkpath");
    assert_eq!(desk.blisk().document.file(), Some(&*file));
    assert_eq!(Document::open(&file).unwrap().params().genetic.seed, 61);
    let other = home.path("other.sparkpath");
    std::fs::write(&other, "precious").unwrap();
    for name in ["other", "other.sparkpath"] {
        desk.key_with(Modifiers::COMMAND | Modifiers::SHIFT, Key::S);
        desk.type_path(&home.path(name));
        desk.assert_shows("exists already");
        desk.press("Cancel");
        assert_eq!(std::fs::read_to_string(&other).unwrap(), "precious");
        assert_eq!(desk.blisk().document.file(), Some(&*file));
    }
    desk.key_with(Modifiers::COMMAND | Modifiers::SHIFT, Key::S);
    desk.type_path(&other);
    desk.press("Replace");
    assert_eq!(Document::open(&other).unwrap().params().genetic.seed, 61);
    desk.key_with(Modifiers::COMMAND | Modifiers::SHIFT, Key::S);
    desk.type_path(&home.path(""));
    desk.assert_shows("is a folder");
}

/// However large a project is, nobody waits for it: what is open stays until all of the other one was read.
#[test]
fn a_project_is_read_behind_the_window() {
    let home = Home::new();
    let file = home.path("other.sparkpath");
    project(&file, 45);
    let mut desk = home.start(Opening::Demonstration);
    desk.until_done(Stage::Part);
    desk.window.state_mut().open(&file);
    assert!(desk.app().is_opening() && seed(&desk) != 45, "it is not read at once");
    desk.settle();
    assert!(seed(&desk) == 45 && desk.blisk().document.file() == Some(&*file) && !desk.shows(UNSAVED));
    // What is opened last is what is opened.
    let [slow, last] = ["slow.sparkpath", "last.sparkpath"].map(|name| home.path(name));
    project(&slow, 46);
    project(&last, 47);
    [&slow, &last].into_iter().for_each(|file| desk.window.state_mut().open(file));
    desk.settle();
    assert_eq!(seed(&desk), 47);
}

/// Whether a program that ended left a copy.
fn is_left(home: &Home) -> bool {
    !Recovery::find(&home.folders().autosave).is_empty()
}

fn until_kept(desk: &mut Desk, home: &Home) {
    desk.until("a copy is kept", |_| holds(&home.folders().autosave, ".sparkpath"));
}

#[test]
fn neither_saved_nor_given_up_work_is_recovered() {
    let home = Home::new();
    let mut desk = home.start(Opening::Demonstration);
    work(&mut desk, 71);
    until_kept(&mut desk, &home);
    control(&mut desk, Key::S);
    desk.type_path(&home.path("a.sparkpath"));
    assert!(!holds(&home.folders().autosave, ".sparkpath"), "what is saved needs no copy");
    work(&mut desk, 72);
    until_kept(&mut desk, &home);
    control(&mut desk, Key::Z);
    desk.window.state_mut().on_exit();
    drop(desk);
    assert!(!is_left(&home), "everything was undone");
    let mut desk = home.start(Opening::Demonstration);
    work(&mut desk, 73);
    until_kept(&mut desk, &home);
    control(&mut desk, Key::Q);
    // When the copy is brought up to date the next time, the window is closing.
    desk.wait(2.1);
    desk.press("Don't save");
    desk.window.state_mut().on_exit();
    drop(desk);
    assert!(!is_left(&home), "it was given up on purpose");
    let mut desk = home.start(Opening::Demonstration);
    work(&mut desk, 74);
    desk.window.state_mut().on_exit();
    drop(desk);
    assert!(is_left(&home), "nobody was asked");
}

#[test]
fn recovered_work_keeps_its_copy_until_there_is_another() {
    let home = Home::new();
    let mut desk = home.start(Opening::Demonstration);
    work(&mut desk, 81);
    until_kept(&mut desk, &home);
    drop(desk);
    let mut desk = home.start(Opening::Demonstration);
    // The program's own copy cannot be written: a folder is in its place.
    for entry in std::fs::read_dir(home.folders().autosave).unwrap() {
        let copy = entry.unwrap().path().with_extension("sparkpath");
        if !copy.exists() {
            std::fs::create_dir_all(copy.join("in the way")).unwrap();
        }
    }
    desk.press("Recover");
    assert_eq!(seed(&desk), 81);
    drop(desk);
    let kept = Recovery::find(&home.folders().autosave);
    let job = |copy: &Recovery| copy.open::<PlanJob>().ok().map(|document| document.params().clone());
    let readable: Vec<PlanJob> = kept.iter().filter_map(job).collect();
    let [job] = &readable[..] else { panic!("{readable:?}") };
    assert_eq!(job.genetic.seed, 81);
}

#[test]
fn a_mold_and_a_blisk_of_one_program_are_both_recovered() {
    let home = Home::new();
    let mut desk = home.start(Opening::Demonstration);
    work(&mut desk, 91);
    let mold = desk.mold_mut();
    let params = MoldParams { tolerance_mm: 0.07, ..mold.document.params().clone() };
    mold.edit(params);
    desk.until("both are kept", |_| {
        [".blisk.sparkpath", ".mold.sparkpath"].iter().all(|end| holds(&home.folders().autosave, end))
    });
    drop(desk);
    let mut desk = home.start(Opening::Demonstration);
    desk.assert_shows("Mold, not saved yet");
    desk.press("Recover");
    desk.assert_shows("Recovered work");
    desk.press("Recover");
    let mold = desk.mold();
    // Part and opening direction are noted once the mold that is shown now is read.
    assert!(seed(&desk) == 91 && mold.document.params().tolerance_mm == 0.07 && mold.document.is_unsaved());
    control(&mut desk, Key::Q);
    desk.press("Don't save");
    desk.press("Don't save");
    drop(desk);
    assert!(!is_left(&home), "it was given up on purpose");
}

#[test]
fn a_mold_whose_mesh_is_gone_is_recovered_without_the_picture_of_another() {
    let home = Home::new();
    let other = home.path("other.stl");
    std::fs::copy(home.mold(), &other).unwrap();
    let mut desk = home.start(Opening::In("mold", Some(other.clone())));
    desk.until_loaded();
    let params = MoldParams { tolerance_mm: 0.07, ..desk.mold().document.params().clone() };
    desk.mold_mut().edit(params.clone());
    until_kept(&mut desk, &home);
    drop(desk);
    std::fs::remove_file(&other).unwrap();
    let mut desk = home.start(Opening::In("mold", Some(home.mold())));
    desk.until_loaded();
    assert!(desk.mold().work.mold().is_some());
    desk.press("Recover");
    desk.until("the mesh was looked for", |d| !d.mold().work.is_busy());
    assert!(*desk.mold().document.params() == params && desk.mold().document.is_unsaved());
    assert!(desk.mold().work.mold().is_none(), "it is another part's");
    desk.assert_shows("other.stl: cannot be read");
}

#[test]
fn a_picture_of_the_view_is_written() {
    let home = Home::new();
    let mut desk = home.start(Opening::Demonstration);
    desk.until_done(Stage::Electrode);
    control(&mut desk, Key::K);
    desk.window.event(egui::Event::Text("save picture".to_owned()));
    desk.settle();
    desk.key(Key::Enter);
    desk.type_path(&home.path("view"));
    let file = home.path("view.png");
    desk.until("the picture is written", |desk| desk.log().iter().any(|line| line.contains("picture written to")));
    let picture = image::open(&file).unwrap().into_rgb8();
    assert_eq!(picture.dimensions(), (1920, 1200));
    let corner = *picture.get_pixel(0, 0);
    assert!(picture.pixels().filter(|p| **p != corner).count() > 10_000, "nothing is drawn");
}
