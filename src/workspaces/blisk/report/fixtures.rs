//! A made-up report for the tests of reports.

use feed::path::FeedPath;
use feed::pose::Axis;
use feed::smoothness::AxisSmoothness;
use geometry::frame::Frame;
pub(super) use nc::fixtures::{certificate, path};

use super::*;
use crate::workspaces::blisk::document::choice::MeshFrame;
use crate::workspaces::blisk::document::job_file::PlanJob;
use crate::workspaces::blisk::document::job_file::field_table::FIELDS;

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
            accuracy: None,
        }],
        blisk: blisk(path.frame),
        parameters: FIELDS.list(&PlanJob::for_mesh("turbine60.stl".as_ref())),
        symbols: symbols(),
        electrodes: vec![verified(&path), jammed()],
        residual_stock: None,
        no_residual_stock: None,
        burning: None,
        measured: None,
        written: Written {
            electrode_frame: MeshFrame::W,
            post: "beckhoff-edm".to_owned(),
            files: ["electrode_1.stl", "path_1.csv", "report.json"].map(str::to_owned).to_vec(),
            no_job_sheet: None,
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
        walls_mm: None,
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
        setting: None,
        simulation: None,
        enters_from: "-x".to_owned(),
        extractable: true,
        verified: true,
        required_clearance_mm: certificate.required(),
        tolerance_mm: certificate.tolerance(),
        certified_clearance_mm: Some(certificate.certified()),
        preset: None,
        preset_values: None,
        unworn_mm: None,
        longest_jump_mm: None,
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
        step: None,
        sha256: Some(VerifiedDigests::of(&certificate)),
        files: ["electrode_1.stl", "path_1.csv", "path_1.nc"].map(str::to_owned).to_vec(),
        motion: Some(Motion { rows: path.rows.clone(), clearance: certificate.row_clearance().to_vec() }),
        centroid: path.rows.iter().rev().map(|r| [r.s, r.pose.x, r.pose.y, 110.0 + r.pose.z]).collect(),
        wall_distances: vec![(0.0, Histogram::of(&[vec![0.1, 0.1, 0.11], vec![0.1, 0.12]]))],
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
