//! The triangles of a mesh, laid out for exact signed point distances over short candidate lists.

use std::collections::HashMap;

use foldhash::fast::FixedState;
use glam::DVec3;
use rayon::prelude::*;

use crate::inside::crossing;
use crate::mesh::{Bounds, Mesh, unit_normal};

/// Triangles with the normals that decide the sign of a distance at each of their features (angle-weighted
/// pseudo-normals, Baerentzen and Aanaes 2005).
pub(super) struct LocalTriangles {
    triangles: Vec<Triangle>,
    /// For each triangle of the mesh its number here, [`ELSEWHERE`](Self::ELSEWHERE) if it is none of these.
    numbers: Vec<u32>,
    /// A ball around each, apart from the rest so that looking at many of them is cheap.
    balls: Vec<Ball>,
}

/// Middle and radius.
struct Ball {
    center: DVec3,
    radius: f64,
}

impl Ball {
    /// Around the middle of the corners' box, which for most triangles is near the smallest ball.
    fn around(corners: [DVec3; 3]) -> Self {
        let center = Bounds::of(corners).center();
        // A hair more, against rounding.
        let radius = corners.map(|p| p.distance(center)).into_iter().fold(0.0, f64::max) * (1.0 + 1e-12);
        Self { center, radius }
    }
}

/// A half-space that holds a triangle: no point is further from it than from the triangle.
#[derive(Clone, Copy)]
pub(super) struct HalfSpace {
    /// Unit vector out of it, or zero if it is all space.
    pub(super) out: DVec3,
    at: f64,
}

impl HalfSpace {
    /// All space.
    pub(super) const ALL: Self = Self { out: DVec3::ZERO, at: 0.0 };

    /// Distance from `p`, or a hair less (mm); 0 or less inside.
    #[inline]
    pub(super) fn distance(&self, p: DVec3) -> f64 {
        self.out.dot(p) - self.at
    }
}

struct Triangle {
    a: DVec3,
    ab: DVec3,
    ac: DVec3,
    face: DVec3,
    /// Normals at the corners a, b, c.
    corners: [DVec3; 3],
    /// Normals on the edges ab, bc, ca.
    edges: [DVec3; 3],
}

/// A triangle that can be nearest to some point of a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Candidate {
    /// Distance from the cell's centre, or less (mm).
    from_center: f32,
    pub(super) triangle: u32,
}

impl Candidate {
    /// One that is `from_center` from the centre, or more (mm).
    pub(super) fn new(from_center: f64, triangle: u32) -> Self {
        /// For rounding to single precision, as a share.
        const ROUNDING: f64 = 1e-6;
        Self { from_center: (from_center * (1.0 - ROUNDING)) as f32, triangle }
    }

    /// Least distance from the centre (mm), and the triangle.
    pub(super) fn in_order(&self) -> (f64, u32) {
        (f64::from(self.from_center), self.triangle)
    }
}

/// The triangle nearest to a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Nearest {
    distance_squared: f64,
    pub(super) triangle: u32,
}

impl Nearest {
    pub(super) const NONE: Self = Self { distance_squared: f64::INFINITY, triangle: 0 };

    /// Distance without a sign (mm).
    pub(super) fn distance(self) -> f64 {
        self.distance_squared.sqrt()
    }
}

/// The part of a triangle that holds the nearest point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Feature {
    Corner(usize),
    Edge(usize),
    Face,
}

impl LocalTriangles {
    const ELSEWHERE: u32 = u32::MAX;

