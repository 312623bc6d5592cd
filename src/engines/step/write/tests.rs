//! Tests of the writer.

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

use geometry::mesh::Mesh;
use glam::DVec3;
use step_io::model as m;
use task::{Cancel, Task};

use super::*;

fn written(mesh: &Mesh, tolerance: f64) -> StepFile {
    let part = StepPart { name: "E01", mesh, roles: &[], role_of: &[], patches: &[], properties: &[] };
    write_step(&part, &StepSettings { tolerance, ..Default::default() }, &Task::default()).unwrap()
}

/// Every edge is used exactly twice, in opposite senses.
fn assert_closed(model: &m::StepModel) {
    let mut uses: HashMap<String, Vec<bool>> = HashMap::new();
    for (_, edge) in model.all::<m::OrientedEdge>() {
        uses.entry(format!("{:?}", edge.edge_element)).or_default().push(edge.orientation);
    }
    assert!(!uses.is_empty());
    assert!(uses.values().all(|senses| senses.len() == 2 && senses[0] != senses[1]));
}

/// A tube of rings of points, closed by fans over its flat ends.
fn tube(rings: &[Vec<DVec3>]) -> Mesh {
    let n = rings[0].len() as u32;
    let mut mesh = Mesh { vertices: rings.concat(), triangles: Vec::new() };
    for r in 0..rings.len() as u32 - 1 {
        for k in 0..n {
            let (a, b) = (r * n + k, r * n + (k + 1) % n);
            mesh.triangles.extend([[a, b, b + n], [a, b + n, a + n]]);
        }
    }
    let last = (rings.len() as u32 - 1) * n;
    for k in 1..n - 1 {
        mesh.triangles.push([0, k + 1, k]);
        mesh.triangles.push([last, last + k, last + k + 1]);
    }
    mesh
}

fn circle(radius: f64, height: f64, n: usize) -> Vec<DVec3> {
    let angle = |k: usize| TAU * k as f64 / n as f64;
    (0..n).map(|k| DVec3::new(radius * angle(k).cos(), radius * angle(k).sin(), height)).collect()
}

#[test]
fn a_box_is_six_planes_with_its_volume() {
    let file = written(&Mesh::cuboid(DVec3::new(2.0, 3.0, 4.0)), 0.005);
    let report = &file.report;
    assert_eq!((report.planes, report.faces(), report.edges, report.solids), (6, 6, 12, 1));
    assert!((report.volume_mm3 - 24.0).abs() < 1e-9 && report.deviation_mm() < 1e-9);
    let (model, read) = step_io::read(&file.bytes[..]).unwrap();
    assert!(read.dropped.is_empty());
    assert_eq!((model.all::<m::AdvancedFace>().len(), model.all::<m::Plane>().len()), (6, 6));
    assert_closed(&model);
}

#[test]
fn a_cylinder_is_two_halves_and_has_the_volume_of_a_cylinder() {
    let file = written(&tube(&[circle(5.0, 0.0, 120), circle(5.0, 10.0, 120)]), 0.005);
    let report = &file.report;
    assert_eq!((report.planes, report.cylinders, report.free_forms), (2, 2, 0));
    assert!((report.volume_mm3 / (PI * 250.0) - 1.0).abs() < 2e-4, "{report:?}");
    // A facet of 3 degrees leaves the circle by r (1 - cos 1.5 degrees).
    let sagitta = 5.0 * (1.0 - 1.5f64.to_radians().cos());
    assert!((report.outside_mm - sagitta).abs() < 0.05 * sagitta, "{report:?}");
    let (model, _) = step_io::read(&file.bytes[..]).unwrap();
    assert_eq!(model.all::<m::CylindricalSurface>().len(), 2);
    assert!(model.all::<m::Circle>().len() >= 4);
    assert_closed(&model);
}

#[test]
fn a_cone_is_a_cone() {
    let file = written(&tube(&[circle(5.0, 0.0, 120), circle(3.0, 10.0, 120)]), 0.005);
    assert_eq!((file.report.planes, file.report.cones, file.report.free_forms), (2, 2, 0));
    assert!((file.report.volume_mm3 / (PI * 10.0 / 3.0 * (25.0 + 15.0 + 9.0)) - 1.0).abs() < 2e-4);
}

