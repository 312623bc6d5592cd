//! Times of pictures: preparing meshes, cutting them, drawing frames, picking.

use std::f64::consts::TAU;
use std::sync::Arc;

use criterion::{Criterion, criterion_group, criterion_main};
use geometry::mesh::Mesh;
use glam::{DAffine3, DVec2, DVec3};
use render::camera::{Camera, OrbitStyle};
use render::colour::{Colour, Theme};
use render::colour_map::ColourMap;
use render::mesh::RenderMesh;
use render::offscreen::Offscreen;
use render::pick::pick;
use render::renderer::Quality;
use render::scene::{Grid, Object, ObjectId, Scene, SectionPlane, SurfaceValues};
use render::section::cut;
use wheel::parametric::{MeshResolution, ParametricBlisk};

const SIZE: [u32; 2] = [1280, 800];

/// A closed ring with 20 waves around it: `2 n * n` triangles.
fn wavy_ring(n: usize) -> Mesh {
    let point = |i: usize, j: usize| {
        let (around, across) = (TAU * i as f64 / n as f64, TAU * j as f64 / n as f64);
        let tube = 12.0 + (20.0 * around).sin();
        let r = 60.0 + tube * across.cos();
        DVec3::new(r * around.cos(), r * around.sin(), tube * across.sin())
    };
    let at = |i: usize, j: usize| (i % n * n + j % n) as u32;
    let cells = || (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    let quads = cells().map(|(i, j)| [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
    Mesh {
        vertices: cells().map(|(i, j)| point(i, j)).collect(),
        triangles: quads.flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
    }
}

fn scene(mesh: Arc<RenderMesh>) -> (Scene, Camera) {
    let mut scene = Scene::new(Theme::DARK);
    scene.objects.push(Object::new(ObjectId(0), mesh, Colour::rgb(150, 160, 175)));
    scene.grid = Grid::below(&scene.bounds());
    let mut camera = Camera::default();
    camera.fit(&scene.bounds(), f64::from(SIZE[0]) / f64::from(SIZE[1]));
    (scene, camera)
}

/// A plate of squares of `pitch`, `n * n` of them, each with the surface that `mesh` gives on it.
fn plate(n: usize, pitch: f64, edges: bool, mesh: &Mesh) -> (Scene, Camera) {
    let side = pitch * n as f64;
    let (mut scene, _) = scene(Arc::new(RenderMesh::new(&Mesh::cuboid(DVec3::new(side, side, 10.0)))));
    for i in 0..n * n {
        let middle = DVec3::new(pitch * ((i % n) as f64 + 0.5), pitch * ((i / n) as f64 + 0.5), 30.0);
        let colour = Colour::rgb((i % 256) as u8, (i / 256 % 256) as u8, 90);
        let placed = Arc::new(RenderMesh::new(&mesh.mapped(|p| middle + p)));
        scene.objects.push(Object { edges, ..Object::new(ObjectId(1 + i as u32), placed, colour) });
    }
    let mut camera = Camera::default();
    camera.fit(&scene.bounds(), f64::from(SIZE[0]) / f64::from(SIZE[1]));
    (scene, camera)
}

/// A waved square of 32 triangles.
fn patch() -> Mesh {
    let point = |k: usize| DVec3::new(36.0 * (k / 5) as f64 - 72.0, 36.0 * (k % 5) as f64 - 72.0, (k / 5 % 2) as f64);
    let quads = (0..4).flat_map(|i| (0..4).map(move |j| [0, 5, 6, 1].map(|v| 5 * i + j + v)));
    Mesh {
        vertices: (0..25).map(point).collect(),
        triangles: quads.flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
    }
}

/// A wheel of 200 blades, 640 mm across.
fn wheel_of_200_channels() -> Mesh {
    let wheel = ParametricBlisk {
        blades: 200,
        hub_radius_mm: 300.0,
        shroud_radius_mm: 316.0,
        bore_radius_mm: 250.0,
        ..Default::default()
    };
    wheel.mesh(&MeshResolution::default()).expect("a wheel that can be made")
}

fn render(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("render");
    group.sample_size(10);
    let (mesh, large) = (wavy_ring(316), wavy_ring(707));
    group.bench_function("prepare mesh, 200k triangles", |b| b.iter(|| RenderMesh::new(&mesh)));
    group.bench_function("prepare mesh, 1M triangles", |b| b.iter(|| RenderMesh::new(&large)));
    let prepared = Arc::new(RenderMesh::new(&mesh));
    let plane = SectionPlane { point: DVec3::ZERO, normal: DVec3::Y };
    group.bench_function("section, 200k triangles", |b| b.iter(|| cut(&prepared, &DAffine3::IDENTITY, &plane)));

    let mut offscreen = Offscreen::new().expect("a graphics driver");
    let mut frames = |name: &str, scene: &Scene, mut camera: Camera, quality| {
        group.bench_function(name, |b| {
            b.iter(|| {
                camera.orbit(DVec2::new(3.0, 0.0), SIZE[1], OrbitStyle::Turntable, camera.target);
                offscreen.draw(scene, &camera, SIZE, quality)
            });
        });
    };
    let (small, camera) = scene(prepared);
    frames("frame at rest, 200k triangles", &small, camera, Quality::Full);
    frames("frame in motion, 200k triangles", &small, camera, Quality::Moving);
    let (million, wide) = scene(Arc::new(RenderMesh::new(&large)));
    frames("frame in motion, 1M triangles", &million, wide, Quality::Moving);
    let (wheel, wide) = scene(Arc::new(RenderMesh::new(&wheel_of_200_channels())));
    frames("frame in motion, wheel of 200 channels", &wheel, wide, Quality::Moving);
    let (mut many, wide) = plate(100, 200.0, false, &patch());
    frames("frame in motion, 10,000 regions of a mold", &many, wide, Quality::Moving);
    many.objects.iter_mut().skip(1).for_each(|region| {
        let depths = (0..25).map(|k| k as f32 / 24.0).collect();
        let values = SurfaceValues { values: Arc::new(depths), map: ColourMap::Light, range: [0.0, 1.0] };
        region.values = Some(values);
    });
    frames("frame in motion, 10,000 regions coloured by depth", &many, wide, Quality::Moving);
    let (many, wide) = plate(32, 200.0, true, &wavy_ring(24));
    frames("frame in motion, 1,000 electrodes", &many, wide, Quality::Moving);
    group.bench_function("pick", |b| b.iter(|| pick(&small, &camera, DVec2::new(500.0, 500.0), SIZE)));
    group.finish();
}

criterion_group!(benches, render);
criterion_main!(benches);
