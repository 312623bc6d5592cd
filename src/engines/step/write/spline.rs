//! Cubic B-splines on the unit interval and the unit square.
//!
//! Knots are dyadic fractions: spans are only ever halved, and the places at which curves are chained are dyadic too. So
//! the knots of different curves can be united without spans that are next to nothing.

use glam::DVec3;

use super::band::Band;

/// Degree of every spline that is written.
pub(super) const DEGREE: usize = 3;
/// Weight of the bending between control points against one point of a curve.
const BENDING: f64 = 1e-7;

/// Places on each straight side that a curve along it is fitted to.
pub(super) const ON_SIDE: usize = 8;

/// A cubic knot vector from 0 to 1 with both ends repeated four times, and others at most three times.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Knots(Vec<f64>);

/// The basis functions that are not zero at a parameter.
#[derive(Debug, Clone, Copy)]
pub(super) struct Basis {
    /// Number of the first of the four.
    pub(super) first: usize,
    /// Values of the functions.
    pub(super) values: [f64; 4],
    /// Derivatives of the functions.
    pub(super) slopes: [f64; 4],
}

impl Knots {
    /// The knots of a single span.
    pub(super) fn unit() -> Self {
        Self(vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0])
    }

    /// All knots, the repeated ones too.
    pub(super) fn all(&self) -> &[f64] {
        &self.0
    }

    /// Number of control points.
    pub(super) fn count(&self) -> usize {
        self.0.len() - DEGREE - 1
    }

    /// The different knots, rising.
    pub(super) fn breaks(&self) -> Vec<f64> {
        let mut breaks = self.0.clone();
        breaks.dedup();
        breaks
    }

    /// How often a knot is repeated.
    pub(super) fn times(&self, knot: f64) -> usize {
        self.0.partition_point(|&k| k <= knot) - self.0.partition_point(|&k| k < knot)
    }

    /// The knots with every chosen span between two breaks halved.
    pub(super) fn halved(&self, is_chosen: impl Fn(usize) -> bool) -> Self {
        let breaks = self.breaks();
        let mut knots = self.0.clone();
        knots.extend(breaks.windows(2).enumerate().filter(|(k, _)| is_chosen(*k)).map(|(_, w)| 0.5 * (w[0] + w[1])));
        knots.sort_by(f64::total_cmp);
        Self(knots)
    }

    /// The knots of both, each as often as the one has it that has it more often.
    pub(super) fn united(&self, other: &Self) -> Self {
        let mut breaks: Vec<f64> = self.0.iter().chain(&other.0).copied().collect();
        breaks.sort_by(f64::total_cmp);
        breaks.dedup();
        Self(breaks.into_iter().flat_map(|k| vec![k; self.times(k).max(other.times(k))]).collect())
    }

    /// The knots of the same curve run the other way.
    pub(super) fn reversed(&self) -> Self {
        Self(self.0.iter().rev().map(|k| 1.0 - k).collect())
    }

    /// The parameter at which a control point acts most: the mean of its inner knots (Greville).
    pub(super) fn site(&self, control: usize) -> f64 {
        self.0[control + 1..=control + DEGREE].iter().sum::<f64>() / DEGREE as f64
    }

    /// The basis functions at `u` by the recursion of Cox and de Boor.
    pub(super) fn basis(&self, u: f64) -> Basis {
        let span = self.0.partition_point(|&k| k <= u).clamp(DEGREE + 1, self.count()) - 1;
        let mut values = [1.0, 0.0, 0.0, 0.0];
        let mut lower = values;
        for d in 1..=DEGREE {
            lower = values;
            let mut carried = 0.0;
            for r in 0..d {
                let (left, right) = (self.0[span + 1 + r - d], self.0[span + 1 + r]);
                let share = lower[r] / (right - left);
                values[r] = carried + (right - u) * share;
                carried = (u - left) * share;
            }
            values[d] = carried;
        }
        let mut slopes = [0.0; 4];
        for (r, slope) in slopes.iter_mut().enumerate() {
            let i = span - DEGREE + r;
            let rise = if r > 0 { lower[r - 1] / (self.0[i + DEGREE] - self.0[i]) } else { 0.0 };
            let fall = if r < DEGREE { lower[r] / (self.0[i + DEGREE + 1] - self.0[i + 1]) } else { 0.0 };
            *slope = DEGREE as f64 * (rise - fall);
        }
        Basis { first: span - DEGREE, values, slopes }
    }
}

/// A cubic curve in space.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Curve {
    /// Knots.
    pub(super) knots: Knots,
    /// Control points (mm).
    pub(super) controls: Vec<DVec3>,
}

