//! Deviations of a scan from the nominal surface: list, statistics, worst places, verdict.

use std::collections::BTreeMap;
use std::fmt;

use glam::{DAffine3, DVec3};
use rayon::prelude::*;
use task::Task;

use crate::{MeasuredError, Nominal};

/// Points between two looks at the cancel flag.
const BLOCK: usize = 1024;

/// The deviation of one point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deviation {
    /// The measured point after the fit (mm), in the axes of the nominal mesh.
    pub point: DVec3,
    /// The nearest point of the nominal surface (mm).
    pub nearest: DVec3,
    /// Distance from the nominal surface (mm): positive outside of the metal, where too much is left.
    pub distance: f64,
    /// The triangle of the nominal mesh on which the nearest point lies.
    pub triangle: u32,
}

/// Deviations that are allowed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    below_mm: f64,
    above_mm: f64,
    least_share: f64,
}

impl Tolerance {
    /// Deviations from `-mm` to `mm`, for every point.
    ///
    /// # Errors
    /// [`MeasuredError::BadSetting`] unless the tolerance is positive and finite.
    pub fn symmetric(mm: f64) -> Result<Self, MeasuredError> {
        Self::between(-mm, mm)
    }

    /// Deviations from `below_mm`, too little metal, to `above_mm`, too much, for every point.
    ///
    /// # Errors
    /// [`MeasuredError::BadSetting`] unless both are finite and the first is less.
    pub fn between(below_mm: f64, above_mm: f64) -> Result<Self, MeasuredError> {
        // Written so that NaN fails.
        if below_mm.is_finite() && above_mm.is_finite() && below_mm < above_mm {
            return Ok(Self { below_mm, above_mm, least_share: 1.0 });
        }
        let value = format!("{below_mm} to {above_mm} mm");
        Err(MeasuredError::BadSetting { name: "tolerance", value, rule: "give a range of deviations in mm" })
    }

    /// Tolerance of this range for a share of the points only.
    ///
    /// # Errors
    /// [`MeasuredError::BadSetting`] unless the share is above 0 and not above 1.
    pub fn for_share(self, least_share: f64) -> Result<Self, MeasuredError> {
        if least_share > 0.0 && least_share <= 1.0 {
            return Ok(Self { least_share, ..self });
        }
        let rule = "give a share of the points above 0, at most 1";
        Err(MeasuredError::BadSetting { name: "share within the tolerance", value: least_share.to_string(), rule })
    }

    /// Least and greatest deviation that are allowed (mm).
    pub fn range_mm(&self) -> [f64; 2] {
        [self.below_mm, self.above_mm]
    }

    /// Share of the points that must lie within the range.
    pub fn least_share(&self) -> f64 {
        self.least_share
    }

    /// How far a deviation lies outside of the range (mm), 0 within it.
    pub fn excess(&self, deviation: f64) -> f64 {
        (self.below_mm - deviation).max(deviation - self.above_mm).max(0.0)
    }
}

/// Statistics of deviations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Statistics {
    /// Number of points.
    pub points: usize,
    /// Least deviation (mm): most metal missing.
    pub least_mm: f64,
    /// Mean deviation (mm).
    pub mean_mm: f64,
    /// Greatest deviation (mm): most metal left.
    pub greatest_mm: f64,
    /// Root mean square of the deviations (mm).
    pub rms_mm: f64,
    /// Number of points within the tolerance.
    pub within: usize,
    /// Share of the points within the tolerance.
    pub share_within: f64,
}

impl Statistics {
    fn of(deviations: impl Iterator<Item = f64>, tolerance: &Tolerance) -> Self {
        let (mut points, mut within, mut sum, mut squares) = (0usize, 0usize, 0.0, 0.0);
        let (mut least_mm, mut greatest_mm) = (f64::INFINITY, f64::NEG_INFINITY);
        for d in deviations {
            points += 1;
            within += usize::from(tolerance.excess(d) == 0.0);
            sum += d;
            squares += d * d;
            least_mm = d.min(least_mm);
            greatest_mm = d.max(greatest_mm);
        }
        let count = points.max(1) as f64;
        Self {
            points,
            least_mm,
            mean_mm: sum / count,
            greatest_mm,
            rms_mm: (squares / count).sqrt(),
            within,
            share_within: within as f64 / count,
        }
    }
}

/// Place with a great deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Worst<L> {
    /// The deviation there.
    pub deviation: Deviation,
    /// Label of the surface.
    pub surface: L,
}

/// Whether a part keeps a tolerance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Verdict {
    /// Whether enough points lie within the tolerance.
    pub is_within: bool,
    /// The tolerance.
    pub tolerance: Tolerance,
    /// Number of points that were judged.
    pub points: usize,
    /// Number of points outside of the tolerance.
    pub outside: usize,
    /// The point that lies farthest outside of the tolerance; none if none does.
    pub farthest: Option<Deviation>,
}

impl fmt::Display for Verdict {
    /// Verdict as a sentence without its full stop, with the figures and their limits.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [least, most] = self.tolerance.range_mm();
        let word = if self.is_within { "within" } else { "outside of" };
        write!(f, "{word} the tolerance of {least:+.4} to {most:+.4} mm: ")?;
        let Some(farthest) = &self.farthest else { return write!(f, "all {} points lie in it", self.points) };
        let (share, p) = (100.0 * self.outside as f64 / self.points.max(1) as f64, farthest.point);
        write!(
            f,
            "{} of {} points ({share:.2} %) lie outside, {:.2} % may; the farthest deviates by {:+.4} mm at ({:.3}, \
             {:.3}, {:.3}) mm",
            self.outside,
            self.points,
            100.0 * (1.0 - self.tolerance.least_share),
            farthest.distance,
            p.x,
            p.y,
            p.z
        )
    }
}

