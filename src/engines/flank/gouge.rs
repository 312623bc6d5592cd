//! Gouging of neighbouring walls by the cutter, and of everything by its holder: the least clearance along the path.
//! What of a mesh is a wall, [`Walls`] tells.
//!
//! The tool is a stack of frusta; each is convex, and so is the signed distance to it. Boxes of the mesh and triangles
//! are left out where that distance cannot be less than the least found, and stretches of the path where the tool
//! cannot come nearer by moving. So nothing is stepped over: no clearance is less than the answer by more than
//! [`slack`], 0.001 mm near a touch.

use std::collections::BinaryHeap;

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

use super::FlankError;
use super::cutter::FlankCutter;
use super::frustum_distance::{EXACT, Frustum, nearest_on};
use super::path::{FlankPath, FlankPose};
use super::walls::Walls;
use geometry::bvh::Bvh;
use task::{Cancel, Task};

/// Accuracy of clearances near contact (mm).
pub const TOLERANCE: f64 = 1e-3;

/// Part of the tool that comes near.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ToolPart {
    /// The flutes.
    Cutter,
    /// The part of the holder with this number, from below.
    Holder(usize),
}

/// The place of a path where a part of the tool is nearest to a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Clearance {
    /// Part of the tool.
    pub part: ToolPart,
    /// Distance (mm), to within [`slack`]; negative by the depth where it gouges, less what is allowed at the border of
    /// the milled face.
    pub distance_mm: f64,
    /// Place on the mesh.
    pub point: DVec3,
    /// Parameter t of the path at the place.
    pub t: f64,
}

/// Least clearances of a path.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct GougeCheck {
    /// Clearance of the flutes from neighbouring walls; none if there are none near.
    pub cutter: Option<Clearance>,
    /// Clearance of the holder from everything; none without a holder or if nothing is near.
    pub holder: Option<Clearance>,
}

impl GougeCheck {
    /// Distance from the tool beyond which nothing is searched for (mm).
    pub const FAR: f64 = 50.0;

    /// The worse of both clearances that is below `-tolerance` (mm): a gouge.
    pub fn gouge(&self, tolerance: f64) -> Option<Clearance> {
        let both = [self.cutter, self.holder].into_iter().flatten().filter(|c| c.distance_mm < -tolerance);
        both.min_by(|a, b| a.distance_mm.total_cmp(&b.distance_mm))
    }

    /// Gouges deeper than `tolerance` (mm), in words.
    pub fn warnings(&self, tolerance: f64) -> Vec<String> {
        let gouges = [self.cutter, self.holder].into_iter().flatten().filter(|c| c.distance_mm < -tolerance);
        let words = |c: Clearance| {
            let (depth, at, t) = (-c.distance_mm, c.point, c.t);
            let place = format!("at ({:.3}, {:.3}, {:.3}), t = {t:.4}", at.x, at.y, at.z);
            match c.part {
                ToolPart::Cutter => format!(
                    "the cutter gouges a neighbouring wall {depth:.4} mm deep {place}; take a thinner or shorter \
                     cutter, or end the path before"
                ),
                ToolPart::Holder(part) => format!(
                    "part {} of the holder runs {depth:.4} mm into the part {place}; take longer flutes or a \
                     slimmer holder",
                    part + 1
                ),
            }
        };
        gouges.map(words).collect()
    }
}

/// Checks a path: the flutes against the walls beside the surface, the holder against everything.
///
/// # Errors
/// Cancelled.
pub fn check(path: &FlankPath, cutter: &FlankCutter, walls: &Walls, task: &Task) -> Result<GougeCheck, FlankError> {
    check_along(&|t| path.pose(t), cutter, walls, task)
}

/// Checks straight moves without turns through `places` of the tip, as t from 0 to 1, in the same way.
///
/// # Errors
/// Cancelled.
pub fn check_moves(
    (places, axis): (&[DVec3], DVec3),
    cutter: &FlankCutter,
    walls: &Walls,
    task: &Task,
) -> Result<GougeCheck, FlankError> {
    let [.., _, _] = places else { return Ok(GougeCheck::default()) };
    let pose = |t: f64| {
        let along = t.clamp(0.0, 1.0) * (places.len() - 1) as f64;
        let i = (along as usize).min(places.len() - 2);
        FlankPose { t, tip: places[i].lerp(places[i + 1], along - i as f64), axis }
    };
    check_along(&pose, cutter, walls, task)
}

