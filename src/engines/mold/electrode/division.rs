//! Division of a region until its tips can be milled.
//!
//! At an H-edge two faces of a tip meet, and at least one of them is steep. Cutting along that face leaves a part on
//! whose boundary it goes on straight (the face is enlarged, whatever its draft), and parts beyond it. These reach back
//! over the cut by the overlap, between their own faces enlarged, so that nothing is left between them.

use std::iter::once;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::base::{INTO_BASE, on_plate};
use super::check::{milled, turned_over, watertight};
use super::cut::{Cut, FAR, OFF_WALL, ON_PLANE};
use super::cuts::{Undivided, across, cuts, shapes};
use super::footprint::{grown, half_plane, is_thin, shrunk};
use super::h_edge::{HEdge, Milling, h_edges, inner_edges};
use super::params::DividedAt;
use super::samples::on_cuts;
use super::tip::{Burned, Footprint, SKIN, TipError, led_up, tip};
use crate::cutter::CutterLibrary;
use crate::height_field::{FieldRegion, HeightFieldError};
use crate::invert::LEAST_INVERT;
use crate::outline::Outline;
use crate::plane;
use crate::plane::Shape;
use geometry::mesh::{Bounds, Mesh};
use task::Cancel;

/// How far from a tip in plan what it burns may lie, beyond the gap (mm): regions are known to cells.
pub(super) const CELL: f64 = 0.05;
/// Divisions one after another, at most.
const DEEPEST: usize = 16;
/// Half the width up to which a part of a region is none (mm): regions are known to cells of this size.
const NOTHING: f64 = 0.008;
/// Share of the rest material that all divisions of a part together may leave at most.
const LESS: f64 = 0.7;
/// Share of the rest material that a division may leave where further ones follow.
const SOMEWHAT_LESS: f64 = 0.9;
/// Share of the rest material that divisions across it may leave in the end.
const MOST_ACROSS: f64 = 0.02;
/// The share of H-edges that a division takes away, at least, for one of many to be worth it: grooves that cross have
/// them at every crossing, and a cut takes away those along one of their walls.
const LEAST_TAKEN: f64 = 0.04;
/// Share of the rest material that a division may leave where it takes H-edges away alone; more is no division.
const AS_MUCH: f64 = 1.02;
/// Share by which sizes of rest material may differ and be the same.
const SAME_REST: f64 = 1e-9;
/// Divisions one after another that may take less than a share away, or H-edges alone.
const AHEAD: usize = 3;
/// How far a head is led up to try whether it can be milled (mm).
const LED_UP: f64 = 1.0;
/// How near a corner lies to a line to be on it (mm).
pub(super) const ON_LINE: f64 = 1e-6;
/// Downward part of a normal from which on a face that is enlarged has something below it.
const ON_LEVEL: f64 = 1e-3;
/// Least sine of the angle between faces that have a profile, and of its direction with the cut.
const ALONG: f64 = 0.3;

/// A part of a region and what it was divided into.
#[derive(Debug, Clone)]
pub struct Part {
    /// Where it stands.
    pub footprint: Footprint,
    /// Tip, up to the cap.
    pub body: Mesh,
    /// Inner edges of the tip.
    pub(super) inner: Vec<HEdge>,
    /// Inner edges that no cutter makes.
    pub h_edges: Vec<HEdge>,
    /// The cut, and what it leads to; none where it is not divided.
    pub divided: Option<(Cut, Vec<Part>)>,
    /// Whether there is something beyond the cut that was left out as too thin.
    pub lacks_thin: bool,
    /// What became of the cuts that were tried, where cutters leave something of the head.
    pub undivided: Option<Undivided>,
}

impl Part {
    /// The cut along a face of its head, given by a point (mm) and its outward normal; none where the face is not steep.
    pub(super) fn cut_along_face(&self, through: DVec3, normal: DVec3) -> Option<Cut> {
        Cut::along(normal, through).map(|cut| cut.fitted(&self.inner))
    }

    /// The parts that are not divided further, in order.
    pub fn leaves(&self) -> Vec<&Part> {
        match &self.divided {
            Some((_, parts)) => parts.iter().flat_map(Part::leaves).collect(),
            None => vec![self],
        }
    }

