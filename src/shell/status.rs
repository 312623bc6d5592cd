//! The status bar: what is being worked on, how far it is, how long it will take; the last thing said; the mesh.

use egui::{ProgressBar, RichText, Ui, vec2};

use super::commands::Command;
use super::core::Core;
use super::workspace::Workspace;
use crate::widgets::theme::palette;
use crate::workspaces::blisk::panels::stepper::sentence;
use crate::workspaces::news::EventKind;
use task::Doing;

/// Draws it.
pub fn show(ui: &mut Ui, core: &mut Core) {
    ui.horizontal(|ui| {
        let of_workspace = match core.workspace {
            Workspace::Blisk => None,
            Workspace::Mold => core.mold.work.doing(),
            Workspace::Flank => core.flank.work.doing(),
        };
        let doing = core.opening.doing().or(of_workspace);
        if let Some(doing) = doing.cloned() {
            other(ui, &doing);
        } else if core.workspace != Workspace::Blisk {
        } else if let Some(running) = core.pipeline.running().cloned() {
            ui.label(RichText::new(format!("{}: {}", running.stage.name(), running.doing)));
            let bar = ProgressBar::new(running.fraction as f32).desired_width(140.0).desired_height(8.0);
            let response = ui.add(bar);
            let percent = format!("{} {:.0} %", running.doing, 100.0 * running.fraction);
            response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::ProgressIndicator, true, &percent));
            ui.label(RichText::new(format!("{:3.0} %", 100.0 * running.fraction)).monospace());
            if !running.message.is_empty() {
                ui.label(RichText::new(&running.message).color(palette(ui).faint));
            }
            let elapsed = running.since.elapsed().as_secs();
            let left = running.time_left().map(|t| format!(", about {} s left", t.as_secs() + 1)).unwrap_or_default();
            ui.label(RichText::new(format!("{elapsed} s{left}")).color(palette(ui).faint));
            let cancel = ui.small_button("Cancel").on_hover_text(Command::Cancel.hint(ui.ctx()));
            if cancel.clicked() {
                core.push(Command::Cancel);
            }
            ui.separator();
        }
        sizing(ui, core);
        message(ui, core);
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| facts(ui, core));
    });
}

/// Sizing goes on beside everything else, whichever step is open.
fn sizing(ui: &mut Ui, core: &mut Core) {
    let Some(doing) = core.tuning.sizing().map(str::to_owned) else { return };
    let found = core.tuning.sizes().0.len();
    ui.label(format!("Sizes: {doing}")).on_hover_text("The table grows in the step Electrode");
    ui.label(RichText::new(format!("{found} found")).color(palette(ui).faint));
    if ui.small_button("Stop").on_hover_text("Stop sizing; what was found stays").clicked() {
        core.tuning.stop_sizing();
    }
    ui.separator();
}

/// What is being done in another workspace.
fn other(ui: &mut Ui, doing: &Doing) {
    ui.label(format!("{}: {}", doing.what, doing.stage));
    ui.add(ProgressBar::new(doing.fraction as f32).desired_width(140.0).desired_height(8.0));
    let elapsed = doing.since.elapsed().as_secs();
    ui.label(RichText::new(format!("{elapsed} s")).color(palette(ui).faint));
    ui.separator();
}

fn message(ui: &mut Ui, core: &mut Core) {
    if let Some((text, left)) = core.passing() {
        ui.ctx().request_repaint_after(left);
        let room = (ui.available_width() - 260.0).max(60.0);
        let label = egui::Label::new(RichText::new(text).color(palette(ui).warning)).truncate();
        ui.allocate_ui(vec2(room, 18.0), |ui| ui.add(label)).inner.on_hover_text(text);
        return;
    }
    let Some((line, is_stale)) = core.last_said() else {
        ui.label(RichText::new("Ready").color(palette(ui).faint));
        return;
    };
    let colour = if is_stale { palette(ui).faint } else { colour_of(ui, line.kind) };
    let room = (ui.available_width() - 260.0).max(60.0);
    let label =
        egui::Label::new(RichText::new(sentence(&line.text)).color(colour)).truncate().sense(egui::Sense::click());
    let clicked = ui.allocate_ui(vec2(room, 18.0), |ui| ui.add(label)).inner;
    let hint = if is_stale { "Out of date; click to open the log" } else { "Click to open the log" };
    if clicked.on_hover_text(hint).clicked() {
        core.push(Command::Log);
    }
}

fn facts(ui: &mut Ui, core: &Core) {
    let unit = match core.preferences.length {
        super::preferences::LengthUnit::Millimetre => "mm",
        super::preferences::LengthUnit::Inch => "inch",
    };
    ui.label(RichText::new(unit).color(palette(ui).faint));
    let of_mold = core.mold.work.mold().map(|mold| mold.mesh.triangles.len());
    let of_part = core.pipeline.part().map(|part| part.mesh.triangles.len());
    let count = match core.workspace {
        Workspace::Blisk => of_part,
        Workspace::Mold => of_mold,
        Workspace::Flank => None,
    };
    if let Some(count) = count {
        ui.separator();
        let count = grouped(count);
        ui.label(RichText::new(format!("{count} triangles")).color(palette(ui).faint));
    }
}

/// A number with thin spaces between thousands.
pub fn grouped(n: usize) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

/// The colour of a kind of news.
pub fn colour_of(ui: &Ui, kind: EventKind) -> egui::Color32 {
    match kind {
        EventKind::Done => ui.visuals().text_color(),
        EventKind::Refused | EventKind::Failed => palette(ui).bad,
        EventKind::Cancelled => palette(ui).warning,
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn thousands_stand_apart() {
        assert_eq!(super::grouped(1_234_567), "1 234 567");
        assert_eq!(super::grouped(12), "12");
    }
}
