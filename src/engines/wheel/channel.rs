//! The channel between two neighbouring blades of a blisk, in the workpiece frame W.

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use serde::Serialize;

use geometry::exact::{ExactMesh, ExactMeshError};
use geometry::frame::{Cylindrical, Frame};
use geometry::mesh::{Bounds, Mesh};

/// Face of its blade that a channel wall is, seen along the passage: against the meridional direction.
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
    /// A solid beside the blisk: a fixture, or another part.
    Obstacle,
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
            Self::Obstacle => "obstacle beside the blisk",
        }
    }
}

/// One wall of a channel: a structured grid of points on the finished surface, ordered along the chord
/// (`u`, from the edge at the beginning of the passage, -X in an axial one) and from the hub outwards (`v`). This is the ordered point set that
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

/// Direction of a passage in the meridional plane: the half plane through the axis, with coordinates (x, r).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Flow {
    /// Along the axis, within 45 degrees.
    Axial,
    /// From one to the other, or between both.
    Mixed,
    /// Along the radius, within 45 degrees.
    Radial,
}

impl Flow {
    /// Name in a sentence, e.g. `"radial"`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Axial => "axial",
            Self::Mixed => "mixed",
            Self::Radial => "radial",
        }
    }
}

/// A straight line across the passage in the meridional plane, from the hub to the shroud. The stations of an axial
/// channel are planes across X, as far as its rings reach.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Station {
    /// Position along the passage (mm): x in an axial channel, otherwise the length of the curve through the stations'
    /// middles.
    pub along: f64,
    /// Place of the hub (x, r) (mm). Of the radii met over the middle of the channel the greatest, since a mesh's
    /// facets dip.
    pub hub: DVec2,
    /// Place of the shroud or of the blade tips (x, r) (mm), found in the same way.
    pub shroud: DVec2,
}

impl Station {
    /// The station across the axis at `x` from radius `hub` to radius `shroud` (mm).
    pub fn across_axis(x: f64, hub: f64, shroud: f64) -> Self {
        Self { along: x, hub: DVec2::new(x, hub), shroud: DVec2::new(x, shroud) }
    }

    /// Place (x, r) at `share` of the way from the hub to the shroud (mm).
    pub fn place(&self, share: f64) -> DVec2 {
        self.hub + share * (self.shroud - self.hub)
    }

    /// Distance from hub to shroud (mm).
    pub fn height(&self) -> f64 {
        self.hub.distance(self.shroud)
    }
}

/// A passage opens in a direction where its end runs along it within 45 degrees (cosine).
pub(crate) const OPENS: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// The unit directions (x, r) in which a passage that is not axial runs out of its first and its last station; zero
/// where it has no length.
pub(crate) fn ways_out(stations: &[Station]) -> [DVec2; 2] {
    let [first, .., last] = stations else { return [DVec2::ZERO; 2] };
    let near = 0.1 * (last.along - first.along);
    let at = |along: f64| station_at(stations, along).place(0.5);
    let ways = [at(first.along) - at(first.along + near), at(last.along) - at(last.along - near)];
    ways.map(|way| way.normalize_or_zero())
}

/// A straight line across the passage in the meridional plane at any position along it: turned about the axis a plane
/// across X in an axial channel, else a cone, or a cylinder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Position along the passage (mm), x in an axial channel.
    pub along: f64,
    /// Where heights are counted from (x, r): the axis in an axial channel, else the hub.
    origin: DVec2,
    /// Direction from hub to shroud (x, r), a unit vector.
    pub up: DVec2,
    /// Heights of hub and shroud (mm).
    pub ends: [f64; 2],
}

impl Line {
    /// Place (x, r) at a height (mm).
    pub fn place(&self, height: f64) -> DVec2 {
        self.origin + height * self.up
    }

    /// Distance from the axis at a height (mm).
    pub fn radius(&self, height: f64) -> f64 {
        self.place(height).y
    }

    /// The point in W at a height (mm) and an angle (rad).
    pub fn point(&self, height: f64, theta: f64) -> DVec3 {
        let DVec2 { x, y: r } = self.place(height);
        Cylindrical { x, r, theta }.point()
    }
}

/// The numbers of the channels of a wheel by places in them.
#[derive(Debug, Clone)]
pub struct ChannelNumbers {
    /// Places (x, r) all over the low and the high wall of a channel (mm), and the angle of the wall there (rad).
    walls: [Vec<(DVec2, f64)>; 2],
    /// Number of this channel.
    index: usize,
    /// Number of channels.
    blades: usize,
}

