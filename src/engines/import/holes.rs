//! Boundary loops of a surface.

use glam::DVec3;
use serde::Serialize;

use super::edges::{EdgeTable, NONE, half_ends};
use geometry::mesh::Mesh;

/// A closed chain of edges that have a triangle on one side only.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Hole {
    /// Number of edges.
    pub edges: usize,
    /// Length of the chain (mm).
    pub length_mm: f64,
    /// Centre of gravity (mm).
    pub center_mm: DVec3,
}

/// The boundary of a mesh.
#[derive(Debug, Default)]
pub(super) struct Boundary {
    /// Loops, in the order of their lowest edges.
    pub holes: Vec<Hole>,
    /// Half-edges without a neighbour, in order of edges.
    pub halves: Vec<u32>,
    /// For each of `halves` the number of its loop.
    pub hole_of: Vec<u32>,
}

/// Follows the boundary of `mesh` round its holes.
///
/// The direction of the triangles does not matter. Where loops touch in a vertex they are distinguished arbitrarily but
/// always in the same way.
pub(super) fn trace(mesh: &Mesh, table: &EdgeTable) -> Boundary {
    let halves: Vec<u32> =
        table.edges().filter(|edge| edge.halves().len() == 1).flat_map(|edge| edge.halves().next()).collect();
    let mut at_vertex: Vec<(u32, u32)> = Vec::with_capacity(2 * halves.len());
    for (i, &half) in halves.iter().enumerate() {
        let (a, b) = half_ends(mesh, half);
        at_vertex.extend([(a, i as u32), (b, i as u32)]);
    }
    at_vertex.sort_unstable();
    let mut boundary = Boundary { holes: Vec::new(), hole_of: vec![NONE; halves.len()], halves };
    for first in 0..boundary.halves.len() {
        if boundary.hole_of[first] == NONE {
            let hole = walk(mesh, &at_vertex, &mut boundary, first);
            boundary.holes.push(hole);
        }
    }
    boundary
}

/// Walks from edge `first` on along edges that no hole has yet, until back at its beginning.
fn walk(mesh: &Mesh, at_vertex: &[(u32, u32)], boundary: &mut Boundary, first: usize) -> Hole {
    let number = boundary.holes.len() as u32;
    let (begin, mut vertex) = half_ends(mesh, boundary.halves[first]);
    let (mut edge, mut edges, mut length, mut moment) = (first, 0, 0.0, DVec3::ZERO);
    loop {
        boundary.hole_of[edge] = number;
        let (a, b) = half_ends(mesh, boundary.halves[edge]);
        let (a_point, b_point) = (mesh.vertices[a as usize], mesh.vertices[b as usize]);
        let edge_length = a_point.distance(b_point);
        edges += 1;
        length += edge_length;
        moment += (a_point + b_point) * 0.5 * edge_length;
        if vertex == begin {
            break;
        }
        let from = at_vertex.partition_point(|&(v, _)| v < vertex);
        let free = at_vertex[from..]
            .iter()
            .take_while(|&&(v, _)| v == vertex)
            .find(|&&(_, e)| boundary.hole_of[e as usize] == NONE);
        // A chain that ends ends at an edge of three or more triangles.
        let Some(&(_, next)) = free else { break };
        edge = next as usize;
        let (a, b) = half_ends(mesh, boundary.halves[edge]);
        vertex = if a == vertex { b } else { a };
    }
    // Vertices apart have edges with a length, unless so short that its square is nothing.
    let center = if length > 0.0 { moment / length } else { mesh.vertices[begin as usize] };
    Hole { edges, length_mm: length, center_mm: center }
}
