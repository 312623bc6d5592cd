//! From regions to electrodes.

use std::f64::consts::TAU;

use glam::{DMat3, DQuat, DVec2, DVec3};
use rayon::prelude::*;

use super::base::placed;
use super::check::{GOUGE, LeftOfRegion, Milled};
use super::combine::Form;
use super::design::{Burn, Electrode, ElectrodeSet, PartId, PartNode, RegionPlan};
use super::division::{DivisionSettings, Part, divide};
use super::earlier::{left_to_later, no_room, thick_only};
use super::edits::{apply, named as named_by_edits, places};
use super::family::{Family, into_families, parts};
use super::params::{Edit, ElectrodeParams, ElectrodeParamsError, Method, Orbit, Shape, Stage};
use super::plan_checks::checked;
use super::sharing::{assembled, shared};
use super::tip::{Burned, Place, TipError, footprint};
use crate::geometry::exact::{ExactMesh, ExactMeshError};
use crate::geometry::mesh::Mesh;
use crate::geometry::minkowski::{on_grid, up_to_grid, with_rectangle};
use crate::geometry::offset::{OffsetError, offset, offset_along_disc};
use crate::geometry::solid::{SolidError, unfolded};
use crate::mold::cutter::CutterLibrary;
use crate::mold::height_field::HeightFieldError;
use crate::mold::outline::Outline;
use crate::progress::{Cancel, Cancelled, Progress};

/// How far off a burn surface a point of a tip may be to be part of it (mm).
const ON_BURN: f64 = 1e-6;

/// Said where the two do not belong together.
const OTHER_NET: &str = "without gap it is divided or shared otherwise than with it, so that its net shape is not that of an electrode: \
    write undersized shapes";

