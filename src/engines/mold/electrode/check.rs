//! Checks that nothing may skip: whether an electrode is closed, enters nothing on its way, leaves nothing, and can be
//! milled.

use glam::DVec3;
use serde::{Deserialize, Serialize};

pub use super::clearance::{Clearance, GOUGE, Obstacle};
pub use super::leftover::{LeftOfRegion, Milled, Sample, leftover};
pub use super::milling::machinable;
use geometry::mesh::Mesh;
use geometry::solid;

/// Vertices within this are one in a file of single precision (mm).
const WELD: f64 = 1e-6;

/// What a check is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CheckKind {
    /// The surface is closed.
    Watertight,
    /// Where it burns it keeps the gap.
    Gouge,
    /// On its way in and out it keeps the gap.
    Approach,
    /// What it was made for is burned.
    Leftover,
    /// It can be milled.
    Machinable,
}

impl CheckKind {
    /// All of them, in the order in which they are made.
    pub const ALL: [Self; 5] = [Self::Watertight, Self::Gouge, Self::Approach, Self::Leftover, Self::Machinable];

    /// How it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Watertight => "watertight",
            Self::Gouge => "gouge",
            Self::Approach => "approach",
            Self::Leftover => "leftover",
            Self::Machinable => "machinable",
        }
    }
}

/// What a check found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// What it is about.
    pub kind: CheckKind,
    /// Whether it holds.
    pub holds: bool,
    /// What was found, in words with its figures.
    pub text: String,
    /// Where, in the upright mold (mm).
    pub place: Option<DVec3>,
}

impl Finding {
    /// What was found.
    pub(super) fn new(kind: CheckKind, holds: bool, text: String, place: Option<DVec3>) -> Self {
        Self { kind, holds, text, place }
    }

    /// One that does not hold.
    pub(super) fn failed(kind: CheckKind, text: String) -> Self {
        Self::new(kind, false, text, None)
    }
}

/// Whether a surface is closed.
pub fn watertight(mesh: &Mesh) -> Finding {
    let volume = mesh.volume();
    let is_closed = mesh.is_watertight() && solid::is_closed(mesh, WELD);
    let holds = is_closed && volume > 0.0;
    let text = if holds {
        format!("closed; {volume:.2} mm^3")
    } else if is_closed {
        format!("its faces look inwards ({volume:.2} mm^3): turn them round")
    } else {
        "its surface has open edges or touches itself: no other check means anything".into()
    };
    Finding::new(CheckKind::Watertight, holds, text, None)
}
