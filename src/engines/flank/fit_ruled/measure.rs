//! Distances between a face and a ruled surface, both ways.

use glam::DVec3;
use rayon::prelude::*;

use super::params::RuledFitError;
use super::patch::Patch;
use super::sides::Sides;
use super::strip::{Foot, Strip};
use geometry::exact::ExactMesh;
use geometry::nurbs::FitError;
use task::{Cancel, Cancelled};

/// Corners of the mesh compared at most.
const CORNERS: usize = 12_000;
/// Places of the surface that are compared, along and across.
const BACK: [usize; 2] = [120, 24];

/// Measured distances.
#[derive(Debug, Clone)]
pub(super) struct Measured {
    /// Distances of the mesh's corners.
    pub corners: FitError,
    /// Distances of corners and places inside of triangles.
    pub all: FitError,
    /// Distances from the surface to the triangles, where the surface lies over them.
    pub back: FitError,
    /// Place of the greatest distance of the face (mm).
    pub worst: DVec3,
    /// Greatest distance by which the surface extends beyond the face, as far as sampled (mm).
    pub overhang: f64,
    /// Greatest distance by which the face extends beyond the surface (mm), and its place.
    pub uncovered: f64,
    pub uncovered_at: DVec3,
    /// Greatest distance of omitted pieces from the surface or beyond it (mm).
    pub lost: f64,
    /// Greatest distance of the guides from the face's border (mm).
    pub border: f64,
}

/// Distances of points from the surface, or from its tangent plane where they lie beyond its ends, and how far beyond.
fn distances(strip: &Strip, points: &[DVec3]) -> Vec<[f64; 2]> {
    let rulings = strip.rulings();
    let measure = |p: &DVec3| {
        let foot = strip.foot(&rulings, *p);
        let u = if strip.knots.is_closed { foot.u } else { foot.u.clamp(0.0, 1.0) };
        let kept = Foot { u, v: foot.v.clamp(0.0, 1.0) };
        let place = strip.at(kept);
        let off = *p - place.point;
        let is_within = foot.u == kept.u && foot.v == kept.v;
        let upright = off.dot(place.first[0].cross(place.first[1]).normalize_or_zero()).abs();
        if is_within {
            [off.length(), 0.0]
        } else {
            [upright, (off.length_squared() - upright * upright).max(0.0).sqrt()]
        }
    };
    points.par_iter().map(measure).collect()
}

/// The same, stopped by `cancel`.
fn all_distances(strip: &Strip, points: &[DVec3], cancel: &Cancel) -> Result<Vec<[f64; 2]>, Cancelled> {
    /// Points between two looks at the flag: a few milliseconds of work.
    const CHUNK: usize = 1024;
    let mut found = Vec::with_capacity(points.len());
    for chunk in points.chunks(CHUNK) {
        cancel.check()?;
        found.extend(distances(strip, chunk));
    }
    Ok(found)
}

/// How bad a surface is (mm), by at most `count` corners of the mesh and half as many places inside of triangles: the
/// greatest distance, of the latter less the chord error, with a little for what lies beyond its ends.
pub(super) fn quick(patch: &Patch, strip: &Strip, count: usize) -> f64 {
    let corners: Vec<DVec3> = patch.corner_samples(count).into_iter().map(|c| c.0).collect();
    let worst = |points: &[DVec3], less: f64| {
        let bad = |[off, beyond]: [f64; 2]| (off - less).max(0.0).hypot(0.02 * beyond);
        distances(strip, points).into_iter().map(bad).fold(0.0, f64::max)
    };
    worst(&corners, 0.0).max(worst(&patch.inner_samples(count / 2), patch.chord))
}

/// Distances for each piece of the guides.
pub(super) fn by_piece(patch: &Patch, strip: &Strip, count: usize) -> Vec<f64> {
    let corners: Vec<DVec3> = patch.corner_samples(count).into_iter().map(|c| c.0).collect();
    let mut errors = vec![0.0f64; strip.knots.pieces()];
    let rulings = strip.rulings();
    let mut add = |points: &[DVec3], less: f64| {
        let pieces: Vec<usize> = points.par_iter().map(|p| strip.knots.piece(strip.foot(&rulings, *p).u)).collect();
        for (piece, [off, _]) in pieces.into_iter().zip(distances(strip, points)) {
            errors[piece] = errors[piece].max(off - less);
        }
    };
    add(&corners, 0.0);
    add(&patch.inner_samples(count / 2), patch.chord);
    errors
}

