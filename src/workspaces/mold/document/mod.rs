//! What a user chooses for a mold.

pub mod cutter_file;
pub mod electrode_file;
pub mod fields;
pub mod holder_files;
pub mod mold_file;

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::workspaces::mold::document::cutter_file::standard_cutters;
use files::{Invalid, Validate};
use import::{Imported, Units};
use mold::cutter::CutterLibrary;
use mold::electrode::params::ElectrodeParams;
use mold::opening::Opening;

/// A mold and the question about it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MoldParams {
    /// Its mesh; none as long as nothing is loaded.
    pub mesh: Option<PathBuf>,
    /// Unit of the mesh.
    pub units: Units,
    /// The part that everything was decided for: the digest of its file and the unit it was read in, as they were when
    /// it was read last. None before that.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub part: Option<String>,
    /// The direction in which its opening looks, in the axes of the mesh.
    pub opening: Opening,
    /// Thickness of the residue, across the mold's surface, up to which it counts as cut (mm).
    pub tolerance_mm: f64,
    /// The cutters.
    pub library: CutterLibrary,
    /// What is asked of electrodes for what they leave. Without holders these are those of the user's library.
    pub electrodes: ElectrodeParams,
}

impl Default for MoldParams {
    fn default() -> Self {
        Self {
            mesh: None,
            units: Units::Auto,
            part: None,
            opening: Opening::default(),
            tolerance_mm: 0.02,
            // A program that was built with a file that is none has no cutters to begin with.
            library: standard_cutters().unwrap_or_default(),
            electrodes: ElectrodeParams::default(),
        }
    }
}

impl Validate for MoldParams {
    fn validate(&self) -> Result<(), Invalid> {
        fields::FIELDS.check(self)?;
        Validate::validate(&self.library).map_err(|problem| problem.within("library"))?;
        Validate::validate(&self.electrodes).map_err(|problem| problem.within("electrodes"))
    }
}

impl MoldParams {
    /// What to call the mold.
    pub fn name(&self) -> String {
        let name = self.mesh.as_deref().and_then(Path::file_stem);
        name.map_or("No mold".to_owned(), |n| n.to_string_lossy().into_owned())
    }

    /// Parameters without what was decided for one part only: where it opens to, how its regions are divided and burned,
    /// which of its electrodes are exported although a check fails, and what they are called.
    pub fn undecided(&self) -> Self {
        let (edits, overrides, names) = (Vec::new(), Vec::new(), Vec::new());
        let electrodes = ElectrodeParams { edits, overrides, names, ..self.electrodes.clone() };
        Self { opening: Opening::default(), electrodes, ..self.clone() }
    }

    /// What of these parameters holds for `part`: what was decided for another one does not.
    pub fn of_part(&self, part: &str) -> Self {
        let is_other = self.part.as_ref().is_some_and(|own| own != part);
        let params = if is_other { self.undecided() } else { self.clone() };
        Self { part: Some(part.to_owned()), ..params }
    }
}

/// What tells a part from any other: the digest of its file, and the unit that it was read in.
pub fn part_of(imported: &Imported) -> String {
    format!("{} {}", imported.sha256, imported.report.unit.name())
}
