//! Residual stock of a region after its burns, and the part of it that no electrode can burn with this spark.
//!
//! The spark rounds what it burns: an electrode that has all the room that the gap and the orbit allow, the fullest
//! one, still leaves something in corners. What an electrode leaves there besides it is held against the tolerance.
//! What stays in a corner is told by how far the mold's surface is from what is burned there.
//! Where the fullest one does not come at all, as in a slot that is narrower than twice the gap, it is no excuse for what
//! stays of the region: a corner is where faces meet at an angle, near what it burns, and not where they stand opposite to
//! one another. No electrode is to blame for it either.

use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::burning::Burning;
use super::clearance::Obstacle;
use super::finding::{CheckKind, Finding};
use super::params::{Orbit, Stage};
use task::{Cancel, Cancelled};

/// How near to the burn surface a march along a normal ends (mm).
const ARRIVED: f64 = 1e-6;
/// Distance off the surface at which it is asked what hangs over a sample (mm).
pub(super) const BESIDE: f64 = 1e-4;
/// Share of a distance by which a point above a face is nearer to another one if it is that one's.
const OTHER: f64 = 1e-3;
/// A step of such a march, at least (mm).
const LEAST_STEP: f64 = 1e-4;
/// Steps of such a march, at most.
const STEPS: usize = 200;
/// Cosine of the angle of two normals below which faces stand opposite to one another: where they meet at 42.5 degrees,
/// between the angles that grooves have, so that rounding does not decide.
pub(super) const OPPOSED: f64 = -0.7373;
/// How far a corner's end may be from what the fullest electrode burns, of the radius of what burns: where two faces
/// meet at that angle, or two at 60 on a floor.
const FARTHEST: f64 = 1.76;
/// An electrode is to blame for nothing where the fullest one leaves this share of what it leaves.
const AS_MUCH: f64 = 0.8;

/// A sample of the uncut surface, at which residual stock is measured.
#[derive(Debug, Clone, Copy)]
pub struct Sample {
    /// Middle (mm).
    pub point: DVec3,
    /// Unit normal.
    pub normal: DVec3,
    /// Area (mm^2).
    pub area: f64,
    /// How thick at most the cutters leave it (mm).
    pub thickest: f64,
}

/// Residual stock of a region after its burns.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct LeftOfRegion {
    /// Greatest thickness (mm): in corners that the spark rounds how far the mold's surface is from what is burned, else
    /// across the stock.
    pub thickness: f64,
    /// Where that is.
    pub place: DVec3,
    /// Greatest excess of residual stock over what the gap's radius leaves in corners (mm).
    pub excess: f64,
    /// Where that is.
    pub excess_place: DVec3,
    /// Volume (mm^3).
    pub volume: f64,
}

impl LeftOfRegion {
    /// Residual stock of both together: the greater thickness and the greater excess, each with its place, and the sum of
    /// the volumes.
    pub(super) fn and(self, other: Self) -> Self {
        let thicker = if other.thickness > self.thickness { other } else { self };
        let worse = if other.excess > self.excess { other } else { self };
        Self { volume: self.volume + other.volume, excess: worse.excess, excess_place: worse.excess_place, ..thicker }
    }

    /// The same with its places moved.
    pub(super) fn moved(self, to: impl Fn(DVec3) -> DVec3) -> Self {
        Self { place: to(self.place), excess_place: to(self.excess_place), ..self }
    }
}

/// Where cutters leave something, known to `within` (mm).
pub struct Milled<'a> {
    /// Whether they leave it at a point, or within a distance of it along the axes (mm).
    pub leaves: &'a (dyn Fn(DVec3, f64) -> bool + Sync),
    /// How far off the answer may be (mm): beside a wall the place itself may be told to be in the wall.
    pub within: f64,
}

