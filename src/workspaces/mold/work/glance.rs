//! The quick look that follows while a cutter is changed.

use std::sync::Arc;

use super::steps::LoadedMold;
use crate::workspaces::mold::job::preview::{Preview, preview};
use crate::workspaces::mold::job::uncut::UncutParams;
use crate::workspaces::mold::scene::region_shapes;
use render::mesh::RenderMesh;
use task::Cancel;

/// The result of a quick look.
#[derive(Debug)]
pub struct Glance {
    /// Figures of what is left.
    pub preview: Preview,
    /// Shape of what is left on the mold, for the screen.
    pub shape: Arc<RenderMesh>,
}

/// Takes a quick look at what the cutters leave.
///
/// # Errors
/// One line if it cannot be looked at.
pub(super) fn look(mold: &LoadedMold, params: &UncutParams, cancel: &Cancel) -> Result<Glance, String> {
    let preview = preview(&mold.mesh, params, cancel).map_err(|e| e.to_string())?;
    let cells = preview.regions.iter().flat_map(|r| &r.cells);
    let surface: Vec<_> = cells.flat_map(|cell| cell.pieces(0)).collect();
    let shape = region_shapes(&mold.mesh, &surface, 1, params.opening).swap_remove(0).shape;
    Ok(Glance { preview, shape })
}
