//! Why a mesh that two planes cut out of something is not taken for a sector of a wheel.

use super::MOST_TRIANGLES;
use crate::frame::axis::Axis;
use task::Cancelled;

/// Reason why a mesh that two planes cut out of something is not taken for a sector of a wheel.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SectorError {
    /// Cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// The blades of the sector are too few to tell their pitch.
    #[error(
        "the mesh is a sector of {angle_deg:.2} deg about the axis {axis}, which does not divide a full turn, and it holds \
         too few blades to tell their pitch: give the number of blades of the whole wheel with blisk.blades, or load a \
         larger sector"
    )]
    Pitch {
        /// Angle between the cuts (deg).
        angle_deg: f64,
        /// The axis.
        axis: Axis,
    },
    /// Not one whole pitch.
    #[error(
        "the mesh is a sector of {angle_deg:.4} deg about the axis {axis}, less than the {pitch_deg:.4} deg from blade to \
         blade of a wheel with {blades} blades: load a sector of one pitch at least"
    )]
    Narrow {
        /// Angle between the cuts (deg).
        angle_deg: f64,
        /// Angle from blade to blade (deg).
        pitch_deg: f64,
        /// Number of blades.
        blades: usize,
        /// The axis.
        axis: Axis,
    },
    /// The ends do not fit each other.
    #[error(
        "the mesh is a sector about the axis {axis}, but what lies {angle_deg:.2} deg apart in it is not congruent: at \
         x {x:.3}, r {r:.3} mm about the axis it is {off_mm:.3} mm off; check the axis and the number of blades, or load \
         the whole wheel, or a sector of one pitch or more"
    )]
    Unlike {
        /// Angle between the two ends (deg).
        angle_deg: f64,
        /// Distance (mm).
        off_mm: f64,
        /// Where (mm along the axis).
        x: f64,
        /// Where (mm from the axis).
        r: f64,
        /// The axis.
        axis: Axis,
    },
    /// The blades of the sector differ, and it cannot be told whether they repeat.
    #[error(
        "the mesh is a sector about the axis {axis}, and the blades of its {seen} pitches are not alike: {kinds} kinds \
         can only be told to repeat in a sector of {} pitches; load a larger sector or the whole wheel, or give the number of \
         blades with blisk.blades if they are main blades and splitters",
        2 * .kinds
    )]
    Kinds {
        /// Kinds of blades.
        kinds: usize,
        /// Pitches that were looked at.
        seen: usize,
        /// The axis.
        axis: Axis,
    },
    /// The wheel that is made of the sector shows another number of blades than it is made with.
    #[error(
        "the mesh is a sector about the axis {axis}, and its blades follow each other as those of a wheel of {made} do, but \
         {counted} are counted around the wheel that is made of it: give the number of blades of the whole wheel with \
         blisk.blades, or load a larger sector"
    )]
    Count {
        /// Number of blades that the wheel is made with.
        made: usize,
        /// Number of blades that are counted around it.
        counted: usize,
        /// The axis.
        axis: Axis,
    },
    /// The whole wheel would be too large.
    #[error(
        "the whole wheel of this sector would have {triangles} triangles, more than {MOST_TRIANGLES}: load a coarser mesh"
    )]
    TooLarge {
        /// Triangles of the whole wheel.
        triangles: usize,
    },
    /// The mesh cannot be searched.
    #[error("{0}")]
    Mesh(String),
    /// The ends fit, but joined they do not close the surface.
    #[error(
        "the mesh is a sector of {angle_deg:.2} deg about the axis {axis}, but its turned copies do not close to a wheel: \
         edges remain that one triangle meets; load the whole wheel"
    )]
    Open {
        /// Angle between the two ends (deg).
        angle_deg: f64,
        /// The axis.
        axis: Axis,
    },
}

impl SectorError {
    /// The axis of the sector.
    pub(crate) fn axis(&self) -> Option<Axis> {
        match self {
            Self::Pitch { axis, .. }
            | Self::Narrow { axis, .. }
            | Self::Unlike { axis, .. }
            | Self::Kinds { axis, .. }
            | Self::Count { axis, .. }
            | Self::Open { axis, .. } => Some(*axis),
            Self::Cancelled(_) | Self::Mesh(_) | Self::TooLarge { .. } => None,
        }
    }
}
