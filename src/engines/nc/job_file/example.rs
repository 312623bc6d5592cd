//! Jobs that templates are tried on before there is one.

use super::{
    FORMAT, FileEntry, JobElectrode, JobFile, JobOrbit, JobTechnology, Location, Operation, OperationKind, Position,
    Workpiece, WorkpieceKind,
};
use crate::measuring_points::MeasuringPoint;
use crate::template::Templated;

const UNTURNED: [[f64; 4]; 4] =
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

impl Templated for JobFile {
    const FILE: &'static str = "job.json";
    const SHEET: &'static str = "job sheet";
    const STANDARD: &'static str = include_str!("../../../../assets/job_sheet.jinja");

    /// A wheel of which everything is known that can be, and a mold of which nothing is known that may be unknown.
    fn examples() -> Vec<Self> {
        [(WorkpieceKind::Wheel, true), (WorkpieceKind::Mold, false)]
            .map(|(kind, has_all)| example(kind, has_all))
            .into()
    }
}

fn example(kind: WorkpieceKind, has_all: bool) -> JobFile {
    let digest = || has_all.then(|| files::sha256(b""));
    let word = |word: &str| has_all.then(|| word.to_owned());
    let file = |name: &str| FileEntry::of(name, b"");
    let operation = |k: usize, kind| Operation {
        id: format!("E1.L1.O{k}"),
        kind,
        path: has_all.then(|| file("path_1.csv")),
        path_sha256: digest(),
        certified_clearance_mm: has_all.then_some(0.099),
        volume_mm3: has_all.then_some(350.0),
        minutes: has_all.then_some(62.5),
    };
    let operations = match has_all {
        true => vec![operation(1, OperationKind::Feed), operation(2, OperationKind::Copying)],
        false => vec![operation(1, OperationKind::Sink)],
    };
    let location = Location {
        id: "E1.L1".to_owned(),
        channel: has_all.then_some(0),
        position: Position {
            x_mm: 12.3457,
            y_mm: -4.5,
            z_mm: 20.0,
            a_deg: has_all.then_some(6.0),
            b_deg: has_all.then_some(0.0),
            c_deg: 90.0,
        },
        pose: has_all.then_some(UNTURNED),
        approach: has_all.then_some([0.0, 0.0, -1.0]),
        depth_mm: has_all.then_some(7.25),
        retract_mm: has_all.then_some(30.0),
        operations,
    };
    let technology = || JobTechnology {
        table: "built-in".to_owned(),
        id: "steel-copper".to_owned(),
        last_step: Some("S1".to_owned()),
        finish_vdi: Some(24.0),
    };
    let point = || MeasuringPoint {
        surface: "base".to_owned(),
        point_mm: [1.0, 2.0, 3.0],
        normal: [0.0, 0.0, 1.0],
        ball_radius_mm: 1.0,
    };
    let electrode = JobElectrode {
        id: "E1".to_owned(),
        name: "E01".to_owned(),
        files: if has_all { vec![file("electrode_1.stl")] } else { Vec::new() },
        axes: "those of the workpiece".to_owned(),
        is_undersized: true,
        material: word("copper"),
        stage: word("finish"),
        quantity: has_all.then_some(2),
        needed: "not known".to_owned(),
        spark_gap_mm: 0.05,
        undersize_wall_mm: 0.15,
        undersize_floor_mm: 0.05,
        orbit: has_all.then(|| JobOrbit { pattern: "circular".to_owned(), radius_mm: 0.1 }),
        technology: has_all.then(technology),
        end_wear_mm: has_all.then_some(0.01),
        inspection_points: has_all.then(point).into_iter().collect(),
        locations: vec![location],
    };
    JobFile {
        format: FORMAT.to_owned(),
        program_version: env!("CARGO_PKG_VERSION").to_owned(),
        workpiece: Workpiece {
            id: "W1".to_owned(),
            name: "example".to_owned(),
            kind,
            channels: has_all.then_some(60),
            axes: "those of the datum".to_owned(),
            origin_mm: [0.0; 3],
            x_axis: [1.0, 0.0, 0.0],
            z_axis: [0.0, 0.0, 1.0],
            mesh_sha256: digest(),
        },
        electrodes: vec![electrode],
    }
}
