//! From unreduced sections to the closed rings of an electrode: turned walls, drawn-in shroud side, insets.

use glam::{DMat3, DVec2, DVec3};
use rayon::prelude::*;

use super::boundary::{Boundary, Section, Spot, components};

use super::{ElectrodeError, ElectrodeFace};
use crate::channel::{Flow, Line};
use geometry::inside::guarded_distance;
use task::Cancel;

/// Metal that must be left between the walls (mm).
const LEAST_METAL: f64 = 0.2;
/// End walls that rise by more than this where the electrode turns back to a wall do so in a fillet; facets of a round
/// hub, which the copying motion rises over, are lower (mm).
const FILLET: f64 = 0.05;
/// Width of a face on the hub and shroud sides (mm).
const COLUMN: f64 = 0.75;
/// Where a place falls short of the gap its vertices give way by this more (mm).
const SURPLUS: f64 = 5e-5;
/// Edges whose middle has more than this to spare have it everywhere (mm).
const SPARE: f64 = 5e-3;
/// Steps of the search for the place of an edge that is nearest to the blisk.
const EDGE_STEPS: usize = 12;
/// Places sampled inside a face.
const IN_FACE: [[f64; 3]; 4] =
    [[0.5, 0.25, 0.25], [0.25, 0.5, 0.25], [0.25, 0.25, 0.5], [1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0]];
/// Rounds of giving way at most.
const MOST_ROUNDS: usize = 40;
/// How far a vertex gives way at most, along the line across the passage and along theta (mm): what is not free by then
/// does not get free in this way.
const MOST_WAY: f64 = 1.0;
/// Both parts of a direction across the passage are less than this where it is along the passage.
const ALONG: f64 = 0.5;

/// How many intervals a ring has on its four sides.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Layout {
    /// On each wall.
    pub rows: usize,
    /// On the hub side and on the shroud side.
    pub columns: usize,
}

/// A closed ring across the passage: the hub side from the low to the high wall, up the high wall, the shroud
/// side back, down the low wall.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Ring {
    /// The line across the passage there.
    pub line: Line,
    /// Points of the ring.
    pub points: Vec<Spot>,
}

impl Ring {
    /// Point `k` in W.
    pub(super) fn point(&self, k: usize) -> DVec3 {
        self.line.point(self.points[k].height, self.points[k].theta)
    }
}

impl Layout {
    /// Points of a ring.
    pub(super) fn len(self) -> usize {
        2 * (self.rows + self.columns)
    }

    /// Where the four sides begin, and where the last one ends: hub side, high wall, shroud side, low wall.
    pub(super) fn corners(self) -> [usize; 5] {
        [0, self.columns, self.columns + self.rows, 2 * self.columns + self.rows, self.len()]
    }

    /// Where the point in column `j` of the hub side stands.
    pub(super) fn hub(self, j: usize) -> usize {
        j
    }

    /// Where the point in row `v` of the high wall stands.
    pub(super) fn high(self, v: usize) -> usize {
        self.columns + v
    }

    /// Where the point in column `j`, counted from the low wall, of the shroud side stands.
    pub(super) fn shroud(self, j: usize) -> usize {
        2 * self.columns + self.rows - j
    }

    /// Where the point in row `v` of the low wall stands.
    pub(super) fn low(self, v: usize) -> usize {
        (self.len() - v) % self.len()
    }

    /// Face between points `k` and `k + 1` of two burning rings.
    pub(super) fn face(self, k: usize) -> ElectrodeFace {
        let (n, m) = (self.columns, self.rows);
        match k {
            k if k < n => ElectrodeFace::HubSide,
            k if k < n + m => ElectrodeFace::HighWall,
            k if k < 2 * n + m => ElectrodeFace::ShroudSide,
            _ => ElectrodeFace::LowWall,
        }
    }
}

/// How much smaller than the channel's boundary a ring is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Reduction {
    /// Angles by which the low and the high wall are turned inwards (rad).
    pub turns: [f64; 2],
    /// Further distance all round (mm).
    pub inset: f64,
}

/// Makes rings of sections.
pub(super) struct Finisher<'a> {
    pub(super) boundary: &'a Boundary<'a>,
    pub(super) layout: Layout,
}

