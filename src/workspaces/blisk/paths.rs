//! The paths that the workspace asks for.

use crate::workspaces::context::{MESHES, PathInfo, PathKind, PathSet};

/// What the workspace asks paths for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BliskPath {
    /// Project or mesh to open.
    Open,
    /// Folder for the exported files.
    ExportFolder,
    /// An electrode mesh of one's own.
    ElectrodeMesh,
    /// An NC post of one's own.
    Post,
    /// A machine file of one's own.
    Machine,
    /// A file of a project that is elsewhere now.
    MovedFile,
}

impl PathSet for BliskPath {
    fn table() -> &'static [(Self, PathInfo)] {
        use BliskPath as P;
        const TOML: &[&str] = &["toml"];
        const OPEN: &[&str] = &["stl", "STL", "obj", "OBJ", "gltf", "glb", "GLTF", "GLB", "sparkpath"];
        const fn info(title: &'static str, kind: PathKind) -> PathInfo {
            PathInfo { title, kind, opens: false }
        }
        static TABLE: [(P, PathInfo); 6] = [
            (
                P::Open,
                PathInfo {
                    title: "Open a project or a mesh",
                    kind: PathKind::Read("Projects and meshes", OPEN, false),
                    opens: true,
                },
            ),
            (P::ExportFolder, info("Folder for the exported files", PathKind::Folder)),
            (P::ElectrodeMesh, info("Your own electrode", PathKind::Read("Meshes", MESHES, false))),
            (P::Post, info("Your own NC post", PathKind::Read("Post", TOML, false))),
            (P::Machine, info("Your own machine", PathKind::Read("Machine", TOML, false))),
            (P::MovedFile, info("Find the file", PathKind::Read("Files", &[], false))),
        ];
        &TABLE
    }
}
