//! Figures of a channel: its narrowest place, how much it turns, and the faces of the blisk.

use std::ops::Range;

use glam::{DMat3, DVec2, DVec3};
use nalgebra::{Matrix3, Vector3};
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::Triangle;
use rayon::prelude::*;

use super::super::channel::{BladeSide, ChannelWall, Flow, Station, Throat};
use super::super::frame::slices::cylindrical_components;
use geometry::frame::Cylindrical;
use geometry::mesh::Mesh;
use task::{Cancel, Cancelled};

/// A middle line that turns by less than this (rad), or by less than from one facet to the next, is straight: facets tell
/// no more, up to the second of these.
const STRAIGHT: [f64; 2] = [0.0175, 0.07];
/// Shares of the passage behind an end of the blades over which their angle there is measured: behind the rounding of their
/// edges.
const AT_END: Range<f64> = 0.04..0.3;

/// The narrowest place between the blades of two walls of equal grids, from end wall to end wall without their fillets, to
/// the accuracy with which the grids' triangles follow the walls. The first and the last row lie `beyond` steps from row to
/// row away from hub and shroud; the first and the last `added` columns lie beyond the blades' edges.
///
/// # Errors
/// [`Cancelled`].
pub(super) fn throat(
    [low, high]: [&ChannelWall; 2],
    beyond: f64,
    added: usize,
    cancel: &Cancel,
) -> Result<Throat, Cancelled> {
    let [low, high] = &[low, high].map(|wall| bare(&sharp(wall.clone()), beyond, added));
    let nearest_point = |u: usize, v: usize| {
        let p = low.point(u, v);
        let far = |&i: &usize| (high.points[i] - p).length_squared();
        (0..high.points.len()).min_by(|a, b| far(a).total_cmp(&far(b))).unwrap_or(0)
    };
    // From the closest pair of points of every row the two feet are let slide to rest.
    let of_row = |v: usize| {
        cancel.check()?;
        let pairs = (0..low.nu).map(|u| (u * low.nv + v, nearest_point(u, v)));
        let gap = |&(i, j): &(usize, usize)| (low.points[i] - high.points[j]).length_squared();
        let (i, j) = pairs.min_by(|a, b| gap(a).total_cmp(&gap(b))).unwrap_or((0, 0));
        Ok(slide_to_rest(low, high, i, j))
    };
    let rows: Vec<Throat> = (0..low.nv).into_par_iter().map(of_row).collect::<Result<_, _>>()?;
    let none = Throat { width_mm: f64::INFINITY, on_low_wall: DVec3::ZERO, on_high_wall: DVec3::ZERO };
    Ok(rows.into_iter().fold(none, |best, t| if t.width_mm < best.width_mm { t } else { best }))
}

/// A wall from end wall to end wall, of which the first row lies `beyond` steps from row to row away, without its
/// fillets: in their place the blade goes on straight to the end wall. In a fillet the wall turns from row to row, or a
/// row begins further along the passage than those beside it, and it stands into the passage.
fn bare(wall: &ChannelWall, beyond: f64, added: usize) -> ChannelWall {
    let last = wall.nv - 1;
    let nv = wall.nv + 2;
    let ends = [true, false].map(|is_hub| WallEnd::new(wall, is_hub));
    let ends = ends.map(|end| (end.fillet_rows(added), end));
    let mut points = Vec::with_capacity(wall.nu * nv);
    let mut normals = Vec::with_capacity(wall.nu * nv);
    for u in 0..wall.nu {
        let rows = || (0..nv).map(|v| v.saturating_sub(1).min(last));
        let mut column: Vec<DVec3> = rows().map(|v| wall.point(u, v)).collect();
        for (fillet_rows, end) in &ends {
            let beside = fillet_rows[u];
            let (p, step) = end.goes_on(u, beside, if beside == 0 { 1 } else { FROM });
            let mut set = |row: usize, steps: f64| {
                column[if end.is_hub { row } else { nv - 1 - row }] = p + steps * step;
            };
            set(0, beside as f64 + beyond);
            (0..beside).for_each(|v| set(v + 1, (beside - v) as f64));
        }
        points.append(&mut column);
        normals.extend(rows().map(|v| wall.normal(u, v)));
    }
    ChannelWall { nv, points, normals, ..wall.clone() }
}

