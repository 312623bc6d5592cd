//! Parameters of the fit of a ruled surface, and its errors.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use geometry::nurbs::NurbsError;
use task::Cancelled;

/// Number of control points of each guide while ways to divide the border are tried.
pub(super) const FIRST_COUNT: usize = 7;

/// The base of a part, which is not milled: an electrode's blank, or its shank and holder.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PartBase {
    /// Direction from the part to its base.
    pub towards: DVec3,
    /// Coordinate along that direction from which on all is base (mm); without it the faces that reach to the end of the
    /// part are.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from_mm: Option<f64>,
}

impl PartBase {
    /// The base that is at the end of the part in this direction.
    pub fn at_end(towards: DVec3) -> Self {
        Self { towards, from_mm: None }
    }
}

/// Parameters of the fit of a ruled surface.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RuledFitParams {
    /// Greatest distance between the face and a surface that it is said to be (mm).
    pub tolerance_mm: f64,
    /// Control points that each guide may have at most; 7 or more.
    pub most_control_points: usize,
    /// Upward direction, from the lower guide to the upper one. Of two equal ways to rule a face the rulings that run
    /// along it are taken.
    pub up: DVec3,
    /// Base of the part, if it has one: faces that are clear of it come first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub base: Option<PartBase>,
}

impl Default for RuledFitParams {
    fn default() -> Self {
        Self { tolerance_mm: 0.01, most_control_points: 131, up: DVec3::Z, base: None }
    }
}

impl RuledFitParams {
    /// Whether a fit can be made with them.
    ///
    /// # Errors
    /// [`RuledFitError::Params`] with the key and what it must be.
    pub fn validate(&self) -> Result<(), RuledFitError> {
        if !(self.tolerance_mm > 0.0 && self.tolerance_mm.is_finite()) {
            return Err(RuledFitError::Params("tolerance_mm must be greater than 0"));
        }
        if !(FIRST_COUNT..=259).contains(&self.most_control_points) {
            return Err(RuledFitError::Params("most_control_points must be 7 to 259"));
        }
        if !self.up.is_finite() || self.up.length() < 1e-9 {
            return Err(RuledFitError::Params("up must be a direction"));
        }
        if let Some(PartBase { towards, from_mm }) = self.base {
            if !towards.is_finite() || towards.length() < 1e-9 {
                return Err(RuledFitError::Params("base.towards must be a direction"));
            }
            if from_mm.is_some_and(|from| !from.is_finite()) {
                return Err(RuledFitError::Params("base.from_mm must be a number"));
            }
        }
        Ok(())
    }
}

/// Reason why no ruled surface is fitted.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RuledFitError {
    /// A parameter without meaning.
    #[error("the fit of a ruled surface cannot be made: {0}")]
    Params(&'static str),
    /// A triangle that the mesh has not.
    #[error("the face names triangle {0}, which the mesh does not have")]
    NoTriangle(u32),
    /// A triangle with a corner that is no point.
    #[error("triangle {0} of the face has a corner that is no point")]
    NoPoint(u32),
    /// No triangles, or such without area.
    #[error("the face has no area; choose one that has")]
    NoArea,
    /// Three triangles at one side.
    #[error(
        "the face branches at ({:.3}, {:.3}, {:.3}): three triangles share a side there; choose fewer faces",
        .0.x, .0.y, .0.z
    )]
    Branching(DVec3),
    /// No border at all.
    #[error("the face is closed, it has no border that guides could follow; choose a part of it")]
    Closed,
    /// Cancelled.
    #[error("cancelled")]
    Cancelled,
    /// No four sides.
    #[error(
        "the border of the face has no four sides, two guides and two end rulings; choose another one, which is a \
         strip: faces that go over into each other smoothly are one flank together in the list"
    )]
    NoSides,
    /// Triangles to which no distance can be measured.
    #[error("no distances to the triangles of the face can be measured: {0}; repair the mesh")]
    NoDistances(String),
    /// Guides that cannot be made.
    #[error("no guides follow the border of the face: {0}")]
    Guides(#[from] NurbsError),
}

impl From<Cancelled> for RuledFitError {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}
