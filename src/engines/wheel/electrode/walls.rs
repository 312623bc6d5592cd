//! Tables of the walls of a channel, which are grids of points, by x and radius.

use crate::channel::ChannelWall;
use geometry::frame::Cylindrical;

/// A wall as lines along the chord, one for each position between hub and shroud.
pub struct WallTable {
    lines: Vec<Vec<Cylindrical>>,
}

/// A wall at one x and radius.
#[derive(Debug, Clone, Copy)]
pub struct WallPlace {
    /// Angle of the wall, past the edges that of the tip (rad).
    pub theta: f64,
    /// Whether x is past an edge.
    pub past_edge: bool,
}

impl WallTable {
    /// `None` when the grid has too few points to look anything up.
    pub fn new(wall: &ChannelWall) -> Option<Self> {
        if wall.nu < 2 || wall.nv < 2 || wall.points.len() != wall.nu * wall.nv {
            return None;
        }
        let line = |v| (0..wall.nu).map(|u| wall.cylindrical(u, v)).collect();
        Some(Self { lines: (0..wall.nv).map(line).collect() })
    }

    /// The wall at `x` and `r`, linear between grid points and in the continuation of the last two lines.
    pub fn at(&self, x: f64, r: f64) -> WallPlace {
        let mut below = Self::along(&self.lines[0], x);
        let mut above = Self::along(&self.lines[1], x);
        for line in &self.lines[2..] {
            if above.1.r >= r {
                break;
            }
            (below, above) = (above, Self::along(line, x));
        }
        let height = above.1.r - below.1.r;
        let t = if height.abs() > 1e-9 { ((r - below.1.r) / height).clamp(-0.5, 1.5) } else { 0.0 };
        let mix = |a: f64, b: f64| a + t * (b - a);
        let past_edge = x < mix(below.0[0], above.0[0]) || x > mix(below.0[1], above.0[1]);
        WallPlace { theta: mix(below.1.theta, above.1.theta), past_edge }
    }

    /// The ends of a line along X, and its point at `x` or at the nearer end.
    fn along(line: &[Cylindrical], x: f64) -> ([f64; 2], Cylindrical) {
        let (first, last) = (line[0], line[line.len() - 1]);
        let ends = [first.x, last.x];
        if x <= first.x {
            return (ends, first);
        }
        let Some(i) = line.iter().position(|p| p.x >= x) else { return (ends, last) };
        let (a, b) = (line[i - 1], line[i]);
        let t = if b.x > a.x { (x - a.x) / (b.x - a.x) } else { 0.0 };
        (ends, Cylindrical { x, r: a.r + t * (b.r - a.r), theta: a.theta + t * (b.theta - a.theta) })
    }
}
