//! Pictures of the main states. None of them shows a time or a place on the disk.

use egui::{Key, Role};
use egui_kittest::SnapshotOptions;
use egui_kittest::kittest::{By, Queryable as _};
use files::AnyDocument as _;
use import::write_stl;
use sparkpath::shell::run::Opening;
use sparkpath::workspaces::blisk::document::Document;
use sparkpath::workspaces::blisk::document::job_file::PlanJob;
use sparkpath::workspaces::blisk::document::stage::Stage;
use sparkpath::workspaces::blisk::scene::Layer;
use sparkpath::workspaces::preferences::ThemeChoice;
use task::State;

use crate::common::{curved_blisk, easy_blisk, mesh};
use crate::desk::{Desk, Home, quick};
use crate::made_once::made_once;

impl Desk {
    /// Compares the window with the picture `name`.
    ///
    /// Versions of Mesa differ in the last bit of blended colours and in which side of an edge a pixel on it belongs
    /// to. The first is let pass by the threshold, which is far below what an eye sees; the second by a number of
    /// pixels that is less than one changed word.
    pub fn picture(&mut self, name: &str) {
        // After the last movement it is drawn with full care.
        self.settle();
        let options = SnapshotOptions::new().threshold(1.0).max_failed_pixels(120);
        self.window.snapshot_options(name, &options);
    }