pub(super) fn measured(
    patch: &Patch,
    sides: &Sides,
    strip: &Strip,
    cancel: &Cancel,
) -> Result<Measured, RuledFitError> {
    let corners: Vec<DVec3> = patch.corner_samples(CORNERS).into_iter().map(|c| c.0).collect();
    let inner = patch.inner_samples(usize::MAX);
    let of_corners = all_distances(strip, &corners, cancel)?;
    let of_inner = all_distances(strip, &inner, cancel)?;
    let both = || corners.iter().zip(&of_corners).chain(inner.iter().zip(&of_inner));
    let worst = both().fold((DVec3::ZERO, -1.0), |w, (p, [d, _])| if *d > w.1 { (*p, *d) } else { w });
    let farthest = both().fold((DVec3::ZERO, -1.0), |w, (p, [_, d])| if *d > w.1 { (*p, *d) } else { w });
    let lost = all_distances(strip, &patch.left_out, cancel)?.into_iter().map(|[off, beyond]| off.hypot(beyond));
    cancel.check()?;
    let (back, overhang) = back(patch, strip)?;
    Ok(Measured {
        corners: FitError::of(of_corners.iter().map(|d| d[0])),
        all: FitError::of(both().map(|b| b.1[0])),
        back,
        worst: worst.0 + patch.origin,
        overhang,
        uncovered: farthest.1.max(0.0),
        uncovered_at: farthest.0 + patch.origin,
        lost: lost.fold(0.0, f64::max),
        border: border(sides, strip),
    })
}

/// From places of the surface to the nearest triangles: distances where the surface lies over them, and how far it
/// reaches beyond.
fn back(patch: &Patch, strip: &Strip) -> Result<(FitError, f64), RuledFitError> {
    let exact = ExactMesh::new(&patch.mesh()).map_err(|e| RuledFitError::NoDistances(e.to_string()))?;
    let places: Vec<Foot> = (0..BACK[0] * BACK[1])
        .map(|i| [(i / BACK[1], BACK[0]), (i % BACK[1], BACK[1])].map(|(k, n)| (k as f64 + 0.5) / n as f64))
        .map(|[u, v]| Foot { u, v })
        .collect();
    let mut border: Vec<[u32; 2]> = patch.loops.iter().flat_map(|l| sides_of(l)).collect();
    border.sort_unstable();
    let measure = |foot: &Foot| {
        let p = strip.at(*foot).point;
        let nearest = exact.nearest(p);
        (p.distance(nearest.point), is_on_border(patch, &border, nearest.triangle as usize, nearest.point))
    };
    let found: Vec<(f64, bool)> = places.par_iter().map(measure).collect();
    let is_over = found.iter().any(|f| !f.1);
    // A surface that lies nowhere over the face is as far off as it is from its border.
    let error = FitError::of(found.iter().filter(|f| !f.1 || !is_over).map(|f| f.0));
    Ok((error, found.iter().filter(|f| f.1).map(|f| f.0).fold(0.0, f64::max)))
}

/// The sides of a closed border, each with its lower point first.
fn sides_of(around: &[u32]) -> impl Iterator<Item = [u32; 2]> + '_ {
    (0..around.len()).map(|i| [around[i], around[(i + 1) % around.len()]]).map(|[a, b]| [a.min(b), a.max(b)])
}

/// Whether a point of triangle `t` lies on the border of the face, given by its sorted sides.
fn is_on_border(patch: &Patch, border: &[[u32; 2]], t: usize, p: DVec3) -> bool {
    let near = 1e-9 * patch.size;
    let corners = patch.triangles[t];
    (0..3).any(|k| {
        let (a, b) = (corners[k], corners[(k + 1) % 3]);
        let [from, to] = [a, b].map(|v| patch.points[v as usize]);
        let along = to - from;
        let share = ((p - from).dot(along) / along.length_squared().max(1e-300)).clamp(0.0, 1.0);
        let is_at_corner = p.distance(from) <= near && patch.is_border[a as usize];
        is_at_corner
            || (p.distance(from + along * share) <= near && border.binary_search(&[a.min(b), a.max(b)]).is_ok())
    })
}

/// The greatest distance of the border's points from their guides.
pub(super) fn border(sides: &Sides, strip: &Strip) -> f64 {
    let rulings = strip.rulings();
    let off = |s: usize, p: DVec3| {
        let u = strip.foot_on_guide(s, strip.foot(&rulings, p).u, p);
        strip.guide(s, u)[0].distance(p)
    };
    let of_side = |s: usize| sides.guides[s].iter().map(move |side| off(s, side.0)).fold(0.0, f64::max);
    of_side(0).max(of_side(1))
}
