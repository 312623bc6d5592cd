//! A flank path: where the cutter goes, how far it is off, and whether that holds while it moves.

use glam::DVec3;
use serde::Serialize;

use super::FlankError;
use super::axis_surface::AxisSurface;
use super::compensation::Measured;
use super::cutter::FlankCutter;
use super::deviation::{DesignGrid, Deviation, Feet};
use super::envelope::{self, EnvelopeCheck};

/// A place of the cutter on a path.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FlankPose {
    /// Parameter of the path, 0 to 1.
    pub t: f64,
    /// Centre of the bottom circle (mm).
    pub tip: DVec3,
    /// Unit vector of the axis, from the bottom up.
    pub axis: DVec3,
}

/// Coverage of the surface by a path.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Coverage {
    /// Least and greatest parameter of the path where it stands over the surface or, moving, grazes it; 0 and 1 of a
    /// closed path.
    pub t_range: [f64; 2],
    /// Least and greatest height (mm) of the flute above the bottom circle that touches or is nearest to the surface.
    pub height_range_mm: [f64; 2],
    /// Whether the path begins before and ends behind the surface.
    pub is_whole: bool,
}

/// A path of the cutter.
#[derive(Debug, Clone, PartialEq)]
pub struct FlankPath {
    /// The surface that its axis sweeps, from the height that touches the lower guide.
    pub axis: AxisSurface,
    /// Depth of the cutter's bottom below that height (mm).
    pub below_mm: f64,
    /// Places along it, as many as locations were asked for.
    pub poses: Vec<FlankPose>,
    /// Deviation of the standing cutter over the design surface.
    pub deviation: Deviation,
    /// Foot points of the axis over the samples of the grid.
    pub feet: Feet,
    /// Coverage of the surface.
    pub coverage: Coverage,
    /// Deviation of the moving cutter.
    pub envelope: EnvelopeCheck,
}

impl FlankPath {
    /// The path with all that is to be known of it, and `poses` places along it. `cutter` is what touches: the one
    /// above `below_mm`.
    pub(super) fn of(grid: &DesignGrid, cutter: &FlankCutter, path: Measured, (poses, below_mm): (usize, f64)) -> Self {
        let Measured { axis, deviation, feet, .. } = path;
        let envelope = envelope::check(grid, &axis, cutter, (&deviation, &feet));
        let coverage = coverage((&axis, below_mm), cutter, &feet, &envelope);
        let poses = (0..poses).map(|i| pose(&axis, below_mm, i as f64 / (poses.max(2) - 1) as f64)).collect();
        Self { axis, below_mm, poses, deviation, feet, coverage, envelope }
    }

    /// Results over another grid: deviation of the static cutter and where it stands, coverage, and the moving cutter.
    /// `cutter` is the part that touches.
    ///
    /// # Errors
    /// [`FlankError::Unmeasured`] if no place of the axis stands over some place.
    pub(super) fn over(
        &self,
        grid: &DesignGrid,
        cutter: &FlankCutter,
    ) -> Result<((Deviation, Feet), Coverage, EnvelopeCheck), FlankError> {
        let (deviation, feet) = grid.deviation(&self.axis, cutter, None)?;
        let envelope = envelope::check(grid, &self.axis, cutter, (&deviation, &feet));
        let coverage = coverage((&self.axis, self.below_mm), cutter, &feet, &envelope);
        Ok(((deviation, feet), coverage, envelope))
    }

    /// For each place of the grid the height (mm) of the flute above the bottom circle that touches it or is nearest to
    /// it. `cutter` is the part that touches.
    pub fn contact_heights(&self, cutter: &FlankCutter) -> impl Iterator<Item = f64> {
        contact_heights((&self.axis, self.below_mm), cutter, &self.feet)
    }

    /// The cutter at `t`, from 0 to 1.
    pub fn pose(&self, t: f64) -> FlankPose {
        pose(&self.axis, self.below_mm, t)
    }
}

/// Heights (mm) above the bottom circle in which the flutes touch or are nearest to the places that `feet` are under.
fn contact_heights(
    (axis, below_mm): (&AxisSurface, f64),
    cutter: &FlankCutter,
    feet: &Feet,
) -> impl Iterator<Item = f64> {
    feet.at.iter().map(move |q| below_mm + cutter.contact_height(q.y * axis.at(q.x).length()))
}

/// Coverage by a path whose axis stands at `feet` over the surface.
fn coverage(
    (axis, below_mm): (&AxisSurface, f64),
    cutter: &FlankCutter,
    feet: &Feet,
    envelope: &EnvelopeCheck,
) -> Coverage {
    let widest = |[low, high]: [f64; 2], h: f64| [low.min(h), high.max(h)];
    let heights = contact_heights((axis, below_mm), cutter, feet);
    let height_range_mm = heights.fold([f64::INFINITY, f64::NEG_INFINITY], widest);
    let ([first, last], [grazes_first, grazes_last]) = (feet.t_range(), envelope.t_range);
    let t_range = if axis.is_closed() { [0.0, 1.0] } else { [first.min(grazes_first), last.max(grazes_last)] };
    Coverage { t_range, height_range_mm, is_whole: t_range[0] >= 0.0 && t_range[1] <= 1.0 }
}

/// The cutter at `t` of an axis surface, its bottom `below_mm` below the tip there.
fn pose(axis: &AxisSurface, below_mm: f64, t: f64) -> FlankPose {
    let at = axis.at(t);
    let direction = at.axis();
    FlankPose { t, tip: at.tip - below_mm * direction, axis: direction }
}
