//! Intersections of rays with a mesh, through parry3d-f64's bounding volume hierarchy.

use glam::DVec3;
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy};
use parry3d_f64::query::{Ray, RayCast};
use parry3d_f64::shape::Triangle;
use rayon::prelude::*;

use super::exact::ExactMeshError;
use super::mesh::{Bounds, Mesh, unit_normal};

/// Triangles in a block. A hierarchy over single triangles would take some 130 bytes for each, more than the mesh itself.
const BLOCK: usize = 16;
/// Steps of the grid along each side of the box by which triangles are put in order.
const STEPS: f64 = 2_097_151.0;

/// Triangles of a mesh made ready for rays and boxes, in some 16 bytes each. Unlike [`ExactMesh`](super::exact::ExactMesh) the mesh
/// need be neither closed nor oriented, and is made ready in a fraction of the time.
pub struct RayMesh {
    /// Triangles, neighbours next to one another.
    order: Vec<u32>,
    /// Boxes of [`BLOCK`] of them each.
    blocks: Bvh,
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
        let order = along_a_curve(mesh);
        let boxes: Vec<Aabb> = order.par_chunks(BLOCK).map(|block| box_of(mesh, block)).collect();
        Ok(Self { order, blocks: Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes) })
    }

    /// The first triangle of `mesh`, the one that this was made of, that the ray from `origin` along `direction` meets, from
    /// either side, within `reach`.
    pub fn first_hit(&self, mesh: &Mesh, origin: DVec3, direction: DVec3, reach: f64) -> Option<RayHit> {
        let ray = Ray::new(origin, direction);
        let met = |&triangle: &u32, within: f64| {
            let [a, b, c] = mesh.corners(triangle as usize);
            Some((Triangle::new(a, b, c).cast_local_ray(&ray, within, false)?, triangle))
        };
        let first = |block: u32, within: f64| {
            let hits = self.block(block).iter().filter_map(|triangle| met(triangle, within));
            hits.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
        };
        let (block, distance) = self.blocks.cast_ray(&ray, reach, |block, best| Some(first(block, best)?.0))?;
        let (_, triangle) = first(block, distance)?;
        Some(RayHit { distance, triangle, normal: unit_normal(mesh.corners(triangle as usize)) })
    }

    /// The triangles of `mesh`, the one that this was made of, whose boxes meet something, as larger boxes around them do.
    pub fn meeting(&self, mesh: &Mesh, meets: impl Fn(&Bounds) -> bool + Copy) -> impl Iterator<Item = u32> {
        let blocks = self.blocks.leaves(move |node| meets(&Bounds { min: node.mins(), max: node.maxs() }));
        let triangles = blocks.flat_map(|block| self.block(block).iter().copied());
        triangles.filter(move |triangle| meets(&Bounds::of(mesh.corners(*triangle as usize))))
    }

    /// The corners of the triangles of `mesh`, the one that this was made of, whose boxes the ray from `origin` along
    /// `direction` meets.
    pub fn triangles_along(&self, mesh: &Mesh, origin: DVec3, direction: DVec3) -> impl Iterator<Item = [DVec3; 3]> {
        self.meeting(mesh, is_met_by_ray(origin, direction)).map(|triangle| mesh.corners(triangle as usize))
    }

    fn block(&self, block: u32) -> &[u32] {
        let start = block as usize * BLOCK;
        &self.order[start..(start + BLOCK).min(self.order.len())]
    }
}

/// Whether the ray from `origin` along `direction` meets a box, or comes as near to it as rounding may make that of what
/// it meets.
pub(super) fn is_met_by_ray(origin: DVec3, direction: DVec3) -> impl Fn(&Bounds) -> bool + Copy {
    const HAIR: f64 = 1e-9;
    // Finite, so that an end of a box is never at 0 times infinity.
    let per_mm = direction.recip().clamp(DVec3::splat(-f64::MAX), DVec3::splat(f64::MAX));
    move |bounds| {
        let [from, to] = [bounds.min - HAIR, bounds.max + HAIR].map(|end| (end - origin) * per_mm);
        let (enters, leaves) = (from.min(to).max_element(), from.max(to).min_element());
        enters.max(0.0) <= leaves
    }
}

