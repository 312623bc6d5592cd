//! How well a channel that was found agrees with its mesh, measured between the places that it was found from.

use std::collections::HashMap;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::super::channel::{
    Agreement, ChannelWall, Difference, Station, Surface, Throat, Unlike, along_at, station_at,
};
use super::super::error::BliskError;
use super::super::frame::slices::{Crossing, Gap, Slices};
use super::meridian::{Meridian, Tracer};
use super::walls::Rows;
use geometry::frame::{Cylindrical, angle_near};
use geometry::mesh::{Mesh, normal_times_two_areas};

/// Least share of the samples of a surface that must agree.
const ENOUGH: f64 = 0.95;
/// A place is far off where it misses by more than what it may miss by, times this: as behind a hole, where the mesh is
/// another wall. Fewer such places than [`LEAST_FAR`] may be slivers of it.
const FAR: f64 = 2.0;
const LEAST_FAR: usize = 2;
/// Share of a surface at each of its edges where a place far off may be one of a fillet or of a round edge.
const BESIDE_EDGE: f64 = 0.1;
/// Distance up to which a place agrees, beside the mesh's own chord error (mm), or as a share of the height where that
/// is more.
const TOLERANCE: f64 = 0.005;
const TOLERANCE_SHARE: f64 = 2e-4;
/// Factor on the tolerance where two channels are compared: each is found with an error of its own.
const APART: f64 = 5.0;
/// Number of places of a surface that must be further off than the tolerance by the factor [`MORE`] to be metal that one
/// channel has and the other has not, however small it is.
const LEAST_MORE: usize = 2;
const MORE: f64 = 10.0;
/// Cells of a wall at either edge that are not measured.
const EDGE_CELLS: usize = 2;
/// How far beyond the edges the channels are compared (shares of their length).
const BEYOND: [f64; 3] = [0.05, 0.2, 0.5];
/// Share of the passage's length beside a face at its end that is not compared.
const ON_FACE: f64 = 1e-3;
/// Places over a pitch at which they are compared there.
const AROUND: i32 = 100;
/// Fewer of these places that differ, as a share, are rounding.
const ROUNDING: f64 = 0.001;
/// A narrower throat is none (mm).
const LEAST_THROAT: f64 = 0.01;
/// Share of the channel's width that the end walls are measured over: fillets round the rest.
const MIDDLE_SHARE: f64 = 0.5;
/// Share of the width over which there is wall beside a hole.
const BESIDE_HOLE: f64 = 0.9;
/// Greatest share of the height that is taken for the mesh's own chord error.
const MOST_CHORD: f64 = 0.02;
/// Greatest share of the height that a cell of a wall may bend, as in a fillet.
const MOST_SAG: f64 = 0.05;
/// Share of the height that the rays to an end wall start from it.
pub(super) const START: f64 = 0.1;
/// Shares of the height from which rays start whose way from there is barred by a blade that leans.
const NEARER: [f64; 3] = [0.05, 0.025, 0.0125];
/// Rays that meet something within this share of the height from the end wall's station met the end wall.
const SAME: f64 = 0.01;
/// Where rays go past an end wall by more than this share of the height it is open there, and the greatest share of its
/// places at which holes leave it open.
const HOLE_DEPTH: f64 = 0.05;
const MOST_OPEN: f64 = 0.3;

/// What a ray to an end wall met.
struct Met {
    /// Half plane of the ray (rad).
    theta: f64,
    /// How far it is above the end wall's station (mm).
    above: f64,
    /// Facet that was met; none where nothing was.
    facet: Option<u32>,
    /// Place (x, r) that was met, that of the station where nothing was.
    end: DVec2,
}

/// How densely a channel is measured.
#[derive(Clone, Copy)]
pub(super) struct Density {
    /// Every so many cells of a wall's grid one is measured.
    every: usize,
    /// Stations at which hub and shroud are measured, and places across the channel at each.
    pub stations: usize,
    across: usize,
}