/// Rows beside a fillet from which its blade goes on straight.
const FROM: usize = 6;
/// Shortest step to an end wall, as a share of that from row to row.
const LEAST_STEP: f64 = 0.4;

/// The part of a wall beside its hub or its shroud.
struct WallEnd<'a> {
    wall: &'a ChannelWall,
    is_hub: bool,
    /// Where its first row lies (x, r), without places that all but repeat.
    end: Vec<DVec2>,
}

impl<'a> WallEnd<'a> {
    fn new(wall: &'a ChannelWall, is_hub: bool) -> Self {
        /// Share of the mean distance from place to place up to which one is left out.
        const REPEATED: f64 = 0.2;
        let row = if is_hub { 0 } else { wall.nv - 1 };
        let mut end: Vec<DVec2> = (0..wall.nu).map(|u| place(wall, u, row)).collect();
        let length: f64 = end.windows(2).map(|w| w[0].distance(w[1])).sum();
        end.dedup_by(|next, last| next.distance(*last) < REPEATED * length / wall.nu as f64);
        Self { wall, is_hub, end }
    }

    /// The row that is `v` rows away.
    fn row(&self, v: usize) -> usize {
        if self.is_hub { v } else { self.wall.nv - 1 - v }
    }

    /// Point of a column `beside` rows away, and the step that takes its blade straight on from there, as it runs over the
    /// next `from` rows, to the first row in `beside` steps.
    fn goes_on(&self, u: usize, beside: usize, from: usize) -> (DVec3, DVec3) {
        let inner = (beside + from).min(self.wall.nv - 1);
        let rows = [beside, inner].map(|v| self.row(v));
        let [p, q] = rows.map(|v| self.wall.point(u, v));
        let step = (p - q) / (inner - beside).max(1) as f64;
        let [at, before] = rows.map(|v| place(self.wall, u, v));
        // Beside a swept edge rows lie less far apart within a fillet, and begin further along.
        let steps =
            if beside == 0 { None } else { self.reaches_end(at, (at - before) / (inner - beside).max(1) as f64) };
        (p, step * steps.map_or(1.0, |steps| (steps / beside as f64).clamp(LEAST_STEP, 1.0 / LEAST_STEP)))
    }

    /// How many steps from a place (x, r) on the first row is reached, which goes on straight beyond its ends.
    fn reaches_end(&self, at: DVec2, step: DVec2) -> Option<f64> {
        let last = self.end.len().saturating_sub(2);
        let met = self.end.windows(2).enumerate().filter_map(|(i, w)| {
            let (along, to) = (w[1] - w[0], w[0] - at);
            let across = step.perp_dot(along);
            let (steps, share) = (to.perp_dot(along) / across, to.perp_dot(step) / across);
            let is_met = (share >= 0.0 || i == 0) && (share <= 1.0 || i == last);
            (is_met && steps > 0.0 && steps.is_finite()).then_some(steps)
        });
        met.min_by(f64::total_cmp)
    }

