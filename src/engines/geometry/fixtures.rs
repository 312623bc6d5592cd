//! Meshes that tests of several crates share.

use glam::{DVec2, DVec3};

use crate::mesh::Mesh;

/// The box `[0, (4, 3, 3)]`, closed, whose top runs back and forth in a fold between x = 1 and x = 3. The way
/// back lies `thickness` above the rest, which turns the fold inside out, or below it, which makes it overlap.
pub fn folded_box(thickness: f64) -> Mesh {
    let (back, on) = (3.0 + thickness, 3.0 + 0.25 * thickness);
    let outline = [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [1.0, 3.0], [1.0, back], [3.0, back], [3.0, on], [0.0, on]];
    let vertices = [0.0, 3.0].iter().flat_map(|&y| outline.iter().map(move |p| DVec3::new(p[0], y, p[1]))).collect();
    let n = outline.len() as u32;
    let caps = (1..n - 1).flat_map(|i| [[0, i, i + 1], [n, n + i + 1, n + i]]);
    let sides = (0..n).map(|i| (i, (i + 1) % n)).flat_map(|(i, j)| [[i, i + n, j], [j, i + n, j + n]]);
    Mesh { vertices, triangles: caps.chain(sides).collect() }
}

/// The part of a convex polygon at whose points `off` is not negative; it is linear over the plane.
pub fn clipped(polygon: &[DVec2], off: impl Fn(DVec2) -> f64) -> Vec<DVec2> {
    let mut kept = Vec::new();
    for (k, &p) in polygon.iter().enumerate() {
        let q = polygon[(k + 1) % polygon.len()];
        if off(p) >= 0.0 {
            kept.push(p);
        }
        if (off(p) > 0.0) != (off(q) > 0.0) && off(p) != off(q) {
            kept.push(p.lerp(q, off(p) / (off(p) - off(q))));
        }
    }
    kept
}

/// Area of a polygon that runs counter-clockwise.
pub fn polygon_area(polygon: &[DVec2]) -> f64 {
    0.5 * (0..polygon.len()).map(|i| polygon[i].perp_dot(polygon[(i + 1) % polygon.len()])).sum::<f64>()
}
