//! Electrodes for what the cutters leave of a mold.

use files::Validate;
use glam::{DVec2, DVec3};

use super::uncut::{Uncut, UncutError, on_field};
use geometry::mesh::Mesh;
use geometry::segmentation::{Segmentation, SegmentationSettings};
use mold::electrode::design::ElectrodeSet;
use mold::electrode::params::ElectrodeParams;
use mold::electrode::plan::plan;
use mold::electrode::residual_stock::Milled;
use mold::electrode::setting::{ElectrodeError, RegionToBurn};
use mold::height_field::{Covered, HeightField};
use task::{Cancelled, Task};

/// Share of a face that has to be left for all of it to be: pieces at its border are known roughly.
const WHOLE: f64 = 0.9;
/// Share of a region's surface below which a face does not count.
const MINOR: f64 = 0.01;

/// Reason why there are no electrodes.
#[derive(Debug, thiserror::Error)]
pub enum ElectrodesError {
    /// What is left cannot be found again.
    #[error(transparent)]
    Uncut(#[from] UncutError),
    /// The electrodes cannot be made.
    #[error(transparent)]
    Electrode(#[from] ElectrodeError),
    /// A mold that does not enclose anything.
    #[error(
        "electrodes need a closed mold: this one has {0} open edges; repair it first, or import it with its holes \
         closed"
    )]
    Open(usize),
}

impl ElectrodesError {
    /// Whether the task was cancelled.
    pub fn is_cancelled(&self) -> bool {
        let cancelled = |e: &UncutError| matches!(e, UncutError::Cancelled(_));
        matches!(self, Self::Electrode(ElectrodeError::Cancelled(_))) || matches!(self, Self::Uncut(e) if cancelled(e))
    }
}

impl From<Cancelled> for ElectrodesError {
    fn from(cancelled: Cancelled) -> Self {
        Self::Uncut(cancelled.into())
    }
}

/// Electrodes for everything that `uncut` found left of `mesh`.
///
/// # Errors
/// [`ElectrodesError`].
pub fn electrodes(
    mesh: &Mesh,
    uncut: &Uncut,
    params: &ElectrodeParams,
    task: &Task,
) -> Result<ElectrodeSet, ElectrodesError> {
    let open = super::uncut::open_edges(mesh);
    if open > 0 {
        return Err(ElectrodesError::Open(open));
    }
    params.validate().map_err(ElectrodeError::from)?;
    let upright = uncut.params.opening.upright_mesh(mesh);
    task.report("rest material", 0.0, "");
    let field = HeightField::raster(&upright, uncut.grid_step, &task.cancel).map_err(UncutError::from)?;
    let library = &uncut.params.library;
    let (closing, found) = on_field(&field, library, uncut.params.tolerance_mm, &task.cancel)?;
    let covered = Covered::new(&field, &closing, &found);
    let step = covered.step();
    let leaves = |p: DVec3| {
        let near = [-1.0, 0.0, 1.0].map(|x| [-1.0, 0.0, 1.0].map(|y| DVec2::new(x, y) * step));
        let is_left = |at: DVec2| covered.at(p.truncate() + at).is_some_and(|l| l.low - step <= p.z && p.z <= l.high);
        near.as_flattened().iter().any(|at| is_left(*at))
    };
    let milled = Milled { leaves: &leaves, within: step };
    let regions = to_burn(&upright, uncut);
    task.check()?;
    Ok(plan(&upright, &regions, (library, &milled), params, task)?)
}

/// The regions with their surfaces.
fn to_burn(upright: &Mesh, uncut: &Uncut) -> Vec<RegionToBurn> {
    let of = |r: &mold::uncut_region::UncutRegion| RegionToBurn {
        corners: Vec::new(),
        depths: Vec::new(),
        rim: r.bounds.max.z,
        volume: r.volume,
        thickness: r.thickness,
        has_whole_faces: false,
    };
    let mut regions: Vec<RegionToBurn> = uncut.regions.iter().map(of).collect();
    let segmentation = Segmentation::of(upright, &SegmentationSettings::default());
    let mut left: Vec<std::collections::BTreeMap<u32, f64>> = vec![Default::default(); regions.len()];
    for piece in &uncut.surface {
        let region = &mut regions[piece.region as usize];
        region.corners.push(piece.corners);
        region.depths.push(piece.depth.iter().map(|d| f64::from(*d)).sum::<f64>() / 3.0);
        let face = segmentation.face_of[piece.face as usize];
        *left[piece.region as usize].entry(face).or_default() += piece.area();
    }
    for (region, faces) in regions.iter_mut().zip(left) {
        let all: f64 = faces.values().sum();
        let area = |face: u32| segmentation.faces.get(face as usize).map_or(f64::INFINITY, |f| f.area);
        let counts = |area: &f64| *area > MINOR * all;
        region.has_whole_faces =
            faces.iter().filter(|(_, a)| counts(a)).all(|(face, found)| *found >= WHOLE * area(*face));
    }
    regions
}
