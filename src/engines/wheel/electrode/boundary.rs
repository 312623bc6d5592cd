//! The unreduced boundary: where the exact distance to the finished blisk equals the spark gap.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::walls::WallTable;
use super::{ElectrodeError, ElectrodeParams};
use crate::channel::{Channel, ChannelWall, Flow, Line, Station};
use geometry::exact::ExactMesh;
use geometry::frame::angle_near;
use geometry::inside::guarded_distance;
use task::Cancel;

/// A boundary point keeps at least the gap and at most this more (mm).
const TOLERANCE: f64 = 1e-4;
/// How much farther than free space allows a search may jump ahead; less than the thinnest edge and two gaps (mm).
const LEAP: f64 = 0.3;
/// How far above the hub and below the shroud the corners of a section are searched, so that the walk along the
/// end wall is free (mm).
const CORNER_LIFT: f64 = 1e-3;
/// How far from its wall the search for a corner begins (mm).
const CORNER_INSET: f64 = 0.3;
/// How much the radii of the channel may be wrong (mm).
const MERIDIAN_SLACK: f64 = 0.05;
/// Distance between planes before they are refined (mm).
const STEP: f64 = 0.5;
/// How deep a chord between two planes may cut into the gap before a plane is put between them (mm).
const CHORD_ERROR: f64 = 2e-3;
/// Planes are not put closer than this (mm).
const LEAST_STEP: f64 = 0.01;
/// Planes at most; where they do not suffice the deepest cuts are refined.
const MOST_PLANES: usize = 130;
/// Beside an edge that is flush with the end of the passage sections are traced at least up to here from it (mm).
const DEEPEST: f64 = 1.0;
/// Rounds of halving at most.
const MOST_ROUNDS: usize = 10;
/// Height of a row of faces on the walls (mm).
const ROW: f64 = 1.5;

/// A point on a section.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Spot {
    /// Height on the section's line (mm): the radius in an axial channel.
    pub height: f64,
    /// Angle (rad).
    pub theta: f64,
}

/// The unreduced boundary across the passage at one place along it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Section {
    /// The line across the passage there.
    pub line: Line,
    /// Low and high wall, from the hub outwards.
    pub walls: [Vec<Spot>; 2],
}

/// Finds sections.
pub(super) struct Boundary<'a> {
    pub(super) channel: &'a Channel,
    pub(super) blisk: &'a ExactMesh,
    pub(super) gap: f64,
    pub(super) radial_reduction: f64,
    /// Positions along the passage between which sections are traced on the blisk (mm); infinite unless the blades end
    /// bluntly or flush with the passage. Beside such an end there is no edge to reach round, and a circle leaves the
    /// blisk between the facets of the rim; there sections go straight on.
    traced: [f64; 2],
    ends: [BladeEnd; 2],
    tables: [WallTable; 2],
    rows: usize,
}

/// The sense of theta that leads out of the channel through each wall.
const OUTWARDS: [f64; 2] = [-1.0, 1.0];

impl<'a> Boundary<'a> {
    /// Of a channel, `room` (mm) farther from the blisk than the spark gap.
    pub(super) fn new(
        channel: &'a Channel,
        blisk: &'a ExactMesh,
        params: &ElectrodeParams,
        room: f64,
    ) -> Result<Self, ElectrodeError> {
        let tables = WallTable::of(channel)
            .ok_or(ElectrodeError::BadChannel("the walls are not grids of 2 x 2 points or more"))?;
        if channel.meridian.len() < 2 {
            return Err(ElectrodeError::BadChannel("its hub and shroud radii are missing"));
        }
        let height = channel.meridian.iter().map(Station::height).fold(0.0, f64::max);
        let mut boundary = Self {
            channel,
            blisk,
            gap: params.spark_gap_mm + room,
            radial_reduction: params.radial_reduction_mm,
            traced: [f64::NEG_INFINITY, f64::INFINITY],
            ends: blade_ends(channel, params),
            tables,
            rows: (height / ROW).ceil().clamp(4.0, 40.0) as usize,
        };
        for end in (0..2).filter(|&end| boundary.ends[end] != BladeEnd::Edge) {
            boundary.traced[end] = boundary.last_traced(end);
        }
        Ok(boundary)
    }

