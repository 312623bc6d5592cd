//! The whole wheel from a sector of it that two planes through the axis cut out.
//!
//! As many whole pitches as fit into the sector, and into a full turn without rest, are kept of it and turned about the
//! axis. The two ends of what is kept are sections of surfaces that repeat, so that they are congruent but for the
//! chord error of the mesh: they are joined point by point, and where that does not close the surface there is no wheel.

use std::collections::{HashMap, HashSet};
use std::f64::consts::{PI, TAU};

use glam::{DMat3, DVec2, DVec3, Vec3Swizzles as _};
use rayon::prelude::*;

use super::axis::{Axis, Turning};
use super::frame_along;
use super::slices::{CELLS, Slices};
use crate::options::{AxisChoice, AxisLine, AxisName, BliskOptions};
use geometry::frame::{Frame, wrap_angle};
use geometry::mesh::{Mesh, normal_times_two_areas};
use task::{Cancel, Cancelled};

/// Distance within which points lie on a cut, as a share of the sector's size: the rounding of files.
const ON_CUT: f64 = 2e-5;
/// Distance within which the two ends are joined, as a share of the sector's size: chord errors.
const JOINT: f64 = 2e-4;
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
    /// Passages of the sector that it was made of.
    pub kept: usize,
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
        "the mesh is a sector about the axis {axis}, and the blades between its {kept} passages are not alike: {kinds} kinds \
         can only be told to repeat in a sector of {} passages; load a larger sector or the whole wheel, or confirm the \
         number of blades of the whole wheel with blisk.blades",
        2 * .kinds
    )]
    Kinds {
        /// Kinds of blades.
        kinds: usize,
        /// Passages that were looked at.
        kept: usize,
        /// The axis.
        axis: Axis,
    },
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
            Self::Cancelled(_) => None,
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

/// A sector between two cuts, in the frame of its axis.
struct Sector {
    mesh: Mesh,
    frame: Frame,
    axis: Axis,
    /// Angle of the lower cut (rad).
    from: f64,
    /// Angle between the cuts (rad).
    angle: f64,
    on_cut: f64,
    joint: f64,
}

/// What `mesh` may be as a sector, the likeliest first: about the line of two cuts that its surfaces turn about most.
fn sectors(mesh: &Mesh, options: &BliskOptions) -> Vec<Sector> {
    /// Cuts at a smaller angle meet nowhere that can be told.
    const LEAST_ANGLE: f64 = 0.01;
    /// Hub, shroud and rims are at least this share of the surface of a sector.
    const LEAST_TURNING: f64 = 0.1;
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
            if share > LEAST_TURNING && is_allowed(&axis, options, size) {
                axes.push((share, axis, [a.normal, b.normal]));
            }
        }
    }
    axes.sort_by(|a, b| b.0.total_cmp(&a.0));
    let sector = |(_, axis, normals): (f64, Axis, [DVec3; 2])| {
        let frame = frame_along(&axis);
        let [a, b] = normals.map(|n| frame.direction_from_parent(n));
        // Out of the upper cut in the sense of theta, out of the lower one against it.
        let (upper, lower) = (|n: DVec3| (-n.z).atan2(-n.y), |n: DVec3| n.z.atan2(n.y));
        let between = |low: DVec3, high: DVec3| (upper(high) - lower(low)).rem_euclid(TAU);
        let (low, high) = if between(a, b) < PI { (a, b) } else { (b, a) };
        let (from, angle) = (lower(low), between(low, high));
        Sector { mesh: mesh.in_frame(&frame), frame, axis, from, angle, on_cut, joint: JOINT * size }
    };
    axes.into_iter().map(sector).filter(|sector| sector.angle < PI).collect()
}

fn is_allowed(axis: &Axis, options: &BliskOptions, size: f64) -> bool {
    let along = |direction: DVec3| axis.direction.cross(direction).length() < SAME;
    match options.axis {
        AxisChoice::Named(AxisName::Auto) => true,
        AxisChoice::Named(AxisName::X) => along(DVec3::X),
        AxisChoice::Named(AxisName::Y) => along(DVec3::Y),
        AxisChoice::Named(AxisName::Z) => along(DVec3::Z),
        AxisChoice::Line(AxisLine { direction, point }) => {
            let off = axis.direction.cross(DVec3::from(point) - axis.point).length();
            along(DVec3::from(direction).normalize_or_zero()) && off < SAME * size
        }
    }
}

