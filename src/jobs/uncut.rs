//! What the cutters of a library leave of a mold.
//!
//! Flat cutters are followed exactly, layer by layer. Where a library has rounded cutters too, what all of them leave is
//! told by the field of heights. What flat cutters leave is always found both ways, and how far the two agree is told.

use serde::Serialize;

use crate::geometry::mesh::Mesh;
use crate::mold::cutter::{Cutter, CutterError, CutterKind, CutterLibrary};
use crate::mold::height_field::{self, HeightField, HeightFieldError};
use crate::mold::layers::{LayerSettings, LayerSettingsError};
use crate::mold::opening::Opening;
use crate::mold::region::{self, regions};
use crate::mold::stack::{UncutStack, uncut_stack};
use crate::mold::warning::MoldWarning;
use crate::progress::{Cancel, Cancelled, Progress};

/// Cells of the field of heights that a smallest radius is divided into, where memory allows.
const CELLS_PER_RADIUS: f64 = 40.0;
/// Cells of the field of heights, at most, unless its step is given.
const MOST_CELLS: f64 = 12e6;

/// What is asked.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct UncutParams {
    /// The cutters.
    pub library: CutterLibrary,
    /// From where they come.
    pub opening: Opening,
    /// Thickness of the residue, across the mold's surface, up to which it counts as cut (mm).
    pub tolerance_mm: f64,
    /// Step of the field of heights (mm); none for as fine as it has to be and can be.
    pub grid_step_mm: Option<f64>,
    /// How finely the mold is cut into layers.
    pub layers: LayerSettings,
}

impl UncutParams {
    /// The usual parameters for a library.
    pub fn of(library: CutterLibrary) -> Self {
        let (opening, layers) = (Opening::default(), LayerSettings::default());
        Self { library, opening, tolerance_mm: 0.02, grid_step_mm: None, layers }
    }

    /// Whether they can be asked.
    ///
    /// # Errors
    /// [`UncutError`].
    pub fn validate(&self) -> Result<(), UncutError> {
        self.library.validate()?;
        self.layers.validate()?;
        if !(1e-4..=10.0).contains(&self.tolerance_mm) {
            return Err(UncutError::Tolerance(self.tolerance_mm));
        }
        Ok(())
    }
}

