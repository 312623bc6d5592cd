//! Input of searches: the channel and an electrode, with their distance fields and points on both.
//!
//! A search with the walls drawn in further needs no other electrode: the walls are turned, and points that a drawn-in
//! wall takes away are left out. That makes sizing, and planning while a reduction is tuned, fast.

use std::sync::Arc;

use super::clearance::{Bodies, ClearanceModel, SamplesOf};
use super::objective::WallDistances;
use super::outside::Outside;
use super::plan_params::PlanError;
use super::pose::Axis;
use super::probes::SideDemand;
use super::samples::{Sample, SampleSpacing, limit_to_reduced, sample_convex_edges, sample_electrode};
use geometry::distance_field::DistanceField;
use geometry::exact::ExactMesh;
use geometry::mesh::Mesh;
use task::{Cancel, Cancelled, Task};
use wheel::channel::Channel;
use wheel::electrode::Electrode;
use wheel::surface_finder::SurfaceFinder;

/// Data that all electrodes of one channel share: the blisk's surface in W, its distance field, and the walls.
pub struct PlanningSpace {
    /// The finished blisk in W.
    pub blisk: Arc<Mesh>,
    /// The channel.
    pub channel: Arc<Channel>,
    /// The surfaces of the channel.
    pub finder: SurfaceFinder,
    /// Signed distance around the channel.
    pub field: DistanceField,
    /// Distances to the two walls there.
    pub walls: WallDistances,
    /// Points along the blisk's edges there.
    pub edges: Vec<Sample>,
}

impl PlanningSpace {
    /// Distance beyond the field up to which the blisk's edges are sampled (mm): shank and holder pass there.
    const RIMS: f64 = 25.0;
    /// Cells of the field at most.
    const MOST_CELLS: f64 = 2.5e6;
    /// Distance between points along the blisk's edges (mm).
    const EDGE_SPACING: f64 = 0.4;

    /// Builds the distance field with cells of `cell` mm, or larger ones if there would be too many, over the channel and
    /// its surroundings.
    pub fn new(
        blisk: Arc<Mesh>,
        exact: Arc<ExactMesh>,
        channel: Arc<Channel>,
        cell: f64,
        task: &Task,
    ) -> Result<Self, PlanError> {
        let finder = SurfaceFinder::new(channel.clone())?;
        let region = channel.surroundings(&blisk);
        let cell = DistanceField::cell_for(&region, cell, Self::MOST_CELLS);
        let field = DistanceField::build(&blisk, exact, region, cell, task)?;
        let edges = sample_convex_edges(&blisk, field.bounds().grown(Self::RIMS), Self::EDGE_SPACING, &task.cancel)?;
        let walls = WallDistances::new(&finder, field.bounds(), &task.cancel)?;
        Ok(Self { blisk, channel, finder, field, walls, edges })
    }
}

/// An electrode with its distance field and the points on it that are tested for clearance.
pub struct PreparedElectrode {
    electrode: Arc<Electrode>,
    distance: DistanceField,
    outside: Arc<Outside>,
    samples: Vec<Sample>,
}

impl PreparedElectrode {
    /// Size of a cell of the electrode's distance field (mm), and how many there are at most.
    const CELL: f64 = 0.35;
    const MOST_CELLS: f64 = 2e6;

    /// Prepares `electrode` for searches that want `clearance` (mm) and draw its walls in by up to `most` (rad).
    ///
    /// # Errors
    /// If the field gets too large, or when cancelled.
    pub fn new(
        space: &PlanningSpace,
        electrode: Arc<Electrode>,
        clearance: f64,
        most: f64,
        task: &Task,
    ) -> Result<Self, PlanError> {
        let exact = ExactMesh::new(&electrode.mesh)?.into();
        let region = electrode.mesh.bounds().grown(clearance + Bodies::AROUND);
        let task = task.as_stage("electrode's distance field");
        let cell = DistanceField::cell_for(&region, Self::CELL, Self::MOST_CELLS);
        let distance = DistanceField::build(&electrode.mesh, exact, region, cell, &task)?;
        let outside = Outside::new(&space.blisk, &electrode.mesh, electrode.reference_point).into();
        let mut samples = sample_electrode(&electrode.mesh, &electrode.faces, SampleSpacing::default(), &task.cancel)?;
        if most > 0.0 {
            limit_to_reduced(&mut samples, &distance, most);
        }
        Ok(Self { electrode, distance, outside, samples })
    }

    /// The electrode.
    pub fn electrode(&self) -> &Arc<Electrode> {
        &self.electrode
    }

    /// Clearance model of the electrode in `space`, for which it was prepared, with what is wanted of single sides. With
    /// walls drawn in, the turned walls are those of an electrode made with such reductions, to some thousandths of a mm at
    /// corners; the holder stays where it is.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn model<'a>(
        &'a self,
        space: &'a PlanningSpace,
        sides: SideDemand,
        cancel: &Cancel,
    ) -> Result<ClearanceModel<'a>, Cancelled> {
        ClearanceModel::new(self.bodies(space, sides), self.samples.clone(), space.edges.clone(), cancel)
    }

    /// Clearance model of `drawn_in`, an electrode made with its walls drawn in: of its own points, reference point and
    /// extent. The blisk's edges see the prepared electrode as what its turned walls leave of it, holder included.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn model_of<'a>(
        &'a self,
        drawn_in: &Electrode,
        space: &'a PlanningSpace,
        sides: SideDemand,
        cancel: &Cancel,
    ) -> Result<ClearanceModel<'a>, Cancelled> {
        let samples = sample_electrode(&drawn_in.mesh, &drawn_in.faces, SampleSpacing::default(), cancel)?;
        let reference_point = drawn_in.reference_point;
        let outside = Outside::new(&space.blisk, &drawn_in.mesh, reference_point).into();
        let bodies = Bodies { samples: SamplesOf::DrawnIn, reference_point, outside, ..self.bodies(space, sides) };
        ClearanceModel::new(bodies, samples, space.edges.clone(), cancel)
    }

    fn bodies<'a>(&'a self, space: &'a PlanningSpace, sides: SideDemand) -> Bodies<'a> {
        Bodies {
            samples: SamplesOf::Prepared,
            blisk: &space.field,
            electrode: &self.distance,
            faces_x: space.channel.faces_x,
            free_radii: (Axis::of_withdrawal(self.electrode.enters_from) == Axis::Z)
                .then(|| [self.outside.bore(), self.outside.rim()]),
            outside: self.outside.clone(),
            reference_point: self.electrode.reference_point,
            side: self.electrode.enters_from,
            sides,
        }
    }
}