    /// Next to the blunt or flush end `end` of the blades, the position nearest to it where metal bounds both walls all the way
    /// from hub to shroud (mm).
    fn last_traced(&self, end: usize) -> f64 {
        let tip = self.channel.span_along()[end];
        let inwards = [1.0, -1.0][end];
        let is_bounded = |along: f64| {
            let line = self.channel.line_at(along);
            let is_held = |spot: &Spot| self.clearance(&line, *spot) <= 2.0 * TOLERANCE;
            self.section(line).is_ok_and(|section| section.walls.iter().flatten().all(is_held))
        };
        let depths = std::iter::successors(Some(self.gap), |depth| Some(1.5 * depth));
        let mut places = depths.take_while(|depth| *depth <= DEEPEST).map(|depth| tip + inwards * depth);
        places.find(|&along| is_bounded(along)).unwrap_or(tip + inwards * DEEPEST)
    }

    /// Distance to the blisk less the gap (mm).
    pub(super) fn clearance(&self, line: &Line, p: Spot) -> f64 {
        guarded_distance(self.blisk, line.point(p.height, p.theta)) - self.gap
    }

    /// Sections over `extent`, in order along the passage: at `planes`, at equal steps, and wherever the chord between
    /// two neighbours would cut into the gap.
    pub(super) fn sections(
        &self,
        extent: [f64; 2],
        planes: &[f64],
        cancel: &Cancel,
    ) -> Result<Vec<Section>, ElectrodeError> {
        let steps = ((extent[1] - extent[0]) / STEP).ceil().clamp(2.0, MOST_PLANES as f64 / 2.0);
        let mut places: Vec<f64> = planes.to_vec();
        // The ends as they are, to the last bit.
        places.extend((1..steps as usize).map(|i| extent[0] + (extent[1] - extent[0]) * i as f64 / steps));
        places.extend(extent);
        // Beyond what is traced a section goes straight on: the last one is enough.
        let [first, last] = self.traced;
        places.retain(|at| (first..=last).contains(at) || extent.contains(at) || planes.contains(at));
        let mut kept: Vec<f64> = self.traced.into_iter().filter(|at| (extent[0]..=extent[1]).contains(at)).collect();
        places.extend(&kept);
        kept.extend(planes.iter().chain(&extent));
        places.sort_by(f64::total_cmp);
        // Where a step falls next to a plane that must be there, the plane is enough.
        places.dedup_by(|b, a| *b - *a < 1e-9);
        let is_beside_kept = |at: f64| kept.iter().any(|p| *p != at && (p - at).abs() < 0.2 * STEP);
        places.retain(|&at| kept.contains(&at) || !is_beside_kept(at));
        let mut sections = self.solve(&places, extent, cancel)?;
        for _ in 0..MOST_ROUNDS {
            let split = self.splits(&sections, extent, cancel)?;
            if split.is_empty() {
                break;
            }
            sections.extend(self.solve(&split, extent, cancel)?);
            sections.sort_by(|a, b| a.line.along.total_cmp(&b.line.along));
        }
        Ok(sections)
    }

    /// The sections at `places`; those outside of `extent` are of the way out of the blisk.
    fn solve(&self, places: &[f64], extent: [f64; 2], cancel: &Cancel) -> Result<Vec<Section>, ElectrodeError> {
        let solved: Vec<_> = places
            .par_iter()
            .map(|&along| {
                cancel.check()?;
                let is_way_out = along < extent[0] || along > extent[1];
                self.section_at(along).map_err(|error| match error {
                    ElectrodeError::InsideBlisk { x, r } | ElectrodeError::NoPassage { x, r, .. } if is_way_out => {
                        ElectrodeError::WayOut { x, r }
                    }
                    ElectrodeError::InsideBlisk { .. } | ElectrodeError::NoPassage { .. } => {
                        self.overrun(along).unwrap_or(error)
                    }
                    other => other,
                })
            })
            .collect();
        solved.into_iter().collect()
    }