#[test]
fn a_barrel_goes_around_and_is_fitted_within_the_tolerance() {
    // Turned about z, its radius going up and down as a parabola: a free form with two lines around it.
    let radius = |z: f64| 5.0 + 0.04 * z * (10.0 - z);
    let rings: Vec<Vec<DVec3>> = (0..=40).map(|k| 0.25 * f64::from(k)).map(|z| circle(radius(z), z, 160)).collect();
    let mesh = tube(&rings);
    let report = written(&mesh, 0.005).report;
    assert!(report.free_forms >= 2 && report.free_forms <= 8 && report.planes == 2, "{report:?}");
    assert!(report.deviation_mm() <= 0.006 && report.edge_gap_mm < 0.001, "{report:?}");
    assert!((report.volume_mm3 / mesh.volume() - 1.0).abs() < 5e-4);
}

/// A box of 8 x 8 mm whose top is `top`, on a grid of 41 x 41 points.
fn block(top: impl Fn(f64, f64) -> f64) -> Mesh {
    let n = 41u32;
    let at = |k: u32| -4.0 + 8.0 * f64::from(k) / f64::from(n - 1);
    let mut mesh = Mesh::default();
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        mesh.vertices.push(DVec3::new(at(i), at(j), top(at(i), at(j))));
    }
    for (i, j) in (0..n - 1).flat_map(|i| (0..n - 1).map(move |j| (i, j))) {
        let (a, b) = (i * n + j, (i + 1) * n + j);
        mesh.triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
    }
    // Around the grid counter-clockwise seen from above, then down to the bottom.
    let around: Vec<u32> = (0..n - 1)
        .map(|k| k * n)
        .chain((0..n - 1).map(|k| (n - 1) * n + k))
        .chain((1..n).rev().map(|k| k * n + n - 1))
        .chain((1..n).rev())
        .collect();
    let first = mesh.vertices.len() as u32;
    for &v in &around {
        let p = mesh.vertices[v as usize];
        mesh.vertices.push(DVec3::new(p.x, p.y, -5.0));
    }
    let count = around.len() as u32;
    for k in 0..count {
        let (a, b) = (around[k as usize], around[((k + 1) % count) as usize]);
        let (c, d) = (first + k, first + (k + 1) % count);
        mesh.triangles.extend([[a, c, d], [a, d, b]]);
    }
    mesh.triangles.extend((1..count - 1).map(|k| [first, first + k + 1, first + k]));
    mesh
}

#[test]
fn a_bump_is_one_free_form_within_the_tolerance() {
    let mesh = block(|x, y| 0.8 * (0.4 * x).cos() * (0.3 * y + 0.2).cos());
    assert!(mesh.is_watertight() && mesh.volume() > 0.0);
    let report = written(&mesh, 0.005).report;
    assert_eq!((report.planes, report.free_forms, report.edges), (5, 1, 12), "{report:?}");
    assert!(report.deviation_mm() <= 0.005, "{report:?}");
}

#[test]
fn properties_and_roles_are_in_the_file_and_the_bytes_stay_the_same() {
    let mesh = Mesh::cuboid(DVec3::splat(3.0));
    let roles = [
        Role { name: "burning face".to_owned(), colour: Some([0.9, 0.4, 0.1]) },
        Role { name: "base".to_owned(), colour: None },
    ];
    let property = |name: &str, value| Property { name: name.to_owned(), value };
    let properties = [
        property("material", PropertyValue::Text("copper".to_owned())),
        property("spark gap", PropertyValue::Length(0.05)),
        property("C angle", PropertyValue::Angle(0.5)),
        property("quantity", PropertyValue::Count(2)),
    ];
    let role_of: Vec<u16> = (0..12).map(|i| u16::from(i < 2)).collect();
    let part =
        StepPart { name: "E02", mesh: &mesh, roles: &roles, role_of: &role_of, patches: &[], properties: &properties };
    let write = || write_step(&part, &StepSettings::default(), &Task::default()).unwrap();
    let file = write();
    assert_eq!(file.bytes, write().bytes);
    let (model, read) = step_io::read(&file.bytes[..]).unwrap();
    assert!(read.dropped.is_empty());
    let names = |wanted: &str| model.all::<m::AdvancedFace>().filter(|(_, f)| model.text(f.name) == wanted).count();
    assert_eq!((names("burning face"), names("base")), (5, 1));
    assert_eq!(model.all::<m::PropertyDefinitionRepresentation>().len(), 4);
    assert_eq!(model.all::<m::StyledItem>().len(), 5);
    let solid =
        crate::read::read(&file.bytes, &crate::read::Options::default(), &Task::default()).unwrap().solids.remove(0);
    let coloured = solid.faces.iter().filter(|f| f.name == "burning face" && f.color == Some([0.9, 0.4, 0.1])).count();
    assert_eq!((coloured, solid.faces.len(), solid.is_closed()), (5, 6, true));
}

