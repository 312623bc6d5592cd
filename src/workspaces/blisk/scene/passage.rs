//! The passage of a channel as lines: hub and shroud curves, stations across it, and the two ends of its blades.

use glam::{DVec2, DVec3};

use crate::widgets::theme::{HUB, PASSAGE, SHROUD};
use geometry::frame::{Cylindrical, angle_near};
use render::colour::Colour;
use render::scene::LineSet;
use wheel::channel::{Channel, ChannelWall, Station};

/// Stations that are drawn between the edges of the blades.
const STATIONS: usize = 15;
/// Rows of a wall that the middle of the passage is taken from.
const ROWS: usize = 5;
/// Steps of an arc about the axis.
const ARC: usize = 8;

/// Lines of a passage, in W.
#[derive(Debug, Clone, Default)]
pub struct PassageLines {
    /// The hub half way between the walls, along the whole passage.
    pub hub: Vec<DVec3>,
    /// The shroud or the blade tips half way between the walls.
    pub shroud: Vec<DVec3>,
    /// Lines from hub to shroud half way between the walls, from edge to edge.
    pub stations: Vec<Vec<DVec3>>,
    /// Closed outlines of inlet and outlet, along the edges of the two blades.
    pub ends: [Vec<DVec3>; 2],
}

impl PassageLines {
    /// The lines of `channel`.
    pub fn new(channel: &Channel) -> Self {
        let middle = Middle::new(channel);
        let hub = channel.meridian.iter().map(|station| middle.point(station, 0.0)).collect();
        let shroud = channel.meridian.iter().map(|station| middle.point(station, 1.0)).collect();
        let line = |station: Station| {
            (0..ROWS).map(|row| middle.point(&station, row as f64 / (ROWS - 1) as f64)).collect::<Vec<_>>()
        };
        let stations = between_edges(channel).map(line).collect();
        let ends = [0, channel.low.nu - 1].map(|u| outline(channel, u));
        Self { hub, shroud, stations, ends }
    }

    /// The middle of the passage's first or last end, in W.
    pub fn mouth(&self, is_last: bool) -> Option<DVec3> {
        let station = if is_last { self.stations.last() } else { self.stations.first() };
        station.and_then(|line| line.get(line.len() / 2)).copied()
    }

    /// The lines as parts of a scene, placed by `place`.
    pub fn drawn(&self, place: impl Fn(DVec3) -> DVec3 + Copy) -> [LineSet; 4] {
        let set = |lines: &[Vec<DVec3>], colour: Colour, width_px| {
            let lines = lines.iter().filter(|line| line.len() > 1);
            let lines = lines.map(|line| line.iter().copied().map(place).collect()).collect();
            LineSet { on_top: true, width_px, ..LineSet::new(lines, colour) }
        };
        [
            set(&self.stations, PASSAGE, 1.0),
            set(&self.ends, PASSAGE, 2.0),
            set(std::slice::from_ref(&self.hub), HUB, 2.5),
            set(std::slice::from_ref(&self.shroud), SHROUD, 2.5),
        ]
    }
}

/// Stations evenly from the first edge of the blades to the last one.
pub fn between_edges(channel: &Channel) -> impl Iterator<Item = Station> {
    let [from, to] = channel.span_along();
    (0..STATIONS).map(move |i| channel.station_at(from + (to - from) * i as f64 / (STATIONS - 1) as f64))
}

/// The angle half way between the walls of a channel, by position along the passage and share of its height.
pub struct Middle {
    /// Of some rows of the walls from hub to shroud: position along the passage (mm) and angle (rad) at every point.
    rows: Vec<Vec<[f64; 2]>>,
}

impl Middle {
    /// The middle of `channel`.
    pub fn new(channel: &Channel) -> Self {
        let (low, high) = (&channel.low, &channel.high);
        let row = |row: usize| {
            let v = row * (low.nv - 1) / (ROWS - 1);
            let mut near = 0.0;
            let mut points: Vec<[f64; 2]> = Vec::with_capacity(low.nu);
            for u in 0..low.nu {
                let [a, b] = [low, high].map(|wall| wall.cylindrical(u, v));
                let theta = angle_near(0.5 * (a.theta + angle_near(b.theta, a.theta)), near);
                let place = 0.5 * (DVec2::new(a.x, a.r) + DVec2::new(b.x, b.r));
                near = theta;
                points.push([channel.along_and_height(place)[0], theta]);
            }
            points
        };
        Self { rows: (0..ROWS).map(row).collect() }
    }

