//! Electrodes for what the cutters leave of a mold.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};

use crate::workspaces::technology::read_table;
use files::Validate;
use glam::{DMat3, DMat4, DVec2, DVec3};

use super::uncut::{Uncut, UncutError, on_field};
use geometry::groups::Groups;
use geometry::mesh::Mesh;
use geometry::segmentation::{KnownFace, Segmentation, SegmentationSettings};
use import::{CadFaces, Imported};
use mold::electrode::design::ElectrodeSet;
use mold::electrode::params::ElectrodeParams;
use mold::electrode::plan::plan;
use mold::electrode::residual_stock::Milled;
use mold::electrode::setting::{ElectrodeError, RegionToBurn};
use mold::height_field::{Covered, HeightField};
use mold::opening::Opening;
use task::{Cancel, Cancelled, Task};

/// Share of a face that has to be left for all of it to be: pieces at its border are known roughly.
const WHOLE: f64 = 0.9;
/// Share of a region's surface below which a face does not count.
const MINOR: f64 = 0.01;
/// How far above the underside of a mold a region that goes through it may end (mm): heights are in single precision.
const ON_UNDERSIDE: f64 = 1e-3;

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

/// A mold: its triangles, and the faces of the CAD program where its file has them.
#[derive(Debug, Clone, Copy)]
pub struct MoldBody<'a> {
    /// Triangles (mm).
    pub mesh: &'a Mesh,
    /// Faces of the triangles.
    pub faces: Option<&'a CadFaces>,
    /// Solids beside it that electrodes keep clear of (mm).
    pub obstacles: Option<&'a Mesh>,
}

impl<'a> From<&'a Mesh> for MoldBody<'a> {
    fn from(mesh: &'a Mesh) -> Self {
        Self { mesh, faces: None, obstacles: None }
    }
}

impl<'a> From<&'a Imported> for MoldBody<'a> {
    fn from(imported: &'a Imported) -> Self {
        Self { mesh: &imported.mesh, faces: imported.faces.as_ref(), obstacles: imported.obstacles.as_ref() }
    }
}

impl MoldBody<'_> {
    /// Surfaces that electrodes keep clear of: `upright`, its mesh turned so that `opening` looks along +Z, and the obstacles.
    pub(super) fn in_the_way<'u>(self, upright: &'u Mesh, opening: Opening) -> Cow<'u, Mesh> {
        let Some(obstacles) = self.obstacles else { return Cow::Borrowed(upright) };
        let mut all = upright.clone();
        all.append(&opening.upright_mesh(obstacles));
        Cow::Owned(all)
    }

    /// The faces of `upright`, its mesh turned so that `opening` looks along +Z: those of the CAD program, or those that
    /// the triangles show.
    ///
    /// # Errors
    /// When cancelled.
    pub(super) fn segmentation(
        self,
        upright: &Mesh,
        opening: Opening,
        cancel: &Cancel,
    ) -> Result<Segmentation, Cancelled> {
        let settings = SegmentationSettings::default();
        let Some(cad) = self.faces else { return Segmentation::find(upright, &settings, cancel) };
        let [x, y, z] = DVec3::AXES.map(|axis| opening.upright(axis));
        let turn = DMat4::from_mat3(DMat3::from_cols(x, y, z));
        let known: Vec<KnownFace> = cad.faces.iter().map(|face| face.placed(&turn, 1.0)).collect();
        Ok(Segmentation::of_faces(upright, &known, &cad.face_of, &settings))
    }
}

/// Electrodes for everything that `uncut` found left of `mold`.
///
/// # Errors
/// [`ElectrodesError`].
pub fn electrodes<'a>(
    mold: impl Into<MoldBody<'a>>,
    uncut: &Uncut,
    params: &ElectrodeParams,
    task: &Task,
) -> Result<ElectrodeSet, ElectrodesError> {
    params.validate().map_err(ElectrodeError::from)?;
    let mold = mold.into();
    on_milled(mold.mesh, uncut, task, |upright, milled| {
        let faces = mold.segmentation(upright, uncut.params.opening, &task.cancel)?;
        let regions = to_burn(upright, &faces, uncut, false);
        task.check()?;
        let in_the_way = mold.in_the_way(upright, uncut.params.opening);
        Ok(timed(plan(&in_the_way, &regions, (&uncut.params.library, milled), params, task)?))
    })
}

/// The electrodes with minutes and wear by the technology of their parameters, whose table is read. Why it cannot be read
/// stands in the figures.
pub fn timed(set: ElectrodeSet) -> ElectrodeSet {
    match read_table(&set.params.technology) {
        Ok(table) => set.timed(Ok(&table)),
        Err(error) => set.timed(Err(&error.to_string())),
    }
}

