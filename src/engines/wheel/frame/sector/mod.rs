//! The whole wheel from a sector of it that two planes through the axis cut out, or one, which leaves a half.
//!
//! The sector keeps as many whole pitches as fit into it, and into a full turn without rest. These are turned about the
//! axis. The two ends of what is kept are sections of surfaces that repeat, so that they are congruent but for the
//! chord error of the mesh: they are joined point by point, and where that does not close the surface there is no wheel.

mod cuts;
mod error;
mod half;
mod join;

use std::collections::{HashMap, HashSet};
use std::f64::consts::{PI, TAU};

use glam::{DMat3, DVec2, DVec3, Vec3Swizzles as _};
use rayon::prelude::*;

use self::cuts::{Cut, clipped, cuts};
pub use self::error::SectorError;
use self::join::join;
use super::axis::{self, Axis, Turning};
use super::frame_along;
use super::slices::{CELLS, Crossing, Slices, cylindrical_components};
use crate::options::{AxisChoice, AxisLine, BliskOptions};
use geometry::exact::ExactMesh;
use geometry::frame::{Cylindrical, Frame, wrap_angle};
use geometry::mesh::{Mesh, normal_times_two_areas};
use task::{Cancel, Cancelled};

/// Distance within which points lie on a cut, as a share of the size of the sector: the rounding of files.
const ON_CUT: f64 = 2e-5;
/// Distance within which two ends are joined, as a share of the size of the sector, where chord errors are no greater.
const JOINT: f64 = 5e-5;
/// The greatest such distance, however great the chord errors are.
const MOST_JOINT: f64 = 2e-3;
/// Most triangles of a whole wheel.
const MOST_TRIANGLES: usize = 20_000_000;
/// Angles that are the same (rad).
const SAME: f64 = 1e-3;

/// A wheel that was made of a sector.
pub(super) struct Whole {
    /// The wheel, in the coordinates of the sector's mesh.
    pub mesh: Mesh,
    /// Axis of the wheel.
    pub axis: Axis,
    /// Number of blades that its pitch was told by.
    pub blades: usize,
    /// Number of copies that it was made of.
    pub copies: usize,
    /// Unit vector from the axis to the middle of the sector.
    pub middle: DVec3,
    /// Whole pitches that the sector holds.
    pub pitches_held: usize,
    /// Whether the sector holds no two blades that are alike, so that its angle was taken for their pitch.
    is_by_angle: bool,
    /// Angle between the cuts (rad).
    angle: f64,
    /// How far points were moved to join the copies (mm).
    shift: f64,
}

impl Whole {
    /// The assumption made, in sentences for the user, of a wheel that turned out to have so many blades.
    pub fn assumed(&self, blades: usize) -> String {
        let cuts = if (self.angle - PI).abs() < SAME { "Its cut holds" } else { "Its cuts meet in" };
        let unsure =
            " It holds no two blades that are alike: its angle was taken for one pitch, which blisk.blades corrects.";
        let unsure = if self.is_by_angle { unsure } else { "" };
        format!(
            "The mesh is a sector of {:.3} deg. {cuts} the axis {}; {} of its pitches were turned about it \
             into the {} sectors of the whole wheel of {blades} blades, whose ends were moved by up to {:.4} mm to \
             meet. What does not repeat with the blades, as bolt holes, is not where it is on the part.{unsure}",
            self.angle.to_degrees(),
            self.axis,
            blades / self.copies,
            self.copies,
            self.shift
        )
    }
}

/// The wheel that `mesh`, oriented outwards, is a sector of; none if no planes cut it out about an axis that `options`
/// allow.
///
/// # Errors
/// [`SectorError`], of the likeliest axis.
pub(super) fn whole_wheel(mesh: &Mesh, options: &BliskOptions, cancel: &Cancel) -> Result<Option<Whole>, SectorError> {
    let mut first_error = None;
    for sector in sectors(mesh, options, cancel)? {
        match sector.whole(options.blades.given(), cancel) {
            Err(SectorError::Cancelled(cancelled)) => return Err(cancelled.into()),
            Err(error) if sector.is_likely => first_error = first_error.or(Some(error)),
            Err(_) => {}
            found => return found.map(Some),
        }
    }
    first_error.map_or(Ok(None), Err)
}

