//! Division of a region until its tips can be milled.
//!
//! An H-edge that stands upright is where the walls of two faces meet. Cutting the footprint along one of the walls
//! leaves one part on whose boundary that wall goes on straight (the face is enlarged), and parts beyond it. These
//! reach back over the cut by the overlap, between their own walls enlarged, so that nothing is left between them.

use glam::DVec2;
use serde::{Deserialize, Serialize};

use super::footprint::{grown, half_plane, is_thin, shrunk};
use super::h_edge::{HEdge, h_edges, is_upright, place};
use super::params::DividedAt;
use super::tip::{Burned, Footprint, SKIN, TipError, tip};
use crate::outline::Outline;
use crate::plane;
use crate::plane::Shape;
use geometry::mesh::Mesh;
use task::Cancel;

/// How far from a tip in plan what it burns may lie, beyond the gap (mm): regions are known to cells.
pub(super) const CELL: f64 = 0.05;
/// How far a cut lies off the wall it goes along (mm), so that the two do not lie in one another.
const OFF_WALL: f64 = 1e-4;
/// Further than any mold (mm).
const FAR: f64 = 1e5;
/// Divisions one after another, at most.
const DEEPEST: usize = 8;
/// Half the width up to which a part of a region is none (mm): regions are known to cells of this size.
const NOTHING: f64 = 0.008;
/// How near an H-edge lies to one that was to be taken away, if it was not (mm).
const STILL_THERE: f64 = 0.01;
/// How near a corner lies to a line to be on it (mm).
const ON_LINE: f64 = 1e-6;

/// A cut through a footprint.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Cut {
    /// A point that it goes through, in plan (mm).
    pub through: DVec2,
    /// Unit normal.
    pub outward: DVec2,
    /// Whether parts beyond it reach back over it.
    pub overlaps: bool,
}

/// A part of a region and what it was divided into.
#[derive(Debug, Clone)]
pub struct Part {
    /// Where it stands.
    pub footprint: Footprint,
    /// Tip, up to the cap.
    pub body: Mesh,
    /// The edges that no cutter makes.
    pub h_edges: Vec<HEdge>,
    /// The cut, and what it leads to; none where it is not divided.
    pub divided: Option<(Cut, Vec<Part>)>,
    /// Whether there is something beyond the cut that was left out as too thin.
    pub lacks_thin: bool,
}

impl Part {
    /// The parts that are not divided further, in order.
    pub fn leaves(&self) -> Vec<&Part> {
        match &self.divided {
            Some((_, parts)) => parts.iter().flat_map(Part::leaves).collect(),
            None => vec![self],
        }
    }

    /// Whether something of it was left out as too thin.
    pub fn is_lacking(&self) -> bool {
        self.lacks_thin || self.divided.iter().flat_map(|(_, parts)| parts).any(Self::is_lacking)
    }
}

/// How a region is divided.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DivisionSettings {
    /// How far parts reach over one another (mm).
    pub overlap: f64,
    /// The least width of a part (mm).
    pub least: f64,
    /// Inner edges of tips at which it is divided.
    pub at: DividedAt,
    /// Whether parts that are narrower are left out, for the stages that come after; else nothing is divided where
    /// there would be one.
    pub leaves_out_thin: bool,
}

/// A footprint divided until no part has H-edges, or parts would be smaller than the least size.
///
/// # Errors
/// [`TipError`].
pub fn divide(
    burned: &Burned,
    footprint: Footprint,
    settings: &DivisionSettings,
    cancel: &Cancel,
) -> Result<Part, TipError> {
    let deepest = if settings.at == DividedAt::Nothing { 0 } else { DEEPEST };
    divided(burned, footprint, settings, deepest, cancel)
}

