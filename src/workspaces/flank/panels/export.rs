//! Dialog of the export of a flank, with its obstacles.

use crate::workspaces::commands::FrameCommand;
use crate::workspaces::context::Context;
use crate::workspaces::flank::panels::desk::FlankDesk;
use egui::{RichText, Ui};

use super::results;
use crate::widgets::panel_parts::file_name;
use crate::widgets::panel_parts::from_right;
use crate::widgets::theme::{palette, tick};
use nc::flank_program::milling_post;

/// Answer of the user.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Answer {
    /// Choose the folder and export.
    Folder,
    /// Close the dialog.
    Close,
}

/// Draws the dialog.
pub fn show(ui: &mut Ui, desk: &mut FlankDesk, cx: &mut Context) -> Option<Answer> {
    let mut answer = None;
    let planned = desk.work.to_export(desk.document.params());
    let post = milling_post(&desk.document.params().milling.post);
    let ending = post.map_or_else(|_| "nc".to_owned(), |post| post.extension);
    let has_machine = planned.as_ref().is_ok_and(|result| result.milled().is_some());
    egui::Grid::new("flank files").num_columns(2).min_col_width(150.0).spacing([12.0, 6.0]).show(ui, |ui| {
        let choice = &mut desk.choice;
        let says = |ui: &mut Ui, text: &str| drop(ui.label(RichText::new(text).color(palette(ui).faint)));
        tick(ui, &mut choice.cl, RichText::new("flank.cl").monospace());
        says(ui, "cutter locations, APT");
        ui.end_row();
        ui.add_enabled_ui(has_machine, |ui| {
            tick(ui, &mut choice.nc, RichText::new(format!("flank.{ending}")).monospace())
        });
        says(
            ui,
            if has_machine { "program for the machine" } else { "no machine was chosen, or it cannot follow the path" },
        );
        ui.end_row();
        tick(ui, &mut choice.csv, RichText::new("path.csv").monospace());
        says(ui, "locations with their deviations");
        ui.end_row();
        tick(ui, &mut choice.report, RichText::new("report.html, .json").monospace());
        says(ui, "figures, maps, curves, checks");
        ui.end_row();
    });
    ui.add_space(8.0);
    changed(ui, desk, cx);
    let blocked = planned.as_ref().ok().and_then(|result| result.why_blocked());
    let text = match (&planned, &blocked) {
        (Err(why), _) => RichText::new(format!("Blocked: {why}")).color(palette(ui).bad),
        (_, Some(why)) => {
            let text = format!("Blocked: {why}. Only the report is written.");
            RichText::new(text).color(palette(ui).bad)
        }
        _ if !desk.choice.any() => RichText::new("No file is chosen: nothing would be written.").color(palette(ui).bad),
        _ => {
            let text = "Files of an earlier path in the folder are removed; those that were changed since are renamed \
                 to .old.";
            RichText::new(text).color(palette(ui).warning)
        }
    };
    ui.add(egui::Label::new(text).wrap());
    if let Ok(result) = &planned {
        for check in result.checks.iter().filter(|check| !check.holds) {
            results::let_pass(ui, desk, (result, check), check.is_overridden);
        }
    }
    ui.add_space(10.0);
    from_right(ui, |ui| {
        let is_possible = planned.is_ok() && desk.choice.any();
        let name = if blocked.is_some() { "Report to folder…" } else { "Choose folder…" };
        if ui.add_enabled(is_possible, egui::Button::new(name)).clicked() {
            answer = Some(Answer::Folder);
        }
        if ui.button("Cancel").clicked() {
            answer = Some(Answer::Close);
        }
    });
    answer
}

/// Warning about files that have changed since they were read.
fn changed(ui: &mut Ui, desk: &mut FlankDesk, cx: &mut Context) {
    if desk.changed_files.is_empty() {
        return;
    }
    let names: Vec<String> = desk.changed_files.iter().map(|file| file_name(&file.to_string_lossy())).collect();
    let text =
        format!("Changed or gone since read: {}. What is exported was planned for what was read.", names.join(", "));
    ui.add(egui::Label::new(RichText::new(text).color(palette(ui).warning)).wrap());
    if ui.button("Reload").on_hover_text("Reads all files again; then plan again").clicked() {
        cx.push(FrameCommand::Reload);
        desk.changed_files.clear();
    }
    ui.add_space(4.0);
}