/// Blades of the whole wheel.
struct Blades {
    count: usize,
    /// Cells of the slices in which they follow each other.
    cells: HashSet<[usize; 2]>,
    /// Whether the sector holds no two blades that are alike, so that its angle was taken for their pitch.
    is_by_angle: bool,
}

/// A sector between two cuts, in the frame of its axis.
struct Sector {
    mesh: Mesh,
    frame: Frame,
    axis: Axis,
    /// Angle of the lower cut (rad).
    from: f64,
    /// Angle between the cuts (rad).
    angle: f64,
    /// Distance within which points lie on a cut (mm).
    on_cut: f64,
    /// Distance within which its ends are joined (mm).
    joint: f64,
    /// Whether about as much of the surface turns about its axis as about any other line: if not, it is a sector only
    /// where a wheel can be made of it.
    is_likely: bool,
}

/// The sectors that `mesh` may be, the likeliest first: about the line of two cuts, or in the one cut of half a wheel,
/// that its surfaces turn about most.
fn sectors<'a>(
    mesh: &'a Mesh,
    options: &BliskOptions,
    cancel: &Cancel,
) -> Result<impl Iterator<Item = Sector> + use<'a>, Cancelled> {
    /// Cuts at a smaller angle meet nowhere that can be told.
    const LEAST_ANGLE: f64 = 0.01;
    /// Hub, shroud and rims turn about the axis: at least this share of the surface. An axis is likely where it is this
    /// part of what turns about any other line, as about one along a thick blade.
    const LEAST_TURNING: f64 = 0.02;
    const LIKELY_PART: f64 = 0.5;
    /// An axis is likely as well where both cuts hold this share of the extents of the part, and the smaller of them has
    /// this share of the other's area.
    const HELD: f64 = 0.5;
    const ALIKE: f64 = 0.9;
    /// Lines that are tried, and cuts that half a wheel may be cut at.
    const MOST: usize = 4;
    const MOST_HALVES: usize = 8;
    let size = mesh.bounds().size().length();
    let on_cut = ON_CUT * size;
    let (cuts, turning) = (cuts(mesh, on_cut, cancel)?, Turning::new(mesh));
    let section = |cut: &Cut| cancel.check().map(|()| thinned(cut.facets(mesh, on_cut).flatten()));
    let sections: Vec<Vec<DVec3>> = cuts.par_iter().map(section).collect::<Result<_, Cancelled>>()?;
    let all = thinned(mesh.vertices.iter().copied());
    let mut axes: Vec<(f64, Axis, [usize; 2])> = Vec::new();
    let mut add = |axis: Axis, of: [usize; 2]| {
        let allowed = Some((turning.share(&axis), axis)).filter(|(share, _)| *share > LEAST_TURNING);
        axes.extend(allowed.filter(|_| is_allowed(&axis, options)).map(|(share, axis)| (share, axis, of)));
    };
    // The line that is given lies in the cuts, to the rounding of what is typed.
    let given = match options.axis {
        AxisChoice::Line(AxisLine { direction, point }) => Some(Axis::new(point.into(), direction.into())),
        AxisChoice::Named(_) => None,
    };
    let holds = |cut: &Cut, axis: &Axis| {
        let within = 4.0 * on_cut;
        cut.normal.dot(axis.direction).abs() * size < within && (cut.normal.dot(axis.point) - cut.at).abs() < within
    };
    for (i, a) in cuts.iter().enumerate() {
        for (j, b) in cuts[..i].iter().enumerate() {
            cancel.check()?;
            let along = a.normal.cross(b.normal);
            if along.length() < LEAST_ANGLE {
                continue;
            }
            let point = (b.normal.cross(along) * a.at + along.cross(a.normal) * b.at) / along.length_squared();
            match given {
                Some(axis) if holds(a, &axis) && holds(b, &axis) => add(axis, [i, j]),
                Some(_) => {}
                None => add(Axis::new(point, along).snapped(size), [i, j]),
            }
        }
    }
    // The cut that leaves half a wheel is one of the largest.
    for (i, cut) in cuts.iter().enumerate().take(MOST_HALVES) {
        cancel.check()?;
        let is_turned = |axis: &Axis| turning.share(axis) > 0.5 * LEAST_TURNING;
        match given {
            Some(axis) if holds(cut, &axis) && half::divides(mesh, cut, on_cut, &axis) => add(axis, [i; 2]),
            Some(_) => {}
            None => {
                let axes = half::axes(mesh, cut, on_cut, is_turned);
                axes.into_iter().for_each(|axis| add(axis.snapped(size), [i; 2]));
            }
        }
    }
    // Facets of a rim lie in planes like cuts, but hold little of what turns about the line where two of them meet.
    let likelihood = |found: (f64, Axis, [usize; 2])| {
        let (share, axis, of) = &found;
        let whole = extent(axis, &all);
        let held = of.map(|cut| (extent(axis, &sections[cut]) / whole).min(DVec2::ONE).element_product());
        (share * held[0].min(held[1]), found)
    };
    let mut axes: Vec<_> = axes.into_iter().map(likelihood).collect();
    axes.sort_by(|a, b| b.0.total_cmp(&a.0));
    axes.truncate(MOST);
    let best = axis::candidates(mesh, None).iter().map(|axis| turning.share(axis)).fold(0.0, f64::max);
    let sector = move |(likelihood, (share, axis, of_cuts)): (f64, (f64, Axis, [usize; 2]))| {
        // Whole pitches apart the cuts are alike.
        let [least, most] = [f64::min, f64::max].map(|of| of(cuts[of_cuts[0]].area, cuts[of_cuts[1]].area));
        let is_alike = of_cuts[0] != of_cuts[1] && likelihood > HELD * share && least > ALIKE * most;
        let is_likely = is_alike || share >= LIKELY_PART * best;
        let frame = frame_along(&axis);
        let [a, b] = of_cuts.map(|cut| frame.direction_from_parent(cuts[cut].normal));
        // Out of the upper cut in the sense of theta, out of the lower one against it.
        let (upper, lower) = (|n: DVec3| (-n.z).atan2(-n.y), |n: DVec3| n.z.atan2(n.y));
        let between = |low: DVec3, high: DVec3| (upper(high) - lower(low)).rem_euclid(TAU);
        let (low, high) = if between(a, b) < PI { (a, b) } else { (b, a) };
        let (from, angle) = (lower(low), between(low, high));
        let mesh = mesh.in_frame(&frame);
        let joint = (JOINT * size).max(chord_error(&mesh).min(MOST_JOINT * size));
        Sector { mesh, frame, axis, from, angle, on_cut, joint, is_likely }
    };
    Ok(axes.into_iter().map(sector).filter(|sector| sector.angle < PI + SAME))
}