impl Curve {
    /// The straight line between two points.
    pub(super) fn line(a: DVec3, b: DVec3) -> Self {
        Self { knots: Knots::unit(), controls: (0..=3).map(|k| a.lerp(b, f64::from(k) / 3.0)).collect() }
    }

    /// The point at `u`.
    pub(super) fn at(&self, u: f64) -> DVec3 {
        let basis = self.knots.basis(u);
        (0..=DEGREE).map(|r| self.controls[basis.first + r] * basis.values[r]).sum()
    }

    /// The curve from the first point to the last that is nearest to the points between, at the given parameters, by
    /// least squares. Points in a plane give a curve in the plane.
    pub(super) fn fitted(knots: Knots, parameters: &[f64], points: &[DVec3]) -> Option<Self> {
        let last = knots.count() - 1;
        let ends = [*points.first()?, *points.last()?];
        let mut matrix = Band::new(last - 1, DEGREE);
        let mut right = vec![DVec3::ZERO; last - 1];
        let mut add = |form: &[(usize, f64)], mut target: DVec3, weight: f64| {
            let mut inner = Vec::with_capacity(form.len());
            for &(i, a) in form {
                match i {
                    0 => target -= ends[0] * a,
                    i if i == last => target -= ends[1] * a,
                    i => inner.push((i - 1, a)),
                }
            }
            matrix.add_square(&inner, weight);
            inner.iter().for_each(|&(i, a)| right[i] += target * (a * weight));
        };
        for (&u, &point) in parameters.iter().zip(points) {
            let basis = knots.basis(u);
            let form: [(usize, f64); 4] = std::array::from_fn(|r| (basis.first + r, basis.values[r]));
            add(&form, point, 1.0);
        }
        for i in 1..last {
            let [a, b, c] = [i - 1, i, i + 1].map(|k| knots.site(k));
            let (before, after) = (b - a, c - b);
            let reach = 0.5 * (c - a);
            add(
                &[(i - 1, reach / before), (i, -reach / before - reach / after), (i + 1, reach / after)],
                DVec3::ZERO,
                BENDING,
            );
        }
        matrix.factored()?.solve(&mut right);
        let mut controls = vec![ends[0]];
        controls.extend(right);
        controls.push(ends[1]);
        controls.iter().all(|p| p.is_finite()).then_some(Self { knots, controls })
    }

    /// The curve nearest to the straight sides between points, at the given parameters: between points as near as at
    /// them, however uneven their distances are.
    pub(super) fn along(knots: Knots, parameters: &[f64], points: &[DVec3]) -> Option<Self> {
        let (mut places, mut targets) = (Vec::new(), Vec::new());
        for (ends, sides) in parameters.windows(2).zip(points.windows(2)) {
            for k in 0..ON_SIDE {
                let t = k as f64 / ON_SIDE as f64;
                places.push(ends[0] + t * (ends[1] - ends[0]));
                targets.push(sides[0].lerp(sides[1], t));
            }
        }
        places.push(*parameters.last()?);
        targets.push(*points.last()?);
        Self::fitted(knots, &places, &targets)
    }

    /// The curve run the other way.
    pub(super) fn reversed(&self) -> Self {
        Self { knots: self.knots.reversed(), controls: self.controls.iter().rev().copied().collect() }
    }

    /// Curves one after the other, each over the part of the parameters between two of `joints`, which rise from 0 to 1.
    pub(super) fn chained(parts: &[Self], joints: &[f64]) -> Self {
        let (mut knots, mut controls) = (vec![0.0; DEGREE + 1], Vec::new());
        for (part, ends) in parts.iter().zip(joints.windows(2)) {
            let inner = &part.knots.0[DEGREE + 1..part.knots.count()];
            knots.extend(inner.iter().map(|k| ends[0] + (ends[1] - ends[0]) * k));
            let times = if ends[1] < 1.0 { DEGREE } else { DEGREE + 1 };
            knots.extend(vec![ends[1]; times]);
            controls.extend(&part.controls[usize::from(!controls.is_empty())..]);
        }
        Self { knots: Knots(knots), controls }
    }

    /// The same curve with more knots, of which it has some (Boehm).
    pub(super) fn with_knots(&self, knots: &Knots) -> Self {
        let mut curve = self.clone();
        for knot in knots.breaks() {
            for _ in curve.knots.times(knot)..knots.times(knot) {
                curve.insert(knot);
            }
        }
        curve
    }

    fn insert(&mut self, knot: f64) {
        let all = &self.knots.0;
        let span = all.partition_point(|&k| k <= knot) - 1;
        let share = |i: usize| (knot - all[i]) / (all[i + DEGREE] - all[i]);
        let mut controls = self.controls[..=span - DEGREE].to_vec();
        controls.extend((span - DEGREE + 1..=span).map(|i| self.controls[i - 1].lerp(self.controls[i], share(i))));
        controls.extend(&self.controls[span..]);
        self.controls = controls;
        self.knots.0.insert(span + 1, knot);
    }
}

