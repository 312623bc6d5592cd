//! What is approved is one plan that was seen, and only that is written.

use std::sync::Arc;

use egui::Key;
use sparkpath::jobs::pipeline::StageState;
use sparkpath::project::Stage;

use crate::desk::Home;
use crate::exporting::approved;

#[test]
fn a_plan_that_is_being_made_again_cannot_be_approved_and_its_successor_is_not() {
    let home = Home::new();
    let mut desk = approved(&home);
    let before = desk.app().core().pipeline.plan().unwrap().clone();
    let pipeline = &mut desk.window.state_mut().core_mut().pipeline;
    pipeline.start_plan().unwrap();
    assert!(!pipeline.can_approve() && pipeline.approve().is_err(), "nobody has seen what will come out");
    desk.until("the plan is done", |d| d.state(Stage::Plan) == StageState::Done);
    let pipeline = &desk.app().core().pipeline;
    assert!(!Arc::ptr_eq(&before, pipeline.plan().unwrap()) && pipeline.can_approve() && !pipeline.is_approved());
    // A plan that was given up leaves the one that was seen, which may be approved.
    desk.key(Key::F5);
    desk.window.state_mut().core_mut().pipeline.cancel();
    desk.until_idle();
    desk.window.state_mut().core_mut().pipeline.approve().unwrap();
    assert!(desk.app().core().pipeline.is_approved());
}
