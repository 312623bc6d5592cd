//! The volume left in the channel, along rays from wall to wall.

use std::sync::atomic::{AtomicUsize, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use super::cutter::RESOLUTION;
use super::{Passage, Removal, Stock};
use geometry::distance_field::DistanceField;
use task::{Cancelled, Task};
use wheel::channel::{Flow, Line};

/// Distance between the lines that the rays start from, along the passage (mm), and their greatest number.
const STEP_ALONG: f64 = 0.3;
const MOST_LINES: f64 = 150.0;
/// Distance between rays along such a line: at the hub and shroud, and the most between (mm), or this share of the
/// height if that is more.
const STEPS_UP: [f64; 2] = [0.05, 0.4];
const SHARE_UP: f64 = 0.025;
/// By how much each is longer than the one before.
const GROWTH: f64 = 1.3;
/// Shortest step along a ray (mm).
const LEAST_STEP: f64 = 0.02;
/// Less stock than this is none (mm): the error of a distance.
const NOTHING: f64 = DistanceField::ACCURACY + RESOLUTION;

/// Intervals of stock along one ray.
#[derive(Clone, Copy, Default)]
struct Passed {
    channel: f64,
    left: f64,
    depth: f64,
    at: Option<DVec3>,
}

/// Sections across a passage, the same distance apart.
pub(super) struct Sections<'a> {
    passage: &'a Passage<'a>,
    count: usize,
    step: f64,
}

/// Strip of a section at one height, from the low to the high wall.
pub(super) struct Strip {
    line: Line,
    height: f64,
    radius: f64,
    /// Angles of the walls (rad).
    walls: [f64; 2],
    /// Area that the strip stands for, square to its own direction (mm^2).
    pub(super) section: f64,
}

impl Strip {
    /// Distance from wall to wall (mm).
    pub(super) fn width(&self) -> f64 {
        ((self.walls[1] - self.walls[0]) * self.radius).max(0.0)
    }

    /// The point at a share of the width from the low wall, in W (mm).
    pub(super) fn point(&self, share: f64) -> DVec3 {
        self.line.point(self.height, self.walls[0] + share * (self.walls[1] - self.walls[0]))
    }
}

impl<'a> Sections<'a> {
    /// Sections of `passage`, `finer` times as many as the residual stock needs.
    pub(super) fn of(passage: &'a Passage<'a>, finer: usize) -> Self {
        let [from, to] = passage.span;
        let count = finer * ((to - from) / STEP_ALONG).ceil().clamp(1.0, MOST_LINES) as usize;
        Self { passage, count, step: (to - from) / count as f64 }
    }

    /// Number of sections.
    pub(super) fn len(&self) -> usize {
        self.count
    }

    /// Strips of section number `i`, from the hub to the shroud. Each stands for an interval of heights, and lies at this
    /// share of it.
    pub(super) fn strips(&self, i: usize, share: f64) -> impl Iterator<Item = Strip> {
        let (passage, step, from) = (self.passage, self.step, self.passage.span[0]);
        let channel = passage.channel();
        let [before, line, after] = [0.0, 0.5, 1.0].map(|t| channel.line_at(from + (i as f64 + t) * step));
        let [hub, shroud] = line.ends;
        // From the line before to the line after at the same share of the height, square to this line.
        let thickness = move |height: f64| {
            let place = |of: &Line| of.place(of.ends[0] + (height - hub) / (shroud - hub) * (of.ends[1] - of.ends[0]));
            if channel.flow == Flow::Axial { step } else { (place(&after) - place(&before)).perp_dot(line.up).abs() }
        };
        shells(hub, shroud).into_iter().map(move |[bottom, top]| {
            let height = bottom + share * (top - bottom);
            Strip {
                line,
                height,
                radius: line.radius(height),
                walls: passage.between(line.along, height),
                section: thickness(height) * (top - bottom),
            }
        })
    }
}

