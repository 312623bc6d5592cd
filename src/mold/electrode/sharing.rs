//! Which places one electrode burns, and the electrode itself.

use glam::{DVec2, DVec3};

use super::base::{Base, INTO_BASE, placed};
use super::check::{Burning, GOUGE, Obstacle};
use super::combine::near;
use super::design::{Burn, Electrode};
use super::footprint::is_thin;
use super::params::{ElectrodeParams, Method, Stage};
use super::plan::{ElectrodeError, Leaf, RegionToBurn, Setting};
use super::removal::{burn_area, taken};
use super::tip::{joined, led_up};
use crate::geometry::mesh::{Bounds, Mesh};
use crate::mold::cutter::{Cutter, CutterLibrary};
use crate::mold::plane;
use crate::progress::Cancel;

/// One electrode for several leaves: which, turned and shifted how.
pub(super) struct Shared {
    /// The leaves of the first burn.
    pub(super) leaves: Vec<usize>,
    /// The burns; the first is as the leaves stand.
    pub(super) burns: Vec<(f64, DVec3, Vec<usize>)>,
}

/// Which leaves one electrode burns: congruent ones at several positions, near ones at once.
pub(super) fn shared(
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
            let mut onto = onto.into_iter().filter(|(turn, _)| setting.stage.orbit.fits_turned(*turn));
            onto.find(|by| serves(setting, &mold, (first, leaf), *by, regions, params).unwrap_or(false))
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
    let gap = setting.stage.undersize(DVec3::Z) - GOUGE;
    if moved.vertices.iter().any(|p| mold.distance(*p) < gap) {
        return Ok(false);
    }
    let found = mold.clearance(&moved, &Stage { orbit: Default::default(), ..setting.stage.clone() }, 0.0)?;
    Ok(found.findings(&setting.stage)[0].holds)
}

/// The electrode of a group, for stage number `stage`; `made` says of each stage up to it which share of each region it has
/// tips for.
pub(super) fn assembled(
    setting: &Setting,
    leaves: &[Leaf],
    group: &Shared,
    regions: &[RegionToBurn],
    (stage, params, made): (usize, &ElectrodeParams, &[Vec<f64>]),
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
    let front_area = group.leaves.iter().map(|i| plane::area(&leaves[*i].part.footprint.free)).sum();
    let first = &params.stages[stage];
    let burns: Vec<Burn> = group
        .burns
        .iter()
        .map(|(turn, shift, ids)| {
            let part = |i: &usize| {
                let number = leaves[*i].id.region;
                let made: Vec<f64> = made.iter().map(|shares| shares[number]).collect();
                taken(&regions[number], setting, (&params.stages, stage), &made) * share_of(&leaves[*i], leaves)
            };
            // Each place is burned by the tip in the same place of the list.
            let fronts = group.leaves.iter().map(|i| plane::area(&leaves[*i].part.footprint.free));
            let tips: Vec<(f64, f64)> = ids.iter().map(part).zip(fronts).collect();
            let volume = tips.iter().map(|(volume, _)| volume).sum();
            let minutes = params.removal.minutes_of_tips(&tips, first.finish_vdi);
            let at = DVec2::from_angle(*turn).rotate(middle).extend(seat) + *shift;
            let parts = ids.iter().map(|i| leaves[*i].id).collect();
            Burn { position: back * at, turn: *turn, parts, depth: top - around.min.z - shift.z, volume, minutes }
        })
        .collect();
    let only_tips = tips.into_iter().fold(Mesh::default(), joined);
    let is_extruded = group.leaves.iter().all(|i| leaves[*i].part.footprint.method == Method::Extruding);
    let minutes = burns.iter().map(|burn| burn.minutes).sum();
    Ok(Electrode {
        name: String::new(),
        stage,
        mesh,
        tips: only_tips,
        burns,
        direction: back * DVec3::NEG_Z,
        method: if is_extruded { Method::Extruding } else { Method::Cutting },
        blank: base.sides.extend(length),
        holder: base.holder(params),
        minutes,
        is_thin: group.leaves.iter().any(|i| is_thin(&leaves[*i].part.footprint.free, params.least_size_mm)),
        front_area,
        burn_area: burn_area(setting, group.leaves.iter().map(|i| &leaves[*i].part.body)),
        base,
        family: Default::default(),
        others: Mesh::default(),
    })
}

/// The part of a region that is a leaf's, by area.
fn share_of(leaf: &Leaf, leaves: &[Leaf]) -> f64 {
    let area = |l: &Leaf| plane::area(&l.part.footprint.region).max(1e-12);
    let all: f64 = leaves.iter().filter(|l| l.id.region == leaf.id.region).map(area).sum();
    area(leaf) / all
}
