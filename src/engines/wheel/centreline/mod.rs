//! The centreline of a channel (P1): in each section circles inscribed between the two walls, their centres joined, the
//! middle of all sections, and a NURBS curve through it.
//!
//! A section is the curve of both walls at the same share of the height. It is unrolled into a plane of meridional
//! length and of arc length at its mean radius, where the circles are found; where the passage does not run along the axis,
//! meridional lengths are scaled as arcs are at each radius, so that the plane keeps angles. The circles' centres are taken
//! back to space by the true places of the two points of contact, so that unrolling costs an error of second order along
//! the channel only.
//!
//! Between blades that hardly overlap, or that wind far around the axis, such circles do not lead through the passage: they
//! leave it, or hardly any fits. The centreline is then half way between both walls at each position along the passage.

mod blade_circles;
mod summary;
#[cfg(test)]
mod tests;

use std::ops::RangeInclusive;

use glam::{DVec2, DVec3};

pub use self::blade_circles::{BladeCircle, blade_circles};
pub use self::summary::{CentrelineSummary, WallFit};
use crate::channel::{Channel, Flow};
use crate::inscribed::{CurvePair, InscribedCircle};
use crate::nurbs_wall::NurbsWall;
use crate::passage::Passage;
use geometry::frame::{Cylindrical, angle_near};
use geometry::nurbs::{FitError, NurbsCurve, NurbsError};
use task::{Cancel, Cancelled};

/// A circle between the walls, in W.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChannelCircle {
    /// Centre of the circle (mm).
    pub center: DVec3,
    /// Radius of the circle (mm).
    pub radius: f64,
    /// Contacts with the low and the high wall (mm).
    pub contacts: [DVec3; 2],
}

/// The centreline with what it was made from.
#[derive(Debug, Clone, PartialEq)]
pub struct Centreline {
    curve: NurbsCurve,
    /// Circles of each section, from the hub outwards, in order along the channel; none where the line is half way
    /// between the walls.
    pub sections: Vec<Vec<ChannelCircle>>,
    /// Distances of the curve from the middles of the sections, half of which it was fitted to.
    pub fit: FitError,
    /// Lengths along the curve at evenly spaced parameters (mm).
    lengths: Vec<f64>,
}

/// Reason why there is no centreline.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum CentrelineError {
    /// The walls or the middles cannot be joined.
    #[error("the channel's centreline was not found: {0}")]
    Nurbs(#[from] NurbsError),
    /// The walls do not face each other.
    #[error(
        "the channel's centreline was not found: in {found} of {sections} sections a circle fits between the walls; \
         more than half must have one"
    )]
    NoPassage {
        /// Sections with circles.
        found: usize,
        /// Sections tested.
        sections: usize,
    },
    /// The middles fold back.
    #[error("the channel's centreline folds back at x = {x:.2} mm, radius {r:.2} mm; look at the walls there")]
    Folds {
        /// Where along X (mm).
        x: f64,
        /// Radius of the place (mm).
        r: f64,
    },
    /// Cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// What orders places along a passage.
#[derive(Clone, Copy)]
enum Order<'a> {
    /// x.
    X,
    /// The position along the passage of a channel.
    Along(&'a Channel),
}

impl Order<'_> {
    fn of(&self, p: DVec3) -> f64 {
        let Cylindrical { x, r, .. } = Cylindrical::from_point(p);
        let place = DVec2::new(x, r);
        let Self::Along(channel) = self else { return x };
        let [along, height] = channel.along_and_height(place);
        let share = height / channel.station_at(along).height();
        let [first, last] = channel.ends_along();
        match along > first && along < last {
            true => along,
            false => along + (place - channel.line_at(along).place(height)).dot(channel.forward(along, share)),
        }
    }

    /// Whether `p` is between hub and shroud: beside edges a circle may touch both walls far from the passage.
    fn holds(self, p: DVec3) -> bool {
        let Self::Along(channel) = self else { return true };
        let [along, height] = channel.along_and_height(DVec2::new(p.x, p.y.hypot(p.z)));
        (0.0..=channel.station_at(along).height()).contains(&height)
    }
}

