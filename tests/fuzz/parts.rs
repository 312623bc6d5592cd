//! Engines on parts that are valid but nasty: slivers, knife edges, faces that lie on one another, tiny and huge sizes, shells that
//! touch. An answer or a refusal, and never a certificate for a motion in which something touches.

use feed::path::{FeedPath, PathRow};
use feed::pose::Pose;
use feed::verify::{VerifyOptions, verify};
use geometry::frame::Frame;
use geometry::mesh::Mesh;
use glam::{DMat3, DVec3};
use mold::cutter::CutterLibrary;
use rand::{RngExt, seq::IndexedRandom};
use sparkpath::workspaces::mold::job::electrodes::electrodes;
use sparkpath::workspaces::mold::job::uncut::{UncutParams, uncut};
use task::Task;
use wheel::channel::Surface;

use super::mesh_files::cuboid;
use super::mutate::Bytes;
use super::target::Target;

/// A closed solid of a few faces about the origin, as large as about 1.
fn solid(random: &mut Bytes) -> Mesh {
    match random.random_range(0..4) {
        0 => cuboid(DVec3::new(1.0, random.random_range(1e-3..1.0), random.random_range(1e-3..1.0))),
        1 => prism(random),
        // A knife edge.
        2 => {
            let mut wedge = cuboid(DVec3::ONE);
            let thin = 10f64.powf(random.random_range(-9.0..-1.0));
            wedge.vertices.iter_mut().filter(|p| p.z > 0.5).for_each(|p| p.y *= thin);
            wedge
        }
        // A step: two boxes that share a face.
        _ => {
            let mut whole = cuboid(DVec3::ONE);
            append(&mut whole, moved(&cuboid(DVec3::new(0.5, 1.0, 0.5)), DVec3::new(0.0, 0.0, 1.0)));
            whole
        }
    }
}

/// A prism over a star of a few corners, which may be slivers.
fn prism(random: &mut Bytes) -> Mesh {
    let n = random.random_range(3..12u32);
    let ring: Vec<DVec3> = (0..n)
        .map(|i| {
            let angle = std::f64::consts::TAU * f64::from(i) / f64::from(n);
            DVec3::new(angle.cos(), angle.sin(), 0.0) * random.random_range(0.05..0.5)
        })
        .collect();
    let mut vertices: Vec<DVec3> = ring.iter().flat_map(|p| [*p, p.with_z(1.0)]).collect();
    vertices.extend([DVec3::ZERO, DVec3::Z]);
    let (bottom, top) = (2 * n, 2 * n + 1);
    let side = |i: u32| {
        let (a, b) = (2 * i, 2 * ((i + 1) % n));
        [[a, b, b + 1], [a, b + 1, a + 1], [bottom, b, a], [top, a + 1, b + 1]]
    };
    Mesh { triangles: (0..n).flat_map(side).collect(), vertices }
}

fn append(mesh: &mut Mesh, other: Mesh) {
    let from = mesh.vertices.len() as u32;
    mesh.vertices.extend(other.vertices);
    mesh.triangles.extend(other.triangles.into_iter().map(|t| t.map(|corner| corner + from)));
}

fn moved(mesh: &Mesh, by: DVec3) -> Mesh {
    mesh.mapped(|p| p + by)
}

fn turn(random: &mut Bytes) -> DMat3 {
    let angle = |random: &mut Bytes| match random.random_range(0..3) {
        0 => 0.0,
        1 => std::f64::consts::FRAC_PI_2,
        _ => random.random_range(-3.0..3.0),
    };
    DMat3::from_rotation_x(angle(random))
        * DMat3::from_rotation_y(angle(random))
        * DMat3::from_rotation_z(angle(random))
}