impl Sector {
    fn whole(&self, wanted: Option<usize>, cancel: &Cancel) -> Result<Whole, SectorError> {
        let (axis, angle_deg) = (self.axis, self.angle.to_degrees());
        let count = wanted.map_or_else(|| self.blades(cancel), |given| Ok(Some(given)))?;
        let blades = count.ok_or(SectorError::Pitch { angle_deg, axis })?;
        let pitch = TAU / blades as f64;
        let fits = |k: &usize| *k as f64 * pitch < self.angle + SAME * pitch && *k as f64 * pitch < PI;
        let kept = (1..=blades).rev().filter(|k| blades.is_multiple_of(*k)).find(fits);
        let kept = kept.ok_or(SectorError::Narrow { angle_deg, pitch_deg: pitch.to_degrees(), blades, axis })?;
        let kept_angle = kept as f64 * pitch;
        // The whole of it where that is as many pitches, else its middle.
        let spare = (self.angle - kept_angle).max(0.0);
        let from = if spare < SAME * pitch { self.from } else { self.from + 0.5 * spare };
        let ends = [from, from + kept_angle];
        let around = |theta: f64| DVec3::new(0.0, -theta.cos(), -theta.sin());
        let slab = clipped(&clipped(&self.mesh, around(ends[0]), self.on_cut), -around(ends[1]), self.on_cut);
        cancel.check()?;
        let mesh = self.turned(slab, ends, blades / kept)?;
        let assumed = format!(
            "The mesh is a sector of {angle_deg:.3} deg. Its cuts meet in the axis {axis}; {kept} of its pitches were turned \
             about it into the {} sectors of the whole wheel of {blades} blades.",
            blades / kept
        );
        Ok(Whole { mesh: mesh.in_parent_of(&self.frame), axis, blades, kept, assumed })
    }

    /// The number of blades of the whole wheel, from those of the sector; from its angle if that holds fewer than two.
    fn blades(&self, cancel: &Cancel) -> Result<Option<usize>, Cancelled> {
        /// Circles that are enough to tell.
        const ENOUGH: usize = 20;
        /// Part of a blade by which a count may be off.
        const OFF: f64 = 0.05;
        let slices = Slices::new(self.mesh.clone());
        let middle = self.from + 0.5 * self.angle;
        let beside = |theta: f64| wrap_angle(theta - middle).abs() < 0.5 * self.angle - SAME;
        let mut pitches = Vec::new();
        for ix in 0..CELLS[0] {
            cancel.check()?;
            for ir in 0..CELLS[1] {
                let at = slices.cell_middle(ix, ir);
                let gaps = slices.gaps(at.x, at.y);
                let passed =
                    gaps.iter().filter(|g| g.width() < self.angle && beside(g.low.theta) && beside(g.high.theta));
                let mut lows: Vec<f64> = passed.map(|g| wrap_angle(g.low.theta - middle)).collect();
                lows.sort_by(f64::total_cmp);
                pitches.extend(lows.windows(2).map(|w| w[1] - w[0]));
            }
        }
        let whole = |count: f64| (count - count.round()).abs() < OFF && count.round() >= 3.0;
        if pitches.len() < ENOUGH {
            let count = TAU / self.angle;
            return Ok(whole(count).then_some(count.round() as usize));
        }
        pitches.sort_by(f64::total_cmp);
        let pitch = pitches[pitches.len() / 2];
        let by_blades = TAU / pitch;
        // The cuts are mostly whole pitches apart, and then tell more exactly than the facets of blades.
        let by_cuts = TAU * (self.angle / pitch).round() / self.angle;
        let count = if whole(by_cuts) && (by_cuts - by_blades).abs() < 0.3 { by_cuts } else { by_blades };
        Ok((count.round() >= 3.0).then_some(count.round() as usize))
    }

