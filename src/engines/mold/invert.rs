//! Invert faces, which look downwards, and the shadow that they throw on what lies below.
//!
//! A cutter from above cannot reach an invert face, and material above a place is in its way there. So a layer at
//! height z is blocked by S(z), the union of the mold's sections at z and above. Material above z either goes on down
//! to z or ends in a face that looks downwards; hence S(z) is the section at z united with the plan projection of the
//! parts of such faces above z, exactly. Without invert faces it is the section as it is.

use std::sync::Arc;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use glam::{DVec2, DVec3};

use super::outline::Outline;
use super::plane;
use super::section::{Section, vertex_error};
use geometry::mesh::{Mesh, normal_times_two_areas, unit_normal};
use task::{Cancel, Cancelled};

/// Faces whose unit normal along the opening is less than this look away; vertical walls do not.
pub(crate) const DOWNWARDS: f64 = -1e-3;
/// How far above the mesh's bottom a face must reach not to belong to its base (mm).
const BASE: f64 = 1e-6;
/// Area of faces that look downwards up to which it is rounding (mm^2).
pub const LEAST_INVERT: f64 = 1e-2;
/// Gaps up to this width between a section and a shadow are rounding, and are closed (mm).
const GAP: f64 = 2e-5;

/// How far the normal of a triangle may be off (radians), whose vertices are off by `error` (mm): narrow ones tilt far.
pub(super) fn tilt(corners: [DVec3; 3], error: f64) -> f64 {
    let [a, b, c] = corners;
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    let height = normal_times_two_areas(corners).length() / longest;
    if height > 0.0 { 2.0 * error / height } else { f64::INFINITY }
}

/// Whether a face looks away from a direction, a unit vector, by more than vertices that are off by `error` (mm) make of
/// a wall along it.
pub(super) fn looks_away(corners: [DVec3; 3], direction: DVec3, error: f64) -> bool {
    let up = unit_normal(corners).dot(direction);
    up < DOWNWARDS && -up > tilt(corners, error)
}

/// Height up to which faces are of a mesh's base (mm): by rounding it is no plane, and lies a hair aslant.
pub(super) fn base(mesh: &Mesh) -> f64 {
    mesh.bounds().min.z + BASE.max(2.0 * vertex_error(mesh))
}

/// The faces of a mold that no cutter from above reaches.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct InvertFaces {
    /// Indices in the mesh, in order.
    pub triangles: Vec<u32>,
    /// Area (mm^2).
    pub area: f64,
}

impl InvertFaces {
    /// Middle (mm) and outward unit normal of the largest of the faces, of a mesh with the same triangles; none where there
    /// is no face.
    pub fn largest(&self, mesh: &Mesh) -> Option<[DVec3; 2]> {
        let corners = self.triangles.iter().map(|i| mesh.corners(*i as usize));
        let area = |c: &[DVec3; 3]| normal_times_two_areas(*c).length_squared();
        let largest = corners.max_by(|a, b| area(a).total_cmp(&area(b)))?;
        Some([(largest[0] + largest[1] + largest[2]) / 3.0, unit_normal(largest)])
    }

    /// The invert faces of `mesh`.
    pub fn of(mesh: &Mesh) -> Self {
        let error = vertex_error(mesh);
        let base = base(mesh);
        let is_invert = |[a, b, c]: [DVec3; 3]| a.z.max(b.z).max(c.z) > base && looks_away([a, b, c], DVec3::Z, error);
        let triangles: Vec<u32> =
            mesh.iter_corners().enumerate().filter(|(_, corners)| is_invert(*corners)).map(|(i, _)| i as u32).collect();
        let area = |i: &u32| 0.5 * normal_times_two_areas(mesh.corners(*i as usize)).length();
        Self { area: triangles.iter().map(area).sum(), triangles }
    }
}

/// The shadows of the invert faces of a mesh at heights that were asked for.
pub struct Shadows<'a> {
    mesh: &'a Mesh,
    faces: InvertFaces,
    /// Heights, the greatest first, each with the projection of what lies above it.
    known: Vec<(f64, Arc<Vec<Outline>>)>,
}

impl<'a> Shadows<'a> {
    /// No shadow yet.
    pub fn new(mesh: &'a Mesh) -> Self {
        Self { mesh, faces: InvertFaces::of(mesh), known: Vec::new() }
    }

