//! Volume that each electrode removes along its motion, and its frontal area there.
//!
//! The channel is filled with points, each of which stands for a volume. A point is removed by the electrode that comes
//! within the spark gap of it first: in the order of the burns, on the feed or on the copying motion. So an electrode
//! removes what the ones before have left. The feed, and the copying motion, are cut into pieces of equal advance of the
//! middle of the burning faces, without stretches on which nothing is removed. The frontal area of a piece is the volume
//! that is removed on it by its advance: the area of the electrode in the stock, seen along the motion.
//!
//! The stock is that of the blank in the channel between the finished walls, hub and shroud, over the span of the blades. Of a bar that moves straight, volumes are within 2 % and frontal areas within 8 %, less where it enters.

use glam::DVec3;
use rayon::prelude::*;

use super::cutter::{Cutter, Motion};
use super::volume::Sections;
use super::{Burn, Passage, Removal};
use crate::pose::Pose;
use crate::problem::quasi_random;
use burning::choice::Piece;
use geometry::distance_field::DistanceField;
use task::{Cancelled, Task};

/// Distance of the stations of a motion (mm of advance), and their greatest number.
const STATION: f64 = 0.25;
const MOST_STATIONS: f64 = 400.0;
/// Greatest number of pieces of a motion, and their least advance (mm).
const MOST_PIECES: f64 = 16.0;
const LEAST_ADVANCE: f64 = 1.0;
/// Share of the greatest volume of a stretch between two stations below which a stretch removes nothing worth an advance.
const IDLE: f64 = 0.02;
/// Sections across the passage in the place of each that the residual stock is measured in.
const FINER: usize = 8;
/// Points across the channel in a section, from wall to wall. Each section has them elsewhere.
const ACROSS: usize = 8;

/// Motion of an electrode as stations, the same advance between each two.
struct Stations {
    motion: Motion,
    /// Advance between two stations (mm).
    step: f64,
}

impl Stations {
    /// Stations along `poses`; none if the middle of the burning faces does not advance.
    fn along(poses: &[Pose], burn: &Burn, cutter: &Cutter) -> Option<Self> {
        let middle = burn.electrode.middle();
        let reference = burn.electrode.reference_point;
        let places: Vec<DVec3> = poses.iter().map(|pose| pose.placement(reference).transform_point3(middle)).collect();
        let mut advance = vec![0.0];
        for pair in places.windows(2) {
            advance.push(advance.last().copied().unwrap_or(0.0) + pair[0].distance(pair[1]));
        }
        let length = advance.last().copied().filter(|length| *length > 0.0)?;
        let count = (length / STATION).ceil().clamp(1.0, MOST_STATIONS) as usize;
        let step = length / count as f64;
        let mut row = 0;
        let stations = (0..=count).map(|k| {
            let at = (k as f64 * step).min(length);
            while row + 2 < poses.len() && advance[row + 1] < at {
                row += 1;
            }
            let way = advance[row + 1] - advance[row];
            let share = if way > 0.0 { ((at - advance[row]) / way).clamp(0.0, 1.0) } else { 1.0 };
            poses[row].lerp(&poses[row + 1], share)
        });
        Some(Self { motion: cutter.motion(stations.collect()), step })
    }

    /// Pieces of the motion, given the volume that is removed up to each of its stations from the one before (mm^3).
    fn pieces_of(&self, removed: &[f64]) -> Vec<Piece> {
        let idle = IDLE * removed.iter().copied().fold(0.0, f64::max);
        let (mut busy, mut carried): (Vec<f64>, f64) = (Vec::new(), 0.0);
        for volume in removed {
            carried += volume;
            if *volume > idle {
                busy.push(std::mem::take(&mut carried));
            }
        }
        let Some(last) = busy.last_mut() else { return Vec::new() };
        *last += carried;
        let pieces = (self.step * busy.len() as f64 / LEAST_ADVANCE).floor().clamp(1.0, MOST_PIECES) as usize;
        let pieces = pieces.min(busy.len());
        let piece = |i: usize| {
            let stretches = &busy[i * busy.len() / pieces..(i + 1) * busy.len() / pieces];
            let volume_mm3 = stretches.iter().sum::<f64>();
            Piece { volume_mm3, frontal_area_mm2: volume_mm3 / (self.step * stretches.len() as f64) }
        };
        (0..pieces).map(piece).collect()
    }
}

/// Pieces of the burn of each electrode, in the order of its motion.
pub(super) fn removed(
    passage: &Passage,
    removal: &Removal,
    burns: &[Burn],
    task: &Task,
) -> Result<Vec<Vec<Piece>>, Cancelled> {
    let of_burn = |(burn, cutter)| -> Vec<Stations> {
        let burn: &Burn = burn;
        let copying = [&[Pose::FINAL], &burn.copying[..]].concat();
        [&burn.feed[..], &copying[..]].into_iter().filter_map(|poses| Stations::along(poses, burn, cutter)).collect()
    };
    let stations: Vec<Vec<Stations>> = burns.iter().zip(&removal.cutters).map(of_burn).collect();
    let nothing: Vec<Vec<Vec<f64>>> =
        stations.iter().map(|of| of.iter().map(|s| vec![0.0; s.motion.len()]).collect()).collect();
    let sections = Sections::of(passage, FINER);
    let of_section = |i: usize| {
        let mut sums = nothing.clone();
        let [up, aside] = [0, 1].map(|k| quasi_random(i as f64, k));
        for strip in sections.strips(i, up) {
            task.check()?;
            let volume = strip.section * strip.width() / ACROSS as f64;
            for k in 0..ACROSS {
                let p = strip.point((k as f64 + aside) / ACROSS as f64);
                if !removal.blank.holds(p) {
                    continue;
                }
                let cutters = removal.cutters.iter().zip(&removal.gaps);
                let first = stations.iter().zip(cutters).enumerate().find_map(|(b, (of, (cutter, gap)))| {
                    let within = gap + DistanceField::ACCURACY;
                    let row = |(m, s): (usize, &Stations)| Some((m, cutter.first_row_within(&s.motion, p, within)?));
                    of.iter().enumerate().find_map(row).map(|(m, row)| (b, m, row))
                });
                if let Some((b, m, row)) = first {
                    // What is removed at the first station is removed with the first advance.
                    sums[b][m][row.max(1)] += volume;
                }
            }
        }
        Ok(sums)
    };
    let of_sections: Vec<Result<_, Cancelled>> = (0..sections.len()).into_par_iter().map(of_section).collect();
    let mut sums = nothing.clone();
    for own in of_sections {
        let own: Vec<Vec<Vec<f64>>> = own?;
        let own = own.iter().flatten().flatten();
        sums.iter_mut().flatten().flatten().zip(own).for_each(|(sum, volume)| *sum += volume);
    }
    let pieces = stations.iter().zip(&sums);
    Ok(pieces.map(|(of, sums)| of.iter().zip(sums).flat_map(|(s, sums)| s.pieces_of(&sums[1..])).collect()).collect())
}