/// A bicubic surface over the unit square.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SplineSurface {
    /// Knots along u and v.
    pub(super) knots: [Knots; 2],
    /// Control point (`i`, `j`) along u and v at `i * count_v + j` (mm).
    pub(super) controls: Vec<DVec3>,
}

impl SplineSurface {
    /// The point where the functions `u` and `v` are those of a place.
    pub(super) fn point(&self, u: &Basis, v: &Basis) -> DVec3 {
        let count = self.knots[1].count();
        let row = |r: usize| {
            let at = (u.first + r) * count + v.first;
            (0..=DEGREE).map(|s| self.controls[at + s] * v.values[s]).sum::<DVec3>()
        };
        (0..=DEGREE).map(|r| row(r) * u.values[r]).sum()
    }

    /// The unit normal there; zero where the surface has none.
    pub(super) fn normal(&self, u: &Basis, v: &Basis) -> DVec3 {
        let count = self.knots[1].count();
        let (mut along_u, mut along_v) = (DVec3::ZERO, DVec3::ZERO);
        for r in 0..=DEGREE {
            for s in 0..=DEGREE {
                let control = self.controls[(u.first + r) * count + v.first + s];
                along_u += control * (u.slopes[r] * v.values[s]);
                along_v += control * (u.values[r] * v.slopes[s]);
            }
        }
        along_u.cross(along_v).normalize_or_zero()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_basis_sums_to_one_and_its_slopes_are_differences() {
        let mut knots = Knots::unit().halved(|_| true).halved(|span| span == 1);
        knots.0.splice(5..5, [0.5, 0.5]);
        assert_eq!((knots.breaks(), knots.times(0.5), knots.count()), (vec![0.0, 0.5, 0.75, 1.0], 3, 8));
        for u in [0.0, 0.3, 0.499, 0.5, 0.7, 1.0] {
            let basis = knots.basis(u);
            assert!((basis.values.iter().sum::<f64>() - 1.0).abs() < 1e-14);
            // The control points at their sites make the straight function.
            let sum = |of: [f64; 4]| (0..4).map(|r| of[r] * knots.site(basis.first + r)).sum::<f64>();
            assert!((sum(basis.values) - u).abs() < 1e-14 && (sum(basis.slopes) - 1.0).abs() < 1e-12, "{u}");
        }
    }

    fn arc(knots: Knots, from: f64, to: f64) -> Curve {
        let angle = |u: f64| from + (to - from) * u;
        let parameters: Vec<f64> = (0..=100).map(|i| f64::from(i) / 100.0).collect();
        let point = |u: &f64| DVec3::new(5.0 * angle(*u).cos(), 5.0 * angle(*u).sin(), 0.0);
        let points: Vec<DVec3> = parameters.iter().map(point).collect();
        Curve::fitted(knots, &parameters, &points).unwrap()
    }

    #[test]
    fn a_fit_to_points_of_a_circle_is_as_near_as_cubics_can_be() {
        let curve = arc((0..3).fold(Knots::unit(), |k, _| k.halved(|_| true)), 0.0, 1.5);
        let worst = (0..=999).map(|i| (curve.at(f64::from(i) / 999.0).length() - 5.0).abs()).fold(0.0, f64::max);
        // h^4 / 384 of the fourth derivative: 5 mm (1.5 / 8)^4 / 384.
        assert!(worst < 5.0 * (1.5f64 / 8.0).powi(4) / 100.0, "{worst}");
        assert_eq!(curve.at(0.0), DVec3::X * 5.0);
    }

    #[test]
    fn chains_turns_and_further_knots_leave_a_curve_where_it_is() {
        let parts = [arc(Knots::unit().halved(|_| true), 0.0, 0.4), arc(Knots::unit(), 0.4, 1.5)];
        let chain = Curve::chained(&parts, &[0.0, 0.25, 1.0]);
        let knots = chain.knots.united(&Knots::unit().halved(|_| true).halved(|_| true));
        assert_eq!((chain.knots.times(0.25), knots.times(0.25), knots.times(0.75)), (3, 3, 1));
        let (more, back) = (chain.with_knots(&knots), chain.reversed());
        assert_eq!(more.knots, knots);
        for u in (0..=50).map(|i| f64::from(i) / 50.0) {
            let p = if u < 0.25 { parts[0].at(4.0 * u) } else { parts[1].at((u - 0.25) / 0.75) };
            let all = [chain.at(u), more.at(u), back.at(1.0 - u)];
            assert!(all.iter().all(|q| q.distance(p) < 1e-13), "{u}");
        }
    }
}
