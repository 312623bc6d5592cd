//! Curves and surfaces through given points, and how far they are off.

use glam::{DVec3, DVec4};
use serde::Serialize;

use super::NurbsError;
use super::banded::Banded;
use super::curve::NurbsCurve;
use super::knots::{KnotVector, MAX_DEGREE};
use super::surface::NurbsSurface;

/// Distances of a fit from its data.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct FitError {
    /// Greatest distance (mm).
    pub greatest_mm: f64,
    /// Root mean square of the distances (mm).
    pub rms_mm: f64,
    /// Places compared.
    pub points: usize,
}

impl FitError {
    /// The figures of some distances (mm).
    pub fn of(distances: impl IntoIterator<Item = f64>) -> Self {
        let (mut greatest_mm, mut squares, mut points) = (0.0f64, 0.0, 0);
        for distance in distances {
            greatest_mm = greatest_mm.max(distance.abs());
            squares += distance * distance;
            points += 1;
        }
        Self { greatest_mm, rms_mm: (squares / points.max(1) as f64).sqrt(), points }
    }
}

/// Parameters from 0 to 1 that grow with the distance from point to point, P1 (13) and (14).
///
/// # Errors
/// If there are fewer than 2 points or two neighbouring ones coincide.
pub fn chord_parameters(points: &[DVec3]) -> Result<Vec<f64>, NurbsError> {
    if points.len() < 2 {
        return Err(NurbsError::Counts);
    }
    let mut sums = vec![0.0];
    for (i, pair) in points.windows(2).enumerate() {
        let chord = pair[0].distance(pair[1]);
        if chord.is_nan() || chord <= 0.0 {
            return Err(NurbsError::Coincident(i + 1));
        }
        sums.push(sums[i] + chord);
    }
    let length = sums[sums.len() - 1];
    let mut parameters: Vec<f64> = sums.iter().map(|s| s / length).collect();
    parameters[points.len() - 1] = 1.0;
    Ok(parameters)
}

/// The system that control points of an interpolation solve.
pub(super) struct Interpolation {
    pub knots: KnotVector,
    pub matrix: Banded,
    /// Whether the second row and the last but one are derivatives at the ends.
    tangents: bool,
}

impl Interpolation {
    /// The system for points at `parameters`, of `degree` or of as much as the points allow.
    pub fn new(parameters: &[f64], degree: usize, tangents: bool) -> Result<Self, NurbsError> {
        let n = parameters.len();
        if !(1..=MAX_DEGREE).contains(&degree) {
            return Err(NurbsError::Degree(degree));
        }
        if n < 2 {
            return Err(NurbsError::Counts);
        }
        let rises = |i: &usize| parameters[*i].is_finite() && parameters[*i] > parameters[*i - 1];
        if let Some(i) = (1..n).find(|i| !rises(i)) {
            return Err(NurbsError::Coincident(i));
        }
        // Two tangents count as two points; without room between the ends they say nothing.
        let tangents = tangents && degree >= 2;
        let degree = degree.min(if tangents { n + 1 } else { n - 1 });
        let knots = KnotVector::averaged(degree, parameters, tangents)?;
        let size = knots.count();
        let mut matrix = Banded::new(size, degree);
        let mut row = 0;
        let mut add = |u: f64, order: usize| {
            let basis = knots.basis(u);
            let result = (0..=degree).try_for_each(|k| matrix.set(row, basis.first + k, basis.orders[order][k]));
            row += 1;
            result
        };
        for (i, &u) in parameters.iter().enumerate() {
            if tangents && i == n - 1 {
                add(u, 1)?;
            }
            add(u, 0)?;
            if tangents && i == 0 {
                add(u, 1)?;
            }
        }
        Ok(Self { knots, matrix, tangents })
    }

    /// The control points of many curves at once, in homogeneous coordinates: `points[i]` holds the points of all curves at
    /// parameter `i`.
    fn control_points(
        &self,
        points: &[Vec<DVec4>],
        ends: Option<[Vec<DVec4>; 2]>,
    ) -> Result<Vec<Vec<DVec4>>, NurbsError> {
        let mut rows: Vec<Vec<DVec4>> = points.to_vec();
        if let (true, Some([first, last])) = (self.tangents, ends) {
            rows.insert(1, first);
            rows.insert(rows.len() - 1, last);
        }
        let flat = rows.iter().map(|row| row.iter().flat_map(|p| p.to_array()).collect()).collect();
        let solved = self.matrix.clone().solve(flat)?;
        Ok(solved.iter().map(|row| row.chunks_exact(4).map(DVec4::from_slice).collect()).collect())
    }
}

/// The derivative by the parameter at the first of `points`, of the parabola through the first three.
fn end_tangent(u: [f64; 3], [p, q, r]: [DVec4; 3]) -> DVec4 {
    let (first, second) = ((q - p) / (u[1] - u[0]), (r - q) / (u[2] - u[1]));
    first + (first - second) * ((u[1] - u[0]) / (u[2] - u[0]))
}

