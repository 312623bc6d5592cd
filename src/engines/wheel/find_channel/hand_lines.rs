//! The lines across a passage whose hub or shroud is given by points on it, and the passage that points on blades bound.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::super::by_hand::{self, ByHand, nearest};
use super::super::channel::{Channel, Station, Surface};
use super::super::error::BliskError;
use super::super::frame::slices::Gap;
use super::super::options::{BliskOptions, EndWalls};
use super::flow::{Lines, MOST_STEEP, rising, steep_share};
use super::meridian::{Place, Tracer};
use geometry::frame::{Cylindrical, wrap_angle};

/// Points may lie so far off the surface that is measured beside them, as a share of the height.
const MOST_OFF: f64 = 0.05;
/// The tips are sought so far about the curve through points on them, as a share of the height.
const ABOUT_TIPS: f64 = 0.2;
/// Points on blades lie no further off them than this share of the pitch, or this (mm).
const OFF_BLADE: f64 = 0.02;
const OFF_BLADE_MM: f64 = 0.05;
/// A point on blades is named as off where the wheel is found without it, further off than this share of the pitch.
const OFF_BLADE_FOUND: f64 = 0.2;
/// A ray looks so many times as far as the passage is high beside it.
const REACH: f64 = 2.0;

impl Tracer<'_> {
    /// The lines across the passage that the points on hub and shroud give, or those that were found without them if
    /// they say the same; none where the passage is at most as steep as `slope`.
    ///
    /// # Errors
    /// [`BliskError::HandCurve`] where the points make no curve along the passage.
    pub(super) fn lines_by_hand(
        &self,
        start: Place,
        found: Option<Lines>,
        slope: f64,
    ) -> Result<Option<Lines>, BliskError> {
        let curves = self.by_hand.curves.clone();
        let at = DVec2::new(start.x, start.r);
        let wrong = |key| BliskError::HandCurve { key, x: at.x, r: at.y };
        let is_measured = self.options.end_walls == EndWalls::Measured;
        let pairs = match curves {
            [Some(hub), Some(shroud)] => {
                let found = found.filter(|_| is_measured).map(|found| turned_to(found, 0, &hub));
                if let Some(found) = found.filter(|found| are_ends(&self.by_hand.ends, found)) {
                    return Ok(Some(found));
                }
                let bounds = self.slices.bounds();
                let rim = bounds.min.abs().max(bounds.max.abs());
                let is_in_part = |line: &[DVec2; 2]| {
                    let middle = 0.5 * (line[0] + line[1]);
                    (bounds.min.x..=bounds.max.x).contains(&middle.x) && middle.y <= rim.y.max(rim.z)
                };
                pairs(&hub, &shroud).into_iter().filter(is_in_part).collect()
            }
            [None, None] => return Ok(found),
            [hub, shroud] => {
                let (end, given) = if let Some(hub) = hub { (0, hub) } else { (1, shroud.unwrap_or_default()) };
                if let Some(found) = found.filter(|_| is_measured) {
                    return Ok(Some(turned_to(found, end, &given)));
                }
                if steep_share(&given, slope) <= MOST_STEEP {
                    return Ok(None);
                }
                self.across(start, &given, end)
            }
        };
        if pairs.len() < 2 {
            return Err(wrong(if self.by_hand.ends[0].is_empty() { "shroud_points_mm" } else { "hub_points_mm" }));
        }
        let middle: Vec<DVec2> = pairs.iter().map(|[hub, shroud]| 0.5 * (*hub + *shroud)).collect();
        if steep_share(&middle, slope) <= MOST_STEEP {
            return Ok(None);
        }
        let height = pairs.iter().map(|[hub, shroud]| hub.distance(*shroud)).fold(f64::INFINITY, f64::min);
        let meets = |line: &&[DVec2; 2]| {
            let station = Station { along: 0.0, hub: line[0], shroud: line[1] };
            let gap = self.followed(&start.gap, at, station.place(0.5)).ok();
            let [from, toward] = self.start_of(&station, 0.5, Surface::Shroud);
            gap.and_then(|gap| self.met(gap.middle(), from, toward, 0.75 * station.height())).is_some()
        };
        let shrouded = 2 * pairs.iter().filter(meets).count() > pairs.len();
        Ok(Some(Lines::new(rising(pairs), (ABOUT_TIPS * height / 3.0, slope), shrouded)))
    }

    /// Lines square to a curve, the hub (`end` 0) or the shroud (1), to where the other end of the passage is met.
    fn across(&self, start: Place, given: &[DVec2], end: usize) -> Vec<[DVec2; 2]> {
        let at = DVec2::new(start.x, start.r);
        let (foot, off) = nearest(given, at);
        let first = (0..given.len()).min_by(|a, b| given[*a].distance(foot).total_cmp(&given[*b].distance(foot)));
        let first = first.unwrap_or(0);
        let mut half = off.max(1e-6);
        let mut lines: Vec<(usize, [DVec2; 2])> = Vec::new();
        for way in [1, -1] {
            let (mut gap, mut near, mut i) = (start.gap, at, first as isize);
            half = lines.first().map_or(half, |(_, [a, b])| 0.5 * a.distance(*b));
            while let Some(&from) = usize::try_from(i).ok().and_then(|i| given.get(i)) {
                let k = i as usize;
                let along = given[(k + 1).min(given.len() - 1)] - given[k.saturating_sub(1)];
                let across = along.perp().normalize_or(DVec2::Y);
                let up = across * across.dot(near - from).signum();
                let middle = from + half * up;
                let here = self.followed(&gap, near, middle);
                let other = match &here {
                    Ok(here) => self.other_end(here, middle, up, half, end),
                    // Beside the blades there are no tips, but walls go on.
                    Err(_) => self.wall_at(&gap, middle, up, half),
                };
                if let Some(other) = other {
                    (gap, near, half) = (here.unwrap_or(gap), middle, 0.5 * from.distance(other));
                    lines.push((k, if end == 0 { [from, other] } else { [other, from] }));
                }
                i += way;
            }
        }
        lines.sort_by_key(|(k, _)| *k);
        lines.dedup_by_key(|(k, _)| *k);
        lines.into_iter().map(|(_, line)| line).collect()
    }

    /// Where the passage ends from its `middle` along `up`: at a wall, or at the tips where no hub is sought.
    fn other_end(&self, gap: &Gap, middle: DVec2, up: DVec2, half: f64, end: usize) -> Option<DVec2> {
        let wall = self.wall_at(gap, middle, up, half);
        let tip = || {
            let (step, mut good, mut gap) = (0.05 * half, 0.0, *gap);
            while good < 2.0 * REACH * half {
                let next = middle + (good + step) * up;
                let Some(here) = self.bladed_gap(next.x, next.y, &gap) else { return Some(middle + good * up) };
                (good, gap) = (good + step, here);
            }
            None
        };
        if end == 0 { wall.or_else(tip) } else { wall }
    }

    /// Where a wall is met from the `middle` of a passage along `up`, in the middle of its gap.
    fn wall_at(&self, gap: &Gap, middle: DVec2, up: DVec2, half: f64) -> Option<DVec2> {
        self.met(gap.middle(), middle, up, REACH * 2.0 * half).map(|(distance, _)| middle + distance * up)
    }

    /// The passage that the wall of the first of the points on blades bounds, in the middle of all of them; none without
    /// points.
    ///
    /// # Errors
    /// [`BliskError::BladePoint`] where a point lies on no wall of a passage.
    pub(super) fn picked(&self) -> Result<Option<Place>, BliskError> {
        let mut first = None;
        for (i, point) in self.by_hand.blades.iter().enumerate() {
            let gaps = self.slices.gaps(point.x, point.r).into_iter().filter(|g| g.width() < 1.5 * self.pitch);
            let walls = gaps.flat_map(|gap| [(gap, gap.low), (gap, gap.high)]);
            let off = walls.map(|(gap, end)| (gap, wrap_angle(end.theta - point.theta).abs() * point.r));
            let nearest = off.min_by(|a, b| a.1.total_cmp(&b.1));
            let most = (OFF_BLADE * self.pitch * point.r).max(OFF_BLADE_MM);
            let Some((gap, _)) = nearest.filter(|(_, off)| *off <= most) else {
                let off_mm = nearest.map(|(_, off)| off);
                return Err(BliskError::BladePoint { number: i + 1, x: point.x, r: point.r, off_mm });
            };
            first = first.or(Some(Place { along: point.x, x: point.x, r: point.r, gap }));
        }
        let Some(first) = first else { return Ok(None) };
        let places = self.by_hand.places();
        let middle = places.iter().sum::<DVec2>() / places.len() as f64;
        let moved = self.followed(&first.gap, DVec2::new(first.x, first.r), middle);
        Ok(Some(moved.map_or(first, |gap| Place { along: middle.x, x: middle.x, r: middle.y, gap })))
    }

    /// Whether the hub or the shroud is the curve through the points that are given for it.
    pub(super) fn is_drawn(&self, surface: Surface) -> bool {
        let end = if surface == Surface::Hub { 0 } else { 1 };
        self.options.end_walls == EndWalls::Drawn && self.by_hand.curves[end].is_some()
    }

    /// Radii of hub and shroud at `x`, in a passage along the axis, where they are given or drawn.
    pub(super) fn given_radii(&self, x: f64) -> [Option<f64>; 2] {
        let [hub, shroud] = self.radii_by_hand(x);
        [
            self.options.hub_radius_mm.given().or(hub.filter(|_| self.is_drawn(Surface::Hub))),
            self.options.shroud_radius_mm.given().or(shroud.filter(|_| self.is_drawn(Surface::Shroud))),
        ]
    }

    /// Radii of hub and shroud at `x` after the curves through the points on them, in a passage along the axis.
    pub(super) fn radii_by_hand(&self, x: f64) -> [Option<f64>; 2] {
        self.by_hand.curves.each_ref().map(|curve| by_hand::radius_at(curve.as_ref()?, x))
    }
}

