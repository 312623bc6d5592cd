//! What is asked of electrodes, what they came to, and their export.

use egui::{ComboBox, DragValue, RichText, TextEdit, Ui, vec2};

use super::super::super::commands::Command;
use super::super::super::core::Core;
use super::super::super::panel_parts::named;
use super::super::super::stepper::{command_button, fact, notice, sentence};
use super::super::super::theme::{palette, tick};
use crate::export::electrode_files::ElectrodeFormat;
use crate::jobs::pipeline::StageState;
use crate::mold::electrode::params::{ElectrodeParams, Holder, Orbit, Shape, Stage};

/// Height of a row (points).
const HEIGHT: f32 = 22.0;
/// Gap that another rough stage begins with (mm), and its finish (VDI 3400).
const ROUGH: (f64, f64) = (0.25, 32.0);

/// Draws it.
pub fn show(ui: &mut Ui, core: &mut Core) {
    let mut params = core.mold.params.clone();
    let asked = &mut params.electrodes;
    stages(ui, asked);
    ui.add_space(4.0);
    lengths(ui, asked);
    holders(ui, asked, &core.mold.electrodes.holders);
    if let Err(problem) = asked.validate() {
        let text = RichText::new(sentence(&problem.to_string())).small().color(palette(ui).bad);
        ui.add(egui::Label::new(text).wrap());
    }
    // Which meet nothing is known of what was made with them.
    let made = core.mold.electrodes.designed().filter(|made| made.set.params.edits == asked.edits);
    edits(ui, asked, &made.map_or_else(Vec::new, |made| made.set.unmet_edits()));
    core.mold.edit(params);
    answer(ui, core);
}

fn number(ui: &mut Ui, value: &mut f64, (most, width): (f64, f32), name: &str) {
    let field = DragValue::new(value).speed(0.01).range(0.0..=most).max_decimals(3).update_while_editing(false);
    let response = ui.add_sized(vec2(width, HEIGHT), field).on_hover_text(name);
    ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(name));
}

fn stages(ui: &mut Ui, asked: &mut ElectrodeParams) {
    let mut removed = None;
    let several = asked.stages.len() > 1;
    ui.scope(|ui| {
        ui.spacing_mut().item_spacing = vec2(4.0, 2.0);
        egui::Grid::new("stages").num_columns(6).min_col_width(0.0).show(ui, |ui| {
            for head in ["stage", "gap", "orbit", "radius", "VDI", ""] {
                ui.label(RichText::new(head).small().color(palette(ui).faint));
            }
            ui.end_row();
            for (i, stage) in asked.stages.iter_mut().enumerate() {
                let of = |what: &str| format!("{what} of stage {}", i + 1);
                let field = TextEdit::singleline(&mut stage.name).desired_width(70.0);
                let response = ui.add_sized(vec2(70.0, HEIGHT), field);
                ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(of("Name")));
                number(ui, &mut stage.gap_mm, (5.0, 50.0), &of("Gap"));
                orbit(ui, &mut stage.orbit, i);
                let mut radius = stage.orbit.radius_mm();
                ui.add_enabled_ui(radius > 0.0, |ui| number(ui, &mut radius, (5.0, 50.0), &of("Radius of orbit")));
                match &mut stage.orbit {
                    Orbit::None => {}
                    Orbit::Circular { radius_mm } | Orbit::Square { radius_mm } => *radius_mm = radius.max(0.001),
                }
                number(ui, &mut stage.finish_vdi, (50.0, 44.0), &of("Finish"));
                let remove = ui.add_enabled(several, egui::Button::new("\u{00d7}").small());
                if remove.on_hover_text("Remove this stage").clicked() {
                    removed = Some(i);
                }
                ui.end_row();
            }
        });
    });
    if let Some(i) = removed {
        asked.stages.remove(i);
    }
    if ui.button("Add a rough stage").on_hover_text("Burned before the others").clicked() {
        let is_free = |name: &String| asked.stages.iter().all(|s| s.name != *name);
        let names = std::iter::once("rough".to_owned()).chain((2..100).map(|i| format!("rough{i}")));
        let name = names.into_iter().find(is_free).unwrap_or_default();
        asked.stages.insert(0, Stage { name, finish_vdi: ROUGH.1, ..Stage::finish(ROUGH.0) });
    }
}

fn orbit(ui: &mut Ui, orbit: &mut Orbit, i: usize) {
    let name = match orbit {
        Orbit::None => "none",
        Orbit::Circular { .. } => "circle",
        Orbit::Square { .. } => "square",
    };
    let radius_mm = orbit.radius_mm().max(0.05);
    let all = [Orbit::None, Orbit::Circular { radius_mm }, Orbit::Square { radius_mm }];
    ComboBox::from_id_salt(("orbit", i)).selected_text(name).width(64.0).show_ui(ui, |ui| {
        for (kind, text) in all.into_iter().zip(["none", "circle", "square"]) {
            if ui.selectable_label(text == name, text).clicked() && text != name {
                *orbit = kind;
            }
        }
    });
}

