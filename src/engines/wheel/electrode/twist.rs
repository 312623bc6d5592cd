//! Twisted faces of an electrode, and the rings that are put between its rings where they are.
//!
//! A face of four points a, b, c, d is two triangles of the certified mesh, but part of a smooth face of an exported file.
//! In its middle these are |a - b + c - d| / 4 apart, its twist. Where a fillet begins or ends, the corners of the rings
//! run away from the rows beside them; rings between two rings share their twist.

use super::ring::{Layout, Ring};
use crate::channel::Channel;

/// How far an exported file may lie within the triangles in the middle of a face (mm), before rings are put between.
const MOST_WITHIN: f64 = 0.028;
/// Factor by which all four points of a face are drawn in more than it would lie beyond the triangles.
const DRAWN_IN: f64 = 1.3;
/// Twist that is left where rings are put between (mm): vertices that give way twist faces once more.
const LEFT: f64 = 0.01;
/// Parts that a distance between two rings is divided into at most.
const MOST_PARTS: usize = 12;

/// `rings` with further rings between those whose faces are twisted; none where no face is.
pub(super) fn divided(rings: &[Ring], layout: Layout, channel: &Channel) -> Option<Vec<Ring>> {
    let [first, .., last] = rings else { return None };
    let order = (last.line.along - first.line.along).signum();
    let sense = order * channel.across(&first.line).perp_dot(first.line.up).signum();
    let twists: Vec<Vec<f64>> =
        rings.windows(2).map(|pair| twists([&pair[0], &pair[1]], layout.len(), sense)).collect();
    let within = within(&twists);
    // Faces beside one that is drawn in are drawn in with it.
    let beside = |i: usize| &within[i.saturating_sub(1)..within.len().min(i + 2)];
    let parts = |i: usize| {
        let most = twists[i].iter().fold(0.0, |most: f64, twist| most.max(twist.abs()));
        let is_twisted = beside(i).iter().any(|within| *within > MOST_WITHIN);
        if is_twisted { ((most / LEFT).ceil() as usize).clamp(1, MOST_PARTS) } else { 1 }
    };
    let parts: Vec<usize> = (0..twists.len()).map(parts).collect();
    if parts.iter().all(|parts| *parts == 1) {
        return None;
    }
    let mut all = Vec::new();
    for (pair, parts) in rings.windows(2).zip(parts) {
        all.push(pair[0].clone());
        all.extend((1..parts).map(|k| pair[0].between(&pair[1], k as f64 / parts as f64, channel)));
    }
    all.push(last.clone());
    Some(all)
}

/// How far the middles of the smooth faces between two rings lie beyond the triangles, negative within them (mm).
/// `sense` is 1 where faces from ring to ring in the order of their points look inwards, -1 where they look outwards.
fn twists(rings: [&Ring; 2], n: usize, sense: f64) -> Vec<f64> {
    let twist = |k: usize| {
        let [[a, d], [b, c]] = [k, (k + 1) % n].map(|k| rings.map(|ring| ring.point(k)));
        let outwards = -sense * (c - a).cross(d - b).normalize_or_zero();
        0.25 * (b + d - a - c).dot(outwards)
    };
    (0..n).map(twist).collect()
}

/// How far the file's faces would lie within the triangles between each two rings at most (mm), once those beyond are
/// drawn in.
fn within(twists: &[Vec<f64>]) -> Vec<f64> {
    let n = twists.first().map_or(0, Vec::len);
    // Of point `k` of ring `i`, by the faces around it.
    let drawn_in = |i: usize, k: usize| {
        let around = &twists[i.saturating_sub(1)..twists.len().min(i + 1)];
        let beyond = around.iter().flat_map(|twists| [twists[k], twists[(k + n - 1) % n]]);
        DRAWN_IN * beyond.fold(0.0, f64::max)
    };
    let of_face = |i: usize, k: usize| {
        let corners = [(i, k), (i, (k + 1) % n), (i + 1, k), (i + 1, (k + 1) % n)];
        let drawn_in = corners.iter().map(|&(i, k)| drawn_in(i, k)).fold(0.0, f64::max);
        drawn_in - twists[i][k].min(0.0)
    };
    (0..twists.len()).map(|i| (0..n).map(|k| of_face(i, k)).fold(0.0, f64::max)).collect()
}

