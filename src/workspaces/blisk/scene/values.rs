//! Quantities shown as colours.

use glam::DVec3;
use rayon::prelude::*;

use feed::pose::Pose;
use geometry::exact::ExactMesh;
use task::{Cancel, Cancelled};
use wheel::electrode::Electrode;

/// Vertices between two looks at the cancel flag.
const BLOCK: usize = 4096;

/// Distance (mm, negative in metal) from every vertex of `electrode` at `pose` to the finished `blisk`, in W.
///
/// # Errors
/// When told to stop.
pub fn clearance_at_vertices(
    electrode: &Electrode,
    blisk: &ExactMesh,
    pose: &Pose,
    cancel: &Cancel,
) -> Result<Vec<f32>, Cancelled> {
    let placement = pose.placement(electrode.reference_point);
    let distance = |p: &DVec3| blisk.nearest(placement.transform_point3(*p)).signed_distance as f32;
    let mut values = Vec::with_capacity(electrode.mesh.vertices.len());
    for block in electrode.mesh.vertices.chunks(BLOCK) {
        cancel.check()?;
        values.par_extend(block.par_iter().map(distance));
    }
    Ok(values)
}
