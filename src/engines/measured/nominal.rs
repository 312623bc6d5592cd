//! The nominal surface, made ready for questions about many points.

use std::sync::Arc;

use geometry::exact::{ExactMesh, Nearest};
use geometry::inside::guarded_nearest;
use geometry::mesh::{Mesh, unit_normal};
use glam::DVec3;
use rayon::prelude::*;
use task::Task;

use crate::MeasuredError;

/// Greatest angle between triangles of one smooth surface (rad); a greater one is an edge of the part.
const SMOOTH: f64 = 30.0 * std::f64::consts::PI / 180.0;

/// The nominal surface of a part: a triangle mesh (mm), counter-clockwise seen from outside the metal.
pub struct Nominal {
    mesh: Arc<Mesh>,
    exact: ExactMesh,
    is_closed: bool,
    /// Of each triangle the greatest angle between its normal and that of the smooth surface it stands for (rad).
    facet_angles: Vec<f32>,
}

impl Nominal {
    /// Prepares `mesh` (mm). Distances have a sign also where the mesh is open, as the normals of its triangles say;
    /// away from its rims that is right.
    ///
    /// # Errors
    /// [`MeasuredError::Nominal`] for a mesh without triangles, and [`MeasuredError::Cancelled`].
    pub fn new(mesh: Arc<Mesh>, task: &Task) -> Result<Self, MeasuredError> {
        task.check()?;
        task.report("nominal surface", 0.0, "");
        let exact = ExactMesh::new(&mesh)?;
        task.check()?;
        let is_closed = mesh.is_watertight();
        task.check()?;
        let facet_angles = facet_angles(&mesh);
        task.report("nominal surface", 1.0, "");
        Ok(Self { mesh, exact, is_closed, facet_angles })
    }

    /// The mesh (mm).
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// Whether the mesh is closed, so that its inside is certain.
    pub fn is_closed(&self) -> bool {
        self.is_closed
    }

    /// The nearest point of the surface to `p` (mm), its distance negative within the metal.
    pub fn nearest(&self, p: DVec3) -> Nearest {
        if self.is_closed { guarded_nearest(&self.exact, p) } else { self.exact.nearest(p) }
    }

    /// The nearest point of the surface to `p` (mm), the sign of its distance as the normals beside it say.
    pub(crate) fn nearest_by_normals(&self, p: DVec3) -> Nearest {
        self.exact.nearest(p)
    }

    /// Unit normal of a triangle, zero for a degenerate one.
    pub(crate) fn normal(&self, triangle: u32) -> DVec3 {
        unit_normal(self.mesh.corners(triangle as usize))
    }

    /// The greatest angle between the normal of a triangle and that of the smooth surface it stands for (rad): half of
    /// the greatest angle at which a triangle meets it without an edge.
    pub(crate) fn facet_angle(&self, triangle: u32) -> f64 {
        self.facet_angles.get(triangle as usize).map_or(0.0, |angle| f64::from(*angle))
    }
}

fn facet_angles(mesh: &Mesh) -> Vec<f32> {
    let normals: Vec<DVec3> = (0..mesh.triangles.len()).into_par_iter().map(|i| unit_normal(mesh.corners(i))).collect();
    let mut sides: Vec<(u64, u32)> = mesh
        .sides()
        .map(|((from, to), i)| (u64::from(from.min(to)) << 32 | u64::from(from.max(to)), i as u32))
        .collect();
    sides.par_sort_unstable();
    let mut angles = vec![0.0f32; normals.len()];
    // Sorted, the triangles at an edge stand side by side.
    for pair in sides.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        let both = [pair[0].1 as usize, pair[1].1 as usize];
        let [n, m] = both.map(|i| normals[i]);
        let angle = n.cross(m).length().atan2(n.dot(m));
        if angle < SMOOTH && n != DVec3::ZERO && m != DVec3::ZERO {
            for i in both {
                angles[i] = angles[i].max(0.5 * angle as f32);
            }
        }
    }
    angles
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn facets_of_a_drum_are_told_and_edges_of_a_box_are_none() {
        let boxed = Nominal::new(Arc::new(Mesh::cuboid(DVec3::ONE)), &Task::default()).unwrap();
        assert!((0..12).all(|i| boxed.facet_angle(i) == 0.0) && boxed.is_closed());
        let drum = Nominal::new(Arc::new(crate::tests::meshes::drum(10.0, 20.0, 72)), &Task::default()).unwrap();
        let angle = (0..drum.mesh().triangles.len() as u32).map(|i| drum.facet_angle(i)).fold(0.0, f64::max);
        assert!((angle.to_degrees() - 2.5).abs() < 1e-3, "{angle}");
        assert!(drum.nearest(DVec3::new(0.0, 0.0, 1.0)).signed_distance < 0.0);
    }
}
