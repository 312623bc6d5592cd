//! Non-uniform rational B-splines: curves, tensor product surfaces and functions of one variable, with the fits that
//! P1 (NURBS centreline planning) rebuilds blades by: parameters by cumulative chord length, averaged knots,
//! interpolation with given end tangents from a banded system, and skinning over sections.
//!
//! All of it is our own. The crate `curvo` evaluates and interpolates such curves too, but would bring some twenty
//! further crates for what is a page of code here, and has neither end tangents nor fit errors.
//!
//! Guaranteed: an interpolation passes through its points to rounding and has `degree - 1` continuous derivatives.
//! Not guaranteed: that the curve between the points is near to what they were measured on; see [`FitError`].
//!
//! ```
//! use glam::DVec3;
//! use geometry::nurbs::NurbsCurve;
//! let points: Vec<DVec3> = (0..9).map(|i| 0.2 * f64::from(i)).map(|t| DVec3::new(t.cos(), t.sin(), t)).collect();
//! let curve = NurbsCurve::through(&points, 3)?;
//! let [start, end] = curve.domain();
//! assert!((curve.point(start) - points[0]).length() < 1e-12 && (curve.point(end) - points[8]).length() < 1e-12);
//! assert!(points.iter().all(|p| curve.nearest(*p).distance < 1e-9));
//! # Ok::<(), geometry::nurbs::NurbsError>(())
//! ```

mod banded;
mod curve;
mod fit;
mod function;
mod knots;
mod surface;
#[cfg(test)]
mod tests;

pub use curve::{NearestOnCurve, NurbsCurve};
pub use fit::{FitError, LineShape, chord_parameters};
pub use function::BSpline;
pub use knots::{KnotVector, MAX_DEGREE};
pub use surface::NurbsSurface;

/// Reason why there is no such curve or surface.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum NurbsError {
    /// Too few points, or unequal numbers of things that belong together.
    #[error("a NURBS needs at least 2 points, and as many weights, parameters and points in each section")]
    Counts,
    /// A degree that is not supported.
    #[error("NURBS of degree {0} are not supported; take 1 to {MAX_DEGREE}")]
    Degree(usize),
    /// A knot vector that does not fit its degree and number of points.
    #[error("NURBS knot {0} falls below the one before, or is repeated too often")]
    Knots(usize),
    /// Two neighbouring points that coincide, or parameters that do not rise.
    #[error("NURBS point {0} coincides with the one before, or its parameter does not rise")]
    Coincident(usize),
    /// A weight that is not positive, or a coordinate that is no number.
    #[error("NURBS point {0} has a weight that is not positive or a coordinate that is no number")]
    Value(usize),
    /// Points so uneven that their interpolation cannot be solved for.
    #[error("these points are too unevenly spaced to be interpolated by a NURBS")]
    Singular,
}
