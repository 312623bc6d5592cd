//! Metal within a passage that is none of its walls: a pin, a strut, a lump, a part left in place.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use glam::DVec3;
use rayon::prelude::*;

use super::super::channel::{Channel, Difference, Unlike};
use super::super::error::BliskError;
use super::super::passage::Passage;
use super::super::surface_finder::SurfaceFinder;
use geometry::frame::Cylindrical;
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
/// Triangles that are looked at in one go.
const BATCH: usize = 1024;

/// A place within a passage.
#[derive(Clone, Copy)]
struct Within {
    /// Number of the passage, counted on from the chosen one in channels of its kind.
    number: i64,
    /// The place, turned back to the chosen passage (mm, in W).
    at: DVec3,
    /// How far it is off the nearest surface (mm).
    off: f64,
}

/// The channels of the kind of `channel` in whose passages `mesh`, in W, has metal that is too far off walls, hub and shroud
/// to belong to one of them; their numbers are counted on from this one.
///
/// # Errors
/// [`BliskError::Obstructed`] with the place that is deepest in the passage, where it is this one's.
pub(super) fn obstructed(channel: &Channel, mesh: &Mesh, cancel: &Cancel) -> Result<Vec<Unlike>, BliskError> {
    let Some(passage) = Passage::new(channel) else { return Ok(Vec::new()) };
    let wall_points = || channel.low.points.iter().chain(&channel.high.points).copied();
    let walls = Bounds::of(wall_points());
    let reach = wall_points().map(|p| p.y.hypot(p.z)).fold(0.0, f64::max);
    let around = Bounds { min: DVec3::new(walls.min.x, -reach, -reach), max: DVec3::new(walls.max.x, reach, reach) };
    let inner = channel.meridian.iter().map(|s| s.hub.y.min(s.shroud.y)).fold(f64::INFINITY, f64::min);
    // The passage lies between the least and the greatest angle of both walls, which may be more than a turn apart.
    let thetas = wall_points().flat_map(|p| {
        let [along, height] = passage.along_and_height(p);
        passage.between(along, height)
    });
    let [least, most] = thetas.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], t| [a.min(t), b.max(t)]);
    let count = (channel.blades / channel.kinds) as i64;
    let period = TAU / count as f64;
    let [from, to] = passage.span;
    let (from, to) = (from + EDGE * (to - from), to - EDGE * (to - from));
    let enough = |line: [f64; 2]| LEAST_OFF.max(OFF_SHARE * (line[1] - line[0]));
    // How far a place is off the nearest surface, to the walls around the axis, turned back to this channel; none outside
    // the passages, or where it may belong to a surface.
    let depths = |p: DVec3| -> Vec<Within> {
        let Cylindrical { x, r, theta } = Cylindrical::from_point(p);
        let [along, height] = passage.along_and_height(p);
        if !(from..=to).contains(&along) {
            return Vec::new();
        }
        let [hub, shroud] = channel.line_at(along).ends;
        let off_ends = (height - hub).min(shroud - height);
        if off_ends <= enough([hub, shroud]) {
            return Vec::new();
        }
        // At one height the blades may begin or end further along than at another: there edges of others stand beside them.
        let walls = passage.walls_at(along, height.clamp(hub, shroud));
        if walls.iter().any(|wall| wall.past_edge) {
            return Vec::new();
        }
        let [low, high] = walls.map(|wall| wall.theta);
        // Passages that wind by more than a pitch lie beside each other at one angle.
        let (first, last) = (((theta - most) / period).ceil() as i64, ((theta - least) / period).floor() as i64);
        let of = |number: i64| {
            let theta = theta - number as f64 * period;
            let off = ((theta - low) * r).min((high - theta) * r).min(off_ends);
            let at = Cylindrical { x, r, theta }.point();
            (off > enough([hub, shroud])).then_some(Within { number: number.rem_euclid(count), at, off })
        };
        (first..=last).filter_map(of).collect()
    };
    let step = STEP * channel.middle().height();
    let of_batch = |batch: usize| {
        let triangles = (batch * BATCH..((batch + 1) * BATCH).min(mesh.triangles.len())).map(|i| mesh.corners(i));
        // A triangle reaches no further from the axis than its corners.
        let outside = triangles.filter(|corners| corners.iter().any(|p| p.y.hypot(p.z) > inner));
        let mut found = Vec::new();
        for corners in outside {
            cancel.check()?;
            found.extend(halved(corners, &around, &|_, _| step).into_iter().flatten().flat_map(depths));
        }
        Ok(found)
    };
    let batches = (0..mesh.triangles.len().div_ceil(BATCH)).into_par_iter().map(of_batch);
    let found: Vec<Vec<Within>> = batches.collect::<Result<_, Cancelled>>()?;
    if found.iter().all(Vec::is_empty) {
        return Ok(Vec::new());
    }
    let Ok(finder) = SurfaceFinder::new(channel.clone().into()) else { return Ok(Vec::new()) };
    // A wall that stands aslant comes nearer beside the circle than on it.
    let off = |within: Within| {
        cancel.check()?;
        let off = finder.wall_distances(within.at).into_iter().fold(within.off, f64::min);
        let enough = enough(channel.line_at(passage.along_and_height(within.at)[0]).ends);
        Ok((off > enough).then_some(Within { off, ..within }))
    };
    let found: Vec<Option<Within>> = found.into_par_iter().flatten().map(off).collect::<Result<_, Cancelled>>()?;
    let mut deepest: BTreeMap<i64, Within> = BTreeMap::new();
    for within in found.into_iter().flatten() {
        // Of places as deep the first, on any number of threads.
        let known = deepest.entry(within.number).or_insert(within);
        if within.off > known.off {
            *known = within;
        }
    }
    if let Some(&Within { at, off, .. }) = deepest.get(&0) {
        return Err(BliskError::Obstructed { at, off_mm: off });
    }
    let unlike = |within: Within| Unlike {
        number: within.number as usize * channel.kinds,
        difference: Difference::Obstructed { off_mm: within.off },
    };
    Ok(deepest.into_values().map(unlike).collect())
}
