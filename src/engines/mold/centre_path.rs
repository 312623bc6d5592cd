//! Path of a flat cutter's centre around its obstacles, in one layer.
//!
//! Where the edge touches an outline the cutter's centre stands off it by the radius, along its outward normal; at a
//! convex corner it turns about the corner. The holder keeps its own radius off what stands higher than the reach, and
//! so the centre does too. Both ways are cut by the I-regions of all sides that are too near, exactly (see
//! [`super::capsule`]); what is free of them bounds where the centre can stand.
//!
//! While the centre follows the outline of the layer, the cutter touches it. While it follows what the holder must keep
//! off, the cutter's edge draws the envelope: that outline grown by the holder's radius less the cutter's. No position
//! of the cutter goes beyond it, since each keeps the holder's radius off.

use glam::DVec2;

use super::capsule::{Arc, Interval, free_between, on_arc, on_line};
use super::edge_grid::EdgeGrid;
use super::outline::{Outline, off_segment};

/// Steps in which an arc is drawn (rad).
pub const ARC_STEP: f64 = 0.03;
/// Distance of the ends of the two paths to the same critical point, as a share of the radius: rounding.
pub const SAME_CENTER: f64 = 1e-6;

/// How far within the distance an element lies that is blocked at a glance (mm): more than rounding.
const WELL_WITHIN: f64 = 1e-6;

/// Outlines that the cutter's centre keeps off, with the material on their left.
#[derive(Debug, Clone, Copy)]
pub struct Obstacle<'a> {
    /// The outlines, which neither touch nor cross each other.
    pub outlines: &'a [Outline],
    /// How far the centre keeps off (mm).
    pub distance: f64,
}

/// A stretch of the boundary of what is left, with what is left on its left.
#[derive(Debug, Clone)]
pub struct Chain {
    /// Points.
    pub points: Vec<DVec2>,
    /// The cutter's centres when it touches the first and the last one; none if the stretch is closed.
    pub centers: Option<[DVec2; 2]>,
    /// Whether it is part of an outline that the cutter does not touch, not an envelope of the cutter.
    pub is_outline: bool,
    /// By how much its arcs, drawn in steps, make the area too small (mm^2).
    pub bulge: f64,
}

/// Everything that the centre of a cutter of this radius keeps off in one layer.
pub struct Layer<'a> {
    radius: f64,
    families: Vec<Family<'a>>,
}

struct Family<'a> {
    obstacle: Obstacle<'a>,
    sides: Vec<[DVec2; 2]>,
    /// Index in `sides` of each outline's first.
    first: Vec<usize>,
    grid: EdgeGrid,
}

/// One element of the way of the cutter's centre around an outline.
enum Element {
    /// Along a side: from where, which way (unit), how far; the outward normal.
    Side { from: DVec2, along: DVec2, length: f64, normal: DVec2 },
    /// Around a convex corner.
    Corner(Arc),
}

/// Elements in order, each with what is free of it.
struct Way {
    elements: Vec<(Element, Vec<Interval>)>,
    distance: f64,
}

impl<'a> Layer<'a> {
    /// A layer with what the cutter's edge and, where there is one, what its holder must keep off.
    pub fn new(radius: f64, edge: &'a [Outline], holder: Option<Obstacle<'a>>) -> Self {
        let edge = Obstacle { outlines: edge, distance: radius };
        // A holder no wider than the cutter meets only what the cutter meets below it.
        let holder = holder.filter(|h| h.distance > radius * (1.0 + SAME_CENTER) && !h.outlines.is_empty());
        Self { radius, families: std::iter::once(edge).chain(holder).map(Family::new).collect() }
    }

    /// Family and index of all outlines.
    pub fn outlines(&self) -> Vec<(usize, usize)> {
        let of = |f: usize| (0..self.families[f].obstacle.outlines.len()).map(move |i| (f, i));
        (0..self.families.len()).flat_map(of).collect()
    }

    /// The stretches around the outline with this family and index that bound what is left.
    pub fn chains(&self, (family, outline): (usize, usize)) -> Vec<Chain> {
        let way = self.way(family, outline);
        // The edge's way lies outside the material by itself; the holder's may run within what lies lower.
        let is_outside = |p: DVec2| {
            let edge = self.families[0].obstacle.outlines;
            edge.iter().map(|o| o.winding(p)).sum::<i32>() <= 0
        };
        if family == 0 { way.untouched() } else { way.envelopes(self.radius, is_outside) }
    }

