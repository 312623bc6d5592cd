//! What is asked of electrodes, what they came to, and their export.

use crate::workspaces::commands::FrameCommand;
use crate::workspaces::context::Context;
use crate::workspaces::mold::panels::MoldDesk;
use std::path::Path;

use egui::{CollapsingHeader, RichText, TextEdit, Ui};

use super::super::cutters;
use super::fields::{Figure, figure, measure, sizes};
use super::stages;
use crate::widgets::panel_parts::named;
use crate::widgets::panel_parts::{fact, notice, sentence};
use crate::widgets::theme::{palette, tick};
use crate::workspaces::mold::paths::MoldPath;
use crate::workspaces::mold::report::why_unmet;
use mold::cutter::CutterLibrary;
use mold::electrode::params::{ElectrodeParams, Holder, Removal, Shape};
use nc::burn_template::BurnSheet;
use nc::electrode_files::ElectrodeFormat;

/// Draws it. Answers what a path is wanted for.
pub fn show(ui: &mut Ui, desk: &mut MoldDesk, cx: &mut Context) -> Option<MoldPath> {
    let mut params = desk.document.params().clone();
    let asked = &mut params.electrodes;
    stages::show(ui, asked);
    tips(ui, asked);
    sharing(ui, asked);
    bases(ui, asked);
    files(ui, asked);
    folded(ui, "Blanks and holders", |ui| {
        blanks(ui, asked);
        holders(ui, asked, &desk.electrodes.holders);
    });
    folded(ui, "Cutters for electrodes", |ui| {
        own_cutters(ui, asked, &params.library, &mut desk.electrodes.cutter);
    });
    folded(ui, "Burning times", |ui| removal(ui, &mut asked.removal));
    if let Err(problem) = asked.validate() {
        let text = RichText::new(sentence(&problem.to_string())).small().color(palette(ui).bad);
        ui.add(egui::Label::new(text).wrap());
    }
    // Which meet nothing is known of what was made with them.
    let made = desk.electrodes.designed().filter(|made| made.set.params.edits == asked.edits);
    edits(ui, asked, &made.map_or_else(Vec::new, |made| made.set.unmet_edits()));
    desk.edit(params);
    answer(ui, desk, cx)
}

/// The name of fields that belong together.
fn heading(ui: &mut Ui, name: &str) {
    ui.add_space(4.0);
    ui.label(RichText::new(name).small().color(palette(ui).faint));
}

/// Fields that few need to touch.
fn folded(ui: &mut Ui, name: &str, body: impl FnOnce(&mut Ui)) {
    CollapsingHeader::new(name).id_salt(("electrodes", name)).show_unindented(ui, body);
}

fn tips(ui: &mut Ui, asked: &mut ElectrodeParams) {
    heading(ui, "Heads");
    for (name, value, range, hint) in [
        (
            "Side extension",
            &mut asked.margin_mm,
            0.01..=20.0,
            "Distance by which heads extend beyond the uncut region, where the mold allows it",
        ),
        (
            "Clearance above mold",
            &mut asked.extension_mm,
            0.1..=1000.0,
            "From the top of the mold to the electrode base",
        ),
        ("Overlap", &mut asked.overlap_mm, 0.0..=20.0, "Overlap of the parts of a divided region"),
        (
            "Least size",
            &mut asked.least_size_mm,
            0.0..=1000.0,
            "Least width of a part; a region is not divided into narrower ones",
        ),
        (
            "Allowed rest",
            &mut asked.tolerance_mm,
            1e-4..=1.0,
            "Residual stock allowed across the surface, beyond what the spark gap's radius leaves in corners",
        ),
    ] {
        measure(ui, name, value, (range, "mm", hint));
    }
}

/// What electrodes have in common.
fn sharing(ui: &mut Ui, asked: &mut ElectrodeParams) {
    let room =
        |least: f64, hint| Figure { range: least..=1000.0, speed: 0.05, width: 50.0, suffix: "", decimals: 4, hint };
    named(ui, "Identical places", |ui, _| {
        tick(ui, &mut asked.share, "share").on_hover_text("Reuse one electrode at identical places");
        let mut is_together = asked.together_mm > 0.0;
        let hint = "Neighbouring heads share a base up to this width (mm)";
        tick(ui, &mut is_together, "group within").on_hover_text(hint);
        if is_together != (asked.together_mm > 0.0) {
            asked.together_mm = if is_together { ElectrodeParams::default().together_mm } else { 0.0 };
        }
        ui.add_enabled_ui(is_together, |ui| figure(ui, &mut asked.together_mm, "Group within", &room(0.0, hint)));
    });
    named(ui, "Stages", |ui, _| {
        let several = asked.stages.len() > 1;
        ui.add_enabled_ui(several, |ui| {
            tick(ui, &mut asked.family, "on one base, distance").on_hover_text(
                "Family: electrodes of all stages for the same places on one base, at this distance of their heads",
            );
        });
        let hint = "Least distance between the heads of a family (mm)";
        ui.add_enabled_ui(several && asked.family, |ui| {
            figure(ui, &mut asked.family_spacing_mm, "Distance between stages", &room(0.1, hint));
        });
    });
}

