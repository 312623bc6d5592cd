//! What the moving cutter leaves: its true envelope, and a brute-force sweep to check it.

use super::deviation::Deviation;

/// Deviation of the moving cutter, and how it compares with that of the standing one.
#[derive(Debug, Clone, PartialEq)]
pub struct EnvelopeCheck {
    /// Deviation of the moving cutter over the same grid.
    pub deviation: Deviation,
    /// Greatest difference to the standing cutter's (mm).
    pub greatest_difference: f64,
    /// Places without a grazing point over them; there the standing cutter's deviation stands.
    pub without: usize,
}
