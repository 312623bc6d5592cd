//! A ring of metal that crosses all passages, as a part-span shroud does.

use std::f64::consts::{PI, TAU};
use std::mem::discriminant;

use glam::DVec2;

use super::super::frame::slices::{Gap, Slices};

/// Directions in which a ring is looked for, and places along each.
const DIRECTIONS: usize = 16;
const PLACES: i32 = 160;
/// How far it is looked for, as a share of the arc from blade to blade.
const REACH: f64 = 1.2;
/// Greatest share of these places that it may fill.
const MOST: f64 = 0.3;

/// Factor between the widths of a passage on either side of a ring, at most: gaps of other widths are of something else.
const AS_WIDE: f64 = 1.5;

/// What a circle about the axis meets.
#[derive(Clone, Copy)]
enum Circle {
    /// Blades, with the mean width of the gaps between them (rad).
    Blades(f64),
    Metal,
    Free,
}

/// A place (x, r) in a ring of metal near `place`: the circle through it is solid all round, and on either side of it there
/// are circles that meet all or one of every few of `blades` blades.
pub(super) fn near(slices: &Slices, place: DVec2, blades: usize) -> Option<DVec2> {
    let reach = REACH * place.y * TAU / blades as f64;
    let circle = |at: DVec2| {
        let gaps = slices.gaps(at.x, at.y);
        let width = gaps.iter().map(Gap::width).sum::<f64>() / gaps.len() as f64;
        match gaps.len() {
            0 => Some(if slices.is_solid(at.x, at.y, 0.0) { Circle::Metal } else { Circle::Free }),
            count => (count >= 3 && blades.is_multiple_of(count)).then_some(Circle::Blades(width)),
        }
    };
    let along = |direction: usize| {
        let way = reach * DVec2::from_angle(PI * direction as f64 / DIRECTIONS as f64);
        let at = |i: i32| place + way * f64::from(i) / f64::from(PLACES);
        // Circles that graze facets say nothing.
        let circles = (-PLACES..=PLACES).map(at).filter(|at| at.y > 0.0).filter_map(|at| Some((at, circle(at)?)));
        let circles: Vec<(DVec2, Circle)> = circles.collect();
        let runs: Vec<&[(DVec2, Circle)]> = circles.chunk_by(|a, b| discriminant(&a.1) == discriminant(&b.1)).collect();
        let is_ring = |run: &[&[(DVec2, Circle)]]| {
            let is_thin = (run[1].len() as f64) < MOST * 2.0 * f64::from(PLACES);
            match (run[0].last(), run[1].first(), run[2].first()) {
                (Some((_, Circle::Blades(a))), Some((_, Circle::Metal)), Some((_, Circle::Blades(b)))) => {
                    is_thin && a.max(*b) < AS_WIDE * a.min(*b)
                }
                _ => false,
            }
        };
        runs.windows(3).find(|run| is_ring(run)).map(|run| run[1][run[1].len() / 2].0)
    };
    (0..DIRECTIONS).find_map(along)
}
