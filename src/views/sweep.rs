//! The room that an electrode passes through, as a shape.

use std::sync::Arc;

use glam::{DAffine3, DVec3};

use super::track::Track;
use crate::blisk::electrode::Electrode;
use crate::geometry::mesh::Bounds;
use crate::geometry::swept::{SweptError, SweptSurface};
use crate::progress::{Cancel, Progress};
use crate::render::mesh::RenderMesh;

/// Cells of the lattice that the surface is made on: cells of some tenths of a millimetre.
const CELLS: usize = 1_000_000;

/// The surface that `electrode` sweeps along `track`, in W. Takes seconds.
///
/// # Errors
/// If there is no way, or when told to stop.
pub fn swept_shape(
    electrode: &Electrode,
    track: &Track,
    progress: &Progress,
    cancel: &Cancel,
) -> Result<Arc<RenderMesh>, SweptError> {
    let placements = placements(electrode, track);
    let swept = SweptSurface::new(&electrode.mesh, &placements, CELLS, progress, cancel)?;
    cancel.check()?;
    Ok(Arc::new(RenderMesh::new(&swept.mesh)))
}

/// Where the electrode is along `track`, in W, so often that no point of it goes much further than
/// [`SweptSurface::STEP`] from one to the next.
pub fn placements(electrode: &Electrode, track: &Track) -> Vec<DAffine3> {
    let Bounds { min, max } = electrode.mesh.bounds();
    let corners: [DVec3; 8] =
        std::array::from_fn(|i| DVec3::select(glam::BVec3::new(i & 1 > 0, i & 2 > 0, i & 4 > 0), max, min));
    let o = electrode.reference_point;
    let mut placements: Vec<DAffine3> = track.stations().iter().take(1).map(|s| s.pose.placement(o)).collect();
    for pair in track.stations().windows(2) {
        let [from, to] = [pair[0].pose, pair[1].pose].map(|p| p.placement(o));
        let moved = corners.map(|c| from.transform_point3(c).distance(to.transform_point3(c)));
        let steps = (moved.into_iter().fold(0.0, f64::max) / SweptSurface::STEP).ceil().max(1.0);
        let at = |i: usize| pair[0].pose.lerp(&pair[1].pose, i as f64 / steps).placement(o);
        placements.extend((1..=steps as usize).map(at));
    }
    placements
}
