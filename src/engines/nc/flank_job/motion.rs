//! Lead-in and lead-out of a path, and the positions of a machine along all of it.

use glam::DVec3;

use crate::flank_job::settings::{CutDirection, MillingSettings};
use crate::flank_program::settings::milling_post;
use flank::cutter::FlankCutter;
use flank::machine::joint_feed::{Contact, Slowed, paces};
use flank::machine::kinematics::{Kinematics, ToolPose};
use flank::machine::linearise::{LinearisationParams, MachinePath, linearise};
use flank::machine::milling_machine::MillingMachine;
use flank::machine::tool_path::{ToolPath, ToolPathError};
use flank::path::FlankPath;
use flank::ruled_surface::RuledSurface;
use task::Cancel;

/// How much longer than the machine's tool flutes and holder may be drawn (mm).
const TOOL_MM: f64 = 1e-6;

/// The path in the positions of a machine.
#[derive(Debug, Clone)]
pub struct Milled {
    /// The machine.
    pub machine: Kinematics,
    /// Positions.
    pub line: MachinePath,
    /// Parameters of the positions.
    pub params: LinearisationParams,
    /// Contact of the flutes, for the feed.
    pub contact: Contact,
    /// Time of every move (min), one less than the positions.
    pub move_minutes: Vec<f64>,
    /// Time from the first position to the last (min).
    pub minutes: f64,
    /// Moves that are slower than asked for.
    pub slowed: Option<Slowed>,
}

/// The moves that lead to both ends of a path, outside first: from the side onto the surface, and along the cutter's
/// axis before that.
pub(super) fn leads(surface: &RuledSurface, path: &FlankPath, milling: &MillingSettings) -> [Vec<ToolPose>; 2] {
    let lead = |t: f64, u: f64| {
        let pose = path.pose(t);
        let normal = surface.normal(u, 0.5);
        // Square to the axis, so that the flutes come off all along.
        let off = (normal - pose.axis * normal.dot(pose.axis)).normalize_or_zero();
        let aside = pose.tip + milling.aside_mm * off;
        let lifted = aside + milling.retract_mm * pose.axis;
        let mut poses: Vec<DVec3> = Vec::new();
        for place in [aside, lifted] {
            if place != *poses.last().unwrap_or(&pose.tip) {
                poses.push(place);
            }
        }
        poses.into_iter().map(|tip| ToolPose { tip, axis: pose.axis }).collect::<Vec<_>>()
    };
    let mut approach = lead(0.0, 0.0);
    approach.reverse();
    [approach, lead(1.0, 1.0)]
}

/// The path with the moves that lead to it and from it.
///
/// # Errors
/// [`ToolPathError`].
pub(super) fn tool_path<'a>(
    path: &'a FlankPath,
    approach: &[ToolPose],
    retract: &[ToolPose],
) -> Result<ToolPath<'a>, ToolPathError> {
    let at = |t: f64| {
        let pose = path.pose(t);
        (pose.tip, pose.axis)
    };
    let places: Vec<f64> = path.poses.iter().map(|p| p.t).collect();
    ToolPath::with_leads(at, &places, approach, retract)
}

/// Chordal deviation: greatest distance of tip and flutes' top from the path on straight moves (mm), of cutter
/// locations, and of the machine's positions if there are any. Where a path cannot be resolved into such moves nothing
/// is written, and it is 0.
pub(super) fn chordal_deviation(
    path: &FlankPath,
    milling: &MillingSettings,
    [approach, retract]: [&[ToolPose]; 2],
    (cutter, milled): (&FlankCutter, Option<&Result<Milled, String>>),
) -> f64 {
    let straight = tool_path(path, approach, retract)
        .and_then(|path| path.straightened(milling.linearisation_mm, cutter.length_mm))
        .map_or(0.0, |straight| straight.chordal_deviation_mm);
    let of_machine = milled.and_then(|milled| milled.as_ref().ok()).map_or(0.0, |milled| milled.line.deviation_mm);
    straight.max(of_machine)
}

/// The positions of a machine along a path, or in one line why there are none.
pub(super) fn milled(
    machine: &MillingMachine,
    path: &ToolPath,
    (milling, cutter): (&MillingSettings, &FlankCutter),
    cancel: &Cancel,
) -> Result<Milled, String> {
    let (tool_mm, gauge_mm) = (cutter.tool_length(), machine.gauge_length_mm);
    if tool_mm > gauge_mm + TOOL_MM {
        return Err(format!(
            "flutes and holder are {tool_mm:.3} mm long, gauge length is {gauge_mm:.3} mm: correct the gauge length \
             or shorten the holder"
        ));
    }
    let machine = machine.kinematics().map_err(|e| e.to_string())?;
    let params = milling.linearisation(cutter.length_mm);
    let line = linearise(&machine, path, &params, cancel).map_err(|e| e.to_string())?;
    let post = milling_post(&milling.post).map_err(|e| e.to_string())?;
    let radii_mm = [0.0, cutter.length_mm].map(|height| cutter.radius_at(height));
    let contact = Contact { radii_mm, is_right: milling.cut == CutDirection::Climb };
    let paces = paces(&machine, path, &line, &milling.program.feeds(&params, &post, Some(contact)));
    let slowed = Slowed::of(&paces);
    let move_minutes: Vec<f64> = paces.iter().map(|p| p.minutes).collect();
    let minutes = move_minutes.iter().sum();
    Ok(Milled { machine, line, params, contact, move_minutes, minutes, slowed })
}
