//! The paths that the workspace asks for.

use crate::workspaces::context::{PathInfo, PathKind, PathSet};

/// What the workspace asks paths for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MoldPath {
    /// The mesh of a mold, or a mold that was saved.
    Open,
    /// A library of cutters.
    Cutters,
    /// Another one to compare with.
    OtherCutters,
    /// Folder for the files of electrodes.
    ElectrodeFolder,
    /// A template of the burn sheet.
    BurnSheet,
    /// Where the cutters are saved.
    SaveCutters,
}

impl PathSet for MoldPath {
    fn table() -> &'static [(Self, PathInfo)] {
        use MoldPath as P;
        const TOML: &[&str] = &["toml"];
        const OPEN: &[&str] = &["stl", "STL", "obj", "OBJ", "gltf", "glb", "GLTF", "GLB", "sparkpath"];
        const fn info(title: &'static str, kind: PathKind) -> PathInfo {
            PathInfo { title, kind, opens: false }
        }
        static TABLE: [(P, PathInfo); 6] = [
            (
                P::Open,
                PathInfo { title: "Open a mold", kind: PathKind::Read("Molds and meshes", OPEN, false), opens: true },
            ),
            (P::Cutters, info("Load cutters", PathKind::Read("Cutters", TOML, false))),
            (P::OtherCutters, info("Load cutters to compare with", PathKind::Read("Cutters", TOML, false))),
            (P::ElectrodeFolder, info("Folder for the electrodes", PathKind::Folder)),
            (P::BurnSheet, info("Template of the burn sheet", PathKind::Read("", &[], false))),
            (P::SaveCutters, info("Save cutters", PathKind::Write("Cutters", ".toml"))),
        ];
        &TABLE
    }
}
