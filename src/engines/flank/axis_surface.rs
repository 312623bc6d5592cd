//! The surface that the cutter's axis sweeps: ruled between two cubic B-splines, P4 (8) and (9). Around a closed
//! surface they are closed too: what is beyond their end is their beginning.

use glam::DVec3;
use nalgebra::{DMatrix, DVector};

use super::FlankError;
use super::offset::CutterLocation;

/// Uniform cubic B-splines over 0 to 1, as polynomials of each piece. Clamped ones go on past the ends with the end
/// pieces, closed ones start again.
#[derive(Debug, Clone, PartialEq)]
pub struct CubicBasis {
    is_closed: bool,
    /// For each piece the coefficients of its four functions, in powers of the share of the piece.
    pieces: Vec<[[f64; 4]; 4]>,
}

/// The four functions that are not zero at a parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BasisAt {
    /// Numbers.
    pub numbers: [usize; 4],
    /// Values.
    pub values: [f64; 4],
}

impl CubicBasis {
    /// The clamped basis of this many functions, 4 at least.
    pub fn new(count: usize) -> Self {
        Self::with(count.max(4) - 3, false)
    }

    /// The closed basis of this many functions, 4 at least.
    pub fn closed(count: usize) -> Self {
        Self::with(count.max(4), true)
    }

    fn with(pieces: usize, is_closed: bool) -> Self {
        let knot = |i: isize| if is_closed { i as f64 } else { i.clamp(0, pieces as isize) as f64 };
        let of = |piece: usize| {
            // Cox and de Boor with polynomials for values; knots count pieces, x is the share of the piece.
            let mut functions = [[0.0; 4]; 4];
            functions[0][0] = 1.0;
            for degree in 1..=3isize {
                let mut carried = [0.0; 4];
                for (r, function) in functions.iter_mut().enumerate().take(degree as usize) {
                    let left = knot((piece + 1 + r) as isize - degree);
                    let right = knot((piece + 1 + r) as isize);
                    let share = function.map(|c| c / (right - left));
                    let falling = times_line(&share, right - piece as f64, -1.0);
                    *function = std::array::from_fn(|k| carried[k] + falling[k]);
                    carried = times_line(&share, piece as f64 - left, 1.0);
                }
                functions[degree as usize] = carried;
            }
            functions
        };
        Self { is_closed, pieces: (0..pieces).map(of).collect() }
    }

    /// Number of functions.
    pub fn count(&self) -> usize {
        if self.is_closed { self.pieces.len() } else { self.pieces.len() + 3 }
    }

    /// The numbers of the functions that are not zero on a piece.
    fn numbers(&self, piece: usize) -> [usize; 4] {
        [0, 1, 2, 3].map(|r| (piece + r) % self.count())
    }

    /// The piece of `t` and the share of it.
    fn place(&self, t: f64) -> (usize, f64) {
        let t = if self.is_closed { t - t.floor() } else { t };
        let scaled = t * self.pieces.len() as f64;
        let piece = (scaled.max(0.0) as usize).min(self.pieces.len() - 1);
        (piece, scaled - piece as f64)
    }

    /// The functions at `t`.
    pub fn at(&self, t: f64) -> BasisAt {
        let (piece, x) = self.place(t);
        let values = self.pieces[piece].map(|c| c[0] + x * (c[1] + x * (c[2] + x * c[3])));
        BasisAt { numbers: self.numbers(piece), values }
    }
}

/// (constant + slope x) times a polynomial of degree 2 at most.
fn times_line(p: &[f64; 4], constant: f64, slope: f64) -> [f64; 4] {
    std::array::from_fn(|k| constant * p[k] + if k > 0 { slope * p[k - 1] } else { 0.0 })
}

/// A place of the axis at a moment: its ends and how they move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisAt {
    /// Centre of the bottom circle (mm), C_b.
    pub tip: DVec3,
    /// Derivative of the tip by t.
    pub tip_speed: DVec3,
    /// Upper end of the axis (mm), C_t.
    pub top: DVec3,
    /// Derivative of the upper end by t.
    pub top_speed: DVec3,
}

