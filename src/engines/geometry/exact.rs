//! Exact distances to a mesh, through parry3d-f64's bounding volume hierarchy.

use std::sync::{Arc, OnceLock};

use glam::{DAffine3, DQuat, DVec3};
use parry3d_f64::math::Pose;
use parry3d_f64::partitioning::BvhNode;
use parry3d_f64::query::{self, ClosestPoints, PointQuery, Ray, RayCast};
use parry3d_f64::shape::{TriMesh, TriMeshFlags};
use rayon::prelude::*;

use super::mesh::{Bounds, Mesh};
use super::raycast::{RayMesh, is_met_by_ray};
use super::shells::Shells;

/// A mesh made ready for exact distance queries (errors of a few units in the last place of f64).
pub struct ExactMesh {
    shape: TriMesh,
    /// What is left of the mesh, where `shape` is only a part of it.
    rest: Option<Rest>,
    /// The shells of the mesh, found when first asked for.
    shells: OnceLock<Shells>,
}

/// A mesh of which only the part around a region was made ready. Answers that could depend on the rest take it into
/// account.
struct Rest {
    mesh: Arc<Mesh>,
    region: Bounds,
    /// Numbers in the mesh of the triangles that were made ready, those whose boxes meet the region.
    ready: Vec<u32>,
    /// All of the mesh, for rays and boxes.
    rays: RayMesh,
    /// All of the mesh, for distances; made ready once an answer needs it.
    whole: OnceLock<Option<TriMesh>>,
}

/// Reason why a mesh cannot be queried.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ExactMeshError {
    /// There are no triangles.
    #[error("the mesh has no triangles")]
    Empty,
    /// The hierarchy could not be built.
    #[error("the mesh cannot be searched: {0}")]
    Rejected(String),
}

/// The nearest point of a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nearest {
    /// The nearest point of the surface.
    pub point: DVec3,
    /// Distance, negative when the query point is inside the (closed, oriented) mesh.
    pub signed_distance: f64,
    /// The triangle it lies on.
    pub triangle: u32,
}

impl ExactMesh {
    /// Prepares `mesh`. Signs are meaningful only if it is closed and oriented outwards.
    pub fn new(mesh: &Mesh) -> Result<Self, ExactMeshError> {
        if mesh.triangles.is_empty() {
            return Err(ExactMeshError::Empty);
        }
        Ok(Self { shape: oriented(mesh)?, rest: None, shells: OnceLock::new() })
    }

    /// Prepares `mesh` for questions about places well inside of `region`: as exact as all of it anywhere, but the
    /// first distance that reaches out of the region waits until the whole mesh is made ready.
    pub fn around(mesh: Arc<Mesh>, region: Bounds) -> Result<Self, ExactMeshError> {
        let is_near: Vec<bool> = mesh.triangles.par_iter().map(|t| mesh.bounds_of(t).intersects(&region)).collect();
        let ready: Vec<u32> = (0..is_near.len()).filter(|&i| is_near[i]).map(|i| i as u32).collect();
        if ready.is_empty() || ready.len() == is_near.len() {
            return Self::new(&mesh);
        }
        let triangles = ready.iter().map(|&i| mesh.triangles[i as usize]).collect();
        let shape = oriented(&Mesh { vertices: mesh.vertices.clone(), triangles }.compacted())?;
        let rays = RayMesh::new(&mesh)?;
        let rest = Rest { mesh, region, ready, rays, whole: OnceLock::new() };
        Ok(Self { shape, rest: Some(rest), shells: OnceLock::new() })
    }

    /// All of the mesh.
    fn whole(&self) -> &TriMesh {
        let Some(rest) = &self.rest else { return &self.shape };
        rest.whole.get_or_init(|| oriented(&rest.mesh).ok()).as_ref().unwrap_or(&self.shape)
    }

    /// The nearest point of the surface to `p`.
    pub fn nearest(&self, p: DVec3) -> Nearest {
        let near = nearest_of(&self.shape, p);
        match &self.rest {
            None => near,
            // No other triangle is nearer than the end of the region, and none is missing beside the nearest point.
            Some(rest) if rest.reach(p) > near.signed_distance.abs() => {
                Nearest { triangle: rest.ready[near.triangle as usize], ..near }
            }
            Some(_) => nearest_of(self.whole(), p),
        }
    }

    /// Distance from `p` to the surface, negative inside.
    pub fn signed_distance(&self, p: DVec3) -> f64 {
        self.nearest(p).signed_distance
    }