    /// How far straight on beyond the edges of the blades the channel's middle is free, where it is not at `along`; none where
    /// that lies between the blades.
    fn overrun(&self, along: f64) -> Option<ElectrodeError> {
        const ROUNDS: usize = 10;
        let [from, to] = self.channel.span_along();
        let edge = if along < from { from } else { to };
        let outside = along - edge;
        if (from..=to).contains(&along) || self.section_at(edge).is_err() {
            return None;
        }
        let (mut free, mut met) = (0.0, 1.0);
        for _ in 0..ROUNDS {
            let middle = 0.5 * (free + met);
            match self.section_at(edge + middle * outside) {
                Ok(_) => free = middle,
                Err(_) => met = middle,
            }
        }
        let line = self.channel.line_at(edge + met * outside);
        let DVec2 { x, y: r } = line.place(0.5 * (line.ends[0] + line.ends[1]));
        // What is said holds as it is said, with two decimals.
        Some(ElectrodeError::Overrun { x, r, beyond: (100.0 * free * outside.abs()).floor() / 100.0 })
    }

    /// The middles of the intervals whose chords cut too deep: the deepest, and each time only half as many as may
    /// still be added, so that the deepest cuts are refined first.
    fn splits(&self, sections: &[Section], extent: [f64; 2], cancel: &Cancel) -> Result<Vec<f64>, ElectrodeError> {
        let cut = |i: usize| {
            let (a, b) = (&sections[i], &sections[i + 1]);
            let [from, to] = [a, b].map(|section| section.line.along);
            let [first, last] = self.traced;
            let is_inside = from > extent[0].max(first) - 1e-9 && to < extent[1].min(last) + 1e-9;
            let may_split = is_inside && to - from >= 2.0 * LEAST_STEP;
            let depth = if may_split { self.chord_depth(a, b) } else { 0.0 };
            (depth > CHORD_ERROR).then_some((depth, 0.5 * (from + to)))
        };
        let cuts: Vec<_> =
            (0..sections.len().saturating_sub(1)).into_par_iter().map(|i| cancel.check().map(|()| cut(i))).collect();
        let mut cuts: Vec<_> = cuts.into_iter().collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect();
        cuts.sort_by(|a, b| b.0.total_cmp(&a.0));
        cuts.truncate(MOST_PLANES.saturating_sub(sections.len()).div_ceil(2));
        Ok(cuts.into_iter().map(|(_, along)| along).collect())
    }

    /// How deep the chords between two sections cut into the gap at their middles, away from the corners (mm).
    fn chord_depth(&self, a: &Section, b: &Section) -> f64 {
        let chords = (0..2).flat_map(|w| a.walls[w].iter().zip(&b.walls[w]).skip(1).take(self.rows - 1));
        let middles = chords.map(|(p, q)| (a.line.point(p.height, p.theta) + b.line.point(q.height, q.theta)) / 2.0);
        middles.map(|middle| self.gap - guarded_distance(self.blisk, middle)).fold(0.0, f64::max)
    }

    /// The boundary across the passage at a position along it.
    fn section_at(&self, along: f64) -> Result<Section, ElectrodeError> {
        let last = along.clamp(self.traced[0], self.traced[1]);
        let near = self.section(self.channel.line_at(last))?;
        if last == along {
            return Ok(near);
        }
        let further = self.section(self.channel.line_at(2.0 * last - along))?;
        let line = self.channel.line_at(along);
        let go_on = |(a, b): (&Spot, &Spot)| Spot { height: 2.0 * a.height - b.height, theta: 2.0 * a.theta - b.theta };
        let mut walls = [0, 1].map(|w| near.walls[w].iter().zip(&further.walls[w]).map(go_on).collect::<Vec<_>>());
        if self.ends[usize::from(along > last)] == BladeEnd::Blunt {
            // Hub and shroud go on beside the blades.
            let [hub, shroud] = line.ends;
            let height = 0.5 * (hub + shroud);
            let middle = 0.5 * (walls[0][self.rows / 2].theta + walls[1][self.rows / 2].theta);
            let (bottom, top) = self.height(&line, Spot { height, theta: middle })?;
            for wall in &mut walls {
                let reduced = top - bottom - self.radial_reduction;
                wall.iter_mut()
                    .enumerate()
                    .for_each(|(v, p)| p.height = bottom + reduced * v as f64 / self.rows as f64);
            }
        }
        Ok(Section { line, walls })
    }

