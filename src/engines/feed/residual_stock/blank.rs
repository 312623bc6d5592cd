//! Stock of a wheel before electrodes burn it.

use geometry::exact::{ExactMesh, ExactMeshError};
use geometry::mesh::Mesh;
use glam::DVec3;

/// A wheel before electrodes burn it.
#[derive(Debug, Clone, Copy, Default)]
pub enum Blank<'a> {
    /// A ring whose channels are full of stock.
    #[default]
    Full,
    /// A wheel that was cast, printed or roughed before: this much stock on every surface of its channels (mm).
    Allowance(f64),
    /// The wheel as it comes: its closed surface in W (mm).
    Solid(&'a Mesh),
}

/// A blank made ready to be asked.
pub(super) enum Stocked {
    Full,
    /// Stock as far as this from the finished blisk (mm).
    Near(ExactMesh, f64),
    Within(ExactMesh),
}

impl Stocked {
    pub(super) fn new(blank: Blank, blisk: &Mesh) -> Result<Self, ExactMeshError> {
        Ok(match blank {
            Blank::Full => Self::Full,
            Blank::Allowance(mm) => Self::Near(ExactMesh::new(blisk)?, mm),
            Blank::Solid(mesh) => Self::Within(ExactMesh::new(mesh)?),
        })
    }

    /// Whether there was stock everywhere.
    pub(super) fn is_full(&self) -> bool {
        matches!(self, Self::Full)
    }

    /// Whether there was stock at `p`, between the finished walls of a channel (mm, in W).
    pub(super) fn holds(&self, p: DVec3) -> bool {
        match self {
            Self::Full => true,
            Self::Near(blisk, mm) => blisk.signed_distance(p) <= *mm,
            Self::Within(blank) => blank.signed_distance(p) <= 0.0,
        }
    }

    /// The thickness of the stock on a finished surface at `p` that an electrode leaves `deviation` of (mm).
    pub(super) fn left(&self, p: DVec3, deviation: f64) -> f64 {
        match self {
            Self::Full => deviation,
            Self::Near(_, mm) => deviation.min(*mm),
            Self::Within(_) if deviation > 0.0 && !self.holds(p) => 0.0,
            Self::Within(_) => deviation,
        }
    }
}
