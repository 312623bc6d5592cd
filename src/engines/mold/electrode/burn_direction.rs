//! Proposal of a burn direction for a region that walls of the mold hang over.
//!
//! A head that sinks straight burns what is seen against the burn direction. Directions are tried on samples of the
//! region's surface: in steps of tilt and heading, and those that its own faces give, such as along two of its walls
//! or against its floor. The one from which most of the region's area is seen is proposed; of several from which as
//! much is seen, the one that is tilted least.

use std::fmt;

use glam::{DMat3, DVec2, DVec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::clearance::Obstacle;
use super::residual_stock::Sample;
use super::samples::Thinning;
use task::{Cancel, Cancelled};

/// Step of tilts that are tried, up to 90 degrees (degrees).
const TILT_STEP_DEG: f64 = 5.0;
/// Number of such steps.
const TILTS: usize = 18;
/// Number of headings that are tried with each tilt.
const HEADINGS: usize = 24;
/// Number of faces, the largest, that give directions of their own.
const FACES: usize = 8;
/// Cosine of the angle between normals of what counts as one face: 1 degree.
const ONE_FACE: f64 = 0.999_848;
/// Number of samples at most that the mold hangs over, and of others.
const POINTS: f64 = 150.0;
/// Distance off the surface from which a ray starts (mm).
const OFF: f64 = 1e-3;
/// Share of the reach of what burns that has to be free around it.
const NARROWER: f64 = 0.95;
/// How far a normal may look along the burn direction, by its component, for a face to count as seen: a wall along
/// the direction does so by rounding.
const ACROSS: f64 = 1e-3;
/// Shares of an area that differ by less are one.
const EQUAL: f64 = 1e-9;
/// Share of a region's area, seen more than from the present direction, from which on turning the electrode is worth
/// it where still not all of it is seen.
const WORTH: f64 = 0.02;

/// A burn direction from which more of a region is seen than from the present one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BurnProposal {
    /// Burn direction, a unit vector in the upright mold.
    pub direction: DVec3,
    /// Share of the region's area that is seen from it, from 0 to 1.
    pub seen: f64,
    /// Share of the region's area that is seen from the present burn direction, from 0 to 1.
    pub seen_now: f64,
}

impl BurnProposal {
    /// Whether the whole region is seen from it.
    pub fn sees_all(&self) -> bool {
        self.seen > 1.0 - EQUAL
    }
}

/// The direction and what is seen from it, in words: `tilted 20.0 deg towards 90.0 deg all of it is seen`. The angles
/// are those of [`angles_deg`].
impl fmt::Display for BurnProposal {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let [tilt, towards] = angles_deg(self.direction);
        // Rounded down, so that what is not all is not told as all.
        let percent = |share: f64| (1000.0 * share + EQUAL).floor() / 10.0;
        if tilt > 0.0 {
            write!(f, "tilted {tilt:.1} deg towards {towards:.1} deg ")?;
        } else {
            write!(f, "straight down ")?;
        }
        if self.sees_all() {
            return write!(f, "all of it is seen");
        }
        let [seen, now] = [self.seen, self.seen_now].map(percent);
        write!(f, "{seen:.1} % of its area is seen, from the present direction {now:.1} %")
    }
}

/// Tilt of a burn direction from straight down, and its heading in plan, from +X towards +Y of the upright mold
/// (degrees).
pub fn angles_deg(direction: DVec3) -> [f64; 2] {
    let flat = direction.truncate();
    let tilt = flat.length().atan2(-direction.z).to_degrees();
    // What rounding makes of straight down has no direction in plan.
    if tilt < 1e-6 { [0.0, 0.0] } else { [tilt, flat.to_angle().to_degrees()].map(|deg| (deg * 1e6).round() / 1e6) }
}

/// The burn direction with this tilt and heading (degrees), a unit vector in the upright mold.
pub fn along(tilt: f64, towards: f64) -> DVec3 {
    let (tilt, flat) = (tilt.to_radians(), DVec2::from_angle(towards.to_radians()));
    (tilt.sin() * flat).extend(-tilt.cos())
}

