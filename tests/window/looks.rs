//! Pictures of the main states. None of them shows a time or a place on the disk.

use std::time::Duration;

use egui::{Key, Role};
use egui_kittest::SnapshotOptions;
use sparkpath::app::{Opening, ThemeChoice};
use sparkpath::jobs::pipeline::StageState;
use sparkpath::project::{PlanJob, Stage};

use crate::common::{curved_blisk, easy_blisk};
use crate::desk::{Desk, Home, quick};

/// Longer than the view takes to be drawn with full care after the last movement.
const REST: Duration = Duration::from_millis(250);

impl Desk {
    /// Compares the window with the picture `name`.
    ///
    /// Versions of Mesa differ in the last bit of blended colours and in which side of an edge a pixel on it belongs
    /// to. The first is let pass by the threshold, which is far below what an eye sees; the second by a number of
    /// pixels that is less than one changed word.
    fn picture(&mut self, name: &str) {
        std::thread::sleep(REST);
        self.settle();
        let options = SnapshotOptions::new().threshold(1.0).max_failed_pixels(120);
        self.window.snapshot_options(name, &options);
    }

    /// The picture `name` in dark and in light.
    fn pictures(&mut self, name: &str) {
        for (theme, choice) in [("light", ThemeChoice::Light), ("dark", ThemeChoice::Dark)] {
            self.window.state_mut().core_mut().preferences.theme = choice;
            self.settle();
            self.picture(&format!("{name}_{theme}"));
        }
    }
}

#[test]
fn the_steps_before_the_plan() {
    let home = Home::new();
    let mut desk = home.start(Opening::Demonstration);
    desk.until_idle();
    desk.pictures("start");
    desk.open_step(Stage::Channel);
    desk.press("Channel");
    desk.pictures("channel");
    desk.open_step(Stage::Electrode);
    desk.pictures("electrode");
}

/// A window with a plan of the easy blisk.
fn planned(home: &Home) -> Desk {
    let mut desk = home.start(Opening::File(home.part(&easy_blisk())));
    desk.until_idle();
    let mut job = quick(desk.app().core().document.job().clone());
    job.electrode.circumferential_reduction_deg = [3.0, 3.0];
    job.electrode.radial_reduction_mm = 1.0;
    plan(&mut desk, job);
    desk
}

fn plan(desk: &mut Desk, job: PlanJob) {
    desk.window.state_mut().core_mut().edit("Job", job, false);
    desk.until_idle();
    desk.key(Key::F5);
    desk.until("the plan has ended", |d| matches!(d.state(Stage::Plan), StageState::Done | StageState::Failed(_)));
}

#[test]
fn a_plan_until_it_is_stale() {
    let home = Home::new();
    let mut desk = planned(&home);
    desk.press("Channel");
    desk.open_step(Stage::Verify);
    let node = desk.app().core().track().nodes().nth(9).unwrap().s;
    desk.window.state_mut().core_mut().cursor.s = node;
    desk.settle();
    desk.pictures("planned");
    desk.press("Nodes");
    desk.picture("nodes_dark");
    desk.press("Clearance");
    desk.open_step(Stage::Export);
    desk.press("Approve");
    desk.press("Export…");
    desk.pictures("export");
    desk.press_role(Role::Button, "Cancel");
    desk.open_step(Stage::Electrode);
    desk.enter("Radial reduction", "1.2");
    desk.until_idle();
    desk.open_step(Stage::Verify);
    desk.pictures("stale");
}

#[test]
fn an_electrode_that_cannot_come_out_jams_at_a_node() {
    let home = Home::new();
    let mut desk = home.start(Opening::File(home.part(&curved_blisk())));
    desk.until_idle();
    let mut job = quick(desk.app().core().document.job().clone());
    job.electrode.circumferential_reduction_deg = [1.5, 1.5];
    (job.genetic.population, job.genetic.generations) = (8, 3);
    plan(&mut desk, job);
    desk.assert_shows("jams at node");
    assert!(desk.step_says(Stage::Plan, "failed") && !desk.app().core().pipeline.can_approve());
    let jam = desk.app().core().outcome().unwrap().plan.jam.unwrap();
    desk.assert_shows(&format!("Jams at node {}", jam.node));
    desk.press("Channel");
    desk.open_step(Stage::Plan);
    desk.press("Go there");
    let core = desk.app().core();
    assert_eq!(core.cursor.s, jam.s.min(core.track().length()), "the cursor goes as far as there are poses");
    desk.pictures("jam");
    desk.open_step(Stage::Export);
    desk.assert_shows("Only a plan with a certificate that holds");
}

#[test]
fn wrong_input() {
    let home = Home::new();
    let mut desk = home.start(Opening::Demonstration);
    desk.until_idle();
    desk.open_step(Stage::Electrode);
    desk.enter("Spark gap", "9");
    desk.until_idle();
    desk.pictures("wrong_input");
}
