//! P0's angle constraint over the ordered points of the channel walls.
//!
//! For an electrode point E, M1 is the nearest point of the wall, N1 the wall's normal there into the channel, and
//! M5 the neighbour of M1 on the side of E. The point is free of the wall when the angle alpha between M1E and
//! N1 is smaller, by more than Delta2, than the angle theta between M1M5 and N1: `theta - alpha - Delta2 > 0`. Where
//! the wall bends away theta exceeds 90 degrees, so a point that a plain 90 degree test would refuse may be free.
//! Hub and shroud are tested by radius, (3), with Delta1; where the passage does not run along the axis, by the height on the
//! line across it.
//!
//! P0 tests against contact; here the wall points are first moved into the channel by the spark gap and margin, so
//! that the test asks for the clearance that the process needs.

use files::Invalid;
use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

use super::clearance::ClearanceModel;
use super::pose::Pose;
use super::probes::Turns;
use wheel::channel::{Channel, ChannelWall, Flow};

/// Safety factors of the angle constraint.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct AngleParams {
    /// Delta1: distance kept from hub and shroud beyond spark gap and margin (mm).
    pub delta1_mm: f64,
    /// Delta2: least difference theta - alpha (deg).
    pub delta2_deg: f64,
}

impl AngleParams {
    /// Whether both are usable.
    pub fn validate(&self) -> Result<(), Invalid> {
        Invalid::unless_within("delta1_mm", self.delta1_mm, [0.0, f64::INFINITY], "mm")?;
        let delta2_deg = self.delta2_deg;
        let is_right = (0.0..90.0).contains(&delta2_deg);
        if is_right {
            Ok(())
        } else {
            Err(Invalid::new("delta2_deg", delta2_deg, "must be from 0 to less than 90 deg"))
        }
    }
}

/// Angles of P0's figure 3 at the point M1 of a wall that is nearest to a point E.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Angles {
    /// Angle between M1E and the normal (rad).
    pub alpha: f64,
    /// Angle between M1M5 and the normal (rad).
    pub theta: f64,
    /// Distance from M1 to E (mm).
    pub distance: f64,
}

/// The constraint, made ready for one channel.
pub struct AngleTest<'a> {
    channel: &'a Channel,
    walls: [OrderedWall; 2],
    span: [f64; 2],
    /// Distance kept from hub and shroud (mm).
    end_walls: f64,
    /// Delta2 (rad).
    delta2: f64,
}

/// A wall's points moved into the channel, in their order.
struct OrderedWall {
    nu: usize,
    nv: usize,
    points: Vec<DVec3>,
    normals: Vec<DVec3>,
}

impl<'a> AngleTest<'a> {
    /// A test that keeps `clearance` (spark gap and margin, mm) from `channel`.
    pub fn new(channel: &'a Channel, clearance: f64, params: &AngleParams) -> Self {
        Self {
            channel,
            walls: [&channel.low, &channel.high].map(|wall| OrderedWall::new(wall, clearance)),
            span: channel.span_along(),
            end_walls: clearance + params.delta1_mm,
            delta2: params.delta2_deg.to_radians(),
        }
    }

    /// Whether every sample of the electrode passes at `pose`, with walls drawn in by `turns`.
    pub fn is_free(&self, model: &ClearanceModel, pose: &Pose, turns: Turns) -> bool {
        // Neighbouring samples have neighbouring nearest wall points: each walk starts where the last one ended.
        let mut nearest = [0; 2];
        // In the final pose the end walls are just the spark gap away; rounding must not refuse it.
        const ROUNDING: f64 = 1e-4;
        model.placed_samples(pose, turns).all(|p| {
            let Some((along, [above_hub, below_shroud])) = self.in_passage(p) else { return true };
            let between = above_hub > self.end_walls - ROUNDING
                && (!self.channel.shrouded || below_shroud > self.end_walls - ROUNDING);
            let beside_blades = along < self.span[0] || along > self.span[1];
            between && (beside_blades || (0..2).all(|w| self.walls[w].passes(p, self.delta2, &mut nearest[w])))
        })
    }

    /// The angles at the low and at the high wall for the point `p`, in W; none where the test says nothing of a wall.
    /// `nearest` holds the wall points where the search begins, and those where it ended.
    pub fn angles(&self, p: DVec3, nearest: &mut [usize; 2]) -> [Option<Angles>; 2] {
        [0, 1].map(|w| self.walls[w].angles(p, &mut nearest[w]))
    }

    /// Position of `p` along the passage and its heights above the hub and below the shroud (mm); none beyond the
    /// passage's ends.
    fn in_passage(&self, p: DVec3) -> Option<(f64, [f64; 2])> {
        /// How far a place may be off the line across the passage that it is on (mm).
        const OFF_LINE: f64 = 1e-6;
        let (channel, place) = (self.channel, DVec2::new(p.x, p.y.hypot(p.z)));
        if channel.flow == Flow::Axial {
            let within = p.x >= channel.faces_x[0] && p.x <= channel.faces_x[1];
            let (hub, shroud) = channel.radii_at(p.x);
            return within.then_some((p.x, [place.y - hub, shroud - place.y]));
        }
        let [along, height] = channel.along_and_height(place);
        let line = channel.line_at(along);
        // Beyond an end the nearest line is that of the end.
        let ends = channel.ends_along();
        let is_beyond = (along <= ends[0] || along >= ends[1]) && line.place(height).distance(place) > OFF_LINE;
        (!is_beyond).then_some((along, [height - line.ends[0], line.ends[1] - height]))
    }
}

