//! Inside or outside a closed surface, also where the surface is folded or crosses itself.

use std::f64::consts::TAU;

use glam::DVec3;

use super::exact::{ExactMesh, Nearest};
use super::mesh::Mesh;
use super::raycast::RayMesh;

/// Directions in which crossings are counted; askew, so that they run along no edge of a mesh drawn by hand.
const DIRECTIONS: [DVec3; 3] =
    [DVec3::new(0.95, 0.17, 0.26), DVec3::new(-0.93, 0.21, -0.30), DVec3::new(0.11, -0.19, -0.97)];

/// How often the surface of `mesh` winds around `p`: 0 outside, 1 inside. Where sheets overlap it may be 2 or more,
/// in a fold turned inside out -1. Points on the surface get either side's number.
///
/// Counted along a ray, that is exact but for a ray that meets an edge to rounding; so two rays must agree, or
/// else two of three.
pub fn winding_number(mesh: &ExactMesh, p: DVec3) -> i32 {
    agreed(|direction| signed_crossings(mesh.triangles_along(p, direction), p, direction))
}

/// [`winding_number`] of a mesh that need not be connected, and `rays` made of it.
pub fn winding_number_by_rays(mesh: &Mesh, rays: &RayMesh, p: DVec3) -> i32 {
    agreed(|direction| signed_crossings(rays.triangles_along(mesh, p, direction), p, direction))
}

/// Whether `p` is inside of a mesh of which only few points are asked: every triangle is looked at, nothing is
/// prepared.
pub fn is_inside_of(mesh: &Mesh, p: DVec3) -> bool {
    agreed(|direction| signed_crossings(mesh.iter_corners(), p, direction)) != 0
}

/// How often a mesh that need not be closed winds around `p`: where it is closed, outwards, 1 inside and 0 outside;
/// where something of it is missing, less than 1 by the share of all directions in which `p` looks out of it. One is
/// inside of what lacks little where this is above a half.
pub fn generalised_winding_number(mesh: &Mesh, p: DVec3) -> f64 {
    mesh.iter_corners().map(|corners| half_solid_angle(&corners, p)).sum::<f64>() / TAU
}

/// Half of the solid angle under which a triangle is seen from `p`, positive from behind it. After A. Van Oosterom and
/// J. Strackee (IEEE Trans. Biomed. Eng. 30, 1983).
pub fn half_solid_angle(corners: &[DVec3; 3], p: DVec3) -> f64 {
    let [a, b, c] = corners.map(|q| q - p);
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let cosine = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    a.dot(b.cross(c)).atan2(cosine)
}

/// The number of crossings that two directions agree on, or else two of three.
fn agreed(along: impl Fn(DVec3) -> i32) -> i32 {
    let [first, second] = [DIRECTIONS[0], DIRECTIONS[1]].map(&along);
    if first == second {
        return first;
    }
    let mut three = [first, second, along(DIRECTIONS[2])];
    three.sort_unstable();
    three[1]
}

/// Whether `p` is inside: the surface winds around it, either way.
pub fn is_inside(mesh: &ExactMesh, p: DVec3) -> bool {
    winding_number(mesh, p) != 0
}

/// The exact distance from `p` to the surface, negative inside (mm).
///
/// The normals next to the nearest point may give the wrong sign: beside a fold, as of a blade tip closed by a fan of
/// triangles, and within a shell beside another that reaches into it. So the surface must wind around `p` where they say
/// that it is inside, and where it lies in one of several shells.
pub fn guarded_distance(mesh: &ExactMesh, p: DVec3) -> f64 {
    guarded_nearest(mesh, p).signed_distance
}

/// The nearest point of the surface to `p`, with the sign of [`guarded_distance`].
pub fn guarded_nearest(mesh: &ExactMesh, p: DVec3) -> Nearest {
    let nearest = mesh.nearest(p);
    let distance = nearest.signed_distance;
    let is_doubted = distance < 0.0 || mesh.is_in_overlapping_shell(p, &nearest);
    let signed_distance = if is_doubted && is_inside(mesh, p) { -distance.abs() } else { distance.abs() };
    Nearest { signed_distance, ..nearest }
}

