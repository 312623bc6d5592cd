//! The status bar: work under way with its progress and time left, the last message, and the mesh.

use egui::{RichText, Ui, vec2};

use crate::widgets::panel_parts::{grouped, sentence};
use crate::widgets::theme::palette;
use crate::workspaces::commands::{CommandSet as _, FrameCommand};
use crate::workspaces::context::{Context, LogLine, status_sentence};
use crate::workspaces::news::EventKind;
use crate::workspaces::preferences::LengthUnit;
use crate::workspaces::workspace::{Standing, Workspace};

/// Draws the status bar.
///
/// `waiting` is a sentence on files whose drive does not answer, if there are any.
pub fn show(
    ui: &mut Ui,
    (workspaces, shown): (&mut [Box<dyn Workspace>], usize),
    waiting: Option<&str>,
    cx: &mut Context,
) {
    ui.horizontal(|ui| {
        if let Some(waiting) = waiting {
            if ui.small_button("Cancel").on_hover_text(FrameCommand::Cancel.hint(ui.ctx())).clicked() {
                cx.push(FrameCommand::Cancel);
            }
            let room = ui.available_width();
            status_sentence(ui, (0.5 * room).clamp(120.0, 460.0), waiting);
            ui.separator();
        }
        for (i, workspace) in workspaces.iter_mut().enumerate() {
            workspace.status(ui, cx, i == shown);
        }
        let here = &*workspaces[shown];
        message(ui, here, shown, cx);
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| facts(ui, here, cx));
    });
}

/// The last line of the log in workspace number `shown`, unless it tells of a problem that is over; and whether the
/// line is of other parameters than the present ones.
pub fn last_said<'a>(here: &dyn Workspace, shown: usize, cx: &'a Context) -> Option<(&'a LogLine, bool)> {
    let line = cx.log.iter().rev().find(|line| line.workspace == shown)?;
    let standing = here.standing(line);
    (standing != Standing::Over).then_some((line, standing == Standing::Stale))
}

fn message(ui: &mut Ui, here: &dyn Workspace, shown: usize, cx: &mut Context) {
    let room = (ui.available_width() - 260.0).max(60.0);
    let passing = cx.passing(shown).filter(|(line, _)| here.standing(line) != Standing::Over);
    if let Some((line, left)) = passing {
        ui.ctx().request_repaint_after(left);
        let label = egui::Label::new(RichText::new(&line.text).color(colour_of(ui, line.kind))).truncate();
        ui.allocate_ui(vec2(room, 18.0), |ui| ui.add(label)).inner.on_hover_text(&line.text);
        return;
    }
    let Some((line, is_stale)) = last_said(here, shown, cx) else {
        ui.label(RichText::new("Ready").color(palette(ui).faint));
        return;
    };
    let colour = if is_stale { palette(ui).faint } else { colour_of(ui, line.kind) };
    let label =
        egui::Label::new(RichText::new(sentence(&line.text)).color(colour)).truncate().sense(egui::Sense::click());
    let clicked = ui.allocate_ui(vec2(room, 18.0), |ui| ui.add(label)).inner;
    let hint = if is_stale { "Out of date; click to open the log" } else { "Click to open the log" };
    if clicked.on_hover_text(hint).clicked() {
        cx.push(FrameCommand::Log);
    }
}

fn facts(ui: &mut Ui, here: &dyn Workspace, cx: &Context) {
    let unit = match cx.preferences.length {
        LengthUnit::Millimetre => "mm",
        LengthUnit::Inch => "inch",
    };
    ui.label(RichText::new(unit).color(palette(ui).faint));
    if let Some(count) = here.triangles() {
        ui.separator();
        let count = grouped(count);
        ui.label(RichText::new(format!("{count} triangles")).color(palette(ui).faint));
    }
}

/// Colour of a kind of message.
pub fn colour_of(ui: &Ui, kind: EventKind) -> egui::Color32 {
    match kind {
        EventKind::Done => ui.visuals().text_color(),
        EventKind::Refused | EventKind::Failed => palette(ui).bad,
        EventKind::Cancelled => palette(ui).warning,
    }
}
