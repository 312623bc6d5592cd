//! Planes that cut a sector out of a wheel, and the part of a mesh on one side of a plane.

use std::collections::HashMap;

use glam::DVec3;
use rayon::prelude::*;

use geometry::mesh::{Mesh, normal_times_two_areas};
use task::{Cancel, Cancelled};

/// A plane that all of a mesh lies on one side of.
pub(super) struct Cut {
    /// Unit normal, away from the mesh.
    pub normal: DVec3,
    /// Distance from the origin along the normal (mm).
    pub at: f64,
    /// Area of the mesh in it (mm^2).
    pub area: f64,
}

impl Cut {
    /// Corners of the facets of the mesh in it.
    pub fn facets(&self, mesh: &Mesh, on_cut: f64) -> impl Iterator<Item = [DVec3; 3]> {
        mesh.iter_corners().filter(move |t| t.iter().all(|p| self.at - self.normal.dot(*p) <= on_cut))
    }
}

/// Planes that the mesh lies on one side of, and with a part of its surface in, the largest part first.
///
/// # Errors
/// [`Cancelled`].
pub(super) fn cuts(mesh: &Mesh, on_cut: f64, cancel: &Cancel) -> Result<Vec<Cut>, Cancelled> {
    /// Directions that are looked at, those of most area.
    const MOST: usize = 200;
    /// Normals in one of these steps are one direction.
    const STEP: f64 = 1e-3;
    /// Least share of the surface.
    const LEAST: f64 = 1e-3;
    let mut directions: HashMap<[i32; 3], DVec3> = HashMap::new();
    let mut whole = 0.0;
    for (i, corners) in mesh.iter_corners().enumerate() {
        if i % (1 << 16) == 0 {
            cancel.check()?;
        }
        let normal = normal_times_two_areas(corners);
        whole += 0.5 * normal.length();
        let key = (normal.normalize_or_zero() / STEP).round().as_ivec3().to_array();
        *directions.entry(key).or_default() += normal;
    }
    let mut directions: Vec<([i32; 3], DVec3)> = directions.into_iter().collect();
    directions.sort_by(|(i, a), (j, b)| b.length_squared().total_cmp(&a.length_squared()).then(i.cmp(j)));
    directions.truncate(MOST);
    let cut = |(_, direction): &([i32; 3], DVec3)| {
        cancel.check()?;
        let normal = direction.normalize_or_zero();
        let furthest = |normal: DVec3| mesh.vertices.iter().map(|p| normal.dot(*p)).fold(f64::NEG_INFINITY, f64::max);
        let (mut cut, near) = (Cut { normal, at: furthest(normal), area: 0.0 }, 50.0 * on_cut);
        // Once more with the normal of all that lies near and looks that way: a step holds some triangles of a cut.
        for within in [near, on_cut] {
            cancel.check()?;
            let looks = |normal: DVec3| normal.dot(cut.normal) > (1.0 - 2.0 * STEP * STEP) * normal.length();
            let lies = |t: &[DVec3; 3]| t.iter().all(|p| cut.at - cut.normal.dot(*p) <= within);
            let normals = mesh.iter_corners().filter(lies).map(normal_times_two_areas);
            let sum: DVec3 = normals.filter(|normal| looks(*normal)).sum();
            let normal = sum.normalize_or_zero();
            cut = Cut { normal, at: furthest(normal), area: 0.5 * sum.length() };
        }
        Ok(cut)
    };
    let mut cuts: Vec<Cut> = directions.par_iter().map(cut).collect::<Result<_, Cancelled>>()?;
    cuts.retain(|cut| cut.area > LEAST * whole);
    let mut found: Vec<Cut> = Vec::new();
    for cut in cuts {
        if !found.iter().any(|known: &Cut| known.normal.dot(cut.normal) > 1.0 - STEP * STEP) {
            found.push(cut);
        }
    }
    found.sort_by(|a, b| b.area.total_cmp(&a.area));
    Ok(found)
}

/// The part of `mesh` on the side of the plane through the origin that `inward` points to, without what lies in the
/// plane. Vertices within `on_cut` of the plane are moved into it.
pub(super) fn clipped(mesh: &Mesh, inward: DVec3, on_cut: f64) -> Mesh {
    let height: Vec<f64> = mesh.vertices.iter().map(|p| inward.dot(*p)).collect();
    let height: Vec<f64> = height.into_iter().map(|h| if h.abs() <= on_cut { 0.0 } else { h }).collect();
    let moved = |(p, h): (&DVec3, &f64)| if *h == 0.0 { *p - inward * inward.dot(*p) } else { *p };
    let mut vertices: Vec<DVec3> = mesh.vertices.iter().zip(&height).map(moved).collect();
    let mut between: HashMap<[u32; 2], u32> = HashMap::new();
    let mut triangles = Vec::new();
    for t in &mesh.triangles {
        let heights = t.map(|v| height[v as usize]);
        if heights.iter().all(|h| *h <= 0.0) {
            continue;
        }
        let mut corners: Vec<u32> = Vec::with_capacity(4);
        for i in 0..3 {
            let (a, b) = (t[i], t[(i + 1) % 3]);
            let (above, below) = (heights[i], heights[(i + 1) % 3]);
            if above >= 0.0 {
                corners.push(a);
            }
            if above * below < 0.0 {
                let edge = [a.min(b), a.max(b)];
                let cut = *between.entry(edge).or_insert_with(|| {
                    let [p, q] = edge.map(|v| (vertices[v as usize], height[v as usize]));
                    vertices.push(p.0.lerp(q.0, p.1 / (p.1 - q.1)));
                    vertices.len() as u32 - 1
                });
                corners.push(cut);
            }
        }
        triangles.extend((2..corners.len()).map(|i| [corners[0], corners[i - 1], corners[i]]));
    }
    Mesh { vertices, triangles }.compacted()
}
