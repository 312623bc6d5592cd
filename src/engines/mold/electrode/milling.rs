//! Whether cutters mill an electrode.

use glam::DVec3;

use super::check::{CheckKind, Finding};
use crate::cutter::CutterLibrary;
use crate::height_field;
use crate::height_field::{HeightField, HeightFieldError};
use crate::invert::InvertFaces;
use geometry::mesh::Mesh;
use task::Cancel;

/// Cells of the smallest radius on the grid on which it is tried whether an electrode can be milled.
const MILLING_CELLS: f64 = 20.0;
/// Area of faces that look away from the cutters up to which it is rounding (mm^2).
const LEAST_INVERT: f64 = 1e-2;

/// Whether cutters mill an electrode, turned over so that its tips look up, leaving nothing above `tolerance` (mm). Only
/// what stands on something of its own is left: tips need the base that they stand on.
///
/// # Errors
/// [`HeightFieldError`].
pub fn machinable(
    electrode: &Mesh,
    cutters: &CutterLibrary,
    tolerance: f64,
    cancel: &Cancel,
) -> Result<Finding, HeightFieldError> {
    let over = electrode.mapped(|p| DVec3::new(p.x, -p.y, -p.z));
    let radius = cutters.needed().iter().map(|c| c.radius()).fold(f64::INFINITY, f64::min);
    let field = HeightField::raster(&over, (radius / MILLING_CELLS).min(1.25 * tolerance.max(0.02)), cancel)?;
    let closing = height_field::closing(&field, cutters, cancel)?;
    let left = height_field::regions(&field, &closing, tolerance, cancel)?;
    let invert = InvertFaces::of(&over).area;
    let back = |p: DVec3| DVec3::new(p.x, -p.y, -p.z);
    Ok(match left.first() {
        Some(worst) => {
            let text = format!(
                "not millable: the cutters leave rest material at {} places, {:.3} mm^3 in all, up to {:.3} mm thick; divide it there, or add a smaller cutter",
                left.len(),
                left.iter().map(|r| r.volume).sum::<f64>(),
                left.iter().map(|r| r.normal_depth).fold(0.0, f64::max)
            );
            Finding::new(CheckKind::Machinable, false, text, Some(back(worst.bounds.center())))
        }
        None if invert > LEAST_INVERT => {
            let text = format!("not millable: {invert:.3} mm^2 are undercut");
            Finding::new(CheckKind::Machinable, false, text, None)
        }
        None => Finding::new(CheckKind::Machinable, true, "millable: no rest material".into(), None),
    })
}
