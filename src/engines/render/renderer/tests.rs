use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec2, DVec3};
use image::RgbaImage;

use super::Quality;
use crate::camera::Camera;
use crate::colour::{Colour, Theme};
use crate::colour_map::ColourMap;
use crate::mesh::RenderMesh;
use crate::mesh::tests::sphere;
use crate::offscreen::{Offscreen, RenderError, png_bytes};
use crate::scene::{Grid, LineSet, Marker, Object, ObjectId, Scene, SectionPlane, SurfaceValues};
use crate::view::{StandardView, looking};
use geometry::mesh::Mesh;
use task::{Cancel, Cancelled};

#[path = "tests_moving.rs"]
mod moving;

const SIZE: [u32; 2] = [240, 160];
const MIDDLE: DVec2 = DVec2::new(120.0, 80.0);
const BLUE: Colour = Colour::rgb(40, 80, 220);
const RED: Colour = Colour::rgb(220, 40, 40);

fn offscreen() -> Offscreen {
    Offscreen::new().unwrap_or_else(|e| panic!("this test draws, and needs what scripts/test installs: {e}"))
}

fn object(id: u32, colour: Colour, size: f64) -> Object {
    let mesh = Mesh::cuboid(DVec3::splat(size)).mapped(|p| p - 0.5 * size);
    Object::new(ObjectId(id), Arc::new(RenderMesh::new(&mesh)), colour)
}

fn scene(objects: Vec<Object>) -> Scene {
    Scene { objects, ..Scene::default() }
}

fn front(scene: &Scene) -> Camera {
    let mut camera = Camera { orientation: StandardView::Front.orientation(), ..Camera::default() };
    camera.fit(&scene.bounds(), 1.5);
    camera
}

fn drawn(scene: &Scene, camera: &Camera) -> RgbaImage {
    offscreen().image(scene, camera, SIZE).unwrap()
}

/// Mean colour of the 3 by 3 pixels around a place.
fn around(image: &RgbaImage, at: DVec2) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (dx, dy) in (-1..=1).flat_map(|x| (-1..=1).map(move |y| (x, y))) {
        let pixel = image.get_pixel((at.x as i32 + dx) as u32, (at.y as i32 + dy) as u32);
        assert_eq!(pixel.0[3], 255);
        (0..3).for_each(|i| sum[i] += f64::from(pixel.0[i]) / 9.0);
    }
    sum
}

fn difference(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).abs()).fold(0.0, f64::max)
}

/// How many pixels differ clearly between two pictures of one size.
fn different(a: &RgbaImage, b: &RgbaImage) -> usize {
    let clearly = |(p, q): (&image::Rgba<u8>, &image::Rgba<u8>)| (0..3).any(|i| p.0[i].abs_diff(q.0[i]) > 8);
    a.pixels().zip(b.pixels()).filter(|&pair| clearly(pair)).count()
}

#[test]
fn an_empty_scene_is_the_background_from_top_to_bottom() {
    let image = drawn(&Scene::default(), &Camera::default());
    let theme = Theme::DARK;
    for (y, colour) in [(2.0, theme.background_top), (157.0, theme.background_bottom)] {
        let expected = [colour.r, colour.g, colour.b].map(f64::from);
        assert!(difference(around(&image, DVec2::new(50.0, y)), expected) < 2.0);
    }
}

#[test]
fn a_box_has_its_hue_in_the_middle_and_nothing_is_drawn_outside_it() {
    let scene = scene(vec![object(1, BLUE, 10.0)]);
    let camera = front(&scene);
    let image = drawn(&scene, &camera);
    let [r, g, b] = around(&image, MIDDLE);
    assert!(b > 100.0 && b > 1.8 * g && g > r, "{r} {g} {b}");
    let empty = drawn(&Scene::default(), &camera);
    let corner = camera.project(DVec3::new(5.0, -5.0, 5.0), SIZE).unwrap().pixel;
    let half = (corner - MIDDLE).abs();
    for (x, y, pixel) in image.enumerate_pixels() {
        let off = (DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5) - MIDDLE).abs() - half;
        // Its edges are as wide as a pixel or two.
        if off.max_element() > 2.0 {
            assert_eq!(pixel, empty.get_pixel(x, y));
        }
    }
    assert!(different(&image, &empty) as f64 > 0.95 * 4.0 * half.x * half.y);
}

