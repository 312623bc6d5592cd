//! Hub and shroud along the axis, met by rays along the radius through the channel's middle.

use glam::DVec2;

use super::super::by_hand::ByHand;
use super::super::channel::{Flow, Station, Surface};
use super::super::error::BliskError;
use super::super::frame::MOST_KINDS;
use super::super::frame::slices::{Gap, RadialCrossing, Slices};
use super::super::options::BliskOptions;
use task::Cancel;

/// Samples over the whole length of the part. No round number: on parts with round figures a sample would fall
/// on the very edge of the blades, where rounding decides whether they are met.
const STATIONS: f64 = 197.3;
/// Rays across the channel, and the middle share of its width that they stay in, clear of root fillets.
pub(super) const RAYS: usize = 13;
pub(super) const MIDDLE_SHARE: f64 = 0.6;
/// A wall whose points are given lies so near to the curve through them, as a share of the distance to the passage's
/// middle.
const ABOUT_POINTS: f64 = 0.4;
/// Share of the height away from an end wall where the channel's middle beside it is looked for.
const BESIDE: f64 = 0.1;
/// Most times that an end wall whose rays are not of one wall is measured again, from nearer to it; twice as many where a
/// blade is met.
const MOST_NEARER: i32 = 3;
/// A facet whose normal lies less than this in the half plane through the axis (cosine) is a blade's, not an end wall's.
const OF_END_WALL: f64 = 0.9;
/// Rays that differ from the middle one of them by more than this share of the height met something else.
const SAME_WALL: f64 = 0.03;
/// Share of the part's size by which the vertices of a plane face may lie off it.
pub(super) const FACE_ROUNDING: f64 = 1e-6;
/// Greatest share of the height by which an end wall lies off its straight continuation just before its ring ends.
const ALONG_WALL: f64 = 5e-4;
/// Share of the distance of two stations within which a step of an end wall between them is found.
const STEP_WIDTH: f64 = 1e-6;
/// Share of the height by which blade tips may lie off a straight line between two stations, and how often these are
/// halved until they do.
const BEND: f64 = 0.005;
const BEND_HALVINGS: usize = 6;
/// Blade tips that fall steeper than 45 degrees to less than this share of the height are a swept edge; what falls less is a
/// step of the tips.
const EDGE_FALL: f64 = 0.5;
/// Share of the height, beside the dip of facets, up to which rays meet an even wall.
pub(super) const DIP: f64 = 0.0001;

/// A place in a channel: a circle and its gap.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    /// Position along the passage (mm).
    pub along: f64,
    pub x: f64,
    pub r: f64,
    pub gap: Gap,
}

/// The channel's bounds in the meridional plane.
pub(super) struct Meridian {
    /// In order of rising `along`.
    pub stations: Vec<Station>,
    /// Direction of the passage.
    pub flow: Flow,
    /// Whether a shroud was met.
    pub shrouded: bool,
}

/// An end wall at one place.
#[derive(Clone, Copy)]
struct EndWall {
    /// Radius (mm).
    radius: f64,
    /// Whether most rays are of this wall, and differ by no more than its facets dip.
    is_even: bool,
    /// Whether the middle one of the rays met a blade.
    is_blade: bool,
}

/// A station and the channel's gaps there, or at the nearest x where the blades bound them.
#[derive(Clone, Copy)]
struct Traced {
    station: Station,
    /// The gap at the middle radius.
    gap: Gap,
    /// The gaps beside hub and shroud, which lie elsewhere about the axis where blades lean.
    beside: [Gap; 2],
}

/// The middle between two positions (mm), while they are further apart than a billionth of a step and than rounding.
pub(super) fn middle_between(a: f64, b: f64, step: f64) -> Option<f64> {
    let middle = 0.5 * (a + b);
    ((b - a).abs() > 1e-9 * step.abs() && middle != a && middle != b).then_some(middle)
}

/// Follows one channel.
pub(super) struct Tracer<'a> {
    pub slices: &'a Slices,
    /// Angle from blade to blade (rad).
    pub pitch: f64,
    pub options: &'a BliskOptions,
    pub by_hand: &'a ByHand,
    pub cancel: &'a Cancel,
}

