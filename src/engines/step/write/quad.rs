//! Four-sided B-spline surfaces over free forms, whose sides are given curves.

use geometry::exact::ExactMesh;
use glam::DVec3;
use task::{Cancelled, Task};

use super::band::Band;
use super::map::Map;
use super::spline::{Basis, Curve, DEGREE, Knots, SplineSurface};

/// Places in each span at which a surface is fitted and judged.
const SAMPLES: usize = 3;
/// Rounds of moving the places to fit to where the surface is nearest to the mesh.
const ROUNDS: usize = 2;
/// Cosine of the angle between the normals of surface and mesh below which the surface counts as folded.
const FACING: f64 = -0.2;
/// Tolerances for which a place on a fold counts.
const FOLD: f64 = 1.0;
/// Most control points along one direction, unless the sides have more.
const MOST: usize = 120;

/// The sides of a quad, along v = 0 and v = 1 with rising u, and along u = 0 and u = 1 with rising v.
#[derive(Debug, Clone)]
pub(super) struct Sides {
    /// At v = 0 and v = 1.
    pub(super) along_u: [Curve; 2],
    /// At u = 0 and u = 1.
    pub(super) along_v: [Curve; 2],
}

/// A fitted surface.
#[derive(Debug, Clone)]
pub(super) struct Quad {
    /// The surface.
    pub(super) surface: SplineSurface,
    /// Greatest distance of the surface from the mesh (mm).
    pub(super) distance: f64,
    /// Place of that distance (mm).
    pub(super) at: DVec3,
    /// Spans along u and v with places out of tolerance.
    failing: [Vec<bool>; 2],
    /// How much is out of tolerance altogether, folds included.
    pub(super) excess: f64,
}

/// The places along one direction at which a surface is fitted.
struct Grid {
    places: Vec<f64>,
    bases: Vec<Basis>,
    /// The span of each place.
    spans: Vec<usize>,
}

impl Grid {
    /// Places in the middles of the parts of every span, or between them.
    fn of(knots: &Knots, offset: f64) -> Self {
        let (mut places, mut spans) = (Vec::new(), Vec::new());
        for (span, w) in knots.breaks().windows(2).enumerate() {
            for k in 0..SAMPLES {
                let place = w[0] + (w[1] - w[0]) * (k as f64 + offset) / SAMPLES as f64;
                if place > 0.0 {
                    places.push(place);
                    spans.push(span);
                }
            }
        }
        let bases = places.iter().map(|&u| knots.basis(u)).collect();
        Self { places, bases, spans }
    }
}

/// Something to fit to.
pub(super) struct Target<'a> {
    /// The mesh laid out in the unit square.
    pub(super) map: &'a Map,
    /// The same mesh for distances.
    pub(super) exact: &'a ExactMesh,
    /// Unit normals of its triangles; zero without area.
    pub(super) normals: &'a [DVec3],
    /// The tolerance (mm).
    pub(super) tolerance: f64,
}

/// The surface between the sides with as few spans as are needed, or the best there is; none where it cannot be solved
/// for.
pub(super) fn fit(target: &Target, sides: &Sides, task: &Task) -> Result<Option<Quad>, Cancelled> {
    let knots = [&sides.along_u, &sides.along_v].map(|pair| pair[0].knots.united(&pair[1].knots));
    let limit = [0, 1].map(|k| knots[k].count().max(MOST));
    let Some(mut best) = trial(target, sides, knots) else { return Ok(None) };
    while best.excess > 0.0 {
        task.check()?;
        let Some(next) = refined(target, sides, &best, limit) else { break };
        best = next;
    }
    Ok(Some(best))
}

/// A surface with more knots: those along the direction that helps more, or along both where neither helps much.
fn refined(target: &Target, sides: &Sides, now: &Quad, limit: [usize; 2]) -> Option<Quad> {
    let knots = &now.surface.knots;
    let halves: [Knots; 2] = std::array::from_fn(|k| knots[k].halved(|span| now.failing[k][span]));
    let candidate = |pair: [Knots; 2]| {
        let is_small = (0..2).all(|k| pair[k].count() <= limit[k]);
        if is_small { trial(target, sides, pair) } else { None }
    };
    let along_u = candidate([halves[0].clone(), knots[1].clone()]);
    let along_v = candidate([knots[0].clone(), halves[1].clone()]);
    let better = match (along_u, along_v) {
        (Some(a), Some(b)) => Some(if a.excess <= b.excess { a } else { b }),
        (a, b) => a.or(b),
    };
    match better {
        Some(found) if found.excess < 0.4 * now.excess => Some(found),
        other => {
            candidate(halves).filter(|f| f.excess < 0.9 * now.excess).or(other.filter(|f| f.excess < 0.9 * now.excess))
        }
    }
}

