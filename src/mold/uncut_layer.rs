//! What the edge of a flat cutter cannot touch in one layer (P3, section 4.1).
//!
//! Where the edge touches an outline the cutter's centre stands off it by the radius, along its outward normal; at a
//! convex corner it turns about the corner. That way of the centre is cut by the I-regions of all sides that are nearer
//! than twice the radius, of the same outline and of others, exactly (see [`super::capsule`]). What remains is the
//! boundary of where the centre can stand; its corners are the critical points, from which the cutter touches two
//! places at once. Between these two the outline is uncut, and the cutter's own arc bounds the stock that is left.
//!
//! The answer equals the closing of the material by the disc less the material.

use glam::DVec2;
use rayon::prelude::*;

use super::capsule::{Interval, free_between, on_arc, on_line};
use super::edge_grid::EdgeGrid;
use super::outline::Outline;

/// Steps in which an arc is drawn (rad).
const ARC_STEP: f64 = 0.15;
/// Parts of a side at whose ends its depth is taken.
const DEPTH_STEPS: u8 = 8;
/// How far apart the two ways to the same critical point may end, as a share of the radius: rounding.
const SAME_CENTER: f64 = 1e-6;

/// A piece of the plane that the cutter leaves, connected.
#[derive(Debug, Clone, PartialEq)]
pub struct UncutPiece {
    /// Its boundary, arcs in short steps: first the outer one, counter-clockwise, then its holes.
    pub boundary: Vec<Outline>,
    /// Area (mm^2), arcs taken as arcs.
    pub area: f64,
    /// The parts of the outlines that are not touched.
    pub segments: Vec<Vec<DVec2>>,
    /// How far its deepest corner is from where the cutter comes (mm); infinite where it never comes near.
    pub depth: f64,
}

impl UncutPiece {
    /// Length of the outline that is not touched (mm).
    pub fn segment_length(&self) -> f64 {
        self.segments.iter().map(|s| s.windows(2).map(|w| w[0].distance(w[1])).sum::<f64>()).sum()
    }
}

/// The pieces deeper than `tolerance` (mm) that a disc of `radius` (mm) leaves outside the material within `outlines`,
/// which neither touch nor cross each other.
pub fn uncut_pieces(outlines: &[Outline], radius: f64, tolerance: f64) -> Vec<UncutPiece> {
    let layer = Layer::new(outlines, radius);
    let ways: Vec<Way> = (0..outlines.len()).into_par_iter().map(|i| layer.way(i)).collect();
    let chains: Vec<Chain> = ways.iter().flat_map(|way| way.uncut()).collect();
    let cycles = joined(&chains, radius);
    let mut pieces = nested(cycles);
    pieces.retain(|piece| piece.depth > tolerance);
    pieces
}

/// One element of the way of the cutter's centre around an outline.
enum Element {
    /// Along a side: from where, which way (unit), how far; the outward normal.
    Side { from: DVec2, along: DVec2, length: f64, normal: DVec2 },
    /// Around a convex corner: where, the first direction to the centre (rad), how far it turns (rad).
    Corner { at: DVec2, first: f64, turn: f64 },
}

/// Elements in order, each with what is free of it.
struct Way {
    elements: Vec<(Element, Vec<Interval>)>,
    radius: f64,
}

/// A stretch of outline that is not touched.
struct Chain {
    /// Its points along the outline, from the last one touched before to the first one touched after.
    points: Vec<DVec2>,
    /// The centres from which these two are touched; none if all of the outline is uncut.
    centers: Option<[DVec2; 2]>,
}

struct Layer<'a> {
    outlines: &'a [Outline],
    radius: f64,
    sides: Vec<[DVec2; 2]>,
    /// Index in `sides` of each outline's first.
    first: Vec<usize>,
    grid: EdgeGrid,
}

impl<'a> Layer<'a> {
    fn new(outlines: &'a [Outline], radius: f64) -> Self {
        let first = outlines.iter().scan(0, |sum, o| {
            let first = *sum;
            *sum += o.points().len();
            Some(first)
        });
        let first = first.collect();
        let sides: Vec<_> = outlines.iter().flat_map(Outline::sides).collect();
        let grid = EdgeGrid::new(&sides, radius);
        Self { outlines, radius, sides, first, grid }
    }