    fn way(&self, family: usize, outline: usize) -> Way {
        let Family { obstacle, sides, first, .. } = &self.families[family];
        let (first, n) = (first[outline], obstacle.outlines[outline].points().len());
        let mut near = Vec::new();
        let mut elements = Vec::with_capacity(2 * n);
        for i in 0..n {
            let (own, next) = (first + i, first + (i + 1) % n);
            let ([a, b], [_, c]) = (sides[own], sides[next]);
            let along = (b - a).normalize_or_zero();
            // The material is on the left.
            let normal = -along.perp();
            let side = Element::Side { from: a, along, length: a.distance(b), normal };
            let free = self.free(&side, family, &[own], &mut near);
            elements.push((side, free));
            let turn = along.angle_to((c - b).normalize_or_zero());
            if turn > 0.0 {
                let radius = obstacle.distance;
                let corner = Element::Corner(Arc { center: b, radius, first: normal.to_angle(), turn });
                let free = self.free(&corner, family, &[own, next], &mut near);
                elements.push((corner, free));
            }
        }
        Way { elements, distance: obstacle.distance }
    }

    /// Free parts of an element, apart from its own sides, from which it keeps the distance.
    fn free(&self, element: &Element, family: usize, own: &[usize], near: &mut Vec<u32>) -> Vec<Interval> {
        let distance = self.families[family].obstacle.distance;
        let [p, q] = [element.off(0.0, distance), element.off(element.length(), distance)];
        // No point of it is further from its middle than half its length.
        let middle = element.off(0.5 * element.length(), distance);
        let half = match element {
            Element::Side { length, .. } => 0.5 * length,
            Element::Corner(arc) => 0.5 * arc.turn * distance,
        };
        let mut blocked = Vec::new();
        for (f, other) in self.families.iter().enumerate() {
            let keep = other.obstacle.distance;
            match element {
                Element::Side { .. } => other.grid.along([p, q], keep, near),
                Element::Corner(arc) => other.grid.near(arc.center - distance, arc.center + distance, keep, near),
            }
            for &k in near.iter().filter(|&&k| f != family || !own.contains(&(k as usize))) {
                let segment = other.sides[k as usize];
                let off = off_segment(middle, segment[0], segment[1]);
                if off > keep + half {
                    continue;
                }
                if off + half < keep - WELL_WITHIN {
                    return Vec::new();
                }
                match *element {
                    Element::Side { along, length, .. } => on_line(p, along, length, segment, keep, &mut blocked),
                    Element::Corner(arc) => on_arc(arc, segment, keep, &mut blocked),
                }
            }
        }
        free_between(&mut blocked, element.length())
    }
}

impl<'a> Family<'a> {
    fn new(obstacle: Obstacle<'a>) -> Self {
        let first = obstacle.outlines.iter().scan(0, |sum, o| {
            let first = *sum;
            *sum += o.points().len();
            Some(first)
        });
        let first = first.collect();
        let sides: Vec<_> = obstacle.outlines.iter().flat_map(Outline::sides).collect();
        let grid = EdgeGrid::new(&sides, obstacle.distance);
        Self { obstacle, sides, first, grid }
    }
}

impl Element {
    /// Range of its parameter: mm or rad.
    fn length(&self) -> f64 {
        match self {
            Self::Side { length, .. } => *length,
            Self::Corner(arc) => arc.turn,
        }
    }

    /// The point `distance` off the outline at parameter `t`.
    fn off(&self, t: f64, distance: f64) -> DVec2 {
        match *self {
            Self::Side { from, along, normal, .. } => from + along * t + normal * distance,
            Self::Corner(Arc { center, first, .. }) => center + DVec2::from_angle(first + t) * distance,
        }
    }
}

