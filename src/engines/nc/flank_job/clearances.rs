//! The checks of what the tool may touch nowhere: the surface itself from elsewhere, walls, and both on the way to the
//! path and away from it.

use glam::DVec3;

use super::result::{CheckKind, FlankCheck, FlankResult};
use flank::gouge::{Clearance, ToolPart};

/// In words, as many as the flutes, for the verbs behind.
fn part_name(part: ToolPart) -> String {
    match part {
        ToolPart::Cutter => "the flutes".to_owned(),
        ToolPart::Holder(i) => format!("the sides of part {} of the holder", i + 1),
    }
}

/// Finding on approach or retraction that is not allowed.
struct OnLead {
    /// How much more than nothing it is (mm).
    by_mm: f64,
    point: DVec3,
    text: String,
}

/// Approach and retraction against the surface itself, and against walls if there are any: the worse of both comes
/// first.
pub(super) fn leads(result: &FlankResult) -> FlankCheck {
    let tolerance = result.plan.params.gouge_tolerance_mm;
    let (own, wall) = (own_on_leads(result), nearest_on_leads(result));
    let excess_mm = own.as_ref().map_or(0.0, |own| own.by_mm);
    let depth_mm = wall.map_or(0.0, |(_, wall)| result.chordal_deviation_mm - wall.distance_mm);
    let in_wall = wall.filter(|_| depth_mm > tolerance).map(|(name, Clearance { part, point, .. })| OnLead {
        by_mm: depth_mm,
        point,
        text: format!(
            "on the {name} {} go {depth_mm:.4} mm deep into a wall; allowed: {tolerance} mm{}; change lead-in or \
             retract distance (--aside, --retract), or move the walls away",
            part_name(part),
            with_deviation(result)
        ),
    });
    let mut found: Vec<OnLead> = own.into_iter().chain(in_wall).collect();
    found.sort_by(|a, b| b.by_mm.total_cmp(&a.by_mm));
    if let Some(worst) = found.first() {
        let text = found.iter().map(|found| found.text.as_str()).collect::<Vec<_>>().join("; ");
        let check = FlankCheck::new(CheckKind::Leads, false, text).at(worst.point);
        return check.with(&[("own_excess_mm", excess_mm), ("depth_mm", depth_mm)]);
    }
    let Some((_, Clearance { part, point, .. })) = wall else {
        let near = if result.lead_gouge.iter().any(Option::is_some) { "; no wall is near them" } else { "" };
        let text = format!("approach and retraction cut the surface itself nowhere deeper than the path's ends{near}");
        return FlankCheck::new(CheckKind::Leads, true, text);
    };
    let part = part_name(part);
    let text = if depth_mm > 0.0 {
        format!(
            "on approach and retraction {part} go {depth_mm:.4} mm deep into a wall; allowed: {tolerance} mm{}; the \
             surface itself is cut nowhere deeper than by the path's ends",
            with_deviation(result)
        )
    } else {
        format!("on approach and retraction {part} keep {:.4} mm away from walls and off the surface itself", -depth_mm)
    };
    FlankCheck::new(CheckKind::Leads, true, text).at(point)
}

/// Where approach and retraction cut the surface itself deeper than the ends of the path do.
fn own_on_leads(result: &FlankResult) -> Option<OnLead> {
    let tolerance = result.plan.params.gouge_tolerance_mm;
    let own = LEADS.into_iter().zip(result.lead_own).filter_map(|(name, own)| Some((name, own?)));
    let (name, own) = own.max_by(|a, b| a.1.excess_mm().total_cmp(&b.1.excess_mm()))?;
    let text = format!(
        "on the {name} {} cut the surface itself {:.4} mm deep at u = {:.4}, v = {:.4}, where the end of the path cuts \
         {:.4} mm; {tolerance} mm more are allowed; shorten the lead-in (--aside), or take a thinner cutter",
        part_name(own.part),
        own.depth_mm,
        own.u,
        own.v,
        own.expected_mm
    );
    Some(OnLead { by_mm: own.excess_mm(), point: own.point, text })
}

/// Names of the moves, in the order of the results.
const LEADS: [&str; 2] = ["approach", "retraction"];

/// The least clearance from walls on them, and on which.
fn nearest_on_leads(result: &FlankResult) -> Option<(&'static str, Clearance)> {
    let near = LEADS.into_iter().zip(result.lead_gouge).flat_map(|(name, gouge)| {
        gouge.into_iter().flat_map(|g| [g.cutter, g.holder]).flatten().map(move |clearance| (name, clearance))
    });
    near.min_by(|a, b| a.1.distance_mm.total_cmp(&b.1.distance_mm))
}

/// Share of a depth that comes from the chordal deviation of straight moves, in words.
fn with_deviation(result: &FlankResult) -> String {
    format!(", including {:.4} mm chordal deviation", result.chordal_deviation_mm)
}

/// The whole tool against the surface itself all along the path.
pub(super) fn own_surface(result: &FlankResult) -> FlankCheck {
    let own = &result.own_surface;
    let ([_, across], [_, usual]) = (own.grid, result.checked.deviation.grid);
    let mut text = own.text();
    if across < usual {
        text += &format!("; {across} samples on each ruling, where the other checks have {usual}");
    }
    let check = FlankCheck::new(CheckKind::Surface, own.holds(), text);
    match own.worst {
        Some(worst) => {
            FlankCheck { t: Some(worst.t), ..check.at(worst.point) }.with(&[("excess_mm", worst.excess_mm())])
        }
        None => check,
    }
}

/// Flutes and holder against walls all along the path. The straight moves that are written may bring the tool nearer by
/// as much as they leave the path.
pub(super) fn gouge(result: &FlankResult) -> Vec<FlankCheck> {
    let Some(gouge) = &result.gouge else { return Vec::new() };
    let tolerance = result.plan.params.gouge_tolerance_mm;
    let one = |kind, what: &str, clearance: Option<Clearance>| {
        let Some(Clearance { part, distance_mm, point, t }) = clearance else {
            return FlankCheck::new(kind, true, format!("nothing is near the {what}"));
        };
        let (part, depth_mm) = (part_name(part), result.chordal_deviation_mm - distance_mm);
        let text = if depth_mm > 0.0 {
            format!("{part} go {depth_mm:.4} mm deep at t = {t:.4}; allowed: {tolerance} mm{}", with_deviation(result))
        } else {
            format!("{part} keep {:.4} mm away, nearest at t = {t:.4}", -depth_mm)
        };
        let check = FlankCheck::new(kind, depth_mm <= tolerance, text).at(point);
        FlankCheck { t: Some(t), ..check }.with(&[("depth_mm", depth_mm)])
    };
    let mut checks = vec![one(CheckKind::Gouge, "flutes", gouge.cutter)];
    if !result.plan.cutter.holder.is_empty() {
        checks.push(one(CheckKind::Holder, "holder", gouge.holder));
    }
    checks
}
