//! The edges worth drawing, and whether a mesh is closed.

use glam::DVec3;
use rayon::prelude::*;

use super::fans::Fans;

/// Topology of the edges of a mesh.
#[derive(Debug, Default, PartialEq)]
pub struct Edges {
    /// Vertices of the feature edges: creases, rims of open surfaces, and where more than two faces meet.
    pub features: Vec<[u32; 2]>,
    /// Whether every edge is passed as often in one direction as in the other, which gives the mesh an inside.
    pub closed: bool,
}

/// A triangle's side that begins or ends at the vertex at hand.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Side {
    other: u32,
    triangle: u32,
    outgoing: bool,
}

/// Finds the edges; `crease` is the cosine of the angle between normals from which on a crease is a feature.
pub fn find_edges(triangles: &[[u32; 3]], fans: &Fans, normals: &[DVec3], crease: f64) -> Edges {
    let chunks: Vec<Edges> = (0..fans.vertex_count().div_ceil(4096))
        .into_par_iter()
        .map(|chunk| {
            let mut found = Edges { features: Vec::new(), closed: true };
            let mut sides = Vec::new();
            for v in chunk * 4096..((chunk + 1) * 4096).min(fans.vertex_count()) {
                collect_sides(triangles, fans, v, &mut sides);
                for edge in sides.chunk_by(|a, b| a.other == b.other) {
                    let outgoing = edge.iter().filter(|s| s.outgoing).count();
                    found.closed &= 2 * outgoing == edge.len();
                    if is_feature(edge, normals, crease) {
                        found.features.push([v as u32, edge[0].other]);
                    }
                }
            }
            found
        })
        .collect();
    let closed = !triangles.is_empty() && chunks.iter().all(|c| c.closed);
    Edges { features: chunks.into_iter().flat_map(|c| c.features).collect(), closed }
}

/// The sides between `v` and vertices of higher index, sorted by these.
fn collect_sides(triangles: &[[u32; 3]], fans: &Fans, v: usize, sides: &mut Vec<Side>) {
    sides.clear();
    for &corner in fans.of(v) {
        let (triangle, k) = (corner / 3, corner as usize % 3);
        let t = triangles[triangle as usize];
        let (next, previous) = (t[(k + 1) % 3], t[(k + 2) % 3]);
        for (other, outgoing) in [(next, true), (previous, false)] {
            if other > v as u32 {
                sides.push(Side { other, triangle, outgoing });
            }
        }
    }
    sides.sort_unstable();
}

fn is_feature(edge: &[Side], normals: &[DVec3], crease: f64) -> bool {
    let [a, b] = edge else { return true };
    let (na, nb) = (normals[a.triangle as usize], normals[b.triangle as usize]);
    if na == DVec3::ZERO || nb == DVec3::ZERO {
        return false;
    }
    // Two faces that pass the edge in the same direction are turned against each other.
    let turned = if a.outgoing == b.outgoing { -1.0 } else { 1.0 };
    turned * na.dot(nb) < crease
}
