//! A blade section as P1 prescribes it: two edge circles anywhere, and a suction and a pressure side of fifth order with
//! given slopes and curvatures where they leave the circles (P1, equations 2 to 5, tables 1 and 2).
//!
//! [`profile`](super::profile) makes sections of a wanted thickness, with curvatures to match; here the curvatures are
//! given. The section lies in the plane of `x` (along the blisk axis) and `y` (around it); the suction side is the one
//! of greater `y`.

use glam::DVec2;

use super::profile::{EdgeCircle, EndCondition, Quintic};

/// Parameters of a section at one of its edges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BladeEdge {
    /// The edge circle.
    pub circle: EdgeCircle,
    /// Blade angle, from the blisk axis (rad).
    pub angle: f64,
    /// Wedge angle between the two sides (rad), positive where they open away from the edge.
    pub wedge: f64,
    /// Signed curvature of the suction side at its tangent point (1/mm), positive towards greater `y`.
    pub suction_curvature: f64,
    /// Curvature of the pressure side (1/mm).
    pub pressure_curvature: f64,
}

/// A section made of two circles and two sides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BladeSection {
    /// The leading edge.
    pub leading: EdgeCircle,
    /// The trailing edge.
    pub trailing: EdgeCircle,
    /// The suction side between its tangent points.
    pub suction: Quintic,
    /// The pressure side between its tangent points.
    pub pressure: Quintic,
}

