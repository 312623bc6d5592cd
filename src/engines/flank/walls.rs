//! Walls: the parts of a mesh that the flutes must keep off while they mill a surface of it.
//!
//! The law:
//! - The triangles of the milled face itself are no walls. What is done to them is told by deviation and by
//!   [`super::own_surface`]. Which ones they are is known by their number where the face was picked from the mesh; what
//!   merely lies near the surface is a wall.
//! - Every other triangle is a wall, and the depth of its points in the flutes is a gouge.
//! - Walls that touch the face's border at a convex or smooth edge are in the flutes there as deep as the border
//!   itself: by what the path cuts the surface too deep at that place, and by what the border, which is made of chords,
//!   stands out of the surface. So much of their depth counts as touching, and no more. Walls that lean towards the
//!   tool, as a floor or a step does, have no such allowance.
//!
//! Not guaranteed: walls that touch the border between corners of its triangles only are not known to touch it, and
//! have no allowance either.

use std::collections::HashMap;

use glam::DVec3;
use rayon::prelude::*;

use super::path::FlankPath;
use super::ruled_surface::{RuledSurface, SurfacePlace};
use geometry::bvh::Bvh;
use geometry::exact::ExactMesh;
use geometry::mesh::{Mesh, normal_times_two_areas};
use geometry::weld::place;
use task::{Cancel, Cancelled};

/// How far a wall may turn towards the tool at the border and still go on smoothly (deg): as far as neighbouring facets
/// of one curved surface turn.
const SMOOTH_DEG: f64 = 20.0;

/// Triangles of a mesh that belong to the milled face.
#[derive(Debug, Clone, Copy)]
pub enum OwnTriangles<'a> {
    /// Triangles with these numbers.
    Listed(&'a [u32]),
    /// Triangles that lie on triangles of another mesh, to within a distance (mm): a second copy of the part.
    On(&'a Mesh, &'a [u32], f64),
    /// Triangles that lie on the surface, to within a distance (mm): where nothing else is known.
    Near(f64),
}

/// The walls of a mesh, ready to be held against the flutes; and the whole mesh, for the holder.
#[derive(Debug, Clone)]
pub struct Walls {
    /// All but the face's own triangles.
    pub(super) beside: Bvh,
    /// For each of them how deep its points may lie in the flutes (mm).
    pub(super) allowed: Vec<f64>,
    /// All triangles.
    pub(super) whole: Bvh,
}

impl Walls {
    /// The walls of `part` beside `surface`, for the flutes on `path`. What the border of the face stands out of the
    /// surface is allowed for up to `most_mm` only, the greatest distance of the face from the surface that is known.
    ///
    /// # Errors
    /// Cancelled.
    pub fn new(
        part: &Mesh,
        own: OwnTriangles,
        (surface, path): (&RuledSurface, &FlankPath),
        most_mm: f64,
        cancel: &Cancel,
    ) -> Result<Self, Cancelled> {
        let is_own = is_own(part, own, surface);
        cancel.check()?;
        let border = Border::of(part, &is_own, surface);
        let walls: Vec<[u32; 3]> = part.triangles.iter().zip(&is_own).filter(|t| !t.1).map(|t| *t.0).collect();
        let allowance = |t: &[u32; 3]| {
            let corners = t.map(|v| part.vertices[v as usize]);
            let places = border.touched(corners);
            places.into_iter().map(|p| depth_at(surface, path, p, most_mm)).fold(0.0, f64::max)
        };
        let allowed = walls.par_iter().map(allowance).collect();
        cancel.check()?;
        let beside = Bvh::new(&Mesh { vertices: part.vertices.clone(), triangles: walls }, cancel)?;
        Ok(Self { beside, allowed, whole: Bvh::new(part, cancel)? })
    }

    /// Corners of the walls' triangles.
    pub fn triangles(&self) -> &[[DVec3; 3]] {
        self.beside.triangles()
    }
}

fn is_own(part: &Mesh, own: OwnTriangles, surface: &RuledSurface) -> Vec<bool> {
    match own {
        OwnTriangles::Listed(numbers) => {
            let mut is_own = vec![false; part.triangles.len()];
            for &t in numbers {
                if let Some(own) = is_own.get_mut(t as usize) {
                    *own = true;
                }
            }
            is_own
        }
        OwnTriangles::On(other, numbers, within_mm) => {
            let face = numbers.iter().filter_map(|&t| other.triangles.get(t as usize)).copied().collect();
            let face = ExactMesh::new(&Mesh { vertices: other.vertices.clone(), triangles: face });
            let Ok(face) = face else { return vec![false; part.triangles.len()] };
            all_within(part, &|p: DVec3| face.nearest(p).point.distance(p) <= within_mm)
        }
        OwnTriangles::Near(within_mm) => {
            let is_near = near(surface, within_mm);
            all_within(part, &|p: DVec3| is_near(p) && surface.nearest(p).point.distance(p) <= within_mm)
        }
    }
}

