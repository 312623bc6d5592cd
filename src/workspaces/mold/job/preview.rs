//! A coarse look at what cutters leave, quick enough to follow a hand that changes a cutter.

use glam::{DVec2, DVec3};

use super::uncut::{UncutError, UncutParams};
use geometry::mesh::{Bounds, Mesh};
use mold::height_field;
use mold::height_field::{HeightField, HeightFieldError};
use mold::surface::SurfacePiece;
use task::Cancel;

/// Cells of the field of heights of a quick look.
const CELLS: f64 = 250e3;
/// Steps of the grid by which neighbouring cells may differ in height and still be one surface.
const STEEP: f64 = 2.0;

/// A place of the grid where something is left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CoarseCell {
    /// Corners of the cell on the mold's surface, counter-clockwise seen from above (mm), the opening looking along +Z.
    pub corners: [DVec3; 4],
    /// Height of what is left above it (mm).
    pub depth: f32,
}

impl CoarseCell {
    /// The cell as two triangles of the surface of a `region`, of no face of the mesh.
    pub fn pieces(&self, region: u32) -> [SurfacePiece; 2] {
        let [a, b, c, d] = self.corners;
        [[a, b, c], [a, c, d]].map(|corners| SurfacePiece { corners, face: u32::MAX, region, depth: [self.depth; 3] })
    }
}

/// A connected piece of what is left, as coarse as the grid.
#[derive(Debug, Clone, PartialEq)]
pub struct CoarseRegion {
    /// Volume (mm^3).
    pub volume: f64,
    /// Box around it (mm), the opening looking along +Z.
    pub bounds: Bounds,
    /// Cells of the region.
    pub cells: Vec<CoarseCell>,
}

/// What a coarse look finds.
#[derive(Debug, Clone, PartialEq)]
pub struct Preview {
    /// Step of its grid (mm).
    pub step: f64,
    /// The regions, the largest first.
    pub regions: Vec<CoarseRegion>,
}

impl Preview {
    /// Result of the preview, in a sentence that does not promise more than is known.
    pub fn sentence(&self) -> String {
        let volume: f64 = self.regions.iter().map(|r| r.volume).sum();
        let step = self.step;
        match self.regions.len() {
            0 => format!("Preview, cells of {step:.2} mm: no rest material."),
            1 => format!("Preview, cells of {step:.2} mm: 1 region of about {volume:.1} mm³."),
            n => format!("Preview, cells of {step:.2} mm: {n} regions of about {volume:.1} mm³ in all."),
        }
    }
}

/// A coarse look at what the cutters of `params` leave of `mesh`. What is narrower than three cells is not seen.
///
/// # Errors
/// [`UncutError`].
pub fn preview(mesh: &Mesh, params: &UncutParams, cancel: &Cancel) -> Result<Preview, UncutError> {
    params.validate()?;
    let upright = params.opening.upright_mesh(mesh);
    let size = upright.bounds().size();
    let step = (size.x * size.y / CELLS).sqrt();
    if !(step.is_finite() && step > 0.0) {
        return Err(UncutError::Field(HeightFieldError::NoMaterial));
    }
    let field = HeightField::raster(&upright, step, cancel)?;
    let closing = height_field::closing(&field, &params.library, cancel)?;
    let found = height_field::regions(&field, &closing, params.tolerance_mm, cancel)?;
    let mut regions = Vec::with_capacity(found.len());
    for region in found {
        cancel.check()?;
        let cells = (0..region.cells.len()).map(|i| CoarseCell {
            corners: corners(&field, &region.cells, i),
            depth: closing.residue(&field, region.cells[i] as usize) as f32,
        });
        regions.push(CoarseRegion { volume: region.volume, bounds: region.bounds, cells: cells.collect() });
    }
    Ok(Preview { step, regions })
}

/// The corners of cell number `i` of those of a region, each as high as the cells of the region that meet there are on
/// average, so that a slope is one surface and a step remains a step.
fn corners(field: &HeightField, cells: &[u32], i: usize) -> [DVec3; 4] {
    let (columns, cell) = (field.size()[0] as i64, i64::from(cells[i]));
    let own = field.height(cell as usize).unwrap_or_default();
    let height = |number: i64| {
        let is_of_region = u32::try_from(number).is_ok_and(|n| cells.binary_search(&n).is_ok());
        let height = if is_of_region { field.height(number as usize) } else { None };
        height.filter(|h| (h - own).abs() <= STEEP * field.step())
    };
    let center = field.center(cell as usize);
    [(-1, -1), (1, -1), (1, 1), (-1, 1)].map(|(x, y): (i64, i64)| {
        let around = [cell, cell + x, cell + y * columns, cell + x + y * columns];
        let known: Vec<f64> = around.into_iter().filter_map(height).collect();
        let mean = known.iter().sum::<f64>() / known.len().max(1) as f64;
        (center + 0.5 * field.step() * DVec2::new(x as f64, y as f64)).extend(mean)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use mold::cutter::{Cutter, CutterLibrary};
    use mold::fixtures::{pocket, rectangle};
    use mold::opening::Opening;

    #[test]
    fn a_quick_look_sees_the_corners_of_a_pocket_about_as_large_as_they_are() {
        let mesh = pocket(&rectangle(20.0, 20.0), &rectangle(12.0, 9.0), &rectangle(12.0, 9.0), [10.0, 4.0]);
        let radius = 2.0;
        let library = CutterLibrary { cutter: vec![Cutter::flat(radius)] };
        let found = preview(&mesh, &UncutParams::of(library.clone()), &Cancel::default()).unwrap();
        let exact = (1.0 - std::f64::consts::FRAC_PI_4) * radius * radius * 4.0;
        assert_eq!(found.regions.len(), 4);
        for region in &found.regions {
            assert!((region.volume / exact - 1.0).abs() < 0.1, "{} {exact}", region.volume);
            // On the floor of the pocket, with the pocket's whole depth above it.
            assert!(region.cells.iter().flat_map(|c| c.corners).all(|p| (p.z - 6.0).abs() < 1e-5));
            assert!(region.cells.iter().all(|c| (c.depth - 4.0).abs() < 1e-4));
            let plan = region.cells.len() as f64 * found.step * found.step;
            assert!((plan * 4.0 / region.volume - 1.0).abs() < 1e-3);
        }
        assert!(found.sentence().contains("4 regions"));
        let mut turned = UncutParams::of(library);
        turned.opening = Opening::MinusX;
        let lying = mesh.mapped(|p| turned.opening.in_mesh(p));
        assert_eq!(preview(&lying, &turned, &Cancel::default()).unwrap(), found);
    }

    #[test]
    fn what_cannot_be_looked_at_is_answered_in_words() {
        let params = UncutParams::of(CutterLibrary { cutter: vec![Cutter::flat(1.0)] });
        let empty = preview(&Mesh::default(), &params, &Cancel::default()).unwrap_err();
        assert!(empty.to_string().contains("nothing to cut"), "{empty}");
        let none = UncutParams::of(CutterLibrary::default());
        assert!(preview(&Mesh::default(), &none, &Cancel::default()).unwrap_err().to_string().contains("no cutter"));
    }
}
