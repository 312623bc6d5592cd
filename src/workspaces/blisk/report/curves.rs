//! From rows to the curves that the report plots.

use crate::workspaces::blisk::report::Motion;
use feed::pose::Axis;
use feed::quantise::MM_DECIMALS;
use files::svg_plot::{Plot, Series};

/// Most intervals that derivatives are taken over.
const INTERVALS: f64 = 60.0;

/// Values of one axis over `s`, s rising: mm, or degrees for a rotary axis.
pub(super) fn axis_curve(motion: &Motion, axis: Axis) -> Vec<[f64; 2]> {
    let value = |v: f64| if axis.is_rotary() { v.to_degrees() } else { v };
    let mut points: Vec<_> = motion.rows.iter().map(|r| [r.s, value(r.pose.get(axis))]).collect();
    points.sort_by(|p, q| p[0].total_cmp(&q[0]));
    points
}

/// First and second derivative of a curve, from the parabola through each three neighbours among points that
/// are far enough apart for the rounding of the values not to show.
pub(super) fn derivatives(curve: &[[f64; 2]]) -> [Vec<[f64; 2]>; 2] {
    let (Some(first), Some(last)) = (curve.first(), curve.last()) else { return [vec![], vec![]] };
    let apart = (last[0] - first[0]) / INTERVALS;
    let mut points = vec![*first];
    for &p in &curve[1..] {
        // A hair less, so that even rows just that far apart all count.
        if points.last().is_some_and(|q| apart > 0.0 && p[0] - q[0] >= apart * (1.0 - 1e-6)) {
            points.push(p);
        }
    }
    let parabola = |w: &[[f64; 2]]| {
        let ([s0, v0], [s1, v1], [s2, v2]) = (w[0], w[1], w[2]);
        let (before, after) = ((v1 - v0) / (s1 - s0), (v2 - v1) / (s2 - s1));
        let slope = (before * (s2 - s1) + after * (s1 - s0)) / (s2 - s0);
        ([s1, slope], [s1, 2.0 * (after - before) / (s2 - s0)])
    };
    let (slope, bend) = points.windows(3).map(parabola).unzip();
    [slope, bend]
}

fn value_at(curve: &[[f64; 2]], s: f64) -> f64 {
    let i = curve.partition_point(|p| p[0] < s).clamp(1, curve.len() - 1);
    let ([s0, v0], [s1, v1]) = (curve[i - 1], curve[i]);
    if s1 > s0 { v0 + (v1 - v0) * ((s - s0) / (s1 - s0)).clamp(0.0, 1.0) } else { v1 }
}

/// The axes that move.
pub(super) fn moving_axes(motion: &Motion) -> Vec<Axis> {
    Axis::ALL.into_iter().filter(|&axis| motion.rows.iter().any(|r| r.pose.get(axis) != 0.0)).collect()
}

/// Position, first and second derivative of `axis` side by side; `nodes` are the s of the search nodes.
pub(super) fn axis_plots(motion: &Motion, axis: Axis, nodes: &[f64]) -> [Plot; 3] {
    let curve = axis_curve(motion, axis);
    let [slope, bend] = derivatives(&curve);
    let (letter, unit) = (axis.letter(), if axis.is_rotary() { "\u{b0}" } else { "mm" });
    let at_nodes = if curve.len() > 1 { nodes.iter().map(|&s| [s, value_at(&curve, s)]).collect() } else { vec![] };
    let class = ["c0", "c1", "c2", "c3", "c4", "c5"][axis as usize];
    let line = |points| Series { points, class, dots: false };
    let span = curve.first().zip(curve.last()).map_or(0.0, |(p, q)| q[0] - p[0]);
    let (step, noise) = (span / INTERVALS, 0.5 * 10f64.powi(-(MM_DECIMALS as i32)));
    // What rounding alone can do to a derivative must look flat.
    let range = |order: i32| if step > 0.0 { 40.0 * noise * (2.0 / step).powi(order) } else { 0.0 };
    let plot = |title: String, order: i32, series| Plot {
        title,
        least_range: range(order),
        x_label: "s, mm retracted".to_owned(),
        size: [360.0, 190.0],
        series,
        ..Plot::default()
    };
    let dots = Series { points: at_nodes, class: "n", dots: true };
    [
        plot(format!("{letter}, {unit}"), 0, vec![line(curve), dots]),
        plot(format!("d{letter}/ds, {unit}/mm"), 1, vec![line(slope)]),
        plot(format!("d\u{b2}{letter}/ds\u{b2}, {unit}/mm\u{b2}"), 2, vec![line(bend)]),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use feed::path::PathRow;
    use feed::pose::Pose;

    #[test]
    fn derivatives_of_a_cubic_are_its_parabola_and_line() {
        let s = |i: usize| i as f64 * 0.1;
        let y = |s: f64| 2.0 + s - 0.5 * s * s + 0.1 * s * s * s;
        let rows = (0..=400).rev().map(|i| PathRow { node: 0, s: s(i), pose: Pose { y: y(s(i)), ..Pose::FINAL } });
        let motion = Motion { rows: rows.collect(), clearance: vec![] };
        let [slope, bend] = derivatives(&axis_curve(&motion, Axis::Y));
        assert!((50..60).contains(&slope.len()), "{}", slope.len());
        for ([s, d], [_, dd]) in slope.into_iter().zip(bend) {
            assert!((d - (1.0 - s + 0.3 * s * s)).abs() < 0.1, "{s} {d}");
            assert!((dd - (-1.0 + 0.6 * s)).abs() < 1e-6, "{s} {dd}");
        }
        assert_eq!(moving_axes(&motion), [Axis::Y]);
    }

    #[test]
    fn short_or_standing_paths_have_no_derivative() {
        assert!(derivatives(&[]).concat().is_empty());
        assert!(derivatives(&[[0.0, 1.0]; 30]).concat().is_empty());
    }
}
