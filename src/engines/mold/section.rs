//! Horizontal sections of a mold.
//!
//! A section is taken just above its height: vertices at that very height count as below. So no vertex ever lies on
//! the plane, horizontal faces at that height are not cut, and every triangle is crossed by at most one segment. Where
//! the mesh is closed and oriented the segments join into closed outlines with the material on their left.

use std::collections::HashMap;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::outline::{Outline, without_straight_points};
use geometry::mesh::Mesh;
use task::{Cancel, Cancelled};

/// Deviation up to which a point counts as on a straight line (mm): what single precision makes of coordinates.
const STRAIGHT: f64 = 6e-6;

/// Single-precision roundings that a coordinate may have gone through: one when the part was written, one when it was
/// moved or turned.
const ROUNDINGS: f64 = 2.0;

/// How far the vertices of a mesh may be from where they were meant to be (mm): files hold coordinates in single
/// precision, so each is off by up to 2^-24 of the greatest, and in space by the square root of 3 times as much.
pub fn vertex_error(mesh: &Mesh) -> f64 {
    let bounds = mesh.bounds();
    let greatest = bounds.min.abs().max(bounds.max.abs()).max_element();
    let rounding = if greatest.is_finite() { greatest * 2f64.powi(-24) } else { 0.0 };
    ROUNDINGS * 3f64.sqrt() * rounding
}

/// How far the outlines of a mesh may lie off the walls that were meant (mm): as far as its vertices, and as points that
/// are left out as on a straight line.
pub fn outline_error(mesh: &Mesh) -> f64 {
    STRAIGHT + vertex_error(mesh)
}

/// Section of a mold by a horizontal plane.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Section {
    /// The height (mm).
    pub z: f64,
    /// Closed outlines, material on the left.
    pub outlines: Vec<Outline>,
    /// Pieces of outlines that do not close, where the mesh is open or not oriented: their ends (mm).
    pub open: Vec<[DVec2; 2]>,
}

/// An edge of the mesh: its vertices, the smaller first.
type EdgeKey = (u32, u32);

/// The sections of `mesh` at `heights` (mm), in that order.
///
/// # Errors
/// [`Cancelled`].
pub fn sections(mesh: &Mesh, heights: &[f64], cancel: &Cancel) -> Result<Vec<Section>, Cancelled> {
    let mut order: Vec<usize> = (0..heights.len()).collect();
    order.sort_by(|&a, &b| heights[a].total_cmp(&heights[b]));
    let sorted: Vec<f64> = order.iter().map(|&i| heights[i]).collect();
    let mut crossing: Vec<Vec<u32>> = vec![Vec::new(); heights.len()];
    for (i, corners) in mesh.iter_corners().enumerate() {
        let [low, high] = corners.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], p| [a.min(p.z), b.max(p.z)]);
        // Crossed just above z: low <= z < high.
        let from = sorted.partition_point(|&z| z < low);
        let to = sorted.partition_point(|&z| z < high);
        (from..to).for_each(|k| crossing[order[k]].push(i as u32));
    }
    let cut = |(z, triangles): (&f64, &Vec<u32>)| {
        cancel.check()?;
        Ok(section(mesh, *z, triangles))
    };
    heights.par_iter().zip(&crossing).map(cut).collect()
}

