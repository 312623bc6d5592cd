//! Figures for how smoothly an axis moves.

use serde::Serialize;

use super::interpolation::AxisCurves;
use super::pose::Axis;

/// Smoothness of one axis over equal steps of withdrawn distance; degrees for axes that turn.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct AxisSmoothness {
    /// Sum of the sizes of all first differences (mm or deg).
    pub total_variation: f64,
    /// Root mean square of the second differences (mm or deg).
    pub rms_second_difference: f64,
    /// Greatest size of a second difference (mm or deg).
    pub max_second_difference: f64,
    /// Number of sign changes of the first difference: reversals.
    pub sign_changes: usize,
}

/// Most steps that a path is sampled in, however long it is.
const MOST_STEPS: f64 = 1e5;

/// The smoothness of `axis`, sampled every `step` mm of withdrawn distance, in longer steps where these would be too
/// many.
pub fn axis_smoothness(curves: &AxisCurves, axis: Axis, step: f64) -> AxisSmoothness {
    let curve = curves.axis(axis);
    let way = curve.knots()[curve.knots().len() - 1];
    let steps = (way / step).round().clamp(1.0, MOST_STEPS) as usize;
    let values: Vec<f64> = (0..=steps)
        .map(|i| curve.at(way * i as f64 / steps as f64)[0])
        .map(|v| if axis.is_rotary() { v.to_degrees() } else { v })
        .collect();
    AxisSmoothness::of(&values)
}

impl AxisSmoothness {
    /// The figures of `values` at equal steps.
    pub fn of(values: &[f64]) -> Self {
        /// Movements smaller than this are rounding, not reversals.
        const STILL: f64 = 1e-9;
        let first: Vec<f64> = values.windows(2).map(|w| w[1] - w[0]).collect();
        let second: Vec<f64> = first.windows(2).map(|w| w[1] - w[0]).collect();
        let signs: Vec<bool> = first.iter().filter(|d| d.abs() > STILL).map(|d| *d > 0.0).collect();
        let squares: f64 = second.iter().map(|d| d * d).sum();
        Self {
            total_variation: first.iter().map(|d| d.abs()).sum(),
            rms_second_difference: (squares / second.len().max(1) as f64).sqrt(),
            max_second_difference: second.iter().map(|d| d.abs()).fold(0.0, f64::max),
            sign_changes: signs.windows(2).filter(|w| w[0] != w[1]).count(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::objective::ObjectiveValue;
    use crate::pose::Pose;
    use crate::problem::Node;
    use geometry::spline::EndCondition;

    #[test]
    fn a_path_of_any_length_is_sampled_in_bounded_steps() {
        let node = |s: f64| {
            let pose = Pose { x: -s, ..Pose::FINAL };
            Node { s, pose, h: 0.0, clearance: 0.1, objective: ObjectiveValue::default() }
        };
        let nodes = [0.0, 0.25e15, 0.5e15, 0.75e15, 1e15].map(node);
        let curves = AxisCurves::through(&nodes, EndCondition::NotAKnot).unwrap();
        let smooth = axis_smoothness(&curves, Axis::X, 0.5);
        // A straight way has no reversals and is as long as it is, however it is sampled.
        assert!((smooth.total_variation / 1e15 - 1.0).abs() < 1e-9 && smooth.sign_changes == 0, "{smooth:?}");
    }

    #[test]
    fn figures_of_a_short_zigzag() {
        let s = AxisSmoothness::of(&[0.0, 1.0, 0.0, 0.0, 2.0]);
        // First differences 1 -1 0 2, second -2 1 2.
        assert_eq!(s.total_variation, 4.0);
        assert_eq!(s.max_second_difference, 2.0);
        assert!((s.rms_second_difference - 3f64.sqrt()).abs() < 1e-15);
        assert_eq!(s.sign_changes, 2);
    }
}
