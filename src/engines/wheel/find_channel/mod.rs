//! Finds a channel of a blisk, with its walls, in a bare mesh.

mod agreement;
mod measure;
mod meridian;
#[cfg(test)]
mod tests;
mod walls;

use std::borrow::Cow;
use std::f64::consts::TAU;

use self::meridian::{Meridian, Place, Tracer};
use self::walls::{INSET, WallFinder};
use super::channel::Channel;
use super::error::BliskError;
use super::frame::slices::{Gap, Slices};
use super::frame::{BliskFrame, find_frame, is_inside_out};
use super::options::BliskOptions;
use geometry::frame::Frame;
use geometry::mesh::Mesh;
use task::{Cancel, Task};

/// Finds the axis, the blades and the chosen channel of `mesh` (mm, closed, in any attitude).
///
/// W's X runs along the blisk axis, towards the positive side of the mesh axis it is nearest to; its origin is
/// the foot of the mesh's origin on the axis, and the middle of the channel (half way between the blades'
/// edges, half way up, half way across) lies on +Z.
///
/// # Errors
/// [`BliskError`] says what could not be found, why, and which key of the project gives it by hand.
pub fn find_channel(mesh: &Mesh, options: &BliskOptions, task: &Task) -> Result<Channel, BliskError> {
    let (mesh, mut assumed) = prepared(mesh, options)?;
    let blisk = find_frame(&mesh, options, task)?;
    assumed.extend(blisk.assumed.iter().cloned());
    channel_of(&mesh, &blisk, options, assumed, task)
}

/// The mesh with its normals outwards, and what was assumed for that.
pub(super) fn prepared<'a>(mesh: &'a Mesh, options: &BliskOptions) -> Result<(Cow<'a, Mesh>, Vec<String>), BliskError> {
    options.validate().map_err(BliskError::Options)?;
    if !is_inside_out(mesh)? {
        return Ok((Cow::Borrowed(mesh), Vec::new()));
    }
    let triangles = mesh.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
    let turned = Mesh { vertices: mesh.vertices.clone(), triangles };
    Ok((Cow::Owned(turned), vec!["The mesh is inside out; its triangles were turned over.".into()]))
}

/// The chosen channel of a blisk whose axis and period are known. `assumed` is carried on.
pub(super) fn channel_of(
    mesh: &Mesh,
    blisk: &BliskFrame,
    options: &BliskOptions,
    mut assumed: Vec<String>,
    task: &Task,
) -> Result<Channel, BliskError> {
    let blades = blisk.repetition.blades;
    if options.channel >= blades {
        return Err(BliskError::NoSuchChannel { index: options.channel, blades });
    }
    task.report("channel", 0.0, "place");
    let (frame, start) = place_channel(mesh, blisk, options, &task.cancel)?;

    task.report("channel", 0.3, "end walls");
    let slices = Slices::new(mesh.in_frame(&frame));
    let tracer = Tracer { slices: &slices, pitch: TAU / blades as f64, options, cancel: &task.cancel };
    let lost = BliskError::LostWall { x: start.x, r: start.r };
    let gap = tracer.bladed_gap(start.x, start.r, &start.gap).ok_or(lost)?;
    let start = Place { gap, ..start };
    let Meridian { samples: meridian, shrouded } = tracer.meridian(start)?;

    task.report("channel", 0.6, "walls");
    let finder = WallFinder { tracer: &tracer, meridian: &meridian, start };
    let [mut low, mut high] = finder.walls(options.wall_points_chord, options.wall_points_span)?;
    let throat = measure::throat(&low, &high);
    let (turning, sides) = measure::turning(&low, &high);
    [low.side, high.side] = sides;
    let faces_x = measure::faces_x(slices.mesh(), &meridian);
    assumed.extend(end_wall_assumptions(options, shrouded));
    let agreement = agreement::agreement(&tracer, &meridian, shrouded, [&low, &high], &throat)?;
    task.report("channel", 1.0, "");
    let index = options.channel;
    Ok(Channel { frame, blades, index, shrouded, meridian, low, high, throat, turning, faces_x, agreement, assumed })
}

/// W of the chosen channel, and the channel's middle in it.
fn place_channel(
    mesh: &Mesh,
    blisk: &BliskFrame,
    options: &BliskOptions,
    cancel: &Cancel,
) -> Result<(Frame, Place), BliskError> {
    let slices = Slices::new(mesh.in_frame(&blisk.frame));
    let pitch = TAU / blisk.repetition.blades as f64;
    let tracer = Tracer { slices: &slices, pitch, options, cancel };
    let (x, r) = (blisk.middle.x, blisk.middle.y);
    let gap = slices.gaps(x, r).into_iter().find(|g| g.width() < 1.5 * pitch);
    let mut place = middle_of(&tracer, Place { x, r, gap: gap.ok_or(BliskError::LostWall { x, r })? })?;

    // The same again from the chosen channel, since facets differ a little from channel to channel.
    let (x, r) = (place.x, place.r);
    let theta = place.gap.middle();
    // Channels are counted from the one nearest to theta = 0; of two equally near ones, the one of greater theta.
    let nearest = theta - pitch * ((theta / pitch - 0.5) - 1e-6).ceil();
    let turn = nearest + pitch * options.channel as f64 - theta;
    let chosen = tracer.bladed_gap(x, r, &turned(place.gap, turn)).ok_or(BliskError::LostWall { x, r })?;
    place = middle_of(&tracer, Place { x, r, gap: chosen })?;
    let theta = place.gap.middle();
    place.gap = turned(place.gap, -theta);
    Ok((blisk.frame.turned_about_x(theta), place))
}

/// The middle of the channel through a place: half way between the edges, half way up.
fn middle_of(tracer: &Tracer, start: Place) -> Result<Place, BliskError> {
    let meridian = tracer.meridian(start)?.samples;
    let finder = WallFinder { tracer, meridian: &meridian, start };
    let row = finder.row(0.5)?;
    finder.place(&row, 0.5 * (row.front.x + row.back.x))
}

fn turned(mut gap: Gap, angle: f64) -> Gap {
    gap.low.theta += angle;
    gap.high.theta += angle;
    gap
}

fn end_wall_assumptions(options: &BliskOptions, shrouded: bool) -> Vec<String> {
    let mut assumed = Vec::new();
    match options.hub_radius_mm.given() {
        Some(r) => assumed.push(format!("The hub radius was given: {r} mm along the whole channel.")),
        None => assumed.push("The hub radius is the greatest met over the middle 60 % of the channel's width.".into()),
    }
    assumed.push(match (options.shroud_radius_mm.given(), shrouded) {
        (Some(r), _) => format!("The shroud radius was given: {r} mm along the whole channel."),
        (None, true) => "The shroud radius is the least met over the middle 60 % of the channel's width.".into(),
        (None, false) => "No shroud was met along the radius; the blade tips bound the channel instead.".into(),
    });
    assumed.push(format!(
        "The walls were measured up to {} % of the height away from hub and {}.",
        100.0 * INSET,
        if shrouded { "shroud" } else { "tips" }
    ));
    assumed
}
