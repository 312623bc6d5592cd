//! Uncut stock of a flat cutter in one layer (P3, section 4.1).
//!
//! The way of the cutter's centre around the outlines (module `centre_path`) ends at critical points, from which the
//! cutter touches two places at once. Between these two the outline is uncut, and the cutter's own arc bounds the stock
//! that is left.
//!
//! The answer equals the closing of the material by the disc less the material; with a limited reach, what no position
//! of the disc covers for which the holder is free as well.

use std::f64::consts::TAU;

use glam::DVec2;
use rayon::prelude::*;

use super::centre_path::{ARC_STEP, Chain, Layer, Obstacle, SAME_CENTER, segment_area};
use super::outline::{Outline, off_segment};
pub use super::piece::UncutPiece;
use super::piece::runs;
use super::plane;

/// Parts of a side at whose ends its depth is taken.
const DEPTH_STEPS: u8 = 8;
/// How far off its side a point is taken to ask what piece the side bounds (mm).
const BESIDE: f64 = 1e-6;
/// Share of the tolerance below which the thickness of a piece is rounding: that of a corner is a third of its depth.
const THINNEST: f64 = 0.05;

/// The pieces deeper than `tolerance` (mm) that a disc of `radius` (mm) leaves outside the material within `outlines`,
/// which neither touch nor cross each other.
pub fn uncut_pieces(outlines: &[Outline], radius: f64, tolerance: f64) -> Vec<UncutPiece> {
    uncut_with_holder(outlines, radius, None, tolerance)
}

/// Uncut stock of a cutter whose centre also keeps off the obstacles of its holder.
pub fn uncut_with_holder(
    outlines: &[Outline],
    radius: f64,
    holder: Option<Obstacle>,
    tolerance: f64,
) -> Vec<UncutPiece> {
    let layer = Layer::new(radius, outlines, holder);
    let chains: Vec<Vec<Chain>> = layer.outlines().into_par_iter().map(|outline| layer.chains(outline)).collect();
    let cycles = Joints::new(chains.into_iter().flatten().collect(), radius).cycles();
    let mut pieces =
        if have_crossing_arcs(&cycles, radius) { resolved(&cycles, radius) } else { nested(cycles, radius) };
    pieces.retain(|piece| piece.depth > tolerance && piece.thickness() > THINNEST * tolerance);
    pieces
}

/// Part of a cutter's edge, clockwise.
#[derive(Debug, Clone, Copy)]
struct Edge {
    center: DVec2,
    /// Direction to its beginning (rad).
    from: f64,
    sweep: f64,
}

/// A closed boundary of what is left, with what is left on its left.
struct Cycle {
    outline: Outline,
    area: f64,
    chains: Vec<Chain>,
    edges: Vec<Edge>,
}

/// Stretches of boundary and where they begin.
struct Joints {
    chains: Vec<Chain>,
    radius: f64,
    /// The centres from which chains begin, by x.
    begin: Vec<(DVec2, usize)>,
}

impl Joints {
    fn new(chains: Vec<Chain>, radius: f64) -> Self {
        let mut begin: Vec<(DVec2, usize)> =
            chains.iter().enumerate().filter_map(|(i, c)| c.centers.map(|[center, _]| (center, i))).collect();
        begin.sort_by(|a, b| a.0.x.total_cmp(&b.0.x).then(a.1.cmp(&b.1)));
        Self { chains, radius, begin }
    }

    /// Joins the stretches by the arcs of the cutter at critical points.
    fn cycles(&self) -> Vec<Cycle> {
        let mut used = vec![false; self.chains.len()];
        let mut cycles = Vec::new();
        for start in 0..self.chains.len() {
            let (mut points, mut chains, mut edges, mut bulges) = (Vec::new(), Vec::new(), Vec::new(), 0.0);
            let mut at = start;
            while !used[at] {
                used[at] = true;
                let chain = &self.chains[at];
                points.extend(&chain.points);
                bulges += chain.bulge;
                chains.push(chain.clone());
                let (Some([_, center]), Some(&touched)) = (chain.centers, chain.points.last()) else { break };
                let Some((next, sweep)) = self.following(center, touched) else { break };
                edges.push(Edge { center, from: (touched - center).to_angle(), sweep });
                let steps = steps(sweep);
                points.extend(arc(center, touched, sweep, steps));
                bulges -= segment_area(self.radius, sweep, steps);
                at = next;
            }
            if let Some(outline) = Outline::new(points) {
                cycles.push(Cycle { area: outline.area() + bulges, outline, chains, edges });
            }
        }
        cycles
    }

