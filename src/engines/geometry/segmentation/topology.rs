//! Triangles of a mesh with their neighbours, normals and areas.

use glam::DVec3;

use crate::mesh::{Mesh, normal_times_two_areas};
use crate::weld::Weld;

/// No triangle, no facet, no face.
pub(super) const NONE: u32 = u32::MAX;

/// The triangles of a mesh, their points joined where they coincide and counted from the middle of the mesh.
pub(super) struct Topology {
    /// Origin of the points (mm).
    pub(super) origin: DVec3,
    /// Points (mm).
    pub(super) points: Vec<DVec3>,
    /// The points of each triangle.
    pub(super) corners: Vec<[u32; 3]>,
    /// The triangle across side `k`, which runs from corner `k` to the next; [`NONE`] at a border.
    pub(super) neighbours: Vec<[u32; 3]>,
    /// Unit normals, zero for a triangle without area.
    pub(super) normals: Vec<DVec3>,
    /// Areas (mm^2).
    pub(super) areas: Vec<f64>,
    /// The least height of each triangle (mm); zero without area.
    pub(super) heights: Vec<f64>,
    /// Greatest error of a coordinate that was once stored with 24 bits (mm).
    pub(super) rounding: f64,
}

impl Topology {
    pub(super) fn of(mesh: &Mesh) -> Self {
        let finite = || mesh.vertices.iter().copied().filter(|p| p.is_finite());
        let low = finite().reduce(DVec3::min).unwrap_or_default();
        let high = finite().reduce(DVec3::max).unwrap_or_default();
        let origin = 0.5 * low + 0.5 * high;
        let rounding = low.abs().max(high.abs()).max_element() * 2f64.powi(-24);
        let mut weld = Weld::with_capacity(mesh.vertices.len());
        let number: Vec<u32> = mesh.vertices.iter().map(|p| weld.add(*p)).collect();
        let corner = |v: u32| number.get(v as usize).copied().unwrap_or(NONE);
        let corners: Vec<[u32; 3]> = mesh.triangles.iter().map(|t| t.map(corner)).collect();
        let points: Vec<DVec3> = weld.points().iter().map(|p| p - origin).collect();
        let neighbours = neighbours(&points, &corners);
        let mut topology = Self {
            origin,
            points,
            corners,
            neighbours,
            normals: Vec::new(),
            areas: Vec::new(),
            heights: Vec::new(),
            rounding,
        };
        topology.measure();
        topology
    }

    fn measure(&mut self) {
        for i in 0..self.corners.len() {
            let (mut normal, mut area, mut height) = (DVec3::ZERO, 0.0, 0.0);
            if is_sound(&self.points, self.corners[i]) {
                let [a, b, c] = self.triangle(i);
                let doubled = normal_times_two_areas([a, b, c]);
                let longest = (b - a).length().max((c - b).length()).max((a - c).length());
                let size = doubled.length();
                if size.is_finite() && size > 0.0 {
                    (normal, area, height) = (doubled.normalize_or_zero(), 0.5 * size, size / longest);
                }
            }
            self.normals.push(normal);
            self.areas.push(area);
            self.heights.push(height);
        }
    }

    /// Points of triangle `i`.
    pub(super) fn triangle(&self, i: usize) -> [DVec3; 3] {
        self.corners[i].map(|v| self.points[v as usize])
    }

    /// The ends of side `k` of triangle `i`.
    pub(super) fn side(&self, i: usize, k: usize) -> [u32; 2] {
        [self.corners[i][k], self.corners[i][(k + 1) % 3]]
    }

    /// From the first to the second end of side `k` of triangle `i` (mm).
    pub(super) fn along_side(&self, i: usize, k: usize) -> DVec3 {
        let [a, b] = self.side(i, k);
        self.points[b as usize] - self.points[a as usize]
    }

    /// The points of `triangles`, each once, rising.
    pub(super) fn points_of(&self, triangles: impl IntoIterator<Item = u32>) -> Vec<u32> {
        let mut found: Vec<u32> = triangles.into_iter().flat_map(|t| self.corners[t as usize]).collect();
        found.sort_unstable();
        found.dedup();
        found
    }
}

/// Whether a triangle has three different points, all finite.
fn is_sound(points: &[DVec3], [a, b, c]: [u32; 3]) -> bool {
    let is_point = |v: u32| points.get(v as usize).is_some_and(|p| p.is_finite());
    a != b && b != c && c != a && is_point(a) && is_point(b) && is_point(c)
}

/// The triangle across each side. More than two triangles at a side, or two that disagree which way is out, are no
/// neighbours.
fn neighbours(points: &[DVec3], corners: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut sides = Vec::with_capacity(corners.len() * 3);
    for (i, &triangle) in corners.iter().enumerate().filter(|(_, t)| is_sound(points, **t)) {
        for k in 0..3 {
            let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
            sides.push((a.min(b), a.max(b), a > b, i as u32, k as u32));
        }
    }
    sides.sort_unstable();
    let mut found = vec![[NONE; 3]; corners.len()];
    for group in sides.chunk_by(|s, t| (s.0, s.1) == (t.0, t.1)) {
        if let [(_, _, false, i, k), (_, _, true, j, l)] = *group {
            found[i as usize][k as usize] = j;
            found[j as usize][l as usize] = i;
        }
    }
    found
}
