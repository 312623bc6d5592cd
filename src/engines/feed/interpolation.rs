//! From nodes to rows: a curve through the nodes of each axis, then rows so dense that linear motion between them
//! stays close to the curve.

use files::Invalid;
use serde::{Deserialize, Serialize};

use super::axis_curve::{AxisCurve, CurveError, CurveKind, Joining};
use super::path::{FeedPath, PathRow};
use super::pose::{Axis, Pose};
use super::problem::Node;
use super::quantise::{DEG_DECIMALS, MM_DECIMALS, quantise_path};
use geometry::frame::Frame;
use geometry::spline::EndCondition;
use glam::DVec3;

/// Parameters of the interpolation between nodes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct InterpolationParams {
    /// Kind of curve that joins the nodes.
    pub kind: CurveKind,
    /// End condition of cubic splines at both ends of the path.
    pub ends: EndCondition,
    /// Degree of NURBS.
    pub degree: usize,
    /// Chordal deviation: greatest distance between linear motion from row to row and the curve, at any point of the
    /// electrode (mm).
    pub chord_error_mm: f64,
}

impl Default for InterpolationParams {
    fn default() -> Self {
        Self { kind: CurveKind::Spline, ends: EndCondition::NotAKnot, degree: 3, chord_error_mm: 0.001 }
    }
}

impl InterpolationParams {
    /// Whether the chord error is one that rows can be rounded to, and the degree one of a smooth curve.
    pub fn validate(&self) -> Result<(), Invalid> {
        Invalid::unless_within("chord_error_mm", self.chord_error_mm, [5e-5, 0.1], "mm")?;
        Invalid::unless_within("degree", self.degree as f64, [3.0, 5.0], "")
    }

    /// Interpolation between nodes.
    pub fn joining(&self) -> Joining {
        match self.kind {
            CurveKind::Spline => Joining::Spline(self.ends),
            CurveKind::Nurbs => Joining::Nurbs(self.degree),
        }
    }
}

/// Most rows from one node to the next.
const MOST_PIECES: f64 = 1e4;
/// Most rows of a path.
const MOST_ROWS: usize = 1_000_000;

/// Reason why no rows can be made that keep to the curve.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum InterpolationError {
    /// Rounding alone moves the electrode's points further than allowed.
    #[error(
        "plan.interpolation.chord_error_mm is {chord_error}: rounding of rows alone moves the electrode by up to \
         {rounding:.6} mm; allow more"
    )]
    Rounding {
        /// Chordal deviation allowed (mm).
        chord_error: f64,
        /// Part of it that rounding takes (mm).
        rounding: f64,
    },
    /// The curve bends so much that it would take too many rows to follow it.
    #[error(
        "the curve bends so much {s:.3} mm before the final pose that it takes {pieces:.0} rows to the next node, more \
         than 10000; raise plan.interpolation.chord_error_mm"
    )]
    TooManyRows {
        /// Where (mm withdrawn).
        s: f64,
        /// Rows needed.
        pieces: f64,
    },
    /// No stretch of the curve takes too many rows, but all of them together do.
    #[error(
        "the curve takes more than {MOST_ROWS} rows in all; raise plan.interpolation.chord_error_mm or plan.step_mm"
    )]
    TooLong,
}

/// The curve of every axis over the withdrawn distance s.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisCurves {
    curves: [AxisCurve; 6],
}

impl AxisCurves {
    /// Curves through `nodes`, at least two of them, s rising.
    ///
    /// # Errors
    /// [`CurveError`] if they are fewer or s does not rise.
    pub fn through(nodes: &[Node], joining: impl Into<Joining>) -> Result<Self, CurveError> {
        let joining = joining.into();
        let s: Vec<f64> = nodes.iter().map(|n| n.s).collect();
        let curve = |axis: Axis| {
            let values: Vec<f64> = nodes.iter().map(|n| n.pose.get(axis)).collect();
            AxisCurve::through(&s, &values, joining)
        };
        let [x, y, z, a, b, c] = Axis::ALL.map(curve);
        Ok(Self { curves: [x?, y?, z?, a?, b?, c?] })
    }

    /// The curve of one axis.
    pub fn axis(&self, axis: Axis) -> &AxisCurve {
        &self.curves[axis as usize]
    }

    /// The pose when withdrawn by `s`.
    pub fn pose(&self, s: f64) -> Pose {
        Pose::from_array(std::array::from_fn(|i| self.curves[i].at(s)[0]))
    }