fn lengths(ui: &mut Ui, asked: &mut ElectrodeParams) {
    for (name, value, most, hint) in [
        ("Margin", &mut asked.margin_mm, 20.0, "How far tips reach beyond what is left, where the mold leaves room"),
        ("Extension", &mut asked.extension_mm, 1000.0, "From the mold's top to the base"),
        ("Base height", &mut asked.base_height_mm, 1000.0, "Least height of the base"),
        ("Base margin", &mut asked.base_margin_mm, 1000.0, "How far the base reaches beyond the tips"),
        ("Lift", &mut asked.lift_mm, 10000.0, "How far an electrode is lifted"),
    ] {
        length(ui, name, value, most, hint);
    }
    named(ui, "Places", |ui, _| {
        tick(ui, &mut asked.share, "share").on_hover_text("One electrode for congruent places");
        let mut is_together = asked.together_mm > 0.0;
        let hint = "Tips that lie near one another stand on one base, up to this width";
        tick(ui, &mut is_together, "together up to").on_hover_text(hint);
        if is_together != (asked.together_mm > 0.0) {
            asked.together_mm = if is_together { ElectrodeParams::default().together_mm } else { 0.0 };
        }
        ui.add_enabled_ui(is_together, |ui| number(ui, &mut asked.together_mm, (1000.0, 50.0), "Together up to"));
    });
    named(ui, "Stages", |ui, _| {
        let several = asked.stages.len() > 1;
        ui.add_enabled_ui(several, |ui| {
            tick(ui, &mut asked.family, "on one base, apart by").on_hover_text(
                "A family: electrodes of all stages for the same places on one base, with this room between their tips",
            );
        });
        ui.add_enabled_ui(several && asked.family, |ui| {
            number(ui, &mut asked.family_spacing_mm, (1000.0, 50.0), "Room between stages");
        });
    });
    named(ui, "Files hold", |ui, _| {
        for (shape, name, hint) in [
            (Shape::Undersized, "undersized", "The electrode as it is made: smaller by gap and orbit"),
            (Shape::Net, "net", "The shape of the cavity; the gap is an attribute"),
        ] {
            ui.selectable_value(&mut asked.shape, shape, name).on_hover_text(hint);
        }
    });
    named(ui, "Material", |ui, label| {
        ui.add(TextEdit::singleline(&mut asked.material).desired_width(120.0)).labelled_by(label);
    });
}

fn length(ui: &mut Ui, name: &str, value: &mut f64, most: f64, hint: &str) {
    named(ui, name, |ui, label| {
        let field = DragValue::new(value).speed(0.05).range(0.0..=most).max_decimals(3).update_while_editing(false);
        ui.add_sized(vec2(74.0, HEIGHT), field).labelled_by(label).on_hover_text(hint);
        ui.label(RichText::new("mm").color(palette(ui).faint));
    });
}

/// Holders by name; those chosen are tried in the order of the list. One always stays chosen.
fn holders(ui: &mut Ui, asked: &mut ElectrodeParams, known: &[Holder]) {
    let own = asked.holders.iter().filter(|h| known.iter().all(|k| k.name != h.name));
    let all: Vec<Holder> = known.iter().chain(own).cloned().collect();
    ui.label(RichText::new("Holders").color(palette(ui).faint));
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
    ui.label(RichText::new("Changes").color(palette(ui).faint));
    let mut removed = None;
    for (i, edit) in asked.edits.iter().enumerate() {
        ui.horizontal(|ui| {
            if ui.small_button("\u{00d7}").on_hover_text("Take this change back").clicked() {
                removed = Some(i);
            }
            if unmet.contains(&i) {
                let text = RichText::new(format!("meets no region: {edit}")).color(palette(ui).warning);
                ui.add(egui::Label::new(text).truncate()).on_hover_text("It meets no region, or changes nothing in it");
            } else {
                ui.add(egui::Label::new(edit.to_string()).truncate());
            }
        });
    }
    if let Some(i) = removed {
        asked.edits.remove(i);
    }
}

/// What they came to.
fn answer(ui: &mut Ui, core: &mut Core) {
    let state = core.mold.design_state();
    if let StageState::Failed(why) = &state {
        notice(ui, palette(ui).bad, why);
    }
    let Some(made) = core.mold.electrodes.designed().cloned() else {
        let text = "Design makes electrodes for what the cutters leave; it is found first if it has to be.";
        ui.add(egui::Label::new(RichText::new(text).small().color(palette(ui).faint)).wrap());
        return;
    };
    let said = made.sentence(&core.mold.params.electrodes.overrides);
    let colours = palette(ui);
    if core.mold.is_designed() {
        let is_warned = made.report.table.electrodes.iter().any(|e| !e.warnings.is_empty());
        let is_good = made.report.holds && !is_warned && made.report.unmet_edits.is_empty();
        notice(ui, if is_good { colours.good } else { colours.warning }, &said);
    } else {
        notice(ui, colours.warning, &format!("Of other parameters: {said}"));
    }
    fact(ui, "All burns", format!("{:.0} min", made.set.minutes()));
    ui.horizontal(|ui| {
        for (format, is_on) in ElectrodeFormat::ALL.into_iter().zip(&mut core.mold.electrodes.formats) {
            tick(ui, is_on, format.extension().to_uppercase());
        }
        command_button(ui, core, Command::Export, "Export\u{2026}", false);
    });
    let blocked = |e: &usize| !core.mold.electrodes.is_let_pass(*e, &core.mold.params.electrodes);
    let names: Vec<&str> =
        (0..made.set.electrodes.len()).filter(blocked).map(|e| made.set.electrodes[e].name.as_str()).collect();
    if !names.is_empty() {
        let text = format!("Not exported, for a check fails: {}", names.join(", "));
        ui.add(egui::Label::new(RichText::new(text).small().color(colours.bad)).wrap());
    }
}
