//! Check of a file: it is read again by this crate's own reader and compared with the mesh.

use geometry::exact::ExactMesh;
use geometry::mesh::Mesh;
use geometry::segmentation::FaceKind;
use glam::DVec3;
use rayon::prelude::*;
use task::Task;

use super::StepWriteError;
use crate::error::StepError;
use crate::read;

/// Distances by which a file may be off.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    /// Greatest distance that the triangles of the file that is read may leave its faces by (mm).
    pub(super) chord: f64,
    /// Distance by which a file may leave the mesh at any place, beside that (mm).
    pub(super) deviation: f64,
}

/// Share by which the volume of a file may differ from that of the mesh.
const MOST_VOLUME: f64 = 5e-4;
/// Places between two looks at the flag that cancels.
const BLOCK: usize = 4096;

/// Distances and volume of a file beside its mesh.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Measures {
    /// Greatest distance from a vertex or triangle centre of the mesh to the file (mm).
    pub(super) mesh_to_file: f64,
    /// Greatest distance of the file outside and inside of the mesh (mm).
    pub(super) file_to_mesh: [f64; 2],
    /// Distance by which the triangles that were compared may leave the file's faces (mm).
    pub(super) unsure: f64,
    /// Place of the greatest distance (mm).
    pub(super) at: DVec3,
    /// Volume of the file's solids (mm^3).
    pub(super) volume: f64,
    /// Places of the file outside of the mesh, each with its distance (mm).
    pub(super) beyond: Vec<(f64, DVec3)>,
}

/// Reads a file of so many solids and compares it with the mesh that it was made from.
pub(super) fn check(
    bytes: &[u8],
    mesh: &Mesh,
    solids: usize,
    Limits { chord, deviation: most }: Limits,
    task: &Task,
) -> Result<Measures, StepWriteError> {
    let options = read::Options { chord, ..read::Options::default() };
    let bad = |problem: String| StepWriteError::Reread { problem, at: None };
    let file = read::read(bytes, &options, task).map_err(|error| match error {
        StepError::Cancelled(cancelled) => StepWriteError::Cancelled(cancelled),
        other => bad(other.to_string()),
    })?;
    if file.solids.len() != solids {
        return Err(bad(format!("{} solids instead of {solids}", file.solids.len())));
    }
    for solid in &file.solids {
        if let Some(fault) = solid.faults.first() {
            let [x, y, z] = fault.place.to_array();
            let problem = format!("a face at ({x:.3}, {y:.3}, {z:.3}) mm cannot be read: {}", fault.problem);
            return Err(StepWriteError::Reread { problem, at: Some(fault.place) });
        }
        if !solid.is_closed() {
            return Err(bad("a solid is not closed".to_owned()));
        }
        if solid.mesh.volume() <= 0.0 {
            return Err(bad("a solid is inside out".to_owned()));
        }
    }
    let is_flat = file.solids.iter().flat_map(|s| &s.faces).all(|f| matches!(f.kind, FaceKind::Plane { .. }));
    let mut whole = Mesh::default();
    for solid in file.solids {
        let first = whole.vertices.len() as u32;
        whole.vertices.extend(solid.mesh.vertices);
        whole.triangles.extend(solid.mesh.triangles.iter().map(|t| t.map(|v| v + first)));
    }
    let mut measures = compare(mesh, &whole, task)?;
    let deviation = measures.mesh_to_file.max(measures.file_to_mesh[0]).max(measures.file_to_mesh[1]);
    let most = most + chord;
    if deviation > most {
        return Err(StepWriteError::Deviation { at: measures.at, distance: deviation, most });
    }
    let volume = mesh.volume();
    if (measures.volume / volume - 1.0).abs() > MOST_VOLUME {
        return Err(StepWriteError::Volume { file: measures.volume, mesh: volume });
    }
    measures.unsure = if is_flat { 0.0 } else { chord };
    Ok(measures)
}

fn compare(mesh: &Mesh, file: &Mesh, task: &Task) -> Result<Measures, StepWriteError> {
    let exact = |mesh: &Mesh| ExactMesh::new(mesh).map_err(|_| StepWriteError::Unusable);
    let [of_mesh, of_file] = [exact(mesh)?, exact(file)?];
    let mut found = Measures { volume: file.volume(), ..Default::default() };
    let mut worst = 0.0;
    for (distance, p) in distances(&of_file, mesh, task)? {
        found.mesh_to_file = found.mesh_to_file.max(distance.abs());
        // Where a point of the mesh lies within the file, the file reaches as far beyond the mesh.
        let side = usize::from(distance > 0.0);
        found.file_to_mesh[side] = found.file_to_mesh[side].max(distance.abs());
        if distance < 0.0 {
            found.beyond.push((-distance, p));
        }
        if distance.abs() > worst {
            (worst, found.at) = (distance.abs(), p);
        }
    }
    for (distance, p) in distances(&of_mesh, file, task)? {
        let side = usize::from(distance < 0.0);
        if distance > 0.0 {
            found.beyond.push((distance, p));
        }
        found.file_to_mesh[side] = found.file_to_mesh[side].max(distance.abs());
        if distance.abs() > worst {
            (worst, found.at) = (distance.abs(), p);
        }
    }
    Ok(found)
}

/// Signed distances of the vertices and triangle centres of a mesh from another.
fn distances(to: &ExactMesh, of: &Mesh, task: &Task) -> Result<Vec<(f64, DVec3)>, StepWriteError> {
    let centres = of.iter_corners().map(|[a, b, c]| (a + b + c) / 3.0);
    let places: Vec<DVec3> = of.vertices.iter().copied().chain(centres).collect();
    let mut found = Vec::with_capacity(places.len());
    for block in places.chunks(BLOCK) {
        task.check()?;
        found.par_extend(block.par_iter().map(|&p| (to.signed_distance(p), p)));
    }
    Ok(found)
}
