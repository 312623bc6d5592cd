//! The user's changes to the division of a region.

use files::Invalid;
use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::cut::Cut;
use super::division::{DivisionSettings, Part, are_needed, cut_along, whole};
use super::params::Edit;
use super::setting::{RegionToBurn, Setting};
use super::tip::{Burned, Footprint, SKIN, TipError};
use crate::outline::{Outline, off_segment};
use crate::plane;
use geometry::exact::ExactMesh;
use geometry::mesh::Mesh;

/// How far a place of an edit may be from a region's surface, or from a part in plan (mm).
pub(super) const TOUCHES: f64 = 0.5;

/// Greatest gap that a cut leaves between two parts (mm).
const HAIR: f64 = 1e-3;
/// Regions whose distances from a place differ by less are as near (mm): they are known to cells of about this size.
const AS_NEAR: f64 = 0.02;

impl Edit {
    /// Whether it can be made.
    pub(super) fn validate(&self) -> Result<(), Invalid> {
        let is_place = self.places().iter().all(|place| place.is_finite());
        if !is_place {
            return Err(Invalid::of("", "its places must be finite numbers (mm)"));
        }
        match self {
            // Too long or too short a direction has no length that can be told.
            Self::Burn { direction, .. } if direction.try_normalize().is_none() => {
                Err(Invalid::of("direction", "must be finite and not zero; straight down is [0, 0, -1]"))
            }
            _ => Ok(()),
        }
    }
}

/// Makes a change to the parts of a region; whether it meets them.
///
/// # Errors
/// [`TipError`].
pub(super) fn apply(
    burned: &Burned,
    tree: &mut Part,
    edit: &Edit,
    setting: &Setting,
    settings: &DivisionSettings,
) -> Result<bool, TipError> {
    let plan = |place: DVec3| (setting.turned * place).truncate();
    match edit {
        Edit::Split { line } => {
            let [a, b] = line.map(plan);
            split(burned, tree, [a, b], settings)
        }
        Edit::SplitAlong { place } => {
            let face = setting.face_at(setting.turned * *place, TOUCHES);
            face.map_or(Ok(false), |face| split_along(burned, tree, (plan(*place), face), settings))
        }
        Edit::Merge { places } => {
            let [a, b] = places.map(plan);
            merge(burned, tree, [a, b], settings)
        }
        _ => Ok(false),
    }
}

/// Cuts the part that the middle of a line names along it.
fn split(burned: &Burned, tree: &mut Part, [a, b]: [DVec2; 2], settings: &DivisionSettings) -> Result<bool, TipError> {
    let (through, outward) = (a.midpoint(b), (b - a).perp().normalize_or_zero());
    let held = holder(tree, through).filter(|_| outward != DVec2::ZERO);
    let Some(part) = held.and_then(|way| at(tree, &way)) else { return Ok(false) };
    halve(burned, part, Cut::upright(through, outward, true), settings)
}

/// Cuts the part that a place in plan names along a face of its head, which is given by a point and its normal.
fn split_along(
    burned: &Burned,
    tree: &mut Part,
    (place, (through, normal)): (DVec2, (DVec3, DVec3)),
    settings: &DivisionSettings,
) -> Result<bool, TipError> {
    let Some(part) = holder(tree, place).and_then(|way| at(tree, &way)) else { return Ok(false) };
    let cut = part.cut_along_face(through, normal);
    cut.map_or(Ok(false), |cut| halve(burned, part, cut, settings))
}

/// Divides a part along a cut; whether there is something of it on both sides.
fn halve(burned: &Burned, part: &mut Part, cut: Cut, settings: &DivisionSettings) -> Result<bool, TipError> {
    let (halves, _) = cut_along(burned, part, &cut, settings);
    if halves.len() < 2 {
        return Ok(false);
    }
    match halves.into_iter().map(|f| whole(burned, f, settings)).collect::<Result<Vec<_>, _>>() {
        Ok(mut halves) => {
            let own = burned.by(&part.body);
            let mut is_needed = are_needed(burned, [&own, &own], &halves.iter().collect::<Vec<_>>()).into_iter();
            halves.retain(|_| is_needed.next().unwrap_or(true));
            part.divided = Some((cut, halves));
        }
        // A cut that leaves no head on one side divides nothing.
        Err(error) if error.is_no_head() => return Ok(false),
        Err(error) => return Err(error),
    }
    Ok(true)
}

