//! Solids beside a blisk that are in the way of its electrode.

use std::f64::consts::PI;

use super::*;
use glam::{DQuat, DVec3};

/// The plan of the easy blisk with a plate across the way out, `turn` further about the axis (rad).
fn beside_plate(turn: f64) -> PlanOutcome {
    let channel = &easy_plan().channel;
    let [front, _] = channel.faces_x;
    // From 10 to 14 mm before the front face, wider and higher than a channel.
    let place = DQuat::from_rotation_x(turn);
    let corner = DVec3::new(front - 14.0, -15.0, 35.0);
    let plate = Mesh::cuboid(DVec3::new(4.0, 30.0, 25.0)).mapped(|p| channel.frame.to_parent(place * (p + corner)));
    let inputs = PlanInputs { obstacles: Some(Arc::new(plate)), ..easy_inputs(easy_job()) };
    let task = Task::default();
    run_feeds(&prepare(&inputs, &task).unwrap(), &inputs, &task).unwrap()
}

#[test]
fn a_plate_across_the_way_out_stops_the_electrode_and_one_on_the_other_side_does_not() {
    assert!(easy_plan().is_verified());
    let free = beside_plate(PI);
    assert!(free.is_verified(), "{}", free.electrodes[0].plan.verdict(&free.channel));
    let stopped = beside_plate(0.0);
    let plan = &stopped.electrodes[0].plan;
    let verdict = plan.verdict(&stopped.channel);
    assert!(!stopped.is_verified(), "{verdict}");
    assert!(verdict.contains(stopped.channel.surface_name(Surface::Obstacle)), "{verdict}");
}