impl Tracer<'_> {
    /// The gap at (`x`, `r`) that continues `near`, if blades bound it on both sides.
    pub fn bladed_gap(&self, x: f64, r: f64, near: &Gap) -> Option<Gap> {
        self.continued(x, r, near).filter(|gap| gap.width() < 1.5 * self.pitch)
    }

    /// The gap at (`x`, `r`) between the blades that bound `near`.
    fn continued(&self, x: f64, r: f64, near: &Gap) -> Option<Gap> {
        // Where one of the two blades is missing or ends, as a splitter does, the gap reaches to the next one. Between
        // thick blades that may be less than a pitch and a half away.
        let reaches_on = |gap: &Gap| gap.width() - near.width() > 0.5 * self.pitch;
        self.slices.gap_near(x, r, near).filter(|gap| !reaches_on(gap))
    }

    /// The gap at (`x`, `r`) that continues `near`: between the same blades, or between others where a splitter has ended.
    pub(super) fn gap_between_any(&self, x: f64, r: f64, near: &Gap) -> Option<Gap> {
        let most = (MOST_KINDS as f64 + 0.5) * self.pitch;
        self.slices.gap_near(x, r, near).filter(|gap| gap.width() < most)
    }

    /// Hub and shroud along the whole ring of an axial channel, starting from a place between the blades.
    pub fn meridian(&self, start: Place) -> Result<Meridian, BliskError> {
        let missing = |wall, key| BliskError::NoEndWall { wall, key, x: start.x, r: start.r };
        let (hub, shroud) = self.end_walls(&start, &[start.gap; 2]);
        let shrouded = shroud.is_some();
        let given = self.given_radii(start.x);
        let hub = given[0].or(hub).ok_or(missing("hub", "hub_radius_mm"))?;
        let tip = || self.tip_radius(&start, start.r);
        let shroud = given[1].or(shroud).unwrap_or_else(tip);
        if hub >= shroud {
            return Err(BliskError::NoHeight { hub, shroud });
        }
        let first = self.traced(&start, hub, shroud, &[start.gap; 2]);
        let bounds = self.slices.bounds();
        let step = bounds.size().x / STATIONS;
        let mut stations = self.march(first, -step, bounds.min.x, shrouded)?;
        let mut after = self.march(first, step, bounds.max.x, shrouded)?;
        if !shrouded && given[1].is_none() {
            keep_tips(first.station, &mut stations);
            keep_tips(first.station, &mut after);
        }
        stations.reverse();
        stations.push(first.station);
        stations.extend(after);
        Ok(Meridian { stations, flow: Flow::Axial, shrouded })
    }

    /// Stations beyond `from` in steps of `step` up to where an end wall ends, which is found exactly. Where an end wall
    /// steps away from the passage, as at a face of the ring, the passage keeps its height.
    fn march(&self, mut from: Traced, step: f64, end: f64, shrouded: bool) -> Result<Vec<Station>, BliskError> {
        let mut stations = Vec::new();
        let mut most = [f64::NEG_INFINITY, f64::INFINITY];
        let within =
            |s: Station, most: [f64; 2]| Station::across_axis(s.along, s.hub.y.max(most[0]), s.shroud.y.min(most[1]));
        loop {
            self.cancel.check()?;
            let x =
                if step > 0.0 { (from.station.along + step).min(end) } else { (from.station.along + step).max(end) };
            if x != end
                && let Some(next) = self.station(x, &from, shrouded)
            {
                if let Some([before, after]) = self.step_between(&from, &next, shrouded) {
                    stations.push(within(before, most));
                    let [hub, shroud] = steps_away(&before, &after);
                    if hub {
                        most[0] = most[0].max(before.hub.y);
                    }
                    if shroud {
                        most[1] = most[1].min(before.shroud.y);
                    }
                    stations.push(within(after, most));
                } else if !shrouded {
                    let mut bends = Vec::new();
                    self.add_bends(&from, &next, BEND_HALVINGS, &mut bends);
                    stations.extend(bends.into_iter().map(|bend| within(bend, most)));
                }
                stations.push(within(next.station, most));
                from = next;
                continue;
            }
            let last_where = |is_on: &dyn Fn(&Station) -> bool| {
                let (mut good, mut bad) = (from, x);
                while let Some(middle) = middle_between(good.station.along, bad, step) {
                    match self.station(middle, &good, shrouded).filter(|next| is_on(&next.station)) {
                        Some(next) => good = next,
                        None => bad = middle,
                    }
                }
                good.station
            };
            let mut ring_end = last_where(&|_| true);
            // Where the face stands aslant by little, or lies off its plane by rounding, rays meet what is beyond it.
            if steps_away(&from.station, &ring_end).contains(&true) {
                let on_wall = ALONG_WALL * from.station.height();
                let straight = |along: f64| match stations[..] {
                    [.., a, b] => {
                        let t = (along - a.along) / (b.along - a.along);
                        let at = |a: DVec2, b: DVec2| a.lerp(b, t).y;
                        Station::across_axis(along, at(a.hub, b.hub), at(a.shroud, b.shroud))
                    }
                    _ => from.station,
                };
                ring_end = last_where(&|next| jump(&straight(next.along), next) < on_wall);
            }
            if ring_end.along != from.station.along {
                stations.push(within(ring_end, most));
            }
            return Ok(stations);
        }
    }

    /// The stations just before and just after a step of an end wall between two known ones, if there is one.
    fn step_between(&self, from: &Traced, to: &Traced, shrouded: bool) -> Option<[Station; 2]> {
        let is_step = |a: &Traced, b: &Traced| jump(&a.station, &b.station) > SAME_WALL * a.station.height();
        let step = (to.station.along - from.station.along).abs();
        let (mut before, mut after) = (*from, *to);
        while is_step(&before, &after) {
            if (after.station.along - before.station.along).abs() < STEP_WIDTH * step {
                return Some([before.station, after.station]);
            }
            let middle = self.station(0.5 * (before.station.along + after.station.along), &before, shrouded)?;
            let is_before = jump(&middle.station, &before.station) <= jump(&middle.station, &after.station);
            *(if is_before { &mut before } else { &mut after }) = middle;
        }
        None
    }

    /// Adds the stations between two known ones of blade tips, in their order, at which these are bent: beside a swept edge
    /// they run along the edge, and ahead of it along a fillet.
    fn add_bends(&self, from: &Traced, to: &Traced, halvings: usize, stations: &mut Vec<Station>) {
        let along = 0.5 * (from.station.along + to.station.along);
        let Some(middle) = self.station(along, from, false).filter(|_| halvings > 0) else { return };
        let straight = 0.5 * (from.station.shroud.y + to.station.shroud.y);
        if (middle.station.shroud.y - straight).abs() <= BEND * middle.station.height() {
            return;
        }
        self.add_bends(from, &middle, halvings - 1, stations);
        stations.push(middle.station);
        self.add_bends(&middle, to, halvings - 1, stations);
    }

    /// The end walls at `x`, beside a known station; none where one of them has ended.
    fn station(&self, x: f64, near: &Traced, shrouded: bool) -> Option<Traced> {
        let r = 0.5 * (near.station.hub.y + near.station.shroud.y);
        let bladed = self.gap_between_any(x, r, &near.gap);
        let place = Place { along: x, x, r, gap: bladed.unwrap_or(near.gap) };
        let (hub, shroud) = self.end_walls(&place, &near.beside);
        let tip = || bladed.map_or(near.station.shroud.y, |_| self.tip_radius(&place, near.station.shroud.y));
        let given = self.given_radii(x);
        // A drawn curve bounds the passage with a shroud behind it or without.
        let shroud = match given[1] {
            Some(drawn) if self.is_drawn(Surface::Shroud) => drawn,
            given => {
                let met = if shrouded { shroud? } else { tip() };
                given.unwrap_or(met)
            }
        };
        let hub = given[0].or(hub)?;
        (hub < shroud).then(|| self.traced(&place, hub, shroud, &near.beside))
    }

    /// The station at a place with these radii of hub and shroud. The gaps beside them continue `near`.
    fn traced(&self, place: &Place, hub: f64, shroud: f64, near: &[Gap; 2]) -> Traced {
        let beside = [(hub, &near[0]), (shroud, &near[1])].map(|(wall, near)| {
            let r = wall + 2.0 * BESIDE * (place.r - wall);
            self.gap_between_any(place.x, r, near).unwrap_or(*near)
        });
        Traced { station: Station::across_axis(place.x, hub, shroud), gap: place.gap, beside }
    }

    /// Radii of the hub and of the shroud at a place. Where the rays over the middle of the channel differ by more than
    /// facets do, they are measured beside that end wall: leaned blades pass it elsewhere than at the middle of the
    /// height, and fillets lie beside them. Where no blades bound the place, as ahead of them, their gaps beside the end
    /// walls continue `near`.
    fn end_walls(&self, place: &Place, near: &[Gap; 2]) -> (Option<f64>, Option<f64>) {
        let [hub, shroud] = self.end_walls_along(place);
        let given = self.radii_by_hand(place.x);
        let [hub, shroud] =
            [(0, hub), (1, shroud)].map(|(end, met)| met.or_else(|| self.met_beside(place, end, given[end]?)));
        let beside = |i: usize, mut wall: EndWall| {
            let mut gap = place.gap;
            let inwards = 2.0 * BESIDE * (place.r - wall.radius);
            // What is met first may be a blade that leans over the wall.
            for round in 0..2 * MOST_NEARER {
                if !wall.is_blade && (wall.is_even || round >= MOST_NEARER) {
                    break;
                }
                let r = wall.radius + inwards * 0.5f64.powi(round);
                let next = self.gap_between_any(place.x, r, &gap).unwrap_or(near[i]);
                let Some(nearer) = self.end_walls_along(&Place { r, gap: next, ..*place })[i] else { break };
                (wall, gap) = (nearer, next);
            }
            wall
        };
        let (hub, shroud) = (hub.map(|hub| beside(0, hub)), shroud.map(|shroud| beside(1, shroud)));
        // Where nothing but a blade that leans is met, and no points tell of one, there is no shroud.
        let shroud = shroud.filter(|shroud| !shroud.is_blade || given[1].is_some());
        (hub.map(|hub| hub.radius), shroud.map(|shroud| shroud.radius))
    }

    /// The hub (`end` 0) or the shroud (1) beside the radius `given` of points on it, where a blade that leans covers it
    /// from the middle of the passage.
    fn met_beside(&self, place: &Place, end: usize, given: f64) -> Option<EndWall> {
        let mut gap = place.gap;
        (0..MOST_NEARER).find_map(|round| {
            let r = given + 2.0 * BESIDE * 0.5f64.powi(round) * (place.r - given);
            gap = self.bladed_gap(place.x, r, &gap)?;
            self.end_walls_along(&Place { r, gap, ..*place })[end]
        })
    }

    /// Whether a facet that is met in the half plane at `theta` is a blade's rather than an end wall's.
    pub(super) fn is_of_blade(&self, facet: u32, theta: f64) -> bool {
        self.slices.meridional_normal(facet, theta).length() < OF_END_WALL
    }

    /// The hub and the shroud along the radius through a place: the greatest and the least radius that its rays meet.
    fn end_walls_along(&self, place: &Place) -> [Option<EndWall>; 2] {
        let middle = place.gap.middle();
        let half = 0.5 * MIDDLE_SHARE * place.gap.width();
        let theta = |i: usize| middle + half * (2.0 * i as f64 / (RAYS - 1) as f64 - 1.0);
        let rays: Vec<Vec<RadialCrossing>> = (0..RAYS).map(|i| self.slices.ray(place.x, theta(i))).collect();
        let [hub, shroud] = self.radii_by_hand(place.x);
        let near = |ray: &[RadialCrossing], given: f64, enters: bool| {
            let most = ABOUT_POINTS * (place.r - given).abs();
            let walls = ray.iter().filter(|c| c.enters == enters && (c.r - given).abs() < most).copied();
            walls.min_by(|a, b| (a.r - given).abs().total_cmp(&(b.r - given).abs()))
        };
        // A ray that starts within the solid meets the wall from behind.
        let inner = rays.iter().filter_map(|ray| match hub {
            Some(given) => near(ray, given, false),
            None => ray.iter().rfind(|c| c.r < place.r).filter(|c| !c.enters).copied(),
        });
        let outer = rays.iter().filter_map(|ray| match shroud {
            Some(given) => near(ray, given, true),
            None => ray.iter().find(|c| c.r > place.r).filter(|c| c.enters).copied(),
        });
        let (inner, outer) = (sorted(inner), sorted(outer));
        let most = |v: &[RadialCrossing]| (2 * v.len() > RAYS).then(|| v[v.len() / 2]);
        let (hub, shroud) = (most(&inner), most(&outer));
        let height = shroud.map_or(place.r, |c| c.r) - hub.map_or(place.r, |c| c.r);
        // The same wall is met as far off as its facets dip; what differs more is a fillet or a blade.
        let dip = |c: &RadialCrossing| DIP * height + self.slices.sag(c.triangle, c.r);
        // Between its facets a hub stands out at corners, which rays miss.
        let corners = self.slices.corner_radii(place.x, middle, half);
        let greatest = |c: &RadialCrossing, same: f64| {
            let met = inner.iter().map(|c| c.r).chain(corners.iter().copied());
            met.filter(|r| *r <= c.r + same).fold(c.r, f64::max)
        };
        let least = |c: &RadialCrossing, same: f64| outer.iter().map(|c| c.r).find(|r| *r >= c.r - same).unwrap_or(c.r);
        let wall = |c: RadialCrossing, rays: &[RadialCrossing], of: &dyn Fn(&RadialCrossing, f64) -> f64| {
            let (radius, same) = (of(&c, dip(&c)), SAME_WALL * height);
            let of_wall = rays.iter().filter(|ray| (ray.r - c.r).abs() <= same).count();
            // A staggered blade faces along the axis, and an end wall that does so is met by no ray along the radius.
            let normal = self.slices.meridional_normal(c.triangle, middle);
            let is_blade = self.is_of_blade(c.triangle, middle) || normal.x.abs() > normal.y.abs();
            EndWall { radius, is_even: radius == of(&c, same) && 3 * of_wall >= 2 * RAYS, is_blade }
        };
        [hub.map(|c| wall(c, &inner, &greatest)), shroud.map(|c| wall(c, &outer, &least))]
    }

    /// The greatest radius at which blades still bound the channel at a place; it is sought around `guess`.
    fn tip_radius(&self, place: &Place, guess: f64) -> f64 {
        let step = self.slices.cell_size().y;
        let (mut good, mut gap) = (place.r, place.gap);
        let below = guess - step;
        if below > good
            && let Some(next) = self.continued(place.x, below, &gap)
        {
            (good, gap) = (below, next);
        }
        let mut bad = loop {
            match self.continued(place.x, good + step, &gap) {
                Some(next) => (good, gap) = (good + step, next),
                None => break good + step,
            }
        };
        while bad - good > 1e-6 * step {
            let r = 0.5 * (good + bad);
            match self.continued(place.x, r, &gap) {
                Some(next) => (good, gap) = (r, next),
                None => bad = r,
            }
        }
        good
    }
}