    /// The stretch that begins where the cutter at `center` touches next, clockwise from `touched`, and the angle to
    /// there.
    fn following(&self, center: DVec2, touched: DVec2) -> Option<(usize, f64)> {
        let same = 2.0 * SAME_CENTER * self.radius;
        let first = self.begin.partition_point(|(c, _)| c.x < center.x - same);
        let near = self.begin[first..].iter().take_while(|(c, _)| c.x <= center.x + same);
        let from = (touched - center).to_angle();
        let sweep_to = |i: usize| {
            let to = self.chains[i].points.first()?;
            Some((i, (from - (*to - center).to_angle()).rem_euclid(TAU)))
        };
        let ends = near.filter(|(c, _)| c.distance(center) <= same).filter_map(|&(_, i)| sweep_to(i));
        ends.min_by(|a, b| a.1.total_cmp(&b.1))
    }
}

fn steps(sweep: f64) -> usize {
    (sweep / ARC_STEP).ceil().max(1.0) as usize
}

/// Points between both ends of an arc that runs clockwise.
fn arc(center: DVec2, from: DVec2, sweep: f64, steps: usize) -> impl Iterator<Item = DVec2> {
    let spoke = from - center;
    (1..steps).map(move |k| center + DVec2::from_angle(-sweep * k as f64 / steps as f64).rotate(spoke))
}

/// Whether the cutter reaches into what bounds it in another position: through a neck narrower than itself, from both
/// sides.
fn have_crossing_arcs(cycles: &[Cycle], radius: f64) -> bool {
    let mut edges: Vec<Edge> = cycles.iter().flat_map(|c| c.edges.iter().copied()).collect();
    edges.sort_by(|a, b| a.center.x.total_cmp(&b.center.x).then(a.center.y.total_cmp(&b.center.y)));
    edges.iter().enumerate().any(|(i, a)| {
        let near = edges[i + 1..].iter().take_while(|b| b.center.x - a.center.x < 2.0 * radius);
        near.into_iter().any(|b| do_cross(a, b, radius))
    })
}

fn do_cross(a: &Edge, b: &Edge, radius: f64) -> bool {
    /// Angle from either end within which arcs only meet (rad).
    const MEETING: f64 = 1e-5;
    let between = b.center - a.center;
    let (off, ratio) = (between.length(), between.length() / (2.0 * radius));
    if off <= 2.0 * SAME_CENTER * radius || ratio >= 1.0 {
        return false;
    }
    let is_within = |edge: &Edge, direction: f64| {
        let along = (edge.from - direction).rem_euclid(TAU);
        along > MEETING && along < edge.sweep - MEETING
    };
    [1.0, -1.0].into_iter().any(|sign| {
        let (of_a, of_b) = (sign * ratio.acos(), std::f64::consts::PI - sign * ratio.acos());
        is_within(a, between.to_angle() + of_a) && is_within(b, between.to_angle() + of_b)
    })
}

/// Outer boundaries with the holes in them.
fn nested(cycles: Vec<Cycle>, radius: f64) -> Vec<UncutPiece> {
    let (mut outer, holes): (Vec<Cycle>, Vec<Cycle>) = cycles.into_iter().partition(|c| c.outline.area() > 0.0);
    outer.sort_by(|a, b| a.outline.area().total_cmp(&b.outline.area()));
    let mut own: Vec<Vec<usize>> = outer.iter().map(|_| Vec::new()).collect();
    for (k, hole) in holes.iter().enumerate() {
        let [p, q] = hole.outline.longest_side();
        let beside = p.midpoint(q);
        // The smallest that holds it; what none holds is the air around the block. Where the cutter reaches through a
        // neck from both sides its two positions bound no hole: there is nothing around it.
        let around = |cycles: &[Cycle]| cycles.iter().map(|c| c.outline.winding(beside)).sum::<i32>();
        if let Some(i) = outer.iter().position(|o| o.outline.winding(beside) != 0)
            && around(&outer) + around(&holes[..k]) + around(&holes[k + 1..]) > 0
        {
            own[i].push(k);
        }
    }
    let mut holes: Vec<Option<Cycle>> = holes.into_iter().map(Some).collect();
    let mut taken = |of: Vec<usize>| of.into_iter().filter_map(|k| holes[k].take()).collect();
    outer.into_iter().zip(own).map(|(outer, of)| piece(outer, taken(of), radius)).collect()
}

