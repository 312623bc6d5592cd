//! The two walls of a channel as grids of points that lie exactly on the mesh, between the blades' edges.

use std::f64::consts::{PI, TAU};
use std::ops::RangeInclusive;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::super::channel::{BladeSide, ChannelWall, Flow, along_at, station_at};
use super::super::error::BliskError;
use super::super::frame::slices::{Crossing, Gap};
use super::meridian::{FACE_ROUNDING, Meridian, Place, Tracer, middle_between};
use super::turned;
use geometry::frame::{Cylindrical, angle_near};

/// The first and last row of points stay away from hub and shroud by the first of these shares of the height at which the
/// facets of the end walls, which are large on coarse meshes, do not cut their circles.
const INSETS: [f64; 4] = [0.005, 0.01, 0.02, 0.04];

/// From step to step an end of a gap moves into it by less than this share of its width.
const JUMP: f64 = 0.3;
/// At an edge that is flush with a face the ends of a gap move by less than this share of its width within the rounding
/// of that face.
const EDGE_JUMP: f64 = 0.005;

/// Share of the columns of a wall's grid that may jump between hub and shroud.
const MOST_JUMPS: f64 = 0.05;

/// Before a flat edge a gap has widened by less than this share of the pitch from one step to the next.
const MOST_WIDENED: f64 = 0.4;

/// A passage that widens at once by more than this share of its width does so suddenly.
const SUDDEN: f64 = 0.05;
/// From step to step a wall moves by less than this share of the passage's width.
const SAME_WALL: f64 = 0.1;
/// Shares of the height at which facets of hub and shroud do not stand out into a row.
const NOT_AT_END_WALLS: RangeInclusive<f64> = 0.04..=0.96;

/// Points beyond an edge on a wall that goes on there.
pub(super) const BEYOND_EDGE: usize = 24;

/// Blades that go on so far beyond the end of hub or shroud (share of the height) are not bounded there.
const BEYOND_END: f64 = 0.05;

/// A curve along the channel at a constant share of the height, between the blades' edges.
pub(super) struct Row {
    /// Share of the height, 0 at the hub and 1 at the shroud.
    share: f64,
    /// The last place before the edges at the beginning of the passage.
    pub front: Place,
    /// The last place before the edges at its end.
    pub back: Place,
    /// A place between them.
    inside: Place,
}

/// Both walls of a channel, and where their rows lie.
pub(super) struct Walls {
    pub low: ChannelWall,
    pub high: ChannelWall,
    pub rows: Rows,
}

/// The rows of the points of a wall.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rows {
    /// Share of the height by which the first and the last stay away from hub and shroud.
    pub inset: f64,
    /// How many there are, two at least.
    count: usize,
}

impl Rows {
    /// Share of the height at which row `v` lies.
    pub fn share(self, v: usize) -> f64 {
        self.inset + (1.0 - 2.0 * self.inset) * v as f64 / (self.count - 1) as f64
    }

    /// How far hub and shroud lie beyond the first and the last row, in steps from row to row.
    pub fn beyond(self) -> f64 {
        self.inset / (1.0 - 2.0 * self.inset) * (self.count - 1) as f64
    }
}

/// Share of the blades' length by which an edge may be further from one row to the next.
const EDGE_STEP: f64 = 0.2;
/// Slope of an edge against the height up to which that may be more.
const EDGE_SLOPE: f64 = 8.0;

/// Finds rows and walls of a channel with known end walls.
pub(super) struct WallFinder<'a> {
    pub tracer: &'a Tracer<'a>,
    pub meridian: &'a Meridian,
    /// A place between the blades.
    pub start: Place,
}

