//! Indexed triangle meshes.

use serde::{Deserialize, Serialize};
use std::collections::HashMap;

use glam::DVec3;
use rayon::prelude::*;
use sha2::{Digest, Sha256};

use super::frame::Frame;

/// A triangle mesh with shared vertices; triangles are counter-clockwise seen from outside.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Mesh {
    /// Vertex positions (mm).
    pub vertices: Vec<DVec3>,
    /// Vertex indices of each triangle.
    pub triangles: Vec<[u32; 3]>,
}

/// An edge between two faces that agree which way is out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Edge {
    /// Ends (mm).
    pub ends: [DVec3; 2],
    /// The unit normals of its faces, first of the one on its left.
    pub normals: [DVec3; 2],
}

impl Edge {
    /// Length (mm).
    pub fn length(&self) -> f64 {
        self.ends[0].distance(self.ends[1])
    }

    /// Unit vector from the first end to the second.
    pub fn along(&self) -> DVec3 {
        (self.ends[1] - self.ends[0]).normalize_or_zero()
    }
}

/// An axis-aligned box.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Bounds {
    /// Least coordinates.
    pub min: DVec3,
    /// Greatest coordinates.
    pub max: DVec3,
}

impl Bounds {
    /// The box that holds nothing.
    pub const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    /// The smallest box around `points`.
    pub fn of(points: impl IntoIterator<Item = DVec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| Self { min: b.min.min(p), max: b.max.max(p) })
    }

    /// Edge lengths.
    pub fn size(&self) -> DVec3 {
        self.max - self.min
    }

    /// The eight corners: number `i` lies on the far side along x, y, z where bits 0, 1, 2 of `i` are set.
    pub fn corners(&self) -> [DVec3; 8] {
        let ends = [self.min, self.max];
        std::array::from_fn(|i| DVec3::new(ends[i & 1].x, ends[i >> 1 & 1].y, ends[i >> 2 & 1].z))
    }

    /// Middle point.
    pub fn center(&self) -> DVec3 {
        (self.min + self.max) * 0.5
    }

    /// This box grown by `margin` on every side.
    pub fn grown(&self, margin: f64) -> Self {
        Self { min: self.min - margin, max: self.max + margin }
    }

    /// Distance from `p` to the box (mm); 0 within it.
    pub fn distance_to(&self, p: DVec3) -> f64 {
        p.distance(p.clamp(self.min, self.max))
    }

    /// Whether the two boxes share a point.
    pub fn intersects(&self, other: &Self) -> bool {
        self.min.cmple(other.max).all() && other.min.cmple(self.max).all()
    }
}

impl Mesh {
    /// The mesh with its triangles turned over: what was inside is outside.
    pub fn turned_over(&self) -> Self {
        let triangles = self.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
        Self { vertices: self.vertices.clone(), triangles }
    }

