//! Comparison with other cutters.

use crate::workspaces::context::Context;
use crate::workspaces::mold::commands::MoldCommand;
use crate::workspaces::mold::panels::desk::MoldDesk;
use egui::{Grid, RichText, Ui};

use super::cutters;
use crate::widgets::form::Form;
use crate::widgets::panel_parts::notice;
use crate::widgets::theme::palette;
use crate::workspaces::mold::document::fields::LIBRARY;
use crate::workspaces::mold::job::compare::Comparison;
use crate::workspaces::mold::paths::MoldPath;
use files::Validate as _;
use mold::cutter::Cutter;

/// Draws the comparison. Returns the path that the user is to choose.
pub fn show(ui: &mut Ui, desk: &mut MoldDesk, cx: &mut Context) -> Option<MoldPath> {
    let mut asked = None;
    ui.horizontal_wrapped(|ui| {
        if ui.button("Copy the present cutters").on_hover_text("Start the comparison from them").clicked() {
            desk.other = desk.document.params().library.clone();
        }
        if ui.button("Load…").on_hover_text("Another library of cutters (TOML)").clicked() {
            asked = Some(MoldPath::OtherCutters);
        }
        // The question that is asked most.
        if ui.button("Add a ball of 1 mm").clicked() {
            desk.other.cutter.push(Cutter::ball(0.5));
        }
    });
    let mut form = Form::new(&LIBRARY, &desk.other, desk.other.validate().err().as_ref());
    cutters::table(ui, &mut form, "cutter");
    let answer = form.answer();
    if let Some(edit) = answer.edit {
        desk.other = edit.params;
    }
    answer.said.into_iter().for_each(|said| cx.say_in_passing(said));
    cx.button(ui, desk, MoldCommand::CompareCutters, "Compare", false);
    let (mold, colours) = (&*desk, palette(ui));
    if let Some(why) = mold.work.comparison_state(mold.document.params(), &mold.other).why_not() {
        notice(ui, colours.bad, why);
    }
    if let Some(other) = mold.work.other().cloned() {
        let sentence = other.1.sentence();
        if mold.work.is_other_of(mold.document.params(), &mold.other) {
            notice(ui, colours.accent, &sentence);
        } else {
            notice(ui, colours.warning, &format!("Out of date: {sentence}"));
        }
        figures(ui, &other.1);
    }
    asked
}

/// Regions and volumes of both libraries side by side.
fn figures(ui: &mut Ui, comparison: &Comparison) {
    let faint = palette(ui).faint;
    let ([now, other], [volume, other_volume]) = (comparison.regions, comparison.volumes);
    Grid::new("comparison of cutters").num_columns(4).spacing([18.0, 3.0]).striped(true).show(ui, |ui| {
        for head in ["", "present", "other", "removed"] {
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
