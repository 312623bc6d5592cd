//! A made-up path, certificate and report for the tests of this floor.

use glam::DVec3;

use super::quantise::quantise_path;
use crate::blisk::channel::Surface;
use crate::feed::certificate::{Certificate, Contact};
use crate::feed::path::{FeedPath, PathRow};
use crate::feed::pose::Pose;
use crate::geometry::frame::Frame;
use crate::geometry::mesh::Bounds;

/// A five-axis path of 121 rows over 60 mm, rounded, in a turned and shifted frame.
pub(crate) fn path() -> FeedPath {
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
pub(crate) fn certificate(path: &FeedPath) -> Certificate {
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
    Certificate {
        path_digest: path.digest(),
        required: 0.1,
        tolerance: 0.002,
        certified: 0.1015,
        least,
        row_clearance: path.rows.iter().map(|r| clearance(r.s)).collect(),
        row_surface: vec![Surface::HighWall; path.rows.len()],
        ends_right: true,
        pair_intervals: 123_456,
    }
}

/// The box around the electrode of [`path`], in W.
pub(crate) fn electrode_bounds() -> Bounds {
    Bounds { min: DVec3::new(-18.0, -9.0, 88.0), max: DVec3::new(20.0, 11.0, 131.0) }
}
