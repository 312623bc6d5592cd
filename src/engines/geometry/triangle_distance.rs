//! The exact distance between two triangles, with the points where it occurs.
//!
//! Two triangles that do not meet come closest either between two edges or between a vertex and the inside of
//! a face, so fifteen small problems answer the question; a further test finds edges that pierce a face.
//! Degenerate triangles (segments and points) are valid input. Both witness points are convex combinations of
//! corners, so the distance told can be trusted as an upper bound whatever the rounding.

use glam::DVec3;

use super::mesh::normal_times_two_areas;

/// A point of each of two sets, where they are (or may be taken as) closest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClosestPoints {
    /// Distance between the two points (mm).
    pub distance: f64,
    /// The point of the first set.
    pub first: DVec3,
    /// The point of the second set.
    pub second: DVec3,
}

impl ClosestPoints {
    /// Further apart than any two points.
    pub const NONE: Self = Self { distance: f64::INFINITY, first: DVec3::ZERO, second: DVec3::ZERO };

    fn between(first: DVec3, second: DVec3) -> Self {
        Self { distance: first.distance(second), first, second }
    }

    fn swapped(self) -> Self {
        Self { first: self.second, second: self.first, ..self }
    }

    /// The closer of two; `self` if they are equal.
    pub fn closer(self, other: Self) -> Self {
        if other.distance < self.distance { other } else { self }
    }
}

/// The closest points of two triangles given by their corners; distance 0 when they touch or cross.
pub fn triangle_distance(first: &[DVec3; 3], second: &[DVec3; 3]) -> ClosestPoints {
    let mut best = ClosestPoints::NONE;
    for i in 0..3 {
        for j in 0..3 {
            let (p, q) = ([first[i], first[(i + 1) % 3]], [second[j], second[(j + 1) % 3]]);
            best = best.closer(segment_distance(p, q));
        }
    }
    let to_second = corners_to_face(first, second);
    if to_second.distance == 0.0 {
        return to_second;
    }
    best.closer(to_second).closer(corners_to_face(second, first).swapped())
}

/// The closest points of two segments given by their ends.
pub fn segment_distance([p0, p1]: [DVec3; 2], [q0, q1]: [DVec3; 2]) -> ClosestPoints {
    let (u, v, r) = (p1 - p0, q1 - q0, q0 - p0);
    let (uu, vv) = (u.length_squared(), v.length_squared());
    let across = u.cross(v);
    // The cross product, unlike uu * vv - (u.v)^2, keeps its digits when the segments are nearly parallel.
    let s = ratio(r.cross(v).dot(across), across.length_squared());
    let t = ratio((p0 + u * s - q0).dot(v), vv);
    let s = ratio((q0 + v * t - p0).dot(u), uu);
    ClosestPoints::between(p0 + u * s, q0 + v * t)
}

/// `a / b` clamped to [0, 1], and 0 where `b` vanishes.
fn ratio(a: f64, b: f64) -> f64 {
    if b > 0.0 { (a / b).clamp(0.0, 1.0) } else { 0.0 }
}

/// The closest points among: each corner of `triangle` with its foot on `face` where that lies inside it, and
/// each point where an edge of `triangle` pierces `face`.
fn corners_to_face(triangle: &[DVec3; 3], face: &[DVec3; 3]) -> ClosestPoints {
    let plane = FacePlane::new(face);
    let heights = triangle.map(|p| plane.normal.dot(p - face[0]));
    let mut best = ClosestPoints::NONE;
    for i in 0..3 {
        let j = (i + 1) % 3;
        if let Some(foot) = plane.point_above(triangle[i]) {
            best = best.closer(ClosestPoints::between(triangle[i], foot));
        }
        if heights[i] * heights[j] < 0.0 {
            let crossing = triangle[i].lerp(triangle[j], heights[i] / (heights[i] - heights[j]));
            if plane.point_above(crossing).is_some() {
                return ClosestPoints { distance: 0.0, first: crossing, second: crossing };
            }
        }
    }
    best
}

/// A face with what projecting points onto it needs.
struct FacePlane {
    origin: DVec3,
    u: DVec3,
    v: DVec3,
    normal: DVec3,
    scale: f64,
}

impl FacePlane {
    fn new(face: &[DVec3; 3]) -> Self {
        let normal = normal_times_two_areas(*face);
        let scale = 1.0 / normal.length_squared();
        Self { origin: face[0], u: face[1] - face[0], v: face[2] - face[0], normal, scale }
    }

