//! A made-up path, certificate and report for the tests of this floor.

use glam::DVec3;

use super::approved::Approved;
use feed::certificate::{Certificate, Contact, Findings, TravelVerdict};
use feed::copying::{CopyingExtent, CopyingMotion, Turn};
use feed::machine_model::MachineModel;
use feed::path::{FeedPath, PathRow};
use feed::pose::Pose;
use feed::quantise::quantise_path;
use feed::quantise::quantise_rad;
use feed::simulation;
use feed::simulation::{PairReport, Phase, Place, Visit};
use geometry::frame::Frame;
use geometry::mesh::{Bounds, Mesh};
use wheel::channel::Surface;
use wheel::electrode::EntrySide;

/// A five-axis path of 121 rows over 60 mm, rounded, in a turned and shifted frame.
pub fn path() -> FeedPath {
    let rows = (0..=120).rev().map(|i| {
        let s = i as f64 * 0.5;
        let t = s / 60.0;
        let pose = Pose {
            x: -s,
            y: 6.0 * t * t * (1.0 - 0.4 * t),
            z: 1.3 * (2.2 * t).sin() * t,
            a: (0.11 * s).sin() * 0.004 - 0.21 * t * t,
            b: 0.0,
            c: 0.38 * t * t - 0.05 * t,
        };
        PathRow { node: i / 4, s, pose }
    });
    quantise_path(&FeedPath {
        frame: Frame::from_x_and_z_hint(DVec3::new(0.1, -2.0, 33.3), DVec3::new(0.3, 0.9, -0.2), DVec3::Z),
        reference_point: DVec3::new(1.25, 0.0, 117.0 / 7.0),
        spark_gap: 0.1,
        rows: rows.collect(),
    })
}

/// A certificate for `path` that holds: least clearance 0.1032 mm a fifth of the way out.
pub fn certificate(path: &FeedPath) -> Certificate {
    let clearance =
        |s: f64| 0.1032 + 0.004 * (s - 12.0).powi(2) / (1.0 + 0.02 * s) + 0.01 * (1.0 - (0.9 * (s - 12.0)).cos());
    let row = path.rows.len() - 25;
    let least = Contact {
        distance: 0.1032,
        row: row as f64,
        s: path.rows[row].s,
        pose: path.rows[row].pose,
        on_electrode: DVec3::new(3.0, -4.0, 120.0),
        on_blisk: DVec3::new(3.0, -4.1, 120.02),
        surface: Surface::HighWall,
    };
    Certificate::made_up(Findings {
        violations: Vec::new(),
        path_digest: path.digest(),
        blisk_digest: blisk_mesh().digest(),
        electrode_digest: electrode_mesh().digest(),
        required: 0.1,
        tolerance: 0.002,
        certified: 0.1015,
        least,
        row_clearance: path.rows.iter().map(|r| clearance(r.s)).collect(),
        row_surface: vec![Surface::HighWall; path.rows.len()],
        ends_right: true,
        travel: TravelVerdict::Within,
        pair_intervals: 123_456,
    })
}

/// The box around the electrode of [`path`], in W.
pub fn electrode_bounds() -> Bounds {
    Bounds { min: DVec3::new(-18.0, -9.0, 88.0), max: DVec3::new(20.0, 11.0, 131.0) }
}

/// A blisk that nothing but its digest is taken of.
pub fn blisk_mesh() -> Mesh {
    Mesh::cuboid(DVec3::new(30.0, 250.0, 250.0))
}

/// An electrode that fills [`electrode_bounds`].
pub fn electrode_mesh() -> Mesh {
    let Bounds { min, max } = electrode_bounds();
    Mesh::cuboid(max - min).mapped(|p| p + min)
}

/// [`path`] approved on its [`certificate`].
pub fn approved() -> Approved {
    let path = path();
    let certificate = certificate(&path);
    Approved::new(path, certificate, &blisk_mesh(), &electrode_mesh()).unwrap()
}

/// A copying motion at the end of [`path`], certified, with what the verifier found changed by `change`.
pub fn copying(change: impl Fn(&mut Findings)) -> CopyingMotion {
    let row = |a: f64, z: f64| PathRow { node: 0, s: 0.0, pose: Pose { a, z, ..Pose::FINAL } };
    let turn = 1.2f64;
    let rows = vec![row(0.0, 0.0), row(-turn.to_radians(), 0.0), row(0.0, 0.0), row(0.0, 0.5), row(0.0, 0.0)];
    let path = quantise_path(&FeedPath { rows, ..self::path() });
    let mut findings = certificate(&self::path()).into_findings();
    findings.path_digest = path.digest();
    findings.row_clearance.truncate(path.rows.len());
    findings.row_surface.truncate(path.rows.len());
    findings.ends_right = false;
    change(&mut findings);
    let wanted = CopyingExtent { low: turn.to_radians(), high: 0.0, outwards: 0.5 };
    let turns = vec![Turn { z: 0.0, a: -turn.to_radians() }];
    CopyingMotion { path, certificate: Certificate::made_up(findings), wanted, reached: wanted, turns }
}

/// What was found of the whole motion of [`path`] in two channels, 6 degrees apart: down 20 mm, 10 mm in, and the feed.
pub fn simulation() -> simulation::Findings {
    let (path, electrode) = (path(), electrode_mesh());
    let first = path.rows[0].pose;
    let clear = Pose { x: first.x - 10.0, z: first.z + 20.0, ..first };
    let least = Place {
        distance: 2.0,
        phase: Phase::Approach,
        channel: 3,
        row: 1.0,
        pose: first,
        on_moving: DVec3::ZERO,
        on_fixed: DVec3::X,
    };
    simulation::Findings {
        path_digest: path.digest(),
        copying_digest: None,
        blisk_digest: blisk_mesh().digest(),
        electrode_digest: electrode.digest(),
        model_digest: MachineModel::default().digest(),
        with_bodies: true,
        body_clearance_mm: 1.0,
        enters_from: EntrySide::PlusX,
        approach: vec![clear, Pose { z: first.z, ..clear }, first],
        visits: vec![Visit { channel: 3, turn: 0.0 }, Visit { channel: 4, turn: quantise_rad(6f64.to_radians()) }],
        out_of_reach: vec![],
        pairs: vec![PairReport {
            moving: "electrode".to_owned(),
            fixed: "blisk".to_owned(),
            during: Some("moves outside"),
            required: 1.0,
            certified: 1.99,
            least,
            contact: None,
        }],
        travel: None,
        minutes: 1.0,
        period_error: Some(0.0),
        bodies: vec![],
    }
}
