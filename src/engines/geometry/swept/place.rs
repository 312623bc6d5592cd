//! Moves the vertices of a net onto the surface, and onto its edges and corners.

use glam::DVec3;
use nalgebra::{Matrix3, SymmetricEigen, Vector3};
use rayon::prelude::*;

use super::SweptSurface;
use super::lattice::{Blocks, Lattice};
use super::motion::{Motion, Near, Touch};
use super::net::{Net, Start};
use crate::distance_field::DistanceField;
use crate::mesh::Mesh;
use task::{Cancel, Cancelled};

/// From how far above the surface its vertices are led there at least (cells).
const HEIGHT: f64 = 0.4;
/// Share of the greatest spread of normals from which on another direction counts: faces that meet at more than
/// about 35 degrees make an edge.
const SPREAD: f64 = 0.1;

/// A vertex on the surface.
#[derive(Clone, Copy)]
struct Placed {
    at: DVec3,
    normal: DVec3,
}

/// The mesh of `net` with every vertex in its place.
pub(super) fn placed(
    net: Net,
    lattice: &Lattice,
    blocks: &Blocks,
    motion: &Motion,
    cancel: &Cancel,
) -> Result<Mesh, Cancelled> {
    let Net { starts, counts, quads } = net;
    let setter = Setter { motion, height: (HEIGHT * lattice.cell).min(0.8 * DistanceField::NEAR) };
    let smooth = by_block(&starts, &counts, blocks, cancel, |&start, near| setter.smooth(start, near))?;
    let fits = |v: usize, at: DVec3| lattice.keeps(starts[v].middle, at);
    let features = features(&smooth, &quads, fits);
    let sharp = by_block(&features, &counts, blocks, cancel, |feature, near| {
        feature.as_ref().and_then(|f| setter.sharp(f, near))
    })?;
    let kept = |v: usize| sharp[v].filter(|at| fits(v, *at));
    let vertices: Vec<DVec3> = (0..smooth.len()).map(|v| kept(v).unwrap_or(smooth[v].at)).collect();
    let sharp = |v: u32| kept(v as usize).is_some();
    let triangles = quads.iter().flat_map(|quad| split(quad, &vertices, sharp)).collect();
    Ok(Mesh { vertices, triangles })
}

/// `work` on every item, of which the mixed blocks have `counts` each, with the placements near its block.
fn by_block<T: Sync, R: Send>(
    items: &[T],
    counts: &[usize],
    blocks: &Blocks,
    cancel: &Cancel,
    work: impl Fn(&T, &Near) -> R + Sync,
) -> Result<Vec<R>, Cancelled> {
    let mut rest = items;
    let own: Vec<&[T]> = counts
        .iter()
        .map(|&n| {
            let (own, others) = rest.split_at(n);
            rest = others;
            own
        })
        .collect();
    let parts: Vec<Vec<R>> = own
        .par_iter()
        .zip(&blocks.mixed)
        .map(|(own, (_, near))| cancel.check().map(|()| own.iter().map(|item| work(item, near)).collect()))
        .collect::<Result<_, _>>()?;
    Ok(parts.into_iter().flatten().collect())
}

/// Sets vertices onto the surface. They are led there from outside: there the least distance is that to the surface
/// itself, also where an edge of the body traces it. Inside it is that to the body in its deepest placement, and on the
/// surface its gradient may be that of a face which the surface does not follow.
struct Setter<'a> {
    motion: &'a Motion,
    /// From how far above the surface vertices are led at least (mm).
    height: f64,
}