impl WallFinder<'_> {
    /// The place (x, r) at `along` and `share` of the height. An axial channel goes on beyond its rings.
    fn place_at(&self, along: f64, share: f64) -> Option<DVec2> {
        let stations = &self.meridian.stations;
        let station = station_at(stations, along);
        if self.meridian.flow == Flow::Axial {
            let (hub, shroud) = (station.hub.y, station.shroud.y);
            return Some(DVec2::new(along, hub + share * (shroud - hub)));
        }
        let ends = [stations.first()?.along, stations.last()?.along];
        (ends[0]..=ends[1]).contains(&along).then(|| station.place(share))
    }

    /// The channel's place at `along` and `share` of the height, where blades bound it on both sides as they do at
    /// `near`. A gap of which an end jumps is none between the same blades: a splitter begins there, or facets of an end
    /// wall stand out of it.
    fn bladed(&self, along: f64, share: f64, near: &Place) -> Option<Place> {
        let at = self.place_at(along, share)?;
        let gap = self.tracer.bladed_gap(at.x, at.y, &near.gap)?;
        let narrowed = (gap.low.theta - near.gap.low.theta).max(near.gap.high.theta - gap.high.theta);
        // Less in less than a step, but the root of that beside round edges.
        let most = JUMP * near.gap.width() * ((along - near.along).abs() / self.step()).min(1.0).sqrt();
        (narrowed <= most).then_some(Place { along, x: at.x, r: at.y, gap })
    }

    fn lost(&self, along: f64, share: f64) -> BliskError {
        let at = station_at(&self.meridian.stations, along).place(share);
        BliskError::LostWall { x: at.x, r: at.y }
    }

    /// Longest step along the passage (mm).
    fn step(&self) -> f64 {
        let length = match (self.meridian.flow, &self.meridian.stations[..]) {
            (Flow::Axial, _) | (_, []) => self.tracer.slices.bounds().size().x,
            (_, [first, ..]) => self.meridian.stations.last().map_or(0.0, |last| last.along - first.along),
        };
        length / 256.0
    }

    /// The row at `share` of the height.
    pub fn row(&self, share: f64) -> Result<Row, BliskError> {
        let inside = self.climb(share)?;
        Ok(Row { share, front: self.edge(&inside, share, -1.0)?, back: self.edge(&inside, share, 1.0)?, inside })
    }

    /// The place at the start's station and `share` of the height, reached from the start on a straight line.
    fn climb(&self, share: f64) -> Result<Place, BliskError> {
        let Place { along, x, r, gap } = self.start;
        let to = self.place_at(along, share).ok_or_else(|| self.lost(along, share))?;
        let gap = self.tracer.followed(&gap, DVec2::new(x, r), to)?;
        Ok(Place { along, x: to.x, r: to.y, gap })
    }

    /// The last place towards the beginning or the end that blades bound on both sides.
    fn edge(&self, from: &Place, share: f64, toward: f64) -> Result<Place, BliskError> {
        let step = self.step();
        if step.is_nan() || step <= 0.0 {
            return Err(self.lost(from.along, share));
        }
        let (mut before, mut good) = (*from, *from);
        let mut bad = loop {
            self.tracer.cancel.check()?;
            match self.bladed(good.along + toward * step, share, &good) {
                Some(place) => {
                    self.check_widening(&good, &place, share)?;
                    (before, good) = (good, place);
                }
                None => break good.along + toward * step,
            }
        };
        while let Some(along) = middle_between(good.along, bad, step) {
            match self.bladed(along, share, &good) {
                Some(place) => good = place,
                None => bad = along,
            }
        }
        // Where a flat edge lies along the circles they run into its face, up to the next blade: the passage ends before.
        if self.follow(share, from, good.along).is_err() {
            let is_within = |place: &Place| place.gap.width() - before.gap.width() < MOST_WIDENED * self.tracer.pitch;
            (good, bad) = (before, good.along);
            while let Some(along) = middle_between(good.along, bad, step) {
                match self.bladed(along, share, &before).filter(is_within) {
                    Some(place) => good = place,
                    None => bad = along,
                }
            }
        }
        // Beside a face that is flush with the edge a circle may meet the face itself.
        let inside = good.along - toward * FACE_ROUNDING * self.tracer.slices.bounds().size().length();
        if (inside - from.along) * toward > 0.0 {
            let inside = self.follow(share, from, inside)?;
            let moved = [inside.gap.low.theta - good.gap.low.theta, inside.gap.high.theta - good.gap.high.theta];
            if moved.iter().any(|moved| moved.abs() > EDGE_JUMP * good.gap.width()) {
                good = inside;
            }
        }
        self.check_end(&good, share, toward)?;
        self.check_undivided(&good, bad + 0.5 * toward * step, share)?;
        Ok(good)
    }

    /// Refuses a passage that widens suddenly between two places and goes on: metal in it has ended there. At a
    /// blade's edge it ends there.
    fn check_widening(&self, from: &Place, to: &Place, share: f64) -> Result<(), BliskError> {
        const HALVINGS: usize = 12;
        let widened = |from: &Place, to: &Place| {
            let ends = [[to.gap.low, from.gap.low], [from.gap.high, to.gap.high]].map(|ends| ends.map(|end| end.theta));
            if ends[0][1] - ends[0][0] > ends[1][1] - ends[1][0] { ends[0] } else { ends[1] }
        };
        let is_jump = |[low, high]: [f64; 2]| high - low > SUDDEN * from.gap.width();
        if !is_jump(widened(from, to)) || !NOT_AT_END_WALLS.contains(&share) {
            return Ok(());
        }
        // What is sudden stays so however near to each other the places are.
        let (mut near, mut far) = (*from, *to);
        for _ in 0..HALVINGS {
            let Some(middle) = self.bladed(0.5 * (near.along + far.along), share, &near) else { return Ok(()) };
            if is_jump(widened(&near, &middle)) { far = middle } else { near = middle }
        }
        let [low, high] = widened(&near, &far);
        let beyond = to.along + 0.25 * (to.along - from.along).signum() * (high - low) * to.r;
        if !is_jump([low, high]) || self.follow(share, to, beyond).is_err() {
            return self.tracer.cancel.check().map_err(BliskError::from);
        }
        let at = Cylindrical { x: near.x, r: near.r, theta: 0.5 * (low + high) }.point();
        Err(BliskError::Obstructed { at, off_mm: 0.5 * (high - low) * near.r })
    }

    /// Refuses an edge beyond which, at `beyond`, both blades go on with metal between them that ends before they do: a
    /// splitter goes on to the end.
    fn check_undivided(&self, edge: &Place, beyond: f64, share: f64) -> Result<(), BliskError> {
        let (step, mut walls) = ((beyond - edge.along).signum() * self.step(), edge.gap);
        let (mut along, mut met) = (beyond, None);
        while let Some(at) = self.place_at(along, share).filter(|_| NOT_AT_END_WALLS.contains(&share)) {
            self.tracer.cancel.check()?;
            let Some((around, between)) = self.between(&walls, at) else { break };
            met = met.or(between.map(|metal| (at, metal)));
            let Some((at, [low, high])) = met else { break };
            if between.is_none() {
                let off_mm = at.y * (low - edge.gap.low.theta).min(edge.gap.high.theta - high);
                let at = Cylindrical { x: at.x, r: at.y, theta: 0.5 * (low + high) }.point();
                return Err(BliskError::Obstructed { at, off_mm });
            }
            (walls, along) = (around, along + step);
        }
        Ok(())
    }

    /// At a place (x, r), where both walls are near those of `near`: the gap from one to the other, and from where to
    /// where the first metal between them reaches, if there is any.
    fn between(&self, near: &Gap, at: DVec2) -> Option<(Gap, Option<[f64; 2]>)> {
        let turned_near = |gap: Gap| turned(gap, angle_near(gap.middle(), near.middle()) - gap.middle());
        let mut gaps: Vec<Gap> = self.tracer.slices.gaps(at.x, at.y).into_iter().map(turned_near).collect();
        gaps.sort_by(|a, b| a.low.theta.total_cmp(&b.low.theta));
        let is_near = |a: Crossing, b: Crossing| (a.theta - b.theta).abs() < SAME_WALL * near.width();
        let first = gaps.iter().position(|gap| is_near(gap.low, near.low))?;
        let last = gaps.iter().position(|gap| is_near(gap.high, near.high)).filter(|last| *last >= first)?;
        let metal = (last > first).then(|| [gaps[first].high.theta, gaps[first + 1].low.theta]);
        Some((Gap { low: gaps[first].low, high: gaps[last].high }, metal))
    }

    /// Refuses an edge where hub or shroud ends, but not the blades.
    fn check_end(&self, edge: &Place, share: f64, toward: f64) -> Result<(), BliskError> {
        let stations = &self.meridian.stations;
        let (([.., before, last], true) | ([last, before, ..], false)) = (&stations[..], toward > 0.0) else {
            return Ok(());
        };
        let way = last.place(share) - before.place(share);
        let is_inside = (edge.along - last.along).abs() > 1e-6 * self.step();
        // Beside hub and shroud the edges may be flush with their ends.
        if self.meridian.flow == Flow::Axial || is_inside || !(0.25..=0.75).contains(&share) {
            return Ok(());
        }
        let beyond = last.place(share) + BEYOND_END * last.height() * way.normalize_or_zero();
        match self.tracer.bladed_gap(beyond.x, beyond.y, &edge.gap) {
            None => Ok(()),
            Some(_) => Err(BliskError::Unbounded { x: beyond.x, r: beyond.y }),
        }
    }

    /// The place of a row at `along`, between its edges.
    pub fn place(&self, row: &Row, along: f64) -> Result<Place, BliskError> {
        self.follow(row.share, &row.inside, along)
    }

    /// The gaps of a row at `n` places from edge to edge, closer together towards both.
    fn gaps(&self, row: &Row, n: usize) -> Result<Vec<Place>, BliskError> {
        let (from, to) = (row.front.along, row.back.along);
        let along_of = |u: usize| from + (to - from) * 0.5 * (1.0 - (PI * u as f64 / (n - 1) as f64).cos());
        let inner: Vec<f64> = (1..n - 1).map(along_of).collect();
        let middle = inner.partition_point(|&along| along < row.inside.along);
        let follow = |all: &mut dyn Iterator<Item = f64>| {
            let mut last = row.inside;
            all.map(|along| {
                self.tracer.cancel.check()?;
                // Within the facets of a twisted edge short steps may not go over a jump that the edge was found beyond.
                let next = self.follow(row.share, &last, along);
                last = next.or_else(|_| self.follow(row.share, &row.inside, along))?;
                Ok(last)
            })
            .collect::<Result<Vec<_>, BliskError>>()
        };
        let mut places = vec![row.back];
        places.splice(0..0, follow(&mut inner[middle..].iter().copied())?);
        let mut front = follow(&mut inner[..middle].iter().rev().copied())?;
        front.push(row.front);
        front.reverse();
        front.extend(places);
        Ok(front)
    }

    /// The place at `to` on a row, followed from `from` in steps no longer than the part allows.
    fn follow(&self, share: f64, from: &Place, to: f64) -> Result<Place, BliskError> {
        let steps = ((to - from.along).abs() / self.step()).ceil().max(1.0) as usize;
        (1..=steps).try_fold(*from, |place, i| {
            let along = from.along + (to - from.along) * i as f64 / steps as f64;
            self.bladed(along, share, &place).ok_or_else(|| self.lost(along, share))
        })
    }

    /// Both walls, low and high, with `nu` by `nv` points. Their sides are not set yet.
    pub fn walls(&self, nu: usize, nv: usize) -> Result<Walls, BliskError> {
        let mut first_error = None;
        for rows in INSETS.map(|inset| Rows { inset, count: nv }) {
            match self.walls_of(nu, rows) {
                Err(BliskError::LostWall { x, r }) => first_error = first_error.or(Some(BliskError::LostWall { x, r })),
                walls => return walls.map(|[low, high]| Walls { low, high, rows }),
            }
        }
        Err(first_error.unwrap_or_else(|| self.lost(self.start.along, 0.5)))
    }

    fn walls_of(&self, nu: usize, rows: Rows) -> Result<[ChannelWall; 2], BliskError> {
        let nv = rows.count;
        let of_row = |v| self.gaps(&self.row(rows.share(v))?, nu);
        let rows: Vec<Vec<Place>> = (0..nv).into_par_iter().map(of_row).collect::<Result<_, BliskError>>()?;
        check_edges(&rows)?;
        Ok([|g: &Gap| g.low, |g: &Gap| g.high].map(|end| {
            let order = || (0..nu).flat_map(|u| rows.iter().map(move |row| &row[u]));
            ChannelWall {
                nu,
                nv,
                points: order().map(|p| point(p, end(&p.gap))).collect(),
                normals: order().map(|p| self.normal(end(&p.gap))).collect(),
                side: BladeSide::Flat,
            }
        }))
    }

    /// The grids of both walls with what their blades go on by beyond the ends of the passage between them, as far as it is
    /// wide there; where a blade ends, points repeat. Normals are those of its ends there.
    pub fn beyond_edges(&self, Walls { low, high, rows }: &Walls) -> Result<[ChannelWall; 2], BliskError> {
        let (walls, nu, nv) = ([low, high], low.nu, low.nv);
        let rows: Vec<[Vec<DVec3>; 2]> = (0..nv)
            .into_par_iter()
            .map(|v| {
                self.tracer.cancel.check()?;
                let share = rows.share(v);
                let end = |u, toward| self.beyond_edge(walls, (u, v), share, toward);
                let ends = [end(0, -1.0), end(nu - 1, 1.0)];
                Ok([0, 1].map(|w| {
                    let ahead = ends[0][w].iter().rev().copied();
                    ahead.chain((0..nu).map(|u| walls[w].point(u, v))).chain(ends[1][w].iter().copied()).collect()
                }))
            })
            .collect::<Result<_, BliskError>>()?;
        let all = nu + 2 * BEYOND_EDGE;
        Ok([0, 1].map(|w| {
            let points = (0..all).flat_map(|u| rows.iter().map(move |row| row[w][u])).collect();
            let nearest = |u: usize| u.saturating_sub(BEYOND_EDGE).min(nu - 1);
            let normals = (0..all).flat_map(|u| (0..nv).map(move |v| walls[w].normal(nearest(u), v))).collect();
            ChannelWall { nu: all, nv, points, normals, side: BladeSide::Flat }
        }))
    }

    /// Of each wall the points beyond its end at grid position (`u`, `v`), which lies at `share` of the height.
    fn beyond_edge(
        &self,
        walls: [&ChannelWall; 2],
        (u, v): (usize, usize),
        share: f64,
        toward: f64,
    ) -> [Vec<DVec3>; 2] {
        let stations = &self.meridian.stations;
        let (ends, at) = (walls.map(|wall| wall.cylindrical(u, v)), walls.map(|wall| wall.point(u, v)));
        let along = along_at(stations, DVec2::new(ends[0].x, ends[0].r), share);
        let step = toward * at[0].distance(at[1]) / BEYOND_EDGE as f64;
        [0, 1].map(|w| {
            let (mut theta, mut points) = (ends[w].theta, Vec::with_capacity(BEYOND_EDGE));
            let next = |theta: f64, k: usize| {
                let place = self.place_at(along + k as f64 * step, share)?;
                let gaps = self.tracer.slices.gaps(place.x, place.y).into_iter();
                let thetas = gaps.map(|gap| angle_near([gap.low, gap.high][w].theta, theta));
                let near = thetas.min_by(|a, b| (a - theta).abs().total_cmp(&(b - theta).abs()))?;
                let is_on = (near - theta).abs() < SAME_WALL * self.tracer.pitch;
                is_on.then(|| (near, Cylindrical { x: place.x, r: place.y, theta: near }.point()))
            };
            for k in 1..=BEYOND_EDGE {
                let Some((on, point)) = next(theta, k) else { break };
                theta = on;
                points.push(point);
            }
            points.resize(BEYOND_EDGE, points.last().copied().unwrap_or(at[w]));
            points
        })
    }

    /// The mesh's normal where a circle meets it. A triangle without area is met only along its neighbours'
    /// edges; there the direction around the axis stands in.
    fn normal(&self, crossing: Crossing) -> DVec3 {
        let around = DVec3::new(0.0, -crossing.theta.cos(), -crossing.theta.sin());
        let into_gap = if crossing.enters { -around } else { around };
        self.tracer.slices.normal(crossing.triangle).try_normalize().unwrap_or(into_gap)
    }
}