/// The triangles of a mesh along a curve on which neighbours in space are near one another (G. M. Morton, 1966).
fn along_a_curve(mesh: &Mesh) -> Vec<u32> {
    let bounds = mesh.bounds();
    let scale = STEPS / bounds.size().max_element().max(f64::MIN_POSITIVE);
    let key = |i: u32| {
        let middle = mesh.corners(i as usize).iter().sum::<DVec3>() / 3.0;
        let [x, y, z] = ((middle - bounds.min) * scale).to_array().map(|c| spread(c as u64));
        (x | y << 1 | z << 2, i)
    };
    let mut keys: Vec<(u64, u32)> = (0..mesh.triangles.len() as u32).into_par_iter().map(key).collect();
    keys.par_sort_unstable();
    keys.into_par_iter().map(|(_, i)| i).collect()
}

/// The lowest 21 bits of `x`, two zeros between each and the next.
fn spread(x: u64) -> u64 {
    let parts = [(32, 0x1f_0000_0000_ffff), (16, 0x1f_0000_ff00_00ff), (8, 0x100f_00f0_0f00_f00f)];
    let parts = parts.into_iter().chain([(4, 0x10c3_0c30_c30c_30c3), (2, 0x1249_2492_4924_9249)]);
    parts.fold(x & 0x1f_ffff, |x, (shift, mask)| (x | x << shift) & mask)
}

fn box_of(mesh: &Mesh, triangles: &[u32]) -> Aabb {
    let bounds = Bounds::of(triangles.iter().flat_map(|t| mesh.corners(*t as usize)));
    Aabb::new(bounds.min, bounds.max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_through_a_box_meets_the_near_face_and_from_inside_the_far_one() {
        let mesh = Mesh::cuboid(DVec3::splat(2.0));
        let rays = RayMesh::new(&mesh).unwrap();
        let outside = rays.first_hit(&mesh, DVec3::new(0.4, 0.7, 5.0), DVec3::NEG_Z, 1e3).unwrap();
        assert_eq!((outside.distance, outside.normal), (3.0, DVec3::Z));
        let inside = rays.first_hit(&mesh, DVec3::new(0.4, 0.7, 1.5), DVec3::NEG_Z * 0.5, 1e3).unwrap();
        assert_eq!((inside.distance, inside.normal), (3.0, DVec3::NEG_Z));
        assert!(mesh.corners(inside.triangle as usize).iter().all(|p| p.z == 0.0));
        assert_eq!(rays.first_hit(&mesh, DVec3::new(0.4, 0.7, 5.0), DVec3::NEG_Z, 2.9), None);
        assert!(matches!(RayMesh::new(&Mesh::default()), Err(ExactMeshError::Empty)));
    }

    #[test]
    fn rays_and_boxes_meet_the_triangles_that_a_look_at_each_finds() {
        use rand::{RngExt as _, SeedableRng as _};
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        let mut point = |far: f64| DVec3::from_array([(); 3].map(|()| random.random_range(-far..far)));
        let mut mesh = Mesh::default();
        for i in 0..500 {
            let (middle, first) = (point(1e3), 3 * i);
            mesh.vertices.extend([middle + point(400.0), middle + point(400.0), middle + point(400.0)]);
            mesh.triangles.push([first, first + 1, first + 2]);
        }
        let rays = RayMesh::new(&mesh).unwrap();
        let mut met = 0;
        for _ in 0..300 {
            let origin = point(2e3);
            let direction = (point(800.0) - origin).normalize();
            let each = mesh.triangles.iter().enumerate().filter_map(|(t, &corners)| {
                let vertices = corners.map(|v| mesh.vertices[v as usize]).to_vec();
                let single = Mesh { vertices, triangles: vec![[0, 1, 2]] };
                let hit = RayMesh::new(&single).unwrap().first_hit(&single, origin, direction, 1e4)?;
                Some((t as u32, hit.distance))
            });
            let nearest = each.min_by(|a, b| a.1.total_cmp(&b.1));
            let found = rays.first_hit(&mesh, origin, direction, 1e4).map(|hit| (hit.triangle, hit.distance));
            assert_eq!(found, nearest);
            met += usize::from(found.is_some());
        }
        assert!(met > 100, "{met}");
        for _ in 0..50 {
            let bounds = Bounds::of([point(1e3)]).grown(100.0);
            let meets = |t: &usize| Bounds::of(mesh.corners(*t)).intersects(&bounds);
            let mut found: Vec<usize> = rays.meeting(&mesh, |b| b.intersects(&bounds)).map(|t| t as usize).collect();
            found.sort_unstable();
            assert_eq!(found, (0..500).filter(meets).collect::<Vec<_>>());
        }
    }
}
