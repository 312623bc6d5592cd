//! What works behind the window: how many threads stand while everything is busy.

use egui::{Key, Role};
use mold::cutter::Cutter;
use sparkpath::shell::run::Opening;
use sparkpath::workspaces::blisk::document::stage::Stage;
use task::State;

use crate::desk::{Home, quick};

/// The names of the threads of this process (Linux).
fn threads() -> Vec<String> {
    let tasks = std::fs::read_dir("/proc/self/task").unwrap().flatten();
    tasks.filter_map(|task| std::fs::read_to_string(task.path().join("comm")).ok()).collect()
}

#[test]
#[cfg(target_os = "linux")]
fn two_threads_more_than_cores_stand_however_much_is_worked_on() {
    let home = Home::new();
    let mut desk = home.start(Opening::In("mold", Some(home.mold())));
    desk.take_cutters(&[Cutter::flat(3.0)]);
    desk.until_loaded();
    desk.press_role(Role::Tab, "Blisk workspace");
    desk.until_idle();
    // A search that no machine ends before it is looked at.
    let mut long = quick(desk.blisk().document.params().clone());
    long.genetic.generations = 10_000;
    desk.blisk_mut().edit("Long search", long, false);
    desk.until_idle();
    desk.key(Key::F5);
    desk.until("nodes are searched", |d| d.blisk().work.partial_plan().is_some());
    desk.press_role(Role::Tab, "Mold workspace");
    desk.press("Find rest material");
    desk.press_role(Role::Tab, "Flank workspace");
    desk.press("Plan");
    let cores = std::thread::available_parallelism().unwrap().get();
    let names = threads();
    assert_eq!(desk.state(Stage::Plan), State::Running);
    let of = |start: &str| names.iter().filter(|name| name.starts_with(start)).count();
    assert_eq!((of("quick work"), of("long work")), (1, 1), "{names:?}");
    assert!(of("pool") <= cores, "{names:?}");
}