/// Refuses points that do not lie on the hub or the shroud that was measured beside them, of which there are none where
/// the passage is not `shrouded`, but tips.
///
/// # Errors
/// [`BliskError::PointOff`].
pub(super) fn check_points(by_hand: &ByHand, stations: &[Station], shrouded: bool) -> Result<(), BliskError> {
    let [hub, shroud] = [|s: &Station| s.hub, |s: &Station| s.shroud];
    let outer = if shrouded { "shroud" } else { "blade tips" };
    let ends = [("hub", "hub_points_mm", hub), (outer, "shroud_points_mm", shroud)];
    for ((surface, key, place), points) in ends.into_iter().zip(&by_hand.ends) {
        let beyond = stations.iter().map(Station::height).fold(0.0, f64::max);
        let polygon = extended(stations.iter().map(place).collect(), beyond);
        for (i, at) in points.iter().enumerate() {
            let (foot, off_mm) = nearest(&polygon, *at);
            let near = |s: &&Station| place(s).distance_squared(foot);
            let station = stations.iter().min_by(|a, b| near(a).total_cmp(&near(b)));
            let height = station.map_or(0.0, Station::height);
            if off_mm.is_nan() || off_mm > MOST_OFF * height {
                return Err(BliskError::PointOff { surface, key, number: i + 1, x: at.x, r: at.y, off_mm });
            }
        }
    }
    Ok(())
}

