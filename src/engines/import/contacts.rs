//! Edges along which solids touch.

use std::cmp::Ordering;
use std::f64::consts::TAU;

use super::edges::{Edge, EdgeTable, half_ends};
use geometry::mesh::Mesh;
use task::{Cancelled, Task};

/// Faces at an edge between which the angle is less than this (rad) lie on each other.
const ON_EACH_OTHER: f64 = 1e-4;

/// Gives solids that touch along edges vertices of their own, so that each closes on its own; returns the number of these
/// edges.
///
/// An edge of more than two triangles is one of several solids if metal and air take turns around it. The triangles on
/// either side of the same metal stay joined. Other edges of more than two triangles stay as they are.
pub(super) fn part_touching(mesh: &mut Mesh, table: &EdgeTable, task: &Task) -> Result<usize, Cancelled> {
    if table.edges().all(|edge| edge.halves().len() <= 2) {
        return Ok(0);
    }
    let (mut joined, mut parted) = (Corners::new(3 * mesh.triangles.len()), 0);
    for edge in table.edges() {
        match sides_of_metal(mesh, &edge).filter(|pairs| pairs.len() > 1) {
            Some(pairs) => {
                parted += 1;
                pairs.iter().for_each(|pair| joined.join_along(mesh, *pair));
            }
            None => edge.halves().zip(edge.halves().skip(1)).for_each(|(a, b)| joined.join_along(mesh, [a, b])),
        }
    }
    task.check()?;
    if parted == 0 {
        return Ok(0);
    }
    // The first corner at a vertex keeps it; corners that are not joined to it get vertices of their own.
    let mut is_taken = vec![false; mesh.vertices.len()];
    let mut vertex_of: Vec<Option<u32>> = vec![None; 3 * mesh.triangles.len()];
    for corner in 0..3 * mesh.triangles.len() as u32 {
        let at = mesh.triangles[corner as usize / 3][corner as usize % 3];
        let vertex = *vertex_of[joined.root(corner) as usize].get_or_insert_with(|| {
            if !std::mem::replace(&mut is_taken[at as usize], true) {
                return at;
            }
            mesh.vertices.push(mesh.vertices[at as usize]);
            mesh.vertices.len() as u32 - 1
        });
        mesh.triangles[corner as usize / 3][corner as usize % 3] = vertex;
    }
    Ok(parted)
}

/// The half-edges on either side of each metal at an edge; none if metal and air do not take turns around it.
fn sides_of_metal(mesh: &Mesh, edge: &Edge) -> Option<Vec<[u32; 2]>> {
    if !edge.halves().len().is_multiple_of(2) || edge.imbalance(mesh) != 0 {
        return None;
    }
    let [low, high] = [edge.low, edge.high].map(|v| mesh.vertices[v as usize]);
    let along = (high - low).try_normalize()?;
    let across = along.any_orthonormal_vector();
    let up = along.cross(across);
    let angle = |half: u32| {
        let apex = mesh.vertices[mesh.triangles[half as usize / 3][(half as usize + 2) % 3] as usize] - low;
        up.dot(apex).atan2(across.dot(apex)).rem_euclid(TAU)
    };
    // Seen along the edge, a triangle whose half-edge runs along it has its metal on the side of smaller angles.
    let mut faces: Vec<(f64, bool, u32)> =
        edge.halves().map(|half| (angle(half), half_ends(mesh, half).0 == edge.low, half)).collect();
    faces.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.2.cmp(&b.2)));
    // Counted from the widest angle between them, so that no faces that lie on each other are far apart in the list.
    let before = |i: usize| (faces[i].0 - faces[(i + faces.len() - 1) % faces.len()].0).rem_euclid(TAU);
    let first = (0..faces.len()).max_by(|&a, &b| before(a).total_cmp(&before(b)))?;
    let start = faces[first].0;
    faces.rotate_left(first);
    faces.iter_mut().for_each(|face| face.0 = (face.0 - start).rem_euclid(TAU));
    // Of faces that lie on each other, metal ends before the next begins.
    let mut turns: Vec<(bool, u32)> = Vec::with_capacity(faces.len());
    for group in faces.chunk_by(|a, b| b.0 - a.0 <= ON_EACH_OTHER) {
        let (ends, begins): (Vec<_>, Vec<_>) = group.iter().copied().partition(|face| face.1);
        turns.extend(ends.into_iter().chain(begins).map(|(_, ends, half)| (ends, half)));
    }
    let first = turns.iter().position(|(ends, _)| !ends)?;
    turns.rotate_left(first);
    let pair = |pair: &[(bool, u32)]| match pair {
        [(false, begins), (true, ends)] => Some([*begins, *ends]),
        _ => None,
    };
    turns.chunks(2).map(pair).collect()
}

/// Corners of triangles, three for each, of which those that are the same vertex are joined.
struct Corners(Vec<u32>);

impl Corners {
    fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    fn root(&mut self, mut corner: u32) -> u32 {
        while self.0[corner as usize] != corner {
            self.0[corner as usize] = self.0[self.0[corner as usize] as usize];
            corner = self.0[corner as usize];
        }
        corner
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        match a.cmp(&b) {
            Ordering::Less => self.0[b as usize] = a,
            _ => self.0[a as usize] = b,
        }
    }

    /// Joins the corners of two triangles at both ends of the edge that they share.
    fn join_along(&mut self, mesh: &Mesh, halves: [u32; 2]) {
        let next = |half: u32| half / 3 * 3 + (half + 1) % 3;
        let [a, b] = halves;
        let (other, ahead) = if half_ends(mesh, a).0 == half_ends(mesh, b).0 { (b, next(b)) } else { (next(b), b) };
        self.join(a, other);
        self.join(next(a), ahead);
    }
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

    #[test]
    fn solids_that_touch_along_an_edge_or_with_a_face_close_each_on_its_own() {
        for at in [DVec3::new(1.0, 1.0, 0.0), DVec3::Z, DVec3::NEG_Z, DVec3::new(-1.0, 0.0, 1.0)] {
            for turned in [false, true] {
                let mesh = welded(&[cube(DVec3::ZERO, false), cube(at, turned)]);
                let (mesh, repairs) = repair(mesh, None, &Task::default()).unwrap();
                assert!(repairs.watertight && repairs.non_manifold_edges == 0, "{at} {turned}: {repairs:?}");
                // Faces that are divided alike go, and what remains is one solid.
                let parts = if repairs.duplicates > 0 { 1 } else { 2 };
                assert_eq!(repairs.orientation.parts, parts, "{at} {turned}");
                assert!((mesh.volume() - 2.0).abs() < 1e-12, "{at} {turned}: {}", mesh.volume());
            }
        }
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