/// A swept volume lies on the body that sweeps it with neither quite the same triangles nor quite the same places; the
/// bases of two electrodes lie on each other the same but for rounding.
#[test]
fn of_two_bodies_that_lie_on_each_other_one_is_seen_the_solid_one_or_the_later_one() {
    let solid = scene(vec![object(1, BLUE, 10.0)]);
    let fine = sphere(5.0, 12, DVec3::ZERO);
    let shaken = |by: f64| {
        let mut mesh = fine.clone();
        mesh.vertices.iter_mut().enumerate().for_each(|(i, p)| *p *= 1.0 + by * (1.7 * i as f64).sin());
        mesh
    };
    let body = |id, colour, mesh: &Mesh| {
        let object = Object::new(ObjectId(id), Arc::new(RenderMesh::new(mesh)), colour);
        Object { edges: false, ..object }
    };
    for camera in [front(&solid), Camera { distance: 40.0, ..Camera::default() }] {
        let alone = scene(vec![body(1, BLUE, &fine)]);
        let translucent = scene(vec![body(1, BLUE, &fine), body(2, RED, &shaken(1e-5)).with_opacity(0.5)]);
        let earlier = scene(vec![body(2, RED, &shaken(1e-7)), body(1, BLUE, &fine)]);
        let [alone, translucent, earlier] = [&alone, &translucent, &earlier].map(|scene| drawn(scene, &camera));
        for both in [translucent, earlier] {
            // At its outline a pixel may hold a little of either.
            assert!(different(&alone, &both) < 60, "{} pixels flicker", different(&alone, &both));
        }
    }
}

#[test]
fn the_same_scene_gives_the_same_bytes_also_from_another_device() {
    let mut scene = scene(vec![object(1, BLUE, 10.0), object(2, RED, 14.0).with_opacity(0.4)]);
    scene.section = Some(SectionPlane { point: DVec3::ZERO, normal: DVec3::X });
    scene.triad = true;
    let camera = Camera { distance: 60.0, ..Camera::default() };
    let mut first = offscreen();
    let images = [first.image(&scene, &camera, SIZE).unwrap(), first.image(&scene, &camera, SIZE).unwrap()];
    assert!(images[0] == images[1] && images[0] == drawn(&scene, &camera));
    assert_eq!(
        image::load_from_memory(&png_bytes(&images[0], &Cancel::default()).unwrap()).unwrap().into_rgba8(),
        images[0]
    );
    let cancel = Cancel::default();
    cancel.cancel();
    assert_eq!(png_bytes(&images[0], &cancel), Err(RenderError::Cancelled(Cancelled)));
    assert_eq!(first.png(&scene, &camera, SIZE, &cancel), Err(RenderError::Cancelled(Cancelled)));
}

#[test]
fn a_picture_in_parts_is_the_picture() {
    let mut scene = scene(vec![object(0, BLUE, 10.0), object(1, RED, 12.0), object(2, BLUE, 14.0)]);
    scene.objects[1].transform = DAffine3::from_translation(DVec3::splat(4.0));
    scene.objects[2].opacity = 0.4;
    scene.section = Some(SectionPlane { point: DVec3::ZERO, normal: DVec3::Z });
    let camera = front(&scene);
    let whole = drawn(&scene, &camera);
    // Boxes of 36 indices: parts that end within one, between two, and with the last.
    for at_a_time in [3, 30, 36, 72] {
        let mut device = offscreen();
        device.renderer.indices_at_a_time = at_a_time;
        assert!(device.image(&scene, &camera, SIZE).unwrap() == whole, "{at_a_time}");
    }
}

