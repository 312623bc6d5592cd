//! Surface of the swept volume of a moving body.
//!
//! The room is the union of the body in all its placements. The distance from a point to it is the least of the
//! distances to the body, each read from one distance field at the point brought into the body's frame. The zero of
//! that least distance is made a surface on a lattice by dual contouring: a vertex in every cell that the surface
//! passes, one for each sheet of it, moved onto the zero itself, and onto the edge or corner where sheets of
//! different slope meet (Ju, Losasso, Schaefer and Warren, SIGGRAPH 2002; sheets apart as by Nielson, Dual Marching
//! Cubes, IEEE Visualization 2004).
//!
//! **Guaranteed:** the surface is closed and oriented outwards, and the same on any number of threads. **Accuracy:**
//! vertices lie within [`SweptSurface::ACCURACY`] of the zero; between them the surface deviates as a chord of its
//! lattice does. What is thinner than a cell may be missing. **Not guaranteed:** that no two of its triangles cross
//! where sheets of the surface are less than two cells apart.

mod lattice;
mod motion;
mod net;
mod place;

use glam::DAffine3;

use super::distance_field::{DistanceField, FieldError};
use super::exact::{ExactMesh, ExactMeshError};
use super::mesh::{Bounds, Mesh};
use lattice::Lattice;
use motion::Motion;
use task::{Cancelled, Task};

/// Reason why there is no swept surface.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SweptError {
    /// Cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// The body cannot be searched.
    #[error(transparent)]
    Body(#[from] ExactMeshError),
    /// The distance field of the body does not fit.
    #[error(transparent)]
    Field(FieldError),
    /// There are no placements, or they lead beyond all numbers.
    #[error("the way of the body has no finite extent")]
    NoWay,
}

impl From<FieldError> for SweptError {
    fn from(error: FieldError) -> Self {
        match error {
            FieldError::Cancelled(cancelled) => cancelled.into(),
            other => Self::Field(other),
        }
    }
}

/// A swept surface and how it was made.
#[derive(Debug, Clone, PartialEq)]
pub struct SweptSurface {
    /// The closed surface.
    pub mesh: Mesh,
    /// Edge of a cell of the lattice (mm).
    pub cell: f64,
}

impl SweptSurface {
    /// Greatest distance of a vertex from the true surface (mm), if placements follow each other within
    /// [`STEP`](Self::STEP).
    pub const ACCURACY: f64 = 0.02;
    /// Greatest way of a point of the body from one placement to the next (mm). Between two of them the motion counts
    /// as linear.
    pub const STEP: f64 = 0.1;

    /// The surface that `body`, closed and oriented outwards, sweeps in `placements` in the order of its motion, made
    /// on a lattice of about `cells` cells.
    ///
    /// # Errors
    /// If body or way are empty or not finite, or when cancelled.
    pub fn new(body: &Mesh, placements: &[DAffine3], cells: usize, task: &Task) -> Result<Self, SweptError> {
        const STAGE: &str = "swept surface";
        task.report(STAGE, 0.0, "");
        let exact = ExactMesh::new(body)?.into();
        let lattice = Lattice::around(&extent(body, placements)?, cells);
        // Far from the body its box will do; near it means where a vertex may begin.
        let region = body.bounds().grown(2.0 * lattice.cell);
        let field = DistanceField::build(body, exact, region, lattice.cell, &Task::silent(&task.cancel))?;
        let motion = Motion::new(body, field, placements);
        task.report(STAGE, 0.1, "");
        let blocks = lattice.blocks(&motion, &task.cancel)?;
        task.report(STAGE, 0.4, "");
        let net = net::Net::new(&lattice, &blocks);
        let mesh = place::placed(net, &lattice, &blocks, &motion, &task.cancel)?;
        task.report(STAGE, 1.0, "");
        Ok(Self { mesh, cell: lattice.cell })
    }
}

/// The box around the box of `body` in all placements.
fn extent(body: &Mesh, placements: &[DAffine3]) -> Result<Bounds, SweptError> {
    let corners = body.bounds().corners();
    let points = placements.iter().flat_map(|at| corners.map(|c| at.transform_point3(c)));
    // A comparison with NaN leaves no trace in a box.
    let mut finite = true;
    let bounds = Bounds::of(points.inspect(|p| finite &= p.is_finite()));
    if finite && bounds.size().is_finite() && bounds.min.x <= bounds.max.x {
        Ok(bounds)
    } else {
        Err(SweptError::NoWay)
    }
}

#[cfg(test)]
mod tests;
