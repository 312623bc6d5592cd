//! Surfaces moved outwards, each face by its own distance.

use std::collections::{HashMap, HashSet};

use glam::{DMat3, DVec2, DVec3};
use rayon::prelude::*;

use super::mesh::{Mesh, normal_times_two_areas, unit_normal};
use super::solid::filled;

/// Normals that differ by less than this are those of one face.
const SAME: f64 = 2e-4;
/// Height of a triangle below which its normal is noise (mm).
const SLIVER: f64 = 1e-5;
/// A constraint may be missed by this share of its distance.
const SLACK: f64 = 1e-9;
/// Normals of a vertex at most that are combined by threes; of more, those of the largest faces go first.
const MOST: usize = 40;

/// Reason why a surface cannot be moved.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum OffsetError {
    /// The faces at a vertex look all ways.
    #[error("at ({:.3}, {:.3}, {:.3}) faces look in opposite directions (a point or a wall without thickness), so that \
         the surface has no offset there", .0.x, .0.y, .0.z)]
    Pointed(DVec3),
}

/// `mesh` with every face moved outwards by at least `distance` of its unit normal (mm), and each vertex as little as
/// that allows: edges stay sharp, nothing comes closer to its own face. Vertices keep their numbers; flat faces may be
/// divided into other triangles. Where a hollow or a step is narrower than the way of its corners the moved faces cross
/// each other.
///
/// # Errors
/// [`OffsetError`].
pub fn offset(mesh: &Mesh, distance: impl Fn(DVec3) -> f64 + Sync) -> Result<Mesh, OffsetError> {
    moved(mesh, |own| least_shift(&own.iter().map(|n| (*n, distance(*n))).collect::<Vec<_>>()))
}

/// `mesh` with each vertex moved by the shift for the different normals of the faces around it.
fn moved(mesh: &Mesh, shift: impl Fn(&[DVec3]) -> Option<DVec3> + Sync) -> Result<Mesh, OffsetError> {
    let normals = vertex_normals(mesh);
    let moved = |(vertex, own): (&DVec3, &Vec<DVec3>)| {
        shift(own).map(|shift| *vertex + shift).ok_or(OffsetError::Pointed(*vertex))
    };
    let vertices = mesh.vertices.par_iter().zip(&normals).map(moved).collect::<Result<_, _>>()?;
    let mut grown = Mesh { vertices, triangles: mesh.triangles.clone() };
    unfold(&mut grown, mesh);
    Ok(grown)
}

/// Fills flat faces anew in which corners that moved across a thin triangle left it upside down.
fn unfold(grown: &mut Mesh, mesh: &Mesh) {
    let normals: Vec<DVec3> = mesh.iter_corners().map(unit_normal).collect();
    let is_turned = |i: usize| normals[i].dot(normal_times_two_areas(grown.corners(i))) < 0.0;
    let turned: Vec<usize> = (0..normals.len()).filter(|i| is_turned(*i)).collect();
    if turned.is_empty() {
        return;
    }
    let mut sides = HashMap::new();
    for (i, &[a, b, c]) in mesh.triangles.iter().enumerate() {
        [(a, b), (b, c), (c, a)].into_iter().for_each(|side| {
            sides.insert(side, i);
        });
    }
    let mut seen = vec![false; normals.len()];
    let mut filled: Vec<(Vec<usize>, Vec<[u32; 3]>)> = Vec::new();
    for first in turned {
        if seen[first] {
            continue;
        }
        seen[first] = true;
        let (mut face, mut next) = (vec![first], 0);
        while let Some(&i) = face.get(next) {
            next += 1;
            let [a, b, c] = mesh.triangles[i];
            for side in [(b, a), (c, b), (a, c)] {
                let Some(&j) = sides.get(&side) else { continue };
                if !seen[j] && normals[j].distance_squared(normals[first]) < SAME * SAME {
                    seen[j] = true;
                    face.push(j);
                }
            }
        }
        if let Some(anew) = filled_anew(grown, &face, normals[first]) {
            filled.push((face, anew));
        }
    }
    let mut is_gone = vec![false; normals.len()];
    filled.iter().flat_map(|(face, _)| face).for_each(|i| is_gone[*i] = true);
    let mut kept = is_gone.iter();
    grown.triangles.retain(|_| kept.next() != Some(&true));
    grown.triangles.extend(filled.into_iter().flat_map(|(_, anew)| anew));
}

