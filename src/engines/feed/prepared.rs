//! An electrode made ready for searches: its distance field, and points on it and on the blisk.
//!
//! Searches with the walls drawn in further need no other electrode: the walls are turned, and points that a drawn-in
//! wall takes away are left out. That makes sizing, and planning while a reduction is tuned, fast.

use std::sync::Arc;

use super::clearance::{Bodies, ClearanceModel, SamplesOf};
use super::outside::Outside;
use super::plan::PlanningSpace;
use super::plan_params::PlanError;
use super::samples::{Sample, SampleSpacing, limit_to_reduced, sample_electrode};
use geometry::distance_field::DistanceField;
use geometry::exact::ExactMesh;
use task::{Cancel, Cancelled, Progress};
use wheel::electrode::Electrode;

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

    /// The model of its clearance in `space`, for which it was prepared. With walls drawn in it is as true as the turned
    /// walls are those of an electrode made with such reductions: to some thousandths of a mm at corners.
    pub fn model<'a>(&'a self, space: &'a PlanningSpace) -> ClearanceModel<'a> {
        ClearanceModel::new(self.bodies(space), self.samples.clone(), space.edges.clone())
    }

    /// The same for `drawn_in`, an electrode made with its walls drawn in: its own points are tested, and only for the
    /// blisk's edges its walls are taken from the prepared one.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn model_of<'a>(
        &'a self,
        drawn_in: &Electrode,
        space: &'a PlanningSpace,
        cancel: &Cancel,
    ) -> Result<ClearanceModel<'a>, Cancelled> {
        let samples = sample_electrode(&drawn_in.mesh, &drawn_in.faces, SampleSpacing::default(), cancel)?;
        let bodies = Bodies { samples: SamplesOf::DrawnIn, ..self.bodies(space) };
        Ok(ClearanceModel::new(bodies, samples, space.edges.clone()))
    }

    fn bodies<'a>(&'a self, space: &'a PlanningSpace) -> Bodies<'a> {
        Bodies {
            samples: SamplesOf::Prepared,
            blisk: &space.field,
            electrode: &self.distance,
            faces_x: space.channel.faces_x,
            outside: &self.outside,
            reference_point: self.electrode.reference_point,
            side: self.electrode.enters_from,
        }
    }
}
