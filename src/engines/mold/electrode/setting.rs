//! The mold and its regions as electrodes are planned for them: in the burn frame of a direction, grown by what a stage
//! keeps clear.

use std::f64::consts::TAU;

use files::Invalid;
use glam::{DMat3, DQuat, DVec2, DVec3};

use super::params::{Orbit, Stage};
use crate::height_field::HeightFieldError;
use geometry::envelope::{Growth, envelope};
use geometry::exact::{ExactMesh, ExactMeshError};
use geometry::mesh::{Mesh, unit_normal};
use geometry::minkowski::{on_grid, up_to_grid, with_rectangle};
use geometry::solid::{SolidError, Trimmer};
use task::{Cancel, Cancelled};

/// By how much an electrode may come closer than the gap (mm): rounding of files, not of sparks.
pub const GOUGE: f64 = 5e-4;
/// How far off a burn surface a point of a tip may be to be part of it (mm).
const ON_BURN: f64 = 2e-5;

/// Reason why there are no electrodes.
#[derive(Debug, thiserror::Error)]
pub enum ElectrodeError {
    /// Parameters that cannot be used.
    #[error(transparent)]
    Params(#[from] Invalid),
    /// A body that encloses nothing.
    #[error("electrodes need a closed mold, which can be told inside from outside: {0}")]
    Solid(SolidError),
    /// The mold cannot be searched.
    #[error(transparent)]
    Exact(#[from] ExactMeshError),
    /// An electrode cannot be tried with the cutters.
    #[error("milling of the electrodes: {0}")]
    Milling(HeightFieldError),
    /// Cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<SolidError> for ElectrodeError {
    fn from(error: SolidError) -> Self {
        match error {
            SolidError::Cancelled(cancelled) => Self::Cancelled(cancelled),
            other => Self::Solid(other),
        }
    }
}

impl From<HeightFieldError> for ElectrodeError {
    fn from(error: HeightFieldError) -> Self {
        match error {
            HeightFieldError::Cancelled(cancelled) => Self::Cancelled(cancelled),
            other => Self::Milling(other),
        }
    }
}

/// An uncut region, in the upright mold.
#[derive(Debug, Clone)]
pub struct RegionToBurn {
    /// The corners of the parts of the surface that bound it (mm).
    pub corners: Vec<[DVec3; 3]>,
    /// Height up to which each of them is covered (mm).
    pub depths: Vec<f64>,
    /// Greatest height of the residual stock (mm).
    pub rim: f64,
    /// Volume (mm^3).
    pub volume: f64,
    /// Greatest thickness across the surface (mm).
    pub thickness: f64,
    /// Whether it consists of whole faces of the mold.
    pub has_whole_faces: bool,
    /// Whether it goes through the mold's underside.
    pub is_through: bool,
}

/// The mold for one burn direction and stage.
pub(super) struct Setting {
    /// Rotation from the upright mold to the burn frame.
    pub(super) turned: DMat3,
    /// The mold in the burn frame.
    pub(super) mold: Mesh,
    /// The mold for distance queries.
    own: ExactMesh,
    pub(super) stage: Stage,
}

impl Setting {
    pub(super) fn new(mold: &Mesh, direction: DVec3, stage: &Stage) -> Result<Self, ElectrodeError> {
        let turned = to_burn_frame(direction);
        let mold = mold.mapped(|p| turned * p);
        let own = ExactMesh::new(&mold)?;
        Ok(Self { turned, mold, own, stage: stage.clone() })
    }

    /// The face of an electrode over the mold's face at a point within `reach` (mm): a point of it (mm) and its unit
    /// normal, out of the electrode. All in the burn frame; none where the mold has no surface.
    pub(super) fn face_at(&self, p: DVec3, reach: f64) -> Option<(DVec3, DVec3)> {
        let nearest = self.own.nearest(p);
        let normal = unit_normal(self.mold.corners(nearest.triangle as usize));
        let is_there = nearest.point.distance(p) <= reach;
        is_there.then(|| (nearest.point + self.stage.undersize(normal) * normal, -normal))
    }

    /// Whether an electrode that holds a point keeps the gap there all along its orbit.
    pub(super) fn keeps_gap(&self, p: DVec3) -> bool {
        /// Places of an orbit that are tried.
        const PLACES: usize = 8;
        let least = self.stage.gap_mm + self.stage.stock_mm - GOUGE;
        let keeps = |shift: DVec2| self.own.nearest(p + shift.extend(0.0)).signed_distance >= least;
        let around = |i: usize| DVec2::from_angle((i as f64 + 0.5) * TAU / PLACES as f64);
        match self.stage.orbit {
            Orbit::None => keeps(DVec2::ZERO),
            Orbit::Circular { radius_mm } => (0..PLACES).all(|i| keeps(around(i) * radius_mm)),
            Orbit::Square { radius_mm } => (0..PLACES).all(|i| keeps(around(i).signum() * radius_mm)),
        }
    }
}

/// What a straight sinking electrode must stay above around a region, in the burn frame: the mold grown by gap and
/// orbit, and all that lies below.
pub(super) struct KeptClear {
    /// The volume.
    pub(super) mesh: Mesh,
    pub(super) trimmer: Trimmer,
    exact: ExactMesh,
}

impl KeptClear {
    /// Volume of a mold over a rectangle in plan (its corners, mm), for a region whose lowest point is at the height `low`.
    pub(super) fn over(
        mold: &Mesh,
        stage: &Stage,
        plan: [DVec2; 2],
        low: f64,
        cancel: &Cancel,
    ) -> Result<Self, SolidError> {
        /// How far it reaches below the region (mm).
        const BELOW: f64 = 1.0;
        let gap = stage.gap_mm + stage.stock_mm;
        // Moved apart by a square the facets of two of its quarters would meet too far out: it is swept as a solid.
        let (radius, half) = match stage.orbit {
            Orbit::None => (0.0, 0.0),
            Orbit::Circular { radius_mm } => (radius_mm, 0.0),
            Orbit::Square { radius_mm } => (0.0, up_to_grid(radius_mm)),
        };
        let [from, to] = plan;
        let grown = envelope(mold, &Growth { gap, radius }, [from - half, to + half], low - BELOW, cancel)?;
        let mesh = if half > 0.0 { with_rectangle(&on_grid(&grown), DVec2::splat(half))? } else { grown };
        let exact = ExactMesh::new(&mesh).map_err(|error| SolidError::Failed(error.to_string()))?;
        Ok(Self { trimmer: Trimmer::new(&mesh)?, mesh, exact })
    }

    /// Whether a point lies on the surface that burns.
    pub(super) fn burns(&self, p: DVec3) -> bool {
        self.exact.nearest(p).signed_distance.abs() < ON_BURN
    }
}

/// The rotation that turns a burn direction to -Z; none for straight down.
pub fn to_burn_frame(direction: DVec3) -> DMat3 {
    let direction = direction.normalize_or_zero();
    if direction == DVec3::ZERO || direction.dot(DVec3::NEG_Z) > 1.0 - 1e-12 {
        return DMat3::IDENTITY;
    }
    DMat3::from_quat(DQuat::from_rotation_arc(direction, DVec3::NEG_Z))
}

/// Volume of the layer that a stage leaves of a region for the next one (mm^3): as thick as that one's electrode is
/// larger than its own, and no less than its stock.
pub(super) fn layer(region: &RegionToBurn, turned: &DMat3, [stage, next]: [&Stage; 2]) -> f64 {
    let of = |corners: &[DVec3; 3]| {
        let [a, b, c] = corners.map(|p| *turned * p);
        let area = 0.5 * (b - a).cross(c - a).length();
        let normal = unit_normal([a, b, c]);
        // On a surface that has no normal there is no layer.
        let thick = (stage.undersize(normal) - next.undersize(normal)).max(stage.stock_mm);
        if area > 0.0 { area * thick } else { 0.0 }
    };
    region.corners.iter().map(of).sum()
}

/// Area of bodies on the surface that burns, the mold's own moved by the gap (mm^2).
pub(super) fn burn_area<'a>(bodies: impl Iterator<Item = (&'a KeptClear, &'a Mesh)>) -> f64 {
    let of = |(clear, body): (&KeptClear, &Mesh)| -> f64 {
        let burns: Vec<bool> = body.vertices.iter().map(|p| clear.burns(*p)).collect();
        let is_burning = |t: &&[u32; 3]| {
            let middle = t.iter().map(|i| body.vertices[*i as usize]).sum::<DVec3>() / 3.0;
            t.iter().all(|i| burns[*i as usize]) && clear.burns(middle)
        };
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| body.vertices[i as usize]);
            0.5 * (b - a).cross(c - a).length()
        };
        // The sum of none is a zero with a sign.
        body.triangles.iter().filter(is_burning).map(area).sum::<f64>() + 0.0
    };
    bodies.map(of).sum::<f64>() + 0.0
}
