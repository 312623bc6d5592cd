//! Guide curves: the two borders that a ruled surface is spanned between.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::FlankError;
use geometry::nurbs::{KnotVector, NurbsCurve, NurbsError, chord_parameters};

/// A guide curve as it is given; its curve runs from u = 0 to u = 1.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum GuideCurve {
    /// A Bezier curve, of a degree one less than its points.
    Bezier {
        /// Control points (mm), 2 to 8.
        points: Vec<DVec3>,
    },
    /// A B-spline.
    BSpline {
        /// Degree, 1 to 15.
        degree: usize,
        /// Knots, both ends repeated `degree + 1` times.
        knots: Vec<f64>,
        /// Control points (mm).
        points: Vec<DVec3>,
        /// Weights; empty for all the same.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        weights: Vec<f64>,
    },
    /// A curve through points, with parameters by chord length.
    Points {
        /// The points (mm), two at least.
        points: Vec<DVec3>,
        /// The degree between them, 1 to 15; less where points are few.
        #[serde(default = "cubic")]
        degree: usize,
    },
}

/// Both curves, from u = 0 to 1. Two rows with as many points each have shared parameters, the means of both rows' own.
///
/// # Errors
/// [`FlankError::Guide`] that says which is wrong, [`FlankError::TooManyPoints`].
pub(super) fn pair(lower: &GuideCurve, upper: &GuideCurve) -> Result<[NurbsCurve; 2], FlankError> {
    let wrong = |which| {
        let guide = if which == "lower" { lower } else { upper };
        move |reason| guide.wrong(which, reason)
    };
    let rows = [lower, upper].map(|guide| match guide {
        GuideCurve::Points { points, degree } => Some((points, *degree)),
        _ => None,
    });
    if rows.iter().flatten().any(|(points, _)| points.len() > GuideCurve::MOST_POINTS) {
        return Err(FlankError::TooManyPoints { most: GuideCurve::MOST_POINTS });
    }
    let [Some((low, low_degree)), Some((high, high_degree))] = rows else {
        return Ok([lower.curve().map_err(wrong("lower"))?, upper.curve().map_err(wrong("upper"))?]);
    };
    // What is wrong with a row by itself is said of it.
    let own = [lower.curve().map_err(wrong("lower"))?, upper.curve().map_err(wrong("upper"))?];
    if low.len() != high.len() {
        return Ok(own);
    }
    let [Some(shared), _] = row_parameters(lower, upper)? else { return Ok(own) };
    let through = |which, points: &[DVec3], degree| through_at(&shared, points, degree).map_err(wrong(which));
    Ok([through("lower", low, low_degree)?, through("upper", high, high_degree)?])
}

/// The parameters at which the curves of [`pair`] go through their points; none of a guide that is no row of points.
///
/// # Errors
/// Every error of [`pair`].
pub(super) fn row_parameters(lower: &GuideCurve, upper: &GuideCurve) -> Result<[Option<Vec<f64>>; 2], FlankError> {
    let own = |which, guide: &GuideCurve| match guide {
        GuideCurve::Points { points, .. } => {
            chord_parameters(points).map(Some).map_err(|reason| guide.wrong(which, reason))
        }
        _ => Ok(None),
    };
    let both = [own("lower", lower)?, own("upper", upper)?];
    let [Some(first), Some(second)] = &both else { return Ok(both) };
    if first.len() != second.len() {
        return Ok(both);
    }
    let shared: Vec<f64> = first.iter().zip(second).map(|(a, b)| 0.5 * (a + b)).collect();
    Ok([Some(shared.clone()), Some(shared)])
}

/// Warning on the joining of two guides: rows of points with different counts have no counterparts.
pub fn pairing_warning(lower: &GuideCurve, upper: &GuideCurve) -> Option<String> {
    let (GuideCurve::Points { points: low, .. }, GuideCurve::Points { points: high, .. }) = (lower, upper) else {
        return None;
    };
    (low.len() != high.len()).then(|| {
        format!(
            "the lower guide has {} points and the upper one {}: rulings join places at the same share of each row's \
             length, not point to point; give as many points of both for rulings between them",
            low.len(),
            high.len()
        )
    })
}

fn cubic() -> usize {
    3
}

impl GuideCurve {
    /// Most points of a row.
    pub const MOST_POINTS: usize = 20_000;

