//! Thin regions that flat cutters leave and the field of heights is too coarse for: whether rounded cutters take them is
//! found on a finer grid over each of them.

use glam::DVec3;
use rayon::prelude::*;

use super::{UncutError, UncutParams};
use geometry::mesh::Mesh;
use mold::cutter::{Cutter, CutterKind, CutterLibrary};
use mold::height_field::{FieldRegion, HeightField, HeightFieldError, closing_within, left_at_most, regions};
use mold::region::LayerRegion;
use mold::warning::MoldWarning;
use task::Cancel;

/// Cells that a region is thick from which on a field of heights cannot miss it.
const THIN: f64 = 3.0;
/// Cells of the finer grid that a region is thick, and that the tolerance is: what is left is seen from three cells on, so
/// that slivers up to a fifth above the tolerance may be missed.
const CELLS: f64 = 3.0;
const CELLS_OF_TOLERANCE: f64 = 2.5;
/// Cells of all finer grids together, at most.
const MOST_CELLS: f64 = 64e6;

/// Answer about a region.
enum Answer {
    /// A cutter takes it.
    Taken,
    /// All cutters leave it, at most as thick as this across the surface (mm), also at this place.
    Left(f64, DVec3),
    /// The region is too thin for any grid that there is room for.
    Unknown,
}

/// Warnings about thin regions that flat cutters leave where the field finds nothing: those that every cutter leaves,
/// and those of which it is not known.
///
/// # Errors
/// [`UncutError`].
pub(super) fn thin_regions(
    (mesh, field): (&Mesh, &HeightField),
    (flat, found): (&[LayerRegion], &[FieldRegion]),
    params: &UncutParams,
    cancel: &Cancel,
) -> Result<Vec<MoldWarning>, UncutError> {
    let is_found = |r: &LayerRegion| found.iter().any(|f| f.bounds.grown(field.step()).intersects(&r.bounds));
    let thin: Vec<&LayerRegion> = flat.iter().filter(|r| r.residue() < THIN * field.step() && !is_found(r)).collect();
    let mut cutters = params.library.needed();
    cutters.sort_by(|a, b| a.radius().total_cmp(&b.radius()).then(a.corner_mm.total_cmp(&b.corner_mm)));
    let tolerance = params.tolerance_mm;
    let look = CloserLook { mesh, field, cutters, tolerance, most: MOST_CELLS / thin.len().max(1) as f64 };
    let answers: Vec<Answer> = thin.par_iter().map(|region| look.at(region, cancel)).collect::<Result<_, _>>()?;
    let mut warnings = Vec::new();
    let left = answers.iter().filter_map(|answer| match answer {
        Answer::Left(thickness, place) => Some((*thickness, *place)),
        _ => None,
    });
    let left: Vec<(f64, DVec3)> = left.collect();
    if let Some((thickness, place)) = left.iter().max_by(|a, b| a.0.total_cmp(&b.0)) {
        let place = params.opening.in_mesh(*place).to_array();
        warnings.push(MoldWarning::SliversLeft { regions: left.len(), thickness: *thickness, place });
    }
    let unknown = thin.iter().zip(&answers).filter(|(_, answer)| matches!(answer, Answer::Unknown));
    let unknown: Vec<f64> = unknown.map(|(region, _)| region.residue()).collect();
    if !unknown.is_empty() {
        let thickness = unknown.iter().copied().fold(0.0, f64::max);
        warnings.push(MoldWarning::ThinRegions { regions: unknown.len(), thickness });
    }
    Ok(warnings)
}

struct CloserLook<'a> {
    mesh: &'a Mesh,
    field: &'a HeightField,
    /// The smallest first.
    cutters: Vec<&'a Cutter>,
    tolerance: f64,
    /// Cells of each finer grid, at most.
    most: f64,
}

impl CloserLook<'_> {
    /// Whether cutters take a region: mostly the smallest ones show it, by their tips that touch it alone.
    fn at(&self, region: &LayerRegion, cancel: &Cancel) -> Result<Answer, UncutError> {
        let smallest = |is_flat: bool| self.cutters.iter().find(|c| (c.kind() == CutterKind::Flat) == is_flat);
        let both: Vec<&&Cutter> = [true, false].into_iter().filter_map(smallest).collect();
        if let Answer::Taken = self.left_by(&both, region, true, cancel)? {
            return Ok(Answer::Taken);
        }
        match self.left_by(&self.cutters.iter().collect::<Vec<_>>(), region, false, cancel)? {
            // The smallest rounded one asks for less room.
            Answer::Unknown => match self.left_by(smallest(false).as_slice(), region, false, cancel)? {
                Answer::Taken => Ok(Answer::Taken),
                Answer::Left(..) | Answer::Unknown => Ok(Answer::Unknown),
            },
            known => Ok(known),
        }
    }

    /// What some cutters leave of a region; if `by_touching`, it is found only whether tips that touch it take it.
    fn left_by(
        &self,
        cutters: &[&&Cutter],
        region: &LayerRegion,
        by_touching: bool,
        cancel: &Cancel,
    ) -> Result<Answer, UncutError> {
        let library = CutterLibrary { cutter: cutters.iter().map(|cutter| (**cutter).clone()).collect() };
        let widest = |cutter: &Cutter| cutter.radius() + cutter.holder().map_or(cutter.radius(), |(radius, _)| radius);
        let reach = library.cutter.iter().map(widest).fold(0.0, f64::max);
        let least = library.cutter.iter().map(|cutter| cutter.diameter_mm).fold(f64::INFINITY, f64::min);
        let finest = (region.residue() / CELLS).min(self.tolerance / CELLS_OF_TOLERANCE);
        // The smallest cutter is a whole number of cells wide.
        let step = least / (least / finest).ceil();
        // Some cells more than the region has, in which its own are inner ones.
        let around = region.bounds.grown(4.0 * step);
        let asked = [around.min.truncate(), around.max.truncate()];
        let plan = [asked[0] - reach, asked[1] + reach];
        let size = (plan[1] - plan[0]) / step;
        if size.x * size.y > self.most {
            return Ok(Answer::Unknown);
        }
        let left = || -> Result<_, HeightFieldError> {
            let field = self.field.closer(self.mesh, plan, step, cancel)?;
            let left = if by_touching {
                left_at_most(&field, &library, asked, self.tolerance, cancel)?
            } else {
                let closing = closing_within(&field, &library, asked, cancel)?;
                regions(&field, &closing, self.tolerance, cancel)?
            };
            let here = left.into_iter().filter(|left| left.bounds.intersects(&around));
            let deepest = here.max_by(|a, b| a.normal_depth.total_cmp(&b.normal_depth));
            Ok(deepest.map(|left| (left.normal_depth, field.surface_point(left.cells[left.cells.len() / 2] as usize))))
        };
        match left() {
            Err(HeightFieldError::TooManyCells { .. }) => Ok(Answer::Unknown),
            Err(other) => Err(other.into()),
            Ok(None) => Ok(Answer::Taken),
            Ok(Some(_)) if by_touching => Ok(Answer::Unknown),
            // Flat cutters leave no more than the region.
            Ok(Some((depth, place))) => {
                Ok(Answer::Left(depth.min(region.residue()), place.unwrap_or(region.bounds.center())))
            }
        }
    }
}
