//! The curve of one axis over the withdrawn distance.

use serde::{Deserialize, Serialize};

use geometry::nurbs::{BSpline, NurbsError};
use geometry::spline::{CubicSpline, EndCondition, SplineError};

/// Kind of curve that joins the nodes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CurveKind {
    /// Cubic splines with the nodes as knots (P0).
    #[default]
    Spline,
    /// Interpolating B-splines with averaged knots (P1). Their parameter is the withdrawn distance, which is the chord
    /// length along X, so that X stays linear.
    Nurbs,
}

/// Curve through the nodes with its parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Joining {
    /// Cubic spline with this end condition.
    Spline(EndCondition),
    /// NURBS curve of this degree.
    Nurbs(usize),
}

impl From<EndCondition> for Joining {
    fn from(ends: EndCondition) -> Self {
        Self::Spline(ends)
    }
}

/// Reason why nodes cannot be joined.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum CurveError {
    /// By a cubic spline.
    #[error(transparent)]
    Spline(#[from] SplineError),
    /// By a B-spline.
    #[error(transparent)]
    Nurbs(#[from] NurbsError),
}

/// The curve of one axis.
#[derive(Debug, Clone, PartialEq)]
pub enum AxisCurve {
    /// A cubic spline.
    Spline(CubicSpline),
    /// A B-spline.
    Nurbs(BSpline),
}

impl AxisCurve {
    /// The curve with `values[i]` at `s[i]`.
    ///
    /// # Errors
    /// If there are fewer than 2 values or `s` does not rise.
    pub fn through(s: &[f64], values: &[f64], joining: Joining) -> Result<Self, CurveError> {
        Ok(match joining {
            Joining::Spline(ends) => Self::Spline(CubicSpline::new(s, values, ends)?),
            Joining::Nurbs(degree) => Self::Nurbs(BSpline::through(s, values, degree)?),
        })
    }

    /// Withdrawn distances of the nodes (mm).
    pub fn knots(&self) -> &[f64] {
        match self {
            Self::Spline(curve) => curve.knots(),
            Self::Nurbs(curve) => curve.parameters(),
        }
    }

    /// Value, first and second derivative at `s`; beyond the ends the end pieces continue.
    pub fn at(&self, s: f64) -> [f64; 3] {
        match self {
            Self::Spline(curve) => curve.at(s),
            Self::Nurbs(curve) => curve.at(s),
        }
    }

    /// A bound on the size of the second derivative between nodes `i` and `i + 1`.
    pub fn greatest_second(&self, i: usize) -> f64 {
        match self {
            Self::Spline(curve) => curve.greatest_second(i),
            Self::Nurbs(curve) => curve.greatest_second(i),
        }
    }
}
