//! Points along edges, shared by the faces on both sides.

use geometry::nurbs::{KnotVector, NurbsCurve};
use glam::DVec3;

use super::Fineness;
use super::clamp::{Row, clamped};

/// How often a piece of a curve is halved at most.
const HALVINGS: u32 = 14;

/// Greatest coordinate of a curve (units of the file). Further away numbers are coarser than chords may be off, and curves would be
/// halved for ever.
const FARTHEST: f64 = 1e12;

/// The curve; none if it is no NURBS curve, or goes beyond what can be measured.
pub(super) fn curve(from: &step_io::scene::NurbsCurve) -> Option<NurbsCurve> {
    let points = from.control_points.iter().zip(&from.weights);
    let rows = points.map(|(p, w)| Row(vec![(DVec3::from(*p) * *w).extend(*w)])).collect();
    let (knots, rows) = clamped(from.degree, from.knots.clone(), rows)?;
    let (points, weights): (Vec<DVec3>, Vec<f64>) =
        rows.iter().flat_map(|row| &row.0).map(|p| (p.truncate() / p.w, p.w)).unzip();
    if !points.iter().all(|p| p.abs().max_element() <= FARTHEST) {
        return None;
    }
    NurbsCurve::new(KnotVector::new(from.degree, knots).ok()?, &points, &weights).ok()
}

/// Points within the curve, its ends not among them, so close that chords leave the curve by no more than `fine` says.
/// A closed curve has at least three. Each piece of the curve is halved `level` times in any case.
pub(super) fn points(curve: &NurbsCurve, is_closed: bool, level: u32, fine: &Fineness) -> Vec<DVec3> {
    let joints = curve.knots().joints();
    let parts = if is_closed { (4 / (joints.len() - 1)).max(1) } else { 1 };
    let parts = parts << level;
    let mut found = Vec::new();
    let last = *joints.last().unwrap_or(&0.0);
    for w in joints.windows(2) {
        for k in 0..parts {
            let place = |k: usize| w[0] + (w[1] - w[0]) * k as f64 / parts as f64;
            let ends = [place(k), if k + 1 == parts { w[1] } else { place(k + 1) }];
            halve(curve, ends, ends.map(|u| curve.at(u)), HALVINGS, fine, &mut found);
            if ends[1] < last {
                found.push(curve.point(ends[1]));
            }
        }
    }
    found
}

/// Adds the points needed between two places of a curve.
fn halve(
    curve: &NurbsCurve,
    ends: [f64; 2],
    at: [[DVec3; 3]; 2],
    halvings: u32,
    fine: &Fineness,
    found: &mut Vec<DVec3>,
) {
    let middle = 0.5 * (ends[0] + ends[1]);
    let is_fine = |u: f64| fine.allows(at[0][0], at[1][0], curve.point(u));
    let quarter = |k: f64| ends[0] + (ends[1] - ends[0]) * k;
    let turn = at[0][1].angle_between(at[1][1]);
    let is_even = turn <= fine.turn || at[0][0].distance(at[1][0]) <= fine.least_length;
    let ends_alike = is_even && [0.25, 0.5, 0.75].into_iter().all(|k| is_fine(quarter(k)));
    if ends_alike || halvings == 0 || middle <= ends[0] || middle >= ends[1] {
        return;
    }
    let half = curve.at(middle);
    halve(curve, [ends[0], middle], [at[0], half], halvings - 1, fine, found);
    found.push(half[0]);
    halve(curve, [middle, ends[1]], [half, at[1]], halvings - 1, fine, found);
}
