//! What the window shows.

/// A workspace of the window: what it is about, with a document of its own.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Workspace {
    /// The feed path of a blisk.
    #[default]
    Blisk,
    /// What cutters leave of a mold, and electrodes for it.
    Mold,
    /// A ruled flank milled with the side of a cutter.
    Flank,
}

impl Workspace {
    /// All of them, in the order of the switch.
    pub const ALL: [Self; 3] = [Self::Blisk, Self::Mold, Self::Flank];

    /// What the switch calls it.
    pub fn name(self) -> &'static str {
        ["Blisk", "Mold", "Flank"][self as usize]
    }
}