    /// The triangles of `mesh` whose boxes meet `around`, in their order.
    pub(super) fn new(mesh: &Mesh, around: Bounds) -> Self {
        let is_near: Vec<bool> = mesh.triangles.par_iter().map(|t| mesh.bounds_of(t).intersects(&around)).collect();
        let own: Vec<u32> = (0..is_near.len()).filter(|&i| is_near[i]).map(|i| i as u32).collect();
        let mut numbers = vec![Self::ELSEWHERE; is_near.len()];
        own.iter().zip(0..).for_each(|(&i, number)| numbers[i as usize] = number);
        let mut used = vec![false; mesh.vertices.len()];
        own.iter().flat_map(|&i| mesh.triangles[i as usize]).for_each(|v| used[v as usize] = true);
        let mut corner_normals = vec![DVec3::ZERO; mesh.vertices.len()];
        let mut edge_normals: HashMap<(u32, u32), DVec3, FixedState> = HashMap::default();
        // Those beside them have a say in the normals of what they share.
        for t in mesh.triangles.iter().filter(|t| t.iter().any(|&v| used[v as usize])) {
            let points = t.map(|v| mesh.vertices[v as usize]);
            let face = unit_normal(points);
            for i in 0..3 {
                let [(here, p), (next, q), (_, r)] = [0, 1, 2].map(|k| (t[(i + k) % 3], points[(i + k) % 3]));
                corner_normals[here as usize] += face * angle_between(q - p, r - p);
                *edge_normals.entry((here.min(next), here.max(next))).or_default() += face;
            }
        }
        let triangle = |&i: &u32| {
            let t = mesh.triangles[i as usize];
            let [a, b, c] = mesh.corners(i as usize);
            let edge = |i: usize| edge_normals[&(t[i].min(t[(i + 1) % 3]), t[i].max(t[(i + 1) % 3]))];
            let corners = t.map(|v| corner_normals[v as usize]);
            let face = unit_normal([a, b, c]);
            Triangle { a, ab: b - a, ac: c - a, face, corners, edges: [edge(0), edge(1), edge(2)] }
        };
        let triangles = own.iter().map(triangle).collect();
        Self { triangles, numbers, balls: own.iter().map(|&i| Ball::around(mesh.corners(i as usize))).collect() }
    }

    /// The numbers here of those of the mesh's `triangles` that are here.
    pub(super) fn numbers(&self, triangles: Vec<u32>) -> impl Iterator<Item = u32> {
        triangles.into_iter().map(|i| self.numbers[i as usize]).filter(|&number| number != Self::ELSEWHERE)
    }

    /// Distance from `p` to triangle `i`.
    pub(super) fn distance(&self, p: DVec3, i: u32) -> f64 {
        self.triangles[i as usize].distance_squared(p).sqrt()
    }

    /// The point of triangle `i` nearest to `p`.
    pub(super) fn nearest_point(&self, p: DVec3, i: u32) -> DVec3 {
        self.triangles[i as usize].nearest(p).0
    }

    /// The half-space against the unit vector `out` that just holds triangle `i`.
    pub(super) fn half_space(&self, out: DVec3, i: u32) -> HalfSpace {
        /// Against rounding (mm).
        const HAIR: f64 = 1e-9;
        let Triangle { a, ab, ac, .. } = &self.triangles[i as usize];
        let furthest = out.dot(*a) + out.dot(*ab).max(out.dot(*ac)).max(0.0);
        HalfSpace { out, at: furthest + HAIR }
    }

    /// Whether triangle `i` is, told at a glance, further than `reach` from `p`.
    #[inline]
    pub(super) fn is_beyond(&self, p: DVec3, i: u32, reach: f64) -> bool {
        let Ball { center, radius } = self.balls[i as usize];
        let reach = reach + radius;
        p.distance_squared(center) > reach * reach
    }

    /// Crossings from inside to outside less those from outside to inside on the way from `from` to `to`.
    pub(super) fn signed_crossings(&self, from: DVec3, to: DVec3, candidates: &[Candidate]) -> i32 {
        let corners = |t: &Triangle| [t.a, t.a + t.ab, t.a + t.ac].map(|q| q - from);
        let triangles = candidates.iter().map(|c| corners(&self.triangles[c.triangle as usize]));
        triangles.filter_map(|t| crossing(t, to - from)).filter(|&(_, share)| share <= 1.0).map(|(sign, _)| sign).sum()
    }

    /// Whether two of these triangles face away from each other, as those of a fold do.
    pub(super) fn any_opposite(&self, candidates: &[Candidate]) -> bool {
        const OPPOSITE: f64 = -0.8;
        let face = |c: &Candidate| self.triangles[c.triangle as usize].face;
        candidates.iter().enumerate().any(|(k, i)| candidates[..k].iter().any(|j| face(i).dot(face(j)) < OPPOSITE))
    }