/// Makes the parts that two places name one, which stands where the first of them stood.
fn merge(burned: &Burned, tree: &mut Part, places: [DVec2; 2], settings: &DivisionSettings) -> Result<bool, TipError> {
    let [Some(a), Some(b)] = places.map(|p| holder(tree, p)) else { return Ok(false) };
    if a == b {
        return Ok(false);
    }
    let (first, second) = if a < b { (a, b) } else { (b, a) };
    let Some(other) = at(tree, &second).map(|part| part.footprint.clone()) else { return Ok(false) };
    let Some(one) = at(tree, &first) else { return Ok(false) };
    let joined = |x: &[Outline], y: &[Outline]| plane::outlines(plane::union(x, y));
    let mut footprint = one.footprint.clone();
    // A hair between the two, which a cut leaves, is closed.
    let free = joined(&footprint.free, &other.free);
    footprint.free = plane::outlines(plane::grown(&plane::outlines(plane::grown(&free, HAIR)), -HAIR));
    footprint.outlines = plane::outlines(plane::grown(&footprint.free, SKIN));
    footprint.region = joined(&footprint.region, &other.region);
    footprint.removed.retain(|body| other.removed.contains(body));
    match whole(burned, footprint, settings) {
        Ok(joined) => *one = joined,
        Err(error) if error.is_no_head() => return Ok(false),
        Err(error) => return Err(error),
    }
    remove(tree, &second);
    Ok(true)
}

/// The way to the undivided part that a point names: the part whose share of the region holds it, else of those whose
/// tip or share does the one whose share is nearest, else the nearest part beside it. What is left often lies along
/// walls only, with the tip between them, and a neighbour's margin may reach over a part.
fn holder(tree: &Part, p: DVec2) -> Option<Vec<usize>> {
    let mut ways = Vec::new();
    ways_to(tree, Vec::new(), &mut ways);
    let named = ways.into_iter().filter_map(|(way, part)| {
        let Footprint { free, outlines, region, .. } = &part.footprint;
        let off = plane::off(region, p);
        let is_in_tip = plane::holds(outlines, p) || plane::holds(free, p);
        let is_inner = off == 0.0 && plane::holds(free, p);
        let is_beside = !is_in_tip && off > 0.0;
        // Between a wall and a tip the nearest of both says whose it is.
        let off = if is_beside { off.min(plane::off(free, p)) } else { off };
        (off <= TOUCHES || is_in_tip).then_some((is_beside, !is_inner, off, way))
    });
    named.min_by(|a, b| (a.0, a.1).cmp(&(b.0, b.1)).then(a.2.total_cmp(&b.2))).map(|(.., way)| way)
}

/// The undivided parts and the ways to them, in order.
fn ways_to<'a>(tree: &'a Part, way: Vec<usize>, ways: &mut Vec<(Vec<usize>, &'a Part)>) {
    let Some((_, parts)) = &tree.divided else { return ways.push((way, tree)) };
    for (i, part) in parts.iter().enumerate() {
        ways_to(part, way.iter().copied().chain([i]).collect(), ways);
    }
}

/// For each of these regions the changes to a division that may meet it, by their places in the list: of those nearest
/// to it in plan. Tips of neighbours overlap, and a change is for one region.
pub(super) fn named(
    regions: &[&RegionToBurn],
    edits: &[Edit],
    plan: impl Fn(DVec3) -> DVec2 + Sync,
) -> Vec<Vec<usize>> {
    let off = |region: &RegionToBurn, edit: &Edit| -> f64 {
        let places = match edit {
            Edit::Split { line: [a, b] } => [plan(*a).midpoint(plan(*b)); 2],
            Edit::SplitAlong { place } => [plan(*place); 2],
            Edit::Merge { places } => places.map(&plan),
            _ => return f64::INFINITY,
        };
        places.into_iter().map(|p| off_in_plan(region, &plan, p)).fold(0.0, f64::max)
    };
    let offs: Vec<Vec<f64>> = regions.par_iter().map(|r| edits.iter().map(|e| off(r, e)).collect()).collect();
    let least = |e: usize| offs.iter().map(|of| of[e]).fold(f64::INFINITY, f64::min);
    let nearest: Vec<f64> = (0..edits.len()).map(least).collect();
    let is_near = |of: &[f64], e: usize| of[e].is_finite() && of[e] <= nearest[e] + AS_NEAR;
    offs.iter().map(|of| (0..edits.len()).filter(|e| is_near(of, *e)).collect()).collect()
}