/// Some of the points, enough to tell how far they reach.
fn thinned(points: impl Iterator<Item = DVec3>) -> Vec<DVec3> {
    const ENOUGH: usize = 1000;
    let points: Vec<DVec3> = points.collect();
    let step = (points.len() / ENOUGH) | 1;
    points.into_iter().step_by(step).collect()
}

/// How far points reach along an axis and away from it (mm).
fn extent(axis: &Axis, points: &[DVec3]) -> DVec2 {
    let place = |p: &DVec3| DVec2::new(axis.direction.dot(*p), axis.direction.cross(*p - axis.point).length());
    let [mut least, mut most] = [DVec2::INFINITY, DVec2::NEG_INFINITY];
    for place in points.iter().map(place) {
        [least, most] = [least.min(place), most.max(place)];
    }
    most - least
}

/// Greatest height of an arc about X over the edge that stands for it, on surfaces of revolution (mm).
fn chord_error(mesh: &Mesh) -> f64 {
    /// Ends of such an edge have the same radius and x to this share.
    const LEVEL: f64 = 1e-3;
    /// Parts of its normal by which a surface of revolution faces along the radius, at least, and around the axis, at
    /// most.
    const FACING: [f64; 2] = [0.3, 0.1];
    let rise = |corners: [DVec3; 3]| {
        let normal = normal_times_two_areas(corners).normalize_or_zero();
        let middle = corners.into_iter().sum::<DVec3>() / 3.0;
        let out = DVec3::new(0.0, middle.y, middle.z).normalize_or_zero();
        if normal.dot(out).abs() < FACING[0] || normal.dot(DVec3::X.cross(out)).abs() > FACING[1] {
            return 0.0;
        }
        let edges = [[0, 1], [1, 2], [2, 0]].map(|edge| edge.map(|i| Cylindrical::from_point(corners[i])));
        let of_edge = |[a, b]: [Cylindrical; 2]| {
            let half = 0.5 * wrap_angle(b.theta - a.theta).abs();
            let is_arc = (a.r - b.r).abs() < LEVEL * a.r && (a.x - b.x).abs() < 0.1 * half * a.r;
            if is_arc { a.r * (1.0 - half.cos()) } else { 0.0 }
        };
        edges.map(of_edge).into_iter().fold(0.0, f64::max)
    };
    mesh.iter_corners().map(rise).fold(0.0, f64::max)
}

