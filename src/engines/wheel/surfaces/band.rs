//! Places of a wheel's surface against the hub, the shroud and the walls of a channel.

use glam::{DVec2, DVec3};

use super::super::channel::{Channel, Flow, Station};
use super::super::frame::slices::cylindrical_components;

/// Cells along x and along r that the stations are looked up in.
const CELLS: usize = 128;
/// Stations are looked up so far beyond hub and shroud, as a share of the height.
const BEYOND: f64 = 0.4;
/// Share of the height beside hub and shroud where fillets may be in the walls' grid.
const CLEAR: f64 = 0.3;
/// Points of the walls' grid at either edge that lie on its rounding.
const EDGE: usize = 3;

/// A place (x, r) against hub and shroud.
#[derive(Debug, Clone, Copy)]
pub(super) struct Foot {
    /// Position along the passage (mm).
    pub along: f64,
    /// Share of the height, 0 at the hub and 1 at the shroud.
    pub share: f64,
    /// Distances above the hub and below the shroud (mm).
    pub off: [f64; 2],
    /// Unit normals of hub and shroud into the passage (x, r).
    pub normals: [DVec2; 2],
    /// How far hub and shroud bend off their chords between stations there (mm).
    pub sag: [f64; 2],
    /// Height of the passage (mm).
    pub height: f64,
}

/// The flow path between hub and shroud.
pub(super) struct Band {
    stations: Vec<Station>,
    /// Unit directions along the passage, across each station (x, r).
    ways: Vec<DVec2>,
    least: DVec2,
    cell: DVec2,
    /// The station nearest to each cell.
    nearest: Vec<u32>,
}

impl Band {
    /// The flow path of `channel`; none without at least two stations.
    pub fn new(channel: &Channel) -> Option<Self> {
        let mut stations = channel.meridian.clone();
        stations.dedup_by(|b, a| b.hub.distance(a.hub) < 1e-9 || b.shroud.distance(a.shroud) < 1e-9);
        if stations.len() < 2 {
            return None;
        }
        let n = stations.len();
        let way = |i: usize| {
            let across = (stations[i].shroud - stations[i].hub).perp();
            let ahead = stations[(i + 1).min(n - 1)].place(0.5) - stations[i.saturating_sub(1)].place(0.5);
            across.normalize_or(DVec2::X) * across.dot(ahead).signum()
        };
        let ways = (0..n).map(way).collect();
        let ends = || stations.iter().flat_map(|s| [s.hub, s.shroud]);
        let (least, most) = ends().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, m), p| (l.min(p), m.max(p)));
        let highest = stations.iter().map(Station::height).fold(0.0, f64::max);
        let margin = (0.05 * (most - least).length()).max(BEYOND * highest);
        let (least, most) = (least - margin, most + margin);
        let cell = (most - least) / CELLS as f64;
        let nearest = (0..CELLS * CELLS).map(|i| {
            let at = least + cell * (DVec2::new((i / CELLS) as f64, (i % CELLS) as f64) + 0.5);
            let far = |s: &Station| {
                let up = s.shroud - s.hub;
                let share = ((at - s.hub).dot(up) / up.length_squared()).clamp(0.0, 1.0);
                s.place(share).distance_squared(at)
            };
            let all = stations.iter().map(far).zip(0u32..);
            all.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0, |(_, i)| i)
        });
        let nearest = nearest.collect();
        Some(Self { stations, ways, least, cell, nearest })
    }

    /// How far the place lies beyond station `i` along the passage (mm).
    fn beyond(&self, i: usize, place: DVec2) -> f64 {
        (place - self.stations[i].hub).dot(self.ways[i])
    }

    /// The place (x, r) against hub and shroud; none well outside the flow path.
    pub fn foot(&self, place: DVec2) -> Option<Foot> {
        let at = (place - self.least) / self.cell;
        let inside = at.min_element() >= 0.0 && at.max_element() < CELLS as f64;
        let index = inside.then(|| at.x as usize * CELLS + at.y as usize)?;
        let last = self.stations.len() - 2;
        let mut i = (self.nearest[index] as usize).min(last);
        // From the nearest station the place lies a few stations on at most.
        for _ in 0..self.stations.len() {
            if i > 0 && self.beyond(i, place) < 0.0 {
                i -= 1;
            } else if i < last && self.beyond(i + 1, place) > 0.0 {
                i += 1;
            } else {
                break;
            }
        }
        let (behind, ahead) = (self.beyond(i, place), -self.beyond(i + 1, place));
        let t = if behind + ahead > 0.0 { behind / (behind + ahead) } else { 0.5 };
        let (a, b) = (self.stations[i], self.stations[i + 1]);
        let (hub, shroud) = (a.hub.lerp(b.hub, t), a.shroud.lerp(b.shroud, t));
        let up = shroud - hub;
        let normal = |from: DVec2, to: DVec2, inward: DVec2| {
            let across = (to - from).perp().normalize_or(inward.normalize_or(DVec2::Y));
            across * across.dot(inward).signum()
        };
        let normals = [normal(a.hub, b.hub, up), normal(a.shroud, b.shroud, -up)];
        let bend = |place: fn(&Station) -> DVec2| {
            let (j, k) = (i.saturating_sub(1), (i + 2).min(last + 1));
            (place(&self.stations[j]) + place(&self.stations[k]) - place(&a) - place(&b)).length() / 8.0
        };
        Some(Foot {
            along: a.along + t * (b.along - a.along),
            share: (place - hub).dot(up) / up.length_squared().max(f64::MIN_POSITIVE),
            off: [(place - a.hub).dot(normals[0]), (place - a.shroud).dot(normals[1])],
            normals,
            sag: [bend(|s| s.hub), bend(|s| s.shroud)],
            height: up.length(),
        })
    }

    /// Positions of the first and the last station along the passage (mm).
    pub fn ends(&self) -> [f64; 2] {
        [self.stations[0].along, self.stations[self.stations.len() - 1].along]
    }
}