    /// `copies` of the slab between its `ends`, turned about X and joined.
    fn turned(&self, mut slab: Mesh, ends: [f64; 2], copies: usize) -> Result<Mesh, SectorError> {
        let angle = ends[1] - ends[0];
        let partners = join(&mut slab, ends, self.on_cut, self.joint).map_err(|(off_mm, at)| SectorError::Unlike {
            angle_deg: angle.to_degrees(),
            off_mm,
            x: at.x,
            r: at.y,
            axis: self.axis,
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
        Ok(whole)
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

/// One of the two outlines that are to be joined.
struct Outline {
    /// Edges, as the triangles have them.
    edges: Vec<[u32; 2]>,
    /// Its vertices, with their place in its half-plane: along the axis and away from it.
    points: Vec<(u32, DVec2)>,
}

/// Joins the outlines of the slab at its two ends: answers for each vertex of the upper outline the one of the lower.
/// Points that the other outline has not are put into its edges.
///
/// # Errors
/// How far a point lies from the other outline, and where (along the axis and away from it, mm).
fn join(slab: &mut Mesh, ends: [f64; 2], on_cut: f64, joint: f64) -> Result<HashMap<u32, u32>, (f64, DVec2)> {
    let [lower, upper] = ends.map(|theta| outline(slab, theta, on_cut));
    let mut partners = HashMap::new();
    let nearest = |outline: &Outline, p: DVec2| {
        let off = outline.points.iter().map(|(v, q)| (q.distance_squared(p), *v));
        off.min_by(|a, b| a.0.total_cmp(&b.0))
    };
    // Each other's nearest.
    for (v, p) in &upper.points {
        let Some((off, w)) = nearest(&lower, *p) else { continue };
        let q = slab_place(slab, w);
        if off.sqrt() <= 4.0 * on_cut && nearest(&upper, q).is_some_and(|(_, back)| back == *v) {
            partners.insert(*v, w);
        }
    }
    let taken: HashSet<u32> = partners.values().copied().collect();
    let of_upper: Vec<_> = upper.points.iter().filter(|(v, _)| !partners.contains_key(v)).copied().collect();
    let of_lower: Vec<_> = lower.points.iter().filter(|(v, _)| !taken.contains(v)).copied().collect();
    let angle = ends[1] - ends[0];
    for (added, at) in put_into(slab, &lower, &of_upper, -angle, joint)? {
        partners.insert(at, added);
    }
    for (added, at) in put_into(slab, &upper, &of_lower, angle, joint)? {
        partners.insert(added, at);
    }
    Ok(partners)
}

/// Place of a vertex in its half-plane.
fn slab_place(slab: &Mesh, v: u32) -> DVec2 {
    let p = slab.vertices[v as usize];
    DVec2::new(p.x, p.yz().length())
}

/// The open edges of the slab in the half-plane at `theta`.
fn outline(slab: &Mesh, theta: f64, on_cut: f64) -> Outline {
    let around = DVec3::new(0.0, -theta.cos(), -theta.sin());
    let lies = |v: u32| around.dot(slab.vertices[v as usize]).abs() <= on_cut;
    let all = slab.directed_edges();
    let open = |&&(a, b): &&(u32, u32)| !all.contains_key(&(b, a)) && lies(a) && lies(b);
    let mut edges: Vec<[u32; 2]> = all.keys().filter(open).map(|&(a, b)| [a, b]).collect();
    edges.sort_unstable();
    let mut vertices: Vec<u32> = edges.iter().flatten().copied().collect();
    vertices.sort_unstable();
    vertices.dedup();
    let points = vertices.into_iter().map(|v| (v, slab_place(slab, v))).collect();
    Outline { edges, points }
}

/// Puts `points` into the nearest edges of an outline, each where it stands once it is turned by `turn` (rad); answers
/// the new vertices with those that they were made from.
fn put_into(
    slab: &mut Mesh,
    outline: &Outline,
    points: &[(u32, DVec2)],
    turn: f64,
    joint: f64,
) -> Result<Vec<(u32, u32)>, (f64, DVec2)> {
    let turn = DMat3::from_rotation_x(turn);
    let mut put: HashMap<[u32; 2], Vec<(f64, u32, u32)>> = HashMap::new();
    let mut added = Vec::new();
    for &(v, p) in points {
        let off = |edge: &[u32; 2]| {
            let [a, b] = edge.map(|v| slab_place(slab, v));
            let share = ((p - a).dot(b - a) / (b - a).length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            (a.lerp(b, share).distance(p), share)
        };
        let all = outline.edges.iter().map(|edge| (off(edge), *edge));
        let nearest = all.min_by(|(a, _), (b, _)| a.0.total_cmp(&b.0));
        let ((distance, share), edge) = nearest.ok_or((f64::INFINITY, p))?;
        if distance > joint {
            return Err((distance, p));
        }
        let new = slab.vertices.len() as u32;
        slab.vertices.push(turn * slab.vertices[v as usize]);
        put.entry(edge).or_default().push((share, new, v));
        added.push((new, v));
    }
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
    Ok(added)
}
