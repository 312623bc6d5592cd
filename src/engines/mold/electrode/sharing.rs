//! Sharing: the places that one electrode burns, and the electrode itself.

use std::sync::Arc;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::arrangement::{Arranged, Arrangement};
use super::base::{Base, INTO_BASE, placed};
use super::burning::Burning;
use super::clearance::Obstacle;
use super::combine::{Form, near};
use super::design::{Burn, Electrode, OtherWay, PartId};
use super::division::Part;
use super::footprint::is_thin;
use super::params::{ElectrodeParams, Method, Repeat};
use super::samples::samples;
use super::setting::{ElectrodeError, KeptClear, RegionToBurn, Setting, burn_area};
use super::tip::{joined, led_up};
use crate::cutter::CutterLibrary;
use crate::plane;
use burning::figures::BurnFigures;
use geometry::mesh::{Bounds, Mesh};
use task::Cancel;

/// An electrode head with the part that it burns.
pub(super) struct Leaf {
    pub(super) id: PartId,
    pub(super) part: Part,
    pub(super) form: Form,
    /// What it stays above.
    pub(super) clear: Arc<KeptClear>,
}

/// One electrode for several leaves: which, turned and shifted how.
#[derive(Clone)]
pub(super) struct Shared {
    /// The leaves of the first burn.
    pub(super) leaves: Vec<usize>,
    /// The burns; the first is as the leaves stand.
    pub(super) burns: Vec<(f64, DVec3, Vec<usize>)>,
    /// Whether its heads are of one shape that one head could burn.
    is_repeated: bool,
}

impl Shared {
    fn of(leaves: Vec<usize>) -> Self {
        Self { burns: vec![(0.0, DVec3::ZERO, leaves.clone())], leaves, is_repeated: false }
    }

    fn holds(&self, leaf: usize) -> bool {
        self.burns.iter().any(|(.., own)| own.contains(&leaf))
    }

    /// The group without places that another electrode burns: none where nothing is left, and several where its first
    /// burn is gone.
    fn without(self, gone: &[usize]) -> Vec<Self> {
        if !self.burns.iter().any(|(.., own)| own.iter().any(|leaf| gone.contains(leaf))) {
            return vec![self];
        }
        let left = |own: &[usize]| -> Vec<usize> { own.iter().copied().filter(|leaf| !gone.contains(leaf)).collect() };
        let (heads, is_repeated) = (self.leaves.len(), self.is_repeated);
        let (mut whole, mut part): (Vec<_>, Vec<_>) =
            self.burns.into_iter().partition(|(.., own)| left(own).len() == own.len());
        // The heads are made as they stand at the first place that is left, which needs all of them.
        if whole.first().is_some_and(|(.., own)| own.len() < heads) {
            part.append(&mut whole);
        }
        let rest = part.iter().map(|(.., own)| left(own)).filter(|own| !own.is_empty()).map(Self::of);
        let whole = Self::of_places(whole).map(|group| Self { is_repeated, ..group });
        whole.into_iter().chain(rest).collect()
    }

    /// One electrode for these burns, whose heads are made as they stand at the first of them.
    fn of_places(burns: Vec<(f64, DVec3, Vec<usize>)>) -> Option<Self> {
        let (from, at, leaves) = burns.first()?.clone();
        let moved = |(turn, shift, own): (f64, DVec3, Vec<usize>)| {
            let back = DVec2::from_angle(turn - from).rotate(at.truncate()).extend(at.z);
            (turn - from, shift - back, own)
        };
        Some(Self { leaves, burns: burns.into_iter().map(moved).collect(), is_repeated: false })
    }
}

/// Comparison of leaves: whether one can burn the place of another.
struct Comparison<'a> {
    setting: &'a Setting,
    mold: Obstacle,
    leaves: &'a [Leaf],
    regions: &'a [RegionToBurn],
    params: &'a ElectrodeParams,
    cancel: &'a Cancel,
}

