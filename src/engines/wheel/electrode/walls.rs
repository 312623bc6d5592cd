//! Tables of the walls of a channel, which are grids of points, by position along the passage and height.

use std::f64::consts::FRAC_PI_2;

use glam::DVec2;

use crate::channel::{Channel, ChannelWall};
use geometry::frame::angle_near;

/// A wall as lines along the chord, one for each position between hub and shroud.
pub struct WallTable {
    lines: Vec<Vec<WallPoint>>,
}

/// A point of a wall.
#[derive(Debug, Clone, Copy)]
struct WallPoint {
    along: f64,
    height: f64,
    theta: f64,
}

/// A wall at one position along the passage and one height.
#[derive(Debug, Clone, Copy)]
pub struct WallPlace {
    /// Angle of the wall, past the edges that of the tip (rad).
    pub theta: f64,
    /// Whether the position is past an edge.
    pub past_edge: bool,
}

impl WallTable {
    /// Of the low and the high wall. Angles are continuous along the passage, however far it winds about the axis, and
    /// those of the high wall are greater than those of the low one beside it. `None` when the grids have too few points
    /// to look anything up.
    pub fn of(channel: &Channel) -> Option<[Self; 2]> {
        let Channel { low, high, .. } = channel;
        let is_grid = |wall: &ChannelWall| wall.nu >= 2 && wall.nv >= 2 && wall.points.len() == wall.nu * wall.nv;
        if !is_grid(low) || !is_grid(high) || [low.nu, low.nv] != [high.nu, high.nv] {
            return None;
        }
        let theta = |wall: &ChannelWall, u: usize, v: usize| wall.cylindrical(u, v).theta;
        let start = (0..low.nu).min_by(|&a, &b| theta(low, a, 0).abs().total_cmp(&theta(low, b, 0).abs()))?;
        // Angles of both walls from hub to shroud, outwards from where the low wall is nearest to W's +Z.
        let mut columns = vec![Vec::new(); low.nu];
        let mut near = theta(low, start, 0);
        for u in (start..low.nu).chain((0..start).rev()) {
            if u + 1 == start {
                near = theta(low, start, 0);
            }
            for v in 0..low.nv {
                let at_low = angle_near(theta(low, u, v), near);
                columns[u].push([at_low, angle_near(theta(high, u, v), at_low + FRAC_PI_2)]);
                near = at_low;
            }
            near = columns[u][0][0];
        }
        let table = |(i, wall): (usize, &ChannelWall)| {
            let point = |u, v| {
                let place = wall.cylindrical(u, v);
                let [along, height] = channel.along_and_height(DVec2::new(place.x, place.r));
                WallPoint { along, height, theta: columns[u][v][i] }
            };
            Self { lines: (0..wall.nv).map(|v| (0..wall.nu).map(|u| point(u, v)).collect()).collect() }
        };
        Some([(0, low), (1, high)].map(table))
    }

    /// The wall at a position along the passage and a height on the line across it, x and the radius in an axial
    /// channel (mm); linear between grid points and in the continuation of the last two lines.
    pub fn at(&self, at: f64, height: f64) -> WallPlace {
        let mut below = Self::along(&self.lines[0], at);
        let mut above = Self::along(&self.lines[1], at);
        for line in &self.lines[2..] {
            if above.1.height >= height {
                break;
            }
            (below, above) = (above, Self::along(line, at));
        }
        let apart = above.1.height - below.1.height;
        let t = if apart.abs() > 1e-9 { ((height - below.1.height) / apart).clamp(-0.5, 1.5) } else { 0.0 };
        let mix = |a: f64, b: f64| a + t * (b - a);
        let past_edge = at < mix(below.0[0], above.0[0]) || at > mix(below.0[1], above.0[1]);
        WallPlace { theta: mix(below.1.theta, above.1.theta), past_edge }
    }

    /// The ends of a line along the passage, and its point at `along` or at the nearer end.
    fn along(line: &[WallPoint], along: f64) -> ([f64; 2], WallPoint) {
        let (first, last) = (line[0], line[line.len() - 1]);
        let ends = [first.along, last.along];
        if along <= first.along {
            return (ends, first);
        }
        let Some(i) = line.iter().position(|p| p.along >= along) else { return (ends, last) };
        let (a, b) = (line[i - 1], line[i]);
        let t = if b.along > a.along { (along - a.along) / (b.along - a.along) } else { 0.0 };
        let mix = |a: f64, b: f64| a + t * (b - a);
        (ends, WallPoint { along, height: mix(a.height, b.height), theta: mix(a.theta, b.theta) })
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::fixtures::exact_channel;
    use crate::parametric::ParametricBlisk;
    use glam::DMat3;

    #[test]
    fn angles_of_walls_that_wind_far_about_the_axis_go_on() {
        let mut channel = exact_channel(&ParametricBlisk::default());
        let [from, to] = channel.span_x();
        let flat = WallTable::of(&channel).unwrap();
        // The walls wound once more about the axis from edge to edge, and a quarter turn away from +Z.
        let wind = |x: f64| TAU * (0.25 + (x - from) / (to - from));
        for point in channel.low.points.iter_mut().chain(&mut channel.high.points) {
            *point = DMat3::from_rotation_x(wind(point.x)) * *point;
        }
        let wound = WallTable::of(&channel).unwrap();
        let mut turns = Vec::new();
        for (i, wall) in [&channel.low, &channel.high].into_iter().enumerate() {
            for place in wall.points.iter().map(|p| DVec2::new(p.x, p.y.hypot(p.z))) {
                let [was, is] = [&flat, &wound].map(|tables| tables[i].at(place.x, place.y).theta);
                turns.push((is - was - wind(place.x)) / TAU);
            }
        }
        // The same number of whole turns everywhere, on both walls: no jump between any two places.
        assert!((turns[0] - turns[0].round()).abs() < 1e-9, "{}", turns[0]);
        assert!(turns.iter().all(|turn| (turn - turns[0]).abs() < 1e-9), "{turns:?}");
    }
}
