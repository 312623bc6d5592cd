//! The whole wheel from a sector of it that two planes through the axis cut out.
//!
//! As many whole pitches as fit into the sector, and into a full turn without rest, are kept of it and turned about the
//! axis. The two ends of what is kept are sections of surfaces that repeat, so that they are congruent but for the
//! chord error of the mesh: they are joined point by point, and where that does not close the surface there is no wheel.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::f64::consts::{PI, TAU};

use glam::{DMat3, DVec2, DVec3, Vec3Swizzles as _};
use rayon::prelude::*;

use super::axis::{self, Axis, Turning};
use super::frame_along;
use super::slices::{CELLS, Slices};
use crate::options::{AxisChoice, AxisLine, AxisName, BliskOptions};
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
/// Most vertices of the outlines of an end: more than any sector has, and few enough to be compared.
const MOST_OUTLINE: usize = 20_000;
/// Angles that are the same (rad).
const SAME: f64 = 1e-3;

/// A wheel that was made of a sector.
pub(super) struct Whole {
    /// The wheel, in the coordinates of the sector's mesh.
    pub mesh: Mesh,
    /// Its axis.
    pub axis: Axis,
    /// Its number of blades.
    pub blades: usize,
    /// Unit vector from the axis to the middle of the sector.
    pub middle: DVec3,
    /// Whole pitches that the sector holds.
    pub seen: usize,
    /// What was assumed, in a sentence.
    pub assumed: String,
}

/// Reason why a mesh that two planes cut out of something is not taken for a sector of a wheel.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SectorError {
    /// Cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// Its blades are too few to tell their pitch.
    #[error(
        "the mesh is a sector of {angle_deg:.2} deg about the axis {axis}, which does not divide a full turn, and it holds \
         too few blades to tell their pitch: give the number of blades of the whole wheel with blisk.blades, or load a \
         larger sector"
    )]
    Pitch {
        /// Angle between the cuts (deg).
        angle_deg: f64,
        /// The axis.
        axis: Axis,
    },
    /// Not one whole pitch.
    #[error(
        "the mesh is a sector of {angle_deg:.2} deg about the axis {axis}, less than the {pitch_deg:.2} deg from blade to \
         blade of a wheel with {blades} blades: load a sector of one pitch at least"
    )]
    Narrow {
        /// Angle between the cuts (deg).
        angle_deg: f64,
        /// Angle from blade to blade (deg).
        pitch_deg: f64,
        /// Number of blades.
        blades: usize,
        /// The axis.
        axis: Axis,
    },
    /// The ends do not fit each other.
    #[error(
        "the mesh is a sector about the axis {axis}, but what lies {angle_deg:.2} deg apart in it is not congruent: at \
         x {x:.3}, r {r:.3} mm about the axis it is {off_mm:.3} mm off; check the axis and the number of blades, or load \
         the whole wheel"
    )]
    Unlike {
        /// Angle between the two ends (deg).
        angle_deg: f64,
        /// Distance (mm).
        off_mm: f64,
        /// Where (mm along the axis).
        x: f64,
        /// Where (mm from the axis).
        r: f64,
        /// The axis.
        axis: Axis,
    },
    /// Its blades differ, and it cannot be told whether they repeat.
    #[error(
        "the mesh is a sector about the axis {axis}, and the blades of its {seen} pitches are not alike: {kinds} kinds \
         can only be told to repeat in a sector of {} pitches; load a larger sector or the whole wheel",
        2 * .kinds
    )]
    Kinds {
        /// Kinds of blades.
        kinds: usize,
        /// Pitches that were looked at.
        seen: usize,
        /// The axis.
        axis: Axis,
    },
    /// The whole wheel would be too large.
    #[error(
        "the whole wheel of this sector would have {triangles} triangles, more than {MOST_TRIANGLES}: load a coarser mesh"
    )]
    TooLarge {
        /// Triangles of the whole wheel.
        triangles: usize,
    },
    /// Its mesh cannot be searched.
    #[error("{0}")]
    Mesh(String),
    /// The ends fit, but joined they do not close the surface.
    #[error(
        "the mesh is a sector of {angle_deg:.2} deg about the axis {axis}, but its turned copies do not close to a wheel: \
         edges remain that one triangle meets; load the whole wheel"
    )]
    Open {
        /// Angle between the two ends (deg).
        angle_deg: f64,
        /// The axis.
        axis: Axis,
    },
}