/// Does `work` on the upright mold with what its cutters leave of it.
///
/// # Errors
/// [`ElectrodesError`].
pub(super) fn on_milled<T>(
    mesh: &Mesh,
    uncut: &Uncut,
    task: &Task,
    work: impl FnOnce(&Mesh, &Milled) -> Result<T, ElectrodesError>,
) -> Result<T, ElectrodesError> {
    let open = super::uncut::open_edges(mesh);
    if open > 0 {
        return Err(ElectrodesError::Open(open));
    }
    let upright = uncut.params.opening.upright_mesh(mesh);
    task.report("rest material", 0.0, "");
    let field = HeightField::raster(&upright, uncut.grid_step, &task.cancel).map_err(UncutError::from)?;
    let (closing, found) =
        on_field(&field, &uncut.params.library, (uncut.exact(), uncut.params.tolerance_mm), &task.cancel)?;
    let covered = Covered::new(&field, &closing, &found);
    let step = covered.step();
    let leaves = |p: DVec3, within: f64| {
        let is_left = |at: DVec2| covered.at(p.truncate() + at).is_some_and(|l| l.low - within <= p.z && p.z <= l.high);
        let near = [-1.0, 0.0, 1.0].map(|x| [-1.0, 0.0, 1.0].map(|y| DVec2::new(x, y) * within));
        is_left(DVec2::ZERO) || (within > 0.0 && near.as_flattened().iter().any(|at| is_left(*at)))
    };
    work(&upright, &Milled { leaves: &leaves, within: step })
}

/// The regions with their surfaces; if they are of whole faces, each with all of every face that it is part of, and
/// those that share one as one.
pub(super) fn to_burn(
    upright: &Mesh,
    segmentation: &Segmentation,
    uncut: &Uncut,
    of_whole_faces: bool,
) -> Vec<RegionToBurn> {
    let underside = upright.bounds().min.z;
    let of = |r: &mold::uncut_region::UncutRegion| RegionToBurn {
        corners: Vec::new(),
        depths: Vec::new(),
        rim: r.bounds.max.z,
        volume: r.volume,
        thickness: r.thickness,
        has_whole_faces: false,
        is_through: r.bounds.min.z <= underside + ON_UNDERSIDE,
    };
    let mut regions: Vec<RegionToBurn> = uncut.regions.iter().map(of).collect();
    let mut left: Vec<BTreeMap<u32, f64>> = vec![Default::default(); regions.len()];
    for piece in &uncut.surface {
        let region = &mut regions[piece.region as usize];
        region.corners.push(piece.corners);
        region.depths.push(piece.depth.iter().map(|d| f64::from(*d)).sum::<f64>() / 3.0);
        let face = segmentation.face_of[piece.face as usize];
        *left[piece.region as usize].entry(face).or_default() += piece.area();
    }
    let counted = |faces: &BTreeMap<u32, f64>| {
        let all: f64 = faces.values().sum();
        faces.iter().filter(|(_, area)| **area > MINOR * all).map(|(face, area)| (*face, *area)).collect::<Vec<_>>()
    };
    if of_whole_faces {
        let faces: Vec<Vec<u32>> =
            left.iter().map(|of| counted(of).into_iter().map(|(face, _)| face).collect()).collect();
        return whole_faces(upright, &regions, &faces, segmentation);
    }
    let area = |face: u32| segmentation.faces.get(face as usize).map_or(f64::INFINITY, |f| f.area);
    for (region, faces) in regions.iter_mut().zip(left) {
        region.has_whole_faces = counted(&faces).into_iter().all(|(face, found)| found >= WHOLE * area(face));
    }
    regions
}

/// Regions of all triangles of these `faces` of each, those that share a face as one.
fn whole_faces(
    upright: &Mesh,
    regions: &[RegionToBurn],
    faces: &[Vec<u32>],
    segmentation: &Segmentation,
) -> Vec<RegionToBurn> {
    let mut groups = Groups::of(regions.len());
    let mut owner = BTreeMap::new();
    for (r, face) in faces.iter().enumerate().flat_map(|(r, own)| own.iter().map(move |face| (r, *face))) {
        groups.join(r, *owner.entry(face).or_insert(r));
    }
    let (numbers, count) = groups.numbers();
    let of_group = |group: usize| {
        let own: Vec<usize> = (0..regions.len()).filter(|r| numbers[*r] as usize == group).collect();
        let known: BTreeSet<u32> = own.iter().flat_map(|r| faces[*r].iter().copied()).collect();
        let triangles =
            known.iter().filter_map(|face| segmentation.faces.get(*face as usize)).flat_map(|f| &f.triangles);
        let corners: Vec<[DVec3; 3]> = triangles.map(|t| upright.corners(*t as usize)).collect();
        let rim = corners.iter().flatten().map(|p| p.z).fold(f64::NEG_INFINITY, f64::max);
        let height = |c: &[DVec3; 3]| rim - c.iter().map(|p| p.z).sum::<f64>() / 3.0;
        RegionToBurn {
            depths: corners.iter().map(height).collect(),
            corners,
            rim,
            volume: own.iter().map(|r| regions[*r].volume).sum(),
            thickness: own.iter().map(|r| regions[*r].thickness).fold(0.0, f64::max),
            has_whole_faces: true,
            is_through: own.iter().any(|r| regions[*r].is_through),
        }
    };
    (0..count).map(of_group).collect()
}
