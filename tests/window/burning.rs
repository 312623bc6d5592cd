//! Technology tables in their window, and the finished part against its scan.

use burning::technology::TECHNOLOGY_FILE;
use egui::Key;
use import::write_stl;
use sparkpath::shell::run::Opening;
use sparkpath::workspaces::blisk::document::stage::Stage;
use task::State;

use crate::common::{easy_blisk, mesh};
use crate::desk::Home;

#[test]
fn a_technology_table_is_copied_changed_and_used() {
    let home = Home::new();
    let own = home.path("own.toml");
    let mut desk = home.start(Opening::Demonstration);
    desk.until_idle();
    desk.key(Key::T);
    desk.assert_shows("The built-in table is made from rules and cannot be changed. A copy of it can, as a file.");
    desk.pictures("technology");
    desk.press("Save a copy…");
    desk.type_path(&own);
    desk.until("the project uses the copy", |desk| {
        desk.blisk().document.params().technology.table == own.to_string_lossy()
    });
    let read = || TECHNOLOGY_FILE.read(&own).unwrap();
    let id = desk.blisk().document.params().technology.id.clone();
    // A figure of zero is given; one that is not possible is said to be so, and not taken.
    desk.enter("Steps 1, Wear", "0");
    desk.enter("Steps 2, Wear", "-3");
    desk.settle();
    let step = |i: usize| read().get(&id).unwrap().step[i].clone();
    assert_eq!((step(0).wear_percent, step(1).wear_percent), (Some(0.0), None));
    desk.assert_shows("Not taken. Steps 2, Wear");
    desk.press("Undo");
    desk.settle();
    assert_eq!(step(0).wear_percent, None);
    desk.key(Key::T);
    desk.settle();
    assert!(!desk.shows("Other table…"));
}

#[test]
fn a_scan_is_judged_beside_the_plan() {
    let home = Home::new();
    let scan = home.path("scan.stl");
    write_stl(&scan, &mesh(&easy_blisk())).unwrap();
    let project = home.project(&easy_blisk(), |job| job.scan.file = Some(scan.to_string_lossy().into_owned()));
    let mut desk = home.start(Opening::File(project));
    desk.until("the scan is judged", |desk| desk.blisk().scan_state() == State::Ready);
    let part = &desk.blisk().scan().unwrap().part;
    assert!(part.verdict.is_within && part.all.greatest_mm < 1e-4 && part.all.least_mm > -1e-4, "{}", part.verdict);
    assert_eq!(part.by_channel.len(), easy_blisk().blades);
    desk.open_step(Stage::Verify);
    desk.until_idle();
    desk.press("Show the deviations");
    desk.until_idle();
    desk.picture("scan_dark");
}
