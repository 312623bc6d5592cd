//! Thin regions that flat cutters leave and the field of heights is too coarse for: whether rounded cutters take them is
//! found on a finer grid over each of them.

use glam::DVec2;
use rayon::prelude::*;

use super::{UncutError, UncutParams};
use geometry::mesh::Mesh;
use mold::cutter::{Cutter, CutterKind, CutterLibrary};
use mold::height_field::{FieldRegion, HeightField, HeightFieldError, closing_within, regions};
use mold::region::LayerRegion;
use mold::warning::MoldWarning;
use task::Cancel;

/// Cells that a region is thick from which on a field of heights cannot miss it.
const THIN: f64 = 3.0;
/// Cells of the finer grid that a region is thick.
const CELLS: f64 = 3.0;
/// Cells of all finer grids together, at most.
const MOST_CELLS: f64 = 64e6;

/// Answer about a region.
enum Answer {
    /// A cutter takes it.
    Taken,
    /// All cutters leave it, as thick as this across the surface (mm).
    Left(f64),
    /// It is too thin for any grid that there is room for.
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
    // What the flat ones leave is known.
    let mut cutters = params.library.needed();
    cutters.retain(|cutter| cutter.kind() != CutterKind::Flat);
    cutters.sort_by(|a, b| a.radius().total_cmp(&b.radius()).then(a.corner_mm.total_cmp(&b.corner_mm)));
    let tolerance = params.tolerance_mm;
    let look = CloserLook { mesh, field, cutters, tolerance, most: MOST_CELLS / thin.len().max(1) as f64 };
    let answers: Vec<Answer> = thin.par_iter().map(|region| look.at(region, cancel)).collect::<Result<_, _>>()?;
    let mut warnings = Vec::new();
    let left = thin.iter().zip(&answers).filter_map(|(region, answer)| {
        let Answer::Left(thickness) = answer else { return None };
        Some((*thickness, region.bounds.center()))
    });
    let left: Vec<_> = left.collect();
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
    /// The rounded cutters, the smallest first.
    cutters: Vec<&'a Cutter>,
    tolerance: f64,
    /// Cells of each finer grid, at most.
    most: f64,
}

impl CloserLook<'_> {
    /// What the rounded cutters leave of a region, ever more of them, the smallest first, until they take it.
    fn at(&self, region: &LayerRegion, cancel: &Cancel) -> Result<Answer, UncutError> {
        let mut thickness = None;
        for count in 1..=self.cutters.len() {
            let library = CutterLibrary { cutter: self.cutters[..count].iter().map(|c| (*c).clone()).collect() };
            match self.left_by(&library, region, cancel)? {
                Some(0.0) => return Ok(Answer::Taken),
                Some(left) => thickness = Some(left.min(region.residue())),
                // A larger cutter needs a larger grid: what the smaller ones leave is as much as is known.
                None if thickness.is_none() => return Ok(Answer::Unknown),
                None => break,
            }
        }
        Ok(thickness.map_or(Answer::Unknown, Answer::Left))
    }

    /// How thick a library leaves a region (mm): zero where it takes it; none where a grid that is fine enough has too
    /// many cells.
    fn left_by(
        &self,
        library: &CutterLibrary,
        region: &LayerRegion,
        cancel: &Cancel,
    ) -> Result<Option<f64>, UncutError> {
        let widest = |cutter: &Cutter| cutter.radius() + cutter.holder().map_or(cutter.radius(), |(radius, _)| radius);
        let reach = library.cutter.iter().map(widest).fold(0.0, f64::max);
        let own = region.bounds;
        let plan = [own.min.truncate() - reach, own.max.truncate() + reach];
        let step = region.residue() / CELLS;
        let cells = |size: DVec2| (size.x / step) * (size.y / step);
        if cells(plan[1] - plan[0]) > self.most {
            return Ok(None);
        }
        let field = match self.field.closer(self.mesh, plan, step, cancel) {
            Err(HeightFieldError::TooManyCells { .. }) => return Ok(None),
            other => other?,
        };
        // Some cells more than the region has, in which its own are inner ones.
        let around = own.grown(4.0 * step);
        let asked = [around.min.truncate(), around.max.truncate()];
        let closing = match closing_within(&field, library, asked, cancel) {
            Err(HeightFieldError::TooManyCells { .. }) => return Ok(None),
            other => other?,
        };
        let left = regions(&field, &closing, self.tolerance, cancel)?;
        let here = left.iter().filter(|left| left.bounds.intersects(&around));
        Ok(Some(here.map(|left| left.normal_depth).fold(0.0, f64::max)))
    }
}