    /// The way around the outline with this index.
    fn way(&self, outline: usize) -> Way {
        let (first, n) = (self.first[outline], self.outlines[outline].points().len());
        let mut near = Vec::new();
        let mut elements = Vec::with_capacity(2 * n);
        for i in 0..n {
            let (own, next) = (first + i, first + (i + 1) % n);
            let ([a, b], [_, c]) = (self.sides[own], self.sides[next]);
            let along = (b - a).normalize_or_zero();
            // The material is on the left.
            let normal = -along.perp();
            let side = Element::Side { from: a, along, length: a.distance(b), normal };
            let free = self.free(&side, &[own], &mut near);
            elements.push((side, free));
            let turn = along.angle_to((c - b).normalize_or_zero());
            if turn > 0.0 {
                let corner = Element::Corner { at: b, first: normal.to_angle(), turn };
                let free = self.free(&corner, &[own, next], &mut near);
                elements.push((corner, free));
            }
        }
        Way { elements, radius: self.radius }
    }

    /// What is free of an element, but for its own sides, from which it keeps the radius.
    fn free(&self, element: &Element, own: &[usize], near: &mut Vec<u32>) -> Vec<Interval> {
        let r = self.radius;
        let [p, q] = [element.center(0.0, r), element.center(element.length(), r)];
        let (min, max) = match element {
            Element::Side { .. } => (p.min(q), p.max(q)),
            Element::Corner { at, .. } => (*at - r, *at + r),
        };
        self.grid.near(min, max, r, near);
        let mut blocked = Vec::new();
        for &other in near.iter().filter(|&&k| !own.contains(&(k as usize))) {
            let segment = self.sides[other as usize];
            match *element {
                Element::Side { along, length, .. } => on_line(p, along, length, segment, r, &mut blocked),
                Element::Corner { at, first, turn } => on_arc(at, r, first, turn, segment, &mut blocked),
            }
        }
        free_between(&mut blocked, element.length())
    }
}

impl Element {
    /// Range of its parameter: mm or rad.
    fn length(&self) -> f64 {
        match self {
            Self::Side { length, .. } => *length,
            Self::Corner { turn, .. } => *turn,
        }
    }

    /// Where the centre is at parameter `t`.
    fn center(&self, t: f64, radius: f64) -> DVec2 {
        match *self {
            Self::Side { from, along, normal, .. } => from + along * t + normal * radius,
            Self::Corner { at, first, .. } => at + DVec2::from_angle(first + t) * radius,
        }
    }

    /// What the cutter touches then.
    fn touched(&self, t: f64) -> DVec2 {
        match *self {
            Self::Side { from, along, .. } => from + along * t,
            Self::Corner { at, .. } => at,
        }
    }
}

impl Way {
    /// The stretches of the outline between what is touched.
    fn uncut(&self) -> Vec<Chain> {
        let count = self.elements.len();
        let start = |i: usize| self.elements[i].0.touched(0.0);
        let free: Vec<(usize, Interval)> =
            self.elements.iter().enumerate().flat_map(|(i, (_, free))| free.iter().map(move |f| (i, *f))).collect();
        if free.is_empty() {
            let points: Vec<DVec2> = (0..=count).map(|i| start(i % count)).collect();
            return vec![Chain { points, centers: None }];
        }
        let mut chains = Vec::new();
        for (k, &(i, [_, leave])) in free.iter().enumerate() {
            let (j, [arrive, _]) = free[(k + 1) % free.len()];
            let (before, after) = (&self.elements[i].0, &self.elements[j].0);
            // One element follows the other, free up to where they meet.
            let follows = (i + 1) % count == j && arrive <= 0.0 && leave >= before.length();
            let centers = [before.center(leave, self.radius), after.center(arrive, self.radius)];
            if follows && centers[0].distance(centers[1]) <= SAME_CENTER * self.radius {
                continue;
            }
            let steps = if j > i || (j == i && arrive > leave) { j - i } else { j + count - i };
            let mut points = vec![before.touched(leave)];
            points.extend((1..=steps).map(|s| start((i + s) % count)));
            points.push(after.touched(arrive));
            points.dedup();
            chains.push(Chain { points, centers: Some(centers) });
        }
        chains
    }
}

/// A closed boundary of what is left, with what is left on its left.
struct Cycle {
    outline: Outline,
    area: f64,
    chains: Vec<Vec<DVec2>>,
    centers: Vec<DVec2>,
}

