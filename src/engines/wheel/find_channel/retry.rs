//! What else is tried where a wheel or its channel is not found: another number of blades, or without what is given by hand.

use super::super::channel::Channel;
use super::super::error::{BliskError, Misleading, Refused};
use super::super::frame::{BliskFrame, Repetition, Wheel, find_wheel};
use super::super::options::{Auto, BliskOptions};
use super::{channel_of, hand_lines, wheel_and_channel};
use geometry::mesh::Mesh;
use task::Task;

/// How many blades there seem to be, and what is the matter with them, where `error` refuses what was counted and no number
/// is given: circles through a broken blade meet fewer gaps, and those through hollow ones more.
pub(super) fn recount(error: &BliskError, found: &Repetition, options: &BliskOptions) -> Option<(usize, &'static str)> {
    match error {
        _ if options.blades.given().is_some() => None,
        BliskError::LostWall { .. } => Some((found.blades, "of which some are broken or missing")),
        BliskError::Unbounded { .. } if found.kinds > 1 => Some((found.blades / found.kinds, "which are hollow")),
        _ => None,
    }
}

/// The wheel of so many blades, with what is the matter with them, and its channel, if it has one.
pub(super) fn counted<'a>(
    mesh: &'a Mesh,
    (count, what, options): (usize, &str, &BliskOptions),
    assumed: &[String],
    task: &Task,
    found: &mut dyn FnMut(&Wheel),
) -> Result<Option<(Wheel<'a>, Channel)>, BliskError> {
    let told = format!("{count} blades were counted around the axis, {what}.");
    let assumed = &[assumed, &[told]].concat()[..];
    let options = BliskOptions { blades: Auto::Given(count), ..options.clone() };
    let wheel = match find_wheel(mesh, &options, task) {
        Ok(wheel) => wheel,
        Err(error @ BliskError::Cancelled(_)) => return Err(error),
        Err(_) => return Ok(None),
    };
    found(&wheel);
    let assumed = [assumed, &wheel.blisk.assumed].concat();
    match channel_of(wheel.clone(), &options, assumed, task) {
        Ok(channel) => Ok(Some((wheel, channel))),
        Err(Refused { error: error @ BliskError::Cancelled(_), .. }) => Err(error),
        Err(_) => Ok(None),
    }
}

/// The refusal of the first of `suspects` that is given by hand, where a channel is found without it.
pub(super) fn misleading(
    mesh: &Mesh,
    options: &BliskOptions,
    suspects: &[Misleading],
    task: &Task,
) -> Result<Option<BliskError>, BliskError> {
    let mut fewer = options.clone();
    let Some(given) = suspects.iter().copied().find(|given| given.take_away(&mut fewer)) else { return Ok(None) };
    match wheel_and_channel(mesh, &fewer, &[], task, &mut |_| ()) {
        Ok((Wheel { blisk: BliskFrame { axis, repetition, middle, .. }, .. }, channel)) => {
            if let (Misleading::Points, Some(off)) = (given, hand_lines::point_off(options, &channel)) {
                return Ok(Some(off));
            }
            Ok(Some(BliskError::Misleading { given, axis, blades: repetition.blades, at: middle }))
        }
        Err(Refused { error: error @ BliskError::Cancelled(_), .. }) => Err(error),
        Err(Refused { error: error @ BliskError::Misleading { .. }, .. }) => Ok(Some(error)),
        Err(_) => Ok(None),
    }
}
