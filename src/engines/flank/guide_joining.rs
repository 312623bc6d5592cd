//! How far the smooth curve through a guide's points leaves the straight lines between them, and whether the points
//! account for that: what is straight or has a corner is milled otherwise than it was meant.

use glam::DVec3;

use super::FlankError;
use super::guide::{self, GuideCurve};
use geometry::nurbs::NurbsCurve;

/// Where the curve through a guide's points leaves the straight lines between them most, or as the points least account
/// for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Joining {
    /// Name of the guide: lower, upper.
    pub which: &'static str,
    /// The first of the two points between which that is, counted from 1.
    pub point: usize,
    /// Greatest distance of the curve from the line between the two points (mm).
    pub departure_mm: f64,
    /// Place of that distance (mm).
    pub at: DVec3,
    /// How much the line through the points turns at the one of the two where it turns more (rad).
    pub turn: f64,
    /// Whether the points do not account for it.
    pub is_doubtful: bool,
}

impl Joining {
    /// Departures up to this are of no account (mm).
    const LEAST_MM: f64 = 0.05;
    /// Greatest turn of the line at a point of a curve (rad), 30 degrees: a circle has twelve points then. A line that
    /// turns more has a corner, or is measured too coarsely to tell.
    const SHARP: f64 = 30.5 * std::f64::consts::PI / 180.0;
    /// How many times the departure of the circle that turns as the points do there a curve may have: twice where
    /// points stand at uneven distances, twice where the curvature changes.
    const TIMES: f64 = 4.0;

    /// Of each guide that is a row of points joined by a smooth curve, where it leaves the lines between them most;
    /// first of all where the points do not account for that.
    ///
    /// # Errors
    /// Every error of [`GuideCurve::curve`], of a guide that is no curve.
    pub fn of(lower: &GuideCurve, upper: &GuideCurve) -> Result<Vec<Self>, FlankError> {
        let curves = guide::pair(lower, upper)?;
        let parameters = guide::row_parameters(lower, upper)?;
        let guides = [("lower", lower), ("upper", upper)];
        let one = |(((which, guide), curve), parameters): (((_, &GuideCurve), &NurbsCurve), &Option<Vec<f64>>)| {
            let GuideCurve::Points { points, .. } = guide else { return None };
            worst(which, points, curve, parameters.as_ref()?)
        };
        Ok(guides.into_iter().zip(&curves).zip(&parameters).filter_map(one).collect())
    }

    /// One line on it.
    pub fn words(&self) -> String {
        let Self { which, point, departure_mm, turn, is_doubtful, .. } = self;
        let next = point + 1;
        if *is_doubtful {
            format!(
                "the points of the {which} guide are joined by a smooth curve, which leaves the straight line between \
                 points {point} and {next} by {departure_mm:.3} mm, where the line through the points turns by {:.1} \
                 degrees: give more points where it should stay straight or is bent sharply, and a flank of its own \
                 for each side of a corner",
                turn.to_degrees()
            )
        } else {
            format!("{departure_mm:.3} mm on the {which} guide, between points {point} and {next}")
        }
    }
}

fn worst(which: &'static str, points: &[DVec3], curve: &NurbsCurve, parameters: &[f64]) -> Option<Joining> {
    let turns = turns(points);
    let pieces = (1..points.len().min(parameters.len())).map(|i| {
        let turn = turns[i - 1].max(turns[i]);
        let ends = [points[i - 1], points[i]];
        let (departure_mm, at) = departure(curve, [parameters[i - 1], parameters[i]], ends);
        // The sagitta of a chord of this length whose circle turns so much from one to the next.
        let explained = ends[0].distance(ends[1]) * turn / 8.0;
        let is_doubtful = departure_mm > Joining::LEAST_MM
            && (turn > Joining::SHARP || departure_mm > Joining::TIMES * explained + Joining::LEAST_MM);
        Joining { which, point: i, departure_mm, at, turn, is_doubtful }
    });
    pieces.reduce(|a, b| {
        let is_worse = (b.is_doubtful, b.departure_mm) > (a.is_doubtful, a.departure_mm);
        if is_worse { b } else { a }
    })
}

/// How far a piece of a curve leaves the line between its ends at most (mm), and where.
fn departure(curve: &NurbsCurve, [from, to]: [f64; 2], [a, b]: [DVec3; 2]) -> (f64, DVec3) {
    /// Places within a piece, as a cubic has at most two turns there.
    const LOOKS: usize = 8;
    let mut most = (0.0, a);
    for k in 1..LOOKS {
        let p = curve.point(from + (to - from) * k as f64 / LOOKS as f64);
        let share = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
        let off = p.distance(a.lerp(b, share));
        if off > most.0 {
            most = (off, p);
        }
    }
    most
}