/// Refuses blades whose edges jump from row to row, but for the rows beside fillets: what lies beyond a hole in one of them is
/// not seen as its wall.
fn check_edges(rows: &[Vec<Place>]) -> Result<(), BliskError> {
    let at = |place: &Place| DVec2::new(place.x, place.r);
    let inner = rows.get(1..rows.len().saturating_sub(1)).unwrap_or_default();
    for pair in inner.windows(2) {
        let ([first, .., last], [over_first, .., over_last]) = (&pair[0][..], &pair[1][..]) else { continue };
        let span = (last.along - first.along).max(over_last.along - over_first.along);
        // Where one edge jumps the other tells how far apart the rows are.
        let apart = at(first).distance(at(over_first)).min(at(last).distance(at(over_last)));
        let most = (EDGE_STEP * span).max(EDGE_SLOPE * apart);
        for (edge, over) in [(first, over_first), (last, over_last)] {
            if (over.along - edge.along).abs() > most {
                let DVec2 { x, y: r } = at(edge).midpoint(at(over));
                return Err(BliskError::LostWall { x, r });
            }
        }
    }
    Ok(())
}

/// Refuses walls without shroud between which the passage widens by a jump from row to row, above the fillets at the
/// hub: one of them is no blade up to its tip, as where a shroud covers a part of the passage.
pub(super) fn check_rows(low: &ChannelWall, high: &ChannelWall) -> Result<(), BliskError> {
    let jump = |u: usize| {
        let width = |v: usize| (high.cylindrical(u, v).theta - low.cylindrical(u, v).theta).rem_euclid(TAU);
        let jumps = |v: &usize| (width(*v) - width(v - 1)).abs() > JUMP * width(*v).max(width(v - 1));
        (low.nv / 3..low.nv).find(jumps).map(|v| low.cylindrical(u, v))
    };
    // Beside the edges, round which the walls turn, a few may.
    let jumps: Vec<Cylindrical> = (0..low.nu).filter_map(jump).collect();
    match jumps[..] {
        [at, ..] if jumps.len() as f64 > MOST_JUMPS * low.nu as f64 => Err(BliskError::LostWall { x: at.x, r: at.r }),
        _ => Ok(()),
    }
}