impl SectorError {
    /// The axis of the sector.
    pub(crate) fn axis(&self) -> Option<Axis> {
        match self {
            Self::Pitch { axis, .. }
            | Self::Narrow { axis, .. }
            | Self::Unlike { axis, .. }
            | Self::Kinds { axis, .. }
            | Self::Open { axis, .. } => Some(*axis),
            Self::Cancelled(_) | Self::Mesh(_) | Self::TooLarge { .. } => None,
        }
    }
}

/// The wheel that `mesh`, oriented outwards, is a sector of; none if no two planes cut it out about an axis that
/// `options` allow.
///
/// # Errors
/// [`SectorError`], of the likeliest axis.
pub(super) fn whole_wheel(mesh: &Mesh, options: &BliskOptions, cancel: &Cancel) -> Result<Option<Whole>, SectorError> {
    let mut first_error = None;
    for sector in sectors(mesh, options) {
        match sector.whole(options.blades.given(), cancel) {
            Err(SectorError::Cancelled(cancelled)) => return Err(cancelled.into()),
            Err(error) => first_error = first_error.or(Some(error)),
            found => return found.map(Some),
        }
    }
    first_error.map_or(Ok(None), Err)
}

/// A plane that all of a mesh lies on one side of.
struct Cut {
    /// Unit normal, away from the mesh.
    normal: DVec3,
    /// Distance from the origin along the normal (mm).
    at: f64,
    /// Area of the mesh in it (mm^2).
    area: f64,
}

/// Planes that the mesh lies on one side of, and with a part of its surface in, the largest part first.
fn cuts(mesh: &Mesh, on_cut: f64) -> Vec<Cut> {
    /// Directions that are looked at, those of most area.
    const MOST: usize = 200;
    /// Normals in one of these steps are one direction.
    const STEP: f64 = 1e-3;
    /// Least share of the surface.
    const LEAST: f64 = 1e-3;
    let mut directions: HashMap<[i32; 3], DVec3> = HashMap::new();
    let mut whole = 0.0;
    for corners in mesh.iter_corners() {
        let normal = normal_times_two_areas(corners);
        whole += 0.5 * normal.length();
        let key = (normal.normalize_or_zero() / STEP).round().as_ivec3().to_array();
        *directions.entry(key).or_default() += normal;
    }
    let mut directions: Vec<([i32; 3], DVec3)> = directions.into_iter().collect();
    directions.sort_by(|(i, a), (j, b)| b.length_squared().total_cmp(&a.length_squared()).then(i.cmp(j)));
    directions.truncate(MOST);
    let cut = |(_, direction): &([i32; 3], DVec3)| {
        let normal = direction.normalize_or_zero();
        let furthest = |normal: DVec3| mesh.vertices.iter().map(|p| normal.dot(*p)).fold(f64::NEG_INFINITY, f64::max);
        let (mut cut, near) = (Cut { normal, at: furthest(normal), area: 0.0 }, 50.0 * on_cut);
        // Once more with the normal of all that lies near and looks that way: a step holds some triangles of a cut.
        for within in [near, on_cut] {
            let looks = |normal: DVec3| normal.dot(cut.normal) > (1.0 - 2.0 * STEP * STEP) * normal.length();
            let lies = |t: &[DVec3; 3]| t.iter().all(|p| cut.at - cut.normal.dot(*p) <= within);
            let normals = mesh.iter_corners().filter(lies).map(normal_times_two_areas);
            let sum: DVec3 = normals.filter(|normal| looks(*normal)).sum();
            let normal = sum.normalize_or_zero();
            cut = Cut { normal, at: furthest(normal), area: 0.5 * sum.length() };
        }
        cut
    };
    let cuts: Vec<Cut> = directions.par_iter().map(cut).filter(|cut| cut.area > LEAST * whole).collect();
    let mut found: Vec<Cut> = Vec::new();
    for cut in cuts {
        if !found.iter().any(|known: &Cut| known.normal.dot(cut.normal) > 1.0 - STEP * STEP) {
            found.push(cut);
        }
    }
    found.sort_by(|a, b| b.area.total_cmp(&a.area));
    found
}

/// Blades of the whole wheel.
struct Blades {
    count: usize,
    /// Cells of the slices in which they follow each other.
    cells: HashSet<[usize; 2]>,
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
}