    /// The box `[0, size]` as 12 outward triangles.
    pub fn cuboid(size: DVec3) -> Self {
        let vertices =
            (0..8).map(|i| size * DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2 & 1) as f64)).collect();
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        Self { vertices, triangles }
    }

    /// Corner points of triangle `i`.
    pub fn corners(&self, i: usize) -> [DVec3; 3] {
        self.triangles[i].map(|v| self.vertices[v as usize])
    }

    /// Box around a triangle of this mesh.
    pub fn bounds_of(&self, triangle: &[u32; 3]) -> Bounds {
        Bounds::of(triangle.map(|v| self.vertices[v as usize]))
    }

    /// Corner points of every triangle in order.
    pub fn iter_corners(&self) -> impl ExactSizeIterator<Item = [DVec3; 3]> + '_ {
        self.triangles.iter().map(|t| t.map(|v| self.vertices[v as usize]))
    }

    /// Box around all vertices.
    pub fn bounds(&self) -> Bounds {
        Bounds::of(self.vertices.iter().copied())
    }

    /// Enclosed volume (mm^3); meaningful for closed meshes, positive when normals point outwards.
    pub fn volume(&self) -> f64 {
        // Relative to a nearby point, so that a mesh far from the origin loses no digits.
        let o = self.vertices.first().copied().unwrap_or_default();
        self.iter_corners().map(|[a, b, c]| (a - o).dot((b - o).cross(c - o))).sum::<f64>() / 6.0
    }

    /// Surface area (mm^2).
    pub fn area(&self) -> f64 {
        self.iter_corners().map(|t| normal_times_two_areas(t).length()).sum::<f64>() / 2.0
    }

    /// SHA-256 (lower-case hex) over the number and exact bits of the vertices and over the triangles: two meshes with
    /// the same digest are the same surface in the same coordinates.
    pub fn digest(&self) -> String {
        let mut hash = Sha256::new();
        hash.update((self.vertices.len() as u64).to_le_bytes());
        for vertex in &self.vertices {
            let [x, y, z] = vertex.to_array().map(|v| v.to_bits().to_le_bytes());
            hash.update([x, y, z].as_flattened());
        }
        for triangle in &self.triangles {
            hash.update(triangle.map(u32::to_le_bytes).as_flattened());
        }
        hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }

    /// How often each directed edge occurs; in a closed, oriented mesh each once, with its opposite once.
    pub fn directed_edges(&self) -> HashMap<(u32, u32), u32> {
        let mut edges = HashMap::with_capacity(self.triangles.len() * 3);
        for &[a, b, c] in &self.triangles {
            for edge in [(a, b), (b, c), (c, a)] {
                *edges.entry(edge).or_insert(0) += 1;
            }
        }
        edges
    }

    /// The edges in which the faces turn towards each other by more than `turn` (rad), in the order of their triangles.
    pub fn concave_edges(&self, turn: f64) -> Vec<Edge> {
        let faces: HashMap<(u32, u32), usize> = self.sides().collect();
        let edge = |((from, to), i)| {
            let other = faces.get(&(to, from)).filter(|_| from < to)?;
            let normals = [i, *other].map(|face| unit_normal(self.corners(face)));
            let ends = [from, to].map(|v| self.vertices[v as usize]);
            let [n, m] = normals;
            let is_concave = n.dot(m) < turn.cos() && n.cross(m).dot(ends[1] - ends[0]) < 0.0;
            is_concave.then_some(Edge { ends, normals })
        };
        self.sides().filter_map(edge).collect()
    }

    /// The directed edges of the triangles, each with the number of its triangle.
    pub fn sides(&self) -> impl Iterator<Item = ((u32, u32), usize)> + '_ {
        let sides = |[a, b, c]: [u32; 3]| [(a, b), (b, c), (c, a)];
        self.triangles.iter().enumerate().flat_map(move |(i, t)| sides(*t).map(|side| (side, i)))
    }

    /// Whether every edge is shared by exactly two triangles of agreeing orientation.
    pub fn is_watertight(&self) -> bool {
        // The edge's vertices, the lower first, then the direction in which a triangle passes it.
        let side =
            |from: u32, to: u32| u64::from(from.min(to)) << 33 | u64::from(from.max(to)) << 1 | u64::from(from > to);
        let of = |&[a, b, c]: &[u32; 3]| [side(a, b), side(b, c), side(c, a)];
        let mut sides: Vec<u64> = self.triangles.par_iter().flat_map_iter(of).collect();
        sides.par_sort_unstable();
        // Sorted, the two directions of every edge stand side by side.
        let is_passed_both_ways = |pair: &[u64]| pair[0] & 1 == 0 && pair.get(1) == Some(&(pair[0] | 1));
        !sides.is_empty() && sides.par_chunks(2).all(is_passed_both_ways)
    }

    /// The mesh without the vertices that no triangle has.
    pub fn compacted(&self) -> Self {
        let mut number = vec![u32::MAX; self.vertices.len()];
        let mut vertices = Vec::new();
        let mut keep = |v: u32| {
            let known = &mut number[v as usize];
            if *known == u32::MAX {
                *known = vertices.len() as u32;
                vertices.push(self.vertices[v as usize]);
            }
            *known
        };
        let triangles = self.triangles.iter().map(|t| t.map(&mut keep)).collect();
        Self { vertices, triangles }
    }

    /// Adds another mesh, whose vertices and triangles come after those of this one.
    pub fn append(&mut self, other: &Self) {
        let first = self.vertices.len() as u32;
        self.vertices.extend(&other.vertices);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + first)));
    }

    /// Mesh with its vertices mapped by `f`, which must keep orientation.
    pub fn mapped(&self, f: impl Fn(DVec3) -> DVec3) -> Self {
        Self { vertices: self.vertices.iter().map(|&p| f(p)).collect(), triangles: self.triangles.clone() }
    }

    /// The mesh in coordinates of `frame`, when it is given in the parent's.
    pub fn in_frame(&self, frame: &Frame) -> Self {
        self.mapped(|p| frame.from_parent(p))
    }

    /// The mesh in the parent's coordinates, when it is given in `frame`.
    pub fn in_parent_of(&self, frame: &Frame) -> Self {
        self.mapped(|p| frame.to_parent(p))
    }
}

