//! Picking: the object under a pixel, found on the CPU, exact, and without waiting for the GPU.

use glam::{DVec2, DVec3};

use super::camera::{Camera, Projection, ViewRay};
use super::scene::{Object, ObjectId, Scene, SectionPlane};
use geometry::raycast::RayHit;

/// Objects of less opacity are looked through.
const FIRM: f32 = 0.5;

/// Object that was hit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pick {
    /// The object.
    pub object: ObjectId,
    /// The triangle of the object's mesh; `None` on the cut face of a section.
    pub triangle: Option<u32>,
    /// The point hit, in the scene's frame.
    pub point: DVec3,
    /// The unit normal there, towards the viewer.
    pub normal: DVec3,
}

/// The part of a ray that can be seen.
#[derive(Debug, Clone, Copy)]
struct Sight {
    ray: ViewRay,
    /// Distances along the ray between which things stand.
    from: f64,
    to: f64,
    /// Whether it begins in the section plane.
    from_plane: bool,
}

/// The first thing that the ray through `pixel` meets in a picture of `size` pixels. What a section takes away
/// is not met, its cut faces are. An object with an opacity under one half is looked through: it is the answer
/// only if there is nothing firmer behind it.
pub fn pick(scene: &Scene, camera: &Camera, pixel: DVec2, size: [u32; 2]) -> Option<Pick> {
    if !camera.is_valid() || !pixel.is_finite() {
        return None;
    }
    let sight = sight(scene, camera, camera.ray(pixel, size))?;
    let nearest = |firm: bool| {
        let candidates = scene.objects.iter().filter(|o| o.is_visible() && (o.opacity >= FIRM) == firm);
        let hits = candidates.filter_map(|o| hit(o, &sight, scene.section.as_ref()));
        hits.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, pick)| pick)
    };
    nearest(true).or_else(|| nearest(false))
}

/// Part of the ray that the section leaves; `None` if nothing.
fn sight(scene: &Scene, camera: &Camera, ray: ViewRay) -> Option<Sight> {
    // An orthographic view also shows what lies behind the plane its rays start from.
    let behind = match camera.projection {
        Projection::Perspective => 0.0,
        Projection::Orthographic => (camera.depth_extent(&scene.bounds())[0] - camera.distance).min(0.0),
    };
    let whole = Sight { ray, from: behind, to: f64::INFINITY, from_plane: false };
    let Some((plane, normal)) = scene.section.as_ref().and_then(|s| Some((s, s.unit_normal()?))) else {
        return Some(whole);
    };
    let start = ray.origin + ray.direction * whole.from;
    let (height, rise) = (normal.dot(start - plane.point), normal.dot(ray.direction));
    let crossing = whole.from - height / rise;
    match (height > 0.0, rise < 0.0) {
        (true, true) => Some(Sight { from: crossing, from_plane: true, ..whole }),
        (true, false) => None,
        (false, true) => Some(whole),
        (false, false) => Some(Sight { to: if rise > 0.0 { crossing } else { f64::INFINITY }, ..whole }),
    }
}

/// Where the object is met, and how far along the ray.
fn hit(object: &Object, sight: &Sight, section: Option<&SectionPlane>) -> Option<(f64, Pick)> {
    let rays = object.mesh.rays()?;
    if object.transform.matrix3.determinant() == 0.0 {
        return None;
    }
    let to_mesh = object.transform.inverse();
    let start = sight.ray.origin + sight.ray.direction * sight.from;
    let (origin, direction) = (to_mesh.transform_point3(start), to_mesh.transform_vector3(sight.ray.direction));
    // In a scaled mesh the ray is scaled with it: distances are in its lengths.
    let found = rays.first_hit(object.mesh.source(), origin, direction, reach(sight))?;
    let enters_material = found.normal.dot(direction) > 0.0;
    if sight.from_plane && object.mesh.is_closed() && enters_material {
        let normal = section.and_then(SectionPlane::unit_normal)?;
        return Some((sight.from, Pick { object: object.id, triangle: None, point: start, normal }));
    }
    Some((sight.from + found.distance, surface_pick(object, sight, start, &found)))
}

fn reach(sight: &Sight) -> f64 {
    let reach = sight.to - sight.from;
    if reach.is_finite() { reach } else { f64::MAX }
}

fn surface_pick(object: &Object, sight: &Sight, start: DVec3, found: &RayHit) -> Pick {
    let direction = sight.ray.direction;
    let normal = (object.transform.matrix3.inverse().transpose() * found.normal).normalize_or(-direction);
    Pick {
        object: object.id,
        triangle: Some(found.triangle),
        point: start + direction * found.distance,
        normal: if normal.dot(direction) > 0.0 { -normal } else { normal },
    }
}

#[cfg(test)]
mod tests;
