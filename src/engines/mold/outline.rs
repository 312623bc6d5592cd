//! Closed outlines in a horizontal plane.

use glam::DVec2;
use serde::{Deserialize, Serialize};

/// A closed polygon without repeated points; whatever it bounds lies on its left.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Outline {
    points: Vec<DVec2>,
}

impl Outline {
    /// The polygon through `points`, repeated neighbours left out; none if fewer than three remain.
    pub fn new(mut points: Vec<DVec2>) -> Option<Self> {
        points.dedup();
        while points.len() > 1 && points.first() == points.last() {
            points.pop();
        }
        (points.len() > 2).then_some(Self { points })
    }

    /// The same polygon run through backwards, so that it bounds what it did not.
    pub fn reversed(&self) -> Self {
        Self { points: self.points.iter().rev().copied().collect() }
    }

    /// Corners in order.
    pub fn points(&self) -> &[DVec2] {
        &self.points
    }

    /// Sides in order, each from corner to corner.
    pub fn sides(&self) -> impl ExactSizeIterator<Item = [DVec2; 2]> + '_ {
        let n = self.points.len();
        (0..n).map(move |i| [self.points[i], self.points[(i + 1) % n]])
    }

    /// The area on its left: positive where it runs counter-clockwise (mm^2).
    pub fn area(&self) -> f64 {
        let o = self.points[0];
        0.5 * self.sides().map(|[p, q]| (p - o).perp_dot(q - o)).sum::<f64>()
    }

    /// Length of all sides (mm).
    pub fn length(&self) -> f64 {
        self.sides().map(|[p, q]| p.distance(q)).sum()
    }

    /// Whether it turns left at every corner, once around.
    pub fn is_convex(&self) -> bool {
        let n = self.points.len();
        let at = |i: usize| self.points[i % n];
        let turns = (0..n).map(|i| (at(i + 1) - at(i)).angle_to(at(i + 2) - at(i + 1)));
        let (least, sum) = turns.fold((0.0f64, 0.0), |(least, sum), turn| (least.min(turn), sum + turn));
        least >= 0.0 && sum < 1.5 * std::f64::consts::TAU
    }

    /// The longest of its sides, the first of them.
    pub fn longest_side(&self) -> [DVec2; 2] {
        let length = |[p, q]: [DVec2; 2]| p.distance_squared(q);
        let first = [self.points[0], self.points[1]];
        self.sides().fold(first, |best, side| if length(side) > length(best) { side } else { best })
    }

    /// How often it winds around `p`, which does not lie on it.
    pub fn winding(&self, p: DVec2) -> i32 {
        let turn = |[a, b]: [DVec2; 2]| match (a.y <= p.y, b.y <= p.y) {
            (true, false) if (b - a).perp_dot(p - a) > 0.0 => 1,
            (false, true) if (b - a).perp_dot(p - a) < 0.0 => -1,
            _ => 0,
        };
        self.sides().map(turn).sum()
    }
}

/// A closed polygon without the points that lie on the line between those that are kept, to within `within` (mm).
pub fn without_straight_points(points: &[DVec2], within: f64) -> Vec<DVec2> {
    let n = points.len();
    if n < 4 {
        return points.to_vec();
    }
    // Begin at a corner that stays: the one furthest from the middle.
    let middle = points.iter().sum::<DVec2>() / n as f64;
    let off = |i: usize| points[i].distance_squared(middle);
    let first = (0..n).fold(0, |best, i| if off(i) > off(best) { i } else { best });
    let (mut kept, mut last) = (vec![points[first]], 0);
    for i in 1..=n {
        let at = |k: usize| points[(first + k) % n];
        let (from, to) = (at(last), at((i + 1).min(n)));
        let on_line = (last + 1..=i).all(|k| off_segment(at(k), from, to) <= within);
        if i < n && (!on_line || i - last > 64) {
            kept.push(at(i));
            last = i;
        }
    }
    kept
}

/// Distance of a point to a segment (mm).
pub fn off_segment(p: DVec2, a: DVec2, b: DVec2) -> f64 {
    let along = b - a;
    let length = along.length_squared();
    let t = if length > 0.0 { ((p - a).dot(along) / length).clamp(0.0, 1.0) } else { 0.0 };
    p.distance(a + along * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(side: f64) -> Vec<DVec2> {
        [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec2::new(x, y) * side).to_vec()
    }

    #[test]
    fn areas_and_windings_have_their_sign() {
        let outline = Outline::new(square(2.0)).unwrap();
        let turned = outline.reversed();
        assert_eq!((outline.area(), turned.area(), outline.length()), (4.0, -4.0, 8.0));
        assert_eq!([outline.is_convex(), turned.is_convex()], [true, false]);
        assert_eq!([outline.winding(DVec2::ONE), turned.winding(DVec2::ONE)], [1, -1]);
        assert_eq!(outline.winding(DVec2::new(3.0, 1.0)), 0);
        assert!(Outline::new(vec![DVec2::ZERO, DVec2::ZERO, DVec2::X, DVec2::ZERO]).is_none());
    }

    #[test]
    fn points_on_straight_lines_go_and_corners_stay() {
        let corners = square(3.0);
        let mut points = Vec::new();
        for i in 0..4 {
            let (a, b) = (corners[i], corners[(i + 1) % 4]);
            points.extend((0..10).map(|k| a.lerp(b, f64::from(k) / 10.0) + 1e-7 * f64::from(k % 2)));
        }
        let kept = without_straight_points(&points, 1e-6);
        assert_eq!(kept.len(), 4, "{kept:?}");
        assert!(kept.iter().all(|p| corners.iter().any(|c| c.distance(*p) < 1e-6)));
    }
}