fn bases(ui: &mut Ui, asked: &mut ElectrodeParams) {
    heading(ui, "Base");
    let largest_corner = asked.base_margin_mm.max(0.0);
    for (name, value, range, hint) in [
        ("Base height", &mut asked.base_height_mm, 0.5..=1000.0, "Least height of the base; the blank is rounded up"),
        ("Base margin", &mut asked.base_margin_mm, 0.1..=1000.0, "Distance by which the base extends beyond the heads"),
        (
            "Orientation chamfer",
            &mut asked.datum_corner_mm,
            0.0..=largest_corner,
            "Chamfer at the corner +X +Y that shows the orientation, along each side; 0 for none",
        ),
        (
            "Retract distance",
            &mut asked.lift_mm,
            0.0..=10000.0,
            "Distance by which the electrode is retracted after the burn",
        ),
    ] {
        measure(ui, name, value, (range, "mm", hint));
    }
}

fn files(ui: &mut Ui, asked: &mut ElectrodeParams) {
    heading(ui, "Files");
    named(ui, "Export", |ui, _| {
        for (shape, name, hint) in [
            (
                Shape::Undersized,
                "undersized",
                "With spark gap: the electrode as it is milled, smaller by the undersize",
            ),
            (Shape::Net, "net", "Without spark gap: the net shape; the undersize is stated in the burn table"),
        ] {
            ui.selectable_value(&mut asked.shape, shape, name).on_hover_text(hint);
        }
    });
    named(ui, "Material", |ui, label| {
        ui.add(TextEdit::singleline(&mut asked.material).desired_width(120.0)).labelled_by(label);
    });
    ui.add_space(4.0);
}

fn blanks(ui: &mut Ui, asked: &mut ElectrodeParams) {
    let blanks = &mut asked.blanks;
    sizes(ui, "Sides", &mut blanks.sides_mm, "Sides of rectangular blanks");
    let hint = "Diameters of round blanks; used where a round blank is smaller than the rectangular one";
    sizes(ui, "Diameters", &mut blanks.diameters_mm, hint);
    let hint = "Lengths, and sides beyond the largest, are rounded up to this";
    measure(ui, "Increment", &mut blanks.increment_mm, (0.1..=100.0, "mm", hint));
}

/// The cutters that mill electrodes: those of the mold, or others.
fn own_cutters(ui: &mut Ui, asked: &mut ElectrodeParams, of_mold: &CutterLibrary, selected: &mut usize) {
    let mut are_of_mold = asked.cutters.is_none();
    let hint = "The library of the mold also mills the electrodes";
    if tick(ui, &mut are_of_mold, "same as the mold").on_hover_text(hint).changed() {
        asked.cutters = (!are_of_mold).then(|| of_mold.clone());
    }
    if let Some(library) = &mut asked.cutters {
        cutters::table(ui, library, selected, "electrode cutter");
        ui.horizontal_wrapped(|ui| cutters::buttons(ui, library, selected));
    }
}

fn removal(ui: &mut Ui, removal: &mut Removal) {
    for (name, value, range, unit, hint) in [
        (
            "Rate",
            &mut removal.per_area_mm_min,
            1e-4..=1000.0,
            "mm/min",
            "Removal rate for each area of a head seen along the burn, at the finish below",
        ),
        ("At most", &mut removal.most_mm3_min, 1e-3..=1e5, "mm³/min", "Limit for all heads of an electrode together"),
        ("At a finish", &mut removal.at_vdi, 0.1..=60.0, "VDI", "Finish for which both figures hold"),
        (
            "Tenfold by",
            &mut removal.tenfold_vdi,
            0.1..=60.0,
            "VDI",
            "How much rougher a finish burns ten times as fast",
        ),
        ("Setting", &mut removal.setting_min, 0.0..=1000.0, "min", "For each burn: positioning, rinsing, measuring"),
    ] {
        measure(ui, name, value, (range, unit, hint));
    }
}

/// Holders by name; those chosen are tried in the order of the list. One always stays chosen.
fn holders(ui: &mut Ui, asked: &mut ElectrodeParams, known: &[Holder]) {
    let own = asked.holders.iter().filter(|h| known.iter().all(|k| k.name != h.name));
    let all: Vec<Holder> = known.iter().chain(own).cloned().collect();
    heading(ui, "Holders, of which the first that is large enough is taken");
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
                if !chosen.is_empty() {
                    asked.holders = chosen;
                }
                break;
            }
        }
    });
}

/// The changes that the user made to the division, each of which can be taken away; those at the places `unmet` do nothing.
fn edits(ui: &mut Ui, asked: &mut ElectrodeParams, unmet: &[usize]) {
    if asked.edits.is_empty() {
        return;
    }
    ui.label(RichText::new("Changes to the division").color(palette(ui).faint));
    let mut removed = None;
    for (i, edit) in asked.edits.iter().enumerate() {
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
        asked.edits.remove(i);
    }
}

/// What they came to, and how it is written.
fn answer(ui: &mut Ui, desk: &mut MoldDesk, cx: &mut Context) -> Option<MoldPath> {
    let state = desk.design_state();
    if let Some(why) = state.why_not() {
        notice(ui, palette(ui).bad, why);
    }
    let Some(made) = desk.electrodes.designed().cloned() else {
        let text = "\"Create electrodes\" designs electrodes for the rest material; the rest material is found first if needed.";
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
    fact(ui, "All burns", format!("{:.0} min", made.set.minutes()));
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