/// What `mesh` may be as a sector, the likeliest first: about the line of two cuts that its surfaces turn about most.
fn sectors<'a>(mesh: &'a Mesh, options: &BliskOptions) -> impl Iterator<Item = Sector> + use<'a> {
    /// Cuts at a smaller angle meet nowhere that can be told.
    const LEAST_ANGLE: f64 = 0.01;
    /// Hub, shroud and rims turn about the axis: at least this share of the surface, and this part of what turns about
    /// any other line.
    const LEAST_TURNING: f64 = 0.02;
    const LEAST_PART: f64 = 0.5;
    /// Lines that are tried.
    const MOST: usize = 4;
    let size = mesh.bounds().size().length();
    let on_cut = ON_CUT * size;
    let (cuts, turning) = (cuts(mesh, on_cut), Turning::new(mesh));
    let mut axes: Vec<(f64, Axis, [DVec3; 2])> = Vec::new();
    for (i, a) in cuts.iter().enumerate() {
        for b in &cuts[..i] {
            let along = a.normal.cross(b.normal);
            if along.length() < LEAST_ANGLE {
                continue;
            }
            let point = (b.normal.cross(along) * a.at + along.cross(a.normal) * b.at) / along.length_squared();
            let axis = Axis::new(point, along).snapped(size);
            let share = turning.share(&axis);
            let allowed = allowed(axis, options, on_cut, size).filter(|_| share > LEAST_TURNING);
            axes.extend(allowed.map(|axis| (share, axis, [a.normal, b.normal])));
        }
    }
    axes.sort_by(|a, b| b.0.total_cmp(&a.0));
    // Flats of a whole wheel meet in lines that little turns about.
    let best = axis::candidates(mesh, None).iter().map(|axis| turning.share(axis)).fold(0.0, f64::max);
    axes.retain(|(share, ..)| *share >= LEAST_PART * best);
    axes.truncate(MOST);
    let sector = move |(_, axis, normals): (f64, Axis, [DVec3; 2])| {
        let frame = frame_along(&axis);
        let [a, b] = normals.map(|n| frame.direction_from_parent(n));
        // Out of the upper cut in the sense of theta, out of the lower one against it.
        let (upper, lower) = (|n: DVec3| (-n.z).atan2(-n.y), |n: DVec3| n.z.atan2(n.y));
        let between = |low: DVec3, high: DVec3| (upper(high) - lower(low)).rem_euclid(TAU);
        let (low, high) = if between(a, b) < PI { (a, b) } else { (b, a) };
        let (from, angle) = (lower(low), between(low, high));
        let mesh = mesh.in_frame(&frame);
        let joint = (JOINT * size).max(chord_error(&mesh).min(MOST_JOINT * size));
        Sector { mesh, frame, axis, from, angle, on_cut, joint }
    };
    axes.into_iter().map(sector).filter(|sector| sector.angle < PI)
}

