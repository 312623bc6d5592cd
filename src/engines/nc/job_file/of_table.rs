//! The job of a mold: that of its burn table.

use super::{
    FORMAT, FileEntry, JobElectrode, JobFile, JobOrbit, JobTechnology, Location, Operation, OperationKind, Position,
    Workpiece, WorkpieceKind,
};
use crate::burn_table::{BurnEntry, BurnTable, ElectrodeEntry, ElectrodeState};
use crate::measuring_points::MeasuringPoint;
use mold::electrode::params::Shape;

impl JobFile {
    /// The job of a mold's electrodes. `files_of` gives the files of the electrode with a name, `technology_of` the technology
    /// of a stage, `points_of` the points to be measured of the electrode with a name. Electrodes that are blocked are left out.
    pub fn of_table(
        table: &BurnTable,
        files_of: impl Fn(&str) -> Vec<FileEntry>,
        technology_of: impl Fn(&str) -> Option<JobTechnology>,
        points_of: impl Fn(&str) -> Vec<MeasuringPoint>,
    ) -> Self {
        let released = table.electrodes.iter().filter(|entry| entry.state != ElectrodeState::Blocked);
        let electrode = |(i, entry): (usize, &ElectrodeEntry)| {
            let id = format!("E{}", i + 1);
            JobElectrode {
                name: entry.name.clone(),
                files: files_of(&entry.name),
                axes: "the electrode's own, with the middle of the underside of its base at the origin".to_owned(),
                is_undersized: entry.shape == Shape::Undersized,
                material: Some(entry.material.clone()),
                stage: Some(entry.stage.clone()),
                quantity: Some(entry.quantity as usize),
                needed: entry.needed.clone(),
                spark_gap_mm: entry.gap_mm,
                undersize_wall_mm: entry.undersize_wall_mm,
                undersize_floor_mm: entry.undersize_floor_mm,
                orbit: (entry.orbit.radius_mm > 0.0)
                    .then(|| JobOrbit { pattern: entry.orbit.pattern.to_owned(), radius_mm: entry.orbit.radius_mm }),
                technology: technology_of(&entry.stage),
                inspection_points: points_of(&entry.name),
                // That of all burns is shared among them.
                end_wear_mm: entry.end_wear_mm.map(|wear| wear / entry.burns.len().max(1) as f64),
                locations: entry.burns.iter().map(|burn| location(&id, entry, burn, table.lift_mm)).collect(),
                id,
            }
        };
        let z_axis = [0, 1, 2].map(|row| table.to_file[row][2]);
        Self {
            format: FORMAT.to_owned(),
            program_version: env!("CARGO_PKG_VERSION").to_owned(),
            workpiece: Workpiece {
                id: "W1".to_owned(),
                name: table.mold.clone(),
                kind: WorkpieceKind::Mold,
                channels: None,
                axes: format!("{}, Z out of the opening", table.datum.name),
                origin_mm: table.datum.origin_mm,
                x_axis: table.datum.x_axis,
                z_axis,
                mesh_sha256: None,
            },
            electrodes: released.enumerate().map(electrode).collect(),
        }
    }
}

/// The value to six decimals.
fn rounded(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}

fn location(electrode: &str, entry: &ElectrodeEntry, burn: &BurnEntry, lift_mm: f64) -> Location {
    let id = format!("{electrode}.L{}", burn.number);
    let operation = Operation {
        id: format!("{id}.O1"),
        kind: OperationKind::Sink,
        path: None,
        path_sha256: None,
        certified_clearance_mm: None,
        volume_mm3: Some(rounded(burn.volume_mm3)),
        minutes: burn.minutes.map(rounded),
    };
    let upright = (entry.lift == [0.0, 0.0, 1.0]).then_some(0.0);
    let BurnEntry { x_mm, y_mm, z_mm, c_deg, .. } = *burn;
    Location {
        id,
        channel: None,
        position: Position { x_mm, y_mm, z_mm, a_deg: upright, b_deg: upright, c_deg },
        pose: Some(burn.pose),
        approach: Some(entry.lift.map(|v| 0.0 - v)),
        depth_mm: Some(rounded(burn.depth_mm)),
        retract_mm: Some(lift_mm),
        operations: vec![operation],
    }
}
