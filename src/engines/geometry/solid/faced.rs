//! Unions and common parts of solids whose triangles belong to faces.

use manifold_rust::manifold::Manifold;
use manifold_rust::types::{BooleanEngine, Error, MeshGL64, OpType};

use super::{SMALLEST, SolidError, combined, given, is_same, mesh, on_grid, simplified};
use crate::mesh::Mesh;
use task::Cancel;

/// A closed surface whose triangles belong to faces.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FacedMesh {
    /// The surface.
    pub mesh: Mesh,
    /// Number of the face of each triangle.
    pub face_of: Vec<u32>,
}

/// Union of `solids`: what is left of a face keeps its number.
///
/// # Errors
/// [`SolidError::NotClosed`], [`SolidError::Failed`], and [`SolidError::Cancelled`] when cancelled.
pub fn union_of_faced(solids: &[FacedMesh], cancel: &Cancel) -> Result<FacedMesh, SolidError> {
    if solids.is_empty() {
        return Ok(FacedMesh::default());
    }
    Ok(faced(simplified(united(solids, cancel)?, SMALLEST)))
}

/// The part that two solids have in common, without triangles where there is none: what is left of a face keeps its number.
///
/// # Errors
/// [`SolidError::NotClosed`], [`SolidError::Failed`], and [`SolidError::Cancelled`] when cancelled.
pub fn common_of_faced(a: &FacedMesh, b: &FacedMesh, cancel: &Cancel) -> Result<FacedMesh, SolidError> {
    cancel.check()?;
    let common = combined(&manifold(a)?, &manifold(b)?, OpType::Intersect, BooleanEngine::Exact)?;
    Ok(faced(simplified(common, SMALLEST)))
}

fn faced(solid: Manifold) -> FacedMesh {
    let face_of = solid.get_mesh_gl64(-1).face_id.iter().map(|face| *face as u32).collect();
    FacedMesh { mesh: mesh(&solid), face_of }
}

/// The union of solids, of halves of them first, so that each takes part in few unions.
fn united(solids: &[FacedMesh], cancel: &Cancel) -> Result<Manifold, SolidError> {
    cancel.check()?;
    match solids {
        [] => Ok(Manifold::empty()),
        [solid] => manifold(solid),
        _ => {
            let (low, high) = solids.split_at(solids.len() / 2);
            combined(&united(low, cancel)?, &united(high, cancel)?, OpType::Add, BooleanEngine::Exact)
        }
    }
}

/// A faced surface as a solid. Where tidying would take corners away it is read as it is.
fn manifold(solid: &FacedMesh) -> Result<Manifold, SolidError> {
    let rounded = solid.mesh.mapped(on_grid);
    let face_id = solid.face_of.iter().map(|face| u64::from(*face)).collect();
    let faced = MeshGL64 { face_id, ..given(&rounded) };
    let tidied = Manifold::from_mesh_gl64(&faced);
    let found = if tidied.status() == Error::NoError && is_same(&tidied, &rounded) {
        tidied
    } else {
        Manifold::from_mesh_gl64_robust(&faced)
    };
    match found.status() {
        Error::NoError => Ok(found),
        error => Err(SolidError::NotClosed(error.to_str().to_owned())),
    }
}

#[cfg(test)]
mod tests {
    use glam::{DMat3, DVec3};

    use super::*;

    #[test]
    fn what_two_solids_have_in_common_has_the_faces_of_both() {
        let [a, b] = [
            block(DVec3::ZERO, DVec3::splat(2.0), 0, DMat3::IDENTITY),
            block(DVec3::ONE, DVec3::splat(2.0), 6, DMat3::IDENTITY),
        ];
        let found = common_of_faced(&a, &b, &Cancel::default()).unwrap();
        assert!(found.mesh.is_watertight() && (found.mesh.volume() - 1.0).abs() < 1e-6);
        let mut faces = found.face_of;
        faces.sort_unstable();
        faces.dedup();
        // The greater sides of the first along X, Y and Z, and the lesser sides of the second.
        assert_eq!(faces, [1, 3, 5, 6, 8, 10]);
        let apart = block(DVec3::splat(5.0), DVec3::ONE, 6, DMat3::IDENTITY);
        assert!(common_of_faced(&a, &apart, &Cancel::default()).unwrap().mesh.triangles.is_empty());
    }

    /// A box with the number of its face for each triangle, from `first` on.
    fn block(at: DVec3, size: DVec3, first: u32, turn: DMat3) -> FacedMesh {
        let mesh = Mesh::cuboid(size).mapped(|p| p + at);
        let face =
            |normal: DVec3| (0..3).find(|k| normal[*k].abs() > 0.5).map_or(6, |k| 2 * k + usize::from(normal[k] > 0.0));
        let normals = mesh.iter_corners().map(|[a, b, c]| (b - a).cross(c - a).normalize());
        let face_of = normals.map(|n| first + face(n) as u32).collect();
        FacedMesh { mesh: mesh.mapped(|p| turn * p), face_of }
    }

    /// Blocks that share a face, stand on one another with a part of it, or reach into one another, in any position.
    #[test]
    fn what_is_left_of_faces_keeps_its_number() {
        for turn in [DMat3::IDENTITY, DMat3::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 1.1)] {
            for (at, size, common) in [
                (DVec3::new(2.0, 0.0, 0.0), DVec3::new(1.0, 2.0, 2.0), 0.0),
                (DVec3::new(2.0, 0.5, 0.5), DVec3::ONE, 0.0),
                (DVec3::new(1.5, 0.5, 0.5), DVec3::ONE, 0.5),
            ] {
                let solids = [block(DVec3::ZERO, DVec3::splat(2.0), 0, turn), block(at, size, 6, turn)];
                let found = union_of_faced(&solids, &Cancel::default()).unwrap();
                let volume = 8.0 + size.element_product() - common;
                assert!(found.mesh.is_watertight() && (found.mesh.volume() - volume).abs() < 1e-6, "{at}");
                assert_eq!(found.face_of.len(), found.mesh.triangles.len());
                for (corners, face) in found.mesh.iter_corners().zip(&found.face_of) {
                    let solid = &solids[*face as usize / 6];
                    let own = solid.face_of.iter().position(|f| f == face).unwrap();
                    let [a, b, c] = solid.mesh.corners(own);
                    let normal = (b - a).cross(c - a).normalize();
                    assert!(corners.iter().all(|p| (*p - a).dot(normal).abs() < 1e-6), "{at}: face {face}");
                }
                // The side of the first block that the other one covers wholly is none any more.
                assert_eq!(found.face_of.contains(&1), size != DVec3::new(1.0, 2.0, 2.0), "{at}");
            }
        }
    }
}
