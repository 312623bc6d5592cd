//! Sharing: the places that one electrode burns, and the electrode itself.

use std::sync::Arc;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::base::{Base, INTO_BASE, placed};
use super::burning::Burning;
use super::clearance::Obstacle;
use super::combine::{Form, near};
use super::design::{Burn, Electrode, PartId};
use super::division::Part;
use super::footprint::is_thin;
use super::params::{ElectrodeParams, Method};
use super::samples::samples;
use super::setting::{ElectrodeError, KeptClear, RegionToBurn, Setting, burn_area};
use super::tip::{joined, led_up};
use crate::cutter::{Cutter, CutterLibrary};
use crate::plane;
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
pub(super) struct Shared {
    /// The leaves of the first burn.
    pub(super) leaves: Vec<usize>,
    /// The burns; the first is as the leaves stand.
    pub(super) burns: Vec<(f64, DVec3, Vec<usize>)>,
}

/// Groups of leaves that one electrode burns: congruent ones at several positions, near ones at once.
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
        // Looked for once there is a tip that may be laid onto it.
        let mut own: Option<Own> = None;
        let mut fits = |group: &Shared| -> Option<(f64, DVec3)> {
            let first = &leaves[group.leaves[0]];
            let onto = first.form.onto(&leaf.form).into_iter();
            for by in onto.filter(|(turn, _)| setting.stage.orbit.fits_turned(*turn)) {
                if own.is_none() {
                    own = Own::of(setting, leaf, &regions[leaf.id.region], params).ok();
                }
                if cancel.is_cancelled() {
                    return None;
                }
                if serves(setting, &mold, (first, own.as_ref()?), by, params).unwrap_or(false) {
                    return Some(by);
                }
            }
            None
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
    (stage, params): (usize, &ElectrodeParams),
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
    let burns = burns(setting, leaves, group, (origin, around.min.z));
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
        minutes: 0.0,
        burns,
        is_thin: own.iter().any(|leaf| is_thin(&leaf.part.footprint.free, params.least_size_mm)),
        front_area: own.iter().map(|leaf| plane::area(&leaf.part.footprint.free)).sum(),
        burn_area: burn_area(own.iter().map(|leaf| (&*leaf.clear, &leaf.part.body))),
        base,
        family: Default::default(),
        others: Mesh::default(),
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
            minutes: 0.0,
        }
    };
    group.burns.iter().map(of).collect()
}
