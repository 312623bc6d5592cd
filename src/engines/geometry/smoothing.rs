//! Smoothing of values along a line: the values of least bending near given ones.

/// Smooths values at given places; the first value stays as it is.
///
/// For values `f_k` at `s_k` it finds the `q_k` that minimise `sum (q_k - f_k)^2 + l^4 sum b_k^2`, where `b_k` is twice
/// the second divided difference of `q` at `s_k` and `l` the smoothing length: waves shorter than `2 pi l` are damped.
/// The normal equations are symmetric with two bands beside the diagonal; they are factored once as `L D L^T`.
#[derive(Debug, Clone)]
pub struct Smoother {
    diagonal: Vec<f64>,
    /// `L` one and two places left of the diagonal.
    first: Vec<f64>,
    second: Vec<f64>,
    /// Contribution of the fixed first value to the right-hand sides of the first unknowns.
    fixed: [f64; 2],
}

impl Smoother {
    /// For places `s`, which must rise, and a smoothing length. None if there are fewer than three places, they do not
    /// rise, or the length is no positive number.
    pub fn new(s: &[f64], length: f64) -> Option<Self> {
        let rising = s.windows(2).all(|w| w[1] > w[0]) && s.iter().all(|v| v.is_finite());
        if s.len() < 3 || !rising || !(length > 0.0 && length.is_finite()) {
            return None;
        }
        let n = s.len();
        let weight = length.powi(4);
        let (mut main, mut one, mut two) = (vec![1.0; n], vec![0.0; n], vec![0.0; n]);
        for k in 1..n - 1 {
            let (h0, h1) = (s[k] - s[k - 1], s[k + 1] - s[k]);
            let row = [2.0 / (h0 * (h0 + h1)), -2.0 / (h0 * h1), 2.0 / (h1 * (h0 + h1))];
            for i in 0..3 {
                main[k - 1 + i] += weight * row[i] * row[i];
            }
            one[k] += weight * row[0] * row[1];
            one[k + 1] += weight * row[1] * row[2];
            two[k + 1] += weight * row[0] * row[2];
        }
        let fixed = [one[1], two[2]];
        // The unknowns are the values but the first.
        let (mut diagonal, mut first, mut second) = (vec![0.0; n - 1], vec![0.0; n - 1], vec![0.0; n - 1]);
        for i in 0..n - 1 {
            let k = i + 1;
            if i >= 2 {
                second[i] = two[k] / diagonal[i - 2];
            }
            if i >= 1 {
                let carried = if i >= 2 { second[i] * diagonal[i - 2] * first[i - 1] } else { 0.0 };
                first[i] = (one[k] - carried) / diagonal[i - 1];
            }
            let mut d = main[k];
            if i >= 1 {
                d -= first[i] * first[i] * diagonal[i - 1];
            }
            if i >= 2 {
                d -= second[i] * second[i] * diagonal[i - 2];
            }
            diagonal[i] = d;
        }
        Some(Self { diagonal, first, second, fixed })
    }

    /// The smooth values near `values`, one for each place.
    ///
    /// # Panics
    /// If there are not as many values as places.
    pub fn smooth(&self, values: &[f64]) -> Vec<f64> {
        assert_eq!(values.len(), self.diagonal.len() + 1, "one value for each place");
        let fixed = values[0];
        let mut q = values[1..].to_vec();
        q[0] -= self.fixed[0] * fixed;
        q[1] -= self.fixed[1] * fixed;
        let n = q.len();
        for i in 1..n {
            q[i] -= self.first[i] * q[i - 1];
            if i >= 2 {
                q[i] -= self.second[i] * q[i - 2];
            }
        }
        for (value, d) in q.iter_mut().zip(&self.diagonal) {
            *value /= d;
        }
        for i in (0..n).rev() {
            if i + 1 < n {
                q[i] -= self.first[i + 1] * q[i + 1];
            }
            if i + 2 < n {
                q[i] -= self.second[i + 2] * q[i + 2];
            }
        }
        q.insert(0, fixed);
        q
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Cost to be minimised.
    fn cost(s: &[f64], length: f64, f: &[f64], q: &[f64]) -> f64 {
        let near: f64 = f.iter().zip(q).map(|(f, q)| (f - q).powi(2)).sum();
        let slope = |i: usize| (q[i + 1] - q[i]) / (s[i + 1] - s[i]);
        let bend = |k: usize| 2.0 * (slope(k) - slope(k - 1)) / (s[k + 1] - s[k - 1]);
        near + length.powi(4) * (1..s.len() - 1).map(|k| bend(k).powi(2)).sum::<f64>()
    }

    proptest! {
        /// No small change of any value but the first makes it better: the minimum of a convex function.
        #[test]
        fn nothing_near_is_better(
            steps in prop::collection::vec(0.2f64..2.0, 3..30),
            length in 0.3f64..4.0,
            seed in prop::collection::vec(-1.0f64..1.0, 31),
        ) {
            let s: Vec<f64> = steps.iter().scan(0.0, |at, h| { *at += h; Some(*at) }).collect();
            let f = &seed[..s.len()];
            let q = Smoother::new(&s, length).unwrap().smooth(f);
            prop_assert_eq!(q[0], f[0]);
            let least = cost(&s, length, f, &q);
            for k in 1..s.len() {
                for by in [1e-4, -1e-4] {
                    let mut other = q.clone();
                    other[k] += by;
                    prop_assert!(cost(&s, length, f, &other) > least, "{} {}", k, by);
                }
            }
        }
    }

    #[test]
    fn straight_lines_stay() {
        let s = [0.0, 0.5, 1.5, 1.75, 4.0];
        let line = s.map(|s| 3.0 - 2.0 * s);
        let smooth = Smoother::new(&s, 5.0).unwrap().smooth(&line);
        assert!(smooth.iter().zip(line).all(|(q, f)| (q - f).abs() < 1e-9), "{smooth:?}");
    }

    #[test]
    fn places_that_do_not_rise_are_refused() {
        assert!(Smoother::new(&[0.0, 1.0, 1.0], 1.0).is_none());
        assert!(Smoother::new(&[0.0, 1.0], 1.0).is_none());
        assert!(Smoother::new(&[0.0, 1.0, 2.0], f64::NAN).is_none());
    }
}