/// Why a mold has no answer.
#[derive(Debug, thiserror::Error)]
pub enum UncutError {
    /// The library is not one.
    #[error("cutters: {0}")]
    Cutters(#[from] CutterError),
    /// The settings are not possible.
    #[error("layers: {0}")]
    Layers(#[from] LayerSettingsError),
    /// The tolerance is not possible.
    #[error("tolerance_mm is {0}: it must be finite and from 0.0001 to 10 mm")]
    Tolerance(f64),
    /// The field of heights cannot be had.
    #[error("field of heights: {0}")]
    Field(HeightFieldError),
    /// It was told to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<HeightFieldError> for UncutError {
    fn from(error: HeightFieldError) -> Self {
        match error {
            HeightFieldError::Cancelled(cancelled) => Self::Cancelled(cancelled),
            HeightFieldError::Cutter(cutter) => Self::Cutters(cutter),
            other => Self::Field(other),
        }
    }
}

/// How many regions, and their volume (mm^3), by one way of finding them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
#[allow(missing_docs)]
pub struct Found {
    pub regions: usize,
    pub volume_mm3: f64,
}

/// What is left of a mold.
#[derive(Debug, Clone)]
pub struct Uncut {
    /// What was asked.
    pub params: UncutParams,
    /// What the flat cutters leave, layer by layer, with the invert faces; the opening looks along +Z.
    pub stack: UncutStack,
    /// The regions that the flat cutters leave.
    pub flat_regions: Vec<region::UncutRegion>,
    /// Step of the field of heights (mm).
    pub grid_step: f64,
    /// The regions that all cutters leave, by the field of heights.
    pub field_regions: Vec<height_field::UncutRegion>,
    /// What flat cutters leave by layers and by the field of heights; none without flat cutters.
    pub agreement: Option<[Found; 2]>,
}

impl Uncut {
    /// Whether only flat cutters count, so that the layers are the answer.
    pub fn is_of_flats(&self) -> bool {
        self.params.library.needed().iter().all(|c| c.kind() == CutterKind::Flat)
    }

    /// Regions and volume of what the whole library leaves.
    pub fn found(&self) -> Found {
        if self.is_of_flats() { by_layers(&self.flat_regions) } else { by_field(&self.field_regions) }
    }

    /// Whether the mesh is such that the answer holds for all of it.
    pub fn is_whole(&self) -> bool {
        let breaks = |w: &MoldWarning| {
            use MoldWarning::{Crossing, Empty, NotClosed, Open};
            matches!(w, Empty | NotClosed { .. } | Open { .. } | Crossing { .. })
        };
        !self.stack.warnings.iter().any(breaks)
    }
}

fn by_layers(regions: &[region::UncutRegion]) -> Found {
    Found { regions: regions.len(), volume_mm3: regions.iter().fold(0.0, |sum, r| sum + r.volume) }
}

fn by_field(regions: &[height_field::UncutRegion]) -> Found {
    Found { regions: regions.len(), volume_mm3: regions.iter().fold(0.0, |sum, r| sum + r.volume) }
}

/// What the cutters of `params` leave of `mesh`.
///
/// # Errors
/// [`UncutError`].
pub fn uncut(mesh: &Mesh, params: &UncutParams, progress: &Progress, cancel: &Cancel) -> Result<Uncut, UncutError> {
    params.validate()?;
    if mesh.triangles.is_empty() {
        return Err(UncutError::Field(HeightFieldError::NoMaterial));
    }
    let upright = params.opening.upright_mesh(mesh);
    let needed = params.library.needed();
    let flats: Vec<&Cutter> = needed.iter().copied().filter(|c| c.kind() == CutterKind::Flat).collect();
    let mut stack = uncut_stack(&upright, &flats, None, &params.layers, progress, cancel)?;
    // Where a whole wall is missing every section closes all the same.
    let edges = open_edges(mesh);
    if edges > 0 {
        stack.warnings.insert(0, MoldWarning::NotClosed { edges });
    }
    let flat_regions = regions(&stack.layers, params.tolerance_mm);
    let grid_step = params.grid_step_mm.unwrap_or_else(|| usual_step(&upright, &needed));
    progress.report("field of heights", 0.0, "");
    let field = HeightField::raster(&upright, grid_step, cancel)?;
    let of = |library: &CutterLibrary| -> Result<Vec<height_field::UncutRegion>, UncutError> {
        let closing = height_field::closing(&field, library, cancel)?;
        Ok(height_field::regions(&field, &closing, params.tolerance_mm, cancel)?)
    };
    let field_regions = of(&params.library)?;
    progress.report("field of heights", 0.7, "");
    let agreement = if flats.is_empty() {
        None
    } else {
        let with_flats = if flats.len() == needed.len() {
            by_field(&field_regions)
        } else {
            by_field(&of(&CutterLibrary { cutter: flats.into_iter().cloned().collect() })?)
        };
        Some([by_layers(&flat_regions), with_flats])
    };
    progress.report("field of heights", 1.0, "");
    Ok(Uncut { params: params.clone(), stack, flat_regions, grid_step, field_regions, agreement })
}

/// Edges that have no face on one side, or more on one than on the other.
fn open_edges(mesh: &Mesh) -> usize {
    let directed = mesh.directed_edges();
    directed.iter().filter(|((a, b), count)| directed.get(&(*b, *a)).copied().unwrap_or(0) < **count).count()
}

/// As fine as the smallest radius asks for, but with no more cells than a computer holds with ease.
fn usual_step(mesh: &Mesh, cutters: &[&Cutter]) -> f64 {
    let smallest = cutters.iter().map(|c| c.radius()).fold(f64::INFINITY, f64::min);
    let widest = cutters.iter().map(|c| c.holder().map_or(c.radius(), |(holder, _)| holder)).fold(0.0, f64::max);
    let size = mesh.bounds().size().truncate() + 2.0 * widest;
    let coarsest = (size.x * size.y / MOST_CELLS).sqrt();
    // Round figures, so that the step is one to speak of.
    (1e4 * (smallest / CELLS_PER_RADIUS).max(coarsest)).ceil() / 1e4
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::geometry::mesh::tests::cuboid;

    fn answer(mesh: &Mesh, cutters: Vec<Cutter>) -> Result<Uncut, UncutError> {
        let params = UncutParams::of(CutterLibrary { cutter: cutters });
        uncut(mesh, &params, &Progress::silent(), &Cancel::default())
    }

    #[test]
    fn nothing_is_left_of_a_plain_block() {
        let mesh = cuboid(DVec3::new(10.0, 8.0, 3.0));
        let left = answer(&mesh, vec![Cutter::flat(1.0), Cutter::ball(1.0)]).unwrap();
        assert_eq!(left.found(), Found::default());
        assert!(left.is_whole() && !left.is_of_flats());
        assert_eq!(left.agreement, Some([Found::default(); 2]));
    }

    #[test]
    fn what_cannot_be_asked_is_answered_in_words() {
        let mesh = cuboid(DVec3::new(10.0, 8.0, 3.0));
        let refused = |mesh: &Mesh, cutters| answer(mesh, cutters).unwrap_err().to_string();
        assert!(refused(&mesh, Vec::new()).contains("no cutter"));
        assert!(refused(&mesh, vec![Cutter::flat(-1.0)]).contains("diameter_mm is -2 mm"));
        assert!(refused(&Mesh::default(), vec![Cutter::flat(1.0)]).contains("nothing to cut"));
    }
}
