/// stub
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
