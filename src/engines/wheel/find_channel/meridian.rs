//! Hub and shroud along the axis, met by rays along the radius through the channel's middle.

use super::super::channel::MeridianSample;
use super::super::error::BliskError;
use super::super::frame::slices::{Gap, RadialCrossing, Slices};
use super::super::options::BliskOptions;
use task::Cancel;

/// Samples over the whole length of the part. No round number: on parts with round figures a sample would fall
/// on the very edge of the blades, where rounding decides whether they are met.
const STATIONS: f64 = 197.3;
/// Rays across the channel, and the middle share of its width that they stay in, clear of root fillets.
const RAYS: usize = 13;
const MIDDLE_SHARE: f64 = 0.6;
/// Rays that differ from the middle one of them by more than this share of the height met something else.
const SAME_WALL: f64 = 0.03;

/// A place in a channel: a circle and its gap.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub x: f64,
    pub r: f64,
    pub gap: Gap,
}

/// The channel's bounds in the meridional plane.
pub(super) struct Meridian {
    /// In order of rising x.
    pub samples: Vec<MeridianSample>,
    /// Whether a shroud was met.
    pub shrouded: bool,
}

/// One sample and the channel's gap at its middle radius, or at the nearest x where the blades bound it.
#[derive(Clone, Copy)]
struct Station {
    sample: MeridianSample,
    gap: Gap,
}

/// Follows one channel along X.
pub(super) struct Tracer<'a> {
    pub slices: &'a Slices,
    /// Angle from blade to blade (rad).
    pub pitch: f64,
    pub options: &'a BliskOptions,
    pub cancel: &'a Cancel,
}

