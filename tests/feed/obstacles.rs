//! Solids beside a blisk that are in the way of its electrode.

use std::f64::consts::PI;

use super::*;
use glam::{DQuat, DVec3};

/// The plan of the easy blisk with a plate before its channel, from 10 to 14 mm before the front face and wider and higher than
/// a channel, `turn` further about the axis (rad).
fn beside_plate(turn: f64) -> Result<PlanOutcome, PlanJobError> {
    let channel = &easy_plan().channel;
    let [front, _] = channel.faces_x;
    let place = DQuat::from_rotation_x(turn);
    let corner = DVec3::new(front - 14.0, -15.0, 35.0);
    let plate = Mesh::cuboid(DVec3::new(4.0, 30.0, 25.0)).mapped(|p| channel.frame.to_parent(place * (p + corner)));
    let inputs = PlanInputs { obstacles: Some(Arc::new(plate)), ..easy_inputs(easy_job()) };
    let task = Task::default();
    run_feeds(&prepare(&inputs, &task)?, &inputs, &task)
}

/// The shank passes through the middle of the plate, which is 4 mm thick.
pub fn a_plate_before_the_channel_is_in_the_way_of_the_shank_and_one_on_the_other_side_is_not() {
    assert!(beside_plate(PI).unwrap().is_verified());
    let [front, _] = easy_plan().channel.faces_x;
    match beside_plate(0.0).unwrap_err() {
        PlanJobError::Electrode(ElectrodeError::ShankMeets { clearance, at, .. }) => {
            assert!((clearance + 2.0).abs() < 0.05, "{clearance}");
            assert!((front - 14.1..front - 9.9).contains(&at.x), "{at}");
        }
        other => panic!("{other}"),
    }
}