impl Comparison<'_> {
    /// How one of these leaves is laid onto another place so that it burns that too.
    fn fits(&self, [first, other]: [usize; 2], own: &mut Option<Own>) -> Option<(f64, DVec3)> {
        let onto = self.leaves[first].form.onto(&self.leaves[other].form).into_iter();
        onto.filter(|(turn, _)| self.setting.stage.orbit.fits_turned(*turn))
            .find(|by| !self.cancel.is_cancelled() && self.serves([first, other], *by, own))
    }

    /// Whether a leaf, turned and moved, burns another's place. What that one burns itself is looked for once.
    fn serves(&self, [first, other]: [usize; 2], by: (f64, DVec3), own: &mut Option<Own>) -> bool {
        let leaf = &self.leaves[other];
        if own.is_none() {
            *own = Own::of(self.setting, leaf, &self.regions[leaf.id.region], self.params).ok();
        }
        let Some(own) = own else { return false };
        serves(self.setting, &self.mold, (&self.leaves[first], own), by, self.params).unwrap_or(false)
    }

    /// The burn of another cavity by these heads: the first of the pair burns the second there, and each of the others
    /// what it finds.
    fn copied(&self, heads: &[usize], [a, b]: [usize; 2]) -> Option<(f64, DVec3, Vec<usize>)> {
        let (turn, shift) = self.fits([a, b], &mut None)?;
        let middle = |leaf: usize| {
            let [low, high] = plane::extent(&self.leaves[leaf].part.footprint.free);
            low.midpoint(high)
        };
        let there = |head: usize| DVec2::from_angle(turn).rotate(middle(head)) + shift.truncate();
        let burned = |head: usize| {
            let others = (0..self.leaves.len()).filter(|leaf| !heads.contains(leaf));
            let near = others.filter(|leaf| middle(*leaf).distance(there(head)) < NEAR);
            near.into_iter().find(|leaf| self.serves([head, *leaf], (turn, shift), &mut None))
        };
        let found: Vec<usize> =
            heads.iter().filter_map(|head| if *head == a { Some(b) } else { burned(*head) }).collect();
        Some((turn, shift, found))
    }

    /// Sets of heads, of which those that are laid onto one another are burned by one electrode.
    fn of_one_shape(&self, sets: Vec<Shared>) -> Vec<Shared> {
        let mut groups: Vec<Shared> = Vec::new();
        for set in sets {
            let burn = |group: &Shared| {
                let is_alike = set.is_repeated && group.is_repeated && set.leaves.len() == group.leaves.len();
                let mut onto = set.leaves.iter().filter(|_| is_alike);
                onto.find_map(|leaf| {
                    let burn = self.copied(&group.leaves, [group.leaves[0], *leaf])?;
                    (sorted(burn.2.clone()) == sorted(set.leaves.clone())).then_some(burn)
                })
            };
            match groups.iter().enumerate().find_map(|(g, group)| Some((g, burn(group)?))) {
                Some((g, burn)) => groups[g].burns.push(burn),
                None => groups.push(set),
            }
        }
        groups
    }
}

/// How near the middle of a head comes to that of a place that it burns (mm).
const NEAR: f64 = 1.0;

