//! What is left of a mold as one list of regions with their surface, whichever way it was found.

use glam::DVec3;

use super::uncut::{Uncut, UncutError};
use super::uncut_preview::{CoarseCell, look};
use crate::geometry::mesh::{Bounds, Mesh};
use crate::mold::surface::SurfacePiece;
use crate::progress::Cancel;

/// Cells of the field of heights whose cells stand in for the surface.
const CELLS: f64 = 400e3;

/// A connected piece of what is left.
#[derive(Debug, Clone, PartialEq)]
pub struct LeftRegion {
    /// Volume (mm^3).
    pub volume: f64,
    /// Area seen from the cutter (mm^2).
    pub plan_area: f64,
    /// Greatest height (mm).
    pub depth: f64,
    /// Box around it in the axes of the mesh (mm).
    pub bounds: Bounds,
    /// The cutter of the library that comes nearest.
    pub nearest_cutter: Option<usize>,
}

/// Everything that is left.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Left {
    /// The regions, the largest volume first, as reports count them.
    pub regions: Vec<LeftRegion>,
    /// The mold's surface under them, with places in `regions`; the opening looks along +Z.
    pub surface: Vec<SurfacePiece>,
}

/// What is left of `mesh` according to `uncut`.
///
/// # Errors
/// [`UncutError`].
pub fn left(uncut: &Uncut, mesh: &Mesh, cancel: &Cancel) -> Result<Left, UncutError> {
    let mut upright: Vec<LeftRegion> = if uncut.is_of_flats() {
        let region = |r: &crate::mold::region::UncutRegion| LeftRegion {
            volume: r.volume,
            plan_area: r.plan_area,
            depth: r.height,
            bounds: r.bounds,
            nearest_cutter: None,
        };
        uncut.flat_regions.iter().map(region).collect()
    } else {
        let region = |r: &crate::mold::height_field::UncutRegion| LeftRegion {
            volume: r.volume,
            plan_area: r.plan_area,
            depth: r.depth,
            bounds: r.bounds,
            nearest_cutter: Some(r.nearest_cutter),
        };
        uncut.field_regions.iter().map(region).collect()
    };
    upright.sort_by(|a, b| b.volume.total_cmp(&a.volume));
    let params = &uncut.params;
    let coarse = look(mesh, params.opening, &params.library, params.tolerance_mm, CELLS, cancel)?;
    let mut surface = Vec::new();
    for cell in coarse.regions.iter().flat_map(|r| &r.cells) {
        if let Some(region) = region_at(&upright, cell, coarse.step) {
            surface.extend(pieces(cell, region));
        }
    }
    let in_mesh = |r: LeftRegion| {
        let ends = [r.bounds.min, r.bounds.max].map(|p| params.opening.in_mesh(p));
        LeftRegion { bounds: Bounds::of(ends), ..r }
    };
    Ok(Left { regions: upright.into_iter().map(in_mesh).collect(), surface })
}

/// The smallest region whose box holds the middle of a cell.
fn region_at(regions: &[LeftRegion], cell: &CoarseCell, step: f64) -> Option<u32> {
    let middle = cell.corners.iter().sum::<DVec3>() / 4.0;
    let holds = |r: &&LeftRegion| {
        let Bounds { min, max } = r.bounds.grown(step);
        min.cmple(middle).all() && middle.cmple(max).all()
    };
    // They come in falling order of their volumes.
    regions.iter().rposition(|r| holds(&r)).and_then(|i| u32::try_from(i).ok())
}

/// A cell as two triangles.
pub fn pieces(cell: &CoarseCell, region: u32) -> [SurfacePiece; 2] {
    let [a, b, c, d] = cell.corners;
    [[a, b, c], [a, c, d]].map(|corners| SurfacePiece { corners, face: u32::MAX, region, depth: [cell.depth; 3] })
}
