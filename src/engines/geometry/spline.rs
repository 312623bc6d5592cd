//! Interpolating cubic splines of one variable.

use serde::{Deserialize, Serialize};

/// End condition of a cubic spline.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum EndCondition {
    /// The third derivative is continuous across the first and the last inner knot (Matlab's `spline`).
    #[default]
    NotAKnot,
    /// The second derivative is zero at both ends.
    Natural,
}

/// A twice continuously differentiable piecewise cubic through given points.
#[derive(Debug, Clone, PartialEq)]
pub struct CubicSpline {
    knots: Vec<f64>,
    values: Vec<f64>,
    /// Second derivatives at the knots.
    seconds: Vec<f64>,
}

/// Reason why points cannot be interpolated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum SplineError {
    /// Too few points or unequal numbers of knots and values.
    #[error("a spline needs at least 2 points and as many values as knots")]
    TooFew,
    /// Knots that do not rise.
    #[error("spline knots must rise; knot {0} does not")]
    NotRising(usize),
}

impl CubicSpline {
    /// The spline through `(knots[i], values[i])`. With 2 points it is a straight line, with 3 points and
    /// not-a-knot ends the parabola through them.
    pub fn new(knots: &[f64], values: &[f64], ends: EndCondition) -> Result<Self, SplineError> {
        if knots.len() < 2 || knots.len() != values.len() {
            return Err(SplineError::TooFew);
        }
        if let Some(i) =
            (1..knots.len()).find(|&i| knots[i].is_nan() || knots[i - 1].is_nan() || knots[i] <= knots[i - 1])
        {
            return Err(SplineError::NotRising(i));
        }
        let seconds = second_derivatives(knots, values, ends);
        Ok(Self { knots: knots.to_vec(), values: values.to_vec(), seconds })
    }

    /// Parameters at which the polynomial pieces join.
    pub fn knots(&self) -> &[f64] {
        &self.knots
    }

    /// Value, first and second derivative at `t`; beyond the ends the end pieces continue.
    pub fn at(&self, t: f64) -> [f64; 3] {
        let i = self.piece(t);
        let h = self.knots[i + 1] - self.knots[i];
        let (a, b) = ((self.knots[i + 1] - t) / h, (t - self.knots[i]) / h);
        let (y0, y1, m0, m1) = (self.values[i], self.values[i + 1], self.seconds[i], self.seconds[i + 1]);
        [
            a * y0 + b * y1 + ((a * a * a - a) * m0 + (b * b * b - b) * m1) * h * h / 6.0,
            (y1 - y0) / h + ((3.0 * b * b - 1.0) * m1 - (3.0 * a * a - 1.0) * m0) * h / 6.0,
            a * m0 + b * m1,
        ]
    }

    /// The greatest size of the second derivative over piece `i`, between knots `i` and `i + 1`: it is linear
    /// there, so the greater of its ends.
    pub fn greatest_second(&self, i: usize) -> f64 {
        self.seconds[i].abs().max(self.seconds[i + 1].abs())
    }

    fn piece(&self, t: f64) -> usize {
        self.knots.partition_point(|&k| k <= t).clamp(1, self.knots.len() - 1) - 1
    }
}

