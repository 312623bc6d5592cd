//! A face of a mesh by itself: its points, normals, border loops and samples.

use std::collections::HashMap;

use glam::DVec3;

use super::params::RuledFitError;
use geometry::groups::Groups;
use geometry::mesh::{Mesh, normal_times_two_areas};
use geometry::segmentation::{FaceKind, Segmentation, SegmentationSettings};
use geometry::weld::Weld;

/// No triangle.
const NONE: u32 = u32::MAX;

/// Places inside of triangles that are known.
const INNER: usize = 8_000;

/// The triangles of a face that hang together, all turned the same way.
#[derive(Debug, Clone)]
pub(super) struct Patch {
    /// Origin of the points (mm).
    pub origin: DVec3,
    /// Points, each place once (mm).
    pub points: Vec<DVec3>,
    /// The points of each triangle, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Unit normals at the points, outwards.
    pub normals: Vec<DVec3>,
    /// The share of the area that belongs to each point (mm^2).
    pub shares: Vec<f64>,
    /// Area (mm^2).
    pub area: f64,
    /// Diagonal of the box around the face (mm).
    pub size: f64,
    /// Borders, the face on the left seen from outside; the longest first.
    pub loops: Vec<Vec<u32>>,
    /// Whether each point lies on a border.
    pub is_border: Vec<bool>,
    /// Greatest distance between the triangles and a smooth surface through their corners (mm), estimated.
    pub chord: f64,
    /// Places inside of triangles, evenly over the area (mm).
    inner: Vec<DVec3>,
    /// Triangles that faced the other way than most of the others.
    pub turned: usize,
    /// Share of the area in pieces that do not hang together with the largest and are left out.
    pub lost: f64,
    /// Corners of those pieces, not all where they are many.
    pub left_out: Vec<DVec3>,
}

impl Patch {
    pub(super) fn of(mesh: &Mesh, chosen: &[u32]) -> Result<Self, RuledFitError> {
        let (origin, points, triangles) = welded(mesh, chosen)?;
        let (neighbours, branching) = neighbours(&triangles);
        if let Some(p) = branching {
            return Err(RuledFitError::Branching(points[p as usize] + origin));
        }
        let all = triangles.clone();
        let (triangles, turned, lost) = oriented(&points, triangles, &neighbours);
        let left_out = left_out(&points, &all, &triangles);
        let mut patch = Self {
            origin,
            points,
            triangles,
            normals: Vec::new(),
            shares: Vec::new(),
            area: 0.0,
            size: 0.0,
            loops: Vec::new(),
            is_border: Vec::new(),
            chord: 0.0,
            inner: Vec::new(),
            turned,
            lost,
            left_out,
        };
        patch.measure();
        if patch.area <= 1e-12 * patch.size * patch.size {
            return Err(RuledFitError::NoArea);
        }
        patch.loops = patch.borders();
        patch.is_border = vec![false; patch.points.len()];
        patch.loops.iter().flatten().for_each(|&v| patch.is_border[v as usize] = true);
        patch.chord = chord_error(&patch);
        patch.inner = patch.places(INNER);
        Ok(patch)
    }

    /// Corner points of triangle `i`.
    pub(super) fn corners(&self, i: usize) -> [DVec3; 3] {
        self.triangles[i].map(|v| self.points[v as usize])
    }