#[test]
fn what_cannot_be_written_is_told() {
    let mesh = Mesh::cuboid(DVec3::ONE);
    let write = |mesh: &Mesh, tolerance: f64, task: &Task| {
        let part = StepPart { name: "E", mesh, roles: &[], role_of: &[], patches: &[], properties: &[] };
        write_step(&part, &StepSettings { tolerance, ..Default::default() }, task).unwrap_err()
    };
    let task = Task::default();
    assert_eq!(write(&mesh, 0.0, &task), StepWriteError::Tolerance(0.0));
    assert_eq!(write(&Mesh::default(), 0.01, &task), StepWriteError::Unusable);
    let open = Mesh { triangles: mesh.triangles[1..].to_vec(), ..mesh.clone() };
    assert!(matches!(write(&open, 0.01, &task), StepWriteError::NotClosed { .. }));
    assert!(matches!(write(&mesh.turned_over(), 0.01, &task), StepWriteError::Cavity { .. }));
    let cancel = Cancel::default();
    cancel.cancel();
    assert_eq!(write(&mesh, 0.01, &Task::silent(&cancel)), StepWriteError::Cancelled(Cancelled));
}

/// Rings of four sides with `n` intervals each, one after the other, as a closed mesh with its patches: four for each
/// of the runs of rings that `runs` ends, and the two caps.
fn patched(rings: &[Vec<DVec3>], n: usize, runs: &[usize]) -> (Mesh, Vec<Patch>) {
    let around = 4 * n;
    let mut mesh = Mesh { vertices: rings.concat(), triangles: Vec::new() };
    let mut patches = Vec::new();
    let mut from = 0;
    for &to in runs {
        for side in 0..4 {
            let id = |k: usize, ring: usize| (ring * around + (side * n + k) % around) as u32;
            let vertices = (0..=n).flat_map(|k| (from..=to).map(move |ring| id(k, ring))).collect();
            patches.push(Patch::new(to - from + 1, vertices).unwrap());
        }
        from = to;
    }
    for (ring, is_first) in [(0, true), (rings.len() - 1, false)] {
        let on = |k: usize| ring * around + k % around;
        let mut vertices = Vec::new();
        for i in 0..=n {
            for j in 0..=n {
                vertices.push(match (i, j) {
                    (i, 0) => on(i),
                    (i, j) if i == n => on(n + j),
                    (i, j) if j == n => on(3 * n - i),
                    (0, j) => on(4 * n - j),
                    _ => {
                        let (left, right) = (mesh.vertices[on(4 * n - j)], mesh.vertices[on(n + j)]);
                        mesh.vertices.push(left.lerp(right, i as f64 / n as f64));
                        mesh.vertices.len() - 1
                    }
                } as u32);
            }
        }
        let patch = Patch::new(n + 1, vertices).unwrap();
        patches.push(if is_first { patch.turned_over() } else { patch });
    }
    let quads = patches.iter().flat_map(Patch::quads);
    mesh.triangles = quads.flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    (mesh, patches)
}

/// A ring of four sides that bulge by `bulge` at z, turned by `turn`.
fn four_sided(half: f64, bulge: f64, (z, turn): (f64, f64), n: usize) -> Vec<DVec3> {
    let corner =
        |k: usize| DVec3::from([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]][k % 4]);
    let rotation = glam::DMat3::from_rotation_z(turn);
    let point = |side: usize, k: usize| {
        let t = k as f64 / n as f64;
        let out = (corner(side) + corner(side + 1)) * 0.5;
        let flat = corner(side).lerp(corner(side + 1), t) * half + out * (bulge * 4.0 * t * (1.0 - t));
        rotation * flat + DVec3::Z * z
    };
    (0..4).flat_map(|side| (0..n).map(move |k| (side, k))).map(|(side, k)| point(side, k)).collect()
}