    /// The faces that throw them.
    pub fn faces(&self) -> &InvertFaces {
        &self.faces
    }

    /// Sections with the shadow on them, at their own heights: what is in a cutter's way.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn cast(&mut self, sections: &mut [Section], cancel: &Cancel) -> Result<(), Cancelled> {
        if self.faces.triangles.is_empty() {
            return Ok(());
        }
        let heights: Vec<f64> = sections.iter().map(|s| s.z).collect();
        self.prepare(&heights, cancel)?;
        let shaded = |section: &mut Section| {
            cancel.check()?;
            let shadow = self.at(section.z);
            if !shadow.is_empty() {
                section.outlines = without_gaps(&plane::outlines(plane::union(&section.outlines, &shadow)));
            }
            Ok(())
        };
        sections.par_iter_mut().try_for_each(shaded)
    }

    /// The projection of what lies above a height that has been prepared.
    fn at(&self, z: f64) -> Arc<Vec<Outline>> {
        let at = self.known.partition_point(|(height, _)| *height > z);
        self.known.get(at).filter(|(height, _)| *height == z).map(|(_, shadow)| shadow.clone()).unwrap_or_default()
    }

    /// Finds the shadows at `heights`: each from the next higher one and the parts of faces between.
    fn prepare(&mut self, heights: &[f64], cancel: &Cancel) -> Result<(), Cancelled> {
        let mut new: Vec<f64> = heights.iter().copied().filter(|z| !self.known.iter().any(|(k, _)| k == z)).collect();
        new.sort_by(|a, b| b.total_cmp(a));
        new.dedup();
        let ceilings: Vec<f64> = new
            .iter()
            .enumerate()
            .map(|(i, &z)| {
                let known = self.known.iter().map(|(k, _)| *k).filter(|k| *k > z).fold(f64::INFINITY, f64::min);
                if i > 0 { known.min(new[i - 1]) } else { known }
            })
            .collect();
        let slab = |(low, high): (&f64, &f64)| {
            cancel.check()?;
            Ok(self.between(*low, *high))
        };
        let slabs: Vec<Vec<Outline>> = new.par_iter().zip(&ceilings).map(slab).collect::<Result<_, _>>()?;
        for ((z, ceiling), slab) in new.into_iter().zip(ceilings).zip(slabs) {
            cancel.check()?;
            let above = self.at(ceiling);
            let shadow = if slab.is_empty() { above } else { Arc::new(plane::outlines(plane::union(&above, &slab))) };
            let at = self.known.partition_point(|(height, _)| *height > z);
            self.known.insert(at, (z, shadow));
        }
        Ok(())
    }

    /// The projection of the parts of the faces between two heights.
    fn between(&self, low: f64, high: f64) -> Vec<Outline> {
        let parts = self.faces.triangles.iter().filter_map(|&i| {
            let corners = self.mesh.corners(i as usize);
            // Seen from above a face that looks downwards runs clockwise.
            let mut points: Vec<DVec2> = clipped(&corners, low, high)?.iter().rev().map(|p| p.truncate()).collect();
            points.dedup();
            Outline::new(points)
        });
        let parts: Vec<Outline> = parts.collect();
        if parts.is_empty() { parts } else { plane::outlines(plane::union(&parts, &[])) }
    }
}

/// The part of a triangle between two heights; none if it has no extent.
fn clipped(corners: &[DVec3; 3], low: f64, high: f64) -> Option<Vec<DVec3>> {
    let zs = corners.map(|p| p.z);
    // A level face counts where it lies: above the lower height.
    let (least, most) =
        (zs.iter().copied().fold(f64::INFINITY, f64::min), zs.into_iter().fold(f64::NEG_INFINITY, f64::max));
    if most <= low || least > high {
        return None;
    }
    let above = clip(corners, |p| p.z - low);
    let between = if high.is_finite() { clip(&above, |p| high - p.z) } else { above };
    (between.len() > 2).then_some(between)
}

/// The part of a polygon where `side`, which is linear, is not negative.
fn clip(points: &[DVec3], side: impl Fn(DVec3) -> f64) -> Vec<DVec3> {
    let n = points.len();
    let mut kept = Vec::with_capacity(n + 1);
    for i in 0..n {
        let (p, q) = (points[i], points[(i + 1) % n]);
        let (at_p, at_q) = (side(p), side(q));
        if at_p >= 0.0 {
            kept.push(p);
        }
        if (at_p > 0.0 && at_q < 0.0) || (at_p < 0.0 && at_q > 0.0) {
            kept.push(p.lerp(q, at_p / (at_p - at_q)));
        }
    }
    kept
}

