//! Making one vertex of several that stand for the same point.

use std::collections::HashMap;
use std::iter;

use glam::{DVec3, I64Vec3};

use super::edges::NONE;
use super::source::tick;
use geometry::mesh::Mesh;
use geometry::weld::Weld;
use task::{Cancelled, Task};

/// `mesh` with equal vertices made one.
pub(super) fn weld_exact(mesh: Mesh, task: &Task) -> Result<Mesh, Cancelled> {
    let mut weld = Weld::with_capacity(mesh.vertices.len());
    let mut number = Vec::with_capacity(mesh.vertices.len());
    for (i, &p) in mesh.vertices.iter().enumerate() {
        tick(task, "welding", i, mesh.vertices.len())?;
        number.push(weld.add(p));
    }
    let triangles = mesh.triangles.iter().map(|t| t.map(|v| number[v as usize])).collect();
    Ok(Mesh { vertices: weld.into_points(), triangles })
}

/// `mesh` with each vertex moved onto the first one within `tolerance` (mm) of it that stays.
///
/// Merging vertices maps closed surfaces onto closed surfaces (the boundary of the image is the image of the
/// boundary), so this can close cracks but never opens one. Triangles may collapse; they are left for the caller.
pub(super) fn weld_near(mesh: Mesh, tolerance: f64, task: &Task) -> Result<Mesh, Cancelled> {
    let width = CELL_WIDTH * tolerance;
    // Last vertex of each cell, and for each vertex the one before it in its cell.
    let mut last: HashMap<I64Vec3, u32> = HashMap::new();
    let mut before: Vec<u32> = Vec::new();
    let mut vertices: Vec<DVec3> = Vec::new();
    let mut number = Vec::with_capacity(mesh.vertices.len());
    for (i, &p) in mesh.vertices.iter().enumerate() {
        tick(task, "welding", i, mesh.vertices.len())?;
        let near = cells_near(p / width, 1.0 / CELL_WIDTH)
            .filter_map(|cell| last.get(&cell).copied())
            .flat_map(|v| iter::successors(Some(v), |&v| Some(before[v as usize]).filter(|&v| v != NONE)))
            .filter(|&v| vertices[v as usize].distance_squared(p) <= tolerance * tolerance)
            .min();
        number.push(near.unwrap_or_else(|| {
            let v = vertices.len() as u32;
            vertices.push(p);
            before.push(last.insert((p / width).floor().as_i64vec3(), v).unwrap_or(NONE));
            v
        }));
    }
    let triangles = mesh.triangles.iter().map(|t| t.map(|v| number[v as usize])).collect();
    Ok(Mesh { vertices, triangles })
}

/// Width of the cells in which near vertices are looked for, in tolerances. Vertices that stay keep their distance,
/// so a cell holds a bounded number of them; wider cells need fewer neighbours looked into, but hold more.
const CELL_WIDTH: f64 = 4.0;

/// The cells, of width 1, that have a point nearer than `reach` (less than 1/2) to `p` along each axis.
fn cells_near(p: DVec3, reach: f64) -> impl Iterator<Item = I64Vec3> {
    let (low, high) = ((p - reach).floor().as_i64vec3(), (p + reach).floor().as_i64vec3());
    (low.x..=high.x)
        .flat_map(move |x| (low.y..=high.y).flat_map(move |y| (low.z..=high.z).map(move |z| I64Vec3::new(x, y, z))))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn soup(mesh: &Mesh) -> Mesh {
        let vertices: Vec<DVec3> = mesh.iter_corners().flatten().collect();
        let triangles = (0..mesh.triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        Mesh { vertices, triangles }
    }

    #[test]
    fn equal_corners_become_one_vertex_whatever_the_sign_of_zero() {
        let mut parts = soup(&Mesh::cuboid(DVec3::new(2.0, 3.0, 4.0)));
        for p in parts.vertices.iter_mut().step_by(2) {
            *p = -(-*p);
            p.x = if p.x == 0.0 { -0.0 } else { p.x };
        }
        let mesh = weld_exact(parts, &Task::default()).unwrap();
        assert_eq!(mesh.vertices.len(), 8);
        assert!(mesh.is_watertight());
    }

    #[test]
    fn near_corners_meet_and_far_ones_stay_apart() {
        let tolerance = 1e-3;
        let mut parts = soup(&Mesh::cuboid(DVec3::splat(1.0)));
        // Less than half the tolerance away from where it belongs, so any two of a corner are near each other;
        // some are pushed over a cell's edge.
        for (i, p) in parts.vertices.iter_mut().enumerate() {
            *p += 0.28 * tolerance * DVec3::new((i as f64).sin(), (i as f64 * 1.7).cos(), (i as f64 * 2.3).sin());
        }
        let near = weld_near(parts.clone(), tolerance, &Task::default()).unwrap();
        assert_eq!(near.vertices.len(), 8);
        assert!(near.is_watertight());
        let far = weld_near(parts, tolerance * 1e-3, &Task::default()).unwrap();
        assert!(far.vertices.len() > 30);
    }
}