/// Solves the tridiagonal system for the second derivatives at the knots.
fn second_derivatives(t: &[f64], y: &[f64], ends: EndCondition) -> Vec<f64> {
    let n = t.len();
    let h: Vec<f64> = t.windows(2).map(|w| w[1] - w[0]).collect();
    let slope: Vec<f64> = (0..n - 1).map(|i| (y[i + 1] - y[i]) / h[i]).collect();
    if n == 2 {
        return vec![0.0; 2];
    }
    if n == 3 && ends == EndCondition::NotAKnot {
        return vec![2.0 * (slope[1] - slope[0]) / (h[0] + h[1]); 3];
    }
    // Rows for the inner knots: lower * m[i-1] + diagonal * m[i] + upper * m[i+1] = right.
    let mut rows: Vec<[f64; 4]> =
        (1..n - 1).map(|i| [h[i - 1], 2.0 * (h[i - 1] + h[i]), h[i], 6.0 * (slope[i] - slope[i - 1])]).collect();
    let last = rows.len() - 1;
    if ends == EndCondition::NotAKnot {
        // m[0] = m[1] - (m[2] - m[1]) h0/h1 follows from equal third derivatives; likewise at the other end.
        let (p, q) = (h[0] / h[1], h[n - 2] / h[n - 3]);
        rows[0][1] += rows[0][0] * (1.0 + p);
        rows[0][2] -= rows[0][0] * p;
        rows[last][1] += rows[last][2] * (1.0 + q);
        rows[last][0] -= rows[last][2] * q;
    }
    for i in 1..=last {
        let factor = rows[i][0] / rows[i - 1][1];
        rows[i][1] -= factor * rows[i - 1][2];
        rows[i][3] -= factor * rows[i - 1][3];
    }
    let mut m = vec![0.0; n];
    for i in (0..=last).rev() {
        let beyond = if i == last { 0.0 } else { rows[i][2] * m[i + 2] };
        m[i + 1] = (rows[i][3] - beyond) / rows[i][1];
    }
    if ends == EndCondition::NotAKnot {
        m[0] = m[1] - (m[2] - m[1]) * h[0] / h[1];
        m[n - 1] = m[n - 2] + (m[n - 2] - m[n - 3]) * h[n - 2] / h[n - 3];
    }
    m
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn spline(t: &[f64], y: &[f64], ends: EndCondition) -> CubicSpline {
        CubicSpline::new(t, y, ends).unwrap()
    }

    #[test]
    fn not_a_knot_reproduces_any_cubic() {
        let cubic = |t: f64| 2.0 - t + 0.5 * t * t - 0.3 * t * t * t;
        let t = [0.0, 0.7, 1.0, 2.5, 3.0];
        let s = spline(&t, &t.map(cubic), EndCondition::NotAKnot);
        for i in 0..=30 {
            let x = f64::from(i) * 0.1;
            let [v, d, dd] = s.at(x);
            assert!((v - cubic(x)).abs() < 1e-12);
            assert!((d - (-1.0 + x - 0.9 * x * x)).abs() < 1e-11);
            assert!((dd - (1.0 - 1.8 * x)).abs() < 1e-11);
        }
    }

    /// Values of scipy.interpolate.CubicSpline(t, y, bc_type) at 0.5, 2.0 and 6.5.
    #[test]
    fn both_end_conditions_agree_with_an_independent_program() {
        let (t, y) = ([0.0, 1.0, 2.5, 4.0, 7.0], [1.0, -2.0, 0.5, 3.0, -1.0]);
        for (ends, expected) in [(EndCondition::NotAKnot, NOT_A_KNOT), (EndCondition::Natural, NATURAL)] {
            let s = spline(&t, &y, ends);
            for (x, e) in [0.5, 2.0, 6.5].into_iter().zip(expected) {
                assert!((s.at(x)[0] - e).abs() < 1e-12, "{ends:?} at {x}: {} instead of {e}", s.at(x)[0]);
            }
        }
    }

    const NOT_A_KNOT: [f64; 3] = [-1.2484848484848485, -0.7030303030303032, 0.7323232323232327];
    const NATURAL: [f64; 3] = [-0.8691037735849056, -0.8480083857442344, 0.11150419287211832];

    #[test]
    fn few_points_give_a_line_and_a_parabola() {
        assert_eq!(spline(&[0.0, 2.0], &[1.0, 5.0], EndCondition::NotAKnot).at(1.5), [4.0, 2.0, 0.0]);
        let s = spline(&[0.0, 1.0, 3.0], &[0.0, 1.0, 9.0], EndCondition::NotAKnot);
        assert!((s.at(2.0)[0] - 4.0).abs() < 1e-14 && (s.at(2.0)[2] - 2.0).abs() < 1e-14);
    }

    #[test]
    fn bad_points_are_refused() {
        assert_eq!(CubicSpline::new(&[0.0], &[1.0], EndCondition::Natural), Err(SplineError::TooFew));
        let falling = CubicSpline::new(&[0.0, 1.0, 1.0], &[0.0; 3], EndCondition::Natural);
        assert_eq!(falling, Err(SplineError::NotRising(2)));
        assert!(CubicSpline::new(&[0.0, f64::NAN], &[0.0; 2], EndCondition::Natural).is_err());
    }

    proptest! {
        #[test]
        fn a_spline_meets_its_points_and_bends_continuously(
            steps in prop::collection::vec(0.1..3.0f64, 3..20),
            seed in prop::collection::vec(-5.0..5.0f64, 20),
        ) {
            let t: Vec<f64> = steps.iter().scan(0.0, |s, h| { *s += h; Some(*s) }).collect();
            let s = spline(&t, &seed[..t.len()], EndCondition::NotAKnot);
            for (i, &k) in t.iter().enumerate() {
                prop_assert!((s.at(k)[0] - seed[i]).abs() < 1e-9);
            }
            for &k in &t[1..t.len() - 1] {
                let (left, right) = (s.at(k - 1e-9), s.at(k));
                prop_assert!((left[1] - right[1]).abs() < 1e-4 && (left[2] - right[2]).abs() < 1e-4);
            }
        }
    }
}
