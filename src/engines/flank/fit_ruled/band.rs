//! Symmetric equations in which each unknown meets near ones only.

/// The lower half of a symmetric matrix that is zero farther than its width from its diagonal.
#[derive(Debug, Clone)]
pub(super) struct Band {
    width: usize,
    /// Row by row, each from the diagonal to the left.
    values: Vec<f64>,
}

impl Band {
    /// Zeros; each row has `width` elements, its diagonal among them.
    pub(super) fn new(size: usize, width: usize) -> Self {
        Self { width, values: vec![0.0; size * width] }
    }

    fn size(&self) -> usize {
        self.values.len() / self.width
    }

    fn row(&self, i: usize) -> &[f64] {
        &self.values[i * self.width..(i + 1) * self.width]
    }

    /// Adds to the element in row `i` and column `j`; nothing above the diagonal or outside of the band.
    pub(super) fn add(&mut self, i: usize, j: usize, value: f64) {
        if let Some(k) = i.checked_sub(j).filter(|k| *k < self.width) {
            self.values[i * self.width + k] += value;
        }
    }

    /// The element of the diagonal in row `i`.
    pub(super) fn diagonal(&self, i: usize) -> f64 {
        self.values[i * self.width]
    }

    /// The mean of the diagonal.
    pub(super) fn mean(&self) -> f64 {
        self.values.iter().step_by(self.width).sum::<f64>() / self.size().max(1) as f64
    }

    /// The solution for `right` by Cholesky's factors; none unless the matrix is positive definite.
    pub(super) fn solve(mut self, right: &[f64]) -> Option<Vec<f64>> {
        let (size, width) = (self.size(), self.width);
        for i in 0..size {
            for k in (0..width.min(i + 1)).rev() {
                let j = i - k;
                let shared = (width - k).min(j + 1);
                let products = self.row(i)[k..].iter().zip(self.row(j)).take(shared).skip(1);
                let sum: f64 = products.map(|(a, b)| a * b).sum();
                let rest = self.row(i)[k] - sum;
                self.values[i * width + k] = if k > 0 { rest / self.diagonal(j) } else { rest };
            }
            let pivot = self.diagonal(i);
            if pivot.is_nan() || pivot <= 0.0 {
                return None;
            }
            self.values[i * width] = pivot.sqrt();
        }
        let mut x = right.to_vec();
        for i in 0..size {
            let sum: f64 = (1..width.min(i + 1)).map(|k| self.row(i)[k] * x[i - k]).sum();
            x[i] = (x[i] - sum) / self.diagonal(i);
        }
        for i in (0..size).rev() {
            let sum: f64 = (1..width.min(size - i)).map(|k| self.row(i + k)[k] * x[i + k]).sum();
            x[i] = (x[i] - sum) / self.diagonal(i);
        }
        Some(x)
    }
}