    /// The number of rows that are within a fillet, for each column; the first and the last `added` lie beyond the edges.
    fn fillet_rows(&self, added: usize) -> Vec<usize> {
        /// Shares of the height within which fillets end, and over which they turn.
        const REACH: f64 = 0.3;
        const OVER: f64 = 0.1;
        /// Angle by which they turn over it, at least (rad).
        const TURN: f64 = 0.26;
        /// Rows beside a fillet that its last facets may still reach into.
        const BESIDE: usize = 2;
        /// Share of the columns at either edge, round which fillets go on from the wall beside it.
        const NEAR: f64 = 0.2;
        let wall = self.wall;
        let last = wall.nv - 1;
        let over = ((OVER * last as f64).ceil() as usize).max(1);
        let reach = ((REACH * last as f64) as usize).min(last.saturating_sub(BESIDE.max(over)));
        let of_column = |u: usize| {
            let turn = |v: usize| wall.normal(u, self.row(v)).angle_between(wall.normal(u, self.row(v + over)));
            let place = |v: usize| place(wall, u, self.row(v));
            let is_aside = |v: usize| {
                let ([near, far], steps) =
                    ([BESIDE, BESIDE + FROM].map(|rows| place((v + rows).min(last))), FROM as f64);
                let step = (near - far) / steps;
                (place(v) - (near + BESIDE as f64 * step)).length() > step.length()
            };
            // A blade that grows thinner towards the end wall turns as well, but away from what goes on straight.
            let stands_out = |beside: &usize| {
                let (p, step) = self.goes_on(u, *beside, FROM);
                let off = wall.point(u, self.row(0)) - (p + *beside as f64 * step);
                off.dot(wall.normal(u, self.row(*beside))) >= 0.0
            };
            let mut turned = (0..reach).rev().filter(|v| turn(*v) > TURN || is_aside(*v)).map(|v| v + BESIDE);
            turned.find(stands_out).unwrap_or(0)
        };
        let mut all: Vec<usize> = (0..wall.nu).map(of_column).collect();
        // Rows within a fillet begin further along the passage: towards an edge, round which the columns go, one that is
        // there in the middle takes no fewer of them.
        let near = added + (NEAR * (wall.nu - 2 * added) as f64) as usize;
        let middle = all.len() / 4..all.len() - all.len() / 4;
        let is_there = 2 * all[middle.clone()].iter().filter(|rows| **rows > 0).count() > middle.len();
        for u in (0..near).rev().filter(|_| is_there) {
            all[u] = all[u].max(all[u + 1]);
            all[wall.nu - 1 - u] = all[wall.nu - 1 - u].max(all[wall.nu - 2 - u]);
        }
        all
    }
}

/// Where a point of a wall lies (x, r).
fn place(wall: &ChannelWall, u: usize, v: usize) -> DVec2 {
    let Cylindrical { x, r, .. } = wall.cylindrical(u, v);
    DVec2::new(x, r)
}

/// The wall with points of its grid moved onto sharp edges along the blade, which the grid cuts off.
fn sharp(mut wall: ChannelWall) -> ChannelWall {
    for v in 0..wall.nv {
        for u in (1..wall.nu).filter(|u| is_edge(&wall, *u, v)).collect::<Vec<_>>() {
            let [a, b] = [u - 1, u].map(|u| wall.point(u, v));
            let Some(edge) = edge_between((a, wall.normal(u - 1, v)), (b, wall.normal(u, v))) else { continue };
            let nearer = if edge.distance(a) < edge.distance(b) { u - 1 } else { u };
            wall.points[nearer * wall.nv + v] = edge;
        }
    }
    wall
}

/// Whether the wall has a sharp edge along its blade, which stands out into the channel, between the columns `u - 1` and
/// `u` of row `v`: it turns at once there, and beside it not.
fn is_edge(wall: &ChannelWall, u: usize, v: usize) -> bool {
    /// Angle by which it turns, at least, and as much as at most beside it (rad).
    const SHARP: f64 = 0.7;
    let turn = |u: usize| wall.normal(u - 1, v).angle_between(wall.normal(u, v));
    let is_even = |u: usize| turn(u) < 0.5 * SHARP;
    let stands_out = (wall.point(u, v) - wall.point(u - 1, v)).dot(wall.normal(u - 1, v)) < 0.0;
    stands_out && turn(u) > SHARP && (u < 2 || is_even(u - 1)) && (u + 1 >= wall.nu || is_even(u + 1))
}

