//! Pictures of many objects while the view moves.

use super::*;

const LARGE: [u32; 2] = [480, 320];

fn moving(offscreen: &mut Offscreen, scene: &Scene, camera: &Camera) -> RgbaImage {
    offscreen.draw(scene, camera, LARGE, Quality::Moving).unwrap();
    offscreen.read_back().unwrap()
}

/// Boxes side by side, enough to be drawn together, of many colours and placed in many ways.
fn boxes() -> Scene {
    let wedge = {
        let mut mesh = Mesh::cuboid(DVec3::new(4.0, 5.0, 6.0));
        mesh.vertices.iter_mut().for_each(|p| p.x += 0.2 * p.z);
        Arc::new(RenderMesh::new(&mesh))
    };
    let placed = |i: u32| {
        let at = DVec3::new(f64::from(i % 25) * 10.0, 0.0, f64::from(i / 25) * 10.0);
        let size = DVec3::new(1.0, 1.0 + f64::from(i % 2), if i.is_multiple_of(3) { -1.0 } else { 1.0 });
        DAffine3::from_scale_rotation_translation(size, DQuat::from_rotation_y(f64::from(i % 7)), at)
    };
    let colour = |i: u32| Colour::rgb((i * 7 % 256) as u8, (i * 31 % 256) as u8, (i * 3 % 256) as u8);
    let object = |i: u32| Object {
        edges: false,
        selected: i.is_multiple_of(11),
        ..Object::new(ObjectId(i), wedge.clone(), colour(i)).at(placed(i))
    };
    scene((0..375).map(object).collect())
}

/// A scene with a section beside all of it, in which objects are never drawn together.
fn one_by_one(scene: &Scene) -> Scene {
    let beside = SectionPlane { point: DVec3::new(0.0, -1000.0, 0.0), normal: DVec3::NEG_Y };
    Scene { section: Some(beside), ..scene.clone() }
}

#[test]
fn objects_drawn_together_look_as_one_by_one() {
    let (mut offscreen, scene) = (offscreen(), boxes());
    let camera = front(&scene);
    let together = moving(&mut offscreen, &scene, &camera);
    let alone = moving(&mut offscreen, &one_by_one(&scene), &camera);
    assert!(different(&together, &alone) < 20, "{}", different(&together, &alone));
    let empty = moving(&mut offscreen, &Scene::default(), &camera);
    assert!(different(&together, &empty) > 20_000);
}

/// Each object has one value, or none; the range, the map and the values may change.
#[test]
fn values_of_objects_drawn_together_look_as_one_by_one() {
    let (mut offscreen, mut scene) = (offscreen(), boxes());
    let camera = front(&scene);
    let plain = moving(&mut offscreen, &scene, &camera);
    let count = scene.objects[0].mesh.source().vertices.len();
    for (i, object) in scene.objects.iter_mut().enumerate() {
        let value = if i % 5 == 0 { f32::NAN } else { (i % 6) as f32 };
        let values = Arc::new(vec![value; count]);
        object.values = Some(SurfaceValues { values, map: ColourMap::Light, range: [0.0, 5.0] });
    }
    let mut before = plain;
    for change in [
        (|_| ()) as fn(&mut SurfaceValues),
        |v| v.range = [2.0, 3.0],
        |v| v.map = ColourMap::Sequential,
        |v| v.values = Arc::new(v.values.iter().map(|x| 5.0 - x).collect()),
    ] {
        scene.objects.iter_mut().filter_map(|o| o.values.as_mut()).for_each(change);
        let together = moving(&mut offscreen, &scene, &camera);
        let alone = moving(&mut offscreen, &one_by_one(&scene), &camera);
        assert!(different(&together, &alone) < 20, "{}", different(&together, &alone));
        assert!(different(&together, &before) > 2000, "{}", different(&together, &before));
        before = together;
    }
}

#[test]
fn a_change_of_one_of_many_is_seen_and_what_comes_again_looks_as_before() {
    let (mut offscreen, scene) = (offscreen(), boxes());
    let camera = front(&scene);
    let first = moving(&mut offscreen, &scene, &camera);
    for change in [
        (|o: &mut Object| o.opacity = 0.0) as fn(&mut Object),
        |o| o.colour = Colour::rgb(255, 255, 255),
        |o| o.transform.translation.z += 3.0,
        |o| o.selected = !o.selected,
    ] {
        let mut changed = scene.clone();
        change(&mut changed.objects[187]);
        let picture = moving(&mut offscreen, &changed, &camera);
        assert!((10..2000).contains(&different(&first, &picture)), "{}", different(&first, &picture));
        let alone = moving(&mut offscreen, &one_by_one(&changed), &camera);
        assert!(different(&picture, &alone) < 20);
    }
    // Long enough for what is not drawn to be let go.
    let nothing = Scene::default();
    (0..320).for_each(|_| offscreen.draw(&nothing, &camera, [8, 8], Quality::Moving).unwrap());
    assert!(moving(&mut offscreen, &scene, &camera) == first);
}

#[test]
fn smaller_meshes_are_drawn_lighter_only_where_there_are_very_many_triangles() {
    let mut offscreen = offscreen();
    let ball = Arc::new(RenderMesh::new(&sphere(5.0, 14, DVec3::ZERO)));
    let at = |i: u32| DAffine3::from_translation(DVec3::X * 20.0 * f64::from(i));
    let object = |i: u32| Object::new(ObjectId(i), ball.clone(), BLUE).at(at(i));
    let balls = |count: u32| scene((0..count).map(object).collect());
    // All but the first are beside the picture.
    let camera = front(&balls(1));
    let [many, more, very_many] = [260, 270, 300].map(|count| moving(&mut offscreen, &balls(count), &camera));
    assert!(different(&many, &more) < 20, "{}", different(&many, &more));
    assert!(different(&many, &very_many) > 500, "{}", different(&many, &very_many));
}
