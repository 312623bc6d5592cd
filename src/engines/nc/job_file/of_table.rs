//! The job of a mold: that of its burn table.

use super::{
    FORMAT, FileEntry, JobElectrode, JobFile, JobOrbit, JobTechnology, Location, Operation, OperationKind, Position,
    Workpiece, WorkpieceKind,
};
use crate::burn_table::{BurnEntry, BurnTable, ElectrodeEntry, ElectrodeState};

impl JobFile {
    /// The job of a mold's electrodes. `files_of` tells those of an electrode by its name, `technology_of` the technology of
    /// its stage. Electrodes that are blocked are left out.
    pub fn of_table(
        table: &BurnTable,
        files_of: impl Fn(&str) -> Vec<FileEntry>,
        technology_of: impl Fn(&str) -> Option<JobTechnology>,
    ) -> Self {
        let released = table.electrodes.iter().filter(|entry| entry.state != ElectrodeState::Blocked);
        let electrode = |(i, entry): (usize, &ElectrodeEntry)| {
            let id = format!("E{}", i + 1);
            JobElectrode {
                name: entry.name.clone(),
                files: files_of(&entry.name),
                material: Some(entry.material.clone()),
                stage: Some(entry.stage.clone()),
                quantity: Some(entry.quantity as usize),
                spark_gap_mm: entry.gap_mm,
                undersize_wall_mm: entry.undersize_wall_mm,
                undersize_floor_mm: entry.undersize_floor_mm,
                orbit: (entry.orbit.radius_mm > 0.0)
                    .then(|| JobOrbit { pattern: entry.orbit.pattern.to_owned(), radius_mm: entry.orbit.radius_mm }),
                technology: technology_of(&entry.stage),
                // That of all burns is shared among them.
                end_wear_mm: entry.end_wear_mm.map(|wear| wear / entry.burns.len().max(1) as f64),
                locations: entry.burns.iter().map(|burn| location(&id, entry, burn, table.lift_mm)).collect(),
                id,
            }
        };
        let z_axis = [0, 1, 2].map(|row| table.to_file[row][2]);
        Self {
            format: FORMAT,
            program_version: env!("CARGO_PKG_VERSION"),
            workpiece: Workpiece {
                id: "W1".to_owned(),
                name: table.mold.clone(),
                kind: WorkpieceKind::Mold,
                channels: None,
                axes: format!("{}, Z out of the opening", table.datum.name),
                origin_mm: table.datum.origin_mm,
                x_axis: table.datum.x_axis,
                z_axis,
                sha256: None,
            },
            electrodes: released.enumerate().map(electrode).collect(),
        }
    }
}

/// Without what rounding leaves behind the sixth decimal.
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
    let BurnEntry { x_mm, y_mm, z_mm, c_deg, .. } = *burn;
    Location {
        id,
        channel: None,
        position: Position { x_mm, y_mm, z_mm, c_deg, ..Position::default() },
        approach: entry.lift.map(|v| 0.0 - v),
        depth_mm: Some(rounded(burn.depth_mm)),
        retract_mm: Some(lift_mm),
        operations: vec![operation],
    }
}
