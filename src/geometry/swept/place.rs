//! Moves the vertices of a net onto the surface, and onto its edges and corners.

use glam::DVec3;
use nalgebra::{Matrix3, SymmetricEigen, Vector3};
use rayon::prelude::*;

use super::lattice::{Blocks, Lattice};
use super::motion::{Motion, Near};
use super::net::Net;
use crate::geometry::mesh::Mesh;
use crate::progress::{Cancel, Cancelled};

/// Most steps that bring a vertex onto the surface.
const STEPS: usize = 5;
/// Distance at which it has arrived (mm).
const ARRIVED: f64 = 5e-4;
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
    let smooth =
        by_block(&starts, &counts, blocks, cancel, |&start, near| onto(start, 1.5 * lattice.cell, near, motion))?;
    let targets = features(&smooth, &quads, |v, target| lattice.keeps(starts[v], target));
    let both: Vec<_> = smooth.iter().copied().zip(targets.iter().copied()).collect();
    let last = by_block(&both, &counts, blocks, cancel, |&(smooth, target), near| match target {
        Some(target) => onto(target, 0.5 * lattice.cell, near, motion),
        None => smooth,
    })?;
    let vertices: Vec<DVec3> = last.iter().map(|p| p.at).collect();
    let sharp = |v: u32| targets[v as usize].is_some();
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

/// Goes from `start` to the surface along the gradient, no further than `reach` away.
fn onto(start: DVec3, reach: f64, near: &Near, motion: &Motion) -> Placed {
    let mut placed = Placed { at: start, normal: DVec3::ZERO };
    for step in 0..STEPS {
        let touch = motion.nearest(near, placed.at);
        placed.normal = touch.normal;
        if touch.distance.abs() < ARRIVED || step + 1 == STEPS || !touch.distance.is_finite() {
            break;
        }
        placed.at = start + (placed.at - touch.normal * touch.distance - start).clamp_length_max(reach);
    }
    placed
}

/// Where vertices beside edges and corners belong: the place nearest to the tangent planes of all their neighbours, if
/// it `fits` the vertex. None for the others.
fn features(placed: &[Placed], quads: &[[u32; 4]], fits: impl Fn(usize, DVec3) -> bool + Sync) -> Vec<Option<DVec3>> {
    let mut planes = vec![(Matrix3::<f64>::zeros(), Vector3::<f64>::zeros()); placed.len()];
    for quad in quads {
        for &v in quad {
            let (a, b) = &mut planes[v as usize];
            for &w in quad {
                let Placed { at, normal } = placed[w as usize];
                let n = Vector3::from(normal.to_array());
                *a += n * n.transpose();
                *b += n * normal.dot(at - placed[v as usize].at);
            }
        }
    }
    let target = |(v, (a, b)): (usize, &(Matrix3<f64>, Vector3<f64>))| {
        let eigen = SymmetricEigen::new(*a);
        let greatest = eigen.eigenvalues.max();
        let counts = |i: &usize| eigen.eigenvalues[*i] > SPREAD * greatest;
        if (0..3).filter(counts).count() < 2 {
            return None;
        }
        let along =
            |i: usize| eigen.eigenvectors.column(i) * (eigen.eigenvectors.column(i).dot(b) / eigen.eigenvalues[i]);
        let shift: Vector3<f64> = (0..3).filter(counts).map(along).sum();
        let target = placed[v].at + DVec3::new(shift.x, shift.y, shift.z);
        fits(v, target).then_some(target)
    };
    planes.par_iter().enumerate().map(target).collect()
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
