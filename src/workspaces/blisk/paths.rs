//! The paths that the workspace asks for.

use crate::workspaces::context::{CSV, PROJECT, PathInfo, PathKind, PathSet, TOML};
use crate::workspaces::moved_files::FIND;
use import::MESH_ENDINGS;

/// Purpose of a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BliskPath {
    /// Project or mesh to open.
    Open,
    /// Folder for the exported files.
    ExportFolder,
    /// An electrode mesh of one's own.
    ElectrodeMesh,
    /// A table of measured sections.
    Sections,
    /// An NC post of one's own.
    Post,
    /// A template of the job sheet of one's own.
    JobSheet,
    /// A machine file of one's own.
    Machine,
    /// A technology table of one's own.
    Technology,
    /// A copy of the technology table.
    TechnologyCopy,
    /// A table of the electrodes as they are measured.
    Presets,
    /// A mesh of the wheel as it comes.
    Blank,
    /// A scan of the finished part.
    Scan,
    /// A file of a project that is elsewhere now.
    MovedFile,
}

/// Endings of scans.
const SCAN_ENDINGS: &[&str] = &["stl", "obj", "ply", "xyz", "csv", "txt"];

impl PathSet for BliskPath {
    fn table() -> &'static [(Self, PathInfo)] {
        use BliskPath as P;
        static TABLE: [(P, PathInfo); 13] = [
            (
                P::Open,
                PathInfo::open(
                    "Open a project or a mesh",
                    PathKind::Read("Projects and meshes", &[PROJECT, MESH_ENDINGS], false),
                ),
            ),
            (P::ExportFolder, PathInfo::new("Folder for the exported files", PathKind::Folder)),
            (P::ElectrodeMesh, PathInfo::new("Your own electrode", PathKind::Read("Meshes", &[MESH_ENDINGS], false))),
            (P::Sections, PathInfo::new("Measured sections", PathKind::Read("Tables", &[CSV], false))),
            (P::Post, PathInfo::new("Your own NC post", PathKind::Read("Post", &[TOML], false))),
            (P::JobSheet, PathInfo::new("Your own template of the job sheet", PathKind::Read("", &[], false))),
            (P::Machine, PathInfo::new("Your own machine", PathKind::Read("Machine", &[TOML], false))),
            (P::Technology, PathInfo::new("Your own technology table", PathKind::Read("Technology", &[TOML], false))),
            (P::TechnologyCopy, PathInfo::new("Copy of the technology table", PathKind::Write("Technology", ".toml"))),
            (P::Blank, PathInfo::new("The wheel as it comes", PathKind::Read("Meshes", &[MESH_ENDINGS], false))),
            (P::Presets, PathInfo::new("Electrodes as measured", PathKind::Read("Tables", &[CSV], false))),
            (P::Scan, PathInfo::new("Scan of the finished part", PathKind::Read("Points", &[SCAN_ENDINGS], false))),
            (P::MovedFile, FIND),
        ];
        &TABLE
    }
}