/// The camber surface between the two blades of a channel.
pub(super) struct Blades {
    rows: Vec<Row>,
}

/// A row of the walls' grids.
struct Row {
    alongs: Vec<f64>,
    /// Unit normals of the camber surface towards greater theta: along x, along r and about the axis.
    cambers: Vec<DVec3>,
}

impl Blades {
    /// The blades of `channel`; none where the places of its walls along the passage are not known.
    pub fn new(channel: &Channel, band: &Band) -> Option<Self> {
        let (low, high) = (&channel.low, &channel.high);
        let row = |v: usize| {
            let mut row = Row { alongs: Vec::new(), cambers: Vec::new() };
            for u in 0..low.nu {
                let (a, b) = (low.cylindrical(u, v), high.cylindrical(u, v));
                let foot = band.foot(DVec2::new(a.x, a.r));
                let along = if channel.flow == Flow::Axial { a.x } else { foot.map_or(f64::NAN, |f| f.along) };
                row.alongs.push(along);
                let sides = [(low.normal(u, v), a.theta), (high.normal(u, v), b.theta)];
                let [n, m] = sides.map(|(n, theta)| cylindrical_components(n, theta));
                row.cambers.push((n - m).normalize_or(DVec3::Z));
            }
            row
        };
        let rows: Vec<Row> = (0..low.nv).map(row).collect();
        let is_known = low.nu >= 2 * EDGE + 2 && rows.iter().flat_map(|row| &row.alongs).all(|a| a.is_finite());
        (is_known && !rows.is_empty()).then_some(Self { rows })
    }

    /// Unit normal of the camber surface towards greater theta, along x, along r and about the axis, at a position along the
    /// passage and a share of the height.
    pub fn camber(&self, along: f64, share: f64) -> DVec3 {
        let nv = self.rows.len();
        let row_at = |share: f64| &self.rows[((share * (nv - 1) as f64).round() as usize).min(nv - 1)];
        let row = row_at(share.clamp(0.0, 1.0));
        let n = row.alongs.len();
        // Beyond the edges, which are round, the walls go on as they come.
        let i = row.alongs.partition_point(|a| *a < along).clamp(EDGE + 1, n - 1 - EDGE);
        let (a, b) = (row.alongs[i - 1], row.alongs[i]);
        let t = if b > a { (along - a) / (b - a) } else { 0.0 };
        let clear = row_at(share.clamp(CLEAR, 1.0 - CLEAR));
        clear.cambers[i - 1].lerp(clear.cambers[i], t.clamp(0.0, 1.0)).normalize_or(DVec3::Z)
    }
}
