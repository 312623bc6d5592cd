//! Knot vectors and their basis functions.

use super::NurbsError;

/// The highest degree, which CAD programs do not exceed.
pub const MAX_DEGREE: usize = 15;

/// A non-falling sequence of parameters with both ends repeated `degree + 1` times.
#[derive(Debug, Clone, PartialEq)]
pub struct KnotVector {
    degree: usize,
    knots: Vec<f64>,
}

/// The basis functions that are not zero at a parameter.
#[derive(Debug, Clone, Copy)]
pub(super) struct Basis {
    /// Number of the first of them.
    pub first: usize,
    /// Values, first and second derivatives.
    pub orders: [[f64; MAX_DEGREE + 1]; 3],
}

impl KnotVector {
    /// The knot vector of `degree` with the given knots.
    ///
    /// # Errors
    /// If the knots fall, are too few, or an inner one is repeated more than `degree` times.
    pub fn new(degree: usize, knots: Vec<f64>) -> Result<Self, NurbsError> {
        if !(1..=MAX_DEGREE).contains(&degree) {
            return Err(NurbsError::Degree(degree));
        }
        if knots.len() < 2 * degree + 2 {
            return Err(NurbsError::Counts);
        }
        let rises = |i: &usize| knots[*i].is_finite() && knots[*i] >= knots[*i - 1];
        if let Some(i) = (1..knots.len()).find(|i| !rises(i)) {
            return Err(NurbsError::Knots(i));
        }
        let last = knots.len() - 1;
        let repeated = |i: &usize| knots[*i] == knots[*i + degree];
        if let Some(i) = (1..last - degree).find(repeated) {
            return Err(NurbsError::Knots(i + degree));
        }
        let clamped = knots[0] == knots[degree] && knots[last] == knots[last - degree];
        if clamped { Ok(Self { degree, knots }) } else { Err(NurbsError::Knots(0)) }
    }

    /// The knots whose inner ones are `inner`, between `start` and `end`.
    pub(super) fn clamped(degree: usize, start: f64, inner: Vec<f64>, end: f64) -> Result<Self, NurbsError> {
        let mut knots = vec![start; degree + 1];
        knots.extend(inner);
        knots.resize(knots.len() + degree + 1, end);
        Self::new(degree, knots)
    }

    /// Knots for the interpolation at `parameters`: each inner one the mean of `degree` neighbouring parameters, so
    /// that every piece has its share of points. With `tangents` there is room for a derivative at both ends.
    pub(super) fn averaged(degree: usize, parameters: &[f64], tangents: bool) -> Result<Self, NurbsError> {
        let n = parameters.len();
        let means = |from: usize, to: usize| -> Vec<f64> {
            (from..to).map(|j| parameters[j..j + degree].iter().sum::<f64>() / degree as f64).collect()
        };
        let inner = if tangents { means(0, n + 1 - degree) } else { means(1, n - degree) };
        Self::clamped(degree, parameters[0], inner, parameters[n - 1])
    }

    /// The knots of the same curve run the other way.
    pub(super) fn reversed(&self) -> Self {
        let [from, to] = self.domain();
        // Both ends come out exactly.
        let mirrored = |k: &f64| if *k == to { from } else { (from + to - k).clamp(from, to) };
        Self { degree: self.degree, knots: self.knots.iter().rev().map(mirrored).collect() }
    }

    /// Degree.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// All knots, the repeated ones too.
    pub fn knots(&self) -> &[f64] {
        &self.knots
    }

    /// Number of basis functions, and so of control points.
    pub fn count(&self) -> usize {
        self.knots.len() - self.degree - 1
    }

    /// First and last parameter.
    pub fn domain(&self) -> [f64; 2] {
        [self.knots[0], self.knots[self.knots.len() - 1]]
    }

    /// Parameters at which pieces join, ends included, each once.
    pub fn joints(&self) -> Vec<f64> {
        let mut joints = self.knots.clone();
        joints.dedup();
        joints
    }

    /// Number of the last knot of the piece that `u` lies on; beyond the ends that of the end pieces.
    fn span(&self, u: f64) -> usize {
        self.knots.partition_point(|&k| k <= u).clamp(self.degree + 1, self.count()) - 1
    }

    /// The basis functions at `u` by the recursion of Cox and de Boor.
    pub(super) fn basis(&self, u: f64) -> Basis {
        let (p, span) = (self.degree, self.span(u));
        let of_degree = |degree: usize| self.values(span, u, degree);
        let mut orders = [of_degree(p), [0.0; MAX_DEGREE + 1], [0.0; MAX_DEGREE + 1]];
        orders[1] = self.derivative(span, &of_degree(p - 1), p);
        if p >= 2 {
            let slope = self.derivative(span, &of_degree(p - 2), p - 1);
            orders[2] = self.derivative(span, &slope, p);
        }
        Basis { first: span - p, orders }
    }

    /// The first control point of the piece around `u`, and by how much the difference of each two neighbouring ones of
    /// that piece counts in the slope.
    pub(super) fn slope_steps(&self, u: f64) -> (usize, impl Iterator<Item = f64> + '_) {
        let first = self.span(u) - self.degree;
        let step = move |i: usize| self.degree as f64 / (self.knots[i + self.degree + 1] - self.knots[i + 1]);
        (first, (first..first + self.degree).map(step))
    }

    /// Values of the functions of `degree` that are not zero on the piece `span`.
    fn values(&self, span: usize, u: f64, degree: usize) -> [f64; MAX_DEGREE + 1] {
        let mut values = [0.0; MAX_DEGREE + 1];
        values[0] = 1.0;
        for d in 1..=degree {
            let mut carried = 0.0;
            for (r, value) in values.iter_mut().enumerate().take(d) {
                let (left, right) = (self.knots[span + 1 + r - d], self.knots[span + 1 + r]);
                let share = *value / (right - left);
                *value = carried + (right - u) * share;
                carried = (u - left) * share;
            }
            values[d] = carried;
        }
        values
    }

    /// From functions of one degree less (or their derivatives) to the derivatives of those of `degree`.
    fn derivative(&self, span: usize, lower: &[f64; MAX_DEGREE + 1], degree: usize) -> [f64; MAX_DEGREE + 1] {
        let mut slopes = [0.0; MAX_DEGREE + 1];
        for (r, slope) in slopes.iter_mut().enumerate().take(degree + 1) {
            let i = span - degree + r;
            let rise = if r > 0 { lower[r - 1] / (self.knots[i + degree] - self.knots[i]) } else { 0.0 };
            let fall = if r < degree { lower[r] / (self.knots[i + degree + 1] - self.knots[i + 1]) } else { 0.0 };
            *slope = degree as f64 * (rise - fall);
        }
        slopes
    }
}
