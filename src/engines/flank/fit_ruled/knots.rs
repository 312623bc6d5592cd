//! The knots of both guides while they are being fitted: clamped ones, or those of a ring that goes on from its end.

/// Cubic B-splines from 0 to 1.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Knots {
    /// Parameters at which pieces meet, from 0 to 1.
    pub breaks: Vec<f64>,
    /// Whether the end is the start; otherwise the end pieces go on beyond.
    pub is_closed: bool,
}

/// The four basis functions at a parameter, with their first and second derivatives.
#[derive(Debug, Clone, Copy)]
pub(super) struct Basis {
    /// Numbers.
    pub numbers: [usize; 4],
    /// Values, first and second derivatives.
    pub orders: [[f64; 4]; 3],
}

impl Knots {
    /// Pieces of equal length, as many as `count` clamped control points make.
    pub(super) fn even(count: usize, is_closed: bool) -> Self {
        let pieces = count - 3;
        Self { breaks: (0..=pieces).map(|i| i as f64 / pieces as f64).collect(), is_closed }
    }

    pub(super) fn pieces(&self) -> usize {
        self.breaks.len() - 1
    }

    /// Number of control points.
    pub(super) fn count(&self) -> usize {
        self.pieces() + if self.is_closed { 0 } else { 3 }
    }

    /// The break with this number, beyond the ends too.
    fn at(&self, i: isize) -> f64 {
        let pieces = self.pieces() as isize;
        if self.is_closed {
            self.breaks[i.rem_euclid(pieces) as usize] + i.div_euclid(pieces) as f64
        } else {
            self.breaks[i.clamp(0, pieces) as usize]
        }
    }

    /// The parameter where control point `i` counts most; any number of a closed guide.
    pub(super) fn place(&self, i: isize) -> f64 {
        (self.at(i - 2) + self.at(i - 1) + self.at(i)) / 3.0
    }

    /// A parameter from 0 to 1 of a closed guide; of others as it is.
    pub(super) fn wrapped(&self, u: f64) -> f64 {
        if self.is_closed { u - u.floor() } else { u }
    }

    /// Number of the piece that has the parameter `u`.
    pub(super) fn piece(&self, u: f64) -> usize {
        let u = self.wrapped(u);
        self.breaks.partition_point(|b| *b <= u).clamp(1, self.pieces()) - 1
    }

    /// The basis functions at `u`.
    pub(super) fn basis(&self, u: f64) -> Basis {
        let u = self.wrapped(u);
        let span = self.piece(u);
        // The knots around the span: three before it, itself, three behind.
        let k: [f64; 6] = std::array::from_fn(|i| self.at(span as isize + i as isize - 2));
        let mut rows = [[0.0; 4]; 4];
        rows[0][0] = 1.0;
        for d in 1..=3 {
            let mut carried = 0.0;
            for r in 0..d {
                let (left, right) = (k[3 + r - d], k[3 + r]);
                let share = rows[d - 1][r] / (right - left);
                rows[d][r] = carried + (right - u) * share;
                carried = (u - left) * share;
            }
            rows[d][d] = carried;
        }
        let slope = |lower: &[f64; 4], d: usize| -> [f64; 4] {
            std::array::from_fn(|r| {
                let rise = if r > 0 && r <= d { lower[r - 1] / (k[r + 2] - k[r + 2 - d]) } else { 0.0 };
                let fall = if r < d { lower[r] / (k[r + 3] - k[r + 3 - d]) } else { 0.0 };
                d as f64 * (rise - fall)
            })
        };
        let first = slope(&rows[2], 3);
        let second = slope(&slope(&rows[1], 2), 3);
        Basis { numbers: [0, 1, 2, 3].map(|r| (span + r) % self.count()), orders: [rows[3], first, second] }
    }

    /// Neighbouring control points, three at a time: all around of a closed guide.
    pub(super) fn triples(&self) -> impl Iterator<Item = [usize; 3]> {
        let (n, is_closed) = (self.count(), self.is_closed);
        let middles = if is_closed { 0..n } else { 1..n - 1 };
        middles.map(move |i| [(i + n - 1) % n, i, (i + 1) % n])
    }

    /// Eight places in every piece, and the end.
    pub(super) fn dense(&self) -> Vec<f64> {
        let pieces = self.breaks.windows(2);
        let within = pieces.flat_map(|w| (0..8).map(move |i| w[0] + (w[1] - w[0]) * f64::from(i) / 8.0));
        within.chain([1.0]).collect()
    }
}
