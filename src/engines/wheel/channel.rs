//! The channel between two neighbouring blades of a blisk, in the workpiece frame W.

use glam::DVec3;
use serde::Serialize;

use geometry::frame::{Cylindrical, Frame};

/// Face of its blade that a channel wall is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum BladeSide {
    /// The convex (back) face.
    Suction,
    /// The concave (front) face.
    Pressure,
    /// A face that is straight within what can be measured.
    Flat,
}

/// A surface of the finished blisk that an electrode may come near to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Surface {
    /// The wall on the side of smaller theta.
    LowWall,
    /// The wall on the side of greater theta.
    HighWall,
    /// The inner end wall.
    Hub,
    /// The outer end wall.
    Shroud,
    /// Anything else: rims, faces, other channels.
    Elsewhere,
}

impl Surface {
    /// Name in a sentence, e.g. `"low wall"`.
    pub fn name(self) -> &'static str {
        match self {
            Self::LowWall => "low wall",
            Self::HighWall => "high wall",
            Self::Hub => "hub",
            Self::Shroud => "shroud",
            Self::Elsewhere => "blisk outside the channel",
        }
    }
}

/// One wall of a channel: a structured grid of points on the finished surface, ordered along the chord
/// (`u`, from the -X edge to the +X edge) and from the hub outwards (`v`). This is the ordered point set that
/// the angle constraint of P0 needs.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelWall {
    /// Points along the chord.
    pub nu: usize,
    /// Points from hub to shroud.
    pub nv: usize,
    /// `nu * nv` points in W (mm), index `u * nv + v`.
    pub points: Vec<DVec3>,
    /// Unit normals at the points, pointing into the channel.
    pub normals: Vec<DVec3>,
    /// Face of the blade that the wall is.
    pub side: BladeSide,
}

impl ChannelWall {
    /// The point at grid position (`u`, `v`).
    pub fn point(&self, u: usize, v: usize) -> DVec3 {
        self.points[u * self.nv + v]
    }

    /// The normal into the channel at grid position (`u`, `v`).
    pub fn normal(&self, u: usize, v: usize) -> DVec3 {
        self.normals[u * self.nv + v]
    }

    /// Cylindrical coordinates of the point at grid position (`u`, `v`).
    pub fn cylindrical(&self, u: usize, v: usize) -> Cylindrical {
        Cylindrical::from_point(self.point(u, v))
    }
}

/// The bounds of the passage in the meridional plane, sampled along X over the whole width of the blisk's ring.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MeridianSample {
    /// Position along X (mm).
    pub x: f64,
    /// Radius of the hub here: the greatest over the channel's middle part, since a mesh's facets dip (mm).
    pub hub: f64,
    /// Radius of the shroud (the least over the channel's middle part) or of the blade tips (mm).
    pub shroud: f64,
}

/// The narrowest place between the two walls.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Throat {
    /// Least distance between the two walls (mm).
    pub width_mm: f64,
    /// End on the low wall, in W (mm).
    pub on_low_wall: DVec3,
    /// End on the high wall, in W (mm).
    pub on_high_wall: DVec3,
}

/// How well one surface of a channel agrees with the mesh.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Agreement {
    /// The surface.
    pub surface: Surface,
    /// Places measured.
    pub samples: usize,
    /// Share of them that agree within their tolerance, 0 to 1.
    pub share: f64,
    /// Greatest distance along the radius (hub, shroud) or along the normal (walls) (mm); infinite, `null` in JSON, where
    /// the mesh has no such surface at all.
    pub greatest_mm: f64,
    /// Where that is, in W (mm).
    pub at: DVec3,
    /// Share of the places that are further off than any error of measurement, 0 to 1.
    pub doubted: f64,
}

/// One channel of a blisk. All coordinates are in W: X is the blisk axis, the channel's middle lies on +Z.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// W in the coordinates of the loaded mesh (mm).
    pub frame: Frame,
    /// Number of blades around the blisk.
    pub blades: usize,
    /// Number of the channel, counted from the mesh's own reference direction in the sense of theta.
    pub index: usize,
    /// Whether the passage is closed by a shroud; if not, `shroud` radii are blade tip radii.
    pub shrouded: bool,
    /// Hub and shroud radii in order of rising x. Outside the blades' span they describe the rings beside
    /// them, as far as these reach.
    pub meridian: Vec<MeridianSample>,
    /// The wall on the side of smaller theta.
    pub low: ChannelWall,
    /// The wall on the side of greater theta.
    pub high: ChannelWall,
    /// Narrowest place between the walls.
    pub throat: Throat,
    /// Turn of the middle line between its two ends, seen along the radius (rad).
    pub turning: f64,
    /// X extent of the blisk at the channel's radii: its two faces (mm).
    pub faces_x: [f64; 2],
    /// How well the walls, the hub and the shroud agree with the mesh, measured between the places that they were found
    /// from. Empty for a channel that was not found in a mesh.
    pub agreement: Vec<Agreement>,
    /// Assumptions made in finding the channel, in plain sentences for the user.
    pub assumed: Vec<String>,
}

impl Channel {
    /// Least and greatest x of the blades over both walls and all radii: the span between the edges (mm).
    pub fn span_x(&self) -> [f64; 2] {
        let xs = self.low.points.iter().chain(&self.high.points).map(|p| p.x);
        xs.fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], x| [lo.min(x), hi.max(x)])
    }

    /// Hub and shroud (or tip) radius at `x`, linear between samples and constant beyond the ends (mm).
    pub fn radii_at(&self, x: f64) -> (f64, f64) {
        radii_at(&self.meridian, x)
    }

    /// The name of `surface` for a reader, e.g. `"suction wall"`.
    pub fn surface_name(&self, surface: Surface) -> &'static str {
        let wall = |side, otherwise| match side {
            BladeSide::Suction => "suction wall",
            BladeSide::Pressure => "pressure wall",
            BladeSide::Flat => otherwise,
        };
        match surface {
            Surface::LowWall => wall(self.low.side, "wall on the low-theta side"),
            Surface::HighWall => wall(self.high.side, "wall on the high-theta side"),
            other => other.name(),
        }
    }
}

/// Hub and shroud (or tip) radius at `x` among samples in order of rising x: linear between them and constant
/// beyond the ends (mm). Without samples both are NaN.
pub(super) fn radii_at(meridian: &[MeridianSample], x: f64) -> (f64, f64) {
    let i = meridian.partition_point(|s| s.x < x);
    let Some(b) = meridian.get(i).or(meridian.last()) else { return (f64::NAN, f64::NAN) };
    let a = meridian.get(i.wrapping_sub(1)).unwrap_or(b);
    let t = if b.x > a.x { ((x - a.x) / (b.x - a.x)).clamp(0.0, 1.0) } else { 0.0 };
    (a.hub + t * (b.hub - a.hub), a.shroud + t * (b.shroud - a.shroud))
}