/// For each region those of the changes that say whether it is burned, how it is made and from where, by their places in
/// the list: each is for the region nearest to its place, if that is near enough.
pub(super) fn pointed_at(regions: &[RegionToBurn], edits: &[Edit]) -> Vec<Vec<usize>> {
    let mut of = vec![Vec::new(); regions.len()];
    for (number, edit) in edits.iter().enumerate() {
        let (Edit::Make { place, .. } | Edit::Burn { place, .. } | Edit::SetAside { place }) = edit else { continue };
        let offs: Vec<f64> = regions.par_iter().map(|region| off_in_space(region, *place)).collect();
        let nearest = offs.iter().copied().fold(f64::INFINITY, f64::min);
        let is_meant = |off: f64| off < TOUCHES && off <= nearest + AS_NEAR;
        offs.iter().zip(&mut of).filter(|(off, _)| is_meant(**off)).for_each(|(_, of)| of.push(number));
    }
    of
}

/// How far a point is from a region's surface (mm).
fn off_in_space(region: &RegionToBurn, p: DVec3) -> f64 {
    let vertices: Vec<DVec3> = region.corners.iter().flatten().copied().collect();
    let triangles = (0..region.corners.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let surface = ExactMesh::new(&Mesh { vertices, triangles });
    surface.map_or(f64::INFINITY, |surface| surface.nearest(p).point.distance(p))
}

/// How far a point is from a region in plan (mm).
pub(super) fn off_in_plan(region: &RegionToBurn, plan: impl Fn(DVec3) -> DVec2, p: DVec2) -> f64 {
    let of = |corners: &[DVec3; 3]| {
        let sides = [0, 1, 2].map(|i| [plan(corners[i]), plan(corners[(i + 1) % 3])]);
        let turns = sides.map(|[a, b]| (b - a).perp_dot(p - a));
        if turns.iter().all(|t| *t > 0.0) || turns.iter().all(|t| *t < 0.0) {
            return 0.0;
        }
        sides.into_iter().map(|[a, b]| off_segment(p, a, b)).fold(f64::INFINITY, f64::min)
    };
    region.corners.iter().map(of).fold(f64::INFINITY, f64::min)
}

/// A point of each undivided part that names it, in plan: of its share of the region and of no other's where there is
/// one.
pub(super) fn places(tree: &Part) -> Vec<Option<DVec2>> {
    let leaves = tree.leaves();
    let of = |(i, part): (usize, &&Part)| {
        let Footprint { free, region, .. } = &part.footprint;
        let inner = plane::outlines(plane::intersection(free, region));
        let others = leaves.iter().enumerate().filter(|(j, _)| *j != i);
        let others: Vec<Outline> = others.flat_map(|(_, other)| other.footprint.region.iter().cloned()).collect();
        let own = |of: &[Outline]| plane::inside(&plane::outlines(plane::difference(of, &others)));
        own(&inner).or_else(|| own(region)).or_else(|| plane::inside(region)).or_else(|| plane::inside(free))
    };
    leaves.iter().enumerate().map(of).collect()
}

/// The part at the end of a way that [`holder`] found.
fn at<'a>(tree: &'a mut Part, way: &[usize]) -> Option<&'a mut Part> {
    way.iter().try_fold(tree, |part, i| part.divided.as_mut()?.1.get_mut(*i))
}

/// Takes a part out of the tree; a part that is left with one only is that one.
fn remove(tree: &mut Part, way: &[usize]) {
    let Some((_, parts)) = &mut tree.divided else { return };
    match way {
        [i] => drop(parts.remove(*i)),
        [i, rest @ ..] => remove(&mut parts[*i], rest),
        [] => return,
    }
    if parts.len() == 1 {
        *tree = parts.remove(0);
    }
}
