//! Linear systems whose rows have entries near the diagonal only.

use super::NurbsError;

/// A square matrix with entries at most `reach` columns from the diagonal.
#[derive(Debug, Clone)]
pub(super) struct Banded {
    reach: usize,
    rows: Vec<Vec<f64>>,
}

impl Banded {
    /// A matrix of zeros.
    pub fn new(size: usize, reach: usize) -> Self {
        Self { reach, rows: vec![vec![0.0; 2 * reach + 1]; size] }
    }

    /// Puts `value` in place.
    ///
    /// # Errors
    /// [`NurbsError::Singular`] if the place is outside the band and the value is not zero.
    pub fn set(&mut self, row: usize, column: usize, value: f64) -> Result<(), NurbsError> {
        match (column + self.reach).checked_sub(row).and_then(|at| self.rows[row].get_mut(at)) {
            Some(place) => *place = value,
            None if value == 0.0 => {}
            None => return Err(NurbsError::Singular),
        }
        Ok(())
    }

    fn at(&self, row: usize, column: usize) -> f64 {
        self.rows[row][column + self.reach - row]
    }

    /// Solves for all columns of `right` at once, given by rows. Elimination without exchange of rows: matrices of
    /// B-spline interpolation are totally positive and need none.
    ///
    /// # Errors
    /// [`NurbsError::Singular`].
    pub fn solve(mut self, mut right: Vec<Vec<f64>>) -> Result<Vec<Vec<f64>>, NurbsError> {
        let n = self.rows.len();
        for pivot in 0..n {
            let size = self.at(pivot, pivot);
            if size.is_nan() || size.abs() < 1e-12 {
                return Err(NurbsError::Singular);
            }
            let last = (pivot + self.reach).min(n - 1);
            for row in pivot + 1..=last {
                let factor = self.at(row, pivot) / size;
                if factor == 0.0 {
                    continue;
                }
                for column in pivot..=last {
                    let value = factor * self.at(pivot, column);
                    let place = column + self.reach - row;
                    self.rows[row][place] -= value;
                }
                let (above, below) = right.split_at_mut(row);
                below[0].iter_mut().zip(&above[pivot]).for_each(|(b, a)| *b -= factor * a);
            }
        }
        for row in (0..n).rev() {
            let last = (row + self.reach).min(n - 1);
            let (solving, known) = right.split_at_mut(row + 1);
            for column in row + 1..=last {
                let factor = self.at(row, column);
                solving[row].iter_mut().zip(&known[column - row - 1]).for_each(|(v, k)| *v -= factor * k);
            }
            let size = self.at(row, row);
            solving[row].iter_mut().for_each(|v| *v /= size);
        }
        Ok(right)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_solution_meets_every_equation() {
        let (n, reach) = (9usize, 2usize);
        let entry = |r: usize, c: usize| if r == c { 7.0 } else { ((r * 5 + c * 3) % 7) as f64 - 3.0 };
        let mut matrix = Banded::new(n, reach);
        for r in 0..n {
            for c in r.saturating_sub(reach)..(r + reach + 1).min(n) {
                matrix.set(r, c, entry(r, c)).unwrap();
            }
        }
        let right: Vec<Vec<f64>> = (0..n).map(|r| vec![r as f64, (r * r) as f64 - 4.0]).collect();
        let x = matrix.clone().solve(right.clone()).unwrap();
        for (r, wanted) in right.iter().enumerate() {
            for (k, wanted) in wanted.iter().enumerate() {
                let sum: f64 = (r.saturating_sub(reach)..(r + reach + 1).min(n)).map(|c| entry(r, c) * x[c][k]).sum();
                assert!((sum - wanted).abs() < 1e-11, "{sum}");
            }
        }
        assert_eq!(matrix.set(0, 3, 1.0), Err(NurbsError::Singular));
        assert_eq!(Banded::new(2, 1).solve(vec![vec![1.0]; 2]), Err(NurbsError::Singular));
    }
}