/// For the channel itself, and for whether the others are like it.
const DENSE: Density = Density { every: 2, stations: 40, across: 9 };
pub(super) const SPARSE: Density = Density { every: 4, stations: 16, across: 5 };

/// One measured place: how far off the mesh it is, with the sense, the mesh's own chord error there, where it is, and the
/// facet that is met.
#[derive(Clone, Copy)]
struct Sample {
    off: f64,
    chord: f64,
    at: DVec3,
    triangle: Option<u32>,
    /// How far the mesh lies beyond a surface that is given by hand (mm).
    left: f64,
    /// Whether it is beside an edge of the surface, where fillets and round edges are.
    at_edge: bool,
}

impl Sample {
    /// Whether it is off by no more than `times` what it may be off. What cannot be measured is not.
    fn is_near(&self, within: f64, times: f64) -> bool {
        self.off.abs() <= times * (self.chord + within)
    }
}

/// The facets of a mesh: triangles in one plane that are joined are one facet, however finely it was divided.
struct Facets {
    /// The facet of each triangle.
    of_triangle: Vec<u32>,
    /// How far each facet may lie off the bent surface that it stands for (mm).
    chords: Vec<f64>,
}

impl Facets {
    fn new(mesh: &Mesh) -> Self {
        /// A smaller turn (rad) is rounding.
        const FLAT: f64 = 1e-4;
        const NONE: u32 = u32::MAX;
        let normals: Vec<DVec3> = (0..mesh.triangles.len()).map(|i| normal_times_two_areas(mesh.corners(i))).collect();
        let triangle_of: HashMap<(u32, u32), usize> = mesh.sides().collect();
        // A facet has the plane of its greatest triangle, which rounding turns least. A triangle without area has none, and
        // joins any facet.
        let mut seeds: Vec<usize> = (0..normals.len()).collect();
        seeds.sort_by(|&i, &k| normals[k].length_squared().total_cmp(&normals[i].length_squared()));
        let mut of_triangle = vec![NONE; normals.len()];
        let mut rims = Vec::new();
        for seed in seeds {
            if of_triangle[seed] != NONE {
                continue;
            }
            let facet = rims.len() as u32;
            of_triangle[seed] = facet;
            let (mut rim, mut open) = (Vec::new(), vec![seed]);
            while let Some(triangle) = open.pop() {
                let [a, b, c] = mesh.triangles[triangle];
                for (from, to) in [(a, b), (b, c), (c, a)] {
                    let Some(&beside) = triangle_of.get(&(to, from)) else { continue };
                    let turn = normals[seed].angle_between(normals[beside]);
                    if turn >= FLAT {
                        rim.push(([from, to], turn));
                    } else if of_triangle[beside] == NONE {
                        of_triangle[beside] = facet;
                        open.push(beside);
                    }
                }
            }
            rims.push(rim);
        }
        Self { of_triangle, chords: rims.par_iter().map(|rim| chord_of_facet(mesh, rim)).collect() }
    }

    /// How far the facet of a sample may lie off the bent surface that it stands for (mm).
    fn of(&self, sample: &Sample) -> f64 {
        sample.triangle.map_or(0.0, |triangle| self.chords[self.of_triangle[triangle as usize] as usize])
    }
}

/// How far the facet within `rim` may lie off the bent surface that it stands for (mm): as far as an arc over it that turns
/// from each of its neighbours to the opposite one as they do, twice over, since facets differ in size. Creases are no arcs.
/// The rim is of edges, with the turn over each (rad).
fn chord_of_facet(mesh: &Mesh, rim: &[([u32; 2], f64)]) -> f64 {
    const CREASE: f64 = 0.6;
    let point = |v: u32| mesh.vertices[v as usize];
    let sag = |&([from, to], turn): &([u32; 2], f64)| {
        let (from, along) = (point(from), (point(to) - point(from)).normalize_or_zero());
        let across = rim.iter().map(|([v, _], _)| (point(*v) - from).cross(along).length()).fold(0.0, f64::max);
        (turn < CREASE).then_some(turn * across / 4.0)
    };
    rim.iter().filter_map(sag).fold(0.0, f64::max)
}

