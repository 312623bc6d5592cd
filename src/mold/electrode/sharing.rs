//! Which places one electrode burns, and the electrode itself.

use glam::{DVec2, DVec3};

use super::base::{Base, INTO_BASE, placed};
use super::burning::Burning;
use super::check::Obstacle;
use super::combine::near;
use super::design::{Burn, Electrode};
use super::footprint::is_thin;
use super::params::{ElectrodeParams, Method};
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
    let mold = Obstacle::new(&setting.mold)?.stopped_by(cancel);
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
    // Most of what does not keep the gap is told by a corner. Moved, it may have less room on its orbit than at its middle.
    if !moved.vertices.iter().all(|p| setting.keeps_gap(*p)) {
        return Ok(false);
    }
    let found = mold.clearance(&moved, &setting.stage, 0.0)?;
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
    let own: Vec<&Leaf> = group.leaves.iter().map(|i| &leaves[*i]).collect();
    let highest = group.burns.iter().map(|(_, shift, _)| -shift.z).fold(0.0, f64::max);
    let seat = setting.mold.bounds().max.z + params.extension_mm + highest;
    let raised: Vec<Mesh> =
        own.iter().map(|leaf| led_up(&leaf.part.body, leaf.part.footprint.cap, seat + INTO_BASE)).collect();
    let around = Bounds::of(raised.iter().flat_map(|m| m.vertices.iter().copied()));
    let origin = around.center().with_z(seat);
    let tips: Vec<Mesh> = raised.iter().map(|m| m.mapped(|p| p - origin)).collect();
    let (base, length) = Base::under(&Bounds { max: around.max.with_z(seat), ..around }, params);
    let burns = burns(setting, leaves, group, regions, (stage, params, made), (origin, around.min.z));
    let is_extruded = own.iter().all(|leaf| leaf.part.footprint.method == Method::Extruding);
    Ok(Electrode {
        name: String::new(),
        stage,
        mesh: base.with_tips(&tips)?,
        tips: tips.into_iter().fold(Mesh::default(), joined),
        direction: setting.turned.transpose() * DVec3::NEG_Z,
        method: if is_extruded { Method::Extruding } else { Method::Cutting },
        blank: base.sides.extend(length),
        holder: base.holder(params),
        minutes: burns.iter().map(|burn| burn.minutes).sum(),
        burns,
        is_thin: own.iter().any(|leaf| is_thin(&leaf.part.footprint.free, params.least_size_mm)),
        front_area: own.iter().map(|leaf| plane::area(&leaf.part.footprint.free)).sum(),
        burn_area: burn_area(setting, own.iter().map(|leaf| &leaf.part.body)),
        base,
        family: Default::default(),
        others: Mesh::default(),
    })
}

/// The burns of a group's electrode, whose origin and lowest point stand there in the first of them.
fn burns(
    setting: &Setting,
    leaves: &[Leaf],
    group: &Shared,
    regions: &[RegionToBurn],
    (stage, params, made): (usize, &ElectrodeParams, &[Vec<f64>]),
    (origin, lowest): (DVec3, f64),
) -> Vec<Burn> {
    let (top, back) = (setting.mold.bounds().max.z, setting.turned.transpose());
    let volume_of = |i: &usize| {
        let number = leaves[*i].id.region;
        let made: Vec<f64> = made.iter().map(|shares| shares[number]).collect();
        taken(&regions[number], setting, (&params.stages, stage), &made) * share_of(&leaves[*i], leaves)
    };
    let of = |(turn, shift, ids): &(f64, DVec3, Vec<usize>)| {
        // Each place is burned by the tip in the same place of the list.
        let fronts = group.leaves.iter().map(|i| plane::area(&leaves[*i].part.footprint.free));
        let tips: Vec<(f64, f64)> = ids.iter().map(volume_of).zip(fronts).collect();
        let at = DVec2::from_angle(*turn).rotate(origin.truncate()).extend(origin.z) + *shift;
        Burn {
            position: back * at,
            turn: *turn,
            parts: ids.iter().map(|i| leaves[*i].id).collect(),
            depth: top - lowest - shift.z,
            volume: tips.iter().map(|(volume, _)| volume).sum(),
            minutes: params.removal.minutes_of_tips(&tips, params.stages[stage].finish_vdi),
        }
    };
    group.burns.iter().map(of).collect()
}

/// The part of a region that is a leaf's, by area.
fn share_of(leaf: &Leaf, leaves: &[Leaf]) -> f64 {
    let area = |l: &Leaf| plane::area(&l.part.footprint.region).max(1e-12);
    let all: f64 = leaves.iter().filter(|l| l.id.region == leaf.id.region).map(area).sum();
    area(leaf) / all
}
