//! A tool wholly within a wall: it is near to none of its triangles, and so no clearance tells of it.

use glam::DVec3;

use super::cutter::FlankCutter;
use super::gouge::{Clearance, Frustum, GougeCheck, ToolPart, tool_of};
use super::path::FlankPose;
use crate::geometry::inside::is_inside_of;
use crate::geometry::mesh::Mesh;
use crate::geometry::solid::is_closed;

/// Which parts of the tool at `pose` have their middle within a closed `wall`, and how deep that lies in them. A tool that
/// meets no triangle of a wall is inside of it or outside all along its way, so that one place of the way tells. An open
/// wall has no inside.
pub fn within(pose: &FlankPose, cutter: &FlankCutter, wall: &Mesh) -> GougeCheck {
    /// Vertices of a closed wall that lie as near to each other (mm) are one.
    const WELDED: f64 = 1e-6;
    let clearance = |(part, frustum): &(ToolPart, Frustum)| {
        let point: DVec3 = pose.tip + 0.5 * (frustum.heights[0] + frustum.heights[1]) * pose.axis;
        let distance_mm = frustum.distance(pose, point).0;
        is_inside_of(wall, point).then_some(Clearance { part: *part, distance_mm, point, t: pose.t })
    };
    let (flutes, holder) = tool_of(cutter);
    let deepest = |a: Clearance, b: Clearance| if b.distance_mm < a.distance_mm { b } else { a };
    let found = GougeCheck { cutter: clearance(&flutes), holder: holder.iter().filter_map(clearance).reduce(deepest) };
    let is_within = (found.cutter.is_some() || found.holder.is_some()) && is_closed(wall, WELDED);
    if is_within { found } else { GougeCheck::default() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flank::cutter::HolderPart;
    use crate::geometry::mesh::tests::cuboid;

    #[test]
    fn a_tool_wholly_within_a_closed_wall_gouges_it() {
        let holder = vec![HolderPart { length_mm: 10.0, lower_radius_mm: 6.0, upper_radius_mm: 6.0 }];
        let cutter = FlankCutter { holder, ..FlankCutter::cylinder(2.0, 20.0) };
        let pose = FlankPose { t: 0.25, tip: DVec3::new(3.0, -7.0, 11.0), axis: DVec3::new(2.0, 3.0, 6.0) / 7.0 };
        let room = cuboid(DVec3::splat(800.0)).mapped(|p| p - 400.0);
        let found = within(&pose, &cutter, &room);
        // In the middle of the flutes the wall is as deep as they are thick, in the holder half its length.
        assert!((found.cutter.unwrap().distance_mm + 2.0).abs() < 1e-9, "{found:?}");
        assert!((found.holder.unwrap().distance_mm + 5.0).abs() < 1e-9, "{found:?}");
        assert!(found.gouge(0.01).is_some_and(|c| c.t == 0.25));
        // Beside it is outside, and an open wall has no inside.
        assert_eq!(within(&pose, &cutter, &room.mapped(|p| p + DVec3::X * 1000.0)), GougeCheck::default());
        let open = Mesh { triangles: room.triangles[1..].to_vec(), ..room };
        assert_eq!(within(&pose, &cutter, &open), GougeCheck::default());
    }
}
