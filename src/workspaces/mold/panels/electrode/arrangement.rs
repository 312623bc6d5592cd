//! The selected electrode as the user arranges it: its heads, name, holder, blank and material.

use egui::{CollapsingHeader, ComboBox, DragValue, RichText, TextEdit, Ui};
use glam::DVec3;

use crate::widgets::panel_parts::named;
use crate::widgets::theme::palette;
use crate::workspaces::mold::document::MoldParams;
use crate::workspaces::mold::panels::desk::MoldDesk;
use crate::workspaces::mold::work::Designed;
use mold::electrode::design::{Electrode, PartId};
use mold::electrode::given::{Given, numbered};
use mold::electrode::params::Edit;

/// Draws the arrangement of an electrode.
pub fn show(ui: &mut Ui, desk: &mut MoldDesk, made: &Designed, electrode: usize) {
    let Some(own) = made.set.electrodes.get(electrode) else { return };
    CollapsingHeader::new("Arrangement").id_salt("arrangement").show_unindented(ui, |ui| {
        ui.horizontal_wrapped(|ui| {
            join(ui, desk, made, electrode);
            take_apart(ui, desk, made, own);
            copy(ui, desk, made, own);
        });
        other_way(ui, desk, made, own);
        given(ui, desk, own);
    });
}

/// Changes the parameters.
fn change(desk: &mut MoldDesk, with: impl FnOnce(&mut MoldParams)) {
    let mut params = desk.document.params().clone();
    with(&mut params);
    desk.edit(params);
}

/// A place of each of these parts that changes name it by.
fn places(made: &Designed, parts: &[PartId]) -> Vec<DVec3> {
    parts.iter().filter_map(|id| made.leaves(id.region).get(id.part).copied().flatten()).collect()
}

/// Parts of the first burn: those that the heads stand over.
fn heads(electrode: &Electrode) -> &[PartId] {
    electrode.burns.first().map_or(&[], |burn| &burn.parts)
}

fn join(ui: &mut Ui, desk: &mut MoldDesk, made: &Designed, electrode: usize) {
    let own = &made.set.electrodes[electrode];
    let others = made
        .set
        .electrodes
        .iter()
        .filter(|other| other.name != own.name && (other.stage, other.direction) == (own.stage, own.direction));
    let menu = ui.menu_button("Join with", |ui| {
        for other in others {
            let first = |e: &Electrode| places(made, heads(e)).first().copied();
            let Some((a, b)) = first(own).zip(first(other)) else { continue };
            if ui.button(&other.name).clicked() {
                change(desk, |params| params.electrodes.edits.push(Edit::Join { places: [a, b] }));
                ui.close();
            }
        }
    });
    menu.response.on_hover_text("The heads of another electrode and these stand on one base");
}

fn take_apart(ui: &mut Ui, desk: &mut MoldDesk, made: &Designed, own: &Electrode) {
    let all: Vec<DVec3> = places(made, &own.parts());
    let button = ui.add_enabled(all.len() > 1, egui::Button::new("Take apart"));
    let why_not = if own.parts().len() > 1 {
        "Only electrodes of the last stage that burn straight down are taken apart"
    } else {
        "It has one head that burns one place"
    };
    let button = button.on_disabled_hover_text(why_not);
    if button.on_hover_text("An electrode of its own for each place").clicked() {
        let apart = all.iter().map(|place| Edit::TakeApart { place: *place });
        change(desk, |params| params.electrodes.edits.extend(apart));
    }
}

fn copy(ui: &mut Ui, desk: &mut MoldDesk, made: &Designed, own: &Electrode) {
    let from = places(made, heads(own)).first().copied();
    let parts = own.parts();
    let is_other = |e: &&Electrode| (e.stage, e.direction) == (own.stage, own.direction);
    let mut others: Vec<PartId> = made.set.electrodes.iter().filter(is_other).flat_map(Electrode::parts).collect();
    others.retain(|part| !parts.contains(part));
    others.sort_unstable();
    let menu = ui.menu_button("Copy to", |ui| {
        for other in others {
            let Some((a, b)) = from.zip(places(made, &[other]).first().copied()) else { continue };
            if ui.button(other.to_string()).clicked() {
                change(desk, |params| params.electrodes.edits.push(Edit::Copy { places: [a, b] }));
                ui.close();
            }
        }
    });
    menu.response.on_hover_text("The electrode also burns the same place of another cavity");
}