impl ChannelNumbers {
    /// Number of the channel whose low or high wall (`wall` 0 or 1) the place `p` lies on, or without a wall the one that it
    /// lies in (mm, in W of a channel).
    pub fn at(&self, p: DVec3, wall: Option<usize>) -> usize {
        let Cylindrical { x, r, theta } = Cylindrical::from_point(p);
        let off = |(place, _): &&(DVec2, f64)| place.distance_squared(DVec2::new(x, r));
        let angle = |nodes: &Vec<(DVec2, f64)>| {
            nodes.iter().min_by(|a, b| off(a).total_cmp(&off(b))).map_or(0.0, |(_, theta)| *theta)
        };
        let reference = match wall {
            Some(wall) => angle(&self.walls[wall]),
            None => {
                let [low, high] = [0, 1].map(|wall| angle(&self.walls[wall]));
                low + 0.5 * (high - low).rem_euclid(TAU)
            }
        };
        let pitches = ((theta - reference) * self.blades as f64 / TAU).round() as i64;
        (self.index as i64 + pitches).rem_euclid(self.blades as i64) as usize
    }
}

/// The narrowest place between the two blades, as if they had no fillets: in place of those they go on straight to hub and
/// shroud.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Throat {
    /// Least distance between the two blades (mm).
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
    /// Share of them that agree, 0 to 1.
    pub share: f64,
    /// Distance up to which a place agrees, beside the mesh's own chord error there (mm).
    pub within_mm: f64,
    /// Greatest distance along the radius (hub, shroud) or along the normal (walls) (mm); infinite, `null` in JSON,
    /// where the mesh has no such surface at all.
    pub greatest_mm: f64,
    /// Where that is, in W (mm).
    pub at: DVec3,
    /// Share of the places, beside these, at which holes leave a hub or a shroud open, 0 to 1.
    pub open: f64,
    /// How far the mesh's hub or shroud lies beyond one that was given by hand, at most (mm).
    pub left_mm: f64,
}

/// A channel that is not like the chosen one turned about the axis, though it is of its kind.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unlike {
    /// Number of the channel.
    pub number: usize,
    /// What differs most.
    pub difference: Difference,
}

/// What differs between two channels of one kind.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Difference {
    /// A surface is elsewhere.
    Surface {
        /// The surface.
        surface: Surface,
        /// Greatest distance (mm); infinite where the surface is missing, or too far off to be found.
        greatest_mm: f64,
    },
    /// Only one of them is covered where blade tips are.
    Tips,
    /// The blades end elsewhere, or other metal stands beside their edges.
    BesideEdges,
    /// Metal stands in the passage, off its walls.
    Obstructed {
        /// How far within it (mm).
        off_mm: f64,
    },
}

impl std::fmt::Display for Difference {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Surface { surface, greatest_mm } if greatest_mm.is_finite() => {
                write!(f, "{} off by up to {greatest_mm:.3} mm", surface.name())
            }
            Self::Surface { surface, .. } => {
                write!(f, "{} missing in part, or too far off to be found", surface.name())
            }
            Self::Tips => f.write_str("tips covered otherwise"),
            Self::BesideEdges => f.write_str("metal beside its edges that the other has not"),
            Self::Obstructed { off_mm } => write!(f, "metal stands up to {off_mm:.3} mm within it"),
        }
    }
}

/// Where the blades of a channel stand, about the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BladeSpan {
    x: [f64; 2],
    /// Every radius in an axial channel, where blades bound the passage at every radius that matters.
    r: Option<[f64; 2]>,
}

impl BladeSpan {
    /// Whether `p`, in W, is as far along the passage as blades stand.
    pub fn contains(&self, p: DVec3) -> bool {
        (self.x[0]..=self.x[1]).contains(&p.x)
            && self.r.is_none_or(|[least, most]| (least..=most).contains(&p.y.hypot(p.z)))
    }
}

