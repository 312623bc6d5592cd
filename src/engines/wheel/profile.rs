//! The section of a blade: edge circles joined by two fifth-order polynomials, after P1 (figure 3, tables 1 and 2).
//!
//! A section lies in the unrolled cylinder of one radius: `x` along the blisk axis, `y` along the circumference.
//! The leading edge circle touches `x = 0`, the trailing edge circle `x = chord`. The side of greater `y` is
//! called upper. Each side leaves the edge circles tangentially at half the wedge angle from the blade angle,
//! and is the polynomial of fifth order that has the given position, slope and second derivative at both
//! tangent points. Both sides are single-valued in `x`, which is what makes structured meshes of a blisk easy.

use glam::{DVec2, DVec3};

use crate::inscribed::CurvePair;
use geometry::nurbs::{NurbsCurve, NurbsError};

/// Parameters of a section. Angles are measured from the blisk axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProfileParams {
    /// Axial distance between the tips of the edges (mm).
    pub chord: f64,
    /// Blade angle at the leading edge (rad).
    pub beta_in: f64,
    /// Blade angle at the trailing edge (rad).
    pub beta_out: f64,
    /// Angle between the two sides at the leading edge (rad).
    pub wedge_in: f64,
    /// Angle between the two sides at the trailing edge (rad).
    pub wedge_out: f64,
    /// Thickness at mid-chord, square to the camber line (mm).
    pub thickness: f64,
    /// Radius of the leading edge circle (mm).
    pub leading_radius: f64,
    /// Radius of the trailing edge circle (mm).
    pub trailing_radius: f64,
}

/// A circle of a section: one of its edges, or one inscribed between its sides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SectionCircle {
    /// Centre of the circle (mm).
    pub center: DVec2,
    /// Radius of the circle (mm).
    pub radius: f64,
}

impl SectionCircle {
    /// Half the height of the circle at `x`, 0 outside.
    fn half_height(&self, x: f64) -> f64 {
        let dx = x - self.center.x;
        (self.radius * self.radius - dx * dx).max(0.0).sqrt()
    }

    /// The point where a tangent of slope `tan(angle)` touches, above (`sign = 1`) or below (`-1`) the centre.
    pub(super) fn tangent_point(&self, angle: f64, sign: f64) -> DVec2 {
        self.center + DVec2::new(-angle.sin(), angle.cos()) * (sign * self.radius)
    }
}

/// Position, slope and second derivative of a curve `y(x)` at one end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct EndCondition {
    pub at: DVec2,
    pub slope: f64,
    pub bend: f64,
}

/// A fifth-order polynomial between two abscissae.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quintic {
    /// Least abscissa (mm).
    pub start: f64,
    /// Greatest abscissa (mm).
    pub end: f64,
    coefficients: [f64; 6],
}

impl Quintic {
    /// The polynomial that meets both conditions (P1, equations 4 and 5), written in `(x - start) / (end - start)`.
    pub(super) fn through(a: EndCondition, b: EndCondition) -> Self {
        let l = b.at.x - a.at.x;
        let (c0, c1, c2) = (a.at.y, a.slope * l, 0.5 * a.bend * l * l);
        let value = b.at.y - c0 - c1 - c2;
        let slope = b.slope * l - c1 - 2.0 * c2;
        let bend = b.bend * l * l - 2.0 * c2;
        let c3 = 10.0 * value - 4.0 * slope + 0.5 * bend;
        let c4 = -15.0 * value + 7.0 * slope - bend;
        let c5 = 6.0 * value - 3.0 * slope + 0.5 * bend;
        Self { start: a.at.x, end: b.at.x, coefficients: [c0, c1, c2, c3, c4, c5] }
    }

    /// The value at `x` (mm).
    pub fn value(&self, x: f64) -> f64 {
        self.at(x)[0]
    }

