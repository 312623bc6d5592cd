//! Compensation of deviations by the singular value decomposition, over every rank, P4 (10) to (13).

/// True sums of deviations over the number of singular values kept.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RankCurve {
    /// The singular values, falling.
    pub singular_values: Vec<f64>,
    /// For each rank k from 1: the sum of absolute deviations (mm) of the path it leads to; none where that path is so
    /// far off that it cannot be measured.
    pub sums: Vec<Option<f64>>,
    /// The rank with the least sum among paths that cover the surface.
    pub best: usize,
}
