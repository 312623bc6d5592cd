//! A lighter mesh for while the view moves.

use glam::DVec3;
use rayon::prelude::*;

use super::fans::Fans;
use geometry::mesh::Mesh;

/// A lighter mesh and where its vertices come from.
pub struct Lighter {
    /// The mesh; its vertices are some of the original's.
    pub mesh: Mesh,
    /// The original's vertex that each vertex is.
    pub sources: Vec<u32>,
}

/// Merges the vertices in each cell of a grid that face the same way into the one nearest their mean (vertex
/// clustering; J. Rossignac and P. Borrel, Multi-resolution 3D approximations for rendering complex scenes,
/// 1993). No point of the lighter mesh is further from a vertex of the original than a cell's diagonal, and
/// the two sides of a thin wall stay apart. It has about `target` triangles.
pub fn lighter(mesh: &Mesh, fans: &Fans, normals: &[DVec3], target: f64) -> Lighter {
    let bounds = mesh.bounds();
    let cell = cell_size(mesh, target);
    let mut keys: Vec<(u64, u32)> = (0..mesh.vertices.len() as u32)
        .into_par_iter()
        .filter(|&v| !fans.of(v as usize).is_empty())
        .map(|v| {
            let [x, y, z] = ((mesh.vertices[v as usize] - bounds.min) / cell).to_array().map(|c| c as u64 & 0xf_ffff);
            let facing: DVec3 = fans.of(v as usize).iter().map(|&c| normals[c as usize / 3]).sum();
            let octant = u64::from(facing.is_negative_bitmask() & 7);
            (((x << 20 | y) << 20 | z) << 3 | octant, v)
        })
        .collect();
    keys.par_sort_unstable();
    let mut new_index = vec![0u32; mesh.vertices.len()];
    let mut sources = Vec::new();
    for group in keys.chunk_by(|a, b| a.0 == b.0) {
        for &(_, v) in group {
            new_index[v as usize] = sources.len() as u32;
        }
        sources.push(most_central(mesh, group));
    }
    let vertices = sources.iter().map(|&v| mesh.vertices[v as usize]).collect();
    let merged = mesh.triangles.iter().map(|t| t.map(|v| new_index[v as usize]));
    let triangles = merged.filter(|&[a, b, c]| a != b && b != c && c != a).collect();
    Lighter { mesh: Mesh { vertices, triangles }, sources }
}

/// Edge of the cells (mm) that leave about `target` triangles.
pub fn cell_size(mesh: &Mesh, target: f64) -> f64 {
    // A surface of area A meets about 1.5 A / cell^2 cells, and has two triangles to a vertex.
    let by_area = (3.0 * mesh.area() / target).sqrt();
    let by_box = mesh.bounds().size().max_element() / 1e6;
    by_area.max(by_box).max(f64::MIN_POSITIVE)
}

fn most_central(mesh: &Mesh, group: &[(u64, u32)]) -> u32 {
    let at = |v: u32| mesh.vertices[v as usize];
    let mean = group.iter().map(|&(_, v)| at(v)).sum::<DVec3>() / group.len() as f64;
    let off = |v: u32| at(v).distance_squared(mean);
    group.iter().map(|&(_, v)| v).min_by(|&a, &b| off(a).total_cmp(&off(b)).then(a.cmp(&b))).unwrap_or(0)
}