impl Milled<'_> {
    /// Accuracy of the thickness of what the cutters leave (mm): on its grid a cutter is taken for thinner than it is by
    /// up to a quarter of a cell.
    pub fn accuracy(&self) -> f64 {
        0.25 * self.within
    }

    fn leaves_near(&self, p: DVec3) -> bool {
        (self.leaves)(p, self.within)
    }

    /// How far along a line from `near`, beside a wall, to `end`, where they leave nothing any more, the stock goes (mm).
    fn ends(&self, at: &dyn Fn(f64) -> DVec3, [near, end]: [f64; 2]) -> f64 {
        /// Halvings of the way.
        const HALVINGS: usize = 8;
        let (mut left, mut free) = (near, end);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (left + free);
            if (self.leaves)(at(middle), 0.0) { left = middle } else { free = middle }
        }
        left
    }
}

/// Burns of a region.
pub(super) struct Burns<'a> {
    /// Each of its burns.
    pub(super) all: &'a [Burning],
    /// The fullest electrode, if corners are to be forgiven at all.
    pub(super) fullest: Option<&'a Burning>,
}

/// Residual stock on a sample.
#[derive(Debug, Clone, Copy)]
pub(super) struct LeftAt {
    /// How much.
    pub(super) left: LeftOfRegion,
    /// Whether it is in a slot that no electrode of this spark enters, so that none of them is to blame.
    pub(super) is_in_slot: bool,
    /// Whether the fullest electrode does not come near it, and leaves as much.
    pub(super) is_unreached: bool,
    /// Whether none comes near it, because the mold hangs over it.
    pub(super) is_shaded: bool,
}

/// Residual stock on each of the samples of a region's surface, of the stock that the cutters left.
///
/// # Errors
/// [`Cancelled`].
pub(super) fn left_by(
    burns: &Burns,
    samples: &[Sample],
    (mold, milled): (&Obstacle, &Milled),
    cancel: &Cancel,
) -> Result<Vec<LeftAt>, Cancelled> {
    let of = |sample: &Sample| -> Result<LeftAt, Cancelled> {
        cancel.check()?;
        Ok(left_at(burns, sample, mold, milled))
    };
    samples.par_iter().map(of).collect()
}

fn left_at(burns: &Burns, sample: &Sample, mold: &Obstacle, milled: &Milled) -> LeftAt {
    let beyond = |p: DVec3| burns.all.iter().map(|burn| burn.beyond(p)).fold(f64::INFINITY, f64::min);
    let thickness = march(sample, &beyond, mold, milled).thickness;
    let (mut allowed, mut is_in_slot, mut is_unreached, mut is_shaded) = (0.0, false, false, false);
    // On an edge a normal runs into, or along, the other face.
    let rounded = if milled.leaves_near(sample.point) { beyond(sample.point).clamp(0.0, sample.thickest) } else { 0.0 };
    let mut told = thickness;
    if let Some(fullest) = burns.fullest.filter(|_| thickness.max(rounded) > ARRIVED && !burns.all.is_empty()) {
        let least = march(sample, &|p| fullest.beyond(p), mold, milled);
        let reach = burns.all.iter().map(Burning::reach).fold(0.0, f64::max);
        is_in_slot = least.is_opposed;
        let is_near = least.farthest <= FARTHEST * reach;
        // What burns there keeps the gap on its way up too.
        let is_under = || mold.hangs_over(sample.point + sample.normal * reach, reach, DVec3::Z);
        is_shaded = !is_near
            && !is_in_slot
            && (mold.hangs_over(sample.point + sample.normal * BESIDE, 0.0, DVec3::Z) || is_under());
        if is_near && !is_in_slot {
            (allowed, told) = (least.thickness, rounded);
        }
        is_unreached = !is_near && least.thickness >= AS_MUCH * thickness;
    }
    let excess = (thickness - allowed).max(0.0);
    let (place, volume) = (sample.point, thickness * sample.area);
    let left = LeftOfRegion { thickness: told, place, excess, excess_place: place, volume };
    LeftAt { left, is_in_slot, is_unreached, is_shaded }
}