/// Keeps the passage as high as the tips of its blades beyond the corner where these end: there the greatest radius that
/// blades bound falls along a swept edge to the hub. `stations` lie in order away from `first`, between the blades.
fn keep_tips(first: Station, stations: &mut [Station]) {
    let at = |i: usize| if i == 0 { first } else { stations[i - 1] };
    let falls = |i: usize| at(i).shroud.y - at(i + 1).shroud.y > (at(i + 1).along - at(i).along).abs();
    let is_low = |s: &Station, from: &Station| s.shroud.y - from.hub.y < EDGE_FALL * from.height();
    let ends_low = |i: usize| stations[i..].iter().any(|s| is_low(s, &at(i)));
    let Some(corner) = (0..stations.len()).find(|&i| falls(i) && ends_low(i)) else { return };
    let tips = at(corner).shroud.y;
    stations[corner..].iter_mut().for_each(|station| station.shroud.y = tips);
}

/// Whether the hub and whether the shroud step away from the passage from one station to the next.
fn steps_away(before: &Station, after: &Station) -> [bool; 2] {
    let same = SAME_WALL * before.height();
    [after.hub.y < before.hub.y - same, after.shroud.y > before.shroud.y + same]
}

/// Greatest difference of the radii of two stations (mm).
fn jump(one: &Station, other: &Station) -> f64 {
    (one.hub.y - other.hub.y).abs().max((one.shroud.y - other.shroud.y).abs())
}

fn sorted(values: impl Iterator<Item = RadialCrossing>) -> Vec<RadialCrossing> {
    let mut values: Vec<RadialCrossing> = values.collect();
    values.sort_by(|a, b| a.r.total_cmp(&b.r));
    values
}
