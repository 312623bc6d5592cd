//! Edges along which solids touch.

use std::f64::consts::TAU;

use super::edges::{Edge, EdgeTable, half_ends};
use super::source::tick;
use geometry::groups::Groups;
use geometry::mesh::Mesh;
use task::{Cancelled, Task};

/// Faces at an edge between which the angle is less than this (rad), or their tips are nearer than the tolerance of
/// welding, lie on each other.
const ON_EACH_OTHER: f64 = 1e-4;

/// Gives solids that touch along edges vertices of their own at these, so that each closes on its own; none if `table`,
/// that of `mesh`, has no such edges.
///
/// An edge of more than two triangles is one of several solids if metal and air take turns around it. The triangles on
/// either side of the same metal stay joined. Other edges of more than two triangles stay as they are. Faces that lie on
/// each other are taken for two solids that touch; of a sheet without thickness, which looks alike at its edges, the two
/// sides come out as parts without volume. `tolerance` is that of welding (mm).
pub(super) fn split_touching(
    mesh: &Mesh,
    table: &EdgeTable,
    tolerance: f64,
    task: &Task,
) -> Result<Option<Mesh>, Cancelled> {
    const STAGE: &str = "solids that touch";
    let is_branched = |edge: &Edge| edge.halves().len() > 2;
    if !table.edges().any(|edge| is_branched(&edge)) {
        return Ok(None);
    }
    // Of a mesh that is inside out, metal is on the other side of each triangle.
    let is_inside_out = mesh.volume() < 0.0;
    let corner_count = 3 * mesh.triangles.len();
    let mut joined = Groups::of(corner_count);
    let mut is_end = vec![false; mesh.vertices.len()];
    for (i, edge) in table.edges().enumerate() {
        tick(task, STAGE, i, corner_count)?;
        let sides = if is_branched(&edge) { sides_of_metal(mesh, &edge, is_inside_out, tolerance) } else { None };
        match sides {
            Some(pairs) => {
                pairs.iter().for_each(|pair| join_along(&mut joined, mesh, *pair));
                for v in [edge.low, edge.high] {
                    is_end[v as usize] = true;
                }
            }
            None => edge.halves().zip(edge.halves().skip(1)).for_each(|(a, b)| join_along(&mut joined, mesh, [a, b])),
        }
    }
    // The first corner at a vertex keeps it; corners at a split edge that are not joined to it get vertices of their own.
    let mut split = mesh.clone();
    let mut is_taken = vec![false; mesh.vertices.len()];
    let mut vertex_of: Vec<Option<u32>> = vec![None; corner_count];
    for corner in 0..corner_count {
        tick(task, STAGE, corner, corner_count)?;
        let at = &mut split.triangles[corner / 3][corner % 3];
        if !is_end[*at as usize] {
            continue;
        }
        *at = *vertex_of[joined.first(corner)].get_or_insert_with(|| {
            if !std::mem::replace(&mut is_taken[*at as usize], true) {
                return *at;
            }
            split.vertices.push(mesh.vertices[*at as usize]);
            split.vertices.len() as u32 - 1
        });
    }
    Ok(Some(split).filter(|split| split.vertices.len() > mesh.vertices.len()))
}

/// A triangle at an edge.
#[derive(Clone, Copy)]
struct Face {
    /// Half-edge of the triangle on the edge.
    half: u32,
    /// Angle about the edge (rad).
    angle: f64,
    /// Angle within which another lies on it (rad).
    within: f64,
    /// Whether metal ends at it, seen in the sense of rising angles; else metal begins there.
    ends: bool,
}

/// The half-edges on either side of each metal at an edge; none if metal and air do not take turns around it.
fn sides_of_metal(mesh: &Mesh, edge: &Edge, is_inside_out: bool, tolerance: f64) -> Option<Vec<[u32; 2]>> {
    let [low, high] = [edge.low, edge.high].map(|v| mesh.vertices[v as usize]);
    let along = (high - low).try_normalize()?;
    let across = along.any_orthonormal_vector();
    let up = along.cross(across);
    // Seen along the edge, a triangle whose half-edge runs along it has its metal on the side of smaller angles.
    let face = |half: u32| {
        let apex = mesh.vertices[mesh.triangles[half as usize / 3][(half as usize + 2) % 3] as usize] - low;
        let within = ON_EACH_OTHER + tolerance / apex.reject_from_normalized(along).length();
        let angle = up.dot(apex).atan2(across.dot(apex)).rem_euclid(TAU);
        Face { half, angle, within, ends: (half_ends(mesh, half).0 == edge.low) != is_inside_out }
    };
    let mut faces: Vec<Face> = edge.halves().map(face).collect();
    faces.sort_by(|a, b| a.angle.total_cmp(&b.angle).then(a.half.cmp(&b.half)));
    // Counted from the widest angle between them, so that no faces that lie on each other are far apart in the list.
    let before = |i: usize| (faces[i].angle - faces[(i + faces.len() - 1) % faces.len()].angle).rem_euclid(TAU);
    let first = (0..faces.len()).max_by(|&a, &b| before(a).total_cmp(&before(b)))?;
    let start = faces[first].angle;
    faces.rotate_left(first);
    faces.iter_mut().for_each(|face| face.angle = (face.angle - start).rem_euclid(TAU));
    // Of faces that lie on each other, metal ends before the next begins.
    let mut turns: Vec<Face> = Vec::with_capacity(faces.len());
    for group in faces.chunk_by(|a, b| b.angle - a.angle <= a.within.max(b.within)) {
        let (ends, begins): (Vec<Face>, Vec<Face>) = group.iter().partition(|face| face.ends);
        turns.extend(ends.into_iter().chain(begins));
    }
    let begins = turns.iter().position(|face| !face.ends)?;
    turns.rotate_left(begins);
    let pair = |pair: &[Face]| match pair {
        [begins, ends] if !begins.ends && ends.ends => Some([begins.half, ends.half]),
        _ => None,
    };
    turns.chunks(2).map(pair).collect()
}

