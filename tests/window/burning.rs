//! Technology tables in their window, and the finished part against its scan.

use burning::technology::TECHNOLOGY_FILE;
use egui::{Key, Role};
use import::write_stl;
use mold::cutter::Cutter;
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
fn a_technology_table_that_one_workspace_changes_counts_in_the_other() {
    let home = Home::new();
    let own = home.path("own.toml");
    let read = || TECHNOLOGY_FILE.read(&own).unwrap();
    let mut table = burning::defaults::standard().unwrap();
    let id = "steel-copper";
    table.technology.retain(|technology| technology.id == id);
    // One step for fronts of any size and for the spark gap of the mold: minutes rest on its rate alone.
    let steps = &mut table.technology[0].step;
    steps.retain(|step| step.name == "S1");
    (steps[0].max_density_a_cm2, steps[0].gap_side_mm, steps[0].gap_front_mm) = (None, Some(0.05), Some(0.05));
    TECHNOLOGY_FILE.write(&own, &table).unwrap();
    let name = own.to_string_lossy().into_owned();
    let mut desk = home.start_in(Opening::In("mold", Some(home.mold())), [1280, 720], 1.0);
    desk.take_cutters(&[Cutter::flat(3.0)]);
    let mut params = desk.mold().document.params().clone();
    params.electrodes.technology.table.clone_from(&name);
    params.electrodes.stages[0].last_step = table.technology[0].step[0].name.clone();
    desk.mold_mut().edit(params);
    desk.until_loaded();
    desk.press("Create electrodes");
    let minutes =
        |desk: &crate::desk::Desk| desk.mold().electrodes.designed().and_then(|made| Some(made.set.minutes()?.mean));
    desk.until("electrodes are made", |d| d.mold().design_state() == State::Ready && !d.mold().work.is_busy());
    let why = |desk: &crate::desk::Desk| {
        let made = desk.mold().electrodes.designed().unwrap();
        made.report.table.electrodes.iter().flat_map(|e| e.rests_on.clone()).collect::<Vec<_>>().join("; ")
    };
    let before = minutes(&desk).unwrap_or_else(|| panic!("{}", why(&desk)));
    // The window of the mold shows the table too, and is left open.
    desk.key(Key::T);
    desk.settle();

    desk.press_role(Role::Tab, "Blisk workspace");
    desk.until_idle();
    let mut job = desk.blisk().document.params().clone();
    job.technology.table.clone_from(&name);
    job.technology.id = id.to_owned();
    desk.blisk_mut().edit("Technology table", job, false);
    desk.until_idle();
    desk.key(Key::T);
    let rate = 0.5 * read().technology[0].step[0].rate_mm3_min.unwrap();
    desk.enter("Steps 1, Rate", &rate.to_string());
    desk.until_idle();
    assert_eq!(read().technology[0].step[0].rate_mm3_min, Some(rate));
    let now = minutes(&desk).unwrap();
    assert!(now > 1.5 * before, "half the rate takes longer: {before} {now}");

    // The other way round. The mold's window has read what the blisk's wrote, and writes into that.
    let edits = desk.blisk().work.technology_edits();
    desk.press_role(Role::Tab, "Mold workspace");
    desk.settle();
    desk.enter("Steps 1, Wear", "0.5");
    desk.settle();
    let step = read().technology[0].step[0].clone();
    assert_eq!((step.rate_mm3_min, step.wear_percent), (Some(rate), Some(0.5)));
    assert_eq!(desk.blisk().work.technology_edits(), edits + 1);
    assert!(!desk.shows("Not written"));
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