#[cfg(test)]
mod tests {
    use super::super::boundary::Spot;
    use super::*;
    use crate::fixtures::exact_channel;
    use crate::parametric::ParametricBlisk;

    const LAYOUT: Layout = Layout { rows: 4, columns: 5 };

    /// A ring whose corner of the low wall and the hub side is `shift` (mm) farther out.
    fn ring(along: f64, shift: f64, channel: &Channel) -> Ring {
        let line = channel.line_at(along);
        let [hub, shroud] = line.ends;
        let mut points = vec![Spot { height: 0.0, theta: 0.0 }; LAYOUT.len()];
        let at = |v: usize, j: usize| Spot {
            height: hub + 0.1 + (shroud - hub - 0.2) * v as f64 / LAYOUT.rows as f64,
            theta: 0.02 * j as f64 / LAYOUT.columns as f64,
        };
        for j in 0..=LAYOUT.columns {
            (points[LAYOUT.hub(j)], points[LAYOUT.shroud(j)]) = (at(0, j), at(LAYOUT.rows, j));
        }
        for v in 0..=LAYOUT.rows {
            (points[LAYOUT.low(v)], points[LAYOUT.high(v)]) = (at(v, 0), at(v, LAYOUT.columns));
        }
        points[0].theta -= shift / line.radius(points[0].height);
        Ring { line, points }
    }

    /// The diagonals of the faces run the other way from the other end, so that there the smooth face lies beyond them.
    #[test]
    fn what_lies_beyond_is_told_from_what_lies_within() {
        let channel = exact_channel(&ParametricBlisk::default());
        let [a, b] = [ring(2.0, 0.0, &channel), ring(3.0, 0.1, &channel)];
        let least_and_most = |rings: [&Ring; 2], sense: f64| {
            let twists = twists(rings, LAYOUT.len(), sense);
            [twists.iter().copied().fold(0.0, f64::min), twists.iter().copied().fold(0.0, f64::max)]
        };
        let [within, beyond] = [least_and_most([&a, &b], 1.0)[0], least_and_most([&b, &a], -1.0)[1]];
        assert!((within + 0.025).abs() < 2e-3 && (beyond - 0.025).abs() < 2e-3, "{within} {beyond}");
    }

    #[test]
    fn rings_are_put_between_where_a_corner_runs_away_and_nowhere_else() {
        let channel = exact_channel(&ParametricBlisk::default());
        let at = |k: usize| 2.0 + 0.6 * k as f64;
        // The corner runs 0.8 mm out between the second and the third ring, a quarter of it for the middle of the face.
        let shifts = [0.0, 0.0, 0.8, 0.8];
        let forward: Vec<Ring> = shifts.iter().enumerate().map(|(k, shift)| ring(at(k), *shift, &channel)).collect();
        let backward: Vec<Ring> = forward.iter().rev().cloned().collect();
        let more = [forward, backward].map(|rings| {
            let divided = divided(&rings, LAYOUT, &channel).unwrap();
            assert!(super::divided(&divided, LAYOUT, &channel).is_none(), "they are still twisted");
            assert!(rings.iter().all(|ring| divided.contains(ring)));
            let new: Vec<f64> = divided.iter().filter(|r| !rings.contains(r)).map(|r| r.line.along).collect();
            assert!(new.iter().all(|along| (at(1)..at(2)).contains(along)), "{new:?}");
            new.len()
        });
        assert!(more.iter().all(|more| (5..MOST_PARTS).contains(more)), "{more:?}");
        let even: Vec<Ring> = (0..4).map(|k| ring(at(k), 0.8, &channel)).collect();
        assert!(divided(&even, LAYOUT, &channel).is_none());
    }
}