/// Place (x, r) at a position along the passage of `channel` and a share of its height; beyond the passage's ends it goes
/// straight on.
fn place_at(channel: &Channel, along: f64, share: f64) -> DVec2 {
    let [first, last] = channel.ends_along();
    let within = along.clamp(first, last);
    let beyond = along - within;
    let place = channel.station_at(within).place(share);
    if beyond == 0.0 { place } else { place + beyond * channel.forward(within, share) }
}

impl Centreline {
    /// Sections.
    const SECTIONS: usize = 9;
    /// Circles in each.
    const CIRCLES: usize = 81;
    /// Middles along the channel; the curve goes through every other one.
    const MIDDLES: usize = 81;
    /// Circles nearer together than this are one (mm).
    const SAME: f64 = 1e-6;
    /// Intervals of the table of lengths.
    const TABLE: usize = 256;
    /// Share of the length over which the direction beyond an end is taken: circles at the very mouth of a channel
    /// lean on the round edge of one blade.
    const MOUTH: f64 = 0.05;
    /// Least and greatest share of the passage's width, and of its height, that the line has on one side of it.
    const IN_THE_MIDDLE: RangeInclusive<f64> = 0.2..=0.8;

    /// The centreline of `channel`.
    ///
    /// # Errors
    /// [`CentrelineError`].
    pub fn of_channel(channel: &Channel, cancel: &Cancel) -> Result<Self, CentrelineError> {
        let [low, high] = NurbsWall::of_channel(channel)?;
        let order = if channel.flow == Flow::Axial { Order::X } else { Order::Along(channel) };
        let passage = Passage::new(channel).ok_or(NurbsError::Counts)?;
        match Self::ordered(&low, &high, order, cancel) {
            Ok(line) if line.is_in_the_middle_of(&passage) => Ok(line),
            Err(CentrelineError::Cancelled(cancelled)) => Err(cancelled.into()),
            Err(error) => Self::half_way(&passage, order).map_err(|_| error),
            Ok(_) => Self::half_way(&passage, order),
        }
    }

    /// The line half way between the walls, and between hub and shroud, from edge to edge of the blades.
    fn half_way(passage: &Passage, order: Order) -> Result<Self, CentrelineError> {
        let channel = passage.channel();
        let end = |u: usize, v: usize| [&channel.low, &channel.high].map(|wall| order.of(wall.point(u, v)));
        let mean = |u: usize| {
            let alongs = (0..channel.low.nv).flat_map(|v| end(u, v));
            alongs.sum::<f64>() / (2 * channel.low.nv) as f64
        };
        let [from, to] = [mean(0), mean(channel.low.nu - 1)];
        let middle = |i: usize| {
            let line = channel.line_at(from + (to - from) * i as f64 / (Self::MIDDLES - 1) as f64);
            let height = 0.5 * (line.ends[0] + line.ends[1]);
            let [low, high] = passage.between(line.along, height);
            line.point(height, 0.5 * (low + high))
        };
        Self::through(&(0..Self::MIDDLES).map(middle).collect::<Vec<_>>(), Vec::new(), order)
    }

    /// Whether the line keeps off walls, hub and shroud of the passage that it belongs to.
    fn is_in_the_middle_of(&self, passage: &Passage) -> bool {
        (0..=Self::TABLE).all(|i| {
            let p = self.curve.point(i as f64 / Self::TABLE as f64);
            let [along, height] = passage.along_and_height(p);
            let [hub, shroud] = passage.channel().line_at(along).ends;
            let [low, high] = passage.between(along, height);
            let theta = angle_near(Cylindrical::from_point(p).theta, 0.5 * (low + high));
            let shares = [(theta - low) / (high - low), (height - hub) / (shroud - hub)];
            shares.iter().all(|share| Self::IN_THE_MIDDLE.contains(share))
        })
    }

