//! Circles inscribed between two curves of a plane: tangent to both, with their centres on the middle line.

use glam::DVec3;

use geometry::nurbs::{NearestOnCurve, NurbsCurve};

/// A circle that touches both curves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct InscribedCircle {
    /// Centre of the circle.
    pub center: DVec3,
    /// Radius of the circle.
    pub radius: f64,
    /// Parameters of its points of contact on the low and on the high curve.
    pub contacts: [f64; 2],
}

/// Two curves in the plane z = 0, the channel between them.
pub(super) struct CurvePair {
    low: Looked,
    high: Looked,
}

/// A curve with points on it to start searches from.
struct Looked {
    curve: NurbsCurve,
    places: Vec<(f64, DVec3)>,
}

impl Looked {
    const PLACES: usize = 256;

    fn new(curve: NurbsCurve) -> Self {
        let [start, end] = curve.domain();
        let at = |i: usize| start + (end - start) * i as f64 / Self::PLACES as f64;
        let places = (0..=Self::PLACES).map(|i| (at(i), curve.point(at(i)))).collect();
        Self { curve, places }
    }

    fn nearest(&self, p: DVec3) -> NearestOnCurve {
        let distance = |i: &usize| self.places[*i].1.distance_squared(p);
        let best = (0..self.places.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0);
        let within = [best.saturating_sub(1), (best + 1).min(self.places.len() - 1)];
        self.curve.nearest_between(p, self.places[best].0, within.map(|i| self.places[i].0))
    }
}

impl CurvePair {
    /// Circles looked for along the low curve before its covered part is known.
    const LOOKS: usize = 64;

    /// The passage between two curves that run the same way.
    pub fn new(low: NurbsCurve, high: NurbsCurve) -> Self {
        Self { low: Looked::new(low), high: Looked::new(high) }
    }

    /// Up to `count` circles in order along the covered part of the passage, where a circle has a point of contact on
    /// both curves: as many as fit, at least half of them. None where there is no such part.
    pub fn circles(&self, count: usize) -> Option<Vec<InscribedCircle>> {
        let [start, end] = self.low.curve.domain();
        let at = |i: usize| start + (end - start) * i as f64 / Self::LOOKS as f64;
        let fits = |i: &usize| self.circle(at(*i)).is_some();
        let first = (0..=Self::LOOKS).find(fits)?;
        let last = (first..=Self::LOOKS).rev().find(fits)?;
        let from = if first == 0 { start } else { self.edge(at(first), at(first - 1)) };
        let to = if last == Self::LOOKS { end } else { self.edge(at(last), at(last + 1)) };
        let steps = count.max(2) - 1;
        let place = |i: usize| if i == steps { to } else { from + (to - from) * i as f64 / steps as f64 };
        let circles: Vec<InscribedCircle> = (0..=steps).filter_map(|i| self.circle(place(i))).collect();
        (2 * circles.len() >= count).then_some(circles)
    }

    /// Circles along the passage, each touching the one before, as many as there is room for.
    pub fn chain(&self) -> Vec<InscribedCircle> {
        const STEPS: usize = 256;
        let [start, end] = self.low.curve.domain();
        let at = |i: usize| start + (end - start) * i as f64 / STEPS as f64;
        let all: Vec<InscribedCircle> = (0..=STEPS).filter_map(|i| self.circle(at(i))).collect();
        let gap = |a: &InscribedCircle, b: &InscribedCircle| a.center.distance(b.center) - a.radius - b.radius;
        let mut chain = Vec::from_iter(all.first().copied());
        while let Some(last) = chain.last().copied() {
            let is_beyond = |c: &&InscribedCircle| c.contacts[0] > last.contacts[0] && gap(&last, c) > 0.0;
            let Some(beyond) = all.iter().find(is_beyond) else { break };
            let (mut near, mut far) = (last, *beyond);
            for _ in 0..60 {
                let Some(middle) = self.circle(0.5 * (near.contacts[0] + far.contacts[0])) else { break };
                if gap(&last, &middle) > 0.0 {
                    far = middle;
                } else {
                    near = middle;
                }
            }
            chain.push(far);
        }
        chain
    }

    /// The last parameter from `good` towards `bad` with a circle.
    fn edge(&self, good: f64, bad: f64) -> f64 {
        let (mut good, mut bad) = (good, bad);
        for _ in 0..50 {
            let middle = 0.5 * (good + bad);
            if self.circle(middle).is_some() {
                good = middle;
            } else {
                bad = middle;
            }
        }
        good
    }

