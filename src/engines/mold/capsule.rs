//! Where a cutter's centre, on its way along a line or around a corner, comes too near to a side: P3's I-region.
//!
//! All points nearer than the radius to a segment make a capsule. Its boundary is two half circles and two lines, so
//! where a straight line or a circle enters and leaves it is known exactly.

use glam::DVec2;

use super::outline::off_segment;

/// An open interval of a parameter.
pub type Interval = [f64; 2];

/// How much nearer than the radius counts as too near (mm): rounding.
const ROUNDING: f64 = 1e-9;

/// Intervals of `t` in `[0, length]` where `from + t along` (`along` of length 1) is nearer than `radius` to the
/// segment.
pub fn on_line(from: DVec2, along: DVec2, length: f64, segment: [DVec2; 2], radius: f64, blocked: &mut Vec<Interval>) {
    let [a, b] = segment;
    let mut cuts = vec![0.0, length];
    for end in [a, b] {
        // |from + t along - end| = radius.
        let to = end - from;
        let middle = to.dot(along);
        let half = radius * radius - (to.length_squared() - middle * middle);
        if half > 0.0 {
            cuts.extend([middle - half.sqrt(), middle + half.sqrt()]);
        }
    }
    let side = (b - a).normalize_or_zero();
    let steep = side.perp_dot(along);
    if steep.abs() > 1e-12 {
        let off = side.perp_dot(from - a);
        cuts.extend([(radius - off) / steep, (-radius - off) / steep]);
    }
    collect(cuts, 0.0, length, |t| off_segment(from + along * t, a, b) < radius - ROUNDING, blocked);
}

/// Part of a circle on which the cutter's centre turns about a corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arc {
    /// The corner.
    pub center: DVec2,
    /// How far off it the cutter's centre is (mm).
    pub radius: f64,
    /// Direction to where it begins (rad).
    pub first: f64,
    /// How far it turns, counter-clockwise (rad).
    pub turn: f64,
}

/// Intervals of the angle from its beginning where `arc` is nearer than `radius` to the segment.
pub fn on_arc(arc: Arc, segment: [DVec2; 2], radius: f64, blocked: &mut Vec<Interval>) {
    let Arc { center, radius: own, first, turn } = arc;
    let [a, b] = segment;
    let mut angles = Vec::new();
    for end in [a, b] {
        // Where two circles meet: the law of cosines.
        let to = end - center;
        let off = to.length();
        let cosine = (own * own + off * off - radius * radius) / (2.0 * own * off);
        if cosine.abs() < 1.0 {
            angles.extend([to.to_angle() + cosine.acos(), to.to_angle() - cosine.acos()]);
        }
    }
    let side = (b - a).normalize_or_zero();
    let off = side.perp_dot(center - a);
    for level in [radius, -radius] {
        // off + own radius * sin(angle - angle of the side) = level.
        let sine = (level - off) / own;
        if sine.abs() <= 1.0 {
            let (at, half) = (side.to_angle(), sine.asin());
            angles.extend([at + half, at + std::f64::consts::PI - half]);
        }
    }
    let mut cuts = vec![0.0, turn];
    cuts.extend(angles.into_iter().map(|angle| (angle - first).rem_euclid(std::f64::consts::TAU)));
    let at = |angle: f64| center + DVec2::from_angle(first + angle) * own;
    collect(cuts, 0.0, turn, |angle| off_segment(at(angle), a, b) < radius - ROUNDING, blocked);
}

/// Of the intervals between the `cuts` within `[from, to]` those whose middle is blocked.
fn collect(mut cuts: Vec<f64>, from: f64, to: f64, is_blocked: impl Fn(f64) -> bool, blocked: &mut Vec<Interval>) {
    cuts.retain(|t| (from..=to).contains(t));
    cuts.sort_by(f64::total_cmp);
    let between = cuts.windows(2).map(|w| [w[0], w[1]]);
    blocked.extend(between.filter(|[a, b]| b > a && is_blocked(0.5 * (a + b))));
}

/// Free parts of `[0, length]` between the `blocked` intervals, touching ones joined, in order.
pub fn free_between(blocked: &mut [Interval], length: f64) -> Vec<Interval> {
    blocked.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let (mut free, mut at) = (Vec::new(), 0.0f64);
    for &[from, to] in blocked.iter() {
        if from > at + ROUNDING {
            free.push([at, from]);
        }
        at = at.max(to);
    }
    if length > at + ROUNDING {
        free.push([at, length]);
    }
    free
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn within(intervals: &[Interval], t: f64) -> bool {
        intervals.iter().any(|[a, b]| *a < t && t < *b)
    }

    proptest! {
        #[test]
        fn intervals_are_where_the_distance_says(
            a in prop::array::uniform2(-3.0..3.0f64), b in prop::array::uniform2(-3.0..3.0f64),
            c in prop::array::uniform2(-3.0..3.0f64), angle in -3.0..3.0f64, turn in 0.1..3.0f64, radius in 0.2..2.0f64,
            own in 0.2..2.0f64,
        ) {
            let (segment, c) = ([DVec2::from(a), DVec2::from(b)], DVec2::from(c));
            let (mut line, mut arc) = (Vec::new(), Vec::new());
            let along = DVec2::from_angle(angle);
            on_line(c, along, 4.0, segment, radius, &mut line);
            on_arc(Arc { center: c, radius: own, first: angle, turn }, segment, radius, &mut arc);
            for k in 0..97 {
                let share = (f64::from(k) + 0.5) / 97.0;
                let checks = [
                    (c + along * 4.0 * share, &line, 4.0 * share),
                    (c + DVec2::from_angle(angle + turn * share) * own, &arc, turn * share),
                ];
                for (p, intervals, t) in checks {
                    let off = off_segment(p, segment[0], segment[1]) - radius;
                    prop_assume!(off.abs() > 1e-6);
                    prop_assert_eq!(within(intervals, t), off < 0.0, "{} {}", t, off);
                }
            }
        }
    }

    #[test]
    fn what_is_free_lies_between_what_is_blocked() {
        let free = free_between(&mut [[3.0, 4.0], [0.0, 1.0], [0.5, 2.0]], 5.0);
        assert_eq!(free, [[2.0, 3.0], [4.0, 5.0]]);
        assert_eq!(free_between(&mut [[0.0, 5.0]], 5.0), Vec::<Interval>::new());
        assert_eq!(free_between(&mut [], 1.0), [[0.0, 1.0]]);
    }
}
