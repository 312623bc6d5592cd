//! Symmetric linear systems whose rows have entries near the diagonal only.

use glam::DVec3;

/// A symmetric positive definite matrix with entries at most `reach` columns from the diagonal.
#[derive(Debug, Clone)]
pub(super) struct Band {
    size: usize,
    reach: usize,
    /// Row by row the entries up to the diagonal.
    entries: Vec<f64>,
}

/// The factors of a [`Band`] by the method of Cholesky.
#[derive(Debug, Clone)]
pub(super) struct Factor(Band);

impl Band {
    /// A matrix of zeros.
    pub(super) fn new(size: usize, reach: usize) -> Self {
        let reach = reach.min(size.saturating_sub(1));
        Self { size, reach, entries: vec![0.0; size * (reach + 1)] }
    }

    fn at(&self, row: usize, column: usize) -> usize {
        row * (self.reach + 1) + column + self.reach - row
    }

    /// Adds `weight` times the square of a linear form, given by its coefficients at their places; places farther
    /// apart than the reach are not kept.
    pub(super) fn add_square(&mut self, form: &[(usize, f64)], weight: f64) {
        for &(i, a) in form {
            for &(j, b) in form.iter().filter(|(j, _)| *j <= i && i - *j <= self.reach) {
                let at = self.at(i, j);
                self.entries[at] += weight * a * b;
            }
        }
    }

    /// Adds to the diagonal what keeps the matrix regular where nothing else is known.
    pub(super) fn add_to_diagonal(&mut self, value: f64) {
        for i in 0..self.size {
            let at = self.at(i, i);
            self.entries[at] += value;
        }
    }

    /// The factors; none where the matrix is not positive definite.
    pub(super) fn factored(mut self) -> Option<Factor> {
        for i in 0..self.size {
            let first = i.saturating_sub(self.reach);
            for j in first..=i {
                let from = first.max(j.saturating_sub(self.reach));
                let (row, other) = (self.at(i, from), self.at(j, from));
                let pairs = self.entries[row..row + j - from].iter().zip(&self.entries[other..other + j - from]);
                let value = self.entries[self.at(i, j)] - pairs.map(|(a, b)| a * b).sum::<f64>();
                let at = self.at(i, j);
                if i == j {
                    if value.is_nan() || value <= 0.0 {
                        return None;
                    }
                    self.entries[at] = value.sqrt();
                } else {
                    self.entries[at] = value / self.entries[self.at(j, j)];
                }
            }
        }
        Some(Factor(self))
    }
}

impl Factor {
    /// Puts the solution in the place of the right side.
    pub(super) fn solve(&self, right: &mut [DVec3]) {
        let Self(band) = self;
        let n = band.size.min(right.len());
        for i in 0..n {
            for j in i.saturating_sub(band.reach)..i {
                let known = right[j] * band.entries[band.at(i, j)];
                right[i] -= known;
            }
            right[i] /= band.entries[band.at(i, i)];
        }
        for i in (0..n).rev() {
            right[i] /= band.entries[band.at(i, i)];
            let known = right[i];
            let first = i.saturating_sub(band.reach);
            let row = &band.entries[band.at(i, first)..];
            right[first..i].iter_mut().zip(row).for_each(|(r, entry)| *r -= known * *entry);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_solution_meets_every_equation() {
        let forms: Vec<Vec<(usize, f64)>> =
            (0..7).map(|i| vec![(i, 1.0 + i as f64), (i + 1, -0.5), (i + 2, 0.25)]).collect();
        let mut matrix = Band::new(9, 2);
        matrix.add_to_diagonal(0.1);
        forms.iter().for_each(|form| matrix.add_square(form, 2.0));
        let right: Vec<DVec3> = (0..9).map(|i| DVec3::new(f64::from(i), f64::from(1 - i * i), 1.0)).collect();
        let mut x = right.clone();
        matrix.factored().unwrap().solve(&mut x);
        // The gradient of the sum of squares, computed form by form.
        let mut left: Vec<DVec3> = x.iter().map(|v| *v * 0.1).collect();
        for form in &forms {
            let value: DVec3 = form.iter().map(|&(i, a)| x[i] * a).sum();
            form.iter().for_each(|&(i, a)| left[i] += value * (2.0 * a));
        }
        assert!(left.iter().zip(&right).all(|(l, r)| l.distance(*r) < 1e-10));
        assert!(Band::new(2, 1).factored().is_none());
    }
}
