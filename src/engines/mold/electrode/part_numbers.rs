//! Numbers of parts, the same place by the same number in every stage.
//!
//! Each stage divides a region for itself: where its gap is wider it has other parts. A part of one stage is that of
//! another if most of each, in plan, is most of the other. The last stage numbers its parts in the order of its tree;
//! what other stages have besides gets numbers of its own, so that no two places share one.

use std::collections::BTreeMap;

use super::cuts::Undivided;
use super::design::{PartId, PartNode, RegionPlan};
use super::division::Part;
use super::params::ElectrodeParams;
use super::setting::{RegionToBurn, layer, to_burn_frame};
use crate::outline::Outline;
use crate::plane;

/// Share of each of two parts that has to be the other's for them to be the same.
const MOST: f64 = 0.5;

/// A part of a region that a stage divides into.
#[derive(Debug, Clone)]
pub(super) struct Numbered {
    pub(super) stage: usize,
    pub(super) number: usize,
    /// Area burned, in plan.
    pub(super) shape: Vec<Outline>,
    /// Area of its tip in plan (mm^2); none if the stage has no tip for it.
    pub(super) front: Option<f64>,
    /// What became of the cuts that were tried, where cutters leave something of its tip.
    pub(super) undivided: Option<Undivided>,
}

/// For each region the parts of all stages.
pub(super) type Parts = Vec<Vec<Numbered>>;

/// Area that a part burns in plan; the outline of its tip where it burns only beside it.
pub(super) fn shape(part: &Part) -> Vec<Outline> {
    let footprint = &part.footprint;
    if plane::area(&footprint.region) > 0.0 { footprint.region.clone() } else { footprint.free.clone() }
}

fn common(a: &[Outline], b: &[Outline]) -> f64 {
    plane::intersection(a, b).iter().map(|shape| plane::area(shape)).sum()
}

/// Numbers for parts of a region: of those `known` the one that is the same, each once, else one from `fresh` on.
pub(super) fn numbers(known: &[&Numbered], shapes: &[Vec<Outline>], mut fresh: usize) -> Vec<usize> {
    let mut same: Vec<(f64, usize, usize)> = Vec::new();
    for (i, shape) in shapes.iter().enumerate() {
        for k in known {
            let both = common(shape, &k.shape);
            let least = both / plane::area(shape).max(plane::area(&k.shape)).max(f64::MIN_POSITIVE);
            if least > MOST {
                same.push((least, i, k.number));
            }
        }
    }
    same.sort_by(|a, b| b.0.total_cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let mut found: Vec<Option<usize>> = vec![None; shapes.len()];
    for (_, i, number) in same {
        if found[i].is_none() && !found.contains(&Some(number)) {
            found[i] = Some(number);
        }
    }
    let number = |found: Option<usize>| {
        found.unwrap_or_else(|| {
            fresh += 1;
            fresh - 1
        })
    };
    found.into_iter().map(number).collect()
}

/// Gives the leaves of a tree these numbers.
pub(super) fn renumber(tree: &mut PartNode, numbers: &[usize]) {
    tree.part = tree.part.and_then(|part| numbers.get(part).copied());
    tree.parts.iter_mut().for_each(|part| renumber(part, numbers));
}

/// Volume that each stage takes of each part that it has a tip for (mm^3). `made` says of each stage which share of
/// each region it has tips for.
///
/// A region's volume belongs to the parts of the last stage by area. Of these each earlier stage takes what its own
/// parts cover, so that all burns together take the region's volume, and a part that roughing passed over is left
/// whole.
pub(super) fn volumes(
    regions: &[RegionToBurn],
    plans: &[RegionPlan],
    parts: &Parts,
    params: &ElectrodeParams,
    made: &[Vec<f64>],
) -> BTreeMap<(usize, PartId), f64> {
    let mut taken = BTreeMap::new();
    for (r, (region, parts)) in regions.iter().zip(parts).enumerate() {
        let turned = to_burn_frame(plans[r].direction);
        let of_stage =
            |stage: usize| parts.iter().filter(move |p| p.stage == stage && p.front.is_some()).collect::<Vec<_>>();
        let last = (0..made.len()).rev().find(|s| !of_stage(*s).is_empty());
        let places = last.map(of_stage).unwrap_or_default();
        let areas: Vec<f64> = places.iter().map(|p| plane::area(&p.shape).max(1e-12)).collect();
        let all: f64 = areas.iter().sum();
        let mut left: Vec<f64> = areas.iter().map(|a| region.volume * a / all).collect();
        for (stage, made) in made.iter().enumerate() {
            let own = of_stage(stage);
            let layer =
                params.stages.get(stage + 1).map_or(0.0, |next| layer(region, &turned, [&params.stages[stage], next]));
            for (p, place) in places.iter().enumerate() {
                let shares = shares(&own, place, areas[p], (Some(stage) == last, made[r] >= 1.0));
                let most = left[p] - left[p].min(layer * areas[p] / all);
                for (part, share) in own.iter().zip(shares) {
                    *taken.entry((stage, PartId { region: r, part: part.number })).or_insert(0.0) += share * most;
                    left[p] -= share * most;
                }
            }
        }
    }
    taken
}

/// Share of a place of this area that each part of a stage burns; everything each where the stage lacks nothing.
fn shares(own: &[&Numbered], place: &Numbered, area: f64, (is_last, is_whole): (bool, bool)) -> Vec<f64> {
    if is_last {
        return own.iter().map(|part| f64::from(part.number == place.number)).collect();
    }
    let both: Vec<f64> = own.iter().map(|part| common(&part.shape, &place.shape)).collect();
    let sum: f64 = both.iter().sum();
    let of = if is_whole { sum } else { sum.max(area) };
    both.into_iter().map(|both| if of > 0.0 { both / of } else { 0.0 }).collect()
}