/// Triangles, and how deep the points of each may lie in the tool (mm); none where nothing is said.
type Wall<'a> = (&'a Bvh, &'a [f64]);

/// Where the cutter is at t from 0 to 1.
type Motion<'a> = &'a (dyn Fn(f64) -> FlankPose + Sync);

fn check_along(motion: Motion, cutter: &FlankCutter, walls: &Walls, task: &Task) -> Result<GougeCheck, FlankError> {
    task.report("gouge of neighbouring walls", 0.0, "");
    let (flutes, holder) = tool_of(cutter);
    let cutter_clearance = least(motion, &[flutes], (&walls.beside, &walls.allowed), &task.cancel)?;
    task.report("gouge by the holder", 0.5, "");
    let holder_clearance = least(motion, &holder, (&walls.whole, &[]), &task.cancel)?;
    task.report("gouge by the holder", 1.0, "");
    Ok(GougeCheck { cutter: cutter_clearance, holder: holder_clearance })
}

/// The flutes, and the parts of what holds them from below upwards.
pub(super) fn tool_of(cutter: &FlankCutter) -> ((ToolPart, Frustum), Vec<(ToolPart, Frustum)>) {
    let radii = [cutter.radius_mm, cutter.radius_at(cutter.length_mm)];
    let flutes = Frustum { heights: [0.0, cutter.length_mm], radii };
    let mut bottom = cutter.length_mm;
    let mut holder = Vec::new();
    for (i, part) in cutter.holder.iter().enumerate() {
        let heights = [bottom, bottom + part.length_mm];
        holder.push((ToolPart::Holder(i), Frustum { heights, radii: [part.lower_radius_mm, part.upper_radius_mm] }));
        bottom = heights[1];
    }
    ((ToolPart::Cutter, flutes), holder)
}

/// A stretch of the path that is still to be looked at; those that may hold the least come first.
#[derive(Debug, Clone, Copy)]
struct Stretch {
    /// No clearance on it is less (mm).
    bound: f64,
    from: f64,
    to: f64,
}

impl PartialEq for Stretch {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}
impl Eq for Stretch {}
impl PartialOrd for Stretch {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Stretch {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        other.bound.total_cmp(&self.bound).then(other.from.total_cmp(&self.from))
    }
}

/// The least clearance of a stack of frusta along the path.
fn least(
    motion: Motion,
    tool: &[(ToolPart, Frustum)],
    wall: Wall,
    cancel: &Cancel,
) -> Result<Option<Clearance>, FlankError> {
    const FIRST: usize = 32;
    if wall.0.is_empty() || tool.is_empty() {
        return Ok(None);
    }
    let at = |t: f64, most: f64| nearest(wall, tool, &motion(t), t, most);
    let mut best: Option<Clearance> = None;
    let mut open = BinaryHeap::new();
    for i in 0..FIRST {
        let [from, to] = [i, i + 1].map(|k| k as f64 / FIRST as f64);
        open.push(Stretch { bound: f64::NEG_INFINITY, from, to });
    }
    loop {
        cancel.check()?;
        let most = best.map_or(GougeCheck::FAR, |b| b.distance_mm);
        let enough = most - slack(most);
        // A fixed number at once, so that the answer is the same on any number of threads.
        let batch: Vec<Stretch> =
            std::iter::from_fn(|| open.pop().filter(|stretch| stretch.bound < enough)).take(FIRST).collect();
        if batch.is_empty() {
            return Ok(best);
        }
        // What is further off than the least found by more than the tool moves does not matter on a stretch.
        let look = |stretch: &Stretch| {
            let moves = greatest_move(motion, tool, stretch.from, stretch.to);
            (moves, at(0.5 * (stretch.from + stretch.to), most + moves))
        };
        let found: Vec<(f64, Option<Clearance>)> = batch.par_iter().map(look).collect();
        for found in found.iter().filter_map(|f| f.1) {
            if best.is_none_or(|b| found.distance_mm < b.distance_mm) && found.distance_mm < GougeCheck::FAR {
                best = Some(found);
            }
        }
        let least = best.map_or(GougeCheck::FAR, |b| b.distance_mm);
        for (Stretch { from, to, .. }, (moves, found)) in batch.into_iter().zip(found) {
            let bound = found.map_or(most + moves, |f| f.distance_mm) - moves - EXACT;
            if bound < least - slack(least) && to - from > 1e-9 {
                let middle = 0.5 * (from + to);
                open.push(Stretch { bound, from, to: middle });
                open.push(Stretch { bound, from: middle, to });
            }
        }
    }
}