/// Groups of leaves that one electrode burns: as the user arranges them, and else congruent ones at several positions
/// and near ones at once. Also tells which of the user's changes are made.
pub(super) fn shared(
    setting: &Setting,
    (leaves, arrangement): (&[Leaf], &Arrangement),
    regions: &[RegionToBurn],
    cutters: &CutterLibrary,
    params: &ElectrodeParams,
    cancel: &Cancel,
) -> Result<(Vec<Shared>, Vec<usize>), ElectrodeError> {
    let mold = Obstacle::new(&setting.mold)?.stopped_by(cancel);
    let comparison = Comparison { setting, mold, leaves, regions, params, cancel };
    let mut groups: Vec<Shared> = Vec::new();
    for i in (0..leaves.len()).filter(|i| !arrangement.apart.contains(i)) {
        cancel.check()?;
        // Looked for once there is a tip that may be laid onto it.
        let mut own: Option<Own> = None;
        let mut fits = |group: &Shared| comparison.fits([group.leaves[0], i], &mut own);
        let found =
            params.share.then(|| groups.iter().enumerate().find_map(|(g, group)| Some((g, fits(group)?)))).flatten();
        match found {
            Some((g, (turn, shift))) => groups[g].burns.push((turn, shift, vec![i])),
            None => groups.push(Shared::of(vec![i])),
        }
    }
    let (single, mut several): (Vec<Shared>, Vec<Shared>) = groups.into_iter().partition(|g| g.burns.len() == 1);
    let radius = cutters.least_radius();
    // A cutter has to pass between two tips.
    let clear = 2.2 * radius;
    let together = |all: &[usize]| -> Vec<Vec<usize>> {
        let boxes: Vec<[DVec2; 2]> = all.iter().map(|leaf| plane::extent(&leaves[*leaf].part.footprint.free)).collect();
        let near = near(&boxes, params.together_mm, clear);
        near.into_iter().map(|members| members.into_iter().map(|m| all[m]).collect()).collect()
    };
    if params.repeat == Repeat::Heads {
        let sets = several.into_iter().flat_map(|group| heads_of(group, &together));
        several = comparison.of_one_shape(sets.collect());
        cancel.check()?;
    }
    let single: Vec<usize> = single.iter().map(|group| group.leaves[0]).collect();
    several.extend(together(&single).into_iter().map(Shared::of));
    several.extend(arrangement.apart.iter().map(|leaf| Shared::of(vec![*leaf])));
    let mut met = Vec::new();
    for (edit, arranged) in &arrangement.arranged {
        cancel.check()?;
        let of = |leaf: usize, all: &[Shared]| all.iter().position(|group| group.holds(leaf));
        match arranged {
            Arranged::Joined([a, b]) => {
                // A place that shares an electrode gets a head of its own for it.
                for leaf in [*a, *b] {
                    if let Some(g) = of(leaf, &several).filter(|g| several[*g].burns.len() > 1) {
                        let rest = several.remove(g).without(&[leaf]);
                        several.extend(rest.into_iter().chain([Shared::of(vec![leaf])]));
                    }
                }
                let (Some(one), Some(other)) = (of(*a, &several), of(*b, &several)) else { continue };
                if one != other {
                    let [low, high] = [one.min(other), one.max(other)];
                    let heads = [several.remove(high).leaves, several.remove(low).leaves].concat();
                    several.push(Shared::of(sorted(heads)));
                }
                met.push(*edit);
            }
            Arranged::Copied([a, b]) => {
                let Some(from) = of(*a, &several).filter(|from| !several[*from].holds(*b)) else { continue };
                // The head that burns the first place.
                let at = several[from].burns.iter().find_map(|(.., own)| own.iter().position(|leaf| leaf == a));
                let Some(head) = at.and_then(|at| several[from].leaves.get(at).copied()) else { continue };
                let Some(burn) = comparison.copied(&several[from].leaves, [head, *b]) else { continue };
                let mut group = several.remove(from);
                several = several.into_iter().flat_map(|other| other.without(&burn.2)).collect();
                group.burns.push(burn);
                several.push(group);
                met.push(*edit);
            }
        }
    }
    several.sort_by_key(|g| g.leaves[0]);
    Ok((several, met))
}

fn sorted(mut leaves: Vec<usize>) -> Vec<usize> {
    leaves.sort_unstable();
    leaves
}

/// The electrodes that burn the places of a group by a head for each where they stand near one another.
fn heads_of(group: Shared, together: &dyn Fn(&[usize]) -> Vec<Vec<usize>>) -> Vec<Shared> {
    let all: Vec<usize> = group.burns.iter().flat_map(|(.., own)| own.iter().copied()).collect();
    let sets = together(&all);
    if sets.len() == all.len() {
        return vec![group];
    }
    let (alone, at_once): (Vec<_>, Vec<_>) = sets.into_iter().partition(|set| set.len() == 1);
    let at_once = at_once.into_iter().map(|set| Shared { is_repeated: true, ..Shared::of(set) });
    // Places by themselves share one head as before.
    let place = |leaf: usize| group.burns.iter().find(|(.., own)| own.contains(&leaf)).cloned();
    let one_head = Shared::of_places(alone.into_iter().flatten().filter_map(place).collect());
    at_once.chain(one_head).collect()
}