impl<'a> Finisher<'a> {
    pub(super) fn new(boundary: &'a Boundary<'a>, sections: &[Section]) -> Self {
        let width = |s: &Section| {
            let pairs = s.walls[0].iter().zip(&s.walls[1]);
            pairs.map(|(low, high)| (high.theta - low.theta) * s.line.radius(high.height)).fold(0.0, f64::max)
        };
        let widest = sections.iter().map(width).fold(0.0, f64::max);
        let rows = sections.first().map_or(1, |s| s.walls[0].len() - 1);
        let columns = (widest / COLUMN).ceil().clamp(4.0, 60.0) as usize;
        Self { boundary, layout: Layout { rows, columns } }
    }

    /// The rings of `sections`, in their order.
    pub(super) fn rings(
        &self,
        sections: &[&Section],
        reduction: Reduction,
        cancel: &Cancel,
    ) -> Result<Vec<Ring>, ElectrodeError> {
        let rings: Vec<_> = sections
            .par_iter()
            .map(|section| {
                cancel.check()?;
                self.ring(section, reduction)
            })
            .collect();
        let (mut rings, fillets): (Vec<Ring>, Vec<bool>) =
            rings.into_iter().collect::<Result<Vec<_>, _>>()?.into_iter().unzip();
        // Without fillets nothing is in the way of turning back but facets.
        let turns = if fillets.contains(&true) { reduction.turns } else { [0.0; 2] };
        self.relax(&mut rings, turns, cancel)?;
        Ok(rings)
    }

    /// The ring of a section, and whether it gives way to fillets.
    fn ring(&self, section: &Section, reduction: Reduction) -> Result<(Ring, bool), ElectrodeError> {
        let Layout { rows, columns } = self.layout;
        let line = section.line;
        let walls = self.reduced_walls(section, reduction)?;
        let mut points = vec![Spot { height: 0.0, theta: 0.0 }; self.layout.len()];
        for v in 1..rows {
            points[self.layout.low(v)] = walls[0][v];
            points[self.layout.high(v)] = walls[1][v];
        }
        let across = |v: usize, j: usize| {
            let (a, b, t) = (walls[0][v], walls[1][v], j as f64 / columns as f64);
            Spot { height: a.height + t * (b.height - a.height), theta: a.theta + t * (b.theta - a.theta) }
        };
        let mut has_fillets = false;
        for j in 0..=columns {
            let is_corner = j == 0 || j == columns;
            let (hub, is_raised) = self.on_hub_side(&line, across(0, j), reduction.turns, is_corner);
            let (shroud, is_lowered) = self.on_shroud_side(&line, across(rows, j), reduction.turns, is_corner);
            (points[self.layout.hub(j)], points[self.layout.shroud(j)]) = (hub, shroud);
            has_fillets |= is_raised || is_lowered;
        }
        let mut ring = Ring { line, points };
        if reduction.inset > 0.0 {
            self.draw_in(&mut ring, reduction.inset)?;
        }
        Ok((ring, has_fillets))
    }

    /// Both walls turned inwards, if that leaves metal.
    fn reduced_walls(&self, section: &Section, reduction: Reduction) -> Result<[Vec<Spot>; 2], ElectrodeError> {
        let turned = |w: usize| -> Vec<Spot> {
            let turn = |p: &Spot| reduction.turns[w] + reduction.inset / section.line.radius(p.height);
            let sign = if w == 0 { 1.0 } else { -1.0 };
            section.walls[w].iter().map(|p| Spot { theta: p.theta + sign * turn(p), ..*p }).collect()
        };
        let walls = [turned(0), turned(1)];
        for v in 0..walls[0].len() {
            let DVec2 { x, y: r } = section.line.place(walls[0][v].height);
            let width = |walls: &[Vec<Spot>; 2]| (walls[1][v].theta - walls[0][v].theta) * r;
            let (available, left) = (width(&section.walls), width(&walls));
            if left.is_nan() || left < LEAST_METAL {
                return Err(ElectrodeError::NoMetal { x, r, available, taken: available - left });
            }
        }
        Ok(walls)
    }

    /// The point on the hub's gap at the angle of `guess`, where the walls are turned inwards by `turns`; above what a
    /// fillet leaves it when they are turned back, and whether it does.
    fn on_hub_side(&self, line: &Line, guess: Spot, turns: [f64; 2], is_corner: bool) -> (Spot, bool) {
        let height = |guess| self.boundary.descend(line, self.freed(line, guess, 1.0));
        let here = height(guess);
        let back = turned_back(guess, turns).map(height).into_iter().fold(here, f64::max);
        let is_raised = !is_corner && back > here + FILLET;
        (Spot { height: if is_raised { back } else { here }, ..guess }, is_raised)
    }