impl OrderedWall {
    fn new(wall: &ChannelWall, clearance: f64) -> Self {
        let points = wall.points.iter().zip(&wall.normals).map(|(&p, &n)| p + n * clearance).collect();
        Self { nu: wall.nu, nv: wall.nv, points, normals: wall.normals.clone() }
    }

    fn passes(&self, e: DVec3, delta2: f64, start: &mut usize) -> bool {
        const TOUCHING: f64 = 1e-4;
        self.angles(e, start).is_none_or(|Angles { alpha, theta, distance }| {
            distance < TOUCHING || theta - alpha - delta2 > -TOUCHING / distance
        })
    }

    /// The angles at the nearest point; none beyond the wall's first or last row, where the blade ends, and with it what
    /// the test can tell.
    fn angles(&self, e: DVec3, start: &mut usize) -> Option<Angles> {
        *start = self.nearest(e, *start);
        let row = *start / self.nv;
        if row == 0 || row + 1 == self.nu {
            return None;
        }
        let (m1, normal) = (self.points[*start], self.normals[*start]);
        let to_e = e - m1;
        let m5 = self.neighbour_towards(*start, to_e)?;
        let [theta, alpha] = [self.points[m5] - m1, to_e].map(|towards| normal.angle_between(towards));
        Some(Angles { alpha, theta, distance: to_e.length() })
    }

    /// Walks from `start` to the point that no neighbour is nearer than. On a wall that is a graph over its grid
    /// that is the nearest point; the walk is started anew from a coarse search when it ends far away.
    fn nearest(&self, e: DVec3, start: usize) -> usize {
        let walk = |mut at: usize| loop {
            let next = self.neighbours(at).min_by(|&a, &b| self.distance(a, e).total_cmp(&self.distance(b, e)));
            match next {
                Some(next) if self.distance(next, e) < self.distance(at, e) => at = next,
                _ => return at,
            }
        };
        let stride = (self.points.len() / 64).max(1);
        let coarse = (0..self.points.len())
            .step_by(stride)
            .min_by(|&a, &b| self.distance(a, e).total_cmp(&self.distance(b, e)))
            .unwrap_or(0);
        let (near, far) = (walk(start), walk(coarse));
        if self.distance(near, e) <= self.distance(far, e) { near } else { far }
    }

    fn distance(&self, i: usize, e: DVec3) -> f64 {
        self.points[i].distance_squared(e)
    }

    /// The neighbours of a point in the grid, diagonal ones included.
    fn neighbours(&self, i: usize) -> impl Iterator<Item = usize> {
        let (u, v, nu, nv) = ((i / self.nv) as isize, (i % self.nv) as isize, self.nu as isize, self.nv as isize);
        (0..9).filter(|&k| k != 4).filter_map(move |k| {
            let (a, b) = (u + k / 3 - 1, v + k % 3 - 1);
            (a >= 0 && b >= 0 && a < nu && b < nv).then_some((a * nv + b) as usize)
        })
    }

    /// M5: the nearest neighbour of `i` on the side that `to_e` points to along the wall.
    fn neighbour_towards(&self, i: usize, to_e: DVec3) -> Option<usize> {
        let normal = self.normals[i];
        let along = to_e - normal * normal.dot(to_e);
        self.neighbours(i)
            .filter(|&k| (self.points[k] - self.points[i]).dot(along) > 0.0)
            .min_by(|&a, &b| self.distance(a, self.points[i]).total_cmp(&self.distance(b, self.points[i])))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wall bent like a cylinder of radius 10 about the Z axis, seen from outside (convex) or inside.
    fn bent_wall(convex: bool) -> OrderedWall {
        let (nu, nv) = (41, 5);
        let sign = if convex { 1.0 } else { -1.0 };
        let on = |u: usize| DVec3::new((u as f64 * 0.05 - 1.0).sin(), (u as f64 * 0.05 - 1.0).cos(), 0.0);
        let grid = (0..nu).flat_map(|u| (0..nv).map(move |v| (u, v as f64)));
        let points = grid.clone().map(|(u, v)| on(u) * 10.0 + DVec3::Z * v).collect();
        OrderedWall { nu, nv, points, normals: grid.map(|(u, _)| on(u) * sign).collect() }
    }

    #[test]
    fn a_point_past_the_bend_of_a_convex_wall_is_free_although_it_is_below_the_tangent_plane() {
        let wall = bent_wall(true);
        // Half way to the next row beyond the last one found nearest, just outside the cylinder: 90 degrees refuse it.
        let angle: f64 = 0.024;
        let e = DVec3::new(angle.sin(), angle.cos(), 0.2) * DVec3::new(10.001, 10.001, 10.0);
        let mut start = 0;
        let nearest = wall.nearest(e, start);
        assert!((e - wall.points[nearest]).dot(wall.normals[nearest]) < 0.0, "the plain test says it is inside");
        assert!(wall.passes(e, 0.0, &mut start));
    }

    #[test]
    fn points_behind_the_wall_fail_and_points_before_it_pass() {
        for convex in [true, false] {
            let wall = bent_wall(convex);
            for (depth, free) in [(0.5, true), (-0.5, false)] {
                let r = if convex { 10.0 + depth } else { 10.0 - depth };
                let e = DVec3::new(0.3f64.sin() * r, 0.3f64.cos() * r, 2.3);
                assert_eq!(wall.passes(e, 0.0, &mut 7), free, "convex {convex}, depth {depth}");
            }
        }
    }

    #[test]
    fn delta2_asks_for_more() {
        let wall = bent_wall(true);
        let e = DVec3::new(0.0, 10.05, 2.6);
        assert!(wall.passes(e, 0.0, &mut 0));
        assert!(!wall.passes(e, 1.0, &mut 0));
    }
}