    /// The cuts that the part and its parts were divided by.
    fn cuts(&self) -> Vec<Cut> {
        self.divided.iter().flat_map(|(cut, parts)| once(*cut).chain(parts.iter().flat_map(Part::cuts))).collect()
    }

    /// Whether something of it was left out as too thin.
    pub fn is_lacking(&self) -> bool {
        self.lacks_thin || self.divided.iter().flat_map(|(_, parts)| parts).any(Self::is_lacking)
    }
}

/// How a region is divided.
#[derive(Debug, Clone, Copy)]
pub struct DivisionSettings<'a> {
    /// How far parts reach over one another (mm).
    pub overlap: f64,
    /// The least width of a part (mm).
    pub least: f64,
    /// Inner edges of tips at which it is divided.
    pub at: DividedAt,
    /// How inner edges are milled.
    pub milling: Milling,
    /// The cutters that mill the heads.
    pub cutters: &'a CutterLibrary,
    /// Rest material that the cutters may leave (mm).
    pub tolerance: f64,
    /// Whether parts that are narrower are left out, for the stages that come after; else nothing is divided where
    /// there would be one.
    pub leaves_out_thin: bool,
    /// Least radius of the cutters that milled the mold (mm).
    pub milled_by: f64,
}

/// A footprint divided until no part has H-edges, or parts would be smaller than the least size. Where its parts do not
/// burn all places on the cuts between them, it is divided anew with these places asked for; that is taken if the cutters
/// leave no more, nothing is left out and fewer places are missed. `surface` is that of the region, given by its
/// triangles' corners (mm).
///
/// # Errors
/// [`TipError`].
pub fn divide(
    burned: &Burned,
    surface: &[[DVec3; 3]],
    footprint: Footprint,
    settings: &DivisionSettings,
    cancel: &Cancel,
) -> Result<Part, TipError> {
    let deepest = if settings.at == DividedAt::Nothing { 0 } else { DEEPEST };
    let part = whole(burned, footprint, settings)?;
    // A head without inner edges needs no look, unless it consists of several.
    let is_simple = part.inner.is_empty() && shapes(&part.footprint).len() < 2;
    let rest = if is_simple { RestMaterial::default() } else { rest_material(&part, settings, cancel)? };
    let divided = |burned: &Burned| {
        let by_whole = if rest.size > 0.0 { burned.by(&part.body) } else { Vec::new() };
        divided((burned, &by_whole), (part.clone(), rest.clone()), settings, (deepest, AHEAD), cancel)
    };
    let (first, left) = divided(burned)?;
    let missed = missed_on_cuts(burned, surface, &first, cancel)?;
    if missed.is_empty() {
        return Ok(first);
    }
    let places = [burned.places, &missed].concat();
    let (again, left_again) = divided(&Burned { places: &places, ..*burned })?;
    let is_better = left_again <= left * (1.0 + SAME_REST)
        && left.is_finite()
        && !again.is_lacking()
        && missed_on_cuts(burned, surface, &again, cancel)?.len() < missed.len();
    Ok(if is_better { again } else { first })
}

/// Places of the surface on the cuts of a division that its parts together do not burn as the whole does. Where the cuts
/// lie is known only after the division.
fn missed_on_cuts(
    burned: &Burned,
    surface: &[[DVec3; 3]],
    part: &Part,
    cancel: &Cancel,
) -> Result<Vec<DVec3>, TipError> {
    let cuts = part.cuts();
    if cuts.is_empty() || part.is_lacking() {
        return Ok(Vec::new());
    }
    let places: Vec<DVec3> = on_cuts(surface, &cuts).into_iter().map(|(_, p)| p).collect();
    let burned = Burned { places: &places, ..*burned };
    let (by_whole, leaves) = (burned.by(&part.body), part.leaves());
    cancel.check()?;
    let is_burned = burned.are_burned([&by_whole, &by_whole], leaves.iter().map(|leaf| &leaf.body));
    Ok(places.iter().zip(is_burned).filter(|(_, is_burned)| !is_burned).map(|(p, _)| *p).collect())
}

