//! Stages that others follow. What they have no tip for, as it would be too thin or as the gap leaves no room, is left
//! to those after them: a roughing electrode keeps its thick part, and the finishing one burns the rest alone.

use super::design::LeftOut;
use super::division::{CELL, Part};
use super::footprint::{grown, is_thin};
use super::params::{ElectrodeParams, Stage};
use super::setting::{RegionToBurn, Setting};
use crate::outline::Outline;
use crate::plane;

/// Takes out the parts that are nowhere as thick as `least` (mm), each with its number; what share of a region, given
/// in plan, the others burn, and whether one was taken out that would be thick enough by less than what regions are
/// known to. `is_lacking` says that division has left out parts already.
pub(super) fn thick_only(
    setting: &Setting,
    parts: &mut Vec<(usize, Part)>,
    region: &[Outline],
    (least, is_lacking): (f64, bool),
) -> (f64, bool) {
    let all = parts.len();
    let is_close = |part: &Part| is_thin(&part.footprint.free, least) && !is_thin(&part.footprint.free, least - CELL);
    let is_close = parts.iter().any(|(_, part)| is_close(part));
    parts.retain(|(_, part)| !is_thin(&part.footprint.free, least));
    if parts.is_empty() {
        return (0.0, is_close);
    }
    if parts.len() == all && !is_lacking {
        return (1.0, false);
    }
    let free: Vec<Outline> = parts.iter().flat_map(|(_, part)| part.footprint.free.iter().cloned()).collect();
    let reached = grown(&free, setting.stage.most_across() + CELL);
    let burned: f64 = plane::intersection(&reached, region).iter().map(|shape| plane::area(shape)).sum();
    ((burned / plane::area(region).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0), is_close)
}

/// Report on a stage that has tips for a share of a region only.
pub(super) fn left_to_later(stage: &Stage, number: usize, (share, is_close): (f64, bool), least: f64) -> LeftOut {
    let name = &stage.name;
    let mut text = if share > 0.0 {
        format!(
            "{name} stage: it keeps to what is thick; {:.0} % of the region in plan, where its tip would be thinner \
             than the least size of {least} mm, is burned by the stages after it alone",
            100.0 * (1.0 - share)
        )
    } else {
        format!(
            "{name} stage: left out, its head would be thinner than the least size of {least} mm; the later stages \
             burn alone"
        )
    };
    if is_close {
        text += &format!(
            "; it is so by less than {CELL} mm, to which regions are known, so that one of two places alike may have a \
             tip: a least size that much smaller gives both one"
        );
    }
    LeftOut { stage: number, text }
}

/// Report on a stage whose gap leaves no room for a tip.
pub(super) fn no_room(stage: &Stage, number: usize) -> LeftOut {
    let name = &stage.name;
    let text =
        format!("{name} stage: left out, its spark gap is too large for a head here; the later stages burn alone");
    LeftOut { stage: number, text }
}

/// Whether a region that has no room for a tip needs none: it is about as thin as what counts as burned.
pub(super) fn is_nothing(region: &RegionToBurn, params: &ElectrodeParams) -> bool {
    /// Thickness of such a region, in tolerances.
    const NEAR: f64 = 1.5;
    region.thickness <= NEAR * params.tolerance_mm
}

/// Report on such a region.
pub(super) fn nothing(stage: &Stage, number: usize, thickness: f64) -> LeftOut {
    let name = &stage.name;
    let text = format!(
        "{name} stage: there is nothing to burn, as what is left is {thickness:.4} mm thick, about as thin as the \
         tolerance"
    );
    LeftOut { stage: number, text }
}