    /// The nearest of candidates in order of their distance from `center`, given with each: those that are too far from
    /// the centre to be nearest to `p` need not be tested.
    #[inline]
    pub(super) fn nearest_in_order(
        &self,
        p: DVec3,
        center: DVec3,
        candidates: impl Iterator<Item = (f64, u32)>,
    ) -> Nearest {
        let away = p.distance(center);
        let mut best = Nearest::NONE;
        let mut least = f64::INFINITY;
        for (from_center, i) in candidates {
            if from_center - away > least {
                break;
            }
            if self.is_beyond(p, i, least) {
                continue;
            }
            self.take_if_nearer(p, i, &mut best, &mut least);
        }
        best
    }

    /// Takes triangle `i` for the nearest to `p` if it is nearer than `best`; `least` is the distance of the best, or a
    /// hair more: what is as near to the last bit must still be tested.
    #[inline]
    pub(super) fn take_if_nearer(&self, p: DVec3, i: u32, best: &mut Nearest, least: &mut f64) {
        let d = self.triangles[i as usize].distance_squared(p);
        // Ties go to the smaller number, so that the order of the candidates does not matter.
        if d < best.distance_squared || (d == best.distance_squared && i < best.triangle) {
            *best = Nearest { distance_squared: d, triangle: i };
            *least = d.sqrt() * (1.0 + 1e-12);
        }
    }

    /// Signed distance from `p` to its nearest triangle, the point there that is nearest, and the normal in it.
    /// Infinite where there is no nearest.
    pub(super) fn signed(&self, p: DVec3, best: Nearest) -> (f64, DVec3, DVec3) {
        if best.distance_squared.is_infinite() {
            return (f64::INFINITY, p, DVec3::ZERO);
        }
        let triangle = &self.triangles[best.triangle as usize];
        let (nearest, feature) = triangle.nearest(p);
        let normal = match feature {
            Feature::Corner(i) => triangle.corners[i],
            Feature::Edge(i) => triangle.edges[i],
            Feature::Face => triangle.face,
        };
        let distance = best.distance();
        let inside = (p - nearest).dot(normal) < 0.0;
        (if inside { -distance } else { distance }, nearest, normal.normalize_or_zero())
    }
}

impl Triangle {
    #[inline]
    fn distance_squared(&self, p: DVec3) -> f64 {
        p.distance_squared(self.nearest(p).0)
    }

    /// Nearest point by the Voronoi regions of the triangle's features (Ericson, Real-Time Collision Detection,
    /// section 5.1.5).
    #[inline]
    fn nearest(&self, p: DVec3) -> (DVec3, Feature) {
        let Self { a, ab, ac, .. } = *self;
        let ap = p - a;
        let (d1, d2) = (ab.dot(ap), ac.dot(ap));
        if d1 <= 0.0 && d2 <= 0.0 {
            return (a, Feature::Corner(0));
        }
        let bp = ap - ab;
        let (d3, d4) = (ab.dot(bp), ac.dot(bp));
        if d3 >= 0.0 && d4 <= d3 {
            return (a + ab, Feature::Corner(1));
        }
        let vc = d1 * d4 - d3 * d2;
        if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
            return (a + ab * (d1 / (d1 - d3)), Feature::Edge(0));
        }
        let cp = ap - ac;
        let (d5, d6) = (ab.dot(cp), ac.dot(cp));
        if d6 >= 0.0 && d5 <= d6 {
            return (a + ac, Feature::Corner(2));
        }
        let vb = d5 * d2 - d1 * d6;
        if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
            return (a + ac * (d2 / (d2 - d6)), Feature::Edge(2));
        }
        let va = d3 * d6 - d5 * d4;
        if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
            let t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
            return (a + ab + (ac - ab) * t, Feature::Edge(1));
        }
        let scale = 1.0 / (va + vb + vc);
        (a + ab * (vb * scale) + ac * (vc * scale), Feature::Face)
    }
}

fn angle_between(u: DVec3, v: DVec3) -> f64 {
    u.cross(v).length().atan2(u.dot(v))
}