/// A channel to be measured against its mesh.
pub(super) struct Measured<'a> {
    pub tracer: &'a Tracer<'a>,
    pub meridian: &'a Meridian,
    /// The low and the high wall.
    pub walls: [&'a ChannelWall; 2],
    /// Where their rows lie.
    pub rows: Rows,
}

impl Measured<'_> {
    /// Measures walls and end walls against the mesh, and takes the throat into account.
    ///
    /// # Errors
    /// [`BliskError::Disagrees`] where more than a few places of a surface are not where the channel has them, or fewer are
    /// far from there,
    /// [`BliskError::DrawnOutside`] where a drawn one reaches into the part, and
    /// [`BliskError::NoThroat`] where its walls touch: what was found is no channel of this part then.
    pub fn agreement(&self, throat: &Throat) -> Result<Vec<Agreement>, BliskError> {
        let within = self.tolerance();
        let (mut all, mut off, mut facets) = (Vec::new(), Vec::new(), None);
        for (surface, mut samples) in self.samples(DENSE, 0.0)? {
            let open = match surface {
                Surface::Hub | Surface::Shroud => self.take_holes(surface, &mut samples),
                _ => 0.0,
            };
            let mut agreement = summary(surface, &samples, within);
            if !agrees(&agreement, &samples) {
                // Beside the facet that stands out most others lie deeper, by as much as they may be off their surface.
                let facets = facets.get_or_insert_with(|| Facets::new(self.tracer.slices.mesh()));
                let most = MOST_CHORD * self.least_height();
                samples.iter_mut().for_each(|sample| sample.chord += facets.of(sample).min(most));
                agreement = summary(surface, &samples, within);
            }
            agreement.open = open;
            if !agrees(&agreement, &samples) {
                off.push(agreement);
            }
            all.push(agreement);
        }
        // That of which most is off is what was not found; it may take others with it.
        if let Some(a) = off.into_iter().min_by(|a, b| a.share.total_cmp(&b.share)) {
            let key = if a.surface == Surface::Hub { "hub_points_mm" } else { "shroud_points_mm" };
            let Cylindrical { x, r, .. } = Cylindrical::from_point(a.at);
            let is_drawn = self.tracer.is_drawn(a.surface);
            return Err(if is_drawn { BliskError::DrawnOutside { key, x, r } } else { BliskError::Disagrees(a) });
        }
        if throat.width_mm < LEAST_THROAT {
            let Cylindrical { x, r, .. } = Cylindrical::from_point(throat.on_low_wall);
            return Err(BliskError::NoThroat { x, r });
        }
        Ok(all)
    }

    /// Takes the places at which an end wall is open out of its `samples`, and returns their share, where they are those of
    /// holes: few, deep, with wall beside them, and away from both ends of the passage, beyond which there may be no wall at
    /// all.
    fn take_holes(&self, surface: Surface, samples: &mut Vec<Sample>) -> f64 {
        let depth = HOLE_DEPTH * self.least_height();
        let is_open = |sample: &Sample| sample.off == f64::INFINITY || sample.off < -depth;
        let open = samples.iter().filter(|sample| is_open(sample)).count() as f64 / samples.len().max(1) as f64;
        let is_all_open = |station: &[Sample]| station.iter().all(is_open);
        let stations: Vec<&[Sample]> = samples.chunks(DENSE.across).collect();
        let ends = [stations.first(), stations.last()].into_iter().flatten();
        if open > MOST_OPEN || ends.into_iter().any(|station| station.iter().any(is_open)) {
            return 0.0;
        }
        if stations.iter().any(|station| is_all_open(station)) {
            let wider = self.end_wall_samples(surface, (DENSE, BESIDE_HOLE), 0.0);
            let is_lost = |(station, wider): (&&[Sample], &[Sample])| is_all_open(station) && is_all_open(wider);
            if stations.iter().zip(wider.chunks(DENSE.across)).any(is_lost) {
                return 0.0;
            }
        }
        samples.retain(|sample| !is_open(sample));
        open
    }

    /// The channels of this one's kind, every one of `kinds`, counted on from this one, of which more than a few places
    /// of a surface are off those of this channel turned about the axis, with what differs most.
    pub fn unlike(&self, blades: usize, kinds: usize) -> Result<Vec<Unlike>, BliskError> {
        self.unlike_among(0, &(1..blades / kinds).map(|i| i * kinds).collect::<Vec<_>>())
    }

    /// Whether the channels `unlike` this one, which are all others of its kind, are mostly like each other: then this is
    /// the odd one.
    pub fn is_odd(&self, unlike: &[Unlike]) -> Result<bool, BliskError> {
        // Channels beside this one share a wall with it, and may be spoilt with it.
        let [_, between @ .., _] = unlike else { return Ok(false) };
        let mut numbers: Vec<usize> = between.iter().map(|unlike| unlike.number).collect();
        if numbers.len() < 2 {
            return Ok(false);
        }
        let base = numbers.remove(numbers.len() / 2);
        Ok(2 * self.unlike_among(base, &numbers)?.len() < numbers.len())
    }

    /// The channels among `numbers` that are not like number `base`.
    fn unlike_among(&self, base: usize, numbers: &[usize]) -> Result<Vec<Unlike>, BliskError> {
        let unlike = self.unlike_of(base, numbers, None)?;
        if unlike.is_empty() {
            return Ok(unlike);
        }
        // What the facets of either channel may be off the surfaces that they stand for is no difference.
        let numbers: Vec<usize> = unlike.iter().map(|unlike| unlike.number).collect();
        self.unlike_of(base, &numbers, Some(&Facets::new(self.tracer.slices.mesh())))
    }

    /// The channels among `numbers` that differ from number `base` by more than the errors with which two are found, the cells' own chord
    /// error, and that of `facets`.
    fn unlike_of(&self, base: usize, numbers: &[usize], facets: Option<&Facets>) -> Result<Vec<Unlike>, BliskError> {
        let within = APART * self.tolerance();
        let turn_of = |number: usize| number as f64 * self.tracer.pitch;
        let covered = self.covered(turn_of(base));
        let own: Vec<_> = self.samples(SPARSE, turn_of(base))?.collect();
        let most_chord = self.most_sag();
        let unlike = |number: usize| {
            let turn = turn_of(number);
            let compared = self.samples(SPARSE, turn)?.zip(&own).map(|((surface, mut samples), (_, own))| {
                let chord = |sample: &Sample| facets.map_or(0.0, |all| all.of(sample));
                let is_end_wall = matches!(surface, Surface::Hub | Surface::Shroud);
                // The two channels are compared, not both with the grid between its points.
                for (sample, own) in samples.iter_mut().zip(own) {
                    // A hole that both have is no difference.
                    let is_hole = is_end_wall && [&*sample, own].iter().all(|s| s.off == f64::INFINITY);
                    sample.off = if is_hole { 0.0 } else { sample.off - own.off };
                    sample.chord += (chord(sample) + chord(own)).min(most_chord);
                }
                let has_more = samples.iter().filter(|s| s.off.abs() > s.chord + MORE * within).count() >= LEAST_MORE;
                (summary(surface, &samples, within), has_more)
            });
            let off = compared.filter(|(a, has_more)| a.share < ENOUGH || *has_more).map(|(a, _)| a);
            let off = off.max_by(|a, b| a.greatest_mm.total_cmp(&b.greatest_mm));
            let off = off.map(|a| Difference::Surface { surface: a.surface, greatest_mm: a.greatest_mm });
            let tips = || ((self.covered(turn) - covered).abs() > 1.0 - ENOUGH).then_some(Difference::Tips);
            let beside = || self.differing_beside_edges([turn_of(base), turn]) > 1.0 - ENOUGH;
            let edges = || beside().then_some(Difference::BesideEdges);
            let difference = off.or_else(tips).or_else(edges);
            Ok::<_, BliskError>(difference.map(|difference| Unlike { number, difference }))
        };
        let all: Vec<Result<Option<Unlike>, BliskError>> = numbers.par_iter().map(|number| unlike(*number)).collect();
        let all = all.into_iter().collect::<Result<Vec<_>, _>>()?;
        Ok(all.into_iter().flatten().collect())
    }

    /// Share of the metal between hub and shroud beyond the edges, a pitch to either side, that only one of two channels
    /// has, which lie `turns` further about the axis than this one (rad): a splitter ends where its neighbours go on.
    fn differing_beside_edges(&self, turns: [f64; 2]) -> f64 {
        let (wall, stations) = (self.walls[0], &self.meridian.stations[..]);
        let (mut all, mut metal, mut differ) = (0, 0, 0);
        // Not beyond the passage's own ends, where there may be other things, nor on a face there, which may stand aslant.
        let [Some(first), Some(last)] = [stations.first(), stations.last()] else { return 0.0 };
        let face = ON_FACE * (last.along - first.along);
        let (first, last) = (first.along + face, last.along - face);
        for share in [0.1, 0.5, 0.9] {
            let v = (share * (wall.nv - 1) as f64).round() as usize;
            let share = self.rows.share(v);
            let along = |end: Cylindrical| along_at(stations, DVec2::new(end.x, end.r), share);
            let edges = [0, wall.nu - 1].map(|u| self.walls.map(|wall| wall.cylindrical(u, v)));
            let length = along(edges[1][0]) - along(edges[0][0]);
            for (ends, way) in edges.into_iter().zip([-length, length]) {
                let middle = 0.5 * (ends[0].theta + angle_near(ends[1].theta, ends[0].theta));
                for beyond in BEYOND {
                    let at = station_at(stations, (along(ends[0]) + beyond * way).clamp(first, last)).place(share);
                    let both = turns.map(|turn| self.metal(at, middle + turn));
                    all += both[0].len();
                    metal += both[0].iter().zip(&both[1]).filter(|(a, b)| **a || **b).count();
                    differ += both[0].iter().zip(&both[1]).filter(|(a, b)| a != b).count();
                }
            }
        }
        // So little is rounding.
        if differ as f64 <= ROUNDING * all as f64 { 0.0 } else { differ as f64 / metal as f64 }
    }

    /// Whether there is metal at places on the circle through (x, r), over a pitch to either side of `middle` (rad).
    fn metal(&self, at: DVec2, middle: f64) -> Vec<bool> {
        let gaps = self.tracer.slices.gaps(at.x, at.y);
        let is_free = |theta: f64| gaps.iter().any(|gap| gap.holds(theta));
        let theta = |k: i32| middle + f64::from(k) / f64::from(AROUND) * self.tracer.pitch;
        if gaps.is_empty() {
            return vec![self.tracer.slices.is_solid(at.x, at.y, middle); 2 * AROUND as usize + 1];
        }
        (-AROUND..=AROUND).map(|k| !is_free(theta(k))).collect()
    }

    /// Distance up to which a place agrees, beside the mesh's own chord error (mm).
    fn tolerance(&self) -> f64 {
        TOLERANCE.max(TOLERANCE_SHARE * self.least_height())
    }

    fn least_height(&self) -> f64 {
        self.meridian.stations.iter().map(Station::height).fold(f64::INFINITY, f64::min)
    }

    /// How far a cell of a wall may bend at most (mm).
    fn most_sag(&self) -> f64 {
        MOST_SAG * self.meridian.stations.iter().map(Station::height).fold(0.0, f64::max)
    }

    /// The measured places of each surface of the channel that lies `turn` further about the axis (rad).
    fn samples(&self, density: Density, turn: f64) -> Result<impl Iterator<Item = (Surface, Vec<Sample>)>, BliskError> {
        let ends = if self.meridian.shrouded { &[Surface::Hub, Surface::Shroud][..] } else { &[Surface::Hub] };
        self.tracer.cancel.check()?;
        let walls = [(Surface::LowWall, low as fn(&Gap) -> Crossing), (Surface::HighWall, high)];
        let walls = walls.into_iter().zip(self.walls);
        let walls = walls.map(move |((surface, end), wall)| (surface, self.wall_samples(wall, end, density, turn)));
        let ends =
            ends.iter().map(move |&surface| (surface, self.end_wall_samples(surface, (density, MIDDLE_SHARE), turn)));
        Ok(walls.chain(ends))
    }

    /// The middles of the cells of a wall's grid: where the circle through each meets the mesh.
    fn wall_samples(&self, wall: &ChannelWall, end: fn(&Gap) -> Crossing, density: Density, turn: f64) -> Vec<Sample> {
        let tracer = self.tracer;
        let every = density.every;
        // Not at the edges, round which a wall turns within a cell or two.
        let edge = EDGE_CELLS.min((wall.nu - 2) / 2);
        let columns = (edge + 1..wall.nu - edge).step_by(every);
        let cells = columns.flat_map(|u| (every.div_ceil(2)..wall.nv).step_by(every).map(move |v| (u, v)));
        let cells: Vec<_> = cells.collect();
        let most_sag = self.most_sag();
        let sample = |&(u, v): &(usize, usize)| {
            let (at, sag) = cell(wall, u, v);
            let Cylindrical { x, r, theta } = Cylindrical::from_point(at);
            let thetas = self.walls.map(|wall| angle_near(Cylindrical::from_point(cell(wall, u, v).0).theta, theta));
            let near = |t: f64| Crossing { theta: t + turn, enters: true, triangle: 0 };
            let near = Gap { low: near(thetas[0].min(theta)), high: near(thetas[1].max(theta)) };
            let found = tracer.bladed_gap(x, r, &near).map(|gap| end(&gap));
            let theta = theta + turn;
            let off = found.map_or(f64::INFINITY, |crossing| {
                let around = DVec3::new(0.0, -theta.cos(), -theta.sin());
                // A triangle without area has no normal.
                let normal = tracer.slices.normal(crossing.triangle).try_normalize().unwrap_or(around);
                r * (crossing.theta - theta) * normal.dot(around).abs()
            });
            let at_edge = is_at_edge(u, wall.nu) || is_at_edge(v, wall.nv);
            let triangle = found.map(|crossing| crossing.triangle);
            Sample { off, chord: sag.min(most_sag), at, triangle, left: 0.0, at_edge }
        };
        cells.par_iter().map(sample).collect()
    }

    /// Rays along the stations from within the channel to its hub or shroud, over the middle share `middle_share` of its
    /// width there.
    fn end_wall_samples(&self, surface: Surface, (density, middle_share): (Density, f64), turn: f64) -> Vec<Sample> {
        let (tracer, walls, meridian) = (self.tracer, self.walls, &self.meridian.stations[..]);
        let (row, share, radius) = if surface == Surface::Hub {
            (0, 0.0, tracer.options.hub_radius_mm)
        } else {
            (walls[0].nv - 1, 1.0, tracer.options.shroud_radius_mm)
        };
        let given = radius.given().is_some() || tracer.is_drawn(surface);
        let Density { stations, across, .. } = density;
        let of_column = |i: usize| {
            let u = (i + 1) * (walls[0].nu - 1) / (stations + 1);
            let at_edge = is_at_edge(i, stations);
            let ends = walls.map(|wall| wall.cylindrical(u, row));
            let middle = 0.5 * (DVec2::new(ends[0].x, ends[0].r) + DVec2::new(ends[1].x, ends[1].r));
            let station = station_at(meridian, along_at(meridian, middle, self.rows.share(row)));
            let [first, last] = [ends[0].theta, angle_near(ends[1].theta, ends[0].theta)];
            let (middle, half) = (0.5 * (first + last) + turn, 0.5 * middle_share * (last - first));
            let height = station.height();
            let start_of = |start: f64| tracer.start_of(&station, share + (1.0 - 2.0 * share) * start, surface);
            let from = |start: f64| start_of(start)[0];
            let ray = |theta: f64, start: f64| {
                let [from, toward] = start_of(start);
                let met = tracer.met(theta, from, toward, f64::INFINITY);
                let distance = met.map_or(start * height, |(distance, _)| distance);
                Met {
                    theta,
                    above: start * height - distance,
                    facet: met.map(|met| met.1),
                    end: from + distance * toward,
                }
            };
            let met = |k: usize| {
                let theta = middle + half * (2.0 * k as f64 / (across - 1) as f64 - 1.0);
                let far = ray(theta, START);
                // Over a narrow passage a blade leans: then the end wall is met from nearer, through air. What else is met
                // stands in the passage.
                if far.facet.is_some_and(|facet| !tracer.is_of_blade(facet, theta)) {
                    return far;
                }
                let is_same = |met: &Met| met.facet.is_some() && met.above.abs() < SAME * height;
                let nearer =
                    NEARER.into_iter().filter(|start| !tracer.slices.is_solid(from(*start).x, from(*start).y, theta));
                nearer.map(|start| ray(theta, start)).find(is_same).unwrap_or(far)
            };
            let met: Vec<Met> = (0..across).map(met).collect();
            // A station is that of the facet which stands out most there, beside which flatter ones lie.
            let chord = |met: &Met| Some(chord_error(tracer.slices, meridian, share, met.facet?, met.end.y));
            let chord = met.iter().filter_map(chord).fold(0.0, f64::max).min(MOST_CHORD * height);
            let sample = |met: &Met| {
                // A radius or a curve given by hand may leave metal to others, but may not reach into the part.
                // Beyond a drawn one the rays may graze the walls, where these come together.
                let missed = if tracer.is_drawn(surface) { 0.0 } else { f64::INFINITY };
                let above = if given { met.above.max(0.0) } else { met.above };
                let left = if given && met.facet.is_some() { (-met.above - chord).max(0.0) } else { 0.0 };
                let at = Cylindrical { x: met.end.x, r: met.end.y, theta: met.theta }.point();
                Sample { off: met.facet.map_or(missed, |_| above), chord, at, triangle: met.facet, left, at_edge }
            };
            let mut samples: Vec<Sample> = met.iter().map(sample).collect();
            // A hole is deeper than the wall beside it.
            let mut left: Vec<f64> = samples.iter().map(|s| s.left).collect();
            left.sort_by(f64::total_cmp);
            let most = left[left.len() / 2] + HOLE_DEPTH * height;
            samples.iter_mut().filter(|s| s.left > most).for_each(|s| s.left = 0.0);
            samples
        };
        (0..stations).into_par_iter().map(of_column).collect::<Vec<_>>().concat()
    }
}

