//! A made-up path, certificate and report for the tests of this floor.

use glam::DVec3;

use super::approved::Approved;
use super::choice::MeshFrame;
use super::quantise::quantise_path;
use super::report::*;
use crate::blisk::channel::Surface;
use crate::blisk::electrode::EntrySide;
use crate::feed::certificate::{Certificate, Contact, Findings, TravelVerdict};
use crate::feed::copying::{CopyingExtent, CopyingMotion, Turn};
use crate::feed::machine_model::MachineModel;
use crate::feed::path::{FeedPath, PathRow};
use crate::feed::pose::{Axis, Pose};
use crate::feed::quantise::quantise_rad;
use crate::feed::simulation::{self, PairReport, Phase, Place, Visit};
use crate::feed::smoothness::AxisSmoothness;
use crate::geometry::frame::Frame;
use crate::geometry::mesh::tests::cuboid;
use crate::geometry::mesh::{Bounds, Mesh};

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
pub(crate) fn electrode_bounds() -> Bounds {
    Bounds { min: DVec3::new(-18.0, -9.0, 88.0), max: DVec3::new(20.0, 11.0, 131.0) }
}

/// A blisk that nothing but its digest is taken of.
pub(crate) fn blisk_mesh() -> Mesh {
    cuboid(DVec3::new(30.0, 250.0, 250.0))
}

/// An electrode that fills [`electrode_bounds`].
pub(crate) fn electrode_mesh() -> Mesh {
    let Bounds { min, max } = electrode_bounds();
    cuboid(max - min).mapped(|p| p + min)
}

/// [`path`] approved on its [`certificate`].
pub(crate) fn approved() -> Approved {
    let path = path();
    let certificate = certificate(&path);
    Approved::new(path, certificate, &blisk_mesh(), &electrode_mesh()).unwrap()
}

