//! Ruled surfaces that a CAD program gives the guides of.

use glam::DVec3;

use super::knots::Knots;
use super::measure;
use super::patch::Patch;
use super::sides::{self, Sides};
use super::strip::{Foot, Strip};
use geometry::nurbs::NurbsCurve;

/// How near cubic guides are to the given ones (mm).
const SAME: f64 = 1e-7;
/// Most pieces of a guide.
const MOST_PIECES: usize = 512;

/// Pieces of a closed guide at least.
const CLOSED_PIECES: u32 = 8;

/// The surface between the pair of `guides` whose rulings are the most upright, with its sides on the face; none where
/// the face has no four sides, or the guides are no cubic splines to [`SAME`].
pub(super) fn surface(patch: &Patch, guides: &[[NurbsCurve; 2]], up: DVec3) -> Option<(Sides, Strip)> {
    let lean = |pair: &&[NurbsCurve; 2]| {
        let [a, b] = pair.each_ref().map(middle);
        (b - a).normalize_or_zero().dot(up).abs()
    };
    let pair = guides.iter().max_by(|a, b| lean(a).total_cmp(&lean(b)))?;
    let [low, high] = pair;
    let pair = if (middle(high) - middle(low)).dot(up) < 0.0 { [high, low] } else { [low, high] };
    let strip = cubic(pair.map(|g| g.mapped(|p| p - patch.origin)))?;
    let strip = if is_outwards(patch, &strip) {
        strip
    } else {
        cubic(pair.map(|g| g.reversed().mapped(|p| p - patch.origin)))?
    };
    let choices = sides::choices(patch, up).into_iter().filter(|sides| sides.is_ring == strip.knots.is_closed);
    let measured = choices.map(|sides| (measure::border(&sides, &strip), sides));
    let (_, sides) = measured.min_by(|a, b| a.0.total_cmp(&b.0))?;
    Some((sides, strip))
}

fn middle(guide: &NurbsCurve) -> DVec3 {
    let [from, to] = guide.domain();
    guide.point(0.5 * (from + to))
}

/// The guides as cubic splines with common knots from 0 to 1: exactly, where they are such, else with pieces halved until
/// they are within [`SAME`].
fn cubic(guides: [NurbsCurve; 2]) -> Option<Strip> {
    let place = |guide: &NurbsCurve, u: f64| {
        let [from, to] = guide.domain();
        guide.at(from + (to - from) * u)
    };
    let ends = |u: f64| guides.each_ref().map(|g| place(g, u)[0]);
    let is_closed = guides.iter().all(|g| {
        let [start, end] = [0.0, 1.0].map(|u| place(g, u));
        start[0].distance(end[0]) < SAME && start[1].angle_between(end[1]) < 1e-6
    });
    let mut breaks: Vec<f64> = guides
        .iter()
        .flat_map(|g| {
            let [from, to] = g.domain();
            g.knots().joints().into_iter().map(move |u| (u - from) / (to - from))
        })
        .collect();
    if is_closed {
        breaks.extend((1..CLOSED_PIECES).map(|i| f64::from(i) / f64::from(CLOSED_PIECES)));
    }
    breaks.sort_by(f64::total_cmp);
    breaks.dedup_by(|a, b| *a - *b < 1e-12);
    if let Some(last) = breaks.last_mut() {
        *last = 1.0;
    }
    loop {
        let knots = Knots { breaks: breaks.clone(), is_closed };
        let places = knots.dense();
        let strip = Strip::through(knots, &places, &places.iter().map(|u| ends(*u)).collect::<Vec<_>>())?;
        let off = |u: f64| {
            let [a, b] = strip.ends(u);
            let [c, d] = ends(u);
            a.distance(c).max(b.distance(d))
        };
        let is_off = |w: &[f64]| (0..8).any(|i| off(w[0] + (w[1] - w[0]) * (f64::from(i) + 0.5) / 8.0) > SAME);
        let halves: Vec<f64> = breaks.windows(2).filter(|w| is_off(w)).map(|w| 0.5 * (w[0] + w[1])).collect();
        if halves.is_empty() {
            return Some(strip);
        }
        if breaks.len() + halves.len() > MOST_PIECES {
            return None;
        }
        breaks.extend(halves);
        breaks.sort_by(f64::total_cmp);
    }
}

/// Whether the guides crossed with from the lower to the upper one point out of the solid.
fn is_outwards(patch: &Patch, strip: &Strip) -> bool {
    let place = strip.at(Foot { u: 0.5, v: 0.5 });
    let near = |i: &usize| patch.points[*i].distance_squared(place.point);
    let nearest = (0..patch.points.len()).min_by(|i, j| near(i).total_cmp(&near(j))).unwrap_or(0);
    place.first[0].cross(place.first[1]).dot(patch.normals[nearest]) > 0.0
}