    /// The circle that touches the low curve at `u` and the high curve anywhere but beyond its ends.
    fn circle(&self, u: f64) -> Option<InscribedCircle> {
        /// Cosine of the angle between spoke and curve up to which the contact counts as a tangent's.
        const SQUARE: f64 = 1e-6;
        /// How much nearer the low curve may be elsewhere, as a share of the radius: walls measured on a mesh have
        /// its facets in them.
        const ROUGH: f64 = 0.02;
        let [p, along, _] = self.low.curve.at(u);
        let across = DVec3::new(-along.y, along.x, 0.0).normalize_or_zero();
        let inward = if across.dot(self.high.nearest(p).point - p) < 0.0 { -across } else { across };
        let radius = self.radius(p, inward);
        let center = p + inward * radius;
        let foot = self.high.nearest(center);
        let tangent = self.high.curve.tangent(foot.u);
        let touches = (foot.distance - radius).abs() < 1e-9 * (1.0 + radius)
            && (center - foot.point).dot(tangent).abs() <= SQUARE * radius;
        // Where the low curve bends into the circle it is nearer elsewhere.
        let clear = self.low.nearest(center).distance >= radius * (1.0 - ROUGH);
        (touches && clear && radius > 0.0).then_some(InscribedCircle { center, radius, contacts: [u, foot.u] })
    }

    /// How far to go from `p` along `inward` to be as far from the high curve as from `p`: by Newton's method on the
    /// difference, which only falls on the way, within a bracket that is halved where that fails.
    fn radius(&self, p: DVec3, inward: DVec3) -> f64 {
        const ROUNDS: usize = 80;
        let difference = |radius: f64| {
            let center = p + inward * radius;
            let foot = self.high.nearest(center);
            let spoke = (center - foot.point) / foot.distance.max(1e-300);
            (foot.distance - radius, inward.dot(spoke) - 1.0)
        };
        // The distance to p itself grows as fast as the radius, that to the high curve at most as fast.
        let (mut low, mut high) = (0.0, self.high.nearest(p).distance);
        while difference(high).0 > 0.0 && high < 1e6 {
            (low, high) = (high, 2.0 * high);
        }
        let mut radius = 0.5 * (low + high);
        for _ in 0..ROUNDS {
            let (value, slope) = difference(radius);
            if value > 0.0 {
                low = radius;
            } else {
                high = radius;
            }
            let newton = radius - value / slope;
            let next = if (low..=high).contains(&newton) { newton } else { 0.5 * (low + high) };
            if (next - radius).abs() <= 1e-14 * (1.0 + radius) {
                return next;
            }
            radius = next;
        }
        radius
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(f: impl Fn(f64) -> DVec3) -> NurbsCurve {
        let points: Vec<DVec3> = (0..=80).map(|i| f(f64::from(i) / 80.0)).collect();
        NurbsCurve::through(&points, 5).unwrap()
    }

    #[test]
    fn between_concentric_arcs_the_circles_lie_on_the_arc_half_way() {
        let arc = |radius: f64| curve(move |t| DVec3::new(radius * (t - 0.5).sin(), radius * (t - 0.5).cos(), 0.0));
        let passage = CurvePair::new(arc(36.0), arc(44.0));
        let circles = passage.circles(41).unwrap();
        for circle in &circles {
            assert!((circle.center.length() - 40.0).abs() < 1e-7, "{}", circle.center.length());
            assert!((circle.radius - 4.0).abs() < 1e-7);
        }
        let length: f64 = circles.windows(2).map(|w| w[0].center.distance(w[1].center)).sum();
        assert!((length - 40.0).abs() < 1e-2, "the whole arc is covered: {length}");
    }

    #[test]
    fn between_concentric_arcs_circles_in_a_chain_stand_their_diameter_apart() {
        let arc = |radius: f64| curve(move |t| DVec3::new(radius * (t - 0.5).sin(), radius * (t - 0.5).cos(), 0.0));
        let chain = CurvePair::new(arc(36.0), arc(44.0)).chain();
        // One radian holds steps of 2 asin(4 / 40) each.
        assert_eq!(chain.len(), 5);
        for pair in chain.windows(2) {
            assert!((pair[0].center.distance(pair[1].center) - 8.0).abs() < 1e-6);
            assert!((pair[1].center.length() - 40.0).abs() < 1e-7);
        }
    }

    #[test]
    fn between_straight_lines_the_circles_lie_on_the_bisector_where_both_have_a_foot() {
        // A wedge opening from the origin, the low line twice as long.
        let (low, high) = (0.1f64, 0.3f64);
        let line = |angle: f64, from: f64, to: f64| {
            curve(move |t| DVec3::new(angle.cos(), angle.sin(), 0.0) * (from + (to - from) * t))
        };
        let circles = CurvePair::new(line(low, 10.0, 50.0), line(high, 20.0, 40.0)).circles(21).unwrap();
        for circle in &circles {
            let angle = circle.center.y.atan2(circle.center.x);
            assert!((angle - 0.2).abs() < 1e-9);
            assert!((circle.radius - circle.center.length() * 0.1f64.sin()).abs() < 1e-9);
        }
        // Contacts are as far from the origin on one line as on the other.
        let ends = [0, 20].map(|i| circles[i].center.length() * 0.1f64.cos());
        assert!((ends[0] - 20.0).abs() < 1e-3 && (ends[1] - 40.0).abs() < 1e-3, "{ends:?}");
        let apart = CurvePair::new(line(low, 10.0, 15.0), line(high, 20.0, 40.0));
        assert_eq!(apart.circles(5), None);
    }
}
