//! Exact distances to a mesh, through parry3d-f64's bounding volume hierarchy.

use glam::{DAffine3, DQuat, DVec3};
use parry3d_f64::bounding_volume::BoundingVolume;
use parry3d_f64::math::Pose;
use parry3d_f64::partitioning::BvhNode;
use parry3d_f64::query::{self, ClosestPoints, PointQuery, Ray, RayCast};
use parry3d_f64::shape::{TriMesh, TriMeshFlags};

use super::mesh::Mesh;

/// A mesh made ready for exact distance queries (errors of a few units in the last place of f64).
pub struct ExactMesh {
    shape: TriMesh,
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
        let shape = TriMesh::with_flags(mesh.vertices.clone(), mesh.triangles.clone(), TriMeshFlags::ORIENTED)
            .map_err(|e| ExactMeshError::Rejected(e.to_string()))?;
        Ok(Self { shape })
    }

    /// The nearest point of the surface to `p`.
    pub fn nearest(&self, p: DVec3) -> Nearest {
        let projection = self.shape.project_local_point(p, false);
        let distance = (p - projection.point).length();
        Nearest {
            point: projection.point,
            signed_distance: if projection.is_inside { -distance } else { distance },
            triangle: projection.subshape,
        }
    }

    /// Distance from `p` to the surface, negative inside.
    pub fn signed_distance(&self, p: DVec3) -> f64 {
        self.nearest(p).signed_distance
    }

    /// The triangles of which some point may lie within `reach` of `p` (those whose boxes do), in rising order.
    pub fn triangles_within(&self, p: DVec3, reach: f64) -> Vec<u32> {
        let near = |node: &BvhNode| node.aabb().distance_to_local_point(p, true) <= reach;
        let mut found: Vec<u32> = self.shape.bvh().leaves(near).collect();
        found.sort_unstable();
        found
    }

    /// Distance along the unit vector `direction` from `origin` to the first crossing of the surface from
    /// either side, if there is one within `reach`.
    pub fn first_crossing(&self, origin: DVec3, direction: DVec3, reach: f64) -> Option<f64> {
        self.shape.cast_local_ray(&Ray::new(origin, direction), reach, false)
    }

    /// The triangles whose boxes the ray from `origin` along `direction` meets.
    pub fn triangles_along(&self, origin: DVec3, direction: DVec3) -> impl Iterator<Item = [DVec3; 3]> {
        let ray = Ray::new(origin, direction);
        // A hair more than the box, which rounding must not make too small.
        let meets = move |node: &BvhNode| node.aabb().loosened(1e-9).intersects_local_ray(&ray, f64::MAX);
        let triangle = |i: u32| self.shape.triangle(i);
        self.shape.bvh().leaves(meets).map(triangle).map(|t| [t.a, t.b, t.c])
    }

    /// The least distance between this mesh and `other` moved by the rigid motion `placement`; 0 when they
    /// touch or cross. This is the library's own query, slow where the surfaces run close to each other.
    pub fn distance_to(&self, other: &ExactMesh, placement: &DAffine3) -> f64 {
        let pose = Pose::from_parts(placement.translation, DQuat::from_mat3(&placement.matrix3));
        query::distance(&Pose::IDENTITY, &self.shape, &pose, &other.shape).map_or(f64::NAN, |d| d.distance)
    }

    /// The point of this mesh that is nearest to `other` moved by `shift`; none if they touch or cross, or are further
    /// apart than `within`.
    pub fn nearest_to(&self, other: &ExactMesh, shift: DVec3, within: f64) -> Option<DVec3> {
        let pose = Pose::from_translation(shift);
        match query::closest_points(&Pose::IDENTITY, &self.shape, &pose, &other.shape, within) {
            Ok(ClosestPoints::WithinMargin(own, _)) => Some(own),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