/// The derivatives at both ends, of parabolas through three points; of the chord where there are but two.
fn end_tangents(u: &[f64], points: &[DVec4]) -> [DVec4; 2] {
    let n = points.len();
    if n < 3 {
        return [(points[n - 1] - points[0]) / (u[n - 1] - u[0]); 2];
    }
    let last = end_tangent([u[n - 1], u[n - 2], u[n - 3]], [points[n - 1], points[n - 2], points[n - 3]]);
    [end_tangent([u[0], u[1], u[2]], [points[0], points[1], points[2]]), last]
}

/// Weights and end directions of a cubic through points (P1, equations 6 to 18).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LineShape {
    /// Weights of the points, greater than 0; all are 1 if there are none.
    pub weights: Vec<f64>,
    /// Directions at the first and the last point, onwards along the line; where none is given, that of the parabola through
    /// the three points there.
    pub ends: [Option<DVec3>; 2],
}

impl LineShape {
    /// Whether the weights are those of a line of so many points, or left out.
    fn suits(&self, points: usize) -> bool {
        [0, points].contains(&self.weights.len())
    }

    /// The derivative at an end, in homogeneous coordinates: that of the parabola, `found`, turned to the direction that is
    /// given.
    fn end(&self, end: usize, point: DVec4, found: DVec4) -> DVec4 {
        let Some(direction) = self.ends[end].and_then(DVec3::try_normalize) else { return found };
        let (place, weight) = (point.truncate() / point.w, point.w);
        let speed = ((found.truncate() - place * found.w) / weight).length();
        (place * found.w + direction * speed * weight).extend(found.w)
    }
}

impl NurbsCurve {
    /// The curve of `degree`, or of as much as the points allow, through `points`: parameters by chord length,
    /// averaged knots.
    ///
    /// # Errors
    /// [`NurbsError`] if neighbouring points coincide or there are fewer than two.
    pub fn through(points: &[DVec3], degree: usize) -> Result<Self, NurbsError> {
        Self::through_at(&chord_parameters(points)?, points, degree, None)
    }

    /// The cubic through `points` with the derivatives by the chord-length parameter (0 to 1) at its ends as given, or
    /// those of parabolas through the three points there (P1, equations 15 to 18).
    ///
    /// # Errors
    /// Every error of [`through`](Self::through).
    pub fn cubic(points: &[DVec3], ends: Option<[DVec3; 2]>) -> Result<Self, NurbsError> {
        let parameters = chord_parameters(points)?;
        let parabolas = || end_tangents(&parameters, &homogeneous(points, &[])).map(DVec4::truncate);
        let ends = ends.unwrap_or_else(parabolas);
        Self::through_at(&parameters, points, 3, Some(ends))
    }

    /// The rational cubic through `points` of the given shape, with parameters by chord length (P1, equations 6 to 18).
    ///
    /// # Errors
    /// Every error of [`through`](Self::through), and [`NurbsError::Value`] where weights differ so much from point to
    /// point that one between would not be positive.
    pub fn rational(points: &[DVec3], shape: &LineShape) -> Result<Self, NurbsError> {
        Self::rational_at(&chord_parameters(points)?, points, shape)
    }

    /// The rational cubic of the given shape with `points[i]` at `parameters[i]`.
    ///
    /// # Errors
    /// Every error of [`rational`](Self::rational).
    pub fn rational_at(parameters: &[f64], points: &[DVec3], shape: &LineShape) -> Result<Self, NurbsError> {
        if parameters.len() != points.len() || !shape.suits(points.len()) {
            return Err(NurbsError::Counts);
        }
        let rows = homogeneous(points, &shape.weights).into_iter().map(|p| vec![p]).collect::<Vec<_>>();
        let (knots, control) = cubics(parameters, &rows, std::slice::from_ref(shape))?;
        let (points, weights) = parted(&control.concat(), shape.weights.is_empty());
        Self::new(knots, &points, &weights)
    }

    /// The curve of `degree` with `points[i]` at `parameters[i]`, and the derivatives at its ends if they are given.
    ///
    /// # Errors
    /// [`NurbsError`] if the parameters do not rise or are too few.
    pub fn through_at(
        parameters: &[f64],
        points: &[DVec3],
        degree: usize,
        ends: Option<[DVec3; 2]>,
    ) -> Result<Self, NurbsError> {
        if parameters.len() != points.len() {
            return Err(NurbsError::Counts);
        }
        let interpolation = Interpolation::new(parameters, degree, ends.is_some())?;
        let rows: Vec<Vec<DVec4>> = homogeneous(points, &[]).into_iter().map(|p| vec![p]).collect();
        let control = interpolation.control_points(&rows, ends.map(|e| e.map(|t| vec![t.extend(0.0)])))?.concat();
        let (control, weights) = parted(&control, true);
        Self::new(interpolation.knots, &control, &weights)
    }
}

