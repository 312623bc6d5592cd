//! Blades that may be none, as teeth of gears and splines, spokes, struts, threads of worms and screws; and blades that
//! were not counted.

use std::f64::consts::TAU;

use glam::DVec2;

use super::super::channel::{Channel, Flow};
use super::super::frame::slices::{Gap, Slices};
use super::super::passage::Passage;
use super::sentences::{SCREW, STRAIGHT, uncounted_sentence};

/// Places along the passage and shares of its height at which the middle of the gap is looked at.
const ALONG: usize = 9;
const HEIGHTS: [f64; 3] = [0.2, 0.5, 0.8];
/// Share of the blades' span at either edge that is not looked at, since edges are rounded.
const EDGE: f64 = 0.15;
/// An angle within this share of the gap's width is none.
const SAME: f64 = 0.03;

/// Says that what stands about the axis may be no blades: the middle of the passage stays in one plane through the axis, or
/// winds by one lead at every height and position, with gaps that stay as wide.
pub(super) fn doubt(channel: &Channel) -> Option<&'static str> {
    let passage = Passage::new(channel)?;
    let [from, to] = passage.span;
    let place = |share: f64, height: f64| {
        let along = from + share * (to - from);
        let [hub, shroud] = channel.line_at(along).ends;
        let [low, high] = passage.between(along, hub + height * (shroud - hub));
        (share - 0.5, 0.5 * (low + high), high - low)
    };
    let shares = (0..ALONG).map(|i| EDGE + (1.0 - 2.0 * EDGE) * i as f64 / (ALONG - 1) as f64);
    let rows: Vec<Vec<_>> =
        HEIGHTS.iter().map(|height| shares.clone().map(|share| place(share, *height)).collect()).collect();
    let places = || rows.iter().flatten();
    let mean = places().map(|(_, middle, _)| middle).sum::<f64>() / places().count() as f64;
    let lead = places().map(|(share, middle, _)| share * (middle - mean)).sum::<f64>()
        / places().map(|(share, ..)| share * share).sum::<f64>();
    let winds_by =
        |lead: f64| places().all(|(share, middle, width)| (middle - mean - lead * share).abs() < SAME * width);
    let stays_as_wide =
        |row: &Vec<(f64, f64, f64)>| row.iter().all(|(.., width)| (width / row[0].2 - 1.0).abs() < SAME);
    if winds_by(0.0) {
        return Some(STRAIGHT);
    }
    (channel.flow == Flow::Axial && winds_by(lead) && rows.iter().all(stays_as_wide)).then_some(SCREW)
}

/// Tells of a circle around the axis that crosses more gaps than the counted blades make, and no multiple of their number:
/// blades of another kind, of which some are missing, stand in other passages or behind this one. `slices` are of the wheel
/// in W.
pub(super) fn uncounted(channel: &Channel, slices: &Slices) -> Option<String> {
    /// Stations that are looked at, and how many of them must tell it.
    const PLACES: usize = 24;
    const LEAST: usize = 2;
    /// A gap of less than this share of the pitch is none.
    const NARROW: f64 = 0.02;
    let narrow = NARROW * TAU / channel.blades as f64;
    let more = channel.meridian.iter().step_by(channel.meridian.len().div_ceil(PLACES).max(1)).filter_map(|station| {
        let at = 0.5 * (station.hub + station.shroud);
        let gaps = slices.gaps(at.x, at.y).iter().map(Gap::width).filter(|width| *width > narrow).count();
        (gaps > channel.blades && !gaps.is_multiple_of(channel.blades)).then_some((gaps, at))
    });
    let more: Vec<(usize, DVec2)> = more.collect();
    let (gaps, at) = *more.get(more.len() / 2)?;
    (more.len() >= LEAST).then(|| uncounted_sentence(gaps, channel.blades, at))
}
