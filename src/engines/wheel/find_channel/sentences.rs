//! What was assumed in finding a channel, and what was found beside it, in sentences.

use glam::DVec2;

use super::super::channel::{Agreement, Flow, Unlike};
use super::super::options::{BliskOptions, EndWalls};
use super::meridian::Meridian;

/// Says that blades may be none.
pub(super) const STRAIGHT: &str = "The blades stand straight, in planes through the axis, and turn no flow, as spokes, struts, \
                        splines and the teeth of a gear do: check that they are blades.";

/// Says that blades which are wound may be none.
pub(super) const SCREW: &str = "The blades are wound by one lead over their length and height, with gaps as wide from end to end, \
                     as the teeth of a helical gear and the threads of a worm or a screw are: check that they are blades.";

/// Says that a circle around the axis at (x, r) (mm) crosses more gaps than the blades that were counted make.
pub(super) fn uncounted_sentence(gaps: usize, blades: usize, at: DVec2) -> String {
    format!(
        "A circle around the axis at x {:.3}, r {:.3} mm crosses {gaps} gaps, more than {blades} blades make: others stand in \
         passages of another kind, or behind this one, and some may be missing. Compare the passages with blisk.channel, or \
         give the number of blades, those that are missing included, with blisk.blades.",
        at.x, at.y
    )
}

/// Says what hub and shroud were taken for.
pub(super) fn end_wall_assumptions(options: &BliskOptions, meridian: &Meridian, inset: f64) -> Vec<String> {
    let mut assumed = Vec::new();
    let shrouded = meridian.shrouded;
    if meridian.flow != Flow::Axial {
        let outer = if shrouded { "shroud" } else { "tips" };
        assumed.push(format!(
            "The passage is {}: hub and {outer} are the curves beside the blades' ends{}.",
            meridian.flow.name(),
            if shrouded { ", the hub the one nearer to the axis or, of two as near, at smaller x" } else { "" }
        ));
        assumed.push(measured_up_to(shrouded, inset));
        return assumed;
    }
    match options.hub_radius_mm.given() {
        Some(r) => assumed.push(format!("The hub radius was given: {r} mm along the whole channel.")),
        None => assumed.push("The hub radius is the greatest met over the middle 60 % of the channel's width.".into()),
    }
    assumed.push(match (options.shroud_radius_mm.given(), shrouded) {
        (Some(r), _) => format!("The shroud radius was given: {r} mm along the whole channel."),
        (None, true) => "The shroud radius is the least met over the middle 60 % of the channel's width.".into(),
        (None, false) => "No shroud was met along the radius; the blade tips bound the channel instead.".into(),
    });
    assumed.push(measured_up_to(shrouded, inset));
    assumed
}

/// Says what points were given.
pub(super) fn given_by_hand(options: &BliskOptions) -> impl Iterator<Item = String> {
    let names = ["hub", "shroud or the tips", "blades"];
    let given = names.into_iter().zip(options.points()).filter(|(_, (_, points, _))| !points.is_empty());
    let given: Vec<String> = given.map(|(name, (_, points, _))| format!("{} on the {name}", points.len())).collect();
    let sentence = (!given.is_empty()).then(|| format!("Points were given: {}.", given.join(", ")));
    let picked = "Channel 0 is the one whose wall the first of the points on blades lies on.".to_owned();
    let drawn = "Drawn curves bound the passage: what lies beyond them is not burned.".to_owned();
    let drawn = (options.end_walls == EndWalls::Drawn).then_some(drawn);
    sentence.into_iter().chain(drawn).chain((!options.blade_points_mm.is_empty()).then_some(picked))
}

/// Says which of the channels of its kind are not like number `index`, which was found, and what differs most, or how few
/// are like it. `is_odd` where all others are like each other.
pub(super) fn unlike_sentence(
    unlike: &[Unlike],
    is_odd: bool,
    (blades, kinds): (usize, usize),
    index: usize,
) -> Option<String> {
    const MOST: usize = 8;
    let others = blades / kinds - 1;
    if unlike.len() > 1 && 2 * unlike.len() > others + 1 {
        let middle = unlike[unlike.len() / 2];
        if is_odd {
            return Some(format!(
                "Channel {index} is the odd one: the other {others} of its kind are like each other, not like this one ({}). \
                 What is planned here fits none of them: choose another with blisk.channel, {} say.",
                middle.difference, middle.number
            ));
        }
        let how_few = match others - unlike.len() {
            0 => "nor is any like another".to_owned(),
            like => format!("only {like} {}", if like == 1 { "is" } else { "are" }),
        };
        return Some(format!(
            "Of the other {others} channels of its kind, {} are not like this one: {how_few}. Channel {}: {}. Compare \
             another with blisk.channel, {} say.",
            unlike.len(),
            middle.number,
            middle.difference,
            middle.number
        ));
    }
    let named = |of: &Unlike| {
        let angle = 360.0 * ((of.number + blades - index) % blades) as f64 / blades as f64;
        format!("{} at {angle:.1} deg from this one: {}", of.number, of.difference)
    };
    let names: Vec<String> = unlike.iter().take(MOST).map(named).collect();
    let more = if unlike.len() > MOST { "; …" } else { "" };
    (!unlike.is_empty()).then(|| {
        format!(
            "Of the other {others} channels of its kind, {} {} not like this one ({}{more}): what is planned here does not fit \
             there.",
            unlike.len(),
            if unlike.len() == 1 { "is" } else { "are" },
            names.join("; ")
        )
    })
}

/// Says how much of an end wall is open.
pub(super) fn holes_sentence(agreement: &Agreement) -> Option<String> {
    (agreement.open > 0.0).then(|| {
        let share = 100.0 * agreement.open;
        format!(
            "The {} has holes, over {share:.1} % of the places measured: it is taken to go on there.",
            agreement.surface.name()
        )
    })
}

/// Says how much of the passage is left between a hub or a shroud that was given by hand and that of the mesh.
pub(super) fn left_sentence(agreement: &Agreement) -> Option<String> {
    (agreement.left_mm > agreement.within_mm).then(|| {
        format!(
            "The {0} of the mesh lies up to {1:.3} mm beyond the one that was given: what is between them is not burned.",
            agreement.surface.name(),
            agreement.left_mm
        )
    })
}

/// Says how far blades end before the shroud.
pub(super) fn tip_gap_sentence(gap_mm: f64) -> String {
    format!(
        "The blades end up to {gap_mm:.3} mm before the shroud, which is another solid: their walls are taken to go on to it."
    )
}

fn measured_up_to(shrouded: bool, inset: f64) -> String {
    let outer = if shrouded { "shroud" } else { "tips" };
    format!("The walls were measured up to {} % of the height away from hub and {outer}.", 100.0 * inset)
}
