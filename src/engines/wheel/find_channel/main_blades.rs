//! Which blades of a wheel with splitters are its main blades.

use std::f64::consts::TAU;

use glam::DVec2;

use super::super::frame::MOST_KINDS;
use super::super::frame::slices::Gap;
use super::flow::flood;
use super::meridian::{Place, Tracer};
use geometry::frame::wrap_angle;
use task::Cancelled;

/// Main blades cover at least this share of what the largest blade covers in the meridional plane.
const MAIN: f64 = 0.9;
/// On a circle through hub or shroud the metal between two gaps is more than a blade: wider than the gaps by this factor.
const WIDER: f64 = 2.0;

/// The blades of a group on a circle about the axis.
#[derive(Clone, Copy)]
struct Standing {
    /// Angle of the middle of each, or where it would be (rad).
    thetas: [f64; MOST_KINDS],
    /// Which of them are there.
    is_there: [bool; MOST_KINDS],
}

/// Which blades of a group of so many `kinds` are main blades, counted from the one below the channel through `start`. All
/// channels of a wheel have the same, whichever is chosen: blades are compared as far as they reach, also where those beside
/// the channel have ended.
pub(super) fn main_blades(tracer: &Tracer, start: &Place, kinds: usize) -> Result<[bool; MOST_KINDS], Cancelled> {
    let at = DVec2::new(start.x, start.r);
    let begin = Standing::near(tracer, at, &evenly_spaced(&start.gap, tracer.pitch, kinds), kinds);
    let Some(begin) = begin.filter(|_| kinds > 1) else { return Ok([true; MOST_KINDS]) };
    let (_, places) = flood(tracer, (at, begin), |at, near| Standing::near(tracer, at, &near.thetas, kinds))?;
    let covered: [usize; MOST_KINDS] = std::array::from_fn(|k| places.values().filter(|s| s.is_there[k]).count());
    let most = covered.into_iter().fold(0, usize::max) as f64;
    Ok(covered.map(|places| places as f64 >= MAIN * most))
}

/// Angles of the blades of a group: those beside a gap, the others evenly spaced over the rest of the group.
fn evenly_spaced(gap: &Gap, pitch: f64, kinds: usize) -> [f64; MOST_KINDS] {
    let rest = (kinds as f64 * pitch - gap.width()) / (kinds.max(2) - 1) as f64;
    std::array::from_fn(|k| if k == 0 { gap.low.theta } else { gap.high.theta + rest * (k - 1) as f64 })
}

impl Standing {
    /// The blades on the circle at (x, r), on a neighbouring one of which they are at `thetas` (rad); none where none of them
    /// is there.
    fn near(tracer: &Tracer, at: DVec2, thetas: &[f64; MOST_KINDS], kinds: usize) -> Option<Self> {
        let gaps = tracer.slices.gaps(at.x, at.y);
        let group = kinds as f64 * tracer.pitch;
        let mut is_there = [false; MOST_KINDS];
        let mut turns = [0.0; MOST_KINDS];
        for (i, below) in gaps.iter().enumerate() {
            let above = &gaps[(i + 1) % gaps.len()];
            let width = (above.low.theta - below.high.theta).rem_euclid(TAU);
            if width > WIDER * below.width().min(above.width()) {
                continue;
            }
            let middle = below.high.theta + 0.5 * width;
            // Of all groups' blades the nearest, if it is of this group.
            let turn = |k: usize| wrap_angle(middle - thetas[k]);
            let beside = |k: usize| turn(k) - group * (turn(k) / group).round();
            let nearest = (0..kinds).min_by(|a, b| beside(*a).abs().total_cmp(&beside(*b).abs()))?;
            if turn(nearest).abs() < 0.5 * group.min(tracer.pitch) {
                (is_there[nearest], turns[nearest]) = (true, turn(nearest));
            }
        }
        let there = is_there.iter().filter(|is_there| **is_there).count();
        let mean = turns.iter().sum::<f64>() / there.max(1) as f64;
        let thetas = std::array::from_fn(|k| thetas[k] + if is_there[k] { turns[k] } else { mean });
        (there > 0).then_some(Self { thetas, is_there })
    }
}