/// Where the planes through two points square to their normals meet, half way between them along the edge; none if that
/// is further away than they are from one another.
fn edge_between((a, normal_a): (DVec3, DVec3), (b, normal_b): (DVec3, DVec3)) -> Option<DVec3> {
    let along = normal_a.cross(normal_b).try_normalize()?;
    let planes = DMat3::from_cols(normal_a, normal_b, along).transpose();
    let edge = planes.inverse() * DVec3::new(normal_a.dot(a), normal_b.dot(b), along.dot(0.5 * (a + b)));
    (edge.distance(a).max(edge.distance(b)) <= a.distance(b)).then_some(edge)
}

/// Projects back and forth between the walls, starting at grid points `i` and `j`.
fn slide_to_rest(low: &ChannelWall, high: &ChannelWall, mut i: usize, mut j: usize) -> Throat {
    const MOST_ROUNDS: usize = 200;
    let (mut p, mut q) = (low.points[i], high.points[j]);
    for _ in 0..MOST_ROUNDS {
        let before = (p - q).length();
        (q, j) = foot(high, j, p);
        (p, i) = foot(low, i, q);
        if before - (p - q).length() < 1e-9 * before {
            break;
        }
    }
    Throat { width_mm: (p - q).length(), on_low_wall: p, on_high_wall: q }
}

/// The nearest point to `p` of the wall's triangles within two cells of grid point `near`, and the corner of
/// the cell it lies in.
fn foot(wall: &ChannelWall, near: usize, p: DVec3) -> (DVec3, usize) {
    let (u, v) = (near / wall.nv, near % wall.nv);
    let cells = |at: usize, n: usize| at.saturating_sub(2)..(at + 2).min(n - 1);
    let mut best = (wall.points[near], near);
    for cu in cells(u, wall.nu) {
        for cv in cells(v, wall.nv) {
            let [a, b, c, d] = [(cu, cv), (cu + 1, cv), (cu + 1, cv + 1), (cu, cv + 1)].map(|(u, v)| wall.point(u, v));
            for triangle in [Triangle::new(a, b, c), Triangle::new(a, c, d)] {
                let q = triangle.project_local_point(p, false).point;
                if (q - p).length_squared() < (best.0 - p).length_squared() {
                    best = (q, cu * wall.nv + cv);
                }
            }
        }
    }
    best
}

/// The middle line at mid height, unrolled: position along the passage against radius times angle (mm). The radius of
/// an axial channel is the mean one.
fn middle_line(low: &ChannelWall, high: &ChannelWall, flow: Flow) -> Vec<[f64; 2]> {
    let v = low.nv / 2;
    let at = |u: usize| (low.cylindrical(u, v), high.cylindrical(u, v));
    let radius = (0..low.nu).map(|u| at(u).0.r).sum::<f64>() / low.nu as f64;
    let mut previous = 0.0;
    let mut line: Vec<[f64; 2]> = Vec::with_capacity(low.nu);
    for u in 0..low.nu {
        let (a, b) = at(u);
        let width = (b.theta - a.theta).rem_euclid(std::f64::consts::TAU);
        // A strongly staggered channel may wind past half a turn: keep to the turn of the point before.
        let turn = geometry::frame::wrap_angle(a.theta + 0.5 * width - previous);
        previous += turn;
        line.push(match (flow, line.last()) {
            (Flow::Axial, _) => [a.x, radius * previous],
            (_, None) => [0.0, 0.0],
            (_, Some([along, around])) => {
                let before = at(u - 1).0;
                [along + (a.x - before.x).hypot(a.r - before.r), around + 0.5 * (a.r + before.r) * turn]
            }
        });
    }
    line
}

