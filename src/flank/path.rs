//! A flank path: where the cutter goes, how far it is off, and whether that holds while it moves.

use glam::DVec3;

use super::axis_surface::AxisSurface;
use super::deviation::{Deviation, Feet};
use super::envelope::EnvelopeCheck;

/// A place of the cutter on a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlankPose {
    /// Parameter of the path, 0 to 1.
    pub t: f64,
    /// Centre of the bottom circle (mm).
    pub tip: DVec3,
    /// Unit vector of the axis, from the bottom up.
    pub axis: DVec3,
}

/// What a path covers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coverage {
    /// Least and greatest parameter of the path that stands over the surface.
    pub t_range: [f64; 2],
    /// Least and greatest height (mm) of the flute above the bottom circle that touches or is nearest to the surface.
    pub height_range_mm: [f64; 2],
    /// Whether the path begins before and ends behind the surface.
    pub is_whole: bool,
}

/// A path of the cutter.
#[derive(Debug, Clone, PartialEq)]
pub struct FlankPath {
    /// The surface that its axis sweeps.
    pub axis: AxisSurface,
    /// Places along it, as many as locations were asked for.
    pub poses: Vec<FlankPose>,
    /// Deviation of the standing cutter over the design surface.
    pub deviation: Deviation,
    /// Where the axis stands over the places of the grid.
    pub feet: Feet,
    /// What it covers.
    pub coverage: Coverage,
    /// Deviation of the moving cutter.
    pub envelope: EnvelopeCheck,
}

impl FlankPath {
    /// The cutter at `t`, from 0 to 1.
    pub fn pose(&self, t: f64) -> FlankPose {
        pose(&self.axis, t)
    }
}

/// The cutter at `t` of an axis surface.
pub fn pose(axis: &AxisSurface, t: f64) -> FlankPose {
    let at = axis.at(t);
    FlankPose { t, tip: at.tip, axis: at.axis() }
}
