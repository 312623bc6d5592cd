//! B-splines as functions of one variable.

use super::NurbsError;
use super::fit::Interpolation;
use super::knots::KnotVector;

/// A function made of polynomial pieces that join with `degree - 1` continuous derivatives, through given points.
#[derive(Debug, Clone, PartialEq)]
pub struct BSpline {
    knots: KnotVector,
    coefficients: Vec<f64>,
    parameters: Vec<f64>,
}

impl BSpline {
    /// The function of `degree`, or of one less than the number of points if these are too few, with the value
    /// `values[i]` at `parameters[i]`.
    ///
    /// # Errors
    /// If the parameters do not rise or are too few.
    pub fn through(parameters: &[f64], values: &[f64], degree: usize) -> Result<Self, NurbsError> {
        if parameters.len() != values.len() {
            return Err(NurbsError::Counts);
        }
        let interpolation = Interpolation::new(parameters, degree, false)?;
        let solved = interpolation.matrix.solve(values.iter().map(|v| vec![*v]).collect())?;
        let coefficients = solved.into_iter().flatten().collect();
        Ok(Self { knots: interpolation.knots, coefficients, parameters: parameters.to_vec() })
    }

    /// The parameters of the points it was made from.
    pub fn parameters(&self) -> &[f64] {
        &self.parameters
    }

    /// Value, first and second derivative at `t`; beyond the ends the end pieces continue.
    pub fn at(&self, t: f64) -> [f64; 3] {
        let basis = self.knots.basis(t);
        let coefficients = &self.coefficients[basis.first..=basis.first + self.knots.degree()];
        basis.orders.map(|order| order.iter().zip(coefficients).map(|(n, c)| n * c).sum())
    }

    /// A bound on the size of the second derivative between points `i` and `i + 1`: the second derivative is a B-spline
    /// itself and lies between its coefficients.
    pub fn greatest_second(&self, i: usize) -> f64 {
        let (p, knots) = (self.knots.degree(), self.knots.knots());
        if p < 2 {
            return 0.0;
        }
        let (from, to) = (self.parameters[i], self.parameters[i + 1]);
        let slope = |j: usize| {
            let width = knots[j + p + 1] - knots[j + 1];
            p as f64 * (self.coefficients[j + 1] - self.coefficients[j]) / width
        };
        // Coefficient j of the second derivative has a say from knot j + 2 to knot j + p + 1.
        (0..self.coefficients.len() - 2)
            .filter(|&j| knots[j + 2] < to && knots[j + p + 1] > from)
            .map(|j| ((p - 1) as f64 * (slope(j + 1) - slope(j)) / (knots[j + p + 1] - knots[j + 2])).abs())
            .fold(0.0, f64::max)
    }
}
