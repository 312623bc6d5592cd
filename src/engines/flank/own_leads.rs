//! Effect of the whole tool on the design surface itself on the straight moves that lead to a path and away from it.
//!
//! Guaranteed: no place of the grid is cut deeper than said, by more than [`EXACT`]. Not guaranteed: what happens
//! between places of the grid.

use glam::DVec3;
use rayon::prelude::*;

use super::FlankError;
use super::cutter::FlankCutter;
use super::deviation::{DesignGrid, GridPlace};
use super::frustum_distance::Frustum;
use super::gouge::{ToolPart, tool_of};
use super::own_surface::{EXACT, OwnGouge};
use super::path::FlankPose;
use task::Cancel;

/// The place of the surface that the tool cuts deepest beyond what is expected while its tip goes straight through
/// `places` (mm) without turning; its t is the share of these moves. The first of the places is the end of the path: as
/// deep as the tool lies there is expected, and `tolerance_mm` beyond it is allowed. None if nothing is cut deeper.
///
/// # Errors
/// Cancelled.
pub fn own_gouge_of_moves(
    (places, axis): (&[DVec3], DVec3),
    cutter: &FlankCutter,
    (grid, tolerance_mm): (&DesignGrid, f64),
    cancel: &Cancel,
) -> Result<Option<OwnGouge>, FlankError> {
    let Some(first) = places.first() else { return Ok(None) };
    let (flutes, holder) = tool_of(cutter);
    let tool: Vec<(ToolPart, Frustum)> = std::iter::once(flutes).chain(holder).collect();
    let on_path = FlankPose { t: 0.0, tip: *first, axis };
    let moves: Vec<[DVec3; 2]> = places.windows(2).map(|w| [w[0], w[1]]).collect();
    let one = |place: &GridPlace| -> Result<Option<OwnGouge>, FlankError> {
        cancel.check()?;
        let (u, v, point) = (place.at.u, place.at.v, place.at.point);
        let here = tool.iter().map(|(_, part)| part.distance(&on_path, point).0).fold(f64::INFINITY, f64::min);
        let expected_mm = (-here).max(0.0);
        let (mut least, mut worst) = (-expected_mm - tolerance_mm, None);
        for (i, ends) in moves.iter().enumerate() {
            for (part, frustum) in &tool {
                let Some((distance, share)) = least_on_move(frustum, (*ends, axis), point, least) else { continue };
                let (part, t) = (*part, (i as f64 + share) / moves.len() as f64);
                least = distance;
                worst = Some(OwnGouge { u, v, point, part, t, depth_mm: -distance, expected_mm });
            }
        }
        Ok(worst)
    };
    let found: Result<Vec<Option<OwnGouge>>, FlankError> = grid.grid_places().par_iter().map(one).collect();
    let deeper = found?.into_iter().flatten();
    Ok(deeper.max_by(|a, b| a.excess_mm().total_cmp(&b.excess_mm())))
}

/// The least distance (mm) of a point to a frustum whose tip goes straight from one end to the other, and at which
/// share of the way, if it is less than `most`. The distance to a convex body is convex along a straight line, so that
/// its slope says on which side of a place the least lies.
fn least_on_move(
    frustum: &Frustum,
    ([from, to], axis): ([DVec3; 2], DVec3),
    p: DVec3,
    most: f64,
) -> Option<(f64, f64)> {
    const ROUNDS: usize = 60;
    let way = to - from;
    let (mut least, mut best) = (most, None);
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..ROUNDS {
        let share = 0.5 * (low + high);
        let (distance, gradient) = frustum.distance(&FlankPose { t: share, tip: from + share * way, axis }, p);
        if distance < least {
            (least, best) = (distance, Some((distance, share)));
        }
        // The tool goes one way, the point goes the other as seen from it.
        let slope = -gradient.dot(way);
        let half = 0.5 * (high - low);
        // Nowhere on the stretch is it less than its tangent at the middle says.
        if distance - slope.abs() * half >= least - EXACT {
            break;
        }
        if slope > 0.0 {
            high = share;
        } else {
            low = share;
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_distance_on_a_move_is_that_of_dense_sampling() {
        let cone = Frustum { heights: [0.0, 12.0], radii: [1.5, 4.0] };
        let axis = DVec3::new(1.0, -2.0, 2.0) / 3.0;
        let ends = [DVec3::new(0.0, 1.0, -2.0), DVec3::new(9.0, -4.0, 6.0)];
        let mut met = 0;
        for k in 0..200u32 {
            let at = |m: u32, n: u32| -6.0 + 18.0 * f64::from(k * m % n) / f64::from(n);
            let p = DVec3::new(at(37, 101), at(53, 103), at(71, 107));
            let pose = |i: u32| FlankPose { t: 0.0, tip: ends[0].lerp(ends[1], f64::from(i) / 5000.0), axis };
            let dense = (0..=5000).map(|i| cone.distance(&pose(i), p).0).fold(f64::INFINITY, f64::min);
            let found = least_on_move(&cone, (ends, axis), p, 3.0).map(|f| f.0);
            met += usize::from(dense < 0.0);
            assert!(found.is_some() || dense > 3.0 - EXACT, "{p}: {dense}");
            assert!(found.is_none_or(|f| f > dense - 1e-9 - 2e-3 && f < dense + EXACT), "{p}: {found:?} {dense}");
        }
        assert!(met > 5, "some lie in the way");
    }
}
