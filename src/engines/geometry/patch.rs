//! Four-sided patches of a mesh.

/// A grid of vertices of a mesh, over whose triangles one smooth surface is meant to pass: a face with four sides.
///
/// Rows and columns are numbered so that the direction of rising rows, that of rising columns and the outward normal are
/// right-handed. Both are at least two.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Patch {
    columns: usize,
    vertices: Vec<u32>,
}

impl Patch {
    /// A patch of vertices, row after row; none of less than two rows or columns, or with a row that is not whole.
    pub fn new(columns: usize, vertices: Vec<u32>) -> Option<Self> {
        let is_grid = columns >= 2 && vertices.len() >= 2 * columns && vertices.len().is_multiple_of(columns);
        is_grid.then_some(Self { columns, vertices })
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.vertices.len() / self.columns
    }

    /// Number of columns.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// The vertex in a row and a column.
    pub fn at(&self, row: usize, column: usize) -> u32 {
        self.vertices[row * self.columns + column]
    }

    /// The patch over other numbers of the vertices; none if one has no other number.
    pub fn renumbered(&self, number: impl Fn(u32) -> Option<u32>) -> Option<Self> {
        let vertices = self.vertices.iter().map(|&v| number(v)).collect::<Option<_>>()?;
        Some(Self { columns: self.columns, vertices })
    }

    /// The patch with rows for columns: its normal points the other way.
    #[must_use]
    pub fn turned_over(&self) -> Self {
        Self { columns: self.rows(), vertices: self.lines(0).concat() }
    }

    /// The part from the first to the last of these rows and columns; none if these are not two or not in the patch.
    pub fn part(&self, rows: [usize; 2], columns: [usize; 2]) -> Option<Self> {
        let is_within =
            rows[0] < rows[1] && rows[1] < self.rows() && columns[0] < columns[1] && columns[1] < self.columns;
        let row = |i: usize| (columns[0]..=columns[1]).map(move |j| self.at(i, j));
        is_within.then(|| Self {
            columns: columns[1] - columns[0] + 1,
            vertices: (rows[0]..=rows[1]).flat_map(row).collect(),
        })
    }

    /// The vertices line by line: from row to row in each column (0), or from column to column in each row (1).
    pub fn lines(&self, direction: usize) -> Vec<Vec<u32>> {
        if direction == 0 {
            (0..self.columns).map(|j| (0..self.rows()).map(|i| self.at(i, j)).collect()).collect()
        } else {
            self.vertices.chunks(self.columns).map(<[u32]>::to_vec).collect()
        }
    }

    /// The quads between neighbouring rows and columns, counter-clockwise seen from outside.
    pub fn quads(&self) -> impl Iterator<Item = [u32; 4]> {
        let in_row = move |i: usize| {
            (0..self.columns - 1)
                .map(move |j| [self.at(i, j), self.at(i + 1, j), self.at(i + 1, j + 1), self.at(i, j + 1)])
        };
        (0..self.rows() - 1).flat_map(in_row)
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
        let patch = Patch::new(3, vec![0, 1, 2, 3, 4, 5]).unwrap();
        assert_eq!(patch.sides(), [vec![0, 3], vec![3, 4, 5], vec![5, 2], vec![2, 1, 0]]);
        let over = patch.turned_over();
        assert_eq!(over.sides(), [vec![0, 1, 2], vec![2, 5], vec![5, 4, 3], vec![3, 0]]);
        assert_eq!((over.rows(), over.turned_over()), (3, patch.clone()));
        assert_eq!(patch.quads().collect::<Vec<_>>(), [[0, 3, 4, 1], [1, 4, 5, 2]]);
        assert_eq!(patch.part([0, 1], [1, 2]).unwrap().sides()[1], [4, 5]);
    }

    #[test]
    fn what_is_no_grid_of_two_by_two_at_least_is_no_patch() {
        let none = [(0, 0), (0, 4), (1, 4), (3, 3), (3, 5), (2, 3), (9, 4)];
        assert!(none.iter().all(|&(columns, count)| Patch::new(columns, vec![0; count]).is_none()));
        let patch = Patch::new(2, vec![0, 1, 2, 3]).unwrap();
        assert!(patch.part([0, 0], [0, 1]).is_none() && patch.part([0, 2], [0, 1]).is_none());
        assert!(patch.renumbered(|v| (v < 3).then_some(v)).is_none());
    }
}
