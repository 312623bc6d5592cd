//! Form of the electrodes, their result, and their export.

use crate::workspaces::commands::FrameCommand;
use crate::workspaces::context::Context;
use crate::workspaces::mold::commands::MoldCommand;
use crate::workspaces::mold::panels::desk::MoldDesk;
use std::path::Path;

use egui::{CollapsingHeader, Grid, RichText, Ui};

use super::super::cutters;
use crate::widgets::form::{Form, heading};
use crate::widgets::panel_parts::{fact, notice};
use crate::widgets::theme::{palette, tick};
use crate::workspaces::mold::document::MoldParams;
use crate::workspaces::mold::document::fields::FIELDS;
use crate::workspaces::mold::paths::MoldPath;
use crate::workspaces::mold::report::why_unmet;
use burning::figures::minutes_text;
use mold::electrode::params::Holder;
use nc::electrode_files::ElectrodeFormat;
use nc::template::BurnSheet;

/// Draws the form. Returns the path that the user is to choose.
pub fn show(ui: &mut Ui, desk: &mut MoldDesk, cx: &mut Context) -> Option<MoldPath> {
    let mut form = Form::new(&FIELDS, desk.document.params(), desk.document.problem());
    for group in ["Stages", "Heads", "Sharing", "Base", "Files", "Blanks"] {
        form.group(ui, group);
    }
    sort_blanks(&mut form);
    folded(ui, "Holders", |ui| holders(ui, &mut form, &desk.electrodes.holders));
    folded(ui, "Cutters for electrodes", |ui| own_cutters(ui, &mut form));
    form.group(ui, "Burning times");
    form.group(ui, "Set-up sheet");
    // Which meet nothing is known of what was made with them.
    let made = desk.electrodes.designed().filter(|made| made.set.params.edits == form.params().electrodes.edits);
    edits(ui, &mut form, &made.map_or_else(Vec::new, |made| made.set.unmet_edits()));
    let changed = form.answer();
    let asked = changed.wanted.is_some().then_some(MoldPath::Technology);
    desk.take(changed, cx);
    cx.button(ui, desk, MoldCommand::Technology, "Technology table\u{2026}", false);
    answer(ui, desk, cx).or(asked)
}

/// Fields that few need to touch.
fn folded(ui: &mut Ui, name: &str, body: impl FnOnce(&mut Ui)) {
    CollapsingHeader::new(name).id_salt(("electrodes", name)).show_unindented(ui, body);
}

/// Sizes are typed in any order.
fn sort_blanks(form: &mut Form<MoldParams>) {
    let blanks = &form.params().electrodes.blanks;
    if ![&blanks.sides_mm, &blanks.diameters_mm].iter().all(|sizes| sizes.is_sorted_by(|a, b| a < b)) {
        form.change(|params| {
            let blanks = &mut params.electrodes.blanks;
            for sizes in [&mut blanks.sides_mm, &mut blanks.diameters_mm] {
                sizes.sort_by(f64::total_cmp);
                sizes.dedup();
            }
        });
    }
}

/// The cutters that mill electrodes: those of the mold, or others.
fn own_cutters(ui: &mut Ui, form: &mut Form<MoldParams>) {
    let mut are_of_mold = form.params().electrodes.cutters.is_none();
    let hint = "The library of the mold also mills the electrodes";
    if tick(ui, &mut are_of_mold, "same as the mold").on_hover_text(hint).changed() {
        form.change(|params| params.electrodes.cutters = (!are_of_mold).then(|| params.library.clone()));
    }
    cutters::table(ui, form, "electrodes.cutters.cutter");
}

/// Holders by name; those chosen are tried in the order of the list. One always stays chosen.
fn holders(ui: &mut Ui, form: &mut Form<MoldParams>, known: &[Holder]) {
    let asked = &form.params().electrodes;
    let own = asked.holders.iter().filter(|h| known.iter().all(|k| k.name != h.name));
    let all: Vec<Holder> = known.iter().chain(own).cloned().collect();
    let mut taken = None;
    heading(ui, "The first that is large enough is taken");
    ui.horizontal_wrapped(|ui| {
        for holder in &all {
            let is_on = asked.holders.iter().any(|h| h.name == holder.name);
            let [x, y] = holder.size_mm;
            let response = ui.selectable_label(is_on, &holder.name);
            let hint = format!("Blanks up to {x} × {y} mm, {} mm high", holder.height_mm);
            if response.on_hover_text(hint).clicked() {
                let is_chosen = |h: &Holder| (h.name == holder.name) != asked.holders.iter().any(|o| o.name == h.name);
                let chosen: Vec<Holder> = all.iter().filter(|h| is_chosen(h)).cloned().collect();
                // None at all would stand for every one.
                taken = Some(chosen).filter(|chosen| !chosen.is_empty());
            }
        }
    });
    if let Some(taken) = taken {
        form.change(|params| params.electrodes.holders = taken);
    }
}

/// The changes that the user made to the division, each of which can be taken away; those at the places `unmet` do
/// nothing.
fn edits(ui: &mut Ui, form: &mut Form<MoldParams>, unmet: &[usize]) {
    let edits = &form.params().electrodes.edits;
    if edits.is_empty() {
        return;
    }
    ui.label(RichText::new("Changes to the division").color(palette(ui).faint));
    let mut removed = None;
    for (i, edit) in edits.iter().enumerate() {
        ui.horizontal(|ui| {
            if ui.small_button("\u{00d7}").on_hover_text("Remove this change").clicked() {
                removed = Some(i);
            }
            if unmet.contains(&i) {
                let text = format!("{} has no effect: {}", i + 1, why_unmet(edit));
                ui.add(egui::Label::new(RichText::new(text).color(palette(ui).warning)).wrap());
            } else {
                ui.add(egui::Label::new(format!("{} {edit}", i + 1)).truncate());
            }
        });
    }
    if let Some(i) = removed {
        form.change(|params| {
            params.electrodes.edits.remove(i);
        });
    }
}