/// Joins the corners of two triangles at both ends of the edge that they share.
fn join_along(joined: &mut Groups, mesh: &Mesh, [a, b]: [u32; 2]) {
    let next = |half: u32| half / 3 * 3 + (half + 1) % 3;
    let is_along = half_ends(mesh, a).0 == half_ends(mesh, b).0;
    let (other, ahead) = if is_along { (b, next(b)) } else { (next(b), b) };
    joined.join(a as usize, other as usize);
    joined.join(next(a) as usize, ahead as usize);
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::repair::repair;

    /// A cube of edge length 1 at `at`, its faces divided along the other diagonal if `turned`.
    fn cube(at: DVec3, turned: bool) -> Mesh {
        let cube = Mesh::cuboid(DVec3::ONE);
        // Turned by a right angle about an axis of the cube, the diagonals of the faces across it are the other ones.
        let place = |p: DVec3| at + if turned { DVec3::new(1.0 - p.y, p.x, p.z) } else { p };
        cube.mapped(place)
    }

    /// The meshes as one, points at the same place the same vertex.
    fn welded(meshes: &[Mesh]) -> Mesh {
        let mut all = Mesh { vertices: Vec::new(), triangles: Vec::new() };
        for corners in meshes.iter().flat_map(Mesh::iter_corners) {
            let vertex = corners.map(|p| {
                all.vertices.iter().position(|q| *q == p).unwrap_or_else(|| {
                    all.vertices.push(p);
                    all.vertices.len() - 1
                }) as u32
            });
            all.triangles.push(vertex);
        }
        all
    }

    fn turned_inside_out(mesh: &Mesh) -> Mesh {
        Mesh { triangles: mesh.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect(), ..mesh.clone() }
    }

    #[test]
    fn solids_that_touch_along_an_edge_or_with_a_face_close_each_on_its_own() {
        for at in [DVec3::new(1.0, 1.0, 0.0), DVec3::Z, DVec3::NEG_Z, DVec3::new(-1.0, 0.0, 1.0)] {
            for turned in [false, true] {
                let mesh = welded(&[cube(DVec3::ZERO, false), cube(at, turned)]);
                let inverted = turned_inside_out(&mesh);
                let (mesh, repairs) = repair(mesh, None, &Task::default()).unwrap();
                let (other, _) = repair(inverted, None, &Task::default()).unwrap();
                assert!(other.is_watertight() && (other.volume() - 2.0).abs() < 1e-12, "{at} {turned}: inside out");
                assert!(repairs.watertight && repairs.non_manifold_edges == 0, "{at} {turned}: {repairs:?}");
                // Faces that are divided alike go, and what remains is one solid.
                let parts = if repairs.duplicates > 0 { 1 } else { 2 };
                assert_eq!(repairs.orientation.parts, parts, "{at} {turned}");
                assert!((mesh.volume() - 2.0).abs() < 1e-12, "{at} {turned}: {}", mesh.volume());
            }
        }
    }

    #[test]
    fn where_metal_and_air_do_not_take_turns_nothing_is_split() {
        // One of two solids is inside out.
        let one = welded(&[cube(DVec3::ZERO, false), turned_inside_out(&cube(DVec3::new(1.0, 1.0, 0.0), false))]);
        let (_, repairs) = repair(one, None, &Task::default()).unwrap();
        assert!(!repairs.watertight && repairs.non_manifold_edges == 1 && repairs.touching_edges == 0, "{repairs:?}");
        // Both sides of a sheet without thickness, a fan about its middle: no solid at all.
        let rim = (0..6).map(|i| f64::from(i) * TAU / 6.0).map(|angle| DVec3::new(angle.cos(), angle.sin(), 0.0));
        let vertices = std::iter::once(DVec3::ZERO).chain(rim).collect();
        let fan = (1..=6).map(|i| [0, i, i % 6 + 1]);
        let triangles = fan.clone().chain(fan.map(|[a, b, c]| [a, c, b])).collect();
        let (_, repairs) = repair(Mesh { vertices, triangles }, None, &Task::default()).unwrap();
        assert!(!repairs.watertight && repairs.touching_edges == 0, "{repairs:?}");
    }

    #[test]
    fn three_solids_about_an_edge_and_a_fin_on_one() {
        let around = [DVec3::ZERO, DVec3::new(1.0, 1.0, 0.0), DVec3::X].map(|at| cube(at, false));
        let (mesh, repairs) = repair(welded(&around), None, &Task::default()).unwrap();
        assert!(repairs.watertight && (mesh.volume() - 3.0).abs() < 1e-12, "{repairs:?}");
        // A sheet that stands on an edge is no solid, and stays what it is.
        let mut finned = Mesh::cuboid(DVec3::ONE);
        let [a, b, _] = finned.triangles[0];
        finned.vertices.push(DVec3::splat(-2.0));
        finned.triangles.push([a, b, 8]);
        let (_, repairs) = repair(finned, None, &Task::default()).unwrap();
        assert_eq!((repairs.non_manifold_edges, repairs.touching_edges), (1, 0));
    }
}
