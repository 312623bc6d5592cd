use std::sync::Arc;

use glam::{DAffine3, DQuat};
use proptest::prelude::*;

use super::*;
use crate::colour::{Colour, Theme};
use crate::mesh::RenderMesh;
use crate::mesh::tests::sphere;
use crate::view::looking;
use geometry::mesh::{Mesh, normal_times_two_areas};

const SIZE: [u32; 2] = [320, 200];
const GREY: Colour = Colour::rgb(128, 128, 128);

fn object(id: u32, mesh: &Mesh) -> Object {
    Object::new(ObjectId(id), Arc::new(RenderMesh::new(mesh)), GREY)
}

fn scene(objects: Vec<Object>) -> Scene {
    Scene { objects, ..Scene::new(Theme::DARK) }
}

fn fitted(scene: &Scene, towards_viewer: DVec3) -> Camera {
    let up = if towards_viewer.z.abs() > 0.9 { DVec3::Y } else { DVec3::Z };
    let mut camera = Camera { orientation: looking(towards_viewer, up), ..Camera::default() };
    camera.fit(&scene.bounds(), 1.6);
    camera
}

/// The least distance along the ray to any triangle, with a plain test of each.
fn brute_force(mesh: &Mesh, transform: &DAffine3, ray: &ViewRay) -> Option<f64> {
    let hits = mesh.iter_corners().filter_map(|t| {
        let [a, b, c] = t.map(|p| transform.transform_point3(p));
        let n = normal_times_two_areas([a, b, c]);
        let distance = n.dot(a - ray.origin) / n.dot(ray.direction);
        let p = ray.origin + ray.direction * distance;
        let inside = [(a, b), (b, c), (c, a)].iter().all(|(u, v)| (v - u).cross(p - u).dot(n) >= 0.0);
        (inside && distance > 0.0).then_some(distance)
    });
    hits.min_by(f64::total_cmp)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn a_pick_is_the_nearest_triangle(
        x in 0.0..320.0, y in 0.0..200.0, turn in -3.0..3.0, flat in any::<bool>(), stretch in 0.4..2.0
    ) {
        let ball = sphere(4.0, 12, DVec3::new(1e5, 0.0, 0.0));
        let transform = DAffine3::from_scale_rotation_translation(
            DVec3::new(1.0, stretch, -1.0), DQuat::from_rotation_z(turn), DVec3::new(5.0, 6.0, 7.0));
        let scene = scene(vec![object(9, &ball).at(transform)]);
        let mut camera = fitted(&scene, DVec3::new(turn, 1.0, 0.7));
        camera.projection = if flat { Projection::Orthographic } else { Projection::Perspective };
        let pixel = DVec2::new(x, y);
        let ray = camera.ray(pixel, SIZE);
        let expected = brute_force(&ball, &transform, &ray);
        match (pick(&scene, &camera, pixel, SIZE), expected) {
            (Some(found), Some(distance)) => {
                prop_assert!((found.point.distance(ray.origin) - distance).abs() < 1e-6);
                prop_assert_eq!(found.object, ObjectId(9));
                prop_assert!(found.normal.dot(ray.direction) <= 0.0);
                let corners = ball.corners(found.triangle.unwrap() as usize).map(|p| transform.transform_point3(p));
                let off = found.normal.dot(found.point - corners[0]);
                prop_assert!(off.abs() < 1e-6, "the point lies off its triangle by {off}");
            }
            (found, expected) => prop_assert!(found.is_none() && expected.is_none(), "{found:?} {expected:?}"),
        }
    }
}

#[test]
fn what_the_section_takes_away_is_not_met_and_its_cut_face_is() {
    let mut scene = scene(vec![object(1, &Mesh::cuboid(DVec3::splat(10.0)))]);
    let camera = fitted(&scene, DVec3::Z);
    let middle = DVec2::new(160.0, 100.0);
    let plane = |normal| Some(SectionPlane { point: DVec3::splat(4.0), normal });
    assert_eq!(pick(&scene, &camera, middle, SIZE).unwrap().point.z, 10.0);
    scene.section = plane(DVec3::Z);
    let cap = pick(&scene, &camera, middle, SIZE).unwrap();
    assert!((cap.point.z - 4.0).abs() < 1e-9 && cap.triangle.is_none() && cap.normal == DVec3::Z);
    // The lower part taken away: the top is still there, and from below the cut face.
    scene.section = plane(DVec3::NEG_Z);
    assert_eq!(pick(&scene, &camera, middle, SIZE).unwrap().point.z, 10.0);
    let below = fitted(&scene, DVec3::NEG_Z);
    assert!((pick(&scene, &below, middle, SIZE).unwrap().point.z - 4.0).abs() < 1e-9);
    // Across the view: to the right of the cut there is nothing.
    scene.section = plane(DVec3::X);
    assert!(pick(&scene, &camera, DVec2::new(175.0, 100.0), SIZE).is_none());
    assert!(pick(&scene, &camera, DVec2::new(120.0, 100.0), SIZE).is_some());
}

#[test]
fn an_open_surface_has_no_cut_face() {
    let mut open = Mesh::cuboid(DVec3::splat(10.0));
    open.triangles.pop();
    let mut scene = scene(vec![object(1, &open)]);
    scene.section = Some(SectionPlane { point: DVec3::splat(4.0), normal: DVec3::Z });
    let found = pick(&scene, &fitted(&scene, DVec3::Z), DVec2::new(160.0, 100.0), SIZE).unwrap();
    assert!(found.triangle.is_some() && found.point.z == 0.0);
}

#[test]
fn a_faint_object_is_looked_through_and_a_hidden_one_is_not_there() {
    let inner = object(2, &Mesh::cuboid(DVec3::splat(2.0))).at(DAffine3::from_translation(DVec3::splat(4.0)));
    let mut scene = scene(vec![object(1, &Mesh::cuboid(DVec3::splat(10.0))).with_opacity(0.3), inner]);
    let camera = fitted(&scene, DVec3::Z);
    let (middle, side) = (DVec2::new(160.0, 100.0), DVec2::new(100.0, 100.0));
    assert_eq!(pick(&scene, &camera, middle, SIZE).unwrap().object, ObjectId(2));
    assert_eq!(pick(&scene, &camera, side, SIZE).unwrap().object, ObjectId(1));
    scene.objects[0].opacity = 0.0;
    assert!(pick(&scene, &camera, side, SIZE).is_none());
    scene.objects[0].opacity = 0.8;
    assert_eq!(pick(&scene, &camera, middle, SIZE).unwrap().object, ObjectId(1));
    assert!(pick(&Scene::default(), &camera, middle, SIZE).is_none());
    assert!(pick(&scene, &camera, DVec2::NAN, SIZE).is_none());
}
