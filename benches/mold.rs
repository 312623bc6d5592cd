//! Times of uncut detection: a mold of filleted cavities, 31 thousand triangles, and the same divided to 495 thousand.

use criterion::{Criterion, criterion_group, criterion_main};
use geometry::mesh::Mesh;
use import::{ImportOptions, import_file};
use mold::cutter::{Cutter, CutterLibrary};
use mold::height_field::{HeightField, closing, regions};
use sparkpath::workspaces::mold::job::uncut::{UncutParams, uncut};
use task::Task;

fn library(cutters: &[&str]) -> CutterLibrary {
    CutterLibrary { cutter: cutters.iter().map(|c| c.parse::<Cutter>().expect("a cutter")).collect() }
}

/// Every triangle in four.
fn divided(mesh: &Mesh) -> Mesh {
    let mut fine = Mesh { vertices: mesh.vertices.clone(), triangles: Vec::new() };
    let mut middles = std::collections::HashMap::new();
    for &[a, b, c] in &mesh.triangles {
        let [ab, bc, ca] = [[a, b], [b, c], [c, a]].map(|[p, q]| {
            *middles.entry([p.min(q), p.max(q)]).or_insert_with(|| {
                fine.vertices.push(0.5 * (mesh.vertices[p as usize] + mesh.vertices[q as usize]));
                fine.vertices.len() as u32 - 1
            })
        });
        fine.triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    fine
}

fn molds(criterion: &mut Criterion) {
    let task = Task::default();
    let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/molds/c_fillets.stl");
    let mesh = import_file(&file, &ImportOptions::default(), &task).expect("the mold").mesh;
    let fine = divided(&divided(&mesh));
    let mut group = criterion.benchmark_group("mold");
    group.sample_size(10);
    let flats = ["flat:1", "flat:2", "flat:3"];
    let mixed = ["flat:1", "flat:2", "flat:3", "ball:0.5", "ball:1", "ball:2"];
    let mut of = |name: &str, mesh: &Mesh, cutters: &[&str], spacing: Option<f64>| {
        let mut params = UncutParams::of(library(cutters));
        if let Some(spacing) = spacing {
            (params.layers.is_fixed, params.layers.spacing_mm) = (true, spacing);
        }
        group.bench_function(name, |b| b.iter(|| uncut(mesh, &params, &task).expect("an answer")));
    };
    of("31k triangles, three flat cutters, layers as needed", &mesh, &flats, None);
    of("31k triangles, three flat cutters, some 26 layers", &mesh, &flats, Some(0.5));
    of("31k triangles, flat and ball cutters", &mesh, &mixed, None);
    of("495k triangles, three flat cutters", &fine, &flats, None);
    let heights = |mesh: &Mesh, step: f64| {
        let field = HeightField::raster(mesh, step, &task.cancel).expect("a field");
        let left = closing(&field, &library(&flats), &task.cancel).expect("what is left");
        regions(&field, &left, 0.02, &task.cancel).expect("regions")
    };
    group.bench_function("the yardstick: plain closing at 0.05 mm", |b| b.iter(|| heights(&mesh, 0.05)));
    group.bench_function("a glance: closing at 0.2 mm", |b| b.iter(|| heights(&mesh, 0.2)));
    group.finish();
}

criterion_group!(benches, molds);
criterion_main!(benches);