    /// The boundary across the passage on `line`, traced on the blisk.
    fn section(&self, line: Line) -> Result<Section, ElectrodeError> {
        let [hub, shroud] = line.ends;
        let height = 0.5 * (hub + shroud);
        let middle = Spot { height, theta: self.middle(&line, height) };
        let (bottom, top) = self.height(&line, middle)?;
        let (available, taken) = (top - bottom, self.radial_reduction);
        if available < taken + 0.2 {
            return Err(ElectrodeError::NoHeight { x: line.place(height).x, available, taken, of_shank: false });
        }
        let rows = self.rows;
        let height = |v: usize| bottom + (available - taken) * v as f64 / rows as f64;
        let wall = |w: usize| -> Result<Vec<Spot>, ElectrodeError> {
            let mut points = vec![Spot { height: 0.0, theta: 0.0 }; rows + 1];
            for (v, point) in points.iter_mut().enumerate().take(rows).skip(1) {
                *point = self.wall_point(w, &line, height(v))?;
            }
            points[0] = self.corner(w, &line, points[1], -1.0);
            points[rows] = if self.channel.shrouded {
                self.corner(w, &line, points[rows - 1], 1.0)
            } else {
                self.wall_point(w, &line, height(rows))?
            };
            Ok(points)
        };
        Ok(Section { line, walls: [wall(0)?, wall(1)?] })
    }

    /// Heights at which the hub's gap and the shroud's are met below and above `middle`, which must be free.
    fn height(&self, line: &Line, middle: Spot) -> Result<(f64, f64), ElectrodeError> {
        let clearance = self.clearance(line, middle);
        if clearance.is_nan() || clearance < 0.0 {
            return Err(self.no_passage(line.place(middle.height), clearance));
        }
        let top = if self.channel.shrouded { self.ascend(line, middle) } else { line.ends[1] };
        Ok((self.descend(line, middle), top))
    }

    /// Reason why the channel's middle is not free.
    fn no_passage(&self, place: DVec2, clearance: f64) -> ElectrodeError {
        let (DVec2 { x, y: r }, clearance, gap) = (place, clearance + self.gap, self.gap);
        if clearance >= 0.0 {
            ElectrodeError::NoPassage { x, r, clearance, gap }
        } else {
            ElectrodeError::InsideBlisk { x, r }
        }
    }

    /// Angle of the channel's middle.
    fn middle(&self, line: &Line, height: f64) -> f64 {
        0.5 * (self.tables[0].at(line.along, height).theta + self.tables[1].at(line.along, height).theta)
    }

    /// The height down to which the point may go before it meets the hub's gap.
    pub(super) fn descend(&self, line: &Line, from: Spot) -> f64 {
        let least = line.ends[0] + self.gap - MERIDIAN_SLACK;
        let below = |s: f64| self.clearance(line, Spot { height: from.height - s, ..from });
        from.height - farthest(below, from.height - least)
    }

    /// The height up to which the point may go before it meets the shroud's gap.
    pub(super) fn ascend(&self, line: &Line, from: Spot) -> f64 {
        let most = line.ends[1] - self.gap + MERIDIAN_SLACK;
        let above = |s: f64| self.clearance(line, Spot { height: from.height + s, ..from });
        from.height + farthest(above, most - from.height)
    }

