//! What a user chooses for a mold.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::cutter_file::standard_cutters;
use crate::mesh_io::Units;
use crate::mold::cutter::CutterLibrary;
use crate::mold::opening::Opening;

/// A mold and the question about it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MoldParams {
    /// Its mesh; none as long as nothing is loaded.
    pub mesh: Option<PathBuf>,
    /// Unit of the mesh.
    pub units: Units,
    /// The direction in which its opening looks, in the axes of the mesh.
    pub opening: Opening,
    /// Thickness of the residue, across the mold's surface, up to which it counts as cut (mm).
    pub tolerance_mm: f64,
    /// The cutters.
    pub library: CutterLibrary,
}

impl Default for MoldParams {
    fn default() -> Self {
        Self {
            mesh: None,
            units: Units::Auto,
            opening: Opening::default(),
            tolerance_mm: 0.02,
            // A program that was built with a file that is none has no cutters to begin with.
            library: standard_cutters().unwrap_or_default(),
        }
    }
}

impl MoldParams {
    /// What to call the mold.
    pub fn name(&self) -> String {
        let name = self.mesh.as_deref().and_then(Path::file_stem);
        name.map_or("No mold".to_owned(), |n| n.to_string_lossy().into_owned())
    }
}
