//! From regions to electrodes.

use glam::{DMat3, DQuat, DVec2, DVec3};
use rayon::prelude::*;

use super::base::{Base, INTO_BASE, placed};
use super::check::{
    self, Burning, Finding, GOUGE, LeftOfRegion, Milled, Obstacle, Sample, allowed, left_by, leftover, machinable,
    watertight,
};
use super::combine::{Form, near};
use super::design::{Burn, Electrode, ElectrodeSet, PartId, PartNode, RegionPlan};
use super::division::{Cut, DivisionSettings, Part, cut_along, divide, whole};
use super::params::{Edit, ElectrodeParams, ElectrodeParamsError, Method, Shape, Stage};
use super::tip::{Burned, Place, TipError, footprint, led_up};
use crate::geometry::exact::{ExactMesh, ExactMeshError};
use crate::geometry::mesh::{Bounds, Mesh, unit_normal};
use crate::geometry::offset::{OffsetError, offset};
use crate::geometry::solid::SolidError;
use crate::mold::cutter::{Cutter, CutterLibrary};
use crate::mold::height_field::HeightFieldError;
use crate::mold::outline::Outline;
use crate::mold::plane;
use crate::progress::{Cancel, Cancelled, Progress};

/// How far off a burn surface a point of a tip may be to be part of it (mm).
const ON_BURN: f64 = 1e-6;
/// The z component of the unit normal from which on a face is a floor.
const FLOOR: f64 = 0.5;
/// Samples of a region's surface at most.
const SAMPLES: usize = 6000;

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
struct Setting {
    /// From the upright mold to the burn frame.
    turned: DMat3,
    mold: Mesh,
    kept_clear: Mesh,
    stage: Stage,
}

impl Setting {
    fn new(mold: &Mesh, direction: DVec3, stage: &Stage) -> Result<Self, ElectrodeError> {
        let turned = to_burn_frame(direction);
        let mold = mold.mapped(|p| turned * p);
        let kept_clear = offset(&mold, |n| stage.undersize(n))?;
        Ok(Self { turned, mold, kept_clear, stage: stage.clone() })
    }