    /// The point at a height where the walk from the channel's middle to wall `w` meets the gap.
    fn wall_point(&self, w: usize, line: &Line, height: f64) -> Result<Spot, ElectrodeError> {
        let place = self.tables[w].at(line.along, height);
        let middle = self.middle(line, height);
        let clearance_at = |theta| self.clearance(line, Spot { height, theta });
        // Start next to the wall if that is free, else in the middle.
        let close = place.theta - OUTWARDS[w] * (0.3 + 1.5 * self.gap) / line.radius(height);
        let is_short = (close - middle) * OUTWARDS[w] <= 0.0;
        let start = if is_short || clearance_at(close) < 0.0 { middle } else { close };
        let clearance = clearance_at(start);
        if clearance < 0.0 {
            return Err(self.no_passage(line.place(height), clearance));
        }
        Ok(self.outwards(w, line, Spot { height, theta: start }))
    }

    /// From a free point along theta towards wall `w`, past an edge not beyond the angle of its tip.
    fn outwards(&self, w: usize, line: &Line, from: Spot) -> Spot {
        let (place, radius) = (self.tables[w].at(line.along, from.height), line.radius(from.height));
        let slack = if place.past_edge { 0.0 } else { 0.5 };
        let reach = (place.theta - from.theta) * OUTWARDS[w] * radius + slack;
        let at = |s: f64| Spot { theta: from.theta + OUTWARDS[w] * s / radius, ..from };
        at(farthest(|s| self.clearance(line, at(s)), reach))
    }

    /// The corner between wall `w` and the hub (`up = -1`) or shroud (`up = 1`), next to the wall point `beside`.
    ///
    /// The search runs along the end wall just inside its gap, and goes over facets of the end wall that rise into it.
    fn corner(&self, w: usize, line: &Line, beside: Spot, up: f64) -> Spot {
        let radius = line.radius(beside.height);
        let middle = self.middle(line, beside.height);
        // On the way to the end wall the blade may lean into the passage.
        let end = line.ends[usize::from(up > 0.0)];
        let lean = (beside.theta - self.tables[w].at(line.along, end).theta) * OUTWARDS[w] * radius;
        let inset = if lean > CORNER_INSET { CORNER_INSET + lean } else { CORNER_INSET };
        let inset = inset.min(0.5 * ((beside.theta - middle) * OUTWARDS[w] * radius).abs());
        let start = Spot { theta: beside.theta - OUTWARDS[w] * inset / radius, ..beside };
        let (end_wall, drawn_in) = match up {
            up if up < 0.0 => (self.descend(line, start), 0.0),
            _ => (self.ascend(line, start), self.radial_reduction),
        };
        let mut lift = CORNER_LIFT;
        let mut corner = Spot { height: end_wall - up * (lift + drawn_in), ..start };
        if self.clearance(line, corner) < 0.0 {
            return Spot { height: end_wall - up * drawn_in, ..start };
        }
        loop {
            corner = self.outwards(w, line, corner);
            let is_stopped = self.clearance(line, corner) <= TOLERANCE;
            let lifted = Spot { height: corner.height - up * lift, ..corner };
            if !is_stopped || lift > 0.1 || !self.is_across(line, corner) || self.clearance(line, lifted) < 0.0 {
                return corner;
            }
            corner = lifted;
            lift *= 2.0;
        }
    }

    /// Whether what stops a point lies below or above it rather than beside it.
    fn is_across(&self, line: &Line, p: Spot) -> bool {
        let point = line.point(p.height, p.theta);
        let [up, around] = components(point, line.up, point - self.blisk.nearest(point).point);
        up.abs() > around.abs()
    }
}

/// How the blades of a channel end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum BladeEnd {
    /// In an edge that the boundary reaches round, or at the face of an axial blisk.
    Edge,
    /// In a plane or a cylinder across the passage, within it.
    Blunt,
    /// Flush with the end of the passage all the way from hub to shroud, to within the gap; not in an axial channel.
    Flush,
}

