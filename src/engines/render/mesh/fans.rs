//! The triangles around each vertex.

/// For each vertex the corners of triangles that lie on it, in rising order. Corner `3 t + k` is the `k`-th of
/// triangle `t`.
pub struct Fans {
    starts: Vec<u32>,
    corners: Vec<u32>,
}

impl Fans {
    /// The fans of a mesh with `vertex_count` vertices, all of whose indices exist.
    pub fn new(vertex_count: usize, triangles: &[[u32; 3]]) -> Self {
        let mut starts = vec![0u32; vertex_count + 1];
        for &v in triangles.as_flattened() {
            starts[v as usize + 1] += 1;
        }
        for v in 0..vertex_count {
            starts[v + 1] += starts[v];
        }
        let mut next = starts.clone();
        let mut corners = vec![0u32; triangles.len() * 3];
        for (corner, &v) in triangles.as_flattened().iter().enumerate() {
            let place = &mut next[v as usize];
            corners[*place as usize] = corner as u32;
            *place += 1;
        }
        Self { starts, corners }
    }

    /// Number of vertices.
    pub fn vertex_count(&self) -> usize {
        self.starts.len() - 1
    }

    /// Range of the corners of vertex `v` in the list of all corners.
    pub fn range(&self, v: usize) -> std::ops::Range<usize> {
        self.starts[v] as usize..self.starts[v + 1] as usize
    }

    /// The corners on vertex `v`.
    pub fn of(&self, v: usize) -> &[u32] {
        &self.corners[self.range(v)]
    }

    /// The corners of every vertex, one vertex after the other.
    pub fn all(&self) -> &[u32] {
        &self.corners
    }
}