/// Outlines with gaps narrower than [`GAP`] closed: grown by half of it and shrunk again, corners kept.
pub(super) fn without_gaps(outlines: &[Outline]) -> Vec<Outline> {
    let points = |o: &Outline| super::outline::without_straight_points(o.points(), 0.5 * GAP);
    let grown = plane::grown(outlines, 0.5 * GAP);
    let closed = plane::grown(&plane::outlines(grown), -0.5 * GAP);
    plane::outlines(closed).iter().filter_map(|o| Outline::new(points(o))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::section::sections;

    /// A post with a plate on it: `[4, 6] x [4, 6] x [0, 6]` under `[0, 10] x [0, 10] x [5, 6]`, as one surface.
    fn table() -> Mesh {
        let at = |x: [f64; 2], y: [f64; 2], z: [f64; 2]| {
            let size = DVec3::new(x[1] - x[0], y[1] - y[0], z[1] - z[0]);
            Mesh::cuboid(size).mapped(|p| p + DVec3::new(x[0], y[0], z[0]))
        };
        let mut mesh = at([4.0, 6.0], [4.0, 6.0], [0.0, 5.0]);
        let top = at([0.0, 10.0], [0.0, 10.0], [5.0, 6.0]);
        let n = mesh.vertices.len() as u32;
        mesh.vertices.extend(&top.vertices);
        mesh.triangles.extend(top.triangles.iter().map(|t| t.map(|v| v + n)));
        mesh
    }

    fn shaded(mesh: &Mesh, heights: &[f64]) -> Vec<f64> {
        let mut sections = sections(mesh, heights, &Cancel::default()).unwrap();
        Shadows::new(mesh).cast(&mut sections, &Cancel::default()).unwrap();
        sections.iter().map(|s| plane::area(&s.outlines)).collect()
    }

    #[test]
    fn a_plate_shades_what_is_under_it() {
        let mesh = table();
        let faces = InvertFaces::of(&mesh);
        // The plate's underside; the post's bottom is the base.
        assert!(faces.triangles.len() == 2 && (faces.area - 100.0).abs() < 1e-9, "{faces:?}");
        for (area, expected) in shaded(&mesh, &[5.5, 4.0, 0.5, 6.5]).into_iter().zip([100.0, 100.0, 100.0, 0.0]) {
            assert!((area - expected).abs() < 1e-6, "{area} {expected}");
        }
    }

    /// A cone on its tip throws at every height the disc that it has above.
    #[test]
    fn what_widens_upwards_shades_as_far_as_it_goes() {
        let block = Mesh::cuboid(DVec3::new(4.0, 4.0, 2.0));
        // Turned into a frustum: 4 x 4 at the bottom, 8 x 4 at the top.
        let mesh = block.mapped(|p| DVec3::new(p.x * (1.0 + 0.5 * p.z), p.y, p.z));
        let areas = shaded(&mesh, &[0.0, 0.5, 1.0, 1.9]);
        let own = sections(&mesh, &[1.0], &Cancel::default()).unwrap();
        assert!((plane::area(&own[0].outlines) - 24.0).abs() < 1e-9);
        assert!(areas.iter().all(|a| (a - 32.0).abs() < 1e-6), "{areas:?}");
        // The same however the heights were asked for.
        let mut shadows = Shadows::new(&mesh);
        for z in [1.9, 0.5, 1.0] {
            let mut section = sections(&mesh, &[z], &Cancel::default()).unwrap();
            shadows.cast(&mut section, &Cancel::default()).unwrap();
            assert!((plane::area(&section[0].outlines) - 32.0).abs() < 1e-6);
        }
    }

    #[test]
    fn without_invert_faces_a_section_is_as_it_was() {
        let mesh = Mesh::cuboid(DVec3::new(3.0, 4.0, 5.0));
        let before = sections(&mesh, &[0.0, 2.0], &Cancel::default()).unwrap();
        let mut after = before.clone();
        Shadows::new(&mesh).cast(&mut after, &Cancel::default()).unwrap();
        assert_eq!(before, after);
    }
}