/// Stock left between the walls.
pub(super) fn stock(passage: &Passage, removal: &Removal, task: &Task) -> Result<Stock, Cancelled> {
    let sections = Sections::of(passage, 1);
    let done = AtomicUsize::new(0);
    let section = |i: usize| {
        let mut sum = Passed::default();
        for strip in sections.strips(i, 0.5) {
            task.check()?;
            let passed = ray(removal, &strip);
            sum.channel += strip.section * passed.channel;
            sum.left += strip.section * passed.left;
            if passed.depth > sum.depth {
                (sum.depth, sum.at) = (passed.depth, passed.at);
            }
        }
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        task.report("residual stock", 0.7 + 0.3 * done as f64 / sections.len() as f64, "volume of the channel");
        Ok(sum)
    };
    let sums: Vec<Result<Passed, Cancelled>> = (0..sections.len()).into_par_iter().map(section).collect();
    let mut stock = Stock { channel_mm3: 0.0, left_mm3: 0.0, depth_mm: 0.0, at: None };
    for sum in sums {
        let sum = sum?;
        stock.channel_mm3 += sum.channel;
        stock.left_mm3 += sum.left;
        if sum.depth > stock.depth_mm {
            (stock.depth_mm, stock.at) = (sum.depth, sum.at);
        }
    }
    Ok(stock)
}

/// Intervals of the height from the hub to the shroud, short at both.
fn shells(hub: f64, shroud: f64) -> Vec<[f64; 2]> {
    let middle = 0.5 * (hub + shroud);
    if middle.is_nan() || shroud <= hub {
        return Vec::new();
    }
    let most = STEPS_UP[1].max(SHARE_UP * (shroud - hub));
    let (mut heights, mut sum, mut step) = (vec![0.0], 0.0, STEPS_UP[0]);
    while sum < 0.5 * (shroud - hub) {
        sum += step;
        heights.push(sum);
        step = (step * GROWTH).min(most);
    }
    // The last one ends in the middle, all others a little shorter.
    let scale = 0.5 * (shroud - hub) / sum;
    let upwards = heights.windows(2).map(|h| [hub + scale * h[0], hub + scale * h[1]]);
    let downwards = heights.windows(2).rev().map(|h| [shroud - scale * h[1], shroud - scale * h[0]]);
    upwards.chain(downwards).collect()
}

/// Goes from the low to the high wall: no deviation changes faster than the point moves, so that what is left, or
/// eroded, stays so for as far as it is deep.
fn ray(removal: &Removal, strip: &Strip) -> Passed {
    let width = strip.width();
    if !removal.blank.is_full() {
        return sampled(removal, strip);
    }
    let mut passed = Passed { channel: width, ..Passed::default() };
    let mut s = 0.0;
    // The part of the last step that may have led into stock.
    let mut entered = 0.0;
    while s < width {
        let p = strip.point(s / width);
        let deviation = removal.deviation(p, 0.0);
        let step = deviation.abs().max(LEAST_STEP).min(width - s);
        if deviation > NOTHING {
            passed.left += deviation.min(width - s) + deviation.min(entered);
        }
        entered = if deviation > NOTHING { 0.0 } else { step - deviation.abs().min(step) };
        if deviation > passed.depth {
            (passed.depth, passed.at) = (deviation, Some(p));
        }
        s += step;
    }
    passed
}

/// Points from wall to wall, where the stock of the blank need not go on as far as a point is from what is eroded.
fn sampled(removal: &Removal, strip: &Strip) -> Passed {
    const POINTS: usize = 32;
    let width = strip.width();
    let mut passed = Passed { channel: width, ..Passed::default() };
    for k in 0..POINTS {
        let p = strip.point((k as f64 + 0.5) / POINTS as f64);
        let deviation = removal.deviation(p, 0.0);
        if deviation > NOTHING && removal.blank.holds(p) {
            passed.left += width / POINTS as f64;
            if deviation > passed.depth {
                (passed.depth, passed.at) = (deviation, Some(p));
            }
        }
    }
    passed
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shells_fill_the_height_without_gaps() {
        let shells = shells(100.0, 115.0);
        assert_eq!((shells[0][0], shells[shells.len() - 1][1]), (100.0, 115.0));
        assert!(shells.windows(2).all(|w| (w[0][1] - w[1][0]).abs() < 1e-9));
        assert!(shells.iter().all(|s| s[1] > s[0] && s[1] - s[0] <= STEPS_UP[1] + 1e-9));
        assert!(super::shells(10.0, 10.0).is_empty() && super::shells(f64::NAN, 10.0).is_empty());
    }
}
