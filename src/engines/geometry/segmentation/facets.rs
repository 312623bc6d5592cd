//! Facets: triangles side by side in one plane.

use std::collections::VecDeque;

use glam::DVec3;

use super::topology::{NONE, Topology};

/// How much wider than its neighbour a facet of the same curved surface may be.
const WIDER: f64 = 3.0;
/// How much larger in area.
const LARGER: f64 = 10.0;

/// A plane: the points `p` with `normal . p = offset`, counted from the origin of the topology.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Flat {
    /// Unit normal, outwards.
    pub(super) normal: DVec3,
    /// Distance along the normal (mm).
    pub(super) offset: f64,
}

/// Triangles in one plane.
#[derive(Debug, Clone)]
pub(super) struct Facet {
    pub(super) flat: Flat,
    pub(super) triangles: Vec<u32>,
    /// The points where its outline bends: those in between, inside or on a straight side, add nothing.
    pub(super) corners: Vec<u32>,
    /// mm^2.
    pub(super) area: f64,
    /// Area over greatest extent (mm): about the width of a narrow facet.
    pub(super) width: f64,
}

/// Common border of two facets.
#[derive(Debug, Clone, Copy)]
pub(super) struct Link {
    pub(super) to: u32,
    /// Length of the sides they share (mm).
    pub(super) length: f64,
    /// Angle between the normals (rad), positive over a convex side.
    pub(super) turn: f64,
    /// Unit vector about which the normal turns on the way over.
    pub(super) about: DVec3,
}

/// The facets of a mesh.
pub(super) struct Facets {
    pub(super) all: Vec<Facet>,
    /// The facet of each triangle; [`NONE`] for triangles without three different points.
    pub(super) of_triangle: Vec<u32>,
    links: Vec<Link>,
    starts: Vec<usize>,
}

impl Facet {
    /// Whether the other is no much smaller one.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        self.width <= WIDER * other.width && self.area <= LARGER * other.area
    }
}

impl Facets {
    /// Grows facets from the largest triangles first: those have the most reliable normals.
    pub(super) fn of(topology: &Topology, angle: f64, tolerance: f64) -> Self {
        let mut order: Vec<u32> = (0..topology.corners.len() as u32).collect();
        order.retain(|&i| topology.corners[i as usize].iter().all(|&v| v != NONE) && is_usable(topology, i));
        order.sort_by(|&a, &b| topology.areas[b as usize].total_cmp(&topology.areas[a as usize]).then(a.cmp(&b)));
        let mut facets = Self {
            all: Vec::new(),
            of_triangle: vec![NONE; topology.corners.len()],
            links: Vec::new(),
            starts: Vec::new(),
        };
        for seed in order {
            if facets.of_triangle[seed as usize] == NONE {
                facets.grow(topology, seed, angle, tolerance);
            }
        }
        facets.link(topology);
        facets.find_corners(topology);
        facets
    }

    fn grow(&mut self, topology: &Topology, seed: u32, angle: f64, tolerance: f64) {
        let number = self.all.len() as u32;
        let mut plane = RunningPlane::default();
        let mut triangles = Vec::new();
        let mut queue = VecDeque::from([seed]);
        self.of_triangle[seed as usize] = number;
        plane.add(topology, seed);
        while let Some(i) = queue.pop_front() {
            triangles.push(i);
            for next in topology.neighbours[i as usize] {
                if next == NONE || self.of_triangle[next as usize] != NONE {
                    continue;
                }
                if plane.flat().holds(topology, next, angle, tolerance) {
                    self.of_triangle[next as usize] = number;
                    plane.add(topology, next);
                    queue.push_back(next);
                }
            }
        }
        self.all.push(facet(topology, triangles, plane.flat()));
    }

    /// Neighbours of facet `i`.
    pub(super) fn links(&self, i: u32) -> &[Link] {
        &self.links[self.starts[i as usize]..self.starts[i as usize + 1]]
    }

