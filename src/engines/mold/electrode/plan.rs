//! From regions to electrodes.

use files::Validate;
use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{DMat3, DVec2, DVec3};
use rayon::prelude::*;

use super::arrangement::{Arranged, Arrangement};
use super::base::placed;
use super::combine::Form;
use super::design::{Burn, Electrode, ElectrodeSet, PartId, PartNode, RegionPlan};
use super::division::{DivisionSettings, Part, divide};
use super::earlier::{is_nothing, left_to_later, no_room, nothing, thick_only};
use super::edits::{apply, named as named_by_edits, places, pointed_at};
use super::family::into_families;
use super::h_edge::{Milling, chains};
use super::names::named;
use super::net_shape::{net, told_of_real};
use super::params::{Edit, ElectrodeParams, Method, Shape, Stage};
use super::part_numbers::{Numbered, Parts, numbers, renumber, shape, volumes};
use super::plan_checks::checked;
use super::residual_stock::{LeftOfRegion, Milled};
use super::samples::samples;
use super::setting::{ElectrodeError, KeptClear, RegionToBurn, Setting};
use super::sharing::{Leaf, assembled, shared};
use super::tip::{Burned, Place, Rooms, TipError, footprint};
use crate::cutter::CutterLibrary;
use crate::outline::Outline;
use crate::plane;
use burning::choice::Piece;
use geometry::mesh::Mesh;
use task::{Cancel, Task};

/// How far below the underside of a mold heads of regions go that go through it (mm).
const THROUGH: f64 = 0.5;

/// Electrodes for `regions` of a mold that opens along +Z.
///
/// # Errors
/// [`ElectrodeError`].
pub fn plan(
    mold: &Mesh,
    regions: &[RegionToBurn],
    libraries: (&CutterLibrary, &Milled),
    params: &ElectrodeParams,
    task: &Task,
) -> Result<ElectrodeSet, ElectrodeError> {
    params.validate()?;
    let (made, parts) = plan_stages(mold, regions, libraries, (params, &params.stages, None), task)?;
    if params.shape == Shape::Undersized {
        return Ok(made);
    }
    // Files of the net shape are those of an electrode without gap; it is the real one that has to come out.
    let stages: Vec<Stage> = params.stages.iter().map(net).collect();
    let like = Some((&made.electrodes[..], &parts));
    let (filed, _) = plan_stages(mold, regions, libraries, (params, &stages, like), task)?;
    Ok(told_of_real(filed, made))
}

/// Electrodes of which these are the net shapes, and the parts that they burn.
type Real<'a> = (&'a [Electrode], &'a Parts);

