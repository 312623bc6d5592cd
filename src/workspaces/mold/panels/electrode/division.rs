//! Division of regions into parts, and the user's changes of it.

use crate::workspaces::mold::panels::desk::MoldDesk;
use std::ops::RangeInclusive;

use egui::{ComboBox, DragValue, RichText, Ui, vec2};
use glam::DVec3;

use super::checks;
use crate::widgets::theme::palette;
use crate::workspaces::mold::report::{Division, division_of};
use crate::workspaces::mold::scene::division::NodeAt;
use crate::workspaces::mold::work::Designed;
use mold::electrode::burn_direction::{BurnProposal, along, angles_deg};
use mold::electrode::params::{Edit, Method};
use mold::electrode::residual_stock::LeftOfRegion;

/// Explanation of a part that is divided.
const DIVIDED: &str = "The head is cut here. H-edges are inner edges of the head that no cutter mills; those that run on \
    from one another are a chain. The cut goes along a face, enlarged. The draft is the angle by which this face leans \
    from the burn direction. By the overlap the part beyond the cut reaches back over it. The view shows the chains and \
    the cut; click to keep them emphasised.";
/// Explanation of splitting along a face.
const ALONG_FACE: &str = "One click on a steep face of the mold: the part nearest to it is cut along this face, enlarged, \
    with its draft. Clicked beside a chain of H-edges that lies on the face, the cut takes the chain away.";

/// Draws the division of these regions of an electrode, counted from 1.
pub fn show(ui: &mut Ui, desk: &mut MoldDesk, made: &Designed, (electrode, regions): (usize, &[usize])) {
    for region in regions {
        region_of(ui, desk, made, (electrode, region - 1));
    }
}

fn region_of(ui: &mut Ui, desk: &mut MoldDesk, made: &Designed, (electrode, r): (usize, usize)) {
    let Some(plan) = made.set.regions.get(r) else { return };
    ui.add_space(4.0);
    ui.horizontal_wrapped(|ui| {
        ui.label(RichText::new(format!("Region {}", r + 1)).strong());
        if let Some(place) = made.places.get(r).copied().flatten() {
            method(ui, desk, (r, place), plan.method);
            let is_current = made.set.params.edits == desk.document.params().electrodes.edits;
            let now = if is_current { plan.direction } else { DVec3::NEG_Z };
            direction(ui, desk, (r, place), (now, plan.proposal.filter(|_| is_current)));
        }
        if ui
            .small_button("Split\u{2026}")
            .on_hover_text("Along a line: two clicks on the mold, seen from above")
            .clicked()
        {
            desk.electrodes.begin_split(r);
        }
        if ui.small_button("Divide along a face\u{2026}").on_hover_text(ALONG_FACE).clicked() {
            desk.electrodes.begin_split_along(r);
        }
        let hint = "No electrode for this region. It is taken back under \"Changes to the division\".";
        if let Some(place) = made.places.get(r).copied().flatten()
            && ui.small_button("Set aside").on_hover_text(hint).clicked()
        {
            let mut params = desk.document.params().clone();
            params.electrodes.edits.push(Edit::SetAside { place });
            desk.edit(params);
        }
    });
    left(ui, desk, &plan.left, (electrode, r));
    let axes = desk.params().datum.of_upright(made.opening);
    if let Some(division) = division_of(&made.set, r, &axes) {
        let (places, mut leaf, mut number) = (made.leaves(r), 0, 0);
        node(ui, desk, &division, (r, 0), (&mut leaf, &mut number), &places);
        // Parts of a region that was divided otherwise in the meantime are chosen no more.
        desk.electrodes.parts.retain(|part| part.0 != r || part.1 < leaf);
    }
}

