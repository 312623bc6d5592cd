//! Checks that nothing may skip: whether an electrode is closed, enters nothing on its way, leaves no residual stock,
//! and can be milled.

use glam::DVec3;

use super::cuts::Undivided;
use super::finding::{CheckKind, Finding};
use crate::cutter::{Cutter, CutterLibrary};
use crate::height_field;
use crate::height_field::{FieldRegion, HeightField, HeightFieldError};
use crate::invert::{InvertFaces, LEAST_INVERT};
use geometry::mesh::Mesh;
use geometry::solid;
use task::Cancel;

/// Vertices within this are one to programs that weld (mm).
pub(super) const WELD: f64 = 1e-6;

/// The smallest radius of a cutter that is looked at as a remedy (mm).
const SMALLEST: f64 = 0.2;
/// Cells of the smallest radius on the grid on which it is tried whether an electrode can be milled.
const MILLING_CELLS: f64 = 20.0;
/// Least number of cells in the radius of the smallest cutter, where a finer grid would have more than [`MOST_CELLS`].
const LEAST_CELLS: f64 = 5.0;
/// Number of cells of a grid from which on it is made coarser.
const MOST_CELLS: f64 = 1.6e7;

/// A mesh as a file in single precision has it.
pub(super) fn in_file(mesh: &Mesh) -> Mesh {
    mesh.mapped(|p| p.as_vec3().as_dvec3())
}

/// Whether a surface is closed, also as a file in single precision has it.
pub fn watertight(mesh: &Mesh) -> Finding {
    let volume = mesh.volume();
    let filed = in_file(mesh);
    // Some programs take triangles with two equal corners for open edges.
    let has_points = filed.iter_corners().any(|[a, b, c]| a == b || b == c || c == a);
    let is_closed =
        mesh.is_watertight() && !has_points && [mesh, &filed].into_iter().all(|mesh| solid::is_closed(mesh, WELD));
    let holds = is_closed && volume > 0.0;
    let text = if holds {
        format!("closed; {volume:.2} mm^3")
    } else if is_closed {
        format!("its faces look inwards ({volume:.2} mm^3): turn them round")
    } else {
        "its surface has open edges or touches itself: no other check means anything".into()
    };
    Finding::new(CheckKind::Watertight, holds, text, None).with(&[("not_closed", 1.0)])
}

/// Rest material on an electrode that is turned over so that its tips look up.
pub(super) struct Milled {
    /// The heights of it.
    field: HeightField,
    /// Rest material, the largest first, with places of the electrode turned over.
    pub(super) left: Vec<FieldRegion>,
    /// Area that looks away from the cutters (mm^2).
    pub(super) undercut: f64,
}

/// What cutters leave of an electrode above `tolerance` (mm). Only stock on a footing of its own counts: tips need the
/// base that they stand on.
///
/// # Errors
/// [`HeightFieldError`].
pub(super) fn milled(
    electrode: &Mesh,
    cutters: &CutterLibrary,
    tolerance: f64,
    cancel: &Cancel,
) -> Result<Milled, HeightFieldError> {
    let over = electrode.mapped(turned_over);
    let fine = (cutters.least_radius() / MILLING_CELLS).min(1.25 * tolerance.max(0.02));
    let size = over.bounds().size();
    // A large electrode for a small cutter is looked at more coarsely, as long as the cutter is some cells wide.
    let coarse = (size.x * size.y / MOST_CELLS).sqrt().min(cutters.least_radius() / LEAST_CELLS);
    let field = HeightField::raster(&over, fine.max(coarse), cancel)?;
    let left = left_by(&field, cutters, tolerance, cancel)?;
    Ok(Milled { field, left, undercut: InvertFaces::of(&over).area })
}

/// A point of an electrode that is turned over, and of one that is not.
pub(super) fn turned_over(p: DVec3) -> DVec3 {
    DVec3::new(p.x, -p.y, -p.z)
}

fn left_by(
    field: &HeightField,
    cutters: &CutterLibrary,
    tolerance: f64,
    cancel: &Cancel,
) -> Result<Vec<FieldRegion>, HeightFieldError> {
    let closing = height_field::closing(field, cutters, cancel)?;
    height_field::regions(field, &closing, tolerance, cancel)
}

/// Whether cutters mill an electrode, leaving nothing above `tolerance` (mm). Where they do not, `undivided` tells what
/// became of the cuts that were tried on its heads.
///
/// # Errors
/// [`HeightFieldError`].
pub fn machinable(
    electrode: &Mesh,
    cutters: &CutterLibrary,
    tolerance: f64,
    undivided: Option<Undivided>,
    cancel: &Cancel,
) -> Result<Finding, HeightFieldError> {
    let Milled { field, left, undercut } = milled(electrode, cutters, tolerance, cancel)?;
    let radius = cutters.least_radius();
    Ok(match left.first() {
        Some(worst) => {
            let volume = left.iter().map(|r| r.volume).sum::<f64>();
            let thickness = left.iter().map(|r| r.normal_depth).fold(0.0, f64::max);
            let why =
                undivided.map_or_else(|| ": divide it there".to_owned(), |undivided| format!(", and {undivided}"));
            let mut remedy = format!("no cutter down to a radius of {SMALLEST} mm mills it{why}");
            for smaller in [0.5 * radius, 0.25 * radius, SMALLEST] {
                let both = CutterLibrary { cutter: vec![Cutter::flat(smaller), Cutter::ball(smaller)] };
                if (SMALLEST..radius).contains(&smaller) && left_by(&field, &both, tolerance, cancel)?.is_empty() {
                    remedy = format!("flat and ball cutters of {smaller} mm radius mill it");
                    break;
                }
            }
            let text = format!(
                "not millable: the cutters leave rest material at {}, {volume:.3} mm^3 in all, up to {thickness:.3} mm \
                 thick; {remedy}",
                if left.len() == 1 { "1 place".to_owned() } else { format!("{} places", left.len()) },
            );
            let finding = Finding::new(CheckKind::Machinable, false, text, Some(turned_over(worst.bounds.center())));
            finding.with(&[("volume_mm3", volume), ("thickness_mm", thickness)])
        }
        None if undercut > LEAST_INVERT => {
            let text = format!("not millable: {undercut:.3} mm^2 are undercut");
            Finding::failed(CheckKind::Machinable, text, ("undercut_mm2", undercut))
        }
        None => Finding::new(CheckKind::Machinable, true, "millable: no rest material".into(), None),
    })
}