impl AxisAt {
    /// Unit vector of the axis.
    pub fn axis(&self) -> DVec3 {
        (self.top - self.tip).normalize_or_zero()
    }

    /// Distance between the ends (mm).
    pub fn length(&self) -> f64 {
        self.top.distance(self.tip)
    }
}

/// The axis trajectory surface D(t, a) = (1 - a) C_b(t) + a C_t(t), t from 0 to 1; any t where it is closed.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisSurface {
    basis: CubicBasis,
    lower: Vec<DVec3>,
    upper: Vec<DVec3>,
    /// Of each piece, both curves in powers of the share of the piece.
    pieces: Vec<[[DVec3; 4]; 2]>,
    /// u0 of the locations at t = 0 and t = 1.
    pub u0_range: [f64; 2],
}

impl AxisSurface {
    /// The surface with these control points of C_b and C_t, as many of both and 4 at least.
    ///
    /// # Errors
    /// [`FlankError::Singular`] if the points do not match or are no numbers.
    pub fn new(lower: Vec<DVec3>, upper: Vec<DVec3>, u0_range: [f64; 2]) -> Result<Self, FlankError> {
        let basis = CubicBasis::new(lower.len());
        Self::with(basis, [lower, upper], u0_range)
    }

    /// The closed surface with these control points of C_b and C_t, as many of both and 4 at least; u0 is its
    /// parameter.
    ///
    /// # Errors
    /// Every error of [`Self::new`].
    pub fn closed(lower: Vec<DVec3>, upper: Vec<DVec3>) -> Result<Self, FlankError> {
        let basis = CubicBasis::closed(lower.len());
        Self::with(basis, [lower, upper], [0.0, 1.0])
    }

    fn with(basis: CubicBasis, [lower, upper]: [Vec<DVec3>; 2], u0_range: [f64; 2]) -> Result<Self, FlankError> {
        let is_finite = lower.iter().chain(&upper).all(|p| p.is_finite());
        if lower.len() != upper.len() || lower.len() < 4 || !is_finite {
            return Err(FlankError::Singular("the axis surface"));
        }
        let powers = |points: &[DVec3], piece: usize| -> [DVec3; 4] {
            let functions = &basis.pieces[piece];
            let numbers = basis.numbers(piece);
            std::array::from_fn(|k| (0..4).map(|r| points[numbers[r]] * functions[r][k]).sum())
        };
        let pieces = (0..basis.pieces.len()).map(|i| [powers(&lower, i), powers(&upper, i)]).collect();
        Ok(Self { basis, lower, upper, pieces, u0_range })
    }

    /// Least squares through the tips and upper ends of `locations`, whose u0 must rise; closed if they go once around
    /// a closed surface, from u0 = 0 to 1.
    ///
    /// # Errors
    /// [`FlankError::Singular`] if there are too few locations.
    pub fn fit(locations: &[CutterLocation], control_points: usize, is_closed: bool) -> Result<Self, FlankError> {
        let singular = FlankError::Singular("the fit of the axis surface");
        let (Some(first), Some(last)) = (locations.first(), locations.last()) else { return Err(singular) };
        let range = [first.u0, last.u0];
        // Once around, the last location is the first one again, which must not count twice.
        let locations = if is_closed { &locations[..locations.len() - 1] } else { locations };
        if control_points < 4 || locations.len() < control_points {
            return Err(singular);
        }
        let basis = if is_closed { CubicBasis::closed(control_points) } else { CubicBasis::new(control_points) };
        let mut rows = DMatrix::zeros(locations.len(), control_points);
        let mut right = DMatrix::zeros(locations.len(), 6);
        for (i, location) in locations.iter().enumerate() {
            let at = basis.at((location.u0 - range[0]) / (range[1] - range[0]));
            (0..4).for_each(|r| rows[(i, at.numbers[r])] = at.values[r]);
            let ends = location.tip.to_array().into_iter().chain(location.q2.to_array());
            ends.enumerate().for_each(|(k, x)| right[(i, k)] = x);
        }
        let qr = rows.qr();
        let solved = qr.r().solve_upper_triangular(&(qr.q().transpose() * right)).ok_or(singular)?;
        let point = |i: usize, k: usize| DVec3::new(solved[(i, k)], solved[(i, k + 1)], solved[(i, k + 2)]);
        let points = |k: usize| (0..control_points).map(|i| point(i, k)).collect();
        Self::with(basis, [points(0), points(3)], range)
    }

