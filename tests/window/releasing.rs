//! What is released is one plan that was seen, and only that is written.

use std::sync::Arc;
use std::sync::mpsc::{Sender, channel};

use egui::Key;
use sparkpath::workspaces::blisk::document::kept_plan::KeptPlan;
use sparkpath::workspaces::blisk::document::stage::Stage;
use sparkpath::workspaces::blisk::report::Written;
use sparkpath::workspaces::blisk::work::release::ExportWork;
use task::{State, Task};
use wheel::parametric::ParametricBlisk;

use crate::common::easy_blisk;
use crate::desk::{Desk, Home};
use crate::exporting::released;

#[test]
fn a_plan_that_is_made_again_is_released_again() {
    let home = Home::new();
    let mut desk = released(&home);
    a_plan_that_is_being_made_again_cannot_be_released_and_its_successor_is_not(&mut desk);
    a_release_does_not_wait_for_the_residual_stock_and_outlives_it(&mut desk);
}

fn a_plan_that_is_being_made_again_cannot_be_released_and_its_successor_is_not(desk: &mut Desk) {
    assert!(desk.blisk().work.released().is_some());
    let before = desk.blisk().work.plan().unwrap().clone();
    let work = &mut desk.blisk_mut().work;
    work.start_plan().unwrap();
    assert!(!work.can_release() && work.release().is_err(), "nobody has seen what will come out");
    desk.until_idle();
    let work = &desk.blisk().work;
    assert!(!Arc::ptr_eq(&before, work.plan().unwrap()) && work.can_release() && work.released().is_none());
    // A plan that was given up leaves the one that was seen, which may be released.
    desk.key(Key::F5);
    desk.blisk_mut().work.cancel();
    desk.until_idle();
    desk.blisk_mut().work.release().unwrap();
    assert!(desk.blisk().work.released().is_some());
}

#[test]
fn nothing_is_released_before_its_copying_motions_are_known_or_given_up() {
    let home = Home::new();
    let mut desk = released(&home);
    // Another plan of the same parameters is finished anew.
    desk.blisk_mut().work.start_plan().unwrap();
    desk.until("the plan is done", |d| d.state(Stage::Plan) == State::Ready);
    let work = &mut desk.blisk_mut().work;
    let plan = work.plan().unwrap().clone();
    assert!(plan.finishing().is_none(), "the verdict does not wait for the stock that is left");
    assert!(work.residual_stock_shape().is_none() && !work.can_release() && work.release().is_err());
    work.cancel();
    desk.until_idle();
    desk.open_step(Stage::Verify);
    desk.assert_shows("No residual stock and no copying motions: stopped.");
    desk.blisk_mut().work.release().unwrap();
    // What becomes known later was not released.
    desk.press("Compute the residual stock");
    desk.until_idle();
    let work = &desk.blisk().work;
    assert!(Arc::ptr_eq(&plan, work.plan().unwrap()) && work.can_release() && work.released().is_none());
    assert!(plan.residual_stock().is_some() && work.residual_stock_shape().is_some());
    assert!(desk.log().iter().any(|line| line.contains("remain in the channel")), "{:#?}", desk.log());
}

fn a_release_does_not_wait_for_the_residual_stock_and_outlives_it(desk: &mut Desk) {
    desk.blisk_mut().work.start_plan().unwrap();
    let motions_are_known = |d: &Desk| d.blisk().work.plan().is_some_and(|plan| plan.finishing().is_some());
    desk.until("the plan is done", |d| d.state(Stage::Plan) == State::Ready);
    desk.until("the motions are known", motions_are_known);
    desk.blisk_mut().work.release().unwrap();
    desk.until_idle();
    let work = &desk.blisk().work;
    assert!(work.released().is_some() && work.plan().unwrap().residual_stock().is_some());
}

#[test]
fn an_export_stops_when_its_release_is_taken_back() {
    let home = Home::new();
    let mut desk = released(&home);
    // Goes on only after the release was taken back.
    let until_told = || -> (Sender<()>, ExportWork) {
        let (tell, told) = channel();
        let work = move |task: &Task| {
            told.recv().map_err(|e| e.to_string())?;
            task.check().map_err(|e| e.to_string())?;
            Ok(Written { files: vec!["written without a release".to_owned()], ..Written::default() })
        };
        (tell, Box::new(move |_, _, _, _, task| work(task)))
    };
    let (tell, work) = until_told();
    let blisk = &mut desk.blisk_mut().work;
    blisk.start_export(&home.path("out"), work).unwrap();
    blisk.withdraw();
    tell.send(()).unwrap_or(());
    desk.until_idle();
    assert_eq!(desk.state(Stage::Export), State::Missing, "{:#?}", desk.log());
    let (tell, work) = until_told();
    let core = desk.blisk_mut();
    core.work.release().unwrap();
    core.work.start_export(&home.path("out"), work).unwrap();
    let mut job = core.document.params().clone();
    job.plan.margin_mm += 0.01;
    core.edit("Margin", job, false);
    desk.settle();
    tell.send(()).unwrap_or(());
    desk.until_idle();
    assert_eq!(desk.state(Stage::Export), State::Missing, "{:#?}", desk.log());
    assert!(desk.log().iter().any(|line| line.contains("release withdrawn")));
}

#[test]
fn a_plan_is_kept_for_the_mesh_that_it_was_made_from() {
    let home = Home::new();
    let mut desk = released(&home);
    let kept = KeptPlan::of(&desk.blisk().document).unwrap();
    home.part(&ParametricBlisk { width_mm: 20.5, ..easy_blisk() });
    desk.blisk_mut().work.reload();
    desk.until_idle();
    assert_eq!(desk.state(Stage::Plan), State::Stale, "the mesh is another one");
    let work = &mut desk.blisk_mut().work;
    work.start_plan().unwrap();
    work.cancel();
    desk.until_idle();
    assert_eq!(desk.state(Stage::Plan), State::Stale, "{:#?}", desk.log());
    assert_eq!(KeptPlan::of(&desk.blisk().document), Some(kept));
}
