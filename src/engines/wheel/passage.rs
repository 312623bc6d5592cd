//! The passage of a channel as the room between its two walls, for asking where a point is in it.

use glam::{DVec2, DVec3};

use super::channel::Channel;
use super::electrode::walls::{WallPlace, WallTable};
use geometry::frame::{Cylindrical, angle_near};

/// The room between the two walls of a channel, from edge to edge of the blades.
pub struct Passage<'a> {
    channel: &'a Channel,
    tables: [WallTable; 2],
    /// Span along the passage between the edges of the blades (mm).
    pub span: [f64; 2],
}

impl<'a> Passage<'a> {
    /// That of `channel`; none if its walls have too few points.
    pub fn new(channel: &'a Channel) -> Option<Self> {
        Some(Self { channel, tables: WallTable::of(channel)?, span: channel.span_along() })
    }

    /// The channel.
    pub fn channel(&self) -> &'a Channel {
        self.channel
    }

    /// The low and the high wall at a position along the passage and a height there (mm).
    pub fn walls_at(&self, along: f64, height: f64) -> [WallPlace; 2] {
        [self.tables[0].at(along, height), self.tables[1].at(along, height)]
    }

    /// Angles of the low and the high wall at a position along the passage and a height there (rad).
    pub fn between(&self, along: f64, height: f64) -> [f64; 2] {
        self.walls_at(along, height).map(|wall| wall.theta)
    }

    /// Position along the passage and height of the place of `p` (mm).
    pub fn along_and_height(&self, p: DVec3) -> [f64; 2] {
        self.channel.along_and_height(DVec2::new(p.x, p.y.hypot(p.z)))
    }

    /// How far a point lies from the surface across the channel that has `share` of its width on the low side, along
    /// the circumference (mm, negative on the low side).
    pub fn beyond_split(&self, p: DVec3, share: f64) -> f64 {
        let Cylindrical { r, theta, .. } = Cylindrical::from_point(p);
        let [along, height] = self.along_and_height(p);
        let [low, high] = self.between(along, height);
        (angle_near(theta, 0.5 * (low + high)) - low - share * (high - low)) * r
    }

    /// Whether a point of the surface bounds the room, to within `slack` (mm) along the circumference.
    pub fn holds(&self, p: DVec3, slack: f64) -> bool {
        let [along, height] = self.along_and_height(p);
        let [from, to] = self.span;
        let Cylindrical { r, theta, .. } = Cylindrical::from_point(p);
        let [low, high] = self.between(along, height);
        let is_between = (low - slack / r..=high + slack / r).contains(&angle_near(theta, 0.5 * (low + high)));
        (from..=to).contains(&along) && is_between
    }
}
