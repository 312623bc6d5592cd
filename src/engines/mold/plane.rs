//! Sets of the plane and their unions, intersections and differences, on a fixed grid (i_overlay).

use glam::DVec2;
use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay::Overlay;
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::core::solver::{Precision, Solver};
use i_overlay::i_float::int::point::IntPoint;

use super::outline::{Outline, off_segment};

/// Squares of the grid per mm: finer than any file's rounding.
const SCALE: f64 = (1u64 << 30) as f64;
/// Radius within which crossings are moved to ends of sides: one square of the grid, and eight times as much in each
/// further round. Where sides of many outlines lie on nearly one line a radius that grows slowly takes round after round,
/// each with more pieces than the one before.
const SNAPPING: Precision = Precision { start: 0, progression: 6 };
/// How far from the origin points may lie (mm), so that no product of two coordinates overflows.
const FURTHEST: f64 = 1e8;

/// A connected set of the plane: its outer boundary, counter-clockwise, then its holes, clockwise.
pub type Shape = Vec<Outline>;

type Ring = Vec<IntPoint<i64>>;

/// The outlines of shapes.
pub fn outlines(shapes: Vec<Shape>) -> Vec<Outline> {
    shapes.into_iter().flatten().collect()
}

/// Points around which either of the sets winds at least once.
pub fn union(a: &[Outline], b: &[Outline]) -> Vec<Shape> {
    overlay(a, b, OverlayRule::Union)
}

/// Points around which both wind at least once.
pub fn intersection(a: &[Outline], b: &[Outline]) -> Vec<Shape> {
    overlay(a, b, OverlayRule::Intersect)
}

/// Points around which `a` winds at least once and `b` does not.
pub fn difference(a: &[Outline], b: &[Outline]) -> Vec<Shape> {
    overlay(a, b, OverlayRule::Difference)
}

/// The set within outlines grown by `by` (mm; shrunk if negative), with corners kept as they are. What is shrunk
/// must be thicker than twice as much everywhere, as a grown set is.
pub fn grown(outlines: &[Outline], by: f64) -> Vec<Shape> {
    /// How much further a corner may move than a side.
    const FURTHEST: f64 = 8.0;
    let moved = |outline: &Outline| {
        let points = outline.points();
        let n = points.len();
        let corner = |i: usize| {
            let [a, b, c] = [points[(i + n - 1) % n], points[i], points[(i + 1) % n]];
            let [before, after] = [b - a, c - b].map(|d| -d.normalize_or_zero().perp());
            b + (before + after) / (1.0 + before.dot(after)).max(2.0 / (FURTHEST * FURTHEST)) * by
        };
        Outline::new((0..n).map(corner).collect())
    };
    let moved: Vec<Outline> = outlines.iter().filter_map(moved).collect();
    union(&moved, &[])
}

/// Area within outlines whose holes run the other way (mm^2).
pub fn area(outlines: &[Outline]) -> f64 {
    outlines.iter().map(Outline::area).sum()
}

/// Whether `p` is within outlines whose holes run the other way.
pub fn holds(outlines: &[Outline], p: DVec2) -> bool {
    outlines.iter().map(|o| o.winding(p)).sum::<i32>() > 0
}

/// How far `p` is from what is within outlines whose holes run the other way (mm); infinite where that is nothing.
pub fn off(outlines: &[Outline], p: DVec2) -> f64 {
    if holds(outlines, p) {
        return 0.0;
    }
    let sides = outlines.iter().flat_map(Outline::sides);
    sides.map(|[a, b]| off_segment(p, a, b)).fold(f64::INFINITY, f64::min)
}

/// A point within outlines whose holes run the other way, away from them where there is room; none where they hold
/// nothing.
pub fn inside(outlines: &[Outline]) -> Option<DVec2> {
    /// Lines along X that are looked along, at most: the middles of the widest bands between corners.
    const LINES: usize = 64;
    let mut heights: Vec<f64> = outlines.iter().flat_map(Outline::points).map(|p| p.y).collect();
    heights.sort_by(f64::total_cmp);
    let mut bands: Vec<[f64; 2]> = heights.windows(2).map(|h| [h[0], h[1]]).filter(|[a, b]| a < b).collect();
    bands.sort_by(|a, b| (b[1] - b[0]).total_cmp(&(a[1] - a[0])));
    let stretches = bands.into_iter().take(LINES).filter_map(|[low, high]| {
        let (y, width) = (low.midpoint(high), |[a, b]: &[f64; 2]| b - a);
        let widest = stretches(outlines, y).into_iter().max_by(|a, b| width(a).total_cmp(&width(b)))?;
        Some((width(&widest).min(high - low), DVec2::new(widest[0].midpoint(widest[1]), y)))
    });
    let within = stretches.filter(|(_, p)| holds(outlines, *p));
    within.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, p)| p)
}

/// Where the line at this height is within outlines: from and to along X.
pub fn stretches(outlines: &[Outline], y: f64) -> Vec<[f64; 2]> {
    let crossing = |[a, b]: [DVec2; 2]| {
        let is_crossed = (a.y <= y) != (b.y <= y);
        // What runs down has the inside on the right.
        is_crossed.then(|| (a.x + (b.x - a.x) * (y - a.y) / (b.y - a.y), if a.y > b.y { 1 } else { -1 }))
    };
    let mut crossings: Vec<(f64, i32)> = outlines.iter().flat_map(Outline::sides).filter_map(crossing).collect();
    crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut winding = 0;
    let mut found = Vec::new();
    for pair in crossings.windows(2) {
        winding += pair[0].1;
        if winding > 0 {
            found.push([pair[0].0, pair[1].0]);
        }
    }
    found
}