#[test]
fn far_from_the_origin_the_picture_is_the_same() {
    let near = scene(vec![object(1, BLUE, 10.0)]);
    let shift = DVec3::new(3e7, -5e7, 2e7);
    let far = scene(vec![object(1, BLUE, 10.0).at(DAffine3::from_translation(shift))]);
    let camera = Camera { distance: 50.0, ..Camera::default() };
    let there = Camera { target: shift, ..camera };
    assert_eq!(different(&drawn(&near, &camera), &drawn(&far, &there)), 0);
}

#[test]
fn a_section_shows_the_cut_face_in_the_objects_hue_and_the_background_through_what_is_gone() {
    let mut scene = scene(vec![object(1, BLUE, 10.0), object(2, RED, 4.0).at(DAffine3::from_translation(DVec3::ZERO))]);
    let camera = front(&scene);
    let whole = drawn(&scene, &camera);
    scene.section = Some(SectionPlane { point: DVec3::ZERO, normal: DVec3::NEG_Y });
    let cut = drawn(&scene, &camera);
    // In the middle the cut inner body, beside it the cut outer one.
    let [r, g, _] = around(&cut, MIDDLE);
    assert!(r > 90.0 && r > 2.0 * g);
    let beside = camera.project(DVec3::new(3.5, 0.0, 0.0), SIZE).unwrap().pixel;
    let [r, _, b] = around(&cut, beside);
    assert!(b > 80.0 && b > 1.5 * r);
    assert!(different(&whole, &cut) > 1000);
    // Cut upright, the half towards +X is gone.
    scene.section = Some(SectionPlane { point: DVec3::ZERO, normal: DVec3::X });
    let half = drawn(&scene, &camera);
    let empty = drawn(&Scene::default(), &camera);
    assert!(difference(around(&half, beside), around(&empty, beside)) < 2.0);
    let other = camera.project(DVec3::new(-3.5, 0.0, 0.0), SIZE).unwrap().pixel;
    assert!(difference(around(&half, other), around(&empty, other)) > 40.0);
}

#[test]
fn the_hatch_fills_a_ring_but_not_its_hole() {
    let hollow = |r| Arc::new(RenderMesh::new(&sphere(r, 40, DVec3::ZERO)));
    let mut inner = sphere(5.0, 40, DVec3::ZERO);
    inner.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    let mut shell = sphere(8.0, 40, DVec3::ZERO);
    let base = shell.vertices.len() as u32;
    shell.vertices.extend(&inner.vertices);
    shell.triangles.extend(inner.triangles.iter().map(|t| t.map(|v| v + base)));
    let shell = Object::new(ObjectId(1), Arc::new(RenderMesh::new(&shell)), BLUE);
    let full = Object { mesh: hollow(8.0), ..shell.clone() };
    let section = Some(SectionPlane { point: DVec3::ZERO, normal: DVec3::NEG_Y });
    let [ring, disc] = [shell, full].map(|o| Scene { section, ..scene(vec![o]) });
    let camera = front(&ring);
    let (ring, disc) = (drawn(&ring, &camera), drawn(&disc, &camera));
    let wall = camera.project(DVec3::new(6.5, 0.0, 0.0), SIZE).unwrap().pixel;
    assert!(difference(around(&ring, wall), around(&disc, wall)) < 2.0);
    // Through the hole one sees the far inside of the shell, in another light and without hatch.
    let (hole, face) = (around(&ring, MIDDLE), around(&disc, MIDDLE));
    assert!(difference(hole, face) > 15.0, "{hole:?} {face:?}");
}

