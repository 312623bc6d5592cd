use glam::{DVec2, DVec3, EulerRot};
use proptest::prelude::*;

use super::*;

const SIZE: [u32; 2] = [640, 360];

fn cameras() -> impl Strategy<Value = Camera> {
    let angle = || -3.0..3.0;
    (angle(), angle(), angle(), 0.1..500.0, -50.0..50.0, any::<bool>(), 0.2..1.8).prop_map(
        |(yaw, pitch, roll, distance, off, flat, field_of_view)| Camera {
            target: DVec3::new(off, -0.3 * off, 1e4 + off),
            distance,
            orientation: DQuat::from_euler(EulerRot::ZYX, yaw, pitch, roll),
            projection: if flat { Projection::Orthographic } else { Projection::Perspective },
            field_of_view,
        },
    )
}

fn pixels() -> impl Strategy<Value = DVec2> {
    (0.0..640.0, 0.0..360.0).prop_map(|(x, y)| DVec2::new(x, y))
}

proptest! {
    #[test]
    fn points_of_a_ray_are_seen_at_its_pixel(camera in cameras(), pixel in pixels(), far in 0.01..3.0) {
        let ray = camera.ray(pixel, SIZE);
        let seen = camera.project(ray.origin + ray.direction * camera.distance * far, SIZE).unwrap();
        prop_assert!((seen.pixel - pixel).length() < 1e-5, "{seen:?}");
        prop_assert!(seen.depth > 0.0);
    }

    #[test]
    fn the_matrix_and_the_projection_agree(camera in cameras(), pixel in pixels(), far in 0.5..2.0) {
        let ray = camera.ray(pixel, SIZE);
        let view = camera.to_view(ray.origin + ray.direction * camera.distance * far);
        let range = [0.1 * camera.distance, 4.0 * camera.distance];
        let clip = camera.projection_matrix(640.0 / 360.0, range) * view.extend(1.0);
        let ndc = clip.truncate() / clip.w;
        let there = DVec2::new((ndc.x + 1.0) * 320.0, (1.0 - ndc.y) * 180.0);
        prop_assert!((there - pixel).length() < 1e-5);
        prop_assert!(ndc.z > 0.0 && ndc.z < 1.0);
    }

    #[test]
    fn zooming_keeps_what_is_under_the_cursor(camera in cameras(), pixel in pixels(), factor in 0.2..5.0) {
        let ray = camera.ray(pixel, SIZE);
        let depth = camera.distance / ray.direction.dot(-camera.backward());
        let point = ray.origin + ray.direction * depth;
        let mut closer = camera;
        closer.zoom(factor, pixel, SIZE);
        prop_assert!((closer.project(point, SIZE).unwrap().pixel - pixel).length() < 1e-5);
        prop_assert!((closer.visible_height() * factor / camera.visible_height() - 1.0).abs() < 1e-9);
    }

    #[test]
    fn panning_moves_the_target_by_the_drag(camera in cameras(), x in -90.0..90.0, y in -90.0..90.0) {
        let mut moved = camera;
        moved.pan(DVec2::new(x, y), SIZE);
        let seen = moved.project(camera.target, SIZE).unwrap().pixel;
        prop_assert!((seen - DVec2::new(320.0 + x, 180.0 + y)).length() < 1e-5);
    }

    #[test]
    fn fitting_shows_all_corners_and_fills_the_picture(
        camera in cameras(), a in 0.1..200.0, b in 0.1..200.0, c in 0.1..200.0
    ) {
        let size = DVec3::new(a, b, c);
        let bounds = Bounds { min: DVec3::new(7.0, -9.0, 3e3), max: DVec3::new(7.0, -9.0, 3e3) + size };
        let mut fitted = camera;
        fitted.fit(&bounds, 640.0 / 360.0);
        let seen = bounds.corners().map(|p| fitted.project(p, SIZE).unwrap().pixel);
        let off = seen.map(|p| ((p.x - 320.0).abs() / 320.0).max((p.y - 180.0).abs() / 180.0));
        let furthest = off.into_iter().fold(0.0, f64::max);
        prop_assert!(furthest <= 1.0 && furthest > 0.9, "{furthest}");
        let [near, far] = fitted.depth_range(&bounds);
        for p in bounds.corners() {
            let depth = fitted.project(p, SIZE).unwrap().depth;
            prop_assert!(near < depth && depth < far);
        }
    }

    #[test]
    fn orbiting_keeps_the_pivot_and_the_turntable_keeps_upright(
        yaw in -3.0..3.0, pitch in -1.5..1.5, x in -400.0..400.0, y in -900.0..900.0, flat in any::<bool>()
    ) {
        let mut camera = Camera::default();
        let direction = DVec3::new(f64::cos(yaw) * f64::cos(pitch), f64::sin(yaw) * f64::cos(pitch), f64::sin(pitch));
        camera.orientation = crate::view::looking(direction, DVec3::Z);
        let pivot = DVec3::new(3.0, -2.0, 1.0);
        let style = if flat { OrbitStyle::Turntable } else { OrbitStyle::Free };
        let before = camera.project(pivot, SIZE).unwrap();
        camera.orbit(DVec2::new(x, y), 360, style, pivot);
        let after = camera.project(pivot, SIZE).unwrap();
        prop_assert!((before.pixel - after.pixel).length() < 1e-6 && (before.depth - after.depth).abs() < 1e-6);
        prop_assert!(camera.is_valid());
        if flat {
            prop_assert!(camera.right().z.abs() < 1e-9 && camera.up().z > -1e-9);
        }
    }

    #[test]
    fn a_view_on_its_way_starts_and_ends_where_it_should(a in cameras(), b in cameras(), t in 0.0..1.0) {
        let same = |x: &Camera, y: &Camera| {
            x.target.distance(y.target) < 1e-6
                && (x.distance / y.distance - 1.0).abs() < 1e-9
                && x.orientation.dot(y.orientation).abs() > 1.0 - 1e-9
        };
        prop_assert!(same(&a.towards(&b, 0.0), &a) && same(&a.towards(&b, 1.0), &b));
        let between = a.towards(&b, t);
        prop_assert!(between.is_valid());
        prop_assert!(between.distance >= a.distance.min(b.distance) * (1.0 - 1e-9));
        prop_assert!(between.distance <= a.distance.max(b.distance) * (1.0 + 1e-9));
    }
}