/// The other way to burn places of one shape, with its figures.
fn other_way(ui: &mut Ui, desk: &mut MoldDesk, made: &Designed, own: &Electrode) {
    let Some(way) = &own.other_way else { return };
    let is_current = made.set.params.edits == desk.document.params().electrodes.edits;
    ui.horizontal_wrapped(|ui| {
        ui.add(
            egui::Label::new(RichText::new(way.sentence(own.figures.minutes)).small().color(palette(ui).faint)).wrap(),
        );
        let hint = "Puts the heads on one base. It is taken back under \"Changes to the division\".";
        if !way.is_of_burns()
            && ui.add_enabled(is_current, egui::Button::new("Several heads").small()).on_hover_text(hint).clicked()
        {
            let of = |burn: &usize| places(made, &own.burns[*burn].parts).first().copied();
            let sets: Vec<Vec<DVec3>> = way.at_once.iter().map(|set| set.iter().filter_map(of).collect()).collect();
            let pairs =
                sets.iter().flat_map(|set| set.windows(2).map(|pair| Edit::Join { places: [pair[0], pair[1]] }));
            change(desk, |params| params.electrodes.edits.extend(pairs));
        }
    });
}

/// Name, number, holder, blank and material.
fn given(ui: &mut Ui, desk: &mut MoldDesk, own: &Electrode) {
    let params = desk.document.params();
    let Some(at) = params.electrodes.names.iter().position(|name| name.number == own.number) else { return };
    let mut given = params.electrodes.names[at].given.clone();
    let mut number = given.number.unwrap_or(own.number);
    let before = given.clone();
    let common = params.electrodes.material.clone();
    let holders: Vec<String> = params.electrodes.holders.iter().map(|holder| holder.name.clone()).collect();
    named(ui, "Name", |ui, label| name(ui, label, &mut given, own));
    named(ui, "Number", |ui, _| {
        ui.add(DragValue::new(&mut number).range(1..=9999).update_while_editing(false));
    });
    named(ui, "Holder", |ui, _| {
        let shown = given.holder.clone().unwrap_or_else(|| "first that fits".to_owned());
        ComboBox::from_id_salt("holder of electrode").selected_text(shown).show_ui(ui, |ui| {
            ui.selectable_value(&mut given.holder, None, "first that fits");
            for holder in &holders {
                ui.selectable_value(&mut given.holder, Some(holder.clone()), holder);
            }
        });
    });
    named(ui, "Blank", |ui, _| blank(ui, &mut given, own));
    named(ui, "Material", |ui, label| text(ui, label.with(own.number), label, &mut given.material, &common));
    given.number = (number != own.number).then_some(number);
    if given != before {
        change(desk, |params| params.electrodes.give(at, given));
    }
}

/// Sides of the blank: of the list of blanks, or given.
fn blank(ui: &mut Ui, given: &mut Given, own: &Electrode) {
    let mut is_given = given.blank_mm.is_some();
    ui.horizontal(|ui| {
        if ui.checkbox(&mut is_given, "own").on_hover_text("Sides other than those of the list of blanks").changed() {
            given.blank_mm = is_given.then_some([own.blank.x, own.blank.y]);
        }
        for side in given.blank_mm.iter_mut().flatten() {
            ui.add(DragValue::new(side).range(1.0..=1000.0).speed(0.5).suffix(" mm").update_while_editing(false));
        }
    });
}

/// The name: characters that no file name may carry become hyphens.
fn name(ui: &mut Ui, label: egui::Id, given: &mut Given, own: &Electrode) {
    let common = numbered(given.number.unwrap_or(own.number));
    text(ui, label.with(own.number), label, &mut given.name, &common);
    let plain = |c: char| if c.is_ascii_alphanumeric() || c == '_' { c } else { '-' };
    // The usual name is none of its own.
    given.name = given.name.take().map(|name| name.chars().map(plain).collect()).filter(|name| *name != common);
}

/// A text beside a label that is taken when it is left; empty for what is common to all.
fn text(ui: &mut Ui, id: egui::Id, label: egui::Id, value: &mut Option<String>, common: &str) {
    let mut now = ui.data_mut(|d| d.get_temp(id)).unwrap_or_else(|| value.clone().unwrap_or_default());
    let edit = ui.add(TextEdit::singleline(&mut now).hint_text(common).desired_width(120.0)).labelled_by(label);
    if edit.has_focus() {
        ui.data_mut(|d| d.insert_temp(id, now));
    } else {
        ui.data_mut(|d| d.remove::<String>(id));
        if edit.lost_focus() {
            *value = Some(now.trim().to_owned()).filter(|text| !text.is_empty());
        }
    }
}
