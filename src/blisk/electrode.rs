//! stub
use crate::geometry::mesh::Mesh;
use crate::progress::Cancelled;
use glam::DVec3;
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize)]
pub enum ElectrodeFace {
    LowWall,
    HighWall,
    HubSide,
    ShroudSide,
    FarEnd,
    EntryEnd,
    Shank,
    Holder,
}
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize)]
pub enum EntrySide {
    MinusX,
    PlusX,
}
#[derive(Debug, Clone, PartialEq)]
pub struct Electrode {
    pub mesh: Mesh,
    pub faces: Vec<ElectrodeFace>,
    pub enters_from: EntrySide,
    pub reference_point: DVec3,
    pub volume_mm3: f64,
}
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ElectrodeError {
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    #[error("x")]
    X,
}