/// A part, divided as long as that leaves less, and the size of what the cutters leave of its heads. `by_whole` tells how
/// far places are from what the head of the whole region burns (mm). `ahead` divisions one after another may take less
/// than a share away, or H-edges alone.
fn divided(
    (burned, by_whole): (&Burned, &[f64]),
    (mut part, rest): (Part, RestMaterial),
    settings: &DivisionSettings,
    (deeper, ahead): (usize, usize),
    cancel: &Cancel,
) -> Result<(Part, f64), TipError> {
    if deeper == 0 || rest.size == 0.0 {
        return Ok((part, rest.size));
    }
    let edges: f64 = part.h_edges.iter().map(HEdge::length).sum();
    let own = burned.by(&part.body);
    let mut tried = Undivided { least: settings.least, ..Undivided::default() };
    // Many heads that no cutter mills either are worse than one: cuts across must leave next to nothing.
    let kinds = [(cuts(&part, &rest, settings), LESS), (across(&part, &rest, settings), MOST_ACROSS)];
    let is_cut = kinds.iter().any(|(cuts, _)| !cuts.is_empty());
    let around = is_cut.then(|| burned.around(&part.footprint)).flatten();
    let burned = &burned.trimmed_by(around.as_ref());
    for (cuts_of_kind, most_left) in kinds {
        let mut best: Option<([f64; 4], bool, Cut, Halves)> = None;
        for cut in cuts_of_kind {
            cancel.check()?;
            tried.tried += 1;
            // What leaves more than the best so far is no better, unless the best has open heads.
            let least = best.as_ref().filter(|(figures, ..)| figures[0] == 0.0).map_or(f64::INFINITY, |b| b.0[1]);
            let most = least.min(AS_MUCH * rest.size);
            let halves = match parts_of((burned, [by_whole, &own]), &part, (&cut, most), settings, cancel)? {
                Ok(halves) => halves,
                Err(refused) => {
                    // Without a head on one of its sides it was no cut.
                    tried.tried -= usize::from(matches!(refused, Refused::NoHead));
                    tried.thin += usize::from(matches!(refused, Refused::Thin));
                    continue;
                }
            };
            let left: f64 = halves.parts.iter().map(|(_, rest)| rest.size).sum();
            let edges_left: f64 = halves.parts.iter().flat_map(|(p, _)| &p.h_edges).map(HEdge::length).sum();
            // Each cut of many takes its share: half as much of the rest material as of the H-edges.
            let taken = if edges > 0.0 { 1.0 - edges_left / edges } else { 0.0 };
            let is_share = taken >= LEAST_TAKEN && left <= (1.0 - 0.5 * taken) * rest.size;
            let is_less = left <= LESS * rest.size || is_share;
            let takes_edges = left <= AS_MUCH * rest.size && edges_left <= LESS * edges;
            let is_on_the_way = ahead > 0 && (takes_edges || left <= SOMEWHAT_LESS * rest.size);
            tried.less += usize::from(is_less || is_on_the_way);
            let open = halves.parts.iter().filter(|(_, rest)| rest.is_open).count();
            let figures = [open as f64, left, edges_left, halves.mouth];
            let is_better = (is_less || is_on_the_way) && best.as_ref().is_none_or(|(least, ..)| figures < *least);
            if is_better
                && (halves.lacks_thin
                    || burned.is_by_all([by_whole, &own], halves.parts.iter().map(|(part, _)| &part.body)))
            {
                best = Some((figures, is_less, cut, halves));
            }
            if best.as_ref().is_some_and(|([open, least, ..], ..)| *open == 0.0 && *least == 0.0) {
                break;
            }
        }
        let Some((_, is_less, cut, halves)) = best else { continue };
        let ahead = if is_less { AHEAD } else { ahead - 1 };
        let further = |half| divided((burned, by_whole), half, settings, (deeper - 1, ahead), cancel);
        let parts: Vec<Result<(Part, f64), TipError>> = halves.parts.into_par_iter().map(further).collect();
        let parts = parts.into_iter().collect::<Result<Vec<_>, _>>()?;
        let left: f64 = parts.iter().map(|(_, left)| left).sum();
        if left <= most_left * rest.size {
            part.lacks_thin = halves.lacks_thin;
            part.divided = Some((cut, parts.into_iter().map(|(part, _)| part).collect()));
            return Ok((part, left));
        }
    }
    part.undivided = Some(tried);
    Ok((part, rest.size))
}