/// The middle of the cell of a wall's grid that ends at (`u`, `v`), and how far the cell lies off the bent surface
/// (mm).
fn cell(wall: &ChannelWall, u: usize, v: usize) -> (DVec3, f64) {
    let places = [(u - 1, v - 1), (u, v - 1), (u, v), (u - 1, v)];
    let corners = places.map(|(u, v)| wall.point(u, v));
    // Halfway along the diagonals the grid lies on either side of a bent surface.
    let bend = (corners[0] + corners[2] - corners[1] - corners[3]).length() / 4.0;
    let sag = [[0, 1], [1, 2], [2, 3], [3, 0]].map(|[i, k]| {
        let [p, q] = [places[i], places[k]];
        let turn = wall.normal(p.0, p.1).angle_between(wall.normal(q.0, q.1));
        // Where a fillet begins within the cell, all of the turn may be in one place.
        corners[i].distance(corners[k]) * turn / 4.0
    });
    (corners.iter().sum::<DVec3>() / 4.0, bend + sag[0].max(sag[2]) + sag[1].max(sag[3]))
}

fn low(gap: &Gap) -> Crossing {
    gap.low
}

fn high(gap: &Gap) -> Crossing {
    gap.high
}

/// Whether number `at` of `count` places across a surface is beside its edge.
fn is_at_edge(at: usize, count: usize) -> bool {
    let off = at.min(count.saturating_sub(at + 1));
    (off as f64) < BESIDE_EDGE * count as f64
}