impl Tracer<'_> {
    /// The gap at (`x`, `r`) that continues `near`, if blades bound it on both sides.
    pub fn bladed_gap(&self, x: f64, r: f64, near: &Gap) -> Option<Gap> {
        // Where one of the two blades is missing the gap reaches to the next one.
        self.slices.gap_near(x, r, near).filter(|g| g.width() < 1.5 * self.pitch)
    }

    /// Hub and shroud along the whole ring, starting from a place between the blades.
    pub fn meridian(&self, start: Place) -> Result<Meridian, BliskError> {
        let missing = |wall, key| BliskError::NoEndWall { wall, key, x: start.x, r: start.r };
        let (hub, shroud) = self.end_walls(&start);
        let shrouded = shroud.is_some();
        let hub = self.options.hub_radius_mm.given().or(hub).ok_or(missing("hub", "hub_radius_mm"))?;
        let tip = || self.tip_radius(&start, start.r);
        let shroud = self.options.shroud_radius_mm.given().or(shroud).unwrap_or_else(tip);
        if hub >= shroud {
            return Err(BliskError::NoHeight { hub, shroud });
        }
        let first = Station { sample: MeridianSample { x: start.x, hub, shroud }, gap: start.gap };
        let bounds = self.slices.mesh().bounds();
        let step = bounds.size().x / STATIONS;
        let mut samples = self.march(first, -step, bounds.min.x, shrouded)?;
        samples.reverse();
        samples.push(first.sample);
        samples.extend(self.march(first, step, bounds.max.x, shrouded)?);
        Ok(Meridian { samples, shrouded })
    }

    /// Samples beyond `from` in steps of `step` up to where an end wall ends, which is found exactly.
    fn march(&self, mut from: Station, step: f64, end: f64, shrouded: bool) -> Result<Vec<MeridianSample>, BliskError> {
        let mut samples = Vec::new();
        loop {
            self.cancel.check()?;
            let x = if step > 0.0 { (from.sample.x + step).min(end) } else { (from.sample.x + step).max(end) };
            let Some(next) = (x != end).then(|| self.station(x, &from, shrouded)).flatten() else {
                let (mut good, mut bad) = (from, x);
                while (bad - good.sample.x).abs() > 1e-9 * step.abs() {
                    match self.station(0.5 * (good.sample.x + bad), &good, shrouded) {
                        Some(station) => good = station,
                        None => bad = 0.5 * (good.sample.x + bad),
                    }
                }
                if good.sample.x != from.sample.x {
                    samples.push(good.sample);
                }
                return Ok(samples);
            };
            samples.push(next.sample);
            from = next;
        }
    }

    /// The end walls at `x`, beside a known station; none where one of them has ended.
    fn station(&self, x: f64, near: &Station, shrouded: bool) -> Option<Station> {
        let r = 0.5 * (near.sample.hub + near.sample.shroud);
        let bladed = self.bladed_gap(x, r, &near.gap);
        let place = Place { x, r, gap: bladed.unwrap_or(near.gap) };
        let (hub, shroud) = self.end_walls(&place);
        let tip = || bladed.map_or(near.sample.shroud, |_| self.tip_radius(&place, near.sample.shroud));
        let shroud = if shrouded { shroud? } else { tip() };
        let sample = MeridianSample {
            x,
            hub: self.options.hub_radius_mm.given().or(hub)?,
            shroud: self.options.shroud_radius_mm.given().unwrap_or(shroud),
        };
        (sample.hub < sample.shroud).then_some(Station { sample, gap: place.gap })
    }

    /// Radii of the hub and of the shroud at a place: the greatest and the least that its rays meet.
    fn end_walls(&self, place: &Place) -> (Option<f64>, Option<f64>) {
        let middle = place.gap.middle();
        let half = 0.5 * MIDDLE_SHARE * place.gap.width().min(self.pitch);
        let theta = |i: usize| middle + half * (2.0 * i as f64 / (RAYS - 1) as f64 - 1.0);
        let rays: Vec<Vec<RadialCrossing>> = (0..RAYS).map(|i| self.slices.ray(place.x, theta(i))).collect();
        let inner = rays.iter().filter_map(|ray| ray.iter().rfind(|c| c.r < place.r));
        let outer = rays.iter().filter_map(|ray| ray.iter().find(|c| c.r > place.r));
        // A ray that starts within the solid meets the wall from behind.
        let inner = sorted(inner.filter(|c| !c.enters).map(|c| c.r));
        let outer = sorted(outer.filter(|c| c.enters).map(|c| c.r));
        let most = |v: &[f64]| (2 * v.len() > RAYS).then(|| v[v.len() / 2]);
        let (hub, shroud) = (most(&inner), most(&outer));
        let same = SAME_WALL * (shroud.unwrap_or(place.r) - hub.unwrap_or(place.r));
        // Between its facets a hub stands out at corners, which rays miss.
        let corners = || self.slices.corner_radii(place.x, middle, half);
        let greatest = |h: f64| inner.iter().copied().chain(corners()).filter(|r| *r <= h + same).fold(h, f64::max);
        (hub.map(greatest), shroud.and_then(|s| outer.iter().find(|&&r| r >= s - same)).copied())
    }

    /// The greatest radius at which blades still bound the channel at a place; it is sought around `guess`.
    fn tip_radius(&self, place: &Place, guess: f64) -> f64 {
        let step = self.slices.cell_size().y;
        let (mut good, mut gap) = (place.r, place.gap);
        let below = guess - step;
        if below > good
            && let Some(next) = self.bladed_gap(place.x, below, &gap)
        {
            (good, gap) = (below, next);
        }
        let mut bad = loop {
            match self.bladed_gap(place.x, good + step, &gap) {
                Some(next) => (good, gap) = (good + step, next),
                None => break good + step,
            }
        };
        while bad - good > 1e-6 * step {
            let r = 0.5 * (good + bad);
            match self.bladed_gap(place.x, r, &gap) {
                Some(next) => (good, gap) = (r, next),
                None => bad = r,
            }
        }
        good
    }
}

fn sorted(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values
}
