//! The job file of a plan: its electrodes with their certified motions in every channel.

use super::burning::{BurningElectrode, WheelBurning};
use super::outcome::{ElectrodeOutcome, PlanOutcome};
use crate::workspaces::blisk::document::job_file::PlanJob;
use burning::wear::WearShare;
use feed::certificate::Certificate;
use feed::copying::Copying;
use files::Params as _;
use nc::job_file::{
    FORMAT, FileEntry, JobElectrode, JobFile, JobTechnology, Location, Operation, OperationKind, Position, Workpiece,
    WorkpieceKind,
};

/// The job of the electrodes of `outcome`, of which `files` are written. Positions are those of W, in which every electrode
/// ends in the same pose; in other channels A is turned.
pub fn job_of_plan(
    outcome: &PlanOutcome,
    job: &PlanJob,
    burning: Option<&WheelBurning>,
    files: &[(String, Vec<u8>)],
) -> JobFile {
    let channel = &outcome.channel;
    let certificates = outcome.electrodes.iter().filter_map(|e| Some(&e.plan.path.as_ref()?.certificate));
    let electrodes = (0..outcome.electrodes.len()).map(|i| electrode(i, outcome, job, burning, files));
    JobFile {
        format: FORMAT,
        program_version: env!("CARGO_PKG_VERSION"),
        workpiece: Workpiece {
            id: "W1".to_owned(),
            name: job.part(),
            kind: WorkpieceKind::Wheel,
            channels: Some(channel.blades),
            axes: "W: X along the axis, Z along the radius through the channel of the plan".to_owned(),
            origin_mm: channel.frame.origin.to_array(),
            x_axis: channel.frame.x.to_array(),
            z_axis: channel.frame.z.to_array(),
            sha256: certificates.map(|c| c.blisk_digest().to_owned()).next(),
        },
        electrodes: electrodes.collect(),
    }
}

fn electrode(
    index: usize,
    outcome: &PlanOutcome,
    job: &PlanJob,
    burning: Option<&WheelBurning>,
    files: &[(String, Vec<u8>)],
) -> JobElectrode {
    let (number, id) = (index + 1, format!("E{}", index + 1));
    let own = outcome.electrodes.get(index);
    let stem = format!("electrode_{number}.");
    let of_electrode = files.iter().filter(|(name, _)| name == &format!("{stem}stl") || name == &format!("{stem}step"));
    let burning = burning.and_then(|burning| burning.electrodes.get(index));
    let gap = job.electrode.spark_gap_mm;
    let last_step = Some(job.burning.last_step.trim()).filter(|step| !step.is_empty()).map(str::to_owned);
    let finish_vdi = job.burning.finish_vdi.filter(|_| last_step.is_none());
    let technology = (last_step.is_some() || finish_vdi.is_some()).then(|| JobTechnology {
        table: job.technology.table.clone(),
        id: job.technology.id.clone(),
        last_step,
        finish_vdi,
    });
    let visits = match outcome.simulation(index) {
        Some(simulation) => simulation.visits().iter().map(|visit| (visit.channel, visit.turn)).collect(),
        None => vec![(outcome.channel.index, 0.0)],
    };
    let location = |(k, (channel, turn)): (usize, (usize, f64))| {
        let id = format!("{id}.L{}", k + 1);
        Location {
            channel: Some(channel),
            position: Position { a_deg: turn.to_degrees(), ..Position::default() },
            // It is withdrawn towards the side that it enters from.
            approach: own.map_or([0.0; 3], |e| (-e.electrode.enters_from.direction()).to_array().map(|v| v + 0.0)),
            depth_mm: None,
            retract_mm: None,
            operations: own.map_or_else(Vec::new, |e| operations(&id, (index, e), outcome, burning, files)),
            id,
        }
    };
    JobElectrode {
        name: format!("electrode {number}"),
        files: of_electrode.map(|(name, bytes)| FileEntry::of(name, bytes)).collect(),
        material: None,
        stage: None,
        quantity: burning.filter(|of| is_wear_known(of)).and_then(|of| of.copies),
        spark_gap_mm: gap,
        undersize_wall_mm: gap,
        undersize_floor_mm: gap,
        orbit: None,
        technology,
        end_wear_mm: burning.and_then(|of| of.figures.end_wear_mm),
        locations: visits.into_iter().enumerate().map(location).collect(),
        id,
    }
}

/// Whether the wear tells how many electrodes are needed.
fn is_wear_known(of: &BurningElectrode) -> bool {
    !matches!(of.figures.wear_share, WearShare::Unknown { .. })
}

/// The certified motions of an electrode, feed and copying.
fn operations(
    location: &str,
    (index, of): (usize, &ElectrodeOutcome),
    outcome: &PlanOutcome,
    burning: Option<&BurningElectrode>,
    files: &[(String, Vec<u8>)],
) -> Vec<Operation> {
    let number = index + 1;
    let feed = of.plan.path.as_ref().map(|planned| &planned.certificate).filter(|c| c.holds());
    let copying = outcome.copying(index).and_then(Copying::certified).map(|motion| &motion.certificate);
    let figures = burning.map(|of| &of.figures);
    let operation = |(k, (kind, name, certificate)): (usize, (OperationKind, String, &Certificate))| {
        // What is removed is known of both motions together.
        let figures = figures.filter(|_| kind == OperationKind::Feed);
        Operation {
            id: format!("{location}.O{}", k + 1),
            kind,
            path: files.iter().find(|(file, _)| *file == name).map(|(name, bytes)| FileEntry::of(name, bytes)),
            path_sha256: Some(certificate.path_digest().to_owned()),
            certified_clearance_mm: Some(certificate.certified()),
            volume_mm3: figures.and_then(|figures| figures.volume_mm3),
            minutes: figures.and_then(|figures| figures.minutes).map(|minutes| minutes.mean),
        }
    };
    let feed = feed.map(|c| (OperationKind::Feed, format!("path_{number}.csv"), c));
    let copying = copying.map(|c| (OperationKind::Copying, format!("copying_{number}.csv"), c));
    let both = feed.into_iter().chain(copying.filter(|_| of.plan.is_verified()));
    both.enumerate().map(operation).collect()
}
