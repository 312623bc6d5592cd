//! Pieces of the plane that cutters leave in one layer, and what several cutters leave together.

use glam::DVec2;
use serde::{Deserialize, Serialize};

use super::edge_grid::EdgeGrid;
use super::outline::{Outline, off_segment};
use super::plane;

/// How near a side lies to an outline to be part of it (mm): rounding.
const ON_OUTLINE: f64 = 1e-6;
/// Share of the area up to which two sets count as the same: rounding.
const SAME_AREA: f64 = 1e-7;

/// Depth in a corner over the distance of both points touched, up to a turn of 20 degrees: a quarter of the tangent of
/// a quarter of the turn, twice.
const SHALLOW: f64 = 0.0437;

/// A piece of the plane that the cutter leaves, connected.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct UncutPiece {
    /// Boundary, arcs in short steps: first the outer one, counter-clockwise, then its holes.
    pub boundary: Vec<Outline>,
    /// Area (mm^2), arcs taken as arcs.
    pub area: f64,
    /// The parts of the outlines that are not touched.
    pub segments: Vec<Vec<DVec2>>,
    /// How far its deepest corner is from where the cutter comes (mm); infinite where it never comes near. What several
    /// cutters leave is at most as deep as this says.
    pub depth: f64,
}

impl UncutPiece {
    /// Length of the outline that is not touched (mm).
    pub fn segment_length(&self) -> f64 {
        self.segments.iter().map(|s| s.windows(2).map(|w| w[0].distance(w[1])).sum::<f64>()).sum()
    }

    /// Twice its area over the length of its boundary: about half of what a strip is wide (mm).
    pub fn thickness(&self) -> f64 {
        thickness(self.area, &self.boundary)
    }

    /// Whether it lies in one corner that hardly turns, as between two facets of a round.
    pub fn is_shallow(&self) -> bool {
        let [segment] = &self.segments[..] else { return false };
        let [a, _, c] = segment[..] else { return false };
        self.depth < SHALLOW * a.distance(c)
    }

    /// Least and greatest coordinates (mm).
    pub fn extent(&self) -> [DVec2; 2] {
        plane::extent(&self.boundary)
    }
}

fn thickness(area: f64, boundary: &[Outline]) -> f64 {
    2.0 * area / boundary.iter().map(Outline::length).sum::<f64>().max(f64::MIN_POSITIVE)
}

/// Residual stock of a layer after every one of several cutters, from the stock that each leaves.
pub fn intersected(sets: impl IntoIterator<Item = Vec<UncutPiece>>) -> Vec<UncutPiece> {
    sets.into_iter().reduce(|a, b| pairs(&a, &b)).unwrap_or_default()
}

/// The parts of pieces within outlines.
pub fn clipped(pieces: Vec<UncutPiece>, to: &[Outline]) -> Vec<UncutPiece> {
    let is_convex = matches!(to, [outline] if outline.is_convex());
    let clip = |piece: UncutPiece| {
        let mut points = piece.boundary.iter().flat_map(Outline::points);
        if is_convex && points.all(|p| plane::holds(to, *p)) {
            return vec![piece];
        }
        let shapes = shared(&piece.boundary, to);
        if is_all_of(&piece, &shapes) {
            return vec![piece];
        }
        let own = [Untouched::new(&piece)];
        shapes.into_iter().map(|boundary| part(boundary, &own, piece.depth)).collect()
    };
    pieces.into_iter().flat_map(clip).collect()
}

/// Intersection of both sets, without slivers from the grid's rounding between common outlines.
fn shared(a: &[Outline], b: &[Outline]) -> Vec<Vec<Outline>> {
    let mut shapes = plane::intersection(a, b);
    shapes.retain(|shape| thickness(plane::area(shape), shape) > ON_OUTLINE);
    shapes
}

/// Whether shapes within a piece are the whole of it.
fn is_all_of(piece: &UncutPiece, shapes: &[Vec<Outline>]) -> bool {
    let [shape] = shapes else { return false };
    let area = plane::area(shape);
    (plane::area(&piece.boundary) - area).abs() <= SAME_AREA * area
}

fn part(boundary: Vec<Outline>, outlines: &[Untouched], depth: f64) -> UncutPiece {
    let segments = boundary.iter().flat_map(|outline| untouched(outline, outlines)).collect();
    UncutPiece { area: plane::area(&boundary), segments, depth, boundary }
}

fn pairs(a: &[UncutPiece], b: &[UncutPiece]) -> Vec<UncutPiece> {
    let extents: Vec<_> = b.iter().map(UncutPiece::extent).collect();
    let mut pieces = Vec::new();
    for first in a {
        let [low, high] = first.extent();
        for (second, [from, to]) in b.iter().zip(&extents) {
            if low.cmple(*to).all() && from.cmple(high).all() {
                pieces.extend(pair(first, second));
            }
        }
    }
    pieces
}