/// Proposal for the region with these samples, each with whether the mold hangs over it; none if no direction sees
/// more of it than the present one. Mold and samples are in the burn frame of the present direction, to which `turned`
/// takes the upright mold. What burns at the border of an overhang keeps off the mold by `reach` (mm) on its way.
/// Little more is not proposed unless it is all.
///
/// # Errors
/// [`Cancelled`].
pub(super) fn proposed(
    mold: &Obstacle,
    turned: &DMat3,
    (samples, reach): (&[(Sample, bool)], f64),
    cancel: &Cancel,
) -> Result<Option<BurnProposal>, Cancelled> {
    // What is hung over may be a small part of a large region: it has samples of its own.
    let of_kind = |kind: bool| thinned(samples.iter().filter(move |(_, shaded)| *shaded == kind).map(|(s, _)| s));
    let on_faces = [true, false].map(of_kind).concat();
    let at_borders = at_borders(mold, samples, reach);
    let directions = candidates(&on_faces, &turned.transpose());
    let points = Points { on_faces, at_borders, reach };
    let seen_from = |direction: &DVec3| -> Result<f64, Cancelled> {
        cancel.check()?;
        Ok(points.seen(mold, *turned * *direction))
    };
    let shares: Vec<f64> = directions.par_iter().map(seen_from).collect::<Result<_, _>>()?;
    let seen_now = points.seen(mold, DVec3::NEG_Z);
    let mut best: Option<BurnProposal> = None;
    for (direction, share) in directions.into_iter().zip(shares) {
        if share > best.map_or(seen_now, |best| best.seen) + EQUAL {
            best = Some(BurnProposal { direction, seen: share, seen_now });
        }
    }
    Ok(best.filter(|best| best.sees_all() || best.seen > seen_now + WORTH))
}

/// Few of samples; each stands for the area of those before it.
fn thinned<'a>(samples: impl Iterator<Item = &'a Sample> + Clone) -> Vec<Sample> {
    let own = || samples.clone().filter(|sample| sample.area > 0.0);
    let share = own().map(|sample| sample.area).sum::<f64>() / POINTS;
    let mut thinning = Thinning::new(share);
    own().filter_map(|sample| Some(Sample { area: thinning.next(sample.area)?, ..*sample })).collect()
}

/// Few of the samples at the borders of overhangs, which stand for no area: each counts as one on a face. Near other
/// faces what burns has no room around it anyway.
fn at_borders(mold: &Obstacle, samples: &[(Sample, bool)], reach: f64) -> Vec<Sample> {
    let usual = samples.iter().map(|(sample, _)| sample.area).sum::<f64>() / samples.len().max(1) as f64;
    let is_at_border = |(sample, is_shaded): &&(Sample, bool)| {
        let is_alone = || mold.off(sample.point + sample.normal * reach).0 >= NARROWER * reach;
        *is_shaded && sample.area <= 0.0 && is_alone()
    };
    let own: Vec<Sample> = samples.iter().filter(is_at_border).map(|(s, _)| Sample { area: usual, ..*s }).collect();
    thinned(own.iter())
}

/// Points of a region that are looked at.
struct Points {
    on_faces: Vec<Sample>,
    /// Points at the borders of overhangs.
    at_borders: Vec<Sample>,
    /// How far what burns at borders keeps off the mold on its way (mm).
    reach: f64,
}

impl Points {
    /// Share of their area that is seen against a burn direction, all in one frame.
    fn seen(&self, mold: &Obstacle, direction: DVec3) -> f64 {
        let is_seen = |point: &&Sample| {
            point.normal.dot(-direction) > -ACROSS && !mold.is_hidden(point.point + point.normal * OFF, -direction)
        };
        // A hair narrower, so that it does not touch the walls that it comes down along.
        let is_free = |point: &&Sample| {
            is_seen(point)
                && !mold.hangs_over(point.point + point.normal * self.reach, NARROWER * self.reach, -direction)
        };
        let area = |points: &mut dyn Iterator<Item = &Sample>| points.map(|point| point.area).sum::<f64>();
        let all = area(&mut self.on_faces.iter().chain(&self.at_borders));
        let own = area(&mut self.on_faces.iter().filter(is_seen)) + area(&mut self.at_borders.iter().filter(is_free));
        if all > 0.0 { own / all } else { 0.0 }
    }
}

/// Directions in the upright mold that are tried, the least tilted first; `back` turns the points to it.
fn candidates(points: &[Sample], back: &DMat3) -> Vec<DVec3> {
    /// How far a direction may point up by rounding.
    const LEVEL: f64 = 1e-9;
    let headings = |tilt: usize| {
        let tilt = tilt as f64 * TILT_STEP_DEG;
        (0..HEADINGS).map(move |i| along(tilt, i as f64 * 360.0 / HEADINGS as f64))
    };
    let faces: Vec<DVec3> = largest_faces(points).into_iter().map(|normal| *back * normal).collect();
    let mut own: Vec<DVec3> = Vec::new();
    for (i, &face) in faces.iter().enumerate() {
        // Against a floor, along a wall as steeply as it goes, and along two walls.
        own.extend([-face, DVec3::NEG_Z + face * face.z]);
        own.extend(faces[..i].iter().flat_map(|other| [face.cross(*other), other.cross(face)]));
    }
    // As the window has them, whose angles are rounded.
    let rounded = |direction: DVec3| {
        let [tilt, towards] = angles_deg(direction);
        along(tilt, towards)
    };
    let own = own.into_iter().filter(|d| d.length() > 1e-3).map(DVec3::normalize).filter(|d| d.z < LEVEL).map(rounded);
    let mut all: Vec<DVec3> = std::iter::once(DVec3::NEG_Z).chain((1..=TILTS).flat_map(headings)).chain(own).collect();
    all.sort_by(|a, b| a.z.total_cmp(&b.z));
    all
}

