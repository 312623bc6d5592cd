//! Checks that nothing may skip: whether an electrode is closed, enters nothing on its way, leaves no residual stock,
//! and can be milled.

use files::Figures;
use glam::DVec3;
use serde::{Deserialize, Serialize};

pub use super::clearance::{Clearance, Obstacle};
pub use super::leftover::{LeftOfRegion, Milled, Sample, leftover};
use crate::cutter::CutterLibrary;
use crate::height_field;
use crate::height_field::{HeightField, HeightFieldError};
use crate::invert::InvertFaces;
use geometry::mesh::Mesh;
use geometry::solid;
use task::Cancel;

/// Vertices within this are one in a file of single precision (mm).
const WELD: f64 = 1e-6;

/// By how much an electrode may come closer than the gap (mm): rounding of files, not of sparks.
pub const GOUGE: f64 = 5e-4;
/// Cells of the smallest radius on the grid on which it is tried whether an electrode can be milled.
const MILLING_CELLS: f64 = 20.0;
/// Area of faces that look away from the cutters up to which it is rounding (mm^2).
const LEAST_INVERT: f64 = 1e-2;

/// Subject of a check.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CheckKind {
    /// The surface is closed.
    Watertight,
    /// The electrode keeps the gap where it burns.
    Gouge,
    /// The electrode keeps the gap on its way in and out.
    Approach,
    /// The parts that the electrode was made for are burned.
    Leftover,
    /// The electrode can be milled.
    Machinable,
}

impl CheckKind {
    /// All checks, in the order in which they are made.
    pub const ALL: [Self; 5] = [Self::Watertight, Self::Gouge, Self::Approach, Self::Leftover, Self::Machinable];

    /// How it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Watertight => "watertight",
            Self::Gouge => "gouge",
            Self::Approach => "approach",
            Self::Leftover => "leftover",
            Self::Machinable => "machinable",
        }
    }
}

/// Finding of a check.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// Subject of the check.
    pub kind: CheckKind,
    /// Whether it holds.
    pub holds: bool,
    /// The finding in words, with its figures.
    pub text: String,
    /// Where, in the upright mold (mm).
    pub place: Option<DVec3>,
    /// How bad it is, if it fails; see [`Figures`].
    pub figures: Figures,
}

/// The greatest figure of what is wrong: what is no number is as bad as that.
const WORST: f64 = 1e9;

impl Finding {
    /// A finding.
    pub(super) fn new(kind: CheckKind, holds: bool, text: String, place: Option<DVec3>) -> Self {
        Self { kind, holds, text, place, figures: Figures::new() }
    }

    /// One that does not hold, as bad as this figure says.
    pub(super) fn failed(kind: CheckKind, text: String, figure: (&str, f64)) -> Self {
        Self::new(kind, false, text, None).with(&[figure])
    }

    /// This finding with the figures of its failure.
    pub(super) fn with(mut self, figures: &[(&str, f64)]) -> Self {
        let worst = |figure: f64| if figure.is_finite() { figure.clamp(0.0, WORST) } else { WORST };
        let wrong = figures.iter().filter(|_| !self.holds);
        self.figures.extend(wrong.map(|(name, figure)| ((*name).to_owned(), worst(*figure))));
        self
    }
}

/// Whether a surface is closed.
pub fn watertight(mesh: &Mesh) -> Finding {
    let volume = mesh.volume();
    let is_closed = mesh.is_watertight() && solid::is_closed(mesh, WELD);
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

/// Whether cutters mill an electrode, turned over so that its tips look up, leaving nothing above `tolerance` (mm).
/// Only stock on a footing of its own counts: tips need the base that they stand on.
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
            let volume = left.iter().map(|r| r.volume).sum::<f64>();
            let thickness = left.iter().map(|r| r.normal_depth).fold(0.0, f64::max);
            let text = format!(
                "not millable: the cutters leave rest material at {} places, {volume:.3} mm^3 in all, up to {thickness:.3} mm thick; divide it there, or add a smaller cutter",
                left.len(),
            );
            let finding = Finding::new(CheckKind::Machinable, false, text, Some(back(worst.bounds.center())));
            finding.with(&[("volume_mm3", volume), ("thickness_mm", thickness)])
        }
        None if invert > LEAST_INVERT => {
            let text = format!("not millable: {invert:.3} mm^2 are undercut");
            Finding::failed(CheckKind::Machinable, text, ("undercut_mm2", invert))
        }
        None => Finding::new(CheckKind::Machinable, true, "millable: no rest material".into(), None),
    })
}