fn pair(a: &UncutPiece, b: &UncutPiece) -> Vec<UncutPiece> {
    let shapes = shared(&a.boundary, &b.boundary);
    let depth = a.depth.min(b.depth);
    // One within the other: its area is known better than that of what is drawn.
    if let Some(whole) = [a, b].into_iter().find(|piece| is_all_of(piece, &shapes)) {
        return vec![UncutPiece { depth, ..whole.clone() }];
    }
    let outlines = [Untouched::new(a), Untouched::new(b)];
    shapes.into_iter().map(|boundary| part(boundary, &outlines, depth)).collect()
}

/// The untouched sides of a piece, to find one near a point.
struct Untouched {
    sides: Vec<[DVec2; 2]>,
    grid: EdgeGrid,
}

impl Untouched {
    const CELL: f64 = 0.5;

    fn new(piece: &UncutPiece) -> Self {
        let sides: Vec<[DVec2; 2]> = piece.segments.iter().flat_map(|s| s.windows(2).map(|w| [w[0], w[1]])).collect();
        let grid = EdgeGrid::new(&sides, Self::CELL);
        Self { sides, grid }
    }

    fn holds(&self, p: DVec2) -> bool {
        let mut near = Vec::new();
        self.grid.near(p, p, ON_OUTLINE, &mut near);
        near.iter().any(|&k| off_segment(p, self.sides[k as usize][0], self.sides[k as usize][1]) <= ON_OUTLINE)
    }
}

/// Runs of sides of a boundary that all leave untouched.
fn untouched(outline: &Outline, of: &[Untouched]) -> Vec<Vec<DVec2>> {
    let sides: Vec<[DVec2; 2]> = outline.sides().collect();
    let is_on: Vec<bool> = sides.iter().map(|[p, q]| of.iter().all(|o| o.holds(p.midpoint(*q)))).collect();
    runs(&sides, &is_on)
}

/// Runs of consecutive sides of a closed polygon that are chosen.
pub fn runs(sides: &[[DVec2; 2]], is_chosen: &[bool]) -> Vec<Vec<DVec2>> {
    let n = sides.len();
    // Begin after a side that is not chosen, so that no run is cut in two.
    let first = is_chosen.iter().position(|c| !c).map_or(0, |k| k + 1);
    let mut runs: Vec<Vec<DVec2>> = Vec::new();
    let mut is_open = false;
    for k in (first..first + n).map(|k| k % n) {
        match (is_chosen[k], is_open) {
            (true, false) => runs.push(sides[k].to_vec()),
            (true, true) => runs.last_mut().into_iter().for_each(|run| run.push(sides[k][1])),
            _ => {}
        }
        is_open = is_chosen[k];
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x: f64, side: f64) -> UncutPiece {
        let corners = [[x, 0.0], [x + side, 0.0], [x + side, side], [x, side]].map(DVec2::from);
        let outline = Outline::new(corners.to_vec()).unwrap();
        // The side at the bottom lies on the outline of the mold, the others are drawn by the cutter.
        let segments = vec![corners[..2].to_vec()];
        UncutPiece { area: side * side, depth: side, segments, boundary: vec![outline] }
    }

    #[test]
    fn two_cutters_leave_what_both_leave() {
        let both = intersected([vec![square(0.0, 2.0), square(5.0, 1.0)], vec![square(1.0, 4.5)]]);
        assert_eq!(both.len(), 2);
        assert!((both[0].area - 2.0).abs() < 1e-7 && (both[0].segment_length() - 1.0).abs() < 1e-7, "{both:?}");
        assert!((both[1].area - 0.5).abs() < 1e-7 && (both[1].segment_length() - 0.5).abs() < 1e-7);
        assert_eq!((both[0].depth, both[1].depth), (2.0, 1.0));
    }

    #[test]
    fn what_lies_outside_goes() {
        let to = square(0.0, 3.0).boundary;
        let pieces = clipped(vec![square(0.5, 1.0), square(2.0, 2.0), square(4.0, 1.0)], &to);
        assert_eq!((pieces.len(), &pieces[0]), (2, &square(0.5, 1.0)));
        assert!((pieces[1].area - 2.0).abs() < 1e-7 && (pieces[1].segment_length() - 1.0).abs() < 1e-7);
    }

    #[test]
    fn what_lies_within_stays_as_it_is() {
        let (small, large) = (square(1.0, 1.0), square(0.0, 4.0));
        let alone = vec![small.clone()];
        assert_eq!(intersected([vec![large.clone()], alone.clone()]), alone);
        assert_eq!(intersected([alone.clone()]), alone);
        assert!(intersected([alone, vec![square(7.0, 1.0)]]).is_empty() && intersected([]).is_empty());
        assert_eq!(intersected([vec![large], Vec::new()]), []);
    }
}