    /// The centreline between two walls along X whose sections belong together.
    ///
    /// # Errors
    /// [`CentrelineError`].
    pub fn between(low: &NurbsWall, high: &NurbsWall, cancel: &Cancel) -> Result<Self, CentrelineError> {
        Self::ordered(low, high, Order::X, cancel)
    }

    fn ordered(low: &NurbsWall, high: &NurbsWall, order: Order, cancel: &Cancel) -> Result<Self, CentrelineError> {
        let mut sections = Vec::new();
        for k in 0..Self::SECTIONS {
            cancel.check()?;
            let share = (k as f64 + 0.5) / Self::SECTIONS as f64;
            let section = Section::new(low, high, share, order)?;
            sections.extend(section.circles()?.map(|circles| (circles, section.span())));
        }
        if 2 * sections.len() <= Self::SECTIONS {
            return Err(CentrelineError::NoPassage { found: sections.len(), sections: Self::SECTIONS });
        }
        let middles = middles(&sections, order)?;
        for (circles, [from, to]) in &mut sections {
            circles.retain(|c| (*from..=*to).contains(&order.of(c.center)) && order.holds(c.center));
        }
        Self::through(&middles, sections.into_iter().map(|(circles, _)| circles).collect(), order)
    }

    /// The line through `middles`, which follow each other along the passage.
    fn through(middles: &[DVec3], sections: Vec<Vec<ChannelCircle>>, order: Order) -> Result<Self, CentrelineError> {
        let through: Vec<DVec3> = middles.iter().copied().step_by(2).collect();
        let curve = NurbsCurve::cubic(&through, None)?;
        let back = middles.windows(2).find(|pair| order.of(pair[1]) <= order.of(pair[0]));
        if let Some([place, _]) = back {
            return Err(CentrelineError::Folds { x: place.x, r: place.y.hypot(place.z) });
        }
        let fit = FitError::of(middles.iter().map(|p| curve.nearest(*p).distance));
        let at = |i: usize| i as f64 / Self::TABLE as f64;
        let mut lengths = vec![0.0];
        for i in 0..Self::TABLE {
            lengths.push(lengths[i] + curve.length(at(i), at(i + 1)));
        }
        Ok(Self { curve, sections, fit, lengths })
    }

    /// The curve, from the beginning of the passage, -X in an axial one, parameters 0 to 1, in W.
    pub fn curve(&self) -> &NurbsCurve {
        &self.curve
    }

    /// Length of the centreline (mm).
    pub fn length(&self) -> f64 {
        self.lengths[Self::TABLE]
    }

    /// Place and direction at arc length `l` from the beginning of the passage (mm); beyond both ends it goes straight on.
    pub fn at_length(&self, l: f64) -> [DVec3; 2] {
        let length = self.length();
        let mouth = Self::MOUTH * length;
        if l < 0.0 {
            let [start, inner] = [self.curve.point(0.0), self.curve.point(self.parameter(mouth))];
            let direction = (inner - start).normalize_or(DVec3::X);
            return [start + direction * l, direction];
        }
        if l > length {
            let [end, inner] = [self.curve.point(1.0), self.curve.point(self.parameter(length - mouth))];
            let direction = (end - inner).normalize_or(DVec3::X);
            return [end + direction * (l - length), direction];
        }
        let u = self.parameter(l);
        [self.curve.point(u), self.curve.tangent(u)]
    }

    /// The parameter at arc length `l` within the curve.
    fn parameter(&self, l: f64) -> f64 {
        const ROUNDS: usize = 8;
        let i = self.lengths.partition_point(|known| *known <= l).clamp(1, Self::TABLE) - 1;
        let [u0, u1] = [i, i + 1].map(|i| i as f64 / Self::TABLE as f64);
        let mut u = u0 + (u1 - u0) * (l - self.lengths[i]) / (self.lengths[i + 1] - self.lengths[i]);
        for _ in 0..ROUNDS {
            let speed = self.curve.at(u)[1].length();
            let step = (l - self.lengths[i] - self.curve.length(u0, u)) / speed;
            if !step.is_finite() || step.abs() < 1e-12 {
                break;
            }
            u = (u + step).clamp(u0, u1);
        }
        u
    }