/// Slope angle of the line at the end where `share` is 0 (share: how far along x from that end): that of the
/// parabola through what lies just behind the rounding of the blades' edge.
fn end_angle(line: &[[f64; 2]], end: f64, length: f64) -> f64 {
    let (mut normal, mut right) = (Matrix3::<f64>::zeros(), Vector3::<f64>::zeros());
    for &[x, y] in line {
        let t = (x - end) / length;
        if AT_END.contains(&t.abs()) {
            let row = Vector3::new(1.0, t, t * t);
            normal += row * row.transpose();
            right += row * y;
        }
    }
    normal.try_inverse().map_or(0.0, |inverse| ((inverse * right)[1] / length).atan())
}

/// How much the channel's middle line turns between blunt ends of its blades (rad, positive) and which sides its low
/// and high walls are.
pub(super) fn turning(low: &ChannelWall, high: &ChannelWall, flow: Flow) -> (f64, [BladeSide; 2]) {
    let is_blunt = |u: &usize| [low, high].iter().any(|wall| is_edge(wall, *u, wall.nv / 2));
    let front = (1..low.nu / 3).rev().find(is_blunt).unwrap_or(0);
    let back = (low.nu - low.nu / 3..low.nu).find(is_blunt).map_or(low.nu - 1, |u| u - 1);
    let line = &middle_line(low, high, flow)[front..=back];
    let (x0, x1) = (line[0][0], line[line.len() - 1][0]);
    let turn = end_angle(line, x1, x1 - x0) - end_angle(line, x0, x1 - x0);
    // Both ends' angles are those of facets: which side is which must not depend on where these begin.
    let is_at_end = |u: &usize| {
        let from_front = (line[u - front][0] - x0) / (x1 - x0);
        AT_END.contains(&from_front) || AT_END.contains(&(1.0 - from_front))
    };
    let columns = (front..back).filter(is_at_end);
    let facets = columns.map(|u| facet_turn(low, u).max(facet_turn(high, u))).fold(0.0, f64::max);
    let sides = if turn.abs() < facets.clamp(STRAIGHT[0], STRAIGHT[1]) {
        [BladeSide::Flat, BladeSide::Flat]
    } else if turn < 0.0 {
        // The line bulges towards greater theta, away from the low wall's blade: that wall is convex.
        [BladeSide::Suction, BladeSide::Pressure]
    } else {
        [BladeSide::Pressure, BladeSide::Suction]
    };
    (turn.abs(), sides)
}

/// By how much a wall turns from column `u` to the next at mid height (rad).
fn facet_turn(wall: &ChannelWall, u: usize) -> f64 {
    let v = wall.nv / 2;
    let [a, b] = [u, u + 1].map(|u| cylindrical_components(wall.normal(u, v), wall.cylindrical(u, v).theta));
    a.angle_between(b)
}