fn point(place: &Place, crossing: Crossing) -> DVec3 {
    Cylindrical { x: place.x, r: place.r, theta: crossing.theta }.point()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_4;

    use glam::DVec2;

    use super::super::tests::{drawn_wall, find, found, least_distance};
    use crate::options::BliskOptions;
    use crate::parametric::wheel::{MeridianCurve, ParametricWheel, Splitters};

    /// Splitters are nearest to the main blades ahead of them, where their passages have not yet begun.
    #[test]
    fn the_throat_beside_splitters_is_that_of_the_blades() {
        let part = ParametricWheel {
            blades: 14,
            splitters: vec![Splitters::over([0.5, 0.95])],
            ..ParametricWheel::impeller()
        };
        let mesh = part.mesh();
        // Main blades alone, which go on ahead of the splitters.
        let main = ParametricWheel { blades: 7, splitters: Vec::new(), ..part.clone() };
        let mut drawn = [
            least_distance(&drawn_wall(&main, 0, 0), &drawn_wall(&part, 0, 1)),
            least_distance(&drawn_wall(&part, 1, 0), &drawn_wall(&main, 0, 1)),
        ];
        let mut found = [0, 1].map(|channel| {
            let options = BliskOptions { channel, ..Default::default() };
            find(&mesh, &options).unwrap().throat.width_mm
        });
        drawn.sort_by(f64::total_cmp);
        found.sort_by(f64::total_cmp);
        assert!((0..2).all(|i| (found[i] / drawn[i] - 1.0).abs() < 0.005), "{found:?} of {drawn:?}");
    }

    /// Between blades along the radius the throat lies in the corners at the hub.
    #[test]
    fn the_throat_is_measured_up_to_hub_and_shroud() {
        let line = |r: f64| MeridianCurve::line(DVec2::new(0.0, r), DVec2::new(24.0, r));
        let part = ParametricWheel {
            blades: 24,
            hub: line(50.0),
            shroud: line(90.0),
            thickness_mm: 11.0,
            pieces: [480, 24, 24],
            ..ParametricWheel::nozzle_ring()
        };
        let drawn = least_distance(&drawn_wall(&part, 0, 0), &drawn_wall(&part, 0, 1));
        let throat = found(&part.mesh()).throat.width_mm;
        assert!((throat / drawn - 1.0).abs() < 0.005, "{throat} of {drawn}");
    }

    /// Beside the hub the gap from main blade to main blade is narrower than one and a half pitches.
    #[test]
    fn walls_end_at_thick_splitters() {
        let part = ParametricWheel {
            blades: 18,
            splitters: vec![Splitters::over([0.5, 0.95])],
            thickness_mm: 7.0,
            ..ParametricWheel::impeller()
        };
        let low = found(&part.mesh()).low;
        for v in 0..low.nv {
            let first = low.cylindrical(0, v);
            // Splitters begin half way along arcs about (-30, 70).
            let angle = (first.x + 30.0).atan2(70.0 - first.r);
            assert!((angle - FRAC_PI_4).abs() < 0.02, "row {v}: {first:?}");
        }
    }
}