/// A part with what is nasty about it.
fn nasty(random: &mut Bytes, sizes: std::ops::Range<f64>) -> Mesh {
    let mut mesh = solid(random);
    for _ in 0..random.random_range(0..4) {
        match random.random_range(0..7) {
            // A shell that touches, overlaps or lies within.
            0 | 1 => {
                let by = *[DVec3::X, DVec3::Y, DVec3::new(1.0, 1.0, 1.0), DVec3::splat(0.25), DVec3::X * (1.0 + 1e-12)]
                    .choose(random)
                    .unwrap_or(&DVec3::X);
                let other = moved(&solid(random), by);
                append(&mut mesh, other);
            }
            // A sliver along an edge.
            2 => {
                let t = random.random_range(0..mesh.triangles.len());
                let [a, b, c] = mesh.triangles[t];
                let [p, q] = [a, b].map(|v| mesh.vertices[v as usize]);
                let at = mesh.vertices.len() as u32;
                mesh.vertices.push(p.lerp(q, 10f64.powf(random.random_range(-14.0..-0.3))));
                mesh.triangles[t] = [a, at, c];
                mesh.triangles.push([at, b, c]);
                if let Some(twin) =
                    mesh.triangles.iter().position(|other| (0..3).any(|k| other[k] == b && other[(k + 1) % 3] == a))
                {
                    let other = mesh.triangles[twin];
                    let k = (0..3).find(|&k| other[k] == b).unwrap_or(0);
                    let apex = other[(k + 2) % 3];
                    mesh.triangles[twin] = [b, at, apex];
                    mesh.triangles.push([at, a, apex]);
                }
            }
            // The same face twice.
            3 => {
                let t = random.random_range(0..mesh.triangles.len());
                mesh.triangles.push(mesh.triangles[t]);
            }
            // Corners on a coarse grid, some of them on one another.
            4 => mesh.vertices.iter_mut().for_each(|p| *p = (*p * 4.0).round() / 4.0),
            // A hole.
            5 => drop(mesh.triangles.swap_remove(random.random_range(0..mesh.triangles.len()))),
            _ => mesh.vertices.iter_mut().for_each(|p| p.x *= 1e-6),
        }
    }
    let turn = turn(random);
    let size = 10f64.powf(random.random_range(sizes));
    let far = if random.random_bool(0.1) { DVec3::splat(1e5) } else { DVec3::ZERO };
    mesh.mapped(|p| turn * p * size + far)
}

/// Tries `check` on what `make` makes of the bytes. With `FUZZ_SHOW` in the environment what is made is shown.
fn of_made<T: std::fmt::Debug>(
    inputs: u64,
    make: impl Fn(&mut Bytes) -> T + Send + Sync + 'static,
    check: impl Fn(&T) -> bool + Send + Sync + 'static,
) -> Target {
    let check = move |bytes: &[u8]| {
        let made = make(&mut Bytes(bytes));
        if std::env::var_os("FUZZ_SHOW").is_some() {
            println!("{made:?}");
        }
        check(&made)
    };
    Target { inputs, seeds: Vec::new(), check: Box::new(check) }
}

pub fn wheels() -> Target {
    let options = wheel::options::BliskOptions::default();
    of_made(
        40,
        |random| nasty(random, -9.0..6.0),
        move |mesh: &Mesh| {
            let found = wheel::inspect::inspect(mesh, None, &options, &Task::default()).unwrap();
            assert!(found.channel.is_none() || found.not_found.is_empty(), "{found}");
            true
        },
    )
}

pub fn uncut_regions_and_electrodes() -> Target {
    let cutter = |word: &str| word.parse().unwrap();
    let library = CutterLibrary { cutter: ["flat:1", "flat:5", "ball:1"].map(cutter).to_vec() };
    of_made(
        20,
        |random| nasty(random, -3.0..1.3),
        move |mesh: &Mesh| {
            let task = Task::default();
            let Ok(left) = uncut(mesh, &UncutParams::of(library.clone()), &task) else { return false };
            assert!(left.regions.iter().all(|region| region.plan_area.is_finite() && region.plan_area >= 0.0));
            // Thousands of electrodes take their time on any part.
            if left.regions.len() < 20 {
                drop(electrodes(mesh, &left, &mold::electrode::params::ElectrodeParams::default(), &task));
            }
            true
        },
    )
}