/// Joins stretches of outline by the arcs of the cutter at critical points.
fn joined(chains: &[Chain], radius: f64) -> Vec<Cycle> {
    let mut used = vec![false; chains.len()];
    let mut cycles = Vec::new();
    for start in 0..chains.len() {
        if used[start] {
            continue;
        }
        let (mut points, mut segments, mut centers, mut bulges) = (Vec::new(), Vec::new(), Vec::new(), 0.0);
        let mut at = start;
        while !used[at] {
            used[at] = true;
            let chain = &chains[at];
            // The material is on the outline's left, what is left outside is on its right: back along it.
            points.extend(chain.points.iter().rev());
            segments.push(chain.points.clone());
            let Some([center, _]) = chain.centers else { break };
            let touched = chain.points[0];
            let Some((next, sweep)) = following(chains, center, touched, radius) else { break };
            centers.push(center);
            bulges += 0.5 * radius * radius * (sweep - sweep.sin());
            points.extend(arc(center, touched, sweep));
            at = next;
        }
        if let Some(outline) = Outline::new(points) {
            let drawn: f64 = outline.area();
            let area = if centers.is_empty() { drawn } else { chorded(&segments).unwrap_or(drawn) - bulges };
            cycles.push(Cycle { outline, area, chains: segments, centers });
        }
    }
    cycles
}

/// The area within the stretches, joined by chords.
fn chorded(segments: &[Vec<DVec2>]) -> Option<f64> {
    Outline::new(segments.iter().flat_map(|s| s.iter().rev().copied()).collect()).map(|o| o.area())
}

/// The stretch that ends where the cutter at `center` touches next, clockwise from `touched`, and the angle to there.
fn following(chains: &[Chain], center: DVec2, touched: DVec2, radius: f64) -> Option<(usize, f64)> {
    let from = (touched - center).to_angle();
    let ends = chains.iter().enumerate().filter_map(|(i, c)| {
        let [_, end] = c.centers?;
        let sweep = || (from - (*c.points.last()? - center).to_angle()).rem_euclid(std::f64::consts::TAU).into();
        (end.distance(center) <= 2.0 * SAME_CENTER * radius).then(sweep).flatten().map(|sweep: f64| (i, sweep))
    });
    ends.min_by(|a, b| a.1.total_cmp(&b.1))
}

/// Points between both ends of an arc that runs clockwise.
fn arc(center: DVec2, from: DVec2, sweep: f64) -> Vec<DVec2> {
    let steps = (sweep / ARC_STEP).ceil().max(1.0) as usize;
    let spoke = from - center;
    (1..steps).map(|k| center + DVec2::from_angle(-sweep * k as f64 / steps as f64).rotate(spoke)).collect()
}

/// Outer boundaries with the holes in them.
fn nested(cycles: Vec<Cycle>) -> Vec<UncutPiece> {
    let (mut outer, holes): (Vec<Cycle>, Vec<Cycle>) = cycles.into_iter().partition(|c| c.outline.area() > 0.0);
    outer.sort_by(|a, b| a.outline.area().total_cmp(&b.outline.area()));
    let mut own: Vec<Vec<Cycle>> = outer.iter().map(|_| Vec::new()).collect();
    for hole in holes {
        let p = hole.outline.points()[0];
        // The smallest that holds it; what none holds is the air around the block.
        if let Some(i) = outer.iter().position(|o| o.outline.winding(p) != 0) {
            own[i].push(hole);
        }
    }
    outer.into_iter().zip(own).map(|(outer, holes)| piece(outer, holes)).collect()
}

fn piece(outer: Cycle, holes: Vec<Cycle>) -> UncutPiece {
    let cycles = || std::iter::once(&outer).chain(&holes);
    let centers: Vec<DVec2> = cycles().flat_map(|c| c.centers.iter().copied()).collect();
    let area = cycles().map(|c| c.area).sum();
    let segments: Vec<Vec<DVec2>> = cycles().flat_map(|c| c.chains.iter().cloned()).collect();
    let depth = depth(&segments, &centers, &outer);
    UncutPiece { area, depth, segments, boundary: std::iter::once(outer).chain(holes).map(|c| c.outline).collect() }
}

