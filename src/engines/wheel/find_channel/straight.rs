//! Blades that turn no flow, as gears, splines, spokes and struts have none that do.

use super::super::channel::Channel;
use super::super::passage::Passage;

/// Places along the passage and shares of its height at which the middle of the gap is looked at.
const ALONG: usize = 9;
const HEIGHTS: [f64; 3] = [0.2, 0.5, 0.8];
/// Share of the blades' span at either edge that is not looked at, since edges are rounded.
const EDGE: f64 = 0.15;
/// The middle of a gap is straight where its angle stays within this share of the gap's width.
const STRAIGHT: f64 = 0.03;

/// Whether the middle of the passage stays in one plane through the axis, so that its blades turn no flow.
pub(super) fn is_straight(channel: &Channel) -> bool {
    let Some(passage) = Passage::new(channel) else { return false };
    let [from, to] = passage.span;
    let middle_and_width = |share: f64, height: f64| {
        let along = from + share * (to - from);
        let [hub, shroud] = channel.line_at(along).ends;
        let [low, high] = passage.between(along, hub + height * (shroud - hub));
        (0.5 * (low + high), high - low)
    };
    let shares = (0..ALONG).map(|i| EDGE + (1.0 - 2.0 * EDGE) * i as f64 / (ALONG - 1) as f64);
    let places: Vec<_> = shares.flat_map(|share| HEIGHTS.map(|height| middle_and_width(share, height))).collect();
    let mean = places.iter().map(|(middle, _)| middle).sum::<f64>() / places.len() as f64;
    places.iter().all(|(middle, width)| (middle - mean).abs() < STRAIGHT * width)
}
