//! The paths that the workspace asks for.

use crate::workspaces::context::{PROJECT, PathInfo, PathKind, PathSet, TOML};
use crate::workspaces::moved_files::FIND;
use import::MESH_ENDINGS;

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