    /// Rows between knots `i` and `i + 1` needed to keep `chord_error`. Linear interpolation of f over a length h
    /// is off by at most h^2/8 max|f''|; an error in A moves a point by at most `radius` times it, one in B or
    /// C by `reach` times it.
    fn pieces(&self, i: usize, chord_error: f64, Lever { radius, reach }: Lever) -> Result<usize, InterpolationError> {
        let h = self.curves[0].knots()[i + 1] - self.curves[0].knots()[i];
        let [x, y, z, a, b, c] = std::array::from_fn(|k| self.curves[k].greatest_second(i));
        let bend = DVec3::new(x, y, z).length() + radius * a + reach * (b + c);
        let pieces = (h * (bend / (8.0 * chord_error)).sqrt()).ceil().max(1.0);
        if pieces <= MOST_PIECES {
            Ok(pieces as usize)
        } else {
            Err(InterpolationError::TooManyRows { s: self.curves[0].knots()[i], pieces })
        }
    }
}

/// Distances that say how far an electrode's points move when axes turn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lever {
    /// Greatest distance of a point from the blisk axis over the path (mm).
    pub radius: f64,
    /// Greatest distance of a point from the reference point O (mm).
    pub reach: f64,
}

impl Lever {
    /// How far rounding a row moves a point at most (mm): half a step of each of X, Y and Z, together less than a step,
    /// and half a step of each of A, B and C.
    fn rounding(&self) -> f64 {
        let half_turn = 0.5 * 10f64.powi(-(DEG_DECIMALS as i32)).to_radians();
        10f64.powi(-(MM_DECIMALS as i32)) + half_turn * (self.radius + 2.0 * self.reach)
    }
}

/// Frame, reference point and spark gap that a path is given with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathFrame {
    /// W in the coordinates of the loaded mesh.
    pub frame: Frame,
    /// O in W (mm).
    pub reference_point: DVec3,
    /// Spark gap (mm).
    pub spark_gap: f64,
}

