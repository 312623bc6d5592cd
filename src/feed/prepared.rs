//! An electrode made ready for searches: its distance field, and points on it and on the blisk.
//!
//! Searches with the walls drawn in further need no other electrode: the walls are turned, and points that a drawn-in
//! wall takes away are left out. That makes sizing, and planning while a reduction is tuned, fast.

use std::sync::Arc;

use super::clearance::{Bodies, ClearanceModel};
use super::outside::Outside;
use super::plan::PlanningSpace;
use super::plan_params::PlanError;
use super::samples::{Sample, SampleSpacing, limit_to_reduced, sample_electrode};
use crate::blisk::electrode::Electrode;
use crate::geometry::distance_field::DistanceField;
use crate::geometry::exact::ExactMesh;
use crate::progress::{Cancel, Progress};

/// See the module's text.
pub struct PreparedElectrode {
    electrode: Arc<Electrode>,
    distance: DistanceField,
    outside: Outside,
    samples: Vec<Sample>,
}

impl PreparedElectrode {
    /// Size of a cell of the electrode's distance field (mm).
    const CELL: f64 = 0.35;

    /// Prepares `electrode` for searches that want `clearance` (mm) and draw its walls in by up to `most` (rad).
    ///
    /// # Errors
    /// If the field gets too large, or when told to stop.
    pub fn new(
        space: &PlanningSpace,
        electrode: Arc<Electrode>,
        clearance: f64,
        most: f64,
        progress: &Progress,
        cancel: &Cancel,
    ) -> Result<Self, PlanError> {
        let exact = ExactMesh::new(&electrode.mesh)?;
        let region = electrode.mesh.bounds().grown(clearance + Bodies::AROUND);
        let progress = progress.as_stage("electrode's distance field");
        let distance = DistanceField::build(&electrode.mesh, &exact, region, Self::CELL, &progress, cancel)?;
        let outside = Outside::new(&space.blisk, &electrode.mesh, electrode.reference_point);
        let mut samples = sample_electrode(&electrode.mesh, &electrode.faces, SampleSpacing::default(), cancel)?;
        if most > 0.0 {
            limit_to_reduced(&mut samples, &distance, most);
        }
        Ok(Self { electrode, distance, outside, samples })
    }

    /// The electrode.
    pub fn electrode(&self) -> &Arc<Electrode> {
        &self.electrode
    }

    /// The model of its clearance in `space`, for which it was prepared.
    pub fn model<'a>(&'a self, space: &'a PlanningSpace) -> ClearanceModel<'a> {
        let bodies = Bodies {
            blisk: &space.field,
            electrode: &self.distance,
            faces_x: space.channel.faces_x,
            outside: &self.outside,
            reference_point: self.electrode.reference_point,
            side: self.electrode.enters_from,
        };
        ClearanceModel::new(bodies, self.samples.clone(), space.edges.clone())
    }
}
