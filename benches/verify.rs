//! Time to verify a feed path in the worst of cases: a screw motion along helical walls, where every surface of
//! the electrode keeps a constant distance of about the spark gap from the blisk all the way.

use criterion::{Criterion, criterion_group, criterion_main};
use feed::path::{FeedPath, PathRow};
use feed::pose::Pose;
use feed::verify::{Verifier, VerifyOptions};
use geometry::frame::{Cylindrical, Frame};
use geometry::mesh::Mesh;
use glam::DVec3;
use task::{Cancel, Task};
use wheel::channel::Surface;

const GAP: f64 = 0.1;
const HUB: f64 = 110.0;
const SHROUD: f64 = 125.0;
const WIDTH: f64 = 26.0;
/// Turn of the walls about the axis per length along it (rad/mm): 30 degrees at the hub.
const LEAD: f64 = 0.577 / HUB;
const CHANNELS: usize = 60;
/// Half the angle of a channel between its walls (rad).
const HALF_CHANNEL: f64 = 0.035;
const REFERENCE_POINT: DVec3 = DVec3::new(0.0, 0.0, 0.5 * (HUB + SHROUD));

/// Adds a grid of `nu` by `nv` cells, its corners given for u and v in [0, 1].
fn add_patch(mesh: &mut Mesh, nu: usize, nv: usize, point: impl Fn(f64, f64) -> DVec3) {
    let first = mesh.vertices.len() as u32;
    let at = |u: usize, v: usize| first + (u * (nv + 1) + v) as u32;
    for u in 0..=nu {
        mesh.vertices.extend((0..=nv).map(|v| point(u as f64 / nu as f64, v as f64 / nv as f64)));
    }
    for (u, v) in (0..nu).flat_map(|u| (0..nv).map(move |v| (u, v))) {
        mesh.triangles.push([at(u, v), at(u + 1, v), at(u + 1, v + 1)]);
        mesh.triangles.push([at(u, v), at(u + 1, v + 1), at(u, v + 1)]);
    }
}

/// The surface of a twisted block: helical side walls at `theta` and `-theta`, from `inner` to `outer` radius.
fn add_twisted_block(mesh: &mut Mesh, width: f64, turn: f64, theta: f64, [inner, outer]: [f64; 2], cells: [usize; 3]) {
    let on = |u: f64, r: f64, theta: f64| {
        let x = (u - 0.5) * width;
        Cylindrical { x, r, theta: turn + theta + LEAD * x }.point()
    };
    let [nx, nr, nt] = cells;
    for side in [-theta, theta] {
        add_patch(mesh, nx, nr, |u, v| on(u, inner + (outer - inner) * v, side));
    }
    for r in [inner, outer] {
        add_patch(mesh, nx, nt, |u, v| on(u, r, theta * (2.0 * v - 1.0)));
    }
    for end in [0.0, 1.0] {
        add_patch(mesh, nr, nt, |u, v| on(end, inner + (outer - inner) * u, theta * (2.0 * v - 1.0)));
    }
}

/// The walls of all channels: about 100 000 triangles.
fn blisk() -> Mesh {
    let mut mesh = Mesh::default();
    for channel in 0..CHANNELS {
        let turn = channel as f64 * std::f64::consts::TAU / CHANNELS as f64;
        let on = |u: f64, r: f64, theta: f64| {
            let x = (u - 0.5) * WIDTH;
            Cylindrical { x, r, theta: turn + theta + LEAD * x }.point()
        };
        for side in [-HALF_CHANNEL, HALF_CHANNEL] {
            add_patch(&mut mesh, 26, 12, |u, v| on(u, HUB + (SHROUD - HUB) * v, side));
        }
        for r in [HUB, SHROUD] {
            add_patch(&mut mesh, 14, 7, |u, v| on(u, r, HALF_CHANNEL * (2.0 * v - 1.0)));
        }
    }
    mesh
}

/// The electrode of the first channel: about 12 000 triangles.
fn electrode() -> Mesh {
    let mut mesh = Mesh::default();
    let radii = [HUB + GAP, SHROUD - GAP];
    add_twisted_block(&mut mesh, 20.0, 0.0, HALF_CHANNEL - 1.4 * GAP / HUB, radii, [60, 24, 16]);
    mesh
}

/// A path of `rows` rows that screws the electrode out of its channel; `slip` is the error of its turn.
fn path(rows: usize, slip: f64) -> FeedPath {
    let row = |i: usize| {
        let s = (rows - 1 - i) as f64 * 30.0 / (rows - 1) as f64;
        PathRow { node: rows - 1 - i, s, pose: Pose { x: -s, a: -LEAD * s * (1.0 + slip), ..Pose::FINAL } }
    };
    let rows = (0..rows).map(row).collect();
    FeedPath { frame: Frame::IDENTITY, reference_point: REFERENCE_POINT, spark_gap: GAP, rows }
}

fn verification(c: &mut Criterion) {
    let (blisk, electrode) = (blisk(), electrode());
    let verifier =
        Verifier::new(&blisk, &electrode, REFERENCE_POINT, &Cancel::default()).expect("the meshes have triangles");
    let options = VerifyOptions::default();
    let mut group = c.benchmark_group("verify");
    group.sample_size(10);
    group.bench_function("prepare 100k and 12k triangles", |b| {
        b.iter(|| Verifier::new(&blisk, &electrode, REFERENCE_POINT, &Cancel::default()));
    });
    group.bench_function("distance in the channel", |b| b.iter(|| verifier.distance(&Pose::FINAL)));
    for (name, slip) in [("300 rows at constant gap", 0.0), ("300 rows that cross", 0.05)] {
        let path = path(300, slip);
        let run = || {
            let surface = |_: DVec3| Surface::Elsewhere;
            verifier.verify(&path, &surface, &options, &Task::default())
        };
        if let Ok(certificate) = run() {
            let (pairs, least) = (certificate.pair_intervals(), certificate.least().distance);
            println!("{name}: {pairs} pairs, least {least:.6}, certified {:.6}", certificate.certified());
        }
        group.bench_function(name, |b| b.iter(run));
    }
    group.finish();
}

criterion_group!(benches, verification);
criterion_main!(benches);