    /// Value (mm), slope and second derivative (1/mm) at `x`.
    pub fn at(&self, x: f64) -> [f64; 3] {
        let length = self.end - self.start;
        let t = (x - self.start) / length;
        let sums =
            self.coefficients.iter().rev().fold([0.0; 3], |[value, slope, half_bend], c| {
                [value * t + c, slope * t + value, half_bend * t + slope]
            });
        [sums[0], sums[1] / length, 2.0 * sums[2] / (length * length)]
    }

    /// Coefficients of the powers 0 to 5 of x in mm: P1's a0 to a5 and b0 to b5, equation 3.
    pub fn in_powers_of_x(&self) -> [f64; 6] {
        let length = self.end - self.start;
        let mut sums = [0.0; 6];
        // Horner's scheme, each round a product with (x - start) / length.
        for c in self.coefficients.iter().rev() {
            let below = [0.0, sums[0], sums[1], sums[2], sums[3], sums[4]];
            for (sum, below) in sums.iter_mut().zip(below) {
                *sum = (below - self.start * *sum) / length;
            }
            sums[0] += c;
        }
        sums
    }
}

/// A blade section: two edge circles and two sides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BladeProfile {
    /// The circle at the leading edge.
    pub leading: SectionCircle,
    /// The circle at the trailing edge.
    pub trailing: SectionCircle,
    /// The side of greater `y` between the tangent points.
    pub upper: Quintic,
    /// The side of smaller `y` between the tangent points.
    pub lower: Quintic,
    chord: f64,
}

impl BladeProfile {
    /// The section that `params` describe, with its camber line through `y = 0` at mid-chord.
    ///
    /// P1 prescribes the second derivatives at the tangent points; here both sides share the one of a parabolic
    /// camber line, plus and minus the amount that gives the wanted thickness at mid-chord.
    pub fn new(params: &ProfileParams) -> Self {
        let slopes = [params.beta_in.tan(), params.beta_out.tan()];
        let centers_x = [params.leading_radius, params.chord - params.trailing_radius];
        let length = centers_x[1] - centers_x[0];
        let bend = (slopes[1] - slopes[0]) / length;
        let camber = |x: f64| {
            let t = x - 0.5 * params.chord;
            0.5 * bend * t * t + (slopes[0] + bend * (0.5 * params.chord - centers_x[0])) * t
        };
        let circle = |x: f64, radius| SectionCircle { center: DVec2::new(x, camber(x)), radius };
        let leading = circle(centers_x[0], params.leading_radius);
        let trailing = circle(centers_x[1], params.trailing_radius);
        let side = |sign: f64, swell: f64| {
            let angles =
                [params.beta_in + 0.5 * sign * params.wedge_in, params.beta_out - 0.5 * sign * params.wedge_out];
            let end = |edge: &SectionCircle, angle: f64| EndCondition {
                at: edge.tangent_point(angle, sign),
                slope: angle.tan(),
                bend: bend + sign * swell,
            };
            Quintic::through(end(&leading, angles[0]), end(&trailing, angles[1]))
        };
        // The thickness at mid-chord is a linear function of the added second derivative.
        let middle = 0.5 * params.chord;
        let thickness = |swell| side(1.0, swell).value(middle) - side(-1.0, swell).value(middle);
        let middle_slope = slopes[0] + bend * (middle - centers_x[0]);
        let wanted = params.thickness * middle_slope.hypot(1.0);
        let swell = (wanted - thickness(0.0)) / (thickness(1.0) - thickness(0.0));
        Self { leading, trailing, upper: side(1.0, swell), lower: side(-1.0, swell), chord: params.chord }
    }

    /// The height of the upper side at `x`, edges included; `x` is taken into `[0, chord]` (mm).
    pub fn upper_y(&self, x: f64) -> f64 {
        self.height(x, &self.upper, 1.0)
    }

    /// The height of the lower side at `x`, edges included; `x` is taken into `[0, chord]` (mm).
    pub fn lower_y(&self, x: f64) -> f64 {
        self.height(x, &self.lower, -1.0)
    }