    fn measure(&mut self) {
        self.normals = vec![DVec3::ZERO; self.points.len()];
        self.shares = vec![0.0; self.points.len()];
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for t in 0..self.triangles.len() {
            let corners = self.corners(t);
            let doubled = normal_times_two_areas(corners);
            let (normal, area) = (doubled.normalize_or_zero(), 0.5 * doubled.length());
            self.area += area;
            for k in 0..3 {
                let [p, q, r] = [corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]];
                (low, high) = (low.min(p), high.max(p));
                let v = self.triangles[t][k] as usize;
                // By the angle at the corner, so that it is no matter how a quadrangle is cut in two.
                let (a, b) = (q - p, r - p);
                self.normals[v] += normal * a.cross(b).length().atan2(a.dot(b));
                self.shares[v] += area / 3.0;
            }
        }
        self.normals.iter_mut().for_each(|n| *n = n.normalize_or_zero());
        self.size = if low.is_finite() { (high - low).length() } else { 0.0 };
    }

    /// The loops of sides that one triangle only has.
    fn borders(&self) -> Vec<Vec<u32>> {
        let mut sides: Vec<(u32, u32)> =
            self.triangles.iter().flat_map(|t| (0..3).map(|k| (t[k], t[(k + 1) % 3]))).collect();
        sides.sort_unstable();
        let is_open = |s: &&(u32, u32)| sides.binary_search(&(s.1, s.0)).is_err();
        let open: Vec<(u32, u32)> = sides.iter().filter(is_open).copied().collect();
        let mut is_used = vec![false; open.len()];
        let mut loops = Vec::new();
        for first in 0..open.len() {
            let (mut next, mut found) = (Some(first).filter(|&i| !is_used[i]), Vec::new());
            while let Some(i) = next {
                is_used[i] = true;
                found.push(open[i].0);
                let from = open.partition_point(|s| s.0 < open[i].1);
                next = (from..open.len()).take_while(|&j| open[j].0 == open[i].1).find(|&j| !is_used[j]);
            }
            loops.push(found);
        }
        loops.retain(|l| l.len() >= 3);
        loops.sort_by(|a, b| self.length(b).total_cmp(&self.length(a)));
        loops
    }

    /// Length of a closed loop (mm).
    pub(super) fn length(&self, around: &[u32]) -> f64 {
        let at = |i: usize| self.points[around[i % around.len()] as usize];
        (0..around.len()).map(|i| at(i).distance(at(i + 1))).sum()
    }

    /// At most `count` points of the corners, evenly over their number, with their shares of the area.
    pub(super) fn corner_samples(&self, count: usize) -> Vec<(DVec3, f64)> {
        let n = self.points.len();
        let count = count.clamp(1, n);
        let step = n as f64 / count as f64;
        // Uneven steps, or all samples of a grid of points could lie in one row of it.
        let number = |k: usize| ((k as f64 + (0.618 * k as f64).fract()) * step) as usize;
        let kept = (0..count).map(|k| if count == n { k } else { number(k).min(n - 1) });
        let at = |i: usize| (self.points[i], self.shares[i] / self.area * step);
        kept.filter(|&i| self.shares[i] > 0.0).map(at).collect()
    }

    /// At most `count` places inside of triangles, evenly over the area.
    pub(super) fn inner_samples(&self, count: usize) -> Vec<DVec3> {
        self.inner.iter().step_by(self.inner.len().div_ceil(count.max(1)).max(1)).copied().collect()
    }

    /// `count` places inside of triangles, evenly over the area.
    fn places(&self, count: usize) -> Vec<DVec3> {
        let mut found = Vec::with_capacity(count);
        let step = self.area / count as f64;
        let (mut sum, mut next) = (0.0, 0.5 * step);
        for t in 0..self.triangles.len() {
            let [a, b, c] = self.corners(t);
            sum += 0.5 * normal_times_two_areas([a, b, c]).length();
            while next < sum && found.len() < count {
                // The additive sequence by the plastic number fills the square evenly.
                let k = found.len() as f64 + 0.5;
                let (mut x, mut y) = ((k * 0.754_877_666_246_692_7).fract(), (k * 0.569_840_290_998_053_2).fract());
                if x + y > 1.0 {
                    (x, y) = (1.0 - x, 1.0 - y);
                }
                found.push(a + (b - a) * x + (c - a) * y);
                next += step;
            }
        }
        found
    }

    /// The face as a mesh, counted from its origin.
    pub(super) fn mesh(&self) -> Mesh {
        Mesh { vertices: self.points.clone(), triangles: self.triangles.clone() }
    }
}

type Welded = (DVec3, Vec<DVec3>, Vec<[u32; 3]>);

/// The points of the chosen triangles with those at the same place joined, and the triangles with three points.
fn welded(mesh: &Mesh, chosen: &[u32]) -> Result<Welded, RuledFitError> {
    let mut chosen = chosen.to_vec();
    chosen.sort_unstable();
    chosen.dedup();
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for &t in &chosen {
        let triangle = mesh.triangles.get(t as usize).ok_or(RuledFitError::NoTriangle(t))?;
        for v in triangle {
            let p = mesh.vertices.get(*v as usize).filter(|p| p.is_finite()).ok_or(RuledFitError::NoPoint(t))?;
            (low, high) = (low.min(*p), high.max(*p));
        }
    }
    if chosen.is_empty() {
        return Err(RuledFitError::NoArea);
    }
    let origin = 0.5 * low + 0.5 * high;
    let (mut weld, mut triangles) = (Weld::with_capacity(chosen.len()), Vec::with_capacity(chosen.len()));
    for &t in &chosen {
        let corners = mesh.triangles[t as usize].map(|v| weld.add(mesh.vertices[v as usize]));
        if corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0] {
            triangles.push(corners);
        }
    }
    let points = weld.points().iter().map(|p| p - origin).collect();
    if triangles.is_empty() { Err(RuledFitError::NoArea) } else { Ok((origin, points, triangles)) }
}