/// The unit normals of the largest faces, the largest first.
fn largest_faces(points: &[Sample]) -> Vec<DVec3> {
    // The first normal of each, and the sum of all by area.
    let mut faces: Vec<(DVec3, DVec3)> = Vec::new();
    for point in points {
        let own = point.normal * point.area;
        match faces.iter_mut().find(|(first, _)| first.dot(point.normal) > ONE_FACE) {
            Some((_, sum)) => *sum += own,
            None => faces.push((point.normal, own)),
        }
    }
    faces.sort_by(|(_, a), (_, b)| b.length().total_cmp(&a.length()));
    faces.into_iter().filter_map(|(_, sum)| sum.try_normalize()).take(FACES).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::electrode::setting::{RegionToBurn, to_burn_frame};
    use crate::electrode::tests::{mold, region};
    use crate::fixtures::rectangle;
    use geometry::mesh::{Mesh, unit_normal};
    use geometry::solid::difference;

    /// What is proposed for a region that is burned along `now`; the lower half is taken to be hung over.
    fn proposed_for(mold: &Mesh, region: &RegionToBurn, now: DVec3) -> Option<BurnProposal> {
        let turned = to_burn_frame(now);
        let sample = |corners: &[DVec3; 3]| {
            let [a, b, c] = corners.map(|p| turned * p);
            let (normal, area) = (unit_normal([a, b, c]), 0.5 * (b - a).cross(c - a).length());
            (Sample { point: (a + b + c) / 3.0, normal, area, thickest: 1.0 }, corners[0].z < -2.0)
        };
        let samples: Vec<(Sample, bool)> = region.corners.iter().map(sample).collect();
        let obstacle = Obstacle::new(&mold.mapped(|p| turned * p)).unwrap();
        proposed(&obstacle, &turned, (&samples, 0.05), &Cancel::default()).unwrap()
    }

    /// A block with a slot of 6 x 2 mm, 4 mm deep along its walls, that is burned with this tilt and heading (degrees).
    fn leaning(tilt: f64, towards: f64) -> (Mesh, RegionToBurn) {
        let turn = DMat3::from_rotation_z((towards - 90.0).to_radians()) * DMat3::from_rotation_x(tilt.to_radians());
        let slot = Mesh::cuboid(DVec3::new(6.0, 2.0, 8.0)).mapped(|p| turn * (p - DVec3::new(3.0, 1.0, 4.0)));
        let mold = difference(&mold([30.0, 30.0, 10.0], &[]), &slot).unwrap();
        let around = DVec2::splat(8.0);
        let all = region(&mold, -around, around);
        (mold, all)
    }

    #[test]
    fn a_slot_that_leans_is_burned_along_its_walls() {
        // In the steps that are tried, between them, and from the side that the walls alone tell.
        for (tilt, towards) in [(20.0, 90.0), (17.3, 100.0), (33.3, -47.0)] {
            let (mold, slot) = leaning(tilt, towards);
            let found = proposed_for(&mold, &slot, DVec3::NEG_Z).unwrap();
            assert!(found.sees_all() && found.seen_now < 0.8, "{found:?}");
            assert!(found.direction.distance(along(tilt, towards)) < 1e-4, "{found}");
            assert_eq!(found.to_string(), format!("tilted {tilt:.1} deg towards {towards:.1} deg all of it is seen"));
            // Its own direction needs no other, and from one that is worse the proposal is the same.
            assert_eq!(proposed_for(&mold, &slot, found.direction), None);
            let again = proposed_for(&mold, &slot, along(10.0, towards + 180.0)).unwrap();
            assert!(again.sees_all() && again.direction.distance(found.direction) < 1e-4, "{again}");
        }
    }

    /// Where all that is left of a slot that leans is seen from above but for what a gap keeps off at its upper edge.
    #[test]
    fn what_only_the_gap_keeps_off_is_burned_from_the_side() {
        let (mold, slot) = leaning(35.0, 90.0);
        let obstacle = Obstacle::new(&mold).unwrap();
        let sample = |corners: &[DVec3; 3]| {
            let [a, b, c] = *corners;
            let (normal, area) = (unit_normal([a, b, c]), 0.5 * (b - a).cross(c - a).length());
            Sample { point: (a + b + c) / 3.0, normal, area, thickest: 1.0 }
        };
        let is_open = |s: &Sample| s.normal.z > -1e-3 && !obstacle.is_hidden(s.point + s.normal * OFF, DVec3::Z);
        let open: Vec<Sample> = slot.corners.iter().map(sample).filter(is_open).collect();
        let seen: Vec<(Sample, bool)> = open.iter().map(|s| (*s, false)).collect();
        let found = |samples: &[(Sample, bool)]| {
            proposed(&obstacle, &DMat3::IDENTITY, (samples, 0.02), &Cancel::default()).unwrap()
        };
        assert_eq!(found(&seen), None);
        // On the lower wall below the upper edge of the wall that hangs over it.
        let (sin, cos) = 35f64.to_radians().sin_cos();
        let along_wall = -(1.0 / cos + cos) / sin;
        let point = DVec3::new(0.0, 1.0 / cos, -sin + along_wall * cos);
        let border = Sample { point, normal: DVec3::new(0.0, cos, sin), area: 0.0, thickest: 1.0 };
        assert!(obstacle.distance(point) < 1e-9);
        let proposal = found(&[&seen[..], &[(border, true)]].concat()).unwrap();
        assert!(proposal.sees_all() && (proposal.direction.y > 0.05), "{proposal:?}");
    }

    #[test]
    fn an_upright_slot_is_burned_straight_down() {
        let mold = mold([30.0, 30.0, 10.0], &[(&rectangle(6.0, 2.0), 4.0)]);
        let slot = region(&mold, DVec2::splat(-8.0), DVec2::splat(8.0));
        assert_eq!(proposed_for(&mold, &slot, DVec3::NEG_Z), None);
        let back = proposed_for(&mold, &slot, along(15.0, 30.0)).unwrap();
        assert!(back.sees_all() && back.direction == DVec3::NEG_Z, "{back}");
        assert_eq!(back.to_string(), "straight down all of it is seen");
    }

    #[test]
    fn where_no_direction_sees_all_the_shares_are_those_of_the_areas() {
        // Two walls that lean outwards below: the mouth is 2 mm wide, the floor 6 mm, 5 mm below.
        let sides = rectangle(30.0, 20.0);
        let narrows = crate::fixtures::pocket(&sides, &rectangle(8.0, 2.0), &rectangle(8.0, 6.0), [10.0, 5.0]);
        let mold = narrows.mapped(|p| p - DVec3::Z * 10.0);
        let all = region(&mold, DVec2::new(-4.1, -3.1), DVec2::new(4.1, 3.1));
        let found = proposed_for(&mold, &all, DVec3::NEG_Z).unwrap();
        let (floor, wall, end) = (8.0 * 6.0, 8.0 * 29f64.sqrt(), 0.5 * (2.0 + 6.0) * 5.0);
        let area = floor + 2.0 * wall + 2.0 * end;
        // Straight down a strip of the floor and of each end as wide as the mouth; along a wall that wall too.
        let strips = 8.0 * 2.0 + 2.0 * 2.0 * 5.0;
        assert!((found.seen_now - strips / area).abs() < 0.03, "{} {}", found.seen_now, strips / area);
        assert!(!found.sees_all() && found.seen > (strips + wall) / area - 0.03, "{found}");
        assert!(found.to_string().contains(" % of its area is seen, from the present direction "), "{found}");
        assert!((angles_deg(found.direction)[1].abs() - 90.0).abs() < 1e-6, "{found}");
    }

    #[test]
    fn a_direction_is_told_by_its_angles() {
        assert_eq!(angles_deg(DVec3::NEG_Z), [0.0, 0.0]);
        assert!(along(0.0, 77.0).distance(DVec3::NEG_Z) < 1e-15);
        for (direction, angles) in [
            (DVec3::X, [90.0, 0.0]),
            (DVec3::NEG_Y, [90.0, -90.0]),
            (DVec3::new(-0.6, 0.0, -0.8), [36.869_898, 180.0]),
            (DVec3::new(0.5, 0.5, -0.5f64.sqrt()), [45.0, 45.0]),
        ] {
            assert_eq!(angles_deg(direction), angles, "{direction}");
            assert!(along(angles[0], angles[1]).distance(direction) < 1e-8, "{direction}");
        }
    }
}
