//! Knot vectors whose ends are not repeated, as files may have them, made such that they are.
//!
//! Knots are inserted at both ends of the domain by the algorithm of Boehm; the curve stays what it is.

use std::ops::{Add, Mul};

use glam::DVec4;

/// Control points of one place along a curve: one of a curve, a row of a surface.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Row(pub Vec<DVec4>);

impl Add for &Row {
    type Output = Row;
    fn add(self, other: Self) -> Row {
        Row(self.0.iter().zip(&other.0).map(|(a, b)| *a + *b).collect())
    }
}

impl Mul<f64> for &Row {
    type Output = Row;
    fn mul(self, by: f64) -> Row {
        Row(self.0.iter().map(|p| *p * by).collect())
    }
}

/// Knots and homogeneous control points of the same curve over its domain, both ends repeated `degree + 1` times. None
/// where the numbers do not match or the domain is empty.
pub(super) fn clamped(degree: usize, knots: Vec<f64>, rows: Vec<Row>) -> Option<(Vec<f64>, Vec<Row>)> {
    if degree == 0 || rows.len() <= degree || knots.len() != rows.len() + degree + 1 {
        return None;
    }
    let is_rising = knots.windows(2).all(|w| w[0] <= w[1]) && knots.iter().all(|k| k.is_finite());
    let [from, to] = [knots[degree], knots[rows.len()]];
    if !is_rising || from >= to {
        return None;
    }
    let (knots, rows) = clamped_start(degree, knots, rows, from);
    let turned = |mut knots: Vec<f64>, mut rows: Vec<Row>| {
        rows.reverse();
        knots.reverse();
        knots.iter_mut().for_each(|k| *k = -*k);
        (knots, rows)
    };
    let (knots, rows) = turned(knots, rows);
    let (knots, rows) = clamped_start(degree, knots, rows, -to);
    Some(turned(knots, rows))
}

/// Knots and control points of the same curve, whose first end, at the parameter `u`, is a knot repeated.
fn clamped_start(degree: usize, mut knots: Vec<f64>, mut rows: Vec<Row>, u: f64) -> (Vec<f64>, Vec<Row>) {
    let last = |knots: &[f64]| knots.partition_point(|k| *k <= u) - 1;
    let repeated = knots.iter().filter(|k| **k == u).count();
    for times in repeated..degree {
        let k = last(&knots);
        let place = |i: usize| {
            if i + degree <= k {
                return rows[i].clone();
            }
            if i + times > k {
                return rows[i - 1].clone();
            }
            let share = (u - knots[i]) / (knots[i + degree] - knots[i]);
            &(&rows[i] * share) + &(&rows[i - 1] * (1.0 - share))
        };
        let inserted = (0..=rows.len()).map(place).collect();
        rows = inserted;
        knots.insert(k + 1, u);
    }
    let k = last(&knots);
    let mut clamped = vec![u; degree + 1];
    clamped.extend(&knots[k + 1..]);
    (clamped, rows.split_off(k - degree))
}
