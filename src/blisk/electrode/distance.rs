//! Signed distances to meshes that are folded in places.

use glam::DVec3;

use crate::geometry::exact::ExactMesh;

/// Directions in which the surface's crossings are counted; askew, so that they run along no edge.
const DIRECTIONS: [DVec3; 3] =
    [DVec3::new(0.95, 0.17, 0.26), DVec3::new(-0.93, 0.21, -0.30), DVec3::new(0.11, -0.19, -0.97)];
/// How far is looked for crossings (mm).
const REACH: f64 = 1e5;
/// How far behind a crossing the next is looked for (mm).
const STEP: f64 = 1e-7;
/// Crossings after which counting is given up.
const MOST_CROSSINGS: usize = 1000;

/// The exact distance from `p` to the surface, negative inside (mm).
///
/// Where a mesh is folded the normals next to the nearest point may give the wrong sign: blade tips closed by a
/// fan of triangles are an example. A negative sign is therefore believed only if two of three rays from `p` cross
/// the surface an odd number of times.
pub(super) fn signed_distance(mesh: &ExactMesh, p: DVec3) -> f64 {
    let distance = mesh.signed_distance(p);
    if distance < 0.0 && !is_inside(mesh, p) { -distance } else { distance }
}

fn is_inside(mesh: &ExactMesh, p: DVec3) -> bool {
    DIRECTIONS.iter().filter(|direction| crossings(mesh, p, direction.normalize()) % 2 == 1).count() >= 2
}

fn crossings(mesh: &ExactMesh, mut p: DVec3, direction: DVec3) -> usize {
    for count in 0..MOST_CROSSINGS {
        let Some(depth) = mesh.first_crossing(p, direction, REACH) else { return count };
        p += direction * (depth + STEP);
    }
    MOST_CROSSINGS
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::mesh::Mesh;

    /// A prism between z = 0 and z = 1 over a crescent, its top a fan around a point in the middle of the crescent.
    /// Fan triangles to the concave side leave the crescent and fold back, as those of a carelessly closed blade do.
    fn crescent() -> Mesh {
        let n = 24;
        let arc = |bulge: f64, i: usize| {
            let t = i as f64 / n as f64;
            DVec3::new(10.0 * t, 4.0 * bulge * t * (1.0 - t), 0.0)
        };
        let mut outline: Vec<_> = (0..=n).map(|i| arc(3.0, i)).collect();
        outline.extend((1..n).rev().map(|i| arc(4.0, i)));
        let m = outline.len() as u32;
        let mut mesh = Mesh { vertices: outline.clone(), triangles: Vec::new() };
        mesh.vertices.extend(outline.iter().map(|p| p + DVec3::Z));
        mesh.vertices.extend([DVec3::new(5.0, 3.5, 0.0), DVec3::new(5.0, 3.5, 1.0)]);
        for i in 0..m {
            let j = (i + 1) % m;
            mesh.triangles.extend([[i, j, j + m], [i, j + m, i + m], [j, i, 2 * m], [i + m, j + m, 2 * m + 1]]);
        }
        mesh
    }

    #[test]
    fn a_folded_cap_does_not_turn_the_sign() {
        let mesh = crescent();
        assert!(mesh.is_watertight() && mesh.volume() > 0.0);
        let exact = ExactMesh::new(&mesh).unwrap();
        let mut mended = 0;
        for i in 0..60 {
            for j in 0..60 {
                let p = DVec3::new(0.5 + 0.15 * f64::from(i), -0.5 + 0.09 * f64::from(j), 0.5);
                let t = p.x / 10.0;
                let (below, above) = (12.0 * t * (1.0 - t), 16.0 * t * (1.0 - t));
                // Chords of the outline leave out what lies within 0.01 of it.
                if (p.y - below).abs() < 0.01 || (p.y - above).abs() < 0.01 {
                    continue;
                }
                let is_inside = p.y > below && p.y < above;
                assert_eq!(signed_distance(&exact, p) < 0.0, is_inside, "{p}");
                mended += usize::from((exact.signed_distance(p) < 0.0) != is_inside);
            }
        }
        assert!(mended > 0, "the cap is folded so far that it matters");
    }
}
