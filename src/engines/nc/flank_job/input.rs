//! Input of a flank plan: surface, cutter, walls, and parameters of the milling.

use std::sync::Arc;

use files::{Override, sha256};
use glam::DVec3;

use super::settings::{MillingSettings, PathChoice};
use flank::cutter::FlankCutter;
use flank::fit_ruled::Candidate;
use flank::guide::GuideCurve;
use flank::machine::milling_machine::MillingMachine;
use flank::params::FlankParams;
use flank::ruled_surface::Side;
use geometry::mesh::Mesh;

/// Source of a surface, read from its files.
#[derive(Debug, Clone)]
pub enum LoadedSurface {
    /// Two guides.
    Guides {
        /// Guide that the cutter's bottom follows.
        lower: GuideCurve,
        /// Upper guide.
        upper: GuideCurve,
    },
    /// A face of a mesh.
    Face {
        /// The mesh.
        mesh: Arc<Mesh>,
        /// Faces that could be milled, as [`flank_candidates`](flank::fit_ruled::flank_candidates) has them.
        candidates: Arc<Vec<Candidate>>,
        /// Number of the face, from 1.
        number: usize,
        /// Whether the rest of the mesh is looked at for gouges.
        is_own_wall: bool,
    },
}

impl LoadedSurface {
    /// Digest of the guides, or of the mesh with the number of its face.
    pub(super) fn digest(&self) -> String {
        let mut bytes = Vec::new();
        let mut add =
            |point: &DVec3| point.to_array().iter().for_each(|part| bytes.extend(part.to_bits().to_le_bytes()));
        match self {
            Self::Guides { lower, upper } => return sha256(format!("{lower:?} {upper:?}").as_bytes()),
            Self::Face { mesh, number, .. } => {
                mesh.vertices.iter().for_each(&mut add);
                bytes.extend(mesh.triangles.iter().flatten().flat_map(|corner| corner.to_le_bytes()));
                bytes.extend(number.to_le_bytes());
            }
        }
        sha256(&bytes)
    }
}

/// Input of a flank.
#[derive(Debug, Clone)]
pub struct FlankInput {
    /// Name of the flank.
    pub name: String,
    /// The surface.
    pub surface: LoadedSurface,
    /// Doubts about the files of surface and walls, in words.
    pub doubts: Vec<String>,
    /// Side of the surface that the cutter stands on.
    pub side: Side,
    /// The cutter.
    pub cutter: FlankCutter,
    /// Parameters of the path.
    pub params: FlankParams,
    /// Path that is milled.
    pub path: PathChoice,
    /// Other walls that must not be cut.
    pub walls: Option<Arc<Mesh>>,
    /// The machine; none for cutter locations only.
    pub machine: Option<MillingMachine>,
    /// Machine settings, clearances and motions of the milling.
    pub milling: MillingSettings,
    /// Greatest difference between the swept envelope and the static deviation at any sample (mm).
    pub envelope_tolerance_mm: f64,
    /// Greatest overcut, static or of the swept envelope (mm).
    pub overcut_tolerance_mm: f64,
    /// Greatest undercut, static or of the swept envelope (mm).
    pub undercut_tolerance_mm: f64,
    /// Checks that do not keep anything from being exported.
    pub overrides: Vec<Override>,
    /// Whether checks are taken on the plan's own coarse grid, for a preview; nothing may be milled by them.
    pub is_preview: bool,
}
