//! The cursor of the timeline.

/// Where the electrode stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cursor {
    /// Which electrode is looked at.
    pub electrode: usize,
    /// Distance withdrawn (mm).
    pub s: f64,
    /// Whether it moves by itself.
    pub playing: bool,
    /// How fast (mm/s).
    pub speed: f64,
}