/// The other way to burn the places of a group, without its duration; none if they are of several shapes or there is
/// but one.
fn other_way(
    leaves: &[Leaf],
    group: &Shared,
    (raised, params): (&[Mesh], &ElectrodeParams),
    clear: f64,
) -> Option<OtherWay> {
    let head = raised.first()?.bounds();
    if group.is_repeated {
        let (base, length) = Base::under(&head, params);
        let places = group.burns.iter().map(|(.., own)| own.len()).sum();
        let at_once = (0..places).map(|place| vec![place]).collect();
        return Some(OtherWay { at_once, blank: base.sides.extend(length), minutes: None });
    }
    let is_one_head = group.burns.len() > 1 && group.burns.iter().all(|(.., own)| own.len() == 1);
    let boxes = || -> Vec<[DVec2; 2]> {
        group.burns.iter().map(|(.., own)| plane::extent(&leaves[own[0]].part.footprint.free)).collect()
    };
    let boxes = is_one_head.then(boxes)?;
    let at_once = near(&boxes, params.together_mm, clear);
    if at_once.len() == boxes.len() {
        return None;
    }
    let blank = |set: &Vec<usize>| {
        let around = set.iter().flat_map(|burn| boxes[*burn]);
        let [low, high] = around.fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[l, h], p| [l.min(p), h.max(p)]);
        let bounds = Bounds { min: low.extend(head.min.z), max: high.extend(head.max.z) };
        let (base, length) = Base::under(&bounds, params);
        base.sides.extend(length)
    };
    let size = |blank: &DVec3| blank.x * blank.y * blank.z;
    let largest = at_once.iter().map(blank).max_by(|a, b| size(a).total_cmp(&size(b)))?;
    Some(OtherWay { at_once, blank: largest, minutes: None })
}

/// Places of its region's surface that a leaf's own tip burns, as sampled by the check of residual stock, and the
/// distance of the tip from each of them (mm).
struct Own(Vec<(DVec3, f64)>);

impl Own {
    fn of(
        setting: &Setting,
        leaf: &Leaf,
        region: &RegionToBurn,
        params: &ElectrodeParams,
    ) -> Result<Self, ElectrodeError> {
        let burning = Burning::new(&leaf.part.body, &setting.stage)?;
        // In its corners more may stay than on its faces; beyond its share other tips burn.
        let most = (3f64.sqrt() - 1.0) * burning.reach() + params.tolerance_mm;
        let is_own = |p: DVec3, off: f64| {
            off <= params.tolerance_mm / 2.0 || (off <= most && plane::holds(&leaf.part.footprint.region, p.truncate()))
        };
        let corners: Vec<[DVec3; 3]> = region.corners.iter().map(|c| c.map(|p| setting.turned * p)).collect();
        let (places, _) = samples(&corners, region, (&[], &[]), [0.0; 2]);
        let with_off = places.into_par_iter().map(|s| (s.point, burning.beyond(s.point)));
        Ok(Self(with_off.filter(|(p, off)| is_own(*p, *off)).collect()))
    }
}