/// Greatest height of an arc about X over the edge that stands for it, on surfaces of revolution (mm).
fn chord_error(mesh: &Mesh) -> f64 {
    /// Ends of such an edge have the same radius and x to this share.
    const LEVEL: f64 = 1e-3;
    /// Such a surface faces along the radius by this much, and around the axis by no more than this.
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

/// The axis in which two cuts meet, if `options` allow it; a line that is given instead, if the cuts meet in it.
fn allowed(axis: Axis, options: &BliskOptions, on_cut: f64, size: f64) -> Option<Axis> {
    let along = |direction: DVec3, within: f64| axis.direction.cross(direction.normalize_or_zero()).length() < within;
    let is_along = |direction: DVec3| along(direction, SAME).then_some(axis);
    match options.axis {
        AxisChoice::Named(AxisName::Auto) => Some(axis),
        AxisChoice::Named(AxisName::X) => is_along(DVec3::X),
        AxisChoice::Named(AxisName::Y) => is_along(DVec3::Y),
        AxisChoice::Named(AxisName::Z) => is_along(DVec3::Z),
        AxisChoice::Line(AxisLine { direction, point }) => {
            let (direction, point) = (DVec3::from(direction), DVec3::from(point));
            let off = axis.direction.cross(point - axis.point).length();
            (along(direction, 4.0 * on_cut / size) && off < 4.0 * on_cut).then(|| Axis::new(point, direction))
        }
    }
}

impl Sector {
    fn whole(&self, wanted: Option<usize>, cancel: &Cancel) -> Result<Whole, SectorError> {
        let (axis, angle_deg) = (self.axis, self.angle.to_degrees());
        let slices = Slices::new(self.mesh.clone());
        let exact = ExactMesh::new(&self.mesh).map_err(|e| SectorError::Mesh(e.to_string()))?;
        let mut first_error = None;
        for blades in self.counts(&slices, wanted, cancel)? {
            match self.with_blades(&blades, &exact, &slices, cancel) {
                Err(SectorError::Cancelled(cancelled)) => return Err(cancelled.into()),
                Err(error) => first_error = first_error.or(Some(error)),
                whole => return whole,
            }
        }
        Err(first_error.unwrap_or(SectorError::Pitch { angle_deg, axis }))
    }

    /// The wheel of so many blades, if the sector is one of it.
    fn with_blades(
        &self,
        blades: &Blades,
        exact: &ExactMesh,
        slices: &Slices,
        cancel: &Cancel,
    ) -> Result<Whole, SectorError> {
        /// Numbers of pitches that are tried, the greatest first, and places of each.
        const TRIED: usize = 4;
        const PLACES: [f64; 7] = [0.5, 0.25, 0.75, 0.1, 0.9, 0.4, 0.6];
        let (axis, angle_deg, Blades { count, cells }) = (self.axis, self.angle.to_degrees(), blades);
        let pitch = TAU / *count as f64;
        let fits = |k: &usize| *k as f64 * pitch < self.angle + SAME * pitch && *k as f64 * pitch < PI;
        let all = (1..=*count).rev().filter(|k| count.is_multiple_of(*k)).filter(fits);
        let is_bladed = |p: DVec3| slices.cell_at(p).is_some_and(|cell| cells.contains(&cell));
        let mut first_error = None;
        for kept in all.take(TRIED) {
            let kept_angle = kept as f64 * pitch;
            let spare = (self.angle - kept_angle).max(0.0);
            if let Some(unlike) = self.unlike(exact, is_bladed, kept_angle) {
                first_error = first_error.or(Some(unlike));
                continue;
            }
            // The whole of it where that is as many pitches; else wherever its ends meet no hole.
            let is_whole = spare < SAME * pitch;
            for place in if is_whole { &[0.0][..] } else { &PLACES } {
                cancel.check()?;
                let from = self.from + place * spare;
                match self.turned([from, from + kept_angle], count / kept) {
                    Ok((mesh, shift)) => {
                        let (seen, assumed) =
                            (((self.angle + SAME * pitch) / pitch) as usize, self.assumed(kept, *count, shift));
                        let mesh = mesh.in_parent_of(&self.frame);
                        let theta = self.from + 0.5 * self.angle;
                        let middle = self.frame.direction_to_parent(Cylindrical { x: 0.0, r: 1.0, theta }.point());
                        return Ok(Whole { mesh, axis, blades: *count, middle, seen, assumed });
                    }
                    Err(error) => first_error = first_error.or(Some(error)),
                }
            }
        }
        let narrow = SectorError::Narrow { angle_deg, pitch_deg: pitch.to_degrees(), blades: *count, axis };
        Err(first_error.unwrap_or(narrow))
    }

    fn assumed(&self, kept: usize, blades: usize, shift: f64) -> String {
        format!(
            "The mesh is a sector of {:.3} deg. Its cuts meet in the axis {}; {kept} of its pitches were turned about it \
             into the {} sectors of the whole wheel of {blades} blades, whose ends were moved by up to {shift:.4} mm to \
             meet. What does not repeat with the blades, as bolt holes, is not where it is on the part.",
            self.angle.to_degrees(),
            self.axis,
            blades / kept
        )
    }

    /// Why the blades do not repeat after a turn by `angle`, as far as that stays in the sector; none if they do.
    fn unlike(&self, exact: &ExactMesh, is_bladed: impl Fn(DVec3) -> bool + Sync, angle: f64) -> Option<SectorError> {
        /// Triangles that are enough to tell.
        const ENOUGH: usize = 6000;
        /// Share of the surface that may be off: edges of holes and of the cuts.
        const LEAST: f64 = 0.01;
        let turn = DMat3::from_rotation_x(angle);
        let [from, to] = [self.from, self.from + self.angle - angle];
        let slack = 4.0 * SAME;
        let is_inside = |p: DVec3| {
            let theta = wrap_angle(Cylindrical::from_point(p).theta - 0.5 * (from + to));
            to - from > 2.0 * slack && theta.abs() < 0.5 * (to - from) - slack
        };
        let step = (self.mesh.triangles.len() / ENOUGH) | 1;
        let middle = |corners: [DVec3; 3]| corners.into_iter().sum::<DVec3>() / 3.0;
        let looked_at: Vec<[DVec3; 3]> = self.mesh.iter_corners().step_by(step).collect();
        let seen = looked_at.into_par_iter().filter(|c| is_inside(middle(*c)) && is_bladed(middle(*c)));
        let off = |corners: [DVec3; 3]| {
            let p = middle(corners);
            (exact.signed_distance(turn * p).abs(), normal_times_two_areas(corners).length(), p)
        };
        let seen: Vec<(f64, f64, DVec3)> = seen.map(off).collect();
        let all: f64 = seen.iter().map(|(_, area, _)| area).sum();
        let odd: f64 = seen.iter().filter(|(off, ..)| *off > self.joint).map(|(_, area, _)| area).sum();
        let (off_mm, _, at) = seen.into_iter().max_by(|a, b| a.0.total_cmp(&b.0)).filter(|_| odd > LEAST * all)?;
        let Cylindrical { x, r, .. } = Cylindrical::from_point(at);
        Some(SectorError::Unlike { angle_deg: angle.to_degrees(), off_mm, x, r, axis: self.axis })
    }

    /// The numbers of blades that the whole wheel may have, the likeliest first: those at whose pitch the most circles
    /// pass from solid to solid again. That of its angle, if it holds no two blades.
    fn counts(&self, slices: &Slices, wanted: Option<usize>, cancel: &Cancel) -> Result<Vec<Blades>, Cancelled> {
        /// Circles that are enough to tell.
        const ENOUGH: usize = 20;
        /// Counts that are tried.
        const TRIED: usize = 4;
        /// Most blades.
        const MOST: usize = 300;
        let middle = self.from + 0.5 * self.angle;
        // Not the cuts themselves.
        let is_inside = |theta: &f64| theta.abs() < 0.5 * self.angle - SAME;
        let mut steps: Vec<([usize; 2], f64, usize)> = Vec::new();
        for ix in 0..CELLS[0] {
            cancel.check()?;
            for ir in 0..CELLS[1] {
                let at = slices.cell_middle(ix, ir);
                let crossings = slices.circle(at.x, at.y);
                for enters in [true, false] {
                    let thetas = crossings.iter().filter(|c| c.enters == enters).map(|c| wrap_angle(c.theta - middle));
                    let mut thetas: Vec<f64> = thetas.filter(is_inside).collect();
                    thetas.sort_by(f64::total_cmp);
                    steps.extend(thetas.windows(2).map(|w| ([ix, ir], w[1] - w[0], 1)));
                    // Splitters off the middle make every other pitch a smaller one.
                    steps.extend(thetas.windows(3).map(|w| ([ix, ir], 0.5 * (w[2] - w[0]), 2)));
                }
            }
        }
        let is_pitch = |step: f64, count: usize, within: f64| (step * count as f64 / TAU - 1.0).abs() < within;
        let bladed = |count: usize| {
            // Those off the middle by up to a third of the pitch.
            let near = steps.iter().filter(|(_, step, _)| is_pitch(*step, count, 0.34));
            Blades { count, cells: near.map(|(cell, ..)| *cell).collect() }
        };
        if let Some(count) = wanted {
            return Ok(vec![bladed(count)]);
        }
        let mut votes = vec![0; MOST + 1];
        for (_, step, weight) in &steps {
            let count = (TAU / step).round();
            if (3.0..=MOST as f64).contains(&count) && is_pitch(*step, count as usize, 0.25 / count) {
                votes[count as usize] += weight;
            }
        }
        let mut counts: Vec<usize> = (3..=MOST).filter(|n| votes[*n] >= ENOUGH).collect();
        counts.sort_by_key(|n| (std::cmp::Reverse(votes[*n]), *n));
        counts.truncate(TRIED);
        let by_cuts = TAU / self.angle;
        if counts.is_empty() && (by_cuts - by_cuts.round()).abs() < 0.01 {
            counts.push(by_cuts.round() as usize);
        }
        Ok(counts.into_iter().filter(|n| *n >= 3).map(bladed).collect())
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

/// The part of `mesh` on the side of the plane through the origin that `inward` points to, without what lies in the
/// plane. Vertices within `on_cut` of the plane are moved into it.
fn clipped(mesh: &Mesh, inward: DVec3, on_cut: f64) -> Mesh {
    let height: Vec<f64> = mesh.vertices.iter().map(|p| inward.dot(*p)).collect();
    let height: Vec<f64> = height.into_iter().map(|h| if h.abs() <= on_cut { 0.0 } else { h }).collect();
    let moved = |(p, h): (&DVec3, &f64)| if *h == 0.0 { *p - inward * inward.dot(*p) } else { *p };
    let mut vertices: Vec<DVec3> = mesh.vertices.iter().zip(&height).map(moved).collect();
    let mut between: HashMap<[u32; 2], u32> = HashMap::new();
    let mut triangles = Vec::new();
    for t in &mesh.triangles {
        let heights = t.map(|v| height[v as usize]);
        if heights.iter().all(|h| *h <= 0.0) {
            continue;
        }
        let mut corners: Vec<u32> = Vec::with_capacity(4);
        for i in 0..3 {
            let (a, b) = (t[i], t[(i + 1) % 3]);
            let (above, below) = (heights[i], heights[(i + 1) % 3]);
            if above >= 0.0 {
                corners.push(a);
            }
            if above * below < 0.0 {
                let edge = [a.min(b), a.max(b)];
                let cut = *between.entry(edge).or_insert_with(|| {
                    let [p, q] = edge.map(|v| (vertices[v as usize], height[v as usize]));
                    vertices.push(p.0.lerp(q.0, p.1 / (p.1 - q.1)));
                    vertices.len() as u32 - 1
                });
                corners.push(cut);
            }
        }
        triangles.extend((2..corners.len()).map(|i| [corners[0], corners[i - 1], corners[i]]));
    }
    compact(Mesh { vertices, triangles })
}

/// The mesh without vertices that no triangle has.
fn compact(mesh: Mesh) -> Mesh {
    let mut number = vec![u32::MAX; mesh.vertices.len()];
    let mut vertices = Vec::new();
    let mut triangles = mesh.triangles;
    for v in triangles.iter_mut().flatten() {
        if number[*v as usize] == u32::MAX {
            number[*v as usize] = vertices.len() as u32;
            vertices.push(mesh.vertices[*v as usize]);
        }
        *v = number[*v as usize];
    }
    Mesh { vertices, triangles }
}

/// A closed line of open edges in a half-plane, as the triangles of the lower end have them: that of the upper end is
/// turned round.
struct Outline {
    vertices: Vec<u32>,
    /// Their places in the half-plane: along the axis and away from it.
    places: Vec<DVec2>,
}

impl Outline {
    /// Place and length of the way (mm) from vertex `from` over `steps` edges, for each vertex on it.
    fn way(&self, from: usize, steps: usize) -> Vec<(usize, DVec2, f64)> {
        let n = self.places.len();
        let (mut way, mut length) = (Vec::with_capacity(steps + 1), 0.0);
        for step in 0..=steps {
            let (i, last) = ((from + step) % n, (from + step + n - 1) % n);
            length += if step > 0 { self.places[i].distance(self.places[last]) } else { 0.0 };
            way.push((i, self.places[i], length));
        }
        way
    }
}

/// Reason why two ends are not joined: how far a place of the one is from the other (mm), and the place.
type Apart = (f64, DVec2);

/// Joins the outlines of the slab at its two ends: answers for each vertex of the upper end the one of the lower that
/// takes its place, and how far they are moved for that (mm). Vertices that are near each other are one; the others are
/// put into the edges of the other end.
///
/// # Errors
/// [`Apart`].
fn join(slab: &mut Mesh, ends: [f64; 2], on_cut: f64, joint: f64) -> Result<(HashMap<u32, u32>, f64), Apart> {
    let angle = ends[1] - ends[0];
    let [lower, upper] = [outlines(slab, ends[0], on_cut, false)?, outlines(slab, ends[1], on_cut, true)?];
    let points = |outlines: &[Outline]| -> Vec<(usize, usize, DVec2)> {
        let of = |(k, outline): (usize, &Outline)| -> Vec<(usize, usize, DVec2)> {
            outline.places.iter().enumerate().map(|(i, p)| (k, i, *p)).collect()
        };
        outlines.iter().enumerate().flat_map(of).collect()
    };
    let (of_lower, of_upper) = (points(&lower), points(&upper));
    let nearest = |points: &[(usize, usize, DVec2)], p: DVec2| {
        let off = points.iter().map(|(k, i, q)| (q.distance_squared(p), *k, *i));
        off.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(off, k, i)| (off.sqrt(), k, i))
    };
    let mut partners = HashMap::new();
    let mut put: HashMap<[u32; 2], Vec<(f64, u32)>> = HashMap::new();
    let mut joined = HashSet::new();
    let mut shift: f64 = 0.0;
    if of_lower.len().max(of_upper.len()) > MOST_OUTLINE {
        return Err((f64::INFINITY, of_lower.first().map_or(DVec2::ZERO, |(.., p)| *p)));
    }
    for (k, outline) in lower.iter().enumerate() {
        // Each other's nearest.
        let mutual = |(i, p): (usize, &DVec2)| {
            let (off, other, j) = nearest(&of_upper, *p)?;
            let (_, back, own) = nearest(&of_lower, upper[other].places[j])?;
            (off <= joint && (back, own) == (k, i)).then_some((i, other, j))
        };
        let anchors: Vec<(usize, usize, usize)> = outline.places.iter().enumerate().filter_map(mutual).collect();
        let apart = || {
            let off = outline.places.iter().filter_map(|p| Some((nearest(&of_upper, *p)?.0, *p)));
            off.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::INFINITY, DVec2::ZERO))
        };
        let Some(&(first, other, start)) = anchors.first() else { return Err(apart()) };
        let (upper, n) = (&upper[other], upper[other].places.len());
        if !joined.insert(other) {
            return Err(apart());
        }
        let ahead = anchors.iter().filter(|a| a.1 == other).map(|(i, _, j)| (i - first, (j + n - start) % n));
        let mut anchors = rising(&ahead.collect::<Vec<_>>());
        anchors.push((outline.places.len(), n));
        for pair in anchors.windows(2) {
            let ((i, j), (to_i, to_j)) = (pair[0], pair[1]);
            let (v, w) = ((start + j) % n, (first + i) % outline.places.len());
            partners.insert(upper.vertices[v], outline.vertices[w]);
            shift = shift.max(upper.places[v].distance(outline.places[w]));
            let ways = [outline.way(first + i, to_i - i), upper.way(start + j, to_j - j)];
            let [own, theirs] = &ways;
            for (v, p, share, edge) in between(theirs, own) {
                let at = slab.vertices.len() as u32;
                let [from, to] = edge.map(|e| outline.vertices[e]);
                let [a, b] = [from, to].map(|v| slab.vertices[v as usize]);
                let new = a.lerp(b, share.1);
                let off = DVec2::new(new.x, new.yz().length()).distance(p);
                if off > 2.0 * joint {
                    return Err((off, p));
                }
                shift = shift.max(off);
                slab.vertices.push(new);
                put.entry([from, to]).or_default().push((share.0, at));
                partners.insert(upper.vertices[v], at);
            }
            for (v, p, share, edge) in between(own, theirs) {
                let at = slab.vertices.len() as u32;
                // The other way round again.
                let [to, from] = edge.map(|e| upper.vertices[e]);
                let off = upper.places[edge[0]].lerp(upper.places[edge[1]], share.1).distance(p);
                if off > 2.0 * joint {
                    return Err((off, p));
                }
                shift = shift.max(off);
                let own = outline.vertices[v];
                slab.vertices.push(DMat3::from_rotation_x(angle) * slab.vertices[own as usize]);
                put.entry([from, to]).or_default().push((-share.0, at));
                partners.insert(at, own);
            }
        }
    }
    if let Some((k, _)) = upper.iter().enumerate().find(|(k, _)| !joined.contains(k)) {
        let p = upper[k].places[0];
        return Err((nearest(&of_lower, p).map_or(f64::INFINITY, |(off, ..)| off), p));
    }
    split_edges(slab, put);
    Ok((partners, shift))
}