#[test]
fn a_translucent_object_blends_with_what_is_behind_and_hides_its_own_inside() {
    let mut scene = scene(vec![object(1, BLUE, 4.0), object(2, RED, 10.0).with_opacity(0.4)]);
    let camera = front(&scene);
    let both = drawn(&scene, &camera);
    let beside = camera.project(DVec3::new(3.5, -5.0, 0.0), SIZE).unwrap().pixel;
    let [r, _, b] = around(&both, MIDDLE);
    assert!(r > 60.0 && b > 60.0, "{r} {b}");
    let [r, _, b] = around(&both, beside);
    assert!(r > 70.0 && b < 60.0, "{r} {b}");
    // One layer only: as much as a single face would cover, although the ray passes two.
    let background = around(&drawn(&Scene::default(), &camera), beside);
    scene.objects = vec![object(2, RED, 10.0)];
    let solid = around(&drawn(&scene, &camera), beside);
    let blended: [f64; 3] = std::array::from_fn(|i| background[i] + 0.4 * (solid[i] - background[i]));
    assert!(difference(around(&both, beside), blended) < 4.0, "{:?} {blended:?}", around(&both, beside));
}

#[test]
fn lines_and_markers_are_where_they_should_be_and_shine_through_only_if_asked() {
    let mut scene = scene(vec![object(1, BLUE, 10.0)]);
    let camera = front(&scene);
    let plain = drawn(&scene, &camera);
    let green = Colour::rgb(0, 255, 0);
    let line = |y: f64, z: f64| vec![DVec3::new(-9.0, y, z), DVec3::new(9.0, y, z)];
    let lines = |polylines, on_top| LineSet { width_px: 3.0, on_top, ..LineSet::new(polylines, green) };
    scene.lines = vec![lines(vec![line(-6.0, 2.0), line(6.0, 0.0)], false), lines(vec![line(6.0, -2.0)], true)];
    let image = drawn(&scene, &camera);
    let greener = |y: f64, z: f64| {
        let at = camera.project(DVec3::new(0.0, y, z), SIZE).unwrap().pixel;
        let (new, old) = (image.get_pixel(at.x as u32, at.y as u32), plain.get_pixel(at.x as u32, at.y as u32));
        i32::from(new.0[1]) - i32::from(old.0[1])
    };
    assert!(greener(-6.0, 2.0) > 120, "{}", greener(-6.0, 2.0));
    assert!(greener(6.0, 0.0) == 0, "{}", greener(6.0, 0.0));
    assert!((20..120).contains(&greener(6.0, -2.0)), "{}", greener(6.0, -2.0));
    scene.lines.clear();
    scene.markers = vec![Marker { at: DVec3::new(0.0, -5.0, 3.0), colour: green, radius_px: 6.0 }];
    let image = drawn(&scene, &camera);
    let at = camera.project(scene.markers[0].at, SIZE).unwrap().pixel;
    assert!(around(&image, at)[1] > 240.0, "{:?} {at}", around(&image, at));
    let count = image.pixels().filter(|p| p.0[1] > 240 && p.0[0] < 30).count() as f64;
    // A disc of 6 pixels less its rim.
    assert!((40.0..114.0).contains(&count), "{count}");
}

#[test]
fn values_show_their_colours_and_no_value_the_objects() {
    let plain = object(1, Colour::rgb(128, 128, 128), 10.0);
    let map = ColourMap::Diverging;
    let with = |value: f32| {
        let values = SurfaceValues { values: Arc::new(vec![value; 8]), map, range: [-1.0, 1.0] };
        let scene = scene(vec![Object { values: Some(values), ..plain.clone() }]);
        around(&drawn(&scene, &front(&scene)), MIDDLE)
    };
    let grey = with(f32::NAN);
    assert!((grey[0] - grey[2]).abs() < 12.0);
    let (low, high) = (with(-5.0), with(0.9));
    assert!(low[2] > 1.5 * low[0] && high[0] > 1.5 * high[2], "{low:?} {high:?}");
}

#[test]
fn selection_turns_towards_the_accent() {
    let mut scene = scene(vec![object(1, BLUE, 10.0)]);
    let camera = front(&scene);
    let before = around(&drawn(&scene, &camera), MIDDLE);
    scene.objects[0].selected = true;
    let after = around(&drawn(&scene, &camera), MIDDLE);
    assert!(after[0] > before[0] + 40.0 && after[2] < before[2] - 20.0, "{before:?} {after:?}");
}

