//! Samples for residual stock on a region's surface: evenly on its faces, and closely along the edges where the
//! spark rounds them and along the cuts between parts.

use glam::DVec3;
use rayon::prelude::*;

use super::cut::Cut;
use super::residual_stock::Looked;
use super::residual_stock::Sample;
use super::setting::RegionToBurn;
use geometry::exact::ExactMesh;
use geometry::mesh::{Bounds, Edge, Mesh, unit_normal};

/// The z component of the unit normal from which on a face is a floor.
const FLOOR: f64 = 0.5;
/// Longest side of the part of a surface that a sample stands for, if there are not too many of them (mm).
const FINE: f64 = 0.2;
/// Samples of a region's surface, about, at most; along its edges, about, at most.
const SAMPLES: f64 = 6000.0;
/// Turn of a concave edge from which on the spark leaves something in it that is worth looking at.
const LEAST_TURN_DEG: f64 = 15.0;
/// Distances from an edge at which it is looked at, and the widths that these stand for, of the radius that burns: such
/// that the area that it leaves in a right angle comes out, where that is thickest, and the edge itself.
const FROM_EDGE: [(f64, f64); 5] = [(0.0, 0.0), (0.11, 0.22), (0.29, 0.0), (0.344, 0.2), (0.661, 0.58)];
/// Upwards part of an edge's direction from which on the orbit rounds it.
const UPRIGHT: f64 = 0.5;
/// How far a place may lie off a region's surface to be on it (mm).
const ON_REGION: f64 = 1e-3;

/// With what radius the spark rounds an edge, of those of level and of upright ones (mm).
fn radius(edge: &Edge, [level, upright]: [f64; 2]) -> f64 {
    if edge.along().z.abs() > UPRIGHT { upright } else { level }
}

/// How far a point is from an edge (mm).
fn off(edge: &Edge, p: DVec3) -> f64 {
    let [a, b] = edge.ends;
    let way = b - a;
    let t = ((p - a).dot(way) / way.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    p.distance(a + way * t)
}

/// The edges of a mold in which the spark leaves something.
pub(super) fn concave_edges(mold: &Mesh) -> Vec<Edge> {
    mold.concave_edges(LEAST_TURN_DEG.to_radians())
}

/// The edges near a region, each as far as it is in the box around it.
fn near(edges: &[Edge], bounds: &Bounds) -> Vec<Edge> {
    let clipped = |edge: &Edge| -> Option<Edge> {
        let [a, b] = edge.ends;
        let (mut from, mut to) = (0f64, 1f64);
        for axis in 0..3 {
            let (start, way) = (a[axis], b[axis] - a[axis]);
            let [low, high] = [bounds.min[axis], bounds.max[axis]];
            if way.abs() < 1e-12 {
                if start < low || start > high {
                    return None;
                }
                continue;
            }
            let [t, u] = [(low - start) / way, (high - start) / way];
            (from, to) = (from.max(t.min(u)), to.min(t.max(u)));
        }
        (from < to).then(|| Edge { ends: [a.lerp(b, from), a.lerp(b, to)], ..*edge })
    };
    edges.iter().filter_map(clipped).collect()
}

/// Evenly along one segment after another: how far from the end of the last one the next place is.
struct Evenly {
    apart: f64,
    due: f64,
}

impl Evenly {
    fn new(apart: f64) -> Self {
        Self { apart, due: 0.5 * apart }
    }

    fn on(&mut self, [a, b]: [DVec3; 2]) -> Vec<DVec3> {
        let length = a.distance(b);
        let mut places = Vec::new();
        while self.due < length {
            places.push(a.lerp(b, self.due / length));
            self.due += self.apart;
        }
        self.due -= length;
        places
    }
}

/// Small areas one after another, of which one in a share stands for itself and those before it.
pub(super) struct Thinning {
    share: f64,
    waiting: f64,
}

impl Thinning {
    /// One for each `share` (mm^2).
    pub(super) fn new(share: f64) -> Self {
        Self { share, waiting: 0.0 }
    }

    /// The area that the next one (mm^2) stands for, if it stands for any.
    pub(super) fn next(&mut self, area: f64) -> Option<f64> {
        self.waiting += area;
        (self.waiting >= self.share).then(|| std::mem::take(&mut self.waiting))
    }
}

/// A region's surface in the burn frame.
struct Surface<'a> {
    corners: &'a [[DVec3; 3]],
    region: &'a RegionToBurn,
}