/// The triangle across each side with whether it agrees which way is out, and a point where three or more meet.
fn neighbours(triangles: &[[u32; 3]]) -> (Vec<[(u32, bool); 3]>, Option<u32>) {
    let mut sides = Vec::with_capacity(triangles.len() * 3);
    for (i, t) in triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            sides.push((a.min(b), a.max(b), a > b, i as u32, k as u32));
        }
    }
    sides.sort_unstable();
    let mut found = vec![[(NONE, true); 3]; triangles.len()];
    let mut branching = None;
    for group in sides.chunk_by(|s, t| (s.0, s.1) == (t.0, t.1)) {
        match *group {
            [_] => {}
            [(_, _, one, i, k), (_, _, other, j, l)] => {
                found[i as usize][k as usize] = (j, one != other);
                found[j as usize][l as usize] = (i, one != other);
            }
            _ => branching = branching.or(group.first().map(|s| s.0)),
        }
    }
    (found, branching)
}

/// The triangles of the piece with the greatest area, turned as most of its area is; how many were turned, and the
/// share of the other pieces.
fn oriented(points: &[DVec3], triangles: Vec<[u32; 3]>, across: &[[(u32, bool); 3]]) -> (Vec<[u32; 3]>, usize, f64) {
    let area = |t: usize| 0.5 * normal_times_two_areas(triangles[t].map(|v| points[v as usize])).length();
    let mut piece = vec![NONE; triangles.len()];
    let mut is_turned = vec![false; triangles.len()];
    let mut pieces: Vec<(f64, f64)> = Vec::new();
    for seed in 0..triangles.len() {
        if piece[seed] != NONE {
            continue;
        }
        let number = pieces.len() as u32;
        piece[seed] = number;
        let (mut members, mut next, mut sums) = (vec![seed], 0, (0.0, 0.0));
        while next < members.len() {
            let t = members[next];
            next += 1;
            sums.0 += area(t);
            sums.1 += if is_turned[t] { area(t) } else { 0.0 };
            for &(to, agrees) in across[t].iter().filter(|(to, _)| *to != NONE) {
                if piece[to as usize] == NONE {
                    piece[to as usize] = number;
                    is_turned[to as usize] = is_turned[t] == agrees;
                    members.push(to as usize);
                }
            }
        }
        pieces.push(sums);
    }
    let total: f64 = pieces.iter().map(|p| p.0).sum();
    let best = (0..pieces.len()).fold(0, |b, i| if pieces[i].0 > pieces[b].0 { i } else { b });
    let flip = pieces[best].1 > 0.5 * pieces[best].0;
    let mut turned = 0;
    let kept = (0..triangles.len()).filter(|&t| piece[t] == best as u32).map(|t| {
        let [a, b, c] = triangles[t];
        turned += usize::from(is_turned[t] != flip);
        if is_turned[t] != flip { [a, c, b] } else { [a, b, c] }
    });
    let kept: Vec<[u32; 3]> = kept.collect();
    (kept, turned, if total > 0.0 { 1.0 - pieces[best].0 / total } else { 0.0 })
}

/// Points of `all` triangles that none of the `kept` has: a part of them, evenly chosen, where they are many.
fn left_out(points: &[DVec3], all: &[[u32; 3]], kept: &[[u32; 3]]) -> Vec<DVec3> {
    if all.len() == kept.len() {
        return Vec::new();
    }
    let mut is_left = vec![false; points.len()];
    all.iter().flatten().for_each(|&v| is_left[v as usize] = true);
    kept.iter().flatten().for_each(|&v| is_left[v as usize] = false);
    let left: Vec<DVec3> = points.iter().zip(&is_left).filter(|(_, left)| **left).map(|(p, _)| *p).collect();
    let step = left.len().div_ceil(INNER).max(1);
    left.into_iter().step_by(step).collect()
}

/// The mean of the unit normals of some triangles of `mesh`, by their areas; those without points do not count.
pub(super) fn mean_normal(mesh: &Mesh, triangles: &[u32]) -> DVec3 {
    let of = |t: &u32| {
        let [a, b, c] = *mesh.triangles.get(*t as usize)?;
        let at = |v: u32| mesh.vertices.get(v as usize).copied();
        Some(normal_times_two_areas([at(a)?, at(b)?, at(c)?])).filter(|n| n.is_finite())
    };
    let sum: DVec3 = triangles.iter().filter_map(of).sum();
    let areas: f64 = triangles.iter().filter_map(of).map(DVec3::length).sum();
    // What is left of a ring's is rounding.
    if sum.length() > 1e-9 * areas { sum.normalize_or_zero() } else { DVec3::ZERO }
}