impl Setter<'_> {
    /// The place on the surface that belongs to `start`.
    fn smooth(&self, start: Start, near: &Near) -> Placed {
        let high = |touch: &Touch| touch.distance > 0.5 * self.height;
        let mut above = start.middle;
        let mut touch = self.motion.nearest(near, above);
        let begins_well = high(&touch) && touch.distance <= DistanceField::NEAR;
        for share in [0.5, 1.0] {
            if !high(&touch) {
                above = start.middle.lerp(start.outside, share);
                touch = self.motion.nearest(near, above);
            }
        }
        let placed = landed(above, &touch);
        if begins_well {
            return placed;
        }
        // Once more from above the middle: so vertices keep their distance, and far off the field is not exact.
        let aside = (placed.at - start.middle).dot(placed.normal);
        let above = start.middle + placed.normal * (aside + self.height);
        let touch = self.motion.nearest(near, above);
        if high(&touch) { landed(above, &touch) } else { placed }
    }

    /// The place on an edge or corner of the surface near `feature`, if there is one.
    fn sharp(&self, feature: &Feature, near: &Near) -> Option<DVec3> {
        let touch = self.motion.nearest(near, feature.at);
        if touch.distance.abs() <= 0.5 * SweptSurface::ACCURACY {
            return Some(feature.at);
        }
        if touch.distance > 0.0 {
            return Some(landed(feature.at, &touch).at);
        }
        let above = feature.at + feature.normal * (self.height - touch.distance);
        let touch = self.motion.nearest(near, above);
        (touch.distance > 0.0).then(|| landed(above, &touch).at)
    }
}

fn landed(above: DVec3, touch: &Touch) -> Placed {
    let way = if touch.distance.is_finite() { touch.distance } else { 0.0 };
    Placed { at: above - touch.normal * way, normal: touch.normal }
}

/// Where an edge or a corner of the surface is to be looked for.
#[derive(Clone, Copy)]
struct Feature {
    at: DVec3,
    /// Mean normal of the faces that meet there.
    normal: DVec3,
}

/// The edges and corners that vertices belong to: the place nearest to the tangent planes of all their neighbours, if
/// it `fits` the vertex. None where these face one way.
fn features(placed: &[Placed], quads: &[[u32; 4]], fits: impl Fn(usize, DVec3) -> bool + Sync) -> Vec<Option<Feature>> {
    let mut planes = vec![Planes::default(); placed.len()];
    for quad in quads {
        for &v in quad {
            for &w in quad {
                planes[v as usize].add(placed[w as usize], placed[v as usize].at);
            }
        }
    }
    let feature = |(v, planes): (usize, &Planes)| {
        let at = placed[v].at + planes.common_point()?;
        fits(v, at).then_some(Feature { at, normal: planes.sum.normalize_or_zero() })
    };
    planes.par_iter().enumerate().map(feature).collect()
}

/// Planes of which the nearest place to all is sought.
#[derive(Clone, Default)]
struct Planes {
    normals: Matrix3<f64>,
    offsets: Vector3<f64>,
    sum: DVec3,
}

impl Planes {
    /// Adds a tangent plane, seen from `origin`.
    fn add(&mut self, Placed { at, normal }: Placed, origin: DVec3) {
        let n = Vector3::from(normal.to_array());
        self.normals += n * n.transpose();
        self.offsets += n * normal.dot(at - origin);
        self.sum += normal;
    }

    /// The place from the origin, by least squares and no further than needed; none if the planes are much the same.
    fn common_point(&self) -> Option<DVec3> {
        let eigen = SymmetricEigen::new(self.normals);
        let greatest = eigen.eigenvalues.max();
        let mut point = Vector3::zeros();
        let mut count = 0;
        for (value, vector) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
            if *value > SPREAD * greatest {
                point += vector * (vector.dot(&self.offsets) / value);
                count += 1;
            }
        }
        (count > 1).then(|| DVec3::new(point.x, point.y, point.z))
    }
}

/// Splits a quadrangle along an edge of the surface if one runs across it, and else along the shorter diagonal.
fn split(quad: &[u32; 4], vertices: &[DVec3], sharp: impl Fn(u32) -> bool) -> [[u32; 3]; 2] {
    let [a, b, c, d] = *quad;
    let length = |v: u32, w: u32| vertices[v as usize].distance_squared(vertices[w as usize]);
    let by_ac = match (sharp(a) && sharp(c), sharp(b) && sharp(d)) {
        (true, false) => true,
        (false, true) => false,
        _ => length(a, c) <= length(b, d),
    };
    if by_ac { [[a, b, c], [a, c, d]] } else { [[b, c, d], [b, d, a]] }
}