    /// The point in W at `share` of the way from hub to shroud on a station.
    pub fn point(&self, station: &Station, share: f64) -> DVec3 {
        let row = share.clamp(0.0, 1.0) * (ROWS - 1) as f64;
        let below = (row as usize).min(ROWS - 2);
        let [a, b] = [below, below + 1].map(|row| angle_at(&self.rows[row], station.along));
        let DVec2 { x, y: r } = station.place(share);
        Cylindrical { x, r, theta: a + (row - below as f64) * (b - a) }.point()
    }
}

/// The angle of a row at a position along the passage, beyond its ends that at the end.
fn angle_at(row: &[[f64; 2]], along: f64) -> f64 {
    let i = row.partition_point(|point| point[0] < along);
    let Some(b) = row.get(i).or(row.last()) else { return 0.0 };
    let a = row.get(i.wrapping_sub(1)).unwrap_or(b);
    let t = if b[0] > a[0] { ((along - a[0]) / (b[0] - a[0])).clamp(0.0, 1.0) } else { 0.0 };
    a[1] + t * (b[1] - a[1])
}

/// The closed line along both walls at `u` of their grids, and across at hub and shroud.
fn outline(channel: &Channel, u: usize) -> Vec<DVec3> {
    let (low, high) = (&channel.low, &channel.high);
    let up = |wall: &ChannelWall| (0..wall.nv).map(|v| wall.point(u, v)).collect::<Vec<_>>();
    let across = |v: usize| {
        let [a, b] = [low, high].map(|wall| wall.cylindrical(u, v));
        let turn = angle_near(b.theta, a.theta) - a.theta;
        (0..=ARC).map(move |i| {
            let t = i as f64 / ARC as f64;
            Cylindrical { x: a.x + t * (b.x - a.x), r: a.r + t * (b.r - a.r), theta: a.theta + t * turn }.point()
        })
    };
    let mut line = up(low);
    line.extend(across(low.nv - 1));
    line.extend(up(high).into_iter().rev());
    line.extend(across(0).collect::<Vec<_>>().into_iter().rev());
    line
}

#[cfg(test)]
mod tests {
    use super::*;
    use wheel::fixtures::exact_channel;
    use wheel::parametric::ParametricBlisk;

    #[test]
    fn hub_shroud_and_stations_lie_between_the_walls_at_the_heights_of_the_passage() {
        let blisk = ParametricBlisk::turbine();
        let channel = exact_channel(&blisk);
        let lines = PassageLines::new(&channel);
        for (line, share) in [(&lines.hub, 0.0), (&lines.shroud, 1.0)] {
            assert_eq!(line.len(), channel.meridian.len());
            for (p, station) in line.iter().zip(&channel.meridian) {
                let place = station.place(share);
                assert!((p.x - place.x).abs() < 1e-9 && (p.y.hypot(p.z) - place.y).abs() < 1e-9, "{p}");
            }
        }
        // The nearest points of either wall on the same circle lie to either side of each station's middle.
        let middle = &lines.stations[STATIONS / 2][ROWS / 2];
        let theta = |wall: &ChannelWall| {
            let near = |p: &&DVec3| (p.x - middle.x).abs() + (p.y.hypot(p.z) - middle.y.hypot(middle.z)).abs();
            let p = wall.points.iter().min_by(|a, b| near(a).total_cmp(&near(b))).unwrap();
            Cylindrical::from_point(*p).theta
        };
        let (low, high) = (theta(&channel.low), theta(&channel.high));
        let at = Cylindrical::from_point(*middle).theta;
        assert!(((at - low) - (high - at)).abs() < 0.05 * (high - low), "{low} {at} {high}");
        assert_eq!(lines.stations.len(), STATIONS);
    }

    #[test]
    fn the_ends_are_closed_lines_along_the_edges() {
        let channel = exact_channel(&ParametricBlisk::turbine());
        for (end, u) in PassageLines::new(&channel).ends.iter().zip([0, channel.low.nu - 1]) {
            assert!(end.first().unwrap().distance(*end.last().unwrap()) < 1e-9);
            for wall in [&channel.low, &channel.high] {
                assert!((0..wall.nv).all(|v| end.contains(&wall.point(u, v))));
            }
        }
    }
}