fn plan_stages(
    mold: &Mesh,
    regions: &[RegionToBurn],
    (library, milled): (&CutterLibrary, &Milled),
    (params, stages, like): (&ElectrodeParams, &[Stage], Option<Real>),
    task: &Task,
) -> Result<(ElectrodeSet, Parts), ElectrodeError> {
    let cutters = params.cutters.as_ref().unwrap_or(library);
    let mut plans = region_plans(regions, params);
    let mut directions: Vec<DVec3> = Vec::new();
    for plan in &plans {
        if !directions.contains(&plan.direction) {
            directions.push(plan.direction);
        }
    }
    let mut electrodes: Vec<Electrode> = Vec::new();
    let mut parts: Parts = vec![Vec::new(); regions.len()];
    // Of each stage, the share of each region that it has tips for.
    let mut made = vec![vec![1.0; regions.len()]; stages.len()];
    // The last stage, which burns everything, tells what the parts are.
    for (number, stage) in stages.iter().enumerate().rev() {
        let done = (1.0 - (number + 1) as f64 / stages.len() as f64) * 0.7;
        let is_last = number + 1 == stages.len();
        for &direction in &directions {
            task.report("electrodes", done, &stage.name);
            let here: Vec<usize> =
                (0..regions.len()).filter(|r| plans[*r].direction == direction && !plans[*r].is_set_aside).collect();
            let setting = Setting::new(mold, direction, stage)?;
            let known = (&mut parts, like.map(|(_, parts)| parts));
            let found = (&mut plans[..], &mut made[number][..]);
            let division = division_settings(params, (library, cutters), is_last);
            let leaves = leaves(&setting, regions, (&here, number, &division), (found, known), params, &task.cancel)?;
            task.report("sharing", done, &stage.name);
            let arrangement = Arrangement::of(&leaves, &params.edits, (regions, &plans, &parts), number);
            let (shared, met) = shared(&setting, (&leaves, &arrangement), regions, cutters, params, &task.cancel)?;
            let arranged = arrangement.arranged.iter().filter(|(edit, _)| met.contains(edit));
            let arranged = arranged
                .map(|(edit, Arranged::Joined([a, _]) | Arranged::Copied([a, _]))| (*edit, leaves[*a].id.region));
            arrangement.met.iter().copied().chain(arranged).for_each(|(edit, region)| plans[region].edits.push(edit));
            for group in &shared {
                match assembled(&setting, &leaves, group, (number, params, cutters)) {
                    Ok(electrode) => electrodes.push(electrode),
                    Err(ElectrodeError::Solid(error)) => {
                        let ids = group.burns.iter().flat_map(|(.., ids)| ids).map(|i| leaves[*i].id.region);
                        let why = format!(
                            "{} stage: the heads and their base make no closed body: {error}; divide the region, or \
                             change the margin of the heads",
                            stage.name
                        );
                        ids.for_each(|r| plans[r].reason = Some(why.clone()));
                    }
                    Err(other) => return Err(other),
                }
            }
        }
    }
    electrodes.sort_by_key(|e| e.stage);
    plans.iter_mut().for_each(|plan| plan.left_out.sort_by_key(|left| left.stage));
    with_volumes(&mut electrodes, &volumes(regions, &plans, &parts, params, &made), &parts);
    into_families(mold, &mut electrodes, like.map(|(real, _)| real), (cutters, params, stages), &task.cancel)?;
    let names = named(&mut electrodes, params, (regions, &plans, &parts))?;
    task.report("checks", 0.7, "");
    let of_regions = (&mut plans[..], regions, &parts);
    let checks = checked((mold, milled), &electrodes, of_regions, (cutters, params, stages), &task.cancel)?;
    task.report("checks", 1.0, "");
    Ok((ElectrodeSet { params: params.clone(), electrodes, checks, regions: plans, names }, parts))
}

/// Tells the burns what they take.
fn with_volumes(electrodes: &mut [Electrode], volumes: &BTreeMap<(usize, PartId), f64>, parts: &Parts) {
    for electrode in electrodes {
        let stage = electrode.stage;
        let is_it = |id: &PartId, part: &&Numbered| (part.stage, part.number) == (stage, id.part);
        let front = |id: &PartId| parts[id.region].iter().find(|part| is_it(id, part)).and_then(|part| part.front);
        let head = |id: &PartId| {
            Some(Piece { volume_mm3: volumes.get(&(stage, *id)).copied()?, frontal_area_mm2: front(id)? })
        };
        for burn in &mut electrode.burns {
            burn.volume = burn.parts.iter().filter_map(|id| volumes.get(&(stage, *id))).sum();
            burn.heads = burn.parts.iter().map(head).collect();
        }
    }
}

/// How regions are burned, with those of the user's changes that say so: each is for the region nearest to its place.
fn region_plans(regions: &[RegionToBurn], params: &ElectrodeParams) -> Vec<RegionPlan> {
    let edits = pointed_at(regions, &params.edits);
    regions.iter().zip(edits).map(|(region, edits)| region_plan(region, edits, params)).collect()
}

fn region_plan(region: &RegionToBurn, edits: Vec<usize>, params: &ElectrodeParams) -> RegionPlan {
    let mut method = if region.has_whole_faces { Method::Extruding } else { Method::Cutting };
    let mut direction = DVec3::NEG_Z;
    let mut is_set_aside = false;
    for number in &edits {
        match &params.edits[*number] {
            Edit::Make { method: chosen, .. } => method = *chosen,
            Edit::Burn { direction: chosen, .. } => direction = chosen.normalize_or(DVec3::NEG_Z),
            Edit::SetAside { .. } => is_set_aside = true,
            _ => {}
        }
    }
    RegionPlan {
        tree: None,
        earlier: Vec::new(),
        method,
        direction,
        is_set_aside,
        edits,
        reason: None,
        reason_place: None,
        left_out: Vec::new(),
        left: LeftOfRegion::default(),
        proposal: None,
    }
}

/// Findings about regions: how they are burned, and the share of each that the stage has tips for.
type Found<'a> = (&'a mut [RegionPlan], &'a mut [f64]);
/// The parts of stages after this one, to which its own are added, and of electrodes of which these are the net shapes.
type Known<'a> = (&'a mut Parts, Option<&'a Parts>);