fn piece(outer: Cycle, holes: Vec<Cycle>, radius: f64) -> UncutPiece {
    let cycles = || std::iter::once(&outer).chain(&holes);
    let area = cycles().map(|c| c.area).sum();
    let chains = || cycles().flat_map(|c| &c.chains);
    let segments: Vec<Vec<DVec2>> = chains().filter(|c| c.is_outline).map(|c| c.points.clone()).collect();
    let centers: Vec<DVec2> = cycles().flat_map(|c| c.edges.iter().map(|e| e.center)).collect();
    let envelopes: Vec<&Chain> = chains().filter(|c| !c.is_outline).collect();
    let depth = depth(&segments, &centers, &envelopes, radius);
    UncutPiece { area, depth, segments, boundary: std::iter::once(outer).chain(holes).map(|c| c.outline).collect() }
}

/// How far a point of the stretches is from the cutter where its edge bounds what is left, at most.
fn depth(segments: &[Vec<DVec2>], centers: &[DVec2], envelopes: &[&Chain], radius: f64) -> f64 {
    let off_envelope = |p: DVec2| {
        let sides = envelopes.iter().flat_map(|c| c.points.windows(2));
        sides.map(|w| off_segment(p, w[0], w[1])).fold(f64::INFINITY, f64::min)
    };
    let off = |p: DVec2| centers.iter().map(|c| p.distance(*c) - radius).fold(off_envelope(p), f64::min);
    let between = |w: &[DVec2]| {
        let (p, q) = (w[0], w[1]);
        (0..=DEPTH_STEPS).map(move |k| p.lerp(q, f64::from(k) / f64::from(DEPTH_STEPS)))
    };
    segments.iter().flat_map(|s| s.windows(2)).flat_map(between).map(off).fold(0.0, f64::max)
}