/// Why there are no electrodes.
#[derive(Debug, thiserror::Error)]
pub enum ElectrodeError {
    /// Parameters that cannot be used.
    #[error(transparent)]
    Params(#[from] ElectrodeParamsError),
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
    /// Told to stop.
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

/// A region that cutters leave, upright.
#[derive(Debug, Clone)]
pub struct RegionToBurn {
    /// The corners of the parts of the surface that bound it (mm).
    pub corners: Vec<[DVec3; 3]>,
    /// How high each of them is covered (mm).
    pub depths: Vec<f64>,
    /// Height that what is left reaches up to (mm).
    pub rim: f64,
    /// Its volume (mm^3).
    pub volume: f64,
    /// Its greatest thickness across the surface (mm).
    pub thickness: f64,
    /// Whether it consists of whole faces of the mold.
    pub has_whole_faces: bool,
}

/// The mold for one burn direction and stage.
pub(super) struct Setting {
    /// From the upright mold to the burn frame.
    pub(super) turned: DMat3,
    /// The mold in it.
    pub(super) mold: Mesh,
    /// The same, for distances.
    own: ExactMesh,
    /// The mold grown by what electrodes keep off.
    kept_clear: Mesh,
    exact: ExactMesh,
    pub(super) stage: Stage,
}

impl Setting {
    fn new(mold: &Mesh, direction: DVec3, stage: &Stage) -> Result<Self, ElectrodeError> {
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

/// What an electrode must not enter, in the burn frame: the mold grown by the gap, and by what the orbit sweeps.
///
/// A circle moves each face by its own way. So does a square, but where the facets of two of its quarters meet, its own side
/// belongs between them: moved each by its own way they would meet further out, by as much as the orbit times the tangent
/// of half their turn. What a square sweeps is therefore added as a solid.
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

/// A tip with what it is for.
pub(super) struct Leaf {
    pub(super) id: PartId,
    pub(super) part: Part,
    pub(super) form: Form,
}

/// Electrodes for `regions` of a mold that opens along +Z.
///
/// # Errors
/// [`ElectrodeError`].
pub fn plan(
    mold: &Mesh,
    regions: &[RegionToBurn],
    libraries: (&CutterLibrary, &Milled),
    params: &ElectrodeParams,
    progress: &Progress,
    cancel: &Cancel,
) -> Result<ElectrodeSet, ElectrodeError> {
    params.validate()?;
    let made = plan_stages(mold, regions, libraries, (params, &params.stages, None), progress, cancel)?;
    if params.shape == Shape::Undersized {
        return Ok(made);
    }
    // Files of the net shape are those of an electrode without gap; it is the real one that has to come out.
    let stages: Vec<Stage> = params.stages.iter().map(net).collect();
    let like = Some(&made.electrodes[..]);
    let mut filed = plan_stages(mold, regions, libraries, (params, &stages, like), progress, cancel)?;
    let parts = |set: &ElectrodeSet| -> Vec<(usize, Vec<Vec<PartId>>)> {
        let of = |e: &Electrode| (e.stage, e.burns.iter().map(|b| b.parts.clone()).collect());
        set.electrodes.iter().map(of).collect()
    };
    let is_same = parts(&made) == parts(&filed);
    for (plan, made) in filed.regions.iter_mut().zip(made.regions) {
        plan.left = made.left;
        plan.left_out = made.left_out;
        plan.trouble = plan.trouble.take().or(made.trouble);
        if !is_same && plan.trouble.is_none() {
            plan.trouble = Some(OTHER_NET.to_owned());
        }
    }
    for (filed, made) in filed.checks.iter_mut().zip(made.checks).filter(|_| is_same) {
        for (net, real) in filed.iter_mut().zip(made) {
            if net.holds {
                *net = real;
            }
        }
    }
    Ok(filed)
}

fn plan_stages(
    mold: &Mesh,
    regions: &[RegionToBurn],
    (library, milled): (&CutterLibrary, &Milled),
    (params, stages, like): (&ElectrodeParams, &[Stage], Option<&[Electrode]>),
    progress: &Progress,
    cancel: &Cancel,
) -> Result<ElectrodeSet, ElectrodeError> {
    let cutters = params.cutters.as_ref().unwrap_or(library);
    let mut plans: Vec<RegionPlan> = regions.iter().map(|r| region_plan(r, params)).collect();
    let mut electrodes: Vec<Electrode> = Vec::new();
    // Of each stage, the share of each region that it has tips for.
    let mut made: Vec<Vec<f64>> = Vec::new();
    for (number, stage) in stages.iter().enumerate() {
        progress.report("electrodes", number as f64 / stages.len() as f64 * 0.7, &stage.name);
        let is_last = number + 1 == stages.len();
        made.push(vec![1.0; regions.len()]);
        let mut directions: Vec<DVec3> = Vec::new();
        for plan in &plans {
            if !directions.contains(&plan.direction) {
                directions.push(plan.direction);
            }
        }
        for direction in directions {
            let setting = Setting::new(mold, direction, stage)?;
            let here: Vec<usize> = (0..regions.len()).filter(|r| plans[*r].direction == direction).collect();
            let leaves = leaves(&setting, regions, (&here, is_last), (&mut plans, &mut made), params, cancel)?;
            let shared = shared(&setting, &leaves, regions, cutters, params, cancel)?;
            for group in &shared {
                match assembled(&setting, &leaves, group, regions, (number, params, &made)) {
                    Ok(electrode) => electrodes.push(electrode),
                    Err(ElectrodeError::Solid(error)) => {
                        let ids = group.burns.iter().flat_map(|(.., ids)| ids).map(|i| leaves[*i].id.region);
                        ids.for_each(|r| plans[r].trouble = Some(format!("{} stage: {error}", stage.name)));
                    }
                    Err(other) => return Err(other),
                }
            }
        }
    }
    into_families(mold, &mut electrodes, like, (cutters, params, stages), cancel)?;
    named(&mut electrodes, params);
    progress.report("checks", 0.7, "");
    let checks = checked((mold, milled), &electrodes, &mut plans, regions, (cutters, params, stages), cancel)?;
    progress.report("checks", 1.0, "");
    Ok(ElectrodeSet { params: params.clone(), electrodes, checks, regions: plans })
}

/// The stage as files of the net shape hold it.
fn net(stage: &Stage) -> Stage {
    Stage { gap_mm: 0.0, stock_mm: 0.0, orbit: Default::default(), ..stage.clone() }
}

/// How far a place of an edit may be from a region's surface, or from a part in plan (mm).
pub(super) const TOUCHES: f64 = 0.5;

fn holds(region: &RegionToBurn, place: DVec3) -> bool {
    let mut surface = Mesh::default();
    for corners in &region.corners {
        let first = surface.vertices.len() as u32;
        surface.vertices.extend(corners);
        surface.triangles.push([first, first + 1, first + 2]);
    }
    ExactMesh::new(&surface).is_ok_and(|s| s.nearest(place).point.distance(place) < TOUCHES)
}

fn region_plan(region: &RegionToBurn, params: &ElectrodeParams) -> RegionPlan {
    let mut method = if region.has_whole_faces { Method::Extruding } else { Method::Cutting };
    let mut direction = DVec3::NEG_Z;
    let mut edits = Vec::new();
    for (number, edit) in params.edits.iter().enumerate() {
        match edit {
            Edit::Make { place, method: chosen } if holds(region, *place) => method = *chosen,
            Edit::Burn { place, direction: chosen } if holds(region, *place) => direction = chosen.normalize_or_zero(),
            _ => continue,
        }
        edits.push(number);
    }
    if direction == DVec3::ZERO {
        direction = DVec3::NEG_Z;
    }
    RegionPlan {
        tree: None,
        method,
        direction,
        edits,
        trouble: None,
        left_out: Vec::new(),
        left: LeftOfRegion::default(),
    }
}

/// The tips of these regions; what stands in their way is told in their plans. `made` has a list of shares for each stage up
/// to this one, the place in whose last these are noted.
fn leaves(
    setting: &Setting,
    regions: &[RegionToBurn],
    (here, is_last): (&[usize], bool),
    (plans, made): (&mut [RegionPlan], &mut [Vec<f64>]),
    params: &ElectrodeParams,
    cancel: &Cancel,
) -> Result<Vec<Leaf>, ElectrodeError> {
    let burns = |p: DVec3| setting.burns(p);
    let own: Vec<&RegionToBurn> = here.iter().map(|r| &regions[*r]).collect();
    let edits = named_by_edits(&own, &params.edits, |p| (setting.turned * p).truncate());
    let of = |(r, edits): (&usize, &Vec<usize>)| {
        parts_of(setting, &regions[*r], (plans[*r].method, edits), (params, is_last), cancel)
    };
    let found: Vec<Result<Divided, TipError>> = here.par_iter().zip(&edits).map(of).collect();
    let (number, least) = (made.len().saturating_sub(1), params.least_size_mm);
    let mut leaves = Vec::new();
    for (region, found) in here.iter().zip(found) {
        let plan = &mut plans[*region];
        let mut share = 1.0;
        match found {
            Ok(Divided { tree, parts, met, in_plan, is_lacking }) => {
                plan.tree = Some(tree);
                plan.edits.extend(met);
                let mut parts: Vec<(usize, Part)> = parts.into_iter().enumerate().collect();
                let mut is_close = false;
                if !is_last {
                    (share, is_close) = thick_only(setting, &mut parts, &in_plan, (least, is_lacking));
                }
                if share < 1.0 {
                    plan.left_out.push(left_to_later(&setting.stage, number, (share, is_close), least));
                }
                let forms: Vec<Form> = parts.par_iter().map(|(_, p)| Form::of(&p.body, burns)).collect();
                leaves.extend(parts.into_iter().zip(forms).map(|((part, leaf), form)| {
                    let id = PartId { region: *region, part };
                    Leaf { id, part: leaf, form }
                }));
            }
            Err(TipError::Cancelled(cancelled)) => return Err(cancelled.into()),
            Err(TipError::NoRoom) if !is_last => {
                share = 0.0;
                plan.left_out.push(no_room(&setting.stage, number));
            }
            Err(other) => plan.trouble = Some(format!("{} stage: {other}", setting.stage.name)),
        }
        if let Some(shares) = made.last_mut() {
            shares[*region] = share;
        }
    }
    Ok(leaves)
}

/// A region's division.
struct Divided {
    tree: PartNode,
    parts: Vec<Part>,
    /// The changes that it was met by.
    met: Vec<usize>,
    /// The region in plan.
    in_plan: Vec<Outline>,
    /// Whether it lacks parts that would be too thin.
    is_lacking: bool,
}

/// The parts of a region after division and those of the user's changes that may meet it.
fn parts_of(
    setting: &Setting,
    region: &RegionToBurn,
    (method, edits): (Method, &[usize]),
    (params, is_last): (&ElectrodeParams, bool),
    cancel: &Cancel,
) -> Result<Divided, TipError> {
    let corners = region.corners.iter().map(|c| c.map(|p| setting.turned * p)).collect();
    let highest = || region.corners.iter().flatten().map(|p| (setting.turned * *p).z).fold(f64::NEG_INFINITY, f64::max);
    let rim = if setting.turned == DMat3::IDENTITY { region.rim } else { highest() };
    let keeps_gap = |p: DVec3| setting.keeps_gap(p);
    let burned = Burned {
        kept_clear: &setting.kept_clear,
        exact: &setting.exact,
        gap_up: setting.stage.undersize(DVec3::Z),
        gap_across: setting.stage.most_across(),
        keeps_gap: &keeps_gap,
    };
    let place = Place::new(corners, rim);
    let settings =
        DivisionSettings { overlap: params.overlap_mm, least: params.least_size_mm, leaves_out_thin: !is_last };
    let first = footprint(&burned, &place, method, params.margin_mm, cancel)?;
    let in_plan = first.region.clone();
    let mut divided = divide(&burned, first, &settings, cancel)?;
    let mut met = Vec::new();
    for &number in edits {
        if apply(&burned, &mut divided, &params.edits[number], |p| (setting.turned * p).truncate(), &settings)? {
            met.push(number);
        }
    }
    let tree = node(&divided, &places(&divided), &mut 0);
    let parts = divided.leaves().into_iter().cloned().collect();
    Ok(Divided { tree, parts, met, in_plan, is_lacking: divided.is_lacking() })
}

fn node(part: &Part, places: &[Option<DVec2>], count: &mut usize) -> PartNode {
    let outlines = part.footprint.free.iter().map(|o| o.points().to_vec()).collect();
    let (cut, h_edges) = (part.divided.as_ref().map(|(cut, _)| *cut), part.h_edges.len());
    let parts = part.divided.iter().flat_map(|(_, parts)| parts);
    let parts: Vec<PartNode> = parts.map(|p| node(p, places, count)).collect();
    let number = parts.is_empty().then_some(*count);
    let place = number.and_then(|number| places.get(number).copied().flatten());
    *count += usize::from(number.is_some());
    PartNode { cut, h_edges, outlines, parts, lacks_thin: part.lacks_thin, part: number, place }
}

/// Names: numbers by design, the same for all stages where they burn the same parts.
fn named(electrodes: &mut [Electrode], params: &ElectrodeParams) {
    let mut known: Vec<Vec<PartId>> = Vec::new();
    for electrode in electrodes.iter_mut() {
        let parts = parts(electrode);
        let number = known.iter().position(|k| *k == parts).unwrap_or_else(|| {
            known.push(parts);
            known.len() - 1
        });
        let stage = &params.stages[electrode.stage].name;
        electrode.name = if params.stages.len() == 1 {
            format!("E{:02}", number + 1)
        } else {
            format!("E{:02}-{stage}", number + 1)
        };
        if let Family::Member { name, .. } = &mut electrode.family {
            *name = format!("E{:02}", number + 1);
        }
    }
}

impl Electrode {
    /// A mesh of its own where a burn puts it, in the burn frame given by the rotation to it.
    pub fn burning(&self, mesh: &Mesh, burn: &Burn, turned: &DMat3) -> Mesh {
        placed(mesh, burn.turn, *turned * burn.position)
    }
}