/// Rest material on a part's head.
#[derive(Clone, Default)]
pub(super) struct RestMaterial {
    /// Volume (mm^3) and undercut area (mm^2), or the length of the edges that are to be divided at (mm).
    size: f64,
    /// Where it is, the largest first.
    pub(super) places: Vec<RestPlace>,
    /// Whether the head's surface has open edges or touches itself.
    is_open: bool,
}

/// A connected place of rest material.
#[derive(Clone)]
pub(super) struct RestPlace {
    /// The box around it (mm).
    pub(super) bounds: Bounds,
    /// Where it is thickest (mm).
    pub(super) thickest: DVec3,
}

fn rest_material(part: &Part, settings: &DivisionSettings, cancel: &Cancel) -> Result<RestMaterial, TipError> {
    if settings.at == DividedAt::EveryEdge {
        let size = part.h_edges.iter().map(HEdge::length).sum();
        let place = |edge: &HEdge| RestPlace { bounds: Bounds::of(edge.ends), thickest: edge.ends[0] };
        let places = part.h_edges.iter().map(place).collect();
        return Ok(RestMaterial { size, places, is_open: false });
    }
    let cap = part.footprint.cap;
    // As in its file, where it stands at the origin.
    let origin = part.body.bounds().center().with_z(cap + LED_UP);
    let head = led_up(&part.body, cap, cap + LED_UP + INTO_BASE).mapped(|p| p - origin);
    let nothing_known = || RestMaterial { size: f64::INFINITY, places: Vec::new(), is_open: true };
    let is_open = !watertight(&head).holds;
    let Ok(head) = on_plate(&head) else { return Ok(nothing_known()) };
    match milled(&head, settings.cutters, settings.tolerance, cancel) {
        Ok(milled) => {
            let undercut = if milled.undercut > LEAST_INVERT { milled.undercut } else { 0.0 };
            let volume: f64 = milled.left.iter().map(|left| left.volume).sum();
            let back = |p: DVec3| turned_over(p) + origin;
            let place = |left: &FieldRegion| RestPlace {
                bounds: Bounds::of([left.bounds.min, left.bounds.max].map(back)),
                thickest: back(left.thickest),
            };
            Ok(RestMaterial { size: volume + undercut, places: milled.left.iter().map(place).collect(), is_open })
        }
        Err(HeightFieldError::Cancelled(cancelled)) => Err(cancelled.into()),
        Err(_) => Ok(nothing_known()),
    }
}

/// A part that is not divided.
///
/// # Errors
/// [`TipError`].
pub(super) fn whole(burned: &Burned, footprint: Footprint, settings: &DivisionSettings) -> Result<Part, TipError> {
    let body = tip(burned, &footprint)?;
    let inner = inner_edges(&body);
    let h_edges = h_edges(&inner, settings.at, &settings.milling);
    Ok(Part { footprint, body, inner, h_edges, divided: None, lacks_thin: false, undivided: None })
}

/// Both parts that a cut makes of a part.
struct Halves {
    parts: Vec<(Part, RestMaterial)>,
    /// The length along which they meet (mm).
    mouth: f64,
    /// Whether one was left out as too thin.
    lacks_thin: bool,
}

/// Reason why a cut is not taken.
#[derive(Debug)]
enum Refused {
    /// A part would be narrower than the least size.
    Thin,
    /// There is no head on one of its sides.
    NoHead,
    /// The cutters leave no less of both parts than of the whole, or than of another cut's.
    LeavesAsMuch,
}