/// The pieces within cycles whose arcs cross: what they wind around.
fn resolved(cycles: &[Cycle], radius: f64) -> Vec<UncutPiece> {
    let outlines: Vec<Outline> = cycles.iter().map(|c| c.outline.clone()).collect();
    let chains = || cycles.iter().flat_map(|c| &c.chains);
    let outer: Vec<&Chain> = chains().filter(|c| c.is_outline).collect();
    let envelopes: Vec<&Chain> = chains().filter(|c| !c.is_outline).collect();
    let centers: Vec<DVec2> = cycles.iter().flat_map(|c| c.edges.iter().map(|e| e.center)).collect();
    let piece = |boundary: Vec<Outline>| {
        let [low, high] = plane::extent(&boundary);
        let bounds = |[p, q]: &[DVec2; 2]| {
            let beside = p.midpoint(*q) + (*q - *p).normalize_or_zero().perp() * BESIDE;
            beside.cmpge(low).all() && beside.cmple(high).all() && plane::holds(&boundary, beside)
        };
        let mut segments = Vec::new();
        for chain in &outer {
            let mut sides: Vec<[DVec2; 2]> = chain.points.windows(2).map(|w| [w[0], w[1]]).collect();
            let mut is_chosen: Vec<bool> = sides.iter().map(bounds).collect();
            // An open stretch has no side from its end to its beginning.
            sides.extend(chain.centers.map(|_| [DVec2::ZERO; 2]));
            is_chosen.extend(chain.centers.map(|_| false));
            segments.extend(runs(&sides, &is_chosen));
        }
        let depth = depth(&segments, &centers, &envelopes, radius);
        UncutPiece { area: plane::area(&boundary), depth, segments, boundary }
    };
    plane::union(&outlines, &[]).into_iter().map(piece).collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::outline::off_segment;

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

    /// A wall with a gap of 1 mm in it: the disc sinks into the gap from both sides. Where the wall is thin both
    /// positions cross, and two bits beside the gap's walls are left; where it is sharp nothing is.
    #[test]
    fn a_gap_that_the_disc_reaches_into_from_both_sides() {
        let (radius, half_gap) = (2.0f64, 0.5);
        let sunk = radius - (radius * radius - half_gap * half_gap).sqrt();
        let left = |half_wall: f64| {
            let mut outlines = block_with(&rectangle(40.0, 20.0));
            for sign in [-1.0, 1.0] {
                // From the gap into the pocket's wall, both ends overlapping nothing.
                let (near, far) = (sign * half_gap, sign * 5.4);
                let mut wall = vec![[-half_wall, near], [half_wall, near], [half_wall, far], [-half_wall, far]];
                if sign < 0.0 {
                    wall.reverse();
                }
                outlines.push(Outline::new(wall.into_iter().map(DVec2::from).collect()).unwrap());
            }
            uncut_pieces(&outlines, radius, 1e-4)
        };
        let at_gap = |pieces: &[UncutPiece]| {
            let near = |p: &&UncutPiece| p.extent().iter().all(|e| e.y.abs() < 0.6 && e.x.abs() < 1.0);
            let of: Vec<UncutPiece> = pieces.iter().filter(near).cloned().collect();
            totals(&of)
        };
        // Between the circle and the gap's wall, from the edge of the gap to the middle of the wall.
        for half_wall in [0.02f64, 0.9 * sunk, 1.1 * sunk, 0.4] {
            let (count, area, length) = at_gap(&left(half_wall));
            let is_thin = half_wall < sunk;
            let steps = 20_000;
            let height = |k: i32| {
                // The disc stands so that it touches both edges of the gap; how far its edge is from the axis here.
                let x = half_wall * (f64::from(k) + 0.5) / f64::from(steps);
                let off = (radius * radius - half_gap * half_gap).sqrt() + half_wall - x;
                half_gap - (radius * radius - off * off).max(0.0).sqrt().min(half_gap)
            };
            let exact = 4.0 * half_wall / f64::from(steps) * (0..steps).map(height).sum::<f64>();
            assert_eq!(count, if is_thin { 2 } else { 1 }, "{half_wall}");
            assert!((area - exact).abs() < 2e-3 * exact + 3e-4, "{half_wall}: {area} {exact}");
            assert!((length - 4.0 * half_wall).abs() < 1e-5, "{half_wall}: {length}");
        }
    }

    /// A holder is kept off by an island that is too high for it: a ring is left around the island.
    #[test]
    fn what_a_holder_cannot_come_near_to_is_left() {
        let (radius, holder) = (1.0, 6.0);
        let island = rectangle(4.0, 4.0).into_iter().map(DVec2::from).collect::<Vec<_>>();
        let island = [Outline::new(island).unwrap()];
        let ring = |outlines: &[Outline]| {
            let obstacle = Obstacle { outlines: &island, distance: holder };
            uncut_with_holder(outlines, radius, Some(obstacle), 1e-3)
        };
        let pieces = ring(&island);
        let off: f64 = holder - radius;
        let exact = 4.0 * 4.0 * off + PI * off * off;
        assert_eq!((pieces.len(), pieces[0].boundary.len()), (1, 2));
        assert!((pieces[0].area - exact).abs() < 1e-6 && (pieces[0].segment_length() - 16.0).abs() < 1e-9);
        assert!((pieces[0].depth - off).abs() < 1e-6, "{}", pieces[0].depth);
        // A pocket's wall 6.5 mm from the island on one side: between both the cutter does not pass.
        let mut outlines = block_with(&[[-8.5, -30.0], [30.0, -30.0], [30.0, 30.0], [-8.5, 30.0]]);
        outlines.extend(island.iter().cloned());
        let pieces = ring(&outlines);
        let joined = pieces.iter().find(|p| p.area > 10.0).unwrap();
        assert!(pieces.len() == 5 && joined.segments.len() == 2 && joined.area > exact, "{}", joined.area);
        let sampled = sampled_holder(&outlines, &island, [radius, holder], [-8.5, -9.0], [8.0, 9.0]);
        assert!((joined.area / sampled - 1.0).abs() < 0.04, "{} {sampled}", joined.area);
    }

    /// Reference by sampling, as [`sampled_closing`], for a cutter whose centre keeps off the island by more.
    fn sampled_holder(outlines: &[Outline], high: &[Outline], keep: [f64; 2], min: [f64; 2], max: [f64; 2]) -> f64 {
        let step = 0.2;
        let in_material = |o: &[Outline], p: DVec2| o.iter().map(|o| o.winding(p)).sum::<i32>() > 0;
        let is_free = |c: DVec2| {
            !in_material(outlines, c) && off_outlines(outlines, c) >= keep[0] && off_outlines(high, c) >= keep[1]
        };
        let places = |margin: f64| {
            let count = |k: usize| ((max[k] - min[k] + 2.0 * margin) / step) as usize;
            let at =
                move |i: usize, j: usize| DVec2::from(min) - margin + step * DVec2::new(i as f64 + 0.5, j as f64 + 0.5);
            (0..count(0)).flat_map(|i| (0..count(1)).map(move |j| (i, j))).map(|(i, j)| at(i, j)).collect::<Vec<_>>()
        };
        let free: Vec<DVec2> = places(keep[0]).into_iter().filter(|&c| is_free(c)).collect();
        let is_left = |p: &DVec2| !in_material(outlines, *p) && free.iter().all(|c| c.distance(*p) > keep[0]);
        places(0.0).iter().filter(|p| is_left(p)).count() as f64 * step * step
    }
}