/// Rows in feed order that follow `curves` to `chord_error` (mm) with linear motion between them. Every row is
/// rounded to what files print, so that the motion that is verified is the one that is written; the rounding is part
/// of the error.
///
/// # Errors
/// [`InterpolationError`] if the error cannot be kept.
pub fn feed_path(
    curves: &AxisCurves,
    chord_error: f64,
    lever: Lever,
    given_in: PathFrame,
) -> Result<FeedPath, InterpolationError> {
    let rounding = lever.rounding();
    if rounding.is_nan() || rounding >= chord_error {
        return Err(InterpolationError::Rounding { chord_error, rounding });
    }
    let knots = curves.curves[0].knots();
    let mut rows = vec![PathRow { node: 0, s: 0.0, pose: Pose::FINAL }];
    for i in 0..knots.len() - 1 {
        let pieces = curves.pieces(i, chord_error - rounding, lever)?;
        if rows.len() + pieces > MOST_ROWS {
            return Err(InterpolationError::TooLong);
        }
        for k in 1..=pieces {
            let s = knots[i] + (knots[i + 1] - knots[i]) * k as f64 / pieces as f64;
            let node = if k == pieces { i + 1 } else { i };
            rows.push(PathRow { node, s, pose: curves.pose(s) });
        }
    }
    rows.reverse();
    let PathFrame { frame, reference_point, spark_gap } = given_in;
    Ok(quantise_path(&FeedPath { frame, reference_point, spark_gap, rows }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::objective::ObjectiveValue;

    fn nodes() -> Vec<Node> {
        (0..12)
            .map(|i| {
                let s = f64::from(i) * 0.5;
                let pose = Pose { x: -s, y: 0.3 * s * s, z: s.sin(), a: 0.01 * s, b: 0.0, c: 0.1 * (0.7 * s).sin() };
                Node { s, pose, h: 0.0, clearance: 0.1, objective: ObjectiveValue::default() }
            })
            .collect()
    }

    #[test]
    fn linear_motion_between_rows_stays_within_the_chord_error() {
        let kinds = [Joining::Spline(EndCondition::NotAKnot), Joining::Nurbs(3), Joining::Nurbs(5)];
        kinds.into_iter().for_each(stays_within_the_chord_error);
    }

    fn stays_within_the_chord_error(joining: Joining) {
        let curves = AxisCurves::through(&nodes(), joining).unwrap();
        let o = DVec3::new(10.0, 0.0, 117.0);
        let points = [DVec3::new(-15.0, 5.0, 126.0), DVec3::new(22.0, -6.0, 110.0), o];
        let radius = 130.0;
        let reach = points.iter().map(|p| p.distance(o)).fold(0.0, f64::max);
        let given_in = PathFrame { frame: Frame::IDENTITY, reference_point: o, spark_gap: 0.1 };
        let path = feed_path(&curves, 0.001, Lever { radius, reach }, given_in).unwrap();
        for pair in path.rows.windows(2) {
            for k in 0..=20 {
                let t = f64::from(k) / 20.0;
                let linear = pair[0].pose.lerp(&pair[1].pose, t).placement(o);
                // s is rounded too: the place on the curve is that far uncertain.
                let near = (-5..=5).map(|i| curves.pose(pair[0].s + (pair[1].s - pair[0].s) * t + 1e-6 * f64::from(i)));
                let near: Vec<_> = near.map(|pose| pose.placement(o)).collect();
                for &p in &points {
                    let at = linear.transform_point3(p);
                    let off = near.iter().map(|c| at.distance(c.transform_point3(p))).fold(f64::INFINITY, f64::min);
                    // Between two of the places tried the curve goes on by less than 1e-6 mm times its speed.
                    assert!(off <= 0.001 + 2e-6, "{off} mm");
                }
            }
        }
    }

    #[test]
    fn nurbs_leave_x_linear_and_reproduce_a_cubic_motion() {
        let nodes: Vec<Node> = [0.0, 0.5, 0.75, 0.8, 1.3, 2.3, 2.8]
            .map(|s: f64| Node { s, pose: Pose { x: -s, c: 0.01 * s.powi(3) - 0.02 * s, ..Pose::FINAL }, ..nodes()[0] })
            .to_vec();
        let curves = AxisCurves::through(&nodes, Joining::Nurbs(3)).unwrap();
        for i in 0..=280 {
            let s = 0.01 * f64::from(i);
            let pose = curves.pose(s);
            assert!((pose.x + s).abs() < 1e-12 && (pose.c - (0.01 * s.powi(3) - 0.02 * s)).abs() < 1e-12, "{s}");
        }
        let params = InterpolationParams { kind: CurveKind::Nurbs, degree: 4, ..Default::default() };
        assert_eq!((params.validate(), params.joining()), (Ok(()), Joining::Nurbs(4)));
        let error = InterpolationParams { degree: 2, ..params }.validate().unwrap_err();
        assert_eq!((error.key.as_str(), error.value.as_str()), ("degree", "2"));
    }

    #[test]
    fn an_error_that_cannot_be_kept_is_refused_and_not_passed_over() {
        let curves = AxisCurves::through(&nodes(), EndCondition::NotAKnot).unwrap();
        let given_in = PathFrame { frame: Frame::IDENTITY, reference_point: DVec3::ZERO, spark_gap: 0.1 };
        let rows = |chord_error, radius| feed_path(&curves, chord_error, Lever { radius, reach: 30.0 }, given_in);
        // Half of 1e-6 deg at 1e4 mm is 8.7e-5 mm.
        assert!(matches!(rows(9e-5, 1e4), Err(InterpolationError::Rounding { .. })));
        assert!(rows(1.1e-4, 1e4).is_ok());
        let wild = Pose { y: 1e7, ..Pose::FINAL };
        let jump = [nodes(), vec![Node { s: 5.6, pose: wild, ..nodes()[0] }]].concat();
        let curves = AxisCurves::through(&jump, EndCondition::NotAKnot).unwrap();
        let error = feed_path(&curves, 0.001, Lever { radius: 1.0, reach: 1.0 }, given_in).unwrap_err();
        assert!(matches!(error, InterpolationError::TooManyRows { .. }), "{error}");
        let zigzag = |i: u32| {
            let y = if i.is_multiple_of(2) { 1e4 } else { -1e4 };
            Node { s: 0.5 * f64::from(i), pose: Pose { y, ..Pose::FINAL }, ..nodes()[0] }
        };
        let many: Vec<Node> = (0..400).map(zigzag).collect();
        let curves = AxisCurves::through(&many, EndCondition::NotAKnot).unwrap();
        let error = feed_path(&curves, 0.001, Lever { radius: 1.0, reach: 1.0 }, given_in).unwrap_err();
        assert_eq!(error, InterpolationError::TooLong);
    }

    #[test]
    fn a_path_runs_from_outside_to_the_final_pose_through_every_node() {
        let kinds = [Joining::Spline(EndCondition::NotAKnot), Joining::Nurbs(3)];
        kinds.into_iter().for_each(runs_through_every_node);
    }

    fn runs_through_every_node(joining: Joining) {
        let nodes = nodes();
        let curves = AxisCurves::through(&nodes, joining).unwrap();
        let given_in = PathFrame { frame: Frame::IDENTITY, reference_point: DVec3::ZERO, spark_gap: 0.1 };
        let path = feed_path(&curves, 0.001, Lever { radius: 1.0, reach: 1.0 }, given_in).unwrap();
        assert_eq!(path.rows.last().map(|r| (r.node, r.s, r.pose)), Some((0, 0.0, Pose::FINAL)));
        assert!(path.rows.windows(2).all(|w| w[0].s > w[1].s));
        for (i, node) in nodes.iter().enumerate() {
            let row = path.rows.iter().rfind(|r| r.s <= node.s && r.node == i).unwrap();
            assert!((row.pose.y - node.pose.y).abs() <= 1e-5 && (row.pose.c - node.pose.c).abs() <= 1e-7, "node {i}");
        }
    }
}