/// How the blades end at the first and at the last end of the passage.
pub(super) fn blade_ends(channel: &Channel, params: &ElectrodeParams) -> [BladeEnd; 2] {
    /// A blunt end is at least so wide across the passage on one wall (mm), and so much wider than it is deep; thick round
    /// noses are not.
    const WIDTH: f64 = 0.8;
    const SLENDER: f64 = 20.0;
    let along = |wall: &ChannelWall, u: usize, v: usize| {
        let place = wall.cylindrical(u, v);
        channel.along_and_height(DVec2::new(place.x, place.r))[0]
    };
    let edges = || [&channel.low, &channel.high].into_iter().flat_map(|wall| (0..wall.nv).map(move |v| (wall, v)));
    let at = |wall: &ChannelWall, end: usize, k: usize| if end == 0 { k } else { wall.nu - 1 - k };
    let is_flush = |end: usize| {
        let ends = channel.ends_along()[end];
        edges().all(|(wall, v)| (along(wall, at(wall, end, 0), v) - ends).abs() < params.spark_gap_mm)
    };
    // Some points from the end a wall has come far across the passage, but hardly along it.
    let is_blunt = |end: usize| {
        edges().any(|(wall, v)| {
            let tip = wall.cylindrical(at(wall, end, 0), v);
            (1..wall.nu / 4).any(|k| {
                let place = wall.cylindrical(at(wall, end, k), v);
                let across = (angle_near(place.theta, tip.theta) - tip.theta).abs() * tip.r;
                let depth = (along(wall, at(wall, end, k), v) - along(wall, at(wall, end, 0), v)).abs();
                across > WIDTH && across > SLENDER * depth
            })
        })
    };
    [0, 1].map(|end| match is_flush(end) {
        true if channel.flow == Flow::Axial => BladeEnd::Edge,
        true => BladeEnd::Flush,
        false if is_blunt(end) => BladeEnd::Blunt,
        false => BladeEnd::Edge,
    })
}

/// Components of a direction at `point` along `up` (x, r) in the meridional plane there, and along theta.
pub(super) fn components(point: DVec3, up: DVec2, direction: DVec3) -> [f64; 2] {
    let outward = DVec3::new(0.0, point.y, point.z).normalize_or(DVec3::Z);
    [direction.dot(DVec3::X * up.x + outward * up.y), direction.dot(DVec3::X.cross(outward))]
}

/// How far one may walk from 0 towards `reach` before `clearance`, which falls by at most 1 per mm and is not
/// negative at 0, gets negative: a place where it lies between 0 and [`TOLERANCE`], or `reach` if there is none.
fn farthest(clearance: impl Fn(f64) -> f64, reach: f64) -> f64 {
    if reach <= 0.0 {
        return 0.0;
    }
    let (mut s, mut free, mut slope) = (0.0, clearance(0.0), 1.0);
    for _ in 0..500 {
        if free <= TOLERANCE {
            return s;
        }
        // Free space allows a step of `free`; the fall seen so far suggests a longer one.
        let next = (s + (free / slope).min(free.max(LEAP))).min(reach);
        let there = clearance(next);
        if there < 0.0 {
            return crossing(clearance, (s, free), (next, there));
        }
        slope = ((free - there) / (next - s)).clamp(0.02, 1.0);
        (s, free) = (next, there);
        if s >= reach {
            return reach;
        }
    }
    s
}

/// A place between `free` (clearance >= 0) and `blocked` (< 0) where the clearance is between 0 and
/// [`TOLERANCE`], by the Illinois method.
fn crossing(clearance: impl Fn(f64) -> f64, mut free: (f64, f64), mut blocked: (f64, f64)) -> f64 {
    let (mut weight_free, mut weight_blocked) = (1.0, 1.0);
    for _ in 0..100 {
        if free.1 <= TOLERANCE || (blocked.0 - free.0).abs() < 1e-8 {
            break;
        }
        // Aim at the middle of the tolerance.
        let (a, b) = ((free.1 - 0.5 * TOLERANCE) * weight_free, (blocked.1 - 0.5 * TOLERANCE) * weight_blocked);
        let next = free.0 + (blocked.0 - free.0) * (a / (a - b)).clamp(0.01, 0.99);
        let there = clearance(next);
        if there >= 0.0 {
            free = (next, there);
            (weight_free, weight_blocked) = (1.0, weight_blocked * 0.5);
        } else {
            blocked = (next, there);
            (weight_free, weight_blocked) = (weight_free * 0.5, 1.0);
        }
    }
    free.0
}