/// The tips of these regions for stage `number`; what stands in their way is listed in their plans.
fn leaves(
    setting: &Setting,
    regions: &[RegionToBurn],
    (here, number, division): (&[usize], usize, &DivisionSettings),
    ((plans, made), (parts, like)): (Found, Known),
    params: &ElectrodeParams,
    cancel: &Cancel,
) -> Result<Vec<Leaf>, ElectrodeError> {
    let is_last = !division.leaves_out_thin;
    let own: Vec<&RegionToBurn> = here.iter().map(|r| &regions[*r]).collect();
    let edits = named_by_edits(&own, &params.edits, |p| (setting.turned * p).truncate());
    let of = |(r, edits): (&usize, &Vec<usize>)| {
        parts_of(setting, &regions[*r], (plans[*r].method, edits), (params, division), cancel)
    };
    let found: Vec<Result<Divided, TipError>> = here.par_iter().zip(&edits).map(of).collect();
    let least = params.least_size_mm;
    let mut leaves = Vec::new();
    for (&r, found) in here.iter().zip(found) {
        let plan = &mut plans[r];
        match found {
            Ok(divided) => {
                let known = (&mut *parts, like);
                let (own, (share, is_close)) = numbered(setting, (r, number), divided, plan, known, (least, is_last));
                if share < 1.0 {
                    plan.left_out.push(left_to_later(&setting.stage, number, (share, is_close), least));
                }
                made[r] = share;
                leaves.extend(own);
            }
            Err(TipError::Cancelled(cancelled)) => return Err(cancelled.into()),
            Err(TipError::NoRoom | TipError::NoSurface) if is_nothing(&regions[r], params) => {
                made[r] = 0.0;
                plan.left_out.push(nothing(&setting.stage, number, regions[r].thickness));
            }
            Err(TipError::NoRoom) if !is_last => {
                made[r] = 0.0;
                plan.left_out.push(no_room(&setting.stage, number));
            }
            Err(other) => {
                plan.reason.get_or_insert(format!("{} stage: {other}", setting.stage.name));
            }
        }
    }
    Ok(leaves)
}

/// The parts of a region that a stage has tips for, by numbers that are the same in every stage, what share of the
/// region they burn, and whether a part was left out by hardly more than regions are known to.
fn numbered(
    setting: &Setting,
    (region, stage): (usize, usize),
    Divided { mut tree, parts, met, in_plan, is_lacking, clear }: Divided,
    plan: &mut RegionPlan,
    (known, like): Known,
    (least, is_last): (f64, bool),
) -> (Vec<Leaf>, (f64, bool)) {
    let shapes: Vec<Vec<Outline>> = parts.iter().map(shape).collect();
    let real = like.map(|parts| &parts[region]);
    let fresh = real.into_iter().chain([&known[region]]).flatten().map(|p| p.number + 1).max().unwrap_or(0);
    let same: Vec<&Numbered> = match real {
        Some(real) => real.iter().filter(|p| p.stage == stage).collect(),
        None => known[region].iter().collect(),
    };
    let numbers = numbers(&same, &shapes, fresh);
    renumber(&mut tree, &numbers);
    if plan.tree.is_none() {
        plan.tree = Some(tree);
    } else {
        plan.earlier.push((stage, tree));
    }
    plan.edits.extend(met);
    let mut parts: Vec<(usize, Part)> = numbers.iter().copied().zip(parts).collect();
    let share = if is_last { (1.0, false) } else { thick_only(setting, &mut parts, &in_plan, (least, is_lacking)) };
    let front = |number: usize| {
        parts.iter().find(|(kept, _)| *kept == number).map(|(_, part)| plane::area(&part.footprint.free))
    };
    let undivided = |number: usize| parts.iter().find(|(kept, _)| *kept == number).and_then(|(_, part)| part.undivided);
    known[region].extend(numbers.iter().zip(shapes).map(|(&number, shape)| Numbered {
        stage,
        number,
        shape,
        front: front(number),
        undivided: undivided(number),
    }));
    let forms: Vec<Form> = parts.par_iter().map(|(_, p)| Form::of(&p.body, |p| clear.burns(p))).collect();
    let leaf = |((part, leaf), form): ((usize, Part), Form)| Leaf {
        id: PartId { region, part },
        part: leaf,
        form,
        clear: clear.clone(),
    };
    (parts.into_iter().zip(forms).map(leaf).collect(), share)
}