    fn height(&self, x: f64, side: &Quintic, sign: f64) -> f64 {
        let x = x.clamp(0.0, self.chord);
        if x < side.start {
            self.leading.center.y + sign * self.leading.half_height(x)
        } else if x > side.end {
            self.trailing.center.y + sign * self.trailing.half_height(x)
        } else {
            side.value(x)
        }
    }

    /// Circles between both sides, each touching the one before, from the leading edge to the trailing one: P1's C_i,
    /// conditions 1 to 3.
    ///
    /// # Errors
    /// [`NurbsError`] if the sides cannot be followed.
    pub fn inscribed_circles(&self) -> Result<Vec<SectionCircle>, NurbsError> {
        const PIECES: usize = 160;
        let curve = |side: &Quintic| {
            let x = |i: usize| side.start + (side.end - side.start) * i as f64 / PIECES as f64;
            let points: Vec<DVec3> = (0..=PIECES).map(x).map(|x| DVec3::new(x, side.value(x), 0.0)).collect();
            NurbsCurve::through(&points, 5)
        };
        let chain = CurvePair::new(curve(&self.lower)?, curve(&self.upper)?).chain();
        let circle = chain.iter().map(|c| SectionCircle { center: c.center.truncate(), radius: c.radius });
        Ok(circle.collect())
    }