/// One channel of a blisk: the passage between two blades, hub and shroud. All coordinates are in W: X is the blisk
/// axis, the channel's middle lies on +Z; a passage that opens at the rim runs out there along +Z, seen along the axis.
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
    /// Direction of the passage.
    pub flow: Flow,
    /// Hub and shroud along the passage, in order of rising `along`. Outside the blades' span they describe the rings
    /// beside them, as far as these reach.
    pub meridian: Vec<Station>,
    /// The wall on the side of smaller theta.
    pub low: ChannelWall,
    /// The wall on the side of greater theta.
    pub high: ChannelWall,
    /// Narrowest place between the blades.
    pub throat: Throat,
    /// Turn of the middle line between its two ends, seen along the radius or, outside axial flow, square to the
    /// meridional direction (rad).
    pub turning: f64,
    /// X extent of the blisk at the channel's radii: its two faces (mm).
    pub faces_x: [f64; 2],
    /// How well the walls, the hub and the shroud agree with the mesh, measured between the places that they were found
    /// from. Empty for a channel that was not found in a mesh.
    pub agreement: Vec<Agreement>,
    /// Number of kinds of channels: every so many channels are of one kind; more than 1 where there are splitters.
    pub kinds: usize,
    /// Numbers of the channels of this one's kind whose surfaces, or blades beside their edges, are not those of this
    /// one turned about the axis.
    pub unlike: Vec<Unlike>,
    /// The whole wheel in the coordinates of the loaded mesh, where that is only a sector of it.
    pub whole: Option<Arc<Mesh>>,
    /// Solids beside the wheel that are in the way, in the coordinates of the loaded mesh. The channel is found without
    /// them.
    pub obstacles: Option<Arc<Mesh>>,
    /// Assumptions made in finding the channel, in plain sentences for the user.
    pub assumed: Vec<String>,
}

impl Channel {
    /// The wheel in W: the loaded `mesh` that the channel was found in, or the whole wheel that it is a sector of; and
    /// after it the obstacles beside it.
    pub fn wheel_in_w(&self, mesh: &Mesh) -> Mesh {
        let mut all = self.whole.as_deref().unwrap_or(mesh).in_frame(&self.frame);
        if let Some(obstacles) = self.obstacles_in_w() {
            all.append(&obstacles);
        }
        all
    }

    /// The obstacles beside the wheel, in W.
    pub fn obstacles_in_w(&self) -> Option<Mesh> {
        self.obstacles.as_ref().map(|obstacles| obstacles.in_frame(&self.frame))
    }

    /// The box around the channel that an electrode moves in, in `wheel`, which is in W.
    pub fn surroundings(&self, wheel: &Mesh) -> Bounds {
        /// Reach beside the walls, as a share of the pitch: the electrode swings there.
        const BESIDE: f64 = 0.75;
        let walls = Bounds::of(self.low.points.iter().chain(&self.high.points).copied());
        let [front, back] = self.faces_x;
        let beside = BESIDE * std::f64::consts::TAU / self.blades as f64 * walls.max.z;
        let shroud = self.meridian.iter().map(|m| m.shroud.y).fold(walls.max.z, f64::max);
        // Where electrodes may leave along the radius, up to the rim.
        let top = match self.flow {
            Flow::Axial => shroud,
            _ => wheel.vertices.iter().map(|p| p.y.hypot(p.z)).fold(shroud, f64::max),
        };
        Bounds {
            min: DVec3::new(front - 1.0, walls.min.y - beside, self.bottom(walls.min.z - 3.0, beside)),
            max: DVec3::new(back + 1.0, walls.max.y + beside, top + 2.0),
        }
    }

    /// Least z that an electrode moves in, of which `bottom` is that between the walls and `beside` how far it swings (mm):
    /// down to the bore where the passage opens to it below Z.
    fn bottom(&self, bottom: f64, beside: f64) -> f64 {
        let [first, last] = ways_out(&self.meridian);
        let column = if last.y < first.y { self.low.nu - 1 } else { 0 };
        let mouth = [&self.low, &self.high].map(|wall| wall.point(column, wall.nv / 2));
        let farthest = mouth.iter().map(|p| p.y.abs()).fold(0.0, f64::max);
        let bore = self.meridian.iter().map(|m| m.hub.y.min(m.shroud.y)).fold(f64::INFINITY, f64::min);
        let is_above_bore = self.flow != Flow::Axial && -first.y.min(last.y) >= OPENS && farthest < beside;
        if is_above_bore { bottom.min((bore * bore - (farthest + beside).powi(2)).max(0.0).sqrt()) } else { bottom }
    }