#[test]
fn grid_and_axes_are_drawn_in_their_places() {
    let mut scene = scene(vec![object(1, BLUE, 10.0)]);
    let camera = Camera { distance: 60.0, ..Camera::default() };
    let plain = drawn(&scene, &camera);
    scene.triad = true;
    let triad = drawn(&scene, &camera);
    for (a, b) in plain.enumerate_pixels().zip(triad.pixels()) {
        assert!(a.2 == b || (a.0 < 105 && a.1 > 55), "{} {}", a.0, a.1);
    }
    assert!(different(&plain, &triad) > 300);
    scene.triad = false;
    scene.grid = Grid::below(&scene.bounds());
    assert!(different(&plain, &drawn(&scene, &camera)) > 500);
}

#[test]
fn a_moving_picture_is_the_same_view() {
    let mut offscreen = offscreen();
    let mut scene = scene(vec![object(1, BLUE, 10.0)]);
    scene.objects[0].edges = false;
    let camera = Camera { distance: 60.0, ..Camera::default() };
    let size = [1200, 800];
    let full = offscreen.image(&scene, &camera, size).unwrap();
    offscreen.draw(&scene, &camera, size, Quality::Moving).unwrap();
    let moving = offscreen.read_back().unwrap();
    let scale = f64::from(moving.width()) / 1200.0;
    assert!((f64::from(moving.height()) / 800.0 - scale).abs() < 0.005);
    for at in [DVec2::new(600.0, 310.0), DVec2::new(520.0, 450.0), DVec2::new(680.0, 450.0), DVec2::new(20.0, 20.0)] {
        assert!(difference(around(&full, at), around(&moving, at * scale)) < 6.0, "{at}");
    }
}

#[test]
fn sizes_that_cannot_be_drawn_are_errors_and_bad_numbers_draw_nothing() {
    let mut offscreen = offscreen();
    let mut scene = scene(vec![object(1, BLUE, 10.0)]);
    let camera = front(&scene);
    for size in [[0, 10], [10, 0], [u32::MAX, 10]] {
        assert!(matches!(offscreen.image(&scene, &camera, size), Err(RenderError::Size { .. })));
    }
    assert!(offscreen.draw(&scene, &camera, [0, 0], Quality::Full).is_ok());
    let background = offscreen.image(&Scene::default(), &camera, SIZE).unwrap();
    let mut odd = scene.clone();
    odd.objects[0].transform = DAffine3::from_translation(DVec3::NAN);
    odd.objects.push(object(2, RED, 3.0).at(DAffine3::from_scale(DVec3::new(1.0, 1.0, 0.0))));
    odd.markers.push(Marker { at: DVec3::NAN, colour: RED, radius_px: f32::NAN });
    odd.lines.push(LineSet::new(vec![vec![DVec3::NAN, DVec3::ZERO], vec![DVec3::ONE], vec![]], RED));
    odd.section = Some(SectionPlane { point: DVec3::ZERO, normal: DVec3::ZERO });
    odd.grid = Some(Grid { center: DVec3::NAN, spacing: 0.0, radius: -1.0 });
    assert!(offscreen.image(&odd, &camera, SIZE).unwrap() == background);
    let nowhere = Camera { distance: f64::NAN, ..camera };
    assert!(offscreen.image(&scene, &nowhere, SIZE).unwrap() == background);
    // A line through the eye, from before to behind it, is cut at the near plane.
    scene.lines.push(LineSet::new(vec![vec![camera.eye() - DVec3::Y * 9.0, DVec3::new(20.0, 0.0, 0.0)]], RED));
    assert!(offscreen.image(&scene, &camera, SIZE).is_ok());
    let edge_on = Camera { orientation: looking(DVec3::Z, DVec3::Z), ..camera };
    assert!(offscreen.image(&scene, &edge_on, SIZE).is_ok());
}