/// The normal of a triangle scaled by twice its area.
pub fn normal_times_two_areas([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// A triangle halved until no edge is longer than `longest` allows between its ends, at the edge that exceeds it most,
/// as far as it lies in `around`. Every long edge is halved at its middle, from both sides, so that neighbours share
/// their vertices.
pub fn halved(corners: [DVec3; 3], around: &Bounds, longest: &dyn Fn(DVec3, DVec3) -> f64) -> Vec<[DVec3; 3]> {
    let (mut open, mut small) = (vec![corners], Vec::new());
    while let Some([a, b, c]) = open.pop() {
        if !Bounds::of([a, b, c]).intersects(around) {
            continue;
        }
        let turns = [[a, b, c], [b, c, a], [c, a, b]];
        let excess = turns.map(|[p, q, _]| p.distance(q) / longest(p, q));
        let most = (0..3).fold(0, |best, i| if excess[i] > excess[best] { i } else { best });
        if excess[most] <= 1.0 {
            small.push([a, b, c]);
            continue;
        }
        let [p, q, r] = turns[most];
        // The sum does not depend on the order of the two ends.
        let middle = (p + q) * 0.5;
        open.extend([[p, middle, r], [middle, q, r]]);
    }
    small
}

/// The unit normal of a triangle, zero for a degenerate one.
pub fn unit_normal(corners: [DVec3; 3]) -> DVec3 {
    normal_times_two_areas(corners).normalize_or_zero()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_digest_tells_one_bit_and_one_triangle() {
        let mesh = Mesh::cuboid(DVec3::new(2.0, 3.0, 4.0));
        assert_eq!(mesh.digest(), mesh.clone().digest());
        let (mut moved, mut turned) = (mesh.clone(), mesh.clone());
        moved.vertices[5].y = f64::from_bits(moved.vertices[5].y.to_bits() + 1);
        turned.triangles[3].rotate_left(1);
        let shorter = Mesh { triangles: mesh.triangles[1..].to_vec(), ..mesh.clone() };
        let all = [&mesh, &moved, &turned, &shorter].map(Mesh::digest);
        assert!((0..4).all(|i| all[i].len() == 64 && (0..i).all(|j| all[i] != all[j])), "{all:?}");
        // No vertices and no triangles: the digest of eight zero bytes, as another program computes it.
        let nothing = "af5570f5a1810b7af78caf4bc70a660f0df51e42baf91d4de5b2328de0e83dfc";
        assert_eq!(Mesh::default().digest(), nothing);
    }

    #[test]
    fn a_box_has_its_volume_area_and_no_holes() {
        let mesh = Mesh::cuboid(DVec3::new(2.0, 3.0, 4.0)).mapped(|p| p + 1e4);
        assert!((mesh.volume() - 24.0).abs() < 1e-9);
        assert!((mesh.area() - 52.0).abs() < 1e-9);
        assert!(mesh.is_watertight());
        let open = Mesh { triangles: mesh.triangles[1..].to_vec(), ..mesh };
        assert!(!open.is_watertight());
    }
}
