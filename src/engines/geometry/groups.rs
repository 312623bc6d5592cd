//! Connected groups of many things, told pair by pair.

use super::mesh::Mesh;

/// Numbered things in groups, at first each in its own.
#[derive(Debug, Clone)]
pub struct Groups {
    /// For each thing an earlier one of its group, or itself.
    earlier: Vec<u32>,
}

impl Groups {
    /// `count` groups of one item each; `count` always fits.
    pub fn of(count: usize) -> Self {
        Self { earlier: (0..count as u32).collect() }
    }

    /// The vertices of a mesh: those of one triangle are in one group.
    pub fn of_vertices(mesh: &Mesh) -> Self {
        let mut groups = Self::of(mesh.vertices.len());
        for [a, b, c] in mesh.triangles.iter().map(|t| t.map(|v| v as usize)) {
            groups.join(a, b);
            groups.join(a, c);
        }
        groups
    }

    /// Makes the groups of two things one.
    pub fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.first(a), self.first(b));
        self.earlier[a.max(b)] = a.min(b) as u32;
    }

    /// The first thing of the group of `i`.
    pub fn first(&mut self, mut i: usize) -> usize {
        while self.earlier[i] as usize != i {
            self.earlier[i] = self.earlier[self.earlier[i] as usize];
            i = self.earlier[i] as usize;
        }
        i
    }

    /// The number of each thing's group, counted in the order of their first things, and how many groups there are.
    pub fn numbers(mut self) -> (Vec<u32>, usize) {
        let mut numbers = vec![0; self.earlier.len()];
        let mut count = 0;
        for i in 0..numbers.len() {
            let first = self.first(i);
            numbers[i] = if first == i { count } else { numbers[first] };
            count += u32::from(first == i);
        }
        (numbers, count as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_joined_directly_or_not_is_one_group() {
        let mut groups = Groups::of(7);
        for [a, b] in [[5, 2], [3, 6], [2, 3], [4, 4]] {
            groups.join(a, b);
        }
        assert_eq!((groups.first(6), groups.first(4), groups.first(0)), (2, 4, 0));
        assert_eq!(groups.numbers(), (vec![0, 1, 2, 2, 3, 2, 2], 4));
        assert_eq!(Groups::of(0).numbers(), (Vec::new(), 0));
    }
}