/// Whether a surface agrees with the mesh: most of its places, and all but single ones nearly.
fn agrees(agreement: &Agreement, samples: &[Sample]) -> bool {
    let is_far = |s: &&Sample| !s.at_edge && !s.is_near(agreement.within_mm, FAR);
    agreement.share >= ENOUGH && samples.iter().filter(is_far).count() < LEAST_FAR
}

/// What cannot be measured does not agree: a distance that is no number, and a surface without any place.
fn summary(surface: Surface, samples: &[Sample], within_mm: f64) -> Agreement {
    let good = samples.iter().filter(|s| s.is_near(within_mm, 1.0)).count();
    let worst = samples.iter().max_by(|a, b| a.off.abs().total_cmp(&b.off.abs()));
    Agreement {
        surface,
        samples: samples.len(),
        share: good as f64 / samples.len().max(1) as f64,
        within_mm,
        greatest_mm: worst.map_or(0.0, |s| s.off.abs()),
        at: worst.map_or(DVec3::ZERO, |s| s.at),
        open: 0.0,
        left_mm: samples.iter().map(|s| s.left).fold(0.0, f64::max),
    }
}

/// How far a triangle that is met at radius `r` may lie off the surface of revolution that it stands for (mm): its
/// chord around the axis, and its chord along the hub or shroud curve, which is the one at `share` of the height.
fn chord_error(slices: &Slices, meridian: &[Station], share: f64, triangle: u32, r: f64) -> f64 {
    let corners = slices.mesh().corners(triangle as usize).map(Cylindrical::from_point);
    let alongs = corners.map(|c| along_at(meridian, DVec2::new(c.x, c.r), share));
    let (first, last) = alongs.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), a| (a.min(l), a.max(m)));
    let place = |along: f64| station_at(meridian, along).place(share);
    let chord = place(0.5 * (first + last)).distance(0.5 * (place(first) + place(last)));
    slices.radial_sag(triangle, r) + chord
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::super::agreement_tests::quartered;
    use super::*;

    /// The flat sides of a tube of 36 lie off it by their chord times the turn between two over eight, which is taken twice.
    #[test]
    fn a_facet_lies_off_as_far_however_finely_it_is_divided() {
        let (sides, radius) = (36, 50.0);
        let turn = TAU / f64::from(sides);
        let end = |x: f64| (0..sides).map(move |i| Cylindrical { x, r: radius, theta: f64::from(i) * turn }.point());
        let triangles = (0..sides as u32).flat_map(|i| {
            let (k, far) = ((i + 1) % sides as u32, sides as u32);
            [[i, k, k + far], [i, k + far, i + far]]
        });
        let tube = Mesh { vertices: end(0.0).chain(end(200.0)).collect(), triangles: triangles.collect() };
        let chord = 2.0 * radius * (turn / 2.0).sin() * turn / 4.0;
        for times in [0, 5] {
            let facets = Facets::new(&quartered(&tube, times));
            assert_eq!(facets.chords.len(), sides as usize);
            facets.chords.iter().for_each(|found| assert!((found - chord).abs() < 1e-3 * chord, "{found} {chord}"));
        }
    }

    #[test]
    fn what_cannot_be_measured_does_not_agree() {
        let sample =
            |off: f64| Sample { off, chord: 0.001, at: DVec3::ZERO, triangle: None, left: 0.0, at_edge: false };
        let share = |offs: &[f64]| {
            summary(Surface::Hub, &offs.iter().map(|off| sample(*off)).collect::<Vec<_>>(), TOLERANCE).share
        };
        assert_eq!(share(&[]), 0.0);
        assert_eq!(share(&[0.0, 0.0059, f64::NAN, f64::INFINITY]), 0.5);
        assert_eq!(share(&[-0.0059, -0.0061]), 0.5);
    }
}