/// How much the line through points turns at each (rad): nothing at its ends, unless it ends where it begins.
fn turns(points: &[DVec3]) -> Vec<f64> {
    let turn = |a: DVec3, b: DVec3, c: DVec3| (b - a).angle_between(c - b);
    let mut turns = vec![0.0; points.len()];
    for (i, w) in points.windows(3).enumerate() {
        turns[i + 1] = turn(w[0], w[1], w[2]);
    }
    if let [first, second, .., behind, last] = points
        && guide::is_near(points, *first, *last)
    {
        let seam = turn(*behind, *last, *second);
        let end = points.len() - 1;
        (turns[0], turns[end]) = (seam, seam);
    }
    turns
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(points: Vec<DVec3>) -> GuideCurve {
        GuideCurve::Points { points, degree: 3 }
    }

    fn both(points: &[DVec3]) -> Vec<Joining> {
        let upper = points.iter().map(|p| *p + 10.0 * DVec3::Z).collect();
        Joining::of(&row(points.to_vec()), &row(upper)).unwrap()
    }

    fn circle(count: usize, turn: f64) -> Vec<DVec3> {
        let at = |i: usize| turn * i as f64 / count as f64;
        (0..=count).map(|i| 20.0 * DVec3::new(at(i).cos(), at(i).sin(), 0.0)).collect()
    }

    #[test]
    fn points_on_curves_are_no_doubt_and_the_departure_is_the_sagitta_of_a_circle() {
        for count in [12, 16, 48, 1000] {
            for turn in [std::f64::consts::TAU, 3.0] {
                for found in both(&circle(count, turn)) {
                    let sagitta = 20.0 * (1.0 - (0.5 * turn / count as f64).cos());
                    assert!(!found.is_doubtful, "{found:?}");
                    // Of few points the cubic is not quite the circle.
                    assert!((found.departure_mm - sagitta).abs() < 0.15 * sagitta, "{found:?} {sagitta}");
                }
            }
        }
        // Points at distances that differ eight times, on a parabola and on a sine.
        let uneven = |i: usize| i as f64 + if i.is_multiple_of(2) { 0.0 } else { -0.75 };
        for shape in [|x: f64| 0.02 * x * x, |x: f64| 2.0 * (0.3 * x).sin()] {
            let points: Vec<DVec3> = (0..=30).map(uneven).map(|x| DVec3::new(x, shape(x), 0.0)).collect();
            assert!(both(&points).iter().all(|found| !found.is_doubtful), "{:?}", both(&points));
        }
        // A straight line leaves nothing, and noise below the tolerance is no corner.
        let rough: Vec<DVec3> =
            (0..200).map(|i| DVec3::new(0.02 * f64::from(i), if i % 2 == 0 { 0.0 } else { 0.02 }, 0.0)).collect();
        assert!(both(&rough).iter().all(|found| !found.is_doubtful && found.turn > 1.0));
        let straight: Vec<DVec3> = [0.0, 1.0, 1.1, 30.0].map(|x| DVec3::new(x, 0.0, 0.0)).to_vec();
        assert!(both(&straight).iter().all(|found| found.departure_mm < 1e-9));
    }

    #[test]
    fn corners_and_straight_pieces_that_become_round_are_found_where_they_are() {
        let corners = |all: &[[f64; 2]]| all.iter().map(|[x, y]| DVec3::new(*x, *y, 0.0)).collect::<Vec<_>>();
        let square = corners(&[[0.0, 0.0], [40.0, 0.0], [40.0, 40.0], [0.0, 40.0], [0.0, 0.0]]);
        for found in both(&square) {
            assert!(found.is_doubtful && found.departure_mm > 2.0 && found.departure_mm < 20.0, "{found:?}");
            assert!((found.turn.to_degrees() - 90.0).abs() < 1e-9 && found.words().contains("turns by 90.0 degrees"));
        }
        // An L of three points is a parabola.
        let l = both(&corners(&[[0.0, 0.0], [20.0, 0.0], [20.0, 20.0]]));
        assert!(l.len() == 2 && l.iter().all(|found| found.is_doubtful), "{l:?}");
        // Straight, an arc of 5 mm in dense points, straight: no point turns sharply, and the straight ends are bent.
        let arc = (0..=20).map(|i| f64::from(i) * 4.5f64.to_radians());
        let arc = arc.map(|a| DVec3::new(50.0 + 5.0 * a.sin(), 5.0 - 5.0 * a.cos(), 0.0));
        let ends = [DVec3::ZERO, DVec3::new(55.0, 55.0, 0.0)];
        let slot: Vec<DVec3> = std::iter::once(ends[0]).chain(arc).chain([ends[1]]).collect();
        for found in both(&slot) {
            assert!(found.is_doubtful && found.turn < 0.1 && [1, slot.len() - 1].contains(&found.point), "{found:?}");
            assert!(found.departure_mm > 1.0 && found.words().contains("straight line between points"), "{found:?}");
        }
    }
}
