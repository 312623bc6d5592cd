//! Tables of the walls of a channel, which are grids of points, by position along the passage and height.

use glam::DVec2;

use crate::channel::{Channel, ChannelWall};

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
    /// `None` when the grid has too few points to look anything up.
    pub fn new(wall: &ChannelWall, channel: &Channel) -> Option<Self> {
        if wall.nu < 2 || wall.nv < 2 || wall.points.len() != wall.nu * wall.nv {
            return None;
        }
        let point = |u, v| {
            let place = wall.cylindrical(u, v);
            let [along, height] = channel.along_and_height(DVec2::new(place.x, place.r));
            WallPoint { along, height, theta: place.theta }
        };
        let line = |v| (0..wall.nu).map(|u| point(u, v)).collect();
        Some(Self { lines: (0..wall.nv).map(line).collect() })
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