fn of_patches(mesh: &Mesh, patches: &[Patch], settings: &StepSettings) -> Result<StepFile, StepWriteError> {
    let patches: Vec<StepPatch> = patches.iter().map(|grid| StepPatch { grid, role: 0 }).collect();
    let part = StepPart { name: "E", mesh, roles: &[], role_of: &[], patches: &patches, properties: &[] };
    write_step(&part, settings, &Task::default())
}

#[test]
fn known_patches_are_faces_that_stay_inside_of_the_mesh() {
    // A twisted bar, its end in a plane with the frame of a square head.
    let n = 24;
    let mut rings: Vec<Vec<DVec3>> =
        (0..=60).map(|k| four_sided(4.0, 0.8, (0.5 * f64::from(k), 0.01 * f64::from(k)), n)).collect();
    rings.push(four_sided(9.0, 0.0, (30.0, 0.6), n));
    rings.push(four_sided(9.0, 0.0, (36.0, 0.6), n));
    let (mesh, patches) = patched(&rings, n, &[60, 61, 62]);
    let settings = StepSettings { tolerance: 0.002, to_spare: 5e-4, ..Default::default() };
    let file = of_patches(&mesh, &patches, &settings).unwrap();
    let report = &file.report;
    // Four walls; both ends, the frame, which is one face with a hole, and the four sides of the head.
    assert_eq!((report.free_forms, report.planes, report.solids), (4, 7, 1), "{report:?}");
    assert!(report.outside_mm + report.unsure_mm <= settings.to_spare && report.inside_mm < 0.004, "{report:?}");
    assert!((report.volume_mm3 / report.mesh_volume_mm3 - 1.0).abs() < 5e-4, "{report:?}");
    let (model, _) = step_io::read(&file.bytes[..]).unwrap();
    assert_closed(&model);
    let bounds: Vec<usize> = model.all::<m::AdvancedFace>().map(|(_, face)| face.bounds.len()).collect();
    assert_eq!((bounds.len(), bounds.iter().filter(|count| **count == 2).count()), (11, 1));
}

#[test]
fn patches_that_do_not_share_whole_sides_or_leave_holes_are_refused() {
    let rings: Vec<Vec<DVec3>> = [0.0, 5.0, 10.0].map(|z| four_sided(4.0, 0.01, (z, 0.0), 6)).to_vec();
    let (mesh, mut patches) = patched(&rings, 6, &[1, 2]);
    of_patches(&mesh, &patches, &StepSettings::default()).unwrap();
    // Nothing to spare cannot be measured.
    let nothing = StepSettings { to_spare: 0.0, ..Default::default() };
    assert!(matches!(of_patches(&mesh, &patches, &nothing), Err(StepWriteError::ToSpare { .. })));
    let lid = patches.pop().unwrap();
    let refused = |patches: &[Patch]| {
        matches!(of_patches(&mesh, patches, &StepSettings::default()), Err(StepWriteError::Patches { .. }))
    };
    assert!(refused(&patches));
    let half = lid.part([0, 6], [0, 3]).unwrap();
    patches.push(half);
    assert!(refused(&patches));
}

#[test]
fn patches_of_vertices_that_are_not_there_and_a_stop_are_told() {
    let (mesh, mut patches) = patched(&[0.0, 5.0].map(|z| four_sided(4.0, 0.01, (z, 0.0), 6)), 6, &[1]);
    let given: Vec<StepPatch> = patches.iter().map(|grid| StepPatch { grid, role: 0 }).collect();
    let part = StepPart { name: "E", mesh: &mesh, roles: &[], role_of: &[], patches: &given, properties: &[] };
    let cancel = Cancel::default();
    cancel.cancel();
    let stopped = write_step(&part, &StepSettings::default(), &Task::silent(&cancel));
    assert!(matches!(stopped, Err(StepWriteError::Cancelled(_))));
    patches[0] = Patch::new(2, vec![0, 1, 2, 1_000_000]).unwrap();
    assert_eq!(of_patches(&mesh, &patches, &StepSettings::default()).unwrap_err(), StepWriteError::Unusable);
}