/// Residual stock of a region, and the place of the greatest.
fn left(ui: &mut Ui, desk: &mut MoldDesk, left: &LeftOfRegion, (electrode, r): (usize, usize)) {
    ui.horizontal(|ui| {
        let is_somewhere = left.thickness > 0.0;
        let name = format!("Show the thickest residual stock of region {}", r + 1);
        let button = ui.add_enabled_ui(is_somewhere, |ui| checks::show_button(ui, &name)).inner;
        if button.clicked()
            && let Some(mold) = desk.work.mold()
        {
            let bounds = mold.shape.bounds();
            let text = format!("region {}: {}", r + 1, in_words(left));
            desk.electrodes.point_at_burn(electrode, (left.place, text), &bounds);
        }
        let text = format!("residual stock up to {:.4} mm, {:.4} mm³", left.thickness, left.volume);
        ui.label(RichText::new(text).small().color(palette(ui).faint));
    });
}

/// Residual stock at the place of the greatest.
fn in_words(left: &LeftOfRegion) -> String {
    /// Less than what four decimals show (mm).
    const NOTHING: f64 = 5e-5;
    let LeftOfRegion { thickness, excess, .. } = *left;
    if excess >= thickness {
        format!("residual stock {thickness:.4} mm")
    } else if excess >= NOTHING {
        format!("residual stock {excess:.4} mm beyond the corner radius of the spark")
    } else {
        format!("residual stock {thickness:.4} mm in a corner rounded by the spark")
    }
}

/// From where a region is burned: along `now`, unless a change says otherwise. Another direction than straight down is
/// one. A button takes the proposal.
fn direction(
    ui: &mut Ui,
    desk: &mut MoldDesk,
    (r, place): (usize, DVec3),
    (now, proposal): (DVec3, Option<BurnProposal>),
) {
    let own = |edit: &Edit| matches!(edit, Edit::Burn { place: of, .. } if *of == place);
    let mut params = desk.document.params().clone();
    let edits = &mut params.electrodes.edits;
    let asked = edits.iter().rev().find_map(|e| match e {
        Edit::Burn { direction, .. } if own(e) => direction.try_normalize(),
        _ => None,
    });
    let [mut tilt, mut towards] = angles_deg(asked.unwrap_or(now));
    let of = |what: &str| format!("{what} of the burn of region {}", r + 1);
    let hint = "Tilt of the burn from straight down; 90\u{b0} is from the side";
    let mut changed = angle(ui, &mut tilt, 0.0..=90.0, &of("Tilt"), hint);
    if tilt > 0.0 {
        let hint = "Direction of the tilted burn in plan, from +X towards +Y of the upright mold";
        changed |= angle(ui, &mut towards, -180.0..=180.0, &of("Heading"), hint);
    }
    if let Some(proposal) = proposal {
        let hint = format!("Another burn direction of the region: {proposal}").replace(" deg", "\u{b0}");
        if ui.small_button("Use proposal").on_hover_text(hint).clicked() {
            ([tilt, towards], changed) = (angles_deg(proposal.direction), true);
        }
    }
    if changed {
        edits.retain(|edit| !own(edit));
        if tilt > 0.0 {
            edits.push(Edit::Burn { place, direction: along(tilt, towards) });
        }
        desk.edit(params);
    }
}

/// An angle called `name` (degrees). Returns whether it was changed.
fn angle(ui: &mut Ui, value: &mut f64, range: RangeInclusive<f64>, name: &str, hint: &str) -> bool {
    let field = DragValue::new(value).speed(0.5).range(range).clamp_existing_to_range(false);
    let field = field.max_decimals(2).suffix("\u{b0}").update_while_editing(false);
    let response = ui.add_sized(vec2(46.0, 22.0), field);
    ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(name));
    response.on_hover_text(hint).changed()
}