/// The greatest part of `pairs`, which rise in the first number, that rises in the second as well; it holds the first.
fn rising(pairs: &[(usize, usize)]) -> Vec<(usize, usize)> {
    let mut best: Vec<(usize, Option<usize>)> = Vec::new();
    for (i, (_, j)) in pairs.iter().enumerate() {
        let before = (0..i).filter(|k| pairs[*k].1 < *j && best[*k].0 > 0).max_by_key(|k| (best[*k].0, *k));
        // Whatever does not come after the first is nothing.
        best.push(match before {
            None if i > 0 => (0, None),
            before => (before.map_or(0, |k| best[k].0) + 1, before),
        });
    }
    let mut at = (0..best.len()).max_by_key(|i| best[*i].0);
    let mut found = Vec::new();
    while let Some(i) = at {
        found.push(pairs[i]);
        at = best[i].1;
    }
    found.reverse();
    found
}

/// The vertices of a way between its ends, each with its place, the edge of `other` in which as large a share of that way
/// lies behind it, that share, and the share of the edge.
type Between = (usize, DVec2, (f64, f64), [usize; 2]);

fn between(way: &[(usize, DVec2, f64)], other: &[(usize, DVec2, f64)]) -> Vec<Between> {
    let [length, others] = [way, other].map(|way| way.last().map_or(0.0, |end| end.2).max(f64::MIN_POSITIVE));
    let inner = way.iter().skip(1).take(way.len().saturating_sub(2));
    let find = |(v, p, at): &(usize, DVec2, f64)| {
        let share = at / length;
        let edge = other.windows(2).find(|edge| edge[1].2 >= share * others).or(other.windows(2).last())?;
        let [from, to] = [edge[0].2, edge[1].2];
        let within = ((share * others - from) / (to - from).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        Some((*v, *p, (share, within), [edge[0].0, edge[1].0]))
    };
    inner.filter_map(find).collect()
}

/// The closed lines of open edges of the slab in the half-plane at `theta` (rad), turned round if `is_upper`; `on_cut`
/// as in [`Sector`].
///
/// # Errors
/// [`Apart`], where such edges are no closed lines.
fn outlines(slab: &Mesh, theta: f64, on_cut: f64, is_upper: bool) -> Result<Vec<Outline>, Apart> {
    let around = DVec3::new(0.0, -theta.cos(), -theta.sin());
    let lies = |v: u32| around.dot(slab.vertices[v as usize]).abs() <= on_cut;
    let place = |v: u32| {
        let p = slab.vertices[v as usize];
        DVec2::new(p.x, p.yz().length())
    };
    let all = slab.directed_edges();
    let (mut next, mut reached) = (BTreeMap::new(), HashSet::new());
    let sides = slab.triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
    for (a, b) in sides.filter(|(a, b)| !all.contains_key(&(*b, *a)) && lies(*a) && lies(*b)) {
        let (from, to) = if is_upper { (b, a) } else { (a, b) };
        if next.insert(from, to).is_some() {
            return Err((0.0, place(from)));
        }
        reached.insert(to);
    }
    let mut found = Vec::new();
    // The outline of a sector without a bore begins and ends on the axis, where nothing is left of its edge.
    let begins: Vec<u32> = next.keys().filter(|v| !reached.contains(v)).copied().collect();
    let mut begins = begins.into_iter();
    while let Some(start) = begins.next().or_else(|| next.first_key_value().map(|(v, _)| *v)) {
        let (mut vertices, mut at) = (Vec::new(), start);
        while let Some(to) = next.remove(&at) {
            vertices.push(at);
            at = to;
        }
        if at != start {
            if [start, at].iter().any(|v| place(*v).y > on_cut) {
                return Err((f64::INFINITY, place(at)));
            }
            vertices.push(at);
        }
        let places = vertices.iter().map(|v| place(*v)).collect();
        found.push(Outline { vertices, places });
    }
    Ok(found)
}

/// Puts vertices into open edges, each with its order along its edge.
fn split_edges(slab: &mut Mesh, mut put: HashMap<[u32; 2], Vec<(f64, u32)>>) {
    let mut i = 0;
    // What is added is looked at as well: a triangle may have two such edges.
    while i < slab.triangles.len() {
        let t = slab.triangles[i];
        let side = (0..3).find_map(|k| put.remove(&[t[k], t[(k + 1) % 3]]).map(|points| (k, points)));
        let Some((k, mut points)) = side else {
            i += 1;
            continue;
        };
        points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let (from, to, apex) = (t[k], t[(k + 1) % 3], t[(k + 2) % 3]);
        let chain: Vec<u32> = std::iter::once(from).chain(points.iter().map(|p| p.1)).chain([to]).collect();
        slab.triangles[i] = [chain[0], chain[1], apex];
        slab.triangles.extend(chain.windows(2).skip(1).map(|w| [w[0], w[1], apex]));
    }
}