    /// The point on the drawn-in shroud's gap at the angle of `guess`, below what a fillet leaves it, and whether one
    /// does; without a shroud, `guess`.
    fn on_shroud_side(&self, line: &Line, guess: Spot, turns: [f64; 2], is_corner: bool) -> (Spot, bool) {
        let free = self.freed(line, guess, -1.0);
        if is_corner || !self.boundary.channel.shrouded {
            return (free, false);
        }
        let height = |free| self.boundary.ascend(line, free) - self.boundary.radial_reduction;
        let here = height(free);
        let back = turned_back(guess, turns).map(|spot| height(self.freed(line, spot, -1.0)));
        let back = back.into_iter().fold(here, f64::min);
        let is_lowered = back < here - FILLET;
        let height = if is_lowered { back } else { here };
        // Where a leaning wall stops the way up, the line between the corners is right.
        let spot = if height < guess.height - 0.05 { free } else { Spot { height, ..guess } };
        (spot, is_lowered)
    }

    /// `p` moved along the line in the sense of `up` until it keeps the gap; `p` itself where that does not help, as
    /// beside a wall.
    fn freed(&self, line: &Line, p: Spot, up: f64) -> Spot {
        let mut free = p;
        while (free.height - p.height).abs() <= MOST_WAY {
            let clearance = self.boundary.clearance(line, free);
            if clearance.is_nan() || clearance >= 0.0 {
                return free;
            }
            free.height += up * (SURPLUS - clearance);
        }
        p
    }

    /// Draws the hub and shroud sides of `ring` in by `inset`, and the rows between with them.
    fn draw_in(&self, ring: &mut Ring, inset: f64) -> Result<(), ElectrodeError> {
        let Layout { rows, columns } = self.layout;
        for (low, high) in (0..=columns).map(|j| (self.layout.hub(j), self.layout.shroud(j))) {
            let available = ring.points[high].height - ring.points[low].height;
            if available - 2.0 * inset < LEAST_METAL {
                return Err(ElectrodeError::NoHeight {
                    x: ring.line.place(ring.points[low].height).x,
                    available,
                    taken: 2.0 * inset,
                    of_shank: true,
                });
            }
        }
        let corners = |points: &[Spot], on: &dyn Fn(usize) -> usize| [0, columns].map(|j| points[on(j)].theta);
        let old = ring.points.clone();
        for wall in [Layout::low, Layout::high] {
            let index = |v| wall(self.layout, v);
            let (from, to) = (old[index(0)].height, old[index(rows)].height);
            for v in 0..=rows {
                let t = (old[index(v)].height - from) / (to - from);
                let point = &mut ring.points[index(v)];
                point.height += inset * (1.0 - 2.0 * t);
                // Blades of other passages lean so far that a point must stay on its wall.
                if self.boundary.channel.flow != Flow::Axial {
                    point.theta = theta_at((0..=rows).map(|v| old[index(v)]), point.height);
                }
            }
        }
        for side in [Layout::hub, Layout::shroud] {
            let on = |j: usize| side(self.layout, j);
            let ([a, b], [c, d]) = (corners(&old, &on), corners(&ring.points, &on));
            for j in 1..columns {
                ring.points[on(j)].theta = c + (ring.points[on(j)].theta - a) * (d - c) / (b - a);
            }
        }
        for j in 1..columns {
            ring.points[self.layout.hub(j)].height += inset;
            ring.points[self.layout.shroud(j)].height -= inset;
        }
        Ok(())
    }

    /// How the ring points `around` a place give way when its normal has the given parts: the axis (0 the line
    /// across the passage, 1 theta), the sense, and the part of the normal along it. Walls give way into the metal along
    /// theta unless the normal is nearly along the line, hub and shroud sides along the line unless it is nearly along
    /// theta or leads out of the electrode, as that of a leaning wall does.
    fn way_in(&self, around: &[(usize, usize)], normal: [f64; 2]) -> (usize, f64, f64) {
        let Layout { rows, columns } = self.layout;
        let all = |on: &dyn Fn(usize) -> bool| around.iter().all(|&(_, k)| on(k));
        let low = all(&|k| k == 0 || k >= 2 * columns + rows);
        let high = all(&|k| (columns..=columns + rows).contains(&k));
        let hub = all(&|k| k <= columns);
        let shroud = all(&|k| (columns + rows..=2 * columns + rows).contains(&k));
        let sense = |inwards: bool, outwards: bool, part: f64| match (inwards, outwards) {
            (true, false) => 1.0,
            (false, true) => -1.0,
            _ => part.signum(),
        };
        let up_from = match (low || high, hub || shroud) {
            (true, false) => 0.8,
            (false, true) => 0.2,
            _ => std::f64::consts::FRAC_1_SQRT_2,
        };
        let [up, along_theta] = normal;
        let is_outwards = (hub && !shroud && up < 0.0) || (shroud && !hub && up > 0.0);
        if up.abs() > up_from && !is_outwards {
            (0, sense(hub, shroud, up), up.abs())
        } else {
            (1, sense(low, high, along_theta), along_theta.abs())
        }
    }