    /// The foot of the perpendicular from `p`, if it lies on the face. None for a degenerate face, whose edges
    /// say all there is to say.
    fn point_above(&self, p: DVec3) -> Option<DVec3> {
        let r = p - self.origin;
        let a = r.cross(self.v).dot(self.normal) * self.scale;
        let b = self.u.cross(r).dot(self.normal) * self.scale;
        (a >= 0.0 && b >= 0.0 && a + b <= 1.0).then(|| self.origin + self.u * a + self.v * b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use parry3d_f64::math::Pose;
    use parry3d_f64::query;
    use parry3d_f64::shape::Triangle;
    use proptest::prelude::*;

    fn point(range: f64) -> impl Strategy<Value = DVec3> {
        let c = move || -range..range;
        (c(), c(), c()).prop_map(|(x, y, z)| DVec3::new(x, y, z))
    }

    fn triangle() -> impl Strategy<Value = [DVec3; 3]> {
        [point(3.0), point(3.0), point(3.0)]
    }

    /// The least distance of a point of a fine grid on `a` to `b`, each by plain projection onto the plane and
    /// the three edges.
    fn sampled(a: &[DVec3; 3], b: &[DVec3; 3], n: usize) -> f64 {
        let mut least = f64::INFINITY;
        for i in 0..=n {
            for j in 0..=n - i {
                let (u, v) = (i as f64 / n as f64, j as f64 / n as f64);
                let p = a[0] + (a[1] - a[0]) * u + (a[2] - a[0]) * v;
                let by_edges = (0..3).map(|k| {
                    let (q, e) = (b[k], b[(k + 1) % 3] - b[k]);
                    (p - q - e * ((p - q).dot(e) / e.dot(e)).clamp(0.0, 1.0)).length()
                });
                least = by_edges.fold(least, f64::min);
                let normal = normal_times_two_areas(*b).normalize();
                let foot = p - normal * normal.dot(p - b[0]);
                let inside = (0..3).all(|k| (b[(k + 1) % 3] - b[k]).cross(foot - b[k]).dot(normal) >= 0.0);
                least = if inside { least.min(normal.dot(p - b[0]).abs()) } else { least };
            }
        }
        least
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(400))]

        #[test]
        fn agrees_with_another_library(a in triangle(), b in triangle()) {
            let shape = |t: [DVec3; 3]| Triangle::new(t[0], t[1], t[2]);
            let expected = query::distance(&Pose::IDENTITY, &shape(a), &Pose::IDENTITY, &shape(b)).unwrap().distance;
            let found = triangle_distance(&a, &b);
            // The other library iterates, to about the square root of the machine's precision.
            prop_assert!((found.distance - expected).abs() < 1e-6, "{} {expected}", found.distance);
            prop_assert!((found.first.distance(found.second) - found.distance).abs() < 1e-12);
        }

        #[test]
        fn agrees_with_dense_sampling(a in triangle(), b in triangle()) {
            let n = 60;
            let edge = (0..3).map(|i| a[i].distance(a[(i + 1) % 3])).fold(0.0, f64::max);
            let (found, sampled) = (triangle_distance(&a, &b).distance, sampled(&a, &b, n));
            prop_assert!(found <= sampled + 1e-9 && sampled <= found + edge / n as f64, "{found} {sampled}");
        }

        #[test]
        fn is_symmetric_and_blind_to_the_order_of_corners(a in triangle(), b in triangle()) {
            let d = triangle_distance(&a, &b).distance;
            prop_assert!((triangle_distance(&b, &a).distance - d).abs() < 1e-9);
            prop_assert!((triangle_distance(&[a[1], a[2], a[0]], &[b[2], b[1], b[0]]).distance - d).abs() < 1e-9);
        }

        #[test]
        fn degenerate_triangles_are_segments_and_points(a in [point(3.0), point(3.0)], b in triangle(), t in 0.0..1.0) {
            let on_segment = a[0].lerp(a[1], t);
            let flat = triangle_distance(&[a[0], on_segment, a[1]], &b);
            let point = triangle_distance(&[a[0]; 3], &b);
            prop_assert!(flat.distance.is_finite() && flat.distance <= point.distance + 1e-9);
            // A segment is also the limit of ever thinner triangles.
            let thin = triangle_distance(&[a[0], a[1], a[1] + DVec3::splat(1e-7)], &b);
            prop_assert!((thin.distance - flat.distance).abs() < 1e-6, "{} {}", thin.distance, flat.distance);
        }
    }

    #[test]
    fn nearly_parallel_edges_keep_their_digits() {
        for angle in [0.0, 1e-15, 1e-12, 1e-9, 1e-7, 1e-5] {
            let p = [DVec3::new(-13.0, 0.0, 0.0), DVec3::new(13.0, 0.0, 0.0)];
            let d = DVec3::new(f64::cos(angle), f64::sin(angle), 0.0) * 13.0;
            let middle = DVec3::new(0.0, 0.0, 0.1);
            let found = segment_distance(p, [middle - d, middle + d]);
            assert!((found.distance - 0.1).abs() < 1e-12, "{angle}: {}", found.distance);
        }
    }

    #[test]
    fn triangles_that_cross_are_at_distance_zero() {
        let flat = [DVec3::ZERO, DVec3::X * 2.0, DVec3::Y * 2.0];
        let through = [DVec3::new(0.5, 0.5, -1.0), DVec3::new(0.6, 0.5, 1.0), DVec3::new(0.5, 0.6, 1.0)];
        assert_eq!(triangle_distance(&flat, &through).distance, 0.0);
        let coplanar = flat.map(|p| p + DVec3::new(0.2, 0.2, 0.0));
        assert!(triangle_distance(&flat, &coplanar).distance < 1e-12);
    }
}
