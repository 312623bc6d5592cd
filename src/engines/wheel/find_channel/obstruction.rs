//! Metal within a passage that is none of its walls: a pin, a strut, a lump, a part left in place.

use glam::DVec3;
use rayon::prelude::*;

use super::super::channel::Channel;
use super::super::error::BliskError;
use super::super::passage::Passage;
use super::super::surface_finder::SurfaceFinder;
use geometry::frame::{Cylindrical, angle_near};
use geometry::mesh::{Bounds, Mesh, halved};
use task::{Cancel, Cancelled};

/// Share of the passage's height that metal must be off walls, hub and shroud not to belong to one of them.
const OFF_SHARE: f64 = 0.06;
/// Least distance that it must be off them (mm).
const LEAST_OFF: f64 = 0.1;
/// Share of the blades' span at either edge that is not looked at: round edges of neighbours reach into it.
const EDGE: f64 = 0.05;
/// Distance of the places on a triangle, as a share of the passage's height.
const STEP: f64 = 0.2;
/// Triangles between two looks at the cancel flag.
const BATCH: usize = 1024;

/// Refuses `channel` where `mesh`, in W, has metal in its passage that is too far off walls, hub and shroud to belong to
/// one of them.
///
/// # Errors
/// [`BliskError::Obstructed`] with the place that is deepest in the passage.
pub(super) fn check_unobstructed(channel: &Channel, mesh: &Mesh, cancel: &Cancel) -> Result<(), BliskError> {
    let Some(passage) = Passage::new(channel) else { return Ok(()) };
    let wall_points = || channel.low.points.iter().chain(&channel.high.points).copied();
    let around = Bounds::of(wall_points());
    // The walls wind about +Z; the passage lies between the least and the greatest angle of both.
    let middle = Cylindrical::from_point(channel.low.point(channel.low.nu / 2, channel.low.nv / 2)).theta;
    let thetas = wall_points().map(|p| angle_near(Cylindrical::from_point(p).theta, middle));
    let [least, most] = thetas.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], t| [a.min(t), b.max(t)]);
    let [from, to] = passage.span;
    let (from, to) = (from + EDGE * (to - from), to - EDGE * (to - from));
    let enough = |line: [f64; 2]| LEAST_OFF.max(OFF_SHARE * (line[1] - line[0]));
    // How far a place is off the nearest surface, to the walls around the axis; none outside the passage, or where it may
    // belong to a surface.
    let depth = |p: DVec3| {
        let Cylindrical { r, theta, .. } = Cylindrical::from_point(p);
        if !(least..=most).contains(&angle_near(theta, 0.5 * (least + most))) {
            return None;
        }
        let [along, height] = passage.along_and_height(p);
        if !(from..=to).contains(&along) {
            return None;
        }
        let [hub, shroud] = channel.line_at(along).ends;
        let [low, high] = passage.between(along, height.clamp(hub, shroud));
        let theta = angle_near(theta, 0.5 * (low + high));
        let off = ((theta - low) * r).min((high - theta) * r).min(height - hub).min(shroud - height);
        (off > enough([hub, shroud])).then_some(off)
    };
    let step = STEP * channel.middle().height();
    let of_batch = |batch: usize| {
        cancel.check()?;
        let triangles = batch * BATCH..((batch + 1) * BATCH).min(mesh.triangles.len());
        let pieces = triangles.flat_map(|i| halved(mesh.corners(i), &around, &|_, _| step)).flatten();
        Ok(pieces.filter_map(|p| Some((p, depth(p)?))).collect())
    };
    let batches = (0..mesh.triangles.len().div_ceil(BATCH)).into_par_iter().map(of_batch);
    let found: Vec<Vec<(DVec3, f64)>> = batches.collect::<Result<_, Cancelled>>()?;
    if found.iter().all(Vec::is_empty) {
        return Ok(());
    }
    let Ok(finder) = SurfaceFinder::new(channel.clone().into()) else { return Ok(()) };
    // A wall that stands aslant comes nearer beside the circle than on it.
    let off = |(p, around): (DVec3, f64)| {
        let off_mm = finder.wall_distances(p).into_iter().fold(around, f64::min);
        (off_mm > enough(channel.line_at(passage.along_and_height(p)[0]).ends)).then_some((p, off_mm))
    };
    // Of places as deep the first, on any number of threads.
    let deepest = found.into_par_iter().flatten().filter_map(off).reduce_with(|a, b| if b.1 > a.1 { b } else { a });
    deepest.map_or(Ok(()), |(at, off_mm)| Err(BliskError::Obstructed { at, off_mm }))
}
