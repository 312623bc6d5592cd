//! The paths that the workspace asks for.

use crate::workspaces::context::{Endings, PROJECT, PathInfo, PathKind, PathSet, TOML};
use crate::workspaces::moved_files::FIND;
use import::MESH_ENDINGS;

/// Purpose of a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FlankPath {
    /// A flank that was saved, or a mesh with one.
    Open,
    /// Points of the lower guide curve.
    Lower,
    /// File of the upper guide.
    Upper,
    /// A mesh with the flank.
    Mesh,
    /// Walls that must not be cut.
    Walls,
    /// A machine of one's own.
    Machine,
    /// A post of one's own.
    Post,
    /// Folder for the exported files.
    Folder,
    /// A file of a project that is elsewhere now.
    MovedFile,
}

impl PathSet for FlankPath {
    fn table() -> &'static [(Self, PathInfo)] {
        use FlankPath as P;
        const POINTS: &[&str] = &["csv", "txt"];
        const OPEN: Endings = &[PROJECT, MESH_ENDINGS, POINTS];
        const fn file(title: &'static str, what: &'static str, endings: Endings) -> PathInfo {
            PathInfo::new(title, PathKind::Read(what, endings, true))
        }
        static TABLE: [(P, PathInfo); 9] = [
            (P::Open, PathInfo { opens: true, ..file("Open a flank", "Flanks, meshes and points", OPEN) }),
            (P::Lower, file("Points of the lower guide curve", "Points", &[POINTS])),
            (P::Upper, file("Points of the upper guide curve", "Points", &[POINTS])),
            (P::Mesh, file("Mesh with the flank", "Meshes", &[MESH_ENDINGS])),
            (P::Walls, file("Neighbouring walls", "Meshes", &[MESH_ENDINGS])),
            (P::Machine, file("Your own milling machine", "Machine", &[TOML])),
            (P::Post, file("Your own post for milling", "Post", &[TOML])),
            (P::Folder, PathInfo::new("Folder for the flank's files", PathKind::Folder)),
            (P::MovedFile, FIND),
        ];
        &TABLE
    }
}