/// The parts on both sides of a cut that burn something; the reason where one of them is too small, where its tip cannot
/// be made, or where the cutters leave more than `most` of them. `by` tells how far places are from what the heads of
/// the whole region and of the part burn (mm).
fn parts_of(
    (burned, by): (&Burned, [&[f64]; 2]),
    part: &Part,
    (cut, most): (&Cut, f64),
    settings: &DivisionSettings,
    cancel: &Cancel,
) -> Result<Result<Halves, Refused>, TipError> {
    let (parts, mouth) = cut_along(burned, part, cut, settings);
    let (small, parts): (Vec<_>, Vec<_>) = parts.into_iter().partition(|f| is_too_small(&f.free, settings.least));
    // What the others reach is none of theirs.
    let lacks_thin = small.iter().any(|f| !is_reached(burned, f, &parts.iter().collect::<Vec<_>>()));
    if parts.is_empty() || (lacks_thin && !settings.leaves_out_thin) {
        return Ok(Err(if small.is_empty() { Refused::NoHead } else { Refused::Thin }));
    }
    let parts: Result<Vec<Part>, TipError> = parts.into_iter().map(|f| whole(burned, f, settings)).collect();
    let parts = match parts {
        Ok(parts) => parts,
        Err(error) if error.is_no_head() => return Ok(Err(Refused::NoHead)),
        Err(error) => return Err(error),
    };
    let is_needed = are_needed(burned, by, &parts.iter().collect::<Vec<_>>());
    let (mut needed, mut left) = (Vec::new(), 0.0);
    for (part, _) in parts.into_iter().zip(is_needed).filter(|(_, is_needed)| *is_needed) {
        let rest = rest_material(&part, settings, cancel)?;
        left += rest.size;
        needed.push((part, rest));
        if left > most {
            return Ok(Err(Refused::LeavesAsMuch));
        }
    }
    Ok(Ok(Halves { parts: needed, mouth, lacks_thin }))
}

/// Whether others, in plan, come as near to a footprint's share of the region as what they burn reaches.
fn is_reached(burned: &Burned, footprint: &Footprint, others: &[&Footprint]) -> bool {
    let free: Vec<Outline> = others.iter().flat_map(|other| other.free.iter().cloned()).collect();
    let reached = grown(&free, burned.gap_across + CELL);
    shrunk(&plane::outlines(plane::difference(&footprint.region, &reached)), NOTHING).is_empty()
}

/// Whether each of several parts burns something that the others do not; a head that removes nothing is none, as one
/// that a cut leaves in the air beside the mold. `by` tells how far places are from what the heads of the whole region
/// and of what was divided burn (mm).
pub(super) fn are_needed(burned: &Burned, by: [&[f64]; 2], parts: &[&Part]) -> Vec<bool> {
    let mut is_needed = vec![true; parts.len()];
    let size = |i: &usize| plane::area(&parts[*i].footprint.free);
    let mut order: Vec<usize> = (0..parts.len()).collect();
    order.sort_by(|a, b| size(a).total_cmp(&size(b)).then(a.cmp(b)));
    for i in order {
        let others: Vec<&Part> = (0..parts.len()).filter(|j| *j != i && is_needed[*j]).map(|j| parts[j]).collect();
        let footprints: Vec<&Footprint> = others.iter().map(|other| &other.footprint).collect();
        let is_reached = !others.is_empty() && is_reached(burned, &parts[i].footprint, &footprints);
        is_needed[i] = !(is_reached && burned.is_by_all(by, others.iter().map(|other| &other.body)));
    }
    is_needed
}