impl Surface<'_> {
    /// A sample of one of its triangles.
    fn sample(&self, triangle: usize, point: DVec3, area: f64) -> Sample {
        let (region, upright) = (self.region, unit_normal(self.region.corners[triangle]).z);
        let depth = region.depths.get(triangle).copied().unwrap_or(region.thickness);
        // What lies on a floor is as thick as it is high, across the surface.
        let thickest = if upright > FLOOR { (depth * upright).min(region.thickness) } else { region.thickness };
        Sample { point, normal: unit_normal(self.corners[triangle]), area, thickest }
    }

    /// Evenly by area: large parts are divided, of small ones each stands for its neighbours.
    fn on_faces(&self) -> (Vec<Sample>, f64) {
        let area = |[a, b, c]: &[DVec3; 3]| 0.5 * (*b - *a).cross(*c - *a).length();
        let all: f64 = self.corners.iter().map(area).sum();
        let share = (all / SAMPLES).max(1e-9);
        let longest = FINE.max((4.0 * share).sqrt());
        let (mut samples, mut thinning) = (Vec::new(), Thinning::new(share));
        for (i, corners) in self.corners.iter().enumerate() {
            let mut parts = vec![*corners];
            while let Some(part) = parts.pop() {
                let [a, b, c] = part;
                let sides = [a.distance(b), b.distance(c), c.distance(a)];
                let most = sides.iter().copied().fold(0.0, f64::max);
                if most > longest {
                    let [a, b, c] = match sides.iter().position(|s| *s == most) {
                        Some(1) => [b, c, a],
                        Some(2) => [c, a, b],
                        _ => [a, b, c],
                    };
                    parts.extend([[a, a.midpoint(b), c], [a.midpoint(b), b, c]]);
                    continue;
                }
                let stands_for = thinning.next(area(&part));
                samples.extend(stands_for.map(|area| self.sample(i, (a + b + c) / 3.0, area)));
            }
        }
        (samples, longest)
    }

    /// On both sides of edges, up to the reach of the spark.
    fn along(&self, edges: &[Edge], radii: [f64; 2]) -> (Vec<Sample>, f64) {
        let soup = Mesh {
            vertices: self.corners.as_flattened().to_vec(),
            triangles: (0..self.corners.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        };
        let Ok(exact) = ExactMesh::new(&soup) else { return (Vec::new(), 0.0) };
        let length: f64 = edges.iter().map(Edge::length).sum();
        let apart = FINE.max(length * 2.0 * FROM_EDGE.len() as f64 / SAMPLES);
        let mut evenly = Evenly::new(apart);
        let mut samples = Vec::new();
        for edge in edges {
            let (along, radius) = (edge.along(), radius(edge, radii));
            let [n, m] = edge.normals;
            // Into each face, away from the edge.
            let sides = [n.cross(along), along.cross(m)];
            for place in evenly.on(edge.ends) {
                for side in sides {
                    for (off, width) in FROM_EDGE.map(|(off, width)| (off * radius, width * radius)) {
                        let nearest = exact.nearest(place + side * off);
                        if nearest.signed_distance.abs() < ON_REGION {
                            samples.push(self.sample(nearest.triangle as usize, nearest.point, apart * width));
                        }
                    }
                }
            }
        }
        (samples, apart)
    }

    /// Along cuts: they stand for no area.
    fn along_cuts(&self, cuts: &[Cut]) -> Vec<Sample> {
        on_cuts(self.corners, cuts).into_iter().map(|(i, p)| self.sample(i, p, 0.0)).collect()
    }
}

/// Places of a surface, given by its triangles' corners (mm), evenly along cuts through it, each with its triangle.
pub(super) fn on_cuts(corners: &[[DVec3; 3]], cuts: &[Cut]) -> Vec<(usize, DVec3)> {
    let mut crossings: Vec<(usize, [DVec3; 2])> = Vec::new();
    for cut in cuts {
        for (i, corners) in corners.iter().enumerate() {
            let off = corners.map(|p| cut.beyond(p));
            let sides = (0..3).map(|k| (k, (k + 1) % 3)).filter(|(k, l)| (off[*k] < 0.0) != (off[*l] < 0.0));
            let at = |(k, l): (usize, usize)| corners[k].lerp(corners[l], off[k] / (off[k] - off[l]));
            let ends: Vec<DVec3> = sides.map(at).collect();
            if let [a, b] = ends[..] {
                crossings.push((i, [a, b]));
            }
        }
    }
    let length: f64 = crossings.iter().map(|(_, [a, b])| a.distance(*b)).sum();
    let mut evenly = Evenly::new((0.5 * FINE).max(length / SAMPLES));
    let on = |(i, ends): (usize, [DVec3; 2])| -> Vec<(usize, DVec3)> {
        evenly.on(ends).into_iter().map(|p| (i, p)).collect()
    };
    crossings.into_iter().flat_map(on).collect()
}

/// Samples for the residual stock of a region, given the corners of its surface in the burn frame, the mold's edges,
/// the cuts between its parts and the radii with which the spark rounds level and upright edges (mm).
pub(super) fn samples(
    corners: &[[DVec3; 3]],
    region: &RegionToBurn,
    (edges, cuts): (&[Edge], &[Cut]),
    radii: [f64; 2],
) -> (Vec<Sample>, Looked) {
    let surface = Surface { corners, region };
    let (mut samples, on_faces) = surface.on_faces();
    let mut along_edges = on_faces;
    if radii[1] > 0.0 {
        let bounds = Bounds::of(corners.as_flattened().iter().copied()).grown(ON_REGION);
        let edges = near(edges, &bounds);
        let (close, apart) = surface.along(&edges, radii);
        if !close.is_empty() {
            along_edges = apart;
            // What is looked at closely is not counted twice.
            let is_close = |s: &Sample| edges.iter().any(|edge| off(edge, s.point) < radius(edge, radii));
            samples.par_iter_mut().filter(|s| is_close(s)).for_each(|s| s.area = 0.0);
        }
        samples.extend(close);
    }
    samples.extend(surface.along_cuts(cuts));
    (samples, Looked { on_faces, along_edges })
}
