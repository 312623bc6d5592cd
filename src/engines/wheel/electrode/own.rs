//! An electrode from the user's own mesh.

use glam::{DVec2, DVec3};

use super::boundary::components;

use super::measure::{burn_area, in_batches, least_thickness, reference_point, surface_distance};
use super::{Electrode, ElectrodeError, ElectrodeFace, EntrySide};
use crate::channel::Channel;
use geometry::exact::ExactMesh;
use geometry::inside::guarded_distance;
use geometry::mesh::{Mesh, unit_normal};
use task::Cancel;

/// Electrode of `channel` from a user's mesh in its final pose in W.
///
/// Faces are classified by position and normal: those past the blades' edges at the mouth belong to the shank, the others
/// to the wall, end wall or end that their normals point to. The closest distance to the blisk is exact; one below
/// `spark_gap_mm` is accepted and reported in `assumed`.
///
/// # Errors
/// When the passage does not open to that side, and when the mesh is open, inside out, or touches or crosses the blisk.
pub fn from_user_mesh(
    mesh: Mesh,
    channel: &Channel,
    blisk: &ExactMesh,
    spark_gap_mm: f64,
    side: EntrySide,
    cancel: &Cancel,
) -> Result<Electrode, ElectrodeError> {
    let is_last = side.mouth(channel)?;
    if !mesh.is_watertight() {
        return Err(ElectrodeError::NotWatertight);
    }
    let volume_mm3 = mesh.volume();
    if volume_mm3.is_nan() || volume_mm3 <= 0.0 {
        return Err(ElectrodeError::InsideOut(volume_mm3));
    }
    let clearance_mm = clearance(&mesh, blisk, cancel)?;
    let mut assumed = vec![
        "The electrode is the user's own mesh, taken as it is: no gap or reduction was applied to it.".to_owned(),
        format!("In its final pose it is {clearance_mm:.4} mm from the finished blisk."),
    ];
    if clearance_mm < spark_gap_mm {
        assumed.push(format!("That is less than the spark gap of {spark_gap_mm:.4} mm: it would cut too deep."));
    }
    let span = channel.span_along();
    let faces: Vec<_> = mesh.iter_corners().map(|corners| kind(corners, channel, (span, is_last))).collect();
    Ok(Electrode {
        enters_from: side,
        reference_point: reference_point(&mesh, &faces, side, channel.flow),
        stage: None,
        part: 0,
        parts: 1,
        column: None,
        least_thickness_mm: least_thickness(&mesh, &faces, cancel)?,
        volume_mm3,
        burn_area_mm2: burn_area(&mesh, &faces),
        undersize_mm: spark_gap_mm,
        clearance_mm,
        assumed,
        faces,
        patches: Vec::new(),
        mesh,
    })
}

/// The exact distance between the two surfaces, if they are apart and neither is inside the other.
fn clearance(mesh: &Mesh, blisk: &ExactMesh, cancel: &Cancel) -> Result<f64, ElectrodeError> {
    let vertices = in_batches(mesh.vertices.len(), cancel, |i| guarded_distance(blisk, mesh.vertices[i]))?;
    if vertices.iter().any(|d| d.is_nan() || *d <= 0.0) {
        return Err(ElectrodeError::Interferes);
    }
    let known = vertices.into_iter().fold(f64::INFINITY, f64::min);
    let distance = surface_distance(mesh, blisk, known, cancel)?.map_or(known, |points| points.distance);
    if distance > 0.0 { Ok(distance) } else { Err(ElectrodeError::Interferes) }
}

/// The kind of a face. `from` and `to` are the blades' edges along the passage (mm); the electrode enters at `to` if
/// `is_last`, else at `from`.
fn kind(corners: [DVec3; 3], channel: &Channel, ([from, to], is_last): ([f64; 2], bool)) -> ElectrodeFace {
    let center = corners.iter().sum::<DVec3>() / 3.0;
    let place = DVec2::new(center.x, center.y.hypot(center.z));
    let edge = channel.line_at(if is_last { to } else { from });
    let out = if is_last { 1.0 } else { -1.0 };
    let beyond = out * (place - edge.place(0.0)).dot(channel.across(&edge));
    if beyond > 0.05 * (to - from) {
        return ElectrodeFace::Shank;
    }
    let normal = unit_normal(corners);
    let [along, _] = channel.along_and_height(place);
    let line = channel.line_at(along.clamp(from, to));
    let [across, around] = components(center, line.up, normal);
    let [forward, _] = components(center, channel.across(&line), normal);
    // Walls run mostly along the passage, so that only faces nearly across it are ends.
    if forward.abs() > 0.95 {
        return if forward * out > 0.0 { ElectrodeFace::EntryEnd } else { ElectrodeFace::FarEnd };
    }
    match (across.abs() > around.abs(), across > 0.0, around > 0.0) {
        (true, true, _) => ElectrodeFace::ShroudSide,
        (true, false, _) => ElectrodeFace::HubSide,
        (false, _, true) => ElectrodeFace::HighWall,
        (false, _, false) => ElectrodeFace::LowWall,
    }
}
