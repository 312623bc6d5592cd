//! Gouging of neighbouring walls by the cutter, and of everything by its holder.

use glam::DVec3;

/// Which part of the tool comes near.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ToolPart {
    /// The flutes.
    Cutter,
    /// The part of the holder with this number, from below.
    Holder(usize),
}

/// The place of a path where a part of the tool is nearest to a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clearance {
    /// Which part.
    pub part: ToolPart,
    /// Distance (mm); negative by the depth where it gouges.
    pub distance_mm: f64,
    /// Where on the mesh.
    pub point: DVec3,
    /// At which t of the path.
    pub t: f64,
}

/// Least clearances of a path.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GougeCheck {
    /// Of the flutes from neighbouring walls; none if there are none.
    pub cutter: Option<Clearance>,
    /// Of the holder from everything; none without a holder.
    pub holder: Option<Clearance>,
}