/// How regions are divided for a stage: the mold was milled with a library, the electrodes are with these cutters.
fn division_settings<'a>(
    params: &ElectrodeParams,
    (library, cutters): (&CutterLibrary, &'a CutterLibrary),
    is_last: bool,
) -> DivisionSettings<'a> {
    let least = library.least_radius();
    DivisionSettings {
        overlap: params.overlap_mm,
        least: params.least_size_mm,
        at: params.divided_at,
        milling: Milling::by(cutters, params.tolerance_mm),
        cutters,
        tolerance: params.tolerance_mm,
        leaves_out_thin: !is_last,
        milled_by: if least.is_finite() { least } else { 0.0 },
    }
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
    clear: Arc<KeptClear>,
}

/// The parts of a region after division and those of the user's changes that may meet it.
fn parts_of(
    setting: &Setting,
    region: &RegionToBurn,
    (method, edits): (Method, &[usize]),
    (params, settings): (&ElectrodeParams, &DivisionSettings),
    cancel: &Cancel,
) -> Result<Divided, TipError> {
    let corners: Vec<[DVec3; 3]> = region.corners.iter().map(|c| c.map(|p| setting.turned * p)).collect();
    let (samples, _) = samples(&corners, region, (&[], &[]), [0.0; 2]);
    let on_surface: Vec<DVec3> = samples.into_iter().map(|sample| sample.point).collect();
    let highest = || region.corners.iter().flatten().map(|p| (setting.turned * *p).z).fold(f64::NEG_INFINITY, f64::max);
    // Layers may know less of a region than its surface does; above the mold there is nothing to burn.
    let known = if setting.turned == DMat3::IDENTITY { region.rim } else { f64::NEG_INFINITY };
    let rim = known.max(highest().min(setting.mold.bounds().max.z));
    let mut place = Place::new(corners, rim);
    if place.corners.is_empty() {
        return Err(TipError::NoSurface);
    }
    if region.is_through {
        place.bounds.min.z -= THROUGH;
    }
    let rooms = Rooms::around(&place, params.margin_mm);
    let clear = KeptClear::over(&setting.mold, &setting.stage, rooms.extent(), place.bounds.min.z, cancel)?;
    let clear = Arc::new(clear);
    let burned = Burned {
        kept_clear: &clear.mesh,
        trimmer: &clear.trimmer,
        gap_up: setting.stage.undersize(DVec3::Z),
        gap_across: setting.stage.most_across(),
        stage: &setting.stage,
        places: &on_surface,
    };
    let round = params.margin_mm.max(settings.milled_by);
    let is_tilted = setting.turned != DMat3::IDENTITY;
    let first = footprint(&burned, &place.bounds, &rooms, (method, round, is_tilted), cancel)?;
    let in_plan = first.region.clone();
    let mut divided = divide(&burned, &place.corners, first, settings, cancel)?;
    let mut met = Vec::new();
    for &number in edits {
        if apply(&burned, &mut divided, &params.edits[number], setting, settings)? {
            met.push(number);
        }
    }
    let tree = node(&divided, &places(&divided), &mut 0);
    let parts = divided.leaves().into_iter().cloned().collect();
    Ok(Divided { tree, parts, met, in_plan, is_lacking: divided.is_lacking(), clear })
}

fn node(part: &Part, places: &[Option<DVec2>], count: &mut usize) -> PartNode {
    let outlines = part.footprint.free.iter().map(|o| o.points().to_vec()).collect();
    let (cut, h_edges) = (part.divided.as_ref().map(|(cut, _)| *cut), chains(&part.h_edges));
    let heights = [part.footprint.low, part.footprint.cap];
    let parts = part.divided.iter().flat_map(|(_, parts)| parts);
    let parts: Vec<PartNode> = parts.map(|p| node(p, places, count)).collect();
    let number = parts.is_empty().then_some(*count);
    let place = number.and_then(|number| places.get(number).copied().flatten());
    *count += usize::from(number.is_some());
    PartNode { cut, h_edges, outlines, heights, parts, lacks_thin: part.lacks_thin, part: number, place }
}

impl Electrode {
    /// A mesh of its own where a burn puts it, in the burn frame given by the rotation to it.
    pub fn burning(&self, mesh: &Mesh, burn: &Burn, turned: &DMat3) -> Mesh {
        placed(mesh, burn.turn, *turned * burn.position)
    }
}