    /// The points of a text with x, y, z (mm) on each line, as a cubic through them. Empty lines, lines that start with
    /// `#` and one line of headings are passed over. Where semicolons or blanks separate numbers, these may have
    /// decimal commas.
    ///
    /// # Errors
    /// [`FlankError::Unreadable`] and [`FlankError::SamePoint`] with the line, [`FlankError::TooFewPoints`],
    /// [`FlankError::TooManyPoints`].
    pub fn from_csv(text: &str) -> Result<Self, FlankError> {
        let mut points: Vec<DVec3> = Vec::new();
        let (mut headings, mut before) = (0, 0);
        for (number, line) in text.lines().enumerate() {
            let line = line.trim().trim_start_matches('\u{feff}');
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            match point_of(line) {
                Some(_) if points.len() == Self::MOST_POINTS => {
                    return Err(FlankError::TooManyPoints { most: Self::MOST_POINTS });
                }
                Some(point) if points.last() == Some(&point) => {
                    return Err(FlankError::SamePoint { line: number + 1, before });
                }
                Some(point) => {
                    points.push(point);
                    before = number + 1;
                }
                // Words above the first point are headings.
                None if points.is_empty() && headings == 0 && !line.contains(|c: char| c.is_ascii_digit()) => {
                    headings += 1;
                }
                None => return Err(FlankError::Unreadable { line: number + 1, text: line.chars().take(80).collect() }),
            }
        }
        if points.len() < 2 {
            return Err(FlankError::TooFewPoints { found: points.len() });
        }
        Ok(Self::Points { points, degree: 3 })
    }

    /// Reason why it is no curve; of a row of points in words of points, which are counted from 1.
    fn wrong(&self, which: &'static str, reason: NurbsError) -> FlankError {
        let Self::Points { points, .. } = self else { return FlankError::Guide { which, reason } };
        let problem = match reason {
            NurbsError::Counts => format!("it needs two points at least, and there are {}", points.len()),
            NurbsError::Coincident(i) => {
                format!("point {} coincides with point {i}, or nearly so; leave one of them out", i + 1)
            }
            NurbsError::Value(i) => format!("point {} has a coordinate that is no number", i + 1),
            NurbsError::Singular => {
                "its points are too unevenly spaced; leave some out where they are close".to_owned()
            }
            reason => return FlankError::Guide { which, reason },
        };
        FlankError::Points { which, problem }
    }

    /// The curve, from u = 0 to 1.
    ///
    /// # Errors
    /// [`NurbsError`] that says what is wrong.
    pub fn curve(&self) -> Result<NurbsCurve, NurbsError> {
        match self {
            Self::Bezier { points } => {
                let degree = points.len().checked_sub(1).ok_or(NurbsError::Counts)?;
                let knots = KnotVector::new(degree, [vec![0.0; points.len()], vec![1.0; points.len()]].concat())?;
                NurbsCurve::new(knots, points, &vec![1.0; points.len()])
            }
            Self::BSpline { degree, knots, points, weights } => {
                let knots = from_zero_to_one(&KnotVector::new(*degree, knots.clone())?)?;
                let equal = vec![1.0; points.len()];
                NurbsCurve::new(knots, points, if weights.is_empty() { &equal } else { weights })
            }
            Self::Points { points, degree } => {
                if let Some(i) = points.iter().position(|p| !p.is_finite()) {
                    return Err(NurbsError::Value(i));
                }
                through_at(&chord_parameters(points)?, points, *degree)
            }
        }
    }
}

/// The curve through points at parameters from 0 to 1. One whose points end where they begin goes on from there as it
/// starts: it has the slope of the curve through the points around its seam.
fn through_at(parameters: &[f64], points: &[DVec3], degree: usize) -> Result<NurbsCurve, NurbsError> {
    /// Points on each side of the seam: what is further away changes the slope by no more than rounding.
    const BESIDE: i64 = 16;
    if degree < 2 || !is_ring(points) {
        return NurbsCurve::through_at(parameters, points, degree, None);
    }
    // Once around.
    let count = points.len() as i64 - 1;
    let at = |i: i64| {
        let k = i.rem_euclid(count) as usize;
        (parameters[k] + i.div_euclid(count) as f64, points[k])
    };
    let (around, beside): (Vec<f64>, Vec<DVec3>) = (-BESIDE..=BESIDE).map(at).unzip();
    let slope = NurbsCurve::through_at(&around, &beside, degree, None)?.at(0.0)[1];
    NurbsCurve::through_at(parameters, points, degree, Some([slope; 2]))
}

/// Whether points end where they begin without a corner there: the line through them does not turn much more than at
/// the points beside.
fn is_ring(points: &[DVec3]) -> bool {
    /// Allowance for the turn of the seam over that of the points beside it: a factor, and an angle (rad).
    const MORE: [f64; 2] = [1.5, 0.1];
    let [first, second, third, .., before, behind, last] = points else { return false };
    if !is_near(points, *first, *last) || points.len() < 7 {
        return false;
    }
    let turn = |a: &DVec3, b: &DVec3, c: &DVec3| (*b - *a).angle_between(*c - *b);
    let beside = turn(first, second, third).max(turn(before, behind, last));
    turn(behind, last, second) <= MORE[0] * beside + MORE[1]
}

