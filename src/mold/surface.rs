//! The surface of a mold under what is left.

use glam::DVec3;

/// Part of a mold's triangle that bounds what is left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePiece {
    /// Its corners, counter-clockwise seen from outside (mm), the opening looking along +Z.
    pub corners: [DVec3; 3],
    /// Triangle of the mesh.
    pub face: u32,
    /// Place in the list of regions.
    pub region: u32,
    /// Height of what is left above each corner (mm).
    pub depth: [f32; 3],
}
