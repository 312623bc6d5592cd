//! The paths that the workspace asks for.

use std::path::{Path, PathBuf};

use crate::workspaces::context::{PROJECT, PathInfo, PathKind, PathSet, TOML};
use crate::workspaces::moved_files::FIND;
use files::paths::has_ending;
use import::MESH_ENDINGS;

/// Meshes directly in `folder`, by name.
///
/// # Errors
/// A line without the name of the folder, also if there is no mesh.
pub fn meshes_in(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let unreadable = |error| format!("cannot be read ({error}); check the path");
    let is_mesh = |path: &Path| MESH_ENDINGS.iter().any(|ending| has_ending(path, &format!(".{ending}")));
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        if path.is_file() && is_mesh(&path) {
            files.push(path);
        }
    }
    files.sort();
    if files.is_empty() {
        return Err("there is no mesh in this folder: STL, OBJ, glTF, GLB or STEP".to_owned());
    }
    Ok(files)
}

/// Purpose of a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MoldPath {
    /// The mesh of a mold, or a mold that was saved.
    Open,
    /// A library of cutters.
    Cutters,
    /// Another one to compare with.
    OtherCutters,
    /// Folder for the files of uncut regions.
    UncutFolder,
    /// Folder for the files of electrodes.
    ElectrodeFolder,
    /// A template of the burn sheet.
    BurnSheet,
    /// A technology table of one's own.
    Technology,
    /// A copy of the technology table.
    TechnologyCopy,
    /// Where the cutters are saved.
    SaveCutters,
    /// A file of a project that is elsewhere now.
    MovedFile,
}

impl PathSet for MoldPath {
    fn table() -> &'static [(Self, PathInfo)] {
        use MoldPath as P;
        static TABLE: [(P, PathInfo); 10] = [
            (
                P::Open,
                PathInfo::open("Open a mold", PathKind::Read("Molds and meshes", &[PROJECT, MESH_ENDINGS], false)),
            ),
            (P::Cutters, PathInfo::new("Load cutters", PathKind::Read("Cutters", &[TOML], false))),
            (P::OtherCutters, PathInfo::new("Load cutters to compare with", PathKind::Read("Cutters", &[TOML], false))),
            (P::UncutFolder, PathInfo::new("Folder for the rest material", PathKind::Folder)),
            (P::ElectrodeFolder, PathInfo::new("Folder for the electrodes", PathKind::Folder)),
            (P::BurnSheet, PathInfo::new("Template of the burn sheet", PathKind::Read("", &[], false))),
            (P::Technology, PathInfo::new("Your own technology table", PathKind::Read("Technology", &[TOML], false))),
            (P::TechnologyCopy, PathInfo::new("Copy of the technology table", PathKind::Write("Technology", ".toml"))),
            (P::SaveCutters, PathInfo::new("Save cutters", PathKind::Write("Cutters", ".toml"))),
            (P::MovedFile, FIND),
        ];
        &TABLE
    }
}
