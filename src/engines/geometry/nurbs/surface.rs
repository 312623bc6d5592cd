//! Tensor product NURBS surfaces.

use glam::{DVec3, DVec4};

use super::NurbsError;
use super::curve::NurbsCurve;
use super::knots::KnotVector;

/// A NURBS surface. The control point at (`i`, `j`) has index `i * count_v + j`.
#[derive(Debug, Clone, PartialEq)]
pub struct NurbsSurface {
    u: KnotVector,
    v: KnotVector,
    /// Control points times their weights, and the weights.
    points: Vec<DVec4>,
}

impl NurbsSurface {
    /// The surface with these control points and weights.
    ///
    /// # Errors
    /// If numbers do not match, a weight is not positive or a coordinate is no number.
    pub fn new(u: KnotVector, v: KnotVector, points: &[DVec3], weights: &[f64]) -> Result<Self, NurbsError> {
        if points.len() != u.count() * v.count() || weights.len() != points.len() {
            return Err(NurbsError::Counts);
        }
        let usable = |i: &usize| points[*i].is_finite() && weights[*i].is_finite() && weights[*i] > 0.0;
        if let Some(i) = (0..points.len()).find(|i| !usable(i)) {
            return Err(NurbsError::Value(i));
        }
        Ok(Self { u, v, points: points.iter().zip(weights).map(|(p, w)| (*p * *w).extend(*w)).collect() })
    }

    /// First and last parameter in both directions.
    pub fn domain(&self) -> [[f64; 2]; 2] {
        [self.u.domain(), self.v.domain()]
    }

    /// Knots in direction u (0) or v (1).
    pub fn knots(&self, direction: usize) -> &KnotVector {
        if direction == 0 { &self.u } else { &self.v }
    }

    /// The curve on the surface along u (0) or v (1) on which the other parameter is `across`.
    pub fn curve(&self, direction: usize, across: f64) -> NurbsCurve {
        let basis = self.knots(1 - direction).basis(across);
        let degree = self.knots(1 - direction).degree();
        let place = |along: usize, k: usize| if direction == 0 { [along, k] } else { [k, along] };
        let point = |along: usize| {
            let shares = basis.orders[0].iter().take(degree + 1).enumerate();
            let at = |k: usize| place(along, basis.first + k);
            shares.map(|(k, share)| self.points[at(k)[0] * self.v.count() + at(k)[1]] * *share).sum()
        };
        let knots = self.knots(direction).clone();
        let points = (0..knots.count()).map(point).collect();
        NurbsCurve::of(knots, points)
    }

    /// Parameters at which pieces join in direction u (0) or v (1), ends included, each once.
    pub fn joints(&self, direction: usize) -> Vec<f64> {
        if direction == 0 { self.u.joints() } else { self.v.joints() }
    }

    /// The point at (`u`, `v`).
    pub fn point(&self, u: f64, v: f64) -> DVec3 {
        let [point] = self.sums(u, v, [[0, 0]]);
        point.truncate() / point.w
    }

    /// Point and both first derivatives at (`u`, `v`).
    pub fn at(&self, u: f64, v: f64) -> [DVec3; 3] {
        let [a, b, c] = self.sums(u, v, [[0, 0], [1, 0], [0, 1]]);
        let point = a.truncate() / a.w;
        [point, (b.truncate() - point * b.w) / a.w, (c.truncate() - point * c.w) / a.w]
    }

    /// Point, both first derivatives, and the second ones by u, by both and by v, at (`u`, `v`).
    pub fn with_second(&self, u: f64, v: f64) -> [DVec3; 6] {
        let sums = self.sums(u, v, [[0, 0], [1, 0], [0, 1], [2, 0], [1, 1], [0, 2]]);
        let [(p, w), (pu, wu), (pv, wv), (puu, wuu), (puv, wuv), (pvv, wvv)] = sums.map(|s| (s.truncate(), s.w));
        let point = p / w;
        let (du, dv) = ((pu - point * wu) / w, (pv - point * wv) / w);
        let duu = (puu - 2.0 * wu * du - point * wuu) / w;
        let duv = (puv - wu * dv - wv * du - point * wuv) / w;
        let dvv = (pvv - 2.0 * wv * dv - point * wvv) / w;
        [point, du, dv, duu, duv, dvv]
    }

    /// The unit normal at (`u`, `v`), along the product of the derivatives by u and by v; zero where they are parallel.
    pub fn normal(&self, u: f64, v: f64) -> DVec3 {
        let [_, along_u, along_v] = self.at(u, v);
        along_u.cross(along_v).normalize_or_zero()
    }

    /// Homogeneous derivatives of the given orders in u and v.
    fn sums<const N: usize>(&self, u: f64, v: f64, orders: [[usize; 2]; N]) -> [DVec4; N] {
        let (in_u, in_v) = (self.u.basis(u), self.v.basis(v));
        let mut sums = [DVec4::ZERO; N];
        for i in 0..=self.u.degree() {
            let row = (in_u.first + i) * self.v.count() + in_v.first;
            for (j, point) in self.points[row..=row + self.v.degree()].iter().enumerate() {
                for (sum, [du, dv]) in sums.iter_mut().zip(orders) {
                    *sum += *point * (in_u.orders[du][i] * in_v.orders[dv][j]);
                }
            }
        }
        sums
    }
}