    /// Whether the mesh has several shells and `p`, whose nearest point is given, lies in one of them that reaches to that
    /// point.
    pub fn is_in_overlapping_shell(&self, p: DVec3, nearest: &Nearest) -> bool {
        let mesh = |mesh: &TriMesh| Mesh { vertices: mesh.vertices().to_vec(), triangles: mesh.indices().to_vec() };
        let shells = self.shells.get_or_init(|| match &self.rest {
            Some(rest) => Shells::of(&rest.mesh),
            None => Shells::of(&mesh(&self.shape)),
        });
        let corners = match &self.rest {
            Some(rest) => rest.mesh.corners(nearest.triangle as usize),
            None => self.shape.triangle(nearest.triangle).vertices().to_owned(),
        };
        shells.hold(p, nearest.triangle, corners)
    }

    /// The triangles of which some point may lie within `reach` of `p` (those whose boxes do), in rising order.
    pub fn triangles_within(&self, p: DVec3, reach: f64) -> Vec<u32> {
        let mut found: Vec<u32> = match &self.rest {
            Some(rest) if reach >= rest.reach(p) => {
                rest.rays.meeting(&rest.mesh, |b| b.distance_to(p) <= reach).collect()
            }
            rest => {
                let near = |node: &BvhNode| node.aabb().distance_to_local_point(p, true) <= reach;
                let number = |i: u32| rest.as_ref().map_or(i, |rest| rest.ready[i as usize]);
                self.shape.bvh().leaves(near).map(number).collect()
            }
        };
        found.sort_unstable();
        found
    }