/// Method of making the tips of a region; another choice is a change.
fn method(ui: &mut Ui, desk: &mut MoldDesk, (r, place): (usize, DVec3), now: Method) {
    let own = |edit: &Edit| matches!(edit, Edit::Make { place: of, .. } if *of == place);
    let mut params = desk.document.params().clone();
    let edits = &mut params.electrodes.edits;
    let asked = edits
        .iter()
        .rev()
        .find_map(|e| if let Edit::Make { method, .. } = e { own(e).then_some(*method) } else { None });
    let before = asked.unwrap_or(now);
    let name = |method| if method == Method::Extruding { "extruded" } else { "cut" };
    let mut chosen = before;
    let combo = ComboBox::from_id_salt(("method", r)).selected_text(name(before)).width(78.0);
    combo.show_ui(ui, |ui| {
        ui.selectable_value(&mut chosen, Method::Extruding, "extruded")
            .on_hover_text("Extrude the outline of the region; for regions of whole faces");
        ui.selectable_value(&mut chosen, Method::Cutting, "cut")
            .on_hover_text("A box around the region, trimmed by the faces");
    });
    if chosen != before {
        edits.retain(|edit| !own(edit));
        edits.push(Edit::Make { place, method: chosen });
        desk.edit(params);
    }
}

/// A part and what it is divided into; a part that is not divided can be chosen to be merged.
fn node(
    ui: &mut Ui,
    desk: &mut MoldDesk,
    division: &Division,
    (r, depth): (usize, usize),
    (leaf, number): (&mut usize, &mut usize),
    places: &[Option<DVec3>],
) {
    let part = (r, *leaf);
    let at = NodeAt { region: r, number: *number };
    *number += 1;
    ui.horizontal(|ui| {
        ui.add_space(12.0 * depth as f32);
        if !division.parts.is_empty() {
            let is_on = desk.electrodes.node == Some(at);
            let text = RichText::new(&division.text).small().color(palette(ui).faint);
            let button = ui.add(egui::Button::selectable(is_on, text).wrap()).on_hover_text(DIVIDED);
            if button.contains_pointer() {
                desk.electrodes.hovered = Some(at);
            }
            if button.clicked() {
                desk.electrodes.node = (!is_on).then_some(at);
            }
            return;
        }
        let is_there = places.get(*leaf).is_some_and(Option::is_some) && places.len() > 1;
        let is_on = desk.electrodes.parts.contains(&part);
        let button = egui::Button::selectable(is_on, RichText::new(&division.text).small());
        let why_not = if places.len() > 1 {
            "Parts of a region that is burned straight down can be merged"
        } else {
            "The region has no other part to merge with"
        };
        let button = ui.add_enabled(is_there, button).on_disabled_hover_text(why_not);
        // What cannot be merged is shown as well.
        if button.contains_pointer() {
            desk.electrodes.hovered = Some(at);
        }
        let hint = if division.h_edges > 0 {
            "Select two parts to merge them. The H-edges of this part, inner edges that no cutter mills, are shown in the \
             view"
        } else {
            "Select two parts to merge them"
        };
        if button.on_hover_text(hint).clicked() {
            desk.electrodes.node = (!is_on).then_some(at);
            let parts = &mut desk.electrodes.parts;
            if is_on {
                parts.retain(|other| *other != part);
            } else {
                // Parts of one region only, and two of them.
                parts.retain(|other| other.0 == r);
                parts.truncate(1);
                parts.push(part);
            }
        }
        *leaf += 1;
    });
    // Beside what was chosen last, where the hand is.
    if division.parts.is_empty()
        && let [one, last] = desk.electrodes.parts[..]
        && last == part
    {
        merge(ui, desk, [one, last].map(|(_, part)| places.get(part).copied().flatten()));
    }
    for part in &division.parts {
        node(ui, desk, part, (r, depth + 1), (&mut *leaf, &mut *number), places);
    }
}

/// Offers to make the parts at two places one.
fn merge(ui: &mut Ui, desk: &mut MoldDesk, places: [Option<DVec3>; 2]) {
    let [Some(a), Some(b)] = places else { return };
    if ui.button("Merge the two parts").clicked() {
        let mut params = desk.document.params().clone();
        params.electrodes.edits.push(Edit::Merge { places: [a, b] });
        desk.electrodes.parts.clear();
        desk.edit(params);
    }
}