/// Other triangles between the border of a flat face; none where it crosses itself.
fn filled_anew(grown: &Mesh, face: &[usize], normal: DVec3) -> Option<Vec<[u32; 3]>> {
    let sides = face.iter().map(|i| grown.triangles[*i]).flat_map(|[a, b, c]| [(a, b), (b, c), (c, a)]);
    let sides: Vec<(u32, u32)> = sides.collect();
    let all: HashSet<(u32, u32)> = sides.iter().copied().collect();
    let mut border: HashMap<u32, u32> = HashMap::new();
    for (a, b) in sides.iter().filter(|(a, b)| !all.contains(&(*b, *a))) {
        // A face that meets itself in a corner has no single way around.
        if border.insert(*a, *b).is_some() {
            return None;
        }
    }
    let (x, y) = normal.any_orthonormal_pair();
    let plan = |v: u32| DVec2::new(grown.vertices[v as usize].dot(x), grown.vertices[v as usize].dot(y));
    let mut rings: Vec<Vec<u32>> = Vec::new();
    for &(start, _) in sides.iter().filter(|(a, b)| !all.contains(&(*b, *a))) {
        let mut ring = Vec::new();
        let mut at = start;
        while let Some(next) = border.remove(&at) {
            ring.push(at);
            at = next;
        }
        if !ring.is_empty() {
            rings.push(ring);
        }
    }
    let area = |ring: &Vec<u32>| -> f64 {
        let n = ring.len();
        (0..n).map(|i| plan(ring[i]).perp_dot(plan(ring[(i + 1) % n]))).sum()
    };
    rings.sort_by(|a, b| area(b).total_cmp(&area(a)));
    // One outer border; all others are holes.
    if rings.is_empty() || area(&rings[0]) <= 0.0 || rings[1..].iter().any(|ring| area(ring) >= 0.0) {
        return None;
    }
    let points: Vec<Vec<DVec2>> = rings.iter().map(|ring| ring.iter().map(|v| plan(*v)).collect()).collect();
    let numbers: Vec<u32> = rings.concat();
    let triangles = filled(&points.iter().map(Vec::as_slice).collect::<Vec<_>>()).ok()?;
    Some(triangles.into_iter().map(|t| t.map(|i| numbers[i as usize])).collect())
}

/// The different normals of the faces around each vertex, those of the largest triangles first.
pub(super) fn vertex_normals(mesh: &Mesh) -> Vec<Vec<DVec3>> {
    let mut around: Vec<Vec<(f64, DVec3)>> = vec![Vec::new(); mesh.vertices.len()];
    for (triangle, corners) in mesh.triangles.iter().zip(mesh.iter_corners()) {
        let [a, b, c] = corners;
        let normal = normal_times_two_areas(corners);
        let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
        if normal.length() <= SLIVER * longest {
            continue;
        }
        triangle.iter().for_each(|v| around[*v as usize].push((normal.length(), normal.normalize())));
    }
    let different = |mut all: Vec<(f64, DVec3)>| {
        all.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut kept: Vec<DVec3> = Vec::new();
        for (_, normal) in all {
            if kept.len() < MOST && kept.iter().all(|k| k.distance_squared(normal) > SAME * SAME) {
                kept.push(normal);
            }
        }
        kept
    };
    around.into_par_iter().map(different).collect()
}