    /// The triangles whose boxes meet `bounds`, as a mesh of their own.
    pub fn part_within(&self, bounds: Bounds) -> Mesh {
        let vertices: Vec<DVec3> = self.triangles_meeting(|b| b.intersects(&bounds)).flatten().collect();
        let triangles = (0..vertices.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        Mesh { vertices, triangles }
    }

    /// Distance along the unit vector `direction` from `origin` to the first crossing of the surface from
    /// either side, if there is one within `reach`.
    pub fn first_crossing(&self, origin: DVec3, direction: DVec3, reach: f64) -> Option<f64> {
        self.whole().cast_local_ray(&Ray::new(origin, direction), reach, false)
    }

    /// The triangles whose boxes the ray from `origin` along `direction` meets.
    pub fn triangles_along(&self, origin: DVec3, direction: DVec3) -> impl Iterator<Item = [DVec3; 3]> {
        self.triangles_meeting(is_met_by_ray(origin, direction))
    }

    /// The triangles of which the boxes meet something, as larger boxes around them do.
    fn triangles_meeting(&self, meets: impl Fn(&Bounds) -> bool + Copy) -> impl Iterator<Item = [DVec3; 3]> {
        let of_rest = self.rest.iter();
        let of_rest =
            of_rest.flat_map(move |rest| rest.rays.meeting(&rest.mesh, meets).map(|i| rest.mesh.corners(i as usize)));
        let whole = self.rest.is_none().then_some(&self.shape).into_iter();
        let of_whole = whole.flat_map(move |shape| {
            let leaves = shape.bvh().leaves(move |node| meets(&Bounds { min: node.mins(), max: node.maxs() }));
            leaves.map(|i| shape.triangle(i).vertices().to_owned())
        });
        of_whole.chain(of_rest)
    }

    /// The least distance between this mesh and `other` moved by the rigid motion `placement`; 0 when they
    /// touch or cross. This is the library's own query, slow where the surfaces run close to each other.
    pub fn distance_to(&self, other: &ExactMesh, placement: &DAffine3) -> f64 {
        let pose = Pose::from_parts(placement.translation, DQuat::from_mat3(&placement.matrix3));
        query::distance(&Pose::IDENTITY, self.whole(), &pose, other.whole()).map_or(f64::NAN, |d| d.distance)
    }

    /// The point of this mesh that is nearest to `other` moved by `shift`; none if they touch or cross, or are further
    /// apart than `within`.
    pub fn nearest_to(&self, other: &ExactMesh, shift: DVec3, within: f64) -> Option<DVec3> {
        let pose = Pose::from_translation(shift);
        match query::closest_points(&Pose::IDENTITY, self.whole(), &pose, other.whole(), within) {
            Ok(ClosestPoints::WithinMargin(own, _)) => Some(own),
            _ => None,
        }
    }
}

impl Rest {
    /// Distance up to which everything around `p` was made ready (mm), negative outside of the region.
    fn reach(&self, p: DVec3) -> f64 {
        (p - self.region.min).min_element().min((self.region.max - p).min_element())
    }
}

pub(super) fn oriented(mesh: &Mesh) -> Result<TriMesh, ExactMeshError> {
    TriMesh::with_flags(mesh.vertices.clone(), mesh.triangles.clone(), TriMeshFlags::ORIENTED)
        .map_err(|e| ExactMeshError::Rejected(e.to_string()))
}

pub(super) fn nearest_of(shape: &TriMesh, p: DVec3) -> Nearest {
    let projection = shape.project_local_point(p, false);
    let distance = (p - projection.point).length();
    Nearest {
        point: projection.point,
        signed_distance: if projection.is_inside { -distance } else { distance },
        triangle: projection.subshape,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_made_ready_around_a_region_answers_as_the_whole_does() {
        // Boxes in a row, of which the region holds the second.
        let mut mesh = Mesh::default();
        for k in 0..40 {
            let one = Mesh::cuboid(DVec3::ONE).mapped(|p| p + DVec3::X * 1.5 * f64::from(k));
            let first = mesh.vertices.len() as u32;
            mesh.vertices.extend(one.vertices);
            mesh.triangles.extend(one.triangles.iter().map(|t| t.map(|v| v + first)));
        }
        let whole = ExactMesh::new(&mesh).unwrap();
        let region = Bounds { min: DVec3::new(1.2, -1.0, -1.0), max: DVec3::new(2.8, 2.0, 2.0) };
        let part = ExactMesh::around(mesh.into(), region).unwrap();
        assert!(part.shape.indices().len() == 12 && part.rest.is_some());
        for (i, place) in (0..200).map(|i| (i, f64::from(i))) {
            let p =
                DVec3::new(1.3 + 1.4 * (0.31 * place).fract(), (0.71 * place).fract(), 1.9 * (0.37 * place).fract());
            let (a, b) = (part.nearest(p), whole.nearest(p));
            assert_eq!((a.point, a.signed_distance), (b.point, b.signed_distance), "{p}");
            assert_eq!(part.triangles_within(p, 0.02 * place), whole.triangles_within(p, 0.02 * place));
            let along = DVec3::new(1.0, 0.01 * (0.13 * place).fract() - 0.005, 0.003);
            let met = |mesh: &ExactMesh| {
                let mut met: Vec<String> = mesh.triangles_along(p, along).map(|t| format!("{t:?}")).collect();
                met.sort();
                met
            };
            assert_eq!(met(&part), met(&whole), "{i}");
        }
        let far = DVec3::new(30.2, 0.5, 0.6);
        assert_eq!(part.nearest(far), whole.nearest(far));
    }

    #[test]
    fn distances_to_a_box_are_those_of_a_box() {
        let mesh = ExactMesh::new(&Mesh::cuboid(DVec3::splat(2.0))).unwrap();
        for (p, expected) in [
            (DVec3::new(1.0, 1.0, 3.0), 1.0),
            (DVec3::new(3.0, 3.0, 1.0), 2f64.sqrt()),
            (DVec3::new(1.0, 1.0, 0.25), -0.25),
            (DVec3::new(-1.0, -1.0, -1.0), 3f64.sqrt()),
        ] {
            assert!((mesh.signed_distance(p) - expected).abs() < 1e-12, "{p}");
        }
        let other = ExactMesh::new(&Mesh::cuboid(DVec3::ONE)).unwrap();
        let moved = DAffine3::from_translation(DVec3::new(2.5, 2.5, 0.0));
        assert!((mesh.distance_to(&other, &moved) - 0.5f64.hypot(0.5)).abs() < 1e-9);
        let nearest = mesh.nearest_to(&other, DVec3::new(2.5, 0.5, 0.5), 1.0).unwrap();
        assert!((nearest.x - 2.0).abs() < 1e-9 && mesh.signed_distance(nearest).abs() < 1e-9, "{nearest}");
        assert_eq!(mesh.nearest_to(&other, DVec3::new(1.5, 0.5, 0.5), 1.0), None, "they cross");
        assert_eq!(mesh.nearest_to(&other, DVec3::new(4.5, 0.5, 0.5), 1.0), None, "too far apart");
        assert_eq!(mesh.first_crossing(DVec3::new(1.0, 1.0, 5.0), DVec3::NEG_Z, 10.0), Some(3.0));
    }
}