    /// Moves vertices inwards until edges and faces between neighbouring rings keep the gap too.
    ///
    /// A chord between two points of the boundary cuts into the gap where the blisk is convex. Each place that
    /// falls short pushes the vertices around it along theta or the line; so does each place that falls short, in a
    /// fillet, where the walls, which are turned inwards by `turns`, are turned back.
    fn relax(&self, rings: &mut [Ring], [low, high]: [f64; 2], cancel: &Cancel) -> Result<(), ElectrodeError> {
        let n = self.layout.len();
        let mut is_moved = vec![true; rings.len() * n];
        let starts: Vec<Vec<Spot>> = rings.iter().map(|ring| ring.points.clone()).collect();
        let poses: Vec<Turned> = [-low, high].into_iter().filter(|t| *t != 0.0).map(Turned::by).collect();
        for _ in 0..MOST_ROUNDS {
            let pushes: Vec<_> = (0..rings.len())
                .into_par_iter()
                .map(|i| {
                    cancel.check()?;
                    Ok::<_, ElectrodeError>(self.pushes(rings, i, &poses, &|(ring, k)| is_moved[ring * n + k]))
                })
                .collect();
            is_moved.fill(false);
            let mut moves = vec![[0.0f64; 2]; rings.len() * n];
            for push in pushes.into_iter().collect::<Result<Vec<_>, _>>()?.into_iter().flatten() {
                let most = &mut moves[push.ring * n + push.point][push.axis];
                if push.by.abs() > most.abs() {
                    *most = push.by;
                }
            }
            for (i, &[up, around]) in moves.iter().enumerate().filter(|(_, m)| **m != [0.0; 2]) {
                let (ring, point) = (i / n, i % n);
                let Ring { line, points } = &mut rings[ring];
                let (p, start) = (&mut points[point], starts[ring][point]);
                let radius = line.radius(start.height);
                let turn = MOST_WAY / radius;
                let height = (p.height + up).clamp(start.height - MOST_WAY, start.height + MOST_WAY);
                let theta = (p.theta + around / line.radius(p.height)).clamp(start.theta - turn, start.theta + turn);
                *p = Spot { height, theta };
                is_moved[i] = true;
            }
            if !is_moved.contains(&true) {
                break;
            }
        }
        Ok(())
    }

    /// Corrections for the points on ring `i` and between it and the next, where any ring point around them `is_moved`:
    /// vertices, the nearest point of each edge, and some points inside each face.
    fn pushes(
        &self,
        rings: &[Ring],
        i: usize,
        turned: &[Turned],
        is_moved: &dyn Fn((usize, usize)) -> bool,
    ) -> Vec<Push> {
        let n = self.layout.len();
        let mut pushes = Vec::new();
        let at = |(ring, k): (usize, usize)| rings[ring].point(k);
        let mut face = |corners: [(usize, usize); 3]| {
            if !corners.into_iter().any(is_moved) {
                return;
            }
            let [a, b, c] = corners.map(at);
            for [u, v, w] in IN_FACE {
                let place = a * u + b * v + c * w;
                self.push(rings, place, &corners, &Turned::NOT, &mut pushes);
                turned.iter().for_each(|pose| self.push(rings, place, &corners, pose, &mut pushes));
            }
        };
        let next = |k: usize| (k + 1) % n;
        if i + 1 < rings.len() {
            for k in 0..n {
                face([(i, k), (i, next(k)), (i + 1, next(k))]);
                face([(i, k), (i + 1, next(k)), (i + 1, k)]);
            }
        }
        let mut edge = |a: (usize, usize), b: (usize, usize)| {
            if !is_moved(a) && !is_moved(b) {
                return;
            }
            if let Some(place) = self.nearest_on_edge(at(a), at(b)) {
                self.push(rings, place, &[a, b], &Turned::NOT, &mut pushes);
            }
            let middle = 0.5 * (at(a) + at(b));
            turned.iter().for_each(|pose| self.push(rings, middle, &[a, b], pose, &mut pushes));
        };
        for k in 0..n {
            edge((i, k), (i, next(k)));
            if i + 1 < rings.len() {
                edge((i, k), (i + 1, k));
                edge((i, k), (i + 1, next(k)));
            }
        }
        for k in (0..n).filter(|&k| is_moved((i, k))) {
            self.push(rings, at((i, k)), &[(i, k)], &Turned::NOT, &mut pushes);
            turned.iter().for_each(|pose| self.push(rings, at((i, k)), &[(i, k)], pose, &mut pushes));
        }
        pushes
    }