/// Whether the corners and the middle of each triangle are all within.
fn all_within(part: &Mesh, is_within: &(dyn Fn(DVec3) -> bool + Sync)) -> Vec<bool> {
    let vertices: Vec<bool> = part.vertices.par_iter().map(|p| is_within(*p)).collect();
    let all = |t: &[u32; 3]| {
        let corners = t.map(|i| part.vertices[i as usize]);
        t.iter().all(|i| vertices[*i as usize]) && is_within((corners[0] + corners[1] + corners[2]) / 3.0)
    };
    part.triangles.par_iter().map(all).collect()
}

/// Whether a point may be within a distance of the surface: most of a part is so far off that a coarse look is enough.
fn near(surface: &RuledSurface, within_mm: f64) -> impl Fn(DVec3) -> bool + Sync {
    const ALONG: usize = 64;
    const ACROSS: usize = 8;
    let at = |i: usize, j: usize| surface.point(i as f64 / ALONG as f64, j as f64 / ACROSS as f64);
    let looks: Vec<DVec3> = (0..=ALONG).flat_map(|i| (0..=ACROSS).map(move |j| at(i, j))).collect();
    let steps = |k: usize| {
        let (i, j) = (k / ACROSS, k % ACROSS);
        at(i, j).distance(at(i + 1, j)).max(at(i, j + 1).distance(at(i + 1, j + 1))) + at(i, j).distance(at(i, j + 1))
    };
    let cell = (0..ALONG * ACROSS).map(steps).fold(0.0, f64::max);
    move |p: DVec3| looks.iter().any(|q| q.distance_squared(p) <= (within_mm + cell).powi(2))
}

/// The corners of the face's own triangles.
struct Border {
    /// At each place the normals, towards the tool, of the own triangles with a corner there.
    normals: HashMap<[u64; 3], Vec<DVec3>>,
}

impl Border {
    fn of(part: &Mesh, is_own: &[bool], surface: &RuledSurface) -> Self {
        let mut normals: HashMap<[u64; 3], Vec<DVec3>> = HashMap::new();
        let own: Vec<[DVec3; 3]> = part.iter_corners().zip(is_own).filter(|t| *t.1).map(|t| t.0).collect();
        let towards_tool = |corners: &[DVec3; 3]| {
            let normal = normal_times_two_areas(*corners).normalize_or_zero();
            let place = surface.nearest((corners[0] + corners[1] + corners[2]) / 3.0);
            if normal.dot(place.normal) < 0.0 { -normal } else { normal }
        };
        let turned: Vec<DVec3> = own.par_iter().map(towards_tool).collect();
        for (corners, normal) in own.iter().zip(turned).filter(|t| t.1 != DVec3::ZERO) {
            corners.iter().for_each(|p| normals.entry(place(*p)).or_default().push(normal));
        }
        Self { normals }
    }

    /// Places at which a triangle touches the border, if it goes on from there smoothly or away from the tool.
    fn touched(&self, corners: [DVec3; 3]) -> Vec<DVec3> {
        /// Shares of a side that both ends of touch.
        const ALONG: [f64; 3] = [0.25, 0.5, 0.75];
        let normals = corners.map(|p| self.normals.get(&place(p)));
        let mut places = Vec::new();
        for k in 0..3 {
            let Some(own) = normals[k] else { continue };
            let leans = |to: DVec3| {
                let way = (to - corners[k]).normalize_or_zero();
                // Over all of the own triangles there: those of a hollow face look at each other.
                own.iter().map(|n| way.dot(*n)).fold(f64::INFINITY, f64::min) > SMOOTH_DEG.to_radians().sin()
            };
            let next = (k + 1) % 3;
            if leans(corners[next]) || leans(corners[(k + 2) % 3]) {
                return Vec::new();
            }
            places.push(corners[k]);
            if normals[next].is_some() {
                places.extend(ALONG.map(|share| corners[k].lerp(corners[next], share)));
            }
        }
        places
    }
}

/// How deep a place of the face's border lies in the flutes where these stand over it (mm).
fn depth_at(surface: &RuledSurface, path: &FlankPath, p: DVec3, most_mm: f64) -> f64 {
    let SurfacePlace { u, v, point, normal, .. } = surface.nearest(p);
    let rises = (p - point).dot(normal).clamp(0.0, most_mm.max(0.0));
    // The deepest of the places of the grid around it, standing or moving.
    let both = [&path.deviation, &path.envelope.deviation];
    let around = |x: f64, n: usize| {
        let at = x.clamp(0.0, 1.0) * (n.max(2) - 1) as f64;
        [at.floor() as usize, at.ceil() as usize]
    };
    let deepest = both.iter().flat_map(|d| {
        let [along, across] = [around(u, d.grid[0]), around(v, d.grid[1])];
        along.into_iter().flat_map(move |i| across.map(|j| d.at(i, j).unwrap_or(0.0)))
    });
    rises + deepest.fold(0.0, |most: f64, e| most.max(-e))
}