/// The surface with these knots.
fn trial(target: &Target, sides: &Sides, knots: [Knots; 2]) -> Option<Quad> {
    let grids = [0, 1].map(|k| Grid::of(&knots[k], 0.5));
    let mut wanted = target.map.sampled(&grids[0].places, &grids[1].places);
    let frame = framed(sides, &knots);
    let factors = [normal(&knots[0], &grids[0])?, normal(&knots[1], &grids[1])?];
    let mut quad = None;
    for round in 0..ROUNDS {
        let surface = solve(&frame, &grids, &factors, &wanted);
        if !surface.controls.iter().all(|p| p.is_finite()) {
            return None;
        }
        let judged = judged(target, surface, &grids, &mut wanted);
        let is_enough = judged.excess == 0.0;
        if quad.as_ref().is_none_or(|q: &Quad| judged.excess < q.excess || round == 0) {
            quad = Some(judged);
        }
        if is_enough {
            break;
        }
    }
    // What holds at these places has to hold between them too.
    let found = quad?;
    if found.excess > 0.0 {
        return Some(found);
    }
    let between = [0, 1].map(|k| Grid::of(&knots[k], 0.0));
    let mut places = vec![DVec3::ZERO; between[0].places.len() * between[1].places.len()];
    let again = judged(target, found.surface.clone(), &between, &mut places);
    Some(if again.distance > found.distance || again.excess > 0.0 { again } else { found })
}

/// The surface whose outer control points are those of the sides; the others continue them (Coons).
fn framed(sides: &Sides, knots: &[Knots; 2]) -> SplineSurface {
    let [low, high] = [0, 1].map(|k| sides.along_u[k].with_knots(&knots[0]).controls);
    let [left, right] = [0, 1].map(|k| sides.along_v[k].with_knots(&knots[1]).controls);
    let (n, m) = (low.len(), left.len());
    let mut controls = Vec::with_capacity(n * m);
    for i in 0..n {
        let u = knots[0].site(i);
        for j in 0..m {
            let v = knots[1].site(j);
            let corners = low[0].lerp(low[n - 1], u).lerp(high[0].lerp(high[n - 1], u), v);
            controls.push(match (i, j) {
                (_, 0) => low[i],
                (_, j) if j == m - 1 => high[i],
                (0, _) => left[j],
                (i, _) if i == n - 1 => right[j],
                _ => low[i].lerp(high[i], v) + left[j].lerp(right[j], u) - corners,
            });
        }
    }
    SplineSurface { knots: knots.clone(), controls }
}

/// The normal equations of the inner basis functions along one direction.
fn normal(knots: &Knots, grid: &Grid) -> Option<super::band::Factor> {
    let inner = knots.count() - 2;
    let mut matrix = Band::new(inner, DEGREE);
    for basis in &grid.bases {
        matrix.add_square(&inner_form(basis, inner), 1.0);
    }
    matrix.add_to_diagonal(1e-9);
    matrix.factored()
}

/// A basis without the first and the last function: numbers and values.
fn inner_form(basis: &Basis, inner: usize) -> Vec<(usize, f64)> {
    let all = (0..=DEGREE).map(|r| (basis.first + r, basis.values[r]));
    all.filter(|(i, _)| *i > 0 && *i <= inner).map(|(i, a)| (i - 1, a)).collect()
}

/// The surface nearest to the wanted points by least squares, its outer control points held.
fn solve(
    frame: &SplineSurface,
    grids: &[Grid; 2],
    factors: &[super::band::Factor; 2],
    wanted: &[DVec3],
) -> SplineSurface {
    let [n, m] = [0, 1].map(|k| frame.knots[k].count() - 2);
    let [us, vs] = [0, 1].map(|k| &grids[k].bases);
    // Sums along u for every place along v: column after column of the inner functions.
    let mut columns = vec![vec![DVec3::ZERO; n]; vs.len()];
    for (i, u) in us.iter().enumerate() {
        let form = inner_form(u, n);
        for (j, v) in vs.iter().enumerate() {
            let off = wanted[i * vs.len() + j] - frame.point(u, v);
            form.iter().for_each(|&(r, a)| columns[j][r] += off * a);
        }
    }
    columns.iter_mut().for_each(|c| factors[0].solve(c));
    let mut surface = frame.clone();
    for i in 0..n {
        let mut row = vec![DVec3::ZERO; m];
        for (column, v) in columns.iter().zip(vs) {
            inner_form(v, m).iter().for_each(|&(s, a)| row[s] += column[i] * a);
        }
        factors[1].solve(&mut row);
        let first = (i + 1) * (m + 2) + 1;
        surface.controls[first..first + m].iter_mut().zip(row).for_each(|(c, d)| *c += d);
    }
    surface
}

/// The surface with its distances from the mesh; `wanted` becomes the points of the mesh nearest to it.
fn judged(target: &Target, surface: SplineSurface, grids: &[Grid; 2], wanted: &mut [DVec3]) -> Quad {
    let failing = [0, 1].map(|k| vec![false; grids[k].spans.last().map_or(0, |s| s + 1)]);
    let mut quad = Quad { surface, distance: 0.0, at: DVec3::ZERO, failing, excess: 0.0 };
    for (i, u) in grids[0].bases.iter().enumerate() {
        for (j, v) in grids[1].bases.iter().enumerate() {
            let p = quad.surface.point(u, v);
            let nearest = target.exact.nearest(p);
            let distance = nearest.point.distance(p);
            let facing = quad.surface.normal(u, v).dot(target.normals[nearest.triangle as usize]);
            wanted[i * grids[1].bases.len() + j] = nearest.point;
            if distance > quad.distance {
                (quad.distance, quad.at) = (distance, p);
            }
            let mut excess = (distance / target.tolerance - 1.0).max(0.0);
            if facing < FACING {
                excess += FOLD;
            }
            if excess > 0.0 {
                quad.excess += excess * excess;
                quad.failing[0][grids[0].spans[i]] = true;
                quad.failing[1][grids[1].spans[j]] = true;
            }
        }
    }
    quad
}