/// Least and greatest x of the mesh (in W) at the radii of the channel, its end walls included.
pub(super) fn faces_x(mesh: &Mesh, meridian: &[Station]) -> [f64; 2] {
    let (least, most) = meridian.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), s| {
        (s.hub.y.min(s.shroud.y).min(l), s.hub.y.max(s.shroud.y).max(m))
    });
    let band = 0.01 * (most - least);
    let (least, most) = (least - band, most + band);
    let mut faces = [f64::INFINITY, f64::NEG_INFINITY];
    for corners in mesh.iter_corners() {
        for (p, q) in [(corners[0], corners[1]), (corners[1], corners[2]), (corners[2], corners[0])] {
            let (rp, rq) = (p.y.hypot(p.z), q.y.hypot(q.z));
            if rp.max(rq) < least || rp.min(rq) > most {
                continue;
            }
            let at = |r: f64| if rp == rq { 0.0 } else { ((r.clamp(least, most) - rp) / (rq - rp)).clamp(0.0, 1.0) };
            for t in [at(rp), at(rq)] {
                let x = p.x + t * (q.x - p.x);
                faces = [faces[0].min(x), faces[1].max(x)];
            }
        }
    }
    faces
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// A wall of 41 by 25 points, 0.25 by 0.5 apart, and normals into the channel.
    fn wall(at: impl Fn(f64, f64) -> (DVec3, DVec3)) -> ChannelWall {
        let (nu, nv) = (41, 25);
        let all = (0..nu * nv).map(|i| at(0.25 * (i / nv) as f64, 0.5 * (i % nv) as f64));
        let (points, normals) = all.map(|(point, normal)| (point, normal.normalize())).unzip();
        ChannelWall { nu, nv, points, normals, side: BladeSide::Flat }
    }

    /// A wall like that of `wall`, far from the axis.
    fn raised(at: impl Fn(f64, f64) -> (DVec3, DVec3)) -> ChannelWall {
        wall(|x, z| {
            let (point, normal) = at(x, z);
            (point + 1e5 * DVec3::Z, normal)
        })
    }

    /// The wall y = 0.
    fn plane() -> ChannelWall {
        raised(|x, z| (DVec3::new(x, 0.0, z), DVec3::Y))
    }

    #[test]
    fn the_throat_at_a_sharp_edge_between_columns_is_that_of_the_edge() {
        const EDGE: f64 = 5.08;
        let high = raised(|x, z| {
            let off = x - EDGE;
            (DVec3::new(x, 1.0 + off.abs(), z), DVec3::new(off.signum(), -1.0, 0.0))
        });
        let throat = throat([&plane(), &high], 0.0, 0, &Cancel::default()).unwrap();
        assert!((throat.width_mm - 1.0).abs() < 1e-9, "{throat:?}");
        assert!((throat.on_high_wall.x - EDGE).abs() < 1e-9, "{throat:?}");
    }

    /// A blade over y = 0 that comes nearer by 0.1 per mm down to z = 1.5, and turns there.
    fn turned_at_the_hub(slope_below: f64) -> ChannelWall {
        raised(|x, z| {
            let up = z - 1.5;
            let slope = if up < 0.0 { slope_below } else { 0.1 };
            (DVec3::new(x, 2.0 + slope * up, z), DVec3::new(0.0, -1.0, slope))
        })
    }

    #[test]
    fn a_fillet_is_left_out_of_the_throat_and_a_blade_that_grows_thinner_is_not() {
        // A fillet stands out into the channel: in its place the blade goes on to 0.15 mm nearer at the hub.
        let fillet = throat([&plane(), &turned_at_the_hub(0.8)], 0.0, 0, &Cancel::default()).unwrap().width_mm;
        assert!((fillet - 1.85).abs() < 1e-5, "{fillet}");
        // A thinner blade stands back from what goes on: its edge at z = 1.5 is the nearest place.
        let thinner = throat([&plane(), &turned_at_the_hub(-0.5)], 0.0, 0, &Cancel::default()).unwrap().width_mm;
        assert!((thinner - 2.0).abs() < 1e-5, "{thinner}");
    }

    /// The passage widens from the edge on, and round the edge goes the fillet, whose rows begin further along.
    #[test]
    fn a_fillet_round_the_edge_where_the_throat_lies_is_left_out() {
        const RADIUS: f64 = 1.5;
        const ROUND: f64 = 2.0;
        let high = raised(|x, z| {
            let up = (RADIUS - z).clamp(0.0, 0.99 * RADIUS);
            let root = (RADIUS * RADIUS - up * up).sqrt();
            let (off, slope) = (RADIUS - root, up / root);
            if off > 0.0 && x < ROUND {
                let (sin, cos) = (std::f64::consts::FRAC_PI_2 * x / ROUND).sin_cos();
                return (DVec3::new(-off * cos, 2.0 - off * sin, z), DVec3::new(-cos, -sin, slope));
            }
            let x = if off > 0.0 { (x - ROUND) * 10.0 / (10.0 - ROUND) } else { x };
            (DVec3::new(x, 2.0 + 0.1 * x - off, z), DVec3::new(0.1, -1.0, slope))
        });
        let width = throat([&plane(), &high], 0.0, 0, &Cancel::default()).unwrap().width_mm;
        assert!((width - 2.0).abs() < 1e-6, "{width}");
    }

    #[test]
    fn a_fillet_below_a_blade_that_grows_thinner_is_left_out() {
        // From z = 5 the blade recedes by 0.4 per mm towards the hub, and from z = 1 a fillet stands out, up to 1.9 mm.
        let high = raised(|x, z| {
            let (off, slope) = match z {
                z if z < 1.0 => (1.6 - 1.7 * (1.0 - z), 1.7),
                z if z < 5.0 => (0.4 * (5.0 - z), -0.4),
                z => (0.2 * (z - 5.0), 0.2),
            };
            (DVec3::new(x, 2.0 + off, z), DVec3::new(0.0, -1.0, slope))
        });
        let width = throat([&plane(), &high], 0.0, 0, &Cancel::default()).unwrap().width_mm;
        assert!((width - 2.0).abs() < 1e-9, "{width}");
    }

    #[test]
    fn a_blunt_end_of_a_blade_turns_no_flow() {
        const EDGE: f64 = 8.6;
        let place = |x: f64, r: f64, theta: f64| Cylindrical { x, r, theta }.point();
        let around = |theta: f64| DVec3::new(0.0, -theta.cos(), -theta.sin());
        let low = wall(|x, z| {
            // Beyond its edge the low wall is the end of the blade, which recedes by 10 mm per mm.
            let (theta, face) = if x < EDGE { (0.0, 0.0) } else { (-0.2 * (x - EDGE), 10.0) };
            (place(x, 50.0 + z, theta), around(theta) + face * DVec3::X)
        });
        let high = wall(|x, z| (place(x, 50.0 + z, 0.2), -around(0.2)));
        let (turn, sides) = turning(&low, &high, Flow::Axial);
        assert!(turn < 1e-9 && sides == [BladeSide::Flat; 2], "{turn}");
    }

    /// The angle of a camber line that turns by `turn` over 10 mm, whose facets are `length` long and begin at `from` (mm),
    /// about an axis 50 mm away, and its slope (rad, rad/mm).
    fn faceted(x: f64, (turn, length, from): (f64, f64, f64)) -> (f64, f64) {
        let theta = |x: f64| turn * (x - 5.0) * (x - 5.0) / (2.0 * 10.0 * 52.5);
        let start = from + length * ((x - from) / length).floor();
        let slope = (theta(start + length) - theta(start)) / length;
        (theta(start) + slope * (x - start), slope)
    }

    proptest! {
        /// Which side is which is a matter of the part, not of where the facets of a channel begin.
        #[test]
        fn facets_never_exchange_the_sides(turn in -0.2..0.2, length in 0.3..4.0, from in [0.0..4.0, 0.0..4.0]) {
            let side = |at: f64, from: f64, sign: f64| wall(move |x, z| {
                let (theta, slope) = faceted(x, (turn, length, from));
                let around = DVec3::new(0.0, -(at + theta).cos(), -(at + theta).sin());
                let point = Cylindrical { x, r: 50.0 + z, theta: at + theta }.point();
                (point, sign * (around - (50.0 + z) * slope * DVec3::X))
            });
            let (_, sides) = turning(&side(-0.1, from[0], 1.0), &side(0.1, from[1], -1.0), Flow::Axial);
            let mut right = [BladeSide::Suction, BladeSide::Pressure];
            if turn >= 0.0 {
                right.reverse();
            }
            // More than is ever straight, and of more than a few facets.
            let is_plain = turn.abs() > 2.0 * STRAIGHT[1] && length < 2.5;
            prop_assert!(sides == right || (sides == [BladeSide::Flat; 2] && !is_plain), "{:?}", sides);
        }
    }
}