    /// The arc length of the place where the line, with its straight ends, passes through the plane at `x`; by halving,
    /// for lines that run along X throughout.
    pub fn length_at_x(&self, x: f64) -> f64 {
        let far = 1e4 + self.length();
        let (mut low, mut high) = (-far, far);
        for _ in 0..80 {
            let middle = 0.5 * (low + high);
            if self.at_length(middle)[0].x < x {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    }

    /// The arc length of the place nearest to `p` on the line, its straight ends left out.
    pub fn length_near(&self, p: DVec3) -> f64 {
        const ROUNDS: usize = 100;
        let distance = |l: f64| self.at_length(l)[0].distance_squared(p);
        let off = |i: &usize| distance(self.lengths[*i]);
        let best = (0..=Self::TABLE).min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(0);
        let (mut low, mut high) = (self.lengths[best.saturating_sub(1)], self.lengths[(best + 1).min(Self::TABLE)]);
        for _ in 0..ROUNDS {
            let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
            if distance(a) < distance(b) {
                high = b;
            } else {
                low = a;
            }
        }
        0.5 * (low + high)
    }

    /// The arc length at which the line, followed from `from` towards its end (`sign` 1) or its beginning (-1) and
    /// straight on, comes as far as `value` along `direction`; `from` where it is so far already.
    pub fn length_reaching(&self, (direction, value): (DVec3, f64), from: f64, sign: f64) -> f64 {
        let is_there = |way: f64| self.at_length(from + sign * way)[0].dot(direction) >= value;
        let (mut low, mut high) = (0.0, 1e4 + self.length());
        if is_there(low) {
            return from;
        }
        for _ in 0..80 {
            let middle = 0.5 * (low + high);
            if is_there(middle) {
                high = middle;
            } else {
                low = middle;
            }
        }
        from + sign * 0.5 * (low + high)
    }

    /// Points for drawing, as many as given, from end to end.
    pub fn polyline(&self, points: usize) -> Vec<DVec3> {
        let steps = points.max(2) - 1;
        (0..=steps).map(|i| self.at_length(self.length() * i as f64 / steps as f64)[0]).collect()
    }

    /// Least and greatest diameter of the circles (mm); none where the line is half way between the walls.
    pub fn diameters(&self) -> Option<[f64; 2]> {
        let diameters = self.sections.iter().flatten().map(|c| [2.0 * c.radius; 2]);
        diameters.reduce(|[least, most], [d, _]| [least.min(d), most.max(d)])
    }
}

/// Both walls at a share of the height, unrolled.
struct Section<'a> {
    walls: [&'a NurbsWall; 2],
    /// Parameters of the walls across the sections.
    v: [f64; 2],
    order: Order<'a>,
    /// Rising position along the passage, and x, radius and meridional length there (mm).
    meridian: Vec<[f64; 4]>,
    mean_radius: f64,
    /// Angle of the low wall's first point (rad).
    start: f64,
}

impl<'a> Section<'a> {
    /// Pieces of the meridian.
    const PIECES: usize = 128;

    fn new(low: &'a NurbsWall, high: &'a NurbsWall, share: f64, order: Order<'a>) -> Result<Self, NurbsError> {
        let walls = [low, high];
        let v = walls.map(|wall| at_share(&wall.v, share));
        let on_wall = |i: usize| {
            let wall: &NurbsWall = walls[i];
            wall.u.iter().map(move |u| wall.surface.point(*u, v[i]))
        };
        let line = |i: usize| -> Vec<[f64; 2]> {
            let mut points: Vec<[f64; 2]> = on_wall(i).map(|p| [order.of(p), p.y.hypot(p.z)]).collect();
            points.sort_by(|a, b| a[0].total_cmp(&b[0]));
            points
        };
        let lines = [line(0), line(1)];
        let all = || lines.iter().flatten();
        let mean_radius = all().map(|p| p[1]).sum::<f64>() / all().count() as f64;
        let [from, to] = all().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], p| [a.min(p[0]), b.max(p[0])]);
        if to <= from {
            return Err(NurbsError::Counts);
        }
        let height = match order {
            Order::X => 0.0,
            Order::Along(channel) => mean_height(channel, on_wall(0).chain(on_wall(1))),
        };
        let mut meridian: Vec<[f64; 4]> = Vec::new();
        for i in 0..=Self::PIECES {
            let along = from + (to - from) * i as f64 / Self::PIECES as f64;
            let [x, r] = match order {
                Order::X => [along, 0.5 * (radius_at(&lines[0], along) + radius_at(&lines[1], along))],
                Order::Along(channel) => place_at(channel, along, height).to_array(),
            };
            let m = meridian.last().map_or(0.0, |[_, x0, r0, m0]| {
                let scale = if matches!(order, Order::X) { 1.0 } else { mean_radius / (0.5 * (r + r0)) };
                m0 + scale * (x - x0).hypot(r - r0)
            });
            meridian.push([along, x, r, m]);
        }
        let start = Cylindrical::from_point(low.surface.point(low.u[0], v[0])).theta;
        Ok(Self { walls, v, order, meridian, mean_radius, start })
    }