/// The deviations of the points of a scan, in their order.
#[derive(Debug, Clone, PartialEq)]
pub struct DeviationMap {
    deviations: Vec<Deviation>,
}

/// The deviation of every point of a scan (mm) after `motion`, which brings the scan onto the nominal surface.
///
/// Where the nominal mesh is closed the sign is that of the inside of the metal. Where it is open the sign is that of
/// the normals at the nearest point.
///
/// # Errors
/// [`MeasuredError::TooFewPoints`] for none, [`MeasuredError::NotFinite`] and [`MeasuredError::Cancelled`].
pub fn deviations(
    nominal: &Nominal,
    points: &[DVec3],
    motion: &DAffine3,
    task: &Task,
) -> Result<DeviationMap, MeasuredError> {
    if points.is_empty() {
        return Err(MeasuredError::TooFewPoints { found: 0, needed: 1 });
    }
    let deviation = |p: &DVec3| {
        let point = motion.transform_point3(*p);
        let nearest = nominal.nearest(point);
        Deviation { point, nearest: nearest.point, distance: nearest.signed_distance, triangle: nearest.triangle }
    };
    let blocks = points.par_chunks(BLOCK).enumerate().map(|(k, block)| {
        task.check()?;
        if let Some(i) = block.iter().position(|p| !motion.transform_point3(*p).is_finite()) {
            return Err(MeasuredError::NotFinite { number: k * BLOCK + i + 1 });
        }
        Ok(block.iter().map(deviation).collect::<Vec<_>>())
    });
    task.report("deviations", 0.0, "");
    let deviations = blocks.collect::<Result<Vec<_>, MeasuredError>>()?.concat();
    task.report("deviations", 1.0, "");
    Ok(DeviationMap { deviations })
}

impl DeviationMap {
    /// The deviations, in the order of the points.
    pub fn list(&self) -> &[Deviation] {
        &self.deviations
    }

    /// The deviations of the points within `reach_mm` of the nominal surface, and the number of the others: what a
    /// scanner saw of a fixture.
    pub fn within_reach(&self, reach_mm: f64) -> (Self, usize) {
        let near = self.deviations.iter().filter(|d| d.distance.abs() <= reach_mm).copied();
        let deviations: Vec<Deviation> = near.collect();
        let others = self.deviations.len() - deviations.len();
        (Self { deviations }, others)
    }

    /// Statistics of all points.
    pub fn statistics(&self, tolerance: &Tolerance) -> Statistics {
        Statistics::of(self.deviations.iter().map(|d| d.distance), tolerance)
    }

    /// Statistics of the points of each surface, by the label that `surface` gives to a deviation.
    pub fn statistics_by<L: Ord>(
        &self,
        tolerance: &Tolerance,
        surface: impl Fn(&Deviation) -> L,
    ) -> BTreeMap<L, Statistics> {
        let mut groups: BTreeMap<L, Vec<f64>> = BTreeMap::new();
        for deviation in &self.deviations {
            groups.entry(surface(deviation)).or_default().push(deviation.distance);
        }
        groups.into_iter().map(|(label, group)| (label, Statistics::of(group.into_iter(), tolerance))).collect()
    }

    /// The worst places, at most `count`, the greatest excess over the tolerance first, then the greatest distance. No
    /// two are nearer to each other than `spacing_mm`, so that one bump does not fill the list.
    pub fn worst<L>(
        &self,
        count: usize,
        spacing_mm: f64,
        tolerance: &Tolerance,
        surface: impl Fn(&Deviation) -> L,
    ) -> Vec<Worst<L>> {
        let badness = |d: &Deviation| (tolerance.excess(d.distance), d.distance.abs());
        let mut order: Vec<&Deviation> = self.deviations.iter().collect();
        order.par_sort_by(|a, b| {
            let ((excess, size), (other_excess, other_size)) = (badness(a), badness(b));
            let place = |d: &Deviation| d.point.to_array();
            let by_place = || place(a).iter().zip(&place(b)).map(|(x, y)| x.total_cmp(y)).find(|order| order.is_ne());
            let worse = other_excess.total_cmp(&excess).then(other_size.total_cmp(&size));
            worse.then_with(|| by_place().unwrap_or(std::cmp::Ordering::Equal))
        });
        let mut worst: Vec<Worst<L>> = Vec::new();
        for deviation in order {
            if worst.len() == count {
                break;
            }
            if worst.iter().all(|w| w.deviation.point.distance(deviation.point) >= spacing_mm) {
                worst.push(Worst { deviation: *deviation, surface: surface(deviation) });
            }
        }
        worst
    }

    /// Whether the part keeps the tolerance. A map without points does not.
    pub fn verdict(&self, tolerance: &Tolerance) -> Verdict {
        let statistics = self.statistics(tolerance);
        let points = statistics.points;
        let outside = points - statistics.within;
        let farthest = self.worst(1, 0.0, tolerance, |_| ()).first().map(|w| w.deviation);
        Verdict {
            is_within: points > 0 && statistics.share_within >= tolerance.least_share,
            tolerance: *tolerance,
            points,
            outside,
            farthest: farthest.filter(|_| outside > 0),
        }
    }
}