    /// `wheel`, which is in W, made ready for exact distances in the channel and around it.
    ///
    /// # Errors
    /// If the mesh cannot be searched.
    pub fn exact(&self, wheel: &Arc<Mesh>) -> Result<ExactMesh, ExactMeshError> {
        /// Distances up to this are asked for beside the box that an electrode moves in (mm).
        const REACH: f64 = 12.0;
        ExactMesh::around(wheel.clone(), self.surroundings(wheel).grown(REACH))
    }

    /// Least and greatest x of the blades over both walls and all radii: the span between the edges (mm).
    pub fn span_x(&self) -> [f64; 2] {
        let xs = self.low.points.iter().chain(&self.high.points).map(|p| p.x);
        xs.fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], x| [lo.min(x), hi.max(x)])
    }

    /// Hub and shroud (or tip) radius of an axial channel at `x`, linear between stations and constant beyond the ends
    /// (mm).
    pub fn radii_at(&self, x: f64) -> (f64, f64) {
        radii_at(&self.meridian, x)
    }

    /// The station at a position along the passage, linear between stations; beyond the ends the last one.
    pub fn station_at(&self, along: f64) -> Station {
        station_at(&self.meridian, along)
    }

    /// The line across the passage at a position along it; beyond its ends the passage goes straight on.
    pub fn line_at(&self, along: f64) -> Line {
        if self.flow == Flow::Axial {
            let (hub, shroud) = self.radii_at(along);
            return Line { along, origin: DVec2::new(along, 0.0), up: DVec2::Y, ends: [hub, shroud] };
        }
        let station = self.station_at(along);
        let up = (station.shroud - station.hub).normalize_or(DVec2::Y);
        let ([front, back], [first, last]) = (self.ends_along(), ways_out(&self.meridian));
        let beyond = (front - along).max(0.0) * first + (along - back).max(0.0) * last;
        Line { along, origin: station.hub + beyond, up, ends: [0.0, station.height()] }
    }

    /// Direction (x, r) of the passage at a position along it and a share of its height, a unit vector.
    pub fn forward(&self, along: f64, share: f64) -> DVec2 {
        let [first, last] = self.ends_along();
        let near = 0.01 * (last - first);
        let at = |along: f64| self.station_at(along.clamp(first, last)).place(share);
        (at(along + near) - at(along - near)).normalize_or_zero()
    }

    /// Direction (x, r) square to `line`, from the inlet of the passage to its outlet, a unit vector.
    pub fn across(&self, line: &Line) -> DVec2 {
        let across = -line.up.perp();
        if across.dot(self.forward(line.along, 0.5)) < 0.0 { -across } else { across }
    }

    /// Position along the passage of the place (x, r), and its height on the line across the passage there (mm).
    pub fn along_and_height(&self, place: DVec2) -> [f64; 2] {
        const ROUNDS: usize = 30;
        if self.flow == Flow::Axial {
            return [place.x, place.y];
        }
        let (mut share, mut found) = (0.5, [f64::NAN; 2]);
        let mut before = [f64::NAN; 2];
        for _ in 0..ROUNDS {
            let station = self.station_at(along_at(&self.meridian, place, share));
            let height = (place - station.hub).dot((station.shroud - station.hub).normalize_or(DVec2::Y));
            found = [station.along, height];
            let next = height / station.height().max(f64::MIN_POSITIVE);
            let step = next - share;
            if step.abs() < 1e-12 {
                break;
            }
            // The secant through this step and the one before leads to where there is none, if it does not lead far.
            let secant = share - step * (share - before[0]) / (step - before[1]);
            before = [share, step];
            share = if (secant - next).abs() <= step.abs() { secant } else { next };
        }
        found
    }

    /// Where the blades stand: between two planes across X in an axial channel, else also between two radii.
    pub fn blade_span(&self) -> BladeSpan {
        let radii = self.low.points.iter().chain(&self.high.points).map(|p| p.y.hypot(p.z));
        let r = radii.fold([f64::INFINITY, 0.0], |[least, most], r| [r.min(least), r.max(most)]);
        BladeSpan { x: self.span_x(), r: (self.flow != Flow::Axial).then_some(r) }
    }

    /// Least and greatest position of the blades along the passage over both walls and all heights (mm).
    pub fn span_along(&self) -> [f64; 2] {
        if self.flow == Flow::Axial {
            return self.span_x();
        }
        let places = self.low.points.iter().chain(&self.high.points).map(|p| DVec2::new(p.x, p.y.hypot(p.z)));
        let alongs = places.map(|place| self.along_and_height(place)[0]);
        alongs.fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], a| [lo.min(a), hi.max(a)])
    }

    /// Where the rings beside the blades end along the passage (mm): at the faces in an axial channel.
    pub fn ends_along(&self) -> [f64; 2] {
        match (self.flow, &self.meridian[..]) {
            (Flow::Mixed | Flow::Radial, [first, .., last]) => [first.along, last.along],
            _ => self.faces_x,
        }
    }

    /// Whether channel `number` is this one turned about the axis, so that what is planned for this one fits it.
    pub fn is_like(&self, number: usize) -> bool {
        number.abs_diff(self.index).is_multiple_of(self.kinds)
            && !self.unlike.iter().any(|unlike| unlike.number == number)
    }

    /// The numbers of the channels by places in them.
    pub fn numbers(&self) -> ChannelNumbers {
        let of = |wall: &ChannelWall| {
            let node = |p: &DVec3| {
                let Cylindrical { x, r, theta } = Cylindrical::from_point(*p);
                (DVec2::new(x, r), theta)
            };
            wall.points.iter().map(node).collect()
        };
        ChannelNumbers { walls: [of(&self.low), of(&self.high)], index: self.index, blades: self.blades }
    }

    /// What differs most between one of [`unlike`](Self::unlike) and this channel, for a reader: `"hub 0.412 mm off"`.
    pub fn difference(&self, unlike: &Unlike) -> String {
        match unlike.difference {
            Difference::Surface { surface, greatest_mm } if greatest_mm.is_finite() => {
                format!("{} {greatest_mm:.3} mm off", self.surface_name(surface))
            }
            Difference::Surface { surface, .. } => format!("no {}", self.surface_name(surface)),
            Difference::Tips => "other cover of its tips".to_owned(),
            Difference::BesideEdges => "other metal beside it".to_owned(),
            Difference::Obstructed { off_mm } => format!("metal {off_mm:.3} mm within it"),
        }
    }

    /// The station in the middle of the blades along the passage.
    pub fn middle(&self) -> Station {
        let [from, to] = self.span_along();
        self.station_at(0.5 * (from + to))
    }

    /// How far the place (x, r) lies within the shroud, negative beyond it (mm).
    pub fn below_shroud(&self, place: DVec2) -> f64 {
        if self.flow == Flow::Axial {
            return self.radii_at(place.x).1 - place.y;
        }
        let along = along_at(&self.meridian, place, 1.0);
        let station = station_at(&self.meridian, along);
        (station.shroud - place).dot((station.shroud - station.hub).normalize_or(DVec2::Y))
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

/// The station at `along`, linear between stations; beyond the ends the last one. Without stations it is NaN.
pub(super) fn station_at(meridian: &[Station], along: f64) -> Station {
    let i = meridian.partition_point(|s| s.along < along);
    let Some(b) = meridian.get(i).or(meridian.last()) else {
        return Station { along, hub: DVec2::NAN, shroud: DVec2::NAN };
    };
    let a = meridian.get(i.wrapping_sub(1)).unwrap_or(b);
    let t = if b.along > a.along { ((along - a.along) / (b.along - a.along)).clamp(0.0, 1.0) } else { 0.0 };
    Station { along, hub: a.hub + t * (b.hub - a.hub), shroud: a.shroud + t * (b.shroud - a.shroud) }
}

/// Position along the passage of the point of the curve at `share` of the height that is nearest to `place` (x, r).
/// Without stations it is NaN.
pub(super) fn along_at(meridian: &[Station], place: DVec2, share: f64) -> f64 {
    let feet = meridian.windows(2).map(|pair| {
        let (from, to) = (pair[0].place(share), pair[1].place(share));
        let way = to - from;
        let t = if way == DVec2::ZERO { 0.0 } else { ((place - from).dot(way) / way.length_squared()).clamp(0.0, 1.0) };
        (place.distance_squared(from + t * way), pair[0].along + t * (pair[1].along - pair[0].along))
    });
    feet.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(f64::NAN, |(_, along)| along)
}

/// Hub and shroud (or tip) radius of stations across the axis at `x` (mm).
pub(super) fn radii_at(meridian: &[Station], x: f64) -> (f64, f64) {
    let station = station_at(meridian, x);
    (station.hub.y, station.shroud.y)
}
