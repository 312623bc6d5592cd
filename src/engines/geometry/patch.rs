//! Four-sided patches of a mesh.

/// A grid of vertices of a mesh, over whose triangles one smooth surface is meant to pass: a face with four sides.
///
/// Rows and columns are numbered so that the direction of rising rows, that of rising columns and the outward normal are
/// right-handed.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Patch {
    /// Number of vertices in each row.
    pub columns: usize,
    /// Vertices of the mesh, row after row.
    pub vertices: Vec<u32>,
}

impl Patch {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.vertices.len().checked_div(self.columns).unwrap_or(0)
    }

    /// The vertex in a row and a column.
    pub fn at(&self, row: usize, column: usize) -> u32 {
        self.vertices[row * self.columns + column]
    }

    /// The patch with rows for columns: its normal points the other way.
    #[must_use]
    pub fn turned_over(&self) -> Self {
        let transposed = (0..self.columns).flat_map(|j| (0..self.rows()).map(move |i| self.at(i, j)));
        Self { columns: self.rows(), vertices: transposed.collect() }
    }

    /// The vertices along its four sides, counter-clockwise seen from outside: the first column with rising rows, the last
    /// row, the last column, the first row.
    pub fn sides(&self) -> [Vec<u32>; 4] {
        let (last_row, last_column) = (self.rows() - 1, self.columns - 1);
        [
            (0..=last_row).map(|i| self.at(i, 0)).collect(),
            (0..=last_column).map(|j| self.at(last_row, j)).collect(),
            (0..=last_row).rev().map(|i| self.at(i, last_column)).collect(),
            (0..=last_column).rev().map(|j| self.at(0, j)).collect(),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_go_round_and_turn_the_other_way_when_the_patch_is_turned_over() {
        let patch = Patch { columns: 3, vertices: vec![0, 1, 2, 3, 4, 5] };
        assert_eq!(patch.sides(), [vec![0, 3], vec![3, 4, 5], vec![5, 2], vec![2, 1, 0]]);
        let over = patch.turned_over();
        assert_eq!(over.sides(), [vec![0, 1, 2], vec![2, 5], vec![5, 4, 3], vec![3, 0]]);
        assert_eq!((over.rows(), over.turned_over()), (3, patch));
    }
}
