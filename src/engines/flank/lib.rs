//! Five-axis flank milling of ruled surfaces with cylinders and cones (P4): where the cutter stands so that it touches
//! the surface at two or three points, the surface that its axis sweeps, how far the cutter is off the design surface,
//! and paths that are off least.
//!
//! `GuideCurve -> RuledSurface -> CutterLocation -> AxisSurface -> Deviation -> FlankPlan`; [`plan::plan_flank`] does
//! it all. Deviations are positive where stock is left (undercut) and negative where too much is taken (overcut).
//!
//! Sums of deviations are those of a fixed grid of the design surface, so that no path gets better by leaving the
//! part. The static deviation of each location is not that of the moving cutter: [`envelope`] gives the latter.

mod advance;
pub mod axis_surface;
pub mod check_grid;
pub mod compensation;
pub mod cutter;
pub mod deviation;
mod edges;
pub mod envelope;
pub mod fit_ruled;
pub mod frustum_distance;
pub mod gouge;
pub mod guide;
pub mod guide_joining;
pub mod heights;
pub mod inside_wall;
pub mod machine;
pub mod offset;
pub mod own_leads;
pub mod own_surface;
pub mod params;
pub mod path;
pub mod plan;
pub mod refine;
pub mod ruled_surface;
#[cfg(test)]
mod tests;
pub mod walls;
pub mod warning;

use glam::DVec3;

use geometry::nurbs::NurbsError;
use task::Cancelled;

/// Reason why there is no flank path.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FlankError {
    /// A guide curve that cannot be made.
    #[error("the {which} guide curve: {reason}")]
    Guide {
        /// Name of the guide: lower, upper.
        which: &'static str,
        /// Reason why not.
        reason: NurbsError,
    },
    /// A row of points that is no curve.
    #[error("the {which} guide curve: {problem}")]
    Points {
        /// Name of the guide: lower, upper.
        which: &'static str,
        /// Problem, with the number of the point, counted from 1.
        problem: String,
    },
    /// Too few points in a file.
    #[error("a guide curve needs two points at least, and there are {found}; write x, y, z (mm) of one on each line")]
    TooFewPoints {
        /// How many there are.
        found: usize,
    },
    /// A point twice in a row.
    #[error("guide curve, line {line}: the point is the same as that of line {before}; leave one of them out")]
    SamePoint {
        /// Number of the line, from 1.
        line: usize,
        /// Number of the point before.
        before: usize,
    },
    /// A line of points that cannot be read.
    #[error(
        "guide curve, line {line}: {text:?} is no point; write x, y, z in mm, separated by commas, semicolons or \
         blanks; numbers with decimal commas are separated by semicolons or blanks"
    )]
    Unreadable {
        /// Number of the line, from 1.
        line: usize,
        /// Text found.
        text: String,
    },
    /// A row with more points than a guide needs.
    #[error("a guide curve has more than {most} points; leave out points where they stand close together")]
    TooManyPoints {
        /// The most there may be.
        most: usize,
    },
    /// Guide curves that meet.
    #[error(
        "the guide curves come within {distance_mm:.4} mm of each other at u = {lower_u:.4} of the lower and \
         {upper_u:.4} of the upper one: they cross or touch; shorten them, or give two that stay apart"
    )]
    GuidesMeet {
        /// How near (mm).
        distance_mm: f64,
        /// Where on the lower curve.
        lower_u: f64,
        /// Where on the upper curve.
        upper_u: f64,
    },
    /// A surface that turns over.
    #[error(
        "the ruled surface folds over at u = {u:.4}, v = {v:.4}: neighbouring rulings cross there; reverse one of the \
         guide curves, or match their parameters"
    )]
    Folds {
        /// Along the guides.
        u: f64,
        /// Along the ruling.
        v: f64,
    },
    /// A side that only the user can know.
    #[error(
        "on which side of the surface the cutter stands must be said: at the surface's middle, ({:.2}, {:.2}, {:.2}), \
         the positive side is towards ({:.2}, {:.2}, {:.2}) and the negative side opposite; choose the one away from \
         the part",
        point.x, point.y, point.z, normal.x, normal.y, normal.z
    )]
    SideOpen {
        /// The middle of the surface (mm).
        point: DVec3,
        /// Unit vector to the positive side there.
        normal: DVec3,
    },
    /// A surface that turns too far along a ruling.
    #[error(
        "the normal turns by {turn_deg:.0} deg along the ruling at u = {u:.4}: no straight cutter lies along a ruling \
         that turns by 90 deg or more; reverse one guide if they run against each other, divide the surface, or match \
         the guide curves' parameters"
    )]
    Twisted {
        /// Along the guides.
        u: f64,
        /// By how much (deg).
        turn_deg: f64,
    },
    /// A parameter that is not usable.
    #[error("{name} is {value}: it must be {wanted}")]
    Parameter {
        /// Name.
        name: &'static str,
        /// Value.
        value: f64,
        /// Range of valid values.
        wanted: &'static str,
    },
    /// A cutter whose flutes end below the upper guide.
    #[error(
        "the flutes are {length_mm:.3} mm long and must be {needed_mm:.3} mm to reach the upper guide curve at u = \
         {u:.3}; take a longer cutter or divide the surface along v"
    )]
    CutterTooShort {
        /// Length of the flutes (mm).
        length_mm: f64,
        /// Length needed (mm).
        needed_mm: f64,
        /// Where along the guides.
        u: f64,
    },
    /// A cutter that does not fit into a hollow of the surface.
    #[error(
        "the cutter's radius is {radius_mm:.3} mm at u = {u:.3}, v = {v:.3} where the surface is hollow with a radius \
         of only {hollow_mm:.3} mm; take a cutter of less than that, or the other side of the surface"
    )]
    CutterTooThick {
        /// Radius of the cutter there, along the normal (mm).
        radius_mm: f64,
        /// The surface's least concave radius there (mm).
        hollow_mm: f64,
        /// Along the guides.
        u: f64,
        /// Along the ruling.
        v: f64,
    },
    /// An offset that has no solution.
    #[error("no cutter touches both guide curves at u0 = {u0:.4}, u1 = {u1:.4}: {reason}")]
    NoLocation {
        /// On the lower guide.
        u0: f64,
        /// On the upper guide.
        u1: f64,
        /// Reason why not.
        reason: &'static str,
    },
    /// Places of the surface that no place of the axis stands over.
    #[error(
        "{count} places of the surface, the first at u = {u:.3}, v = {v:.3}, have no place of the axis over them: the \
         path is too far from the surface for its deviation to be measured; take a thinner cutter, the other side of \
         the surface, or divide the surface"
    )]
    Unmeasured {
        /// Number of places.
        count: usize,
        /// Along the guides.
        u: f64,
        /// Along the ruling.
        v: f64,
    },
    /// A system that has no solution.
    #[error("{0} has no solution in finite numbers")]
    Singular(&'static str),
    /// Cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
