//! A tool wholly within a wall: it is near to none of its triangles, and so no clearance tells of it.

use glam::DVec3;

use super::cutter::FlankCutter;
use super::frustum_distance::Frustum;
use super::gouge::{Clearance, GougeCheck, ToolPart, tool_of};
use super::path::FlankPose;
use geometry::inside::{generalised_winding_number, is_inside_of};
use geometry::mesh::{Bounds, Mesh};
use geometry::solid::open_edges;

/// Vertices of a wall that lie as near to each other (mm) are one.
const WELDED: f64 = 1e-6;

/// Parts of the tool at `pose` whose middle lies within `wall`, and their depth in it. A tool that meets no triangle of
/// a wall is inside of it or outside all along its path, so that one place of the path is enough. An open wall counts
/// as inside where it is seen from behind in more than half of the directions.
pub fn within(pose: &FlankPose, cutter: &FlankCutter, wall: &Mesh) -> GougeCheck {
    let (flutes, holder) = tool_of(cutter);
    let bounds = wall.bounds();
    let is_far = |(_, frustum): &(ToolPart, Frustum)| {
        let p = middle(pose, frustum);
        !bounds.intersects(&Bounds { min: p, max: p })
    };
    if std::iter::once(&flutes).chain(&holder).all(is_far) {
        return GougeCheck::default();
    }
    let is_open = open_edges(wall, WELDED) > 0;
    let is_inside = |point: DVec3| {
        // Of an open wall only one side is behind: a pocket without a lid winds the other way around what is in it.
        if is_open { generalised_winding_number(wall, point) > 0.5 } else { is_inside_of(wall, point) }
    };
    let clearance = |(part, frustum): &(ToolPart, Frustum)| {
        let point = middle(pose, frustum);
        let distance_mm = frustum.distance(pose, point).0;
        is_inside(point).then_some(Clearance { part: *part, distance_mm, point, t: pose.t })
    };
    let deepest = |a: Clearance, b: Clearance| if b.distance_mm < a.distance_mm { b } else { a };
    GougeCheck { cutter: clearance(&flutes), holder: holder.iter().filter_map(clearance).reduce(deepest) }
}

/// How many edges of `wall` are open, if the tool at `pose` is so near to it that it might be inside.
pub fn open_edges_about(pose: &FlankPose, cutter: &FlankCutter, wall: &Mesh) -> Option<usize> {
    let bounds = wall.bounds();
    let (flutes, holder) = tool_of(cutter);
    let mut middles = std::iter::once(&flutes).chain(&holder).map(|(_, frustum)| middle(pose, frustum));
    let is_about = middles.any(|p| bounds.intersects(&Bounds { min: p, max: p }));
    is_about.then(|| open_edges(wall, WELDED)).filter(|edges| *edges > 0)
}

/// The middle of a part of the tool.
fn middle(pose: &FlankPose, frustum: &Frustum) -> DVec3 {
    pose.tip + 0.5 * (frustum.heights[0] + frustum.heights[1]) * pose.axis
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cutter::HolderPart;

    #[test]
    fn a_tool_wholly_within_a_closed_wall_gouges_it() {
        let holder = vec![HolderPart { length_mm: 10.0, lower_radius_mm: 6.0, upper_radius_mm: 6.0 }];
        let cutter = FlankCutter { holder, ..FlankCutter::cylinder(2.0, 20.0) };
        let pose = FlankPose { t: 0.25, tip: DVec3::new(3.0, -7.0, 11.0), axis: DVec3::new(2.0, 3.0, 6.0) / 7.0 };
        let room = Mesh::cuboid(DVec3::splat(800.0)).mapped(|p| p - 400.0);
        let found = within(&pose, &cutter, &room);
        // In the middle of the flutes the wall is as deep as they are thick, in the holder half its length.
        assert!((found.cutter.unwrap().distance_mm + 2.0).abs() < 1e-9, "{found:?}");
        assert!((found.holder.unwrap().distance_mm + 5.0).abs() < 1e-9, "{found:?}");
        assert!(found.gouge(0.01).is_some_and(|c| c.t == 0.25));
        // Beside it is outside.
        let beside = |wall: &Mesh| wall.mapped(|p| p + DVec3::X * 1000.0);
        assert_eq!(within(&pose, &cutter, &beside(&room)), GougeCheck::default());
        assert_eq!(open_edges_about(&pose, &cutter, &room), None);
        // A wall that lacks a triangle has three open edges and is a wall all the same, with an inside and an outside.
        let open = Mesh { triangles: room.triangles[1..].to_vec(), ..room.clone() };
        assert_eq!(open_edges_about(&pose, &cutter, &open), Some(3));
        assert_eq!(within(&pose, &cutter, &open), found);
        assert_eq!(within(&pose, &cutter, &beside(&open)), GougeCheck::default());
        assert_eq!(open_edges_about(&pose, &cutter, &beside(&open)), None);
        // A pocket: the same turned inside out, with nothing above. What is in it is in the open.
        let above = |t: &[u32; 3]| t.iter().all(|i| room.vertices[*i as usize].z > 0.0);
        let sides = room.triangles.iter().filter(|t| !above(t));
        let pocket = Mesh { triangles: sides.map(|[a, b, c]| [*a, *c, *b]).collect(), ..room.clone() };
        assert_eq!(pocket.triangles.len(), 10);
        assert_eq!(within(&pose, &cutter, &pocket), GougeCheck::default());
    }
}