/// Why edges make no section.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum BladeSectionError {
    /// A circle without size.
    #[error("the radius of the {0} edge must be positive")]
    Radius(&'static str),
    /// A side that would stand upright.
    #[error("the sides at the {0} edge stand {1:.1} deg to the axis; they must stay below 85 deg")]
    Steep(&'static str, f64),
    /// The edges are in the wrong order or touch.
    #[error("the tangent points of the leading edge must lie before those of the trailing edge along x")]
    Order,
    /// A value that is no number.
    #[error("an edge has a value that is no number")]
    NotFinite,
}

impl BladeSection {
    /// Greatest angle of a side to the axis at an edge (deg).
    const STEEPEST: f64 = 85.0;

    /// The section between two edges.
    ///
    /// # Errors
    /// [`BladeSectionError`] if there is no such section with sides that are functions of `x`.
    pub fn new(leading: &BladeEdge, trailing: &BladeEdge) -> Result<Self, BladeSectionError> {
        check("leading", leading)?;
        check("trailing", trailing)?;
        let side = |sign: f64, curvature: fn(&BladeEdge) -> f64| {
            // The sides draw apart behind the leading edge and together before the trailing edge.
            let start = end_condition(leading, sign, leading.angle + 0.5 * sign * leading.wedge, curvature);
            let end = end_condition(trailing, sign, trailing.angle - 0.5 * sign * trailing.wedge, curvature);
            if start.at.x < end.at.x { Ok(Quintic::through(start, end)) } else { Err(BladeSectionError::Order) }
        };
        Ok(Self {
            leading: leading.circle,
            trailing: trailing.circle,
            suction: side(1.0, |e| e.suction_curvature)?,
            pressure: side(-1.0, |e| e.pressure_curvature)?,
        })
    }

    /// `n` points of a side from tangent point to tangent point, closer together towards both.
    pub fn points(side: &Quintic, n: usize) -> Vec<DVec2> {
        let steps = n.max(2) - 1;
        let share = |i: usize| 0.5 * (1.0 - (std::f64::consts::PI * i as f64 / steps as f64).cos());
        (0..=steps)
            .map(|i| side.start + (side.end - side.start) * share(i))
            .map(|x| DVec2::new(x, side.value(x)))
            .collect()
    }
}

fn check(name: &'static str, edge: &BladeEdge) -> Result<(), BladeSectionError> {
    let EdgeCircle { center, radius } = edge.circle;
    let numbers = [center.x, center.y, radius, edge.angle, edge.wedge, edge.suction_curvature, edge.pressure_curvature];
    if !numbers.iter().all(|n| n.is_finite()) {
        return Err(BladeSectionError::NotFinite);
    }
    if radius <= 0.0 {
        return Err(BladeSectionError::Radius(name));
    }
    let steepest = (edge.angle.abs() + 0.5 * edge.wedge.abs()).to_degrees();
    if steepest < BladeSection::STEEPEST { Ok(()) } else { Err(BladeSectionError::Steep(name, steepest)) }
}

/// Where and how a side at `angle` to the axis leaves the circle of `edge`.
fn end_condition(edge: &BladeEdge, sign: f64, angle: f64, curvature: fn(&BladeEdge) -> f64) -> EndCondition {
    let slope = angle.tan();
    // The curvature of y(x) is y'' / (1 + y'^2)^(3/2).
    let bend = curvature(edge) * slope.hypot(1.0).powi(3);
    EndCondition { at: edge.circle.tangent_point(angle, sign), slope, bend }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn edges() -> [BladeEdge; 2] {
        let circle = |x, y, radius| EdgeCircle { center: DVec2::new(x, y), radius };
        let leading = BladeEdge {
            circle: circle(-12.0, -3.0, 0.5),
            angle: 0.6,
            wedge: 0.3,
            suction_curvature: -0.05,
            pressure_curvature: -0.02,
        };
        let trailing = BladeEdge {
            circle: circle(11.0, -4.5, 0.3),
            angle: -0.8,
            wedge: 0.2,
            suction_curvature: -0.015,
            pressure_curvature: -0.03,
        };
        [leading, trailing]
    }

    /// Value, slope and curvature at `x` by differences.
    fn looked_at(side: &Quintic, x: f64) -> [f64; 3] {
        let h = 1e-4;
        let [before, here, after] = [x - h, x, x + h].map(|x| side.value(x));
        let slope = (after - before) / (2.0 * h);
        [here, slope, (after - 2.0 * here + before) / (h * h) / slope.hypot(1.0).powi(3)]
    }

    #[test]
    fn sides_leave_the_circles_with_the_given_slopes_and_curvatures() {
        let [leading, trailing] = edges();
        let section = BladeSection::new(&leading, &trailing).unwrap();
        for (side, sign) in [(&section.suction, 1.0), (&section.pressure, -1.0)] {
            let ends = [(leading, side.start, 0.5), (trailing, side.end, -0.5)];
            for (edge, x, half) in ends {
                let [y, slope, curvature] = looked_at(side, x);
                let spoke = DVec2::new(x, y) - edge.circle.center;
                assert!((spoke.length() - edge.circle.radius).abs() < 1e-9, "on the circle");
                assert!(spoke.dot(DVec2::new(1.0, slope)).abs() < 1e-7, "square to its radius");
                assert!(spoke.y * sign > 0.0, "on its own side");
                assert!((slope.atan() - (edge.angle + sign * half * edge.wedge)).abs() < 1e-6);
                let given = if sign > 0.0 { edge.suction_curvature } else { edge.pressure_curvature };
                assert!((curvature - given).abs() < 1e-5, "{curvature} instead of {given}");
            }
        }
        let points = BladeSection::points(&section.suction, 41);
        assert_eq!(points.len(), 41);
        assert!(points.windows(2).all(|w| w[0].x < w[1].x));
        assert!((points[40].x - section.suction.end).abs() < 1e-12);
    }

    #[test]
    fn edges_that_make_no_section_are_refused() {
        let [leading, trailing] = edges();
        let error = |leading, trailing| BladeSection::new(&leading, &trailing).unwrap_err();
        let flat = BladeEdge { circle: EdgeCircle { radius: 0.0, ..leading.circle }, ..leading };
        assert_eq!(error(flat, trailing), BladeSectionError::Radius("leading"));
        assert_eq!(error(trailing, leading), BladeSectionError::Order);
        let steep = BladeEdge { angle: 1.45, ..trailing };
        assert!(matches!(error(leading, steep), BladeSectionError::Steep("trailing", _)));
        assert_eq!(error(BladeEdge { wedge: f64::NAN, ..leading }, trailing), BladeSectionError::NotFinite);
    }
}