impl NurbsSurface {
    /// The bicubic surface skinned over `sections`, each with the same number of points: cubics along the sections with
    /// shared parameters, then cubics from section to section through their control points. Parameters are means of
    /// the chord lengths over all sections and over all points; end tangents are those of parabolas. Returns the
    /// surface and the parameters of the points in u, along the sections, and in v, across them.
    ///
    /// # Errors
    /// [`NurbsError`] if there are fewer than two sections or points, or neighbouring ones coincide.
    pub fn skinned(sections: &[Vec<DVec3>]) -> Result<(Self, [Vec<f64>; 2]), NurbsError> {
        Self::skinned_as(sections, &vec![LineShape::default(); sections.len()])
    }

    /// The bicubic surface skinned over `sections`, each of the shape in `shapes`, as [`skinned`](Self::skinned) does it
    /// without weights and given ends.
    ///
    /// # Errors
    /// Every error of [`skinned`](Self::skinned), and [`NurbsError::Value`] where weights differ so much from point to point that one between would not be
    /// positive.
    pub fn skinned_as(sections: &[Vec<DVec3>], shapes: &[LineShape]) -> Result<(Self, [Vec<f64>; 2]), NurbsError> {
        let n = sections.first().map_or(0, Vec::len);
        let suit = shapes.len() == sections.len() && shapes.iter().all(|shape| shape.suits(n));
        if sections.len() < 2 || n < 2 || sections.iter().any(|s| s.len() != n) || !suit {
            return Err(NurbsError::Counts);
        }
        let along: Vec<Vec<DVec3>> = (0..n).map(|i| sections.iter().map(|s| s[i]).collect()).collect();
        let (u, v) = (mean_parameters(sections)?, mean_parameters(&along)?);
        let weighted: Vec<Vec<DVec4>> =
            sections.iter().zip(shapes).map(|(section, shape)| homogeneous(section, &shape.weights)).collect();
        let along: Vec<Vec<DVec4>> = (0..n).map(|i| weighted.iter().map(|s| s[i]).collect()).collect();
        let (in_u, control) = cubics(&u, &along, shapes)?;
        let across: Vec<Vec<DVec4>> = (0..v.len()).map(|j| control.iter().map(|row| row[j]).collect()).collect();
        let (in_v, control) = cubics(&v, &across, &vec![LineShape::default(); in_u.count()])?;
        let points: Vec<DVec4> = (0..in_u.count()).flat_map(|i| control.iter().map(move |row| row[i])).collect();
        let (points, weights) = parted(&points, shapes.iter().all(|shape| shape.weights.is_empty()));
        Ok((Self::new(in_u, in_v, &points, &weights)?, [u, v]))
    }
}

/// Chord-length parameters, the mean over all of `lines`.
fn mean_parameters(lines: &[Vec<DVec3>]) -> Result<Vec<f64>, NurbsError> {
    let mut sums = vec![0.0; lines[0].len()];
    for line in lines {
        sums.iter_mut().zip(chord_parameters(line)?).for_each(|(sum, u)| *sum += u);
    }
    Ok(sums.iter().map(|sum| sum / lines.len() as f64).collect())
}

/// Cubics through many lines of points at once, in homogeneous coordinates: `rows[i]` holds the points of all of them at
/// parameter `i`, `shapes` what is given of each line.
fn cubics(
    parameters: &[f64],
    rows: &[Vec<DVec4>],
    shapes: &[LineShape],
) -> Result<(KnotVector, Vec<Vec<DVec4>>), NurbsError> {
    let interpolation = Interpolation::new(parameters, 3, true)?;
    let ends = |(j, shape): (usize, &LineShape)| {
        let line: Vec<DVec4> = rows.iter().map(|row| row[j]).collect();
        let found = end_tangents(parameters, &line);
        [0, 1].map(|end| shape.end(end, [line[0], line[line.len() - 1]][end], found[end]))
    };
    let ends: Vec<[DVec4; 2]> = shapes.iter().enumerate().map(ends).collect();
    let ends = [0, 1].map(|end| ends.iter().map(|e| e[end]).collect());
    let control = interpolation.control_points(rows, Some(ends))?;
    Ok((interpolation.knots, control))
}

/// Points times their weights, and the weights; without weights these are 1.
fn homogeneous(points: &[DVec3], weights: &[f64]) -> Vec<DVec4> {
    let weight = |i: usize| weights.get(i).copied().unwrap_or(1.0);
    points.iter().enumerate().map(|(i, p)| (*p * weight(i)).extend(weight(i))).collect()
}

/// Points and weights of homogeneous ones; the weights are 1 but for rounding if they `are_one`.
fn parted(points: &[DVec4], are_one: bool) -> (Vec<DVec3>, Vec<f64>) {
    let weight = |p: &DVec4| if are_one { 1.0 } else { p.w };
    points.iter().map(|p| (p.truncate() / weight(p), weight(p))).unzip()
}