/// Whether `options` allow an axis that was found, or given, along this direction.
fn is_allowed(axis: &Axis, options: &BliskOptions) -> bool {
    let is_along = |direction: DVec3| axis.direction.cross(direction).length() < SAME;
    match options.axis {
        AxisChoice::Line(_) => true,
        AxisChoice::Named(name) => name.direction().is_none_or(is_along),
    }
}

impl Sector {
    fn whole(&self, wanted: Option<usize>, cancel: &Cancel) -> Result<Whole, SectorError> {
        let (axis, angle_deg) = (self.axis, self.angle.to_degrees());
        let slices = Slices::new(self.mesh.clone());
        let exact = ExactMesh::new(&self.mesh).map_err(|e| SectorError::Mesh(e.to_string()))?;
        let mut first_error = None;
        for blades in self.counts(&slices, wanted, cancel)? {
            // What is one pitch itself holds nothing twice.
            let is_one_pitch = (TAU / self.angle - blades.count as f64).abs() < 0.01;
            let is_told = wanted.is_some() || is_one_pitch;
            match self.with_blades(&blades, is_told, &exact, &slices, cancel) {
                Err(SectorError::Cancelled(cancelled)) => return Err(cancelled.into()),
                Err(error) => first_error = first_error.or(Some(error)),
                whole => return whole,
            }
        }
        Err(first_error.unwrap_or(SectorError::Pitch { angle_deg, axis }))
    }

