//! Symmetric equations in which each unknown meets near ones only.

/// Unknowns of one row of a band: four neighbouring control points of both guides, three coordinates each.
const WIDTH: usize = 24;

/// The lower half of a symmetric matrix that is zero farther than [`WIDTH`] from its diagonal.
#[derive(Debug, Clone)]
pub(super) struct Band {
    /// Row by row, each from the diagonal to the left.
    values: Vec<[f64; WIDTH]>,
}

impl Band {
    pub(super) fn new(size: usize) -> Self {
        Self { values: vec![[0.0; WIDTH]; size] }
    }

    /// Adds to the element in row `i` and column `j`; nothing above the diagonal or outside of the band.
    pub(super) fn add(&mut self, i: usize, j: usize, value: f64) {
        if let Some(element) = i.checked_sub(j).and_then(|k| self.values[i].get_mut(k)) {
            *element += value;
        }
    }

    /// The element of the diagonal in row `i`.
    pub(super) fn diagonal(&self, i: usize) -> f64 {
        self.values[i][0]
    }

    /// The mean of the diagonal.
    pub(super) fn mean(&self) -> f64 {
        self.values.iter().map(|row| row[0]).sum::<f64>() / self.values.len().max(1) as f64
    }

    /// The solution for `right` by Cholesky's factors; none unless the matrix is positive definite.
    pub(super) fn solve(mut self, right: &[f64]) -> Option<Vec<f64>> {
        let size = self.values.len();
        for i in 0..size {
            for k in (0..WIDTH.min(i + 1)).rev() {
                let j = i - k;
                let shared = (1..WIDTH - k).take_while(|l| *l <= j);
                let sum: f64 = shared.map(|l| self.values[i][k + l] * self.values[j][l]).sum();
                let rest = self.values[i][k] - sum;
                self.values[i][k] = if k > 0 { rest / self.values[j][0] } else { rest };
            }
            let pivot = self.values[i][0];
            if pivot.is_nan() || pivot <= 0.0 {
                return None;
            }
            self.values[i][0] = pivot.sqrt();
        }
        let mut x = right.to_vec();
        for i in 0..size {
            let sum: f64 = (1..WIDTH.min(i + 1)).map(|k| self.values[i][k] * x[i - k]).sum();
            x[i] = (x[i] - sum) / self.values[i][0];
        }
        for i in (0..size).rev() {
            let sum: f64 = (1..WIDTH.min(size - i)).map(|k| self.values[i + k][k] * x[i + k]).sum();
            x[i] = (x[i] - sum) / self.values[i][0];
        }
        Some(x)
    }
}
