//! The mold and its regions as electrodes are planned for them: in the burn frame of a direction, grown by what a stage
//! keeps clear.

use std::f64::consts::TAU;

use files::Invalid;
use glam::{DMat3, DQuat, DVec2, DVec3};

use super::params::{Orbit, Stage};
use crate::height_field::HeightFieldError;
use geometry::exact::{ExactMesh, ExactMeshError};
use geometry::mesh::{Mesh, unit_normal};
use geometry::minkowski::{on_grid, up_to_grid, with_rectangle};
use geometry::offset::{OffsetError, offset, offset_along_disc};
use geometry::solid::{SolidError, unfolded};
use task::Cancelled;

/// By how much an electrode may come closer than the gap (mm): rounding of files, not of sparks.
pub const GOUGE: f64 = 5e-4;
/// How far off a burn surface a point of a tip may be to be part of it (mm).
const ON_BURN: f64 = 1e-6;

/// Reason why there are no electrodes.
#[derive(Debug, thiserror::Error)]
pub enum ElectrodeError {
    /// Parameters that cannot be used.
    #[error(transparent)]
    Params(#[from] Invalid),
    /// The mold's surface cannot be moved by the gap.
    #[error("the mold grown by the spark gap: {0}")]
    Offset(#[from] OffsetError),
    /// The mold is no solid.
    #[error("electrodes need a closed mold, which can be told inside from outside: {0}")]
    Solid(#[from] SolidError),
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
}

/// The mold for one burn direction and stage.
pub(super) struct Setting {
    /// Rotation from the upright mold to the burn frame.
    pub(super) turned: DMat3,
    /// The mold in the burn frame.
    pub(super) mold: Mesh,
    /// The mold for distance queries.
    own: ExactMesh,
    /// Volume that electrodes must keep out of: the mold grown by gap, stock and orbit.
    pub(super) kept_clear: Mesh,
    pub(super) exact: ExactMesh,
    pub(super) stage: Stage,
}

impl Setting {
    pub(super) fn new(mold: &Mesh, direction: DVec3, stage: &Stage) -> Result<Self, ElectrodeError> {
        let turned = to_burn_frame(direction);
        let mold = mold.mapped(|p| turned * p);
        let kept_clear = kept_clear(&mold, stage)?;
        let exact = ExactMesh::new(&kept_clear)?;
        let own = ExactMesh::new(&mold)?;
        Ok(Self { turned, mold, own, kept_clear, exact, stage: stage.clone() })
    }

    /// Whether a point lies on the surface that burns.
    pub(super) fn burns(&self, p: DVec3) -> bool {
        self.exact.nearest(p).signed_distance.abs() < ON_BURN
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

/// Volume that an electrode must not enter, in the burn frame: the mold grown by the gap, and by the orbit's sweep.
///
/// A circular orbit moves each face by its own amount. So does a square orbit, but where the facets of two of its
/// quarters meet, a side of the square belongs between them: moved separately they would meet further out, by as much
/// as the orbit times the tangent of half their turn. The sweep of a square is therefore added as a solid.
pub(super) fn kept_clear(mold: &Mesh, stage: &Stage) -> Result<Mesh, ElectrodeError> {
    let gap = stage.gap_mm + stage.stock_mm;
    match stage.orbit {
        Orbit::None => Ok(unfolded(offset(mold, |_| gap)?)?),
        Orbit::Circular { radius_mm } => Ok(unfolded(offset_along_disc(mold, gap, radius_mm)?)?),
        Orbit::Square { radius_mm } => {
            let grown = unfolded(on_grid(&offset(mold, |_| gap)?))?;
            Ok(with_rectangle(&grown, DVec2::splat(up_to_grid(radius_mm)))?)
        }
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
pub(super) fn burn_area<'a>(setting: &Setting, bodies: impl Iterator<Item = &'a Mesh>) -> f64 {
    let of = |body: &Mesh| -> f64 {
        let burns: Vec<bool> = body.vertices.iter().map(|p| setting.burns(*p)).collect();
        let is_burning = |t: &&[u32; 3]| {
            let middle = t.iter().map(|i| body.vertices[*i as usize]).sum::<DVec3>() / 3.0;
            t.iter().all(|i| burns[*i as usize]) && setting.burns(middle)
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
