//! Electrodes whose front is worn.

use geometry::mesh::{Bounds, Mesh};
use geometry::solid::{FacedMesh, SolidError, common_of_faced, union_of_faced};
use glam::DVec3;
use task::Cancel;

use super::{Electrode, ElectrodeFace};

impl Electrode {
    /// The electrode after its front has lost the length of `advance`, moved on by `advance` (mm, in W).
    ///
    /// Wear is that of the technology, taken from the front alone, along the direction of burning: what is left of the faces
    /// that burn is the new electrode within the new one moved back by the loss. Moved on by the loss, its front is where the
    /// front of a new electrode is, and what burns lies within the new electrode, so that it keeps at least the distance that a
    /// new one keeps. Where faces look back against the direction of burning it falls short of the new one. Shank and holder do
    /// not wear: they are moved on as they are. It has no patches; its thickness, volume and assumptions are those of the new
    /// one.
    ///
    /// # Errors
    /// [`SolidError`] if the mesh is not closed, nothing is left, or told to stop.
    pub fn worn(&self, advance: DVec3, cancel: &Cancel) -> Result<Self, SolidError> {
        let mut kinds = vec![ElectrodeFace::Shank];
        let number = |face: &ElectrodeFace| {
            kinds.iter().position(|kind| kind == face).unwrap_or_else(|| {
                kinds.push(*face);
                kinds.len() - 1
            }) as u32
        };
        let face_of: Vec<u32> = self.faces.iter().map(number).collect();
        let faced = |mesh: Mesh| FacedMesh { mesh, face_of: face_of.clone() };
        let kept = match self.about_shank() {
            Some(room) => {
                let mesh = Mesh::cuboid(room.size()).mapped(|p| room.min + p);
                let face_of = vec![0; mesh.triangles.len()];
                union_of_faced(&[faced(self.mesh.clone()), FacedMesh { mesh, face_of }], cancel)?
            }
            None => faced(self.mesh.clone()),
        };
        let left = common_of_faced(&faced(self.mesh.mapped(|p| p + advance)), &kept, cancel)?;
        if left.mesh.triangles.is_empty() {
            return Err(SolidError::Failed("nothing of the electrode is left of so much wear".to_owned()));
        }
        let faces = left.face_of.iter().map(|face| kinds[*face as usize]).collect();
        Ok(Self { mesh: left.mesh, faces, patches: Vec::new(), ..self.clone() })
    }

    /// Room about shank and holder: all that is as far out towards the side of entry as any part of them, and farther; none
    /// where the electrode has none.
    fn about_shank(&self) -> Option<Bounds> {
        let (out, bounds) = (self.enters_from.direction(), self.mesh.bounds());
        let shank = self.mesh.iter_corners().zip(&self.faces).filter(|(_, face)| !face.burns());
        let edge = shank.flat_map(|(corners, _)| corners).map(|p| p.dot(out)).fold(f64::INFINITY, f64::min);
        let around = bounds.grown(bounds.size().max_element());
        let beyond = |p: DVec3| p + (edge - p.dot(out)).max(0.0) * out;
        edge.is_finite().then(|| Bounds::of(around.corners().map(beyond)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::electrode::tests::UNREDUCED;
    use geometry::exact::ExactMesh;

    #[test]
    fn the_front_of_a_worn_electrode_that_is_moved_on_is_where_that_of_a_new_one_is() {
        for new in UNREDUCED.iter() {
            let advance = -0.2 * new.enters_from.direction();
            let worn = new.worn(advance, &Cancel::default()).unwrap();
            assert!(worn.mesh.is_watertight() && worn.faces.len() == worn.mesh.triangles.len());
            let exact = ExactMesh::new(&new.mesh).unwrap();
            let ends = |mesh: &Mesh, along: DVec3| {
                mesh.vertices.iter().map(|p| p.dot(along)).fold(f64::NEG_INFINITY, f64::max)
            };
            let forward = advance.normalize();
            assert!((ends(&worn.mesh, forward) - ends(&new.mesh, forward)).abs() < 1e-6);
            assert!(
                (ends(&worn.mesh, -forward) - ends(&new.mesh, -forward) + 0.2).abs() < 1e-6,
                "the holder goes along"
            );
            // What burns lies within the new electrode.
            for (corners, face) in worn.mesh.iter_corners().zip(&worn.faces).filter(|(_, face)| face.burns()) {
                assert!(corners.iter().all(|p| exact.signed_distance(*p) < 1e-6), "{face:?}: {corners:?}");
            }
            // The faces of a burning part that look back give way by the loss across them: what is missing of its volume.
            let along = |mesh: &Mesh, faces: &[ElectrodeFace], looks_back: bool| -> f64 {
                let burning = mesh.iter_corners().zip(faces).filter(|(_, face)| face.burns());
                let across = burning.map(|([a, b, c], _)| 0.5 * (b - a).cross(c - a).dot(forward));
                across.filter(|area| (*area < 0.0) == looks_back).sum()
            };
            let [before, after] = [&new, &&worn].map(|e| along(&e.mesh, &e.faces, false));
            assert!(after <= before * (1.0 + 1e-9) && after > 0.95 * before, "{after} of {before} mm² of front");
        }
    }

    #[test]
    fn an_electrode_that_is_worn_away_is_refused() {
        let new = &UNREDUCED[0];
        let far = 10.0 * new.mesh.bounds().size().max_element();
        assert!(new.worn(-far * new.enters_from.direction(), &Cancel::default()).is_err());
        let unworn = new.worn(DVec3::ZERO, &Cancel::default()).unwrap();
        assert!((unworn.mesh.volume() - new.mesh.volume()).abs() < 1e-6);
    }
}
