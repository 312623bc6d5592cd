//! Intersections of rays with a mesh, through parry3d-f64's bounding volume hierarchy.

use glam::DVec3;
use parry3d_f64::query::{Ray, RayCast};
use parry3d_f64::shape::TriMesh;

use super::exact::ExactMeshError;
use super::mesh::{Mesh, unit_normal};

/// A mesh made ready for rays. Unlike [`ExactMesh`](super::exact::ExactMesh) it need be neither closed nor
/// oriented, and is made in a fraction of the time.
pub struct RayMesh {
    shape: TriMesh,
}

/// Intersection of a ray with a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayHit {
    /// Distance from the ray's origin, in lengths of its direction.
    pub distance: f64,
    /// The triangle.
    pub triangle: u32,
    /// Unit normal, by the order of its vertices.
    pub normal: DVec3,
}

impl RayMesh {
    /// Prepares `mesh`, all of whose vertices must be finite.
    pub fn new(mesh: &Mesh) -> Result<Self, ExactMeshError> {
        if mesh.triangles.is_empty() {
            return Err(ExactMeshError::Empty);
        }
        let shape = TriMesh::new(mesh.vertices.clone(), mesh.triangles.clone())
            .map_err(|e| ExactMeshError::Rejected(e.to_string()))?;
        Ok(Self { shape })
    }

    /// The first triangle that the ray from `origin` along `direction` meets, from either side, within `reach`.
    pub fn first_hit(&self, origin: DVec3, direction: DVec3, reach: f64) -> Option<RayHit> {
        let hit = self.shape.cast_local_ray_and_get_normal(&Ray::new(origin, direction), reach, false)?;
        let triangle = hit.subshape;
        let corners = self.shape.triangle(triangle);
        Some(RayHit { distance: hit.time_of_impact, triangle, normal: unit_normal([corners.a, corners.b, corners.c]) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_through_a_box_meets_the_near_face_and_from_inside_the_far_one() {
        let mesh = Mesh::cuboid(DVec3::splat(2.0));
        let rays = RayMesh::new(&mesh).unwrap();
        let outside = rays.first_hit(DVec3::new(0.4, 0.7, 5.0), DVec3::NEG_Z, 1e3).unwrap();
        assert_eq!((outside.distance, outside.normal), (3.0, DVec3::Z));
        let inside = rays.first_hit(DVec3::new(0.4, 0.7, 1.5), DVec3::NEG_Z * 0.5, 1e3).unwrap();
        assert_eq!((inside.distance, inside.normal), (3.0, DVec3::NEG_Z));
        assert!(mesh.corners(inside.triangle as usize).iter().all(|p| p.z == 0.0));
        assert_eq!(rays.first_hit(DVec3::new(0.4, 0.7, 5.0), DVec3::NEG_Z, 2.9), None);
        assert!(matches!(RayMesh::new(&Mesh::default()), Err(ExactMeshError::Empty)));
    }
}