/// How much less (mm) a clearance may be than the one that is answered: where nothing is touched, and where all is
/// lost, it need not be known so well. A tool that slides along a wall would else be looked at everywhere.
pub fn slack(distance_mm: f64) -> f64 {
    const SHARE: f64 = 0.05;
    TOLERANCE.max(SHARE * distance_mm.abs())
}

/// No point of the tool moves more (mm) between the middle and any other place of the stretch. Ends and middle of the
/// axis are compared at several places; a cubic that turns more between them would need a stretch to be longer than a
/// piece of the path, and half as much again is allowed for.
fn greatest_move(motion: Motion, tool: &[(ToolPart, Frustum)], from: f64, to: f64) -> f64 {
    const LOOKS: i32 = 8;
    const SAFETY: f64 = 1.5;
    let (mut reach, mut radius) = (0.0f64, 0.0f64);
    for (_, part) in tool {
        reach = reach.max(part.heights[1]);
        radius = radius.max(part.radii[0]).max(part.radii[1]);
    }
    let middle = motion(0.5 * (from + to));
    let moves = (0..=LOOKS).map(|i| {
        let pose = motion(from + (to - from) * f64::from(i) / f64::from(LOOKS));
        let turn = (pose.axis - middle.axis).length();
        let tip = pose.tip.distance(middle.tip);
        let top = (pose.tip + reach * pose.axis).distance(middle.tip + reach * middle.axis);
        tip.max(top) + radius * turn
    });
    SAFETY * moves.fold(0.0, f64::max)
}

/// The least clearance at one place, if it is less than `most`.
fn nearest(wall: Wall, tool: &[(ToolPart, Frustum)], pose: &FlankPose, t: f64, most: f64) -> Option<Clearance> {
    let mut best: Option<Clearance> = None;
    for (part, frustum) in tool {
        let limit = best.map_or(most, |b| b.distance_mm);
        if let Some((distance_mm, point)) = nearest_to(wall, frustum, pose, limit) {
            best = Some(Clearance { part: *part, distance_mm, point, t });
        }
    }
    best
}

fn nearest_to((tree, allowed): Wall, frustum: &Frustum, pose: &FlankPose, most: f64) -> Option<(f64, DVec3)> {
    let (mut best, mut least) = (None, most);
    let mut open = vec![0];
    while let Some(index) = open.pop() {
        let node = tree.node(index);
        let (distance, slope) = frustum.distance(pose, node.bounds.center);
        // Convex: nowhere below its tangent plane; and it changes by no more than the way.
        let by_plane = distance + node.bounds.least_along(slope) - slope.dot(node.bounds.center);
        if by_plane.max(distance - node.radius) >= least {
            continue;
        }
        if let Some([first, second]) = tree.children(index) {
            let off = |i: u32| frustum.distance(pose, tree.node(i).bounds.center).0 - tree.node(i).radius;
            // The one that may be nearer is looked at first.
            open.extend(if off(first) < off(second) { [second, first] } else { [first, second] });
        } else {
            // A touch is not nearer than another touch, however deep it may be: the search then ends where it should.
            let allowed = allowed.get(node.triangle as usize).copied().unwrap_or(0.0);
            let limit = if least > 0.0 { least } else { least - allowed };
            if let Some((distance, point)) = nearest_on(*tree.corners(node.triangle), frustum, pose, limit) {
                least = if distance < 0.0 { (distance + allowed).min(0.0) } else { distance };
                best = Some((least, point));
            }
        }
    }
    best
}
