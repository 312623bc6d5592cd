//! The job file of a plan: its electrodes with their certified motions in every channel.

use super::burning::{BurningElectrode, WheelBurning};
use super::outcome::{ElectrodeOutcome, PlanOutcome};
use crate::workspaces::blisk::document::choice::MeshFrame;
use crate::workspaces::blisk::document::job_file::PlanJob;
use feed::certificate::Certificate;
use feed::copying::Copying;
use feed::path::PathRow;
use files::Params as _;
use geometry::mesh::unit_normal;
use glam::DVec3;
use nc::job_file::{
    FORMAT, FileEntry, JobElectrode, JobFile, JobTechnology, Location, Operation, OperationKind, Position, Workpiece,
    WorkpieceKind,
};
use nc::measuring_points::{MeasuringPoint, measuring_points};
use wheel::channel::{Channel, Surface};
use wheel::electrode::{Electrode, ElectrodeFace};

/// The job of the electrodes of `outcome`, of which `files` are written. Positions are those of W, in which every electrode
/// ends in the same pose; in other channels A is turned.
pub fn job_of_plan(
    outcome: &PlanOutcome,
    job: &PlanJob,
    burning: Option<&WheelBurning>,
    files: &[(String, Vec<u8>)],
) -> JobFile {
    let channel = &outcome.channel;
    let certificates =
        outcome.electrodes.iter().filter_map(|e| Some(&e.plan.path.as_ref()?.certificate)).filter(|c| c.holds());
    let electrodes = outcome.electrodes.iter().enumerate();
    let electrodes = electrodes.map(|own| electrode(own, outcome, job, burning, files)).collect();
    JobFile {
        format: FORMAT.to_owned(),
        program_version: env!("CARGO_PKG_VERSION").to_owned(),
        workpiece: Workpiece {
            id: "W1".to_owned(),
            name: job.part(),
            kind: WorkpieceKind::Wheel,
            channels: Some(channel.blades),
            axes: "W: X along the axis, Z along the radius through the channel of the plan".to_owned(),
            origin_mm: channel.frame.origin.to_array(),
            x_axis: channel.frame.x.to_array(),
            z_axis: channel.frame.z.to_array(),
            mesh_sha256: certificates.map(|c| c.blisk_digest().to_owned()).next(),
        },
        electrodes,
    }
}

fn electrode(
    (index, own): (usize, &ElectrodeOutcome),
    outcome: &PlanOutcome,
    job: &PlanJob,
    burning: Option<&WheelBurning>,
    files: &[(String, Vec<u8>)],
) -> JobElectrode {
    let (number, id) = (index + 1, format!("E{}", index + 1));
    let stem = format!("electrode_{number}.");
    let of_electrode = files.iter().filter(|(name, _)| name == &format!("{stem}stl") || name == &format!("{stem}step"));
    let burning = burning.and_then(|burning| burning.electrodes.get(index));
    let stage = job.electrode.stage_of(index).map(|stage| stage.name.clone());
    let gap = job.electrode.burned_gap_mm(index);
    let (job, _) = &job.of_electrode(index);
    let undersize = job.electrode.spark_gap_mm;
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
    let [x_mm, y_mm, z_mm, c] = own.preset.map_or([0.0; 4], |preset| preset.zero());
    let position = Position { x_mm, y_mm, z_mm, c_deg: c.to_degrees(), ..Position::default() };
    let location = |(k, (channel, turn)): (usize, (usize, f64))| {
        let id = format!("{id}.L{}", k + 1);
        Location {
            channel: Some(channel),
            position: Position { a_deg: Some(turn.to_degrees()), b_deg: Some(0.0), ..position },
            pose: None,
            approach: approach(own),
            depth_mm: None,
            retract_mm: None,
            operations: operations(&id, (index, own), outcome, burning, files),
            id,
        }
    };
    JobElectrode {
        name: format!("electrode {number}"),
        files: of_electrode.map(|(name, bytes)| FileEntry::of(name, bytes)).collect(),
        axes: match job.export.frame {
            MeshFrame::Mesh => "those of the workpiece's file, with the electrode in its final pose".to_owned(),
            MeshFrame::W => "W, with the electrode in its final pose".to_owned(),
        },
        is_undersized: true,
        material: None,
        stage,
        quantity: None,
        needed: burning.map_or_else(|| "not known".to_owned(), BurningElectrode::needed_text),
        spark_gap_mm: gap,
        undersize_wall_mm: undersize,
        undersize_floor_mm: undersize,
        orbit: None,
        technology,
        inspection_points: inspection_points(&own.electrode, &outcome.channel, job.export.frame),
        end_wear_mm: burning.and_then(|of| of.figures.end_wear_mm),
        locations: visits.into_iter().enumerate().map(location).collect(),
        id,
    }
}

/// Points of the base and of the burning faces of an electrode on its holder, in the axes of its files. The face of the base that
/// lies on the holder is out of reach.
fn inspection_points(electrode: &Electrode, channel: &Channel, frame: MeshFrame) -> Vec<MeasuringPoint> {
    let outwards = electrode.enters_from.direction();
    let is_reached = |(face, corners): (&ElectrodeFace, [DVec3; 3])| {
        face.burns() || (*face == ElectrodeFace::Holder && unit_normal(corners).dot(outwards) < ON_HOLDER)
    };
    let mut measured: Vec<ElectrodeFace> = Vec::new();
    let mut surface_of = Vec::with_capacity(electrode.faces.len());
    for (face, corners) in electrode.faces.iter().zip(electrode.mesh.iter_corners()) {
        surface_of.push(is_reached((face, corners)).then(|| {
            measured.iter().position(|of| of == face).unwrap_or_else(|| {
                measured.push(*face);
                measured.len() - 1
            })
        }));
    }
    let names: Vec<&str> = measured.iter().map(|&face| face_name(face, channel)).collect();
    let mesh = match frame {
        MeshFrame::Mesh => &electrode.mesh.in_parent_of(&channel.frame),
        MeshFrame::W => &electrode.mesh,
    };
    measuring_points(mesh, &names, &surface_of, POINTS)
}

/// Points of a face.
const POINTS: usize = 9;
/// Cosine of the angle to the direction of withdrawal within which a face of the base lies on the holder.
const ON_HOLDER: f64 = 0.9;

/// Name of a face.
pub fn face_name(face: ElectrodeFace, channel: &Channel) -> &'static str {
    match face {
        ElectrodeFace::LowWall => channel.surface_name(Surface::LowWall),
        ElectrodeFace::HighWall => channel.surface_name(Surface::HighWall),
        ElectrodeFace::HubSide => "hub side",
        ElectrodeFace::ShroudSide => "shroud side",
        ElectrodeFace::Division => "division",
        ElectrodeFace::FarEnd => "far end",
        ElectrodeFace::EntryEnd => "shoulder",
        ElectrodeFace::Shank => "shank",
        ElectrodeFace::Holder => "base",
    }
}

/// Unit vector along which the certified feed of an electrode ends, in the axes of W.
fn approach(of: &ElectrodeOutcome) -> Option<[f64; 3]> {
    let planned = of.plan.path.as_ref().filter(|planned| planned.certificate.holds())?;
    let [.., before, last] = &planned.path.rows[..] else { return None };
    let place = |row: &PathRow| DVec3::new(row.pose.x, row.pose.y, row.pose.z);
    let along = (place(last) - place(before)).try_normalize()?;
    Some(along.to_array().map(|v| v + 0.0))
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