fn divided(
    burned: &Burned,
    footprint: Footprint,
    settings: &DivisionSettings,
    deeper: usize,
    cancel: &Cancel,
) -> Result<Part, TipError> {
    cancel.check()?;
    let mut part = whole(burned, footprint, settings.at)?;
    // The first cut that takes an H-edge away, the longest first, and leaves fewest in its parts.
    for edge in part.h_edges.iter().filter(|_| deeper > 0) {
        let mut best: Option<(usize, f64, Cut, Halves)> = None;
        for cut in cuts(edge) {
            cancel.check()?;
            let Some(halves) = parts_of(burned, &part.footprint, &cut, settings)? else { continue };
            let (parts, mouth) = (&halves.parts, halves.mouth);
            let is_left = |h: &HEdge| place(h).distance(place(edge)) < STILL_THERE;
            let left = parts.iter().map(|p| p.h_edges.len()).sum::<usize>();
            let is_better = best.as_ref().is_none_or(|(least, shortest, ..)| (left, mouth) < (*least, *shortest));
            if is_better && !parts.iter().flat_map(|p| &p.h_edges).any(is_left) {
                best = Some((left, mouth, cut, halves));
            }
        }
        if let Some((.., cut, halves)) = best {
            let deeper = |p: Part| divided(burned, p.footprint, settings, deeper - 1, cancel);
            part.lacks_thin = halves.lacks_thin;
            part.divided = Some((cut, halves.parts.into_iter().map(deeper).collect::<Result<_, _>>()?));
            return Ok(part);
        }
    }
    Ok(part)
}

/// A part that is not divided.
///
/// # Errors
/// [`TipError`].
pub(super) fn whole(burned: &Burned, footprint: Footprint, at: DividedAt) -> Result<Part, TipError> {
    let body = tip(burned, &footprint)?;
    let h_edges = h_edges(&body, at);
    Ok(Part { footprint, body, h_edges, divided: None, lacks_thin: false })
}

/// Both parts that a cut makes of a part.
struct Halves {
    parts: Vec<Part>,
    /// The length along which they meet (mm).
    mouth: f64,
    /// Whether one was left out as too thin.
    lacks_thin: bool,
}

/// The parts on both sides of a cut; none where one of them is too small, or its tip cannot be made.
fn parts_of(
    burned: &Burned,
    footprint: &Footprint,
    cut: &Cut,
    settings: &DivisionSettings,
) -> Result<Option<Halves>, TipError> {
    let (mut parts, mouth) = cut_along(burned, footprint, cut, settings);
    let all = parts.len();
    parts.retain(|f| !is_too_small(&f.free, settings.least));
    let lacks_thin = parts.len() < all;
    if parts.is_empty() || (lacks_thin && !settings.leaves_out_thin) {
        return Ok(None);
    }
    match parts.into_iter().map(|f| whole(burned, f, settings.at)).collect::<Result<Vec<Part>, _>>() {
        Ok(parts) => Ok(Some(Halves { parts, mouth, lacks_thin })),
        Err(TipError::NoRoom | TipError::NoSurface | TipError::Solid(_)) => Ok(None),
        Err(other) => Err(other),
    }
}

/// The cuts that take an H-edge away, those that overlap first.
fn cuts(edge: &HEdge) -> Vec<Cut> {
    let through = place(edge);
    let outwards: Vec<DVec2> = if is_upright(edge) {
        edge.normals.iter().map(|n| n.truncate().normalize_or_zero()).filter(|n| *n != DVec2::ZERO).collect()
    } else {
        let along = (edge.ends[1] - edge.ends[0]).truncate().normalize_or_zero();
        vec![along.perp(), -along.perp()]
    };
    let of = |overlaps: bool| outwards.clone().into_iter().map(move |outward| Cut { through, outward, overlaps });
    if is_upright(edge) { of(true).chain(of(false)).collect() } else { of(false).collect() }
}