    /// The wheel of so many blades, if the sector is one of it. Walls must repeat after one of the turns that are tried, unless
    /// the number `is_told` by something else.
    fn with_blades(
        &self,
        blades: &Blades,
        is_told: bool,
        exact: &ExactMesh,
        slices: &Slices,
        cancel: &Cancel,
    ) -> Result<Whole, SectorError> {
        /// Numbers of pitches that are tried, the greatest first, and places of each.
        const TRIED: usize = 4;
        const PLACES: [f64; 7] = [0.5, 0.25, 0.75, 0.1, 0.9, 0.4, 0.6];
        /// Share of the sector's walls that must repeat. Facets of rings repeat as well, but hardly face around the axis.
        const LEAST: f64 = 0.01;
        let (axis, angle_deg, Blades { count, cells, .. }) = (self.axis, self.angle.to_degrees(), blades);
        let pitch = TAU / *count as f64;
        // What is missing of a pitch leaves a gap at the rim, which must be within the cuts' own rounding.
        let reach = self.mesh.vertices.iter().map(|p| p.yz().length()).fold(f64::MIN_POSITIVE, f64::max);
        let slack = (self.on_cut / reach).min(SAME * pitch);
        let fits = |k: &usize| *k as f64 * pitch < self.angle + slack && *k as f64 * pitch < PI;
        let all = (1..=*count).rev().filter(|k| count.is_multiple_of(*k)).filter(fits);
        let is_bladed = |p: DVec3| slices.cell_at(p).is_some_and(|cell| cells.contains(&cell));
        let repeating = |kept: usize| (kept, self.repeating(exact, is_bladed, kept as f64 * pitch));
        let tried: Vec<(usize, Result<f64, SectorError>)> = all.take(TRIED).map(repeating).collect();
        let is_told = is_told || tried.iter().any(|(_, share)| share.as_ref().is_ok_and(|share| *share > LEAST));
        let mut first_error = None;
        for (kept, share) in tried {
            let told = if is_told { Ok(()) } else { Err(SectorError::Pitch { angle_deg, axis }) };
            if let Err(error) = share.and(told) {
                first_error = first_error.or(Some(error));
                continue;
            }
            let kept_angle = kept as f64 * pitch;
            let spare = (self.angle - kept_angle).max(0.0);
            // The whole of it where that is as many pitches; else wherever its ends meet no hole.
            let is_whole = spare < SAME * pitch;
            for place in if is_whole { &[0.0][..] } else { &PLACES } {
                cancel.check()?;
                let from = self.from + place * spare;
                match self.turned([from, from + kept_angle], count / kept) {
                    Ok((mesh, shift)) => {
                        let pitches_held = ((self.angle + SAME * pitch) / pitch) as usize;
                        let mesh = mesh.in_parent_of(&self.frame);
                        let theta = self.from + 0.5 * self.angle;
                        let middle = self.frame.direction_to_parent(Cylindrical { x: 0.0, r: 1.0, theta }.point());
                        let (blades, copies, angle, is_by_angle) =
                            (*count, count / kept, self.angle, blades.is_by_angle);
                        return Ok(Whole {
                            mesh,
                            axis,
                            blades,
                            copies,
                            middle,
                            pitches_held,
                            is_by_angle,
                            angle,
                            shift,
                        });
                    }
                    Err(error) => first_error = first_error.or(Some(error)),
                }
            }
        }
        let narrow = SectorError::Narrow { angle_deg, pitch_deg: pitch.to_degrees(), blades: *count, axis };
        Err(first_error.unwrap_or(narrow))
    }

    /// Share of the sector's walls that are met again after a turn by `angle`: of its surface, weighed by the square of the
    /// part of its normal that points around the axis.
    ///
    /// # Errors
    /// [`SectorError::Unlike`] where blades are not met again, as far as the turn stays in the sector.
    fn repeating(
        &self,
        exact: &ExactMesh,
        is_bladed: impl Fn(DVec3) -> bool + Sync,
        angle: f64,
    ) -> Result<f64, SectorError> {
        /// Triangles that are enough to tell.
        const ENOUGH: usize = 6000;
        /// Share of the surface that may be off: edges of holes and of the cuts.
        const LEAST: f64 = 0.01;
        struct Seen {
            off: f64,
            area: f64,
            around: f64,
            at: Cylindrical,
        }
        let turn = DMat3::from_rotation_x(angle);
        let middle = |corners: [DVec3; 3]| corners.into_iter().sum::<DVec3>() / 3.0;
        // What lies between the cuts, and is met between them again after the turn.
        let slack = 4.0 * SAME;
        let is_within = |p: DVec3, angle: f64| {
            let half = 0.5 * (self.angle - angle) - slack;
            wrap_angle(Cylindrical::from_point(p).theta - self.from - 0.5 * (self.angle - angle)).abs() < half
        };
        let around = |corners: [DVec3; 3]| {
            let theta = Cylindrical::from_point(middle(corners)).theta;
            let normal = cylindrical_components(normal_times_two_areas(corners), theta);
            normal.z.powi(2) / normal.length().max(f64::MIN_POSITIVE)
        };
        let step = (self.mesh.triangles.len() / ENOUGH) | 1;
        let looked_at: Vec<[DVec3; 3]> =
            self.mesh.iter_corners().step_by(step).filter(|c| is_within(middle(*c), 0.0)).collect();
        let walls: f64 = looked_at.iter().map(|corners| around(*corners)).sum();
        let seen = looked_at.into_par_iter().filter(|c| is_within(middle(*c), angle) && is_bladed(middle(*c)));
        let seen: Vec<Seen> = seen
            .map(|corners| {
                let p = middle(corners);
                Seen {
                    off: exact.signed_distance(turn * p).abs(),
                    area: normal_times_two_areas(corners).length(),
                    around: around(corners),
                    at: Cylindrical::from_point(p),
                }
            })
            .collect();
        let all: f64 = seen.iter().map(|seen| seen.area).sum();
        // Of two facets that differ each may be off by as much.
        let is_off = |seen: &&Seen| seen.off > 2.0 * self.joint;
        let odd: f64 = seen.iter().filter(is_off).map(|seen| seen.area).sum();
        if odd > LEAST * all
            && let Some(Seen { off, at, .. }) = seen.iter().max_by(|a, b| a.off.total_cmp(&b.off))
        {
            let (angle_deg, axis) = (angle.to_degrees(), self.axis);
            return Err(SectorError::Unlike { angle_deg, off_mm: *off, x: at.x, r: at.r, axis });
        }
        let again: f64 = seen.iter().filter(|seen| !is_off(seen)).map(|seen| seen.around).sum();
        Ok(again / walls.max(f64::MIN_POSITIVE))
    }