/// Walk along a sample's normal through the residual stock.
struct March {
    /// How far off any face the way comes (mm): along an edge a normal runs beside another face, and what is nearer to
    /// that one is counted there.
    thickness: f64,
    /// How far at most it was from what is burned (mm).
    farthest: f64,
    /// Whether it came nearer to a face that stands opposite.
    is_opposed: bool,
}

/// The way along a sample's normal to where nothing is `beyond` what is burned, or the cutters have been.
fn march(sample: &Sample, beyond: &dyn Fn(DVec3) -> f64, mold: &Obstacle, milled: &Milled) -> March {
    let at = |t: f64| sample.point + sample.normal * t;
    let mut met = March { thickness: 0.0, farthest: 0.0, is_opposed: false };
    let mut along = 0.0;
    for _ in 0..STEPS {
        let step = beyond(at(along));
        if step <= ARRIVED || along >= sample.thickest {
            break;
        }
        met.farthest = met.farthest.max(step);
        // Where it is not known to a cell whether the cutters leave it, small steps.
        let on = f64::min(along + step.clamp(LEAST_STEP, milled.within.max(LEAST_STEP)), sample.thickest);
        let (off, from) = mold.off(at(on));
        if off <= 0.0 {
            break;
        }
        if !milled.leaves_near(at(on)) {
            // It ended no more than 1.5 cells before the last place where they may leave something.
            let end = milled.ends(&at, [f64::max(along - 1.5 * milled.within, 0.0), on]);
            met.thickness = met.thickness.min(end);
            break;
        }
        along = on;
        met.thickness = met.thickness.max(along.min(off));
        met.is_opposed |= off < along * (1.0 - OTHER) && from.dot(sample.normal) < OPPOSED;
    }
    met
}

/// How closely a region was looked at.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Looked {
    /// Distance of samples on faces (mm).
    pub on_faces: f64,
    /// Tolerance along edges and cuts (mm).
    pub along_edges: f64,
}

impl Looked {
    /// The coarser of both.
    pub(super) fn and(self, other: Self) -> Self {
        Self { on_faces: self.on_faces.max(other.on_faces), along_edges: self.along_edges.max(other.along_edges) }
    }
}

/// Remark for a square orbit where stock is left.
const SQUARE: &str =
    "; a square orbit reaches only into corners of walls along X and Y: a circular one, or none, leaves less";

/// The finding for what is left of the parts that an electrode is for: what is left beyond what the spark keeps in
/// corners is held against the tolerance, to the accuracy that what the cutters leave is known to (mm).
pub fn residual_stock(
    left: &LeftOfRegion,
    (tolerance, accuracy): (f64, f64),
    stage: &Stage,
    looked: Looked,
) -> Finding {
    let holds = left.excess <= tolerance + accuracy;
    let apart =
        format!("sampled every {:.2} mm on faces, every {:.2} mm along edges", looked.on_faces, looked.along_edges);
    let text = if holds && left.excess > tolerance {
        format!(
            "residual stock {:.4} mm beyond the corner radius, allowed rest {tolerance:.4} mm, which is kept within \
             the {accuracy:.4} mm to which the cutters' rest is known; {:.4} mm^3 in all; {apart}",
            left.excess, left.volume
        )
    } else if holds {
        format!(
            "residual stock up to {:.4} mm, in corners rounded by the spark; {:.4} mm^3 in all; {apart}",
            left.thickness, left.volume
        )
    } else {
        format!(
            "residual stock {:.4} mm beyond the corner radius, allowed rest {tolerance:.4} mm; {:.4} mm^3 in all{}; \
             {apart}",
            left.excess,
            left.volume,
            if matches!(stage.orbit, Orbit::Square { .. }) { SQUARE } else { "" }
        )
    };
    let finding = Finding::new(CheckKind::ResidualStock, holds, text, (!holds).then_some(left.excess_place));
    finding.with(&[("excess_mm", left.excess)])
}