/// The shortest shift that goes at least each plane's distance along its normal.
pub(super) fn least_shift(planes: &[(DVec3, f64)]) -> Option<DVec3> {
    let holds = |shift: DVec3| planes.iter().all(|(n, d)| n.dot(shift) >= d - SLACK * (1.0 + d.abs()));
    let mut best: Option<DVec3> = None;
    let mut offer = |shift: DVec3| {
        let is_shorter = best.is_none_or(|b| shift.length_squared() < b.length_squared());
        if shift.is_finite() && is_shorter && holds(shift) {
            best = Some(shift);
        }
    };
    offer(DVec3::ZERO);
    // The shortest one is held by one, two or three planes; with fewer it is shorter.
    planes.iter().for_each(|(n, d)| offer(*n * *d));
    for (i, (a, da)) in planes.iter().enumerate() {
        for (b, db) in &planes[..i] {
            let cos = a.dot(*b);
            let free = 1.0 - cos * cos;
            offer((*a * (da - cos * db) + *b * (db - cos * da)) / free);
        }
    }
    for (i, (a, da)) in planes.iter().enumerate() {
        for (j, (b, db)) in planes[..i].iter().enumerate() {
            for (c, dc) in &planes[..j] {
                let rows = DMat3::from_cols(*a, *b, *c).transpose();
                if rows.determinant().abs() > 1e-12 {
                    offer(rows.inverse() * DVec3::new(*da, *db, *dc));
                }
            }
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solid::{difference, prism};

    fn block(low: DVec3, high: DVec3) -> Mesh {
        let ring = [(low.x, low.y), (high.x, low.y), (high.x, high.y), (low.x, high.y)].map(DVec2::from);
        prism(&[&ring], low.z, high.z).unwrap()
    }

    #[test]
    fn a_block_grows_by_the_distance_of_each_face() {
        let mesh = block(DVec3::ZERO, DVec3::new(4.0, 3.0, 2.0));
        let even = offset(&mesh, |_| 0.25).unwrap();
        assert!(even.is_watertight() && (even.volume() - 4.5 * 3.5 * 2.5).abs() < 1e-12);
        // An orbit in plan widens walls only.
        let walls = offset(&mesh, |n| 0.1 + 0.2 * n.truncate().length()).unwrap();
        assert!((walls.volume() - 4.6 * 3.6 * 2.2).abs() < 1e-12);
    }

    #[test]
    fn a_pocket_shrinks_and_its_edges_stay_sharp() {
        let block_with_pocket = difference(
            &block(DVec3::ZERO, DVec3::new(10.0, 10.0, 5.0)),
            &block(DVec3::new(2.0, 3.0, 2.0), DVec3::new(8.0, 7.0, 6.0)),
        )
        .unwrap();
        let grown = offset(&block_with_pocket, |_| 0.1).unwrap();
        let expected = 10.2 * 10.2 * 5.2 - 5.8 * 3.8 * 3.0;
        assert!((grown.volume() - expected).abs() < 1e-9, "{} {expected}", grown.volume());
    }

    #[test]
    fn no_corner_of_a_faceted_ball_comes_closer_to_its_faces() {
        // Twelve facets around, six from pole to pole: at the poles twelve different planes meet.
        let at = |i: usize, k: usize| {
            let (around, up) = (i as f64 * std::f64::consts::TAU / 12.0, k as f64 * std::f64::consts::PI / 6.0);
            DVec3::new(up.sin() * around.cos(), up.sin() * around.sin(), up.cos()) * 5.0
        };
        let mut mesh = Mesh { vertices: vec![at(0, 0), at(0, 6)], triangles: Vec::new() };
        mesh.vertices.extend((1..6).flat_map(|k| (0..12).map(move |i| at(i, k))));
        let vertex = |i: usize, k: usize| {
            if k == 0 {
                0
            } else if k == 6 {
                1
            } else {
                (2 + (k - 1) * 12 + i % 12) as u32
            }
        };
        for (i, k) in (0..12).flat_map(|i| (0..6).map(move |k| (i, k))) {
            let [a, b, c, d] = [vertex(i, k), vertex(i, k + 1), vertex(i + 1, k + 1), vertex(i + 1, k)];
            mesh.triangles.extend([[a, b, c], [a, c, d]].into_iter().filter(|[a, b, c]| a != b && b != c && c != a));
        }
        assert!(mesh.is_watertight() && mesh.volume() > 0.0);
        let grown = offset(&mesh, |_| 0.3).unwrap();
        for (corners, moved) in mesh.iter_corners().zip(grown.iter_corners()) {
            let normal = crate::mesh::unit_normal(corners);
            let off = moved.map(|p| normal.dot(p - corners[0]));
            assert!(off.iter().all(|d| (0.3 - 1e-6..0.33).contains(d)), "{off:?}");
        }
    }

    #[test]
    fn a_wall_without_thickness_has_no_offset() {
        let [a, b, c] = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let mesh = Mesh { vertices: vec![a, b, c], triangles: vec![[0, 1, 2], [0, 2, 1]] };
        assert_eq!(offset(&mesh, |_| 0.1), Err(OffsetError::Pointed(a)));
    }
}
