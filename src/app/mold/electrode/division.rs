//! How regions are divided into parts, and what the user changes about that.

use egui::{ComboBox, RichText, Ui};
use glam::DVec3;

use super::super::super::core::Core;
use super::super::super::theme::palette;
use crate::export::electrode_report::Division;
use crate::jobs::mold::Designed;
use crate::mold::electrode::params::{Edit, Method};

/// Draws it for these regions, counted from 1.
pub fn show(ui: &mut Ui, core: &mut Core, made: &Designed, regions: &[usize]) {
    for region in regions {
        region_of(ui, core, made, region - 1);
    }
    merge(ui, core, made);
}

fn region_of(ui: &mut Ui, core: &mut Core, made: &Designed, r: usize) {
    let (Some(plan), Some(entry)) = (made.set.regions.get(r), made.report.regions.get(r)) else { return };
    ui.add_space(4.0);
    ui.horizontal(|ui| {
        ui.label(RichText::new(format!("Region {}", r + 1)).strong());
        if let Some(place) = made.places.get(r).copied().flatten() {
            method(ui, core, (r, place), plan.method);
        }
        if ui
            .small_button("Split\u{2026}")
            .on_hover_text("Along a line: two clicks on the mold, seen from above")
            .clicked()
        {
            core.mold.electrodes.begin_split(r);
        }
    });
    let left = format!("{:.4} mm left at most, {:.4} mm³", plan.left.thickness, plan.left.volume);
    ui.label(RichText::new(left).small().color(palette(ui).faint));
    if let Some(division) = &entry.division {
        let (places, mut leaf) = (made.leaves(r), 0);
        node(ui, core, division, (r, 0), &mut leaf, &places);
    }
}

/// How the tips of a region are made; another choice is a change.
fn method(ui: &mut Ui, core: &mut Core, (r, place): (usize, DVec3), now: Method) {
    let own = |edit: &Edit| matches!(edit, Edit::Make { place: of, .. } if *of == place);
    let mut params = core.mold.params.clone();
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
            .on_hover_text("The region's own outline led up: for regions of whole faces");
        ui.selectable_value(&mut chosen, Method::Cutting, "cut")
            .on_hover_text("A box around the region, trimmed by the faces");
    });
    if chosen != before {
        edits.retain(|edit| !own(edit));
        edits.push(Edit::Make { place, method: chosen });
        core.mold.edit(params);
    }
}

/// A part and what it is divided into; a part that is not divided can be chosen to be merged.
fn node(
    ui: &mut Ui,
    core: &mut Core,
    division: &Division,
    (r, depth): (usize, usize),
    leaf: &mut usize,
    places: &[Option<DVec3>],
) {
    ui.horizontal(|ui| {
        ui.add_space(12.0 * depth as f32);
        if !division.parts.is_empty() {
            ui.add(egui::Label::new(RichText::new(&division.text).small().color(palette(ui).faint)).wrap());
            return;
        }
        let part = (r, *leaf);
        let is_there = places.get(*leaf).is_some_and(Option::is_some) && places.len() > 1;
        let parts = &mut core.mold.electrodes.parts;
        let is_on = parts.contains(&part);
        let button = egui::Button::selectable(is_on, RichText::new(&division.text).small());
        if ui.add_enabled(is_there, button).on_hover_text("Select two parts to merge them").clicked() {
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
    for part in &division.parts {
        node(ui, core, part, (r, depth + 1), leaf, places);
    }
}

fn merge(ui: &mut Ui, core: &mut Core, made: &Designed) {
    let [one, other] = core.mold.electrodes.parts[..] else { return };
    let place = |(r, part): (usize, usize)| made.leaves(r).get(part).copied().flatten();
    let (Some(a), Some(b)) = (place(one), place(other)) else { return };
    if ui.button("Merge the two parts").clicked() {
        let mut params = core.mold.params.clone();
        params.electrodes.edits.push(Edit::Merge { places: [a, b] });
        core.mold.electrodes.parts.clear();
        core.mold.edit(params);
    }
}