/// Draws the electrodes that were made, and their export.
fn answer(ui: &mut Ui, desk: &mut MoldDesk, cx: &mut Context) -> Option<MoldPath> {
    let state = desk.design_state();
    if let Some(why) = state.why_not() {
        notice(ui, palette(ui).bad, why);
    }
    let Some(made) = desk.electrodes.designed().cloned() else {
        let text = "\"Create electrodes\" designs electrodes for the rest material; the rest material is found first \
             if needed.";
        ui.add(egui::Label::new(RichText::new(text).small().color(palette(ui).faint)).wrap());
        return None;
    };
    let said = made.sentence(&desk.document.params().electrodes.overrides);
    let colours = palette(ui);
    if desk.is_designed() {
        let is_warned = made.report.table.electrodes.iter().any(|e| !e.warnings.is_empty());
        let is_good = made.report.holds && !is_warned && made.report.unmet_edits.is_empty();
        notice(ui, if is_good { colours.good } else { colours.warning }, &said);
    } else {
        notice(ui, colours.warning, &format!("Out of date: {said}"));
    }
    fact(ui, "All burns", minutes_text(made.set.minutes()));
    divisions(ui, desk, cx);
    let asked = burn_sheet(ui, desk);
    ui.horizontal(|ui| {
        for (format, is_on) in ElectrodeFormat::ALL.into_iter().zip(&mut desk.electrodes.formats) {
            tick(ui, is_on, format.extension().to_uppercase());
        }
        cx.button(ui, desk, FrameCommand::Export, "Export\u{2026}", false);
    });
    let blocked = |e: &usize| !desk.electrodes.is_let_pass(*e, &desk.document.params().electrodes);
    let names: Vec<&str> =
        (0..made.set.electrodes.len()).filter(blocked).map(|e| made.set.electrodes[e].name.as_str()).collect();
    if !names.is_empty() {
        let text = format!("Blocked by a failed check: {}", names.join(", "));
        ui.add(egui::Label::new(RichText::new(text).small().color(colours.bad)).wrap());
    }
    asked
}

/// Ways of dividing side by side.
fn divisions(ui: &mut Ui, desk: &MoldDesk, cx: &mut Context) {
    let params = desk.document.params();
    if let Some(why) = desk.work.divisions_state(params).why_not() {
        notice(ui, palette(ui).bad, why);
    }
    let Some(ways) = desk.work.divisions(params).cloned() else {
        return cx.button(ui, desk, MoldCommand::CompareDivisions, "Compare ways of dividing", false);
    };
    let faint = palette(ui).faint;
    Grid::new("ways of dividing").num_columns(7).spacing([10.0, 3.0]).striped(true).show(ui, |ui| {
        for (head, hint) in [
            ("divided at", "Heads of whole faces: a face that is partly uncut counts as uncut"),
            ("heads", "Heads on all electrodes"),
            ("els.", "Electrodes"),
            ("burns", ""),
            ("min", "All burns with set-up and changing"),
            ("long", "Longest head in plan (mm)"),
            ("\u{2716}", "Electrodes that the cutters do not mill"),
        ] {
            ui.label(RichText::new(head).small().color(faint)).on_hover_text(hint);
        }
        ui.end_row();
        for way in ways.iter() {
            let name = RichText::new(way.way.name()).small();
            ui.label(if way.is_own { name.strong() } else { name });
            if let Some(why) = &way.failure {
                ui.label(RichText::new("none").small().color(palette(ui).bad)).on_hover_text(why);
                ui.end_row();
                continue;
            }
            let figures = [
                way.heads.to_string(),
                way.electrodes.to_string(),
                way.burns.to_string(),
                way.minutes.map_or_else(|| "\u{2013}".to_owned(), |minutes| format!("{minutes:.0}")),
                format!("{:.1}", way.largest_mm),
                way.not_millable.to_string(),
            ];
            figures.into_iter().for_each(|figure| drop(ui.label(RichText::new(figure).small().monospace())));
            ui.end_row();
        }
    });
}

/// The template of the burn sheet.
fn burn_sheet(ui: &mut Ui, desk: &mut MoldDesk) -> Option<MoldPath> {
    let sheet = &mut desk.electrodes.sheet;
    let mut asked = None;
    ui.horizontal(|ui| {
        ui.label("Burn sheet");
        let hint = "Text template (Jinja) with the keys of burn_table.json";
        if ui.small_button("Template\u{2026}").on_hover_text(hint).clicked() {
            asked = Some(MoldPath::BurnSheet);
        }
        let is_standard = sheet.name() == BurnSheet::standard().name();
        if !is_standard && ui.small_button("Built-in").on_hover_text("Use the built-in template").clicked() {
            *sheet = BurnSheet::standard();
        }
        // Last, as it takes what is left of the row.
        let name = Path::new(sheet.name()).file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
        ui.add(egui::Label::new(RichText::new(name).color(palette(ui).faint)).truncate()).on_hover_text(sheet.name());
    });
    asked
}
