//! Volume that an electrode burns at its position, all along its orbit.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::params::{Orbit, Stage};
use geometry::exact::{ExactMesh, ExactMeshError};
use geometry::mesh::Mesh;
use geometry::minkowski::{on_grid, with_rectangle};

/// By how much a place of the orbit has to be better to be moved on from (mm).
const BETTER: f64 = 1e-6;

/// An electrode where it burns.
pub struct Burning {
    mesh: ExactMesh,
    gap: f64,
    /// The orbit, as far as it is not swept already.
    orbit: Orbit,
}

impl Burning {
    /// An electrode, placed in the mold, with its gap and orbit. What a square sweeps is a solid of its own.
    ///
    /// # Errors
    /// [`ExactMeshError`].
    pub fn new(electrode: &Mesh, stage: &Stage) -> Result<Self, ExactMeshError> {
        if let Orbit::Square { radius_mm } = stage.orbit
            && let Ok(swept) = with_rectangle(&on_grid(electrode), DVec2::splat(radius_mm))
        {
            return Ok(Self { mesh: ExactMesh::new(&swept)?, gap: stage.gap_mm, orbit: Orbit::None });
        }
        Ok(Self { mesh: ExactMesh::new(electrode)?, gap: stage.gap_mm, orbit: stage.orbit })
    }

    /// The radius that it leaves in corners at most (mm).
    pub(super) fn reach(&self) -> f64 {
        match self.orbit {
            Orbit::Circular { radius_mm } => self.gap + radius_mm,
            _ => self.gap,
        }
    }

    /// How far a point is from what is burned (mm); 0 or less within it. Never too small.
    ///
    /// The nearest point of the electrode itself is not always the one that comes nearest on its orbit: beside a wall
    /// that the orbit reaches, the nearest may be a floor that it does not. It is looked for from places all around the
    /// orbit, each moved on along the orbit to where the point that is nearest from there comes nearest.
    pub fn beyond(&self, p: DVec3) -> f64 {
        /// Places of the orbit that are begun at, and how often each is moved on at most.
        const PLACES: usize = 16;
        const ROUNDS: usize = 4;
        let around = |i: usize| DVec2::from_angle(i as f64 * 2.0 * PI / PLACES as f64) * self.orbit.radius_mm();
        let places = if self.orbit.radius_mm() > 0.0 { PLACES } else { 0 };
        let mut least = f64::INFINITY;
        for begin in std::iter::once(DVec2::ZERO).chain((0..places).map(around)) {
            let (mut shift, mut before) = (begin, f64::INFINITY);
            for _ in 0..ROUNDS {
                let nearest = self.mesh.nearest(p + shift.extend(0.0));
                if nearest.signed_distance <= self.gap {
                    return (nearest.signed_distance - self.gap).max(-self.gap);
                }
                least = least.min(nearest.signed_distance);
                if nearest.signed_distance > before - BETTER {
                    break;
                }
                before = nearest.signed_distance;
                shift = self.orbit.nearest((nearest.point - p).truncate());
            }
        }
        least - self.gap
    }
}
