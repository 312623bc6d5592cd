//! Edges and the triangles that meet at them.

use super::source::tick;
use geometry::mesh::Mesh;
use task::{Cancelled, Task};

/// No half-edge.
pub(super) const NONE: u32 = u32::MAX;

/// Half-edge `3 t + k` goes from corner `k` of triangle `t` to its next corner.
pub(super) fn half_ends(mesh: &Mesh, half: u32) -> (u32, u32) {
    let (triangle, k) = (mesh.triangles[half as usize / 3], half as usize % 3);
    (triangle[k], triangle[(k + 1) % 3])
}

/// The half-edges of a mesh, sorted by the edge they lie on.
///
/// No triangle of the mesh may have a vertex twice.
pub(super) struct EdgeTable {
    /// Where the entries of each vertex begin; an edge is found at the lower of its two vertices.
    start: Vec<u32>,
    /// Higher vertex and half-edge.
    entries: Vec<(u32, u32)>,
}

/// An edge and the half-edges on it, in either direction.
pub(super) struct Edge<'a> {
    pub low: u32,
    pub high: u32,
    entries: &'a [(u32, u32)],
}

impl Edge<'_> {
    /// Half-edges on this edge, in the order of their triangles.
    pub fn halves(&self) -> impl ExactSizeIterator<Item = u32> + Clone + '_ {
        self.entries.iter().map(|&(_, half)| half)
    }

    /// Half-edges from the lower to the higher vertex less those of the opposite direction.
    pub fn imbalance(&self, mesh: &Mesh) -> i64 {
        self.halves().map(|half| if half_ends(mesh, half).0 == self.low { 1 } else { -1 }).sum()
    }
}

impl EdgeTable {
    /// Sorts the half-edges of `mesh`, by counting: linear in their number.
    pub fn of(mesh: &Mesh, task: &Task) -> Result<Self, Cancelled> {
        const STAGE: &str = "finding edges";
        let count = mesh.triangles.len();
        let mut start = vec![0_u32; mesh.vertices.len() + 1];
        for (t, &[a, b, c]) in mesh.triangles.iter().enumerate() {
            tick(task, STAGE, t, 3 * count)?;
            for low in [a.min(b), b.min(c), c.min(a)] {
                start[low as usize + 1] += 1;
            }
        }
        for v in 1..start.len() {
            start[v] += start[v - 1];
        }
        let mut next = start.clone();
        let mut entries = vec![(0, 0); 3 * count];
        for t in 0..count {
            tick(task, STAGE, count + t, 3 * count)?;
            for half in 3 * t as u32..3 * t as u32 + 3 {
                let (a, b) = half_ends(mesh, half);
                let slot = &mut next[a.min(b) as usize];
                entries[*slot as usize] = (a.max(b), half);
                *slot += 1;
            }
        }
        for v in 0..mesh.vertices.len() {
            tick(task, STAGE, count + v, count + mesh.vertices.len())?;
            entries[start[v] as usize..start[v + 1] as usize].sort_unstable();
        }
        Ok(Self { start, entries })
    }

    /// All edges, in the order of their vertices.
    pub fn edges(&self) -> impl Iterator<Item = Edge<'_>> {
        (0..self.start.len() - 1).flat_map(|low| self.edges_at(low as u32))
    }

    /// The edges whose lower vertex is `low`.
    fn edges_at(&self, low: u32) -> impl Iterator<Item = Edge<'_>> {
        let range = self.start[low as usize] as usize..self.start[low as usize + 1] as usize;
        self.entries[range].chunk_by(|a, b| a.0 == b.0).map(move |entries| Edge { low, high: entries[0].0, entries })
    }

    /// Whether some triangle has the edge between `a` and `b`.
    pub fn contains(&self, a: u32, b: u32) -> bool {
        let range = self.start[a.min(b) as usize] as usize..self.start[a.min(b) as usize + 1] as usize;
        self.entries[range].binary_search_by_key(&a.max(b), |&(high, _)| high).is_ok()
    }

    /// Whether every edge joins exactly two triangles.
    pub fn is_closed(&self) -> bool {
        self.edges().all(|edge| edge.entries.len() == 2)
    }

    /// Whether every edge joins exactly two triangles of agreeing orientation.
    pub fn is_watertight(&self, mesh: &Mesh) -> bool {
        self.edges().all(|edge| edge.entries.len() == 2 && edge.imbalance(mesh) == 0)
    }

    /// Sum over the edges of how many half-edges lack their opposite: 0 for a surface without boundary.
    pub fn boundary_size(&self, mesh: &Mesh) -> u64 {
        self.edges().map(|edge| edge.imbalance(mesh).unsigned_abs()).sum()
    }

    /// For each half-edge the other one on its edge, [`NONE`] unless the edge joins exactly two triangles.
    pub fn twins(&self) -> Vec<u32> {
        let mut twins = vec![NONE; self.entries.len()];
        for edge in self.edges() {
            if let &[(_, a), (_, b)] = edge.entries {
                twins[a as usize] = b;
                twins[b as usize] = a;
            }
        }
        twins
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn a_box_has_eighteen_edges_of_two_and_an_open_one_lacks_three_twins() {
        let mut mesh = Mesh::cuboid(DVec3::ONE);
        let table = EdgeTable::of(&mesh, &Task::default()).unwrap();
        assert_eq!(table.edges().count(), 18);
        assert!(table.is_watertight(&mesh) && table.boundary_size(&mesh) == 0);
        for (half, &twin) in table.twins().iter().enumerate() {
            let (a, b) = half_ends(&mesh, half as u32);
            assert_eq!(half_ends(&mesh, twin), (b, a));
            assert!(table.contains(a, b) && table.contains(b, a));
        }
        mesh.triangles.remove(5);
        let table = EdgeTable::of(&mesh, &Task::default()).unwrap();
        assert!(!table.is_watertight(&mesh));
        assert_eq!(table.boundary_size(&mesh), 3);
        assert_eq!(table.twins().iter().filter(|&&t| t == NONE).count(), 3);
    }
}