/// A copying motion at the end of [`path`], certified, with what the verifier found changed by `change`.
pub(crate) fn copying(change: impl Fn(&mut Findings)) -> CopyingMotion {
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
pub(crate) fn simulation() -> simulation::Findings {
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

/// A report on one electrode that comes out and one that jams.
pub(crate) fn report() -> Report {
    let (path, stage) = (path(), |stage: &str, seconds| StageTime { stage: stage.to_owned(), seconds });
    Report {
        schema: SCHEMA,
        program_version: "0.1.0".to_owned(),
        verdict: Verdict {
            exit_code: 3,
            sentence: "1 of 2 electrodes has a verified path; electrode 2 jams.".to_owned(),
        },
        inputs: vec![InputFile {
            role: "blisk".to_owned(),
            path: "/home/eng/parts/turbine 60 <rev B>.stl".to_owned(),
            sha256: "9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08".to_owned(),
            triangles: 184_320,
            unit: "mm".to_owned(),
            unit_reason: "a diameter of 268 is a blisk in mm, not in inches".to_owned(),
            repairs: vec!["merged 12 duplicate vertices".to_owned()],
        }],
        blisk: blisk(path.frame),
        parameters: serde_json::json!({
            "blisk": {"mesh": "turbine60.stl", "units": "mm", "axis": "auto"},
            "electrode": {"spark_gap_mm": 0.1, "circumferential_reduction_deg": [1.03, 1.03], "parts": 1},
            "genetic": {"population": 60, "generations": 80, "seed": 1},
        }),
        symbols: symbols(),
        electrodes: vec![verified(&path), jammed()],
        leftover: None,
        no_leftover: None,
        written: Written {
            electrode_frame: MeshFrame::W,
            post: "beckhoff-edm".to_owned(),
            files: ["electrode_1.stl", "path_1.csv", "report.json"].map(str::to_owned).to_vec(),
            not_asked_for: vec!["nc", "pictures"],
        },
        times: vec![
            stage("read and mend", 0.41),
            stage("channel", 1.62),
            stage("distance field", 9.83),
            stage("search", 41.7),
            stage("verification", 17.35),
            stage("export", 0.09),
        ],
        pictures: vec![],
        no_pictures: None,
    }
}

fn blisk(frame: Frame) -> BliskSummary {
    BliskSummary {
        blades: 60,
        channel: 0,
        shrouded: true,
        frame,
        hub_radius_mm: [96.0, 98.4],
        shroud_radius_mm: [128.0, 130.1],
        span_x_mm: [-17.2, 18.9],
        throat_mm: 4.318,
        turning_deg: 61.3,
        low_wall: "suction wall".to_owned(),
        high_wall: "pressure wall".to_owned(),
        assumed: vec!["The +X side is the one nearest to the mesh's +Z.".to_owned()],
    }
}

fn symbols() -> Vec<Symbol> {
    let rows = [
        ("δ", "spark gap", "0.10", "mm"),
        ("Δ1, Δ2", "circumferential reductions", "1.03, 1.03", "°"),
        ("a3 | b3", "weights of smoothness and centring", "0.80 | 0.20", ""),
        ("N", "bits per variable (8)", "11", ""),
    ];
    let symbol = |[symbol, meaning, value, unit]: [String; 4]| Symbol { symbol, meaning, value, unit };
    rows.map(|(a, b, c, d)| symbol([a, b, c, d].map(str::to_owned))).to_vec()
}

fn verified(path: &FeedPath) -> ElectrodeReport {
    let certificate = certificate(path);
    let nodes = path.rows.iter().enumerate().rev().step_by(4).map(|(i, r)| NodeReport {
        node: r.node,
        s_mm: r.s,
        pose: PoseReport::from(&r.pose),
        clearance_mm: certificate.row_clearance()[i],
        distances_mm: None,
        objective: Some(ObjectiveReport {
            smoothness: 0.02 + 0.001 * r.s,
            centring: 0.11,
            total: 0.038 + 0.0008 * r.s,
        }),
    });
    let falling = |node: usize, floor: f64| {
        (0..80).map(|g| floor + (0.5 + 0.01 * node as f64) * (-0.07 * g as f64).exp()).collect()
    };
    let nodes: Vec<_> = nodes.collect();
    ElectrodeReport {
        index: 1,
        share: "part 1 of 2".to_owned(),
        copying: None,
        simulation: None,
        enters_from: "-x".to_owned(),
        extractable: true,
        verified: true,
        required_clearance_mm: certificate.required(),
        tolerance_mm: certificate.tolerance(),
        certified_clearance_mm: Some(certificate.certified()),
        least_clearance_mm: Some(certificate.least().distance),
        least_clearance_at: Some(ClearancePlace::of(certificate.least(), "pressure wall")),
        smoothness: Smoothness::of(&Axis::ALL.map(|axis| {
            let in_file_units = |v: f64| if axis.is_rotary() { v.to_degrees() } else { v };
            AxisSmoothness::of(&path.rows.iter().map(|r| in_file_units(r.pose.get(axis))).collect::<Vec<_>>())
        })),
        volume_mm3: 8431.7,
        least_thickness_mm: Some(1.84),
        burn_area_mm2: Some(3127.0),
        ga_convergence: nodes
            .iter()
            .map(|n| Convergence { node: n.node, best: falling(n.node, 0.04), mean: falling(n.node + 25, 0.09) })
            .collect(),
        nodes,
        failure: None,
        feed_lowered: Some(FeedLowered { blocks: 12, of_blocks: 240, least_share: 0.43, axis: 'A' }),
        sha256: Some(VerifiedDigests::of(&certificate)),
        files: ["electrode_1.stl", "path_1.csv", "path_1.nc"].map(str::to_owned).to_vec(),
        motion: Some(Motion { rows: path.rows.clone(), clearance: certificate.row_clearance().to_vec() }),
    }
}

fn jammed() -> ElectrodeReport {
    ElectrodeReport {
        index: 2,
        enters_from: "+x".to_owned(),
        required_clearance_mm: 0.1,
        tolerance_mm: 0.002,
        volume_mm3: 8790.2,
        failure: Some(Failure {
            node: 14,
            s_mm: 7.02,
            wall: Some("suction wall & hub".to_owned()),
            place: Some([-8.31, 1.442, 101.07]),
            sentence: "After 7.02 mm the electrode has no free pose: it is held between the suction wall and the hub. \
                       About 0.2° more circumferential reduction, or entering from -x, would open the way."
                .to_owned(),
        }),
        files: vec!["electrode_2.stl".to_owned()],
        ..ElectrodeReport::default()
    }
}