    fn burned(&self) -> Burned<'_> {
        Burned { kept_clear: &self.kept_clear, gap_up: self.stage.undersize(DVec3::Z) }
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
struct Leaf {
    id: PartId,
    part: Part,
    form: Form,
}

/// One electrode for several leaves: which, turned and shifted how.
struct Shared {
    /// The leaves of the first burn.
    leaves: Vec<usize>,
    /// The burns; the first is as the leaves stand.
    burns: Vec<(f64, DVec3, Vec<usize>)>,
}

/// Electrodes for `regions` of a mold that opens along +Z.
///
/// # Errors
/// [`ElectrodeError`].
pub fn plan(
    mold: &Mesh,
    regions: &[RegionToBurn],
    (library, milled): (&CutterLibrary, &Milled),
    params: &ElectrodeParams,
    progress: &Progress,
    cancel: &Cancel,
) -> Result<ElectrodeSet, ElectrodeError> {
    params.validate()?;
    let cutters = params.cutters.as_ref().unwrap_or(library);
    let stages: Vec<Stage> = params.stages.iter().map(|stage| as_filed(stage, params.shape)).collect();
    let mut plans: Vec<RegionPlan> = regions.iter().map(|r| region_plan(r, params)).collect();
    let mut electrodes: Vec<Electrode> = Vec::new();
    for (number, stage) in stages.iter().enumerate() {
        progress.report("electrodes", number as f64 / stages.len() as f64 * 0.7, &stage.name);
        let mut directions: Vec<DVec3> = Vec::new();
        for plan in &plans {
            if !directions.contains(&plan.direction) {
                directions.push(plan.direction);
            }
        }
        for direction in directions {
            let setting = Setting::new(mold, direction, stage)?;
            let here: Vec<usize> = (0..regions.len()).filter(|r| plans[*r].direction == direction).collect();
            let leaves = leaves(&setting, regions, &here, &mut plans, params, cancel)?;
            let shared = shared(&setting, &leaves, regions, cutters, params, cancel)?;
            for group in &shared {
                electrodes.push(assembled(&setting, &leaves, group, regions, (number, params))?);
            }
        }
    }
    named(&mut electrodes, params);
    progress.report("checks", 0.7, "");
    let checks = checked((mold, milled), &electrodes, &mut plans, regions, (cutters, params, &stages), cancel)?;
    progress.report("checks", 1.0, "");
    Ok(ElectrodeSet { params: params.clone(), electrodes, checks, regions: plans })
}

/// The stage as its files hold it: a net shape has no gap.
fn as_filed(stage: &Stage, shape: Shape) -> Stage {
    match shape {
        Shape::Undersized => stage.clone(),
        Shape::Net => Stage { gap_mm: 0.0, orbit: Default::default(), ..stage.clone() },
    }
}

/// How far a place of an edit may be from a region's surface (mm).
const TOUCHES: f64 = 0.5;

fn holds(region: &RegionToBurn, place: DVec3) -> bool {
    let near = |c: &[DVec3; 3]| c.iter().any(|p| p.distance(place) < TOUCHES);
    region.corners.iter().any(near)
}

fn region_plan(region: &RegionToBurn, params: &ElectrodeParams) -> RegionPlan {
    let mut method = if region.has_whole_faces { Method::Extruding } else { Method::Cutting };
    let mut direction = DVec3::NEG_Z;
    for edit in &params.edits {
        match edit {
            Edit::Make { place, method: chosen } if holds(region, *place) => method = *chosen,
            Edit::Burn { place, direction: chosen } if holds(region, *place) => direction = chosen.normalize_or_zero(),
            _ => {}
        }
    }
    if direction == DVec3::ZERO {
        direction = DVec3::NEG_Z;
    }
    RegionPlan { tree: None, method, direction, trouble: None, left: LeftOfRegion::default() }
}

/// The tips of these regions; what stands in their way is told in their plans.
fn leaves(
    setting: &Setting,
    regions: &[RegionToBurn],
    here: &[usize],
    plans: &mut [RegionPlan],
    params: &ElectrodeParams,
    cancel: &Cancel,
) -> Result<Vec<Leaf>, ElectrodeError> {
    let kept = ExactMesh::new(&setting.kept_clear)?;
    let burns = |p: DVec3| kept.nearest(p).signed_distance.abs() < ON_BURN;
    let of = |r: &usize| parts_of(setting, &regions[*r], plans[*r].method, params, cancel);
    let found: Vec<Result<(PartNode, Vec<Part>), TipError>> = here.par_iter().map(of).collect();
    let mut leaves = Vec::new();
    for (region, found) in here.iter().zip(found) {
        match found {
            Ok((tree, parts)) => {
                plans[*region].tree = Some(tree);
                let forms: Vec<Form> = parts.par_iter().map(|p| Form::of(&p.body, burns)).collect();
                let numbered = parts.into_iter().zip(forms).enumerate();
                leaves.extend(numbered.map(|(part, (leaf, form))| {
                    let id = PartId { region: *region, part };
                    Leaf { id, part: leaf, form }
                }));
            }
            Err(TipError::Cancelled(cancelled)) => return Err(cancelled.into()),
            Err(other) => plans[*region].trouble = Some(format!("{} stage: {other}", setting.stage.name)),
        }
    }
    Ok(leaves)
}

/// The parts of a region after division and the user's changes.
fn parts_of(
    setting: &Setting,
    region: &RegionToBurn,
    method: Method,
    params: &ElectrodeParams,
    cancel: &Cancel,
) -> Result<(PartNode, Vec<Part>), TipError> {
    let corners = region.corners.iter().map(|c| c.map(|p| setting.turned * p)).collect();
    let highest = || region.corners.iter().flatten().map(|p| (setting.turned * *p).z).fold(f64::NEG_INFINITY, f64::max);
    let rim = if setting.turned == DMat3::IDENTITY { region.rim } else { highest() };
    let burned = setting.burned();
    let place = Place::new(corners, rim);
    let settings = DivisionSettings { overlap: params.overlap_mm, least: params.least_size_mm };
    let first = footprint(&burned, &place, method, params.margin_mm, cancel)?;
    let divided = divide(&burned, first, &settings, cancel)?;
    let mut count = 0;
    let tree = node(&divided, &mut count);
    let mut parts: Vec<Part> = divided.leaves().into_iter().cloned().collect();
    for edit in &params.edits {
        apply(&burned, &mut parts, edit, setting, &settings)?;
    }
    Ok((tree, parts))
}

/// A change of the user's, made to the parts of a region.
fn apply(
    burned: &Burned,
    parts: &mut Vec<Part>,
    edit: &Edit,
    setting: &Setting,
    settings: &DivisionSettings,
) -> Result<(), TipError> {
    let holder = |parts: &[Part], p: DVec2| parts.iter().position(|part| plane::holds(&part.footprint.free, p));
    let plan = |p: DVec3| (setting.turned * p).truncate();
    match edit {
        Edit::Split { line: [a, b] } => {
            let [a, b] = [a, b].map(|p| plan(p.extend(0.0)));
            let outward = (b - a).perp().normalize_or_zero();
            let Some(i) = holder(parts, a.midpoint(b)).filter(|_| outward != DVec2::ZERO) else { return Ok(()) };
            let cut = Cut { through: a.midpoint(b), outward, overlaps: true };
            let (halves, _) = cut_along(&parts[i].footprint, &cut, settings);
            if halves.len() > 1 {
                let halves = halves.into_iter().map(|f| whole(burned, f)).collect::<Result<Vec<_>, _>>()?;
                parts.splice(i..=i, halves);
            }
        }
        Edit::Merge { places } => {
            let [a, b] = places.map(plan).map(|p| holder(parts, p));
            let (Some(a), Some(b)) = (a, b) else { return Ok(()) };
            if a != b {
                let other = parts.remove(a.max(b));
                let one = &mut parts[a.min(b)];
                let joined = |x: &[Outline], y: &[Outline]| plane::union(x, y).into_iter().flatten().collect();
                let mut footprint = one.footprint.clone();
                footprint.outlines = joined(&footprint.outlines, &other.footprint.outlines);
                footprint.free = joined(&footprint.free, &other.footprint.free);
                footprint.region = joined(&footprint.region, &other.footprint.region);
                *one = whole(burned, footprint)?;
            }
        }
        Edit::Make { .. } | Edit::Burn { .. } => {}
    }
    Ok(())
}

fn node(part: &Part, count: &mut usize) -> PartNode {
    let outlines = part.footprint.free.iter().map(|o| o.points().to_vec()).collect();
    let (cut, h_edges) = (part.divided.as_ref().map(|(cut, _)| *cut), part.h_edges.len());
    let parts: Vec<PartNode> = part.divided.iter().flat_map(|(_, parts)| parts).map(|p| node(p, count)).collect();
    let number = parts.is_empty().then_some(*count);
    *count += usize::from(number.is_some());
    PartNode { cut, h_edges, outlines, parts, part: number }
}

/// Which leaves one electrode burns: congruent ones at several positions, near ones at once.
fn shared(
    setting: &Setting,
    leaves: &[Leaf],
    regions: &[RegionToBurn],
    cutters: &CutterLibrary,
    params: &ElectrodeParams,
    cancel: &Cancel,
) -> Result<Vec<Shared>, ElectrodeError> {
    let mold = Obstacle::new(&setting.mold)?;
    let mut groups: Vec<Shared> = Vec::new();
    for (i, leaf) in leaves.iter().enumerate() {
        cancel.check()?;
        let fits = |group: &Shared| -> Option<(f64, DVec3)> {
            let first = &leaves[group.leaves[0]];
            let onto = first.form.onto(&leaf.form);
            onto.into_iter().find(|by| serves(setting, &mold, (first, leaf), *by, regions, params).unwrap_or(false))
        };
        let found =
            params.share.then(|| groups.iter().enumerate().find_map(|(g, group)| Some((g, fits(group)?)))).flatten();
        match found {
            Some((g, (turn, shift))) => groups[g].burns.push((turn, shift, vec![i])),
            None => groups.push(Shared { leaves: vec![i], burns: vec![(0.0, DVec3::ZERO, vec![i])] }),
        }
    }
    let (single, mut several): (Vec<Shared>, Vec<Shared>) = groups.into_iter().partition(|g| g.burns.len() == 1);
    let radius = cutters.needed().iter().map(|c: &&Cutter| c.radius()).fold(f64::INFINITY, f64::min);
    let boxes: Vec<[DVec2; 2]> =
        single.iter().map(|g| plane::extent(&leaves[g.leaves[0]].part.footprint.free)).collect();
    // A cutter has to pass between two tips.
    for members in near(&boxes, params.together_mm, 2.2 * radius) {
        let all: Vec<usize> = members.iter().flat_map(|m| single[*m].leaves.iter().copied()).collect();
        several.push(Shared { burns: vec![(0.0, DVec3::ZERO, all.clone())], leaves: all });
    }
    several.sort_by_key(|g| g.leaves[0]);
    Ok(several)
}

/// Whether the tip of `first`, moved, burns what `leaf` is for as well as its own tip does, and keeps the gap.
fn serves(
    setting: &Setting,
    mold: &Obstacle,
    (first, leaf): (&Leaf, &Leaf),
    (turn, shift): (f64, DVec3),
    regions: &[RegionToBurn],
    params: &ElectrodeParams,
) -> Result<bool, ElectrodeError> {
    let moved = placed(&first.part.body, turn, shift);
    let least = params.tolerance_mm / 2.0;
    let (own, other) = (Burning::new(&leaf.part.body, &setting.stage)?, Burning::new(&moved, &setting.stage)?);
    let corners = &regions[leaf.id.region].corners;
    let stride = corners.len() / 400 + 1;
    let points = corners.iter().step_by(stride).map(|c| setting.turned * ((c[0] + c[1] + c[2]) / 3.0));
    for p in points {
        // What the leaf's own tip burns.
        let by_own = own.beyond(p);
        if by_own <= least && other.beyond(p) > by_own.max(0.0) + least {
            return Ok(false);
        }
    }
    let gap = setting.stage.gap_mm - GOUGE;
    if moved.vertices.iter().any(|p| mold.distance(*p) < gap) {
        return Ok(false);
    }
    let found = mold.clearance(&moved, &Stage { orbit: Default::default(), ..setting.stage.clone() }, 0.0)?;
    Ok(found[0].holds)
}

/// The electrode of a group.
fn assembled(
    setting: &Setting,
    leaves: &[Leaf],
    group: &Shared,
    regions: &[RegionToBurn],
    (stage, params): (usize, &ElectrodeParams),
) -> Result<Electrode, ElectrodeError> {
    let top = setting.mold.bounds().max.z;
    let highest = group.burns.iter().map(|(_, shift, _)| -shift.z).fold(0.0, f64::max);
    let seat = top + params.extension_mm + highest;
    let raised: Vec<Mesh> = group
        .leaves
        .iter()
        .map(|i| led_up(&leaves[*i].part.body, leaves[*i].part.footprint.cap, seat + INTO_BASE))
        .collect();
    let around = Bounds::of(raised.iter().flat_map(|m| m.vertices.iter().copied()));
    let middle = around.center().truncate();
    let origin = middle.extend(seat);
    let tips: Vec<Mesh> = raised.iter().map(|m| m.mapped(|p| p - origin)).collect();
    let around = Bounds { min: around.min, max: around.max.with_z(seat) };
    let (base, length) = Base::under(&around, params);
    let mesh = base.with_tips(&tips)?;
    let back = setting.turned.transpose();
    let holder = params.holders.iter().position(|h| {
        let [x, y] = h.size_mm;
        base.sides.x.min(base.sides.y) <= x.min(y) && base.sides.max_element() <= x.max(y)
    });
    let front_area = group.leaves.iter().map(|i| plane::area(&leaves[*i].part.footprint.free)).sum();
    let first = &params.stages[stage];
    let mut minutes = 0.0;
    let burns: Vec<Burn> = group
        .burns
        .iter()
        .map(|(turn, shift, ids)| {
            let volume = ids.iter().map(|i| share_of(&leaves[*i], leaves, regions)).sum();
            minutes += params.removal.minutes(volume, front_area, first.finish_vdi);
            let at = DVec2::from_angle(*turn).rotate(middle).extend(seat) + *shift;
            let parts = ids.iter().map(|i| leaves[*i].id).collect();
            Burn { position: back * at, turn: *turn, parts, depth: top - around.min.z - shift.z, volume }
        })
        .collect();
    let only_tips = tips.into_iter().fold(Mesh::default(), |mut all, tip| {
        let first = all.vertices.len() as u32;
        all.vertices.extend(tip.vertices);
        all.triangles.extend(tip.triangles.iter().map(|t| t.map(|i| i + first)));
        all
    });
    let is_extruded = group.leaves.iter().all(|i| leaves[*i].part.footprint.method == Method::Extruding);
    Ok(Electrode {
        name: String::new(),
        stage,
        mesh,
        tips: only_tips,
        burns,
        direction: back * DVec3::NEG_Z,
        method: if is_extruded { Method::Extruding } else { Method::Cutting },
        blank: base.sides.extend(length),
        holder,
        minutes,
        front_area,
    })
}

/// The part of a region's volume that is a leaf's, by area.
fn share_of(leaf: &Leaf, leaves: &[Leaf], regions: &[RegionToBurn]) -> f64 {
    let area = |l: &Leaf| plane::area(&l.part.footprint.region).max(1e-12);
    let all: f64 = leaves.iter().filter(|l| l.id.region == leaf.id.region).map(area).sum();
    regions[leaf.id.region].volume * area(leaf) / all
}

/// Names: numbers by design, the same for all stages where they burn the same parts.
fn named(electrodes: &mut [Electrode], params: &ElectrodeParams) {
    let mut known: Vec<Vec<PartId>> = Vec::new();
    for electrode in electrodes.iter_mut() {
        let parts: Vec<PartId> = electrode.burns.iter().flat_map(|b| b.parts.iter().copied()).collect();
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
    }
}

impl Electrode {
    /// A mesh of its own where a burn puts it, in the burn frame given by the rotation to it.
    pub fn burning(&self, mesh: &Mesh, burn: &Burn, turned: &DMat3) -> Mesh {
        placed(mesh, burn.turn, *turned * burn.position)
    }
}

/// The findings for each electrode; what is left of each region goes into its plan.
fn checked(
    (mold, milled): (&Mesh, &Milled),
    electrodes: &[Electrode],
    plans: &mut [RegionPlan],
    regions: &[RegionToBurn],
    (cutters, params, stages): (&CutterLibrary, &ElectrodeParams, &[Stage]),
    cancel: &Cancel,
) -> Result<Vec<Vec<Finding>>, ElectrodeError> {
    let last = electrodes.iter().map(|e| e.stage).max().unwrap_or(0);
    let upright = Obstacle::new(mold)?;
    let left = (0..regions.len())
        .into_par_iter()
        .map(|r| left_of((&upright, milled), r, electrodes, &regions[r], stages, cancel));
    let left: Vec<LeftOfRegion> = left.collect::<Result<_, ElectrodeError>>()?;
    plans.iter_mut().zip(&left).for_each(|(plan, left)| plan.left = *left);
    let most = stages.get(last).map_or(params.tolerance_mm, |stage| allowed(stage, params.tolerance_mm));
    let check = |electrode: &Electrode| -> Result<Vec<Finding>, ElectrodeError> {
        cancel.check()?;
        let closed = watertight(&electrode.mesh);
        let is_closed = closed.holds;
        let mut findings = vec![closed];
        let turned = to_burn_frame(electrode.direction);
        let setting = mold.mapped(|p| turned * p);
        let obstacle = if turned == DMat3::IDENTITY { None } else { Some(Obstacle::new(&setting)?) };
        let obstacle = obstacle.as_ref().unwrap_or(&upright);
        let mut worst: [Option<Finding>; 2] = [None, None];
        for burn in &electrode.burns {
            let mesh = electrode.burning(&electrode.mesh, burn, &turned);
            let found = obstacle.clearance(&mesh, &stages[electrode.stage], params.lift_mm)?;
            for (worst, found) in worst.iter_mut().zip(found) {
                if worst.as_ref().is_none_or(|w| w.holds && !found.holds) {
                    let place = found.place.map(|p| turned.transpose() * p);
                    *worst = Some(Finding { place, ..found });
                }
            }
        }
        findings.extend(worst.into_iter().flatten());
        let own = electrode.burns.iter().flat_map(|b| &b.parts).map(|p| left[p.region]);
        if let Some(left) = own.max_by(|a, b| a.thickness.total_cmp(&b.thickness)) {
            findings.push(leftover(&left, most));
        }
        if is_closed {
            findings.push(placed_first(machinable(&electrode.tips, cutters, params.tolerance_mm, cancel)?, electrode));
        }
        Ok(findings)
    };
    electrodes.par_iter().map(check).collect()
}

/// A finding on an electrode by itself, with its place where the first burn puts it.
fn placed_first(finding: Finding, electrode: &Electrode) -> Finding {
    let Some(burn) = electrode.burns.first() else { return finding };
    let back = to_burn_frame(electrode.direction).transpose();
    let at = |p: DVec3| burn.position + back * DVec2::from_angle(burn.turn).rotate(p.truncate()).extend(p.z);
    Finding { place: finding.place.map(at), ..finding }
}

/// What all burns leave of a region.
fn left_of(
    (mold, milled): (&Obstacle, &Milled),
    number: usize,
    electrodes: &[Electrode],
    region: &RegionToBurn,
    stages: &[Stage],
    cancel: &Cancel,
) -> Result<LeftOfRegion, ElectrodeError> {
    let mut burns: Vec<Burning> = Vec::new();
    let mut turned = DMat3::IDENTITY;
    for electrode in electrodes {
        for burn in electrode.burns.iter().filter(|b| b.parts.iter().any(|p| p.region == number)) {
            turned = to_burn_frame(electrode.direction);
            let mesh = electrode.burning(&electrode.tips, burn, &turned);
            burns.push(Burning::new(&mesh, &stages[electrode.stage])?);
        }
    }
    let stride = region.corners.len() / SAMPLES + 1;
    let sample = |(corners, depth): (&[DVec3; 3], &f64)| {
        let upright = unit_normal(*corners).z;
        let [a, b, c] = corners.map(|p| turned * p);
        let twice = (b - a).cross(c - a);
        let (normal, area) = (twice.normalize_or_zero(), 0.5 * twice.length() * stride as f64);
        // What lies on a floor is as thick as it is high, across the surface.
        let thickest = if upright > FLOOR { (depth * upright).min(region.thickness) } else { region.thickness };
        Sample { point: (a + b + c) / 3.0, normal, area, thickest }
    };
    let samples: Vec<Sample> = region.corners.iter().zip(&region.depths).step_by(stride).map(sample).collect();
    let back = turned.transpose();
    let in_frame;
    let mold = if turned == DMat3::IDENTITY {
        mold
    } else {
        in_frame = mold.turned(&turned)?;
        &in_frame
    };
    let leaves = |p: DVec3| (milled.leaves)(back * p);
    let milled = Milled { leaves: &leaves, within: milled.within };
    let left = left_by(&burns.iter().collect::<Vec<_>>(), &samples, (mold, &milled), cancel)?;
    Ok(LeftOfRegion { place: back * left.place, ..left })
}

/// Checks of electrodes from elsewhere, placed in the upright mold, as those of a plan are checked.
///
/// # Errors
/// [`ElectrodeError`].
pub fn check_own(
    mold: &Mesh,
    electrode: &Mesh,
    stage: &Stage,
    (cutters, params): (&CutterLibrary, &ElectrodeParams),
    cancel: &Cancel,
) -> Result<Vec<Finding>, ElectrodeError> {
    let closed = check::watertight(electrode);
    let is_closed = closed.holds;
    let mut findings = vec![closed];
    findings.extend(Obstacle::new(mold)?.clearance(electrode, stage, params.lift_mm)?);
    if is_closed {
        findings.push(machinable(electrode, cutters, params.tolerance_mm, cancel)?);
    }
    Ok(findings)
}