pub fn ruled_surfaces() -> Target {
    of_made(
        40,
        |random| nasty(random, -3.0..3.0),
        |mesh: &Mesh| {
            let all: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
            let params = flank::fit_ruled::RuledFitParams::default();
            flank::fit_ruled::fit_ruled(mesh, &all[..all.len() / 2], &params, &task::Cancel::default()).is_ok()
        },
    )
}

/// A blisk, an electrode and a path.
#[derive(Debug)]
struct Motion {
    blisk: Mesh,
    electrode: Mesh,
    path: FeedPath,
}

fn motion(random: &mut Bytes) -> Motion {
    let blisk = nasty(random, 0.0..2.0);
    let electrode = moved(&nasty(random, 0.0..1.5), DVec3::splat(random.random_range(0.0..20.0)));
    let rows = random.random_range(2..8);
    let mut pose = Pose::FINAL;
    let mut back: Vec<PathRow> = (0..rows)
        .map(|node| {
            let row = PathRow { node, s: node as f64, pose };
            let step = |random: &mut Bytes, most: f64| random.random_range(-most..most);
            pose.x -= random.random_range(0.0..5.0);
            (pose.y, pose.z) = (pose.y + step(random, 1.0), pose.z + step(random, 1.0));
            (pose.a, pose.c) = (pose.a + step(random, 0.3), pose.c + step(random, 0.3));
            row
        })
        .collect();
    back.reverse();
    let path = FeedPath {
        frame: Frame::from_x_and_z_hint(DVec3::ZERO, DVec3::X, DVec3::Z),
        reference_point: DVec3::ZERO,
        spark_gap: 0.1,
        rows: back,
    };
    Motion { blisk, electrode, path }
}

/// The pose at share `t` of the way from one row to the next.
fn between(from: &Pose, to: &Pose, t: f64) -> Pose {
    let at = |of: fn(&Pose) -> f64| of(from) + t * (of(to) - of(from));
    Pose { x: at(|p| p.x), y: at(|p| p.y), z: at(|p| p.z), a: at(|p| p.a), b: at(|p| p.b), c: at(|p| p.c) }
}

/// No certificate is contradicted by a sample.
pub fn certificates() -> Target {
    of_made(60, motion, |Motion { blisk, electrode, path }: &Motion| {
        let options = VerifyOptions::default();
        let surface = |_: DVec3| Surface::Hub;
        let Ok(certificate) = verify(blisk, electrode, path, &surface, &options, &Task::default()) else {
            return false;
        };
        if !certificate.holds() {
            return false;
        }
        let proven = certificate.certified();
        assert!(proven >= path.spark_gap - options.tolerance_mm, "{proven}");
        for rows in path.rows.windows(2) {
            for k in 0..=20 {
                let pose = between(&rows[0].pose, &rows[1].pose, f64::from(k) / 20.0);
                let placement = pose.placement(path.reference_point);
                let placed = electrode.mapped(|p| placement.transform_point3(p));
                let distance = nearest(&placed, blisk);
                assert!(
                    distance >= proven - 1e-9 * (1.0 + blisk.bounds().size().length()),
                    "{distance} for {proven} at {pose:?}"
                );
            }
        }
        true
    })
}

/// Distance of two meshes by every pair of triangles (mm).
fn nearest(a: &Mesh, b: &Mesh) -> f64 {
    use parry3d_f64::query::distance;
    use parry3d_f64::shape::Triangle;
    let triangle = |[p, q, r]: [DVec3; 3]| Triangle::new(p.to_array().into(), q.to_array().into(), r.to_array().into());
    let of = |mesh: &Mesh| -> Vec<Triangle> { mesh.iter_corners().map(triangle).collect() };
    let (a, b) = (of(a), of(b));
    let still = Default::default();
    let pairs = a.iter().flat_map(|a| b.iter().map(move |b| (a, b)));
    pairs
        .filter_map(|(a, b)| distance(&still, a, &still, b).ok())
        .map(|found| found.distance)
        .fold(f64::INFINITY, f64::min)
}
