//! What is exported of a flank, and what stands in its way.

use egui::{RichText, Ui};

use super::super::core::Core;
use super::super::dialogs::{Answer, from_right};
use super::super::theme::{palette, tick};
use super::results;
use crate::export::flank_nc::milling_post;

/// Draws it.
pub fn show(ui: &mut Ui, core: &mut Core) -> Option<Answer> {
    let mut answer = None;
    let planned = core.flank.work.to_export(&core.flank.params);
    let post = milling_post(&core.flank.params.milling.post);
    let ending = post.map_or_else(|_| "nc".to_owned(), |post| post.extension);
    let has_machine = planned.as_ref().is_ok_and(|result| result.milled().is_some());
    egui::Grid::new("flank files").num_columns(2).min_col_width(150.0).spacing([12.0, 6.0]).show(ui, |ui| {
        let choice = &mut core.flank.choice;
        let says = |ui: &mut Ui, text: &str| drop(ui.label(RichText::new(text).color(palette(ui).faint)));
        tick(ui, &mut choice.cl, RichText::new("flank.cl").monospace());
        says(ui, "cutter locations, APT");
        ui.end_row();
        ui.add_enabled_ui(has_machine, |ui| {
            tick(ui, &mut choice.nc, RichText::new(format!("flank.{ending}")).monospace())
        });
        says(ui, if has_machine { "program for the machine" } else { "no machine has a path" });
        ui.end_row();
        tick(ui, &mut choice.csv, RichText::new("path.csv").monospace());
        says(ui, "locations with their deviations");
        ui.end_row();
        tick(ui, &mut choice.report, RichText::new("report.html, .json").monospace());
        says(ui, "figures, maps, curves, checks");
        ui.end_row();
    });
    ui.add_space(8.0);
    let why = planned.as_ref().map_or_else(|why| Some(why.clone()), |result| result.why_blocked());
    let text = match &why {
        Some(why) => RichText::new(format!("Blocked: {why}")).color(palette(ui).bad),
        None if !core.flank.choice.any() => {
            RichText::new("Nothing is chosen, so that nothing would be written.").color(palette(ui).bad)
        }
        None => {
            let text = "Files of an earlier path in the folder are replaced, or get .old behind their names.";
            RichText::new(text).color(palette(ui).warning)
        }
    };
    ui.add(egui::Label::new(text).wrap());
    if let Ok(result) = &planned {
        for check in result.checks.iter().filter(|check| !check.holds) {
            results::let_pass(ui, core, check, check.is_overridden);
        }
    }
    ui.add_space(10.0);
    from_right(ui, |ui| {
        let is_possible = why.is_none() && core.flank.choice.any();
        if ui.add_enabled(is_possible, egui::Button::new("Choose folder…")).clicked() {
            answer = Some(Answer::ExportFlankTo);
        }
        if ui.button("Cancel").clicked() {
            answer = Some(Answer::Close);
        }
    });
    answer
}