    /// The least thickness along `y` away from the edge circles, and where it is (mm); negative when the sides cross.
    pub fn least_thickness(&self) -> (f64, f64) {
        let (from, to) = (self.leading.center.x, self.trailing.center.x);
        let steps = 200;
        (0..=steps)
            .map(|i| from + (to - from) * f64::from(i) / f64::from(steps))
            .map(|x| (self.upper_y(x) - self.lower_y(x), x))
            .fold((f64::INFINITY, 0.0), |best, next| if next.0 < best.0 { next } else { best })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn params() -> impl Strategy<Value = ProfileParams> {
        let angles = (-55.0..55.0f64, -55.0..55.0f64, 5.0..25.0f64, 5.0..20.0f64);
        (angles, 10.0..40.0f64, 0.08..0.2f64, 0.2..0.6f64, 0.2..0.6f64).prop_map(
            |((beta_in, beta_out, wedge_in, wedge_out), chord, thickness, leading_radius, trailing_radius)| {
                ProfileParams {
                    chord,
                    beta_in: beta_in.to_radians(),
                    beta_out: beta_out.to_radians(),
                    wedge_in: wedge_in.to_radians(),
                    wedge_out: wedge_out.to_radians(),
                    thickness: chord * thickness,
                    leading_radius,
                    trailing_radius,
                }
            },
        )
    }

    /// Slope by a central difference, good to about 1e-9.
    fn slope(side: &Quintic, x: f64) -> f64 {
        (side.value(x + 1e-5) - side.value(x - 1e-5)) / 2e-5
    }

    proptest! {
        #[test]
        fn sides_leave_the_edge_circles_tangentially(p in params()) {
            let profile = BladeProfile::new(&p);
            for side in [&profile.upper, &profile.lower] {
                let powers = side.in_powers_of_x();
                for (edge, x) in [(&profile.leading, side.start), (&profile.trailing, side.end)] {
                    let [value, first, _] = side.at(x);
                    let sum = powers.iter().rev().fold(0.0, |sum, c| sum * x + c);
                    prop_assert!((sum - value).abs() < 1e-7, "{sum} and {value}");
                    prop_assert!((first - slope(side, x)).abs() < 1e-6);
                    let spoke = DVec2::new(x, side.value(x)) - edge.center;
                    prop_assert!((spoke.length() - edge.radius).abs() < 1e-9, "starts on the circle");
                    let tangent = DVec2::new(1.0, slope(side, x)).normalize();
                    prop_assert!((spoke / edge.radius).dot(tangent).abs() < 1e-6, "and square to its radius");
                }
            }
        }

        #[test]
        fn blade_angles_wedges_and_thickness_are_those_asked_for(p in params()) {
            let profile = BladeProfile::new(&p);
            let upper = slope(&profile.upper, profile.upper.start).atan();
            let lower = slope(&profile.lower, profile.lower.start).atan();
            prop_assert!((0.5 * (upper + lower) - p.beta_in).abs() < 1e-6);
            prop_assert!((upper - lower - p.wedge_in).abs() < 1e-6);
            let upper = slope(&profile.upper, profile.upper.end).atan();
            let lower = slope(&profile.lower, profile.lower.end).atan();
            prop_assert!((0.5 * (upper + lower) - p.beta_out).abs() < 1e-6);
            prop_assert!((lower - upper - p.wedge_out).abs() < 1e-6);
            // The slope of a parabolic camber line goes linearly from edge centre to edge centre.
            let middle = 0.5 * p.chord;
            let t = (middle - p.leading_radius) / (p.chord - p.leading_radius - p.trailing_radius);
            let rise = p.beta_in.tan() * (1.0 - t) + p.beta_out.tan() * t;
            let across = (profile.upper.value(middle) - profile.lower.value(middle)) * rise.atan().cos();
            prop_assert!((across - p.thickness).abs() < 1e-9, "{across} for {}", p.thickness);
        }
    }

    fn symmetric() -> BladeProfile {
        BladeProfile::new(&ProfileParams {
            chord: 20.0,
            beta_in: 0.0,
            beta_out: 0.0,
            wedge_in: 0.2,
            wedge_out: 0.2,
            thickness: 3.0,
            leading_radius: 0.4,
            trailing_radius: 0.4,
        })
    }

    #[test]
    fn circles_between_the_sides_touch_both_and_each_other() {
        let turned = BladeProfile::new(&ProfileParams {
            chord: 20.0,
            beta_in: 0.7,
            beta_out: -0.8,
            wedge_in: 0.35,
            wedge_out: 0.25,
            thickness: 3.2,
            leading_radius: 0.4,
            trailing_radius: 0.3,
        });
        for profile in [symmetric(), turned] {
            let circles = profile.inscribed_circles().unwrap();
            assert!(circles.len() > 6, "{}", circles.len());
            assert!(circles[0].center.distance(profile.leading.center) < 0.1, "begins at the edge");
            let end = circles[circles.len() - 1];
            let gap = end.center.distance(profile.trailing.center);
            assert!(gap < 2.0 * end.radius + 0.01, "no further circle fits before the trailing edge: {gap}");
            for pair in circles.windows(2) {
                let apart = pair[0].center.distance(pair[1].center) - pair[0].radius - pair[1].radius;
                assert!(apart.abs() < 1e-9, "{apart}");
            }
            for circle in &circles {
                for side in [&profile.upper, &profile.lower] {
                    let places = (0..=20_000).map(|i| side.start + (side.end - side.start) * f64::from(i) / 2e4);
                    let nearest = places.map(|x| circle.center.distance(DVec2::new(x, side.value(x))));
                    let nearest = nearest.fold(f64::INFINITY, f64::min);
                    assert!((nearest - circle.radius).abs() < 1e-5, "{nearest} for {circle:?}");
                }
            }
        }
        assert!(symmetric().inscribed_circles().unwrap().iter().all(|c| c.center.y.abs() < 1e-6));
    }

    #[test]
    fn a_symmetric_section_is_symmetric() {
        let profile = symmetric();
        for i in 0..=100 {
            let x = 0.2 * f64::from(i);
            assert!((profile.upper_y(x) + profile.lower_y(x)).abs() < 1e-12);
            assert!((profile.upper_y(x) - profile.upper_y(20.0 - x)).abs() < 1e-6);
        }
        assert!((profile.upper_y(10.0) - 1.5).abs() < 1e-12);
        assert!(profile.upper_y(0.0).abs() < 1e-6 && profile.upper_y(20.0).abs() < 1e-6, "tips on the camber line");
    }
}