/// The refusal of the points of `options` where `channel` is found without them: of the first that lies off its hub or
/// its shroud, or of that on blades which is furthest off its walls; none where all lie on them.
pub(super) fn point_off(options: &BliskOptions, channel: &Channel) -> Option<BliskError> {
    let by_hand = ByHand::new(options, &channel.frame);
    if options.end_walls == EndWalls::Measured
        && let Err(off) = check_points(&by_hand, &channel.meridian, channel.shrouded)
    {
        return Some(off);
    }
    let pitch = TAU / channel.blades as f64;
    let walls = || channel.low.points.iter().chain(&channel.high.points).map(|p| Cylindrical::from_point(*p));
    let off = |point: &Cylindrical| {
        let around = |wall: Cylindrical| {
            let turns = (point.theta - wall.theta) / pitch;
            point.r * pitch * (turns - turns.round())
        };
        let all = walls().map(|wall| DVec3::new(wall.x - point.x, wall.r - point.r, around(wall)).length());
        all.fold(f64::INFINITY, f64::min)
    };
    let all = by_hand.blades.iter().enumerate().map(|(i, point)| (i + 1, point, off(point)));
    let (number, point, off_mm) = all.max_by(|a, b| a.2.total_cmp(&b.2))?;
    // To the distance of the points of the walls.
    let is_off = off_mm > OFF_BLADE_FOUND * pitch * point.r;
    is_off.then_some(BliskError::BladePoint { number, x: point.x, r: point.r, off_mm: Some(off_mm) })
}