    /// The picture `name` in dark and in light.
    pub fn pictures(&mut self, name: &str) {
        for (theme, choice) in [("light", ThemeChoice::Light), ("dark", ThemeChoice::Dark)] {
            self.window.state_mut().context_mut().preferences.theme = choice;
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
    let project = home.project(&easy_blisk(), |job| *job = easy(job.clone()));
    let mut desk = home.start(Opening::File(project));
    plan(&mut desk);
    desk
}

/// Reductions that let the electrode out.
fn easy(mut job: PlanJob) -> PlanJob {
    job.electrode.circumferential_reduction_deg = [3.0, 3.0];
    job.electrode.radial_reduction_mm = 1.0;
    job
}

fn plan(desk: &mut Desk) {
    desk.until_idle();
    desk.key(Key::F5);
    desk.until("the plan has ended", |d| matches!(d.state(Stage::Plan), State::Ready | State::Failed(_)));
    desk.until_idle();
}

#[test]
fn a_plan_until_it_is_stale() {
    let home = Home::new();
    let mut desk = planned(&home);
    desk.press("Channel");
    desk.open_step(Stage::Verify);
    let node = desk.blisk().track().nodes().nth(9).unwrap().s;
    desk.blisk_mut().cursor.s = node;
    desk.settle();
    desk.pictures("planned");
    desk.press("Nodes");
    desk.picture("nodes_dark");
    desk.press("Clearance");
    desk.open_step(Stage::Export);
    desk.press("Release for export");
    desk.press("Export…");
    desk.pictures("export");
    desk.press_role(Role::Button, "Cancel");
    desk.open_step(Stage::Electrode);
    desk.enter("Radial reduction", "1.2");
    desk.until_idle();
    desk.open_step(Stage::Verify);
    desk.pictures("stale");
}

/// A cut through the channel, and the electrode coloured by its clearance.
fn cut_and_coloured(desk: &mut Desk) {
    desk.key(Key::End);
    desk.key(Key::X);
    desk.blisk_mut().colours = true;
    desk.until("the colours are there", |d| d.blisk().colour_values().is_some());
}

/// One plan in windows of all sizes, each as if it had been opened so.
#[test]
fn a_plan_in_windows_of_all_sizes() {
    let home = Home::new();
    let mut desk = planned(&home);
    desk.press("Front");
    cut_and_coloured(&mut desk);
    desk.pictures("section");
    desk.key(Key::X);
    desk.blisk_mut().colours = false;
    a_window_of_1920_by_1080(&mut desk);
    plots_and_their_tabs_keep_within_windows_between(&mut desk);
}

fn resize(desk: &mut Desk, pixels: [u16; 2]) {
    desk.window.set_size(egui::Vec2::from(pixels.map(f32::from)));
    desk.settle();
}

/// Where there is room the table of nodes stands beside the plots.
fn a_window_of_1920_by_1080(desk: &mut Desk) {
    resize(desk, [1920, 1080]);
    desk.press("Channel");
    desk.open_step(Stage::Verify);
    let node = desk.blisk().track().nodes().nth(4).unwrap().s;
    desk.blisk_mut().cursor.s = node;
    desk.blisk_mut().selected = Some(Layer::Electrode);
    desk.settle();
    assert!(desk.shows("Axes") && desk.shows("clearance mm"), "plots and table at once");
    desk.picture("wide_dark");
    desk.blisk_mut().selected = None;
    desk.press("Centroid");
    desk.picture("centroid_dark");
    desk.press("Histogram");
    assert!(desk.shows("no longer between the blades"), "the electrode is nearly out");
    let last = desk.blisk().track().nodes().map(|node| node.s).fold(f64::INFINITY, f64::min);
    desk.blisk_mut().cursor.s = last;
    desk.settle();
    desk.picture("histogram_dark");
    desk.press("Axes");
}

/// Room between small and large: nothing runs out of the window.
fn plots_and_their_tabs_keep_within_windows_between(desk: &mut Desk) {
    for pixels in [[1000_u16, 700], [800, 560]] {
        resize(desk, pixels);
        let right = |role: Role, name: &str| desk.window.get(By::new().role(role).label(name)).rect().right();
        for tab in ["Axes", "Speed", "Second derivative", "Clearance", "Centroid", "Histogram", "Convergence", "Nodes"]
        {
            let names = desk.window.query_all(By::new().role(Role::Button).label(tab));
            let rightmost = names.map(|node| node.rect().right()).fold(0.0, f32::max);
            assert!(rightmost > 0.0 && rightmost <= f32::from(pixels[0]), "{pixels:?}: {tab} ends at {rightmost}");
        }
        let plot = right(Role::Image, "Plot axes");
        assert!(plot <= f32::from(pixels[0]), "{pixels:?}: {plot}");
    }
    desk.picture("verify_800_dark");
}

/// A window of so many pixels, of which `scale` make a point, with a plan that was kept.
fn reopened(home: &Home, pixels: [u16; 2], scale: f32) -> Desk {
    const FILES: [&str; 2] = ["part.stl", "part.sparkpath"];
    let kept = made_once("planned", |folder| {
        let [part, project] = FILES.map(|name| folder.join(name));
        write_stl(&part, &mesh(&easy_blisk())).unwrap();
        Document::new(easy(quick(PlanJob::for_mesh(&part)))).save_as(&project).unwrap();
        let mut desk = Home::new().start(Opening::File(project.clone()));
        plan(&mut desk);
        desk.blisk_mut().document.save_as(&project).unwrap();
    });
    for name in FILES {
        std::fs::copy(kept.join(name), home.path(name)).unwrap();
    }
    let mut desk = home.start_in(Opening::File(home.path(FILES[1])), pixels, scale);
    desk.until_done(Stage::Plan);
    desk.until_idle();
    desk
}

/// Twice as many pixels show the same, only sharper.
#[test]
fn a_window_of_2560_by_1440_at_200_percent() {
    let home = Home::new();
    let mut desk = reopened(&home, [2560, 1440], 2.0);
    desk.press("Channel");
    desk.open_step(Stage::Verify);
    desk.picture("fine_dark");
}

/// As little room as there ever is: 640 by 360 points.
#[test]
fn a_window_of_1280_by_720_at_200_percent() {
    let home = Home::new();
    let mut desk = reopened(&home, [1280, 720], 2.0);
    desk.open_step(Stage::Part);
    desk.picture("small_part_dark");
    desk.open_step(Stage::Electrode);
    desk.picture("small_electrode_dark");
    cut_and_coloured(&mut desk);
    desk.picture("small_section_dark");
    desk.key(Key::X);
    desk.blisk_mut().colours = false;
    desk.open_step(Stage::Verify);
    desk.window.state_mut().context_mut().preferences.theme = ThemeChoice::Light;
    desk.settle();
    desk.picture("small_verify_light");
    desk.open_step(Stage::Export);
    desk.press("Release for export");
    desk.press("Export…");
    desk.picture("small_export_light");
    desk.press_role(Role::Button, "Cancel");
    desk.window.state_mut().context_mut().preferences.live = true;
    desk.key_with(egui::Modifiers::COMMAND, Key::Comma);
    desk.picture("small_preferences_light");
}

#[test]
fn an_electrode_that_cannot_come_out_jams_at_a_node() {
    let home = Home::new();
    let project = home.project(&curved_blisk(), |job| {
        job.electrode.circumferential_reduction_deg = [1.5, 1.5];
        (job.genetic.population, job.genetic.generations) = (8, 3);
    });
    let mut desk = home.start(Opening::File(project));
    plan(&mut desk);
    desk.assert_shows("jams at node");
    assert!(desk.step_says(Stage::Plan, "failed") && !desk.blisk().work.can_release());
    let jam = desk.blisk().outcome().unwrap().plan.jam.clone().unwrap();
    desk.assert_shows(&format!("Jams at node {}", jam.node));
    desk.press("Channel");
    desk.open_step(Stage::Plan);
    desk.press("Go there");
    let core = desk.blisk();
    assert_eq!(core.cursor.s, jam.s, "the cursor stands where it jams");
    desk.pictures("jam");
    desk.open_step(Stage::Export);
    desk.assert_shows("Only a certified plan that is up to date");
}

#[test]
fn wrong_input() {
    let home = Home::new();
    let mut desk = home.start(Opening::Demonstration);
    desk.until_done(Stage::Plan);
    desk.open_step(Stage::Electrode);
    desk.enter("Spark gap", "9");
    desk.until_idle();
    desk.pictures("wrong_input");
}