/// Whether the tip of `first`, moved, burns what another leaf's own tip does as well as that one, and keeps the gap
/// where it burns and on its way there.
fn serves(
    setting: &Setting,
    mold: &Obstacle,
    (first, own): (&Leaf, &Own),
    (turn, shift): (f64, DVec3),
    params: &ElectrodeParams,
) -> Result<bool, ElectrodeError> {
    /// By how much it may burn a place less well (mm): tips are laid onto one another no better.
    const WORSE: f64 = 2e-3;
    let moved = placed(&first.part.body, turn, shift);
    let least = params.tolerance_mm / 2.0;
    let other = Burning::new(&moved, &setting.stage)?;
    if own.0.par_iter().any(|(p, by_own)| other.beyond(*p) > (by_own + WORSE).max(least)) {
        return Ok(false);
    }
    // Most of what does not keep the gap is told by a corner. Moved, it may have less room on its orbit than at its
    // middle.
    if !moved.vertices.iter().all(|p| setting.keeps_gap(*p)) {
        return Ok(false);
    }
    let top = setting.mold.bounds().max.z + params.extension_mm;
    let led = placed(&led_up(&first.part.body, first.part.footprint.cap, top - shift.z), turn, shift);
    let depth = setting.mold.bounds().max.z - led.bounds().min.z;
    let lift = params.lift_mm.max(depth + Burn::CLEAR_MM);
    let found = mold.clearance(&led, &setting.stage, lift)?;
    Ok(found.findings(&setting.stage).iter().all(|finding| finding.holds))
}

/// The electrode of a group, for stage number `stage`; what its burns take is not known yet.
pub(super) fn assembled(
    setting: &Setting,
    leaves: &[Leaf],
    group: &Shared,
    (stage, params, cutters): (usize, &ElectrodeParams, &CutterLibrary),
) -> Result<Electrode, ElectrodeError> {
    let own: Vec<&Leaf> = group.leaves.iter().map(|i| &leaves[*i]).collect();
    let highest = group.burns.iter().map(|(_, shift, _)| -shift.z).fold(0.0, f64::max);
    let seat = setting.mold.bounds().max.z + params.extension_mm + highest;
    let raised: Vec<Mesh> =
        own.iter().map(|leaf| led_up(&leaf.part.body, leaf.part.footprint.cap, seat + INTO_BASE)).collect();
    let around = Bounds::of(raised.iter().flat_map(|m| m.vertices.iter().copied()));
    let origin = around.center().with_z(seat);
    let tips: Vec<Mesh> = raised.iter().map(|m| m.mapped(|p| p - origin)).collect();
    let (base, length) = Base::under(&Bounds { max: around.max.with_z(seat), ..around }, params);
    let radius = cutters.least_radius();
    let other_way = other_way(leaves, group, (&raised, params), 2.2 * radius);
    let burns = burns(setting, leaves, group, (origin, around.min.z));
    let is_extruded = own.iter().all(|leaf| leaf.part.footprint.method == Method::Extruding);
    Ok(Electrode {
        name: String::new(),
        number: 0,
        stage,
        mesh: base.with_tips(&tips)?,
        tips: tips.into_iter().fold(Mesh::default(), joined),
        direction: setting.turned.transpose() * DVec3::NEG_Z,
        method: if is_extruded { Method::Extruding } else { Method::Cutting },
        blank: base.sides.extend(length),
        holder: base.holder(params),
        figures: BurnFigures::default(),
        needed: None,
        burns,
        is_thin: own.iter().any(|leaf| is_thin(&leaf.part.footprint.free, params.least_size_mm)),
        front_area: own.iter().map(|leaf| plane::area(&leaf.part.footprint.free)).sum(),
        burn_area: burn_area(own.iter().map(|leaf| (&*leaf.clear, &leaf.part.body))),
        base,
        family: Default::default(),
        others: Mesh::default(),
        material: None,
        unmet: Vec::new(),
        other_way,
    })
}

/// The burns of a group's electrode, whose origin and lowest point stand there in the first of them.
fn burns(setting: &Setting, leaves: &[Leaf], group: &Shared, (origin, lowest): (DVec3, f64)) -> Vec<Burn> {
    let (top, back) = (setting.mold.bounds().max.z, setting.turned.transpose());
    let of = |(turn, shift, ids): &(f64, DVec3, Vec<usize>)| {
        let at = DVec2::from_angle(*turn).rotate(origin.truncate()).extend(origin.z) + *shift;
        Burn {
            position: back * at,
            turn: *turn,
            parts: ids.iter().map(|i| leaves[*i].id).collect(),
            depth: top - lowest - shift.z,
            volume: 0.0,
            heads: None,
            minutes: None,
        }
    };
    group.burns.iter().map(of).collect()
}