/// Lines from places of the hub to the nearest ones of the shroud, as far as both reach.
fn pairs(hub: &[DVec2], shroud: &[DVec2]) -> Vec<[DVec2; 2]> {
    let ends = [shroud[0], shroud[shroud.len() - 1]];
    let is_end = |foot: DVec2| ends.iter().any(|end| end.distance(foot) < 1e-9);
    let line = |from: &DVec2| [*from, nearest(shroud, *from).0];
    let lines: Vec<[DVec2; 2]> = hub.iter().map(line).collect();
    let inner: Vec<[DVec2; 2]> = lines.iter().filter(|[_, foot]| !is_end(*foot)).copied().collect();
    if inner.len() >= 2 {
        return inner;
    }
    // They lie one behind the other: straight across from end to end.
    let same = hub[0].distance(ends[0]) + hub[hub.len() - 1].distance(ends[1]);
    let other = hub[0].distance(ends[1]) + hub[hub.len() - 1].distance(ends[0]);
    let mut shroud = shroud.to_vec();
    if other < same {
        shroud.reverse();
    }
    hub.iter().copied().zip(shroud).map(|(hub, shroud)| [hub, shroud]).collect()
}

/// Whether points on hub and shroud lie on the ends of lines that were found, as nearly as these are known.
fn are_ends(points: &[Vec<DVec2>; 2], found: &Lines) -> bool {
    let heights = found.lines.iter().map(|[hub, shroud]| hub.distance(*shroud));
    let (least, most) = heights.fold((f64::INFINITY, 0.0f64), |(l, m), height| (l.min(height), m.max(height)));
    let within = (MOST_OFF * least).max(found.step);
    points.iter().enumerate().all(|(end, points)| {
        let wall = extended(found.lines.iter().map(|line| line[end]).collect(), most);
        points.iter().all(|at| nearest(&wall, *at).1 <= within)
    })
}

/// A polygon that goes straight on by `length` at either end.
fn extended(mut polygon: Vec<DVec2>, length: f64) -> Vec<DVec2> {
    if let [first, second, ..] = polygon[..] {
        polygon.insert(0, first + length * (first - second).normalize_or_zero());
    }
    if let [.., before, last] = polygon[..] {
        polygon.push(last + length * (last - before).normalize_or_zero());
    }
    polygon
}

/// The lines that were found, with the wall that lies nearer to the given points as hub (`end` 0) or shroud (1).
fn turned_to(mut found: Lines, end: usize, given: &[DVec2]) -> Lines {
    let off = |k: usize| {
        let wall: Vec<DVec2> = found.lines.iter().map(|line| line[k]).collect();
        given.iter().map(|p| nearest(&wall, *p).1).sum::<f64>()
    };
    if found.shrouded && off(1 - end) < off(end) {
        found.lines.iter_mut().for_each(|line| line.swap(0, 1));
    }
    found
}