    /// If `place`, turned, falls short of the gap, what it takes from the ring points around it.
    fn push(&self, rings: &[Ring], place: DVec3, around: &[(usize, usize)], turned: &Turned, pushes: &mut Vec<Push>) {
        let place = turned.turn * place;
        let distance = guarded_distance(self.boundary.blisk, place);
        let short = self.boundary.gap - distance;
        if short <= turned.spare {
            return;
        }
        let nearest = self.boundary.blisk.nearest(place).point;
        let away = (place - nearest).normalize_or_zero() * distance.signum();
        let up = around.first().map_or(DVec2::Y, |&(ring, _)| rings[ring].line.up);
        let across = components(place, up, away);
        // Beside a blunt end of a blade nothing is gained across the passage.
        if turned.spare > 0.0 && across.iter().all(|part| part.abs() < ALONG) {
            return;
        }
        let (axis, sense, part) = self.way_in(around, across);
        let by = (short + SURPLUS) / part.max(0.2) * sense;
        pushes.extend(around.iter().map(|&(ring, point)| Push { ring, point, axis, by }));
    }

    /// The place of the edge from `a` to `b` that is nearest to the blisk, unless the edge has room to spare. The
    /// distance to a convex surface is convex along an edge, so that shrinking by the golden section finds it.
    fn nearest_on_edge(&self, a: DVec3, b: DVec3) -> Option<DVec3> {
        let distance = |t: f64| guarded_distance(self.boundary.blisk, a.lerp(b, t));
        if distance(0.5) > self.boundary.gap + SPARE {
            return None;
        }
        let ratio = 0.5 * (5f64.sqrt() - 1.0);
        let (mut from, mut to) = (0.0, 1.0);
        let (mut t, mut u) = (1.0 - ratio, ratio);
        let (mut at_t, mut at_u) = (distance(t), distance(u));
        for _ in 0..EDGE_STEPS {
            if at_t < at_u {
                (to, u, at_u) = (u, t, at_t);
                t = to - ratio * (to - from);
                at_t = distance(t);
            } else {
                (from, t, at_t) = (t, u, at_u);
                u = from + ratio * (to - from);
                at_u = distance(u);
            }
        }
        Some(a.lerp(b, if at_t < at_u { t } else { u }))
    }
}

/// Angle at `height` of the line through points in order of rising height, at the nearer end beyond them.
fn theta_at(points: impl Iterator<Item = Spot>, height: f64) -> f64 {
    let mut below: Option<Spot> = None;
    for above in points {
        if above.height >= height {
            let from = below.unwrap_or(above);
            let rise = above.height - from.height;
            let t = if rise > 0.0 { (height - from.height) / rise } else { 0.0 };
            return from.theta + t * (above.theta - from.theta);
        }
        below = Some(above);
    }
    below.map_or(f64::NAN, |last| last.theta)
}

/// Places that a point of the electrode passes when each of its walls, turned inwards by `turns`, is turned back.
fn turned_back(spot: Spot, [low, high]: [f64; 2]) -> [Spot; 6] {
    let turns = [-low / 3.0, -low / 1.5, -low, high / 3.0, high / 1.5, high];
    turns.map(|turn| Spot { theta: spot.theta + turn, ..spot })
}

/// A turn of the electrode about the axis, and by how much places may fall short of the gap there.
struct Turned {
    turn: DMat3,
    spare: f64,
}

impl Turned {
    /// The final pose.
    const NOT: Self = Self { turn: DMat3::IDENTITY, spare: 0.0 };

    /// Where the copying motion turns to: facets of a round hub do not matter there.
    fn by(turn: f64) -> Self {
        Self { turn: DMat3::from_rotation_x(turn), spare: FILLET }
    }
}

/// A wanted displacement of one ring point: along the line across the passage (axis 0) or theta (axis 1), in mm.
struct Push {
    ring: usize,
    point: usize,
    axis: usize,
    by: f64,
}