    /// The numbers of blades that the whole wheel may have, the likeliest first: those at whose pitch the most circles
    /// pass from solid to solid again; last that of its angle.
    fn counts(&self, slices: &Slices, wanted: Option<usize>, cancel: &Cancel) -> Result<Vec<Blades>, Cancelled> {
        /// Sum of weights that is enough to tell: a circle that meets walls head on counts 1, one that meets them aslant less.
        const ENOUGH: f64 = 3.0;
        /// Counts that are tried.
        const TRIED: usize = 4;
        /// Most blades.
        const MOST: usize = 300;
        let middle = self.from + 0.5 * self.angle;
        // Not the cuts themselves.
        let is_inside = |theta: &f64| theta.abs() < 0.5 * self.angle - SAME;
        // By how much a circle meets the wall head on: facets of rings are met aslant.
        let head_on = |c: &Crossing| cylindrical_components(slices.normal(c.triangle), c.theta).z.abs();
        let mut steps: Vec<([usize; 2], f64, f64)> = Vec::new();
        for ix in 0..CELLS[0] {
            cancel.check()?;
            for ir in 0..CELLS[1] {
                let at = slices.cell_middle(ix, ir);
                let crossings = slices.circle(at.x, at.y);
                for enters in [true, false] {
                    let met = crossings.iter().filter(|c| c.enters == enters);
                    let met = met.map(|c| (wrap_angle(c.theta - middle), head_on(c)));
                    let mut met: Vec<(f64, f64)> = met.filter(|(theta, _)| is_inside(theta)).collect();
                    met.sort_by(|a, b| a.0.total_cmp(&b.0));
                    let least = |met: &[(f64, f64)]| met.iter().map(|(_, head_on)| *head_on).fold(1.0, f64::min);
                    steps.extend(met.windows(2).map(|w| ([ix, ir], w[1].0 - w[0].0, least(w))));
                    // Splitters off the middle make every other pitch a smaller one.
                    steps.extend(met.windows(3).map(|w| ([ix, ir], 0.5 * (w[2].0 - w[0].0), 2.0 * least(w))));
                }
            }
        }
        let is_pitch = |step: f64, count: usize, within: f64| (step * count as f64 / TAU - 1.0).abs() < within;
        let mut of_cells: HashMap<[usize; 2], Vec<f64>> = HashMap::new();
        for (cell, step, _) in &steps {
            of_cells.entry(*cell).or_default().push(*step);
        }
        let bladed = |count: usize| {
            // Splitters stand off the middle by up to a third of the pitch.
            let is_near = |steps: &[f64]| steps.iter().any(|step| is_pitch(*step, count, 0.34));
            // Cells whose steps all tell one other number hold something else, as bolt holes, unless the number is given: it may
            // be wrong.
            let is_other = |steps: &[f64]| {
                let other = (TAU / (steps.iter().sum::<f64>() / steps.len() as f64)).round() as usize;
                other != count && steps.iter().all(|step| is_pitch(*step, other, 0.25 / other as f64))
            };
            let bladed = of_cells.iter().filter(|(_, steps)| is_near(steps) && (wanted.is_some() || !is_other(steps)));
            Blades { count, cells: bladed.map(|(cell, _)| *cell).collect(), is_by_angle: false }
        };
        if let Some(count) = wanted {
            return Ok(vec![bladed(count)]);
        }
        let mut votes = vec![0.0; MOST + 1];
        for (_, step, weight) in &steps {
            let count = (TAU / step).round();
            if (3.0..=MOST as f64).contains(&count) && is_pitch(*step, count as usize, 0.25 / count) {
                votes[count as usize] += weight;
            }
        }
        let mut counts: Vec<usize> = (3..=MOST).filter(|n| votes[*n] >= ENOUGH).collect();
        counts.sort_by(|a, b| votes[*b].total_cmp(&votes[*a]).then(a.cmp(b)));
        counts.truncate(TRIED);
        // Where no pitch that is counted repeats, the sector may be one itself: it holds no two blades that are alike.
        let by_cuts = TAU / self.angle;
        let by_angle = by_cuts.round() as usize;
        let is_new = by_angle >= 3 && !counts.contains(&by_angle);
        let added = is_new && (by_cuts - by_cuts.round()).abs() < 0.01;
        let added = added.then(|| Blades { is_by_angle: true, ..bladed(by_angle) });
        Ok(counts.into_iter().map(bladed).chain(added).collect())
    }