/// Whether two of `points` coincide for their size.
pub(super) fn is_near(points: &[DVec3], a: DVec3, b: DVec3) -> bool {
    /// Share of the size within which points coincide, as for surfaces.
    const NEAR: f64 = 1e-6;
    let extent = points.iter().map(|p| p.distance(a)).fold(0.0, f64::max);
    a.distance(b) <= NEAR * extent
}

/// Knots stretched to run from 0 to 1.
fn from_zero_to_one(knots: &KnotVector) -> Result<KnotVector, NurbsError> {
    let [start, end] = knots.domain();
    let stretched = knots.knots().iter().map(|k| (k - start) / (end - start)).collect();
    KnotVector::new(knots.degree(), stretched)
}

/// Three finite numbers, and nothing else. Beside semicolons commas are those of decimals, and so they are beside
/// blanks that stand alone between numbers.
fn point_of(line: &str) -> Option<DVec3> {
    let is_gap = |c: char| c == ';' || c.is_whitespace();
    let three = |words: &mut dyn Iterator<Item = String>| {
        let numbers: Option<Vec<f64>> = words.filter(|w| !w.is_empty()).map(|w| w.parse::<f64>().ok()).collect();
        let [x, y, z] = numbers?.try_into().ok()?;
        Some(DVec3::new(x, y, z)).filter(|p| p.is_finite())
    };
    let with_commas = || three(&mut line.split(is_gap).map(|word| word.replacen(',', ".", 1)));
    if line.contains(';') {
        return with_commas();
    }
    // Where blanks alone separate some numbers, a comma within others is that of a decimal.
    let words: Vec<&str> = line.split_whitespace().collect();
    let is_open = |w: &[&str]| !w[0].ends_with(',') && !w[1].starts_with(',');
    let is_within = |word: &&str| word.trim_matches(',').contains(',');
    if words.windows(2).any(is_open) && words.iter().any(is_within) {
        return with_commas();
    }
    three(&mut line.split(|c: char| c == ',' || is_gap(c)).map(str::to_owned))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(text: &str) -> Vec<[f64; 3]> {
        let GuideCurve::Points { points, .. } = GuideCurve::from_csv(text).unwrap() else { panic!("{text}") };
        points.into_iter().map(|p| p.to_array()).collect()
    }

    #[test]
    fn decimal_commas_are_read_where_something_else_separates_numbers() {
        let all = [[1.5, 2.0, -3.25], [4.0, 5.0, 6.0]];
        for text in ["1.5,2,-3.25\n4,5,6", "1,5;2,0;-3,25\n4;5;6", "1,5 2 -3,25\n4,0\t5,0\t6,0", "1.5 2 -3.25\n4, 5, 6"]
        {
            assert_eq!(points(text), all, "{text}");
        }
        for text in ["1,5,2,0,-3,25\n4,5,6", "1,5;2\n4;5;6", "1,000,5;2;3\n4;5;6", "1,5 2\n4 5 6", "1 2,5\n4 5 6"] {
            let why = GuideCurve::from_csv(text).unwrap_err().to_string();
            assert!(why.contains("line 1") && why.contains("decimal commas"), "{text}: {why}");
        }
    }

    #[test]
    fn what_is_wrong_with_points_is_said_of_lines_and_points_counted_from_one() {
        let why = |text: &str| GuideCurve::from_csv(text).unwrap_err().to_string();
        assert!(why("x,y,z\n1,2,3\n").contains("two points at least, and there are 1"));
        assert!(why("").contains("there are 0"));
        let twice = why("x y z\n1 2 3\n\n# again\n1.0 2 3\n4 5 6");
        assert!(twice.contains("line 5") && twice.contains("line 2"), "{twice}");
        let row = |points: Vec<DVec3>| GuideCurve::Points { points, degree: 3 };
        let good = row(vec![DVec3::ZERO, DVec3::X]);
        for (bad, words) in [
            (row(vec![DVec3::X]), "two points"),
            (row(vec![DVec3::ZERO, DVec3::X, DVec3::X]), "point 3 coincides with point 2"),
            (row(vec![DVec3::ZERO, DVec3::NAN]), "point 2 has"),
        ] {
            let why = pair(&good, &bad).unwrap_err().to_string();
            assert!(why.starts_with("the upper guide curve") && why.contains(words), "{why}");
            assert!(!why.contains("NURBS"), "{why}");
        }
    }
}