    /// How far tips and upper ends of `locations` are from the places of both curves that belong to their u0, at most
    /// (mm).
    pub fn furthest(&self, locations: &[CutterLocation]) -> f64 {
        let [from, to] = self.u0_range;
        let off = |location: &CutterLocation| {
            let at = self.at((location.u0 - from) / (to - from));
            at.tip.distance(location.tip).max(at.top.distance(location.q2))
        };
        locations.iter().map(off).fold(0.0, f64::max)
    }

    /// Control points of C_b, the curve of the tip (mm).
    pub fn lower(&self) -> &[DVec3] {
        &self.lower
    }

    /// Control points of C_t, the curve of the upper end (mm).
    pub fn upper(&self) -> &[DVec3] {
        &self.upper
    }

    /// Whether it ends where it starts.
    pub fn is_closed(&self) -> bool {
        self.basis.is_closed
    }

    /// Basis functions.
    pub fn basis(&self) -> &CubicBasis {
        &self.basis
    }

    /// The axis at `t`.
    pub fn at(&self, t: f64) -> AxisAt {
        let (piece, x) = self.basis.place(t);
        let by_t = self.pieces.len() as f64;
        let value = |c: &[DVec3; 4]| c[0] + x * (c[1] + x * (c[2] + x * c[3]));
        let slope = |c: &[DVec3; 4]| by_t * (c[1] + x * (2.0 * c[2] + 3.0 * x * c[3]));
        let [lower, upper] = &self.pieces[piece];
        AxisAt { tip: value(lower), tip_speed: slope(lower), top: value(upper), top_speed: slope(upper) }
    }

    /// The place D(t, a) of the axis.
    pub fn point(&self, t: f64, a: f64) -> DVec3 {
        let at = self.at(t);
        at.tip.lerp(at.top, a)
    }

    /// Number of polynomial pieces that both curves are made of.
    pub(super) fn pieces(&self) -> usize {
        self.pieces.len()
    }

    /// The axis at the middle of a stretch, `middle` and `half` as shares of a piece, and how far its lower end (mm)
    /// and its unit vector move from there at most: bounds by the terms of the cubics, which nothing on the stretch
    /// exceeds.
    pub(super) fn stretch(&self, piece: usize, middle: f64, half: f64) -> (AxisAt, [f64; 2]) {
        let moves = |c: [DVec3; 4]| {
            let first = c[1] + middle * (2.0 * c[2] + 3.0 * middle * c[3]);
            let second = c[2] + 3.0 * middle * c[3];
            half * (first.length() + half * (second.length() + half * c[3].length()))
        };
        let at = self.at((piece as f64 + middle) / self.pieces.len() as f64);
        let [lower, upper] = &self.pieces[piece];
        let (tip, between) = (moves(*lower), moves(std::array::from_fn(|k| upper[k] - lower[k])));
        let length = at.length();
        // Two vectors of lengths a and b that are d apart have unit vectors at most 2 d / (a + b) apart, and none are
        // more than 2.
        let turn = if between < length { 2.0 * between / (2.0 * length - between) } else { 2.0 };
        (at, [tip, turn])
    }

    /// u0 of the location at `t`.
    pub fn u0(&self, t: f64) -> f64 {
        self.u0_range[0] + t * (self.u0_range[1] - self.u0_range[0])
    }

    /// The surface with every control point moved: `change` holds x, y, z of all of C_b, then of all of C_t.
    ///
    /// # Errors
    /// [`FlankError::Singular`] if a change is no number.
    pub fn moved(&self, change: &DVector<f64>) -> Result<Self, FlankError> {
        let n = self.lower.len();
        let by = |i: usize| DVec3::new(change[3 * i], change[3 * i + 1], change[3 * i + 2]);
        let lower = (0..n).map(|i| self.lower[i] + by(i)).collect();
        let upper = (0..n).map(|i| self.upper[i] + by(n + i)).collect();
        Self::with(self.basis.clone(), [lower, upper], self.u0_range)
    }
}