    /// Least and greatest position of both walls along the passage (mm).
    fn span(&self) -> [f64; 2] {
        [self.meridian[0][0], self.meridian[Self::PIECES][0]]
    }

    /// The piece of the meridian at a position along the passage: its start, and rates of x, radius and meridional
    /// length by that position.
    fn piece(&self, along: f64) -> ([f64; 4], [f64; 3]) {
        let i = self.meridian.partition_point(|m| m[0] <= along).clamp(1, self.meridian.len() - 1);
        let (a, b) = (self.meridian[i - 1], self.meridian[i]);
        (a, [1, 2, 3].map(|k| (b[k] - a[k]) / (b[0] - a[0])))
    }

    /// A wall as a curve of the plane, its parameter that of the wall's chord. Angles go on along the wall.
    fn curve(&self, wall: usize) -> Result<NurbsCurve, NurbsError> {
        let (u, mut before) = (&self.walls[wall].u, self.start);
        let mut unrolled = |p: DVec3| {
            let along = self.order.of(p);
            let (start, [.., rate]) = self.piece(along);
            before = angle_near(Cylindrical::from_point(p).theta, before);
            DVec3::new(start[3] + rate * (along - start[0]), self.mean_radius * before, 0.0)
        };
        let points: Vec<DVec3> = u.iter().map(|u| unrolled(self.on_wall(wall, *u))).collect();
        NurbsCurve::through_at(u, &points, 3, None)
    }

    fn on_wall(&self, wall: usize, u: f64) -> DVec3 {
        self.walls[wall].surface.point(u, self.v[wall])
    }

    /// The circles in order along the channel; none if no circle fits.
    fn circles(&self) -> Result<Option<Vec<ChannelCircle>>, NurbsError> {
        let curves = [self.curve(0)?, self.curve(1)?];
        let found = CurvePair::new(curves[0].clone(), curves[1].clone()).circles(Centreline::CIRCLES);
        let Some(found) = found else { return Ok(None) };
        let mut circles: Vec<ChannelCircle> = Vec::new();
        for circle in &found {
            let circle = self.in_space(circle, &curves);
            if circles.last().is_none_or(|last| last.center.distance(circle.center) > Centreline::SAME) {
                circles.push(circle);
            }
        }
        Ok((circles.len() > 3).then_some(circles))
    }