/// The parts of a footprint on both sides of a cut, and the length along which they meet (mm).
pub fn cut_along(
    burned: &Burned,
    footprint: &Footprint,
    cut: &Cut,
    settings: &DivisionSettings,
) -> (Vec<Footprint>, f64) {
    // Both sides keep off the wall itself, so that neither gets a hair of what lies behind it.
    let through = cut.through + cut.outward * OFF_WALL;
    let near = half_plane(cut.through - cut.outward * OFF_WALL, cut.outward, FAR);
    let far = half_plane(through, -cut.outward, FAR);
    let needed = |side: &[Outline], outward: DVec2| -> Vec<(Shape, Vec<Outline>)> {
        let all = plane::intersection(&footprint.free, side).into_iter();
        all.filter_map(|free| share(burned, footprint, &free, (side, cut.through, outward)).map(|own| (free, own)))
            .collect()
    };
    let with_walls =
        |free: &Shape, side: &[Outline]| both(&both(&flat(plane::grown(free, SKIN)), &footprint.outlines), side);
    let part = |outlines: Vec<Outline>, own: &[Outline]| {
        let free = both(&outlines, &footprint.free);
        let region = flat(plane::union(&both(&outlines, &footprint.region), own));
        Footprint { outlines, free, region, ..*footprint }
    };
    let mut parts: Vec<Footprint> =
        needed(&near, cut.outward).iter().map(|(free, own)| part(with_walls(free, &near), own)).collect();
    let mut mouths = 0.0;
    for (free, own) in needed(&far, -cut.outward) {
        let mut outlines = with_walls(&free, &far);
        let (length, strip) = back_over(&free, through, cut.outward, settings.overlap);
        mouths += length;
        if cut.overlaps {
            let strip = both(&strip, &footprint.free);
            outlines = flat(plane::union(&outlines, &strip));
        }
        parts.push(part(outlines, &own));
    }
    (parts, mouths)
}

/// Part of the region that a piece of a footprint burns on its side of a cut; none where that is nothing, so that the
/// piece is not needed. The outward normal of the cut points away from the side.
fn share(
    burned: &Burned,
    footprint: &Footprint,
    free: &Shape,
    (side, through, outward): (&[Outline], DVec2, DVec2),
) -> Option<Vec<Outline>> {
    let own = both(&both(&footprint.region, side), &grown(free, burned.gap_across + CELL));
    // Along walls the region is a cell wide. What goes on beyond the cut is no cell of what lies before it.
    let beyond = half_plane(through - outward * 2.0 * NOTHING, outward, FAR);
    let is_needed = !shrunk(&both(free, &footprint.region), NOTHING).is_empty()
        || plane::area(&both(&own, &beyond)) > 4.0 * NOTHING * NOTHING;
    is_needed.then_some(own)
}

fn flat(shapes: Vec<Shape>) -> Vec<Outline> {
    shapes.into_iter().flatten().collect()
}

fn both(a: &[Outline], b: &[Outline]) -> Vec<Outline> {
    flat(plane::intersection(a, b))
}

/// The length of a shape's sides on the line of a cut, and the strips by which it reaches back over them, between its
/// own walls enlarged.
fn back_over(shape: &Shape, through: DVec2, outward: DVec2, by: f64) -> (f64, Vec<Outline>) {
    let off = |p: DVec2| (p - through).dot(outward);
    let (mut length, mut strips) = (0.0, Vec::new());
    for outline in shape {
        let points = outline.points();
        let n = points.len();
        for i in 0..n {
            let [before, a, b, after] = [points[(i + n - 1) % n], points[i], points[(i + 1) % n], points[(i + 2) % n]];
            if off(a).abs() > ON_LINE || off(b).abs() > ON_LINE {
                continue;
            }
            length += a.distance(b);
            // Along the wall that ends here, and on beyond the line.
            let back = |wall: DVec2, end: DVec2| {
                let along = end - wall;
                let fall = off(wall).max(1e-9);
                let shift = along * (by / fall);
                end + if shift.length() <= 4.0 * by { shift } else { -outward * by }
            };
            // A hair over the line, so that the strip and the part it belongs to are one.
            let over = outward * OFF_WALL;
            strips.extend(Outline::new(vec![a + over, back(before, a), back(after, b), b + over]));
        }
    }
    let turned =
        |o: Outline| if o.area() > 0.0 { Some(o) } else { Outline::new(o.points().iter().rev().copied().collect()) };
    (length, strips.into_iter().filter_map(turned).collect())
}

/// Whether a head over a set would be smaller than the least size (mm), or nowhere as thick as that.
fn is_too_small(outlines: &[Outline], least: f64) -> bool {
    least_width(outlines) < least || is_thin(outlines, least)
}

/// The least width of a set over all directions in steps of 15 degrees (mm).
pub fn least_width(outlines: &[Outline]) -> f64 {
    let width = |direction: DVec2| {
        let along = outlines.iter().flat_map(Outline::points).map(|p| p.dot(direction));
        let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        high - low
    };
    (0..12).map(|i| width(DVec2::from_angle(i as f64 * std::f64::consts::PI / 12.0))).fold(f64::INFINITY, f64::min)
}