#[test]
fn dragging_right_turns_the_front_to_the_right() {
    let mut camera = Camera { orientation: crate::view::StandardView::Front.orientation(), ..Camera::default() };
    let front = DVec3::NEG_Y;
    camera.orbit(DVec2::new(20.0, 0.0), 360, OrbitStyle::Turntable, camera.target);
    assert!(camera.project(front, SIZE).unwrap().pixel.x > 320.0);
    // Dragging down tips the front down: it is seen from above.
    camera.orbit(DVec2::new(0.0, 20.0), 360, OrbitStyle::Turntable, camera.target);
    assert!(camera.backward().z > 0.0 && camera.project(front, SIZE).unwrap().pixel.y > 180.0);
}

#[test]
fn nothing_to_fit_changes_nothing() {
    let mut camera = Camera::default();
    camera.fit(&Bounds::EMPTY, 1.5);
    assert_eq!(camera, Camera::default());
    assert!(camera.depth_range(&Bounds::EMPTY).iter().all(|d| d.is_finite()));
}

#[test]
fn changing_the_projection_keeps_sizes_at_the_target() {
    let mut camera = Camera::default();
    let beside = camera.target + camera.right() * 7.0;
    let perspective = camera.project(beside, SIZE).unwrap().pixel;
    camera.projection = Projection::Orthographic;
    assert!((camera.project(beside, SIZE).unwrap().pixel - perspective).length() < 1e-9);
}
