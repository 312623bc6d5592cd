//! Plans that are kept to compare with.

use egui::{Key, Role};
use egui_kittest::kittest::{By, Queryable as _};
use feed::plan_params::{PlanParams, Strategy};
use files::AnyDocument as _;
use sparkpath::shell::run::Opening;
use sparkpath::workspaces::blisk::document::job_file::PlanJob;
use sparkpath::workspaces::blisk::document::kept_plan::KeptRun;
use sparkpath::workspaces::blisk::document::stage::Stage;
use task::State;

use crate::common::easy_blisk;
use crate::desk::{Desk, Home};

/// Reductions that let the electrode out, and few nodes: each plan is made, and made anew when it is opened.
fn reduced(job: &mut PlanJob) {
    job.plan.step_mm = 2.4;
    job.electrode.circumferential_reduction_deg = [3.0, 3.0];
    job.electrode.radial_reduction_mm = 1.0;
}

/// Plans by `strategy`.
fn plan(desk: &mut Desk, strategy: Strategy) {
    desk.until_done(Stage::Electrode);
    let core = desk.blisk_mut();
    let mut job = core.document.params().clone();
    job.plan.strategy = strategy;
    core.edit("Strategy", job, false);
    desk.until_done(Stage::Electrode);
    desk.key(Key::F5);
    desk.until("the plan is done", |d| d.state(Stage::Plan) == State::Ready);
    desk.open_step(Stage::Plan);
}

fn count(desk: &Desk, role: Role, name: &str) -> usize {
    desk.window.query_all(By::new().role(role).label(name)).count()
}

fn has(desk: &Desk, role: Role, name: &str) -> bool {
    count(desk, role, name) > 0
}

fn runs(desk: &Desk) -> Vec<KeptRun> {
    KeptRun::all_of(&desk.blisk().document)
}

/// What the certificate of the present plan says, as it is shown.
fn certified(desk: &Desk) -> String {
    let planned = desk.blisk().outcome().unwrap().plan.path.as_ref().unwrap();
    format!("{:.4}", planned.certificate.certified())
}

#[test]
fn a_kept_run_stands_in_the_comparison_until_it_is_removed() {
    let home = Home::new();
    let mut desk = home.start(Opening::File(home.project(&easy_blisk(), reduced)));
    plan(&mut desk, Strategy::Genetic);
    assert!(!has(&desk, Role::Button, "Comparison"), "nothing is kept yet");
    desk.press("Keep for comparison");
    let genetic = certified(&desk);
    let elsewhere = count(&desk, Role::Label, &genetic);
    assert!(has(&desk, Role::Label, "1 genetic"), "the legend of the axes has it");
    desk.press("Comparison");
    assert!(has(&desk, Role::Label, "1 genetic"));
    assert_eq!(count(&desk, Role::Label, &genetic), elsewhere + 1, "{genetic} is in the table");
    desk.press("Keep for comparison");
    assert!(!desk.shows("2 genetic"), "the same plan is not kept twice");

    plan(&mut desk, Strategy::MaxMinDistance);
    desk.press("Keep for comparison");
    desk.assert_shows("1 genetic");
    desk.assert_shows("2 max-min-distance");
    // What is kept is in the project, and made anew from it.
    assert!(desk.blisk().document.is_unsaved());
    let project = home.path("kept.sparkpath");
    desk.blisk_mut().document.save_as(&project).unwrap();
    assert!(!desk.blisk().document.is_unsaved());
    desk.window.state_mut().open(&project);
    desk.until("the runs are there again", |d| runs(d).len() == 2 && d.shows("2 max-min-distance"));
    desk.until_idle();
    assert!(!desk.blisk().document.is_unsaved() && !desk.blisk().can_keep(), "{:#?}", desk.log());
    desk.open_step(Stage::Plan);
    desk.pictures("kept_axes");
    desk.press("Comparison");
    desk.pictures("comparison");
    // One of another part takes a place too: it is there to be removed.
    let mut kept = runs(&desk);
    let mut foreign = kept[0].clone();
    (foreign.number, foreign.plan.inputs) = (7, "another part".to_owned());
    kept.push(foreign);
    KeptRun::keep(&kept, &mut desk.blisk_mut().document).unwrap();
    desk.until("it is refused", |d| d.shows("not compared: it is of another part or channel"));
    desk.picture("comparison_foreign_dark");
    desk.press("Remove 7 genetic");
    assert!(!desk.shows("7 genetic") && runs(&desk).len() == 2);
    let before = count(&desk, Role::Label, &genetic);
    desk.press("Remove 1 genetic");
    assert!(!has(&desk, Role::Label, "1 genetic"));
    assert_eq!(count(&desk, Role::Label, &genetic) + 1, before);
    desk.assert_shows("2 max-min-distance");
    desk.press("Remove 2 max-min-distance");
    assert!(!has(&desk, Role::Button, "Comparison"), "nothing is kept any more");
}

#[test]
fn sizes_are_of_the_parameters_that_they_were_found_with() {
    let home = Home::new();
    let project = home.project(&easy_blisk(), |job| {
        (job.plan.strategy, job.plan.step_mm) = (PlanParams::default().strategy, 0.8);
        job.electrode.radial_reduction_mm = 1.0;
    });
    let mut desk = home.start(Opening::File(project));
    desk.until_done(Stage::Electrode);
    desk.open_step(Stage::Electrode);
    desk.press("Find sizes");
    desk.open_step(Stage::Verify);
    desk.assert_shows("Sizes, ");
    desk.open_step(Stage::Electrode);
    desk.until("there is a size", |d| !d.blisk().work.sizes().0.is_empty());
    desk.press("Stop sizing");
    desk.press("Take size 1");
    desk.until_idle();
    let row = desk.blisk().work.sizes().0[0].clone();
    let limit = row.limit.as_ref().unwrap();
    assert_eq!((limit.electrode, limit.electrodes), (1, 1));
    assert!(limit.clause().starts_with(&format!("limited at node {}, ", limit.node)), "{}", limit.clause());
    assert!(limit.surface.contains("wall") || limit.surface == "hub", "{}", limit.clause());
    let of_other = "These sizes are out of date; find them again to take one.";
    let electrode = desk.blisk().document.params().electrode.clone();
    assert_eq!(&[electrode.circumferential_reduction_deg], &row.reduction_deg[..]);
    assert!(!has(&desk, Role::Label, of_other), "what is taken is of these parameters");
    desk.enter("Radial reduction", "1.1");
    desk.until_done(Stage::Electrode);
    desk.assert_shows(of_other);
    let file = home.part(&easy_blisk());
    desk.window.state_mut().open(&file);
    desk.until_idle();
    assert!(desk.blisk().work.sizes().0.is_empty(), "another document has no sizes yet");
}