    /// A circle of the plane in space: the middle of its true points of contact, and from there what the centre lies
    /// beside their middle.
    fn in_space(&self, circle: &InscribedCircle, curves: &[NurbsCurve; 2]) -> ChannelCircle {
        let contacts = [0, 1].map(|i| self.on_wall(i, circle.contacts[i]));
        let middle = 0.5 * (contacts[0] + contacts[1]);
        let beside = circle.center - 0.5 * (curves[0].point(circle.contacts[0]) + curves[1].point(circle.contacts[1]));
        let Cylindrical { r, theta, .. } = Cylindrical::from_point(middle);
        let (_, [axial, radial, rate]) = self.piece(self.order.of(middle));
        let (sin, cos) = theta.sin_cos();
        let along = (DVec3::X * axial + DVec3::new(0.0, -sin, cos) * radial) / rate;
        let around = DVec3::new(0.0, -cos, -sin) * (r / self.mean_radius);
        let center = middle + along * beside.x + around * beside.y;
        let radius = 0.5 * (center.distance(contacts[0]) + center.distance(contacts[1]));
        ChannelCircle { center, radius, contacts }
    }
}

/// Mean height of `points` in the passage of `channel`, as a share of the whole.
fn mean_height(channel: &Channel, points: impl Iterator<Item = DVec3>) -> f64 {
    let share = |p: DVec3| {
        let [along, height] = channel.along_and_height(DVec2::new(p.x, p.y.hypot(p.z)));
        height / channel.station_at(along).height()
    };
    let (sum, count) = points.map(share).fold((0.0, 0.0), |(sum, count), share| (sum + share, count + 1.0));
    sum / count
}

/// The radius at `x` on a line of (x, r) with rising x, constant beyond its ends.
fn radius_at(line: &[[f64; 2]], x: f64) -> f64 {
    let i = line.partition_point(|p| p[0] <= x).clamp(1, line.len() - 1);
    let ([x0, r0], [x1, r1]) = (line[i - 1], line[i]);
    let t = if x1 > x0 { ((x - x0) / (x1 - x0)).clamp(0.0, 1.0) } else { 0.0 };
    r0 + t * (r1 - r0)
}

/// The parameter at a share of the rows from first to last.
fn at_share(v: &[f64], share: f64) -> f64 {
    let place = share * (v.len() - 1) as f64;
    let i = (place as usize).min(v.len() - 2);
    v[i] + (v[i + 1] - v[i]) * (place - i as f64)
}

/// The means of all sections at equal shares of their lengths between the ends of the walls. Beyond them circles touch
/// the blades' edges alone.
fn middles(sections: &[(Vec<ChannelCircle>, [f64; 2])], order: Order) -> Result<Vec<DVec3>, NurbsError> {
    let steps = Centreline::MIDDLES - 1;
    let mut sums = vec![DVec3::ZERO; Centreline::MIDDLES];
    for (circles, span) in sections {
        let line = NurbsCurve::through(&rising(circles, *span, order), 3)?;
        let [from, to] = span.map(|along| parameter_at(&line, along, order));
        for (i, sum) in sums.iter_mut().enumerate() {
            *sum += line.point(from + (to - from) * i as f64 / steps as f64);
        }
    }
    Ok(sums.into_iter().map(|sum| sum / sections.len() as f64).collect())
}

/// The centres of `circles` from the last one before the walls' ends `span` to the first one behind them. Those that do
/// not lie farther along the passage than what comes before are left out: a circle that touches a round edge moves with the facets
/// there, and one between two edges lies far off.
fn rising(circles: &[ChannelCircle], [from, to]: [f64; 2], order: Order) -> Vec<DVec3> {
    let first = circles.iter().rposition(|c| order.of(c.center) <= from).unwrap_or(0);
    let (mut centers, mut last): (Vec<DVec3>, _) = (Vec::new(), f64::NEG_INFINITY);
    for circle in &circles[first..] {
        let along = order.of(circle.center);
        if along > last + Centreline::SAME {
            centers.push(circle.center);
            last = along;
        }
        if along >= to {
            break;
        }
    }
    centers
}

/// The parameter where `line`, which runs along the passage, passes the position `along`, or that of the end nearer to
/// it.
fn parameter_at(line: &NurbsCurve, along: f64, order: Order) -> f64 {
    let [mut low, mut high] = line.domain();
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if order.of(line.point(middle)) < along {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}