impl Way {
    /// Free intervals with their elements, in order, and which of them do not go on in the next.
    fn free(&self) -> (Vec<(usize, Interval)>, Vec<usize>) {
        let count = self.elements.len();
        let free: Vec<(usize, Interval)> =
            self.elements.iter().enumerate().flat_map(|(i, (_, free))| free.iter().map(move |f| (i, *f))).collect();
        let goes_on = |k: usize| {
            let ((i, [_, leave]), (j, [arrive, _])) = (free[k], free[(k + 1) % free.len()]);
            let (before, after) = (&self.elements[i].0, &self.elements[j].0);
            let off = before.off(leave, self.distance).distance(after.off(arrive, self.distance));
            let follows = (i + 1) % count == j && arrive <= 0.0 && leave >= before.length();
            follows && off <= SAME_CENTER * self.distance
        };
        let breaks = (0..free.len()).filter(|&k| !goes_on(k)).collect();
        (free, breaks)
    }

    /// The stretches of the outline between what is touched.
    fn untouched(&self) -> Vec<Chain> {
        let count = self.elements.len();
        let start = |i: usize| self.elements[i % count].0.off(0.0, 0.0);
        let chain = |points: Vec<DVec2>, centers| Chain { points, centers, is_outline: true, bulge: 0.0 };
        let (free, breaks) = self.free();
        if free.is_empty() {
            return vec![chain((0..=count).rev().map(start).collect(), None)];
        }
        let between = |&k: &usize| {
            let ((i, [_, leave]), (j, [arrive, _])) = (free[k], free[(k + 1) % free.len()]);
            let (before, after) = (&self.elements[i].0, &self.elements[j].0);
            let steps = if j > i || (j == i && arrive > leave) { j - i } else { j + count - i };
            // Against the outline, which has the material on its left.
            let mut points = vec![after.off(arrive, 0.0)];
            points.extend((1..=steps).rev().map(|s| start(i + s)));
            points.push(before.off(leave, 0.0));
            points.dedup();
            chain(points, Some([after.off(arrive, self.distance), before.off(leave, self.distance)]))
        };
        breaks.iter().map(between).collect()
    }

    /// Envelope of a cutter of this radius along the path where its centre is outside the material. A stretch that
    /// nothing blocks is outside or inside as a whole.
    fn envelopes(&self, radius: f64, is_outside: impl Fn(DVec2) -> bool) -> Vec<Chain> {
        let (free, breaks) = self.free();
        let count = free.len();
        let draw = |from: usize, steps: usize, is_closed: bool| {
            let (mut points, mut bulge) = (Vec::new(), 0.0);
            for (i, interval) in (0..steps).map(|s| free[(from + s) % count]) {
                bulge += self.draw(i, interval, self.distance - radius, &mut points);
            }
            let ((i, [arrive, _]), (j, [_, leave])) = (free[from % count], free[(from + steps - 1) % count]);
            let [i, j] = [i, j].map(|k| &self.elements[k].0);
            let centers = (!is_closed).then(|| [i.off(arrive, self.distance), j.off(leave, self.distance)]);
            points.dedup();
            Chain { points, centers, is_outline: false, bulge }
        };
        let begins_outside = |from: usize| {
            let (i, [arrive, leave]) = free[from % count];
            is_outside(self.elements[i].0.off(0.5 * (arrive + leave), self.distance))
        };
        if breaks.is_empty() {
            let is_drawn = !free.is_empty() && begins_outside(0);
            return is_drawn.then(|| draw(0, count, true)).into_iter().collect();
        }
        let next = |b: usize| if b + 1 < breaks.len() { breaks[b + 1] } else { breaks[0] + count };
        let runs = (0..breaks.len()).filter(|&b| begins_outside(breaks[b] + 1));
        runs.map(|b| draw(breaks[b] + 1, next(b) - breaks[b], false)).collect()
    }

    /// Points of an element `off` the outline; by how much steps make the area within too small.
    fn draw(&self, element: usize, [from, to]: Interval, off: f64, points: &mut Vec<DVec2>) -> f64 {
        let element = &self.elements[element].0;
        let steps = match element {
            Element::Side { .. } => 1,
            Element::Corner(_) => ((to - from) / ARC_STEP).ceil().max(1.0) as usize,
        };
        points.extend((0..=steps).map(|k| element.off(from + (to - from) * k as f64 / steps as f64, off)));
        match element {
            Element::Side { .. } => 0.0,
            Element::Corner(_) => segment_area(off, to - from, steps),
        }
    }
}

/// Area between an arc and the chords of so many steps (mm^2).
pub fn segment_area(radius: f64, angle: f64, steps: usize) -> f64 {
    let step = angle / steps as f64;
    0.5 * radius * radius * (step - step.sin()) * steps as f64
}