fn section(mesh: &Mesh, z: f64, triangles: &[u32]) -> Section {
    let mut next: HashMap<EdgeKey, Vec<EdgeKey>> = HashMap::with_capacity(triangles.len());
    let mut starts = Vec::with_capacity(triangles.len());
    for &t in triangles {
        if let Some([from, to]) = crossed_edges(mesh, mesh.triangles[t as usize], z) {
            next.entry(from).or_default().push(to);
            starts.push(from);
        }
    }
    let mut section = Section { z, ..Section::default() };
    // Open ends first: a piece begins where no other one ends.
    let mut ends: HashMap<EdgeKey, usize> = HashMap::new();
    next.values().flatten().for_each(|to| *ends.entry(*to).or_default() += 1);
    let begins = |key: &EdgeKey| next.get(key).map_or(0, Vec::len) > ends.get(key).copied().unwrap_or(0);
    let (first, rest): (Vec<EdgeKey>, Vec<EdgeKey>) = starts.iter().partition(|key| begins(key));
    for start in first.into_iter().chain(rest) {
        let Some(keys) = walk(&mut next, start) else { continue };
        let is_closed = keys.len() > 2 && keys.first() == keys.last();
        let points: Vec<DVec2> = keys.iter().map(|&key| crossing_point(mesh, key, z)).collect();
        if !is_closed {
            section.open.extend(points.first().zip(points.last()).map(|(a, b)| [*a, *b]));
            continue;
        }
        let points = without_straight_points(&points[1..], STRAIGHT);
        section.outlines.extend(Outline::new(points));
    }
    section
}

/// The edges that the plane crosses, from and to, with the material on the left on the way.
fn crossed_edges(mesh: &Mesh, triangle: [u32; 3], z: f64) -> Option<[EdgeKey; 2]> {
    let above = triangle.map(|v| mesh.vertices[v as usize].z > z);
    let count = above.iter().filter(|a| **a).count();
    // The corner that is alone on its side.
    let alone = above.iter().position(|&a| a == (count == 1)).filter(|_| count == 1 || count == 2)?;
    let [a, b, c] = [0, 1, 2].map(|k| triangle[(alone + k) % 3]);
    let key = |p: u32, q: u32| (p.min(q), p.max(q));
    let [first, second] = [key(a, b), key(c, a)];
    Some(if count == 1 { [first, second] } else { [second, first] })
}

/// Takes segments from `next` from `start` on until there is no further one, or it is back at `start`.
fn walk(next: &mut HashMap<EdgeKey, Vec<EdgeKey>>, start: EdgeKey) -> Option<Vec<EdgeKey>> {
    let mut keys = vec![start, next.get_mut(&start)?.pop()?];
    while let Some(&last) = keys.last() {
        if last == start {
            break;
        }
        match next.get_mut(&last).and_then(Vec::pop) {
            Some(further) => keys.push(further),
            None => break,
        }
    }
    Some(keys)
}

fn crossing_point(mesh: &Mesh, (a, b): EdgeKey, z: f64) -> DVec2 {
    let [a, b]: [DVec3; 2] = [a, b].map(|v| mesh.vertices[v as usize]);
    a.truncate().lerp(b.truncate(), ((z - a.z) / (b.z - a.z)).clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(mesh: &Mesh, z: f64) -> Section {
        sections(mesh, &[z], &Cancel::default()).unwrap().remove(0)
    }

    #[test]
    fn a_box_has_its_rectangle_up_to_but_not_at_its_top() {
        let mesh = Mesh::cuboid(DVec3::new(1.0, 2.0, 3.0));
        let bounds = mesh.bounds();
        for z in [bounds.min.z, 0.5 * (bounds.min.z + bounds.max.z), bounds.max.z - 1e-9] {
            let section = at(&mesh, z);
            assert_eq!((section.outlines.len(), section.open.len()), (1, 0), "{z}");
            let size = bounds.size();
            assert!((section.outlines[0].area() - size.x * size.y).abs() < 1e-9, "material on the left");
            assert_eq!(section.outlines[0].points().len(), 4);
        }
        assert!(at(&mesh, bounds.max.z).outlines.is_empty() && at(&mesh, bounds.min.z - 1e-9).outlines.is_empty());
    }

    #[test]
    fn an_open_mesh_says_where() {
        let mut mesh = Mesh::cuboid(DVec3::new(1.0, 2.0, 3.0));
        let z = mesh.bounds().center().z;
        let side = mesh.iter_corners().position(|c| {
            let zs = c.map(|p| p.z);
            zs.iter().any(|&v| v > z) && zs.iter().any(|&v| v < z)
        });
        mesh.triangles.remove(side.unwrap());
        let section = at(&mesh, z);
        assert_eq!((section.outlines.len(), section.open.len()), (0, 1));
    }
}
