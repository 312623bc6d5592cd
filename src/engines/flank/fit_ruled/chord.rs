//! How far the triangles of a face may be off the smooth surface that was tessellated.
//!
//! It shows in how the triangles turn against each other. A flat that goes over into a rounding turns at their seam only:
//! normals at the seam that are the mean of both would make a bulge of the whole flat. So triangles are compared within
//! one smooth piece of the face: flats are pieces by themselves, and whatever is curved between them.

use std::collections::HashMap;

use glam::DVec3;

use super::patch::Patch;
use geometry::mesh::normal_times_two_areas;
use geometry::segmentation::{FaceKind, Segmentation, SegmentationSettings};

/// Greatest distance between the triangles and a smooth surface through their corners (mm), estimated. Zero over flats.
pub(super) fn error(patch: &Patch) -> f64 {
    let piece = smooth_pieces(patch);
    along_sides(patch, &piece).max(across_sides(patch, &piece))
}

/// The smooth piece that each triangle belongs to. Faces side by side are one piece, whether a plane is among them or
/// not, unless just one of both is a plane: what is flat beside something curved is flat, but planes beside planes may be
/// the coarse triangles of one curved surface.
fn smooth_pieces(patch: &Patch) -> Vec<u32> {
    let found = Segmentation::of(&patch.mesh(), &SegmentationSettings::default());
    let is_flat: Vec<bool> = found.faces.iter().map(|f| matches!(f.kind, FaceKind::Plane { .. })).collect();
    let mut piece: Vec<u32> = (0..found.faces.len() as u32).collect();
    let root = |piece: &[u32], mut f: u32| {
        while piece[f as usize] != f {
            f = piece[f as usize];
        }
        f
    };
    for edge in &found.edges {
        let [a, b] = edge.faces;
        if is_flat[a as usize] == is_flat[b as usize] {
            let (a, b) = (root(&piece, a), root(&piece, b));
            piece[a.max(b) as usize] = a.min(b);
        }
    }
    found.face_of.iter().map(|f| root(&piece, *f)).collect()
}

/// The greatest height, over the sides of triangles, of the cubic that has the piece's normals at both ends: a quarter of
/// the turn of the chord, as of a circle's.
fn along_sides(patch: &Patch, piece: &[u32]) -> f64 {
    let mut normals: HashMap<(u32, u32), DVec3> = HashMap::with_capacity(patch.points.len());
    for (t, corners) in patch.triangles.iter().enumerate() {
        let points = patch.corners(t);
        let normal = normal_times_two_areas(points).normalize_or_zero();
        for k in 0..3 {
            // By the angle at the corner, so that it is no matter how a quadrangle is cut in two.
            let (a, b) = (points[(k + 1) % 3] - points[k], points[(k + 2) % 3] - points[k]);
            *normals.entry((corners[k], piece[t])).or_default() += normal * a.cross(b).length().atan2(a.dot(b));
        }
    }
    normals.values_mut().for_each(|n| *n = n.normalize_or_zero());
    let at = |v: u32, piece: u32| normals.get(&(v, piece)).copied().unwrap_or_default();
    let height = |t: usize, k: usize| {
        let (a, b) = (patch.triangles[t][k], patch.triangles[t][(k + 1) % 3]);
        let along = patch.points[b as usize] - patch.points[a as usize];
        (along.dot(at(b, piece[t]) - at(a, piece[t])) / 8.0).abs()
    };
    (0..patch.triangles.len()).flat_map(|t| (0..3).map(move |k| (t, k))).map(|(t, k)| height(t, k)).fold(0.0, f64::max)
}

/// The same from how neighbours of one piece turn over the side that they share, which tells of a rounding of two
/// triangles' breadth, whose normals at the seams are those of one triangle only.
fn across_sides(patch: &Patch, piece: &[u32]) -> f64 {
    let mut sides: Vec<(u32, u32, u32)> = Vec::with_capacity(3 * patch.triangles.len());
    for (t, corners) in patch.triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            sides.push((a.min(b), a.max(b), t as u32));
        }
    }
    sides.sort_unstable();
    let height = |pair: &[(u32, u32, u32)]| {
        let [(a, b, s), (_, _, t)] = *pair else { return 0.0 };
        if piece[s as usize] != piece[t as usize] {
            return 0.0;
        }
        let length = patch.points[a as usize].distance(patch.points[b as usize]).max(f64::MIN_POSITIVE);
        let doubled = [s, t].map(|t| normal_times_two_areas(patch.corners(t as usize)));
        let [h, g] = doubled.map(|n| n.length() / length);
        let turn = doubled[0].cross(doubled[1]).length().atan2(doubled[0].dot(doubled[1]));
        // An arc that turns so much from the middle of one to the middle of the other.
        let bend = 2.0 * turn / (h + g).max(f64::MIN_POSITIVE);
        bend * h.min(g).powi(2) / 8.0
    };
    let found = sides.chunk_by(|s, t| (s.0, s.1) == (t.0, t.1)).map(height);
    found.fold(0.0, f64::max)
}