/// The parts of a part on both sides of a cut, and the length along which they meet (mm).
pub(super) fn cut_along(burned: &Burned, part: &Part, cut: &Cut, settings: &DivisionSettings) -> (Vec<Footprint>, f64) {
    let (footprint, outward) = (&part.footprint, cut.outward());
    let crossed: Vec<&HEdge> = part.inner.iter().filter(|edge| cut.holds(edge)).collect();
    // The near part is widest at the cap, what lies beyond it where the cut begins.
    let low = cut.low.clamp(footprint.low, footprint.cap);
    let [inner, outer] = [low, footprint.cap].map(|height| cut.line(height));
    // Both sides keep off the wall itself, so that neither gets a hair of what lies behind it.
    let through = outer + outward * OFF_WALL;
    let near = half_plane(outer - outward * OFF_WALL, outward, FAR);
    let far = half_plane(through, -outward, FAR);
    let needed = |side: &[Outline], through: DVec2, outward: DVec2| -> Vec<(Shape, Vec<Outline>)> {
        // What is no wider than faces are known to is part of their walls.
        let is_wide = |free: &Shape| !shrunk(free, ON_PLANE).is_empty();
        let all = plane::intersection(&footprint.free, side).into_iter().filter(is_wide);
        all.filter_map(|free| share(burned, footprint, &free, (side, through, outward)).map(|own| (free, own)))
            .collect()
    };
    let with_walls = |free: &Shape, side: &[Outline]| {
        both(&both(&plane::outlines(plane::grown(free, SKIN)), &footprint.outlines), side)
    };
    let part = |outlines: Vec<Outline>, own: &[Outline], removed: &[Vec<DVec3>]| {
        let free = both(&outlines, &footprint.free);
        let region = plane::outlines(plane::union(&both(&outlines, &footprint.region), own));
        let removed = footprint.removed.iter().chain(removed).cloned().collect();
        Footprint { outlines, free, region, removed, ..*footprint }
    };
    let (bottom, top) = (footprint.low - 1.0, footprint.cap + 1.0);
    // Down to the tip: what stayed beyond the cut below its lowest edge would be a ledge that no cutter reaches.
    let beyond: Vec<Vec<DVec3>> = (cut.normal.z < 0.0).then(|| cut.all_beyond([bottom, top])).into_iter().collect();
    let mut parts: Vec<Footprint> =
        needed(&near, outer, outward).iter().map(|(free, own)| part(with_walls(free, &near), own, &beyond)).collect();
    // Below the cap a slanted cut lies within the near part's outline.
    let reach = inner.distance(outer) + if cut.overlaps { settings.overlap } else { 0.0 };
    let below: Vec<Vec<DVec3>> = enlarged(&crossed, cut, reach, bottom);
    let mut mouths = 0.0;
    for (free, own) in needed(&far, outer, -outward) {
        let mut outlines = with_walls(&free, &far);
        let (length, strip) = back_over(&free, through, outward, reach);
        mouths += length;
        if reach > 0.0 {
            let strip = both(&strip, &footprint.free);
            outlines = plane::outlines(plane::union(&outlines, &strip));
        }
        parts.push(part(outlines, &own, if reach > 0.0 { &below } else { &[] }));
    }
    (parts, mouths)
}

/// The space below the faces beyond a cut at the edges on it, enlarged back over the cut, down to a height: convex
/// bodies, each given by its corners (mm).
pub(super) fn enlarged(edges: &[&HEdge], cut: &Cut, reach: f64, low: f64) -> Vec<Vec<DVec3>> {
    let beyond = |edge: &HEdge| {
        let [n, m] = edge.normals;
        if n.dot(cut.normal) < m.dot(cut.normal) { n } else { m }
    };
    let faces: Vec<DVec3> = edges.iter().map(|edge| beyond(edge)).collect();
    // Faces of one profile are enlarged along it, so that they go on together.
    let first = faces.first().copied().unwrap_or(DVec3::Z);
    let along = faces.iter().map(|n| first.cross(*n)).max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
    let along = along.and_then(|along| (along.length() > ALONG).then(|| along.normalize().truncate()));
    let outward = cut.outward();
    let along = along.filter(|along| along.dot(outward).abs() > ALONG).unwrap_or(outward);
    let back = along * (-2.0 * reach / along.dot(outward));
    let below = |(edge, face): (&&HEdge, &DVec3)| {
        // Below an upright face there is nothing.
        let rise = (face.z < -ON_LEVEL).then(|| -face.truncate().dot(back) / face.z)?;
        // A hair longer than the edge, so that nothing beside its ends touches what is left.
        let [a, b] = edge.ends;
        let longer = (b - a).normalize_or_zero() * OFF_WALL;
        let [a, b] = [a - longer, b + longer];
        let top = [a, b, a + back.extend(rise), b + back.extend(rise)];
        Some(top.into_iter().chain(top.map(|p| p.with_z(low))).collect())
    };
    edges.iter().zip(&faces).filter_map(below).collect()
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

fn both(a: &[Outline], b: &[Outline]) -> Vec<Outline> {
    plane::outlines(plane::intersection(a, b))
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
    let turned = |o: Outline| if o.area() > 0.0 { o } else { o.reversed() };
    (length, strips.into_iter().map(turned).collect())
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