    fn find_corners(&mut self, topology: &Topology) {
        let mut ends: Vec<(u32, u32, bool, usize, usize)> = Vec::new();
        for (i, neighbours) in topology.neighbours.iter().enumerate() {
            let own = self.of_triangle[i];
            if own == NONE {
                continue;
            }
            for (k, &j) in neighbours.iter().enumerate() {
                if j == NONE || self.of_triangle[j as usize] != own {
                    let [from, to] = topology.side(i, k);
                    ends.extend([(own, from, true, i, k), (own, to, false, i, k)]);
                }
            }
        }
        ends.sort_unstable();
        for group in ends.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let is_straight = match *group {
                [(_, _, false, i, k), (_, _, true, j, l)] => {
                    let (a, b) = (topology.along_side(i, k), topology.along_side(j, l));
                    a.cross(b).length() <= STRAIGHT * a.dot(b)
                }
                _ => false,
            };
            if !is_straight {
                self.all[group[0].0 as usize].corners.push(group[0].1);
            }
        }
    }

    fn link(&mut self, topology: &Topology) {
        let mut shared: Vec<(u32, u32, f64, f64)> = Vec::new();
        for (i, neighbours) in topology.neighbours.iter().enumerate() {
            for (k, &j) in neighbours.iter().enumerate().filter(|(_, j)| **j != NONE) {
                let (a, b) = (self.of_triangle[i], self.of_triangle[j as usize]);
                if a != b && a != NONE && b != NONE {
                    let along = topology.along_side(i, k);
                    let [n, m] = [a, b].map(|f| self.all[f as usize].flat.normal);
                    shared.push((a, b, along.length(), n.cross(m).dot(along)));
                }
            }
        }
        shared.sort_by_key(|s| (s.0, s.1));
        self.starts = vec![0];
        for group in shared.chunk_by(|s, t| (s.0, s.1) == (t.0, t.1)) {
            let (from, to, ..) = group[0];
            self.starts.resize(from as usize + 1, self.links.len());
            let [n, m] = [from, to].map(|f| self.all[f as usize].flat.normal);
            let (length, sign) = group.iter().fold((0.0, 0.0), |(l, s), g| (l + g.2, s + g.3));
            let turn = n.cross(m).length().atan2(n.dot(m)) * sign.signum();
            self.links.push(Link { to, length, turn, about: n.cross(m).normalize_or_zero() });
        }
        self.starts.resize(self.all.len() + 1, self.links.len());
    }
}

/// Bend left by the rounding of coordinates (rad).
const STRAIGHT: f64 = 2e-3;

/// Triangles with three different points; those without are given a face in the end.
fn is_usable(topology: &Topology, i: u32) -> bool {
    topology.areas[i as usize] > 0.0 || topology.neighbours[i as usize].iter().any(|&n| n != NONE)
}

fn facet(topology: &Topology, triangles: Vec<u32>, flat: Flat) -> Facet {
    let area = triangles.iter().map(|&t| topology.areas[t as usize]).sum();
    let points = topology.points_of(triangles.iter().copied());
    let farthest = |from: DVec3| {
        let far = |v: &u32| topology.points[*v as usize].distance_squared(from);
        points.iter().map(|v| (far(v), *v)).fold((0.0, points[0]), |best, p| if p.0 > best.0 { p } else { best })
    };
    // Twice the farthest point from any point: a greatest extent for all that matters here.
    let (_, end) = farthest(topology.points[points[0] as usize]);
    let extent = farthest(topology.points[end as usize]).0.sqrt();
    Facet { flat, triangles, corners: Vec::new(), area, width: area / extent.max(f64::MIN_POSITIVE) }
}

impl Flat {
    /// Distance of a point (mm).
    pub(super) fn distance(&self, p: DVec3) -> f64 {
        (self.normal.dot(p) - self.offset).abs()
    }

    /// Whether a triangle lies in the plane. A corner may be off by the tolerance, which turns the normal of a narrow
    /// triangle: that of a sliver says nothing.
    fn holds(&self, topology: &Topology, triangle: u32, angle: f64, tolerance: f64) -> bool {
        let i = triangle as usize;
        if topology.triangle(i).iter().any(|&p| self.distance(p) > tolerance) {
            return false;
        }
        let height = topology.heights[i];
        height <= tolerance || {
            let normal = topology.normals[i];
            let turn = normal.cross(self.normal).length().atan2(normal.dot(self.normal));
            turn <= angle + tolerance / height
        }
    }
}

/// The mean plane of the triangles so far.
#[derive(Default)]
struct RunningPlane {
    directed: DVec3,
    moment: DVec3,
    area: f64,
    first: DVec3,
}

impl RunningPlane {
    fn add(&mut self, topology: &Topology, triangle: u32) {
        let i = triangle as usize;
        let [a, b, c] = topology.triangle(i);
        if self.area == 0.0 {
            self.first = a;
        }
        let area = topology.areas[i];
        self.directed += topology.normals[i] * area;
        self.moment += ((a - self.first) + (b - self.first) + (c - self.first)) / 3.0 * area;
        self.area += area;
    }

    fn flat(&self) -> Flat {
        let normal = self.directed.normalize_or_zero();
        let middle = if self.area > 0.0 { self.moment / self.area } else { DVec3::ZERO };
        Flat { normal, offset: normal.dot(self.first + middle) }
    }
}