/// How far a point of the stretches is from the cutter in all its critical positions, at most.
fn depth(segments: &[Vec<DVec2>], centers: &[DVec2], outer: &Cycle) -> f64 {
    let Some(&[a, ..]) = outer.chains.first().map(Vec::as_slice) else { return f64::INFINITY };
    let Some(&center) = outer.centers.first() else { return f64::INFINITY };
    let radius = a.distance(center);
    let off = |p: DVec2| centers.iter().map(|c| p.distance(*c) - radius).fold(f64::INFINITY, f64::min);
    let between = |w: &[DVec2]| {
        let (p, q) = (w[0], w[1]);
        (0..=DEPTH_STEPS).map(move |k| p.lerp(q, f64::from(k) / f64::from(DEPTH_STEPS)))
    };
    segments.iter().flat_map(|s| s.windows(2)).flat_map(between).map(off).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::mold::outline::off_segment;

    /// Distance of `p` to the nearest side of `outlines` (mm).
    fn off_outlines(outlines: &[Outline], p: DVec2) -> f64 {
        outlines.iter().flat_map(Outline::sides).map(|[a, b]| off_segment(p, a, b)).fold(f64::INFINITY, f64::min)
    }

    /// A pocket in a block of 100 x 100 mm: its corners counter-clockwise.
    fn block_with(pocket: &[[f64; 2]]) -> Vec<Outline> {
        let outer = [[-50.0, -50.0], [50.0, -50.0], [50.0, 50.0], [-50.0, 50.0]];
        let inner = pocket.iter().rev().map(|p| DVec2::from(*p)).collect();
        vec![Outline::new(outer.map(DVec2::from).to_vec()).unwrap(), Outline::new(inner).unwrap()]
    }

    fn rectangle(width: f64, height: f64) -> Vec<[f64; 2]> {
        let (x, y) = (0.5 * width, 0.5 * height);
        vec![[-x, -y], [x, -y], [x, y], [-x, y]]
    }

    fn totals(pieces: &[UncutPiece]) -> (usize, f64, f64) {
        let length = pieces.iter().map(UncutPiece::segment_length).sum();
        (pieces.len(), pieces.iter().map(|p| p.area).sum(), length)
    }

    /// In each right-angled corner a square of the radius less a quarter of the disc is left.
    #[test]
    fn corners_of_a_pocket_keep_what_the_disc_cannot_fill() {
        for (radius, turned) in [(0.5, 0.0), (1.0, 0.3), (2.0, 1.1), (5.9, 0.7)] {
            let spin = |p: [f64; 2]| DVec2::from_angle(turned).rotate(DVec2::from(p)).to_array();
            let pocket: Vec<_> = rectangle(20.0, 12.0).into_iter().map(spin).collect();
            let pieces = uncut_pieces(&block_with(&pocket), radius, 1e-3);
            let (count, area, length) = totals(&pieces);
            assert_eq!(count, 4);
            assert!((area - 4.0 * (1.0 - PI / 4.0) * radius * radius).abs() < 1e-6 * radius, "{radius}: {area}");
            assert!((length - 8.0 * radius).abs() < 1e-6, "{length}");
            for piece in &pieces {
                assert!((piece.depth - (2f64.sqrt() - 1.0) * radius).abs() < 1e-6, "{}", piece.depth);
                let drawn: f64 = piece.boundary.iter().map(Outline::area).sum();
                assert!((drawn / piece.area - 1.0).abs() < 0.02, "drawn in steps: {drawn}");
            }
        }
    }

    #[test]
    fn a_slot_narrower_than_the_disc_is_left_whole() {
        let pieces = uncut_pieces(&block_with(&rectangle(10.0, 1.9)), 1.0, 1e-3);
        let (count, area, length) = totals(&pieces);
        assert!(count == 1 && (area - 19.0).abs() < 1e-9 && (length - 23.8).abs() < 1e-9, "{count} {area} {length}");
        assert_eq!(pieces[0].depth, f64::INFINITY);
        let (count, area, length) = totals(&uncut_pieces(&block_with(&rectangle(10.0, 2.2)), 1.0, 1e-3));
        assert!(count == 4 && (area - (4.0 - PI)).abs() < 1e-6 && (length - 8.0).abs() < 1e-6);
    }

    /// A slot of 1 mm that opens into a pocket: all of it and what the disc leaves at its mouth.
    #[test]
    fn a_slot_that_opens_into_a_pocket_is_left_up_to_where_the_disc_looks_in() {
        let (width, radius) = (1.0, 2.0f64);
        let outline = [
            [-10.0, -5.0],
            [10.0, -5.0],
            [10.0, -0.5],
            [18.0, -0.5],
            [18.0, 0.5],
            [10.0, 0.5],
            [10.0, 5.0],
            [-10.0, 5.0],
        ];
        let pieces = uncut_pieces(&block_with(&outline), radius, 1e-3);
        let slot = pieces.iter().find(|p| p.segment_length() > 10.0).unwrap();
        // The disc touches both corners of the mouth and sinks in by its sagitta.
        let half = (0.5 * width / radius).asin();
        let sunk = radius * radius * (half - half.sin() * half.cos());
        assert!((slot.area - (8.0 * width - sunk)).abs() < 1e-6, "{}", slot.area);
        assert!((slot.segment_length() - 17.0).abs() < 1e-6);
        assert_eq!(pieces.len(), 5);
    }

    #[test]
    fn an_island_too_near_to_the_wall_closes_the_gap_between_them() {
        let mut outlines = block_with(&rectangle(30.0, 20.0));
        // 1.5 mm from the wall at -15, elsewhere far.
        let island = [[-13.5, -2.0], [-5.0, -2.0], [-5.0, 2.0], [-13.5, 2.0]].map(DVec2::from);
        outlines.push(Outline::new(island.to_vec()).unwrap());
        let pieces = uncut_pieces(&outlines, 1.0, 1e-3);
        let gap = pieces.iter().find(|p| p.segment_length() > 4.0).unwrap();
        // Beside the island the disc touches its corner and the wall.
        let beside = (1.0 - 0.25f64).sqrt();
        assert_eq!((pieces.len(), gap.segments.len()), (5, 2));
        assert!((gap.segment_length() - (4.0 + 4.0 + 2.0 * beside)).abs() < 1e-6, "{}", gap.segment_length());
        let sampled = sampled_closing(&outlines, 1.0, [-15.2, -3.2], [-12.0, 3.2], 0.02);
        assert!((gap.area / sampled - 1.0).abs() < 0.02, "{} {sampled}", gap.area);
    }

    /// Area of closing less material in a window, by points of a grid: a point is left if every disc that holds it
    /// meets the material.
    fn sampled_closing(outlines: &[Outline], radius: f64, min: [f64; 2], max: [f64; 2], step: f64) -> f64 {
        let in_material = |p: DVec2| outlines.iter().map(|o| o.winding(p)).sum::<i32>() > 0;
        let reach = radius + step;
        let count = |k: usize| ((max[k] - min[k] + 2.0 * reach) / step).ceil() as usize;
        let at = |i: usize, j: usize| DVec2::new(min[0] - reach + i as f64 * step, min[1] - reach + j as f64 * step);
        let free: Vec<DVec2> = (0..count(0))
            .flat_map(|i| (0..count(1)).map(move |j| (i, j)))
            .map(|(i, j)| at(i, j))
            .filter(|&c| !in_material(c) && off_outlines(outlines, c) >= radius)
            .collect();
        let mut area = 0.0;
        for i in 0..count(0) {
            for j in 0..count(1) {
                let p = at(i, j) + 0.37 * step;
                let inside = p.x > min[0] && p.y > min[1] && p.x < max[0] && p.y < max[1];
                if inside && !in_material(p) && free.iter().all(|c| c.distance(p) > radius) {
                    area += step * step;
                }
            }
        }
        area
    }

    /// A round fillet of less than the disc's radius, in facets: what is left lies between arc and arc.
    #[test]
    fn a_fillet_is_left_where_the_disc_is_rounder_and_not_where_it_is_not() {
        let filleted = |fillet: f64| {
            let mut points = Vec::new();
            for (k, [x, y]) in rectangle(20.0, 12.0).into_iter().enumerate() {
                let center = DVec2::new(x, y) - fillet * DVec2::new(x.signum(), y.signum());
                let first = PI + k as f64 * PI / 2.0;
                points.extend(
                    (0..=200)
                        .map(|i| (center + DVec2::from_angle(first + f64::from(i) * PI / 400.0) * fillet).to_array()),
                );
            }
            block_with(&points)
        };
        let (count, area, length) = totals(&uncut_pieces(&filleted(0.5), 1.0, 2e-3));
        // Square less quarter disc, for the disc and for the fillet.
        let left = 4.0 * (1.0 - PI / 4.0) * (1.0 - 0.25);
        assert!(count == 4 && (area / left - 1.0).abs() < 1e-3, "{area} {left}");
        assert!((length - 4.0 * (1.0 + 0.5 * PI / 2.0)).abs() < 2e-3, "{length}");
        assert!(uncut_pieces(&filleted(1.05), 1.0, 2e-3).is_empty());
        assert!(uncut_pieces(&filleted(3.0), 1.0, 2e-3).is_empty());
    }

    #[test]
    fn a_larger_disc_leaves_more() {
        let outline = [[-20.0, -9.0], [3.0, -12.0], [7.0, -4.0], [20.0, -1.0], [15.0, 11.0], [2.0, 4.0], [-8.0, 13.0]];
        let left = |radius: f64| totals(&uncut_pieces(&block_with(&outline), radius, 0.0)).1;
        let areas: Vec<f64> = (1..30).map(|k| left(0.25 * f64::from(k))).collect();
        assert!(areas.windows(2).all(|w| w[1] >= w[0] - 1e-9), "{areas:?}");
    }
}
