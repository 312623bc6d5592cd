//! What other cutters would leave.

use egui::{Grid, RichText, Ui};

use super::super::commands::Command;
use super::super::core::Core;
use super::super::files::Purpose;
use super::super::stepper::{command_button, notice};
use super::super::theme::palette;
use super::cutters;
use crate::jobs::pipeline::StageState;
use crate::jobs::uncut_compare::Comparison;
use crate::mold::cutter::Cutter;

/// Draws it. Answers what a path is wanted for.
pub fn show(ui: &mut Ui, core: &mut Core) -> Option<Purpose> {
    let mut asked = None;
    ui.horizontal_wrapped(|ui| {
        if ui.button("Take the present ones").on_hover_text("As cutters to compare with").clicked() {
            core.mold.other = core.mold.params.library.clone();
        }
        if ui.button("Load…").on_hover_text("Another library of cutters (TOML)").clicked() {
            asked = Some(Purpose::OtherCutters);
        }
        // The question that is asked most.
        if ui.button("Add a ball of 1 mm").clicked() {
            core.mold.other.cutter.push(Cutter::ball(0.5));
        }
    });
    let mold = &mut core.mold;
    cutters::table(ui, &mut mold.other, &mut mold.other_cutter, "other cutter");
    ui.horizontal(|ui| {
        cutters::buttons(ui, &mut core.mold.other, &mut core.mold.other_cutter);
        ui.separator();
        command_button(ui, core, Command::CompareCutters, "Compare", false);
    });
    match core.mold.work.comparison_state(&core.mold.params, &core.mold.other) {
        StageState::Failed(why) => notice(ui, palette(ui).bad, &why),
        StageState::Stale => notice(ui, palette(ui).warning, "What is shown belongs to other parameters."),
        _ => {}
    }
    if let Some(other) = core.mold.work.other().cloned() {
        notice(ui, palette(ui).accent, &other.1.sentence());
        figures(ui, &other.1);
    }
    asked
}

/// Regions and volumes of both libraries side by side.
fn figures(ui: &mut Ui, comparison: &Comparison) {
    let faint = palette(ui).faint;
    let ([now, other], [volume, other_volume]) = (comparison.regions, comparison.volumes);
    Grid::new("comparison of cutters").num_columns(4).spacing([18.0, 3.0]).striped(true).show(ui, |ui| {
        for head in ["", "present", "other", "taken away"] {
            ui.label(RichText::new(head).small().color(faint));
        }
        ui.end_row();
        let number = |ui: &mut Ui, text: String| drop(ui.label(RichText::new(text).monospace()));
        ui.label("Regions");
        number(ui, now.to_string());
        number(ui, other.to_string());
        number(ui, comparison.vanishing().to_string());
        ui.end_row();
        ui.label("Volume mm³");
        number(ui, format!("{volume:.3}"));
        number(ui, format!("{other_volume:.3}"));
        number(ui, format!("{:.3}", volume - other_volume));
        ui.end_row();
    });
}