/// Least and greatest coordinates.
pub fn extent(outlines: &[Outline]) -> [DVec2; 2] {
    let points = outlines.iter().flat_map(Outline::points);
    points.fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[low, high], p| [low.min(*p), high.max(*p)])
}

fn overlay(a: &[Outline], b: &[Outline], rule: OverlayRule) -> Vec<Shape> {
    // Points too far for the grid or not finite: there is no such mold, and nothing is found.
    let (Some(a), Some(b)) = (on_grid(a), on_grid(b)) else { return Vec::new() };
    let mut overlay = Overlay::<i64>::from_subj_and_clip(&a, &b);
    overlay.solver = Solver::with_precision(SNAPPING);
    let shapes = overlay.overlay(rule, FillRule::Positive);
    let point = |p: IntPoint<i64>| DVec2::new(p.x as f64, p.y as f64) / SCALE;
    let outline = |ring: Ring| Outline::new(ring.into_iter().map(point).collect());
    let shape = |rings: Vec<Ring>| {
        let mut rings = rings.into_iter().map(outline);
        let outer = rings.next().flatten()?;
        Some(std::iter::once(outer).chain(rings.flatten()).collect())
    };
    shapes.into_iter().filter_map(shape).collect()
}

fn on_grid(outlines: &[Outline]) -> Option<Vec<Ring>> {
    let point = |p: &DVec2| {
        let place = (p.abs().max_element() <= FURTHEST && p.is_finite()).then(|| (*p * SCALE).round())?;
        Some(IntPoint { x: place.x as i64, y: place.y as i64 })
    };
    outlines.iter().map(|o| o.points().iter().map(point).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x: f64, y: f64, side: f64) -> Outline {
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        Outline::new(corners.map(|(u, v)| DVec2::new(x + side * u, y + side * v)).to_vec()).unwrap()
    }

    #[test]
    fn sets_of_squares_have_the_areas_of_squares() {
        let (a, b) = ([square(0.0, 0.0, 2.0)], [square(1.0, 1.0, 2.0)]);
        let of = |shapes: Vec<Shape>| shapes.iter().map(|s| area(s)).sum::<f64>();
        assert!((of(union(&a, &b)) - 7.0).abs() < 1e-7);
        assert!((of(intersection(&a, &b)) - 1.0).abs() < 1e-7);
        assert!((of(difference(&a, &b)) - 3.0).abs() < 1e-7);
        assert!(intersection(&a, &[]).is_empty() && union(&[], &[]).is_empty());
        assert!(intersection(&a, &[square(5.0, 0.0, 1.0)]).is_empty());
    }

    #[test]
    fn a_point_inside_is_found_and_others_are_as_far_off_as_the_nearest_side() {
        let l = [(0.0, 0.0), (6.0, 0.0), (6.0, 1.0), (1.0, 1.0), (1.0, 6.0), (0.0, 6.0)];
        let l = [Outline::new(l.into_iter().map(DVec2::from).collect()).unwrap()];
        let p = inside(&l).unwrap();
        assert!(p.min_element() > 0.0 && p.min_element() < 1.0 && p.max_element() < 6.0, "{p}");
        // The middle of a frame is not of it.
        let frame = [square(0.0, 0.0, 10.0), square(0.5, 0.5, 9.0).reversed()];
        let p = inside(&frame).unwrap();
        assert!(holds(&frame, p) && off(&frame, p) == 0.0, "{p}");
        assert!((off(&frame, DVec2::splat(5.0)) - 4.5).abs() < 1e-12);
        assert!((off(&frame, DVec2::new(13.0, 14.0)) - 5.0).abs() < 1e-12);
        assert!(inside(&[]).is_none() && off(&[], DVec2::ZERO) == f64::INFINITY);
    }

    #[test]
    fn growing_and_shrinking_keeps_squares_and_closes_gaps() {
        let by = 1e-5;
        let grown_square: f64 = grown(&[square(0.0, 0.0, 2.0)], by).iter().map(|s| area(s)).sum();
        assert!((grown_square - (2.0 + 2.0 * by).powi(2)).abs() < 1e-7, "{grown_square}");
        let halves = [square(0.0, 0.0, 2.0), square(2.0 + by, 0.0, 2.0)];
        let closed: Vec<Outline> = grown(&halves, by).into_iter().flatten().collect();
        let back = grown(&closed, -by);
        assert!(back.len() == 1 && (area(&back[0]) - 8.0 - 2.0 * by).abs() < 1e-7, "{back:?}");
    }

    #[test]
    fn holes_run_the_other_way_and_what_winds_the_wrong_way_is_no_set() {
        let ring = [square(0.0, 0.0, 4.0), square(1.0, 1.0, 1.0).reversed()];
        let shapes = union(&ring, &[]);
        assert_eq!((shapes.len(), shapes[0].len()), (1, 2));
        assert!(shapes[0][0].area() > 0.0 && shapes[0][1].area() < 0.0);
        assert!((area(&shapes[0]) - 15.0).abs() < 1e-7 && (area(&ring) - 15.0).abs() < 1e-7);
        assert!(union(&[square(0.0, 0.0, 1.0).reversed()], &[]).is_empty());
        assert!(holds(&ring, DVec2::splat(0.5)) && !holds(&ring, DVec2::splat(1.5)));
        let far = [Outline::new(vec![DVec2::ZERO, DVec2::X * 1e300, DVec2::Y * 1e300]).unwrap()];
        assert!(union(&far, &ring).is_empty());
    }
}
