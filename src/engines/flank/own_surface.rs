//! Effect of the whole tool on the design surface itself, all along the path.
//!
//! Deviation and envelope are taken where the cutter stands over a place. Elsewhere on the path it may come back to
//! that place from aside: the other lip of a groove, the other leg of a corner. So every place of a grid is held
//! against every position of flutes and holder; stretches of the path are divided until none can hide a deeper cut.
//!
//! Guaranteed: no place of the grid is cut deeper than said, by more than [`EXACT`]. Not guaranteed: what happens
//! between places of the grid.

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use serde::Serialize;

use super::FlankError;
use super::cutter::FlankCutter;
use super::deviation::{DesignGrid, GridPlace};
use super::envelope;
use super::frustum_distance::Frustum;
use super::gouge::{ToolPart, tool_of};
use super::path::{FlankPath, FlankPose};
use task::Task;

/// Accuracy of depths (mm).
pub const EXACT: f64 = 1e-3;

/// A place of the design surface that the tool cuts deeper than the moving cutter does where it stands over it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct OwnGouge {
    /// Along the guides.
    pub u: f64,
    /// Along the ruling.
    pub v: f64,
    /// Position (mm).
    pub point: DVec3,
    /// Part of the tool that cuts the surface.
    pub part: ToolPart,
    /// Parameter t of the path at the place.
    pub t: f64,
    /// Depth of the point in the tool (mm).
    pub depth_mm: f64,
    /// Depth of cut of the swept envelope above it (mm); 0 if it leaves stock.
    pub expected_mm: f64,
}

impl OwnGouge {
    /// Depth beyond the expected one (mm).
    pub fn excess_mm(&self) -> f64 {
        self.depth_mm - self.expected_mm
    }
}

/// Check of the whole tool against the design surface.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OwnSurfaceCheck {
    /// Places along u and v.
    pub grid: [usize; 2],
    /// Tolerance beyond the cut of the moving cutter where it stands (mm).
    pub tolerance_mm: f64,
    /// Places that are cut deeper than that.
    pub count: usize,
    /// Place that is cut deepest beyond what is expected.
    pub worst: Option<OwnGouge>,
}

impl OwnSurfaceCheck {
    /// Whether no place is cut deeper than expected.
    pub fn holds(&self) -> bool {
        self.worst.is_none()
    }

    /// Result in words.
    pub fn text(&self) -> String {
        let [nu, nv] = self.grid;
        let Some(worst) = &self.worst else {
            return format!(
                "no sample of {nu} x {nv} is cut more than {} mm deeper than at its nearest location",
                self.tolerance_mm
            );
        };
        let part = match worst.part {
            ToolPart::Cutter => "the flutes".to_owned(),
            ToolPart::Holder(i) => format!("part {} of the holder", i + 1),
        };
        format!(
            "{part} cut the surface itself {:.4} mm deep at u = {:.4}, v = {:.4} while at t = {:.4} ({} of {nu} x {nv} \
             places are cut deeper than {} mm beyond what is expected there, {:.4} mm); take a thinner cutter, or \
             divide the surface",
            worst.depth_mm, worst.u, worst.v, worst.t, self.count, self.tolerance_mm, worst.expected_mm
        )
    }
}

/// Holds every place of a `grid` of the design surface against the whole `cutter`, flutes and holder, all along `path`.
/// A place fails where it lies deeper in the tool than the moving cutter cuts there, by more than `tolerance_mm`.
///
/// # Errors
/// [`FlankError::Parameter`] if the grid is empty or too fine; cancelled.
pub fn own_surface(
    path: &FlankPath,
    cutter: &FlankCutter,
    (grid, tolerance_mm): (&DesignGrid, f64),
    task: &Task,
) -> Result<OwnSurfaceCheck, FlankError> {
    const MOST: usize = 200_000;
    let size = grid.size();
    let places = size[0].saturating_mul(size[1]);
    if size[0] < 2 || size[1] < 2 || places > MOST {
        let wanted = "2 places at least both ways, and at most 200000 in all";
        return Err(FlankError::Parameter { name: "grid of the surface's own check", value: places as f64, wanted });
    }
    task.report("the tool against its own surface", 0.0, "");
    let touching = cutter.above(path.below_mm)?;
    let moving = moving(grid, path, &touching);
    let (flutes, holder) = tool_of(cutter);
    let tool: Vec<(ToolPart, Frustum)> = std::iter::once(flutes).chain(holder).collect();
    let one = |(place, moving): (&GridPlace, &Option<f64>)| -> Result<Option<OwnGouge>, FlankError> {
        task.check()?;
        let (u, v, point) = (place.at.u, place.at.v, place.at.point);
        // Where the cutter stands nowhere over a place, nothing is expected.
        let expected_mm = moving.map_or(0.0, |moving| -moving).max(0.0);
        let found = deepest(path, &tool, point, -expected_mm - tolerance_mm);
        Ok(found.map(|(distance, t, part)| OwnGouge { u, v, point, part, t, depth_mm: -distance, expected_mm }))
    };
    let found: Result<Vec<Option<OwnGouge>>, FlankError> =
        grid.grid_places().par_iter().zip(&moving).map(one).collect();
    let found = found?;
    let gouges = || found.iter().take(grid.counted_places().len()).flatten();
    let worst = gouges().max_by(|a, b| a.excess_mm().total_cmp(&b.excess_mm())).copied();
    task.report("the tool against its own surface", 1.0, "");
    Ok(OwnSurfaceCheck { grid: grid.counted_size(), tolerance_mm, count: gouges().count(), worst })
}

/// The least distance from a point to the tool along the path, where and by which part, if it is less than `most`.
fn deepest(path: &FlankPath, tool: &[(ToolPart, Frustum)], p: DVec3, most: f64) -> Option<(f64, f64, ToolPart)> {
    const SHORTEST: f64 = 1e-9;
    let pieces = path.axis.pieces();
    let (mut best, mut least) = (None, most);
    let mut open: Vec<(usize, f64, f64)> = (0..pieces).rev().map(|piece| (piece, 0.5, 0.5)).collect();
    while let Some((piece, middle, half)) = open.pop() {
        let (at, [tip_moves, turns]) = path.axis.stretch(piece, middle, half);
        let (axis, t) = (at.axis(), (piece as f64 + middle) / pieces as f64);
        let pose = FlankPose { t, tip: at.tip - path.below_mm * axis, axis };
        // Height and distance from the axis, on which all depends, change by no more than this.
        let moves = tip_moves + turns * p.distance(at.tip);
        let mut here = f64::INFINITY;
        for (part, frustum) in tool {
            let distance = frustum.distance(&pose, p).0;
            here = here.min(distance);
            if distance < least {
                (least, best) = (distance, Some((distance, t, *part)));
            }
        }
        if here - moves < least - EXACT && half > SHORTEST {
            let quarter = 0.5 * half;
            open.extend([(piece, middle + quarter, quarter), (piece, middle - quarter, quarter)]);
        }
    }
    best
}

/// Deviation of the moving cutter over the places of a grid; none where it stands nowhere over one.
pub(super) fn moving(grid: &DesignGrid, path: &FlankPath, touching: &FlankCutter) -> Vec<Option<f64>> {
    let standing = grid.measured(&path.axis, touching, None);
    let over = |(place, standing): (&GridPlace, &Option<(f64, DVec2)>)| {
        let (still, foot) = (*standing)?;
        let grazing = envelope::envelope_over(&path.axis, touching, place, foot);
        Some(grazing.and_then(|g| g.above).unwrap_or(still))
    };
    grid.grid_places().par_iter().zip(&standing).map(over).collect()
}