/// Crossings from inside to outside less those from outside to inside that a ray from `p` has with `triangles`.
fn signed_crossings(triangles: impl Iterator<Item = [DVec3; 3]>, p: DVec3, direction: DVec3) -> i32 {
    triangles.map(|corners| crossing(corners.map(|q| q - p), direction).map_or(0, |(sign, _)| sign)).sum()
}

/// How the ray from the origin along `direction` crosses a triangle: 1 if it leaves through its front, -1 if it
/// enters, and where, as a share of `direction`.
///
/// The two triangles at an edge are tested by the same volume with opposite signs, so no ray slips through between
/// them.
#[inline]
pub(super) fn crossing([a, b, c]: [DVec3; 3], direction: DVec3) -> Option<(i32, f64)> {
    let [u, v, w] = [b.cross(c), c.cross(a), a.cross(b)].map(|volume| volume.dot(direction));
    let front = u >= 0.0 && v >= 0.0 && w >= 0.0;
    let back = u < 0.0 && v < 0.0 && w < 0.0;
    if !front && !back {
        return None;
    }
    let sum = u + v + w;
    let share = (b - a).cross(c - a).dot(a) / sum;
    (sum != 0.0 && share > 0.0).then_some((if front { 1 } else { -1 }, share))
}

#[cfg(test)]
mod tests {
    use super::*;

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
                let inside = p.y > below && p.y < above;
                assert_eq!(guarded_distance(&exact, p) < 0.0, inside, "{p}");
                assert_eq!(is_inside_of(&mesh, p), inside, "{p}");
                mended += usize::from((exact.signed_distance(p) < 0.0) != inside);
            }
        }
        assert!(mended > 0, "the cap is folded so far that it matters");
    }

    #[test]
    fn overlapping_parts_are_wound_around_twice_and_cavities_not_at_all() {
        let outer = Mesh::cuboid(DVec3::splat(4.0));
        let with = |other: Mesh| {
            let first = outer.vertices.len() as u32;
            let triangles = other.triangles.iter().map(|t| t.map(|v| v + first));
            let triangles = outer.triangles.iter().copied().chain(triangles).collect();
            Mesh { vertices: [outer.vertices.clone(), other.vertices].concat(), triangles }
        };
        let both = with(outer.mapped(|p| p + 2.0));
        let (overlapping, rays) = (ExactMesh::new(&both).unwrap(), RayMesh::new(&both).unwrap());
        for (p, expected) in [(1.0, 1), (3.0, 2), (5.0, 1), (7.0, 0), (-1.0, 0)] {
            assert_eq!(winding_number(&overlapping, DVec3::splat(p)), expected, "{p}");
            assert_eq!(winding_number_by_rays(&both, &rays, DVec3::splat(p)), expected, "{p}");
        }
        let small = Mesh::cuboid(DVec3::ONE).mapped(|p| p + 1.0);
        let hollow = with(Mesh { triangles: small.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect(), ..small });
        let hollow = ExactMesh::new(&hollow).unwrap();
        // 0.2 from a face of one cube within the other.
        assert!((guarded_distance(&overlapping, DVec3::new(3.0, 3.0, 1.8)) + 0.2).abs() < 1e-12);
        assert!((guarded_distance(&overlapping, DVec3::new(5.0, 5.0, 1.8)) - 0.2).abs() < 1e-12);
        assert!((guarded_distance(&hollow, DVec3::splat(1.5)) - 0.5).abs() < 1e-12);
        assert!(guarded_distance(&hollow, DVec3::splat(0.8)) < 0.0);
        assert_eq!(winding_number(&hollow, DVec3::splat(1.5)), 0);
        assert_eq!(winding_number(&hollow, DVec3::splat(3.5)), 1);
    }

    #[test]
    fn rays_through_edges_and_corners_are_counted_once() {
        let mesh = ExactMesh::new(&Mesh::cuboid(DVec3::splat(2.0))).unwrap();
        let middle = DVec3::ONE;
        // Each direction from the middle to a corner, to the middle of an edge or of a face's diagonal.
        for i in (0..27).filter(|&i| i != 13) {
            let direction = DVec3::new((i % 3) as f64, (i / 3 % 3) as f64, (i / 9) as f64) - 1.0;
            let tilted = direction + DVec3::new(1e-9, 2.3e-9, -1.7e-9);
            let count = signed_crossings(mesh.triangles_along(middle, tilted), middle, tilted);
            assert_eq!(count, 1, "{direction}");
        }
    }
}
