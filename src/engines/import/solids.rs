//! Solids and faces of files that have them.

use std::collections::HashMap;

use geometry::mesh::Mesh;
pub use geometry::segmentation::CadFaces;
use serde::Serialize;

/// A solid of a file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SolidReport {
    /// Number, from 1.
    pub number: u32,
    /// Name in the file.
    pub name: String,
    /// Whether it is part of the mesh.
    pub is_taken: bool,
    /// Whether the solid is an obstacle beside the part.
    pub is_obstacle: bool,
    /// Number of faces.
    pub faces: usize,
    /// Volume (mm^3); without meaning unless closed.
    pub volume_mm3: f64,
    /// Whether its surface is closed.
    pub is_closed: bool,
    /// Red, green and blue from 0 to 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub color: Option<[f32; 3]>,
}

/// Solids and faces as a reader found them.
#[derive(Debug, Default)]
pub(super) struct Solids {
    /// All solids of the file.
    pub list: Vec<SolidReport>,
    /// Faces of those that were taken.
    pub faces: CadFaces,
    /// Solids that are obstacles.
    pub obstacles: Mesh,
}

/// The `faces`, known for the triangles of `before`, of the triangles of `after`, its repaired form.
pub(super) fn carried(mut faces: CadFaces, before: &Mesh, after: &Mesh) -> CadFaces {
    if before.triangles.len() == after.triangles.len() && corners(before).eq(corners(after)) {
        return faces;
    }
    let of_corners: HashMap<Corners, u32> = corners(before).map(sorted).zip(faces.face_of.iter().copied()).collect();
    let mut of_vertex: HashMap<[u64; 3], u32> = HashMap::new();
    let known: Vec<Option<u32>> = corners(after)
        .map(|c| {
            let face = of_corners.get(&sorted(c)).copied();
            of_vertex.extend(face.iter().flat_map(|f| c.map(|p| (p, *f))));
            face
        })
        .collect();
    // Triangles that were turned or exchanged belong to the face beside them.
    let beside = |c: Corners| c.iter().find_map(|p| of_vertex.get(p)).copied().unwrap_or(0);
    faces.face_of = known.into_iter().zip(corners(after)).map(|(face, c)| face.unwrap_or_else(|| beside(c))).collect();
    faces
}

type Corners = [[u64; 3]; 3];

fn corners(mesh: &Mesh) -> impl Iterator<Item = Corners> + '_ {
    mesh.iter_corners().map(|c| c.map(|p| p.to_array().map(f64::to_bits)))
}

fn sorted(mut corners: Corners) -> Corners {
    corners.sort_unstable();
    corners
}