/// Estimated greatest distance between the triangles and a smooth surface through their corners (mm); zero over flats.
///
/// The estimate comes from the turn of the triangles against each other. A flat that goes over into a rounding turns at
/// their seam only: normals at the seam that are the mean of both would make a bulge of the whole flat. So triangles
/// are compared within one smooth piece of the face: each flat, and the curved facets between flats.
fn chord_error(patch: &Patch) -> f64 {
    let piece = smooth_pieces(patch);
    along_sides(patch, &piece).max(across_sides(patch, &piece))
}

/// The smooth piece that each triangle belongs to. Faces side by side are one piece, whether a plane is among them or
/// not, unless just one of both is a plane: what is flat beside something curved is flat, but planes beside planes may
/// be the coarse triangles of one curved surface.
fn smooth_pieces(patch: &Patch) -> Vec<u32> {
    let found = Segmentation::of(&patch.mesh(), &SegmentationSettings::default());
    let is_flat: Vec<bool> = found.faces.iter().map(|f| matches!(f.kind, FaceKind::Plane { .. })).collect();
    let mut pieces = Groups::of(found.faces.len());
    for edge in &found.edges {
        let [a, b] = edge.faces.map(|face| face as usize);
        if is_flat[a] == is_flat[b] {
            pieces.join(a, b);
        }
    }
    found.face_of.iter().map(|face| pieces.first(*face as usize) as u32).collect()
}

/// The greatest height, over the sides of triangles, of the cubic that has the piece's normals at both ends: a quarter
/// of the turn of the chord, as of a circle's.
fn along_sides(patch: &Patch, piece: &[u32]) -> f64 {
    let mut normals: HashMap<(u32, u32), DVec3> = HashMap::with_capacity(patch.points.len());
    for (t, corners) in patch.triangles.iter().enumerate() {
        let points = patch.corners(t);
        let normal = normal_times_two_areas(points).normalize_or_zero();
        for k in 0..3 {
            // By the angle at the corner, so that it is no matter how a quadrangle is cut in two.
            let (a, b) = (points[(k + 1) % 3] - points[k], points[(k + 2) % 3] - points[k]);
            *normals.entry((corners[k], piece[t])).or_default() += normal * a.cross(b).length().atan2(a.dot(b));
        }
    }
    normals.values_mut().for_each(|n| *n = n.normalize_or_zero());
    let at = |v: u32, piece: u32| normals.get(&(v, piece)).copied().unwrap_or_default();
    let height = |t: usize, k: usize| {
        let (a, b) = (patch.triangles[t][k], patch.triangles[t][(k + 1) % 3]);
        let along = patch.points[b as usize] - patch.points[a as usize];
        (along.dot(at(b, piece[t]) - at(a, piece[t])) / 8.0).abs()
    };
    (0..patch.triangles.len()).flat_map(|t| (0..3).map(move |k| (t, k))).map(|(t, k)| height(t, k)).fold(0.0, f64::max)
}

/// Chord error by the turn of neighbours of one piece over their common side, which shows a rounding of two triangles'
/// breadth, whose normals at the seams are those of one triangle only.
fn across_sides(patch: &Patch, piece: &[u32]) -> f64 {
    let mut sides: Vec<(u32, u32, u32)> = Vec::with_capacity(3 * patch.triangles.len());
    for (t, corners) in patch.triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            sides.push((a.min(b), a.max(b), t as u32));
        }
    }
    sides.sort_unstable();
    let height = |pair: &[(u32, u32, u32)]| {
        let [(a, b, s), (_, _, t)] = *pair else { return 0.0 };
        if piece[s as usize] != piece[t as usize] {
            return 0.0;
        }
        let length = patch.points[a as usize].distance(patch.points[b as usize]).max(f64::MIN_POSITIVE);
        let doubled = [s, t].map(|t| normal_times_two_areas(patch.corners(t as usize)));
        let [h, g] = doubled.map(|n| n.length() / length);
        let turn = doubled[0].cross(doubled[1]).length().atan2(doubled[0].dot(doubled[1]));
        // An arc that turns so much from the middle of one to the middle of the other.
        let bend = 2.0 * turn / (h + g).max(f64::MIN_POSITIVE);
        bend * h.min(g).powi(2) / 8.0
    };
    let found = sides.chunk_by(|s, t| (s.0, s.1) == (t.0, t.1)).map(height);
    found.fold(0.0, f64::max)
}