    /// `copies` of what lies between two angles (rad), turned about X and joined, and how far points were moved for that
    /// (mm).
    fn turned(&self, ends: [f64; 2], copies: usize) -> Result<(Mesh, f64), SectorError> {
        let angle = ends[1] - ends[0];
        let around = |theta: f64| DVec3::new(0.0, -theta.cos(), -theta.sin());
        let lower = clipped(&self.mesh, around(ends[0]), self.on_cut);
        let mut slab = clipped(&lower, -around(ends[1]), self.on_cut);
        let triangles = slab.triangles.len().saturating_mul(copies);
        if triangles > MOST_TRIANGLES {
            return Err(SectorError::TooLarge { triangles });
        }
        let (partners, shift) = join(&mut slab, ends, self.on_cut, self.joint).map_err(|(off_mm, at)| {
            SectorError::Unlike { angle_deg: angle.to_degrees(), off_mm, x: at.x, r: at.y, axis: self.axis }
        })?;
        let mut whole = Mesh::default();
        // On the axis there is one vertex for all copies; those of the upper end are those of the next copy's lower.
        let on_axis = |v: usize| slab.vertices[v].yz().length() <= self.on_cut;
        let own: Vec<usize> =
            (0..slab.vertices.len()).filter(|v| !on_axis(*v) && !partners.contains_key(&(*v as u32))).collect();
        let shared: Vec<usize> = (0..slab.vertices.len()).filter(|v| on_axis(*v)).collect();
        let mut number = vec![0u32; slab.vertices.len()];
        own.iter().enumerate().for_each(|(i, v)| number[*v] = (shared.len() + i) as u32);
        shared.iter().enumerate().for_each(|(i, v)| number[*v] = i as u32);
        whole.vertices.extend(shared.iter().map(|v| slab.vertices[*v]));
        for copy in 0..copies {
            let turn = DMat3::from_rotation_x(copy as f64 * angle);
            whole.vertices.extend(own.iter().map(|v| turn * slab.vertices[*v]));
            let of = |v: u32, copy: usize| {
                if on_axis(v as usize) {
                    number[v as usize]
                } else {
                    number[v as usize] + (copy % copies * own.len()) as u32
                }
            };
            let vertex = |v: u32| partners.get(&v).map_or_else(|| of(v, copy), |p| of(*p, copy + 1));
            whole.triangles.extend(slab.triangles.iter().map(|t| t.map(vertex)));
        }
        whole.triangles.retain(|[a, b, c]| a != b && b != c && c != a);
        if !whole.is_watertight() {
            return Err(SectorError::Open { angle_deg: angle.to_degrees(), axis: self.axis });
        }
        Ok((whole, shift))
    }
}
